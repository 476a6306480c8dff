// enclose_plan.c - the planar arrangement of all linework on the 1 mm grid.
//
// GEOS nodes the linework by snap rounding (J. Hobby, Practical segment intersection with finite precision output,
// 1999) and polygonizes it; faces, edges and vertices are then held here as indices over whole millimetres, where
// equality is exact.
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/enclose/enclose.h"

static const double GRID_MM = 1.0;  // MAPS_GRID

// ---- shapes

bool shape_contains(const Shape *shape, Vec2 p) {
    if (p.x < shape->min.x || p.x > shape->max.x || p.y < shape->min.y || p.y > shape->max.y) return false;
    bool inside = false;
    for (int r = 0; r < shape->ring_count; r++) {
        for (int i = shape->ring[r], j = shape->ring[r + 1] - 1; i < shape->ring[r + 1]; j = i++)
            inside ^= ring_edge_is_crossed(shape->points[i], shape->points[j], p, RING_MULTIPLY_FIRST);
    }
    return inside;
}

static void shape_bound(Shape *shape) {
    shape->min = vec2(INFINITY, INFINITY);
    shape->max = vec2(-INFINITY, -INFINITY);
    for (int i = 0; i < shape->ring[shape->ring_count]; i++) {
        Vec2 p = shape->points[i];
        shape->min = vec2(fmin(shape->min.x, p.x), fmin(shape->min.y, p.y));
        shape->max = vec2(fmax(shape->max.x, p.x), fmax(shape->max.y, p.y));
    }
}

Shape shape_of_points(Arena *arena, const Vec2 *points, int count) {
    Shape shape = {ARENA_ARRAY(arena, Vec2, count), ARENA_ARRAY(arena, int, 2), 1, {0, 0}, {0, 0}};
    if (count) memcpy(shape.points, points, sizeof(Vec2) * (size_t)count);
    shape.ring[1] = count;
    shape_bound(&shape);
    return shape;
}

static GEOSCoordSequence *sequence_of(Enclosure *e, const Vec2 *points, int count, bool close) {
    GEOSCoordSequence *sequence = GEOSCoordSeq_create_r(e->geos, (unsigned)(count + close), 2);
    for (int i = 0; sequence && i < count + close; i++) {
        GEOSCoordSeq_setXY_r(e->geos, sequence, (unsigned)i, points[i % count].x, points[i % count].y);
    }
    return sequence;
}

GEOSGeometry *shape_to_geos(Enclosure *e, const Shape *shape) {
    GEOSGeometry *ring =
        GEOSGeom_createLinearRing_r(e->geos, sequence_of(e, shape->points, shape->ring[1], true));
    GEOSGeometry *polygon = ring ? GEOSGeom_createPolygon_r(e->geos, ring, NULL, 0) : NULL;
    if (!polygon) return NULL;
    if (GEOSisValid_r(e->geos, polygon) == 1) return polygon;
    GEOSGeometry *valid = GEOSMakeValid_r(e->geos, polygon);
    GEOSGeom_destroy_r(e->geos, polygon);
    return valid;
}

static int ring_points(Enclosure *e, const GEOSGeometry *ring, Vec2 *out) {
    const GEOSCoordSequence *sequence = GEOSGeom_getCoordSeq_r(e->geos, ring);
    unsigned size = 0;
    GEOSCoordSeq_getSize_r(e->geos, sequence, &size);
    int count = size > 0 ? (int)size - 1 : 0;  // the last repeats the first
    for (int i = 0; out && i < count; i++) {
        GEOSCoordSeq_getXY_r(e->geos, sequence, (unsigned)i, &out[i].x, &out[i].y);
    }
    return count;
}

