// test_mirrors.c - mirrors as portals: the item buffer through a mirror against rays that are reflected at it, the drawn picture in a
// mirror against direct looks along reflected rays, and which polygons count as mirrors.
#include <criterion/criterion.h>

#include "engine/walk/verify.h"
#include "tests/draw/renderer_fixture.h"
#include "tests/maps/plan_fixture.h"
#include "tests/support/oracles/hidden_excuse.h"
#include "tests/support/support.h"
#include "tests/walk/walk_fixture.h"
#include "visibility/rays/ray_surfaces.h"

// Pixels each way of the views; every pixel in so many of a mirror's is held against rays.
enum { VIEW_WIDTH = 240, VIEW_HEIGHT = 135, PIXEL_STEP = 3 };

// Where OpenGL may differ from rays: it rounds corners to a 256th of a pixel, and depths to floats.
static const HiddenSlack FLOAT = {1 / 128.0, 1e-5, 1e-5, false};

typedef struct Looked {
    Walked walked;
    WalkVerify *verify;
    long pixels, excused;
} Looked;

// A ray of the camera, reflected at the plane of the mirror.
static Ray reflect_ray(const Camera *camera, Plane plane, double x, double y) {
    Vec3 ray = camera_ray(camera, x, y);
    double t = -plane_distance(plane, camera->eye) / vec3_dot(plane.n, ray);
    return (Ray){vec3_add(camera->eye, vec3_scale(ray, t)),
                 vec3_sub(ray, vec3_scale(plane.n, 2 * vec3_dot(plane.n, ray))), -1e-9, INFINITY};
}

static Plane posed_plane(const Looked *l, int polygon) {
    const Polygon *p = &l->walked.graph.polygons[polygon];
    return plane_of_polygon(walk_verify_vertices(l->verify) + p->first_vertex, p->vertex_count);
}

// The pixels of one mirror of the last frame.
static void expect_reflected(Looked *l, const Camera *camera, const float *doors, const MirrorView *view,
                             const int32_t *items) {
    const CellGraph *graph = &l->walked.graph;
    Arena scratch = {0};
    int *list = ARENA_ARRAY(&scratch, int, graph->polygon_count + 1), count = 0;
    int all = walk_opaque_polygons(graph, doors, &view->camera.eye, list);
    for (int i = 0; i < all; i++) {
        bool own = false;
        for (int k = 0; k < view->polygon_count; k++) own = own || view->polygons[k] == list[i];
        if (!own) list[count++] = list[i];
    }
    RaySource source = {
        &l->walked.building, graph->polygons, walk_verify_vertices(l->verify), list, NULL, count, 0};
    RaySurfaces surfaces = ray_surfaces_new(&source, &scratch);
    SurfaceTree tree = surface_tree_new(&surfaces, &scratch);
    Scene scene = {graph->polygons, walk_verify_vertices(l->verify), list, count};
    HiddenJudge *judge = hidden_judge_new(&scene, &scratch);
    Plane plane = posed_plane(l, view->polygons[0]);
    for (int p = 0; p < VIEW_WIDTH * VIEW_HEIGHT; p += PIXEL_STEP) {
        int x = p % VIEW_WIDTH, y = p / VIEW_WIDTH;
        if (items[p] < 0) continue;
        Ray ray = reflect_ray(camera, plane, x + 0.5, y + 0.5);
        // The tree numbers the polygons by their place in the list.
        int hit = surface_tree_first(&tree, &ray).item, want = hit < 0 ? -1 : list[hit];
        l->pixels++;
        if (want == items[p]) continue;
        cr_assert_neq(hidden_excuse(judge, &view->camera, x, y, want, items[p], FLOAT), EXCUSE_NONE,
                      "pixel %d, %d of eye %.9g, %.9g, %.9g: rays see polygon %d, the item buffer %d", x, y,
                      camera->eye.x, camera->eye.y, camera->eye.z, want, items[p]);
        l->excused++;
    }
    arena_free(&scratch);
}

// Random views that see mirrors: nothing is missing culled, and the item buffer through each mirror is what rays see.
static void expect_mirrors(const char *path, uint64_t seed, int views) {
    Looked l = {0};
    Error error;
    walk_check_open_building(&l.walked, path);
    l.verify = walk_verify_new(&l.walked.graph, &l.walked.forest, &l.walked.arena, &error);
    cr_assert(l.verify, "%s", error.text);
    Random random = {seed};
    RandomView view = {.door_open = l.walked.doors};
    for (int seen = 0; seen < views;) {
        VerifyFrame frame;
        if (!walk_random_view(&l.walked.graph, &random, VIEW_WIDTH, VIEW_HEIGHT, &view)) continue;
        cr_assert(
            walk_verify_frame(l.verify, &view.camera, view.cell, view.door_open, CULL_STAB, &frame, &error),
            "%s", error.text);
        if (frame.mirror_pixels == 0) continue;
        cr_assert(frame.missing_polygons == 0 && frame.mismatched_pixels == 0,
                  "view %d (%s): %d polygons missing (one is %d), %d pixels differ; eye %.9g, %.9g, %.9g",
                  seen, view.kind, frame.missing_polygons, frame.missing, frame.mismatched_pixels,
                  view.camera.eye.x, view.camera.eye.y, view.camera.eye.z);
        const MirrorView *mirrors;
        int count = walk_verify_mirrors(l.verify, &mirrors);
        for (int i = 0; i < count; i++)
            expect_reflected(&l, &view.camera, view.door_open, &mirrors[i],
                             walk_verify_mirror_items(l.verify, i));
        seen++;
    }
    cr_assert_gt(l.pixels, 100 * views);
    // Edges are thin.
    cr_assert_lt(l.excused, l.pixels / 100, "%ld of %ld pixels needed an excuse", l.excused, l.pixels);
    walk_verify_free(l.verify);
    arena_free(&l.walked.arena);
}

