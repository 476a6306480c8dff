// flow.h - depth-first through portals, within separating planes, towards the cells that are still in doubt.
//
// A chain (beam.h) ends when nothing is left of it, or when no cell in doubt lies in its beam.
#ifndef VISIBILITY_PAIRS_FLOW_H
#define VISIBILITY_PAIRS_FLOW_H

#include "visibility/beam.h"
#include "visibility/pairs/pairs.h"

typedef struct FlowStep {
    Beam beam;
    // Cells in doubt that the beam may reach, as the words of a row of bits that are not zero: of thousands of cells a chain looks for
    // a few.
    int word_count;
    int *word;       // [words] their places in the row
    uint64_t *bits;  // [words]
    bool recorded;   // of sight_record: the pairs of the chain as far as this step are in the finding
    Vec3 place;      // of sight_record: on a sightline, in the cell that the way leaves
} FlowStep;

typedef struct Merged Merged;

// One thread's search. Give it back with flow_free.
typedef struct Flow {
    const WayGraph *ways;
    const uint64_t *might;     // [way_count * words] cells that may be seen through a way
    uint64_t *unknown;         // [words] cells in doubt: `arrive` drops those it decides
    FlowStep **steps;          // [cell_count + 1] the chain so far; steps[0] is the first way
    unsigned char *on_path;    // [cell_count] a line enters a convex cell once
    int *stack;                // [cell_count] of flow_reach
    uint64_t *within, *goals;  // [words] of flow_reach
    // Called when the chain steps[0 .. depth] leads into a cell in doubt.
    void (*arrive)(struct Flow *flow, int depth);
    void *context;
    bool (*go_on)(struct Flow *flow);  // NULL: always. After false a search loses its patience at once
    Vec3 point;                        // of flow_look
    long long patience;  // chains that one search may follow; cells that are in doubt then stay in `unknown`
    long long left;      // of the patience
    long long spent, allowed;  // work of one search (ways_work), and how much it may do
    ChainWork work;
    Merged *merged;  // of merged.c: its memory, made when first needed
    Arena arena;
} Flow;

void flow_start(Flow *flow, const WayGraph *ways, const uint64_t *might);
void flow_end(Flow *flow);

// Follows all chains that begin with `way`, as long as `unknown` is not empty. Returns false when it lost patience,
// or has done all the work that it may.
bool flow_search(Flow *flow, int way);

// Marks in `reached` the cells of `may` to which a flood comes that begins with the way and the one after it, and stays within the
// beam of both: all that may be seen, and not much more.
void flow_reach(Flow *flow, int way, const uint64_t *may, uint64_t *reached);

// As flow_search for lines from `flow->point`, a point of the way's portal, only: exact, so that each cell reached is seen from it. Calls
// `arrive` for cells in doubt; the cone stands in for the beam, the source is the point.
void flow_look(Flow *flow, int way, void (*arrive)(Flow *flow, int depth));

// Does any of the box lie within the planes of a beam, as far as these tell?
bool flow_box_in_beam(Box box, const Separators *planes, double epsilon);

// Planes through the eye and the edges of a winding ahead of it, which keep its inside.
void flow_cone(Vec3 eye, const Winding *through, Separators *out);

// The cell that chain steps[0 .. depth] leads into.
static inline int flow_cell(const Flow *flow, int depth) {
    return flow->ways->ways[flow->steps[depth]->beam.way].to;
}

#endif
