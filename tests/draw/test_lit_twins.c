// test_lit_twins.c - of faces in one place that look the same way all but the lowest are set back, and no others.
#include <criterion/criterion.h>

#include "engine/lit/lit_mesh.h"
#include "tests/support/lit_fixture.h"

static void top(Lit *lit, double x, double y, double side, double z) {
    lit_quad(lit, vec3(x, y, z), vec3(x + side, y, z), vec3(x + side, y + side, z), vec3(x, y + side, z),
             LIT_WALL);
}

// Proves which: one that lies in another, and one that overlaps it in part; not a neighbour that touches, nor one a millimetre
// above, nor one that looks the other way. And that it is drawn half a millimetre behind, which is what depths can tell.
Test(lit_twins, are_set_back) {
    static const bool EXPECTED[] = {false, true, true, false, false, false};
    Lit *lit = lit_new();
    top(lit, 0, 0, 1, 0.5);
    top(lit, 0.2, 0.3, 0.4, 0.5);
    top(lit, 0.9, 0.9, 1, 0.5);
    top(lit, 1, -0.1, 1, 0.5);
    top(lit, 0, 0, 1, 0.501);
    lit_quad(lit, vec3(0, 0, 0.5), vec3(0, 1, 0.5), vec3(1, 1, 0.5), vec3(1, 0, 0.5), LIT_WALL);
    lit_finish(lit, 1, 1);
    const bool *twins = lit_twins(&lit->mesh, &lit->arena);
    const LitMesh *drawn = lit_mesh_new(&lit->mesh, &lit->arena, &lit->arena);
    for (int p = 0; p < 6; p++) {
        cr_expect_eq(twins[lit->mesh.face_of[p]], EXPECTED[p], "polygon %d", p);
        double z = (double)drawn->vertex[lit_face_of(drawn, p)->first_vertex].position[2] + drawn->origin.z;
        cr_expect_float_eq(z, (p == 4 ? 0.501 : 0.5) - (EXPECTED[p] ? 5e-4 : 0), 1e-6, "polygon %d at %g", p,
                           z);
    }
    lit_free(lit);
}
