// cmd_walk.c - `enfilade walk FILE`: a walk through a building, in a window or off-screen.
#include <dirent.h>
#include <fnmatch.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/app.h"
#include "engine/core/file.h"
#include "engine/walk/walk_offscreen.h"
#include "engine/walk/walk_window.h"

typedef struct Arguments {
    WalkOptions walk;  // off-screen
    // Those of the window; parts that both share are in `walk` until all is read.
    struct {
        SessionOptions session;
        DisplayOptions display;
        double scale;  // pixels to a point; 0: the screen's own
    } window;
    SceneOptions load;
    const char *file;
    int size[2];
    double until[2];  // hours, as DayOptions.time
    bool json, sized, off_screen, toured, bake, no_bake, no_vsync;
} Arguments;

#define AT(field) offsetof(Arguments, field)
static const Option ROWS[] = {
    {.type = OPTION_HEADING, .help = "In both:"},
    OPTION_MAP(AT(load.map)),
    OPTION_PHOTOMETRY(AT(load.photometry)),
    OPTION_MEMORY(
        AT(load.memory),
        "what fits the file to open it, then three quarters of the machine's; OpenGL's own is not counted"),
    {.name = "size",
     .value = "WxH",
     .type = OPTION_SIZE,
     .at = AT(size),
     .low = 16,
     .high = 8192,
     .help = "pixels, @ (window 1280x720; off-screen 960x540, with --verify 640x360)"},
    {.name = "look",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(walk.look),
     .names = WALK_LOOK_NAMES,
     .name_count = WALK_LOOKS,
     .help = "@ (default: baked where there is light, else off-screen fine; in the window fast where OpenGL "
             "is software)"},
    {.name = "light",
     .value = "FILE.rad",
     .type = OPTION_TEXT,
     .at = AT(load.light),
     .help = "the light that `enfilade bake` stored (default: FILE with the suffix .rad, or the light that "
             "`enfilade bake "
             "FILE` left in the user's cache, where there is one; one that does not fit is passed over)"},
    OPTION_DAYLIGHT(AT(load.day), "default: stored light as it is, else a day as --day has it"),
    OPTION_FILL_LAMPS(AT(load.fill_lamps)),
    OPTION_LAMPS(AT(load.lamp_state), ""),
    {.name = "false-colour",
     .value = "Q",
     .type = OPTION_NAME,
     .at = AT(walk.false_colour),
     .names = FALSE_COLOUR_NAMES,
     .name_count = FALSE_COLOURS,
     .help = "light in numbers: @; radiosity and irradiance in W/m2, illuminance in lux"},
    {.name = "culling",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(walk.culling),
     .names = CULLING_NAMES,
     .name_count = QUERY_CULLINGS,
     .help = "how objects that cannot be seen are left out: @ (default stab)"},
    {.name = "doors",
     .value = "STATE",
     .type = OPTION_NAME,
     .at = AT(walk.doors),
     .names = WALK_DOORS_NAMES,
     .name_count = WALK_DOORS,
     .help =
         "@ (default: in the window drawn, off-screen open, but with no leaf before a stored viewpoint; the "
         "tour `auto` opens and closes them on its way)"},
    {.name = "replay",
     .value = "PATH",
     .type = OPTION_TEXT,
     .at = AT(walk.replay),
     .help = "follow a recorded path"},
    {.type = OPTION_HEADING, .help = "In the window:"},
    {.name = "view",
     .value = "NAME",
     .type = OPTION_TEXT,
     .at = AT(window.session.view),
     .help = "begin at a stored viewpoint"},
    {.name = "pictures",
     .value = "DIR",
     .type = OPTION_TEXT,
     .at = AT(window.session.pictures),
     .help = "where screenshots and recorded paths go (default: the current folder)"},
    {.name = "scale",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(window.scale),
     .low = 0.5,
     .high = 8,
     .help = "of text, pixels to a point, @ (default: as the screen says)"},
    {.name = "full-screen",
     .type = OPTION_FLAG,
     .at = AT(window.display.full_screen),
     .help = "fill the screen"},
    {.name = "no-bake",
     .type = OPTION_FLAG,
     .at = AT(no_bake),
     .help = "where there is no light do not bake it in the background"},
    {.name = "no-vsync", .type = OPTION_FLAG, .at = AT(no_vsync), .help = "do not wait for the screen"},
    {.name = "trace",
     .value = "OUT",
     .type = OPTION_TEXT,
     .at = AT(window.session.trace),
     .help = "a JSON line ten times a second: place, doors, figures"},
    {.type = OPTION_HEADING, .help = "Off-screen:"},
    {.name = "offscreen",
     .value = "DIR",
     .type = OPTION_TEXT,
     .at = AT(walk.folder),
     .help = "write the frames to DIR/frame-00000.png ..."},
    {.name = "bake",
     .type = OPTION_FLAG,
     .at = AT(bake),
     .help =
         "where there is no light bake it first, and keep it in the user's cache; light follows the doors "
         "then, baked anew where need be; --day, --night and their like ask for it, too"},
    {.name = "tour",
     .value = "NAME",
     .type = OPTION_TEXT,
     .at = AT(walk.tour),
     .help = "auto (default), or the name of a stored tour or viewpoint"},
    {.name = "rooms",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(walk.path.rooms),
     .low = 1,
     .high = 10000000,
     .help = "of the tour `auto`: at most so many rooms, those nearest to the start, @ (default: all)"},
    {.name = "until",
     .value = "TIME",
     .type = OPTION_TIME,
     .at = AT(until),
     .low = -14,
     .high = 14,
     .help =
         "while the frames go by, the hour passes from that of the day on to @, in steps of ten minutes; a "
         "viewpoint stays, a frame for each step"},
    {.name = "video",
     .value = "OUT.mp4",
     .type = OPTION_TEXT,
     .at = AT(walk.video),
     .help = "also as a video, made by ffmpeg"},
    {.name = "fps",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(walk.frames_per_second),
     .low = 1,
     .high = 240,
     .help = "frames in a second, @ (default 24 with --video, else 12; of a replay 60)"},
    {.name = "every",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(walk.every),
     .low = 1,
     .high = 1000000,
     .help = "write each Nth frame only, @ (default 1); the video is as long as with all"},
    {.name = "step",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(walk.path.step),
     .low = 0.01,
     .high = 10,
     .help = "of a stored tour: greatest way between two frames, metres, @ (default 0.5)"},
    {.name = "turn",
     .value = "DEG",
     .type = OPTION_DEGREES,
     .at = AT(walk.path.turn),
     .low = 1,
     .high = 60,
     .help = "of a stored tour: greatest turn between two frames, degrees, @ (default 15)"},
    {.name = "stats",
     .value = "OUT.csv",
     .type = OPTION_TEXT,
     .at = AT(walk.stats),
     .help = "a line a frame: place, cells, objects, polygons, times"},
    {.name = "verify",
     .type = OPTION_FLAG,
     .at = AT(walk.verify),
     .help = "draw each frame also with nothing culled and compare, in flat colours"},
    {.name = "random",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(walk.random),
     .low = 1,
     .high = 10000000,
     .help = "then verify so many random views as well, @ (with --verify)"},
    {.name = "raycast",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(walk.raycast),
     .low = 1,
     .high = 1000000,
     .help = "check so many of these frames and views against rays, too, @ (with --verify)"},
    {.name = "seed",
     .value = "N",
     .type = OPTION_SEED,
     .at = AT(walk.seed),
     .high = 2147483647,
     .help = "of random views and doors, @ (default 1)"},
    OPTION_JSON(AT(json)),
};
static const OptionTable OPTIONS =
    OPTION_TABLE("walk",
                 "FILE [OPTIONS]\n"
                 "FILE --offscreen DIR [--tour auto|NAME | --replay PATH] [OPTIONS]",
                 "Walks through a building, in a window or, off-screen, along a tour. `auto` walks at 1.4 "
                 "m/s through every "
                 "room that a person can enter, and says what it leaves out; NAME is a tour or viewpoint "
                 "stored in the file; "
                 "PATH was recorded in the window.",
                 ROWS);

