// cmd_walk.c - `enfilade walk FILE`: a walk through a building, in a window or off-screen.
#include <dirent.h>
#include <fnmatch.h>
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/app_light.h"
#include "engine/core/file.h"
#include "engine/walk/walk_offscreen.h"
#include "engine/walk/walk_window.h"

static const char HELP[] =
    "usage: enfilade walk FILE [OPTIONS]\n"
    "       enfilade walk FILE --offscreen DIR [--tour auto|NAME | --replay PATH] [OPTIONS]\n\n"
    "Walks through a building, in a window or, off-screen, along a tour. `auto` visits every cell that a "
    "person\n"
    "reaches through doors; NAME is a tour or viewpoint stored in the file; PATH was recorded in the "
    "window.\n\n"
    "In both:\n"
    "  --map NAME         which one of a file that holds several maps (default: the first)\n"
    "  --memory MB        memory that may be used, 16 to 1000000 (default: what fits the file to open it, "
    "then "
    "three quarters\n"
    "                     of the machine's); OpenGL's own is not counted\n"
    "  --size WxH         pixels, 16 to 8192 each (window 1280x720; off-screen 960x540, with --verify "
    "640x360)\n"
    "  --look NAME        fast, fine or baked (default: baked where there is light, else off-screen fine; in "
    "the\n"
    "                     window fast where OpenGL is software)\n"
    "  --light FILE.rad   the light that `enfilade bake` stored (default: FILE with the suffix .rad, or what "
    "`enfilade bake\n"
    "                     FILE` left in the user's cache, where there is one; one that does not fit is "
    "passed "
    "over)\n"
    "  --false-colour Q   light in numbers: radiosity, irradiance (W/m2) or illuminance (lux)\n"
    "  --method NAME      what is culled: none, frustum, portals, plan, stab (default)\n"
    "  --doors STATE      open (off-screen), closed, drawn (window) or random\n"
    "  --replay PATH      follow a recorded path\n\n"
    "In the window:\n"
    "  --view NAME        begin at a stored viewpoint\n"
    "  --pictures DIR     where screenshots and recorded paths go (default: the current folder)\n"
    "  --scale S          of text, pixels to a point, 0.5 to 8 (default: what the screen says)\n"
    "  --full-screen      fill the screen\n"
    "  --no-bake          where there is no light do not bake it in the background\n"
    "  --no-vsync         do not wait for the screen\n"
    "  --trace OUT        a JSON line ten times a second: place, doors, figures\n\n"
    "Off-screen:\n"
    "  --offscreen DIR    write the frames to DIR/frame-00000.png ...\n"
    "  --bake             where there is no light bake it first, and keep it in the user's cache\n"
    "  --tour NAME        auto (default), or the name of a stored tour or viewpoint\n"
    "  --video OUT.mp4    also as a video, made by ffmpeg\n"
    "  --fps N            frames of the video in a second, 1 to 240 (default 12; of a replay 60)\n"
    "  --every N          write each Nth frame only (default 1)\n"
    "  --step M           greatest way between two frames, metres, 0.01 to 10 (default 0.5)\n"
    "  --turn DEG         greatest turn between two frames, degrees, 1 to 60 (default 15)\n"
    "  --stats OUT.csv    a line a frame: place, cells, objects, polygons, times\n"
    "  --verify           draw each frame also with nothing culled and compare, in flat colours\n"
    "  --random N         then verify N random views as well (with --verify)\n"
    "  --raycast N        check N of these frames and views against rays, too (with --verify)\n"
    "  --seed N           of what is random (default 1)\n"
    "  --json             one JSON object on standard output\n\n"
    "Exit status 1 also when --verify finds a difference. Keys in the window:\n";

typedef struct Arguments {
    WalkOptions walk;      // off-screen
    WindowOptions window;  // what both share is in `walk` until all is read
    const char *file, *map, *light;
    bool json, help, sized, off_screen, toured, bake, no_bake;
} Arguments;

enum {
    OFFSCREEN = 256,
    TOUR,
    SIZE,
    VIDEO,
    FPS,
    EVERY,
    STEP,
    TURN,
    STATS,
    METHOD,
    DOORS,
    VERIFY,
    RANDOM,
    RAYCAST,
    SEED,
    LOOK,
    REPLAY,
    VIEW,
    PICTURES,
    SCALE,
    FULL_SCREEN,
    NO_VSYNC,
    TRACE,
    MAP,
    MEMORY,
    LIGHT,
    FALSE_COLOUR,
    BAKE,
    NO_BAKE
};

