// bench_pictures.c - how right the light of a walk's picture is: four views of each building by night and by day, the light that each
// pixel shows against path tracing at random pixels, and against a converged gather at every pixel, whose ratio to it tells blotches by
// their size.
//
// The truth of a view is kept in the user's cache: it depends on the building, the lamps added to it, the view, the day, the seed and the
// error asked for.
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/bench/bench.h"
#include "engine/bench/light/blotch.h"
#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/draw/image.h"
#include "engine/draw/view.h"
#include "engine/lit/exposure.h"
#include "engine/lit/false_colour.h"
#include "engine/scene/bake_mesh.h"
#include "engine/scene/door_state.h"
#include "engine/shade/walk_shade.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"
#include "radiosity/truth/path_tracer.h"
#include "radiosity/truth/path_walk.h"

static const char PICTURES_HEAD[] = "building,view,hour,method,seconds,mean,p95,blotch\n";

enum { VIEWS = 4 };
// Pixels darker than this share of the view's mean are measured against it.
static const double DARK = 0.01;
// Edge of the elements of the truth's own mesh, which path tracing does not see, metres.
static const double TRUTH_ELEMENT = 1;
// The solution that the gather reads is found in so many directions each way, and until so little is left.
static const int GATHERED_RESOLUTION = 200;
static const double GATHERED_RESIDUAL = 2e-4;
// Beyond so many paths a pixel stays as uncertain as it is.
static const long long MOST_PATHS = 4000000;
// Walks that learn where light comes from.
static const long long LEARNING_PATHS = 300000;
// The first round stops at so many times the error asked for, or after so many paths.
static const double FIRST = 10;
static const long long FIRST_PATHS = 20000;
// Pixels at which the gather is held against an exact one, to tell its noise.
enum { NOISE_PIXELS = 64 };
// The file of a truth gets another number with another content.
enum { TRUTH_VERSION = 2 };
static const size_t LARGEST_TRUTH = (size_t)1 << 30;

// A pixel that shows a front that reflects light.
typedef struct Seen {
    int pixel, polygon;  // row by row; of the graph
    Vec3 point, normal;
    double albedo[3], emitted[3];
} Seen;

typedef struct PictureView {
    const char *name;
    Camera camera;
    Seen *seen;         // [seen_count] in the order of pixels
    double *gathered;   // [seen_count] radiosity, W/m^2, the sum of the channels
    int *chosen;        // [chosen_count] in `seen`
    double *truth;      // [chosen_count] radiosity by path tracing
    double *deviation;  // [chosen_count] its standard error
    double mean;        // of `truth`
    double noise;       // of the gather, the root of the mean square, a share
    double seconds;     // of the gather, its bake included
    int seen_count, chosen_count;
} PictureView;

typedef struct PictureScene {
    const char *file, *hour;
    const BenchArguments *arguments;
    LoadedScene scene;
    float *doors;
    PictureView views[VIEWS];
    int view_count;
    Mesh mesh;  // of the truth
    PathTracer *tracer;
} PictureScene;

// A light, as a walk shows it; `fine` NULL: the view's gather.
typedef struct Shown {
    Mesh mesh;
    RadSolution solution;
    const FineMesh *fine;
    RadSolution light;  // of `fine`
    VertexLight field;
    double seconds;
} Shown;

// A way to bake.
typedef struct PictureWay {
    const char *name;
    int resolution, gather;  // of shots, and of a final gather at all vertices; 0: as `enfilade bake` does
    double share, residual;
    bool shot;      // light straight from lamps is shown as it was shot
    bool gathered;  // no bake: the gather at every pixel that blotches are told by
} PictureWay;

static const PictureWay WAYS[] = {
    {.name = "default"},
    {.name = "as-shot", .shot = true},
    {.name = "resolution-200", .resolution = 200},
    {.name = "resolution-400", .resolution = 400},
    {.name = "split-1", .share = 1},
    {.name = "split-2", .share = 2},
    {.name = "final-gather", .gather = 50},
    {.name = "gathered", .gathered = true},
};
enum { WAY_COUNT = sizeof WAYS / sizeof *WAYS };

static bool is_picture_method(const char *name) {
    for (int i = 0; i < WAY_COUNT; i++)
        if (strcmp(WAYS[i].name, name) == 0) return true;
    return false;
}

static void print_ways(void) {
    printf("    ways:               ");
    for (int i = 0; i < WAY_COUNT; i++) printf("%s%s", WAYS[i].name, i + 1 < WAY_COUNT ? ", " : "\n");
}

// ---- views: those that the building stores, then its rooms, the largest first

