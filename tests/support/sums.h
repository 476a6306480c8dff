// sums.h - sums over what the program makes of many buildings, held against those in references/sums.
//
// Such a test proves that nothing changed, and so notices any fault in what it sums up; that the result is right is for other tests
// to prove. ENFILADE_KEEP=1 takes the figures anew: before they are committed, say why each of them changed.
#ifndef TESTS_SUMS_H
#define TESTS_SUMS_H

#include <stdio.h>

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// A sum of numbers in their order: two that change places change the sum.
typedef struct Sum {
    int count;
    double sum;   // of the numbers, each with a weight of its own, 1 .. 2
    double size;  // of their magnitudes
} Sum;

void sum_add(Sum *sum, double x);
void sum_add2(Sum *sum, Vec2 p);
void sum_add3(Sum *sum, Vec3 p);
void sum_box(Sum *sum, Box box);
void sum_ints(Sum *sum, const int *values, int count);

// One file of references, a line a scene: its name, then `what=count:sum` for each thing that is summed up.
typedef struct SumFile {
    Arena arena;
    const char *path, *scene;
    FILE *out;              // where figures are taken anew
    char *expected, *line;  // what is left of the file, and of the scene's line
    int scenes, different;  // scenes written, sums that differ
} SumFile;

SumFile sums_begin(const char *name);
void sums_scene(SumFile *f, const char *name);
void sums_sum(SumFile *f, const char *what, Sum sum);
// The test fails where a count differs, or a sum by more than rounding: 1e-11 of the magnitudes added.
void sums_end(SumFile *f);

#endif