void shapes_from_geos(Enclosure *e, const GEOSGeometry *geometry, double narrowest, ShapeList *out) {
    int type = GEOSGeomTypeId_r(e->geos, geometry);
    if (type == GEOS_MULTIPOLYGON || type == GEOS_GEOMETRYCOLLECTION) {
        for (int i = 0; i < GEOSGetNumGeometries_r(e->geos, geometry); i++) {
            shapes_from_geos(e, GEOSGetGeometryN_r(e->geos, geometry, i), narrowest, out);
        }
    }
    double area = 0, perimeter = 0;
    if (type != GEOS_POLYGON || GEOSisEmpty_r(e->geos, geometry)) return;
    GEOSArea_r(e->geos, geometry, &area);
    GEOSLength_r(e->geos, geometry, &perimeter);
    if (!(2 * area > narrowest * perimeter)) return;
    int holes = GEOSGetNumInteriorRings_r(e->geos, geometry), total = 0;
    Shape shape = {NULL, ARENA_ARRAY(e->scratch, int, holes + 2), holes + 1, {0, 0}, {0, 0}};
    for (int r = 0; r <= holes; r++) {
        const GEOSGeometry *ring =
            r ? GEOSGetInteriorRingN_r(e->geos, geometry, r - 1) : GEOSGetExteriorRing_r(e->geos, geometry);
        total += ring_points(e, ring, NULL);
        shape.ring[r + 1] = total;
    }
    shape.points = ARENA_ARRAY(e->scratch, Vec2, total);
    for (int r = 0; r <= holes; r++) {
        const GEOSGeometry *ring =
            r ? GEOSGetInteriorRingN_r(e->geos, geometry, r - 1) : GEOSGetExteriorRing_r(e->geos, geometry);
        ring_points(e, ring, shape.points + shape.ring[r]);
    }
    shape_bound(&shape);
    *ARENA_PUSH(e->scratch, out->items, out->count, out->capacity) = shape;
}

// ---- linework

// The arrangement of more lines, or more storeys, is made by plan_arrange. GEOS makes the others, since the order of the faces
// follows from how it does so; it takes several times as much time and memory, and looks at all pairs of equal lines.
enum { GEOS_LINES = 1000, GEOS_STOREYS = 8 };

typedef struct Lines {
    Line *items;
    int count, capacity;
} Lines;

static void add_line(Enclosure *e, Lines *lines, const Vec2 *points, int count, bool close) {
    *ARENA_PUSH(e->scratch, lines->items, lines->count, lines->capacity) = (Line){points, count, close};
}

static void add_shape(Enclosure *e, Lines *lines, const Shape *shape) {
    for (int r = 0; r < shape->ring_count; r++) {
        int first = shape->ring[r], count = shape->ring[r + 1] - first;
        if (count >= 2) add_line(e, lines, shape->points + first, count, true);
    }
}

static void add_shapes(Enclosure *e, Lines *lines, const ShapeList *list) {
    for (int i = 0; i < list->count; i++) add_shape(e, lines, &list->items[i]);
}

static void gather_lines(Enclosure *e, bool with_plugs, Lines *lines) {
    const Sketch *s = e->sketch;
    Vec2 *world = ARENA_ARRAY(e->scratch, Vec2, 4);
    world[0] = e->world_min;
    world[1] = vec2(e->world_max.x, e->world_min.y);
    world[2] = e->world_max;
    world[3] = vec2(e->world_min.x, e->world_max.y);
    add_line(e, lines, world, 4, true);
    for (int i = 0; i < s->wall_count; i++) {
        if (e->wall_bounds[i]) add_shape(e, lines, &e->walls[i]);
    }
    for (int i = 0; i < s->room_count; i++) {
        if (e->room_used[i]) add_shape(e, lines, &e->rooms[i]);
    }
    for (int i = 0; i < s->cutout_count; i++) {
        if (e->cutout_used[i]) add_shape(e, lines, &e->cutouts[i]);
    }
    for (int i = 0; i < s->opening_count; i++) {
        if (!e->holes[i].used) continue;
        add_shape(e, lines, &e->holes[i].box);
        if (s->openings[i].kind == OPENING_DOOR) add_line(e, lines, e->holes[i].line, 2, false);
    }
    for (int i = 0; i < e->b->storey_count; i++) {
        add_shapes(e, lines, &e->implicit[i]);
        add_shapes(e, lines, &e->slits[i]);
        if (with_plugs) add_shapes(e, lines, &e->plugs[i]);
    }
}

typedef struct Hash {
    int *slot;  // index + 1, 0: empty
    size_t mask;
} Hash;

static Hash hash_new(Arena *arena, int count) {
    size_t size = 64;
    while (size < (size_t)count * 2) size *= 2;
    return (Hash){ARENA_ARRAY(arena, int, size), size - 1};
}

static uint64_t mix(uint64_t x) {
    x = (x ^ (x >> 31)) * 0x9e3779b97f4a7c15u;
    return x ^ (x >> 29);
}

static GEOSGeometry *lines_to_geos(Enclosure *e, const Lines *lines) {
    GEOSGeometry **items = ARENA_ARRAY(e->scratch, GEOSGeometry *, lines->count);
    int count = 0;
    for (int i = 0; i < lines->count; i++) {
        const Line *l = &lines->items[i];
        GEOSCoordSequence *sequence = sequence_of(e, l->points, l->count, l->close);
        GEOSGeometry *line = sequence ? GEOSGeom_createLineString_r(e->geos, sequence) : NULL;
        if (line) items[count++] = line;
    }
    return GEOSGeom_createCollection_r(e->geos, GEOS_MULTILINESTRING, items, (unsigned)count);
}

