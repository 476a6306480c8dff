// ifc_file.h - what the parts of the reader share: the file with its units and styles, and the state of one thread.
#ifndef MAPS_IFC_FILE_H
#define MAPS_IFC_FILE_H

#include "maps/ifc/ifc.h"
#include "maps/ifc/shape.h"
#include "maps/ifc/step.h"
#include "maps/ifc/types.h"

// A profile, swept along its normal, or the ring of an upright prism: kept so that footprints can be told.
typedef struct Prism {
    Vec3 *corners;  // of all rings, at the base
    int *size;      // [ring_count]
    int ring_count;
    Vec3 sweep;    // from base to top
    bool clipped;  // something was cut off
} Prism;

// One item of a representation.
typedef struct Item {
    Shape shape;
    Prism prism;  // ring_count 0: it is none
} Item;

// The items of a representation.
typedef struct Body {
    Item *items;
    int count, room;
} Body;

// A list of pairs of records, sorted by the first one.
typedef struct Pair {
    int key, value;
} Pair;
typedef struct Pairs {
    Pair *pair;
    int count, room;
} Pairs;

// All that is known of the whole file before meshes are made; then only read, by all threads.
typedef struct IfcFile {
    StepFile step;
    IfcOptions options;
    double length, angle;  // metres and radians of the file's units
    Pairs styles;          // item -> material in `materials`
    Pairs looks;           // IfcMaterial -> material
    Pairs colour_maps;     // face set -> IfcIndexedColourMap
    Pairs places;          // face or face set -> its places in a picture (IfcTextureCoordinate)
    Pairs maps;            // representation map -> its index in map_bodies
    Body *map_bodies;
    IfcMaterial *materials;
    int material_count, material_room;
    IfcTexture *textures;  // entry 0 is none
    int texture_count, texture_room;
    long long most_polygons;
    long long *polygons;  // made by all threads; beyond `most_polygons` the file is refused
} IfcFile;

// A note before its product is known.
typedef struct RawNote {
    int entity, product;
    const char *text;
} RawNote;

enum { IFC_PLACED = 64 };  // placements that a thread remembers
// Where a placement stands in the world: many products stand in the same storey, doors in walls.
typedef struct Placed {
    int record, depth;  // 0: nothing is remembered here
    Frame frame;
} Placed;

// One thread's state.
typedef struct Reader {
    const IfcFile *file;
    Arena scratch;        // until the product is done
    Arena kept;           // until the end
    StepStrings strings;  // in `kept`
    size_t bad;           // the first byte that is no argument
    RawNote *notes;
    int note_count, note_room;
    int product;       // that is read, an index; -1: none
    int depth;         // of items within items
    long long visits;  // of items, profiles and curves since the product or the map began
    long long work;    // of booleans since then
    Placed placed[IFC_PLACED];
} Reader;

enum {
    IFC_VISITS = 16,            // visits of items, profiles and curves that count as a polygon
    IFC_POINTS = 64,            // points of lists that count as a polygon
    IFC_WORK = 2000,            // corners looked at by booleans that count as one
    IFC_DEEPEST = 40,           // items within items, placements in placements
    IFC_LONGEST_CHAIN = 10000,  // booleans whose first operand is a boolean
    IFC_MOST_CHORDS = 256,      // of an arc or circle
    IFC_MOST_FACES = 64000000,  // made on the way, those of openings and operands too
};
// Points of a curve closer than this are one, metres.
#define IFC_SAME_POINT 1e-6
// Chords lie off their circle by this at most, metres: where a circle is so large that the options' chords lie farther off, it has more.
#define IFC_SAGITTA 0.02

// The first `count` arguments of a record; those that the record lacks are STEP_NONE. False: there is no such record.
bool ifc_arguments(Reader *r, int record, StepValue *out, int count);
int ifc_type(const Reader *r, int record);  // T_..., STEP_OTHER, or -1 of record -1
StepCursor ifc_list(Reader *r, const StepValue *list);
// The number of a value, that of a typed value too; `otherwise` where there is none. Lengths are in metres.
double ifc_number(Reader *r, const StepValue *value, double otherwise);
double ifc_length(Reader *r, const StepValue *value, double otherwise);
bool ifc_is(const Reader *r, const StepValue *value, const char *enumerator);
int ifc_pair(const Pairs *pairs, int key);  // index of the first pair with this key, or -1
void ifc_sort(Pairs *pairs);
void ifc_note(Reader *r, int record, const char *format, ...) __attribute__((format(printf, 3, 4)));

