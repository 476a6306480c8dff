// cmd_plan.c - `enfilade plan FILE`: the plan of a storey as SVG, and the stab tree and sightlines from a place.
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/app.h"
#include "engine/core/file.h"
#include "visibility/prepare/figure.h"

static const char HELP[] =
    "usage: enfilade plan FILE [--map NAME] [-o OUT.svg] [--from X,Y,Z] [--storey N] [--depth N] [--width "
    "PIXELS]\n"
    "                     [--memory MB]\n\n"
    "Draws the plan of a storey: cells, walls, portals, doors with their swing, windows. With --from, also "
    "the stab\n"
    "tree of the cell at that place (metres): the cells it may see, shaded by depth, a sightline into each "
    "room, and\n"
    "the tree itself below.\n\n"
    "  --map NAME      which one of a file that holds several maps (default: the first)\n"
    "  -o OUT.svg      where to write (default: standard output)\n"
    "  --from X,Y,Z    the place to look from\n"
    "  --storey N      which storey, from 0 (default: that of --from, or 0)\n"
    "  --depth N       levels of the tree to draw, 1 to 64 (default 8)\n"
    "  --width PIXELS  of the drawing, 100 to 10000 (default 1200)\n"
    "  --memory MB     memory that may be used, 16 to 1000000 (default: what fits the file)\n";

typedef struct Arguments {
    const char *file, *out, *map;
    bool from_given, help;
    Vec3 from;
    int storey, depth, width;
} Arguments;

static int parse(int argc, char **argv, Arguments *a) {
    static const struct option options[] = {
        {"help", no_argument, NULL, 'h'},         {"from", required_argument, NULL, 'f'},
        {"storey", required_argument, NULL, 's'}, {"depth", required_argument, NULL, 'd'},
        {"width", required_argument, NULL, 'w'},  {"map", required_argument, NULL, 'm'},
        {"memory", required_argument, NULL, 'y'}, {0}};
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":ho:", options, NULL)) != -1;) {
        switch (c) {
        case 'h':
            a->help = true;
            return APP_GOOD;
        case 'm':
            a->map = optarg;
            break;
        case 'y':
            if (app_take_memory("plan", optarg) != APP_GOOD) return APP_BAD_USE;
            break;
        case 'o':
            a->out = optarg;
            break;
        case 'f':
            a->from_given = true;
            if (app_parse_point(optarg, &a->from)) break;
            return app_misuse("plan", "plan: --from is `%s` (three numbers are needed: X,Y,Z in metres)",
                              optarg);
        case 's':
            if (app_parse_int(optarg, 0, 1000, &a->storey)) break;
            return app_misuse("plan", "plan: --storey is `%s` (allowed 0 to 1000)", optarg);
        case 'd':
            if (app_parse_int(optarg, 1, 64, &a->depth)) break;
            return app_misuse("plan", "plan: --depth is `%s` (allowed 1 to 64)", optarg);
        case 'w':
            if (app_parse_int(optarg, 100, 10000, &a->width)) break;
            return app_misuse("plan", "plan: --width is `%s` (allowed 100 to 10000)", optarg);
        default:
            return app_misuse_option("plan", c, argv);
        }
    }
    if (argc - optind != 1)
        return app_misuse("plan", "plan: one building file is needed, %d were given", argc - optind);
    a->file = argv[optind];
    return APP_GOOD;
}

// All that is indoors, with a margin for the nearest outdoors.
static Box figure_bounds(const CellGraph *graph) {
    Box box = box_empty();
    for (int c = 0; c < graph->cell_count; c++) {
        if (vis_region(graph, c)->kind != REGION_OUTDOORS) {
            box = box_union(box, graph->cells[c].box);
        }
    }
    return box_grow(box_is_empty(box) ? graph->box : box, 1.0);
}

// Where the plan is cut: over the floor of the storey, or, of a building without storeys, as low about the eye.
static bool cut_height(const Arguments *a, const CellGraph *graph, int root, double *out, Error *error) {
    static const double CUT = 1.2, EYE = 1.6;  // metres above the floor
    const Building *b = graph->building;
    int storey = a->storey;
    if (b->storey_count == 0) {
        if (storey >= 0)
            return error_set(error, "%s: has no storeys (--storey is for plans and homes)", a->file);
        *out = (a->from_given ? a->from.z : b->start.z) - (EYE - CUT);
        return true;
    }
    if (storey < 0) storey = root >= 0 ? (int)fmax(vis_region(graph, root)->storey, 0) : 0;
    if (storey >= b->storey_count) {
        return error_set(error, "%s: has no storey %d (allowed 0 to %d)", a->file, storey,
                         b->storey_count - 1);
    }
    *out = b->storeys[storey].floor + fmin(CUT, b->storeys[storey].height / 2);
    return true;
}

static bool draw_figure(const Arguments *a, const AppScene *scene, Arena *arena, const char **svg_text,
                        Error *error) {
    const CellGraph *graph = &scene->graph;
    int root = a->from_given ? vis_locate(graph, a->from, -1) : -1;
    if (a->from_given && root < 0) {
        return error_set(error, "%s: there is no cell at (%g, %g, %g): it lies in a wall or outside", a->file,
                         a->from.x, a->from.y, a->from.z);
    }
    double z = 0;
    if (!cut_height(a, graph, root, &z, error)) return false;
    Box plan = figure_bounds(graph), whole = plan;
    double tree_height = 0.5 * (plan.max.x - plan.min.x);
    if (root >= 0) whole.min.y -= tree_height;
    SvgDrawing *svg = svg_begin(arena, whole, a->width);
    Draw draw = svg_draw(svg);
    figure_ground(graph, z, &draw);
    if (root >= 0) figure_seen(graph, &scene->forest, root, z, &draw);
    figure_lines(graph, z, &draw);
    if (root >= 0) {
        DrawStyle paper = {.fill = 0xffffff, .fill_opacity = 1};
        Vec2 sheet[4] = {{whole.min.x, whole.min.y},
                         {whole.max.x, whole.min.y},
                         {whole.max.x, plan.min.y},
                         {whole.min.x, plan.min.y}};
        draw.polygon(draw.context, sheet, 4, &paper);
        Box area = {{whole.min.x + 0.2, whole.min.y + 0.4, 0}, {whole.max.x - 0.2, plan.min.y - 0.4, 0}};
        figure_tree(graph, &scene->forest, root, area, a->depth, &draw);
    }
    *svg_text = svg_end(svg);
    return true;
}

int cmd_plan(int argc, char **argv) {
    Arguments a = {.storey = -1, .depth = 8, .width = 1200};
    int code = parse(argc, argv, &a);
    if (code != APP_GOOD) return code;
    if (a.help) {
        fputs(HELP, stdout);
        return APP_GOOD;
    }
    Arena arena = {0};
    AppScene scene;
    Error error;
    AppOptions load = app_default_options();
    load.map = a.map;
    const char *text = NULL;
    bool good = app_check_files(&a.out, 1, &a.file, 1, &error) &&
                app_load(a.file, &load, &arena, &scene, &error) && app_has_walls(&scene, &error) &&
                draw_figure(&a, &scene, &arena, &text, &error);
    if (good && a.out) good = file_write(a.out, text, strlen(text), &error);
    if (good && !a.out) fputs(text, stdout);
    arena_free(&arena);
    return good ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
}
