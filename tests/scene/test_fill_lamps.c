// test_fill_lamps.c - rooms without light get lamps, all other rooms get none, and a file of light knows the difference.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/polygon.h"
#include "engine/scene/scene.h"
#include "tests/support/support.h"

// Three rooms in a row, 4 x 3 m, 3 x 3 m and 12 x 2 m. A door leads from the first to the second; the third is apart.
static const char ROOMS[] =
    "plan 1\nmaterial m #808080\nmaterial glow #FFFFFF emission 10\nground m height 0\n"
    "storey s floor 0 height 2.5 slab 0.3\n"
    "room first 0,0 4,0 4,3 0,3 floor m ceiling m walls m wall 0.1\n"
    "room second 4.1,0 7.1,0 7.1,3 4.1,3 floor m ceiling m walls m wall 0.1\n"
    "room third 0,5 12,5 12,7 0,7 floor m ceiling m walls m wall 0.1\n";
static const char DOOR[] = "door d 4.05,1.5 angle 90 width 0.9 height 2 hinge left swing 85 material m\n";
static const char PASSAGE[] = "passage d 4.05,1.5 angle 90 width 0.9 height 2\n";
static const char WIDE[] = "passage d 4.05,1.5 angle 90 width 2.5 height 2\n";
static const char WINDOW[] = "window w 5.6,-0.05 width 1 height 1 sill 1\n";
static const char LAMP[] = "inlay glow ceiling 1,1 2,1 2,2 1,2\n";
// A cupboard up to the ceiling fills the middle of the second room.
static const char CUPBOARD[] =
    "model cupboard\n  box -0.5,-0.5,0 0.5,0.5,2.5 m\nend\nplace cupboard 5.6,1.5\n";

static void load(const char *const *lines, int count, double sky, int fill, Arena *arena, LoadedScene *out) {
    const char *path = arena_format(arena, "%s/rooms.plan", support_folder(arena));
    FILE *file = fopen(path, "w");
    Error error = {""};
    SceneOptions options = scene_default_options();
    cr_assert(file);
    fputs(ROOMS, file);
    for (int i = 0; i < count; i++) fputs(lines[i], file);
    cr_assert_eq(fclose(file), 0);
    options.lamps = SCENE_LAMPS_ALL;
    options.keep = false;
    options.fill_lamps = fill;
    for (int c = 0; c < 3; c++) options.day.sky[c] = sky;
    cr_assert(scene_load(path, &options, arena, out, &error), "%s", error.text);
}

// The number of added lamps in a region, and their flux, W a channel. All of them must face down into the room.
static int lamps_in(const LoadedScene *scene, const char *name, double *watts) {
    const Building *b = &scene->building;
    int count = 0;
    *watts = 0;
    for (int i = b->object_count - b->fill_lamps; i < b->object_count; i++) {
        const Polygon *p = &b->polygons[b->objects[i].first_polygon];
        const Vec3 *v = &b->vertices[p->first_vertex];
        Vec3 middle = vec3_lerp(v[0], v[2], 0.5);
        cr_assert_lt(plane_of_polygon(v, p->vertex_count).n.z, -0.999);
        cr_assert_float_eq(middle.z, 2.495, 1e-9, "a lamp hangs at %g m", middle.z);
        int cell = vis_locate(&scene->graph, middle, -1);
        cr_assert_geq(cell, 0);
        if (strcmp(vis_region(&scene->graph, cell)->name, name) != 0) continue;
        *watts += (double)b->materials[p->material].emission.r * polygon_area(v, p->vertex_count);
        count++;
    }
    return count;
}

