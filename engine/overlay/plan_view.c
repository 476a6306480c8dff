// plan_view.c - draws the plan in layers: cells tinted by visibility, stairs, view, walls, stab tree, openings, names, and the eye on top.
#include "engine/overlay/plan_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/sim/body.h"
#include "visibility/prepare/figure.h"

// The plan is cut at this height over the floor, metres: through doors, and through most windows.
#define PLAN_CUT 1.2
// The margin kept around the rooms and the eye, metres.
#define PLAN_MARGIN 0.6
// Hatching shows the treads of stairs this far apart, metres, as far as real treads are.
#define PLAN_TREAD 0.28
// The tint of seen cells fades to half at this distance from the eye, metres: a large room.
#define PLAN_FADE 8.0
// Deeper levels of the tree are left out: lines would cross everywhere.
#define PLAN_TREE_LEVELS 24

// Sizes below are in points.
static const double NAME_SIZE = 9.5, NAME_MARGIN = 3, EYE_RADIUS = 4.2, WEDGE_REACH = 44;

static const unsigned OUTDOORS = 0x1a2026, ROOM = 0x333d49, THRESHOLD = 0x3f4650, SEEN = 0x3f8fe0,
                      HERE = 0xcd7a28, NAME = 0xf4f6f8, EYE = 0xffffff, WEDGE = 0xffd966;

typedef struct PlanDrawing {
    const PlanView *view;
    const Draw *draw;
    Box area;
    double z, point;
    Arena *scratch;
    BoxHits cells;  // in `area` and at `z`, ascending
} PlanDrawing;

PlanPlaces *plan_places(const CellGraph *graph, Arena *arena) {
    const Building *b = graph->building;
    PlanPlaces *places = ARENA_ARRAY(arena, PlanPlaces, 1);
    Box *cells = ARENA_ARRAY(arena, Box, graph->cell_count + 1),
        *openings = ARENA_ARRAY(arena, Box, b->opening_count + 1);
    int stairs = 0;
    for (int c = 0; c < graph->cell_count; c++) cells[c] = graph->cells[c].box;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        Box box = box_add(box_add(box_empty(), vec3(o->line[0].x, o->line[0].y, o->sill)),
                          vec3(o->line[1].x, o->line[1].y, o->head));
        // An open leaf reaches as far from the opening as the opening is wide.
        openings[i] = box_grow(box, vec2_length(vec2_sub(o->line[1], o->line[0])));
    }
    for (int i = 0; i < b->object_count; i++)
        stairs += b->objects[i].kind == OBJECT_STAIR && b->objects[i].proxy;
    Box *boxes = ARENA_ARRAY(arena, Box, stairs + 1);
    places->stair = ARENA_ARRAY(arena, int, stairs + 1);
    stairs = 0;
    for (int i = 0; i < b->object_count; i++) {
        if (b->objects[i].kind != OBJECT_STAIR || !b->objects[i].proxy) continue;
        boxes[stairs] = graph->object_boxes[i];
        places->stair[stairs++] = i;
    }
    places->cells = box_tree_build(cells, graph->cell_count, arena);
    places->openings = box_tree_build(openings, b->opening_count, arena);
    places->stairs = box_tree_build(boxes, stairs, arena);
    places->rooms_z = NAN;
    return places;
}

int plan_view_storey(const CellGraph *graph, int cell, Vec3 eye) {
    const Building *b = graph->building;
    int storey = cell >= 0 ? vis_region(graph, cell)->storey : -1;
    if (storey >= 0 || b->storey_count == 0) return storey;
    storey = 0;
    for (int i = 1; i < b->storey_count; i++) {
        bool below = b->storeys[i].floor <= eye.z, best_below = b->storeys[storey].floor <= eye.z;
        bool higher = b->storeys[i].floor > b->storeys[storey].floor;
        if (below ? higher || !best_below : !best_below && !higher) storey = i;
    }
    return storey;
}

