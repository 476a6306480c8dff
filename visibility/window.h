// window.h - a large building group by group: the cells that a group of cells may see, as a cell graph of their own.
//
// A line from a cell stays in cells that this one may see. So what is decided of lines that begin in the group holds in the building if
// it holds in the window, and costs what the window costs, however large the building.
#ifndef VISIBILITY_WINDOW_H
#define VISIBILITY_WINDOW_H

#include "visibility/vis.h"

// Windows pay in a building of more cells than WINDOW_LEAST of which a cell, in the mean, sees less than one in WINDOW_SHARE.
enum { WINDOW_LEAST = 1024, WINDOW_SHARE = 32, WINDOW_GROUP = 256 };
bool window_pays(const CellRows *near);

// Cells that lie near each other, in groups.
typedef struct CellGroups {
    int *cell;   // [cell_count] group g is cell[first[g]] ..
    int *first;  // [count + 1]
    int count;
} CellGroups;

// Groups of `size` cells at most; one of all cells has them in their order.
CellGroups cell_groups(const CellGraph *graph, int size, Arena *arena);
// Groups that no portal leads out of, each as small as it can be, but that small ones are together until they have `least` cells. A group
// has its cells in their order.
CellGroups cell_houses(const CellGraph *graph, int least, Arena *arena);

// Cells and portals have the order that they have in the building.
typedef struct CellWindow {
    CellGraph
        graph;  // cells, portals and their vertices alone: of cells their number, of portals all but the door
    int *cell, *portal;  // of the building
    uint64_t *own;       // bit i: cell i is of the group
    int own_count;
} CellWindow;

// `near`: the cells that each cell may see, itself among them. `place` [cell_count] tells where cells of the building are in the window,
// -1: not there; it comes as -1 throughout, and window_leave makes it so again.
void window_enter(const CellGraph *graph, const CellRows *near, const int *group, int count, int *place,
                  Arena *arena, CellWindow *out);
void window_leave(const CellWindow *window, int *place);
// A group that no portal leads out of as a building of its own. Unlike a window its graph has cells, of which the box and ways are set.
void window_of_house(const CellGraph *graph, const int *group, int count, int *place, Arena *arena,
                     CellWindow *out);

#endif
