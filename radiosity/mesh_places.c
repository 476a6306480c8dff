// mesh_places.c - welds points by place and finds those on edges, with hash tables of small cubes: time grows with the
// number of points and with the length of the edges, whatever the building.
#include "radiosity/mesh_places.h"

#include <stdint.h>

// Side of the cubes in which points are welded, metres: far above MESH_WELD, so that few lie near a border. The cubes are
// shifted: coordinates are often whole millimetres.
static const double WELD_CUBE = 1e-3;
static const double WELD_SHIFT = 0.37e-3;

typedef struct Cube {
    int64_t x, y, z;
} Cube;

static Cube cube_at(Vec3 p, double size, double shift) {
    return (Cube){(int64_t)floor((p.x + shift) / size), (int64_t)floor((p.y + shift) / size),
                  (int64_t)floor((p.z + shift) / size)};
}

static unsigned cube_hash(Cube c) {
    uint64_t h = (uint64_t)c.x * 0x9e3779b97f4a7c15u ^ (uint64_t)c.y * 0xc2b2ae3d27d4eb4fu ^
                 (uint64_t)c.z * 0x165667b19e3779f9u;
    h ^= h >> 32;
    h *= 0xd6e8feb86659fd93u;
    return (unsigned)(h >> 32);
}

// ---- welding

static unsigned weld_slot(const Places *places, Cube cube) {
    return cube_hash(cube) & (unsigned)(places->slot_count - 1);
}

static void grow_table(Places *places, int slots) {
    places->slots = ARENA_ARRAY(places->arena, int, slots);
    places->slot_count = slots;
    for (int i = 0; i < slots; i++) places->slots[i] = -1;
    for (int i = 0; i < places->count; i++) {
        unsigned slot = weld_slot(places, cube_at(places->points[i], WELD_CUBE, WELD_SHIFT));
        places->next[i] = places->slots[slot];
        places->slots[slot] = i;
    }
}

void places_start(Places *places, Arena *arena) {
    *places = (Places){.arena = arena};
    grow_table(places, 1024);
}

static int find_in_cube(const Places *places, Cube cube, Vec3 point) {
    for (int i = places->slots[weld_slot(places, cube)]; i >= 0; i = places->next[i]) {
        Vec3 off = vec3_sub(places->points[i], point);
        if (vec3_dot(off, off) <= MESH_WELD * MESH_WELD) return i;
    }
    return -1;
}

int places_add(Places *places, Vec3 point) {
    Vec3 by = {MESH_WELD, MESH_WELD, MESH_WELD};
    Cube home = cube_at(point, WELD_CUBE, WELD_SHIFT);
    Cube low = cube_at(vec3_sub(point, by), WELD_CUBE, WELD_SHIFT);
    Cube high = cube_at(vec3_add(point, by), WELD_CUBE, WELD_SHIFT);
    int known = -1;  // the first that came, whichever cube it is in
    for (int64_t x = low.x; x <= high.x; x++) {
        for (int64_t y = low.y; y <= high.y; y++) {
            for (int64_t z = low.z; z <= high.z; z++) {
                int i = find_in_cube(places, (Cube){x, y, z}, point);
                if (i >= 0 && (known < 0 || i < known)) known = i;
            }
        }
    }
    if (known >= 0) return known;
    int i = places->count;
    *ARENA_PUSH(places->arena, places->points, places->count, places->capacity) = point;
    *ARENA_PUSH(places->arena, places->next, i, places->next_capacity) = -1;
    if (places->count > places->slot_count) {
        grow_table(places, 4 * places->slot_count);
    } else {
        unsigned slot = weld_slot(places, home);
        places->next[places->count - 1] = places->slots[slot];
        places->slots[slot] = places->count - 1;
    }
    return places->count - 1;
}

// ---- points on edges

