// building_check.c - every fault of a building, named with its place.
#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>

#include "engine/core/box_tree.h"
#include "engine/core/polygon.h"
#include "maps/building/building.h"
#include "maps/curved/curved_patch.h"

typedef struct Check {
    const Building *b;
    Arena *arena;    // of the sentences
    Arena *scratch;  // of all else
    const char **faults;
    int max, count;
    Vec2 *mm;                 // [point_count] plan points in millimetres, whole ones on the grid
    BoxHits mine, near, row;  // edges found last, of regions
} Check;

// Adds a fault; the sentence is formatted as by printf.
__attribute__((format(printf, 2, 3))) static inline void check_fault(Check *c, const char *format, ...) {
    if (c->count++ >= c->max) return;
    va_list args;
    va_start(args, format);
    c->faults[c->count - 1] = arena_format_list(c->arena, format, args);
    va_end(args);
}

static inline bool good(double x) { return isfinite(x) && fabs(x) <= MAPS_LIMIT; }
static inline bool good3(Vec3 p) { return good(p.x) && good(p.y) && good(p.z); }
static inline bool index_good(int i, int count) { return i >= 0 && i < count; }
static inline bool run_good(int first, int count, int total) {
    return first >= 0 && count >= 0 && first <= total - count;
}
static inline const char *text_of(const char *name) { return name && *name ? name : "unnamed"; }

