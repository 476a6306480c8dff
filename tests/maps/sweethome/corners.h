// corners.h - a home's pictures held against those of Sweet Home 3D, corner by corner.
//
// The figures come from the program itself, by SweetHomeCorners.java: each triangle that it draws with a picture, and the places of its
// corners in the picture; and the solids of the home. A triangle's point is unseen where the point 2 mm before its front, the only side
// that the program draws, lies in a solid and in no gap of it: mitres in a corner between two walls, backs of baseboards, sides and
// undersides of floors within walls or beside other floors. At all other points of a triangle the building must have a surface
// with a picture, on which the triangle's corners lie within 2 cm of where the program has them.
#ifndef TESTS_CORNERS_H
#define TESTS_CORNERS_H

#include <stdbool.h>

// The triangles of a kind, wall, board, room, piece or ground: those that show the same, that nobody sees, that have no surface of ours
// within 2 cm, and on whose surface the picture lies otherwise.
typedef struct CornersTally {
    const char *kind;
    int same, unseen, missing, off;
} CornersTally;

// Adds to tallies[count] what the kinds named there have. `sized`: each picture has sides of its own, and is told by them.
void corners_compare(const char *home, const char *figures, bool sized, CornersTally *tallies, int count);

#endif
