// building.h - the data of a building, from any file.
//
// Free space is a set of disjoint prisms, the regions: a plan polygon between two heights. Space outside all
// regions is solid (walls, slabs, soil) or beyond the world. Where two regions touch, each can be seen from the
// other; everywhere else their boundary is an opaque surface. Walls, floors and ceilings are therefore not stored
// as polygons: the cell stage makes them from the regions, watertight by construction. Furniture and details are
// polygons of their own, grouped in objects.
//
// This form, a building of regions, is that of plans, homes and Doom maps. Two other forms have no regions: a soup is
// polygons alone, among which the cell stage finds the cells; the third form is convex cells and their portals
// alone, as visibility compilers exchange them, with nothing to draw or to walk on.
//
// All plan coordinates and heights of regions are multiples of 1 mm (maps_snap), and regions that touch share
// their plan vertices exactly: if the boundaries of two regions overlap along a line, they have the same vertices
// there. Only a region that is already convex, to within MAPS_DENT, may have vertices off the grid: it becomes one
// cell without being cut, and the lines that partition a plan may cross anywhere. building_check names faults
// against these rules.
#ifndef MAPS_BUILDING_H
#define MAPS_BUILDING_H

#include <stdint.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/vec.h"
#include "maps/building/curved.h"
#include "maps/building/photometry.h"

// The three channels of a spectrum: shares or W/m^2, as said at each field of this type.
typedef struct Rgb {
    float r, g, b;
} Rgb;
// The same channels as doubles.
static inline void rgb_doubles(Rgb from, double out[3]) {
    out[0] = (double)from.r;
    out[1] = (double)from.g;
    out[2] = (double)from.b;
}
// The sum of three channels.
static inline double rgb_sum(const double v[3]) { return v[0] + v[1] + v[2]; }

// The one rule by which three channels become one number. Power, W/m^2, is the sum of the channels. A luminous quantity weights
// each channel by its share in luminance (ITU-R BT.709), at 683 lm/W (the definition of the candela).
#define LIGHT_LUMINOUS 0.2126, 0.7152, 0.0722
#define LIGHT_LUMENS_PER_WATT 683.0
static inline double light_luminous(const double w[3]) {
    const double share[3] = {LIGHT_LUMINOUS};
    return share[0] * w[0] + share[1] * w[1] + share[2] * w[2];
}

// The colour and optics of polygons.
typedef struct Material {
    const char *name;
    Rgb reflectance;  // linear, 0 .. 0.99 (MAPS_MAX_REFLECTANCE); of a texture its mean
    Rgb emission;     // radiant exitance, W/m^2
    Rgb full;  // of a lamp that can be switched (lamps.h): its emission when it is fully lit; 0: of no such lamp
    // 1 opaque, whatever its texture; below 1 seen through, never an occluder; of a texture with holes the mean. At a point it is in
    // proportion to the opacity of the texture there and its mean.
    float alpha;
    float mirror;  // share of light that is reflected as by a mirror, 0 .. 1, where rays are traced
    // The index of refraction, where rays are traced: 1.33 water, 1.5 glass; 0: the material does not refract.
    float index;
    float gloss;  // of an opaque material: it reflects this share, 0 .. 1, of what lacquer of index 1.5 does
    // Its texture and, for polygons that have no map of their own, how the picture lies. 0: none.
    int texture, texture_map;
    // How it emits, in Building.spreads; 0: by Lambert's cosine. What has a spread reflects nothing.
    int spread;
} Material;

// A texture: a picture. Smaller levels follow its texels, each of half the sides (rounded down, at least 1) of the
// one before, down to one texel; texture_level in texture.h finds them.
typedef struct Texture {
    const char *name;  // for messages
    int width, height;
    uint8_t *texels;  // [.. * 4] rows from the top: red, green, blue as sRGB, and opacity
    Rgb mean;         // reflectance, weighted by opacity
    float opacity;    // 0 .. 1, the mean
} Texture;

// How a picture lies in a building: it shows its place (u, v) = (dot(u, p) + u0, dot(v, p) + v0) at point p, for leaves
// of doors at p when the leaf is closed. (0, 0) is the picture's top left corner, (1, 1) its bottom right one, and the picture repeats.
typedef struct TextureMap {
    Vec3 u, v;  // 1 / metres
    double u0, v0;
} TextureMap;