// ---- the faults of regions: rings, outlines, and pairs that overlap or touch without sharing
// vertices. It computes in whole millimetres held in doubles, in which every orientation is exact; points off the grid keep their fraction.

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
    return box_tree_find(&outline->tree, (Box){vec3(low.x, low.y, 0), vec3(high.x, high.y, 0)}, c->scratch,
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
    out->edges = ARENA_ARRAY(c->scratch, Edge, count);
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
    Box *boxes = ARENA_ARRAY(c->scratch, Box, out->count);
    for (int i = 0; i < out->count; i++) {
        Edge e = out->edges[i];
        boxes[i] = box_add(box_add(box_empty(), vec3(e.a.x, e.a.y, 0)), vec3(e.b.x, e.b.y, 0));
    }
    out->tree = box_tree_build(boxes, out->count, c->scratch);
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

// Only regions that lie in one another's reach: maps have thousands, and in a tower most lie over one another.
static void check_pairs(Check *c, const Outline *outlines) {
    const Building *b = c->b;
    Swept *order = ARENA_ARRAY(c->scratch, Swept, b->region_count + 1);
    int count = 0;
    for (int i = 0; i < b->region_count; i++) {
        if (outlines[i].sound) order[count++] = (Swept){outlines[i].min.x, i};
    }
    qsort(order, (size_t)count, sizeof *order, by_left);
    Box *boxes = ARENA_ARRAY(c->scratch, Box, count + 1);
    for (int i = 0; i < count; i++) {
        const Outline *o = &outlines[order[i].region];
        const Region *r = &b->regions[order[i].region];
        boxes[i] = (Box){vec3(o->min.x, o->min.y, r->z0), vec3(o->max.x, o->max.y, r->z1)};
    }
    BoxTree tree = box_tree_build(boxes, count, c->scratch);
    BoxHits beside = {0};
    for (int i = 0; i < count; i++) {
        const Outline *p = &outlines[order[i].region];
        box_tree_find(&tree, boxes[i], c->scratch, &beside);
        for (int k = 0; k < beside.count; k++) {
            if (beside.items[k] <= i) continue;
            int first = order[i].region, second = order[beside.items[k]].region;
            const Outline *q = &outlines[second];
            if (first < second) {
                check_pair(c, first, second, p, q);
            } else {
                check_pair(c, second, first, q, p);
            }
        }
    }
}

static void check_regions(Check *c) {
    const Building *b = c->b;
    c->mm = ARENA_ARRAY(c->scratch, Vec2, b->point_count);
    for (int i = 0; i < b->point_count; i++) {
        Vec2 p = vec2_scale(b->points[i], MM_PER_M);
        c->mm[i] = on_grid(b->points[i]) ? vec2(nearbyint(p.x), nearbyint(p.y)) : p;
    }
    Outline *outlines = ARENA_ARRAY(c->scratch, Outline, b->region_count);
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

// ---- the form: each form of a building lacks some parts, and only one has given portals

// How far a given portal's corners may lie off its plane, metres: compilers print few decimals of their own units.
static const double GIVEN_BEND = 0.004;

static void check_absent(Check *c, const char *form, const char *what, int count) {
    if (count != 0) check_fault(c, "a building of %s has %d %s (allowed 0)", form, count, what);
}

static void check_given_portal(Check *c, int i) {
    const Building *b = c->b;
    const GivenPortal *p = &b->given_portals[i];
    for (int side = 0; side < 2; side++) {
        if (!index_good(p->cell[side], b->given_cell_count))
            check_fault(c, "given portal %d: cell %d (allowed 0 to %d)", i, p->cell[side],
                        b->given_cell_count - 1);
    }
    if (p->cell[0] == p->cell[1])
        check_fault(c, "given portal %d: leads from cell %d to itself", i, p->cell[0]);
    if (p->vertex_count < 3 || !run_good(p->first_vertex, p->vertex_count, b->vertex_count)) {
        check_fault(c, "given portal %d: vertices %d to %d of %d (at least 3, all there)", i, p->first_vertex,
                    p->first_vertex + p->vertex_count - 1, b->vertex_count);
        return;
    }
    const Vec3 *v = &b->vertices[p->first_vertex];
    for (int k = 0; k < p->vertex_count; k++) {
        if (good3(v[k])) continue;
        check_fault(c, "given portal %d: vertex %d at (%g, %g, %g) (finite, within %g m)", i, k, v[k].x,
                    v[k].y, v[k].z, MAPS_LIMIT);
        return;
    }
    double off = polygon_bend(v, p->vertex_count, plane_of_polygon(v, p->vertex_count));
    if (maps_portal_is_thin(v, p->vertex_count)) {
        check_fault(c, "given portal %d at (%.3f, %.3f, %.3f): no area", i, v[0].x, v[0].y, v[0].z);
    } else if (off > GIVEN_BEND) {
        check_fault(c, "given portal %d at (%.3f, %.3f, %.3f): bends by %.4f m (limit %g)", i, v[0].x, v[0].y,
                    v[0].z, off, GIVEN_BEND);
    }
}

static void check_no_plan(Check *c, const char *form) {
    const Building *b = c->b;
    check_absent(c, form, "regions", b->region_count);
    check_absent(c, form, "storeys", b->storey_count);
    check_absent(c, form, "inlays", b->inlay_count);
}

static void check_no_cells(Check *c, const char *form) {
    check_absent(c, form, "given cells", c->b->given_cell_count);
    check_absent(c, form, "given portals", c->b->given_portal_count);
}

static void check_form(Check *c) {
    const Building *b = c->b;
    switch (b->form) {
    case FORM_REGIONS:
        check_no_cells(c, "regions");
        return;
    case FORM_SOUP:
        check_no_plan(c, "polygons alone");
        check_no_cells(c, "polygons alone");
        return;
    case FORM_CELLS:
        check_no_plan(c, "given cells");
        check_absent(c, "given cells", "openings", b->opening_count);
        check_absent(c, "given cells", "leaves", b->leaf_count);
        check_absent(c, "given cells", "objects", b->object_count);
        check_absent(c, "given cells", "polygons", b->polygon_count);
        if (b->given_cell_count < 1) check_fault(c, "a building of given cells has none");
        for (int i = 0; i < b->given_portal_count; i++) check_given_portal(c, i);
        return;
    case BUILDING_FORMS:
        break;
    }
    check_fault(c, "form %d (allowed 0 to %d)", (int)b->form, BUILDING_FORMS - 1);
}

// ---- materials, storeys, polygons, objects, openings

static void check_rgb(Check *c, const char *what, int i, Rgb v, float most) {
    float channel[3] = {v.r, v.g, v.b};
    for (int k = 0; k < 3; k++) {
        if (!(channel[k] >= 0 && channel[k] <= most)) {
            check_fault(c, "%s %d: channel %d is %g (allowed 0 to %g)", what, i, k, (double)channel[k],
                        (double)most);
        }
    }
}

static void check_bands(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->band_count; i++) {
        const EdgeBand *band = &b->bands[i];
        if (!index_good(band->edge, b->point_count) || !index_good(band->material, b->material_count) ||
            !good(band->from) || (i > 0 && band[-1].edge > band->edge))
            check_fault(c, "band %d: edge %d of %d, from %g m, material %d of %d", i, band->edge,
                        b->point_count, band->from, band->material, b->material_count);
    }
}

static void check_materials_and_storeys(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->material_count; i++) {
        const Material *m = &b->materials[i];
        check_rgb(c, "reflectance of material", i, m->reflectance, MAPS_MAX_REFLECTANCE);
        check_rgb(c, "emission of material", i, m->emission, 1e30f);
        if (!(m->alpha >= 0 && m->alpha <= 1)) {
            check_fault(c, "material %d (%s): alpha %g (allowed 0 to 1)", i, text_of(m->name),
                        (double)m->alpha);
        }
        if (!index_good(m->spread, b->spread_count + (b->spread_count == 0)))
            check_fault(c, "material %d (%s): spread %d of %d", i, text_of(m->name), m->spread,
                        b->spread_count);
        // Entry 0 is "none", also where there are no entries.
        if (!index_good(m->texture, b->texture_count + (b->texture_count == 0)) ||
            !index_good(m->texture_map, b->texture_map_count + (b->texture_map_count == 0))) {
            check_fault(c, "material %d (%s): texture %d of %d, map %d of %d", i, text_of(m->name),
                        m->texture, b->texture_count, m->texture_map, b->texture_map_count);
        }
    }
    for (int i = 1; i < b->texture_count; i++) {
        const Texture *t = &b->textures[i];
        check_rgb(c, "mean of texture", i, t->mean, MAPS_MAX_COLOUR);
        if (t->width < 1 || t->height < 1 || !t->texels)
            check_fault(c, "texture %d (%s): %d x %d texels", i, text_of(t->name), t->width, t->height);
    }
    for (int i = 1; i < b->texture_map_count; i++) {
        const TextureMap *t = &b->texture_maps[i];
        if (!good3(t->u) || !good3(t->v) || !isfinite(t->u0) || !isfinite(t->v0))
            check_fault(c, "texture map %d: (%g, %g, %g) and (%g, %g, %g), %g, %g (finite, within %g)", i,
                        t->u.x, t->u.y, t->u.z, t->v.x, t->v.y, t->v.z, t->u0, t->v0, MAPS_LIMIT);
    }
    for (int i = 0; i < b->storey_count; i++) {
        const Storey *s = &b->storeys[i];
        if (!good(s->floor) || !good(s->height) || !good(s->slab) || s->height <= 0 || s->slab < 0) {
            check_fault(
                c,
                "storey %d (%s): floor %g m, height %g m, slab %g m (floor finite, height above 0, slab at "
                "least 0)",
                i, text_of(s->name), s->floor, s->height, s->slab);
        }
    }
}

