// test_sh3d_openings.c - doors and windows of homes.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "maps/sweethome/sh3d.h"
#include "tests/maps/sweethome/sh3d_fixture.h"
#include "tests/support/files/home_fixture.h"

// ---- openings

typedef struct OpeningCase {
    const char *attributes, *sashes;
    OpeningKind kind;
    bool glazed;
    int hinge;
    double swing;
} OpeningCase;

// The kind of a piece, and how it turns, follow from its size, its sashes, its mirroring and its name.
Test(sh3d, kinds_and_swings_of_openings) {
    static const OpeningCase CASES[] = {
        {"name='Door' height='208'", HOME_SASH_LEFT, OPENING_DOOR, false, 0, -M_PI / 2},
        {"name='Door' height='208' modelMirrored='true'", HOME_SASH_LEFT, OPENING_DOOR, false, 1, M_PI / 2},
        {"name='Door' height='208'", HOME_SASH_RIGHT, OPENING_DOOR, false, 1, M_PI / 2},
        {"name='Double' height='208'", HOME_SASH_RIGHT HOME_SASH_LEFT, OPENING_DOOR, false, 2, -M_PI / 2},
        {"name='Porte-fenêtre' height='200' elevation='11'", HOME_SASH_LEFT, OPENING_DOOR, true, 0,
         -M_PI / 2},
        {"name='x' catalogId='eTeks#sliderWindow126x200' height='210'", "", OPENING_DOOR, true, 0, -M_PI / 2},
        {"name='Garage' height='208'", "", OPENING_DOOR, false, 0, -M_PI / 2},
        {"name='Türrahmen' height='208'", "", OPENING_PASSAGE, false, 0, -M_PI / 2},
        {"name='Door frame' height='208'", HOME_SASH_LEFT, OPENING_DOOR, false, 0, -M_PI / 2},
        {"name='Window' height='120' elevation='90'", HOME_SASH_LEFT, OPENING_WINDOW, true, 0, -M_PI / 2},
        {"name='Cat flap' height='40'", "", OPENING_WINDOW, true, 0, 0},
        // Down to the floor: without a sash it does not open, unless its name says that one walks through.
        {"name='x' catalogId='eTeks#fixedWindow85x123' height='210'", "", OPENING_WINDOW, true, 0, 0},
        {"name='Festes Fenster' height='210'", "", OPENING_WINDOW, true, 0, 0},
        {"name='Window' height='210'", HOME_SASH_LEFT, OPENING_DOOR, true, 0, -M_PI / 2},
        {"name='Porte-fenêtre' height='210'", "", OPENING_DOOR, true, 0, -M_PI / 2},
        {"name='Window' catalogId='a#sliding' height='210'", "", OPENING_DOOR, true, 0, -M_PI / 2},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Home h = home_of(HOME_ROOM "<doorOrWindow x='100' y='0' width='90' depth='10' %s>%s</doorOrWindow>",
                         CASES[i].attributes, CASES[i].sashes);
        cr_assert(h.good, "%s", h.error.text);
        cr_assert_eq(h.sketch.opening_count, 1);
        const SketchOpening *o = &h.sketch.openings[0];
        cr_assert_eq(o->kind, CASES[i].kind, "case %zu: %s", i, opening_kind_name(o->kind));
        cr_assert_eq(o->glazed, CASES[i].glazed, "case %zu", i);
        cr_assert_eq(o->hinge, CASES[i].hinge, "case %zu: hinge %d", i, o->hinge);
        cr_assert_float_eq(o->swing, CASES[i].swing, 1e-6, "case %zu: swing %g", i, o->swing);
        cr_assert_eq(h.b.object_count, 0, "a missing model fills no hole");
        home_free(&h);
    }
}

// The model decides where its parts are named: panes alone do not open, whatever the name; parts on rails do.
Test(sh3d, models_tell_fixed_windows) {
    static const struct {
        const char *name, *parts;
        OpeningKind kind;
    } CASES[] = {{"front", "sweethome3d_window_pane", OPENING_WINDOW},
                 {"window", "sweethome3d_window_pane", OPENING_WINDOW},
                 {"window", "frame", OPENING_WINDOW},
                 {"front", "frame", OPENING_DOOR},
                 {"window", "sweethome3d_window_pane_on_rail_1", OPENING_DOOR},
                 {"window", "sweethome3d_opening_on_hinge_1", OPENING_DOOR},
                 {"patio", "sweethome3d_window_pane", OPENING_DOOR}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        char xml[1024], model[200];
        snprintf(model, sizeof model, "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0.1\ng %s\nf 1 2 3 4\nf 1 2 4\n",
                 CASES[i].parts);
        snprintf(xml, sizeof xml,
                 "<home wallHeight='250'>" HOME_ROOM
                 "<doorOrWindow name='%s' model='1' x='100' y='0' width='90' "
                 "depth='10' height='210'/></home>",
                 CASES[i].name);
        HomeEntry entries[] = {{"Home.xml", xml, strlen(xml)}, {"1", model, strlen(model)}};
        Home h = home_of_zip(entries, 2);
        cr_assert(h.good, "%s", h.error.text);
        cr_expect_eq(h.sketch.openings[0].kind, CASES[i].kind, "case %zu", i);
        home_free(&h);
    }
}

