// soup_fixture.h - buildings of polygons alone, made in memory or read from a reference scene, for tests.
#ifndef TESTS_SOUP_FIXTURE_H
#define TESTS_SOUP_FIXTURE_H

#include "engine/core/random.h"
#include "visibility/vis.h"

// An empty soup with one object to put polygons in, an opaque material 0 and glass, 1.
Building *soup_fixture_new(Arena *arena);
void soup_fixture_quad(Arena *arena, Building *b, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int material);
// The six sides of an upright box.
void soup_fixture_box(Arena *arena, Building *b, Vec3 low, Vec3 high, int material);
// A wall in the plane x = `at` (axis 0) or y = `at` (axis 1) from `from` to `to`, between heights z0 and z1, with a hole
// for each pair of `holes`, from z0 up to `head`.
void soup_fixture_wall(Arena *arena, Building *b, int axis, double at, double from, double to, double z0,
                       double z1, const double *holes, int hole_count, double head);

// nx x ny rooms of 4 x 4 x 2.5 m, closed all around; between neighbours a wall without thickness, mostly with a doorway at
// a random place; under a flat ceiling, or a roof that slants; in some a box of furniture.
Building *soup_fixture_house(Arena *arena, Random *random, int nx, int ny);

// The quads of a reference scene; skips the running test where it is absent.
Building *soup_fixture_read(Arena *arena, const char *name, const char *own);

// The same soup, scaled, turned about an axis and shifted.
typedef struct SoupPose {
    double scale, angle;
    Vec3 axis, shift;
} SoupPose;
Building *soup_fixture_posed(Arena *arena, const Building *b, const SoupPose *pose);
Vec3 soup_fixture_pose_point(const SoupPose *pose, Vec3 p);

// The cells and the stretch of each that a line crosses, told by the cells' planes alone, in order; lines that come
// within `doubt` metres of an edge of the partition are given up.
typedef struct Crossing {
    int cell;
    double from, to;  // along the line
} Crossing;
int soup_fixture_crossings(const CellGraph *graph, Vec3 from, Vec3 direction, Crossing *out, int max);
// Is the point in the polygon's plane and inside it? 1 yes, 0 no, -1: within `doubt` metres of its edges or off its plane.
int soup_fixture_inside(const Vec3 *v, int count, Vec3 p, double doubt);
Vec3 soup_fixture_point(const CellGraph *graph, Random *random, int cell);  // inside the cell

#endif
