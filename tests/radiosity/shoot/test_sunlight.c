// test_sunlight.c - the sun on elements: areas of shadows in closed form, shares against rays, rooms by day against path tracing.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/random.h"
#include "radiosity/shoot/sunlight.h"
#include "radiosity/truth/path_walk.h"
#include "tests/radiosity/shoot/sky_fixture.h"
#include "tests/support/lit_fixture.h"

// The whole scene's lit area of faces with this material, m^2.
static double lit_area(Lit *lit, Vec3 sun, int material) {
    double *share = ARENA_ARRAY(&lit->arena, double, lit->mesh.element_count), area = 0;
    sunlight_shares(&lit->mesh, vec3_normalize(sun), true, 1, share);
    for (int e = 0; e < lit->mesh.element_count; e++)
        if (lit->mesh.faces[lit->mesh.elements[e].face].material == material)
            area += share[e] * lit->mesh.elements[e].area;
    return area;
}

static void lay_square(Lit *lit, double x, double y, double z, double side, int material) {
    lit_quad(lit, vec3(x, y, z), vec3(x + side, y, z), vec3(x + side, y + side, z), vec3(x, y + side, z),
             material);
}

static Daylight clear_day(double degrees, double azimuth) {
    SunPosition sun = {degrees * M_PI / 180, azimuth * M_PI / 180, 1};
    return daylight_of(&sun, 0, DAYLIGHT_CLEAR);
}

// Proves shadows in closed form: level plates throw shadows of their own areas on level ground, wherever the sun stands, and overlapping
// shadows count once. Here two plates of 1 m^2 overlap by 0.5 x 0.5 as the sun sees them, being 1 m apart in height under a sun that
// moves the shadow by (0.3, 0.2) a metre; elements of 0.37 m are not aligned with any of it. Tolerance: slivers, 1e-9 of each element.
Test(sunlight, shadows_in_closed_form) {
    Lit *lit = lit_new();
    lay_square(lit, 0, 0, 0, 6, LIT_WALL);
    lay_square(lit, 2, 2, 1, 1, LIT_RED);
    lay_square(lit, 2.5 + 0.3, 2.5 + 0.2, 2, 1, LIT_RED);
    lit_finish(lit, 0.37, 2);
    Vec3 sun = {0.3, 0.2, 1};
    cr_expect_float_eq(lit_area(lit, sun, LIT_WALL), 36 - 1.75, 1e-7);
    cr_expect_float_eq(lit_area(lit, sun, LIT_RED), 2 - 0.25, 1e-7,
                       "the lower plate is in the higher one's shadow");
    cr_expect_float_eq(lit_area(lit, vec3(-0.3, 0.1, -1), LIT_WALL), 0, 0, "a sun below shines on backs");
    lit_free(lit);
}

// Proves which of two faces in one place the sun meets: one of them alone, the first; and that a wall without thickness is lit on the
// sun's side only. Exact.
Test(sunlight, faces_in_one_place) {
    Lit *lit = lit_new();
    lay_square(lit, 0, 0, 0, 2, LIT_RED);
    lay_square(lit, 0, 0, 0, 2, LIT_WALL);
    lit_quad(lit, vec3(9, 0, 0), vec3(9, 1, 0), vec3(9, 1, 1), vec3(9, 0, 1), LIT_LAMP);
    lit_quad(lit, vec3(9, 0, 0), vec3(9, 0, 1), vec3(9, 1, 1), vec3(9, 1, 0), LIT_LAMP);
    lit_finish(lit, 0.3, 2);
    Vec3 sun = {0.5, 0.1, 1};
    cr_expect_float_eq(lit_area(lit, sun, LIT_RED), 4, 1e-9);
    cr_expect_eq(lit_area(lit, sun, LIT_WALL), 0);
    cr_expect_float_eq(lit_area(lit, sun, LIT_LAMP), 1, 1e-9);
    lit_free(lit);
}

// Proves that closed rooms stay dark from every side: no light comes in along the lines where faces meet. Two rooms share a wall without
// thickness, and the lower one's ceiling ends on the higher one's wall. Tolerance: none.
Test(sunlight, closed_rooms_are_dark) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0.1, 0.2, 0), vec3(4.3, 3.1, 2.5), true, LIT_RED, 0);
    lit_box(lit, vec3(4.3, 0.2, 0), vec3(7, 3.1, 3.3), true, LIT_RED, 0);
    lay_square(lit, -10, -10, -0.1, 20, LIT_WALL);
    lit_finish(lit, 0.4, 2);
    Random random = {1};
    for (int i = 0; i < 40; i++) {
        double angle = 2 * M_PI * random_unit(&random), up = 0.02 + 0.97 * random_unit(&random),
               across = sqrt(1 - up * up);
        Vec3 sun = {cos(angle) * across, sin(angle) * across, up};
        cr_assert_eq(lit_area(lit, sun, LIT_RED), 0);
        double ground = lit_area(lit, sun, LIT_WALL);
        cr_assert(ground > 100 && ground < 400 - 7.8 * 2.7, "%g m^2 of the ground are lit", ground);
    }
    lit_free(lit);
}

