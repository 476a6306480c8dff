// stability_fixture.c - see the header.
#include "tests/radiosity/factors/stability_fixture.h"

#include <criterion/criterion.h>

#include "radiosity/factors/analytic.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

bool stability_is(const FormFactorMethod *method, const char *name) {
    return strcmp(method->name, name) == 0;
}

bool stability_as_printed(const FormFactorMethod *method) { return method->truth == FORM_FACTOR_GUESS; }

bool stability_fits(const FormFactorMethod *method) {
    return stability_is(method, "hemisphere-scanlines-fit");
}

bool stability_in_floats(const FormFactorMethod *method) { return method->truth == FORM_FACTOR_FLOAT; }

FormFactor *stability_maker_of(Arena *arena, const FormFactorMethod *method, const ViewFixture *f,
                               int resolution) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    return form_factor_new(method, &f->mesh, &options, arena);
}

double stability_share_of(const Mesh *mesh, const Row *row, int face) {
    double sum = 0;
    for (int i = 0; i < row->count; i++)
        if (mesh->elements[row->element[i]].face == face) sum += (double)row->factor[i];
    return sum;
}

double stability_share_at(Arena *arena, const FormFactorMethod *method, const ViewFixture *f, int resolution,
                          Vec3 eye) {
    FormFactor *maker = stability_maker_of(arena, method, f, resolution);
    double share = stability_share_of(
        &f->mesh, form_factor_row(maker, view_fixture_look(arena, f, eye, vec3(0, 0, 1))), 0);
    form_factor_end(maker);
    return share;
}

void stability_slab(Arena *arena, ViewFixture *f, Vec2 low, Vec2 high, double z, double turn, Vec3 shift) {
    const Vec2 p[4] = {{low.x, low.y}, {low.x, high.y}, {high.x, high.y}, {high.x, low.y}};
    Vec3 v[4];
    double c = cos(turn), s = sin(turn);
    for (int k = 0; k < 4; k++)
        v[k] = vec3_add(vec3(c * p[k].x - s * p[k].y, s * p[k].x + c * p[k].y, z), shift);
    view_fixture_quad(arena, f, v[0], v[1], v[2], v[3], 1, 1);
}
