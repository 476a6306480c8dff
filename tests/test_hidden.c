// test_hidden.c - the item-buffer methods against each other, and against Embree.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "tests/embree_oracle.h"
#include "visibility/hidden/raycast.h"

#define PI 3.14159265358979323846

typedef struct Soup {
    Polygon *polygons;
    Vec3 *vertices;
    int polygon_count, vertex_count, polygon_capacity, vertex_capacity;
} Soup;

static void soup_add(Arena *arena, Soup *soup, const Vec3 *vertices, int count) {
    *ARENA_PUSH(arena, soup->polygons, soup->polygon_count, soup->polygon_capacity) =
        (Polygon){soup->vertex_count, count, 0};
    for (int i = 0; i < count; i++) {
        *ARENA_PUSH(arena, soup->vertices, soup->vertex_count, soup->vertex_capacity) = vertices[i];
    }
}

static Vec3 random_direction(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * PI), s = sqrt(1 - z * z);
    return vec3(s * cos(a), s * sin(a), z);
}

// A convex polygon of 3 to 6 vertices on an ellipse, one in three with a collinear vertex on its last edge.
static void soup_add_random(Arena *arena, Soup *soup, Random *random, Vec3 centre, Vec3 n) {
    Vec3 u = vec3_normalize(vec3_cross(n, fabs(n.z) > 0.9 ? vec3(1, 0, 0) : vec3(0, 0, 1))),
         v = vec3_cross(n, u);
    double a = random_between(random, 0.05, 3), b = random_between(random, 0.05, 3);
    double start = random_between(random, 0, 2 * PI);
    int count = 3 + random_index(random, 4);
    Vec3 p[7];
    for (int i = 0; i < count; i++) {
        double t = start + 2 * PI * i / count;
        p[i] = vec3_add(centre, vec3_add(vec3_scale(u, a * cos(t)), vec3_scale(v, b * sin(t))));
    }
    if (random_index(random, 3) == 0) {
        p[count] = vec3_lerp(p[count - 1], p[0], 0.5);
        count++;
    }
    soup_add(arena, soup, p, count);
}

// Random polygons about the eye; with repeats of earlier ones, and sheets whose plane holds the eye.
static Soup soup_new(Arena *arena, Random *random, Vec3 eye, int count) {
    Soup soup = {0};
    for (int i = 0; i < count; i++) {
        Vec3 centre = vec3_add(eye, vec3_scale(random_direction(random), random_between(random, 0.5, 10)));
        int kind = random_index(random, 10);
        if (kind == 0 && soup.polygon_count > 0) {
            Polygon p = soup.polygons[random_index(random, soup.polygon_count)];
            Vec3 copy[8];
            for (int k = 0; k < p.vertex_count; k++) copy[k] = soup.vertices[p.first_vertex + k];
            soup_add(arena, &soup, copy, p.vertex_count);
        } else if (kind == 1) {
            Vec3 n = vec3_cross(random_direction(random), vec3_sub(centre, eye));
            soup_add_random(arena, &soup, random, centre, vec3_normalize(n));
        } else if (kind < 5) {
            int axis = random_index(random, 3);
            soup_add_random(arena, &soup, random, centre, vec3(axis == 0, axis == 1, axis == 2));
        } else {
            soup_add_random(arena, &soup, random, centre, random_direction(random));
        }
    }
    return soup;
}

// Each soup twice: at the origin and 1,000 km off, where a double still holds 1e-10 m.
static Vec3 place(int trial) { return trial % 2 ? vec3(8e5, -6e5, 100) : vec3(0, 0, 0); }

static Camera random_camera(Random *random, Vec3 eye, int width, int height) {
    return camera_look(eye, random_between(random, -PI, PI), random_between(random, -1.5, 1.5),
                       random_between(random, 0.3, 2.2), width, height);
}

