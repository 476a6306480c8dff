// path_tracer.c - irradiance by random walks from a point (path_walk.c). Blocks of walks are independent, and their scatter tells
// the standard error.
#include "radiosity/truth/path_tracer.h"

#include "engine/core/parallel.h"
#include "radiosity/truth/path_walk.h"

enum { FEWEST_BLOCKS = 32 };  // for a standard error that is right to an eighth

struct PathTracer {
    PathWorld world;
};

PathTracer *path_tracer_new(const Mesh *mesh, const Daylight *day, Arena *arena) {
    PathTracer *tracer = ARENA_ARRAY(arena, PathTracer, 1);
    tracer->world = path_world(mesh, day, arena);
    return tracer;
}

void path_tracer_end(PathTracer *tracer) { path_world_end(&tracer->world); }

// Sums over blocks: of their means and of the squares of these; the fourth channel is the sum of the others.
typedef struct Blocks {
    double sum[4], squares[4];
    long long count;
} Blocks;

static void trace_block(const PathTracer *t, const PathQuery *q, const PathPlace *place, Blocks *blocks) {
    PathNumbers numbers = path_numbers(q->seed, blocks->count++);
    double mean[4] = {0};
    for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++) {
        double weight[3] = {1, 1, 1};
        path_walk(&t->world, *place, &numbers, 0, NULL, NULL, weight, mean);
    }
    mean[3] = mean[0] + mean[1] + mean[2];
    for (int c = 0; c < 4; c++) {
        blocks->sum[c] += mean[c] / PATH_BLOCK;
        blocks->squares[c] += mean[c] / PATH_BLOCK * mean[c] / PATH_BLOCK;
    }
}

static double error_of(const Blocks *b, int channel) {
    double n = (double)b->count, mean = b->sum[channel] / n;
    double variance = fmax(b->squares[channel] / n - mean * mean, 0);
    return sqrt(variance / (n - 1));
}

static bool is_enough(const PathQuery *q, const Blocks *b) {
    if (b->count < FEWEST_BLOCKS) return false;
    double error = error_of(b, 3), mean = b->sum[3] / (double)b->count;
    return error <= q->relative_error * mean || error <= q->absolute_error ||
           (b->count + 1) * PATH_BLOCK > q->most_paths;
}

typedef struct Asked {
    const PathTracer *tracer;
    const PathQuery *queries;
    PathResult *results;
} Asked;

static void answer(void *context, int index, int thread) {
    (void)thread;
    const Asked *asked = context;
    const PathTracer *t = asked->tracer;
    const PathQuery *q = &asked->queries[index];
    Vec3 point = vec3_sub(q->point, path_scene_origin(t->world.scene));
    PathPlace place = {path_scene_off(t->world.scene, point, q->normal), q->normal};
    Blocks blocks = {0};
    while (!is_enough(q, &blocks)) trace_block(t, q, &place, &blocks);
    PathResult *out = &asked->results[index];
    out->paths = blocks.count * PATH_BLOCK;
    for (int c = 0; c < 3; c++) {
        out->irradiance[c] = blocks.sum[c] / (double)blocks.count;
        out->standard_error[c] = error_of(&blocks, c);
    }
}

void path_tracer_irradiance(const PathTracer *tracer, const PathQuery *queries, int count, int threads,
                            PathResult *results) {
    Asked asked = {tracer, queries, results};
    parallel_for(parallel_threads(threads), count, answer, &asked);
}

double path_tracer_open(const PathTracer *t, Vec3 point, Vec3 normal, double near) {
    PathNumbers numbers = path_numbers(0, 0);
    Vec3 from = path_scene_off(t->world.scene, vec3_sub(point, path_scene_origin(t->world.scene)), normal);
    int open = 0;
    for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++) {
        double u[PATH_NUMBERS];
        path_numbers_at(&numbers, 0, u);
        PathHit hit = path_scene_trace(t->world.scene, from,
                                       path_direction(normal, u[PATH_DIRECTION], u[PATH_DIRECTION + 1]));
        open += hit.face < 0 || (hit.front && vec3_length(vec3_sub(hit.point, from)) > near);
    }
    return (double)open / PATH_BLOCK;
}
