// test_sampler_depth.c - depths of large polygons, of coincident ones and of near sheets.
#include <criterion/criterion.h>
#include <criterion/parameterized.h>

#include "radiosity/factors/form_factor.h"
#include "tests/radiosity/factors/sampler_fixture.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

// The share of the weights of samples that see a face of Mesh.faces, -1: nothing.
static double share_of(const Method *m, const View *view, int face) {
    double share = 0;
    for (int i = 0; i < m->samples->count; i++)
        if ((m->item[i] < 0 ? -1 : view->faces[m->item[i]].face) == face)
            share += (double)m->samples->weight[i];
    return share;
}

static void quad_above(Arena *arena, ViewFixture *f, double height, double half, Vec3 shift) {
    Vec3 v[4] = {{-half, -half, height}, {-half, half, height}, {half, half, height}, {half, -half, height}};
    for (int k = 0; k < 4; k++) v[k] = vec3_add(v[k], shift);
    view_fixture_quad(arena, f, v[0], v[1], v[2], v[3], 1, 1);
}

// The hemicube drawn by the hidden-surface methods sees what rays see: the sides hang the right way round, and together.
Test(sampler, hemicube_by_hidden_methods, .timeout = 120) {
    static const char *const HIDDEN[] = {"raycast", "osmesa"};
    for (int k = 0; k < 8; k++) {
        Arena arena = {0};
        Random random = {5000 + (uint64_t)k};
        ViewFixture *f = view_fixture_room(&arena, &random, 3, 4, vec3(0, 0, 0));
        FormFactorOptions options = {.resolution = 32 + k / 2, .hidden = HIDDEN[k % 2]};
        Method m = {.method = &FORM_FACTOR_HEMICUBE};
        m.self = m.method->start(&f->mesh, &options, &arena);
        m.samples = m.method->samples(m.self);
        m.item = ARENA_ARRAY(&arena, int32_t, m.samples->count);
        View *view = view_fixture_look_about(&arena, f, &random);
        sampler_of_see(&m, view);
        int wrong = 0, sure = 0;
        for (int i = 0; i < m.samples->count; i++) {
            // OpenGL's pixels are at 1/256 of their size, and it works in floats: edges are wider.
            int cast = view_fixture_cast(view, sampler_of_sample(&m, i), k % 2 ? 1e-3 : 1e-6);
            if (cast == -2) continue;
            sure++;
            wrong += m.item[i] != cast;
        }
        cr_assert(wrong == 0 && sure > 0.9 * m.samples->count, "%s: %d of %d samples are wrong",
                  HIDDEN[k % 2], wrong, sure);
        m.method->stop(m.self);
        arena_free(&arena);
    }
}

// A ceiling that spans 60 or 120 degrees hides an upper floor at twice its distance, everywhere.
Test(sampler, depth_of_large_polygons) {
    for (int which = 0; which < 2; which++) {
        for (int degrees = 60; degrees <= 120; degrees += 60) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            double half = tan(degrees * M_PI / 360);
            quad_above(&arena, f, 2, 2 * half, vec3(0, 0, 0));
            quad_above(&arena, f, 1, half, vec3(0, 0, 0));
            Method m = sampler_of_method_of(&arena, which, f, 200);
            View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
            sampler_of_see(&m, view);
            cr_assert_eq(share_of(&m, view, 0), 0, "%s, %d degrees", m.method->name, degrees);
            cr_assert(share_of(&m, view, 1) > 0.2);
            arena_free(&arena);
        }
    }
}

// Two coincident quads: the lower index is seen, whichever comes first.
Test(sampler, coincident_quads) {
    for (int which = 0; which < 2; which++) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_new(&arena), *one = view_fixture_new(&arena);
        quad_above(&arena, one, 0.7, 0.43, vec3(0.1, 0.2, 0));
        quad_above(&arena, f, 0.7, 0.43, vec3(0.1, 0.2, 0));
        quad_above(&arena, f, 0.7, 0.43, vec3(0.1, 0.2, 0));
        Method m = sampler_of_method_of(&arena, which, f, 100),
               n = sampler_of_method_of(&arena, which, one, 100);
        View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
        View *alone = view_fixture_look(&arena, one, vec3(0, 0, 0), vec3(0, 0, 1));
        sampler_of_see(&n, alone);
        for (int order = 0; order < 2; order++) {
            sampler_of_see(&m, view);
            cr_assert_eq(share_of(&m, view, 0), share_of(&n, alone, 0));
            cr_assert_eq(share_of(&m, view, 1), 0);
            ViewFace first = view->faces[0];
            view->faces[0] = view->faces[1];
            view->faces[1] = first;
        }
        arena_free(&arena);
    }
}

// The order of the faces in the view changes nothing.
Test(sampler, order_does_not_matter) {
    for (int round = 0; round < 20; round++) {
        Arena arena = {0};
        Random random = {3000 + (uint64_t)round};
        ViewFixture *f = view_fixture_room(&arena, &random, 3, 5, vec3(0, 0, 0));
        Method m = sampler_of_method_of(&arena, round % 2, f, 90);
        View *view = view_fixture_look_about(&arena, f, &random);
        sampler_of_see(&m, view);
        int32_t *before = ARENA_ARRAY(&arena, int32_t, m.samples->count);
        for (int i = 0; i < m.samples->count; i++) before[i] = view->faces[m.item[i]].face;
        for (int i = view->face_count - 1; i > 0; i--) {
            int k = random_index(&random, i + 1);
            ViewFace other = view->faces[i];
            view->faces[i] = view->faces[k];
            view->faces[k] = other;
        }
        sampler_of_see(&m, view);
        for (int i = 0; i < m.samples->count; i++) cr_assert_eq(before[i], view->faces[m.item[i]].face);
        arena_free(&arena);
    }
}

// A sheet a hair's breadth before the point hides the quad behind it; also far from the origin, where doubles still tell the
// two apart.
Test(sampler, near_sheets) {
    static const double AWAY[] = {2e-7, 1e-6, 1e-5, 1e-4};
    for (int k = 0; k < 16; k++) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_new(&arena);
        double away = AWAY[k % 4];
        Vec3 shift = k / 4 % 2 ? vec3(1e6, 1e3, 0) : vec3(0, 0, 0);
        quad_above(&arena, f, away, 0.5, shift);
        quad_above(&arena, f, 1, 0.5, shift);
        Method m = sampler_of_method_of(&arena, k / 8, f, 200);
        View *view = view_fixture_look(&arena, f, shift, vec3(0, 0, 1));
        sampler_of_see(&m, view);
        cr_assert(share_of(&m, view, 0) > 0.999, "%s, %g m: %.6f", m.method->name, away,
                  share_of(&m, view, 0));
        cr_assert_eq(share_of(&m, view, 1), 0);
        arena_free(&arena);
    }
}
