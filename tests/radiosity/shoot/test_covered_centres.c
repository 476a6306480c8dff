// test_covered_centres.c - patches whose middle is covered by a thing: they shoot and look from a free place.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/shoot/adapt.h"
#include "radiosity/show/gather.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/radiosity/show/gather_fixture.h"

// A room in which a lamp of 0.4 m looks up from a box, and a rod without ends stands on the lamp's middle, up to the ceiling. The lamp is
// one patch.
static Lit *room_with_rod(double half) {
    Lit *lit = lit_new();
    Vec3 low = {1.8, 1.3, 1.1}, high = {2.2, 1.7, 1.2};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, low, high, false, LIT_WALL, 1 << 5);
    lit_quad(lit, vec3(low.x, low.y, high.z), vec3(high.x, low.y, high.z), vec3(high.x, high.y, high.z),
             vec3(low.x, high.y, high.z), LIT_LAMP);
    lit_box(lit, vec3(2 - half, 1.5 - half, high.z), vec3(2 + half, 1.5 + half, 2.5), false, LIT_WALL,
            1 << 4 | 1 << 5);
    // For one test it shines.
    lit_quad(lit, vec3(0.1, 0.1, 2.4), vec3(0.1, 0.5, 2.4), vec3(0.5, 0.5, 2.4), vec3(0.5, 0.1, 2.4),
             LIT_RED);
    MeshOptions options = {.element = 0.4, .per_patch = 1, .close = 0.05};
    lit_finish_with(lit, &options);
    return lit;
}

static const Patch *lamp_patch(const Mesh *mesh) {
    const Patch *found = NULL;
    for (int p = 0; p < mesh->patch_count; p++) {
        if (!mesh_emits(mesh, mesh->patches[p].face)) continue;
        cr_assert_null(found, "the lamp is several patches: this proves nothing");
        found = &mesh->patches[p];
    }
    cr_assert_not_null(found);
    return found;
}

// The light that the room reflects to points of the floor, over that of path tracing: how far its mean is off, and the worst of all.
static void reflected_errors(const Lit *lit, double *mean, double *worst) {
    Arena arena = {0};
    RadSolution s;
    Error error = {""};
    RadOptions options = rad_default_options();
    options.residual = 1e-4;
    cr_assert(rad_start(&lit->mesh, &arena, &s, &error), "%s", error.text);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    PathTracer *tracer = path_tracer_new(&lit->mesh, NULL, &arena);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, NULL};
    GatherOptions gathering = gather_default_options();
    double found = 0, right = 0;
    *worst = 0;
    for (int i = 0; i < 6; i++) {
        Vec3 p = {0.6 + 1.4 * (i % 3), 0.7 + 1.6 * (i / 3), 0}, up = {0, 0, 1};
        double h[3];
        PathQuery query = {
            .point = p, .normal = up, .relative_error = 0.003, .most_paths = 1000000, .seed = (uint64_t)i};
        PathResult truth;
        path_tracer_irradiance(tracer, &query, 1, 0, &truth);
        gather_once(&scene, &gathering, p, up, h);
        *worst = fmax(*worst, fabs(h[1] / truth.irradiance[1] - 1));
        found += h[1];
        right += truth.irradiance[1];
    }
    *mean = found / right - 1;
    path_tracer_end(tracer);
    arena_free(&arena);
}

// Proves that all light of a lamp leaves it though a rod of 2 cm stands on its middle: what the room reflects to the floor is that of path
// tracing; from within the rod the floor would have no light at all. Tolerance: 1.5 % in the mean. One place beside the rod sees it to one
// side, so that a point may be 8 % off.
Test(covered_centres, lamp_under_a_rod) {
    Lit *lit = room_with_rod(0.01);
    double mean, worst;
    Vec3 centre = lamp_patch(&lit->mesh)->centre;
    cr_expect_gt(fmax(fabs(centre.x - 2), fabs(centre.y - 1.5)), 0.01, "the lamp looks from within the rod");
    reflected_errors(lit, &mean, &worst);
    printf("mean %.2f %%, worst %.2f %%\n", 100 * mean, 100 * worst);
    cr_expect_lt(fabs(mean), 0.015);
    cr_expect_lt(worst, 0.08);
    lit_free(lit);
}

// Proves that a mesh adapted to light cuts such a lamp in four, which have no rod on their middles, also where the lamp is faint beside
// another one: then, when the other one is off, points are right within 2.5 %.
Test(covered_centres, faint_lamp_is_cut) {
    Lit *lit = room_with_rod(0.01);
    Rgb *bright = &lit->building->materials[LIT_RED].emission;
    *bright = (Rgb){1000, 1000, 1000};
    MeshOptions options = {.element = 0.2, .per_patch = 2, .close = 0.05};
    AdaptOptions adapt = adapt_default_options();
    RadOptions rad = rad_default_options();
    AdaptScene scene = {&lit->graph, &lit->forest, NULL, NULL};
    Error error = {""};
    cr_assert(adapt_mesh(&scene, &options, &adapt, &rad, NULL, &lit->arena, &lit->mesh, &error), "%s",
              error.text);
    *bright = (Rgb){0, 0, 0};
    int lamps = 0;
    for (int p = 0; p < lit->mesh.patch_count; p++) {
        const Patch *patch = &lit->mesh.patches[p];
        if (!mesh_emits(&lit->mesh, patch->face)) continue;
        lamps++;
        cr_expect_not(patch->covered, "a patch of the lamp looks from beside its middle");
    }
    cr_expect_eq(lamps, 4);
    double mean, worst;
    reflected_errors(lit, &mean, &worst);
    printf("mean %.2f %%, worst %.2f %%\n", 100 * mean, 100 * worst);
    cr_expect_lt(worst, 0.025);
    lit_free(lit);
}

// Proves that only covered centres move, and no farther than to the edge of what covers them: the lamp's by a rod of 2 cm, not by one that
// is as broad as the lamp, where no place is free; and those of bare patches are their centroids to the last bit.
Test(covered_centres, only_covered_ones_move) {
    Lit *bare = lit_new(), *rod = room_with_rod(0.01), *all = room_with_rod(0.2 - 1e-7);
    lit_box(bare, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    MeshOptions options = {.element = 0.4, .per_patch = 1};
    lit_finish_with(bare, &options);
    Vec3 moved = lamp_patch(&rod->mesh)->centre, kept = lamp_patch(&all->mesh)->centre;
    cr_expect_lt(fmax(fabs(moved.x - 2), fabs(moved.y - 1.5)), 0.11);
    cr_expect_float_eq(moved.z, 1.2, 1e-12);
    cr_expect(fabs(kept.x - 2) < 1e-6 && fabs(kept.y - 1.5) < 1e-6);
    // The room's own patches are those of the bare room, in front of all others.
    for (int p = 0; p < bare->mesh.patch_count; p++) {
        Vec3 a = bare->mesh.patches[p].centre, b = rod->mesh.patches[p].centre;
        bool ceiling = a.z > 2.4;  // the rod stands there, too
        cr_expect(ceiling || (a.x == b.x && a.y == b.y && a.z == b.z));
    }
    lit_free(bare);
    lit_free(rod);
    lit_free(all);
}
