// mesh_texture.c - the reflectances of elements whose material has a picture: means over the element, by the midpoint rule.
#include "radiosity/mesh/mesh_parts.h"

// Points along each side of an element. Each is the mean over half the way to the next, so that little of the picture beside the
// element counts.
enum { SIDE = 4 };
// The least share of the material's mean that an element reflects.
static const float LEAST_SHARE = 1e-3f;

bool mesh_has_picture(const Mesh *mesh, int face) {
    const Material *m = mesh_material(mesh, face);
    return m->texture > 0 && (mesh->faces[face].texture_map > 0 || m->texture_map > 0) &&
           !mesh_is_lamp(mesh, face);
}

Rgb mesh_reflectance_at(const Mesh *mesh, int index, Vec3 point, double width) {
    const Face *face = &mesh->faces[index];
    const Building *b = mesh->graph->building;
    if (!mesh_has_picture(mesh, index)) return b->materials[face->material].reflectance;
    int leaf = mesh->graph->objects[face->object].leaf;
    if (leaf >= 0) point = leaf_point_closed(&b->leaves[leaf], face->open, point);
    return texture_at(b, face->material, face->texture_map, point, width).colour;
}

// The element's corners in the units of the face's grid, and the box around them.
static void find_corners(const Mesh *mesh, const Element *e, Vec2 *out, Vec2 *low, Vec2 *high) {
    const Face *face = &mesh->faces[e->face];
    *low = vec2(INFINITY, INFINITY);
    *high = vec2(-INFINITY, -INFINITY);
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 p = vec3_sub(mesh->vertices[mesh->corners[e->first_corner + i]], face->origin);
        out[i] = vec2(vec3_dot(face->gx, p), vec3_dot(face->gy, p));
        *low = vec2(fmin(low->x, out[i].x), fmin(low->y, out[i].y));
        *high = vec2(fmax(high->x, out[i].x), fmax(high->y, out[i].y));
    }
}

static bool is_within(const Vec2 *corner, int count, Vec2 p) {
    for (int i = 0; i < count; i++) {
        Vec2 a = corner[i], b = corner[(i + 1) % count];
        if (vec2_cross(vec2_sub(b, a), vec2_sub(p, a)) < 0) return false;
    }
    return true;
}

static Rgb mean_over(const Mesh *mesh, int element, Arena *scratch) {
    const Element *e = &mesh->elements[element];
    const Face *face = &mesh->faces[e->face];
    Vec2 *corner = ARENA_ARRAY(scratch, Vec2, e->corner_count), low, high;
    find_corners(mesh, e, corner, &low, &high);
    Vec2 step = vec2_scale(vec2_sub(high, low), 1.0 / SIDE);
    double x2 = vec3_dot(face->gx, face->gx), y2 = vec3_dot(face->gy, face->gy);
    double width = sqrt(step.x * step.y / sqrt(x2 * y2)) / 2, sum[3] = {0, 0, 0};
    int count = 0;
    for (int k = 0; k < SIDE * SIDE; k++) {
        Vec2 at = vec2(low.x + (k % SIDE + 0.5) * step.x, low.y + ((double)(k / SIDE) + 0.5) * step.y);
        if (!is_within(corner, e->corner_count, at)) continue;
        Vec3 p = vec3_add(face->origin,
                          vec3_add(vec3_scale(face->gx, at.x / x2), vec3_scale(face->gy, at.y / y2)));
        Rgb rho = mesh_reflectance_at(mesh, e->face, p, width);
        double channels[3];
        rgb_doubles(rho, channels);
        for (int c = 0; c < 3; c++) sum[c] += channels[c];
        count++;
    }
    if (count == 0) {
        Vec3 p = mesh->vertices[mesh->corners[e->first_corner]];
        return mesh_reflectance_at(mesh, e->face, p, sqrt(e->area));
    }
    return (Rgb){(float)(sum[0] / count), (float)(sum[1] / count), (float)(sum[2] / count)};
}

void mesh_find_reflectances(Mesh *mesh, Arena *arena) {
    Arena scratch = {0};
    mesh->reflectance = NULL;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        if (!mesh_has_picture(mesh, f)) continue;
        Rgb least = mesh_material(mesh, f)->reflectance;
        if (!mesh->reflectance) {
            mesh->reflectance = ARENA_ARRAY(arena, Rgb, mesh->element_count);
            for (int e = 0; e < mesh->element_count; e++)
                mesh->reflectance[e] = mesh_material(mesh, mesh->elements[e].face)->reflectance;
        }
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            arena_reset(&scratch);
            Rgb mean = mean_over(mesh, e, &scratch);
            mesh->reflectance[e] =
                (Rgb){fmaxf(mean.r, LEAST_SHARE * least.r), fmaxf(mean.g, LEAST_SHARE * least.g),
                      fmaxf(mean.b, LEAST_SHARE * least.b)};
        }
    }
    arena_free(&scratch);
}

Rgb mesh_patch_reflectance(const Mesh *mesh, int index) {
    const Patch *patch = &mesh->patches[index];
    const Rgb *rho = mesh->reflectance;
    if (!rho || !mesh_has_picture(mesh, patch->face)) return mesh_material(mesh, patch->face)->reflectance;
    double sum[3] = {0, 0, 0}, area = 0;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        double channels[3];
        rgb_doubles(rho[e], channels);
        for (int c = 0; c < 3; c++) sum[c] += mesh->elements[e].area * channels[c];
        area += mesh->elements[e].area;
    }
    return (Rgb){(float)(sum[0] / area), (float)(sum[1] / area), (float)(sum[2] / area)};
}
