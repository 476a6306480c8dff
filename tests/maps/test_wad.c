// Doom WADs: what becomes of a small map made here, and faults of files. Real maps: test_wad_maps.c.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/sim/doors.h"
#include "engine/sim/tour.h"
#include "engine/walk/verify.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "tests/support/wad_builder.h"

extern const MapsReader MAPS_READER_WAD;
static const double UNIT = 0.031;  // metres a map unit

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    Doors doors;
    BodyWorld world;
    Body body;
} Made;

static const char *write_wad(Arena *arena, Bytes file) {
    Error error;
    char *path = arena_format(arena, "%s/test.wad", support_folder(arena));
    cr_assert(file_write(path, file.data, file.size, &error), "%s", error.text);
    return path;
}

static const char *write_map(Arena *arena, const WadMaker *maker) {
    static const char *const NAMES[] = {"MAP01"};
    return write_wad(arena, wad_file(maker, NAMES, 1, NULL));
}

static void open_file(Made *m, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    m->doors = doors_new(&m->graph, &m->arena);
    m->world = body_world(&m->graph, m->doors.open, &m->arena);
    m->body = (Body){.cell = -1};
}

static void open_two_rooms(Made *m) {
    *m = (Made){.arena = {0}};
    WadMaker maker = {.arena = &m->arena};
    wad_two_rooms(&maker);
    open_file(m, write_map(&m->arena, &maker));
}

static const Region *region_of(const Building *b, int sector) {
    char name[32];
    snprintf(name, sizeof name, "sector %d", sector);
    for (int i = 0; i < b->region_count; i++) {
        if (strcmp(b->regions[i].name, name) == 0) return &b->regions[i];
    }
    return NULL;
}

static int opening_named(const Building *b, const char *name) {
    for (int i = 0; i < b->opening_count; i++) {
        if (strcmp(b->openings[i].name, name) == 0) return i;
    }
    cr_assert_fail("there is no opening %s", name);
    return -1;
}

// ---- the small map

static double area_of_sector(const Building *b, int sector) {
    char name[32];
    double area = 0;
    snprintf(name, sizeof name, "sector %d", sector);
    for (int i = 0; i < b->region_count; i++)
        if (strcmp(b->regions[i].name, name) == 0) area += fixture_region_area(b, &b->regions[i]);
    return area;
}

// Proves that each sector becomes free space of its area and heights, a door and a lift as they are with all that moves
// out of the way, and that its things are where one stands.
Test(wad, sectors_become_regions) {
    // Square map units, by hand: the pillar in the first room has 2,630.
    static const double AREA[] = {256 * 256 - 2630, 16 * 64, 256 * 256, 64 * 64, 256 * 256};
    static const double FLOOR[] = {0, 0, 0, 0, 64}, CEILING[] = {128, 124, 160, 160, 256};
    Made m;
    open_two_rooms(&m);
    const Building *b = &m.building;
    for (int s = 0; s < 5; s++) {
        const Region *r = region_of(b, s);
        cr_assert(r, "sector %d", s);
        // Corners off the grid are moved by up to 1e-5 m along some 30 m of edges.
        cr_expect_float_eq(area_of_sector(b, s), AREA[s] * UNIT * UNIT, 1e-4, "sector %d", s);
        cr_expect_float_eq(r->z0, FLOOR[s] * UNIT, 1e-12, "sector %d", s);
        cr_expect_float_eq(r->z1, CEILING[s] * UNIT, 1e-12, "sector %d", s);
    }
    cr_expect_str_eq(b->materials[region_of(b, WAD_COURT)->ceiling_material].name, "sky");
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
    open_two_rooms(&m);
    int off = 0;
    for (int i = 0; i < m.graph.plan_count; i++) off += m.graph.plan[i].x != maps_snap(m.graph.plan[i].x);
    cr_expect_gt(off, 0, "no corner is off the grid: this proves nothing");
    cr_expect_eq(fixture_dents(&m.graph), 0);
    arena_free(&m.arena);
}

