// bench_light.c - the error of the light of a bake at random points, against path tracing, and its time, for several ways to bake.
//
// Errors are relative to the irradiance, or to a hundredth of the mean of all points where that is more; the last of each three also
// to the mean.
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/bake_probes.h"
#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/draw.h"
#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/draw/false_colour.h"
#include "engine/draw/image.h"
#include "engine/scene/bake_mesh.h"
#include "engine/scene/door_state.h"
#include "radiosity/shoot/adapt.h"
#include "radiosity/shoot/shoot.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"
#include "radiosity/truth/path_tracer.h"
#include "radiosity/truth/path_walk.h"
#include "visibility/hidden/hidden.h"

typedef struct LightPoint {
    Vec3 place, normal;
    int polygon;                      // of the graph
    double truth[3], standard_error;  // irradiance, W/m^2 a channel; of the sum of the channels
    double scale;                     // of relative errors, W/m^2
} LightPoint;

typedef struct LightPoints {
    LightPoint *points;  // [count]
    int count;
    double mean;  // irradiance, W/m^2, the sum of the channels
    long long paths;
    double seconds;  // of path tracing, all cores
} LightPoints;

// The standard error of the truth is a share of the irradiance at the point, or of a hundredth of the mean of all points where
// that is more, so that points in the dark do not decide; or of the mean.
typedef enum LightTruth { LIGHT_TRUTH_EACH, LIGHT_TRUTH_MEAN } LightTruth;

static inline double light_point_irradiance(const LightPoint *p) {
    return p->truth[0] + p->truth[1] + p->truth[2];
}

typedef struct LightScene {
    const char *file;
    const BenchArguments *arguments;
    LoadedScene scene;
    float *doors;  // [opening_count] as drawn
    LightPoints points;
} LightScene;

// The options of a bake, and its results.
typedef struct LightBake {
    MeshOptions options;
    AdaptOptions adapt;
    RadOptions rad;
    int gather;  // resolution of a final gather at all vertices; 0: none
    Mesh mesh;
    RadSolution solution;
    RadReport report;
    const FineMesh *fine;  // the mesh that is shown; `shown` is its light
    RadSolution shown;
    double mesh_seconds, seconds;  // all is `seconds`
    double work_seconds;           // of all threads
} LightBake;

// Three values are compared with the truth: the light that a point gathers, as by `bake --probe`; and the solution itself at
// the point, (B - E) / rho, once from the element there and once between its corners, which a walk shows.
enum { LIGHT_GATHERED, LIGHT_OF_ELEMENT, LIGHT_BETWEEN_CORNERS, LIGHT_COMPARED };
extern const char *const LIGHT_COMPARED_NAMES[LIGHT_COMPARED];

typedef struct LightErrors {
    double *off[LIGHT_COMPARED];  // [points.count] W/m^2, signed; NAN where there is nothing to compare
    double gather_seconds;
} LightErrors;

// ---- points spread by area over the elements of patches that look into rooms; path tracing in two rounds, the first
// of which tells how bright the building is.

// Beyond so many paths a point stays as uncertain as it is.
static const long long MOST_PATHS = 4000000;
// Points with less light than this share of the mean are measured against it.
static const double DARK = 0.01;
// A face nearer than this lies against a point, metres.
static const double TOUCHING = 0.001;
// Tries for each point.
enum { TRIES = 1000 };

static bool is_indoors(const Mesh *mesh, const Element *element) {
    int cell = mesh->patches[element->patch].cell;
    return cell >= 0 && vis_region(mesh->graph, cell)->kind != REGION_OUTDOORS;
}

// Evenly over a convex element, in triangles about its first corner.
static Vec3 point_in(const Mesh *mesh, const Element *element, Random *random) {
    const int *corner = mesh->corners + element->first_corner;
    Vec3 first = mesh->vertices[corner[0]];
    double left = random_unit(random) * element->area;
    for (int i = 1;; i++) {
        Vec3 a = vec3_sub(mesh->vertices[corner[i]], first);
        Vec3 b = vec3_sub(mesh->vertices[corner[i + 1]], first);
        double area = 0.5 * vec3_length(vec3_cross(a, b));
        bool last = i + 2 == element->corner_count;
        if (left > area && !last) {
            left -= area;
            continue;
        }
        double along = random_unit(random), far = sqrt(random_unit(random));
        return vec3_add(first, vec3_scale(vec3_lerp(a, b, along), far));
    }
}

