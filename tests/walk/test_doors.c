// Doors over time: they arrive, they wait for whoever is in the way and for one another, and go on when it is free.
#include <criterion/criterion.h>

#include "engine/sim/door_states.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

static const char ROOMS[] = "plan 1\nstorey s floor 0 height 2.6\n"
                            "room west 0,0 4,0 4,4 0,4 wall 0.15\n"
                            "room east 4.15,0 8.15,0 8.15,4 4.15,4 wall 0.15\n";

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    Doors doors;
    BodyWorld world;
    Body body;
} Made;

// The rooms with these doors, closed; the body in the middle of the western one.
static void make(Made *m, const char *doors) {
    Error error;
    VisOptions options = vis_default_options();
    *m = (Made){.body = {.cell = -1}};
    char *path = arena_format(&m->arena, "%s/doors.plan", support_folder(&m->arena));
    char *text = arena_format(&m->arena, "%s%s", ROOMS, doors);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert(maps_read(path, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    m->doors = doors_new(&m->graph, &m->arena);
    m->world = body_world(&m->graph, m->doors.open, &m->arena);
    cr_assert(body_place_near(&m->body, &m->world, vec3(2, 3, 0)));
}

// ---- an oracle for leaves: corners and edges, no more

static bool apart_along_edges(const Vec2 a[4], const Vec2 b[4]) {
    for (int i = 0; i < 4; i++) {
        Vec2 edge = vec2_sub(a[(i + 1) % 4], a[i]);
        bool all_right = true;
        for (int k = 0; k < 4; k++) all_right = all_right && vec2_cross(edge, vec2_sub(b[k], a[i])) <= 0;
        if (all_right) return true;
    }
    return false;
}

static double distance_to_leaf(const Leaf *leaf, double open, Vec2 p) {
    Vec2 box[4];
    double nearest = INFINITY;
    bool inside = true;
    leaf_box(leaf, open, box);
    for (int i = 0; i < 4; i++) {
        Vec2 edge = vec2_sub(box[(i + 1) % 4], box[i]), to = vec2_sub(p, box[i]);
        double t = fmin(fmax(vec2_dot(to, edge) / vec2_dot(edge, edge), 0), 1);
        nearest = fmin(nearest, vec2_length(vec2_sub(to, vec2_scale(edge, t))));
        inside = inside && vec2_cross(edge, to) >= 0;
    }
    return inside ? 0 : nearest;
}

// No leaf in another, none in the body.
static void expect_clear(const Made *m) {
    const Building *b = &m->building;
    Vec2 at = vec2(m->body.foot.x, m->body.foot.y);
    for (int i = 0; i < b->leaf_count; i++) {
        double open = (double)m->doors.open[b->leaves[i].opening];
        Vec2 box[4];
        leaf_box(&b->leaves[i], open, box);
        cr_assert_geq(distance_to_leaf(&b->leaves[i], open, at), BODY_RADIUS, "leaf %d touches the body", i);
        for (int k = 0; k < i; k++) {
            Vec2 other[4];
            leaf_box(&b->leaves[k], (double)m->doors.open[b->leaves[k].opening], other);
            cr_assert(apart_along_edges(box, other) || apart_along_edges(other, box),
                      "leaves %d and %d lie in one another", i, k);
        }
    }
}

static void pass(Made *m, double seconds) {
    for (double t = 0; t < seconds; t += 1.0 / 120) {
        doors_advance(&m->doors, 1.0 / 120, &m->body);
        expect_clear(m);
    }
}

// Proves that every kind of door opens all the way, over time and not at once, and closes to exactly nothing: single,
// double, sliding, glazed, and one drawn ajar.
Test(doors, open_and_close) {
    static const char *const DOORS[] = {
        "door d 4.075,1.5 angle 90 width 0.9 height 2\n",
        "door d 4.075,1.5 angle 90 width 1.6 height 2 hinge both swing -85\n",
        "door d 4.075,1.5 angle 90 width 0.9 height 2 slide 0.85\n",
        "door d 4.075,1.5 angle 90 width 1.6 height 2 hinge both slide 0.7\n",
        "door d 4.075,1.5 angle 90 width 1.4 height 2 hinge both swing 88 glazed\n",
        "door d 4.075,1.5 angle 90 width 0.9 height 2 hinge right swing 100 open 0.3\n"};
    for (size_t i = 0; i < sizeof DOORS / sizeof *DOORS; i++) {
        Made m;
        make(&m, DOORS[i]);
        bool ajar = m.doors.open[0] > 0;
        cr_assert(ajar == (i == 5) && (!ajar || m.doors.open[0] == 0.3f), "door %zu begins as drawn", i);
        cr_assert(doors_toggle(&m.doors, 0));
        pass(&m, 0.2);
        cr_expect(m.doors.open[0] > 0 && m.doors.open[0] < 1, "door %zu is on its way, at %g", i,
                  (double)m.doors.open[0]);
        pass(&m, 3);
        cr_expect_eq(m.doors.open[0], 1.0f, "door %zu", i);
        cr_assert(doors_toggle(&m.doors, 0));
        pass(&m, 3);
        cr_expect_eq(m.doors.open[0], 0.0f, "door %zu", i);
        arena_free(&m.arena);
    }
}

// Proves that a door halts before whoever stands in its doorway, wherever in it, and closes when they have gone.
Test(doors, wait_for_the_body) {
    for (int i = 0; i <= 10; i++) {
        Made m;
        make(&m, "door d 4.075,1.5 angle 90 width 0.9 height 2 hinge left swing -88\n");
        doors_set(&m.doors, 0, 1);
        double x = 4.075 + 0.1 * (i - 5);
        cr_assert(body_place_near(&m.body, &m.world, vec3(x, 1.55, 0)));
        doors_toggle(&m.doors, 0);
        pass(&m, 5);
        bool in_the_way =
            distance_to_leaf(&m.building.leaves[0], 0, vec2(m.body.foot.x, m.body.foot.y)) < BODY_RADIUS;
        if (in_the_way) {
            cr_expect_gt(m.doors.open[0], 0.0f, "at x = %g the door closes onto the body", x);
            cr_expect_eq(m.doors.halt[0], DOOR_MEETS_BODY);
        }
        for (int k = 0; k < 300; k++) body_step(&m.body, &m.world, vec2(-0.01, 0), 0.01);
        pass(&m, 5);
        cr_expect_eq(m.doors.open[0], 0.0f, "from x = %g: it closes when the way is free", x);
        arena_free(&m.arena);
    }
}

// Proves that nobody passes a closed door, of glass or not, nor a leaf that stands half open in the way.
Test(doors, hold_the_body) {
    for (int glazed = 0; glazed < 2; glazed++) {
        for (int half = 0; half < 2; half++) {
            Made m;
            make(&m, glazed ? "door d 4.075,1.5 angle 90 width 0.9 height 2 glazed\n"
                            : "door d 4.075,1.5 angle 90 width 0.9 height 2\n");
            doors_set(&m.doors, 0, half ? 0.25f : 0);
            cr_assert(body_place_near(&m.body, &m.world, vec3(3, 1.5, 0)));
            for (int k = 0; k < 400; k++) body_step(&m.body, &m.world, vec2(0.01, 0), 0.01);
            cr_expect_lt(m.body.foot.x, 4.075, "glazed %d, half %d", glazed, half);
            doors_set(&m.doors, 0, 1);
            for (int k = 0; k < 400; k++) body_step(&m.body, &m.world, vec2(0.01, 0), 0.01);
            cr_expect_gt(m.body.foot.x, 5, "glazed %d: open, it lets pass", glazed);
            arena_free(&m.arena);
        }
    }
}

// Proves that two doors hung on one jamb both open, at once or one after the other, and never through one another.
Test(doors, share_a_jamb) {
    for (int delay = 0; delay < 4; delay++) {
        Made m;
        make(&m, "door a 4.075,1.0 angle 90 width 0.9 height 2 hinge right swing 88\n"
                 "door b 4.075,2.0 angle 90 width 0.9 height 2 hinge left swing -88\n"
                 "door c 4.075,3.0 angle 90 width 0.9 height 2 hinge left swing -88\n");
        doors_toggle(&m.doors, 0);
        pass(&m, 0.2 * delay);
        doors_toggle(&m.doors, 1);
        doors_toggle(&m.doors, 2);
        pass(&m, 4);
        for (int i = 0; i < 3; i++) cr_expect_eq(m.doors.open[i], 1.0f, "door %d, delay %d", i, delay);
        arena_free(&m.arena);
    }
}

// Proves that a door which would swing into another waits for it, and goes on when that one has closed.
Test(doors, wait_for_one_another) {
    Made m;
    make(&m, "door a 4.075,1.0 angle 90 width 0.9 height 2 hinge left swing -88\n"
             "door b 4.8,-0.075 width 0.9 height 2 hinge left swing 88\n");
    doors_toggle(&m.doors, 0);
    pass(&m, 3);
    cr_assert_eq(m.doors.open[0], 1.0f);
    doors_toggle(&m.doors, 1);
    pass(&m, 5);
    cr_expect(m.doors.open[1] > 0 && m.doors.open[1] < 1, "it stands at %g", (double)m.doors.open[1]);
    cr_expect_eq(m.doors.halt[1], DOOR_MEETS_DOOR);
    doors_toggle(&m.doors, 0);
    pass(&m, 5);
    cr_expect_eq(m.doors.open[0], 0.0f);
    cr_expect_eq(m.doors.open[1], 1.0f, "the way is free");
    arena_free(&m.arena);
}

// Metres between leaves 0 and 1, which do not overlap: at a corner of one of them.
static double leaf_gap(const Made *m) {
    double gap = INFINITY;
    for (int i = 0; i < 2; i++) {
        const Leaf *one = &m->building.leaves[i], *other = &m->building.leaves[1 - i];
        Vec2 box[4];
        leaf_box(one, (double)m->doors.open[one->opening], box);
        for (int k = 0; k < 4; k++)
            gap = fmin(gap, distance_to_leaf(other, (double)m->doors.open[other->opening], box[k]));
    }
    return gap;
}

// Proves that leaves halt a centimetre before one another and before a body, and no farther off than a step of another centimetre,
// in frames of any length: what is in the way of a long one is not passed over. 1e-6: shares are floats.
Test(doors, halt_a_centimetre_off) {
    static const double FRAMES[] = {1.0 / 240, 1.0 / 30, 0.2, 3};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 8; k++) {
            Made m;
            make(&m, "door a 4.075,1.0 angle 90 width 0.9 height 2 hinge left swing -88\n"
                     "door b 4.8,-0.075 width 0.9 height 2 hinge left swing 88\n");
            doors_set(&m.doors, 0, 0.65f + 0.05f * (float)k);
            doors_toggle(&m.doors, 1);
            for (double t = 0; t < 3; t += FRAMES[i]) doors_advance(&m.doors, FRAMES[i], NULL);
            double gap = leaf_gap(&m);
            cr_expect_eq(m.doors.halt[1], DOOR_MEETS_DOOR);
            cr_expect(gap > 0.01 - 1e-6 && gap < 0.02 + 1e-6, "%g m to the other leaf, frames of %g s, %d",
                      gap, FRAMES[i], k);
            arena_free(&m.arena);

            make(&m, "door d 4.075,1.5 angle 90 width 0.9 height 2 hinge left swing -88\n");
            doors_set(&m.doors, 0, 1);
            cr_assert(body_place_near(&m.body, &m.world, vec3(3.95 + 0.02 * k, 1.55, 0)));
            doors_toggle(&m.doors, 0);
            for (double t = 0; t < 3; t += FRAMES[i]) doors_advance(&m.doors, FRAMES[i], &m.body);
            Vec2 at = vec2(m.body.foot.x, m.body.foot.y);
            gap = distance_to_leaf(&m.building.leaves[0], (double)m.doors.open[0], at) - BODY_RADIUS;
            cr_expect_eq(m.doors.halt[0], DOOR_MEETS_BODY);
            cr_expect(gap > 0.01 - 1e-6 && gap < 0.02 + 1e-6, "%g m to the body, frames of %g s, %d", gap,
                      FRAMES[i], k);
            arena_free(&m.arena);
        }
    }
}

