// tour.h - where an eye goes through a building, frame by frame.
#ifndef WALK_TOUR_H
#define WALK_TOUR_H

#include "visibility/vis.h"

typedef struct TourFrame {
    Vec3 eye;
    double yaw, pitch, fov;  // radians, see Viewpoint
} TourFrame;

typedef struct TourOptions {
    double step;        // greatest distance between two frames, metres, 0.01 .. 10
    double turn;        // greatest turn between two frames, radians, 0.01 .. 1
    double fov;         // horizontal, radians; stored viewpoints keep their own
    double eye_height;  // over the floor, metres; less in a cell with a low ceiling
} TourOptions;
TourOptions tour_default_options(void);

typedef struct TourPath {
    TourFrame *frames;
    int frame_count, frame_capacity;
    unsigned char *reachable, *visited;  // [cell_count]; all zero for a stored tour or viewpoint
    int reachable_count, visited_count;
} TourPath;

// Makes the frames of the tour `name`. `auto` visits every cell that a person reaches from Building.start through doors, passages,
// open sides of rooms and over stairs, never through windows; on first entering a room it makes a full turn at the room's centre.
// Outdoors it steps just into each cell, and looks back at each outer door. Any other name is a stored tour, or a stored viewpoint
// (one frame). Returns false, with an error that lists the existing names, when there is none of that name.
bool tour_make(const CellGraph *graph, const char *name, const TourOptions *options, Arena *arena,
               TourPath *out, Error *error);

#endif
