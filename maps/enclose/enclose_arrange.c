// enclose_arrange.c - the planar arrangement of many lines: snap rounding (J. Hobby, Practical segment intersection with finite
// precision output, 1999) and the faces between the rounded edges.
//
// A pixel is the unit square around a grid point, its lower and left sides included. Pixels of corners and crossings are hot; each
// segment goes through the middles of all hot pixels that it passes, and then no two edges cross. All coordinates are whole
// millimetres and all decisions are exact. What a segment becomes depends on the segments near it alone, so that time and memory grow
// with the lines. GEOS does the same for few lines, in which the order of faces must stay what it was.
#include <stdlib.h>

#include "maps/enclose/enclose.h"

// Products of three differences of coordinates, which are up to 2 * 10^11 mm.
__extension__ typedef __int128 Wide;

typedef struct GridPoint {
    int64_t x, y;
} GridPoint;

// a before b, by x, then y.
typedef struct Segment {
    GridPoint a, b;
} Segment;

static GridPoint grid_sub(GridPoint a, GridPoint b) { return (GridPoint){a.x - b.x, a.y - b.y}; }
static Wide grid_cross(GridPoint a, GridPoint b) { return (Wide)a.x * b.y - (Wide)a.y * b.x; }

static int compare_points(GridPoint a, GridPoint b) {
    return a.x != b.x ? (a.x > b.x) - (a.x < b.x) : (a.y > b.y) - (a.y < b.y);
}
static int by_point(const void *p, const void *q) {
    const GridPoint *a = p, *b = q;
    return compare_points(*a, *b);
}
static int by_segment(const void *p, const void *q) {
    const Segment *s = p, *t = q;
    int first = compare_points(s->a, t->a);
    return first ? first : compare_points(s->b, t->b);
}
static int by_edge(const void *p, const void *q) {
    uint64_t a = *(const uint64_t *)p, b = *(const uint64_t *)q;
    return (a > b) - (a < b);
}

// Sorts, and keeps one of each; returns how many are kept.
static int sort_once(void *items, int count, size_t size, int (*compare)(const void *, const void *)) {
    char *all = items;
    int kept = 0;
    qsort(all, (size_t)count, size, compare);
    for (int i = 0; i < count; i++) {
        char *item = all + (size_t)i * size;
        if (kept > 0 && compare(all + (size_t)(kept - 1) * size, item) == 0) continue;
        memmove(all + (size_t)kept++ * size, item, size);
    }
    return kept;
}

// ---- segments and hot pixels

static GridPoint grid_point(Vec2 p) {
    return (GridPoint){(int64_t)floor(p.x + 0.5), (int64_t)floor(p.y + 0.5)};
}

// Equal segments once.
static int gather_segments(const Line *lines, int line_count, Arena *arena, Segment **out) {
    int most = 0, count = 0;
    for (int i = 0; i < line_count; i++) most += lines[i].count;
    Segment *segments = ARENA_ARRAY(arena, Segment, most);
    for (int i = 0; i < line_count; i++) {
        const Line *line = &lines[i];
        for (int k = line->close ? 0 : 1; k < line->count; k++) {
            GridPoint a = grid_point(line->points[k > 0 ? k - 1 : line->count - 1]),
                      b = grid_point(line->points[k]);
            int order = compare_points(a, b);
            if (order) segments[count++] = order < 0 ? (Segment){a, b} : (Segment){b, a};
        }
    }
    *out = segments;
    return sort_once(segments, count, sizeof *segments, by_segment);
}

static Box segment_box(const Segment *s) {
    double y = (double)s->a.y, z = (double)s->b.y;
    return enclose_box(vec2((double)s->a.x, fmin(y, z)), vec2((double)s->b.x, fmax(y, z)), 0);
}

// The whole number nearest to n / d; of two the larger. d > 0.
static int64_t nearest_quotient(Wide n, Wide d) {
    Wide twice = 2 * n + d, by = 2 * d, whole = twice / by;
    return (int64_t)(whole - (twice % by < 0));
}

static bool on_two_sides(Wide a, Wide b) { return (a < 0 && b > 0) || (a > 0 && b < 0); }

// Whether the segments cross within both; ends that touch are hot anyway.
static bool segments_cross(const Segment *s, const Segment *t, GridPoint *at) {
    GridPoint d = grid_sub(s->b, s->a), g = grid_sub(t->b, t->a), between = grid_sub(t->a, s->a);
    if (!on_two_sides(grid_cross(d, between), grid_cross(d, grid_sub(t->b, s->a)))) return false;
    if (!on_two_sides(grid_cross(g, grid_sub(s->a, t->a)), grid_cross(g, grid_sub(s->b, t->a)))) return false;
    Wide n = grid_cross(between, g), m = grid_cross(d, g);
    if (m < 0) n = -n, m = -m;
    *at = (GridPoint){s->a.x + nearest_quotient(d.x * n, m), s->a.y + nearest_quotient(d.y * n, m)};
    return true;
}

