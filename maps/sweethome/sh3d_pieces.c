// sh3d_pieces.c - furniture, lamps, stairs and the models of doors: each a model scaled to its box and put in its
// place, as Sweet Home 3D shows it. What the program can do beyond that and this reader does not: parts of a model
// moved by hand (`transformation`).
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "maps/building/texture.h"
#include "maps/sweethome/sh3d_pieces.h"

static const unsigned BOX_COLOUR = 0xC8C4BC;  // sRGB, of a piece without model and colour
static const double THINNEST_MODEL = 0.001;   // model units: the program's smallest extent for pictures
static const double FLAT = 1e-9;              // model units: an extent below it stays flat
static const float PANE_ALPHA = 0.3f;         // of window panes whose material is not transparent itself
static const float INVISIBLE = 0.01f;         // alpha below which a face is not there at all
static const double WATTS = 10;               // radiant flux of a lamp of power 1
static const double DEFAULT_POWER = 0.5, DEFAULT_RADIUS = 0.0325;  // the program's own; metres
static const double MAX_STEP = 0.2;                                // metres, of a plain stair
static const double STAIR_REACH = 0.3;  // metres by which a stair may end below the floor it leads to
#define MAX_STEPS 200
#define MAX_FAN 256  // corners from which a face is cut into a fan, since cutting it well takes cubic time

static const char *const STAIR_WORDS[] = {"stair", "escalier", "trepp",   "scala", "escaler", "escada",
                                          "trap",  "schod",    "лестниц", "階段",  NULL};
static const char *const NO_STAIR_WORDS[] = {"trapez", "strap", "staircase rail", NULL};

