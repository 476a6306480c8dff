// test_form_factor_stability.c - where form-factor methods break: each row of the list of known failures against every
// method it applies to. The figures reached are logged (--verbose); the ones that must hold are asserted.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/factors/analytic.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

#define EACH_METHOD(m) for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++)

static bool is(const FormFactorMethod *method, const char *name) { return strcmp(method->name, name) == 0; }
// The method kept as it was printed, whose failures are measured and not mended.
static bool as_printed(const FormFactorMethod *method) { return method->truth == FORM_FACTOR_GUESS; }
// Takes a quarter of the lines where both ways agree on the row as a whole, small as a part of it may be.
static bool fits(const FormFactorMethod *method) { return is(method, "hemisphere-scanlines-fit"); }
// Embree's rays are floats throughout: two sheets 2e-7 apart are one to them, and one so near is none.
static bool in_floats(const FormFactorMethod *method) { return method->truth == FORM_FACTOR_FLOAT; }

static FormFactor *maker_of(Arena *arena, const FormFactorMethod *method, const ViewFixture *f,
                            int resolution) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    return form_factor_new(method, &f->mesh, &options, arena);
}

static double share_of(const Mesh *mesh, const Row *row, int face) {
    double sum = 0;
    for (int i = 0; i < row->count; i++)
        if (mesh->elements[row->element[i]].face == face) sum += (double)row->factor[i];
    return sum;
}

// From the origin about z; the share of face 0.
static double share_at(Arena *arena, const FormFactorMethod *method, const ViewFixture *f, int resolution,
                       Vec3 eye) {
    FormFactor *maker = maker_of(arena, method, f, resolution);
    double share =
        share_of(&f->mesh, form_factor_row(maker, view_fixture_look(arena, f, eye, vec3(0, 0, 1))), 0);
    form_factor_end(maker);
    return share;
}

// A rectangle x0 .. x1, y0 .. y1 at height z that looks down, turned about the z axis, shifted.
static void slab(Arena *arena, ViewFixture *f, Vec2 low, Vec2 high, double z, double turn, Vec3 shift) {
    const Vec2 p[4] = {{low.x, low.y}, {low.x, high.y}, {high.x, high.y}, {high.x, low.y}};
    Vec3 v[4];
    double c = cos(turn), s = sin(turn);
    for (int k = 0; k < 4; k++)
        v[k] = vec3_add(vec3(c * p[k].x - s * p[k].y, s * p[k].x + c * p[k].y, z), shift);
    view_fixture_quad(arena, f, v[0], v[1], v[2], v[3], 1, 1);
}

// ---- elements of few pixels

// A square of k x k pixels (2 / resolution wide near the zenith), anywhere and turned: RMS of its relative error.
static double small_element(const FormFactorMethod *method, double k, int tries) {
    Random random = {101};
    double square = 0;
    for (int n = 0; n < tries; n++) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_new(&arena);
        double half = k / 100;
        Vec3 shift = vec3(random_between(&random, -.1, .1), random_between(&random, -.1, .1), 0);
        slab(&arena, f, vec2(-half, -half), vec2(half, half), 1, random_between(&random, 0, M_PI), shift);
        View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
        double exact = analytic_point(view->vertices, 4);
        double error = share_at(&arena, method, f, 100, vec3(0, 0, 0)) / exact - 1;
        square += error * error;
        arena_free(&arena);
    }
    return sqrt(square / tries);
}

// Limits: the RMS seen with plain pixels, and a third for chance.
Test(form_factor_stability, small_elements, .timeout = 120) {
    static const double SIZE[] = {.5, 1, 2, 5}, SEEN[] = {1.74, .42, .146, .027};
    EACH_METHOD(m) {
        double rms[4];
        for (int i = 0; i < 4; i++) {
            rms[i] = small_element(*m, SIZE[i], 120);
            cr_expect(fits(*m) || rms[i] < SEEN[i] * 1.35, "%s: RMS %.3g of a square of %g pixels (seen %g)",
                      (*m)->name, rms[i], SIZE[i], SEEN[i]);
        }
        cr_log_info("%-20s RMS of squares of .5, 1, 2, 5 pixels: %.3g %.3g %.3g %.3g", (*m)->name, rms[0],
                    rms[1], rms[2], rms[3]);
    }
}

