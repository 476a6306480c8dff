// enclose_crossings.c - outlines that cross so many others that the plan would fall into more pieces than a scene needs.
//
// n walls may cross at n^2 places, and each place is a vertex of the plan. Outlines are taken in their order, each if the places
// where it meets the outlines before it do not make too many in all. A wall that is not taken becomes an object: it is drawn,
// collides and casts shadows, but it divides no space, so that more counts as visible than can be seen. Rooms, cut-outs and
// openings that are not taken are left out, and noted.
#include <stdlib.h>

#include "maps/enclose/enclose.h"

// The most places where outlines may meet: MEETINGS, and MEETINGS_EACH more for each outline. Walls of real
// buildings meet two or three others.
static const long long MEETINGS = 10000, MEETINGS_EACH = 6;
// The most corners on edges of other outlines: each is a vertex anyway, and storeys that differ little have many on one line.
// Where there are many outlines, TOUCHES_EACH for each: the four corners of an opening lie on edges of its wall and of the rooms.
static const long long TOUCHES = 500000, TOUCHES_EACH = 16;
// The most pairs of edges that may be looked at to find these places: LOOKS, and LOOKS_AN_EDGE more for each edge.
static const long long LOOKS = 4000000, LOOKS_AN_EDGE = 32;
// The most pairs for the first outline, which may be the only one and have very many corners.
static const long long LOOKS_FIRST = 12000000;
// An end this near to another edge lies on that edge, mm.
static const double ON_EDGE = 1;

typedef struct PlanSegment {
    Vec2 a, b;   // a before b, by x, then y
    bool fresh;  // of the outline tried last: no outline taken before has it
    int same;    // the first segment that equals this one: walls of a tower stand over one another
} PlanSegment;

// The outlines taken so far, against which the next ones are tried.
typedef struct Crossings {
    Enclosure *e;
    PlanSegment *segments;
    int segment_count, segment_capacity;
    int *first;  // [outline_count + 1] the first segment of each outline
    int outline_count, outline_capacity;
    bool *taken;  // [segment_count] of the first of equal segments: an outline that was taken has it
    BoxTree tree;
    long long meetings, touches, looks;  // so far
    long long outlines;                  // taken so far, except those on others
    bool any;                            // an outline was taken
    // Why the outline tried last was not taken: too many looks, or too many outlines for the number of storeys. Neither: too many
    // meetings.
    bool looked_out, crowded;
} Crossings;

static PlanSegment segment_between(Vec2 a, Vec2 b) {
    bool turn = a.x != b.x ? a.x > b.x : a.y > b.y;
    return turn ? (PlanSegment){b, a, false, -1} : (PlanSegment){a, b, false, -1};
}

static void add_outline(Crossings *c, const Shape *shape, bool use) {
    Arena *a = c->e->scratch;
    *ARENA_PUSH(a, c->first, c->outline_count, c->outline_capacity) = c->segment_count;
    for (int r = 0; use && r < shape->ring_count; r++) {
        for (int i = shape->ring[r], j = shape->ring[r + 1] - 1; i < shape->ring[r + 1]; j = i++)
            *ARENA_PUSH(a, c->segments, c->segment_count, c->segment_capacity) =
                segment_between(shape->points[j], shape->points[i]);
    }
}

static Box segment_box(const PlanSegment *s) {
    Vec2 low = vec2(fmin(s->a.x, s->b.x) - ON_EDGE, fmin(s->a.y, s->b.y) - ON_EDGE);
    Vec2 high = vec2(fmax(s->a.x, s->b.x) + ON_EDGE, fmax(s->a.y, s->b.y) + ON_EDGE);
    return enclose_box(low, high, 0);
}

static int compare_ends(const PlanSegment *s, const PlanSegment *t) {
    double p[4] = {s->a.x, s->a.y, s->b.x, s->b.y}, q[4] = {t->a.x, t->a.y, t->b.x, t->b.y};
    for (int i = 0; i < 4; i++)
        if (p[i] != q[i]) return p[i] < q[i] ? -1 : 1;
    return 0;
}

static int by_ends(const void *p, const void *q, void *segments) {
    int i = *(const int *)p, j = *(const int *)q;
    const PlanSegment *list = segments;
    int order = compare_ends(&list[i], &list[j]);
    return order ? order : (i > j) - (i < j);
}

