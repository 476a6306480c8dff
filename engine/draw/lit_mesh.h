// lit_mesh.h - what the baked look draws, in memory: elements as triangles, and states of the light at their corners. Made by
// whoever bakes, in any thread; walk_lit.h brings it to OpenGL.
#ifndef WALK_LIT_MESH_H
#define WALK_LIT_MESH_H

#include "engine/draw/false_colour.h"
#include "engine/scene/walk_light.h"

typedef struct LitVertex {
    float position[3], normal[3];
    int32_t material, emits;  // in Building; 0 or 1
} LitVertex;

// The graph's polygons in their order; of leaves, which move, polygons whole. What the mesh lacks (glass) has no vertices.
typedef struct LitMesh {
    const Mesh *mesh;
    Vec3 origin;                      // places are relative to it
    int *first_vertex, *first_index;  // [polygon_count + 1] in `vertex` and `index`
    LitVertex *vertex;                // leaves as when closed
    int *source;                      // [vertex_count] in Mesh.corners; of leaves the face, as -1 - face
    unsigned *index;
    Plane *plane;      // [polygon_count]
    float (*spot)[4];  // [element_count] as the eye's exposure takes it: the middle; the area, m^2
} LitMesh;

// A state of the light.
typedef struct LitLight {
    float (*vertex)[3];  // [vertex_count] W/m^2
    float *luminous;     // [element_count] light_luminous of it; 0 of lamps
    double level;        // the logarithmic mean of all that, as exposure_meter takes it by areas; 0: dark
    LightRange ranges[FALSE_COLOURS];  // of all but lamps
} LitLight;

// Where positions of a graph are relative to: floats stay exact enough far from the building's own origin.
Vec3 lit_origin(const CellGraph *graph);

LitMesh *lit_mesh_new(const Mesh *mesh, Arena *arena);
static inline int lit_vertex_count(const LitMesh *lit) {
    return lit->first_vertex[lit->mesh->graph->polygon_count];
}

LitLight lit_light_new(const LitMesh *lit, Arena *arena);
void lit_light_fill(const LitMesh *lit, const RadSolution *solution, LitLight *out);

#endif
