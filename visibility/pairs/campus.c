// campus.c - see campus.h. Houses that no portal joins are searched one by one. In a large house first a merged search from every way,
// which follows nothing but portals that its beam meets, bounds what may be seen through the way. Within these bounds, and no farther,
// each group of cells is searched in a window of its own.
#include "visibility/pairs/campus.h"

#include <stdlib.h>

#include "engine/core/parallel.h"
#include "visibility/pairs/merged.h"
#include "visibility/pairs/proof.h"
#include "visibility/window.h"

// The cells that may be seen through each way.
typedef struct Bounds {
    WayGraph ways;
    int **cells;  // [way_count] lists
    int *count;   // [way_count] -1: not found
    Flow *flows;  // [threads], as are these
    int **found;  // [cell_count] a list while it is made
    Arena *own;   // of lists
    long long *spent;
    bool many;  // more cells than one matrix has
    int *way;   // of the run
    int threads;
} Bounds;

static void bound_way(void *context, int index, int thread) {
    Bounds *b = context;
    int way = b->way[index];
    Flow *flow = &b->flows[thread];
    b->spent[index] = flow->spent = 0;
    if (b->cells[way]) return;
    int count = merged_cells(flow, way, b->found[thread], b->ways.cell_count);
    b->spent[index] = flow->spent;
    b->count[way] = count;
    if (count < 0) return;
    b->cells[way] = ARENA_ARRAY(&b->own[thread], int, count);
    memcpy(b->cells[way], b->found[thread], (size_t)count * sizeof *b->found[thread]);
}

// A way as it is told to other processes: work, the number of cells, the cells.
typedef struct PackedWay {
    long long spent;
    int count;
} PackedWay;

static Bytes pack_way(void *context, int index, Arena *arena) {
    const Bounds *b = context;
    int way = b->way[index], count = b->count[way];
    PackedWay head = {b->spent[index], count};
    size_t cells = count > 0 ? (size_t)count * sizeof *b->cells[way] : 0;
    Bytes out = {arena_alloc(arena, sizeof head + cells, 1), sizeof head + cells};
    memcpy(out.data, &head, sizeof head);
    if (cells > 0) memcpy(out.data + sizeof head, b->cells[way], cells);
    return out;
}

static void unpack_way(void *context, int index, Bytes result) {
    Bounds *b = context;
    int way = b->way[index];
    PackedWay head;
    memcpy(&head, result.data, sizeof head);
    b->spent[index] = head.spent;
    b->count[way] = head.count;
    if (b->cells[way] || head.count < 0) return;
    b->cells[way] = ARENA_ARRAY(&b->own[0], int, head.count);
    memcpy(b->cells[way], result.data + sizeof head, result.size - sizeof head);
}

// Work of a way in the mean, see ways_work: of rooms some tens of microseconds. Of more than VIS_MANY_CELLS, which have no other search,
// it may be more.
static long long bound_work(const WayGraph *ways) {
    return ways->cell_count > VIS_MANY_CELLS ? 2000000 : 200000;
}

enum { RUN = 1024 };

// Bounds the ways of a run, and adds what was done to `spent`. False where one of them takes too long.
static bool bound_run(Bounds *b, int count, long long allowed, long long *spent) {
    SharedLoop loop = {count, bound_way, pack_way, unpack_way, b};
    for (int i = 0; i < b->threads; i++) b->flows[i].allowed = allowed - *spent;
    parallel_share(b->threads, &loop);
    for (int i = 0; i < count; i++) {
        *spent += b->spent[i];
        if (b->count[b->way[i]] < 0) return false;
    }
    return *spent <= allowed;
}

// Do some ways, from all over the building, see so much that windows will hardly pay (window_pays)? Then one matrix has the pairs.
static bool much_is_seen(Bounds *b, long long *spent) {
    enum { SAMPLE = 64, TWICE = 2 };
    int ways = b->ways.way_count, count = ways < SAMPLE ? ways : SAMPLE;
    double cells = 0;
    for (int i = 0; i < count; i++) b->way[i] = (int)((long long)i * ways / count);
    if (!bound_run(b, count, bound_work(&b->ways) * ways, spent)) return true;
    for (int i = 0; i < count; i++) cells += b->count[b->way[i]];
    return cells * WINDOW_SHARE > TWICE * (double)count * b->ways.cell_count;
}

