// view_fixture.h - faces made by hand and what a point sees of them, for tests of form factors that need no building.
#ifndef TESTS_VIEW_FIXTURE_H
#define TESTS_VIEW_FIXTURE_H

#include "engine/core/random.h"
#include "radiosity/factors/view.h"

typedef struct ViewFixture {
    Mesh mesh;  // whose graph has a building with one material, and nothing else
    int face_capacity, element_capacity, patch_capacity, vertex_capacity, outline_capacity, corner_capacity,
        square_capacity;
} ViewFixture;

ViewFixture *view_fixture_new(Arena *arena);

// A planar convex polygon, counter-clockwise from its front; corners of other faces on its edges may be among its vertices.
// One element. Returns the face's index.
int view_fixture_face(Arena *arena, ViewFixture *f, const Vec3 *v, int count);
// A parallelogram with nx x ny elements, nx of them from p to q.
int view_fixture_quad(Arena *arena, ViewFixture *f, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int nx, int ny);

// A turn about an axis and a shift, for scenes that are aligned with nothing.
typedef struct ViewPose {
    Vec3 x, y, z, shift;
} ViewPose;
ViewPose view_fixture_pose(Random *random, Vec3 shift);
Vec3 view_fixture_place(const ViewPose *pose, Vec3 p);
// A box whose sides are cut into `cuts` x `cuts` quads of one element each, at the same places on opposite and neighbouring
// sides, so that no vertex lies inside another's edge. `inwards`: a room, else furniture. `pose` NULL: as it is.
void view_fixture_box(Arena *arena, ViewFixture *f, Vec3 low, Vec3 high, int cuts, bool inwards,
                      const ViewPose *pose);
// A closed room of 4 x 3 x 2.5 m and `boxes` closed boxes that stand about in it, turned and shifted.
ViewFixture *view_fixture_room(Arena *arena, Random *random, int cuts, int boxes, Vec3 shift);

// The faces that the eye sees, in the order and with the rules of viewer_look; nothing is culled.
View *view_fixture_look(Arena *arena, const ViewFixture *f, Vec3 eye, Vec3 normal);
// From a random point of a random face, a hair's breadth from no edge.
View *view_fixture_look_about(Arena *arena, const ViewFixture *f, Random *random);

// The index in view->faces of the nearest face along `w` (in the view's axes), -1: none; by plain crossings in doubles, face
// by face. `doubt`: within this angle of an edge, or two faces this share of the distance apart, the answer is -2. Exact ties
// go to the lower ViewFace.face.
int view_fixture_cast(const View *view, Vec3 w, double doubt);

#endif
