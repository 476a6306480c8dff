// enclose_regions.c - regions from columns: like spans of neighbouring faces become one prism, whose outline
// is traced as simple rings.
//
// Edges between equal columns are dissolved, then vertices in the middle of a straight line; every vertex left
// lies on the boundary of all regions that pass it, so that touching regions share their vertices.
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/enclose/enclose.h"

// A side of a wall that does not cover the face behind an edge counts for the edge when the side is this near, mm.
static const double SIDE_REACH = 30;
// Sides of walls that cover the face behind an edge are preferred to other sides by this distance, mm.
static const double COVER_BONUS = 100;

void enclose_push_point(Enclosure *e, Vec2 metres, int material) {
    Building *b = e->b;
    if (b->edge_capacity <= b->point_count) {
        // A reader may have added points of inlays without materials.
        int capacity = b->point_count * 2 + 64;
        int *larger = ARENA_ARRAY(e->arena, int, capacity);
        if (b->edge_material && b->edge_capacity)
            memcpy(larger, b->edge_material, sizeof(int) * (size_t)b->edge_capacity);
        b->edge_material = larger;
        b->edge_capacity = capacity;
    }
    b->edge_material[b->point_count] = material;
    *ARENA_APPEND(e->arena, b->points, b->point_count, b->point_capacity) = metres;
}

// ---- materials of edges

static double distance_to_segment(Vec2 p, Vec2 a, Vec2 b) {
    Vec2 d = vec2_sub(b, a), ap = vec2_sub(p, a);
    double t = vec2_dot(d, d) > 0 ? fmin(1, fmax(0, vec2_dot(ap, d) / vec2_dot(d, d))) : 0;
    return vec2_length(vec2_sub(ap, vec2_scale(d, t)));
}

static bool wall_covers(const Pass *pass, int wall, int face) {
    int low = pass->cover_first[face], high = pass->cover_first[face + 1];
    while (low < high) {
        int middle = (low + high) / 2;
        if (pass->cover_wall[middle] < wall)
            low = middle + 1;
        else
            high = middle;
    }
    return low < pass->cover_first[face + 1] && pass->cover_wall[low] == wall;
}

// Takes the points from the sketch: the wall's shape may lack repeated points, so that its sides count otherwise.
static void side_ends(const Enclosure *e, int wall, int side, Vec2 ends[2]) {
    const SketchWall *w = &e->sketch->walls[wall];
    ends[0] = enclose_local(e, e->sketch->points[w->first_point + side]);
    ends[1] = enclose_local(e, e->sketch->points[w->first_point + (side + 1) % w->point_count]);
}

static double distance_to_side(const Enclosure *e, Vec2 p, int wall, int side) {
    Vec2 ends[2];
    side_ends(e, wall, side, ends);
    return distance_to_segment(p, ends[0], ends[1]);
}

static void index_sides(Enclosure *e) {
    const Sketch *s = e->sketch;
    int count = 0;
    for (int i = 0; i < s->wall_count; i++) count += e->wall_bounds[i] ? s->walls[i].point_count : 0;
    Box *boxes = ARENA_ARRAY(e->scratch, Box, count);
    e->side_wall = ARENA_ARRAY(e->scratch, int, count);
    e->side_at = ARENA_ARRAY(e->scratch, int, count);
    count = 0;
    for (int i = 0; i < s->wall_count; i++) {
        for (int k = 0; e->wall_bounds[i] && k < s->walls[i].point_count; k++) {
            Vec2 ends[2];
            side_ends(e, i, k, ends);
            Vec2 low = vec2(fmin(ends[0].x, ends[1].x), fmin(ends[0].y, ends[1].y));
            Vec2 high = vec2(fmax(ends[0].x, ends[1].x), fmax(ends[0].y, ends[1].y));
            e->side_wall[count] = i;
            e->side_at[count] = k;
            boxes[count++] = enclose_box(low, high, s->walls[i].storey);
        }
    }
    e->side_tree = box_tree_build(boxes, count, e->scratch);
}

