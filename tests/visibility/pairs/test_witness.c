// test_witness.c - the second walk of sightlines: on rooms whose lines can be told by hand, and against the ray of
// fixture.c, which finds its way by the walls instead of the portals.
#include <criterion/criterion.h>

#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "visibility/pairs/sight.h"
#include "visibility/pairs/witness.h"

// Three rooms along x with doorways of 2 x 2 m at x = 2 m (y 0 to 2) and x = 4 m (y 3 to 5), and a fourth above the
// third, through a hatch at z = 2 m.
static const char ROOMS[] = "PRT1\n4\n3\n"
                            "4 0 1 (64 0 64 ) (64 0 0 ) (64 64 0 ) (64 64 64 )\n"
                            "4 1 2 (128 96 64 ) (128 96 0 ) (128 160 0 ) (128 160 64 )\n"
                            "4 2 3 (192 96 64 ) (192 128 64 ) (160 128 64 ) (160 96 64 )\n";

typedef struct Rooms {
    Arena arena;
    CellGraph *graph;
} Rooms;

static Rooms rooms(void) {
    Rooms r = {{0}, NULL};
    r.graph = prt_scene(&r.arena, ROOMS);
    return r;
}

static bool proves(const Rooms *r, int a, int b, Vec3 from, Vec3 to) {
    bool there = witness_walk(r->graph, a, b, from, to).proves;
    cr_expect_eq(there, witness_walk(r->graph, b, a, to, from).proves, "sight is symmetric");
    return there;
}

// Through the middle of a doorway, and how near it comes to the edges.
Test(witness, measures_its_margin) {
    Rooms r = rooms();
    WitnessWalk walk = witness_walk(r.graph, 0, 1, vec3(1, 1, 1), vec3(3, 1, 1));
    cr_expect(walk.proves);
    cr_expect_eq(walk.crossed, 1);
    cr_expect_float_eq(walk.margin, 1, 1e-12);
    cr_expect_float_eq(walk.flattest, 1, 1e-12);
    // Aslant at 45 degrees the nearest upright edge, a metre off, is 1 / sqrt 2 from the line.
    walk = witness_walk(r.graph, 0, 1, vec3(1, 0, 1), vec3(3, 2, 1));
    cr_expect(walk.proves);
    cr_expect_float_eq(walk.margin, sqrt(0.5), 1e-12);
    cr_expect_float_eq(walk.flattest, sqrt(0.5), 1e-12);
    arena_free(&r.arena);
}

// Beside the doorway, above it, along its edge, and just inside: by 1 mm it proves, by a picometre it does not.
Test(witness, keeps_off_edges) {
    Rooms r = rooms();
    cr_expect_not(proves(&r, 0, 1, vec3(1, 3, 1), vec3(3, 3, 1)));
    cr_expect_not(proves(&r, 0, 1, vec3(1, 1, 3), vec3(3, 1, 3)));
    cr_expect_not(proves(&r, 0, 1, vec3(1, 2, 1), vec3(3, 2, 1)));
    cr_expect_not(proves(&r, 0, 1, vec3(1, 2 - 1e-12, 1), vec3(3, 2 - 1e-12, 1)));
    cr_expect_not(proves(&r, 0, 1, vec3(1, 0, 0), vec3(3, 0, 0)));
    cr_expect(proves(&r, 0, 1, vec3(1, 2 - 1e-3, 1), vec3(3, 2 - 1e-3, 1)));
    cr_expect(proves(&r, 0, 1, vec3(1, 1e-3, 1e-3), vec3(3, 1e-3, 1e-3)));
    arena_free(&r.arena);
}

// A line that hardly crosses the wall, at an angle of 1e-7, proves nothing; at 1e-3 it does.
Test(witness, refuses_flat_angles) {
    Rooms r = rooms();
    cr_expect_not(proves(&r, 0, 1, vec3(2 - 5e-8, 0.5, 1), vec3(2 + 5e-8, 1.5, 1)));
    cr_expect(proves(&r, 0, 1, vec3(2 - 5e-4, 0.5, 1), vec3(2 + 5e-4, 1.5, 1)));
    cr_expect_not(proves(&r, 0, 1, vec3(2, 0.5, 1), vec3(2, 1.5, 1)));
    arena_free(&r.arena);
}

// From room 0 to room 2 a line must come through both doorways, in that order; to room 3 through the hatch besides.
Test(witness, follows_the_rooms) {
    Rooms r = rooms();
    Vec3 from = vec3(1, 0.1, 1), beyond = vec3(4.5, 4.2, 1);
    WitnessWalk walk = witness_walk(r.graph, 0, 2, from, beyond);
    cr_expect(walk.proves);
    cr_expect_eq(walk.crossed, 2);
    cr_expect(witness_walk(r.graph, 0, 1, from, beyond).proves, "it comes through room 1");
    cr_expect_not(proves(&r, 0, 3, from, beyond));
    cr_expect_not(proves(&r, 0, 2, vec3(1, 1, 1), vec3(5, 1, 1)), "the wall of room 1 is in the way");
    cr_expect_not(proves(&r, 0, 2, vec3(1, 4, 1), vec3(5, 4, 1)), "the second doorway alone will not do");
    cr_expect(proves(&r, 2, 3, vec3(5.5, 3.5, 1), vec3(5.5, 3.5, 3)));
    cr_expect(proves(&r, 1, 3, vec3(3.5, 3.2, 0.1), vec3(5.5, 3.6, 2.4)));
    arena_free(&r.arena);
}

