// sh3d.h - the parts of the Sweet Home 3D reader; private to maps/ and to its tests, which look at the plan before
// it is enclosed.
//
// The file's plan is in centimetres with y down. Each value is converted to metres with y up as soon as it is read.
// This mirrors the plan: angles change their sign, and left on the screen stays left. Only the plan is mirrored: a
// model's right, up and front become x, z and -y, which is a rotation, so that lettering stays legible.
#ifndef MAPS_SH3D_H
#define MAPS_SH3D_H

#include "maps/building/sketch.h"
#include "maps/building/zip.h"
#include "maps/polygons/obj.h"
#include "maps/sweethome/sh3d_xml.h"

// The most bytes of Home.xml; real files have below 1 MB.
#define SH3D_MAX_XML ((size_t)64 << 20)
// Bounds on the numbers of a file, in its own centimetres and radians.
#define SH3D_CM 0.01              // metres
#define SH3D_MAX_LENGTH 1e6       // width, depth, height, thickness: 10 km
#define SH3D_MAX_COORDINATE 5e9   // half of MAPS_LIMIT, so that sums stay within it
#define SH3D_MAX_ANGLE 1e6        // cameras really turn many times round
#define SH3D_MAX_LATITUDE 1.5708  // a right angle, rounded up; a longitude has twice as much
// Hours of cameras, milliseconds since 1970: the years 1900 to 2100, for which the sun's place is known.
#define SH3D_FIRST_TIME -2208988800e3
#define SH3D_LAST_TIME 4133980799e3
// Heights that differ by at most this count as equal, metres: files hold heights as single-precision centimetres.
#define SH3D_SAME_HEIGHT 0.01

typedef struct Sh3dLevel {
    const XmlNode *node;  // NULL in a home without levels
    const char *id;
    double floor, height, slab;  // metres
    int index;                   // order among levels of the same elevation
    int storey;
} Sh3dLevel;

typedef struct Sh3d {
    const char *where, *unit;  // for messages: the file, and what XmlNode.line counts
    Archive *archive;          // NULL: a bare Home.xml
    Arena *arena;
    Building *b;
    Sketch *sketch;
    Error *error;
    bool failed;  // the first error is in `error`; values read after it mean nothing
    const XmlNode *home;
    double wall_height;  // for walls that state no height, metres
    Sh3dLevel *levels;
    struct Sh3dWall *walls;        // private to sh3d_walls.c
    struct Sh3dModel *models;      // private to sh3d_models.c
    struct Sh3dPicture *pictures;  // private to sh3d_textures.c
    double pixels;                 // of images that may still be decoded
    int level_count, level_capacity, wall_count, wall_capacity, model_count, model_capacity, picture_count,
        picture_capacity;
    int wall_material, floor_material, ceiling_material;  // for surfaces that name no colour
    NoteTally missing_models, missing_frames, missing_textures, dark_lights, unknown_joins, bad_shapes,
        unknown_materials, plain_pictures, plain_walls;
    bool has_observer;
    Viewpoint observer;
} Sh3d;

// ---- sh3d_attributes.c

// Read an attribute of a node. `missing` is returned for an absent attribute; NAN makes the attribute required. A bad
// value sets s->failed.
double sh3d_number(Sh3d *s, const XmlNode *node, const char *name, double missing, double low, double high);
double sh3d_length(Sh3d *s, const XmlNode *node, const char *name, double missing);      // metres, >= 0
double sh3d_coordinate(Sh3d *s, const XmlNode *node, const char *name, double missing);  // metres, as signed
double sh3d_angle(Sh3d *s, const XmlNode *node, const char *name);  // counter-clockwise; quarter turns exact
bool sh3d_flag(const XmlNode *node, const char *name, bool missing);
const char *sh3d_text(const XmlNode *node, const char *name);  // "" when absent
const char *sh3d_place(Sh3d *s, const XmlNode *node, const char *what);
bool sh3d_fail(Sh3d *s, const XmlNode *node, const char *format, ...) __attribute__((format(printf, 3, 4)));

const Sh3dLevel *sh3d_level(Sh3d *s, const XmlNode *node);  // never NULL
int sh3d_add_point(Sh3d *s, Vec2 point, int material);

// 0 matt .. 1, as the program writes it; numbers beyond are cut.
double sh3d_shininess(Sh3d *s, const XmlNode *node, const char *name, double missing);
int sh3d_add_colour(Sh3d *s, const char *name, Rgb colour);                       // an opaque material
bool sh3d_colour(Sh3d *s, const XmlNode *node, const char *name, unsigned *rgb);  // false: absent
bool sh3d_has_word(const XmlNode *node, const char *const *words);  // in the node's name or catalogue id

// ---- sh3d_textures.c