static void index_segments(Crossings *c) {
    Box *boxes = ARENA_ARRAY(c->e->scratch, Box, c->segment_count);
    int *order = ARENA_ARRAY(c->e->scratch, int, c->segment_count);
    for (int i = 0; i < c->segment_count; i++) order[i] = i;
    qsort_r(order, (size_t)c->segment_count, sizeof *order, by_ends, c->segments);
    for (int i = 0, first = 0; i < c->segment_count; i++) {
        if (compare_ends(&c->segments[order[first]], &c->segments[order[i]]) != 0) first = i;
        c->segments[order[i]].same = order[first];
    }
    for (int i = 0; i < c->segment_count; i++)
        boxes[i] = c->segments[i].same == i ? segment_box(&c->segments[i]) : box_empty();
    c->tree = box_tree_build(boxes, c->segment_count, c->e->scratch);
    c->taken = ARENA_ARRAY(c->e->scratch, bool, c->segment_count);
    *ARENA_PUSH(c->e->scratch, c->first, c->outline_count, c->outline_capacity) = c->segment_count;
    c->outline_count--;
}

static bool lies_on(Vec2 p, const PlanSegment *s) {
    Vec2 d = vec2_sub(s->b, s->a), ap = vec2_sub(p, s->a);
    double length2 = vec2_dot(d, d), along = vec2_dot(ap, d), aside = vec2_cross(d, ap);
    return along > 0 && along < length2 && aside * aside <= ON_EDGE * ON_EDGE * length2;
}

// Whether the edges cross in one point within both.
static bool edges_cross(const PlanSegment *s, const PlanSegment *t) {
    Vec2 d = vec2_sub(s->b, s->a), g = vec2_sub(t->b, t->a);
    double p = vec2_cross(d, vec2_sub(t->a, s->a)), q = vec2_cross(d, vec2_sub(t->b, s->a));
    double u = vec2_cross(g, vec2_sub(s->a, t->a)), v = vec2_cross(g, vec2_sub(s->b, t->a));
    return p * q < 0 && u * v < 0;
}

// How many ends of the two edges lie on the other edge.
static int ends_on(const PlanSegment *s, const PlanSegment *t) {
    return lies_on(t->a, s) + lies_on(t->b, s) + lies_on(s->a, t) + lies_on(s->b, t);
}

// Takes an outline if it meets the outlines taken before at few enough places, and if the outlines taken are few enough: each makes
// at least one piece of the plan.
static bool take_outline(Crossings *c, int outline) {
    long long most = MEETINGS + MEETINGS_EACH * c->outline_count,
              looks = c->any ? LOOKS + LOOKS_AN_EDGE * c->segment_count : LOOKS_FIRST,
              spots = (long long)(c->e->share * ENCLOSE_MOST_SPOTS / 2 /
                                  (c->e->b->storey_count > 0 ? c->e->b->storey_count : 1)),
              most_touches = TOUCHES, count = 0, touches = 0;
    if (most > spots) most = spots;
    if (most_touches < TOUCHES_EACH * c->outline_count) most_touches = TOUCHES_EACH * c->outline_count;
    int end = c->first[outline];
    bool good = true, fresh = false;
    for (; end < c->first[outline + 1] && good; end++) {
        int i = end;
        c->segments[i].fresh = !c->taken[c->segments[i].same];
        if (!c->segments[i].fresh) continue;
        fresh = true;
        i = c->segments[i].same;
        long long before = c->e->near.looked;
        box_tree_find(&c->tree, c->tree.boxes[i], c->e->scratch, &c->e->near);
        c->looks += c->e->near.looked - before;
        for (int k = 0; k < c->e->near.count; k++) {
            int j = c->e->near.items[k];
            bool own = j >= c->first[outline] && j < c->first[outline + 1];
            if (!c->taken[j]) continue;
            if (edges_cross(&c->segments[i], &c->segments[j]))
                count++;
            else if (!own)
                touches += ends_on(&c->segments[i], &c->segments[j]);
        }
        c->taken[i] = true;
        good = c->meetings + count <= most && c->touches + touches <= most_touches && c->looks <= looks;
    }
    c->crowded = fresh && c->outlines >= 2 * spots;
    c->looked_out = c->looks > looks;
    good = good && !c->crowded;
    if (!c->any) c->looks = 0;
    if (good) {
        c->meetings += count;
        c->touches += touches;
        c->outlines += fresh;
        return c->any = true;
    }
    for (int i = c->first[outline]; i < end; i++)
        if (c->segments[i].fresh) c->taken[c->segments[i].same] = false;
    return false;
}