static double cut_height(const PlanView *view) {
    if (view->storey < 0) return view->eye.z - (BODY_EYE - PLAN_CUT);
    const Storey *s = &view->graph->building->storeys[view->storey];
    return s->floor + fmin(PLAN_CUT, s->height / 2);
}

// ---- the part that shows

// Shortens the range least .. most to `longest`, around `middle` as far as its ends allow.
static void shorten(double *least, double *most, double middle, double longest) {
    if (*most - *least <= longest) return;
    double from = fmin(fmax(middle - longest / 2, *least), *most - longest);
    *least = from;
    *most = from + longest;
}

Box plan_view_area(const PlanView *view, double most) {
    const CellGraph *graph = view->graph;
    PlanPlaces *places = view->places;
    double z = cut_height(view);
    if (places->rooms_z != z) {
        places->rooms = box_empty();
        for (int c = 0; c < graph->cell_count; c++) {
            bool outdoors = vis_region(graph, c)->kind == REGION_OUTDOORS;
            if (!outdoors && figure_cuts(graph, c, z))
                places->rooms = box_union(places->rooms, graph->cells[c].box);
        }
        places->rooms_z = z;
    }
    Box box = box_grow(box_add(places->rooms, view->eye), PLAN_MARGIN);
    shorten(&box.min.x, &box.max.x, view->eye.x, most);
    shorten(&box.min.y, &box.max.y, view->eye.y, most);
    return box;
}

// The part of the plan that shows, between two heights.
static Box area_between(const PlanDrawing *d, double z0, double z1) {
    return (Box){{d->area.min.x, d->area.min.y, z0}, {d->area.max.x, d->area.max.y, z1}};
}

static void find_cells(PlanDrawing *d) {
    int kept = 0,
        found = box_tree_find(&d->view->places->cells, area_between(d, d->z, d->z), d->scratch, &d->cells);
    for (int i = 0; i < found; i++)
        if (figure_cuts(d->view->graph, d->cells.items[i], d->z)) d->cells.items[kept++] = d->cells.items[i];
    d->cells.count = kept;
}

static int by_number(const void *p, const void *q) {
    const int *a = p, *b = q;
    return (*a > *b) - (*a < *b);
}

// ---- cells

static unsigned mixed(unsigned below, unsigned above, double share) {
    unsigned out = 0;
    for (int shift = 0; shift <= 16; shift += 8) {
        double a = below >> shift & 255, b = above >> shift & 255;
        out |= (unsigned)lround(a + (b - a) * share) << shift;
    }
    return out;
}

// Each cell is drawn once: the blue of seen cells is mixed in here, not on the screen.
static void draw_cells(const PlanDrawing *d) {
    const PlanView *view = d->view;
    const CellGraph *graph = view->graph;
    double *strength = ARENA_ARRAY(d->scratch, double, d->cells.count + 1);
    for (int i = 0; d->cells.count > 0 && view->visible && i < view->visible->cell_count; i++) {
        const VisibleCell *seen = &view->visible->cells[i];
        const int *at =
            bsearch(&seen->cell, d->cells.items, (size_t)d->cells.count, sizeof *d->cells.items, by_number);
        if (at) strength[at - d->cells.items] = 0.2 + 0.6 / (1 + seen->distance / PLAN_FADE);
    }
    for (int i = 0; i < d->cells.count; i++) {
        int c = d->cells.items[i];
        RegionKind kind = vis_region(graph, c)->kind;
        bool outdoors = kind == REGION_OUTDOORS;
        if (outdoors && c != view->cell && strength[i] == 0) continue;
        unsigned ground = outdoors ? OUTDOORS : kind == REGION_ROOM ? ROOM : THRESHOLD;
        DrawStyle style = {.fill = mixed(ground, SEEN, strength[i]), .fill_opacity = 1};
        // A garden is too large for the full colour.
        if (c == view->cell) style.fill = mixed(ground, HERE, outdoors ? 0.4 : 1);
        figure_fill(graph, c, &style, d->draw);
    }
}

