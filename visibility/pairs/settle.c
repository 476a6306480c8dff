// settle.c - see settle.h. For each chain between the two cells the source portal is cut in halves, and each half in
// halves, until separating planes exclude a piece or a sightline from it proves the pair. As a piece shrinks to a point
// the separators become the cone from that point: their excess over the truth goes to nothing with its size.
#include "visibility/pairs/settle.h"

#include <stdlib.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "visibility/pairs/sight.h"

// Pieces of one chain; beyond that the pair stays undecided.
enum { MOST_PIECES = 128 };
// A piece takes as long as so many chains.
enum { PIECE_CHAINS = 15 };
// And so much work a portal, see ways_work; of all cases together.
enum { WORK_PIECE = 500 };
static const double WORK = 2.5e8;
// A piece shorter than this many epsilons, or narrower in the mean, lies within what rounding leaves open: lines that only
// touch an edge on their way leave a strip of the source that is never used up.
static const double SHORTEST_PIECE = 1e4;

typedef enum Verdict { EXCLUDED, PROVEN, OPEN } Verdict;

// One pair while it is tried.
typedef struct Case {
    Finding finding;
    Verdict verdict;
    int goal;
} Case;

typedef struct Cutter {
    Flow *flow;
    int depth, pieces;
    // The rest of the chain's portals that a piece of each level of halving leaves; level 0 is the chain as the search left it.
    Winding *portals[MOST_PIECES + 1];  // [depth + 1] or NULL
    Arena arena;
    Sight sight;
} Cutter;

// Shrinks `source` to what may see through the whole chain, whose portals are as the level above left them, and these to
// what it sees; false when that is nothing.
static bool shrink(const Cutter *cutter, int level, Winding *source) {
    const Flow *flow = cutter->flow;
    const Winding *above = cutter->portals[level - 1];
    Winding *portals = cutter->portals[level];
    double epsilon = flow->ways->epsilon;
    Separators beam, back;
    const WayShape *first = &flow->ways->ways[flow->steps[0]->beam.way];
    beam.count = 0;
    for (int i = 1; i <= cutter->depth; i++) {
        const WayShape *way = &flow->ways->ways[flow->steps[i]->beam.way];
        Winding *next = &portals[i];
        const Winding *pass = &portals[i - 1];
        winding_copy(next, &above[i]);
        if (!beam_clip(next, &beam, epsilon)) return false;
        if (!winding_clip(source, beam_side(way, -1, first), epsilon)) return false;
        back.count = 0;
        if (i > 1) {
            winding_tangents(next, pass, -1, KEEP_OTHER, epsilon, &back);
            winding_tangents(pass, next, 1, KEEP_EDGES, epsilon, &back);
        }
        if (!beam_clip(source, &back, epsilon)) return false;
        if (i < cutter->depth) beam_planes(source, next, epsilon, &beam);
    }
    return true;
}

// The two corners farthest from each other.
static double longest(const Winding *w, Vec3 *a, Vec3 *b) {
    double best = 0;
    for (int i = 0; i < w->count; i++) {
        for (int k = i + 1; k < w->count; k++) {
            Vec3 p = winding_corner(w, i), q = winding_corner(w, k);
            double length = vec3_length(vec3_sub(q, p));
            if (length <= best) continue;
            best = length;
            *a = p;
            *b = q;
        }
    }
    return best;
}

static Verdict try_piece(Cutter *cutter, int level, Winding *piece);

static Verdict try_halves(Cutter *cutter, int level, const Winding *piece) {
    Vec3 a = {0, 0, 0}, b = {0, 0, 0};
    double length = longest(piece, &a, &b), shortest = SHORTEST_PIECE * cutter->flow->ways->epsilon;
    if (length < shortest || winding_area(piece) < length * shortest) return OPEN;
    Vec3 along = vec3_scale(vec3_sub(b, a), 1 / length), middle = vec3_lerp(a, b, 0.5);
    Verdict worst = EXCLUDED;
    for (int side = -1; side <= 1; side += 2) {
        Winding half;
        winding_copy(&half, piece);
        Vec3 n = vec3_scale(along, side);
        if (!winding_clip(&half, (Plane){n, vec3_dot(n, middle)}, 0)) continue;
        Verdict verdict = try_piece(cutter, level + 1, &half);
        if (verdict == PROVEN) return PROVEN;
        if (verdict == OPEN) worst = OPEN;
    }
    return worst;
}

