// portals.c - where two cells touch, one sees from one into the other.
//
// Vertical contacts: regions share their plan vertices where they touch (building.h), so two cells touch along an
// edge iff one has it as a -> b and the other as b -> a; the portal spans the heights they have in common.
// Horizontal contacts: the ceiling of one cell at the height of the floor of another, where their plans overlap.
#include <stdlib.h>
#include <string.h>

#include "engine/core/polygon.h"
#include "visibility/cells/build.h"

typedef struct PlanEdge {
    Vec2 a, b;  // a is the lexicographically smaller end
    int cell, edge;
} PlanEdge;

static int compare_points(Vec2 a, Vec2 b) {
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    return (a.y > b.y) - (a.y < b.y);
}

static int by_ends(const void *p, const void *q) {
    const PlanEdge *a = p, *b = q;
    int order = compare_points(a->a, b->a);
    if (order == 0) order = compare_points(a->b, b->b);
    if (order == 0) order = (a->edge > b->edge) - (a->edge < b->edge);
    return order;
}

static Portal *add_portal(CellBuilder *builder, const Vec3 *vertices, int count) {
    CellGraph *graph = builder->graph;
    Portal *portal =
        ARENA_APPEND(builder->arena, graph->portals, graph->portal_count, builder->portal_capacity);
    *portal = (Portal){.first_vertex = graph->portal_vertex_count,
                       .vertex_count = count,
                       .plane = plane_of_polygon(vertices, count),
                       .door = -1};
    for (int i = 0; i < count; i++) {
        *ARENA_APPEND(builder->arena, graph->portal_vertices, graph->portal_vertex_count,
                      builder->portal_vertex_capacity) = vertices[i];
    }
    return portal;
}

// The door that fills region `r` closes all its contacts with other regions.
static bool is_filled(const Building *b, const Region *r, const Region *beyond) {
    if (r->opening < 0 || r->opening == beyond->opening) return false;
    const Opening *opening = &b->openings[r->opening];
    return opening->kind == OPENING_DOOR && opening->fills && !opening->glazed;
}

// The halves of a door meet at its leaf. Of two doors that fill neighbours one is enough: the other is closed at its own
// contacts farther on.
static int door_between(const Building *b, const Cell *p, const Cell *q) {
    const Region *r = &b->regions[p->region], *s = &b->regions[q->region];
    if (is_filled(b, r, s)) return r->opening;
    if (is_filled(b, s, r)) return s->opening;
    if (r->opening < 0 || r->opening != s->opening || r->side == s->side) return -1;
    const Opening *opening = &b->openings[r->opening];
    return opening->kind == OPENING_DOOR && !opening->glazed ? r->opening : -1;
}

// `e` runs along its cell counter-clockwise, so seen from inside, walking out, its start is on the right.
static void add_vertical(CellBuilder *builder, const PlanEdge *e, const PlanEdge *f) {
    CellGraph *graph = builder->graph;
    const Cell *p = &graph->cells[e->cell], *q = &graph->cells[f->cell];
    double z0 = fmax(p->z0, q->z0), z1 = fmin(p->z1, q->z1);
    if (z0 >= z1) return;
    int first = p->first_edge, next = first + (e->edge - first + 1) % p->edge_count;
    Vec2 a = graph->plan[e->edge], b = graph->plan[next];
    // Counter-clockwise from inside, where a is on the right and b on the left.
    Vec3 quad[4] = {vec3(a.x, a.y, z0), vec3(a.x, a.y, z1), vec3(b.x, b.y, z1), vec3(b.x, b.y, z0)};
    Portal *portal = add_portal(builder, quad, 4);
    portal->cell[0] = e->cell;
    portal->cell[1] = f->cell;
    portal->left = b;
    portal->right = a;
    portal->door = door_between(builder->building, p, q);
}

// An edge of a stack by the foot of its cell, and a pair of edges that share heights.
typedef struct Foot {
    double z;
    int edge;
} Foot;
typedef struct EdgePair {
    int first, second;
} EdgePair;
typedef struct Stack {
    Foot *feet;
    EdgePair *pairs;
    int foot_capacity, pair_capacity;
} Stack;

static int by_foot(const void *p, const void *q) {
    const Foot *a = p, *b = q;
    if (a->z != b->z) return a->z < b->z ? -1 : 1;
    return (a->edge > b->edge) - (a->edge < b->edge);
}

static int by_edges(const void *p, const void *q) {
    const EdgePair *a = p, *b = q;
    if (a->first != b->first) return a->first < b->first ? -1 : 1;
    return (a->second > b->second) - (a->second < b->second);
}

