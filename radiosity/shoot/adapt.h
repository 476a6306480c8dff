// adapt.h - a mesh that is as fine as its light asks: elements are small where light changes, large where it is even.
#ifndef RADIOSITY_ADAPT_H
#define RADIOSITY_ADAPT_H

#include "radiosity/shoot/shoot.h"

// How fine a mesh may become.
typedef struct AdaptOptions {
    double share;     // elements there may be, of those of a mesh without splits; 0: no splits
    double few;       // so many there may be, whatever their share: small buildings need not be frugal
    double smallest;  // edge of the smallest elements, metres
    double sky[3];    // radiance, W/m^2/sr a channel
} AdaptOptions;
// As `enfilade bake` takes it.
AdaptOptions adapt_default_options(void);

// The scene of which a mesh is made.
typedef struct AdaptScene {
    const CellGraph *graph;
    const Vec3 *vertices;  // as for mesh_build
    const StabForest *forest;
    const float *door_open;
} AdaptScene;

// `options` of the mesh: their splits are found here.
bool adapt_mesh(const AdaptScene *scene, const MeshOptions *options, const AdaptOptions *adapt,
                const RadOptions *rad, const Progress *progress, Arena *arena, Mesh *out, Error *error);

#endif
