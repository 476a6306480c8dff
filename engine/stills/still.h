// still.h - draws a picture of a baked building by rays.
#ifndef STILLS_STILL_H
#define STILLS_STILL_H

#include "engine/lit/exposure.h"
#include "engine/scene/walk_light.h"
#include "engine/stills/whitted.h"

// Light straight from lamps: as it was baked, or found by shadow rays.
enum { STILL_BAKED, STILL_RAYS, STILL_DIRECTS };
extern const char *const STILL_DIRECT_NAMES[STILL_DIRECTS];

typedef struct StillOptions {
    int samples;   // of a pixel, 1 .. 4096
    int depth;     // 1 .. 64
    int threads;   // 0: all cores; the picture is the same on any number
    int direct;    // light straight from lamps: STILL_BAKED, STILL_RAYS
    int tree;      // STILL_TREE_OWN ..
    double stops;  // the picture is brighter by so many powers of two
} StillOptions;
StillOptions still_default_options(void);

typedef struct StillReport {
    WhittedWork work;
    double exposure;       // factor of radiosities, m^2/W
    double seconds_scene;  // for the parts made once
    double seconds;        // for the picture alone
    int lamps;
} StillReport;

// Draws into `rgb` [height * width * 3], sRGB, rows from the top. False: progress asked to stop.
bool still_draw(const StabForest *forest, const WalkLight *baked, const Camera *camera,
                const StillOptions *options, const Progress *progress, uint8_t *rgb, StillReport *report);

#endif
