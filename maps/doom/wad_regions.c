// wad_regions.c - the convex pieces of a Doom map as regions: a prism each, between its sector's floor and ceiling.
//
// Regions that touch share their vertices, those too where the corner of one lies on the edge of another
// (wad_vertices.c).
#include <stdio.h>

#include "maps/doom/wad.h"

// A cell has at most 64 corners: a ring of more is cut along a chord.
enum { MOST_CORNERS = 60 };
// Light is dimmed in so many steps, so that there are no more than so many materials of one name.
enum { LIGHT_STEPS = 8, BRIGHTEST = 256 };
// What the dimmest and the brightest sector reflect of the colour's own.
static const double DIMMEST = 0.35, FULL = 1.0;
static const char SKY_FLAT[] = "F_SKY1";
enum { SKY_COLOUR = 0xA8CCF0 };
enum { MATERIAL_SLOTS = 1 << 16 };  // of the hash table; materials beyond half of it share the first

// ---- materials

// A steady colour for a name: greyish, as most surfaces of such maps are.
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

// The name of a texture as it is lit in a sector. The sky is the same everywhere.
static void name_material(const char *texture, int step, char out[32]) {
    bool bare = strcmp(texture, "-") == 0 || !*texture;
    if (strcmp(texture, SKY_FLAT) == 0) {
        snprintf(out, 32, "sky");
    } else {
        snprintf(out, 32, "%s light %d", bare ? "bare" : texture, step);
    }
}

// The sky is drawn, since it hides what lies beyond: other courts, as high as they like, are not seen over a wall.
static int material_of(WadBuilder *w, const char *texture, int sector) {
    Building *b = w->building;
    int light = w->map->sectors[sector].light;
    light = light < 0 ? 0 : light >= BRIGHTEST ? BRIGHTEST - 1 : light;
    int step = light * LIGHT_STEPS / BRIGHTEST;
    char name[32];
    name_material(texture, step, name);
    size_t slot = (size_t)file_hash(name, strlen(name), 0) % MATERIAL_SLOTS;
    for (; w->materials[slot] >= 0; slot = (slot + 1) % MATERIAL_SLOTS) {
        if (strcmp(b->materials[w->materials[slot]].name, name) == 0) return w->materials[slot];
    }
    if (b->material_count >= MATERIAL_SLOTS / 2) return 0;
    Material *m = ARENA_PUSH(w->arena, b->materials, b->material_count, b->material_capacity);
    *m = (Material){.name = arena_string(w->arena, name), .alpha = 1};
    double dimmed = DIMMEST + (FULL - DIMMEST) * step / (LIGHT_STEPS - 1);
    m->reflectance = strcmp(texture, SKY_FLAT) == 0 ? maps_colour(SKY_COLOUR) : colour_of(texture, dimmed);
    return w->materials[slot] = b->material_count - 1;
}

// Of the wall above or below an opening to another sector, the higher one.
static const char *step_texture(const WadMap *map, const WadSide *side, int sector, int beyond) {
    const WadSector *here = &map->sectors[sector], *there = &map->sectors[beyond];
    int upper = here->ceiling - there->ceiling, lower = there->floor - here->floor;
    // Between two ceilings of sky there is sky.
    bool sky =
        strcmp(here->ceiling_flat, there->ceiling_flat) == 0 && strcmp(here->ceiling_flat, SKY_FLAT) == 0;
    return upper < lower ? side->lower : sky ? SKY_FLAT : side->upper;
}

int wad_wall_material(WadBuilder *w, const WadEdge *edge, int sector, double along) {
    const WadMap *map = w->map;
    for (int i = w->index->first[edge->axis]; i < w->index->first[edge->axis + 1]; i++) {
        const WadSpan *span = &w->index->spans[i];
        if (span->low > along || span->high < along) continue;
        const WadLine *line = &map->lines[span->line];
        int facing = wad_facing(span, edge->side), beyond = line->sector[1 - facing];
        if (line->side[facing] < 0) continue;
        const WadSide *side = &map->sides[line->side[facing]];
        const char *texture = beyond < 0 ? side->middle : step_texture(map, side, sector, beyond);
        return material_of(w, texture, sector);
    }
    return material_of(w, map->sectors[sector].floor_flat, sector);
}

// ---- rings

typedef struct Outline {
    Vec2 *points;
    int *materials;
    int count, point_capacity, material_capacity;
} Outline;

static void add_point(Arena *scratch, Outline *o, Vec2 at, int material) {
    int count = o->count;
    *ARENA_PUSH(scratch, o->points, count, o->point_capacity) = at;
    *ARENA_PUSH(scratch, o->materials, o->count, o->material_capacity) = material;
}

