// test_mesh_contacts.c - elements cut along what stands on a face, or close before it: none lies on both sides, nothing of a face is
// lost, what is covered shoots by itself, and no light lands under what is closed.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/radiosity/mesh/contacts_fixture.h"
#include "tests/support/lit_fixture.h"

// Checks a floor on which things with these outlines stand. Returns the area inside them, m^2.
static double check_floor(const Lit *lit, const Rectangle *outlines, int count) {
    const Mesh *mesh = &lit->mesh;
    int face = contacts_the_floor(lit);
    double inside = 0;
    cr_assert_float_eq(contacts_area_of(mesh, face), 12, 1e-9, "the floor has %.12g m^2",
                       contacts_area_of(mesh, face));
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        int sides[2] = {0, 0};
        bool looks_inside = false, looks_covered;
        if (patch->face != face) continue;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
            int within = 0;
            for (int r = 0; r < count; r++) {
                int side = contacts_side_of(mesh, &mesh->elements[e], &outlines[r]);
                Vec3 m = contacts_middle_of(mesh, &mesh->elements[e]);
                cr_assert_geq(side, 0, "element %d about %g %g lies on both sides of outline %d", e, m.x, m.y,
                              r);
                within |= side;
            }
            sides[within]++;
            if (within) inside += mesh->elements[e].area;
            cr_assert_eq(mesh_element_at(mesh, face, contacts_middle_of(mesh, &mesh->elements[e])), e);
        }
        cr_assert(sides[0] == 0 || sides[1] == 0, "patch %d has %d elements open and %d covered", p, sides[0],
                  sides[1]);
        // Between two boxes, on their border, both is true.
        looks_covered = sides[1] > 0;
        for (int r = 0; r < count; r++)
            looks_inside |= contacts_in_rectangle(&outlines[r], patch->centre, looks_covered ? -1e-6 : 1e-6);
        cr_assert_eq(looks_inside, looks_covered, "patch %d looks from %g %g", p, patch->centre.x,
                     patch->centre.y);
    }
    return inside;
}

// The most light of an element of the floor inside an outline, W/m^2.
static double most_light(const Lit *lit, const RadSolution *s, const Rectangle *r) {
    int face = contacts_the_floor(lit);
    double most = 0;
    for (int e = 0; e < s->element_count; e++) {
        const Element *element = &lit->mesh.elements[e];
        if (element->face == face && contacts_side_of(&lit->mesh, element, r) == 1)
            most = fmax(most, s->radiosity[e][0]);
    }
    return most;
}

// Proves that the floor under a box is told from the floor around it, whether the box has a bottom or not, on the floor, a centimetre
// above it, and nearly as far as counts; and that where the box is closed, on the floor, no light at all is under it.
Test(mesh_contacts, a_box_on_the_floor) {
    static const double GAPS[] = {0, 0.01, 0.049};
    static const Rectangle OUTLINE = {1.13, 0.71, 2.27, 1.94};
    for (int bottom = 0; bottom < 2; bottom++) {
        for (int g = 0; g < 3; g++) {
            Lit *lit = contacts_room();
            lit_box(lit, vec3(OUTLINE.x0, OUTLINE.y0, GAPS[g]), vec3(OUTLINE.x1, OUTLINE.y1, 0.8), false,
                    LIT_RED, bottom ? 0 : 1 << 4);
            contacts_finish(lit, 0.4, 2, NULL);
            double inside = check_floor(lit, &OUTLINE, 1), whole = 1.14 * 1.23;
            // Tolerance: what is thinner than a millimetre is not cut off.
            cr_assert_float_eq(inside, whole, 5e-3, "gap %g: %g m^2 of %g", GAPS[g], inside, whole);
            RadSolution s = contacts_check_light(lit);
            if (GAPS[g] == 0)
                cr_assert_eq(most_light(lit, &s, &OUTLINE), 0, "%g", most_light(lit, &s, &OUTLINE));
            lit_free(lit);
        }
    }
}

// Proves the same in a doll's house, narrower than a metre along x or y.
Test(mesh_contacts, a_box_in_a_small_room) {
    static const Vec3 SIZES[] = {{0.75, 16, 1}, {16, 0.75, 1}};
    for (int i = 0; i < 2; i++) {
        Lit *lit = lit_new();
        const Rectangle outline = {0.31, 0.23, 0.53, 0.47};
        lit_box(lit, vec3(0, 0, 0), SIZES[i], true, LIT_WALL, 0);
        lit_box(lit, vec3(outline.x0, outline.y0, 0.01), vec3(outline.x1, outline.y1, 0.3), false, LIT_RED,
                0);
        contacts_finish(lit, 0.2, 2, NULL);
        // Tolerance: what is thinner than a millimetre is not cut off.
        cr_assert_float_eq(check_floor(lit, &outline, 1), 0.22 * 0.24, 1e-3);
        lit_free(lit);
    }
}

// Proves that what is farther from the floor cuts nothing.
Test(mesh_contacts, a_box_beyond_close) {
    Lit *lit = contacts_room();
    lit_box(lit, vec3(1.13, 0.71, 0.06), vec3(2.27, 1.94, 0.8), false, LIT_RED, 0);
    contacts_finish(lit, 0.4, 2, NULL);
    const Face *face = &lit->mesh.faces[contacts_the_floor(lit)];
    cr_assert_eq(face->element_count, face->nx * face->ny);
    contacts_check_light(lit);
    lit_free(lit);
}

// Proves that what stands in the middle of a patch does not become the place that the floor around it shoots from.
Test(mesh_contacts, a_small_box_in_the_middle_of_a_patch) {
    Lit *lit = contacts_room();
    contacts_finish(lit, 0.5, 2, NULL);
    Vec3 m = lit->mesh.patches[lit->mesh.faces[contacts_the_floor(lit)].first_patch].centre;
    const Rectangle outline = {m.x - 0.13, m.y - 0.11, m.x + 0.13, m.y + 0.11};
    Lit *with = contacts_room();
    lit_box(with, vec3(outline.x0, outline.y0, 0), vec3(outline.x1, outline.y1, 0.5), false, LIT_RED, 1 << 4);
    contacts_finish(with, 0.5, 2, NULL);
    check_floor(with, &outline, 1);
    RadSolution s = contacts_check_light(with);
    cr_assert_eq(most_light(with, &s, &outline), 0, "%g W/m^2 under it", most_light(with, &s, &outline));
    lit_free(with);
    lit_free(lit);
}

// Proves the same of cupboards side by side, whose sides in one place say of each other that all is open there.
Test(mesh_contacts, boxes_side_by_side) {
    static const Rectangle OUTLINES[3] = {{0.6, 0, 1.2, 0.6}, {1.2, 0, 1.83, 0.6}, {1.83, 0, 2.4, 0.55}};
    Lit *lit = contacts_room();
    for (int i = 0; i < 3; i++) {
        const Rectangle *r = &OUTLINES[i];
        lit_box(lit, vec3(r->x0, r->y0, 0), vec3(r->x1, r->y1, 0.9), false, LIT_RED, 0);
    }
    contacts_finish(lit, 0.4, 2, NULL);
    check_floor(lit, OUTLINES, 3);
    RadSolution s = contacts_check_light(lit);
    for (int i = 0; i < 3; i++) cr_assert_eq(most_light(lit, &s, &OUTLINES[i]), 0);
    lit_free(lit);
}