// The first element up to which the areas exceed `at`.
static int element_up_to(const double *up_to, int count, double at) {
    int low = 0, high = count - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (up_to[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static bool is_near_view(const Building *building, Vec3 place, double near) {
    for (int i = 0; i < building->viewpoint_count; i++)
        if (vec3_length(vec3_sub(building->viewpoints[i].eye, place)) <= near) return true;
    return false;
}

// Chooses points evenly, by area, over the fronts of surfaces in rooms, but not at places that nobody sees: where only backs are
// before the front, or another front lies against it. Every other point lies within `near` of a view that the building stores, if
// that is not 0. Fails where there are no such places.
static bool light_points_choose(const Mesh *mesh, int count, uint64_t seed, double near, Arena *arena,
                                LightPoints *out, Error *error) {
    Arena scratch = {0};
    double area = 0, *up_to = ARENA_ARRAY(&scratch, double, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++) {
        if (is_indoors(mesh, &mesh->elements[e])) area += mesh->elements[e].area;
        up_to[e] = area;
    }
    Random random = {seed};
    PathTracer *tracer = path_tracer_new(mesh, NULL, &scratch);
    *out = (LightPoints){.points = ARENA_ARRAY(arena, LightPoint, count)};
    for (int i = 0; i < count * TRIES && out->count < count && area > 0; i++) {
        int e = element_up_to(up_to, mesh->element_count, random_unit(&random) * area);
        const Face *face = &mesh->faces[mesh->elements[e].face];
        LightPoint point = {.place = point_in(mesh, &mesh->elements[e], &random),
                            .normal = face->plane.n,
                            .polygon = face->polygon};
        if (near > 0 && out->count % 2 && !is_near_view(mesh->graph->building, point.place, near)) continue;
        if (path_tracer_open(tracer, point.place, point.normal, TOUCHING) > 0)
            out->points[out->count++] = point;
    }
    path_tracer_end(tracer);
    arena_free(&scratch);
    if (out->count == count) return true;
    return error_set(error, "%s: has no surface in a room that light could reach",
                     mesh->graph->building->source);
}

static void take_results(LightPoints *points, const PathResult *results) {
    double sum = 0;
    points->paths = 0;
    for (int i = 0; i < points->count; i++) {
        LightPoint *p = &points->points[i];
        const double *e = results[i].standard_error;
        memcpy(p->truth, results[i].irradiance, sizeof p->truth);
        // The channels scatter together.
        p->standard_error = e[0] + e[1] + e[2];
        points->paths += results[i].paths;
        sum += light_point_irradiance(p);
    }
    points->mean = sum / points->count;
    for (int i = 0; i < points->count; i++)
        points->points[i].scale = fmax(light_point_irradiance(&points->points[i]), DARK * points->mean);
}

static void light_points_trace(const Mesh *mesh, const double radiance[3], LightTruth kind, double error,
                               uint64_t seed, LightPoints *points) {
    Arena scratch = {0};
    double begin = clock_seconds();
    Daylight day = daylight_uniform(radiance);
    PathTracer *tracer = path_tracer_new(mesh, &day, &scratch);
    PathQuery *queries = ARENA_ARRAY(&scratch, PathQuery, points->count);
    PathResult *results = ARENA_ARRAY(&scratch, PathResult, points->count);
    for (int i = 0; i < points->count; i++)
        queries[i] = (PathQuery){
            .point = points->points[i].place, .normal = points->points[i].normal, .seed = seed + (uint64_t)i};
    path_tracer_irradiance(tracer, queries, points->count, 0, results);
    take_results(points, results);
    int asked = 0, *which = ARENA_ARRAY(&scratch, int, points->count);
    PathResult *again = ARENA_ARRAY(&scratch, PathResult, points->count);
    for (int i = 0; i < points->count; i++) {
        const LightPoint *p = &points->points[i];
        double most = error * (kind == LIGHT_TRUTH_MEAN ? points->mean : p->scale);
        if (kind == LIGHT_TRUTH_MEAN && p->standard_error <= most) continue;
        which[asked] = i;
        queries[asked] = queries[i];
        queries[asked].absolute_error = most;
        queries[asked++].most_paths = MOST_PATHS;
    }
    path_tracer_irradiance(tracer, queries, asked, 0, again);
    for (int i = 0; i < asked; i++) results[which[i]] = again[i];
    take_results(points, results);
    path_tracer_end(tracer);
    points->seconds = clock_seconds() - begin;
    arena_free(&scratch);
}

// ---- a building for the benches of light: read, lit by path tracing at random points, baked, and compared there.

const char *const LIGHT_COMPARED_NAMES[LIGHT_COMPARED] = {"gather", "element", "vertex"};

// Edge of the elements that points are chosen on, metres: a mesh of their own, so that they stay where they are whatever the
// default becomes.
static const double CHOSEN_ON = 1;

static bool make_points(LightScene *s, LightTruth kind, Arena *arena, Error *error) {
    Arena scratch = {0};
    MeshOptions options = mesh_default_options();
    options.element = CHOSEN_ON;
    Mesh mesh;
    const BenchArguments *a = s->arguments;
    bool good = mesh_build(&s->scene.graph, s->doors, &options, &scratch, &mesh, error) &&
                light_points_choose(&mesh, a->points, a->seed, a->near, arena, &s->points, error);
    if (good) {
        light_points_trace(&mesh, a->sky, kind, a->error, a->seed, &s->points);
        fprintf(stderr, "%s: %lld paths to %d points in %.1f s, mean irradiance %.4g W/m^2\n",
                bench_name(s->file), s->points.paths, s->points.count, s->points.seconds, s->points.mean);
    }
    arena_free(&scratch);
    return good;
}

static bool light_scene_load(const char *file, const BenchArguments *a, Arena *arena, LightScene *out,
                             Error *error) {
    *out = (LightScene){.file = file, .arguments = a};
    SceneOptions options = a->load;
    options.lamps = SCENE_LAMPS_ALL;
    if (!app_load(file, &options, arena, &out->scene, error) || !scene_has_walls(&out->scene, error))
        return false;
    out->doors = door_state_drawn(&out->scene.building, arena);
    return true;
}

// Its points are chosen, `kind` says how well each is to be known.
static bool light_scene_open(const char *file, const BenchArguments *a, LightTruth kind, Arena *arena,
                             LightScene *out, Error *error) {
    return light_scene_load(file, a, arena, out, error) && make_points(out, kind, arena, error);
}

// ---- a bake

// The options that `enfilade bake` has without any.
static void light_bake_defaults(const LightScene *scene, LightBake *out) {
    *out = (LightBake){
        .options = mesh_default_options(), .adapt = adapt_default_options(), .rad = rad_default_options()};
    out->options.element = mesh_fitting_element(&scene->scene.graph);
    out->rad.residual = 0;
    out->rad.form_factor.resolution = 0;
    out->rad.row_bytes = RAD_ROWS_FIT;
    out->adapt.day = daylight_uniform(scene->arguments->sky);
}

// Gathers light at all vertices: then the value between corners shows the quality of the final gather.
static void gather_vertices(const LightScene *s, LightBake *bake, Arena *arena) {
    Arena scratch = {0};
    VertexLight light = reconstruct_light(&bake->mesh, &bake->solution, &scratch);
    GatherScene scene = {&bake->mesh, &s->scene.forest, s->doors, &bake->solution, &light};
    GatherOptions options = gather_default_options();
    options.resolution = bake->gather;
    final_gather(&scene, &options, 0, NULL, arena, &bake->solution);
    arena_free(&scratch);
}

static bool light_bake(const LightScene *s, Arena *arena, LightBake *bake, Error *error) {
    const CellGraph *graph = &s->scene.graph;
    AdaptScene lit = {graph, &s->scene.forest, s->doors};
    Mesh *mesh = &bake->mesh;
    Daylight day = daylight_uniform(s->arguments->sky);
    double begin = clock_seconds(), worked = clock_work_seconds();
    bake->options.proxies = proxies_find(graph, bake->options.proxy, arena);
    bool good = bake->adapt.share > 0
                    ? adapt_mesh(&lit, &bake->options, &bake->adapt, &bake->rad, NULL, arena, mesh, error)
                    : mesh_build(graph, s->doors, &bake->options, arena, mesh, error);
    if (!good || !rad_start_dark(mesh, arena, &bake->solution, error)) return false;
    bake->mesh_seconds = clock_seconds() - begin;
    rad_fit(mesh, &bake->rad);
    if (daylight_shines(&day))
        rad_shine(mesh, &s->scene.forest, s->doors, &bake->rad, &day, NULL, &bake->solution);
    bake->report = rad_shoot(mesh, &s->scene.forest, s->doors, &bake->rad, NULL, &bake->solution);
    if (bake->gather > 0) gather_vertices(s, bake, arena);
    bake->fine = fine_mesh_new(mesh, arena);
    bake->shown = fine_light(bake->fine, &bake->solution, arena);
    bake->seconds = clock_seconds() - begin;
    bake->work_seconds = clock_work_seconds() - worked;
    return true;
}

// ---- errors

// The irradiance, from the reflected light. Channels that the material does not reflect count as right.
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

static void gather_points(const LightScene *s, const LightBake *bake, int gathering, LightErrors *out) {
    Arena scratch = {0};
    Probes probes = {ARENA_ARRAY(&scratch, Probe, gathering + 1), gathering, gathering};
    for (int i = 0; i < gathering; i++)
        probes.probes[i] = (Probe){.place = s->points.points[i].place, .normal = s->points.points[i].normal};
    double begin = clock_seconds();
    GatherScene scene = {&bake->fine->mesh, &s->scene.forest, s->doors, &bake->shown, NULL};
    if (gathering > 0) bake_probes_gather(&scene, &probes);
    out->gather_seconds = clock_seconds() - begin;
    for (int i = 0; i < gathering; i++) {
        const double *h = probes.probes[i].irradiance;
        out->off[LIGHT_GATHERED][i] = h[0] + h[1] + h[2] - light_point_irradiance(&s->points.points[i]);
    }
    arena_free(&scratch);
}

// The first so many points gather.
static LightErrors light_errors(const LightScene *s, const LightBake *bake, int gathering, Arena *arena) {
    LightErrors out = {0};
    Arena scratch = {0};
    const Mesh *mesh = &bake->fine->mesh;
    VertexLight field = reconstruct_light(mesh, &bake->shown, &scratch);
    for (int what = 0; what < LIGHT_COMPARED; what++)
        out.off[what] = ARENA_ARRAY(arena, double, s->points.count);
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        int face = mesh->face_of[p->polygon];
        const Material *m = mesh_material(mesh, face);
        const double *own = bake->shown.radiosity[mesh_element_at(mesh, face, p->place)];
        double light[3], truth = light_point_irradiance(p);
        reconstruct_at(mesh, &field, face, p->place, light);
        out.off[LIGHT_GATHERED][i] = NAN;
        out.off[LIGHT_OF_ELEMENT][i] = reflects(m) ? irradiance_of(p, m, own) - truth : NAN;
        out.off[LIGHT_BETWEEN_CORNERS][i] = reflects(m) ? irradiance_of(p, m, light) - truth : NAN;
    }
    arena_free(&scratch);
    gather_points(s, bake, gathering < s->points.count ? gathering : s->points.count, &out);
    return out;
}

// The scatter of the truth itself is no error of ours.
static double light_errors_rms(const LightScene *s, const double *off) {
    double squares = 0, scatter = 0;
    int count = 0;
    for (int i = 0; i < s->points.count; i++) {
        double uncertain = s->points.points[i].standard_error;
        if (isnan(off[i])) continue;
        squares += off[i] * off[i];
        scatter += uncertain * uncertain;
        count++;
    }
    return count > 0 && s->points.mean > 0 ? 100 * sqrt(fmax(squares - scatter, 0) / count) / s->points.mean
                                           : 0;
}

typedef struct ErrorPicture {
    const Mesh *mesh;
    const RadSolution *solution;
    uint64_t seed;
} ErrorPicture;

// Roots of mean squares over the pixels, percent.
typedef struct ErrorPictureFound {
    double rms, noise;  // of the shown light against the truth; of the standard error of the truth
} ErrorPictureFound;

// The ends of the scale, relative: a greater error looks like an error of this size.
static const double ENDS = 0.2;
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
        PathHit hit =
            path_scene_trace(scene, vec3_sub(camera->eye, path_scene_origin(scene)), vec3_normalize(along));
        if (hit.face < 0 || !hit.front || mesh_emits(e->mesh, hit.face)) continue;
        double shown = shown_at(e, &field, hit.face, vec3_add(hit.point, path_scene_origin(scene)));
        if (shown < 0) continue;  // no reflection in some channel: its irradiance is not shown
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
            path_walk(t->world, t->pixels->place[index], &numbers, 0, NULL, NULL, weight, light);
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
    PathWorld world = path_world(e->mesh, &e->solution->day, &scratch);
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

// Draws a bar from too dark to too bright, with numbers below.
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

// ---- the elements that adaptive meshes save: elements against error, from coarse to fine, for three kinds of meshes: even meshes,
// even meshes that are cut where objects stand on their faces, and cut meshes that are as fine as their light requires; and how
// many elements an even mesh would need for the same error.
//
// The error is that of the field: the root of the mean square, over all surfaces, of the error of the irradiance, relative to the
// mean irradiance (against path tracing at random points, evenly by area). It is measured for the light of the elements, for the
// light between their corners, which is shown, and for the light that the first points gather.

static const char MESHES_HEAD[] =
    "building,mesh,element_m,elements,patches,mesh_seconds,bake_seconds,element_rms,vertex_rms,gather_rms,"
    "of_even_element,of_even_vertex,of_even_gather,points,points_gathering,truth_error\n";

// Edges of elements, relative to the edge that fits the building. Even meshes go on to finer elements, so that their errors come
// down to those of the other kinds.
static const double SCALES[] = {4, 2.8, 2, 1.4, 1, 0.7};
enum { SCALE_COUNT = sizeof SCALES / sizeof *SCALES, MOST_GATHERING = 100 };

enum { EVEN, CUT, ADAPTIVE, KINDS };
static const struct {
    const char *name;
    int scales;
} KIND[KINDS] = {{"even", SCALE_COUNT}, {"cut", SCALE_COUNT - 1}, {"adaptive", SCALE_COUNT - 1}};

typedef struct Size {
    double elements, rms[LIGHT_COMPARED];
} Size;

typedef struct Curve {
    Size sizes[SCALE_COUNT];  // ever more elements
    int count;
} Curve;

// How many elements the curve takes for that error, between its sizes as powers of each other; 0: outside of them.
static double elements_at(const Curve *curve, int what, double rms) {
    for (int i = curve->count - 1; i > 0; i--) {
        const Size *coarse = &curve->sizes[i - 1], *fine = &curve->sizes[i];
        double high = coarse->rms[what], low = fine->rms[what];
        if (!(rms >= low && rms <= high && high > low)) continue;
        double along = log(rms / high) / log(low / high);
        return coarse->elements * pow(fine->elements / coarse->elements, along);
    }
    return 0;
}

static void add_meshes_row(const LightScene *s, const LightBake *bake, int kind, const Size *size,
                           const Curve *even, Text *csv) {
    size_t before = csv->size;
    text_append(csv, "%s,%s,%g,%d,%d,%.4f,%.4f", bench_name(s->file), KIND[kind].name, bake->options.element,
                bake->mesh.element_count, bake->mesh.patch_count, bake->mesh_seconds, bake->seconds);
    static const int ORDER[] = {LIGHT_OF_ELEMENT, LIGHT_BETWEEN_CORNERS, LIGHT_GATHERED};
    for (int k = 0; k < LIGHT_COMPARED; k++) text_append(csv, ",%.4f", size->rms[ORDER[k]]);
    for (int k = 0; k < LIGHT_COMPARED; k++) {
        double like = kind != EVEN ? elements_at(even, ORDER[k], size->rms[ORDER[k]]) : 0;
        if (like > 0)
            text_append(csv, ",%.3f", size->elements / like);
        else
            text_append(csv, ",");
    }
    const LightPoints *points = &s->points;
    double squares = 0;
    for (int i = 0; i < points->count; i++)
        squares += points->points[i].standard_error * points->points[i].standard_error;
    text_append(csv, ",%d,%d,%.4f\n", points->count,
                points->count < MOST_GATHERING ? points->count : MOST_GATHERING,
                100 * sqrt(squares / points->count) / points->mean);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

static bool bench_size(const LightScene *s, int kind, double scale, Curve *curves, Text *csv, Error *error) {
    Arena arena = {0};
    LightBake bake;
    light_bake_defaults(s, &bake);
    bake.options.element *= scale;
    bake.adapt.few = 0;
    if (kind == EVEN) bake.options.close = 0;
    if (kind != ADAPTIVE) bake.adapt.share = 0;
    bool good = light_bake(s, &arena, &bake, error);
    if (good) {
        LightErrors errors = light_errors(s, &bake, MOST_GATHERING, &arena);
        Curve *curve = &curves[kind];
        Size *size = &curve->sizes[curve->count++];
        size->elements = bake.mesh.element_count;
        for (int what = 0; what < LIGHT_COMPARED; what++)
            size->rms[what] = light_errors_rms(s, errors.off[what]);
        add_meshes_row(s, &bake, kind, size, &curves[EVEN], csv);
    }
    arena_free(&arena);
    return good;
}

static bool meshes_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Arena arena = {0};
    LightScene s;
    Curve curves[KINDS] = {0};
    bool good = light_scene_open(file, a, LIGHT_TRUTH_MEAN, &arena, &s, error);
    for (int kind = 0; kind < KINDS; kind++)
        for (int i = 0; i < KIND[kind].scales && good; i++)
            good = bench_size(&s, kind, SCALES[i], curves, csv, error);
    arena_free(&arena);
    return good;
}

static bool measure_meshes(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.points == 0) own.points = 500;
    if (own.error == 0) own.error = 0.03;
    return bench_table(&own, MESHES_HEAD, NULL, meshes_of_file, error);
}

static const Option MESHES_ROWS[] = {
    BENCH_POINTS("500"),
    BENCH_ERROR("standard error of the truth, of the mean irradiance, @ (default 0.03)"),
    BENCH_SEED("of points and paths"),
    BENCH_SKY,
    BENCH_CSV,
};

const Bench BENCH_MESHES = {
    .name = "meshes",
    .about =
        "what adaptive meshes save: elements against error, from coarse to fine, of even meshes, of even "
        "ones "
        "cut where things stand (cut) and of those that `enfilade bake` makes (adaptive); the root of the "
        "mean square, over all surfaces, of the error of the irradiance, percent of its mean: element_: as "
        "elements hold it, vertex_: between corners, gather_: of the first 100 points; of_even_: elements, "
        "of "
        "those that an even mesh needs for the same error",
    BENCH_OPTIONS(MESHES_ROWS),
    .run = measure_meshes,
    .files = BENCH_LIT_FILES,
};

// ---- narrow places: the light that a walk shows and the light that --probe gathers, against path tracing, at points half of which lie
// near the views of a building. Points and truth are kept beside each building, in a file that ends in .ref: a line each of polygon,
// place, normal, irradiance and its standard error.

static const char NARROW_HEAD[] =
    "scene,method,elements,seconds,median,rms,p99,most,near_median,near_rms,near_p99,worst_room,points,"
    "truth_error\n";

enum { NARROW_SHOWN, NARROW_PROBE, NARROW_FINAL_GATHER, NARROW_METHODS, NARROW_WORST = 6, GATHERED = 50 };
static const char *const NARROW_NAMES[NARROW_METHODS] = {"shown", "probe", "final-gather"};

static bool is_narrow_method(const char *name) {
    for (int i = 0; i < NARROW_METHODS; i++)
        if (strcmp(NARROW_NAMES[i], name) == 0) return true;
    return false;
}

static void print_narrow_methods(void) {
    printf("    ways:               ");
    for (int i = 0; i < NARROW_METHODS; i++)
        printf("%s%s", NARROW_NAMES[i], i + 1 < NARROW_METHODS ? ", " : "\n");
}

// `building.plan` has `building.ref`.
static const char *truth_path(const char *file, Arena *arena) {
    const char *dot = strrchr(file, '.');
    return arena_format(arena, "%.*s.ref", (int)(dot ? dot - file : (ptrdiff_t)strlen(file)), file);
}

static bool keep_truth(const LightScene *s, Error *error) {
    Arena scratch = {0};
    Text text = {.arena = &scratch};
    text_append(
        &text, "# polygon, place, normal, irradiance and its standard error: enfilade bench narrow --keep\n");
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        text_append(&text, "%d %.17g %.17g %.17g %.17g %.17g %.17g %.6g %.2g\n", p->polygon, p->place.x,
                    p->place.y, p->place.z, p->normal.x, p->normal.y, p->normal.z, light_point_irradiance(p),
                    p->standard_error);
    }
    bool good = file_write(truth_path(s->file, &scratch), text.data, text.size, error);
    arena_free(&scratch);
    return good;
}

