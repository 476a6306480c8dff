// test_form_factor_holes.c - no method leaves holes, and walls without thickness do not leak.
#include <criterion/criterion.h>

#include "radiosity/factors/analytic.h"
#include "tests/radiosity/factors/stability_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

// ---- holes

static double escaped_mean(const FormFactorMethod *method, double threshold, int shots) {
    Random random = {7};
    double sum = 0;
    for (int room = 0; room < 20; room++) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_room(&arena, &random, 1 + room % 3, room % 5, vec3(0, 0, 0));
        FormFactorOptions options = {.resolution = 100, .edge_threshold = threshold};
        FormFactor *maker = form_factor_new(method, &f->mesh, &options, &arena);
        for (int shot = 0; shot < shots / 20; shot++) {
            Arena scratch = {0};
            sum += form_factor_row(maker, view_fixture_look_about(&scratch, f, &random))->escaped;
            arena_free(&scratch);
        }
        form_factor_end(maker);
        arena_free(&arena);
    }
    return sum / shots;
}

// Nothing escapes from closed rooms over 20,000 shots; polylines leave holes between the rim and its chords, .04 pixels a
// shot at 1 degree, 12 at 10, 87 at 45.
Test(form_factor_stability, holes, .timeout = 300) {
    EACH_METHOD(m) {
        if (stability_as_printed(*m)) {
            for (int d = 0; d < 3; d++) {
                static const double DEGREES[] = {1, 10, 45};
                double holes = escaped_mean(*m, DEGREES[d] * M_PI / 180, support_count(200, 20000)) * 7860;
                cr_log_info("%-20s edges cut to %g degrees: %.3g holes a shot", (*m)->name, DEGREES[d],
                            holes);
                cr_expect(d < 2 || holes > 10, "%s: the failure to be shown is not there", (*m)->name);
            }
            continue;
        }
        // Ours that are fast enough take all of them.
        int shots = stability_in_floats(*m) ? 400 : stability_is(*m, "analytic") ? 4000 : 20000;
        double escaped = escaped_mean(*m, M_PI / 180, shots);
        cr_log_info("%-20s %d shots: %.3g escaped", (*m)->name, shots, escaped);
        cr_expect(stability_in_floats(*m) ? escaped < 1e-6 : escaped == 0, "%s, seed 7: %g escaped",
                  (*m)->name, escaped);
    }
}

// A room whose floor is cut otherwise than its walls, its T-vertices among the outlines, stands in a larger one, dark and
// out of sight. Nothing of it may be seen, nothing escape.
static ViewFixture *room_in_room(Arena *arena, Random *random, Vec3 shift) {
    ViewFixture *f = view_fixture_new(arena);
    ViewPose pose = view_fixture_pose(random, shift);
    static const double CUT[] = {0, 0.7, 1.9, 4};
    Vec3 v[8];
    for (int i = 0; i < 3; i++) {
        const Vec3 strip[4] = {{CUT[i], 0, 0}, {CUT[i + 1], 0, 0}, {CUT[i + 1], 3, 0}, {CUT[i], 3, 0}};
        for (int k = 0; k < 4; k++) v[k] = view_fixture_place(&pose, strip[k]);
        view_fixture_face(arena, f, v, 4);
    }
    const Vec3 front[6] = {{4, 0, 0}, {1.9, 0, 0}, {0.7, 0, 0}, {0, 0, 0}, {0, 0, 2.5}, {4, 0, 2.5}};
    const Vec3 back[6] = {{0, 3, 0}, {0.7, 3, 0}, {1.9, 3, 0}, {4, 3, 0}, {4, 3, 2.5}, {0, 3, 2.5}};
    const Vec3 side[3][4] = {{{0, 0, 0}, {0, 3, 0}, {0, 3, 2.5}, {0, 0, 2.5}},
                             {{4, 0, 0}, {4, 0, 2.5}, {4, 3, 2.5}, {4, 3, 0}},
                             {{0, 0, 2.5}, {0, 3, 2.5}, {4, 3, 2.5}, {4, 0, 2.5}}};
    for (int wall = 0; wall < 2; wall++) {
        for (int k = 0; k < 6; k++) v[k] = view_fixture_place(&pose, wall ? back[k] : front[k]);
        view_fixture_face(arena, f, v, 6);
    }
    for (int wall = 0; wall < 3; wall++) {
        for (int k = 0; k < 4; k++) v[k] = view_fixture_place(&pose, side[wall][k]);
        view_fixture_face(arena, f, v, 4);
    }
    view_fixture_box(arena, f, vec3(-.1, -.1, -.1), vec3(4.1, 3.1, 2.6), 2, true, &pose);
    return f;
}

