// mesh_places.c - welds points that are one place and finds the points that lie on edges, with hash tables of small cubes: in any
// building the time grows with the number of points and with the length of the edges.
#include "radiosity/mesh/mesh_places.h"

#include <stdint.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/mesh/mesh_parts.h"

// Points sorted into cubes of side `size`.
typedef struct PlaceGrid {
    const Vec3 *points;
    const Places *places;
    double size, shift;
    unsigned slot_count;         // a power of two
    int *first;                  // [slot_count + 1] in `sorted`
    struct PlaceInGrid *sorted;  // [point_count]
} PlaceGrid;

typedef struct PlaceOnEdge {
    double t;  // 0 at the edge's beginning .. 1
    int point;
} PlaceOnEdge;

// The points within MESH_WELD of an edge, in order along the edge, without its ends. `found` grows in the arena.
typedef struct PlacesFound {
    PlaceOnEdge *found;
    int count, capacity;
    Arena *arena;
} PlacesFound;

// A point's entry in the hash table.
typedef struct PlaceLink {
    int next;       // another point in the same slot, -1: none
    unsigned hash;  // of the cube that the point is in
    int body;
} PlaceLink;

typedef struct PlaceInGrid {
    Vec3 at;
    int place;
} PlaceInGrid;

// Side of the cubes in which points are welded, metres: far above MESH_WELD, so that few points lie near a border. The cubes are
// shifted by WELD_SHIFT, metres, because coordinates are often whole millimetres.
static const double WELD_CUBE = 1e-3;
static const double WELD_SHIFT = 0.37e-3;
// The shift of the cubes of a PlaceGrid, in sides: floors often lie at 0, and an edge along a border would meet twice as many cubes.
static const double GRID_SHIFT = 0.37;

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

static int *slot_for(const Places *places, unsigned hash) {
    return &places->slots[hash & (unsigned)(places->slot_count - 1)];
}

static void link_place(Places *places, int place) {
    int *slot = slot_for(places, places->links[place].hash);
    places->links[place].next = *slot;
    *slot = place;
}

static void grow_table(Places *places, int slots) {
    places->slots = ARENA_ARRAY(places->arena, int, slots);
    places->slot_count = slots;
    for (int i = 0; i < slots; i++) places->slots[i] = -1;
    for (int i = 0; i < places->count; i++) link_place(places, i);
}

void places_start(Places *places, Arena *arena) {
    *places = (Places){.arena = arena};
    grow_table(places, 1024);
}

// The points are scattered over memory: comparing the hashes first avoids reading most of them.
static int find_in_cube(const Places *places, unsigned hash, Vec3 point) {
    for (int i = *slot_for(places, hash); i >= 0; i = places->links[i].next) {
        if (places->links[i].hash != hash || places->links[i].body != places->body) continue;
        Vec3 off = vec3_sub(places->points[i], point);
        if (vec3_dot(off, off) <= MESH_WELD * MESH_WELD) return i;
    }
    return -1;
}

// Is a coordinate farther from the borders of its cube than MESH_WELD plus rounding?
static bool is_clear(double at, int64_t cube) {
    double from = at + WELD_SHIFT - (double)cube * WELD_CUBE;
    return from > 2 * MESH_WELD && from < WELD_CUBE - 2 * MESH_WELD;
}

static bool is_inside(Cube home, Vec3 p) {
    return is_clear(p.x, home.x) && is_clear(p.y, home.y) && is_clear(p.z, home.z);
}

