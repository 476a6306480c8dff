// final_gather.h - the light at each node, gathered from the solution instead of interpolated between its elements.
#ifndef RADIOSITY_FINAL_GATHER_H
#define RADIOSITY_FINAL_GATHER_H

#include "engine/core/progress.h"
#include "radiosity/show/gather.h"

// Into solution->node, in the arena; the same on any number of threads (0: all cores). False, and the solution as it was, where
// progress asked to stop. `scene->light` is what is seen, of the solution without nodes.
bool final_gather(const GatherScene *scene, const GatherOptions *options, int threads,
                  const Progress *progress, Arena *arena, RadSolution *solution);

#endif