// Options that exclude or need one another.
static int check(const Arguments *a) {
    if (a->walk.random > 0 && !a->walk.verify) return app_misuse("walk", "walk: --random needs --verify");
    if (a->walk.raycast > 0 && !a->walk.verify) return app_misuse("walk", "walk: --raycast needs --verify");
    bool for_tours = a->toured || a->walk.video || a->walk.stats || a->walk.verify || a->json;
    if (!a->off_screen && for_tours) {
        return app_misuse("walk", "walk: --tour, --video, --stats, --verify and --json need --offscreen DIR: "
                                  "they are not for the window");
    }
    bool for_window = a->window.session.view || a->window.session.trace || a->window.display.full_screen;
    if (a->off_screen && for_window)
        return app_misuse("walk",
                          "walk: --view, --trace and --full-screen are for the window, not --offscreen");
    if (a->off_screen ? a->no_bake : a->bake)
        return app_misuse("walk", "walk: --bake is for --offscreen, --no-bake for the window");
    if (a->walk.path.rooms > 0 && (a->walk.replay || !a->off_screen || strcmp(a->walk.tour, "auto") != 0))
        return app_misuse("walk", "walk: --rooms is for the tour `auto`, off-screen");
    if (!isnan(a->until[0]) && (!a->off_screen || a->walk.verify || a->load.day.night))
        return app_misuse("walk", "walk: --until is for --offscreen, by day and without --verify");
    if (day_asks(&a->load.day) && a->walk.verify)
        return app_misuse("walk", "walk: %s is not for --verify, which shows no light",
                          day_asks_sky(&a->load.day) ? "--sky" : "daylight");
    if (a->walk.verify && (a->load.light || a->walk.look == WALK_BAKED))
        return app_misuse("walk", "walk: %s is not for --verify, which shows no light",
                          a->load.light ? "--light" : "--look baked");
    if (a->toured && a->walk.replay)
        return app_misuse("walk", "walk: --tour or --replay (one of them is allowed)");
    return app_check_day("walk", &a->load.day);
}

