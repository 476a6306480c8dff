// surfaces.c - the walls, floors and ceilings that close a cell wherever it has no portal, and the closed leaves.
//
// Walls: each plan edge between the heights no portal takes. Floors and ceilings: the cell's plan less its portals
// and the inlays that lie there. All are convex and face into their cell. Neighbouring surfaces share their
// vertices: where a corner of one lies on an edge of another it becomes a vertex of that too, since a T-vertex lets
// light and sight through when it is rounded.
#include <stdlib.h>
#include <string.h>

#include "engine/core/box_tree.h"
#include "engine/core/polygon.h"
#include "visibility/cells/build.h"

// How near an edge a corner is taken to lie on it, metres: above the rounding of cuts (1e-13), and even a corner of
// the 1 mm grid that is no nearer than this moves the edge by less than a screen could show.
static const double T_VERTEX = 1e-7;

static Object *add_object(CellBuilder *builder, ObjectKind kind, const char *name) {
    CellGraph *graph = builder->graph;
    Object *object =
        ARENA_APPEND(builder->arena, graph->objects, graph->object_count, builder->object_capacity);
    *object = (Object){
        .kind = kind, .name = name, .first_polygon = graph->polygon_count, .opening = -1, .leaf = -1};
    return object;
}

static void add_graph_polygon(CellBuilder *builder, const Vec3 *vertices, int count, int material) {
    CellGraph *graph = builder->graph;
    *ARENA_APPEND(builder->arena, graph->polygons, graph->polygon_count, builder->polygon_capacity) =
        (Polygon){graph->vertex_count, count, material, 0};
    graph->vertices =
        arena_regrow(builder->arena, graph->vertices, sizeof *graph->vertices, graph->vertex_count,
                     graph->vertex_count + count, &builder->vertex_capacity);
    memcpy(graph->vertices + graph->vertex_count, vertices, (size_t)count * sizeof *vertices);
    graph->vertex_count += count;
    graph->objects[graph->object_count - 1].polygon_count++;
}

static void copy_building(CellBuilder *builder) {
    const Building *b = builder->building;
    CellGraph *graph = builder->graph;
    // Room for the surfaces as well: the arrays of a furnished building need not move.
    builder->polygon_capacity = b->polygon_count + b->polygon_count / 4 + 256;
    builder->vertex_capacity = b->vertex_count + b->vertex_count / 4 + 1024;
    graph->polygons = ARENA_ARRAY(builder->arena, Polygon, builder->polygon_capacity);
    graph->vertices = ARENA_ARRAY(builder->arena, Vec3, builder->vertex_capacity);
    for (int i = 0; i < b->object_count; i++) {
        const Object *from = &b->objects[i];
        Object *object = add_object(builder, from->kind, from->name);
        int first = object->first_polygon;
        *object = *from;
        object->first_polygon = first;
        object->polygon_count = 0;
        for (int p = from->first_polygon; p < from->first_polygon + from->polygon_count; p++) {
            add_graph_polygon(builder, b->vertices + b->polygons[p].first_vertex, b->polygons[p].vertex_count,
                              b->polygons[p].material);
            graph->polygons[graph->polygon_count - 1].texture_map = b->polygons[p].texture_map;
        }
    }
}

static void add_surface(CellBuilder *builder, int cell, const Vec3 *vertices, int count, int material) {
    if (count < 3 || polygon_area(vertices, count) < VIS_SLIVER) {
        builder->graph->dropped_slivers++;
        return;
    }
    const Region *region = &builder->building->regions[builder->graph->cells[cell].region];
    add_object(builder, OBJECT_SURFACE, region->name);
    add_graph_polygon(builder, vertices, count, material);
}

typedef struct Span {
    double z0, z1;
} Span;

static int by_height(const void *p, const void *q) {
    const Span *a = p, *b = q;
    return (a->z0 > b->z0) - (a->z0 < b->z0);
}

