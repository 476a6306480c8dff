// test_walk_store.c - a building that is held in part looks like one that is held whole.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/core/random.h"
#include "engine/draw/view.h"
#include "tests/draw/renderer_fixture.h"

// So small that a building of some thousand vertices fills and empties the halves over and over.
static const WalkStoreLimits TIGHT = {0, 3000, 80};

static void look_anywhere(Stage *s, Random *random, Camera *out) {
    int cell = random_index(random, s->graph.cell_count);
    Box box = s->graph.cells[cell].box;
    Vec3 share = vec3(random_unit(random), random_unit(random), random_unit(random));
    Vec3 eye =
        vec3(box.min.x + share.x * (box.max.x - box.min.x), box.min.y + share.y * (box.max.y - box.min.y),
             box.min.z + share.z * (box.max.z - box.min.z));
    *out = camera_look(eye, 2 * M_PI * random_unit(random), random_unit(random) - 0.5, 1.2, WIDTH, HEIGHT);
}

static int greatest_difference(const uint8_t *a, const uint8_t *b) {
    int most = 0;
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        if (abs(a[i] - b[i]) > most) most = abs(a[i] - b[i]);
    return most;
}

// Draws the same views, with doors that move, from both; objects ahead are made only where asked for.
static void compare(const char *file, bool ahead, int views) {
    Stage s;
    Error error;
    Random random = {7};
    renderer_check_open_stage(&s, file);
    WalkRenderer *whole = s.renderer, *part = walk_renderer_new_limited(&s.graph, &TIGHT, &s.arena, &error);
    cr_assert(part, "%s", error.text);
    cr_assert_eq(walk_renderer_held(part).vertices, 0, "something is held before anything was drawn");
    for (int i = 0; i < views; i++) {
        Camera camera;
        look_anywhere(&s, &random, &camera);
        for (int k = 0; k < s.building.opening_count; k++)
            if (random_unit(&random) < 0.2) s.doors[k] = (float)random_unit(&random);
        WalkLook look = (WalkLook)(i % 2);
        s.renderer = whole;
        const uint8_t *expected = renderer_check_picture(&s, &camera, CULL_STAB, look);
        s.renderer = part;
        const uint8_t *picture = renderer_check_picture(&s, &camera, CULL_STAB, look);
        if (ahead) walk_renderer_ahead(part, &s.forest, vis_locate(&s.graph, camera.eye, -1));
        // Texels lie elsewhere in the texture. OpenGL takes their places by 256ths of a texel, and neighbours in a corner may differ by
        // all brightness: a step of the screen each way, which the picture of a bright texture doubles.
        cr_assert_leq(greatest_difference(expected, picture), look == WALK_FAST ? 4 : 0,
                      "%s: view %d differs by %d", file, i, greatest_difference(expected, picture));
    }
    WalkStoreFigures held = walk_renderer_held(part), all = walk_renderer_held(whole);
    cr_assert_geq(held.emptied, 2, "the halves were emptied %ld times only", held.emptied);
    cr_assert_lt(held.vertices, all.vertices, "%ld of %ld vertices are held", held.vertices, all.vertices);
    walk_renderer_free(part);
    s.renderer = whole;
    renderer_check_close_stage(&s);
}

// Proves that what comes and goes leaves no trace: views of random places with doors that move are those of a renderer that
// holds everything, whether objects are made ahead or when they are drawn. Pictures and mirrors are in one of the homes.
Test(walk_store, parts_look_like_the_whole, .timeout = 120) {
    compare("build/maps/house.plan", false, 60);
    compare("build/maps/house.plan", true, 60);
    compare("build/maps/villa.sh3d", false, 20);
    compare("build/maps/villa.sh3d", true, 20);
}

// Proves that a frame that needs more than there is room for gets it: the halves grow, and the picture is right.
Test(walk_store, grows_where_one_frame_needs_it, .timeout = 120) {
    Stage s;
    Error error;
    WalkStoreLimits tiny = {0, 40, 4};
    renderer_check_open_stage(&s, "build/maps/office-plain.plan");
    WalkRenderer *whole = s.renderer, *part = walk_renderer_new_limited(&s.graph, &tiny, &s.arena, &error);
    cr_assert(part, "%s", error.text);
    const uint8_t *expected = renderer_check_picture(&s, &s.camera, CULL_NONE, WALK_FINE);
    s.renderer = part;
    const uint8_t *picture = renderer_check_picture(&s, &s.camera, CULL_NONE, WALK_FINE);
    cr_assert_eq(renderer_check_differing(expected, picture, WIDTH * HEIGHT), 0);
    cr_assert_gt(walk_renderer_held(part).grown, 3);
    cr_assert_eq(walk_renderer_held(part).vertices, walk_renderer_held(whole).vertices);
    walk_renderer_free(part);
    s.renderer = whole;
    renderer_check_close_stage(&s);
}

// Proves that what was made ahead is there: after enough frames in one place everything that may be seen from its cell is held, so
// that a look around makes nothing.
Test(walk_store, a_look_around_finds_it_there, .timeout = 120) {
    Stage s;
    Error error;
    WalkStoreLimits limits = {0, 1 << 16, 512};
    renderer_check_open_stage(&s, "build/maps/office-plain.plan");
    WalkRenderer *whole = s.renderer, *part = walk_renderer_new_limited(&s.graph, &limits, &s.arena, &error);
    cr_assert(part, "%s", error.text);
    s.renderer = part;
    int cell = vis_locate(&s.graph, s.camera.eye, -1);
    renderer_check_picture(&s, &s.camera, CULL_STAB, WALK_FAST);
    for (int i = 0; i < 200; i++) walk_renderer_ahead(part, &s.forest, cell);
    long made = walk_renderer_held(part).vertices;
    for (int i = 0; i < 16; i++) {
        Camera camera = camera_look(s.camera.eye, i * M_PI / 8, 0, 1.2, WIDTH, HEIGHT);
        renderer_check_picture(&s, &camera, CULL_STAB, WALK_FAST);
    }
    cr_assert_eq(walk_renderer_held(part).vertices, made, "a look around made %ld vertices",
                 walk_renderer_held(part).vertices - made);
    walk_renderer_free(part);
    s.renderer = whole;
    renderer_check_close_stage(&s);
}
