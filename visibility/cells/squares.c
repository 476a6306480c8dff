// squares.c - the grid of squares inside each cell, and the objects registered there (Oki 2.2).
//
// A surface belongs to its cell: its back is never seen. An object of the building belongs to every square of every
// cell that one of its polygons touches: the polygon is clipped by the cell grown by `touch`, and what is left by
// rows and columns of squares. The leaf of a door belongs wherever it may come.
#include <string.h>

#include "engine/core/box_tree.h"
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/cells/build.h"

static int clamp(double x, int count) { return x < 0 ? 0 : x >= count ? count - 1 : (int)x; }

// Square columns or rows from..to that [low, high] touches.
typedef struct Range {
    int from, to;
} Range;

static Range squares_of(double origin, double size, int count, double low, double high, double touch) {
    return (Range){clamp(floor((low - touch - origin) / size), count),
                   clamp(floor((high + touch - origin) / size), count)};
}

static SquareGrid grid_over(Box box, double size, int first_square) {
    return (SquareGrid){.origin = {box.min.x, box.min.y},
                        .size = size,
                        .nx = (int)fmax(1, ceil((box.max.x - box.min.x) / size)),
                        .ny = (int)fmax(1, ceil((box.max.y - box.min.y) / size)),
                        .first_square = first_square};
}

// About one cell per locator square, within limits.
static double locator_size(const CellGraph *graph) {
    double area = (graph->box.max.x - graph->box.min.x) * (graph->box.max.y - graph->box.min.y);
    return fmax(0.5, sqrt(area / (4.0 * graph->cell_count + 16)));
}

void build_locator(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    SquareGrid *grid = &graph->locator;
    *grid = grid_over(graph->box, locator_size(graph), 0);
    int squares = grid->nx * grid->ny;
    graph->locator_first = ARENA_ARRAY(builder->arena, int, squares + 1);
    int *fill = ARENA_ARRAY(builder->scratch, int, squares + 1);
    for (int pass = 0; pass < 2; pass++) {
        for (int c = 0; c < graph->cell_count; c++) {
            Box box = graph->cells[c].box;
            Range x = squares_of(grid->origin.x, grid->size, grid->nx, box.min.x, box.max.x, graph->touch);
            Range y = squares_of(grid->origin.y, grid->size, grid->ny, box.min.y, box.max.y, graph->touch);
            for (int j = y.from; j <= y.to; j++) {
                for (int i = x.from; i <= x.to; i++) {
                    int square = j * grid->nx + i;
                    if (pass == 0) {
                        graph->locator_first[square + 1]++;
                    } else {
                        graph->locator_cells[fill[square]++] = c;
                    }
                }
            }
        }
        if (pass > 0) break;
        for (int s = 0; s < squares; s++) graph->locator_first[s + 1] += graph->locator_first[s];
        memcpy(fill, graph->locator_first, (size_t)squares * sizeof *fill);
        graph->locator_cells = ARENA_ARRAY(builder->arena, int, graph->locator_first[squares]);
    }
}

typedef struct Registration {
    int square, object;
} Registration;

typedef struct Registrar {
    CellBuilder *builder;
    Registration *list;
    int count, capacity;
    BoxTree cells;  // of all cells' boxes
    BoxHits near;
    int *registered;  // [square_count] the last object registered in a square
    // [cell_count] and in how many of a cell's squares the object at hand is, if it is the last of `filler`
    int *filled;
    int *filler;       // [cell_count]
    int *first_plane;  // [cell_count + 1]
    Plane *planes;     // of the plan of cell c: from first_plane[c] to first_plane[c + 1] - 1
    Vec3 *buffer[4];   // each with room for the largest polygon after clipping by a cell and a slab
} Registrar;

static bool is_filled(const Registrar *r, int cell, int object) {
    const SquareGrid *grid = &r->builder->graph->grids[cell];
    return r->filler[cell] == object && r->filled[cell] == grid->nx * grid->ny;
}