static int misuse_number(const char *option, const char *value, const char *allowed) {
    return app_misuse("walk", "walk: --%s is `%s` (allowed %s)", option, value, allowed);
}

static int take_number(Arguments *a, int c, const char *value) {
    int seed;
    double degrees;
    switch (c) {
    case SIZE:
        a->sized = true;
        if (app_parse_size(value, &a->walk.width, &a->walk.height)) return APP_GOOD;
        return misuse_number("size", value, "WxH, 16 to 8192 each");
    case FPS:
        if (app_parse_int(value, 1, 240, &a->walk.frames_per_second)) return APP_GOOD;
        return misuse_number("fps", value, "1 to 240");
    case EVERY:
        if (app_parse_int(value, 1, 1000000, &a->walk.every)) return APP_GOOD;
        return misuse_number("every", value, "1 to 1000000");
    case STEP:
        if (app_parse_number(value, 0.01, 10, &a->walk.path.step)) return APP_GOOD;
        return misuse_number("step", value, "0.01 to 10 metres");
    case TURN:
        if (!app_parse_number(value, 1, 60, &degrees)) return misuse_number("turn", value, "1 to 60 degrees");
        a->walk.path.turn = degrees * (M_PI / 180);
        return APP_GOOD;
    case SCALE:
        if (app_parse_number(value, 0.5, 8, &a->window.scale)) return APP_GOOD;
        return misuse_number("scale", value, "0.5 to 8");
    case RANDOM:
        if (app_parse_int(value, 1, 10000000, &a->walk.random)) return APP_GOOD;
        return misuse_number("random", value, "1 to 10000000");
    case RAYCAST:
        if (app_parse_int(value, 1, 1000000, &a->walk.raycast)) return APP_GOOD;
        return misuse_number("raycast", value, "1 to 1000000");
    default:
        if (!app_parse_int(value, 0, 2147483647, &seed))
            return misuse_number("seed", value, "0 to 2147483647");
        a->walk.seed = (uint64_t)seed;
        return APP_GOOD;
    }
}

static int take_window(Arguments *a, int c, const char *value) {
    switch (c) {
    case VIEW:
        a->window.session.view = value;
        return APP_GOOD;
    case PICTURES:
        a->window.session.pictures = value;
        return APP_GOOD;
    case TRACE:
        a->window.session.trace = value;
        return APP_GOOD;
    case FULL_SCREEN:
        a->window.display.full_screen = true;
        return APP_GOOD;
    case NO_VSYNC:
        a->window.display.vsync = false;
        return APP_GOOD;
    default:
        return take_number(a, c, value);
    }
}

static int take_name(Arguments *a, int c, const char *value) {
    int index = 0, code;
    switch (c) {
    case METHOD:
        code = app_parse_name("walk", "--method", value, VIS_METHOD_NAMES, VIS_METHODS, &index);
        a->walk.method = (VisMethod)index;
        return code;
    case LOOK:
        code = app_parse_name("walk", "--look", value, WALK_LOOK_NAMES, WALK_LOOKS, &index);
        a->walk.look = (WalkLook)index;
        return code;
    case FALSE_COLOUR:
        code = app_parse_name("walk", "--false-colour", value, FALSE_COLOUR_NAMES, FALSE_COLOURS, &index);
        a->walk.false_colour = (FalseColour)index;
        return code;
    default:
        code = app_parse_name("walk", "--doors", value, WALK_DOORS_NAMES, WALK_DOORS, &index);
        a->walk.doors = (WalkDoors)index;
        return code;
    }
}

