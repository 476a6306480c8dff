// bench_light.c - how right the light of a bake is, and what that costs: at random points, against path tracing, by ways to bake.
//
// Two things are compared with the truth: the irradiance that a point gathers from what it sees, as `bake --probe` does; and
// that of the solution itself where the point lies, (B - E) / rho, of the element and between its corners, which is what a walk
// shows. Errors are relative to the irradiance, or to a hundredth of the mean of all points where that is more.
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/bake.h"
#include "engine/app/bench.h"
#include "engine/app/light_errors.h"
#include "engine/app/light_points.h"
#include "engine/core/clock.h"
#include "radiosity/fine_mesh.h"
#include "radiosity/sky.h"

static const char HEAD[] =
    "building,configuration,element_m,per_patch,culling,row_mb,residual,resolution,elements,patches,shots,"
    "rows_"
    "made,bake_seconds,probe_seconds,"
    "gather_median,gather_rms,gather_p90,gather_max,gather_lit_median,gather_lit_rms,gather_mean_rms,"
    "element_median,element_rms,element_p90,element_max,element_lit_median,element_lit_rms,element_mean_rms,"
    "vertex_median,vertex_rms,vertex_p90,vertex_max,vertex_lit_median,vertex_lit_rms,vertex_mean_rms,"
    "points,points_reflecting,points_dark,truth_error\n";

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
    {.name = "residual-0.1", .residual = 0.1},
    {.name = "residual-0.01", .residual = 0.01},
    {.name = "residual-0.001", .residual = 0.001},
    {.name = "residual-0.0001", .residual = 1e-4},
    {.name = "resolution-50", .resolution = 50},
    {.name = "resolution-200", .resolution = 200},
    {.name = "finest", .element = 0.17, .per_patch = 1, .residual = 1e-4, .resolution = 200},
};

enum { WAY_COUNT = sizeof WAYS / sizeof *WAYS };

bool bench_light_knows(const char *name) {
    for (int i = 0; i < WAY_COUNT; i++)
        if (strcmp(WAYS[i].name, name) == 0) return true;
    return false;
}

static void apply(const Way *way, double fitting, MeshOptions *mesh, RadOptions *rad, AdaptOptions *adapt) {
    *mesh = mesh_default_options();
    mesh->element = fitting;
    *rad = rad_default_options();
    rad->residual = 0;
    rad->form_factor.resolution = 0;
    *adapt = adapt_default_options();
    if (way->share != 0) adapt->share = fmax(way->share, 0);
    if (way->reach != 0) rad->reach = fmax(way->reach, 0);
    if (way->close != 0) mesh->close = fmax(way->close, 0);
    if (way->proxy != 0) mesh->proxy = fmax(way->proxy, 0);
    if (way->element > 0) mesh->element = way->element;
    if (way->per_patch > 0) mesh->per_patch = way->per_patch;
    if (way->unculled) rad->culling = CULL_NOTHING;
    if (way->keeps_no_rows) rad->row_bytes = 0;
    if (way->residual > 0) rad->residual = way->residual;
    if (way->resolution > 0) rad->form_factor.resolution = way->resolution;
}

// ---- errors

enum { GATHERED, OF_ELEMENT, BETWEEN_CORNERS, COMPARED };
static const char *const COMPARED_NAMES[COMPARED] = {"gather", "element", "vertex"};

typedef struct LightBench {
    const char *file;
    const BenchArguments *arguments;
    AppScene scene;
    float *doors;    // [opening_count] as drawn
    Vec3 *vertices;  // the graph's, with the doors there
    LightPoints points;
    double *error[COMPARED];  // [count] relative, signed; NAN where there is nothing to compare
} LightBench;

// Irradiance from what is reflected; channels that are not count as right.
static double irradiance_of(const LightPoint *p, const Material *m, const double b[3]) {
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += rho[c] > 0 ? (b[c] - (double)e[c]) / (double)rho[c] : p->truth[c];
    return sum;
}

static bool reflects(const Material *m) {
    return m->reflectance.r > 0 || m->reflectance.g > 0 || m->reflectance.b > 0;
}

static double relative(const LightPoint *p, double irradiance) {
    return (irradiance - light_point_irradiance(p)) / p->scale;
}

// Returns the seconds that gathering took.
static double find_errors(LightBench *b, const Mesh *mesh, const RadSolution *solution) {
    Arena scratch = {0};
    int count = b->points.count;
    Probes probes = {ARENA_ARRAY(&scratch, Probe, count), count, count};
    for (int i = 0; i < count; i++)
        probes.probes[i] = (Probe){.place = b->points.points[i].place, .normal = b->points.points[i].normal};
    double begin = clock_seconds();
    VertexLight field = reconstruct_light(mesh, solution, &scratch);
    GatherScene scene = {mesh, &b->scene.forest, b->doors, solution, NULL};
    bake_probes_gather(&scene, &probes);
    double seconds = clock_seconds() - begin;
    for (int i = 0; i < count; i++) {
        const LightPoint *p = &b->points.points[i];
        int face = mesh->face_of[p->polygon];
        const Material *m = mesh_material(mesh, face);
        const double *h = probes.probes[i].irradiance;
        double light[3];
        b->error[GATHERED][i] = relative(p, h[0] + h[1] + h[2]);
        const double *own = solution->radiosity[mesh_element_at(mesh, face, p->place)];
        b->error[OF_ELEMENT][i] = reflects(m) ? relative(p, irradiance_of(p, m, own)) : NAN;
        reconstruct_at(mesh, &field, face, p->place, light);
        b->error[BETWEEN_CORNERS][i] = reflects(m) ? relative(p, irradiance_of(p, m, light)) : NAN;
    }
    arena_free(&scratch);
    return seconds;
}