static void check_polygon(Check *c, int i) {
    const Building *b = c->b;
    const Polygon *p = &b->polygons[i];
    if (p->vertex_count < 3 || !run_good(p->first_vertex, p->vertex_count, b->vertex_count)) {
        check_fault(c, "polygon %d: vertices %d to %d of %d (at least 3, all there)", i, p->first_vertex,
                    p->first_vertex + p->vertex_count - 1, b->vertex_count);
        return;
    }
    const Vec3 *v = &b->vertices[p->first_vertex];
    if (!index_good(p->material, b->material_count)) {
        check_fault(c, "polygon %d: material %d (allowed 0 to %d)", i, p->material, b->material_count - 1);
    }
    if (!index_good(p->texture_map, b->texture_map_count + (b->texture_map_count == 0)))
        check_fault(c, "polygon %d: texture map %d of %d", i, p->texture_map, b->texture_map_count);
    for (int k = 0; k < p->vertex_count; k++) {
        if (good3(v[k])) continue;
        check_fault(c, "polygon %d: vertex %d at (%g, %g, %g) (finite, within %g m)", i, k, v[k].x, v[k].y,
                    v[k].z, MAPS_LIMIT);
        return;
    }
    Plane plane = plane_of_polygon(v, p->vertex_count);
    double off = polygon_bend(v, p->vertex_count, plane);
    if (polygon_area(v, p->vertex_count) <= MAPS_SMALLEST_AREA / 2) {
        check_fault(c, "polygon %d at (%.3f, %.3f, %.3f): no area", i, v[0].x, v[0].y, v[0].z);
    } else if (off > MAPS_PLANARITY) {
        check_fault(c, "polygon %d at (%.3f, %.3f, %.3f): bends by %.4f m (limit %g)", i, v[0].x, v[0].y,
                    v[0].z, off, MAPS_PLANARITY);
    } else if (!polygon_is_convex(v, p->vertex_count, plane.n)) {
        check_fault(c, "polygon %d at (%.3f, %.3f, %.3f): not convex", i, v[0].x, v[0].y, v[0].z);
    }
}

