// test_sky_rows.c - the sky as rows of form factors see it, and the light that patches gather from it along their rows.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "radiosity/show/gather.h"
#include "tests/radiosity/shoot/sky_fixture.h"

// Noon at the equinox at 50 degrees north: the sun stands 40 degrees high.
static Daylight clear_noon(void) {
    SunPosition sun = sun_position(2026, 3, 21, 12, 50 * M_PI / 180, 0);
    return daylight_of(&sun, 0, DAYLIGHT_CLEAR);
}

// Proves that a row's share of the sky times its radiance is, of a square that lies under a clear sky, the mean radiance that daylight.h
// has by a sum over other directions; of one that looks down, nothing. By each method that has samples. Tolerance: the largest of samples
// that are a hundredth of the disc apart, about the sun's place, where the sky is brightest.
Test(sky, rows_tell_the_radiance_of_the_sky) {
    Lit *lit = lit_new();
    lit_quad(lit, vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0), LIT_WALL);
    lit_finish(lit, 0.5, 2);
    Daylight day = clear_noon();
    FormFactorOptions options = form_factor_default_options();
    Viewer *viewer = viewer_new(&lit->mesh, &lit->forest, NULL, &lit->arena);
    options.day = &day;
    for (int i = 0; FORM_FACTOR_METHODS[i]; i++) {
        if (!FORM_FACTOR_METHODS[i]->projective) continue;
        FormFactor *rows = form_factor_new(FORM_FACTOR_METHODS[i], &lit->mesh, &options, &lit->arena);
        for (int up = -1; up <= 1; up += 2) {
            ViewPoint from = {vec3(0.5, 0.5, 1), vec3(0, 0, up), -1};
            const Row *row = form_factor_row(rows, viewer_look(viewer, &from, CULL_NONE));
            cr_expect_float_eq(row->sky_light, up > 0 ? day.mean : 0, 0.005 * day.mean, "%s: %g, not %g",
                               FORM_FACTOR_METHODS[i]->name, row->sky_light, day.mean);
        }
        form_factor_end(rows);
    }
    lit_free(lit);
}

static int by_size(const void *a, const void *b) {
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

// How far the gathered light of patches indoors in some range of sizes, of surfaces or of things, is off a gather at their
// middles that asks for four times as many directions each way, relative, in order. Looks at one patch of each `stride`.
// Returns their number.
static int errors_of_patches(Lit *lit, bool things, double least, double most, int stride, double **out) {
    Daylight day = clear_noon();
    RadOptions options = sky_options_of(CULL_STAB, 0);
    RadSolution s = sky_day_shone(lit, &day, &options);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    cr_assert(s.gathered);
    VertexLight light = reconstruct_light(&lit->mesh, &s, &lit->arena);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, &light};
    GatherOptions gather_options = gather_default_options();
    gather_options.reflected = true;
    gather_options.resolution = 4 * options.form_factor.resolution;
    Gatherer *gatherer = gatherer_new(&scene, &gather_options, &lit->arena);
    double *off = *out = ARENA_ARRAY(&lit->arena, double, s.patch_count);
    int count = 0;
    for (int p = 0; p < s.patch_count; p += stride) {
        const Patch *patch = &lit->mesh.patches[p];
        double right[3];
        if (patch->cell < 0 || vis_region(&lit->graph, patch->cell)->kind != REGION_ROOM) continue;
        ObjectKind kind = lit->graph.objects[lit->mesh.faces[patch->face].object].kind;
        if (patch->area < least || patch->area >= most || (kind == OBJECT_SURFACE) == things) continue;
        gather(gatherer, &(ViewPoint){patch->centre, lit->mesh.faces[patch->face].plane.n, patch->cell},
               right);
        if (rgb_sum(right) > 0) off[count++] = fabs(rgb_sum(s.reflected[p]) / rgb_sum(right) - 1);
    }
    gatherer_end(gatherer);
    qsort(off, (size_t)count, sizeof *off, by_size);
    return count;
}

// Proves that patches gather the light of sky and ground along their rows: in a room with a window under a clear sky their light is that
// of a gather at their middles, which asks the sky for each of four times as many directions each way. Patches are small, so that their
// middles stand for them. Tolerance: 1 % in the median: of the hundred samples that see a window one in a hundred errs at its border.
Test(sky, patches_gather_the_sky_along_their_rows, .timeout = 120) {
    Lit *lit = sky_room_with_window(1.2, 1.3, 0.25);
    double *off;
    int count = errors_of_patches(lit, false, 0.01, INFINITY, 3, &off);
    cr_assert_gt(count, 50);
    printf("light of %d patches is off by %.2f %% in the median\n", count, 100 * off[count / 2]);
    cr_expect_lt(off[count / 2], 0.01);
    lit_free(lit);
}

// The light of patches from `least` to a square decimetre, more than `many`, is within 4 % of what a gather finds, in the median.
static void expect_right(Lit *lit, bool things, double least, int many) {
    double *off;
    int count = errors_of_patches(lit, things, least, 0.01, 1, &off);
    cr_assert_gt(count, many, "%d patches", count);
    printf("light of %d small patches is off by %.2f %% in the median, %.2f %% at most\n", count,
           100 * off[count / 2], 100 * off[count - 1]);
    cr_expect_lt(off[count / 2], 0.04);
    lit_free(lit);
}

// Proves that slivers of walls and ceilings gather, too: those of a room one of whose walls has grooves, 4 mm deep, are as right as other
// patches. What is shot to a sliver are a few samples, 16 % off in the median. Tolerance: of 100 samples that see the window some 20 lie at
// its border, of which four or five err together; twice that, since grooves hide the window in part.
Test(sky, slivers_of_surfaces_gather, .timeout = 120) {
    Arena arena = {0};
    const char *grooves = "";
    for (int i = 0; i < 20; i++)
        grooves = arena_format(&arena, "%s %.3f,3 %.3f,3 %.3f,3.004 %.3f,3.004", grooves, 3.8 - 0.15 * i,
                               3.75 - 0.15 * i, 3.75 - 0.15 * i, 3.7 - 0.15 * i);
    Lit *lit = sky_read_plan_with(
        arena_format(&arena,
                     "room a 0,3 0,0 4,0 4,3%s floor oak ceiling white walls white wall 0.2\n"
                     "window w 4.1,1.5 angle 90 width 1.2 sill 0.9 height 1.3\n",
                     grooves),
        0.25, 2);
    expect_right(lit, false, 1e-5, 20);
    arena_free(&arena);
}

// Proves that small patches gather where they are parts of a larger face: those of rods, 1.8 cm wide, are as right as those of walls. The
// light that is shot to them is 5 % off in the median, and was seen as smears on leaves of doors and frames of windows. Tolerance: that of
// slivers above.
Test(sky, small_patches_of_large_things_gather, .timeout = 120) {
    Arena arena = {0};
    const char *rods = "";
    for (int i = 0; i < 10; i++) rods = arena_format(&arena, "%splace rod %.2f,2.2\n", rods, 0.4 + 0.2 * i);
    Lit *lit = sky_read_plan_with(
        arena_format(&arena,
                     "room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                     "window w 4.1,1.5 angle 90 width 1.2 sill 0.9 height 1.3\n"
                     "model rod\nbox 0,0,0 0.018,0.018,2 white\nend\n%s",
                     rods),
        0.25, 2);
    expect_right(lit, true, 1e-3, 100);
    arena_free(&arena);
}
