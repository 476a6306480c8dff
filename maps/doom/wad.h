// wad.h - the data that the files wad*.c share: a Doom map as its lumps have it, and its plan cut into convex pieces.
#ifndef MAPS_WAD_H
#define MAPS_WAD_H

#include "maps/building/reader.h"

// ---- wad_map.c: the lumps of one map. Lengths are map units (WAD_METRE), x east, y north, z up.

// The plan point (x / w, y / w), w > 0, without a common divisor: a vertex of the map with w = 1, or the place where two axes
// cross, never rounded.
typedef struct WadPoint {
    long long x, y, w;
} WadPoint;

// A line of the map; its front lies to the right of v[0] -> v[1].
typedef struct WadLine {
    int v[2];
    int flags, special, tag;
    int side[2];    // front and back, in WadMap.sides; -1: none
    int sector[2];  // of these sides; -1: none
} WadLine;

typedef struct WadSide {
    char upper[9], lower[9], middle[9];  // names of textures; "-": none
    int offset[2];                       // of the textures, to the left and upwards
    int sector;
} WadSide;

typedef struct WadSector {
    int floor, ceiling;
    char floor_flat[9], ceiling_flat[9];
    int light, special, tag;
} WadSector;

typedef struct WadThing {
    WadPoint at;
    int angle;  // degrees, 0 looks east
    int type;
} WadThing;

typedef struct WadMap {
    const char *path, *name;
    WadPoint *vertices;  // w = 1
    WadLine *lines;
    WadSide *sides;
    WadSector *sectors;
    WadThing *things;
    int vertex_count, line_count, side_count, sector_count, thing_count;
    Bytes content;                   // of the file
    const unsigned char *directory;  // of its lumps, in `content`
    int lump_count;
} WadMap;

// Reads the map named `name`, NULL for the first of the file. Every index in the result is in range.
bool wad_read_map(const char *path, Bytes content, const char *name, Arena *arena, WadMap *out, Error *error);

// The bytes of one of the file's lumps, and its name; no data where it is empty or does not lie within the file.
Bytes wad_lump_bytes(const WadMap *map, int lump, char name[9]);
// Eight bytes as a name in capitals, ended by a zero where it is shorter; unprintable bytes become question marks.
void wad_name(const unsigned char *bytes, char name[9]);

// Whether a line bounds nothing: it has no length, or the same sector on both sides (a trick of map makers).
bool wad_line_is_void(const WadMap *map, const WadLine *line);

// ---- wad_bsp.c: the plan between the lines as convex pieces, exactly.

// The points with a x + b y + c = 0; integers without a common divisor. The axis runs along (b, -a), with its positive
// side on the left. Coordinates have 16 bits, so |a|, |b| < 2^17 and |c| < 2^34.
typedef struct WadAxis {
    long long a, b, c;
} WadAxis;

// An edge of a piece, from `from` to where the next edge of the piece begins.
typedef struct WadEdge {
    WadPoint from;
    int axis;
    int side;  // +1 or -1: the side of the axis on which the piece lies
} WadEdge;

typedef struct WadPiece {
    int first_edge, edge_count;  // counter-clockwise, no two neighbours on one axis
    int sector;                  // -1: outside all of them
} WadPiece;

typedef struct WadPieces {
    WadAxis *axes;
    WadEdge *edges;
    WadPiece *pieces;
    int *line_axis;  // [line_count] the line's axis; -1: the line bounds nothing
    // The lines along axis i are spans[first_span[i]] .. spans[first_span[i + 1] - 1]; their fields are private to wad_sectors.c.
    struct WadSpan *spans;
    int *first_span;  // [axis_count + 1]
    int axis_count, edge_count, piece_count;
    int edge_capacity, piece_capacity;
} WadPieces;

// Cuts the plan and a margin around it along the map's lines, until no line runs inside a piece. The sectors of the
// pieces are found later, by wad_find_sectors.
bool wad_cut_plan(const WadMap *map, Arena *arena, WadPieces *out, Error *error);

int wad_side_of(const WadAxis *axis, WadPoint p);  // +1 on the positive side, -1 on the other, 0 on it
double wad_x(WadPoint p);                          // correctly rounded: equal points have equal coordinates
double wad_y(WadPoint p);
// The position of a point along its axis: increasing in the axis's direction, map units.
double wad_along(const WadAxis *axis, WadPoint p);

