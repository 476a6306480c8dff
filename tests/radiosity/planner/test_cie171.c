// test_cie171.c - cases of CIE 171:2006 (Test Cases to Assess the Accuracy of Lighting Computer Programs) as far as their subjects are
// told openly, each with a closed form of our own instead of the report's tables. Sizes are our own where they are not told.
//
// The bar is half a percent; each test prints its worst error.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/planner/room_light.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/gather.h"
#include "tests/radiosity/shoot/sky_fixture.h"
#include "tests/radiosity/show/gather_fixture.h"

static const double BAR = 0.005;

static double worst_off(double worst, double found, double right) {
    return fmax(worst, fabs(found / right - 1));
}

static double at(const Lit *lit, const RadSolution *s, Vec3 p, Vec3 n) {
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, s, NULL};
    GatherOptions options = gather_default_options();
    double h[3];
    if (daylight_shines(&s->day)) options.resolution = ROOM_SKY_RESOLUTION;
    gather_once(&scene, &options, p, n, h);
    return h[1];
}

static Lit *black_room(void) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].reflectance = (Rgb){0, 0, 0};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 4, 3), true, LIT_WALL, 0);
    return lit;
}

// 5.2, a point source: a lamp of 2 cm in the middle of a black room of 4 x 4 x 3 m, at points of the floor: I cos^2 / d^2, I by Lambert's
// cosine. Tolerance: the bar; the lamp's size is worth 2e-5.
Test(cie171, point_source) {
    Lit *lit = black_room();
    double half = 0.01, z = 2.9, worst = 0;
    lit_quad(lit, vec3(2 - half, 2 - half, z), vec3(2 - half, 2 + half, z), vec3(2 + half, 2 + half, z),
             vec3(2 + half, 2 - half, z), LIT_LAMP);
    lit_finish(lit, 0.5, 2);
    RadSolution s;
    RadOptions options = rad_default_options();
    lit_shoot(lit, &options, &s);
    for (int i = 0; i < 16; i++) {
        Vec3 p = {0.25 + i % 4, 0.25 + i / 4, 0}, to = vec3_sub(vec3(2, 2, z), p);
        double d2 = vec3_dot(to, to), cosine2 = z * z / d2;
        worst = worst_off(worst, at(lit, &s, p, vec3(0, 0, 1)), 10 * 4 * half * half / M_PI * cosine2 / d2);
    }
    printf("5.2 point source: %.4f %%\n", 100 * worst);
    cr_expect_lt(worst, BAR);
    lit_free(lit);
}

// 5.3, an area source: a lamp of 1 x 1 m, at points of the floor and of a wall, against the sum over 10^6 parts of it.
Test(cie171, area_source) {
    Lit *lit = black_room();
    double worst = 0;
    lit_lamp(lit, vec3(2, 2, 2.95));
    lit_finish(lit, 0.5, 2);
    RadSolution s;
    RadOptions options = rad_default_options();
    lit_shoot(lit, &options, &s);
    for (int i = 0; i < 12; i++) {
        bool wall = i >= 8;
        Vec3 p = wall ? vec3(0, 0.5 + i % 4, 0.4 + 0.6 * (i % 4)) : vec3(0.5 + i % 4, 0.5 + 1.5 * (i / 4), 0),
             n = wall ? vec3(1, 0, 0) : vec3(0, 0, 1);
        enum { ACROSS = 1000 };
        double sum = 0;
        for (int k = 0; k < ACROSS * ACROSS; k++) {
            Vec3 to =
                vec3_sub(vec3(1.5 + (k % ACROSS + 0.5) / ACROSS, 1.5 + (k / ACROSS + 0.5) / ACROSS, 2.95), p);
            double d2 = vec3_dot(to, to);
            sum += 10 / M_PI * vec3_dot(to, n) * to.z / (d2 * d2) / (ACROSS * ACROSS);
        }
        worst = worst_off(worst, at(lit, &s, p, n), sum);
    }
    printf("5.3 area source: %.4f %%\n", 100 * worst);
    cr_expect_lt(worst, BAR);
    lit_free(lit);
}

