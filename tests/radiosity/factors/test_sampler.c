// test_sampler.c - the rasteriser over directions: that each sample of hemisphere and hemicube sees what a ray sees, that
// nothing falls between faces, and that depth, ties and nearness are exact.
#include <criterion/criterion.h>
#include <criterion/parameterized.h>

#include "radiosity/factors/form_factor.h"
#include "tests/radiosity/factors/sampler_fixture.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

// Radians, and share of a distance: rays nearer an edge, or faces nearer each other, are left to the method. Its floats
// err by some 3e-7.
#define DOUBT 1e-6

// Weights sum to 1, directions are unit vectors above the horizon.
Test(sampler, samples) {
    for (int which = 0; which < 2; which++) {
        for (int resolution = 8; resolution < 300; resolution += 23) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            Method m = sampler_of_method_of(&arena, which, f, resolution);
            double sum = 0;
            for (int i = 0; i < m.samples->count; i++) {
                Vec3 w = sampler_of_sample(&m, i);
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
        int cast = view_fixture_cast(view, sampler_of_sample(m, i), DOUBT);
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
            Method m = sampler_of_method_of(&arena, which, f, 20 + round % 50);
            for (int shot = 0; shot < 3; shot++) {
                View *view = view_fixture_look_about(&arena, f, &random);
                sampler_of_see(&m, view);
                check_against_rays(&m, view, seed, &sure);
                all += m.samples->count;
            }
        }
        arena_free(&arena);
    }
    cr_assert(sure > 0.999 * all, "%d of %d samples were sure", sure, all);
}

// A sphere that contains a face, as viewer_look finds it.
static void put_sphere(View *view, ViewFace *face) {
    const Vec3 *v = view->vertices + face->first_vertex;
    Vec3 centre = {0, 0, 0};
    double radius = 0;
    for (int i = 0; i < face->vertex_count; i++)
        centre = vec3_add(centre, vec3_scale(v[i], 1.0 / face->vertex_count));
    for (int i = 0; i < face->vertex_count; i++) radius = fmax(radius, vec3_length(vec3_sub(v[i], centre)));
    face->radius = (float)radius * (1 + 1e-6f);
    face->centre[0] = (float)centre.x;
    face->centre[1] = (float)centre.y;
    face->centre[2] = (float)centre.z;
}

// Triangles from a hundredth of the distance between samples to some of them, overlapping, of any slant, some of them across the horizon.
// Proves that no sample is missed where spheres and spans tell which samples a face can meet.
Test(sampler, small_faces, .timeout = 300) {
    int rounds = support_count(8, 400), sure = 0, seen = 0;
    for (int round = 0; round < rounds; round++) {
        Arena arena = {0};
        uint64_t seed = 9000 + (uint64_t)round;
        Random random = {seed};
        ViewFixture *f = view_fixture_new(&arena);
        int resolution = 20 + round % 60;
        for (int i = 0; i < 2000; i++) {
            ViewPose pose = view_fixture_pose(&random, vec3(0, 0, 0));
            double away = random_between(&random, 0.5, 4), angle = random_between(&random, 0, 2 * M_PI),
                   size = away * pow(10, random_between(&random, -2, 0.7)) / resolution,
                   disc = sqrt(random_unit(&random)), up = sqrt(1 - disc * disc);
            pose.shift = vec3_scale(vec3(disc * cos(angle), disc * sin(angle), up), away);
            Vec3 v[3];
            for (int k = 0; k < 3; k++)
                v[k] = view_fixture_place(&pose, vec3(size * cos(2.1 * k), size * sin(2.1 * k), 0));
            view_fixture_face(&arena, f, v, 3);
        }
        for (int which = 0; which < 2; which++) {
            Method m = sampler_of_method_of(&arena, which, f, resolution);
            View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
            for (int i = 0; i < view->face_count && round % 4; i++) put_sphere(view, &view->faces[i]);
            sampler_of_see(&m, view);
            check_against_rays(&m, view, seed, &sure);
            for (int i = 0; i < m.samples->count; i++) seen += m.item[i] >= 0;
        }
        arena_free(&arena);
    }
    cr_assert(seen > 0.15 * sure, "%d of %d samples saw a face", seen, sure);
}

static void check_closed(Arena *arena, const ViewFixture *f, Random *random, uint64_t seed, int shots) {
    for (int which = 0; which < 2; which++) {
        Method m = sampler_of_method_of(arena, which, f, 64);
        for (int shot = 0; shot < shots; shot++) {
            Arena scratch = {0};
            View *view = view_fixture_look_about(&scratch, f, random);
            sampler_of_see(&m, view);
            for (int i = 0; i < m.samples->count; i++)
                cr_assert(m.item[i] >= 0, "%s, seed %llu, shot %d: sample %d falls through", m.method->name,
                          (unsigned long long)seed, shot, i);
            arena_free(&scratch);
        }
    }
}

// Proves that closed rooms show no hole: 0 over 20,000 shots.
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
    Method off = sampler_of_method_of(&arena, 1, f, 65);
    int zenith = 0;
    for (int i = 0; i < off.samples->count; i++)
        if (off.samples->z[i] > off.samples->z[zenith]) zenith = i;
    double z = (double)off.samples->z[zenith];
    double x = (double)off.samples->x[zenith] / z, y = (double)off.samples->y[zenith] / z;
    view_fixture_box(&arena, f, vec3(x - 1, y - 1, 0), vec3(x + 1, y + 1, 1), 2, true, NULL);
    Method m = sampler_of_method_of(&arena, 1, f, 65);
    View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    sampler_of_see(&m, view);
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
        Method m = sampler_of_method_of(&arena, 1, f, 65);
        sampler_of_see(&m, view);
        for (int i = 0; i < m.samples->count; i++)
            cr_assert(m.item[i] >= 0, "seed %d: sample %d falls through", 4000 + round, i);
        arena_free(&arena);
    }
}
