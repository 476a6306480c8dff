// path_tracer.c - irradiance by random walks from a point (Kajiya 1986, The Rendering Equation): at each surface one lamp is
// asked for its light, and one direction followed, distributed as cosines; both may find the same lamp, and are weighed by the
// balance heuristic (Veach & Guibas 1995), so that lamps close by are found by directions and small ones by asking. A walk goes
// on as often as the surface reflects (Russian roulette); backs absorb.
//
// The numbers of the first bounces are a lattice's (Korobov 1959; its multiplier: L'Ecuyer & Lemieux 2000), shifted at random for
// each block of paths: blocks are independent, and their scatter tells the standard error.
#include "radiosity/path_tracer.h"

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "radiosity/path_lights.h"

enum {
    BLOCK = 1021,       // paths of a block, a prime
    MULTIPLIER = 76,    // of its lattice
    FEWEST_BLOCKS = 32  // for a standard error that is right to an eighth
};

// Numbers that a surface takes: three for a lamp, two for a direction, one to go on.
enum { LAMP = 0, DIRECTION = 3, ROULETTE = 5, NUMBERS = 6, LATTICE_BOUNCES = 3 };

struct PathTracer {
    const Mesh *mesh;
    PathScene *scene;
    PathLights *lights;
    double sky[3];
};

PathTracer *path_tracer_new(const Mesh *mesh, const double sky[3], Arena *arena) {
    PathTracer *tracer = ARENA_ARRAY(arena, PathTracer, 1);
    tracer->mesh = mesh;
    tracer->scene = path_scene_new(mesh, arena);
    tracer->lights = path_lights_new(tracer->scene, arena);
    for (int c = 0; c < 3; c++) tracer->sky[c] = sky ? sky[c] : 0;
    return tracer;
}

void path_tracer_end(PathTracer *tracer) { path_scene_end(tracer->scene); }

// ---- numbers

typedef struct Lattice {
    Random random;  // beyond the lattice
    double shift[LATTICE_BOUNCES * NUMBERS];
    int generator[LATTICE_BOUNCES * NUMBERS];
    int path;
} Lattice;

static Lattice lattice_of(uint64_t seed, long long block) {
    Random mix = {seed};
    Lattice lattice = {.random = {random_next(&mix) + (uint64_t)block * 0xd1342543de82ef95u}};
    int generator = 1;
    for (int k = 0; k < LATTICE_BOUNCES * NUMBERS; k++) {
        lattice.shift[k] = random_unit(&lattice.random);
        lattice.generator[k] = generator;
        generator = generator * MULTIPLIER % BLOCK;
    }
    return lattice;
}

static void numbers_at(Lattice *lattice, int bounce, double u[NUMBERS]) {
    for (int k = 0; k < NUMBERS; k++) {
        if (bounce >= LATTICE_BOUNCES) {
            u[k] = random_unit(&lattice->random);
            continue;
        }
        int at = bounce * NUMBERS + k;
        double x = (double)(lattice->path * lattice->generator[at] % BLOCK) / BLOCK + lattice->shift[at];
        u[k] = x < 1 ? x : x - 1;
    }
}

// ---- one path

static void add_light(double light[3], const double weight[3], Rgb from, double by) {
    light[0] += weight[0] * (double)from.r * by;
    light[1] += weight[1] * (double)from.g * by;
    light[2] += weight[2] * (double)from.b * by;
}

// The density of directions, 1/sr, with which a point at `to` is chosen where points of its face are with `density`.
static double as_directions(double density, Vec3 to, Vec3 normal) {
    double d2 = vec3_dot(to, to), across = -vec3_dot(to, normal);
    return across > 0 ? density * d2 * sqrt(d2) / across : 0;
}

// The share of a lamp's light that arrives, asked for, and weighed.
static void ask_lamp(const PathTracer *t, const PathPlace *place, const double u[NUMBERS],
                     const double weight[3], double light[3]) {
    PathLightPoint lamp;
    if (!path_lights_choose(t->lights, place, u + LAMP, &lamp)) return;
    Vec3 to = vec3_sub(lamp.point, place->point);
    double cosine = vec3_dot(place->normal, vec3_normalize(to)) / M_PI;
    double asked = as_directions(lamp.density, to, t->mesh->faces[lamp.face].plane.n);
    if (!(cosine > 0) || !(asked > 0)) return;
    PathHit hit = path_scene_trace(t->scene, place->point, vec3_normalize(to));
    if (hit.face != lamp.face) return;
    add_light(light, weight, mesh_material(t->mesh, lamp.face)->emission, cosine / (asked + cosine));
}

