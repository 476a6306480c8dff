// test_lines.c - which element a point of a face lies on, by the borders of elements: against mesh_element_at.
#include <criterion/criterion.h>

#include "radiosity/mesh/lines.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

// A room with boxes along which elements are cut, at any place of the grid.
static Lit *room_with_boxes(uint64_t seed) {
    Random random = {seed};
    Lit *lit = lit_new();
    double far = seed % 3 == 0 ? 1e6 : 0;
    Vec3 at = {far, -far / 3, 0};
    MeshOptions options = mesh_default_options();
    lit_box(lit, at, vec3_add(at, vec3(4, 3, 2.5)), true, LIT_WALL, 0);
    for (int i = 0; i < 6; i++) {
        Vec3 low = vec3_add(at, vec3(random_between(&random, 0.1, 3), random_between(&random, 0.1, 2), 0));
        building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "box");
        lit_box(
            lit, low,
            vec3_add(low, vec3(random_between(&random, 0.1, 0.9), random_between(&random, 0.1, 0.9), 0.7)),
            false, LIT_WALL, 0);
    }
    options.element = random_between(&random, 0.1, 0.4);
    options.close = 0.05;
    lit_finish_with(lit, &options);
    return lit;
}

// Proves that borders give the element that mesh_element_at finds from all corners, at points of every element, inside it and beyond its
// corners, where other elements or none lie; and that elements which share squares are among them. Points on a border itself may fall to
// either side: of random points none does.
Test(lines, borders_tell_elements, .timeout = 120) {
    long long points = 0, shared = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(12, 300); seed++) {
        Lit *lit = room_with_boxes(seed);
        const Mesh *mesh = &lit->mesh;
        FaceLines lines = lines_of_mesh(mesh, &lit->arena);
        Random random = {seed};
        for (int e = 0; e < mesh->element_count; e++) {
            const Element *element = &mesh->elements[e];
            Vec3 centre = element_centroid(mesh, e);
            shared += lines.first_border[e + 1] > lines.first_border[e];
            for (int i = 0; i < element->corner_count; i++) {
                Vec3 corner = mesh->vertices[mesh->corners[element->first_corner + i]];
                Vec3 p = vec3_lerp(centre, corner, random_between(&random, 0, 1.3));
                int found = lines_element_at(&lines, mesh, element->face, p),
                    wanted = mesh_element_at(mesh, element->face, p);
                cr_assert_eq(found, wanted, "seed %llu: element %d, not %d", (unsigned long long)seed, found,
                             wanted);
                points++;
            }
        }
        lit_free(lit);
    }
    cr_expect(shared > 0 && 50 * shared > points / 4, "%lld of the elements of %lld points share squares",
              shared, points);
}
