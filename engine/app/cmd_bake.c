// cmd_bake.c - `enfilade bake FILE`: computes the light of a building by radiosity, and stores it.
#include <getopt.h>
#include <stdio.h>
#include <strings.h>

#include "engine/app/app.h"
#include "engine/app/bake.h"
#include "visibility/hidden/hidden.h"

static const char HELP[] =
    "usage: enfilade bake FILE [-o OUT.rad] [-o OUT.glb] [OPTIONS]\n\n"
    "Computes the light of a building by radiosity: its polygons are cut into elements, patches of elements "
    "shoot\n"
    "the light they have, the strongest first, until little is left. Only what the stab tree of a patch's "
    "cell "
    "lets\n"
    "it see is looked at. The light is stored in OUT.rad, or in the user's cache. The same bytes come out on "
    "any\n"
    "number of threads, and with culling or without. Ctrl-C stops early and stores what there is.\n\n"
    "  --map NAME        which one of a file that holds several maps (default: the first)\n"
    "  -o OUT.rad        where to write\n"
    "  -o OUT.glb        a model for Blender and browsers, its light in the colours of its vertices; without "
    "-o OUT.rad\n"
    "                    the light is stored there alone\n"
    "  --resume          go on from what is there, made with the same elements and doors\n"
    "  --doors STATE     drawn (default), open or closed\n"
    "  --sky L           daylight: a sky of radiance L, or R,G,B, W/m^2/sr, 0 to 1e6, the same all over "
    "(default 0)\n"
    "  --element M       edge of an element aimed at, metres, 0.01 to 100 (default: for about 60,000, 0.15 "
    "to 0.33)\n"
    "  --per-patch K     elements along the side of a patch, 1 to 16 (default 2)\n"
    "  --refine S        elements are small where light changes, large where it is even: S times as many as "
    "there\n"
    "                    would be if all were alike, 0 to 100; 0: all are alike (default 0.4)\n"
    "  --smallest M      edge of the smallest elements, metres, 0.01 to 100 (default 0.06)\n"
    "  --close M         elements are cut along what stands on a face, or so near to it, metres, 0 (nothing) "
    "to "
    "1\n"
    "                    (default 0.05)\n"
    "  --reach R         elements within so many radii of a patch have light of all of it, not of its "
    "centre,\n"
    "                    0 to 100 (default 2)\n"
    "  --proxies M       fine furniture is lit by coarse stand-ins whose outlines are within M metres of it, "
    "0.001 to\n"
    "                    0.1, or off (default 0.0125)\n"
    "  --residual E      stop when this share of the light is left to shoot, 1e-9 to 1 (default 0.001; with "
    "fewer\n"
    "                    than 10000 patches 0.0003, with fewer than 4000 0.0001)\n"
    "  --shots N         stop when so many were shot, those of a run that is resumed included\n"
    "  --seconds S       stop after S seconds of shooting, 0.001 to 1e6\n"
    "  --final-gather    then gather the light at every vertex once more, from all that it sees: sharper "
    "shadows, "
    "for\n"
    "                    about half a millisecond each\n"
    "  --method NAME     how form factors are found (default hemisphere); below\n"
    "  --resolution R    pixels, lines or rays across, 8 to 2000 (default 80; with fewer patches, as above, "
    "141, 200)\n"
    "  --hidden NAME     what fills the sides of `hemicube`: one of the hidden-surface methods below "
    "(default: "
    "its own)\n"
    "  --culling NAME    what is left out: none, depth (what lies behind things), and that with cells, plan\n"
    "                    (Oki's), portals (default); the result is the same\n"
    "  --no-cull         --culling none\n"
    "  --threads N       1 to 256 (default: all cores)\n"
    "  --memory MB       memory that may be used, 16 to 1000000 (default: what fits the file to open it, "
    "then "
    "three\n"
    "                    quarters of the machine's)\n"
    "  --row-memory MB   rows of form factors kept for patches that shoot again, 0 to 1000000 (default 128)\n"
    "  --probe P         X,Y,Z,NX,NY,NZ: the light at a point, on a line `x y z nx ny nz HR HG HB BR BG BB`: "
    "what\n"
    "                    arrives, W/m^2, and what leaves the face it lies on; may be given several times\n"
    "  --probes FILE     as many as there are lines in FILE, or points in a .quads file\n"
    "  --json            one JSON object on standard output\n\n"
    "Lights are polygons that emit. A lamp whose model has none gets a square beneath it, or above where its "
    "light\n"
    "sits in its upper half; a light without a lamp becomes a small cube.\n\n"
    "form factors:\n";

