// error_picture.c - see error_picture.h.
#include "engine/bench/light/error_picture.h"

#include <string.h>

#include "engine/core/draw.h"
#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "engine/draw/image.h"
#include "engine/lit/false_colour.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_tracer.h"
#include "radiosity/truth/path_walk.h"

// The ends of the scale, relative: a greater error looks like an error of this size.
static const double ENDS = 0.2;
// Pixels darker than this share of the mean are measured against it.
static const double DARK = 0.01;
// 4,084 walks a pixel leave a few per cent of noise. A path tracer's query takes eight times as many to know its own error.
enum { BLOCKS = 4 };
static const uint8_t NOTHING = 96;  // grey

typedef struct Pixels {
    Arena arena;
    int count, seen;          // of those seen, in order:
    int *pixel;               // [seen]
    double *shown;            // [seen] irradiance, W/m^2, the sum of the channels that are reflected
    PathPlace *place;         // [seen] of the scene
    double *truth, *scatter;  // [seen] irradiance likewise; the standard error of that
} Pixels;

typedef struct Tracing {
    const PathWorld *world;
    Pixels *pixels;
    uint64_t seed;
} Tracing;

static double shown_at(const ErrorPicture *e, const VertexLight *field, int face, Vec3 point) {
    double b[3];
    reconstruct_at(e->mesh, field, face, point, b);
    return false_colour_value(FALSE_COLOUR_IRRADIANCE, b, mesh_material(e->mesh, face));
}

static void look_through_pixels(const ErrorPicture *e, const Camera *camera, const PathScene *scene,
                                Pixels *p) {
    Arena scratch = {0};
    VertexLight field = reconstruct_light(e->mesh, e->solution, &scratch);
    p->count = camera->width * camera->height;
    p->pixel = ARENA_ARRAY(&p->arena, int, p->count);
    p->shown = ARENA_ARRAY(&p->arena, double, p->count);
    p->truth = ARENA_ARRAY(&p->arena, double, p->count);
    p->scatter = ARENA_ARRAY(&p->arena, double, p->count);
    p->place = ARENA_ARRAY(&p->arena, PathPlace, p->count);
    for (int i = 0; i < p->count; i++) {
        Vec3 along = camera_ray(camera, i % camera->width + 0.5, i / camera->width + 0.5);
        PathHit hit =
            path_scene_trace(scene, vec3_sub(camera->eye, path_scene_origin(scene)), vec3_normalize(along));
        if (hit.face < 0 || !hit.front || mesh_emits(e->mesh, hit.face)) continue;
        double shown = shown_at(e, &field, hit.face, vec3_add(hit.point, path_scene_origin(scene)));
        if (shown < 0) continue;  // no reflection in some channel: its irradiance is not shown
        p->pixel[p->seen] = i;
        p->shown[p->seen] = shown;
        p->place[p->seen++] =
            (PathPlace){path_scene_before(scene, hit.face, hit.point), e->mesh->faces[hit.face].plane.n};
    }
    arena_free(&scratch);
}

static void trace_pixel(void *context, int index, int thread) {
    (void)thread;
    const Tracing *t = context;
    double sum = 0, squares = 0;
    for (int b = 0; b < BLOCKS; b++) {
        PathNumbers numbers = path_numbers(t->seed + (uint64_t)index, b);
        double light[3] = {0, 0, 0};
        for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++) {
            double weight[3] = {1, 1, 1};
            path_walk(t->world, t->pixels->place[index], &numbers, 0, NULL, NULL, weight, light);
        }
        double mean = (light[0] + light[1] + light[2]) / PATH_BLOCK;
        sum += mean;
        squares += mean * mean;
    }
    double mean = sum / BLOCKS, variance = fmax(squares / BLOCKS - mean * mean, 0);
    t->pixels->truth[index] = mean;
    t->pixels->scatter[index] = sqrt(variance / (BLOCKS - 1));
}

static void look_and_trace(const ErrorPicture *e, const Camera *camera, Pixels *p) {
    Arena scratch = {0};
    PathWorld world = path_world(e->mesh, &e->solution->day, &scratch);
    Tracing tracing = {&world, p, e->seed};
    look_through_pixels(e, camera, world.scene, p);
    parallel_for(parallel_threads(0), p->seen, trace_pixel, &tracing);
    path_world_end(&world);
    arena_free(&scratch);
}

static void put_colour(uint8_t out[3], Rgb c) {
    out[0] = (uint8_t)lrintf(255 * c.r);
    out[1] = (uint8_t)lrintf(255 * c.g);
    out[2] = (uint8_t)lrintf(255 * c.b);
}

static void colour(const Pixels *p, uint8_t *rgb, ErrorPictureFound *found) {
    double mean = 0, squares = 0, scatter = 0;
    for (int i = 0; i < p->seen; i++) mean += p->truth[i] / p->seen;
    memset(rgb, NOTHING, (size_t)p->count * 3);
    for (int i = 0; i < p->seen; i++) {
        double scale = fmax(p->truth[i], DARK * mean), off = (p->shown[i] - p->truth[i]) / scale;
        put_colour(rgb + 3 * p->pixel[i], false_colour_signed(off / ENDS));
        squares += off * off;
        scatter += p->scatter[i] / scale * p->scatter[i] / scale;
    }
    int seen = p->seen > 0 ? p->seen : 1;
    *found = (ErrorPictureFound){100 * sqrt(squares / seen), 100 * sqrt(scatter / seen)};
}

// ---- the legend

static unsigned hex_of(Rgb c) {
    uint8_t v[3];
    put_colour(v, c);
    return (unsigned)v[0] << 16 | (unsigned)v[1] << 8 | v[2];
}

// Draws a bar from too dark to too bright, with numbers below.
static bool write_legend(const char *folder, Error *error) {
    enum { WIDTH = 480, STEPS = 80, TICKS = 4 };
    Arena arena = {0};
    SvgDrawing *svg = svg_begin(&arena, (Box){{-1.5, -0.1, 0}, {1.5, 0.1, 0}}, WIDTH);
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
                  i == 0 ? "0" : arena_format(&arena, "%s%+.0f %%", end, 100 * ENDS * x));
    }
    const char *text = svg_end(svg), *path = arena_format(&arena, "%s/light-error-scale.svg", folder);
    bool good = file_write(path, text, strlen(text), error);
    arena_free(&arena);
    return good;
}

bool error_picture(const ErrorPicture *e, const Camera *camera, const char *folder, const char *name,
                   ErrorPictureFound *found, Error *error) {
    Pixels p = {.arena = {0}};
    look_and_trace(e, camera, &p);
    uint8_t *rgb = ARENA_ARRAY(&p.arena, uint8_t, 3 * p.count);
    colour(&p, rgb, found);
    const char *path = arena_format(&p.arena, "%s/%s-error.png", folder, name);
    bool good = file_make_folder(folder, error) &&
                image_write_png(path, rgb, camera->width, camera->height, error) &&
                write_legend(folder, error);
    arena_free(&p.arena);
    return good;
}
