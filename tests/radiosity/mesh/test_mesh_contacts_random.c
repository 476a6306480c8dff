// test_mesh_contacts_random.c - partitions, boxes through walls, sheets, and boxes at random.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/radiosity/mesh/contacts_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

// Proves that no element lies on both sides of a partition across the room, nor any patch: of two sheets in one place, and of a board
// of 5 cm.
Test(mesh_contacts, a_partition) {
    static const double THICK[] = {0, 0.05};
    for (int i = 0; i < 2; i++) {
        Lit *lit = contacts_room();
        double x0 = 1.71, x1 = x0 + THICK[i];
        lit_quad(lit, vec3(x1, 0, 0), vec3(x1, 3, 0), vec3(x1, 3, 2), vec3(x1, 0, 2), LIT_RED);
        lit_quad(lit, vec3(x0, 3, 0), vec3(x0, 0, 0), vec3(x0, 0, 2), vec3(x0, 3, 2), LIT_RED);
        contacts_finish(lit, 0.4, 2, NULL);
        const Rectangle left = {-1, -1, x0, 4}, right = {x1, -1, 5, 4};
        int face = contacts_the_floor(lit);
        cr_assert_float_eq(contacts_area_of(&lit->mesh, face), 12, 1e-9);
        for (int e = 0; e < lit->mesh.element_count; e++) {
            const Element *element = &lit->mesh.elements[e];
            if (element->face != face) continue;
            Vec3 m = contacts_middle_of(&lit->mesh, element);
            cr_assert(contacts_side_of(&lit->mesh, element, &left) >= 0 &&
                          contacts_side_of(&lit->mesh, element, &right) >= 0,
                      "%g m thick: element %d about %g %g lies on both sides", THICK[i], e, m.x, m.y);
        }
        contacts_check_light(lit);
        lit_free(lit);
    }
}

// Proves that a box through the wall cuts it where it goes through, both ways: what of the box's sides is outside the room is elements of
// its own, in the dark.
Test(mesh_contacts, a_box_through_a_wall) {
    Lit *lit = contacts_room();
    lit_box(lit, vec3(3.5, 1.11, 0.93), vec3(4.61, 2.07, 1.71), false, LIT_RED, 0);
    contacts_finish(lit, 0.4, 2, NULL);
    const Mesh *mesh = &lit->mesh;
    RadSolution s = contacts_check_light(lit);
    double area = 0, dark = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Polygon *p = &lit->graph.polygons[mesh->faces[f].polygon];
        double whole = polygon_area(lit->graph.vertices + p->first_vertex, p->vertex_count);
        cr_assert_float_eq(contacts_area_of(mesh, f), whole, 1e-9 * whole);
    }
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        const Face *face = &mesh->faces[element->face];
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < element->corner_count; i++) {
            double x = mesh->vertices[mesh->corners[element->first_corner + i]].x;
            low = fmin(low, x);
            high = fmax(high, x);
        }
        if (face->material == LIT_RED) {
            cr_assert(low > 4 - 2e-3 || high < 4 + 2e-3, "element %d is from x = %g to %g", e, low, high);
            if (low > 4 - 2e-3) cr_assert_eq(s.radiosity[e][0], 0);
        }
        Vec3 m = contacts_middle_of(mesh, element);
        if (fabs(m.x - 4) > 1e-6 || m.y < 1.11 || m.y > 2.07 || m.z < 0.93 || m.z > 1.71) continue;
        area += element->area;
        dark = fmax(dark, s.radiosity[e][0]);
    }
    cr_assert_float_eq(area, 0.96 * 0.78, 5e-3, "%g m^2 of the wall are inside the box", area);
    cr_assert_eq(dark, 0);
    lit_free(lit);
}

// Proves that faces with a sheet of their size in the same place, or all but in it, keep their elements: no NaN, nothing lost.
Test(mesh_contacts, coplanar_and_all_but_parallel_sheets) {
    static const double TILTS[] = {0, 1e-9, 1e-4, 2e-3};
    for (int i = 0; i < 4; i++) {
        double t = TILTS[i];
        Lit *lit = contacts_room();
        lit_quad(lit, vec3(0.5, 0.5, t), vec3(0.5, 2.5, 0), vec3(3.5, 2.5, -t), vec3(3.5, 0.5, 0), LIT_RED);
        lit_quad(lit, vec3(0.5, 0.5, -0.001 - t), vec3(3.5, 0.5, -0.001), vec3(3.5, 2.5, t - 0.001),
                 vec3(0.5, 2.5, -0.001), LIT_RED);
        contacts_finish(lit, 0.4, 2, NULL);
        double area = contacts_area_of(&lit->mesh, contacts_the_floor(lit));
        cr_assert_float_eq(area, 12, 1e-9, "tilt %g: %.12g", t, area);
        contacts_check_light(lit);
        lit_free(lit);
    }
}

