// bench_light.c - how right the light of a bake is, and what that costs: at random points, against path tracing, by ways to bake.
//
// Errors are relative to the irradiance, or to a hundredth of the mean of all points where that is more; the last of each three also
// to the mean.
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/bench/light_scene.h"
#include "engine/core/clock.h"
#include "engine/core/draw.h"
#include "engine/core/parallel.h"
#include "engine/draw/false_colour.h"
#include "engine/draw/image.h"
#include "radiosity/shoot/shoot.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_walk.h"
#include "visibility/hidden/hidden.h"

typedef struct ErrorPicture {
    const Mesh *mesh;
    const RadSolution *solution;
    uint64_t seed;
} ErrorPicture;

// Roots of mean squares over the pixels, percent.
typedef struct ErrorPictureFound {
    double rms, noise;  // of what is shown; of that, the standard error of the truth
} ErrorPictureFound;

// Ends of the scale, relative: what is farther off looks as if it were so far.
static const double ENDS = 0.2;
// Pixels with less light than this share of the mean of all are measured against it.
static const double DARK = 0.01;
// 4,084 walks a pixel leave a few per cent of noise. A path tracer's query takes eight times as many to know its own error.
enum { BLOCKS = 4 };
static const uint8_t NOTHING = 96;  // grey

typedef struct Pixels {
    Arena arena;
    int count, seen;          // of those seen, in order:
    int *pixel;               // [seen]
    double *shown;            // [seen] irradiance, W/m^2, the sum of the channels that are reflected
    PathPlace *place;         // [seen] of the scene
    double *truth, *scatter;  // [seen] irradiance likewise; the standard error of that
} Pixels;

typedef struct Tracing {
    const PathWorld *world;
    Pixels *pixels;
    uint64_t seed;
} Tracing;

static double shown_at(const ErrorPicture *e, const VertexLight *field, int face, Vec3 point) {
    double b[3];
    reconstruct_at(e->mesh, field, face, point, b);
    return false_colour_value(FALSE_COLOUR_IRRADIANCE, b, mesh_material(e->mesh, face));
}

static void look_through_pixels(const ErrorPicture *e, const Camera *camera, const PathScene *scene,
                                Pixels *p) {
    Arena scratch = {0};
    VertexLight field = reconstruct_light(e->mesh, e->solution, &scratch);
    p->count = camera->width * camera->height;
    p->pixel = ARENA_ARRAY(&p->arena, int, p->count);
    p->shown = ARENA_ARRAY(&p->arena, double, p->count);
    p->truth = ARENA_ARRAY(&p->arena, double, p->count);
    p->scatter = ARENA_ARRAY(&p->arena, double, p->count);
    p->place = ARENA_ARRAY(&p->arena, PathPlace, p->count);
    for (int i = 0; i < p->count; i++) {
        Vec3 along = camera_ray(camera, i % camera->width + 0.5, i / camera->width + 0.5);
        PathHit hit = path_scene_trace(scene, vec3_sub(camera->eye, scene->origin), vec3_normalize(along));
        if (hit.face < 0 || !hit.front || mesh_emits(e->mesh, hit.face)) continue;
        double shown = shown_at(e, &field, hit.face, vec3_add(hit.point, scene->origin));
        if (shown < 0) continue;  // reflects nothing in some channel: what arrives there is not shown
        p->pixel[p->seen] = i;
        p->shown[p->seen] = shown;
        p->place[p->seen++] =
            (PathPlace){path_scene_before(scene, hit.face, hit.point), e->mesh->faces[hit.face].plane.n};
    }
    arena_free(&scratch);
}

static void trace_pixel(void *context, int index, int thread) {
    (void)thread;
    const Tracing *t = context;
    double sum = 0, squares = 0;
    for (int b = 0; b < BLOCKS; b++) {
        PathNumbers numbers = path_numbers(t->seed + (uint64_t)index, b);
        double light[3] = {0, 0, 0};
        for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++) {
            double weight[3] = {1, 1, 1};
            path_walk(t->world, t->pixels->place[index], &numbers, 0, NULL, weight, light);
        }
        double mean = (light[0] + light[1] + light[2]) / PATH_BLOCK;
        sum += mean;
        squares += mean * mean;
    }
    double mean = sum / BLOCKS, variance = fmax(squares / BLOCKS - mean * mean, 0);
    t->pixels->truth[index] = mean;
    t->pixels->scatter[index] = sqrt(variance / (BLOCKS - 1));
}

