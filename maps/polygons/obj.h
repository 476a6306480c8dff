// obj.h - Wavefront OBJ models with their MTL materials, as furniture and whole buildings come.
#ifndef MAPS_OBJ_H
#define MAPS_OBJ_H

#include "engine/core/file.h"
#include "maps/building/building.h"
#include "maps/polygons/obj_materials.h"

// Limits of one model: well above the largest furniture seen (some 100,000 faces), well below a size at which reading would hang.
#define OBJ_MAX_VERTICES (4 << 20)
#define OBJ_MAX_CORNERS (16 << 20)
#define OBJ_MAX_NAMES 4096  // groups; materials

typedef struct ObjMaterial {
    const char *name;
    Rgb colour;    // linear reflectance
    Rgb emission;  // radiant exitance, W/m^2
    float alpha;   // 1 opaque; without the holes of its picture
    int texture;   // in Building.textures, 0: none
    // The picture shows at texture coordinates (s, t), t upwards, its place (s, t) * scale + offset (`-s`, `-o`).
    Vec2 scale, offset;
    float shininess;  // 0 matt .. 1: a share of the largest exponent
    // Share of the light that it reflects as a mirror: its mean Ks, where its illumination model reflects rays (3, 5) and its highlights
    // are as sharp as a mirror's (OBJ_MIRROR_SHININESS); else 0.
    float mirror;
    bool known;  // by a material library, or by name (obj_materials.h); else it has the colour of `default`
} ObjMaterial;

// From this exponent on (1000 is the largest) a highlight is 5 degrees wide or less.
#define OBJ_MIRROR_SHININESS 500

// The text of the note about unknown materials; the count comes before it, their names after it.
#define OBJ_UNKNOWN_NOTE                                                                                     \
    "materials have a name that neither a library nor Sweet Home 3D knows, and the colour of its default "   \
    "material"

typedef struct ObjFace {
    int first_corner, corner_count;
    int group, material;
    int line;  // where it stands in the file
} ObjFace;

typedef struct ObjModel {
    Vec3 *vertices;      // model units; in furniture x right, y up, z to the front
    int *corners;        // of faces: indices of vertices
    Vec2 *places;        // texture coordinates (s, t) as in the file
    int *corner_places;  // [corner_count] indices of places, -1: none
    ObjFace *faces;
    const char **groups;     // names; group 0 is "" for faces before the first g or o
    ObjMaterial *materials;  // material 0 is "" for faces before the first usemtl
    int vertex_count, corner_count, place_count, face_count, group_count, material_count;
    int vertex_capacity, corner_capacity, place_capacity, corner_place_capacity, face_capacity,
        group_capacity, material_capacity;
    int skipped;         // lines that could not be used
    const char *fault;   // the first unusable vertex or face, as `LINE: sentence`; NULL: none
    const char *absent;  // the first library or image that could not be read; NULL: none
    int nameless;        // lines with a name beyond OBJ_MAX_NAMES
    Box box;             // of the vertices that faces use
    bool fixed_box;      // the box is given, and the faces need not fill it
} ObjModel;

// Reads the material libraries and images that a model refers to. `name` is as the file spells it; `read` may be NULL.
typedef struct ObjFiles {
    bool (*read)(void *context, const char *name, Arena *arena, Bytes *out);
    void *context;
    double *pixels;  // of images that may still be decoded, see texture_add; NULL: any
    Building *b;     // to which images are added; NULL: a material has the colour that the library states
} ObjFiles;

// Lines that make no sense are skipped and counted. Fails on a model without a usable face and on a model beyond the
// limits.
bool obj_read(Bytes content, const char *path, const ObjFiles *files, Arena *arena, ObjModel *out,
              Error *error);

// The texture coordinates of a face's corners, as in the file; false where a corner has none.
bool obj_places(const ObjModel *model, const ObjFace *face, Vec2 *out);

// The box from (0, 0, 0) to (1, 1, 1) as six quads: it stands in for a missing model.
ObjModel obj_box(Arena *arena);

#endif
