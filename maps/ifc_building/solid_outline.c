// solid_outline.c - what a solid body covers of the plan between two heights: the union of its faces as seen from above, cut off at
// both heights, and of its sections there. GEOS joins them on a grid of a tenth of a millimetre.
//
// A section is found from the lines in which faces meet the level plane: they are made a planar graph, and of its cells those count
// whose inner point is inside an odd number of the lines' loops.
#include "maps/ifc_building/solid_outline.h"

#define GEOS_USE_ONLY_R_API
#include <geos_c.h>
#include <math.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/core/polygon.h"

// Metres: a tenth of the grid of plans, coarser than the noise of placements that were multiplied.
static const double GRID = 1e-4;
// Corners that lie this near to the line between their neighbours are left out, metres: below the grid of plans.
static const double STRAIGHT = 2e-4;
// A face counts as seen from above where its projection has this share of its own area at least, else it is upright.
static const double UPRIGHT = 1e-6;

struct SolidTracer {
    Arena *arena;
    GEOSContextHandle_t geos;
    Vec3 *corners;
    int *first;  // [count + 1] of each polygon's corners
    int corner_count, corner_capacity, count, first_capacity;
};

static void on_error(const char *message, void *context) {
    (void)context;
    if (strcmp(message, "std::bad_alloc") == 0) memory_end_library("GEOS");
}

SolidTracer *solid_begin(Arena *arena) {
    SolidTracer *t = ARENA_ARRAY(arena, SolidTracer, 1);
    t->arena = arena;
    t->geos = GEOS_init_r();
    GEOSContext_setErrorMessageHandler_r(t->geos, on_error, NULL);
    return t;
}

void solid_end(SolidTracer *tracer) { GEOS_finish_r(tracer->geos); }

void solid_add(SolidTracer *t, const Vec3 *corners, int count) {
    if (count < 3) return;
    *ARENA_PUSH(t->arena, t->first, t->count, t->first_capacity) = t->corner_count;
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(t->arena, t->corners, t->corner_count, t->corner_capacity) = corners[i];
}

// ---- to and from GEOS

typedef struct Pieces {
    GEOSGeometry **items;
    int count, capacity;
} Pieces;

static void collect(SolidTracer *t, Pieces *pieces, GEOSGeometry *g) {
    if (g) *ARENA_PUSH(t->arena, pieces->items, pieces->count, pieces->capacity) = g;
}

static GEOSCoordSequence *sequence(const SolidTracer *t, const Vec2 *points, int count, bool close) {
    GEOSCoordSequence *s = GEOSCoordSeq_create_r(t->geos, (unsigned)(count + close), 2);
    for (int i = 0; s && i < count + close; i++)
        GEOSCoordSeq_setXY_r(t->geos, s, (unsigned)i, points[i % count].x, points[i % count].y);
    return s;
}

static GEOSGeometry *made_valid(const SolidTracer *t, GEOSGeometry *g) {
    if (!g || GEOSisValid_r(t->geos, g) == 1) return g;
    GEOSGeometry *valid = GEOSMakeValid_r(t->geos, g);
    GEOSGeom_destroy_r(t->geos, g);
    return valid;
}

static GEOSGeometry *polygon_of(const SolidTracer *t, const SolidOutline *o) {
    GEOSGeometry **holes = ARENA_ARRAY(t->arena, GEOSGeometry *, o->ring_count);
    GEOSGeometry *outer = NULL;
    for (int r = 0; r < o->ring_count; r++) {
        int first = o->ring[r], count = o->ring[r + 1] - first;
        GEOSGeometry *ring =
            GEOSGeom_createLinearRing_r(t->geos, sequence(t, o->points + first, count, true));
        if (!ring) {
            for (int k = 0; k + 1 < r; k++) GEOSGeom_destroy_r(t->geos, holes[k]);
            if (outer) GEOSGeom_destroy_r(t->geos, outer);
            return NULL;
        }
        if (r == 0)
            outer = ring;
        else
            holes[r - 1] = ring;
    }
    if (!outer) return NULL;
    return made_valid(t, GEOSGeom_createPolygon_r(t->geos, outer, holes, (unsigned)(o->ring_count - 1)));
}

