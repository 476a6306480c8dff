// gather.h - the light that arrives at a point, gathered from all elements that it sees of a solution (final gather; Reichert 1992).
#ifndef RADIOSITY_GATHER_H
#define RADIOSITY_GATHER_H

#include "radiosity/shoot/shoot.h"
#include "radiosity/show/reconstruct.h"

// How light is gathered.
typedef struct GatherOptions {
    const FormFactorMethod *method;  // gives the weight of each element's mean
    int resolution;                  // of it, 8 .. 2000
    Culling culling;
    bool exact_lamps;  // emitted light by closed form, whatever the method
    // Walks to close elements.
    struct {
        double
            reach;  // elements are near within so many times their size; 0: close elements are looked up like others
        double error;  // standard error to be content with, of all light but that of lamps in sight
        int blocks;    // of 1021 walks, at most
    } near;
} GatherOptions;
// As `bake --probe` takes it.
GatherOptions gather_default_options(void);
// As exact as it gets, at ten times the cost: analytic rows. And walks to close elements: nothing in the open, 10 to 100 ms in corners
// and slits.
GatherOptions gather_exact_options(void);

// The scene whose light is gathered.
typedef struct GatherScene {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    const RadSolution *solution;
    const VertexLight *light;  // says how light slopes in each element; NULL: not at all
} GatherScene;

// A gatherer finds the light at points. It is one thread's at a time, and lives in the arena of gatherer_new but for what gatherer_end
// lets go of.
typedef struct Gatherer Gatherer;
// All memory is taken here; the data that `scene` points to must outlive it.
Gatherer *gatherer_new(const GatherScene *scene, const GatherOptions *options, Arena *arena);
// Frees the memory outside the arena.
void gatherer_end(Gatherer *self);
// W/m^2 a channel. Allocates nothing.
void gather(Gatherer *self, const ViewPoint *from, double irradiance[3]);

// The cell in front of a point of a surface, -1 where there is none (then nothing is culled); `hint` as for vis_locate.
int gather_cell(const CellGraph *graph, Vec3 point, Vec3 normal, int hint);

#endif
