// bench_ray_trees.h - rows of `enfilade bench rays` about finding what a ray meets in a building.
#ifndef APP_BENCH_RAY_TREES_H
#define APP_BENCH_RAY_TREES_H

#include "engine/bench/bench.h"

// In the columns of bench_rays.c: shape is `BUILDING KIND`, ns_hit of all rays, `missed` where others meet something else than our
// own hierarchy.
BenchFile bench_ray_trees;

#endif
