// query_walk.c - the view followed through portals where there is no tree (after Luebke & Georges 1995).
//
// They follow every way, and in an open plan there are more ways than can be followed. So what is in view of a portal is
// gathered over all ways to it, as one convex polygon, and the view goes on from there once: portals wait in a queue, the
// nearest first, and most have been reached by all their ways when their turn comes. Where one is reached again by a way
// that shows more of it, the view goes on again with the larger polygon, and after a few times with all the eye could
// see of it. So more may be found than is seen, and never less.
#include <string.h>

#include "engine/core/heap.h"
#include "visibility/query/query.h"

// Times that the view goes on through a portal before it takes all of it: with the nearest first, few go on twice.
enum { PASSES = 3 };

// The view through a block of ways, a lane or a bit for each way.
typedef struct ViewBlock {
    Slots slots;         // of upright rectangles; of others see Sloped
    FourFloat distance;  // as ViewPart's: it only orders
    // The ways of which a part is in view so far; those which let all of the view pass; are seen edge-on; can show no more;
    // are in the queue; were gone through PASSES times.
    unsigned char part, all, edge, whole, queued, spent;
    unsigned char passes[FOUR];  // how often they were gone through
} ViewBlock;

// ---- polygons in a portal's plane

// A corner's place in the plane, of which one coordinate is left out, and where it came from.
typedef struct Corner {
    double x, y;
    const Vec3 *p;
} Corner;

// Turned so that corners counter-clockwise about n are so here.
static Corner flatten(const Vec3 *p, Vec3 n) {
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    if (z >= x && z >= y) return n.z > 0 ? (Corner){p->x, p->y, p} : (Corner){p->y, p->x, p};
    if (y >= x) return n.y > 0 ? (Corner){p->z, p->x, p} : (Corner){p->x, p->z, p};
    return n.x > 0 ? (Corner){p->y, p->z, p} : (Corner){p->z, p->y, p};
}

