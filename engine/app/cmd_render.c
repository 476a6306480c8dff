// cmd_render.c - `enfilade render FILE`: a still by rays, with mirrors and glass.
#include <getopt.h>
#include <stdio.h>

#include "engine/app/render.h"

static const char HELP[] =
    "usage: enfilade render FILE -o OUT.png [OPTIONS]\n\n"
    "Draws a picture of a building by rays: mirrors, glass, curved shapes as they are, lamps with sharp "
    "shadows, "
    "and\n"
    "the light that `enfilade bake` found; where there is none it is baked first, and kept. The same bytes "
    "come "
    "out\n"
    "on any number of threads. Ctrl-C leaves no file.\n\n"
    "  -o OUT.png        where to write\n"
    "  --map NAME        which one of a file that holds several maps (default: the first)\n"
    "  --view NAME       a stored viewpoint (default: the first, or where a walk begins)\n"
    "  --eye X,Y,Z       from there instead, metres\n"
    "  --look X,Y,Z      towards this place\n"
    "  --fov DEG         angle of view across, degrees, 1 to 170 (default: the view's, or 70)\n"
    "  --size WxH        pixels, 16 to 8192 each (default 1280x720)\n"
    "  --samples N       of a pixel, 1 to 4096 (default 16)\n"
    "  --depth N         rays on top of one another in mirrors and glass, 1 to 64 (default 12)\n"
    "  --direct NAME     light straight from lamps: rays, with sharp shadows, or baked (default: rays, "
    "unless more\n"
    "                    than a quarter of all surfaces emit)\n"
    "  --tree NAME       what finds where rays hit: own (default), a hierarchy of boxes, or grid\n"
    "  --exposure S      brighter by so many stops, -8 to 8 (default 0)\n"
    "  --light FILE.rad  the light that `enfilade bake` stored (default: FILE with the suffix .rad, or what "
    "`enfilade\n"
    "                    bake FILE` left in the user's cache)\n"
    "  --memory MB       memory that may be used, 16 to 1000000 (default: what fits the file to open it, "
    "then "
    "three\n"
    "                    quarters of the machine's)\n"
    "  --threads N       1 to 256 (default: all cores)\n"
    "  --json            one JSON object on standard output\n";

enum {
    MAP = 256,
    MEMORY,
    VIEW,
    EYE,
    LOOK,
    FOV,
    SIZE,
    SAMPLES,
    DEPTH,
    DIRECT,
    TREE,
    EXPOSURE,
    LIGHT,
    THREADS
};

static const struct option OPTIONS[] = {{"json", no_argument, NULL, 'j'},
                                        {"help", no_argument, NULL, 'h'},
                                        {"map", required_argument, NULL, MAP},
                                        {"memory", required_argument, NULL, MEMORY},
                                        {"view", required_argument, NULL, VIEW},
                                        {"eye", required_argument, NULL, EYE},
                                        {"look", required_argument, NULL, LOOK},
                                        {"fov", required_argument, NULL, FOV},
                                        {"size", required_argument, NULL, SIZE},
                                        {"samples", required_argument, NULL, SAMPLES},
                                        {"depth", required_argument, NULL, DEPTH},
                                        {"direct", required_argument, NULL, DIRECT},
                                        {"tree", required_argument, NULL, TREE},
                                        {"exposure", required_argument, NULL, EXPOSURE},
                                        {"light", required_argument, NULL, LIGHT},
                                        {"threads", required_argument, NULL, THREADS},
                                        {0}};

typedef struct Arguments {
    RenderArguments render;
    bool help;
} Arguments;

static int misuse(const char *option, const char *allowed) {
    return app_misuse("render", "render: %s is `%s` (allowed %s)", option, optarg, allowed);
}

static int parse_whole(const char *option, int low, int high, int *out) {
    if (app_parse_int(optarg, low, high, out)) return APP_GOOD;
    char allowed[64];
    snprintf(allowed, sizeof allowed, "%d to %d", low, high);
    return misuse(option, allowed);
}

