// lamp_spread.h - lamps that send their light by a candela table (LampSpread) instead of Lambert's cosine: what they send to a point, and
// the row of their patches.
//
// A part dA of such a lamp, of exitance M, has the intensity M dA s(w) along the direction w, where s is spread_share; by Lambert's cosine
// s is the cosine over pi. So the irradiance of a point is the sum of M s(w) cos / d^2 dA over the parts in sight, and the weight of a
// sample of a row is that of a diffuse row times pi s(w) over the cosine. Everything else about lamps is the same for both.
#ifndef RADIOSITY_LAMP_SPREAD_H
#define RADIOSITY_LAMP_SPREAD_H

#include "radiosity/factors/analytic.h"

// The part of a lamp in sight of the origin, piece after piece: as AnalyticSight, whose `share` times the lamp's exitance is the
// irradiance about z. The axes are those of the polygons, in the building.
typedef struct SpreadSight {
    AnalyticSight sight;
    const LampSpread *spread;
    double
        off;  // how far the light of a part may be off, a share of it: LAMP_SPREAD_OFF, or more where it is noisy anyway
    Vec3 x, y, z;
} SpreadSight;
#define LAMP_SPREAD_OFF 4e-4
static inline SpreadSight spread_sight(const LampSpread *spread, double off, Vec3 x, Vec3 y, Vec3 z) {
    return (SpreadSight){.spread = spread, .off = off, .x = x, .y = y, .z = z};
}
// Adds a piece to a SpreadSight, for analytic_visible: by parts as narrow as a step of the table where that is needed.
void spread_sight_add(void *sight, const Vec3 *polygon, int count);

// The rows of patches with a spread, by a method of their own.
typedef struct SpreadRows SpreadRows;
// `options` as for form_factor_new. All memory is taken here.
SpreadRows *spread_rows_new(const Mesh *mesh, const FormFactorOptions *options, Arena *arena);
// Frees the memory outside the arena.
void spread_rows_end(SpreadRows *self);
// The row of a patch, the mean over its elements, as each is seen by `viewer`. Valid until the next call.
const Row *spread_row(SpreadRows *self, Viewer *viewer, Culling culling, int patch);

#endif