enum {
    RESUME = 256,
    DOORS,
    ELEMENT,
    PER_PATCH,
    RESIDUAL,
    SHOTS,
    SECONDS,
    FINAL_GATHER,
    METHOD,
    HIDDEN,
    RESOLUTION,
    CULLING,
    REACH,
    REFINE,
    SMALLEST,
    CLOSE,
    NO_CULL,
    ROW_MEMORY,
    MEMORY,
    PROBE,
    PROBES,
    SKY,
    PROXIES,
};

static const struct option OPTIONS[] = {{"json", no_argument, NULL, 'j'},
                                        {"help", no_argument, NULL, 'h'},
                                        {"map", required_argument, NULL, 'm'},
                                        {"threads", required_argument, NULL, 't'},
                                        {"resume", no_argument, NULL, RESUME},
                                        {"doors", required_argument, NULL, DOORS},
                                        {"element", required_argument, NULL, ELEMENT},
                                        {"per-patch", required_argument, NULL, PER_PATCH},
                                        {"residual", required_argument, NULL, RESIDUAL},
                                        {"shots", required_argument, NULL, SHOTS},
                                        {"seconds", required_argument, NULL, SECONDS},
                                        {"final-gather", no_argument, NULL, FINAL_GATHER},
                                        {"method", required_argument, NULL, METHOD},
                                        {"hidden", required_argument, NULL, HIDDEN},
                                        {"resolution", required_argument, NULL, RESOLUTION},
                                        {"culling", required_argument, NULL, CULLING},
                                        {"reach", required_argument, NULL, REACH},
                                        {"refine", required_argument, NULL, REFINE},
                                        {"smallest", required_argument, NULL, SMALLEST},
                                        {"close", required_argument, NULL, CLOSE},
                                        {"proxies", required_argument, NULL, PROXIES},
                                        {"no-cull", no_argument, NULL, NO_CULL},
                                        {"row-memory", required_argument, NULL, ROW_MEMORY},
                                        {"memory", required_argument, NULL, MEMORY},
                                        {"probe", required_argument, NULL, PROBE},
                                        {"probes", required_argument, NULL, PROBES},
                                        {"sky", required_argument, NULL, SKY},
                                        {0}};

typedef struct Arguments {
    BakeArguments bake;
    Arena arena;
    bool help;
} Arguments;

static int parse_number(const char *option, double low, double high, double *out) {
    if (app_parse_number(optarg, low, high, out)) return APP_GOOD;
    return app_misuse("bake", "bake: %s is `%s` (allowed %g to %g)", option, optarg, low, high);
}

static int parse_whole(const char *option, int low, int high, int *out) {
    if (app_parse_int(optarg, low, high, out)) return APP_GOOD;
    return app_misuse("bake", "bake: %s is `%s` (allowed %d to %d)", option, optarg, low, high);
}

static int parse_probes(bool file, Arguments *a) {
    Error error;
    if (file) a->bake.probe_file = optarg;
    bool good = file ? bake_probes_read(optarg, &a->arena, &a->bake.probes, &error)
                     : bake_probe_parse(optarg, &a->arena, &a->bake.probes, &error);
    if (good) return APP_GOOD;
    return file ? app_fail(APP_BAD_INPUT, "%s", error.text) : app_misuse("bake", "bake: %s", error.text);
}

static int parse_method(RadOptions *rad) {
    rad->method = form_factor_method(optarg);
    if (rad->method) return APP_GOOD;
    return app_misuse("bake", "bake: --method is `%s` (see --help for those allowed)", optarg);
}

static int parse_hidden(RadOptions *rad) {
    rad->form_factor.hidden = optarg;
    if (hidden_find(optarg)) return APP_GOOD;
    return app_misuse("bake", "bake: --hidden is `%s` (see --help for those allowed)", optarg);
}

static int parse_proxies(double *out) {
    *out = 0;
    if (strcmp(optarg, "off") == 0 || app_parse_number(optarg, 0.001, 0.1, out)) return APP_GOOD;
    return app_misuse("bake", "bake: --proxies is `%s` (allowed 0.001 to 0.1, or off)", optarg);
}