// The middles of all hot pixels, sorted by x, then y.
static int find_hot_pixels(const Segment *segments, int count, Arena *arena, GridPoint **out) {
    Arena scratch = {0};
    Box *boxes = ARENA_ARRAY(&scratch, Box, count);
    BoxHits near = {0};
    GridPoint *hot = NULL, at;
    int hot_count = 0, capacity = 0;
    for (int i = 0; i < count; i++) boxes[i] = segment_box(&segments[i]);
    BoxTree tree = box_tree_build(boxes, count, &scratch);
    for (int i = 0; i < count; i++) {
        *ARENA_PUSH(arena, hot, hot_count, capacity) = segments[i].a;
        *ARENA_PUSH(arena, hot, hot_count, capacity) = segments[i].b;
        box_tree_find(&tree, boxes[i], &scratch, &near);
        for (int k = 0; k < near.count; k++) {
            if (near.items[k] > i && segments_cross(&segments[i], &segments[near.items[k]], &at))
                *ARENA_PUSH(arena, hot, hot_count, capacity) = at;
        }
    }
    arena_free(&scratch);
    *out = hot;
    return sort_once(hot, hot_count, sizeof *hot, by_point);
}

// Whether the segment passes the pixel around a point within the segment's bounding rectangle: the line through it does.
static bool passes_pixel(const Segment *s, GridPoint p) {
    GridPoint d = grid_sub(s->b, s->a);
    Wide rise = d.y, aside = 2 * grid_cross(d, grid_sub(p, s->a)), reach = d.x + (rise < 0 ? -rise : rise);
    // The line is on the pixel's boundary at one corner at most, of which the lower left one belongs to the pixel.
    return (aside < reach && -aside < reach) || aside == d.x - rise;
}

// The edges between hot pixels, as 2^32 * lower + higher index, sorted.
static int snap_segments(const Segment *segments, int count, const GridPoint *hot, int hot_count,
                         Arena *arena, uint64_t **out) {
    Arena scratch = {0};
    Box *boxes = ARENA_ARRAY(&scratch, Box, hot_count);
    BoxHits near = {0};
    uint64_t *edges = NULL;
    int edge_count = 0, capacity = 0;
    for (int i = 0; i < hot_count; i++) {
        Vec2 p = vec2((double)hot[i].x, (double)hot[i].y);
        boxes[i] = enclose_box(p, p, 0);
    }
    BoxTree tree = box_tree_build(boxes, hot_count, &scratch);
    for (int i = 0; i < count; i++) {
        const Segment *s = &segments[i];
        // In the order of hot pixels, which is that along a segment that rises, and, but for those of one x, along one that falls.
        int found = box_tree_find(&tree, segment_box(s), &scratch, &near), kept = 0;
        for (int k = 0; k < found; k++)
            if (passes_pixel(s, hot[near.items[k]])) near.items[kept++] = near.items[k];
        for (int k = 0, end; k < kept && s->b.y < s->a.y; k = end) {
            for (end = k + 1; end < kept && hot[near.items[end]].x == hot[near.items[k]].x;) end++;
            for (int low = k, high = end - 1; low < high; low++, high--) {
                int item = near.items[low];
                near.items[low] = near.items[high];
                near.items[high] = item;
            }
        }
        for (int k = 1; k < kept; k++) {
            int u = near.items[k - 1], v = near.items[k];
            *ARENA_PUSH(arena, edges, edge_count, capacity) =
                (uint64_t)(u < v ? u : v) << 32 | (uint64_t)(u < v ? v : u);
        }
    }
    arena_free(&scratch);
    *out = edges;
    return sort_once(edges, edge_count, sizeof *edges, by_edge);
}

// ---- rings: half-edges are as in Plan; the face is on the left

typedef struct Rings {
    const GridPoint *point;
    int (*ends)[2];  // [edge_count] lower vertex first
    bool *gone;      // [edge_count]
    int edge_count, vertex_count;
    int *first,
        *out;  // [vertex_count + 1] the half-edges out of vertex v: out[first[v]] .., counter-clockwise
    int *next,
        *ring;  // [2 * edge_count] the half-edge after this one along the face on its left; -1; its ring
    int ring_count;
} Rings;

