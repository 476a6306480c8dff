// ifc_building.h - a Building from an IfcModel: what its files share.
//
// Spaces become rooms, walls become walls, each on every storey through which it reaches; openings in walls, with the doors and windows
// that fill them, become the openings of the plan; what stands in rooms becomes objects. maps_enclose finds the free space. So a space
// that overlaps a wall gives way to it, and one that ends short of a wall is widened to it.
#ifndef MAPS_IFC_BUILDING_H
#define MAPS_IFC_BUILDING_H

#include "engine/core/box_tree.h"
#include "maps/building/building.h"
#include "maps/building/sketch.h"
#include "maps/ifc/ifc.h"
#include "maps/ifc_building/solid_outline.h"
#include "maps/polygons/soup_readers.h"

// A space that becomes a room.
typedef struct IfcRoom {
    int product;
    int storey;  // in Building.storeys
    SolidOutlines outline;
    double z0, z1, area;
    const char *name;
} IfcRoom;

// An opening of the sketch, and where it comes from.
typedef struct IfcHole {
    int product;        // the door, window, or the opening that nothing fills
    Vec2 centre, u, n;  // plan: its width runs along u; n to its left
    double width, depth, z0, z1;
} IfcHole;

typedef struct IfcPlan {
    const IfcModel *model;
    const char *path;
    Arena *arena;  // of the building
    Arena scratch;
    Building *b;
    Sketch sketch;
    SolidTracer *tracer;   // in scratch
    IfcRoom *rooms;        // smaller ones first, so that a room within a larger one keeps its place
    IfcHole *holes;        // [sketch.opening_count]
    SolidOutlines *walls;  // [product_count] the parts of the plan that a wall covers
    // Boxes of rooms, and of walls that bound rooms by product; trees over them, and the last hits.
    Box *room_box, *wall_box;
    BoxTree room_tree, wall_tree;
    BoxHits near;
    int *floors;  // [floor_count] products: the slabs and coverings that have a body
    int floor_count, floor_capacity;
    int *first_part, *parts;  // the parts of product i: parts[first_part[i]] .. parts[first_part[i + 1] - 1]
    int *storey;              // [model->storey_count] the building's storey, -1: it became none
    int *material;            // [model->material_count] of the building, -1: not yet
    int *pictured;      // [model->material_count] the same with its picture; -1: it has none, or not yet
    int *texture;       // [model->texture_count] of the building, 0: none, -1: not yet
    SoupReader beside;  // reads pictures beside the model
    double pixels;      // of pictures that may still be decoded (texture_add)
    int room_count, room_capacity, hole_capacity;
    int wall_material, floor_material, ceiling_material, door_material, thing_material, glass_material;
    NoteTally no_body, recesses, small_holes, roof_windows, low_doors, too_many, unbuilt;
} IfcPlan;

// ---- ifc_building_looks.c
const char *ifc_name(const IfcPlan *p, int product);   // of a space its number and its name
const char *ifc_place(const IfcPlan *p, int product);  // for notes: #12 door `D-1`
int ifc_material(IfcPlan *p, int material,
                 int otherwise);  // in the building; `otherwise` for polygons without a style
int ifc_pictured(IfcPlan *p, int material, int otherwise);  // the same for polygons on which its picture lies

// ---- ifc_building_plan.c
bool ifc_plan_storeys(IfcPlan *p, Error *error);  // finds rooms, too
void ifc_plan_rooms(IfcPlan *p);
void ifc_plan_walls(IfcPlan *p);
void ifc_plan_floors(IfcPlan *p);                            // holes in floors, the ground
bool ifc_is_stair(const IfcModel *m, const IfcProduct *it);  // flights, ramps, and the landings between them
// The storey on which something stands whose foot is at this height.
int ifc_storey_at(const IfcPlan *p, double z);
// The mean of a polygon's corners, and the box around them.
Vec3 ifc_middle(const Vec3 *corners, int count, Box *box);
// The room of a storey, or of any (-1), in which a place is; -1: none.
int ifc_room_at(IfcPlan *p, int storey, Vec3 place);

// ---- ifc_building_openings.c
void ifc_plan_openings(IfcPlan *p);
// Holds each door's opening against the spaces on both its sides; notes doors that do not join these.
void ifc_check_doors(IfcPlan *p);

// ---- ifc_building_objects.c
void ifc_add_objects(IfcPlan *p);
// Adds the polygons of a mesh as an object. Returns it, -1 where nothing is left.
int ifc_add_mesh(IfcPlan *p, const IfcMesh *mesh, ObjectKind kind, const char *name, int otherwise);

#endif