// The portals of cells that stand over one another along one line of the plan: in a tower these are many, of which few share heights.
static void add_stack(CellBuilder *builder, const PlanEdge *edges, int count, Stack *stack) {
    const CellGraph *graph = builder->graph;
    int feet = 0, pairs = 0;
    if (count < 2) return;
    for (int i = 0; i < count; i++)
        *ARENA_APPEND(builder->scratch, stack->feet, feet, stack->foot_capacity) =
            (Foot){graph->cells[edges[i].cell].z0, i};
    qsort(stack->feet, (size_t)count, sizeof *stack->feet, by_foot);
    for (int i = 0; i < count; i++) {
        int low = stack->feet[i].edge;
        double top = graph->cells[edges[low].cell].z1;
        for (int k = i + 1; k < count && stack->feet[k].z < top; k++) {
            int high = stack->feet[k].edge;
            if (vec2_equal(graph->plan[edges[low].edge], graph->plan[edges[high].edge]))
                continue;  // the same way
            *ARENA_APPEND(builder->scratch, stack->pairs, pairs, stack->pair_capacity) =
                low < high ? (EdgePair){low, high} : (EdgePair){high, low};
        }
    }
    if (pairs > 1) qsort(stack->pairs, (size_t)pairs, sizeof *stack->pairs, by_edges);
    for (int i = 0; i < pairs; i++)
        add_vertical(builder, &edges[stack->pairs[i].first], &edges[stack->pairs[i].second]);
}

static void add_verticals(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    PlanEdge *edges = ARENA_ARRAY(builder->scratch, PlanEdge, graph->plan_count);
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        for (int i = 0; i < cell->edge_count; i++) {
            Vec2 a = graph->plan[cell->first_edge + i];
            Vec2 b = graph->plan[cell->first_edge + (i + 1) % cell->edge_count];
            bool swap = compare_points(a, b) > 0;
            edges[cell->first_edge + i] = (PlanEdge){swap ? b : a, swap ? a : b, c, cell->first_edge + i};
        }
    }
    qsort(edges, (size_t)graph->plan_count, sizeof *edges, by_ends);
    Stack stack = {0};
    for (int i = 0, next; i < graph->plan_count; i = next) {
        next = i + 1;
        while (next < graph->plan_count && vec2_equal(edges[i].a, edges[next].a) &&
               vec2_equal(edges[i].b, edges[next].b))
            next++;
        add_stack(builder, edges + i, next - i, &stack);
    }
}

// The plan overlap of two convex cells at height z, counter-clockwise from above; its vertex count.
static int overlap(const CellGraph *graph, const Cell *p, const Cell *q, double z,
                   Vec3 out[BUILD_MAX_VERTICES]) {
    Vec3 buffer[BUILD_MAX_VERTICES];
    int count = cell_polygon(graph, p, z, out);
    for (int i = 0; i < q->edge_count && count > 0; i++) {
        Vec2 a = graph->plan[q->first_edge + i], b = graph->plan[q->first_edge + (i + 1) % q->edge_count];
        Vec3 n = vec3_normalize(vec3(a.y - b.y, b.x - a.x, 0));
        count = polygon_clip(out, count, (Plane){n, n.x * a.x + n.y * a.y}, 0, buffer);
        memcpy(out, buffer, (size_t)count * sizeof *out);
    }
    return count;
}

static void add_horizontal(CellBuilder *builder, int lower, int upper) {
    CellGraph *graph = builder->graph;
    Vec3 polygon[BUILD_MAX_VERTICES];
    int count = overlap(graph, &graph->cells[upper], &graph->cells[lower], graph->cells[upper].z0, polygon);
    if (count < 3) return;
    if (polygon_area(polygon, count) < VIS_SLIVER) {
        // Two cells whose plans merely share an edge overlap in rounding noise only.
        return;
    }
    Portal *portal = add_portal(builder, polygon, count);
    portal->cell[0] = upper;
    portal->cell[1] = lower;
    portal->horizontal = true;
    portal->door = door_between(builder->building, &graph->cells[upper], &graph->cells[lower]);
}

typedef struct Level {
    double z, x0, x1;
    int cell;
} Level;

static int by_level(const void *p, const void *q) {
    const Level *a = p, *b = q;
    if (a->z != b->z) return a->z < b->z ? -1 : 1;
    if (a->x0 != b->x0) return a->x0 < b->x0 ? -1 : 1;
    return (a->cell > b->cell) - (a->cell < b->cell);
}

static void add_horizontals(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    int count = graph->cell_count;
    Level *floors = ARENA_ARRAY(builder->scratch, Level, count);
    for (int c = 0; c < count; c++) {
        const Cell *cell = &graph->cells[c];
        floors[c] = (Level){cell->z0, cell->box.min.x, cell->box.max.x, c};
    }
    qsort(floors, (size_t)count, sizeof *floors, by_level);
    for (int c = 0; c < count; c++) {
        const Cell *lower = &graph->cells[c];
        int low = 0, high = count;  // the first floor at the height of this ceiling
        while (low < high) {
            int middle = (low + high) / 2;
            if (floors[middle].z < lower->z1) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        for (int i = low; i < count && floors[i].z == lower->z1 && floors[i].x0 < lower->box.max.x; i++) {
            const Cell *upper = &graph->cells[floors[i].cell];
            if (floors[i].x1 <= lower->box.min.x || upper->box.min.y >= lower->box.max.y ||
                upper->box.max.y <= lower->box.min.y) {
                continue;
            }
            add_horizontal(builder, c, floors[i].cell);
        }
    }
}

void build_portals(CellBuilder *builder) {
    add_verticals(builder);
    add_horizontals(builder);
    list_ways(builder);
}
