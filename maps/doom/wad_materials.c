// wad_materials.c - materials of a Doom map: textures as sectors light them, and how they lie on walls, floors and ceilings.
//
// One texel is one map unit (id Software 1993). Flats lie on the grid of the world, their rows from north to south. A wall's texture
// begins at its line's left end as seen from its side, moved by the side's offsets. Its rows hang from the ceiling, or stand on the floor:
// of a wall with nothing behind it they hang, unless its line is "lower unpegged"; above an opening they stand on the opening's head,
// unless "upper unpegged"; below one they hang from its sill, unless "lower unpegged", then from the ceiling.
#include <stdio.h>
#include <stdlib.h>

#include "maps/building/texture.h"
#include "maps/doom/wad.h"

// Light is dimmed in so many steps, so that there are few materials of one texture.
enum { LIGHT_STEPS = 8, BRIGHTEST = 256 };
// The dimmest and the brightest sector reflect these shares of the colour's own reflectance.
static const double DIMMEST = 0.35, FULL = 1.0;
static const char SKY_FLAT[] = "F_SKY1";
enum { SKY_COLOUR = 0xA8CCF0 };
enum { MATERIAL_SLOTS = 1 << 16 };  // of the hash table; materials beyond half of it share the first
enum { UPPER_UNPEGGED = 8, LOWER_UNPEGGED = 16 };  // flags of lines

static bool is_sky(const char *flat) { return strcmp(flat, SKY_FLAT) == 0; }

// A steady colour for a texture that the file lacks: greyish, as most surfaces of such maps are.
static Rgb colour_of(const char *name, double light) {
    uint64_t hash = file_hash(name, strlen(name), 0);
    float channel[3];
    double grey = 0.25 + 0.35 * (double)(hash >> 8 & 255) / 255;
    for (int i = 0; i < 3; i++) {
        double tint = 0.75 + 0.5 * (double)(hash >> (16 + 8 * i) & 255) / 255;
        channel[i] = (float)(light * grey * tint);
    }
    return (Rgb){channel[0], channel[1], channel[2]};
}

static int light_step(const WadMap *map, int sector) {
    int light = map->sectors[sector].light;
    return (light < 0 ? 0 : light >= BRIGHTEST ? BRIGHTEST - 1 : light) * LIGHT_STEPS / BRIGHTEST;
}

static bool same_map(const TextureMap *a, const TextureMap *b) {
    return vec3_equal(a->u, b->u) && vec3_equal(a->v, b->v) && a->u0 == b->u0 && a->v0 == b->v0;
}

// The material with this name and lie of its texture; its colour is that of `like` if it is new.
static int add_material(WadBuilder *w, Material like, const TextureMap *lie) {
    Building *b = w->building;
    uint64_t hash = file_hash(like.name, strlen(like.name), 0);
    if (like.texture) hash = file_hash(lie, sizeof *lie, hash);
    size_t slot = (size_t)hash % MATERIAL_SLOTS;
    for (; w->materials[slot] >= 0; slot = (slot + 1) % MATERIAL_SLOTS) {
        const Material *m = &b->materials[w->materials[slot]];
        bool lies = like.texture == 0 ? m->texture_map == 0
                                      : m->texture_map > 0 && same_map(&b->texture_maps[m->texture_map], lie);
        if (strcmp(m->name, like.name) == 0 && lies) return w->materials[slot];
    }
    if (b->material_count >= MATERIAL_SLOTS / 2) return 0;
    like.name = arena_string(w->arena, like.name);
    if (like.texture) like.texture_map = building_add_texture_map(w->arena, b, *lie);
    *ARENA_PUSH(w->arena, b->materials, b->material_count, b->material_capacity) = like;
    return w->materials[slot] = b->material_count - 1;
}

// A texture as it is lit in a sector. `lie` has texels for its unit, for textures of any size. The sky is the same everywhere; it is
// drawn, since it hides the space beyond: other courts, as high as they like, are not seen over a wall.
static int lit_material(WadBuilder *w, const char *texture, bool flat, int sector, TextureMap lie) {
    Building *b = w->building;
    if (is_sky(texture)) {
        Rgb colour = b->sky_texture ? b->textures[b->sky_texture].mean : maps_colour(SKY_COLOUR);
        return add_material(w, (Material){.name = "sky", .reflectance = colour, .alpha = 1}, NULL);
    }
    int step = light_step(w->map, sector), width = 1, height = 1;
    double light = DIMMEST + (FULL - DIMMEST) * step / (LIGHT_STEPS - 1);
    char name[32];
    snprintf(name, sizeof name, "%s light %d", !*texture || strcmp(texture, "-") == 0 ? "bare" : texture,
             step);
    Material m = {.name = name, .alpha = 1, .reflectance = colour_of(texture, light)};
    m.texture = wad_texture(w->pictures, texture, flat, &width, &height);
    if (m.texture) {
        Rgb mean = b->textures[m.texture].mean;
        float share = (float)light;
        m.reflectance = (Rgb){share * mean.r, share * mean.g, share * mean.b};
        lie.u = vec3_scale(lie.u, 1.0 / width), lie.u0 /= width;
        lie.v = vec3_scale(lie.v, 1.0 / height), lie.v0 /= height;
    }
    return add_material(w, m, &lie);
}

int wad_level_material(WadBuilder *w, const char *flat, int sector) {
    static const double TEXEL = 1 / WAD_METRE;
    return lit_material(w, flat, true, sector, (TextureMap){{TEXEL, 0, 0}, {0, -TEXEL, 0}, 0, 0});
}

