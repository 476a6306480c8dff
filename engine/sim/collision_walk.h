// collision_walk.h - a body walks at random through a building while its doors move, and every step is checked; and it walks every
// way of a flood (the places that can be reached by foot, on a grid) once.
#ifndef WALK_COLLISION_WALK_H
#define WALK_COLLISION_WALK_H

#include "engine/core/random.h"
#include "engine/sim/collision_check.h"

typedef struct CollisionReport {
    long steps;
    long wall_tests, object_tests, pieces;
    long faults[COLLISION_FAULTS];
    long strays;  // steps that ended where no walking body can get
    long relocations, refused;
    // Steps that led nowhere, from a place from which no way leads, and from a place from which a way would lead if one door stood
    // differently.
    long stuck, shut_in;
    // Places of the flood; its ways that were walked; ways on which a body does not arrive; and ways that a body does not even
    // begin, since it stands at their start at another height.
    long flood_places, flood_ways, flood_lost, flood_doubtful;
    double seconds;                          // of the steps alone
    uint64_t hash;                           // of every place
    char first_fault[256], first_lost[256];  // where, or ""
} CollisionReport;

typedef struct CollisionWalkOptions {
    long steps;
    uint64_t seed;
    int flood_every;  // every nth way of the flood is walked, 1 ..
} CollisionWalkOptions;

long collision_violations(const CollisionReport *report);  // all faults and strays
// Returns false when no body can stand near the start of the building.
bool collision_walk(const CellGraph *graph, const CollisionWalkOptions *options, CollisionReport *out,
                    Error *error);

#endif
