// collision_flood.c - every place of a plan grid that can be reached by foot.
//
// Breadth first. A place is taken when no polygon comes over or under a disc about it between what is stepped over and
// what is ducked under; for the disc stands a regular polygon about it, by which upright and sloping polygons are cut.
#include "engine/sim/collision_flood.h"

#include "engine/core/polygon.h"
#include "engine/sim/body.h"

enum { SIDES = 32, MOST_CORNERS = 256 };
// Slopes of more than 45 degrees carry nobody.
static const double STEEP = 0.7;
// More upright than this is the side of a step, which its tread tops.
static const double RISER = 0.1;
// How deep ways lead down when they need not lead up again, metres.
static const double DEEPEST = 30.0;

FloodRules flood_strict(void) {
    return (FloodRules){.radius = BODY_RADIUS,
                        .spare = 0.02,
                        .step = BODY_STEP - 0.02,
                        .headroom = BODY_LOWEST + 0.02,
                        .leaves = true,
                        .strict = true};
}

FloodRules flood_loose(void) {
    // Half the diagonal of the grid nearer, and the circle about a polygon of so many sides within.
    double radius = (BODY_RADIUS - FLOOD_APART * M_SQRT1_2) * cos(M_PI / SIDES) - 1e-3;
    return (FloodRules){.radius = radius, .step = 2 * BODY_STEP, .headroom = BODY_LOWEST - 0.02};
}

typedef struct Stand {
    double foot, step;  // where it comes from, and how much higher it may step
    bool asked;         // false: nothing is known
    bool free;
    double support;  // the highest under the disc itself
    double middle;   // under its middle
    double top,
        footing;   // with the room to spare: the highest that is stepped over, and the highest that carries
    double slope;  // with the room to spare: the highest that is neither level nor upright
    double ceiling;
} Stand;

typedef struct Flooder {
    CollisionCheck *check;
    const CellGraph *graph;
    const FloodRules *rules;
    CollisionFlood *out;
    Stand *last;  // [nx * ny] the last answer for each column: its neighbours ask the same
    Arena *arena;
} Flooder;

// ---- a place

// The heights of a polygon over a disc that it comes over or under; for the disc stands a regular polygon about it.
static bool heights_over(const Vec3 *v, int count, Vec2 at, double radius, double *low, double *high) {
    Vec3 buffer[2][MOST_CORNERS];
    *low = *high = v[0].z;
    bool flat = true;
    for (int i = 1; i < count; i++) flat = flat && v[i].z == v[0].z;
    if (flat) return true;
    if (count + SIDES > MOST_CORNERS) return false;
    const Vec3 *left = v;
    for (int i = 0; i < SIDES && count > 0; i++) {
        double angle = 2 * M_PI * i / SIDES;
        Vec3 n = {-cos(angle), -sin(angle), 0};
        count = polygon_clip(left, count, (Plane){n, n.x * at.x + n.y * at.y - radius}, 0, buffer[i % 2]);
        left = buffer[i % 2];
    }
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < count; i++) {
        *low = fmin(*low, left[i].z);
        *high = fmax(*high, left[i].z);
    }
    return count > 0;
}

// True where it is something to step on.
static bool stand_on(Stand *s, const FloodRules *r, double low, double high) {
    if (high <= s->foot + s->step) return true;
    if (low >= s->foot + r->headroom) {
        s->ceiling = fmin(s->ceiling, low);
    } else {
        s->free = false;
    }
    return false;
}

static void meet_polygon(Stand *s, const Flooder *f, int polygon, Vec2 at) {
    const FloodRules *r = f->rules;
    const Polygon *p = &f->graph->polygons[polygon];
    const Vec3 *v = f->graph->vertices + p->first_vertex;
    double middle = r->radius / 2 - r->spare, low, high, top,
           distance = collision_plan_distance(v, p->vertex_count, at);
    if (distance >= r->radius + r->spare) return;
    if (!heights_over(v, p->vertex_count, at, r->radius + r->spare, &low, &high)) return;
    if (!stand_on(s, r, low, high)) return;
    s->top = fmax(s->top, high);
    double level = fabs(plane_of_polygon(v, p->vertex_count).n.z);
    if (level >= STEEP) s->footing = fmax(s->footing, high);
    if (level < STEEP && level > RISER) s->slope = fmax(s->slope, high);
    if (high > s->support && distance < r->radius &&
        heights_over(v, p->vertex_count, at, r->radius, &low, &top))
        s->support = fmax(s->support, top);
    if (high > s->middle && distance < middle && heights_over(v, p->vertex_count, at, middle, &low, &top))
        s->middle = fmax(s->middle, top);
}