// The first place that was added within MESH_WELD of a point. Where the point is near a border of its cube, the cubes beyond the
// border are searched too.
static int find_place(const Places *places, Cube home, Vec3 point) {
    if (is_inside(home, point)) return find_in_cube(places, cube_hash(home), point);
    Vec3 by = {MESH_WELD, MESH_WELD, MESH_WELD};
    Cube low = cube_at(vec3_sub(point, by), WELD_CUBE, WELD_SHIFT);
    Cube high = cube_at(vec3_add(point, by), WELD_CUBE, WELD_SHIFT);
    int known = -1;
    for (int64_t x = low.x; x <= high.x; x++) {
        for (int64_t y = low.y; y <= high.y; y++) {
            for (int64_t z = low.z; z <= high.z; z++) {
                int i = find_in_cube(places, cube_hash((Cube){x, y, z}), point);
                if (i >= 0 && (known < 0 || i < known)) known = i;
            }
        }
    }
    return known;
}

int places_add(Places *places, Vec3 point) {
    Cube home = cube_at(point, WELD_CUBE, WELD_SHIFT);
    int known = find_place(places, home, point);
    if (known >= 0) return known;
    int i = places->count;
    *ARENA_PUSH(places->arena, places->points, places->count, places->capacity) = point;
    *ARENA_PUSH(places->arena, places->links, i, places->link_capacity) =
        (PlaceLink){.hash = cube_hash(home), .body = places->body};
    if (places->count > places->slot_count)
        grow_table(places, 4 * places->slot_count);
    else
        link_place(places, places->count - 1);
    return places->count - 1;
}

int places_body(const Places *places, int place) { return places->links[place].body; }

// ---- points on edges

static Cube cube_in(const PlaceGrid *grid, Vec3 p) { return cube_at(p, grid->size, grid->shift); }

static unsigned slot_of(const PlaceGrid *grid, Cube cube) { return cube_hash(cube) & (grid->slot_count - 1); }

static PlaceGrid place_grid(const Places *places, double size, Arena *arena) {
    const Vec3 *points = places->points;
    const int count = places->count;
    PlaceGrid grid = {
        .points = points, .places = places, .size = size, .shift = GRID_SHIFT * size, .slot_count = 1024};
    while (grid.slot_count < (unsigned)count) grid.slot_count *= 2;
    Arena scratch = {0};
    unsigned *slot = ARENA_ARRAY(&scratch, unsigned, count);
    grid.first = ARENA_ARRAY(arena, int, grid.slot_count + 1);
    grid.sorted = ARENA_ARRAY(arena, PlaceInGrid, count);
    for (int i = 0; i < count; i++) {
        slot[i] = slot_of(&grid, cube_in(&grid, points[i]));
        grid.first[slot[i] + 1]++;
    }
    for (unsigned s = 0; s < grid.slot_count; s++) grid.first[s + 1] += grid.first[s];
    // Going backwards, each run is filled from its end: the points stay in order, and `first` is right again when all are in.
    for (int i = count - 1; i >= 0; i--) grid.sorted[--grid.first[slot[i] + 1]] = (PlaceInGrid){points[i], i};
    for (unsigned s = 0; s < grid.slot_count; s++) grid.first[s] = grid.first[s + 1];
    grid.first[grid.slot_count] = count;
    arena_free(&scratch);
    return grid;
}

// A piece of an edge: t in [t0, t1), and a box about it.
typedef struct EdgePiece {
    Vec3 from, along;  // of the whole edge
    double length;     // of the whole edge, metres
    int a, b;          // the ends of the whole edge, indices of points
    double t0, t1;
    Box box;
} EdgePiece;