// Proves that an opening takes the time it should, in frames of any length.
Test(doors, open_in_nine_tenths_of_a_second) {
    for (int frames = 1; frames <= 100; frames *= 10) {
        Made m;
        make(&m, "door d 4.075,1.5 angle 90 width 0.9 height 2\n");
        doors_toggle(&m.doors, 0);
        for (int i = 0; i < frames; i++) doors_advance(&m.doors, 0.45 / frames, NULL);
        cr_expect_float_eq(m.doors.open[0], 0.5, 1e-4, "halfway in half the time, %d frames", frames);
        doors_toggle(&m.doors, 0);
        doors_toggle(&m.doors, 0);
        doors_advance(&m.doors, 0.4501, NULL);
        cr_expect_eq(m.doors.open[0], 1.0f);
        arena_free(&m.arena);
    }
}

// Proves that no door is used through a window, which lets sight through but no hand; through a passage it is.
Test(doors, are_not_used_through_windows) {
    static const char DOOR[] = "door b 8.225,1.5 angle 90 width 0.9 height 2\n";
    static const char *const BETWEEN[] = {"window w 4.075,1.5 angle 90 width 1 sill 0.5 height 1.8\n",
                                          "passage p 4.075,1.5 angle 90 width 1 height 2.3\n"};
    for (int i = 0; i < 2; i++) {
        Made m;
        Arena arena = {0};
        make(&m, arena_format(&arena, "%s%s", BETWEEN[i], DOOR));
        arena_free(&arena);
        for (int k = -4; k <= 4; k++) {
            Vec3 eye = vec3(2.5, 1.5 + 0.05 * k, 1.6);
            int found = doors_looked_at(&m.doors, eye, vis_locate(&m.graph, eye, -1), vec3(1, 0, 0), 10);
            cr_expect_eq(found, i == 0 ? -1 : 1, "opening %d is meant, %d", found, k);
        }
        arena_free(&m.arena);
    }
}

