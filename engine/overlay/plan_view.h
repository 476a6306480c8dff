// plan_view.h - the plan of a storey as a map: where the eye is, which way it looks, which cells it sees, how doors stand.
#ifndef WALK_PLAN_VIEW_H
#define WALK_PLAN_VIEW_H

#include "engine/core/draw.h"
#include "visibility/vis.h"

typedef struct PlanView {
    const CellGraph *graph;
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
