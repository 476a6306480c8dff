// test_bake_parts.c - light that is found in parts of a building, side by side, is that of the whole.
#include <criterion/criterion.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/scene/bake_parts.h"
#include "engine/scene/kept_parts.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "tests/support/support.h"

// A building that is baked in parts, and the same bake options.
typedef struct Parted {
    Arena arena;
    LoadedScene scene;
    BakeOptions options;
    float *doors;
    Mesh mesh;
    RadSolution light;
    PartsReport report;
} Parted;

static Parted *load(const char *path, bool day, double element, double residual) {
    Parted *p = calloc(1, sizeof *p);
    SceneOptions load = scene_default_options();
    Error error = {""};
    load.day.day = day;
    load.day.night = !day;
    load.lamps = SCENE_LAMPS_ALL;
    cr_assert(scene_load(path, &load, &p->arena, &p->scene, &error), "%s", error.text);
    p->options = bake_default_options();
    p->options.day = p->scene.day;
    p->options.mesh.element = element;
    p->options.rad.residual = residual;
    return p;
}

static bool try_bake(Parted *p, int cells, const PartsKeep *keep, const Progress *progress, Error *error) {
    return bake_parts(&p->options, &p->scene, cells, keep, progress, &p->arena, &p->doors, &p->mesh,
                      &p->light, &p->report, error);
}

static void bake(Parted *p, int cells, int threads) {
    Error error = {""};
    p->options.rad.threads = threads;
    cr_assert(try_bake(p, cells, NULL, NULL, &error), "%s", error.text);
}

static void end(Parted *p) {
    arena_free(&p->arena);
    free(p);
}

// Light of the whole building on the mesh that came of the parts, shown.
static RadSolution whole_light(Parted *p) {
    Error error = {""};
    RadSolution out;
    RadOptions rad = p->options.rad;
    rad_fit(&p->mesh, &rad);
    cr_assert(rad_start_dark(&p->mesh, &p->arena, &out, &error));
    if (daylight_shines(&p->scene.day))
        cr_assert(rad_shine(&p->mesh, &p->scene.forest, p->doors, &rad, &p->scene.day, NULL, &out));
    rad_shoot(&p->mesh, &p->scene.forest, p->doors, &rad, NULL, &out);
    cr_assert(direct_show(&p->mesh, &p->scene.forest, p->doors, 0, NULL, &p->arena, &out, NULL));
    return out;
}

// Proves that with a single part the light is, to the last bit, that of a bake of the whole, on the same mesh and at the same nodes.
Test(parts, one_part_is_the_whole) {
    Parted *p = load("build/maps/two-rooms.plan", false, 0.4, 1e-3);
    Error error = {""};
    Mesh mesh;
    float *doors;
    bake(p, 1000, 0);
    cr_assert(bake_mesh(&p->options, &p->scene, NULL, NULL, &p->arena, &doors, &mesh, &error));
    RadSolution whole = whole_light(p);
    cr_assert_eq(p->report.parts, 1);
    cr_assert_eq(mesh.element_count, p->mesh.element_count);
    cr_assert_eq(whole.node_count, p->light.node_count);
    cr_expect(memcmp(whole.radiosity, p->light.radiosity,
                     (size_t)mesh.element_count * sizeof *whole.radiosity) == 0);
    cr_expect(memcmp(whole.node, p->light.node, (size_t)whole.node_count * sizeof *whole.node) == 0);
    end(p);
}