static int parse_walk(int argc, char **argv, Arguments *a, bool *help) {
    bool given[sizeof ROWS / sizeof *ROWS] = {false};
    int code = options_parse_file(&OPTIONS, argc, argv, a, given, &a->file, help);
    if (code != APP_GOOD || *help) return code;
    a->sized = options_given(&OPTIONS, given, "size");
    a->toured = options_given(&OPTIONS, given, "tour");
    a->off_screen = a->walk.folder != NULL;
    if (a->no_vsync) a->window.display.vsync = false;
    return check(a);
}

static void print_json(const LoadedScene *scene, const WalkTotals *t) {
    json_t *o = app_counts(scene);
    json_object_set_new(o, "frames", json_integer(t->frames));
    json_object_set_new(o, "random_frames", json_integer(t->random_frames));
    json_object_set_new(o, "images", json_integer(t->images));
    json_object_set_new(o, "cells_reachable", json_integer(t->reachable_cells));
    json_object_set_new(o, "seconds", json_real(t->seconds));
    json_object_set_new(o, "rooms_enterable", json_integer(t->rooms_enterable));
    json_object_set_new(o, "rooms_entered", json_integer(t->rooms_entered));
    json_object_set_new(o, "cuts", json_integer(t->cuts));
    const FilmFigures *f = &t->film;
    double frames = fmax(1, f->frames), views = fmax(1, f->views);
    json_object_set_new(o, "fastest_m_s", json_real(f->fastest));
    json_object_set_new(o, "quickest_turn_deg_s", json_real(f->quickest * 180 / M_PI));
    json_object_set_new(o, "turning_share", json_real(f->turning / frames));
    json_object_set_new(o, "frames_in_furniture", json_integer(f->in_furniture));
    // These two are known of verified frames only.
    json_object_set_new(o, "near_share", f->views ? json_real(f->near / views) : json_null());
    json_object_set_new(o, "one_polygon_share", f->views ? json_real(f->one_polygon / views) : json_null());
    json_object_set_new(o, "cells_visited", json_integer(t->visited_cells));
    json_object_set_new(o, "polygons_total", json_integer(t->polygons_total));
    json_object_set_new(o, "polygons_drawn_mean", json_real(t->polygons_drawn_mean));
    json_object_set_new(o, "cells_visible_mean", json_real(t->cells_visible_mean));
    json_object_set_new(o, "query_us_mean", json_real(t->query_us_mean));
    json_object_set_new(o, "query_us_max", json_real(t->query_us_max));
    json_object_set_new(o, "frame_ms_mean", json_real(t->frame_ms_mean));
    json_object_set_new(o, "light_parts_wanted", json_integer(t->light_parts.wanted));
    json_object_set_new(o, "light_parts_read", json_integer(t->light_parts.read));
    json_object_set_new(o, "light_parts_kept", json_integer(t->light_parts.kept));
    json_object_set_new(o, "mismatched_pixels", json_integer(t->mismatched_pixels));
    json_object_set_new(o, "missing_polygons", json_integer(t->missing_polygons));
    json_object_set_new(o, "mirrors", json_integer(t->mirrors));
    json_object_set_new(o, "mirror_pixels", json_integer(t->mirror_pixels));
    json_object_set_new(o, "raycast_frames", json_integer(t->raycast_frames));
    json_object_set_new(o, "raycast_missing", json_integer(t->raycast_missing));
    app_print_json(o);
}

