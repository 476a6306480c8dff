// test_bezier_clip.c - rays and Bezier patches: every hit there is, and no other, against a dense grid refined by Newton's
// steps in long doubles; rays that touch; patches of all sizes and places; neighbours without cracks; trims.
#include <criterion/criterion.h>

#include "engine/bench/ray_patches.h"
#include "engine/core/random.h"
#include "tests/support/oracles/patch_oracle.h"
#include "tests/support/support.h"
#include "visibility/rays/curved_rays.h"

// The error of a hit's place, of the patch's size.
#define EXACT 1e-9

typedef struct Bench {
    Building building;
    CurvedRays *rays;
    PatchOracle *oracle;
    double size;
} Bench;

static Bench bench_of(int patch, double scale, Vec3 shift, int cells, Arena *arena) {
    Bench b = {.building = ray_patch_building(patch, scale, arena)};
    for (int k = 0; k < 16; k++) b.building.controls[k].point = vec3_add(b.building.controls[k].point, shift);
    b.building.shapes[0].trim_count = 0;
    b.rays = curved_rays_new(&b.building, arena);
    b.oracle = patch_oracle_new(&b.building, cells, arena);
    b.size = patch_oracle_size(b.oracle);
    return b;
}

static Vec3 random_unit_vector(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(a), r * sin(a), z);
}

static Ray ray_through(Vec3 p, Vec3 direction, double before) {
    return (Ray){vec3_sub(p, vec3_scale(direction, before)), direction, -INFINITY, INFINITY};
}

// Three of four rays pass anywhere through the bounds, the others nearly touch the patch: down to a millionth of a radian.
static Ray random_ray(const Bench *b, Random *random) {
    if (random_unit(random) < 0.75) {
        Box box = curved_rays_box(b->rays, 0);
        Vec3 p =
            vec3(random_between(random, box.min.x, box.max.x), random_between(random, box.min.y, box.max.y),
                 random_between(random, box.min.z, box.max.z));
        return ray_through(p, random_unit_vector(random), 3 * b->size);
    }
    Vec3 du, dv, p = patch_oracle_point(b->oracle, random_unit(random), random_unit(random), &du, &dv);
    double turn = random_between(random, 0, 2 * M_PI), lift = pow(10, random_between(random, -6, 0));
    Vec3 n = vec3_normalize(vec3_cross(du, dv));
    Vec3 d = vec3_add(vec3_scale(vec3_normalize(du), cos(turn)), vec3_scale(vec3_normalize(dv), sin(turn)));
    d = vec3_normalize(vec3_add(vec3_normalize(d), vec3_scale(n, lift)));
    return ray_through(p, d, 3 * b->size);
}

static double off_ray(const Bench *b, const Ray *ray, const RayHit *hit) {
    Vec3 p = patch_oracle_point(b->oracle, hit->u, hit->v, NULL, NULL);
    return vec3_length(vec3_sub(p, vec3_add(ray->origin, vec3_scale(ray->direction, hit->t))));
}

typedef struct Tally {
    long long rays, roots, unsure, beyond_the_grid;
} Tally;

// How far a hit may lie from its root along the ray: a thousand roundings across it, which a grazing ray stretches.
static double known_to(const Bench *b, const Ray *ray, const RayHit *hit) {
    return fmin(1e-5, EXACT + 1e-12 / fabs(vec3_dot(hit->normal, ray->direction))) * b->size;
}

