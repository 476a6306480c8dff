// figure.c - plans and stab trees as figures, after figures 1 and 3 of Oki's paper.
#include "visibility/prepare/figure.h"

#include <stdio.h>

#include "engine/core/error.h"
#include "visibility/sightline.h"

static const DrawStyle WALL = {.stroke = 0x222222, .width = 0.07};
static const DrawStyle SHEET = {.stroke = 0x222222, .width = 0.03};  // of a soup: furniture may be dense
static const DrawStyle PORTAL = {.stroke = 0x5588cc, .width = 0.015};
static const DrawStyle DOOR = {.stroke = 0xb05020, .width = 0.05};
static const DrawStyle SWING = {.stroke = 0xb05020, .width = 0.012, .dash = 0.06};
static const DrawStyle GLASS = {.stroke = 0x30a0d0, .width = 0.05};
static const DrawStyle SIGHTLINE = {.stroke = 0xcc2222, .width = 0.02, .dash = 0.12};

static Vec2 centroid(const Vec2 *p, int count) {
    Vec2 sum = {0, 0};
    double area = 0;
    for (int i = 1; i + 1 < count; i++) {
        double a = vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0]));
        Vec2 middle = vec2_scale(vec2_add(vec2_add(p[0], p[i]), p[i + 1]), 1.0 / 3);
        sum = vec2_add(sum, vec2_scale(middle, a));
        area += a;
    }
    return area > 0 ? vec2_scale(sum, 1 / area) : p[0];
}

bool figure_cuts(const CellGraph *graph, int cell, double z) {
    return graph->cells[cell].z0 <= z && z <= graph->cells[cell].z1;
}

static Vec2 cell_middle(const CellGraph *graph, int c) {
    return centroid(graph->plan + graph->cells[c].first_edge, graph->cells[c].edge_count);
}

static const Region *region_of(const CellGraph *graph, int c) { return vis_region(graph, c); }

void figure_fill(const CellGraph *graph, int cell, const DrawStyle *style, const Draw *draw) {
    const Cell *c = &graph->cells[cell];
    draw->polygon(draw->context, graph->plan + c->first_edge, c->edge_count, style);
}

void figure_walls(const CellGraph *graph, int cell, double z, const DrawStyle *style, const Draw *draw) {
    for (int i = graph->surface_first[cell]; i < graph->surface_first[cell + 1]; i++) {
        const Polygon *p = &graph->polygons[graph->objects[i].first_polygon];
        const Vec3 *v = graph->vertices + p->first_vertex;
        Box box = box_empty();
        for (int k = 0; k < p->vertex_count; k++) box = box_add(box, v[k]);
        if (box.min.z == box.max.z || box.min.z > z || box.max.z < z) continue;
        Vec3 far = v[0];  // an upright surface: its plan is the line to the corner farthest from the first
        for (int k = 1; k < p->vertex_count; k++) {
            if (hypot(v[k].x - v[0].x, v[k].y - v[0].y) > hypot(far.x - v[0].x, far.y - v[0].y)) far = v[k];
        }
        // A line shorter than lines are wide lies under its neighbours.
        if (hypot(far.x - v[0].x, far.y - v[0].y) < style->width) continue;
        draw->line(draw->context, vec2(v[0].x, v[0].y), vec2(far.x, far.y), style);
    }
}

// Where a convex polygon crosses height z.
static bool cross_height(const Vec3 *v, int count, double z, Vec2 ends[2]) {
    int found = 0;
    for (int i = 0; i < count && found < 2; i++) {
        Vec3 a = v[i], b = v[(i + 1) % count];
        if ((a.z < z) == (b.z < z)) continue;
        Vec3 p = vec3_lerp(a, b, (z - a.z) / (b.z - a.z));
        ends[found++] = vec2(p.x, p.y);
    }
    return found == 2;
}

