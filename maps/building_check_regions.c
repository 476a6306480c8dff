// building_check_regions.c - the faults of regions: rings, outlines, and pairs that overlap or touch without sharing
// vertices. It computes in whole millimetres held in doubles, in which every orientation is exact; points off the grid keep their fraction.
#include <limits.h>
#include <stdlib.h>

#include "maps/building_check.h"

static const double MM_PER_M = 1000.0;

static double ring_area2(const Vec2 *p, int count) {
    double sum = 0;
    for (int i = 1; i + 1 < count; i++) sum += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0]));
    return sum;
}

// c on the open segment a-b.
static bool strictly_between(Vec2 a, Vec2 b, Vec2 c) {
    if (vec2_equal(a, c) || vec2_equal(b, c)) return false;
    if (c.x < fmin(a.x, b.x) || c.x > fmax(a.x, b.x) || c.y < fmin(a.y, b.y) || c.y > fmax(a.y, b.y))
        return false;
    return orient2d(a, b, c) == 0;
}

static bool boxes_apart(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    return fmax(a.x, b.x) < fmin(c.x, d.x) || fmax(c.x, d.x) < fmin(a.x, b.x) ||
           fmax(a.y, b.y) < fmin(c.y, d.y) || fmax(c.y, d.y) < fmin(a.y, b.y);
}

// The open segments cross in one point.
static bool cross_properly(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    return orient2d(a, b, c) * orient2d(a, b, d) < 0 && orient2d(c, d, a) * orient2d(c, d, b) < 0;
}

// The segments share more than a point.
static bool overlap_along_line(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    if (orient2d(a, b, c) != 0 || orient2d(a, b, d) != 0) return false;
    bool x = fabs(b.x - a.x) >= fabs(b.y - a.y);
    double a0 = x ? a.x : a.y, b0 = x ? b.x : b.y, c0 = x ? c.x : c.y, d0 = x ? d.x : d.y;
    return fmax(fmin(a0, b0), fmin(c0, d0)) < fmin(fmax(a0, b0), fmax(c0, d0));
}

typedef struct Edge {
    Vec2 a, b;
    int ring, index;
} Edge;

typedef struct Outline {
    Edge *edges;  // by left end
    int count;
    BoxTree tree;  // of the edges
    Vec2 min, max;
    bool sound;
} Outline;

// The edges whose boxes touch a rectangle, ascending.
static int edges_near(Check *c, const Outline *outline, Vec2 low, Vec2 high, BoxHits *hits) {
    return box_tree_find(&outline->tree, (Box){vec3(low.x, low.y, 0), vec3(high.x, high.y, 0)}, c->arena,
                         hits);
}

static int edges_near_edge(Check *c, const Outline *outline, Edge e, BoxHits *hits) {
    return edges_near(c, outline, vec2(fmin(e.a.x, e.b.x), fmin(e.a.y, e.b.y)),
                      vec2(fmax(e.a.x, e.b.x), fmax(e.a.y, e.b.y)), hits);
}

// +1 inside, 0 on the boundary, -1 outside the first rings of a region. By a ray along x just above p: on its own height may lie all
// edges of a long straight wall.
static int locate(Check *c, const Outline *outline, int ring_count, Vec2 p) {
    bool inside = false;
    edges_near(c, outline, p, p, &c->row);
    for (int i = 0; i < c->row.count; i++) {
        Edge e = outline->edges[c->row.items[i]];
        if (e.ring < ring_count && (vec2_equal(p, e.b) || strictly_between(e.a, e.b, p))) return 0;
    }
    double above = nextafter(p.y, INFINITY);
    edges_near(c, outline, vec2(p.x, above), vec2(INFINITY, above), &c->row);
    for (int i = 0; i < c->row.count; i++) {
        Edge e = outline->edges[c->row.items[i]];
        if (e.ring >= ring_count || (e.b.y > p.y) == (e.a.y > p.y)) continue;
        int side = e.a.y < e.b.y ? orient2d(e.a, e.b, p) : orient2d(e.b, e.a, p);
        if (side > 0) inside = !inside;
    }
    return inside ? 1 : -1;
}

static bool on_grid(Vec2 p) { return p.x == maps_snap(p.x) && p.y == maps_snap(p.y); }

