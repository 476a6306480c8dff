// query_way.c - the portals as cells have them, four to a block, and the part of them that a cone shows.
//
// Portals between prisms are upright rectangles. The part in view of one is kept as a slot, which has two ends, one line above
// and one below, instead of a polygon with any number of corners. Clipping slots takes a few divisions, for four at once.
//
// Where several planes cross over a portal, the lowest one over its middle is kept. So a slot may be larger than the part in
// view, and is never smaller.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/query/query.h"

// A portal whose normal rises less than this is upright: over a storey its corners lean less than any slack.
static const double LEAN = 1e-9;
// A portal is a rectangle where its area lacks no more than this of its bounding rectangle's, relative.
static const double AREA_ROUNDING = 1e-9;
// A plane that leans less than this from upright cuts a slot's ends, not its height.
static const double STEEP = 1e-6;

bool query_is_wall(const CellGraph *graph, const Portal *portal, Plane plane, double *s, double *z) {
    if (fabs(plane.n.z) > LEAN) return false;
    s[0] = z[0] = INFINITY, s[1] = z[1] = -INFINITY;
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    for (int i = 0; i < portal->vertex_count; i++) {
        double at = plane.n.y * v[i].x - plane.n.x * v[i].y;
        s[0] = fmin(s[0], at), s[1] = fmax(s[1], at);
        z[0] = fmin(z[0], v[i].z), z[1] = fmax(z[1], v[i].z);
    }
    double area = (s[1] - s[0]) * (z[1] - z[0]);
    return polygon_area(v, portal->vertex_count) >= area * (1 - AREA_ROUNDING);
}

static Box portal_box(const CellGraph *graph, const Portal *portal) {
    Box box = box_empty();
    for (int i = 0; i < portal->vertex_count; i++)
        box = box_add(box, graph->portal_vertices[portal->first_vertex + i]);
    return box;
}

bool query_eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye) {
    return box_contains(box_grow(portal_box(graph, portal), AT_PORTAL), eye);
}

// Writes a lane; returns whether the portal is an upright rectangle. Of others `sloped` is the index.
static bool set_way(const VisQuery *q, int cell, Way leads, int sloped, WayBlock *out, int lane) {
    const CellGraph *graph = q->graph;
    const Portal *p = &graph->portals[leads.portal];
    double side = p->cell[0] == cell ? 1 : -1, s[2], z[2];
    Plane plane = {vec3_scale(p->plane.n, side), side * p->plane.d};
    bool wall = query_is_wall(graph, p, plane, s, z);
    out->nx[lane] = plane.n.x;
    out->ny[lane] = plane.n.y;
    out->d[lane] = plane.d;
    out->s0[lane] = wall ? s[0] : 0;
    out->s1[lane] = wall ? s[1] : -1 - sloped;
    out->z0[lane] = wall ? z[0] : plane.n.z;
    out->z1[lane] = wall ? z[1] : 0;
    out->cell[lane] = leads.cell;
    out->beyond[lane] = q->of_cell[leads.cell].first_block | (p->door >= 0 ? WAY_DOOR : 0);
    return wall;
}

static void list_ways_of(VisQuery *q, int c, Arena *arena, int *sloped_capacity) {
    const CellGraph *graph = q->graph;
    const Cell *cell = &graph->cells[c];
    int first = q->of_cell[c].first_block;
    for (int i = 0; i < cell->way_count; i++) {
        Way leads = graph->ways[cell->first_way + i];
        const Portal *portal = &graph->portals[leads.portal];
        int way = first * FOUR + i;
        q->way_of[2 * leads.portal + (portal->cell[0] == c ? 0 : 1)] = way;
        q->portal_of[way] = leads.portal;
        if (set_way(q, c, leads, q->sloped_count, &q->ways[way / FOUR], way % FOUR)) continue;
        Box box = portal_box(graph, portal);
        Sloped *sloped = ARENA_PUSH(arena, q->sloped, q->sloped_count, *sloped_capacity);
        sloped->centre = vec3_lerp(box.min, box.max, 0.5);
        sloped->half = vec3_sub(box.max, sloped->centre);
    }
}

void query_list_ways(VisQuery *q, Arena *arena) {
    const CellGraph *graph = q->graph;
    int blocks = 0, sloped_capacity = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        q->of_cell[c].first_block = blocks;
        q->of_cell[c].block_count = (graph->cells[c].way_count + FOUR - 1) / FOUR;
        blocks += q->of_cell[c].block_count;
    }
    q->block_count = blocks;
    q->ways = ARENA_ARRAY(arena, WayBlock, blocks);
    q->portal_of = ARENA_ARRAY(arena, int, FOUR *blocks);
    q->way_of = ARENA_ARRAY(arena, int, 2 * graph->portal_count);
    for (int k = 0; k < blocks; k++) q->ways[k].d = four_of(INFINITY);
    for (int c = 0; c < graph->cell_count; c++) list_ways_of(q, c, arena, &sloped_capacity);
}

