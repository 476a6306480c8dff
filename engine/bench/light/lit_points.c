// lit_points.c - see lit_points.h.
#include "engine/bench/light/lit_points.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/app/bake_probes.h"
#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "engine/scene/door_state.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_tracer.h"

// ---- points spread by area over the elements of patches that look into rooms; path tracing in two rounds, the first
// of which tells how bright the building is.

// Beyond so many paths a point stays as uncertain as it is.
static const long long MOST_PATHS = 4000000;
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

bool lit_near_view(const Building *building, Vec3 place, double near) {
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
        if (near > 0 && out->count % 2 && !lit_near_view(mesh->graph->building, point.place, near)) continue;
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
        points->points[i].scale = fmax(light_point_irradiance(&points->points[i]), LIT_DARK * points->mean);
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

bool light_scene_load(const char *file, const BenchArguments *a, Arena *arena, LightScene *out,
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
bool light_scene_open(const char *file, const BenchArguments *a, LightTruth kind, Arena *arena,
                      LightScene *out, Error *error) {
    return light_scene_load(file, a, arena, out, error) && make_points(out, kind, arena, error);
}

// ---- a bake

// The options that `enfilade bake` has without any.
void light_bake_defaults(const LightScene *scene, LightBake *out) {
    *out = (LightBake){
        .options = mesh_default_options(), .adapt = adapt_default_options(), .rad = rad_default_options()};
    out->options.element = mesh_fitting_element(&scene->scene.graph);
    out->rad.residual = 0;
    out->rad.form_factor.resolution = 0;
    out->rad.row_bytes = RAD_ROWS_FIT;
    out->adapt.day = daylight_uniform(scene->arguments->sky);
}

// Gathers light at all vertices: then the value between corners shows the quality of the final gather.
void light_gather_vertices(const LightScene *s, LightBake *bake, Arena *arena) {
    Arena scratch = {0};
    VertexLight light = reconstruct_light(&bake->mesh, &bake->solution, &scratch);
    GatherScene scene = {&bake->mesh, &s->scene.forest, s->doors, &bake->solution, &light};
    GatherOptions options = gather_default_options();
    options.resolution = bake->gather;
    final_gather(&scene, &options, 0, NULL, arena, &bake->solution);
    arena_free(&scratch);
}

bool light_bake(const LightScene *s, Arena *arena, LightBake *bake, Error *error) {
    const CellGraph *graph = &s->scene.graph;
    AdaptScene lit = {graph, &s->scene.forest, s->doors, NULL};
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
    if (bake->gather > 0) light_gather_vertices(s, bake, arena);
    bake->fine = fine_mesh_new(mesh, arena);
    bake->shown = fine_light(bake->fine, &bake->solution, arena);
    bake->seconds = clock_seconds() - begin;
    bake->work_seconds = clock_work_seconds() - worked;
    return true;
}

// The irradiance, from the reflected light. Channels that the material does not reflect count as right.
double light_irradiance_of(const LightPoint *p, const Material *m, const double b[3]) {
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += rho[c] > 0 ? (b[c] - (double)e[c]) / (double)rho[c] : p->truth[c];
    return sum;
}

bool light_reflects(const Material *m) {
    return m->reflectance.r > 0 || m->reflectance.g > 0 || m->reflectance.b > 0;
}

static void gather_points(const LightScene *s, const LightBake *bake, int gathering, LightErrors *out) {
    Arena scratch = {0};
    Probes probes = {ARENA_ARRAY(&scratch, Probe, gathering + 1), gathering, gathering};
    for (int i = 0; i < gathering; i++)
        probes.probes[i] = (Probe){.place = s->points.points[i].place, .normal = s->points.points[i].normal};
    double begin = clock_seconds();
    GatherScene scene = {&bake->fine->mesh, &s->scene.forest, s->doors, &bake->shown, NULL};
    if (gathering > 0) bake_probes_gather(&scene, 1, &probes);
    out->gather_seconds = clock_seconds() - begin;
    for (int i = 0; i < gathering; i++) {
        const double *h = probes.probes[i].irradiance;
        out->off[LIGHT_GATHERED][i] = h[0] + h[1] + h[2] - light_point_irradiance(&s->points.points[i]);
    }
    arena_free(&scratch);
}

// The first so many points gather.
LightErrors light_errors(const LightScene *s, const LightBake *bake, int gathering, Arena *arena) {
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
        out.off[LIGHT_OF_ELEMENT][i] = light_reflects(m) ? light_irradiance_of(p, m, own) - truth : NAN;
        out.off[LIGHT_BETWEEN_CORNERS][i] =
            light_reflects(m) ? light_irradiance_of(p, m, light) - truth : NAN;
    }
    arena_free(&scratch);
    gather_points(s, bake, gathering < s->points.count ? gathering : s->points.count, &out);
    return out;
}

// The scatter of the truth itself is no error of ours.
double light_errors_rms(const LightScene *s, const double *off) {
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

// ---- their spread

static bool is_lit(const LightPoint *p) { return light_point_irradiance(p) >= p->scale; }

int lit_by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

// The spread over all points, or over the points that are lit.
Spread lit_spread(const LightPoints *points, const double *off, bool lit) {
    int count = points->count;
    Arena scratch = {0};
    double *size = ARENA_ARRAY(&scratch, double, count + 1), squares = 0;
    Spread s = {0};
    for (int i = 0; i < count; i++) {
        const LightPoint *p = &points->points[i];
        if (!isnan(off[i]) && (!lit || is_lit(p))) size[s.count++] = fabs(off[i] / p->scale);
    }
    qsort(size, (size_t)s.count, sizeof *size, lit_by_size);
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

double lit_truth_error(const LightPoints *points, int *dark) {
    double sum = 0;
    *dark = 0;
    for (int i = 0; i < points->count; i++) {
        const LightPoint *p = &points->points[i];
        sum += p->standard_error / p->scale * p->standard_error / p->scale;
        *dark += !is_lit(p);
    }
    return 100 * sqrt(sum / points->count);
}