static int take(Arguments *a, int c, char **argv) {
    switch (c) {
    case 'j':
        a->json = true;
        return APP_GOOD;
    case OFFSCREEN:
        a->walk.folder = optarg;
        a->off_screen = true;
        return APP_GOOD;
    case TOUR:
        a->walk.tour = optarg;
        a->toured = true;
        return APP_GOOD;
    case MAP:
        a->map = optarg;
        return APP_GOOD;
    case MEMORY:
        return app_take_memory("walk", optarg);
    case LIGHT:
        a->light = optarg;
        return APP_GOOD;
    case REPLAY:
        a->walk.replay = optarg;
        return APP_GOOD;
    case VIDEO:
        a->walk.video = optarg;
        return APP_GOOD;
    case STATS:
        a->walk.stats = optarg;
        return APP_GOOD;
    case VERIFY:
        a->walk.verify = true;
        return APP_GOOD;
    case BAKE:
        a->bake = true;
        return APP_GOOD;
    case NO_BAKE:
        a->no_bake = true;
        return APP_GOOD;
    case METHOD:
    case LOOK:
    case DOORS:
    case FALSE_COLOUR:
        return take_name(a, c, optarg);
    case ':':
    case '?':
        return app_misuse_option("walk", c, argv);
    default:
        return take_window(a, c, optarg);
    }
}

// What was asked for must go together.
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
    if (a->toured && a->walk.replay)
        return app_misuse("walk", "walk: --tour or --replay (one of them is allowed)");
    return APP_GOOD;
}

static int parse(int argc, char **argv, Arguments *a) {
    static const struct option options[] = {{"json", no_argument, NULL, 'j'},
                                            {"help", no_argument, NULL, 'h'},
                                            {"verify", no_argument, NULL, VERIFY},
                                            {"offscreen", required_argument, NULL, OFFSCREEN},
                                            {"tour", required_argument, NULL, TOUR},
                                            {"size", required_argument, NULL, SIZE},
                                            {"video", required_argument, NULL, VIDEO},
                                            {"fps", required_argument, NULL, FPS},
                                            {"every", required_argument, NULL, EVERY},
                                            {"step", required_argument, NULL, STEP},
                                            {"turn", required_argument, NULL, TURN},
                                            {"stats", required_argument, NULL, STATS},
                                            {"method", required_argument, NULL, METHOD},
                                            {"doors", required_argument, NULL, DOORS},
                                            {"random", required_argument, NULL, RANDOM},
                                            {"raycast", required_argument, NULL, RAYCAST},
                                            {"seed", required_argument, NULL, SEED},
                                            {"look", required_argument, NULL, LOOK},
                                            {"replay", required_argument, NULL, REPLAY},
                                            {"view", required_argument, NULL, VIEW},
                                            {"pictures", required_argument, NULL, PICTURES},
                                            {"scale", required_argument, NULL, SCALE},
                                            {"full-screen", no_argument, NULL, FULL_SCREEN},
                                            {"no-vsync", no_argument, NULL, NO_VSYNC},
                                            {"trace", required_argument, NULL, TRACE},
                                            {"map", required_argument, NULL, MAP},
                                            {"memory", required_argument, NULL, MEMORY},
                                            {"light", required_argument, NULL, LIGHT},
                                            {"false-colour", required_argument, NULL, FALSE_COLOUR},
                                            {"bake", no_argument, NULL, BAKE},
                                            {"no-bake", no_argument, NULL, NO_BAKE},
                                            {0}};
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":h", options, NULL)) != -1;) {
        if (c == 'h') {
            a->help = true;
            return APP_GOOD;
        }
        int code = take(a, c, argv);
        if (code != APP_GOOD) return code;
    }
    if (argc - optind != 1)
        return app_misuse("walk", "walk: one building file is needed, %d were given", argc - optind);
    a->file = argv[optind];
    return check(a);
}

static void print_json(const AppScene *scene, const WalkTotals *t) {
    json_t *o = app_counts(scene);
    json_object_set_new(o, "frames", json_integer(t->frames));
    json_object_set_new(o, "random_frames", json_integer(t->random_frames));
    json_object_set_new(o, "images", json_integer(t->images));
    json_object_set_new(o, "cells_reachable", json_integer(t->reachable_cells));
    json_object_set_new(o, "cells_visited", json_integer(t->visited_cells));
    json_object_set_new(o, "polygons_total", json_integer(t->polygons_total));
    json_object_set_new(o, "polygons_drawn_mean", json_real(t->polygons_drawn_mean));
    json_object_set_new(o, "cells_visible_mean", json_real(t->cells_visible_mean));
    json_object_set_new(o, "query_us_mean", json_real(t->query_us_mean));
    json_object_set_new(o, "query_us_max", json_real(t->query_us_max));
    json_object_set_new(o, "frame_ms_mean", json_real(t->frame_ms_mean));
    json_object_set_new(o, "mismatched_pixels", json_integer(t->mismatched_pixels));
    json_object_set_new(o, "missing_polygons", json_integer(t->missing_polygons));
    json_object_set_new(o, "raycast_frames", json_integer(t->raycast_frames));
    json_object_set_new(o, "raycast_missing", json_integer(t->raycast_missing));
    app_print_json(o);
}