// Sums of channels are kept alone, so they count as light of one channel.
static bool read_truth(LightScene *s, Arena *arena, Error *error) {
    enum { LARGEST = 1 << 24 };
    Bytes bytes;
    const char *path = truth_path(s->file, arena);
    if (!file_read(path, LARGEST, arena, &bytes, error)) return false;
    LightPoints *points = &s->points;
    *points = (LightPoints){.points = ARENA_ARRAY(arena, LightPoint, bytes.size / 18 + 1)};
    for (char *line = strtok((char *)bytes.data, "\n"); line; line = strtok(NULL, "\n")) {
        LightPoint p = {0};
        if (*line == '#') continue;
        if (sscanf(line, "%d %lf %lf %lf %lf %lf %lf %lf %lf", &p.polygon, &p.place.x, &p.place.y, &p.place.z,
                   &p.normal.x, &p.normal.y, &p.normal.z, &p.truth[0], &p.standard_error) != 9 ||
            p.polygon < 0 || p.polygon >= s->scene.graph.polygon_count)
            return error_set(error, "%s: holds `%s` (allowed: a polygon of %s and 8 numbers)", path, line,
                             s->file);
        points->points[points->count++] = p;
        points->mean += p.truth[0];
    }
    if (points->count == 0) return error_set(error, "%s: holds no points", path);
    points->mean /= points->count;
    for (int i = 0; i < points->count; i++)
        points->points[i].scale = fmax(points->points[i].truth[0], DARK * points->mean);
    return true;
}