// ---- weights

// Delta form factors sum to 1; the limit is that of a sum of floats.
Test(form_factor_stability, weights_sum_to_one) {
    EACH_METHOD(m) {
        if (!(*m)->projective) continue;
        for (int resolution = 8; resolution <= 400; resolution += 49) {
            Arena arena = {0};
            FormFactor *maker = maker_of(&arena, *m, view_fixture_new(&arena), resolution);
            const FormFactorSamples *samples = form_factor_samples(maker);
            double sum = 0;
            for (int i = 0; i < samples->count; i++) sum += (double)samples->weight[i];
            cr_expect(fabs(sum - 1) < 1e-6, "%s %d: weights sum to %.9f", (*m)->name, resolution, sum);
            form_factor_end(maker);
            arena_free(&arena);
        }
    }
}

// ---- near walls

static double wall_error(const FormFactorMethod *method, double away, double turn, int resolution) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    Vec3 v[4] = {{away, -.5, 0}, {away, -.5, 1}, {away, .5, 1}, {away, .5, 0}};
    double c = cos(turn), s = sin(turn);
    for (int k = 0; k < 4; k++) v[k] = vec3(c * v[k].x - s * v[k].y, s * v[k].x + c * v[k].y, v[k].z);
    view_fixture_face(&arena, f, v, 4);
    double error = share_at(&arena, method, f, resolution, vec3(0, 0, 0)) - analytic_point(v, 4);
    arena_free(&arena);
    return error;
}

// A 1 x 1 m wall from the middle of its foot, all the way round: 2e-4 at 200. What shows over it is a sliver 1 and 1/10 pixel
// wide; how many samples are to one side of its edge errs by 8e-4 where the edge runs along rows of them. So methods mend it by
// the closed form; those that are kept as they are known are held to what that costs.
Test(form_factor_stability, near_walls) {
    EACH_METHOD(m) {
        for (int i = 0; i < 2; i++) {
            double away = i ? .001 : .01, mean = 0, worst = 0;
            for (int k = 0; k < 32; k++) {
                double error = fabs(wall_error(*m, away, 2 * M_PI * k / 32 + 0.01, 200));
                mean += error / 32;
                worst = fmax(worst, error);
            }
            double limit = is(*m, "analytic") ? 1e-6 : (*m)->mended ? 2e-4 : 9e-4;
            cr_log_info("%-20s wall %g m away: mean error %.2g, worst %.2g", (*m)->name, away, mean, worst);
            cr_expect(worst < limit && mean < 3e-4, "%s, wall %g m away: %.2g (limit %g), mean %.2g",
                      (*m)->name, away, worst, limit, mean);
        }
    }
}

// Largest error of the shares of the walls 1 and 2 cm away, x = 0 and x = `width` of a room; with a cupboard before it if
// `hidden`. `lost`: what the row's sum lacks.
static double slot_error(const FormFactorMethod *method, double width, bool hidden, double *lost) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    view_fixture_box(&arena, f, vec3(0, 0, 0), vec3(width, 3, 2.5), 1, true, NULL);
    int walls = f->mesh.face_count;
    if (hidden) view_fixture_box(&arena, f, vec3(0.003, 1.6, 0.2), vec3(0.006, 1.9, 2), 1, false, NULL);
    View *view = view_fixture_look(&arena, f, vec3(0.01, 1.4, 0), vec3(0, 0, 1));
    FormFactor *exact = maker_of(&arena, form_factor_method("analytic"), f, 200),
               *maker = maker_of(&arena, method, f, 200);
    const Row *right = form_factor_row(exact, view), *row = form_factor_row(maker, view);
    double largest = 0;
    *lost = 1 - row->back - row->escaped;
    for (int i = 0; i < row->count; i++) *lost -= (double)row->factor[i];
    for (int face = 0; face < walls; face++)
        if (fabs(f->mesh.faces[face].plane.n.x) > 0.5 &&
            fabs(plane_distance(f->mesh.faces[face].plane, view->eye)) < 0.03)
            largest = fmax(largest, fabs(share_of(&f->mesh, row, face) - share_of(&f->mesh, right, face)));
    form_factor_end(maker);
    arena_free(&arena);
    return largest;
}

