// soup_readers.h - the parts that readers of polygon soups share: files beside the one read, colours within their limit, the end of
// reading, and triangles merged back into polygons.
#ifndef MAPS_SOUP_READERS_H
#define MAPS_SOUP_READERS_H

#include "engine/core/file.h"
#include "maps/building/building.h"

// Limits of one soup: a furnished office building has some 100,000 polygons; four million still fit into memory.
#define SOUP_MAX_POLYGONS (4 << 20)
#define SOUP_MAX_VERTICES (4 << 20)
// Materials are compared one by one.
#define SOUP_MAX_MATERIALS 10000
// Corners of one face: cutting a concave one into triangles takes up to cubic time.
#define SOUP_MAX_CORNERS 256
// Bytes of all files beside the one read, and how many they are.
#define SOUP_MAX_BYTES ((size_t)1 << 30)
#define SOUP_MAX_FILES 1000

// ---- soup_readers.c

// A soup while it is read, and the files beside the one at `path`. Start with {.path = path, .arena = arena, .b = b}.
typedef struct SoupReader {
    const char *path;
    Arena *arena;  // of the building
    Building *b;
    uint64_t hash;  // of the files beside that were read
    size_t bytes;   // of these files
    int files;
    int capped;                // colours above MAPS_MAX_REFLECTANCE
    const char *first_capped;  // the material of the first of them
    double most_capped;
} SoupReader;

// Reads the file `name`. It may lie in the folder of `path` or below it, not outside: names that are empty, absolute or
// hold `..` are refused, and so are files beyond the limits above. Backslashes count as slashes, as exporters write them.
bool soup_read_beside(SoupReader *reader, const char *name, Arena *arena, Bytes *out, Error *error);

// A linear reflectance of 0 or more, capped; colours that had to be are counted.
Rgb soup_cap(SoupReader *reader, Rgb reflectance, const char *material);
// The end of every reader of a soup: notes colours that were capped and a size that no building has (`resize` says how the file
// can state another), and sets the world's box and the start: at the first viewpoint, else at eye height in the
// middle. Fails on a soup without a polygon.
bool soup_finish(const SoupReader *reader, const char *resize, Error *error);

// ---- soup_merge.c

typedef struct SoupFace {
    int first_corner, corner_count;  // counter-clockwise from its front
    int material;
} SoupFace;

typedef struct SoupMesh {
    Vec3 *vertices;
    int *corners;  // of faces: indices of vertices
    SoupFace *faces;
    int vertex_count, corner_count, face_count;
} SoupMesh;

// Joins faces of one material that share an edge, run along it in opposite directions, lie in one plane and are convex
// together: triangles into which an exporter cut a polygon become that polygon again. No vertex moves and none is left out. `out`
// shares the vertices of `mesh` and lies in `arena`; faces are in the order of the first of each that joined.
void soup_merge(const SoupMesh *mesh, Arena *arena, SoupMesh *out);

// For each vertex the first one at the same place: [count], in `arena`.
int *soup_weld(const Vec3 *vertices, int count, Arena *arena);

#endif
