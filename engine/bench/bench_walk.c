// bench_walk.c - each way of culling along the automatic tour of each building.
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/bench/bench.h"
#include "engine/bench/peer_frames.h"
#include "engine/core/clock.h"
#include "engine/draw/view.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "engine/scene/light.h"
#include "engine/tour/tour.h"

typedef struct Sums {
    double polygons, cells, query, frame, portals, objects;
    double *each, *query_each;  // [frames] seconds
    int most;                   // polygons
    int frames;
} Sums;

// A building, the tour of it, and the query and renderer that show it.
typedef struct Watch {
    WalkScene scene;
    TourPath path;
    VisQuery *query;
    Mirrors *mirrors;  // or NULL
    WalkRenderer *renderer;
    Exposure exposure;
    int cell;  // of the last eye
} Watch;

// As a window does, the eye adapted to what is in view.
static void expose(Watch *w, const Camera *camera, const VisResult *v) {
    const LitLight *light = walk_renderer_lit(w->renderer);
    if (!light) return;
    double seen = exposure_meter(walk_renderer_mesh(w->renderer), light, camera, v->objects, v->object_count);
    exposure_adapt(&w->exposure, seen, light->level, 1);
    walk_renderer_plain(w->renderer, gl_is_software());
    walk_renderer_tone(w->renderer, exposure_scale(&w->exposure), FALSE_COLOUR_OFF);
}

static Camera camera_of(const TourFrame *at, const BenchArguments *a) {
    return camera_look(at->eye, at->yaw, at->pitch, at->fov, a->size[0], a->size[1]);
}

// Draws the objects in view, which took `query` seconds to find.
static bool draw(Watch *w, const Camera *camera, const BenchArguments *a, const VisResult *v, Culling culling,
                 double query, Sums *sums, Error *error) {
    double start = clock_seconds();
    const MirrorView *mirrors;
    int mirror_count = mirrors_look(w->mirrors, camera, v, NULL, culling, &mirrors);
    walk_renderer_mirrors(w->renderer, mirrors, mirror_count);
    expose(w, camera, v);
    if (!walk_renderer_draw(w->renderer, camera, v->objects, v->object_count, a->look, error) ||
        !walk_renderer_finish_scene(w->renderer, error))
        return false;
    walk_renderer_finish();
    double frame = query + clock_seconds() - start;
    sums->query_each[sums->frames] = query;
    sums->each[sums->frames++] = frame;
    sums->frame += frame;
    sums->query += query;
    sums->polygons += v->polygon_count;
    if (v->polygon_count > sums->most) sums->most = v->polygon_count;
    sums->cells += v->cell_count;
    sums->portals += v->portals_tested;
    sums->objects += v->objects_tested;
    return true;
}

static bool query_and_draw(Watch *w, const TourFrame *at, const BenchArguments *a, Culling culling,
                           Sums *sums, Error *error) {
    Camera camera = camera_of(at, a);
    Eye eye = walk_eye(&camera);
    w->cell = vis_locate(w->scene.graph, at->eye, w->cell);
    double start = clock_seconds();
    VisResult v = vis_query(w->query, &eye, w->cell, NULL, culling);
    return draw(w, &camera, a, &v, culling, clock_seconds() - start, sums, error);
}

static int frames_taken(const Watch *w, const BenchArguments *a) {
    return w->path.frame_count < a->frames ? w->path.frame_count : a->frames;
}

// The frame `index` of those taken evenly over the tour.
static const TourFrame *frame_taken(const Watch *w, const BenchArguments *a, int index) {
    return &w->path.frames[(long)index * w->path.frame_count / frames_taken(w, a)];
}

static Sums new_sums(int frames, Arena *arena) {
    return (Sums){.each = ARENA_ARRAY(arena, double, frames + 1),
                  .query_each = ARENA_ARRAY(arena, double, frames + 1)};
}

// Measures frames taken evenly over the tour, each after the frame before it in the tour, as a walk shows them: the contents of
// the caches after one frame affect the time of the next. The first frame, which has none before it, is drawn twice.
static bool measure_culling(Watch *w, const BenchArguments *a, Culling culling, Arena *arena, Sums *out,
                            Error *error) {
    int taken = frames_taken(w, a);
    *out = new_sums(taken, arena);
    w->cell = -1;
    for (int i = 0; i < taken; i++) {
        const TourFrame *at = frame_taken(w, a, i), *before = at > w->path.frames ? at - 1 : at;
        Sums passed_over = new_sums(1, arena);
        if (!query_and_draw(w, before, a, culling, &passed_over, error) ||
            !query_and_draw(w, at, a, culling, out, error))
            return false;
    }
    return true;
}