// camera_look's frame is right-handed, row 0 is the top, and yaw and pitch are what Viewpoint says.
Test(hidden, camera) {
    Camera c = camera_look(vec3(1, 2, 3), PI / 2, 0, PI / 2, 200, 100);
    cr_assert(vec3_length(vec3_sub(c.forward, vec3(0, 1, 0))) < 1e-15);
    cr_assert(vec3_length(vec3_sub(c.right, vec3(1, 0, 0))) < 1e-15);
    cr_assert(vec3_length(vec3_sub(c.up, vec3(0, 0, 1))) < 1e-15);
    cr_assert_float_eq(c.tan_x, 1, 1e-15);
    cr_assert_float_eq(c.tan_y, 0.5, 1e-15);
    cr_assert(vec3_length(vec3_sub(camera_ray(&c, 0, 0), vec3(-1, 1, 0.5))) < 1e-15);
    cr_assert(camera_look(vec3(0, 0, 0), 1, 0.5, 1, 2, 2).forward.z > 0);
    cr_assert(hidden_find("raycast") == &HIDDEN_RAYCAST && hidden_find("no such") == NULL);
}

// The hierarchy changes no pixel: items and depths are equal bit for bit to testing every polygon, copies and
// edge-on polygons among them; of copies the first in the list is seen, and edge-on ones never are.
Test(hidden, hierarchy_equals_brute_force) {
    uint64_t seed = 1;
    Random random = {seed};
    for (int trial = 0; trial < 60; trial++) {
        Arena arena = {0};
        Vec3 eye = place(trial);
        Soup soup = soup_new(&arena, &random, eye, 1 << random_index(&random, 10));
        int *list = ARENA_ARRAY(&arena, int, soup.polygon_count);
        // Backwards: the list's order decides, not the index.
        for (int i = 0; i < soup.polygon_count; i++) list[i] = soup.polygon_count - 1 - i;
        Scene scene = {soup.polygons, soup.vertices, trial % 3 ? list : NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena);
        for (int i = 0; i < 2000; i++) {
            Vec3 ray = i % 5 == 0 ? vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 % 3 - 1) : random_direction(&random);
            float z, brute_z;
            int item = ray_scene_nearest(rays, eye, ray, &z);
            int brute = ray_scene_nearest_brute(rays, eye, ray, &brute_z);
            cr_assert(item == brute && z == brute_z, "seed %lu, trial %d, ray %d: %d at %g, brute %d at %g",
                      (unsigned long)seed, trial, i, item, (double)z, brute, (double)brute_z);
        }
        arena_free(&arena);
    }
}

// A box around the eye has no crack: rays through its edges, corners and T-vertices all hit, from any place in it.
Test(hidden, no_ray_slips_through_an_edge) {
    Random random = {2};
    for (int trial = 0; trial < 50; trial++) {
        Arena arena = {0};
        Soup soup = {0};
        Vec3 o = place(trial);
        double t = random_between(&random, 0.1, 0.9);
        for (int axis = 0; axis < 3; axis++) {
            for (int side = 0; side < 2; side++) {
                // Floor and ceiling are two pieces each, so the faces across y carry vertices on their long edges.
                double corner[6][2] = {{0, 0}, {t, 0}, {1, 0}, {1, 1}, {t, 1}, {0, 1}};
                for (int half = 0; half < (axis == 2 ? 2 : 1); half++) {
                    int pick[4][6] = {{0, 2, 3, 5}, {0, 1, 2, 3, 4, 5}, {0, 1, 4, 5}, {1, 2, 3, 4}};
                    Vec3 p[6];
                    int n = axis == 1 ? 6 : 4;
                    for (int i = 0; i < n; i++) {
                        double *c = corner[pick[axis + half][i]];
                        p[i] = axis == 0   ? vec3(o.x + side * 7.1, o.y + c[0] * 3.3, o.z + c[1] * 2.7)
                               : axis == 1 ? vec3(o.x + c[0] * 7.1, o.y + side * 3.3, o.z + c[1] * 2.7)
                                           : vec3(o.x + c[0] * 7.1, o.y + c[1] * 3.3, o.z + side * 2.7);
                    }
                    soup_add(&arena, &soup, p, n);
                }
            }
        }
        Scene scene = {soup.polygons, soup.vertices, NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena);
        Vec3 eye =
            vec3(o.x + random_between(&random, 0.001, 7.099), o.y + random_between(&random, 0.001, 3.299),
                 o.z + random_between(&random, 0.001, 2.699));
        for (int k = 0; k < soup.polygon_count; k++) {
            const Vec3 *v = soup.vertices + soup.polygons[k].first_vertex;
            for (int i = 0; i < 200; i++) {
                int a = i % soup.polygons[k].vertex_count, b = (a + 1) % soup.polygons[k].vertex_count;
                Vec3 ray = vec3_sub(vec3_lerp(v[a], v[b], i < 20 ? 0 : random_unit(&random)), eye);
                float z;
                cr_assert(ray_scene_nearest(rays, eye, ray, &z) >= 0, "trial %d, polygon %d, edge %d", trial,
                          k, a);
            }
        }
        arena_free(&arena);
    }
}

