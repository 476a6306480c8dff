// baked_fixture.h - buildings made in memory, baked as `enfilade bake` does without options, and how right their light is.
#ifndef TESTS_BAKED_FIXTURE_H
#define TESTS_BAKED_FIXTURE_H

#include "engine/app/app.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"

// The adaptive mesh, what is close lit from whole patches, residual and resolution that fit. `lit` has its polygons only; fails the
// running test where there is no light.
RadReport baked_solve(Lit *lit, RadSolution *out);

// Power that is neither absorbed nor escaped nor left, of what was emitted, the worst channel.
double baked_lost(const Lit *lit, const RadSolution *s);

// Errors of irradiance, all channels, at points: of what is gathered there, as by --probe, and of what is shown, between the
// corners of elements. Relative to the truth, or to a tenth of the mean of all points where that is more.
typedef struct BakedErrors {
    double gathered_rms, gathered_most, shown_rms, shown_most;
    double truth;           // its standard error, in the same measure, the mean
    double sum, sum_error;  // of what is gathered at all points, of the truth; and the standard error of that
} BakedErrors;

typedef struct BakedPoint {
    Vec3 place, normal;
    double truth, standard_error;  // irradiance, the sum of the channels, W/m^2
} BakedPoint;

// Random points on the fronts of faces of polygons first .. end - 1, evenly by area; their truth is the caller's, or path tracing's.
BakedPoint *baked_points(Lit *lit, int first, int end, int count);
void baked_trace(const Lit *lit, double error, long long most_paths, BakedPoint *points, int count);
BakedErrors baked_errors(const Lit *lit, const RadSolution *s, const BakedPoint *points, int count);
void baked_print(const char *name, const BakedErrors *errors);

// A building from its file, doors as drawn, to a residual, 0: what fits. Freed by the caller.
typedef struct BakedBuilding {
    Arena arena;
    LoadedScene scene;
    float *doors;  // [opening_count]
    Mesh mesh;
    RadSolution solution;
} BakedBuilding;
BakedBuilding *baked_building(const char *path, double residual);
void baked_building_free(BakedBuilding *building);

#endif
