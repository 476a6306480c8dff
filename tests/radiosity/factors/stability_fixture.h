// stability_fixture.h - views of quads, and rows of every method.
#ifndef TESTS_STABILITY_FIXTURE_H
#define TESTS_STABILITY_FIXTURE_H

#include "radiosity/factors/analytic.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

#define EACH_METHOD(m) for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++)

bool stability_is(const FormFactorMethod *method, const char *name);

// The method kept as it was printed, whose failures are measured and not mended.
bool stability_as_printed(const FormFactorMethod *method);

// Takes a quarter of the lines where both ways agree on the row as a whole, small as a part of it may be.
bool stability_fits(const FormFactorMethod *method);

// Embree's rays are floats throughout: two sheets 2e-7 apart are one to them, and one so near is none.
bool stability_in_floats(const FormFactorMethod *method);

FormFactor *stability_maker_of(Arena *arena, const FormFactorMethod *method, const ViewFixture *f,
                               int resolution);

double stability_share_of(const Mesh *mesh, const Row *row, int face);

// From the origin about z; the share of face 0.
double stability_share_at(Arena *arena, const FormFactorMethod *method, const ViewFixture *f, int resolution,
                          Vec3 eye);

// A rectangle x0 .. x1, y0 .. y1 at height z that looks down, turned about the z axis, shifted.
void stability_slab(Arena *arena, ViewFixture *f, Vec2 low, Vec2 high, double z, double turn, Vec3 shift);

#endif