static void meet_leaves(Stand *s, const Flooder *f, Vec2 at) {
    const Building *b = f->graph->building;
    for (int i = 0; i < b->leaf_count && f->rules->leaves; i++) {
        const Leaf *leaf = &b->leaves[i];
        Vec2 corner[LEAF_CORNERS];
        Vec3 plan[LEAF_CORNERS];
        int count = leaf_plan(b, leaf, 1, corner);
        for (int c = 0; c < count; c++) plan[c] = vec3(corner[c].x, corner[c].y, 0);
        if (collision_plan_distance(plan, count, at) < f->rules->radius + f->rules->spare)
            stand_on(s, f->rules, leaf->z0 + leaf->rise, leaf->z1 + leaf->rise);
    }
}

static bool in_window(const CellGraph *graph, Vec3 place) {
    int cell = vis_locate(graph, place, -1);
    if (cell < 0) return true;
    int opening = vis_region(graph, cell)->opening;
    return opening >= 0 && graph->building->openings[opening].kind == OPENING_WINDOW;
}

// For one who comes from a foot height and may step so much higher.
static Stand stand_at(const Flooder *f, Vec2 at, double foot, double step) {
    const FloodRules *r = f->rules;
    Stand s = {foot, step, false, true, -INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, INFINITY};
    double reach = r->radius + r->spare, depth = r->strict ? BODY_STEP : DEEPEST;
    Box box = {{at.x - reach, at.y - reach, foot - depth},
               {at.x + reach, at.y + reach, foot + BODY_STEP + BODY_HEIGHT}};
    const int *near;
    int count = collision_check_near(f->check, box, &near);
    if (in_window(f->graph, vec3(at.x, at.y, foot + BODY_MIDDLE))) s.free = false;
    for (int i = 0; i < count && s.free; i++) meet_polygon(&s, f, near[i], at);
    if (s.free) meet_leaves(&s, f, at);
    if (r->strict && (s.top > s.footing || s.slope > s.support)) s.free = false;
    s.free = s.free && isfinite(s.support) && s.ceiling - s.support >= r->headroom;
    return s;
}

// ---- the flood

static Vec2 column_place(const CollisionFlood *flood, int i, int j) {
    return vec2(flood->origin.x + i * FLOOD_APART, flood->origin.y + j * FLOOD_APART);
}

// The stand in a column, remembered.
static Stand stand_in(Flooder *f, int i, int j, double foot, double step) {
    Stand *last = &f->last[j * f->out->nx + i];
    if (last->asked && last->foot == foot && last->step == step) return *last;
    *last = stand_at(f, column_place(f->out, i, j), foot, step);
    last->asked = true;
    return *last;
}

// Finds the place of a column at this height, or makes it.
static int take_stand(Flooder *f, int i, int j, Stand s) {
    enum { MOST_PLACES = 1 << 23 };
    CollisionFlood *flood = f->out;
    const double same = 1e-6;  // metres: the same floor, cut twice
    int *first = &flood->column[j * flood->nx + i];
    for (int k = *first; k >= 0; k = flood->places[k].next) {
        if (fabs(flood->places[k].foot.z - s.support) < same) return k;
    }
    if (flood->place_count == MOST_PLACES) return -1;
    Vec2 at = column_place(flood, i, j);
    *ARENA_PUSH(f->arena, flood->places, flood->place_count, flood->place_capacity) =
        (FloodPlace){vec3(at.x, at.y, s.support), s.middle, s.ceiling, {-1, -1, -1, -1}, *first};
    return *first = flood->place_count - 1;
}

