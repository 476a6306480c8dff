// lit_mesh.h - the data that the baked look draws, in memory: elements as triangles, and states of the light at their corners. Any
// thread may make the data; walk_lit.h uploads it to OpenGL.
#ifndef WALK_LIT_MESH_H
#define WALK_LIT_MESH_H

#include "engine/lit/false_colour.h"
#include "engine/scene/light.h"

typedef struct LitVertex {
    float position[3], normal[3];
    int32_t material;         // index in Building.materials
    uint8_t emits, outdoors;  // 0 or 1: does it emit? Is outdoors in front of it?
    uint8_t unused[2];
} LitVertex;

// A polygon of the graph that is drawn.
typedef struct LitFace {
    Plane plane;                       // as in the mesh when it was made
    int polygon, material;             // in the graph, in the building
    int first_vertex, first_index;     // in LitMesh.vertex and index; those of the next face end them
    int first_element, element_count;  // in LitMesh.spot and LitLight.luminous
    bool lamp, outdoors;               // lit or not; outdoors is in front of it
} LitFace;

// The triangles of the graph's polygons, in the order of the polygons. Polygons that the mesh lacks (glass) have no face.
typedef struct LitMesh {
    const CellGraph *graph;
    Vec3 origin;     // positions are relative to this point
    LitFace *faces;  // [face_count + 1] the last one ends the arrays
    int *
        first_face;  // [polygon_count + 1] in `faces`: of polygon p from first_face[p] to before first_face[p + 1], one or none
    int face_count, element_count;
    LitVertex *
        vertex;  // [vertex_count] of each face the nodes at its elements' corners, each once; leaves as when closed
    unsigned *index;
    int *lamp;  // [lamp_count] faces of lamps, lit or not
    int lamp_count;
    float (*spot)[4];  // [element_count] for the exposure: the element's middle; its area, m^2
    // Light is filled from these; NULL: no more is (lit_part.h).
    const Mesh *mesh;
    Nodes nodes;  // of the mesh
    int *node;    // [vertex_count]
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

// `of_fill` has what light is filled from: the same arena, or one that ends with the mesh once light was filled for the last time.
LitMesh *lit_mesh_new(const Mesh *mesh, Arena *arena, Arena *of_fill);
static inline int lit_vertex_count(const LitMesh *lit) { return lit->faces[lit->face_count].first_vertex; }
// The face of a polygon; NULL: it has none.
static inline const LitFace *lit_face_of(const LitMesh *lit, int polygon) {
    int f = lit->first_face[polygon];
    return f < lit->first_face[polygon + 1] ? &lit->faces[f] : NULL;
}
// Where the faces of an object begin; those of the next one, and its vertices, end it.
static inline const LitFace *lit_object_begin(const LitMesh *lit, const Object *object) {
    return &lit->faces[lit->first_face[object->first_polygon]];
}
static inline const LitFace *lit_object_end(const LitMesh *lit, const Object *object) {
    return &lit->faces[lit->first_face[object->first_polygon + object->polygon_count]];
}

// [face_count] For each face: does a face of a lower number lie in the same place, at least in part, and look the same way? Form factors
// give the light there to the lower face (radiosity/factors/view.h), and the other face stays dark.
bool *lit_twins(const Mesh *mesh, Arena *arena);

LitLight lit_light_new(const LitMesh *lit, Arena *arena);
// `doors` [opening_count]; NULL: as they stand in lit->mesh.
void lit_light_fill(const LitMesh *lit, const RadSolution *solution, const float *doors, LitLight *out);

#endif
