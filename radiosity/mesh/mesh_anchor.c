// mesh_anchor.c - vertices of neighbours on the edges of faces and elements become vertices of theirs, so that neighbours share whole
// edges and no crack opens between them (Baum, Mann, Smith & Winget 1991: T-vertices).
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/mesh/mesh_parts.h"

// Rings of corners: ring r is corner[end[r - 1]] .. corner[end[r] - 1], and closed.
typedef struct Rings {
    int *corner;  // places
    int *end;     // [count]
    int count;
} Rings;

static int begin_of(const Rings *rings, int ring) { return ring == 0 ? 0 : rings->end[ring - 1]; }

static double mean_edge(const Vec3 *points, const Rings *rings) {
    double length = 0;
    int edges = 0;
    for (int r = 0; r < rings->count; r++) {
        int first = begin_of(rings, r), end = rings->end[r];
        for (int i = first; i < end; i++, edges++) {
            int next = i + 1 == end ? first : i + 1;
            length += vec3_length(vec3_sub(points[rings->corner[next]], points[rings->corner[i]]));
        }
    }
    return edges > 0 ? length / edges : 1;
}

// ---- on several threads

enum { RINGS_A_GROUP = 512 };

// The outcome for a group of rings.
typedef struct Anchored {
    Arena arena;
    int *corner, count, capacity;
} Anchored;

typedef struct Anchoring {
    const Rings *rings;
    PlaceGrid grid;
    int *grown;  // [rings->count] corners of each
    Anchored *groups;
} Anchoring;

static void push(Anchored *out, int place) {
    *ARENA_PUSH(&out->arena, out->corner, out->count, out->capacity) = place;
}

static void anchor_ring(const Anchoring *a, int ring, PlacesFound *on_edge, Anchored *out) {
    const int *corner = a->rings->corner;
    int first = begin_of(a->rings, ring), end = a->rings->end[ring], before = out->count;
    for (int i = first; i < end; i++) {
        push(out, corner[i]);
        int found = place_grid_on_edge(&a->grid, corner[i], corner[i + 1 == end ? first : i + 1], on_edge);
        for (int k = 0; k < found; k++) push(out, on_edge->found[k].point);
    }
    a->grown[ring] = out->count - before;
}

static void anchor_group(void *context, int index, int thread) {
    (void)thread;
    const Anchoring *a = context;
    int first = index * RINGS_A_GROUP, end = first + RINGS_A_GROUP;
    PlacesFound on_edge = {.arena = &a->groups[index].arena};
    for (int ring = first; ring < end && ring < a->rings->count; ring++)
        anchor_ring(a, ring, &on_edge, &a->groups[index]);
}

// The groups' corners one after the other, in the arena; they are freed.
static int *join_groups(const Anchoring *a, int group_count, Arena *arena, int *out_count) {
    int count = 0;
    for (int g = 0; g < group_count; g++) count += a->groups[g].count;
    int *corner = ARENA_ARRAY(arena, int, count);
    *out_count = 0;
    for (int g = 0; g < group_count; g++) {
        Anchored *group = &a->groups[g];
        if (group->count > 0)
            memcpy(corner + *out_count, group->corner, (size_t)group->count * sizeof *corner);
        *out_count += group->count;
        arena_free(&group->arena);
    }
    return corner;
}

// Puts in every one of the builder's places that lies on an edge. Returns how many corners there are then.
static int anchor(MeshBuilder *builder, Rings *rings) {
    Arena scratch = {0};
    const Places *places = &builder->places;
    int groups = (rings->count + RINGS_A_GROUP - 1) / RINGS_A_GROUP, count;
    Anchoring a = {.rings = rings,
                   .grid =
                       place_grid(places->points, places->count, mean_edge(places->points, rings), &scratch),
                   .grown = ARENA_ARRAY(&scratch, int, rings->count),
                   .groups = ARENA_ARRAY(&scratch, Anchored, groups)};
    parallel_for(parallel_threads(builder->mesh->options.threads), groups, anchor_group, &a);
    rings->corner = join_groups(&a, groups, builder->arena, &count);
    for (int r = 0, end = 0; r < rings->count; r++) rings->end[r] = end += a.grown[r];
    arena_free(&scratch);
    return count;
}

// ---- of a mesh

void mesh_anchor_outlines(MeshBuilder *builder, int *corner) {
    Mesh *mesh = builder->mesh;
    Arena scratch = {0};
    Rings rings = {corner, ARENA_ARRAY(&scratch, int, mesh->face_count), mesh->face_count};
    for (int f = 0; f < mesh->face_count; f++)
        rings.end[f] = mesh->faces[f].first_vertex + mesh->faces[f].vertex_count;
    mesh->outline_count = anchor(builder, &rings);
    mesh->outline = rings.corner;
    for (int f = 0; f < mesh->face_count; f++) {
        mesh->faces[f].first_vertex = begin_of(&rings, f);
        mesh->faces[f].vertex_count = rings.end[f] - begin_of(&rings, f);
    }
    arena_free(&scratch);
}

void mesh_anchor_elements(MeshBuilder *builder) {
    Mesh *mesh = builder->mesh;
    Arena scratch = {0};
    Rings rings = {mesh->corners, ARENA_ARRAY(&scratch, int, mesh->element_count), mesh->element_count};
    for (int e = 0; e < mesh->element_count; e++)
        rings.end[e] = mesh->elements[e].first_corner + mesh->elements[e].corner_count;
    mesh->corner_count = anchor(builder, &rings);
    mesh->corners = rings.corner;
    for (int e = 0; e < mesh->element_count; e++) {
        mesh->elements[e].first_corner = begin_of(&rings, e);
        mesh->elements[e].corner_count = rings.end[e] - begin_of(&rings, e);
    }
    arena_free(&scratch);
}
