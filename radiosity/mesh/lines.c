// lines.c - finds the straight lines that bound faces: successive edges of an outline that are straight are one line, and so are
// edges between the same two vertices.
//
// Polygons crack at T-vertices: a wall that meets two other walls along its edge has a vertex in the middle of this edge, which
// in floats lies beside the line. If each part of the edge were a great circle of its own, samples beside the joint would fall
// between the faces; here one line decides all these samples.
#include "radiosity/mesh/lines.h"

#include <math.h>
#include <stdlib.h>

#include "engine/core/sets.h"

typedef struct Line {
    Vec3 point, along;  // a point of the line, and its unit direction
    int from, to;       // the vertices that the line goes through
} Line;

// An edge of an outline; `low` and `high` are its vertices in increasing order.
typedef struct OutlineEdge {
    int low, high, at;  // `at`: the index in Mesh.outline where the edge starts
} OutlineEdge;

typedef struct Finder {
    const Mesh *mesh;
    int *next;  // [outline_count] the next index in Mesh.outline, round the face
    // [outline_count] of the union-find forest over edges, each named by the index where it starts
    int *parent;
    bool *bent;  // [outline_count] for roots: the vertices of the set do not lie on one line
} Finder;

static int by_vertices(const void *a, const void *b) {
    const OutlineEdge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return x->at < y->at ? -1 : x->at > y->at;
}

static Vec3 vertex(const Finder *f, int at) { return f->mesh->vertices[f->mesh->outline[at]]; }

// The distance of p from the line through a and b.
static double off_line(Vec3 a, Vec3 b, Vec3 p) {
    Vec3 along = vec3_normalize(vec3_sub(b, a));
    return vec3_length(vec3_cross(along, vec3_sub(p, a)));
}

// Joins edges between the same two vertices.
static void join_shared(Finder *f, Arena *scratch) {
    int count = f->mesh->outline_count;
    OutlineEdge *edges = ARENA_ARRAY(scratch, OutlineEdge, count + 1);
    for (int i = 0; i < count; i++) {
        int p = f->mesh->outline[i], q = f->mesh->outline[f->next[i]];
        edges[i] = (OutlineEdge){p < q ? p : q, p < q ? q : p, i};
    }
    qsort(edges, (size_t)count, sizeof *edges, by_vertices);
    for (int i = 1; i < count; i++)
        if (edges[i].low == edges[i - 1].low && edges[i].high == edges[i - 1].high)
            set_unite(f->parent, edges[i].at, edges[i - 1].at);
}

// Joins successive edges of an outline that are straight.
static void join_straight(Finder *f) {
    for (int i = 0; i < f->mesh->outline_count; i++) {
        int j = f->next[i], k = f->next[j];
        Vec3 p = vertex(f, i), q = vertex(f, j), r = vertex(f, k);
        if (vec3_dot(vec3_sub(q, p), vec3_sub(r, q)) > 0 && off_line(p, r, q) < RAD_STRAIGHT)
            set_unite(f->parent, i, j);
    }
}

// Finds the line of each joined set: through the two vertices that are farthest apart along the set's root edge.
static void fit_lines(const Finder *f, Line *line, Arena *scratch) {
    int count = f->mesh->outline_count;
    double *low = ARENA_ARRAY(scratch, double, count + 1), *high = ARENA_ARRAY(scratch, double, count + 1);
    int *first = ARENA_ARRAY(scratch, int, count + 1), *last = ARENA_ARRAY(scratch, int, count + 1);
    for (int i = 0; i < count; i++) first[i] = last[i] = i;
    for (int i = 0; i < count; i++) {
        int root = set_find(f->parent, i);
        Vec3 from = vertex(f, root), along = vec3_sub(vertex(f, f->next[root]), from);
        for (int end = 0; end < 2; end++) {
            int at = end ? f->next[i] : i;
            double t = vec3_dot(along, vec3_sub(vertex(f, at), from));
            if (t < low[root]) low[root] = t, first[root] = at;
            if (t > high[root]) high[root] = t, last[root] = at;
        }
    }
    for (int i = 0; i < count; i++) {
        if (set_find(f->parent, i) != i) continue;
        Vec3 from = vertex(f, first[i]);
        line[i] = (Line){from, vec3_normalize(vec3_sub(vertex(f, last[i]), from)), f->mesh->outline[first[i]],
                         f->mesh->outline[last[i]]};
    }
}