// The light that a walk shows, less the truth: exact light of lamps at nodes, or all light gathered at nodes, and linear between them.
static bool narrow_shown(const LightScene *s, LightBake *bake, bool final_gather, double *off, Arena *arena,
                         Error *error) {
    const Mesh *mesh;
    const RadSolution *light;
    if (final_gather)
        gather_vertices(s, bake, arena);
    else
        direct_show(&bake->mesh, &s->scene.forest, s->doors, 0, NULL, arena, &bake->solution, NULL);
    if (!shown_light(&bake->mesh, &bake->solution, s->doors, arena, &mesh, &light, error)) return false;
    bake->fine = fine_mesh_new(mesh, arena);
    bake->shown = fine_light(bake->fine, light, arena);
    VertexLight field = reconstruct_light(&bake->fine->mesh, &bake->shown, arena);
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        double b[3];
        int face = bake->fine->mesh.face_of[p->polygon];
        const Material *m = mesh_material(&bake->fine->mesh, face);
        reconstruct_at(&bake->fine->mesh, &field, face, p->place, b);
        off[i] = reflects(m) ? irradiance_of(p, m, b) - light_point_irradiance(p) : NAN;
    }
    return true;
}

// Percent, over the points near views or over all.
static Spread narrow_spread(const LightScene *s, const double *off, bool near, double *p99) {
    Arena scratch = {0};
    LightPoints some = {.points = ARENA_ARRAY(&scratch, LightPoint, s->points.count + 1)};
    double *size = ARENA_ARRAY(&scratch, double, s->points.count + 1);
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        if (isnan(off[i]) || (near && !is_near_view(&s->scene.building, p->place, s->arguments->near)))
            continue;
        some.points[some.count] = *p;
        size[some.count++] = off[i];
    }
    Spread spread = spread_of(&some, size, false);
    for (int i = 0; i < some.count; i++) size[i] = fabs(size[i] / some.points[i].scale);
    qsort(size, (size_t)some.count, sizeof *size, by_size);
    *p99 = some.count > 0 ? 100 * size[(int)(0.99 * (some.count - 1) + 0.5)] : 0;
    arena_free(&scratch);
    return spread;
}