// The material of the side of a wall that lies behind half-edge h on one storey, or -1.
static int wall_side(Enclosure *e, int storey, int h) {
    const Plan *p = &e->pass.plan;
    const Sketch *s = e->sketch;
    Vec2 middle = vec2_scale(vec2_add(p->vertices[half_from(p, h)], p->vertices[half_to(p, h)]), 0.5);
    int best = -1, next = 0;
    double nearest = COVER_BONUS + SIDE_REACH;
    box_tree_find(&e->wall_tree, enclose_around(middle, SIDE_REACH, storey), e->scratch, &e->near);
    box_tree_find(&e->side_tree, enclose_around(middle, COVER_BONUS, storey), e->scratch, &e->sides);
    for (int found = 0; found < e->near.count; found++) {
        int i = e->near.items[found];
        bool covers = wall_covers(&e->pass, i, half_right(p, h));
        // All farther sides of a covering wall count as equally far: its first side stands for them.
        while (next < e->sides.count && e->side_wall[e->sides.items[next]] < i) next++;
        for (int k = covers ? 0 : -1;
             k >= 0 || (next < e->sides.count && e->side_wall[e->sides.items[next]] == i); k = -1) {
            int side = k >= 0 ? k : e->side_at[e->sides.items[next++]];
            double d = distance_to_side(e, middle, i, side);
            if (!covers)
                d = d > SIDE_REACH ? INFINITY : d + COVER_BONUS;
            else
                d = fmin(d, COVER_BONUS - 1);  // in a jamb the sides may be far
            if (d >= nearest) continue;
            nearest = d;
            best = s->edge_material ? s->edge_material[s->walls[i].first_point + side] : -1;
        }
    }
    return best;
}

static bool material_good(const Enclosure *e, int material) {
    return material >= 0 && material < e->b->material_count;
}

static int owner_material(const Enclosure *e, int room) {
    int material = room >= 0 && room < e->sketch->room_count ? e->sketch->rooms[room].wall_material : -1;
    return material_good(e, material) ? material : e->sketch->outer_material;
}

// The material of the surface behind half-edge h, seen from its left on `storey`; -1: seen from outdoors, any storey.
static int half_material(Enclosure *e, int storey, int h) {
    const Plan *p = &e->pass.plan;
    int outer = e->sketch->outer_material, right = half_right(p, h);
    if (right < 0) return outer;
    bool outdoors = storey < 0;
    for (int s = outdoors ? 0 : storey; s < (outdoors ? e->b->storey_count : storey + 1); s++) {
        const Spot *spot = spot_at(e, s, right);
        if (spot->wall == NO_WALL && spot->hole[0] < 0) continue;
        int side = wall_side(e, s, h);
        if (material_good(e, side)) return side;
        const Spot *left = half_left(p, h) >= 0 ? spot_at(e, s, half_left(p, h)) : NULL;
        if (!left || outdoors) return outer;
        if (left->hole[0] >= 0) return owner_material(e, spot->owner);
        return owner_material(e, left->indoor);
    }
    return outer;
}

// ---- dissolving

typedef struct Tracer {
    Enclosure *e;
    int *parent;        // [span_count] union of like spans
    bool *kept;         // [edge_count] the columns left and right differ
    bool *gone;         // [vertex_count] in the middle of a straight line
    int *material;      // [2 * edge_count][storey_count + 1] of kept edges, by storey + 1; 0: outdoors
    int *first, *list;  // spans of a root: list[first[r]] ..
    int *span_face;     // [span_count]
    int *next_out;      // scratch of tracing: [vertex_count] first boundary half out of a vertex, -1
    int *same_vertex;   // [2 * edge_count] next boundary half out of the same vertex
    int *stamp;         // [vertex_count] position in the loop being split, -1
} Tracer;

