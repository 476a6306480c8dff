// test_hidden_input.c - what hidden-surface methods do with input that is none: a clear error, or a picture that is defined.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "tests/support/oracles/hidden_scenes.h"
#include "tests/support/support.h"

enum { WIDE = 64, HIGH = 48 };

// Looks along +x from the origin.
static Camera ahead(int width, int height) { return camera_look(vec3(0, 0, 0), 0, 0, 1.2, width, height); }

static ItemBuffer draw(const HiddenMethod *method, const Scene *scene, const Camera *camera, Arena *arena,
                       HiddenWork *work) {
    Error error;
    ItemBuffer items = item_buffer_new(arena, camera->width, camera->height);
    void *prepared = method->begin(scene, arena, &error);
    cr_assert(prepared, "%s: %s", method->name, error.text);
    cr_assert(hidden_draw(method, prepared, camera, &items, work, &error), "%s: %s", method->name,
              error.text);
    if (method->end) method->end(prepared);
    return items;
}

static int count_of(const ItemBuffer *items, int item) {
    int count = 0;
    for (int p = 0; p < items->width * items->height; p++) count += items->item[p] == item;
    return count;
}

static Scene scene_of(const HiddenSoup *soup) {
    return (Scene){soup->polygons, soup->vertices, NULL, soup->polygon_count};
}

// No polygons, and polygons without area: every method sees nothing, at every depth.
Test(hidden_input, nothing_to_see, .timeout = 60) {
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        Arena arena = {0};
        HiddenSoup soup = {0};
        const Vec3 point[3] = {{3, 0, 0}, {3, 0, 0}, {3, 0, 0}};
        const Vec3 line[4] = {{3, -1, 0}, {3, 0, 0}, {3, 1, 0}, {3, 0, 0}};
        for (int k = 0; k < 2; k++) {
            if (k) hidden_soup_add(&arena, &soup, point, 3);
            if (k) hidden_soup_add(&arena, &soup, line, 4);
            if (k) hidden_soup_add(&arena, &soup, line, 2);
            Scene scene = scene_of(&soup);
            Camera camera = ahead(WIDE, HIGH);
            ItemBuffer items = draw(HIDDEN_METHODS[m], &scene, &camera, &arena, NULL);
            cr_assert_eq(count_of(&items, -1), WIDE * HIGH, "%s sees something", HIDDEN_METHODS[m]->name);
            for (int p = 0; p < WIDE * HIGH; p++) cr_assert(isinf(items.depth[p]));
        }
        arena_free(&arena);
    }
}

// Coordinates that are no numbers or beyond all buildings are refused with the polygon's number.
Test(hidden_input, no_numbers, .timeout = 60) {
    const double bad[] = {NAN, INFINITY, -INFINITY, 2e8};
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        for (int k = 0; k < 4; k++) {
            Arena arena = {0};
            Error error = {""};
            HiddenSoup soup = {0};
            const Vec3 good[3] = {{3, -1, 0}, {3, 1, 0}, {3, 0, 1}};
            Vec3 wrong[3] = {{3, -1, 0}, {3, 1, 0}, {3, 0, bad[k]}};
            hidden_soup_add(&arena, &soup, good, 3);
            hidden_soup_add(&arena, &soup, wrong, 3);
            Scene scene = scene_of(&soup);
            cr_assert_null(HIDDEN_METHODS[m]->begin(&scene, &arena, &error));
            cr_assert(strstr(error.text, "polygon 1: corner 2"), "%s says `%s`", HIDDEN_METHODS[m]->name,
                      error.text);
            arena_free(&arena);
        }
    }
}

// A camera that is none, and pictures of no size or too large, are refused; nothing is written.
Test(hidden_input, no_camera) {
    Arena arena = {0};
    Error error = {""};
    HiddenSoup soup = {0};
    Scene scene = scene_of(&soup);
    const HiddenMethod *method = hidden_find("zbuffer");
    void *prepared = method->begin(&scene, &arena, &error);
    Camera camera[6];
    for (int k = 0; k < 6; k++) camera[k] = ahead(8, 8);
    camera[0].eye.x = NAN;
    camera[1].forward = vec3(0, 0, 0);
    camera[2].tan_x = 0;
    camera[3].tan_y = INFINITY;
    camera[4].width = 0;
    camera[5].height = HIDDEN_LARGEST + 1;
    for (int k = 0; k < 6; k++) {
        ItemBuffer none = {camera[k].width, camera[k].height, NULL, NULL};
        error.text[0] = 0;
        cr_assert_not(hidden_draw(method, prepared, &camera[k], &none, NULL, &error));
        cr_assert(strncmp(error.text, "zbuffer: ", 9) == 0, "camera %d: `%s`", k, error.text);
    }
    arena_free(&arena);
}

