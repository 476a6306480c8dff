// sky_fixture.c - see the header.
#include "tests/radiosity/shoot/sky_fixture.h"

#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/bake_probes.h"
#include "engine/core/file.h"
#include "maps/maps.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

RadOptions sky_options_of(Culling culling, int threads) {
    RadOptions options = rad_default_options();
    options.culling = culling;
    options.threads = threads;
    return options;
}

RadSolution sky_day_shone(Lit *lit, const Daylight *day, const RadOptions *options) {
    RadSolution s;
    Error error = {""};
    cr_assert(rad_start_dark(&lit->mesh, &lit->arena, &s, &error), "%s", error.text);
    cr_assert(rad_shine(&lit->mesh, &lit->forest, NULL, options, day, NULL, &s));
    return s;
}

RadSolution sky_shone(Lit *lit, const RadOptions *options) {
    Daylight day = daylight_uniform(SKY);
    return sky_day_shone(lit, &day, options);
}

static void check_kept(const RadSolution *s) {
    for (int c = 0; c < 3; c++) {
        double gone = s->absorbed[c] + s->escaped[c];
        cr_assert_leq(gone, s->emitted[c] * (1 + 1e-9));
    }
}

void sky_check_conserved(const Lit *lit, const RadSolution *s) {
    for (int c = 0; c < 3; c++) {
        double left = 0;
        for (int p = 0; p < s->patch_count; p++) left += s->unshot[p][c] * lit->mesh.patches[p].area;
        double sum = s->absorbed[c] + s->escaped[c] + left;
        cr_assert_float_eq(sum, s->emitted[c], 1e-9 * s->emitted[c], "%.12g, not %.12g", sum, s->emitted[c]);
    }
    check_kept(s);
}

Lit *sky_read_plan_with(const char *rest, double element, int per_patch) {
    Lit *lit = lit_new();
    Error error = {""};
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/room.plan", support_folder(&arena));
    const char *text = arena_format(&arena,
                                    "plan 1\nmaterial white #E8E8E8\nmaterial oak #B08A5B\nmaterial grass "
                                    "#6F8F4E\nground grass height -0.2\nfacade white\n"
                                    "storey ground floor 0 height 2.5 slab 0.3\n%s",
                                    rest);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    *lit->building = (Building){0};
    path = arena_string(&lit->arena, path);
    cr_assert(maps_read(path, &lit->arena, lit->building, &error), "%s", error.text);
    arena_free(&arena);
    lit_finish(lit, element, per_patch);
    return lit;
}

// A room with one window of this size, a table before it, a garden and a wall out there.
Lit *sky_room_with_window(double width, double height, double element) {
    Arena arena = {0};
    const char *text =
        arena_format(&arena,
                     "room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                     "window w 4.1,1.5 angle 90 width %g sill 0.9 height %g\n"
                     "model table\n  box -0.4,-0.6,0 0.4,0.6,0.7 oak\nend\nplace table 2.6,1.4\n"
                     "model wall\n  box -0.1,-2,0 0.1,2,2 white\nend\nplace wall 8,2\n",
                     width, height);
    Lit *lit = sky_read_plan_with(text, element, 2);
    arena_free(&arena);
    return lit;
}

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

// `make soak` looks at all points, `make test` at a third of them.
int sky_point_count(void) { return support_count(8, SKY_POINTS); }

// Relative errors of what points indoors gather, in order; points nearly in the dark aside.
int sky_errors_of(Lit *lit, const RadSolution *s, double errors[SKY_POINTS]) {
    Arena arena = {0};
    PathTracer *tracer = path_tracer_new(&lit->mesh, &s->day, &arena);
    PathQuery queries[SKY_POINTS];
    PathResult truth[SKY_POINTS];
    Probes probes = {ARENA_ARRAY(&arena, Probe, SKY_POINTS), 0, SKY_POINTS};
    for (int i = 0; probes.count < sky_point_count() && i < lit->mesh.patch_count; i++) {
        // Anywhere, by a stride that has no factor in common with most counts.
        const Patch *patch = &lit->mesh.patches[(long long)i * 7919 % lit->mesh.patch_count];
        if (patch->cell < 0 || vis_region(&lit->graph, patch->cell)->kind != REGION_ROOM) continue;
        Vec3 n = lit->mesh.faces[patch->face].plane.n;
        queries[probes.count] = (PathQuery){patch->centre, n, 0.003, 0, 1500000, (uint64_t)i};
        probes.probes[probes.count++] = (Probe){.place = patch->centre, .normal = n};
    }
    path_tracer_irradiance(tracer, queries, probes.count, 0, truth);
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, s, NULL}, 1, &probes);
    int count = 0;
    for (int i = 0; i < probes.count; i++) {
        double h = truth[i].irradiance[1], e = probes.probes[i].irradiance[1] / h - 1;
        if (!(h > 0.01)) continue;
        printf("%6.3f %6.3f %6.3f: %9.5f +- %.5f, gathered %+.2f %%\n", queries[i].point.x,
               queries[i].point.y, queries[i].point.z, h, truth[i].standard_error[1], 100 * e);
        errors[count++] = fabs(e);
    }
    qsort(errors, (size_t)count, sizeof *errors, by_size);
    path_tracer_end(tracer);
    arena_free(&arena);
    return count;
}
