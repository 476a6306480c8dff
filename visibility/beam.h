// beam.h - the lines that come through a chain of portals, bounded by separating planes.
//
// A chain is a sequence of ways, each leading out of the cell where the one before leads in. All lines that come through
// a chain lie, behind its last portal, in the beam: the separators of the rest of its first portal (the source) and
// of its last (the pass). Each further portal is clipped by the beam, and the source by the separators of the new
// portal and the pass. Where nothing is left no line comes through; where something is left there need not be one.
#ifndef VISIBILITY_BEAM_H
#define VISIBILITY_BEAM_H

#include "visibility/ways.h"

typedef struct Beam {
    int way;               // crossed last
    Winding source, pass;  // the visible parts of the chain's first portal, and of this way's
    Separators planes;
} Beam;

// The chain of one way, from whose whole portal lines go everywhere: without planes.
void beam_begin(const WayGraph *ways, int way, Beam *out);

// The half-spaces that hold, beyond `pass`, every line that comes through `source` and then `pass`.
void beam_planes(const Winding *source, const Winding *pass, double epsilon, Separators *out);

// -1: the way's portal lies outside one of the half-spaces, or touches it from outside within epsilon; +1: inside all of them; else
// 0, and which of them cut it.
int beam_meets(const WayShape *way, const Separators *planes, double epsilon, uint64_t *cutting);

// The chain of `from` goes on through `way`: the visible parts of its portal, and of the source through which it is seen. Only
// the planes of `cutting` (beam_meets) are tried. `first` is the beam of the chain's first way. False when nothing is left.
// The planes of `out` are not made.
bool beam_narrow(const WayGraph *ways, const Beam *first, const Beam *from, int way, uint64_t cutting,
                 Beam *out, ChainWork *work);

// The half-space on the given side of a way's portal (+1 in front), to clip the portal of `other`.
Plane beam_side(const WayShape *way, int side, const WayShape *other);

// Clips by all half-spaces, or by those of `some` only; false when nothing is left.
bool beam_clip(Winding *w, const Separators *planes, double epsilon);
static inline bool beam_cut(Winding *w, const Separators *planes, uint64_t some, double epsilon) {
    for (; some; some &= some - 1) {
        if (!winding_clip(w, separators_at(planes, __builtin_ctzll(some)), epsilon)) return false;
    }
    return true;
}

#endif
