// test_ifc_building.c - building models as buildings: spaces as rooms, doors that join them, storeys, sites, units, files without
// spaces or walls, and real files.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "tests/maps/ifc/house_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_IFC;

// The names of what an opening joins, in either order.
static bool joins(const Building *b, const Opening *o, const char *one, const char *other) {
    const char *name[2];
    for (int i = 0; i < 2; i++) {
        if (o->region[i] < 0) return false;
        const Region *r = &b->regions[o->region[i]];
        name[i] = r->kind == REGION_OUTDOORS ? "outdoors" : r->name;
    }
    return (strcmp(name[0], one) == 0 && strcmp(name[1], other) == 0) ||
           (strcmp(name[0], other) == 0 && strcmp(name[1], one) == 0);
}

static void expect_two_rooms(const Building *b) {
    cr_expect_eq(b->storey_count, 1);
    cr_expect_str_eq(b->storeys[0].name, "ground floor");
    cr_expect_float_eq(b->storeys[0].height, 2.5, 1e-9);
    const Region *west = house_room(b, "1 west"), *east = house_room(b, "2 east");
    // Tolerance: a millimetre, the grid of plans, along each side.
    cr_expect_float_eq(fixture_region_area(b, west), 12, 0.014);
    cr_expect_float_eq(fixture_region_area(b, east), 12, 0.014);
    cr_expect_float_eq(west->z1 - west->z0, 2.5, 1e-9);
    cr_expect(joins(b, house_opening(b, "inner door"), "1 west", "2 east"));
    cr_expect(joins(b, house_opening(b, "front door"), "1 west", "outdoors"));
    cr_expect(joins(b, house_opening(b, "north window"), "2 east", "outdoors"));
    cr_expect_eq(house_opening(b, "inner door")->kind, OPENING_DOOR);
    cr_expect_eq(house_opening(b, "north window")->kind, OPENING_WINDOW);
    cr_expect_eq(house_notes(b, "joins"), 0);
    cr_expect_eq(house_notes(b, "nowhere"), 0);
}

// The middle of a leaf's free end when it is wide open.
static Vec2 open_end(const Building *b, const Opening *o) {
    const Leaf *leaf = &b->leaves[o->first_leaf];
    Vec3 at = leaf_point(leaf, 1, vec3(leaf->axis[1].x, leaf->axis[1].y, 1));
    return vec2(at.x, at.y);
}

// Rooms, doors and windows of a house of two rooms; the leaves are those of the file and turn as it says.
Test(ifc_building, two_rooms) {
    Arena arena = {0};
    Building b;
    House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
    house_read(&arena, house_end(&h), &b);
    expect_two_rooms(&b);
    const Opening *inner = house_opening(&b, "inner door"), *front = house_opening(&b, "front door");
    cr_assert_eq(inner->leaf_count, 1);
    // Hung at its southern end, it opens west: its free end goes from (4.1, 1.84) to (3.3, 1).
    Vec2 end = open_end(&b, inner);
    cr_expect(end.x < 3.5 && end.y < 1.2, "%g %g", end.x, end.y);
    // Hung at the right end as seen along its y axis, it opens north, into the house.
    end = open_end(&b, front);
    cr_expect(end.x > 1.8 && end.y > 0.5, "%g %g", end.x, end.y);
    int leaves = 0, frames = 0;
    for (int i = 0; i < b.object_count; i++) {
        leaves += b.objects[i].kind == OBJECT_LEAF;
        frames += b.objects[i].kind == OBJECT_FRAME;
    }
    cr_expect_eq(leaves, 2, "the leaf is a part of the door's body, and moves");
    cr_expect_eq(frames, 4, "two linings, a window's frame and its pane");
    cr_expect(b.site.placed);
    cr_expect_float_eq(b.site.latitude, 50.5 * M_PI / 180, 1e-9);
    arena_free(&arena);
}

// A house of one room, 8 x 3 m.
static House hall(Arena *arena, int walls[4]) {
    House h = house_begin(arena, false, vec2(0, 0), 0);
    int ground = house_storey(&h, "ground floor", 0);
    house_walls(&h, ground, vec3(0, 0, 0), vec3(8, 3, 2.5), walls);
    house_space(&h, "1", "hall", ground, vec3(0, 0, 0), vec3(8, 3, 2.5));
    return h;
}