void figure_polygons(const CellGraph *graph, double z, Box area, const DrawStyle *style, const Draw *draw) {
    area.min.z = area.max.z = z;
    for (int i = 0; i < graph->building->object_count; i++) {
        const Object *o = &graph->objects[i];
        if (o->leaf >= 0 || !box_overlap(area, graph->object_boxes[i])) continue;
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
            Vec2 ends[2];
            if (cross_height(graph->vertices + graph->polygons[p].first_vertex,
                             graph->polygons[p].vertex_count, z, ends))
                draw->line(draw->context, ends[0], ends[1], style);
        }
    }
}

bool figure_portal(const CellGraph *graph, int portal, double z, Vec2 ends[2]) {
    const Portal *p = &graph->portals[portal];
    return cross_height(graph->portal_vertices + p->first_vertex, p->vertex_count, z, ends);
}

void figure_portals(const CellGraph *graph, int cell, double z, const DrawStyle *style, const Draw *draw) {
    const Cell *c = &graph->cells[cell];
    for (int i = c->first_way; i < c->first_way + c->way_count; i++) {
        int portal = graph->ways[i].portal;
        Vec2 ends[2];
        if (graph->portals[portal].cell[0] == cell && figure_portal(graph, portal, z, ends))
            draw->line(draw->context, ends[0], ends[1], style);
    }
}

// The way of the free end from closed to wide open, and the leaf there.
static void draw_leaf(const Leaf *leaf, const Draw *draw) {
    enum { STEPS = 12 };
    Vec2 previous = leaf->axis[1];
    for (int i = 1; i <= STEPS; i++) {
        Vec3 at = leaf_point(leaf, (double)i / STEPS, vec3(leaf->axis[1].x, leaf->axis[1].y, 0));
        Vec2 next = vec2(at.x, at.y);
        draw->line(draw->context, previous, next, &SWING);
        previous = next;
    }
    Vec3 hinge = leaf_point(leaf, 1, vec3(leaf->axis[0].x, leaf->axis[0].y, 0));
    draw->line(draw->context, vec2(hinge.x, hinge.y), previous, &DOOR);
}

static void draw_openings(const CellGraph *graph, double z, const Draw *draw) {
    const Building *b = graph->building;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->sill > z || o->head < z) continue;
        if (o->kind == OPENING_WINDOW || o->glazed) draw->line(draw->context, o->line[0], o->line[1], &GLASS);
        if (o->kind != OPENING_DOOR || o->glazed) continue;
        for (int k = o->first_leaf; k < o->first_leaf + o->leaf_count; k++) draw_leaf(&b->leaves[k], draw);
    }
}

// The stretch of the region that holds x along the line at height y of the plan; false where (x, y) is not in it.
static bool free_stretch(const Building *b, int region, double x, double y, double *from, double *to) {
    const Region *r = &b->regions[region];
    bool inside = false;
    *from = -INFINITY;
    *to = INFINITY;
    for (int k = r->first_ring; k < r->first_ring + r->ring_count; k++) {
        const Vec2 *p = b->points + b->rings[k].first_point;
        for (int i = 0, n = b->rings[k].point_count; i < n; i++) {
            Vec2 a = p[i], c = p[(i + 1) % n];
            if ((a.y > y) == (c.y > y)) continue;
            double at = a.x + (c.x - a.x) * (y - a.y) / (c.y - a.y);
            if (at > x) *to = fmin(*to, at);
            if (at > x) continue;
            *from = fmax(*from, at);
            inside = !inside;
        }
    }
    return inside;
}

// Is there room around (x, y), moved along x as need be?
static bool has_room(const Building *b, int region, Box area, double width, double height, Vec2 *middle) {
    double from = area.min.x, to = area.max.x;
    if (middle->y - height / 2 < area.min.y || middle->y + height / 2 > area.max.y) return false;
    for (int i = -1; i <= 1; i++) {
        double left, right;
        if (!free_stretch(b, region, middle->x, middle->y + i * height / 2, &left, &right)) return false;
        from = fmax(from, left);
        to = fmin(to, right);
    }
    if (to - from < width) return false;
    middle->x = fmin(fmax(middle->x, from + width / 2), to - width / 2);
    return true;
}