static int parse_camera(int c, RenderArguments *r) {
    double degrees;
    switch (c) {
    case VIEW:
        r->view = optarg;
        return APP_GOOD;
    case EYE:
        r->from = true;
        return app_parse_point(optarg, &r->eye) ? APP_GOOD : misuse("--eye", "X,Y,Z");
    case LOOK:
        r->towards = true;
        return app_parse_point(optarg, &r->look) ? APP_GOOD : misuse("--look", "X,Y,Z");
    case FOV:
        if (!app_parse_number(optarg, 1, 170, &degrees)) return misuse("--fov", "1 to 170 degrees");
        r->fov = degrees * (M_PI / 180);
        r->widened = true;
        return APP_GOOD;
    default:
        return app_parse_size(optarg, &r->width, &r->height) ? APP_GOOD
                                                             : misuse("--size", "WxH, 16 to 8192 each");
    }
}

static int parse_still(int c, RenderArguments *r) {
    StillOptions *s = &r->still;
    int name = 0, code;
    switch (c) {
    case SAMPLES:
        return parse_whole("--samples", 1, 4096, &s->samples);
    case DEPTH:
        return parse_whole("--depth", 1, 64, &s->depth);
    case THREADS:
        return parse_whole("--threads", 1, 256, &s->threads);
    case DIRECT:
        code = app_parse_name("render", "--direct", optarg, STILL_DIRECT_NAMES, STILL_DIRECTS, &name);
        s->direct = (StillDirect)name;
        r->direct_given = true;
        return code;
    case TREE:
        code = app_parse_name("render", "--tree", optarg, STILL_TREE_NAMES, STILL_TREES, &name);
        s->tree = (StillTree)name;
        return code;
    default:
        if (app_parse_number(optarg, -EXPOSURE_STOPS_MOST, EXPOSURE_STOPS_MOST, &s->stops)) return APP_GOOD;
        return misuse("--exposure", "-8 to 8 stops");
    }
}

static int take(int c, char **argv, Arguments *a) {
    switch (c) {
    case 'h':
        a->help = true;
        return APP_GOOD;
    case 'j':
        a->render.json = true;
        return APP_GOOD;
    case 'o':
        a->render.out = optarg;
        return APP_GOOD;
    case MAP:
        a->render.map = optarg;
        return APP_GOOD;
    case MEMORY:
        return app_take_memory("render", optarg);
    case LIGHT:
        a->render.light = optarg;
        return APP_GOOD;
    case ':':
    case '?':
        return app_misuse_option("render", c, argv);
    default:
        return c >= VIEW && c <= SIZE ? parse_camera(c, &a->render) : parse_still(c, &a->render);
    }
}

static int parse(int argc, char **argv, Arguments *a) {
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":ho:", OPTIONS, NULL)) != -1;) {
        int code = take(c, argv, a);
        if (code != APP_GOOD || a->help) return code;
    }
    if (argc - optind != 1)
        return app_misuse("render", "render: one building file is needed, %d were given", argc - optind);
    a->render.file = argv[optind];
    if (!a->render.out) return app_misuse("render", "render: where to write is not said: give -o OUT.png");
    if (a->render.view && a->render.from)
        return app_misuse("render", "render: --view or --eye (one of them is allowed)");
    if (a->render.from && !a->render.towards) return app_misuse("render", "render: --eye needs --look X,Y,Z");
    return APP_GOOD;
}

int cmd_render(int argc, char **argv) {
    Arguments a = {.render = {.width = 1280, .height = 720, .still = still_default_options()}};
    int code = parse(argc, argv, &a);
    if (code != APP_GOOD) return code;
    if (a.help) {
        fputs(HELP, stdout);
        return APP_GOOD;
    }
    return render(&a.render);
}