// The heights that portals take of the cell's edge a -> b, lowest first; they are disjoint.
static int portal_spans(const CellGraph *graph, const Cell *cell, Vec2 a, Vec2 b, Span *out) {
    int count = 0;
    for (int i = 0; i < cell->way_count; i++) {
        const Portal *portal = &graph->portals[graph->ways[cell->first_way + i].portal];
        if (portal->horizontal) continue;
        bool here = (vec2_equal(portal->left, a) && vec2_equal(portal->right, b)) ||
                    (vec2_equal(portal->left, b) && vec2_equal(portal->right, a));
        if (!here) continue;
        const Vec3 *v = graph->portal_vertices + portal->first_vertex;
        out[count++] = (Span){v[0].z, v[1].z};
    }
    qsort(out, (size_t)count, sizeof *out, by_height);
    return count;
}

static void add_wall(CellBuilder *builder, int cell, Vec2 a, Vec2 b, double z0, double z1, int material) {
    if (z0 >= z1) return;
    Vec3 quad[4] = {vec3(a.x, a.y, z0), vec3(a.x, a.y, z1), vec3(b.x, b.y, z1), vec3(b.x, b.y, z0)};
    add_surface(builder, cell, quad, 4, material);
}

// A wall behind a ring's edge: one quad for each look that it has at its heights.
static void add_bands(CellBuilder *builder, int cell, int edge, Vec2 a, Vec2 b, Span span, int material) {
    const Building *at = builder->building;
    double from = span.z0;
    for (int i = building_first_band(at, edge); i < at->band_count && at->bands[i].edge == edge; i++) {
        double to = fmin(fmax(at->bands[i].from, from), span.z1);
        add_wall(builder, cell, a, b, from, to, material);
        material = at->bands[i].material;
        from = to;
    }
    add_wall(builder, cell, a, b, from, span.z1, material);
}

static void add_walls(CellBuilder *builder, int c) {
    CellGraph *graph = builder->graph;
    const Building *at = builder->building;
    const Cell *cell = &graph->cells[c];
    Span *spans = ARENA_ARRAY(builder->scratch, Span, cell->way_count);
    for (int i = 0; i < cell->edge_count; i++) {
        int edge = cell->first_edge + i;
        if (builder->edge_outer[edge]) continue;
        Vec2 a = graph->plan[edge], b = graph->plan[cell->first_edge + (i + 1) % cell->edge_count];
        int count = portal_spans(graph, cell, a, b, spans), ring = builder->ring_edge[edge],
            material = ring < 0 ? 0 : at->edge_material[ring],
            upper = ring >= 0 && at->edge_upper ? at->edge_upper[ring] : material;
        if (material < 0) material = 0;
        if (upper < 0) upper = 0;
        double from = cell->z0;
        for (int s = 0; s < count; s++) {
            add_bands(builder, c, ring, a, b, (Span){from, spans[s].z0}, material);
            from = spans[s].z1;
        }
        add_bands(builder, c, ring, a, b, (Span){from, cell->z1}, count > 0 ? upper : material);
    }
}

// ---- the rest of a floor or ceiling around portals and inlays

// A convex polygon of it; without vertices: gone.
typedef struct Piece {
    Vec3 *v;
    int count;
} Piece;

typedef struct PieceList {
    int *items;
    int count, capacity;
} PieceList;

// Beyond so many pieces, or holes, they are sorted into so many squares a side, and a hole cuts those alone that it overlaps: what
// lies beside keeps its form. Few are cut along the whole lines of its edges, which makes long neighbours share their corners.
enum { MANY = 256, SIDE = 64 };

// A growing set of convex polygons in one horizontal plane.
typedef struct Pieces {
    Arena *scratch;
    Piece *list, *spare;
    int count, capacity, spare_capacity, holes;
    Vec3 *rest, *part;  // room for a polygon at hand
    int room;
    // Where there are many pieces: which reach into which square.
    PieceList *squares;  // [SIDE * SIDE], NULL: few
    Box box;
    int *stamp;  // [capacity] the last hole that looked at one
    int stamp_capacity, stamp_count;
} Pieces;

