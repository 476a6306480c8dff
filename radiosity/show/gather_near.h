// gather_near.h - what surfaces reflect that are close to a point for the size of their elements: walked to, not looked up.
#ifndef RADIOSITY_GATHER_NEAR_H
#define RADIOSITY_GATHER_NEAR_H

#include "radiosity/shoot/shoot.h"

// The reach of near elements, and the length of walks.
typedef struct NearOptions {
    double reach;  // elements are near within so many times their size; 0: none is
    double error;  // standard error to be content with, of all light but that of lamps in sight
    int blocks;    // of 1021 walks, at most
} NearOptions;
// As `bake --probe` takes it.
NearOptions near_default_options(void);

// One thread's.
typedef struct NearGatherer NearGatherer;
// All memory is taken here.
NearGatherer *near_gatherer_new(const Mesh *mesh, const RadSolution *solution, const NearOptions *options,
                                Arena *arena);
// Lets go of what is not in the arena.
void near_gatherer_end(NearGatherer *self);

// Looks from a point; what follows is about it. It depends on nothing but the point, and allocates nothing.
void near_gatherer_look(NearGatherer *self, Vec3 eye, Vec3 normal);
// For the point looked from: is this element one that is walked to?
bool near_gatherer_is_near(NearGatherer *self, int element);
// The mean of what near elements reflect where the point sees them, as much as each of them is seen: W/m^2 a channel. False: walks
// do not find any.
bool near_gatherer_mean(NearGatherer *self, double reflected[3]);

#endif