// The mean light of the points of a room, relative to its truth, of the room in which it is worst, percent. Rooms whose truth is less
// certain than KNOWN are left out.
static double worst_room(const LightScene *s, const double *off) {
    static const double KNOWN = 0.01;
    double worst = 0;
    const CellGraph *graph = &s->scene.graph;
    for (int r = 0; r < graph->building->region_count; r++) {
        double sum = 0, truth = 0, variance = 0;
        for (int i = 0; i < s->points.count; i++) {
            const LightPoint *p = &s->points.points[i];
            int cell = gather_cell(graph, p->place, p->normal, -1);
            if (isnan(off[i]) || cell < 0 || graph->cells[cell].region != r) continue;
            sum += off[i];
            truth += light_point_irradiance(p);
            variance += p->standard_error * p->standard_error;
        }
        if (graph->building->regions[r].kind != REGION_ROOM || !(truth > 0)) continue;
        if (s->arguments->verbose)
            fprintf(stderr, "%s: room %s is %+.2f %% off its truth, which is known to %.2f %%\n",
                    bench_name(s->file), graph->building->regions[r].name, 100 * sum / truth,
                    100 * sqrt(variance) / truth);
        if (sqrt(variance) <= KNOWN * truth && fabs(sum / truth) > fabs(worst)) worst = sum / truth;
    }
    return 100 * worst;
}