static double cell_area(const CellGraph *graph, int cell) {
    const Cell *c = &graph->cells[cell];
    const Vec2 *v = graph->plan + c->first_edge;
    double twice = 0;
    for (int i = 1; i + 1 < c->edge_count; i++)
        twice += (v[i].x - v[0].x) * (v[i + 1].y - v[0].y) - (v[i + 1].x - v[0].x) * (v[i].y - v[0].y);
    return twice / 2;
}

// From the middle of the cell's plan to its farthest corner.
static Viewpoint cell_view(const CellGraph *graph, int cell) {
    const Cell *c = &graph->cells[cell];
    const Vec2 *v = graph->plan + c->first_edge;
    Vec2 middle = {0, 0}, to = {0, 0};
    double farthest = -1;
    for (int i = 0; i < c->edge_count; i++) {
        middle.x += v[i].x / c->edge_count;
        middle.y += v[i].y / c->edge_count;
    }
    for (int i = 0; i < c->edge_count; i++) {
        Vec2 way = {v[i].x - middle.x, v[i].y - middle.y};
        double far = way.x * way.x + way.y * way.y;
        if (far <= farthest) continue;
        farthest = far;
        to = way;
    }
    double z = fmin(c->z0 + 1.6, (c->z0 + 2 * c->z1) / 3);
    return (Viewpoint){.eye = vec3(middle.x, middle.y, z), .yaw = atan2(to.y, to.x), .fov = 75 * M_PI / 180};
}

static void add_view(PictureScene *s, const char *name, const Viewpoint *v) {
    const int *size = s->arguments->size;
    s->views[s->view_count++] = (PictureView){
        .name = name, .camera = camera_look(v->eye, v->yaw, v->pitch, v->fov, size[0], size[1])};
}

// The largest cell of each room that has no view yet.
static int largest_room(const CellGraph *graph, const bool *used) {
    int best = -1;
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        bool indoors =
            cell->region < 0 ? !cell->outdoors : graph->building->regions[cell->region].kind == REGION_ROOM;
        if (!indoors || (cell->region >= 0 ? used[cell->region] : used[c])) continue;
        if (best < 0 || cell_area(graph, c) > cell_area(graph, best)) best = c;
    }
    return best;
}

static void choose_views(PictureScene *s, Arena *arena) {
    const Building *b = &s->scene.building;
    const CellGraph *graph = &s->scene.graph;
    bool *used = ARENA_ARRAY(arena, bool, b->region_count + graph->cell_count + 1);
    for (int i = 0; i < b->viewpoint_count && s->view_count < VIEWS; i++)
        add_view(s, arena_format(arena, "%d", s->view_count + 1), &b->viewpoints[i]);
    for (int cell; s->view_count < VIEWS && (cell = largest_room(graph, used)) >= 0;) {
        int region = graph->cells[cell].region;
        Viewpoint v = cell_view(graph, cell);
        used[region >= 0 ? region : cell] = true;
        add_view(s, arena_format(arena, "%d", s->view_count + 1), &v);
    }
}

// ---- pixels

// Radiosity of the pixel's surface under an irradiance, the sum of the channels.
static double lit(const Seen *seen, const double irradiance[3]) {
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += seen->emitted[c] + seen->albedo[c] * irradiance[c];
    return sum;
}

// Lamps, backs, the sky and surfaces that reflect nothing are left out: their picture depends on no light.
static void look_through_pixels(PictureScene *s, PictureView *view, Arena *arena) {
    Arena scratch = {0};
    PathScene *paths = path_scene_new(&s->mesh, &scratch);
    Vec3 origin = path_scene_origin(paths);
    int count = view->camera.width * view->camera.height;
    view->seen = ARENA_ARRAY(arena, Seen, count);
    for (int i = 0; i < count; i++) {
        Vec3 along = camera_ray(&view->camera, i % view->camera.width + 0.5, i / view->camera.width + 0.5);
        PathHit hit = path_scene_trace(paths, vec3_sub(view->camera.eye, origin), vec3_normalize(along));
        if (hit.face < 0 || !hit.front || mesh_emits(&s->mesh, hit.face)) continue;
        Seen *seen = &view->seen[view->seen_count];
        *seen = (Seen){.pixel = i,
                       .polygon = s->mesh.faces[hit.face].polygon,
                       .point = vec3_add(hit.point, origin),
                       .normal = s->mesh.faces[hit.face].plane.n};
        rgb_doubles(mesh_material(&s->mesh, hit.face)->reflectance, seen->albedo);
        rgb_doubles(mesh_material(&s->mesh, hit.face)->emission, seen->emitted);
        view->seen_count += rgb_sum(seen->albedo) > 0;
    }
    path_scene_end(paths);
    arena_free(&scratch);
}