// False where it takes too long, or progress asked to stop.
static bool bound_ways(Bounds *b, const Progress *progress, Arena *scratch) {
    enum { AHEAD = 16 * RUN };
    int ways = b->ways.way_count;
    long long spent = 0;
    b->spent = ARENA_ARRAY(scratch, long long, RUN);
    b->way = ARENA_ARRAY(scratch, int, RUN);
    if (!b->many && much_is_seen(b, &spent)) return false;
    for (int first = 0; first < ways; first += RUN) {
        int count = ways - first < RUN ? ways - first : RUN;
        if (!parallel_agree(progress_report(progress, "bounds", (double)first / ways))) return false;
        // The first ways may take what is meant for others.
        int ahead = ways < first + AHEAD ? ways : first + AHEAD;
        for (int i = 0; i < count; i++) b->way[i] = first + i;
        if (!bound_run(b, count, bound_work(&b->ways) * ahead, &spent)) return false;
    }
    return true;
}

static int by_cell_number(const void *p, const void *q) {
    int a = *(const int *)p, b = *(const int *)q;
    return (a > b) - (a < b);
}

// The cells that each cell may see through one of its ways, itself among them, as far as these may see it.
static CellRows unite_bounds(const Bounds *b, Arena *scratch) {
    const WayGraph *ways = &b->ways;
    CellRows rows = cell_rows_new(ways->cell_count, scratch);
    Arena own = {0};
    int *list = ARENA_ARRAY(&own, int, ways->cell_count), *stamp = ARENA_ARRAY(&own, int, ways->cell_count);
    for (int c = 0; c < ways->cell_count; c++) {
        int count = 0;
        list[count++] = c;
        stamp[c] = c + 1;
        for (int i = ways->first[c]; i < ways->first[c + 1]; i++) {
            int way = ways->list[i];
            for (int k = 0; k < b->count[way]; k++) {
                int cell = b->cells[way][k];
                if (stamp[cell] == c + 1) continue;
                stamp[cell] = c + 1;
                list[count++] = cell;
            }
        }
        qsort(list, (size_t)count, sizeof *list, by_cell_number);
        cell_rows_set_list(&rows, c, list, count, scratch);
    }
    arena_free(&own);
    cell_rows_make_symmetric(&rows, scratch);
    return rows;
}

// The data of the search in windows.
typedef struct Search {
    const CellGraph *graph;
    const Bounds *bounds;
    CellRows seen, proven;
    Arena *rows;        // of both
    Arena window;       // of a group while it is searched
    int *place, *list;  // [cell_count] of window_enter; -1, and scratch
    PairOptions options;
    const Progress *progress;
    int group, groups;
} Search;

static bool report_group(void *context, const char *stage, double done) {
    const Search *s = context;
    (void)stage;
    return progress_report(s->progress, "sightlines", (s->group + done) / s->groups);
}

static void add_listed(const Search *s, int count, uint64_t *row) {
    for (int i = 0; i < count; i++) {
        if (s->place[s->list[i]] >= 0) row_add(row, s->place[s->list[i]]);
    }
}

// The knowledge so far of the cells and ways in the window.
static void load(const Search *s, const CellWindow *window, Rounds *r) {
    const Bounds *b = s->bounds;
    size_t words = (size_t)r->ways.words;
    for (int c = 0; c < window->graph.cell_count; c++) {
        int cell = window->cell[c];
        add_listed(s, cell_rows_list(&s->seen, cell, s->list), r->set->seen + (size_t)c * words);
        int count = cell_rows_list(&s->proven, cell, s->list);
        add_listed(s, count, r->set->proven + (size_t)c * words);
        for (int i = 0; i < count; i++) {
            int other = s->place[s->list[i]];
            if (other >= 0) row_add(r->set->proven + (size_t)other * words, c);
        }
    }
    for (int w = 0; w < r->ways.way_count; w++) {
        int way = 2 * window->portal[w / 2] + w % 2;
        for (int i = 0; i < b->count[way]; i++) {
            int place = s->place[b->cells[way][i]];
            if (place >= 0) row_add(r->might + (size_t)w * words, place);
        }
    }
}

// The rows of the group's cells. A cell that sees none of the group is not in the window, and in no row.
static void store_group(Search *s, const CellWindow *window, const PairSet *set) {
    for (int c = 0; c < set->cell_count; c++) {
        if (!row_has(window->own, c)) continue;
        for (int k = 0; k < 2; k++) {
            const uint64_t *row = (k ? set->proven : set->seen) + (size_t)c * (size_t)set->words;
            int count = 0;
            for (int w = 0; w < set->words; w++)
                for (uint64_t bits = row[w]; bits; bits &= bits - 1)
                    s->list[count++] = window->cell[64 * w + __builtin_ctzll(bits)];
            cell_rows_set_list(k ? &s->proven : &s->seen, window->cell[c], s->list, count, s->rows);
        }
    }
}

