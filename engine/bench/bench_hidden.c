// bench_hidden.c - hidden-surface methods side by side: the table of T. Nishita's lecture on hidden-surface removal (100, 2,500
// and 60,000 polygons) at a fixed depth complexity, what depth complexity and resolution cost, small triangles, and
// real buildings, culled and not.
//
// Times are of one thread, the least of several draws of each view, and their mean over the views; preparing a scene is told
// apart. What differs from the ray caster's picture is counted.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/bench/bench_hidden_scenes.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"

static const char HEAD[] =
    "table,scene,polygons,depth_complexity,width,height,method,prepare_ms,ms,wrong_share,"
    "memory_kb,set_up,edges,comparisons,splits,pixels,depth_tests,nodes,rays,undecided\n";

// A view is drawn until it took so long, or so often.
static const double VIEW_SECONDS = 0.03;
enum { VIEW_DRAWS = 30, MOST_METHODS = 16 };

// Of a method on the views of a scene; sums over the views.
typedef struct Run {
    double prepare_seconds, seconds;
    int prepared;  // scenes
    long wrong;
    HiddenWork work;
} Run;

typedef struct HiddenBench {
    const BenchArguments *arguments;
    const char *table, *scene;
    const HiddenViews *views;
    ItemBuffer *right;  // [views->count] by the ray caster
    Text *csv;
    Run runs[MOST_METHODS];  // the last table's
} HiddenBench;

static void add_work(HiddenWork *sum, const HiddenWork *w) {
    sum->polygons += w->polygons, sum->edges += w->edges, sum->comparisons += w->comparisons;
    sum->splits += w->splits, sum->pixels += w->pixels, sum->depth_tests += w->depth_tests;
    sum->nodes += w->nodes, sum->rays += w->rays, sum->undecided += w->undecided;
    if (w->memory > sum->memory) sum->memory = w->memory;
}

static bool draw_view(const HiddenMethod *method, void *prepared, const HiddenView *view, ItemBuffer *out,
                      Run *run, Error *error) {
    HiddenWork work;
    double least = INFINITY, spent = 0;
    for (int i = 0; i < VIEW_DRAWS && (i == 0 || spent < VIEW_SECONDS); i++) {
        double start = clock_thread_seconds();
        if (!hidden_draw(method, prepared, &view->camera, out, &work, error)) return false;
        double taken = clock_thread_seconds() - start;
        least = taken < least ? taken : least;
        spent += taken;
    }
    run->seconds += least;
    add_work(&run->work, &work);
    return true;
}

// Draws all views; keeps the pictures in `keep` (NULL: compares them with those kept).
static bool run_method(HiddenBench *b, const HiddenMethod *method, ItemBuffer *keep, Run *run, Error *error) {
    Arena arena = {0}, picture = {0};
    void *prepared = NULL;
    bool good = true;
    *run = (Run){0};
    for (int i = 0; i < b->views->count && good; i++) {
        const HiddenView *view = &b->views->views[i];
        if (!view->same) {
            if (prepared && method->end) method->end(prepared);
            arena_reset(&arena);
            double start = clock_thread_seconds();
            prepared = method->begin(&view->scene, &arena, error);
            run->prepare_seconds += clock_thread_seconds() - start;
            run->prepared++;
        }
        arena_reset(&picture);
        ItemBuffer own = keep ? keep[i] : item_buffer_new(&picture, view->camera.width, view->camera.height);
        good = prepared && draw_view(method, prepared, view, &own, run, error);
        for (int p = 0; !keep && good && p < own.width * own.height; p++)
            run->wrong += own.item[p] != b->right[i].item[p];
    }
    if (prepared && method->end) method->end(prepared);
    arena_free(&arena);
    arena_free(&picture);
    return good;
}