// False where it is there already.
static bool add_registration(Registrar *r, int square, int object) {
    if (r->registered[square] == object) return false;
    r->registered[square] = object;
    *ARENA_APPEND(r->builder->scratch, r->list, r->count, r->capacity) = (Registration){square, object};
    return true;
}

static void register_in_cell(Registrar *r, int cell, int square, int object) {
    if (!add_registration(r, square, object)) return;
    if (r->filler[cell] != object) r->filled[cell] = 0;
    r->filler[cell] = object;
    r->filled[cell]++;
}

// The part of a convex polygon with low <= coordinate <= high along x or y. Clips into buffer[2].
static int clip_slab(const Registrar *r, const Vec3 *in, int count, Vec3 axis, double low, double high) {
    double touch = r->builder->graph->touch;
    count = polygon_clip(in, count, (Plane){axis, low}, touch, r->buffer[3]);
    return polygon_clip(r->buffer[3], count, (Plane){vec3_scale(axis, -1), -high}, touch, r->buffer[2]);
}

static Box bounds(const Vec3 *v, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, v[i]);
    return box;
}

// Whether an object is in all squares of a row.
static bool is_row_filled(const Registrar *r, const SquareGrid *grid, int row, Range x, int object) {
    const int *registered = r->registered + grid->first_square + row * grid->nx;
    for (int i = x.from; i <= x.to; i++)
        if (registered[i] != object) return false;
    return true;
}

// Registers a polygon that lies within a cell.
static void register_squares(Registrar *r, int cell, const Vec3 *polygon, int count, int object) {
    const CellGraph *graph = r->builder->graph;
    const SquareGrid *grid = &graph->grids[cell];
    Box box = bounds(polygon, count);
    Range across = squares_of(grid->origin.x, grid->size, grid->nx, box.min.x, box.max.x, graph->touch);
    Range y = squares_of(grid->origin.y, grid->size, grid->ny, box.min.y, box.max.y, graph->touch);
    for (int j = y.from; j <= y.to; j++) {
        if (is_row_filled(r, grid, j, across, object)) continue;
        double low = grid->origin.y + j * grid->size;
        int rows = clip_slab(r, polygon, count, vec3(0, 1, 0), low, low + grid->size);
        if (rows == 0) continue;
        Box row = bounds(r->buffer[2], rows);
        // A convex piece no wider than its row touches every square between its ends.
        Range x = squares_of(grid->origin.x, grid->size, grid->nx, row.min.x, row.max.x, graph->touch);
        for (int i = x.from; i <= x.to; i++)
            register_in_cell(r, cell, grid->first_square + j * grid->nx + i, object);
    }
}

static Plane side_plane(Vec2 a, Vec2 b) {
    Vec3 n = vec3_normalize(vec3(a.y - b.y, b.x - a.x, 0));
    return (Plane){n, n.x * a.x + n.y * a.y};
}

// Whether b lies on the line from a to c, but for rounding: far less than what registers.
static bool is_straight(Vec2 a, Vec2 b, Vec2 c) {
    static const double ROUNDING = 1e-11;
    Vec2 ac = vec2_sub(c, a);
    return fabs(vec2_cross(vec2_sub(b, a), ac)) <= ROUNDING * (fabs(ac.x) + fabs(ac.y));
}

// The sides of a cell's plan; `straight`, sides in one line count as one: a wall with thousands of doors has thousands.
// `planes` has room for all edges. Returns how many there are.
static int plan_planes(const CellGraph *graph, const Cell *cell, bool straight, Plane *planes) {
    const Vec2 *v = graph->plan + cell->first_edge;
    int count = 0, n = cell->edge_count;
    for (int i = 0, end; i < n; i = end) {
        for (end = i + 1; straight && end < n - (i == 0) && is_straight(v[i], v[end], v[(end + 1) % n]);)
            end++;
        planes[count++] = side_plane(v[i], v[end % n]);
    }
    return count;
}

