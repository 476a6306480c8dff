// box_tree.h - hierarchies of boxes: finds the boxes that meet a box without looking at all of them, and splits sets of boxes for
// hierarchies that callers build themselves, by the surface-area heuristic in bins (I. Wald, On fast construction of SAH-based
// bounding volume hierarchies, 2007).
#ifndef CORE_BOX_TREE_H
#define CORE_BOX_TREE_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// A balanced binary tree, see box_tree_build.
typedef struct BoxTree {
    const Box *boxes;  // [count] as given; the caller keeps them
    int *order;        // [count] their indices, leaf by leaf
    struct BoxNode *nodes;
    int count, node_count;
} BoxTree;

// The items that a search found. Start with {0}; one BoxHits serves many searches, and keeps its memory.
typedef struct BoxHits {
    int *items;
    int count, capacity;
    long long looked;  // nodes and boxes looked at, over all searches
} BoxHits;

// Boxes may overlap, be points, or be empty (box_empty); empty boxes are never found. The same boxes always give the same tree.
BoxTree box_tree_build(const Box *boxes, int count, Arena *arena);

// Fills `hits` with the indices of the boxes that overlap or touch `box`, ascending, and returns their number. Looks at about
// log(count) boxes more than it finds. `arena` provides the memory of hits->items.
int box_tree_find(const BoxTree *tree, Box box, Arena *arena, BoxHits *hits);

// A box that is sorted into a hierarchy.
typedef struct BoxItem {
    Box box;
    Vec3 centre;
    int item;  // the caller's index
} BoxItem;

double box_half_area(Box box);  // half the area of its surface; 0 for an empty box
Box box_of_items(const BoxItem *items, int count);

// Ways to split boxes.
enum {
    BOX_SPLIT_ANY_AXIS,
    // Only along the axis on which the centres lie farthest apart: the tree is built in three fifths of the time.
    BOX_SPLIT_LONGEST,
    // Into two halves, in the order given.
    BOX_SPLIT_HALVES
};

// Moves the items on one side of the cheapest split to the front and returns their number, 1 .. count - 1 for two items or more.
// Where no axis separates the centres, or with BOX_SPLIT_HALVES, the items keep their order and count / 2 is returned.
int box_split(BoxItem *items, int count, int way);

#endif
