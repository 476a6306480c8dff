// rounds.c - see rounds.h. Searches go from the way that may see least to the one that may see most, since a decided way
// bounds what is seen through it; and as sight is symmetric, a cell found not to see another is taken from what the
// other may see at once. Both happen between rounds of a fixed number of searches only.
#include "visibility/pairs/rounds.h"

#include <pthread.h>
#include <stdlib.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"

// Sorting anew costs a pass over all potentially visible cells; the order hardly changes from one round to the next.
enum { LARGEST_ROUND = 64, SMALLEST_ROUND = 4, ROUNDS = 24, SORT_EVERY = 8 };

// Room for one more than `count`.
static void *grown(void *list, int count, int *capacity, size_t size) {
    if (count < *capacity) return list;
    *capacity = *capacity ? *capacity * 2 : 64;
    return memory_grow(list, (size_t)*capacity * size);
}

void finding_add(Finding *finding, int a, int b, Vec3 from, Vec3 to) {
    const PairSet *set = finding->rounds->set;
    if (a == b || pair_bit(set->proven, set->words, a, b)) return;
    int count = finding->pair_count++;
    finding->pairs = grown(finding->pairs, count, &finding->pair_capacity, sizeof *finding->pairs);
    finding->pairs[count] = a < b ? (PairEnds){a, b} : (PairEnds){b, a};
    if (!finding->rounds->options->witnesses) return;
    finding->lines = grown(finding->lines, count, &finding->line_capacity, sizeof *finding->lines);
    finding->lines[count] = a < b ? (Sight){from, to} : (Sight){to, from};
}

typedef struct PackedFinding {
    ChainWork work;
    long long spent;
    int pairs, lines;
    bool done;
} PackedFinding;

Bytes finding_pack(const Finding *finding, const void *more, size_t more_size, Arena *arena) {
    int lines = finding->lines ? finding->pair_count : 0;
    PackedFinding head = {finding->work, finding->spent, finding->pair_count, lines, finding->done};
    const struct {
        const void *data;
        size_t size;
    } piece[] = {{&head, sizeof head},
                 {more, more_size},
                 {finding->pairs, (size_t)finding->pair_count * sizeof *finding->pairs},
                 {finding->lines, (size_t)lines * sizeof *finding->lines}};
    enum { PIECES = sizeof piece / sizeof *piece };
    Bytes out = {NULL, 0};
    size_t size = 0;
    for (int i = 0; i < PIECES; i++) size += piece[i].size;
    out.data = arena_alloc(arena, size, 1);
    for (int i = 0; i < PIECES; i++) {
        if (piece[i].size > 0) memcpy(out.data + out.size, piece[i].data, piece[i].size);
        out.size += piece[i].size;
    }
    return out;
}

void finding_unpack(Finding *finding, void *more, size_t more_size, Bytes packed) {
    PackedFinding head;
    memcpy(&head, packed.data, sizeof head);
    const unsigned char *at = packed.data + sizeof head;
    if (more_size > 0) memcpy(more, at, more_size);
    at += more_size;
    finding->work = head.work;
    finding->spent = head.spent;
    finding->done = head.done;
    finding->pair_count = finding->pair_capacity = head.pairs;
    finding->line_capacity = head.lines;
    if (head.pairs > 0) {
        size_t size = (size_t)head.pairs * sizeof *finding->pairs;
        finding->pairs = memory_new(size);
        memcpy(finding->pairs, at, size);
        at += size;
    }
    if (head.lines > 0) {
        finding->lines = memory_new((size_t)head.lines * sizeof *finding->lines);
        memcpy(finding->lines, at, (size_t)head.lines * sizeof *finding->lines);
    }
}

static uint64_t *might_row(const Rounds *r, int way) {
    return r->might + (size_t)way * (size_t)r->ways.words;
}
static uint64_t *set_row(const Rounds *r, uint64_t *rows, int cell) {
    return rows + (size_t)cell * (size_t)r->ways.words;
}

