// cells.c - a building's free space as convex cells: each region's plan that is not convex is cut into convex pieces,
// each piece is a prism between the region's floor and ceiling.
#include "engine/core/memory.h"
#include "visibility/cells/build.h"
#include "visibility/cells/convex.h"

// Both ends on the same side of the world's border.
static bool on_border(const Box *world, Vec2 a, Vec2 b) {
    return (a.x == b.x && (a.x == world->min.x || a.x == world->max.x)) ||
           (a.y == b.y && (a.y == world->min.y || a.y == world->max.y));
}

// The ring edge that starts at `point` and ends at `next`, or -1 for a cut through the region.
static int ring_edge(const Building *b, const Region *region, int point, int next) {
    // The rings of a region, and their points, follow each other.
    int low = region->first_ring, high = low + region->ring_count - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (b->rings[middle].first_point <= point)
            low = middle;
        else
            high = middle - 1;
    }
    int first = b->rings[low].first_point, count = b->rings[low].point_count;
    if (point < first || point >= first + count) return -1;
    return first + (point - first + 1) % count == next ? point : -1;
}

static void add_edge(CellBuilder *builder, const Region *region, int point, int next) {
    const Building *b = builder->building;
    CellGraph *graph = builder->graph;
    Vec2 a = b->points[point], end = b->points[next];
    int count = graph->plan_count;
    *ARENA_PUSH(builder->scratch, builder->ring_edge, count, builder->edge_capacity) =
        ring_edge(b, region, point, next);
    count = graph->plan_count;
    *ARENA_PUSH(builder->scratch, builder->edge_outer, count, builder->outer_capacity) =
        region->kind == REGION_OUTDOORS && on_border(&b->world, a, end);
    *ARENA_APPEND(builder->arena, graph->plan, graph->plan_count, builder->plan_capacity) = a;
}

static void add_cell(CellBuilder *builder, int region_index, const int *vertex, int count, int *capacity) {
    CellGraph *graph = builder->graph;
    const Region *region = &builder->building->regions[region_index];
    Cell *cell = ARENA_APPEND(builder->arena, graph->cells, graph->cell_count, *capacity);
    *cell = (Cell){.region = region_index,
                   .first_edge = graph->plan_count,
                   .edge_count = count,
                   .z0 = region->z0,
                   .z1 = region->z1,
                   .box = box_empty()};
    for (int i = 0; i < count; i++) {
        add_edge(builder, region, vertex[i], vertex[(i + 1) % count]);
        Vec2 p = builder->building->points[vertex[i]];
        cell->box = box_add(box_add(cell->box, vec3(p.x, p.y, cell->z0)), vec3(p.x, p.y, cell->z1));
    }
    graph->box = box_union(graph->box, cell->box);
}

static double part_area(const CellBuilder *builder, const int *vertex, int first, int count, int all) {
    const Vec2 *points = builder->building->points;
    Vec2 origin = points[vertex[first % all]];
    double twice = 0;
    for (int i = 1; i + 1 < count; i++)
        twice += vec2_cross(vec2_sub(points[vertex[(first + i) % all]], origin),
                            vec2_sub(points[vertex[(first + i + 1) % all]], origin));
    return 0.5 * twice;
}

enum { MOST_EDGES = BUILD_MAX_VERTICES / 2 };

// As a fan of chords from the first vertex; false, and no cells, where a part of it would be flat.
static bool add_fan(CellBuilder *builder, int region, const int *vertex, int count, int *capacity) {
    int part[MOST_EDGES];
    for (int adding = 0; adding < 2; adding++) {
        for (int next = 1, size; next + 1 < count; next += size - 2) {
            size = count - next + 1 < MOST_EDGES ? count - next + 1 : MOST_EDGES;
            part[0] = vertex[0];
            for (int i = 1; i < size; i++) part[i] = vertex[next + i - 1];
            if (adding)
                add_cell(builder, region, part, size, capacity);
            else if (size < count && part_area(builder, part, 0, size, size) < VIS_SLIVER)
                return false;
        }
    }
    return true;
}

// A piece with very many vertices (a round room, a long corridor) becomes several: a fan, or where so many vertices lie on one side that
// a part of it would be flat, halves with as many vertices each, cut along the first chord that has something on both its sides.
static void add_cell_piece(CellBuilder *builder, int region, const int *vertex, int count, int *capacity) {
    if (add_fan(builder, region, vertex, count, capacity)) return;
    int half = count / 2, k = 0;
    while (k + 1 < count && (part_area(builder, vertex, k, half + 1, count) < VIS_SLIVER ||
                             part_area(builder, vertex, k + half, count - half + 1, count) < VIS_SLIVER))
        k++;
    int *part = ARENA_ARRAY(builder->scratch, int, count);
    for (int i = 0; i <= half; i++) part[i] = vertex[(k + i) % count];
    add_cell_piece(builder, region, part, half + 1, capacity);
    for (int i = 0; i <= count - half; i++) part[i] = vertex[(k + half + i) % count];
    add_cell_piece(builder, region, part, count - half + 1, capacity);
}

// A region that is convex as it is, its vertices on the grid or off it.
static void add_whole(CellBuilder *builder, int region, int *capacity) {
    const Building *b = builder->building;
    Ring ring = b->rings[b->regions[region].first_ring];
    int *vertex = ARENA_ARRAY(builder->scratch, int, ring.point_count);
    for (int i = 0; i < ring.point_count; i++) vertex[i] = ring.first_point + i;
    add_cell_piece(builder, region, vertex, ring.point_count, capacity);
}

static bool few_enough(const CellBuilder *builder, Error *error) {
    const char *source = builder->building->source;
    return builder->graph->cell_count <= MAPS_MAX_CELLS ||
           error_set(error, "%s: its rooms make more than %d convex cells", source ? source : "building",
                     MAPS_MAX_CELLS);
}

static bool make_cells(CellBuilder *builder, Error *error) {
    const Building *b = builder->building;
    int capacity = 0;
    builder->graph->box = box_empty();
    for (int r = 0; r < b->region_count; r++) {
        const Region *region = &b->regions[r];
        if (!memory_within(error)) return false;
        if (!few_enough(builder, error)) return false;
        if (region_is_convex(b, region)) {
            add_whole(builder, r, &capacity);
            continue;
        }
        int *first = ARENA_ARRAY(builder->scratch, int, region->ring_count);
        int *size = ARENA_ARRAY(builder->scratch, int, region->ring_count);
        for (int i = 0; i < region->ring_count; i++) {
            first[i] = b->rings[region->first_ring + i].first_point;
            size[i] = b->rings[region->first_ring + i].point_count;
        }
        ConvexPieces pieces;
        Error reason;
        if (!convex_decompose(b->points, first, size, region->ring_count, builder->scratch, &pieces,
                              &reason)) {
            return error_set(error, "%s: region %d `%s`: %s", b->source ? b->source : "building", r,
                             region->name, reason.text);
        }
        for (int i = 0; i < pieces.count; i++) {
            add_cell_piece(builder, r, pieces.vertex + pieces.first[i], pieces.first[i + 1] - pieces.first[i],
                           &capacity);
        }
    }
    const char *source = b->source ? b->source : "building";
    if (builder->graph->cell_count == 0) return error_set(error, "%s: has no free space to walk in", source);
    return few_enough(builder, error);
}

bool build_regions(CellBuilder *builder, Error *error) {
    if (!make_cells(builder, error)) return false;
    build_portals(builder);
    build_surfaces(builder);
    return true;
}
