// walk_offscreen.c - runs a tour frame by frame: locates the eye, asks what is visible, draws and writes.
#include "engine/walk/walk_offscreen.h"

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/random.h"
#include "engine/core/text.h"
#include "engine/draw/image.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/hud.h"
#include "engine/sim/recording.h"
#include "engine/walk/verify.h"
#include "engine/walk/video.h"
#include "visibility/hidden/hidden.h"

// Frames of a tour in a second of video, unless the options say otherwise.
enum { USUAL_RATE = 12, FILM_RATE = 24 };

WalkOptions walk_default_options(void) {
    return (WalkOptions){.tour = "auto",
                         .width = 960,
                         .height = 540,
                         .every = 1,
                         .seed = 1,
                         .doors = WALK_DOORS,
                         .culling = CULL_STAB,
                         .look = WALK_FINE,
                         .path = tour_default_options()};
}

// The figures of one frame, which was drawn in a look or verified.
typedef struct Frame {
    VisResult visible;
    double light_seconds;  // until its light was there
    double query_seconds, draw_seconds;
    int mismatched_pixels, missing_polygons, missing, raycast_missing;
    int mirrors, mirror_pixels;
    double one_polygon;  // see film_figures_view; 0 unless verified
} Frame;

typedef struct Walk {
    const CellGraph *graph;
    const StabForest *forest;
    const WalkOptions *options;
    Arena *arena;
    WalkTotals *totals;
    VisQuery *query;
    Mirrors *mirrors;        // or NULL
    GlContext *context;      // of the renderer
    WalkRenderer *renderer;  // NULL when verifying
    FilmLight *light;        // or NULL
    Overlay *overlay;        // for a legend, or NULL
    Exposure exposure;
    int rate;            // frames a second
    WalkVerify *verify;  // or NULL
    Video *video;
    uint8_t *rgb;
    float *door_open;
    Recording *replay;  // or NULL
    Text stats;
    int cell, planned;  // planned: frames and random views to be verified
    Arena rays;
} Walk;

static void add_to_totals(Walk *w, int index, const char *kind, const Camera *camera, const Frame *f) {
    WalkTotals *t = w->totals;
    t->mismatched_pixels += f->mismatched_pixels;
    t->missing_polygons += f->missing_polygons;
    t->raycast_missing += f->raycast_missing;
    t->mirrors += f->mirrors;
    t->mirror_pixels += f->mirror_pixels;
    if (f->mismatched_pixels == 0 && f->missing_polygons == 0 && f->raycast_missing == 0) return;
    t->bad_frames++;
    if (t->first_fault) return;
    t->first_fault =
        arena_format(w->arena,
                     "%s %d, eye %.9g,%.9g,%.9g in cell %d, looking along %.4f,%.4f,%.4f: %d pixels differ, "
                     "%d polygons are missing (one is %d), rays find %d",
                     kind, index, camera->eye.x, camera->eye.y, camera->eye.z, f->visible.eye_cell,
                     camera->forward.x, camera->forward.y, camera->forward.z, f->mismatched_pixels,
                     f->missing_polygons, f->missing, f->raycast_missing);
}

static void add_to_means(Walk *w, int index, const TourFrame *at, bool cut, const Frame *f) {
    WalkTotals *t = w->totals;
    const VisResult *v = &f->visible;
    t->polygons_drawn_mean += v->polygon_count;
    t->cells_visible_mean += v->cell_count;
    t->objects_mean += v->object_count;
    t->query_us_mean += 1e6 * f->query_seconds;
    t->query_us_max = fmax(t->query_us_max, 1e6 * f->query_seconds);
    t->frame_ms_mean += 1e3 * (f->query_seconds + f->draw_seconds);
    t->portals_tested_mean += v->portals_tested;
    t->objects_tested_mean += v->objects_tested;
    if (!w->options->stats) return;
    text_append(&w->stats, "%d,%.4f,%.4f,%.4f,%.5f,%.5f,%d,%d,%d,%d,%d,%.2f,%.3f,%d,%d,%d,%.3f,%.3f\n", index,
                at->eye.x, at->eye.y, at->eye.z, at->yaw, at->pitch, w->cell, v->cell_count, v->object_count,
                v->polygon_count, w->graph->polygon_count, 1e6 * f->query_seconds,
                1e3 * (f->query_seconds + f->draw_seconds), f->mismatched_pixels, f->missing_polygons, cut,
                f->one_polygon, 1e3 * f->light_seconds);
}