// The union of all pieces on the grid; takes them over. NULL where there is none.
static GEOSGeometry *unite(const SolidTracer *t, Pieces *pieces) {
    if (pieces->count == 0) return NULL;
    GEOSGeometry *all =
        GEOSGeom_createCollection_r(t->geos, GEOS_GEOMETRYCOLLECTION, pieces->items, (unsigned)pieces->count);
    GEOSGeometry *joined = all ? GEOSUnaryUnionPrec_r(t->geos, all, GRID) : NULL;
    if (all) GEOSGeom_destroy_r(t->geos, all);
    return joined;
}

static int ring_points(const SolidTracer *t, const GEOSGeometry *ring, Vec2 *out) {
    const GEOSCoordSequence *s = GEOSGeom_getCoordSeq_r(t->geos, ring);
    unsigned size = 0;
    GEOSCoordSeq_getSize_r(t->geos, s, &size);
    int count = size > 0 ? (int)size - 1 : 0;  // the last repeats the first
    for (int i = 0; out && i < count; i++)
        GEOSCoordSeq_getXY_r(t->geos, s, (unsigned)i, &out[i].x, &out[i].y);
    return count;
}

static double signed_area(const Vec2 *p, int count) {
    double twice = 0;
    for (int i = 1; i + 1 < count; i++) twice += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0]));
    return twice / 2;
}

static void take_polygon(const SolidTracer *t, const GEOSGeometry *g, SolidOutlines *out) {
    int holes = GEOSGetNumInteriorRings_r(t->geos, g), total = 0;
    SolidOutline o = {.ring = ARENA_ARRAY(t->arena, int, holes + 2), .ring_count = holes + 1};
    GEOSArea_r(t->geos, g, &o.area);
    for (int r = 0; r <= holes; r++)
        total += ring_points(
            t, r ? GEOSGetInteriorRingN_r(t->geos, g, r - 1) : GEOSGetExteriorRing_r(t->geos, g), NULL);
    o.points = ARENA_ARRAY(t->arena, Vec2, total);
    for (int r = 0; r <= holes; r++) {
        Vec2 *ring = o.points + o.ring[r];
        int count = ring_points(
            t, r ? GEOSGetInteriorRingN_r(t->geos, g, r - 1) : GEOSGetExteriorRing_r(t->geos, g), ring);
        o.ring[r + 1] = o.ring[r] + count;
        if ((signed_area(ring, count) > 0) == (r == 0)) continue;
        for (int i = 0; i < count / 2; i++) {
            Vec2 swap = ring[i];
            ring[i] = ring[count - 1 - i];
            ring[count - 1 - i] = swap;
        }
    }
    *ARENA_PUSH(t->arena, out->items, out->count, out->capacity) = o;
}

// Appends the polygons of a geometry whose mean width is more than `narrowest`, metres.
static void gather_outlines(const SolidTracer *t, const GEOSGeometry *g, double narrowest,
                            SolidOutlines *out) {
    int type = GEOSGeomTypeId_r(t->geos, g);
    if (type == GEOS_MULTIPOLYGON || type == GEOS_GEOMETRYCOLLECTION)
        for (int i = 0; i < GEOSGetNumGeometries_r(t->geos, g); i++)
            gather_outlines(t, GEOSGetGeometryN_r(t->geos, g, i), narrowest, out);
    if (type != GEOS_POLYGON || GEOSisEmpty_r(t->geos, g)) return;
    double area = 0, perimeter = 0;
    GEOSArea_r(t->geos, g, &area);
    GEOSLength_r(t->geos, g, &perimeter);
    if (area >= SOLID_LEAST_AREA && 2 * area > narrowest * perimeter) take_polygon(t, g, out);
}

// Reads and destroys.
static SolidOutlines take(const SolidTracer *t, GEOSGeometry *g, double narrowest) {
    SolidOutlines out = {NULL, 0, 0};
    if (!g) return out;
    GEOSGeometry *simple = GEOSTopologyPreserveSimplify_r(t->geos, g, STRAIGHT);
    gather_outlines(t, simple ? simple : g, narrowest, &out);
    if (simple) GEOSGeom_destroy_r(t->geos, simple);
    GEOSGeom_destroy_r(t->geos, g);
    return out;
}

// ---- cover

// The place where an edge meets a height, the same from either end.
static Vec2 meet(Vec3 a, Vec3 b, double z) {
    if (a.z > b.z) {
        Vec3 swap = a;
        a = b;
        b = swap;
    }
    double share = (z - a.z) / (b.z - a.z);
    return vec2(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y));
}

