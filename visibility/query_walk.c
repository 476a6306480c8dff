// query_walk.c - the view followed through portals where there is no tree (after Luebke & Georges 1995).
//
// They follow every way, and in an open plan there are more ways than can be followed. So what is in view of a portal is
// gathered over all ways to it, as one convex polygon, and the view goes on from there once: portals wait in a queue, the
// nearest first, and most have been reached by all their ways when their turn comes. Where one is reached again by a way
// that shows more of it, the view goes on again with the larger polygon, and after a few times with all the eye could
// see of it. So more may be found than is seen, and never less.
#include <string.h>

#include "engine/core/error.h"
#include "visibility/query.h"

// Times that the view goes on through a portal before it takes all of it: with the nearest first, few go on twice.
enum { PASSES = 3 };

// ---- the queue

static bool nearer(const VisQuery *q, int a, int b) {
    double more = q->views[a].distance - q->views[b].distance;
    return more < 0 || (more == 0 && a < b);
}

static void place(VisQuery *q, int at, int way) {
    q->queue[at] = way;
    q->views[way].place = at;
}

// Into the queue, or nearer its head.
static void raise_way(VisQuery *q, int way) {
    int at = q->views[way].place >= 0 ? q->views[way].place : q->queue_count++;
    for (; at > 0 && nearer(q, way, q->queue[(at - 1) / 2]); at = (at - 1) / 2)
        place(q, at, q->queue[(at - 1) / 2]);
    place(q, at, way);
}

static int take_nearest(VisQuery *q) {
    int nearest = q->queue[0], last = q->queue[--q->queue_count], at = 0;
    q->views[nearest].place = -1;
    if (q->queue_count == 0) return nearest;
    for (;;) {
        int child = 2 * at + 1;
        if (child >= q->queue_count) break;
        if (child + 1 < q->queue_count && nearer(q, q->queue[child + 1], q->queue[child])) child++;
        if (!nearer(q, q->queue[child], last)) break;
        place(q, at, q->queue[child]);
        at = child;
    }
    place(q, at, last);
    return nearest;
}

// ---- polygons in a portal's plane

// A corner's place in the plane, of which one coordinate is left out, and where it came from.
typedef struct Corner {
    double x, y;
    const Vec3 *p;
} Corner;

// So turned that what runs counter-clockwise about n does so here.
static Corner flatten(const Vec3 *p, Vec3 n) {
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    if (z >= x && z >= y) return n.z > 0 ? (Corner){p->x, p->y, p} : (Corner){p->y, p->x, p};
    if (y >= x) return n.y > 0 ? (Corner){p->z, p->x, p} : (Corner){p->x, p->z, p};
    return n.x > 0 ? (Corner){p->y, p->z, p} : (Corner){p->z, p->y, p};
}

static double turn(const Corner *a, const Corner *b, const Corner *c) {
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

// The convex hull, counter-clockwise about n (A. M. Andrew 1979).
static int hull_of(const Vec3 *a, int a_count, const Vec3 *b, int b_count, Vec3 n, Vec3 *out) {
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
            while (kept >= least + 2 && turn(chain[kept - 2], chain[kept - 1], next) <= 0) kept--;
            chain[kept++] = next;
        }
        kept--;  // it begins the way back
    }
    for (int i = 0; i < kept; i++) out[i] = *chain[i]->p;
    return kept;
}

// Is all of `part` in what the view has come through before? Both lie in the portal's plane.
static bool holds(const PortalView *view, const ViewPart *part, Vec3 n) {
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

// ---- the walk

static PortalView *view_of(VisQuery *q, int way) {
    PortalView *view = &q->views[way];
    if (view->frame == q->frame) return view;
    view->frame = q->frame;
    view->passage = PASSAGE_NONE;
    view->whole = false;
    view->passes = view->count = 0;
    view->place = -1;
    view->distance = INFINITY;
    return view;
}

static void take(PortalView *view, const Vec3 *polygon, int count) {
    view->count = count;
    if (count > VIEW_CORNERS) view->passage = PASSAGE_ALL;
    if (count <= VIEW_CORNERS) memcpy(view->v, polygon, (size_t)count * sizeof *polygon);
}

// Takes all that the eye could see of the portal by any way.
static void take_whole(VisQuery *q, PortalView *view, const Gate *gate) {
    ViewPart whole;
    view->whole = true;
    if (query_clip(q, &q->cones[0], gate, &whole) == PASSAGE_NONE) return;  // but for slack it sees nothing
    view->distance = fmin(view->distance, whole.distance);
    take(view, whole.polygon, whole.count);
}

// Takes what is new into the view; false where nothing is.
static bool widen(VisQuery *q, PortalView *view, const Gate *gate, Passage passage, const ViewPart *part) {
    Vec3 n = q->graph->portals[gate->portal].plane.n, hull[2 * (VIEW_CORNERS + MAX_CORNERS)];
    if (view->count > 0 && holds(view, part, n)) return false;
    view->passage = passage;
    view->distance = fmin(view->distance, part->distance);
    if (passage == PASSAGE_ALL) return true;
    if (view->count == 0) {
        take(view, part->polygon, part->count);
    } else {
        int count = hull_of(view->v, view->count, part->polygon, part->count, n, hull);
        if (count > VIEW_CORNERS) view->passes = PASSES;
        if (count >= 3 && count <= VIEW_CORNERS) take(view, hull, count);
    }
    if (passage == PASSAGE_EDGE || view->passes >= PASSES) take_whole(q, view, gate);
    return true;
}

static void look_through(VisQuery *q, const Cone *cone, const Gate *gate) {
    PortalView *view = view_of(q, gate->way);
    if (view->passage == PASSAGE_ALL || view->whole) return;
    ViewPart part;
    Passage passage = query_clip(q, cone, gate, &part);
    if (passage != PASSAGE_NONE && widen(q, view, gate, passage, &part)) raise_way(q, gate->way);
}

// Through all portals of a cell but the one come by.
static void look_around(VisQuery *q, const Cone *cone, int c, int but) {
    const Cell *cell = &q->graph->cells[c];
    const Gate *end = q->gates + cell->first_contact + cell->contact_count;
    for (const Gate *gate = q->gates + cell->first_contact; gate < end; gate++) {
        bool hidden = q->limit && !(q->limit[gate->cell / 64] >> (gate->cell % 64) & 1);
        if (hidden || gate->portal == but) continue;
        if (plane_distance(gate->plane, q->eye->position) < -ON_PLANE) continue;
        look_through(q, cone, gate);
    }
}

// The middle of what is in view of a portal, from the eye.
static Vec3 middle_of(const PortalView *view, Vec3 eye) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < view->count; i++) sum = vec3_add(sum, vec3_sub(view->v[i], eye));
    return sum;
}

void query_walk(VisQuery *q, int cell) {
    q->queue_count = 0;
    look_around(q, &q->cones[0], cell, -1);
    while (q->queue_count > 0) {
        int way = take_nearest(q);
        const Gate *gate = &q->gates[q->gate_of[way]];
        PortalView *view = &q->views[way];
        view->passes++;
        ViewPart part;
        part.polygon = view->v;
        part.count = view->count;
        part.middle = middle_of(view, q->eye->position);
        Cone beyond;
        query_beyond(q, &q->cones[0], view->passage, gate, &part, &beyond);
        if (query_enter(q, gate, &beyond, view->distance)) look_around(q, &beyond, gate->cell, gate->portal);
    }
}
