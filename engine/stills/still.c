// still.c - draws pixels: each is the mean of stratified samples, exposed as in the walkthrough.
#include "engine/stills/still.h"

#include <stdatomic.h>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/draw/view.h"
#include "engine/shade/walk_shade.h"
#include "engine/stills/still_sky.h"

const char *const STILL_DIRECT_NAMES[STILL_DIRECTS] = {"baked", "rays"};

// A ray whose weight in its pixel is less than this is not followed: half a step of a screen's 255.
static const double THRESHOLD = 1.0 / 512;
// Shadow rays of each sample.
enum { LAMP_RAYS = 2 };
// The side of a tile, pixels; a thread takes one tile at a time.
enum { TILE = 16 };

StillOptions still_default_options(void) {
    return (StillOptions){.samples = 16, .depth = 12, .direct = STILL_RAYS};
}

typedef struct Tile {
    WhittedWork work;
} Tile;

typedef struct Still {
    const Camera *camera;
    const StillOptions *options;
    const Progress *progress;
    StillScene *scene;
    StillLight light;
    Whitted whitted;
    StillSky sky;
    Media media;
    double exposure;
    uint8_t *rgb;
    Tile *tiles;
    int columns, rows;
    atomic_int done;
    atomic_bool stopped;
} Still;

// ---- on the screen

// A channel on the screen, 0 .. 255, for light times exposure.
static uint8_t tone(double light) { return (uint8_t)lrint(255 * exposure_on_screen(light)); }

// ---- exposure

static double expose(const StabForest *forest, const WalkLight *baked, const Camera *camera, double stops) {
    const Mesh *mesh = baked->mesh;
    Arena scratch = {0};
    LitMesh *lit = lit_mesh_new(mesh, &scratch, &scratch);
    LitLight light = lit_light_new(lit, &scratch);
    lit_light_fill(lit, baked->solution, NULL, &light);
    VisQuery *query = vis_query_new(mesh->graph, forest, &scratch);
    Eye eye = walk_eye(camera);
    VisResult seen =
        vis_query(query, &eye, vis_locate(mesh->graph, camera->eye, -1), baked->door_open, CULL_STAB);
    Exposure exposure = {.stops = stops};
    exposure_adapt(&exposure, exposure_meter(lit, &light, camera, seen.objects, seen.object_count),
                   light.level, 0);
    arena_free(&scratch);
    return exposure_scale(&exposure);
}

// ---- pixels

// The bits of i in reverse order, as a fraction of 1 (van der Corput 1935).
static double radical_inverse(unsigned i) {
    i = __builtin_bswap32(i);
    i = (i & 0x0f0f0f0fu) << 4 | (i & 0xf0f0f0f0u) >> 4;
    i = (i & 0x33333333u) << 2 | (i & 0xccccccccu) >> 2;
    i = (i & 0x55555555u) << 1 | (i & 0xaaaaaaaau) >> 1;
    return i * 0x1p-32;
}

// Samples are Hammersley's points, shifted for each pixel by another vector (Cranley & Patterson 1976).
static void draw_pixel(const Still *s, int x, int y, WhittedWork *work) {
    Random random = {(uint64_t)y << 32 | (uint64_t)x};
    double shift[2] = {random_unit(&random), random_unit(&random)}, sum[3] = {0};
    uint64_t seed = random_next(&random);
    int samples = s->options->samples;
    for (int i = 0; i < samples; i++) {
        double u = (i + shift[0]) / samples, v = radical_inverse((unsigned)i) + shift[1];
        Vec3 way = vec3_normalize(camera_ray(s->camera, x + u, y + (v - floor(v))));
        Ray ray = {s->camera->eye, way, 0, INFINITY};
        double light[3];
        whitted_trace(&s->whitted, &ray, &s->media, seed, i, work, light);
        // A sample is cut off at white: otherwise a lamp's edge would have steps.
        for (int c = 0; c < 3; c++) sum[c] += fmin(light[c] * s->exposure, WALK_WHITE);
    }
    for (int c = 0; c < 3; c++) s->rgb[3 * (y * s->camera->width + x) + c] = tone(sum[c] / samples);
}

