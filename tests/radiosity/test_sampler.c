// test_sampler.c - the rasteriser over directions: that each sample of hemisphere and hemicube sees what a ray sees, that
// nothing falls between faces, and that depth, ties and nearness are exact.
#include <criterion/criterion.h>
#include <criterion/parameterized.h>

#include "radiosity/factors/form_factor.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

extern const FormFactorMethod FORM_FACTOR_HEMISPHERE, FORM_FACTOR_HEMICUBE;

// Radians, and share of a distance: rays nearer an edge, or faces nearer each other, are left to the method. Its floats
// err by some 3e-7.
#define DOUBT 1e-6

typedef struct Method {
    const FormFactorMethod *method;
    void *self;
    const FormFactorSamples *samples;
    int32_t *item;
    FormFactorWork work;
} Method;

static Method method_of(Arena *arena, int which, const ViewFixture *f, int resolution) {
    FormFactorOptions options = {.resolution = resolution};
    Method m = {.method = which ? &FORM_FACTOR_HEMICUBE : &FORM_FACTOR_HEMISPHERE};
    m.self = m.method->start(&f->mesh, &options, arena);
    m.samples = m.method->samples(m.self);
    m.item = ARENA_ARRAY(arena, int32_t, m.samples->count);
    return m;
}

static void see(Method *m, const View *view) { m->method->items(m->self, view, m->item, &m->work); }

static Vec3 sample(const Method *m, int i) {
    return vec3((double)m->samples->x[i], (double)m->samples->y[i], (double)m->samples->z[i]);
}

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

// Weights sum to 1, directions are unit vectors above the horizon.
Test(sampler, samples) {
    for (int which = 0; which < 2; which++) {
        for (int resolution = 8; resolution < 300; resolution += 23) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            Method m = method_of(&arena, which, f, resolution);
            double sum = 0;
            for (int i = 0; i < m.samples->count; i++) {
                Vec3 w = sample(&m, i);
                sum += (double)m.samples->weight[i];
                cr_assert(fabs(vec3_length(w) - 1) < 1e-6 && w.z > 0 && m.samples->weight[i] > 0);
            }
            cr_assert(fabs(sum - 1) < 1e-6, "%s %d: weights sum to %.9f", m.method->name, resolution, sum);
            arena_free(&arena);
        }
    }
}

// Walls in strips of random widths between a floor and a ceiling of one polygon each: their outlines have a vertex at each
// strip, which no float, and hardly a double, puts on the straight line.
static ViewFixture *strips(Arena *arena, Random *random, int count, Vec3 shift) {
    ViewFixture *f = view_fixture_new(arena);
    ViewPose pose = view_fixture_pose(random, shift);
    static const double CORNERS[4][2] = {{0, 0}, {4, 0}, {4, 3}, {0, 3}};
    Vec3 *low = ARENA_ARRAY(arena, Vec3, 4 * count), *high = ARENA_ARRAY(arena, Vec3, 4 * count);
    for (int side = 0; side < 4; side++) {
        const double *a = CORNERS[side], *b = CORNERS[(side + 1) % 4];
        for (int i = 0; i < count; i++) {
            double t = i == 0 ? 0 : (i + random_between(random, -0.4, 0.4)) / count;
            double x = a[0] + (b[0] - a[0]) * t, y = a[1] + (b[1] - a[1]) * t;
            low[side * count + i] = view_fixture_place(&pose, vec3(x, y, 0));
            high[4 * count - 1 - side * count - i] = view_fixture_place(&pose, vec3(x, y, 2.5));
        }
    }
    int n = 4 * count;
    view_fixture_face(arena, f, low, n);
    view_fixture_face(arena, f, high, n);
    for (int i = 0; i < n; i++) {
        int j = (i + 1) % n;
        view_fixture_face(arena, f, (Vec3[]){low[j], low[i], high[n - 1 - i], high[n - 1 - j]}, 4);
    }
    return f;
}