static void choose_pixels(const PictureScene *s, PictureView *view, int index, Arena *arena) {
    Random random = {s->arguments->seed * VIEWS + (uint64_t)index};
    view->chosen_count = view->seen_count > 0 ? s->arguments->points : 0;
    view->chosen = ARENA_ARRAY(arena, int, view->chosen_count + 1);
    view->truth = ARENA_ARRAY(arena, double, view->chosen_count + 1);
    view->deviation = ARENA_ARRAY(arena, double, view->chosen_count + 1);
    view->gathered = ARENA_ARRAY(arena, double, view->seen_count + 1);
    for (int i = 0; i < view->chosen_count; i++) view->chosen[i] = random_index(&random, view->seen_count);
}

// ---- the truth

static void take_paths(PictureView *view, int index, const PathResult *result) {
    const Seen *seen = &view->seen[view->chosen[index]];
    view->truth[index] = lit(seen, result->irradiance);
    view->deviation[index] = 0;
    // The channels scatter together.
    for (int c = 0; c < 3; c++) view->deviation[index] += seen->albedo[c] * result->standard_error[c];
}

static double mean_of(const double *v, int count) {
    double sum = 0;
    for (int i = 0; i < count; i++) sum += v[i];
    return count > 0 ? sum / count : 0;
}

// In two rounds: the first tells how bright the view is.
static void trace_pixels(const PictureScene *s, PictureView *view) {
    Arena scratch = {0};
    int count = view->chosen_count, *which = ARENA_ARRAY(&scratch, int, count + 1), asked = 0;
    PathQuery *queries = ARENA_ARRAY(&scratch, PathQuery, count + 1);
    PathResult *results = ARENA_ARRAY(&scratch, PathResult, count + 1);
    for (int i = 0; i < count; i++) {
        const Seen *seen = &view->seen[view->chosen[i]];
        queries[i] = (PathQuery){.point = seen->point,
                                 .normal = seen->normal,
                                 .relative_error = FIRST * s->arguments->error,
                                 .most_paths = FIRST_PATHS,
                                 .seed = s->arguments->seed + (uint64_t)seen->pixel};
    }
    path_tracer_learn(s->tracer, queries, count, LEARNING_PATHS, 0);
    path_tracer_irradiance(s->tracer, queries, count, 0, results);
    for (int i = 0; i < count; i++) take_paths(view, i, &results[i]);
    view->mean = mean_of(view->truth, count);
    for (int i = 0; i < count; i++) {
        const Seen *seen = &view->seen[view->chosen[i]];
        double most = s->arguments->error * fmax(view->truth[i], DARK * view->mean);
        if (view->deviation[i] <= most) continue;
        which[asked] = i;
        queries[asked] = queries[i];
        queries[asked].relative_error = 0;
        // Errors of irradiance: at most this share of what is reflected.
        queries[asked].absolute_error = 3 * most / rgb_sum(seen->albedo);
        queries[asked++].most_paths = MOST_PATHS;
    }
    path_tracer_irradiance(s->tracer, queries, asked, 0, results);
    for (int i = 0; i < asked; i++) take_paths(view, which[i], &results[i]);
    view->mean = mean_of(view->truth, count);
    arena_free(&scratch);
}

// ---- bakes

static bool bake_way(const PictureScene *s, const PictureWay *way, Arena *arena, Shown *out, Error *error) {
    BakeOptions options = bake_default_options();
    double begin = clock_seconds();
    float *doors;
    options.day = s->scene.day;
    if (way->share > 0) options.adapt.share = way->share;
    options.rad.form_factor.resolution = way->resolution;
    options.rad.residual = way->residual;
    if (!bake_mesh(&options, &s->scene, NULL, NULL, arena, &doors, &out->mesh, error) ||
        !rad_start_dark(&out->mesh, arena, &out->solution, error))
        return false;
    const StabForest *forest = &s->scene.forest;
    rad_fit(&out->mesh, &options.rad);
    if (daylight_shines(&options.day))
        rad_shine(&out->mesh, forest, doors, &options.rad, &options.day, NULL, &out->solution);
    rad_shoot(&out->mesh, forest, doors, &options.rad, NULL, &out->solution);
    if (way->gather > 0) {
        VertexLight light = reconstruct_light(&out->mesh, &out->solution, arena);
        GatherScene scene = {&out->mesh, forest, doors, &out->solution, &light};
        GatherOptions gather = gather_default_options();
        gather.resolution = way->gather;
        final_gather(&scene, &gather, 0, NULL, arena, &out->solution);
    }
    if (way->gather == 0 && !way->shot)
        direct_show(&out->mesh, forest, doors, 0, NULL, arena, &out->solution, NULL);
    const Mesh *mesh;
    const RadSolution *light;
    if (!shown_light(&out->mesh, &out->solution, doors, arena, &mesh, &light, error)) return false;
    out->fine = fine_mesh_new(mesh, arena);
    out->light = fine_light(out->fine, light, arena);
    out->field = reconstruct_light(&out->fine->mesh, &out->light, arena);
    out->seconds = clock_seconds() - begin;
    return true;
}

