// lamp_ways.c - sets of lamps by object, and floods from cell to cell through the portals that a shaft meets.
#include "radiosity/show/lamp_ways.h"

typedef struct ObjectCells {
    int first, end;  // in LampWays.cells
} ObjectCells;

struct LampWays {
    const CellGraph *graph;
    const int *lamp;  // [lamp_count]
    int lamp_count;
    size_t words;
    uint64_t *seen;         // [object_count * words] the lamps that each object may see
    ObjectCells *cells_of;  // [object_count]
    int *cells;
};

struct LampFlood {
    const LampWays *ways;
    int *came, *goal;  // [cell_count] the number of the flood that came last, and of that which is to come
    int *queue;        // [cell_count] cells to which the flood came
    int count, number;
};

// ---- the cells of objects

// Tells of each run of an object in the squares of each cell.
static void each_object(const CellGraph *graph, void (*body)(LampWays *ways, int cell, int object),
                        LampWays *ways) {
    for (int c = 0; c < graph->cell_count; c++) {
        const SquareGrid *squares = &graph->grids[c];
        int first = graph->square_first[squares->first_square],
            end = graph->square_first[squares->first_square + squares->nx * squares->ny];
        for (int k = first; k < end; k++) body(ways, c, graph->square_objects[k]);
    }
}

static void count_cell(LampWays *ways, int cell, int object) {
    (void)cell;
    ways->cells_of[object].end++;
}

static void put_cell(LampWays *ways, int cell, int object) {
    ObjectCells *of = &ways->cells_of[object];
    if (of->end == of->first || ways->cells[of->end - 1] != cell) ways->cells[of->end++] = cell;
}

static void find_cells(LampWays *ways, Arena *arena) {
    const CellGraph *graph = ways->graph;
    int next = 0;
    ways->cells_of = ARENA_ARRAY(arena, ObjectCells, graph->object_count + 1);
    each_object(graph, count_cell, ways);
    for (int o = 0; o < graph->object_count; o++) {
        int count = ways->cells_of[o].end;
        ways->cells_of[o] = (ObjectCells){next, next};
        next += count;
    }
    ways->cells = ARENA_ARRAY(arena, int, next + 1);
    each_object(graph, put_cell, ways);
}

// ---- lamps that objects may see

static void add_lamps(uint64_t *to, const uint64_t *from, size_t words) {
    for (size_t w = 0; w < words; w++) to[w] |= from[w];
}

static void set_lamp(uint64_t *set, int lamp) { set[lamp / 64] |= (uint64_t)1 << lamp % 64; }

// Adds the lamps in a cell to the sets of all cells that it may see. Sight is symmetric.
static void tell_cells(const CellRows *rows, int cell, const uint64_t *inside, size_t words, uint64_t *before,
                       int *list) {
    for (int i = 0, count = cell_rows_list(rows, cell, list); i < count; i++)
        add_lamps(before + (size_t)list[i] * words, inside, words);
}

// For each cell the lamps that it may see, [cell_count * words].
static uint64_t *seen_from_cells(const LampWays *ways, const StabForest *forest, Arena *arena) {
    const CellGraph *graph = ways->graph;
    size_t words = ways->words, cells = (size_t)graph->cell_count;
    uint64_t *inside = ARENA_ARRAY(arena, uint64_t, cells * words + 1);
    uint64_t *before = ARENA_ARRAY(arena, uint64_t, cells * words + 1);
    uint64_t *nowhere = ARENA_ARRAY(arena, uint64_t, words + 1);
    bool *lit = ARENA_ARRAY(arena, bool, cells + 1);
    int *list = ARENA_ARRAY(arena, int, cells + 1);
    for (int i = 0; i < ways->lamp_count; i++) {
        ObjectCells of = ways->cells_of[ways->lamp[i]];
        if (of.first == of.end) set_lamp(nowhere, i);
        for (int k = of.first; k < of.end; k++) {
            set_lamp(inside + (size_t)ways->cells[k] * words, i);
            lit[ways->cells[k]] = true;
        }
    }
    for (int k = 0; k < graph->cell_count; k++)
        if (lit[k]) tell_cells(&forest->seen, k, inside + (size_t)k * words, words, before, list);
    for (size_t c = 0; c < cells; c++) add_lamps(before + c * words, nowhere, words);
    return before;
}

