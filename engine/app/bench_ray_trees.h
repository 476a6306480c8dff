// bench_ray_trees.h - rows of `enfilade bench rays` about finding what a ray meets in a building.
#ifndef APP_BENCH_RAY_TREES_H
#define APP_BENCH_RAY_TREES_H

#include "engine/app/bench.h"

// The columns of its rows.
extern const char BENCH_RAY_TREES_HEAD[];
BenchFile bench_ray_trees;

#endif
