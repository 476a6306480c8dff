// convex.c - convex decomposition of a plan polygon.
//
// A constrained Delaunay triangulation (GEOS), whose diagonals are then taken away, longest first, while both of
// their ends stay convex (Hertel & Mehlhorn 1983: at most four times the fewest pieces possible). Signs are exact:
// points on the grid are taken in whole millimetres, where a node on a slanted wall is collinear with its ends.
#include "visibility/cells/convex.h"

#include <geos_c.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// In this object, so that no library is needed for it.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "engine/core/memory.h"
#include "maps/building/building.h"

// GEOS takes the square of their number, and fails at some of so many.
enum { MOST_RINGS = 1000, MOST_POINTS = 8000 };

typedef struct HalfEdge {
    int from;        // vertex
    int next, prev;  // of its piece
    int twin;        // -1 on the boundary
    bool removed;
} HalfEdge;

typedef struct HalfEdges {
    HalfEdge *edges;
    int count;
} HalfEdges;

typedef struct Triangulator {
    GEOSContextHandle_t geos;
    const Vec2 *points;
    const int *ring_first, *ring_size;
    int ring_count;
    Vec2 origin;  // subtracted for GEOS: far from the origin its in-circle tests lose digits
} Triangulator;

static Vec2 millimetres(Vec2 p) { return vec2(nearbyint(p.x / MAPS_GRID), nearbyint(p.y / MAPS_GRID)); }

static Vec2 local(const Triangulator *t, int point) {
    return vec2_sub(millimetres(t->points[point]), t->origin);
}

static int orient(const Vec2 *points, int a, int b, int c) {
    return orient2d(millimetres(points[a]), millimetres(points[b]), millimetres(points[c]));
}

static void silent(const char *message, void *context) {
    (void)context;
    if (strcmp(message, "std::bad_alloc") == 0) memory_end_library("GEOS");
}

static GEOSGeometry *ring_geometry(const Triangulator *t, int ring) {
    int first = t->ring_first[ring], size = t->ring_size[ring];
    GEOSCoordSequence *sequence = GEOSCoordSeq_create_r(t->geos, (unsigned)size + 1, 2);
    if (!sequence) return NULL;
    for (int i = 0; i <= size; i++) {
        Vec2 p = local(t, first + i % size);
        GEOSCoordSeq_setXY_r(t->geos, sequence, (unsigned)i, p.x, p.y);
    }
    return GEOSGeom_createLinearRing_r(t->geos, sequence);
}

static GEOSGeometry *polygon_geometry(const Triangulator *t, Arena *scratch) {
    GEOSGeometry **holes = ARENA_ARRAY(scratch, GEOSGeometry *, t->ring_count);
    for (int r = 0; r < t->ring_count; r++) {
        holes[r] = ring_geometry(t, r);
        if (!holes[r]) {
            while (r-- > 0) GEOSGeom_destroy_r(t->geos, holes[r]);
            return NULL;
        }
    }
    return GEOSGeom_createPolygon_r(t->geos, holes[0], holes + 1, (unsigned)t->ring_count - 1);
}

// Open addressing from a coordinate, as GEOS saw it, to the index of the point.
typedef struct PointIndex {
    int *slot;
    size_t mask;
} PointIndex;

static size_t hash_point(Vec2 p) {
    double key[2] = {p.x + 0.0, p.y + 0.0};  // + 0.0 turns -0 into 0
    return (size_t)XXH3_64bits(key, sizeof key);
}

static PointIndex index_points(const Triangulator *t, Arena *scratch) {
    int total = 0;
    for (int r = 0; r < t->ring_count; r++) total += t->ring_size[r];
    size_t size = 16;
    while (size < (size_t)total * 2) size *= 2;
    PointIndex index = {ARENA_ARRAY(scratch, int, size), size - 1};
    for (size_t i = 0; i < size; i++) index.slot[i] = -1;
    for (int r = 0; r < t->ring_count; r++) {
        for (int i = 0; i < t->ring_size[r]; i++) {
            int point = t->ring_first[r] + i;
            size_t s = hash_point(local(t, point)) & index.mask;
            while (index.slot[s] >= 0 && !vec2_equal(t->points[index.slot[s]], t->points[point])) {
                s = (s + 1) & index.mask;
            }
            if (index.slot[s] < 0) index.slot[s] = point;
        }
    }
    return index;
}

static int find_point(const Triangulator *t, const PointIndex *index, Vec2 p) {
    for (size_t s = hash_point(p) & index->mask; index->slot[s] >= 0; s = (s + 1) & index->mask) {
        if (vec2_equal(local(t, index->slot[s]), p)) return index->slot[s];
    }
    return -1;
}

