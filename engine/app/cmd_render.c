// cmd_render.c - `enfilade render FILE`: a still by rays, with mirrors and glass.
#include <stddef.h>

#include "engine/app/render.h"

#define AT(field) offsetof(RenderArguments, field)
static const Option ROWS[] = {
    {.name = "o", .value = "OUT.png", .type = OPTION_TEXT, .at = AT(out), .help = "where to write"},
    OPTION_MAP(AT(load.map)),
    {.name = "view",
     .value = "NAME",
     .type = OPTION_TEXT,
     .at = AT(view),
     .help = "a stored viewpoint (default: the first, or where a walk begins)"},
    {.name = "eye",
     .value = "X,Y,Z",
     .type = OPTION_POINT,
     .at = AT(eye),
     .help = "from there instead, metres"},
    {.name = "look", .value = "X,Y,Z", .type = OPTION_POINT, .at = AT(look), .help = "towards this place"},
    {.name = "fov",
     .value = "DEG",
     .type = OPTION_DEGREES,
     .at = AT(fov),
     .low = 1,
     .high = 170,
     .help = "angle of view across, degrees, @ (default: the view's, or 70)"},
    {.name = "size",
     .value = "WxH",
     .type = OPTION_SIZE,
     .at = AT(size),
     .low = 16,
     .high = 8192,
     .help = "pixels, @ (default 1280x720)"},
    {.name = "samples",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(still.samples),
     .low = 1,
     .high = 4096,
     .help = "of a pixel, @ (default 16)"},
    {.name = "depth",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(still.depth),
     .low = 1,
     .high = 64,
     .help = "rays on top of one another in mirrors and glass, @ (default 12)"},
    {.name = "direct",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(still.direct),
     .names = STILL_DIRECT_NAMES,
     .name_count = STILL_DIRECTS,
     .help = "light straight from lamps: @ (default: rays, with sharp shadows, unless more than a quarter of "
             "all surfaces "
             "emit)"},
    {.name = "tree",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(still.tree),
     .names = STILL_TREE_NAMES,
     .name_count = STILL_TREES,
     .help = "the structure in which rays find surfaces: @ (default own, a hierarchy of boxes)"},
    {.name = "exposure",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(still.stops),
     .low = -EXPOSURE_STOPS_MOST,
     .high = EXPOSURE_STOPS_MOST,
     .help = "brighter by so many stops, @ (default 0)"},
    {.name = "light",
     .value = "FILE.rad",
     .type = OPTION_TEXT,
     .at = AT(load.light),
     .help = "the light that `enfilade bake` stored (default: FILE with the suffix .rad, or the light that "
             "`enfilade bake "
             "FILE` left in the user's cache)"},
    OPTION_MEMORY(AT(load.memory), "what fits the file to open it, then three quarters of the machine's"),
    OPTION_THREADS(AT(still.threads)),
    OPTION_JSON(AT(json)),
};
static const OptionTable OPTIONS =
    OPTION_TABLE("render", "FILE -o OUT.png [OPTIONS]",
                 "Draws a picture of a building by rays: mirrors, glass, curved shapes as they are, lamps "
                 "with sharp shadows, and the "
                 "light that `enfilade bake` found; where there is none it is baked first, and kept. The "
                 "same bytes come out on any "
                 "number of threads. Ctrl-C leaves no file.",
                 ROWS);

static int parse_render(int argc, char **argv, RenderArguments *a, bool *help) {
    bool given[sizeof ROWS / sizeof *ROWS] = {false};
    int code = options_parse_file(&OPTIONS, argc, argv, a, given, &a->file, help);
    if (code != APP_GOOD || *help) return code;
    a->from = options_given(&OPTIONS, given, "eye");
    a->towards = options_given(&OPTIONS, given, "look");
    a->widened = options_given(&OPTIONS, given, "fov");
    a->direct_given = options_given(&OPTIONS, given, "direct");
    if (!a->out) return app_misuse("render", "render: where to write is not said: give -o OUT.png");
    if (a->view && a->from) return app_misuse("render", "render: --view or --eye (one of them is allowed)");
    if (a->from && !a->towards) return app_misuse("render", "render: --eye needs --look X,Y,Z");
    return APP_GOOD;
}

int cmd_render(int argc, char **argv) {
    RenderArguments a = {.load = app_scene_options(), .size = {1280, 720}, .still = still_default_options()};
    bool help = false;
    int code = parse_render(argc, argv, &a, &help);
    if (help) options_print_help(&OPTIONS);
    return code != APP_GOOD || help ? code : render(&a);
}