static void look_and_trace(const ErrorPicture *e, const Camera *camera, Pixels *p) {
    Arena scratch = {0};
    PathWorld world = path_world(e->mesh, e->solution->sky, &scratch);
    Tracing tracing = {&world, p, e->seed};
    look_through_pixels(e, camera, world.scene, p);
    parallel_for(parallel_threads(0), p->seen, trace_pixel, &tracing);
    path_world_end(&world);
    arena_free(&scratch);
}

static void put_colour(uint8_t out[3], Rgb c) {
    out[0] = (uint8_t)lrintf(255 * c.r);
    out[1] = (uint8_t)lrintf(255 * c.g);
    out[2] = (uint8_t)lrintf(255 * c.b);
}

static void colour(const Pixels *p, uint8_t *rgb, ErrorPictureFound *found) {
    double mean = 0, squares = 0, scatter = 0;
    for (int i = 0; i < p->seen; i++) mean += p->truth[i] / p->seen;
    memset(rgb, NOTHING, (size_t)p->count * 3);
    for (int i = 0; i < p->seen; i++) {
        double scale = fmax(p->truth[i], DARK * mean), off = (p->shown[i] - p->truth[i]) / scale;
        put_colour(rgb + 3 * p->pixel[i], false_colour_signed(off / ENDS));
        squares += off * off;
        scatter += p->scatter[i] / scale * p->scatter[i] / scale;
    }
    int seen = p->seen > 0 ? p->seen : 1;
    *found = (ErrorPictureFound){100 * sqrt(squares / seen), 100 * sqrt(scatter / seen)};
}

// ---- the legend

static unsigned hex_of(Rgb c) {
    uint8_t v[3];
    put_colour(v, c);
    return (unsigned)v[0] << 16 | (unsigned)v[1] << 8 | v[2];
}

// A bar from what is too dark to what is too bright, its numbers below.
static bool write_legend(const char *folder, Error *error) {
    enum { WIDTH = 480, STEPS = 80, TICKS = 4 };
    Arena arena = {0};
    SvgDrawing *svg = svg_begin(&arena, (Box){{-1.5, -0.1, 0}, {1.5, 0.1, 0}}, WIDTH);
    Draw draw = svg_draw(svg);
    for (int i = 0; i < STEPS; i++) {
        double x = -1 + 2.0 * i / STEPS, next = x + 2.0 / STEPS;
        DrawStyle fill = {.fill = hex_of(false_colour_signed((x + next) / 2)), .fill_opacity = 1};
        Vec2 v[4] = {{x, 0}, {next, 0}, {next, 0.08}, {x, 0.08}};
        draw.polygon(draw.context, v, 4, &fill);
    }
    for (int i = -TICKS; i <= TICKS; i += 2) {
        double x = (double)i / TICKS;
        const char *end = i == -TICKS ? "too dark " : i == TICKS ? "too bright " : "";
        draw.text(draw.context, (Vec2){x, -0.05}, 0.06, 0,
                  i == 0 ? "0" : arena_format(&arena, "%s%+.0f %%", end, 100 * ENDS * x));
    }
    const char *text = svg_end(svg), *path = arena_format(&arena, "%s/light-error-scale.svg", folder);
    bool good = file_write(path, text, strlen(text), error);
    arena_free(&arena);
    return good;
}

// Writes DIR/NAME-error.png, and DIR/light-error-scale.svg, its legend. Pixels that show lamps, backs or nothing are grey.
static bool error_picture(const ErrorPicture *e, const Camera *camera, const char *folder, const char *name,
                          ErrorPictureFound *found, Error *error) {
    Pixels p = {.arena = {0}};
    look_and_trace(e, camera, &p);
    uint8_t *rgb = ARENA_ARRAY(&p.arena, uint8_t, 3 * p.count);
    colour(&p, rgb, found);
    const char *path = arena_format(&p.arena, "%s/%s-error.png", folder, name);
    bool good = file_make_folder(folder, error) &&
                image_write_png(path, rgb, camera->width, camera->height, error) &&
                write_legend(folder, error);
    arena_free(&p.arena);
    return good;
}

static const char HEAD[] =
    "building,configuration,element_m,per_patch,culling,row_mb,residual,resolution,elements,patches,shots,"
    "rows_made,bake_seconds,probe_seconds,"
    "gather_median,gather_rms,gather_p90,gather_max,gather_lit_median,gather_lit_rms,gather_mean_rms,"
    "element_median,element_rms,element_p90,element_max,element_lit_median,element_lit_rms,element_mean_rms,"
    "vertex_median,vertex_rms,vertex_p90,vertex_max,vertex_lit_median,vertex_lit_rms,vertex_mean_rms,"
    "points,points_reflecting,points_dark,truth_error,bake_work_seconds\n";

// ---- ways to bake