static bool columns_equal(const Enclosure *e, int f, int g) {
    if (f < 0 || g < 0) return false;
    int a = e->first_span[f], b = e->first_span[g], count = e->first_span[f + 1] - a;
    if (count != e->first_span[g + 1] - b) return false;
    for (int i = 0; i < count; i++) {
        if (!span_equal(&e->spans[a + i], &e->spans[b + i])) return false;
    }
    return true;
}

static int matching_span(const Enclosure *e, int span, int face) {
    if (face < 0) return -1;
    int i = face_span_above(e, face, e->spans[span].z0);
    return i < e->first_span[face + 1] && span_equal(&e->spans[span], &e->spans[i]) ? i : -1;
}

static void join_spans(Tracer *t) {
    Enclosure *e = t->e;
    const Plan *p = &e->pass.plan;
    for (int i = 0; i < e->span_count; i++) t->parent[i] = i;
    for (int i = 0; i < p->edge_count; i++) {
        int f = p->edges[i].face[0], g = p->edges[i].face[1];
        t->kept[i] = !columns_equal(e, f, g);
        if (f < 0 || g < 0) continue;
        for (int k = e->first_span[f]; k < e->first_span[f + 1]; k++) {
            int other = matching_span(e, k, g);
            if (other < 0) continue;
            set_unite(t->parent, k, other);
        }
    }
}

static void find_materials(Tracer *t) {
    Enclosure *e = t->e;
    int layers = e->b->storey_count + 1;
    for (int h = 0; h < 2 * e->pass.plan.edge_count; h++) {
        if (!t->kept[h >> 1]) continue;
        for (int s = 0; s < layers; s++)
            t->material[(size_t)h * (size_t)layers + (size_t)s] = half_material(e, s - 1, h);
    }
}

static bool same_materials(const Tracer *t, int h, int g) {
    size_t layers = (size_t)t->e->b->storey_count + 1;
    return memcmp(&t->material[(size_t)h * layers], &t->material[(size_t)g * layers], layers * sizeof(int)) ==
           0;
}

static void find_gone(Tracer *t) {
    const Plan *p = &t->e->pass.plan;
    int *degree = ARENA_ARRAY(t->e->scratch, int, p->vertex_count);
    int *in = ARENA_ARRAY(t->e->scratch, int, p->vertex_count),
        *out = ARENA_ARRAY(t->e->scratch, int, p->vertex_count);
    for (int i = 0; i < p->edge_count; i++) {
        if (!t->kept[i]) continue;
        for (int way = 0; way < 2; way++) {
            int v = p->edges[i].v[way], h = 2 * i + way;  // h leaves v
            if (degree[v]++ == 0)
                out[v] = h;
            else
                in[v] = h ^ 1;
        }
    }
    for (int v = 0; v < p->vertex_count; v++) {
        if (degree[v] != 2) continue;
        Vec2 a = p->vertices[half_from(p, in[v])], b = p->vertices[half_to(p, out[v])];
        t->gone[v] = orient2d(a, p->vertices[v], b) == 0 && same_materials(t, in[v], out[v]) &&
                     same_materials(t, in[v] ^ 1, out[v] ^ 1);
    }
}

// ---- tracing

typedef struct Loop {
    int *halves;
    int count;
    double area;  // twice, signed, mm^2
    int region;
} Loop;

typedef struct Loops {
    Loop *items;
    int count, capacity;
} Loops;

static double turn_between(Vec2 back, Vec2 out) {
    // Clockwise from `back` to `out`, in (0, 2 pi].
    double angle = -atan2(vec2_cross(back, out), vec2_dot(back, out));
    return angle > 0 ? angle : angle + 2 * M_PI;
}