typedef struct SquareRange {
    int i0, i1, j0, j1;
} SquareRange;

static int square_at(double x, double low, double high) {
    double at = high > low ? SIDE * (x - low) / (high - low) : 0;
    return at < 0 ? 0 : at < SIDE ? (int)at : SIDE - 1;
}

static Box piece_box(const Vec3 *v, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, v[i]);
    return box;
}

static SquareRange squares_under(const Pieces *pieces, Box box) {
    Box all = pieces->box;
    return (SquareRange){
        square_at(box.min.x, all.min.x, all.max.x), square_at(box.max.x, all.min.x, all.max.x),
        square_at(box.min.y, all.min.y, all.max.y), square_at(box.max.y, all.min.y, all.max.y)};
}

static void sort_piece(Pieces *pieces, int index) {
    SquareRange r = squares_under(pieces, piece_box(pieces->list[index].v, pieces->list[index].count));
    for (int j = r.j0; j <= r.j1; j++) {
        for (int i = r.i0; i <= r.i1; i++) {
            PieceList *square = &pieces->squares[j * SIDE + i];
            *ARENA_PUSH(pieces->scratch, square->items, square->count, square->capacity) = index;
        }
    }
}

static void add_surface_piece(Pieces *pieces, const Vec3 *vertices, int count) {
    Vec3 *v = ARENA_ARRAY(pieces->scratch, Vec3, count);
    memcpy(v, vertices, (size_t)count * sizeof *v);
    *ARENA_PUSH(pieces->scratch, pieces->list, pieces->count, pieces->capacity) = (Piece){v, count};
    if (!pieces->squares) return;
    *ARENA_PUSH(pieces->scratch, pieces->stamp, pieces->stamp_count, pieces->stamp_capacity) = -1;
    sort_piece(pieces, pieces->count - 1);
}

static void make_room(Pieces *pieces, int count) {
    if (count <= pieces->room) return;
    pieces->room = 2 * count;
    pieces->rest = ARENA_ARRAY(pieces->scratch, Vec3, pieces->room);
    pieces->part = ARENA_ARRAY(pieces->scratch, Vec3, pieces->room);
}

// Upright through an edge of a polygon that is counter-clockwise from above, pointing out of it.
static Plane outside_edge(Vec3 a, Vec3 b) {
    Vec3 n = vec3_normalize(vec3(b.y - a.y, a.x - b.x, 0));
    return (Plane){n, vec3_dot(n, a)};
}

// Cuts `piece` by the convex `hole` (counter-clockwise from above): what lies outside its first edge, then of the rest what lies
// outside the second, and so on; `keep`: adds these parts. Returns whether anything lies in the hole.
static bool subtract(Pieces *pieces, Piece piece, const Vec3 *hole, int hole_count, bool keep) {
    int count = piece.count;
    make_room(pieces, count + hole_count + 2);
    memcpy(pieces->rest, piece.v, (size_t)count * sizeof *piece.v);
    for (int i = 0; i < hole_count && count > 0; i++) {
        Vec3 a = hole[i], b = hole[(i + 1) % hole_count];
        // Two cuts that meet in a corner may leave an edge of rounding, which has no direction.
        if (vec3_length(vec3_sub(b, a)) < T_VERTEX) continue;
        Plane outside = outside_edge(a, b), inside = {vec3_scale(outside.n, -1), -outside.d};
        int kept = keep ? polygon_clip(pieces->rest, count, outside, 0, pieces->part) : 0;
        if (kept >= 3 && polygon_area(pieces->part, kept) >= VIS_SLIVER)
            add_surface_piece(pieces, pieces->part, kept);
        count = polygon_clip(pieces->rest, count, inside, 0, pieces->part);
        memcpy(pieces->rest, pieces->part, (size_t)count * sizeof *pieces->rest);
    }
    return count >= 3 && polygon_area(pieces->rest, count) >= VIS_SLIVER;
}

