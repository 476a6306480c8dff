// nodes.c - sorts the corners of elements into nodes: corners are joined over every smooth edge (disjoint sets; Tarjan 1975), and
// each joined set of corners is a node. Elements have the vertices of their neighbours on their edges as corners, so neighbours
// share whole edges, and T-vertices need no special treatment.
#include "radiosity/mesh/nodes.h"

#include "engine/core/sets.h"

// Two planes are one if 1 - cosine of their normals is below this: the rounding of models with six digits.
static const double SAME_PLANE = 1e-6;
// A face that rises from an edge at an angle with more than this sine stands on the edge: light cannot pass along the surface there.
static const double STANDS = 1e-3;

// An edge of an element, from corner `from` to the next, `to`.
typedef struct Side {
    int element, from, to;
    int other_vertex;  // the higher index of its two vertices
    bool rising;       // the edge runs from the vertex of lower index to the one of higher index
} Side;

typedef struct Sides {
    int *first;  // [vertex_count + 1] in `side`, by the lower vertex of a side
    Side *side;  // [corner_count]
} Sides;

static int lower_vertex(const Mesh *mesh, const Side *side) {
    int a = mesh->corners[side->from], b = mesh->corners[side->to];
    return a < b ? a : b;
}

static Side side_at(const Mesh *mesh, int element, int k) {
    const Element *e = &mesh->elements[element];
    Side side = {element, e->first_corner + k, e->first_corner + (k + 1) % e->corner_count, 0, false};
    int a = mesh->corners[side.from], b = mesh->corners[side.to];
    side.other_vertex = a < b ? b : a;
    side.rising = a < b;
    return side;
}

static Sides sort_sides(const Mesh *mesh, Arena *arena) {
    Sides s = {ARENA_ARRAY(arena, int, mesh->vertex_count + 2), ARENA_ARRAY(arena, Side, mesh->corner_count)};
    // Counts are stored two places ahead and fills advance the entry one place ahead, so that `first` is right in the end.
    for (int pass = 0; pass < 2; pass++) {
        for (int e = 0; e < mesh->element_count; e++) {
            for (int k = 0; k < mesh->elements[e].corner_count; k++) {
                Side side = side_at(mesh, e, k);
                int lower = lower_vertex(mesh, &side);
                if (pass == 0)
                    s.first[lower + 2]++;
                else
                    s.side[s.first[lower + 1]++] = side;
            }
        }
        for (int v = 0; pass == 0 && v < mesh->vertex_count; v++) s.first[v + 2] += s.first[v + 1];
    }
    return s;
}

static const Face *face_of(const Mesh *mesh, int element) {
    return &mesh->faces[mesh->elements[element].face];
}

static bool one_surface(const Mesh *mesh, int e, int f) {
    const Face *a = face_of(mesh, e), *b = face_of(mesh, f);
    double cosine = vec3_dot(a->plane.n, b->plane.n);
    if (a->material != b->material) return false;
    if (cosine > 1 - SAME_PLANE) return true;
    return a->object == b->object && mesh->graph->objects[a->object].kind != OBJECT_SURFACE &&
           cosine > NODES_CURVED;
}

// Does any element but a's and b's rise from their common edge, on their front side?
static bool stood_upon(const Mesh *mesh, const Side *run, int count, const Side *a, const Side *b) {
    Vec3 up =
        vec3_normalize(vec3_add(face_of(mesh, a->element)->plane.n, face_of(mesh, b->element)->plane.n));
    for (int i = 0; i < count; i++) {
        const Side *s = &run[i];
        if (s->other_vertex != a->other_vertex || s->element == a->element || s->element == b->element)
            continue;
        Vec3 along = vec3_sub(mesh->vertices[mesh->corners[s->to]], mesh->vertices[mesh->corners[s->from]]);
        Vec3 inwards = vec3_cross(face_of(mesh, s->element)->plane.n, vec3_normalize(along));
        if (vec3_dot(inwards, up) > STANDS) return true;
    }
    return false;
}

// ---- sets of corners; the lowest corner is the root of its set, so that the nodes are in the order of the corners

// Joins the corners of smooth neighbours at their common edges. Neighbours run along their edge in opposite directions.
static void join_run(const Mesh *mesh, const Side *run, int count, int *up) {
    for (int i = 0; i < count; i++) {
        for (int j = i + 1; j < count; j++) {
            const Side *a = &run[i], *b = &run[j];
            if (a->other_vertex != b->other_vertex || a->rising == b->rising ||
                !one_surface(mesh, a->element, b->element) || stood_upon(mesh, run, count, a, b))
                continue;
            set_unite(up, a->from, b->to);
            set_unite(up, a->to, b->from);
        }
    }
}

static void number_nodes(const Mesh *mesh, int *up, Nodes *out) {
    for (int i = 0; i < mesh->corner_count; i++) {
        int root = set_find(up, i);
        out->of_corner[i] = root == i ? out->count++ : out->of_corner[root];
    }
}

static void fill_nodes(const Mesh *mesh, Nodes *out, Arena *arena) {
    out->vertex = ARENA_ARRAY(arena, int, out->count);
    out->normal = ARENA_ARRAY(arena, Vec3, out->count);
    out->first = ARENA_ARRAY(arena, int, out->count + 2);
    out->element = ARENA_ARRAY(arena, int, mesh->corner_count);
    for (int i = 0; i < mesh->corner_count; i++) {
        out->vertex[out->of_corner[i]] = mesh->corners[i];
        out->first[out->of_corner[i] + 2]++;
    }
    for (int n = 0; n < out->count; n++) out->first[n + 2] += out->first[n + 1];
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++) {
            int n = out->of_corner[i];
            out->element[out->first[n + 1]++] = e;
            out->normal[n] = vec3_add(out->normal[n], face_of(mesh, e)->plane.n);
        }
    }
    for (int n = 0; n < out->count; n++) out->normal[n] = vec3_normalize(out->normal[n]);
}

Nodes nodes_of(const Mesh *mesh, Arena *arena) {
    Arena scratch = {0};
    Nodes out = {.of_corner = ARENA_ARRAY(arena, int, mesh->corner_count)};
    Sides sides = sort_sides(mesh, &scratch);
    int *up = ARENA_ARRAY(&scratch, int, mesh->corner_count);
    for (int i = 0; i < mesh->corner_count; i++) up[i] = i;
    for (int v = 0; v < mesh->vertex_count; v++)
        join_run(mesh, sides.side + sides.first[v], sides.first[v + 1] - sides.first[v], up);
    number_nodes(mesh, up, &out);
    fill_nodes(mesh, &out, arena);
    arena_free(&scratch);
    return out;
}

void nodes_pose(Nodes *nodes, const Mesh *mesh) {
    for (int n = 0; n < nodes->count; n++) {
        const int *first = nodes->element + nodes->first[n], *end = nodes->element + nodes->first[n + 1];
        Vec3 sum = {0, 0, 0};
        if (mesh->graph->objects[face_of(mesh, *first)->object].leaf < 0) continue;
        for (const int *e = first; e < end; e++) sum = vec3_add(sum, face_of(mesh, *e)->plane.n);
        nodes->normal[n] = vec3_normalize(sum);
    }
}