// Points in metres, directions of unit length; `otherwise` where the record is none.
Vec3 ifc_point(Reader *r, int record);
Vec3 ifc_direction(Reader *r, int record, Vec3 otherwise);
// IfcAxis2Placement2D and 3D; the identity where the record is none.
Frame ifc_axes(Reader *r, int record);
Frame ifc_axis(Reader *r, int record);       // IfcAxis1Placement: origin and z
Frame ifc_operator(Reader *r, int record);   // IfcCartesianTransformationOperator
Frame ifc_placement(Reader *r, int record);  // IfcObjectPlacement, down to the world
// Points of an IfcCartesianPointList; the arrays lie in scratch.
int ifc_point_list(Reader *r, int record, Vec3 **out);

// A curve as points. A closed one does not repeat its first point.
typedef struct Curve {
    Vec3 *points;
    int count, room;
    bool closed;
    Vec3 first,
        last;  // the directions at its ends, where these are those of an arc; else 0: those of its edges
} Curve;
bool ifc_curve(Reader *r, int record, Curve *out);
// The part of a curve from one parameter to a larger one: angles of conics, lengths of a line's vector, points of polylines. Other curves
// are whole, and so are those whose parameters are not told (NAN), and polylines from 0 to 1.
bool ifc_curve_between(Reader *r, int record, double from, double to, Curve *out);
// The part of an edge's curve from its start to its end.
bool ifc_edge(Reader *r, int record, Vec3 start, Vec3 end, bool same_sense, Curve *out);
// The place of the point of an open curve nearest to p, in points from 0; how far p is from it, unless that is NULL.
double ifc_along(const Curve *curve, Vec3 p, double *far);
// The simple loops of a closed curve that touches itself, in the directions that it has (loops.c); 0 where it does not.
int ifc_loops(Reader *r, const Curve *ring, Curve **out);
// Appends a point, unless it is the last one once more.
void ifc_curve_push(Reader *r, Curve *curve, Vec3 point);
int ifc_chords(const Reader *r, double radius, double angle);  // for an arc of this angle
// A B-spline curve (spline.c).
bool ifc_spline_curve(Reader *r, int record, const double *trim, Curve *out);

// A span of a B-spline surface between two knots, in one direction.
typedef struct SplineSpan {
    double low, high;  // in 0 .. 1
    double parts;      // to be cut into at least
} SplineSpan;
// A B-spline surface, rational or not (spline.c). Both parameters run from 0 to 1; where it is closed they go around.
typedef struct SplineSurface {
    Vec3 *points;         // [count[0] * count[1]] the net, row by row
    double *weights;      // of each point
    double *knots[2];     // [count[d] + degree[d] + 1]
    SplineSpan *span[2];  // [spans[d]]
    Vec3 *seed;           // [seeds[0] * seeds[1]] points from which parameters are looked for
    int degree[2], count[2], spans[2], seeds[2];
    bool closed[2];
    Vec3 pole[4];  // where v is 0, v is 1, u is 0, u is 1: the point that this edge is
    bool is_pole[4];
} SplineSurface;
// `points` is how many will be looked for on the surface, which counts as work.
bool ifc_spline_surface(Reader *r, int record, int points, SplineSurface *out);
Vec3 ifc_spline_point(const SplineSurface *s, Vec2 at);
// The edge that is a pole at point p, an index of `pole`; -1.
int ifc_spline_pole(const SplineSurface *s, Vec3 p);
// The parameters of the surface's point nearest to p.
Vec2 ifc_spline_nearest(const SplineSurface *s, Vec3 p);

// A profile: rings of points in its plane. Area i begins with an outer ring, counter-clockwise; its holes, clockwise, follow.
typedef struct Profile {
    Curve rings;  // points of all rings, z = 0
    int *size;    // [ring_count]
    bool *outer;  // [ring_count]
    int ring_count, size_room, outer_room;
    bool open;  // one open curve: it sweeps a surface
} Profile;
bool ifc_profile(Reader *r, int record, Profile *out);

