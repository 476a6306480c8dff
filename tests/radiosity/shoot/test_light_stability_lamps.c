// test_light_stability_lamps.c - lamps in cupboards, like wires, by the thousand, and light through a key-hole.
#include <criterion/criterion.h>
#include <stdio.h>

#include "maps/maps.h"
#include "tests/radiosity/shoot/light_fixture.h"
#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

// ---- cupboards

enum { CUPBOARD = SIDES };

static const Vec3 CUPBOARD_LOW = {0, 1, 0}, CUPBOARD_HIGH = {0.6, 2, 2};

// A cupboard against the west wall, a lamp in it; of walls so thick, 0: sheets that are seen from both sides. Its front is open by
// a slit at the north, over its whole height.
static Lit *cupboard(double thick, double slit) {
    Lit *lit = lit_new();
    Vec3 l = CUPBOARD_LOW, h = CUPBOARD_HIGH;
    lit_box(lit, ROOM_LOW, ROOM_HIGH, true, LIT_WALL, 0);
    double front = h.y - slit;
    lit_box(lit, l, h, false, LIT_WALL, 1 << WEST | 1 << EAST | 1 << FLOOR);
    lit_quad(lit, vec3(h.x, l.y, 0), vec3(h.x, front, 0), vec3(h.x, front, h.z), vec3(h.x, l.y, h.z),
             LIT_WALL);
    Vec3 in_low = {thick, l.y + thick, thick}, in_high = {h.x - thick, h.y - thick, h.z - thick};
    // Without thickness the room's wall and floor close it.
    int closed = thick > 0 ? 0 : 1 << WEST | 1 << FLOOR;
    lit_box(lit, in_low, in_high, true, LIT_WALL, 1 << EAST | closed);
    lit_quad(lit, vec3(in_high.x, in_low.y, in_low.z), vec3(in_high.x, in_low.y, in_high.z),
             vec3(in_high.x, in_high.y - slit, in_high.z), vec3(in_high.x, in_high.y - slit, in_low.z),
             LIT_WALL);
    lit_quad(lit, vec3(0.2, 1.4, 1.9), vec3(0.2, 1.6, 1.9), vec3(0.4, 1.6, 1.9), vec3(0.4, 1.4, 1.9),
             LIT_LAMP);
    return lit;
}

static bool inside_cupboard(const Mesh *mesh, int element) {
    Vec3 p = element_centroid(mesh, element), n = mesh->faces[mesh->elements[element].face].plane.n;
    p = vec3_add(p, vec3_scale(n, 1e-3));
    return p.x < CUPBOARD_HIGH.x && p.y > CUPBOARD_LOW.y && p.y < CUPBOARD_HIGH.y && p.z < CUPBOARD_HIGH.z;
}

// Proves that not one watt leaves a closed cupboard with a lamp in it, of walls of 2 cm. Of sheets without thickness, which stand on
// floor and wall without covering a place there, a few per cent do: patches of the floor lie on both sides, and shoot as one.
Test(light_stability, lamp_in_a_closed_cupboard, .timeout = 120) {
    for (int i = 0; i < 2; i++) {
        Lit *lit = cupboard(i * 0.02, 0);
        RadSolution s;
        baked_solve(lit, &s);
        light_check_balance(lit, &s);
        double power[2] = {0, 0};
        for (int e = 0; e < s.element_count; e++)
            power[inside_cupboard(&lit->mesh, e)] += lit->mesh.elements[e].area * light_sum3(s.radiosity[e]);
        // Measured: 2.3 %.
        double most = i == 0 ? 0.03 * light_sum3(s.emitted) : 0;
        printf("walls of %g m: %g W outside, of %g emitted\n", i * 0.02, power[0], light_sum3(s.emitted));
        cr_expect_leq(power[0], most, "walls of %g m: %g W outside, of %g emitted", i * 0.02, power[0],
                      light_sum3(s.emitted));
        cr_assert_gt(power[1], light_sum3(s.emitted));
        lit_free(lit);
    }
}

// Proves that a slit of 3 cm lets out what path tracing says, which finds it with some effort: outside all points together are
// compared, within four standard errors and what solver's elements are off.
Test(light_stability, lamp_in_a_cupboard_ajar, .timeout = 120) {
    Lit *lit = cupboard(0.02, 0.03);
    RadSolution s;
    baked_solve(lit, &s);
    light_check_balance(lit, &s);
    BakedErrors out = light_check_traced("cupboard ajar, outside", lit, &s, EAST, FLOOR, 24, 200000);
    cr_expect_lt(fabs(out.sum - 1), 4 * out.sum_error + 0.05);
    BakedErrors in =
        light_check_traced("cupboard ajar, inside", lit, &s, CUPBOARD + 4, CUPBOARD + 9, 20, 50000);
    // The noise of the truth, and elements beside the lamp, which count as even; measured: 1.9 % together.
    cr_expect_lt(in.gathered_most, 4 * in.truth + 0.015);
    lit_free(lit);
}

// ---- lamps

// Proves that a lamp of 1 m x 1 mm is right, which no element is as narrow as.
Test(light_stability, lamp_like_a_wire, .timeout = 120) {
    Lit *lit = lit_new();
    RadSolution s;
    lit->building->materials[LIT_LAMP].emission = (Rgb){12000, 10000, 6000};
    lit_box(lit, ROOM_LOW, ROOM_HIGH, true, LIT_WALL, 0);
    lit_quad(lit, vec3(1.5, 1.2, 2.3), vec3(1.5, 1.201, 2.3), vec3(2.5, 1.201, 2.3), vec3(2.5, 1.2, 2.3),
             LIT_LAMP);
    baked_solve(lit, &s);
    light_check_balance(lit, &s);
    BakedErrors e = light_check_traced("1 m x 1 mm", lit, &s, 0, SIDES, 40, 100000);
    // The noise of the truth, four standard errors; and of light between corners what its bend is off, measured as 1 %.
    cr_expect_lt(e.gathered_most, 4 * e.truth);
    cr_expect_lt(e.shown_rms, 0.02);
    lit_free(lit);
}

