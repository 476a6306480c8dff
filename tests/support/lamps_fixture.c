// lamps_fixture.c - a plan, written to a file, loaded and baked as `enfilade bake --lamps each` does.
#include "tests/support/lamps_fixture.h"

#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/scene/bake_mesh.h"
#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"
#include "tests/support/support.h"

static const char PLAN[] =
    "plan 1\nmaterial m #A0A0A0\nmaterial glow reflectance 0.3 emission 10\n"
    "material warm reflectance 0.3 emission 20 12 6\nground m height 0\n"
    "storey s floor 0 height 2.5 slab 0.3\n"
    "room first 0,0 4,0 4,3 0,3 floor m ceiling m walls m wall 0.1\n"
    "room second 4.1,0 7.1,0 7.1,3 4.1,3 floor m ceiling m walls m wall 0.1\n"
    "room third 0,5 4,5 4,8 0,8 floor m ceiling m walls m wall 0.1\n"
    "window w 2,-0.05 width 1 height 1 sill 1\n"
    "door d 4.05,1.5 angle 90 width 0.9 height 2 hinge left swing 85 open 0.5 material m\n"
    "inlay glow ceiling 1,1 1.5,1 1.5,1.5 1,1.5\n"
    "inlay glow ceiling 6,1 6.5,1 6.5,1.5 6,1.5\n"
    "model box\n  box -0.1,-0.1,0.8 0.1,0.1,1 warm\nend\nplace box 3,2\n"
    "inlay warm ceiling 1,6 2,6 2,7 1,7\n";

Lamps3 *lamps3_load_plan(const char *plan, bool day) {
    Lamps3 *l = calloc(1, sizeof *l);
    cr_assert(l);
    const char *path = arena_format(&l->arena, "%s/lamps.plan", support_folder(&l->arena));
    FILE *file = fopen(path, "w");
    Error error = {""};
    SceneOptions options = scene_default_options();
    cr_assert(file);
    fputs(plan, file);
    cr_assert_eq(fclose(file), 0);
    options.lamps = SCENE_LAMPS_ALL;
    options.keep = false;
    options.day.day = day;
    cr_assert(scene_load(path, &options, &l->arena, &l->scene, &error), "%s", error.text);
    return l;
}

Lamps3 *lamps3_load(bool day) { return lamps3_load_plan(PLAN, day); }

static void copy(Arena *arena, double (**v)[3], int count) {
    double(*to)[3] = arena_alloc(arena, (size_t)count + 1, sizeof *to);
    memcpy(to, *v, (size_t)count * sizeof *to);
    *v = to;
}

// Shoots and shows all light; its rows stay.
static DirectSources *bake(Lamps3 *l, double residual, int threads, bool follow) {
    Error error = {""};
    BakeOptions a = bake_default_options();
    const StabForest *forest = &l->scene.forest;
    a.day = l->scene.day;
    // Few elements: bakes of a second.
    a.mesh.element = 0.4;
    a.adapt.few = 3000;
    a.rad.residual = residual;
    a.rad.form_factor.resolution = 80;
    a.rad.threads = threads;
    cr_assert(bake_mesh(&a, &l->scene, NULL, NULL, &l->arena, &l->doors, &l->mesh, &error), "%s", error.text);
    rad_fit(&l->mesh, &a.rad);
    cr_assert(rad_start_dark(&l->mesh, &l->arena, &l->solution, &error), "%s", error.text);
    l->rad = a.rad;
    l->day = a.day;
    bool turns = follow && daylight_shines(&a.day);
    if (turns) {
        l->rad.form_factor.sky_parts = true;
        l->rad.sky = sky_looks_new(&l->mesh, forest, l->doors, &l->rad);
    }
    if (daylight_shines(&a.day))
        cr_assert(rad_shine(&l->mesh, forest, l->doors, &l->rad, &a.day, NULL, &l->solution));
    l->rad.rows = shoot_rows_new(&l->mesh, forest, l->doors, &l->rad, &l->day, &l->arena);
    DirectSources *sources = each_lamp_sources(&l->mesh, &l->scene.lamps, threads, &l->arena);
    if (turns) direct_sources_turn(sources, NULL, NULL);
    if (follow) relight_prepare(sources, &l->mesh, &l->arena);
    cr_assert_not(rad_shoot(&l->mesh, forest, l->doors, &l->rad, NULL, &l->solution).stopped);
    cr_assert(direct_show_apart(&l->mesh, forest, l->doors, threads, NULL, &l->arena, &l->solution, sources,
                                NULL, NULL));
    l->joint = l->solution;
    copy(&l->arena, &l->joint.node, l->solution.node_count);
    copy(&l->arena, &l->joint.radiosity, l->solution.element_count);
    return sources;
}

void lamps3_bake(Lamps3 *l, double residual, int threads) {
    DirectSources *sources = bake(l, residual, threads, false);
    EachLamp each = {&l->mesh, &l->scene.lamps, &l->scene.forest, l->doors, &l->rad, sources};
    cr_assert(each_lamp_find(&each, NULL, &l->arena, &l->solution));
    direct_sources_end(sources);
    shoot_rows_end(l->rad.rows);
}

void lamps3_follow(Lamps3 *l, double residual, int threads) {
    DirectSources *sources = bake(l, residual, threads, true);
    l->relight = (Relight){.mesh = &l->mesh,
                           .lamps = &l->scene.lamps,
                           .forest = &l->scene.forest,
                           .door_open = l->doors,
                           .options = &l->rad,
                           .sources = sources,
                           .all = &l->solution,
                           .day = &l->day};
}

void lamps3_free(Lamps3 *l) {
    if (l->relight.sources) {
        relight_end(&l->relight);
        direct_sources_end(l->relight.sources);
        shoot_rows_end(l->rad.rows);
        if (l->rad.sky) sky_looks_end(l->rad.sky);
    }
    arena_free(&l->arena);
    free(l);
}

Mesh lamps3_alone(Lamps3 *l, int lamp) {
    Rgb *lit = ARENA_ARRAY(&l->arena, Rgb, l->scene.lamps.count + 1);
    lit[lamp] = (Rgb){1, 1, 1};
    return lamps_mesh(&l->scene.lamps, &l->mesh, lit, &l->arena);
}

static int smaller_first(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

LightOff lamps3_off(double (*value)[3], double (*truth)[3], const double *weight, int count, double share) {
    Arena scratch = {0};
    double *off = ARENA_ARRAY(&scratch, double, count + 1), light = 0, all = 0, sum = 0;
    int found = 0;
    for (int i = 0; i < count; i++) {
        light += (weight ? weight[i] : 1) * rgb_sum(truth[i]);
        all += weight ? weight[i] : 1;
    }
    for (int i = 0; i < count; i++) {
        if (rgb_sum(value[i]) == 0 && rgb_sum(truth[i]) == 0) continue;
        off[found] =
            fabs(rgb_sum(value[i]) - rgb_sum(truth[i])) / fmax(rgb_sum(truth[i]), share * light / all);
        sum += off[found++];
    }
    qsort(off, (size_t)found, sizeof *off, smaller_first);
    LightOff out = {sum / found, off[(size_t)(0.99 * (found - 1))]};
    arena_free(&scratch);
    return out;
}
