// sight.h - a real line through a chain of portals: the proof that two cells see each other.
#ifndef VISIBILITY_PAIRS_SIGHT_H
#define VISIBILITY_PAIRS_SIGHT_H

#include "visibility/pairs/rounds.h"

// Does the line pass the portal by SIGHT_MARGIN epsilons or more from its edges, and not flatter than SIGHT_FLATTEST? Both
// are several times those of a check by other means, so that rounding stands between neither and its proof.
#define SIGHT_MARGIN 4
#define SIGHT_FLATTEST 4e-6  // sine
bool sight_passes(const WayShape *way, Sight sight, double epsilon);

// Looks from a point of the first portal of the chain steps[0 .. depth] through all its portals; exact but for rounding,
// which errs towards nothing. On success the line passes every portal by SIGHT_MARGIN epsilons or more from its edges.
bool sight_from_point(Flow *flow, int depth, Vec3 from, Sight *out);

// The line from `from` to the middle of the visible part of the chain's last portal, if it passes all portals so.
bool sight_to_middle(Flow *flow, int depth, Vec3 from, Sight *out);

// The same from several points of `source`, a part of the first portal.
bool sight_through(Flow *flow, int depth, const Winding *source, Sight *out);

// Records that all cells along the chain see each other along `sight`, and takes them from the cells in doubt; the
// flow's context is a Finding.
void sight_record(Flow *flow, int depth, Sight sight);

#endif