// The boundary half-edge that follows h around the interior on its left.
static int next_half(const Tracer *t, int h) {
    const Plan *p = &t->e->pass.plan;
    int v = half_to(p, h), best = t->next_out[v];
    if (t->same_vertex[best] < 0) return best;
    Vec2 back = vec2_sub(p->vertices[half_from(p, h)], p->vertices[v]);
    double least = INFINITY;
    for (int out = t->next_out[v]; out >= 0; out = t->same_vertex[out]) {
        double turn = turn_between(back, vec2_sub(p->vertices[half_to(p, out)], p->vertices[v]));
        if (turn >= least) continue;
        least = turn;
        best = out;
    }
    return best;
}

static double loop_area(const Plan *p, const int *halves, int count) {
    double sum = 0;
    Vec2 o = p->vertices[half_from(p, halves[0])];
    for (int i = 1; i < count; i++) {
        sum += vec2_cross(vec2_sub(p->vertices[half_from(p, halves[i])], o),
                          vec2_sub(p->vertices[half_to(p, halves[i])], o));
    }
    return sum;
}

static void keep_loop(Tracer *t, const int *halves, int count, Loops *loops) {
    Loop *loop = ARENA_PUSH(t->e->scratch, loops->items, loops->count, loops->capacity);
    *loop =
        (Loop){ARENA_ARRAY(t->e->scratch, int, count), count, loop_area(&t->e->pass.plan, halves, count), -1};
    memcpy(loop->halves, halves, sizeof(int) * (size_t)count);
}

// Splits a loop wherever it comes back to a vertex.
static void split_loop(Tracer *t, const int *halves, int count, int *stack, Loops *loops) {
    const Plan *p = &t->e->pass.plan;
    int depth = 0;
    for (int i = 0; i < count; i++) {
        int v = half_from(p, halves[i]);
        if (t->stamp[v] >= 0) {
            int start = t->stamp[v];
            for (int k = start; k < depth; k++) t->stamp[half_from(p, stack[k])] = -1;
            keep_loop(t, stack + start, depth - start, loops);
            depth = start;
        }
        t->stamp[v] = depth;
        stack[depth++] = halves[i];
    }
    for (int k = 0; k < depth; k++) t->stamp[half_from(p, stack[k])] = -1;
    if (depth) keep_loop(t, stack, depth, loops);
}

// Traces all boundary loops of the spans of one root.
static void trace_root(Tracer *t, int root, int *boundary, int *loop, int *stack, bool *used, Loops *loops) {
    Enclosure *e = t->e;
    const Plan *p = &e->pass.plan;
    int count = 0;
    for (int i = t->first[root]; i < t->first[root + 1]; i++) {
        int span = t->list[i];
        const PlanFace *face = &p->faces[t->span_face[span]];
        for (int k = 0; k < face->half_count; k++) {
            int h = p->halves[face->first_half + k];
            if (matching_span(e, span, half_right(p, h)) < 0) boundary[count++] = h;
        }
    }
    for (int i = 0; i < count; i++) t->next_out[half_from(p, boundary[i])] = -1;
    for (int i = 0; i < count; i++) {
        int v = half_from(p, boundary[i]);
        t->same_vertex[boundary[i]] = t->next_out[v];
        t->next_out[v] = boundary[i];
        used[boundary[i]] = false;
    }
    for (int i = 0; i < count; i++) {
        int length = 0;
        for (int h = boundary[i]; !used[h]; h = next_half(t, h)) {
            used[h] = true;
            loop[length++] = h;
        }
        if (length) split_loop(t, loop, length, stack, loops);
    }
}

// ---- appending regions

// Outdoors the walls of all storeys stand above each other; from the lower side of its slab on a storey's wall has its own look.
static void append_bands(Tracer *t, int h, int edge) {
    Enclosure *e = t->e;
    Building *b = e->b;
    int right = half_right(&e->pass.plan, h), layers = b->storey_count + 1;
    if (right < 0) return;
    const int *material = &t->material[(size_t)h * (size_t)layers];
    int below = material[0];
    for (int s = 0; s < b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, right);
        if ((spot->wall == NO_WALL && spot->hole[0] < 0) || material[s + 1] == below) continue;
        below = material[s + 1];
        *ARENA_PUSH(e->arena, b->bands, b->band_count, b->band_capacity) =
            (EdgeBand){edge, b->storeys[s].floor - b->storeys[s].slab, below};
    }
}

