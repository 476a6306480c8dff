// plain_scene.h - a few quads and what a point sees of them, where a benchmark needs no building.
#ifndef APP_PLAIN_SCENE_H
#define APP_PLAIN_SCENE_H

#include "radiosity/factors/view.h"

enum { PLAIN_QUADS = 64 };

// Each quad is a face of one element. The pointers of `mesh` and `view` lead into the scene itself: it stays where it is.
typedef struct PlainScene {
    Mesh mesh;
    View view;
    Face faces[PLAIN_QUADS];
    Element elements[PLAIN_QUADS];
    Patch patches[PLAIN_QUADS];
    Vec3 vertices[4 * PLAIN_QUADS], seen[4 * PLAIN_QUADS];
    int outline[4 * PLAIN_QUADS], squares[PLAIN_QUADS];
    ViewFace view_faces[PLAIN_QUADS];
} PlainScene;

PlainScene *plain_scene_new(Arena *arena);
// Counter-clockwise from its front.
void plain_scene_add(PlainScene *scene, const Vec3 corner[4]);
// What a point with a normal sees, near to far.
const View *plain_scene_look(PlainScene *scene, Vec3 eye, Vec3 normal);

#endif