// ---- doors and lifts

// Proves that a closed door hides what is behind it and one that is hardly open hides nothing; that a lift never does.
Test(wad, doors_block_sight_and_lifts_do_not) {
    Made m;
    StabForest forest;
    open_two_rooms(&m);
    VisOptions options = vis_default_options();
    cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &forest));
    VisQuery *query = vis_query_new(&m.graph, &forest, &m.arena);
    int door = opening_named(&m.building, "door 1"), lift = opening_named(&m.building, "lift 3");
    Eye eye = {.position = vec3(200 * UNIT, 128 * UNIT, 1.6)};
    int cell = vis_locate(&m.graph, eye.position, -1),
        hall = (int)(region_of(&m.building, WAD_HALL) - m.building.regions);
    for (int state = 0; state < 4; state++) {
        m.doors.open[door] = state % 2 ? 1e-6f : 0;
        m.doors.open[lift] = state / 2 ? 1 : 0;
        VisResult seen = vis_query(query, &eye, cell, m.doors.open, CULL_STAB);
        bool behind = false;
        for (int i = 0; i < seen.cell_count; i++)
            behind = behind || m.graph.cells[seen.cells[i].cell].region == hall;
        cr_expect_eq(behind, state % 2 == 1, "door %g, lift %g", (double)m.doors.open[door],
                     (double)m.doors.open[lift]);
    }
    int closing = 0;
    for (int i = 0; i < m.graph.portal_count; i++) {
        cr_expect(m.graph.portals[i].door != lift);
        closing += m.graph.portals[i].door == door;
    }
    cr_expect_eq(closing, 2, "the door closes its two sides");
    arena_free(&m.arena);
}

// Proves that culled pictures equal unculled ones, item for item, from random places with doors and lifts anywhere.
Test(wad, nothing_visible_is_lost) {
    Made m;
    StabForest forest;
    Error error;
    open_two_rooms(&m);
    VisOptions options = vis_default_options();
    cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &forest));
    WalkVerify *verify = walk_verify_new(&m.graph, &forest, &m.arena, &error);
    cr_assert(verify, "%s", error.text);
    uint64_t seed = 5;
    Random random = {seed};
    RandomView view = {.door_open = ARENA_ARRAY(&m.arena, float, m.building.opening_count)};
    int tried = 0;
    for (int i = 0; i < support_count(200, 4000); i++) {
        VerifyFrame frame;
        if (!walk_random_view(&m.graph, &random, 120, 80, &view)) continue;
        cr_assert(
            walk_verify_frame(verify, &view.camera, view.cell, view.door_open, CULL_STAB, &frame, &error),
            "%s", error.text);
        cr_expect(frame.missing_polygons == 0 && frame.mismatched_pixels == 0,
                  "seed %llu, view %d (%s): %d polygons missing, %d pixels differ", (unsigned long long)seed,
                  i, view.kind, frame.missing_polygons, frame.mismatched_pixels);
        tried++;
    }
    cr_expect_gt(tried, 50);
    walk_verify_free(verify);
    arena_free(&m.arena);
}

// Proves that a tour looks all around once in each room, not once in each piece that it was cut into.
Test(wad, tours_turn_once_a_room) {
    Made m;
    TourPath path;
    Error error;
    TourOptions options = tour_default_options();
    open_two_rooms(&m);
    cr_assert(tour_make(&m.graph, "auto", &options, &m.arena, &path, &error), "%s", error.text);
    int circles = 0, still = 0, whole = (int)(2 * M_PI / options.turn + 0.5);
    for (int i = 1; i < path.frame_count; i++) {
        still = vec3_equal(path.frames[i].eye, path.frames[i - 1].eye) ? still + 1 : 0;
        circles += still == whole;
    }
    cr_expect_gt(m.building.region_count, 5, "no room is cut: this proves nothing");
    cr_expect_eq(circles, 2, "the room and the hall; the court is up a lift");
    arena_free(&m.arena);
}

