// tour.h - where an eye goes through a building, frame by frame.
#ifndef WALK_TOUR_H
#define WALK_TOUR_H

#include "visibility/vis.h"

typedef struct TourFrame {
    Vec3 eye;
    double yaw, pitch, fov;  // radians, see Viewpoint
} TourFrame;

typedef struct TourOptions {
    double step;        // greatest way between two frames, metres, 0.01 .. 10
    double turn;        // greatest turn between two frames, radians, 0.01 .. 1
    double fov;         // horizontal, radians; stored viewpoints keep their own
    double eye_height;  // over the floor, metres; lower in a cell that is lower
} TourOptions;
TourOptions tour_default_options(void);

typedef struct TourPath {
    TourFrame *frames;
    int frame_count, frame_capacity;
    unsigned char *reachable, *visited;  // [cell_count]; of a stored tour or viewpoint all zero
    int reachable_count, visited_count;
} TourPath;

// `auto`: every cell that a person reaches from Building.start through doors, passages, open sides of rooms and over
// stairs, never through windows; on first entering a room a full turn at its centre. Outdoors it steps just into
// each cell, and looks back at each outer door. Any other name: a stored tour, or a stored
// viewpoint (one frame). False, with the names there are, when there is none of that name.
bool tour_make(const CellGraph *graph, const char *name, const TourOptions *options, Arena *arena,
               TourPath *out, Error *error);

#endif