// A concave polygon is seen where it is, not where its hull is; one that is bent is seen without a gap; one that crosses itself
// gives the same picture by all exact methods.
Test(hidden_input, no_convex_polygons, .timeout = 60) {
    // An arrowhead with its notch on the left, seen from x = 0 with y to the left and z up.
    const Vec3 notched[4] = {{3, 1, -1}, {3, -1, 0}, {3, 1, 1}, {3, 0, 0}};
    const Vec3 bent[4] = {{3, -9, -9}, {4, 9, -9}, {3, 9, 9}, {4, -9, 9}};
    const Vec3 crossed[4] = {{3, -1, -1}, {3, 1, 1}, {3, 1, -1}, {3, -1, 2}};
    ItemBuffer first = {0};
    Arena keep = {0};
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        const HiddenMethod *method = HIDDEN_METHODS[m];
        Arena arena = {0};
        HiddenSoup soup = {0};
        hidden_soup_add(&arena, &soup, notched, 4);
        Scene scene = scene_of(&soup);
        // Rays through (1, 0.3, 0) and (1, -0.1, 0): into the notch, and into the head.
        Camera camera = ahead(200, 200);
        ItemBuffer items = draw(method, &scene, &camera, &arena, NULL);
        cr_assert_eq(items.item[100 * 200 + 70], -1, "%s fills a notch", method->name);
        cr_assert_eq(items.item[100 * 200 + 110], 0, "%s loses the head", method->name);

        soup = (HiddenSoup){0};
        hidden_soup_add(&arena, &soup, bent, 4);
        scene = scene_of(&soup);
        items = draw(method, &scene, &camera, &arena, NULL);
        cr_assert_eq(count_of(&items, 0), 200 * 200, "%s tears what is bent", method->name);

        soup = (HiddenSoup){0};
        hidden_soup_add(&arena, &soup, crossed, 4);
        scene = scene_of(&soup);
        items = draw(method, &scene, &camera, method->truth == HIDDEN_EXACT && !first.item ? &keep : &arena,
                     NULL);
        cr_assert_gt(count_of(&items, 0), 0);
        if (method->truth != HIDDEN_EXACT) continue;
        if (!first.item) first = items;
        cr_assert(memcmp(first.item, items.item, sizeof(int32_t) * 200 * 200) == 0, "%s", method->name);
        arena_free(&arena);
    }
    arena_free(&keep);
}

// A polygon of 1,000 corners is a disc, by every method; so is one of 33, a corner more than a facet holds.
Test(hidden_input, many_corners, .timeout = 60) {
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        for (int corners = 33; corners <= 1000; corners += 967) {
            Arena arena = {0};
            HiddenSoup soup = {0};
            Vec3 *v = ARENA_ARRAY(&arena, Vec3, corners);
            for (int i = 0; i < corners; i++)
                v[i] = vec3(2, cos(2 * M_PI * i / corners), sin(2 * M_PI * i / corners));
            hidden_soup_add(&arena, &soup, v, corners);
            Scene scene = scene_of(&soup);
            Camera camera = ahead(100, 100);
            ItemBuffer items = draw(HIDDEN_METHODS[m], &scene, &camera, &arena, NULL);
            for (int p = 0; p < 100 * 100; p++) {
                Vec3 ray = camera_ray(&camera, p % 100 + 0.5, p / 100 + 0.5);
                double radius = 2 * hypot(ray.y, ray.z);
                // Sides of 33 corners cut 0.5 % off.
                if (radius < 0.99) cr_assert_eq(items.item[p], 0, "%s", HIDDEN_METHODS[m]->name);
                if (radius > 1.01) cr_assert_eq(items.item[p], -1, "%s", HIDDEN_METHODS[m]->name);
            }
            arena_free(&arena);
        }
    }
}

// Pictures of a single pixel, row and column, and the widest and highest there are; at soak the largest, by our own methods
// (4 minutes).
Test(hidden_input, sizes, .timeout = 1800) {
    const int sizes[][2] = {{1, 1},
                            {1, 7},
                            {7, 1},
                            {3, 3},
                            {HIDDEN_LARGEST, 1},
                            {1, HIDDEN_LARGEST},
                            {HIDDEN_LARGEST, HIDDEN_LARGEST}};
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        int count = support_soak() && HIDDEN_METHODS[m]->truth == HIDDEN_EXACT ? 7 : 6;
        for (int k = 0; k < count; k++) {
            Arena arena = {0};
            HiddenSoup soup = {0};
            const Vec3 behind[4] = {{5, -99, -99}, {5, 99, -99}, {5, 99, 99}, {5, -99, 99}};
            const Vec3 before[4] = {{4, -99, -99}, {4, 99, -99}, {4, 99, 99}, {4, -99, 99}};
            hidden_soup_add(&arena, &soup, behind, 4);
            hidden_soup_add(&arena, &soup, before, 4);
            Scene scene = scene_of(&soup);
            Camera camera = ahead(sizes[k][0], sizes[k][1]);
            camera.tan_y = camera.tan_x = 0.7;
            ItemBuffer items = draw(HIDDEN_METHODS[m], &scene, &camera, &arena, NULL);
            size_t pixels = (size_t)items.width * (size_t)items.height;
            for (size_t p = 0; p < pixels; p++)
                cr_assert(items.item[p] == 1 && fabsf(items.depth[p] - 4) < 1e-5f, "%s at %d x %d: pixel %zu",
                          HIDDEN_METHODS[m]->name, items.width, items.height, p);
            arena_free(&arena);
        }
    }
}