// From `cell` only cells that may be seen through one of its ways are seen: no other cell sees it either. Of the cells
// of word k.
static void lend_word(Rounds *r, int cell, int k) {
    const WayGraph *ways = &r->ways;
    uint64_t *row = set_row(r, r->set->seen, cell), may = set_row(r, r->set->proven, cell)[k];
    for (int i = ways->first[cell]; i < ways->first[cell + 1]; i++) may |= might_row(r, ways->list[i])[k];
    uint64_t gone = row[k] & ~may;
    row[k] &= may;
    for (; gone; gone &= gone - 1) {
        int other = k * 64 + __builtin_ctzll(gone);
        row_drop(set_row(r, r->set->seen, other), cell);
        for (int i = ways->first[other]; i < ways->first[other + 1]; i++)
            row_drop(might_row(r, ways->list[i]), cell);
    }
}

// Rows of bits become columns: halves of the block change places, then quarters, and so on.
static void transpose(uint64_t block[64]) {
    uint64_t mask = UINT32_MAX;
    for (int step = 32; step > 0; step /= 2, mask ^= mask << step) {
        for (int i = 0; i < 64; i = (i + step + 1) & ~step) {
            uint64_t moved = (block[i] >> step ^ block[i + step]) & mask;
            block[i] ^= moved << step;
            block[i + step] ^= moved;
        }
    }
}

// A block of the matrix: which of the cells from 64 k on are seen by those from 64 i on.
static void read_block(const Rounds *r, int i, int k, uint64_t block[64]) {
    for (int c = 0; c < 64; c++) {
        int cell = i * 64 + c;
        block[c] = cell < r->ways.cell_count ? set_row(r, r->set->seen, cell)[k] : 0;
    }
}
static void and_block(const Rounds *r, int i, int k, const uint64_t block[64]) {
    for (int c = 0; c < 64 && i * 64 + c < r->ways.cell_count; c++)
        set_row(r, r->set->seen, i * 64 + c)[k] &= block[c];
}

void rounds_agree(Rounds *r) {
    const WayGraph *ways = &r->ways;
    int words = ways->words;
    for (int i = 0; i < words; i++) {
        for (int k = 0; k <= i; k++) {
            uint64_t a[64], b[64];
            read_block(r, i, k, a);
            read_block(r, k, i, b);
            transpose(a);
            transpose(b);
            and_block(r, i, k, b);
            and_block(r, k, i, a);
        }
    }
    if (r->options->known) pair_set_take_known(r->set, r->options->known);
    for (int w = 0; w < ways->way_count; w++) {
        const uint64_t *seen = set_row(r, r->set->seen, ways->ways[w].from);
        for (int k = 0; k < words; k++) might_row(r, w)[k] &= seen[k];
    }
}

// A cell sees what may be seen through one of its ways, as far as that may see the cell.
static void see_floods(Rounds *r) {
    const WayGraph *ways = &r->ways;
    for (int w = 0; w < ways->way_count; w++) {
        uint64_t *seen = set_row(r, r->set->seen, ways->ways[w].from);
        for (int k = 0; k < ways->words; k++) seen[k] |= might_row(r, w)[k];
    }
    rounds_agree(r);
}

static void flood_cell(void *context, int cell, int thread) {
    Rounds *r = context;
    const WayGraph *ways = &r->ways;
    Arena own = {0};
    int *stack = ARENA_ARRAY(&own, int, ways->cell_count);
    (void)thread;
    bool go_on = rounds_report(r, "flood", atomic_fetch_add(&r->flooded, 1), ways->cell_count);
    for (int i = ways->first[cell]; i < ways->first[cell + 1]; i++) {
        uint64_t *row = might_row(r, ways->list[i]);
        if (go_on)
            ways_flood(ways, ways->list[i], row, stack);
        else
            row_add_all(row, ways->cell_count);
    }
    arena_free(&own);
}

static bool tell(Rounds *r, const char *stage, double done) {
    pthread_mutex_lock(&r->lock);
    if (stage) r->told = stage, r->told_done = done;
    if (!r->stopped && !progress_report(r->progress, r->told, r->told_done)) r->stopped = true;
    bool stopped = r->stopped;
    pthread_mutex_unlock(&r->lock);
    return !stopped;
}

bool rounds_report(Rounds *r, const char *stage, int done, int count) {
    return tell(r, stage, (double)done / count);
}

