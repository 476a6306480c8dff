// shoot_fixture.c - see the header.
#include "tests/radiosity/shoot/shoot_fixture.h"

#include <criterion/criterion.h>

#include "tests/support/lit_fixture.h"

RadOptions shoot_options_to(double residual) {
    RadOptions o = rad_default_options();
    o.form_factor.resolution = 50;
    o.residual = residual;
    o.threads = 2;
    return o;
}

double shoot_lost_power(const Lit *lit, const RadSolution *s) {
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        double unshot = 0;
        for (int p = 0; p < s->patch_count; p++) unshot += s->unshot[p][c] * lit->mesh.patches[p].area;
        double lost = s->emitted[c] - s->absorbed[c] - s->escaped[c] - unshot;
        worst = fmax(worst, fabs(lost) / s->emitted[c]);
    }
    return worst;
}
