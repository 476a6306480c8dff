// test_doors_looked_at.c - doors that are looked at, told how to stand, and kept when a file changes.
#include <criterion/criterion.h>

#include "engine/sim/door_states.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/sim/doors_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

// Proves which door is meant: the one looked at within reach, not the one behind a wall or behind one's back.
Test(doors, looked_at) {
    Made m;
    doors_check_make(&m, "door a 4.075,1.5 angle 90 width 0.9 height 2\n"
                         "door b 8.225,1.5 angle 90 width 0.9 height 2\n");
    Vec3 eye = vec3(2.5, 1.5, 1.6), east = vec3(1, 0, 0);
    int cell = vis_locate(&m.graph, eye, -1);
    cr_expect_eq(doors_looked_at(&m.doors, eye, cell, east, DOORS_REACH), 0);
    cr_expect_eq(doors_looked_at(&m.doors, eye, cell, vec3(-1, 0, 0), DOORS_REACH), -1);
    cr_expect_eq(doors_looked_at(&m.doors, vec3(0.5, 1.5, 1.6), cell, east, DOORS_REACH), -1, "out of reach");
    cr_expect_eq(doors_looked_at(&m.doors, vec3(2.5, 3.5, 1.6), cell, east, 10), -1, "a wall");
    // Open, it is its doorway that is meant, from sill to head: the leaf is out of the way.
    doors_set(&m.doors, 0, 1);
    cr_expect_eq(doors_looked_at(&m.doors, eye, cell, east, DOORS_REACH), 0);
    cr_expect_eq(doors_looked_at(&m.doors, vec3(2.5, 1.5, 2.2), cell, east, DOORS_REACH), -1,
                 "above its head");
    Vec3 slant = vec3_normalize(vec3(8.225 - 6.5, 0, -0.3));
    eye = vec3(6.5, 1.5, 1.6);
    cr_expect_eq(doors_looked_at(&m.doors, eye, vis_locate(&m.graph, eye, -1), slant, DOORS_REACH), 1);
    arena_free(&m.arena);
}

// Proves what the states of doors are: open, closed, as drawn, and at random closed, wide open, anywhere and hardly open (the fourth power
// of a share, so half of them below a sixteenth), each in a quarter of cases. Tolerance: four standard deviations, 0.009 at most.
Test(doors, stand_as_they_are_told) {
    enum { DRAWS = 40000 };
    Opening opening = {.kind = OPENING_DOOR, .open = 0.3};
    Building b = {.openings = &opening, .opening_count = 1};
    Random random = {5};
    int shut = 0, wide = 0, hardly = 0, most = 0;
    for (int i = 0; i < DRAWS; i++) {
        Random before = random;
        float share = walk_door_share(&b, 0, WALK_DOORS_RANDOM, &random);
        cr_assert(share >= 0 && share <= 1);
        Random after[3] = {before, before, before};
        cr_assert_eq(walk_door_share(&b, 0, WALK_DOORS_OPEN, &after[0]), 1.0f);
        cr_assert_eq(walk_door_share(&b, 0, WALK_DOORS_CLOSED, &after[1]), 0.0f);
        cr_assert_eq(walk_door_share(&b, 0, WALK_DOORS_DRAWN, &after[2]), 0.3f);
        for (int k = 0; k < 3; k++)
            cr_assert_eq(random_next(&after[k]), random_next(&(Random){random.state}),
                         "all states draw alike");
        shut += share == 0;
        wide += share == 1;
        hardly += share > 0 && share < 1.0f / 16;
        most += share > 0.9f && share < 1;
    }
    cr_expect_float_eq(shut / (double)DRAWS, 0.25, 0.009);
    cr_expect_float_eq(wide / (double)DRAWS, 0.25, 0.009);
    cr_expect_float_eq(hardly / (double)DRAWS, (1.0 / 16 + 0.5) / 4, 0.009);
    cr_expect_float_eq(most / (double)DRAWS, (0.1 + 1 - sqrt(sqrt(0.9))) / 4, 0.009);
}

