// beam.c - see beam.h.
//
// Source: the clipping of source and pass along a chain is that of Quake's vis (J. Carmack, 1996); separating planes bound
// what a chain lets through from outside (Teller 1992).
#include "visibility/beam.h"

void beam_begin(const WayGraph *ways, int way, Beam *out) {
    out->way = way;
    out->planes.count = 0;
    way_winding(&ways->ways[way], &out->source);
    way_winding(&ways->ways[way], &out->pass);
}

void beam_planes(const Winding *source, const Winding *pass, double epsilon, Separators *out) {
    out->count = 0;
    winding_tangents(source, pass, 1, KEEP_OTHER, epsilon, out);
    winding_tangents(pass, source, -1, KEEP_EDGES, epsilon, out);
}

Plane beam_side(const WayShape *way, int side, const WayShape *other) {
    Plane plane = way->facet.plane;
    return (Plane){vec3_scale(plane.n, side), side * plane.d - way_doubt(way, other)};
}

// Corners coordinate by coordinate or one after the other: `step` numbers lie from one to the next.
typedef struct Corners {
    const double *x, *y, *z;
    int count, step;
} Corners;

// Which half-spaces of a block have no corner inside by more than epsilon, and which have one outside by more.
static inline unsigned block_misses(const Separators *s, int block, Corners c, double epsilon,
                                    unsigned *cutting) {
    Four nx = four_load(s->x + block), ny = four_load(s->y + block), nz = four_load(s->z + block),
         d = four_load(s->d + block);
    FourMask inside = {0}, outside = {0};
    for (int k = 0; k < c.count * c.step; k += c.step) {
        Four at = nx * c.x[k] + ny * c.y[k] + nz * c.z[k] - d;
        inside |= at > epsilon;
        outside |= at < -epsilon;
    }
    *cutting = four_lanes(outside);
    return FOUR_ALL & ~four_lanes(inside);
}

int beam_meets(const WayShape *way, const Separators *planes, double epsilon, uint64_t *cutting) {
    Vec3 middle = way->facet.middle;
    Corners corners = {&way->corners->x, &way->corners->y, &way->corners->z, way->corner_count, 3};
    // By the ball around the portal first.
    uint64_t near = 0;
    *cutting = 0;
    for (int i = 0; i < planes->count; i += FOUR) {
        Four at = four_load(planes->x + i) * middle.x + four_load(planes->y + i) * middle.y +
                  four_load(planes->z + i) * middle.z - four_load(planes->d + i);
        if (four_lanes(at < -way->radius)) return -1;
        near |= (uint64_t)four_lanes(at <= way->radius + epsilon) << i;
    }
    for (int i = 0; near; i += FOUR, near >>= FOUR) {
        unsigned cuts;
        if (!(near & FOUR_ALL)) continue;
        if (block_misses(planes, i, corners, epsilon, &cuts)) return -1;
        *cutting |= (uint64_t)cuts << i;
    }
    return *cutting == 0;
}

bool beam_clip(Winding *w, const Separators *planes, double epsilon) {
    Corners corners = {w->x, w->y, w->z, w->count, 1};
    uint64_t cutting = 0;
    for (int i = 0; i < planes->count; i += FOUR) {
        unsigned cuts;
        if (block_misses(planes, i, corners, epsilon, &cuts)) return false;
        cutting |= (uint64_t)cuts << i;
    }
    return beam_cut(w, planes, cutting, epsilon);
}

// Clips the rest of the portal of `other` by one side of that of `way`.
static bool clip_side(Winding *w, const WayShape *way, int side, const WayShape *other, double epsilon) {
    Plane plane = beam_side(way, side, other);
    if (plane_distance(plane, other->facet.middle) > other->radius + epsilon) return true;
    return winding_clip(w, plane, epsilon);
}

bool beam_narrow(const WayGraph *ways, const Beam *first, const Beam *from, int way, uint64_t cutting,
                 Beam *out, ChainWork *work) {
    const WayShape *here = &ways->ways[way], *start = &ways->ways[first->way];
    double epsilon = ways->epsilon;
    out->way = way;
    way_winding(here, &out->pass);
    work->clips++;
    if (!clip_side(&out->pass, start, 1, here, epsilon)) return false;
    if (!beam_cut(&out->pass, &from->planes, cutting, epsilon)) return false;
    winding_copy(&out->source, &from->source);
    if (!clip_side(&out->source, here, -1, start, epsilon)) return false;
    if (from == first) return true;
    Separators back;
    back.count = 0;
    // Planes through the edges of the new portal would narrow the source hardly more (1 % fewer chains).
    winding_tangents(&from->pass, &out->pass, 1, KEEP_EDGES, epsilon, &back);
    work->separators += back.count;
    return beam_clip(&out->source, &back, epsilon);
}