// A sheet whose plane passes the eye within float rounding may show as a line, or not.
static bool edge_on(const Scene *scene, int item, Vec3 eye) {
    const Vec3 *v = scene->vertices + scene->polygons[item].first_vertex;
    Plane plane = plane_of_polygon(v, scene->polygons[item].vertex_count);
    return fabs(vec3_dot(plane.n, vec3_sub(v[0], eye))) < 1e-5;
}

// What a rasteriser may see at a pixel instead: what lies within a 128th of a pixel (it rounds vertices to a 256th),
// or at the same depth but for float rounding.
static bool excused(const RayScene *rays, const Camera *camera, int i, int j, int item, float z,
                    float seen_z) {
    float tie =
        1e-5f * fminf(z, seen_z);  // about 100 roundings of a float, for a plane seen at a grazing angle
    if (fabsf(z - seen_z) <= tie) return true;
    for (int k = 0; k < 32; k++) {
        double angle = 2 * PI * k / 16, radius = k < 16 ? 1 / 128.0 : 1 / 300.0;
        Vec3 ray = camera_ray(camera, i + 0.5 + radius * cos(angle), j + 0.5 + radius * sin(angle));
        float near;
        int other = ray_scene_nearest(rays, camera->eye, ray, &near);
        if (other == item || (isfinite(near) && fabsf(near - seen_z) <= 10 * tie)) return true;
    }
    return false;
}

typedef struct Difference {
    int pixels, excused, unexcused, depth;
} Difference;

static Difference compare(const Scene *scene, const RayScene *rays, const Camera *camera,
                          const ItemBuffer *want, const ItemBuffer *got) {
    Difference d = {0};
    for (int j = 0; j < camera->height; j++) {
        for (int i = 0; i < camera->width; i++) {
            int p = j * camera->width + i;
            d.pixels++;
            if (want->item[p] == got->item[p]) {
                // Float rounding of 1/z, a hundred times over for grazing planes.
                if (want->item[p] >= 0 && fabsf(want->depth[p] - got->depth[p]) > 1e-4f * want->depth[p])
                    d.depth++;
            } else if ((got->item[p] >= 0 && edge_on(scene, got->item[p], camera->eye)) ||
                       excused(rays, camera, i, j, got->item[p], want->depth[p], got->depth[p])) {
                d.excused++;
            } else {
                d.unexcused++;
            }
        }
    }
    return d;
}

