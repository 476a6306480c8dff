// enclose_report.c - notes on the rooms and openings of the sketch: areas, overlaps, terraces, closed gaps, leaks.
#include <stdlib.h>

#include "maps/enclose/enclose.h"

// A room that keeps less than this share of its area is lost.
static const double LEAST_KEPT = 0.1;
// Overlaps of rooms up to this area, mm^2, and losses of openings up to this share are not noted.
static const double SMALL_OVERLAP = 5e4, SMALL_LOSS = 0.2;

typedef struct RoomAreas {
    double drawn, overlapped, open, kept, terrace;
} RoomAreas;

static void measure_rooms(Enclosure *e, RoomAreas *areas) {
    const Plan *p = &e->pass.plan;
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (!e->room_used[i]) continue;
        const Spot *spots = e->pass.spots + (size_t)e->sketch->rooms[i].storey * (size_t)p->face_count;
        for (int k = plan_faces_in(e, p, &e->rooms[i]); k-- > 0;) {
            const Spot *spot = &spots[e->faces.items[k]];
            double area = p->faces[e->faces.items[k]].area;
            if (spot->room != i) {
                if (spot_is_open(spot)) areas[i].overlapped += area;
                continue;
            }
            areas[i].drawn += area;
            if (spot_is_open(spot)) areas[i].open += area;
            if (spot->indoor >= 0) areas[i].kept += area;
            if (spot->terrace >= 0) areas[i].terrace += area;
        }
    }
}

static void report_room(Enclosure *e, int i, const RoomAreas *a) {
    const SketchRoom *r = &e->sketch->rooms[i];
    Vec3 p = enclose_place(e, e->rooms[i].points[0], r->storey);
    const char *name = enclose_text(r->place);
    double m2 = ENCLOSE_MM * ENCLOSE_MM, usable = a->kept + a->terrace;
    double lost = usable < LEAST_KEPT * a->drawn ? a->drawn : fmax(0, a->open - usable);
    e->b->drawn_area += a->drawn / m2;
    e->b->lost_area += lost / m2;
    if (a->overlapped > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "%s at (%.2f, %.2f) overlaps earlier ones by %.2f m^2: they keep it", name, p.x, p.y,
                      a->overlapped / m2);
    }
    if (a->drawn <= 0 || lost == a->drawn) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f) left out: walls or other rooms cover its %.2f m^2", name, p.x, p.y,
                      (a->drawn + a->overlapped) / m2);
    } else if (lost > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f): %.2f of its %.2f m^2 lie outside the walls and are left out", name,
                      p.x, p.y, lost / m2, a->drawn / m2);
    }
    if (a->terrace > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "%s at (%.2f, %.2f) is not enclosed: %.2f m^2 of it are a terrace", name, p.x, p.y,
                      a->terrace / m2);
    }
}

static void report_holes(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    for (int i = 0; i < e->sketch->opening_count; i++) {
        Hole *h = &e->holes[i];
        if (!h->used) continue;
        int storey = e->sketch->openings[i].storey;
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        double kept = 0, lost = 0;
        int other = -1;
        for (int k = plan_faces_in(e, p, &h->box); k-- > 0;) {
            const Spot *spot = &spots[e->faces.items[k]];
            bool own = false;
            for (int n = 0; n < SPOT_HOLES; n++) own = own || spot->hole[n] == i;
            if (own) {
                kept += p->faces[e->faces.items[k]].area;
            } else {
                lost += p->faces[e->faces.items[k]].area;
                if (spot->hole[0] >= 0 && (other < 0 || spot->hole[0] < other)) other = spot->hole[0];
            }
        }
        Vec3 at = enclose_place(e, h->centre, storey);
        const char *name = enclose_text(e->sketch->openings[i].place);
        const char *by = other >= 0 ? enclose_text(e->sketch->openings[other].place) : "its own thinness";
        if (kept <= 0) {
            h->used = false;
            building_note(e->arena, e->b, NOTE_DROPPED, at, "%s at (%.2f, %.2f) left out: covered by %s",
                          name, at.x, at.y, by);
        } else if (lost > SMALL_LOSS * (kept + lost)) {
            building_note(e->arena, e->b, NOTE_CHANGED, at,
                          "%s at (%.2f, %.2f) loses %.0f %% of its place to %s", name, at.x, at.y,
                          100 * lost / (kept + lost), by);
        }
    }
}

