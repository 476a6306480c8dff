// bench_relight.c - how soon light follows lamps and doors, and how right it is then. Lamps: sums of the light of each, all light shot anew
// along rows that are kept, and all from nothing, against lamps of which each is shot to a ten-millionth. Doors: each is opened, or closed
// where it stands open, and what that changes is found anew, against light that is shot to a ten-millionth in the same state. Hours: by day
// the light turns to others, against light from nothing at that hour on the same elements.
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "engine/scene/bake_mesh.h"
#include "radiosity/follow/each_lamp.h"
#include "radiosity/follow/relight.h"
#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/shown.h"

static const char HEAD[] = "building,change,method,ms_90,ms_whole,speedup,error_p99,error_mean,lamps,"
                           "elements,mb,ms_first,first_share\n";
// Random states; and those of them that are also shot, which takes minutes.
enum { STATES = 200, SHOT = 1, APART = STATES / SHOT + 1 };
// The truth: of each lamp's light a tenth of this is not shot (each_lamp.h).
static const double TRUTH = 1e-6;
// Light below this share of the brightest state of a place counts as that much. So does light below this share of the mean of all places:
// a third of the first step above black that a display of 8 bits shows (1 / 255 / 12.92 of white, in sRGB). Cracks behind furniture have
// less.
static const double DARK = 1e-3, NOTHING = 1e-4;

typedef struct Relit {
    const char *file;
    LoadedScene scene;
    float *doors;
    Mesh mesh;
    RadOptions rad;
    RadSolution solution, truth;  // both with `each`, by night
    Daylight day;                 // of the rows
    Relight relight;
    double bake_seconds, each_seconds;
    Text *csv;
} Relit;

static void copy_light(Arena *arena, RadSolution *s) {
    double(**all[])[3] = {&s->radiosity, &s->direct, &s->node, &s->rest, &s->unshot};
    const int count[] = {s->element_count, s->element_count, s->node_count, s->node_count, s->patch_count};
    for (int i = 0; i < 5; i++) {
        double(*to)[3] = arena_alloc(arena, (size_t)count[i] + 1, sizeof *to);
        memcpy(to, *all[i], (size_t)count[i] * sizeof *to);
        *all[i] = to;
    }
}

// Bakes light that can follow.
static bool bake_all(Relit *r, Arena *arena, Error *error) {
    double start = clock_seconds();
    BakeOptions bake = bake_default_options();
    const StabForest *forest = &r->scene.forest;
    r->day = bake.day = r->scene.day;
    const bool by_day = daylight_shines(&r->day);
    if (!bake_mesh(&bake, &r->scene, NULL, NULL, arena, &r->doors, &r->mesh, error)) return false;
    r->rad = bake.rad;
    rad_fit(&r->mesh, &r->rad);
    if (by_day) {
        r->rad.form_factor.sky_parts = true;
        r->rad.sky = sky_looks_new(&r->mesh, forest, r->doors, &r->rad);
    }
    if (!(by_day ? rad_start_dark : rad_start)(&r->mesh, arena, &r->solution, error)) return false;
    if (by_day) rad_shine(&r->mesh, forest, r->doors, &r->rad, &r->day, NULL, &r->solution);
    r->rad.rows = shoot_rows_new(&r->mesh, forest, r->doors, &r->rad, &r->day, arena);
    DirectSources *sources = each_lamp_sources(&r->mesh, &r->scene.lamps, 0, arena);
    relight_prepare(sources, &r->mesh, arena);
    if (by_day) direct_sources_turn(sources, NULL, NULL);
    rad_shoot(&r->mesh, forest, r->doors, &r->rad, NULL, &r->solution);
    direct_show_apart(&r->mesh, forest, r->doors, 0, NULL, arena, &r->solution, sources, NULL, NULL);
    r->bake_seconds = clock_seconds() - start;
    r->relight = (Relight){.mesh = &r->mesh,
                           .lamps = &r->scene.lamps,
                           .forest = forest,
                           .door_open = r->doors,
                           .options = &r->rad,
                           .sources = sources,
                           .all = &r->solution,
                           .day = &r->day};
    r->truth = r->solution;
    copy_light(arena, &r->truth);
    return true;
}