static void print_walk(const Arguments *a, const WalkTotals *t) {
    printf("%d frames of %s `%s`; %.1f of %d polygons drawn in the mean (%.1f %%), query %.1f us, frame "
           "%.1f ms\n",
           t->frames, a->walk.replay ? "path" : "tour", a->walk.replay ? a->walk.replay : a->walk.tour,
           t->polygons_drawn_mean, t->polygons_total,
           t->polygons_total > 0 ? 100 * t->polygons_drawn_mean / t->polygons_total : 0, t->query_us_mean,
           t->frame_ms_mean);
    if (t->rooms_enterable > 0) {
        printf("rooms       %d of %d that a body can enter; %d cuts; %.1f s; at most %.2f m/s and %.0f "
               "degrees a "
               "second\n",
               t->rooms_entered, t->rooms_enterable, t->cuts, t->seconds, t->film.fastest,
               t->film.quickest * 180 / M_PI);
    }
    if (t->images > 0)
        printf("frames      %s/frame-00000.png to frame-%05d.png\n", a->walk.folder, t->images - 1);
    if (a->walk.video) printf("video       %s\n", a->walk.video);
    if (a->walk.stats) printf("statistics  %s\n", a->walk.stats);
    if (t->light_parts.wanted > 0)
        printf("light       the part changed %ld times, and was read from files %ld times; %d parts are in "
               "memory at "
               "the end\n",
               t->light_parts.wanted, t->light_parts.read, t->light_parts.kept);
    if (a->walk.verify) {
        printf("verified    %d frames and %d random views: %ld pixels differ, %ld polygons are missing\n",
               t->frames, t->random_frames, t->mismatched_pixels, t->missing_polygons);
    }
    if (t->mirrors > 0)
        printf("mirrors     %ld views in mirrors, of %ld pixels, were compared, too\n", t->mirrors,
               t->mirror_pixels);
    if (t->raycast_frames > 0) {
        printf("rays        %d frames: %ld polygons seen that are not drawn\n", t->raycast_frames,
               t->raycast_missing);
    }
}

// Before the first frame. Stored light is read; where it is not of the doors of a frame, it is baked anew.
static bool bake_first(Arguments *a, const LightBaker *baker, Arena *room, WalkLight *light, Error *error) {
    Progress progress = app_progress();
    bool good = film_light_bake(baker, &progress, room, light, error);
    app_progress_end();
    if (!good) return false;
    if (*error->text) app_warn(error->text);
    a->walk.light.light = light;
    a->walk.light.anew = baker->anew;
    return true;
}