void rounds_agree_stop(Rounds *r) { r->stopped = !parallel_agree(!r->stopped); }

bool rounds_go_on(Flow *flow) {
    const Finding *finding = flow->context;
    return tell(finding->rounds, NULL, 0);
}

void rounds_open(Rounds *r, const CellGraph *graph, const WayGraph *ways, const PairOptions *options,
                 const Progress *progress, Arena *arena, Arena *scratch, PairSet *set) {
    *r = (Rounds){.options = options,
                  .progress = progress,
                  .set = set,
                  .stage = "sightlines",
                  .threads = parallel_threads(options->threads),
                  .lock = PTHREAD_MUTEX_INITIALIZER,
                  .arena = arena,
                  .ways = *ways};
    r->scratch = scratch ? scratch : &r->own_scratch;
    *set = pair_set_new(graph, arena);
    r->might = ARENA_ARRAY(r->scratch, uint64_t, (size_t)r->ways.way_count * (size_t)r->ways.words);
    for (int c = 0; c < r->ways.cell_count; c++) {
        row_add(set_row(r, set->proven, c), c);
        row_add(set_row(r, set->seen, c), c);
    }
}

void rounds_start(Rounds *r, const CellGraph *graph, const PairOptions *options, const Progress *progress,
                  Arena *arena, PairSet *set) {
    Arena own = {0};
    WayGraph ways;
    ways_build(graph, &own, &ways);
    rounds_open(r, graph, &ways, options, progress, arena, NULL, set);
    arena_join(&r->own_scratch, &own);
    parallel_for(r->threads, r->ways.cell_count, flood_cell, r);
    rounds_agree_stop(r);
    see_floods(r);
}

typedef struct Turn {
    long might;
    int way;
} Turn;

static int by_might(const void *p, const void *q) {
    const Turn *a = p, *b = q;
    if (a->might != b->might) return a->might < b->might ? -1 : 1;
    return (a->way > b->way) - (a->way < b->way);
}

static void sort_turns(const Rounds *r, Turn *turns, int count) {
    for (int i = 0; i < count; i++) {
        const uint64_t *row = might_row(r, turns[i].way);
        turns[i].might = 0;
        for (int k = 0; k < r->ways.words; k++) turns[i].might += __builtin_popcountll(row[k]);
    }
    qsort(turns, (size_t)count, sizeof *turns, by_might);
}

// Searches from one way; reads only the findings from before the round.
static void search_way(Flow *flow, const Rounds *r, int index, Finding *finding) {
    const WayGraph *ways = &r->ways;
    const WayShape *way = &ways->ways[index];
    const uint64_t *might = might_row(r, index), *proven = set_row(r, r->set->proven, way->from);
    // A line that comes through the way is seen from both its cells.
    const uint64_t *here = set_row(r, r->set->seen, way->from), *there = set_row(r, r->set->seen, way->to);
    uint64_t any = 0;
    for (int k = 0; k < ways->words; k++) {
        uint64_t may = might[k] & here[k] & there[k];
        finding->kept[k] = may & proven[k];
        flow->unknown[k] = may & ~proven[k];
        any |= flow->unknown[k];
    }
    if (!any) return;
    flow->work = (ChainWork){0};
    flow->spent = 0;
    flow->context = finding;
    if (!r->search(flow, index)) {
        flow->work.given_up++;
        for (int k = 0; k < ways->words; k++) finding->kept[k] |= flow->unknown[k];
    }
    finding->work = flow->work;
    finding->spent = flow->spent;
}

static void take(Rounds *r, int way, Finding *finding) {
    int words = r->ways.words;
    rounds_take_proofs(r, finding);
    uint64_t *might = might_row(r, way);
    // The cell's row was lent before: only words that lose something can change.
    for (int k = 0; k < words; k++) {
        uint64_t gone = might[k] & ~finding->kept[k];
        might[k] &= finding->kept[k];
        if (gone) lend_word(r, r->ways.ways[way].from, k);
    }
    chain_work_add(&r->set->work, finding->work);
}