static void check_against_rays(const Method *m, const View *view, uint64_t seed, int *sure) {
    for (int i = 0; i < m->samples->count; i++) {
        int cast = view_fixture_cast(view, sample(m, i), DOUBT);
        if (cast == -2) continue;
        ++*sure;
        cr_assert_eq(m->item[i], cast, "%s, seed %llu: sample %d sees %d, the ray %d", m->method->name,
                     (unsigned long long)seed, i, m->item[i], cast);
    }
}

// Near the origin and 1,000 km from it.
Test(sampler, sees_what_rays_see, .timeout = 600) {
    int rounds = support_count(40, 2000), sure = 0, all = 0;
    for (int round = 0; round < rounds; round++) {
        Arena arena = {0};
        uint64_t seed = 1000 + (uint64_t)round;
        Random random = {seed};
        Vec3 shift = round % 3 ? vec3(0, 0, 0) : vec3(1e6, -4e5, 30);
        ViewFixture *f = view_fixture_room(&arena, &random, 1 + round % 4, round % 7, shift);
        for (int which = 0; which < 2; which++) {
            Method m = method_of(&arena, which, f, 20 + round % 50);
            for (int shot = 0; shot < 3; shot++) {
                View *view = view_fixture_look_about(&arena, f, &random);
                see(&m, view);
                check_against_rays(&m, view, seed, &sure);
                all += m.samples->count;
            }
        }
        arena_free(&arena);
    }
    cr_assert(sure > 0.999 * all, "%d of %d samples were sure", sure, all);
}

static void check_closed(Arena *arena, const ViewFixture *f, Random *random, uint64_t seed, int shots) {
    for (int which = 0; which < 2; which++) {
        Method m = method_of(arena, which, f, 64);
        for (int shot = 0; shot < shots; shot++) {
            Arena scratch = {0};
            View *view = view_fixture_look_about(&scratch, f, random);
            see(&m, view);
            for (int i = 0; i < m.samples->count; i++)
                cr_assert(m.item[i] >= 0, "%s, seed %llu, shot %d: sample %d falls through", m.method->name,
                          (unsigned long long)seed, shot, i);
            arena_free(&scratch);
        }
    }
}

// references.md: 0 holes over 20,000 shots.
Test(sampler, closed_rooms_have_no_holes, .timeout = 300) {
    for (int round = 0; round < 100; round++) {
        Arena arena = {0};
        uint64_t seed = 2000 + (uint64_t)round;
        Random random = {seed};
        Vec3 shift = round % 5 ? vec3(0, 0, 0) : vec3(1e6, 1e6, 0);
        ViewFixture *f = round % 2 ? view_fixture_room(&arena, &random, 1 + round % 9, round % 4, shift)
                                   : strips(&arena, &random, 1 + round % 13, shift);
        check_closed(&arena, f, &random, seed, support_count(20, 200));
        arena_free(&arena);
    }
}

// Edges that run through samples, as nearly as floats can say: one face holds them. (The hemisphere's are turned out of any such
// place, and the hemicube's are a hair off; so is the box.)
Test(sampler, samples_on_edges) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    Method off = method_of(&arena, 1, f, 65);
    int zenith = 0;
    for (int i = 0; i < off.samples->count; i++)
        if (off.samples->z[i] > off.samples->z[zenith]) zenith = i;
    double z = (double)off.samples->z[zenith];
    double x = (double)off.samples->x[zenith] / z, y = (double)off.samples->y[zenith] / z;
    view_fixture_box(&arena, f, vec3(x - 1, y - 1, 0), vec3(x + 1, y + 1, 1), 2, true, NULL);
    Method m = method_of(&arena, 1, f, 65);
    View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    see(&m, view);
    int on_edge = 0;
    for (int i = 0; i < m.samples->count; i++) {
        cr_assert(m.item[i] >= 0, "%s: sample %d falls through", m.method->name, i);
        double on = (double)m.samples->z[i];
        on_edge +=
            fabs((double)m.samples->x[i] - x * on) < 1e-7 || fabs((double)m.samples->y[i] - y * on) < 1e-7;
    }
    cr_assert(on_edge > 100);
    arena_free(&arena);
}

