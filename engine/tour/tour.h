// tour.h - where an eye goes through a building, frame by frame.
#ifndef WALK_TOUR_H
#define WALK_TOUR_H

#include "engine/sim/recording.h"
#include "engine/tour/tour_film.h"

typedef struct TourOptions {
    double step;            // of a stored tour: greatest distance between two frames, metres, 0.01 .. 10
    double turn;            // of a stored tour: greatest turn between two frames, radians, 0.01 .. 1
    double fov;             // horizontal, radians; stored viewpoints keep their own
    int frames_per_second;  // of the automatic tour, 1 .. 240
    int rooms;              // of the automatic tour: at most so many, those nearest to the start; 0: all
} TourOptions;
TourOptions tour_default_options(void);

// All but the frames is empty in a stored tour or viewpoint.
typedef struct TourPath {
    TourFrame *frames;
    int frame_count, frame_capacity;
    bool is_film;  // the automatic tour, whose frames lie evenly in time and whose doors move
    TourFilm film;
    int *cuts;  // [cut_count] the frames before which the eye is put elsewhere
    int cut_count;
    // [cell_count] cells on whose floor a body can stand, anywhere in the building; cells that the eye is in.
    unsigned char *reachable, *visited;
    int reachable_count, visited_count;
    int rooms_enterable, rooms_entered;  // see TourRoute
    const char **notes;                  // [note_count] sentences: what the tour left out, where it begins
    int note_count, note_capacity;
} TourPath;

// Makes the frames of the tour `name`. `auto` walks as a person would (body.h) through all rooms that a body can enter, see
// tour_route.h and tour_film.h. Any other name is a stored tour, or a stored viewpoint (one frame). Returns false, with an error that
// lists the existing names, when there is none of that name.
bool tour_make(const CellGraph *graph, const char *name, const TourOptions *options, Arena *arena,
               TourPath *out, Error *error);

// How the doors of the automatic tour stand in a frame, as for vis_query; `door_open` [opening_count].
void tour_doors(const TourPath *path, int frame, double frames_per_second, float *door_open);

// Is the eye put elsewhere before this frame?
bool tour_is_cut(const TourPath *path, int frame);

#endif