// Proves that a near wall's share is exact in a room, too, that two walls are mended together, that what they are given the others
// lose, and that a wall is left alone where something stands before it (tolerance: that of pixels, 0.4 / 200).
Test(form_factor_stability, slots) {
    EACH_METHOD(m) {
        if (!(*m)->mended) continue;
        static const double WIDTH[] = {4, 0.03, 4}, LIMIT[] = {1e-6, 1e-6, 2e-3};
        double error[3];
        for (int i = 0; i < 3; i++) {
            double lost;
            error[i] = slot_error(*m, WIDTH[i], i == 2, &lost);
            cr_expect(fabs(lost) < 1e-6, "%s, case %d: %g lost", (*m)->name, i, lost);
            cr_expect(error[i] < LIMIT[i], "%s, case %d: off by %g (limit %g)", (*m)->name, i, error[i],
                      LIMIT[i]);
        }
        cr_log_info("%-20s a near wall is off by %.2g, two by %.2g, one half hidden by %.2g", (*m)->name,
                    error[0], error[1], error[2]);
    }
}

// ---- the horizon, chords, depth

// Unclipped, Lambert's formula gives 0 for this wall, which is half below the horizon. To 1e-4 at 500 pixels.
Test(form_factor_stability, horizon) {
    Vec3 v[4] = {{1, -1, -1}, {1, -1, 1}, {1, 1, 1}, {1, 1, -1}};
    EACH_METHOD(m) {
        double worst = 0;
        for (int k = 0; k < 8; k++) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            Vec3 w[4];
            double c = cos(0.3 * k + 0.1), s = sin(0.3 * k + 0.1);
            for (int i = 0; i < 4; i++) w[i] = vec3(c * v[i].x - s * v[i].y, s * v[i].x + c * v[i].y, v[i].z);
            view_fixture_face(&arena, f, w, 4);
            double error = fabs(share_at(&arena, *m, f, 500, vec3(0, 0, 0)) - .11146839401);
            worst = fmax(worst, error);
            arena_free(&arena);
        }
        cr_log_info("%-20s wall through the horizon: %.2g", (*m)->name, worst);
        cr_expect(worst < (fits(*m) ? 1e-3 : 1e-4), "%s: %.2g", (*m)->name, worst);
    }
}

// A ceiling 120 degrees wide at 1 m, and a piece of an upper one at 2 m behind its middle, which must not show at all. Its
// corners are nearer than those of the ceiling.
Test(form_factor_stability, depth_of_wide_polygons) {
    EACH_METHOD(m) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_new(&arena);
        double half = tan(M_PI / 3);
        slab(&arena, f, vec2(-.5, -.5), vec2(.5, .5), 2, 0.2, vec3(0, 0, 0));
        slab(&arena, f, vec2(-half, -half), vec2(half, half), 1, 0.2, vec3(0, 0, 0));
        double wrong = share_at(&arena, *m, f, 100, vec3(0, 0, 0));
        cr_log_info("%-20s the hidden ceiling shows: %.2g", (*m)->name, wrong);
        if (as_printed(*m))
            cr_expect(wrong > 0.01, "%s: the failure to be shown is not there", (*m)->name);
        else
            cr_expect(wrong == 0, "%s: a hidden ceiling shows, %.2g", (*m)->name, wrong);
        arena_free(&arena);
    }
}

