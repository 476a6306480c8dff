// test_wad.c - Doom WADs: what becomes of a small map made here, and faults of files. Real maps: test_wad_maps.c.
#include <criterion/criterion.h>

#include "tests/maps/doom/wad_fixture.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/fixture.h"

// ---- the small map

// Proves that each sector becomes free space of its area and heights, a door and a lift as they are with all that moves
// out of the way, and that its things are where one stands.
Test(wad, sectors_become_regions) {
    // Square map units, by hand: the pillar in the first room has 2,630.
    static const double AREA[] = {256 * 256 - 2630, 16 * 64, 256 * 256, 64 * 64, 256 * 256};
    static const double FLOOR[] = {0, 0, 0, 0, 64}, CEILING[] = {128, 124, 160, 160, 256};
    Made m;
    wad_open_two_rooms(&m);
    const Building *b = &m.building;
    for (int s = 0; s < 5; s++) {
        const Region *r = wad_region_of(b, s);
        cr_assert(r, "sector %d", s);
        // Corners off the grid are moved by up to 1e-5 m along some 30 m of edges.
        cr_expect_float_eq(wad_area_of_sector(b, s), AREA[s] * UNIT * UNIT, 1e-4, "sector %d", s);
        cr_expect_float_eq(r->z0, FLOOR[s] * UNIT, 1e-12, "sector %d", s);
        cr_expect_float_eq(r->z1, CEILING[s] * UNIT, 1e-12, "sector %d", s);
    }
    cr_expect_str_eq(b->materials[wad_region_of(b, WAD_COURT)->ceiling_material].name, "sky");
    cr_expect_str_eq(b->map, "MAP01");
    cr_expect_float_eq(b->start.x, 40 * UNIT, 1e-12);
    cr_expect_float_eq(b->start.z, 1.6, 1e-12);
    cr_assert_eq(b->viewpoint_count, 2);
    cr_expect_str_eq(b->viewpoints[1].name, "deathmatch 1");
    cr_expect_float_eq(b->viewpoints[1].yaw, M_PI, 1e-12);
    cr_expect_float_eq(b->viewpoints[1].eye.z, 64 * UNIT + 1.6, 1e-12);
    arena_free(&m.arena);
}

// Proves that every cell is convex to the last bit, although its corners were rounded: a pillar of walls that cross the
// grid anywhere cuts the room.
Test(wad, cells_are_exactly_convex) {
    Made m;
    wad_open_two_rooms(&m);
    int off = 0;
    for (int i = 0; i < m.graph.plan_count; i++) off += m.graph.plan[i].x != maps_snap(m.graph.plan[i].x);
    cr_expect_gt(off, 0, "no corner is off the grid: this proves nothing");
    cr_expect_eq(fixture_dents(&m.graph), 0);
    arena_free(&m.arena);
}