static void print_narrow_worst(const LightScene *s, const LightBake *bake, const char *method,
                               const double *off) {
    Arena scratch = {0};
    const Mesh *mesh = &bake->fine->mesh;
    bool *told = ARENA_ARRAY(&scratch, bool, s->points.count);
    for (int k = 0; k < NARROW_WORST; k++) {
        int worst = -1;
        for (int i = 0; i < s->points.count; i++) {
            const LightPoint *p = &s->points.points[i];
            if (told[i] || isnan(off[i])) continue;
            if (worst < 0 || fabs(off[i] / p->scale) > fabs(off[worst] / s->points.points[worst].scale))
                worst = i;
        }
        if (worst < 0) break;
        told[worst] = true;
        const LightPoint *p = &s->points.points[worst];
        const Element *e = &mesh->elements[mesh_element_at(mesh, mesh->face_of[p->polygon], p->place)];
        fprintf(stderr,
                "%s, %s: point %d, polygon %d, %.3f,%.3f,%.3f facing %.2f,%.2f,%.2f: %+.2f %% of %.4g W/m^2 "
                "(%.4g of the mean), element of %.3f m, %d corners\n",
                bench_name(s->file), method, worst, p->polygon, p->place.x, p->place.y, p->place.z,
                p->normal.x, p->normal.y, p->normal.z, 100 * off[worst] / p->scale, light_point_irradiance(p),
                light_point_irradiance(p) / s->points.mean, sqrt(e->area), e->corner_count);
    }
    arena_free(&scratch);
}

