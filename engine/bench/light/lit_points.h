// lit_points.h - light at random points of a building: by path tracing, by a bake, and how far the two are apart.
#ifndef BENCH_LIT_POINTS_H
#define BENCH_LIT_POINTS_H

#include "engine/bench/bench.h"
#include "radiosity/shoot/adapt.h"
#include "radiosity/shoot/shoot.h"
#include "radiosity/show/fine_mesh.h"

typedef struct LightPoint {
    Vec3 place, normal;
    int polygon;                      // of the graph
    double truth[3], standard_error;  // irradiance, W/m^2 a channel; of the sum of the channels
    double scale;                     // of relative errors, W/m^2
} LightPoint;

typedef struct LightPoints {
    LightPoint *points;  // [count]
    int count;
    double mean;  // irradiance, W/m^2, the sum of the channels
    long long paths;
    double seconds;  // of path tracing, all cores
} LightPoints;

// The standard error of the truth is a share of the irradiance at the point, or of a hundredth of the mean of all points where
// that is more, so that points in the dark do not decide; or of the mean.
typedef enum LightTruth { LIGHT_TRUTH_EACH, LIGHT_TRUTH_MEAN } LightTruth;

static inline double light_point_irradiance(const LightPoint *p) {
    return p->truth[0] + p->truth[1] + p->truth[2];
}

typedef struct LightScene {
    const char *file;
    const BenchArguments *arguments;
    LoadedScene scene;
    float *doors;  // [opening_count] as drawn
    LightPoints points;
} LightScene;

// The options of a bake, and its results.
typedef struct LightBake {
    MeshOptions options;
    AdaptOptions adapt;
    RadOptions rad;
    int gather;  // resolution of a final gather at all vertices; 0: none
    Mesh mesh;
    RadSolution solution;
    RadReport report;
    const FineMesh *fine;  // the mesh that is shown; `shown` is its light
    RadSolution shown;
    double mesh_seconds, seconds;  // all is `seconds`
    double work_seconds;           // of all threads
} LightBake;

// Three values are compared with the truth: the light that a point gathers, as by `bake --probe`; and the solution itself at
// the point, (B - E) / rho, once from the element there and once between its corners, which a walk shows.
enum { LIGHT_GATHERED, LIGHT_OF_ELEMENT, LIGHT_BETWEEN_CORNERS, LIGHT_COMPARED };
extern const char *const LIGHT_COMPARED_NAMES[LIGHT_COMPARED];

typedef struct LightErrors {
    double *off[LIGHT_COMPARED];  // [points.count] W/m^2, signed; NAN where there is nothing to compare
    double gather_seconds;
} LightErrors;

// Points with less light than this share of the mean are measured against it.
static const double LIT_DARK = 0.01;

// Is the place within `near` metres of a view that the building stores?
bool lit_near_view(const Building *building, Vec3 place, double near);

// Reads a building for these benches. Its points are none yet.
bool light_scene_load(const char *file, const BenchArguments *arguments, Arena *arena, LightScene *out,
                      Error *error);
// The same, and chooses arguments->points points, spread by area over the elements of patches that look into rooms, half of them near views
// where arguments->near is not 0. Path tracing tells the light there; `kind` says how well each is to be known.
bool light_scene_open(const char *file, const BenchArguments *arguments, LightTruth kind, Arena *arena,
                      LightScene *out, Error *error);

// The options that `enfilade bake` has without any.
void light_bake_defaults(const LightScene *scene, LightBake *out);
// Makes the mesh and its light, by the options in `bake`.
bool light_bake(const LightScene *scene, Arena *arena, LightBake *bake, Error *error);

// Gathers light at all vertices: then the value between corners shows the quality of the final gather.
void light_gather_vertices(const LightScene *scene, LightBake *bake, Arena *arena);

// The irradiance, W/m^2, the sum of the channels, from the reflected light `b`. Channels that the material does not reflect count as right.
double light_irradiance_of(const LightPoint *point, const Material *material, const double b[3]);
bool light_reflects(const Material *material);
// The errors of a bake at all points; the first `gathering` gather.
LightErrors light_errors(const LightScene *scene, const LightBake *bake, int gathering, Arena *arena);
// The root of the mean square of errors, W/m^2, as percent of the mean irradiance. The scatter of the truth itself is no error of ours.
double light_errors_rms(const LightScene *scene, const double *off);

typedef struct Spread {
    double median, rms, p90, most;  // percent
    int count;
} Spread;
// The spread of errors over all points, or over the points that are lit.
Spread lit_spread(const LightPoints *points, const double *off, bool lit);
// The error of the truth itself, percent; `dark` gets how many points are not lit.
double lit_truth_error(const LightPoints *points, int *dark);
// Orders doubles, for qsort.
int lit_by_size(const void *a, const void *b);

#endif
