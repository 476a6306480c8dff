// light_errors.c - a ray through each pixel, the irradiance shown where it meets a surface, and the one that random walks find there.
#include "engine/app/light_errors.h"

#include <stdio.h>

#include "engine/core/draw.h"
#include "engine/walk/false_colour.h"
#include "engine/walk/image.h"
#include "radiosity/path_scene.h"
#include "radiosity/path_tracer.h"
#include "radiosity/reconstruct.h"

// Ends of the scale, relative: what is farther off looks as if it were so far.
static const double ENDS = 0.2;
// Pixels with less light than this share of the mean of all are measured against it.
static const double DARK = 0.01;
// Where it is hardly lit paths are many: a pixel stays as uncertain as it is then.
static const long long MOST_PATHS = 5000;
static const uint8_t NOTHING = 96;  // grey

typedef struct Pixels {
    Arena arena;
    int count, seen;   // of those seen, in order:
    int *pixel;        // [seen]
    double *shown;     // [seen] irradiance, W/m^2, the sum of the channels that are reflected
    PathQuery *query;  // [seen]
    PathResult *truth;
} Pixels;

static double shown_at(const LightErrors *e, const VertexLight *field, int face, Vec3 point) {
    double b[3];
    reconstruct_at(e->mesh, field, face, point, b);
    return false_colour_value(FALSE_COLOUR_IRRADIANCE, b, mesh_material(e->mesh, face));
}

static void look(const LightErrors *e, const Camera *camera, Pixels *p) {
    Arena scratch = {0};
    PathScene *scene = path_scene_new(e->mesh, &scratch);
    VertexLight field = reconstruct_light(e->mesh, e->solution, &scratch);
    p->count = camera->width * camera->height;
    p->pixel = ARENA_ARRAY(&p->arena, int, p->count);
    p->shown = ARENA_ARRAY(&p->arena, double, p->count);
    p->query = ARENA_ARRAY(&p->arena, PathQuery, p->count);
    p->truth = ARENA_ARRAY(&p->arena, PathResult, p->count);
    for (int i = 0; i < p->count; i++) {
        Vec3 along = camera_ray(camera, i % camera->width + 0.5, i / camera->width + 0.5);
        PathHit hit = path_scene_trace(scene, vec3_sub(camera->eye, scene->origin), vec3_normalize(along));
        if (hit.face < 0 || !hit.front || mesh_emits(e->mesh, hit.face)) continue;
        Vec3 at = vec3_add(hit.point, scene->origin), n = e->mesh->faces[hit.face].plane.n;
        double shown = shown_at(e, &field, hit.face, at);
        if (shown < 0) continue;  // reflects nothing in some channel: what arrives there is not shown
        p->pixel[p->seen] = i;
        p->shown[p->seen] = shown;
        p->query[p->seen++] = (PathQuery){at, n, e->error, 0, MOST_PATHS, e->seed + (uint64_t)i};
    }
    path_scene_end(scene);
    arena_free(&scratch);
}

static void trace(const LightErrors *e, Pixels *p) {
    Arena scratch = {0};
    PathTracer *tracer = path_tracer_new(e->mesh, e->solution->sky, &scratch);
    path_tracer_irradiance(tracer, p->query, p->seen, 0, p->truth);
    path_tracer_end(tracer);
    arena_free(&scratch);
}

static double truth_of(const Pixels *p, int i) {
    const double *h = p->truth[i].irradiance;
    return h[0] + h[1] + h[2];
}

static void put(uint8_t out[3], Rgb c) {
    out[0] = (uint8_t)lrintf(255 * c.r);
    out[1] = (uint8_t)lrintf(255 * c.g);
    out[2] = (uint8_t)lrintf(255 * c.b);
}

// The picture's pixels; returns the root of the mean square of the errors, in percent.
static double colour(const Pixels *p, uint8_t *rgb) {
    double mean = 0, squares = 0;
    for (int i = 0; i < p->seen; i++) mean += truth_of(p, i) / p->seen;
    memset(rgb, NOTHING, (size_t)p->count * 3);
    for (int i = 0; i < p->seen; i++) {
        double off = (p->shown[i] - truth_of(p, i)) / fmax(truth_of(p, i), DARK * mean);
        put(rgb + 3 * p->pixel[i], false_colour_signed(off / ENDS));
        squares += off * off;
    }
    return p->seen > 0 ? 100 * sqrt(squares / p->seen) : 0;
}

// ---- the legend

static unsigned hex_of(Rgb c) {
    uint8_t v[3];
    put(v, c);
    return (unsigned)v[0] << 16 | (unsigned)v[1] << 8 | v[2];
}

// A bar from what is too dark to what is too bright, its numbers below; twelve times as wide as high.
static bool write_legend(const char *folder, int width, Error *error) {
    enum { STEPS = 80, TICKS = 4 };
    Arena arena = {0};
    SvgDrawing *svg = svg_begin(&arena, (Box){{-1.2, -0.1, 0}, {1.2, 0.1, 0}}, width);
    Draw draw = svg_draw(svg);
    for (int i = 0; i < STEPS; i++) {
        double x = -1 + 2.0 * i / STEPS, next = x + 2.0 / STEPS;
        DrawStyle fill = {.fill = hex_of(false_colour_signed((x + next) / 2)), .fill_opacity = 1};
        Vec2 v[4] = {{x, 0}, {next, 0}, {next, 0.08}, {x, 0.08}};
        draw.polygon(draw.context, v, 4, &fill);
    }
    for (int i = -TICKS; i <= TICKS; i += 2) {
        double x = (double)i / TICKS;
        const char *end = i == -TICKS ? "too dark " : i == TICKS ? "too bright " : "";
        draw.text(draw.context, (Vec2){x, -0.05}, 0.06, 0,
                  arena_format(&arena, "%s%+.0f %%", end, 100 * ENDS * x));
    }
    const char *text = svg_end(svg), *path = arena_format(&arena, "%s/light-error-scale.svg", folder);
    bool good = file_write(path, text, strlen(text), error);
    arena_free(&arena);
    return good;
}

bool light_errors_picture(const LightErrors *e, const Camera *camera, const char *folder, const char *name,
                          double *rms, Error *error) {
    Pixels p = {.arena = {0}};
    look(e, camera, &p);
    trace(e, &p);
    uint8_t *rgb = ARENA_ARRAY(&p.arena, uint8_t, 3 * p.count);
    *rms = colour(&p, rgb);
    const char *path = arena_format(&p.arena, "%s/%s-error.png", folder, name);
    bool good = file_make_folder(folder, error) &&
                image_write_png(path, rgb, camera->width, camera->height, error) &&
                write_legend(folder, camera->width, error);
    arena_free(&p.arena);
    return good;
}
