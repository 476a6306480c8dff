// reconstruct_at.c - light between vertices: linear over the triangles that elements are drawn as.
#include "engine/core/polygon.h"
#include "radiosity/reconstruct.h"

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

// Corners that elements hardly ever have more of.
enum { FEW = 64 };

void reconstruct_in(const Mesh *mesh, const VertexLight *light, int element, Vec3 point, double out[3]) {
    const Element *e = &mesh->elements[element];
    Arena scratch = {0};
    Vec3 few[FEW], n = mesh->faces[e->face].plane.n, *v = few;
    int few_triangles[3 * FEW], *triangle = few_triangles, best[3] = {0, 1, 2};
    if (e->corner_count > FEW) {
        v = ARENA_ARRAY(&scratch, Vec3, e->corner_count);
        triangle = ARENA_ARRAY(&scratch, int, 3 * e->corner_count);
    }
    double inside = -INFINITY, share[3] = {1, 0, 0};
    for (int i = 0; i < e->corner_count; i++) v[i] = mesh->vertices[mesh->corners[e->first_corner + i]];
    polygon_triangulate(v, e->corner_count, triangle);
    for (int t = 0; t < e->corner_count - 2; t++) {
        const int *k = triangle + 3 * t;
        const Vec3 corner[3] = {v[k[0]], v[k[1]], v[k[2]]};
        double s[3];
        shares_at(corner, n, point, s);
        if (!(least3(s) > inside)) continue;
        inside = least3(s);
        memcpy(share, s, sizeof s);
        memcpy(best, k, sizeof best);
    }
    arena_free(&scratch);
    clamp_shares(share);
    for (int c = 0; c < 3; c++) {
        out[c] = 0;
        for (int k = 0; k < 3; k++) out[c] += share[k] * light->corner[e->first_corner + best[k]][c];
    }
}

void reconstruct_at(const Mesh *mesh, const VertexLight *light, int face, Vec3 point, double out[3]) {
    reconstruct_in(mesh, light, mesh_element_at(mesh, face, point), point, out);
}
