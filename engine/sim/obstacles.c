// obstacles.c - the solids around a body.
//
// Source: K. Shudo et al. (Oki), 3.2: a body that stays in a cell meets only the boundary of that cell, so no other wall is
// looked at. Departures: a body has a radius, so cells that it reaches into through portals count too; and furniture,
// which Oki does not treat, comes from a plan grid of its polygons, finer than the squares of the graph, since models
// have thousands within a metre. Furniture behind a wall is farther than the wall, so no body meets it.
#include "engine/sim/obstacles.h"

#include <string.h>

#include "engine/sim/door_part.h"

// Side of the squares in which polygons of furniture are looked up, metres: about a body's radius.
static const double SQUARE = 0.25;
// The squares are made larger until there are at most ENTRIES_PER_POLYGON entries for each item, and LEAST_ENTRIES more.
enum { ENTRIES_PER_POLYGON = 32, LEAST_ENTRIES = 1 << 16, MOST_SQUARES = 1024 };  // along a side
// The upright share of a normal below which nobody stands on a polygon: slopes of more than 45 degrees, and walls.
static const double STEEP = 0.7;
// A path that comes this near a portal touches it, metres: far above rounding at the edge of the allowed world (1e-8),
// far below the grid of the plan.
static const double TOUCH = 1e-6;

// A polygon that is not part of a cell's surface and never moves; or a leaf of a door, whose box is all that it may reach.
typedef struct Item {
    int polygon, leaf;  // the other is -1
    unsigned seen;      // `serial` of the last call that saw it
    bool steep;
    float box[2][3];  // low and high corner, rounded outwards: there are millions of items
} Item;

// A grid in plan.
typedef struct PlanGrid {
    Vec2 origin;
    double size;
    int nx, ny;
    int *first;  // [nx * ny + 1]
    int *items;  // in Obstacles.item: run s is items[first[s]] .. items[first[s + 1] - 1]
} PlanGrid;

struct Obstacles {
    const CellGraph *graph;
    PlanGrid grid;
    Arena *arena;
    Item *item;  // [item_count]
    int item_count;
    unsigned char *shut;              // [cell_count] inside a window: nobody enters
    int *bare_door;                   // [portal_count] the door without leaves that closes the portal, or -1
    Vec3 border[4][4];                // the sides of the world
    Vec3 (*leaf_plan)[LEAF_CORNERS];  // [leaf_count] plans of the leaves gathered
    // The state of the last call:
    unsigned serial;
    unsigned *cell_seen;  // [cell_count] `serial` of the last call that saw the cell
    int *cells;           // [cell_count] reached
    int cell_count;
    Solid *solids;  // [solid_capacity]
    int solid_count, solid_capacity, wall_tests, object_tests;
};

static float below(double x) { return nextafterf((float)x, -INFINITY); }
static float above(double x) { return nextafterf((float)x, INFINITY); }

static Item make_item(int polygon, int leaf, bool steep, Box box) {
    return (Item){.polygon = polygon,
                  .leaf = leaf,
                  .steep = steep,
                  .box = {{below(box.min.x), below(box.min.y), below(box.min.z)},
                          {above(box.max.x), above(box.max.y), above(box.max.z)}}};
}

static Box item_box(const Item *item) {
    return (Box){{(double)item->box[0][0], (double)item->box[0][1], (double)item->box[0][2]},
                 {(double)item->box[1][0], (double)item->box[1][1], (double)item->box[1][2]}};
}

static Box box_of_vertices(const Vec3 *v, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, v[i]);
    return box;
}

// ---- made once

static int clamp(double x, int count) { return x < 0 ? 0 : x >= count ? count - 1 : (int)x; }

typedef struct Range {
    int x0, x1, y0, y1;
} Range;

static Range squares_under(const PlanGrid *grid, Box box) {
    return (Range){clamp((box.min.x - grid->origin.x) / grid->size, grid->nx),
                   clamp((box.max.x - grid->origin.x) / grid->size, grid->nx),
                   clamp((box.min.y - grid->origin.y) / grid->size, grid->ny),
                   clamp((box.max.y - grid->origin.y) / grid->size, grid->ny)};
}