// What says how light is found.
static int parse_light(int c, char **argv, Arguments *a) {
    BakeArguments *b = &a->bake;
    RadOptions *rad = &b->rad;
    int number = 0, code = APP_GOOD;
    switch (c) {
    case METHOD:
        return parse_method(rad);
    case HIDDEN:
        return parse_hidden(rad);
    case RESOLUTION:
        return parse_whole("--resolution", 8, 2000, &rad->form_factor.resolution);
    case CULLING:
        code = app_parse_name("bake", "--culling", optarg, VIEW_CULLING_NAMES, VIEW_CULLINGS, &number);
        if (code == APP_GOOD) rad->culling = (ViewCulling)number;
        return code;
    case NO_CULL:
        rad->culling = CULL_NOTHING;
        return code;
    case REFINE:
        return parse_number("--refine", 0, 100, &a->bake.adapt.share);
    case SMALLEST:
        return parse_number("--smallest", 0.01, 100, &a->bake.adapt.smallest);
    case CLOSE:
        return parse_number("--close", 0, 1, &a->bake.mesh.close);
    case PROXIES:
        return parse_proxies(&b->mesh.proxy);
    case REACH:
        return parse_number("--reach", 0, 100, &rad->reach);
    case RESIDUAL:
        return parse_number("--residual", 1e-9, 1, &rad->residual);
    case SHOTS:
        code = parse_whole("--shots", 1, INT32_MAX, &number);
        rad->shots = number;
        return code;
    case SECONDS:
        return parse_number("--seconds", 0.001, 1e6, &rad->seconds);
    case ROW_MEMORY:
        code = parse_whole("--row-memory", 0, 1000000, &number);
        rad->row_bytes = (size_t)number << 20;
        return code;
    default:
        return app_misuse_option("bake", c, argv);
    }
}

static bool is_model(const char *path) {
    size_t length = strlen(path);
    return length > 4 && strcasecmp(path + length - 4, ".glb") == 0;
}

static int parse_option(int c, char **argv, Arguments *a) {
    BakeArguments *b = &a->bake;
    switch (c) {
    case 'j':
        b->json = true;
        return APP_GOOD;
    case 'h':
        a->help = true;
        return APP_GOOD;
    case 'm':
        b->load.map = optarg;
        return APP_GOOD;
    case 'o':
        *(is_model(optarg) ? &b->model : &b->out) = optarg;
        return APP_GOOD;
    case 't':
        b->rad.threads = b->load.vis.threads = 1;
        if (parse_whole("--threads", 1, 256, &b->rad.threads) != APP_GOOD) return APP_BAD_USE;
        b->load.vis.threads = b->rad.threads;
        return APP_GOOD;
    case RESUME:
        b->resume = true;
        return APP_GOOD;
    case FINAL_GATHER:
        b->final_gather = true;
        return APP_GOOD;
    case DOORS:
        return app_parse_name("bake", "--doors", optarg, BAKE_DOORS_NAMES, BAKE_DOORS, &b->doors);
    case ELEMENT:
        return parse_number("--element", 0.01, 100, &b->mesh.element);
    case PER_PATCH:
        return parse_whole("--per-patch", 1, 16, &b->mesh.per_patch);
    case SKY:
        if (app_parse_sky(optarg, b->sky)) return APP_GOOD;
        return app_misuse("bake", "bake: --sky is `%s` (allowed L or R,G,B, 0 to 1e6 each)", optarg);
    case MEMORY:
        return app_take_memory("bake", optarg);
    case PROBE:
    case PROBES:
        return parse_probes(c == PROBES, a);
    default:
        return parse_light(c, argv, a);
    }
}

static int parse(int argc, char **argv, Arguments *a) {
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":ho:", OPTIONS, NULL)) != -1;) {
        int code = parse_option(c, argv, a);
        if (code != APP_GOOD || a->help) return code;
    }
    if (argc - optind != 1)
        return app_misuse("bake", "bake: one building file is needed, %d were given", argc - optind);
    a->bake.file = argv[optind];
    if (a->bake.rad.form_factor.hidden && strcmp(a->bake.rad.method->name, "hemicube") != 0)
        return app_misuse("bake", "bake: --hidden fills the sides of a hemicube: give --method hemicube");
    return APP_GOOD;
}

static void print_help(void) {
    fputs(HELP, stdout);
    for (int i = 0; FORM_FACTOR_METHODS[i]; i++)
        printf("  %-24s  %s\n", FORM_FACTOR_METHODS[i]->name, FORM_FACTOR_METHODS[i]->summary);
    printf("\nhidden surfaces:\n");
    for (int i = 0; HIDDEN_METHODS[i]; i++)
        printf("  %-24s  %s\n", HIDDEN_METHODS[i]->name, HIDDEN_METHODS[i]->summary);
}

int cmd_bake(int argc, char **argv) {
    Arguments a = {.bake = bake_default_arguments()};
    int code = parse(argc, argv, &a);
    if (code == APP_GOOD && a.help) print_help();
    if (code == APP_GOOD && !a.help) code = bake(&a.bake);
    arena_free(&a.arena);
    return code;
}