static void add_hidden_row(HiddenBench *b, const char *method, const Run *run, double depth) {
    size_t before = b->csv->size;
    const Camera *camera = &b->views->views[0].camera;
    int n = b->views->count;
    double pixels = (double)camera->width * camera->height * n, polygons = 0;
    for (int i = 0; i < n; i++) polygons += (double)b->views->views[i].scene.count / n;
    const HiddenWork *w = &run->work;
    text_append(b->csv, "%s,%s,%.0f,%.2f,%d,%d,%s,%.4f,%.4f,%.6f,%.0f,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld\n",
                b->table, b->scene, polygons, depth, camera->width, camera->height, method,
                1e3 * run->prepare_seconds / run->prepared, 1e3 * run->seconds / n,
                (double)run->wrong / pixels, (double)w->memory / 1024, w->polygons / n, w->edges / n,
                w->comparisons / n, w->splits / n, w->pixels / n, w->depth_tests / n, w->nodes / n,
                w->rays / n, w->undecided / n);
    fputs(b->csv->data + before, stdout);
    fflush(stdout);
}

// All methods on the views: a row each.
static bool bench_views(HiddenBench *b, const char *table, const char *scene, const HiddenViews *views,
                        Error *error) {
    Arena arena = {0};
    b->table = table;
    b->scene = scene;
    b->views = views;
    b->right = ARENA_ARRAY(&arena, ItemBuffer, views->count);
    for (int i = 0; i < views->count; i++)
        b->right[i] = item_buffer_new(&arena, views->views[i].camera.width, views->views[i].camera.height);
    // The depth buffer tries each polygon at each of its pixels: so many lie there, one behind the other.
    Run first;
    bool good = run_method(b, hidden_find("raycast"), b->right, &first, error) &&
                run_method(b, hidden_find("zbuffer"), NULL, &first, error);
    const Camera *camera = &views->views[0].camera;
    double depth = (double)first.work.depth_tests / views->count / camera->width / camera->height;
    for (int m = 0; HIDDEN_METHODS[m] && good; m++) {
        CORE_ASSERT(m < MOST_METHODS);
        b->runs[m] = (Run){0};
        if (!bench_listed(b->arguments->methods, HIDDEN_METHODS[m]->name)) continue;
        good = run_method(b, HIDDEN_METHODS[m], NULL, &b->runs[m], error);
        if (good) add_hidden_row(b, HIDDEN_METHODS[m]->name, &b->runs[m], depth);
    }
    arena_free(&arena);
    return good;
}

static const Run *run_of(const HiddenBench *b, const char *name) {
    for (int m = 0; HIDDEN_METHODS[m]; m++)
        if (strcmp(HIDDEN_METHODS[m]->name, name) == 0) return &b->runs[m];
    return NULL;
}

static void print_ratio(const HiddenBench *b, const char *method, const char *to) {
    const Run *p = run_of(b, method), *q = run_of(b, to);
    if (p->seconds > 0 && q->seconds > 0)
        fprintf(stderr, "%s %s: %s takes %.3f ms, %s %.3f ms: %.2f times as much\n", b->table, b->scene,
                method, 1e3 * p->seconds / b->views->count, to, 1e3 * q->seconds / b->views->count,
                q->seconds / p->seconds);
}

// ---- tables

static bool bench_random(HiddenBench *b, const char *table, int polygons, double depth, int size, int scenes,
                         Error *error) {
    Arena arena = {0};
    HiddenViews views = hidden_views_random(polygons, depth, size, size, scenes, b->arguments->seed, &arena);
    bool good = bench_views(b, table, "random", &views, error);
    arena_free(&arena);
    return good;
}

// The lecture's counts, and some between them. Its times at 100, 2,500 and 60,000 polygons give these slopes.
static const int COUNTS[] = {100, 500, 2500, 12000, 60000};
enum { COUNT_STEPS = sizeof COUNTS / sizeof *COUNTS, FROM = 2, TO = COUNT_STEPS - 1 };
static const struct {
    const char *method;
    double slope;
} LECTURE[] = {{"depth-sort", 1.23}, {"zbuffer", 0}, {"scanline", 0.49}, {"warnock", 0.49}};