// Makes the material a mirror that reflects this share, 0 .. 1, of what it does not scatter.
static inline void material_make_mirror(Material *m, float share) {
    m->mirror = share;
    m->gloss = 0;
    m->reflectance.r *= 1 - share;
    m->reflectance.g *= 1 - share;
    m->reflectance.b *= 1 - share;
}

// A level of a building.
typedef struct Storey {
    const char *name;
    double floor;   // metres
    double height;  // floor to ceiling, metres
    double slab;    // thickness of the slab under the floor, metres
} Storey;

typedef enum RegionKind {
    REGION_ROOM,      // indoors
    REGION_OUTDOORS,  // under the sky
    REGION_OPENING,   // inside a wall: a doorway, or one half of it, or a window
    REGION_SHAFT,     // inside a slab: a stairwell
    REGION_KINDS
} RegionKind;

// A prism of free space. The first ring is the outer one, counter-clockwise from above; the others are holes,
// clockwise. Free space thus lies to the left of every edge.
typedef struct Region {
    RegionKind kind;
    const char *name;  // of the room as drawn, or ""
    int storey;        // -1 outdoors
    int opening;       // for REGION_OPENING, else -1
    int side;          // for REGION_OPENING: which half, 0 or 1 (0 for windows)
    int first_ring, ring_count;
    double z0, z1;
    int floor_material, ceiling_material;  // -1: nothing is drawn (the sky)
} Region;

// A closed outline in plan.
typedef struct Ring {
    int first_point, point_count;
} Ring;

// From this height on the wall behind a ring's edge is another storey's, with a look of its own.
typedef struct EdgeBand {
    int edge;  // as in Building.edge_material
    double from;
    int material;
} EdgeBand;

typedef enum OpeningKind {
    OPENING_DOOR,     // has a leaf: blocks sight and passage while closed, unless glazed
    OPENING_PASSAGE,  // no leaf
    OPENING_WINDOW,   // seen through, not walked through
    OPENING_KINDS
} OpeningKind;

// A hole in a wall between `sill` and `head`. The vertical plane through line[0] and line[1] splits a door's region
// into two halves. A closed door, unless glazed, fills the contact of the halves, so that nothing is seen past its
// leaves. A door that `fills` has no halves but one or several regions, and leaves as thick as these regions; when
// closed it fills all contacts of its regions with other regions.
typedef struct Opening {
    OpeningKind kind;
    const char *name;
    int storey;                  // -1 in a soup
    bool glazed;                 // a door of glass: never blocks sight
    bool fills;                  // its leaves fill its regions
    Vec2 line[2];                // its plan ends; side 0 lies to the left of line[0] -> line[1]
    double sill, head;           // absolute heights, metres
    int first_leaf, leaf_count;  // in Building.leaves; of doors only
    double open;                 // how far it is open as drawn, 0 closed .. 1 wide open
    // The regions beyond its two sides (rooms or outdoors); -1 where a side leads nowhere, and in a soup.
    int region[2];
    const char *reason;  // NULL, or why a side leads nowhere
    int material;        // of the leaf
} Opening;

// The moving part of a door. At share t of its way, 0 closed .. 1 wide open, the leaf is turned by t * turn about the
// upright axis through `pivot`, then shifted by t * slide and raised by t * rise. `axis` and `thickness` are its plan box
// when closed: `axis` runs through the middle of the box from the hinged end to the free end. The corners of a leaf that is
// not a box in plan are given as a convex polygon within the box.
typedef struct Leaf {
    int opening;
    Vec2 pivot;
    double turn;  // radians, counter-clockwise from above; 0 where it slides
    Vec2 slide;   // metres; 0, 0 where it turns
    double rise;  // metres, below 0 where it sinks
    Vec2 axis[2];
    double thickness, z0, z1;        // metres
    int first_corner, corner_count;  // in Building.points, counter-clockwise, up to LEAF_CORNERS; 0: the box
} Leaf;

// A convex planar polygon (within MAPS_PLANARITY), counter-clockwise seen from its front; visible from both sides.
typedef struct Polygon {
    int first_vertex, vertex_count;
    int material;
    int texture_map;  // 0: that of the material
} Polygon;

typedef enum ObjectKind {
    OBJECT_FURNITURE,
    OBJECT_STAIR,
    OBJECT_LOW_WALL,  // a wall that does not reach the ceiling
    OBJECT_FRAME,     // of a door or window
    OBJECT_LEAF,      // of a door
    OBJECT_LAMP,
    OBJECT_SURFACE,  // walls, floors and ceilings, made by the cell stage
    OBJECT_KINDS
} ObjectKind;