PlaceGrid place_grid(const Vec3 *points, int count, double size, Arena *arena) {
    PlaceGrid grid = {.points = points, .size = size, .slot_count = 1024};
    while (grid.slot_count < (unsigned)count) grid.slot_count *= 2;
    grid.first = ARENA_ARRAY(arena, int, grid.slot_count + 1);
    grid.index = ARENA_ARRAY(arena, int, count);
    for (int i = 0; i < count; i++)
        grid.first[(cube_hash(cube_at(points[i], size, 0)) & (grid.slot_count - 1)) + 1]++;
    for (unsigned s = 0; s < grid.slot_count; s++) grid.first[s + 1] += grid.first[s];
    // Backwards, each run fills from its end: in order, and the beginnings are back in place when done.
    for (int i = count - 1; i >= 0; i--)
        grid.index[--grid.first[(cube_hash(cube_at(points[i], size, 0)) & (grid.slot_count - 1)) + 1]] = i;
    for (unsigned s = 0; s < grid.slot_count; s++) grid.first[s] = grid.first[s + 1];
    grid.first[grid.slot_count] = count;
    return grid;
}

typedef struct Edge {
    Vec3 from, along;
    double length;  // metres
    int a, b;
} Edge;

static bool same_cube(Cube a, Cube b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// Points of a cube on the edge, with t in [t0, t1).
static void find_on_edge(const PlaceGrid *grid, Cube cube, const Edge *edge, double t0, double t1,
                         PlacesFound *out) {
    unsigned slot = cube_hash(cube) & (grid->slot_count - 1);
    for (int k = grid->first[slot]; k < grid->first[slot + 1]; k++) {
        int point = grid->index[k];
        Vec3 off = vec3_sub(grid->points[point], edge->from);
        double t = vec3_dot(off, edge->along) / (edge->length * edge->length);
        if (!(t >= t0 && t < t1) || point == edge->a || point == edge->b) continue;
        Vec3 beside = vec3_sub(off, vec3_scale(edge->along, t));
        if (vec3_dot(beside, beside) > MESH_WELD * MESH_WELD) continue;
        if (!same_cube(cube, cube_at(grid->points[point], grid->size, 0))) continue;  // of the same slot
        *ARENA_PUSH(out->arena, out->found, out->count, out->capacity) = (PlaceOnEdge){t, point};
    }
}

static void sort_by_t(PlaceOnEdge *found, int count) {
    for (int i = 1; i < count; i++) {
        PlaceOnEdge p = found[i];
        int at = i;
        for (; at > 0 && (found[at - 1].t > p.t || (found[at - 1].t == p.t && found[at - 1].point > p.point));
             at--)
            found[at] = found[at - 1];
        found[at] = p;
    }
}

int place_grid_on_edge(const PlaceGrid *grid, int a, int b, PlacesFound *out) {
    out->count = 0;
    Edge edge = {grid->points[a], vec3_sub(grid->points[b], grid->points[a]), 0, a, b};
    edge.length = vec3_length(edge.along);
    if (edge.length <= MESH_WELD) return 0;
    // In pieces no longer than a cube, which meet eight cubes at most and mostly one or two.
    int pieces = (int)ceil(edge.length / grid->size);
    for (int i = 0; i < pieces; i++) {
        double t0 = (double)i / pieces, t1 = (double)(i + 1) / pieces;
        Vec3 from = vec3_add(edge.from, vec3_scale(edge.along, t0)),
             to = vec3_add(edge.from, vec3_scale(edge.along, t1));
        Box box = box_grow(box_add(box_add(box_empty(), from), to), 2 * MESH_WELD);
        Cube low = cube_at(box.min, grid->size, 0), high = cube_at(box.max, grid->size, 0);
        for (int64_t x = low.x; x <= high.x; x++)
            for (int64_t y = low.y; y <= high.y; y++)
                for (int64_t z = low.z; z <= high.z; z++)
                    find_on_edge(grid, (Cube){x, y, z}, &edge, t0, t1, out);
    }
    sort_by_t(out->found, out->count);
    return out->count;
}
