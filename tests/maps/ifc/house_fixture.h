// house_fixture.h - small building models, written as STEP files: boxes that are spaces, walls, slabs, doors and windows.
//
// Coordinates are metres in the building; the file has them in its own unit, at the place and turn of its site.
#ifndef TESTS_HOUSE_FIXTURE_H
#define TESTS_HOUSE_FIXTURE_H

#include "engine/core/text.h"
#include "maps/maps.h"

typedef struct House {
    Arena *arena;
    Text text;
    int next;        // entity
    double metre;    // of the file's unit in a metre
    int storeys[4];  // entities
    int placed;      // the building's placement
    int storey_count;
} House;

// Begins a file whose unit is the metre, or the foot; its site lies at `site` and is turned, radians counter-clockwise.
House house_begin(Arena *arena, bool feet, Vec2 site, double turn);
int house_storey(House *h, const char *name, double elevation);
// An upright box from `low` to `high`, a product of the type (IFCWALL, IFCSLAB ...) on a storey. Returns its entity.
int house_box(House *h, const char *type, const char *name, int storey, Vec3 low, Vec3 high);
int house_space(House *h, const char *number, const char *name, int storey, Vec3 low, Vec3 high);
// The same of a faceted boundary: a house's end whose ridge runs along x at half the depth, `ridge` high.
int house_attic(House *h, const char *number, const char *name, int storey, Vec3 low, Vec3 high,
                double ridge);
// A piece of furniture: the six faces of a box as sheets. Faces whose bits are set in `turned` show their backs to the outside.
int house_sheets(House *h, const char *name, int storey, Vec3 low, Vec3 high, unsigned turned);
void house_part(House *h, int whole, int part);
// A box cut out of a product.
int house_hole(House *h, int host, Vec3 low, Vec3 high);
// A door that fills a hole: its own x axis begins at `hinge` and runs along `along`; it opens to its left.
int house_door(House *h, int hole, const char *name, Vec3 hinge, Vec2 along, double width, double height,
               const char *operation);
// It has two leaves, which touch in the middle, where the operation begins with DOUBLE.
// A door whose leaf touches both posts of its lining and is flush with their left face, 4 cm thick, with a handle on the other side.
int house_tight_door(House *h, int hole, const char *name, Vec3 hinge, Vec2 along, double width,
                     double height);
// A window likewise: a frame of four bars, without glass, or one with a pane.
int house_window(House *h, int hole, const char *name, Vec3 low, Vec2 along, double width, double height);
Bytes house_end(House *h);

// Four walls around a rectangle, 0.2 m thick, outside of it. Returns the first of their entities: south, east, north, west.
void house_walls(House *h, int storey, Vec3 low, Vec3 high, int walls[4]);
// Two rooms of 4 x 3 m, `west` and `east`, 2.5 m high, the wall between them at x 4 to 4.2, with a door in it.
House house_two_rooms(Arena *arena, bool feet, Vec2 site, double turn, bool spaces);

// Reads a building that must read.
void house_read(Arena *arena, Bytes file, Building *b);
// The opening of a name, and how many notes hold some text.
const Opening *house_opening(const Building *b, const char *name);
int house_notes(const Building *b, const char *text);
// The region of a name that is the largest; fails where there is none.
const Region *house_room(const Building *b, const char *name);

#endif
