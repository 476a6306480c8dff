// final_gather.h - the light at each node, gathered from the solution instead of interpolated between its elements.
#ifndef RADIOSITY_FINAL_GATHER_H
#define RADIOSITY_FINAL_GATHER_H

#include "engine/core/progress.h"
#include "radiosity/show/gather.h"

// Gathers the light at each node into solution->node, allocated in the arena; the same on any number of threads (0: all cores).
// False where progress asked to stop: the solution is then unchanged. `scene->light` must come from the solution without nodes.
bool final_gather(const GatherScene *scene, const GatherOptions *options, int threads,
                  const Progress *progress, Arena *arena, RadSolution *solution);

#endif