static const double DEPTH = 4;         // complexity, where it is not what changes
enum { SIZE = 512, POLYGONS = 2500 };  // alike

static double lecture_slope(const char *method) {
    for (size_t i = 0; i < sizeof LECTURE / sizeof *LECTURE; i++)
        if (strcmp(LECTURE[i].method, method) == 0) return LECTURE[i].slope;
    return NAN;
}

static bool bench_lecture(HiddenBench *b, Error *error) {
    double ms[COUNT_STEPS][MOST_METHODS] = {{0}};
    for (int i = 0; i < COUNT_STEPS; i++) {
        if (!bench_random(b, "polygons", COUNTS[i], DEPTH, SIZE, 3, error)) return false;
        for (int m = 0; HIDDEN_METHODS[m]; m++) ms[i][m] = 1e3 * b->runs[m].seconds / 3;
    }
    fprintf(stderr,
            "%-14s %9s %9s %9s ms at 100, 2,500, 60,000 polygons; slope from 2,500 on (the lecture's)\n", "",
            "", "", "");
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        if (!(ms[0][m] > 0)) continue;
        double slope = log(ms[TO][m] / ms[FROM][m]) / log((double)COUNTS[TO] / COUNTS[FROM]);
        fprintf(stderr, "%-14s %9.3f %9.3f %9.3f  %.2f (%.2f)\n", HIDDEN_METHODS[m]->name, ms[0][m],
                ms[FROM][m], ms[TO][m], slope, lecture_slope(HIDDEN_METHODS[m]->name));
    }
    return true;
}

static bool bench_own_scenes(const BenchArguments *a, Text *csv, Error *error) {
    HiddenBench b = {.arguments = a, .csv = csv};
    if (!bench_lecture(&b, error)) return false;
    for (double depth = 1; depth <= 16; depth *= 2)
        if (!bench_random(&b, "depth", POLYGONS, depth, SIZE, 3, error)) return false;
    for (int size = 64; size <= 1024; size *= 2)
        if (!bench_random(&b, "resolution", POLYGONS, DEPTH, size, 3, error)) return false;
    Arena arena = {0};
    HiddenViews views = hidden_views_triangles(20000, 128, 128, a->seed, &arena);
    bool good = bench_views(&b, "triangles", "2-20 pixels", &views, error);
    if (good) print_ratio(&b, "zbuffer", "osmesa");
    arena_free(&arena);
    return good;
}

static bool bench_building(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    enum { FRAMES = 20 };
    Arena arena = {0};
    HiddenBench b = {.arguments = a, .csv = csv};
    HiddenViews whole, culled;
    bool good = hidden_views_building(file, a, FRAMES, &arena, &whole, &culled, error) &&
                bench_views(&b, "unculled", bench_name(file), &whole, error);
    if (good) print_ratio(&b, "raycast", "embree");
    good = good && bench_views(&b, "culled", bench_name(file), &culled, error);
    arena_free(&arena);
    return good;
}

static bool is_hidden_method(const char *method) { return hidden_find(method) != NULL; }

static bool measure_hidden(const BenchArguments *a, Error *error) {
    // llvmpipe draws in the calling thread then, whose time is taken.
    setenv("LP_NUM_THREADS", "0", 1);
    return bench_table(a, HEAD, bench_own_scenes, bench_building, error);
}

static const Option ROWS[] = {
    BENCH_METHODS("some of the methods (default: all; `enfilade bake --help` lists them)"),
    BENCH_SIZE("of the pictures of FILE"),
    BENCH_SEED("of its own scenes"),
    BENCH_CSV,
};

const Bench BENCH_HIDDEN = {
    .name = "hidden",
    .about = "each hidden-surface method: time, memory and operations by polygons, depth complexity and "
             "resolution, in scenes of its own; in FILE along the auto tour, culled and not",
    BENCH_OPTIONS(ROWS),
    .run = measure_hidden,
    .is_method = is_hidden_method,
    .list = "bake",
};
