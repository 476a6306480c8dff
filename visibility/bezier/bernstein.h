// bernstein.h - polynomials in Bernstein's basis: sum c[i] binomial(n, i) s^i (1 - s)^(n - i), 0 <= s <= 1.
#ifndef RAYS_BERNSTEIN_H
#define RAYS_BERNSTEIN_H

#include <stdbool.h>

#include "visibility/bezier/ray.h"

enum { BERNSTEIN_DEGREE = 6 };  // the highest there may be

// Its value, and its slope there; degree 1 at least.
double bernstein_value(const double *c, int degree, double s, double *slope);
// The same polynomial with `low` .. `high` as its 0 .. 1.
void bernstein_cut(double *c, int degree, double low, double high);
// The first `max` roots in rising order, by Bezier clipping; a multiple root, or an extremum within slack of 0, is one.
int bernstein_roots(const double *c, int degree, double slack, double *root, int max, CurvedWork *work);

#endif
