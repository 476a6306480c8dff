// test_ambient.c - light on its way: exact where form factors are shares of the area, and gone when all is shot.
#include <criterion/criterion.h>

#include "radiosity/shoot/ambient.h"
#include "tests/support/lit_fixture.h"

// Proves the sum of all reflections: a closed room whose walls all emit 1 and reflect half is 2 W/m^2 everywhere, and with
// nothing shot yet the ambient term alone says so; to rounding.
Test(ambient, a_furnace_is_right_at_once) {
    Lit *lit = lit_new();
    Error error = {""};
    RadSolution solution;
    lit->building->materials[LIT_WALL].emission = (Rgb){1, 1, 1};
    lit_box(lit, vec3(0, 0, 0), vec3(3, 2, 2.5), true, LIT_WALL, 0);
    lit_finish(lit, 0.5, 2);
    cr_assert(rad_start(&lit->mesh, &lit->arena, &solution, &error), "%s", error.text);
    double(*shown)[3] = arena_alloc(&lit->arena, (size_t)lit->mesh.element_count, sizeof *shown);
    ambient_radiosities(&lit->mesh, &solution, shown);
    for (int e = 0; e < lit->mesh.element_count; e++)
        cr_assert_float_eq(shown[e][1], 2, 1e-12, "element %d shows %g", e, shown[e][1]);
    lit_free(lit);
}

// Proves that the term stands for what is missing: at every stage of a bake what is shown has, over the building, the light
// of the end to a fifth, where the bare solution begins with a fraction; and that it fades as the bake goes on.
Test(ambient, stands_for_what_is_missing, .timeout = 60) {
    Lit *lit = lit_rooms(4);
    double whole = 0, glow_before = INFINITY;
    double(*shown)[3] = arena_alloc(&lit->arena, (size_t)lit->mesh.element_count, sizeof *shown);
    RadOptions options = rad_default_options();
    RadSolution end;
    lit_shoot(lit, &options, &end);
    const Mesh *mesh = &lit->mesh;
    for (int e = 0; e < mesh->element_count; e++) whole += mesh->elements[e].area * end.radiosity[e][1];
    for (int shots = 1; shots <= 4096; shots *= 8) {
        RadSolution part;
        double sum = 0, bare = 0, glow[3];
        options.shots = shots;
        lit_shoot(lit, &options, &part);
        ambient_radiosities(mesh, &part, shown);
        ambient_irradiance(mesh, &part, glow);
        for (int e = 0; e < mesh->element_count; e++) {
            sum += mesh->elements[e].area * shown[e][1];
            bare += mesh->elements[e].area * part.radiosity[e][1];
        }
        cr_expect(fabs(sum / whole - 1) < 0.2, "%d shots: %g of the light is shown", shots, sum / whole);
        cr_expect(sum >= bare && glow[1] <= glow_before, "%d shots: glow %g after %g", shots, glow[1],
                  glow_before);
        if (shots == 1) cr_expect_lt(bare, 0.8 * whole);
        glow_before = glow[1];
    }
    lit_free(lit);
}