static bool find_each(Relit *r, Arena *arena, Error *error) {
    RadOptions fine = r->rad;
    fine.residual = TRUTH;
    EachLamp each = {&r->mesh, &r->scene.lamps, &r->scene.forest, r->doors, &r->rad, r->relight.sources},
             exact = each;
    exact.options = &fine;
    double start = clock_seconds();
    bool good = each_lamp_find(&each, NULL, arena, &r->solution);
    r->each_seconds = clock_seconds() - start;
    good = good && each_lamp_find(&exact, NULL, arena, &r->truth);
    return good || error_set(error, "%s: the light of each lamp could not be found", r->file);
}

// ---- errors

typedef struct Errors {
    float *off;  // [count]
    size_t count;
    double sum;
} Errors;

static Errors errors_new(int elements, int states, Arena *arena) {
    return (Errors){.off = arena_alloc(arena, (size_t)elements * (size_t)states + 1, sizeof(float))};
}

static void add_errors(Errors *e, double (*light)[3], double (*truth)[3], double (*brightest)[3], int count) {
    double mean = 0;
    for (int i = 0; i < count; i++) mean += rgb_sum(brightest[i]) / count;
    for (int i = 0; i < count; i++) {
        double scale = fmax(fmax(rgb_sum(truth[i]), DARK * rgb_sum(brightest[i])), NOTHING * mean);
        if (!(scale > 0)) continue;
        double off = fabs(rgb_sum(light[i]) - rgb_sum(truth[i])) / scale;
        e->off[e->count++] = (float)off;
        e->sum += off;
    }
}

static int smaller_first(const void *a, const void *b) {
    float p = *(const float *)a, q = *(const float *)b;
    return (p > q) - (p < q);
}

// How long light takes: until the first step is there, which makes `share` of the change; until 90 % of the change is; until all is.
typedef struct Seconds {
    double first, share, most, whole;
} Seconds;

static Seconds at_once(double seconds) { return (Seconds){seconds, 1, seconds, seconds}; }

static void print_row(Relit *r, const char *change, const char *method, Seconds after, Errors *e) {
    size_t before = r->csv->size;
    qsort(e->off, e->count, sizeof *e->off, smaller_first);
    text_append(r->csv, "%s,%s,%s,%.2f,%.2f,%.1f,%.5f,%.6f,%d,%d,%.2f,%.2f,%.3f\n", bench_name(r->file),
                change, method, 1e3 * after.most, 1e3 * after.whole, r->bake_seconds / after.whole,
                e->count > 0 ? (double)e->off[(size_t)(0.99 * (double)(e->count - 1))] : 0,
                e->count > 0 ? e->sum / (double)e->count : 0, r->scene.lamps.count, r->mesh.element_count,
                (double)each_lamp_bytes(&r->solution) / (1 << 20), 1e3 * after.first, after.share);
    fputs(r->csv->data + before, stdout);
    fflush(stdout);
}

// ---- states

// One lamp alone at first, then any: on, off, dimmed, coloured.
static void random_state(Random *random, int index, int count, Rgb *lit) {
    for (int i = 0; i < count; i++) {
        bool on = index < count ? i == index : random_unit(random) < 0.5;
        float share = on && random_unit(random) < 0.5 ? (float)random_unit(random) : (float)on;
        bool coloured = index >= count && random_unit(random) < 0.2;
        lit[i] = (Rgb){share, coloured ? share / 2 : share, coloured ? 0 : share};
    }
}

