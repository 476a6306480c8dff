// test_soup_doors.c - doors of a soup, and soups that are moved, turned and shaken.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "maps/polygons/soup_doors.h"
#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/soup/soup_checks.h"
#include "visibility/pairs/pairs.h"

// ---- doors

static Building *rooms_with_door(Arena *arena, const char *name, double width) {
    const double hole[2] = {1, 2};
    Building *b = soup_closed_room(arena, vec3(8, 3, 2.5));
    soup_fixture_wall(arena, b, 0, 5, 0, 3, 0, 2.5, hole, 1, 2.1);
    building_add_object(arena, b, OBJECT_FURNITURE, name);
    soup_fixture_box(arena, b, vec3(4.98, 1.01, 0.01), vec3(5.02, 1.01 + width, 2.09), 0);
    soup_find_doors(arena, b);
    return b;
}

// Proves that words and sizes tell doors, in several languages and spellings, and what is no door.
Test(soup_doors, told_by_name) {
    static const struct {
        const char *name;
        int doors;
    } cases[] = {
        {"Door", 1},        {"front_door.001", 1}, {"FrontDoor", 1},   {"Haus Tür", 1}, {"TÜR-2", 1},
        {"la porte", 1},    {"DOORS", 1},          {"doorway", 0},     {"outdoor", 0},  {"door frame", 0},
        {"Door_Frame1", 0}, {"wall", 0},           {"indoors.set", 0}, {"", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Arena arena = {0};
        Building *b = rooms_with_door(&arena, cases[i].name, 0.98);
        cr_assert_eq(b->opening_count, cases[i].doors, "`%s`", cases[i].name);
        arena_free(&arena);
    }
    Arena arena = {0};
    cr_assert_eq(rooms_with_door(&arena, "door", 0.3)->opening_count, 0, "too narrow to pass");
    arena_free(&arena);
}

// Proves that a door becomes an opening with a leaf of its own polygons, that nothing else changes, and that the building
// has no fault.
Test(soup_doors, leaf) {
    Arena arena = {0};
    Building *b = rooms_with_door(&arena, "door", 0.98);
    const Leaf *leaf = &b->leaves[0];
    cr_assert_eq(b->leaf_count, 1);
    cr_assert_eq(leaf->opening, 0);
    cr_assert_float_eq(vec2_length(vec2_sub(leaf->axis[1], leaf->axis[0])), 0.98, 1e-9);
    cr_assert_float_eq(leaf->thickness, 0.04, 1e-9);
    cr_assert(vec2_equal(leaf->pivot, leaf->axis[0]));
    int moving = 0, polygons = 0;
    for (int i = 0; i < b->object_count; i++) {
        polygons += b->objects[i].polygon_count;
        if (b->objects[i].leaf == 0) moving += b->objects[i].polygon_count;
    }
    cr_assert_eq(moving, 6);
    cr_assert_eq(polygons, b->polygon_count);
    const char *fault = "";
    cr_assert_eq(building_check(b, &arena, &fault, 1), 0, "%s", fault);
    arena_free(&arena);
}

// As above, with a wall of 0.2 m and the leaf in the middle of it, in no plane of the wall.
static Building *rooms_with_doorway(Arena *arena) {
    const double hole[2] = {1, 2};
    Building *b = soup_closed_room(arena, vec3(8, 3, 2.5));
    for (int side = 0; side < 2; side++)
        soup_fixture_wall(arena, b, 0, 5 + 0.2 * side, 0, 3, 0, 2.5, hole, 1, 2.1);
    for (int k = 0; k < 2; k++) soup_fixture_wall(arena, b, 1, hole[k], 5, 5.2, 0, 2.1, NULL, 0, 0);
    soup_fixture_quad(arena, b, vec3(5, 1, 2.1), vec3(5.2, 1, 2.1), vec3(5.2, 2, 2.1), vec3(5, 2, 2.1), 0);
    building_add_object(arena, b, OBJECT_FURNITURE, "door");
    soup_fixture_box(arena, b, vec3(5.08, 1.01, 0.01), vec3(5.12, 1.99, 2.09), 0);
    soup_find_doors(arena, b);
    return b;
}

// Proves that doors hide nothing while open, and all that is behind them while closed: each portal in the door's plane is
// the door's and has a plug.
Test(soup_doors, close_the_view) {
    Arena arena = {0};
    Building *b = rooms_with_doorway(&arena);
    CellGraph g = soup_make(&arena, b);
    cr_assert(soup_connected(&g, vec3(2, 1, 1), vec3(7, 1, 1)));
    int doors = 0, plugs = 0;
    for (int p = 0; p < g.portal_count; p++) doors += g.portals[p].door == 0;
    for (int i = 0; i < g.object_count; i++) plugs += g.objects[i].plug;
    cr_assert(doors == 1 && plugs == 1, "%d portals, %d plugs", doors, plugs);
    VisOptions options = vis_default_options();
    StabForest forest;
    cr_assert(vis_build_forest(&g, &options, NULL, &arena, &forest));
    VisQuery *query = vis_query_new(&g, &forest, &arena);
    Eye eye = {.position = vec3(2, 1.5, 1.5)};
    float open = 0;
    int behind = vis_locate(&g, vec3(7, 1.5, 1), -1);
    for (int i = 0; i < 2; i++, open = 0.1f) {
        VisResult r = vis_query(query, &eye, vis_locate(&g, eye.position, -1), &open, CULL_STAB);
        bool seen = false;
        for (int k = 0; k < r.cell_count; k++) seen = seen || r.cells[k].cell == behind;
        cr_assert_eq(seen, i == 1);
    }
    arena_free(&arena);
}

// ---- stability

// Which polygons lie in cells that see each other: bit b of row a.
static uint64_t *polygon_pairs(Arena *arena, const Building *b, const PairMethod *method, int *words) {
    CellGraph g = soup_make(arena, b);
    PairOptions options = {.threads = 1};
    PairSet set;
    method->find(&g, &options, NULL, arena, &set);
    int count = b->object_count;
    *words = (count + 63) / 64;
    unsigned char *in = ARENA_ARRAY(arena, unsigned char, (size_t)g.cell_count *(size_t)count);
    for (int c = 0; c < g.cell_count; c++) {
        const SquareGrid *grid = &g.grids[c];
        int end = g.square_first[grid->first_square + grid->nx * grid->ny];
        for (int k = g.square_first[grid->first_square]; k < end; k++) {
            if (g.square_objects[k] < count) in[c * count + g.square_objects[k]] = 1;
        }
    }
    uint64_t *pairs = ARENA_ARRAY(arena, uint64_t, (size_t)count * (size_t)*words);
    for (int c = 0; c < g.cell_count; c++) {
        for (int d = 0; d < g.cell_count; d++) {
            if (!pair_bit(set.seen, set.words, c, d)) continue;
            for (int a = 0; a < count; a++) {
                for (int e = 0; in[c * count + a] && e < count; e++) {
                    if (in[d * count + e]) pairs[a * *words + e / 64] |= (uint64_t)1 << (e % 64);
                }
            }
        }
    }
    return pairs;
}

// An object for each polygon, so that the squares tell where each lies.
static Building *one_by_one(Arena *arena, const Building *b) {
    Building *split = ARENA_ARRAY(arena, Building, 1);
    *split = *b;
    split->objects = NULL;
    split->object_count = split->object_capacity = 0;
    for (int p = 0; p < b->polygon_count; p++) {
        building_add_object(arena, split, OBJECT_FURNITURE, "");
        split->objects[p].first_polygon = p;
        split->objects[p].polygon_count = 1;
    }
    return split;
}

static void check_stable(const Building *b, const PairMethod *method, Random *random, uint64_t seed) {
    Arena arena = {0};
    int words;
    const uint64_t *expected = polygon_pairs(&arena, b, method, &words);
    Vec3 axis = fixture_direction(random), far = vec3_scale(fixture_direction(random), 1e6);
    double angle = random_between(random, 0.1, 6);
    const SoupPose poses[] = {{1, angle, {0, 0, 1}, {0, 0, 0}},
                              {1, angle, axis, {0, 0, 0}},
                              {1e-3, 0, axis, {0, 0, 0}},
                              {1e3, 0, axis, {0, 0, 0}},
                              {1, 0, axis, far},
                              {1e-3, angle, axis, {1, 2, 3}},
                              {1, angle, axis, far}};
    for (size_t i = 0; i < sizeof poses / sizeof *poses; i++) {
        const uint64_t *found =
            polygon_pairs(&arena, soup_fixture_posed(&arena, b, &poses[i]), method, &words);
        for (int k = 0; k < b->object_count * words; k++)
            cr_assert_eq(found[k], expected[k], "seed %llu, pose %zu, %s: polygon %d",
                         (unsigned long long)seed, i, method->name, k / words);
    }
    arena_free(&arena);
}

// Proves that the pairs of polygons that see each other are the same however the building is turned, scaled and shifted,
// by the methods that know no upright direction.
Test(soup, is_stable) {
    static const char *const methods[] = {"flood", "flow"};
    for (uint64_t seed = 0; seed <= 12; seed++) {
        Arena arena = {0};
        Random random = {seed};
        const Building *drawn = seed == 0   ? soup_fixture_read(&arena, "twoRoom.quads", "two-rooms.quads")
                                : seed == 1 ? soup_fixture_read(&arena, "boxA.quads", "boxes.quads")
                                            : soup_fixture_house(&arena, &random, 3, 2);
        const Building *b = one_by_one(&arena, drawn);
        for (int i = 0; i < 2; i++) {
            const PairMethod *method = pair_method(methods[i]);
            if (method) check_stable(b, method, &random, seed);
        }
        arena_free(&arena);
    }
}
