// query_cell.c - a cone enters a cell, unless a closed door is in the way, and marks the cell's objects that it meets: those in
// the squares under its wedge (Oki 2.2) whose boxes reach into it; of a cell that holds few objects, all are tried at once.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/query/query.h"

// All objects of a cell that holds no more than this are tried: finding the squares under the view would cost more.
enum { FEW = 24 };  // at most bits of CellView.undrawn, less one

bool query_box_outside(Box box, const Plane *planes, int count, Vec3 eye) {
    Vec3 centre = vec3_lerp(box.min, box.max, 0.5), half = vec3_sub(box.max, centre);
    Vec3 to = vec3_sub(centre, eye);
    for (int i = 0; i < count; i++) {
        Vec3 n = planes[i].n;
        double at = vec3_dot(n, to) + plane_distance(planes[i], eye);
        if (at + fabs(n.x) * half.x + fabs(n.y) * half.y + fabs(n.z) * half.z < -POSITION_SLACK) return true;
    }
    return false;
}

// Four objects as a cell lists them: the middles of their boxes, from the middle of the building, and half their sizes, rounded
// up.
typedef struct BoxBlock {
    FourFloat centre[3], half[3];
    FourInt object;  // lanes left over repeat one
} BoxBlock;

// The half of the plan to the left of the line from the eye along `direction`.
static Plane left_of(Vec2 eye, Vec2 direction) {
    Vec3 n = vec3_normalize(vec3(-direction.y, direction.x, 0));
    return (Plane){n, n.x * eye.x + n.y * eye.y};
}

static void draw_square(VisQuery *q, int square, Cone *cone) {
    const CellGraph *graph = q->graph;
    for (int k = graph->square_first[square]; k < graph->square_first[square + 1]; k++) {
        int object = graph->square_objects[k];
        if (q->object_tested[object] == q->cone_serial) continue;
        q->object_tested[object] = q->cone_serial;
        if (q->drawn[object / 64] >> (object % 64) & 1) continue;
        q->result.objects_tested++;
        if (!query_box_outside(graph->object_boxes[object], cone->plane, cone->count, q->eye->position))
            query_draw_object(q, object);
    }
}

// The part of the cell's plan inside the cone's plan wedge, at height 0.
static int wedge_in_cell(const VisQuery *q, const Cell *cell, const Cone *cone, Vec3 *out) {
    Vec2 eye = {q->eye->position.x, q->eye->position.y};
    double touch = q->graph->touch;
    int count = cell_polygon(q->graph, cell, 0, out);
    if (cone->all_around) return count;
    Vec3 part[BUILD_MAX_VERTICES];
    count = polygon_clip(out, count, left_of(eye, cone->from), touch, part);
    return polygon_clip(part, count, left_of(eye, vec2_scale(cone->to, -1)), touch, out);
}

static int square_at(double x, int count) { return x < 0 ? 0 : x >= count ? count - 1 : (int)x; }

// The columns that the plan polygon reaches in the row between y0 and y1: from its corners there and from where its
// edges cross the row's borders.
static bool row_extent(const Vec3 *region, int count, double y0, double y1, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 a = region[i], b = region[i + 1 == count ? 0 : i + 1];
        if (a.y >= y0 && a.y <= y1) {
            *low = fmin(*low, a.x);
            *high = fmax(*high, a.x);
        }
        for (int k = 0; k < 2; k++) {
            double y = k ? y1 : y0;
            if ((a.y < y) == (b.y < y)) continue;
            double x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            *low = fmin(*low, x);
            *high = fmax(*high, x);
        }
    }
    return *low <= *high;
}

// Middles from the eye and half sizes of four boxes.
typedef struct Boxes {
    Four x, y, z, half_x, half_y, half_z;
} Boxes;

// Which have no corner in front of one of the planes?
static FourMask boxes_outside(const Cone *cone, Vec3 eye, const Boxes *b) {
    FourMask outside = {0};
    for (int i = 0; i < cone->count; i++) {
        Vec3 n = cone->plane[i].n;
        Four at = n.x * b->x + n.y * b->y + n.z * b->z + plane_distance(cone->plane[i], eye);
        outside |=
            at + fabs(n.x) * b->half_x + fabs(n.y) * b->half_y + fabs(n.z) * b->half_z < -POSITION_SLACK;
    }
    return outside;
}

