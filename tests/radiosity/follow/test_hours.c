// test_hours.c - light that follows the hour: looks at the sky and rows that are kept, and all light along them, against light from
// nothing at that hour.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/shown.h"
#include "tests/support/lamps_fixture.h"

static Daylight day_at(double hour) {
    SunPosition sun = sun_position(2026, 6, 21, hour, 50 * M_PI / 180, 0);
    return daylight_of(&sun, 0, DAYLIGHT_CLEAR);
}

static double *areas_of(const Mesh *mesh, Arena *arena) {
    double *out = ARENA_ARRAY(arena, double, mesh->element_count + 1);
    for (int e = 0; e < mesh->element_count; e++) out[e] = mesh->elements[e].area;
    return out;
}

// ---- looks at the sky

static RadSolution shone(Lamps3 *l, SkyLooks *looks, const float *doors, const Daylight *day, Arena *arena) {
    RadSolution out;
    Error error = {""};
    RadOptions options = l->rad;
    options.sky = looks;
    options.rows = NULL;
    cr_assert(rad_start_dark(&l->mesh, arena, &out, &error), "%s", error.text);
    cr_assert(rad_shine(&l->mesh, &l->scene.forest, doors, &options, day, NULL, &out));
    double gone = rgb_sum(out.emitted) - rgb_sum(out.absorbed), left = 0;
    for (int p = 0; p < out.patch_count; p++) left += rgb_sum(out.unshot[p]) * l->mesh.patches[p].area;
    cr_expect_float_eq(gone, left, 1e-9 * rgb_sum(out.emitted), "nothing is lost");
    return out;
}

static int door_of(const Lamps3 *l) {
    int door = 0;
    while (l->scene.building.openings[door].kind != OPENING_DOOR) door++;
    return door;
}

// Proves that kept looks tell the light of the day under which they were made as looks that are not kept do, to the rounding of floats,
// and that of other hours within what parts of the sky may be off, half a hundredth in the mean and a hundredth at the worst
// (test_sky_parts.c); and that looks past a door that moved are made anew.
Test(hours, looks_turn, .timeout = 240) {
    Lamps3 *l = lamps3_load(true);
    lamps3_follow(l, 1e-2, 2);
    Arena scratch = {0};
    static const double HOURS[] = {10, 12.5, 17, 5};
    double *area = areas_of(&l->mesh, &scratch);
    int openings = l->scene.building.opening_count, elements = l->mesh.element_count;
    float *doors = ARENA_ARRAY(&scratch, float, openings), *to = ARENA_ARRAY(&scratch, float, openings);
    memcpy(doors, l->doors, (size_t)openings * sizeof *doors);
    SkyLooks *looks = sky_looks_new(&l->mesh, &l->scene.forest, doors, &l->rad);
    for (int i = 0; i < 4; i++) {
        Daylight day = day_at(HOURS[i]);
        LightOff off = lamps3_off(shone(l, looks, doors, &day, &scratch).radiosity,
                                  shone(l, NULL, doors, &day, &scratch).radiosity, area, elements, 0.01);
        printf("%g:00: light of kept looks is %.4f %% off in the mean, %.3f %% at p99\n", HOURS[i],
               100 * off.mean, 100 * off.p99);
        cr_expect(off.mean < (i ? 5e-3 : 1e-6) && off.p99 < (i ? 1e-2 : 1e-5));
    }
    memcpy(to, doors, (size_t)openings * sizeof *to);
    to[door_of(l)] = 1;
    MovedDoors moved = mesh_move(&l->mesh, doors, to, &scratch);
    memcpy(doors, to, (size_t)openings * sizeof *to);
    sky_looks_move(looks, &moved);
    Daylight day = day_at(HOURS[3]);
    LightOff off = lamps3_off(shone(l, looks, doors, &day, &scratch).radiosity,
                              shone(l, NULL, doors, &day, &scratch).radiosity, area, elements, 0.01);
    printf("door moved: %.4f %% off in the mean, %.3f %% at p99\n", 100 * off.mean, 100 * off.p99);
    cr_expect(off.mean < 5e-3 && off.p99 < 1e-2);
    sky_looks_end(looks);
    mesh_pose(&l->mesh, l->doors);
    arena_free(&scratch);
    lamps3_free(l);
}