static int ring_from(const Rings *r, int half) { return r->ends[half >> 1][half & 1]; }
static GridPoint ring_way(const Rings *r, int half) {
    return grid_sub(r->point[r->ends[half >> 1][~half & 1]], r->point[ring_from(r, half)]);
}

static bool turns_first(GridPoint a, GridPoint b) {
    bool low_a = a.y < 0 || (a.y == 0 && a.x < 0), low_b = b.y < 0 || (b.y == 0 && b.x < 0);
    return low_a != low_b ? low_b : grid_cross(a, b) > 0;
}

static void list_halves(Rings *r, Arena *arena) {
    r->first = ARENA_ARRAY(arena, int, r->vertex_count + 1);
    r->out = ARENA_ARRAY(arena, int, 2 * r->edge_count);
    for (int h = 0; h < 2 * r->edge_count; h++) r->first[ring_from(r, h) + 1]++;
    for (int v = 0; v < r->vertex_count; v++) r->first[v + 1] += r->first[v];
    int *end = ARENA_ARRAY(arena, int, r->vertex_count);
    for (int v = 0; v < r->vertex_count; v++) end[v] = r->first[v];
    for (int h = 0; h < 2 * r->edge_count; h++) {
        int v = ring_from(r, h), at = end[v]++;
        for (; at > r->first[v] && turns_first(ring_way(r, h), ring_way(r, r->out[at - 1])); at--)
            r->out[at] = r->out[at - 1];
        r->out[at] = h;
    }
}

// Takes away edges that end blind, until there are none.
static void drop_blind_edges(Rings *r, Arena *arena) {
    int *degree = ARENA_ARRAY(arena, int, r->vertex_count);
    for (int v = 0; v < r->vertex_count; v++) degree[v] = r->first[v + 1] - r->first[v];
    for (int start = 0; start < r->vertex_count; start++) {
        for (int v = start; degree[v] == 1;) {
            int at = r->first[v];
            while (r->gone[r->out[at] >> 1]) at++;
            r->gone[r->out[at] >> 1] = true;
            degree[v] = 0;
            v = ring_from(r, r->out[at] ^ 1);
            degree[v]--;
        }
    }
}

static void find_rings(Rings *r) {
    for (int h = 0; h < 2 * r->edge_count; h++) r->next[h] = r->ring[h] = -1;
    for (int v = 0; v < r->vertex_count; v++) {
        int first = -1, last = -1;
        for (int at = r->first[v]; at < r->first[v + 1]; at++) {
            int half = r->out[at];
            if (r->gone[half >> 1]) continue;
            if (first < 0) first = half;
            if (last >= 0) r->next[half ^ 1] = last;
            last = half;
        }
        if (first >= 0) r->next[first ^ 1] = last;
    }
    r->ring_count = 0;
    for (int h = 0; h < 2 * r->edge_count; h++) {
        if (r->gone[h >> 1] || r->ring[h] >= 0) continue;
        for (int k = h; r->ring[k] < 0; k = r->next[k]) r->ring[k] = r->ring_count;
        r->ring_count++;
    }
}

// Takes away edges that have the same face on both sides.
static bool drop_bridges(Rings *r) {
    bool any = false;
    for (int i = 0; i < r->edge_count; i++) {
        if (r->gone[i] || r->ring[2 * i] != r->ring[2 * i + 1]) continue;
        any = r->gone[i] = true;
    }
    return any;
}

// ---- holes: a ring around a part of the plan that hangs together lies in the face beside it

// The edge beside a point on the left, of those at heights a little above the point's; -1. Looks farther and farther.
static int edge_beside(const Rings *r, const BoxTree *tree, GridPoint p, double farthest, Arena *arena,
                       BoxHits *near) {
    int best = -1;
    Wide best_n = 0, best_d = 1;
    for (double reach = 1000; best < 0; reach *= 2) {
        Vec2 at = vec2((double)p.x, (double)p.y);
        box_tree_find(tree, enclose_box(vec2(at.x - reach, at.y), at, 0), arena, near);
        for (int k = 0; k < near->count; k++) {
            int edge = near->items[k];
            GridPoint a = r->point[r->ends[edge][0]], d = ring_way(r, 2 * edge);
            if (r->gone[edge] || (a.y > p.y) == (a.y + d.y > p.y)) continue;
            if (d.y < 0) a.x += d.x, a.y += d.y, d.x = -d.x, d.y = -d.y;
            // Where it is at this height: n / d.y from the point.
            Wide n = (Wide)(a.x - p.x) * d.y + (Wide)d.x * (p.y - a.y), gain = n * best_d - best_n * d.y;
            bool beside = n < 0 || (n == 0 && d.x < 0);
            if (!beside) continue;
            // The one that is farther right above it.
            GridPoint other = best < 0 ? d : ring_way(r, 2 * best);
            if (best >= 0 && other.y < 0) other = (GridPoint){-other.x, -other.y};
            if (best >= 0 && (gain < 0 || (gain == 0 && (Wide)d.x * other.y <= (Wide)other.x * d.y)))
                continue;
            best = edge, best_n = n, best_d = d.y;
        }
        // An edge at the border of the search may not be the nearest.
        if (best >= 0 && -best_n > (Wide)reach * best_d) best = -1;
        if (reach > farthest) break;
    }
    return best;
}

