// walk_light.c - radiosities at corners: constant elements become linear by the mean at each corner (Cohen & Greenberg 1985,
// section 7: nodal radiosities).
#include "engine/walk/walk_light.h"

// Planes are one where their normals are this near, 1 - cosine.
static const double SAME_PLANE = 1e-6;

// What meets at a place in one plane, of one material.
typedef struct Meeting {
    Vec3 n;
    int material, next;
    double sum[3], area;
} Meeting;

static int find_meeting(const Meeting *meetings, int first, const Face *face) {
    for (int i = first; i >= 0; i = meetings[i].next) {
        if (meetings[i].material == face->material && vec3_dot(meetings[i].n, face->plane.n) > 1 - SAME_PLANE)
            return i;
    }
    return -1;
}

static void fill_corners(const Mesh *mesh, const RadSolution *solution, double (*out)[3]) {
    Arena scratch = {0};
    Meeting *meetings = ARENA_ARRAY(&scratch, Meeting, mesh->corner_count);
    int *first = ARENA_ARRAY(&scratch, int, mesh->vertex_count),
        *meeting = ARENA_ARRAY(&scratch, int, mesh->corner_count);
    int count = 0;
    for (int v = 0; v < mesh->vertex_count; v++) first[v] = -1;
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        const Face *face = &mesh->faces[element->face];
        for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++) {
            int v = mesh->corners[i], at = find_meeting(meetings, first[v], face);
            if (at < 0) {
                at = count++;
                meetings[at] = (Meeting){.n = face->plane.n, .material = face->material, .next = first[v]};
                first[v] = at;
            }
            for (int c = 0; c < 3; c++) meetings[at].sum[c] += element->area * solution->radiosity[e][c];
            meetings[at].area += element->area;
            meeting[i] = at;
        }
    }
    for (int i = 0; i < mesh->corner_count; i++) {
        const Meeting *m = &meetings[meeting[i]];
        for (int c = 0; c < 3; c++) out[i][c] = m->sum[c] / m->area;
    }
    arena_free(&scratch);
}

VertexLight walk_light_vertices(const Mesh *mesh, const RadSolution *solution, Arena *arena) {
    VertexLight out = {arena_alloc(arena, (size_t)mesh->corner_count, sizeof *out.corner),
                       arena_alloc(arena, (size_t)mesh->face_count, sizeof *out.face)};
    fill_corners(mesh, solution, out.corner);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        double sum[3] = {0}, area = 0;
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            for (int c = 0; c < 3; c++) sum[c] += mesh->elements[e].area * solution->radiosity[e][c];
            area += mesh->elements[e].area;
        }
        for (int c = 0; c < 3; c++) out.face[f][c] = sum[c] / area;
    }
    return out;
}
