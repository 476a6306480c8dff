// soup_readers.h - the parts that readers of polygon soups share: files beside the one read, colours within their limit, the end of
// reading, and triangles merged back into polygons.
#ifndef MAPS_SOUP_READERS_H
#define MAPS_SOUP_READERS_H

#include "engine/core/file.h"
#include "maps/building/building.h"

// Limits of one soup: a furnished office building has some 100,000 polygons; four million still fit into memory.
#define SOUP_MAX_POLYGONS (4 << 20)
#define SOUP_MAX_VERTICES (4 << 20)
// The most materials, since they are compared one by one.
#define SOUP_MAX_MATERIALS 10000
// The most corners of one face: cutting a concave face into triangles takes up to cubic time.
#define SOUP_MAX_CORNERS 256
// The most bytes of all files beside the one read, and the most files beside it.
#define SOUP_MAX_BYTES ((size_t)1 << 30)
#define SOUP_MAX_FILES 1000

// ---- soup_readers.c

// A soup while it is read, and the files beside the one at `path`. Start with {.path = path, .arena = arena, .b = b}.
typedef struct SoupReader {
    const char *path;
    Arena *arena;  // of the building
    Building *b;
    uint64_t hash;  // of the files read beside `path`
    size_t bytes;   // of these files
    int files;
    // The library of materials of a model that was converted: it stands for every file NAME.mtl. Else no data.
    Bytes library;
    int capped;  // colours above `limit`, the one of soup_cap
    double limit;
    const char *first_capped;  // the material of the first of them
    double most_capped;
} SoupReader;

// Reads the file `name`, which must lie in the folder of `path` or below: names that are empty, absolute or hold `..` are
// refused, and so are files beyond the limits above. Backslashes count as slashes, since some exporters write them.
bool soup_read_beside(SoupReader *reader, const char *name, Arena *arena, Bytes *out, Error *error);

// Returns a linear reflectance, which is 0 or more, capped at the format's limit: MAPS_MAX_REFLECTANCE of stated reflectances,
// MAPS_MAX_COLOUR of colours. Counts the colours above this limit.
Rgb soup_cap(SoupReader *reader, Rgb reflectance, float limit, const char *material);
// Every reader of a soup ends with this call. It notes colours that were capped and a size that no building has (`resize` says how
// the file can state another size), and sets the world's box and the start: the first viewpoint, else a place at eye height in
// the middle. Fails on a soup without a polygon.
bool soup_finish(const SoupReader *reader, const char *resize, Error *error);

// ---- soup_merge.c

typedef struct SoupFace {
    int first_corner, corner_count;  // counter-clockwise seen from its front
    int material;
    int texture;  // in SoupMesh.textures; 0: none
} SoupFace;

typedef struct SoupMesh {
    Vec3 *vertices;
    int *corners;  // of faces: indices of vertices
    SoupFace *faces;
    Vec2 *places;             // [corner_count] in the pictures of faces that have a texture, or NULL
    const Texture *textures;  // of the building; read where there are places
    int vertex_count, corner_count, face_count;
} SoupMesh;

// Joins faces of one material that share an edge, run along it in opposite directions, lie in one plane and are convex
// together: triangles into which an exporter cut a polygon become that polygon again. Faces with a texture are joined where one
// texture map fits all corners of both to half a texel. No vertex moves and none is left out. `out` shares the vertices of `mesh` and
// lies in `arena`; its faces are in the order of the first face joined into each.
void soup_merge(const SoupMesh *mesh, Arena *arena, SoupMesh *out);

// Returns for each vertex the index of the first vertex at the same place: [count], in `arena`.
int *soup_weld(const Vec3 *vertices, int count, Arena *arena);

#endif
