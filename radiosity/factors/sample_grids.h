// sample_grids.h - the directions of the projective methods, as grids of pixels.
#ifndef RADIOSITY_SAMPLE_GRIDS_H
#define RADIOSITY_SAMPLE_GRIDS_H

#include <stdbool.h>

// A rectangle of directions: `at` gives the direction (not always a unit vector) and the weight of place (i, j), 0 <= i < width,
// 0 <= j < height, or returns false where there is no direction. The directions of a row are without gaps.
typedef struct SampleGrid {
    int width, height, which;  // `which` tells `at` the grid where a method has several
    double shift[2];           // of the disc's pixels, in pixels
    bool (*at)(const struct SampleGrid *grid, int i, int j, double direction[3], double *weight);
} SampleGrid;

enum { MOST_GRIDS = 5 };

// The angle by which the disc's pixels are turned about the normal, radians; its tangent is the golden section. Unturned rows of
// pixels run along walls (the view's axes are parallel to the walls of most rooms) and all cross an edge at one place. Turned rows
// cross the edge at different places, and the form factors of an office err a quarter less at the same resolution.
#define GRIDS_TURN 0.5535743588970453

// Pixels over the unit disc; weights are equal. grids_of_disc and grids_of_hemicube return how many grids there are.
int grids_of_disc(int resolution, SampleGrid out[MOST_GRIDS]);
// The same, the pixels shifted by parts of a pixel: `shift` 0 .. 15. All shifts together make pixels of a quarter the size.
int grids_of_shifted_disc(int resolution, int shift, SampleGrid out[MOST_GRIDS]);
// Pixels of a half cube, R x R on top and R x R/2 (rounded up) on the sides, with their delta form factors.
int grids_of_hemicube(int resolution, SampleGrid out[MOST_GRIDS]);

#endif