// Two leaves that touch hang at either end and open to the same side; a sliding one goes aside.
Test(ifc_building, double_and_sliding) {
    Arena arena = {0};
    Building b;
    int walls[4];
    House h = hall(&arena, walls);
    int hole = house_hole(&h, walls[0], vec3(1, -0.3, 0), vec3(3, 0.1, 2.1));
    house_door(&h, hole, "double", vec3(1, -0.1, 0), vec2(1, 0), 2, 2.1, "DOUBLE_DOOR_SINGLE_SWING");
    hole = house_hole(&h, walls[0], vec3(5, -0.3, 0), vec3(6, 0.1, 2.1));
    house_door(&h, hole, "sliding", vec3(5, -0.1, 0), vec2(1, 0), 1, 2.1, "SLIDING_TO_RIGHT");
    house_read(&arena, house_end(&h), &b);
    const Opening *o = house_opening(&b, "double");
    cr_assert_eq(o->leaf_count, 2);
    for (int i = 0; i < 2; i++) {
        const Leaf *leaf = &b.leaves[o->first_leaf + i];
        Vec3 end = leaf_point(leaf, 1, vec3(leaf->axis[1].x, leaf->axis[1].y, 1));
        cr_expect(end.y > 0.7, "it opens into the house: %g", end.y);
        cr_expect(fabs(end.x - (i ? 2.94 : 1.06)) < 0.1, "leaf %d hangs at its end: %g", i, end.x);
    }
    o = house_opening(&b, "sliding");
    cr_assert_eq(o->leaf_count, 1);
    cr_expect_float_eq(b.leaves[o->first_leaf].slide.x, 1, 1e-6);
    arena_free(&arena);
}

// A leaf that touches its lining moves without it. The door closes within the leaf, wherever that lies in the wall and whatever sticks out
// of it, so that no dark gap is left between the leaf and what closes the door.
Test(ifc_building, leaf_touches_its_lining) {
    Arena arena = {0};
    Building b;
    int walls[4];
    House h = hall(&arena, walls);
    int hole = house_hole(&h, walls[0], vec3(1, -0.3, 0), vec3(2, 0.1, 2.1));
    house_tight_door(&h, hole, "tight", vec3(1, -0.06, 0), vec2(1, 0), 1, 2.1);
    house_read(&arena, house_end(&h), &b);
    const Opening *o = house_opening(&b, "tight");
    cr_assert_eq(o->leaf_count, 1);
    double width = vec2_length(vec2_sub(b.leaves[o->first_leaf].axis[1], b.leaves[o->first_leaf].axis[0]));
    cr_expect_float_eq(width, 0.9, 1e-6, "the posts stay: %g", width);
    // The leaf reaches from 5 to 1 cm before the wall's inner face; a millimetre is the grid of plans.
    for (int end = 0; end < 2; end++)
        cr_expect_float_eq(o->line[end].y, -0.03, 0.0011, "closes at %g", o->line[end].y);
    arena_free(&arena);
}

// A pane without a style of its own is seen through.
Test(ifc_building, panes_are_glass) {
    Arena arena = {0};
    Building b;
    House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
    house_read(&arena, house_end(&h), &b);
    int clear = 0;
    for (int i = 0; i < b.object_count; i++)
        for (int k = 0; k < b.objects[i].polygon_count; k++)
            clear += b.materials[b.polygons[b.objects[i].first_polygon + k].material].alpha < 1;
    cr_expect_eq(clear, 6, "the six sides of the pane: %d", clear);
    arena_free(&arena);
}

// A site far away and turned, and a file in feet, make the same rooms.
Test(ifc_building, site_and_units) {
    static const struct {
        bool feet;
        Vec2 site;
        double turn;
    } CASES[] = {
        {false, {4500000, 5400000}, 0}, {false, {0, 0}, 0.5}, {true, {0, 0}, 0}, {true, {300000, 100}, 2.2}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        House h = house_two_rooms(&arena, CASES[i].feet, CASES[i].site, CASES[i].turn, true);
        house_read(&arena, house_end(&h), &b);
        expect_two_rooms(&b);
        cr_expect(fabs(b.start.x) < 1e5, "case %zu: coordinates count from near the house: %g", i, b.start.x);
        arena_free(&arena);
    }
}

