// bench_light.c - the error of the light of a bake at random points, against path tracing, and its time, for several ways to bake.
//
// Errors are relative to the irradiance, or to a hundredth of the mean of all points where that is more; the last of each three also
// to the mean.
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "engine/bench/light/error_picture.h"
#include "engine/bench/light/lit_points.h"
#include "engine/core/clock.h"

static const char LIGHT_HEAD[] =
    "building,configuration,element_m,per_patch,culling,row_mb,residual,resolution,elements,patches,shots,"
    "rows_made,bake_seconds,probe_seconds,"
    "gather_median,gather_rms,gather_p90,gather_max,gather_lit_median,gather_lit_rms,gather_mean_rms,"
    "element_median,element_rms,element_p90,element_max,element_lit_median,element_lit_rms,element_mean_rms,"
    "vertex_median,vertex_rms,vertex_p90,vertex_max,vertex_lit_median,vertex_lit_rms,vertex_mean_rms,"
    "points,points_reflecting,points_dark,truth_error,bake_work_seconds\n";

// ---- ways to bake

typedef struct LightWay {
    const char *name;
    double element;  // metres; 0, and so on: the default
    int per_patch;
    bool unculled, keeps_no_rows;
    double residual;
    int resolution;
    double proxy;         // metres; below 0: no stand-ins
    double share;         // of elements that a mesh without splits has; below 0: no splits
    double reach, close;  // below 0: none
    int gather;           // resolution of a final gather at all vertices; 0: none
} LightWay;

static const LightWay WAYS[] = {
    {.name = "default"},
    {.name = "even", .share = -1},
    {.name = "even-uncut", .share = -1, .close = -1},
    {.name = "even-uncut-reach-0", .share = -1, .close = -1, .reach = -1},
    {.name = "split-0.2", .share = 0.2},
    {.name = "split-0.4", .share = 0.4},
    {.name = "split-0.7", .share = 0.7},
    {.name = "split-1", .share = 1},
    {.name = "split-2", .share = 2},
    {.name = "no-proxies", .proxy = -1},
    {.name = "proxies-0.005", .proxy = 0.005},
    {.name = "proxies-0.01", .proxy = 0.01},
    {.name = "proxies-0.02", .proxy = 0.02},
    {.name = "proxies-0.04", .proxy = 0.04},
    {.name = "reach-0", .reach = -1},
    {.name = "reach-1", .reach = 1},
    {.name = "reach-3", .reach = 3},
    {.name = "element-1", .element = 1},
    {.name = "element-0.7", .element = 0.7},
    {.name = "element-0.5", .element = 0.5},
    {.name = "element-0.33", .element = 0.33},
    {.name = "element-0.25", .element = 0.25},
    {.name = "element-0.17", .element = 0.17},
    {.name = "per-patch-1", .per_patch = 1},
    {.name = "per-patch-2", .per_patch = 2},
    {.name = "per-patch-4", .per_patch = 4},
    {.name = "not-culled", .unculled = true},
    {.name = "no-rows-kept", .keeps_no_rows = true},
    {.name = "not-culled-0.1", .unculled = true, .residual = 0.1},
    {.name = "not-culled-0.01", .unculled = true, .residual = 0.01},
    {.name = "not-culled-0.001", .unculled = true, .residual = 0.001},
    {.name = "no-rows-kept-0.1", .keeps_no_rows = true, .residual = 0.1},
    {.name = "no-rows-kept-0.01", .keeps_no_rows = true, .residual = 0.01},
    {.name = "no-rows-kept-0.001", .keeps_no_rows = true, .residual = 0.001},
    {.name = "residual-0.1", .residual = 0.1},
    {.name = "residual-0.01", .residual = 0.01},
    {.name = "residual-0.001", .residual = 0.001},
    {.name = "residual-0.0001", .residual = 1e-4},
    {.name = "resolution-50", .resolution = 50},
    {.name = "resolution-200", .resolution = 200},
    {.name = "final-gather-25", .gather = 25},
    {.name = "final-gather-50", .gather = 50},
    {.name = "final-gather-100", .gather = 100},
    {.name = "finest", .element = 0.17, .per_patch = 1, .residual = 1e-4, .resolution = 200},
};

