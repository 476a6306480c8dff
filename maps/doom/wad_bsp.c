// wad_bsp.c - the plan of a Doom map cut along its lines into convex pieces: a binary space partition (Fuchs, Kedem &
// Naylor 1980) whose own nodes in the file are not looked at.
//
// Exact: an axis has whole numbers, and a corner is kept as the crossing of two axes, as three whole numbers. On which
// side of an axis a corner lies is the sign of a sum of products in 128 bits; nothing is rounded before the pieces are
// done, so no piece overlaps another, and none is lost, however acute.
#include <stdlib.h>

#include "engine/core/error.h"
#include "maps/doom/wad.h"

// Cutting a line in two costs as much as so many lines more on one side than on the other: deep trees cost nothing later, every
// cut may become a cell more.
enum { SPLIT_COST = 40 };
// An axis that is not along x or y costs so much, since its cuts leave corners off the grid.
enum { SLANT_COST = 2 };
// Tries for the best axis: at least so many, and as many as keep a node's work below WORK.
enum { FEWEST_TRIES = 8, WORK = 1 << 15 };
// Lines that cross all over could be cut into millions of pieces; the largest map known has 10,000.
enum { MOST_PIECES = 200000 };
// The plan is cut this far around the lines, map units, so that the whole outside hangs together.
enum { MARGIN = 64 };

// ---- axes and points

