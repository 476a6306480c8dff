// path_tracer.h - the light at points by random walks: the truth that solutions are measured against. It shares the faces and
// their materials with the solver, and no transport: no elements, no form factors, no culling.
#ifndef RADIOSITY_PATH_TRACER_H
#define RADIOSITY_PATH_TRACER_H

#include "radiosity/mesh/mesh.h"

// Faces in a hierarchy for rays. One caller's at a time, which may ask for several threads; it lives in the arena of path_tracer_new but
// for what path_tracer_end lets go of, and the mesh outlives it.
typedef struct PathTracer PathTracer;
// `sky`: radiance of the sky above the horizon, W/m^2/sr a channel, where a path meets no face; NULL: none.
PathTracer *path_tracer_new(const Mesh *mesh, const double sky[3], Arena *arena);
// Frees the memory outside the arena.
void path_tracer_end(PathTracer *tracer);

// Where to ask, and when to be content: at either error, or after so many paths.
typedef struct PathQuery {
    Vec3 point, normal;     // building space; unit
    double relative_error;  // standard error of the irradiance, of the sum of its channels, over it
    double absolute_error;  // W/m^2; 0: does not count
    long long most_paths;
    uint64_t seed;  // another for each point
} PathQuery;

// The light that arrives at a point.
typedef struct PathResult {
    double irradiance[3], standard_error[3];  // W/m^2 a channel
    long long paths;
} PathResult;

// The same result on any number of threads (0: all cores).
void path_tracer_irradiance(const PathTracer *tracer, const PathQuery *queries, int count, int threads,
                            PathResult *results);

// The share of the light that leaves a point that meets a front farther than `near`, metres, or nothing: 0 inside of what is
// closed, or where another surface lies against it.
double path_tracer_open(const PathTracer *tracer, Vec3 point, Vec3 normal, double near);

#endif