// Shot in the state as it is: from nothing, or along kept rows.
static double shoot_state(const Relit *r, const Rgb *lit, bool kept, Arena *arena, RadSolution *out) {
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    Error error;
    RadOptions rad = r->rad;
    double start = clock_seconds();
    *mesh = lamps_mesh(&r->scene.lamps, &r->mesh, lit, arena);
    if (!kept) rad.rows = NULL;
    rad_start_dark(mesh, arena, out, &error);
    rad_shoot(mesh, &r->scene.forest, r->doors, &rad, NULL, out);
    direct_show(mesh, &r->scene.forest, r->doors, 0, NULL, arena, out, NULL);
    return clock_seconds() - start;
}

static void compare_states(Relit *r, const BenchArguments *a) {
    Arena scratch = {0};
    Random random = {a->seed};
    int lamps = r->scene.lamps.count, elements = r->mesh.element_count, nodes = r->solution.node_count;
    Rgb *lit = ARENA_ARRAY(&scratch, Rgb, lamps + 1);
    RadSolution brightest = r->truth;
    copy_light(&scratch, &brightest);
    Errors of_elements = errors_new(elements, STATES, &scratch),
           of_nodes = errors_new(nodes, STATES, &scratch), kept = errors_new(elements, SHOT, &scratch),
           anew = errors_new(elements, SHOT, &scratch);
    double seconds[3] = {0};
    for (int i = 0; i < STATES; i++) {
        random_state(&random, i, lamps, lit);
        double start = clock_seconds();
        each_lamp_sum(&r->solution, lit);
        seconds[0] += (clock_seconds() - start) / STATES;
        each_lamp_sum(&r->truth, lit);
        add_errors(&of_elements, r->solution.radiosity, r->truth.radiosity, brightest.radiosity, elements);
        add_errors(&of_nodes, r->solution.node, r->truth.node, brightest.node, nodes);
        for (int nothing = 0; nothing < 2 && i % APART == 1; nothing++) {
            Arena shot = {0};
            RadSolution s;
            seconds[1 + nothing] += shoot_state(r, lit, !nothing, &shot, &s) / SHOT;
            add_errors(nothing ? &anew : &kept, s.radiosity, r->truth.radiosity, brightest.radiosity,
                       elements);
            arena_free(&shot);
        }
    }
    print_row(r, "lamps", "sum of lamps", at_once(seconds[0]), &of_elements);
    print_row(r, "lamps", "sum of lamps; as shown", at_once(seconds[0]), &of_nodes);
    print_row(r, "lamps", "shot along kept rows", at_once(seconds[1]), &kept);
    print_row(r, "lamps", "from nothing", at_once(seconds[2]), &anew);
    arena_free(&scratch);
}

// ---- doors

// Doors of a building that are moved, at most.
enum { DOORS = 24 };

// The share of a change of light that a first step makes.
static double share_of_change(const RadSolution *before, const RadSolution *first, const RadSolution *whole) {
    double left = 0, all = 0;
    for (int n = 0; n < whole->node_count; n++)
        for (int c = 0; c < 3; c++) {
            left += fabs(whole->node[n][c] - first->node[n][c]);
            all += fabs(whole->node[n][c] - before->node[n][c]);
        }
    return all > 0 ? 1 - left / all : 1;
}

// Light follows a door, in two steps.
static Seconds follow(Relight *relight, const float *doors, const Rgb *lit, const RadSolution *before,
                      Arena *arena, RadSolution *now) {
    RadSolution first;
    double start = clock_seconds();
    relight_straight(relight, doors, lit, before, arena, &first, NULL);
    double soon = clock_seconds() - start;
    relight_state(relight, doors, lit, NULL, arena, now, NULL);
    double whole = clock_seconds() - start;
    double share = share_of_change(before, &first, now);
    return (Seconds){soon, share, share < 0.9 ? whole : soon, whole};
}

