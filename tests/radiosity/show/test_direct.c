// test_direct.c - light straight from lamps at nodes is exact, whatever stands between.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/show/direct.h"
#include "radiosity/show/final_gather.h"
#include "tests/support/baked_fixture.h"

// Shares of light are sums over edges of lamps cut by edges of faces, each right to 1e-15 or so; faces that reach less than 1e-8 m into
// the way to a lamp may be left out, which hides less than so much of a lamp of a centimetre.
static const double SAME = 2e-6;

// A solution in which nothing was shot: gathered light is light straight from lamps, by exact views of all faces.
static double worst_difference(const Mesh *mesh, const StabForest *forest, const float *doors,
                               RadReport *report) {
    Arena arena = {0};
    RadSolution dark;
    Error error;
    Nodes nodes = nodes_of(mesh, &arena);
    double(*h)[3] = arena_alloc(&arena, (size_t)nodes.count + 1, sizeof *h), worst = 0, mean = 0;
    cr_assert(rad_start(mesh, &arena, &dark, &error), "%s", error.text);
    cr_assert(direct_irradiance(mesh, forest, &nodes, 0, NULL, h, report));
    GatherScene scene = {mesh, forest, doors, &dark, NULL};
    GatherOptions options = gather_default_options();
    options.resolution = 8;
    cr_assert(final_gather(&scene, &options, 0, NULL, &arena, &dark));
    cr_assert_eq(dark.node_count, nodes.count);
    for (int pass = 0; pass < 2; pass++) {
        int off = 0;
        for (int n = 0; n < nodes.count; n++) {
            const Material *m = mesh_material(mesh, mesh->elements[nodes.element[nodes.first[n]]].face);
            double gathered = dark.node[n][1] - (double)m->emission.g,
                   direct = (double)m->reflectance.g * h[n][1];
            if (pass == 0) {
                mean += gathered / nodes.count;
                continue;
            }
            double difference = fabs(gathered - direct) / fmax(gathered, mean);
            worst = fmax(worst, difference);
            off += difference > SAME;
        }
        if (pass == 1) printf("%d nodes, %d differ, %.2g at most\n", nodes.count, off, worst);
    }
    arena_free(&arena);
    return worst;
}

// Proves that shafts and quick tests leave out no face that hides, and no lamp in sight: at every node of rooms with boxes and lamps at
// random, light is as a gather finds it from the view of all faces.
Test(direct, as_gathered_in_rooms) {
    for (uint64_t seed = 1; seed <= 6; seed++) {
        Lit *lit = lit_rooms(seed);
        RadReport report = {0};
        cr_expect_lt(worst_difference(&lit->mesh, &lit->forest, NULL, &report), SAME);
        cr_expect_gt(report.direct_cut, 0);
        lit_free(lit);
    }
}

// The same for a home, with lamps of many faces, furniture and doors that stand as drawn.
Test(direct, as_gathered_in_a_home, .timeout = 120) {
    BakedBuilding *b = baked_building("build/maps/two-rooms.plan", 0.5);
    RadReport report = {0};
    cr_expect_lt(worst_difference(&b->mesh, &b->scene.forest, b->doors, &report), SAME);
    baked_building_free(b);
}