// Each hit is a root, each root is a hit, one each.
static void check_ray(const Bench *b, const Ray *ray, const char *name, unsigned long long seed,
                      Tally *tally) {
    OracleRoot roots[ORACLE_ROOTS];
    RayHit hits[ORACLE_ROOTS];
    bool taken[ORACLE_ROOTS] = {false};
    int root_count = patch_oracle_roots(b->oracle, ray, roots);
    int count = curved_rays_all(b->rays, 0, ray, hits, ORACLE_ROOTS, NULL);
    tally->rays++;
    tally->roots += root_count;
    for (int i = 0; i < count && i < ORACLE_ROOTS; i++) {
        OracleRoot root;
        double off = off_ray(b, ray, &hits[i]);
        cr_assert(off < EXACT * b->size, "%s, seed %llu: hit %d is %g off the ray", name, seed, i,
                  off / b->size);
        bool known = false;
        for (int k = 0; k < root_count; k++) {
            double apart = fabs(roots[k].t - hits[i].t);
            if (taken[k] || apart > (roots[k].sure ? known_to(b, ray, &hits[i]) : 1e-5 * b->size)) continue;
            taken[k] = known = true;
            break;
        }
        if (known) continue;
        bool is_root = patch_oracle_refine(b->oracle, ray, hits[i].u, hits[i].v, &root);
        if (is_root && root.sure) tally->beyond_the_grid++;
        cr_assert(!is_root || !root.sure || fabs(root.t - hits[i].t) < known_to(b, ray, &hits[i]),
                  "%s, seed %llu", name, seed);
        for (int k = 0; k < root_count && is_root && root.sure; k++)
            cr_assert(fabs(roots[k].t - root.t) > EXACT * b->size,
                      "%s, seed %llu: hit %d of %d is there twice", name, seed, i, count);
    }
    for (int k = 0; k < root_count; k++) {
        tally->unsure += !roots[k].sure;
        cr_assert(taken[k] || !roots[k].sure,
                  "%s, seed %llu: no hit at u %.9f v %.9f t %.9f (%d hits, %d roots)", name, seed, roots[k].u,
                  roots[k].v, roots[k].t, count, root_count);
    }
}

// All roots of 1,000 rays a patch, and no more: number and place.
Test(bezier_clip, all_roots, .timeout = 300) {
    for (int patch = 0; patch < RAY_PATCHES; patch++) {
        Arena arena = {0};
        Bench b = bench_of(patch, 1, vec3(0, 0, 0), support_count(40, 100), &arena);
        Tally tally = {0};
        for (int i = 0; i < support_count(1000, 20000); i++) {
            uint64_t seed = 1000000 * (uint64_t)(patch + 1) + (uint64_t)i;
            Random random = {seed};
            Ray ray = random_ray(&b, &random);
            check_ray(&b, &ray, RAY_PATCH_NAMES[patch], (unsigned long long)seed, &tally);
        }
        cr_log_info("%s: %lld roots of %lld rays, %lld at folds, %lld beyond the grid",
                    RAY_PATCH_NAMES[patch], tally.roots, tally.rays, tally.unsure, tally.beyond_the_grid);
        cr_assert(tally.unsure * 4 < tally.roots && tally.beyond_the_grid * 100 < tally.roots);
        arena_free(&arena);
    }
}

// A direction along the surface, and how far in it the surface stays within `off` of its tangent.
static Vec3 tangent_at(const Bench *b, double u, double v, double turn, double off, Vec3 *p, double *reach) {
    Vec3 du, dv;
    *p = patch_oracle_point(b->oracle, u, v, &du, &dv);
    Vec3 n = vec3_normalize(vec3_cross(du, dv)), x = vec3_normalize(du), y = vec3_cross(n, x);
    Vec3 d = vec3_add(vec3_scale(x, cos(turn)), vec3_scale(y, sin(turn)));
    double along_v = vec3_dot(d, y) / vec3_dot(dv, y);
    double along_u = (vec3_dot(d, x) - along_v * vec3_dot(dv, x)) / vec3_length(du);
    double away = 0;
    for (*reach = 1e-7 * b->size; away < off && *reach < b->size; *reach *= 2) {
        away = INFINITY;
        for (int side = -1; side <= 1; side += 2) {
            Vec3 q = patch_oracle_point(b->oracle, u + side * *reach * along_u, v + side * *reach * along_v,
                                        NULL, NULL);
            away = fmin(away, fabs(vec3_dot(n, vec3_sub(q, *p))));
        }
    }
    return d;
}

