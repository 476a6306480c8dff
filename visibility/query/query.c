// query.c - the visible set of an eye: the stab tree of its cell, walked while the view volume narrows at each
// portal (Teller & Sequin 1991, section 5; Luebke & Georges 1995 for the walk without trees), then the squares of
// each visible cell that the narrowed volume covers in plan (Oki 2.2), then the boxes of the objects there.
//
// The narrowed volume is a cone: planes through the eye. It is kept a little too large, so that nothing a rasteriser
// could show is lost: see ANGLE_SLACK and POSITION_SLACK.
#include <string.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/query/query.h"

const char *const CULLING_NAMES[CULLINGS] = {"none", "frustum", "portals", "plan", "stab", "depth", "cells"};

static int forest_depth(const StabForest *forest, Arena *scratch) {
    int deepest = 1, *depth = ARENA_ARRAY(scratch, int, forest->node_count);
    for (int i = 0; i < forest->node_count; i++) {
        depth[i] = forest->nodes[i].parent < 0 ? 1 : depth[forest->nodes[i].parent] + 1;
        if (depth[i] > deepest) deepest = depth[i];
    }
    return deepest;
}

static void list_traits(VisQuery *q, Arena *arena) {
    const CellGraph *graph = q->graph;
    q->traits = arena_alloc(arena, (size_t)graph->object_count, sizeof *q->traits);
    for (int i = 0; i < graph->object_count; i++) {
        const Object *object = &graph->objects[i];
        q->traits[i].polygon_count = object->polygon_count;
        q->traits[i].plug = object->plug ? object->opening : -1;
    }
}

static void *copy_of(const void *from, int count, size_t size, Arena *arena) {
    void *copy = arena_alloc(arena, (size_t)count, size);
    if (count > 0) memcpy(copy, from, (size_t)count * size);
    return copy;
}

// A query has its own of what it writes.
static void share_lists(VisQuery *q, const VisQuery *from, Arena *arena) {
    q->of_cell = copy_of(from->of_cell, q->graph->cell_count, sizeof *q->of_cell, arena);
    for (int c = 0; c < q->graph->cell_count; c++) q->of_cell[c].frame = 0;
    q->boxes = from->boxes;
    q->middle = from->middle;
    q->ways = from->ways;
    q->block_count = from->block_count;
    q->portal_of = from->portal_of;
    q->way_of = from->way_of;
    q->sloped = copy_of(from->sloped, from->sloped_count, sizeof *q->sloped, arena);
    q->sloped_count = from->sloped_count;
    q->traits = from->traits;
    q->depth = from->depth;
}

VisQuery *vis_query_new(const CellGraph *graph, const StabForest *forest, Arena *arena) {
    VisQuery *q = arena_alloc(arena, 1, sizeof *q);
    q->graph = graph;
    q->forest = forest;
    q->every_cell = ARENA_ARRAY(arena, uint64_t, forest->words);
    q->joined = ARENA_ARRAY(arena, uint64_t, forest->words);
    q->joined_cell = ARENA_ARRAY(arena, int, graph->cell_count);
    memset(q->every_cell, 0xff, (size_t)forest->words * sizeof *q->every_cell);
    q->cells = ARENA_ARRAY(arena, VisibleCell, graph->cell_count);
    q->spare = ARENA_ARRAY(arena, VisibleCell, graph->cell_count);
    q->drawn = ARENA_ARRAY(arena, uint64_t, graph->object_count / 64 + 1);
    q->drawn_words = ARENA_ARRAY(arena, uint64_t, graph->object_count / 4096 + 1);
    q->object_tested = ARENA_ARRAY(arena, unsigned, graph->object_count + 1);
    q->objects = ARENA_ARRAY(arena, int, graph->object_count + 1);
    if (graph->query && graph->query->forest == forest) {
        share_lists(q, graph->query, arena);
    } else {
        q->of_cell = ARENA_ARRAY(arena, CellView, graph->cell_count);
        query_list_objects(q, arena);
        query_list_ways(q, arena);
        list_traits(q, arena);
        Arena scratch = {0};
        q->depth = forest_depth(forest, &scratch);
        arena_free(&scratch);
    }
    q->cones = ARENA_ARRAY(arena, Cone, q->depth + 1);
    query_prepare_walk(q, arena);
    return q;
}

void vis_share_query(CellGraph *graph, const StabForest *forest, Arena *arena) {
    graph->query = vis_query_new(graph, forest, arena);
}

bool vis_shown(const Object *object, const float *door_open) {
    return !object->plug || (door_open && door_open[object->opening] == 0);
}

// ---- the walk