// 5.8, the internal reflected component: a closed cube whose sides reflect alike. The light that arrives after reflection is, in the mean
// over all sides, that of the sphere, phi rho / (A (1 - rho)), for 0.3, 0.5, 0.7 and 0.9.
Test(cie171, internal_reflected_component) {
    static const float RHO[] = {0.3f, 0.5f, 0.7f, 0.9f};
    double worst = 0;
    for (int i = 0; i < 4; i++) {
        Lit *lit = lit_new();
        lit->building->materials[LIT_WALL].reflectance = (Rgb){RHO[i], RHO[i], RHO[i]};
        // The lamp is a side of the cube that reflects as all others do.
        lit->building->materials[LIT_LAMP].reflectance = (Rgb){RHO[i], RHO[i], RHO[i]};
        lit_box(lit, vec3(0, 0, 0), vec3(4, 4, 4), true, LIT_WALL, 1 << 5);
        lit_quad(lit, vec3(0, 0, 4), vec3(0, 4, 4), vec3(4, 4, 4), vec3(4, 0, 4), LIT_LAMP);
        lit_finish(lit, 0.5, 2);
        RadSolution s;
        RadOptions options = rad_default_options();
        options.residual = 1e-6;
        lit_shoot(lit, &options, &s);
        double reflected = 0, phi = 10 * 16, rho = (double)RHO[i];
        for (int e = 0; e < lit->mesh.element_count; e++) {
            double emitted = (double)mesh_material(&lit->mesh, lit->mesh.elements[e].face)->emission.g;
            reflected += (s.radiosity[e][1] - emitted) / rho * lit->mesh.elements[e].area;
        }
        // All that arrives, less what arrives straight from the lamp, phi.
        worst = worst_off(worst, reflected - phi, phi * rho / (1 - rho));
        lit_free(lit);
    }
    printf("5.8 internal reflected component: %.4f %%\n", 100 * worst);
    cr_expect_lt(worst, BAR);
}

// 5.9, an opening without glass in the roof: a black room of 4 x 4 x 3 m with a hole of 1 x 1 m, whose roof is thin. The light at points of
// the floor is the sum over the hole, of a uniform sky and of the CIE overcast sky.
static double radiance(const double cie[2], double up) { return (1 + cie[0] * exp(cie[1] / up)); }

static void roof_opening(const char *name, const Daylight *day, const double cie[2]) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].reflectance = (Rgb){0, 0, 0};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 4, 3), true, LIT_WALL, 1 << 5);
    static const double RECT[4][4] = {{0, 0, 4, 1.5}, {0, 2.5, 4, 4}, {0, 1.5, 1.5, 2.5}, {2.5, 1.5, 4, 2.5}};
    for (int i = 0; i < 4; i++) {
        const double *r = RECT[i];
        lit_quad(lit, vec3(r[0], r[1], 3), vec3(r[0], r[3], 3), vec3(r[2], r[3], 3), vec3(r[2], r[1], 3),
                 LIT_WALL);
    }
    lit_finish(lit, 0.25, 2);
    RadOptions options = sky_options_of(CULL_STAB, 0);
    RadSolution s = sky_day_shone(lit, day, &options);
    double level[3], worst = 0;
    daylight_horizontal(day, level);
    for (int i = 0; i < 9; i++) {
        enum { ACROSS = 400 };
        Vec3 p = {0.5 + 1.5 * (i % 3), 0.5 + 1.5 * (i / 3), 0};
        double light = 0, all = 0;
        for (int k = 0; k < ACROSS * ACROSS; k++) {
            Vec3 to =
                vec3_sub(vec3(1.5 + (k % ACROSS + 0.5) / ACROSS, 1.5 + (k / ACROSS + 0.5) / ACROSS, 3), p);
            double d2 = vec3_dot(to, to), up = to.z / sqrt(d2);
            light += radiance(cie, up) * up * up / d2 / (ACROSS * ACROSS);
        }
        for (int k = 0; k < 100000; k++) {
            double up = (k + 0.5) / 100000;
            all += 2 * M_PI * radiance(cie, up) * up / 100000;
        }
        worst = worst_off(worst, at(lit, &s, p, vec3(0, 0, 1)) / level[1], light / all);
    }
    printf("5.9 roof opening, %s sky: %.4f %%\n", name, 100 * worst);
    cr_expect_lt(worst, BAR);
    lit_free(lit);
}

Test(cie171, roof_opening) {
    static const double EVEN[3] = {1, 1, 1}, UNIFORM[2] = {0, -1}, OVERCAST[2] = {4, -0.7};
    static const SunPosition SUN = {.altitude = 1, .distance = 1};
    Daylight even = daylight_uniform(EVEN), overcast = daylight_of(&SUN, 0, DAYLIGHT_OVERCAST);
    roof_opening("uniform", &even, UNIFORM);
    roof_opening("overcast", &overcast, OVERCAST);
}
