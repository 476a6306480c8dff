// sample_grids.c - pixels of the hemisphere's base and of the hemicube as directions with weights.
//
// Disc: a unit hemisphere's points lie over the unit disc, and equal areas of the disc are equal shares of the light that leaves
// the centre (Nusselt 1928). Half cube: a pixel's share is its area times 1 / (pi (x^2 + y^2 + 1)^2) on top,
// z / (pi (y^2 + z^2 + 1)^2) on a side (Cohen & Greenberg 1985).
#include "radiosity/factors/sample_grids.h"

#include <math.h>

// Samples are shifted from their pixels' centres by this share of the disc's radius or of half the cube's side. Without the shift,
// the corners of a box-shaped room seen from the middle of a patch would lie exactly on samples, and three edges that meet there,
// each right to a rounding, might leave a hole between them.
static const double HAIR_X = 6.18e-6, HAIR_Y = -4.36e-6;

static bool over_disc(const SampleGrid *grid, int i, int j, double w[3], double *weight) {
    w[0] = 2 * (i + 0.5 + grid->shift[0]) / grid->width - 1 + HAIR_X;
    w[1] = 2 * (j + 0.5 + grid->shift[1]) / grid->height - 1 + HAIR_Y;
    double left = 1 - w[0] * w[0] - w[1] * w[1];
    if (left <= 0) return false;
    w[2] = sqrt(left);
    *weight = 1;
    return true;
}

int grids_of_disc(int resolution, SampleGrid out[MOST_GRIDS]) {
    out[0] = (SampleGrid){.width = resolution, .height = resolution, .at = over_disc};
    return 1;
}

int grids_of_shifted_disc(int resolution, int shift, SampleGrid out[MOST_GRIDS]) {
    int count = grids_of_disc(resolution, out);
    // Never by half a pixel or more, so that all pixels whose middles are inside the disc are among resolution x resolution.
    out[0].shift[0] = shift % 4 * 0.25 - 0.375;
    out[0].shift[1] = shift / 4 * 0.25 - 0.375;
    return count;
}

enum { TOP = 4 };

// The sides 0 .. 3 look along x, y, -x, -y, each from the horizon up.
static bool on_cube(const SampleGrid *grid, int i, int j, double w[3], double *weight) {
    double u = 2 * (i + 0.5) / grid->width - 1 + HAIR_X;
    if (grid->which == TOP) {
        double v = 2 * (j + 0.5) / grid->height - 1 + HAIR_Y, s = u * u + v * v + 1;
        w[0] = u, w[1] = v, w[2] = 1;
        *weight = 2.0 / grid->width / (s * s);
        return true;
    }
    static const double AHEAD[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    double z = (j + 0.5) / grid->height + HAIR_X, s = u * u + z * z + 1;
    const double *a = AHEAD[grid->which];
    w[0] = a[0] - u * a[1];
    w[1] = a[1] + u * a[0];
    w[2] = z;
    *weight = z / grid->height / (s * s);
    return true;
}

int grids_of_hemicube(int resolution, SampleGrid out[MOST_GRIDS]) {
    out[0] = (SampleGrid){.width = resolution, .height = resolution, .which = TOP, .at = on_cube};
    for (int side = 0; side < TOP; side++)
        out[side + 1] =
            (SampleGrid){.width = resolution, .height = (resolution + 1) / 2, .which = side, .at = on_cube};
    return 5;
}
