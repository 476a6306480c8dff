// bezier_beam.h - a ray as two planes, about a patch's centre; the pieces of the patch it may hit; hits as they are found.
#ifndef RAYS_BEZIER_BEAM_H
#define RAYS_BEZIER_BEAM_H

#include "visibility/bezier/bezier_patch.h"
#include "visibility/bezier/hit_list.h"

typedef struct BezierBeam {
    const BezierPatch *patch;
    Vec3 o, d;     // o is nearest to the centre
    Vec3 n[2];     // of the planes, unit
    double e[2];   // dot(n, o)
    double start;  // t of o
    double slack;  // distances that count as 0
    HitList *list;
    CurvedWork *work;
} BezierBeam;

// False: the ray passes beside all of the patch.
bool bezier_beam(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work, BezierBeam *out);
// Distances of a net's points to one of the planes, multiplied by their weights; rows of v.
void bezier_beam_project(const BezierBeam *beam, const PatchNet *net, int plane, Four out[4]);
// Calls for the pieces whose boxes the ray meets before the hits found so far, the nearest first.
void bezier_beam_pieces(const BezierBeam *beam,
                        void (*each)(const BezierBeam *beam, const PatchPiece *piece));
// At u, v of a piece, unless it is cut off or known.
void bezier_beam_hit(const BezierBeam *beam, const PatchPiece *piece, double u, double v);

#endif