// Reads triangle `part` as three point indices, counter-clockwise.
static bool read_triangle(const Triangulator *t, const PointIndex *index, const GEOSGeometry *part,
                          int corner[3]) {
    const GEOSGeometry *ring = GEOSGetExteriorRing_r(t->geos, part);
    const GEOSCoordSequence *sequence = ring ? GEOSGeom_getCoordSeq_r(t->geos, ring) : NULL;
    if (!sequence) return false;
    for (unsigned i = 0; i < 3; i++) {
        Vec2 p;
        if (!GEOSCoordSeq_getXY_r(t->geos, sequence, i, &p.x, &p.y)) return false;
        corner[i] = find_point(t, index, p);
        if (corner[i] < 0) return false;
    }
    int sign = orient(t->points, corner[0], corner[1], corner[2]);
    if (sign < 0) {
        int swap = corner[1];
        corner[1] = corner[2];
        corner[2] = swap;
    }
    return sign != 0;
}

static void add_half_edges(HalfEdges *half, const int corner[3]) {
    for (int k = 0; k < 3; k++) {
        half->edges[half->count + k] =
            (HalfEdge){corner[k], half->count + (k + 1) % 3, half->count + (k + 2) % 3, -1, false};
    }
    half->count += 3;
}

static bool triangulate(const Triangulator *t, Arena *scratch, HalfEdges *half) {
    GEOSGeometry *polygon = polygon_geometry(t, scratch);
    if (!polygon) return false;
    GEOSGeometry *triangles = GEOSConstrainedDelaunayTriangulation_r(t->geos, polygon);
    GEOSGeom_destroy_r(t->geos, polygon);
    if (!triangles) return false;
    int count = GEOSGetNumGeometries_r(t->geos, triangles);
    PointIndex index = index_points(t, scratch);
    half->edges = ARENA_ARRAY(scratch, HalfEdge, 3 * (size_t)(count > 0 ? count : 1));
    half->count = 0;
    bool good = count > 0;
    for (int i = 0; i < count && good; i++) {
        int corner[3];
        good = read_triangle(t, &index, GEOSGetGeometryN_r(t->geos, triangles, i), corner);
        if (good) add_half_edges(half, corner);
    }
    GEOSGeom_destroy_r(t->geos, triangles);
    return good;
}

// The same by convex_sweep.c: not as fat, but of any number of holes.
static bool triangulate_by_sweep(const Triangulator *t, Arena *scratch, HalfEdges *half) {
    int total = 0;
    for (int r = 0; r < t->ring_count; r++) total += t->ring_size[r];
    Vec2 *at = ARENA_ARRAY(scratch, Vec2, total);
    int(*edges)[2] = arena_alloc(scratch, (size_t)total, sizeof *edges), *triangles;
    for (int r = 0, point = 0; r < t->ring_count; r++) {
        int first = point;
        for (int i = 0; i < t->ring_size[r]; i++, point++) {
            at[point] = local(t, t->ring_first[r] + i);
            edges[point][0] = point;
            edges[point][1] = i + 1 < t->ring_size[r] ? point + 1 : first;
        }
    }
    int count = convex_sweep(at, (const int(*)[2])edges, total, scratch, &triangles);
    PointIndex index = index_points(t, scratch);
    half->edges = ARENA_ARRAY(scratch, HalfEdge, 3 * (size_t)(count > 0 ? count : 1));
    half->count = 0;
    for (int i = 0; i < count; i++) {
        int corner[3];
        for (int k = 0; k < 3; k++) corner[k] = find_point(t, &index, at[triangles[3 * i + k]]);
        add_half_edges(half, corner);
    }
    return count > 0;
}

// Twice, mm^2: in whole millimetres products and sums are exact.
static double triangle_area(const Triangulator *t, int a, int b, int c) {
    Vec2 p = local(t, a);
    return vec2_cross(vec2_sub(local(t, b), p), vec2_sub(local(t, c), p));
}

static double ring_area(const Triangulator *t, int ring) {
    double area = 0;
    int first = t->ring_first[ring];
    for (int i = 1; i + 1 < t->ring_size[ring]; i++)
        area += triangle_area(t, first, first + i, first + i + 1);
    return area;
}

// The triangles must tile the polygon: a triangulation that GEOS got wrong would leave a hole in free space.
static bool tiles(const Triangulator *t, const HalfEdges *half) {
    double whole = 0, sum = 0;
    for (int r = 0; r < t->ring_count; r++) whole += ring_area(t, r);
    for (int e = 0; e < half->count; e += 3) {
        const HalfEdge *corner = half->edges + e;
        sum += triangle_area(t, corner[0].from, corner[1].from, corner[2].from);
    }
    // Nothing is rounded below 1,000 km^2; beyond, far less than this share. The smallest triangle on the grid has 1.
    return fabs(whole - sum) <= 1e-12 * whole + 0.5;
}

typedef struct Diagonal {
    double length;
    int edge;
} Diagonal;

