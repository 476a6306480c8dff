// cmd_bench.c - `enfilade bench NAME`: tables of measurements, a benchmark a row of the table below.
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/app.h"
#include "engine/core/clock.h"
#include "engine/walk/tour.h"
#include "engine/walk/view.h"
#include "engine/walk/walk_renderer.h"
#include "visibility/hidden/gl_context.h"

static const char HELP[] =
    "usage: enfilade bench walk [FILE ...] [--size WxH] [--frames N] [--look NAME]\n\n"
    "Measures, and writes CSV with a header on standard output.\n\n"
    "  walk           each culling method along the auto tour of each building: polygons drawn, cells seen, "
    "time of\n"
    "                 the query and of the whole frame (default FILE: build/maps/office.plan)\n\n"
    "  --size WxH     of the frames, pixels, 16 to 8192 each (default 640x360)\n"
    "  --look NAME    fast (default) or fine\n"
    "  --frames N     of the tour, evenly taken, 1 to 1000000 (default 200)\n";

typedef struct Arguments {
    const char *name;
    char **files;
    int file_count, width, height, frames;
    WalkLook look;
    bool help;
} Arguments;

typedef struct Sums {
    double polygons, cells, query, frame, portals, objects;
    int frames;
} Sums;

static bool measure(const AppScene *scene, const TourPath *path, const Arguments *a, VisMethod method,
                    VisQuery *query, WalkRenderer *renderer, Sums *out, Error *error) {
    *out = (Sums){0};
    int taken = path->frame_count < a->frames ? path->frame_count : a->frames, cell = -1;
    // The first frame once more before all: it pays for what is made on first use.
    for (int i = -1; i < taken; i++) {
        const TourFrame *at = &path->frames[(long)(i < 0 ? 0 : i) * path->frame_count / taken];
        Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, a->width, a->height);
        Eye eye = walk_eye(&camera);
        cell = vis_locate(&scene->graph, at->eye, cell);
        double start = clock_seconds();
        VisResult v = vis_query(query, &eye, cell, NULL, method);
        double asked = clock_seconds();
        if (!walk_renderer_draw(renderer, &camera, v.objects, v.object_count, a->look, error) ||
            !walk_renderer_finish_scene(renderer, error)) return false;
        walk_renderer_finish();
        if (i < 0) continue;
        out->frame += clock_seconds() - start;
        out->query += asked - start;
        out->polygons += v.polygon_count;
        out->cells += v.cell_count;
        out->portals += v.portals_tested;
        out->objects += v.objects_tested;
        out->frames++;
    }
    return true;
}

static bool bench_building(const char *file, const Arguments *a, GlContext *context, Arena *arena,
                           Error *error) {
    AppOptions load = app_default_options();
    AppScene scene;
    TourOptions options = tour_default_options();
    TourPath path;
    if (!app_load(file, &load, arena, &scene, error)) return false;
    if (!tour_make(&scene.graph, "auto", &options, arena, &path, error)) return false;
    VisQuery *query = vis_query_new(&scene.graph, &scene.forest, arena);
    if (!gl_context_use(context, error)) return false;
    WalkRenderer *renderer = walk_renderer_new(&scene.graph, arena, error);
    if (!renderer) return false;
    const char *slash = strrchr(file, '/');
    bool good = true;
    for (int m = 0; m < VIS_METHODS && good; m++) {
        Sums s;
        good = measure(&scene, &path, a, (VisMethod)m, query, renderer, &s, error);
        if (!good) break;
        double n = s.frames;
        printf("%s,%s,%d,%d,%.1f,%.2f,%.2f,%.3f,%.1f,%.1f\n", slash ? slash + 1 : file, VIS_METHOD_NAMES[m],
               s.frames, scene.graph.polygon_count, s.polygons / n, s.cells / n, 1e6 * s.query / n,
               1e3 * s.frame / n, s.portals / n, s.objects / n);
        fflush(stdout);
    }
    walk_renderer_free(renderer);
    return good;
}

static bool bench_walk(const Arguments *a, Error *error) {
    static char office[] = "build/maps/office.plan";
    static char *usual[] = {office};
    char **files = a->file_count > 0 ? a->files : usual;
    int count = a->file_count > 0 ? a->file_count : 1;
    Arena arena = {0};
    GlContext *context = gl_context_open(&arena, error);
    bool good = context != NULL;
    if (good) {
        puts("building,method,frames,polygons_total,polygons_drawn_mean,cells_visible_mean,query_us_mean,"
             "frame_ms_mean,portals_tested_mean,objects_tested_mean");
    }
    for (int i = 0; i < count && good; i++) {
        Arena building = {0};
        good = bench_building(files[i], a, context, &building, error);
        arena_free(&building);
    }
    gl_context_close(context);
    arena_free(&arena);
    return good;
}

static const struct {
    const char *name;
    bool (*run)(const Arguments *a, Error *error);
} BENCHES[] = {{"walk", bench_walk}};

static int parse(int argc, char **argv, Arguments *a) {
    static const struct option options[] = {{"help", no_argument, NULL, 'h'},
                                            {"size", required_argument, NULL, 's'},
                                            {"frames", required_argument, NULL, 'f'},
                                            {"look", required_argument, NULL, 'l'},
                                            {0}};
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":h", options, NULL)) != -1;) {
        switch (c) {
        case 'h':
            a->help = true;
            return APP_GOOD;
        case 's':
            if (app_parse_size(optarg, &a->width, &a->height)) break;
            return app_misuse("bench", "bench: --size is `%s` (allowed WxH, 16 to 8192 each)", optarg);
        case 'f':
            if (app_parse_int(optarg, 1, 1000000, &a->frames)) break;
            return app_misuse("bench", "bench: --frames is `%s` (allowed 1 to 1000000)", optarg);
        case 'l':
            a->look = WALK_FAST;
            while (a->look < WALK_LOOKS && strcmp(WALK_LOOK_NAMES[a->look], optarg) != 0) a->look++;
            if (a->look < WALK_LOOKS) break;
            return app_misuse("bench", "bench: --look is `%s` (allowed fast, fine)", optarg);
        default:
            return app_misuse_option("bench", c, argv);
        }
    }
    if (optind == argc) return app_misuse("bench", "bench: which one? (allowed: walk)");
    a->name = argv[optind];
    a->files = argv + optind + 1;
    a->file_count = argc - optind - 1;
    return APP_GOOD;
}

int cmd_bench(int argc, char **argv) {
    Arguments a = {.width = 640, .height = 360, .frames = 200};
    int code = parse(argc, argv, &a);
    if (code != APP_GOOD) return code;
    if (a.help) {
        fputs(HELP, stdout);
        return APP_GOOD;
    }
    for (size_t i = 0; i < sizeof BENCHES / sizeof *BENCHES; i++) {
        if (strcmp(BENCHES[i].name, a.name) != 0) continue;
        Error error;
        return BENCHES[i].run(&a, &error) ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
    }
    return app_misuse("bench", "bench: there is no benchmark `%s` (allowed: walk)", a.name);
}