// Decides all pairs of a cell of the group; false when progress asked to stop.
static bool search_group(Search *s, const int *group, int count, ChainWork *work) {
    CellWindow window;
    WayGraph ways;
    PairSet set;
    Rounds rounds;
    Progress progress = {report_group, s};
    arena_reset(&s->window);
    window_enter(s->graph, &s->seen, group, count, s->place, &s->window, &window);
    ways_take(&s->bounds->ways, window.portal, window.graph.portal_count, s->place, window.graph.cell_count,
              &s->window, &ways);
    rounds_open(&rounds, &window.graph, &ways, &s->options, &progress, &s->window, &s->window, &set);
    rounds.own = window.own;
    rounds.ways.scale *= (double)count / s->graph->cell_count;
    load(s, &window, &rounds);
    rounds_agree(&rounds);
    // A proof goes before an exclusion elsewhere, which rounding may have caused.
    for (size_t i = 0; i < (size_t)set.cell_count * (size_t)set.words; i++) set.seen[i] |= set.proven[i];
    proof_search(&rounds, false);
    store_group(s, &window, &set);
    chain_work_add(work, set.work);
    window_leave(&window, s->place);
    return !set.stopped;
}

// Proven pairs are seen from both ends, whatever the group of one of them excluded.
static void keep_proofs(Search *s) {
    for (int c = 0; c < s->seen.cell_count; c++) {
        int count = cell_rows_list(&s->proven, c, s->list);
        for (int i = 0; i < count; i++) {
            int other = s->list[i];
            if (cell_rows_has(&s->seen, other, c)) continue;
            int *row = ARENA_ARRAY(s->rows, int, cell_rows_size(&s->seen, other) + 1),
                seen = cell_rows_list(&s->seen, other, row);
            row[seen] = c;
            qsort(row, (size_t)seen + 1, sizeof *row, by_cell_number);
            cell_rows_set_list(&s->seen, other, row, seen + 1, s->rows);
        }
    }
}

// Pairs may be proven from one end alone.
static long long count_undecided(const Search *s) {
    long long count = 0;
    for (int c = 0; c < s->seen.cell_count; c++) {
        int seen = cell_rows_list(&s->seen, c, s->list);
        for (int i = 0; i < seen; i++)
            count += !cell_rows_has(&s->proven, c, s->list[i]) && !cell_rows_has(&s->proven, s->list[i], c);
    }
    return count;
}

// False where windows do not pay.
static bool search_groups(const CellGraph *graph, const Bounds *bounds, const PairOptions *options,
                          const Progress *progress, Arena *arena, CampusPairs *out) {
    Arena scratch = {.dense = true};
    CellRows seen = unite_bounds(bounds, &scratch);
    if (!window_pays(&seen)) {
        arena_free(&scratch);
        return false;
    }
    CellGroups groups = cell_groups(graph, WINDOW_GROUP, &scratch);
    Search s = {.graph = graph,
                .bounds = bounds,
                .seen = seen,
                .proven = cell_rows_new(graph->cell_count, &scratch),
                .rows = &scratch,
                .place = ARENA_ARRAY(&scratch, int, graph->cell_count),
                .list = ARENA_ARRAY(&scratch, int, graph->cell_count),
                .options = {.threads = options->threads},
                .progress = progress,
                .groups = groups.count};
    for (int c = 0; c < graph->cell_count; c++) {
        s.place[c] = -1;
        cell_rows_set_list(&s.proven, c, &c, 1, &scratch);
    }
    for (; s.group < groups.count && !out->stopped; s.group++) {
        const int *first = groups.cell + groups.first[s.group];
        out->stopped =
            !search_group(&s, first, groups.first[s.group + 1] - groups.first[s.group], &out->work);
    }
    out->stopped = !parallel_agree(!out->stopped);
    arena_free(&s.window);
    keep_proofs(&s);
    cell_rows_make_symmetric(&s.seen, &scratch);
    out->undecided = count_undecided(&s);
    out->seen = cell_rows_copy(&s.seen, arena);
    arena_free(&scratch);
    return true;
}

