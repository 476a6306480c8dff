// lamps_fixture.h - three rooms with four lamps, with the light of each lamp.
#ifndef TESTS_LAMPS_FIXTURE_H
#define TESTS_LAMPS_FIXTURE_H

#include "engine/scene/scene.h"
#include "radiosity/follow/each_lamp.h"
#include "radiosity/follow/relight.h"

// A room with a panel in its ceiling and a glowing box, a second one with a panel behind a door that is half open, a third one of its own
// with a light.
typedef struct Lamps3 {
    Arena arena;
    LoadedScene scene;
    float *doors;
    Mesh mesh;
    RadSolution solution;  // with `each`, as their sum
    RadSolution joint;     // as it was before, of all lamps together
    RadOptions rad;
    Daylight day;     // of the rows
    Relight relight;  // of lamps3_follow
} Lamps3;

// `day`: in daylight, through a window of the first room.
Lamps3 *lamps3_load(bool day);
// Another plan in its place, as text.
Lamps3 *lamps3_load_plan(const char *plan, bool day);
// Shoots to a residual, and finds the light of each lamp.
void lamps3_bake(Lamps3 *l, double residual, int threads);
// Shoots to a residual, so that light can follow the doors: l->relight.
void lamps3_follow(Lamps3 *l, double residual, int threads);
void lamps3_free(Lamps3 *l);

// How far values [count] are off: the mean, and of the worst hundredth the best, relative to the truth or to this share of its mean, in
// which `weight` (NULL: all alike) tells how much each counts. Places that are dark in both do not count.
typedef struct LightOff {
    double mean, p99;
} LightOff;
LightOff lamps3_off(double (*value)[3], double (*truth)[3], const double *weight, int count, double share);

// The mesh with one lamp alone, fully lit.
Mesh lamps3_alone(Lamps3 *l, int lamp);

#endif
