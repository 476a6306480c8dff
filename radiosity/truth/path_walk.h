// path_walk.h - random walks that bring light to a point. The caller sums the walks.
#ifndef RADIOSITY_PATH_WALK_H
#define RADIOSITY_PATH_WALK_H

#include "engine/core/random.h"
#include "radiosity/daylight/daylight.h"
#include "radiosity/mesh/mesh.h"

// ---- tracing rays against the faces of a mesh, with Embree in its robust mode

// The faces of a mesh in Embree. Points are in metres from the middle of the mesh, because Embree's coordinates are floats.
typedef struct PathScene PathScene;
PathScene *path_scene_new(const Mesh *mesh, Arena *arena);
void path_scene_end(PathScene *scene);

typedef struct PathHit {
    int face;    // in Mesh.faces; -1: nothing was met
    bool front;  // the ray met the front of the face
    Vec3 point;  // on the face's plane
} PathHit;
// Among faces in one place, the ray meets a front before a back, then the lower index in the mesh, as for form factors. Any number of
// threads may call this at once.
PathHit path_scene_trace(const PathScene *scene, Vec3 from, Vec3 along);

// The start of rays from a point of a face: a little in front of the face, and a little towards its middle.
Vec3 path_scene_before(const PathScene *scene, int face, Vec3 point);
// The start of rays from a point of any surface with this unit normal: a little in front of the surface.
Vec3 path_scene_off(const PathScene *scene, Vec3 point, Vec3 normal);
// The middle of the mesh, in building space.
Vec3 path_scene_origin(const PathScene *scene);

// ---- walks

typedef struct PathLights PathLights;
// The knowledge that walks gathered of the scene (path_guide.h).
typedef struct PathGuide PathGuide;

// A point at which light arrives, and the normal of its surface, in the scene's coordinates.
typedef struct PathPlace {
    Vec3 point, normal;
} PathPlace;

typedef struct PathWorld {
    const Mesh *mesh;
    PathScene *scene;
    PathLights *lights;
    Daylight day;
    PathGuide *guide;  // NULL: nothing was learned
} PathWorld;

PathWorld path_world(const Mesh *mesh, const Daylight *day, Arena *arena);  // `day` NULL: night
void path_world_end(PathWorld *world);

enum { PATH_BLOCK = 1021 };  // walks in a block, a prime
// Lamps that are close to each other are learned of together: at most so many groups.
enum { PATH_LAMP_GROUPS = 64 };

// The random numbers that a walk takes at each surface: three to choose a point of a lamp, two for a direction, one for Russian
// roulette. The first PATH_LATTICE_BOUNCES surfaces take them from a lattice.
enum { PATH_LAMP = 0, PATH_DIRECTION = 3, PATH_ROULETTE = 5, PATH_NUMBERS = 6, PATH_LATTICE_BOUNCES = 3 };

// The random numbers of a block of walks. Each walk takes one point of the lattice.
typedef struct PathNumbers {
    Random random;  // for bounces beyond the lattice
    double shift[PATH_LATTICE_BOUNCES * PATH_NUMBERS];
    int generator[PATH_LATTICE_BOUNCES * PATH_NUMBERS];
    int path;  // the index of the walk in the block, 0 .. PATH_BLOCK - 1; the caller sets it
} PathNumbers;

PathNumbers path_numbers(uint64_t seed, long long block);
void path_numbers_at(PathNumbers *numbers, int bounce, double u[PATH_NUMBERS]);

// A unit direction about a unit normal, distributed in proportion to the cosine; u and v are uniform in [0, 1).
Vec3 path_direction(Vec3 normal, double u, double v);

// Adds to `light` the light that one walk brings to a place, times `weight`, which the walk changes. The walk takes its random
// numbers from `bounce` on. `known` is called for each front that the walk meets; if it returns true, it has stored the light that
// the front reflects, W/m^2 a channel, and the walk ends there. `from` and the hit are in the scene's coordinates. NULL: the walk
// goes on until it is absorbed.
void path_walk(const PathWorld *world, PathPlace place, PathNumbers *numbers, int bounce,
               bool (*known)(void *context, Vec3 from, const PathHit *hit, double reflected[3]),
               void *context, double weight[3], double light[3]);
// A walk without `known` from bounce 0 on. `own` are the shares of the place itself, NULL: those of the world's guide. `trail` takes what
// the walk met, NULL: nobody asks.
struct PathShares;
struct PathTrail;
void path_walk_guided(const PathWorld *world, PathPlace place, PathNumbers *numbers,
                      const struct PathShares *own, struct PathTrail *trail, double light[3]);
// Multiplies a walk's weight by the reflectance, with Russian roulette by `u`; false: the walk is absorbed.
bool path_reflect(Rgb reflectance, double u, double weight[3]);
// The reflectance where a ray met a face: of the material's picture there, to a texel, or else that of the material.
Rgb path_reflectance(const PathWorld *world, const PathHit *hit);

#endif