// 500 views in all: doors open and closed at random, mirrors on leaves among them, eyes within a millimetre of portals and corners.
Test(mirrors, equal_rays_in_the_school, .timeout = 600) {
    expect_mirrors("maps/buildings/mirrors.plan", 1, support_count(350, 5000));
}

Test(mirrors, equal_rays_in_the_house, .timeout = 600) {
    expect_mirrors("build/maps/house.plan", 2, support_count(150, 2000));
}

// The camera stands in a doorway of the house, and its image two micrometres from a wall that passes behind the mirror. To floats that
// wall reaches through the image's near plane.
Test(mirrors, the_image_of_the_eye_may_be_in_a_wall) {
    Walked walked = {0};
    Error error;
    walk_check_open_building(&walked, "build/maps/house.plan");
    WalkVerify *verify = walk_verify_new(&walked.graph, &walked.forest, &walked.arena, &error);
    cr_assert(verify, "%s", error.text);
    Vec3 eye = {8.2 - 2e-6, 1.04693183, 3.28190318};
    Camera camera = camera_look(eye, 1.7226, -0.1315, 2, 640, 360);
    for (int i = 0; i < walked.building.opening_count; i++) walked.doors[i] = 1;
    VerifyFrame frame;
    cr_assert(walk_verify_frame(verify, &camera, vis_locate(&walked.graph, eye, -1), walked.doors, CULL_STAB,
                                &frame, &error),
              "%s", error.text);
    cr_assert_gt(frame.mirror_pixels, 1000);
    cr_assert(frame.missing_polygons == 0 && frame.mismatched_pixels == 0,
              "%d polygons missing, %d pixels differ", frame.missing_polygons, frame.mismatched_pixels);
    walk_verify_free(verify);
    arena_free(&walked.arena);
}

// ---- the drawn picture

static const uint8_t *pixel_of(const uint8_t *picture, int x, int y) { return picture + 3 * (y * WIDTH + x); }

// Does the picture have one colour around the pixel?
static bool is_even(const uint8_t *picture, int x, int y) {
    for (int j = y - 1; j <= y + 1; j++) {
        for (int i = x - 1; i <= x + 1; i++) {
            for (int c = 0; c < 3; c++)
                if (abs(pixel_of(picture, i, j)[c] - pixel_of(picture, x, y)[c]) > 2) return false;
        }
    }
    return true;
}

// A camera that looks from a point along a direction.
static Camera look_along(Vec3 eye, Vec3 direction) {
    Vec3 d = vec3_normalize(direction);
    return camera_look(eye, atan2(d.y, d.x), asin(d.z), 0.3, WIDTH, HEIGHT);
}

// Compares the picture `shown`, in which the mirror alone is drawn, with looks from the mirror. Returns the number of pixels compared.
static int compare_mirror(Stage *s, const Camera *camera, const MirrorView *m, const uint8_t *plain,
                          const uint8_t *shown) {
    const Polygon *polygon = &s->graph.polygons[m->polygons[0]];
    Plane plane = plane_of_polygon(vis_posed(&s->graph, NULL, &s->arena) + polygon->first_vertex,
                                   polygon->vertex_count);
    double share = (double)m->share;
    int compared = 0;
    for (int i = 0; i < (m->right - m->left - 4) * (m->bottom - m->top - 4); i += 7) {
        int x = m->left + 2 + i % (m->right - m->left - 4), y = m->top + 2 + i / (m->right - m->left - 4);
        // Where the mirror is hidden, nothing has changed.
        if (memcmp(pixel_of(plain, x, y), pixel_of(shown, x, y), 3) == 0) continue;
        Ray ray = reflect_ray(camera, plane, x + 0.5, y + 0.5);
        Camera direct = look_along(vec3_add(ray.origin, vec3_scale(plane.n, 1e-3)), ray.direction);
        if (vis_locate(&s->graph, direct.eye, -1) < 0 || !is_even(plain, x, y) || !is_even(shown, x, y))
            continue;
        const uint8_t *there = renderer_check_picture(s, &direct, CULL_STAB, WALK_FAST);
        if (!is_even(there, WIDTH / 2, HEIGHT / 2)) continue;
        for (int c = 0; c < 3; c++) {
            double want = sqrt(share) * pixel_of(there, WIDTH / 2, HEIGHT / 2)[c] +
                          (1 - share) * pixel_of(plain, x, y)[c];
            cr_expect_float_eq(pixel_of(shown, x, y)[c], want, 4, "pixel %d, %d, channel %d: %d, not %g", x,
                               y, c, pixel_of(shown, x, y)[c], want);
        }
        compared++;
    }
    return compared;
}

