// reflected.h - reflected light where it is shown: gathered once more in the parts of those elements within which it may change much.
#ifndef RADIOSITY_REFLECTED_H
#define RADIOSITY_REFLECTED_H

#include "radiosity/mesh/nodes.h"
#include "radiosity/show/gather.h"

// How often each element of the mesh is to be halved along each axis of its face's grid, [element_count], so that reflected light is shown
// as it changes: between neighbours that differ, and in front of close surfaces. The solution must be `gathered`.
MeshDepth *reflected_depths(const Mesh *mesh, const Nodes *nodes, const RadSolution *solution, Arena *arena);

// The irradiance by reflected light at nodes of a mesh whose elements are those of the scene's mesh, halved as often as `halved` says or
// oftener, W/m^2 a channel, into `out` [nodes->count]. `halved` NULL: no element was halved for reflected light. The same on any number of
// threads (0: all cores). False where progress asked to stop.
bool reflected_nodes(const GatherScene *scene, const MeshDepth *halved, const Mesh *shown, const Nodes *nodes,
                     int threads, const Progress *progress, double (*out)[3]);

#endif