// Frames are written after the light was baked, which may take long.
static bool check_folder(const Arguments *a, const Building *b, Arena *arena, Error *error) {
    if (!file_make_folder(a->walk.folder, error) ||
        !file_check(arena_format(arena, "%s/frame-00000.png", a->walk.folder), 0, error))
        return false;
    // How many pictures there will be is not known yet: each name that one may have counts.
    const char *read[] = {a->file, a->load.light, a->walk.replay};
    DIR *folder = opendir(a->walk.folder);
    bool good = true;
    for (struct dirent *entry; good && folder && (entry = readdir(folder));) {
        if (fnmatch("frame-*.png", entry->d_name, 0) != 0) continue;
        const char *path = arena_format(arena, "%s/%s", a->walk.folder, entry->d_name);
        good = scene_spares(&path, 1, read, 3, error) &&
               scene_spares(&path, 1, b->beside, b->beside_count, error);
    }
    if (folder) closedir(folder);
    return good;
}

// The days under which the frames go by, in the arena, until the hour that was asked for.
static bool find_hours(Arguments *a, const LoadedScene *scene, Arena *arena, Error *error) {
    static const double STEP = 1 / 6.0;
    const Building *b = &scene->building;
    if (isnan(a->until[0])) return true;
    if (!daylight_shines(&scene->day) || daylight_is_uniform(&scene->day))
        return error_set(error, "%s: --until is for daylight that has hours (--day; not --sky)", a->file);
    double from = day_hour(&a->load.day, b, &scene->day), passes = fmod(a->until[0] - from + 24, 24);
    int count = (int)ceil(passes / STEP - 1e-6) + 1;
    Daylight *hours = ARENA_ARRAY(arena, Daylight, count);
    for (int i = 0; i < count; i++) {
        double hour = from + fmin(i * STEP, passes);
        DayOptions at = day_at_hour(&a->load.day, b, hour);
        if (!at.night && day_over(&at, b, &hours[i], error)) continue;
        int minutes = (int)lrint(60 * hour) % (24 * 60);
        return error_set(error, "%s: --until: it is night at %02d:%02d (the hours of a film are by day)",
                         a->file, minutes / 60, minutes % 60);
    }
    a->walk.hours = hours;
    a->walk.hour_count = count;
    return true;
}

static bool draw_lit(Arguments *a, const WalkScene *scene, Arena *arena, WalkTotals *totals, Error *error) {
    Arena room = {0}, hours[2] = {{0}};
    WalkLight baked = {0};
    a->walk.light = (FilmLightSource){
        .light = scene->light, .parts = scene->baker.parts, .lit = scene->scene->lit, .room = hours};
    bool good = find_hours(a, scene->scene, arena, error) &&
                (!scene->baker.bake || bake_first(a, &scene->baker, &room, &baked, error));
    bool light = a->walk.light.light || a->walk.light.parts;
    if (a->walk.look == WALK_LOOKS) a->walk.look = light ? WALK_BAKED : WALK_FINE;
    if (good && a->walk.look == WALK_BAKED && !light)
        good =
            error_set(error, "%s: there is no light to show (enfilade bake, then --light FILE.rad)", a->file);
    Progress progress = app_progress();
    good = good && walk_offscreen(scene->graph, scene->forest, &a->walk, &progress, arena, totals, error);
    app_progress_end();
    light_end(&baked);
    for (int i = 0; i < 2; i++) arena_free(&hours[i]);
    arena_free(&room);
    return good;
}

