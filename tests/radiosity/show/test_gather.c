// test_gather.c - light gathered at points: lamps as closed forms say whatever samples see, slopes in elements as finer
// elements have them, and what is culled is not missed.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/parallel.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/radiosity/show/gather_fixture.h"
#include "tests/support/lit_fixture.h"

// Proves that with exact lamps a few hundred samples give direct light to rounding: a unit square 1 m above a point, in
// closed form; and that half of it hidden by an edge is half of it.
Test(gather, lamps_are_exact) {
    for (int hidden = 0; hidden < 2; hidden++) {
        Lit *lit = lit_new();
        RadSolution s;
        lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
        lit_lamp(lit, vec3(2, 1.5, 2));
        if (hidden)
            lit_quad(lit, vec3(2, 0.5, 1.5), vec3(4, 0.5, 1.5), vec3(4, 2.5, 1.5), vec3(2, 2.5, 1.5),
                     LIT_WALL);
        lit_finish(lit, 0.5, 2);
        RadOptions nothing = rad_default_options();
        nothing.residual = 1;
        lit_shoot(lit, &nothing, &s);
        GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, NULL};
        GatherOptions options = gather_default_options();
        options.resolution = 16;
        double h[3], expected = .23945647046 / (hidden ? 2 : 1);
        gather_once(&scene, &options, vec3(2, 1.5, 1), vec3(0, 0, 1), h);
        cr_assert_float_eq(h[0], 12 * expected, 1e-6);
        cr_assert_float_eq(h[2], 6 * expected, 1e-6);
        gather_once(&scene, &options, vec3(2, 1.5, 2), vec3(0, 0, -1), h);
        cr_assert_eq(h[0], 0);
        lit_free(lit);
    }
}

// Light that grows along a room's floor and walls, as elements of a side hold it.
static double in_sloped_room(double side, bool slopes, const GatherOptions *options, Vec3 p, Vec3 n) {
    Lit *lit = lit_new();
    double h[3];
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_finish(lit, side, 2);
    RadSolution s = {.element_count = lit->mesh.element_count};
    s.radiosity = arena_alloc(&lit->arena, (size_t)s.element_count, sizeof *s.radiosity);
    for (int e = 0; e < s.element_count; e++) {
        Vec3 c = element_centroid(&lit->mesh, e);
        s.radiosity[e][0] = s.radiosity[e][1] = s.radiosity[e][2] = 0.2 + 3 * c.z + c.x * 0.5;
    }
    VertexLight light = reconstruct_light(&lit->mesh, &s, &lit->arena);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, slopes ? &light : NULL};
    gather_once(&scene, options, p, n, h);
    lit_free(lit);
    return h[1];
}

// Proves that elements of half a metre with slopes give what elements of 4 cm give, at a point of the floor 2 cm from a wall,
// which sees the foot of the wall alone on that side: within 0.3 % where constant elements are 5 % off. By both methods.
Test(gather, slopes_are_seen) {
    Vec3 p = {2, 0.02, 0}, n = {0, 0, 1};
    GatherOptions fast = gather_default_options(), exact = gather_exact_options();
    // Light that is looked up is tried here; light that no lamp gave cannot be walked to.
    exact.near.reach = 0;
    double truth = in_sloped_room(0.04, false, &exact, p, n);
    double constant = in_sloped_room(0.5, false, &exact, p, n) / truth - 1;
    double off = in_sloped_room(0.5, true, &exact, p, n) / truth - 1;
    double off_fast = in_sloped_room(0.5, true, &fast, p, n) / truth - 1;
    printf("constant %.2f %%, with slopes %.3f %%, by samples %.3f %%\n", 100 * constant, 100 * off,
           100 * off_fast);
    cr_assert(fabs(constant) > 0.03);
    cr_assert(fabs(off) < 0.003);
    cr_assert(fabs(off_fast) < 0.003);
}