// Polygons that belong together and are drawn together.
// The coarse stand-in of an object for tours, shade and plans: an upright box.
typedef struct ObjectProxy {
    Vec2 corner[4];  // counter-clockwise
    double z0, z1;   // z0 < z1
} ObjectProxy;

// A building has millions of surfaces that are objects without a proxy.
typedef struct Object {
    ObjectKind kind;
    bool plug;  // fills the contact of a door's halves: present only while the door is closed
    const char *name;
    int first_polygon, polygon_count;
    int opening;               // the door or window it is part of, or -1
    int leaf;                  // in Building.leaves, with which it moves; drawn here as when closed; or -1
    const ObjectProxy *proxy;  // NULL: none
} Object;

// A flat piece let into a floor or a ceiling (a lamp panel, a carpet): where it lies, the floor or ceiling is
// left out. Convex, counter-clockwise from above, points in Building.points.
typedef struct Inlay {
    int first_point, point_count;
    double z;
    int material;
} Inlay;

// A light as drawn: a luminous ball, to which lamp_faces.h gives faces.
typedef struct Light {
    const char *name;
    Vec3 position;
    double radius;  // metres
    Rgb flux;       // W
    int object;     // the lamp in which the light sits, or -1
    // The photometric file that the light's own statement names; NULL: none.
    const char *file;
    // The table by which its light leaves, in Building.photometries; 0: none.
    int photometry;
    double turn;  // of the table's plane C0 from +x, radians counter-clockwise from above
} Light;

// Where and when a building stands, as far as its file says so.
typedef struct Site {
    bool placed;                 // latitude and longitude are known
    double latitude, longitude;  // radians north and east
    double north;                // direction of north in the plan, radians clockwise from +y
    int date[3];                 // year, month, day; year 0: neither date nor hour are known
    double hour;                 // of the place's clock, 0 .. 24
    bool zoned;                  // `ahead` is known; else the clock counts as the sun's mean time
    double ahead;                // hours that the clock is ahead of UTC
} Site;

// A stored view.
typedef struct Viewpoint {
    const char *name;
    Vec3 eye;
    double yaw, pitch;  // radians; yaw 0 looks along +x, counter-clockwise; pitch > 0 looks up
    double fov;         // horizontal, radians
} Viewpoint;

// A stored camera path: a run of viewpoints.
typedef struct Tour {
    const char *name;
    int first_viewpoint, viewpoint_count;  // in Building.tour_points
} Tour;

// Kinds of notes.
enum { NOTE_LEAK, NOTE_DROPPED, NOTE_CHANGED, NOTE_KINDS };

// A remark on reading: a room that is not enclosed (with the way to the hole), or things left out or changed.
typedef struct Note {
    int kind;
    const char *text;  // one sentence with its place
    Vec3 place;
    int first_point, point_count;  // a leak's path from the room to the hole and out, in Building.points
} Note;

// A convex planar polygon in Building.vertices through which two given cells touch; counter-clockwise seen from cell[0].
typedef struct GivenPortal {
    int cell[2];
    int first_vertex, vertex_count;
} GivenPortal;