// ---- the stab tree

typedef struct TreeStep {
    int from, to;  // portals; from -1: the eye
    int depth;     // the least depth of this step in the tree; 0: it is not in the tree
} TreeStep;

static bool portal_shows(const CellGraph *graph, int portal, double z) {
    Vec2 ends[2];
    return figure_portal(graph, portal, z, ends);
}

// The index of the portal among the cell's ways.
static int way_of(const CellGraph *graph, int cell, int portal) {
    const Cell *c = &graph->cells[cell];
    for (int i = 0; i < c->way_count; i++) {
        if (graph->ways[c->first_way + i].portal == portal) return i;
    }
    return 0;
}

// The steps of the tree, each once: the step from a cell's way i to its way j is at first[cell] + i * ways + j; the ways out of the root
// come last.
static TreeStep *tree_steps(const PlanDrawing *d, int *count) {
    const CellGraph *graph = d->view->graph;
    const StabForest *forest = d->view->forest;
    int root = forest->root[d->view->cell], end = forest->root[d->view->cell + 1];
    int *first = ARENA_ARRAY(d->scratch, int, graph->cell_count + 1);
    int *depth = ARENA_ARRAY(d->scratch, int, end - root);
    for (int c = 0; c < graph->cell_count; c++) {
        first[c + 1] = first[c] + graph->cells[c].way_count * graph->cells[c].way_count;
    }
    *count = first[graph->cell_count] + graph->cells[d->view->cell].way_count;
    TreeStep *steps = ARENA_ARRAY(d->scratch, TreeStep, *count + 1);
    for (int n = root + 1; n < end; n++) {
        const StabNode *node = &forest->nodes[n], *parent = &forest->nodes[node->parent];
        depth[n - root] = depth[node->parent - root] + 1;
        int out = way_of(graph, parent->cell, node->portal), ways = graph->cells[parent->cell].way_count;
        int at = node->parent == root
                     ? first[graph->cell_count] + out
                     : first[parent->cell] + way_of(graph, parent->cell, parent->portal) * ways + out;
        if (steps[at].depth && steps[at].depth <= depth[n - root]) continue;
        steps[at] = (TreeStep){parent->portal, node->portal, depth[n - root]};
    }
    return steps;
}

static Vec2 portal_middle(const CellGraph *graph, int portal) {
    return vec2_scale(vec2_add(graph->portals[portal].left, graph->portals[portal].right), 0.5);
}

// Colours go from yellow at the root over red to violet, and lines get thinner; deep steps are drawn first, so that near steps lie on top.
static void draw_tree(const PlanDrawing *d) {
    static const unsigned LEVELS[] = {0xffe14d, 0xffb02e, 0xff7a3c, 0xf4506a, 0xd048a8, 0xa04ccc, 0x7a50c8};
    enum { LEVEL_COUNT = sizeof LEVELS / sizeof *LEVELS };
    const PlanView *view = d->view;
    if (!view->forest || view->cell < 0) return;
    int count;
    const TreeStep *steps = tree_steps(d, &count);
    for (int depth = PLAN_TREE_LEVELS; depth > 0; depth--) {
        int level = depth <= LEVEL_COUNT ? depth - 1 : LEVEL_COUNT - 1;
        DrawStyle style = {.stroke = LEVELS[level], .width = d->point * fmax(0.6, 1.9 - 0.2 * level)};
        for (int i = 0; i < count; i++) {
            const TreeStep *s = &steps[i];
            if (s->depth != depth || !portal_shows(view->graph, s->to, d->z)) continue;
            if (s->from >= 0 && !portal_shows(view->graph, s->from, d->z)) continue;
            Vec2 from = s->from < 0 ? vec2(view->eye.x, view->eye.y) : portal_middle(view->graph, s->from);
            d->draw->line(d->draw->context, from, portal_middle(view->graph, s->to), &style);
        }
    }
}