bool figure_name_place(const Building *b, int region, Box area, double width, double height, Vec2 *middle) {
    enum { STEPS = 4 };  // places tried each way
    const Ring *ring = &b->rings[b->regions[region].first_ring];
    const Vec2 *points = b->points + ring->first_point;
    Box box = box_empty();
    for (int i = 0; i < ring->point_count; i++) box = box_add(box, vec3(points[i].x, points[i].y, 0));
    box.min = vec3(fmax(box.min.x, area.min.x), fmax(box.min.y, area.min.y), 0);
    box.max = vec3(fmin(box.max.x, area.max.x), fmin(box.max.y, area.max.y), 0);
    if (box.max.x - box.min.x < width || box.max.y - box.min.y < height) return false;
    Vec2 wish = centroid(points, ring->point_count);
    *middle = wish;
    if (has_room(b, region, box, width, height, middle)) return true;
    double nearest = INFINITY;
    for (int k = 0; k < STEPS * STEPS; k++) {
        Vec2 p = {box.min.x + (k % STEPS + 0.5) / STEPS * (box.max.x - box.min.x),
                  box.min.y + (k / STEPS + 0.5) / STEPS * (box.max.y - box.min.y)};
        if (!has_room(b, region, box, width, height, &p)) continue;
        double distance = vec2_length(vec2_sub(p, wish));
        if (distance >= nearest) continue;
        nearest = distance;
        *middle = p;
    }
    return nearest < INFINITY;
}

static void draw_names(const CellGraph *graph, double z, const Draw *draw) {
    const Building *b = graph->building;
    for (int r = 0; r < b->region_count; r++) {
        const Region *region = &b->regions[r];
        if (region->kind != REGION_ROOM || !*region->name || region->z0 > z || region->z1 < z) continue;
        const Ring *ring = &b->rings[region->first_ring];
        draw->text(draw->context, centroid(b->points + ring->first_point, ring->point_count), 0.28, 0x555555,
                   region->name);
    }
}

void figure_ground(const CellGraph *graph, double z, const Draw *draw) {
    static const unsigned fills[REGION_KINDS] = {0xf6f1e6, 0xeaf3e4, 0xf3e6d8, 0xe0e0f0};
    for (int c = 0; c < graph->cell_count; c++) {
        DrawStyle style = {.fill = fills[region_of(graph, c)->kind], .fill_opacity = 1};
        if (figure_cuts(graph, c, z)) figure_fill(graph, c, &style, draw);
    }
    for (int c = 0; c < graph->cell_count; c++) figure_portals(graph, c, z, &PORTAL, draw);
}

void figure_lines(const CellGraph *graph, double z, const Draw *draw) {
    for (int c = 0; c < graph->cell_count; c++) figure_walls(graph, c, z, &WALL, draw);
    if (graph->building->form == FORM_SOUP) figure_polygons(graph, z, graph->box, &SHEET, draw);
    draw_openings(graph, z, draw);
    draw_names(graph, z, draw);
}

// ---- sightlines

static bool lines_meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d, Vec2 *out) {
    Vec2 u = vec2_sub(b, a), v = vec2_sub(d, c);
    double det = vec2_cross(u, v);
    if (fabs(det) < 1e-12) return false;
    *out = vec2_add(a, vec2_scale(u, vec2_cross(vec2_sub(c, a), v) / det));
    return true;
}

// A line between the two extremes of the sequence: through where they cross, half-way between their directions.
static void middle_line(const Sightline *line, Vec2 *point, Vec2 *direction) {
    Vec2 a = line->right[line->ccw_from], b = line->left[line->ccw_to];
    Vec2 c = line->left[line->cw_from], d = line->right[line->cw_to];
    Vec2 u = vec2_sub(b, a), v = vec2_sub(d, c);
    u = vec2_scale(u, 1 / fmax(vec2_length(u), 1e-12));
    v = vec2_scale(v, 1 / fmax(vec2_length(v), 1e-12));
    *direction = vec2_add(u, v);
    if (!lines_meet(a, b, c, d, point)) *point = vec2_scale(vec2_add(a, c), 0.5);
}