// Without spaces the walls make the rooms, without walls the spaces; without either the bodies are all there is.
Test(ifc_building, without_spaces_or_walls) {
    Arena arena = {0};
    Building b;
    House h = house_two_rooms(&arena, false, vec2(0, 0), 0, false);
    house_read(&arena, house_end(&h), &b);
    const Opening *inner = house_opening(&b, "inner door");
    cr_assert(inner->region[0] >= 0 && inner->region[1] >= 0);
    cr_expect_neq(inner->region[0], inner->region[1]);
    for (int i = 0; i < 2; i++) cr_expect_eq(b.regions[inner->region[i]].kind, REGION_ROOM);
    cr_expect_float_eq(b.storeys[0].height, 2.5, 1e-9, "walls tell the height");

    h = house_begin(&arena, false, vec2(0, 0), 0);
    int ground = house_storey(&h, "ground floor", 0);
    house_space(&h, "1", "west", ground, vec3(0, 0, 0), vec3(4, 3, 2.5));
    house_space(&h, "2", "east", ground, vec3(4, 0, 0), vec3(8, 3, 2.5));
    house_read(&arena, house_end(&h), &b);
    house_room(&b, "1 west");
    house_room(&b, "2 east");

    // Walls too low to bound anything are bodies as well.
    for (int low_wall = 0; low_wall < 2; low_wall++) {
        h = house_begin(&arena, false, vec2(0, 0), 0);
        ground = house_storey(&h, "ground floor", 0);
        house_box(&h, low_wall ? "IFCWALL" : "IFCSLAB", "body", ground, vec3(0, 0, 0), vec3(4, 3, 0.2));
        house_read(&arena, house_end(&h), &b);
        cr_expect_eq(b.form, FORM_SOUP);
        cr_expect_eq(b.polygon_count, 6);
    }
    arena_free(&arena);
}

// An upper storey over a slab with a hole: a shaft joins the rooms; the slab's balcony is there.
Test(ifc_building, upper_storey) {
    Arena arena = {0};
    Building b;
    House h = house_begin(&arena, false, vec2(0, 0), 0);
    int walls[4], ground = house_storey(&h, "ground floor", 0), upper = house_storey(&h, "upper floor", 2.8);
    house_walls(&h, ground, vec3(0, 0, 0), vec3(6, 4, 2.5), walls);
    house_walls(&h, upper, vec3(0, 0, 2.8), vec3(6, 4, 5.3), walls);
    house_space(&h, "0.1", "below", ground, vec3(0, 0, 0), vec3(6, 4, 2.5));
    house_space(&h, "1.1", "above", upper, vec3(0, 0, 2.8), vec3(6, 4, 5.3));
    int slab = house_box(&h, "IFCSLAB", "slab", upper, vec3(-0.2, -2, 2.5), vec3(6.2, 4.2, 2.8));
    house_hole(&h, slab, vec3(1, 1, 2.4), vec3(3, 2, 2.9));
    house_box(&h, "IFCSTAIR", "stair", ground, vec3(1, 1, 0), vec3(3, 2, 2.8));
    house_read(&arena, house_end(&h), &b);
    cr_assert_eq(b.storey_count, 2);
    cr_expect_str_eq(b.storeys[1].name, "upper floor");
    cr_expect_float_eq(b.storeys[1].floor, 2.8, 1e-9);
    cr_expect_float_eq(b.storeys[1].slab, 0.3, 1e-9);
    cr_expect_float_eq(house_room(&b, "1.1 above")->z0, 2.8, 1e-9);
    double shaft = 0, balcony = 0;
    for (int i = 0; i < b.region_count; i++)
        if (b.regions[i].kind == REGION_SHAFT) shaft += fixture_region_area(&b, &b.regions[i]);
    for (int i = 0; i < b.object_count; i++) {
        const Object *o = &b.objects[i];
        if (o->kind != OBJECT_LOW_WALL || strcmp(o->name, "slab") != 0) continue;
        for (int k = 0; k < o->polygon_count; k++) {
            const Polygon *p = &b.polygons[o->first_polygon + k];
            const Vec3 *v = &b.vertices[p->first_vertex];
            if (plane_of_polygon(v, p->vertex_count).n.z > 0.9) balcony += polygon_area(v, p->vertex_count);
        }
    }
    cr_expect_float_eq(shaft, 2, 0.01);
    cr_expect_float_eq(balcony, 6.4 * 1.8, 0.02);
    arena_free(&arena);
}

