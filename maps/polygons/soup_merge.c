// soup_merge.c - convex polygons from the triangles that exporters cut them into, after Hertel & Mehlhorn 1983: an
// edge between two faces goes where the joined face is convex, and where a texture goes on across the edge. Each edge is tried once, in
// the order of the faces: a later join may make an earlier one possible that is not made, which costs a polygon and no more.
#include "engine/core/polygon.h"
#include "maps/polygons/soup_readers.h"

// Faces lie in one plane if their corners lie within this share of the mesh's largest coordinate of it: single
// precision, in which models come, resolves a sixteenth of that.
static const double FLAT = 1e-6;
enum { MAX_RING = 64, NONE = -1, SEVERAL = -2 };

// One side of an edge, running from its vertex to that of `next` with the face to its left.
typedef struct Side {
    int vertex, next, previous, face;
    int twin;  // the one side that runs the other way, or NONE
    bool gone;
} Side;

// Open addressing: slots hold an index or NONE.
typedef struct Table {
    int *slot;
    size_t mask;
} Table;

static Table make_table(Arena *arena, int count) {
    size_t size = 16;
    while (size < 2 * (size_t)count) size *= 2;
    Table table = {ARENA_ARRAY(arena, int, size), size - 1};
    for (size_t i = 0; i < size; i++) table.slot[i] = NONE;
    return table;
}

int *soup_weld(const Vec3 *vertices, int count, Arena *arena) {
    int *first = ARENA_ARRAY(arena, int, count);
    Table table = make_table(arena, count);
    for (int i = 0; i < count; i++) {
        // Adding zero makes one of both zeros.
        Vec3 v = vec3_add(vertices[i], vec3(0, 0, 0));
        size_t at = file_hash(&v, sizeof v, 0) & table.mask;
        while (table.slot[at] >= 0 && !vec3_equal(vertices[table.slot[at]], v)) at = (at + 1) & table.mask;
        if (table.slot[at] < 0) table.slot[at] = i;
        first[i] = table.slot[at];
    }
    return first;
}

static Side *list_sides(const SoupMesh *mesh, Arena *arena) {
    Side *sides = ARENA_ARRAY(arena, Side, mesh->corner_count);
    for (int f = 0; f < mesh->face_count; f++) {
        int first = mesh->faces[f].first_corner, count = mesh->faces[f].corner_count;
        for (int i = 0; i < count; i++) {
            sides[first + i] = (Side){.vertex = mesh->corners[first + i],
                                      .next = first + (i + 1) % count,
                                      .previous = first + (i + count - 1) % count,
                                      .face = f,
                                      .twin = NONE};
        }
    }
    return sides;
}

static size_t find_edge(const Table *table, const Side *sides, const int *place, int from, int to) {
    int key[2] = {from, to};
    size_t at = file_hash(key, sizeof key, 0) & table->mask;
    while (table->slot[at] != NONE) {
        const Side *s = &sides[table->slot[at]];
        if (place[s->vertex] == from && place[sides[s->next].vertex] == to) break;
        at = (at + 1) & table->mask;
    }
    return at;
}

// Two sides are twins if they are the only ones that run along their edge, one each way.
static void find_twins(const SoupMesh *mesh, Side *sides, const int *place, Arena *arena) {
    Table table = make_table(arena, mesh->corner_count);
    for (int i = 0; i < mesh->corner_count; i++) {
        size_t at =
            find_edge(&table, sides, place, place[sides[i].vertex], place[sides[sides[i].next].vertex]);
        if (table.slot[at] != NONE)
            sides[table.slot[at]].twin = SEVERAL;
        else
            table.slot[at] = i;
    }
    for (int i = 0; i < mesh->corner_count; i++) {
        int from = place[sides[i].vertex], to = place[sides[sides[i].next].vertex];
        int same = table.slot[find_edge(&table, sides, place, from, to)],
            back = table.slot[find_edge(&table, sides, place, to, from)];
        if (same != i || sides[i].twin == SEVERAL || back == NONE || sides[back].twin == SEVERAL) continue;
        sides[i].twin = back;
    }
}

static int ring_size(const Side *sides, int start) {
    int count = 1;
    for (int s = sides[start].next; s != start; s = sides[s].next) count++;
    return count;
}

// Whether the texture of the faces left of a side and of its twin goes on across the edge. Sides have the numbers of their corners.
static bool same_places(const SoupMesh *mesh, const Side *sides, int side, const double half[2]) {
    int twin = sides[side].twin, ends[2][2] = {{side, sides[twin].next}, {sides[side].next, twin}};
    for (int i = 0; i < 2; i++) {
        Vec2 off = vec2_sub(mesh->places[ends[i][0]], mesh->places[ends[i][1]]);
        if (!(fabs(off.x) <= half[0] && fabs(off.y) <= half[1])) return false;
    }
    return true;
}

