// recording.h - a path as it was walked: where the eye was and how far each door stood open, frame by frame. The path
// holds states, not input, so that it replays exactly on any later version of the program.
//
// The file: `enfilade path 1`, `building "NAME" HASH`, `ticks 60`, then a line for each frame: X Y Z YAW PITCH FOV, where a dash
// stands for the same number as in the frame before. `door INDEX SHARE` before a frame: that door stands open by this share from
// this frame on (before the first frame all doors are closed). `= N`: the next N frames change nothing. Numbers are written so that
// they read back to the same bits.
#ifndef WALK_RECORDING_H
#define WALK_RECORDING_H

#include "engine/core/file.h"
#include "visibility/vis.h"

// Frames per second of a recorded path.
#define RECORDING_TICKS 60
// The most frames of one path: four hours, up to 90 MB in memory.
#define RECORDING_LONGEST (4 * 3600 * RECORDING_TICKS)

// Where an eye is and looks in a frame.
typedef struct TourFrame {
    Vec3 eye;
    double yaw, pitch, fov;  // radians, see Viewpoint
} TourFrame;

typedef struct Recording {
    Arena *arena;
    const char *building;  // the name of its file, without folders
    uint64_t hash;         // of that file
    TourFrame *frames;
    // Changes of doors, in order of their frames: from `frame` on the door `opening` stands open by `open`.
    struct {
        int frame, opening;
        float open;  // see Leaf
    } * doors;
    float *door_open;  // [opening_count] in the last frame
    int opening_count, frame_count, door_count, frame_capacity, door_capacity;
} Recording;

Recording *recording_new(const Building *building, Arena *arena);
// Adds a frame; `door_open` is as for vis_query, but never NULL. Returns false and adds nothing when the path has RECORDING_LONGEST
// frames or recording_load would refuse the frame.
bool recording_add(Recording *recording, const TourFrame *frame, const float *door_open);
bool recording_save(const Recording *recording, const char *path, Error *error);
// Returns NULL, with the reason, when the file is damaged or was recorded in another building.
Recording *recording_load(const char *path, const Building *building, Arena *arena, Error *error);
// As recording_load, from a file that is already in memory; `bytes` is changed.
Recording *recording_read(const char *path, Bytes bytes, const Building *building, Arena *arena,
                          Error *error);
// Changes `door_open` [opening_count] from the doors' shares in the frame before to their shares in `frame`. For frame 0 its
// earlier content does not matter.
void recording_doors(const Recording *recording, int frame, float *door_open);

#endif
