// window.c - see window.h.
#include "visibility/window.h"

#include <stdlib.h>
#include <string.h>

// The place of a cell along a curve through all space that stays near where it was (G. Morton 1966).
typedef struct Stop {
    uint64_t key;
    int cell;
} Stop;

static int by_curve(const void *p, const void *q) {
    const Stop *a = p, *b = q;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->cell > b->cell) - (a->cell < b->cell);
}

static uint64_t curve_key(Vec3 p, Box box) {
    enum { BITS = 20 };
    Vec3 size = vec3_sub(box.max, box.min);
    double side = fmax(size.x, fmax(size.y, size.z)),
           at[3] = {p.x - box.min.x, p.y - box.min.y, p.z - box.min.z};
    uint64_t key = 0;
    for (int axis = 0; axis < 3; axis++) {
        double share = side > 0 ? fmin(fmax(at[axis] / side, 0), 1) : 0;
        uint64_t whole = (uint64_t)(share * ((1 << BITS) - 1));
        for (int bit = 0; bit < BITS; bit++) key |= (whole >> bit & 1) << (3 * bit + axis);
    }
    return key;
}

bool window_pays(const CellRows *near) {
    double cells = near->cell_count;
    return cells > WINDOW_LEAST && (double)cell_rows_count(near) * WINDOW_SHARE < cells * cells;
}

// Groups grow through portals, each from the first cell of the curve that is left: who sees much of the same is together, and not who
// lives behind the same wall.
static void grow_groups(const CellGraph *graph, int size, const Stop *stops, Arena *arena, int *out) {
    bool *taken = ARENA_ARRAY(arena, bool, graph->cell_count);
    for (int done = 0, next = 0, seed = 0, first = 0; done < graph->cell_count;) {
        if (next == done) {
            while (taken[stops[seed].cell]) seed++;
            taken[stops[seed].cell] = true;
            out[done++] = stops[seed].cell;
        }
        const Cell *cell = &graph->cells[out[next++]];
        for (int w = cell->first_way; w < cell->first_way + cell->way_count && done - first < size; w++) {
            int beyond = graph->ways[w].cell;
            if (taken[beyond]) continue;
            taken[beyond] = true;
            out[done++] = beyond;
        }
        if (done - first == size) first = next = done;
    }
}

CellGroups cell_groups(const CellGraph *graph, int size, Arena *arena) {
    int cells = graph->cell_count;
    CellGroups groups = {.cell = ARENA_ARRAY(arena, int, cells),
                         .count = cells ? (cells + size - 1) / size : 0};
    Stop *stops = ARENA_ARRAY(arena, Stop, cells);
    for (int c = 0; c < cells; c++) {
        Box box = graph->cells[c].box;
        stops[c].cell = c;
        if (groups.count > 1)
            stops[c].key = curve_key(vec3_scale(vec3_add(box.min, box.max), 0.5), graph->box);
    }
    qsort(stops, (size_t)cells, sizeof *stops, by_curve);
    for (int c = 0; c < cells; c++) groups.cell[c] = stops[c].cell;
    if (groups.count > 1) grow_groups(graph, size, stops, arena, groups.cell);
    groups.first = ARENA_ARRAY(arena, int, groups.count + 1);
    for (int g = 0; g <= groups.count; g++) groups.first[g] = g < groups.count ? g * size : cells;
    return groups;
}

// The first cell of those that portals join to this one, as far as they are joined by now (R. Tarjan 1975).
static int first_joined(int *joined, int cell) {
    while (joined[cell] != cell) {
        joined[cell] = joined[joined[cell]];
        cell = joined[cell];
    }
    return cell;
}

CellGroups cell_houses(const CellGraph *graph, int least, Arena *arena) {
    int cells = graph->cell_count;
    int *joined = ARENA_ARRAY(arena, int, cells), *size = ARENA_ARRAY(arena, int, cells),
        *group = ARENA_ARRAY(arena, int, cells);
    CellGroups houses = {.cell = ARENA_ARRAY(arena, int, cells), .first = ARENA_ARRAY(arena, int, cells + 1)};
    for (int c = 0; c < cells; c++) joined[c] = c;
    for (int p = 0; p < graph->portal_count; p++) {
        int a = first_joined(joined, graph->portals[p].cell[0]),
            b = first_joined(joined, graph->portals[p].cell[1]);
        joined[a > b ? a : b] = a > b ? b : a;
    }
    for (int c = 0; c < cells; c++) size[joined[c] = first_joined(joined, c)]++;
    for (int c = 0, together = least; c < cells; c++) {
        if (joined[c] == c) {
            if (together >= least) houses.count++, together = 0;
            group[c] = houses.count - 1;
            together += size[c];
        }
        group[c] = group[joined[c]];
        houses.first[group[c] + 1]++;
    }
    for (int g = 0; g < houses.count; g++) houses.first[g + 1] += houses.first[g];
    int *next = ARENA_ARRAY(arena, int, houses.count);
    for (int c = 0; c < cells; c++) houses.cell[houses.first[group[c]] + next[group[c]]++] = c;
    return houses;
}