// The share of an element from whose points a ray to the sun meets nothing, times what glass on the ray lets through. Points
// are drawn in triangles of its fan.
static double share_by_rays(const PathScene *scene, const Mesh *mesh, int element, Vec3 sun, int count,
                            Random *random) {
    const Element *e = &mesh->elements[element];
    const int *corner = mesh->corners + e->first_corner;
    Vec3 a = mesh->vertices[corner[0]];
    double seen = 0, all = 0;
    for (int i = 1; i + 1 < e->corner_count; i++) {
        Vec3 b = vec3_sub(mesh->vertices[corner[i]], a), c = vec3_sub(mesh->vertices[corner[i + 1]], a);
        double area = vec3_length(vec3_cross(b, c)) / 2 / e->area;
        int rays = (int)ceil(area * count);
        double free_rays = 0;
        for (int k = 0; k < rays; k++) {
            double u = sqrt(random_unit(random)), v = random_unit(random);
            Vec3 p = vec3_add(a, vec3_add(vec3_scale(b, u * (1 - v)), vec3_scale(c, u * v)));
            p = vec3_sub(vec3_add(p, vec3_scale(mesh->faces[e->face].plane.n, 1e-4)),
                         path_scene_origin(scene));
            if (path_scene_trace(scene, p, sun).face < 0)
                free_rays +=
                    panes_transmit_from_afar(&mesh->panes, vec3_add(p, path_scene_origin(scene)), sun);
        }
        if (rays > 0) seen += area * free_rays / rays;
        all += area;
    }
    return seen / all;
}

// Proves the shares in a furnished house against rays, which share neither projection nor clipping: of 60 elements that the sun meets in
// part, and 60 others that face it. Tolerance: with 400 rays five standard deviations are at most 0.125; a ray begins 0.1 mm before its
// face. And that beams through portals miss no cell: the bytes are the same without them, and on three threads.
Test(sunlight, shares_against_rays, .timeout = 60) {
    Lit *lit = sky_room_with_window(1.2, 1.3, 0.2);
    const Mesh *mesh = &lit->mesh;
    Vec3 sun = vec3_normalize(vec3(1, -0.15, 0.45));
    size_t bytes = (size_t)mesh->element_count * sizeof(double);
    double *share = ARENA_ARRAY(&lit->arena, double, mesh->element_count);
    double *whole = ARENA_ARRAY(&lit->arena, double, mesh->element_count);
    sunlight_shares(mesh, sun, true, 1, share);
    sunlight_shares(mesh, sun, false, 3, whole);
    cr_assert_arr_eq(share, whole, bytes);
    PathScene *scene = path_scene_new(mesh, &lit->arena);
    Random random = {7};
    int parts = 0, others = 0, indoors = 0;
    for (int i = 0; i < mesh->element_count && (parts < 60 || others < 60); i++) {
        int e = (int)((long long)i * 7919 % mesh->element_count);
        bool part = share[e] > 0.01 && share[e] < 0.99;
        if (!(vec3_dot(mesh->faces[mesh->elements[e].face].plane.n, sun) > 0.01)) continue;
        int *taken = part ? &parts : &others;
        if ((*taken)++ >= 60) continue;
        int cell = mesh->patches[mesh->elements[e].patch].cell;
        indoors += cell >= 0 && vis_region(&lit->graph, cell)->kind == REGION_ROOM && share[e] > 0;
        double want = share_by_rays(scene, mesh, e, sun, 400, &random);
        cr_expect_float_eq(share[e], want, 0.125, "element %d: %g, by rays %g", e, share[e], want);
    }
    cr_expect(parts > 30 && others >= 60 && indoors > 10, "%d parts, %d others, %d indoors", parts, others,
              indoors);
    path_scene_end(scene);
    lit_free(lit);
}

// Proves a room by day, with sun, a sky by direction and light from the ground, against path tracing, and that no light is lost.
// Tolerances: as for an even sky (test_sky_rooms.c).
Test(sunlight, room_by_day, .timeout = 300) {
    Lit *lit = sky_room_with_window(1.2, 1.3, 0.25);
    Daylight day = clear_day(25, 80);
    RadOptions options = sky_options_of(CULL_STAB, 0);
    RadSolution s = sky_day_shone(lit, &day, &options);
    sky_check_conserved(lit, &s);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    double errors[SKY_POINTS];
    int count = sky_errors_of(lit, &s, errors);
    cr_assert_geq(count, sky_point_count() * 5 / 8);
    cr_assert_leq(errors[count / 2], 0.02, "median %.2f %%", 100 * errors[count / 2]);
    cr_assert_leq(errors[count - 1], 0.1, "at most %.2f %%", 100 * errors[count - 1]);
    sky_check_conserved(lit, &s);
    lit_free(lit);
}

