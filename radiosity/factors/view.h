// view.h - the faces in front of a point of a surface that the stab trees leave, in the axes of the point.
#ifndef RADIOSITY_VIEW_H
#define RADIOSITY_VIEW_H

#include "radiosity/mesh/mesh.h"

// A face in the axes of the view: the eye is at the origin, and z is the normal of the surface that the eye is on.
typedef struct ViewFace {
    int face;  // in Mesh.faces; form_factor_rank decides which of several in one place is seen
    int first_vertex, vertex_count;  // in View.vertices; counter-clockwise seen from the face's front
    // A sphere that contains the face, right to a few roundings of floats; all 0: not known.
    float radius, centre[3];
    Vec3 n;    // unit, to the face's front
    double d;  // dot(n, p) = d on its plane; below 0: the eye is in front of it
} ViewFace;

// Eight faces at most, of one thing, that lie together and are not yet all listed.
typedef struct ViewCluster {
    float centre[3];  // of a box about them, in the view's axes
    float half[3];    // half its size along the building's axes, metres
    float nearest;    // 1 / the distance of the box
    int cluster;      // the viewer's
    unsigned listed;  // a bit for each that is in View.faces, or is none
} ViewCluster;
enum { CLUSTER_FACES = 8, CLUSTER_CORNERS = 4, VIEW_ALL = 0xff };

// The faces before a point. The arrays belong to the viewer and are valid until its next look.
typedef struct View {
    Vec3 eye, x, y, z;  // building space; x, y, z are unit and right-handed
    // [face_count] the faces with a point above the horizon (z > 0) whose planes do not contain the eye, sorted by the distance of
    // their nearest corner. A nearer face in this order may still be hidden by a farther one. Those of clusters follow as they are listed.
    ViewFace *faces;
    // [vertex_count, with room for one more] metres from the eye, in the view's axes: dot(x, v - eye) and so on, to the last bit.
    Vec3 *vertices;
    int face_count, vertex_count;
    // [cluster_count] of viewer_look_at_clusters, the nearest first.
    ViewCluster *clusters;
    int cluster_count;
    struct Viewer *viewer;
    bool by_depth;          // faces wholly behind faces already drawn may be skipped
    const uint64_t *doors;  // a bit for each opening: may its door, moved, change the view? NULL: any may
} View;

// Is the bit of an opening set?
static inline bool view_has_door(const uint64_t *doors, int opening) {
    return !doors || (doors[opening / 64] >> opening % 64 & 1);
}

// Where to look from.
typedef struct ViewPoint {
    Vec3 eye, normal;
    int cell;  // the graph's cell in front of the surface; -1: unknown, nothing is culled
} ViewPoint;

// A viewer lists the faces before points. Only one thread at a time may use a viewer. It lives in the arena of viewer_new; mesh and
// forest must outlive the viewer.
typedef struct Viewer Viewer;
// `door_open` as for mesh_build. All memory is taken here.
Viewer *viewer_new(const Mesh *mesh, const StabForest *forest, const float *door_open, Arena *arena);
// To be called when the mesh was posed anew (mesh_pose).
void viewer_pose(Viewer *viewer);
// Words of View.doors.
int viewer_door_words(const Mesh *mesh);
// Valid until the next look. Allocates nothing. With CULL_NONE and CULL_DEPTH the view lists every face above the horizon. With
// every culling but CULL_NONE the samplers may skip faces behind those already drawn. CULL_PLAN takes the squares of each cell.
const View *viewer_look(Viewer *viewer, const ViewPoint *from, Culling culling);
// The same, but faces of things that have many are left in clusters, for samplers, which need not list what is hidden or meets no sample.
const View *viewer_look_at_clusters(Viewer *viewer, const ViewPoint *from, Culling culling);
// Where the faces of a cluster lie in the view's axes, right to a few roundings of floats: corners of a quadrilateral about each,
// [corner][axis][face].
void view_corners(const View *view, int cluster, float out[CLUSTER_CORNERS][3][CLUSTER_FACES]);
// Lists some faces of a cluster, a bit for each, behind those that are listed, unless they are. Where faces, vertices and clusters lie
// does not change. Returns which of them are listed now: of the others no part is above the horizon, or the eye is in their plane.
unsigned view_list(const View *view, int cluster, unsigned faces);
// Unit axes perpendicular to a unit normal, right-handed with it; the same normal always gives the same axes.
void view_axes(Vec3 normal, Vec3 *x, Vec3 *y);

#endif