// The radiosity that a pixel of view->seen shows, the sum of the channels; NAN where the walk draws nothing.
static double shown_at(const Shown *shown, const PictureView *view, int index) {
    double b[3];
    const Seen *seen = &view->seen[index];
    if (!shown->fine) return view->gathered[index];
    int face = shown->fine->mesh.face_of[seen->polygon];
    if (face < 0) return NAN;
    reconstruct_at(&shown->fine->mesh, &shown->field, face, seen->point, b);
    return rgb_sum(b);
}

// ---- a converged gather at every pixel

typedef struct Gathering {
    const PictureView *view;
    const CellGraph *graph;
    Gatherer **gatherer;  // [threads]
    const int *which;     // [count]; NULL: all
    double *out;
} Gathering;

static void gather_pixel(void *context, int index, int thread) {
    const Gathering *g = context;
    const Seen *seen = &g->view->seen[g->which ? g->which[index] : index];
    double h[3];
    int cell = gather_cell(g->graph, seen->point, seen->normal, -1);
    gather(g->gatherer[thread], &(ViewPoint){seen->point, seen->normal, cell}, h);
    g->out[index] = lit(seen, h);
}

static void gather_pixels(const PictureScene *s, const PictureView *view, const Shown *from,
                          const GatherOptions *options, const int *which, int count, double *out) {
    Arena scratch = {0};
    int threads = parallel_threads(0);
    GatherScene scene = {&from->fine->mesh, &s->scene.forest, s->doors, &from->light, &from->field};
    Gathering g = {view, &s->scene.graph, ARENA_ARRAY(&scratch, Gatherer *, threads), which, out};
    for (int t = 0; t < threads; t++) g.gatherer[t] = gatherer_new(&scene, options, &scratch);
    parallel_for(threads, count, gather_pixel, &g);
    for (int t = 0; t < threads; t++) gatherer_end(g.gatherer[t]);
    arena_free(&scratch);
}

// How far the gather is off an exact one.
static void find_noise(const PictureScene *s, PictureView *view, const Shown *from) {
    GatherOptions exact = gather_exact_options();
    int which[NOISE_PIXELS], count = view->chosen_count < NOISE_PIXELS ? view->chosen_count : NOISE_PIXELS;
    double out[NOISE_PIXELS], squares = 0;
    for (int i = 0; i < count; i++) which[i] = view->chosen[i];
    gather_pixels(s, view, from, &exact, which, count, out);
    for (int i = 0; i < count; i++) {
        double scale = fmax(out[i], DARK * view->mean);
        double off = scale > 0 ? (view->gathered[which[i]] - out[i]) / scale : 0;
        squares += off * off;
    }
    view->noise = count > 0 ? sqrt(squares / count) : 0;
}

// ---- the truth in the cache

typedef struct TruthKey {
    uint64_t version, building, seed;
    double camera[14], error;
    Daylight day;
    int64_t fill_lamps, width, height, points, seen;
} TruthKey;

static TruthKey truth_key(const PictureScene *s, const PictureView *view) {
    const Camera *c = &view->camera;
    const BenchArguments *a = s->arguments;
    return (TruthKey){TRUTH_VERSION,
                      s->scene.building.hash,
                      a->seed,
                      {c->eye.x, c->eye.y, c->eye.z, c->forward.x, c->forward.y, c->forward.z, c->right.x,
                       c->right.y, c->right.z, c->up.x, c->up.y, c->up.z, c->tan_x, c->tan_y},
                      a->error,
                      s->scene.day,
                      s->scene.building.fill_lamps,
                      c->width,
                      c->height,
                      view->chosen_count,
                      view->seen_count};
}

// The numbers of a truth, in the order of the file: mean, noise, seconds, truth, deviation, gathered.
static size_t truth_numbers(const PictureView *view) {
    return 3 + 2 * (size_t)view->chosen_count + (size_t)view->seen_count;
}

static void copy_truth(PictureView *view, double *numbers, bool store) {
    struct {
        double *field;
        size_t count;
    } parts[] = {{&view->mean, 1},
                 {&view->noise, 1},
                 {&view->seconds, 1},
                 {view->truth, (size_t)view->chosen_count},
                 {view->deviation, (size_t)view->chosen_count},
                 {view->gathered, (size_t)view->seen_count}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (store)
            memcpy(numbers, parts[i].field, parts[i].count * sizeof *numbers);
        else
            memcpy(parts[i].field, numbers, parts[i].count * sizeof *numbers);
        numbers += parts[i].count;
    }
}

