// whitted.c - each surface sends on a reflected and a refracted ray, as far as it is mirror or glass (Whitted 1980,
// An Improved Illumination Model for Shaded Display). A ray is followed no further for one of four reasons: its surface is neither
// mirror nor glass; it meets nothing; its light would be below a threshold; its chain of rays is too long.
//
// Departures: for the last two reasons no light is lost. Where a ray parts in two and one part counts too little, that part leaves its
// share to the other; a ray that is not followed brings the mean light of the building. Thus a surface as bright as everything around it
// cannot be seen, and the end of a tunnel of two mirrors is not dark.
#include "engine/stills/whitted.h"

typedef struct Trace {
    const Whitted *w;
    uint64_t seed;
    int sample, visits;  // visits: surfaces lit so far
    WhittedWork *work;
} Trace;

typedef struct Path {
    Ray ray;
    Media media;
    double way;     // from the eye to the ray's origin, along the rays before, metres
    double weight;  // the most that it counts in the pixel, in any channel
    int depth;
} Path;

static void follow_ray(Trace *t, const Path *path, double out[3]);

static double most_of(Rgb c) { return (double)fmaxf(c.r, fmaxf(c.g, c.b)); }

// At each surface a sample continues the pixel's sequence where the sample before ended: one number a shadow ray, and one more.
static StillNumbers numbers_of(Trace *t, int rays) {
    Random random = {t->seed ^ (uint64_t)t->visits++ * 0x9e3779b97f4a7c15u};
    StillNumbers numbers = {.next = t->sample * (rays + 1)};
    for (int i = 0; i < 3; i++) numbers.shift[i] = random_unit(&random);
    return numbers;
}

// The width on a surface, metres, of what the ray stands for: mirrors and glass count as even. Where the ray grazes the surface the
// width along it is bounded, so that the width across is not averaged over too much.
static double width_of(const Trace *t, const Path *path, const SurfaceHit *hit) {
    static const double LEAST_COSINE = 0.125;
    double cosine = fabs(vec3_dot(path->ray.direction, hit->at.normal));
    return t->w->spread * (path->way + hit->at.t) / fmax(cosine, LEAST_COSINE);
}

// ---- glass

// The factor of the light that passes a surface: its opaque share gives the light the surface's colour.
static Rgb tint_of(Texel texel) {
    float clear = 1 - texel.opacity;
    return (Rgb){clear + texel.opacity * texel.colour.r, clear + texel.opacity * texel.colour.g,
                 clear + texel.opacity * texel.colour.b};
}

// The passage through a surface: how much light it reflects, and where the rest goes.
typedef struct Passage {
    double reflected;
    Vec3 through;
    Media beyond;
    Rgb tint;
} Passage;

static const Rgb CLEAR = {1, 1, 1};

// The passage into or out of a body that refracts.
static Passage refract(const Path *path, const StillSurface *s, Rgb tint, bool front, Vec3 normal) {
    double index = (double)s->material->index;
    Passage p = {.beyond =
                     front ? media_enter(&path->media, s->body, index) : media_leave(&path->media, s->body),
                 .tint = front ? tint : CLEAR};
    // A ray that leaves a body which it never entered counts as inside the body all the same.
    double here = front ? media_index(&path->media) : index, beyond = front ? index : media_index(&p.beyond);
    double cosine = fmin(-vec3_dot(path->ray.direction, normal), 1);
    p.reflected = glass_fresnel(cosine, beyond / here);
    if (!glass_refract(path->ray.direction, normal, beyond / here, &p.through)) p.reflected = 1;
    return p;
}

// The passage straight through thin glass. A closed body has a second face, which reflects by itself.
static Passage pass(const Path *path, const StillSurface *s, Rgb tint, bool front, Vec3 normal) {
    double index = s->material->index > 0 ? (double)s->material->index : GLASS_USUAL;
    double cosine = fmin(-vec3_dot(path->ray.direction, normal), 1);
    bool closed = s->body >= 0;
    return (Passage){.reflected = closed ? glass_fresnel(cosine, index) : glass_sheet(cosine, index),
                     .through = path->ray.direction,
                     .beyond = path->media,
                     .tint = front || !closed ? tint : CLEAR};
}

static void add_light(double out[3], const double light[3], double share, Rgb tint) {
    out[0] += share * (double)tint.r * light[0];
    out[1] += share * (double)tint.g * light[1];
    out[2] += share * (double)tint.b * light[2];
}

// `at` lies on the ray.
static void go_on(Trace *t, const Path *path, Vec3 at, Vec3 direction, const Media *media, double share,
                  Rgb tint, double out[3]) {
    Path next = {.ray = still_ray(at, direction),
                 .media = *media,
                 .way = path->way + vec3_length(vec3_sub(at, path->ray.origin)),
                 .weight = path->weight * share * most_of(tint),
                 .depth = path->depth + 1};
    double light[3];
    follow_ray(t, &next, light);
    add_light(out, light, share, tint);
}

