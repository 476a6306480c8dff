// photometry.h - how a lamp sends its light by direction: a table of candela, and the side of it that one face sends.
#ifndef MAPS_PHOTOMETRY_H
#define MAPS_PHOTOMETRY_H

#include "engine/core/vec.h"

// The sides of a table: below and above the horizon.
enum { PHOTOMETRY_BELOW, PHOTOMETRY_ABOVE, PHOTOMETRY_SIDES };

// Luminous intensities of a lamp, as a photometric file has them. Angles are degrees. A direction has an angle from straight down
// (gamma, 0 to 180) and lies in a half plane about the lamp's vertical axis (the plane C, counter-clockwise from above). Between the
// angles of the table intensity is linear in both; below the first gamma and above the last there is none.
typedef struct Photometry {
    const char *name;  // of the file, for messages
    double *gamma;     // [gamma_count] ascending
    double *
        plane;  // [plane_count] ascending; the last is the first, a whole turn on. One plane: the same all round
    double *candela;  // [plane_count * gamma_count] plane by plane
    int gamma_count, plane_count;
    double size[2];                   // of the luminous opening along C0 and along C90, metres; 0: not known
    double lumens[PHOTOMETRY_SIDES];  // that the table sends to either side
    double stated;                    // lumens of the lamp by the file's own ratio of light output; 0: none
} Photometry;

// Finds the flux to either side: the integral of the table, linear as it is.
void photometry_integrate(Photometry *table);
// The intensity in a direction, cd; angles in degrees, any plane.
double photometry_candela(const Photometry *table, double gamma, double plane);
static inline double photometry_lumens(const Photometry *table) {
    return table->lumens[PHOTOMETRY_BELOW] + table->lumens[PHOTOMETRY_ABOVE];
}

// How a level face with a table sends its flux.
typedef struct LampSpread {
    const Photometry *table;
    double turn;  // of the plane C0 from +x, radians counter-clockwise from above
    int side;     // the face sends this side of the table, which is its front
} LampSpread;

// The share of the face's flux that leaves along a unit direction, 1/sr. By Lambert's cosine it would be the cosine over pi.
double spread_share(const LampSpread *spread, Vec3 along);

// The ratio of the radiance of a face along a unit direction to what it would be by Lambert's cosine: 1 where `spread` is NULL. It has no
// bound at the horizon, where the cosine is 0 and the light of the table need not be.
double spread_ratio(const LampSpread *spread, Vec3 normal, Vec3 along);

#endif
