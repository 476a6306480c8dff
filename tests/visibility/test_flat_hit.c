// test_flat_hit.c - rays and boxes, which are their faces; concave polygons against triangles; meshes without cracks.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "visibility/rays/flat_hit.h"

static Vec3 random_unit_vector(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(a), r * sin(a), z);
}

// A box is hit where its six faces are, as polygons: same places, same normals.
Test(flat_hit, boxes_are_their_faces) {
    for (int i = 0; i < 100000; i++) {
        Random random = {(uint64_t)i};
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++) {
            lower[k] = random_between(&random, -1, 0.5);
            upper[k] = lower[k] + random_between(&random, 0.01, 1);
        }
        Box box = {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
        Vec3 p = vec3(random_between(&random, -1, 1), random_between(&random, -1, 1),
                      random_between(&random, -1, 1));
        Vec3 d = i % 7 ? random_unit_vector(&random) : vec3(i % 3 == 0, i % 3 == 1, i % 3 == 2);
        Ray ray = {vec3_sub(p, vec3_scale(d, 2)), d, -INFINITY, INFINITY};
        RayHit hit[4], face_hit[8];
        HitList hits = {hit, 0, 4, ray.near, ray.far}, faces = {face_hit, 0, 8, ray.near, ray.far};
        box_hits(&box, &ray, &hits);
        for (int face = 0; face < 6; face++) {
            int axis = face / 2, end = face % 2;
            Vec3 v[4], n = {axis == 0, axis == 1, axis == 2};
            for (int k = 0; k < 4; k++) {
                double q[3];
                q[axis] = end ? upper[axis] : lower[axis];
                q[(axis + 1) % 3] = k == 1 || k == 2 ? upper[(axis + 1) % 3] : lower[(axis + 1) % 3];
                q[(axis + 2) % 3] = k >= 2 ? upper[(axis + 2) % 3] : lower[(axis + 2) % 3];
                v[k] = vec3(q[0], q[1], q[2]);
            }
            Plane plane = {vec3_scale(n, end ? 1 : -1), end ? upper[axis] : -lower[axis]};
            polygon_hits(v, 4, plane, &ray, &faces);
        }
        cr_assert_eq(hits.count, faces.count, "seed %d: %d hits, the faces have %d", i, hits.count,
                     faces.count);
        for (int k = 0; k < hits.count; k++)
            cr_assert(fabs(hit[k].t - face_hit[k].t) < 1e-12 && vec3_equal(hit[k].normal, face_hit[k].normal),
                      "seed %d", i);
    }
}

// A star of random radii about the origin, in a random plane: concave in most corners, and known in polar coordinates.
static int random_star(Random *random, Vec3 *v, double *radius, Vec3 axis[3]) {
    int count = 3 + random_index(random, 30);
    axis[0] = random_unit_vector(random);
    axis[1] = vec3_normalize(vec3_cross(axis[0], random_unit_vector(random)));
    axis[2] = vec3_cross(axis[0], axis[1]);
    for (int i = 0; i < count; i++) {
        double a = 2 * M_PI * i / count;
        radius[i] = random_between(random, 0.05, 1);
        v[i] = vec3_add(vec3_scale(axis[0], radius[i] * cos(a)), vec3_scale(axis[1], radius[i] * sin(a)));
    }
    return count;
}

// Concave polygons: a ray hits where its place in the plane is in one of the triangles from the star's centre.
Test(flat_hit, concave_polygons) {
    int inside = 0;
    for (int i = 0; i < 100000; i++) {
        Random random = {(uint64_t)i};
        Vec3 v[40], axis[3];
        double radius[40];
        int count = random_star(&random, v, radius, axis);
        Vec3 d = random_unit_vector(&random);
        double x = random_between(&random, -1, 1), y = random_between(&random, -1, 1),
               slope = vec3_dot(d, axis[2]);
        Vec3 p = vec3_add(vec3_scale(axis[0], x), vec3_scale(axis[1], y));
        Ray ray = {vec3_sub(p, vec3_scale(d, 3)), d, 0, INFINITY};
        double turn = atan2(y, x) / (2 * M_PI) * count;
        turn += turn < 0 ? count : 0;
        int k = (int)turn % count, next = (k + 1) % count;
        double a = 2 * M_PI * k / count, b = 2 * M_PI * (k + 1) / count;
        Vec2 from = {radius[k] * cos(a), radius[k] * sin(a)},
             to = {radius[next] * cos(b), radius[next] * sin(b)};
        double side = vec2_cross(vec2_sub(to, from), vec2_sub(vec2(x, y), from));
        if (fabs(side) < 1e-9 || fabs(slope) < 1e-3) continue;
        RayHit hit[2];
        HitList list = {hit, 0, 1, 0, INFINITY};
        polygon_hits(v, count, (Plane){axis[2], 0}, &ray, &list);
        // Of triangles of more than half a turn, only three corners: the centre may lie outside.
        if (count > 3)
            cr_assert_eq(list.count, side > 0, "seed %d: %d hits, the side is %g", i, list.count, side);
        if (list.count) cr_assert(fabs(hit[0].t - 3) < 1e-9 / fabs(slope));
        inside += list.count;
    }
    cr_assert(inside > 10000);
}

// Rays at corners and along edges of a bent mesh of triangles: each hits one of the two or six that meet there, or more,
// never none.
Test(flat_hit, no_cracks_between_polygons) {
    enum { SIDE = 12 };
    Random random = {1};
    Vec3 grid[SIDE + 1][SIDE + 1];
    for (int i = 0; i <= SIDE; i++)
        for (int k = 0; k <= SIDE; k++) grid[i][k] = vec3(k, i, random_unit(&random));
    for (int n = 0; n < 20000; n++) {
        int i = 1 + random_index(&random, SIDE - 1), k = 1 + random_index(&random, SIDE - 1);
        Vec3 p =
            vec3_lerp(grid[i][k], n % 2 ? grid[i][k - 1] : grid[i - 1][k], n % 3 ? random_unit(&random) : 0);
        Vec3 eye = vec3(random_between(&random, 5, 7), random_between(&random, 5, 7), 9);
        Ray ray = {eye, vec3_normalize(vec3_sub(p, eye)), 0, INFINITY};
        RayHit hit;
        HitList list = {&hit, 0, 1, 0, INFINITY};
        for (int a = i - 1; a <= i; a++)
            for (int b = k - 1; b <= k; b++) {
                Vec3 *q[4] = {&grid[a][b], &grid[a][b + 1], &grid[a + 1][b + 1], &grid[a + 1][b]};
                for (int half = 0; half < 2; half++) {
                    Vec3 v[3] = {*q[0], *q[1 + half], *q[2 + half]};
                    polygon_hits(v, 3, plane_of_polygon(v, 3), &ray, &list);
                }
            }
        cr_assert(list.count > 0, "ray %d slips through", n);
    }
}