static void walk_east(Made *m, double metres) {
    for (double gone = 0; gone < metres; gone += 0.02) body_step(&m->body, &m->world, vec2(0.02, 0), 0.02);
}

static void pass(Made *m, double seconds) {
    for (double t = 0; t < seconds; t += 1.0 / 120) {
        doors_advance(&m->doors, 1.0 / 120, &m->body);
        body_step(&m->body, &m->world, vec2(0, 0), 1.0 / 120);
    }
}

// Proves that a closed door holds a body and an open one lets it pass, and that one which comes down halts over a body
// in its doorway, and goes on when that has gone.
Test(wad, doors_hold_bodies_and_wait_for_them) {
    Made m;
    open_two_rooms(&m);
    int door = opening_named(&m.building, "door 1");
    cr_assert(doors_usable(&m.doors, door));
    cr_assert(body_place_near(&m.body, &m.world, vec3(200 * UNIT, 128 * UNIT, 0)));
    walk_east(&m, 3);
    cr_expect_lt(m.body.foot.x, 256 * UNIT, "closed");
    Vec3 eye = vec3(m.body.foot.x, m.body.foot.y, 1.6);
    cr_expect_eq(doors_looked_at(&m.doors, eye, m.body.cell, vec3(1, 0, 0), DOORS_REACH), door);
    cr_expect_eq(doors_looked_at(&m.doors, eye, m.body.cell, vec3(-1, 0, 0), DOORS_REACH), -1);
    cr_assert(doors_toggle(&m.doors, door));
    pass(&m, 0.3);
    cr_expect(m.doors.open[door] > 0 && m.doors.open[door] < 1, "it takes its time");
    pass(&m, 2);
    cr_expect_eq(m.doors.open[door], 1.0f);
    walk_east(&m, 264 * UNIT - m.body.foot.x);
    cr_assert(fabs(m.body.foot.x - 264 * UNIT) < 0.1, "in the doorway");
    doors_toggle(&m.doors, door);
    pass(&m, 3);
    cr_expect_gt(m.doors.open[door], 0.3f, "it does not come down on a body");
    cr_expect_eq(m.doors.halt[door], DOOR_MEETS_BODY);
    walk_east(&m, 2);
    pass(&m, 3);
    cr_expect_gt(m.body.foot.x, 272 * UNIT);
    cr_expect_eq(m.doors.open[door], 0.0f);
    cr_expect_eq(m.world.relocations, 0);
    arena_free(&m.arena);
}

// Proves that a lift carries who stands on it, down and up again, and stops nobody walking off.
Test(wad, lifts_carry_bodies) {
    Made m;
    open_two_rooms(&m);
    int lift = opening_named(&m.building, "lift 3");
    double top = 64 * UNIT;
    cr_assert(body_place_near(&m.body, &m.world, vec3(560 * UNIT, 128 * UNIT, top)));
    cr_expect_float_eq(m.body.foot.z, top, 1e-6, "it stands up as drawn");
    cr_assert(doors_toggle(&m.doors, lift));
    pass(&m, 3);
    cr_expect_eq(m.doors.open[lift], 1.0f);
    cr_expect_float_eq(m.body.foot.z, 0, 1e-6, "down");
    doors_toggle(&m.doors, lift);
    pass(&m, 3);
    cr_expect_eq(m.doors.open[lift], 0.0f);
    cr_expect_float_eq(m.body.foot.z, top, 1e-6, "up");
    cr_expect_float_eq(m.body.foot.x, 560 * UNIT, 1e-3, "where it was");
    cr_expect_eq(m.world.relocations, 0);
    walk_east(&m, 3);
    cr_expect_gt(m.body.foot.x, 592 * UNIT + 1, "into the court");
    arena_free(&m.arena);
}