// Solids. Each appends to `out`, in the frame of the item; false: it cannot be used, which is noted.
bool ifc_extrusion(Reader *r, int record, Shape *out, Prism *prism);
bool ifc_revolution(Reader *r, int record, Shape *out);
bool ifc_swept_disk(Reader *r, int record, Shape *out);
bool ifc_directed_sweep(Reader *r, int record, Shape *out);
bool ifc_primitive(Reader *r, int record, Shape *out);
bool ifc_brep(Reader *r, int record, Shape *out);      // breps, shells and surface models
bool ifc_face_set(Reader *r, int record, Shape *out);  // triangulated and polygonal face sets
// The corners of a face in space, ring by ring, the outer one first, counter-clockwise seen from the side of its surface's normal.
typedef struct FaceRings {
    Vec3 *corners;
    int *size;  // [ring_count]
    int count, room, ring_count, size_room;
} FaceRings;
// A face on a curved surface; false where the surface is none that is read.
bool ifc_curved_face(Reader *r, int surface, const FaceRings *rings, bool same_sense, Shape *out);
void ifc_swept_surface(Reader *r, int record, Shape *out);
// A profile moved along a vector, with caps unless the profile is open.
void ifc_sweep_profile(Reader *r, const Profile *profile, const Frame *frame, Vec3 sweep, Shape *out);
// Appends the items of a representation item: one, or those of a mapped item; `frame` may be NULL.
void ifc_item(Reader *r, int record, const Frame *frame, int material, Body *out);
void ifc_representation(Reader *r, int record, const Frame *frame, int material, Body *out);
// The material of an item by its style, or -1.
int ifc_style_of(const Reader *r, int record);
void ifc_count_polygons(Reader *r, int count);
void ifc_count_points(Reader *r, int count);  // of a list, which many items may read anew
bool ifc_too_many(const Reader *r);
// Enters an item, a profile or a curve that may contain others; false where there are too many within each other, which is noted.
// Every call that returns true wants an ifc_leave.
bool ifc_enter(Reader *r, int record);
void ifc_leave(Reader *r);
// Begins the next product or map: what was visited for the last one counts as polygons do.
void ifc_begin(Reader *r, int product);

// Units and looks (styles.c), before any product is read.
void ifc_read_units(Reader *r, IfcFile *file);
void ifc_read_styles(Reader *r, IfcFile *file, Arena *arena);
// The look of an IfcMaterialSelect; -1 where it has none.
int ifc_material_look(Reader *r, int record, int depth);

// Pictures (textures.c). A texture of a surface style is kept once, by a reader whose memory lasts; 0: it cannot be used.
int ifc_read_texture(Reader *r, IfcFile *file, int record);
// Places of corners in a picture: of a face in order, or of triangle i of a face set by index[3 * i] and the next two.
typedef struct IfcPlaces {
    Vec2 *at;
    int *index;
    int count, index_count;
} IfcPlaces;
bool ifc_places(Reader *r, int record, IfcPlaces *out);
// Lays a picture on the faces of a shape from `first` on, so that each corner has its place.
void ifc_lay_picture(Reader *r, Shape *shape, int first, const Vec3 *corners, const Vec2 *places, int count);

// Products and what relates them (products.c). Lists of records by product or host, sorted.
typedef struct Relations {
    Pairs products;   // record -> index
    Pairs storeys;    // record -> index in the order of the file
    Pairs materials;  // record of a product or a type -> its IfcMaterialSelect
    Pairs types;      // record of a product -> that of its type
    Pairs openings;   // record of a product -> that of an opening
    Pairs fills;      // record of a door -> that of its opening
    Pairs inside;     // record of a product -> that of the storey or space which contains it
    Pairs parts;      // record of a part -> that of its whole
    Pairs maps;       // record of a representation map -> that of an item that maps it
    int *record;      // [product_count]
} Relations;
void ifc_read_relations(Reader *readers, int threads, Arena *arena, Relations *out);
// A product's own arguments, for each product by any thread; then what relates products. The model then is complete but for meshes,
// footprints and notes.
void ifc_read_product(Reader *r, const Relations *relations, int product, IfcProduct *out);
void ifc_relate_products(Reader *r, int threads, Arena *arena, Relations *relations, IfcModel *model);

#endif