static void sort_pieces(Pieces *pieces) {
    pieces->box = box_empty();
    for (int i = 0; i < pieces->count; i++)
        pieces->box = box_union(pieces->box, piece_box(pieces->list[i].v, pieces->list[i].count));
    pieces->squares = ARENA_ARRAY(pieces->scratch, PieceList, SIDE * SIDE);
    for (int i = 0; i < pieces->count; i++) {
        *ARENA_PUSH(pieces->scratch, pieces->stamp, pieces->stamp_count, pieces->stamp_capacity) = -1;
        sort_piece(pieces, i);
    }
}

static void subtract_from_some(Pieces *pieces, const Vec3 *hole, int hole_count) {
    Box box = piece_box(hole, hole_count);
    SquareRange r = squares_under(pieces, box);
    for (int j = r.j0; j <= r.j1; j++) {
        for (int i = r.i0; i <= r.i1; i++) {
            PieceList *square = &pieces->squares[j * SIDE + i];
            int kept = 0;
            // Parts come to the end of the same list, and are not looked at again.
            for (int k = 0; k < square->count; k++) {
                int index = square->items[k];
                Piece piece = pieces->list[index];
                if (piece.count == 0) continue;
                square->items[kept++] = index;
                if (pieces->stamp[index] == pieces->holes) continue;
                pieces->stamp[index] = pieces->holes;
                if (!box_overlap(box, piece_box(piece.v, piece.count)) ||
                    !subtract(pieces, piece, hole, hole_count, false))
                    continue;
                int first = pieces->count;
                pieces->list[index].count = 0;
                subtract(pieces, piece, hole, hole_count, true);
                for (int p = first; p < pieces->count; p++) pieces->stamp[p] = pieces->holes;
            }
            square->count = kept;
        }
    }
}

static void subtract_from_all(Pieces *pieces, const Vec3 *hole, int hole_count) {
    pieces->holes++;
    if (!pieces->squares && (pieces->count > MANY || pieces->holes > MANY)) sort_pieces(pieces);
    if (pieces->squares) {
        subtract_from_some(pieces, hole, hole_count);
        return;
    }
    Piece *old = pieces->list;
    int count = pieces->count, capacity = pieces->capacity;
    pieces->list = pieces->spare;
    pieces->capacity = pieces->spare_capacity;
    pieces->count = 0;
    for (int i = 0; i < count; i++) subtract(pieces, old[i], hole, hole_count, true);
    pieces->spare = old;
    pieces->spare_capacity = capacity;
}

// The part of an inlay over this cell becomes a surface of its own; in pieces->rest.
static int inlay_in_cell(const CellGraph *graph, const Inlay *inlay, const Cell *cell, Pieces *pieces) {
    const Vec2 *points = graph->building->points + inlay->first_point;
    int count = inlay->point_count;
    make_room(pieces, count + cell->edge_count + 1);
    for (int i = 0; i < count; i++) pieces->rest[i] = vec3(points[i].x, points[i].y, inlay->z);
    for (int i = 0; i < cell->edge_count && count > 0; i++) {
        Vec2 a = graph->plan[cell->first_edge + i],
             b = graph->plan[cell->first_edge + (i + 1) % cell->edge_count];
        Vec3 n = vec3_normalize(vec3(a.y - b.y, b.x - a.x, 0));
        count = polygon_clip(pieces->rest, count, (Plane){n, n.x * a.x + n.y * a.y}, 0, pieces->part);
        memcpy(pieces->rest, pieces->part, (size_t)count * sizeof *pieces->rest);
    }
    return count >= 3 && polygon_area(pieces->rest, count) >= VIS_SLIVER ? count : 0;
}

static void add_level_surface(CellBuilder *builder, int cell, Vec3 *v, int count, int material, bool floor) {
    for (int i = 0; !floor && i < count / 2; i++) {  // a ceiling faces down
        Vec3 swap = v[i];
        v[i] = v[count - 1 - i];
        v[count - 1 - i] = swap;
    }
    add_surface(builder, cell, v, count, material);
}

