// light_scene.h - a building, random points of it with the light that is there in truth, and how far a bake is off.
#ifndef APP_LIGHT_SCENE_H
#define APP_LIGHT_SCENE_H

#include "engine/bench/bench.h"
#include "engine/bench/light_points.h"
#include "radiosity/shoot/adapt.h"
#include "radiosity/show/fine_mesh.h"

typedef struct LightScene {
    const char *file;
    const BenchArguments *arguments;
    LoadedScene scene;
    float *doors;    // [opening_count] as drawn
    Vec3 *vertices;  // the graph's, with the doors there
    LightPoints points;
} LightScene;

// Its points are chosen, `kind` says how well each is to be known.
bool light_scene_open(const char *file, const BenchArguments *arguments, LightTruth kind, Arena *arena,
                      LightScene *out, Error *error);

// How to bake, and what came of it.
typedef struct LightBake {
    MeshOptions options;
    AdaptOptions adapt;
    RadOptions rad;
    int gather;  // resolution of a final gather at all vertices; 0: none
    Mesh mesh;
    RadSolution solution;
    RadReport report;
    const FineMesh *fine;  // what is shown, and its light
    RadSolution shown;
    double mesh_seconds, seconds;  // all is `seconds`
    double work_seconds;           // of all threads
} LightBake;
// The options that `enfilade bake` has without any.
void light_bake_defaults(const LightScene *scene, LightBake *out);
bool light_bake(const LightScene *scene, Arena *arena, LightBake *bake, Error *error);

// Compared with the truth are the light that a point gathers, as `bake --probe` does, and the solution itself where
// the point lies, (B - E) / rho, of the element there and between its corners, which is what a walk shows.
enum { LIGHT_GATHERED, LIGHT_OF_ELEMENT, LIGHT_BETWEEN_CORNERS, LIGHT_COMPARED };
extern const char *const LIGHT_COMPARED_NAMES[LIGHT_COMPARED];

typedef struct LightErrors {
    double *off[LIGHT_COMPARED];  // [points.count] W/m^2, signed; NAN where there is nothing to compare
    double gather_seconds;
} LightErrors;
// The first so many points gather.
LightErrors light_errors(const LightScene *scene, const LightBake *bake, int gathering, Arena *arena);
// Root of the mean square of what irradiances are off, of their mean over all points, percent.
double light_errors_rms(const LightScene *scene, const double *off);

#endif
