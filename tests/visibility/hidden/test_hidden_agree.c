// test_hidden_agree.c - all hidden-surface methods see the same: the reference is one ray a pixel in world space
// (ray_scene.h), which shares with them what polygons there are and nothing else.
#include <criterion/criterion.h>
#include <stdio.h>

#include "maps/maps.h"
#include "tests/support/oracles/hidden_excuse.h"
#include "tests/support/oracles/hidden_scenes.h"
#include "tests/support/oracles/ray_scene.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"

// How exactly a method tells things apart: one of our own; one in floats, whose edges lie on a grid of 1/256 pixel (OpenGL), or which
// takes any of those that tie (Embree).
static const HiddenSlack EXACT = {1e-6, 1e-9, 1.1 * HIDDEN_EDGE_ON, true};
static const HiddenSlack FLOAT = {1 / 128.0, 1e-5, 1e-5, false};
// Depths that must be the same: a float's rounding, a hundred times over for planes seen at a grazing angle by floats; places
// in a building in floats, metres.
static const double EXACT_DEPTH = 3e-7, FLOAT_DEPTH = 1e-4, FLOAT_PLACE = 5e-6;

typedef struct Tally {
    long pixels, excused[HIDDEN_EXCUSES], wrong, wrong_depths;
} Tally;

// Are two depths of a polygon the same, seen from `height` metres off its plane? The effect of rounding grows as that shrinks.
static bool same_depth(float a, float b, double height, bool exact) {
    double share = exact ? EXACT_DEPTH : FLOAT_DEPTH + FLOAT_PLACE / height;
    return a == b || (double)fabsf(a - b) <= share * (double)fabsf(b);
}

static void compare(const HiddenJudge *judge, const Camera *camera, const ItemBuffer *want,
                    const ItemBuffer *got, bool exact, const char *what, Tally *tally) {
    for (int p = 0; p < camera->width * camera->height; p++) {
        tally->pixels++;
        int i = p % camera->width, j = p / camera->width, a = want->item[p], b = got->item[p];
        if (a == b) {
            tally->wrong_depths +=
                a >= 0 && !same_depth(got->depth[p], want->depth[p], hidden_height(judge, camera, a), exact);
            continue;
        }
        HiddenExcuse excuse = hidden_excuse(judge, camera, i, j, a, b, exact ? EXACT : FLOAT);
        tally->excused[excuse]++;
        if (excuse != EXCUSE_NONE) continue;
        if (tally->wrong++ < 3)
            fprintf(stderr,
                    "%s: pixel (%d, %d) of %d x %d sees polygon %d at %.9g, the reference %d at %.9g\n", what,
                    i, j, camera->width, camera->height, b, (double)got->depth[p], a, (double)want->depth[p]);
    }
}

static void look(const RayScene *rays, const Camera *camera, ItemBuffer *out) {
    for (int p = 0; p < camera->width * camera->height; p++) {
        Vec3 ray = camera_ray(camera, p % camera->width + 0.5, p / camera->width + 0.5);
        out->item[p] = ray_scene_nearest(rays, camera->eye, ray, &out->depth[p]);
    }
}

enum { MOST_METHODS = 16 };

// All methods but those that guess on some views of a scene; `floats`: it is one for floats.
static void compare_scene(const Scene *scene, const Camera *cameras, int count, bool floats, const char *what,
                          Tally tally[MOST_METHODS]) {
    Arena arena = {0};
    Error error;
    RayScene *rays = ray_scene_new(scene, &arena, &error);
    cr_assert(rays, "%s: %s", what, error.text);
    HiddenJudge *judge = hidden_judge_new(scene, &arena);
    ItemBuffer *want = ARENA_ARRAY(&arena, ItemBuffer, count);
    for (int k = 0; k < count; k++) {
        want[k] = item_buffer_new(&arena, cameras[k].width, cameras[k].height);
        look(rays, &cameras[k], &want[k]);
    }
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        const HiddenMethod *method = HIDDEN_METHODS[m];
        bool exact = method->truth == HIDDEN_EXACT;
        if (method->truth == HIDDEN_GUESS || (!exact && !floats)) continue;
        void *prepared = method->begin(scene, &arena, &error);
        cr_assert(prepared, "%s: %s", method->name, error.text);
        for (int k = 0; k < count; k++) {
            ItemBuffer got = item_buffer_new(&arena, cameras[k].width, cameras[k].height);
            HiddenWork work;
            cr_assert(hidden_draw(method, prepared, &cameras[k], &got, &work, &error), "%s", error.text);
            char name[160];
            snprintf(name, sizeof name, "%s, %s, view %d", method->name, what, k);
            compare(judge, &cameras[k], &want[k], &got, exact, name, &tally[m]);
        }
        if (method->end) method->end(prepared);
    }
    arena_free(&arena);
}

// So many of a method's pixels may be excluded: a sample of a picture rarely lies on an edge to a millionth.
static const double EXACT_EXCLUDED = 1e-5, FLOAT_EXCLUDED = 0.05;