static const char *truth_path(const TruthKey *key, Arena *arena) {
    return scene_cache_path(arena,
                            arena_format(arena, "%016llx-%016llx.truth", (unsigned long long)key->building,
                                         (unsigned long long)file_hash(key, sizeof *key, 0)));
}

static bool read_truth(const PictureScene *s, PictureView *view) {
    Arena scratch = {0};
    Bytes bytes;
    Error error;
    TruthKey key = truth_key(s, view);
    const char *path = truth_path(&key, &scratch);
    size_t size = sizeof key + truth_numbers(view) * sizeof(double);
    bool good = path && file_read(path, LARGEST_TRUTH, &scratch, &bytes, &error) && bytes.size == size + 8 &&
                memcmp(bytes.data, &key, sizeof key) == 0;
    if (good) {
        uint64_t hash = file_hash(bytes.data, size, 0);
        good = memcmp(bytes.data + size, &hash, sizeof hash) == 0;
    }
    if (good) copy_truth(view, (double *)(void *)(bytes.data + sizeof key), false);
    arena_free(&scratch);
    return good;
}

// A truth that cannot be kept is found again the next time.
static void keep_truth(const PictureScene *s, PictureView *view) {
    Arena scratch = {0};
    Error error;
    TruthKey key = truth_key(s, view);
    const char *path = truth_path(&key, &scratch);
    size_t size = sizeof key + truth_numbers(view) * sizeof(double);
    unsigned char *data = ARENA_ARRAY(&scratch, unsigned char, size + 8);
    memcpy(data, &key, sizeof key);
    copy_truth(view, (double *)(void *)(data + sizeof key), true);
    uint64_t hash = file_hash(data, size, 0);
    memcpy(data + size, &hash, sizeof hash);
    if (path && scene_cache_check(path, size, &error) && !file_write(path, data, size + 8, &error))
        app_warn(error.text);
    arena_free(&scratch);
}

// The solution that is gathered is made when the first view asks for it.
static bool find_truth(PictureScene *s, Arena *arena, Error *error) {
    static const PictureWay GATHERED = {
        .name = "gathered", .resolution = GATHERED_RESOLUTION, .residual = GATHERED_RESIDUAL};
    Arena scratch = {0};
    Shown from;
    bool baked = false, good = true;
    for (int v = 0; v < s->view_count && good; v++) {
        PictureView *view = &s->views[v];
        look_through_pixels(s, view, arena);
        choose_pixels(s, view, v, arena);
        if (read_truth(s, view)) continue;
        double begin = clock_seconds();
        if (!baked) good = bake_way(s, &GATHERED, &scratch, &from, error);
        baked = true;
        if (!good) break;
        double paths = -clock_seconds();
        trace_pixels(s, view);
        paths += clock_seconds();
        GatherOptions options = gather_default_options();
        options.resolution = GATHERED_RESOLUTION;
        view->seconds = -clock_seconds();
        gather_pixels(s, view, &from, &options, NULL, view->seen_count, view->gathered);
        view->seconds += clock_seconds() + from.seconds;
        find_noise(s, view, &from);
        keep_truth(s, view);
        fprintf(stderr, "%s, view %s, %s: truth in %.1f s, of which %.1f s are of paths\n",
                bench_name(s->file), view->name, s->hour, clock_seconds() - begin, paths);
    }
    arena_free(&scratch);
    return good;
}

// ---- errors

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

// Shares of the truth.
typedef struct PictureErrors {
    double mean, median, p95;  // without the scatter of the truth itself
    double bias;               // the mean of signed errors
} PictureErrors;

static double at_share(const double *sorted, int count, double share) {
    return count > 0 ? sorted[(int)(share * (count - 1) + 0.5)] : 0;
}

static PictureErrors find_errors(const PictureView *view, const Shown *shown) {
    Arena scratch = {0};
    double *off = ARENA_ARRAY(&scratch, double, view->chosen_count + 1), bias = 0;
    int count = 0;
    for (int i = 0; i < view->chosen_count; i++) {
        double value = shown_at(shown, view, view->chosen[i]);
        double scale = fmax(view->truth[i], DARK * view->mean);
        if (isnan(value) || !(scale > 0)) continue;
        double error = value - view->truth[i], deviation = view->deviation[i];
        off[count++] = sqrt(fmax(error * error - deviation * deviation, 0)) / scale;
        bias += error / scale;
    }
    qsort(off, (size_t)count, sizeof *off, by_size);
    PictureErrors errors = {mean_of(off, count), at_share(off, count, 0.5), at_share(off, count, 0.95),
                            count > 0 ? bias / count : 0};
    arena_free(&scratch);
    return errors;
}