// Culling leaves out what is hidden, and rows are the same bit by bit with and without it - but those of the method as
// printed, to which its depths show what is hidden: the one method whose light depends on culling.
Test(form_factor_stability, hidden_faces_leave_no_trace) {
    EACH_METHOD(m) {
        if ((*m)->whole_mesh) continue;  // whatever the view
        Arena arena = {0};
        ViewFixture *f = view_fixture_new(&arena);
        double half = tan(M_PI / 3);
        slab(&arena, f, vec2(-.5, -.5), vec2(.5, .5), 2, 0.2, vec3(0, 0, 0));
        slab(&arena, f, vec2(-half, -half), vec2(half, half), 1, 0.2, vec3(0, 0, 0));
        View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
        cr_assert_eq(view->face_count, 2);
        FormFactor *maker = maker_of(&arena, *m, f, 100);
        double all = share_of(&f->mesh, form_factor_row(maker, view), 1);
        view->faces[0] = view->faces[view->faces[0].face == 0 ? 1 : 0];
        view->face_count = 1;
        double culled = share_of(&f->mesh, form_factor_row(maker, view), 1);
        cr_expect(as_printed(*m) ? culled > all + 0.01 : culled == all, "%s: %g, culled %g", (*m)->name, all,
                  culled);
        form_factor_end(maker);
        arena_free(&arena);
    }
}

// The polyline method with edges left whole: -11.4 % for a unit square at 1 m, -35.6 % at 0.1 m; at 1 degree it is right.
Test(form_factor_stability, chords) {
    const FormFactorMethod *method = form_factor_method("hemisphere-polyline");
    static const double HEIGHT[] = {1, .1}, SEEN[] = {-.114, -.356}, DEGREES[] = {1, 10, 45, 180};
    cr_assert(method);
    for (int i = 0; i < 2; i++)
        for (int d = 0; d < 4; d++) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            slab(&arena, f, vec2(-.5, -.5), vec2(.5, .5), HEIGHT[i], 0.2, vec3(0, 0, 0));
            View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
            FormFactorOptions options = {.resolution = 400, .edge_threshold = DEGREES[d] * M_PI / 180};
            const Row *row = form_factor_row(form_factor_new(method, &f->mesh, &options, &arena), view);
            double error = share_of(&f->mesh, row, 0) / analytic_point(view->vertices, 4) - 1;
            cr_log_info("square at %g m, edges cut to %g degrees: %+.2f %%", HEIGHT[i], DEGREES[d],
                        100 * error);
            if (d == 0) cr_expect(fabs(error) < 2e-3, "at 1 degree %+.4f", error);
            if (d == 3) cr_expect(fabs(error - SEEN[i]) < 5e-3, "uncut %+.4f (seen %+.3f)", error, SEEN[i]);
            arena_free(&arena);
        }
}

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
        if (as_printed(*m)) {
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
        int shots = in_floats(*m) ? 400 : is(*m, "analytic") ? 4000 : 20000;
        double escaped = escaped_mean(*m, M_PI / 180, shots);
        cr_log_info("%-20s %d shots: %.3g escaped", (*m)->name, shots, escaped);
        cr_expect(in_floats(*m) ? escaped < 1e-6 : escaped == 0, "%s, seed 7: %g escaped", (*m)->name,
                  escaped);
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
            FormFactor *maker = maker_of(&arena, *m, f, 100);
            for (int shot = 0; shot < 30; shot++) leak += leak_of(maker, f, look_inside(&arena, f, &random));
            form_factor_end(maker);
            arena_free(&arena);
        }
        cr_log_info("%-20s leak of a sealed room %s: %.3g", (*m)->name, where, leak / 300);
        // Polylines leave holes; Embree's triangles are watertight only where outlines are.
        if (!as_printed(*m) && !in_floats(*m))
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
        int leaks = 0, rooms = is(*m, "analytic") || in_floats(*m) ? 10 : support_count(30, 1000);
        for (int k = 0; k < rooms; k++)
            most = fmax(most, most_through_walls(*m, &random, k % 2 ? 50 : 100, &leaks));
        cr_log_info("%-20s through walls without thickness: %d rows leak in %d buildings, most %.3g",
                    (*m)->name, leaks, rooms, most);
        if (!as_printed(*m) && !in_floats(*m))
            cr_expect(leaks == 0, "%s, seed 47: %d rows leak, %g", (*m)->name, leaks, most);
    }
}

