// hidden_excuse.h - where two hidden-surface methods may disagree: next to edges, lines of intersection and ties, and nowhere
// else. Told in long doubles from the polygons alone.
#ifndef TESTS_HIDDEN_EXCUSE_H
#define TESTS_HIDDEN_EXCUSE_H

#include "visibility/hidden/facets.h"

typedef enum HiddenExcuse {
    EXCUSE_NONE,
    EXCUSE_EDGE,      // of one of the two polygons
    EXCUSE_CROSSING,  // of the two
    EXCUSE_TIE,       // their depths
    HIDDEN_EXCUSES
} HiddenExcuse;

// How far apart is still a tie or an edge.
typedef struct HiddenSlack {
    double pixels;   // from an edge or a line of intersection
    double depth;    // as a share of it
    double edge_on;  // metres: a polygon whose plane is so near the eye may be seen or not
    bool order;      // of copies of one polygon the first in the list must be seen
} HiddenSlack;

typedef struct HiddenJudge HiddenJudge;
HiddenJudge *hidden_judge_new(const Scene *scene, Arena *arena);

// The excuse of pixel (i, j), where one method sees polygon a and another b (-1: nothing).
HiddenExcuse hidden_excuse(const HiddenJudge *judge, const Camera *camera, int i, int j, int a, int b,
                           HiddenSlack slack);

// How far the eye is from the polygon's plane, metres.
double hidden_height(const HiddenJudge *judge, const Camera *camera, int polygon);

#endif
