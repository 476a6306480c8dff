// walk_offscreen.h - a tour drawn without a window: frames, video, statistics, and the check that nothing is lost.
#ifndef WALK_OFFSCREEN_H
#define WALK_OFFSCREEN_H

#include "engine/draw/walk_renderer.h"
#include "engine/sim/door_states.h"
#include "engine/sim/tour.h"

typedef struct WalkOptions {
    const char *tour;       // see tour_make
    const char *replay;     // a recorded path to draw instead, or NULL
    const char *folder;     // frames go to frame-00000.png ... here; made if missing; NULL: none are written
    const char *video;      // an MP4 file, or NULL
    const char *stats;      // a CSV file, a line a frame, or NULL
    int width, height;      // pixels, 16 .. 8192
    int every;              // write and film each nth frame only, 1 ..
    int frames_per_second;  // of the video, 1 .. 240; 0: 12, of a recorded path as many as it has
    bool verify;            // each frame also without culling, flat colours, compared
    int random;             // then so many random views, verified only
    int raycast;            // so many of the verified frames, spread evenly, also against rays
    uint64_t seed;          // of random views and random doors
    WalkDoors doors;
    Culling culling;
    WalkLook look;
    const WalkLight *light;  // for WALK_BAKED, or NULL
    FalseColour false_colour;
    TourOptions path;
} WalkOptions;
WalkOptions walk_default_options(void);

typedef struct WalkTotals {
    int frames;         // of the tour
    int random_frames;  // views beside it
    int images;         // files written
    int reachable_cells, visited_cells;
    int polygons_total;
    double polygons_drawn_mean, cells_visible_mean, objects_mean;
    double query_us_mean, query_us_max, frame_ms_mean;
    double portals_tested_mean, objects_tested_mean;
    long mismatched_pixels, missing_polygons;  // over all frames; 0 unless verified
    int raycast_frames;
    long raycast_missing;  // polygons that rays see and the draw list lacks
    int bad_frames;
    const char *first_fault;  // where, for the first bad frame; or NULL
} WalkTotals;

bool walk_offscreen(const CellGraph *graph, const StabForest *forest, const WalkOptions *options,
                    const Progress *progress, Arena *arena, WalkTotals *out, Error *error);

#endif
