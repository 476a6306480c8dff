// bends.h - where light bends within elements, so that light between their corners is not linear: trees of halves, from which a finer
// mesh is made.
#ifndef RADIOSITY_BENDS_H
#define RADIOSITY_BENDS_H

#include "radiosity/mesh/mesh.h"

// An element that is halved, or a part of it.
typedef struct Bend Bend;

// Halves an element of a mesh with splits until, in each part, linear light between the corners is near enough to the light at the middle
// and at the middles of the sides, or the part is 2.5 cm long. `corner` [corner_count of the element] is the light at its corners, `at`
// tells the light at a point; `rest` is other light on the element, which counts as even. `edge`, if not NULL, tells whether a shadow's
// edge may pass a part: such parts are looked into also where none of these points is off, and halved until they are 1 cm long. NULL: light
// does not bend in the element. The result lives in the arena.
Bend *bend_find(const Mesh *mesh, int element, const double *corner, double (*at)(void *context, Vec3 point),
                bool (*edge)(void *context, const Vec3 *corner, int count), void *context, double rest,
                Arena *arena);

// Splits of a finer mesh: as deep as the elements of the mesh, and as their bends [element_count] ask for. Where that would take more
// than `most` further elements, the bends that are least off are left out. NULL: nothing bends.
MeshSplits *bend_splits(const Mesh *mesh, Bend *const *bends, double most, Arena *arena);

#endif