// Proves that a building a thousand kilometres from the origin is cut as well as at it: as many elements, of the same areas.
Test(mesh_contacts, far_from_the_origin) {
    Lit *lit[2];
    static const MeshSplits ONCE = {.even = 1};
    for (int k = 0; k < 2; k++) {
        Vec3 o = {k * 1e6, k * 1e6, 0};
        lit[k] = lit_new();
        lit_box(lit[k], o, vec3_add(o, vec3(4, 3, 2.5)), true, LIT_WALL, 0);
        lit_lamp(lit[k], vec3_add(o, vec3(2, 1.5, 2.4)));
        lit_box(lit[k], vec3_add(o, vec3(1.13, 0.71, 0)), vec3_add(o, vec3(2.27, 1.94, 0.8)), false, LIT_RED,
                0);
        contacts_finish(lit[k], 0.4, 2, &ONCE);
    }
    cr_assert_eq(lit[0]->mesh.element_count, lit[1]->mesh.element_count);
    cr_assert_eq(lit[0]->mesh.patch_count, lit[1]->mesh.patch_count);
    for (int e = 0; e < lit[0]->mesh.element_count; e++)
        cr_assert_float_eq(lit[0]->mesh.elements[e].area, lit[1]->mesh.elements[e].area, 1e-8);
    contacts_check_light(lit[1]);
    for (int k = 0; k < 2; k++) lit_free(lit[k]);
}

// A box turned by an angle, standing on the floor, without a bottom.
static void add_turned(Lit *lit, Vec3 middle, double angle, double half_x, double half_y) {
    Vec3 v[4], up = {0, 0, 0.6};
    for (int i = 0; i < 4; i++) {
        double x = i == 1 || i == 2 ? half_x : -half_x, y = i >= 2 ? half_y : -half_y;
        v[i] = vec3_add(middle, vec3(x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle), 0));
    }
    for (int i = 0; i < 4; i++) {
        Vec3 p = v[i], q = v[(i + 1) % 4];
        lit_quad(lit, p, q, vec3_add(q, up), vec3_add(p, up), LIT_RED);
    }
    lit_quad(lit, vec3_add(v[0], up), vec3_add(v[1], up), vec3_add(v[2], up), vec3_add(v[3], up), LIT_RED);
}

// Proves that whatever stands on a floor, askew and through each other, on splits of any kind, nothing of it is lost, elements stay convex,
// and every point is in the element that is said to be there.
Test(mesh_contacts, random_boxes) {
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(20, 500); seed++) {
        Random random = {seed};
        Lit *lit = contacts_room();
        unsigned char bits[64];
        MeshSplits splits = {.bit_count = 8 * sizeof bits, .bits = bits};
        for (size_t i = 0; i < sizeof bits; i++)
            bits[i] = (unsigned char)(random_next(&random) & random_next(&random));
        for (int i = 1 + random_index(&random, 8); i > 0; i--) {
            Vec3 at = {random_between(&random, 0.5, 3.5), random_between(&random, 0.5, 2.5), 0};
            add_turned(lit, at, random_between(&random, 0, 6.28), random_between(&random, 0.02, 0.5),
                       random_between(&random, 0.02, 0.5));
        }
        contacts_finish(lit, 0.4, 1 + random_index(&random, 4), seed % 2 ? &splits : NULL);
        const Mesh *mesh = &lit->mesh;
        int face = contacts_the_floor(lit);
        double area = contacts_area_of(mesh, face);
        cr_assert_float_eq(area, 12, 1e-8, "seed %llu: %.12g m^2", (unsigned long long)seed, area);
        for (int k = 0; k < 500; k++) {
            Vec3 p = {random_between(&random, 0, 4), random_between(&random, 0, 3), 0};
            const Element *e = &mesh->elements[mesh_element_at(mesh, face, p)];
            for (int i = 0; i < e->corner_count; i++) {
                Vec3 a = mesh->vertices[mesh->corners[e->first_corner + i]],
                     b = mesh->vertices[mesh->corners[e->first_corner + (i + 1) % e->corner_count]];
                Vec3 inwards = vec3_normalize(vec3_cross(vec3(0, 0, 1), vec3_sub(b, a)));
                double off = vec3_dot(inwards, vec3_sub(p, a));
                // Tolerance: corners are welded.
                cr_assert_geq(off, -1e-6, "seed %llu: %g %g is %g m outside", (unsigned long long)seed, p.x,
                              p.y, off);
            }
        }
        for (int i = 0; i < mesh->patch_count; i++)
            cr_assert_leq(mesh->patches[i].element_count, MESH_MOST_IN_PATCH);
        lit_free(lit);
    }
}
