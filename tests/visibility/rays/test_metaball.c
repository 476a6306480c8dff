// test_metaball.c - rays and metaballs: hits are where the field, summed in long doubles, passes the threshold, and nowhere
// else; coefficients are the printed ones; rays that touch; more balls than a walk holds at once.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "tests/support/support.h"
#include "visibility/bezier/bernstein.h"
#include "visibility/rays/curved_rays.h"

// How far the field may be off the threshold where a ray hits, of that and all weights.
#define EXACT 1e-9
enum { MOST_HITS = 64 };

typedef long double Real;

typedef struct Blob {
    Building building;
    CurvedShape shape;
    CurvedRays *rays;
    double size;
} Blob;

static Vec3 random_unit_vector(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(a), r * sin(a), z);
}

static void add_ball(Blob *b, Arena *arena, Vec3 centre, double radius, double weight) {
    *ARENA_PUSH(arena, b->building.balls, b->building.ball_count, b->building.ball_capacity) =
        (CurvedBall){centre, radius, weight};
}

static void finish(Blob *b, Arena *arena, double threshold) {
    b->shape =
        (CurvedShape){.kind = CURVED_METABALLS, .ball_count = b->building.ball_count, .threshold = threshold};
    b->building.shapes = &b->shape;
    b->building.shape_count = 1;
    b->rays = curved_rays_new(&b->building, arena);
    Box box = curved_rays_box(b->rays, 0);
    b->size = vec3_length(vec3_sub(box.max, box.min));
}

// One to `most` balls that overlap; some take away. Of any size.
static Blob *random_blob(Random *random, int most, Arena *arena) {
    Blob *b = ARENA_ARRAY(arena, Blob, 1);
    double scale = pow(10, random_between(random, -3, 2));
    Vec3 place = vec3_scale(random_unit_vector(random), scale * random_between(random, 0, 10));
    int count = 1 + random_index(random, most);
    for (int i = 0; i < count; i++) {
        Vec3 c =
            vec3_add(place, vec3_scale(random_unit_vector(random), scale * random_between(random, 0, 1)));
        double weight = random_between(random, 0.5, 2) * (i % 4 == 3 ? -1 : 1);
        add_ball(b, arena, c, scale * random_between(random, 0.3, 1.2), weight);
    }
    finish(b, arena, random_between(random, 0.1, 0.8));
    return b;
}

// As CurvedBall has it, less the threshold.
static Real field(const Blob *b, Vec3 p) {
    Real sum = -(Real)b->shape.threshold;
    for (int i = 0; i < b->building.ball_count; i++) {
        const CurvedBall *ball = &b->building.balls[i];
        Real x = (Real)p.x - (Real)ball->centre.x, y = (Real)p.y - (Real)ball->centre.y,
             z = (Real)p.z - (Real)ball->centre.z;
        Real u = (x * x + y * y + z * z) / ((Real)ball->radius * (Real)ball->radius);
        if (u < 1) sum += (Real)ball->weight * (1 - 22 * u / 9 + 17 * u * u / 9 - 4 * u * u * u / 9);
    }
    return sum;
}

static double weights(const Blob *b) {
    double sum = b->shape.threshold;
    for (int i = 0; i < b->building.ball_count; i++) sum += fabs(b->building.balls[i].weight);
    return sum;
}

static Vec3 at(const Ray *ray, double t) { return vec3_add(ray->origin, vec3_scale(ray->direction, t)); }

static Vec3 fall(const Blob *b, Vec3 p) {
    double h = 1e-6 * b->size;
    return vec3((double)(field(b, vec3_sub(p, vec3(h, 0, 0))) - field(b, vec3_add(p, vec3(h, 0, 0)))),
                (double)(field(b, vec3_sub(p, vec3(0, h, 0))) - field(b, vec3_add(p, vec3(0, h, 0)))),
                (double)(field(b, vec3_sub(p, vec3(0, 0, h))) - field(b, vec3_add(p, vec3(0, 0, h)))));
}

static Ray random_ray(const Blob *b, Random *random) {
    Box box = curved_rays_box(b->rays, 0);
    Vec3 p = vec3(random_between(random, box.min.x, box.max.x), random_between(random, box.min.y, box.max.y),
                  random_between(random, box.min.z, box.max.z));
    Vec3 d = random_unit_vector(random);
    return (Ray){vec3_sub(p, vec3_scale(d, b->size * random_between(random, 0, 3))), d, -INFINITY, INFINITY};
}

