// test_hidden.c - the item-buffer methods against each other, and against Embree.
#include <criterion/criterion.h>

#include "tests/support/oracles/hidden_scenes.h"
#include "tests/support/oracles/ray_scene.h"
#include "visibility/hidden/hidden.h"

#define PI 3.14159265358979323846

// Each soup twice: at the origin and 1,000 km off, where a double still holds 1e-10 m.
static Vec3 place(int trial) { return trial % 2 ? vec3(8e5, -6e5, 100) : vec3(0, 0, 0); }

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
    cr_assert(strcmp(hidden_find("raycast")->name, "raycast") == 0 && hidden_find("no such") == NULL);
}

// The hierarchy changes no pixel: items and depths are equal bit for bit to testing every polygon, copies and
// edge-on polygons among them; of copies the first in the list is seen, and edge-on ones never are.
Test(hidden, hierarchy_equals_brute_force) {
    uint64_t seed = 1;
    Random random = {seed};
    for (int trial = 0; trial < 60; trial++) {
        Arena arena = {0};
        Error error;
        Vec3 eye = place(trial);
        HiddenSoup soup = hidden_soup_plain(&arena, &random, eye, 1 << random_index(&random, 10));
        int *list = ARENA_ARRAY(&arena, int, soup.polygon_count);
        // Backwards: the list's order decides, not the index.
        for (int i = 0; i < soup.polygon_count; i++) list[i] = soup.polygon_count - 1 - i;
        Scene scene = {soup.polygons, soup.vertices, trial % 3 ? list : NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena, &error);
        for (int i = 0; i < 2000; i++) {
            Vec3 ray = i % 5 == 0 ? vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 % 3 - 1) : hidden_direction(&random);
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
        Error error;
        HiddenSoup soup = {0};
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
                    hidden_soup_add(&arena, &soup, p, n);
                }
            }
        }
        Scene scene = {soup.polygons, soup.vertices, NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena, &error);
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

// About 100 roundings of a float, for a plane seen at a grazing angle.
static float tie_of(float z, float seen_z) { return 1e-5f * fminf(z, seen_z); }

// May a rasteriser see this item at a pixel instead? It may see all that lies within a 128th of a pixel (it rounds vertices to a 256th).
static bool excused(const RayScene *rays, const Camera *camera, int i, int j, int item, float z,
                    float seen_z) {
    float tie = tie_of(z, seen_z);
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
    int pixels, ties, excused, unexcused, depth;
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
            } else if (fabsf(want->depth[p] - got->depth[p]) <= tie_of(want->depth[p], got->depth[p])) {
                d.ties++;
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

static void look(const RayScene *rays, const Camera *camera, ItemBuffer *out) {
    for (int p = 0; p < camera->width * camera->height; p++) {
        Vec3 ray = camera_ray(camera, p % camera->width + 0.5, p / camera->width + 0.5);
        out->item[p] = ray_scene_nearest(rays, camera->eye, ray, &out->depth[p]);
    }
}

// At most one pixel in 100 needs an excuse: edges are many in a soup of 300, but thin. `list`: of ties it keeps the order.
static void outside_method(const char *name, uint64_t seed, bool list) {
    const HiddenMethod *method = hidden_find(name);
    Random random = {seed};
    for (int trial = 0; trial < 12; trial++) {
        Arena arena = {0};
        Error error;
        Vec3 eye = place(trial);
        HiddenSoup soup = hidden_soup_plain(&arena, &random, eye, 300);
        Scene scene = {soup.polygons, soup.vertices, NULL, soup.polygon_count};
        RayScene *rays = ray_scene_new(&scene, &arena, &error);
        void *prepared = method->begin(&scene, &arena, &error);
        cr_assert(prepared, "%s", error.text);
        for (int k = 0; k < 2; k++) {
            Camera camera = hidden_camera(&random, eye, 80 + 20 * k, 60);
            ItemBuffer want = item_buffer_new(&arena, camera.width, camera.height);
            ItemBuffer got = item_buffer_new(&arena, camera.width, camera.height);
            look(rays, &camera, &want);
            cr_assert(hidden_draw(method, prepared, &camera, &got, NULL, &error), "%s", error.text);
            Difference d = compare(&scene, rays, &camera, &want, &got);
            cr_assert(
                d.unexcused == 0 && d.depth == 0 && (d.excused + (list ? d.ties : 0)) * 100 <= d.pixels,
                "%s, seed %lu, trial %d: %d of %d pixels differ, %d of them excused, %d more tie; %d depths",
                name, (unsigned long)seed, trial, d.unexcused + d.excused, d.pixels, d.excused, d.ties,
                d.depth);
        }
        if (method->end) method->end(prepared);
        arena_free(&arena);
    }
}

// The item buffer by OpenGL equals the ray caster's off edges and ties, on soups near and far from the origin.
Test(hidden, osmesa_equals_rays, .timeout = 60) { outside_method("osmesa", 3, true); }

// Embree, which shares no code with us, sees what the ray caster sees, but for float rounding at edges, and ties, of which it
// takes any.
Test(hidden, embree_equals_rays, .timeout = 60) { outside_method("embree", 4, false); }

// An eye that almost touches a wall, or lies exactly in the corner line of two, does not look through them.
Test(hidden, near_walls_stay_closed) {
    Arena arena = {0};
    Error error;
    HiddenSoup soup = {0};
    Vec3 near_wall[4] = {{0, -5, 0}, {0, 5, 0}, {0, 5, 3}, {0, -5, 3}};
    Vec3 far_wall[4] = {{4, -9, -3}, {4, 9, -3}, {4, 9, 6}, {4, -9, 6}};
    hidden_soup_add(&arena, &soup, near_wall, 4);
    hidden_soup_add(&arena, &soup, far_wall, 4);
    Scene scene = {soup.polygons, soup.vertices, NULL, 2};
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        void *prepared = HIDDEN_METHODS[m]->begin(&scene, &arena, &error);
        cr_assert(prepared, "%s", error.text);
        double distance[] = {1e-2, 1e-3, 1e-4, 1e-5};
        for (int k = 0; k < 4; k++) {
            Camera camera = camera_look(vec3(-distance[k], 0.3, 1.6), 0.1, 0.05, 1.2, 64, 48);
            ItemBuffer items = item_buffer_new(&arena, 64, 48);
            cr_assert(hidden_draw(HIDDEN_METHODS[m], prepared, &camera, &items, NULL, &error));
            for (int p = 0; p < 64 * 48; p++) {
                cr_assert(items.item[p] == 0, "%s at %g m: pixel %d sees %d", HIDDEN_METHODS[m]->name,
                          distance[k], p, items.item[p]);
            }
        }
        if (HIDDEN_METHODS[m]->end) HIDDEN_METHODS[m]->end(prepared);
    }
    arena_free(&arena);
}