// The same frames by an occlusion culler of others.
static bool measure_peer(Watch *w, const BenchArguments *a, Arena *arena, Sums *out, Error *error) {
    const CellGraph *graph = w->scene.graph;
    int taken = frames_taken(w, a);
    *out = new_sums(taken, arena);
    Camera *cameras = ARENA_ARRAY(arena, Camera, taken + 1);
    PeerFrame *answers = ARENA_ARRAY(arena, PeerFrame, taken + 1);
    for (int i = 0; i < taken; i++) cameras[i] = camera_of(frame_taken(w, a, i), a);
    if (!peer_frames(a->peer, graph, cameras, taken, arena, answers, error)) return false;
    for (int i = 0; i < taken; i++) {
        VisResult v = {.objects = answers[i].objects, .object_count = answers[i].object_count};
        for (int k = 0; k < v.object_count; k++)
            v.polygon_count += graph->objects[v.objects[k]].polygon_count;
        if (!draw(w, &cameras[i], a, &v, CULL_NONE, answers[i].seconds, out, error)) return false;
    }
    return true;
}

static int by_time(const void *p, const void *q) {
    const double *a = p, *b = q;
    return (*a > *b) - (*a < *b);
}

// The time that so many frames of 100 stay below, seconds.
static double slowest(double *each, int frames, int percent) {
    qsort(each, (size_t)frames, sizeof *each, by_time);
    return each[(percent * frames + 99) / 100 - 1];
}

static bool load_building(const char *file, const BenchArguments *a, Arena *arena, Watch *out, Error *error) {
    SceneOptions load = a->load;
    load.find_light = a->look == WALK_BAKED;
    load.fill_lamps = load.find_light ? FILL_LAMPS_ON : FILL_LAMPS_OFF;
    load.lamps = load.find_light ? SCENE_LAMPS_IF_LIT : SCENE_LAMPS_NONE;
    bool good = walk_scene_load(&load, file, arena, &out->scene, error);
    app_progress_end();
    if (good && load.find_light && !out->scene.light)
        return error_set(error, "%s: there is no light to show (enfilade bake, then --light FILE.rad)", file);
    return good;
}

static void print_row(const char *file, const char *method, const CellGraph *graph, Sums *s) {
    double n = s->frames;
    printf("%s,%s,%d,%d,%.1f,%.2f,%.2f,%.3f,%.3f,%.1f,%.1f,%d,%.2f\n", bench_name(file), method, s->frames,
           graph->polygon_count, s->polygons / n, s->cells / n, 1e6 * s->query / n, 1e3 * s->frame / n,
           1e3 * slowest(s->each, s->frames, 99), s->portals / n, s->objects / n, s->most,
           1e6 * slowest(s->query_each, s->frames, 95));
    fflush(stdout);
}

static bool bench_building(const char *file, const BenchArguments *a, GlContext *context, Arena *arena,
                           Error *error) {
    Watch watch = {.cell = -1};
    TourOptions options = tour_default_options();
    if (!load_building(file, a, arena, &watch, error) || !scene_has_walls(watch.scene.scene, error))
        return false;
    const CellGraph *graph = watch.scene.graph;
    if (!tour_make(graph, "auto", &options, arena, &watch.path, error)) return false;
    watch.query = vis_query_new(graph, watch.scene.forest, arena);
    watch.mirrors = mirrors_new(graph, watch.scene.forest, arena);
    if (!gl_context_use(context, error)) return false;
    watch.renderer = walk_renderer_new(graph, arena, error);
    if (!watch.renderer) return false;
    bool good = a->look != WALK_BAKED || walk_renderer_light(watch.renderer, watch.scene.light, arena, error);
    Sums sums;
    for (int m = 0; m < QUERY_CULLINGS && good; m++) {
        good = measure_culling(&watch, a, (Culling)m, arena, &sums, error);
        if (good) print_row(file, CULLING_NAMES[m], graph, &sums);
    }
    if (good && a->peer) {
        good = measure_peer(&watch, a, arena, &sums, error);
        if (good) print_row(file, "peer", graph, &sums);
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
             "frame_ms_mean,frame_ms_p99,portals_tested_mean,objects_tested_mean,polygons_drawn_most,query_"
             "us_p95");
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
     .name_count = WALK_LOOKS,
     .help = "@ (default fast)"},
    {.name = "light",
     .value = "FILE.rad",
     .type = OPTION_TEXT,
     .at = BENCH_AT(load.light),
     .help = "the light of the look baked, as `enfilade walk` has it (default: what is stored)"},
    {.name = "frames",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(frames),
     .low = 1,
     .high = 1000000,
     .help = "of the tour, evenly taken, each after the one before it, @ (default 200)"},
    {.name = "peer",
     .value = "PROGRAM",
     .type = OPTION_TEXT,
     .at = BENCH_AT(peer),
     .help = "a row for an external occlusion culler, which is told the building and the frames in a file "
             "(engine/bench/peer_frames.h)"},
};

const Bench BENCH_WALK = {
    .name = "walk",
    .about =
        "each way of culling along the auto tour of each building: polygons drawn, cells seen, time of the "
        "query and of the whole frame, in the mean and the slowest of a hundred",
    BENCH_OPTIONS(ROWS),
    .run = measure_walk,
};