static void draw_tile(void *context, int index, int thread) {
    Still *s = context;
    int width = s->camera->width, height = s->camera->height;
    int x0 = index % s->columns * TILE, y0 = index / s->columns * TILE;
    if (atomic_load(&s->stopped)) return;
    for (int y = y0; y < y0 + TILE && y < height; y++)
        for (int x = x0; x < x0 + TILE && x < width; x++) draw_pixel(s, x, y, &s->tiles[index].work);
    int done = atomic_fetch_add(&s->done, 1) + 1;
    if (thread == 0 && !progress_report(s->progress, "still", (double)done / (s->columns * s->rows)))
        atomic_store(&s->stopped, true);
}

// Between the rays through neighbouring pixels in the middle, radians.
static double pixel_angle(const Camera *camera) {
    double x = 0.5 * camera->width, y = 0.5 * camera->height;
    return vec3_length(vec3_sub(camera_ray(camera, x + 1, y), camera_ray(camera, x, y)));
}

static void prepare_still(Still *s, const StabForest *forest, const WalkLight *baked, StillReport *report,
                          Arena *arena) {
    bool rays = s->options->direct == STILL_RAYS;
    s->scene = still_scene_new(baked->mesh, baked->door_open, s->options->tree, arena);
    StillLamps *lamps = rays ? still_lamps_new(s->scene, forest, s->options->samples, arena) : NULL;
    s->light = still_light_new(s->scene, baked->solution, lamps, arena);
    s->exposure = expose(forest, baked, s->camera, s->options->stops);
    double spread = pixel_angle(s->camera) / sqrt(s->options->samples);
    s->sky = still_sky(baked->mesh->graph->building, &baked->solution->day, s->exposure, spread);
    s->light.outdoors = s->sky.outdoors = exposure_outdoors(s->exposure, &baked->solution->day) / s->exposure;
    s->media = still_scene_media(s->scene, s->camera->eye);
    s->whitted = (Whitted){.scene = s->scene,
                           .light = &s->light,
                           .depth = s->options->depth,
                           .threshold = THRESHOLD,
                           .spread = spread,
                           .lamp_rays = LAMP_RAYS,
                           .sky = still_sky_at,
                           .sky_context = &s->sky};
    report->exposure = s->exposure;
    report->lamps = lamps ? still_lamps_count(lamps) : 0;
}

static void add_work(WhittedWork *sum, const WhittedWork *work) {
    sum->rays += work->rays;
    sum->matt += work->matt;
    sum->escaped += work->escaped;
    sum->faint += work->faint;
    sum->deep += work->deep;
}

bool still_draw(const StabForest *forest, const WalkLight *baked, const Camera *camera,
                const StillOptions *options, const Progress *progress, uint8_t *rgb, StillReport *report) {
    Arena arena = {0};
    Still s = {.camera = camera,
               .options = options,
               .progress = progress,
               .rgb = rgb,
               .columns = (camera->width + TILE - 1) / TILE,
               .rows = (camera->height + TILE - 1) / TILE};
    double start = clock_seconds();
    *report = (StillReport){0};
    prepare_still(&s, forest, baked, report, &arena);
    report->seconds_scene = clock_seconds() - start;
    s.tiles = ARENA_ARRAY(&arena, Tile, s.columns * s.rows);
    start = clock_seconds();
    parallel_for(parallel_threads(options->threads), s.columns * s.rows, draw_tile, &s);
    report->seconds = clock_seconds() - start;
    for (int i = 0; i < s.columns * s.rows; i++) add_work(&report->work, &s.tiles[i].work);
    if (s.light.lamps) still_lamps_end(s.light.lamps);
    arena_free(&arena);
    return !atomic_load(&s.stopped);
}