static Box box_of(const CellGraph *graph, int polygon) {
    const Polygon *p = &graph->polygons[polygon];
    return box_of_vertices(graph->vertices + p->first_vertex, p->vertex_count);
}

static bool is_steep(const CellGraph *graph, int polygon) {
    const Polygon *p = &graph->polygons[polygon];
    return fabs(plane_of_polygon(graph->vertices + p->first_vertex, p->vertex_count).n.z) < STEEP;
}

// Is the object neither a surface nor a leaf, and in the way? Of the building's own objects.
static bool stands_in_the_way(const Object *object, const unsigned char *frameless) {
    if (object->plug || object->leaf >= 0) return false;
    return object->kind != OBJECT_FRAME || object->opening < 0 || !frameless[object->opening];
}

// Lists the items: polygons, then leaves.
static void list_items(Obstacles *o, Arena *arena) {
    const CellGraph *graph = o->graph;
    const Building *b = graph->building;
    Arena scratch = {0};
    unsigned char *frameless = ARENA_ARRAY(&scratch, unsigned char, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) {
        // A frame that bars its door by itself, as in some models cut into parts, is drawn but is no obstacle.
        frameless[i] = b->openings[i].kind == OPENING_DOOR && !door_lets_pass(graph, i, true) &&
                       door_lets_pass(graph, i, false);
    }
    int count = b->leaf_count;
    for (int i = 0; i < graph->surface_first[0]; i++)
        if (stands_in_the_way(&graph->objects[i], frameless)) count += graph->objects[i].polygon_count;
    o->item = ARENA_ARRAY(arena, Item, count + 1);
    for (int i = 0; i < graph->surface_first[0]; i++) {
        const Object *object = &graph->objects[i];
        if (!stands_in_the_way(object, frameless)) continue;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            o->item[o->item_count++] = make_item(p, -1, is_steep(graph, p), box_of(graph, p));
    }
    for (int i = 0; i < b->leaf_count; i++)
        o->item[o->item_count++] = make_item(-1, i, false, door_leaf_reach(&b->leaves[i]));
    arena_free(&scratch);
}

static PlanGrid grid_over(Box box, double size) {
    return (PlanGrid){.origin = {box.min.x, box.min.y},
                      .size = size,
                      .nx = (int)fmax(1, ceil((box.max.x - box.min.x) / size)),
                      .ny = (int)fmax(1, ceil((box.max.y - box.min.y) / size))};
}

static long count_entries(const Obstacles *o, const PlanGrid *grid) {
    long entries = 0;
    for (int i = 0; i < o->item_count; i++) {
        Range r = squares_under(grid, item_box(&o->item[i]));
        entries += (long)(r.x1 - r.x0 + 1) * (r.y1 - r.y0 + 1);
    }
    return entries;
}

// Counts the entries of each square when `fill` is NULL, otherwise puts the items into their squares.
static void enter_items(Obstacles *o, int *fill) {
    PlanGrid *grid = &o->grid;
    for (int i = 0; i < o->item_count; i++) {
        Range r = squares_under(grid, item_box(&o->item[i]));
        for (int y = r.y0; y <= r.y1; y++) {
            for (int x = r.x0; x <= r.x1; x++) {
                int square = y * grid->nx + x;
                if (fill) {
                    grid->items[fill[square]++] = i;
                } else {
                    grid->first[square + 1]++;
                }
            }
        }
    }
}

