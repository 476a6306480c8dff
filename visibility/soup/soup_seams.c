// soup_seams.c - where a corner of one polygon lies on an edge of another it becomes a corner of that too: a T-vertex lets
// sight through when it is rounded, and the objects seen there are behind a wall.
#include <stdlib.h>

#include "engine/core/error.h"
#include "visibility/soup/soup.h"

// How near an edge a corner lies on it, relative to the size: far above rounding, and no picture shows such a bend.
static const double ON_EDGE = 1e-7;
enum { LEAF = 8 };  // corners that are looked at one by one
// Edges that all run along one line hold each other's corners, by the square of their number: beyond so many, and so many for each
// corner there was, the rest of the edges stay as they are.
static const double FEW_HITS = 1e5, HITS_A_CORNER = 4;

// All corners, each once, as a k-d tree (Bentley 1975): of the run from lo to hi the middle one parts the others along
// axis[middle]. Corners come in crowds, plants beside walls, which no even grid parts.
typedef struct CornerTree {
    Vec3 *corners;
    unsigned char *axis;
    int count;
} CornerTree;

typedef struct Hit {
    double t;
    Vec3 p;
} Hit;

typedef struct Seams {
    CellBuilder *builder;
    CornerTree tree;
    double near;  // metres
    Hit *hits;    // on the edge looked at
    int hit_count, hit_capacity;
    double left;  // hits that there may still be
} Seams;

// Leaves of doors move: they share no seams.
static bool moves(const CellGraph *graph, int object) { return graph->objects[object].leaf >= 0; }

static int by_corner_place(const void *p, const void *q) {
    const Vec3 *a = p, *b = q;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return (a->z > b->z) - (a->z < b->z);
}

static void list_corners(CornerTree *tree, const CellGraph *graph, Arena *scratch) {
    tree->corners = ARENA_ARRAY(scratch, Vec3, graph->vertex_count);
    tree->axis = ARENA_ARRAY(scratch, unsigned char, graph->vertex_count);
    int count = 0;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = 0; !moves(graph, o) && p < object->polygon_count; p++) {
            const Polygon *polygon = &graph->polygons[object->first_polygon + p];
            for (int k = 0; k < polygon->vertex_count; k++)
                tree->corners[count++] = graph->vertices[polygon->first_vertex + k];
        }
    }
    if (count > 0) qsort(tree->corners, (size_t)count, sizeof *tree->corners, by_corner_place);
    for (int i = 0; i < count; i++) {
        if (i == 0 || !vec3_equal(tree->corners[i], tree->corners[tree->count - 1]))
            tree->corners[tree->count++] = tree->corners[i];
    }
}

// Puts the middle one by `axis` of the run into its middle, none greater before it and none smaller behind (Hoare 1961).
static void part_at_middle(Vec3 *corners, int lo, int hi, int axis) {
    int middle = (lo + hi) / 2;
    for (hi--; lo < hi;) {
        double pivot = vec3_component(corners[(lo + hi) / 2], axis);
        int i = lo, k = hi;
        while (i <= k) {
            while (vec3_component(corners[i], axis) < pivot) i++;
            while (vec3_component(corners[k], axis) > pivot) k--;
            if (i > k) break;
            Vec3 swapped = corners[i];
            corners[i++] = corners[k];
            corners[k--] = swapped;
        }
        if (middle <= k)
            hi = k;
        else if (middle >= i)
            lo = i;
        else
            return;
    }
}

static void part_corners(CornerTree *tree, int lo, int hi) {
    if (hi - lo <= LEAF) return;
    Box box = box_empty();
    for (int i = lo; i < hi; i++) box = box_add(box, tree->corners[i]);
    Vec3 size = vec3_sub(box.max, box.min);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2, middle = (lo + hi) / 2;
    part_at_middle(tree->corners, lo, hi, axis);
    tree->axis[middle] = (unsigned char)axis;
    part_corners(tree, lo, middle);
    part_corners(tree, middle + 1, hi);
}

static int along_edge(const void *p, const void *q) {
    const Hit *a = p, *b = q;
    if (a->t != b->t) return a->t < b->t ? -1 : 1;
    return by_corner_place(&a->p, &b->p);
}

