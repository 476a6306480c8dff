// quake.h - compiled levels of the Quake family (.bsp): their trees of planes, the cells and portals of these, and the lump that tells
// a game which leaves see which.
//
// Four formats: Quake's own of version 29, its two extensions with wider numbers (2PSB, BSP2), and Quake II's IBSP of version 38 (id
// Software, 1996 and 1997). All numbers are little-endian. 32 game units become a metre: a power of two rounds no coordinate.
#ifndef MAPS_QUAKE_H
#define MAPS_QUAKE_H

#include <stdint.h>

#include "maps/building/reader.h"

#define QUAKE_METRE 32.0  // game units

typedef enum QuakeFormat { QUAKE_29, QUAKE_2PSB, QUAKE_BSP2, QUAKE_IBSP38, QUAKE_FORMATS } QuakeFormat;
extern const char *const QUAKE_FORMAT_NAMES[QUAKE_FORMATS];

// The lumps that are read here; others are copied as they are. Quake II has no lump of pictures.
typedef enum QuakeLump {
    QUAKE_PLANES,
    QUAKE_VISIBILITY,
    QUAKE_NODES,
    QUAKE_LEAVES,
    QUAKE_MODELS,
    QUAKE_LEAF_FACES,
    QUAKE_FACES,
    QUAKE_TEXTURES,  // which picture a face has, and how it lies
    QUAKE_PICTURES,
    QUAKE_LUMPS
} QuakeLump;
extern const char *const QUAKE_LUMP_NAMES[QUAKE_LUMPS];

// Where a format has its fields: bytes from the beginning of a record; -1: nowhere.
typedef struct QuakeLayout {
    unsigned char magic[4];
    int header;  // bytes before the lumps' places
    int lump_count;
    int lump[QUAKE_LUMPS], record[QUAKE_LUMPS];  // its number in the file, and bytes of a record
    int child;                                   // bytes of a node's child
    int leaf_faces, leaf_face;      // where a leaf has its faces, and bytes of a face's number there
    int sounds;                     // where a leaf has its four sounds
    int face_texture, face_number;  // where a face has its texture, and bytes of that number
} QuakeLayout;
extern const QuakeLayout QUAKE_LAYOUTS[QUAKE_FORMATS];

// Numbers of the file.
static inline int quake_u16(const unsigned char *p) { return p[0] | p[1] << 8; }
static inline int quake_i32(const unsigned char *p) {
    return (int32_t)((uint32_t)quake_u16(p) | (uint32_t)quake_u16(p + 2) << 16);
}
static inline double quake_float(const unsigned char *p) {
    int bits = quake_i32(p);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

// A plane of the tree cuts the node's space in two.
typedef struct QuakeNode {
    int plane;
    int child[2];  // before the plane and behind: a node, or of leaf i the number ~i
} QuakeNode;

// A convex piece of space, all of one content.
typedef struct QuakeLeaf {
    int contents;
    int cluster;  // of Quake II: -1 of solid; of Quake, whose rows are those of leaves, the leaf's place in a row, -1 of leaf 0
    // Where its row begins in the visibility lump, of Quake; -1: it has none, and sees all.
    int row;
    int first_face, face_count;  // in the lump of leaves' faces
} QuakeLeaf;

// A level as its file has it. Every index is in range, and the tree is one: no node is reached twice.
typedef struct QuakeLevel {
    const char *path;
    Bytes content;
    QuakeFormat format;
    Bytes lumps[QUAKE_LUMPS];
    Plane *planes;  // metres
    QuakeNode *nodes;
    QuakeLeaf *leaves;
    int plane_count, node_count, leaf_count;
    int root;  // as QuakeNode.child
    // Rows have a bit for each cluster; of Quake a cluster is a leaf of the level itself.
    int cluster_count;
    Box box;  // of the level's drawn faces, metres
} QuakeLevel;

// Tells a level by its first bytes.
bool quake_recognise(Bytes content);
bool quake_read(const char *path, Bytes content, Arena *arena, QuakeLevel *out, Error *error);
// Records of a lump.
int quake_count(const QuakeLevel *level, QuakeLump lump);
const unsigned char *quake_record(const QuakeLevel *level, QuakeLump lump, int i);

// The leaf that holds a point, metres.
int quake_locate(const QuakeLevel *level, Vec3 point);

// ---- quake_portals.c, quake_cells.c: cells and portals

// The cells of a level as a building of given cells, and which cell each leaf belongs to.
typedef struct QuakeCells {
    Building building;
    int *cell_of_leaf;  // [leaf_count] -1: the leaf is solid or in no cluster
} QuakeCells;

// Which portals a level is taken with.
typedef struct QuakePortals {
    const char *file;  // a portal file; NULL: portals are made from the leaves, each of which is a cell
    bool clear_water;  // made from leaves: sight passes the surfaces of water, slime and lava
} QuakePortals;

// Adds the portals between the leaves of the tree to a building of which each leaf in a cluster is a cell. Faces of cells come from
// planes in single precision: where such planes nearly coincide, sight passes. Fails on a tree that cuts its portals into too many
// pieces.
bool quake_make_portals(const QuakeLevel *level, bool clear_water, Arena *arena, QuakeCells *cells,
                        Error *error);

// Cells and portals of a level. Those of a file are refused where they are not of this level: other counts of leaves, or portals
// between other leaves than the tree has there.
bool quake_cells(const QuakeLevel *level, const QuakePortals *portals, Arena *arena, QuakeCells *out,
                 Error *error);

// ---- quake_rows.c: the visibility lump

// The clusters that the level's own lump says are seen from each: bit j of row i; `rows` [cluster_count * words]. What has no row sees
// all, as in games. Fails on rows that leave the lump.
bool quake_rows(const QuakeLevel *level, int words, uint64_t *rows, Error *error);

// The same rows from a matrix of cells: cell j may be seen from cell i where bit j of row i of `seen` [cells * cell_words] is set.
void quake_rows_of_cells(const QuakeLevel *level, const QuakeCells *cells, const uint64_t *seen,
                         int cell_words, int words, uint64_t *rows);

// The content of the file with these rows as its visibility lump, and of Quake with the ambient sounds of its leaves, which follow from
// them; of Quake II with what is heard, the union of all that is seen from what is seen. All else is kept, byte for byte. Fails where
// the lump shares bytes with another, or the file would exceed what its numbers hold.
bool quake_with_rows(const QuakeLevel *level, const uint64_t *rows, int words, Arena *arena, Bytes *out,
                     Error *error);

#endif
