// test_curved_rays.c - rays and spheres, ellipsoids, cylinders, cones: hits, normals, inside and outside against fields in long
// doubles; grazing rays, rays from the surface, missing discs.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "tests/support/support.h"
#include "visibility/rays/curved_rays.h"

// How far a hit may lie off its surface, of the shape's size.
#define EXACT 1e-9

typedef long double Real;

static Vec3 random_unit_vector(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(a), r * sin(a), z);
}

static const struct {
    const char *name;
    CurvedKind kind;
    bool even;  // its axes are of one length
    double top;
} SOLIDS[] = {{"sphere", CURVED_SPHERE, true, 0},     {"ellipsoid", CURVED_SPHERE, false, 0},
              {"cylinder", CURVED_CYLINDER, true, 0}, {"flat cylinder", CURVED_CYLINDER, false, 0},
              {"cone", CURVED_CONE, true, 0},         {"cut cone", CURVED_CONE, false, 0.4},
              {"drum", CURVED_CONE, true, 1}};
enum { SOLID_COUNT = sizeof SOLIDS / sizeof *SOLIDS };

// A shape of any size from 1 mm to 100 m, turned, every other one a mirror image, up to a kilometre from the origin.
static CurvedShape random_solid(int kind, Random *random) {
    CurvedShape s = {.kind = SOLIDS[kind].kind, .top = SOLIDS[kind].top, .disc = {true, true}};
    Vec3 x = random_unit_vector(random), y = vec3_normalize(vec3_cross(x, random_unit_vector(random)));
    Vec3 axis[3] = {x, y, vec3_cross(x, y)};
    double size = pow(10, random_between(random, -3, 2));
    for (int i = 0; i < 3; i++) {
        double stretch = SOLIDS[kind].even ? 1 : random_between(random, 0.05, 1);
        s.frame.axis[i] = vec3_scale(axis[i], size * stretch * (i == 2 && random_index(random, 2) ? -1 : 1));
    }
    s.frame.origin = vec3_scale(random_unit_vector(random), size * random_between(random, 0, 10));
    return s;
}

typedef struct Local {
    Real x, y, z;
} Local;

static Local local_of(const CurvedShape *s, Vec3 p) {
    Real q[3], d[3] = {(Real)p.x - (Real)s->frame.origin.x, (Real)p.y - (Real)s->frame.origin.y,
                       (Real)p.z - (Real)s->frame.origin.z};
    for (int i = 0; i < 3; i++) {
        Vec3 a = s->frame.axis[i];
        Real x = a.x, y = a.y, z = a.z;
        q[i] = (d[0] * x + d[1] * y + d[2] * z) / (x * x + y * y + z * z);
    }
    return (Local){q[0], q[1], q[2]};
}

// Below 0 inside, about a distance in the shape's own space.
static double field(const CurvedShape *s, Vec3 p) {
    Local q = local_of(s, p);
    if (s->kind == CURVED_SPHERE) return (double)(sqrtl(q.x * q.x + q.y * q.y + q.z * q.z) - 1);
    Real radius = s->kind == CURVED_CONE ? 1 + ((Real)s->top - 1) * q.z : 1;
    return (double)fmaxl(sqrtl(q.x * q.x + q.y * q.y) - radius, fmaxl(-q.z, q.z - 1));
}

static double size_of(const CurvedShape *s) {
    return vec3_length(s->frame.axis[0]) + vec3_length(s->frame.axis[1]) + vec3_length(s->frame.axis[2]);
}

static double least_axis(const CurvedShape *s) {
    return fmin(vec3_length(s->frame.axis[0]),
                fmin(vec3_length(s->frame.axis[1]), vec3_length(s->frame.axis[2])));
}

static Vec3 at(const Ray *ray, double t) { return vec3_add(ray->origin, vec3_scale(ray->direction, t)); }

