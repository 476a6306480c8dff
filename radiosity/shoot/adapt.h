// adapt.h - a mesh as fine as its light needs: elements are small where light changes, large where it is even.
#ifndef RADIOSITY_ADAPT_H
#define RADIOSITY_ADAPT_H

#include "radiosity/shoot/shoot.h"

// How fine a mesh may become.
typedef struct AdaptOptions {
    double share;  // the most elements, as a share of the number that a mesh without splits has; 0: no splits
    double few;    // this many elements are allowed in any case: small buildings need not be frugal
    double smallest;  // edge of the smallest elements, metres
    Daylight day;     // all zeros: night
} AdaptOptions;
// The options that `enfilade bake` uses.
AdaptOptions adapt_default_options(void);

// The scene from which a mesh is made.
typedef struct AdaptScene {
    const CellGraph *graph;
    const StabForest *forest;
    const float *door_open;
    // The member that finds the light of a part of the building (MeshOptions.part); all members call adapt_mesh. NULL: the whole building.
    TeamMember *member;
} AdaptScene;

// Makes a mesh with splits fitted to its light. `options` are the options of the mesh; their `splits` are found here.
bool adapt_mesh(const AdaptScene *scene, const MeshOptions *options, const AdaptOptions *adapt,
                const RadOptions *rad, const Progress *progress, Arena *arena, Mesh *out, Error *error);

#endif
