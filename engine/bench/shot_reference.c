// shot_reference.c - rows by independent random rays, cosine-distributed (Embree), which share no pattern with any method.
#include "engine/bench/shot_reference.h"

#include <math.h>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "radiosity/methods/ray_caster.h"

enum { MOST_THREADS = 64 };

typedef struct Casting {
    const ShotReference *reference;
    const ViewPoint *from;
    uint64_t seed;
    RayCaster *casters[MOST_THREADS];  // of each thread
} Casting;

// Eight directions about `z`: points of the disc, lifted.
static RayEight random_rays(Random *random, Vec3 x, Vec3 y, Vec3 z) {
    RayEight rays;
    for (int i = 0; i < LANES; i++) {
        double r2 = random_unit(random), angle = 2 * M_PI * random_unit(random), r = sqrt(r2);
        Vec3 w = vec3_add(vec3_add(vec3_scale(x, r * cos(angle)), vec3_scale(y, r * sin(angle))),
                          vec3_scale(z, sqrt(1 - r2)));
        rays.x[i] = (float)w.x;
        rays.y[i] = (float)w.y;
        rays.z[i] = (float)w.z;
    }
    return rays;
}

static void cast_shooter(void *context, int shooter, int thread) {
    const Casting *casting = context;
    Random random = {casting->seed * 1000003 + (uint64_t)shooter};
    const ViewPoint *from = &casting->from[shooter];
    Vec3 x, y;
    view_axes(from->normal, &x, &y);
    uint32_t *arrivals = casting->reference->arrivals[shooter];
    for (long long i = 0; i < casting->reference->rays / LANES; i++) {
        RayEight rays = random_rays(&random, x, y, from->normal);
        int32_t face[LANES], element[LANES];
        ray_caster_cast(casting->casters[thread], from->eye, from->normal, &rays, ~(LaneInt){0}, false, face,
                        element);
        for (int k = 0; k < LANES; k++)
            if (element[k] >= 0) arrivals[element[k]]++;
    }
}

ShotReference shot_reference(const Mesh *mesh, const ViewPoint *from, int count, long long rays,
                             uint64_t seed, Arena *arena) {
    ShotReference reference = {.rays = rays / LANES * LANES, .element_count = mesh->element_count};
    reference.arrivals = ARENA_ARRAY(arena, uint32_t *, count + 1);
    for (int s = 0; s < count; s++) reference.arrivals[s] = ARENA_ARRAY(arena, uint32_t, mesh->element_count);
    Casting casting = {.reference = &reference, .from = from, .seed = seed};
    int threads = parallel_threads(0);
    if (threads > MOST_THREADS) threads = MOST_THREADS;
    for (int t = 0; t < threads; t++) casting.casters[t] = ray_caster_new(mesh, arena);
    parallel_for(threads, count, cast_shooter, &casting);
    for (int t = 0; t < threads; t++) ray_caster_end(casting.casters[t]);
    return reference;
}

double shot_reference_l1(const ShotReference *reference, int shooter, const Row *row) {
    const uint32_t *arrivals = reference->arrivals[shooter];
    double sum = 0;
    int at = 0;
    for (int e = 0; e < reference->element_count; e++) {
        double f = 0;
        if (at < row->count && row->element[at] == e) f = (double)row->factor[at++];
        sum += fabs(f - arrivals[e] / (double)reference->rays);
    }
    return sum;
}