// False where windows do not pay, or progress asked to stop before the bounds were there.
static bool in_windows(const CellGraph *graph, double share, const PairOptions *options,
                       const Progress *progress, Arena *arena, CampusPairs *out) {
    Arena scratch = {.dense = true};
    *out = (CampusPairs){.stopped = false};
    Bounds b = {.threads = parallel_threads(options->threads), .many = graph->cell_count > VIS_MANY_CELLS};
    ways_build(graph, &scratch, &b.ways);
    b.ways.scale *= share;
    b.cells = ARENA_ARRAY(&scratch, int *, b.ways.way_count);
    b.count = ARENA_ARRAY(&scratch, int, b.ways.way_count);
    b.flows = ARENA_ARRAY(&scratch, Flow, b.threads);
    b.found = ARENA_ARRAY(&scratch, int *, b.threads);
    b.own = ARENA_ARRAY(&scratch, Arena, b.threads);
    for (int i = 0; i < b.threads; i++) {
        flow_start(&b.flows[i], &b.ways, NULL);
        b.found[i] = ARENA_ARRAY(&scratch, int, b.ways.cell_count);
        b.own[i].dense = true;
    }
    bool good = bound_ways(&b, progress, &scratch);
    for (int i = 0; i < b.threads; i++) flow_end(&b.flows[i]);
    good = good && search_groups(graph, &b, options, progress, arena, out);
    for (int i = 0; i < b.threads; i++) arena_free(&b.own[i]);
    arena_free(&scratch);
    return good;
}

static void in_matrix(const CellGraph *graph, double share, const PairOptions *options,
                      const Progress *progress, Arena *arena, CampusPairs *out) {
    Arena scratch = {0};
    PairSet set;
    Rounds rounds;
    rounds_start(&rounds, graph, options, progress, &scratch, &set);
    rounds.ways.scale *= share;
    proof_search(&rounds, true);
    *out = (CampusPairs){.seen = cell_rows_of_matrix(set.seen, set.cell_count, arena),
                         .undecided = pair_count(set.seen, set.cell_count, set.words) -
                                      pair_count(set.proven, set.cell_count, set.words),
                         .work = set.work,
                         .stopped = !parallel_agree(!set.stopped)};
    arena_free(&scratch);
}

static bool has_rooms(const CellGraph *graph) {
    return graph->building->form == FORM_REGIONS && !graph->building->map;
}

// Finds the pairs of a building, or of a house that has a `share` of the building's cells. False as campus_pairs.
static bool whole_pairs(const CellGraph *graph, double share, const PairOptions *options,
                        const Progress *progress, Arena *arena, CampusPairs *out) {
    // Levels of games and portal files are more open than buildings: there the bounds would be made in vain.
    bool many = graph->cell_count > VIS_MANY_CELLS;
    if (many || (has_rooms(graph) && graph->cell_count > WINDOW_LEAST)) {
        if (in_windows(graph, share, options, progress, arena, out)) return true;
        if (many) return false;
    }
    in_matrix(graph, share, options, progress, arena, out);
    return true;
}

// The findings in a house, but for its rows.
typedef struct HouseFound {
    long long undecided;
    ChainWork work;
    bool good, stopped;
} HouseFound;

// The search house by house: no line leads from one into another. Processes share the houses.
typedef struct Houses {
    const CellGraph *graph;
    const CellGroups *groups;
    PairOptions options;
    const Progress *progress;
    HouseFound *found;  // [groups->count]
    int *place, *list;  // [cell_count] of window_enter; -1, and scratch
    Arena *rows;        // of the rows of all
    bool gave_up;       // on a house, so that the rest are not searched
    CampusPairs *out;
    double before, share;  // of all cells: those of houses before the one at hand, and its own
} Houses;

static bool report_house(void *context, const char *stage, double done) {
    const Houses *h = context;
    return progress_report(h->progress, stage, h->before + h->share * done);
}

static const int *cells_of_house(const Houses *h, int house, int *count) {
    *count = h->groups->first[house + 1] - h->groups->first[house];
    return h->groups->cell + h->groups->first[house];
}

// Takes over the rows of a house.
static void store_house(Houses *h, const CellWindow *house, const CampusPairs *pairs) {
    for (int c = 0; c < house->graph.cell_count; c++) {
        int count = cell_rows_list(&pairs->seen, c, h->list);
        for (int i = 0; i < count; i++) h->list[i] = house->cell[h->list[i]];
        cell_rows_set_list(&h->out->seen, house->cell[c], h->list, count, h->rows);
    }
}

