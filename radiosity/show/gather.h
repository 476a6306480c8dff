// gather.h - the light that arrives at a point, gathered from all elements of a solution that are in sight of the point (final
// gather; Reichert 1992).
#ifndef RADIOSITY_GATHER_H
#define RADIOSITY_GATHER_H

#include "radiosity/shoot/shoot.h"
#include "radiosity/show/reconstruct.h"

// How light is gathered.
typedef struct GatherOptions {
    const FormFactorMethod *method;  // gives the weight of each element's mean
    int resolution;                  // of the method, 8 .. FORM_FACTOR_FINEST
    Culling culling;
    bool exact_lamps;  // emitted light by closed form, with any method
    bool reflected;    // all but the light straight from lamps and the sun
    bool sky_parts;    // rows tell GatherRow.sky_part
    // Random walks that replace the radiosities of elements close to the point.
    struct {
        // An element is near within its size times this; 0: no walks, close elements count like others
        double reach;
        double error;  // walks stop at this relative standard error of all light but that of lamps in sight
        int blocks;    // the most blocks of PATH_BLOCK walks (path_walk.h)
    } near;
} GatherOptions;
// The options that `bake --probe` uses.
GatherOptions gather_default_options(void);
// The most exact options, at ten times the cost: analytic rows, and walks to close elements. The walks cost nothing in the open,
// 10 to 100 ms in corners and slits.
GatherOptions gather_exact_options(void);

// The scene whose light is gathered.
typedef struct GatherScene {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    const RadSolution *solution;
    const VertexLight *light;  // gives the slope of light in each element; NULL: elements are constant
} GatherScene;

// A gatherer finds the light at points. Only one thread at a time may use it. It lives in the arena of gatherer_new, but for the
// memory that gatherer_end frees.
typedef struct Gatherer Gatherer;
// All memory is taken here; the data that `scene` points to must outlive it.
Gatherer *gatherer_new(const GatherScene *scene, const GatherOptions *options, Arena *arena);
// For gather_apart, too: `own` is the light of the mesh with its rooms closed, by the panes `closed` (panes_between_rooms). Without slopes
// and walks.
Gatherer *gatherer_new_apart(const GatherScene *scene, const GatherOptions *options, const RadSolution *own,
                             const Panes *closed, Arena *arena);
// Frees the memory outside the arena.
void gatherer_end(Gatherer *self);
// To be called when the mesh was posed anew (mesh_pose), by a gatherer of rows.
void gatherer_pose(Gatherer *self);
// The irradiance at a point, W/m^2 a channel. Allocates nothing.
void gather(Gatherer *self, const ViewPoint *from, double irradiance[3]);
// The same, and the part of it that is there with all rooms closed: light of `own`, past none of the black panes. `inside` (or NULL) is
// the share of the view that meets backs: nearly 1 inside closed things.
void gather_apart(Gatherer *self, const ViewPoint *from, double irradiance[3], double own[3], double *inside);

// The light at a point as a sum over a solution's elements, for points whose light is looked for under one state of the lamps after the
// other. Shares are those of `gather`, panes of glass included.
typedef struct GatherRow {
    int count;
    const int *element;  // [count]
    const float *share;  // [count]
    double backs;        // the share of the view that meets backs: nearly 1 inside closed things
    double sky, ground;  // shares of the irradiances by a whole view of the sky overhead, and of the ground
    const uint64_t *doors;    // as in View
    const SkyPart *sky_part;  // [sky_part_count] whose light is `sky`; 0: not asked for
    int sky_part_count;
} GatherRow;
// Only with the options `reflected`, without walks, by a projective method, and for a scene without slopes. Both arrays live in the
// arena.
GatherRow gather_row_new(Gatherer *self, const ViewPoint *from, Arena *arena);
// The irradiance along a row, W/m^2 a channel, of the light that leaves the elements of a solution, under its day; as of `gather`, to
// rounding.
void gather_along(double (*leaving)[3], const Daylight *day, const GatherRow *row, double irradiance[3]);
// The mean light that leaves each element, W/m^2, less its emission where that is found apart.
double (*gather_leaving(const GatherScene *scene, const GatherOptions *options, Arena *arena))[3];

// The cell in front of a point of a surface, -1 where there is no cell (then nothing is culled); `hint` as for vis_locate.
int gather_cell(const CellGraph *graph, Vec3 point, Vec3 normal, int hint);

#endif
