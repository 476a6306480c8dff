// sight.c - see sight.h. The view from a point is a cone; each portal is clipped by it, and what is left makes the next
// cone.
#include "visibility/pairs/sight.h"

// Where the line crosses a portal.
static Vec3 sight_crossing(const WayShape *way, Sight sight) {
    double a = plane_distance(way->facet.plane, sight.from), b = plane_distance(way->facet.plane, sight.to);
    return a == b ? sight.from : vec3_lerp(sight.from, sight.to, a / (a - b));
}

// How near the line comes to an edge of the portal it pierces, metres, whatever surface its bent corners span; negative
// outside, or when it is too flat to tell. Between the lines, not within the portal's plane: one that grazes the plane
// may cross it far from an edge and yet miss that edge by a hair.
static double margin(const WayShape *way, Sight sight) {
    Vec3 p = sight_crossing(way, sight), direction = vec3_normalize(vec3_sub(sight.to, sight.from));
    double least = INFINITY, steepness = fabs(vec3_dot(direction, way->facet.plane.n));
    if (!(steepness >= SIGHT_FLATTEST)) return -INFINITY;
    for (int i = 0; i < way->corner_count; i++) {
        Vec3 corner = way->corners[i],
             edge = vec3_sub(way->corners[i + 1 == way->corner_count ? 0 : i + 1], corner);
        double across = vec3_length(vec3_cross(edge, direction));
        if (across == 0) continue;
        double inwards = vec3_dot(vec3_cross(way->facet.plane.n, edge), vec3_sub(p, corner));
        least = fmin(least, (inwards * steepness - way->facet.bend * vec3_length(edge)) / across);
    }
    return least;
}

bool sight_passes(const WayShape *way, Sight sight, double epsilon) {
    return margin(way, sight) >= SIGHT_MARGIN * epsilon;
}

// The work of a portal that a line is tried against, and of a pair that is recorded, see ways_work.
enum { WORK_PORTAL = 50, WORK_PAIR = 40 };

static bool passes(Flow *flow, int depth, Sight sight) {
    for (int i = 0; i <= depth; i++) {
        flow->spent += WORK_PORTAL;
        if (!sight_passes(&flow->ways->ways[flow->steps[i]->beam.way], sight, flow->ways->epsilon))
            return false;
    }
    return true;
}

bool sight_from_point(Flow *flow, int depth, Vec3 from, Sight *out) {
    Separators cone;
    Winding left;
    double epsilon = flow->ways->epsilon;
    cone.count = left.count = 0;
    if (flow->ways->ways[flow->steps[0]->beam.way].coarse) return false;
    for (int i = 1; i <= depth; i++) {
        const WayShape *way = &flow->ways->ways[flow->steps[i]->beam.way];
        // Flat against a portal there is no telling.
        if (way->coarse || plane_distance(way->facet.plane, from) >
                               -SIGHT_MARGIN * (epsilon + facet_doubt(&way->facet, from)))
            return false;
        way_winding(way, &left);
        if (!beam_clip(&left, &cone, epsilon)) return false;
        flow_cone(from, &left, &cone);
    }
    *out = (Sight){from, winding_middle(&left)};
    return passes(flow, depth, *out);
}

bool sight_to_middle(Flow *flow, int depth, Vec3 from, Sight *out) {
    for (int i = 0; i <= depth; i++) {
        if (flow->ways->ways[flow->steps[i]->beam.way].coarse) return false;
    }
    *out = (Sight){from, winding_middle(&flow->steps[depth]->beam.pass)};
    return depth > 0 && passes(flow, depth, *out);
}

bool sight_through(Flow *flow, int depth, const Winding *source, Sight *out) {
    static const double INWARDS =
        0.02;  // corners and sides are tried from so far inside: on them no line passes
    Vec3 middle = winding_middle(source);
    if (sight_from_point(flow, depth, middle, out)) return true;
    for (int i = 0; i < 2 * source->count; i++) {
        Vec3 p = winding_corner(source, i / 2);
        if (i % 2) p = vec3_lerp(p, winding_corner(source, i / 2 + 1), 0.5);
        if (sight_from_point(flow, depth, vec3_lerp(p, middle, INWARDS), out)) return true;
    }
    return false;
}

// Places on the line inside the cells that the steps leave: half-way from where it came in. Lines between such places are
// as long as can be, so that walking them again is sure of their direction. Before the first portal and beyond the last
// the line is not followed: there its ends stand.
static void set_places(Flow *flow, int depth, Sight sight) {
    Vec3 in = sight.from;
    for (int i = 0; i <= depth; i++) {
        Vec3 out = sight_crossing(&flow->ways->ways[flow->steps[i]->beam.way], sight);
        flow->steps[i]->place = i == 0 ? sight.from : vec3_lerp(in, out, 0.5);
        in = out;
    }
}

void sight_record(Flow *flow, int depth, Sight sight) {
    const WayShape *ways = flow->ways->ways;
    Finding *finding = flow->context;
    set_places(flow, depth, sight);
    for (int j = 0; j <= depth; j++) {
        if (flow->steps[j]->recorded) continue;  // with those before it, on an earlier line of the same chain
        flow->steps[j]->recorded = true;
        flow->spent += WORK_PAIR * (j + 1);
        int last = ways[flow->steps[j]->beam.way].to;
        row_add(finding->kept, last);
        row_drop(flow->unknown, last);
        Vec3 to = j < depth ? flow->steps[j + 1]->place : sight.to;
        for (int i = 0; i < j; i++)
            finding_add(finding, ways[flow->steps[i]->beam.way].from, last, flow->steps[i]->place, to);
    }
}
