// test_bake_parts.c - light that is found in parts of a building, side by side, is that of the whole.
#include <criterion/criterion.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/scene/bake_parts.h"
#include "engine/scene/kept_parts.h"
#include "engine/scene/light.h"
#include "engine/scene/light_parts.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/shown.h"
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
    Parted *p = load("build/maps/house.plan", day, 0.75, 1e-5);
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
    PartsKeep keep = {folder, 0, false, NULL, NULL};
    Stop stop = {-1, 0};
    Progress progress = {count_down, &stop};
    bake(whole, cells, 0);
    cr_assert(try_bake(parted, cells, &keep, &progress, &error), "%s", error.text);
    expect_same(whole, parted, "kept all along");
    cr_assert(parted->report.kept >= 1 && parted->report.parts > 1, "kept %d times", parted->report.kept);
    const int reports = stop.count, tries = support_count(4, 40);
    int resumed = 0;
    for (int i = 1; i <= tries; i++) {
        kept_remove(folder, INT_MAX, 0);
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
    kept_remove(folder, INT_MAX, 0);
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
    PartsKeep keep = {folder, 0, false, NULL, NULL}, resume = {folder, 1e9, true, NULL, NULL};
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
    kept_remove(folder, INT_MAX, 0);
    cr_expect_neq(access(folder, F_OK), 0);
    end(p);
    end(day);
}

// ---- light that stays apart

// The light that is shown on a polygon, the mean over its area, of all channels, W/m^2; below 0: the mesh has no such polygon.
static double shown_on(const WalkLight *light, const Nodes *nodes, int polygon) {
    const Mesh *mesh = light->mesh;
    int f = mesh->face_of[polygon];
    double sum = 0, area = 0;
    if (f < 0) return -1;
    const Face *face = &mesh->faces[f];
    for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
        const Element *element = &mesh->elements[e];
        double mean = 0;
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++)
            mean += rgb_sum(light->solution->node[nodes->of_corner[c]]) / element->corner_count;
        sum += mean * element->area;
        area += element->area;
    }
    return sum / area;
}

// A polygon that is seen from a part has its light there.
static void compare_part(const Parted *p, const LightOfParts *of, int part, const WalkLight *whole,
                         const Nodes *nodes, double mean, int *compared, int *same, int *far, double *worst) {
    Arena arena = {0};
    Error error = {""};
    WalkLight light;
    cr_assert(light_load_part(of, part, &arena, &light, &error), "%s", error.text);
    Nodes own = nodes_of(light.mesh, &arena);
    const CellGraph *graph = &p->scene.graph;
    for (int c = 0; c < graph->cell_count; c++) {
        if (light_part_of(of, c) != part) continue;
        for (int other = 0; other < graph->cell_count; other++) {
            if (!cell_rows_has(&p->scene.forest.seen, c, other)) continue;
            for (int o = graph->surface_first[other]; o < graph->surface_first[other + 1]; o++) {
                for (int i = 0; i < graph->objects[o].polygon_count; i++) {
                    int polygon = graph->objects[o].first_polygon + i;
                    double there = shown_on(whole, nodes, polygon), here = shown_on(&light, &own, polygon);
                    cr_assert(there < 0 || here >= 0, "polygon %d is not in part %d", polygon, part);
                    if (there < 0) continue;
                    *far += fabs(here - there) > 0.02 * mean;
                    *worst = fmax(*worst, fabs(here - there) / mean);
                    *same += fabs(here - there) <= 1e-12 * mean;
                    (*compared)++;
                }
            }
        }
    }
    arena_free(&arena);
}

