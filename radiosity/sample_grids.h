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

// Pixels over the unit disc; weights are equal. Both return how many grids there are.
int grids_of_disc(int resolution, SampleGrid out[MOST_GRIDS]);
// Pixels of a half cube, R x R on top and R x R/2 (rounded up) on the sides, with their delta form factors.
int grids_of_hemicube(int resolution, SampleGrid out[MOST_GRIDS]);

#endif
