// flood.c - the coarsest method: the cells that a flood through open portals reaches, way by way.
#include <omp.h>

#include "visibility/pairs/ways.h"

static void find(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                 PairSet *out) {
    *out = pair_set_new(graph, arena);
    Arena scratch = {0};
    WayGraph ways;
    ways_build(graph, &scratch, &ways);
    int threads = options->threads > 0 ? options->threads : omp_get_num_procs(), done = 0;
    bool stopped = false;
    long long tried = 0;
#pragma omp parallel num_threads(threads) reduction(+ : tried)
    {
        Arena own = {0};
        int *stack = ARENA_ARRAY(&own, int, ways.cell_count);
        uint64_t *flood = ARENA_ARRAY(&own, uint64_t, ways.words);
#pragma omp for schedule(dynamic, 4)
        for (int c = 0; c < ways.cell_count; c++) {
            uint64_t *row = out->seen + (size_t)c * (size_t)out->words;
            bool stop;
#pragma omp atomic read
            stop = stopped;
            if (stop) {
                for (int i = 0; i < ways.cell_count; i++) row_add(row, i);
                continue;
            }
            for (int i = ways.first[c]; i < ways.first[c + 1]; i++) {
                memset(flood, 0, (size_t)ways.words * sizeof *flood);
                tried += ways_flood(&ways, ways.list[i], flood, stack);
                for (int k = 0; k < ways.words; k++) row[k] |= flood[k];
            }
#pragma omp critical
            if (!progress_report(progress, "flood", (double)++done / ways.cell_count)) {
#pragma omp atomic write
                stopped = true;
            }
        }
        arena_free(&own);
    }
    arena_free(&scratch);
    pair_set_make_symmetric(out);
    out->stopped = stopped;
    out->work.chains = tried;
}

const PairMethod PAIR_METHOD_FLOOD = {
    .name = "flood", .summary = "through open portals, each beyond the first one", .find = find};
