// home_fixture.h - small Sweet Home 3D homes made in memory, for the tests of their reader.
#ifndef TESTS_HOME_FIXTURE_H
#define TESTS_HOME_FIXTURE_H

#include "maps/sweethome/sh3d.h"

typedef struct Home {
    Arena arena;
    Building b;
    Sketch sketch;
    Error error;
    bool good;
} Home;

Home home_of_bytes(Bytes xml, Archive *archive);
// A home of the given elements.
Home home_of(const char *format, ...) __attribute__((format(printf, 1, 2)));
void home_free(Home *h);
int home_note(const Home *h, const char *words);  // the first note that holds them, or -1

// A home that is right without further elements.
#define HOME_ROOM                                                                                            \
    "<room><point x='0' y='0'/><point x='400' y='0'/><point x='400' y='300'/><point x='0' "                  \
    "y='300'/></room>\n"

typedef struct HomeEntry {
    const char *name;
    const void *data;
    size_t size;
} HomeEntry;

Bytes home_zip(Arena *arena, const HomeEntry *entries, int count);
Home home_of_zip(const HomeEntry *entries, int count);  // its Home.xml, with what else is in it

// A wedge with one corner at each of (1, 0, 0), (0, 2, 0), (0, 0, 4) and the origin: no two views of it are alike.
#define HOME_WEDGE                                                                                           \
    "mtllib w.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\nusemtl skin\n"                                        \
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
#define HOME_WEDGE_LIBRARY "newmtl skin\nKd 1 0 0\n"

// The sash of a door, hinged at the left of its opening or at the right.
#define HOME_SASH_LEFT "<sash xAxis='0.05' yAxis='0.5' width='0.9' startAngle='0' endAngle='-1.5707964'/>"
#define HOME_SASH_RIGHT                                                                                      \
    "<sash xAxis='0.95' yAxis='0.5' width='0.9' startAngle='3.1415927' endAngle='4.712389'/>"

#endif
