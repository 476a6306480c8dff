// tour_film.h - a route as it passes in time: where the eye is, where it looks and how the doors stand.
#ifndef WALK_TOUR_FILM_H
#define WALK_TOUR_FILM_H

#include "engine/tour/tour_route.h"

// The speed and turn of a person who shows a house: metres a second, and radians a second.
#define TOUR_SPEED 1.4
#define TOUR_TURN (M_PI / 3)
// A film is computed at moments so far apart, seconds; frames lie between them.
#define FILM_TICK 0.05

typedef struct FilmMoment {
    Vec3 eye;
    double foot;        // height of the floor under it, metres
    double yaw, pitch;  // radians; yaw is continuous within a leg
    int room;           // see RoutePoint
} FilmMoment;

// A door begins to open or to close.
typedef struct FilmSwing {
    double start;  // seconds of the film
    int opening;
    bool opens;
} FilmSwing;
// From closed to wide open, or back, seconds.
#define FILM_SWING 0.9

typedef struct TourFilm {
    FilmMoment *moments;  // [moment_count] FILM_TICK apart
    int *leg_first;       // [leg_count + 1] leg i is moments[leg_first[i]] ..; between legs there is a cut
    int moment_count, moment_capacity, leg_count;
    FilmSwing *swings;  // [swing_count] in order of their starts
    int swing_count, swing_capacity;
    unsigned char *open_first;  // [opening_count] the door stands open when the film begins
    int opening_count;
} TourFilm;

// Walks the route: never faster than TOUR_SPEED, with eased starts, stops and turns.
void tour_film_walk(const TourRoute *route, Arena *arena, TourFilm *out);
// Lets each door open before the eye comes and close after it has gone, where its leaves have the room to swing.
void tour_film_doors(const CellGraph *graph, Arena *arena, TourFilm *film);
// Turns the eye: where it goes, into rooms, to where the view is long, and never faster than TOUR_TURN.
void tour_film_gaze(const CellGraph *graph, TourFilm *film);

// The shares by which the doors stand open at a time of the film, as for vis_query; `door_open` [opening_count].
void tour_film_shares(const TourFilm *film, double seconds, float *door_open);

#endif
