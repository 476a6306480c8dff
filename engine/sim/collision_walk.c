// collision_walk.c - a body that walks at random, watched at every step.
#include "engine/sim/collision_walk.h"

#include <stdio.h>

#include "engine/core/clock.h"
#include "engine/sim/collision_flood.h"
#include "engine/sim/doors.h"

// Lengths of steps, metres: evenly spread over their logarithm.
static const double SHORTEST = 0.001, LONGEST = 5.0;
// How often it turns, is put elsewhere, and a door is used: shares of the steps.
static const double TURNS = 0.1, MOVES = 0.002, DOORS = 0.05;
// Between two steps, seconds; now and then the machine stalls.
static const double TICK = 1.0 / 60, STALL = 5.0, STALLS = 0.001;
// A body is as near as this to where a foot may get: twice the diagonal of a square of the flood, in plan.
static const double STRAY = 0.1;
// Arrived where a way of the flood leads, metres.
static const double ARRIVED = 0.02;
// Steps that lead less far lead nowhere, metres.
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
    bool fell;  // since it last was where a foot gets
} Watch;

// Writes a sentence, of which the first is kept.
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
        // Rising first, sinking last: a level part is at the height at which it was walked.
        if (from.z > to.z) corner = vec3(to.x, to.y, from.z);
        CollisionFault f = collision_check_way(w->check, w->doors.open, from, corner, &what);
        if (f == COLLISION_NONE) f = collision_check_way(w->check, w->doors.open, corner, to, &what);
        if (f == COLLISION_NONE) continue;
        w->out->faults[f]++;
        report(w, w->out->first_fault, COLLISION_FAULT_NAMES[f], to, what);
    }
}

// A ledge of some centimetres carries the rim of a body, and one walks along it; the flood, whose disc is small, does not.
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
    // Who falls may land where nobody walks to.
    if (!w->body.standing) w->fell = true;
    if (collision_flood_near(&w->loose, w->body.foot, STRAY, 2 * BODY_STEP)) {
        w->fell = !w->body.standing;
    } else if (!w->fell && !stands_on_its_rim(w)) {
        w->out->strays++;
        report(w, w->out->first_fault, "where no foot gets", w->body.foot, -1);
    }
}

// From where it is, does any way lead anywhere, with the doors as they are?
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

// Is it one door that holds it there, as when a leaf swings before a corner? Then a way leads where that one is open, or closed.
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

// Begins as the flood stands there, if that is how a body stands.
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

// ---- all of it

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