enum { INNER_FACES = 8 };

static double leak_of(FormFactor *maker, const ViewFixture *f, const View *view) {
    const Row *row = form_factor_row(maker, view);
    double leak = row->escaped + row->back;
    for (int i = 0; i < row->count; i++)
        if (f->mesh.elements[row->element[i]].face >= INNER_FACES) leak += (double)row->factor[i];
    return leak;
}

// From a point of one of the room's own faces.
static View *look_inside(Arena *arena, const ViewFixture *f, Random *random) {
    ViewFixture inner = *f;
    inner.mesh.face_count = INNER_FACES;
    Vec3 eye = view_fixture_look_about(arena, &inner, random)->eye;
    for (int i = 0; i < INNER_FACES; i++)
        if (fabs(plane_distance(f->mesh.faces[i].plane, eye)) < 1e-8)
            return view_fixture_look(arena, f, eye, f->mesh.faces[i].plane.n);
    cr_assert_fail("the eye is on no face");
    return NULL;
}

static void check_leaks(Vec3 shift, const char *where) {
    EACH_METHOD(m) {
        Random random = {31};
        double leak = 0;
        for (int n = 0; n < 10; n++) {
            Arena arena = {0};
            ViewFixture *f = room_in_room(&arena, &random, shift);
            FormFactor *maker = stability_maker_of(&arena, *m, f, 100);
            for (int shot = 0; shot < 30; shot++) leak += leak_of(maker, f, look_inside(&arena, f, &random));
            form_factor_end(maker);
            arena_free(&arena);
        }
        cr_log_info("%-20s leak of a sealed room %s: %.3g", (*m)->name, where, leak / 300);
        // Polylines leave holes; Embree's triangles are watertight only where outlines are.
        if (!stability_as_printed(*m) && !stability_in_floats(*m))
            cr_expect(leak == 0, "%s, seed 31, %s: %g leaks", (*m)->name, where, leak);
    }
}

Test(form_factor_stability, leaks, .timeout = 120) { check_leaks(vec3(0, 0, 0), "at the origin"); }

// Georeferenced buildings.
Test(form_factor_stability, leaks_far_away, .timeout = 120) {
    check_leaks(vec3(600, -700, 400), "1 km away");
    check_leaks(vec3(6e5, -7e5, 4e5), "1,000 km away");
}

// ---- walls without thickness

static double quarters(Random *random, int low, int high) {
    return 0.25 * (low + (int)random_between(random, 0, high - low + 0.999));
}

// As it is, across the axes, or any way.
static void pose_building(Building *b, Random *random) {
    int turn = (int)random_between(random, 0, 3);
    double c = turn == 1 ? M_SQRT1_2 : 1, s = turn == 1 ? M_SQRT1_2 : 0;
    ViewPose pose = {{c, s, 0}, {-s, c, 0}, {0, 0, 1}, {0, 0, 0}};
    if (turn == 2) pose = view_fixture_pose(random, vec3(0, 0, 0));
    b->world = box_empty();
    for (int i = 0; i < b->vertex_count; i++) {
        b->vertices[i] = view_fixture_place(&pose, b->vertices[i]);
        b->world = box_add(b->world, b->vertices[i]);
    }
}

