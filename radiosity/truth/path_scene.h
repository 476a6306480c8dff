// path_scene.h - the faces of a mesh as light paths meet them: what a ray sees first, by Embree in its robust mode.
#ifndef RADIOSITY_PATH_SCENE_H
#define RADIOSITY_PATH_SCENE_H

#include "radiosity/mesh/mesh.h"

// Points are metres from `origin`, the middle of the mesh: Embree's coordinates are floats.
typedef struct PathScene {
    const Mesh *mesh;
    Vec3 origin;
    double off;         // metres: rays start so far before their surface, lest they meet it
    Vec3 *centres;      // [face_count] of their corners
    double *distances;  // [face_count] dot(n, p) on their planes
    bool *contested;    // [face_count] another face lies in the same place, in part
    int *face_of;       // [triangle]
    struct Embree *embree;
} PathScene;

PathScene *path_scene_new(const Mesh *mesh, Arena *arena);
void path_scene_end(PathScene *scene);

typedef struct PathHit {
    int face;    // -1: nothing
    bool front;  // its front was met
    Vec3 point;  // on its plane
} PathHit;
// Among faces in one place the ray meets the one that turns its front to it, then the lower in the mesh, as for form factors.
// May be called by many threads.
PathHit path_scene_trace(const PathScene *scene, Vec3 from, Vec3 along);

// Where rays from a point of a face start, or of whatever surface has that normal.
Vec3 path_scene_before(const PathScene *scene, int face, Vec3 point);
static inline Vec3 path_scene_off(const PathScene *scene, Vec3 point, Vec3 normal) {
    return vec3_add(point, vec3_scale(normal, scene->off));
}

#endif