// How a texture lies on a side of a line: columns from the line's left end, rows downwards from height `top`, map units.
static TextureMap lie_on_wall(const WadMap *map, const WadLine *line, int facing, double top) {
    const WadSide *side = &map->sides[line->side[facing]];
    WadPoint from = map->vertices[line->v[facing]], to = map->vertices[line->v[1 - facing]];
    Vec2 along = vec2((double)(to.x - from.x), (double)(to.y - from.y));
    along = vec2_scale(along, 1 / vec2_length(along));
    double start = along.x * (double)from.x + along.y * (double)from.y;
    return (TextureMap){{along.x / WAD_METRE, along.y / WAD_METRE, 0},
                        {0, 0, -1 / WAD_METRE},
                        side->offset[0] - start,
                        side->offset[1] + top};
}

// The height of the texture, map units; 0 of one that the file lacks.
static int height_of(WadBuilder *w, const char *texture) {
    int width, height = 0;
    return wad_texture(w->pictures, texture, false, &width, &height) ? height : 0;
}

int wad_wall_material(WadBuilder *w, const WadEdge *edge, int sector, double along, bool above) {
    const WadMap *map = w->map;
    int facing, i = wad_line_at(map, w->pieces, edge, along, &facing);
    if (i < 0) return wad_level_material(w, map->sectors[sector].floor_flat, sector);
    const WadLine *line = &map->lines[i];
    const WadSide *side = &map->sides[line->side[facing]];
    const WadSector *here = &map->sectors[sector];
    const char *texture = side->middle;
    double top = here->ceiling;
    if (line->sector[1 - facing] < 0) {
        if (line->flags & LOWER_UNPEGGED) top = here->floor + height_of(w, texture);
        return lit_material(w, texture, false, sector, lie_on_wall(map, line, facing, top));
    }
    const WadSector *there = &map->sectors[line->sector[1 - facing]];
    bool open_sky = is_sky(here->ceiling_flat) && is_sky(there->ceiling_flat);
    if (above) {
        // Between two ceilings of sky there is sky.
        texture = open_sky ? SKY_FLAT : side->upper;
        if (!open_sky && !(line->flags & UPPER_UNPEGGED)) top = there->ceiling + height_of(w, texture);
    } else {
        texture = side->lower;
        if (!(line->flags & LOWER_UNPEGGED))
            top = there->floor;
        else if (open_sky)
            top = there->ceiling;
    }
    return lit_material(w, texture, false, sector, lie_on_wall(map, line, facing, top));
}

// Whether a wall with no opening in it shows what lies above one: the higher of both.
bool wad_wall_is_upper(const WadBuilder *w, const WadEdge *edge, int sector, double along) {
    const WadMap *map = w->map;
    int facing, i = wad_line_at(map, w->pieces, edge, along, &facing);
    int beyond = i < 0 ? -1 : map->lines[i].sector[1 - facing];
    if (beyond < 0) return false;
    const WadSector *here = &map->sectors[sector], *there = &map->sectors[beyond];
    return here->ceiling - there->ceiling >= there->floor - here->floor;
}

// ---- the sky

// The number of the sky of a map: its episode's, or that of maps 1 to 11, 12 to 20 and on.
static int sky_number(const char *map) {
    if (map[0] == 'E' && map[2] == 'M' && map[1] >= '1' && map[1] <= '4') return map[1] - '0';
    int number = strncmp(map, "MAP", 3) == 0 ? atoi(map + 3) : 1;
    return number < 12 ? 1 : number < 21 ? 2 : 3;
}

// Doom draws a sky texture four times around, a column for each of 1,024 directions counter-clockwise, as flat as a wall 160 texels
// away whose row 100 is at the horizon: to who turns to the right its columns run backwards, as here from +x on. Rows are here those of
// equal steps of elevation; above the texture's first row is the row's mean.
void wad_add_sky(WadBuilder *w) {
    enum { ROWS = 256, HORIZON = 100, AWAY = 160, TURNS = 4, MOST_WIDTH = 1024 };
    Building *b = w->building;
    char name[] = "SKY1";
    name[3] = (char)('0' + sky_number(w->map->name));
    int width, height, texture = wad_texture(w->pictures, name, false, &width, &height);
    if (texture == 0 || width > MOST_WIDTH) return;
    const Texture *t = &b->textures[texture];
    int wide = t->width * TURNS;
    uint8_t *texels = ARENA_ARRAY(w->scratch, uint8_t, 4 * (size_t)wide * ROWS);
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < 4 * t->width; i++)
        if (i % 4 < 3) sum[i % 4] += (double)t->texels[i] / t->width;
    for (int j = 0; j < ROWS; j++) {
        double up = (1 - (j + 0.5) / ROWS) * M_PI / 2, row = HORIZON - AWAY * tan(up);
        int from = (int)(row * t->height / height);
        for (int i = 0; i < wide; i++) {
            uint8_t *out = texels + 4 * ((size_t)j * (size_t)wide + (size_t)i);
            for (int c = 0; c < 3; c++) out[c] = (uint8_t)(sum[c] + 0.5);
            out[3] = 255;
            if (row >= 0 && from < t->height)
                memcpy(out,
                       t->texels +
                           4 * ((size_t)from * (size_t)t->width + (size_t)(t->width - 1 - i % t->width)),
                       3);
        }
    }
    b->sky_texture = texture_add_pixels(w->arena, b, "sky", wide, ROWS, texels);
}

void wad_begin_materials(WadBuilder *w) {
    w->materials = ARENA_ARRAY(w->scratch, int, MATERIAL_SLOTS);
    for (int i = 0; i < MATERIAL_SLOTS; i++) w->materials[i] = -1;
    w->pictures = wad_open_pictures(w->map, w->arena, w->scratch, w->building);
    wad_add_sky(w);
}