static bool check_ring(Check *c, int region, int k, const Ring *ring) {
    const Building *b = c->b;
    if (ring->point_count < 3 || !run_good(ring->first_point, ring->point_count, b->point_count)) {
        check_fault(c, "region %d ring %d: points %d to %d of %d (at least 3, all there)", region, k,
                    ring->first_point, ring->first_point + ring->point_count - 1, b->point_count);
        return false;
    }
    for (int i = 0; i < ring->point_count; i++) {
        Vec2 p = b->points[ring->first_point + i];
        if (!good(p.x) || !good(p.y)) {
            check_fault(c, "region %d ring %d: point %d at (%g, %g) (finite, within %g m)", region, k, i, p.x,
                        p.y, MAPS_LIMIT);
            return false;
        }
        if (!on_grid(p) && !region_is_convex(b, &b->regions[region])) {
            check_fault(
                c,
                "region %d ring %d: point (%.6f, %.6f) is off the grid of %g m, and the region is not convex",
                region, k, p.x, p.y, MAPS_GRID);
        }
        int material = b->edge_material ? b->edge_material[ring->first_point + i] : -1;
        if (!index_good(material, b->material_count)) {
            check_fault(c, "region %d ring %d: edge %d at (%.3f, %.3f) has material %d of %d", region, k, i,
                        p.x, p.y, material, b->material_count);
        }
    }
    double area = ring_area2(&c->mm[ring->first_point], ring->point_count);
    if (k == 0 ? area <= 0 : area >= 0) {
        Vec2 p = b->points[ring->first_point];
        check_fault(
            c,
            "region %d ring %d at (%.3f, %.3f): signed area %g m^2 (the outer ring counter-clockwise, "
            "holes clockwise)",
            region, k, p.x, p.y, area / 2 / (MM_PER_M * MM_PER_M));
        return false;
    }
    return true;
}

static bool check_region_fields(Check *c, int i) {
    const Building *b = c->b;
    const Region *r = &b->regions[i];
    const char *name = text_of(r->name);
    if (r->kind < 0 || r->kind >= REGION_KINDS)
        check_fault(c, "region %d (%s): kind %d", i, name, (int)r->kind);
    if (r->storey != -1 && !index_good(r->storey, b->storey_count)) {
        check_fault(c, "region %d (%s): storey %d of %d", i, name, r->storey, b->storey_count);
    }
    bool opening = r->kind == REGION_OPENING;
    if (opening ? !index_good(r->opening, b->opening_count) : r->opening != -1) {
        check_fault(c, "region %d (%s): opening %d of %d", i, name, r->opening, b->opening_count);
    }
    if (r->side < 0 || r->side > 1)
        check_fault(c, "region %d (%s): side %d (allowed 0, 1)", i, name, r->side);
    int material[2] = {r->floor_material, r->ceiling_material};
    for (int k = 0; k < 2; k++) {
        if (material[k] < -1 || material[k] >= b->material_count) {
            check_fault(c, "region %d (%s): %s material %d of %d", i, name, k ? "ceiling" : "floor",
                        material[k], b->material_count);
        }
    }
    if (!good(r->z0) || !good(r->z1) || r->z0 >= r->z1) {
        check_fault(c, "region %d (%s): reaches from %g m up to %g m", i, name, r->z0, r->z1);
        return false;
    }
    if (r->z0 != maps_snap(r->z0) || r->z1 != maps_snap(r->z1)) {
        check_fault(c, "region %d (%s): heights %.6f, %.6f are off the grid of %g m", i, name, r->z0, r->z1,
                    MAPS_GRID);
    }
    if (r->ring_count < 1 || !run_good(r->first_ring, r->ring_count, b->ring_count)) {
        check_fault(c, "region %d (%s): rings %d to %d of %d", i, name, r->first_ring,
                    r->first_ring + r->ring_count - 1, b->ring_count);
        return false;
    }
    return true;
}

static int by_left_end(const void *pa, const void *pb) {
    const Edge *a = pa, *b = pb;
    double x = fmin(a->a.x, a->b.x), y = fmin(b->a.x, b->b.x);
    return x != y ? (x < y ? -1 : 1) : a->ring != b->ring ? a->ring - b->ring : a->index - b->index;
}