static void divide_means(WalkTotals *t) {
    double *means[] = {&t->polygons_drawn_mean, &t->cells_visible_mean, &t->objects_mean,
                       &t->query_us_mean,       &t->frame_ms_mean,      &t->portals_tested_mean,
                       &t->objects_tested_mean};
    for (size_t i = 0; i < sizeof means / sizeof *means; i++) *means[i] /= t->frames > 0 ? t->frames : 1;
}

// ---- frames

// Compares the polygons that rays see through each pixel with the draw list.
static bool compare_rays(Walk *w, const Camera *camera, const float *door_open, Frame *out, Error *error) {
    const CellGraph *graph = w->graph;
    arena_reset(&w->rays);
    int *list = ARENA_ARRAY(&w->rays, int, graph->polygon_count + 1);
    Scene scene = {graph->polygons, walk_verify_vertices(w->verify), list,
                   walk_opaque_polygons(graph, door_open, &camera->eye, list)};
    ItemBuffer items = item_buffer_new(&w->rays, camera->width, camera->height);
    const HiddenMethod *rays = hidden_find("raycast");
    void *prepared = rays->begin(&scene, &w->rays, error);
    if (!prepared || !hidden_draw(rays, prepared, camera, &items, NULL, error)) return false;
    out->raycast_missing = walk_verify_missing(w->verify, &items, &out->missing);
    w->totals->raycast_frames++;
    return true;
}

static bool verify_frame(Walk *w, const Camera *camera, int cell, const float *door_open, Frame *out,
                         Error *error) {
    VerifyFrame v;
    if (!walk_verify_frame(w->verify, camera, cell, door_open, w->options->culling, &v, error)) return false;
    *out = (Frame){.visible = v.visible,
                   .query_seconds = v.query_seconds,
                   .draw_seconds = v.draw_seconds,
                   .mismatched_pixels = v.mismatched_pixels,
                   .missing_polygons = v.missing_polygons,
                   .missing = v.missing,
                   .mirrors = v.mirrors,
                   .mirror_pixels = v.mirror_pixels};
    long done = w->totals->frames + w->totals->random_frames, rays = w->options->raycast;
    // A frame is chosen each time the line through (0, 0) and (planned, rays) passes a whole number.
    bool chosen = done * rays / w->planned != (done + 1) * rays / w->planned;
    return !chosen || compare_rays(w, camera, door_open, out, error);
}

// The eye adapts by the time of the film, not of the clock, so that the same frames come out every time.
static void expose(Walk *w, const Camera *camera, const VisResult *visible) {
    const LitLight *light = walk_renderer_lit(w->renderer);
    if (!light) return;
    double seen = exposure_meter(walk_renderer_mesh(w->renderer), light, camera, visible->objects,
                                 visible->object_count);
    exposure_adapt(&w->exposure, seen, light->level, 1.0 / w->rate);
    walk_renderer_tone(w->renderer, exposure_scale(&w->exposure), w->options->false_colour);
}

static bool draw_legend(Walk *w, Error *error) {
    if (!w->overlay || !walk_renderer_lit(w->renderer)) return true;
    FalseColour quantity = w->options->false_colour;
    HudLegend legend = {quantity, walk_renderer_lit(w->renderer)->ranges[quantity]};
    Arena scratch = {0};
    HudState state = {.legend = &legend, .scratch = &scratch};
    overlay_begin(w->overlay, w->options->width, w->options->height, 1);
    hud_draw(w->overlay, &state);
    arena_free(&scratch);
    return overlay_end(w->overlay, error);
}

static bool draw_frame(Walk *w, const Camera *camera, Frame *out, Error *error) {
    Eye eye = walk_eye(camera);
    double start = clock_seconds();
    *out = (Frame){.visible = vis_query(w->query, &eye, w->cell, w->door_open, w->options->culling),
                   .missing = -1};
    double asked = clock_seconds();
    walk_renderer_pose(w->renderer, w->door_open);
    const MirrorView *mirrors;
    int mirror_count =
        mirrors_look(w->mirrors, camera, &out->visible, w->door_open, w->options->culling, &mirrors);
    walk_renderer_mirrors(w->renderer, mirrors, mirror_count);
    expose(w, camera, &out->visible);
    // Where stored light has no part about the eye, as outside all cells, there is the fast look.
    WalkLook look = w->light && !film_light_covers(w->light, w->cell) ? WALK_FAST : w->options->look;
    if (!walk_renderer_draw(w->renderer, camera, out->visible.objects, out->visible.object_count, look,
                            error) ||
        !walk_renderer_finish_scene(w->renderer, error) || !draw_legend(w, error)) {
        return false;
    }
    walk_renderer_finish();
    out->query_seconds = asked - start;
    out->draw_seconds = clock_seconds() - asked;
    walk_renderer_ahead(w->renderer, w->forest, w->cell);
    return true;
}