// The same of the cone beyond a slot: beyond one of its planes, with what of the box reaches back to it.
static FourMask boxes_outside_slot(const Cone *cone, const Boxes *b) {
    Vec2 from = cone->from, to = cone->to, top = cone->top, bottom = cone->bottom;
    FourMask outside =
        from.x * b->y - from.y * b->x + fabs(from.x) * b->half_y + fabs(from.y) * b->half_x < -POSITION_SLACK;
    outside |= to.y * b->x - to.x * b->y + fabs(to.y) * b->half_x + fabs(to.x) * b->half_y < -POSITION_SLACK;
    Four high = top.x * b->x + top.y * b->y + fabs(top.x) * b->half_x + fabs(top.y) * b->half_y;
    outside |= b->z - b->half_z > high + cone->top_slack;
    Four low = bottom.x * b->x + bottom.y * b->y - fabs(bottom.x) * b->half_x - fabs(bottom.y) * b->half_y;
    return outside | (b->z + b->half_z < low - cone->bottom_slack);
}

// Those of the cell that it has not yet shown.
static void draw_listed(VisQuery *q, CellView *view, const Cone *cone) {
    // To the eye from the building's middle, where boxes are counted from.
    Vec3 eye = vec3_sub(q->eye->position, q->middle);
    const BoxBlock *block = q->boxes + view->first_box;
    unsigned undrawn = view->undrawn;
    for (int first = 0; undrawn >> first; first += FOUR, block++) {
        unsigned lanes = undrawn >> first & FOUR_ALL;
        if (!lanes) continue;
        lanes &= ~four_in_set(q->drawn, block->object);  // objects that other cells have shown
        q->result.objects_tested += __builtin_popcount(lanes);
        Boxes boxes = {four_from_float(block->centre[0]) - eye.x, four_from_float(block->centre[1]) - eye.y,
                       four_from_float(block->centre[2]) - eye.z, four_from_float(block->half[0]),
                       four_from_float(block->half[1]),           four_from_float(block->half[2])};
        FourMask outside =
            cone->is_slot ? boxes_outside_slot(cone, &boxes) : boxes_outside(cone, q->eye->position, &boxes);
        lanes &= ~four_lanes(outside);
        view->undrawn &= ~(lanes << first);
        for (; lanes; lanes &= lanes - 1) query_draw_object(q, block->object[__builtin_ctz(lanes)]);
    }
}

static void draw_cell(VisQuery *q, int c, Cone *cone) {
    const SquareGrid *grid = &q->graph->grids[c];
    const Cell *cell = &q->graph->cells[c];
    double touch = q->graph->touch;
    if (query_lists_objects(q, c)) {
        draw_listed(q, query_cell_view(q, c), cone);
        return;
    }
    int squares = grid->first_square;
    if (q->graph->square_first[squares] == q->graph->square_first[squares + grid->nx * grid->ny]) return;
    q->cone_serial++;
    query_cone_planes(cone, q->eye->position);
    Vec3 region[BUILD_MAX_VERTICES];
    int count = wedge_in_cell(q, cell, cone, region);
    if (count == 0) return;
    double bottom = INFINITY, top = -INFINITY;
    for (int i = 0; i < count; i++) {
        bottom = fmin(bottom, region[i].y);
        top = fmax(top, region[i].y);
    }
    int from = square_at((bottom - touch - grid->origin.y) / grid->size, grid->ny);
    int to = square_at((top + touch - grid->origin.y) / grid->size, grid->ny);
    for (int j = from; j <= to; j++) {
        double y0 = grid->origin.y + j * grid->size, low, high;
        // The last row also holds places beyond the grid by rounding.
        double y1 = j == to ? top + touch : y0 + grid->size;
        if (!row_extent(region, count, (j == from ? bottom : y0) - touch, y1 + touch, &low, &high)) continue;
        int first = square_at((low - touch - grid->origin.x) / grid->size, grid->nx);
        int last = square_at((high + touch - grid->origin.x) / grid->size, grid->nx);
        int row = grid->first_square + j * grid->nx;
        for (int i = first; i <= last; i++) draw_square(q, row + i, cone);
    }
}

// ---- from cell to cell

// A closed door ends the view, unless the eye is in the leaf itself: then it sees both sides.
bool query_door_closed(const VisQuery *q, int index) {
    if (!q->door_open || !(q->ways[index / FOUR].beyond[index % FOUR] & WAY_DOOR)) return false;
    ViewWay way = query_way(q, index);
    const Portal *portal = &q->graph->portals[way.portal];
    if (q->door_open[portal->door] > 0) return false;
    return fabs(way.ahead) >= ON_PLANE || !query_eye_at_portal(q->graph, portal, q->eye->position);
}