// Proves that a mirror shows in each pixel what one sees from the mirror along the reflected ray, at the share that it reflects, over its
// own colour. In the fast look colours depend on the place alone, not on the direction from which it is seen. Tolerance: four
// roundings of colours to bytes, of places to pixels in an even field, and of the share.
Test(mirrors, show_what_is_seen_along_reflected_rays, .timeout = 120) {
    Stage s;
    renderer_check_open_stage(&s, "maps/buildings/mirrors.plan");
    Mirrors *mirrors = mirrors_new(&s.graph, &s.forest, &s.arena);
    cr_assert(mirrors);
    // On a wall, as a floor, in a frame and as walls, past no glass.
    static const double VIEWS[][5] = {
        {4.2, 6, 1.5, 80, -4}, {11.4, 0.6, 1.6, 160, -30}, {10.4, 1.2, 1.6, 80, -8}, {10.6, 4, 1.6, 140, 0}};
    for (int v = 0; v < 4; v++) {
        Vec3 from = vec3(VIEWS[v][0], VIEWS[v][1], VIEWS[v][2]);
        Camera camera =
            camera_look(from, VIEWS[v][3] * M_PI / 180, VIEWS[v][4] * M_PI / 180, 1.2, WIDTH, HEIGHT);
        Eye eye = walk_eye(&camera);
        VisResult seen = vis_query(s.query, &eye, vis_locate(&s.graph, camera.eye, -1), NULL, CULL_STAB);
        const uint8_t *plain = renderer_check_picture(&s, &camera, CULL_STAB, WALK_FAST);
        const MirrorView *views;
        int count = mirrors_look(mirrors, &camera, &seen, NULL, CULL_STAB, &views), compared = 0;
        for (int i = 0; i < count; i++) {
            walk_renderer_mirrors(s.renderer, &views[i], 1);
            const uint8_t *shown = renderer_check_picture(&s, &camera, CULL_STAB, WALK_FAST);
            walk_renderer_mirrors(s.renderer, NULL, 0);
            compared += compare_mirror(&s, &camera, &views[i], plain, shown);
        }
        cr_assert_gt(compared, 20, "view %d: %d pixels of %d mirrors", v, compared, count);
    }
    mirrors_free(mirrors);
    renderer_check_close_stage(&s);
}

// ---- which polygons are mirrors

// Proves that facets, edges of sheets, slight gloss and glass are no mirrors, that polygons in one plane are one mirror, and that its
// back shows nothing.
Test(mirrors, are_flat_and_large) {
    static const char PLAN[] = "plan 1\n"
                               "material silver reflectance 0.04 mirror 0.88\n"
                               "material gloss  reflectance 0.3 mirror 0.05\n"
                               "material glass  reflectance 0.04 mirror 0.5 alpha 0.2\n"
                               "storey ground floor 0 height 2.6\n"
                               "room room 0,0 6,0 6,6 0,6 walls gloss wall 0.2\n"
                               "model things\n"
                               "  cylinder silver 0 0.5 0,0 radius 0.02 sides 24\n"
                               "  box 1,0.3,0 1.1,0.4,0.1 silver\n"
                               "  box -1,-1,0 -0.9,-0.9,2 glass\n"
                               "  poly silver 2,0.5,0 2.03,0.5,0 2.03,0.5,2 2,0.5,2\n"
                               "  poly silver 2,0,0 2.5,0,0 2.5,0,1 2,0,1\n"
                               "  poly silver 2.6,0,0 3,0,0 3,0,1 2.6,0,1\n"
                               "end\n"
                               "place things 2,3\n";
    Arena arena = {0};
    Building b = {0};
    CellGraph graph;
    StabForest forest;
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(plan_read_text(&arena, PLAN, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&graph, &options, NULL, &arena, &forest));
    Mirrors *mirrors = mirrors_new(&graph, &forest, &arena);
    cr_assert(mirrors);
    VisQuery *query = vis_query_new(&graph, &forest, &arena);
    for (int side = -1; side <= 1; side += 2) {
        // The two polygons face -y.
        Camera camera = camera_look(vec3(4.5, 3 + 2 * side, 0.6), -side * M_PI / 2, 0, 1.2, 100, 100);
        Eye eye = walk_eye(&camera);
        VisResult seen = vis_query(query, &eye, vis_locate(&graph, camera.eye, -1), NULL, CULL_STAB);
        const MirrorView *views;
        int count = mirrors_look(mirrors, &camera, &seen, NULL, CULL_STAB, &views);
        cr_assert_eq(count, side < 0 ? 1 : 0);
        if (count > 0) cr_assert_eq(views[0].polygon_count, 2);
    }
    mirrors_free(mirrors);
    arena_free(&arena);
}
