// cmd_plan.c - `enfilade plan FILE`: the plan of a storey as SVG, and the stab tree and sightlines from a place.
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/app.h"
#include "engine/core/file.h"
#include "visibility/prepare/figure.h"

typedef struct Arguments {
    SceneOptions load;
    const char *file, *out;
    bool from_given;
    Vec3 from;
    int storey, depth, width;
} Arguments;

static const Option ROWS[] = {
    OPTION_MAP(offsetof(Arguments, load.map)),
    {.name = "o",
     .value = "OUT.svg",
     .type = OPTION_OUTPUT,
     .names = (const char *const[]){"svg"},
     .name_count = 1,
     .at = offsetof(Arguments, out),
     .help = "where to write (default: standard output)"},
    {.name = "from",
     .value = "X,Y,Z",
     .type = OPTION_POINT,
     .at = offsetof(Arguments, from),
     .help = "the place to look from, metres"},
    {.name = "storey",
     .value = "N",
     .type = OPTION_INT,
     .at = offsetof(Arguments, storey),
     .high = 1000,
     .help = "which storey, @ (default: that of --from, or 0)"},
    {.name = "depth",
     .value = "N",
     .type = OPTION_INT,
     .at = offsetof(Arguments, depth),
     .low = 1,
     .high = 64,
     .help = "levels of the tree to draw, @ (default 8)"},
    {.name = "width",
     .value = "PIXELS",
     .type = OPTION_INT,
     .at = offsetof(Arguments, width),
     .low = 100,
     .high = 10000,
     .help = "of the drawing, @ (default 1200)"},
    OPTION_MEMORY(offsetof(Arguments, load.memory), "what fits the file"),
};
static const OptionTable OPTIONS = OPTION_TABLE("plan", "FILE [OPTIONS]",
                                                "Draws the plan of a storey as SVG: cells, walls, portals, "
                                                "doors with their swing, windows. With --from, also the "
                                                "stab tree of the cell at that place: the cells it may see, "
                                                "shaded by depth, a sightline into each room, and the "
                                                "tree itself below.",
                                                ROWS);

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

static bool draw_figure(const Arguments *a, const LoadedScene *scene, Arena *arena, const char **svg_text,
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
    Arguments a = {.load = app_scene_options(), .storey = -1, .depth = 8, .width = 1200};
    bool help = false, given[sizeof ROWS / sizeof *ROWS] = {false};
    int code = options_parse_file(&OPTIONS, argc, argv, &a, given, &a.file, &help);
    if (help) options_print_help(&OPTIONS);
    if (code != APP_GOOD || help) return code;
    a.from_given = options_given(&OPTIONS, given, "from");
    Arena arena = {0};
    LoadedScene scene;
    Error error;
    const char *text = NULL;
    bool good = app_check_files(&a.out, 1, &a.file, 1, &a.load, &error) &&
                app_load(a.file, &a.load, &arena, &scene, &error) && scene_has_walls(&scene, &error) &&
                draw_figure(&a, &scene, &arena, &text, &error);
    if (good && a.out) good = file_write(a.out, text, strlen(text), &error);
    if (good && !a.out) fputs(text, stdout);
    arena_free(&arena);
    return good ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
}