// ---- wad_sectors.c: which sector each piece belongs to; fewer and larger pieces.

// A stretch along an axis on which a piece on its positive side meets one on its other side.
typedef struct WadContact {
    int axis;
    int piece[2];      // on the positive and on the other side
    int edge[2];       // in WadPieces.edges
    double low, high;  // along the axis
    bool open;         // no line runs there
} WadContact;

// Fills pieces->spans and pieces->first_span, which all functions below use.
void wad_index_lines(const WadMap *map, WadPieces *pieces, Arena *arena);
// Returns the line on an edge of a piece at the position `along` (see wad_along), or -1 where there is none. `facing` receives the
// side of the line that faces the piece: 0 its front, 1 its back.
int wad_line_at(const WadMap *map, const WadPieces *pieces, const WadEdge *edge, double along, int *facing);
// Lists all contacts of the pieces in `arena`; returns how many there are.
int wad_find_contacts(const WadPieces *pieces, Arena *arena, WadContact **out);

// Gives every piece its sector by the lines around it, or by its neighbours where no line is between. A sector that is
// not closed is noted on the building.
void wad_find_sectors(const WadMap *map, WadPieces *pieces, Arena *arena, Building *b);
// Joins neighbouring pieces of one sector whose union is convex.
void wad_merge(WadPieces *pieces, Arena *arena);

// ---- wad_movers.c: the sectors that move.

// The heights of a sector with its leaf, the part that moves, out of the way, and the heights of the leaf. Map units.
typedef struct WadMover {
    enum {
        WAD_FIXED,
        WAD_DOOR,   // its ceiling rises
        WAD_HATCH,  // closed like a door, but its floor sinks
        WAD_LIFT    // its floor sinks; can be seen over at all times
    } motion;
    int floor, ceiling;
    int low, high;  // of the leaf when closed; a lift's as drawn
    double open;    // as drawn, 0 .. 1
} WadMover;

// Returns one mover for each sector, in `arena`.
WadMover *wad_find_movers(const WadMap *map, Arena *arena);

// ---- wad_textures.c: pictures of the file.

typedef struct WadPictures WadPictures;
WadPictures *wad_open_pictures(const WadMap *map, Arena *arena, Arena *scratch, Building *b);
// The building's texture for a flat or a wall texture and its sides in texels; 0 where the file has none.
int wad_texture(WadPictures *pictures, const char *name, bool flat, int *width, int *height);
// Adds a note that names what a file with a palette lacked.
void wad_note_missing(WadPictures *pictures);

// ---- wad_materials.c, wad_regions.c, wad_openings.c: materials, regions and doors of the building.

typedef struct WadBuilder {
    const WadMap *map;
    const WadPieces *pieces;
    const WadMover *movers;
    Arena *arena;    // of the building
    Arena *scratch;  // for use while reading
    Building *building;
    int *first_region;  // [piece_count + 1] regions of piece i: first_region[i] .. first_region[i + 1] - 1
    int *materials;     // a hash table, see wad_materials.c
    WadPictures *pictures;
} WadBuilder;

// Opens the file's pictures and adds its sky to the building.
void wad_begin_materials(WadBuilder *builder);

// Adds a region for each piece of a sector that has a height; regions share their vertices with all neighbours.
void wad_add_regions(WadBuilder *builder);
// Adds a door for each part of a sector that moves.
void wad_add_openings(WadBuilder *builder);
// The material of the wall seen from inside a piece of `sector` at the position `along` (see wad_along) on the piece's edge, above or
// below the opening there; where nothing lies behind the wall, both are one.
int wad_wall_material(WadBuilder *builder, const WadEdge *edge, int sector, double along, bool above);
// Whether the wall there shows more above the opening than below it.
bool wad_wall_is_upper(const WadBuilder *builder, const WadEdge *edge, int sector, double along);
// The material of a floor or ceiling.
int wad_level_material(WadBuilder *builder, const char *flat, int sector);

// Metres in a map unit: customarily 32 units are a metre, and 31 mm keeps whole units on the grid of the plan.
#define WAD_METRE 0.031
// The same in whole steps of that grid, so that no coordinate is rounded twice.
#define WAD_MILLIMETRES 31
static inline double wad_metres_of(double units) { return WAD_MILLIMETRES * units / 1000; }

#endif
