// test_curved_scene.c - hidden-surface methods draw curved shapes by subdividing them for the view.
#include <criterion/criterion.h>

#include "tests/support/curved_fixture.h"
#include "visibility/hidden/curved_scene.h"

enum { WIDTH = 320, HEIGHT = 200 };
static const char SHAPES[] =
    "sphere red -1,0,0.5 radius 0.5\n"
    "cone red 0,0,0 0,0,1.2 radius 0.4\n"
    "lathe red 1,0 profile 0.1,0 0.5,0.1 0.4,0.5 0.2,0.6 0.1,0.65 0.2,0.8 0.3,0.9\n"
    "metaballs red threshold 0.5\nball 0.4,-0.9,0.3 radius 0.5\nball 0.8,-0.8,0.5 radius 0.4\n"
    "cylinder red 0 0.7 -0.6,-0.9 radius 0.25 round\n"
    "box -2,1,0 2,1.1,1 red\nbox -0.2,-0.7,0 0.2,-0.6,0.4 red\n";

static Camera camera_at(double distance) {
    return camera_look(vec3(4, 2 - distance, 1.1), M_PI / 2, -0.1, 1.0, WIDTH, HEIGHT);
}

// Draws: under each pixel the shape, or -1 - the polygon where there is no shape.
static void draw(const char *method, const CurvedScene *scene, const Camera *camera, int *seen,
                 float *depth) {
    Arena arena = {0};
    Error error = {""};
    const HiddenMethod *m = hidden_find(method);
    void *prepared = m->begin(&scene->scene, &arena, &error);
    cr_assert(prepared, "%s: %s", method, error.text);
    ItemBuffer out = item_buffer_new(&arena, WIDTH, HEIGHT);
    cr_assert(hidden_draw(m, prepared, camera, &out, NULL, &error), "%s: %s", method, error.text);
    for (int p = 0; p < WIDTH * HEIGHT; p++) {
        int item = out.item[p];
        seen[p] = item >= 0 && scene->shape[item] >= 0 ? scene->shape[item] : -2 - item;
        depth[p] = out.depth[p];
    }
    if (m->end) m->end(prepared);
    arena_free(&arena);
}

static bool is_edge(const int *seen, int p) {
    int x = p % WIDTH, y = p / WIDTH;
    for (int k = 0; k < 9; k++) {
        int i = x + k % 3 - 1, j = y + k / 3 - 1;
        if (i >= 0 && j >= 0 && i < WIDTH && j < HEIGHT && seen[j * WIDTH + i] != seen[p]) return true;
    }
    return false;
}

typedef struct Look {
    int seen[WIDTH * HEIGHT];
    float depth[WIDTH * HEIGHT];
} Look;

static Look *look(Arena *arena, const Building *b, const Camera *camera, double pixels, const char *method) {
    Scene given = {b->polygons, b->vertices, NULL, b->polygon_count};
    CurvedScene scene;
    curved_scene_new(b, &given, b->polygon_count, b->vertex_count, camera, pixels, arena, &scene);
    // The finest grid of metaballs leaves more than a fortieth of a pixel.
    double most = fmax(pixels * 1.0001, 0.6 * CURVED_SCENE_PIXELS);
    cr_assert_leq(scene.largest_off, most, "%g of %g pixels", scene.largest_off, pixels);
    Look *out = ARENA_ARRAY(arena, Look, 1);
    draw(method, &scene, camera, out->seen, out->depth);
    return out;
}

// Proves that scan lines and the depth buffer draw shapes subdivided for the view as a tessellation up to ten times as fine does: what
// differs lies at the edges, at most every 50th pixel of them (of those on either side of an edge that is inset by up to a
// quarter of a pixel, mostly less), and depths differ by no more than some pixels; and that both draw the very same.
Test(curved_scene, edges_agree_with_a_fine_tessellation) {
    static const double DISTANCES[] = {1.9, 4, 12};
    for (int k = 0; k < 3; k++) {
        Arena arena = {0};
        Building b;
        curved_read_model(&arena, SHAPES, "4,2", &b);
        Camera camera = camera_at(DISTANCES[k]);
        const Look *scanline = look(&arena, &b, &camera, CURVED_SCENE_PIXELS, "scanline"),
                   *zbuffer = look(&arena, &b, &camera, CURVED_SCENE_PIXELS, "zbuffer"),
                   *fine = look(&arena, &b, &camera, CURVED_SCENE_PIXELS / 10, "zbuffer");
        double pixel = 2 * camera.tan_x / WIDTH;
        int edges = 0, other = 0, curved = 0;
        for (int p = 0; p < WIDTH * HEIGHT; p++) {
            cr_assert_eq(scanline->seen[p], zbuffer->seen[p], "pixel %d of distance %g", p, DISTANCES[k]);
            bool edge = is_edge(fine->seen, p);
            edges += edge;
            curved += fine->seen[p] >= 0;
            if (scanline->seen[p] != fine->seen[p]) {
                cr_assert(edge, "pixel %d, %d lies at no edge", p % WIDTH, p / WIDTH);
                other++;
            } else if (fine->seen[p] >= 0 && !edge) {
                // Seen at a grazing angle a quarter of a pixel off is more along the view.
                cr_assert_float_eq((double)scanline->depth[p], (double)fine->depth[p],
                                   16 * pixel * (double)fine->depth[p]);
            }
        }
        cr_expect_gt(curved, 200, "the shapes are seen: %d pixels", curved);
        cr_expect_lt(50 * other, edges, "distance %g: %d of %d edge pixels differ", DISTANCES[k], other,
                     edges);
        arena_free(&arena);
    }
}

// Proves that the subdivision follows the view: more polygons from near, few from far, none for what is behind the eye; and that
// all others stay where they were.
Test(curved_scene, follows_the_view) {
    Arena arena = {0};
    Building b;
    curved_read_model(&arena, SHAPES, "4,2", &b);
    Scene given = {b.polygons, b.vertices, NULL, b.polygon_count};
    int last = 1 << 30;
    for (double distance = 2; distance < 40; distance *= 2) {
        Camera camera = camera_at(distance);
        CurvedScene scene;
        curved_scene_new(&b, &given, b.polygon_count, b.vertex_count, &camera, 0.25, &arena, &scene);
        cr_expect(scene.subdivided > 0 && scene.subdivided < last, "at %g: %d, before %d", distance,
                  scene.subdivided, last);
        last = scene.subdivided;
        for (int i = 0; i < scene.scene.count; i++) {
            int item = scene.scene.list[i];
            cr_assert(item >= b.polygon_count ? scene.shape[item] >= 0 : scene.shape[item] < 0);
        }
    }
    Camera back = camera_look(vec3(4, -3, 1.1), -M_PI / 2, 0, 1.0, WIDTH, HEIGHT);
    CurvedScene scene;
    curved_scene_new(&b, &given, b.polygon_count, b.vertex_count, &back, 0.25, &arena, &scene);
    cr_expect_eq(scene.subdivided, 0);
    cr_expect_eq(scene.scene.count, b.polygon_count);
    arena_free(&arena);
}