static void add_seconds(Seconds *sum, Seconds *worst, Seconds s) {
    *sum = (Seconds){sum->first + s.first, sum->share + s.share, sum->most + s.most, sum->whole + s.whole};
    *worst = (Seconds){fmax(worst->first, s.first), fmin(worst->share, s.share), fmax(worst->most, s.most),
                       fmax(worst->whole, s.whole)};
}

static void compare_doors(Relit *r) {
    static const char METHOD[] = "straight light first; then differences";
    Arena scratch = {0}, found[2] = {{0}};
    const Building *b = &r->scene.building;
    RadOptions fine = r->rad;
    fine.residual = TRUTH / 10;
    Relight *relight = &r->relight, exact = *relight;
    exact.options = &fine;
    int openings = b->opening_count, count = 0, nodes = r->solution.node_count;
    float *doors = ARENA_ARRAY(&scratch, float, openings + 1);
    Rgb *lit = ARENA_ARRAY(&scratch, Rgb, r->scene.lamps.count + 1);
    Errors all = errors_new(nodes, DOORS, &scratch);
    Seconds mean = {0}, worst = {.share = 1};
    RadSolution state[2];
    memcpy(doors, r->doors, (size_t)openings * sizeof *doors);
    for (int i = 0; i < r->scene.lamps.count; i++) lit[i] = (Rgb){1, 1, 1};
    if (r->truth.each) each_lamp_sum(&r->truth, lit);
    relight_state(relight, doors, lit, NULL, &found[0], &state[0], NULL);
    for (int i = 0; i < openings && count < DOORS; i++) {
        int now = (count + 1) % 2;
        Arena truth_arena = {0};
        RadSolution truth;
        if (b->openings[i].kind != OPENING_DOOR) continue;
        doors[i] = doors[i] > 0.5F ? 0 : 1;
        arena_free(&found[now]);
        Seconds seconds = follow(relight, doors, lit, &state[1 - now], &found[now], &state[now]);
        // Its last light is of other rows: all is shot from nothing.
        relight_end(&exact);
        relight_state(&exact, doors, lit, NULL, &truth_arena, &truth, NULL);
        Errors of_door = errors_new(nodes, 1, &truth_arena);
        add_errors(&of_door, state[now].node, truth.node, r->truth.node, nodes);
        add_errors(&all, state[now].node, truth.node, r->truth.node, nodes);
        print_row(r, b->openings[i].name, METHOD, seconds, &of_door);
        add_seconds(&mean, &worst, seconds);
        count++;
        arena_free(&truth_arena);
    }
    if (count > 0) {
        mean = (Seconds){mean.first / count, mean.share / count, mean.most / count, mean.whole / count};
        print_row(r, "a door in the mean", METHOD, mean, &all);
        print_row(r, "the worst door", METHOD, worst, &all);
    }
    relight_end(&exact);
    memcpy(doors, r->doors, (size_t)openings * sizeof *doors);
    for (int i = 0; i < 2; i++) arena_free(&found[i]);
    arena_free(&scratch);
}

// ---- hours

// On the same elements, with the doors as they stand.
static double (*from_nothing(const Relit *r, const Daylight *day, Arena *arena))[3] {
    RadSolution s;
    Error error;
    Mesh finer;
    RadOptions rad = r->rad;
    const StabForest *forest = &r->scene.forest;
    rad.rows = NULL;
    rad.sky = NULL;
    rad_start_dark(&r->mesh, arena, &s, &error);
    rad_shine(&r->mesh, forest, r->doors, &rad, day, NULL, &s);
    rad_shoot(&r->mesh, forest, r->doors, &rad, NULL, &s);
    direct_show(&r->mesh, forest, r->doors, 0, NULL, arena, &s, NULL);
    bool is_finer = s.shown && shown_build(&r->mesh, s.shown, r->doors, arena, &finer, &error);
    return shown_means(&r->mesh, is_finer ? &finer : &r->mesh, &s, arena);
}

// The hours that the light turns to, after that of the bake, minutes.
static const int TURNS[] = {10, 20, 30, 90, 210, 390};