static bool is_written(const Walk *w, int index) {
    return index % w->options->every == 0 && (w->options->folder || w->video);
}

static bool write_frame(Walk *w, int index, Error *error) {
    const WalkOptions *o = w->options;
    if (!is_written(w, index)) return true;
    if (w->verify) {
        walk_verify_image(w->verify, w->rgb);
    } else if (!walk_renderer_read(w->renderer, w->rgb, error)) {
        return false;
    }
    if (w->video && !video_add(w->video, w->rgb, error)) return false;
    if (!o->folder) return true;
    Arena scratch = {0};
    const char *path = arena_format(&scratch, "%s/frame-%05d.png", o->folder, w->totals->images);
    bool good = image_write_png(path, w->rgb, o->width, o->height, error);
    arena_free(&scratch);
    w->totals->images += good;
    return good;
}

// The day of a frame, NULL: that of the light.
static const Daylight *hour_of(const WalkOptions *o, int frame, int frames) {
    return o->hour_count > 0 ? &o->hours[(long long)frame * o->hour_count / frames] : NULL;
}

static bool run_tour(Walk *w, const TourPath *path, const Progress *progress, Error *error) {
    const WalkOptions *o = w->options;
    text_append(
        &w->stats,
        "frame,x,y,z,yaw,pitch,cell,cells_visible,objects,polygons_drawn,polygons_total,query_us,frame_ms,"
        "mismatched_pixels,missing_polygons,cut,one_polygon,light_ms\n");
    for (int i = 0; i < path->frame_count; i++) {
        const TourFrame *at = &path->frames[i];
        Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, o->width, o->height);
        w->cell = vis_locate(w->graph, at->eye, w->cell);
        bool cut = tour_is_cut(path, i);
        if (w->replay) recording_doors(w->replay, i, w->door_open);
        if (path->is_film && o->doors == WALK_DOORS) tour_doors(path, i, w->rate, w->door_open);
        Frame frame;
        double start = clock_seconds();
        // Frames that are timed have the light that is stored, those that are written that of doors and hours, too.
        if (w->light && (is_written(w, i) || o->stats) && !film_light_come(w->light, w->cell, error))
            return false;
        if (w->light && is_written(w, i) &&
            !film_light_follow(w->light, w->door_open, hour_of(o, i, path->frame_count), progress, error))
            return false;
        double lit = clock_seconds() - start;
        bool good = w->verify ? verify_frame(w, &camera, w->cell, w->door_open, &frame, error)
                              : draw_frame(w, &camera, &frame, error);
        if (!good || !write_frame(w, i, error)) return false;
        frame.light_seconds = lit;
        w->totals->frames++;
        add_to_totals(w, i, "frame", &camera, &frame);
        if (w->verify) frame.one_polygon = film_figures_view(&w->totals->film, walk_verify_items(w->verify));
        add_to_means(w, i, at, cut, &frame);
        film_figures_move(&w->totals->film, w->graph->building, i > 0 && !cut ? at - 1 : NULL, at,
                          1.0 / w->rate);
        if (!progress_report(progress, "tour", (double)(i + 1) / path->frame_count))
            return error_set(error, "stopped");
    }
    return true;
}

static bool run_random(Walk *w, const Progress *progress, Error *error) {
    // Most draws find a place, but some kinds have none: a building without doors has no place in the plane of a leaf.
    enum { DRAWS = 100 };
    const WalkOptions *o = w->options;
    Random random = {o->seed};
    RandomView view = {.door_open = ARENA_ARRAY(w->arena, float, w->graph->building->opening_count + 1)};
    for (int i = 0; i < o->random; i++) {
        int draws = 0;
        while (!walk_random_view(w->graph, &random, o->width, o->height, &view) && draws < DRAWS) draws++;
        if (draws == DRAWS) return error_set(error, "no place for a random eye was found in %d draws", DRAWS);
        Frame frame;
        if (!verify_frame(w, &view.camera, view.cell, view.door_open, &frame, error)) return false;
        w->totals->random_frames++;
        add_to_totals(w, i, view.kind, &view.camera, &frame);
        if (!progress_report(progress, "random views", (i + 1.0) / o->random))
            return error_set(error, "stopped");
    }
    return true;
}

// ---- set-up

static bool read_replay(const CellGraph *graph, const char *file, Arena *arena, Recording **out,
                        TourPath *path, Error *error) {
    *out = recording_load(file, graph->building, arena, error);
    if (!*out) return false;
    *path = (TourPath){.frames = (*out)->frames, .frame_count = (*out)->frame_count};
    return true;
}

