// orient.c - faces of a shell turned so that neighbours run along their common edges in opposite directions. Files contradict themselves
// about the sides of curved faces: their loops, their senses and their surfaces' normals tell each something else.
#include <stdint.h>
#include <stdlib.h>

#include "maps/ifc/shape.h"

// An edge of a face's outline: `key` is the same for both directions, `forwards` tells which it is.
typedef struct Edge {
    uint64_t key;
    int group;
    bool forwards;
} Edge;

static uint64_t mix(uint64_t h, double x) {
    // A tenth of a millimetre: corners of neighbours differ by rounding alone.
    h = (h ^ (uint64_t)(int64_t)llround(x * 1e4)) * 0x9E3779B97F4A7C15u;
    return h ^ (h >> 29);
}

static uint64_t place_key(Vec3 p) { return mix(mix(mix(0, p.x), p.y), p.z); }

static int compare_edges(const void *a, const void *b) {
    const Edge *p = a, *q = b;
    if (p->key != q->key) return p->key < q->key ? -1 : 1;
    return p->group < q->group ? -1 : p->group > q->group;
}

// Groups that are joined, each by its parent, and whether it is turned against it.
typedef struct Group {
    int parent, polygons;
    bool turned;
} Group;

static int root_of(Group *groups, int g, bool *turned) {
    *turned = false;
    while (groups[g].parent != g) {
        *turned ^= groups[g].turned;
        g = groups[g].parent;
    }
    return g;
}

static void join(Group *groups, int a, int b, bool turned) {
    bool turned_a, turned_b;
    a = root_of(groups, a, &turned_a);
    b = root_of(groups, b, &turned_b);
    if (a == b) return;
    // The smaller one under the larger one keeps ways short.
    if (groups[a].polygons > groups[b].polygons) {
        int keep = a;
        a = b;
        b = keep;
    }
    groups[a].parent = b;
    groups[a].turned = turned ^ turned_a ^ turned_b;
    groups[b].polygons += groups[a].polygons;
}

static Edge edge_of(Vec3 from, Vec3 to, int group) {
    uint64_t a = place_key(from), b = place_key(to);
    return (Edge){(a < b ? a : b) * 31 + (a < b ? b : a), group, a < b};
}

// Joins groups that have an edge for themselves.
static void join_along(Group *groups, Edge *edges, int count) {
    qsort(edges, (size_t)count, sizeof *edges, compare_edges);
    for (int i = 0; i + 1 < count; i++) {
        const Edge *a = &edges[i], *b = &edges[i + 1];
        bool alone = (i == 0 || edges[i - 1].key != a->key) && (i + 2 == count || edges[i + 2].key != a->key);
        if (a->key == b->key && alone && a->group != b->group)
            join(groups, a->group, b->group, a->forwards == b->forwards);
    }
}

void shape_orient(Arena *arena, Shape *shape, const int *first, int group_count, const ShapeEdge *outline,
                  int outline_count) {
    int count = 0, most = outline_count;
    for (int i = first[0]; i < shape->face_count; i++) most += shape->faces[i].count;
    Edge *edges = ARENA_ARRAY(arena, Edge, most + 1);
    Group *groups = ARENA_ARRAY(arena, Group, group_count + 1);
    for (int g = 0; g < group_count; g++) {
        int end = g + 1 < group_count ? first[g + 1] : shape->face_count;
        groups[g] = (Group){.parent = g, .polygons = end - first[g]};
        for (int i = first[g]; i < end; i++) {
            const Vec3 *c = shape->corners + shape->faces[i].first;
            for (int k = 0; k < shape->faces[i].count; k++)
                edges[count++] = edge_of(c[k], c[(k + 1) % shape->faces[i].count], g);
        }
    }
    join_along(groups, edges, count);
    // Along a straight edge a curved face has more corners than its neighbour: there the edges of the file tell.
    for (count = 0; count < outline_count; count++)
        edges[count] = edge_of(outline[count].from, outline[count].to, outline[count].group);
    join_along(groups, edges, count);
    // All that hangs together can be turned in two ways: the one that turns fewer polygons.
    long long *turned = ARENA_ARRAY(arena, long long, group_count + 1);
    bool against;
    for (int pass = 0; pass < 2; pass++) {
        for (int g = 0; g < group_count; g++) {
            int root = root_of(groups, g, &against),
                end = g + 1 < group_count ? first[g + 1] : shape->face_count;
            if (pass == 0) turned[root] += against ? end - first[g] : first[g] - end;
            if (pass == 1 && against == (turned[root] <= 0)) shape_flip_faces(shape, first[g], end);
        }
    }
}