// A line that starts elsewhere, or ends too early, proves nothing. On the portals themselves it may start and end.
Test(witness, starts_in_its_cell_and_gets_there) {
    Rooms r = rooms();
    cr_expect_not(witness_walk(r.graph, 0, 1, vec3(2.5, 1, 1), vec3(3, 1, 1)).proves);
    cr_expect_not(witness_walk(r.graph, 1, 2, vec3(1, 1, 1), vec3(5, 4, 1)).proves);
    cr_expect_not(witness_walk(r.graph, 0, 1, vec3(1, 1, 1), vec3(1.9, 1, 1)).proves);
    cr_expect_not(witness_walk(r.graph, 0, 1, vec3(1, 1, 1), vec3(1, 1, 1)).proves);
    cr_expect(proves(&r, 0, 1, vec3(2, 1, 1), vec3(3, 1, 1)));
    cr_expect(proves(&r, 0, 1, vec3(1, 1, 1), vec3(2, 1, 1)));
    cr_expect(proves(&r, 0, 2, vec3(2, 1.5, 1), vec3(4, 3.5, 1)));
    arena_free(&r.arena);
}

// A cell always sees itself, from any point in it; not from one outside.
Test(witness, a_cell_sees_itself) {
    Rooms r = rooms();
    cr_expect(witness_walk(r.graph, 1, 1, vec3(3, 1, 1), vec3(3.5, 1, 1)).proves);
    cr_expect_not(witness_walk(r.graph, 1, 1, vec3(1, 1, 1), vec3(1.5, 1, 1)).proves);
    arena_free(&r.arena);
}

// Far from the origin and at other scales the same lines prove the same: the margin is the building's share.
Test(witness, is_the_same_anywhere) {
    static const double SHIFTS[] = {0, 1e6};
    for (int k = 0; k < 2; k++) {
        Rooms r = rooms();
        Vec3 shift = vec3(SHIFTS[k], -SHIFTS[k], 0);
        for (int i = 0; i < r.graph->portal_vertex_count; i++)
            r.graph->portal_vertices[i] = vec3_add(r.graph->portal_vertices[i], shift);
        r.graph->box.min = vec3_add(r.graph->box.min, shift);
        r.graph->box.max = vec3_add(r.graph->box.max, shift);
        for (int i = 0; i < r.graph->portal_count; i++)
            r.graph->portals[i].plane.d += vec3_dot(r.graph->portals[i].plane.n, shift);
        for (int i = 0; i < r.graph->face_count; i++)
            r.graph->faces[i].d += vec3_dot(r.graph->faces[i].n, shift);
        cr_expect(proves(&r, 0, 2, vec3_add(shift, vec3(1, 0.1, 1)), vec3_add(shift, vec3(4.5, 4.2, 1))));
        cr_expect(proves(&r, 0, 1, vec3_add(shift, vec3(1, 1.99, 1)), vec3_add(shift, vec3(3, 1.99, 1))));
        cr_expect_not(proves(&r, 0, 1, vec3_add(shift, vec3(1, 2, 1)), vec3_add(shift, vec3(3, 2, 1))));
        arena_free(&r.arena);
    }
}

// In buildings of regions a random line proves exactly the cells that the ray through the walls comes through.
Test(witness, agrees_with_a_ray_through_the_walls) {
    Random random = {7};
    int agreed = 0;
    for (int k = 0; k < 6; k++) {
        Arena arena = {0};
        CellGraph graph;
        VisOptions options = vis_default_options();
        Error error = {""};
        Building *b = fixture_rooms(&arena, &random, 3, 2, 1 + k % 2);
        cr_assert(vis_build_cells(b, &options, &arena, &graph, &error), "%s", error.text);
        for (int i = 0; i < 500; i++) {
            int cell = random_index(&random, graph.cell_count);
            Vec3 from = fixture_point(&graph, &random, cell);
            Trace trace;
            if (!fixture_trace(&graph, cell, from, fixture_direction(&random), NULL, &trace)) continue;
            for (int c = 0; c < graph.cell_count; c++) {
                bool crossed = false;
                for (int t = 0; t < trace.count; t++) crossed = crossed || trace.cells[t] == c;
                bool proven = witness_walk(&graph, cell, c, from, trace.hit).proves;
                cr_expect_eq(proven, crossed, "cell %d from %d", c, cell);
                agreed += proven && c != cell;
            }
        }
        arena_free(&arena);
    }
    cr_expect_gt(agreed, 1000, "only %d lines came anywhere", agreed);
}

// Whatever the finder of sightlines takes for a sightline holds when it is walked, also where it grazes the portal or
// passes close to an edge: lines of all angles down to 1e-8, at all distances from an edge down to 1e-9 m.
Test(witness, holds_what_is_found) {
    Rooms r = rooms();
    Random random = {21};
    Arena arena = {0};
    WayGraph ways;
    ways_build(r.graph, &arena, &ways);
    int found = 0, near = 0, flat = 0;
    for (int k = 0; k < 20000; k++) {
        double sine = pow(10, random_between(&random, -8, 0)),
               inwards = pow(10, random_between(&random, -9, 0));
        double turn = random_between(&random, 0, 6.3);
        Vec3 through = vec3(2, inwards, 1), along = vec3(sine, cos(turn), sin(turn));
        Vec3 from = vec3_sub(through, along), to = vec3_add(through, along);
        Sight sight = {vec3_sub(from, ways.origin), vec3_sub(to, ways.origin)};
        if (!sight_passes(&ways.ways[0], sight, ways.epsilon)) continue;
        cr_expect(proves(&r, 0, 1, from, to), "sine %g, %g m inwards, turned by %g", sine, inwards, turn);
        found++;
        near += inwards < 1e-6;
        flat += sine < 1e-4;
    }
    cr_expect(near > 100 && flat > 1000, "%d, of which %d near and %d flat", found, near, flat);
    arena_free(&arena);
    arena_free(&r.arena);
}