static void spread(Flooder *f, int from) {
    static const int STEPS[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    CollisionFlood *flood = f->out;
    FloodPlace here = flood->places[from];
    int x = (int)lround((here.foot.x - flood->origin.x) / FLOOD_APART);
    int y = (int)lround((here.foot.y - flood->origin.y) / FLOOD_APART);
    // For the height of a step counts the ground under the middle.
    double step = f->rules->strict ? fmax(0, here.middle + f->rules->step - here.foot.z) : f->rules->step;
    for (int k = 0; k < 4; k++) {
        int i = x + STEPS[k][0], j = y + STEPS[k][1];
        if (i < 0 || j < 0 || i >= flood->nx || j >= flood->ny) continue;
        Stand s = stand_in(f, i, j, here.foot.z, step);
        if (!s.free) continue;
        double top = fmax(here.foot.z, s.support) + f->rules->headroom;
        // Under a low ceiling nobody begins a step up.
        if (f->rules->strict &&
            (here.foot.z - s.support > f->rules->step || here.ceiling < top || s.ceiling < top))
            continue;
        int to = take_stand(f, i, j, s);
        flood->places[from].link[k] = to;
    }
}

static void lay(CollisionFlood *flood, const CellGraph *graph, const FloodRules *rules, Arena *arena) {
    Box box = box_empty();
    for (int c = 0; c < graph->cell_count; c++) {
        if (vis_region(graph, c)->kind != REGION_OUTDOORS) box = box_union(box, graph->cells[c].box);
    }
    box = box_is_empty(box) ? graph->box : box_grow(box, FLOOD_OUTDOORS);
    // Nobody comes nearer to the border of the world: that of a soup runs along its outer walls, its roof within.
    Box world = box_grow(graph->building->world, -rules->radius - rules->spare);
    box.min.x = fmax(box.min.x, world.min.x), box.max.x = fmin(box.max.x, world.max.x - FLOOD_APART);
    box.min.y = fmax(box.min.y, world.min.y), box.max.y = fmin(box.max.y, world.max.y - FLOOD_APART);
    flood->origin = vec2(box.min.x, box.min.y);
    flood->nx = (int)ceil(fmax(0, box.max.x - box.min.x) / FLOOD_APART) + 1;
    flood->ny = (int)ceil(fmax(0, box.max.y - box.min.y) / FLOOD_APART) + 1;
    flood->column = ARENA_ARRAY(arena, int, flood->nx * flood->ny);
    for (int i = 0; i < flood->nx * flood->ny; i++) flood->column[i] = -1;
}

// The middle of each cell's corners, on its floor.
static void seed(Flooder *f, int c) {
    CollisionFlood *flood = f->out;
    const Cell *cell = &f->graph->cells[c];
    Vec2 sum = {0, 0};
    for (int i = 0; i < cell->edge_count; i++) sum = vec2_add(sum, f->graph->plan[cell->first_edge + i]);
    int i = (int)lround((sum.x / cell->edge_count - flood->origin.x) / FLOOD_APART);
    int j = (int)lround((sum.y / cell->edge_count - flood->origin.y) / FLOOD_APART);
    if (i < 0 || j < 0 || i >= flood->nx || j >= flood->ny) return;
    Stand s = stand_in(f, i, j, cell->z0, 0);
    if (s.free) take_stand(f, i, j, s);
}

CollisionFlood collision_flood(CollisionCheck *check, const CellGraph *graph, const FloodRules *rules,
                               Arena *arena) {
    CollisionFlood flood = {0};
    Flooder f = {.check = check, .graph = graph, .rules = rules, .out = &flood, .arena = arena};
    lay(&flood, graph, rules, arena);
    f.last = ARENA_ARRAY(arena, Stand, flood.nx * flood.ny);
    for (int c = 0; c < graph->cell_count; c++) seed(&f, c);
    for (int i = 0; i < flood.place_count; i++) spread(&f, i);
    return flood;
}

bool collision_flood_near(const CollisionFlood *flood, Vec3 foot, double reach, double rise) {
    int x0 = (int)ceil((foot.x - reach - flood->origin.x) / FLOOD_APART);
    int x1 = (int)floor((foot.x + reach - flood->origin.x) / FLOOD_APART);
    int y0 = (int)ceil((foot.y - reach - flood->origin.y) / FLOOD_APART);
    int y1 = (int)floor((foot.y + reach - flood->origin.y) / FLOOD_APART);
    if (x0 < 0 || y0 < 0 || x1 >= flood->nx || y1 >= flood->ny) return true;
    for (int j = y0; j <= y1; j++) {
        for (int i = x0; i <= x1; i++) {
            for (int k = flood->column[j * flood->nx + i]; k >= 0; k = flood->places[k].next) {
                if (fabs(flood->places[k].foot.z - foot.z) <= rise) return true;
            }
        }
    }
    return false;
}