// Through the shape's surroundings; every third along an edge of what it may touch: a point of its surface, and a direction
// in the tangent plane, lifted by up to a thousandth.
static Ray random_ray(const CurvedShape *s, Random *random) {
    double z = random_unit(random), a = random_between(random, 0, 2 * M_PI),
           r = s->kind == CURVED_CONE ? 1 + (s->top - 1) * z : 1;
    double q[3] = {r * cos(a), r * sin(a), z};
    double tangent[3] = {-sin(a), cos(a), 0}, slope = s->kind == CURVED_CONE ? s->top - 1 : 0;
    if (s->kind == CURVED_SPHERE)
        q[2] = 2 * z - 1, q[0] *= sqrt(1 - q[2] * q[2]), q[1] *= sqrt(1 - q[2] * q[2]);
    bool grazes = random_index(random, 3) == 0;
    double along = random_between(random, -1, 1);
    Vec3 p = s->frame.origin, d = {0};
    for (int i = 0; i < 3; i++) {
        double reach = grazes ? q[i] : random_between(random, -1.2, 1.2);
        double way[3] = {cos(a) * slope, sin(a) * slope, 1};
        p = vec3_add(p, vec3_scale(s->frame.axis[i], reach));
        d = vec3_add(
            d, vec3_scale(s->frame.axis[i], tangent[i] + (s->kind == CURVED_SPHERE ? 0 : along * way[i])));
    }
    double lift = pow(10, random_between(random, -9, -3));
    d = grazes ? vec3_add(vec3_normalize(d), vec3_scale(random_unit_vector(random), lift))
               : random_unit_vector(random);
    d = vec3_normalize(d);
    double before = size_of(s) * random_between(random, 0, 4);
    return (Ray){vec3_sub(p, vec3_scale(d, before)), d, -INFINITY, INFINITY};
}

// The field's gradient by differences, unit.
static Vec3 gradient(const CurvedShape *s, Vec3 p) {
    double h = 1e-6 * least_axis(s);
    return vec3_normalize(vec3(field(s, vec3_add(p, vec3(h, 0, 0))) - field(s, vec3_sub(p, vec3(h, 0, 0))),
                               field(s, vec3_add(p, vec3(0, h, 0))) - field(s, vec3_sub(p, vec3(0, h, 0))),
                               field(s, vec3_add(p, vec3(0, 0, h))) - field(s, vec3_sub(p, vec3(0, 0, h)))));
}

// Is the point so near to an edge of the surface that differences across it mean nothing?
static bool near_edge(const CurvedShape *s, Vec3 p) {
    Local q = local_of(s, p);
    if (s->kind == CURVED_SPHERE) return false;
    Real radius = s->kind == CURVED_CONE ? 1 + ((Real)s->top - 1) * q.z : 1, r = sqrtl(q.x * q.x + q.y * q.y);
    bool on_side = fabsl(r - radius) < 1e-4L, on_disc = fabsl(q.z) < 1e-4L || fabsl(q.z - 1) < 1e-4L;
    return (on_side && on_disc) || r < 1e-4L;
}

static void check_solid(const CurvedShape *s, const CurvedRays *rays, const Ray *ray, const char *name,
                        uint64_t seed) {
    RayHit hits[4], first;
    int count = curved_rays_all(rays, 0, ray, hits, 4, NULL);
    unsigned long long number = seed;
    double size = size_of(s);
    // In the shape's own space, where the field is: rounding of the building's coordinates counts for more there.
    double exact = EXACT * size / least_axis(s);
    cr_assert(count == 0 || count == 2, "%s, seed %llu: %d hits of a convex solid", name, number, count);
    cr_assert_eq(curved_rays_hit(rays, 0, ray, &first, NULL), count > 0);
    if (count > 0) cr_assert(first.t == hits[0].t && vec3_equal(first.normal, hits[0].normal));
    for (int i = 0; i < count; i++) {
        Vec3 p = at(ray, hits[i].t), n = hits[i].normal;
        cr_assert(fabs(field(s, p)) < exact, "%s, seed %llu: hit %d is %g off", name, number, i, field(s, p));
        cr_assert(box_contains(curved_rays_box(rays, 0), p) || field(s, p) > 0,
                  "%s, seed %llu: out of bounds", name, number);
        cr_assert(fabs(vec3_length(n) - 1) < 1e-12);
        cr_assert((vec3_dot(n, ray->direction) <= 1e-6) == (i == 0) ||
                      fabs(vec3_dot(n, ray->direction)) < 1e-6 || near_edge(s, p),
                  "%s, seed %llu: normal %d faces the wrong way, %g", name, number, i,
                  vec3_dot(n, ray->direction));
        if (!near_edge(s, p))
            cr_assert(vec3_length(vec3_sub(gradient(s, p), n)) < 1e-4,
                      "%s, seed %llu: normal %d is not the field's", name, number, i);
    }
    double centre = vec3_dot(vec3_sub(s->frame.origin, ray->origin), ray->direction);
    for (int k = -4; k <= 4; k++) {
        double t = centre + (k + 0.3) * size / 5, f = field(s, at(ray, t));
        bool inside = count == 2 && hits[0].t < t && t < hits[1].t;
        cr_assert(inside ? f < exact : f > -exact, "%s, seed %llu: %s at t %g, the field is %g", name, number,
                  inside ? "inside" : "outside", t, f);
    }
}

