// bench_rays.c - `enfilade bench rays`: the time of a ray that hits a curved shape, and of a ray that misses it; for patches
// by each method, with the numbers of roots that the method misses or makes up.
//
// Rays come from three sizes away and pass through the shape's bounds. Times are the least of several rounds, of all methods
// in turn. The truth is every root that any method finds and Newton's steps confirm, but for those of grazing rays, which
// rounding makes two or none.
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "engine/bench/bench.h"
#include "engine/bench/ray_patches.h"
#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "visibility/bezier/bezier_clip.h"
#include "visibility/hidden/embree_device.h"
#include "visibility/hidden/hidden.h"
#include "visibility/rays/curved_rays.h"
#include "visibility/rays/ray_surfaces.h"

enum { TREE_ROUNDS = 5, TREE_SIDE = 256, TREE_COUNT = TREE_SIDE * TREE_SIDE };
// Hits that Embree leaves out or takes twice at an edge are told apart from hits that differ by so many metres along the ray.
static const double SAME_HIT = 1e-3;

typedef enum Kind { PICTURE, ANYWHERE, BETWEEN, KINDS } Kind;
static const char *const KIND_NAMES[KINDS] = {"picture", "anywhere", "between"};
typedef enum Caster { OWN, GRID, EMBREE, WAYS } Caster;
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
static void make_tree_rays(const CellGraph *g, Kind kind, Ray *rays) {
    enum { PICTURE_SIDE = 64 };
    Random random = {(uint64_t)kind + 1};
    Camera camera = {0};
    for (int i = 0; i < TREE_COUNT; i++) {
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

static double first_of(const TreeBench *b, Caster way, const Ray *ray) {
    if (way == EMBREE) return embree_first(b, ray);
    SurfaceHit hit = way == OWN ? surface_tree_first(&b->tree, ray) : surface_grid_first(&b->grid, ray);
    return hit.item < 0 ? INFINITY : hit.at.t;
}

static bool blocked_of(const TreeBench *b, Caster way, const Ray *ray) {
    if (way == EMBREE) return embree_blocked(b, ray);
    return way == OWN ? surface_tree_blocked(&b->tree, ray) : surface_grid_blocked(&b->grid, ray);
}

static double round_of(const TreeBench *b, Caster way, Kind kind, const Ray *rays, double *met) {
    double start = clock_thread_seconds();
    if (kind == BETWEEN)
        for (int i = 0; i < TREE_COUNT; i++) met[i] = blocked_of(b, way, &rays[i]) ? 1 : INFINITY;
    else
        for (int i = 0; i < TREE_COUNT; i++) met[i] = first_of(b, way, &rays[i]);
    return clock_thread_seconds() - start;
}

static void add_tree_rows(const TreeBench *b, const char *scene, Kind kind, const Ray *rays,
                          double *met[WAYS], Text *csv) {
    double least[WAYS];
    for (int way = 0; way < WAYS; way++) least[way] = INFINITY;
    for (int round = 0; round < TREE_ROUNDS; round++)
        for (int way = 0; way < WAYS; way++)
            least[way] = fmin(least[way], round_of(b, (Caster)way, kind, rays, met[way]));
    for (int way = 0; way < WAYS; way++) {
        int hits = 0, differ = 0;
        for (int i = 0; i < TREE_COUNT; i++) {
            hits += isfinite(met[way][i]);
            differ +=
                isfinite(met[way][i]) != isfinite(met[OWN][i]) || fabs(met[way][i] - met[OWN][i]) > SAME_HIT;
        }
        char row[256];
        double ns = 1e9 * least[way] / TREE_COUNT;
        snprintf(row, sizeof row, "%s %s,%s,%d,%.4f,%.3f,%.1f,,%.0f,,,,,%d,%d,\n", scene, KIND_NAMES[kind],
                 WAY_NAMES[way], TREE_COUNT, (double)hits / TREE_COUNT, 1e3 * b->prepare[way], ns, 1e9 / ns,
                 hits, differ);
        fputs(row, stdout);
        text_append(csv, "%s", row);
    }
    fflush(stdout);
}

static void prepare_trees(TreeBench *b, const CellGraph *g, Arena *arena) {
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

// In the columns of bench_rays.c: shape is `BUILDING KIND`, ns_hit of all rays, `missed` where others meet something else than our
// own hierarchy.
static bool bench_ray_trees(const char *file, const BenchArguments *arguments, Text *csv, Error *error) {
    Arena arena = {0};
    LoadedScene scene;
    SceneOptions load = arguments->load;
    bool good = scene_load_cells(file, &load, &arena, &scene, error) && scene_has_walls(&scene, error);
    if (good) {
        TreeBench b;
        Ray *rays = ARENA_ARRAY(&arena, Ray, TREE_COUNT);
        double *met[WAYS];
        for (int way = 0; way < WAYS; way++) met[way] = ARENA_ARRAY(&arena, double, TREE_COUNT);
        prepare_trees(&b, &scene.graph, &arena);
        for (int kind = 0; kind < KINDS; kind++) {
            make_tree_rays(&scene.graph, (Kind)kind, rays);
            add_tree_rows(&b, bench_name(file), (Kind)kind, rays, met, csv);
        }
        rtcReleaseScene(b.embree);
        rtcReleaseDevice(b.device);
    }
    arena_free(&arena);
    return good;
}

static const char HEAD[] =
    "shape,method,rays,hit_share,prepare_ms,ns_hit,ns_miss,rays_a_second,clips,halvings,steps,undecided,"
    "roots,missed,false\n";

enum { RAYS = 4000, TRUTH_RAYS = 1000, ROUNDS = 5, MOST_HITS = 32, MOST_METHODS = 8 };
// Slow methods get fewer rays: halving takes a hundred times as long as the others.
enum { SLOW_RAYS = 400 };
// A root is confirmed when it is no farther than this from the ray, of the size, and the same as another no farther
// than the second along it. Grazing: the sine of the ray's angle with the patch.
static const double CONFIRMED = 1e-9, SAME = 1e-8, GRAZING = 1e-4;

// A method and its data, which find the hits of a ray with one shape.
typedef struct Shooter {
    const char *shape, *method;
    const BezierMethod *of_patch;  // or NULL
    const BezierPatch *patch;
    const CurvedRays *rays;  // where there is no patch
    bool slow;
    double prepare_ms;
    double ns[2];  // of misses, of hits
    CurvedWork work;
    long long roots, missed, made_up;
} Shooter;

static int shoot(const Shooter *s, const Ray *ray, RayHit *hits, int max, CurvedWork *work) {
    if (!s->of_patch)
        return max > 1 ? curved_rays_all(s->rays, 0, ray, hits, max, work)
                       : curved_rays_hit(s->rays, 0, ray, hits, work);
    HitList list = {.hits = hits, .max = max, .near = ray->near, .far = ray->far};
    work->rays++;
    s->of_patch->hits(s->patch, ray, &list, work);
    return list.count;
}

static void make_rays(Box box, uint64_t seed, Ray *rays, int count) {
    Random random = {seed};
    double size = vec3_length(vec3_sub(box.max, box.min));
    for (int i = 0; i < count; i++) {
        double z = random_between(&random, -1, 1), a = random_between(&random, 0, 2 * M_PI),
               r = sqrt(1 - z * z);
        Vec3 d = {r * cos(a), r * sin(a), z};
        Vec3 p = {random_between(&random, box.min.x, box.max.x),
                  random_between(&random, box.min.y, box.max.y),
                  random_between(&random, box.min.z, box.max.z)};
        rays[i] = (Ray){vec3_sub(p, vec3_scale(d, 3 * size)), d, 0, INFINITY};
    }
}

// ---- time

// Rays in order: those that miss, those that hit. Returns how many miss.
static int sort_rays(const Shooter *s, Ray *rays, int count) {
    int misses = 0;
    CurvedWork work = {0};
    for (int i = 0; i < count; i++) {
        RayHit hit;
        if (shoot(s, &rays[i], &hit, 1, &work)) continue;
        Ray swap = rays[misses];
        rays[misses++] = rays[i];
        rays[i] = swap;
    }
    return misses;
}

static void measure_shooter(Shooter *s, const Ray *rays, int misses, int count, bool first) {
    for (int hits = 0; hits < 2; hits++) {
        int from = hits ? misses : 0, to = hits ? count : misses;
        if (s->slow && to - from > SLOW_RAYS) to = from + SLOW_RAYS;
        if (from == to) continue;
        CurvedWork work = {0};
        RayHit hit;
        double start = clock_thread_seconds();
        for (int i = from; i < to; i++) shoot(s, &rays[i], &hit, 1, &work);
        double ns = 1e9 * (clock_thread_seconds() - start) / (to - from);
        if (first || ns < s->ns[hits]) s->ns[hits] = ns;
        if (!first) continue;
        s->work.rays += work.rays;
        s->work.clips += work.clips;
        s->work.splits += work.splits;
        s->work.steps += work.steps;
        s->work.undecided += work.undecided;
    }
}

// ---- truth

typedef struct Roots {
    double t[MOST_METHODS * MOST_HITS];
    int count;
} Roots;

static bool is_confirmed(const BezierPatch *whole, const Ray *ray, const RayHit *hit, bool *grazes) {
    Vec3 p = bezier_patch_at(whole, hit->u, hit->v);
    Vec3 q = vec3_add(ray->origin, vec3_scale(ray->direction, hit->t));
    *grazes = fabs(vec3_dot(hit->normal, ray->direction)) < GRAZING;
    return vec3_length(vec3_sub(p, q)) < CONFIRMED * bezier_patch_size(whole);
}

static void add_root(Roots *roots, double t, double same) {
    for (int i = 0; i < roots->count; i++)
        if (fabs(roots->t[i] - t) < same) return;
    roots->t[roots->count++] = t;
}

// Rays that graze the patch anywhere are left out.
static void compare(Shooter *shooters, int count, const BezierPatch *whole, const Ray *ray) {
    RayHit hits[MOST_METHODS][MOST_HITS];
    int found[MOST_METHODS], made_up[MOST_METHODS] = {0};
    Roots truth = {.count = 0};
    bool grazes = false;
    CurvedWork work = {0};
    for (int m = 0; m < count; m++) {
        found[m] = shoot(&shooters[m], ray, hits[m], MOST_HITS, &work);
        if (found[m] > MOST_HITS) found[m] = MOST_HITS;
        for (int i = 0; i < found[m]; i++) {
            bool near = false;
            if (is_confirmed(whole, ray, &hits[m][i], &near))
                add_root(&truth, hits[m][i].t, SAME * bezier_patch_size(whole));
            else
                made_up[m]++;
            grazes |= near;
        }
    }
    for (int m = 0; m < count && !grazes; m++) {
        Roots own = {.count = 0};
        for (int i = 0; i < found[m]; i++) add_root(&own, hits[m][i].t, SAME * bezier_patch_size(whole));
        int twice = found[m] - own.count, right = own.count - made_up[m];
        shooters[m].roots += truth.count;
        shooters[m].made_up += made_up[m] + twice;
        shooters[m].missed += truth.count > right ? truth.count - right : 0;
    }
}

// ---- tables

static void add_rays_row(const Shooter *s, double hit_share, Text *csv) {
    double n = (double)s->work.rays, ns = hit_share * s->ns[1] + (1 - hit_share) * s->ns[0];
    size_t start = csv->size;
    text_append(csv, "%s,%s,%lld,%.4f,%.3f,%.0f,%.0f,%.0f,%.2f,%.2f,%.2f,%lld", s->shape, s->method,
                s->work.rays, hit_share, s->prepare_ms, s->ns[1], s->ns[0], 1e9 / ns,
                (double)s->work.clips / n, (double)s->work.splits / n, (double)s->work.steps / n,
                s->work.undecided);
    if (s->of_patch)
        text_append(csv, ",%lld,%lld,%lld\n", s->roots, s->missed, s->made_up);
    else
        text_append(csv, ",,,\n");
    fputs(csv->data + start, stdout);
    fflush(stdout);
}

static void measure_all(Shooter *shooters, int count, Box box, uint64_t seed, Text *csv) {
    Arena arena = {0};
    Ray *rays = ARENA_ARRAY(&arena, Ray, RAYS);
    make_rays(box, seed, rays, RAYS);
    int misses = sort_rays(&shooters[0], rays, RAYS);
    for (int round = 0; round < ROUNDS; round++)
        for (int m = 0; m < count; m++) measure_shooter(&shooters[m], rays, misses, RAYS, round == 0);
    for (int m = 0; m < count; m++) add_rays_row(&shooters[m], 1 - (double)misses / RAYS, csv);
    arena_free(&arena);
}

static void bench_patch(int index, const BenchArguments *a, Text *csv) {
    Arena arena = {0};
    Building building = ray_patch_building(index, 1, &arena);
    Shooter shooters[MOST_METHODS];
    int count = 0;
    for (const BezierMethod *method = BEZIER_METHODS; method->name; method++, count++) {
        double start = clock_thread_seconds();
        const BezierPatch *made = bezier_patch_new(&building, building.shapes, method->whole, &arena);
        shooters[count] = (Shooter){.shape = RAY_PATCH_NAMES[index],
                                    .method = method->name,
                                    .of_patch = method,
                                    .patch = made,
                                    .slow = method->slow,
                                    .prepare_ms = 1000 * (clock_thread_seconds() - start)};
    }
    Ray rays[TRUTH_RAYS];
    Building untrimmed = building;
    CurvedShape shape = building.shapes[0];
    shape.trim_count = 0;
    untrimmed.shapes = &shape;
    const BezierPatch *whole = bezier_patch_new(&untrimmed, &shape, true, &arena);
    make_rays(bezier_patch_box(whole), a->seed + 1, rays, TRUTH_RAYS);
    for (int i = 0; i < TRUTH_RAYS; i++) compare(shooters, count, whole, &rays[i]);
    measure_all(shooters, count, bezier_patch_box(whole), a->seed, csv);
    arena_free(&arena);
}

// ---- the other kinds

typedef struct Solid {
    const char *name;
    CurvedKind kind;
    double z, top;  // the third axis' length
    int balls;
} Solid;
static const Solid SOLIDS[] = {{"sphere", CURVED_SPHERE, 1, 0, 0},
                               {"ellipsoid", CURVED_SPHERE, 0.3, 0, 0},
                               {"cylinder", CURVED_CYLINDER, 1, 0, 0},
                               {"cone", CURVED_CONE, 1, 0, 0},
                               {"cut cone", CURVED_CONE, 1, 0.5, 0},
                               {"1 metaball", CURVED_METABALLS, 1, 0, 1},
                               {"8 metaballs", CURVED_METABALLS, 1, 0, 8},
                               {"64 metaballs", CURVED_METABALLS, 1, 0, 64},
                               {"512 metaballs", CURVED_METABALLS, 1, 0, 512}};

static void bench_solid(const Solid *solid, const BenchArguments *a, Text *csv) {
    Arena arena = {0};
    Random random = {a->seed};
    CurvedShape shape = {.kind = solid->kind,
                         .top = solid->top,
                         .disc = {true, true},
                         .ball_count = solid->balls,
                         .threshold = 0.4,
                         .frame = {{0.3, 0.2, 0.1}, {{1, 0, 0}, {0, 1, 0}, {0, 0, solid->z}}}};
    Building building = {
        .shapes = &shape, .shape_count = 1, .balls = ARENA_ARRAY(&arena, CurvedBall, solid->balls + 1)};
    double spread = cbrt(solid->balls);  // balls overlap as much, however many
    for (int i = 0; i < solid->balls; i++) {
        Vec3 c = {random_between(&random, 0, spread), random_between(&random, 0, spread),
                  random_between(&random, 0, spread)};
        building.balls[i] = (CurvedBall){c, random_between(&random, 0.6, 1), 1};
    }
    Shooter s = {.shape = solid->name, .method = "own"};
    double start = clock_thread_seconds();
    s.rays = curved_rays_new(&building, &arena);
    s.prepare_ms = 1000 * (clock_thread_seconds() - start);
    measure_all(&s, 1, curved_rays_box(s.rays, 0), a->seed, csv);
    arena_free(&arena);
}

static bool bench_shapes(const BenchArguments *a, Text *csv, Error *error) {
    (void)error;
    for (size_t i = 0; i < sizeof SOLIDS / sizeof *SOLIDS; i++) bench_solid(&SOLIDS[i], a, csv);
    for (int patch = 0; patch < RAY_PATCHES; patch++) bench_patch(patch, a, csv);
    return true;
}

static bool measure_rays(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, bench_shapes, bench_ray_trees, error);
}

static const Option ROWS[] = {
    BENCH_SEED("of the rays"),
    BENCH_CSV,
};

const Bench BENCH_RAYS = {
    .name = "rays",
    .about =
        "what a ray costs that hits or misses a curved shape; of Bezier patches by each method, and what "
        "each "
        "misses or makes up; in each building rays of a picture, anywhere, and between places by our own "
        "hierarchy, a grid and Embree",
    BENCH_OPTIONS(ROWS),
    .run = measure_rays,
};