// From inside to outside and back at each hit, and nowhere else: at `samples` places along the ray and at the hits.
static int check_ray(const Blob *b, const Ray *ray, int samples, int seed) {
    RayHit hits[MOST_HITS], first;
    int count = curved_rays_all(b->rays, 0, ray, hits, MOST_HITS, NULL);
    double exact = EXACT * weights(b);
    cr_assert(count <= MOST_HITS);
    cr_assert_eq(curved_rays_hit(b->rays, 0, ray, &first, NULL), count > 0);
    if (count > 0) cr_assert(first.t == hits[0].t);
    for (int i = 0; i < count; i++) {
        Vec3 p = at(ray, hits[i].t), expected = fall(b, p);
        cr_assert(fabsl(field(b, p)) < (Real)exact, "seed %d: hit %d is %Lg off", seed, i, field(b, p));
        if (vec3_length(expected) > 1e-8 * weights(b))
            cr_assert(vec3_length(vec3_sub(vec3_normalize(expected), hits[i].normal)) < 1e-3,
                      "seed %d: normal %d", seed, i);
        // Between two hits the field is of one sign; a place where it only touches is a hit between two of the same sign.
        double next = i + 1 < count ? hits[i + 1].t : hits[i].t + b->size, middle = (hits[i].t + next) / 2;
        double before = i > 0 ? hits[i - 1].t : hits[i].t - b->size, previous = (before + hits[i].t) / 2;
        Real here = field(b, at(ray, middle)), there = field(b, at(ray, previous));
        cr_assert((here > 0) != (there > 0) || fabsl(here) < 1e-6L || fabsl(there) < 1e-6L ||
                      fabs(vec3_dot(hits[i].normal, ray->direction)) < 1e-3,
                  "seed %d: hit %d of %d passes nothing", seed, i, count);
    }
    double centre =
        vec3_dot(vec3_sub(vec3_lerp(curved_rays_box(b->rays, 0).min, curved_rays_box(b->rays, 0).max, 0.5),
                          ray->origin),
                 ray->direction);
    for (int k = 0; k < samples; k++) {
        double t = centre + b->size * ((k + 0.5) / samples - 0.5);
        int passed = 0;
        for (int i = 0; i < count; i++)
            passed += hits[i].t < t && fabs(vec3_dot(hits[i].normal, ray->direction)) > 1e-6;
        Real value = field(b, at(ray, t));
        bool touches = false;
        for (int i = 0; i < count; i++) touches |= fabs(vec3_dot(hits[i].normal, ray->direction)) <= 1e-4;
        cr_assert(touches || fabsl(value) < (Real)exact || (value > 0) == passed % 2,
                  "seed %d: at t %g the field is %Lg after %d hits of %d", seed, t, value, passed, count);
    }
    return count;
}

// The printed coefficients of one ball over its chord, with a = (half chord / radius)^2, and the field itself on a part.
Test(metaball, coefficients) {
    for (int i = 0; i < 10000; i++) {
        Random random = {(uint64_t)i};
        double a = random_between(&random, 0, 1), weight = random_between(&random, -2, 2), d[7] = {0}, slope;
        metaball_add_field((double[]){0, 2 * a, 0}, weight, d);
        const double printed[7] = {0, 0, 16 * a * a / 27, 8 * a * a * (8 * a + 5) / 45, 16 * a * a / 27,
                                   0, 0};
        for (int k = 0; k < 7; k++) cr_assert(fabs(d[k] - weight * printed[k]) < 1e-14, "seed %d: %d", i, k);
        // w along the chord is 4 a s (1 - s).
        double low = random_unit(&random), high = random_unit(&random), part[7] = {0};
        metaball_add_field((double[]){4 * a * low * (1 - low), 2 * a * (low + high - 2 * low * high),
                                      4 * a * high * (1 - high)},
                           weight, part);
        double s = random_unit(&random), whole = bernstein_value(d, 6, low + (high - low) * s, &slope);
        cr_assert(fabs(bernstein_value(part, 6, s, &slope) - whole) < 1e-14, "seed %d", i);
    }
}

// 100,000 rays: hits are on the surface and the field has the sign they say everywhere else.
Test(metaball, hits_are_where_the_field_passes, .timeout = 120) {
    int hits = 0;
    for (int round = 0; round < support_count(1000, 20000); round++) {
        Arena arena = {0};
        Random random = {(uint64_t)round};
        Blob *b = random_blob(&random, 12, &arena);
        for (int i = 0; i < 100; i++) {
            Ray ray = random_ray(b, &random);
            hits += check_ray(b, &ray, 20, round);
        }
        arena_free(&arena);
    }
    cr_assert(hits > 50000, "only %d hits", hits);
}

