// soup_seams.c - where a corner of one polygon lies on an edge of another it becomes a corner of that too: a T-vertex lets
// sight through when it is rounded, and what is seen there is behind a wall.
#include <stdlib.h>

#include "engine/core/error.h"
#include "visibility/soup.h"

// How near an edge a corner lies on it, relative to the size: far above rounding, and no picture shows such a bend.
static const double ON_EDGE = 1e-7;
enum { MOST_CUBES = 96 };  // along a side

// All corners by the cubes of a grid: run c is corners[first[c]] .. corners[first[c + 1] - 1].
typedef struct CornerGrid {
    Vec3 origin;
    double side;
    int n[3];
    int *first;
    Vec3 *corners;
} CornerGrid;

typedef struct Hit {
    double t;
    Vec3 p;
} Hit;

typedef struct Seams {
    CellBuilder *builder;
    CornerGrid grid;
    double near;  // metres
    Hit *hits;    // on the edge looked at
    int hit_count, hit_capacity;
} Seams;

static int cube_along(const CornerGrid *grid, int axis, double at) {
    double c = floor(at / grid->side);
    return c < 0 ? 0 : c >= grid->n[axis] ? grid->n[axis] - 1 : (int)c;
}

static int cube_of(const CornerGrid *grid, Vec3 p) {
    Vec3 at = vec3_sub(p, grid->origin);
    return (cube_along(grid, 2, at.z) * grid->n[1] + cube_along(grid, 1, at.y)) * grid->n[0] +
           cube_along(grid, 0, at.x);
}

// Leaves of doors move: they share no seams.
static bool moves(const CellGraph *graph, int object) { return graph->objects[object].leaf >= 0; }

static void enter_corners(CornerGrid *grid, const CellGraph *graph, int *fill) {
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = 0; !moves(graph, o) && p < object->polygon_count; p++) {
            const Polygon *polygon = &graph->polygons[object->first_polygon + p];
            for (int k = 0; k < polygon->vertex_count; k++) {
                Vec3 corner = graph->vertices[polygon->first_vertex + k];
                int cube = cube_of(grid, corner);
                if (!fill) grid->first[cube + 1]++;
                if (fill) grid->corners[fill[cube]++] = corner;
            }
        }
    }
}

static CornerGrid lay_grid(const CellGraph *graph, Arena *scratch) {
    Box box = box_empty();
    for (int i = 0; i < graph->vertex_count; i++) box = box_add(box, graph->vertices[i]);
    Vec3 size = vec3_sub(box.max, box.min);
    double longest = fmax(size.x, fmax(size.y, size.z));
    CornerGrid grid = {.origin = box.min};
    grid.side = longest / fmin(MOST_CUBES, 1 + cbrt(graph->vertex_count));
    const double extent[3] = {size.x, size.y, size.z};
    for (int k = 0; k < 3; k++) grid.n[k] = (int)fmin(MOST_CUBES, floor(extent[k] / grid.side) + 1);
    int cubes = grid.n[0] * grid.n[1] * grid.n[2];
    grid.first = ARENA_ARRAY(scratch, int, cubes + 1);
    enter_corners(&grid, graph, NULL);
    for (int c = 0; c < cubes; c++) grid.first[c + 1] += grid.first[c];
    grid.corners = ARENA_ARRAY(scratch, Vec3, grid.first[cubes]);
    int *fill = ARENA_ARRAY(scratch, int, cubes);
    memcpy(fill, grid.first, (size_t)cubes * sizeof *fill);
    enter_corners(&grid, graph, fill);
    return grid;
}

static int along_edge(const void *p, const void *q) {
    const Hit *a = p, *b = q;
    return (a->t > b->t) - (a->t < b->t);
}

// The corners of a cube that lie inside the edge.
static void hit_cube(Seams *s, int cube, Vec3 a, Vec3 b) {
    Vec3 along = vec3_sub(b, a);
    double length2 = vec3_dot(along, along);
    for (int i = s->grid.first[cube]; i < s->grid.first[cube + 1]; i++) {
        Vec3 p = s->grid.corners[i], from = vec3_sub(p, a);
        double t = vec3_dot(from, along) / length2;
        Vec3 off = vec3_sub(from, vec3_scale(along, t));
        if (vec3_dot(off, off) > s->near * s->near) continue;
        if (t * t * length2 <= s->near * s->near || (1 - t) * (1 - t) * length2 <= s->near * s->near)
            continue;
        if (t <= 0 || t >= 1) continue;
        *ARENA_PUSH(s->builder->scratch, s->hits, s->hit_count, s->hit_capacity) = (Hit){t, p};
    }
}

// The corners inside an edge, in order along it, each once.
static void hit_edge(Seams *s, Vec3 a, Vec3 b) {
    const CornerGrid *grid = &s->grid;
    int steps = 1 + (int)(vec3_length(vec3_sub(b, a)) / grid->side);
    s->hit_count = 0;
    for (int i = 0; i < steps; i++) {
        Box box = box_add(box_add(box_empty(), vec3_lerp(a, b, (double)i / steps)),
                          vec3_lerp(a, b, (double)(i + 1) / steps));
        Vec3 low = vec3_sub(box_grow(box, s->near).min, grid->origin),
             high = vec3_sub(box_grow(box, s->near).max, grid->origin);
        for (int z = cube_along(grid, 2, low.z); z <= cube_along(grid, 2, high.z); z++) {
            for (int y = cube_along(grid, 1, low.y); y <= cube_along(grid, 1, high.y); y++) {
                for (int x = cube_along(grid, 0, low.x); x <= cube_along(grid, 0, high.x); x++)
                    hit_cube(s, (z * grid->n[1] + y) * grid->n[0] + x, a, b);
            }
        }
    }
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
    Seams s = {.builder = builder, .grid = lay_grid(graph, builder->scratch), .near = ON_EDGE * soup->size};
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
