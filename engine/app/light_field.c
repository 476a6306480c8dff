// light_field.c - constant elements, and means at their corners (Cohen & Greenberg 1985, section 7: nodal radiosities) with what
// lies between by mean value coordinates (Floater 2003), which are bilinear enough in a square and take any convex polygon.
#include "engine/app/light_field.h"

// Planes are one where their normals are this near, 1 - cosine: as walk_light.c has it.
static const double SAME_PLANE = 1e-6;
// A point nearer to a corner than this is there, metres.
static const double AT_CORNER = 1e-9;

typedef struct Meeting {
    Vec3 n;
    int material, next;
    double sum[3], area;
} Meeting;

static int find_meeting(const Meeting *meetings, int first, const Face *face) {
    for (int i = first; i >= 0; i = meetings[i].next)
        if (meetings[i].material == face->material && vec3_dot(meetings[i].n, face->plane.n) > 1 - SAME_PLANE)
            return i;
    return -1;
}

LightField light_field(const Mesh *mesh, const RadSolution *solution, Arena *arena) {
    LightField field = {mesh, solution, NULL};
    field.corners = arena_alloc(arena, (size_t)mesh->corner_count, sizeof *field.corners);
    Arena scratch = {0};
    Meeting *meetings = ARENA_ARRAY(&scratch, Meeting, mesh->corner_count);
    int *first = ARENA_ARRAY(&scratch, int, mesh->vertex_count), count = 0;
    int *meeting = ARENA_ARRAY(&scratch, int, mesh->corner_count);
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
    for (int i = 0; i < mesh->corner_count; i++)
        for (int c = 0; c < 3; c++)
            field.corners[i][c] = meetings[meeting[i]].sum[c] / meetings[meeting[i]].area;
    arena_free(&scratch);
    return field;
}

void light_field_element(const LightField *field, int polygon, Vec3 point, double radiosity[3]) {
    int element = mesh_element_at(field->mesh, field->mesh->face_of[polygon], point);
    memcpy(radiosity, field->solution->radiosity[element], 3 * sizeof *radiosity);
}

// The tangent of half the angle at `p` between a and b.
static double half_tangent(Vec3 a, Vec3 b) {
    double la = vec3_length(a), lb = vec3_length(b), both = la * lb;
    return vec3_length(vec3_cross(a, b)) / (both + vec3_dot(a, b));
}

void light_field_vertex(const LightField *field, int polygon, Vec3 point, double radiosity[3]) {
    const Mesh *mesh = field->mesh;
    const Element *element = &mesh->elements[mesh_element_at(mesh, mesh->face_of[polygon], point)];
    const int *corner = mesh->corners + element->first_corner;
    int count = element->corner_count;
    double sum[3] = {0}, total = 0;
    for (int i = 0; i < count; i++) {
        Vec3 before = vec3_sub(mesh->vertices[corner[(i + count - 1) % count]], point);
        Vec3 at = vec3_sub(mesh->vertices[corner[i]], point);
        Vec3 after = vec3_sub(mesh->vertices[corner[(i + 1) % count]], point);
        const double *light = field->corners[element->first_corner + i];
        double far = vec3_length(at);
        if (far < AT_CORNER) {
            memcpy(radiosity, light, 3 * sizeof *radiosity);
            return;
        }
        double weight = (half_tangent(before, at) + half_tangent(at, after)) / far;
        for (int c = 0; c < 3; c++) sum[c] += weight * light[c];
        total += weight;
    }
    for (int c = 0; c < 3; c++) radiosity[c] = sum[c] / total;
}