// Proves that stab trees leave out nothing that gives light: exact rows, culled by the cell found for the point and not, at every
// 7th element of rooms with furniture. 1e-9: rows are normed by their sums, which pieces in other order round otherwise.
Test(gather, culling_misses_nothing) {
    for (unsigned seed = 1; seed <= 3; seed++) {
        Lit *lit = lit_rooms(seed);
        const Mesh *mesh = &lit->mesh;
        RadOptions some = rad_default_options();
        some.residual = 0.05;
        RadSolution s;
        lit_shoot(lit, &some, &s);
        GatherScene scene = {mesh, &lit->forest, NULL, &s, NULL};
        GatherOptions culled = gather_exact_options(), all = culled;
        all.culling = CULL_NONE;
        Gatherer *a = gatherer_new(&scene, &culled, &lit->arena),
                 *b = gatherer_new(&scene, &all, &lit->arena);
        int lit_points = 0;
        for (int e = 0; e < mesh->element_count; e += 29) {
            Vec3 p = element_centroid(mesh, e), n = mesh->faces[mesh->elements[e].face].plane.n;
            double h[3], expected[3];
            ViewPoint from = {p, n, gather_cell(mesh->graph, p, n, -1)};
            gather(a, &from, h);
            gather(b, &from, expected);
            cr_assert_float_eq(h[1], expected[1], 1e-9 * expected[1] + 1e-12, "seed %u, element %d", seed, e);
            lit_points += expected[1] > 0;
        }
        cr_assert_gt(lit_points, 30);
        gatherer_end(a);
        gatherer_end(b);
        lit_free(lit);
    }
}

static void trace_all(const Mesh *mesh, PathResult *out) {
    Arena arena = {0};
    PathTracer *tracer = path_tracer_new(mesh, NULL, &arena);
    PathQuery queries[CLOSE_POINTS];
    for (int i = 0; i < CLOSE_POINTS; i++)
        queries[i] = (PathQuery){.point = CLOSE[i].eye,
                                 .normal = CLOSE[i].normal,
                                 .relative_error = 0.005,
                                 .most_paths = 500000,
                                 .seed = (uint64_t)i};
    path_tracer_irradiance(tracer, queries, CLOSE_POINTS, 0, out);
    path_tracer_end(tracer);
    arena_free(&arena);
}

// Proves that light in a slit, at its mouth and in a corner is what paths find, of elements half a metre long, where looking it up
// is off by a factor of 40 and more. Tolerance: 5 %, and a five-thousandth of what the room has; deep inside is less than a
// thousandth, of which neither has seen much.
Test(gather, slit) {
    RadSolution s;
    Lit *lit = gather_room_with_slit(&s);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, NULL};
    GatherOptions near = gather_exact_options(), even = near, fast = gather_default_options();
    even.near.reach = 0;
    fast.near = near.near;
    double h[CLOSE_POINTS][3], looked_up[CLOSE_POINTS][3], sampled[CLOSE_POINTS][3], worst = 0;
    PathResult truth[CLOSE_POINTS];
    gather_all(&scene, &near, h);
    gather_all(&scene, &even, looked_up);
    gather_all(&scene, &fast, sampled);
    trace_all(&lit->mesh, truth);
    for (int i = 0; i < CLOSE_POINTS; i++) {
        double t = truth[i].irradiance[1], may = 0.05 * t + 1e-4;
        printf("point %d: %.4g +- %.2g W/m^2, gathered %.4g, by samples %.4g, looked up %.4g\n", i, t,
               truth[i].standard_error[1], h[i][1], sampled[i][1], looked_up[i][1]);
        cr_expect_float_eq(h[i][1], t, may, "point %d", i);
        cr_expect_float_eq(sampled[i][1], t, may, "point %d by samples", i);
        worst = fmax(worst, looked_up[i][1] / t);
    }
    cr_expect_gt(worst, 40);
    lit_free(lit);
}