static void gather_edges(Check *c, const Region *r, Outline *out) {
    int count = 0;
    for (int k = 0; k < r->ring_count; k++) count += c->b->rings[r->first_ring + k].point_count;
    out->edges = ARENA_ARRAY(c->arena, Edge, count);
    out->min = vec2(INFINITY, INFINITY);
    out->max = vec2(-INFINITY, -INFINITY);
    for (int k = 0; k < r->ring_count; k++) {
        const Ring *ring = &c->b->rings[r->first_ring + k];
        const Vec2 *v = &c->mm[ring->first_point];
        for (int i = 0; i < ring->point_count; i++) {
            out->edges[out->count++] = (Edge){v[i], v[(i + 1) % ring->point_count], k, i};
            out->min = vec2(fmin(out->min.x, v[i].x), fmin(out->min.y, v[i].y));
            out->max = vec2(fmax(out->max.x, v[i].x), fmax(out->max.y, v[i].y));
        }
    }
    qsort(out->edges, (size_t)out->count, sizeof(Edge), by_left_end);
    Box *boxes = ARENA_ARRAY(c->arena, Box, out->count);
    for (int i = 0; i < out->count; i++) {
        Edge e = out->edges[i];
        boxes[i] = box_add(box_add(box_empty(), vec3(e.a.x, e.a.y, 0)), vec3(e.b.x, e.b.y, 0));
    }
    out->tree = box_tree_build(boxes, out->count, c->arena);
}

// Two edges of one region may share end points, of different rings even; nothing else.
static bool edges_of_region_meet_well(Edge e, Edge f) {
    if (boxes_apart(e.a, e.b, f.a, f.b)) return true;
    if (vec2_equal(e.a, f.a) && e.ring == f.ring) return false;  // a vertex visited twice
    return !cross_properly(e.a, e.b, f.a, f.b) && !strictly_between(e.a, e.b, f.a) &&
           !strictly_between(e.a, e.b, f.b) && !strictly_between(f.a, f.b, e.a) &&
           !strictly_between(f.a, f.b, e.b) && !overlap_along_line(e.a, e.b, f.a, f.b);
}

static bool check_outline(Check *c, int i, Outline *out) {
    const Region *r = &c->b->regions[i];
    gather_edges(c, r, out);
    for (int e = 0; e < out->count; e++) {
        Edge a = out->edges[e];
        if (vec2_equal(a.a, a.b)) {
            check_fault(c, "region %d ring %d: edge %d at (%.3f, %.3f) has no length", i, a.ring, a.index,
                        a.a.x / MM_PER_M, a.a.y / MM_PER_M);
            return false;
        }
        edges_near_edge(c, out, a, &c->near);
        for (int k = 0; k < c->near.count; k++) {
            int f = c->near.items[k];
            if (f <= e || edges_of_region_meet_well(a, out->edges[f])) continue;
            check_fault(c, "region %d (%s): its outline touches or crosses itself near (%.3f, %.3f)", i,
                        text_of(r->name), a.a.x / MM_PER_M, a.a.y / MM_PER_M);
            return false;
        }
    }
    for (int k = 1; k < r->ring_count; k++) {
        // A hole lies inside: its edges' middles do, since nothing crosses. In doubled millimetres, exactly.
        const Ring *ring = &c->b->rings[r->first_ring + k];
        for (int n = 0; n < ring->point_count; n++) {
            if (locate(c, out, 1, c->mm[ring->first_point + n]) >= 0) continue;
            check_fault(c, "region %d (%s): hole %d at (%.3f, %.3f) lies outside", i, text_of(r->name), k,
                        c->b->points[ring->first_point].x, c->b->points[ring->first_point].y);
            return false;
        }
    }
    return true;
}

typedef struct Pair {
    bool crossing, unshared;
    Vec2 place;
} Pair;

// How edge e of one region meets the edges of the other; whether it lies on one of them.
static bool edge_against(Check *c, Edge e, const Outline *other, Pair *pair, bool *same_way) {
    bool shared = false;
    edges_near_edge(c, other, e, &c->near);
    for (int i = 0; i < c->near.count; i++) {
        Edge f = other->edges[c->near.items[i]];
        if (boxes_apart(e.a, e.b, f.a, f.b)) continue;
        if (vec2_equal(e.a, f.b) && vec2_equal(e.b, f.a)) {
            shared = true;
        } else if (vec2_equal(e.a, f.a) && vec2_equal(e.b, f.b)) {
            shared = *same_way = true;
        } else if (cross_properly(e.a, e.b, f.a, f.b)) {
            pair->crossing = true;
            pair->place = e.a;
        } else if (overlap_along_line(e.a, e.b, f.a, f.b)) {
            pair->unshared = true;
            pair->place = e.a;
        }
    }
    return shared;
}

