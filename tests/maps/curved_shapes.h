// curved_shapes.h - curved shapes at random, as polygons.
#ifndef TESTS_CURVED_SHAPES_H
#define TESTS_CURVED_SHAPES_H

#include "engine/core/random.h"
#include "maps/curved/curved_patch.h"
#include "tests/support/support.h"

// Closed shapes; a torus whose profile is four cubics; a vase with an inside that meets the axis at both ends.
static const char TORUS[] =
    "lathe red 0,0,0.3 profile 0.30,-0.1 0.3552,-0.1 0.4,-0.0552 0.4,0 0.4,0.0552 0.3552,0.1 "
    "0.3,0.1 0.2448,0.1 0.2,0.0552 0.2,0 0.2,-0.0552 0.2448,-0.1 0.30,-0.1";

static const char VASE[] =
    "lathe red 0,0 profile 0,0 0.03,0 0.05,0 0.06,0 0.06,0.01 0.14,0.1 0.04,0.2 0.05,0.3 "
    "0.045,0.305 0.04,0.3 0.03,0.2 0.12,0.12 0,0.02";

static const char *const CLOSED[] = {
    "sphere red 0,0,0.3 radius 0.3",
    "ellipsoid red 0,0,0.5 radii 0.1,0.3,0.5 angle 20",
    "cylinder red 0.1 0.9 0,0 radius 0.3 round",
    "cone red 0,0,0.1 0.4,0.2,0.6 radius 0.2",
    "cone red 0,0,0.1 0,0,0.6 radius 0.2 top 0.1",
    "cone red 0,0,0.1 0.2,0,0.6 radius 0.1 top 0.25",
    TORUS,
    VASE,
    "metaballs red threshold 0.5\nball 0,0,0.5 radius 0.5",
    "metaballs red threshold 0.4\nball 0,0,0.4 radius 0.4\nball 0.3,0,0.4 radius 0.3\n"
    "ball 0.1,0.1,0.6 radius 0.2 weight -0.4\nball 0.1,-0.2,0.5 radius 0.3"};

enum { CLOSED_COUNT = sizeof CLOSED / sizeof *CLOSED };

double curved_between(Random *random, double low, double high);

void curved_random_patch(Random *random, CurvedControl control[PATCH_CONTROLS]);

#endif