static void compare_hours(Relit *r, const BenchArguments *a) {
    Arena rooms[2] = {{0}}, scratch = {0};
    double begun = day_hour(&a->load.day, &r->scene.building, &r->day);
    float *doors = ARENA_ARRAY(&scratch, float, r->scene.building.opening_count + 1);
    memcpy(doors, r->doors, (size_t)r->scene.building.opening_count * sizeof *doors);
    for (size_t i = 0; i < sizeof TURNS / sizeof *TURNS; i++) {
        Arena *room = &rooms[i % 2], truth = {0};
        Daylight day;
        Error error;
        double hour = begun + TURNS[i] / 60.0;
        DayOptions at = day_at_hour(&a->load.day, &r->scene.building, hour);
        if (at.night || !day_over(&at, &r->scene.building, &day, &error)) break;
        arena_free(room);
        RadSolution *s = ARENA_ARRAY(room, RadSolution, 1);
        double start = clock_seconds();
        relight_turn(&r->relight, &day, doors, NULL, room, s);
        double seconds = clock_seconds() - start;
        Errors off = errors_new(r->mesh.element_count, 1, &truth);
        double(*wanted)[3] = from_nothing(r, &day, &truth);
        add_errors(&off, shown_means(&r->mesh, direct_sources_shown(r->relight.sources), s, &truth), wanted,
                   wanted, r->mesh.element_count);
        print_row(r, arena_format(&truth, "%d minutes later", TURNS[i]), "kept rows and looks at the sky",
                  at_once(seconds), &off);
        arena_free(&truth);
    }
    relight_end(&r->relight);
    direct_sources_end(r->relight.sources);
    r->relight.sources = NULL;
    for (int i = 0; i < 2; i++) arena_free(&rooms[i]);
    arena_free(&scratch);
}

static bool relight_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Relit *r = calloc(1, sizeof *r);
    Arena arena = {0};
    SceneOptions load = a->load;
    load.lamps = SCENE_LAMPS_ALL;
    if (!r) return error_set(error, "no memory");
    r->file = file;
    r->csv = csv;
    bool good = app_load(file, &load, &arena, &r->scene, error) && bake_all(r, &arena, error);
    const bool day = good && daylight_shines(&r->day);
    Errors none = {0};
    if (good) print_row(r, day ? "the day" : "all lamps", "all together", at_once(r->bake_seconds), &none);
    good = good && (day || find_each(r, &arena, error));
    if (good && !day) {
        print_row(r, "all lamps", "each lamp by itself", at_once(r->each_seconds), &none);
        compare_states(r, a);
    }
    if (good) compare_doors(r);
    if (good && day && !daylight_is_uniform(&r->day)) compare_hours(r, a);
    relight_end(&r->relight);
    if (r->relight.sources) direct_sources_end(r->relight.sources);
    if (r->rad.rows) shoot_rows_end(r->rad.rows);
    if (r->rad.sky) sky_looks_end(r->rad.sky);
    arena_free(&arena);
    free(r);
    return good;
}

static bool measure_relight(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, NULL, relight_file, error);
}

static const Option ROWS[] = {BENCH_SEED("of the states"), OPTION_FILL_LAMPS(BENCH_AT(load.fill_lamps)),
                              OPTION_DAYLIGHT(BENCH_AT(load.day), "default"), BENCH_CSV};

const Bench BENCH_RELIGHT = {
    .name = "relight",
    .about =
        "200 states of the lamps of each FILE, and each of its doors opened or closed: how soon their light "
        "is there, and how far it is off the light of lamps that are shot to a ten-millionth, at elements "
        "and at what is shown; relative to the light there, or to a thousandth of that of all lamps where "
        "that is more. By day the doors, and hours to which the light turns",
    BENCH_OPTIONS(ROWS),
    .run = measure_relight,
    .files = "build/maps/house.plan",
    .fill_lamps = FILL_LAMPS_ON,
};