// The part of a polygon inside these planes moved outwards by `slack`.
static int clip_to_planes(const Plane *inward, int plane_count, const Vec3 *polygon, int count, double slack,
                          Vec3 *out, Vec3 *buffer) {
    memmove(out, polygon, (size_t)count * sizeof *out);
    for (int i = 0; i < plane_count; i++) {
        int inside = 0;
        for (int k = 0; k < count; k++) inside += plane_distance(inward[i], out[k]) + slack >= 0;
        if (inside == 0) return 0;
        if (inside == count) continue;
        count = polygon_clip(out, count, inward[i], slack, buffer);
        memcpy(out, buffer, (size_t)count * sizeof *out);
    }
    return count;
}

// The part of a polygon inside a cell grown by `slack`; `planes` are those of its plan; `out` and `buffer` have room for as many
// vertices more as the cell has sides.
static int clip_to_cell(const CellGraph *graph, const Cell *cell, const Plane *planes, int plane_count,
                        const Vec3 *polygon, int count, double slack, Vec3 *out, Vec3 *buffer) {
    if (cell->face_count == 0) {
        count = polygon_clip(polygon, count, (Plane){{0, 0, 1}, cell->z0}, slack, buffer);
        count = polygon_clip(buffer, count, (Plane){{0, 0, -1}, -cell->z1}, slack, out);
        return clip_to_planes(planes, plane_count, out, count, slack, out, buffer);
    }
    return clip_to_planes(graph->faces + cell->first_face, cell->face_count, polygon, count, slack, out,
                          buffer);
}

// Whether an object is in all squares of a cell that something within the box can touch.
static bool is_covered(const Registrar *r, int cell, Box box, int object) {
    if (r->filler[cell] != object) return false;
    const SquareGrid *grid = &r->builder->graph->grids[cell];
    double touch = r->builder->graph->touch;
    Range x = squares_of(grid->origin.x, grid->size, grid->nx, box.min.x, box.max.x, touch);
    Range y = squares_of(grid->origin.y, grid->size, grid->ny, box.min.y, box.max.y, touch);
    for (int j = y.from; j <= y.to; j++)
        if (!is_row_filled(r, grid, j, x, object)) return false;
    return true;
}

// The cells that something within the box can touch, to `near`.
static void find_near(Registrar *r, Box box) {
    box_tree_find(&r->cells, box_grow(box, r->builder->graph->touch), r->builder->scratch, &r->near);
}

// Registers a polygon, or, `upright`, the prism over and under it within `box`; `near` holds all cells that it can touch.
static void register_near(Registrar *r, int object, const Vec3 *v, int vertex_count, Box box, bool upright) {
    CellGraph *graph = r->builder->graph;
    graph->object_boxes[object] = box_union(graph->object_boxes[object], box);
    box = box_grow(box, graph->touch);
    for (int i = 0; i < r->near.count; i++) {
        int c = r->near.items[i];
        if (!box_overlap(graph->cells[c].box, box)) continue;
        if (is_filled(r, c, object) || is_covered(r, c, box, object)) continue;
        const Plane *planes = r->planes + r->first_plane[c];
        int sides = r->first_plane[c + 1] - r->first_plane[c];
        int count =
            upright ? clip_to_planes(planes, sides, v, vertex_count, graph->touch, r->buffer[0], r->buffer[1])
                    : clip_to_cell(graph, &graph->cells[c], planes, sides, v, vertex_count, graph->touch,
                                   r->buffer[0], r->buffer[1]);
        if (count > 0) register_squares(r, c, r->buffer[0], count, object);
    }
}