// Takes the corner where it lies inside the edge.
static void hit_corner(Seams *s, Vec3 p, Vec3 a, Vec3 along, double length2) {
    Vec3 from = vec3_sub(p, a);
    double t = vec3_dot(from, along) / length2;
    Vec3 off = vec3_sub(from, vec3_scale(along, t));
    if (vec3_dot(off, off) > s->near * s->near) return;
    if (t * t * length2 <= s->near * s->near || (1 - t) * (1 - t) * length2 <= s->near * s->near) return;
    if (t <= 0 || t >= 1) return;
    *ARENA_PUSH(s->builder->scratch, s->hits, s->hit_count, s->hit_capacity) = (Hit){t, p};
}

// The corners of a run along the part of the edge from t0 to t1.
static void hit_run(Seams *s, int lo, int hi, Vec3 a, Vec3 along, double t0, double t1) {
    const CornerTree *tree = &s->tree;
    double length2 = vec3_dot(along, along);
    if (hi - lo <= LEAF) {
        for (int i = lo; i < hi; i++) hit_corner(s, tree->corners[i], a, along, length2);
        return;
    }
    int middle = (lo + hi) / 2, axis = tree->axis[middle];
    double at = vec3_component(tree->corners[middle], axis), from = vec3_component(a, axis),
           slope = vec3_component(along, axis), begin = from + slope * t0, end = from + slope * t1;
    hit_corner(s, tree->corners[middle], a, along, length2);
    // Twice: the ends are rounded.
    double low = at - 2 * s->near, high = at + 2 * s->near;
    if (fmin(begin, end) <= high) {
        double t = (high - from) / slope;
        hit_run(s, lo, middle, a, along, begin > high ? fmax(t0, t) : t0, end > high ? fmin(t1, t) : t1);
    }
    if (fmax(begin, end) >= low) {
        double t = (low - from) / slope;
        hit_run(s, middle + 1, hi, a, along, begin < low ? fmax(t0, t) : t0, end < low ? fmin(t1, t) : t1);
    }
}

// The corners inside an edge, in order along it, each once.
static void hit_edge(Seams *s, Vec3 a, Vec3 b) {
    s->hit_count = 0;
    if (s->left <= 0) return;
    hit_run(s, 0, s->tree.count, a, vec3_sub(b, a), 0, 1);
    s->left -= s->hit_count;
    if (s->hit_count > 1) qsort(s->hits, (size_t)s->hit_count, sizeof *s->hits, along_edge);
    int kept = 0;
    for (int i = 0; i < s->hit_count; i++) {
        if (kept == 0 || vec3_length(vec3_sub(s->hits[i].p, s->hits[kept - 1].p)) > s->near)
            s->hits[kept++] = s->hits[i];
    }
    s->hit_count = kept;
}

static void add_vertex(CellBuilder *builder, Vec3 p) {
    CellGraph *graph = builder->graph;
    *ARENA_PUSH(builder->arena, graph->vertices, graph->vertex_count, builder->vertex_capacity) = p;
}

void soup_close_seams(const Soup *soup) {
    CellBuilder *builder = soup->builder;
    CellGraph *graph = builder->graph;
    Seams s = {.builder = builder, .near = ON_EDGE * soup->size};
    s.left = FEW_HITS + HITS_A_CORNER * graph->vertex_count;
    list_corners(&s.tree, graph, builder->scratch);
    part_corners(&s.tree, 0, s.tree.count);
    const Vec3 *old = graph->vertices;
    graph->vertices = NULL;
    graph->vertex_count = builder->vertex_capacity = 0;
    for (int o = 0; o < graph->object_count; o++) {
        for (int i = 0; i < graph->objects[o].polygon_count; i++) {
            Polygon *p = &graph->polygons[graph->objects[o].first_polygon + i];
            const Vec3 *v = old + p->first_vertex;
            int corners = p->vertex_count;
            p->first_vertex = graph->vertex_count;
            for (int k = 0; k < corners; k++) {
                add_vertex(builder, v[k]);
                if (moves(graph, o)) continue;
                hit_edge(&s, v[k], v[(k + 1) % corners]);
                for (int h = 0; h < s.hit_count; h++) add_vertex(builder, s.hits[h].p);
            }
            p->vertex_count = graph->vertex_count - p->first_vertex;
        }
    }
}
