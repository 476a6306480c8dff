// recording.h - a path as it was walked: where the eye was and how far each door stood open, frame by frame. The path
// holds states, not input, so that it replays exactly on any later version of the program.
//
// The file: `enfilade path 1`, `building "NAME" HASH`, `ticks 60`, then a line for each frame: X Y Z YAW PITCH FOV, where a
// dash stands for the number of the frame before. `door INDEX SHARE` before a frame: that door stands open by this share
// from this frame on (all doors are closed before). `= N`: the next N frames change nothing. Numbers read back to the same
// bits.
#ifndef WALK_RECORDING_H
#define WALK_RECORDING_H

#include "engine/core/file.h"
#include "engine/sim/tour.h"

// Frames of a recorded path in a second.
#define RECORDING_TICKS 60
// Frames of one path at most: four hours, up to 90 MB in memory.
#define RECORDING_LONGEST (4 * 3600 * RECORDING_TICKS)

typedef struct Recording {
    Arena *arena;
    const char *building;  // the name of its file, without folders
    uint64_t hash;         // of that file
    TourFrame *frames;
    // Doors that stand otherwise from `frame` on, in order of their frames.
    struct {
        int frame, opening;
        float open;  // see Leaf
    } * doors;
    float *door_open;  // [opening_count] in the last frame
    int opening_count, frame_count, door_count, frame_capacity, door_capacity;
} Recording;

Recording *recording_new(const Building *building, Arena *arena);
// `door_open` as for vis_query, but never NULL. Adds nothing and returns false when the path is as long as can be or the
// frame is one that recording_load would refuse.
bool recording_add(Recording *recording, const TourFrame *frame, const float *door_open);
bool recording_save(const Recording *recording, const char *path, Error *error);
// NULL with the reason when it is damaged, or was recorded in another building.
Recording *recording_load(const char *path, const Building *building, Arena *arena, Error *error);
// As recording_load, from a file that is already in memory; `bytes` is changed.
Recording *recording_read(const char *path, Bytes bytes, const Building *building, Arena *arena,
                          Error *error);
// Puts the doors as they stand in a frame, where `door_open` has them as in the frame before. Frame 0 needs none before.
void recording_doors(const Recording *recording, int frame, float *door_open);

#endif