// Rays that touch a patch without passing through: the double root is there, and at its place. Tolerance: anywhere
// where the surface is within some roundings of the ray (the search takes 1.6e-13 of the size for nothing, and which points
// lie over the ray is only known to first order here). In an asymptotic direction, where the root is as good as triple,
// the iteration may end undecided, and says so.
Test(bezier_clip, rays_that_touch, .timeout = 300) {
    for (int patch = 1; patch < RAY_PATCHES; patch++) {
        Arena arena = {0};
        Bench b = bench_of(patch, 1, vec3(0, 0, 0), 1, &arena);
        CurvedWork work = {0};
        int missed = 0;
        for (int i = 0; i < support_count(1000, 100000); i++) {
            unsigned long long seed = 50000 * (unsigned long long)patch + (unsigned long long)i;
            Random random = {seed};
            Vec3 p;
            double reach, u = random_between(&random, 0.01, 0.99), v = random_between(&random, 0.01, 0.99);
            Vec3 d = tangent_at(&b, u, v, random_between(&random, 0, 2 * M_PI), 2e-12 * b.size, &p, &reach);
            Ray ray = ray_through(p, d, 3 * b.size);
            RayHit hits[ORACLE_ROOTS];
            long long undecided = work.undecided;
            int count = curved_rays_all(b.rays, 0, &ray, hits, ORACLE_ROOTS, &work);
            double nearest = INFINITY;
            for (int k = 0; k < count && k < ORACLE_ROOTS; k++)
                nearest = fmin(nearest, fabs(hits[k].t - 3 * b.size));
            missed += nearest >= reach;
            cr_assert(nearest < reach || work.undecided > undecided,
                      "%s, seed %llu: u %.6f v %.6f, %d hits, the nearest %g away, not %g",
                      RAY_PATCH_NAMES[patch], seed, u, v, count, nearest, reach);
        }
        cr_assert(100 * work.undecided <= work.rays, "%s: %lld of %lld undecided", RAY_PATCH_NAMES[patch],
                  work.undecided, work.rays);
        cr_assert(200LL * missed <= work.rays, "%s: %d of %lld missed", RAY_PATCH_NAMES[patch], missed,
                  work.rays);
        cr_log_info("%s: %.1f clips, %.1f halvings, %.1f steps a ray, %lld undecided, %d missed",
                    RAY_PATCH_NAMES[patch], (double)work.clips / (double)work.rays,
                    (double)work.splits / (double)work.rays, (double)work.steps / (double)work.rays,
                    work.undecided, missed);
        arena_free(&arena);
    }
}

// A patch of 1 mm, of 1 km, or far from the origin is hit where the same patch of 2 m at the origin is. Tolerance: what the
// coordinates themselves are rounded to, doubled by the angle of the ray, and a thousandfold for grazing ones.
Test(bezier_clip, small_large_and_far) {
    static const double SCALE[4] = {0.0005, 1, 500, 1};
    const Vec3 SHIFT[4] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {90, -40, 1000}};
    for (int patch = 0; patch < RAY_PATCHES; patch++) {
        Arena arena = {0};
        Bench b[4];
        for (int k = 0; k < 4; k++) b[k] = bench_of(patch, SCALE[k], SHIFT[k], 1, &arena);
        for (int i = 0; i < 300; i++) {
            Random random = {(uint64_t)i};
            Ray ray = random_ray(&b[1], &random), other = ray;
            RayHit hit, same;
            bool hits = curved_rays_hit(b[1].rays, 0, &ray, &hit, NULL);
            double slope = hits ? fabs(vec3_dot(hit.normal, ray.direction)) : 0;
            for (int k = 0; k < 4; k++) {
                other.origin = vec3_add(vec3_scale(ray.origin, SCALE[k]), SHIFT[k]);
                bool hits_same = curved_rays_hit(b[k].rays, 0, &other, &same, NULL);
                if (slope < 1e-4) continue;
                cr_assert(hits_same && fabs(same.t / SCALE[k] - hit.t) < 1e-12 / slope * (k == 3 ? 100 : 1),
                          "%s, seed %d, scale %d: t %.15f, not %.15f", RAY_PATCH_NAMES[patch], i, k,
                          hits_same ? same.t / SCALE[k] : -1, hit.t);
            }
        }
        arena_free(&arena);
    }
}