// ---- things

// Draws the outline of an object's coarse box, with treads hatched across its longer side.
static void draw_stair(const PlanDrawing *d, const Object *object) {
    DrawStyle line = {.stroke = 0x9aa6b4, .width = 0.7 * d->point};
    const Vec2 *p = object->proxy->corner;
    int side = vec2_length(vec2_sub(p[1], p[0])) >= vec2_length(vec2_sub(p[2], p[1])) ? 0 : 1;
    Vec2 along = vec2_sub(p[side + 1], p[side]), across = vec2_sub(p[(side + 3) % 4], p[side]);
    int treads = (int)fmin(fmax(vec2_length(along) / PLAN_TREAD, 1), 100);
    for (int i = 0; i <= treads; i++) {
        Vec2 from = vec2_add(p[side], vec2_scale(along, (double)i / treads));
        d->draw->line(d->draw->context, from, vec2_add(from, across), &line);
    }
    for (int i = side; i < 4; i += 2) d->draw->line(d->draw->context, p[i], p[(i + 1) % 4], &line);
}

// Draws the stairs that stand on this storey or come up to it.
static void draw_stairs(const PlanDrawing *d) {
    const PlanPlaces *places = d->view->places;
    BoxHits hits = {0};
    int count = box_tree_find(&places->stairs, area_between(d, -INFINITY, INFINITY), d->scratch, &hits);
    for (int i = 0; i < count; i++) {
        const Object *o = &d->view->graph->building->objects[places->stair[hits.items[i]]];
        if (o->proxy->z0 < d->z && o->proxy->z1 > d->z - PLAN_CUT) draw_stair(d, o);
    }
}

static void draw_walls(const PlanDrawing *d) {
    const CellGraph *graph = d->view->graph;
    DrawStyle portal = {.stroke = 0x8fb4dc, .width = 0.45 * d->point};
    DrawStyle wall = {.stroke = 0xe4e9ee, .width = 1.5 * d->point};
    for (int i = 0; i < d->cells.count; i++) {
        // Cells under the sky are large and many, and the portals between them say nothing.
        int c = d->cells.items[i];
        if (vis_region(graph, c)->kind != REGION_OUTDOORS) figure_portals(graph, c, d->z, &portal, d->draw);
    }
    for (int i = 0; i < d->cells.count; i++) figure_walls(graph, d->cells.items[i], d->z, &wall, d->draw);
    if (graph->building->form == FORM_SOUP) figure_polygons(graph, d->z, d->area, &wall, d->draw);
}

// A leaf is green where the door stands open, red where it is closed, amber between. Leaves are about as thin as a line: one line each.
static void draw_leaves(const PlanDrawing *d, const Opening *door) {
    const PlanView *view = d->view;
    const Building *b = view->graph->building;
    double open = view->door_open ? (double)view->door_open[door - b->openings] : 1;
    DrawStyle style = {.stroke = open <= 0 ? 0xff5a4a : open >= 1 ? 0x6fdc8c : 0xffc040};
    for (int i = door->first_leaf; i < door->first_leaf + door->leaf_count; i++) {
        const Leaf *leaf = &b->leaves[i];
        Vec2 corner[4];
        leaf_box(leaf, open, corner);
        style.width = fmax(leaf->thickness, (door->glazed ? 1.2 : 1.8) * d->point);
        Vec2 hinge = vec2_scale(vec2_add(corner[0], corner[3]), 0.5),
             end = vec2_scale(vec2_add(corner[1], corner[2]), 0.5);
        d->draw->line(d->draw->context, hinge, end, &style);
    }
}

