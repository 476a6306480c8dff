// path_tracer.c - irradiance by random walks from a point (path_walk.c). Blocks of walks are independent, and their scatter tells
// the standard error.
//
// A tracer that has learned the scene (path_guide.c) learns each point, too: by walks that do not count, of which the first are guided
// by what is known of the place, and the others by what the first found.
#include "radiosity/truth/path_tracer.h"

#include "engine/core/parallel.h"
#include "radiosity/truth/path_guide.h"

enum { FEWEST_BLOCKS = 32 };  // for a standard error that is right to an eighth
// A point is learned in so many rounds of a block.
enum { POINT_ROUNDS = 2 };
// The scene is learned in rounds of tasks; each round has twice as many walks as the one before.
enum { SCENE_ROUNDS = 5, SCENE_TASKS = 64 };
// Seeds of walks that do not count.
static const uint64_t LEARNING = 0x5ca1ab1e00000000u;

struct PathTracer {
    PathWorld world;
    Arena *arena;
};

PathTracer *path_tracer_new(const Mesh *mesh, const Daylight *day, Arena *arena) {
    PathTracer *tracer = ARENA_ARRAY(arena, PathTracer, 1);
    tracer->world = path_world(mesh, day, arena);
    tracer->arena = arena;
    return tracer;
}

void path_tracer_end(PathTracer *tracer) { path_world_end(&tracer->world); }

// Sums over blocks: of their means and of the squares of these; the fourth channel is the sum of the others.
typedef struct Blocks {
    double sum[4], squares[4];
    long long count;
} Blocks;

static void trace_block(const PathTracer *t, const PathQuery *q, const PathPlace *place,
                        const PathShares *own, Blocks *blocks) {
    PathNumbers numbers = path_numbers(q->seed, blocks->count++);
    double mean[4] = {0};
    for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++)
        path_walk_guided(&t->world, *place, &numbers, own, NULL, mean);
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

static void learn_point(const PathTracer *t, const PathQuery *q, const PathPlace *place, PathShares *own) {
    PathTally tally = {.walks = 0};
    PathTrail trail;
    for (int round = 0; round < POINT_ROUNDS; round++) {
        PathNumbers numbers = path_numbers(q->seed ^ LEARNING, round);
        for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++) {
            double light[3] = {0, 0, 0};
            path_walk_guided(&t->world, *place, &numbers, round > 0 ? own : NULL, &trail, light);
            path_tally_add(&tally, &trail.steps[0]);
        }
        path_tally_shares(&tally, own);
    }
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
    PathShares own;
    if (t->world.guide) learn_point(t, q, &place, &own);
    while (!is_enough(q, &blocks)) trace_block(t, q, &place, t->world.guide ? &own : NULL, &blocks);
    PathResult *out = &asked->results[index];
    out->paths = blocks.count * PATH_BLOCK;
    for (int c = 0; c < 3; c++) {
        out->irradiance[c] = blocks.sum[c] / (double)blocks.count;
        out->standard_error[c] = error_of(&blocks, c);
    }
}

static Bytes pack_answer(void *context, int index, Arena *arena) {
    const Asked *asked = context;
    (void)arena;
    return (Bytes){(unsigned char *)&asked->results[index], sizeof *asked->results};
}

static void unpack_answer(void *context, int index, Bytes result) {
    const Asked *asked = context;
    memcpy(&asked->results[index], result.data, sizeof *asked->results);
}

void path_tracer_irradiance(const PathTracer *tracer, const PathQuery *queries, int count, int threads,
                            PathResult *results) {
    Asked asked = {tracer, queries, results};
    SharedLoop loop = {count, answer, pack_answer, unpack_answer, &asked};
    parallel_share(parallel_threads(threads), &loop);
}

// ---- learning the scene

// A part of a round.
typedef struct SceneTask {
    PathStep *steps;  // [count]
    int count, capacity;
    Arena arena;
} SceneTask;

typedef struct SceneRound {
    const PathTracer *tracer;
    const PathQuery *queries;
    int query_count, walks, round;
    SceneTask tasks[SCENE_TASKS];
} SceneRound;

static void walk_task(void *context, int index, int thread) {
    (void)thread;
    SceneRound *round = context;
    const PathWorld *world = &round->tracer->world;
    SceneTask *task = &round->tasks[index];
    PathTrail trail;
    Random random = {LEARNING + (uint64_t)(round->round * SCENE_TASKS + index)};
    PathNumbers numbers = path_numbers(random_next(&random), 0);
    for (int i = 0; i < round->walks; i++) {
        const PathQuery *q = &round->queries[random_index(&random, round->query_count)];
        Vec3 point = vec3_sub(q->point, path_scene_origin(world->scene));
        double light[3] = {0, 0, 0};
        if (i % PATH_BLOCK == 0) numbers = path_numbers(random_next(&random), 0);
        numbers.path = i % PATH_BLOCK;
        path_walk_guided(world, (PathPlace){path_scene_off(world->scene, point, q->normal), q->normal},
                         &numbers, NULL, &trail, light);
        for (int k = 0; k < trail.count; k++)
            *ARENA_PUSH(&task->arena, task->steps, task->count, task->capacity) = trail.steps[k];
    }
}

static Bytes pack_task(void *context, int index, Arena *arena) {
    const SceneRound *round = context;
    const SceneTask *task = &round->tasks[index];
    (void)arena;
    return (Bytes){(unsigned char *)task->steps, (size_t)task->count * sizeof *task->steps};
}

static void unpack_task(void *context, int index, Bytes result) {
    SceneRound *round = context;
    SceneTask *task = &round->tasks[index];
    task->count = (int)(result.size / sizeof *task->steps);
    task->steps = ARENA_ARRAY(&task->arena, PathStep, task->count);
    if (task->count > 0) memcpy(task->steps, result.data, result.size);
}

void path_tracer_learn(PathTracer *tracer, const PathQuery *queries, int count, long long walks,
                       int threads) {
    if (count == 0) return;
    PathGuide *guide = path_guide_new(tracer->world.mesh, tracer->arena);
    tracer->world.guide = NULL;
    for (int r = 0; r < SCENE_ROUNDS; r++) {
        long long share = walks * (1 << r) / ((1 << SCENE_ROUNDS) - 1) / SCENE_TASKS;
        SceneRound round = {tracer, queries, count, (int)share, r, {{0}}};
        SharedLoop loop = {SCENE_TASKS, walk_task, pack_task, unpack_task, &round};
        parallel_share(parallel_threads(threads), &loop);
        // In the order of tasks, so that sums are the same on any number of threads.
        for (int k = 0; k < SCENE_TASKS; k++) {
            path_guide_add(guide, round.tasks[k].steps, round.tasks[k].count);
            arena_free(&round.tasks[k].arena);
        }
        path_guide_share(guide);
        tracer->world.guide = guide;
    }
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
