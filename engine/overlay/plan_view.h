// plan_view.h - the plan of a storey as a map: where the eye is, which way it looks, which cells it sees, how doors stand.
#ifndef WALK_PLAN_VIEW_H
#define WALK_PLAN_VIEW_H

#include "engine/core/box_tree.h"
#include "engine/core/draw.h"
#include "visibility/vis.h"

// Where the things lie that a plan shows, so that a plan of a part of a large building looks at that part alone. One thread's at a time.
typedef struct PlanPlaces {
    BoxTree cells, openings, stairs;
    int *stair;      // [stairs.count] objects
    Box rooms;       // around the rooms cut at the height `rooms_z`
    double rooms_z;  // NAN: not known yet
} PlanPlaces;
// Made once for a graph, in the arena.
PlanPlaces *plan_places(const CellGraph *graph, Arena *arena);

typedef struct PlanView {
    const CellGraph *graph;
    PlanPlaces *places;
    const StabForest *forest;  // the stab tree of the eye's cell is drawn; NULL: no tree
    const VisResult *visible;  // its cells are tinted; NULL: none
    const float *door_open;    // as for vis_query
    Vec3 eye;
    double yaw, fov;  // radians, see Viewpoint
    int cell;         // the eye's, or -1
    int storey;       // the one to show; -1: none, it is cut at a height relative to the eye
} PlanView;

// The storey of a place: that of its cell; under the sky the highest storey whose floor is not above the eye; -1 in a building
// without storeys.
int plan_view_storey(const CellGraph *graph, int cell, Vec3 eye);

// The box around the rooms of the storey and the eye, with a margin; of a plan longer than `most` metres, a window around the eye.
// The heights of the box do not matter.
Box plan_view_area(const PlanView *view, double most);

// Draws the plan. `area` is the part of the plan that shows; `point`, in metres of plan, is the unit for widths of lines and sizes of
// letters.
void plan_view_draw(const PlanView *view, Box area, double point, Arena *scratch, const Draw *draw);

#endif