static Vec3 cosine_direction(Vec3 normal, double u, double v) {
    double r = sqrt(u), angle = 2 * M_PI * v;
    Vec3 axis = fabs(normal.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    Vec3 x = vec3_normalize(vec3_cross(axis, normal)), y = vec3_cross(normal, x);
    return vec3_normalize(vec3_add(vec3_scale(normal, sqrt(1 - u)),
                                   vec3_add(vec3_scale(x, r * cos(angle)), vec3_scale(y, r * sin(angle)))));
}

// Follows a direction; false: the path ends there.
static bool follow(const PathTracer *t, PathPlace *place, const double u[NUMBERS], double weight[3],
                   double light[3]) {
    Vec3 along = cosine_direction(place->normal, u[DIRECTION], u[DIRECTION + 1]);
    PathHit hit = path_scene_trace(t->scene, place->point, along);
    if (hit.face < 0)
        for (int c = 0; c < 3 && along.z > 0; c++) light[c] += weight[c] * M_PI * t->sky[c];
    if (hit.face < 0 || !hit.front) return false;
    const Material *m = mesh_material(t->mesh, hit.face);
    Vec3 n = t->mesh->faces[hit.face].plane.n;
    double density = path_lights_density(t->lights, place, hit.face);
    double asked = as_directions(density, vec3_sub(hit.point, place->point), n);
    double cosine = vec3_dot(place->normal, along) / M_PI;
    if (cosine > 0) add_light(light, weight, m->emission, cosine / (asked + cosine));
    weight[0] *= (double)m->reflectance.r;
    weight[1] *= (double)m->reflectance.g;
    weight[2] *= (double)m->reflectance.b;
    double goes_on = fmax(weight[0], fmax(weight[1], weight[2]));
    if (!(u[ROULETTE] < goes_on)) return false;
    for (int c = 0; c < 3; c++) weight[c] /= goes_on;
    *place = (PathPlace){path_scene_before(t->scene, hit.face, hit.point), n};
    return true;
}

static void walk(const PathTracer *t, PathPlace place, Lattice *numbers, double light[3]) {
    double weight[3] = {1, 1, 1}, u[NUMBERS];
    bool on = true;
    for (int bounce = 0; on; bounce++) {
        numbers_at(numbers, bounce, u);
        ask_lamp(t, &place, u, weight, light);
        on = follow(t, &place, u, weight, light);
    }
}

// ---- many

// Of blocks: sums of their means and of the squares of these; the fourth channel is the sum of the others.
typedef struct Blocks {
    double sum[4], squares[4];
    long long count;
} Blocks;

static void add_block(const PathTracer *t, const PathQuery *q, const PathPlace *place, Blocks *blocks) {
    Lattice numbers = lattice_of(q->seed, blocks->count++);
    double mean[4] = {0};
    for (numbers.path = 0; numbers.path < BLOCK; numbers.path++) walk(t, *place, &numbers, mean);
    mean[3] = mean[0] + mean[1] + mean[2];
    for (int c = 0; c < 4; c++) {
        blocks->sum[c] += mean[c] / BLOCK;
        blocks->squares[c] += mean[c] / BLOCK * mean[c] / BLOCK;
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
           (b->count + 1) * BLOCK > q->most_paths;
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
    Vec3 point = vec3_sub(q->point, t->scene->origin);
    PathPlace place = {path_scene_off(t->scene, point, q->normal), q->normal};
    Blocks blocks = {0};
    while (!is_enough(q, &blocks)) add_block(t, q, &place, &blocks);
    PathResult *out = &asked->results[index];
    out->paths = blocks.count * BLOCK;
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
    Lattice numbers = lattice_of(0, 0);
    Vec3 from = path_scene_off(t->scene, vec3_sub(point, t->scene->origin), normal);
    int open = 0;
    for (numbers.path = 0; numbers.path < BLOCK; numbers.path++) {
        double u[NUMBERS];
        numbers_at(&numbers, 0, u);
        PathHit hit =
            path_scene_trace(t->scene, from, cosine_direction(normal, u[DIRECTION], u[DIRECTION + 1]));
        open += hit.face < 0 || (hit.front && vec3_length(vec3_sub(hit.point, from)) > near);
    }
    return (double)open / BLOCK;
}
