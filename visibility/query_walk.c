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

static void place(VisQuery *q, int at, int gate) {
    q->queue[at] = gate;
    q->views[gate].place = at;
}

// Into the queue, or nearer its head.
static void raise_gate(VisQuery *q, int gate) {
    int at = q->views[gate].place >= 0 ? q->views[gate].place : q->queue_count++;
    for (; at > 0 && nearer(q, gate, q->queue[(at - 1) / 2]); at = (at - 1) / 2)
        place(q, at, q->queue[(at - 1) / 2]);
    place(q, at, gate);
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

// Is all of `part` in the polygon? Both lie in the portal's plane.
static bool holds(const Sloped *view, const ViewPart *part, Vec3 n) {
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

static PortalView *view_of(VisQuery *q, int gate) {
    PortalView *view = &q->views[gate];
    if (view->frame == q->frame) return view;
    view->frame = q->frame;
    view->passage = PASSAGE_NONE;
    view->whole = false;
    view->passes = 0;
    view->place = -1;
    view->distance = INFINITY;
    return view;
}

static void take(VisQuery *q, PortalView *view, const Gate *gate, const ViewPart *part) {
    view->distance = fminf(view->distance, (float)part->distance);
    if (part->upright) {
        view->slot = part->slot;
        return;
    }
    if (gate->is_wall) return;  // seen edge-on
    if (part->count > VIEW_CORNERS) {
        view->passage = PASSAGE_ALL;
        return;
    }
    Sloped *sloped = &q->sloped[gate->other.index];
    sloped->count = part->count;
    memcpy(sloped->v, part->polygon, (size_t)part->count * sizeof *part->polygon);
}

// Takes all that the eye could see of the portal by any way.
static void take_whole(VisQuery *q, PortalView *view, const Gate *gate) {
    ViewPart whole;
    view->whole = true;
    // But for slack it sees something.
    double ahead = gate_ahead(gate, q->eye->position);
    if (query_clip(q, &q->cones[0], gate, ahead, &whole) != PASSAGE_NONE) take(q, view, gate, &whole);
}

// The portal is seen a second time: takes what is new into what is in view of it; false where nothing is.
static bool widen_slot(VisQuery *q, PortalView *view, const Gate *gate, const ViewPart *part) {
    if (query_slot_holds(&view->slot, &part->slot)) return false;
    view->slot = query_slot_union(&view->slot, &part->slot, gate, q->eye->position);
    view->distance = fminf(view->distance, (float)part->distance);
    return true;
}

static bool widen_polygon(VisQuery *q, PortalView *view, const Gate *gate, const ViewPart *part) {
    const Sloped *known = &q->sloped[gate->other.index];
    Vec3 n = gate_plane(gate).n, hull[2 * (VIEW_CORNERS + MAX_CORNERS)];
    if (holds(known, part, n)) return false;
    ViewPart both;
    both.upright = false;
    both.distance = part->distance;
    both.polygon = hull;
    both.count = hull_of(known->v, known->count, part->polygon, part->count, n, hull);
    if (both.count > VIEW_CORNERS) view->passes = PASSES;
    if (both.count >= 3 && both.count <= VIEW_CORNERS) take(q, view, gate, &both);
    return true;
}

// Takes what is seen of a portal into its view; false where nothing of it is new.
static bool widen(VisQuery *q, PortalView *view, const Gate *gate, Passage passage, const ViewPart *part) {
    bool known = view->passage == PASSAGE_PART;
    view->passage = (unsigned char)passage;
    if (passage == PASSAGE_ALL) {
        view->distance = fminf(view->distance, (float)part->distance);
        return true;
    }
    if (!known) {
        take(q, view, gate, part);
    } else if (!(part->upright ? widen_slot(q, view, gate, part) : widen_polygon(q, view, gate, part))) {
        return false;
    }
    if (passage == PASSAGE_EDGE || view->passes >= PASSES) take_whole(q, view, gate);
    return true;
}

static void look_through(VisQuery *q, const Cone *cone, int gate, double ahead) {
    ViewPart part;
    Passage passage = query_clip(q, cone, &q->gates[gate], ahead, &part);
    if (passage == PASSAGE_NONE) return;
    PortalView *view = view_of(q, gate);
    if (view->passage == PASSAGE_ALL || view->whole) return;
    if (widen(q, view, &q->gates[gate], passage, &part)) raise_gate(q, gate);
}

// Through all portals of a cell but the one come by.
static void look_around(VisQuery *q, const Cone *cone, int cell, unsigned but) {
    const Gate *gates = q->gates;
    const uint64_t *limit = q->limit;
    Vec3 eye = q->eye->position;
    int first = q->of_cell[cell].first_gate, end = first + q->of_cell[cell].gate_count;
    for (int i = first; i < end; i++) {
        const Gate *gate = &gates[i];
        double ahead = gate_ahead(gate, eye);
        bool seen = limit[gate->cell / 64] >> (gate->cell % 64) & 1;
        // One branch for all three: the processor cannot foretell any of them.
        if ((ahead >= -ON_PLANE) & (gate->portal != but) & seen) look_through(q, cone, i, ahead);
    }
}

// What the view goes on through.
static void view_part(VisQuery *q, const PortalView *view, const Gate *gate, ViewPart *out) {
    out->upright = gate->is_wall;
    if (view->passage == PASSAGE_EDGE) {
        const Portal *portal = &q->graph->portals[gate->portal];
        out->polygon = q->graph->portal_vertices + portal->first_vertex;
        out->count = portal->vertex_count;
    } else if (out->upright) {
        out->slot = view->slot;
    } else {
        const Sloped *sloped = &q->sloped[gate->other.index];
        out->polygon = sloped->v;
        out->count = sloped->count;
        out->middle = vec3(0, 0, 0);
        for (int i = 0; i < out->count; i++)
            out->middle = vec3_add(out->middle, vec3_sub(sloped->v[i], q->eye->position));
    }
}

void query_walk(VisQuery *q, int cell) {
    q->queue_count = 0;
    look_around(q, &q->cones[0], cell, UINT32_MAX);
    while (q->queue_count > 0) {
        int nearest = take_nearest(q);
        const Gate *gate = &q->gates[nearest];
        PortalView *view = &q->views[nearest];
        view->passes++;
        ViewPart part;
        view_part(q, view, gate, &part);
        Cone beyond;
        query_beyond(q, &q->cones[0], view->passage, gate, &part, &beyond);
        if (query_enter(q, gate, &beyond, view->distance)) look_around(q, &beyond, gate->cell, gate->portal);
    }
}
