// test_prt.c - the reader of portal files.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/quake/prt.h"
#include "tests/support/files/soups.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_PRT;

// Two cells with a window of 64 x 32 units between them; the file's normal, (p0 - p1) x (p2 - p1), points along +x
// into cell 0.
#define WINDOW "(0 0 0 ) (0 0 32 ) (0 64 32 ) (0 64 0 )"

static void refuse(const char *text, const char *expected) {
    soups_refuse(&MAPS_READER_PRT, "t.prt", text, expected);
}

static void accept(Arena *arena, const char *text, Building *b) {
    soups_accept(&MAPS_READER_PRT, "t.prt", text, arena, b);
}

// Units become metres, and corners run counter-clockwise seen from the first cell: the plane's normal, by our
// convention, points into it, as the file's does.
Test(prt, portal) {
    Arena arena = {0};
    Building b;
    accept(&arena, "PRT1\n2\n1\n4 0 1 " WINDOW "\n", &b);
    cr_assert(b.form == FORM_CELLS && b.given_cell_count == 2 && b.given_portal_count == 1);
    const GivenPortal *p = &b.given_portals[0];
    cr_assert(p->cell[0] == 0 && p->cell[1] == 1 && p->vertex_count == 4);
    const Vec3 *v = &b.vertices[p->first_vertex];
    Vec3 file[3] = {{0, 0, 0}, {0, 0, 1}, {0, 2, 1}};
    Vec3 into = vec3_cross(vec3_sub(file[0], file[1]), vec3_sub(file[2], file[1]));
    cr_expect_gt(vec3_dot(plane_of_polygon(v, 4).n, into), 0);
    cr_expect_float_eq(polygon_area(v, 4), 2, 1e-12);
    arena_free(&arena);
}

// Blanks, tabs, carriage returns, empty lines and a missing line end change nothing; nor does a blank before `)`.
Test(prt, spelling) {
    static const char *const TEXTS[] = {
        "PRT1\r\n2\r\n1\r\n4 0 1 " WINDOW "\r\n",
        "\n PRT1 \n\n2\n\n1\n\n\t4\t0 1 (0 0 0) (0 0 32)(0 64 32)  ( 0 64 0 )",
        "PRT1\n2\n1\n4 0 1 (0.0 -0 0e0 ) (0 0 3.2e1 ) (0 64.000 32 ) (0 +64 0 ) \n\n\n",
    };
    Arena arena = {0};
    Building first;
    accept(&arena, "PRT1\n2\n1\n4 0 1 " WINDOW "\n", &first);
    for (size_t i = 0; i < sizeof TEXTS / sizeof *TEXTS; i++) {
        Building b;
        accept(&arena, TEXTS[i], &b);
        cr_assert_eq(b.given_portal_count, 1, "%s", TEXTS[i]);
        for (int k = 0; k < 4; k++) cr_expect(vec3_equal(b.vertices[k], first.vertices[k]), "%s", TEXTS[i]);
    }
    arena_free(&arena);
}

// Portals through which nothing is seen are left out, which is said; cells without portals stay.
Test(prt, areas_of_nothing) {
    Arena arena = {0};
    Building b;
    accept(&arena,
           "PRT1\n5\n3\n3 0 1 (0 0 0 ) (0 0 0 ) (0 0 0 )\n4 2 3 " WINDOW
           "\n3 0 1 (0 0 0 ) (0 0 8 ) (0 0 16 )\n",
           &b);
    cr_expect(b.given_cell_count == 5 && b.given_portal_count == 1 && b.given_portals[0].cell[0] == 2);
    cr_expect_eq(soups_notes(&b, "2 portals have no area"), 1);
    accept(&arena, "PRT1\n1\n0\n", &b);
    cr_expect(b.given_cell_count == 1 && b.given_portal_count == 0);
    arena_free(&arena);
}