// Proves that a solution of a day that was broken off shoots on to the same light.
Test(sunlight, shoots_on, .timeout = 60) {
    Lit *lit = sky_room_with_window(1.2, 1.3, 0.2);
    Daylight day = clear_day(25, 80);
    RadOptions whole = sky_options_of(CULL_STAB, 0), part = whole;
    whole.form_factor.resolution = 60;
    part.form_factor.resolution = 60;
    part.shots = 40;
    RadSolution at_once = sky_day_shone(lit, &day, &whole), parts = sky_day_shone(lit, &day, &whole);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &whole, NULL, &at_once);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &part, NULL, &parts);
    cr_assert_not(parts.gathered);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &whole, NULL, &parts);
    cr_expect_arr_eq(parts.radiosity, at_once.radiosity,
                     (size_t)at_once.element_count * sizeof *at_once.radiosity);
    cr_expect_arr_eq(parts.reflected, at_once.reflected,
                     (size_t)at_once.patch_count * sizeof *at_once.reflected);
    lit_free(lit);
}

// Proves that neither culling nor threads change a bit of a day.
Test(sunlight, same_culled_and_on_any_number_of_threads, .timeout = 60) {
    Lit *lit = sky_room_with_window(1, 1, 0.5);
    Daylight day = clear_day(30, 100);
    RadOptions one = sky_options_of(CULL_STAB, 1);
    RadSolution first = sky_day_shone(lit, &day, &one);
    for (int i = 0; i <= CULLINGS; i++) {
        RadOptions options = i < CULLINGS ? sky_options_of((Culling)i, 1) : sky_options_of(CULL_STAB, 3);
        RadSolution s = sky_day_shone(lit, &day, &options);
        cr_assert_arr_eq(s.radiosity, first.radiosity, (size_t)s.element_count * sizeof *s.radiosity);
        cr_assert_arr_eq(s.outdoors, first.outdoors, sizeof s.outdoors);
    }
    lit_free(lit);
}

// Proves the light on open ground in closed form: beam times sine of the altitude, and the sky's irradiance. Tolerance: the sky is seen on
// a disc of 48 pixels across, on which the bright spot about the sun is a few pixels: 1 %.
Test(sunlight, open_ground) {
    Lit *lit = lit_new();
    lay_square(lit, 0, 0, 0, 1, LIT_WALL);
    lit_finish(lit, 0.5, 2);
    Daylight day = clear_day(40, 130);
    RadOptions options = sky_options_of(CULL_STAB, 1);
    RadSolution s = sky_day_shone(lit, &day, &options);
    double level[3];
    daylight_horizontal(&day, level);
    for (int e = 0; e < lit->mesh.element_count; e++)
        for (int c = 0; c < 3; c++)
            cr_expect_float_eq(s.radiosity[e][c] / (0.5 * level[c]), 1, 0.01, "%g of %g", s.radiosity[e][c],
                               level[c] / 2);
    cr_expect_float_eq(s.outdoors[0], s.emitted[0], 1e-9);
    sky_check_conserved(lit, &s);
    lit_free(lit);
}

// Proves the light from below the horizon against path tracing: a box in the air with a hole in a wall, whose ceiling has the most light
// from there. Tolerance: as for an even sky.
Test(sunlight, light_from_the_ground, .timeout = 120) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_RED, 1 << 1);
    lit_box(lit, vec3(-0.2, -0.2, -0.2), vec3(4.2, 3.2, 2.7), false, LIT_WALL, 1 << 1);
    lit_quad(lit, vec3(4, 0, 0), vec3(4, 0, 1), vec3(4, 3, 1), vec3(4, 3, 0), LIT_RED);
    lit_quad(lit, vec3(4.2, -0.2, -0.2), vec3(4.2, 3.2, -0.2), vec3(4.2, 3.2, 1), vec3(4.2, -0.2, 1),
             LIT_WALL);
    lit_finish(lit, 0.25, 2);
    SunPosition sun = {0.9, 3, 1};
    Daylight day = daylight_of(&sun, 0, DAYLIGHT_OVERCAST);
    RadOptions options = sky_options_of(CULL_STAB, 0);
    RadSolution s = sky_day_shone(lit, &day, &options);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    double errors[SKY_POINTS];
    int count = sky_errors_of(lit, &s, errors);
    cr_assert_geq(count, sky_point_count() * 5 / 8);
    cr_assert_leq(errors[count / 2], 0.02, "median %.2f %%", 100 * errors[count / 2]);
    cr_assert_leq(errors[count - 1], 0.1, "at most %.2f %%", 100 * errors[count - 1]);
    sky_check_conserved(lit, &s);
    lit_free(lit);
}
