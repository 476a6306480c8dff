// collision_walk.c - a body that walks at random, checked at every step.
#include "engine/sim/collision_walk.h"

#include <stdio.h>

#include "engine/core/clock.h"
#include "engine/core/polygon.h"
#include "engine/sim/body.h"
#include "engine/sim/collision_check.h"
#include "engine/sim/doors.h"

// Distance of neighbouring places of the flood, metres: a quarter of the radius of a body.
#define FLOOD_APART 0.05
// The flood reaches this far from anything built, metres: farther outdoors there is nothing to meet.
#define FLOOD_OUTDOORS 2.0

typedef struct FloodRules {
    double radius, spare;   // metres: of the disc that is carried, and how much more is kept clear around it
    double step, headroom;  // metres
    bool leaves;            // the leaves of wide open doors are in the way
    bool strict;            // only even ground, and no way down that does not lead up again
} FloodRules;

typedef struct FloodPlace {
    Vec3 foot;
    double middle;  // the height of the polygon that carries the middle of the disc
    double ceiling;
    int link[4];  // the place that a step along +x, +y, -x, -y leads to, -1 none
    int next;     // the next place of the same column, -1 none
} FloodPlace;

typedef struct CollisionFlood {
    FloodPlace *places;
    int *column;  // [nx * ny] the first place of each column, -1 none
    Vec2 origin;
    int nx, ny, place_count, place_capacity;
} CollisionFlood;

// ---- every place of a plan grid that can be reached by foot.
//
// The search is breadth first. A place is taken when, between the height of a step and the headroom of a ducking body, no polygon
// lies over or under a disc around the place. A regular polygon around the disc stands in for the disc: upright and sloping
// polygons are clipped to it.

enum { SIDES = 32, MOST_CORNERS = 256 };
// Slopes of more than 45 degrees carry nobody.
static const double STEEP = 0.7;
// A polygon whose normal has an upright component below this is the riser of a step, and the top of the step is its tread.
static const double RISER = 0.1;
// How far a way may lead down when it need not lead up again, metres.
static const double DEEPEST = 30.0;

// The rules for places that a body surely reaches. Straight ways between neighbours need 2 cm of room to spare: a disc of 0.2 m
// stays within two discs of 0.22 m, 5 cm apart, all the way from one to the other.
static FloodRules flood_strict(void) {
    return (FloodRules){.radius = BODY_RADIUS,
                        .spare = 0.02,
                        .step = BODY_STEP - 0.02,
                        .headroom = BODY_LOWEST + 0.02,
                        .leaves = true,
                        .strict = true};
}

// The rules for places that a body may reach at all: the disc is so small that it is free at the grid's place nearest to any free
// body.
static FloodRules flood_loose(void) {
    // The disc is smaller by half the diagonal of the grid, and the polygon around it, of SIDES sides, lies within this smaller
    // radius.
    double radius = (BODY_RADIUS - FLOOD_APART * M_SQRT1_2) * cos(M_PI / SIDES) - 1e-3;
    return (FloodRules){.radius = radius, .step = 2 * BODY_STEP, .headroom = BODY_LOWEST - 0.02};
}