// A camera inside a wall sees the wall from within; in its plane it sees past it.
Test(hidden_input, inside_a_wall, .timeout = 60) {
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        const HiddenMethod *method = HIDDEN_METHODS[m];
        Arena arena = {0};
        HiddenSoup soup = {0};
        for (int side = -1; side <= 1; side += 2) {
            const Vec3 face[4] = {
                {0.1 * side, -9, -9}, {0.1 * side, 9, -9}, {0.1 * side, 9, 9}, {0.1 * side, -9, 9}};
            hidden_soup_add(&arena, &soup, face, 4);
        }
        Scene scene = scene_of(&soup);
        Camera camera = ahead(WIDE, HIGH);
        ItemBuffer items = draw(method, &scene, &camera, &arena, NULL);
        cr_assert_eq(count_of(&items, 1), WIDE * HIGH, "%s", method->name);
        camera.eye.x = 0.1;
        items = draw(method, &scene, &camera, &arena, NULL);
        cr_assert_eq(count_of(&items, -1), WIDE * HIGH, "%s", method->name);
        arena_free(&arena);
    }
}

// Sorting by centroids fails as the lecture says: where a large polygon's centroid is nearer than a small one that
// lies behind it; the exact methods do not. And rings: cut, by those that cut.
Test(hidden_input, centroids_fail) {
    Arena arena = {0};
    HiddenSoup soup = {0};
    // A floor that runs from under the eye to far away, and a plate that stands beneath it, nearer than its centroid, hidden by it.
    const Vec3 wall[4] = {{1, -1, -1}, {1, 1, -1}, {21, 1, 1}, {21, -1, 1}};
    const Vec3 plate[4] = {{10, -0.5, -4}, {10, 0.5, -4}, {10, 0.5, -1}, {10, -0.5, -1}};
    hidden_soup_add(&arena, &soup, wall, 4);
    hidden_soup_add(&arena, &soup, plate, 4);
    Scene scene = scene_of(&soup);
    Camera camera = ahead(WIDE, HIGH);
    ItemBuffer right = draw(hidden_find("raycast"), &scene, &camera, &arena, NULL);
    for (int m = 0; HIDDEN_METHODS[m]; m++) {
        ItemBuffer items = draw(HIDDEN_METHODS[m], &scene, &camera, &arena, NULL);
        int wrong = 0;
        for (int p = 0; p < WIDE * HIGH; p++) wrong += items.item[p] != right.item[p];
        if (HIDDEN_METHODS[m]->truth == HIDDEN_EXACT) cr_assert_eq(wrong, 0, "%s", HIDDEN_METHODS[m]->name);
        if (HIDDEN_METHODS[m]->truth == HIDDEN_GUESS) cr_assert_gt(wrong, 0, "%s", HIDDEN_METHODS[m]->name);
    }
    arena_free(&arena);
}

// Rings of bars are cut by depth sort, where no plane of theirs cuts another, too, and nothing is left undecided.
Test(hidden_input, rings_are_cut, .timeout = 60) {
    Random random = {7};
    int cut = 0;
    for (int trial = 0; trial < 50; trial++) {
        Arena arena = {0};
        HiddenWork work;
        HiddenSoup soup = hidden_soup_new(&arena, &random, SCENE_RINGS, vec3(0, 0, 0), 3);
        Polygon first = soup.polygons[0];
        Vec3 at = vec3_lerp(soup.vertices[first.first_vertex], soup.vertices[first.first_vertex + 2], 0.5);
        Scene scene = scene_of(&soup);
        Camera camera =
            camera_look(vec3(0, 0, 0), atan2(at.y, at.x), atan2(at.z, hypot(at.x, at.y)), 2, WIDE, HIGH);
        draw(hidden_find("depth-sort"), &scene, &camera, &arena, &work);
        cr_assert_eq(work.undecided, 0);
        cut += work.splits > 0;
        arena_free(&arena);
    }
    cr_assert_gt(cut, 10, "only %d of 50 rings were cut", cut);
}