static void append_ring(Tracer *t, const Loop *loop, const Span *span) {
    Enclosure *e = t->e;
    const Plan *p = &e->pass.plan;
    Building *b = e->b;
    Ring *ring = ARENA_PUSH(e->arena, b->rings, b->ring_count, b->ring_capacity);
    ring->first_point = b->point_count;
    size_t layers = (size_t)b->storey_count + 1;
    int layer = span->kind == SPAN_OUTDOORS ? 0 : span->storey + 1;
    for (int i = 0; i < loop->count; i++) {
        int h = loop->halves[i], v = half_from(p, h);
        if (t->gone[v]) continue;
        int material = t->material[(size_t)h * layers + (size_t)layer];
        if (span->kind == SPAN_SHAFT) material = e->sketch->slab_material;
        if (span->kind == SPAN_OUTDOORS) append_bands(t, h, b->point_count);
        enclose_push_point(e, enclose_metres(e, p->vertices[v]), material);
        b->rings[b->ring_count - 1].point_count++;
    }
}

// Sets the region's name and materials to those drawn, where they are valid.
static void describe_room(const Enclosure *e, const SketchRoom *room, Region *r) {
    r->name = arena_string(e->arena, room->name ? room->name : "");
    if (material_good(e, room->floor_material)) r->floor_material = room->floor_material;
    if (material_good(e, room->ceiling_material)) r->ceiling_material = room->ceiling_material;
}

static void describe_outdoors(const Enclosure *e, const Span *s, Region *r) {
    int terrace = s->id - e->b->material_count;
    if (terrace >= 0)
        describe_room(e, &e->sketch->rooms[terrace], r);
    else if (material_good(e, s->id))
        r->floor_material = s->id;
    r->storey = -1;
    r->ceiling_material = s->z1 >= e->top ? -1 : e->sketch->slab_material;
}

static void describe(const Enclosure *e, const Span *s, Region *r) {
    static const RegionKind kinds[] = {REGION_KINDS, REGION_ROOM, REGION_OUTDOORS, REGION_OPENING,
                                       REGION_SHAFT};
    const Sketch *k = e->sketch;
    *r = (Region){.kind = kinds[s->kind], .name = "", .storey = s->storey, .opening = -1};
    r->z0 = s->z0 / ENCLOSE_MM;
    r->z1 = s->z1 / ENCLOSE_MM;
    r->floor_material = r->ceiling_material = s->kind == SPAN_SHAFT ? k->slab_material : k->outer_material;
    if (s->kind == SPAN_ROOM && s->id < k->room_count) describe_room(e, &k->rooms[s->id], r);
    if (s->kind == SPAN_OUTDOORS) describe_outdoors(e, s, r);
    if (s->kind == SPAN_OPENING) {
        r->opening = e->holes[s->id / 2].opening;
        r->side = s->id % 2;
    }
}

static bool loop_contains(const Plan *p, const Loop *loop, Vec2 q) {
    bool inside = false;
    for (int i = 0; i < loop->count; i++) {
        Vec2 a = p->vertices[half_from(p, loop->halves[i])], b = p->vertices[half_to(p, loop->halves[i])];
        inside ^= ring_edge_is_crossed(a, b, q, RING_MULTIPLY_FIRST);
    }
    return inside;
}

// Whether a hole lies in an outer loop: the loop contains a point just beside one of the hole's edges.
static bool hole_in(const Plan *p, const Loop *hole, const Loop *outer) {
    int h = hole->halves[0];
    Vec2 a = p->vertices[half_from(p, h)], b = p->vertices[half_to(p, h)], d = vec2_sub(b, a);
    Vec2 left = vec2_scale(vec2(-d.y, d.x), 1e-3 / vec2_length(d));  // a micrometre: the grid keeps it clear
    return loop_contains(p, outer, vec2_add(vec2_scale(vec2_add(a, b), 0.5), left));
}