// Whether the faces left of a side and of its twin may become one.
static bool joinable(const SoupMesh *mesh, const Side *sides, const int *place, int side, double flat) {
    int twin = sides[side].twin, texture = mesh->places ? mesh->faces[sides[side].face].texture : 0;
    double half[2] = {0, 0};
    if (texture > 0) {
        building_half_texel(&mesh->textures[texture], half);
        if (!same_places(mesh, sides, side, half)) return false;
    }
    int mine = ring_size(sides, side), others = ring_size(sides, twin), count = mine + others - 2;
    if (count > MAX_RING) return false;
    Vec3 ring[MAX_RING];
    Vec2 places[MAX_RING];
    int at[MAX_RING], used = 0;
    for (int s = sides[side].next, i = 0; i < mine; i++, s = sides[s].next) {
        if (texture > 0) places[used] = mesh->places[s];
        at[used++] = place[sides[s].vertex];
    }
    for (int s = sides[sides[twin].next].next; s != twin; s = sides[s].next) {
        int vertex = place[sides[s].vertex];
        // Faces that meet elsewhere too, as the two sides of a sheet do, would enclose a hole or nothing.
        for (int i = 0; i < mine; i++) {
            if (at[i] == vertex) return false;
        }
        if (texture > 0) places[used] = mesh->places[s];
        at[used++] = vertex;
    }
    for (int i = 0; i < count; i++) ring[i] = mesh->vertices[at[i]];
    Plane plane = plane_of_polygon(ring, count);
    if (polygon_bend(ring, count, plane) > flat || !polygon_is_convex(ring, count, plane.n)) return false;
    TextureMap ignored;
    return texture == 0 || building_fit_map(ring, places, count, plane.n, half, &ignored);
}

// `head` [face_count] is the lowest side of each face that is left.
static void join_faces(Side *sides, int *head, int side) {
    int twin = sides[side].twin, face = sides[side].face, other = sides[twin].face;
    int a = sides[side].previous, b = sides[twin].next, c = sides[twin].previous, d = sides[side].next;
    sides[a].next = b, sides[b].previous = a;
    sides[c].next = d, sides[d].previous = c;
    sides[side].gone = sides[twin].gone = true;
    if (other < face) face = other;
    head[face] = a;
    int s = a;
    do {
        sides[s].face = face;
        if (s < head[face]) head[face] = s;
        s = sides[s].next;
    } while (s != a);
}

static void list_faces(const SoupMesh *mesh, const Side *sides, const int *head, Arena *arena,
                       SoupMesh *out) {
    *out = (SoupMesh){.vertices = mesh->vertices,
                      .vertex_count = mesh->vertex_count,
                      .corners = ARENA_ARRAY(arena, int, mesh->corner_count),
                      .faces = ARENA_ARRAY(arena, SoupFace, mesh->face_count),
                      .textures = mesh->textures};
    if (mesh->places) out->places = ARENA_ARRAY(arena, Vec2, mesh->corner_count);
    for (int f = 0; f < mesh->face_count; f++) {
        if (sides[head[f]].gone || sides[head[f]].face != f) continue;
        SoupFace *kept = &out->faces[out->face_count++];
        *kept = mesh->faces[f];
        kept->first_corner = out->corner_count;
        kept->corner_count = 0;
        int s = head[f];
        do {
            if (mesh->places) out->places[out->corner_count] = mesh->places[s];
            out->corners[out->corner_count++] = sides[s].vertex;
            kept->corner_count++;
            s = sides[s].next;
        } while (s != head[f]);
    }
}

void soup_merge(const SoupMesh *mesh, Arena *arena, SoupMesh *out) {
    Arena scratch = {0};
    int *place = soup_weld(mesh->vertices, mesh->vertex_count, &scratch);
    Side *sides = list_sides(mesh, &scratch);
    find_twins(mesh, sides, place, &scratch);
    int *head = ARENA_ARRAY(&scratch, int, mesh->face_count);
    for (int i = 0; i < mesh->face_count; i++) head[i] = mesh->faces[i].first_corner;
    double largest = 0;
    for (int i = 0; i < mesh->vertex_count; i++) {
        Vec3 v = mesh->vertices[i];
        largest = fmax(largest, fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z))));
    }
    for (int i = 0; i < mesh->corner_count; i++) {
        const Side *side = &sides[i];
        if (side->twin < 0 || side->gone || side->face == sides[side->twin].face) continue;
        if (mesh->faces[side->face].material != mesh->faces[sides[side->twin].face].material) continue;
        if (joinable(mesh, sides, place, i, FLAT * largest)) join_faces(sides, head, i);
    }
    list_faces(mesh, sides, head, arena, out);
    arena_free(&scratch);
}