// One house at a time, each on all threads.
static void search_house(void *context, int house, int thread) {
    (void)thread;
    Houses *h = context;
    Arena own = {0};
    CellWindow window;
    CampusPairs pairs = {.stopped = false};
    if (h->gave_up) return;
    Progress report = {report_house, h};
    int count;
    const int *cells = cells_of_house(h, house, &count);
    h->before = (double)h->groups->first[house] / h->graph->cell_count;
    h->share = (double)count / h->graph->cell_count;
    window_of_house(h->graph, cells, count, h->place, &own, &window);
    bool good = whole_pairs(&window.graph, h->share, &h->options, &report, &own, &pairs);
    if (good) store_house(h, &window, &pairs);
    h->gave_up = !good;
    h->found[house] = (HouseFound){pairs.undecided, pairs.work, good, pairs.stopped};
    window_leave(&window, h->place);
    arena_free(&own);
}

// These findings, and each of the rows: the number of cells, the cells.
static Bytes pack_house(void *context, int house, Arena *arena) {
    Houses *h = context;
    const HouseFound *found = &h->found[house];
    int count;
    const int *cells = cells_of_house(h, house, &count);
    size_t most = 0, numbers = 0;
    for (int i = 0; i < count && found->good; i++)
        most += 1 + (size_t)cell_rows_size(&h->out->seen, cells[i]);
    Bytes out = {arena_alloc(arena, sizeof *found + most * sizeof(int), 1), sizeof *found};
    memcpy(out.data, found, sizeof *found);
    int *number = (int *)(void *)(out.data + sizeof *found);
    for (int i = 0; i < count && found->good; i++) {
        number[numbers] = cell_rows_list(&h->out->seen, cells[i], number + numbers + 1);
        numbers += 1 + (size_t)number[numbers];
    }
    out.size += numbers * sizeof *number;
    return out;
}

static void unpack_house(void *context, int house, Bytes result) {
    Houses *h = context;
    int count;
    const int *cells = cells_of_house(h, house, &count);
    memcpy(&h->found[house], result.data, sizeof *h->found);
    const unsigned char *at = result.data + sizeof *h->found;
    for (int i = 0; i < count && h->found[house].good; i++) {
        int seen;
        memcpy(&seen, at, sizeof seen);
        memcpy(h->list, at + sizeof seen, (size_t)seen * sizeof *h->list);
        at += (1 + (size_t)seen) * sizeof seen;
        cell_rows_set_list(&h->out->seen, cells[i], h->list, seen, h->rows);
    }
}

static bool in_houses(const CellGraph *graph, const CellGroups *houses, const PairOptions *options,
                      const Progress *progress, Arena *arena, CampusPairs *out) {
    Arena scratch = {0};
    bool good = true;
    Houses h = {.graph = graph,
                .groups = houses,
                .options = {.threads = options->threads},  // what is known is of all cells
                .progress = progress,
                .found = ARENA_ARRAY(&scratch, HouseFound, houses->count),
                .place = ARENA_ARRAY(&scratch, int, graph->cell_count),
                .list = ARENA_ARRAY(&scratch, int, graph->cell_count),
                .rows = arena,
                .out = out};
    SharedLoop loop = {houses->count, search_house, pack_house, unpack_house, &h};
    for (int c = 0; c < graph->cell_count; c++) h.place[c] = -1;
    *out = (CampusPairs){.seen = cell_rows_new(graph->cell_count, arena)};
    parallel_share(1, &loop);
    for (int i = 0; i < houses->count; i++) {
        const HouseFound *found = &h.found[i];
        good = good && found->good;
        out->undecided += found->undecided;
        out->stopped = out->stopped || found->stopped;
        chain_work_add(&out->work, found->work);
    }
    arena_free(&scratch);
    return good;
}

bool campus_pairs(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                  CampusPairs *out) {
    Arena scratch = {0};
    bool good;
    CellGroups houses = {.count = 1};
    if (graph->cell_count > WINDOW_LEAST && has_rooms(graph))
        houses = cell_houses(graph, WINDOW_GROUP, &scratch);
    if (houses.count > 1) {
        good = in_houses(graph, &houses, options, progress, arena, out);
    } else {
        good = whole_pairs(graph, 1, options, progress, arena, out);
    }
    arena_free(&scratch);
    return good;
}