void query_visit_cell(VisQuery *q, int cell, double distance, Cone *cone) {
    CellView *view = query_cell_view(q, cell);
    if (view->place < 0) {
        view->place = q->result.cell_count;
        q->cells[q->result.cell_count++] = (VisibleCell){cell, distance};
    } else if (distance < q->cells[view->place].distance) {
        q->cells[view->place].distance = distance;
    }
    draw_cell(q, cell, cone);
}

// Behind a closed leaf the far half of its doorway is drawn, the jambs that share the leaf's edges: to a
// rasteriser these are as near as the leaf. `cell` is part of that half; cells of a region are neighbours in the list.
static void draw_half(VisQuery *q, int cell, Cone *cone) {
    const Cell *cells = q->graph->cells;
    int first = cell;
    if (cells[cell].region < 0) {
        draw_cell(q, cell, cone);
        return;
    }
    while (first > 0 && cells[first - 1].region == cells[cell].region) first--;
    for (int c = first; c < q->graph->cell_count && cells[c].region == cells[cell].region; c++)
        draw_cell(q, c, cone);
}

bool query_enter(VisQuery *q, int way, Cone *beyond, double distance) {
    int cell = q->ways[way / FOUR].cell[way % FOUR];
    bool closed = query_door_closed(q, way);
    if (closed) {
        draw_half(q, cell, beyond);
    } else {
        query_visit_cell(q, cell, distance, beyond);
    }
    return !closed;
}

// ---- before all queries

static void list_box(Box box, Vec3 middle, int object, BoxBlock *out, int lane) {
    const double low[3] = {box.min.x - middle.x, box.min.y - middle.y, box.min.z - middle.z};
    const double high[3] = {box.max.x - middle.x, box.max.y - middle.y, box.max.z - middle.z};
    for (int k = 0; k < 3; k++) {
        float centre = (float)(0.5 * (low[k] + high[k]));
        double half = fmax(high[k] - centre, centre - low[k]);
        out->centre[k][lane] = centre;
        out->half[k][lane] = nextafterf((float)half, INFINITY);
    }
    out->object[lane] = object;
}

// The objects of a cell, each once: at most FEW + 1.
static int objects_of(VisQuery *q, int cell, int out[FEW + 1]) {
    const CellGraph *graph = q->graph;
    const SquareGrid *grid = &graph->grids[cell];
    int end = graph->square_first[grid->first_square + grid->nx * grid->ny], count = 0;
    q->cone_serial++;
    for (int k = graph->square_first[grid->first_square]; k < end && count <= FEW; k++) {
        int object = graph->square_objects[k];
        if (q->object_tested[object] == q->cone_serial) continue;
        q->object_tested[object] = q->cone_serial;
        out[count++] = object;
    }
    return count;
}

void query_list_objects(VisQuery *q, Arena *arena) {
    const CellGraph *graph = q->graph;
    int blocks = 0, capacity = 0;
    q->middle = vec3_lerp(graph->box.min, graph->box.max, 0.5);
    for (int c = 0; c < graph->cell_count; c++) {
        int objects[FEW + 1], count = objects_of(q, c, objects);
        if (count > FEW) count = 0;
        q->of_cell[c].first_box = blocks;
        q->of_cell[c].object_count = count;
        for (int i = 0; i < count; i += FOUR) {
            BoxBlock *block = ARENA_APPEND(arena, q->boxes, blocks, capacity);
            for (int lane = 0; lane < FOUR; lane++) {
                int object = objects[i + lane < count ? i + lane : i];
                list_box(graph->object_boxes[object], q->middle, object, block, lane);
            }
        }
    }
    q->boxes = arena_fit(arena, q->boxes, sizeof *q->boxes, blocks, capacity);
    // Boxes are fetched ahead by their address also where a cell has none, and be it that no cell has any.
    if (!q->boxes) q->boxes = ARENA_ARRAY(arena, BoxBlock, 1);
}

void query_prefetch_boxes(const VisQuery *q, int cell) {
    const char *boxes = (const char *)&q->boxes[q->of_cell[cell].first_box];
    size_t size = (size_t)(q->of_cell[cell].object_count + FOUR - 1) / FOUR * sizeof(BoxBlock);
    for (size_t line = 0; line < size; line += CACHE_LINE) __builtin_prefetch(boxes + line);
}
