// film_figures.h - how watchable the frames of a film are: what fills them, and how the eye moves between them.
#ifndef WALK_FILM_FIGURES_H
#define WALK_FILM_FIGURES_H

#include "engine/tour/tour.h"
#include "visibility/hidden/hidden.h"

// A frame is near when the polygon in its middle is nearer than this, metres; it is of one polygon when one fills more than this
// share of it. The eye turns on the spot when it goes slower, m/s, and turns faster, radians a second.
#define FILM_NEAR 0.4
#define FILM_ONE_POLYGON 0.6
#define FILM_SPOT 0.1
#define FILM_TURNS (3 * M_PI / 180)

typedef struct FilmFigures {
    int frames;  // added by film_figures_move
    int turning, in_furniture;
    int views;  // added by film_figures_view
    int near, one_polygon;
    double fastest, quickest;  // m/s, radians a second
} FilmFigures;

// Adds a frame, `seconds` after the frame `before`, which is NULL at the beginning and after a cut.
void film_figures_move(FilmFigures *figures, const Building *building, const TourFrame *before,
                       const TourFrame *at, double seconds);
// Adds what is seen in a frame: depths are along the view, metres. Returns the share of the frame that one polygon fills, the most.
double film_figures_view(FilmFigures *figures, const ItemBuffer *seen);

#endif
