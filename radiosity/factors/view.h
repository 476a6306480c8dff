// view.h - the faces in front of a point of a surface: those that the stab trees allow, in the axes of the point.
#ifndef RADIOSITY_VIEW_H
#define RADIOSITY_VIEW_H

#include "radiosity/mesh/mesh.h"

// A face from the eye. The eye is at the origin; z is the normal of the surface it is on.
typedef struct ViewFace {
    int face;                        // in Mesh.faces; of faces equally far away the lower one is seen
    int first_vertex, vertex_count;  // in View.vertices; counter-clockwise seen from the face's front
    Vec3 n;                          // unit, to the face's front
    double d;                        // dot(n, p) = d on its plane; below 0: the eye is in front of it
} ViewFace;

// The faces before a point. They lie in the viewer, until this looks again.
typedef struct View {
    Vec3 eye, x, y, z;  // building space; x, y, z are unit and right-handed
    // Those with a point above the horizon (z > 0) whose planes do not hold the eye; near to far as their nearest
    // corners are, which says nothing certain about which hides which.
    ViewFace *faces;
    // Metres from the eye, in the view's axes: dot(x, v - eye) and so on, to the last bit. There is room for one more.
    Vec3 *vertices;
    int face_count, vertex_count;
    bool by_depth;  // faces wholly behind drawn ones may be passed over
} View;

// Where to look from.
typedef struct ViewPoint {
    Vec3 eye, normal;
    int cell;  // of the graph, in front of the surface; -1: unknown, nothing is culled
} ViewPoint;

// A viewer lists the faces before points. It is one thread's at a time, and lives in the arena of viewer_new; mesh and forest outlive
// it.
typedef struct Viewer Viewer;
// `door_open` as for mesh_build. All memory is taken here.
Viewer *viewer_new(const Mesh *mesh, const StabForest *forest, const float *door_open, Arena *arena);
// Valid until the next look. Allocates nothing. Of culling: CULL_NONE lists every face above the horizon; with all others the samplers
// also leave out faces behind those drawn before, and with CULL_DEPTH this alone; CULL_PLAN takes the squares of each cell.
const View *viewer_look(Viewer *viewer, const ViewPoint *from, Culling culling);
// Axes for a normal, the same whenever asked.
void view_axes(Vec3 normal, Vec3 *x, Vec3 *y);

#endif
