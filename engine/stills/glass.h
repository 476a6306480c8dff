// glass.h - optics of smooth surfaces: how much light they reflect, where the rest goes, and which bodies a ray is inside.
#ifndef STILLS_GLASS_H
#define STILLS_GLASS_H

#include "engine/core/vec.h"

// The refractive index of air, and of glass whose material does not give one.
#define GLASS_AIR 1.0
#define GLASS_USUAL 1.5

static inline Vec3 glass_reflect(Vec3 direction, Vec3 normal) {
    return vec3_sub(direction, vec3_scale(normal, 2 * vec3_dot(direction, normal)));
}

// The share of unpolarised light that is reflected. `ratio` is the index beyond the surface over the index before it; `cosine` is that of
// the angle to the normal, 0 .. 1. Result 1: total reflection.
double glass_fresnel(double cosine, double ratio);
// The reflectance of a sheet between whose two faces light goes to and fro.
double glass_sheet(double cosine, double index);
// The direction of the refracted ray, unit; `normal` points to the side that the ray comes from. False: total reflection.
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
// The media beyond the surface of a body, when a ray enters or leaves it. Bodies may be left in any order; bodies beyond MEDIA_MOST are
// ignored.
Media media_enter(const Media *media, int body, double index);
Media media_leave(const Media *media, int body);

#endif
