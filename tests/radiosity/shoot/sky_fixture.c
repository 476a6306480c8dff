// sky_fixture.c - see the header.
#include "tests/radiosity/shoot/sky_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/file.h"
#include "maps/maps.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

RadOptions sky_options_of(Culling culling, int threads) {
    RadOptions options = rad_default_options();
    options.culling = culling;
    options.threads = threads;
    return options;
}

RadSolution sky_shone(Lit *lit, const RadOptions *options) {
    RadSolution s;
    Error error = {""};
    cr_assert(rad_start_dark(&lit->mesh, &lit->arena, &s, &error), "%s", error.text);
    Daylight day = daylight_uniform(SKY);
    cr_assert(rad_shine(&lit->mesh, &lit->forest, NULL, options, &day, NULL, &s));
    return s;
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
