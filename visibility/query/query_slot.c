// query_slot.c - what is in view of upright rectangles, as portals between prisms are: slots, which have two ends, one
// line above and one below, instead of a polygon with any number of corners. Clipping them is a few divisions, for four at
// once.
//
// Where several planes cross over a portal, the lowest one over its middle is kept. So a slot may be larger than what is
// in view, and is never smaller.
#include "visibility/query/query.h"

// A plane that leans less than this from upright cuts a slot's ends, not its height.
static const double STEEP = 1e-6;

static Four edge_at(SlotEdge edge, Four s) { return edge.at + edge.rise * s; }

// Keeps of each slot's length what has a >= b * s. Returns where nothing is left.
static FourMask cut(Slots *slots, Four a, Four b) {
    FourMask left = b * slots->s0 > a, right = b * slots->s1 > a;
    Four end = a / b;
    slots->s0 = four_choose(left, end, slots->s0);
    slots->s1 = four_choose(right, end, slots->s1);
    return left & right;
}

// Takes the lines that are lower over the slots' middle for their tops, those that are higher for their bottoms.
static void lower_top(Slots *slots, SlotEdge edge) {
    Four s = 0.5 * (slots->s0 + slots->s1);
    slots->top = query_choose_edge(edge_at(edge, s) < edge_at(slots->top, s), edge, slots->top);
}
static void raise_bottom(Slots *slots, SlotEdge edge) {
    Four s = 0.5 * (slots->s0 + slots->s1);
    slots->bottom = query_choose_edge(edge_at(edge, s) > edge_at(slots->bottom, s), edge, slots->bottom);
}

// By planes that lie anyhow: first those that pass above and below, then the ends where all planes leave some height.
static FourMask clip_by_planes(const Cone *cone, const GateBlock *gates, Vec3 eye, Four ahead, Slots *slots) {
    FourMask nothing = {0};
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < cone->count; i++) {
            Vec3 n = cone->plane[i].n;
            // The half-space over the portal: a - b * s + n.z * height >= 0.
            Four a = plane_distance(cone->plane[i], eye) + POSITION_SLACK -
                     ahead * (n.x * gates->nx + n.y * gates->ny);
            Four b = n.y * gates->nx - n.x * gates->ny;
            SlotEdge best = n.z > 0 ? slots->top : slots->bottom;
            nothing |= cut(slots, a + n.z * best.at, b - n.z * best.rise);
            if (pass > 0 || fabs(n.z) < STEEP) continue;
            SlotEdge edge = {-a / n.z, b / n.z};
            if (n.z < 0) lower_top(slots, edge);
            if (n.z > 0) raise_bottom(slots, edge);
        }
    }
    return nothing;
}

// By the cone beyond another slot.
static FourMask clip_by_slot(const Cone *cone, const GateBlock *gates, Four ahead, Slots *slots) {
    Vec2 from = cone->from, to = cone->to, top = cone->top, bottom = cone->bottom;
    Four nx = gates->nx, ny = gates->ny;
    FourMask nothing =
        cut(slots, ahead * (from.y * nx - from.x * ny) + POSITION_SLACK, from.x * nx + from.y * ny);
    nothing |= cut(slots, ahead * (to.x * ny - to.y * nx) + POSITION_SLACK, -to.x * nx - to.y * ny);
    SlotEdge high = {cone->top_slack - ahead * (top.x * nx + top.y * ny), top.x * ny - top.y * nx};
    nothing |= cut(slots, high.at - slots->bottom.at, -high.rise);
    SlotEdge low = {-cone->bottom_slack - ahead * (bottom.x * nx + bottom.y * ny),
                    bottom.x * ny - bottom.y * nx};
    nothing |= cut(slots, slots->top.at - low.at, low.rise);
    lower_top(slots, high);
    raise_bottom(slots, low);
    return nothing;
}

unsigned query_slots_clip(const Cone *cone, const GateBlock *gates, Vec3 eye, Four ahead, Slots *out) {
    Four foot = gates->ny * eye.x - gates->nx * eye.y, level = four_of(0);
    Slots slots = {
        gates->s0 - foot, gates->s1 - foot, {gates->z0 - eye.z, level}, {gates->z1 - eye.z, level}};
    FourMask nothing = cone->is_slot ? clip_by_slot(cone, gates, ahead, &slots)
                                     : clip_by_planes(cone, gates, eye, ahead, &slots);
    nothing |= cut(&slots, slots.top.at - slots.bottom.at, slots.bottom.rise - slots.top.rise);
    *out = slots;
    return four_lanes(~nothing);
}

Four query_slots_distance(const Slots *slots, Four ahead) {
    const Four zero = {0};
    Four s = four_most(slots->s0, four_least(slots->s1, zero));
    Four z = four_most(edge_at(slots->bottom, s), four_least(edge_at(slots->top, s), zero));
    return four_root(ahead * ahead + s * s + z * z);
}

unsigned query_slots_hold(const Slots *slots, const Slots *part) {
    const double slack = POSITION_SLACK;
    FourMask held = (part->s0 >= slots->s0 - slack) & (part->s1 <= slots->s1 + slack);
    for (int end = 0; end < 2; end++) {
        Four s = end ? part->s1 : part->s0;
        held &= (edge_at(part->top, s) <= edge_at(slots->top, s) + slack) &
                (edge_at(part->bottom, s) >= edge_at(slots->bottom, s) - slack);
    }
    return four_lanes(held);
}