// A lift of 64 x 64 units that goes down into a hall, with so much room over it when it is up. It lies to the east, so that
// its cell is the first.
static void open_lift(Made *m, int room) {
    static const int AT[][8] = {
        {0, 0, 0, 64, 0, -1, 0, 0},        {0, 64, 64, 64, 0, -1, 0, 0},     {64, 64, 64, 0, 0, 1, 62, 5},
        {64, 0, 0, 0, 0, -1, 0, 0},        {64, 64, 64, 160, 1, -1, 0, 0},   {64, 160, 320, 160, 1, -1, 0, 0},
        {320, 160, 320, -96, 1, -1, 0, 0}, {320, -96, 64, -96, 1, -1, 0, 0}, {64, -96, 64, 0, 1, -1, 0, 0}};
    *m = (Made){.arena = {0}};
    WadMaker maker = {.arena = &m->arena};
    wad_sector(&maker, 64, 64 + room, "CEIL", 5);
    wad_sector(&maker, 0, 200, "CEIL", 0);
    for (size_t i = 0; i < sizeof AT / sizeof *AT; i++) {
        const int *l = AT[i];
        wad_line(&maker, 320 - l[0], 64 - l[1], 320 - l[2], 64 - l[3], l[4], l[5], l[6], l[7]);
    }
    wad_thing(&maker, 120, 32, 0, 1);
    open_file(m, write_map(&m->arena, &maker));
}

// Proves that whoever a lift carries stands on its top at each moment, no taller than there is room under the ceiling, and that it halts
// before it presses anybody: with room to stand, to duck, and with too little. Nothing but the lift moves the body.
Test(wad, lifts_press_nobody) {
    static const int ROOMS[] = {100, 50, 41, 36, 20};
    for (size_t k = 0; k < sizeof ROOMS / sizeof *ROOMS; k++) {
        Made m;
        open_lift(&m, ROOMS[k]);
        int lift = opening_named(&m.building, "lift 0");
        double ceiling = (64 + ROOMS[k]) * UNIT, highest = ceiling - BODY_LOWEST;
        doors_set(&m.doors, lift, 1);
        cr_assert(body_place_near(&m.body, &m.world, vec3(288 * UNIT, 32 * UNIT, 0)));
        cr_assert_float_eq(m.body.foot.z, 0, 1e-6);
        cr_assert_eq(m.body.cell, 0, "the first cell is that of the lift");
        doors_toggle(&m.doors, lift);
        for (int i = 0; i < 400; i++) {
            doors_advance(&m.doors, 1.0 / 240, &m.body);
            const Leaf *leaf = &m.building.leaves[m.building.openings[lift].first_leaf];
            // Wide open it lies a hair under the floor.
            double top = fmax(0, leaf->z1 + (double)m.doors.open[lift] * leaf->rise);
            cr_assert_float_eq(m.body.foot.z, top, 2e-6, "room of %d: at %g on a lift at %g", ROOMS[k],
                               m.body.foot.z, top);
            cr_assert(m.body.standing && m.body.fall == 0);
            cr_assert_float_eq(m.body.height, fmin(BODY_HEIGHT, ceiling - top), 1e-5);
            cr_assert_float_eq(m.body.head, fmin(BODY_HEIGHT, ceiling - top), 1e-5);
        }
        bool up = highest >= 64 * UNIT;
        cr_expect_eq(m.doors.open[lift] == 0, up, "room of %d: at %g", ROOMS[k], (double)m.doors.open[lift]);
        cr_expect_eq(m.doors.halt[lift], up ? DOOR_FREE : DOOR_MEETS_BODY);
        // A step of a leaf is a centimetre.
        if (!up) cr_expect(m.body.foot.z > highest - 0.011 && m.body.foot.z <= highest + 1e-6);
        arena_free(&m.arena);
    }
}

// Puts 16 bits into a record of the small map.
static void poke(unsigned char *records, int at, int value) {
    records[at] = (unsigned char)(value & 255);
    records[at + 1] = (unsigned char)(value >> 8 & 255);
}

