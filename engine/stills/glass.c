// glass.c - Fresnel's formulae and Snell's law, and glass within glass as a stack.
#include "engine/stills/glass.h"

#include "engine/core/fresnel.h"

double glass_fresnel(double cosine, double ratio) {
    double share[2];
    fresnel_shares(cosine, ratio, share);
    return 0.5 * (share[0] + share[1]);
}

// The sum over all reflections inside the sheet: F + F (1 - F)^2 (1 + F^2 + F^4 ...).
double glass_sheet(double cosine, double index) {
    double once = glass_fresnel(cosine, index);
    return 2 * once / (1 + once);
}

bool glass_refract(Vec3 d, Vec3 n, double ratio, Vec3 *out) {
    double cosine = -vec3_dot(d, n), beyond2 = 1 - (1 - cosine * cosine) / (ratio * ratio);
    if (beyond2 <= 0) return false;
    Vec3 along = vec3_scale(vec3_add(d, vec3_scale(n, cosine)), 1 / ratio);
    *out = vec3_normalize(vec3_sub(along, vec3_scale(n, sqrt(beyond2))));
    return true;
}

double media_index(const Media *media) {
    return media->count > 0 ? media->in[media->count - 1].index : GLASS_AIR;
}

Media media_enter(const Media *media, int body, double index) {
    Media out = *media;
    if (out.count == MEDIA_MOST) return out;
    out.in[out.count].body = body;
    out.in[out.count++].index = index;
    return out;
}

Media media_leave(const Media *media, int body) {
    Media out = *media;
    int i = out.count - 1;
    while (i >= 0 && out.in[i].body != body) i--;
    if (i < 0) return out;
    for (out.count--; i < out.count; i++) out.in[i] = out.in[i + 1];
    return out;
}