void rounds_take_proofs(Rounds *r, Finding *finding) {
    rounds_prove(r, finding->pairs, finding->lines, finding->pair_count);
    memory_free(finding->pairs);
    memory_free(finding->lines);
    finding->pairs = NULL;
    finding->lines = NULL;
}

void rounds_prove(Rounds *r, const PairEnds *pairs, const Sight *lines, int count) {
    for (int i = 0; i < count; i++) {
        int a = pairs[i].a, b = pairs[i].b;
        uint64_t *proven = r->set->proven;
        if (row_has(set_row(r, proven, a), b)) continue;
        row_add(set_row(r, proven, a), b);
        row_add(set_row(r, proven, b), a);
        // A proof goes before an exclusion elsewhere, which rounding may have caused.
        row_add(set_row(r, r->set->seen, a), b);
        row_add(set_row(r, r->set->seen, b), a);
        if (!r->options->witnesses) continue;
        r->witnesses = grown(r->witnesses, r->witness_count, &r->witness_capacity, sizeof *r->witnesses);
        r->witnesses[r->witness_count++] = (PairWitness){a, b, lines[i].from, lines[i].to};
    }
}

static int round_size(int searches) {
    int size = searches / ROUNDS;
    return size < SMALLEST_ROUND ? SMALLEST_ROUND : size > LARGEST_ROUND ? LARGEST_ROUND : size;
}

// One round while it runs.
typedef struct Round {
    Rounds *rounds;
    Flow *flows;               // [threads]
    Finding *findings;         // [size]
    const Turn *turns;         // [size] of this round
    Turn *order;               // [size] the same, by how much is in doubt; `way` is the place in turns
    uint64_t *kept;            // [size * words]
    int count, before, total;  // searches of this round, of earlier ones, and of all
    long long left;            // of the work that all of them may do
    atomic_int done;
} Round;

static uint64_t *kept_row(const Round *round, int index) {
    return round->kept + (size_t)index * (size_t)round->rounds->ways.words;
}

static void search_turn(void *context, int index, int thread) {
    Round *round = context;
    Rounds *r = round->rounds;
    index = round->order[index].way;
    int way = round->turns[index].way, done = round->before + atomic_fetch_add(&round->done, 1);
    if (!rounds_report(r, r->stage, done, round->total)) return;
    Finding *finding = &round->findings[index];
    *finding = (Finding){.rounds = r, .source = r->ways.ways[way].from, .kept = kept_row(round, index)};
    search_way(&round->flows[thread], r, way, finding);
    finding->done = true;
}

static size_t kept_size(const Round *round) {
    return (size_t)round->rounds->ways.words * sizeof *round->kept;
}

static Bytes pack_turn(void *context, int index, Arena *arena) {
    const Round *round = context;
    int at = round->order[index].way;
    return finding_pack(&round->findings[at], kept_row(round, at), kept_size(round), arena);
}

static void unpack_turn(void *context, int index, Bytes packed) {
    Round *round = context;
    int at = round->order[index].way;
    round->findings[at].kept = kept_row(round, at);
    finding_unpack(&round->findings[at], kept_row(round, at), kept_size(round), packed);
}

// How many cells a search is to decide.
static long in_doubt(const Rounds *r, int way) {
    const WayShape *w = &r->ways.ways[way];
    const uint64_t *might = might_row(r, way), *proven = set_row(r, r->set->proven, w->from);
    const uint64_t *here = set_row(r, r->set->seen, w->from), *there = set_row(r, r->set->seen, w->to);
    long count = 0;
    for (int k = 0; k < r->ways.words; k++)
        count += __builtin_popcountll(might[k] & here[k] & there[k] & ~proven[k]);
    return count;
}

// The longest searches first, as far as one can tell: then no thread is left with one at the end.
static void order_round(Round *round, int count) {
    for (int i = 0; i < count; i++)
        round->order[i] = (Turn){-in_doubt(round->rounds, round->turns[i].way), i};
    qsort(round->order, (size_t)count, sizeof *round->order, by_might);
}

