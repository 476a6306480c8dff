// parts.c - the window of a part: the cells that it may see, and all that touches them.
#include "radiosity/mesh/parts.h"

#include "visibility/window.h"

// The objects that touch a cell, each once; `last` [object_count] remembers the last cell, plus one, in which an object was counted.
static void each_touch(const CellGraph *graph, int cell, int *last,
                       void (*body)(void *context, int object, int cell), void *context) {
    const SquareGrid *squares = &graph->grids[cell];
    int first = graph->square_first[squares->first_square],
        end = graph->square_first[squares->first_square + squares->nx * squares->ny];
    for (int k = first; k < end; k++) {
        int object = graph->square_objects[k];
        if (last[object] != cell + 1) body(context, object, cell);
        last[object] = cell + 1;
    }
}

static void count_touch(void *context, int object, int cell) {
    (void)cell;
    ((Parts *)context)->first[object + 2]++;
}

static void list_touch(void *context, int object, int cell) {
    Parts *p = context;
    p->cell[p->first[object + 1]++] = cell;
}

static void find_touches(Parts *p, Arena *arena) {
    const CellGraph *graph = p->graph;
    Arena scratch = {0};
    p->first = ARENA_ARRAY(arena, int, graph->object_count + 2);
    int *last = ARENA_ARRAY(&scratch, int, graph->object_count + 1);
    for (int c = 0; c < graph->cell_count; c++) each_touch(graph, c, last, count_touch, p);
    for (int o = 0; o < graph->object_count; o++) p->first[o + 2] += p->first[o + 1], last[o] = 0;
    p->cell = ARENA_ARRAY(arena, int, p->first[graph->object_count + 1] + 1);
    for (int c = 0; c < graph->cell_count; c++) each_touch(graph, c, last, list_touch, p);
    arena_free(&scratch);
}

// [cell_count] May anything outdoors be seen from a cell?
static bool *find_open(const CellGraph *graph, const StabForest *forest, Arena *arena) {
    bool *open = ARENA_ARRAY(arena, bool, graph->cell_count + 1);
    int *seen = ARENA_ARRAY(arena, int, graph->cell_count + 1);
    for (int c = 0; c < graph->cell_count; c++) {
        int count = cell_rows_list(&forest->seen, c, seen);
        for (int i = 0; i < count && !open[c]; i++)
            open[c] = vis_region(graph, seen[i])->kind == REGION_OUTDOORS;
    }
    return open;
}

// Numbers parts of such cells of all groups, open or not, from `part` on; each has whole groups of them. Returns the next number.
static int number_parts(const CellGroups *groups, const bool *open, bool which, int cells, int part,
                        int *owner) {
    int count = 0;
    for (int g = 0; g < groups->count; g++) {
        int of_group = 0;
        for (int i = groups->first[g]; i < groups->first[g + 1]; i++)
            of_group += open[groups->cell[i]] == which;
        if (count > 0 && count + of_group > cells) {
            part++;
            count = 0;
        }
        count += of_group;
        for (int i = groups->first[g]; i < groups->first[g + 1]; i++)
            if (open[groups->cell[i]] == which) owner[groups->cell[i]] = part;
    }
    return part + (count > 0);
}

static int find_owners(const CellGraph *graph, const StabForest *forest, int cells, int *owner) {
    Arena scratch = {0};
    CellGroups groups = cell_groups(graph, cells, &scratch);
    const bool *open = find_open(graph, forest, &scratch);
    int count = 1;
    if (groups.count > 1) {
        count = number_parts(&groups, open, false, cells, 0, owner);
        count = number_parts(&groups, open, true, cells, count, owner);
    }
    arena_free(&scratch);
    return count;
}

Parts parts_of(const CellGraph *graph, const StabForest *forest, int cells, Arena *arena) {
    Parts p = {.graph = graph,
               .owner = ARENA_ARRAY(arena, int, graph->object_count + 1),
               .cell_owner = ARENA_ARRAY(arena, int, graph->cell_count + 1)};
    p.count = find_owners(graph, forest, cells, p.cell_owner);
    find_touches(&p, arena);
    // An object that touches no cell is in a wall. One of several parts belongs to that which sees the outdoors, if any does.
    for (int o = 0; o < graph->object_count; o++)
        for (int i = p.first[o]; i < p.first[o + 1]; i++)
            if (p.cell_owner[p.cell[i]] > p.owner[o]) p.owner[o] = p.cell_owner[p.cell[i]];
    for (int c = 0; c < graph->cell_count; c++)
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++)
            p.owner[o] = p.cell_owner[c];
    p.boxes = box_tree_build(graph->object_boxes, graph->object_count, arena);
    return p;
}

// Marks the cells of marked objects.
static void mark_cells(const Parts *p, const uint64_t *objects, uint64_t *cells) {
    for (int o = 0; o < p->graph->object_count; o++)
        for (int i = p->first[o]; objects[o / 64] >> o % 64 & 1 && i < p->first[o + 1]; i++)
            cells[p->cell[i] / 64] |= (uint64_t)1 << p->cell[i] % 64;
}

// Marks the objects of marked cells.
static void mark_objects(const Parts *p, const uint64_t *cells, uint64_t *objects) {
    for (int o = 0; o < p->graph->object_count; o++)
        for (int i = p->first[o]; i < p->first[o + 1]; i++)
            if (cells[p->cell[i] / 64] >> p->cell[i] % 64 & 1) objects[o / 64] |= (uint64_t)1 << o % 64;
}

// Coordinates of neighbours differ by less, metres.
static const double TOUCH = 1e-3;

MeshPart part_of(const Parts *p, const StabForest *forest, int own, double close, Arena *arena) {
    Arena scratch = {0};
    const CellGraph *graph = p->graph;
    int words = (graph->object_count + 63) / 64, cell_words = (graph->cell_count + 63) / 64;
    uint64_t *seen = ARENA_ARRAY(arena, uint64_t, words + 1), *near = ARENA_ARRAY(arena, uint64_t, words + 1),
             *cells = ARENA_ARRAY(&scratch, uint64_t, cell_words + 1),
             *window = ARENA_ARRAY(&scratch, uint64_t, cell_words + 1);
    BoxHits hits = {0};
    for (int o = 0; o < graph->object_count; o++)
        if (p->owner[o] == own) seen[o / 64] |= (uint64_t)1 << o % 64;
    mark_cells(p, seen, cells);
    for (int c = 0; c < graph->cell_count; c++)
        if (p->cell_owner[c] == own || cells[c / 64] >> c % 64 & 1) cell_rows_join(&forest->seen, c, window);
    mark_objects(p, window, seen);
    for (int o = 0; o < graph->object_count; o++) {
        if (!(seen[o / 64] >> o % 64 & 1)) continue;
        near[o / 64] |= (uint64_t)1 << o % 64;
        int count =
            box_tree_find(&p->boxes, box_grow(graph->object_boxes[o], close + TOUCH), &scratch, &hits);
        for (int i = 0; i < count; i++) near[hits.items[i] / 64] |= (uint64_t)1 << hits.items[i] % 64;
    }
    arena_free(&scratch);
    return (MeshPart){
        .own = own, .owner = p->owner, .cell_owner = p->cell_owner, .objects = near, .seen = seen};
}