static void report_plugs(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        int count = 0, widest = -1;
        for (int f = 0; f < p->face_count; f++) {
            if (spots[f].wall != WALL_PLUG) continue;
            count++;
            if (widest < 0 || p->faces[f].area > p->faces[widest].area) widest = f;
        }
        if (count == 0) continue;
        Vec3 at = enclose_place(e, p->faces[widest].inner, storey);
        building_note(e->arena, e->b, NOTE_CHANGED, at,
                      "storey %d: %d small gaps between walls were closed, the largest at (%.2f, %.2f)",
                      storey, count, at.x, at.y);
    }
}

static void report_slits(Enclosure *e) {
    int count = 0;
    for (int storey = 0; storey < e->b->storey_count; storey++) count += e->slits[storey].count;
    if (count == 0) return;
    const SketchOpening *o = &e->sketch->openings[e->slit_opening];
    Vec3 at = enclose_place(e, e->holes[e->slit_opening].centre, o->storey);
    building_note(e->arena, e->b, NOTE_CHANGED, at,
                  "%d slits between doors or windows and the walls beside them were closed, the widest, %.0f "
                  "mm, beside %s "
                  "at (%.2f, %.2f)",
                  count, e->widest_slit, enclose_text(o->place), at.x, at.y);
}

void indoor_report(Enclosure *e) {
    RoomAreas *areas = ARENA_ARRAY(e->scratch, RoomAreas, e->sketch->room_count);
    measure_rooms(e, areas);
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (e->room_used[i]) report_room(e, i, &areas[i]);
    }
    report_holes(e);
    report_slits(e);
    report_plugs(e);
}

// ---- leaks: where rooms lie open to the outdoors, and the way from the room through the gap to the outside. The work for a room
// depends on its own gaps and faces, since plans that lie open in many places are common.

typedef struct LeakSearch {
    int *from;     // [face_count] half-edge that led into a face, -1: start
    int *reached;  // [face_count] number of the last search that reached the face
    int *queue;
    int search;
} LeakSearch;

typedef enum Ground { GROUND_ROOM, GROUND_AIR } Ground;

static bool belongs(const Spot *spot, Ground ground, int id) {
    return ground == GROUND_ROOM ? spot->indoor == id : spot_is_open(spot) && spot->indoor < 0;
}

// Breadth-first from face to face over one ground, until `goal` (a face, or -1: the edge of the world).
// Returns the face reached there, or -1.
static int find_way(const Plan *p, const Spot *spots, LeakSearch *way, int start, int goal, Ground ground,
                    int id) {
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
static void push_way(Enclosure *e, const LeakSearch *way, int face) {
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

// Lists all slits of a storey, space by space. Returns their number.
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

// Finds the largest face of each space of a storey: largest[ids], -1: none.
static void find_largest(const Plan *p, const Spot *spots, int *largest, int ids) {
    for (int id = 0; id < ids; id++) largest[id] = -1;
    for (int f = 0; f < p->face_count; f++) {
        int id = spots[f].indoor;
        if (id < 0 || (largest[id] >= 0 && p->faces[f].area <= p->faces[largest[id]].area)) continue;
        largest[id] = f;
    }
}

// Notes the leak of the space that holds the face `start`, with the way out through `gap`.
static void note_leak(Enclosure *e, const Spot *spots, int storey, int start, Gap gap, LeakSearch *way) {
    const Plan *p = &e->pass.plan;
    int id = spots[start].indoor, in = half_left(p, gap.half), out = half_right(p, gap.half);
    bool room = id < e->sketch->room_count;
    Vec3 inner = enclose_place(e, p->faces[start].inner, storey), hole = enclose_place(e, gap.middle, storey);
    building_note(e->arena, e->b, NOTE_LEAK, hole, "%s is open to the outdoors over %.2f m at (%.2f, %.2f)",
                  room ? enclose_text(e->sketch->rooms[id].place)
                       : arena_format(e->scratch, "a space at (%.2f, %.2f)", inner.x, inner.y),
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
    LeakSearch way = {.from = ARENA_ARRAY(a, int, p->face_count),
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
