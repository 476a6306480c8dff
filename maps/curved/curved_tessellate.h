// curved_tessellate.h - curved shapes as polygons, within a tolerance.
#ifndef MAPS_CURVED_TESSELLATE_H
#define MAPS_CURVED_TESSELLATE_H

#include "maps/building/building.h"

// Convex polygons, flat to rounding, counter-clockwise seen from outside (of a patch: from the side to which its normal points).
// Polygons that touch share their vertices to the last bit.
typedef struct CurvedMesh {
    Vec3 *vertices;  // [first[polygon_count]] polygon i has first[i] .. first[i + 1] - 1
    int *first;      // [polygon_count + 1]
    int polygon_count;
    // The tolerance reached, metres: larger than asked for where CURVED_MOST_SIDES or a limit like it is too small for it;
    // INFINITY, with no polygons, where trims cut a patch into too many pieces.
    double tolerance;
    int vertex_capacity, first_capacity;
} CurvedMesh;

// The most sides around a sphere, cylinder or cone, steps along a patch, and steps of the grid of metaballs.
enum { CURVED_MOST_SIDES = 256, CURVED_MOST_STEPS = 64, CURVED_MOST_CELLS = 96 };
// The most corners of a polygon: the hidden-surface methods accept at most this many.
enum { CURVED_MOST_CORNERS = 32 };

// The controls, trims and balls of `shape` are in `b`. `tolerance` is above 0, metres. Patches that share a border (the same
// four controls, whichever way round) get the same points along that border at the same tolerance.
void curved_tessellate(const Building *b, const CurvedShape *shape, double tolerance, Arena *arena,
                       CurvedMesh *out);

// ---- for the files of the tessellation alone
void curved_mesh_add(CurvedMesh *mesh, Arena *arena, const Vec3 *vertices, int count, bool flip);
// Adds the quad as one polygon, or as two triangles where it is bent.
void curved_mesh_add_quad(CurvedMesh *mesh, Arena *arena, const Vec3 quad[4]);
void curved_patch_mesh(const CurvedControl *control, double tolerance, Arena *arena, CurvedMesh *out);
void curved_trimmed_mesh(const CurvedControl *control, const CurvedTrim *trims, int trim_count,
                         double tolerance, Arena *arena, CurvedMesh *out);
void curved_balls_mesh(const CurvedBall *balls, int count, double threshold, double tolerance, Arena *arena,
                       CurvedMesh *out);
// The numbers of steps that a patch needs along u and v, and that one of its borders needs. All are chosen from the same few
// numbers, so that neighbours often agree. curved_patch_steps returns how far polygons with these steps lie off the patch, metres.
double curved_patch_steps(const CurvedControl *control, double tolerance, int *u, int *v);
int curved_border_steps(const CurvedControl border[4], double tolerance);
int curved_finer_steps(int steps);  // the next of these numbers

#endif