// A whole building. Arrays may be NULL where their counts are 0.
// Once made, a building is only read, by any number of threads. Its arrays live in the arena of the call that read the file, or
// belong to the code that made the building.
typedef struct Building {
    enum {
        FORM_REGIONS,  // prisms of free space, furniture in them
        FORM_SOUP,     // polygons in objects, and doors recognised by name; no regions, no storeys
        FORM_CELLS,    // given_cell_count convex cells and given_portals; nothing else
        BUILDING_FORMS
    } form;
    const char *source;  // the path it was read from
    const char *map;  // of a file that holds several: the map read, else NULL; before reading, the map wanted
    uint64_t hash;    // of the file's content, and of `map`
    double file_size;     // bytes; 0: not read from a file. The polygons allowed to a building grow with it
    const char **beside;  // [beside_count] paths of the files to which the one read refers, where they exist
    Material *materials;
    Texture *textures;         // entry 0 is no texture
    TextureMap *texture_maps;  // entry 0 is no map
    Photometry *photometries;  // entry 0 is no table
    LampSpread *spreads;       // entry 0 is Lambert's cosine
    Storey *storeys;
    Region *regions;
    Ring *rings;
    Vec2 *points;        // of rings, inlays and leak paths
    int *edge_material;  // [point_count] of the wall right of the ring's edge that begins at points[i]
    int *edge_upper;     // [point_count] of that wall above an opening in it; NULL: edge_material
    EdgeBand *bands;     // [band_count] by edge, then from below
    Opening *openings;
    Leaf *leaves;
    Polygon *polygons;
    Vec3 *vertices;
    Object *objects;
    Inlay *inlays;
    Light *lights;
    Site site;
    // The picture of the sky, once around and from the zenith (v = 0) to the horizon (v = 1); 0: none. As seen by who turns to the
    // right, u grows from 0 at `sky_start`, radians counter-clockwise from +x in the plan.
    int sky_texture;
    double sky_start;
    Viewpoint *viewpoints, *tour_points;
    Tour *tours;
    Note *notes;
    GivenPortal *given_portals;
    CurvedShape *shapes;
    CurvedControl *controls;
    CurvedTrim *trims;
    CurvedBall *balls;
    int given_cell_count, given_portal_count;
    int material_count, texture_count, texture_map_count, storey_count, region_count, ring_count, point_count,
        opening_count, leaf_count, polygon_count, vertex_count, object_count, inlay_count, light_count,
        viewpoint_count, tour_point_count, tour_count, note_count, shape_count, control_count, trim_count,
        ball_count, beside_count, band_count, photometry_count, spread_count;
    // Objects that are lamps added for rooms without light, the last ones; 0 in every file.
    int fill_lamps;
    int material_capacity, texture_capacity, texture_map_capacity, storey_capacity, region_capacity,
        ring_capacity, point_capacity, edge_capacity, edge_upper_capacity, band_capacity, opening_capacity,
        leaf_capacity, polygon_capacity, vertex_capacity, object_capacity, inlay_capacity, light_capacity,
        viewpoint_capacity, tour_point_capacity, tour_capacity, note_capacity, shape_capacity,
        control_capacity, trim_capacity, ball_capacity, beside_capacity, photometry_capacity, spread_capacity;
    Box world;   // of all free space; beyond it there is nothing
    Vec3 start;  // where a walk begins: an eye in a room
    double start_yaw;
    double drawn_area, lost_area;  // m^2 of rooms as drawn, and of those that could not be used
} Building;

// Reflectances that a file states are refused or capped above this: light is reflected a hundred times, and the sum stays finite.
#define MAPS_MAX_REFLECTANCE 0.99f
// Colours as on a screen are capped at this: that of white paint. A file that says white seldom means a better reflector.
#define MAPS_MAX_COLOUR 0.85f
// The most corners a leaf has in plan.
enum { LEAF_CORNERS = 32 };
// The grid of the plan and of heights, metres: finer than any wall, coarser than the noise in real files.
#define MAPS_GRID 0.001
// How far the outline of a convex region may turn inwards, metres: far above the rounding of vertices that lie on a
// straight edge (1e-13), far below the size of anything that shows.
#define MAPS_DENT 1e-9
// How far a polygon's vertices may lie off its plane, metres.
#define MAPS_PLANARITY 0.001
// Places in pictures beyond this are refused: a picture would repeat more often than there are texels on a screen.
#define TEXTURE_FARTHEST 1e6
// Polygons of less area are dropped and are faults, m^2: a square of a tenth of a millimetre is visible nowhere.
#define MAPS_SMALLEST_AREA 1e-8
// Is a portal of given cells too thin to have a plane: has it less area than a square of a millionth of its length? Portal files come in
// any unit, so no area of metres would do.
bool maps_portal_is_thin(const Vec3 *corners, int count);
// Coordinates beyond this are refused, metres: up to here the grid is exact in doubles, and georeferenced plans fit.
#define MAPS_LIMIT 1e8
// The most cells of free space: what is kept for each, a kilobyte and more, is some gigabytes then.
#define MAPS_MAX_CELLS (1 << 22)
// Where cells are given by a file, whose lists and rows name all of them: as many as levels of games can have. Of so many, a table with
// a bit for each pair is half a gigabyte.
#define MAPS_MAX_GIVEN_CELLS (1 << 16)
// How far the outdoors reaches beyond everything built, metres.
#define MAPS_OUTDOORS 20.0

// Rounds a coordinate to the grid, metres.
static inline double maps_snap(double x) { return nearbyint(x * 1000.0) / 1000.0; }

