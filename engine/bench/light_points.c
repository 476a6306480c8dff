// light_points.c - points spread by area over the elements of patches that look into rooms; path tracing in two rounds, the first
// of which tells how bright the building is.
#include "engine/bench/light_points.h"

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "radiosity/truth/path_tracer.h"

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

bool light_points_choose(const Mesh *mesh, int count, uint64_t seed, Arena *arena, LightPoints *out,
                         Error *error) {
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

void light_points_trace(const Mesh *mesh, const double sky[3], LightTruth kind, double error, uint64_t seed,
                        LightPoints *points) {
    Arena scratch = {0};
    double begin = clock_seconds();
    PathTracer *tracer = path_tracer_new(mesh, sky, &scratch);
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