static void build_grid(Obstacles *o, Arena *arena) {
    Arena scratch = {0};
    Box box = o->graph->box;
    double size = fmax(SQUARE, fmax(box.max.x - box.min.x, box.max.y - box.min.y) / MOST_SQUARES);
    o->grid = grid_over(box, size);
    while (count_entries(o, &o->grid) > (long)ENTRIES_PER_POLYGON * o->item_count + LEAST_ENTRIES)
        o->grid = grid_over(box, size *= 2);
    int squares = o->grid.nx * o->grid.ny;
    o->grid.first = ARENA_ARRAY(arena, int, squares + 1);
    enter_items(o, NULL);
    for (int s = 0; s < squares; s++) o->grid.first[s + 1] += o->grid.first[s];
    o->grid.items = ARENA_ARRAY(arena, int, o->grid.first[squares] + 1);
    int *fill = ARENA_ARRAY(&scratch, int, squares);
    memcpy(fill, o->grid.first, (size_t)squares * sizeof *fill);
    enter_items(o, fill);
    arena_free(&scratch);
}

// Marks the cells inside windows, which nobody enters, and the portals between the two halves of a door without leaves.
static void mark_openings(Obstacles *o, Arena *arena) {
    const CellGraph *graph = o->graph;
    const Building *b = graph->building;
    o->shut = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    for (int c = 0; c < graph->cell_count; c++) {
        int opening = vis_region(graph, c)->opening;
        o->shut[c] = opening >= 0 && b->openings[opening].kind == OPENING_WINDOW;
    }
    o->bare_door = ARENA_ARRAY(arena, int, graph->portal_count + 1);
    for (int i = 0; i < graph->portal_count; i++) {
        const Region *p = vis_region(graph, graph->portals[i].cell[0]);
        const Region *q = vis_region(graph, graph->portals[i].cell[1]);
        bool middle = p->opening >= 0 && p->opening == q->opening && p->side != q->side;
        bool bare =
            middle && b->openings[p->opening].kind == OPENING_DOOR && b->openings[p->opening].leaf_count == 0;
        o->bare_door[i] = bare ? p->opening : -1;
    }
}

static void build_border(Obstacles *o) {
    Box w = o->graph->building->world;
    // The cells of a polygon soup reach above its roof, where a body may stand too.
    w.min.z = fmin(w.min.z, o->graph->box.min.z);
    w.max.z = fmax(w.max.z, o->graph->box.max.z);
    double x[5] = {w.min.x, w.max.x, w.max.x, w.min.x, w.min.x},
           y[5] = {w.min.y, w.min.y, w.max.y, w.max.y, w.min.y};
    for (int i = 0; i < 4; i++) {
        o->border[i][0] = vec3(x[i], y[i], w.min.z);
        o->border[i][1] = vec3(x[i], y[i], w.max.z);
        o->border[i][2] = vec3(x[i + 1], y[i + 1], w.max.z);
        o->border[i][3] = vec3(x[i + 1], y[i + 1], w.min.z);
    }
}

Obstacles *obstacles_new(const CellGraph *graph, Arena *arena) {
    Obstacles *o = arena_alloc(arena, 1, sizeof *o);
    int leaves = graph->building->leaf_count;
    o->graph = graph;
    o->arena = arena;
    list_items(o, arena);
    mark_openings(o, arena);
    build_border(o);
    build_grid(o, arena);
    o->leaf_plan = arena_alloc(arena, (size_t)leaves + 1, sizeof *o->leaf_plan);
    o->cell_seen = ARENA_ARRAY(arena, unsigned, graph->cell_count);
    o->cells = ARENA_ARRAY(arena, int, graph->cell_count);
    return o;
}

// ---- which cells

// A path in plan, and the distance within which it touches a portal, metres; `box` holds all points within that distance.
typedef struct Path {
    Vec2 from, to;
    double reach;
    Box box;
} Path;

static Path make_path(Vec3 from, Vec3 to, double reach) {
    Box box = box_grow(box_add(box_add(box_empty(), from), to), reach);
    return (Path){vec2(from.x, from.y), vec2(to.x, to.y), reach, box};
}

static double point_to_edge(Vec2 p, Vec2 a, Vec2 b) {
    Vec2 along = vec2_sub(b, a), to = vec2_sub(p, a);
    double length2 = vec2_dot(along, along), t = length2 > 0 ? vec2_dot(to, along) / length2 : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return vec2_length(vec2_sub(to, vec2_scale(along, t)));
}