// PRT2 and PRT1-AM tell the same: two cells, the first of two leaves.
Test(prt, leaves_of_cells) {
    static const char *const TEXTS[] = {"PRT2\n3\n2\n1\n4 0 1 " WINDOW "\n2 0 -1\n1 -1\n",
                                        "PRT1-AM\n2\n1\n3\n4 0 1 " WINDOW "\n0\n1\n0\n"};
    for (int i = 0; i < 2; i++) {
        Arena arena = {0};
        Building b = {0};
        PrtLeaves leaves;
        Error error = {""};
        Bytes content = {(unsigned char *)arena_string(&arena, TEXTS[i]), strlen(TEXTS[i])};
        cr_assert(prt_read("t.prt", content, &arena, &b, &leaves, &error), "%s", error.text);
        cr_expect(b.given_cell_count == 2 && b.given_portal_count == 1 && leaves.count == 3);
        cr_expect(leaves.cell[0] == 0 && leaves.cell[1] == 1 && leaves.cell[2] == 0);
        arena_free(&arena);
    }
}

// A portal file in a unit of its own keeps its smallest portals: one of a thousandth of a unit stays, a line of corners does not.
Test(prt, small_portals) {
    Arena arena = {0};
    Building b;
    accept(&arena,
           "PRT1\n2\n2\n4 0 1 (0 0 0 ) (0 0 1e-3 ) (0 1e-3 1e-3 ) (0 1e-3 0 )\n3 0 1 (0 0 0 ) (0 1 1 ) (0 2 "
           "2 )\n",
           &b);
    cr_expect_eq(b.given_portal_count, 1);
    cr_expect_eq(soups_notes(&b, "1 portals have no area"), 1);
    arena_free(&arena);
}

// Every fault is refused with its line, what was found and what is allowed.
Test(prt, faults) {
    static const struct {
        const char *text, *expected;
    } CASES[] = {
        {"", "t.prt: is empty (expected PRT1)"},
        {"PRT3\n", "t.prt:1: begins with `PRT3` (allowed PRT1, PRT2 and PRT1-AM)"},
        {"PRT2\n", "t.prt: ends before the number of leaves"},
        {"PRT2\n0\n2\n1\n", "t.prt:2: the number of leaves is `0` (allowed 1 to 1048576)"},
        {"PRT1-AM\n2\n1\n", "t.prt: ends before the number of leaves"},
        {"PRT2\n3\n2\n1\n4 0 1 " WINDOW "\n0 1 -1\n", "t.prt:7: ends within the leaves of cell 1"},
        {"PRT2\n3\n2\n1\n4 0 1 " WINDOW "\n0 1 -1\n3 -1\n", "t.prt:7: a leaf is `3` (allowed -1 to 2)"},
        {"PRT2\n3\n2\n1\n4 0 1 " WINDOW "\n0 1 -1\n-1\n", "t.prt: leaf 2 is in no cell"},
        {"PRT2\n3\n2\n1\n4 0 1 " WINDOW "\n0 1 -1\n2 -1\n7\n", "t.prt:8: found `7` after the last leaf"},
        {"PRT1-AM\n2\n1\n3\n4 0 1 " WINDOW "\n0\n1\n", "ends after the cells of 2 leaves"},
        {"PRT1-AM\n2\n1\n3\n4 0 1 " WINDOW "\n0 1 2\n", "the cell of a leaf is `2` (allowed 0 to 1)"},
        {"PRT1\n", "t.prt: ends before the number of cells"},
        {"PRT1\n2\n", "t.prt: ends before the number of portals"},
        {"PRT1\n0\n0\n", "t.prt:2: the number of cells is `0` (allowed 1 to 65536)"},
        {"PRT1\n-1\n0\n", "the number of cells is `-1`"},
        {"PRT1\n2147483648\n0\n", "the number of cells is `2147483648`"},
        {"PRT1\n2.5\n0\n", "the number of cells is `2.5`"},
        {"PRT1\ntwo\n0\n", "the number of cells is `two`"},
        {"PRT1\n2\n1048577\n", "t.prt:3: the number of portals is `1048577` (allowed 0 to 1048576)"},
        {"PRT1\n2\n2\n4 0 1 " WINDOW "\n", "t.prt:5: ends after 1 portals (its head says 2)"},
        {"PRT1\n2\n1\n4 0 1 " WINDOW "\n4 0 1 " WINDOW "\n", "t.prt:5: found `4` after the last portal"},
        {"PRT1\n2\n0\n4 0 1 " WINDOW "\n",
         "t.prt:4: found `4` after the last portal (its head says 0 portals)"},
        {"PRT1\n2\n1\n2 0 1 (0 0 0 ) (0 0 1 )\n",
         "t.prt:4: the number of a portal's corners is `2` (allowed 3 to 64)"},
        {"PRT1\n2\n1\n65 0 1 " WINDOW "\n", "the number of a portal's corners is `65`"},
        {"PRT1\n2\n1\n5 0 1 " WINDOW "\n", "t.prt:4: found `the end of the line` (expected `(`"},
        {"PRT1\n2\n1\n3 0 1 " WINDOW "\n", "t.prt:4: found `(0` after the portal's 3 corners"},
        {"PRT1\n2\n1\n4 0 2 " WINDOW "\n", "t.prt:4: a portal's cell is `2` (allowed 0 to 1)"},
        {"PRT1\n2\n1\n4 -1 1 " WINDOW "\n", "a portal's cell is `-1`"},
        {"PRT1\n2\n1\n4 1 1 " WINDOW "\n", "t.prt:4: the portal leads from cell 1 to itself"},
        {"PRT1\n2\n1\n3 0 1 (0 0 nan ) (0 0 1 ) (0 1 0 )\n", "a coordinate is `nan`"},
        {"PRT1\n2\n1\n3 0 1 (0 0 1e999 ) (0 0 1 ) (0 1 0 )\n", "a coordinate is `1e999`"},
        {"PRT1\n2\n1\n3 0 1 (0 0 1e9 ) (0 0 1 ) (0 1 0 )\n",
         "a coordinate is `1e9` (allowed -1e+08 to 1e+08)"},
        {"PRT1\n2\n1\n3 0 1 (0 0 0x10 ) (0 0 1 ) (0 1 0 )\n", "a coordinate is `0x10`"},
        {"PRT1\n2\n1\n3 0 1 (0 0) (0 0 1 ) (0 1 0 )\n", "a coordinate is `)`"},
        {"PRT1\n2\n1\n3 0 1 (0 0 0 0 ) (0 0 1 ) (0 1 0 )\n", "found `0` (expected `)`"},
        {"PRT1\n2\n1\n4 0 1 (0 0 0 ) (0 0 32 ) (8 64 32 ) (0 64 0 )\n", "t.prt:4: the portal bends by"},
        {"PRT1\n2\n1\n4 0 1 (0 0 0 ) (0 8 8 ) (0 0 32 ) (0 64 0 )\n",
         "t.prt:4: the portal is not convex: a corner lies"},
        {"PRT1\n2\n1\n5 0 1 (0 0 40 ) (0 24 -32 ) (0 -38 12 ) (0 38 12 ) (0 -24 -32 )\n", "is not convex"},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) refuse(CASES[i].text, CASES[i].expected);
}