// Two rooms, wall on wall, all corners on a grid of a quarter of a metre, so that lines of samples run exactly along those
// where ceilings and floors end on the other room's wall. `dark` is its first polygon of the room not looked from, up to `end`.
static Lit *neighbours(Random *random, int *dark, int *end) {
    Lit *lit = lit_new();
    Vec3 size = vec3(quarters(random, 8, 16), quarters(random, 8, 16), quarters(random, 8, 12));
    Vec3 low = vec3(size.x, quarters(random, -4, 4), quarters(random, -2, 2));
    Vec3 high =
        vec3_add(low, vec3(quarters(random, 4, 12), quarters(random, 4, 12), quarters(random, 4, 12)));
    bool dark_first = random_between(random, 0, 1) < 0.5;
    if (!dark_first) lit_box(lit, vec3(0, 0, 0), size, true, LIT_WALL, 0);
    *dark = lit->building->polygon_count;
    lit_box(lit, low, high, true, LIT_RED, 0);
    *end = lit->building->polygon_count;
    if (dark_first) lit_box(lit, vec3(0, 0, 0), size, true, LIT_WALL, 0);
    pose_building(lit->building, random);
    lit_finish(lit, quarters(random, 3, 5), 1);
    return lit;
}

static double through_walls(const Lit *lit, const Row *row, int dark, int end) {
    double leak = row->escaped + row->back;
    for (int i = 0; i < row->count; i++) {
        int polygon = lit->mesh.faces[lit->mesh.elements[row->element[i]].face].polygon;
        if (polygon >= dark && polygon < end) leak += (double)row->factor[i];
    }
    return leak;
}

// The most of what leaves a patch of the one room and falls elsewhere than on its fronts.
static double most_through_walls(const FormFactorMethod *method, Random *random, int resolution, int *leaks) {
    Arena arena = {0};
    int dark, end;
    double most = 0;
    Lit *lit = neighbours(random, &dark, &end);
    Viewer *viewer = viewer_new(&lit->mesh, &lit->forest, NULL, &arena);
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    FormFactor *maker = form_factor_new(method, &lit->mesh, &options, &arena);
    for (int p = 0; p < lit->mesh.patch_count; p++) {
        const Patch *patch = &lit->mesh.patches[p];
        const Face *face = &lit->mesh.faces[patch->face];
        if (face->polygon >= dark && face->polygon < end) continue;
        ViewPoint from = {patch->centre, face->plane.n, patch->cell};
        for (int culled = 0; culled < 2; culled++) {
            const View *view = viewer_look(viewer, &from, culled ? CULL_STAB : CULL_NONE);
            double leak = through_walls(lit, form_factor_row(maker, view), dark, end);
            most = fmax(most, leak), *leaks += leak > 0;
        }
    }
    form_factor_end(maker);
    lit_free(lit);
    arena_free(&arena);
    return most;
}

// Proves that a wall of two coincident faces, one to each side, lets nothing through, along no line, culled or not, and that
// of the two the one that faces the eye gets the light: all of a row falls on the room's own fronts.
Test(form_factor_stability, walls_without_thickness, .timeout = 240) {
    EACH_METHOD(m) {
        Random random = {47};
        double most = 0;
        int leaks = 0,
            rooms = stability_is(*m, "analytic") || stability_in_floats(*m) ? 10 : support_count(30, 1000);
        for (int k = 0; k < rooms; k++)
            most = fmax(most, most_through_walls(*m, &random, k % 2 ? 50 : 100, &leaks));
        cr_log_info("%-20s through walls without thickness: %d rows leak in %d buildings, most %.3g",
                    (*m)->name, leaks, rooms, most);
        if (!stability_as_printed(*m) && !stability_in_floats(*m))
            cr_expect(leaks == 0, "%s, seed 47: %d rows leak, %g", (*m)->name, leaks, most);
    }
}
