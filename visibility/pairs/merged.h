// merged.h - all chains that begin with one way, merged wherever they come to the same portal.
//
// Through open space that is cut into many cells the number of chains grows with the power of their length, the number of portals they
// cross does not. A merged search keeps for each portal one beam that holds those of all chains as far as the portal: the convex
// hull of the parts of the portal that they leave, and that of the parts of the source. It errs towards visible, by more than the
// search along chains (flow.h) does, and takes a time that is polynomial.
#ifndef VISIBILITY_PAIRS_MERGED_H
#define VISIBILITY_PAIRS_MERGED_H

#include "visibility/pairs/flow.h"

// As flow_search, with a line tried through each portal by which cells in doubt are reached; the flow's context is a Finding.
bool merged_search(Flow *flow, int way);

// All cells that lines through the way may enter, as far as a merged search tells, when nothing is known beforehand: flow->might is not
// read. Writes at most `most` of them, in no order, the nearest first about; returns their number, -1: there are more, or all allowed
// work is done.
int merged_cells(Flow *flow, int way, int *cells, int most);

#endif