// The stretch of the line inside a cell, as parameters along it.
static bool stretch(const CellGraph *graph, int c, Vec2 point, Vec2 direction, double *from, double *to) {
    const Cell *cell = &graph->cells[c];
    const Vec2 *plan = graph->plan + cell->first_edge;
    *from = -1e9;
    *to = 1e9;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = plan[i], edge = vec2_sub(plan[(i + 1) % cell->edge_count], a);
        double here = vec2_cross(edge, vec2_sub(point, a)), rate = vec2_cross(edge, direction);
        if (fabs(rate) < 1e-12) continue;
        if (rate > 0) *from = fmax(*from, -here / rate);
        if (rate < 0) *to = fmin(*to, -here / rate);
    }
    return *from < *to + 1e-6;
}

// A line through all portals on the way to `node`, from inside the root cell to inside the node's, in plan.
// Returns false for the root itself.
static bool sightline_to(const CellGraph *graph, const StabForest *forest, int node, Arena *scratch,
                         Vec2 ends[2]) {
    int depth = 0, root = node;
    for (; forest->nodes[root].parent >= 0; root = forest->nodes[root].parent) depth++;
    if (depth == 0) return false;
    int *path = ARENA_ARRAY(scratch, int, depth + 1);
    for (int i = depth, at = node; i >= 0; i--, at = forest->nodes[at].parent) path[i] = at;
    Sightline line = {.left = ARENA_ARRAY(scratch, Vec2, depth),
                      .right = ARENA_ARRAY(scratch, Vec2, depth),
                      .capacity = depth};
    for (int i = 1; i <= depth; i++) {
        const StabNode *step = &forest->nodes[path[i]];
        const Portal *portal = &graph->portals[step->portal];
        if (portal->horizontal) continue;
        bool forward = portal->cell[0] == forest->nodes[path[i - 1]].cell;
        SightlineUndo undo;
        sightline_push(&line, forward ? portal->left : portal->right, forward ? portal->right : portal->left,
                       &undo);
    }
    Vec2 point, direction;
    int from_cell = forest->nodes[root].cell, to_cell = forest->nodes[node].cell;
    if (line.count >= 2) {
        middle_line(&line, &point, &direction);
    } else {
        point = cell_middle(graph, from_cell);
        Vec2 target =
            line.count ? vec2_scale(vec2_add(line.left[0], line.right[0]), 0.5) : cell_middle(graph, to_cell);
        direction = vec2_sub(target, point);
    }
    double a, b, c, d;
    if (!stretch(graph, from_cell, point, direction, &a, &b) ||
        !stretch(graph, to_cell, point, direction, &c, &d)) {
        return false;
    }
    ends[0] = vec2_add(point, vec2_scale(direction, (a + b) / 2));
    ends[1] = vec2_add(point, vec2_scale(direction, (c + d) / 2));
    return true;
}