typedef struct HoleRing {
    int vertex, ring;  // its first vertex
} HoleRing;

static int by_vertex(const void *p, const void *q) {
    const HoleRing *a = p, *b = q;
    return (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

// face[ring]: of a ring with positive area its own, of others the one that they are cut out of, -1: none.
static void place_holes(const Rings *r, HoleRing *holes, int count, int *face) {
    Arena scratch = {0};
    Box *boxes = ARENA_ARRAY(&scratch, Box, r->edge_count);
    BoxHits near = {0};
    double farthest = r->vertex_count > 0 ? (double)(r->point[r->vertex_count - 1].x - r->point[0].x) : 0;
    qsort(holes, (size_t)count, sizeof *holes, by_vertex);
    for (int i = 0; i < r->edge_count; i++) {
        boxes[i] = r->gone[i] ? box_empty()
                              : segment_box(&(Segment){r->point[r->ends[i][0]], r->point[r->ends[i][1]]});
    }
    BoxTree tree = box_tree_build(boxes, r->edge_count, &scratch);
    for (int i = 0; i < count; i++) {
        int edge = edge_beside(r, &tree, r->point[holes[i].vertex], farthest, &scratch, &near);
        // The half-edge that goes down has its right neighbour on its left. Rings farther left have their faces already.
        bool down = edge >= 0 && ring_way(r, 2 * edge).y < 0;
        face[holes[i].ring] = edge < 0 ? -1 : face[r->ring[2 * edge + !down]];
    }
    arena_free(&scratch);
}

// A face's place along a curve through the plan that stays near where it was (G. Morton 1966): what is made of the plan keeps neighbours
// together.
typedef struct Stop {
    uint64_t key;
    int ring;
} Stop;

static int by_curve(const void *p, const void *q) {
    const Stop *a = p, *b = q;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->ring > b->ring) - (a->ring < b->ring);
}

static uint64_t curve_key(GridPoint p) {
    enum { BITS = 31 };
    uint64_t key = 0;
    for (int bit = 0; bit < BITS; bit++)
        key |= ((uint64_t)p.x >> bit & 1) << (2 * bit) | ((uint64_t)p.y >> bit & 1) << (2 * bit + 1);
    return key;
}

// Numbers the faces of rings with positive area; `vertex` is the first of each ring.
static int number_faces(const Rings *r, const Wide *twice, const int *vertex, int *face, Arena *arena) {
    Stop *stops = ARENA_ARRAY(arena, Stop, r->ring_count);
    int count = 0, shift = 0;
    GridPoint low = r->point[0], high = low;
    for (int v = 0; v < r->vertex_count; v++) {
        GridPoint p = r->point[v];
        low = (GridPoint){p.x < low.x ? p.x : low.x, p.y < low.y ? p.y : low.y};
        high = (GridPoint){p.x > high.x ? p.x : high.x, p.y > high.y ? p.y : high.y};
    }
    GridPoint size = grid_sub(high, low);
    while (size.x >> shift > INT32_MAX || size.y >> shift > INT32_MAX) shift++;
    for (int i = 0; i < r->ring_count; i++) {
        face[i] = -1;
        if (twice[i] <= 0) continue;
        GridPoint p = grid_sub(r->point[vertex[i]], low);
        stops[count++] = (Stop){curve_key((GridPoint){p.x >> shift, p.y >> shift}), i};
    }
    qsort(stops, (size_t)count, sizeof *stops, by_curve);
    for (int f = 0; f < count; f++) face[stops[f].ring] = f;
    return count;
}

static int *find_faces(const Rings *r, int *face_count, Arena *arena) {
    Wide *twice = ARENA_ARRAY(arena, Wide, r->ring_count);
    int *vertex = ARENA_ARRAY(arena, int, r->ring_count), *face = ARENA_ARRAY(arena, int, r->ring_count);
    HoleRing *holes = ARENA_ARRAY(arena, HoleRing, r->ring_count);
    int hole_count = 0;
    for (int i = 0; i < r->ring_count; i++) vertex[i] = r->vertex_count;
    for (int h = 0; h < 2 * r->edge_count; h++) {
        if (r->gone[h >> 1]) continue;
        int from = ring_from(r, h), ring = r->ring[h];
        twice[ring] += grid_cross(r->point[from], ring_way(r, h));
        if (from < vertex[ring]) vertex[ring] = from;
    }
    *face_count = r->vertex_count > 0 ? number_faces(r, twice, vertex, face, arena) : 0;
    for (int i = 0; i < r->ring_count; i++) {
        if (face[i] < 0) holes[hole_count++] = (HoleRing){vertex[i], i};
    }
    place_holes(r, holes, hole_count, face);
    return face;
}

// ---- the plan

static void write_plan(Enclosure *e, const Rings *r, const int *face, int face_count, Arena *scratch,
                       Plan *out) {
    int edges = 0, *number = ARENA_ARRAY(scratch, int, r->vertex_count);
    for (int i = 0; i < r->edge_count; i++) edges += !r->gone[i];
    *out = (Plan){.vertices = ARENA_ARRAY(e->scratch, Vec2, r->vertex_count),
                  .edges = ARENA_ARRAY(e->scratch, PlanEdge, edges),
                  .faces = ARENA_ARRAY(e->scratch, PlanFace, face_count),
                  .halves = ARENA_ARRAY(e->scratch, int, 2 * edges),
                  .face_count = face_count};
    for (int v = 0; v < r->vertex_count; v++) {
        number[v] = -1;
        for (int at = r->first[v]; at < r->first[v + 1] && number[v] < 0; at++)
            if (!r->gone[r->out[at] >> 1]) number[v] = out->vertex_count;
        if (number[v] >= 0)
            out->vertices[out->vertex_count++] = vec2((double)r->point[v].x, (double)r->point[v].y);
    }
    for (int i = 0; i < r->edge_count; i++) {
        if (r->gone[i]) continue;
        PlanEdge *edge = &out->edges[out->edge_count++];
        for (int k = 0; k < 2; k++) {
            edge->v[k] = number[r->ends[i][k]];
            edge->face[k] = face[r->ring[2 * i + k]];
        }
        for (int k = 0; k < 2; k++) {
            if (edge->face[k] < 0) continue;
            PlanFace *of = &out->faces[edge->face[k]];
            Vec2 a = out->vertices[edge->v[k]], b = out->vertices[edge->v[!k]];
            if (of->half_count++ == 0) of->inner = a;
            of->perimeter += vec2_length(vec2_sub(b, a));
            of->area += vec2_cross(vec2_sub(a, of->inner), vec2_sub(b, of->inner)) / 2;
        }
    }
    for (int f = 0; f < face_count; f++) {
        out->faces[f].first_half = out->half_count;
        out->half_count += out->faces[f].half_count;
        out->faces[f].half_count = 0;
    }
    for (int h = 0; h < 2 * out->edge_count; h++) {
        int f = out->edges[h >> 1].face[h & 1];
        if (f >= 0) out->halves[out->faces[f].first_half + out->faces[f].half_count++] = h;
    }
}

void plan_arrange(Enclosure *e, const Line *lines, int count, Plan *out) {
    Arena scratch = {0}, early = {0};
    Segment *segments;
    GridPoint *hot;
    uint64_t *keys;
    int segment_count = gather_segments(lines, count, &early, &segments),
        hot_count = find_hot_pixels(segments, segment_count, &scratch, &hot),
        edge_count = snap_segments(segments, segment_count, hot, hot_count, &early, &keys);
    Rings rings = {.point = hot,
                   .ends = arena_alloc(&scratch, (size_t)edge_count, sizeof *rings.ends),
                   .gone = ARENA_ARRAY(&scratch, bool, edge_count),
                   .next = ARENA_ARRAY(&scratch, int, 2 * edge_count),
                   .ring = ARENA_ARRAY(&scratch, int, 2 * edge_count),
                   .edge_count = edge_count,
                   .vertex_count = hot_count};
    for (int i = 0; i < edge_count; i++) {
        rings.ends[i][0] = (int)(keys[i] >> 32);
        rings.ends[i][1] = (int)(keys[i] & UINT32_MAX);
    }
    arena_free(&early);
    list_halves(&rings, &scratch);
    drop_blind_edges(&rings, &scratch);
    find_rings(&rings);
    if (drop_bridges(&rings)) find_rings(&rings);
    int face_count, *face = find_faces(&rings, &face_count, &scratch);
    write_plan(e, &rings, face, face_count, &scratch, out);
    arena_free(&scratch);
}