static void check_objects(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->polygon_count; i++) check_polygon(c, i);
    for (int i = 0; i < b->object_count; i++) {
        const Object *o = &b->objects[i];
        if (!run_good(o->first_polygon, o->polygon_count, b->polygon_count)) {
            check_fault(c, "object %d (%s): polygons %d to %d of %d", i, text_of(o->name), o->first_polygon,
                        o->first_polygon + o->polygon_count - 1, b->polygon_count);
        }
        if ((o->plug || o->opening != -1) && !index_good(o->opening, b->opening_count)) {
            check_fault(c, "object %d (%s): opening %d (allowed 0 to %d)", i, text_of(o->name), o->opening,
                        b->opening_count - 1);
        }
        if (o->leaf != -1 && !index_good(o->leaf, b->leaf_count)) {
            check_fault(c, "object %d (%s): leaf %d (allowed 0 to %d)", i, text_of(o->name), o->leaf,
                        b->leaf_count - 1);
        }
        if (!o->proxy) continue;
        bool sound = good(o->proxy->z0) && good(o->proxy->z1) && o->proxy->z0 < o->proxy->z1;
        for (int k = 0; k < 4; k++)
            sound = sound && good(o->proxy->corner[k].x) && good(o->proxy->corner[k].y);
        if (!sound) {
            check_fault(c, "object %d (%s): its proxy is not finite or reaches from %g up to %g", i,
                        text_of(o->name), o->proxy->z0, o->proxy->z1);
        }
    }
}

static void check_inlays(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->inlay_count; i++) {
        const Inlay *in = &b->inlays[i];
        if (in->point_count < 3 || !run_good(in->first_point, in->point_count, b->point_count)) {
            check_fault(c, "inlay %d: points %d to %d of %d (at least 3, all there)", i, in->first_point,
                        in->first_point + in->point_count - 1, b->point_count);
            continue;
        }
        if (!index_good(in->material, b->material_count) || !good(in->z)) {
            check_fault(c, "inlay %d: material %d of %d, height %g m", i, in->material, b->material_count,
                        in->z);
        }
        const Vec2 *p = &b->points[in->first_point];
        for (int k = 0; k < in->point_count; k++) {
            Vec2 q = p[(k + 1) % in->point_count], r = p[(k + 2) % in->point_count];
            if (orient2d(p[k], q, r) < 0) {
                check_fault(c, "inlay %d at (%.3f, %.3f): not convex or not counter-clockwise", i, q.x, q.y);
                break;
            }
        }
    }
}