// ---- shapes that tempt

// The image of a large polygon near by is not convex on the disc: every sample sees what a ray sees. Chords of 1 degree are
// up to 4e-5 off.
Test(form_factor_stability, large_polygons_near_by) {
    EACH_METHOD(m) {
        if (!(*m)->projective) continue;
        int sure = 0, wrong = 0;
        Random random = {41};
        for (int n = 0; n < 40; n++) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            ViewPose pose = view_fixture_pose(&random, vec3(0, 0, 0));
            Vec3 v[4];
            for (int k = 0; k < 4; k++)
                v[k] = view_fixture_place(&pose, vec3(k == 0 || k == 3 ? -3 : 2, k < 2 ? -4 : 5, 0.1));
            view_fixture_face(&arena, f, v, 4);
            View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
            FormFactor *maker = maker_of(&arena, *m, f, 100);
            const FormFactorSamples *s = form_factor_samples(maker);
            const int32_t *item = form_factor_items(maker, view);
            for (int i = 0; i < s->count; i++) {
                Vec3 w = vec3((double)s->x[i], (double)s->y[i], (double)s->z[i]);
                int cast = view_fixture_cast(view, w, as_printed(*m) ? 1e-4 : 1e-6);
                sure += cast != -2;
                wrong += cast != -2 && cast != item[i];
            }
            form_factor_end(maker);
            arena_free(&arena);
        }
        cr_log_info("%-20s large polygons from 0.1 m: %d of %d samples wrong", (*m)->name, wrong, sure);
        // Along the rim polylines have holes.
        cr_expect(wrong == 0 || ((as_printed(*m) || in_floats(*m)) && wrong < sure / 1000),
                  "%s, seed 41: %d of %d samples wrong", (*m)->name, wrong, sure);
    }
}

// A sheet that covers the eye, so near that thresholds swallow it; and two sheets as near each other.
static void check_sheets(const FormFactorMethod *method, double gap, Vec3 shift) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    slab(&arena, f, vec2(-1, -1), vec2(1, 1), gap, 0.3, shift);
    double seen = share_at(&arena, method, f, 100, shift);
    ViewFixture *g = view_fixture_new(&arena);
    slab(&arena, g, vec2(-1, -1), vec2(1, 1), 1, 0.3, shift);
    slab(&arena, g, vec2(-1, -1), vec2(1, 1), 1 + gap, 0.3, shift);
    // As pixels have it without the second sheet.
    ViewFixture *h = view_fixture_new(&arena);
    slab(&arena, h, vec2(-1, -1), vec2(1, 1), 1, 0.3, shift);
    double nearer = share_at(&arena, method, g, 100, shift), alone = share_at(&arena, method, h, 100, shift);
    cr_log_info("%-20s sheet %g m away, %g m from the origin: %.7f; of two so far apart %+.2g", method->name,
                gap, vec3_length(shift), seen, nearer - alone);
    if (!in_floats(method) || gap > 1e-5)
        cr_expect(fabs(seen - 1) < 1e-3, "%s: sheet %g m away: %g", method->name, gap, seen);
    if (!in_floats(method))
        cr_expect(fabs(nearer - alone) < 1e-6, "%s: sheets %g m apart: %g too little", method->name, gap,
                  alone - nearer);
    arena_free(&arena);
}

Test(form_factor_stability, sheets) {
    static const double GAP[] = {2e-7, 1e-6, 1e-4};
    EACH_METHOD(m)
    for (int i = 0; i < 3; i++) {
        check_sheets(*m, GAP[i], vec3(0, 0, 0));
        check_sheets(*m, GAP[i], vec3(600, -700, 400));
        check_sheets(*m, GAP[i], vec3(6e5, -7e5, 4e5));
    }
}

