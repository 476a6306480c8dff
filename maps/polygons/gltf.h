// gltf.h - the parts that the files of the glTF reader share: the document, its parts with their JSON paths, accessors and pictures.
//
// Failures are sticky: the first failure is kept with its place, and values asked for afterwards come back empty. A reader can
// therefore read many values and test `failed` once.
#ifndef MAPS_GLTF_H
#define MAPS_GLTF_H

#include <jansson.h>

#include "maps/polygons/soup_readers.h"

// Limits of one document: above any building seen, below a size at which reading would hang. The limits on polygons and vertices
// are those of every soup.
#define GLTF_MAX_JSON ((size_t)128 << 20)  // bytes; parsed it takes up to twenty times as many
#define GLTF_MAX_LIST 1000000              // nodes, accessors, children ...
// The most numbers decoded from all accessors together: GLTF_FREE_VALUES and GLTF_VALUES_A_BYTE for each byte of the files, but
// at most GLTF_MAX_VALUES.
#define GLTF_MAX_VALUES (96 << 20)
#define GLTF_FREE_VALUES (24 << 20)
#define GLTF_VALUES_A_BYTE 16
#define GLTF_MAX_NUMBER 1e15  // of a matrix, a translation, a factor

// The luminous efficacy of green light: exporters turn watts into candela by this factor.
#define GLTF_LUMENS_PER_WATT 683.0

typedef struct Gltf {
    const char *path;
    json_t *root;
    Bytes chunk;  // the BIN chunk of a .glb; no data in a .gltf
    SoupReader reader;
    Arena *arena;    // of the building
    Arena *scratch;  // until the document is read
    Building *b;
    Error *error;
    bool failed;
    Bytes *buffers;                  // [buffers] without data: not yet read
    struct GltfMesh *meshes;         // [meshes] private to gltf.c
    struct GltfMaterial *materials;  // [materials + 1] private to gltf.c; the last is the default
    struct GltfImage *images;        // [images] private to gltf_textures.c
    struct {
        int lines, flat, suns, pictures, skins;  // primitives; polygons; lights; textures; meshes
        int placeless, repeated;                 // primitives
    } tally;                                     // counts of things left out or changed
    int values, faces;                           // numbers decoded; faces placed
    double pixels;                               // of images that may still be decoded
    size_t size;                                 // bytes of the document, without the files beside it
} Gltf;

// ---- gltf_document.c: a part of the document

enum { GLTF_PLACE = 96 };
typedef struct GltfItem {
    const json_t *json;      // an object, or NULL where there is none
    char place[GLTF_PLACE];  // `nodes[3]`, `meshes[0].primitives[1]`
} GltfItem;

// Keeps the first failure as `FILE: PLACE.KEY: sentence` (key may be NULL); returns false.
bool gltf_fail(Gltf *g, const GltfItem *item, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
GltfItem gltf_root(const Gltf *g);
// How many elements the array has; 0 where it is absent.
int gltf_count(Gltf *g, const GltfItem *item, const char *key);
// The object that is element i of an array, or member `key`; absent members have no json.
GltfItem gltf_element(Gltf *g, const GltfItem *item, const char *key, int i);
GltfItem gltf_member(Gltf *g, const GltfItem *item, const char *key);
GltfItem gltf_extension(Gltf *g, const GltfItem *item, const char *name);
// Element i of one of the document's own lists.
GltfItem gltf_item(Gltf *g, const char *list, int i);
int gltf_list_count(Gltf *g, const char *list);
// Read a value within low .. high; `absent` is returned where there is no value.
int gltf_int(Gltf *g, const GltfItem *item, const char *key, int low, int high, int absent);
double gltf_number(Gltf *g, const GltfItem *item, const char *key, double low, double high, double absent);
bool gltf_flag(Gltf *g, const GltfItem *item, const char *key);
const char *gltf_text(Gltf *g, const GltfItem *item, const char *key, const char *absent);
// An index into one of the document's lists, or -1.
int gltf_index(Gltf *g, const GltfItem *item, const char *key, const char *list);
// Element i of an array of indices into one of the document's lists, or -1.
int gltf_index_at(Gltf *g, const GltfItem *item, const char *key, int i, const char *list);
// An array of exactly `count` numbers within low .. high; false where it is absent.
bool gltf_numbers(Gltf *g, const GltfItem *item, const char *key, int count, double low, double high,
                  double *out);

// ---- bytes

// Reads the bytes of a URI: base64 data within it, or a file beside the document. A missing file is a failure only if `needed`.
bool gltf_read_uri(Gltf *g, const GltfItem *item, const char *uri, bool needed, Bytes *out);
bool gltf_read_view(Gltf *g, int view, Bytes *out, int *stride);

// ---- numbers

// Decodes an accessor with `components` numbers in each of at most `most` elements. `integer`: the numbers are indices, so they
// must be u8, u16 or u32. Returns the number of elements, with their numbers in `out` (in `arena`); 0 on failure.
int gltf_decode(Gltf *g, int accessor, int components, bool integer, int most, Arena *arena, double **out);

// ---- gltf_textures.c: pictures

// The highest number of a set of places in pictures, TEXCOORD_n.
enum { GLTF_MAX_SETS = 63 };

// Kept with its opacity, kept as an opaque one, or read for its mean alone.
typedef enum GltfUse { GLTF_OPACITY, GLTF_OPAQUE, GLTF_MEAN } GltfUse;

// A texture as a material names it.
typedef struct GltfPicture {
    int texture;  // in Building.textures
    Rgb mean;     // reflectance
    int set;      // of places: TEXCOORD_n
    double way
        [6];  // (u, v) in the picture: way[0] u + way[1] v + way[2], way[3] u + way[4] v + way[5] of the file's
    bool ends[2];  // its sampler does not repeat it, across and down
} GltfPicture;

// Makes room for the document's images.
bool gltf_list_images(Gltf *g);
// The texture that `key` of `item` names; false where there is none. One whose image is missing, cannot be decoded or is of a kind that
// is not read is tallied.
bool gltf_read_picture(Gltf *g, const GltfItem *item, const char *key, GltfUse use, GltfPicture *out);
// The places in the picture of a primitive's vertices: [vertices], in `arena`; NULL where the primitive has none, which is tallied.
Vec2 *gltf_decode_places(Gltf *g, const GltfItem *attributes, const GltfPicture *picture, int vertices,
                         Arena *arena);

#endif
