// path_walk.h - random walks that bring light to a point, for whoever sums them.
#ifndef RADIOSITY_PATH_WALK_H
#define RADIOSITY_PATH_WALK_H

#include "engine/core/random.h"
#include "radiosity/truth/path_lights.h"

typedef struct PathWorld {
    const Mesh *mesh;
    PathScene *scene;
    PathLights *lights;
    double sky[3];  // radiance of what lies above the horizon, W/m^2/sr a channel
} PathWorld;

PathWorld path_world(const Mesh *mesh, const double sky[3], Arena *arena);  // `sky` NULL: none
void path_world_end(PathWorld *world);

enum { PATH_BLOCK = 1021 };  // walks of a block, a prime

// Numbers that a surface takes: three for a lamp, two for a direction, one to go on.
enum { PATH_LAMP = 0, PATH_DIRECTION = 3, PATH_ROULETTE = 5, PATH_NUMBERS = 6, PATH_LATTICE_BOUNCES = 3 };

// Those of a block of walks, of which each takes one place in a lattice.
typedef struct PathNumbers {
    Random random;  // beyond the lattice
    double shift[PATH_LATTICE_BOUNCES * PATH_NUMBERS];
    int generator[PATH_LATTICE_BOUNCES * PATH_NUMBERS];
    int path;  // the walk's, 0 .. PATH_BLOCK - 1
} PathNumbers;

PathNumbers path_numbers(uint64_t seed, long long block);
void path_numbers_at(PathNumbers *numbers, int bounce, double u[PATH_NUMBERS]);

// Distributed as cosines are.
Vec3 path_direction(Vec3 normal, double u, double v);

// Where walks end before their time: at fronts of which one knows what they reflect. Points are the scene's.
typedef struct PathEnd {
    bool (*known)(void *context, Vec3 from, const PathHit *hit, double reflected[3]);  // W/m^2 a channel
    void *context;
} PathEnd;

// Adds the light that arrives at a place by a walk that takes the numbers from `bounce` on, times `weight`, which changes.
// `end`: NULL, it ends where light is absorbed.
void path_walk(const PathWorld *world, PathPlace place, PathNumbers *numbers, int bounce, const PathEnd *end,
               double weight[3], double light[3]);
// The part of a walk's weight that a surface leaves; false: absorbed, by Russian roulette.
bool path_reflect(const Material *material, double u, double weight[3]);

#endif
