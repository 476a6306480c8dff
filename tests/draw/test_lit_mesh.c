// test_lit_mesh.c - the triangles that show light: all of each polygon, and no place of it twice.
#include <criterion/criterion.h>

#include "engine/lit/lit_mesh.h"
#include "tests/support/lit_fixture.h"

static Vec3 place(const LitMesh *lit, int vertex) {
    const float *p = lit->vertex[vertex].position;
    return vec3_add(vec3((double)p[0], (double)p[1], (double)p[2]), lit->origin);
}

static double triangle_area(const LitMesh *lit, const unsigned *corner) {
    Vec3 a = place(lit, (int)corner[0]), b = place(lit, (int)corner[1]), c = place(lit, (int)corner[2]);
    return vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a))) / 2;
}

// Proves that the vertices of each polygon are its own, in its plane and material, none twice; and that its triangles cover it. In a box of
// even walls each place of a wall is one node. Tolerance: floats.
Test(lit_mesh, polygons_have_each_place_once) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2), true, LIT_WALL, 0);
    lit_box(lit, vec3(1, 1, 0.5), vec3(2, 2, 1), false, LIT_WALL, 0);
    // Two that lie side by side in one plane, and share nodes.
    lit_quad(lit, vec3(5, 0, 0), vec3(6, 0, 0), vec3(6, 1, 0), vec3(5, 1, 0), LIT_WALL);
    lit_quad(lit, vec3(6, 0, 0), vec3(7, 0, 0), vec3(7, 1, 0), vec3(6, 1, 0), LIT_WALL);
    lit_finish(lit, 0.5, 1);
    const Mesh *mesh = &lit->mesh;
    const LitMesh *drawn = lit_mesh_new(mesh, &lit->arena, &lit->arena);
    cr_assert_eq(drawn->face_count, mesh->face_count);
    cr_expect_lt(2 * lit_vertex_count(drawn), mesh->corner_count);
    for (const LitFace *f = drawn->faces; f < drawn->faces + drawn->face_count; f++) {
        double area = 0, all = 0;
        for (int v = f->first_vertex; v < f[1].first_vertex; v++) {
            cr_expect_eq(drawn->vertex[v].material, f->material);
            cr_expect_float_eq(plane_distance(f->plane, place(drawn, v)), 0, 1e-6);
            for (int w = f->first_vertex; w < v; w++)
                cr_expect(vec3_length(vec3_sub(place(drawn, v), place(drawn, w))) > 1e-6);
        }
        for (int i = f->first_index; i < f[1].first_index; i += 3) {
            area += triangle_area(drawn, drawn->index + i);
            for (int k = i; k < i + 3; k++)
                cr_expect((int)drawn->index[k] >= f->first_vertex &&
                          (int)drawn->index[k] < f[1].first_vertex);
        }
        for (int e = f->first_element; e < f->first_element + f->element_count; e++)
            all += mesh->elements[e].area;
        cr_expect_float_eq(area, all, 1e-5 * all, "polygon %d: %g of %g m^2", f->polygon, area, all);
        cr_expect_eq(lit_face_of(drawn, f->polygon), f);
    }
    lit_free(lit);
}