// Proves which rooms get lamps: those without a lamp behind a closed door, but not those with a lamp, nor their neighbours through a
// wide passage, nor, by day, those with a window and their neighbours. By night a passage of 1.8 m^2 does not light 9 m^2. A
// lamp in the first room sets the flux: 10 W in 12 m^2. The third room is a corridor with more than one lamp. Switched off, there is none.
Test(fill_lamps, dark_rooms_get_lamps) {
    static const struct {
        const char *lines[3];
        int count;
        double sky;
        int fill;
        int first, second, rooms;
    } CASES[] = {
        {{DOOR, LAMP}, 2, 0, FILL_LAMPS_ON, 0, 1, 2},   {{PASSAGE, LAMP}, 2, 0, FILL_LAMPS_ON, 0, 1, 2},
        {{WIDE, LAMP}, 2, 0, FILL_LAMPS_ON, 0, 0, 1},   {{DOOR, WINDOW}, 2, 0, FILL_LAMPS_ON, 1, 1, 3},
        {{DOOR, WINDOW}, 2, 5, FILL_LAMPS_ON, 1, 0, 2}, {{PASSAGE, WINDOW}, 2, 5, FILL_LAMPS_ON, 0, 0, 1},
        {{PASSAGE}, 1, 0, FILL_LAMPS_ON, 1, 1, 3},      {{DOOR, LAMP}, 2, 0, FILL_LAMPS_OFF, 0, 0, 0}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        LoadedScene scene;
        double watts;
        load(CASES[i].lines, CASES[i].count, CASES[i].sky, CASES[i].fill, &arena, &scene);
        cr_expect_eq(lamps_in(&scene, "first", &watts), CASES[i].first, "case %zu", i);
        cr_expect_eq(lamps_in(&scene, "second", &watts), CASES[i].second, "case %zu", i);
        if (i == 0) cr_expect_float_eq(watts, 9 * 10.0 / 12, 1e-3, "%g W", watts);
        int corridor = lamps_in(&scene, "third", &watts);
        cr_expect(CASES[i].fill == FILL_LAMPS_ON ? corridor >= 2 : corridor == 0, "case %zu: %d", i,
                  corridor);
        if (i == 0) cr_expect_float_eq(watts, 24 * 10.0 / 12, 1e-3, "%g W", watts);
        cr_expect_eq(scene.filled_rooms, CASES[i].rooms, "case %zu: %d rooms", i, scene.filled_rooms);
        arena_free(&arena);
    }
}

// Proves that a lamp hangs beside a cupboard that fills the middle of the room, not inside.
Test(fill_lamps, hang_beside_furniture) {
    static const char *const LINES[] = {DOOR, LAMP, CUPBOARD};
    Arena arena = {0};
    LoadedScene scene;
    double watts;
    load(LINES, 3, 0, FILL_LAMPS_ON, &arena, &scene);
    cr_assert_eq(lamps_in(&scene, "second", &watts), 1);
    const Building *b = &scene.building;
    for (int i = b->polygon_count - b->fill_lamps; i < b->polygon_count; i++)
        for (int k = 0; k < 4; k++) {
            Vec3 v = b->vertices[b->polygons[i].first_vertex + k];
            cr_assert(fabs(v.x - 5.6) > 0.5 || fabs(v.y - 1.5) > 0.5, "a corner at %g, %g", v.x, v.y);
        }
    arena_free(&arena);
}

// Proves that the cells of a scene are those of its building with all its lamps, whether rooms got some, which makes the cells anew, or
// none, which keeps those that told the rooms.
Test(fill_lamps, cells_are_those_of_the_lit_building) {
    static const char *const LINES[] = {DOOR, LAMP, "inlay glow ceiling 5,1 6,1 6,2 5,2\n",
                                        "inlay glow ceiling 1,6 2,6 2,7 1,7\n"};
    for (int lamps = 1; lamps <= 3; lamps += 2) {
        Arena arena = {0};
        LoadedScene scene;
        CellGraph anew, *kept = &scene.graph;
        Error error = {""};
        VisOptions options = vis_default_options();
        load(LINES, 1 + lamps, 0, FILL_LAMPS_ON, &arena, &scene);
        cr_assert_eq(scene.building.fill_lamps > 0, lamps < 3, "%d", scene.building.fill_lamps);
        cr_assert(vis_build_cells(&scene.building, &options, &arena, &anew, &error), "%s", error.text);
        cr_assert(kept->cell_count == anew.cell_count && kept->object_count == anew.object_count &&
                  kept->polygon_count == anew.polygon_count && kept->vertex_count == anew.vertex_count &&
                  kept->square_object_count == anew.square_object_count);
        // Each lamp has materials of its own.
        for (int p = 0; p < anew.polygon_count; p++)
            cr_expect(kept->polygons[p].first_vertex == anew.polygons[p].first_vertex &&
                      kept->polygons[p].vertex_count == anew.polygons[p].vertex_count &&
                      kept->polygons[p].texture_map == anew.polygons[p].texture_map);
        cr_expect_arr_eq(kept->vertices, anew.vertices, (size_t)anew.vertex_count * sizeof *anew.vertices);
        cr_expect_arr_eq(kept->square_objects, anew.square_objects,
                         (size_t)anew.square_object_count * sizeof *anew.square_objects);
        arena_free(&arena);
    }
}
