// box_tree.h - boxes in hierarchies: which of many boxes meet a box, without looking at all of them; and where to part boxes for
// a hierarchy of one's own, by the surface-area heuristic in bins (I. Wald, On fast construction of SAH-based bounding volume
// hierarchies, 2007).
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

// Boxes may overlap, be points, or be empty (box_empty): those are never found. The same boxes give the same tree.
BoxTree box_tree_build(const Box *boxes, int count, Arena *arena);

// Fills `hits` with the indices of the boxes that overlap or touch `box`, ascending. Returns how many. Looks at about
// log(count) boxes more than it finds. `arena` is for hits->items.
int box_tree_find(const BoxTree *tree, Box box, Arena *arena, BoxHits *hits);

// A box that is sorted into a hierarchy.
typedef struct BoxItem {
    Box box;
    Vec3 centre;
    int item;  // the caller's
} BoxItem;

double box_half_area(Box box);  // of its surface; 0 where it is empty
Box box_of_items(const BoxItem *items, int count);

// Ways to part boxes.
enum {
    BOX_SPLIT_ANY_AXIS,
    // Along the axis on which the centres lie farthest apart alone: the tree is made in three fifths of the time.
    BOX_SPLIT_LONGEST,
    // Half of them, as they come.
    BOX_SPLIT_HALVES
};

// Puts those first that the cheapest split parts from the others; returns how many, 1 .. count - 1 of two or more. Half, as they
// come, where there is no telling them apart.
int box_split(BoxItem *items, int count, int way);

#endif
