// shown.h - the mesh that light is shown on: finer than the mesh that light was found on where light bends (direct.h).
#ifndef RADIOSITY_SHOWN_H
#define RADIOSITY_SHOWN_H

#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"

// The mesh and the light to show for a solution. Without finer splits (RadSolution.shown) both are those given. `door_open` is the
// state of the doors for which `mesh` was made. Power is the same on both meshes. The result lives in the arena and shares memory with
// what was given. Fails where the nodes are not those of the finer mesh.
bool shown_light(const Mesh *mesh, const RadSolution *solution, const float *door_open, Arena *arena,
                 const Mesh **shown, const RadSolution **light, Error *error);

// The same light on a finer mesh that is there already, and so may be its nodes (NULL: they are found). False: the nodes of the solution
// are not those of that mesh.
bool shown_fill(const Mesh *mesh, const RadSolution *solution, const Mesh *finer, const Nodes *nodes,
                Arena *arena, RadSolution *out);

// The finer mesh alone.
bool shown_build(const Mesh *mesh, const MeshSplits *splits, const float *door_open, Arena *arena, Mesh *out,
                 Error *error);

// The element of `mesh` in which an element of the finer mesh lies.
int shown_around(const Mesh *mesh, const Mesh *shown, int element);

// The radiosity at nodes of a finer mesh as the elements of `mesh` tell it, W/m^2, into `out` [nodes->count]. `shown` may be `mesh`.
void shown_nodes(const Mesh *mesh, const RadSolution *solution, const Mesh *shown, const Nodes *nodes,
                 double (*out)[3]);

// The mean radiosity that a solution shows on each element of `mesh`, at nodes of a finer mesh or of `mesh` itself: [mesh->element_count],
// W/m^2, in the arena.
double (*shown_means(const Mesh *mesh, const Mesh *shown, const RadSolution *solution, Arena *arena))[3];

#endif