void figure_seen(const CellGraph *graph, const StabForest *forest, int root, double z, const Draw *draw) {
    Arena scratch = {0};
    int *shallowest = ARENA_ARRAY(&scratch, int, graph->cell_count), first = forest->root[root];
    int count = forest->root[root + 1] - first;
    int *depth = ARENA_ARRAY(&scratch, int, count), *witness = ARENA_ARRAY(&scratch, int, graph->cell_count);
    for (int c = 0; c < graph->cell_count; c++) shallowest[c] = -1;
    for (int i = 0; i < count; i++) {
        const StabNode *node = &forest->nodes[first + i];
        depth[i] = node->parent < 0 ? 0 : depth[node->parent - first] + 1;
        if (shallowest[node->cell] < 0 || depth[i] < shallowest[node->cell]) {
            shallowest[node->cell] = depth[i];
            witness[node->cell] = first + i;
        }
    }
    for (int c = 0; c < graph->cell_count; c++) {
        if (!figure_cuts(graph, c, z) || !vis_sees(forest, root, c)) continue;
        DrawStyle style = {.fill = c == root ? 0xe0a030 : 0x70a8e0,
                           .fill_opacity = c == root ? 0.7 : 0.75 / (1 + 0.25 * fmax(0, shallowest[c]))};
        figure_fill(graph, c, &style, draw);
    }
    for (int c = 0; c < graph->cell_count; c++) {
        Vec2 ends[2];
        bool room = region_of(graph, c)->kind == REGION_ROOM || region_of(graph, c)->kind == REGION_OUTDOORS;
        if (shallowest[c] <= 0 || !room || !figure_cuts(graph, c, z)) continue;
        if (!sightline_to(graph, forest, witness[c], &scratch, ends)) continue;
        draw->line(draw->context, ends[0], ends[1], &SIGHTLINE);
        DrawStyle dot = {.fill = 0xcc2222, .fill_opacity = 1};
        draw->circle(draw->context, ends[1], 0.05, &dot);
    }
    arena_free(&scratch);
}

// ---- the tree itself

typedef struct TreeFigure {
    const CellGraph *graph;
    const StabForest *forest;
    const Draw *draw;
    Box area;
    int max_depth, leaves, next_leaf, levels;
} TreeFigure;

static int count_leaves(TreeFigure *f, int node, int depth) {
    if (depth + 1 > f->levels) f->levels = depth + 1;
    int leaves = 0;
    for (int child = node + 1; depth < f->max_depth && child >= 0 && child < f->forest->node_count &&
                               f->forest->nodes[child].parent == node;
         child = f->forest->nodes[child].next) {
        leaves += count_leaves(f, child, depth + 1);
    }
    return leaves ? leaves : 1;
}

static void node_label(const TreeFigure *f, int cell, char *text, size_t size) {
    const Region *region = region_of(f->graph, cell);
    if (region->kind == REGION_ROOM && *region->name) {
        snprintf(text, size, "%s", region->name);
    } else {
        static const char letters[REGION_KINDS] = {'R', 'O', 'd', 's'};
        snprintf(text, size, "%c%d", letters[region->kind], cell);
    }
}

static double draw_node(TreeFigure *f, int node, int depth) {
    double width = (f->area.max.x - f->area.min.x) / f->leaves;
    double height = (f->area.max.y - f->area.min.y) / (f->levels > 1 ? f->levels - 1 : 1);
    double y = f->area.max.y - depth * height, sum = 0, children[1024];
    int count = 0;
    for (int child = node + 1; depth < f->max_depth && child >= 0 && child < f->forest->node_count &&
                               f->forest->nodes[child].parent == node && count < 1024;
         child = f->forest->nodes[child].next) {
        children[count] = draw_node(f, child, depth + 1);
        sum += children[count++];
    }
    double x = count ? sum / count : f->area.min.x + width * (f->next_leaf++ + 0.5);
    double size = fmin(0.28, fmax(0.05, 0.3 * fmin(width, height)));
    DrawStyle edge = {.stroke = 0x888888, .width = fmin(0.015, size / 8)};
    for (int i = 0; i < count; i++) {
        f->draw->line(f->draw->context, vec2(x, y - 0.7 * size), vec2(children[i], y - height + 0.7 * size),
                      &edge);
    }
    char label[64];
    node_label(f, f->forest->nodes[node].cell, label, sizeof label);
    f->draw->text(f->draw->context, vec2(x, y), size, depth ? 0x222222 : 0xb05020, label);
    return x;
}

void figure_tree(const CellGraph *graph, const StabForest *forest, int root, Box area, int max_depth,
                 const Draw *draw) {
    TreeFigure f = {graph, forest, draw, area, max_depth, 0, 0, 0};
    f.leaves = count_leaves(&f, forest->root[root], 0);
    draw_node(&f, forest->root[root], 0);
}