static void print_result(const Arguments *a, const WalkTotals *t) {
    printf("%d frames of %s `%s`; %.1f of %d polygons drawn in the mean (%.1f %%), query %.1f us, frame "
           "%.1f ms\n",
           t->frames, a->walk.replay ? "path" : "tour", a->walk.replay ? a->walk.replay : a->walk.tour,
           t->polygons_drawn_mean, t->polygons_total,
           t->polygons_total > 0 ? 100 * t->polygons_drawn_mean / t->polygons_total : 0, t->query_us_mean,
           t->frame_ms_mean);
    if (t->images > 0)
        printf("frames      %s/frame-00000.png to frame-%05d.png\n", a->walk.folder, t->images - 1);
    if (a->walk.video) printf("video       %s\n", a->walk.video);
    if (a->walk.stats) printf("statistics  %s\n", a->walk.stats);
    if (a->walk.verify) {
        printf("verified    %d frames and %d random views: %ld pixels differ, %ld polygons are missing\n",
               t->frames, t->random_frames, t->mismatched_pixels, t->missing_polygons);
    }
    if (t->raycast_frames > 0) {
        printf("rays        %d frames: %ld polygons seen that are not drawn\n", t->raycast_frames,
               t->raycast_missing);
    }
}

// The building with its light, if it has any. What is found beside it or in the cache and does not fit is passed over with a
// warning; what was asked for must fit. Where there is none, how it can be baked, if it can and is to be.
static bool load_lit(const Arguments *a, const char *path, Arena *arena, AppScene *scene,
                     const WalkLight **light, AppBake **bake, Error *error) {
    AppOptions load = app_default_options();
    const char *lights[APP_LIGHTS];
    app_open_budget(path);
    int count = a->walk.verify ? 0 : app_find_lights(path, a->map, a->light, arena, lights);
    if (!app_output_spares(lights, count, error)) return false;
    bool bakes = !a->walk.verify && (a->off_screen ? a->bake : !a->no_bake);
    load.map = a->map;
    load.work = "walking";
    load.lamps = count > 0 || bakes;
    *light = NULL;
    *bake = NULL;
    if (!app_load(path, &load, arena, scene, error) || !app_has_walls(scene, error)) return false;
    WalkLight *found = ARENA_ARRAY(arena, WalkLight, 1);
    for (int i = 0; i < count; i++) {
        if (app_load_light(lights[i], scene, arena, found, error)) {
            *light = found;
            return true;
        }
        if (a->light) return false;
        fprintf(stderr, "enfilade: passed over: %s\n", error->text);
    }
    if (bakes) *bake = app_bake_new(path, scene, arena);
    if (!load.lamps || bakes) return true;
    load.lamps = false;
    return app_load(path, &load, arena, scene, error);
}

// Before the first frame.
static bool bake_first(Arguments *a, AppBake *bake, Arena *arena, Error *error) {
    WalkLight *light = ARENA_ARRAY(arena, WalkLight, 1);
    LightHooks hooks = {.progress = app_progress()};
    bool good = app_bake(bake, &hooks, arena, light, error);
    app_progress_end();
    if (!good) return false;
    if (*error->text) fprintf(stderr, "enfilade: %s\n", error->text);
    a->walk.light = light;
    return true;
}

// Frames are written after the light was baked, which may take long.
static bool check_folder(const Arguments *a, const Building *b, Arena *arena, Error *error) {
    if (!file_make_folder(a->walk.folder, error) ||
        !file_check(arena_format(arena, "%s/frame-00000.png", a->walk.folder), 0, error))
        return false;
    // How many pictures there will be is not known yet: each name that one may have counts.
    const char *read[] = {a->file, a->light, a->walk.replay};
    DIR *folder = opendir(a->walk.folder);
    bool good = true;
    for (struct dirent *entry; good && folder && (entry = readdir(folder));) {
        if (fnmatch("frame-*.png", entry->d_name, 0) != 0) continue;
        const char *path = arena_format(arena, "%s/%s", a->walk.folder, entry->d_name);
        good =
            app_spares(&path, 1, read, 3, error) && app_spares(&path, 1, b->beside, b->beside_count, error);
    }
    if (folder) closedir(folder);
    return good;
}