// The first band of a ring's edge in Building.bands, or where it would stand.
int building_first_band(const Building *b, int edge);

// Readers append with these; all copy their arguments into the arena.
int building_add_material(Arena *arena, Building *b, Material material);  // or returns an equal one
// Begins an object, empty yet, to which polygons are then added. Returns its index.
int building_add_object(Arena *arena, Building *b, ObjectKind kind, const char *name);
// Appends a polygon to the last object. Concave or bent polygons are cut into triangles; degenerate ones dropped.
// Returns how many polygons it became.
int building_add_polygon(Arena *arena, Building *b, const Vec3 *vertices, int count, int material);
// The same of a polygon with a place (u, v) in the material's picture for each corner. A polygon that no single map fits, to half a
// texel, is cut into triangles. `places` may be NULL.
int building_add_textured(Arena *arena, Building *b, const Vec3 *vertices, const Vec2 *places, int count,
                          int material);
int building_add_texture_map(Arena *arena, Building *b, TextureMap map);  // or returns the last one, if equal
// The map that fits `count` corners and their places best, by least squares in the plane with normal `n`; false where it is off by
// more than most[0] in u or most[1] in v at a corner.
bool building_fit_map(const Vec3 *vertices, const Vec2 *places, int count, Vec3 n, const double most[2],
                      TextureMap *out);
// Half a texel of a picture, in u and in v: how far a map may be off.
void building_half_texel(const Texture *texture, double half[2]);

// The number of polygons that a file of `file_size` bytes may make by placing models, tessellating curved shapes and instancing
// meshes, since a short line can ask for thousands. A small file may make 300,000, a file of 16 MB BUILDING_MOST_POLYGONS; where
// the user grants memory (--memory), as many as fit into it, up to the same maximum.
enum { BUILDING_MOST_POLYGONS = 4000000 };
int building_polygons_allowed(double file_size);
// Sets the proxy of the last object to the box of its vertices, in the frame turned by `angle` about z. A level object has none.
void building_set_proxy(Arena *arena, Building *b, double angle);
// Gives back the room for more polygons and objects, where there are many.
void building_fit(Arena *arena, Building *b);
// Adds a note; the sentence is formatted as by printf.
void building_note(Arena *arena, Building *b, int kind, Vec3 place, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

// One kind of fault or omission, counted over a whole file and noted once, with the names of the first few.
typedef struct NoteTally {
    int count, shown;
    char names[320];  // the first few, each once
    Vec3 place;       // of the first
} NoteTally;

// Counts one; `name` is kept where it is among the first few.
void building_tally(NoteTally *tally, const char *name, Vec3 place);
// Adds the note `WHERE: COUNT WHAT: NAMES`, a NOTE_CHANGED, unless the count is 0.
void building_note_tally(Arena *arena, Building *b, const char *where, const NoteTally *tally,
                         const char *what);

// sRGB channel 0..255 to linear reflectance, capped.
float maps_linear(int srgb);
Rgb maps_colour(unsigned rgb);  // 0xRRGGBB

// Names every fault with its place: up to `max` sentences in `faults`; returns how many faults there are.
int building_check(const Building *b, Arena *arena, const char **faults, int max);

// Whether the region has only one ring, convex to within MAPS_DENT: it then becomes a cell without being cut.
bool region_is_convex(const Building *b, const Region *region);

// How sentences call a region: by its name, as `outdoors`, or as `a room at (3.2, 1.5)`, a place inside it, metres. The text lies in the
// arena or in the building.
const char *region_title(const Building *b, const Region *region, Arena *arena);

// The position of a point of a leaf at share `open` of the leaf's way; `closed` is its position when the leaf is closed.
Vec3 leaf_point(const Leaf *leaf, double open, Vec3 closed);
// The other way: where a point of a leaf at share `open` is when the leaf is closed.
Vec3 leaf_point_closed(const Leaf *leaf, double open, Vec3 point);
// The leaf's plan box at share `open`, counter-clockwise; corner 0 is at the hinged end, on the right of the axis.
void leaf_box(const Leaf *leaf, double open, Vec2 corner[4]);
// The leaf's plan polygon at share `open`, counter-clockwise: its own corners, or those of its box. Returns their number.
int leaf_plan(const Building *b, const Leaf *leaf, double open, Vec2 corner[LEAF_CORNERS]);

// "door", "passage", "window".
const char *opening_kind_name(OpeningKind kind);

#endif