// Under a ceiling that hangs low the stair's hole goes up to the next floor, over all steps below it. `whole`: they are parts of one stair.
static void expect_stair_hole(bool whole) {
    Arena arena = {0};
    Building b;
    House h = house_begin(&arena, false, vec2(0, 0), 0);
    int walls[4], ground = house_storey(&h, "ground floor", 0), upper = house_storey(&h, "upper floor", 4.2);
    house_walls(&h, ground, vec3(0, 0, 0), vec3(8, 4, 4), walls);
    house_walls(&h, upper, vec3(0, 0, 4.2), vec3(8, 4, 6.7), walls);
    house_space(&h, "0.1", "below", ground, vec3(0, 0, 0), vec3(8, 4, 2.5));
    house_space(&h, "1.1", "above", upper, vec3(0, 0, 4.2), vec3(8, 4, 6.7));
    int stair = whole ? house_box(&h, "IFCSTAIR", "stair", ground, vec3(1, 0.9, 0), vec3(6.25, 1, 0.1)) : -1;
    for (int i = 0; i < 21; i++) {
        int step = house_box(&h, "IFCSTAIRFLIGHT", "step", ground, vec3(1 + 0.25 * i, 1, 0.2 * i),
                             vec3(1.25 + 0.25 * i, 2, 0.2 * (i + 1)));
        if (whole) house_part(&h, stair, step);
    }
    house_read(&arena, house_end(&h), &b);
    double shaft = 0;
    for (int i = 0; i < b.region_count; i++) {
        const Region *r = &b.regions[i];
        if (r->kind != REGION_SHAFT) continue;
        cr_expect_float_eq(r->z0, 2.5, 1e-9);
        cr_expect_float_eq(r->z1, 4.2, 1e-9);
        shaft += fixture_region_area(&b, r);
    }
    // Steps from 0.5 m on: 19 of 21, of a quarter of a square metre each.
    cr_expect_float_eq(shaft, 19 * 0.25, 0.3, "%g", shaft);
    arena_free(&arena);
}

Test(ifc_building, low_ceiling) { expect_stair_hole(true); }
// Some files have each flight as a stair of its own.
Test(ifc_building, flights_apart) { expect_stair_hole(false); }

// A window around a corner is cut out of both walls as one large box: in each it ends where the wall does. A foundation under the floor is
// in nobody's way.
Test(ifc_building, corner_window) {
    Arena arena = {0};
    Building b;
    House h = house_begin(&arena, false, vec2(0, 0), 0);
    int walls[4], ground = house_storey(&h, "ground floor", 0);
    house_walls(&h, ground, vec3(0, 0, 0), vec3(4, 3, 2.5), walls);
    house_hole(&h, walls[0], vec3(-1.2, -1.2, 0.9), vec3(1, 1, 2.1));
    house_hole(&h, walls[3], vec3(-1.2, -1.2, 0.9), vec3(1, 1, 2.1));
    house_box(&h, "IFCFOOTING", "foundation", ground, vec3(-0.3, -0.3, -1), vec3(4.3, 3.3, 0));
    house_read(&arena, house_end(&h), &b);
    cr_assert_eq(b.opening_count, 2);
    for (int i = 0; i < 2; i++) {
        const Opening *o = &b.openings[i];
        cr_expect_eq(o->kind, OPENING_WINDOW);
        for (int k = 0; k < 2; k++)
            cr_expect(o->line[k].x > -0.201 && o->line[k].y > -0.201, "opening %d ends at (%g, %g)", i,
                      o->line[k].x, o->line[k].y);
        // The south wall has the corner.
        cr_expect_float_eq(vec2_length(vec2_sub(o->line[1], o->line[0])), i ? 1 : 1.2, 0.01, "opening %d", i);
    }
    for (int i = 0; i < b.object_count; i++)
        if (strcmp(b.objects[i].name, "foundation") == 0) cr_expect_null(b.objects[i].proxy);
    arena_free(&arena);
}