static Piece read_piece(Sh3d *s, const XmlNode *node) {
    static const double UNTURNED[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    Piece p = {.node = node, .name = sh3d_text(node, "name")};
    p.at = vec2(sh3d_coordinate(s, node, "x", NAN), -sh3d_coordinate(s, node, "y", NAN));
    // Above the level, in a group too: its members hold places of their own.
    p.z = sh3d_level(s, node)->floor + sh3d_coordinate(s, node, "elevation", 0);
    p.width = sh3d_length(s, node, "width", NAN);
    p.depth = sh3d_length(s, node, "depth", NAN);
    p.height = sh3d_length(s, node, "height", NAN);
    p.angle = sh3d_angle(s, node, "angle");
    p.pitch = sh3d_number(s, node, "pitch", 0, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
    p.roll = sh3d_number(s, node, "roll", 0, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
    p.mirrored = sh3d_flag(node, "modelMirrored", false);
    // Version 7 and later have a number of flags, whose lowest bit is the one that versions before have alone.
    int flags = (int)sh3d_number(s, node, "modelFlags", 0, INT_MIN, INT_MAX);
    p.both_sides = sh3d_flag(node, "backFaceShown", false) || flags & 1;
    p.coloured = sh3d_colour(s, node, "color", &p.colour);
    memcpy(p.turn, UNTURNED, sizeof p.turn);
    const char *text = xml_get(node, "modelRotation");
    for (int i = 0; text && i < 9; i++) {
        char *stop;
        p.turn[i] = strtod(text, &stop);
        // Elements of a rotation matrix; a little more, since files round.
        if (stop == text || !(fabs(p.turn[i]) <= 1.01)) {
            sh3d_fail(s, node, "has modelRotation='%.60s' (nine numbers from -1 to 1 are allowed)",
                      xml_get(node, "modelRotation"));
            break;
        }
        text = stop;
    }
    return p;
}

// ---- materials

// The kind of a part of a model by the name of its group, as in the program's photos.
typedef enum PartKind { PART_PLAIN, PART_PANE, PART_MIRROR, PART_KINDS } PartKind;

static PartKind part_kind(const char *group) {
    if (strcasestr(group, "window_mirror")) return PART_MIRROR;
    return strcasestr(group, "window_pane") ? PART_PANE : PART_PLAIN;
}

// A mirror of silvered glass reflects this share.
static const float SILVERED = 0.88f;

// The piece's own statement about a material: by its key where it has one, else by its name.
static const XmlNode * override(const XmlNode *piece, const char *name) {
    for (const XmlNode *child = piece->first; child; child = child->next) {
        const char *key = xml_is(child, "material") ? xml_get(child, "key") : NULL;
        if (xml_is(child, "material") && strcmp(key ? key : sh3d_text(child, "name"), name) == 0)
            return child;
    }
    return NULL;
}

// The surface of a face: its material, and how the picture lies on the model.
typedef struct Paint {
    int material;    // -1: the face is not there
    bool pictured;   // `map` counts
    bool by_places;  // it maps texture coordinates (s, t, 0), else points of the model as in its file
    TextureMap map;
} Paint;

// Where a model has no texture coordinates, the program lays a picture on its front and, folded back, on its top: lengths count from
// the lower left corner of the model's box, which is as large as the piece.
static Sh3dFrame model_frame(const Piece *p, const ObjModel *m, const XmlNode *texture) {
    Vec3 low = m->box.min, size = vec3_sub(m->box.max, low);
    double sx = p->width / fmax(size.x, THINNEST_MODEL), sy = p->height / fmax(size.y, THINNEST_MODEL),
           sz = p->depth / fmax(size.z, THINNEST_MODEL);
    Sh3dFrame f = {.right = {sx, 0, 0}, .up = {0, sy, -sz}};
    if (!sh3d_flag(texture, "leftToRightOriented", true)) return f;
    f.right0 = -low.x * sx;
    f.up0 = m->box.max.z * sz - low.y * sy;
    return f;
}

// Lays a texture of the home on the piece. One for a single material follows the texture coordinates of the model's faces that have them.
static void lay_picture(Sh3d *s, const Piece *p, const ObjModel *m, const XmlNode *texture, bool by_places,
                        Material *material, Paint *paint) {
    Sh3dFrame f = model_frame(p, m, texture);
    if (by_places) f = (Sh3dFrame){.right = {1, 0, 0}, .up = {0, 1, 0}, .unsized = true};
    texture_put(s->b, sh3d_picture(s, texture), material);
    paint->by_places = by_places;
    paint->pictured = sh3d_map(s, texture, &f, &paint->map);
}

// The model's own picture; the program lays it by the model's x and y where it has no texture coordinates.
static void lay_own(const Sh3d *s, const ObjMaterial *own, bool by_places, Material *material, Paint *paint) {
    texture_put(s->b, own->texture, material);
    paint->by_places = by_places;
    paint->pictured = true;
    paint->map = (TextureMap){
        .u = {own->scale.x, 0, 0}, .v = {0, -own->scale.y, 0}, .u0 = own->offset.x, .v0 = 1 - own->offset.y};
}

static void lay_colour(Material *material, Paint *paint, unsigned rgb) {
    paint->pictured = false;
    material->texture = 0;
    material->reflectance = maps_colour(rgb);
}

// A colour of the piece goes over all but its panes; else a texture of the piece; else what it states of single
// materials; else its materials' own colours. Likewise its shininess, which counts where it states none of single
// materials. A picture that replaces another one takes its holes along.
static Paint piece_paint(Sh3d *s, const Piece *p, const ObjModel *model, const ObjMaterial *m, PartKind kind,
                         bool by_places, bool box) {
    bool pane = kind == PART_PANE;
    Paint paint = {0};
    Material out = {.name = m->name, .reflectance = m->colour, .alpha = m->alpha};
    double shininess = box ? 0 : (double)m->shininess;
    if (box) out.reflectance = maps_colour(BOX_COLOUR);
    if (pane && out.alpha >= 1) out.alpha = PANE_ALPHA;
    unsigned rgb;
    const XmlNode *own = override(p->node, m->name), *whole = sh3d_texture_of(s, p->node, ""),
                  *single = own ? sh3d_texture_of(s, own, "") : NULL;
    bool stated = false, known = m->known || box, single_coloured = own && sh3d_colour(s, own, "color", &rgb);
    for (const XmlNode *child = p->node->first; child; child = child->next)
        stated = stated || xml_is(child, "material");
    bool painted = p->coloured || whole;
    if (painted && !pane) {
        known = true;
        if (p->coloured)
            lay_colour(&out, &paint, p->colour);
        else
            lay_picture(s, p, model, whole, false, &out, &paint);
    } else if (!painted && single_coloured) {
        known = true;
        lay_colour(&out, &paint, rgb);
    } else if (!painted && single) {
        known = true;
        lay_picture(s, p, model, single, by_places, &out, &paint);
    } else if (m->texture > 0) {
        lay_own(s, m, by_places, &out, &paint);
    }
    const XmlNode *speaker = painted || !stated ? p->node : own;
    if (speaker) shininess = sh3d_shininess(s, speaker, "shininess", shininess);
    // Panes are glass by their alpha.
    if (out.alpha >= 1) out.gloss = (float)shininess;
    if (kind == PART_MIRROR) material_make_mirror(&out, SILVERED);
    if (!known) building_tally(&s->unknown_materials, m->name, vec3(p->at.x, p->at.y, p->z));
    if (!paint.pictured) out.texture = 0;
    paint.material = out.alpha < INVISIBLE ? -1 : building_add_material(s->arena, s->b, out);
    return paint;
}

// Places in the picture for the corners of a face; false where it has none.
static bool find_places(const ObjModel *m, const ObjFace *f, const Paint *paint, Vec2 *out) {
    if (!paint->pictured || (paint->by_places && !obj_places(m, f, out))) return false;
    for (int i = 0; i < f->corner_count; i++) {
        Vec3 at =
            paint->by_places ? vec3(out[i].x, out[i].y, 0) : m->vertices[m->corners[f->first_corner + i]];
        out[i] = vec2(vec3_dot(paint->map.u, at) + paint->map.u0, vec3_dot(paint->map.v, at) + paint->map.v0);
    }
    return true;
}

// ---- placing

static Vec3 times(const double m[9], Vec3 v) {
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z);
}

static Box turned_box(Box box, const double m[9]) {
    Box out = box_empty();
    for (int i = 0; i < 8; i++)
        out = box_add(out, times(m, vec3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                         i & 4 ? box.max.z : box.min.z)));
    return out;
}

static double scaled(double v, double low, double high, double size) {
    return high - low > FLAT ? ((v - low) / (high - low) - 0.5) * size : 0;
}

// All vertices of a model in building space. The model is turned, its box fitted to the piece's, mirrored, tilted
// about its centre (so that its new box stands on the piece's foot), turned about z, and put in place.
static Vec3 *place(Sh3d *s, const Piece *p, const ObjModel *m) {
    Vec3 *out = ARENA_ARRAY(s->arena, Vec3, m->vertex_count);
    Box turned = box_empty(), tilted = box_empty();
    for (int i = 0; i < m->corner_count; i++)
        turned = box_add(turned, times(p->turn, m->vertices[m->corners[i]]));
    // The plain stair fills only part of its box.
    if (m->fixed_box) turned = turned_box(m->box, p->turn);
    double c = cos(-p->pitch), sn = sin(-p->pitch), cr = cos(-p->roll), sr = sin(-p->roll);
    bool tilt = p->pitch != 0 || p->roll != 0;
    for (int i = 0; i < m->vertex_count; i++) {
        Vec3 v = times(p->turn, m->vertices[i]);
        v = vec3(scaled(v.x, turned.min.x, turned.max.x, p->mirrored ? -p->width : p->width),
                 scaled(v.y, turned.min.y, turned.max.y, p->height),
                 scaled(v.z, turned.min.z, turned.max.z, p->depth));
        // The program tilts about one axis only.
        if (p->pitch != 0)
            v = vec3(v.x, c * v.y - sn * v.z, sn * v.y + c * v.z);
        else if (p->roll != 0)
            v = vec3(cr * v.x - sr * v.y, sr * v.x + cr * v.y, v.z);
        out[i] = v;
    }
    for (int i = 0; tilt && i < m->corner_count; i++) tilted = box_add(tilted, out[m->corners[i]]);
    Vec3 shift = tilt ? vec3_scale(vec3_add(tilted.min, tilted.max), -0.5) : vec3(0, 0, 0);
    double half = tilt ? (tilted.max.y - tilted.min.y) / 2 : p->height / 2;
    double ca = cos(p->angle), sa = sin(p->angle);
    for (int i = 0; i < m->vertex_count; i++) {
        Vec3 v = vec3_add(out[i], shift);
        out[i] = vec3(p->at.x + ca * v.x + sa * v.z, p->at.y + sa * v.x - ca * v.z, p->z + half + v.y);
    }
    return out;
}

// Adds a face of `count` corners, MAX_FAN at most. Where the piece shows its backs they are faces of their own. `places`
// may be NULL.
static void add_model_face(Sh3d *s, const Piece *p, const Vec3 *placed, const int *corner, const Vec2 *places,
                           int count, int material) {
    int sides = p->both_sides ? 2 : 1;
    for (int side = 0; side < sides; side++) {
        bool turned = p->mirrored != side;
        Vec3 few[MAX_FAN];
        Vec2 at[MAX_FAN];
        for (int i = 0; i < count; i++) {
            int to = turned ? count - 1 - i : i;
            few[to] = placed[corner[i]];
            if (places) at[to] = places[i];
        }
        building_add_textured(s->arena, s->b, few, places ? at : NULL, count, material);
    }
}

// The faces whose part is `which`; `part` [face_count], NULL: all.
static void add_faces(Sh3d *s, const Piece *p, const ObjModel *m, const Vec3 *placed, const int *part,
                      int which, bool box) {
    const int kinds = 2 * PART_KINDS;
    Paint *paints = ARENA_ARRAY(s->arena, Paint, kinds * m->material_count);
    int most = 0;
    for (int i = 0; i < kinds * m->material_count; i++) paints[i].material = -2;
    for (int i = 0; i < m->face_count; i++)
        most = m->faces[i].corner_count > most ? m->faces[i].corner_count : most;
    Vec2 *at = ARENA_ARRAY(s->arena, Vec2, most);
    int group = -1;
    PartKind kind = PART_PLAIN;
    for (int i = 0; i < m->face_count; i++) {
        const ObjFace *f = &m->faces[i];
        if (part && part[i] != which) continue;
        // The faces of a group mostly follow one another.
        if (f->group != group) kind = part_kind(m->groups[f->group]);
        group = f->group;
        bool by_places = obj_places(m, f, at);
        Paint *paint = &paints[kinds * f->material + 2 * (int)kind + by_places];
        if (paint->material == -2)
            *paint = piece_paint(s, p, m, &m->materials[f->material], kind, by_places, box);
        if (paint->material < 0) continue;
        const int *corner = m->corners + f->first_corner;
        const Vec2 *places = find_places(m, f, paint, at) ? at : NULL;
        if (f->corner_count <= MAX_FAN) {
            add_model_face(s, p, placed, corner, places, f->corner_count, paint->material);
            continue;
        }
        for (int k = 1; k + 1 < f->corner_count; k++) {
            const int three[3] = {corner[0], corner[k], corner[k + 1]};
            Vec2 of_three[3] = {at[0], at[k], at[k + 1]};
            add_model_face(s, p, placed, three, places ? of_three : NULL, 3, paint->material);
        }
    }
}

static bool room_for(const Sh3d *s, const Piece *p, const ObjModel *m) {
    // Pieces beyond become boxes. Real homes have below 200,000.
    return s->b->polygon_count <=
           building_polygons_allowed(s->b->file_size) - (int64_t)m->corner_count * (p->both_sides ? 2 : 1);
}

// An object that turned out empty goes again.
static void finish_object(Sh3d *s, const Piece *p) {
    Building *b = s->b;
    if (b->objects[b->object_count - 1].polygon_count == 0)
        b->object_count--;
    else
        building_set_proxy(s->arena, b, p->angle);
}

// ---- plain stairs

static void add_box_quad(Arena *arena, ObjModel *m, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    Vec3 corner[4] = {a, b, c, d};
    *ARENA_PUSH(arena, m->faces, m->face_count, m->face_capacity) = (ObjFace){m->corner_count, 4, 0, 0, 0};
    for (int i = 0; i < 4; i++) {
        *ARENA_PUSH(arena, m->corners, m->corner_count, m->corner_capacity) = m->vertex_count;
        *ARENA_PUSH(arena, m->vertices, m->vertex_count, m->vertex_capacity) = corner[i];
    }
}

// A straight flight in the unit box, rising from the front (z = 1) to the back (z = 0) as the program's own stairs
// do, solid below, `steps` treads the last of which lies at height `rise`.
static ObjModel stair_model(Arena *arena, int steps, double rise) {
    ObjModel m = obj_box(arena);
    m.face_count = m.corner_count = m.vertex_count = 0;
    for (int i = 0; i < steps; i++) {
        double low = rise * i / steps, high = rise * (i + 1) / steps;
        double front = 1 - (double)i / steps, back = 1 - (i + 1.0) / steps;
        add_box_quad(arena, &m, vec3(0, low, front), vec3(1, low, front), vec3(1, high, front),
                     vec3(0, high, front));
        add_box_quad(arena, &m, vec3(0, high, front), vec3(1, high, front), vec3(1, high, back),
                     vec3(0, high, back));
        add_box_quad(arena, &m, vec3(0, 0, back), vec3(0, 0, front), vec3(0, high, front),
                     vec3(0, high, back));
        add_box_quad(arena, &m, vec3(1, 0, front), vec3(1, 0, back), vec3(1, high, back),
                     vec3(1, high, front));
    }
    add_box_quad(arena, &m, vec3(1, 0, 0), vec3(0, 0, 0), vec3(0, rise, 0), vec3(1, rise, 0));
    return m;
}

// Whether a storey's floor lies above the stair's foot and within reach of its top.
static bool leads_to(const Sh3d *s, const Piece *p, int storey) {
    double floor = s->b->storeys[storey].floor;
    return floor > p->z + SH3D_SAME_HEIGHT && floor <= p->z + p->height + STAIR_REACH;
}

// The lowest of these storeys, or -1.
static int storey_above(const Sh3d *s, const Piece *p) {
    for (int i = 0; i < s->b->storey_count; i++)
        if (leads_to(s, p, i)) return i;
    return -1;
}

// The part of a stair above the floor that it leads to is railing: the flight itself ends at that floor.
static ObjModel plain_stair(Sh3d *s, const Piece *p) {
    int above = storey_above(s, p);
    double rise = p->height;
    if (above >= 0) rise = fmin(rise, s->b->storeys[above].floor - p->z);
    int steps = (int)fmin(fmax(ceil(rise / MAX_STEP), 1), MAX_STEPS);
    return stair_model(s->arena, steps, p->height > 0 ? rise / p->height : 1);
}

// Between levels a few steps apart the stair may lead to any: the floors of all are cut.
static void add_cutout(Sh3d *s, const Piece *p) {
    const char *path = xml_get(p->node, "staircaseCutOutShape");
    if (!path || storey_above(s, p) < 0) return;
    Vec2 shape[SH3D_MAX_SHAPE] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    int count = sh3d_shape(path, shape, SH3D_MAX_SHAPE);
    if (count < 3) {
        building_tally(&s->bad_shapes, p->name, vec3(p->at.x, p->at.y, p->z));
        memcpy(shape, (Vec2[]){{0, 0}, {0, 1}, {1, 1}, {1, 0}}, 4 * sizeof(Vec2));
        count = 4;
    }
    double c = cos(p->angle), sn = sin(p->angle);
    int first = s->sketch->point_count;
    for (int i = 0; i < count; i++) {
        // The square's y counts from the back to the front.
        double x = (shape[i].x - 0.5) * (p->mirrored ? -p->width : p->width),
               y = (0.5 - shape[i].y) * p->depth;
        sh3d_add_point(s, vec2(p->at.x + c * x - sn * y, p->at.y + sn * x + c * y), -1);
    }
    for (int i = 0; i < s->b->storey_count; i++) {
        if (!leads_to(s, p, i)) continue;
        SketchCutout cutout = {i, first, count, sh3d_place(s, p->node, "stair")};
        *ARENA_PUSH(s->arena, s->sketch->cutouts, s->sketch->cutout_count, s->sketch->cutout_capacity) =
            cutout;
    }
}

// ---- pieces

static void add_furniture(Sh3d *s, const Piece *p, ObjectKind kind, bool flight) {
    const ObjModel *m = sh3d_model(s, p->node);
    ObjModel stand_in;
    bool box = !m || !room_for(s, p, m);
    if (box) {
        stand_in = flight ? plain_stair(s, p) : obj_box(s->arena);
        m = &stand_in;
        building_tally(&s->missing_models, p->name, vec3(p->at.x, p->at.y, p->z));
    }
    building_add_object(s->arena, s->b, kind, p->name);
    add_faces(s, p, m, place(s, p, m), NULL, 0, box);
    finish_object(s, p);
}

// ---- models of doors, lamps

// Places the model of the door or window that the sketch has last: its frame, and its leaves where it is a door.
static void add_opening_model(Sh3d *s, const XmlNode *node) {
    int opening = s->sketch->opening_count - 1;
    const char *name = s->sketch->openings[opening].name;
    Piece p = read_piece(s, node);
    const ObjModel *m = sh3d_model(s, node);
    if (s->failed) return;
    if (!m || !room_for(s, &p, m)) {
        // No box: it would fill the hole.
        building_tally(&s->missing_frames, name, vec3(p.at.x, p.at.y, p.z));
        return;
    }
    const Vec3 *placed = place(s, &p, m);
    SketchOpening *o = &s->sketch->openings[opening];
    Leaves leaves = {NULL, {0}};
    if (o->kind == OPENING_DOOR) leaves = sh3d_find_leaves(s, &p, m, placed, o);
    int frame = building_add_object(s->arena, s->b, OBJECT_FRAME, name);
    s->b->objects[frame].opening = opening;
    add_faces(s, &p, m, placed, leaves.part, FRAME, false);
    finish_object(s, &p);
    for (int leaf = 0; leaf < o->leaf_count; leaf++) {
        int object = building_add_object(s->arena, s->b, OBJECT_LEAF, name);
        s->b->objects[object].opening = opening;
        s->b->objects[object].leaf = leaf;
        add_faces(s, &p, m, sh3d_close_leaf(s, m, placed, &leaves, leaf, o), leaves.part, leaf, false);
        finish_object(s, &p);
    }
}

static Rgb lamp_flux(Sh3d *s, const XmlNode *source, double watts) {
    unsigned rgb = 0xFFFFFF;
    sh3d_colour(s, source, "color", &rgb);
    Rgb c = maps_colour(rgb);
    double sum = (double)c.r + (double)c.g + (double)c.b;
    // A black lamp has no proportion to go by: white.
    if (sum <= 0) c = (Rgb){1, 1, 1}, sum = 3;
    double share = watts / sum;
    return (Rgb){(float)(c.r * share), (float)(c.g * share), (float)(c.b * share)};
}

// Places in shares of the lamp's box: x from its left, y from its front, z from its foot.
static void add_lights(Sh3d *s, const Piece *p, int object) {
    double power = sh3d_number(s, p->node, "power", DEFAULT_POWER, 0, 1e6);
    int sources = 0;
    for (const XmlNode *child = p->node->first; child; child = child->next)
        sources += xml_is(child, "lightSource");
    if (sources == 0) building_tally(&s->dark_lights, p->name, vec3(p->at.x, p->at.y, p->z));
    double c = cos(p->angle), sn = sin(p->angle);
    for (const XmlNode *child = p->node->first; child && !s->failed; child = child->next) {
        if (!xml_is(child, "lightSource")) continue;
        double x = (sh3d_number(s, child, "x", NAN, -100, 100) - 0.5) * (p->mirrored ? -p->width : p->width);
        double y = (sh3d_number(s, child, "y", NAN, -100, 100) - 0.5) * p->depth;
        double z = sh3d_number(s, child, "z", NAN, -100, 100) * p->height;
        double diameter = sh3d_number(s, child, "diameter", 0, 0, 100);
        Light light = {.name = p->name, .object = object, .turn = p->angle};
        light.position = vec3(p->at.x + c * x - sn * y, p->at.y + sn * x + c * y, p->z + z);
        light.radius = diameter > 0 ? diameter * p->width / 2 : DEFAULT_RADIUS;
        light.flux = lamp_flux(s, child, WATTS * power / sources);
        *ARENA_PUSH(s->arena, s->b->lights, s->b->light_count, s->b->light_capacity) = light;
    }
}

static bool is_stair(const XmlNode *node) {
    return xml_get(node, "staircaseCutOutShape") ||
           (sh3d_has_word(node, STAIR_WORDS) && !sh3d_has_word(node, NO_STAIR_WORDS));
}

static void read_furniture(Sh3d *s, const XmlNode *node, bool of_stair) {
    Piece p = read_piece(s, node);
    if (s->failed) return;
    bool lamp = xml_is(node, "light");
    int object = s->b->object_count;
    ObjectKind kind = lamp ? OBJECT_LAMP : of_stair || is_stair(node) ? OBJECT_STAIR : OBJECT_FURNITURE;
    add_furniture(s, &p, kind, kind == OBJECT_STAIR && !of_stair);
    if (kind == OBJECT_STAIR) add_cutout(s, &p);
    if (lamp) add_lights(s, &p, s->b->object_count > object ? object : -1);
}

// In a group called a stair each member is a step. The depth of groups is bounded by XML_MAX_DEPTH.
static void read_children(Sh3d *s, const XmlNode *parent, bool of_stair) {
    for (const XmlNode *node = parent->first; node && !s->failed; node = node->next) {
        bool piece = xml_is(node, "pieceOfFurniture") || xml_is(node, "light") || xml_is(node, "shelfUnit");
        // Before version 1.7 doors were furniture with a mark.
        bool group = xml_is(node, "furnitureGroup"),
             opening = xml_is(node, "doorOrWindow") || (piece && sh3d_flag(node, "doorOrWindow", false));
        if (!(opening || group || piece) || !sh3d_flag(node, "visible", true)) continue;
        if (group)
            read_children(s, node, of_stair || is_stair(node));
        else if (opening) {
            if (sh3d_read_opening(s, node)) add_opening_model(s, node);
        } else
            read_furniture(s, node, of_stair);
    }
}

void sh3d_read_pieces(Sh3d *s) { read_children(s, s->home, false); }
