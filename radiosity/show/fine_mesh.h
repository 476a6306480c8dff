// fine_mesh.h - the fine model that stand-ins replaced (proxy.h), lit from the stand-ins: the model that is shown, exported and
// probed.
#ifndef RADIOSITY_FINE_MESH_H
#define RADIOSITY_FINE_MESH_H

#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"

typedef struct FineMesh {
    const Mesh *light;  // the mesh that light was found on
    // Equal to `light` where nothing is replaced; else its faces without stand-ins, and the fine faces, by polygon
    Mesh mesh;
    bool same;     // nothing is replaced: `mesh` equals `light`, and the fields below are not set
    int *element;  // [mesh.element_count] the element of `light`, or -1 - k: fine, lit by sources[k]
    int *patch;    // [mesh.patch_count] the patch of `light`, or -1 - e: fine, lit like element e of `mesh`
    int *corner;   // [mesh.corner_count] the corner of `light`; -1: of a fine element
    Nodes nodes;   // of `light`
    Nodes own;     // of `mesh`
    bool *fine;    // [own.count] no element of `light` has light there
    struct FineSource *sources;  // [source_count]
    int source_count;
} FineMesh;

// Makes the fine model of `light`, which must outlive the result.
FineMesh *fine_mesh_new(const Mesh *light, Arena *arena);
// The solution of `light` carried over to `mesh`; its fields `direct`, `unshot` and `rest` may be NULL, and so are the result's. The
// result shares memory with `solution` where nothing is replaced.
RadSolution fine_light(const FineMesh *fine, const RadSolution *solution, Arena *arena);

#endif
