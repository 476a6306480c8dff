// lit_mesh.h - the data that the baked look draws, in memory: elements as triangles, and states of the light at their corners. Any
// thread may make the data; walk_lit.h uploads it to OpenGL.
#ifndef WALK_LIT_MESH_H
#define WALK_LIT_MESH_H

#include "engine/lit/false_colour.h"
#include "engine/scene/walk_light.h"

typedef struct LitVertex {
    float position[3], normal[3];
    int32_t material, emits;  // index in Building.materials; 0 or 1: does it emit
} LitVertex;

// The triangles of the graph's polygons, in the order of the polygons. Polygons that the mesh lacks (glass) have no vertices.
typedef struct LitMesh {
    const Mesh *mesh;
    Vec3 origin;                      // positions are relative to this point
    int *first_vertex, *first_index;  // [polygon_count + 1] in `vertex` and `index`
    LitVertex *vertex;                // [vertex_count] leaves as when closed
    int *source;                      // [vertex_count] index in Mesh.corners
    Nodes nodes;                      // of the mesh
    unsigned *index;
    Plane *plane;  // [polygon_count]
    int *lamp;     // [lamp_count] polygons of lamps, lit or not
    int lamp_count;
    float (*spot)[4];  // [element_count] for the exposure: the element's middle; its area, m^2
} LitMesh;

// One state of the light.
typedef struct LitLight {
    float (*vertex)[3];  // [vertex_count] radiosity, W/m^2
    bool *on;            // [lamp_count] does the polygon of a lamp shine?
    float *luminous;     // [element_count] light_luminous of the element; 0 for lamps
    Daylight day;        // that shines; all zeros: night
    double level;        // of the whole building (light_level.h), or of what the mesh has of it; 0: dark
    LightRange ranges[FALSE_COLOURS];  // a scale for each quantity, of all elements but lamps
    float *doors;                      // [opening_count] how far each door was open, where leaves were lit
} LitLight;

// The point that a graph's positions are relative to: floats stay exact enough far from the building's own origin.
Vec3 lit_origin(const CellGraph *graph);

LitMesh *lit_mesh_new(const Mesh *mesh, Arena *arena);
static inline int lit_vertex_count(const LitMesh *lit) {
    return lit->first_vertex[lit->mesh->graph->polygon_count];
}

// [face_count] For each face: does a face of a lower number lie in the same place, at least in part, and look the same way? Form factors
// give the light there to the lower face (radiosity/factors/view.h), and the other face stays dark.
bool *lit_twins(const Mesh *mesh, Arena *arena);

LitLight lit_light_new(const LitMesh *lit, Arena *arena);
// `doors` [opening_count]; NULL: as they stand in lit->mesh.
void lit_light_fill(const LitMesh *lit, const RadSolution *solution, const float *doors, LitLight *out);

#endif