// The cone beyond one of the ways in sight, and how far it is; false where nothing of it is in view.
static bool pass_way(const VisQuery *q, Cone *cone, int index, const Sight *sight, Cone *beyond,
                     double *distance) {
    int lane = index % FOUR;
    if (sight->slots >> lane & 1) {
        query_slot_cone(&sight->slot, &q->ways[index / FOUR], lane, q->eye->position, q->culling == CULL_PLAN,
                        beyond);
        *distance = query_slots_distance(&sight->slot, sight->ahead)[lane];
        return true;
    }
    if (!(sight->others >> lane & 1)) return false;
    ViewWay way = query_way(q, index);
    ViewPart part;
    Passage passage = query_clip(q, cone, &way, &part);
    if (passage == PASSAGE_NONE) return false;
    query_beyond(q, cone, passage, &way, &part, beyond);
    *distance = part.distance;
    return true;
}

// The cone of each depth narrows to that of the next.
static void walk_tree(VisQuery *q, int node, int depth) {
    const StabNode *nodes = q->forest->nodes;
    Cone *cone = &q->cones[depth], *beyond = &q->cones[depth + 1];
    int first = node + 1, end = q->forest->node_count, block = -1;
    Sight sight;
    for (int child = first < end && nodes[first].parent == node ? first : -1; child >= 0;
         child = nodes[child].next) {
        int portal = nodes[child].portal;
        bool forward = q->graph->portals[portal].cell[0] == nodes[node].cell;
        int way = q->way_of[2 * portal + (forward ? 0 : 1)];
        if (way / FOUR != block) query_sight(q, cone, block = way / FOUR, FOUR_ALL, &sight);
        double distance;
        q->result.portals_tested++;
        if (!pass_way(q, cone, way, &sight, beyond, &distance)) continue;
        if (query_enter(q, way, beyond, distance)) walk_tree(q, child, depth + 1);
    }
}

// ---- results

static void draw_all(VisQuery *q, bool by_frustum) {
    for (int i = 0; i < q->graph->object_count; i++) {
        if (by_frustum) {
            q->result.objects_tested++;
            if (query_box_outside(q->graph->object_boxes[i], q->eye->frustum, q->eye->frustum_count,
                                  q->eye->position))
                continue;
        }
        query_draw_object(q, i);
    }
}

static void collect_word(VisQuery *q, int word) {
    VisResult *result = &q->result;
    for (uint64_t bits = q->drawn[word]; bits; bits &= bits - 1) {
        int object = word * 64 + __builtin_ctzll(bits);
        int plug = q->traits[object].plug;
        if (plug >= 0 && !(q->door_open && q->door_open[plug] == 0)) continue;
        q->objects[result->object_count++] = object;
        result->polygon_count += q->traits[object].polygon_count;
    }
    q->drawn[word] = 0;
}

static void collect_objects(VisQuery *q) {
    for (int block = 0; block <= q->graph->object_count / 4096; block++) {
        for (uint64_t words = q->drawn_words[block]; words; words &= words - 1)
            collect_word(q, block * 64 + __builtin_ctzll(words));
        q->drawn_words[block] = 0;
    }
}

enum { SHORT_RUN = 16 };

static bool is_nearer(const VisibleCell *a, const VisibleCell *b) {
    return a->distance < b->distance || (a->distance == b->distance && a->cell < b->cell);
}

// Cells come nearly in order, and short runs are mended in place.
static void sort_run(VisibleCell *cells, int count) {
    for (int i = 1; i < count; i++) {
        VisibleCell cell = cells[i];
        int at = i;
        for (; at > 0 && is_nearer(&cell, &cells[at - 1]); at--) cells[at] = cells[at - 1];
        cells[at] = cell;
    }
}

// Merges runs of twice the length each time; qsort may allocate.
static void sort_cells(VisQuery *q) {
    int count = q->result.cell_count;
    for (int first = 0; first < count; first += SHORT_RUN)
        sort_run(q->cells + first, count - first < SHORT_RUN ? count - first : SHORT_RUN);
    for (int run = SHORT_RUN; run < count; run *= 2) {
        for (int first = 0; first < count; first += 2 * run) {
            int a = first, middle = first + run < count ? first + run : count, b = middle,
                end = middle + run < count ? middle + run : count;
            for (int k = first; k < end; k++) {
                bool left = a < middle && (b >= end || !is_nearer(&q->cells[b], &q->cells[a]));
                q->spare[k] = q->cells[left ? a++ : b++];
            }
        }
        VisibleCell *swap = q->cells;
        q->cells = q->spare;
        q->spare = swap;
    }
    q->result.cells = q->cells;
}