static int ascending(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

// The 99th percentile of how far two lights are apart, by elements or by patches, relative to the mean in the cell before each.
static double apart(const Parted *p, double (*a)[3], double (*b)[3]) {
    const Mesh *mesh = &p->mesh;
    Arena scratch = {0};
    int cells = mesh->graph->cell_count, count = 0;
    double *light = ARENA_ARRAY(&scratch, double, cells), *area = ARENA_ARRAY(&scratch, double, cells),
           *off = ARENA_ARRAY(&scratch, double, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++) {
        int cell = mesh->patches[mesh->elements[e].patch].cell;
        if (cell < 0) continue;
        light[cell] += mesh->elements[e].area * rgb_sum(a[e]);
        area[cell] += mesh->elements[e].area;
    }
    for (int e = 0; e < mesh->element_count; e++) {
        int cell = mesh->patches[mesh->elements[e].patch].cell;
        if (cell < 0 || !(light[cell] > 0)) continue;
        off[count++] = fabs(rgb_sum(a[e]) - rgb_sum(b[e])) / (light[cell] / area[cell]);
    }
    qsort(off, (size_t)count, sizeof *off, ascending);
    double out = off[(int)(0.99 * count)];
    arena_free(&scratch);
    return out;
}

static void check_energy(const Parted *p) {
    const RadSolution *s = &p->light;
    for (int c = 0; c < 3; c++) {
        double left = 0;
        for (int i = 0; i < p->mesh.patch_count; i++) left += s->unshot[i][c] * p->mesh.patches[i].area;
        // The roundings of some 100,000 shots.
        cr_expect_float_eq(s->absorbed[c] + s->escaped[c] + left, s->emitted[c], 1e-9 * s->emitted[c]);
    }
}

// The mesh that shows light is cut where the light passes a threshold, and two lights that are 1e-5 apart may be cut differently. With
// elements of this size they are not: the nodes are the same.
static void check_light(bool day) {
    Parted *p = load("build/maps/house.plan", day, 0.8, 1e-5);
    bake(p, 30, 0);
    cr_assert_geq(p->report.parts, 3);
    RadSolution whole = whole_light(p);
    check_energy(p);
    double elements = apart(p, whole.radiosity, p->light.radiosity);
    double *off = ARENA_ARRAY(&p->arena, double, whole.node_count), mean = 0;
    cr_assert_eq(whole.node_count, p->light.node_count);
    for (int n = 0; n < whole.node_count; n++) {
        off[n] = fabs(rgb_sum(whole.node[n]) - rgb_sum(p->light.node[n]));
        mean += rgb_sum(whole.node[n]) / whole.node_count;
    }
    qsort(off, (size_t)whole.node_count, sizeof *off, ascending);
    double nodes = off[(int)(0.999 * whole.node_count)] / mean;
    printf("%d parts: elements %.2g %% off at the 99th percentile, nodes %.2g %% of the mean at the 99.9th\n",
           p->report.parts, 100 * elements, 100 * nodes);
    cr_expect_leq(elements, 0.01);
    cr_expect_leq(nodes, 0.01);
    end(p);
}

// Proves that light in parts is that of the whole on the same mesh: within 1 % of the mean before each element but for one in a hundred, by
// night and by day; that what is shown is so, too, within 1 % of the mean but for one node in a thousand, since few nodes lie at borders;
// and that no power is lost where light passes from part to part.
Test(parts, light_is_that_of_the_whole_by_night) { check_light(false); }
Test(parts, light_is_that_of_the_whole_by_day) { check_light(true); }

// Proves that the light does not depend on the number of threads.
Test(parts, the_same_on_any_threads) {
    Parted *one = load("build/maps/two-rooms.plan", true, 0.5, 1e-3),
           *three = load("build/maps/two-rooms.plan", true, 0.5, 1e-3);
    bake(one, 2, 1);
    bake(three, 2, 3);
    cr_assert_gt(one->report.parts, 1);
    cr_assert_eq(one->light.node_count, three->light.node_count);
    cr_expect(memcmp(one->light.node, three->light.node,
                     (size_t)one->light.node_count * sizeof *one->light.node) == 0);
    end(one);
    end(three);
}

// ---- light that is kept

// Asks to stop at the report with this number, -1: at none. Counts them.
typedef struct Stop {
    int at, count;
} Stop;
static bool count_down(void *context, const char *stage, double done) {
    Stop *stop = context;
    (void)stage, (void)done;
    return stop->count++ != stop->at;
}

static void expect_same(const Parted *a, const Parted *b, const char *what) {
    cr_assert_eq(a->mesh.element_count, b->mesh.element_count);
    cr_assert_eq(a->light.node_count, b->light.node_count);
    cr_expect_eq(a->light.shots, b->light.shots, "%s", what);
    cr_expect(memcmp(a->light.emitted, b->light.emitted, sizeof a->light.emitted) == 0, "%s", what);
    cr_expect(memcmp(a->light.absorbed, b->light.absorbed, sizeof a->light.absorbed) == 0, "%s", what);
    cr_expect(memcmp(a->light.radiosity, b->light.radiosity,
                     (size_t)a->mesh.element_count * sizeof *a->light.radiosity) == 0,
              "%s", what);
    cr_expect(memcmp(a->light.node, b->light.node, (size_t)a->light.node_count * sizeof *a->light.node) == 0,
              "%s", what);
}

// A bake that is stopped at moments all over it, and goes on from what was kept, is to the last bit one that never was. Each state is kept.
static void check_going_on(const char *path, bool day, double element, int cells) {
    Parted *whole = load(path, day, element, 1e-3), *parted = load(path, day, element, 1e-3);
    Error error = {""};
    const char *folder = arena_format(&whole->arena, "%s/kept", support_folder(&whole->arena));
    PartsKeep keep = {folder, 0, false};
    Stop stop = {-1, 0};
    Progress progress = {count_down, &stop};
    bake(whole, cells, 0);
    cr_assert(try_bake(parted, cells, &keep, &progress, &error), "%s", error.text);
    expect_same(whole, parted, "kept all along");
    cr_assert(parted->report.kept >= 3 && parted->report.parts > 1, "kept %d times", parted->report.kept);
    const int reports = stop.count, tries = support_count(4, 40);
    int resumed = 0;
    for (int i = 1; i <= tries; i++) {
        kept_remove(folder, INT_MAX);
        keep.resume = false;
        stop = (Stop){reports * i / (tries + 1), 0};
        if (try_bake(parted, cells, &keep, &progress, &error)) continue;
        int set, parts = parted->report.parts;
        bool kept = kept_find(folder, parts, &set, NULL);
        cr_expect_eq(strstr(error.text, "--resume") != NULL, kept, "%s", error.text);
        if (!kept) continue;
        keep.resume = true;
        stop.at = -1;
        cr_assert(try_bake(parted, cells, &keep, &progress, &error), "%s", error.text);
        expect_same(whole, parted, "gone on");
        resumed++;
    }
    cr_expect_geq(resumed, tries / 4);
    kept_remove(folder, INT_MAX);
    end(whole);
    end(parted);
}

// Proves it by night and by day.
Test(parts, goes_on_from_what_was_kept, .timeout = 600) {
    check_going_on("build/maps/two-rooms.plan", false, 0.4, 2);
    check_going_on("build/maps/two-rooms.plan", true, 0.5, 2);
}

// Proves that a set with a file missing is passed over for the one before it, and that files of other parts, of another day and damaged
// ones are refused with a sentence.
Test(parts, refuses_what_does_not_fit) {
    Parted *p = load("build/maps/two-rooms.plan", false, 0.5, 1e-2),
           *day = load("build/maps/two-rooms.plan", true, 0.5, 1e-2);
    Error error = {""};
    const char *folder = arena_format(&p->arena, "%s/kept", support_folder(&p->arena));
    PartsKeep keep = {folder, 0, false}, resume = {folder, 1e9, true};
    int set, other;
    cr_expect_not(try_bake(p, 2, &resume, NULL, &error));
    cr_expect(strstr(error.text, "holds no light of all"), "%s", error.text);
    cr_assert(try_bake(p, 2, &keep, NULL, &error), "%s", error.text);
    int parts = p->report.parts;
    cr_assert(kept_find(folder, parts, &set, &error), "%s", error.text);
    cr_expect_eq(set, kept_last(folder));
    cr_expect_not(kept_find(folder, parts + 1, &other, &error));
    cr_expect(strstr(error.text, "(asked for: "), "%s", error.text);
    cr_expect_not(try_bake(day, 2, &resume, NULL, &error));
    cr_expect(strstr(error.text, "was made under"), "%s", error.text);
    // A newer set, of which the last file was never written, and what a killed program left.
    for (int i = 0; i + 1 < parts; i++)
        cr_assert(file_write(kept_file(folder, set + 1, i, parts, &p->arena), "x", 1, &error));
    cr_assert(file_write(
        arena_format(&p->arena, "%s.0.part", kept_file(folder, set + 1, parts - 1, parts, &p->arena)), "x", 1,
        &error));
    cr_assert(kept_find(folder, parts, &other, &error), "%s", error.text);
    cr_expect_eq(other, set);
    cr_assert(try_bake(p, 2, &resume, NULL, &error), "%s", error.text);
    cr_assert(file_write(kept_file(folder, set + 1, parts - 1, parts, &p->arena), "x", 1, &error));
    cr_expect_not(try_bake(p, 2, &resume, NULL, &error));
    cr_expect(strstr(error.text, kept_file(folder, set + 1, 0, parts, &p->arena)), "%s", error.text);
    kept_remove(folder, INT_MAX);
    cr_expect_neq(access(folder, F_OK), 0);
    end(p);
    end(day);
}