static Verdict try_piece(Cutter *cutter, int level, Winding *piece) {
    if (cutter->pieces++ >= MOST_PIECES || cutter->flow->left <= 0 ||
        cutter->flow->spent >= cutter->flow->allowed)
        return OPEN;
    cutter->flow->left -= PIECE_CHAINS;
    cutter->flow->spent += WORK_PIECE * (cutter->depth + 1);
    if (!cutter->portals[level])
        cutter->portals[level] = ARENA_ARRAY(&cutter->arena, Winding, cutter->depth + 1);
    if (!shrink(cutter, level, piece)) return EXCLUDED;
    if (sight_from_point(cutter->flow, cutter->depth, winding_middle(piece), &cutter->sight)) return PROVEN;
    return try_halves(cutter, level, piece);
}

static Verdict try_chain(Cutter *cutter) {
    Winding source;
    winding_copy(&source, &cutter->flow->steps[cutter->depth]->beam.source);
    cutter->portals[0] = ARENA_ARRAY(&cutter->arena, Winding, cutter->depth + 1);
    for (int i = 1; i <= cutter->depth; i++)
        winding_copy(&cutter->portals[0][i], &cutter->flow->steps[i]->beam.pass);
    Verdict verdict = try_piece(cutter, 1, &source);
    arena_free(&cutter->arena);
    return verdict;
}

static void arrive(Flow *flow, int depth) {
    Finding *finding = flow->context;
    Case *c = (Case *)((char *)finding - offsetof(Case, finding));
    Cutter cutter = {.flow = flow, .depth = depth};
    Verdict verdict = depth == 0 ? PROVEN : try_chain(&cutter);
    if (verdict == EXCLUDED) return;
    c->verdict = verdict;
    if (verdict == PROVEN) {
        sight_record(flow, depth, cutter.sight);
    } else {
        row_drop(flow->unknown, c->goal);
    }
}

static void settle(Flow *flow, const Rounds *r, int from, Case *c) {
    const WayGraph *ways = &r->ways;
    long long patience = flow->patience;
    flow->spent = 0;
    flow->work = (ChainWork){0};
    flow->context = &c->finding;
    for (int i = ways->first[from]; i < ways->first[from + 1]; i++) {
        int way = ways->list[i];
        if (!row_has(r->might + (size_t)way * (size_t)ways->words, c->goal)) continue;
        memset(flow->unknown, 0, (size_t)ways->words * sizeof *flow->unknown);
        row_add(flow->unknown, c->goal);
        if (!flow_search(flow, way)) {
            flow->work.given_up++;
            c->verdict = OPEN;
        }
        if (c->verdict != EXCLUDED) break;
        flow->patience = flow->left;  // of the whole case
    }
    flow->patience = patience;
    c->finding.spent = flow->spent;
    c->finding.work = flow->work;
}

typedef struct Doubt {
    int a, b;
} Doubt;

// Pairs seen but not proven: in the open there are millions, of which the first are tried.
static Doubt *list_doubts(const Rounds *r, Arena *arena, int *count) {
    const PairSet *set = r->set;
    long long both_ways = pair_count(set->seen, set->cell_count, set->words) -
                          pair_count(set->proven, set->cell_count, set->words);
    enum { MOST_DOUBTS = 1 << 21 };
    long long most = both_ways / 2 < MOST_DOUBTS ? both_ways / 2 : MOST_DOUBTS;
    Doubt *doubts = ARENA_ARRAY(arena, Doubt, most + 1);
    *count = 0;
    for (int a = 0; a < set->cell_count; a++) {
        const uint64_t *seen = set->seen + (size_t)a * (size_t)set->words,
                       *proven = set->proven + (size_t)a * (size_t)set->words;
        bool all = rounds_asks(r, a);
        for (int k = a / 64; k < set->words; k++) {
            uint64_t doubt = seen[k] & ~proven[k];
            if (k == a / 64) doubt &= ~UINT64_C(1) << (a % 64);
            if (!all) doubt &= r->own[k];
            for (; doubt && *count < most; doubt &= doubt - 1)
                doubts[(*count)++] = (Doubt){a, 64 * k + __builtin_ctzll(doubt)};
        }
    }
    return doubts;
}