typedef struct Segment {
    Vec2 a, b;
} Segment;

// A corner at the height counts as above it, so that lines of a closed body form loops.
static int cut_faces(SolidTracer *t, double z, Segment *out) {
    int count = 0;
    for (int f = 0; f < t->count; f++) {
        int first = t->first[f], n = (f + 1 < t->count ? t->first[f + 1] : t->corner_count) - first, ends = 0;
        Vec2 end[2];
        for (int i = 0; i < n && ends < 2; i++) {
            Vec3 a = t->corners[first + i], b = t->corners[first + (i + 1) % n];
            if ((a.z >= z) != (b.z >= z)) end[ends++] = meet(a, b, z);
        }
        if (ends == 2) out[count++] = (Segment){end[0], end[1]};
    }
    return count;
}

static bool inside_loops(const Segment *segments, int count, Vec2 p) {
    bool inside = false;
    for (int i = 0; i < count; i++)
        inside ^= ring_edge_is_crossed(segments[i].a, segments[i].b, p, RING_DIVIDE_FIRST);
    return inside;
}

static void add_section(SolidTracer *t, double z, Pieces *pieces) {
    Segment *segments = ARENA_ARRAY(t->arena, Segment, t->count);
    int count = cut_faces(t, z, segments);
    Pieces lines = {NULL, 0, 0};
    for (int i = 0; i < count; i++) {
        Vec2 ends[2] = {segments[i].a, segments[i].b};
        if (!vec2_equal(ends[0], ends[1]))
            collect(t, &lines, GEOSGeom_createLineString_r(t->geos, sequence(t, ends, 2, false)));
    }
    GEOSGeometry *noded = unite(t, &lines);
    const GEOSGeometry *list[1] = {noded};
    GEOSGeometry *cells = noded ? GEOSPolygonize_r(t->geos, list, 1) : NULL;
    for (int i = 0; cells && i < GEOSGetNumGeometries_r(t->geos, cells); i++) {
        const GEOSGeometry *cell = GEOSGetGeometryN_r(t->geos, cells, i);
        GEOSGeometry *point = GEOSPointOnSurface_r(t->geos, cell);
        Vec2 p = {NAN, NAN};
        if (point && !GEOSisEmpty_r(t->geos, point)) {
            GEOSGeomGetX_r(t->geos, point, &p.x);
            GEOSGeomGetY_r(t->geos, point, &p.y);
        }
        if (point) GEOSGeom_destroy_r(t->geos, point);
        if (inside_loops(segments, count, p)) collect(t, pieces, GEOSGeom_clone_r(t->geos, cell));
    }
    if (cells) GEOSGeom_destroy_r(t->geos, cells);
    if (noded) GEOSGeom_destroy_r(t->geos, noded);
}

static void project_faces(SolidTracer *t, double z0, double z1, Pieces *pieces) {
    for (int f = 0; f < t->count; f++) {
        int first = t->first[f], n = (f + 1 < t->count ? t->first[f + 1] : t->corner_count) - first;
        Vec3 *low = ARENA_ARRAY(t->arena, Vec3, n + 2), *both = ARENA_ARRAY(t->arena, Vec3, n + 2);
        int kept = polygon_clip(t->corners + first, n, (Plane){{0, 0, 1}, z0}, 0, low);
        kept = kept ? polygon_clip(low, kept, (Plane){{0, 0, -1}, -z1}, 0, both) : 0;
        if (kept < 3) continue;
        Vec2 *plan = ARENA_ARRAY(t->arena, Vec2, kept);
        Vec3 normal = vec3(0, 0, 0);
        for (int i = 0; i < kept; i++) plan[i] = vec2(both[i].x, both[i].y);
        for (int i = 1; i + 1 < kept; i++)
            normal = vec3_add(normal, vec3_cross(vec3_sub(both[i], both[0]), vec3_sub(both[i + 1], both[0])));
        double area = fabs(signed_area(plan, kept));
        if (area <= UPRIGHT * vec3_length(normal) || area < GRID * GRID) continue;
        SolidOutline o = solid_of_ring(t->arena, plan, kept);
        collect(t, pieces, polygon_of(t, &o));
    }
}

