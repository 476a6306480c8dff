// light_points.h - random points of a building's rooms, and the light there as path tracing tells it.
#ifndef APP_LIGHT_POINTS_H
#define APP_LIGHT_POINTS_H

#include "radiosity/shoot/shoot.h"

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

// Evenly over the fronts of what stands in rooms, by area, but where backs alone are before them, or another front lies against
// them: nobody sees that. Fails where there are none.
bool light_points_choose(const Mesh *mesh, int count, uint64_t seed, Arena *arena, LightPoints *out,
                         Error *error);
// The standard error of the truth is a share of the irradiance at the point, or of a hundredth of the mean of all points where
// that is more, so that points in the dark do not decide; or of the mean.
typedef enum LightTruth { LIGHT_TRUTH_EACH, LIGHT_TRUTH_MEAN } LightTruth;
void light_points_trace(const Mesh *mesh, const double sky[3], LightTruth kind, double error, uint64_t seed,
                        LightPoints *points);

static inline double light_point_irradiance(const LightPoint *p) {
    return p->truth[0] + p->truth[1] + p->truth[2];
}

#endif
