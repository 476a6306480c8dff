// query_slot.c - what is in view of an upright rectangle, as portals between prisms are: a slot, which has two ends, one
// line above and one below, instead of a polygon with any number of corners. Clipping it is a few divisions.
//
// Where several planes cross over a portal, the lowest one over its middle is kept. So a slot may be larger than what is
// in view, and is never smaller.
#include "visibility/query.h"

// Of a portal's normal: what its corners lean over a storey is less than any slack.
static const double LEAN = 1e-9;
// What a rectangle's area may lack of its bounding one's, relative.
static const double AREA_ROUNDING = 1e-9;
// A plane that leans less than this from upright cuts a slot's ends, not its height.
static const double STEEP = 1e-6;

bool query_is_wall(const CellGraph *graph, const Portal *portal, Plane plane, Gate *gate) {
    if (fabs(plane.n.z) > LEAN) return false;
    double s0 = INFINITY, s1 = -INFINITY, z0 = INFINITY, z1 = -INFINITY;
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    for (int i = 0; i < portal->vertex_count; i++) {
        double s = plane.n.y * v[i].x - plane.n.x * v[i].y;
        s0 = fmin(s0, s), s1 = fmax(s1, s);
        z0 = fmin(z0, v[i].z), z1 = fmax(z1, v[i].z);
    }
    double area = (s1 - s0) * (z1 - z0);
    if (polygon_area(v, portal->vertex_count) < area * (1 - AREA_ROUNDING)) return false;
    gate->wall.s0 = s0, gate->wall.s1 = s1;
    gate->wall.z0 = z0, gate->wall.z1 = z1;
    return true;
}

static double edge_at(SlotEdge edge, double s) { return edge.at + edge.rise * s; }

// Keeps of the slot's length what has a + b * s >= 0; false: nothing.
static bool cut(Slot *slot, double a, double b) {
    bool left = a + b * slot->s0 < 0, right = a + b * slot->s1 < 0;
    if (left && right) return false;
    if (left) slot->s0 = -a / b;
    if (right) slot->s1 = -a / b;
    return true;
}

// The line that is lower (or, with `side` -1, higher) over the slot's middle.
static SlotEdge tighter(const Slot *slot, SlotEdge old, SlotEdge new, int side) {
    double s = 0.5 * (slot->s0 + slot->s1);
    return side * (edge_at(new, s) - edge_at(old, s)) < 0 ? new : old;
}

// By planes that lie anyhow: first those that pass above and below, then the ends where all planes leave some height.
static bool clip_by_planes(const Cone *cone, const Gate *gate, Vec3 eye, double ahead, Slot *slot) {
    Vec2 along = gate_along(gate);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < cone->count; i++) {
            Vec3 n = cone->plane[i].n;
            // The half-space over the portal: a + b * s + n.z * height >= 0.
            double a = plane_distance(cone->plane[i], eye) - ahead * (n.x * gate->n.x + n.y * gate->n.y) +
                       POSITION_SLACK;
            double b = n.x * along.x + n.y * along.y;
            SlotEdge best = n.z > 0 ? slot->top : slot->bottom;
            if (!cut(slot, a + n.z * best.at, b + n.z * best.rise)) return false;
            if (pass > 0 || fabs(n.z) < STEEP) continue;
            SlotEdge edge = {-a / n.z, -b / n.z};
            if (n.z < 0) slot->top = tighter(slot, slot->top, edge, 1);
            if (n.z > 0) slot->bottom = tighter(slot, slot->bottom, edge, -1);
        }
    }
    return true;
}

// By the cone beyond another slot.
static bool clip_by_slot(const Cone *cone, const Gate *gate, Vec3 eye, double ahead, Slot *slot) {
    Vec2 along = gate_along(gate), foot = {-ahead * gate->n.x, -ahead * gate->n.y};
    if (!cut(slot, vec2_cross(cone->from, foot) + POSITION_SLACK, vec2_cross(cone->from, along)))
        return false;
    if (!cut(slot, vec2_cross(foot, cone->to) + POSITION_SLACK, vec2_cross(along, cone->to))) return false;
    SlotEdge top = {vec2_dot(cone->top, foot) + cone->top_slack, vec2_dot(cone->top, along)};
    if (!cut(slot, top.at - gate->wall.z0 + eye.z, top.rise)) return false;
    SlotEdge bottom = {vec2_dot(cone->bottom, foot) - cone->bottom_slack, vec2_dot(cone->bottom, along)};
    if (!cut(slot, gate->wall.z1 - eye.z - bottom.at, -bottom.rise)) return false;
    slot->top = tighter(slot, slot->top, top, 1);
    slot->bottom = tighter(slot, slot->bottom, bottom, -1);
    return true;
}

bool query_slot_clip(const Cone *cone, const Gate *gate, Vec3 eye, double ahead, Slot *out) {
    double foot = gate->n.y * eye.x - gate->n.x * eye.y;
    *out = (Slot){
        gate->wall.s0 - foot, gate->wall.s1 - foot, {gate->wall.z0 - eye.z, 0}, {gate->wall.z1 - eye.z, 0}};
    bool left = cone->is_slot ? clip_by_slot(cone, gate, eye, ahead, out)
                              : clip_by_planes(cone, gate, eye, ahead, out);
    return left && cut(out, out->top.at - out->bottom.at, out->top.rise - out->bottom.rise);
}

double query_slot_distance(const Slot *slot, double ahead) {
    double s = slot->s0 > 0 ? slot->s0 : slot->s1 < 0 ? slot->s1 : 0;
    double low = edge_at(slot->bottom, s), high = edge_at(slot->top, s);
    double z = low > 0 ? low : high < 0 ? high : 0;
    return sqrt(ahead * ahead + s * s + z * z);
}