static int by_place_in_list(const void *p, const void *q) {
    int a = *(const int *)p, b = *(const int *)q;
    return (a > b) - (a < b);
}

// The portals between cells of the window.
static void add_portals(const CellGraph *graph, const int *place, Arena *arena, CellWindow *out) {
    int count = 0;
    for (int i = 0; i < out->graph.cell_count; i++) count += graph->cells[out->cell[i]].way_count;
    out->portal = ARENA_ARRAY(arena, int, count);
    count = 0;
    for (int i = 0; i < out->graph.cell_count; i++) {
        const Cell *cell = &graph->cells[out->cell[i]];
        for (int w = cell->first_way; w < cell->first_way + cell->way_count; w++) {
            int p = graph->ways[w].portal;
            const Portal *portal = &graph->portals[p];
            if (portal->cell[0] == out->cell[i] && place[portal->cell[1]] >= 0) out->portal[count++] = p;
        }
    }
    qsort(out->portal, (size_t)count, sizeof *out->portal, by_place_in_list);
    out->graph.portals = ARENA_ARRAY(arena, Portal, count);
    out->graph.portal_count = count;
    for (int p = 0; p < count; p++) {
        Portal *portal = &out->graph.portals[p];
        *portal = graph->portals[out->portal[p]];
        for (int side = 0; side < 2; side++) portal->cell[side] = place[portal->cell[side]];
    }
}

// `cells`, ascending, with the portals between them; `place` of all others is -1.
static void take_cells(const CellGraph *graph, int *cells, int count, int *place, Arena *arena,
                       CellWindow *out) {
    *out = (CellWindow){.cell = cells};
    out->graph = (CellGraph){.building = graph->building,
                             .portal_vertices = graph->portal_vertices,
                             .portal_vertex_count = graph->portal_vertex_count,
                             .cell_count = count,
                             .box = graph->box,
                             .touch = graph->touch};
    for (int i = 0; i < count; i++) place[cells[i]] = i;
    add_portals(graph, place, arena, out);
}

void window_enter(const CellGraph *graph, const CellRows *near, const int *group, int count, int *place,
                  Arena *arena, CellWindow *out) {
    int most = 0, cells = 0;
    for (int i = 0; i < count; i++) most += cell_rows_size(near, group[i]);
    if (most > graph->cell_count) most = graph->cell_count;
    // A list may be as long as all cells, behind those that are there already.
    int *all = ARENA_ARRAY(arena, int, most), *list = ARENA_ARRAY(arena, int, most);
    for (int i = 0; i < count; i++) {
        int seen = cell_rows_list(near, group[i], list);
        for (int k = 0; k < seen; k++) {
            if (place[list[k]] >= 0) continue;
            place[list[k]] = 0;
            all[cells++] = list[k];
        }
    }
    qsort(all, (size_t)cells, sizeof *all, by_place_in_list);
    take_cells(graph, all, cells, place, arena, out);
    out->own = ARENA_ARRAY(arena, uint64_t, (cells + 63) / 64);
    out->own_count = count;
    for (int i = 0; i < count; i++) out->own[place[group[i]] / 64] |= (uint64_t)1 << (place[group[i]] % 64);
}

void window_of_house(const CellGraph *graph, const int *group, int count, int *place, Arena *arena,
                     CellWindow *out) {
    int *cells = ARENA_ARRAY(arena, int, count);
    memcpy(cells, group, (size_t)count * sizeof *cells);
    take_cells(graph, cells, count, place, arena, out);
    CellGraph *house = &out->graph;
    house->cells = ARENA_ARRAY(arena, Cell, count);
    house->way_count = 2 * house->portal_count;
    house->ways = ARENA_ARRAY(arena, Way, house->way_count);
    for (int p = 0; p < house->portal_count; p++)
        for (int side = 0; side < 2; side++) house->cells[house->portals[p].cell[side]].way_count++;
    for (int i = 0, way = 0; i < count; i++) {
        Cell *cell = &house->cells[i];
        cell->box = graph->cells[cells[i]].box;
        cell->first_way = way;
        way += cell->way_count;
        cell->way_count = 0;
    }
    for (int p = 0; p < house->portal_count; p++)
        for (int side = 0; side < 2; side++) {
            Cell *cell = &house->cells[house->portals[p].cell[side]];
            house->ways[cell->first_way + cell->way_count++] = (Way){p, house->portals[p].cell[!side]};
        }
}

void window_leave(const CellWindow *window, int *place) {
    for (int i = 0; i < window->graph.cell_count; i++) place[window->cell[i]] = -1;
}