// Proves that lamps may be very many: 10,000 of 4 cm^2 under a ceiling (`make soak`; else 1,024) are as path tracing has them.
Test(light_stability, ten_thousand_lamps, .timeout = 900) {
    Lit *lit = lit_new();
    RadSolution s;
    const int side = support_count(32, 100);
    const Vec3 low = {0, 0, 0}, high = {10, 8, 3};
    const double r = 0.01;
    lit_box(lit, low, high, true, LIT_WALL, 0);
    for (int i = 0; i < side * side; i++) {
        double x = high.x * (i % side + 0.5) / side, y = high.y * (i / side + 0.5) / side, z = 2.9;
        lit_quad(lit, vec3(x - r, y - r, z), vec3(x - r, y + r, z), vec3(x + r, y + r, z),
                 vec3(x + r, y - r, z), LIT_LAMP);
    }
    RadReport report = baked_solve(lit, &s);
    light_check_balance(lit, &s);
    printf("%d lamps: %d elements, %lld shots\n", side * side, s.element_count, report.shots);
    BakedErrors e = light_check_traced("many lamps", lit, &s, 0, SIDES, 30, 50000);
    // The noise of the truth, four standard errors.
    cr_expect_lt(e.gathered_most, 4 * e.truth);
    lit_free(lit);
}

// Proves that a building that is one triangle is lit by itself alone, and that all its light escapes.
Test(light_stability, building_of_one_triangle) {
    Lit *lit = lit_new();
    RadSolution s;
    const Vec3 v[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}};
    lit->building->materials[LIT_WALL].emission = (Rgb){1, 2, 3};
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "triangle");
    building_add_polygon(&lit->arena, lit->building, v, 3, LIT_WALL);
    lit->building->world = (Box){{0, 0, 0}, {1, 1, 0.5}};
    baked_solve(lit, &s);
    light_check_balance(lit, &s);
    for (int e = 0; e < s.element_count; e++)
        for (int c = 0; c < 3; c++) cr_assert_eq(s.radiosity[e][c], c + 1);
    for (int c = 0; c < 3; c++) {
        cr_assert_float_eq(s.emitted[c], (c + 1) * polygon_area(v, 3), 1e-9);
        cr_assert_float_eq(s.escaped[c], s.emitted[c], 1e-9);
    }
    lit_free(lit);
}

// ---- a key-hole

// Proves that light through a portal of 2 cm, 20 cm deep, is what path tracing says: a bright spot opposite to it, and what that
// reflects. Behind it nothing else shines.
Test(light_stability, light_through_a_key_hole, .timeout = 120) {
    static const char PLAN[] = "plan 1\nmaterial white #E8E8E8\nmaterial glow #FFFFFF emission 5000\nground "
                               "white height -0.2\nfacade white\n"
                               "storey ground floor 0 height 2.5 slab 0.3\n"
                               "room a 0,0 4,0 4,3 0,3 floor white ceiling white walls white wall 0.2\n"
                               "room b 4.2,0 8,0 8,3 4.2,3 floor white ceiling white walls white wall 0.2\n"
                               "window hole 4.1,1.5 angle 90 width 0.02 sill 1.2 height 0.02\n"
                               "model lamp\n  box -0.05,-0.5,0.7 0.05,0.5,1.7 glow\nend\nplace lamp 1,1.5\n";
    Error error = {""};
    Arena arena = {0};
    Lit *lit = lit_new();
    const char *path = arena_format(&arena, "%s/hole.plan", support_folder(&arena));
    cr_assert(file_write(path, PLAN, strlen(PLAN), &error), "%s", error.text);
    *lit->building = (Building){0};
    cr_assert(maps_read(arena_string(&lit->arena, path), &lit->arena, lit->building, &error), "%s",
              error.text);
    RadSolution s;
    baked_solve(lit, &s);
    light_check_balance(lit, &s);
    double power = 0;
    int most = support_count(16, 48), count = 0;
    BakedPoint *points = ARENA_ARRAY(&arena, BakedPoint, most);
    for (int e = 0; e < s.element_count; e++) {
        const Element *element = &lit->mesh.elements[e];
        Vec3 p = element_centroid(&lit->mesh, e);
        if (p.x < 4.3 || p.x > 8 || p.y < 0 || p.y > 3 || p.z < 0 || p.z > 2.5) continue;
        power += element->area * light_sum3(s.radiosity[e]);
        if (count < most / 2 && e % 7 == 0)
            points[count++] = (BakedPoint){.place = p, .normal = lit->mesh.faces[element->face].plane.n};
    }
    // The points of the spot on the wall opposite.
    for (; count < most; count++)
        points[count] =
            (BakedPoint){.place = vec3(8, 1.3 + 0.4 * fmod(0.618034 * count, 1), 1 + 0.4 * count / most),
                         .normal = vec3(-1, 0, 0)};
    baked_trace(lit, 0.01, 200000, points, count);
    BakedErrors e = baked_errors(lit, &s, points, count);
    baked_print("key-hole", &e);
    cr_expect_lt(fabs(e.sum - 1), 4 * e.sum_error + 0.05);
    printf("key-hole: %d points, %.3g W of %.3g in the dark room\n", count, power, light_sum3(s.emitted));
    lit_free(lit);
    arena_free(&arena);
}
