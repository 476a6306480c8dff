// adapt_trees.h - quadtrees over a lit mesh: where they are worth being deep.
#ifndef RADIOSITY_ADAPT_TREES_H
#define RADIOSITY_ADAPT_TREES_H

#include "radiosity/mesh/mesh.h"

// Light on the elements of a mesh that has splits.
typedef struct AdaptField {
    const Mesh *mesh;
    const double *light;  // [element_count]
    double (*slope)[2];   // [element_count] its change along the face's grid, a metre
    double (*error)
        [2];  // [element_count] integral of the square of what its constant does not tell, by either slope
} AdaptField;
AdaptField adapt_field(const Mesh *mesh, const double *light, Arena *arena);

// How deep elements are to be where those of the mesh are, [element_count], so that about `most` tell the light with the
// least sum of squares; none smaller than `smallest` metres, nor more than `deeper` times split beyond those that there are.
// `halves`: squares, which those of the mesh must be, may be cut into rectangles.
typedef struct AdaptLimits {
    double most, smallest;
    int deeper;
    bool halves;
} AdaptLimits;
MeshDepth *adapt_depths(const AdaptField *field, const AdaptLimits *limits, Arena *arena);

#endif
