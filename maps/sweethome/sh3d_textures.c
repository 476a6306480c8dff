// sh3d_textures.c - pictures on surfaces, as Sweet Home 3D lays them: from a surface's lengths along a picture, through the
// picture's offset, angle, scale and size, to places in the picture.
//
// Source: the behaviour of the program, versions 5.3 to 7.0.2. A picture of width w, height h, scale k, angle a and offset (x, y)
// shows at lengths (r, t) the place ((r, t) - k (w x, h y)) turned by a and divided by k w, k h, from its lower left corner.
#include <string.h>

#include "maps/building/texture.h"
#include "maps/sweethome/sh3d.h"

static const double UNSIZED = 100;     // cm, sides of a picture that states none
static const double DENSEST = 1e4;     // repetitions a metre: beyond, only its mean could be seen
static const double SCALES = 1e6;      // of a scale, and of its inverse
static const double OFFSETS = 1e6;     // repetitions
static const double SMALLEST = 0.001;  // metres, of an area over which a picture is stretched

// The most surfaces that pictures lie on, each in its own way: a home of 70 textures has below 1,000. Maps and materials are compared one
// by one.
enum { MOST_MAPS = 16384 };

// An image of the file, decoded once.
typedef struct Sh3dPicture {
    const char *name;
    int texture;  // 0: not usable
} Sh3dPicture;

int sh3d_picture(Sh3d *s, const XmlNode *node) {
    const char *name = xml_get(node, "image");
    for (int i = 0; name && i < s->picture_count; i++)
        if (strcmp(s->pictures[i].name, name) == 0) return s->pictures[i].texture;
    Sh3dPicture picture = {.name = name};
    Bytes image;
    Error ignored;
    if (name && s->archive && archive_has(s->archive, name) &&
        archive_read(s->archive, name, ARCHIVE_MAX_ENTRY, s->arena, &image, &ignored))
        picture.texture = texture_add(s->arena, s->b, sh3d_text(node, "name"), image, &s->pixels);
    if (picture.texture == 0) building_tally(&s->missing_textures, sh3d_text(node, "name"), vec3(0, 0, 0));
    if (name) *ARENA_PUSH(s->arena, s->pictures, s->picture_count, s->picture_capacity) = picture;
    return picture.texture;
}

const XmlNode *sh3d_texture_of(Sh3d *s, const XmlNode *node, const char *surface) {
    const char *name = *surface ? arena_format(s->arena, "%sTexture", surface) : "";
    for (const XmlNode *child = node->first; child; child = child->next)
        if (xml_is(child, "texture") && strcmp(sh3d_text(child, "attribute"), name) == 0 &&
            sh3d_picture(s, child) > 0)
            return child;
    return NULL;
}

static bool finish_map(TextureMap map, TextureMap *out) {
    *out = map;
    double density = fmax(vec3_length(map.u), vec3_length(map.v));
    return density <= DENSEST && isfinite(map.u0) && isfinite(map.v0);
}

// A map from lengths in the frame: u = dot(u, (right, up)) + u0, and v upwards.
static TextureMap map_of(const Sh3dFrame *f, Vec2 u, double u0, Vec2 v, double v0) {
    TextureMap map = {vec3_add(vec3_scale(f->right, u.x), vec3_scale(f->up, u.y)),
                      vec3_add(vec3_scale(f->right, v.x), vec3_scale(f->up, v.y)),
                      u.x * f->right0 + u.y * f->up0 + u0, v.x * f->right0 + v.y * f->up0 + v0};
    // Pictures count from the top.
    map.v = vec3_scale(map.v, -1);
    map.v0 = 1 - map.v0;
    return map;
}

bool sh3d_map(Sh3d *s, const XmlNode *texture, const Sh3dFrame *frame, TextureMap *out) {
    Sh3dFrame f = *frame;
    double width = sh3d_number(s, texture, "width", -1, -1, SH3D_MAX_LENGTH),
           height = sh3d_number(s, texture, "height", -1, -1, SH3D_MAX_LENGTH);
    if (width < 0 || height < 0) width = height = UNSIZED;
    double scale = sh3d_number(s, texture, "scale", 1, -SCALES, SCALES),
           angle = sh3d_number(s, texture, "angle", 0, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE),
           x = sh3d_number(s, texture, "xOffset", 0, -OFFSETS, OFFSETS),
           y = sh3d_number(s, texture, "yOffset", 0, -OFFSETS, OFFSETS);
    if (f.left_side && sh3d_flag(texture, "leftToRightOriented", true)) {
        f.right = vec3_scale(f.right, -1);
        f.right0 = -f.right0;
    }
    Vec2 area = vec2_sub(f.fit_high, f.fit_low);
    if (f.can_fit && sh3d_flag(texture, "fittingArea", false) && area.x > SMALLEST && area.y > SMALLEST)
        return finish_map(map_of(&f, vec2(1 / area.x, 0), -f.fit_low.x / area.x, vec2(0, 1 / area.y),
                                 -f.fit_low.y / area.y),
                          out);
    if (f.unsized) width = height = 1 / SH3D_CM;
    double w = SH3D_CM * width * scale, h = SH3D_CM * height * scale, c = cos(angle), sn = sin(angle);
    if (w == 0 || h == 0) return false;
    Vec2 u = vec2(c / w, -sn / w), v = vec2(sn / h, c / h), from = vec2(x * w, y * h);
    return finish_map(map_of(&f, u, -vec2_dot(u, from), v, -vec2_dot(v, from)), out);
}

int sh3d_push_material(Sh3d *s, Material material) {
    Building *b = s->b;
    material.name = arena_string(s->arena, material.name ? material.name : "");
    *ARENA_PUSH(s->arena, b->materials, b->material_count, b->material_capacity) = material;
    return b->material_count - 1;
}

// Surfaces of one frame, as the floors of a home are, share their map.
static int find_map(Sh3d *s, TextureMap map) {
    for (int i = 1; i < s->b->texture_map_count; i++)
        if (memcmp(&s->b->texture_maps[i], &map, sizeof map) == 0) return i;
    return building_add_texture_map(s->arena, s->b, map);
}

int sh3d_material(Sh3d *s, const XmlNode *node, const char *surface, int missing, const Sh3dFrame *frame) {
    Material out = s->b->materials[missing];
    const XmlNode *texture = sh3d_texture_of(s, node, surface);
    unsigned rgb;
    if (texture) {
        TextureMap map;
        out.name = sh3d_text(texture, "name");
        texture_put(s->b, sh3d_picture(s, texture), &out);
        // Walls, floors and ceilings bound rooms, whatever is cut out of their pictures.
        out.alpha = 1;
        if (s->b->texture_map_count >= MOST_MAPS)
            building_tally(&s->plain_pictures, out.name, vec3(0, 0, 0));
        else if (frame && sh3d_map(s, texture, frame, &map))
            out.texture_map = find_map(s, map);
        if (out.texture_map == 0) out.texture = 0;
    } else if (sh3d_colour(s, node, *surface ? arena_format(s->arena, "%sColor", surface) : "color", &rgb)) {
        out.name = "paint";
        out.reflectance = maps_colour(rgb);
        out.texture = out.texture_map = 0;
    }
    const char *shininess = *surface ? arena_format(s->arena, "%sShininess", surface) : "shininess";
    out.gloss = (float)sh3d_shininess(s, node, shininess, 0);
    return building_add_material(s->arena, s->b, out);
}
