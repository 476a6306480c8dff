// peer_frames.h - an occlusion culler of others on the frames of a walk: it is told the building and the frames in a file, and answers
// with the objects that it would draw.
#ifndef BENCH_PEER_FRAMES_H
#define BENCH_PEER_FRAMES_H

#include "engine/bench/peer.h"
#include "engine/core/camera.h"
#include "visibility/vis.h"

// Its answer to a frame.
typedef struct PeerFrame {
    double seconds;
    const int *objects;  // [object_count] increasing
    int object_count;
} PeerFrame;

// Runs `program FRAMES ANSWERS`, two paths in a new folder, for cameras [count] in a building with all doors open. Both files are text in
// metres, z up. FRAMES:
//
//     objects N
//     object X0 Y0 Z0 X1 Y1 Z1             the box of one
//     polygon GLASS X Y Z X Y Z X Y Z ...  of the object before it; GLASS is 1 where one looks through it
//     frames M
//     frame WIDTH HEIGHT TAN_X TAN_Y EYE FORWARD RIGHT UP   vectors of three numbers, see Camera
//
// Objects that are no leaves of doors keep their places. ANSWERS has a line a frame: the microseconds that the frame took, then the numbers
// of the objects to draw, from 0, increasing. `frames` [count] lives in the arena. Fails with a sentence where the program fails or its
// answer is bad.
bool peer_frames(const char *program, const CellGraph *graph, const Camera *cameras, int count, Arena *arena,
                 PeerFrame *frames, Error *error);

#endif