// A piece of furniture is thousands of polygons in one or two cells, which are searched for once.
static void register_object(Registrar *r, int object) {
    enum { FEW = 8 };
    const CellGraph *graph = r->builder->graph;
    const Polygon *from = graph->polygons + graph->objects[object].first_polygon,
                  *to = from + graph->objects[object].polygon_count;
    Box whole = box_empty();
    for (const Polygon *p = from; p < to; p++)
        whole = box_union(whole, bounds(graph->vertices + p->first_vertex, p->vertex_count));
    find_near(r, whole);
    bool few = r->near.count <= FEW;
    for (const Polygon *p = from; p < to; p++) {
        const Vec3 *v = graph->vertices + p->first_vertex;
        Box box = bounds(v, p->vertex_count);
        if (!few) find_near(r, box);
        register_near(r, object, v, p->vertex_count, box, false);
    }
}

static void register_leaf(Registrar *r, int object) {
    SweptLeaf swept;
    build_swept(r->builder->graph, object, &swept);
    for (int i = 0; i < SWEPT_STEPS; i++) {
        Box box = bounds(swept.plan[i], 4);
        box.min.z = swept.z0;
        box.max.z = swept.z1;
        find_near(r, box);
        register_near(r, object, swept.plan[i], 4, box, true);
    }
}

static void register_surface(Registrar *r, int object, int cell) {
    CellGraph *graph = r->builder->graph;
    const Polygon *p = &graph->polygons[graph->objects[object].first_polygon];
    const Vec3 *v = graph->vertices + p->first_vertex;
    graph->object_boxes[object] = bounds(v, p->vertex_count);
    register_squares(r, cell, v, p->vertex_count, object);
}

// Registrations come in the order of objects, so each square's run is increasing.
static void store(Registrar *r) {
    CellGraph *graph = r->builder->graph;
    Arena *arena = r->builder->arena;
    graph->square_object_count = r->count;
    graph->square_first = ARENA_ARRAY(arena, int, graph->square_count + 1);
    graph->square_objects = ARENA_ARRAY(arena, int, r->count);
    for (int i = 0; i < r->count; i++) graph->square_first[r->list[i].square + 1]++;
    for (int s = 0; s < graph->square_count; s++) graph->square_first[s + 1] += graph->square_first[s];
    int *fill = ARENA_ARRAY(r->builder->scratch, int, graph->square_count);
    memcpy(fill, graph->square_first, (size_t)graph->square_count * sizeof *fill);
    for (int i = 0; i < r->count; i++) graph->square_objects[fill[r->list[i].square]++] = r->list[i].object;
}

static Registrar new_registrar(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    Registrar r = {.builder = builder,
                   .registered = ARENA_ARRAY(builder->scratch, int, graph->square_count),
                   .filled = ARENA_ARRAY(builder->scratch, int, graph->cell_count),
                   .filler = ARENA_ARRAY(builder->scratch, int, graph->cell_count)};
    Box *boxes = ARENA_ARRAY(builder->scratch, Box, graph->cell_count);
    int edges = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        boxes[c] = graph->cells[c].box;
        r.filler[c] = -1;
        edges += graph->cells[c].edge_count;
    }
    for (int s = 0; s < graph->square_count; s++) r.registered[s] = -1;
    r.cells = box_tree_build(boxes, graph->cell_count, builder->scratch);
    r.first_plane = ARENA_ARRAY(builder->scratch, int, graph->cell_count + 1);
    r.planes = ARENA_ARRAY(builder->scratch, Plane, edges);
    for (int c = 0; c < graph->cell_count; c++)
        r.first_plane[c + 1] =
            r.first_plane[c] + plan_planes(graph, &graph->cells[c], true, r.planes + r.first_plane[c]);
    int largest = 4;  // vertices of a leaf's sweep
    for (int p = 0; p < graph->polygon_count; p++) {
        if (graph->polygons[p].vertex_count > largest) largest = graph->polygons[p].vertex_count;
    }
    for (int i = 0; i < 4; i++)
        r.buffer[i] = ARENA_ARRAY(builder->scratch, Vec3, largest + BUILD_MAX_VERTICES + 8);
    return r;
}

