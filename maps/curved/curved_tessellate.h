// curved_tessellate.h - curved shapes as polygons, within a tolerance.
#ifndef MAPS_CURVED_TESSELLATE_H
#define MAPS_CURVED_TESSELLATE_H

#include "maps/building/building.h"

// Convex polygons, flat to rounding, counter-clockwise from outside (of a patch: along its normal). Polygons that touch share
// their vertices to the last bit.
typedef struct CurvedMesh {
    Vec3 *vertices;  // [first[polygon_count]] polygon i has first[i] .. first[i + 1] - 1
    int *first;      // [polygon_count + 1]
    int polygon_count;
    // The tolerance that is kept, metres: larger than asked for where CURVED_MOST_SIDES and the like do not reach it;
    // INFINITY, and no polygons, where trims cut a patch into too many pieces.
    double tolerance;
    int vertex_capacity, first_capacity;
} CurvedMesh;

// The most sides around a sphere, cylinder or cone, steps along a patch, and steps of the grid of metaballs.
enum { CURVED_MOST_SIDES = 256, CURVED_MOST_STEPS = 64, CURVED_MOST_CELLS = 96 };
// The most corners of a polygon: methods of hidden surfaces take no more in one piece.
enum { CURVED_MOST_CORNERS = 32 };

// The controls, trims and balls are those of `b`. `tolerance` above 0, metres. Patches that share a border (the same four
// controls, whichever way round) get the same points along it at the same tolerance.
void curved_tessellate(const Building *b, const CurvedShape *shape, double tolerance, Arena *arena,
                       CurvedMesh *out);

// ---- for the files of the tessellation alone
void curved_mesh_add(CurvedMesh *mesh, Arena *arena, const Vec3 *vertices, int count, bool flip);
// Adds two triangles where the quad is bent.
void curved_mesh_add_quad(CurvedMesh *mesh, Arena *arena, const Vec3 quad[4]);
void curved_patch_mesh(const CurvedControl *control, double tolerance, Arena *arena, CurvedMesh *out);
void curved_trimmed_mesh(const CurvedControl *control, const CurvedTrim *trims, int trim_count,
                         double tolerance, Arena *arena, CurvedMesh *out);
void curved_balls_mesh(const CurvedBall *balls, int count, double threshold, double tolerance, Arena *arena,
                       CurvedMesh *out);
// How many steps along u and v a patch needs, and along a border of it: one of the same few numbers, so that neighbours
// often have the same. Returns how far off the steps leave the patch, metres.
double curved_patch_steps(const CurvedControl *control, double tolerance, int *u, int *v);
int curved_border_steps(const CurvedControl border[4], double tolerance);
int curved_finer_steps(int steps);  // the next of these numbers

#endif