static double edge_to_edge(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    Vec2 ab = vec2_sub(b, a), cd = vec2_sub(d, c);
    bool apart = vec2_cross(ab, vec2_sub(c, a)) * vec2_cross(ab, vec2_sub(d, a)) >= 0 ||
                 vec2_cross(cd, vec2_sub(a, c)) * vec2_cross(cd, vec2_sub(b, c)) >= 0;
    if (!apart) return 0;
    return fmin(fmin(point_to_edge(a, c, d), point_to_edge(b, c, d)),
                fmin(point_to_edge(c, a, b), point_to_edge(d, a, b)));
}

static Box portal_box(const CellGraph *graph, int portal) {
    const Portal *p = &graph->portals[portal];
    return box_of_vertices(graph->portal_vertices + p->first_vertex, p->vertex_count);
}

static bool touches(const Obstacles *o, int portal, const Path *path) {
    const Portal *p = &o->graph->portals[portal];
    if (!box_overlap(portal_box(o->graph, portal), path->box)) return false;
    if (!p->horizontal) return edge_to_edge(path->from, path->to, p->left, p->right) <= path->reach;
    // In plan, a path that is outside one edge by more than the reach is that far away from the whole portal.
    const Vec3 *v = o->graph->portal_vertices + p->first_vertex;
    double turn = p->plane.n.z > 0 ? 1 : -1;  // counter-clockwise from above, or from below
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 a = v[i], b = v[(i + 1) % p->vertex_count];
        Vec2 edge = vec2(b.x - a.x, b.y - a.y), at = vec2(a.x, a.y);
        double out = fmax(turn * vec2_cross(edge, vec2_sub(path->from, at)),
                          turn * vec2_cross(edge, vec2_sub(path->to, at)));
        if (out < -path->reach * vec2_length(edge)) return false;
    }
    return true;
}

static void reach_cell(Obstacles *o, int cell) {
    if (o->cell_seen[cell] == o->serial) return;
    o->cell_seen[cell] = o->serial;
    o->cells[o->cell_count++] = cell;
}

static void begin_cell(Obstacles *o, int cell) {
    // The counter may wrap around; a cell or item that was seen 2^32 calls ago must not count as seen now.
    if (++o->serial == 0) {
        memset(o->cell_seen, 0, (size_t)o->graph->cell_count * sizeof *o->cell_seen);
        for (int i = 0; i < o->item_count; i++) o->item[i].seen = 0;
        o->serial = 1;
    }
    o->cell_count = o->solid_count = o->wall_tests = o->object_tests = 0;
    reach_cell(o, cell);
}

// ---- solids

static void add_solid(Obstacles *o, Solid solid) {
    *ARENA_PUSH(o->arena, o->solids, o->solid_count, o->solid_capacity) = solid;
}

// Adds an upright polygon: a portal that nobody passes, or a side of the border of the world.
static void add_barrier(Obstacles *o, const Vec3 *vertices, int count, Box box) {
    add_solid(o, (Solid){.vertices = vertices, .count = count, .steep = true, .box = box});
}

static void add_obstacle_polygon(Obstacles *o, int polygon, bool steep, Box box) {
    const Polygon *p = &o->graph->polygons[polygon];
    add_solid(o, (Solid){.vertices = o->graph->vertices + p->first_vertex,
                         .count = p->vertex_count,
                         .steep = steep,
                         .box = box});
}

static void add_leaf(Obstacles *o, int leaf, const float *door_open, const Box *near) {
    const Leaf *l = &o->graph->building->leaves[leaf];
    Vec2 corner[LEAF_CORNERS];
    double open = door_open ? (double)door_open[l->opening] : 1;
    int count = leaf_plan(o->graph->building, l, open, corner);
    Box box = box_empty();
    for (int i = 0; i < count; i++) {
        o->leaf_plan[leaf][i] = vec3(corner[i].x, corner[i].y, 0);
        box = box_add(box, o->leaf_plan[leaf][i]);
    }
    box.min.z = l->z0 + open * l->rise;
    box.max.z = l->z1 + open * l->rise;
    if (!box_overlap(box, *near)) return;
    add_solid(o, (Solid){.vertices = o->leaf_plan[leaf], .count = count, .prism = true, .box = box});
}