// The interiors meet iff edges cross, or an edge of one, cut where the other's vertices lie on it, runs
// inside the other, or both run along one edge the same way.
static bool interiors_meet(Check *c, const Outline *a, const Outline *b, Pair *pair) {
    bool same_way = false;
    for (int way = 0; way < 2; way++) {
        const Outline *mine = way ? b : a, *other = way ? a : b;
        edges_near(c, mine, other->min, other->max, &c->mine);
        for (int i = 0; i < c->mine.count; i++) {
            Edge e = mine->edges[c->mine.items[i]];
            bool shared = edge_against(c, e, other, pair, &same_way);
            if (pair->crossing || same_way) {
                pair->place = e.a;
                return true;
            }
            if (shared) continue;
            Vec2 mid = vec2((e.a.x + e.b.x) / 2, (e.a.y + e.b.y) / 2);
            if (locate(c, other, INT_MAX, mid) > 0 || locate(c, other, INT_MAX, e.a) > 0) {
                pair->place = e.a;
                return true;
            }
        }
    }
    return false;
}

static void check_pair(Check *c, int i, int j, const Outline *a, const Outline *b) {
    const Region *r = &c->b->regions[i], *s = &c->b->regions[j];
    Pair pair = {false, false, {0, 0}};
    bool meet = interiors_meet(c, a, b, &pair);
    if (meet && fmax(r->z0, s->z0) < fmin(r->z1, s->z1)) {
        check_fault(c, "regions %d (%s) and %d (%s) overlap near (%.3f, %.3f) between heights %.3f and %.3f",
                    i, text_of(r->name), j, text_of(s->name), pair.place.x / MM_PER_M,
                    pair.place.y / MM_PER_M, fmax(r->z0, s->z0), fmin(r->z1, s->z1));
    } else if (pair.unshared) {
        check_fault(c, "regions %d (%s) and %d (%s) touch without sharing vertices near (%.3f, %.3f)", i,
                    text_of(r->name), j, text_of(s->name), pair.place.x / MM_PER_M, pair.place.y / MM_PER_M);
    }
}

// A sound region by the left end of its outline.
typedef struct Swept {
    double left;
    int region;
} Swept;

static int by_left(const void *p, const void *q) {
    const Swept *a = p, *b = q;
    if (a->left != b->left) return a->left < b->left ? -1 : 1;
    return (a->region > b->region) - (a->region < b->region);
}

// Only regions that lie in one another's reach along x: maps have thousands.
static void check_pairs(Check *c, const Outline *outlines) {
    const Building *b = c->b;
    Swept *order = ARENA_ARRAY(c->arena, Swept, b->region_count + 1);
    int count = 0;
    for (int i = 0; i < b->region_count; i++) {
        if (outlines[i].sound) order[count++] = (Swept){outlines[i].min.x, i};
    }
    qsort(order, (size_t)count, sizeof *order, by_left);
    for (int i = 0; i < count; i++) {
        const Outline *p = &outlines[order[i].region];
        for (int k = i + 1; k < count && order[k].left <= p->max.x; k++) {
            int first = order[i].region, second = order[k].region;
            const Region *r = &b->regions[first], *s = &b->regions[second];
            const Outline *q = &outlines[second];
            if (fmax(r->z0, s->z0) > fmin(r->z1, s->z1) || p->max.y < q->min.y || q->max.y < p->min.y)
                continue;
            if (first < second) {
                check_pair(c, first, second, p, q);
            } else {
                check_pair(c, second, first, q, p);
            }
        }
    }
}

void check_regions(Check *c) {
    const Building *b = c->b;
    c->mm = ARENA_ARRAY(c->arena, Vec2, b->point_count);
    for (int i = 0; i < b->point_count; i++) {
        Vec2 p = vec2_scale(b->points[i], MM_PER_M);
        c->mm[i] = on_grid(b->points[i]) ? vec2(nearbyint(p.x), nearbyint(p.y)) : p;
    }
    Outline *outlines = ARENA_ARRAY(c->arena, Outline, b->region_count);
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (!check_region_fields(c, i)) continue;
        bool rings = true;
        for (int k = 0; k < r->ring_count; k++)
            rings = check_ring(c, i, k, &b->rings[r->first_ring + k]) && rings;
        outlines[i].sound = rings && check_outline(c, i, &outlines[i]);
    }
    check_pairs(c, outlines);
}
