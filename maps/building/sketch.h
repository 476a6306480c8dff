// sketch.h - the plan of a building as people draw it: storeys, walls, rooms, openings, holes in floors. It may
// be wrong in any way a drawing can be; maps_enclose finds the free space in it.
//
// Readers of drawn plans fill a Sketch for the plan and append furniture, materials, lights and viewpoints
// straight to the Building.
#ifndef MAPS_SKETCH_H
#define MAPS_SKETCH_H

#include "maps/building/building.h"

// A wall's outline in plan, any simple polygon; between absolute heights z0 and z1.
//
// A wall that reaches its storey's ceiling bounds rooms. A lower wall bounds them too, as if it were as high as its storey, where it is
// at least SKETCH_LEAST_ROOM high and, with all such walls taken as high as the storey,
// - it reaches the ceilings of the rooms drawn on both its sides, which have ceilings of their own (SketchRoom.z1), or
// - it parts two enclosed spaces, or a room drawn with a ceiling from the outdoors.
// Every other lower wall is an object in the room, over which one sees. The reason: people give inner walls the height that they know
// from their house (2.44 m), and leave the storey as the program had it (3.66 m); they mean rooms, and the gap above is nobody's. But
// what divides one room is lower than a door, and what fences a garden has no ceiling.
typedef struct SketchWall {
    int storey;
    // In Sketch.points; edge i has side material edge_material[first_point + i].
    int first_point, point_count;
    double z0, z1;      // z1: its highest point
    double angle;       // direction of its axis, radians
    const char *place;  // for messages: `wall wall-12 at (3.20, 1.50)`
    int top_material;   // seen where the wall stays an object
} SketchWall;

// Metres: the lowest ceiling under which people live (7 feet, 2.13 m, in the International Residential Code, R305.1; less 3 cm for
// rounding). Doors are lower, and so are screens, counters and parapets.
#define SKETCH_LEAST_ROOM 2.1

typedef struct SketchRoom {
    int storey;
    int first_point, point_count;  // a simple polygon, either way round
    const char *name, *place;
    int floor_material, ceiling_material;
    double z0, z1;  // absolute; NAN: the storey's
    double wall;    // > 0: walls of this thickness outside its outline close the room (plans without walls)
    int wall_material;  // of those walls, seen from inside
    bool
        open_above;  // drawn without a ceiling: a garden, a terrace; walls that enclose it enclose it all the same
} SketchRoom;

enum { SKETCH_MAX_LEAVES = 4 };

// An object that is a leaf of the opening's model holds the opening's index in Object.opening, and the leaf's index in
// `leaves` in Object.leaf.
typedef struct SketchOpening {
    OpeningKind kind;
    int storey;
    Vec2 centre;   // plan
    double angle;  // of its width axis, radians
    double width, depth;
    double sill, head;  // absolute
    bool glazed;
    int hinge;  // of a door: 0: at -width/2, 1: at +width/2, 2: a leaf at each
    // Radians from closed to open, counter-clockwise from above; of two leaves the swing of the one at -width/2.
    double swing;
    // Metres that a leaf slides along the width axis instead of turning; two leaves slide apart, each by this.
    double slide;
    double open;  // as drawn, see Opening
    int material;
    // The leaves of its model (see Leaf); where the model has none, maps_enclose makes leaves from the fields above.
    Leaf leaves[SKETCH_MAX_LEAVES];
    int leaf_count;
    // The cut-out, if not a rectangle: a simple polygon in the unit square, x along the width, y up.
    int first_cutout, cutout_count;  // in Sketch.points
    const char *name, *place;
} SketchOpening;

// A hole through the slab below `storey`.
typedef struct SketchCutout {
    int storey;
    int first_point, point_count;
    const char *place;
} SketchCutout;

// A plan as drawn, for maps_enclose. One thread uses it. The arrays live in the caller's arena; after maps_enclose only the names
// are still needed.
typedef struct Sketch {
    SketchWall *walls;
    SketchRoom *rooms;
    SketchOpening *openings;
    SketchCutout *cutouts;
    Vec2 *points;
    int *edge_material;  // [point_count], used by walls
    // How the picture of a material counts lengths (to the right, upwards, 0) from where a surface begins, for readers that begin it
    // anew on ends and jambs of walls: [lengths_count] by material; all 0: not so.
    TextureMap *lengths;
    int wall_count, room_count, opening_count, cutout_count, point_count;
    int wall_capacity, room_capacity, opening_capacity, cutout_capacity, point_capacity, edge_capacity;
    int lengths_count, lengths_capacity;
    double ground;  // height of the ground outdoors
    // The materials of the ground, of walls that name none, and of the edges of slabs.
    int ground_material, outer_material, slab_material;
} Sketch;

// Finds the free space (regions) and the openings between the regions, and appends them to `b`, whose storeys,
// materials and objects are already there. GEOS computes the plan geometry on the 1 mm grid. Rooms that are not
// enclosed and parts that cannot be used are noted in `b`, and the rest is still made; fails when nothing is left, the
// plan has too many pieces, or coordinates exceed MAPS_LIMIT.
bool maps_enclose(const Sketch *sketch, Building *b, Arena *arena, Error *error);

#endif