static void add_narrow_row(const LightScene *s, const LightBake *bake, int method, const double *off,
                           double seconds, Text *csv) {
    size_t before = csv->size;
    double p99, near99;
    int dark;
    Spread all = narrow_spread(s, off, false, &p99), near = narrow_spread(s, off, true, &near99);
    text_append(csv, "%s,%s,%d,%.2f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%.3f\n", bench_name(s->file),
                NARROW_NAMES[method], bake->fine->mesh.element_count, seconds, all.median, all.rms, p99,
                all.most, near.median, near.rms, near99, worst_room(s, off), all.count,
                truth_error(&s->points, &dark));
    fputs(csv->data + before, stdout);
    fflush(stdout);
    if (s->arguments->verbose) print_narrow_worst(s, bake, NARROW_NAMES[method], off);
}

static bool narrow_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Arena arena = {0};
    LightScene s;
    LightBake bake;
    bool good = a->keep
                    ? light_scene_open(file, a, LIGHT_TRUTH_EACH, &arena, &s, error) && keep_truth(&s, error)
                    : light_scene_load(file, a, &arena, &s, error);
    good = good && read_truth(&s, &arena, error);
    if (good) {
        light_bake_defaults(&s, &bake);
        good = light_bake(&s, &arena, &bake, error);
    }
    if (good && bench_listed(a->methods, "probe")) {
        LightErrors errors = light_errors(&s, &bake, s.points.count, &arena);
        add_narrow_row(&s, &bake, NARROW_PROBE, errors.off[LIGHT_GATHERED], errors.gather_seconds, csv);
    }
    for (int method = 0; method < NARROW_METHODS && good; method++) {
        double begin = clock_seconds(), *off = ARENA_ARRAY(&arena, double, s.points.count);
        if (method == NARROW_PROBE || !bench_listed(a->methods, NARROW_NAMES[method])) continue;
        LightBake shown = bake;
        shown.gather = GATHERED;
        good = narrow_shown(&s, &shown, method == NARROW_FINAL_GATHER, off, &arena, error);
        if (good) add_narrow_row(&s, &shown, method, off, bake.seconds + clock_seconds() - begin, csv);
    }
    arena_free(&arena);
    return good;
}