static bool draw_tour(Arguments *a, Arena *arena, WalkTotals *totals, Error *error) {
    WalkScene scene;
    a->load.light_later = a->load.lamps == SCENE_LAMPS_ALL;
    bool loaded = walk_scene_load(&a->load, a->file, arena, &scene, error);
    app_progress_end();
    if (!loaded || !check_folder(a, scene.graph->building, arena, error)) return false;
    if (!draw_lit(a, &scene, arena, totals, error)) return false;
    if (totals->light_stayed)
        app_warn(a->load.lamps == SCENE_LAMPS_ALL
                     ? "the light stays that of the doors as they were baked"
                     : "the light stays that of the doors as they were baked (--bake lets it follow them)");
    for (int i = 0; i < totals->note_count; i++) app_warn(totals->notes[i]);
    if (a->json) {
        print_json(scene.scene, totals);
    } else {
        print_walk(a, totals);
    }
    return true;
}

static bool open_window(Arguments *a, Arena *arena, Error *error) {
    SessionLoader loader = {walk_scene_load, &a->load, walk_scene_turn};
    a->load.light_later = true;
    SessionOptions *session = &a->window.session;
    session->file = a->file;
    session->replay = a->walk.replay;
    session->culling = a->walk.culling;
    session->full_screen = a->window.display.full_screen;
    session->false_colour = a->walk.false_colour;
    if (a->walk.look != WALK_LOOKS) session->look = a->walk.look;
    if (a->walk.doors != WALK_DOORS) session->doors = a->walk.doors;
    a->window.display.title = arena_format(arena, "%s - Enfilade", a->file);
    if (a->sized) {
        a->window.display.width = a->size[0];
        a->window.display.height = a->size[1];
    }
    return walk_window(session, &a->window.display, a->window.scale, &loader, arena, error);
}

static void print_walk_help(void) {
    options_print_help(&OPTIONS);
    puts("\nExit status 1 also when --verify finds a difference. Keys in the window:");
    for (int i = 0; i < SESSION_KEY_COUNT; i++)
        printf("  %-18s %s\n", SESSION_KEYS[i].keys, SESSION_KEYS[i].action);
}

static bool walk(Arguments *a, Arena *arena, WalkTotals *totals, Error *error) {
    SceneOptions *load = &a->load;
    const char *written[] = {a->walk.video, a->walk.stats, a->window.session.trace},
               *read[] = {a->file, load->light, a->walk.replay};
    if (!app_check_files(written, 3, read, 3, load, error)) return false;
    // Daylight or night that is asked for is baked where no stored light has it; the usual day where anything is baked.
    bool asked = day_asks(&load->day) || load->day.night;
    bool bakes = !a->walk.verify && (a->off_screen ? a->bake || asked : !a->no_bake);
    load->day.usual = bakes;
    load->work = "walking";
    load->find_light = !a->walk.verify;
    load->lamps = bakes ? SCENE_LAMPS_ALL : load->find_light ? SCENE_LAMPS_IF_LIT : SCENE_LAMPS_NONE;
    if (!a->off_screen) return open_window(a, arena, error);
    if (a->walk.verify) a->walk.width = 640, a->walk.height = 360;
    if (a->sized) a->walk.width = a->size[0], a->walk.height = a->size[1];
    return draw_tour(a, arena, totals, error);
}

int cmd_walk(int argc, char **argv) {
    Arguments a = {.walk = walk_default_options(),
                   .window = {.session = session_default_options(), .display = display_default_options()},
                   .load = app_scene_options()};
    bool help = false;
    a.load.fill_lamps = FILL_LAMPS_ON;
    a.until[0] = a.until[1] = NAN;
    a.walk.look = WALK_LOOKS;
    a.walk.doors = WALK_DOORS;
    int code = parse_walk(argc, argv, &a, &help);
    if (help) print_walk_help();
    if (code != APP_GOOD || help) return code;
    Arena arena = {0};
    WalkTotals totals = {0};
    Error error;
    bool good = walk(&a, &arena, &totals, &error);
    if (!good) app_fail(APP_BAD_INPUT, "%s", error.text);
    if (good && totals.bad_frames > 0) {
        app_fail(APP_BAD_INPUT, "%d frames differ from the unculled ones; %s", totals.bad_frames,
                 totals.first_fault);
        good = false;
    }
    arena_free(&arena);
    return good ? APP_GOOD : APP_BAD_INPUT;
}
