// quake_builder.h - small levels of the Quake family, made of boxes in memory: for tests of their reader, and as seeds to fuzz it with.
#ifndef TESTS_QUAKE_BUILDER_H
#define TESTS_QUAKE_BUILDER_H

#include "maps/quake/quake.h"

// Boxes of space in solid rock, whole game units, none of which overlap.
typedef struct QuakeBox {
    int min[3], max[3];
    int contents;         // as in a leaf; 0 of Quake: empty
    const char *picture;  // of the one face that lies in each of its leaves; NULL: none
} QuakeBox;

// A leaf that a level came to have: its number, its box, and whose part it is.
typedef struct QuakeBuiltLeaf {
    int leaf, from;  // `from` in the list of boxes
    int min[3], max[3];
} QuakeBuiltLeaf;

typedef struct QuakeBuilt {
    Bytes file;
    QuakeBuiltLeaf *leaves;  // [count] without solid ones
    int count;
} QuakeBuilt;

// How a level is written.
typedef struct QuakeStyle {
    QuakeFormat format;
    bool joined;       // of Quake II: the leaves of a box are one cluster; else each is its own
    Bytes visibility;  // the lump as the file has it at first; none: empty
    bool last;         // that lump stands behind all others, not in their midst
    const char *bspx;  // what is appended as the one entry of a BSPX block; NULL: no block
} QuakeStyle;

QuakeBuilt quake_build(Arena *arena, const QuakeBox *boxes, int count, const QuakeStyle *style);

// Rooms around a corridor, with a pool, lava and a piece of sky.
extern const QuakeBox QUAKE_ROOMS[];
extern const int QUAKE_ROOM_COUNT;

#endif
