// figures.h - sums over what the program makes of many buildings, held against those in references/figures.
//
// Such a test proves that nothing changed, and so notices any fault in what it sums up; that the result is right is for other tests
// to prove. ENFILADE_KEEP=1 takes the figures anew: before they are committed, say why each of them changed.
#ifndef TESTS_FIGURES_H
#define TESTS_FIGURES_H

#include <stdio.h>

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// Of numbers in their order: two that change places change the sum.
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
typedef struct Figures {
    Arena arena;
    const char *path, *scene;
    FILE *out;              // where figures are taken anew
    char *expected, *line;  // what is left of the file, and of the scene's line
    int scenes, different;  // scenes written, sums that differ
} Figures;

Figures figures_begin(const char *name);
void figures_scene(Figures *f, const char *name);
void figures_sum(Figures *f, const char *what, Sum sum);
// The test fails where a count differs, or a sum by more than rounding: 1e-11 of the magnitudes added.
void figures_end(Figures *f);

#endif