// The worst band. Pixels darker than a hundredth of the view's mean are left out.
static double find_blotches(const PictureScene *s, const PictureView *view, const PictureWay *way,
                            const Shown *shown) {
    Arena scratch = {0};
    int count = 0;
    Vec3 *point = ARENA_ARRAY(&scratch, Vec3, view->seen_count + 1);
    Vec3 *normal = ARENA_ARRAY(&scratch, Vec3, view->seen_count + 1);
    double *light = ARENA_ARRAY(&scratch, double, view->seen_count + 1), worst = 0;
    double *truth = ARENA_ARRAY(&scratch, double, view->seen_count + 1), rms[BLOTCH_BANDS];
    for (int i = 0; i < view->seen_count; i++) {
        double value = shown_at(shown, view, i);
        if (!(value > 0) || !(view->gathered[i] > DARK * view->mean)) continue;
        point[count] = view->seen[i].point;
        normal[count] = view->seen[i].normal;
        light[count] = value;
        truth[count++] = view->gathered[i];
    }
    double stays = blotch_bands(&(BlotchPixels){count, point, normal, light, truth}, rms);
    fprintf(stderr, "%s, view %s, %s, %s: blotches of 6, 12, 24, 48, 96 cm", bench_name(s->file), view->name,
            s->hour, way->name);
    for (int b = 0; b < BLOTCH_BANDS; b++) {
        fprintf(stderr, " %.2f", 100 * rms[b]);
        worst = fmax(worst, rms[b]);
    }
    fprintf(stderr, " %%, of %.0f %% of %d pixels; noise of the gather %.2f %%\n", 100 * stays, count,
            100 * view->noise);
    arena_free(&scratch);
    return worst;
}

// ---- pictures: what is shown beside what was gathered, and how far one is off the other

static void put_signed(uint8_t out[3], double off) {
    Rgb c = false_colour_signed(off);
    out[0] = (uint8_t)lrintf(255 * c.r);
    out[1] = (uint8_t)lrintf(255 * c.g);
    out[2] = (uint8_t)lrintf(255 * c.b);
}

// Three pictures side by side: shown, gathered, and the error, white where there is none and red or blue from 20 % on.
static bool draw_view(const PictureScene *s, const PictureView *view, const PictureWay *way,
                      const Shown *shown, Error *error) {
    static const double ENDS = 0.2;
    static const uint8_t NOTHING = 96;  // grey
    Arena scratch = {0};
    int width = view->camera.width, height = view->camera.height;
    uint8_t *rgb = ARENA_ARRAY(&scratch, uint8_t, 9 * width * height);
    memset(rgb, NOTHING, (size_t)(9 * width * height));
    for (int i = 0; i < view->seen_count; i++) {
        const Seen *seen = &view->seen[i];
        double value = shown_at(shown, view, i), scale = fmax(view->gathered[i], DARK * view->mean);
        if (isnan(value) || !(scale > 0)) continue;
        uint8_t *at = rgb + 3 * (seen->pixel / width * 3 * width + seen->pixel % width);
        const double both[2] = {value, view->gathered[i]};
        for (int k = 0; k < 2; k++) {
            // Twice the mean is white; the root stands in for a screen's curve.
            uint8_t level = (uint8_t)lrint(255 * sqrt(fmin(both[k] / (2 * view->mean), 1)));
            memset(at + 3 * k * width, level, 3);
        }
        put_signed(at + 6 * width, (value - view->gathered[i]) / scale / ENDS);
    }
    const char *path = arena_format(&scratch, "%s/%s-%s-%s-%s.png", s->arguments->pictures,
                                    bench_name(s->file), view->name, s->hour, way->name);
    bool good = file_make_folder(s->arguments->pictures, error) &&
                image_write_png(path, rgb, 3 * width, height, error);
    arena_free(&scratch);
    return good;
}

static bool measure_way(const PictureScene *s, const PictureWay *way, Text *csv, Error *error) {
    Arena arena = {0};
    Shown shown = {.fine = NULL};
    bool good = way->gathered || bake_way(s, way, &arena, &shown, error);
    for (int v = 0; v < s->view_count && good; v++) {
        const PictureView *view = &s->views[v];
        PictureErrors errors = find_errors(view, &shown);
        size_t before = csv->size;
        fprintf(stderr, "%s, view %s, %s, %s: median error %.2f %%, bias %+.2f %%\n", bench_name(s->file),
                view->name, s->hour, way->name, 100 * errors.median, 100 * errors.bias);
        double blotch = find_blotches(s, view, way, &shown);
        text_append(csv, "%s,%s,%s,%s,%.3f,%.5f,%.5f,%.5f\n", bench_name(s->file), view->name, s->hour,
                    way->name, way->gathered ? view->seconds : shown.seconds, errors.mean, errors.p95,
                    blotch);
        fputs(csv->data + before, stdout);
        fflush(stdout);
        if (s->arguments->pictures) good = draw_view(s, view, way, &shown, error);
    }
    arena_free(&arena);
    return good;
}

