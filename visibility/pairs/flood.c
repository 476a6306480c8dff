// flood.c - the coarsest bound: the cells that a flood through open portals reaches.
//
// From each way out of a cell the flood passes a further portal only where a line could cross both: each must lie at
// least partly on the far side of the other (the base pass of Quake's vis, J. Carmack 1996).
#include <omp.h>
#include <string.h>

#include "visibility/pairs/pairs.h"

// How far a portal's corner may lie on the wrong side of another's plane and still be reached, relative to the size of
// the building: beyond the rounding of its coordinates, and erring towards visible.
static const double SIDE_SLACK = 1e-9;

typedef struct Flood {
    const CellGraph *graph;
    double slack;            // metres
    int *stack;              // [cell_count]
    unsigned char *entered;  // [cell_count]
    long long tested;
} Flood;

static bool reaches(const Flood *f, const Portal *what, Plane plane, int side) {
    for (int i = 0; i < what->vertex_count; i++) {
        Vec3 p = f->graph->portal_vertices[what->first_vertex + i];
        if (side * plane_distance(plane, p) > -f->slack) return true;
    }
    return false;
}

static void flood_from(Flood *f, int source, Contact way, uint64_t *row) {
    const CellGraph *graph = f->graph;
    memset(f->entered, 0, (size_t)graph->cell_count);
    const Portal *first = &graph->portals[way.portal];
    int first_side = first->cell[0] == source ? -1 : 1, depth = 0;
    f->entered[source] = f->entered[way.cell] = 1;
    row[way.cell / 64] |= (uint64_t)1 << (way.cell % 64);
    f->stack[depth++] = way.cell;
    while (depth > 0) {
        int cell = f->stack[--depth];
        const Cell *from = &graph->cells[cell];
        for (int i = from->first_contact; i < from->first_contact + from->contact_count; i++) {
            int to = graph->contacts[i].cell;
            if (f->entered[to]) continue;
            const Portal *next = &graph->portals[graph->contacts[i].portal];
            int near_side = next->cell[0] == cell ? 1 : -1;
            f->tested++;
            if (!reaches(f, next, first->plane, first_side) || !reaches(f, first, next->plane, near_side))
                continue;
            f->entered[to] = 1;
            row[to / 64] |= (uint64_t)1 << (to % 64);
            f->stack[depth++] = to;
        }
    }
}

static void find(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                 PairSet *out) {
    *out = pair_set_new(graph, arena);
    int threads = options->threads > 0 ? options->threads : omp_get_num_procs(), done = 0;
    Vec3 size = vec3_sub(graph->box.max, graph->box.min);
    long long tested = 0;
    bool stopped = false;
#pragma omp parallel num_threads(threads) reduction(+ : tested)
    {
        Arena scratch = {0};
        Flood f = {.graph = graph,
                   .slack = SIDE_SLACK * vec3_length(size),
                   .stack = ARENA_ARRAY(&scratch, int, graph->cell_count),
                   .entered = ARENA_ARRAY(&scratch, unsigned char, graph->cell_count)};
#pragma omp for schedule(dynamic, 4)
        for (int c = 0; c < graph->cell_count; c++) {
            uint64_t *row = out->seen + (size_t)c * (size_t)out->words;
            bool stop;
#pragma omp atomic read
            stop = stopped;
            if (stop) {
                memset(row, 0xff, (size_t)out->words * sizeof *row);
                if (graph->cell_count % 64) row[out->words - 1] = ((uint64_t)1 << graph->cell_count % 64) - 1;
                continue;
            }
            const Cell *cell = &graph->cells[c];
            for (int i = 0; i < cell->contact_count; i++)
                flood_from(&f, c, graph->contacts[cell->first_contact + i], row);
            row[c / 64] |= (uint64_t)1 << (c % 64);
#pragma omp critical
            {
                done++;
                if (!progress_report(progress, "flood", (double)done / graph->cell_count)) {
#pragma omp atomic write
                    stopped = true;
                }
            }
        }
        tested = f.tested;
        arena_free(&scratch);
    }
    pair_set_make_symmetric(out);
    out->stopped = stopped;
    out->work.chains = tested;
}

const PairMethod PAIR_METHOD_FLOOD = {"flood", "through open portals, each beyond the first", find};