static void report(const char *what, const Tally tally[MOST_METHODS]) {
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        const Tally *t = &tally[m];
        if (t->pixels == 0) continue;
        double most_excused = HIDDEN_METHODS[m]->truth == HIDDEN_EXACT ? EXACT_EXCLUDED : FLOAT_EXCLUDED;
        // Embree takes any of several copies.
        long excused = t->excused[EXCUSE_EDGE] + t->excused[EXCUSE_CROSSING] +
                       (HIDDEN_METHODS[m]->truth == HIDDEN_EXACT ? t->excused[EXCUSE_TIE] : 0);
        cr_log_info("%-9s %-14s %ld pixels, excluded: %ld at edges, %ld at crossings, %ld ties; wrong: %ld, "
                    "depths %ld",
                    what, HIDDEN_METHODS[m]->name, t->pixels, t->excused[EXCUSE_EDGE],
                    t->excused[EXCUSE_CROSSING], t->excused[EXCUSE_TIE], t->wrong, t->wrong_depths);
        cr_expect(t->wrong == 0 && t->wrong_depths == 0 &&
                      (double)excused <= most_excused * (double)t->pixels,
                  "%s on scenes %s: of %ld pixels %ld differ, %ld more within the slack, %ld depths differ",
                  HIDDEN_METHODS[m]->name, what, t->pixels, t->wrong, excused, t->wrong_depths);
    }
}

// On generated scenes of every kind all exact methods give the reference's item buffer and depths, but for pixels within
// 1e-6 of an edge or a line of intersection, or where depths tie within 1e-9: 770 views. Embree and OSMesa do within a 128th of
// a pixel and the rounding of floats, on those that floats hold.
Test(hidden_agree, generated_scenes, .timeout = 600) {
    for (int kind = 0; kind < SCENE_KINDS; kind++) {
        uint64_t seed = 100 + (uint64_t)kind;
        Random random = {seed};
        Tally tally[MOST_METHODS] = {{0}};
        // Floats do not hold these.
        bool fine = kind == SCENE_EDGE_ON || kind == SCENE_HUGE || kind == SCENE_CLOSE || kind == SCENE_MIXED;
        for (int trial = 0; trial < support_count(35, 350); trial++) {
            Arena arena = {0};
            Vec3 eye = trial % 3 == 2 ? vec3(8e3, -6e3, 100) : vec3(0.1, 0.2, 0.3);
            HiddenSoup soup =
                hidden_soup_new(&arena, &random, (HiddenKind)kind, eye, 1 + random_index(&random, 60));
            int *list = ARENA_ARRAY(&arena, int, soup.polygon_count);
            // Backwards: the list's order decides, not the index.
            for (int i = 0; i < soup.polygon_count; i++) list[i] = soup.polygon_count - 1 - i;
            Scene scene = {soup.polygons, soup.vertices, trial % 2 ? list : NULL, soup.polygon_count};
            Camera cameras[2];
            for (int k = 0; k < 2; k++)
                cameras[k] = hidden_camera(&random, eye, 20 + random_index(&random, 60),
                                           10 + random_index(&random, 50));
            char what[80];
            snprintf(what, sizeof what, "%s, seed %lu, trial %d", HIDDEN_KIND_NAMES[kind],
                     (unsigned long)seed, trial);
            compare_scene(&scene, cameras, 2, !fine && trial % 3 == 0, what, tally);
            arena_free(&arena);
        }
        report(HIDDEN_KIND_NAMES[kind], tally);
    }
}

static void compare_building(const char *path, int views, uint64_t seed, Tally tally[MOST_METHODS]) {
    Arena arena = {0};
    Error error;
    Building building;
    CellGraph graph;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, &arena, &building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&building, &options, &arena, &graph, &error), "%s", error.text);
    Scene scene = {graph.polygons, graph.vertices, NULL, graph.polygon_count};
    Random random = {seed};
    Camera *cameras = ARENA_ARRAY(&arena, Camera, views);
    for (int k = 0; k < views; k++)
        cameras[k] = hidden_camera(
            &random, soup_fixture_point(&graph, &random, random_index(&random, graph.cell_count)), 48, 36);
    char what[200];
    snprintf(what, sizeof what, "%s, seed %lu", path, (unsigned long)seed);
    compare_scene(&scene, cameras, views, true, what, tally);
    arena_free(&arena);
}

// The same from random places in the sample buildings, of which all polygons are drawn: 300 views.
Test(hidden_agree, buildings, .timeout = 600) {
    static const char *const NAMES[] = {"two-rooms", "house", "office", "office-plain"};
    for (int b = 0; b < 4; b++) {
        char path[80];
        snprintf(path, sizeof path, "build/maps/%s.plan", NAMES[b]);
        Tally tally[MOST_METHODS] = {{0}};
        compare_building(path, support_count(75, 1000), 200 + (uint64_t)b, tally);
        report(NAMES[b], tally);
    }
}
