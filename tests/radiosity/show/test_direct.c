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

// The mean error of shown light on the wall below a ledge, over its mean, against a gather.
static double off_below_ledge(Lit *lit, const RadSolution *s, Gatherer *gatherer, int face) {
    Random random = {7};
    VertexLight light = reconstruct_light(&lit->mesh, s, &lit->arena);
    double off = 0, sum = 0;
    for (int i = 0; i < 2000; i++) {
        double shown[3], h[3];
        Vec3 at = vec3(0, 0.8 + 1.4 * random_unit(&random), 0.7 + 0.5 * random_unit(&random));
        reconstruct_at(&lit->mesh, &light, face, at, shown);
        int cell = gather_cell(&lit->graph, at, vec3(1, 0, 0), -1);
        gather(gatherer, &(ViewPoint){at, vec3(1, 0, 0), cell}, h);
        off += fabs(shown[1] - 0.5 * h[1]);
        sum += 0.5 * h[1];
    }
    return off / sum;
}

// Proves that a shadow far narrower than elements is shown as they tell it: below a ledge of 3 cm on a wall, which shades some
// centimetres, nodes at the ledge are dark and would darken whole elements. By a fifth at least nearer to a gather of the light of lamps.
Test(direct, narrow_shadows_do_not_spread) {
    Lit *lit = lit_new();
    RadSolution s, dark;
    Error error;
    RadOptions options = rad_default_options();
    options.lamps_only = true;
    options.residual = 0;
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(0, 0.8, 1.2), vec3(0.03, 2.2, 1.24), false, LIT_WALL, 1);
    lit_quad(lit, vec3(1.9, 1.4, 2.4), vec3(1.9, 1.6, 2.4), vec3(2.1, 1.6, 2.4), vec3(2.1, 1.4, 2.4),
             LIT_LAMP);
    MeshOptions mesh = mesh_default_options();
    mesh.element = 0.3;
    lit_finish_with(lit, &mesh);
    lit_shoot(lit, &options, &s);
    cr_assert(rad_start(&lit->mesh, &lit->arena, &dark, &error));
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &dark, NULL};
    GatherOptions gathering = gather_default_options();
    Gatherer *gatherer = gatherer_new(&scene, &gathering, &lit->arena);
    int face = -1;
    for (int f = 0; f < lit->mesh.face_count && face < 0; f++)
        if (lit->mesh.faces[f].plane.n.x > 0.99 && fabs(lit->mesh.faces[f].plane.d) < 1e-9) face = f;
    Nodes nodes = nodes_of(&lit->mesh, &lit->arena);
    RadSolution points = s;
    points.node_count = nodes.count;
    points.node = arena_alloc(&lit->arena, (size_t)nodes.count + 1, sizeof *points.node);
    cr_assert(direct_irradiance(&lit->mesh, &lit->forest, &nodes, 0, NULL, points.node, NULL));
    for (int n = 0; n < nodes.count; n++)
        for (int c = 0; c < 3; c++) points.node[n][c] *= 0.5;
    cr_assert(direct_show(&lit->mesh, &lit->forest, 0, NULL, &lit->arena, &s, NULL));
    double off = off_below_ledge(lit, &s, gatherer, face),
           at_points = off_below_ledge(lit, &points, gatherer, face);
    printf("off by %.2f %%, with exact light at all nodes by %.2f %%\n", 100 * off, 100 * at_points);
    cr_expect_lt(off, 0.8 * at_points);
    gatherer_end(gatherer);
    lit_free(lit);
}