static double corner_turn(const Corner *a, const Corner *b, const Corner *c) {
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

// The convex hull of two polygons in a portal's plane, counter-clockwise about n (A. M. Andrew 1979); returns its corners.
static int hull_of_both(const Vec3 *a, int a_count, const Vec3 *b, int b_count, Vec3 n, Vec3 *out) {
    Corner sorted[VIEW_CORNERS + MAX_CORNERS];
    const Corner *chain[2 * (VIEW_CORNERS + MAX_CORNERS)];
    int count = a_count + b_count, kept = 0;
    for (int i = 0; i < count; i++) {
        Corner next = flatten(i < a_count ? &a[i] : &b[i - a_count], n);
        int at = i;
        for (; at > 0; at--) {
            const Corner *last = &sorted[at - 1];
            if (last->x < next.x || (last->x == next.x && last->y <= next.y)) break;
            sorted[at] = *last;
        }
        sorted[at] = next;
    }
    for (int back = 0; back < 2; back++) {
        int least = kept;
        for (int i = 0; i < count; i++) {
            const Corner *next = &sorted[back ? count - 1 - i : i];
            while (kept >= least + 2 && corner_turn(chain[kept - 2], chain[kept - 1], next) <= 0) kept--;
            chain[kept++] = next;
        }
        kept--;  // it begins the way back
    }
    for (int i = 0; i < kept; i++) out[i] = *chain[i]->p;
    return kept;
}

// Is all of `part` in the polygon? Both lie in the portal's plane.
static bool polygon_holds(const Sloped *view, const ViewPart *part, Vec3 n) {
    for (int i = 0; i < view->count; i++) {
        Vec3 a = view->v[i], edge = vec3_sub(view->v[i + 1 == view->count ? 0 : i + 1], a);
        Vec3 inward = vec3_cross(n, edge);
        double slack = POSITION_SLACK * vec3_length(edge);
        for (int k = 0; k < part->count; k++) {
            if (vec3_dot(inward, vec3_sub(part->polygon[k], a)) < -slack) return false;
        }
    }
    return view->count > 0;
}

// ---- the cache: a query seldom meets data for the second time, and they come from afar

// Fetches the cell beyond a way in the queue.
static void prefetch_beyond(const VisQuery *q, int way) {
    const WayBlock *ways = &q->ways[way / FOUR];
    int block = ways->beyond[way % FOUR] & ~WAY_DOOR;
    const char *first = (const char *)&q->ways[block], *views = (const char *)&q->views[block];
    __builtin_prefetch(&q->of_cell[ways->cell[way % FOUR]]);
    for (size_t line = 0; line < sizeof(WayBlock); line += CACHE_LINE) __builtin_prefetch(first + line);
    for (size_t line = 0; line < sizeof(ViewBlock); line += CACHE_LINE) __builtin_prefetch(views + line, 1);
}

// ---- the queue: a heap of ways, under the bits of their distances, which are in order

static uint64_t key_of(float distance, int way) {
    uint32_t bits;
    memcpy(&bits, &distance, sizeof bits);
    return (uint64_t)bits << 32 | (uint32_t)way;
}

static bool is_nearer_key(const void *context, const void *a, const void *b) {
    (void)context;
    return *(const uint64_t *)a < *(const uint64_t *)b;
}

static inline Heap queue_of(const VisQuery *q) {
    return (Heap){.items = q->queue, .size = sizeof *q->queue, .before = is_nearer_key};
}

// Into the queue, or nearer its head: it was `before` away.
static void enqueue(VisQuery *q, ViewBlock *view, int way, float before) {
    int lane = way % FOUR, at = q->queue_count;
    if (view->queued >> lane & 1) {
        if (view->distance[lane] == before) return;
        for (at = 0; (uint32_t)q->queue[at] != (uint32_t)way;) at++;
    } else {
        view->queued |= (unsigned char)(1u << lane);
        q->queue_count++;
        prefetch_beyond(q, way);
    }
    uint64_t key = key_of(view->distance[lane], way);
    const Heap heap = queue_of(q);
    heap_rise(&heap, at, &key);
}

static int take_nearest(VisQuery *q) {
    int nearest = (int)(uint32_t)q->queue[0];
    const Heap heap = queue_of(q);
    heap_drop_first(&heap, q->queue_count--);
    return nearest;
}

// ---- the visible parts of portals

static ViewBlock *view_of(VisQuery *q, int block) {
    ViewBlock *view = &q->views[block];
    if (q->view_frame[block] == q->frame) return view;
    q->view_frame[block] = q->frame;
    view->distance = (FourFloat){INFINITY, INFINITY, INFINITY, INFINITY};
    view->part = view->all = view->edge = view->whole = view->queued = view->spent = 0;
    memset(view->passes, 0, sizeof view->passes);
    return view;
}

static void approach(ViewBlock *view, int lane, double distance) {
    view->distance[lane] = fminf(view->distance[lane], (float)distance);
}

// ---- of portals that are no upright rectangles

static void take_polygon(VisQuery *q, ViewBlock *view, int lane, const ViewWay *way, const ViewPart *part) {
    unsigned char bit = (unsigned char)(1u << lane);
    approach(view, lane, part->distance);
    if (part->count > VIEW_CORNERS) {
        view->all |= bit;
        return;
    }
    Sloped *sloped = &q->sloped[way->sloped];
    view->part |= bit;
    sloped->count = part->count;
    memcpy(sloped->v, part->polygon, (size_t)part->count * sizeof *part->polygon);
}

// The portal is seen a second time: adds the new part to its visible part; false where there is none.
static bool widen_polygon(VisQuery *q, ViewBlock *view, int lane, const ViewWay *way, const ViewPart *part) {
    const Sloped *known = &q->sloped[way->sloped];
    Vec3 n = way->plane.n, hull[2 * (VIEW_CORNERS + MAX_CORNERS)];
    if (polygon_holds(known, part, n)) return false;
    ViewPart both = {.distance = part->distance, .polygon = hull};
    both.count = hull_of_both(known->v, known->count, part->polygon, part->count, n, hull);
    if (both.count > VIEW_CORNERS) view->spent |= (unsigned char)(1u << lane);
    if (both.count >= 3 && both.count <= VIEW_CORNERS) take_polygon(q, view, lane, way, &both);
    return true;
}

// Adds the seen part of a portal to its visible part; false where none of it is new.
static bool widen_view(VisQuery *q, ViewBlock *view, int lane, const ViewWay *way, Passage passage,
                       ViewPart *part) {
    unsigned char bit = (unsigned char)(1u << lane);
    if (passage != PASSAGE_PART) {
        if (passage == PASSAGE_ALL) view->all |= bit;
        if (passage == PASSAGE_EDGE) view->edge |= bit, view->whole |= bit;
        approach(view, lane, part->distance);
        return true;
    }
    if (!(view->part & bit)) {
        take_polygon(q, view, lane, way, part);
    } else if (!widen_polygon(q, view, lane, way, part)) {
        return false;
    }
    if (!(view->spent & bit)) return true;
    // Takes all of the portal that the eye could see by any way. But for slack it sees some of it.
    view->whole |= bit;
    if (query_clip(q, &q->cones[0], way, part) == PASSAGE_PART) take_polygon(q, view, lane, way, part);
    return true;
}

static void look_through(VisQuery *q, Cone *cone, int index, int but) {
    ViewWay way = query_way(q, index);
    if (way.portal == but) return;
    ViewPart part;
    Passage passage = query_clip(q, cone, &way, &part);
    if (passage == PASSAGE_NONE) return;
    ViewBlock *view = view_of(q, index / FOUR);
    int lane = index % FOUR;
    if ((view->all | view->whole) >> lane & 1) return;
    float before = view->distance[lane];
    if (widen_view(q, view, lane, &way, passage, &part)) enqueue(q, view, index, before);
}

// ---- of upright rectangles

static void put_slots(ViewBlock *view, unsigned lanes, const Slots *from, Four distance) {
    FourMask mask = four_mask(lanes);
    Slots *to = &view->slots;
    if (!view->part) {
        *to = *from;  // without waiting for the old value
    } else {
        to->s0 = four_choose(mask, from->s0, to->s0);
        to->s1 = four_choose(mask, from->s1, to->s1);
        to->bottom = query_choose_edge(mask, from->bottom, to->bottom);
        to->top = query_choose_edge(mask, from->top, to->top);
    }
    distance = four_choose(mask, distance, four_of(INFINITY));
    view->distance = four_to_float(four_least(distance, four_from_float(view->distance)));
    view->part |= (unsigned char)lanes;
}

// Takes all of these that the eye could see by any way.
static void take_whole(VisQuery *q, ViewBlock *view, int block, unsigned lanes) {
    Sight sight;
    view->whole |= (unsigned char)lanes;
    query_sight(q, &q->cones[0], block, lanes, &sight);
    // But for slack it sees something.
    if (sight.slots)
        put_slots(view, sight.slots, &sight.slot, query_slots_distance(&sight.slot, sight.ahead));
}

// Goes on through those of which something new is seen.
static void widen_slots(VisQuery *q, int block, const Sight *sight) {
    ViewBlock *view = view_of(q, block);
    unsigned lanes = sight->slots & ~(unsigned)view->whole, known = lanes & view->part;
    if (known) lanes &= ~(known & query_slots_hold(&view->slots, &sight->slot));
    if (!lanes) return;
    Four distance = query_slots_distance(&sight->slot, sight->ahead);
    FourFloat before = view->distance;
    known &= lanes;
    if (lanes & ~known) put_slots(view, lanes & ~known, &sight->slot, distance);
    if (known) {
        Slots both;
        query_slots_join(&q->ways[block], q->eye->position, &view->slots, &sight->slot, &both);
        put_slots(view, known, &both, distance);
        if (lanes & view->spent) take_whole(q, view, block, lanes & view->spent);
    }
    for (; lanes; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        enqueue(q, view, block * FOUR + lane, before[lane]);
    }
}

// ---- the walk

// Through all portals of a cell, but not back through the way come by.
static void look_around(VisQuery *q, Cone *cone, int cell, int by) {
    const CellView *of = &q->of_cell[cell];
    for (int block = of->first_block; block < of->first_block + of->block_count; block++) {
        Sight sight;
        unsigned lanes = query_sight(q, cone, block, four_in_set(q->limit, q->ways[block].cell), &sight);
        q->result.portals_tested += __builtin_popcount(lanes);
        if (sight.slots) widen_slots(q, block, &sight);
        // The eye is before one side of an upright rectangle alone, unless the rectangle is among these.
        for (unsigned others = sight.others; others; others &= others - 1)
            look_through(q, cone, block * FOUR + __builtin_ctz(others), by < 0 ? -1 : q->portal_of[by]);
    }
}

// The cone beyond a way that is no upright rectangle, or of which not a slot is seen.
static void cone_beyond(VisQuery *q, const ViewBlock *view, int index, Cone *out) {
    ViewWay way = query_way(q, index);
    bool all = view->all >> index % FOUR & 1, edge = view->edge >> index % FOUR & 1;
    ViewPart part = {.count = 0};
    if (edge) {
        const Portal *portal = &q->graph->portals[way.portal];
        part.polygon = q->graph->portal_vertices + portal->first_vertex;
        part.count = portal->vertex_count;
    } else if (!all) {
        const Sloped *sloped = &q->sloped[way.sloped];
        part.polygon = sloped->v;
        part.count = sloped->count;
        part.middle = vec3(0, 0, 0);
        for (int i = 0; i < part.count; i++)
            part.middle = vec3_add(part.middle, vec3_sub(sloped->v[i], q->eye->position));
    }
    query_beyond(q, &q->cones[0], all ? PASSAGE_ALL : edge ? PASSAGE_EDGE : PASSAGE_PART, &way, &part, out);
}

// Where the view will most likely go next.
static int next_cell(const VisQuery *q) {
    uint32_t way = (uint32_t)q->queue[0];
    return q->ways[way / FOUR].cell[way % FOUR];
}

void query_prepare_walk(VisQuery *q, Arena *arena) {
    q->views = ARENA_ARRAY(arena, ViewBlock, q->block_count);
    q->view_frame = ARENA_ARRAY(arena, unsigned, q->block_count);
    q->queue = ARENA_ARRAY(arena, uint64_t, FOUR * q->block_count);
}

void query_walk(VisQuery *q, int cell) {
    q->queue_count = 0;
    look_around(q, &q->cones[0], cell, -1);
    while (q->queue_count > 0) {
        int nearest = take_nearest(q), lane = nearest % FOUR;
        const WayBlock *ways = &q->ways[nearest / FOUR];
        ViewBlock *view = &q->views[nearest / FOUR];
        unsigned bit = 1u << lane;
        query_prefetch_boxes(q, ways->cell[lane]);
        if (q->queue_count > 0) query_prefetch_boxes(q, next_cell(q));
        view->queued &= (unsigned char)~bit;
        if (++view->passes[lane] >= PASSES) view->spent |= (unsigned char)bit;
        Cone beyond;
        if ((view->all | view->edge) & bit || ways->s0[lane] > ways->s1[lane]) {
            cone_beyond(q, view, nearest, &beyond);
        } else {
            query_slot_cone(&view->slots, ways, lane, q->eye->position, q->culling == CULL_PLAN, &beyond);
        }
        // On while the boxes come.
        if (!query_door_closed(q, nearest)) look_around(q, &beyond, ways->cell[lane], nearest);
        query_enter(q, nearest, &beyond, view->distance[lane]);
    }
}