// Proves that light which stays apart is the light that is joined, wherever it is seen: each part, read back, has every surface that its
// cells may see, with the same light in the mean. Corners that only one of two meshes has, where a neighbour that is not seen from the
// part is cut otherwise, are linear in one and found in the other. No part of an element may be off by more than 6 % of its light there
// (bends.c), and a surface has few such corners: its mean is within a third of that. Only at an edge of a face, where light falls steeply,
// may such a corner be off by as much as the light is there: less than one surface in a thousand has one.
Test(parts, light_that_stays_apart_is_the_same) {
    Parted *joined = load("build/maps/house.plan", true, 0.6, 1e-3),
           *p = load("build/maps/house.plan", true, 0.6, 1e-3);
    Error error = {""};
    const char *folder = support_folder(&p->arena), *path = arena_format(&p->arena, "%s/house.rad", folder);
    PartsKeep keep = {kept_folder(path, &p->arena), 1e9, false, path, NULL};
    bake(joined, 30, 0);
    const Mesh *shown;
    const RadSolution *light;
    cr_assert(
        shown_light(&joined->mesh, &joined->light, joined->doors, &joined->arena, &shown, &light, &error));
    WalkLight whole = {.mesh = shown, .solution = light};
    Nodes nodes = nodes_of(shown, &joined->arena);
    double mean = 0, worst = 0;
    for (int n = 0; n < nodes.count; n++) mean += rgb_sum(light->node[n]) / nodes.count;
    cr_assert(try_bake(p, 30, &keep, NULL, &error), "%s", error.text);
    cr_expect_geq(p->report.parts, 3);
    cr_expect_eq(p->report.elements, joined->mesh.element_count);
    cr_expect_eq(p->report.power.shots, joined->light.shots);
    p->scene.lights[0] = path;
    p->scene.light_count = 1;
    const LightOfParts *of;
    cr_assert(light_find_parts(&p->scene, &p->arena, &of, &error), "%s", error.text);
    cr_assert(of);
    int compared = 0, same = 0, far = 0;
    for (int part = 0; part < p->report.parts; part++)
        compare_part(p, of, part, &whole, &nodes, mean, &compared, &same, &far, &worst);
    printf("%d surfaces compared, %d the same, %d are far, at worst %.3g %% of the mean off\n", compared,
           same, far, 100 * worst);
    cr_expect_gt(compared, 1000);
    cr_expect_geq(same, 0.95 * compared);
    cr_expect_leq(far, compared / 1000);
    // There is nothing to go on from; and what does not fit is told.
    PartsKeep resume = keep;
    resume.resume = true;
    cr_expect_not(try_bake(p, 30, &resume, NULL, &error));
    cr_expect(strstr(error.text, "its light is whole"), "%s", error.text);
    WalkLight none;
    cr_expect_not(light_load(path, &p->scene, &p->arena, &none, &error));
    cr_expect(strstr(error.text, "is light in parts"), "%s", error.text);
    int set;
    cr_assert(kept_find(keep.folder, p->report.parts, &set, &error));
    unlink(kept_file(keep.folder, set, 1, p->report.parts, &p->arena));
    cr_expect_not(light_load_part(of, 1, &p->arena, &none, &error));
    cr_expect(strstr(error.text, "-1-of-"), "%s", error.text);
    end(joined);
    end(p);
}

// Proves that it does not depend on the number of threads, nor on how little memory there is; that a bake anew leaves one set of files,
// and one that is stopped the earlier light; and that damaged files are refused.
Test(parts, light_that_stays_apart_is_whole_or_as_before) {
    Parted *p = load("build/maps/two-rooms.plan", false, 0.5, 1e-2);
    Error error = {""};
    const char *folder = support_folder(&p->arena), *path = arena_format(&p->arena, "%s/two.rad", folder);
    PartsKeep keep = {kept_folder(path, &p->arena), 1e9, false, path, NULL};
    LightParts first, second;
    Bytes before[2], after[2];
    p->options.rad.threads = 1;
    cr_assert(try_bake(p, 2, &keep, NULL, &error), "%s", error.text);
    cr_assert(light_parts_load(path, &p->scene.building, &first, &error), "%s", error.text);
    for (int i = 0; i < 2; i++)
        cr_assert(file_read(kept_file(keep.folder, first.set, i, first.parts, &p->arena), 1 << 30, &p->arena,
                            &before[i], &error));
    Stop stop = {3, 0};
    Progress progress = {count_down, &stop};
    PartsKeep often = keep;
    often.seconds = 0;
    cr_expect_not(try_bake(p, 2, &often, &progress, &error));
    cr_assert(light_parts_load(path, &p->scene.building, &second, &error), "%s", error.text);
    cr_expect_eq(second.set, first.set);
    cr_expect_eq(access(kept_file(keep.folder, first.set, 0, first.parts, &p->arena), R_OK), 0);
    MemoryBudget budget = {
        .file = "test", .remedy = "none", .base = memory_used() + ((size_t)200 << 20), .most = SIZE_MAX};
    memory_set_budget(&budget);
    p->options.rad.threads = 3;
    cr_assert(try_bake(p, 2, &keep, NULL, &error), "%s", error.text);
    memory_set_budget(NULL);
    cr_assert(light_parts_load(path, &p->scene.building, &second, &error), "%s", error.text);
    cr_expect_gt(second.set, first.set);
    cr_expect_neq(access(kept_file(keep.folder, first.set, 0, first.parts, &p->arena), F_OK), 0);
    for (int i = 0; i < 2; i++) {
        cr_assert(file_read(kept_file(keep.folder, second.set, i, second.parts, &p->arena), 1 << 30,
                            &p->arena, &after[i], &error));
        cr_expect(after[i].size == before[i].size &&
                      memcmp(after[i].data, before[i].data, after[i].size) == 0,
                  "part %d", i);
    }
    Bytes small;
    cr_assert(file_read(path, 1 << 20, &p->arena, &small, &error));
    for (size_t at = 8; at < small.size; at++) {
        LightParts out;
        unsigned char was = small.data[at];
        small.data[at] = (unsigned char)(was ^ 0x11);
        cr_assert(file_write(path, small.data, small.size, &error));
        cr_expect_not(light_parts_load(path, &p->scene.building, &out, &error), "byte %zu", at);
        small.data[at] = was;
        cr_assert(file_write(path, small.data, at, &error));
        cr_expect_not(light_parts_load(path, &p->scene.building, &out, &error), "cut at %zu", at);
    }
    end(p);
}