// A space that others cover is a zone; a body without an outline, a niche and a hole for a pipe are told by entity.
Test(ifc_building, left_out) {
    Arena arena = {0};
    Building b;
    House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
    int zone = house_space(&h, "Z", "flat", 0, vec3(0, 0, 0), vec3(8.2, 3, 2.5));
    int wall = house_box(&h, "IFCWALLSTANDARDCASE", "thick", 0, vec3(8.4, 0, 0), vec3(8.9, 3, 2.5));
    int niche = house_hole(&h, wall, vec3(8.3, 1, 0.5), vec3(8.6, 2, 1.5));
    int pipe = house_hole(&h, wall, vec3(8.3, 0.2, 0.5), vec3(9, 0.3, 0.6));
    house_read(&arena, house_end(&h), &b);
    expect_two_rooms(&b);
    cr_expect_eq(house_notes(&b, arena_format(&arena, "#%d space `Z flat` is a zone", zone)), 1);
    cr_expect_eq(house_notes(&b, arena_format(&arena, "stay whole there: #%d opening", niche)), 1);
    cr_expect_eq(house_notes(&b, arena_format(&arena, "left closed: #%d opening", pipe)), 1);
    cr_expect_eq(b.opening_count, 3);
    arena_free(&arena);
}

// A space under a roof, which no wall bounds at its eaves, is a room all the same, though nobody can stand in it upright; without the roof
// it is a terrace. Its slopes are there.
Test(ifc_building, attic) {
    static const double RIDGE[] = {5.5, 5.5, 4.6};  // the floor lies at 2.8
    for (int kind = 0; kind < 3; kind++) {
        Arena arena = {0};
        Building b;
        House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
        int upper = house_storey(&h, "attic", 2.8), roofed = kind > 0;
        double ridge = RIDGE[kind];
        int space = house_attic(&h, "2", "attic", upper, vec3(0, 0, 2.8), vec3(8.2, 3, 3), ridge);
        if (roofed)
            house_box(&h, "IFCROOF", "roof", upper, vec3(-1, -1, ridge + 0.1), vec3(9, 4, ridge + 0.2));
        house_read(&arena, house_end(&h), &b);
        cr_expect_eq(house_notes(&b, arena_format(&arena, "#%d space `2 attic` has no wall along", space)),
                     roofed);
        int rooms = 0, slopes = 0;
        for (int i = 0; i < b.region_count; i++)
            rooms += b.regions[i].kind == REGION_ROOM && strcmp(b.regions[i].name, "2 attic") == 0;
        for (int i = 0; i < b.object_count; i++)
            if (strcmp(b.objects[i].name, "sloped ceiling") == 0) slopes += b.objects[i].polygon_count;
        cr_expect_eq(rooms > 0, roofed);
        cr_expect_eq(slopes, 2);
        arena_free(&arena);
    }
}

// Whatever sides the sheets of a closed body have in the file, their fronts show outwards: light falls on fronts.
Test(ifc_building, fronts_show_outwards) {
    for (unsigned turned = 0; turned < 64; turned += 7) {
        Arena arena = {0};
        Building b;
        House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
        house_sheets(&h, "chest", 0, vec3(1, 1, 0.1), vec3(2, 1.5, 0.9), turned);
        house_read(&arena, house_end(&h), &b);
        int sheets = 0;
        for (int o = 0; o < b.object_count; o++) {
            if (strcmp(b.objects[o].name, "chest") != 0) continue;
            for (int i = 0; i < b.objects[o].polygon_count; i++, sheets++) {
                const Polygon *p = &b.polygons[b.objects[o].first_polygon + i];
                Plane plane = plane_of_polygon(b.vertices + p->first_vertex, p->vertex_count);
                cr_expect_lt(plane_distance(plane, vec3(1.5, 1.25, 0.5)), 0, "sheet %d of %u", i, turned);
            }
        }
        cr_expect_eq(sheets, 6);
        arena_free(&arena);
    }
}

// A light fixture is a lamp.
Test(ifc_building, lamp) {
    Arena arena = {0};
    Building b;
    House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
    house_box(&h, "IFCLIGHTFIXTURE", "pendant", 0, vec3(1.9, 1.4, 2), vec3(2.1, 1.6, 2.3));
    house_read(&arena, house_end(&h), &b);
    cr_assert_eq(b.light_count, 1);
    cr_expect_str_eq(b.lights[0].name, "pendant");
    cr_assert_geq(b.lights[0].object, 0);
    cr_expect_eq(b.objects[b.lights[0].object].kind, OBJECT_LAMP);
    arena_free(&arena);
}