// The inlays of a building by their place: a floor or ceiling looks at those that lie over its cell.
typedef struct InlayTree {
    BoxTree tree;
    BoxHits near;
} InlayTree;

static InlayTree sort_inlays(const CellBuilder *builder) {
    const Building *b = builder->building;
    Box *boxes = ARENA_ARRAY(builder->scratch, Box, b->inlay_count);
    for (int i = 0; i < b->inlay_count; i++) {
        const Inlay *inlay = &b->inlays[i];
        boxes[i] = box_empty();
        for (int k = 0; k < inlay->point_count; k++) {
            Vec2 p = b->points[inlay->first_point + k];
            boxes[i] = box_add(boxes[i], vec3(p.x, p.y, inlay->z));
        }
    }
    return (InlayTree){.tree = box_tree_build(boxes, b->inlay_count, builder->scratch)};
}

static void add_level(CellBuilder *builder, InlayTree *inlays, int c, double z, int material, bool floor) {
    CellGraph *graph = builder->graph;
    const Building *b = builder->building;
    const Cell *cell = &graph->cells[c];
    Vec3 polygon[BUILD_MAX_VERTICES];
    Arena scratch = {0};
    Pieces pieces = {.scratch = &scratch};
    int corners = cell_polygon(graph, cell, z, polygon);
    add_surface_piece(&pieces, polygon, corners);
    for (int i = 0; i < cell->way_count; i++) {
        const Portal *portal = &graph->portals[graph->ways[cell->first_way + i].portal];
        if (!portal->horizontal || portal->cell[floor ? 0 : 1] != c) continue;
        subtract_from_all(&pieces, graph->portal_vertices + portal->first_vertex, portal->vertex_count);
    }
    Box level = cell->box;
    level.min.z = level.max.z = z;
    int found = material >= 0 ? box_tree_find(&inlays->tree, level, builder->scratch, &inlays->near) : 0;
    for (int i = 0; i < found; i++) {
        const Inlay *inlay = &b->inlays[inlays->near.items[i]];
        int count = inlay_in_cell(graph, inlay, cell, &pieces);
        if (count == 0) continue;
        Vec3 *part = memcpy(ARENA_ARRAY(&scratch, Vec3, count), pieces.rest, (size_t)count * sizeof *part);
        subtract_from_all(&pieces, part, count);
        add_level_surface(builder, c, part, count, inlay->material, floor);
    }
    for (int i = 0; i < pieces.count && material >= 0; i++) {  // below 0: the sky
        Piece piece = pieces.list[i];
        if (piece.count > 0) add_level_surface(builder, c, piece.v, piece.count, material, floor);
    }
    arena_free(&scratch);
}

static void add_plugs(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    for (int p = 0; p < graph->portal_count; p++) {
        const Portal *portal = &graph->portals[p];
        if (portal->door < 0) continue;
        const Opening *opening = &builder->building->openings[portal->door];
        Object *object = add_object(builder, OBJECT_LEAF, opening->name);
        object->opening = portal->door;
        object->plug = true;
        add_graph_polygon(builder, graph->portal_vertices + portal->first_vertex, portal->vertex_count,
                          opening->material);
    }
}

// Level edges along y: sorted by height, then by their line.
static int by_zxy(const void *p, const void *q) {
    const Vec3 *a = p, *b = q;
    if (a->z != b->z) return a->z < b->z ? -1 : 1;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    return (a->y > b->y) - (a->y < b->y);
}

// Level edges along x.
static int by_zyx(const void *p, const void *q) {
    const Vec3 *a = p, *b = q;
    if (a->z != b->z) return a->z < b->z ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return (a->x > b->x) - (a->x < b->x);
}

// Upright edges: sorted by their place in plan.
static int by_xyz(const void *p, const void *q) {
    const Vec3 *a = p, *b = q;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return (a->z > b->z) - (a->z < b->z);
}

typedef int Compare(const void *, const void *);

// Points in an order of their own: point k of it is points[order[k]].
typedef struct Sorted {
    const Vec3 *points;
    int *order, count;
    Compare *compare;
} Sorted;