// Proves which door is meant: the one looked at within reach, not the one behind a wall or behind one's back.
Test(doors, looked_at) {
    Made m;
    make(&m, "door a 4.075,1.5 angle 90 width 0.9 height 2\n"
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
    make(&before, "door Door 4.075,0.7 angle 90 width 0.9 height 2\n"
                  "door Door 4.075,1.8 angle 90 width 0.9 height 2\n"
                  "door other 4.075,3.2 angle 90 width 0.9 height 2\n");
    doors_set(&before.doors, 1, 1);
    doors_set(&before.doors, 2, 0.25f);
    // The second first, the first moved along the wall, `other` renamed where it stands.
    make(&after, "door Door 4.075,1.8 angle 90 width 0.9 height 2\n"
                 "door Door 4.075,0.6 angle 90 width 0.9 height 2\n"
                 "door Door 4.075,3.2 angle 90 width 0.9 height 2\n");
    doors_keep(&after.doors, &before.doors);
    cr_expect_eq(after.doors.open[0], 1.0f);
    cr_expect_eq(after.doors.open[1], 0.0f);
    cr_expect_eq(after.doors.open[2], 0.25f);
    arena_free(&after.arena);
    // The moved one was the open one; the other keeps its place.
    make(&after, "door Door 4.075,0.7 angle 90 width 0.9 height 2\n"
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