// Splits bent sets, such as a round wall of many short edges, into their edges.
static void part_bent(Finder *f, const Line *line, Arena *scratch) {
    int count = f->mesh->outline_count;
    bool any = false;
    for (int i = 0; i < count; i++) {
        const Line *l = &line[set_find(f->parent, i)];
        for (int end = 0; end < 2; end++) {
            Vec3 p = vertex(f, end ? f->next[i] : i);
            if (vec3_length(vec3_cross(l->along, vec3_sub(p, l->point))) <= RAD_STRAIGHT) continue;
            f->bent[set_find(f->parent, i)] = any = true;
        }
    }
    if (!any) return;
    int *root = ARENA_ARRAY(scratch, int, count + 1);
    for (int i = 0; i < count; i++) root[i] = set_find(f->parent, i);
    for (int i = 0; i < count; i++)
        if (f->bent[root[i]]) f->parent[i] = i;
    // Sets that stay joined must not have parents that were parted: each edge points directly to its set's root.
    for (int i = 0; i < count; i++)
        if (!f->bent[root[i]]) f->parent[i] = root[i];
    Finder shared = *f;
    shared.parent = ARENA_ARRAY(scratch, int, count + 1);
    for (int i = 0; i < count; i++) shared.parent[i] = i;
    join_shared(&shared, scratch);
    for (int i = 0; i < count; i++)
        if (f->bent[root[i]]) f->parent[i] = set_find(shared.parent, i);
}

// The number by which FaceEdge names a vertex of Mesh.vertices.
static int name_of(const Mesh *mesh, const Face *face, int vertex) {
    for (int i = 0; i < face->vertex_count; i++)
        if (mesh->outline[face->first_vertex + i] == vertex) return i;
    return ~vertex;
}

static void add_edges(const Finder *f, const Line *lines, const int *number, FaceLines *out, Arena *scratch) {
    const Mesh *mesh = f->mesh;
    int *last_face =
        ARENA_ARRAY(scratch, int, out->line_count + 1);  // the last face that has the line, plus one
    for (int k = 0; k < mesh->face_count; k++) {
        const Face *face = &mesh->faces[k];
        out->first_edge[k] = out->edge_count;
        for (int i = face->first_vertex; i < face->first_vertex + face->vertex_count; i++) {
            int root = set_find(f->parent, i);
            if (last_face[number[root]] == k + 1) continue;
            last_face[number[root]] = k + 1;
            const Line *line = &lines[root];
            Vec3 step = vec3_sub(vertex(f, f->next[i]), vertex(f, i));
            int from = name_of(mesh, face, line->from), to = name_of(mesh, face, line->to);
            bool with = vec3_dot(step, line->along) > 0;
            out->edges[out->edge_count++] = (FaceEdge){with ? from : to, with ? to : from};
        }
        int edges = out->edge_count - out->first_edge[k];
        if (edges > out->most_edges) out->most_edges = edges;
    }
    out->first_edge[mesh->face_count] = out->edge_count;
}

// ---- borders of elements

// A vertex this near to the line of the side before it, in squares, begins no other line.
static const double STRAIGHT = 1e-9;

typedef struct GridPoint {
    double x, y;
} GridPoint;

static GridPoint on_grid(const Face *face, Vec3 point) {
    Vec3 p = vec3_sub(point, face->origin);
    return (GridPoint){vec3_dot(face->gx, p), vec3_dot(face->gy, p)};
}

// The side from p to q of an element that lies to the left of it, or to the right where the grid is turned over. The coefficients have unit
// length, so that `at` is in squares.
static ElementBorder border_along(GridPoint p, GridPoint q, double left) {
    double x = q.x - p.x, y = q.y - p.y, scale = left / fmax(sqrt(x * x + y * y), 1e-300);
    return (ElementBorder){-y * scale, x * scale, (x * p.y - y * p.x) * scale};
}