// Proves that doors that share a name, as all do that Sweet Home 3D was not told a name for, stand as they did after the file was read
// again: by place, whatever their order; one that was moved by name, as the nearest that has no other's place; a new one as drawn.
Test(doors, are_kept_by_place_then_by_name) {
    Made before, after;
    doors_check_make(&before, "door Door 4.075,0.7 angle 90 width 0.9 height 2\n"
                              "door Door 4.075,1.8 angle 90 width 0.9 height 2\n"
                              "door other 4.075,3.2 angle 90 width 0.9 height 2\n");
    doors_set(&before.doors, 1, 1);
    doors_set(&before.doors, 2, 0.25f);
    // The second first, the first moved along the wall, `other` renamed where it stands.
    doors_check_make(&after, "door Door 4.075,1.8 angle 90 width 0.9 height 2\n"
                             "door Door 4.075,0.6 angle 90 width 0.9 height 2\n"
                             "door Door 4.075,3.2 angle 90 width 0.9 height 2\n");
    doors_keep(&after.doors, &before.doors);
    cr_expect_eq(after.doors.open[0], 1.0f);
    cr_expect_eq(after.doors.open[1], 0.0f);
    cr_expect_eq(after.doors.open[2], 0.25f);
    arena_free(&after.arena);
    // The moved one was the open one; the other keeps its place.
    doors_check_make(&after, "door Door 4.075,0.7 angle 90 width 0.9 height 2\n"
                             "door Door 4.075,2.1 angle 90 width 0.9 height 2\n"
                             "door fresh 4.075,3.3 angle 90 width 0.9 height 2\n");
    doors_keep(&after.doors, &before.doors);
    cr_expect_eq(after.doors.open[0], 0.0f);
    cr_expect_eq(after.doors.open[1], 1.0f);
    cr_expect_eq(after.doors.open[2], 0.0f, "a new door stands as drawn");
    arena_free(&after.arena);
    arena_free(&before.arena);
}

// ---- what is looked at

static bool in_leaf(const Building *b, const Leaf *leaf, double open, Vec3 p, double grown) {
    Vec2 corner[LEAF_CORNERS];
    int count = leaf_plan(b, leaf, open, corner);
    double low = leaf->z0 + open * leaf->rise, high = leaf->z1 + open * leaf->rise;
    if (p.z < low - grown || p.z > high + grown) return false;
    for (int i = 0; i < count; i++) {
        Vec2 a = corner[i], edge = vec2_sub(corner[(i + 1) % count], a);
        if (vec2_cross(edge, vec2_sub(vec2(p.x, p.y), a)) < -grown * vec2_length(edge)) return false;
    }
    return true;
}

// Where the ray passes a doorway between its jambs, sill and head, all moved outwards by `grown`; or INFINITY.
static double passes_doorway(const Opening *o, Vec3 eye, Vec3 way, double grown) {
    Vec2 along = vec2_sub(o->line[1], o->line[0]);
    double width = vec2_length(along);
    along = vec2_scale(along, 1 / width);
    Vec2 n = vec2(-along.y, along.x), from = vec2_sub(vec2(eye.x, eye.y), o->line[0]);
    double t = -vec2_dot(n, from) / vec2_dot(n, vec2(way.x, way.y));
    double at = vec2_dot(along, from) + t * vec2_dot(along, vec2(way.x, way.y)), z = eye.z + t * way.z;
    bool inside =
        t >= 0 && at >= -grown && at <= width + grown && z >= o->sill - grown && z <= o->head + grown;
    return inside ? t : INFINITY;
}