// The share of the first of two rays; a ray that counts too little leaves its share to the other.
static double without_faint(Trace *t, double weight, double share) {
    double least = t->w->threshold / weight;
    bool none = share > 0 && share < least, all = share < 1 && 1 - share < least;
    t->work->faint += none || all;
    return none ? 0 : all ? 1 : share;
}

// A sheet with a picture: a leaf of a plant, a fence. Where the picture is opaque the sheet is matt, in the building's mean light, since
// no light is found on what is seen through; the rest passes as through air.
static void see_cut_out(Trace *t, const Path *path, const Material *m, Texel texel, Vec3 at, double out[3]) {
    double passes = without_faint(t, path->weight, fmax(1 - (double)texel.opacity, 0)), emitted[3];
    rgb_doubles(m->emission, emitted);
    add_light(out, t->w->light->mean, 1 - passes, texel.colour);
    add_light(out, emitted, 1 - passes, CLEAR);
    if (passes > 0) go_on(t, path, at, path->ray.direction, &path->media, passes, CLEAR, out);
}

static void see_through(Trace *t, const Path *path, const StillSurface *s, const SurfaceHit *hit,
                        double out[3]) {
    Vec3 at = still_ray_at(&path->ray, hit->at.t), n = vec3_scale(hit->at.normal, hit->front ? 1 : -1);
    Texel texel = still_texel(t->w->scene, s, at, width_of(t, path, hit));
    if (s->material->texture > 0 && s->material->index == 0) {
        see_cut_out(t, path, s->material, texel, at, out);
        return;
    }
    bool refracts = s->body >= 0 && s->material->index > 0;
    Rgb tint = tint_of(texel);
    Passage p = refracts ? refract(path, s, tint, hit->front, n) : pass(path, s, tint, hit->front, n);
    double reflected = p.reflected + (1 - p.reflected) * (double)s->material->mirror;
    reflected = without_faint(t, path->weight, reflected);
    if (reflected > 0)
        go_on(t, path, at, glass_reflect(path->ray.direction, n), &path->media, reflected, CLEAR, out);
    if (reflected < 1) go_on(t, path, at, p.through, &p.beyond, 1 - reflected, p.tint, out);
}

// ---- opaque surfaces

// A mirror reflects besides the light that it scatters. A material with an index is glazed, one with gloss in part:
// light that the glaze reflects does not reach the layer below.
static double glaze_of(const Material *m, double cosine) {
    if (m->index > 0) return glass_fresnel(cosine, (double)m->index);
    return m->gloss > 0 ? (double)m->gloss * glass_fresnel(cosine, GLASS_USUAL) : 0;
}

static void see(Trace *t, const Path *path, const StillSurface *s, const SurfaceHit *hit, double out[3]) {
    const Material *m = s->material;
    double cosine = fmin(-vec3_dot(path->ray.direction, hit->at.normal), 1);
    double glaze = hit->front ? glaze_of(m, cosine) : 0;
    double mirrored = hit->front ? glaze + (1 - glaze) * (double)m->mirror : 0, lit[3];
    int rays = (int)ceil(t->w->lamp_rays * path->weight * (1 - glaze));
    StillNumbers numbers = numbers_of(t, rays);
    still_light_at(t->w->light, &path->ray, hit, width_of(t, path, hit), rays, &numbers, lit);
    add_light(out, lit, 1 - glaze, CLEAR);
    if (mirrored > 0) {
        Vec3 at = still_ray_at(&path->ray, hit->at.t);
        Vec3 along = glass_reflect(path->ray.direction, hit->at.normal);
        go_on(t, path, at, along, &path->media, mirrored, CLEAR, out);
    } else {
        t->work->matt++;
    }
}

static void follow_ray(Trace *t, const Path *path, double out[3]) {
    out[0] = out[1] = out[2] = 0;
    bool faint = path->weight < t->w->threshold;
    if (faint || path->depth >= t->w->depth) {
        ++*(faint ? &t->work->faint : &t->work->deep);
        add_light(out, t->w->light->mean, 1, CLEAR);
        return;
    }
    SurfaceHit hit = still_rays_first(t->w->scene->all, &path->ray);
    t->work->rays++;
    if (hit.item < 0) {
        t->work->escaped++;
        if (t->w->sky) t->w->sky(t->w->sky_context, path->ray.direction, out);
        return;
    }
    const StillSurface *s = &t->w->scene->surfaces[hit.item];
    if (s->material->alpha < 1)
        see_through(t, path, s, &hit, out);
    else
        see(t, path, s, &hit, out);
}

void whitted_trace(const Whitted *w, const Ray *ray, const Media *media, uint64_t seed, int sample,
                   WhittedWork *work, double out[3]) {
    Trace t = {w, seed, sample, 0, work};
    Path path = {.ray = *ray, .media = *media, .weight = 1};
    follow_ray(&t, &path, out);
}
