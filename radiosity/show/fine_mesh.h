// fine_mesh.h - the fine model that stand-ins were there for (proxy.h), lit from them: the model that is shown, exported and probed.
#ifndef RADIOSITY_FINE_MESH_H
#define RADIOSITY_FINE_MESH_H

#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"

typedef struct FineMesh {
    const Mesh *light;  // the mesh that light was found on
    Mesh
        mesh;  // the same where nothing stands in; else its own faces and the fine ones, in order of polygons
    bool same;                   // it is
    int *element;                // [mesh.element_count] that of `light`, or -1 - k: sources[k]
    int *patch;                  // [mesh.patch_count] that of `light`, or -1 - e: as that element has it
    int *corner;                 // [mesh.corner_count] that of `light`; -1: of a fine element
    Nodes nodes;                 // of `light`
    struct FineSource *sources;  // [source_count]
    int source_count;
} FineMesh;

// `light` stays where it is.
FineMesh *fine_mesh_new(const Mesh *light, Arena *arena);
// A solution of `light`, on `mesh`. Shares memory with it where nothing stands in.
RadSolution fine_light(const FineMesh *fine, const RadSolution *solution, Arena *arena);

#endif
