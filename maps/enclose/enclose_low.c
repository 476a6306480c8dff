// enclose_low.c - which walls lower than their storey bound rooms all the same. The rule and its reason stand at SketchWall (sketch.h).
//
// In the first attempt at a plan all walls that may bound rooms do. Here each is asked which spaces lie on either side of it; those that
// part none are taken away, one after the other, until the rest all bound. The plan is then made again with the rest.
#include "maps/enclose/enclose.h"

// A wall reaches a ceiling when it comes this near to it, metres.
static const double CEILING_SLACK = 0.01;
// A space between walls and the outdoors is a room where rooms with a ceiling are drawn over this share of it.
static const double ROOM_SHARE = 0.5;
// Walls are taken away in rounds; walls that no round of these has come to bound.
enum { ROUNDS = 32 };

// The spaces beside one part of a wall, and their ceilings.
typedef struct Beside {
    int first, other;  // two of its spaces, -1: there are fewer
    bool outdoors, room;
    bool ceiling, reached;  // there are ceilings, and the wall reaches all of them
} Beside;

// One storey while its low walls are judged. Spaces are sets of open faces, named by their leader; number face_count stands for the space
// beyond the world. A room that lies open to the outdoors by a hole in its walls is a space of its own.
typedef struct LowSearch {
    Enclosure *e;
    const Plan *plan;
    const Spot *spots;
    int storey;
    int *space;  // [face_count + 1] sets of open faces
    double *area,
        *roofed;  // [face_count + 1] mm^2 of the space that a face leads: all of it, and under drawn ceilings
    bool *open;   // [face_count]
    bool *low, *gone;  // [wall_count] walls that are judged, and those that were taken away
    int *part;         // [face_count] sets of a wall's own faces that hang together
    int *owner,
        *place;  // [face_count] the wall (plus 1) for which `part` holds, and the face's place among its faces
    Beside *beside;  // [beside_count] of the wall's own faces
    int beside_count;
} LowSearch;

bool enclose_may_bound(const Enclosure *e, int wall) {
    const SketchWall *w = &e->sketch->walls[wall];
    const Storey *storey = &e->b->storeys[w->storey];
    return !e->wall_low[wall] && w->z1 >= storey->floor + SKETCH_LEAST_ROOM &&
           w->z1 < storey->floor + storey->height - CEILING_SLACK;
}

// Whether all walls over a face are among those marked.
static bool covered_by(const LowSearch *s, int face, const bool *marked) {
    const Pass *pass = &s->e->pass;
    for (int i = pass->cover_first[face]; i < pass->cover_first[face + 1]; i++) {
        int w = pass->cover_wall[i];
        if (s->e->sketch->walls[w].storey == s->storey && !marked[w]) return false;
    }
    return true;
}

// Whether one sees from face to face. Where a wall was taken away, it hid nothing.
static bool connects(const LowSearch *s, int f, int g) {
    const Spot *a = &s->spots[f], *b = &s->spots[g];
    bool leak = spot_is_open(a) && spot_is_open(b) && (a->indoor >= 0) != (b->indoor >= 0);
    return s->open[f] && s->open[g] && !leak;
}

static void unite_open(LowSearch *s) {
    const Plan *p = s->plan;
    int world = p->face_count;
    for (int i = 0; i < p->edge_count; i++) {
        int f = p->edges[i].face[0], g = p->edges[i].face[1];
        if (f < 0 || g < 0) {
            if (f + g + 1 >= 0 && s->open[f + g + 1]) set_unite(s->space, world, f + g + 1);
        } else if (connects(s, f, g)) {
            set_unite(s->space, f, g);
        }
    }
    for (int f = 0; f <= world; f++) s->area[f] = s->roofed[f] = 0;
    for (int f = 0; f < world; f++) {
        int room = s->spots[f].room, leader = set_find(s->space, f);
        if (!s->open[f]) continue;
        s->area[leader] += p->faces[f].area;
        if (room >= 0 && !s->e->sketch->rooms[room].open_above) s->roofed[leader] += p->faces[f].area;
    }
}

// The height of the ceiling over an open face as drawn, metres; NAN: it has none, for it is outdoors.
static double ceiling_over(const LowSearch *s, int face) {
    const Storey *storey = &s->e->b->storeys[s->storey];
    // Strips that nobody drew belong to the room beside them.
    int indoor = s->spots[face].indoor, room = s->spots[face].room;
    if (indoor >= 0 && indoor < s->e->sketch->room_count) room = indoor;
    bool outdoors = set_find(s->space, face) == set_find(s->space, s->plan->face_count);
    if (room >= 0 && !isnan(s->e->sketch->rooms[room].z1)) return s->e->sketch->rooms[room].z1;
    return outdoors && room < 0 ? NAN : storey->floor + storey->height;
}

