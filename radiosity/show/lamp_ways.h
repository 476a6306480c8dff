// lamp_ways.h - the lamps that objects may see, by the stab trees, and the portals through which the light of a lamp may come.
#ifndef RADIOSITY_LAMP_WAYS_H
#define RADIOSITY_LAMP_WAYS_H

#include "radiosity/show/shaft.h"
#include "visibility/vis.h"

// Lamps are objects of the graph here. Any number of threads may read it once it is made. It lives in the arena of the call that made
// it; graph, forest and `lamp` must outlive it.
typedef struct LampWays LampWays;
// lamp [lamp_count]: the objects with faces that emit.
LampWays *lamp_ways_new(const CellGraph *graph, const StabForest *forest, const int *lamp, int lamp_count,
                        Arena *arena);
// The first lamp after number `after` (-1: the first of all) that the object may see, all doors open; -1: there is none. An object or a
// lamp in no cell may see all.
int lamp_ways_next(const LampWays *ways, int object, int after);

// A search along portals. Only one thread at a time may use it. It lives in the arena of the call that made it.
typedef struct LampFlood LampFlood;
LampFlood *lamp_flood_new(const LampWays *ways, Arena *arena);
// May light come from object `to` to object `from` within the shaft between their parts, as far as portals tell? True where one of
// them is in no cell.
bool lamp_flood_reaches(LampFlood *flood, const Shaft *shaft, int from, int to);

#endif
