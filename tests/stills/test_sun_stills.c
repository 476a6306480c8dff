// test_sun_stills.c - stills light places from the sun's disc.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/stills/still_light.h"
#include "radiosity/show/direct.h"
#include "tests/radiosity/shoot/sky_fixture.h"
#include "tests/support/lit_fixture.h"

// The share of a disc on one side of a line that passes its middle at a distance of u radii.
static double share_beyond(double u) {
    if (fabs(u) >= 1) return u > 0;
    return 0.5 + (asin(u) + u * sqrt(1 - u * u)) / M_PI;
}

// Proves that a still has the sun's penumbra and counts no light of the sun twice: under the straight edge of a plate 5 m above the
// ground light is a segment of the disc, wherever elements of half a metre end, beside an even 7 W/m^2 that the ground reflects. Tolerance:
// 4,096 evenly spread rays miss a segment by 1 % at most; light at nodes, less that of the sun, is right to the roundings of both.
Test(sun_stills, penumbra_in_closed_form) {
    Lit *lit = lit_new();
    RadSolution s;
    Error error;
    double radius = 5 * tan(DAYLIGHT_SUN_RADIUS), worst = 0;
    MeshOptions options = mesh_default_options();
    static const MeshSplits EVEN = {.even = 1};
    lit_quad(lit, vec3(-5, -5, 0), vec3(5, -5, 0), vec3(5, 5, 0), vec3(-5, 5, 0), LIT_WALL);
    lit_quad(lit, vec3(-9, -9, 5), vec3(0.3, -9, 5), vec3(0.3, 9, 5), vec3(-9, 9, 5), LIT_WALL);
    options.element = 0.5;
    options.splits = &EVEN;
    lit_finish_with(lit, &options);
    const Mesh *mesh = &lit->mesh;
    cr_assert(rad_start_dark(mesh, &lit->arena, &s, &error), "%s", error.text);
    s.day = (Daylight){.sun = {0, 0, 1}, .beam = {100, 100, 100}};
    Nodes nodes = nodes_of(mesh, &lit->arena);
    s.node_count = nodes.count;
    s.node = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *s.node);
    cr_assert(direct_irradiance(mesh, &lit->forest, &nodes, &s.day, 2, NULL, s.node, NULL));
    s.rest = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *s.rest);
    for (int n = 0; n < nodes.count; n++)
        for (int c = 0; c < 3; c++) s.node[n][c] = (s.rest[n][c] = 7) + 0.5 * s.node[n][c];
    StillScene *scene = still_scene_new(mesh, NULL, STILL_TREE_OWN, &lit->arena);
    StillLamps *lamps = still_lamps_new(scene, &lit->forest, 16, &lit->arena);
    StillLight light = still_light_new(scene, &s, lamps, &lit->arena);
    for (int i = -6; i <= 6; i++) {
        double u = i / 5.0, out[3];
        StillNumbers numbers = {{0.1, 0.2, 0.3}, 0};
        Ray ray = {vec3(0.3 + u * radius, 0.11, 1), vec3(0, 0, -1), 0, INFINITY};
        SurfaceHit hit = still_rays_first(scene->all, &ray);
        still_light_at(&light, &ray, &hit, 0, 4096, &numbers, out);
        worst = fmax(worst, fabs((out[1] - 7) / 50 - share_beyond(u)));
    }
    printf("off by %.2g of the sun's light\n", worst);
    cr_expect_lt(worst, 0.01);
    still_lamps_end(lamps);
    lit_free(lit);
}

// Proves that a pane weakens a still's light from the sun, and from a lamp outside, once: by its transmittance at the angle of the light.
// Tolerances: the sun is half a degree wide, the lamp 0.1 m at 5 m; shadow rays meet points of both alike with the pane and without.
Test(sun_stills, light_through_a_pane) {
    Lit *lit = sky_read_plan_with("material lamp #FFFFFF emission 900\n"
                                  "room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                                  "window w 4.1,1.5 angle 90 width 2 sill 0.5 height 1.9\n"
                                  "model l\n  box -0.05,-0.05,0 0.05,0.05,0.1 lamp\nend\nplace l 7,1.4,1.5\n",
                                  0.5, 2);
    Mesh bare = lit->mesh;
    bare.panes.count = 0;
    double light[2][2][3];  // of sun and lamp, with the pane and without
    Vec3 at = {2.6, 1.5, 0}, sun = vec3_normalize(vec3(2, -0.2, 1.3)),
         lamp = vec3_sub(vec3(7, 1.4, 1.55), at);
    for (int i = 0; i < 2; i++) {
        const Mesh *mesh = i ? &bare : &lit->mesh;
        RadSolution s;
        Error error;
        cr_assert(rad_start(mesh, &lit->arena, &s, &error), "%s", error.text);
        Nodes nodes = nodes_of(mesh, &lit->arena);
        s.node_count = nodes.count;
        s.node = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *s.node);
        s.rest = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *s.rest);
        for (int by_sun = 0; by_sun < 2; by_sun++) {
            s.day = (Daylight){.sun = sun, .beam = {by_sun * 1e3, by_sun * 1e3, by_sun * 1e3}};
            StillScene *scene = still_scene_new(mesh, NULL, STILL_TREE_OWN, &lit->arena);
            StillLamps *lamps = still_lamps_new(scene, &lit->forest, 16, &lit->arena);
            StillLight still = still_light_new(scene, &s, lamps, &lit->arena);
            StillNumbers numbers = {{0.1, 0.2, 0.3}, 0};
            Ray ray = {vec3_add(at, vec3(0, 0, 0.5)), vec3(0, 0, -1), 0, INFINITY};
            SurfaceHit hit = still_rays_first(scene->all, &ray);
            still_light_at(&still, &ray, &hit, 0, 4096, &numbers, light[i][by_sun]);
            still_lamps_end(lamps);
        }
    }
    double by_lamp = light[0][0][1] / light[1][0][1],
           by_sun = (light[0][1][1] - light[0][0][1]) / (light[1][1][1] - light[1][0][1]);
    cr_expect(light[1][0][1] > 1e-3 && light[1][1][1] > 10 * light[1][0][1]);
    cr_expect_float_eq(by_lamp, glass_transmits(vec3_normalize(lamp).x), 2e-3, "%g of the lamp", by_lamp);
    cr_expect_float_eq(by_sun, glass_transmits(sun.x), 1e-3, "%g of the sun", by_sun);
    lit_free(lit);
}
