// glass.h - what a smooth surface does with light: how much it reflects, where the rest goes, and what a ray is inside of.
#ifndef STILLS_GLASS_H
#define STILLS_GLASS_H

#include "engine/core/vec.h"

// The index of air, and of glass where a material does not say.
#define GLASS_AIR 1.0
#define GLASS_USUAL 1.5

static inline Vec3 glass_reflect(Vec3 direction, Vec3 normal) {
    return vec3_sub(direction, vec3_scale(normal, 2 * vec3_dot(direction, normal)));
}

// The share of unpolarised light that is reflected where `ratio` is the index beyond over the one before the surface; `cosine` of
// the angle to the normal, 0 .. 1. 1: total reflection.
double glass_fresnel(double cosine, double ratio);
// The reflectance of a sheet whose two faces reflect to and fro.
double glass_sheet(double cosine, double index);
// The direction beyond, unit; `normal` on the side that the ray comes from. False: total reflection.
bool glass_refract(Vec3 direction, Vec3 normal, double ratio, Vec3 *out);

// The bodies around a ray, the innermost last.
enum { MEDIA_MOST = 16 };
typedef struct Media {
    int count;
    struct {
        int body;
        double index;
    } in[MEDIA_MOST];
} Media;

double media_index(const Media *media);
// The media beyond the surface of a body. Bodies may be left in any order; more than MEDIA_MOST are not told apart.
Media media_enter(const Media *media, int body, double index);
Media media_leave(const Media *media, int body);

#endif