static void check_lights_and_views(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->light_count; i++) {
        const Light *l = &b->lights[i];
        if (!good3(l->position) || !(l->radius >= 0) || !good(l->radius)) {
            check_fault(c, "light %d (%s): at (%g, %g, %g), radius %g m (finite, at least 0)", i,
                        text_of(l->name), l->position.x, l->position.y, l->position.z, l->radius);
        }
        check_rgb(c, "flux of light", i, l->flux, 1e30f);
        if (l->object != -1 && !index_good(l->object, b->object_count)) {
            check_fault(c, "light %d (%s): object %d of %d", i, text_of(l->name), l->object, b->object_count);
        }
        if (!index_good(l->photometry, b->photometry_count + (b->photometry_count == 0)) || !good(l->turn))
            check_fault(c, "light %d (%s): table %d of %d, turned by %g", i, text_of(l->name), l->photometry,
                        b->photometry_count, l->turn);
    }
    for (int i = 0; i < b->viewpoint_count + b->tour_point_count; i++) {
        bool stored = i < b->viewpoint_count;
        const Viewpoint *v = stored ? &b->viewpoints[i] : &b->tour_points[i - b->viewpoint_count];
        if (good3(v->eye) && good(v->yaw) && good(v->pitch) && v->fov > 0 && v->fov < M_PI) continue;
        check_fault(
            c,
            "%s %d (%s): eye (%g, %g, %g), yaw %g, pitch %g, field of view %g (finite; view between 0 and "
            "pi)",
            stored ? "viewpoint" : "tour point", stored ? i : i - b->viewpoint_count, text_of(v->name),
            v->eye.x, v->eye.y, v->eye.z, v->yaw, v->pitch, v->fov);
    }
    for (int i = 0; i < b->tour_count; i++) {
        const Tour *t = &b->tours[i];
        if (!run_good(t->first_viewpoint, t->viewpoint_count, b->tour_point_count)) {
            check_fault(c, "tour %d (%s): viewpoints %d to %d of %d", i, text_of(t->name), t->first_viewpoint,
                        t->first_viewpoint + t->viewpoint_count - 1, b->tour_point_count);
        }
    }
    for (int i = 0; i < b->note_count; i++) {
        const Note *n = &b->notes[i];
        if (!n->text || !run_good(n->first_point, n->point_count, b->point_count)) {
            check_fault(c, "note %d: no text, or its path lies outside the points", i);
        }
    }
}

static void check_openings(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        const char *name = text_of(o->name);
        if (o->kind < 0 || o->kind >= OPENING_KINDS)
            check_fault(c, "opening %d (%s): kind %d", i, name, (int)o->kind);
        if (b->form != FORM_SOUP && !index_good(o->storey, b->storey_count)) {
            check_fault(c, "opening %d (%s): storey %d of %d", i, name, o->storey, b->storey_count);
        }
        if (!good(o->line[0].x) || !good(o->line[0].y) || !good(o->line[1].x) || !good(o->line[1].y)) {
            check_fault(c, "opening %d (%s): its line is not finite", i, name);
        } else if (vec2_equal(o->line[0], o->line[1])) {
            check_fault(c, "opening %d (%s) at (%.3f, %.3f): it has no width", i, name, o->line[0].x,
                        o->line[0].y);
        }
        if (!good(o->sill) || !good(o->head) || o->sill >= o->head) {
            check_fault(c, "opening %d (%s): sill %g m, head %g m (sill below head)", i, name, o->sill,
                        o->head);
        }
        if (!(o->open >= 0 && o->open <= 1))
            check_fault(c, "opening %d (%s): open by %g (allowed 0 to 1)", i, name, o->open);
        if (!run_good(o->first_leaf, o->leaf_count, b->leaf_count)) {
            check_fault(c, "opening %d (%s): leaves %d to %d of %d", i, name, o->first_leaf,
                        o->first_leaf + o->leaf_count - 1, b->leaf_count);
        }
        if (!index_good(o->material, b->material_count)) {
            check_fault(c, "opening %d (%s): material %d of %d", i, name, o->material, b->material_count);
        }
        for (int s = 0; s < 2; s++) {
            if (o->region[s] != -1 && !index_good(o->region[s], b->region_count)) {
                check_fault(c, "opening %d (%s): region %d of %d", i, name, o->region[s], b->region_count);
            }
        }
        if (b->form != FORM_SOUP && (o->region[0] == -1 || o->region[1] == -1) && !o->reason) {
            check_fault(c, "opening %d (%s) at (%.3f, %.3f): leads nowhere without a reason", i, name,
                        o->line[0].x, o->line[0].y);
        }
    }
}

