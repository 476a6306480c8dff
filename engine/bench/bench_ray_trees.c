// bench_ray_trees.c - the hierarchy and the grid of visibility/rays and Embree on the polygons of a building: rays of a picture, rays
// anywhere, and whether anything is between two places.
//
// Times are of one thread, the least of several rounds in turn. Ours compute in doubles and let nothing through; Embree's in floats,
// one ray at a time, without its robust mode.
#include "engine/bench/bench_ray_trees.h"

#include <math.h>
#include <stdio.h>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "visibility/hidden/embree_device.h"
#include "visibility/hidden/hidden.h"
#include "visibility/rays/ray_grid.h"
#include "visibility/rays/ray_tree.h"

enum { ROUNDS = 5, SIDE = 256, COUNT = SIDE * SIDE };
// What Embree leaves out or takes twice at an edge is told apart from what differs: by so many metres along the ray.
static const double SAME = 1e-3;

typedef enum Kind { PICTURE, ANYWHERE, BETWEEN, KINDS } Kind;
static const char *const KIND_NAMES[KINDS] = {"picture", "anywhere", "between"};
typedef enum Way { OWN, GRID, EMBREE, WAYS } Way;
static const char *const WAY_NAMES[WAYS] = {"own", "grid", "embree"};

typedef struct TreeBench {
    RaySurfaces surfaces;
    SurfaceTree tree;
    SurfaceGrid grid;
    RTCDevice device;
    RTCScene embree;
    double prepare[WAYS];  // seconds
} TreeBench;

// ---- Embree

static void put_vertex(float *at, Vec3 p) { at[0] = (float)p.x, at[1] = (float)p.y, at[2] = (float)p.z; }