// Only the part in the wall is cut: counted from the back and from the top, mirrored with the model.
Test(sh3d, part_of_an_opening_in_the_wall) {
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        Home h = home_of(HOME_ROOM "<doorOrWindow name='Open door' x='200' y='100' angle='1.5707964' "
                                   "width='100' depth='80' height='200' "
                                   "elevation='10' wallThickness='0.25' wallDistance='0.125' wallWidth='0.5' "
                                   "wallLeft='0.1' wallHeight='0.8' "
                                   "wallTop='0.1' modelMirrored='%s' cutOutShape='M0,0 v1 h1 z'/>",
                         mirrored ? "true" : "false");
        cr_assert(h.good, "%s", h.error.text);
        const SketchOpening *o = &h.sketch.openings[0];
        // A quarter turn clockwise on the screen: its right points down (-y), its back to the right (+x).
        // Along its right: (0.1 + 0.25 - 0.5) * 1 m = -0.15; to its back: (0.5 - 0.125 - 0.125) * 0.8 = 0.2.
        assert_vec2(o->centre, 2.2, mirrored ? -1.15 : -0.85);
        cr_assert_float_eq(o->angle, -M_PI / 2, CLOSE);
        cr_assert_float_eq(o->width, 0.5, CLOSE);
        cr_assert_float_eq(o->depth, 0.2, CLOSE);
        cr_assert_float_eq(o->head, 0.1 + 2 * 0.9, CLOSE);
        cr_assert_float_eq(o->sill, 0.1 + 2 * 0.1, CLOSE);
        cr_assert_eq(o->cutout_count, 3);
        double x = 0;
        for (int i = 0; i < 3; i++) x += h.sketch.points[o->first_cutout + i].x / 3;
        cr_assert_float_eq(x, mirrored ? 2.0 / 3 : 1.0 / 3, CLOSE,
                           "the triangle leans to its left, or right");
        home_free(&h);
    }
}

// Paths of every command, and nonsense.
Test(sh3d, shapes) {
    static const struct {
        const char *path;
        double area;  // signed in the path's own sense, 0: refused
    } CASES[] = {
        {"M0,0 v1 h1 v-1 z", -1},
        {"m 0 0 1 0 0 1 -1 0", 1},
        {"M0 0L1 0L1 1L0 1Z", 1},
        {"M0,0H1V1H0z M.25.25h.5v.5h-.5z", 1},
        {"M0,0.5 a0.5,0.5 0 1,0 1,0 a0.5,0.5 0 1,0 -1,0 z", -0.7765},  // 24 chords of a circle
        {"M0,1 a0.5,0.997 0 1,1 1,0 z", 0.7742},
        {"M0 0C0 1 1 1 1 0Z", -0.5845},
        {"M0 0Q.5 1 1 0Z", -0.328125},
        {"", 0},
        {"M", 0},
        {"M0", 0},
        {"M0,0", 0},
        {"M0,0 v1", 0},
        {"hello", 0},
        {"M0,0 1", 0},
        {"M0 0 v1e9 h1 z", 0},
        {"M0,0 a1", 0},
        {"M0,0 a1,1 0 2,1 1,0 z", 0},
        {"M0 0 S 1 1 2 2 z", 0},
        {"z z z", 0},
        {"M0 0 z 1 1", 0},
        {"M nan 0 h1 v1 z", 0},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Vec2 shape[SH3D_MAX_SHAPE];
        int count = sh3d_shape(CASES[i].path, shape, SH3D_MAX_SHAPE);
        double area = count ? sh3d_shape_area(shape, count) : 0;
        cr_assert_float_eq(area, CASES[i].area, 5e-4, "%s: area %.6f in %d points", CASES[i].path, area,
                           count);
    }
}