static void exclude(PairSet *set, int a, int b) {
    row_drop(set->seen + (size_t)a * (size_t)set->words, b);
    row_drop(set->seen + (size_t)b * (size_t)set->words, a);
}

static void take(Rounds *r, const Doubt *doubt, Case *c) {
    rounds_take_proofs(r, &c->finding);
    chain_work_add(&r->set->work, c->finding.work);
    if (c->finding.done && c->verdict == EXCLUDED) exclude(r->set, doubt->a, doubt->b);
}

// A run of cases, and the memory that each thread needs for one.
typedef struct Cases {
    Rounds *rounds;
    const Doubt *doubts;       // [count]
    Case *cases;               // [count]
    Flow *flows;               // [threads]
    uint64_t *kept;            // [threads * words]
    int count, before, total;  // in this run, in earlier ones, in all
    long long left;            // of the work that all may do
    atomic_int done;
} Cases;

static void settle_case(void *context, int index, int thread) {
    Cases *run = context;
    Rounds *r = run->rounds;
    const Doubt *doubt = &run->doubts[index];
    int done = run->before + atomic_fetch_add(&run->done, 1);
    if (!rounds_report(r, "last doubts", done, run->total)) return;
    Case *c = &run->cases[index];
    c->goal = doubt->b;
    c->finding = (Finding){
        .rounds = r, .source = doubt->a, .kept = run->kept + (size_t)thread * (size_t)r->ways.words};
    settle(&run->flows[thread], r, doubt->a, c);
    c->finding.done = true;
}

static Bytes pack_case(void *context, int index, Arena *arena) {
    const Case *c = &((const Cases *)context)->cases[index];
    return finding_pack(&c->finding, &c->verdict, sizeof c->verdict, arena);
}

static void unpack_case(void *context, int index, Bytes packed) {
    Case *c = &((Cases *)context)->cases[index];
    finding_unpack(&c->finding, &c->verdict, sizeof c->verdict, packed);
}

static void settle_run(Cases *run) {
    memset(run->cases, 0, (size_t)run->count * sizeof *run->cases);
    atomic_store(&run->done, 0);
    for (int i = 0; i < run->rounds->threads; i++)
        run->flows[i].allowed = rounds_share(run->left, run->total - run->before);
    SharedLoop loop = {run->count, settle_case, pack_case, unpack_case, run};
    parallel_share(run->rounds->threads, &loop);
    rounds_agree_stop(run->rounds);
    for (int i = 0; i < run->count; i++) {
        run->left -= run->cases[i].finding.spent;
        take(run->rounds, &run->doubts[i], &run->cases[i]);
    }
}

// Chains that one case may follow: so many in all take half a minute of one core.
static long long patience(int cases) {
    static const long long ALL = 25000000, MOST = 50000;
    long long share = ALL / (cases + 1);
    return share < 1 ? 1 : share > MOST ? MOST : share;
}

void settle_pairs(Rounds *r) {
    enum { MOST_CASES = 256 };  // at once
    Arena scratch = {0};
    Cases run = {.rounds = r, .left = ways_work(&r->ways, WORK)};
    const Doubt *doubts = list_doubts(r, &scratch, &run.total);
    run.cases = ARENA_ARRAY(&scratch, Case, run.total < MOST_CASES ? run.total : MOST_CASES);
    run.flows = ARENA_ARRAY(&scratch, Flow, r->threads);
    run.kept = ARENA_ARRAY(&scratch, uint64_t, (size_t)r->threads * (size_t)r->ways.words);
    for (int i = 0; i < r->threads; i++) {
        flow_start(&run.flows[i], &r->ways, r->might);
        run.flows[i].arrive = arrive;
        run.flows[i].go_on = rounds_go_on;
        run.flows[i].patience = patience(run.total);
    }
    for (run.before = 0; run.before < run.total && !r->stopped && run.left > 0; run.before += run.count) {
        int left = run.total - run.before;
        run.doubts = doubts + run.before;
        run.count = left < MOST_CASES ? left : MOST_CASES;
        settle_run(&run);
    }
    for (int i = 0; i < r->threads; i++) flow_end(&run.flows[i]);
    arena_free(&scratch);
}