static void make_embree(TreeBench *b, const CellGraph *g) {
    int triangles = 0;
    for (int p = 0; p < g->polygon_count; p++) triangles += g->polygons[p].vertex_count - 2;
    b->device = embree_device_new();
    b->embree = rtcNewScene(b->device);
    rtcSetSceneBuildQuality(b->embree, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(b->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertex = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            3 * sizeof(float), (size_t)g->vertex_count);
    unsigned *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(unsigned), (size_t)triangles);
    for (int i = 0; i < g->vertex_count; i++)
        put_vertex(vertex + 3 * i, vec3_sub(g->vertices[i], b->surfaces.origin));
    for (int p = 0; p < g->polygon_count; p++) {
        unsigned first = (unsigned)g->polygons[p].first_vertex, count = (unsigned)g->polygons[p].vertex_count;
        for (unsigned k = 1; k + 1 < count; k++) {
            *index++ = first;
            *index++ = first + k;
            *index++ = first + k + 1;
        }
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(b->embree, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(b->embree);
}

static struct RTCRay embree_ray(const TreeBench *b, const Ray *ray) {
    Vec3 from = vec3_sub(ray->origin, b->surfaces.origin), d = ray->direction;
    return (struct RTCRay){.org_x = (float)from.x,
                           .org_y = (float)from.y,
                           .org_z = (float)from.z,
                           .tnear = (float)ray->near,
                           .dir_x = (float)d.x,
                           .dir_y = (float)d.y,
                           .dir_z = (float)d.z,
                           .tfar = (float)ray->far,
                           .mask = ~0u};
}

static double embree_first(const TreeBench *b, const Ray *ray) {
    struct RTCIntersectContext context;
    struct RTCRayHit hit = {.ray = embree_ray(b, ray), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcInitIntersectContext(&context);
    rtcIntersect1(b->embree, &context, &hit);
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : (double)hit.ray.tfar;
}

static bool embree_blocked(const TreeBench *b, const Ray *ray) {
    struct RTCIntersectContext context;
    struct RTCRay shadow = embree_ray(b, ray);
    rtcInitIntersectContext(&context);
    rtcOccluded1(b->embree, &context, &shadow);
    return shadow.tfar < 0;
}

// ---- rays

static Vec3 place_in(const CellGraph *g, Random *random) {
    for (;;) {
        Box box = g->cells[random_index(random, g->cell_count)].box;
        Vec3 p =
            vec3(random_between(random, box.min.x, box.max.x), random_between(random, box.min.y, box.max.y),
                 random_between(random, box.min.z, box.max.z));
        int cell = vis_locate(g, p, -1);
        if (cell >= 0 && vis_region(g, cell)->kind != REGION_OUTDOORS) return p;
    }
}

static Vec3 direction(Random *random) {
    double z = random_between(random, -1, 1), turn = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(turn), r * sin(turn), z);
}

// Pictures of 64 x 64 from 16 places; or two places of which one is reached from the other at times.
static void make_rays(const CellGraph *g, Kind kind, Ray *rays) {
    enum { PICTURE_SIDE = 64 };
    Random random = {(uint64_t)kind + 1};
    Camera camera = {0};
    for (int i = 0; i < COUNT; i++) {
        int pixel = i % (PICTURE_SIDE * PICTURE_SIDE);
        if (kind == PICTURE) {
            if (pixel == 0)
                camera = camera_look(place_in(g, &random), random_between(&random, 0, 2 * M_PI),
                                     random_between(&random, -0.3, 0.3), 1.2, PICTURE_SIDE, PICTURE_SIDE);
            Vec3 way = camera_ray(&camera, pixel % PICTURE_SIDE + 0.5, pixel / PICTURE_SIDE + 0.5);
            rays[i] = (Ray){camera.eye, vec3_normalize(way), 0, INFINITY};
            continue;
        }
        Vec3 from = place_in(g, &random);
        rays[i] =
            (Ray){from, direction(&random), 0, kind == BETWEEN ? random_between(&random, 0.5, 6) : INFINITY};
    }
}

// ---- rounds

static double first_of(const TreeBench *b, Way way, const Ray *ray) {
    if (way == EMBREE) return embree_first(b, ray);
    SurfaceHit hit = way == OWN ? surface_tree_first(&b->tree, ray) : surface_grid_first(&b->grid, ray);
    return hit.item < 0 ? INFINITY : hit.at.t;
}

static bool blocked_of(const TreeBench *b, Way way, const Ray *ray) {
    if (way == EMBREE) return embree_blocked(b, ray);
    return way == OWN ? surface_tree_blocked(&b->tree, ray) : surface_grid_blocked(&b->grid, ray);
}

static double round_of(const TreeBench *b, Way way, Kind kind, const Ray *rays, double *met) {
    double start = clock_thread_seconds();
    if (kind == BETWEEN)
        for (int i = 0; i < COUNT; i++) met[i] = blocked_of(b, way, &rays[i]) ? 1 : INFINITY;
    else
        for (int i = 0; i < COUNT; i++) met[i] = first_of(b, way, &rays[i]);
    return clock_thread_seconds() - start;
}

static void add_rows(const TreeBench *b, const char *scene, Kind kind, const Ray *rays, double *met[WAYS],
                     Text *csv) {
    double least[WAYS];
    for (int way = 0; way < WAYS; way++) least[way] = INFINITY;
    for (int round = 0; round < ROUNDS; round++)
        for (int way = 0; way < WAYS; way++)
            least[way] = fmin(least[way], round_of(b, (Way)way, kind, rays, met[way]));
    for (int way = 0; way < WAYS; way++) {
        int hits = 0, differ = 0;
        for (int i = 0; i < COUNT; i++) {
            hits += isfinite(met[way][i]);
            differ +=
                isfinite(met[way][i]) != isfinite(met[OWN][i]) || fabs(met[way][i] - met[OWN][i]) > SAME;
        }
        char row[256];
        double ns = 1e9 * least[way] / COUNT;
        snprintf(row, sizeof row, "%s %s,%s,%d,%.4f,%.3f,%.1f,,%.0f,,,,,%d,%d,\n", scene, KIND_NAMES[kind],
                 WAY_NAMES[way], COUNT, (double)hits / COUNT, 1e3 * b->prepare[way], ns, 1e9 / ns, hits,
                 differ);
        fputs(row, stdout);
        text_append(csv, "%s", row);
    }
    fflush(stdout);
}

static void prepare(TreeBench *b, const CellGraph *g, Arena *arena) {
    int *list = ARENA_ARRAY(arena, int, g->polygon_count + 1);
    for (int p = 0; p < g->polygon_count; p++) list[p] = p;
    RaySource source = {
        .polygons = g->polygons, .vertices = g->vertices, .list = list, .list_count = g->polygon_count};
    double start = clock_thread_seconds();
    b->surfaces = ray_surfaces_new(&source, arena);
    double surfaces = clock_thread_seconds(), tree, grid;
    b->tree = surface_tree_new(&b->surfaces, arena);
    tree = clock_thread_seconds();
    b->grid = surface_grid_new(&b->surfaces, arena);
    grid = clock_thread_seconds();
    make_embree(b, g);
    b->prepare[OWN] = tree - start;
    b->prepare[GRID] = surfaces - start + grid - tree;
    b->prepare[EMBREE] = clock_thread_seconds() - grid;
}

bool bench_ray_trees(const char *file, const BenchArguments *arguments, Text *csv, Error *error) {
    Arena arena = {0};
    LoadedScene scene;
    SceneOptions load = arguments->load;
    bool good = scene_load_cells(file, &load, &arena, &scene, error) && scene_has_walls(&scene, error);
    if (good) {
        TreeBench b;
        Ray *rays = ARENA_ARRAY(&arena, Ray, COUNT);
        double *met[WAYS];
        for (int way = 0; way < WAYS; way++) met[way] = ARENA_ARRAY(&arena, double, COUNT);
        prepare(&b, &scene.graph, &arena);
        for (int kind = 0; kind < KINDS; kind++) {
            make_rays(&scene.graph, (Kind)kind, rays);
            add_rows(&b, bench_name(file), (Kind)kind, rays, met, csv);
        }
        rtcReleaseScene(b.embree);
        rtcReleaseDevice(b.device);
    }
    arena_free(&arena);
    return good;
}