typedef struct Spread {
    double median, rms, p90, most;  // percent
    int count;
} Spread;

static bool is_lit(const LightPoint *p) { return light_point_irradiance(p) >= p->scale; }

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

// Of all points, or of those that are lit.
static Spread spread_of(const LightPoints *points, const double *error, bool lit) {
    int count = points->count;
    Arena scratch = {0};
    double *size = ARENA_ARRAY(&scratch, double, count + 1), squares = 0;
    Spread s = {0};
    for (int i = 0; i < count; i++)
        if (!isnan(error[i]) && (!lit || is_lit(&points->points[i]))) size[s.count++] = fabs(error[i]);
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

// Root of the mean square of what irradiances are off, of their mean, percent.
static double mean_rms(const LightPoints *points, const double *error) {
    double squares = 0;
    int count = 0;
    for (int i = 0; i < points->count; i++) {
        if (isnan(error[i])) continue;
        double off = error[i] * points->points[i].scale;
        squares += off * off;
        count++;
    }
    return count > 0 && points->mean > 0 ? 100 * sqrt(squares / count) / points->mean : 0;
}

// ---- what is written

static void print_worst(const LightBench *b, const Way *way, int what) {
    enum { WORST = 3 };
    const CellGraph *graph = &b->scene.graph;
    int worst[WORST] = {-1, -1, -1};
    for (int k = 0; k < WORST; k++) {
        for (int i = 0; i < b->points.count; i++) {
            double e = b->error[what][i];
            bool known = isnan(e) || i == worst[0] || i == worst[1];
            if (!known && (worst[k] < 0 || fabs(e) > fabs(b->error[what][worst[k]]))) worst[k] = i;
        }
        if (worst[k] < 0) return;
        const LightPoint *p = &b->points.points[worst[k]];
        int object = 0;
        while (object + 1 < graph->object_count && graph->objects[object + 1].first_polygon <= p->polygon)
            object++;
        fprintf(stderr,
                "%s, %s, %s: point %d, polygon %d of %s, %.3f,%.3f,%.3f facing %.2f,%.2f,%.2f: %+.2f %% of "
                "%.4g W/m^2\n",
                bench_name(b->file), way->name, COMPARED_NAMES[what], worst[k], p->polygon,
                graph->objects[object].name ? graph->objects[object].name : "", p->place.x, p->place.y,
                p->place.z, p->normal.x, p->normal.y, p->normal.z, 100 * b->error[what][worst[k]],
                light_point_irradiance(p));
    }
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

typedef struct Baked {
    MeshOptions mesh;
    RadOptions rad;
    RadReport report;
    int elements, patches;
    double seconds, probe_seconds;
} Baked;

static void add_row(const LightBench *b, const Way *way, const Baked *baked, Text *csv) {
    size_t before = csv->size;
    text_append(csv, "%s,%s,%g,%d,%s,%zu,%g,%d,%d,%d,%lld,%lld,%.4f,%.4f", bench_name(b->file), way->name,
                baked->mesh.element, baked->mesh.per_patch, VIEW_CULLING_NAMES[baked->rad.culling],
                baked->rad.row_bytes >> 20, baked->rad.residual, baked->rad.form_factor.resolution,
                baked->elements, baked->patches, baked->report.shots, baked->report.rows_made, baked->seconds,
                baked->probe_seconds);
    int reflecting = 0, dark;
    for (int what = 0; what < COMPARED; what++) {
        Spread s = spread_of(&b->points, b->error[what], false);
        Spread lit = spread_of(&b->points, b->error[what], true);
        text_append(csv, ",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f", s.median, s.rms, s.p90, s.most, lit.median,
                    lit.rms, mean_rms(&b->points, b->error[what]));
        reflecting = s.count;
        if (b->arguments->verbose) print_worst(b, way, what);
    }
    double uncertain = truth_error(&b->points, &dark);
    text_append(csv, ",%d,%d,%d,%.4f\n", b->points.count, reflecting, dark, uncertain);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

// From the first stored viewpoint, or where one begins.
static bool draw_errors(const LightBench *b, const Way *way, const Mesh *mesh, const RadSolution *solution,
                        Error *error) {
    const BenchArguments *a = b->arguments;
    const Building *building = &b->scene.building;
    Viewpoint v = {.eye = building->start, .yaw = building->start_yaw, .fov = 75 * M_PI / 180};
    if (building->viewpoint_count > 0) v = building->viewpoints[0];
    Camera camera = camera_look(v.eye, v.yaw, v.pitch, v.fov, a->width, a->height);
    LightErrors errors = {mesh, solution, a->seed};
    LightErrorsFound found;
    double begin = clock_seconds();
    if (!light_errors_picture(&errors, &camera, a->pictures, way->name, &found, error)) return false;
    fprintf(stderr, "%s, %s: %s/%s-error.png in %.1f s, RMS %.2f %%, noise %.2f %%\n", bench_name(b->file),
            way->name, a->pictures, way->name, clock_seconds() - begin, found.rms, found.noise);
    return true;
}

static bool bench_way(LightBench *b, const Way *way, Text *csv, Error *error) {
    Arena arena = {0};
    Mesh mesh;
    RadSolution solution;
    Baked baked = {0};
    AdaptOptions adapt;
    apply(way, mesh_fitting_element(&b->scene.graph), &baked.mesh, &baked.rad, &adapt);
    memcpy(adapt.sky, b->arguments->sky, sizeof adapt.sky);
    AdaptScene scene = {&b->scene.graph, b->vertices, &b->scene.forest, b->doors};
    double begin = clock_seconds();
    baked.mesh.proxies = proxies_find(scene.graph, scene.vertices, baked.mesh.proxy, &arena);
    bool good =
        (adapt.share > 0
             ? adapt_mesh(&scene, &baked.mesh, &adapt, &baked.rad, NULL, &arena, &mesh, error)
             : mesh_build(&b->scene.graph, b->vertices, b->doors, &baked.mesh, &arena, &mesh, error)) &&
        rad_start_dark(&mesh, &arena, &solution, error);
    if (good) {
        rad_fit(&mesh, &baked.rad);
        if (b->arguments->sky[0] + b->arguments->sky[1] + b->arguments->sky[2] > 0)
            rad_shine(&mesh, &b->scene.forest, b->doors, &baked.rad, b->arguments->sky, NULL, &solution);
        baked.report = rad_shoot(&mesh, &b->scene.forest, b->doors, &baked.rad, NULL, &solution);
        baked.seconds = clock_seconds() - begin;
        baked.elements = mesh.element_count;
        baked.patches = mesh.patch_count;
        const FineMesh *fine = fine_mesh_new(&mesh, &arena);
        RadSolution shown = fine_light(fine, &solution, &arena);
        baked.probe_seconds = find_errors(b, &fine->mesh, &shown);
        add_row(b, way, &baked, csv);
        if (b->arguments->pictures) good = draw_errors(b, way, &mesh, &solution, error);
    }
    arena_free(&arena);
    return good;
}

// Chosen on a mesh of their own, so that they stay where they are whatever the default becomes.
static bool make_points(LightBench *b, Arena *arena, Error *error) {
    Arena scratch = {0};
    MeshOptions options = mesh_default_options();
    options.element = 1;
    Mesh mesh;
    const BenchArguments *a = b->arguments;
    bool good = mesh_build(&b->scene.graph, b->vertices, b->doors, &options, &scratch, &mesh, error) &&
                light_points_choose(&mesh, a->points, a->seed, arena, &b->points, error);
    if (good) {
        light_points_trace(&mesh, a->sky, a->error, a->seed, &b->points);
        fprintf(stderr, "%s: %lld paths to %d points in %.1f s, mean irradiance %.4g W/m^2\n",
                bench_name(b->file), b->points.paths, b->points.count, b->points.seconds, b->points.mean);
    }
    arena_free(&scratch);
    return good;
}

// Is the word among the comma-separated `list` (NULL: anything is)?
static bool listed(const char *list, const char *word) {
    size_t length = strlen(word);
    for (const char *at = list; at && *at; at += strcspn(at, ","), at += *at == ',')
        if (strcspn(at, ",") == length && strncmp(at, word, length) == 0) return true;
    return !list;
}

static bool bench_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Arena arena = {0};
    LightBench b = {.file = file, .arguments = a};
    AppOptions options = app_default_options();
    options.map = a->map;
    options.lamps = true;
    bool good = app_load(file, &options, &arena, &b.scene, error) && app_has_walls(&b.scene, error);
    if (good) {
        b.doors = bake_doors(&b.scene.building, BAKE_DOORS_DRAWN, &arena);
        b.vertices = bake_vertices(&b.scene.graph, b.doors, &arena);
        good = make_points(&b, &arena, error);
    }
    for (int what = 0; what < COMPARED && good; what++)
        b.error[what] = ARENA_ARRAY(&arena, double, b.points.count);
    for (int i = 0; i < WAY_COUNT && good; i++)
        if (listed(a->methods, WAYS[i].name)) good = bench_way(&b, &WAYS[i], csv, error);
    arena_free(&arena);
    return good;
}

bool bench_light(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, NULL, bench_file, error);
}