// Proves that looks from outdoors past a door that moved are made anew: under the day of the looks kept ones are then those from nothing,
// to the rounding of floats.
Test(hours, looks_past_an_outer_door, .timeout = 240) {
    Lamps3 *l = lamps3_load_plan(
        "plan 1\nmaterial m #A0A0A0\nmaterial glow reflectance 0.3 emission 10\nground m height 0\n"
        "storey s floor 0 height 2.5 slab 0.3\nroom first 0,0 4,0 4,3 0,3 floor m ceiling m walls m wall "
        "0.1\n"
        "door out 2,-0.05 width 0.8 height 2 hinge left swing -85 material m\n"
        "inlay glow ceiling 1,1 1.5,1 1.5,1.5 1,1.5\n",
        true);
    lamps3_follow(l, 1e-2, 2);
    Arena scratch = {0};
    Daylight day = day_at(10);
    int openings = l->scene.building.opening_count;
    float *doors = ARENA_ARRAY(&scratch, float, openings), *to = ARENA_ARRAY(&scratch, float, openings);
    memcpy(doors, l->doors, (size_t)openings * sizeof *doors);
    memcpy(to, l->doors, (size_t)openings * sizeof *to);
    SkyLooks *looks = sky_looks_new(&l->mesh, &l->scene.forest, doors, &l->rad);
    shone(l, looks, doors, &day, &scratch);
    to[door_of(l)] = 1;
    MovedDoors moved = mesh_move(&l->mesh, doors, to, &scratch);
    memcpy(doors, to, (size_t)openings * sizeof *to);
    sky_looks_move(looks, &moved);
    LightOff off = lamps3_off(shone(l, looks, doors, &day, &scratch).radiosity,
                              shone(l, NULL, doors, &day, &scratch).radiosity, areas_of(&l->mesh, &scratch),
                              l->mesh.element_count, 0.01);
    cr_expect(off.mean < 1e-6 && off.p99 < 1e-5, "%g, %g", off.mean, off.p99);
    sky_looks_end(looks);
    mesh_pose(&l->mesh, l->doors);
    arena_free(&scratch);
    lamps3_free(l);
}

// ---- all light

static double (*turned_to(Lamps3 *l, double hour, const float *doors, Arena *arena))[3] {
    RadSolution *out = ARENA_ARRAY(arena, RadSolution, 1);
    Daylight day = day_at(hour);
    cr_assert(relight_turn(&l->relight, &day, doors, NULL, arena, out));
    double power[2] = {rgb_sum(out->emitted), rgb_sum(out->absorbed) + rgb_sum(out->escaped)};
    for (int p = 0; p < out->patch_count; p++) power[1] += rgb_sum(out->unshot[p]) * l->mesh.patches[p].area;
    cr_expect_float_eq(power[0], power[1], 1e-9 * power[0], "%g W of %g", power[1], power[0]);
    return shown_means(&l->mesh, direct_sources_shown(l->relight.sources), out, arena);
}

// On the same elements, from nothing.
static double (*from_nothing(Lamps3 *l, double hour, const float *doors, Arena *arena))[3] {
    RadSolution s;
    Error error = {""};
    RadOptions options = l->rad;
    Daylight day = day_at(hour);
    Mesh finer;
    options.rows = NULL;
    options.sky = NULL;
    cr_assert(rad_start_dark(&l->mesh, arena, &s, &error));
    cr_assert(rad_shine(&l->mesh, &l->scene.forest, doors, &options, &day, NULL, &s));
    cr_assert_not(rad_shoot(&l->mesh, &l->scene.forest, doors, &options, NULL, &s).stopped);
    cr_assert(direct_show(&l->mesh, &l->scene.forest, doors, 2, NULL, arena, &s, NULL));
    cr_assert(shown_build(&l->mesh, s.shown, doors, arena, &finer, &error), "%s", error.text);
    return shown_means(&l->mesh, &finer, &s, arena);
}

static void expect_near(const char *what, Lamps3 *l, double (*a)[3], double (*b)[3], double mean, double p99,
                        Arena *arena) {
    LightOff off = lamps3_off(a, b, areas_of(&l->mesh, arena), l->mesh.element_count, 0.01);
    printf("%s: %.3f %% off in the mean, %.2f %% at p99\n", what, 100 * off.mean, 100 * off.p99);
    cr_expect(off.mean < mean && off.p99 < p99, "%s", what);
}