static void set_doors(Walk *w) {
    Random random = {w->options->seed};
    const Building *b = w->graph->building;
    for (int i = 0; i < b->opening_count; i++)
        w->door_open[i] = walk_door_share(b, i, w->options->doors, &random);
    if (w->options->doors == WALK_DOORS) walk_clear_views(b, w->door_open);
}

static bool open_drawing(Walk *w, const StabForest *forest, Error *error) {
    const WalkOptions *o = w->options;
    if (o->folder && !file_make_folder(o->folder, error)) return false;
    if (o->verify || o->random > 0) {
        w->verify = walk_verify_new(w->graph, forest, w->arena, error);
        if (!w->verify) return false;
    } else {
        w->query = vis_query_new(w->graph, forest, w->arena);
        w->mirrors = mirrors_new(w->graph, forest, w->arena);
        w->context = gl_context_open(w->arena, error);
        if (!w->context) return false;
        w->renderer = walk_renderer_new(w->graph, w->arena, error);
        if (!w->renderer) return false;
        bool lit = (o->light.light || o->light.parts) && o->look == WALK_BAKED;
        if (lit && !(w->light = film_light_new(&o->light, w->renderer, w->arena, error))) return false;
        if (lit && o->false_colour != FALSE_COLOUR_OFF && !(w->overlay = overlay_new(w->arena, error)))
            return false;
    }
    if (!o->video) return true;
    w->video = video_begin(o->video, o->width, o->height, w->rate, o->every, w->arena, error);
    return w->video != NULL;
}

static void close_drawing(Walk *w) {
    video_abandon(w->video);
    walk_verify_free(w->verify);
    if (w->context && gl_context_use(w->context, NULL)) {
        overlay_free(w->overlay);
        walk_renderer_free(w->renderer);
    }
    gl_context_close(w->context);
    w->totals->light_stayed = film_light_stayed(w->light);
    w->totals->light_parts = film_light_parts(w->light);
    film_light_end(w->light);
    mirrors_free(w->mirrors);
    arena_free(&w->rays);
}

// One frame stays while the hour passes, a frame an hour's step.
static void hold(TourPath *path, int count, Arena *arena) {
    if (count < 2) return;
    TourFrame *frames = ARENA_ARRAY(arena, TourFrame, count);
    for (int i = 0; i < count; i++) frames[i] = path->frames[0];
    path->frames = frames;
    path->frame_count = count;
}

bool walk_offscreen(const CellGraph *graph, const StabForest *forest, const WalkOptions *options,
                    const Progress *progress, Arena *arena, WalkTotals *out, Error *error) {
    CORE_ASSERT(options->every >= 1 && options->width >= 1 && options->height >= 1);
    *out = (WalkTotals){.polygons_total = graph->polygon_count};
    TourPath path;
    TourOptions tour = options->path;
    int rate = options->replay ? RECORDING_TICKS : options->video ? FILM_RATE : USUAL_RATE;
    if (options->frames_per_second > 0) rate = options->frames_per_second;
    tour.frames_per_second = rate;
    Recording *replay = NULL;
    if (options->replay ? !read_replay(graph, options->replay, arena, &replay, &path, error)
                        : !tour_make(graph, options->tour, &tour, arena, &path, error)) {
        return false;
    }
    if (path.frame_count == 1) hold(&path, options->hour_count, arena);
    out->reachable_cells = path.reachable_count;
    out->visited_cells = path.visited_count;
    out->rooms_enterable = path.rooms_enterable;
    out->rooms_entered = path.rooms_entered;
    out->cuts = path.cut_count;
    out->seconds = (double)path.frame_count / rate;
    out->notes = path.notes;
    out->note_count = path.note_count;
    Walk w = {.graph = graph,
              .forest = forest,
              .options = options,
              .arena = arena,
              .totals = out,
              .stats = {.arena = arena},
              .replay = replay,
              .rate = rate,
              .cell = -1};
    w.rgb = arena_alloc(arena, (size_t)options->width * (size_t)options->height, 3);
    w.door_open = ARENA_ARRAY(arena, float, graph->building->opening_count + 1);
    if (!replay) set_doors(&w);  // a recorded path begins with all doors closed and tells each change
    w.planned = path.frame_count + options->random;
    bool good = open_drawing(&w, forest, error) && run_tour(&w, &path, progress, error) &&
                run_random(&w, progress, error);
    if (good && w.video) {
        good = video_end(w.video, error);
        w.video = NULL;
    }
    close_drawing(&w);
    divide_means(out);
    return good && (!options->stats || file_write(options->stats, w.stats.data, w.stats.size, error));
}