// A damaged file is refused with its line.
Test(ifc_building, damaged) {
    Arena arena = {0};
    House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
    Bytes file = house_end(&h);
    Building b = {.file_size = 1};
    Error error = {""};
    file.size = file.size * 2 / 3;
    bool good = MAPS_READER_IFC.read("t.ifc", file, &arena, &b, &error);
    cr_expect(!good || b.note_count > 0, "what is missing is told");
    if (!good) cr_expect(strstr(error.text, "t.ifc:"), "%s", error.text);
    arena_free(&arena);
}

// Changes a digit, a reference or a letter here and there.
static void damage(Bytes file, Random *random) {
    unsigned char *data = (unsigned char *)file.data;
    for (int changes = 1 + (int)(random_next(random) % 4); changes > 0; changes--) {
        size_t at = 400 + random_next(random) % (file.size - 400);
        while (at + 1 < file.size && !(data[at] >= '0' && data[at] <= '9')) at++;
        static const char WITH[] = "0123456789.-#$*(),'";
        data[at] = (unsigned char)WITH[random_next(random) % (sizeof WITH - 1)];
    }
}

// Whatever digits say, a building comes of it that holds together, or a sentence.
Test(ifc_building, damaged_digits) {
    for (int i = 0; i < support_count(300, 30000); i++) {
        Arena arena = {0};
        Random random = {(uint64_t)i + 1};
        House h = house_two_rooms(&arena, false, vec2(0, 0), 0, true);
        int upper = house_storey(&h, "attic", 2.8);
        house_attic(&h, "3", "attic", upper, vec3(0, 0, 2.8), vec3(8.2, 3, 3), 5.5);
        house_box(&h, "IFCSTAIR", "stair", 0, vec3(1, 1, 0), vec3(3, 2, 2.8));
        int slab = house_box(&h, "IFCSLAB", "slab", upper, vec3(-0.2, -2, 2.5), vec3(8.4, 3.2, 2.8));
        house_hole(&h, slab, vec3(1, 1, 2.4), vec3(3, 2, 2.9));
        Bytes file = house_end(&h);
        damage(file, &random);
        Building b = {.file_size = (double)file.size};
        Error error = {""};
        if (MAPS_READER_IFC.read("t.ifc", file, &arena, &b, &error)) {
            const char *fault = "";
            cr_assert_eq(building_check(&b, &arena, &fault, 1), 0, "case %d: %s", i, fault);
        } else {
            cr_assert(error.text[0], "case %d", i);
        }
        arena_free(&arena);
    }
}

// ---- real files

static void check_real(const char *name, int spaces, int doors) {
    Arena arena = {0};
    Building b;
    Error error;
    const char *path = support_shared(name);
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    int rooms = 0, found = 0, told = house_notes(&b, "not enclosed");
    for (int i = 0; i < b.region_count; i++) {
        bool first = b.regions[i].kind == REGION_ROOM && b.regions[i].name[0];
        for (int k = 0; k < i && first; k++)
            first = b.regions[k].kind != REGION_ROOM || strcmp(b.regions[k].name, b.regions[i].name) != 0;
        rooms += first;
    }
    cr_expect_eq(rooms + told, spaces, "%d rooms, %d spaces told to lie open, of %d", rooms, told, spaces);
    for (int i = 0; i < b.opening_count; i++) {
        const Opening *o = &b.openings[i];
        if (o->kind != OPENING_DOOR) continue;
        found++;
        cr_expect(o->region[0] >= 0 && o->region[1] >= 0 && o->region[0] != o->region[1], "%s joins nothing",
                  o->name);
    }
    cr_expect_eq(found, doors);
    cr_expect_eq(house_notes(&b, "but joins"), 0, "each door joins the spaces on its sides");
    arena_free(&arena);
}

Test(ifc_building, smiley) { check_real("ifc/AC11-Smiley-West.ifc", 70, 85); }
Test(ifc_building, duplex) { check_real("ifc/Duplex_A_20110907.ifc", 21, 14); }
Test(ifc_building, five_rooms) { check_real("ifc/edo_5_rooms_all_objcts_doors.ifc", 5, 4); }