static bool draw_tour(Arguments *a, Arena *arena, WalkTotals *totals, Error *error) {
    AppScene scene;
    AppBake *bake;
    if (!load_lit(a, a->file, arena, &scene, &a->walk.light, &bake, error) ||
        !check_folder(a, &scene.building, arena, error) || (bake && !bake_first(a, bake, arena, error)))
        return false;
    if (a->walk.look == WALK_LOOKS) a->walk.look = a->walk.light ? WALK_BAKED : WALK_FINE;
    if (a->walk.look == WALK_BAKED && !a->walk.light)
        return error_set(error, "%s: there is no light to show (enfilade bake, then --light FILE.rad)",
                         a->file);
    Progress progress = app_progress();
    bool good = walk_offscreen(&scene.graph, &scene.forest, &a->walk, &progress, arena, totals, error);
    app_progress_end();
    if (!good) return false;
    if (a->json) {
        print_json(&scene, totals);
    } else {
        print_result(a, totals);
    }
    return true;
}

static bool load_scene(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    const Arguments *a = context;
    AppScene *scene = ARENA_ARRAY(arena, AppScene, 1);
    const WalkLight *light;
    AppBake *bake;
    if (!load_lit(a, path, arena, scene, &light, &bake, error)) return false;
    *out =
        (WalkScene){&scene->graph, &scene->forest, light, {bake ? app_bake : NULL, bake, bake && bake->out}};
    app_memory_gently();  // should the file change
    return true;
}

static bool open_window(Arguments *a, Arena *arena, Error *error) {
    SessionLoader loader = {load_scene, a};
    SessionOptions *session = &a->window.session;
    session->file = a->file;
    session->replay = a->walk.replay;
    session->method = a->walk.method;
    session->full_screen = a->window.display.full_screen;
    session->false_colour = a->walk.false_colour;
    if (a->walk.look != WALK_LOOKS) session->look = a->walk.look;
    if (a->walk.doors != WALK_DOORS) session->doors = a->walk.doors;
    a->window.display.title = arena_format(arena, "%s - Enfilade", a->file);
    if (a->sized) {
        a->window.display.width = a->walk.width;
        a->window.display.height = a->walk.height;
    }
    return walk_window(&a->window, &loader, arena, error);
}

static void print_help(void) {
    fputs(HELP, stdout);
    for (int i = 0; i < SESSION_KEY_COUNT; i++)
        printf("  %-18s %s\n", SESSION_KEYS[i].keys, SESSION_KEYS[i].action);
}

int cmd_walk(int argc, char **argv) {
    Arguments a = {.walk = walk_default_options(), .window = window_default_options()};
    a.walk.look = WALK_LOOKS;
    a.walk.doors = WALK_DOORS;
    int code = parse(argc, argv, &a);
    if (code != APP_GOOD) return code;
    if (a.help) {
        print_help();
        return APP_GOOD;
    }
    Arena arena = {0};
    WalkTotals totals = {0};
    Error error;
    const char *written[] = {a.walk.video, a.walk.stats, a.window.session.trace},
               *read[] = {a.file, a.light, a.walk.replay};
    bool good = app_check_files(written, 3, read, 3, &error);
    if (!good) {
        // Said below.
    } else if (a.off_screen) {
        if (a.walk.verify && !a.sized) a.walk.width = 640, a.walk.height = 360;
        if (a.walk.doors == WALK_DOORS) a.walk.doors = WALK_DOORS_OPEN;
        good = draw_tour(&a, &arena, &totals, &error);
    } else {
        good = open_window(&a, &arena, &error);
    }
    if (!good) app_fail(APP_BAD_INPUT, "%s", error.text);
    if (good && totals.bad_frames > 0) {
        app_fail(APP_BAD_INPUT, "%d frames differ from the unculled ones; %s", totals.bad_frames,
                 totals.first_fault);
        good = false;
    }
    arena_free(&arena);
    return good ? APP_GOOD : APP_BAD_INPUT;
}
