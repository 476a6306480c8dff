// path_tracer.h - the light at points by random walks: the truth that solutions are measured against. The path tracer shares the
// faces and their materials with the solver, and nothing of light transport: no elements, no form factors, no culling.
#ifndef RADIOSITY_PATH_TRACER_H
#define RADIOSITY_PATH_TRACER_H

#include "radiosity/daylight/daylight.h"
#include "radiosity/mesh/mesh.h"

// Faces in a hierarchy for rays. Only one caller at a time may use a tracer, but it may ask for several threads. The tracer lives
// in the arena of path_tracer_new, but for the memory that path_tracer_end frees; the mesh must outlive the tracer.
typedef struct PathTracer PathTracer;
// `day` shines where a path meets no face, and its sun where nothing is in between; NULL: night.
PathTracer *path_tracer_new(const Mesh *mesh, const Daylight *day, Arena *arena);
// Frees the memory outside the arena.
void path_tracer_end(PathTracer *tracer);

// A point, and when to stop: when either error is reached, or after `most_paths`.
typedef struct PathQuery {
    Vec3 point, normal;     // building space; the normal is unit
    double relative_error;  // standard error over the irradiance, both of the sum of the channels
    double absolute_error;  // standard error of that sum, W/m^2; 0: not used
    long long most_paths;
    uint64_t seed;  // a different one for each point
} PathQuery;

// The light that arrives at a point.
typedef struct PathResult {
    double irradiance[3], standard_error[3];  // W/m^2 a channel
    long long paths;
} PathResult;

// Learns where light comes from, by so many walks from these points. Answers then need fewer walks for the same error, and have the
// same mean as without; `paths` does not count walks that learn. The same on any number of threads.
void path_tracer_learn(PathTracer *tracer, const PathQuery *queries, int count, long long walks, int threads);
// Answers `queries` [count] into `results` [count]: the same on any number of threads (0: all cores).
void path_tracer_irradiance(const PathTracer *tracer, const PathQuery *queries, int count, int threads,
                            PathResult *results);

// The share of the light leaving a point that meets nothing, or a front farther away than `near`, metres. The share is 0 inside a
// closed object, or where another surface lies against the point.
double path_tracer_open(const PathTracer *tracer, Vec3 point, Vec3 normal, double near);

#endif
