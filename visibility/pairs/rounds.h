// rounds.h - deciding all pairs of cells by searches from each way, in rounds, so that the findings of a search help later
// ones and yet no thread's pace shows in the result.
#ifndef VISIBILITY_PAIRS_ROUNDS_H
#define VISIBILITY_PAIRS_ROUNDS_H

#include <pthread.h>
#include <stdatomic.h>

#include "visibility/pairs/flow.h"

typedef struct Cast Cast;

// The knowledge so far of a building, which only ever grows tighter.
typedef struct Rounds {
    const PairOptions *options;
    const Progress *progress;
    WayGraph ways;
    uint64_t *might;         // [way_count * words] cells that may be seen through a way
    PairSet *set;            // seen: not excluded; proven: with a sightline. Both symmetric at all times
    PairWitness *witnesses;  // malloc'd
    int witness_count, witness_capacity;
    bool stopped;
    int threads;
    const uint64_t *own;   // bit c: lines from cell c are asked for; NULL: from all
    atomic_int flooded;    // cells
    const char *told;      // the stage last reported,
    double told_done;      // and how much of it
    pthread_mutex_t lock;  // of `progress` and `stopped`
    bool (*search)(Flow *flow, int way);
    const Cast *cast;   // of cast.h, where lines are cast
    const char *stage;  // of the searches, for progress
    Arena *arena;       // of the caller, for the result
    Arena *scratch;     // `own_scratch`, which rounds_end frees, or the caller's
    Arena own_scratch;
} Rounds;

// Two cells, a < b.
typedef struct PairEnds {
    int a, b;
} PairEnds;

// A line: of a chain from `from`, on its first portal, to `to`, on its last.
typedef struct Sight {
    Vec3 from, to;
} Sight;

// The findings of one search.
typedef struct Finding {
    Rounds *rounds;
    int source;       // cell the lines start from
    uint64_t *kept;   // [words] cells reached, or left undecided
    PairEnds *pairs;  // malloc'd [pair_count]: proven now, not before the round
    Sight *lines;     // malloc'd [pair_count] their sightlines, where witnesses are kept
    int pair_count, pair_capacity, line_capacity;
    ChainWork work;
    long long spent;  // of the work that it might do
    bool done;
} Finding;

void finding_add(Finding *finding, int a, int b, Vec3 from, Vec3 to);
// The finding as bytes in the arena, for other processes, with `more` of its search; and back, without `kept` and `rounds`.
Bytes finding_pack(const Finding *finding, const void *more, size_t more_size, Arena *arena);
void finding_unpack(Finding *finding, void *more, size_t more_size, Bytes packed);

// Begins with the flood.
void rounds_start(Rounds *rounds, const CellGraph *graph, const PairOptions *options,
                  const Progress *progress, Arena *arena, PairSet *set);
// The same without the flood: the caller fills `might`, adds to set->seen and set->proven what may be seen and what is, as far as he
// knows and without regard to symmetry of `seen`, and calls rounds_agree, which takes from both what one of them lacks. `ways` are those
// of the graph; what is found meanwhile lies in `scratch`, NULL: in memory that rounds_end frees.
void rounds_open(Rounds *rounds, const CellGraph *graph, const WayGraph *ways, const PairOptions *options,
                 const Progress *progress, Arena *arena, Arena *scratch, PairSet *set);
void rounds_agree(Rounds *rounds);
// Are lines from the cell asked for?
static inline bool rounds_asks(const Rounds *rounds, int cell) {
    return !rounds->own || row_has(rounds->own, cell);
}
// One search from every way out of cells that are asked for: flow_search or one like it. All of them may do `work` (see ways_work).
// `arrive` is that of Flow, whose context is a Finding. In closed buildings a search along chains follows thousands; in the open, where
// there are millions, it is given up, and pairs in doubt stay so; likewise when all allowed work is done.
#define ROUNDS_WORK 8e8  // the usual work of a search along chains
void rounds_search(Rounds *rounds, double work, bool (*search)(Flow *flow, int way),
                   void (*arrive)(Flow *flow, int depth));
// Before: what a flood within beams does not reach (flow_reach) is excluded, way by way.
void rounds_reach(Rounds *rounds);
// Takes pairs as proven; `lines` are asked for where witnesses are kept.
void rounds_prove(Rounds *rounds, const PairEnds *pairs, const Sight *lines, int count);
// Takes the pairs that a finding has proven, and frees the finding.
void rounds_take_proofs(Rounds *rounds, Finding *finding);
// How much work the next of `searches` may do when `left` is left for them all: much more than its share, since most take less.
long long rounds_share(long long left, int searches);
// Completes the set.
void rounds_end(Rounds *rounds);

// For loops on several threads: false when the caller asked to stop.
bool rounds_report(Rounds *rounds, const char *stage, int done, int count);
// After such a loop: `stopped` becomes that of any process that shares it.
void rounds_agree_stop(Rounds *rounds);
// Flow.go_on, while the flow's context is a Finding: reports the same again.
bool rounds_go_on(Flow *flow);

#endif
