// still_sky.c - the sky of stills.
#include "engine/stills/still_sky.h"

#include "engine/lit/exposure.h"
#include "engine/shade/walk_shade.h"

static double smooth_step(double low, double high, double x) {
    double t = fmin(fmax((x - low) / (high - low), 0), 1);
    return t * t * (3 - 2 * t);
}

// The picture of the sky along a direction above the horizon: as Building.sky_texture says.
static void picture_at(const Building *b, Vec3 w, double texels, double out[3]) {
    const Texture *picture = &b->textures[b->sky_texture];
    double around = b->sky_start - atan2(w.y, w.x), down = 1 - 2 * asin(fmin(fmax(w.z, 0), 1)) / M_PI;
    // A picture repeats: the zenith must not be mixed with the horizon.
    double edge = fmin(fmax(texels, 1) / picture->height, 0.5);
    Texel texel = texture_read(picture, around / (2 * M_PI), fmin(fmax(down, edge), 1 - edge), texels);
    rgb_doubles(texel.colour, out);
}

// How bright level ground is under the picture, which has colours up to 1: rings of the sky, weighted by the cosine to the zenith.
static double brightness(const Building *b) {
    enum { RINGS = 24, AROUND = 48 };
    double sum = 0, weights = 0;
    for (int i = 0; i < RINGS * AROUND; i++) {
        double rise = (i % RINGS + 0.5) / RINGS, angle = 2 * M_PI * ((double)(i / RINGS) + 0.5) / AROUND;
        double level = sqrt(1 - rise * rise), colour[3];
        picture_at(b, vec3(level * cos(angle), level * sin(angle), rise),
                   b->textures[b->sky_texture].width / (double)AROUND, colour);
        sum += rise * light_luminous(colour);
        weights += rise;
    }
    return sum / weights;
}

StillSky still_sky(const Building *b, const Daylight *day, double exposure, double spread) {
    StillSky sky = {.day = *day, .exposure = exposure, .outdoors = 1, .building = b};
    if (b->sky_texture == 0 || !daylight_shines(day)) return sky;
    double mean[3], bright = brightness(b);
    daylight_mean(day, mean);
    sky.scale = bright > 0 ? M_PI * light_luminous(mean) / bright : 0;
    sky.texels = spread / (2 * M_PI) * b->textures[b->sky_texture].width;
    return sky;
}

static void by_day(const StillSky *sky, Vec3 w, double out[3]) {
    double colour[3], ground[3], above = smooth_step(-DAYLIGHT_HAZE, 0, w.z);
    bool disc = w.z > 0 && rgb_sum(sky->day.beam) > 0 && vec3_dot(w, sky->day.sun) > cos(DAYLIGHT_SUN_RADIUS);
    if (!(sky->scale > 0) || disc) {
        daylight_seen(&sky->day, w, out);
        return;
    }
    picture_at(sky->building, w, sky->texels, colour);
    daylight_seen_ground(&sky->day, ground);
    for (int c = 0; c < 3; c++) out[c] = ground[c] + above * (sky->scale * colour[c] - ground[c]);
}

// By night the sky that the walkthrough draws (walk_shaders.c).
void still_sky_at(const void *context, Vec3 direction, double out[3]) {
    static const double ZENITH[3] = {WALK_NIGHT_ZENITH}, HORIZON[3] = {WALK_NIGHT_HORIZON},
                        GROUND[3] = {WALK_NIGHT_GROUND};
    const StillSky *sky = context;
    double rise = direction.z, up = 0.97 * sqrt(fmax(rise, 0)), above = smooth_step(-0.03, 0.01, rise);
    if (daylight_shines(&sky->day)) {
        by_day(sky, direction, out);
        for (int c = 0; c < 3; c++) out[c] *= sky->outdoors;
        return;
    }
    for (int c = 0; c < 3; c++) {
        double high = HORIZON[c] + up * (ZENITH[c] - HORIZON[c]);
        out[c] = (double)WALK_EXPOSURE * (GROUND[c] + above * (high - GROUND[c])) / sky->exposure;
    }
}