static void look_beside(const LowSearch *s, int wall, int face, Beside *beside) {
    const Plan *p = s->plan;
    for (int k = 0; k < p->faces[face].half_count; k++) {
        int g = half_right(p, p->halves[p->faces[face].first_half + k]);
        if (g >= 0 && !s->open[g]) continue;
        int space = set_find(s->space, g < 0 ? p->face_count : g);
        if (beside->first < 0) beside->first = space;
        if (space != beside->first && beside->other < 0) beside->other = space;
        bool outdoors = space == set_find(s->space, p->face_count);
        beside->outdoors = beside->outdoors || outdoors;
        beside->room = beside->room || (!outdoors && s->roofed[space] >= ROOM_SHARE * s->area[space]);
        double ceiling = g < 0 ? NAN : ceiling_over(s, g);
        if (isnan(ceiling)) continue;
        beside->ceiling = true;
        if (s->e->sketch->walls[wall].z1 < ceiling - CEILING_SLACK) beside->reached = false;
    }
}

static bool bounds(const Beside *beside) {
    if (beside->ceiling && beside->reached) return true;
    return beside->other >= 0 && (!beside->outdoors || beside->room);
}

// Puts the wall's own faces, those that no wall as high as the storey covers, into e->faces.
static void find_own(LowSearch *s, int wall) {
    BoxHits *faces = &s->e->faces;
    int kept = 0;
    for (int i = plan_faces_in(s->e, s->plan, &s->e->walls[wall]), k = 0; k < i; k++) {
        int f = faces->items[k];
        if (!covered_by(s, f, s->low)) continue;
        s->owner[f] = wall + 1;
        s->part[f] = f;
        s->place[f] = kept;
        faces->items[kept++] = f;
    }
    faces->count = kept;
}

// A wall that ends in a higher one may look out on its far side: each part of its own faces is judged by itself.
static bool wall_bounds(LowSearch *s, int wall) {
    const Plan *p = s->plan;
    find_own(s, wall);
    const BoxHits *own = &s->e->faces;
    for (int i = 0; i < own->count; i++) {
        const PlanFace *face = &p->faces[own->items[i]];
        for (int k = 0; k < face->half_count; k++) {
            int g = half_right(p, p->halves[face->first_half + k]);
            if (g >= 0 && s->owner[g] == wall + 1) set_unite(s->part, own->items[i], g);
        }
    }
    if (own->count > s->beside_count) {
        s->beside_count = 2 * own->count;
        s->beside = ARENA_ARRAY(s->e->scratch, Beside, s->beside_count);
    }
    for (int i = 0; i < own->count; i++) s->beside[i] = (Beside){.first = -1, .other = -1, .reached = true};
    for (int i = 0; i < own->count; i++)
        look_beside(s, wall, own->items[i], &s->beside[s->place[set_find(s->part, own->items[i])]]);
    for (int i = 0; i < own->count; i++)
        if (bounds(&s->beside[i])) return true;
    return false;
}

static void take_away(LowSearch *s, int wall) {
    s->gone[wall] = true;
    s->e->wall_low[wall] = true;
    find_own(s, wall);
    for (int i = 0; i < s->e->faces.count; i++) {
        int f = s->e->faces.items[i];
        if (s->spots[f].hole[0] < 0 && covered_by(s, f, s->gone)) s->open[f] = true;
    }
}

// Whether walls of the storey were taken away.
static bool settle_storey(LowSearch *s) {
    const Sketch *sketch = s->e->sketch;
    int faces = s->plan->face_count, *list = ARENA_ARRAY(s->e->scratch, int, sketch->wall_count);
    int low = 0, before = 0;
    for (int i = 0; i < sketch->wall_count; i++) {
        s->low[i] =
            s->e->wall_bounds[i] && sketch->walls[i].storey == s->storey && enclose_may_bound(s->e, i);
        if (s->low[i]) list[low++] = i;
    }
    before = low;
    for (int f = 0; f < faces; f++) {
        s->space[f] = f;
        s->owner[f] = 0;
        s->open[f] = spot_is_open(&s->spots[f]) || s->spots[f].wall == WALL_CAVITY;
    }
    s->space[faces] = faces;
    for (int round = 0; low > 0 && round < ROUNDS; round++) {
        int kept = 0, gone = 0;
        int *leave = ARENA_ARRAY(s->e->scratch, int, low);
        unite_open(s);
        for (int i = 0; i < low; i++) {
            if (wall_bounds(s, list[i]))
                list[kept++] = list[i];
            else
                leave[gone++] = list[i];
        }
        for (int i = 0; i < gone; i++) take_away(s, leave[i]);
        low = kept;
        if (gone == 0) break;
    }
    return low < before;
}

bool enclose_settle_low_walls(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    Arena *a = e->scratch;
    LowSearch s = {.e = e,
                   .plan = p,
                   .space = ARENA_ARRAY(a, int, p->face_count + 1),
                   .area = ARENA_ARRAY(a, double, p->face_count + 1),
                   .roofed = ARENA_ARRAY(a, double, p->face_count + 1),
                   .open = ARENA_ARRAY(a, bool, p->face_count),
                   .low = ARENA_ARRAY(a, bool, e->sketch->wall_count),
                   .gone = ARENA_ARRAY(a, bool, e->sketch->wall_count),
                   .part = ARENA_ARRAY(a, int, p->face_count),
                   .owner = ARENA_ARRAY(a, int, p->face_count),
                   .place = ARENA_ARRAY(a, int, p->face_count)};
    bool changed = false;
    for (s.storey = 0; s.storey < e->b->storey_count; s.storey++) {
        s.spots = e->pass.spots + (size_t)s.storey * (size_t)p->face_count;
        changed = settle_storey(&s) || changed;
    }
    return changed;
}