typedef struct Way {
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
} Way;

static const Way WAYS[] = {
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

static void apply(const Way *way, LightBake *bake) {
    MeshOptions *mesh = &bake->options;
    RadOptions *rad = &bake->rad;
    if (way->share != 0) bake->adapt.share = fmax(way->share, 0);
    if (way->reach != 0) rad->reach = fmax(way->reach, 0);
    if (way->close != 0) mesh->close = fmax(way->close, 0);
    if (way->proxy != 0) mesh->proxy = fmax(way->proxy, 0);
    if (way->element > 0) mesh->element = way->element;
    if (way->per_patch > 0) mesh->per_patch = way->per_patch;
    if (way->unculled) rad->culling = CULL_NOTHING;
    if (way->keeps_no_rows) rad->row_bytes = 0;
    if (way->residual > 0) rad->residual = way->residual;
    if (way->resolution > 0) rad->form_factor.resolution = way->resolution;
    bake->gather = way->gather;
}

// ---- errors

typedef struct Spread {
    double median, rms, p90, most;  // percent
    int count;
} Spread;

static bool is_lit(const LightPoint *p) { return light_point_irradiance(p) >= p->scale; }

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

// The spread over all points, or over the points that are lit.
static Spread spread_of(const LightPoints *points, const double *off, bool lit) {
    int count = points->count;
    Arena scratch = {0};
    double *size = ARENA_ARRAY(&scratch, double, count + 1), squares = 0;
    Spread s = {0};
    for (int i = 0; i < count; i++) {
        const LightPoint *p = &points->points[i];
        if (!isnan(off[i]) && (!lit || is_lit(p))) size[s.count++] = fabs(off[i] / p->scale);
    }
    qsort(size, (size_t)s.count, sizeof *size, by_size);
    for (int i = 0; i < s.count; i++) squares += size[i] * size[i];
    if (s.count > 0) {
        s.median = 50 * (size[(s.count - 1) / 2] + size[s.count / 2]);
        s.rms = 100 * sqrt(squares / s.count);
        s.p90 = 100 * size[(int)(0.9 * (s.count - 1) + 0.5)];
        s.most = 100 * size[s.count - 1];
    }
    arena_free(&scratch);
    return s;
}

static double truth_error(const LightPoints *points, int *dark) {
    double sum = 0;
    *dark = 0;
    for (int i = 0; i < points->count; i++) {
        const LightPoint *p = &points->points[i];
        sum += p->standard_error / p->scale * p->standard_error / p->scale;
        *dark += !is_lit(p);
    }
    return 100 * sqrt(sum / points->count);
}

// ---- what is written

static void print_worst(const LightScene *s, const Way *way, int what, const double *off) {
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

static void add_light_row(const LightScene *s, const Way *way, const LightBake *bake,
                          const LightErrors *errors, Text *csv) {
    size_t before = csv->size;
    text_append(csv, "%s,%s,%g,%d,%s,%zu,%g,%d,%d,%d,%lld,%lld,%.4f,%.4f", bench_name(s->file), way->name,
                bake->options.element, bake->options.per_patch, VIEW_CULLING_NAMES[bake->rad.culling],
                bake->rad.row_bytes >> 20, bake->rad.residual, bake->rad.form_factor.resolution,
                bake->mesh.element_count, bake->mesh.patch_count, bake->report.shots, bake->report.rows_made,
                bake->seconds, errors->gather_seconds);
    int reflecting = 0, dark;
    for (int what = 0; what < LIGHT_COMPARED; what++) {
        const double *off = errors->off[what];
        Spread all = spread_of(&s->points, off, false), lit = spread_of(&s->points, off, true);
        text_append(csv, ",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f", all.median, all.rms, all.p90, all.most,
                    lit.median, lit.rms, light_errors_rms(s, off));
        reflecting = all.count;
        if (s->arguments->verbose) print_worst(s, way, what, off);
    }
    double uncertain = truth_error(&s->points, &dark);
    text_append(csv, ",%d,%d,%d,%.4f,%.4f\n", s->points.count, reflecting, dark, uncertain,
                bake->work_seconds);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

// From the first stored viewpoint, or where one begins.
static bool draw_errors(const LightScene *s, const Way *way, const LightBake *bake, Error *error) {
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

static bool bench_way(const LightScene *s, const Way *way, Text *csv, Error *error) {
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
    return bench_table(&own, HEAD, NULL, light_of_file, error);
}

static const Option ROWS[] = {
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
    BENCH_OPTIONS(ROWS),
    .run = measure_light,
    .is_method = is_light_method,
    .print_methods = print_ways,
    .files = BENCH_LIT_FILES,
};