LampWays *lamp_ways_new(const CellGraph *graph, const StabForest *forest, const int *lamp, int lamp_count,
                        Arena *arena) {
    Arena scratch = {0};
    LampWays *ways = ARENA_ARRAY(arena, LampWays, 1);
    *ways = (LampWays){
        .graph = graph, .lamp = lamp, .lamp_count = lamp_count, .words = (size_t)(lamp_count + 63) / 64};
    find_cells(ways, arena);
    uint64_t *before = seen_from_cells(ways, forest, &scratch);
    ways->seen = ARENA_ARRAY(arena, uint64_t, (size_t)graph->object_count * ways->words + 1);
    for (int o = 0; o < graph->object_count; o++) {
        ObjectCells of = ways->cells_of[o];
        uint64_t *seen = ways->seen + (size_t)o * ways->words;
        if (of.first == of.end) memset(seen, 0xff, ways->words * sizeof *seen);
        for (int k = of.first; k < of.end; k++)
            add_lamps(seen, before + (size_t)ways->cells[k] * ways->words, ways->words);
    }
    arena_free(&scratch);
    return ways;
}

int lamp_ways_next(const LampWays *ways, int object, int after) {
    const uint64_t *seen = ways->seen + (size_t)object * ways->words;
    int lamp = after + 1;
    for (size_t w = (size_t)(lamp / 64); w < ways->words; w++, lamp = 64 * (int)w) {
        uint64_t left = seen[w] >> (lamp % 64);
        if (left == 0) continue;
        lamp += __builtin_ctzll(left);
        return lamp < ways->lamp_count ? lamp : -1;
    }
    return -1;
}

// ---- floods

LampFlood *lamp_flood_new(const LampWays *ways, Arena *arena) {
    int cells = ways->graph->cell_count + 1;
    LampFlood *flood = ARENA_ARRAY(arena, LampFlood, 1);
    *flood = (LampFlood){.ways = ways,
                         .came = ARENA_ARRAY(arena, int, cells),
                         .goal = ARENA_ARRAY(arena, int, cells),
                         .queue = ARENA_ARRAY(arena, int, cells)};
    return flood;
}

// Is the cell, to which the flood comes, the goal?
static bool comes_to(LampFlood *flood, int cell) {
    if (flood->came[cell] == flood->number) return false;
    flood->came[cell] = flood->number;
    flood->queue[flood->count++] = cell;
    return flood->goal[cell] == flood->number;
}

static bool leaves(LampFlood *flood, const Shaft *shaft, int cell) {
    const CellGraph *graph = flood->ways->graph;
    const Cell *from = &graph->cells[cell];
    for (int i = from->first_way; i < from->first_way + from->way_count; i++) {
        const Portal *portal = &graph->portals[graph->ways[i].portal];
        int beyond = graph->ways[i].cell;
        if (flood->came[beyond] == flood->number ||
            !shaft_is_met(shaft, graph->portal_vertices + portal->first_vertex, portal->vertex_count))
            continue;
        if (comes_to(flood, beyond)) return true;
    }
    return false;
}

bool lamp_flood_reaches(LampFlood *flood, const Shaft *shaft, int from, int to) {
    const LampWays *ways = flood->ways;
    ObjectCells start = ways->cells_of[from], goal = ways->cells_of[to];
    if (start.first == start.end || goal.first == goal.end) return true;
    flood->number++;
    flood->count = 0;
    for (int i = goal.first; i < goal.end; i++) flood->goal[ways->cells[i]] = flood->number;
    for (int i = start.first; i < start.end; i++)
        if (comes_to(flood, ways->cells[i])) return true;
    for (int next = 0; next < flood->count; next++)
        if (leaves(flood, shaft, flood->queue[next])) return true;
    return false;
}
