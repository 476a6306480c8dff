// bench_walk.c - each way of culling along the automatic tour of each building.
#include <stddef.h>
#include <stdio.h>

#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/draw/view.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "engine/tour/tour.h"

typedef struct Sums {
    double polygons, cells, query, frame, portals, objects;
    int frames;
} Sums;

// A building, the tour of it, and the query and renderer that show it.
typedef struct Watch {
    LoadedScene scene;
    TourPath path;
    VisQuery *query;
    Mirrors *mirrors;  // or NULL
    WalkRenderer *renderer;
    int cell;  // of the last eye
} Watch;

// Draws one frame, and adds its times and counts to the sums, if there are any.
static bool draw(Watch *w, const TourFrame *at, const BenchArguments *a, Culling culling, Sums *sums,
                 Error *error) {
    Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, a->size[0], a->size[1]);
    Eye eye = walk_eye(&camera);
    w->cell = vis_locate(&w->scene.graph, at->eye, w->cell);
    double start = clock_seconds();
    VisResult v = vis_query(w->query, &eye, w->cell, NULL, culling);
    double asked = clock_seconds();
    const MirrorView *mirrors;
    int mirror_count = mirrors_look(w->mirrors, &camera, v.objects, v.object_count, NULL, culling, &mirrors);
    walk_renderer_mirrors(w->renderer, mirrors, mirror_count);
    if (!walk_renderer_draw(w->renderer, &camera, v.objects, v.object_count, a->look, error) ||
        !walk_renderer_finish_scene(w->renderer, error))
        return false;
    walk_renderer_finish();
    if (!sums) return true;
    sums->frame += clock_seconds() - start;
    sums->query += asked - start;
    sums->polygons += v.polygon_count;
    sums->cells += v.cell_count;
    sums->portals += v.portals_tested;
    sums->objects += v.objects_tested;
    sums->frames++;
    return true;
}

// Measures frames taken evenly over the tour, each after the frame before it in the tour, as a walk shows them: the contents of
// the caches after one frame affect the time of the next. The first frame, which has none before it, is drawn twice.
static bool measure_culling(Watch *w, const BenchArguments *a, Culling culling, Sums *out, Error *error) {
    *out = (Sums){0};
    int count = w->path.frame_count, taken = count < a->frames ? count : a->frames;
    w->cell = -1;
    for (int i = 0; i < taken; i++) {
        const TourFrame *at = &w->path.frames[(long)i * count / taken];
        const TourFrame *before = at > w->path.frames ? at - 1 : at;
        if (!draw(w, before, a, culling, NULL, error) || !draw(w, at, a, culling, out, error)) return false;
    }
    return true;
}

static bool bench_building(const char *file, const BenchArguments *a, GlContext *context, Arena *arena,
                           Error *error) {
    SceneOptions load = a->load;
    Watch watch = {.cell = -1};
    TourOptions options = tour_default_options();
    if (!app_load(file, &load, arena, &watch.scene, error) || !scene_has_walls(&watch.scene, error))
        return false;
    const CellGraph *graph = &watch.scene.graph;
    if (!tour_make(graph, "auto", &options, arena, &watch.path, error)) return false;
    watch.query = vis_query_new(graph, &watch.scene.forest, arena);
    watch.mirrors = mirrors_new(graph, &watch.scene.forest, arena);
    if (!gl_context_use(context, error)) return false;
    watch.renderer = walk_renderer_new(graph, arena, error);
    if (!watch.renderer) return false;
    bool good = true;
    for (int m = 0; m < QUERY_CULLINGS && good; m++) {
        Sums s;
        good = measure_culling(&watch, a, (Culling)m, &s, error);
        if (!good) break;
        double n = s.frames;
        printf("%s,%s,%d,%d,%.1f,%.2f,%.2f,%.3f,%.1f,%.1f\n", bench_name(file), CULLING_NAMES[m], s.frames,
               graph->polygon_count, s.polygons / n, s.cells / n, 1e6 * s.query / n, 1e3 * s.frame / n,
               s.portals / n, s.objects / n);
        fflush(stdout);
    }
    walk_renderer_free(watch.renderer);
    mirrors_free(watch.mirrors);
    return good;
}

static bool measure_walk(const BenchArguments *a, Error *error) {
    Arena arena = {0};
    GlContext *context = gl_context_open(&arena, error);
    bool good = context != NULL;
    if (good) {
        puts("building,method,frames,polygons_total,polygons_drawn_mean,cells_visible_mean,query_us_mean,"
             "frame_ms_mean,portals_tested_mean,objects_tested_mean");
    }
    for (int i = 0; i < a->file_count && good; i++) {
        Arena building = {0};
        good = bench_building(a->files[i], a, context, &building, error);
        arena_free(&building);
    }
    gl_context_close(context);
    arena_free(&arena);
    return good;
}

static const Option ROWS[] = {
    BENCH_SIZE("of the frames"),
    {.name = "look",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = BENCH_AT(look),
     .names = WALK_LOOK_NAMES,
     .name_count = WALK_FINE + 1,
     .help = "@ (default fast)"},
    {.name = "frames",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(frames),
     .low = 1,
     .high = 1000000,
     .help = "of the tour, evenly taken, each after the one before it, @ (default 200)"},
};

const Bench BENCH_WALK = {
    .name = "walk",
    .about =
        "each way of culling along the auto tour of each building: polygons drawn, cells seen, time of the "
        "query and of the whole frame",
    BENCH_OPTIONS(ROWS),
    .run = measure_walk,
};