static void draw_openings(const PlanDrawing *d) {
    const Building *b = d->view->graph->building;
    DrawStyle glass = {.stroke = 0x6fd3f0, .width = 1.5 * d->point};
    BoxHits hits = {0};
    int count = box_tree_find(&d->view->places->openings, area_between(d, d->z, d->z), d->scratch, &hits);
    for (int i = 0; i < count; i++) {
        const Opening *o = &b->openings[hits.items[i]];
        if (o->sill > d->z || o->head < d->z) continue;
        if (o->kind == OPENING_WINDOW) d->draw->line(d->draw->context, o->line[0], o->line[1], &glass);
        if (o->kind == OPENING_DOOR) draw_leaves(d, o);
    }
}

// Draws the name where it fits and does not hide the eye.
static void draw_name(const PlanDrawing *d, int region, const char *name) {
    const PlanView *view = d->view;
    double size = NAME_SIZE * d->point, margin = 2 * NAME_MARGIN * d->point;
    double width = d->draw->text_width ? d->draw->text_width(d->draw->context, size, name)
                                       : 0.6 * size * (double)strlen(name);
    Vec2 at;
    if (!figure_name_place(view->graph->building, region, d->area, width + margin, size + margin, &at))
        return;
    bool hides =
        fabs(view->eye.x - at.x) < (width + margin) / 2 && fabs(view->eye.y - at.y) < (size + margin) / 2;
    if (!hides) d->draw->text(d->draw->context, at, size, NAME, name);
}

static void draw_names(const PlanDrawing *d) {
    const CellGraph *graph = d->view->graph;
    int named = -1;  // the cells of a region follow each other
    for (int i = 0; i < d->cells.count; i++) {
        int r = graph->cells[d->cells.items[i]].region;
        const Region *region = vis_region(graph, d->cells.items[i]);
        if (r == named || region->kind != REGION_ROOM || !*region->name) continue;
        draw_name(d, r, region->name);
        named = r;
    }
}

// ---- the eye

static Vec2 from_eye(const PlanDrawing *d, double angle, double distance) {
    return vec2_add(vec2(d->view->eye.x, d->view->eye.y), vec2_scale(vec2(cos(angle), sin(angle)), distance));
}

// Draws the eye's view as a sector, in two halves, which are convex even where the sector is wider than half a turn.
static void draw_wedge(const PlanDrawing *d) {
    enum { ARC = 16 };
    double reach = WEDGE_REACH * d->point, from = d->view->yaw - d->view->fov / 2, step = d->view->fov / ARC;
    DrawStyle style = {.fill = WEDGE, .fill_opacity = 0.4};
    for (int half = 0; half < 2; half++) {
        Vec2 p[ARC / 2 + 2] = {vec2(d->view->eye.x, d->view->eye.y)};
        for (int i = 0; i <= ARC / 2; i++)
            p[i + 1] = from_eye(d, from + (half * (ARC / 2) + i) * step, reach);
        d->draw->polygon(d->draw->context, p, ARC / 2 + 2, &style);
    }
}

static void draw_eye(const PlanDrawing *d) {
    Vec2 eye = vec2(d->view->eye.x, d->view->eye.y);
    DrawStyle ray = {.stroke = WEDGE, .width = 1.3 * d->point};
    for (int side = -1; side <= 1; side += 2) {
        Vec2 end = from_eye(d, d->view->yaw + side * d->view->fov / 2, WEDGE_REACH * d->point);
        d->draw->line(d->draw->context, eye, end, &ray);
    }
    DrawStyle dot = {.fill = EYE, .fill_opacity = 1, .stroke = 0x10151b, .width = 1.4 * d->point};
    d->draw->circle(d->draw->context, eye, EYE_RADIUS * d->point, &dot);
}

void plan_view_draw(const PlanView *view, Box area, double point, Arena *scratch, const Draw *draw) {
    PlanDrawing d = {view, draw, area, cut_height(view), point, scratch, {0}};
    find_cells(&d);
    draw_cells(&d);
    draw_stairs(&d);
    draw_wedge(&d);
    draw_walls(&d);
    draw_tree(&d);
    draw_openings(&d);
    draw_names(&d);
    draw_eye(&d);
}