// Turns the view so that x = 0 is the plane through the eye and the middle of a line.
static void turn_to(View *view, const ViewFixture *f, Vec3 p, Vec3 q) {
    Vec3 a = vec3_sub(p, view->eye), b = vec3_sub(q, view->eye);
    view->x = vec3_normalize(vec3_cross(a, b));
    view->z = vec3_normalize(vec3_add(a, b));
    view->y = vec3_cross(view->z, view->x);
    for (int i = 0; i < view->face_count; i++) {
        ViewFace *face = &view->faces[i];
        const Face *from = &f->mesh.faces[face->face];
        Vec3 n = from->plane.n;
        face->n = vec3(vec3_dot(view->x, n), vec3_dot(view->y, n), vec3_dot(view->z, n));
        for (int k = 0; k < face->vertex_count; k++) {
            Vec3 v = vec3_sub(f->mesh.vertices[f->mesh.outline[from->first_vertex + k]], view->eye);
            view->vertices[face->first_vertex + k] =
                vec3(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
        }
    }
}

// The edge between a floor and a wall of many strips, with a column of samples on it: each is decided by a rounding, and
// falls to the floor or to a strip.
Test(sampler, samples_on_edges_of_strips) {
    for (int round = 0; round < 200; round++) {
        Arena arena = {0};
        Random random = {4000 + (uint64_t)round};
        int count = 2 + round % 11;
        ViewFixture *f = strips(&arena, &random, count, vec3(0, 0, 0));
        const Mesh *mesh = &f->mesh;
        const int *floor = &mesh->outline[mesh->faces[0].first_vertex];
        Vec3 p = mesh->vertices[floor[0]], q = mesh->vertices[floor[count]], middle = {0, 0, 0};
        for (int i = 0; i < mesh->vertex_count; i++)
            middle = vec3_add(middle, vec3_scale(mesh->vertices[i], 1.0 / mesh->vertex_count));
        View *view = view_fixture_look(&arena, f, middle, vec3_sub(vec3_lerp(p, q, 0.5), middle));
        turn_to(view, f, p, q);
        Method m = method_of(&arena, 1, f, 65);
        see(&m, view);
        for (int i = 0; i < m.samples->count; i++)
            cr_assert(m.item[i] >= 0, "seed %d: sample %d falls through", 4000 + round, i);
        arena_free(&arena);
    }
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
        see(&m, view);
        int wrong = 0, sure = 0;
        for (int i = 0; i < m.samples->count; i++) {
            // OpenGL's pixels are at 1/256 of their size, and it works in floats: edges are wider.
            int cast = view_fixture_cast(view, sample(&m, i), k % 2 ? 1e-3 : 1e-6);
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
            Method m = method_of(&arena, which, f, 200);
            View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
            see(&m, view);
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
        Method m = method_of(&arena, which, f, 100), n = method_of(&arena, which, one, 100);
        View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
        View *alone = view_fixture_look(&arena, one, vec3(0, 0, 0), vec3(0, 0, 1));
        see(&n, alone);
        for (int order = 0; order < 2; order++) {
            see(&m, view);
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
        Method m = method_of(&arena, round % 2, f, 90);
        View *view = view_fixture_look_about(&arena, f, &random);
        see(&m, view);
        int32_t *before = ARENA_ARRAY(&arena, int32_t, m.samples->count);
        for (int i = 0; i < m.samples->count; i++) before[i] = view->faces[m.item[i]].face;
        for (int i = view->face_count - 1; i > 0; i--) {
            int k = random_index(&random, i + 1);
            ViewFace other = view->faces[i];
            view->faces[i] = view->faces[k];
            view->faces[k] = other;
        }
        see(&m, view);
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
        Method m = method_of(&arena, k / 8, f, 200);
        View *view = view_fixture_look(&arena, f, shift, vec3(0, 0, 1));
        see(&m, view);
        cr_assert(share_of(&m, view, 0) > 0.999, "%s, %g m: %.6f", m.method->name, away,
                  share_of(&m, view, 0));
        cr_assert_eq(share_of(&m, view, 1), 0);
        arena_free(&arena);
    }
}
