// bench_hidden.c - hidden-surface methods side by side: the table of T. Nishita's lecture on hidden-surface removal (100, 2,500
// and 60,000 polygons) at a fixed depth complexity, the time as depth complexity and as resolution grow, small triangles,
// and real buildings, culled and not.
//
// Times are of one thread, the least of several draws of each view, and their mean over the views; preparing a scene is told
// apart. The pixels that differ from the ray caster's picture are counted.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/random.h"
#include "engine/draw/view.h"
#include "engine/tour/tour.h"
#include "visibility/hidden/curved_scene.h"
#include "visibility/hidden/hidden.h"

typedef struct HiddenView {
    Scene scene;
    Camera camera;
    bool same;  // the scene of the view before it
} HiddenView;

typedef struct HiddenViews {
    HiddenView *views;
    int count;
} HiddenViews;

// Random polygons lie so far before the eye, metres; half the picture's extent at 1 m.
static const double NEAR = 4, FAR = 12, TAN = 0.5;

static Camera ahead(int width, int height) {
    Camera camera = camera_look(vec3(0, 0, 0), 0, 0, 2 * atan(TAN), width, height);
    camera.tan_y = TAN;
    return camera;
}

typedef struct Soup {
    Polygon *polygons;
    Vec3 *vertices;
    int count;
} Soup;

static Soup soup_new(Arena *arena, int polygons, int corners) {
    Soup soup = {ARENA_ARRAY(arena, Polygon, polygons), ARENA_ARRAY(arena, Vec3, polygons * corners),
                 polygons};
    for (int i = 0; i < polygons; i++) soup.polygons[i] = (Polygon){i * corners, corners, 0, 0};
    return soup;
}

static Vec3 direction(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), s = sqrt(1 - z * z);
    return vec3(s * cos(a), s * sin(a), z);
}

// Anywhere in the picture, at any of the depths.
static Vec3 somewhere(Random *random) {
    double x = random_between(random, NEAR, FAR);
    return vec3(x, x * TAN * random_between(random, -1, 1), x * TAN * random_between(random, -1, 1));
}

// A square of area 1 about the origin, turned any way.
static void random_square(Vec3 v[4], Random *random, Vec3 centre, double size) {
    Vec3 n = direction(random), u = vec3_normalize(vec3_cross(n, direction(random))), w = vec3_cross(n, u);
    for (int k = 0; k < 4; k++) {
        Vec3 along = vec3_scale(u, k == 1 || k == 2 ? size / 2 : -size / 2);
        v[k] = vec3_add(centre, vec3_add(along, vec3_scale(w, k >= 2 ? size / 2 : -size / 2)));
    }
}

// `scenes` scenes of so many polygons each, in a box before the camera, turned every way; together they cover the picture
// about `depth` times over.
static HiddenViews hidden_views_random(int polygons, double depth, int width, int height, int scenes,
                                       uint64_t seed, Arena *arena) {
    HiddenViews views = {ARENA_ARRAY(arena, HiddenView, scenes), scenes};
    for (int s = 0; s < scenes; s++) {
        Random random = {seed + (uint64_t)s};
        Soup soup = soup_new(arena, polygons, 4);
        for (int i = 0; i < polygons; i++) {
            Vec3 centre = somewhere(&random);
            // Seen from a random side a square shows half of its area.
            double size = 2 * TAN * centre.x * sqrt(2 * depth / polygons);
            random_square(soup.vertices + 4 * (size_t)i, &random, centre, size);
        }
        views.views[s] =
            (HiddenView){{soup.polygons, soup.vertices, NULL, polygons}, ahead(width, height), false};
    }
    return views;
}

// Triangles of 2 to 20 pixels anywhere in the picture.
static HiddenViews hidden_views_triangles(int triangles, int width, int height, uint64_t seed, Arena *arena) {
    HiddenViews views = {ARENA_ARRAY(arena, HiddenView, 1), 1};
    Random random = {seed};
    Soup soup = soup_new(arena, triangles, 3);
    for (int i = 0; i < triangles; i++) {
        Vec3 centre = somewhere(&random);
        double area = random_between(&random, 2, 20), pixel = 2 * TAN * centre.x / width;
        // Half base and height of an isosceles one of that area, turned in the picture and leaning up to 45 degrees.
        double half = sqrt(area / 2) * pixel * random_between(&random, 0.7, 1.4),
               high = area * pixel * pixel / half, a = random_between(&random, 0, 2 * M_PI),
               lean = random_between(&random, -1, 1);
        const double at[3][2] = {{-half, -high / 3}, {half, -high / 3}, {0, 2 * high / 3}};
        for (int k = 0; k < 3; k++) {
            double y = cos(a) * at[k][0] - sin(a) * at[k][1], z = sin(a) * at[k][0] + cos(a) * at[k][1];
            soup.vertices[3 * i + k] = vec3_add(centre, vec3(lean * y, y, z));
        }
    }
    views.views[0] =
        (HiddenView){{soup.polygons, soup.vertices, NULL, triangles}, ahead(width, height), false};
    return views;
}