typedef struct Motion {
    int door_special, floor, ceiling;  // of the door's lines; of its sector
    int lift_special;
    double z0, z1, open, lift_z0;  // of the regions, map units; of the door as drawn
    bool sinks;
} Motion;

// Proves which sectors are doors and lifts, and how far they go: by hand and by tag, Boom's specials, closed without any,
// drawn ajar or open, and where only the floor has somewhere to go.
Test(wad, what_moves) {
    static const Motion MOTIONS[] = {
        {1, 0, 0, 62, 0, 124, 0, 0, false},       {0, 0, 0, 88, 0, 124, 0, 0, false},
        {117, 0, 31, 0, 0, 124, 0.25, 64, false}, {0x3C07, 0, 62, 0x3400, 0, 124, 0.5, 0, false},
        {1, 0, 128, 0, 0, 128, 1, 64, false},     {0, 40, 40, 0, 40, 124, 0, 64, false},
        {0, 128, 128, 123, 0, 128, 0, 0, true},
    };
    enum { LINE = 14, SECTOR = 26, FRONT_OF_DOOR = 3, BACK_OF_DOOR = 13, FRONT_OF_LIFT = 17 };
    for (size_t i = 0; i < sizeof MOTIONS / sizeof *MOTIONS; i++) {
        const Motion *x = &MOTIONS[i];
        Made m = {.arena = {0}};
        WadMaker maker = {.arena = &m.arena};
        wad_two_rooms(&maker);
        poke(maker.lines, LINE * FRONT_OF_DOOR + 6, x->door_special);
        poke(maker.lines, LINE * BACK_OF_DOOR + 6, x->door_special);
        poke(maker.lines, LINE * FRONT_OF_LIFT + 6, x->lift_special);
        poke(maker.sectors, SECTOR * WAD_DOOR_SECTOR, x->floor);
        poke(maker.sectors, SECTOR * WAD_DOOR_SECTOR + 2, x->ceiling);
        open_file(&m, write_map(&m.arena, &maker));
        const Region *door = region_of(&m.building, WAD_DOOR_SECTOR),
                     *lift = region_of(&m.building, WAD_LIFT_SECTOR);
        const Opening *opening = &m.building.openings[opening_named(&m.building, "door 1")];
        cr_expect_float_eq(door->z0, x->z0 * UNIT, 1e-12, "case %zu", i);
        cr_expect_float_eq(door->z1, x->z1 * UNIT, 1e-12, "case %zu", i);
        cr_expect_float_eq(opening->open, x->open, 1e-12, "case %zu", i);
        cr_expect_eq(m.building.leaves[opening->first_leaf].rise < 0, x->sinks, "case %zu", i);
        cr_expect_float_eq(lift->z0, x->lift_z0 * UNIT, 1e-12, "case %zu", i);
        cr_expect_eq(m.building.opening_count, x->lift_z0 == 0 ? 2 : 1, "case %zu", i);
        arena_free(&m.arena);
    }
}

// Proves where a rising leaf is: it keeps its plan, its height goes with its share, and it is found in the squares of
// every cell that it passes.
Test(wad, leaves_rise) {
    Leaf leaf = {.rise = 2.5, .axis = {{0, 0}, {1, 0}}, .thickness = 0.2, .z1 = 2};
    cr_expect(vec3_equal(leaf_point(&leaf, 0.5, vec3(0.3, 0.1, 1)), vec3(0.3, 0.1, 2.25)));
    Made m;
    open_two_rooms(&m);
    const CellGraph *g = &m.graph;
    const char *fault = "";
    m.building.leaves[0].corner_count = 2;
    cr_expect(building_check(&m.building, &m.arena, &fault, 1) == 1 && strstr(fault, "leaf 0: corners"), "%s",
              fault);
    m.building.leaves[0].corner_count = 4;
    for (int o = 0; o < m.building.object_count; o++) {
        if (g->objects[o].leaf < 0) continue;
        const Leaf *l = &m.building.leaves[g->objects[o].leaf];
        Vec2 corner[LEAF_CORNERS];
        cr_assert_eq(leaf_plan(&m.building, l, 0.7, corner), 4);
        Box box = g->object_boxes[o];
        cr_expect_leq(box.min.z, l->z0 + fmin(0, l->rise));
        cr_expect_geq(box.max.z, l->z1 + fmax(0, l->rise));
        for (int i = 0; i < 4; i++) cr_expect(box_contains(box, vec3(corner[i].x, corner[i].y, l->z0)));
    }
    arena_free(&m.arena);
}