// The line, raised (or, with `side` -1, lowered) until it is nowhere below `other` from end to end of `over`.
static SlotEdge raised(SlotEdge edge, SlotEdge other, const Slots *over, int side) {
    Four first = side * (edge_at(other, over->s0) - edge_at(edge, over->s0));
    Four last = side * (edge_at(other, over->s1) - edge_at(edge, over->s1));
    return (SlotEdge){edge.at + side * four_most(four_most(first, last), four_of(0)), edge.rise};
}

void query_slots_join(const GateBlock *gates, Vec3 eye, const Slots *a, const Slots *b, Slots *out) {
    Four level = {0};
    SlotEdge top = {gates->z1 - eye.z, level}, bottom = {gates->z0 - eye.z, level};
    Slots both = {four_least(a->s0, b->s0), four_most(a->s1, b->s1), bottom, top};
    lower_top(&both, raised(a->top, b->top, b, 1));
    lower_top(&both, raised(b->top, a->top, a, 1));
    raise_bottom(&both, raised(a->bottom, b->bottom, b, -1));
    raise_bottom(&both, raised(b->bottom, a->bottom, a, -1));
    *out = both;
}

// The slope of the plane through the eye and an edge 1 / `nearness` ahead: over the plan offset u from the eye the plane is at
// slope . u. It is moved outwards (`side` +1: up) along the whole edge, by `slack` metres or a little more.
// `steepness`, at least the length of (slope, 1), makes heights of distances.
static Vec2 slope_of(Vec2 ahead, double nearness, double at, double rise, double slack, int side,
                     double *steepness) {
    double height = at * nearness;
    Vec2 slope = {ahead.x * height - ahead.y * rise, ahead.y * height + ahead.x * rise};
    *steepness = 1 + fabs(slope.x) + fabs(slope.y);
    // ahead . u is the same all along the portal.
    return vec2_add(slope, vec2_scale(ahead, side * *steepness * slack * nearness));
}

// Keeps what is below (`side` +1) or above (-1) the plane of that slope. A normal shorter than one has more slack.
static void add_slope(Cone *cone, Vec3 eye, Vec2 slope, double steepness, int side) {
    double scale = side / steepness;
    Vec3 n = vec3(slope.x * scale, slope.y * scale, -scale);
    cone_add(cone, n, vec3_dot(n, eye));
}

static void add_slopes(Cone *cone, Vec3 eye) {
    add_slope(cone, eye, cone->top, cone->top_slack / POSITION_SLACK, 1);
    add_slope(cone, eye, cone->bottom, cone->bottom_slack / POSITION_SLACK, -1);
}

void query_cone_planes(Cone *cone, Vec3 eye) {
    if (!cone->is_slot || cone->count > 0) return;
    cone_add_wedge(cone, eye);
    add_slopes(cone, eye);
}

static double larger(double a, double b) { return a > b ? a : b; }
static double reach(double at, double rise, double s0, double s1) {
    return larger(fabs(at + rise * s0), fabs(at + rise * s1));
}

void query_slot_cone(const Slots *slots, const GateBlock *gates, int lane, Vec3 eye, bool plan, Cone *out) {
    Vec2 ahead = {-gates->nx[lane], -gates->ny[lane]}, along = {-ahead.y, ahead.x};
    double distance = -ahead.x * eye.x - ahead.y * eye.y - gates->d[lane];
    double s0 = slots->s0[lane], s1 = slots->s1[lane];
    Vec2 from = vec2_add(vec2_scale(ahead, distance), vec2_scale(along, s0));
    Vec2 to = vec2_add(vec2_scale(ahead, distance), vec2_scale(along, s1));
    double from_length = vec2_length(from), to_length = vec2_length(to);
    out->from = cone_turned(vec2_scale(from, 1 / from_length), -1, from_length);
    out->to = cone_turned(vec2_scale(to, 1 / to_length), 1, to_length);
    out->all_around = vec2_cross(out->from, out->to) <= 0;
    out->count = 0;
    out->is_slot = !plan && !out->all_around;
    if (plan && !out->all_around) cone_add_wedge(out, eye);
    if (plan) return;
    double top = slots->top.at[lane], top_rise = slots->top.rise[lane];
    double bottom = slots->bottom.at[lane], bottom_rise = slots->bottom.rise[lane];
    double height = larger(reach(top, top_rise, s0, s1), reach(bottom, bottom_rise, s0, s1));
    double slack = ANGLE_SLACK * (larger(from_length, to_length) + height) + POSITION_SLACK;
    double up, down, nearness = 1 / distance;
    out->top = slope_of(ahead, nearness, top, top_rise, slack, 1, &up);
    out->bottom = slope_of(ahead, nearness, bottom, bottom_rise, slack, -1, &down);
    out->top_slack = POSITION_SLACK * up;
    out->bottom_slack = POSITION_SLACK * down;
    if (!out->is_slot) add_slopes(out, eye);
}
