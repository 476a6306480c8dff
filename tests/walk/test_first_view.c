// test_first_view.c - where a walk begins, and what its first picture shows.
#include <criterion/criterion.h>

#include "engine/scene/scene.h"
#include "engine/shade/walk_bake.h"
#include "engine/walk/first_view.h"

static void load(const char *path, Arena *arena, LoadedScene *out) {
    SceneOptions options = scene_default_options();
    Error error = {""};
    options.keep = false;
    cr_assert(scene_load(path, &options, arena, out, &error), "%s", error.text);
}

// Proves that a walk begins at the building's start only where that looks into a room: in three homes it faces a door two or three
// metres away, and the first stored view into a room takes its place; in an office without views, a view along its longest way.
Test(first_view, looks_into_a_room) {
    static const struct {
        const char *path, *name;
        bool start;
    } CASES[] = {{"build/maps/house.plan", "", true},           {"build/maps/two-rooms.plan", "", true},
                 {"build/maps/hillside.sh3d", "Living", false}, {"build/maps/villa.sh3d", "Living", false},
                 {"build/maps/flat.Home.xml", "Living", false}, {"build/maps/office-plain.plan", "", false}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        LoadedScene scene;
        load(CASES[i].path, &arena, &scene);
        Viewpoint first = first_view_of_walk(&scene.graph, &scene.forest);
        cr_expect_str_eq(first.name, CASES[i].name, "%s begins at `%s`", CASES[i].path, first.name);
        cr_expect_eq(vec3_equal(first.eye, scene.building.start), CASES[i].start, "%s", CASES[i].path);
        arena_free(&arena);
    }
}

// Proves that the first picture has its rows from the top: a level view has the floor below and the ceiling above.
Test(first_view, picture_is_upright) {
    enum { WIDTH = 64, HEIGHT = 64 };
    Arena arena = {0};
    LoadedScene scene;
    Error error = {""};
    static uint32_t pixels[WIDTH * HEIGHT];
    load("build/maps/two-rooms.plan", &arena, &scene);
    const CellGraph *graph = &scene.graph;
    float *doors = ARENA_ARRAY(&arena, float, scene.building.opening_count + 1);
    FirstScene at = {graph, vis_query_new(graph, &scene.forest, &arena), doors, NULL};
    Camera camera = camera_look(scene.building.start, 0, 0, FIRST_VIEW_FOV, WIDTH, HEIGHT);
    cr_assert(first_picture(&at, &camera, &arena, pixels, &error), "%s", error.text);
    uint32_t ceiling = pixels[WIDTH / 2], floor = pixels[WIDTH * (HEIGHT - 1) + WIDTH / 2];
    const Region *room = vis_region(graph, vis_locate(graph, camera.eye, -1));
    Rgba8 up = walk_bake_plain(&scene.building.materials[room->floor_material], vec3(0, 0, 1)),
          down = walk_bake_plain(&scene.building.materials[room->ceiling_material], vec3(0, 0, -1));
    cr_expect_eq(floor, 0xff000000u | (uint32_t)up.r << 16 | (uint32_t)up.g << 8 | up.b);
    cr_expect_eq(ceiling, 0xff000000u | (uint32_t)down.r << 16 | (uint32_t)down.g << 8 | down.b);
    cr_assert_neq(floor, ceiling);
    arena_free(&arena);
}
