// blotch.h - how uneven shown light is against the truth, by the size of the blotches on the surfaces.
#ifndef BENCH_BLOTCH_H
#define BENCH_BLOTCH_H

#include "engine/core/vec.h"

// Pixels of a picture, each with the place that it shows. The arrays are the caller's.
typedef struct BlotchPixels {
    int count;
    const Vec3 *point, *normal;   // [count] metres; unit
    const double *shown, *truth;  // [count] radiosities, above 0, in one unit
} BlotchPixels;

// Band b holds blotches of 0.06 * 2^b metres to twice that.
enum { BLOTCH_BANDS = 5 };

// The root of the mean square, over the pixels, of log(shown / truth) in each band. Pixels at edges of light, where `truth` itself
// changes by a tenth within 6 cm, are left out, but never more than 40 % of all; returns the share that stays.
double blotch_bands(const BlotchPixels *pixels, double rms[BLOTCH_BANDS]);

#endif