enum { WAY_COUNT = sizeof WAYS / sizeof *WAYS };

static bool is_light_method(const char *name) {
    for (int i = 0; i < WAY_COUNT; i++)
        if (strcmp(WAYS[i].name, name) == 0) return true;
    return false;
}

static void print_ways(void) {
    int column = printf("    ways:              ");
    for (int i = 0; i < WAY_COUNT; i++) {
        if (column + strlen(WAYS[i].name) > 110) column = printf("\n%23s", "") - 1;
        column += printf(" %s%s", WAYS[i].name, i + 1 < WAY_COUNT ? "," : "\n");
    }
}

static void apply(const LightWay *way, LightBake *bake) {
    MeshOptions *mesh = &bake->options;
    RadOptions *rad = &bake->rad;
    if (way->share != 0) bake->adapt.share = fmax(way->share, 0);
    if (way->reach != 0) rad->reach = fmax(way->reach, 0);
    if (way->close != 0) mesh->close = fmax(way->close, 0);
    if (way->proxy != 0) mesh->proxy = fmax(way->proxy, 0);
    if (way->element > 0) mesh->element = way->element;
    if (way->per_patch > 0) mesh->per_patch = way->per_patch;
    if (way->unculled) rad->culling = CULL_NONE;
    if (way->keeps_no_rows) rad->row_bytes = 0;
    if (way->residual > 0) rad->residual = way->residual;
    if (way->resolution > 0) rad->form_factor.resolution = way->resolution;
    bake->gather = way->gather;
}

// ---- tables

static void print_worst(const LightScene *s, const LightWay *way, int what, const double *off) {
    enum { WORST = 3 };
    const CellGraph *graph = &s->scene.graph;
    const LightPoint *points = s->points.points;
    int worst[WORST] = {-1, -1, -1};
    for (int k = 0; k < WORST; k++) {
        double most = -1;
        for (int i = 0; i < s->points.count; i++) {
            double e = fabs(off[i] / points[i].scale);
            if (isnan(e) || i == worst[0] || i == worst[1] || e <= most) continue;
            worst[k] = i;
            most = e;
        }
        if (worst[k] < 0) return;
        const LightPoint *p = &points[worst[k]];
        int object = 0;
        while (object + 1 < graph->object_count && graph->objects[object + 1].first_polygon <= p->polygon)
            object++;
        fprintf(stderr,
                "%s, %s, %s: point %d, polygon %d of %s, %.3f,%.3f,%.3f facing %.2f,%.2f,%.2f: %+.2f %% of "
                "%.4g W/m^2\n",
                bench_name(s->file), way->name, LIGHT_COMPARED_NAMES[what], worst[k], p->polygon,
                graph->objects[object].name ? graph->objects[object].name : "", p->place.x, p->place.y,
                p->place.z, p->normal.x, p->normal.y, p->normal.z, 100 * off[worst[k]] / p->scale,
                light_point_irradiance(p));
    }
}