static void add_borders(const Mesh *mesh, int element, FaceLines *out) {
    const Element *e = &mesh->elements[element];
    const Face *face = &mesh->faces[e->face];
    const int *corner = mesh->corners + e->first_corner;
    double left = vec3_dot(face->plane.n, vec3_cross(face->gx, face->gy)) > 0 ? 1 : -1;
    int first = out->first_border[element], count = 0;
    for (int i = 0; i < e->corner_count; i++) {
        GridPoint p = on_grid(face, mesh->vertices[corner[i]]),
                  q = on_grid(face, mesh->vertices[corner[i + 1 < e->corner_count ? i + 1 : 0]]);
        const ElementBorder *last = &out->borders[first + count - 1];
        if (count > 0 && fabs(last->x * q.x + last->y * q.y - last->at) < STRAIGHT) continue;
        out->borders[first + count++] = border_along(p, q, left);
    }
    out->first_border[element + 1] = first + count;
}

static void find_borders(const Mesh *mesh, FaceLines *out, Arena *arena, Arena *scratch) {
    bool *shares = ARENA_ARRAY(scratch, bool, mesh->element_count + 1);
    int count = 0;
    for (int i = 0; i < mesh->square_count; i++) {
        int code = mesh->squares[i];
        const int *several = code < -1 ? mesh->shared + ~(code + 1) : NULL;
        for (int k = 1; code < -1 && k <= several[0]; k++) shares[several[k]] = true;
    }
    for (int e = 0; e < mesh->element_count; e++) count += shares[e] ? mesh->elements[e].corner_count : 0;
    out->borders = ARENA_ARRAY(arena, ElementBorder, count + 1);
    out->first_border = ARENA_ARRAY(arena, int, mesh->element_count + 1);
    for (int e = 0; e < mesh->element_count; e++) {
        out->first_border[e + 1] = out->first_border[e];
        if (shares[e]) add_borders(mesh, e, out);
    }
}

static bool is_inside(const FaceLines *lines, int element, GridPoint p) {
    const ElementBorder *border = lines->borders + lines->first_border[element],
                        *end = lines->borders + lines->first_border[element + 1];
    for (; border < end; border++)
        if (border->x * p.x + border->y * p.y < border->at) return false;
    return true;
}

int lines_element_at(const FaceLines *lines, const Mesh *mesh, int index, Vec3 point) {
    const Face *face = &mesh->faces[index];
    GridPoint p = on_grid(face, point);
    if (p.x >= 0 && p.x < face->nx && p.y >= 0 && p.y < face->ny) {
        int code = mesh->squares[face->first_square + (int)p.y * face->nx + (int)p.x];
        if (code >= 0) return code;
        const int *several = code < -1 ? mesh->shared + ~(code + 1) : NULL;
        for (int k = 1; code < -1 && k <= several[0]; k++)
            if (is_inside(lines, several[k], p)) return several[k];
    }
    return mesh_element_at(mesh, index, point);
}

FaceLines lines_of_mesh(const Mesh *mesh, Arena *arena) {
    Arena scratch = {0};
    int count = mesh->outline_count;
    Finder f = {.mesh = mesh,
                .next = ARENA_ARRAY(&scratch, int, count + 1),
                .parent = ARENA_ARRAY(&scratch, int, count + 1),
                .bent = ARENA_ARRAY(&scratch, bool, count + 1)};
    for (int k = 0; k < mesh->face_count; k++) {
        int first = mesh->faces[k].first_vertex, n = mesh->faces[k].vertex_count;
        for (int i = 0; i < n; i++) f.next[first + i] = first + (i + 1) % n;
    }
    for (int i = 0; i < count; i++) f.parent[i] = i;
    Line *line = ARENA_ARRAY(&scratch, Line, count + 1);
    join_shared(&f, &scratch);
    join_straight(&f);
    fit_lines(&f, line, &scratch);
    part_bent(&f, line, &scratch);
    fit_lines(&f, line, &scratch);
    FaceLines out = {.edges = ARENA_ARRAY(arena, FaceEdge, count + 1),
                     .first_edge = ARENA_ARRAY(arena, int, mesh->face_count + 1),
                     .face_count = mesh->face_count};
    int *number = ARENA_ARRAY(&scratch, int, count + 1);
    for (int i = 0; i < count; i++)
        if (set_find(f.parent, i) == i) number[i] = out.line_count++;
    add_edges(&f, line, number, &out, &scratch);
    find_borders(mesh, &out, arena, &scratch);
    arena_free(&scratch);
    return out;
}
