// light_fixture.c - see the header.
#include "tests/radiosity/shoot/light_fixture.h"

#include <criterion/criterion.h>

#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

// Emitted light was absorbed, escaped, or is left, but for rounding of sums of a million floats.
static const double BALANCE = 1e-12;

double light_sum3(const double v[3]) { return v[0] + v[1] + v[2]; }

void light_check_balance(const Lit *lit, const RadSolution *s) {
    double lost = baked_lost(lit, s);
    cr_assert_lt(lost, BALANCE, "%g of the power is lost", lost);
}

BakedErrors light_check_traced(const char *name, Lit *lit, const RadSolution *s, int first, int end,
                               int count, long long most_paths) {
    count = support_count(count / 2, count);
    BakedPoint *points = baked_points(lit, first, end, count);
    baked_trace(lit, 0.004, most_paths, points, count);
    BakedErrors errors = baked_errors(lit, s, points, count);
    baked_print(name, &errors);
    return errors;
}