// Adds the surfaces of a cell and its portals that nobody passes; its other portals lead to further cells.
static void add_cell(Obstacles *o, int cell, const float *door_open, const Path *path) {
    const CellGraph *graph = o->graph;
    for (int i = graph->surface_first[cell]; i < graph->surface_first[cell + 1]; i++) {
        const Object *object = &graph->objects[i];
        o->wall_tests += object->polygon_count;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            Box box = box_of(graph, p);
            if (box_overlap(box, path->box)) add_obstacle_polygon(o, p, is_steep(graph, p), box);
        }
    }
    for (int i = 0; i < graph->cells[cell].way_count; i++) {
        Way way = graph->ways[graph->cells[cell].first_way + i];
        if (!touches(o, way.portal, path)) continue;
        const Portal *p = &graph->portals[way.portal];
        int door = o->bare_door[way.portal];
        bool closed = door >= 0 && door_open && door_open[door] == 0;
        // A closed door is met from both of its sides but added only once.
        if (o->shut[way.cell] || (closed && o->cell_seen[way.cell] != o->serial)) {
            add_barrier(o, graph->portal_vertices + p->first_vertex, p->vertex_count,
                        portal_box(graph, way.portal));
        }
        if (!o->shut[way.cell]) reach_cell(o, way.cell);
    }
}

static void add_items(Obstacles *o, const float *door_open, const Box *near) {
    const PlanGrid *grid = &o->grid;
    Range r = squares_under(grid, *near);
    for (int y = r.y0; y <= r.y1; y++) {
        for (int k = grid->first[y * grid->nx + r.x0]; k < grid->first[y * grid->nx + r.x1 + 1]; k++) {
            Item *item = &o->item[grid->items[k]];
            if (item->seen == o->serial) continue;
            item->seen = o->serial;
            o->object_tests++;
            if (!box_overlap(item_box(item), *near)) continue;
            if (item->leaf >= 0) {
                add_leaf(o, item->leaf, door_open, near);
                continue;
            }
            Box box = box_of(o->graph, item->polygon);
            if (box_overlap(box, *near)) add_obstacle_polygon(o, item->polygon, item->steep, box);
        }
    }
}

Gathered obstacles_gather(Obstacles *o, const float *door_open, int cell, Vec2 at, double radius,
                          Band heights) {
    Path path = {at,
                 at,
                 radius,
                 {{at.x - radius, at.y - radius, heights.z0}, {at.x + radius, at.y + radius, heights.z1}}};
    begin_cell(o, cell);
    for (int i = 0; i < o->cell_count; i++) add_cell(o, o->cells[i], door_open, &path);
    add_items(o, door_open, &path.box);
    for (int i = 0; i < 4; i++) {
        Box box = box_of_vertices(o->border[i], 4);
        if (box_overlap(box, path.box)) add_barrier(o, o->border[i], 4, box);
    }
    return (Gathered){o->solids, o->solid_count, o->wall_tests, o->object_tests};
}

int obstacles_cross(Obstacles *o, int cell, Vec3 from, Vec3 to) {
    int end = vis_locate(o->graph, to, cell);
    if (end < 0 || end == cell) return end;
    if (o->shut[end]) return -1;
    Path path = make_path(from, to, TOUCH);
    begin_cell(o, cell);
    for (int i = 0; i < o->cell_count; i++) {
        const Cell *c = &o->graph->cells[o->cells[i]];
        for (int k = 0; k < c->way_count; k++) {
            Way way = o->graph->ways[c->first_way + k];
            if (!o->shut[way.cell] && touches(o, way.portal, &path)) reach_cell(o, way.cell);
        }
        if (o->cell_seen[end] == o->serial) return end;
    }
    return -1;
}

bool obstacles_is_shut(const Obstacles *o, int cell) { return o->shut[cell]; }