ViewWay query_way(const VisQuery *q, int way) {
    const WayBlock *ways = &q->ways[way / FOUR];
    int lane = way % FOUR;
    bool wall = ways->s0[lane] <= ways->s1[lane];
    Plane plane = {{ways->nx[lane], ways->ny[lane], wall ? 0 : ways->z0[lane]}, ways->d[lane]};
    return (ViewWay){.portal = q->portal_of[way],
                     .cell = ways->cell[lane],
                     .sloped = wall ? -1 : (int)(-1 - ways->s1[lane]),
                     .plane = plane,
                     .ahead = plane_distance(plane, q->eye->position)};
}

// ---- slots: places and heights from the eye's foot

static Four edge_at(SlotEdge edge, Four s) { return edge.at + edge.rise * s; }

// Keeps the part of each slot's length that has a >= b * s. Returns the lanes where none is left.
static FourMask cut_slots(Slots *slots, Four a, Four b) {
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
static FourMask clip_by_planes(const Cone *cone, const WayBlock *ways, Vec3 eye, Four ahead, Slots *slots) {
    FourMask nothing = {0};
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < cone->count; i++) {
            Vec3 n = cone->plane[i].n;
            // The half-space over the portal: a - b * s + n.z * height >= 0.
            Four a = plane_distance(cone->plane[i], eye) + POSITION_SLACK -
                     ahead * (n.x * ways->nx + n.y * ways->ny);
            Four b = n.y * ways->nx - n.x * ways->ny;
            SlotEdge best = n.z > 0 ? slots->top : slots->bottom;
            nothing |= cut_slots(slots, a + n.z * best.at, b - n.z * best.rise);
            if (pass > 0 || fabs(n.z) < STEEP) continue;
            SlotEdge edge = {-a / n.z, b / n.z};
            if (n.z < 0) lower_top(slots, edge);
            if (n.z > 0) raise_bottom(slots, edge);
        }
    }
    return nothing;
}

// By the cone beyond another slot.
static FourMask clip_by_slot(const Cone *cone, const WayBlock *ways, Four ahead, Slots *slots) {
    Vec2 from = cone->from, to = cone->to, top = cone->top, bottom = cone->bottom;
    Four nx = ways->nx, ny = ways->ny;
    FourMask nothing =
        cut_slots(slots, ahead * (from.y * nx - from.x * ny) + POSITION_SLACK, from.x * nx + from.y * ny);
    nothing |= cut_slots(slots, ahead * (to.x * ny - to.y * nx) + POSITION_SLACK, -to.x * nx - to.y * ny);
    SlotEdge high = {cone->top_slack - ahead * (top.x * nx + top.y * ny), top.x * ny - top.y * nx};
    nothing |= cut_slots(slots, high.at - slots->bottom.at, -high.rise);
    SlotEdge low = {-cone->bottom_slack - ahead * (bottom.x * nx + bottom.y * ny),
                    bottom.x * ny - bottom.y * nx};
    nothing |= cut_slots(slots, slots->top.at - low.at, low.rise);
    lower_top(slots, high);
    raise_bottom(slots, low);
    return nothing;
}

unsigned query_slots_clip(const Cone *cone, const WayBlock *ways, Vec3 eye, Four ahead, Slots *out) {
    Four foot = ways->ny * eye.x - ways->nx * eye.y, level = four_of(0);
    Slots slots = {ways->s0 - foot, ways->s1 - foot, {ways->z0 - eye.z, level}, {ways->z1 - eye.z, level}};
    FourMask nothing = cone->is_slot ? clip_by_slot(cone, ways, ahead, &slots)
                                     : clip_by_planes(cone, ways, eye, ahead, &slots);
    nothing |= cut_slots(&slots, slots.top.at - slots.bottom.at, slots.bottom.rise - slots.top.rise);
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

void query_slots_join(const WayBlock *ways, Vec3 eye, const Slots *a, const Slots *b, Slots *out) {
    Four level = {0};
    SlotEdge top = {ways->z1 - eye.z, level}, bottom = {ways->z0 - eye.z, level};
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

// Keeps the part below (`side` +1) or above (-1) the plane of that slope. A normal shorter than one has more slack.
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

void query_slot_cone(const Slots *slots, const WayBlock *ways, int lane, Vec3 eye, bool plan, Cone *out) {
    Vec2 ahead = {-ways->nx[lane], -ways->ny[lane]}, along = {-ahead.y, ahead.x};
    double distance = -ahead.x * eye.x - ahead.y * eye.y - ways->d[lane];
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

unsigned query_sight(const VisQuery *q, const Cone *cone, int block, unsigned lanes, Sight *out) {
    const WayBlock *ways = &q->ways[block];
    Vec3 eye = q->eye->position;
    FourMask wall = ways->s0 <= ways->s1;
    Four ahead = ways->nx * eye.x + ways->ny * eye.y - ways->d;
    ahead += four_choose(wall, four_of(0), ways->z0 * eye.z);
    lanes &= four_lanes(ahead >= -ON_PLANE);  // from behind one would come back through it
    out->others = lanes & four_lanes(~wall | (ahead < ON_PLANE));
    out->slots = lanes & ~out->others;
    out->ahead = ahead;
    if (out->slots) out->slots &= query_slots_clip(cone, ways, eye, ahead, &out->slot);
    return lanes;
}