static long long common_divisor(long long a, long long b) {
    a = llabs(a), b = llabs(b);
    while (b) {
        long long rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

// Through two different points; one axis for all lines along it, whichever way they run.
static WadAxis axis_through(WadPoint p, WadPoint q) {
    long long a = p.y - q.y, b = q.x - p.x, divisor = common_divisor(a, b);
    a /= divisor, b /= divisor;
    if (a < 0 || (a == 0 && b < 0)) a = -a, b = -b;
    return (WadAxis){a, b, -(a * p.x + b * p.y)};
}

static WadPoint crossing_of_axes(const WadAxis *p, const WadAxis *q) {
    long long x = p->b * q->c - q->b * p->c, y = p->c * q->a - q->c * p->a, w = p->a * q->b - q->a * p->b;
    CORE_ASSERT(w != 0);
    long long divisor = common_divisor(w, common_divisor(x, y));
    if (w < 0) divisor = -divisor;
    return (WadPoint){x / divisor, y / divisor, w / divisor};
}

int wad_side_of(const WadAxis *axis, WadPoint p) {
    __extension__ typedef __int128 Wide;
    Wide at = (Wide)axis->a * p.x + (Wide)axis->b * p.y + (Wide)axis->c * p.w;
    return (at > 0) - (at < 0);
}

double wad_x(WadPoint p) { return (double)p.x / (double)p.w; }
double wad_y(WadPoint p) { return (double)p.y / (double)p.w; }

double wad_along(const WadAxis *axis, WadPoint p) {
    bool by_x = llabs(axis->b) >= llabs(axis->a);
    return by_x ? (axis->b > 0 ? wad_x(p) : -wad_x(p)) : (axis->a > 0 ? -wad_y(p) : wad_y(p));
}

static int by_coefficients(const void *p, const void *q) {
    const WadAxis *a = p, *b = q;
    if (a->a != b->a) return a->a < b->a ? -1 : 1;
    if (a->b != b->b) return a->b < b->b ? -1 : 1;
    return (a->c > b->c) - (a->c < b->c);
}

// The axes of all lines, each once, and then those of the four sides of a box around them.
static void list_axes(const WadMap *map, const WadPoint box[2], Arena *arena, WadPieces *out) {
    out->axes = ARENA_ARRAY(arena, WadAxis, map->line_count + 4);
    out->line_axis = ARENA_ARRAY(arena, int, map->line_count + 1);
    int count = 0;
    for (int i = 0; i < map->line_count; i++) {
        const WadLine *line = &map->lines[i];
        if (wad_line_is_void(map, line)) continue;
        out->axes[count++] = axis_through(map->vertices[line->v[0]], map->vertices[line->v[1]]);
    }
    qsort(out->axes, (size_t)count, sizeof *out->axes, by_coefficients);
    for (int i = 0; i < count; i++) {
        if (i > 0 && by_coefficients(&out->axes[i], &out->axes[out->axis_count - 1]) == 0) continue;
        out->axes[out->axis_count++] = out->axes[i];
    }
    for (int i = 0; i < map->line_count; i++) {
        const WadLine *line = &map->lines[i];
        out->line_axis[i] = -1;
        if (wad_line_is_void(map, line)) continue;
        WadAxis axis = axis_through(map->vertices[line->v[0]], map->vertices[line->v[1]]);
        const WadAxis *found =
            bsearch(&axis, out->axes, (size_t)out->axis_count, sizeof *out->axes, by_coefficients);
        out->line_axis[i] = (int)(found - out->axes);
    }
    WadPoint corner[4] = {box[0], {box[1].x, box[0].y, 1}, box[1], {box[0].x, box[1].y, 1}};
    for (int i = 0; i < 4; i++) out->axes[out->axis_count++] = axis_through(corner[i], corner[(i + 1) % 4]);
}

// ---- the partition

// The rest of a line after cuts, between two points of its axis.
typedef struct Part {
    WadPoint end[2];
    int axis;
} Part;

// A piece yet to be cut: its lines and its edges are the last ones in the lists of the cutter.
typedef struct Task {
    int first_part, part_count, first_edge, edge_count;
} Task;

typedef struct Cutter {
    const WadMap *map;
    Arena *arena;
    Arena scratch;
    WadPieces *out;
    Part *parts;
    WadEdge *edges;
    Task *tasks;
    int part_count, edge_count, task_count, part_capacity, edge_capacity, task_capacity;
    // The piece being cut:
    Part *its_parts;
    WadEdge *its_edges;
    int its_part_capacity, its_edge_capacity;
} Cutter;

static long long cost_of(const Cutter *c, int count, const WadAxis *axis) {
    long long sides[3] = {0, 0, 0}, splits = 0;
    for (int i = 0; i < count; i++) {
        int a = wad_side_of(axis, c->its_parts[i].end[0]), b = wad_side_of(axis, c->its_parts[i].end[1]);
        if (a * b < 0) splits++;
        if (a + b != 0) sides[1 + (a + b > 0 ? 1 : -1)]++;
    }
    bool slants = axis->a != 0 && axis->b != 0;
    return SPLIT_COST * splits + llabs(sides[2] - sides[0]) + SLANT_COST * slants;
}

static int choose_axis(const Cutter *c, int count) {
    int tries = WORK / count, best = -1;
    if (tries < FEWEST_TRIES) tries = FEWEST_TRIES;
    if (tries > count) tries = count;
    long long least = 0;
    for (int i = 0; i < tries; i++) {
        int axis = c->its_parts[(long long)i * count / tries].axis;
        long long cost = cost_of(c, count, &c->out->axes[axis]);
        if (best >= 0 && cost >= least) continue;
        best = axis;
        least = cost;
    }
    return best;
}

static void push_edge(Cutter *c, WadPoint from, int axis, int side) {
    *ARENA_PUSH(&c->scratch, c->edges, c->edge_count, c->edge_capacity) = (WadEdge){from, axis, side};
}

// Appends the part of the present piece on one side of an axis that runs through its inside.
static void cut_edges(Cutter *c, int count, int axis, int side) {
    const WadAxis *axes = c->out->axes;
    for (int i = 0; i < count; i++) {
        WadEdge e = c->its_edges[i];
        int here = side * wad_side_of(&axes[axis], e.from);
        int next = side * wad_side_of(&axes[axis], c->its_edges[(i + 1) % count].from);
        int last = side * wad_side_of(&axes[axis], c->its_edges[(i + count - 1) % count].from);
        if (here > 0 || (here == 0 && next > 0)) push_edge(c, e.from, e.axis, e.side);
        if (here == 0 && next < 0 && last > 0) push_edge(c, e.from, axis, side);
        if (here > 0 && next < 0) push_edge(c, crossing_of_axes(&axes[e.axis], &axes[axis]), axis, side);
        if (here < 0 && next > 0) push_edge(c, crossing_of_axes(&axes[e.axis], &axes[axis]), e.axis, e.side);
    }
}

// Appends the parts of the present piece's lines on one side of the axis.
static void cut_parts(Cutter *c, int count, int axis, int side) {
    const WadAxis *axes = c->out->axes;
    for (int i = 0; i < count; i++) {
        Part part = c->its_parts[i];
        int at[2];
        for (int k = 0; k < 2; k++) at[k] = side * wad_side_of(&axes[axis], part.end[k]);
        if (at[0] <= 0 && at[1] <= 0) continue;
        for (int k = 0; k < 2; k++) {
            if (at[k] < 0) part.end[k] = crossing_of_axes(&axes[part.axis], &axes[axis]);
        }
        *ARENA_PUSH(&c->scratch, c->parts, c->part_count, c->part_capacity) = part;
    }
}

static void finish_piece(Cutter *c, int count) {
    WadPieces *out = c->out;
    *ARENA_PUSH(c->arena, out->pieces, out->piece_count, out->piece_capacity) =
        (WadPiece){out->edge_count, count, -1};
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(c->arena, out->edges, out->edge_count, out->edge_capacity) = c->its_edges[i];
}

// Room for `count` elements, the old one where it is large enough.
static void *make_room(Cutter *c, void *room, int *capacity, int count, size_t size) {
    if (count <= *capacity) return room;
    *capacity = 2 * count;
    return arena_alloc(&c->scratch, (size_t)*capacity, size);
}

static void take_last(Cutter *c, const Task *task) {
    c->its_parts = make_room(c, c->its_parts, &c->its_part_capacity, task->part_count, sizeof *c->its_parts);
    c->its_edges = make_room(c, c->its_edges, &c->its_edge_capacity, task->edge_count, sizeof *c->its_edges);
    if (task->part_count > 0)
        memcpy(c->its_parts, c->parts + task->first_part, (size_t)task->part_count * sizeof *c->its_parts);
    memcpy(c->its_edges, c->edges + task->first_edge, (size_t)task->edge_count * sizeof *c->its_edges);
    c->part_count = task->first_part;
    c->edge_count = task->first_edge;
}

// Cuts the last piece in two, or finishes it when no line is left inside.
static void cut_last(Cutter *c) {
    Task task = c->tasks[--c->task_count];
    take_last(c, &task);
    if (task.part_count == 0) {
        finish_piece(c, task.edge_count);
        return;
    }
    int axis = choose_axis(c, task.part_count);
    for (int side = -1; side <= 1; side += 2) {
        Task half = {.first_part = c->part_count, .first_edge = c->edge_count};
        cut_parts(c, task.part_count, axis, side);
        cut_edges(c, task.edge_count, axis, side);
        half.part_count = c->part_count - half.first_part;
        half.edge_count = c->edge_count - half.first_edge;
        CORE_ASSERT(half.edge_count >= 3);
        *ARENA_PUSH(&c->scratch, c->tasks, c->task_count, c->task_capacity) = half;
    }
}

// All lines, in the box around them.
static void begin_with_square(Cutter *c, const WadPoint box[2]) {
    int first_axis = c->out->axis_count - 4;
    Task all = {0};
    for (int i = 0; i < c->map->line_count; i++) {
        if (c->out->line_axis[i] < 0) continue;
        const WadLine *line = &c->map->lines[i];
        WadPoint a = c->map->vertices[line->v[0]], b = c->map->vertices[line->v[1]];
        *ARENA_PUSH(&c->scratch, c->parts, c->part_count, c->part_capacity) =
            (Part){{a, b}, c->out->line_axis[i]};
    }
    WadPoint corner[4] = {box[0], {box[1].x, box[0].y, 1}, box[1], {box[0].x, box[1].y, 1}};
    for (int i = 0; i < 4; i++) {
        int side = wad_side_of(&c->out->axes[first_axis + i], corner[(i + 2) % 4]);
        push_edge(c, corner[i], first_axis + i, side);
    }
    all.part_count = c->part_count;
    all.edge_count = c->edge_count;
    *ARENA_PUSH(&c->scratch, c->tasks, c->task_count, c->task_capacity) = all;
}

bool wad_cut_plan(const WadMap *map, Arena *arena, WadPieces *out, Error *error) {
    WadPoint box[2] = {{INT16_MAX, INT16_MAX, 1}, {INT16_MIN, INT16_MIN, 1}};
    for (int i = 0; i < map->line_count; i++) {
        for (int k = 0; k < 2; k++) {
            WadPoint v = map->vertices[map->lines[i].v[k]];
            box[0] = (WadPoint){v.x < box[0].x ? v.x : box[0].x, v.y < box[0].y ? v.y : box[0].y, 1};
            box[1] = (WadPoint){v.x > box[1].x ? v.x : box[1].x, v.y > box[1].y ? v.y : box[1].y, 1};
        }
    }
    *out = (WadPieces){0};
    if (map->line_count == 0)
        return error_set(error, "%s: %s has no lines (allowed: 1 to 65535)", map->path, map->name);
    box[0] = (WadPoint){box[0].x - MARGIN, box[0].y - MARGIN, 1};
    box[1] = (WadPoint){box[1].x + MARGIN, box[1].y + MARGIN, 1};
    list_axes(map, box, arena, out);
    Cutter cutter = {.map = map, .arena = arena, .out = out};
    begin_with_square(&cutter, box);
    while (cutter.task_count > 0 && out->piece_count + cutter.task_count <= MOST_PIECES) cut_last(&cutter);
    bool done = cutter.task_count == 0;
    arena_free(&cutter.scratch);
    return done ||
           error_set(error,
                     "%s: the lines of %s cut its plan into more than %d convex pieces (allowed: as many; "
                     "its lines cross each other where they should meet)",
                     map->path, map->name, MOST_PIECES);
}