static double sum_of_two(Arena *arena, FormFactor *maker, const ViewFixture *f, bool reversed,
                         double share[2]) {
    View *view = view_fixture_look(arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    cr_assert_eq(view->face_count, 2);
    if (reversed) {
        ViewFace first = view->faces[0];
        view->faces[0] = view->faces[1];
        view->faces[1] = first;
    }
    const Row *row = form_factor_row(maker, view);
    for (int i = 0; i < 2; i++) share[i] = share_of(&f->mesh, row, i);
    return share[0] + share[1];
}

// The lower one of coincident quads is seen, whole, whatever the order they are drawn in; turned, so that their planes
// are rounded.
Test(form_factor_stability, coplanar_overlap) {
    EACH_METHOD(m) {
        Random random = {61};
        for (int n = 0; n < 20; n++) {
            Arena arena = {0};
            ViewFixture *one = view_fixture_new(&arena), *two = view_fixture_new(&arena);
            double turn = random_between(&random, 0, 3);
            slab(&arena, one, vec2(-.6, -.7), vec2(.8, .5), 1, turn, vec3(0, 0, 0));
            slab(&arena, two, vec2(-.6, -.7), vec2(.8, .5), 1, turn, vec3(0, 0, 0));
            slab(&arena, two, vec2(-.6, -.7), vec2(.8, .5), 1, turn, vec3(0, 0, 0));
            double alone = share_at(&arena, *m, one, 100, vec3(0, 0, 0)), share[2], reversed[2];
            FormFactor *maker = maker_of(&arena, *m, two, 100);
            double sum = sum_of_two(&arena, maker, two, false, share);
            sum_of_two(&arena, maker, two, true, reversed);
            form_factor_end(maker);
            cr_expect(fabs(sum - alone) < 1e-7, "%s, seed 61: two %.9f, one %.9f", (*m)->name, sum, alone);
            if (in_floats(*m)) continue;
            cr_expect(share[1] == 0, "%s, seed 61: the upper face has %g", (*m)->name, share[1]);
            cr_expect(share[0] == reversed[0] && share[1] == reversed[1],
                      "%s, seed 61: the order shows: %g %g, %g %g", (*m)->name, share[0], share[1],
                      reversed[0], reversed[1]);
            arena_free(&arena);
        }
    }
}

// Quads that pass through each other, nearly parallel or not, near the eye: along a line one may dip behind another and come
// back. L1 to the exact row; tolerance by what edges cost a method at 400, for polylines none.
static double pierced(const FormFactorMethod *method, Random *random) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    double bend = random_between(random, 0.02, 1);
    for (int i = 0; i < 4; i++) {
        Vec3 v[4];
        double height = random_between(random, 0.5, 1);
        const double at[4][2] = {{-4, -4}, {-4, 4}, {4, 4}, {4, -4}};
        Vec3 n = vec3_normalize(
            vec3(random_between(random, -bend, bend), random_between(random, -bend, bend), -1));
        for (int k = 0; k < 4; k++) {
            Vec3 p = vec3(at[k][0], at[k][1], 0);
            p.z = height - (n.x * p.x + n.y * p.y) / n.z;
            v[k] = p;
        }
        view_fixture_face(&arena, f, v, 4);
    }
    View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    const Row *exact = form_factor_row(maker_of(&arena, form_factor_method("analytic"), f, 400), view);
    FormFactor *maker = maker_of(&arena, method, f, 400);
    const Row *row = form_factor_row(maker, view);
    double l1 = fabs(row->escaped - exact->escaped) + fabs(row->back - exact->back);
    for (int i = 0; i < 4; i++) l1 += fabs(share_of(&f->mesh, row, i) - share_of(&f->mesh, exact, i));
    form_factor_end(maker);
    arena_free(&arena);
    return l1;
}

Test(form_factor_stability, interpenetration, .timeout = 120) {
    EACH_METHOD(m) {
        Random random = {83};
        double worst = 0;
        for (int n = 0; n < 24; n++) worst = fmax(worst, pierced(*m, &random));
        cr_log_info("%-20s quads through each other: worst L1 %.2g", (*m)->name, worst);
        if (!as_printed(*m))
            cr_expect(worst < ((*m)->projective || fits(*m) ? 5e-3 : 1e-3), "%s, seed 83: L1 %.2g",
                      (*m)->name, worst);
    }
}