static int by_length(const void *a, const void *b) {
    const Diagonal *p = a, *q = b;
    if (p->length != q->length) return p->length < q->length ? 1 : -1;
    return (p->edge > q->edge) - (p->edge < q->edge);
}

typedef struct EdgeKey {
    int low, high, edge;
} EdgeKey;

static int by_key(const void *a, const void *b) {
    const EdgeKey *p = a, *q = b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    if (p->high != q->high) return p->high < q->high ? -1 : 1;
    return (p->edge > q->edge) - (p->edge < q->edge);
}

static void pair_twins(HalfEdges *half, Arena *scratch) {
    EdgeKey *keys = ARENA_ARRAY(scratch, EdgeKey, half->count);
    for (int e = 0; e < half->count; e++) {
        int a = half->edges[e].from, b = half->edges[half->edges[e].next].from;
        keys[e] = (EdgeKey){a < b ? a : b, a < b ? b : a, e};
    }
    qsort(keys, (size_t)half->count, sizeof *keys, by_key);
    for (int i = 0; i + 1 < half->count; i++) {
        if (keys[i].low != keys[i + 1].low || keys[i].high != keys[i + 1].high) continue;
        half->edges[keys[i].edge].twin = keys[i + 1].edge;
        half->edges[keys[i + 1].edge].twin = keys[i].edge;
        i++;
    }
}

// Would the corner at the start of `e` stay convex without the diagonal e?
static bool corner_stays_convex(const HalfEdges *half, const Vec2 *points, int e) {
    const HalfEdge *edges = half->edges;
    int before = edges[edges[e].prev].from, at = edges[e].from;
    int after = edges[edges[edges[edges[e].twin].next].next].from;
    return orient(points, before, at, after) >= 0;
}

static void remove_diagonal(HalfEdges *half, int e) {
    HalfEdge *edges = half->edges;
    int t = edges[e].twin;
    edges[edges[e].prev].next = edges[t].next;
    edges[edges[t].next].prev = edges[e].prev;
    edges[edges[t].prev].next = edges[e].next;
    edges[edges[e].next].prev = edges[t].prev;
    edges[e].removed = edges[t].removed = true;
}

static void merge(HalfEdges *half, const Vec2 *points, Arena *scratch) {
    pair_twins(half, scratch);
    Diagonal *diagonals = ARENA_ARRAY(scratch, Diagonal, half->count);
    int count = 0;
    for (int e = 0; e < half->count; e++) {
        if (half->edges[e].twin <= e) continue;
        Vec2 a = points[half->edges[e].from], b = points[half->edges[half->edges[e].next].from];
        diagonals[count++] = (Diagonal){vec2_length(vec2_sub(b, a)), e};
    }
    qsort(diagonals, (size_t)count, sizeof *diagonals, by_length);
    for (int i = 0; i < count; i++) {
        int e = diagonals[i].edge;
        if (corner_stays_convex(half, points, e) && corner_stays_convex(half, points, half->edges[e].twin)) {
            remove_diagonal(half, e);
        }
    }
}

static void collect(HalfEdges *half, Arena *arena, ConvexPieces *out) {
    out->vertex = ARENA_ARRAY(arena, int, half->count);
    out->first = ARENA_ARRAY(arena, int, half->count / 3 + 1);
    int used = 0;
    for (int e = 0; e < half->count; e++) {
        if (half->edges[e].removed) continue;
        for (int at = e; !half->edges[at].removed; at = half->edges[at].next) {
            out->vertex[used++] = half->edges[at].from;
            half->edges[at].removed = true;
        }
        out->first[++out->count] = used;
    }
}

bool convex_decompose(const Vec2 *points, const int *ring_first, const int *ring_size, int ring_count,
                      Arena *arena, ConvexPieces *out, Error *error) {
    *out = (ConvexPieces){0};
    Arena scratch = {0};
    HalfEdges half = {0};
    Vec2 corner = points[ring_first[0]];
    Triangulator t = {GEOS_init_r(), points, ring_first, ring_size, ring_count, millimetres(corner)};
    GEOSContext_setErrorMessageHandler_r(t.geos, silent, NULL);
    int total = 0;
    for (int r = 0; r < ring_count; r++) total += ring_size[r];
    bool good = ring_count <= MOST_RINGS && total <= MOST_POINTS && triangulate(&t, &scratch, &half) &&
                tiles(&t, &half);
    if (!good) good = triangulate_by_sweep(&t, &scratch, &half) && tiles(&t, &half);
    GEOS_finish_r(t.geos);
    if (good) {
        merge(&half, points, &scratch);
        collect(&half, arena, out);
    } else {
        error_set(error, "the outline at (%.3f, %.3f) is no polygon that could be cut into convex cells",
                  corner.x, corner.y);
    }
    arena_free(&scratch);
    return good;
}