// How a surface counts lengths along the pictures that lie on it: at point p the program's own texture coordinates, in
// metres, are dot(right, p) + right0 and, upwards, dot(up, p) + up0.
typedef struct Sh3dFrame {
    Vec3 right, up;
    double right0, up0;
    bool left_side;          // of a wall: pictures oriented from left to right count backwards
    bool unsized;            // lengths count in pictures: their own sizes do not matter
    bool can_fit;            // a picture may be stretched over the area below, as rooms allow it
    Vec2 fit_low, fit_high;  // in these coordinates
} Sh3dFrame;

// The map of a picture, as the attributes of its element say, in a surface's frame. Returns false where their numbers make
// no map: then its mean colour counts.
bool sh3d_map(Sh3d *s, const XmlNode *texture, const Sh3dFrame *frame, TextureMap *out);
// The picture of a texture element, an index into Building.textures, decoded once; 0, counted for a note: it is not usable.
int sh3d_picture(Sh3d *s, const XmlNode *texture);
// The texture element of `surface`, a prefix as `leftSide`, "": without a name; NULL: none that is usable.
const XmlNode *sh3d_texture_of(Sh3d *s, const XmlNode *node, const char *surface);
// Returns the material of `surface`: that of its child texture (`leftSideTexture`) as it lies in `frame`, else of its colour
// (`leftSideColor`), else `missing`; shiny as `leftSideShininess` says, else matt. `frame` NULL: a picture counts by its mean.
int sh3d_material(Sh3d *s, const XmlNode *node, const char *surface, int missing, const Sh3dFrame *frame);
// Appends a material without a search for an equal one.
int sh3d_push_material(Sh3d *s, Material material);

// ---- sh3d.c

// Reads a home into a plan (storeys into the building, the rest of the plan into `sketch`) and appends furniture,
// lights, viewpoints and tours to `b`. `archive` may be NULL. Objects of doors and windows refer to openings by their
// index in the sketch, until maps_enclose replaces it by the index in the building.
// `home` is Home.xml or the stream of Java objects that older homes have instead.
bool sh3d_sketch(Bytes home, Archive *archive, const char *where, Arena *arena, Building *b, Sketch *sketch,
                 Error *error);

// ---- sh3d_serialized.c

// Makes the tree of Home.xml from a home as a stream of Java objects, the entry `Home` of files.
bool sh3d_serialized(Bytes stream, const char *where, Arena *arena, const XmlNode **root, Error *error);

// ---- sh3d_walls.c

bool sh3d_read_walls(Sh3d *s);  // call after the levels are read; sets the storeys' heights
void sh3d_find_ceilings(
    Sh3d *s);  // of rooms under walls lower than their storey; call after rooms and walls are read
void sh3d_add_walls(Sh3d *s);            // outlines into the sketch, low walls into the building
void sh3d_add_sloped_ceilings(Sh3d *s);  // call after rooms and walls are read

// ---- sh3d_edges.c

// Remembers how the material of a wall or floor counts lengths along its texture (Sketch.lengths).
void sh3d_keep_lengths(Sh3d *s, int material, const XmlNode *texture);
bool sh3d_has_lengths(const Sketch *sketch, int material);
// To the right from `from` towards `to`, and upwards in absolute heights.
Sh3dFrame sh3d_frame_from(Vec2 from, Vec2 to);
// The material with its picture begun anew, in the frame of an end; without lengths the material itself.
int sh3d_begun_anew(Arena *arena, Building *b, const Sketch *sketch, int material, const Sh3dFrame *frame);
// Jambs, floors of doorways and sides of stairwells; call after maps_enclose.
void sh3d_finish_edges(const Sketch *sketch, Arena *arena, Building *b);

// ---- sh3d_models.c

// The model that a piece, door or window names, read once; NULL: none, or not usable.
const ObjModel *sh3d_model(Sh3d *s, const XmlNode *node);

// ---- sh3d_pieces.c: furniture, stairs, lights and the models of doors

void sh3d_read_pieces(Sh3d *s);

// ---- sh3d_openings.c

// Appends a door or window to the sketch; returns false where the node cannot be used.
bool sh3d_read_opening(Sh3d *s, const XmlNode *node);

// ---- sh3d_zone.c

// How many hours a zone's clock is ahead of UTC when it shows `wall`, seconds since 1970. `zone` is a file of the system's zone data, and
// `name` the name of one. False: not known.
bool sh3d_zone_ahead(Bytes zone, double wall, double *hours);
bool sh3d_zone_find(const char *name, double wall, double *hours);

// ---- sh3d_shape.c

// Writes the largest figure of an SVG path (all commands but S and T) to out[max], with curves as polylines. Returns
// the figure's point count, or 0 where the path makes no sense or has more than `max` points.
int sh3d_shape(const char *path, Vec2 *out, int max);
#define SH3D_MAX_SHAPE 256
double sh3d_shape_area(const Vec2 *points, int count);  // signed, counter-clockwise positive

#endif
