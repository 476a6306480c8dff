// path_walk.h - random walks that bring light to a point, for whoever sums them.
#ifndef RADIOSITY_PATH_WALK_H
#define RADIOSITY_PATH_WALK_H

#include "engine/core/random.h"
#include "radiosity/mesh/mesh.h"

// ---- the faces of a mesh as light paths meet them, by Embree in its robust mode

// Points are metres from the middle of the mesh: Embree's coordinates are floats.
typedef struct PathScene PathScene;
PathScene *path_scene_new(const Mesh *mesh, Arena *arena);
void path_scene_end(PathScene *scene);

typedef struct PathHit {
    int face;    // -1: nothing
    bool front;  // its front was met
    Vec3 point;  // on its plane
} PathHit;
// Among faces in one place the ray meets the one that turns its front to it, then the lower in the mesh, as for form factors.
// May be called by many threads.
PathHit path_scene_trace(const PathScene *scene, Vec3 from, Vec3 along);

// Where rays from a point of a face start, or of whatever surface has that normal.
Vec3 path_scene_before(const PathScene *scene, int face, Vec3 point);
Vec3 path_scene_off(const PathScene *scene, Vec3 point, Vec3 normal);
// The middle of the mesh.
Vec3 path_scene_origin(const PathScene *scene);

// ---- walks

typedef struct PathLights PathLights;

// A point before whose surface one asks for light, in the scene's coordinates.
typedef struct PathPlace {
    Vec3 point, normal;
} PathPlace;

typedef struct PathWorld {
    const Mesh *mesh;
    PathScene *scene;
    PathLights *lights;
    double sky[3];  // radiance of the sky above the horizon, W/m^2/sr a channel
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

// Adds the light that arrives at a place by a walk that takes the numbers from `bounce` on, times `weight`, which changes.
// `known`: of fronts of which one knows what they reflect, W/m^2 a channel, and where the walk ends before its time; points are the
// scene's. NULL: it ends where light is absorbed.
void path_walk(const PathWorld *world, PathPlace place, PathNumbers *numbers, int bounce,
               bool (*known)(void *context, Vec3 from, const PathHit *hit, double reflected[3]),
               void *context, double weight[3], double light[3]);
// The part of a walk's weight that a surface leaves; false: absorbed, by Russian roulette.
bool path_reflect(const Material *material, double u, double weight[3]);

#endif
