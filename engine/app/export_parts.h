// export_parts.h - what the files of the glTF writer share: the document as it grows.
#ifndef APP_EXPORT_PARTS_H
#define APP_EXPORT_PARTS_H

#include <jansson.h>

#include "engine/app/export_tree.h"
#include "radiosity/show/reconstruct.h"

// How a polygon is drawn: walls from their front alone, things from both sides, glass as it lets light through.
typedef enum ExportLook { EXPORT_WALL, EXPORT_THING, EXPORT_GLASS, EXPORT_LOOKS } ExportLook;

typedef struct Export {
    const Mesh *mesh;
    const CellGraph *graph;
    const float *door_open;
    Nodes nodes;
    VertexLight light;
    double exposure;  // m^2/W
    Vec3 origin;      // of positions, building space
    Arena arena;
    json_t *materials, *meshes, *accessors;
    int *material;  // [material_count * EXPORT_LOOKS] in `materials`, -1: not yet there
    // The binary part, each with its own view.
    float (*position)[3];
    uint16_t (*colour)[4];
    uint32_t *index;
    int position_count, position_capacity, colour_count, colour_capacity, index_count, index_capacity;
    // Of the primitive at hand: the vertex a node of light became.
    int *vertex, *stamp, now;  // [nodes.count]
} Export;

// Views of the binary part.
enum { EXPORT_POSITIONS, EXPORT_COLOURS, EXPORT_INDICES, EXPORT_VIEWS };

// A text as JSON; what is no UTF-8 becomes question marks.
json_t *export_text(const char *text);
// A building's material in a look, as index.
int export_material(Export *e, int material, ExportLook look);
// Does the polygon have anything to draw?
bool export_shows(const Export *e, int object, int polygon);
// The mesh of a node's objects, as index in the document.
int export_mesh(Export *e, const ExportTree *tree, const ExportNode *node);
// Nodes and cameras; returns the node of the scene.
int export_nodes(Export *e, const ExportTree *tree, json_t *nodes, json_t *cameras);

#endif