// The door whose leaf or doorway a ray comes to first, in steps of 4 mm, leaves and doorways larger by `grown`; -1: a wall or a window
// comes first; -2: two doors, or the wall, are about as near.
static int meant(const Doors *d, Vec3 eye, Vec3 way, double clear, double grown) {
    static const double STEP = 0.004, ABOUT = 0.03;
    const Building *b = d->graph->building;
    double nearest = INFINITY, next = INFINITY;
    int found = -1;
    for (int i = 0; i < b->opening_count; i++) {
        if (!doors_usable(d, i)) continue;
        double hit = passes_doorway(&b->openings[i], eye, way, grown);
        for (int k = 0; k < b->openings[i].leaf_count; k++) {
            const Leaf *leaf = &b->leaves[b->openings[i].first_leaf + k];
            Vec2 to = vec2_sub(leaf->pivot, vec2(eye.x, eye.y));
            if (vec2_length(to) > clear + 3) continue;
            for (double t = 0; t < fmin(hit, clear + ABOUT); t += STEP)
                if (in_leaf(b, leaf, (double)d->open[i], vec3_add(eye, vec3_scale(way, t)), grown)) hit = t;
        }
        if (hit < nearest)
            next = nearest, nearest = hit, found = i;
        else
            next = fmin(next, hit);
    }
    if (fabs(nearest - clear) < ABOUT || (next - nearest < ABOUT && nearest < clear)) return -2;
    return nearest < clear ? found : -1;
}

// Proves which door is meant in houses, from anywhere and in any direction, doors at any angle: that whose leaf or doorway a ray comes to
// first, before a wall or a window.
Test(doors, looked_at_by_rays) {
    static const char *const FILES[] = {"build/maps/house.plan", "build/maps/house.sh3d",
                                        "build/maps/villa.sh3d"};
    int some = 0, none = 0;
    for (int f = 0; f < 3; f++) {
        Made m = {.arena = {0}};
        Error error;
        Random random = {(uint64_t)f + 1};
        VisOptions options = vis_default_options();
        cr_assert(maps_read(FILES[f], &m.arena, &m.building, &error), "%s", error.text);
        cr_assert(vis_build_cells(&m.building, &options, &m.arena, &m.graph, &error), "%s", error.text);
        m.doors = doors_new(&m.graph, &m.arena);
        for (int n = 0; n < support_count(1200, 20000); n++) {
            for (int i = 0; n % 10 == 0 && i < m.building.opening_count; i++)
                doors_set(&m.doors, i, walk_random_share(&random));
            int cell = random_index(&random, m.graph.cell_count);
            Vec3 eye = fixture_point(&m.graph, &random, cell), way = fixture_direction(&random);
            way = vec3_normalize(vec3(way.x, way.y, 0.3 * way.z));
            double reach = n % 2 ? DOORS_REACH : 6;
            Trace trace;
            if (!fixture_trace(&m.graph, cell, eye, way, NULL, &trace)) continue;
            double clear = fmin(reach, vec3_length(vec3_sub(trace.hit, eye)));
            for (int i = 0; i < trace.count; i++) {
                int opening = vis_region(&m.graph, trace.cells[i])->opening;
                if (opening < 0 || m.building.openings[opening].kind != OPENING_WINDOW) continue;
                Plane plane = {{0, 0, 0}, 0};
                if (i > 0) plane = m.graph.portals[trace.portals[i - 1]].plane;
                clear = i == 0 ? 0 : fmin(clear, -plane_distance(plane, eye) / vec3_dot(plane.n, way));
            }
            int expected = meant(&m.doors, eye, way, clear, 0.006);
            if (expected == -2 || expected != meant(&m.doors, eye, way, clear, -0.006)) continue;
            int found = doors_looked_at(&m.doors, eye, cell, way, reach);
            cr_assert_eq(found, expected, "%s, ray %d from (%g, %g, %g): door %d, not %d", FILES[f], n, eye.x,
                         eye.y, eye.z, found, expected);
            some += found >= 0;
            none += found < 0;
        }
        arena_free(&m.arena);
    }
    cr_assert(some > 200 && none > 1000, "%d at doors, %d not", some, none);
}
