// hidden_scenes.h - polygons about an eye for tests of hidden-surface methods: everything that makes them fail.
#ifndef TESTS_HIDDEN_SCENES_H
#define TESTS_HIDDEN_SCENES_H

#include "engine/core/random.h"
#include "visibility/hidden/hidden.h"

typedef struct HiddenSoup {
    Polygon *polygons;
    Vec3 *vertices;
    int polygon_count, vertex_count, polygon_capacity, vertex_capacity;
} HiddenSoup;

void hidden_soup_add(Arena *arena, HiddenSoup *soup, const Vec3 *vertices, int count);
// A convex polygon of 3 to 6 corners on an ellipse of radii a and b, one in three with a collinear corner on its last edge.
void hidden_soup_ellipse(Arena *arena, HiddenSoup *soup, Random *random, Vec3 centre, Vec3 n, double a,
                         double b);
Vec3 hidden_direction(Random *random);

// Random polygons about the eye, with repeats of earlier ones, and sheets whose plane holds the eye.
HiddenSoup hidden_soup_plain(Arena *arena, Random *random, Vec3 eye, int count);

typedef enum HiddenKind {
    SCENE_PLAIN,
    SCENE_RINGS,     // bars that overlap in a ring, three to six of them
    SCENE_CROSSING,  // large polygons through each other
    SCENE_COPLANAR,  // overlapping ones in few planes, some the same corner by corner
    SCENE_EDGE_ON,   // planes that pass the eye, or nearly
    SCENE_THROUGH,   // polygons through the eye's plane: floors, ceilings, walls
    SCENE_SLIVERS,   // 1e-2 to 1e-7 m wide
    SCENE_HUGE,      // 1e3 to 1e7 m large, and away
    SCENE_TINY,      // below a pixel
    SCENE_CLOSE,     // sheets 1e-8 to 1e-6 of their distance apart: nothing to a float
    SCENE_MIXED,     // a few of each
    SCENE_KINDS
} HiddenKind;
extern const char *const HIDDEN_KIND_NAMES[SCENE_KINDS];

HiddenSoup hidden_soup_new(Arena *arena, Random *random, HiddenKind kind, Vec3 eye, int count);

Camera hidden_camera(Random *random, Vec3 eye, int width, int height);  // looks anywhere

#endif
