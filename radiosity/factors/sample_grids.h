// sample_grids.h - the directions of the projective methods, as grids of pixels.
#ifndef RADIOSITY_SAMPLE_GRIDS_H
#define RADIOSITY_SAMPLE_GRIDS_H

#include <stdbool.h>

// A rectangle of directions: `at` gives the direction (need not be a unit vector) and weight of place (i, j), 0 <= i < width,
// 0 <= j < height; false where there is none. Those there are in a row follow each other.
typedef struct SampleGrid {
    int width, height, which;  // which: of several grids, for `at`
    bool (*at)(const struct SampleGrid *grid, int i, int j, double direction[3], double *weight);
} SampleGrid;

enum { MOST_GRIDS = 5 };

// How far the disc's pixels are turned about the normal, radians: by the golden section as a slope. Rows of pixels that run
// along walls, as those of rooms do with the view's axes, all cross an edge at one place; turned, they take turns, and a row
// of an office errs a quarter less at the same resolution.
#define GRIDS_TURN 0.5535743588970453

// Pixels over the unit disc; weights are equal. Both return how many grids there are.
int grids_of_disc(int resolution, SampleGrid out[MOST_GRIDS]);
// Pixels of a half cube, R x R on top and R x R/2 (rounded up) on the sides, with their delta form factors.
int grids_of_hemicube(int resolution, SampleGrid out[MOST_GRIDS]);

#endif
