// test_shoot_rooms.c - rooms that get little of a building's light get all of it.
#include <criterion/criterion.h>
#include <math.h>

#include "radiosity/shoot/room_shares.h"
#include "tests/radiosity/shoot/shoot_fixture.h"
#include "tests/radiosity/shoot/sky_fixture.h"

// A room with a lamp, and one that gets a few thousandths of its light through a hole below the ceiling.
static Lit *two_rooms(void) {
    return sky_read_plan_with("material glow #FFFFFF emission 30\n"
                              "room bright 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                              "room dim 4.2,0 7,0 7,3 4.2,3 floor oak ceiling white walls white wall 0.2\n"
                              "passage hole 4.1,1.5 angle 90 width 0.4 height 0.3 sill 2\n"
                              "inlay glow ceiling 1,1 2,1 2,2 1,2\n",
                              0.25, 2);
}

static const char *name_of(const Lit *lit, int patch) {
    int cell = lit->mesh.patches[patch].cell;
    return cell < 0 ? "" : vis_region(&lit->graph, cell)->name;
}

// The power that leaves the surfaces of a room, W.
static double light_of(const Lit *lit, const RadSolution *s, const char *room) {
    double sum = 0;
    for (int e = 0; e < lit->mesh.element_count; e++)
        if (strcmp(name_of(lit, lit->mesh.elements[e].patch), room) == 0)
            sum += lit->mesh.elements[e].area * rgb_sum(s->radiosity[e]);
    return sum;
}

// Proves that a room lacks no more of its light than the building does: shot to a residual of 1e-2 it has what it has at 1e-8, less one
// part in a hundred and what reflects that (surfaces reflect .8 at most: five times as much). Without rooms a tenth is missing.
Test(shoot, each_room_has_its_light) {
    Lit *lit = two_rooms();
    RadOptions options = shoot_options_to(1e-8);
    RadSolution whole, rooms, building;
    lit_shoot(lit, &options, &whole);
    double dim = light_of(lit, &whole, "dim"), bright = light_of(lit, &whole, "bright");
    cr_assert_lt(dim, 0.01 * bright, "the dim room has %g of %g W", dim, bright);
    options.residual = 0.01;
    lit_shoot(lit, &options, &rooms);
    options.each_room = false;
    lit_shoot(lit, &options, &building);
    cr_expect_gt(light_of(lit, &rooms, "dim"), (1 - 0.05) * dim, "%g of %g W", light_of(lit, &rooms, "dim"),
                 dim);
    cr_expect_lt(light_of(lit, &building, "dim"), 0.9 * dim, "%g of %g W", light_of(lit, &building, "dim"),
                 dim);
    cr_expect_lt(shoot_lost_power(lit, &rooms), 1e-12);
    lit_free(lit);
}

// Proves that sums kept from shot to shot are those of the solution: a run that is broken off in a room and goes on ends in the same bytes.
Test(shoot, a_room_goes_on_where_it_stopped) {
    Lit *lit = two_rooms();
    RadOptions options = shoot_options_to(0.01);
    RadSolution straight, s;
    options.each_room = false;
    long long first = lit_shoot(lit, &options, &s).shots;
    options.each_room = true;
    long long all = lit_shoot(lit, &options, &straight).shots;
    cr_assert_gt(all, first + 20, "%lld and %lld shots", first, all);
    options.shots = first;
    lit_shoot(lit, &options, &s);
    for (options.shots = first + 1; options.shots < all; options.shots += (all - first) / 4 + 1)
        rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    options.shots = 0;
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    cr_assert_eq(s.shots, straight.shots);
    for (int e = 0; e < s.element_count; e++)
        cr_assert_arr_eq(s.radiosity[e], straight.radiosity[e], sizeof *s.radiosity, "element %d", e);
    lit_free(lit);
}