// The portal files of real maps, or of homes where those are absent, come in whole, as their heads say.
Test(prt, real_maps) {
    static const char *const MAPS[] = {"dm4",
                                       "e1m1",
                                       "lq_e1m5_omitdetail",
                                       "lq_e2m2_nodetail",
                                       "lq_e3m6_nodetail",
                                       "lqdm13_omitdetail",
                                       "lqdm2_omitdetail"};
    for (size_t i = 0; i < sizeof MAPS / sizeof *MAPS; i++) {
        Arena arena = {0};
        Building b;
        Error error = {""};
        const char *path =
            prt_file(&arena, MAPS[i], i % 2 ? "build/maps/hillside.sh3d" : "build/maps/villa.sh3d");
        int cells, portals;
        cr_assert_eq(sscanf((const char *)support_read(&arena, path).data, "PRT1 %d %d", &cells, &portals),
                     2);
        cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
        cr_expect_eq(b.given_cell_count, cells);
        int left_out = b.note_count > 0 ? atoi(strstr(b.notes[0].text, ".prt: ") + 6) : 0;
        cr_expect_eq(b.given_portal_count + left_out, portals, "%s", MAPS[i]);
        arena_free(&arena);
    }
}

Test(prt, survives_damage, .timeout = 120) {
    static const char TEXT[] = "PRT1\n3\n2\n4 0 1 " WINDOW "\n3 1 2 (64 0 0 ) (64 0 32 ) (64 64 0 )\n";
    soups_damage(&MAPS_READER_PRT, "t.prt", TEXT, sizeof TEXT - 1, 29, support_count(4000, 400000));
}