// Proves that light that turns to another hour is that of the hour from nothing on the same elements; that it is the same whatever hour
// came before, doors opened in between included; and that doors and lamps go on from it. The bounds are those that states of doors and
// lamps are promised to have: a thousandth in the mean, a hundredth in 99 of 100 elements.
Test(hours, light_turns, .timeout = 300) {
    Lamps3 *l = lamps3_load(true), *other = lamps3_load(true);
    lamps3_follow(l, 1e-4, 2);
    lamps3_follow(other, 1e-4, 2);
    Arena scratch = {0};
    Rgb full[4] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, off[4] = {{0}};
    int openings = l->scene.building.opening_count;
    float *doors = ARENA_ARRAY(&scratch, float, openings), *open = ARENA_ARRAY(&scratch, float, openings);
    memcpy(doors, l->doors, (size_t)openings * sizeof *doors);
    memcpy(open, l->doors, (size_t)openings * sizeof *open);
    open[door_of(l)] = 1;
    double(*noon)[3] = turned_to(l, 12.5, doors, &scratch);
    expect_near("turned to noon", l, noon, from_nothing(l, 12.5, doors, &scratch), 1e-3, 1e-2, &scratch);
    double(*evening)[3] = turned_to(l, 18, doors, &scratch);
    expect_near("turned to the evening", l, evening, from_nothing(l, 18, doors, &scratch), 1e-3, 1e-2,
                &scratch);
    // Lamps count most at dusk. The sun stands at the horizon, where parts of the sky may be off by half a hundredth in the mean.
    double(*dusk)[3] = turned_to(l, 20, doors, &scratch);
    expect_near("turned to dusk", l, dusk, from_nothing(l, 20, doors, &scratch), 5e-3, 1e-2, &scratch);
    expect_near("at once", l, turned_to(other, 18, doors, &scratch), evening, 1e-3, 1e-2, &scratch);
    // A door opens at noon.
    RadSolution state[2];
    turned_to(l, 12.5, doors, &scratch);
    cr_assert(relight_state(&l->relight, doors, full, NULL, &scratch, &state[0], NULL));
    cr_assert(relight_state(&l->relight, open, full, NULL, &scratch, &state[0], NULL));
    expect_near("a door opened at noon", l,
                shown_means(&l->mesh, direct_sources_shown(l->relight.sources), &state[0], &scratch),
                turned_to(other, 12.5, open, &scratch), 1e-3, 1e-2, &scratch);
    // The sun and the sky alone.
    cr_assert(relight_state(&l->relight, open, off, NULL, &scratch, &state[0], NULL));
    cr_assert(relight_state(&other->relight, open, off, NULL, &scratch, &state[1], NULL));
    expect_near("without lamps", l,
                shown_means(&l->mesh, direct_sources_shown(l->relight.sources), &state[0], &scratch),
                shown_means(&l->mesh, direct_sources_shown(other->relight.sources), &state[1], &scratch),
                1e-3, 1e-2, &scratch);
    // And back.
    expect_near("back", l, turned_to(l, 12.5, doors, &scratch), noon, 1e-3, 1e-2, &scratch);
    lamps3_free(l);
    lamps3_free(other);
    arena_free(&scratch);
}

// Proves that light that turns is the same on any number of threads, to the last bit.
Test(hours, threads_do_not_matter, .timeout = 240) {
    RadSolution found[2];
    Lamps3 *l[2];
    Arena scratch = {0};
    Daylight day = day_at(15);
    for (int i = 0; i < 2; i++) {
        l[i] = lamps3_load(true);
        lamps3_follow(l[i], 1e-3, 1 + i);
        cr_assert(relight_turn(&l[i]->relight, &day, l[i]->doors, NULL, &scratch, &found[i]));
    }
    cr_assert_eq(found[0].node_count, found[1].node_count);
    cr_expect_eq(memcmp(found[0].node, found[1].node, (size_t)found[0].node_count * sizeof *found[0].node),
                 0);
    cr_expect_eq(memcmp(found[0].radiosity, found[1].radiosity,
                        (size_t)found[0].element_count * sizeof *found[0].radiosity),
                 0);
    for (int i = 0; i < 2; i++) lamps3_free(l[i]);
    arena_free(&scratch);
}

static bool stop_at(void *context, const char *stage, double done) {
    int *left = context;
    (void)stage;
    (void)done;
    return --*left > 0;
}

// Proves that a turn that is broken off anywhere leaves light that follows as before: what turns then is the same as without.
Test(hours, turns_broken_off, .timeout = 240) {
    Lamps3 *l = lamps3_load(true), *other = lamps3_load(true);
    lamps3_follow(l, 1e-3, 2);
    lamps3_follow(other, 1e-3, 2);
    Arena scratch = {0};
    Daylight day = day_at(17), was = l->day;
    int broken = 0;
    for (int after = 1; after < 100000; after = after * 3 / 2 + 1, broken++) {
        RadSolution *out = ARENA_ARRAY(&scratch, RadSolution, 1);
        int left = after;
        Progress progress = {stop_at, &left};
        if (relight_turn(&l->relight, &day, l->doors, &progress, &scratch, out)) break;
        cr_expect_eq(memcmp(&was, &l->day, sizeof was), 0);
    }
    cr_expect(broken > 5 && memcmp(&day, &l->day, sizeof day) == 0, "%d", broken);
    expect_near("after turns that were broken off", l, turned_to(l, 12.5, l->doors, &scratch),
                turned_to(other, 12.5, l->doors, &scratch), 1e-3, 1e-2, &scratch);
    lamps3_free(l);
    lamps3_free(other);
    arena_free(&scratch);
}
