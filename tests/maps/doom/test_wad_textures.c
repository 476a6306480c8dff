// test_wad_textures.c - pictures of a Doom map, and how they lie on its walls, floors and ceilings.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "maps/maps.h"
#include "tests/maps/doom/wad_fixture.h"
#include "tests/support/files/soups.h"

static Bytes two_rooms_with_pictures(Arena *arena) {
    static const char *const NAMES[] = {"MAP01"};
    WadMaker maker = {.arena = arena};
    wad_two_rooms(&maker);
    return wad_with_pictures(arena, wad_file(&maker, NAMES, 1, NULL));
}

static void read_file(Arena *arena, Bytes file, Building *b) {
    Error error = {""};
    cr_assert(maps_read(wad_write_wad(arena, file), arena, b, &error), "%s", error.text);
}

// The material of the wall of one of the sector's regions through a point of the plan, map units; above an opening or below it.
static int wall_at(const Building *b, int sector, double x, double y, bool upper) {
    char name[32];
    snprintf(name, sizeof name, "sector %d", sector);
    Vec2 p = vec2(UNIT * x, UNIT * y);
    for (int r = 0; r < b->region_count; r++) {
        const Ring *ring = &b->rings[b->regions[r].first_ring];
        for (int i = 0; i < ring->point_count && strcmp(b->regions[r].name, name) == 0; i++) {
            int at = ring->first_point + i, next = ring->first_point + (i + 1) % ring->point_count;
            Vec2 d = vec2_sub(b->points[next], b->points[at]), to = vec2_sub(p, b->points[at]);
            double along = vec2_dot(to, d) / vec2_dot(d, d);
            if (fabs(vec2_cross(to, d)) < 1e-9 && along > 0 && along < 1)
                return upper ? b->edge_upper[at] : b->edge_material[at];
        }
    }
    cr_assert_fail("no wall at (%g, %g)", x, y);
    return -1;
}

// The texel of the material's texture at a point, map units.
static Vec2 texel_at(const Building *b, int material, double x, double y, double z) {
    const Material *m = &b->materials[material];
    cr_assert_gt(m->texture, 0, "%s", m->name);
    const TextureMap *map = &b->texture_maps[m->texture_map];
    const Texture *t = &b->textures[m->texture];
    Vec3 p = vec3(UNIT * x, UNIT * y, UNIT * z);
    return vec2((vec3_dot(map->u, p) + map->u0) * t->width, (vec3_dot(map->v, p) + map->v0) * t->height);
}

static void set_side(Bytes file, int line, int side, int across, int down) {
    unsigned char *l = file.data + wad_lump(file, "LINEDEFS", NULL) + 14 * line;
    unsigned char *s =
        file.data + wad_lump(file, "SIDEDEFS", NULL) + 30 * (l[10 + 2 * side] | l[11 + 2 * side] << 8);
    s[0] = (unsigned char)across, s[2] = (unsigned char)down;
}

static void set_flags(Bytes file, int line, int flags) {
    file.data[wad_lump(file, "LINEDEFS", NULL) + 14 * line + 4] = (unsigned char)flags;
}

// The lines of wad_two_rooms: a wall of the first room, from (0, 0) to (0, 256), floor 0, ceiling 128; the first room's line to the
// door, from (256, 160) to (256, 96), whose ceiling is 0; the hall's to the lift, from (528, 160) to (528, 96), whose floor is 64 and
// whose ceiling is the hall's, 160.
enum { WALL = 0, TO_DOOR = 3, TO_LIFT = 17 };
enum { UPPER_UNPEGGED = 8, LOWER_UNPEGGED = 16 };

// Proves that textures begin at the left end of their line and hang and stand as Doom's rules say, by hand, with offsets of 10 and 20.
// Tolerance: rounding of doubles, coordinates of some 500 texels.
Test(wad_textures, pegging) {
    static const struct {
        const char *what;
        int line, flags;
        bool upper;
        int sector;
        double x, y, z;      // a place on the wall
        double column, row;  // of the texel there
    } CASES[] = {
        {"hangs from the ceiling", WALL, 1, false, WAD_ROOM, 0, 100, 128, 110, 20},
        {"stands on the floor, 96 high", WALL, 1 | LOWER_UNPEGGED, false, WAD_ROOM, 0, 100, 0, 110, 116},
        {"stands on the opening's head", TO_DOOR, 4, true, WAD_ROOM, 256, 130, 0, 40, 92},
        {"hangs from the ceiling", TO_DOOR, 4 | UPPER_UNPEGGED, true, WAD_ROOM, 256, 130, 128, 40, 20},
        {"hangs from the sill", TO_LIFT, 4, false, WAD_HALL, 528, 130, 64, 40, 20},
        {"goes on from the ceiling", TO_LIFT, 4 | LOWER_UNPEGGED, false, WAD_HALL, 528, 130, 64, 40, 116},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        Bytes file = two_rooms_with_pictures(&arena);
        set_side(file, CASES[i].line, 0, 10, 20);
        set_flags(file, CASES[i].line, CASES[i].flags);
        read_file(&arena, file, &b);
        int material = wall_at(&b, CASES[i].sector, CASES[i].x, CASES[i].y, CASES[i].upper);
        Vec2 texel = texel_at(&b, material, CASES[i].x, CASES[i].y, CASES[i].z);
        cr_expect_float_eq(texel.x, CASES[i].column, 1e-9, "%s", CASES[i].what);
        cr_expect_float_eq(texel.y, CASES[i].row, 1e-9, "%s", CASES[i].what);
        arena_free(&arena);
    }
}

