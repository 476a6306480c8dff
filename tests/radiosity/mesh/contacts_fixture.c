// contacts_fixture.c - see the header.
#include "tests/radiosity/mesh/contacts_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const double CLOSE = 0.05;

Lit *contacts_room(void) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    return lit;
}

int contacts_the_floor(const Lit *lit) {
    for (int f = 0; f < lit->mesh.face_count; f++)
        if (lit->mesh.faces[f].plane.n.z > 0.9 && lit->mesh.faces[f].origin.z == 0) return f;
    cr_assert_fail("no floor");
    return -1;
}

void contacts_finish(Lit *lit, double element, int per_patch, const MeshSplits *splits) {
    MeshOptions options = {.element = element, .per_patch = per_patch, .close = CLOSE, .splits = splits};
    lit_finish_with(lit, &options);
}

Vec3 contacts_middle_of(const Mesh *mesh, const Element *e) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < e->corner_count; i++)
        sum = vec3_add(sum, mesh->vertices[mesh->corners[e->first_corner + i]]);
    return vec3_scale(sum, 1.0 / e->corner_count);
}

bool contacts_in_rectangle(const Rectangle *r, Vec3 p, double by) {
    return p.x > r->x0 + by && p.x < r->x1 - by && p.y > r->y0 + by && p.y < r->y1 - by;
}

double contacts_area_of(const Mesh *mesh, int face) {
    double area = 0;
    for (int e = 0; e < mesh->element_count; e++)
        if (mesh->elements[e].face == face) area += mesh->elements[e].area;
    return area;
}

int contacts_side_of(const Mesh *mesh, const Element *e, const Rectangle *r) {
    // Thinner than a millimetre nothing is cut off.
    const double by = 1.5e-3;
    bool inside = contacts_in_rectangle(r, contacts_middle_of(mesh, e), 0);
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 p = mesh->vertices[mesh->corners[e->first_corner + i]],
             q = mesh->vertices[mesh->corners[e->first_corner + (i + 1) % e->corner_count]];
        for (int k = 0; k < 8; k++) {
            Vec3 v = vec3_lerp(p, q, k / 8.0);
            if (inside ? !contacts_in_rectangle(r, v, -by) : contacts_in_rectangle(r, v, by)) return -1;
        }
    }
    return inside;
}

static RadOptions options_of(Culling culling) {
    RadOptions o = rad_default_options();
    o.form_factor.resolution = 60;
    o.residual = 1e-3;
    o.culling = culling;
    return o;
}

RadSolution contacts_check_light(Lit *lit) {
    RadSolution s, all;
    RadOptions options = options_of(CULL_STAB);
    lit_shoot(lit, &options, &s);
    options = options_of(CULL_NONE);
    lit_shoot(lit, &options, &all);
    cr_assert_eq(memcmp(s.radiosity, all.radiosity, (size_t)s.element_count * sizeof *s.radiosity), 0);
    for (int c = 0; c < 3; c++) {
        double power = s.absorbed[c] + s.escaped[c];
        for (int p = 0; p < s.patch_count; p++) power += s.unshot[p][c] * lit->mesh.patches[p].area;
        cr_assert_float_eq(power, s.emitted[c], 1e-9 * s.emitted[c]);
    }
    return s;
}