// ---- faults

static bool refused(Arena *arena, Bytes file, const char *map, const char *expected) {
    Building b;
    Error error = {""};
    bool read = maps_read_map(write_wad(arena, file), map, arena, &b, &error);
    cr_expect_not(read, "was read; expected: %s", expected);
    cr_expect(read || strstr(error.text, expected), "found: %s; expected: %s", error.text, expected);
    return !read;
}

static Bytes small_file(Arena *arena, const char *with) {
    static const char *const NAMES[] = {"MAP01"};
    WadMaker maker = {.arena = arena};
    wad_two_rooms(&maker);
    return wad_file(&maker, NAMES, 1, with);
}

static void set16(Bytes file, long at, int value) {
    file.data[at] = (unsigned char)(value & 255);
    file.data[at + 1] = (unsigned char)(value >> 8 & 255);
}

static void set32(Bytes file, long at, long value) {
    set16(file, at, (int)(value & 0xFFFF));
    set16(file, at + 2, (int)(value >> 16 & 0xFFFF));
}

// The place of the directory's entry with this name.
static long entry_of(Bytes file, const char *name) {
    char padded[9] = "";
    strncpy(padded, name, 8);
    long at = file.data[8] | file.data[9] << 8 | file.data[10] << 16;
    while (memcmp(file.data + at + 8, padded, 8) != 0) at += 16;
    return at;
}

// Proves that each fault of a file is refused with a sentence that says where and what.
Test(wad, faults_are_named) {
    static const struct {
        const char *lump;
        int at, value;  // 16 bits there
        const char *expected;
    } RECORDS[] = {
        {"LINEDEFS", 2, 60000, "linedef 0: vertex 60000 (allowed: 0 to 55)"},
        {"LINEDEFS", 14 + 10, 40000, "linedef 1: sidedef 40000 (allowed: 65535 for none, or 0 to 31)"},
        {"SIDEDEFS", 30 + 28, 5, "sidedef 1: sector 5 (allowed: 0 to 4)"},
    };
    static const struct {
        const char *lump;
        int at;
        long value;  // 32 bits there, in the directory's entry
        const char *expected;
    } ENTRIES[] = {
        {"VERTEXES", 0, 0x7FFFFFFF, "lump VERTEXES: 224 bytes at byte 2147483647 do not lie within the file"},
        {"SIDEDEFS", 4, 0x7FFFFFF0, "lump SIDEDEFS: 2147483632 bytes"},
        {"SECTORS", 4, -2147483647 - 1, "lump SECTORS: -2147483648 bytes"},
        {"LINEDEFS", 4, 15, "lump LINEDEFS: 15 bytes (allowed: up to 65535 records of 14 bytes each)"},
        {"THINGS", 8, 0x41414141, "none of its 6 lumps begins a map"},
        {"SECTORS", 8, 0x41414141, "MAP01 has no lump SECTORS"},
        {"THINGS", 4, 20, NULL},
    };
    Arena arena = {0};
    for (size_t i = 0; i < sizeof RECORDS / sizeof *RECORDS; i++) {
        Bytes file = small_file(&arena, NULL);
        set16(file, wad_lump(file, RECORDS[i].lump, NULL) + RECORDS[i].at, RECORDS[i].value);
        refused(&arena, file, NULL, RECORDS[i].expected);
    }
    for (size_t i = 0; i < sizeof ENTRIES / sizeof *ENTRIES; i++) {
        Bytes file = small_file(&arena, NULL);
        set32(file, entry_of(file, ENTRIES[i].lump) + ENTRIES[i].at, ENTRIES[i].value);
        if (ENTRIES[i].expected) refused(&arena, file, NULL, ENTRIES[i].expected);
    }
    refused(&arena, small_file(&arena, "BEHAVIOR"), NULL, "Hexen's format");
    Bytes file = small_file(&arena, NULL);
    memcpy(file.data + entry_of(file, "THINGS") + 8, "TEXTMAP", 8);
    refused(&arena, file, NULL, "UDMF");
    arena_free(&arena);
}

