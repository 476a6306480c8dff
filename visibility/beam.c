// beam.c - see beam.h.
//
// Source: the clipping of source and pass along a chain is that of Quake's vis (J. Carmack, 1996); separating planes bound
// what a chain lets through from outside (Teller 1992).
#include "visibility/beam.h"

void beam_begin(const WayGraph *ways, int way, Beam *out) {
    out->way = way;
    out->plane_count = 0;
    way_winding(&ways->ways[way], &out->source);
    way_winding(&ways->ways[way], &out->pass);
}

int beam_planes(const Winding *source, const Winding *pass, double epsilon, Separator out[BEAM_MAX]) {
    int count = winding_tangents(source, pass, 1, KEEP_OTHER, epsilon, out);
    return count + winding_tangents(pass, source, -1, KEEP_EDGES, epsilon, out + count);
}

Separator beam_side(const WayShape *way, int side, const WayShape *other, double epsilon) {
    Plane plane = way->facet.plane;
    return (Separator){vec3_scale(plane.n, side), side * plane.d - way_doubt(way, other), epsilon};
}

int beam_ball(const WayShape *way, const Separator *planes, int count, uint64_t *cutting) {
    *cutting = 0;
    for (int i = 0; i < count; i++) {
        // The slack's measure bounds the normal's length from above (separator_of).
        double at = vec3_dot(planes[i].n, way->facet.middle) - planes[i].d;
        double length = fabs(planes[i].n.x) + fabs(planes[i].n.y) + fabs(planes[i].n.z);
        double reach = way->radius * length;
        if (at < -reach) return -1;
        if (at <= reach + planes[i].slack) *cutting |= (uint64_t)1 << i;
    }
    return *cutting == 0;
}

bool beam_narrow(const WayGraph *ways, const Beam *first, const Beam *from, int way, uint64_t cutting,
                 Beam *out, ChainWork *work) {
    const WayShape *here = &ways->ways[way], *start = &ways->ways[first->way];
    out->way = way;
    way_winding(here, &out->pass);
    work->clips++;
    if (!winding_clip(&out->pass, beam_side(start, 1, here, ways->epsilon))) return false;
    for (; cutting; cutting &= cutting - 1) {
        if (!winding_clip(&out->pass, from->planes[__builtin_ctzll(cutting)])) return false;
    }
    winding_copy(&out->source, &from->source);
    if (!winding_clip(&out->source, beam_side(here, -1, start, ways->epsilon))) return false;
    if (from == first) return true;
    Separator back[WINDING_MAX];
    // Planes through the edges of the new portal would narrow the source hardly more (1 % fewer chains).
    int count = winding_tangents(&from->pass, &out->pass, 1, KEEP_EDGES, ways->epsilon, back);
    work->separators += count;
    for (int i = 0; i < count; i++) {
        if (!winding_clip(&out->source, back[i])) return false;
    }
    return true;
}
