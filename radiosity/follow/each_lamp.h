// each_lamp.h - the light of each lamp by itself, along the rows of a solution of all: any state of the lamps is a sum of these.
//
// Source: J. M. Airey, J. H. Rohlf & F. P. Brooks, Towards Image Realism with Interactive Update Rates in Complex Virtual Building
// Environments, 1990: light is linear in what is emitted, so that lamps are switched by sums.
#ifndef RADIOSITY_EACH_LAMP_H
#define RADIOSITY_EACH_LAMP_H

#include "radiosity/mesh/lamps.h"
#include "radiosity/show/direct.h"

// A light that was shot with all lamps fully lit, along `options->rows`, which are there still, and shown with their sources apart.
typedef struct EachLamp {
    const Mesh *mesh;
    const Lamps *lamps;
    const StabForest *forest;
    const float *door_open;
    const RadOptions *options;
    DirectSources *sources;  // of each_lamp_sources
} EachLamp;

// For direct_show_apart: the lamps are the sources.
DirectSources *each_lamp_sources(const Mesh *mesh, const Lamps *lamps, int threads, Arena *arena);

// Finds the light of each lamp, and by day that of the day with all lamps off, into solution->each; `solution` becomes their sum. Light
// that a lamp gives to a block of places is left out where it is less than four millionths of all lamps' there. Of each lamp's light a
// thousandth of options->residual is not shot, but no less than a millionth where that is below a tenth of it. The same on any number of
// threads. False where progress asked to stop: then nothing changed.
bool each_lamp_find(const EachLamp *each, const Progress *progress, Arena *arena, RadSolution *solution);

// The sum for another state of the lamps, `lit` [solution->lamp_count], into `solution`, whose arrays are overwritten. The solution must
// have `each`.
void each_lamp_sum(RadSolution *solution, const Rgb *lit);

// The light of one source, fully lit, as a solution with arrays of its own in the arena.
RadSolution each_lamp_one(const RadSolution *solution, int source, Arena *arena);

// Memory that the light of all sources takes, bytes.
size_t each_lamp_bytes(const RadSolution *solution);

#endif