// ---- walls, rooms and cut-outs

static void leave_out(const Crossings *c, const Shape *shape, int storey, const char *what,
                      const char *place) {
    Enclosure *e = c->e;
    Vec3 p = enclose_place(e, shape->points[0], storey);
    if (c->looked_out)
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s %s left out: at (%.2f, %.2f) the edges of its outline (%d) lie among so many that "
                      "crossings cannot be looked for",
                      what, enclose_text(place), p.x, p.y, shape->ring[shape->ring_count]);
    else if (c->crowded)
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s %s left out: at (%.2f, %.2f) its outline would be one too many of %d storeys "
                      "(allowed here: %lld)",
                      what, enclose_text(place), p.x, p.y, e->b->storey_count, c->outlines);
    else
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s %s left out: at (%.2f, %.2f) its outline would be one too many that cross others",
                      what, enclose_text(place), p.x, p.y);
}

static Crossings crossings_of(Enclosure *e) {
    const Sketch *s = e->sketch;
    Crossings c = {.e = e};
    for (int i = 0; i < s->room_count; i++) add_outline(&c, &e->rooms[i], e->room_used[i]);
    for (int i = 0; i < s->cutout_count; i++) add_outline(&c, &e->cutouts[i], e->cutout_used[i]);
    for (int i = 0; i < s->wall_count; i++) add_outline(&c, &e->walls[i], e->wall_bounds[i]);
    return c;
}

void crossings_limit(Enclosure *e) {
    const Sketch *s = e->sketch;
    Crossings c = crossings_of(e);
    index_segments(&c);
    for (int i = 0; i < s->room_count; i++) {
        if (!e->room_used[i] || take_outline(&c, i)) continue;
        e->room_used[i] = false;
        enclose_lose_room(e, i);
        leave_out(&c, &e->rooms[i], s->rooms[i].storey, "room", s->rooms[i].place);
    }
    for (int i = 0; i < s->cutout_count; i++) {
        if (!e->cutout_used[i] || take_outline(&c, s->room_count + i)) continue;
        e->cutout_used[i] = false;
        leave_out(&c, &e->cutouts[i], s->cutouts[i].storey, "cut-out", s->cutouts[i].place);
    }
    int count = 0, first = -1;
    for (int i = 0; i < s->wall_count; i++) {
        if (!e->wall_bounds[i] || take_outline(&c, s->room_count + s->cutout_count + i)) continue;
        e->wall_bounds[i] = false;
        enclose_add_low_wall(e, i);
        if (count++ == 0) first = i;
    }
    if (count == 0) return;
    Vec3 p = enclose_place(e, e->walls[first].points[0], s->walls[first].storey);
    building_note(e->arena, e->b, NOTE_CHANGED, p,
                  "%d walls cross so many others that they part no rooms and stand as objects, the first of "
                  "them %s at (%.2f, %.2f)",
                  count, enclose_text(s->walls[first].place), p.x, p.y);
}

// ---- openings

void crossings_limit_holes(Enclosure *e) {
    const Sketch *s = e->sketch;
    Crossings c = crossings_of(e);
    for (int k = 0; k < e->b->storey_count; k++) {
        for (int i = 0; i < e->implicit[k].count; i++) add_outline(&c, &e->implicit[k].items[i], true);
    }
    int first = c.outline_count;
    for (int i = 0; i < s->opening_count; i++) add_outline(&c, &e->holes[i].box, e->holes[i].used);
    index_segments(&c);
    for (int i = 0; i < c.first[first]; i++) c.taken[c.segments[i].same] = true;
    c.any = true;
    for (int i = 0; i < s->opening_count; i++) {
        Hole *h = &e->holes[i];
        if (!h->used || take_outline(&c, first + i)) continue;
        h->used = false;
        leave_out(&c, &h->box, s->openings[i].storey, opening_kind_name(s->openings[i].kind),
                  s->openings[i].place);
    }
}
