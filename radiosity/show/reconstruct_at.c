// reconstruct_at.c - light between vertices: linear over the triangles that elements are drawn as.
#include "engine/core/polygon.h"
#include "radiosity/show/reconstruct.h"

// Shares of a triangle's corners at a point of its plane; below 0 outside.
static void shares_at(const Vec3 v[3], Vec3 n, Vec3 p, double share[3]) {
    double twice = vec3_dot(n, vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0])));
    for (int k = 0; k < 3; k++) {
        Vec3 a = vec3_sub(v[(k + 1) % 3], p), b = vec3_sub(v[(k + 2) % 3], p);
        share[k] = twice > 0 ? vec3_dot(n, vec3_cross(a, b)) / twice : -INFINITY;
    }
}

static double least3(const double v[3]) { return fmin(v[0], fmin(v[1], v[2])); }

// Back into the triangle.
static void clamp_shares(double share[3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += share[k] = fmax(share[k], 0);
    for (int k = 0; k < 3; k++) share[k] /= sum;
}

static void triangulate(const Mesh *mesh, const Element *e, Vec3 *v, int *triangle) {
    for (int i = 0; i < e->corner_count; i++) v[i] = mesh->vertices[mesh->corners[e->first_corner + i]];
    polygon_triangulate(v, e->corner_count, triangle);
}

int *reconstruct_triangles(const Mesh *mesh, Arena *arena) {
    int *triangle = ARENA_ARRAY(arena, int, 3 * mesh->corner_count + 1), most = 0;
    Arena scratch = {0};
    for (int e = 0; e < mesh->element_count; e++)
        if (mesh->elements[e].corner_count > most) most = mesh->elements[e].corner_count;
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, most + 1);
    for (int e = 0; e < mesh->element_count; e++)
        triangulate(mesh, &mesh->elements[e], v, triangle + 3 * mesh->elements[e].first_corner);
    arena_free(&scratch);
    return triangle;
}

// Corners that elements hardly ever have more of.
enum { FEW = 64 };

static void add_shares(const VertexLight *light, const Element *e, const int corner[3], const double share[3],
                       double out[3]) {
    for (int c = 0; c < 3; c++) {
        out[c] = 0;
        for (int k = 0; k < 3; k++) out[c] += share[k] * light->corner[e->first_corner + corner[k]][c];
    }
}

// The corners of the triangle in which the point is, or to which it is nearest.
static void find_shares(const Mesh *mesh, const Element *e, const int *triangle, Vec3 point, int best[3],
                        double share[3]) {
    const int *corners = mesh->corners + e->first_corner;
    Vec3 n = mesh->faces[e->face].plane.n;
    double inside = -INFINITY;
    for (int t = 0; t < e->corner_count - 2; t++) {
        const int *k = triangle + 3 * t;
        const Vec3 corner[3] = {mesh->vertices[corners[k[0]]], mesh->vertices[corners[k[1]]],
                                mesh->vertices[corners[k[2]]]};
        double s[3];
        shares_at(corner, n, point, s);
        if (!(least3(s) > inside)) continue;
        inside = least3(s);
        memcpy(share, s, sizeof s);
        memcpy(best, k, 3 * sizeof *best);
    }
    clamp_shares(share);
}

void reconstruct_in(const Mesh *mesh, const VertexLight *light, int element, Vec3 point, double out[3]) {
    const Element *e = &mesh->elements[element];
    Arena scratch = {0};
    Vec3 few[FEW], *v = few;
    int few_triangles[3 * FEW], *triangle = few_triangles, best[3] = {0, 1, 2};
    double share[3] = {1, 0, 0};
    if (light->triangle) {
        triangle = light->triangle + 3 * e->first_corner;
    } else {
        if (e->corner_count > FEW) {
            v = ARENA_ARRAY(&scratch, Vec3, e->corner_count);
            triangle = ARENA_ARRAY(&scratch, int, 3 * e->corner_count);
        }
        triangulate(mesh, e, v, triangle);
    }
    find_shares(mesh, e, triangle, point, best, share);
    arena_free(&scratch);
    add_shares(light, e, best, share, out);
}

void reconstruct_at(const Mesh *mesh, const VertexLight *light, int face, Vec3 point, double out[3]) {
    reconstruct_in(mesh, light, mesh_element_at(mesh, face, point), point, out);
}