static Vec3 sorted_at(const Sorted *s, int k) { return s->points[s->order[k]]; }

static int by_order(const void *p, const void *q, void *context) {
    const Sorted *s = context;
    return s->compare(&s->points[*(const int *)p], &s->points[*(const int *)q]);
}

static Sorted sort_points(Arena *scratch, const Vec3 *points, int count, Compare *compare) {
    Sorted out = {points, ARENA_ARRAY(scratch, int, count), count, compare};
    for (int i = 0; i < count; i++) out.order[i] = i;
    qsort_r(out.order, (size_t)count, sizeof *out.order, by_order, &out);
    return out;
}

static size_t hash_of_point(Vec3 p) {
    double at[3] = {p.x + 0.0, p.y + 0.0, p.z + 0.0};  // one zero
    uint64_t hash = 0, bits;
    for (int k = 0; k < 3; k++) {
        memcpy(&bits, &at[k], sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return (size_t)hash;
}

// Each once. A corner occurs three times in the mean: sorting all would take more memory than the rest of the stage.
static Vec3 *distinct_points(Arena *scratch, const Vec3 *points, int *count) {
    Arena own = {0};
    int kept = 0, capacity = 0, size = 1024, *slot = ARENA_ARRAY(&own, int, size);  // index + 1; 0: empty
    Vec3 *out = NULL;
    for (int i = 0; i < *count; i++) {
        if (kept > size / 2) {
            slot = ARENA_ARRAY(&own, int, size *= 2);
            for (int k = 0; k < kept; k++) {
                size_t at = hash_of_point(out[k]) & (size_t)(size - 1);
                while (slot[at]) at = (at + 1) & (size_t)(size - 1);
                slot[at] = k + 1;
            }
        }
        size_t at = hash_of_point(points[i]) & (size_t)(size - 1);
        while (slot[at] && !vec3_equal(out[slot[at] - 1], points[i])) at = (at + 1) & (size_t)(size - 1);
        if (slot[at]) continue;
        *ARENA_APPEND(scratch, out, kept, capacity) = points[i];
        slot[at] = kept;
    }
    arena_free(&own);
    *count = kept;
    return out;
}

// The first point not below `key`.
static int lower_bound(const Sorted *s, Vec3 key) {
    int low = 0, high = s->count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (s->compare(&s->points[s->order[middle]], &key) < 0) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

typedef struct Hit {
    double t;
    Vec3 point;
} Hit;

static int by_parameter(const void *p, const void *q) {
    const Hit *a = p, *b = q;
    return (a->t > b->t) - (a->t < b->t);
}

// Appends the corners in run [from, to) that lie inside the edge a -> b.
static void collect_hits(Arena *scratch, const Sorted *run, int from, int to, Vec3 a, Vec3 b, Hit **hits,
                         int *count, int *capacity) {
    Vec3 along = vec3_sub(b, a);
    double length2 = vec3_dot(along, along);
    for (int i = from; i < to; i++) {
        Vec3 corner = sorted_at(run, i), offset = vec3_sub(corner, a);
        double t = vec3_dot(offset, along) / length2;
        if (t <= 0 || t >= 1) continue;
        Vec3 off = vec3_sub(offset, vec3_scale(along, t));
        if (vec3_dot(off, off) > T_VERTEX * T_VERTEX) continue;
        if (vec3_equal(corner, a) || vec3_equal(corner, b)) continue;
        *ARENA_PUSH(scratch, *hits, *count, *capacity) = (Hit){t, corner};
    }
}

// So many corners of a line along y at most have a box together.
enum { RUN = 16 };

// All corners of surfaces, each once, in three orders.
typedef struct TVertices {
    Arena *scratch;
    Sorted upright, along_y, along_x;
    // Once an edge is neither upright nor along x or y: boxes about corners run[i] .. run[i + 1] - 1 of along_y
    BoxTree tree;
    int *run;
    BoxHits near;
    Hit *hits;
    int hit_capacity;
    double left;  // corners that may still be looked at
} TVertices;

// Long edges that are neither along x nor along y, thousands in one plane, each look at all corners there: beyond so many the rest of
// the edges stay as they are.
static const double MOST_LOOKS = 5e8;

static void plant_tree(TVertices *t) {
    const Sorted *s = &t->along_y;
    int count = 0;
    for (int pass = 0; pass < 2; pass++) {
        Box *boxes = pass ? ARENA_ARRAY(t->scratch, Box, count) : NULL;
        if (pass) t->run = ARENA_ARRAY(t->scratch, int, count + 1);
        count = 0;
        for (int first = 0, i = 0; i < s->count; first = i, count++) {
            Vec3 from = sorted_at(s, first), to = from;
            for (; i < s->count && i < first + RUN; i++) {
                Vec3 next = sorted_at(s, i);
                if (next.z != from.z || next.x != from.x) break;
                to = next;
            }
            if (!pass) continue;
            boxes[count] = (Box){from, to};
            t->run[count] = first;
        }
        if (!pass) continue;
        t->run[count] = s->count;
        t->tree = box_tree_build(boxes, count, t->scratch);
    }
}

// Level corners in a rectangle around a slanted edge.
static void collect_slanted(TVertices *t, Vec3 a, Vec3 b, int *count) {
    if (!t->tree.nodes) plant_tree(t);
    Box box = {vec3(fmin(a.x, b.x) - T_VERTEX, fmin(a.y, b.y) - T_VERTEX, a.z),
               vec3(fmax(a.x, b.x) + T_VERTEX, fmax(a.y, b.y) + T_VERTEX, a.z)};
    box_tree_find(&t->tree, box, t->scratch, &t->near);
    for (int i = 0; i < t->near.count; i++) {
        int first = t->run[t->near.items[i]], end = t->run[t->near.items[i] + 1];
        t->left -= end - first;
        collect_hits(t->scratch, &t->along_y, first, end, a, b, &t->hits, count, &t->hit_capacity);
    }
}

// Level corners on lines along x, or along y, that lie as near as a corner of the edge may.
static void collect_along(TVertices *t, Vec3 a, Vec3 b, bool x, int *count) {
    const Sorted *points = x ? &t->along_x : &t->along_y;
    double low = x ? fmin(a.x, b.x) : fmin(a.y, b.y), high = x ? fmax(a.x, b.x) : fmax(a.y, b.y),
           end = (x ? a.y : a.x) + T_VERTEX;
    Vec3 key = x ? vec3(low - T_VERTEX, a.y - T_VERTEX, a.z) : vec3(a.x - T_VERTEX, low - T_VERTEX, a.z);
    for (int at = lower_bound(points, key); at < points->count;) {
        Vec3 corner = sorted_at(points, at);
        double line = x ? corner.y : corner.x;
        if (corner.z != a.z || line > end) return;
        // On this line from `low` to `high`.
        Vec3 from = x ? vec3(low - T_VERTEX, line, a.z) : vec3(line, low - T_VERTEX, a.z),
             to = x ? vec3(high + T_VERTEX, line, a.z) : vec3(line, high + T_VERTEX, a.z),
             next = x ? vec3(INFINITY, line, a.z) : vec3(line, INFINITY, a.z);
        int first = lower_bound(points, from), last = lower_bound(points, to);
        t->left -= last - first;
        collect_hits(t->scratch, points, first, last, a, b, &t->hits, count, &t->hit_capacity);
        at = lower_bound(points, next);
    }
}

// The corners inside edge a -> b, in order along it.
static int corners_on_edge(TVertices *t, Vec3 a, Vec3 b) {
    int count = 0;
    if (t->left <= 0) return 0;
    if (a.x == b.x && a.y == b.y) {
        Vec3 low = a.z < b.z ? a : b, high = a.z < b.z ? b : a;
        int from = lower_bound(&t->upright, low), to = lower_bound(&t->upright, high);
        t->left -= to - from;
        collect_hits(t->scratch, &t->upright, from, to, a, b, &t->hits, &count, &t->hit_capacity);
    } else if (a.x == b.x || a.y == b.y) {
        collect_along(t, a, b, a.y == b.y, &count);
    } else {
        collect_slanted(t, a, b, &count);
    }
    if (count > 1) qsort(t->hits, (size_t)count, sizeof *t->hits, by_parameter);
    return count;
}

// Writes the surfaces anew with the corners of others that lie on their edges.
static void resolve_t_vertices(CellBuilder *builder, int first_polygon) {
    CellGraph *graph = builder->graph;
    if (first_polygon == graph->polygon_count) return;
    int first = graph->polygons[first_polygon].first_vertex, count = graph->vertex_count - first;
    Arena scratch = {0};
    Vec3 *old = ARENA_ARRAY(&scratch, Vec3, count);
    memcpy(old, graph->vertices + first, (size_t)count * sizeof *old);
    int distinct = count;
    const Vec3 *points = distinct_points(&scratch, old, &distinct);
    TVertices t = {.scratch = &scratch,
                   .upright = sort_points(&scratch, points, distinct, by_xyz),
                   .along_y = sort_points(&scratch, points, distinct, by_zxy),
                   .along_x = sort_points(&scratch, points, distinct, by_zyx),
                   .left = MOST_LOOKS};
    graph->vertex_count = first;
    for (int p = first_polygon; p < graph->polygon_count; p++) {
        Polygon *polygon = &graph->polygons[p];
        const Vec3 *v = old + (polygon->first_vertex - first);
        int old_count = polygon->vertex_count;
        polygon->first_vertex = graph->vertex_count;
        for (int i = 0; i < old_count; i++) {
            *ARENA_APPEND(builder->arena, graph->vertices, graph->vertex_count, builder->vertex_capacity) =
                v[i];
            int hits = corners_on_edge(&t, v[i], v[(i + 1) % old_count]);
            for (int h = 0; h < hits; h++) {
                *ARENA_APPEND(builder->arena, graph->vertices, graph->vertex_count,
                              builder->vertex_capacity) = t.hits[h].point;
            }
        }
        polygon->vertex_count = graph->vertex_count - polygon->first_vertex;
    }
    arena_free(&scratch);
}

void build_surfaces(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    copy_building(builder);
    int first_polygon = graph->polygon_count;
    graph->surface_first = ARENA_ARRAY(builder->arena, int, graph->cell_count + 1);
    InlayTree inlays = sort_inlays(builder);
    for (int c = 0; c < graph->cell_count; c++) {
        const Region *region = &builder->building->regions[graph->cells[c].region];
        graph->surface_first[c] = graph->object_count;
        add_walls(builder, c);
        add_level(builder, &inlays, c, graph->cells[c].z0, region->floor_material, true);
        add_level(builder, &inlays, c, graph->cells[c].z1, region->ceiling_material, false);
    }
    graph->surface_first[graph->cell_count] = graph->object_count;
    add_plugs(builder);
    resolve_t_vertices(builder, first_polygon);
    Arena *arena = builder->arena;
    graph->polygons = arena_fit(arena, graph->polygons, sizeof *graph->polygons, graph->polygon_count,
                                builder->polygon_capacity);
    graph->vertices = arena_fit(arena, graph->vertices, sizeof *graph->vertices, graph->vertex_count,
                                builder->vertex_capacity);
    graph->objects = arena_fit(arena, graph->objects, sizeof *graph->objects, graph->object_count,
                               builder->object_capacity);
    graph->portals = arena_fit(arena, graph->portals, sizeof *graph->portals, graph->portal_count,
                               builder->portal_capacity);
    graph->portal_vertices = arena_fit(arena, graph->portal_vertices, sizeof *graph->portal_vertices,
                                       graph->portal_vertex_count, builder->portal_vertex_capacity);
    graph->plan =
        arena_fit(arena, graph->plan, sizeof *graph->plan, graph->plan_count, builder->plan_capacity);
}