// Proves that cells have another wall above an opening than below it: between the hall and the lift, whose ceiling is lowered for this.
Test(wad_textures, cells_have_both) {
    Arena arena = {0};
    Building b;
    CellGraph graph;
    Error error = {""};
    VisOptions options = vis_default_options();
    Bytes file = two_rooms_with_pictures(&arena);
    unsigned char *lift = file.data + wad_lump(file, "SECTORS", NULL) + 26 * WAD_LIFT_SECTOR;
    lift[2] = 150;  // its ceiling
    // No special, so that it stays.
    file.data[wad_lump(file, "LINEDEFS", NULL) + 14 * TO_LIFT + 6] = 0;
    read_file(&arena, file, &b);
    cr_assert(vis_build_cells(&b, &options, &arena, &graph, &error), "%s", error.text);
    int below = 0, above = 0;
    for (int i = 0; i < graph.polygon_count; i++) {
        const Polygon *p = &graph.polygons[i];
        Vec3 middle = vec3(0, 0, 0);
        for (int k = 0; k < p->vertex_count; k++)
            middle = vec3_add(middle,
                              vec3_scale(graph.vertices[p->first_vertex + k], 1 / (UNIT * p->vertex_count)));
        if (fabs(middle.x - 528) > 1e-6 || fabs(middle.y - 128) > 1e-6) continue;
        const char *name = b.textures[b.materials[p->material].texture].name;
        below += fabs(middle.z - 32) < 1e-6 && strcmp(name, "LOWER") == 0;
        above += fabs(middle.z - 155) < 1e-6 && strcmp(name, "UPPER") == 0;
    }
    cr_expect_eq(below, 1);
    cr_expect_eq(above, 1);
    arena_free(&arena);
}

// Proves that flats lie on the world's grid, their rows from north to south, that pictures have the palette's colours and patches their
// places, that materials have the mean as a sector lights it, and that the sky is there.
Test(wad_textures, pictures) {
    Arena arena = {0};
    Building b;
    read_file(&arena, two_rooms_with_pictures(&arena), &b);
    const Region *room = wad_region_of(&b, WAD_ROOM);
    const Material *floor = &b.materials[room->floor_material];
    Vec2 texel = texel_at(&b, room->floor_material, 70, 3, 0);
    cr_expect_float_eq(texel.x, 70, 1e-9);
    cr_expect_float_eq(texel.y, -3, 1e-9);
    const uint8_t *flat = b.textures[floor->texture].texels + 4 * (5 * 64 + 3);
    cr_expect(flat[0] == 13 && flat[1] == 242 && flat[2] == 6 && flat[3] == 255, "colour 3 + 2 * 5");
    // Light 160 is step 5 of 0 to 7.
    cr_expect_float_eq((double)floor->reflectance.g,
                       (0.35 + 0.65 * 5 / 7) * (double)b.textures[floor->texture].mean.g, 1e-6);
    int wall = wall_at(&b, WAD_ROOM, 0, 100, false);
    const Texture *middle = &b.textures[b.materials[wall].texture];
    cr_assert(middle->width == 64 && middle->height == 96);
    cr_expect_eq(middle->texels[4 * (7 * 64 + 40)], 8 + 7, "the second patch begins at column 32");
    const Texture *lower = &b.textures[b.materials[wall_at(&b, WAD_HALL, 528, 130, false)].texture];
    cr_expect_eq(lower->texels[4 * 40], 0, "where no patch lies it is black");
    cr_expect_gt(b.sky_texture, 0);
    cr_expect_eq(b.textures[b.sky_texture].width, 1024);
    cr_expect_eq(soups_notes(&b, "textures are not in the file"), 0);
    arena_free(&arena);
}

// Proves that a file without pictures reads as ever, and that damaged ones cost one note: texture definitions cut short, and a patch
// whose columns lie beyond its end.
Test(wad_textures, damaged_pictures) {
    Arena arena = {0};
    Building b;
    Bytes file = two_rooms_with_pictures(&arena);
    memset(file.data + wad_lump(file, "TEXTURE1", NULL) + 4, 255, 4);
    memset(file.data + wad_lump(file, "PATCH", NULL) + 8, 255, 4);
    read_file(&arena, file, &b);
    cr_expect_eq(
        soups_notes(&b, "1 textures are not in the file, or damaged, and have a colour of their own: MIDDLE"),
        1);
    cr_expect_eq(b.materials[wall_at(&b, WAD_ROOM, 0, 100, false)].texture, 0);
    const Texture *lower = &b.textures[b.materials[wall_at(&b, WAD_HALL, 528, 130, false)].texture];
    cr_expect_eq(lower->texels[4 * 5 * 64], 0, "the first column is lost");
    cr_expect_eq(lower->texels[4 * (5 * 64 + 1)], 6);
    arena_free(&arena);
}
