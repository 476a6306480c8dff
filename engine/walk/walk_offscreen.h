// walk_offscreen.h - draws a tour without a window: frames, video, statistics, and the check that no visible polygon is lost.
#ifndef WALK_OFFSCREEN_H
#define WALK_OFFSCREEN_H

#include "engine/sim/door_states.h"
#include "engine/tour/tour.h"
#include "engine/walk/film_figures.h"
#include "engine/walk/film_light.h"

typedef struct WalkOptions {
    const char *tour;       // see tour_make
    const char *replay;     // a recorded path to draw instead, or NULL
    const char *folder;     // frames are written here as frame-00000.png ...; made if missing; NULL: none are
    const char *video;      // an MP4 file, or NULL
    const char *stats;      // a CSV file with a line for each frame, or NULL
    int width, height;      // pixels, 16 .. 8192
    int every;              // write and film every nth frame only, 1 ..; the film is as long as with all
    int frames_per_second;  // 1 .. 240; 0: the rate of a recorded path; of a tour 24 with a video, else 12
    bool verify;            // draw each frame also without culling, in flat colours, and compare
    int random;             // after the tour, verify so many random views
    int raycast;            // compare so many of the verified frames, spread evenly, also with rays
    uint64_t seed;          // of random views and random doors
    WalkDoors
        doors;  // WALK_DOORS: those of the automatic tour move as it passes, others stand clear of views
    Culling culling;
    WalkLook look;
    FilmLightSource light;  // for WALK_BAKED; `light` NULL: there is none
    const Daylight *
        hours;  // [hour_count] under which the frames go by, each as many of them; 0: under the day of the light
    int hour_count;
    FalseColour false_colour;
    TourOptions path;
} WalkOptions;
WalkOptions walk_default_options(void);

typedef struct WalkTotals {
    int frames;                                                                // of the tour
    int random_frames;                                                         // random views verified
    int images;                                                                // files written
    int reachable_cells, visited_cells, rooms_enterable, rooms_entered, cuts;  // see TourPath
    double seconds;                                                            // of the tour
    FilmFigures film;    // views are counted where frames are verified
    const char **notes;  // [note_count] see TourPath
    int note_count;
    int polygons_total;
    double polygons_drawn_mean, cells_visible_mean, objects_mean;
    double query_us_mean, query_us_max, frame_ms_mean;
    double portals_tested_mean, objects_tested_mean;
    long mismatched_pixels, missing_polygons;  // over all frames; 0 unless verified
    long mirrors, mirror_pixels;               // in how many views of mirrors, and at how many pixels of them
    int raycast_frames;
    long raycast_missing;       // polygons that rays see and the draw list lacks
    LitPartsCount light_parts;  // of light in parts, as the frames wanted them
    bool light_stayed;          // doors stood elsewhere than the light of written frames has them
    int bad_frames;
    const char *first_fault;  // the place and view of the first bad frame, or NULL
} WalkTotals;

bool walk_offscreen(const CellGraph *graph, const StabForest *forest, const WalkOptions *options,
                    const Progress *progress, Arena *arena, WalkTotals *out, Error *error);

#endif