// Proves the same of headers that lie, and that a file cut off anywhere is refused or read, never more.
Test(wad, cut_and_lying_files) {
    Arena arena = {0};
    static const long COUNTS[] = {-1, 0x7FFFFFFF, 1000000}, PLACES[] = {-1, 0x7FFFFFFF, 0x7FFFFFF0};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 2; k++) {
            Bytes file = small_file(&arena, NULL);
            set32(file, k ? 8 : 4, k ? PLACES[i] : COUNTS[i]);
            refused(&arena, file, NULL, "its directory of");
        }
    }
    Bytes whole = small_file(&arena, NULL);
    for (size_t size = 0; size < whole.size; size += 7) {
        Building b = {0};
        Error error = {""};
        Arena own = {0};
        bool read = MAPS_READER_WAD.read("cut.wad", (Bytes){whole.data, size}, &own, &b, &error);
        cr_expect(!read && error.text[0], "cut to %zu bytes: read %d, `%s`", size, read, error.text);
        arena_free(&own);
    }
    arena_free(&arena);
}

// Proves that a missing wall is noted with its sector and place while the rest opens, and that lines which bound nothing
// are counted.
Test(wad, open_sectors_are_noted) {
    Made m = {.arena = {0}};
    WadMaker maker = {.arena = &m.arena};
    wad_two_rooms(&maker);
    // The hall's southern wall now faces nothing on either side.
    unsigned char *line = maker.lines + 19 * 14;
    memset(line + 10, 0xFF, 4);
    wad_line(&maker, 50, 50, 50, 50, WAD_ROOM, -1, 0, 0);
    wad_line(&maker, 60, 60, 70, 60, WAD_ROOM, WAD_ROOM, 0, 0);
    open_file(&m, write_map(&m.arena, &maker));
    static const char *const EXPECTED[] = {"sector 2 is not closed near", "1 lines have no length",
                                           "1 lines have the same sector on both sides",
                                           "1 lines have no sides"};
    for (size_t i = 0; i < sizeof EXPECTED / sizeof *EXPECTED; i++) {
        bool found = false;
        for (int n = 0; n < m.building.note_count; n++)
            found = found || strstr(m.building.notes[n].text, EXPECTED[i]);
        cr_expect(found, "no note says: %s", EXPECTED[i]);
    }
    for (int s = 0; s < 5; s++) cr_expect(region_of(&m.building, s), "sector %d", s);
    arena_free(&m.arena);
}

