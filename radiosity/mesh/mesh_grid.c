// mesh_grid.c - the grid that a face is cut along: parallel to its longest edge, about its outline.
#include "radiosity/mesh/mesh_parts.h"

// Side of squares on faces that are cut, metres; and how many there may be before they are larger.
static const double SEARCHED = 0.06;
static const int MOST_SQUARES = 1 << 16;

// How much longer than asked for an element's edges may be. Small faces make them shorter on the average.
static const double LONGEST = 1.15;

// How many patches of an edge length a side takes.
static int patches_along(double length, double edge) {
    double patches = ceil(length / (LONGEST * edge));
    return patches < 1 ? 1 : (int)patches;
}

double mesh_count_even(const Mesh *mesh) {
    double edge = mesh->options.element * mesh->options.per_patch, per = mesh->options.per_patch, count = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        count += per * patches_along(face->nx / vec3_length(face->gx), edge) * per *
                 patches_along(face->ny / vec3_length(face->gy), edge);
    }
    return count;
}

void mesh_lay_grid(MeshBuilder *builder, Face *face, const int *corner, int count) {
    const Vec3 *points = builder->places.points;
    Vec3 base = points[corner[0]], x = {0};
    double longest = 0;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(points[corner[(i + 1) % count]], points[corner[i]]);
        double length = vec3_length(edge);
        // Among edges equally long but for rounding the first.
        if (length <= longest * (1 + 1e-9)) continue;
        longest = length;
        x = edge;
    }
    x = vec3_normalize(vec3_sub(x, vec3_scale(face->plane.n, vec3_dot(face->plane.n, x))));
    Vec3 y = vec3_cross(face->plane.n, x);
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 p = vec3_sub(points[corner[i]], base);
        x0 = fmin(x0, vec3_dot(x, p));
        x1 = fmax(x1, vec3_dot(x, p));
        y0 = fmin(y0, vec3_dot(y, p));
        y1 = fmax(y1, vec3_dot(y, p));
    }
    const MeshOptions *options = &builder->mesh->options;
    double edge = options->element * options->per_patch * (options->splits ? 2 : 1);
    face->nx = patches_along(x1 - x0, edge);
    face->ny = patches_along(y1 - y0, edge);
    face->root = options->per_patch;
    if (options->splits) face->root = 1 << mesh_deepest(builder, (double)face->nx * face->ny);
    face->nx *= face->root;
    face->ny *= face->root;
    // On the plane, which corners miss where the polygon bends.
    base = vec3_sub(base, vec3_scale(face->plane.n, vec3_dot(face->plane.n, base) - face->plane.d));
    face->origin = vec3_add(base, vec3_add(vec3_scale(x, x0), vec3_scale(y, y0)));
    face->gx = vec3_scale(x, face->nx / (x1 - x0));
    face->gy = vec3_scale(y, face->ny / (y1 - y0));
}

void mesh_refine_grid(const MeshBuilder *builder, int index, Face *face) {
    if (builder->first_cut[index] == builder->first_cut[index + 1]) return;
    double side = 1 / fmin(vec3_length(face->gx), vec3_length(face->gy));
    for (; side > SEARCHED && (long long)face->nx * face->ny < MOST_SQUARES; side /= 2) {
        face->nx *= 2;
        face->ny *= 2;
        face->root *= 2;
        face->gx = vec3_scale(face->gx, 2);
        face->gy = vec3_scale(face->gy, 2);
    }
}