static void append_root(Tracer *t, int root, const Loops *loops) {
    Enclosure *e = t->e;
    Building *b = e->b;
    int outers = 0;
    for (int i = 0; i < loops->count; i++) outers += loops->items[i].area > 0;
    int region = -1;
    for (int i = 0; i < loops->count; i++) {
        const Loop *outer = &loops->items[i];
        if (outer->area <= 0) continue;
        region = b->region_count;
        Region described;
        describe(e, &e->spans[root], &described);
        described.first_ring = b->ring_count;
        append_ring(t, outer, &e->spans[root]);
        for (int k = 0; k < loops->count; k++) {
            const Loop *hole = &loops->items[k];
            if (hole->area < 0 && (outers == 1 || hole_in(&e->pass.plan, hole, outer)))
                append_ring(t, hole, &e->spans[root]);
        }
        described.ring_count = b->ring_count - described.first_ring;
        *ARENA_APPEND(e->arena, b->regions, b->region_count, b->region_capacity) = described;
    }
    for (int i = t->first[root]; i < t->first[root + 1]; i++) e->spans[t->list[i]].region = region;
}

static void group_spans(Tracer *t) {
    Enclosure *e = t->e;
    int n = e->span_count;
    t->first = ARENA_ARRAY(e->scratch, int, n + 2);
    t->list = ARENA_ARRAY(e->scratch, int, n + 1);
    t->span_face = ARENA_ARRAY(e->scratch, int, n + 1);
    for (int f = 0; f < e->pass.plan.face_count; f++) {
        for (int k = e->first_span[f]; k < e->first_span[f + 1]; k++) t->span_face[k] = f;
    }
    for (int i = 0; i < n; i++) t->first[set_find(t->parent, i) + 1]++;
    for (int i = 0; i < n; i++) t->first[i + 1] += t->first[i];
    int *at = ARENA_ARRAY(e->scratch, int, n + 1);
    memcpy(at, t->first, sizeof(int) * (size_t)n);
    for (int i = 0; i < n; i++) t->list[at[set_find(t->parent, i)]++] = i;
}

void regions_trace(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    Arena *a = e->scratch;
    size_t layers = (size_t)e->b->storey_count + 1;
    Tracer t = {.e = e,
                .parent = ARENA_ARRAY(a, int, e->span_count),
                .kept = ARENA_ARRAY(a, bool, p->edge_count),
                .gone = ARENA_ARRAY(a, bool, p->vertex_count),
                .material = ARENA_ARRAY(a, int, 2 * layers * (size_t)p->edge_count),
                .next_out = ARENA_ARRAY(a, int, p->vertex_count),
                .same_vertex = ARENA_ARRAY(a, int, 2 * p->edge_count),
                .stamp = ARENA_ARRAY(a, int, p->vertex_count)};
    for (int v = 0; v < p->vertex_count; v++) t.stamp[v] = -1;
    join_spans(&t);
    index_sides(e);
    find_materials(&t);
    find_gone(&t);
    group_spans(&t);
    int *boundary = ARENA_ARRAY(a, int, 2 * p->edge_count), *loop = ARENA_ARRAY(a, int, 2 * p->edge_count);
    int *stack = ARENA_ARRAY(a, int, 2 * p->edge_count);
    bool *used = ARENA_ARRAY(a, bool, 2 * p->edge_count);
    for (int root = 0; root < e->span_count; root++) {
        if (t.parent[root] != root || e->spans[root].kind == SPAN_SOLID) continue;
        Loops loops = {NULL, 0, 0};
        trace_root(&t, root, boundary, loop, stack, used, &loops);
        append_root(&t, root, &loops);
    }
}