// ---- faces

static int find_vertex(Plan *plan, Hash *hash, Vec2 p) {
    size_t at = mix((uint64_t)(int64_t)p.x * 0x100000001b3u + mix((uint64_t)(int64_t)p.y)) & hash->mask;
    for (; hash->slot[at]; at = (at + 1) & hash->mask) {
        if (vec2_equal(plan->vertices[hash->slot[at] - 1], p)) return hash->slot[at] - 1;
    }
    plan->vertices[plan->vertex_count] = p;
    hash->slot[at] = ++plan->vertex_count;
    return plan->vertex_count - 1;
}

// The half-edge a -> b.
static int find_half(Plan *plan, Hash *hash, int a, int b) {
    int low = a < b ? a : b, high = a < b ? b : a;
    size_t at = mix((uint64_t)low * 0x1000193u + mix((uint64_t)high)) & hash->mask;
    for (; hash->slot[at]; at = (at + 1) & hash->mask) {
        const PlanEdge *edge = &plan->edges[hash->slot[at] - 1];
        if (edge->v[0] == low && edge->v[1] == high) return 2 * (hash->slot[at] - 1) + (a == high);
    }
    plan->edges[plan->edge_count] = (PlanEdge){{low, high}, {-1, -1}};
    hash->slot[at] = ++plan->edge_count;
    return 2 * (plan->edge_count - 1) + (a == high);
}

// Adds a ring with the face on its left: reversed if its area has the wrong sign.
static void add_ring(Plan *plan, Hash *vertices, Hash *edges, const Vec2 *points, int count, bool hole) {
    double area = 0;
    for (int i = 1; i + 1 < count; i++) {
        area += vec2_cross(vec2_sub(points[i], points[0]), vec2_sub(points[i + 1], points[0]));
    }
    bool turn = (area < 0) != hole;
    PlanFace *face = &plan->faces[plan->face_count];
    for (int i = 0; i < count; i++) {
        Vec2 p = points[turn ? count - 1 - i : i],
             q = points[turn ? (2 * count - 2 - i) % count : (i + 1) % count];
        int a = find_vertex(plan, vertices, p), b = find_vertex(plan, vertices, q);
        int half = find_half(plan, edges, a, b);
        plan->edges[half >> 1].face[half & 1] = plan->face_count;
        plan->halves[plan->half_count++] = half;
        face->half_count++;
        face->perimeter += vec2_length(vec2_sub(q, p));
    }
    face->area += fabs(area) / 2 * (hole ? -1 : 1);
}

static int by_value(const void *pa, const void *pb) {
    double a = *(const double *)pa, b = *(const double *)pb;
    return (a > b) - (a < b);
}

// Finds the middle of the widest place of a face on the level y. Returns its score: the smaller of the width and `gap`.
static double widest_at(const Plan *plan, const PlanFace *face, double y, double gap, double *x, Vec2 *best) {
    int count = 0;
    for (int k = 0; k < face->half_count; k++) {
        int h = plan->halves[face->first_half + k];
        Vec2 a = plan->vertices[half_from(plan, h)], b = plan->vertices[half_to(plan, h)];
        if ((a.y > y) != (b.y > y)) x[count++] = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
    }
    qsort(x, (size_t)count, sizeof *x, by_value);
    double widest = -1;
    for (int k = 0; k + 1 < count; k += 2) {
        if (x[k + 1] - x[k] <= widest) continue;
        widest = x[k + 1] - x[k];
        *best = vec2((x[k] + x[k + 1]) / 2, y);
    }
    return fmin(widest, gap);
}

// A point well inside: the middle of the widest place among the levels midway between vertices that lie far
// apart.
static void find_inner(const Plan *plan, PlanFace *face, double *y, double *x) {
    enum { TRIES = 6 };
    for (int k = 0; k < face->half_count; k++) {
        y[k] = plan->vertices[half_from(plan, plan->halves[face->first_half + k])].y;
    }
    qsort(y, (size_t)face->half_count, sizeof *y, by_value);
    double best = -1, bound = INFINITY;
    for (int t = 0; t < TRIES; t++) {
        int tallest = -1;
        double gap = 0;
        for (int k = 0; k + 1 < face->half_count; k++) {
            double here = y[k + 1] - y[k];
            if (here > gap && here < bound) {
                gap = here;
                tallest = k;
            }
        }
        if (tallest < 0) break;
        bound = gap;
        Vec2 point = face->inner;
        double score = widest_at(plan, face, (y[tallest] + y[tallest + 1]) / 2, gap, x, &point);
        if (score > best) {
            best = score;
            face->inner = point;
        }
    }
}

