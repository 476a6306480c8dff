// ifc.h - a building model (IFC2X3, IFC4, IFC4X3) as its STEP file has it: storeys, products, and the mesh of each product.
//
// All lengths are metres, z up, relative to IfcModel.origin, so that models at the coordinates of a country keep their digits.
// The model knows no rooms, cells or doorways yet: maps/ifc turns products into meshes and footprints, and a reader makes a Building
// of them.
#ifndef MAPS_IFC_H
#define MAPS_IFC_H

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/file.h"
#include "engine/core/vec.h"

// The kinds of products. A type of the schema that is none of these is IFC_OTHER; IfcProduct.type tells which it is.
typedef enum IfcKind {
    IFC_OTHER,
    IFC_SPACE,
    IFC_WALL,
    IFC_SLAB,
    IFC_DOOR,
    IFC_WINDOW,
    IFC_OPENING,
    IFC_STAIR,  // the flights as well
    IFC_RAMP,   // the flights as well
    IFC_COLUMN,
    IFC_BEAM,
    IFC_COVERING,
    IFC_FURNISHING,  // furniture, sanitary and electric appliances
    IFC_ROOF,
    IFC_CURTAIN_WALL,
    IFC_RAILING,
    IFC_MEMBER,
    IFC_PLATE,
    IFC_LIGHT,
    IFC_SITE,     // the ground, roads and bridges
    IFC_UNBUILT,  // members of the model for structural analysis, zones, referents: no part of the building
    IFC_KINDS
} IfcKind;

// The look of polygons. Entry 0 of IfcModel.materials is that of polygons without a style.
typedef struct IfcMaterial {
    const char *name;  // of the style or the material; ""
    float colour[3];   // 0 .. 1, as on a screen (sRGB)
    float alpha;       // 1 opaque, 0 clear
    int texture;       // in IfcModel.textures; 0: none
} IfcMaterial;

// A picture: a file beside the model, the bytes of such a file, or pixels.
typedef struct IfcTexture {
    int entity;
    const char *file;  // as the model names it; NULL: none
    Bytes image;       // size 0: none
    uint8_t *pixels;   // [height * width * 4] from the top: red, green, blue, opacity; NULL: none
    int width, height;
} IfcTexture;

// A planar convex polygon, counter-clockwise seen from outside the body.
typedef struct IfcPolygon {
    int first_corner, corner_count;  // in IfcMesh.corners
    int material;                    // in IfcModel.materials
} IfcPolygon;

// The polygons of one product.
typedef struct IfcMesh {
    Vec3 *corners;
    // [corner_count] places in the picture of the polygon's material, (0, 0) its top left corner, (1, 1) its bottom right one; NAN: no
    // picture lies on the polygon. NULL: on none.
    Vec2 *places;
    IfcPolygon *polygons;
    int corner_count, polygon_count;
} IfcMesh;

// An upright prism that is one item of a product's body, before openings and half spaces are cut off.
typedef struct IfcFootprint {
    int first_ring,
        ring_count;  // in IfcModel.rings: the outer one, counter-clockwise from above, then holes, clockwise
    double base, top;
    bool clipped;  // half spaces or solids cut something off this prism: the mesh tells what is left
} IfcFootprint;

typedef struct IfcRing {
    int first_point, point_count;  // in IfcModel.points
} IfcRing;

typedef struct IfcProduct {
    int entity;  // #entity in the file
    IfcKind kind;
    const char *type;                            // as the file writes it: "IFCWALLSTANDARDCASE"
    const char *guid;                            // GlobalId
    const char *name, *long_name, *object_type;  // UTF-8, "" where the file says nothing; long_name of spaces
    const char *predefined;  // the enumerator of its predefined type ("FLOOR", "CEILING", "INTERNAL"), or ""
    int storey;              // in IfcModel.storeys, by containment, whole or host; -1: none
    int space;               // the product, a space, that contains it; -1
    int whole;  // the product that it is a part of (the roof of a slab, the stair of a flight); -1
    int host;  // of an opening: the product that it voids; of a door or window: the opening that it fills; -1
    double width, height;   // of doors and windows: overall, metres; 0: not told
    const char *operation;  // of doors: "SINGLE_SWING_LEFT" and so on, of the door or of its style; ""
    // Its own axes in the model, of unit length, and its place.
    Vec3 axis[3], place;
    IfcMesh
        mesh;  // the body with its openings cut out: what is seen. Of an opening: the solid that is cut out
    IfcMesh whole_mesh;  // before openings were cut out; the same arrays as `mesh` where it has none
    int first_footprint,
        footprint_count;  // in IfcModel.footprints; as many as items only if all are upright prisms
    int item_count;       // solids and surfaces of the body
    Box box;              // of whole_mesh; empty where there is none
} IfcProduct;

typedef struct IfcStorey {
    int entity;
    const char *guid, *name;
    double elevation;  // of its floor, relative to IfcModel.origin: from its placement
} IfcStorey;

// A space has an element at its boundary, as the file claims.
typedef struct IfcBoundary {
    int space, element;  // products; element -1 where it is missing or virtual
    bool physical;       // else a boundary in the air
    bool external;       // beyond the element is the outside
} IfcBoundary;

// A part of the file that could not be used, or was not understood: `#123 IFCBSPLINESURFACE of door "D-1": ...`.
typedef struct IfcNote {
    int entity, product;  // product -1: of none
    const char *text;
} IfcNote;

typedef struct IfcModel {
    const char *schema;          // "IFC2X3", "IFC4", "IFC4X3_ADD2" ...
    const char *name;            // of the project or building
    Vec3 origin;                 // metres; add it to coordinates to get those of the file
    bool placed;                 // latitude and longitude are known
    double latitude, longitude;  // radians north and east
    double north;                // direction of north in the plan, radians clockwise from +y
    double unit;                 // metres a unit of length of the file
    IfcStorey *storeys;          // by elevation
    IfcProduct *products;        // in order of the file; spaces and openings among them
    IfcMaterial *materials;
    IfcTexture *textures;  // entry 0 is none
    IfcFootprint *footprints;
    IfcRing *rings;
    Vec2 *points;
    IfcBoundary *boundaries;
    IfcNote *notes;  // at most IFC_MOST_NOTES, then one that tells how many more
    int storey_count, product_count, material_count, texture_count, footprint_count, ring_count, point_count,
        boundary_count, note_count;
    long long polygon_count;  // of all products
} IfcModel;

// How ifc_read is to read.
typedef struct IfcOptions {
    int threads;        // 0: as many as there are processors
    int circle_chords;  // the least chords of a whole circle, 8 .. 256
} IfcOptions;
static inline IfcOptions ifc_default_options(void) { return (IfcOptions){0, 24}; }

enum { IFC_MOST_NOTES = 1000 };

// Does a file begin as a STEP file does?
bool ifc_recognise(Bytes content);
// Reads a model; all of it is allocated in `arena`. `path` is for messages. The same bytes on any number of threads. Fails with a
// sentence that names the line where the file is no STEP file, or is damaged; products that cannot be used are notes.
bool ifc_read(const char *path, Bytes content, const IfcOptions *options, Arena *arena, IfcModel *out,
              Error *error);

// "wall", "space", ...
const char *ifc_kind_name(IfcKind kind);

#endif
