// renderer_fixture.c - see the header.
#include "tests/draw/renderer_fixture.h"

#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/draw/view.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "engine/shade/walk_bake.h"
#include "engine/shade/walk_occlusion.h"
#include "engine/tour/tour.h"
#include "maps/maps.h"
#include "tests/support/support.h"

void renderer_check_open_stage(Stage *s, const char *path) {
    Error error;
    *s = (Stage){0};
    cr_assert(maps_read(path, &s->arena, &s->building, &error), "%s", error.text);
    renderer_check_open_building(s);
}

void renderer_check_open_building(Stage *s) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(vis_build_cells(&s->building, &options, &s->arena, &s->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&s->graph, &options, NULL, &s->arena, &s->forest));
    s->query = vis_query_new(&s->graph, &s->forest, &s->arena);
    s->doors = ARENA_ARRAY(&s->arena, float, s->building.opening_count + 1);
    s->context = gl_context_open(&s->arena, &error);
    cr_assert(s->context, "%s", error.text);
    s->renderer = walk_renderer_new(&s->graph, &s->arena, &error);
    cr_assert(s->renderer, "%s", error.text);
    s->camera = camera_look(s->building.start, s->building.start_yaw, 0, 1.2, WIDTH, HEIGHT);
}

void renderer_check_close_stage(Stage *s) {
    walk_renderer_free(s->renderer);
    gl_context_close(s->context);
    arena_free(&s->arena);
}

uint8_t *renderer_check_picture(Stage *s, const Camera *camera, Culling culling, WalkLook look) {
    Error error;
    Eye eye = walk_eye(camera);
    int cell = vis_locate(&s->graph, camera->eye, -1);
    VisResult v = vis_query(s->query, &eye, cell, s->doors, culling);
    uint8_t *rgb = arena_alloc(&s->arena, (size_t)camera->width * (size_t)camera->height, 3);
    walk_renderer_pose(s->renderer, s->doors);
    cr_assert(walk_renderer_draw(s->renderer, camera, v.objects, v.object_count, look, &error), "%s",
              error.text);
    cr_assert(walk_renderer_finish_scene(s->renderer, &error), "%s", error.text);
    cr_assert(walk_renderer_read(s->renderer, rgb, &error), "%s", error.text);
    return rgb;
}

int renderer_check_differing(const uint8_t *a, const uint8_t *b, int pixels) {
    int count = 0;
    for (int i = 0; i < pixels; i++) count += memcmp(a + 3 * i, b + 3 * i, 3) != 0;
    return count;
}

Camera renderer_check_door(const Stage *s, int width, int height) {
    const Leaf *leaf = &s->building.leaves[0];
    Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
    Vec2 middle = vec2_scale(vec2_add(leaf->axis[0], leaf->axis[1]), 0.5);
    double angle = atan2(along.y, along.x) + M_PI / 2;
    Vec3 eye = vec3(middle.x - 2 * cos(angle), middle.y - 2 * sin(angle), (leaf->z0 + leaf->z1) / 2);
    return camera_look(eye, angle, 0, 1.2, width, height);
}