static bool open_scene(const char *file, const BenchArguments *a, bool day, Arena *arena, PictureScene *out,
                       Error *error) {
    *out = (PictureScene){.file = file, .hour = day ? "day" : "night", .arguments = a};
    SceneOptions options = a->load;
    options.lamps = SCENE_LAMPS_ALL;
    options.day.night = !day;
    options.day.day = day && !day_asks_sky(&options.day);
    if (!app_load(file, &options, arena, &out->scene, error) || !scene_has_walls(&out->scene, error))
        return false;
    MeshOptions mesh = mesh_default_options();
    mesh.element = TRUTH_ELEMENT;
    out->doors = door_state_drawn(&out->scene.building, arena);
    return mesh_build(&out->scene.graph, out->doors, &mesh, arena, &out->mesh, error);
}

static bool pictures_at(const char *file, const BenchArguments *a, bool day, Text *csv, Error *error) {
    Arena arena = {0};
    PictureScene s;
    bool good = open_scene(file, a, day, &arena, &s, error);
    if (good) {
        s.tracer = path_tracer_new(&s.mesh, &s.scene.day, &arena);
        choose_views(&s, &arena);
        good = find_truth(&s, &arena, error);
        path_tracer_end(s.tracer);
    }
    for (int i = 0; i < WAY_COUNT && good; i++)
        if (bench_listed(a->methods ? a->methods : "default", WAYS[i].name))
            good = measure_way(&s, &WAYS[i], csv, error);
    arena_free(&arena);
    return good;
}

// Both hours, unless one is asked for.
static bool at_hours(const char *file, const BenchArguments *a,
                     bool (*each)(const char *file, const BenchArguments *a, bool day, Text *csv,
                                  Error *error),
                     Text *csv, Error *error) {
    const DayOptions *asked = &a->load.day;
    return (day_asks(asked) || each(file, a, false, csv, error)) &&
           (asked->night || each(file, a, true, csv, error));
}

static bool pictures_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    return at_hours(file, a, pictures_at, csv, error);
}

static bool measure_pictures(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.points == 0) own.points = 300;
    if (own.error == 0) own.error = 0.005;
    return bench_table(&own, PICTURES_HEAD, NULL, pictures_of_file, error);
}

// ---- how bright rooms are on the screen

static const char ROOMS_HEAD[] = "building,hour,room,name,area,tenth,median\n";

typedef struct RoomElement {
    double light, area;  // share of white; m^2
} RoomElement;

static int by_light(const void *a, const void *b) {
    const RoomElement *p = a, *q = b;
    return p->light < q->light ? -1 : p->light > q->light;
}

// The light below which this share of the area is. `elements` are sorted.
static double light_at(const RoomElement *elements, int count, double area, double share) {
    int i = 0;
    for (double sum = 0; i + 1 < count; i++)
        if ((sum += elements[i].area) >= share * area) break;
    return count > 0 ? elements[i].light : 0;
}

// The factor of the screen for an eye that has adapted to the view from the middle of a cell.
static double room_exposure(const PictureScene *s, const LitMesh *lit, const LitLight *light, int cell) {
    Arena scratch = {0};
    const int *size = s->arguments->size;
    Viewpoint v = cell_view(&s->scene.graph, cell);
    Camera camera = camera_look(v.eye, v.yaw, v.pitch, v.fov, size[0], size[1]);
    Eye eye = walk_eye(&camera);
    VisQuery *query = vis_query_new(&s->scene.graph, &s->scene.forest, &scratch);
    VisResult seen = vis_query(query, &eye, vis_locate(&s->scene.graph, v.eye, cell), s->doors, CULL_STAB);
    Exposure exposure = {.stops = 0};
    exposure_adapt(&exposure, exposure_meter(lit, light, &camera, seen.objects, seen.object_count),
                   light->level, 0);
    arena_free(&scratch);
    return exposure_scale(&exposure);
}

// As a share of white; the screen's own curve, by which white is 1, is left out.
static double screen_luminance(double light) {
    double x = fmin(light, WALK_WHITE);
    return fmin(WALK_CURVE(x), 1);
}