// The polygons of objects, in their order.
static Scene scene_of(const CellGraph *graph, const VisResult *seen, Arena *arena) {
    int *list = ARENA_ARRAY(arena, int, seen->polygon_count + 1), count = 0;
    for (int i = 0; i < seen->object_count; i++) {
        const Object *object = &graph->objects[seen->objects[i]];
        for (int k = 0; k < object->polygon_count; k++) list[count++] = object->first_polygon + k;
    }
    return (Scene){graph->polygons, graph->vertices, list, count};
}

// A scene of the view's own where the building has curved shapes: they are subdivided for it. Adds to `polygons` and `seconds`.
static Scene subdivided(const CellGraph *graph, Scene scene, const Camera *camera, Arena *arena,
                        long *polygons, double *seconds) {
    CurvedScene curved;
    double start = clock_thread_seconds();
    curved_scene_new(graph->building, &scene, graph->polygon_count, graph->vertex_count, camera,
                     CURVED_SCENE_PIXELS, arena, &curved);
    *seconds += clock_thread_seconds() - start;
    *polygons += curved.subdivided;
    return curved.scene;
}

// So many frames of the auto tour, doors open: all polygons, and those that the stab trees leave.
static bool hidden_views_building(const char *file, const BenchArguments *a, int frames, Arena *arena,
                                  HiddenViews *whole, HiddenViews *culled, Error *error) {
    LoadedScene *scene = ARENA_ARRAY(arena, LoadedScene, 1);
    SceneOptions load = a->load;
    TourOptions options = tour_default_options();
    TourPath path;
    if (!app_load(file, &load, arena, scene, error) || !scene_has_walls(scene, error) ||
        !tour_make(&scene->graph, "auto", &options, arena, &path, error))
        return false;
    VisQuery *query = vis_query_new(&scene->graph, &scene->forest, arena);
    if (frames > path.frame_count) frames = path.frame_count;
    HiddenViews *out[2] = {whole, culled};
    bool curved = scene->building.shape_count > 0;
    long polygons = 0;
    double seconds = 0;
    for (int k = 0; k < 2; k++) {
        *out[k] = (HiddenViews){ARENA_ARRAY(arena, HiddenView, frames), frames};
        for (int i = 0; i < frames; i++) {
            const TourFrame *at = &path.frames[(long)i * path.frame_count / frames];
            Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, a->size[0], a->size[1]);
            Eye eye = walk_eye(&camera);
            bool same = k == 0 && i > 0 && !curved;
            Scene list = same ? whole->views[0].scene : (Scene){0};
            if (!same) {
                int cell = vis_locate(&scene->graph, at->eye, -1);
                VisResult seen = vis_query(query, &eye, cell, NULL, k == 0 ? CULL_NONE : CULL_STAB);
                list = scene_of(&scene->graph, &seen, arena);
            }
            if (curved) list = subdivided(&scene->graph, list, &camera, arena, &polygons, &seconds);
            out[k]->views[i] = (HiddenView){list, camera, same};
        }
    }
    if (curved)
        fprintf(stderr, "%s: curved shapes become %.0f polygons a view, within %g pixels, in %.3f ms\n", file,
                (double)polygons / (2 * frames), CURVED_SCENE_PIXELS, 1e3 * seconds / (2 * frames));
    return true;
}

static const char HEAD[] =
    "table,scene,polygons,depth_complexity,width,height,method,prepare_ms,ms,wrong_share,"
    "memory_kb,set_up,edges,comparisons,splits,pixels,depth_tests,nodes,rays,undecided\n";

// A view is drawn until it took so long, or so often.
static const double VIEW_SECONDS = 0.03;
enum { VIEW_DRAWS = 30, MOST_METHODS = 16 };

// A method's figures on the views of a scene: sums over the views.
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

static const double DEPTH = 4;         // complexity, where it does not vary
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
