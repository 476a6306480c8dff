// form_factor_fixture.c - see the header.
#include "tests/radiosity/factors/form_factor_fixture.h"

#include <criterion/criterion.h>

#include "tests/support/view_fixture.h"

// How wrong a method may be, of a polygon turned any way: `pixels` / resolution. An edge that runs along a line of pixels
// errs by half a pixel times its length, others by less; the sliver over a wall 1 mm away, 0.0008 of all, is less
// than half a pixel even at 400. Scan lines of one way still see it whole. `least` is what the row's floats leave.
typedef struct Tolerance {
    const char *method;
    double pixels, least;
} Tolerance;

static const Tolerance TOLERANCES[] = {
    {"hemisphere", 0.4, 2e-7},
    {"hemicube", 0.4, 2e-7},
    {"hemisphere-scanline", 0.2, 2e-7},
    {"hemisphere-scanlines", 0.2, 2e-7},
    {"hemisphere-scanlines-fit", 0.8, 2e-7},  // of a quarter of the lines
    {"hemisphere-polyline", 0.4, 2e-7},
    {"analytic", 0, 2e-7},
    {"ray", 0.4, 2e-7},
    {"ray-disc", 0.4, 2e-7},
    {"ray-hemicube", 0.4, 2e-7},
};

double form_factor_tolerance(const FormFactorMethod *method, int resolution) {
    for (size_t i = 0; i < sizeof TOLERANCES / sizeof *TOLERANCES; i++) {
        const Tolerance *t = &TOLERANCES[i];
        if (strcmp(t->method, method->name) == 0) return t->least + t->pixels / resolution;
    }
    cr_assert_fail("no tolerance is stated for method %s", method->name);
    return 0;
}

Vec3 form_factor_spun(Vec3 p, double angle) {
    return vec3(cos(angle) * p.x - sin(angle) * p.y, sin(angle) * p.x + cos(angle) * p.y, p.z);
}

double form_factor_share(Arena *arena, const ViewFixture *f, const FormFactorMethod *method, int resolution,
                         Vec3 eye) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    FormFactor *maker = form_factor_new(method, &f->mesh, &options, arena);
    const Row *row = form_factor_row(maker, view_fixture_look(arena, f, eye, vec3(0, 0, 1)));
    double sum = 0;
    for (int i = 0; i < row->count; i++)
        if (f->mesh.elements[row->element[i]].face == 0) sum += (double)row->factor[i];
    form_factor_end(maker);
    return sum;
}