static void measure_room(const PictureScene *s, const LitMesh *lit, const LitLight *light, int cell,
                         Text *csv) {
    Arena scratch = {0};
    const CellGraph *graph = &s->scene.graph;
    const Mesh *mesh = lit->mesh;
    int region = graph->cells[cell].region, count = 0;
    RoomElement *elements = ARENA_ARRAY(&scratch, RoomElement, mesh->element_count + 1);
    double scale = room_exposure(s, lit, light, cell), area = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        int in = mesh->patches[mesh->elements[e].patch].cell;
        if (in < 0 || (region >= 0 ? graph->cells[in].region != region : in != cell) ||
            mesh_emits(mesh, mesh->elements[e].face))
            continue;
        elements[count] =
            (RoomElement){screen_luminance(scale * (double)light->luminous[e]), mesh->elements[e].area};
        area += elements[count++].area;
    }
    qsort(elements, (size_t)count, sizeof *elements, by_light);
    size_t before = csv->size;
    text_append(csv, "%s,%s,%d,%s,%.2f,%.4f,%.4f\n", bench_name(s->file), s->hour,
                region >= 0 ? region : cell, region >= 0 ? graph->building->regions[region].name : "", area,
                light_at(elements, count, area, 0.1), light_at(elements, count, area, 0.5));
    fputs(csv->data + before, stdout);
    arena_free(&scratch);
}

static bool rooms_at(const char *file, const BenchArguments *a, bool day, Text *csv, Error *error) {
    Arena arena = {0};
    PictureScene s;
    Shown shown;
    bool good = open_scene(file, a, day, &arena, &s, error) && bake_way(&s, &WAYS[0], &arena, &shown, error);
    if (good) {
        const CellGraph *graph = &s.scene.graph;
        LitMesh *lit = lit_mesh_new(&shown.fine->mesh, &arena, &arena);
        LitLight light = lit_light_new(lit, &arena);
        lit_light_fill(lit, &shown.light, NULL, &light);
        bool *used = ARENA_ARRAY(&arena, bool, graph->building->region_count + graph->cell_count + 1);
        for (int cell; (cell = largest_room(graph, used)) >= 0;) {
            int region = graph->cells[cell].region;
            used[region >= 0 ? region : cell] = true;
            measure_room(&s, lit, &light, cell, csv);
        }
    }
    arena_free(&arena);
    return good;
}

static bool rooms_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    return at_hours(file, a, rooms_at, csv, error);
}

static bool measure_rooms(const BenchArguments *a, Error *error) {
    return bench_table(a, ROOMS_HEAD, NULL, rooms_of_file, error);
}

static const Option PICTURES_ROWS[] = {
    BENCH_METHODS("some of the ways below (default: default)"),
    BENCH_POINTS("300"),
    BENCH_ERROR("standard error of the truth, relative, @ (default 0.005)"),
    BENCH_SEED("of pixels and paths"),
    OPTION_DAYLIGHT(BENCH_AT(load.day), "default: by night, then by day"),
    OPTION_FILL_LAMPS(BENCH_AT(load.fill_lamps)),
    BENCH_PICTURES("of each view and way, shown, gathered, and the error: DIR/FILE-VIEW-HOUR-WAY.png"),
    BENCH_SIZE("of the views"),
    BENCH_CSV,
};

const Bench BENCH_LIT_PICTURES = {
    .name = "pictures",
    .about =
        "how right the light is that a walk shows: in four views of each building, against path tracing at "
        "random pixels (mean and 95th percentile of the error, relative to the larger of the truth and a "
        "hundredth of the view's mean), and against a gather at every pixel (blotch: the root of the mean "
        "square of the logarithm of their ratio in the worst octave of sizes from 6 cm to 2 m, away from the "
        "edges of light), by ways to bake; shares of 1",
    BENCH_OPTIONS(PICTURES_ROWS),
    .run = measure_pictures,
    .is_method = is_picture_method,
    .print_methods = print_ways,
    .files = BENCH_LIT_FILES,
    .fill_lamps = FILL_LAMPS_ON,
};

static const Option ROOMS_ROWS[] = {
    OPTION_DAYLIGHT(BENCH_AT(load.day), "default: by night, then by day"),
    OPTION_FILL_LAMPS(BENCH_AT(load.fill_lamps)),
    BENCH_SIZE("of the view that the eye adapts to"),
    BENCH_CSV,
};

const Bench BENCH_ROOMS_LIGHT = {
    .name = "rooms-light",
    .about =
        "how bright each room is on a walk's screen: the luminance, as a share of white, below which a tenth "
        "and half of the area of its surfaces lie, for an eye that has adapted to the view from the "
        "middle of the room",
    BENCH_OPTIONS(ROOMS_ROWS),
    .run = measure_rooms,
    .files = BENCH_LIT_FILES,
    .fill_lamps = FILL_LAMPS_ON,
};