bool query_slot_holds(const Slot *slot, const Slot *part) {
    const double slack = POSITION_SLACK;
    return part->s0 >= slot->s0 - slack && part->s1 <= slot->s1 + slack &&
           edge_at(part->top, part->s0) <= edge_at(slot->top, part->s0) + slack &&
           edge_at(part->top, part->s1) <= edge_at(slot->top, part->s1) + slack &&
           edge_at(part->bottom, part->s0) >= edge_at(slot->bottom, part->s0) - slack &&
           edge_at(part->bottom, part->s1) >= edge_at(slot->bottom, part->s1) - slack;
}

// The line, raised (or, with `side` -1, lowered) until it is nowhere below `other` from s0 to s1.
static SlotEdge raised(SlotEdge edge, SlotEdge other, double s0, double s1, int side) {
    double first = side * (edge_at(other, s0) - edge_at(edge, s0));
    double last = side * (edge_at(other, s1) - edge_at(edge, s1)), most = first > last ? first : last;
    return (SlotEdge){most > 0 ? edge.at + side * most : edge.at, edge.rise};
}

Slot query_slot_union(const Slot *a, const Slot *b, const Gate *gate, Vec3 eye) {
    Slot both = {
        fmin(a->s0, b->s0), fmax(a->s1, b->s1), {gate->wall.z0 - eye.z, 0}, {gate->wall.z1 - eye.z, 0}};
    both.top = tighter(&both, both.top, raised(a->top, b->top, b->s0, b->s1, 1), 1);
    both.top = tighter(&both, both.top, raised(b->top, a->top, a->s0, a->s1, 1), 1);
    both.bottom = tighter(&both, both.bottom, raised(a->bottom, b->bottom, b->s0, b->s1, -1), -1);
    both.bottom = tighter(&both, both.bottom, raised(b->bottom, a->bottom, a->s0, a->s1, -1), -1);
    return both;
}

// The slope of the plane through the eye and an edge 1 / `nearness` ahead: over the plan offset u from the eye the plane is at
// slope . u. It is moved outwards (`side` +1: up) along the whole edge, by `slack` metres or a little more.
// `steepness`, at least the length of (slope, 1), makes heights of distances.
static Vec2 slope_of(Vec2 ahead, double nearness, SlotEdge edge, double slack, int side, double *steepness) {
    double height = edge.at * nearness;
    Vec2 slope = {ahead.x * height - ahead.y * edge.rise, ahead.y * height + ahead.x * edge.rise};
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

static double larger(double a, double b) { return a > b ? a : b; }

void query_slot_cone(const Slot *slot, const Gate *gate, Vec3 eye, bool plan, Cone *out) {
    Vec2 ahead = {-gate->n.x, -gate->n.y}, along = gate_along(gate);
    double distance = gate_ahead(gate, eye);
    Vec2 from = vec2_add(vec2_scale(ahead, distance), vec2_scale(along, slot->s0));
    Vec2 to = vec2_add(vec2_scale(ahead, distance), vec2_scale(along, slot->s1));
    double from_length = vec2_length(from), to_length = vec2_length(to);
    out->from = cone_turned(vec2_scale(from, 1 / from_length), -1, from_length);
    out->to = cone_turned(vec2_scale(to, 1 / to_length), 1, to_length);
    out->all_around = vec2_cross(out->from, out->to) <= 0;
    out->count = 0;
    out->is_slot = !plan && !out->all_around;
    if (!out->all_around) cone_add_wedge(out, eye);
    if (plan) return;
    double high = larger(fabs(edge_at(slot->top, slot->s0)), fabs(edge_at(slot->top, slot->s1)));
    double low = larger(fabs(edge_at(slot->bottom, slot->s0)), fabs(edge_at(slot->bottom, slot->s1)));
    double slack = ANGLE_SLACK * (larger(from_length, to_length) + larger(high, low)) + POSITION_SLACK;
    double top, bottom, nearness = 1 / distance;
    out->top = slope_of(ahead, nearness, slot->top, slack, 1, &top);
    out->bottom = slope_of(ahead, nearness, slot->bottom, slack, -1, &bottom);
    out->top_slack = POSITION_SLACK * top;
    out->bottom_slack = POSITION_SLACK * bottom;
    add_slope(out, eye, out->top, top, 1);
    add_slope(out, eye, out->bottom, bottom, -1);
}

bool query_slot_outside(const Cone *cone, Vec3 centre, Vec3 half) {
    // `centre` from the eye: beyond one of the cone's planes, with what of the box reaches back to it.
    if (cone->from.x * centre.y - cone->from.y * centre.x + fabs(cone->from.x) * half.y +
            fabs(cone->from.y) * half.x <
        -POSITION_SLACK)
        return true;
    if (centre.x * cone->to.y - centre.y * cone->to.x + fabs(cone->to.y) * half.x +
            fabs(cone->to.x) * half.y <
        -POSITION_SLACK)
        return true;
    double top = cone->top.x * centre.x + cone->top.y * centre.y + fabs(cone->top.x) * half.x +
                 fabs(cone->top.y) * half.y;
    if (centre.z - half.z > top + cone->top_slack) return true;
    double bottom = cone->bottom.x * centre.x + cone->bottom.y * centre.y - fabs(cone->bottom.x) * half.x -
                    fabs(cone->bottom.y) * half.y;
    return centre.z + half.z < bottom - cone->bottom_slack;
}