// The cells that an eye may see whose view begins in these cells: rounding may put it in any of them, and a line from there along a
// portal's plane is no line from its own.
static const uint64_t *visible_set(VisQuery *q, const int *around, int count) {
    // Only what is there from the last time: the set of all cells is long in a large building.
    for (int i = 0; i < q->joined_count; i++) cell_rows_clear(&q->forest->seen, q->joined_cell[i], q->joined);
    q->joined_count = count;
    for (int i = 0; i < count; i++) {
        q->joined_cell[i] = around[i];
        cell_rows_join(&q->forest->seen, around[i], q->joined);
    }
    return q->joined;
}

// Fetches into the cache the data that the walk begins with.
static void prefetch_start(const VisQuery *q, int cell) {
    CellRow row = q->forest->seen.row[cell];
    for (int k = 0; k < row.count; k++) __builtin_prefetch(row.runs[k].words);
    const char *ways = (const char *)&q->ways[q->of_cell[cell].first_block];
    for (size_t line = 0; line < sizeof(WayBlock); line += CACHE_LINE) __builtin_prefetch(ways + line);
}

// Fetches the cells that the last query saw: frames draw much between two queries, and from one to the next little changes in view.
static void prefetch_last(const VisQuery *q) {
    enum { LISTS = 8 };  // ahead, where the lists of a cell are
    int count = q->result.cell_count;
    if (count == 0) return;  // all was drawn
    for (int i = 0; i < count + LISTS; i++) {
        if (i < count) __builtin_prefetch(&q->of_cell[q->cells[i].cell]);
        if (i < LISTS) continue;
        const CellView *cell = &q->of_cell[q->cells[i - LISTS].cell];
        const char *ways = (const char *)&q->ways[cell->first_block];
        size_t size = (size_t)cell->block_count * sizeof *q->ways;
        for (size_t line = 0; line < size; line += CACHE_LINE) __builtin_prefetch(ways + line);
        query_prefetch_boxes(q, q->cells[i - LISTS].cell);
    }
    for (int i = 0; i < q->result.object_count; i++) __builtin_prefetch(&q->traits[q->objects[i]]);
}

// From a cell, by its stab tree where `trees` says so and it has one.
static void walk_from(VisQuery *q, int cell, bool trees) {
    query_first_cone(q, &q->cones[0]);
    query_visit_cell(q, cell, 0, &q->cones[0]);
    if (trees && !q->forest->bounded[cell]) {
        walk_tree(q, q->forest->root[cell], 0);
    } else {
        query_walk(q, cell);
    }
}

// A line from the eye may begin in any of these cells. Where there are several, portals are walked, each once for all of them. A line that
// a mirror sends on begins in one of the cells that the mirror touches: they may lie apart, and each has its own tree.
static void walk(VisQuery *q, const int *around, int count) {
    bool trees = q->culling != CULL_PORTALS;
    q->limit = trees ? visible_set(q, around, count) : q->every_cell;
    for (int i = 0; i < count; i++) walk_from(q, around[i], trees && (count == 1 || q->eye->start_count > 0));
}

VisResult vis_query(VisQuery *q, const Eye *eye, int cell, const float *door_open, Culling culling) {
    CORE_ASSERT(cell < q->graph->cell_count && culling < QUERY_CULLINGS);
    prefetch_last(q);
    q->eye = eye;
    q->door_open = door_open;
    q->culling = culling;
    q->result = (VisResult){.cells = q->cells, .objects = q->objects, .eye_cell = cell};
    q->frame++;
    // Before the counters come round, forget the marks of long ago.
    if (q->frame > UINT32_MAX / 2 || q->cone_serial > UINT32_MAX / 2) {
        for (int c = 0; c < q->graph->cell_count; c++) q->of_cell[c].frame = 0;
        for (int k = 0; k < q->block_count; k++) q->view_frame[k] = 0;
        memset(q->object_tested, 0, (size_t)q->graph->object_count * sizeof *q->object_tested);
        q->frame = 1;
        q->cone_serial = 0;
    }
    if (eye->start_count > 0) cell = q->result.eye_cell = eye->start[0];
    if (cell >= 0) prefetch_start(q, cell);
    int near[MOST_AROUND], count = eye->start_count;
    const int *around = eye->start_count > 0 ? eye->start : near;
    if (count == 0) count = query_eye_cells(q->graph, cell, eye, near);
    if (culling == CULL_NONE || culling == CULL_FRUSTUM || count == 0) {
        draw_all(q, culling != CULL_NONE);
    } else {
        walk(q, around, count);
    }
    collect_objects(q);
    sort_cells(q);
    return q->result;
}