static void add_light_row(const LightScene *s, const LightWay *way, const LightBake *bake,
                          const LightErrors *errors, Text *csv) {
    size_t before = csv->size;
    text_append(csv, "%s,%s,%g,%d,%s,%zu,%g,%d,%d,%d,%lld,%lld,%.4f,%.4f", bench_name(s->file), way->name,
                bake->options.element, bake->options.per_patch, CULLING_NAMES[bake->rad.culling],
                bake->rad.row_bytes >> 20, bake->rad.residual, bake->rad.form_factor.resolution,
                bake->mesh.element_count, bake->mesh.patch_count, bake->report.shots, bake->report.rows_made,
                bake->seconds, errors->gather_seconds);
    int reflecting = 0, dark;
    for (int what = 0; what < LIGHT_COMPARED; what++) {
        const double *off = errors->off[what];
        Spread all = lit_spread(&s->points, off, false), lit = lit_spread(&s->points, off, true);
        text_append(csv, ",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f", all.median, all.rms, all.p90, all.most,
                    lit.median, lit.rms, light_errors_rms(s, off));
        reflecting = all.count;
        if (s->arguments->verbose) print_worst(s, way, what, off);
    }
    double uncertain = lit_truth_error(&s->points, &dark);
    text_append(csv, ",%d,%d,%d,%.4f,%.4f\n", s->points.count, reflecting, dark, uncertain,
                bake->work_seconds);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

// From the first stored viewpoint, or where one begins.
static bool draw_errors(const LightScene *s, const LightWay *way, const LightBake *bake, Error *error) {
    const BenchArguments *a = s->arguments;
    const Building *building = &s->scene.building;
    Viewpoint v = {.eye = building->start, .yaw = building->start_yaw, .fov = 75 * M_PI / 180};
    if (building->viewpoint_count > 0) v = building->viewpoints[0];
    Camera camera = camera_look(v.eye, v.yaw, v.pitch, v.fov, a->size[0], a->size[1]);
    ErrorPicture picture = {&bake->fine->mesh, &bake->shown, a->seed};
    ErrorPictureFound found;
    double begin = clock_seconds();
    if (!error_picture(&picture, &camera, a->pictures, way->name, &found, error)) return false;
    fprintf(stderr, "%s, %s: %s/%s-error.png in %.1f s, RMS %.2f %%, noise %.2f %%\n", bench_name(s->file),
            way->name, a->pictures, way->name, clock_seconds() - begin, found.rms, found.noise);
    return true;
}

static bool bench_way(const LightScene *s, const LightWay *way, Text *csv, Error *error) {
    Arena arena = {0};
    LightBake bake;
    light_bake_defaults(s, &bake);
    apply(way, &bake);
    bool good = light_bake(s, &arena, &bake, error);
    if (good) {
        LightErrors errors = light_errors(s, &bake, s->points.count, &arena);
        add_light_row(s, way, &bake, &errors, csv);
        if (s->arguments->pictures) good = draw_errors(s, way, &bake, error);
    }
    arena_free(&arena);
    return good;
}

static bool light_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Arena arena = {0};
    LightScene s;
    bool good = light_scene_open(file, a, LIGHT_TRUTH_EACH, &arena, &s, error);
    for (int i = 0; i < WAY_COUNT && good; i++)
        if (bench_listed(a->methods, WAYS[i].name)) good = bench_way(&s, &WAYS[i], csv, error);
    arena_free(&arena);
    return good;
}

static bool measure_light(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.points == 0) own.points = 100;
    if (own.error == 0) own.error = 0.003;
    return bench_table(&own, LIGHT_HEAD, NULL, light_of_file, error);
}

static const Option LIGHT_ROWS[] = {
    BENCH_METHODS("some of the ways below (default: all)"),
    BENCH_POINTS("100"),
    BENCH_ERROR("standard error of the truth, relative, @ (default 0.003)"),
    BENCH_SEED("of points and paths"),
    BENCH_SKY,
    BENCH_PICTURES(
        "of errors of the light as shown, from FILE's first viewpoint: DIR/default-error.png and so on, "
        "DIR/light-error-scale.svg"),
    BENCH_SIZE("of these pictures, which take minutes"),
    {.name = "verbose",
     .type = OPTION_FLAG,
     .at = BENCH_AT(verbose),
     .help = "the three worst points of each row on standard error"},
    BENCH_CSV,
};

const Bench BENCH_LIGHT = {
    .name = "light",
    .about =
        "how right a bake is at random points, against path tracing, and what it costs, by ways to bake; "
        "percent of the irradiance there, or of a hundredth of the mean where that is more; gather_: as "
        "--probe gathers it, element_ and vertex_: of the solution where the point lies, (B - E) / rho",
    BENCH_OPTIONS(LIGHT_ROWS),
    .run = measure_light,
    .is_method = is_light_method,
    .print_methods = print_ways,
    .files = BENCH_LIT_FILES,
};