static bool measure_narrow(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.points == 0) own.points = 100;
    if (own.error == 0) own.error = 0.003;
    if (own.near == 0) own.near = 0.3;
    return bench_table(&own, NARROW_HEAD, NULL, narrow_of_file, error);
}

static const Option NARROW_ROWS[] = {
    BENCH_METHODS("some of the ways below (default: all)"),
    {.name = "keep",
     .type = OPTION_FLAG,
     .at = BENCH_AT(keep),
     .help = "chooses the points and traces their paths anew, and keeps both in the FILE that ends in .ref"},
    {.name = "near",
     .value = "R",
     .type = OPTION_NUMBER,
     .at = BENCH_AT(near),
     .low = 0.01,
     .high = 100,
     .help = "half of the points lie so near to a view of the building, metres, @ (default 0.3)"},
    BENCH_POINTS("100"),
    BENCH_ERROR("standard error of the truth, relative, @ (default 0.003)"),
    BENCH_SEED("of points and paths"),
    {.name = "verbose",
     .type = OPTION_FLAG,
     .at = BENCH_AT(verbose),
     .help = "the five worst points of each row on standard error"},
    BENCH_CSV,
};

const Bench BENCH_NARROW = {
    .name = "narrow",
    .about = "how right light is in narrow places, against path tracing at points half of which lie near the "
             "views "
             "of each building; percent of the irradiance there, or of a hundredth of the mean where that is "
             "more; "
             "near_: of the points near views; worst_room: the mean light of a room, where it is worst",
    BENCH_OPTIONS(NARROW_ROWS),
    .run = measure_narrow,
    .is_method = is_narrow_method,
    .print_methods = print_narrow_methods,
    .files =
        "tests/narrow/ajar.plan tests/narrow/bed.plan tests/narrow/corridor.plan tests/narrow/curtain.plan "
        "tests/narrow/niche.plan tests/narrow/shelves.plan tests/narrow/sideboard.plan "
        "tests/narrow/slit.plan tests/narrow/stairwell.plan tests/narrow/table.plan",
};