SolidOutlines solid_cover(SolidTracer *t, double z0, double z1) {
    Pieces pieces = {NULL, 0, 0};
    add_section(t, z0, &pieces);
    add_section(t, z1, &pieces);
    project_faces(t, z0, z1, &pieces);
    t->count = t->corner_count = 0;
    return take(t, unite(t, &pieces), GRID);
}

// ---- operations

static GEOSGeometry *all_of(SolidTracer *t, const SolidOutlines *a) {
    Pieces pieces = {NULL, 0, 0};
    for (int i = 0; i < a->count; i++) collect(t, &pieces, polygon_of(t, &a->items[i]));
    return unite(t, &pieces);
}

SolidOutlines solid_union(SolidTracer *t, const SolidOutlines *a) { return take(t, all_of(t, a), GRID); }

SolidOutlines solid_difference(SolidTracer *t, const SolidOutlines *a, const SolidOutlines *b,
                               double narrowest) {
    GEOSGeometry *from = all_of(t, a), *without = all_of(t, b);
    if (!from || !without) {
        if (without) GEOSGeom_destroy_r(t->geos, without);
        return take(t, from, narrowest);
    }
    GEOSGeometry *rest = GEOSDifferencePrec_r(t->geos, from, without, GRID);
    GEOSGeom_destroy_r(t->geos, from);
    GEOSGeom_destroy_r(t->geos, without);
    return take(t, rest, narrowest);
}

double solid_common_area(SolidTracer *t, const SolidOutlines *a, const SolidOutlines *b) {
    GEOSGeometry *p = all_of(t, a), *q = all_of(t, b);
    GEOSGeometry *both = p && q ? GEOSIntersectionPrec_r(t->geos, p, q, GRID) : NULL;
    double area = 0;
    if (both) GEOSArea_r(t->geos, both, &area);
    if (p) GEOSGeom_destroy_r(t->geos, p);
    if (q) GEOSGeom_destroy_r(t->geos, q);
    if (both) GEOSGeom_destroy_r(t->geos, both);
    return area;
}

SolidOutline solid_of_ring(Arena *arena, const Vec2 *points, int count) {
    SolidOutline o = {ARENA_ARRAY(arena, Vec2, count), ARENA_ARRAY(arena, int, 2), 1, 0};
    double area = signed_area(points, count);
    for (int i = 0; i < count; i++) o.points[i] = points[area < 0 ? count - 1 - i : i];
    o.ring[1] = count;
    o.area = fabs(area);
    return o;
}

bool solid_contains(const SolidOutline *o, Vec2 p) {
    bool inside = false;
    for (int r = 0; r < o->ring_count; r++)
        inside ^= ring_contains(o->points + o->ring[r], o->ring[r + 1] - o->ring[r], p);
    return inside;
}

// The line to a hole joins the hole's leftmost corner to the nearest corner that stands before it; holes are taken from the left, so
// that no line crosses another one.
int solid_one_ring(const SolidOutline *o, Arena *arena, Vec2 **out) {
    int count = o->ring[1], total = o->ring[o->ring_count] + 2 * (o->ring_count - 1);
    Vec2 *ring = ARENA_ARRAY(arena, Vec2, total);
    bool *done = ARENA_ARRAY(arena, bool, o->ring_count);
    memcpy(ring, o->points, (size_t)count * sizeof *ring);
    for (int turn = 1; turn < o->ring_count; turn++) {
        int hole = -1, left = -1;
        for (int r = 1; r < o->ring_count; r++)
            for (int i = o->ring[r]; !done[r] && i < o->ring[r + 1]; i++)
                if (left < 0 || o->points[i].x < o->points[left].x) hole = r, left = i;
        if (hole < 0) break;
        done[hole] = true;
        int at = 0, size = o->ring[hole + 1] - o->ring[hole];
        double nearest = INFINITY;
        for (int i = 0; i < count; i++) {
            double d = vec2_length(vec2_sub(ring[i], o->points[left]));
            if (ring[i].x <= o->points[left].x && d < nearest) at = i, nearest = d;
        }
        Vec2 bridge = ring[at];
        memmove(ring + at + size + 3, ring + at + 1, (size_t)(count - at - 1) * sizeof *ring);
        for (int i = 0; i <= size; i++)
            ring[at + 1 + i] = o->points[o->ring[hole] + (left - o->ring[hole] + i) % size];
        ring[at + size + 2] = bridge;
        count += size + 2;
    }
    *out = ring;
    return count;
}
