// enclose_leaks.c - where rooms lie open to the outdoors, and the way from the room through the gap out.
#include "maps/enclose.h"

typedef struct Way {
    int *from;  // [face_count] half-edge that led into a face, -1: start, -2: not reached
    int *queue;
} Way;

typedef enum Ground { GROUND_ROOM, GROUND_AIR } Ground;

static bool belongs(const Spot *spot, Ground ground, int id) {
    return ground == GROUND_ROOM ? spot->indoor == id : spot_is_open(spot) && spot->indoor < 0;
}

// Breadth-first from face to face over one ground, until `goal` (a face, or -1: the edge of the world).
// Returns the face reached there, or -1.
static int search(const Plan *p, const Spot *spots, Way *way, int start, int goal, Ground ground, int id) {
    for (int f = 0; f < p->face_count; f++) way->from[f] = -2;
    int head = 0, tail = 0;
    way->from[start] = -1;
    way->queue[tail++] = start;
    while (head < tail) {
        int f = way->queue[head++];
        if (f == goal) return f;
        for (int k = 0; k < p->faces[f].half_count; k++) {
            int h = p->halves[p->faces[f].first_half + k], g = half_right(p, h);
            if (g < 0 && goal < 0) return f;
            if (g < 0 || way->from[g] != -2 || !belongs(&spots[g], ground, id)) continue;
            way->from[g] = h;
            way->queue[tail++] = g;
        }
    }
    return -1;
}

static Vec2 middle_of(const Plan *p, int h) {
    return vec2_scale(vec2_add(p->vertices[half_from(p, h)], p->vertices[half_to(p, h)]), 0.5);
}

// Appends the middles of the edges crossed on the way to `face`, the first crossed first.
static void push_way(Enclosure *e, const Way *way, int face) {
    const Plan *p = &e->pass.plan;
    int count = 0;
    for (int f = face; way->from[f] >= 0; f = half_left(p, way->from[f])) way->queue[count++] = way->from[f];
    while (count-- > 0) {
        Vec3 m = enclose_place(e, middle_of(p, way->queue[count]), -1);
        enclose_push_point(e, vec2(m.x, m.y), 0);
    }
}

typedef struct Gap {
    double length;
    Vec2 middle;
    int half;  // the edge at its middle, from inside
} Gap;

// A half-edge through which the space `id` lies open to the air.
static bool is_gap(const Plan *p, const Spot *spots, int h, int id) {
    int f = half_left(p, h), g = half_right(p, h);
    return f >= 0 && g >= 0 && spots[f].indoor == id && spot_is_open(&spots[g]) && spots[g].indoor < 0;
}

// The longest run of such edges that hang together.
static Gap widest_gap(const Plan *p, const Spot *spots, int id, int *parent, double *length) {
    Gap best = {0, {0, 0}, -1};
    for (int v = 0; v < p->vertex_count; v++) {
        parent[v] = v;
        length[v] = 0;
    }
    for (int h = 0; h < 2 * p->edge_count; h++) {
        if (is_gap(p, spots, h, id)) set_unite(parent, half_from(p, h), half_to(p, h));
    }
    int root = -1;
    for (int h = 0; h < 2 * p->edge_count; h++) {
        if (!is_gap(p, spots, h, id)) continue;
        int r = set_find(parent, half_from(p, h));
        length[r] += half_length(p, h);
        if (root < 0 || length[r] > length[root]) root = r;
    }
    if (root < 0) return best;
    best.length = length[root];
    double longest = 0;
    for (int h = 0; h < 2 * p->edge_count; h++) {
        if (!is_gap(p, spots, h, id) || set_find(parent, half_from(p, h)) != root ||
            half_length(p, h) <= longest)
            continue;
        longest = half_length(p, h);
        best.half = h;
        best.middle = middle_of(p, h);
    }
    return best;
}

static int largest_face(const Plan *p, const Spot *spots, int id) {
    int best = -1;
    for (int f = 0; f < p->face_count; f++) {
        if (spots[f].indoor == id && (best < 0 || p->faces[f].area > p->faces[best].area)) best = f;
    }
    return best;
}

static void note_leak(Enclosure *e, const Spot *spots, int storey, int id, Gap gap, Way *way) {
    const Plan *p = &e->pass.plan;
    bool room = id < e->sketch->room_count;
    int start = largest_face(p, spots, id), in = half_left(p, gap.half), out = half_right(p, gap.half);
    Vec3 inner = enclose_place(e, p->faces[start].inner, storey), hole = enclose_place(e, gap.middle, storey);
    building_note(e->arena, e->b, NOTE_LEAK, hole, "%s is open to the outdoors over %.2f m at (%.2f, %.2f)",
                  room ? enclose_text(e->sketch->rooms[id].place) : "a space without a name",
                  gap.length / ENCLOSE_MM, hole.x, hole.y);
    int first = e->b->point_count;
    enclose_push_point(e, vec2(inner.x, inner.y), 0);
    if (search(p, spots, way, start, in, GROUND_ROOM, id) == in) push_way(e, way, in);
    enclose_push_point(e, vec2(hole.x, hole.y), 0);
    int end = search(p, spots, way, out, -1, GROUND_AIR, 0);
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
    int ids = e->sketch->room_count + e->pass.space_count;
    bool *leaks = ARENA_ARRAY(e->scratch, bool, ids);
    int *parent = ARENA_ARRAY(e->scratch, int, p->vertex_count);
    double *length = ARENA_ARRAY(e->scratch, double, p->vertex_count);
    Way way = {ARENA_ARRAY(e->scratch, int, p->face_count), ARENA_ARRAY(e->scratch, int, p->face_count)};
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        memset(leaks, 0, (size_t)ids * sizeof *leaks);
        for (int h = 0; h < 2 * p->edge_count; h++) {
            int f = half_left(p, h);
            if (f >= 0 && spots[f].indoor >= 0 && is_gap(p, spots, h, spots[f].indoor))
                leaks[spots[f].indoor] = true;
        }
        for (int id = 0; id < ids; id++) {
            if (leaks[id]) note_leak(e, spots, storey, id, widest_gap(p, spots, id, parent, length), &way);
        }
    }
}
