// form_factor_fixture.h - polygons and points whose form factors are known.
#ifndef TESTS_FORM_FACTOR_FIXTURE_H
#define TESTS_FORM_FACTOR_FIXTURE_H

#include "radiosity/factors/analytic.h"
#include "tests/support/view_fixture.h"

static const int RESOLUTION[] = {100, 200, 400};

double form_factor_tolerance(const FormFactorMethod *method, int resolution);

Vec3 form_factor_spun(Vec3 p, double angle);

// The share of all light that meets the front of the fixture's face 0 from the origin about z.
double form_factor_share(Arena *arena, const ViewFixture *f, const FormFactorMethod *method, int resolution,
                         Vec3 eye);

#define ABOVE(x, y, h)                                                                                       \
    {                                                                                                        \
        {0, 0, h}, {0, y, h}, {x, y, h}, { x, 0, h }                                                         \
    }

// Gauss-Legendre of six points over [0, 1].
static const double GAUSS_X[6] = {0.033765242898423989, 0.16939530676686774, 0.38069040695840156,
                                  0.61930959304159849,  0.83060469323313224, 0.96623475710157603};

static const double GAUSS_W[6] = {0.085662246189585178, 0.18038078652406929, 0.23395696728634552,
                                  0.23395696728634552,  0.18038078652406929, 0.085662246189585178};

#endif
