// test_shoot_runs.c - shooting is the same on any threads and memory, goes on where it stopped, and refuses scenes without light.
#include <criterion/criterion.h>

#include "radiosity/shoot/shoot_queue.h"
#include "tests/radiosity/shoot/shoot_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static Bytes save(Lit *lit, const RadSolution *s) {
    Error error = {""};
    const char *path = arena_format(&lit->arena, "%s/x.rad", support_folder(&lit->arena));
    cr_assert(rad_save(path, &lit->mesh, NULL, s, &error), "%s", error.text);
    return support_read(&lit->arena, path);
}

static void expect_same(Bytes a, Bytes b, const char *what, long long number) {
    cr_assert_eq(a.size, b.size);
    cr_assert(memcmp(a.data, b.data, a.size) == 0, "the .rad file is another with %s %lld", what, number);
}

// Proves that the .rad file depends on nothing but building, mesh and method: not on threads, on the memory for rows, or
// on culling.
Test(shoot, is_the_same_however_it_is_done, .timeout = 300) {
    Lit *lit = lit_rooms(5);
    RadOptions options = shoot_options_to(0.02);
    RadSolution s;
    options.threads = 1;
    RadReport report = lit_shoot(lit, &options, &s);
    cr_assert_gt(report.shots, report.rows_made, "nobody shot twice: the rows' memory is not tried");
    Bytes first = save(lit, &s);
    static const int THREADS[] = {2, 7};
    static const size_t MEMORY[] = {0, 1 << 20, 100 << 20};
    for (int t = 0; t < 2; t++) {
        for (int m = 0; m < 3; m++) {
            options.threads = THREADS[t];
            options.row_bytes = MEMORY[m];
            report = lit_shoot(lit, &options, &s);
            cr_assert_leq(report.row_bytes, MEMORY[m]);
            expect_same(first, save(lit, &s), "threads", THREADS[t]);
        }
    }
    for (int culling = 0; culling < CULLINGS; culling++) {
        options.culling = (Culling)culling;
        lit_shoot(lit, &options, &s);
        expect_same(first, save(lit, &s), "culling", culling);
    }
    lit_free(lit);
}

static bool stop_at_once(void *context, const char *stage, double done) {
    int *calls = context;
    (void)stage;
    cr_assert(done >= 0 && done <= 1);
    return ++*calls < 4;
}

// Proves that a run that was broken off - by a number of shots, by the caller - is a valid solution, and that
// going on from its file ends in the same bytes as never having stopped.
Test(shoot, goes_on_where_it_stopped) {
    Lit *lit = lit_rooms(8);
    RadOptions options = shoot_options_to(1e-6);
    RadSolution straight, s;
    options.shots = 1500;
    lit_shoot(lit, &options, &straight);
    cr_assert_eq(straight.shots, 1500);
    Error error = {""};
    const char *path = arena_format(&lit->arena, "%s/x.rad", support_folder(&lit->arena));
    cr_assert(rad_start(&lit->mesh, &lit->arena, &s, &error));
    for (int part = 0; part < 4; part++) {
        int calls = 0;
        Progress progress = {stop_at_once, &calls};
        options.threads = part + 1;
        options.shots = part == 0 ? 333 : part == 1 ? 700 : 1500;
        RadReport report =
            rad_shoot(&lit->mesh, &lit->forest, NULL, &options, part == 2 ? &progress : NULL, &s);
        cr_assert_eq(report.stopped, part == 2);
        cr_assert_lt(shoot_lost_power(lit, &s), 1e-12);
        cr_assert(rad_save(path, &lit->mesh, NULL, &s, &error), "%s", error.text);
        cr_assert(rad_load(path, &lit->mesh, NULL, &lit->arena, &s, &error), "%s", error.text);
        if (part < 3) cr_assert_lt(s.shots, 1500);
    }
    expect_same(save(lit, &straight), save(lit, &s), "shots", s.shots);
    int calls = 3;
    Progress at_once = {stop_at_once, &calls};
    options.shots = 0;
    cr_assert(rad_shoot(&lit->mesh, &lit->forest, NULL, &options, &at_once, &s).stopped);
    cr_assert_eq(s.shots, 1500);
    lit_free(lit);
}

// Proves that what is no light is refused with a sentence.
Test(shoot, refuses_what_gives_no_light) {
    static const struct {
        int material;
        float reflectance, emission;
        const char *expected;
    } CASES[] = {{LIT_LAMP, 0, 0, "nothing emits light"},
                 {LIT_WALL, 1, 0, "reflectance 1 (allowed: at least 0, below 1)"},
                 {LIT_WALL, -0.1f, 0, "reflectance -0.1"},
                 {LIT_WALL, NAN, 0, "reflectance nan"},
                 {LIT_LAMP, 0, -3, "exitance -3 W/m^2"},
                 {LIT_LAMP, 0, INFINITY, "exitance inf"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Lit *lit = lit_new();
        lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
        lit_lamp(lit, vec3(2, 1.5, 2.4));
        float rho = CASES[i].reflectance, e = CASES[i].emission;
        lit->building->materials[CASES[i].material].reflectance = (Rgb){rho, rho, rho};
        lit->building->materials[CASES[i].material].emission = (Rgb){e, e, e};
        lit_finish(lit, 1, 2);
        RadSolution s;
        Error error = {""};
        cr_assert_not(rad_start(&lit->mesh, &lit->arena, &s, &error));
        cr_assert_not_null(strstr(error.text, CASES[i].expected), "says `%s`", error.text);
        lit_free(lit);
    }
}

// Proves the queue against a plain search, with many ties: the strongest, and the strongest of those not taken, lowest
// index first.
Test(shoot, queue_is_a_plain_search) {
    for (uint64_t seed = 1; seed <= 20; seed++) {
        Random random = {seed};
        Arena arena = {0};
        ShootQueue queue;
        int count = 1 + random_index(&random, seed % 2 ? 300 : 9000);
        shoot_queue_start(&queue, count, &arena);
        bool *taken = ARENA_ARRAY(&arena, bool, count);
        cr_assert_eq(shoot_queue_top(&queue), -1);
        for (int i = 0; i < 2000; i++) {
            int patch = random_index(&random, count);
            taken[random_index(&random, count)] ^= true;
            if (random_unit(&random) < 0.2)
                shoot_queue_clear(&queue, patch);
            else
                shoot_queue_raise(&queue, patch, queue.power[patch] + random_index(&random, 4));
            int best = -1, next[5], found = shoot_queue_next(&queue, taken, 2, 5, next);
            for (int p = 0; p < count; p++)
                if (queue.power[p] > (best < 0 ? 0 : queue.power[best])) best = p;
            cr_assert_eq(shoot_queue_top(&queue), best, "seed %llu", (unsigned long long)seed);
            for (int k = 0; k < 5; k++) {
                int wanted = -1;
                for (int p = 0; p < count; p++) {
                    bool before = false;
                    for (int j = 0; j < k && j < found; j++) before = before || next[j] == p;
                    if (taken[p] || before || queue.power[p] < 2) continue;
                    if (wanted < 0 || queue.power[p] > queue.power[wanted]) wanted = p;
                }
                // The next strongest is among those found: it is moved to the front of what is left of them.
                int at = k;
                while (at < found && next[at] != wanted) at++;
                cr_assert(wanted < 0 ? k >= found : at < found, "seed %llu", (unsigned long long)seed);
                if (wanted >= 0) next[at] = next[k], next[k] = wanted;
            }
        }
        arena_free(&arena);
    }
}
