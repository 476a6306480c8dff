// cmd_bake.c - `enfilade bake FILE`: computes the light of a building by radiosity, and stores it.
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <strings.h>

#include "engine/app/app.h"
#include "engine/app/bake.h"
#include "visibility/hidden/hidden.h"

typedef struct Arguments {
    BakeArguments to;
    Arena arena;
    bool no_cull;
} Arguments;

// ---- values of their own

static int wrong(Error *error, const char *allowed) {
    error_set(error, "%s", allowed);
    return APP_BAD_USE;
}

static int take_output(const char *path, void *arguments, Error *error) {
    BakeArguments *a = &((Arguments *)arguments)->to;
    size_t length = strlen(path);
    bool model = length > 4 && strcasecmp(path + length - 4, ".glb") == 0;
    (void)error;
    *(model ? &a->model : &a->out) = path;
    return APP_GOOD;
}

static int take_proxies(const char *text, void *arguments, Error *error) {
    char *end;
    double width = strcmp(text, "off") == 0 ? 0 : strtod(text, &end);
    if (width != 0 || strcmp(text, "off") != 0)
        if (end == text || *end || !(width >= 0.001 && width <= 0.1))
            return wrong(error, "0.001 to 0.1, or off");
    ((Arguments *)arguments)->to.bake.mesh.proxy = width;
    return APP_GOOD;
}

static int take_shots(const char *text, void *arguments, Error *error) {
    char *end;
    long shots = strtol(text, &end, 10);
    if (end == text || *end || shots < 1 || shots > INT32_MAX) return wrong(error, "1 to 2147483647");
    ((Arguments *)arguments)->to.bake.rad.shots = shots;
    return APP_GOOD;
}

static int take_method(const char *name, void *arguments, Error *error) {
    RadOptions *rad = &((Arguments *)arguments)->to.bake.rad;
    rad->method = form_factor_method(name);
    return rad->method ? APP_GOOD : wrong(error, "those that --help lists");
}

static int take_hidden(const char *name, void *arguments, Error *error) {
    ((Arguments *)arguments)->to.bake.rad.form_factor.hidden = name;
    return hidden_find(name) ? APP_GOOD : wrong(error, "those that --help lists");
}

static int take_probe(const char *text, void *arguments, Error *error) {
    Arguments *a = arguments;
    Error reason;
    (void)error;
    if (bake_probe_parse(text, &a->arena, &a->to.probes, &reason)) return APP_GOOD;
    return app_misuse("bake", "bake: %s", reason.text);
}

static int take_probes(const char *file, void *arguments, Error *error) {
    Arguments *a = arguments;
    Error reason;
    (void)error;
    a->to.probe_file = file;
    if (bake_probes_read(file, &a->arena, &a->to.probes, &reason)) return APP_GOOD;
    return app_fail(APP_BAD_INPUT, "%s", reason.text);
}

// ---- the table