// 100,000 rays a solid: hits lie on the surface, normals are the field's gradient, the ray is inside between its hits and
// nowhere else. Tolerance: EXACT, in the shape's own space; a miss of a hit as shallow as that cannot be told from one.
Test(curved_rays, solids, .timeout = 300) {
    for (int kind = 0; kind < SOLID_COUNT; kind++) {
        for (int round = 0; round < support_count(1000, 10000); round++) {
            Arena arena = {0};
            uint64_t seed = 100000 * (uint64_t)(kind + 1) + (uint64_t)round;
            Random random = {seed};
            CurvedShape shape = random_solid(kind, &random);
            Building building = {.shapes = &shape, .shape_count = 1};
            CurvedRays *rays = curved_rays_new(&building, &arena);
            for (int i = 0; i < 100; i++) {
                Ray ray = random_ray(&shape, &random);
                check_solid(&shape, rays, &ray, SOLIDS[kind].name, seed);
            }
            arena_free(&arena);
        }
    }
}

// Where discs are missing, hits are those of the closed solid but for the ones on these discs; what is hit is not what
// is left out.
Test(curved_rays, missing_discs) {
    for (int kind = 2; kind < SOLID_COUNT; kind++) {
        Arena arena = {0};
        Random random = {(uint64_t)kind};
        CurvedShape shapes[4];
        shapes[0] = random_solid(kind, &random);
        for (int k = 0; k < 4; k++) {
            shapes[k] = shapes[0];
            shapes[k].disc[0] = k & 1;
            shapes[k].disc[1] = k & 2;
        }
        Building building = {.shapes = shapes, .shape_count = 4};
        CurvedRays *rays = curved_rays_new(&building, &arena);
        int on_discs = 0;
        for (int i = 0; i < 20000; i++) {
            Ray ray = random_ray(&shapes[0], &random);
            RayHit closed[2], hits[2];
            int all = curved_rays_all(rays, 3, &ray, closed, 2, NULL);
            for (int k = 0; k < 3; k++) {
                int expected = 0, count = curved_rays_all(rays, k, &ray, hits, 2, NULL);
                for (int h = 0; h < all; h++) {
                    Vec3 axis = vec3_normalize(shapes[0].frame.axis[2]);
                    double z = vec3_dot(closed[h].normal, axis);
                    Local q = local_of(&shapes[0], at(&ray, closed[h].t));
                    int disc = fabs(fabs(z) - 1) < 1e-12 && fabsl(q.z - (z > 0)) < 1e-9L ? z > 0 : -1;
                    on_discs += disc >= 0;
                    if (disc >= 0 && !shapes[k].disc[disc]) continue;
                    cr_assert(expected < count && hits[expected].t == closed[h].t, "%s, ray %d",
                              SOLIDS[kind].name, i);
                    expected++;
                }
                cr_assert_eq(count, expected, "%s, ray %d: %d hits, not %d", SOLIDS[kind].name, i, count,
                             expected);
            }
        }
        cr_assert(on_discs > 1000);
        arena_free(&arena);
    }
}

// A ray that leaves a surface does not hit where it starts, given a near bound of a billionth of the size, and hits nothing
// else if it goes out, one more place if it goes in.
Test(curved_rays, from_the_surface) {
    for (int kind = 0; kind < SOLID_COUNT; kind++) {
        for (int round = 0; round < 2000; round++) {
            Arena arena = {0};
            Random random = {(uint64_t)(kind * 10000 + round)};
            CurvedShape shape = random_solid(kind, &random);
            Building building = {.shapes = &shape, .shape_count = 1};
            CurvedRays *rays = curved_rays_new(&building, &arena);
            Ray ray = random_ray(&shape, &random), next;
            RayHit hit, other;
            if (curved_rays_hit(rays, 0, &ray, &hit, NULL)) {
                next = (Ray){at(&ray, hit.t), random_unit_vector(&random), 1e-9 * size_of(&shape), INFINITY};
                double out = vec3_dot(next.direction, hit.normal);
                if (fabs(out) > 1e-2 && !near_edge(&shape, next.origin))
                    cr_assert_eq(curved_rays_hit(rays, 0, &next, &other, NULL), out < 0, "%s, seed %d",
                                 SOLIDS[kind].name, kind * 10000 + round);
                ray.far = hit.t;
                cr_assert(!curved_rays_hit(rays, 0, &ray, &other, NULL), "a hit at `far`");
            }
            arena_free(&arena);
        }
    }
}