static void check_leaves(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->leaf_count; i++) {
        const Leaf *l = &b->leaves[i];
        double numbers[] = {l->pivot.x,   l->pivot.y,   l->turn,      l->slide.x,   l->slide.y,
                            l->rise,      l->axis[0].x, l->axis[0].y, l->axis[1].x, l->axis[1].y,
                            l->thickness, l->z0,        l->z1};
        bool finite = true;
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) finite = finite && good(numbers[k]);
        if (!finite || l->thickness <= 0 || l->z0 >= l->z1 || vec2_equal(l->axis[0], l->axis[1]))
            check_fault(c, "leaf %d at (%.3f, %.3f): it is not finite or has no size", i, l->pivot.x,
                        l->pivot.y);
        bool corners = l->corner_count == 0 || (l->corner_count >= 3 && l->corner_count <= LEAF_CORNERS &&
                                                run_good(l->first_corner, l->corner_count, b->point_count));
        if (!corners)
            check_fault(c, "leaf %d: corners %d to %d of %d points (none, or 3 to %d)", i, l->first_corner,
                        l->first_corner + l->corner_count - 1, b->point_count, LEAF_CORNERS);
        if (!index_good(l->opening, b->opening_count))
            check_fault(c, "leaf %d: opening %d of %d", i, l->opening, b->opening_count);
    }
}

static void check_world(Check *c) {
    const Building *b = c->b;
    bool sound = good3(b->world.min) && good3(b->world.max);
    for (int i = 0; sound && i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->z0 < b->world.min.z || r->z1 > b->world.max.z) {
            check_fault(c, "region %d (%s): heights %g to %g m leave the world (%g to %g m)", i,
                        text_of(r->name), r->z0, r->z1, b->world.min.z, b->world.max.z);
        }
    }
    if (!sound) check_fault(c, "the world's box is not finite");
    if (!good3(b->start) || !good(b->start_yaw)) {
        check_fault(c, "the start (%g, %g, %g) is not finite", b->start.x, b->start.y, b->start.z);
    }
}

// ---- curved shapes, and materials where rays are traced

// Cosine between axes of a frame that counts as square: rounding of a turn, many times over.
static const double SQUARE = 1e-9;
static const double MOST_INDEX = 4;  // of refraction

static void check_optics(Check *c) {
    for (int i = 0; i < c->b->material_count; i++) {
        const Material *m = &c->b->materials[i];
        float most = fmaxf(m->reflectance.r, fmaxf(m->reflectance.g, m->reflectance.b));
        if (!(m->mirror >= 0 && m->mirror + most <= 1.00001f))
            check_fault(c, "material %d (%s): mirror %g beside a reflectance of %g (together 0 to 1)", i,
                        text_of(m->name), (double)m->mirror, (double)most);
        if (!(m->gloss >= 0 && m->gloss <= 1))
            check_fault(c, "material %d (%s): gloss %g (0 to 1)", i, text_of(m->name), (double)m->gloss);
        if (m->index != 0 && !(m->index >= 1 && (double)m->index <= MOST_INDEX))
            check_fault(c, "material %d (%s): index of refraction %g (0, or 1 to %g)", i, text_of(m->name),
                        (double)m->index, MOST_INDEX);
    }
}

static void check_frame(Check *c, int i) {
    const CurvedFrame *f = &c->b->shapes[i].frame;
    bool sound = good3(f->origin);
    for (int k = 0; k < 3 && sound; k++) {
        Vec3 a = f->axis[k], b = f->axis[(k + 1) % 3];
        double lengths = vec3_length(a) * vec3_length(b);
        sound = good3(a) && lengths > 0 && fabs(vec3_dot(a, b)) <= SQUARE * lengths;
    }
    if (!sound) check_fault(c, "curved shape %d: its axes are not perpendicular, or one has no length", i);
}

