// mesh_fixture.c - see the header.
#include "tests/radiosity/mesh/mesh_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh.h"
#include "radiosity/mesh/mesh_places.h"
#include "tests/support/support.h"

static int corners_of(const Mesh *mesh, const Element *element, Vec3 *out) {
    for (int i = 0; i < element->corner_count; i++)
        out[i] = mesh->vertices[mesh->corners[element->first_corner + i]];
    return element->corner_count;
}

static void check_element(const Mesh *mesh, int e) {
    enum { MOST = 512 };
    const Element *element = &mesh->elements[e];
    const Face *face = &mesh->faces[element->face];
    Vec3 v[MOST], middle = {0, 0, 0};
    cr_assert_leq(element->corner_count, MOST);
    int count = corners_of(mesh, element, v);
    cr_assert_geq(count, 3, "element %d has %d corners", e, count);
    cr_assert_gt(element->area, 0);
    // Tolerance: corners are moved by up to MESH_WELD.
    cr_expect_float_eq(polygon_area(v, count), element->area, 1e-6 * sqrt(element->area), "element %d", e);
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(v[(i + 1) % count], v[i]);
        double length = vec3_length(edge);
        middle = vec3_add(middle, vec3_scale(v[i], 1.0 / count));
        cr_assert_gt(length, MESH_WELD, "element %d has an edge of %g m", e, length);
        for (int k = 0; k < count; k++) {
            double off = vec3_dot(vec3_cross(edge, vec3_sub(v[k], v[i])), face->plane.n) / length;
            cr_expect_geq(off, -3e-7, "element %d: corner %d is %g m outside edge %d", e, k, -off, i);
        }
    }
    cr_expect_eq(mesh_element_at(mesh, element->face, middle), e, "the middle of element %d is in %d", e,
                 mesh_element_at(mesh, element->face, middle));
}

static void check_patch(const Mesh *mesh, int p, int *next) {
    const Patch *patch = &mesh->patches[p];
    const Face *face = &mesh->faces[patch->face];
    double area = 0;
    cr_assert_eq(patch->first_element, *next, "patches are not in the order of elements");
    for (int e = *next; e < *next + patch->element_count; e++) {
        cr_assert(mesh->elements[e].patch == p && mesh->elements[e].face == patch->face);
        area += mesh->elements[e].area;
    }
    *next += patch->element_count;
    cr_expect_float_eq(area, patch->area, 1e-12 + 1e-12 * area);
    cr_expect_lt(fabs(plane_distance(face->plane, patch->centre)), 1e-9);
    int at = mesh_element_at(mesh, patch->face, patch->centre);
    // A patch that lost squares to neighbours may have its centre in one of theirs; mostly not.
    cr_expect_eq(mesh->elements[at].face, patch->face);
}

void mesh_check_mesh(const Mesh *mesh, const Vec3 *vertices) {
    int next = 0;
    double area = 0, drawn = 0;
    for (int e = 0; e < mesh->element_count; e++) check_element(mesh, e), area += mesh->elements[e].area;
    for (int p = 0; p < mesh->patch_count; p++) check_patch(mesh, p, &next);
    cr_expect_eq(next, mesh->element_count);
    for (int f = 0; f < mesh->face_count; f++) {
        const Polygon *p = &mesh->graph->polygons[mesh->faces[f].polygon];
        cr_expect_eq(mesh->face_of[mesh->faces[f].polygon], f);
        drawn += polygon_area(vertices + p->first_vertex, p->vertex_count);
    }
    cr_expect_float_eq(area, drawn, 1e-7 * drawn, "elements have %.9g m^2 of %.9g", area, drawn);
}
