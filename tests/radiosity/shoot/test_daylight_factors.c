// test_daylight_factors.c - daylight factors in a room lit from one side under the CIE overcast sky: the light that a point of the
// working plane receives, of the light on level ground that nothing shades.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/app/bake_probes.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/radiosity/shoot/sky_fixture.h"

// The room: the window lies in the wall x = 0, in its middle; the working plane is at the height of a desk.
static const double WIDTH = 4, DEPTH = 6, THICK = 0.2, PLANE = 0.85;
static const double WINDOW[2] = {2, 1.5}, SILL = 0.9;
enum { PLACES = 6 };

static Vec3 place(int i) { return vec3(0.5 + i, WIDTH / 2, PLANE); }

static Lit *side_lit_room(double floor, double walls, double ceiling, double element) {
    Arena arena = {0};
    const char *text = arena_format(
        &arena,
        "material f reflectance %g\nmaterial w reflectance %g\nmaterial c reflectance %g\nfacade w\n"
        "room a 0,0 %g,0 %g,%g 0,%g floor f ceiling c walls w wall %g height 3\n"
        "window v %g,%g angle 90 width %g sill %g height %g\n",
        floor, walls, ceiling, DEPTH, DEPTH, WIDTH, WIDTH, THICK, -THICK / 2, WIDTH / 2, WINDOW[0], SILL,
        WINDOW[1]);
    Lit *lit = sky_read_plan_with(text, element, 2);
    arena_free(&arena);
    return lit;
}

static Daylight overcast(void) {
    SunPosition sun = sun_position(2026, 3, 21, 12, 50 * M_PI / 180, 0);
    return daylight_of(&sun, 0, DAYLIGHT_OVERCAST);
}

// Irradiance as `bake --probe` gathers it, the green channel.
static void gather_places(Lit *lit, const RadSolution *s, double out[PLACES]) {
    Arena arena = {0};
    Probes probes = {ARENA_ARRAY(&arena, Probe, PLACES), PLACES, PLACES};
    for (int i = 0; i < PLACES; i++) probes.probes[i] = (Probe){.place = place(i), .normal = {0, 0, 1}};
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, s, NULL}, 1, &probes);
    for (int i = 0; i < PLACES; i++) out[i] = probes.probes[i].irradiance[1];
    arena_free(&arena);
}

static RadSolution baked(Lit *lit, const Daylight *day) {
    RadOptions options = sky_options_of(CULL_STAB, 0);
    RadSolution s = sky_day_shone(lit, day, &options);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    return s;
}

// Proves daylight factors against path tracing, the light on level ground too. Tolerance: 3 %, which is what measurements of real rooms
// tell apart; paths are exact to 0.4 %.
Test(sky, daylight_factors, .timeout = 120) {
    enum { ON_ROOF = PLACES };
    Lit *lit = side_lit_room(0.2, 0.5, 0.7, 0.25);
    Daylight day = overcast();
    RadSolution s = baked(lit, &day);
    PathTracer *tracer = path_tracer_new(&lit->mesh, &day, &lit->arena);
    PathQuery query[PLACES + 1];
    PathResult truth[PLACES + 1];
    double gathered[PLACES], level[3], worst = 0;
    for (int i = 0; i <= PLACES; i++)
        query[i] = (PathQuery){
            i < ON_ROOF ? place(i) : vec3(0, 0, 50), {0, 0, 1}, 0.004, 0, 2000000, (uint64_t)i + 1};
    path_tracer_irradiance(tracer, query, PLACES + 1, 0, truth);
    gather_places(lit, &s, gathered);
    daylight_horizontal(&day, level);
    cr_expect_float_eq(truth[ON_ROOF].irradiance[1] / level[1], 1, 0.005);
    for (int i = 0; i < PLACES; i++) {
        double factor = gathered[i] / level[1], want = truth[i].irradiance[1] / truth[ON_ROOF].irradiance[1];
        printf("%.1f m from the window: daylight factor %.3f %%, by paths %.3f +- %.3f %%, %+.2f %% off\n",
               place(i).x, 100 * factor, 100 * want, 100 * truth[i].standard_error[1] / level[1],
               100 * (factor / want - 1));
        worst = fmax(worst, fabs(factor / want - 1));
    }
    cr_expect_lt(worst, 0.03);
    path_tracer_end(tracer);
    lit_free(lit);
}

// The part of the light on level ground that comes through the window alone: the radiance of the overcast sky, 1 + 4 exp(-0.7 / cos z)
// at an angle z from the zenith (ISO 15469, type 1), summed over squares of the window's outer outline that the inner one leaves in sight,
// less what the pane keeps at the angle of each line.
static double through_window(Vec3 from) {
    enum { ACROSS = 400 };
    double light = 0, level = 0;
    for (int i = 0; i < ACROSS; i++)
        for (int j = 0; j < ACROSS; j++) {
            double y = (WIDTH - WINDOW[0]) / 2 + WINDOW[0] * (i + 0.5) / ACROSS,
                   z = SILL + WINDOW[1] * (j + 0.5) / ACROSS;
            Vec3 way = vec3_sub(vec3(-THICK, y, z), from);
            Vec3 inner = vec3_add(from, vec3_scale(way, from.x / (from.x + THICK)));
            if (way.z <= 0 || inner.z < SILL || inner.z > SILL + WINDOW[1] ||
                fabs(inner.y - WIDTH / 2) > WINDOW[0] / 2)
                continue;
            double far = vec3_length(way), up = way.z / far, across = -way.x / far;
            light += (1 + 4 * exp(-0.7 / up)) * up * across * glass_transmits(across) / (far * far) *
                     WINDOW[0] * WINDOW[1] / (ACROSS * ACROSS);
        }
    for (int i = 0; i < 100000; i++) {
        double up = (i + 0.5) / 100000;
        level += 2 * M_PI * (1 + 4 * exp(-0.7 / up)) * up / 100000;
    }
    return light / level;
}

// Proves the part that comes straight from the sky in a black room against a sum over the window, which shares no code with the rest but
// the transmittance of glass.
// Tolerance: the bar of 3 %.
Test(sky, daylight_factors_of_a_black_room, .timeout = 120) {
    Lit *lit = side_lit_room(0, 0, 0, 0.5);
    Daylight day = overcast();
    RadSolution s = baked(lit, &day);
    double gathered[PLACES], level[3];
    gather_places(lit, &s, gathered);
    daylight_horizontal(&day, level);
    for (int i = 0; i < PLACES; i++) {
        double factor = gathered[i] / level[1], want = through_window(place(i));
        printf("%.1f m from the window: %.4f %%, summed %.4f %%, %+.2f %% off\n", place(i).x, 100 * factor,
               100 * want, 100 * (factor / want - 1));
        cr_expect_lt(fabs(factor / want - 1), 0.03);
    }
    lit_free(lit);
}
