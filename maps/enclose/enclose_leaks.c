// enclose_leaks.c - where rooms lie open to the outdoors, and the way from the room through the gap out.
//
// Each room is looked at by its own gaps and faces: plans that lie open in many places are no rarity.
#include <stdlib.h>

#include "maps/enclose/enclose.h"

typedef struct Way {
    int *from;     // [face_count] half-edge that led into a face, -1: start
    int *reached;  // [face_count] by the search of this number
    int *queue;
    int search;
} Way;

typedef enum Ground { GROUND_ROOM, GROUND_AIR } Ground;

static bool belongs(const Spot *spot, Ground ground, int id) {
    return ground == GROUND_ROOM ? spot->indoor == id : spot_is_open(spot) && spot->indoor < 0;
}

// Breadth-first from face to face over one ground, until `goal` (a face, or -1: the edge of the world).
// Returns the face reached there, or -1.
static int find_way(const Plan *p, const Spot *spots, Way *way, int start, int goal, Ground ground, int id) {
    int head = 0, tail = 0;
    way->search++;
    way->reached[start] = way->search;
    way->from[start] = -1;
    way->queue[tail++] = start;
    while (head < tail) {
        int f = way->queue[head++];
        if (f == goal) return f;
        for (int k = 0; k < p->faces[f].half_count; k++) {
            int h = p->halves[p->faces[f].first_half + k], g = half_right(p, h);
            if (g < 0 && goal < 0) return f;
            if (g < 0 || way->reached[g] == way->search || !belongs(&spots[g], ground, id)) continue;
            way->reached[g] = way->search;
            way->from[g] = h;
            way->queue[tail++] = g;
        }
    }
    return -1;
}

static Vec2 middle_of_edge(const Plan *p, int h) {
    return vec2_scale(vec2_add(p->vertices[half_from(p, h)], p->vertices[half_to(p, h)]), 0.5);
}

// Appends the middles of the edges crossed on the way to `face`, the first crossed first.
static void push_way(Enclosure *e, const Way *way, int face) {
    const Plan *p = &e->pass.plan;
    int count = 0;
    for (int f = face; way->from[f] >= 0; f = half_left(p, way->from[f])) way->queue[count++] = way->from[f];
    while (count-- > 0) {
        Vec3 m = enclose_place(e, middle_of_edge(p, way->queue[count]), -1);
        enclose_push_point(e, vec2(m.x, m.y), 0);
    }
}

// A half-edge through which a space lies open to the air.
typedef struct Slit {
    int id, half;
} Slit;

static int by_space(const void *pa, const void *pb) {
    const Slit *a = pa, *b = pb;
    return a->id != b->id ? a->id - b->id : a->half - b->half;
}

// All of a storey, space by space. Returns how many.
static int find_slits(const Plan *p, const Spot *spots, Slit *out) {
    int count = 0;
    for (int h = 0; h < 2 * p->edge_count; h++) {
        int f = half_left(p, h), g = half_right(p, h);
        if (f < 0 || g < 0 || spots[f].indoor < 0) continue;
        if (spot_is_open(&spots[g]) && spots[g].indoor < 0) out[count++] = (Slit){spots[f].indoor, h};
    }
    qsort(out, (size_t)count, sizeof *out, by_space);
    return count;
}

typedef struct Gap {
    double length;
    Vec2 middle;
    int half;  // the edge at its middle, from inside
} Gap;

// The longest run of a space's slits that hang together.
static Gap widest_gap(const Plan *p, const Slit *slits, int count, int *parent, double *length) {
    for (int i = 0; i < count; i++) {
        int from = half_from(p, slits[i].half), to = half_to(p, slits[i].half);
        parent[from] = from;
        parent[to] = to;
        length[from] = length[to] = 0;
    }
    for (int i = 0; i < count; i++) set_unite(parent, half_from(p, slits[i].half), half_to(p, slits[i].half));
    int root = -1;
    for (int i = 0; i < count; i++) {
        int r = set_find(parent, half_from(p, slits[i].half));
        length[r] += half_length(p, slits[i].half);
        if (root < 0 || length[r] > length[root]) root = r;
    }
    Gap best = {length[root], {0, 0}, -1};
    double longest = 0;
    for (int i = 0; i < count; i++) {
        int h = slits[i].half;
        if (set_find(parent, half_from(p, h)) != root || half_length(p, h) <= longest) continue;
        longest = half_length(p, h);
        best.half = h;
        best.middle = middle_of_edge(p, h);
    }
    return best;
}

// [ids] the largest face of each space of a storey.
static void find_largest(const Plan *p, const Spot *spots, int *largest, int ids) {
    for (int id = 0; id < ids; id++) largest[id] = -1;
    for (int f = 0; f < p->face_count; f++) {
        int id = spots[f].indoor;
        if (id < 0 || (largest[id] >= 0 && p->faces[f].area <= p->faces[largest[id]].area)) continue;
        largest[id] = f;
    }
}

// `start`: a face of the space.
static void note_leak(Enclosure *e, const Spot *spots, int storey, int start, Gap gap, Way *way) {
    const Plan *p = &e->pass.plan;
    int id = spots[start].indoor, in = half_left(p, gap.half), out = half_right(p, gap.half);
    bool room = id < e->sketch->room_count;
    Vec3 inner = enclose_place(e, p->faces[start].inner, storey), hole = enclose_place(e, gap.middle, storey);
    building_note(e->arena, e->b, NOTE_LEAK, hole, "%s is open to the outdoors over %.2f m at (%.2f, %.2f)",
                  room ? enclose_text(e->sketch->rooms[id].place) : "a space without a name",
                  gap.length / ENCLOSE_MM, hole.x, hole.y);
    int first = e->b->point_count;
    enclose_push_point(e, vec2(inner.x, inner.y), 0);
    if (find_way(p, spots, way, start, in, GROUND_ROOM, id) == in) push_way(e, way, in);
    enclose_push_point(e, vec2(hole.x, hole.y), 0);
    int end = find_way(p, spots, way, out, -1, GROUND_AIR, 0);
    if (end >= 0) {
        push_way(e, way, end);
        Vec3 air = enclose_place(e, p->faces[end].inner, storey);
        enclose_push_point(e, vec2(air.x, air.y), 0);
    }
    Note *note = &e->b->notes[e->b->note_count - 1];
    note->first_point = first;
    note->point_count = e->b->point_count - first;
}

void leaks_report(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    Arena *a = e->scratch;
    int ids = e->sketch->room_count + e->pass.space_count;
    Slit *slits = ARENA_ARRAY(a, Slit, 2 * p->edge_count);
    int *largest = ARENA_ARRAY(a, int, ids), *parent = ARENA_ARRAY(a, int, p->vertex_count);
    double *length = ARENA_ARRAY(a, double, p->vertex_count);
    Way way = {.from = ARENA_ARRAY(a, int, p->face_count),
               .reached = ARENA_ARRAY(a, int, p->face_count),
               .queue = ARENA_ARRAY(a, int, p->face_count)};
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        int count = find_slits(p, spots, slits);
        if (count > 0) find_largest(p, spots, largest, ids);
        for (int i = 0, next; i < count; i = next) {
            for (next = i + 1; next < count && slits[next].id == slits[i].id;) next++;
            Gap gap = widest_gap(p, slits + i, next - i, parent, length);
            note_leak(e, spots, storey, largest[slits[i].id], gap, &way);
        }
    }
}