static void check_patch(Check *c, int i) {
    const Building *b = c->b;
    const CurvedShape *s = &b->shapes[i];
    if (!run_good(s->first_control, PATCH_CONTROLS, b->control_count) ||
        !run_good(s->first_trim, s->trim_count, b->trim_count)) {
        check_fault(c, "curved shape %d: controls from %d of %d, trims from %d of %d", i, s->first_control,
                    b->control_count, s->first_trim, b->trim_count);
        return;
    }
    for (int k = 0; k < PATCH_CONTROLS; k++) {
        const CurvedControl *control = &b->controls[s->first_control + k];
        if (!good3(control->point) || !(control->weight > 0) || !good(control->weight))
            check_fault(c, "curved shape %d: control %d at (%g, %g, %g), weight %g (finite, above 0)", i, k,
                        control->point.x, control->point.y, control->point.z, control->weight);
    }
    for (int k = 0; k < s->trim_count; k++) {
        const CurvedTrim *t = &b->trims[s->first_trim + k];
        for (int p = 0; p < 4; p++) {
            Vec2 at = t->point[p];
            bool inside = at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1;
            if (!inside || !(t->weight[p] > 0) || !good(t->weight[p]))
                check_fault(c,
                            "curved shape %d: point %d of trim %d is (%g, %g), weight %g (0 to 1, above 0)",
                            i, p, k, at.x, at.y, t->weight[p]);
        }
    }
}

static void check_balls(Check *c, int i) {
    const Building *b = c->b;
    const CurvedShape *s = &b->shapes[i];
    if (s->ball_count < 1 || !run_good(s->first_ball, s->ball_count, b->ball_count) || !(s->threshold > 0)) {
        check_fault(c, "curved shape %d: balls %d to %d of %d (at least 1), threshold %g (above 0)", i,
                    s->first_ball, s->first_ball + s->ball_count - 1, b->ball_count, s->threshold);
        return;
    }
    for (int k = 0; k < s->ball_count; k++) {
        const CurvedBall *ball = &b->balls[s->first_ball + k];
        if (!good3(ball->centre) || !(ball->radius > 0) || !good(ball->radius) || !good(ball->weight))
            check_fault(c, "curved shape %d: ball %d has radius %g, weight %g (finite, a radius above 0)", i,
                        k, ball->radius, ball->weight);
    }
}

static void check_curved(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->shape_count; i++) {
        const CurvedShape *s = &b->shapes[i];
        if (s->kind < 0 || s->kind >= CURVED_KINDS) {
            check_fault(c, "curved shape %d: kind %d (allowed 0 to %d)", i, (int)s->kind, CURVED_KINDS - 1);
            continue;
        }
        bool held = index_good(s->object, b->object_count) &&
                    run_good(s->first_polygon, s->polygon_count, b->polygon_count);
        if (held) {
            const Object *o = &b->objects[s->object];
            held = s->first_polygon >= o->first_polygon &&
                   s->first_polygon + s->polygon_count <= o->first_polygon + o->polygon_count;
        }
        if (!held || !index_good(s->material, b->material_count))
            check_fault(c, "curved shape %d: polygons %d to %d, not all of object %d; material %d of %d", i,
                        s->first_polygon, s->first_polygon + s->polygon_count - 1, s->object, s->material,
                        b->material_count);
        if (!(s->tolerance > 0 && good(s->tolerance)) || !(s->top >= 0 && s->top <= 1))
            check_fault(c, "curved shape %d: tolerance %g m (above 0), top %g (0 to 1)", i, s->tolerance,
                        s->top);
        if (s->kind == CURVED_PATCH) {
            check_patch(c, i);
        } else if (s->kind == CURVED_METABALLS) {
            check_balls(c, i);
        } else {
            check_frame(c, i);
        }
    }
}

int building_check(const Building *b, Arena *arena, const char **faults, int max) {
    Arena scratch = {0};
    Check c = {.b = b, .arena = arena, .scratch = &scratch, .faults = faults, .max = max};
    check_form(&c);
    check_bands(&c);
    check_materials_and_storeys(&c);
    check_optics(&c);
    check_regions(&c);
    check_openings(&c);
    check_leaves(&c);
    check_objects(&c);
    check_curved(&c);
    check_inlays(&c);
    check_lights_and_views(&c);
    check_world(&c);
    arena_free(&scratch);
    return c.count;
}