static bool same_cube(Cube a, Cube b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool is_in_box(const Box *box, Vec3 p) {
    return p.x >= box->min.x && p.x <= box->max.x && p.y >= box->min.y && p.y <= box->max.y &&
           p.z >= box->min.z && p.z <= box->max.z;
}

// Adds the points of a cube that lie on a piece of an edge.
static void find_on_edge(const PlaceGrid *grid, Cube cube, const EdgePiece *edge, PlacesFound *out) {
    unsigned slot = slot_of(grid, cube);
    for (int k = grid->first[slot]; k < grid->first[slot + 1]; k++) {
        const PlaceInGrid *point = &grid->sorted[k];
        if (!is_in_box(&edge->box, point->at) || point->place == edge->a || point->place == edge->b) continue;
        Vec3 off = vec3_sub(point->at, edge->from);
        double t = vec3_dot(off, edge->along) / (edge->length * edge->length);
        if (!(t >= edge->t0 && t < edge->t1)) continue;
        Vec3 beside = vec3_sub(off, vec3_scale(edge->along, t));
        if (vec3_dot(beside, beside) > MESH_WELD * MESH_WELD) continue;
        if (!same_cube(cube, cube_in(grid, point->at))) continue;  // another cube in the same slot
        if (places_body(grid->places, point->place) != places_body(grid->places, edge->a)) continue;
        *ARENA_PUSH(out->arena, out->found, out->count, out->capacity) = (PlaceOnEdge){t, point->place};
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

static int place_grid_on_edge(const PlaceGrid *grid, int a, int b, PlacesFound *out) {
    out->count = 0;
    EdgePiece edge = {grid->points[a], vec3_sub(grid->points[b], grid->points[a]), .a = a, .b = b};
    edge.length = vec3_length(edge.along);
    if (edge.length <= MESH_WELD) return 0;
    // The edge is searched in pieces no longer than a cube's side, which meet eight cubes at most and mostly one or two.
    int pieces = (int)ceil(edge.length / grid->size);
    for (int i = 0; i < pieces; i++) {
        edge.t0 = (double)i / pieces;
        edge.t1 = (double)(i + 1) / pieces;
        Vec3 from = vec3_add(edge.from, vec3_scale(edge.along, edge.t0)),
             to = vec3_add(edge.from, vec3_scale(edge.along, edge.t1));
        edge.box = box_grow(box_add(box_add(box_empty(), from), to), 2 * MESH_WELD);
        Cube low = cube_in(grid, edge.box.min), high = cube_in(grid, edge.box.max);
        for (int64_t x = low.x; x <= high.x; x++)
            for (int64_t y = low.y; y <= high.y; y++)
                for (int64_t z = low.z; z <= high.z; z++) find_on_edge(grid, (Cube){x, y, z}, &edge, out);
    }
    sort_by_t(out->found, out->count);
    return out->count;
}

// ---- anchoring: places that lie on an edge of a face or element become corners there, so that neighbours share whole edges
// and no crack opens between them (Baum, Mann, Smith & Winget 1991: T-vertices).

// Closed rings of corners, the outlines of faces or elements: ring r is corner[end[r - 1]] .. corner[end[r] - 1].
typedef struct Rings {
    int *corner;  // indices of places
    int *end;     // [count]
    int count;
} Rings;

static int begin_of(const Rings *rings, int ring) { return ring == 0 ? 0 : rings->end[ring - 1]; }

static double mean_edge(const Vec3 *points, const Rings *rings) {
    double length = 0;
    int edges = 0;
    for (int r = 0; r < rings->count; r++) {
        int first = begin_of(rings, r), end = rings->end[r];
        for (int i = first; i < end; i++, edges++) {
            int next = i + 1 == end ? first : i + 1;
            length += vec3_length(vec3_sub(points[rings->corner[next]], points[rings->corner[i]]));
        }
    }
    return edges > 0 ? length / edges : 1;
}

// ---- on several threads

enum { RINGS_A_GROUP = 2048 };

// The new corners of a group of rings.
typedef struct Anchored {
    Arena arena;
    int *corner, count, capacity;
} Anchored;

typedef struct Anchoring {
    const Rings *rings;
    PlaceGrid grid;
    int *grown;  // [rings->count] the new number of corners of each ring
    Anchored *groups;
} Anchoring;

static void push(Anchored *out, int place) {
    *ARENA_PUSH(&out->arena, out->corner, out->count, out->capacity) = place;
}

static void anchor_ring(const Anchoring *a, int ring, PlacesFound *on_edge, Anchored *out) {
    const int *corner = a->rings->corner;
    int first = begin_of(a->rings, ring), end = a->rings->end[ring], before = out->count;
    for (int i = first; i < end; i++) {
        push(out, corner[i]);
        int found = place_grid_on_edge(&a->grid, corner[i], corner[i + 1 == end ? first : i + 1], on_edge);
        for (int k = 0; k < found; k++) push(out, on_edge->found[k].point);
    }
    a->grown[ring] = out->count - before;
}

static void anchor_group(void *context, int index, int thread) {
    (void)thread;
    const Anchoring *a = context;
    int first = index * RINGS_A_GROUP, end = first + RINGS_A_GROUP;
    PlacesFound on_edge = {.arena = &a->groups[index].arena};
    for (int ring = first; ring < end && ring < a->rings->count; ring++)
        anchor_ring(a, ring, &on_edge, &a->groups[index]);
}

// Copies the groups' corners into one array in the arena, group after group, and frees the groups.
static int *join_groups(const Anchoring *a, int group_count, Arena *arena, int *out_count) {
    int count = 0;
    for (int g = 0; g < group_count; g++) count += a->groups[g].count;
    int *corner = ARENA_ARRAY(arena, int, count);
    *out_count = 0;
    for (int g = 0; g < group_count; g++) {
        Anchored *group = &a->groups[g];
        if (group->count > 0)
            memcpy(corner + *out_count, group->corner, (size_t)group->count * sizeof *corner);
        *out_count += group->count;
        arena_free(&group->arena);
    }
    return corner;
}

// Inserts each of the builder's places that lies on an edge of a ring into this ring. Returns the new number of all corners.
static int anchor(MeshBuilder *builder, Rings *rings) {
    Arena scratch = {0};
    const Places *places = &builder->places;
    int groups = (rings->count + RINGS_A_GROUP - 1) / RINGS_A_GROUP, count;
    Anchoring a = {.rings = rings,
                   .grid = place_grid(places, mean_edge(places->points, rings), &scratch),
                   .grown = ARENA_ARRAY(&scratch, int, rings->count),
                   .groups = ARENA_ARRAY(&scratch, Anchored, groups)};
    parallel_for(parallel_threads(builder->mesh->options.threads), groups, anchor_group, &a);
    rings->corner = join_groups(&a, groups, builder->arena, &count);
    for (int r = 0, end = 0; r < rings->count; r++) rings->end[r] = end += a.grown[r];
    arena_free(&scratch);
    return count;
}

// ---- the faces and elements of a mesh

void mesh_anchor_outlines(MeshBuilder *builder, int *corner) {
    Mesh *mesh = builder->mesh;
    Arena scratch = {0};
    Rings rings = {corner, ARENA_ARRAY(&scratch, int, mesh->face_count), mesh->face_count};
    for (int f = 0; f < mesh->face_count; f++)
        rings.end[f] = mesh->faces[f].first_vertex + mesh->faces[f].vertex_count;
    mesh->outline_count = anchor(builder, &rings);
    mesh->outline = rings.corner;
    for (int f = 0; f < mesh->face_count; f++) {
        mesh->faces[f].first_vertex = begin_of(&rings, f);
        mesh->faces[f].vertex_count = rings.end[f] - begin_of(&rings, f);
    }
    arena_free(&scratch);
}

void mesh_anchor_elements(MeshBuilder *builder) {
    Mesh *mesh = builder->mesh;
    Arena scratch = {0};
    Rings rings = {mesh->corners, ARENA_ARRAY(&scratch, int, mesh->element_count), mesh->element_count};
    for (int e = 0; e < mesh->element_count; e++)
        rings.end[e] = mesh->elements[e].first_corner + mesh->elements[e].corner_count;
    mesh->corner_count = anchor(builder, &rings);
    mesh->corners = rings.corner;
    for (int e = 0; e < mesh->element_count; e++) {
        mesh->elements[e].first_corner = begin_of(&rings, e);
        mesh->elements[e].corner_count = rings.end[e] - begin_of(&rings, e);
    }
    arena_free(&scratch);
}