// The surface of one ball is a sphere: rays a billionth inside hit twice, a billionth outside never, on it once.
Test(metaball, rays_that_touch) {
    for (int i = 0; i < 2000; i++) {
        Arena arena = {0};
        Random random = {(uint64_t)i};
        Blob *b = ARENA_ARRAY(&arena, Blob, 1);
        double r = random_between(&random, 0.2, 0.9), scale = pow(10, random_between(&random, -3, 2));
        add_ball(b, &arena, vec3(0, 0, 0), scale, 1);
        double u = r * r;
        finish(b, &arena, 1 - 22 * u / 9 + 17 * u * u / 9 - 4 * u * u * u / 9);
        Vec3 d = random_unit_vector(&random),
             out = vec3_normalize(vec3_cross(d, random_unit_vector(&random)));
        for (int side = -1; side <= 1; side++) {
            Vec3 p = vec3_scale(out, scale * r * (1 + side * 1e-9));
            Ray ray = {vec3_sub(p, vec3_scale(d, 3 * scale)), d, 0, INFINITY};
            RayHit hits[8];
            int count = curved_rays_all(b->rays, 0, &ray, hits, 8, NULL);
            cr_assert_eq(count, 1 - side, "seed %d, side %d: %d hits", i, side, count);
            for (int k = 0; k < count; k++)
                cr_assert(fabs(hits[k].t / scale - 3) < 1e-4 &&
                          vec3_length(vec3_sub(hits[k].normal, out)) < 1e-3);
        }
        arena_free(&arena);
    }
}

// A row of 1,000 balls, more than are held at once: each is entered and left, the first hit is the first.
Test(metaball, rows_of_many) {
    Arena arena = {0};
    Random random = {1};
    Blob *b = ARENA_ARRAY(&arena, Blob, 1);
    for (int i = 0; i < 1000; i++)
        add_ball(b, &arena, vec3((i * 37) % 1000, random_between(&random, -0.1, 0.1), 0), i % 5 ? 0.6 : 0.45,
                 1);
    finish(b, &arena, 0.3);
    Ray ray = {vec3(-10, 0.01, 0.02), vec3(1, 0, 0), 0, INFINITY};
    RayHit hits[3000], first;
    int count = curved_rays_all(b->rays, 0, &ray, hits, 3000, NULL), entered = 0;
    Real before = field(b, ray.origin);
    for (int i = 1; i < 60000; i++) {
        Real here = field(b, at(&ray, i * 0.02));
        entered += (here > 0) != (before > 0);
        before = here;
    }
    cr_assert_eq(count, entered, "%d hits, the field passes %d times", count, entered);
    cr_assert(count >= 1500);
    cr_assert(curved_rays_hit(b->rays, 0, &ray, &first, NULL) && first.t == hits[0].t);
    for (int i = 0; i < count; i++) cr_assert(fabsl(field(b, at(&ray, hits[i].t))) < 1e-9L, "hit %d", i);
    arena_free(&arena);
}

// Polynomials with roots set at random, double ones among them: all are found, at their places, and no other.
Test(metaball, roots_of_polynomials) {
    for (int i = 0; i < 100000; i++) {
        Random random = {(uint64_t)i};
        int degree = 1 + random_index(&random, 6), expected = 0, doubles = 0;
        double set[6], c[7] = {1}, root[7];
        for (int k = 0; k < degree; k++) {
            bool twice = k > 0 && doubles == 0 && random_index(&random, 4) == 0;
            set[k] = twice ? set[k - 1] : random_between(&random, -0.5, 1.5);
            doubles += twice;
        }
        // Times (s - root): c of degree k becomes one of degree k + 1.
        for (int k = 0; k < degree; k++)
            for (int j = k + 1; j >= 0; j--)
                c[j] =
                    ((j > 0 ? c[j - 1] * j * (1 - set[k]) : 0) - (j <= k ? c[j] * (k + 1 - j) * set[k] : 0)) /
                    (k + 1);
        bool apart = true;
        for (int k = 0; k < degree; k++) {
            for (int j = 0; j < k; j++) apart &= fabs(set[k] - set[j]) > 0.02 || set[k] == set[j];
            apart &= fabs(set[k]) > 1e-3 && fabs(set[k] - 1) > 1e-3;
        }
        if (!apart) continue;
        for (int k = 0; k < degree; k++)
            expected += set[k] > 0 && set[k] < 1 && (k == 0 || set[k] != set[k - 1]);
        CurvedWork work = {0};
        double most = 0;
        for (int k = 0; k <= degree; k++) most = fmax(most, fabs(c[k]));
        int count = bernstein_roots(c, degree, 1e-15 * most, root, 7, &work);
        cr_assert_eq(count, expected, "seed %d: %d roots of degree %d, not %d", i, count, degree, expected);
        for (int r = 0; r < count; r++) {
            double nearest = INFINITY;
            for (int k = 0; k < degree; k++) nearest = fmin(nearest, fabs(set[k] - root[r]));
            cr_assert(nearest < (doubles ? 1e-4 : 1e-7), "seed %d: root %g is %g off", i, root[r], nearest);
            cr_assert(r == 0 || root[r] > root[r - 1]);
        }
        cr_assert_eq(work.undecided, 0);
    }
}
