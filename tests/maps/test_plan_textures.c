// test_plan_textures.c - pictures of a plan's materials, and how they lie.
#include <criterion/criterion.h>

#include "engine/core/file.h"
#include "maps/maps.h"
#include "tests/support/files/soups.h"
#include "tests/support/support.h"
#include "visibility/vis.h"

static const char PLAN[] =
    "plan 1\n"
    "material oak #808080 texture oak.png width 2 height 0.5 angle 90 right 1 up 0.25\n"
    "material tiles #808080 texture oak.png width 2\n"
    "storey s floor 1 height 3\n"
    "room a 0,0 4,0 4,3 0,3 floor tiles ceiling tiles walls oak wall 0.2\n"
    "model m\nbox -1,-1,0 1,1,1 tiles\nsphere tiles 0,0,2 radius 0.5\nend\n"
    "place m 2,1.5 angle 90\n";

static void read_plan(Arena *arena, const char *text, Bytes picture, Building *b) {
    Error error = {""};
    const char *folder = support_folder(arena), *path = arena_format(arena, "%s/t.plan", folder);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert(file_write(arena_format(arena, "%s/oak.png", folder), picture.data, picture.size, &error), "%s",
              error.text);
    cr_assert(maps_read(path, arena, b, &error), "%s", error.text);
}

static Bytes picture_of_4_by_2(Arena *arena) {
    uint8_t pixels[32];
    memset(pixels, 255, sizeof pixels);
    for (int i = 0; i < 8; i++) pixels[4 * i] = (uint8_t)(20 * i);
    return support_png(arena, 4, 2, pixels);
}

static void expect_place(const Building *b, int map, Vec3 p, double u, double v, const char *what) {
    cr_assert_gt(map, 0, "%s", what);
    const TextureMap *m = &b->texture_maps[map];
    // Tolerance: rounding of doubles.
    cr_expect_float_eq(vec3_dot(m->u, p) + m->u0, u, 1e-12, "%s: u %g", what, vec3_dot(m->u, p) + m->u0);
    cr_expect_float_eq(vec3_dot(m->v, p) + m->v0, v, 1e-12, "%s: v %g", what, vec3_dot(m->v, p) + m->v0);
}

// Proves that a picture of 2 m, whose height of 1 m follows from its sides, lies on a floor and a ceiling; that one of 2 m x 0.5 m,
// moved by 1 m to the right and 0.25 m up and turned by a quarter, lies on walls; and that a model takes its picture along, but not on
// spheres. By hand: of the wall in the south, seen from inside, the right is -x; turned, the picture's right is up and its top to the
// left, +x.
Test(plan_textures, lie_as_stated) {
    Arena arena = {0};
    Building b;
    read_plan(&arena, PLAN, picture_of_4_by_2(&arena), &b);
    const Region *room = NULL;
    for (int i = 0; i < b.region_count; i++)
        if (strcmp(b.regions[i].name, "a") == 0) room = &b.regions[i];
    cr_assert_not_null(room);
    cr_assert_eq(b.texture_count, 2, "one picture for both materials");
    expect_place(&b, b.materials[room->floor_material].texture_map, vec3(0.5, 0.25, 1), 0.25, -0.25, "floor");
    expect_place(&b, b.materials[room->ceiling_material].texture_map, vec3(0.5, 0.25, 4), 0.25, 0.25,
                 "ceiling");
    const Ring *ring = &b.rings[room->first_ring];
    int walls = 0;
    for (int i = 0; i < ring->point_count; i++) {
        int at = ring->first_point + i, next = ring->first_point + (i + 1) % ring->point_count;
        if (b.points[at].y != 0 || b.points[next].y != 0) continue;
        walls++;
        expect_place(&b, b.materials[b.edge_material[at]].texture_map, vec3(1, 0, 2), 0.375, -4,
                     "wall in the south");
    }
    cr_expect_eq(walls, 1);
    int faces = 0, round = 0;
    for (int i = 0; i < b.polygon_count; i++) {
        const Vec3 *v = b.vertices + b.polygons[i].first_vertex;
        bool front = true;
        for (int k = 0; k < b.polygons[i].vertex_count; k++) front &= fabs(v[k].x - 3) < 1e-9;
        round += b.polygons[i].texture_map == 0;
        if (!front) continue;
        faces++;
        // The face that was at y = -1 before it was turned: its right was +x, now +y.
        expect_place(&b, b.polygons[i].texture_map, vec3(3, 2.5, 2), 0.5, -1, "front of the box");
        expect_place(&b, b.polygons[i].texture_map, vec3(3, 0.5, 1), -0.5, 0, "front of the box");
    }
    cr_expect_eq(faces, 1);
    cr_expect_gt(round, 50, "polygons of the sphere");
    cr_expect_eq(b.polygon_count - round, 6);
    cr_expect(fabsf(b.materials[room->floor_material].reflectance.g - MAPS_MAX_COLOUR) < 1e-6f,
              "the picture's mean");
    arena_free(&arena);
}

// Proves that polygons of furniture keep their maps when a building is cut into cells.
Test(plan_textures, cells_keep_maps) {
    Arena arena = {0};
    Building b;
    CellGraph graph;
    Error error = {""};
    VisOptions options = vis_default_options();
    read_plan(&arena, PLAN, picture_of_4_by_2(&arena), &b);
    cr_assert(vis_build_cells(&b, &options, &arena, &graph, &error), "%s", error.text);
    cr_assert_geq(graph.polygon_count, b.polygon_count);
    int laid = 0;
    for (int i = 0; i < b.polygon_count; i++) {
        cr_expect_eq(graph.polygons[i].texture_map, b.polygons[i].texture_map);
        laid += b.polygons[i].texture_map > 0;
    }
    cr_expect_eq(laid, 6);
    arena_free(&arena);
}

// Proves that a picture that is damaged, missing or not below the plan's folder costs a note with its line, and the stated colour stays.
Test(plan_textures, broken_pictures) {
    static const char *const NAMES[] = {"oak.png", "nothing.png", "../oak.png"};
    for (int i = 0; i < 3; i++) {
        Arena arena = {0};
        Building b;
        Bytes picture = picture_of_4_by_2(&arena);
        picture.size -= 20;
        read_plan(&arena,
                  arena_format(&arena,
                               "plan 1\nmaterial oak #808080 texture %s width 2\nstorey s floor 0 height 3\n"
                               "room a 0,0 4,0 4,3 0,3 floor oak wall 0.2\n",
                               NAMES[i]),
                  picture, &b);
        cr_expect_eq(
            soups_notes(&b, arena_format(&arena, "t.plan:2: the texture `%s` is left out", NAMES[i])), 1);
        cr_expect_eq(b.texture_count, 0);
        cr_expect(fabsf(b.materials[1].reflectance.r - maps_linear(0x80)) < 1e-6f);
        arena_free(&arena);
    }
}
