// first_view.h - the view that a walk begins with, and its picture before OpenGL has one.
#ifndef WALK_FIRST_VIEW_H
#define WALK_FIRST_VIEW_H

#include "engine/core/camera.h"
#include "engine/sim/body.h"
#include "visibility/hidden/hidden.h"

// The angle of view of a walk, horizontal, radians.
#define FIRST_VIEW_FOV (75 * M_PI / 180)

// A building to look at; the caller's.
typedef struct FirstScene {
    const CellGraph *graph;
    VisQuery *query;
    const float *door_open;  // as for vis_query
    BodyWorld *world;
} FirstScene;

// The building's start where it looks into a room and not at a wall; else the first stored viewpoint that does; else, where the building
// has rooms, the largest one, from a place where a body fits, along its longest clear view; else the start. `name` is empty but of a
// stored viewpoint. `fov`: horizontal, radians.
Viewpoint first_view(const FirstScene *scene, double fov, Arena *scratch);
// The same for those who have no walk under way: with the doors as a walk in a window finds them, and FIRST_VIEW_FOV.
Viewpoint first_view_of_walk(const CellGraph *graph, const StabForest *forest);

// Draws the view of a camera with the light of walk_bake_plain and neither glass nor shadows: BGRA bytes in `out` [height * width], rows
// from the top. False where the picture cannot be made (hidden_draw).
bool first_picture(const FirstScene *scene, const Camera *camera, Arena *scratch, uint32_t *out,
                   Error *error);

#endif