// A cell has at most MOST_SQUARES along a side: the outdoors is large and holds little, and every square a view covers
// is looked into.
static double square_size(Box box, const VisOptions *options) {
    enum { MOST_SQUARES = 16 };
    double longest = fmax(box.max.x - box.min.x, box.max.y - box.min.y);
    return fmax(options->square, longest / MOST_SQUARES);
}

void build_squares(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    graph->grids = ARENA_ARRAY(builder->arena, SquareGrid, graph->cell_count);
    for (int c = 0; c < graph->cell_count; c++) {
        graph->grids[c] = grid_over(graph->cells[c].box, square_size(graph->cells[c].box, builder->options),
                                    graph->square_count);
        graph->square_count += graph->grids[c].nx * graph->grids[c].ny;
    }
    graph->object_boxes = ARENA_ARRAY(builder->arena, Box, graph->object_count);
    for (int i = 0; i < graph->object_count; i++) graph->object_boxes[i] = box_empty();
    Registrar r = new_registrar(builder);
    for (int i = 0, cell = 0; i < graph->object_count; i++) {
        const Object *object = &graph->objects[i];
        while (cell < graph->cell_count && i >= graph->surface_first[cell + 1]) cell++;
        if (i >= graph->surface_first[0] && cell < graph->cell_count) {
            register_surface(&r, i, cell);
            continue;
        }
        if (object->leaf >= 0 && object->polygon_count > 0)
            register_leaf(&r, i);
        else
            register_object(&r, i);
    }
    store(&r);
}

// A point on the common face of two polyhedra may come out beyond both by rounding: that share of `touch` holds it.
static const double FACE_SLACK = 1e-3;

static bool cell_holds(const CellGraph *graph, const Cell *cell, Vec3 p) {
    for (int i = cell->first_face; i < cell->first_face + cell->face_count; i++) {
        if (plane_distance(graph->faces[i], p) < -FACE_SLACK * graph->touch) return false;
    }
    if (cell->face_count > 0) return box_contains(box_grow(cell->box, FACE_SLACK * graph->touch), p);
    if (!box_contains(cell->box, p)) return false;
    const Vec2 *plan = graph->plan + cell->first_edge;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = plan[i], b = plan[(i + 1) % cell->edge_count];
        if (vec2_cross(vec2_sub(b, a), vec2_sub(vec2(p.x, p.y), a)) < 0) return false;
    }
    return true;
}

const Region *vis_region(const CellGraph *graph, int cell) {
    static const Region without[2] = {{.kind = REGION_ROOM, .name = "", .storey = -1, .opening = -1},
                                      {.kind = REGION_OUTDOORS, .name = "", .storey = -1, .opening = -1}};
    const Cell *c = &graph->cells[cell];
    return c->region >= 0 ? &graph->building->regions[c->region] : &without[c->outdoors];
}

int vis_locate(const CellGraph *graph, Vec3 point, int hint) {
    if (hint >= 0) {
        CORE_ASSERT(hint < graph->cell_count);
        const Cell *cell = &graph->cells[hint];
        if (cell_holds(graph, cell, point)) return hint;
        for (int i = 0; i < cell->way_count; i++) {
            int next = graph->ways[cell->first_way + i].cell;
            if (cell_holds(graph, &graph->cells[next], point)) return next;
        }
    }
    if (!box_contains(box_grow(graph->box, FACE_SLACK * graph->touch), point)) return -1;
    const SquareGrid *grid = &graph->locator;
    int i = clamp((point.x - grid->origin.x) / grid->size, grid->nx);
    int j = clamp((point.y - grid->origin.y) / grid->size, grid->ny);
    int square = j * grid->nx + i;
    for (int k = graph->locator_first[square]; k < graph->locator_first[square + 1]; k++) {
        int c = graph->locator_cells[k];
        if (cell_holds(graph, &graph->cells[c], point)) return c;
    }
    return -1;
}