static Outline trace(WadBuilder *w, const WadVertices *vertices, const WadPiece *piece, Arena *scratch) {
    Outline out = {0};
    for (int k = 0; k < piece->edge_count; k++) {
        WadPlace *places;
        int count = wad_edge_vertices(w->pieces, vertices, piece, k, scratch, &places);
        const WadEdge *edge = &w->pieces->edges[piece->first_edge + k];
        for (int i = 0; i + 1 < count; i++) {
            double middle = (places[i].along + places[i + 1].along) / 2;
            add_point(scratch, &out, places[i].at, wad_wall_material(w, edge, piece->sector, middle));
        }
    }
    return out;
}

static double ring_area(const Vec2 *p, int count) {
    double area = 0;
    for (int i = 1; i + 1 < count; i++) area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0]));
    return area / 2;
}

static void add_ring(WadBuilder *w, const Outline *o) {
    Building *b = w->building;
    *ARENA_PUSH(w->arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, o->count};
    for (int i = 0; i < o->count; i++) {
        int count = b->point_count;
        *ARENA_PUSH(w->arena, b->edge_material, count, b->edge_capacity) = o->materials[i];
        *ARENA_PUSH(w->arena, b->points, b->point_count, b->point_capacity) = o->points[i];
    }
}

static void add_region(WadBuilder *w, int sector, const Outline *o) {
    Building *b = w->building;
    const WadMover *mover = &w->movers[sector];
    const WadSector *s = &w->map->sectors[sector];
    *ARENA_PUSH(w->arena, b->regions, b->region_count, b->region_capacity) =
        (Region){.kind = REGION_ROOM,
                 .name = arena_format(w->arena, "sector %d", sector),
                 .opening = -1,
                 .first_ring = b->ring_count,
                 .ring_count = 1,
                 .z0 = wad_metres_of(mover->floor),
                 .z1 = wad_metres_of(mover->ceiling),
                 .floor_material = material_of(w, s->floor_flat, sector),
                 .ceiling_material = material_of(w, s->ceiling_flat, sector)};
    add_ring(w, o);
}

static Outline part_of(const Outline *o, int from, int count, Arena *scratch) {
    Outline part = {ARENA_ARRAY(scratch, Vec2, count), ARENA_ARRAY(scratch, int, count), count, count, count};
    for (int i = 0; i < count; i++) {
        part.points[i] = o->points[(from + i) % o->count];
        part.materials[i] = o->materials[(from + i) % o->count];
    }
    return part;
}

// Rings with very many corners are halved along the chord that leaves the larger smaller half.
static void add_regions(WadBuilder *w, int sector, const Outline *o, Arena *scratch) {
    if (o->count <= MOST_CORNERS) {
        add_region(w, sector, o);
        return;
    }
    int half = o->count / 2, best = 0;
    double most = -INFINITY;
    Outline part[2];
    for (int i = 0; i < half; i++) {
        part[0] = part_of(o, i, half + 1, scratch);
        part[1] = part_of(o, i + half, o->count - half + 1, scratch);
        double least =
            fmin(ring_area(part[0].points, part[0].count), ring_area(part[1].points, part[1].count));
        if (least > most) most = least, best = i;
    }
    part[0] = part_of(o, best, half + 1, scratch);
    part[1] = part_of(o, best + half, o->count - half + 1, scratch);
    for (int k = 0; k < 2; k++) add_regions(w, sector, &part[k], scratch);
}

void wad_add_regions(WadBuilder *w) {
    const WadPieces *p = w->pieces;
    Arena scratch = {0}, ring = {0};
    const WadVertices *vertices = wad_list_vertices(p, &scratch);
    w->first_region = ARENA_ARRAY(w->scratch, int, p->piece_count + 1);
    w->materials = ARENA_ARRAY(w->scratch, int, MATERIAL_SLOTS);
    for (int i = 0; i < MATERIAL_SLOTS; i++) w->materials[i] = -1;
    for (int i = 0; i < p->piece_count; i++) {
        const WadPiece *piece = &p->pieces[i];
        w->first_region[i] = w->building->region_count;
        if (piece->sector < 0 || w->movers[piece->sector].floor >= w->movers[piece->sector].ceiling) continue;
        arena_reset(&ring);
        Outline outline = trace(w, vertices, piece, &ring);
        add_regions(w, piece->sector, &outline, &ring);
    }
    w->first_region[p->piece_count] = w->building->region_count;
    arena_free(&scratch);
    arena_free(&ring);
}
