// collision_walk.h - a body that walks at random through a building while its doors move, watched at every step; and
// every way of a flood walked once.
#ifndef WALK_COLLISION_WALK_H
#define WALK_COLLISION_WALK_H

#include "engine/core/random.h"
#include "engine/sim/collision_check.h"

typedef struct CollisionReport {
    long steps;
    long wall_tests, object_tests, pieces;
    long faults[COLLISION_FAULTS];
    long strays;  // steps that ended where no foot gets
    long relocations, refused;
    // Steps that led nowhere, from a place from which no way leads: and those where one would if one door were elsewhere.
    long stuck, shut_in;
    // Ways of the flood; those on which a body does not arrive; and those where it does not even begin, since it stands
    // there at another height.
    long flood_places, flood_ways, flood_lost, flood_doubtful;
    double seconds;                          // of the steps alone
    uint64_t hash;                           // of every place
    char first_fault[256], first_lost[256];  // where, or ""
} CollisionReport;

typedef struct CollisionWalkOptions {
    long steps;
    uint64_t seed;
    int flood_every;  // each nth way of the flood is walked, 1 ..
} CollisionWalkOptions;

long collision_violations(const CollisionReport *report);  // all faults and strays
// False when no foot can stand at the start of the building.
bool collision_walk(const CellGraph *graph, const CollisionWalkOptions *options, CollisionReport *out,
                    Error *error);

#endif