int vis_locate_part(const CellGraph *graph, const Vec3 *polygon, int count, Arena *scratch, Vec3 *middle,
                    double *area) {
    const SquareGrid *grid = &graph->locator;
    Box box = bounds(polygon, count);
    Range x = squares_of(grid->origin.x, grid->size, grid->nx, box.min.x, box.max.x, graph->touch);
    Range y = squares_of(grid->origin.y, grid->size, grid->ny, box.min.y, box.max.y, graph->touch);
    int found = -1;
    *area = VIS_SLIVER;
    for (int j = y.from; j <= y.to; j++) {
        int last = graph->locator_first[j * grid->nx + x.to + 1];
        for (int k = graph->locator_first[j * grid->nx + x.from]; k < last; k++) {
            int c = graph->locator_cells[k];
            const Cell *cell = &graph->cells[c];
            if (!box_overlap(box, cell->box)) continue;
            size_t room = (size_t)(count + cell->edge_count + cell->face_count + 2);
            Vec3 *part = arena_alloc(scratch, room, sizeof *part),
                 *buffer = arena_alloc(scratch, room, sizeof *part);
            Plane *planes = ARENA_ARRAY(scratch, Plane, cell->edge_count);
            int sides = plan_planes(graph, cell, false, planes);
            int corners = clip_to_cell(graph, cell, planes, sides, polygon, count, 0, part, buffer);
            double size = corners > 2 ? polygon_area(part, corners) : 0;
            if (size <= *area) continue;
            found = c;
            *area = size;
            *middle = vec3(0, 0, 0);
            for (int i = 0; i < corners; i++) *middle = vec3_add(*middle, vec3_scale(part[i], 1.0 / corners));
        }
    }
    return found;
}

// ---- objects that touch further squares

// Registrations that are there already, by object: those of object o are square[first[o]] .. square[first[o + 1] - 1].
typedef struct Registered {
    int *first, *square;
} Registered;

static Registered by_object(const CellGraph *graph, Arena *scratch) {
    Registered r = {ARENA_ARRAY(scratch, int, graph->object_count + 2),
                    ARENA_ARRAY(scratch, int, graph->square_object_count)};
    for (int pass = 0; pass < 2; pass++) {
        for (int s = 0; s < graph->square_count; s++) {
            for (int k = graph->square_first[s]; k < graph->square_first[s + 1]; k++) {
                int object = graph->square_objects[k];
                if (pass == 0)
                    r.first[object + 2]++;
                else
                    r.square[r.first[object + 1]++] = s;
            }
        }
        for (int o = 0; pass == 0 && o < graph->object_count; o++) r.first[o + 2] += r.first[o + 1];
    }
    return r;
}

void vis_register(const CellGraph *graph, const Polygon *polygons, const Vec3 *vertices, const int *first,
                  Arena *arena, CellGraph *out) {
    Arena scratch = {0};
    CellBuilder builder = {.arena = arena, .scratch = &scratch, .graph = out};
    *out = *graph;
    out->query = NULL;
    out->object_boxes = ARENA_ARRAY(arena, Box, graph->object_count);
    memcpy(out->object_boxes, graph->object_boxes, (size_t)graph->object_count * sizeof *out->object_boxes);
    Registered there = by_object(graph, &scratch);
    Registrar r = new_registrar(&builder);
    for (int o = 0; o < graph->object_count; o++) {
        for (int k = there.first[o]; k < there.first[o + 1]; k++) add_registration(&r, there.square[k], o);
        for (int p = first[o]; p < first[o + 1]; p++) {
            const Vec3 *v = vertices + polygons[p].first_vertex;
            CORE_ASSERT(polygons[p].vertex_count <= BUILD_MAX_VERTICES);
            Box box = bounds(v, polygons[p].vertex_count);
            find_near(&r, box);
            register_near(&r, o, v, polygons[p].vertex_count, box, false);
        }
    }
    store(&r);
    arena_free(&scratch);
}