static void search_round(Round *round, int count) {
    order_round(round, count);
    memset(round->findings, 0, (size_t)count * sizeof *round->findings);
    round->count = count;
    atomic_store(&round->done, 0);
    for (int i = 0; i < round->rounds->threads; i++)
        round->flows[i].allowed = rounds_share(round->left, round->total - round->before);
    SharedLoop loop = {count, search_turn, pack_turn, unpack_turn, round};
    parallel_share(round->rounds->threads, &loop);
    rounds_agree_stop(round->rounds);
    for (int i = 0; i < count; i++) {
        round->left -= round->findings[i].spent;
        if (round->findings[i].done) take(round->rounds, round->turns[i].way, &round->findings[i]);
    }
}

long long rounds_share(long long left, int searches) {
    static const long long TIMES = 64, MOST = 8;
    long long share = left / (searches > 0 ? searches : 1) * TIMES, most = left / MOST;
    return share < most ? share : most;
}

// So many chains take five minutes of one core.
static long long patience(int searches) {
    static const long long ALL = 1000000000, LEAST = 10000, MOST = 200000;
    long long share = ALL / (searches + 1);
    return share < LEAST ? LEAST : share > MOST ? MOST : share;
}

void rounds_search(Rounds *r, double work, bool (*search)(Flow *flow, int way),
                   void (*arrive)(Flow *flow, int depth)) {
    const WayGraph *ways = &r->ways;
    Arena scratch = {0};
    Turn *turns = ARENA_ARRAY(&scratch, Turn, ways->way_count + 1);
    int count = 0;
    for (int w = 0; w < ways->way_count; w++) {
        if (rounds_asks(r, ways->ways[w].from)) turns[count++].way = w;
    }
    int size = round_size(count);
    Round round = {.rounds = r,
                   .flows = ARENA_ARRAY(&scratch, Flow, r->threads),
                   .findings = ARENA_ARRAY(&scratch, Finding, size),
                   .order = ARENA_ARRAY(&scratch, Turn, size),
                   .kept = ARENA_ARRAY(&scratch, uint64_t, (size_t)size * (size_t)ways->words),
                   .total = count,
                   .left = ways_work(ways, work)};
    for (int i = 0; i < r->threads; i++) {
        flow_start(&round.flows[i], ways, r->might);
        round.flows[i].arrive = arrive;
        round.flows[i].go_on = rounds_go_on;
        round.flows[i].patience = patience(count);
    }
    r->search = search;
    for (int first = 0; first < count && !r->stopped; first += size) {
        if (first / size % SORT_EVERY == 0) sort_turns(r, turns + first, count - first);
        round.turns = turns + first;
        round.before = first;
        search_round(&round, count - first < size ? count - first : size);
    }
    for (int i = 0; i < r->threads; i++) flow_end(&round.flows[i]);
    arena_free(&scratch);
}

static bool reach_way(Flow *flow, int way) {
    Finding *finding = flow->context;
    uint64_t *may = flow->unknown;
    for (int k = 0; k < flow->ways->words; k++) may[k] |= finding->kept[k];
    flow_reach(flow, way, may, finding->kept);
    return true;
}

void rounds_reach(Rounds *r) {
    const char *stage = r->stage;
    r->stage = "beams";
    rounds_search(r, ROUNDS_WORK, reach_way, NULL);
    r->stage = stage;
}

static int by_pair(const void *p, const void *q) {
    const PairWitness *a = p, *b = q;
    return a->a != b->a ? (a->a > b->a) - (a->a < b->a) : (a->b > b->b) - (a->b < b->b);
}

void rounds_end(Rounds *r) {
    PairSet *set = r->set;
    set->stopped = r->stopped;
    set->witness_count = r->witness_count;
    if (r->witness_count > 0) {
        qsort(r->witnesses, (size_t)r->witness_count, sizeof *r->witnesses, by_pair);
        set->witnesses = ARENA_ARRAY(r->arena, PairWitness, r->witness_count);
        memcpy(set->witnesses, r->witnesses, (size_t)r->witness_count * sizeof *r->witnesses);
        for (int i = 0; i < set->witness_count; i++) {
            set->witnesses[i].from = vec3_add(set->witnesses[i].from, r->ways.origin);
            set->witnesses[i].to = vec3_add(set->witnesses[i].to, r->ways.origin);
        }
    }
    memory_free(r->witnesses);
    arena_free(&r->own_scratch);
}