typedef struct Stand {
    double foot, step;  // the height from which the body comes, and how much higher it may step
    bool asked;         // false: nothing is known
    bool free;
    double support;  // the highest point under the disc itself
    double middle;   // the highest point under the middle of the disc
    // With the room to spare: the highest polygon that is stepped over, and the highest that carries a body.
    double top, footing;
    double slope;  // with the room to spare: the highest polygon that is neither level nor upright
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

// The lowest and highest point of the part of a polygon over or under a disc, for which a regular polygon around the disc stands
// in; false if there is no such part. The polygon must come over or under the disc.
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

// Is a polygon between these heights one to step on? Otherwise it is a ceiling, or the place is not free.
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

// The stand at a place in plan for a body that comes from the height `foot` and may step `step` higher.
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

// The stand in a column; the last answer for each column is kept.
static Stand stand_in(Flooder *f, int i, int j, double foot, double step) {
    Stand *last = &f->last[j * f->out->nx + i];
    if (last->asked && last->foot == foot && last->step == step) return *last;
    *last = stand_at(f, column_place(f->out, i, j), foot, step);
    last->asked = true;
    return *last;
}

// Finds the place of a column at this height, or makes it.
static int link_stand(Flooder *f, int i, int j, Stand s) {
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
    // The height of a step is measured from the ground under the middle.
    double step = f->rules->strict ? fmax(0, here.middle + f->rules->step - here.foot.z) : f->rules->step;
    for (int k = 0; k < 4; k++) {
        int i = x + STEPS[k][0], j = y + STEPS[k][1];
        if (i < 0 || j < 0 || i >= flood->nx || j >= flood->ny) continue;
        Stand s = stand_in(f, i, j, here.foot.z, step);
        if (!s.free) continue;
        double top = fmax(here.foot.z, s.support) + f->rules->headroom;
        // A body does not begin a step up under a low ceiling.
        if (f->rules->strict &&
            (here.foot.z - s.support > f->rules->step || here.ceiling < top || s.ceiling < top))
            continue;
        int to = link_stand(f, i, j, s);
        flood->places[from].link[k] = to;
    }
}

static void lay(CollisionFlood *flood, const CellGraph *graph, const FloodRules *rules, Arena *arena) {
    Box box = box_empty();
    for (int c = 0; c < graph->cell_count; c++) {
        if (vis_region(graph, c)->kind != REGION_OUTDOORS) box = box_union(box, graph->cells[c].box);
    }
    box = box_is_empty(box) ? graph->box : box_grow(box, FLOOD_OUTDOORS);
    // No body comes nearer than its radius to the border of the world: the border of a polygon soup runs along its outer walls,
    // with its roof inside.
    Box world = box_grow(graph->building->world, -rules->radius - rules->spare);
    box.min.x = fmax(box.min.x, world.min.x), box.max.x = fmin(box.max.x, world.max.x - FLOOD_APART);
    box.min.y = fmax(box.min.y, world.min.y), box.max.y = fmin(box.max.y, world.max.y - FLOOD_APART);
    flood->origin = vec2(box.min.x, box.min.y);
    flood->nx = (int)ceil(fmax(0, box.max.x - box.min.x) / FLOOD_APART) + 1;
    flood->ny = (int)ceil(fmax(0, box.max.y - box.min.y) / FLOOD_APART) + 1;
    flood->column = ARENA_ARRAY(arena, int, flood->nx * flood->ny);
    for (int i = 0; i < flood->nx * flood->ny; i++) flood->column[i] = -1;
}

// Starts the flood in a cell: at the mean of its corners, on its floor.
static void seed(Flooder *f, int c) {
    CollisionFlood *flood = f->out;
    const Cell *cell = &f->graph->cells[c];
    Vec2 sum = {0, 0};
    for (int i = 0; i < cell->edge_count; i++) sum = vec2_add(sum, f->graph->plan[cell->first_edge + i]);
    int i = (int)lround((sum.x / cell->edge_count - flood->origin.x) / FLOOD_APART);
    int j = (int)lround((sum.y / cell->edge_count - flood->origin.y) / FLOOD_APART);
    if (i < 0 || j < 0 || i >= flood->nx || j >= flood->ny) return;
    Stand s = stand_in(f, i, j, cell->z0, 0);
    if (s.free) link_stand(f, i, j, s);
}

// The flood starts from the floor in the middle of every cell: furniture and closed corners separate places from any single start.
static CollisionFlood collision_flood(CollisionCheck *check, const CellGraph *graph, const FloodRules *rules,
                                      Arena *arena) {
    CollisionFlood flood = {0};
    Flooder f = {.check = check, .graph = graph, .rules = rules, .out = &flood, .arena = arena};
    lay(&flood, graph, rules, arena);
    f.last = ARENA_ARRAY(arena, Stand, flood.nx * flood.ny);
    for (int c = 0; c < graph->cell_count; c++) seed(&f, c);
    for (int i = 0; i < flood.place_count; i++) spread(&f, i);
    return flood;
}

// Is a place of the flood within `reach` of `foot` in plan and `rise` in height, metres? True outside the grid, where the flood is
// unknown.
static bool collision_flood_near(const CollisionFlood *flood, Vec3 foot, double reach, double rise) {
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

// The shortest and the longest step, metres: lengths are evenly distributed over their logarithm.
static const double SHORTEST = 0.001, LONGEST = 5.0;
// Shares of the steps at which the body turns, is put elsewhere, and a door is used.
static const double TURNS = 0.1, MOVES = 0.002, DOORS = 0.05;
// The time between two steps, seconds: TICK, but STALL for a share STALLS of the steps, as when the machine stalls.
static const double TICK = 1.0 / 60, STALL = 5.0, STALLS = 0.001;
// A body must be this near in plan to a place of the loose flood, metres: twice FLOOD_APART.
static const double STRAY = 0.1;
// A body this near to the end of a way of the flood has arrived, metres.
static const double ARRIVED = 0.02;
// Steps that lead less far than this lead nowhere, metres.
static const double STILL = 1e-3;
enum { TRACE = 4096 };

typedef struct Watch {
    const CellGraph *graph;
    const CollisionWalkOptions *options;
    CollisionReport *out;
    Doors doors;
    BodyWorld world;
    BodyTrace trace;
    CollisionCheck *check;
    CollisionFlood strict, loose;
    Body body;
    Random random;
    double heading;
    bool fell;  // since the body was last near a place of the loose flood
} Watch;

// Writes a sentence to `out`, unless an earlier sentence is there.
static void report(const Watch *w, char out[256], const char *kind, Vec3 at, int what) {
    if (out[0]) return;
    snprintf(out, 256, "seed %llu, step %ld: %s (%d), foot at (%.9g, %.9g, %.9g)",
             (unsigned long long)w->options->seed, w->out->steps, kind, what, at.x, at.y, at.z);
}

static void add_hash(uint64_t *hash, Vec3 v) {
    union {
        double value;
        uint64_t bits;
    } part[3] = {{v.x}, {v.y}, {v.z}};
    for (int i = 0; i < 3; i++) *hash = (*hash ^ part[i].bits) * 0x100000001b3u;
}

// ---- one step

static void watch_way(Watch *w) {
    for (int i = 1; i < w->trace.count; i++) {
        int what;
        Vec3 from = w->trace.points[i - 1], to = w->trace.points[i], corner = vec3(from.x, from.y, to.z);
        // The body rises first and sinks last, so that a level part is checked at the height at which it was walked.
        if (from.z > to.z) corner = vec3(to.x, to.y, from.z);
        CollisionFault f = collision_check_way(w->check, w->doors.open, from, corner, &what);
        if (f == COLLISION_NONE) f = collision_check_way(w->check, w->doors.open, corner, to, &what);
        if (f == COLLISION_NONE) continue;
        w->out->faults[f]++;
        report(w, w->out->first_fault, COLLISION_FAULT_NAMES[f], to, what);
    }
}

// Does the body stand on the rim of its disc only? A ledge of some centimetres carries the rim, and the body walks along the ledge;
// the flood, whose disc is small, does not.
static bool stands_on_its_rim(Watch *w) {
    const double within = BODY_RADIUS / 2, level = 0.01;
    Vec3 foot = w->body.foot;
    Box box = {{foot.x - within, foot.y - within, foot.z - level},
               {foot.x + within, foot.y + within, foot.z + level}};
    const int *near;
    int count = collision_check_near(w->check, box, &near);
    for (int i = 0; i < count; i++) {
        const Polygon *p = &w->graph->polygons[near[i]];
        const Vec3 *v = w->graph->vertices + p->first_vertex;
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < p->vertex_count; k++) {
            low = fmin(low, v[k].z);
            high = fmax(high, v[k].z);
        }
        if (high < foot.z - level || low > foot.z + level) continue;
        if (collision_plan_distance(v, p->vertex_count, vec2(foot.x, foot.y)) < within) return false;
    }
    return true;
}

static void watch_place(Watch *w) {
    int what;
    CollisionFault f = collision_check_place(w->check, w->doors.open, w->body.foot, w->body.height, &what);
    if (f != COLLISION_NONE) {
        w->out->faults[f]++;
        report(w, w->out->first_fault, COLLISION_FAULT_NAMES[f], w->body.foot, what);
    }
    // A body that falls may land where no body walks to.
    if (!w->body.standing) w->fell = true;
    if (collision_flood_near(&w->loose, w->body.foot, STRAY, 2 * BODY_STEP)) {
        w->fell = !w->body.standing;
    } else if (!w->fell && !stands_on_its_rim(w)) {
        w->out->strays++;
        report(w, w->out->first_fault, "where no foot gets", w->body.foot, -1);
    }
}

// Does no way lead anywhere from the body's place, with the doors as they are?
static bool is_stuck(Watch *w) {
    enum { WAYS = 16 };
    for (int i = 0; i < WAYS; i++) {
        Body copy = w->body;
        long relocations = w->world.relocations;
        double angle = 2 * M_PI * i / WAYS;
        body_step(&copy, &w->world, vec2(BODY_RADIUS * cos(angle), BODY_RADIUS * sin(angle)), 0);
        bool stands = w->world.relocations == relocations;
        w->world.relocations = relocations;
        if (stands && vec3_length(vec3_sub(copy.foot, w->body.foot)) > STILL) return false;
    }
    return true;
}

// Does one door hold the body there, as when a leaf swings in front of a corner? If so, a way leads on with this door open or
// closed.
static bool is_shut_in(Watch *w) {
    bool shut = false;
    for (int i = 0; i < w->graph->building->opening_count && !shut; i++) {
        float was = w->doors.open[i];
        for (int end = 0; end <= 1 && !shut; end++) {
            w->doors.open[i] = (float)end;
            shut = !is_stuck(w);
        }
        w->doors.open[i] = was;
    }
    return shut;
}

static void move_doors(Watch *w, double seconds) {
    int openings = w->graph->building->opening_count;
    if (openings > 0 && random_unit(&w->random) < DOORS)
        doors_toggle(&w->doors, random_index(&w->random, openings));
    doors_advance(&w->doors, seconds, &w->body);
}

static void take_step(Watch *w) {
    Random *r = &w->random;
    double seconds = random_unit(r) < STALLS ? STALL : TICK;
    if (random_unit(r) < TURNS) w->heading = random_between(r, 0, 2 * M_PI);
    if (random_unit(r) < MOVES && w->strict.place_count > 0) {
        body_place_near(&w->body, &w->world, w->strict.places[random_index(r, w->strict.place_count)].foot);
    }
    move_doors(w, seconds);
    watch_place(w);  // doors have moved
    double length = SHORTEST * pow(LONGEST / SHORTEST, random_unit(r));
    Vec3 was = w->body.foot;
    w->trace.count = 0;
    w->world.trace = &w->trace;
    double start = clock_seconds();
    body_step(&w->body, &w->world, vec2(length * cos(w->heading), length * sin(w->heading)), seconds);
    w->out->seconds += clock_seconds() - start;
    w->world.trace = NULL;
    watch_way(w);
    watch_place(w);
    add_hash(&w->out->hash, w->body.foot);
    double gone = vec3_length(vec3_sub(w->body.foot, was));
    if (gone < STILL && length > BODY_RADIUS && is_stuck(w))
        ++*(is_shut_in(w) ? &w->out->shut_in : &w->out->stuck);
    w->out->steps++;
}

// ---- the ways of the flood

// Puts a body at a place of the flood; false if the body does not stay there.
static bool take_stand(Watch *w, Vec3 foot, Body *out) {
    int cell = vis_locate(w->graph, vec3(foot.x, foot.y, foot.z + BODY_MIDDLE), -1);
    *out = (Body){.foot = foot, .height = BODY_LOWEST, .standing = true, .cell = cell};
    body_step(out, &w->world, vec2(0, 0), TICK);
    return vec3_length(vec3_sub(out->foot, foot)) < STILL;
}

static bool arrives(Watch *w, Body body, Vec3 to) {
    body_step(&body, &w->world, vec2(to.x - body.foot.x, to.y - body.foot.y), 0);
    return hypot(body.foot.x - to.x, body.foot.y - to.y) <= ARRIVED && fabs(body.foot.z - to.z) <= BODY_STEP;
}

static void walk_flood(Watch *w) {
    for (int i = 0; i < w->graph->building->opening_count; i++) doors_set(&w->doors, i, 1);
    for (int i = 0; i < w->strict.place_count; i++) {
        const FloodPlace *p = &w->strict.places[i];
        for (int k = 0; k < 4; k++) {
            if (p->link[k] < 0 || (4 * i + k) % w->options->flood_every != 0) continue;
            Body body;
            w->out->flood_ways++;
            if (!take_stand(w, p->foot, &body)) {
                // The disc's rim and the sides of the polygon that stands for it differ by a millimetre.
                w->out->flood_doubtful++;
                continue;
            }
            if (arrives(w, body, w->strict.places[p->link[k]].foot)) continue;
            w->out->flood_lost++;
            report(w, w->out->first_lost, "cannot go on as the flood does", p->foot, k);
        }
    }
    w->out->flood_places = w->strict.place_count;
}

// ---- the whole walk

static bool begin_watch(Watch *w, Arena *arena, Error *error) {
    const Building *b = w->graph->building;
    w->doors = doors_new(w->graph, arena);
    w->world = body_world(w->graph, w->doors.open, arena);
    w->trace = (BodyTrace){.points = ARENA_ARRAY(arena, Vec3, TRACE), .capacity = TRACE};
    w->check = collision_check_new(w->graph, arena);
    w->random = (Random){w->options->seed};
    for (int i = 0; i < b->opening_count; i++) doors_set(&w->doors, i, 1);
    if (!body_place_near(&w->body, &w->world, vec3(b->start.x, b->start.y, b->start.z - BODY_EYE))) {
        return error_set(error, "%s: nobody can stand within %g m of its start at %.3f,%.3f,%.3f",
                         b->source ? b->source : "building", BODY_SEARCH, b->start.x, b->start.y, b->start.z);
    }
    FloodRules strict = flood_strict(), loose = flood_loose();
    w->strict = collision_flood(w->check, w->graph, &strict, arena);
    w->loose = collision_flood(w->check, w->graph, &loose, arena);
    return true;
}

long collision_violations(const CollisionReport *report) {
    long sum = report->strays;
    for (int i = COLLISION_NONE + 1; i < COLLISION_FAULTS; i++) sum += report->faults[i];
    return sum;
}

bool collision_walk(const CellGraph *graph, const CollisionWalkOptions *options, CollisionReport *out,
                    Error *error) {
    Arena arena = {0};
    *out = (CollisionReport){.hash = 0xcbf29ce484222325u};
    Watch w = {.graph = graph, .options = options, .out = out, .body = {.cell = -1}};
    bool good = begin_watch(&w, &arena, error);
    if (good) {
        walk_flood(&w);
        w.world.wall_tests = w.world.object_tests = w.world.pieces = w.world.relocations = w.world.refused =
            0;
        while (out->steps < options->steps) take_step(&w);
        out->wall_tests = w.world.wall_tests;
        out->object_tests = w.world.object_tests;
        out->pieces = w.world.pieces;
        out->relocations = w.world.relocations;
        out->refused = w.world.refused;
    }
    arena_free(&arena);
    return good;
}