// Proves that two rooms with a wall between them that has no thickness open, and that it is told.
Test(wad, walls_without_thickness_are_noted) {
    static const int CORNERS[2][4][2] = {{{0, 0}, {0, 64}, {64, 64}, {64, 0}},
                                         {{64, 0}, {64, 64}, {128, 64}, {128, 0}}};
    Made m = {.arena = {0}};
    WadMaker maker = {.arena = &m.arena};
    for (int room = 0; room < 2; room++) {
        wad_sector(&maker, 0, 100, "CEIL", 0);
        for (int i = 0; i < 4; i++) {
            const int *a = CORNERS[room][i], *b = CORNERS[room][(i + 1) % 4];
            wad_line(&maker, a[0], a[1], b[0], b[1], room, -1, 0, 0);
        }
    }
    open_file(&m, write_map(&m.arena, &maker));
    cr_assert_eq(m.building.note_count, 1);
    cr_expect(strstr(m.building.notes[0].text, "1 walls have no thickness"), "%s", m.building.notes[0].text);
    cr_expect_eq(m.graph.portal_count, 1);
    // Without things one starts in the middle of the first region.
    cr_expect_float_eq(m.building.start.y, 32 * UNIT, 1e-12);
    arena_free(&m.arena);
}

// ---- several maps

// Proves that a map is found by its name, whatever its case, the first one without, that the hash tells them apart, and
// that an unknown name lists those there are.
Test(wad, maps_by_name) {
    Arena arena = {0};
    static const char *const NAMES[] = {"E1M1", "E1M2"};
    WadMaker makers[2] = {{.arena = &arena}, {.arena = &arena}};
    for (int i = 0; i < 2; i++) wad_two_rooms(&makers[i]);
    wad_thing(&makers[1], 30, 30, 90, 2);
    Bytes file = wad_file(makers, NAMES, 2, NULL);
    const char *path = write_wad(&arena, file);
    Building first, second;
    Error error;
    cr_assert(maps_read(path, &arena, &first, &error), "%s", error.text);
    cr_assert(maps_read_map(path, "e1m2", &arena, &second, &error), "%s", error.text);
    cr_expect_str_eq(first.map, "E1M1");
    cr_expect_str_eq(second.map, "E1M2");
    cr_expect_eq(second.viewpoint_count, 3);
    cr_expect_neq(first.hash, second.hash);
    refused(&arena, file, "E2M1", "there is no map `E2M1` (allowed: E1M1, E1M2)");
    char *output;
    int code = support_run(&arena, &output, "%s/enfilade info '%s' --map E1M2 --json", support_build(), path);
    cr_expect_eq(code, 0, "%s", output);
    code = support_run(&arena, &output, "%s/enfilade info '%s' --map E9M9", support_build(), path);
    cr_expect(code == 1 && strstr(output, "allowed: E1M1, E1M2"), "%s", output);
    arena_free(&arena);
}

// Proves that a round hall of more corners than a region may have becomes several regions that are all of it. Tolerance: corners are
// whole millimetres, along 1,250 m of wall.
Test(wad, round_halls_are_parted) {
    enum { CORNERS = 100 };
    Made m = {.arena = {0}};
    WadMaker maker = {.arena = &m.arena};
    int x[CORNERS], y[CORNERS], sector = wad_sector(&maker, 0, 128, "FLAT", 0);
    double area = 0;
    for (int i = 0; i < CORNERS; i++) {
        double angle = -2 * M_PI * i / CORNERS;  // clockwise: the hall is to the right
        x[i] = (int)lrint(6400 * cos(angle));
        y[i] = (int)lrint(6400 * sin(angle));
    }
    for (int i = 0; i < CORNERS; i++) {
        int k = (i + 1) % CORNERS;
        wad_line(&maker, x[i], y[i], x[k], y[k], sector, -1, 0, 0);
        area += ((double)x[k] * y[i] - (double)x[i] * y[k]) / 2 * UNIT * UNIT;
    }
    wad_thing(&maker, 0, 0, 90, 1);
    open_file(&m, write_map(&m.arena, &maker));
    cr_expect_gt(m.building.region_count, 1);
    for (int i = 0; i < m.building.region_count; i++)
        cr_expect_leq(m.building.rings[m.building.regions[i].first_ring].point_count, 60);
    cr_expect_float_eq(area_of_sector(&m.building, sector), area, 1250 * 0.001, "%g of %g m2",
                       area_of_sector(&m.building, sector), area);
    arena_free(&m.arena);
}
