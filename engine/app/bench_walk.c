// bench_walk.c - each way of culling along the automatic tour of each building.
#include <stdio.h>

#include "engine/app/bench.h"
#include "engine/core/clock.h"
#include "engine/walk/tour.h"
#include "engine/walk/view.h"
#include "engine/walk/walk_renderer.h"
#include "visibility/hidden/gl_context.h"

typedef struct Sums {
    double polygons, cells, query, frame, portals, objects;
    int frames;
} Sums;

// Frames are taken as a walk shows them, one after the other in runs of so many, and the runs evenly over the tour: what
// the last frame left in the caches is part of what the next one costs.
enum { RUN = 10 };

static const TourFrame *frame_taken(const TourPath *path, int i, int taken) {
    long run = i / RUN, first = run * RUN * path->frame_count / taken;
    return &path->frames[first + i % RUN];
}

static bool measure(const AppScene *scene, const TourPath *path, const BenchArguments *a, VisMethod method,
                    VisQuery *query, WalkRenderer *renderer, Sums *out, Error *error) {
    *out = (Sums){0};
    int taken = path->frame_count < a->frames ? path->frame_count : a->frames, cell = -1;
    // The first frame once more before all: it pays for what is made on first use.
    for (int i = -1; i < taken; i++) {
        const TourFrame *at = frame_taken(path, i < 0 ? 0 : i, taken);
        Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, a->width, a->height);
        Eye eye = walk_eye(&camera);
        cell = vis_locate(&scene->graph, at->eye, cell);
        double start = clock_seconds();
        VisResult v = vis_query(query, &eye, cell, NULL, method);
        double asked = clock_seconds();
        if (!walk_renderer_draw(renderer, &camera, v.objects, v.object_count, a->look, error) ||
            !walk_renderer_finish_scene(renderer, error))
            return false;
        walk_renderer_finish();
        if (i < 0) continue;
        out->frame += clock_seconds() - start;
        out->query += asked - start;
        out->polygons += v.polygon_count;
        out->cells += v.cell_count;
        out->portals += v.portals_tested;
        out->objects += v.objects_tested;
        out->frames++;
    }
    return true;
}

static bool bench_building(const char *file, const BenchArguments *a, GlContext *context, Arena *arena,
                           Error *error) {
    AppOptions load = app_default_options();
    load.map = a->map;
    AppScene scene;
    TourOptions options = tour_default_options();
    TourPath path;
    if (!app_load(file, &load, arena, &scene, error) || !app_has_walls(&scene, error)) return false;
    if (!tour_make(&scene.graph, "auto", &options, arena, &path, error)) return false;
    VisQuery *query = vis_query_new(&scene.graph, &scene.forest, arena);
    if (!gl_context_use(context, error)) return false;
    WalkRenderer *renderer = walk_renderer_new(&scene.graph, arena, error);
    if (!renderer) return false;
    bool good = true;
    for (int m = 0; m < VIS_METHODS && good; m++) {
        Sums s;
        good = measure(&scene, &path, a, (VisMethod)m, query, renderer, &s, error);
        if (!good) break;
        double n = s.frames;
        printf("%s,%s,%d,%d,%.1f,%.2f,%.2f,%.3f,%.1f,%.1f\n", bench_name(file), VIS_METHOD_NAMES[m], s.frames,
               scene.graph.polygon_count, s.polygons / n, s.cells / n, 1e6 * s.query / n, 1e3 * s.frame / n,
               s.portals / n, s.objects / n);
        fflush(stdout);
    }
    walk_renderer_free(renderer);
    return good;
}

bool bench_walk(const BenchArguments *a, Error *error) {
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