static void finish_faces(Enclosure *e, Plan *plan) {
    int most = 0;
    for (int f = 0; f < plan->face_count; f++)
        most = plan->faces[f].half_count > most ? plan->faces[f].half_count : most;
    double *y = ARENA_ARRAY(e->scratch, double, most), *x = ARENA_ARRAY(e->scratch, double, most);
    Box *points = ARENA_ARRAY(e->scratch, Box, plan->face_count);
    for (int f = 0; f < plan->face_count; f++) {
        find_inner(plan, &plan->faces[f], y, x);
        points[f] = enclose_box(plan->faces[f].inner, plan->faces[f].inner, 0);
    }
    plan->inner = box_tree_build(points, plan->face_count, e->scratch);
}

static void read_faces(Enclosure *e, const GEOSGeometry *polygons, Plan *plan) {
    int count = GEOSGetNumGeometries_r(e->geos, polygons), points = 0, longest = 0;
    for (int i = 0; i < count; i++) {
        points += GEOSGetNumCoordinates_r(e->geos, GEOSGetGeometryN_r(e->geos, polygons, i));
    }
    longest = points;
    *plan = (Plan){.vertices = ARENA_ARRAY(e->scratch, Vec2, points),
                   .edges = ARENA_ARRAY(e->scratch, PlanEdge, points),
                   .faces = ARENA_ARRAY(e->scratch, PlanFace, count),
                   .halves = ARENA_ARRAY(e->scratch, int, points)};
    Hash vertices = hash_new(e->scratch, points), edges = hash_new(e->scratch, points);
    Vec2 *ring = ARENA_ARRAY(e->scratch, Vec2, longest);
    for (int i = 0; i < count; i++) {
        const GEOSGeometry *polygon = GEOSGetGeometryN_r(e->geos, polygons, i);
        plan->faces[plan->face_count] = (PlanFace){.first_half = plan->half_count};
        int n = ring_points(e, GEOSGetExteriorRing_r(e->geos, polygon), ring);
        add_ring(plan, &vertices, &edges, ring, n, false);
        for (int k = 0; k < GEOSGetNumInteriorRings_r(e->geos, polygon); k++) {
            n = ring_points(e, GEOSGetInteriorRingN_r(e->geos, polygon, k), ring);
            add_ring(plan, &vertices, &edges, ring, n, true);
        }
        plan->face_count++;
    }
}

int plan_faces_in(Enclosure *e, const Plan *p, const Shape *shape) {
    BoxHits *faces = &e->faces;
    int count = box_tree_find(&p->inner, enclose_box(shape->min, shape->max, 0), e->scratch, faces), kept = 0;
    for (int i = 0; i < count; i++) {
        if (shape_contains(shape, p->faces[faces->items[i]].inner)) faces->items[kept++] = faces->items[i];
    }
    return faces->count = kept;
}

bool plan_build(Enclosure *e, bool with_plugs, Plan *out) {
    Lines lines = {NULL, 0, 0};
    gather_lines(e, with_plugs, &lines);
    if (lines.count > GEOS_LINES || e->b->storey_count > GEOS_STOREYS) {
        plan_arrange(e, lines.items, lines.count, out);
        finish_faces(e, out);
        return true;
    }
    GEOSGeometry *all = lines_to_geos(e, &lines);
    GEOSGeometry *noded = all ? GEOSUnaryUnionPrec_r(e->geos, all, GRID_MM) : NULL;
    const GEOSGeometry *list[1] = {noded};
    GEOSGeometry *polygons = noded ? GEOSPolygonize_r(e->geos, list, 1) : NULL;
    bool ok = polygons != NULL;
    if (ok) read_faces(e, polygons, out);
    if (ok) finish_faces(e, out);
    if (polygons) GEOSGeom_destroy_r(e->geos, polygons);
    if (noded) GEOSGeom_destroy_r(e->geos, noded);
    if (all) GEOSGeom_destroy_r(e->geos, all);
    return ok ? true
              : error_set(e->error, "the plan's lines could not be joined on the 1 mm grid: %s",
                          e->geos_message);
}