// Control points in the middle of a row of four are those of its halves, which share the last and the first.
static void halve_row(const CurvedControl row[4], CurvedControl first[4], CurvedControl second[4]) {
    double p[4][4];
    for (int i = 0; i < 4; i++) {
        p[i][0] = row[i].point.x * row[i].weight, p[i][1] = row[i].point.y * row[i].weight;
        p[i][2] = row[i].point.z * row[i].weight, p[i][3] = row[i].weight;
    }
    for (int level = 0; level < 4; level++) {
        first[level] =
            (CurvedControl){vec3(p[0][0] / p[0][3], p[0][1] / p[0][3], p[0][2] / p[0][3]), p[0][3]};
        int last = 3 - level;
        second[last] = (CurvedControl){
            vec3(p[last][0] / p[last][3], p[last][1] / p[last][3], p[last][2] / p[last][3]), p[last][3]};
        for (int i = 0; i < last; i++)
            for (int k = 0; k < 4; k++) p[i][k] = (p[i][k] + p[i + 1][k]) / 2;
    }
}

// A patch and its two halves: a ray at their seam hits one of them, or both, where it hits the whole. And at a pole, where a
// row of control points is one point, it hits once, with a normal.
Test(bezier_clip, seams_and_poles) {
    for (int patch = 0; patch < RAY_PATCHES; patch++) {
        Arena arena = {0};
        Bench b = bench_of(patch, 1, vec3(0, 0, 0), 1, &arena);
        CurvedControl halves[32];
        CurvedShape shapes[2] = {b.building.shapes[0], b.building.shapes[0]};
        for (int row = 0; row < 4; row++)
            halve_row(&b.building.controls[4 * row], &halves[4 * row], &halves[16 + 4 * row]);
        shapes[1].first_control = 16;
        Building cut = {.controls = halves, .control_count = 32, .shapes = shapes, .shape_count = 2};
        CurvedRays *rays = curved_rays_new(&cut, &arena);
        for (int i = 0; i < 5000; i++) {
            Random random = {(uint64_t)i};
            Vec3 p = patch_oracle_point(b.oracle, 0.5, random_unit(&random), NULL, NULL);
            Ray ray = ray_through(p, random_unit_vector(&random), 3 * b.size);
            bool met = false;
            for (int half = 0; half < 2; half++) {
                RayHit hits[ORACLE_ROOTS];
                int count = curved_rays_all(rays, half, &ray, hits, ORACLE_ROOTS, NULL);
                for (int k = 0; k < count; k++) {
                    double slope = fabs(vec3_dot(hits[k].normal, ray.direction));
                    met |= fabs(hits[k].t - 3 * b.size) < 1e-12 * b.size / fmax(slope * slope, 1e-8);
                }
            }
            cr_assert(met, "%s, seed %d: slips through", RAY_PATCH_NAMES[patch], i);
        }
        arena_free(&arena);
    }
    Arena arena = {0};
    Bench b = bench_of(6, 1, vec3(0, 0, 0), 1, &arena);  // the sphere: its pole is at the end of v
    for (int i = 0; i < 5000; i++) {
        Random random = {(uint64_t)i};
        Vec3 d = random_unit_vector(&random);
        d.z = -0.1 - fabs(d.z);
        Ray ray = ray_through(vec3(0, 0, 1), vec3_normalize(d), 3 * b.size);
        ray.far = 3.1 * b.size;
        RayHit hits[4];
        int count = curved_rays_all(b.rays, 0, &ray, hits, 4, NULL);
        cr_assert_eq(count, 1, "seed %d: %d hits at the pole", i, count);
        cr_assert(fabs(hits[0].t - 3 * b.size) < EXACT * b.size && fabs(fabs(hits[0].normal.z) - 1) < 1e-9,
                  "seed %d: normal %g %g %g", i, hits[0].normal.x, hits[0].normal.y, hits[0].normal.z);
    }
    arena_free(&arena);
}