// The item buffer by OpenGL equals the ray caster's off edges and ties, on soups near and far from the origin.
// At most one pixel in 100 needs an excuse: edges are many in a soup of 300, but thin.
Test(hidden, osmesa_equals_raycast, .timeout = 60) {
    uint64_t seed = 3;
    Random random = {seed};
    for (int trial = 0; trial < 12; trial++) {
        Arena arena = {0};
        Error error;
        Vec3 eye = place(trial);
        Soup soup = soup_new(&arena, &random, eye, 300);
        Scene scene = {soup.polygons, soup.vertices, NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena);
        void *osmesa = hidden_find("osmesa")->begin(&scene, &arena, &error);
        cr_assert(osmesa, "%s", error.text);
        for (int k = 0; k < 2; k++) {
            Camera camera = random_camera(&random, eye, 160 + 40 * k, 120);
            ItemBuffer want = item_buffer_new(&arena, camera.width, camera.height);
            ItemBuffer got = item_buffer_new(&arena, camera.width, camera.height);
            cr_assert(HIDDEN_RAYCAST.draw(rays, &camera, &want, &error));
            cr_assert(hidden_find("osmesa")->draw(osmesa, &camera, &got, &error), "%s", error.text);
            Difference d = compare(&scene, rays, &camera, &want, &got);
            cr_assert(d.unexcused == 0 && d.depth == 0 && d.excused * 100 <= d.pixels,
                      "seed %lu, trial %d: %d of %d pixels differ, %d of them excused; %d depths",
                      (unsigned long)seed, trial, d.unexcused + d.excused, d.pixels, d.excused, d.depth);
        }
        hidden_find("osmesa")->end(osmesa);
        arena_free(&arena);
    }
}

// Embree, which shares no code with us, sees what the ray caster sees, but for float rounding at edges and ties.
Test(hidden, embree_equals_raycast, .timeout = 60) {
    uint64_t seed = 4;
    Random random = {seed};
    for (int trial = 0; trial < 12; trial++) {
        Arena arena = {0};
        Error error;
        Vec3 eye = place(trial);
        Soup soup = soup_new(&arena, &random, eye, 300);
        Scene scene = {soup.polygons, soup.vertices, NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena);
        EmbreeOracle *embree = embree_oracle_new(&scene, eye, &arena);
        Camera camera = random_camera(&random, eye, 160, 120);
        ItemBuffer want = item_buffer_new(&arena, camera.width, camera.height);
        ItemBuffer got = item_buffer_new(&arena, camera.width, camera.height);
        cr_assert(HIDDEN_RAYCAST.draw(rays, &camera, &want, &error));
        embree_oracle_draw(embree, &camera, &got);
        Difference d = compare(&scene, rays, &camera, &want, &got);
        cr_assert(d.unexcused == 0 && d.excused * 100 <= d.pixels,
                  "seed %lu, trial %d: %d of %d pixels differ, %d excused", (unsigned long)seed, trial,
                  d.unexcused + d.excused, d.pixels, d.excused);
        embree_oracle_free(embree);
        arena_free(&arena);
    }
}

// An eye that almost touches a wall, or lies exactly in the corner line of two, does not look through them.
Test(hidden, near_walls_stay_closed) {
    Arena arena = {0};
    Error error;
    Soup soup = {0};
    Vec3 near_wall[4] = {{0, -5, 0}, {0, 5, 0}, {0, 5, 3}, {0, -5, 3}};
    Vec3 far_wall[4] = {{4, -9, -3}, {4, 9, -3}, {4, 9, 6}, {4, -9, 6}};
    soup_add(&arena, &soup, near_wall, 4);
    soup_add(&arena, &soup, far_wall, 4);
    Scene scene = {soup.polygons, soup.vertices, NULL, 2};
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        void *prepared = HIDDEN_METHODS[m]->begin(&scene, &arena, &error);
        cr_assert(prepared, "%s", error.text);
        double distance[] = {1e-2, 1e-3, 1e-4, 1e-5};
        for (int k = 0; k < 4; k++) {
            Camera camera = camera_look(vec3(-distance[k], 0.3, 1.6), 0.1, 0.05, 1.2, 64, 48);
            ItemBuffer items = item_buffer_new(&arena, 64, 48);
            cr_assert(HIDDEN_METHODS[m]->draw(prepared, &camera, &items, &error));
            for (int p = 0; p < 64 * 48; p++) {
                cr_assert(items.item[p] == 0, "%s at %g m: pixel %d sees %d", HIDDEN_METHODS[m]->name,
                          distance[k], p, items.item[p]);
            }
        }
        if (HIDDEN_METHODS[m]->end) HIDDEN_METHODS[m]->end(prepared);
    }
    arena_free(&arena);
}