#define AT(field) offsetof(Arguments, to.field)
static const Option ROWS[] = {
    OPTION_MAP(AT(load.map)),
    {.name = "o",
     .value = "OUT.rad",
     .type = OPTION_OTHER,
     .take = take_output,
     .help = "where to write (default: the user's cache); with OUT.glb, a model for Blender and browsers "
             "with its light in the colours of its vertices; both may be given"},
    {.name = "resume",
     .type = OPTION_FLAG,
     .at = AT(resume),
     .help = "go on from the light that is there, made with the same elements and doors"},
    {.name = "doors",
     .value = "STATE",
     .type = OPTION_NAME,
     .at = AT(bake.doors),
     .names = BAKE_DOORS_NAMES,
     .name_count = BAKE_DOORS,
     .help = "@ (default drawn)"},
    {.name = "sky",
     .value = "L",
     .type = OPTION_SKY,
     .at = AT(bake.sky),
     .high = 1e6,
     .help = "daylight: a sky of that radiance, W/m^2/sr, the same all over; @ (default 0)"},
    {.name = "element",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(bake.mesh.element),
     .low = 0.01,
     .high = 100,
     .help = "edge of an element aimed at, metres, @ (default: for about 60,000, 0.15 to 0.33)"},
    {.name = "per-patch",
     .value = "K",
     .type = OPTION_INT,
     .at = AT(bake.mesh.per_patch),
     .low = 1,
     .high = 16,
     .help = "elements along the side of a patch, @ (default 2)"},
    {.name = "refine",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(bake.adapt.share),
     .high = 100,
     .help = "elements are small where light changes, large where it is even: S times as many as there would "
             "be if all were alike, @; 0: all are alike (default 0.4)"},
    {.name = "smallest",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(bake.adapt.smallest),
     .low = 0.01,
     .high = 100,
     .help = "edge of the smallest elements, metres, @ (default 0.06)"},
    {.name = "close",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(bake.mesh.close),
     .high = 1,
     .help = "elements are cut along things that stand on a face or this near to it, metres, @; 0: along "
             "none (default 0.05)"},
    {.name = "reach",
     .value = "R",
     .type = OPTION_NUMBER,
     .at = AT(bake.rad.reach),
     .high = 100,
     .help = "elements within so many radii of a patch have light of all of it, not of its centre, @ "
             "(default 2)"},
    {.name = "proxies",
     .value = "M",
     .type = OPTION_OTHER,
     .take = take_proxies,
     .help = "fine furniture is lit by coarse stand-ins whose outlines are within M metres of it, 0.001 to "
             "0.1, or off (default 0.0125)"},
    {.name = "residual",
     .value = "E",
     .type = OPTION_NUMBER,
     .at = AT(bake.rad.residual),
     .low = 1e-9,
     .high = 1,
     .help = "stop when this share of the light is left to shoot, @ (default 0.001; with fewer than 10000 "
             "patches 0.0003, with fewer than 4000 0.0001)"},
    {.name = "shots",
     .value = "N",
     .type = OPTION_OTHER,
     .take = take_shots,
     .help = "stop when so many were shot, those of a run that is resumed included"},
    {.name = "seconds",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(seconds),
     .low = 0.001,
     .high = 1e6,
     .help = "stop after S seconds of shooting, @"},
    {.name = "final-gather",
     .type = OPTION_FLAG,
     .at = AT(final_gather),
     .help = "then gather the light at every vertex once more, from all that it sees: sharper shadows, for "
             "about half a millisecond each"},
    {.name = "method",
     .value = "NAME",
     .type = OPTION_OTHER,
     .take = take_method,
     .help = "how form factors are found (default hemisphere); below"},
    {.name = "resolution",
     .value = "R",
     .type = OPTION_INT,
     .at = AT(bake.rad.form_factor.resolution),
     .low = 8,
     .high = 2000,
     .help = "pixels, lines or rays across, @ (default 80; with fewer patches, as above, 141, 200)"},
    {.name = "hidden",
     .value = "NAME",
     .type = OPTION_OTHER,
     .take = take_hidden,
     .help = "how the sides of `hemicube` are filled: one of the hidden-surface methods below (default: its "
             "own)"},
    {.name = "culling",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(bake.rad.culling),
     .names = VIEW_CULLING_NAMES,
     .name_count = VIEW_CULLINGS,
     .help = "polygons that are left out: @ (default portals); depth: those behind things; cells, plan "
             "(Oki), portals: also those that the cells exclude; the result is the same"},
    {.name = "no-cull", .type = OPTION_FLAG, .at = offsetof(Arguments, no_cull), .help = "--culling none"},
    OPTION_THREADS(AT(bake.rad.threads)),
    OPTION_MEMORY(AT(load.memory), "what fits the file to open it, then three quarters of the machine's"),
    {.name = "row-memory",
     .value = "MB",
     .type = OPTION_MEGABYTES,
     .at = AT(bake.rad.row_bytes),
     .high = 1000000,
     .help = "rows of form factors kept for patches that shoot again, @ (default 128)"},
    {.name = "probe",
     .value = "P",
     .type = OPTION_OTHER,
     .take = take_probe,
     .help = "X,Y,Z,NX,NY,NZ: the light at a point, on a line `x y z nx ny nz HR HG HB BR BG BB`: the light "
             "that arrives, W/m^2, and the light that leaves the face on which the point lies; may be given "
             "several times"},
    {.name = "probes",
     .value = "FILE",
     .type = OPTION_OTHER,
     .take = take_probes,
     .help = "as many as there are lines in FILE, or points in a .quads file"},
    OPTION_JSON(AT(json)),
};
static const OptionTable OPTIONS = OPTION_TABLE(
    "bake", "FILE [-o OUT.rad] [-o OUT.glb] [OPTIONS]",
    "Computes the light of a building by radiosity: its polygons are cut into elements, patches of elements "
    "shoot the "
    "light they have, the strongest first, until little is left. Only polygons that the stab tree of a "
    "patch's cell "
    "lets the patch see are looked at. The light is stored in OUT.rad, or in the user's cache. The same "
    "bytes come out on "
    "any number of threads, and with culling or without. Ctrl-C stops early and stores the light so far.",
    ROWS);

static int parse_bake(int argc, char **argv, Arguments *a, bool *help) {
    BakeArguments *b = &a->to;
    int code = options_parse_file(&OPTIONS, argc, argv, a, NULL, &b->file, help);
    if (code != APP_GOOD || *help) return code;
    if (a->no_cull) b->bake.rad.culling = CULL_NOTHING;
    b->load.vis.threads = b->bake.rad.threads;
    if (b->bake.rad.form_factor.hidden && strcmp(b->bake.rad.method->name, "hemicube") != 0)
        return app_misuse("bake", "bake: --hidden fills the sides of a hemicube: give --method hemicube");
    return APP_GOOD;
}

static void print_bake_help(void) {
    options_print_help(&OPTIONS);
    putchar('\n');
    options_print_paragraph(
        "Lights are polygons that emit. A lamp whose model has none gets a square beneath it, or above where "
        "its light sits in its upper half; a light without a lamp becomes a small cube.\n\nform factors:",
        0, 0);
    for (int i = 0; FORM_FACTOR_METHODS[i]; i++)
        printf("  %-24s  %s\n", FORM_FACTOR_METHODS[i]->name, FORM_FACTOR_METHODS[i]->summary);
    printf("\nhidden surfaces:\n");
    for (int i = 0; HIDDEN_METHODS[i]; i++)
        printf("  %-24s  %s\n", HIDDEN_METHODS[i]->name, HIDDEN_METHODS[i]->summary);
}

int cmd_bake(int argc, char **argv) {
    Arguments a = {.to = bake_default_arguments()};
    bool help = false;
    int code = parse_bake(argc, argv, &a, &help);
    if (help) print_bake_help();
    if (code == APP_GOOD && !help) code = bake(&a.to);
    arena_free(&a.arena);
    return code;
}
