// test_direct.c - light straight from lamps at nodes is exact, whatever stands between.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/show/direct.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/shown.h"
#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

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
    cr_assert(direct_irradiance(mesh, forest, &nodes, NULL, 0, NULL, h, report));
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
static double off_below_ledge(Lit *lit, const Mesh *mesh, const RadSolution *s, Gatherer *gatherer,
                              int face) {
    Random random = {7};
    VertexLight light = reconstruct_light(mesh, s, &lit->arena);
    double off = 0, sum = 0;
    for (int i = 0; i < 2000; i++) {
        double shown[3], h[3];
        Vec3 at = vec3(0, 0.8 + 1.4 * random_unit(&random), 0.7 + 0.5 * random_unit(&random));
        reconstruct_at(mesh, &light, face, at, shown);
        int cell = gather_cell(&lit->graph, at, vec3(1, 0, 0), -1);
        gather(gatherer, &(ViewPoint){at, vec3(1, 0, 0), cell}, h);
        off += fabs(shown[1] - 0.5 * h[1]);
        sum += 0.5 * h[1];
    }
    return off / sum;
}

// A wall with a ledge of 3 cm, lit by a lamp under the ceiling; `off` is the mean error of light on the wall under the ledge as it is
// shown, `at_nodes` if exact light at the nodes of the mesh were shown.
typedef struct Ledge {
    Lit *lit;
    RadSolution solution;
    double off, at_nodes;
} Ledge;

static Ledge show_ledge(void) {
    static const MeshSplits EVEN = {.even = 2};
    Ledge l = {.lit = lit_new()};
    Lit *lit = l.lit;
    RadSolution dark;
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
    mesh.splits = &EVEN;
    lit_finish_with(lit, &mesh);
    lit_shoot(lit, &options, &l.solution);
    cr_assert(rad_start(&lit->mesh, &lit->arena, &dark, &error));
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &dark, NULL};
    GatherOptions gathering = gather_default_options();
    Gatherer *gatherer = gatherer_new(&scene, &gathering, &lit->arena);
    int face = -1;
    for (int f = 0; f < lit->mesh.face_count && face < 0; f++)
        if (lit->mesh.faces[f].plane.n.x > 0.99 && fabs(lit->mesh.faces[f].plane.d) < 1e-9) face = f;
    Nodes nodes = nodes_of(&lit->mesh, &lit->arena);
    RadSolution points = l.solution;
    points.node_count = nodes.count;
    points.node = arena_alloc(&lit->arena, (size_t)nodes.count + 1, sizeof *points.node);
    cr_assert(direct_irradiance(&lit->mesh, &lit->forest, &nodes, NULL, 0, NULL, points.node, NULL));
    for (int n = 0; n < nodes.count; n++)
        for (int c = 0; c < 3; c++) points.node[n][c] *= 0.5;
    l.at_nodes = off_below_ledge(lit, &lit->mesh, &points, gatherer, face);
    cr_assert(direct_show(&lit->mesh, &lit->forest, NULL, 0, NULL, &lit->arena, &l.solution, NULL));
    const Mesh *shown;
    const RadSolution *light;
    cr_assert(shown_light(&lit->mesh, &l.solution, NULL, &lit->arena, &shown, &light, &error), "%s",
              error.text);
    l.off = off_below_ledge(lit, shown, light, gatherer, face);
    gatherer_end(gatherer);
    return l;
}

// Proves that a shadow far narrower than elements is shown as narrow as it is: elements are halved there. The error falls with their
// width, so by one half where the penumbra makes them halve once.
Test(direct, narrow_shadows_do_not_spread) {
    Ledge l = show_ledge();
    printf("off by %.2f %%, with exact light at the nodes of whole elements by %.2f %%\n", 100 * l.off,
           100 * l.at_nodes);
    cr_expect_not_null(l.solution.shown);
    cr_expect_lt(l.off, l.at_nodes / 2);
    lit_free(l.lit);
}

static double power_of(const Mesh *mesh, double (*light)[3]) {
    double sum = 0;
    for (int e = 0; e < mesh->element_count; e++) sum += mesh->elements[e].area * light[e][1];
    return sum;
}

// Elements along objects are cut in squares of other sizes, so that slivers of a millimetre go to other elements.
static const double SLIVERS = 1e-4;

// Proves that the finer mesh has the faces and the power of the mesh that light was found on, that only a part of
// the elements is halved, and that a file brings it back.
Test(direct, finer_elements_keep_the_power) {
    Ledge l = show_ledge();
    const Mesh *mesh = &l.lit->mesh, *shown;
    const RadSolution *light;
    RadSolution back;
    Error error;
    cr_assert(shown_light(mesh, &l.solution, NULL, &l.lit->arena, &shown, &light, &error));
    cr_expect_eq(shown->face_count, mesh->face_count);
    cr_expect_gt(shown->element_count, mesh->element_count);
    cr_expect_leq(shown->element_count, 2 * mesh->element_count);
    double before = power_of(mesh, l.solution.radiosity), after = power_of(shown, light->radiosity);
    cr_expect_float_eq(after / before, 1, SLIVERS);
    before = power_of(mesh, l.solution.direct), after = power_of(shown, light->direct);
    cr_expect_float_eq(after / before, 1, SLIVERS);
    const char *path = arena_format(&l.lit->arena, "%s/x.rad", support_folder(&l.lit->arena));
    cr_assert(rad_save(path, mesh, NULL, &l.solution, &error), "%s", error.text);
    cr_assert(rad_load(path, mesh, NULL, &l.lit->arena, &back, &error), "%s", error.text);
    cr_assert_not_null(back.shown);
    cr_expect_eq(back.shown->bit_count, l.solution.shown->bit_count);
    cr_expect(shown_light(mesh, &back, NULL, &l.lit->arena, &shown, &light, &error), "%s", error.text);
    back.node_count--;
    cr_expect_not(shown_light(mesh, &back, NULL, &l.lit->arena, &shown, &light, &error));
    lit_free(l.lit);
}

// Proves that the finer mesh and its light are the same on one thread and on two.
Test(direct, shown_alike_on_any_number_of_threads) {
    Ledge l = show_ledge();
    RadSolution again = l.solution;
    cr_assert(direct_show(&l.lit->mesh, &l.lit->forest, NULL, 1, NULL, &l.lit->arena, &again, NULL));
    cr_assert_eq(again.node_count, l.solution.node_count);
    cr_expect_eq(memcmp(again.node, l.solution.node, (size_t)again.node_count * sizeof *again.node), 0);
    lit_free(l.lit);
}
