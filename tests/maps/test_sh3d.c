// test_sh3d.c - Sweet Home 3D files: the plan and the objects read from them, before anything is enclosed. Bad files
// and real homes: test_sh3d_input.c.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "maps/sweethome/sh3d.h"
#include "tests/support/home_fixture.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_SH3D;

static const Vec2 *wall_point(const Home *h, int wall, int i) {
    return &h->sketch.points[h->sketch.walls[wall].first_point + i];
}

static double wall_area(const Home *h, int wall) {
    return sh3d_shape_area(wall_point(h, wall, 0), h->sketch.walls[wall].point_count);
}

// 1e-9 m: what double arithmetic leaves of numbers with few digits.
#define CLOSE 1e-9
#define assert_vec2(p, X, Y)                                                                                 \
    cr_assert(fabs((p).x - (X)) < CLOSE && fabs((p).y - (Y)) < CLOSE, "(%.9g, %.9g) is not (%g, %g)", (p).x, \
              (p).y, (double)(X), (double)(Y))
#define assert_vec3(p, X, Y, Z)                                                                              \
    cr_assert(fabs((p).x - (X)) < CLOSE && fabs((p).y - (Y)) < CLOSE && fabs((p).z - (Z)) < CLOSE,           \
              "(%.9g, %.9g, %.9g) is not (%g, %g, %g)", (p).x, (p).y, (p).z, (double)(X), (double)(Y),       \
              (double)(Z))

// ---- walls

// Four walls in a ring: each outline is a trapezoid whose corners lie on the diagonals, and the four together
// have the area of the frame; sides keep their colours.
Test(sh3d, mitres_of_a_square) {
    Home h = home_of("<wall id='a' wallAtStart='d' wallAtEnd='b' xStart='0' yStart='0' xEnd='400' yEnd='0' "
                     "thickness='20' leftSideColor='FFFF0000' rightSideColor='FF00FF00'/>"
                     "<wall id='b' wallAtStart='a' wallAtEnd='c' xStart='400' yStart='0' xEnd='400' "
                     "yEnd='300' thickness='20'/>"
                     "<wall id='c' wallAtStart='d' wallAtEnd='b' xStart='0' yStart='300' xEnd='400' "
                     "yEnd='300' thickness='20'/>"
                     "<wall id='d' wallAtStart='c' wallAtEnd='a' xStart='0' yStart='300' xEnd='0' yEnd='0' "
                     "thickness='20'/>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.sketch.wall_count, 4);
    // Wall a runs along y = 0; its left is up on the screen, which is outside here: y = +0.1.
    assert_vec2(*wall_point(&h, 0, 0), 0.1, -0.1);
    assert_vec2(*wall_point(&h, 0, 1), 3.9, -0.1);
    assert_vec2(*wall_point(&h, 0, 2), 4.1, 0.1);
    assert_vec2(*wall_point(&h, 0, 3), -0.1, 0.1);
    double area = 0;
    for (int i = 0; i < 4; i++) {
        cr_assert_gt(wall_area(&h, i), 0, "outline %d is counter-clockwise", i);
        area += wall_area(&h, i);
    }
    cr_assert_float_eq(area, 4.2 * 3.2 - 3.8 * 2.8, CLOSE);
    const int *side = h.sketch.edge_material + h.sketch.walls[0].first_point;
    cr_assert_gt(h.b.materials[side[0]].reflectance.g, 0.8f, "the right side is green");
    cr_assert_gt(h.b.materials[side[2]].reflectance.r, 0.8f, "the left side is red");
    cr_assert_float_eq(h.sketch.walls[0].z1, 2.5, CLOSE);
    home_free(&h);
}

// Walls that do not name each other keep square ends; a mitre that would move a corner too far is not made; a
// missing neighbour is noted.
Test(sh3d, walls_that_are_not_mitred) {
    Home h =
        home_of("<wall id='a' wallAtEnd='b' xStart='0' yStart='0' xEnd='400' yEnd='0' thickness='20'/>"
                "<wall id='b' xStart='400' yStart='0' xEnd='400' yEnd='300' thickness='20'/>"
                "<wall id='c' wallAtEnd='d' xStart='0' yStart='900' xEnd='400' yEnd='900' thickness='20'/>"
                "<wall id='d' wallAtStart='c' wallAtEnd='gone' xStart='400' yStart='900' xEnd='0' "
                "yEnd='910' thickness='20'/>");
    cr_assert(h.good, "%s", h.error.text);
    assert_vec2(*wall_point(&h, 0, 1), 4, -0.1);
    assert_vec2(*wall_point(&h, 0, 2), 4, 0.1);
    // One side of c meets its counterpart of d 8 m off; it stays.
    assert_vec2(*wall_point(&h, 2, 1), 4, -9.1);
    cr_assert_geq(home_note(&h, "not in the file and are not joined"), 0);
    home_free(&h);
}

// A quarter turn to the left on the screen about a known centre: all points lie on the two circles, and the area
// is that of the ring's sector up to the chords. More than half a turn bulges the same way.
Test(sh3d, arcs) {
    static const double EXTENT[] = {M_PI / 2, -M_PI / 2, 1.5 * M_PI, -1.5 * M_PI, 0.01, 3.1415927};
    for (size_t k = 0; k < sizeof EXTENT / sizeof *EXTENT; k++) {
        Home h = home_of(
            "<wall id='a' xStart='0' yStart='0' xEnd='400' yEnd='0' thickness='20' arcExtent='%.9f'/>",
            EXTENT[k]);
        cr_assert(h.good, "%s", h.error.text);
        double e = EXTENT[k], radius = 2 / fabs(sin(e / 2));
        // Positive: it bulges to the left of its direction, up on the screen (y > 0).
        double centre = -2 / tan(e / 2);
        const SketchWall *w = &h.sketch.walls[0];
        cr_assert_gt(w->point_count, 4);
        for (int i = 0; i < w->point_count; i++) {
            Vec2 p = *wall_point(&h, 0, i);
            double r = vec2_length(vec2_sub(p, vec2(2, centre)));
            // Tolerance: nine digits of pi/2 on a radius of up to 400 m.
            cr_assert_float_eq(fabs(r - radius), 0.1, 1e-5, "extent %g point %d: radius %g of %g", e, i, r,
                               radius);
        }
        double exact = fabs(e) * radius * 0.2, area = wall_area(&h, 0);
        // Chords of at most sqrt(length in cm) steps lose below 2 %% here.
        cr_assert(area > 0.98 * exact && area < exact * 1.0001, "extent %g: area %g of %g", e, area, exact);
        home_free(&h);
    }
}

// Walls below the ceiling are objects, with their sloped tops; the sketch gets the others, up to their highest
// point; what has no size is dropped with a note.
Test(sh3d, low_and_sloped_walls) {
    Home h = home_of(HOME_ROOM
                     "<wall id='low' xStart='0' yStart='0' xEnd='100' yEnd='0' thickness='10' height='80'/>"
                     "<wall id='ramp' xStart='0' yStart='100' xEnd='200' yEnd='100' thickness='10' "
                     "height='0' heightAtEnd='100'/>"
                     "<wall id='gable' xStart='0' yStart='200' xEnd='200' yEnd='200' thickness='10' "
                     "height='100' heightAtEnd='250'/>"
                     "<wall id='point' xStart='5' yStart='5' xEnd='5' yEnd='5' thickness='10'/>"
                     "<wall id='sheet' xStart='5' yStart='5' xEnd='50' yEnd='5' thickness='0'/>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.sketch.wall_count, 1);
    cr_assert_float_eq(h.sketch.walls[0].z1, 2.5, CLOSE);
    cr_assert_eq(h.b.object_count, 2);
    cr_assert_eq(h.b.objects[0].polygon_count, 5);
    // The ramp: no side at its start, its sides are triangles.
    cr_assert_eq(h.b.objects[1].polygon_count, 4);
    cr_assert_float_eq(h.b.objects[1].proxy_z1, 1, CLOSE);
    cr_assert_float_eq(h.b.objects[1].proxy_z1 - h.b.objects[1].proxy_z0, 1, CLOSE);
    cr_assert_geq(home_note(&h, "length below 1 mm"), 0);
    cr_assert_geq(home_note(&h, "thickness below 1 mm"), 0);
    home_free(&h);
}

static double surface_volume(const Home *h, const Object *o, double *area) {
    double volume = 0;
    *area = 0;
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *p = &h->b.polygons[i];
        const Vec3 *v = h->b.vertices + p->first_vertex;
        cr_assert_eq(p->vertex_count, 3);
        double a =
            -vec2_cross(vec2(v[1].x - v[0].x, v[1].y - v[0].y), vec2(v[2].x - v[0].x, v[2].y - v[0].y)) / 2;
        cr_assert_gt(a, 0, "it is seen from below");
        *area += a;
        volume += a * (v[0].z + v[1].z + v[2].z) / 3;
    }
    return volume;
}

// An attic 6 x 4 m with knee walls of 1 m and two gables rising to 2.5 m in the middle: the ceiling is the roof,
// its ridge between the gables' tops (6 x 4 x (1 + 2.5) / 2 m^3 below it), and the knee walls bound the room.
Test(sh3d, ceiling_below_gables) {
    Home h = home_of("<wall id='k1' wallAtStart='g4' wallAtEnd='g1' xStart='0' yStart='0' xEnd='0' "
                     "yEnd='400' thickness='2' height='100'/>"
                     "<wall id='g1' wallAtStart='k1' wallAtEnd='g2' xStart='0' yStart='400' xEnd='300' "
                     "yEnd='400' thickness='2' height='100' heightAtEnd='250'/>"
                     "<wall id='g2' wallAtStart='g1' wallAtEnd='k2' xStart='300' yStart='400' xEnd='600' "
                     "yEnd='400' thickness='2' height='250' heightAtEnd='100'/>"
                     "<wall id='k2' wallAtStart='g2' wallAtEnd='g3' xStart='600' yStart='400' xEnd='600' "
                     "yEnd='0' thickness='2' height='100'/>"
                     "<wall id='g3' wallAtStart='k2' wallAtEnd='g4' xStart='600' yStart='0' xEnd='300' "
                     "yEnd='0' thickness='2' height='100' heightAtEnd='250'/>"
                     "<wall id='g4' wallAtStart='g3' wallAtEnd='k1' xStart='300' yStart='0' xEnd='0' "
                     "yEnd='0' thickness='2' height='250' heightAtEnd='100'/>"
                     "<room><point x='0' y='0'/><point x='600' y='0'/><point x='600' y='400'/><point x='0' "
                     "y='400'/></room>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.sketch.wall_count, 6, "%d walls bound the room", h.sketch.wall_count);
    cr_assert_eq(h.b.object_count, 1);
    double area, volume = surface_volume(&h, &h.b.objects[0], &area);
    cr_assert_float_eq(area, 24, 1e-6);
    cr_assert_float_eq(volume, 24 * 1.75, 1e-6);
    cr_assert_eq(h.b.objects[0].proxy_z0, h.b.objects[0].proxy_z1, "nobody bumps into the roof's box");
    home_free(&h);
}

// A storey is as high as most of its high walls; levels at one elevation are one storey; a hidden one is read.
Test(sh3d, levels) {
    Home h = home_of(
        "<level id='up' name='Up' elevation='262' floorThickness='12' height='200' visible='false'/>"
        "<level id='low' name='Low' elevation='0' floorThickness='20' height='250'/>"
        "<level id='low2' name='Garden' elevation='0' floorThickness='20' height='250' elevationIndex='1'/>"
        "<wall id='a' level='up' xStart='0' yStart='0' xEnd='400' yEnd='0' thickness='20' height='230'/>"
        "<wall id='b' level='up' xStart='0' yStart='300' xEnd='100' yEnd='300' thickness='20' height='200'/>"
        "<wall id='c' level='low2' xStart='0' yStart='0' xEnd='400' yEnd='0' thickness='20' height='500'/>"
        "<wall id='d' level='low' xStart='0' yStart='300' xEnd='300' yEnd='300' thickness='20' "
        "height='90'/>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.b.storey_count, 2);
    cr_assert_str_eq(h.b.storeys[0].name, "Low");
    cr_assert_float_eq(h.b.storeys[0].height, 2.5, CLOSE,
                       "walls over two storeys do not raise the ceiling into the floor above");
    cr_assert_float_eq(h.b.storeys[0].slab, 0.2, CLOSE);
    cr_assert_float_eq(h.b.storeys[1].floor, 2.62, CLOSE);
    cr_assert_float_eq(h.b.storeys[1].height, 2.3, CLOSE);
    cr_assert_eq(h.sketch.wall_count, 2, "b and d are low walls");
    cr_assert_eq(h.sketch.walls[1].storey, 0);
    cr_assert_geq(home_note(&h, "read as one storey"), 0);
    home_free(&h);
}

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

// ---- models

static Home read_wedge(const char *attributes) {
    char xml[2048];
    snprintf(xml, sizeof xml,
             "<home wallHeight='250'>" HOME_ROOM
             "<pieceOfFurniture name='w' model='1/w%%20edge.obj' x='100' y='200' "
             "width='10' depth='40' height='20' elevation='50' %s</home>",
             attributes);
    HomeEntry entries[] = {{"Home.xml", xml, strlen(xml)},
                           {"1/w edge.obj", HOME_WEDGE, sizeof HOME_WEDGE - 1},
                           {"1/w.mtl", HOME_WEDGE_LIBRARY, sizeof HOME_WEDGE_LIBRARY - 1}};
    return home_of_zip(entries, 3);
}

static bool has_vertex(const Home *h, Vec3 p) {
    for (int i = 0; i < h->b.vertex_count; i++)
        if (vec3_length(vec3_sub(h->b.vertices[i], p)) < 1e-6) return true;
    return false;
}

// The volume that the polygons enclose: positive where they are seen from outside.
static double enclosed(const Home *h) {
    double volume = 0;
    for (int i = 0; i < h->b.polygon_count; i++) {
        const Vec3 *v = h->b.vertices + h->b.polygons[i].first_vertex;
        for (int k = 1; k + 1 < h->b.polygons[i].vertex_count; k++)
            volume += vec3_dot(v[0], vec3_cross(v[k], v[k + 1])) / 6;
    }
    return volume;
}

// Right, up and front of a model become x, z and -y; angles turn clockwise on the plan, as the program draws them;
// mirroring swaps right and left, and front sides stay outside.
Test(sh3d, places_models) {
    // The corners that the model has at its right, top and front, for the piece in metres: centre (1, -2), foot 0.5.
    static const struct {
        const char *attributes;
        Vec3 origin, right, top, front;
    } CASES[] = {
        {"/>", {0.95, -1.8, 0.5}, {1.05, -1.8, 0.5}, {0.95, -1.8, 0.7}, {0.95, -2.2, 0.5}},
        {"angle='1.5707964'/>", {1.2, -1.95, 0.5}, {1.2, -2.05, 0.5}, {1.2, -1.95, 0.7}, {0.8, -1.95, 0.5}},
        {"modelMirrored='true'/>",
         {1.05, -1.8, 0.5},
         {0.95, -1.8, 0.5},
         {1.05, -1.8, 0.7},
         {1.05, -2.2, 0.5}},
        {"angle='3.1415927' modelMirrored='true'/>",
         {0.95, -2.2, 0.5},
         {1.05, -2.2, 0.5},
         {0.95, -2.2, 0.7},
         {0.95, -1.8, 0.5}},
        // Turned half round about its vertical axis before it is fitted.
        {"modelRotation='-1 0 0 0 1 0 0 0 -1'/>",
         {1.05, -2.2, 0.5},
         {0.95, -2.2, 0.5},
         {1.05, -2.2, 0.7},
         {1.05, -1.8, 0.5}},
        // A quarter turn about x (pitch counts forwards): up becomes front, front becomes down.
        {"pitch='4.712389'/>", {0.95, -1.9, 0.9}, {1.05, -1.9, 0.9}, {0.95, -2.1, 0.9}, {0.95, -1.9, 0.5}},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Home h = read_wedge(CASES[i].attributes);
        cr_assert(h.good, "%s", h.error.text);
        cr_assert_eq(h.b.object_count, 1);
        cr_assert_eq(h.b.polygon_count, 4);
        cr_assert(has_vertex(&h, CASES[i].origin), "case %zu: origin", i);
        cr_assert(has_vertex(&h, CASES[i].right), "case %zu: right", i);
        cr_assert(has_vertex(&h, CASES[i].top), "case %zu: top", i);
        cr_assert(has_vertex(&h, CASES[i].front), "case %zu: front", i);
        cr_assert_float_eq(enclosed(&h), 0.1 * 0.2 * 0.4 / 6, 1e-9, "case %zu: fronts outside", i);
        cr_assert_gt(h.b.materials[h.b.polygons[0].material].reflectance.r, 0.8f);
        cr_assert_lt(h.b.materials[h.b.polygons[0].material].reflectance.g, 0.1f);
        home_free(&h);
    }
}

// Backs that are shown are faces turned the other way: what was enclosed once is so once from each side.
Test(sh3d, shows_backs_where_asked) {
    static const char *const CASES[] = {"backFaceShown='true'/>",
                                        "backFaceShown='true' modelMirrored='true'/>"};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Home h = read_wedge(CASES[i]);
        cr_assert(h.good, "%s", h.error.text);
        cr_assert_eq(h.b.polygon_count, 8);
        cr_assert_float_eq(enclosed(&h), 0, 1e-12, "%s", CASES[i]);
        h.b.polygon_count = 1;
        double front = enclosed(&h);
        h.b.polygons[0] = h.b.polygons[1];
        cr_assert_float_eq(enclosed(&h), -front, 1e-12, "%s: of the same face", CASES[i]);
        home_free(&h);
    }
}

// A piece's colour goes over its model's, and its own materials' colours over those of the same name.
Test(sh3d, colours_of_pieces) {
    Home h = read_wedge("color='FF0000FF'/>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_gt(h.b.materials[h.b.polygons[0].material].reflectance.b, 0.8f);
    home_free(&h);
    h = read_wedge("><material name='skin' color='FF00FF00'/><material name='other' "
                   "color='FF0000FF'/></pieceOfFurniture>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_gt(h.b.materials[h.b.polygons[0].material].reflectance.g, 0.8f);
    home_free(&h);
}

// A door's moving parts are a leaf that turns on its hinge; its panes are glass; a model drawn open is closed, and the
// door is open. The leaf names the opening that it belongs to.
Test(sh3d, leaves_of_doors) {
    static const char MODEL[] = "v -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\nv -1 0 1\nv -1 2 1\nv -1 0 -0.99\n"
                                "g frame\nf 1 2 3\nf 1 4 6 5\ng sweethome3d_hinge_1\nf 1 7 4\n"
                                "g sweethome3d_opening_on_hinge_1_door\nf %s\n"
                                "g sweethome3d_window_pane_on_hinge_1\nusemtl white\nf %s\n";
    for (int open = 0; open < 2; open++) {
        char model[512];
        const char *leaf = open ? "1 4 6 5" : "1 2 3 4";
        snprintf(model, sizeof model, MODEL, leaf, leaf);
        static const char XML[] = "<home wallHeight='250'>" HOME_ROOM
                                  "<doorOrWindow name='Window' x='1' y='1' width='90' depth='10' "
                                  "height='100' elevation='100' model='1'/>"
                                  "<doorOrWindow name='Door' x='300' y='0' width='90' depth='90' "
                                  "height='200' model='1'>" HOME_SASH_LEFT "</doorOrWindow></home>";
        HomeEntry entries[] = {{"Home.xml", XML, sizeof XML - 1}, {"1", model, strlen(model)}};
        Home h = home_of_zip(entries, 2);
        cr_assert(h.good, "%s", h.error.text);
        cr_assert_eq(h.b.object_count, 3);
        cr_assert_eq(h.b.objects[0].kind, OBJECT_FRAME);
        cr_assert_eq(h.b.objects[0].polygon_count, 5, "a window keeps all its parts");
        cr_assert_eq(h.b.objects[1].polygon_count, 3);
        const Object *o = &h.b.objects[2];
        cr_assert_eq(o->kind, OBJECT_LEAF);
        cr_assert_eq(o->opening, 1);
        cr_assert_eq(o->leaf, 0);
        const SketchOpening *door = &h.sketch.openings[1];
        cr_assert_eq(door->leaf_count, 1);
        // The hinge is at the left of the back; the model's box is scaled to 0.9 m by 0.9 m around x = 3 m.
        cr_assert_float_eq(door->leaves[0].pivot.x, 2.55, 1e-6);
        cr_assert_float_eq(door->leaves[0].turn, -M_PI / 2, 1e-6);
        cr_assert_float_eq(door->open, open ? 1 : 0, 0.01);
        for (int k = 0; k < 4; k++) {
            Vec3 v = h.b.vertices[h.b.polygons[o->first_polygon].first_vertex + k];
            cr_assert(v.y > 0.4 && v.x > 2.5 && v.x < 3.5, "closed, it lies along the back: %g, %g", v.x,
                      v.y);
        }
        cr_assert_eq(o->polygon_count, 2);
        cr_assert_eq(h.b.materials[h.b.polygons[o->first_polygon].material].alpha, 1.0f);
        cr_assert_lt(h.b.materials[h.b.polygons[o->first_polygon + 1].material].alpha, 1.0f);
        home_free(&h);
    }
}

// The first of two leaves on rails slides over the second, which stays; a leaf without a height is none but of the frame.
Test(sh3d, leaves_on_rails) {
    static const char MODEL[] = "v -1 0 0\nv 0 0 0\nv 0 2 0\nv -1 2 0\n"
                                "v 0 0 0.1\nv 1 0 0.1\nv 1 2 0.1\nv 0 2 0.1\nv -1 0 0.1\n"
                                "g sweethome3d_opening_on_hinge_3\nf 1 6 9\n"
                                "g sweethome3d_opening_on_rail_1\nf 1 2 3 4\n"
                                "g sweethome3d_opening_on_rail_2\nf 5 6 7 8\n";
    static const char XML[] = "<home wallHeight='250'>" HOME_ROOM
                              "<doorOrWindow name='Door' x='300' y='0' width='180' depth='10' height='200' "
                              "model='1'/></home>";
    HomeEntry entries[] = {{"Home.xml", XML, sizeof XML - 1}, {"1", MODEL, sizeof MODEL - 1}};
    Home h = home_of_zip(entries, 2);
    cr_assert(h.good, "%s", h.error.text);
    const SketchOpening *door = &h.sketch.openings[0];
    cr_assert_eq(door->leaf_count, 2);
    // The model's two metres are drawn as 1.8: a leaf is 0.9 m wide.
    cr_expect_float_eq(fabs(door->leaves[0].slide.x), 0.9, 1e-6, "slides by %g", door->leaves[0].slide.x);
    cr_expect_eq(vec2_length(door->leaves[1].slide), 0);
    cr_expect(door->leaves[0].turn == 0 && door->leaves[1].turn == 0);
    cr_expect_eq(h.b.objects[0].kind, OBJECT_FRAME);
    cr_expect_eq(h.b.objects[0].polygon_count, 1, "the sheet is of the frame");
    home_free(&h);
}

// Missing models are boxes of the right place, counted in one note; a stair without its model is a flight of steps
// no higher than 0.2 m that ends at the floor above, which gets a hole; hidden pieces and groups are left out.
Test(sh3d, missing_models_and_stairs) {
    Home h = home_of(
        "<level id='l0' name='0' elevation='0' floorThickness='12' height='250'/>"
        "<level id='l1' name='1' elevation='262' floorThickness='12' height='250'/>"
        "<pieceOfFurniture level='l1' name='Box' x='100' y='100' angle='0.5' width='50' depth='30' "
        "height='20' elevation='10' model='gone'/>"
        "<pieceOfFurniture level='l1' name='Hidden' x='0' y='0' width='50' depth='30' height='20' "
        "visible='false'/>"
        "<furnitureGroup level='l1' name='g' visible='false' x='0' y='0' width='1' depth='1' height='1'>"
        "<pieceOfFurniture level='l1' name='Inside' x='0' y='0' width='50' depth='30' "
        "height='20'/></furnitureGroup>"
        "<furnitureGroup level='l1' name='g' x='0' y='0' elevation='70' width='1' depth='1' height='1'>"
        "<shelfUnit level='l1' name='Shelf' x='0' y='0' elevation='70' width='50' depth='30' "
        "height='20'/></furnitureGroup>"
        "<pieceOfFurniture level='l0' name='Escalier' x='300' y='300' width='80' depth='240' height='362' "
        "staircaseCutOutShape='M0,0 v1 h1 v-0.5 z'/>" HOME_ROOM);
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.b.object_count, 3);
    cr_assert_eq(h.b.objects[0].polygon_count, 6);
    cr_assert_float_eq(h.b.objects[0].proxy_z0, 2.72, CLOSE);
    // Tolerance of the box: sines and cosines of an angle.
    Vec2 side = vec2_sub(h.b.objects[0].proxy[1], h.b.objects[0].proxy[0]);
    cr_assert_float_eq(vec2_length(side), 0.5, 1e-9);
    cr_assert_float_eq(atan2(side.y, side.x), -0.5, 1e-9);
    cr_assert_float_eq(h.b.objects[1].proxy_z0, 2.62 + 0.7, CLOSE, "members of groups count from the level");
    const Object *stair = &h.b.objects[2];
    cr_assert_eq(stair->kind, OBJECT_STAIR);
    cr_assert_float_eq(stair->proxy_z1, 2.62, CLOSE, "what rises above the floor is railing");
    cr_assert_eq(stair->polygon_count, 4 * 14 + 1, "14 steps of 0.187 m");
    double lowest_back = 9;
    for (int i = 0; i < h.b.vertex_count; i++)
        if (h.b.vertices[i].y > -1.81 && h.b.vertices[i].x > 2.5 && h.b.vertices[i].z > 1)
            lowest_back = fmin(lowest_back, h.b.vertices[i].z);
    cr_assert_float_eq(lowest_back, 2.62, CLOSE, "it rises to its back");
    cr_assert_eq(h.sketch.cutout_count, 1);
    cr_assert_eq(h.sketch.cutouts[0].storey, 1);
    cr_assert_eq(h.sketch.cutouts[0].point_count, 4);
    int note = home_note(&h, "3 models are not in the file");
    cr_assert_geq(note, 0);
    cr_assert(strstr(h.b.notes[note].text, "Box, Shelf, Escalier"), "%s", h.b.notes[note].text);
    home_free(&h);
}

// ---- lamps and cameras

// 10 W for each unit of power, shared by the colour's linear channels and by the sources; places as shares of the
// box, counted from its left, front and foot.
Test(sh3d, lamps) {
    Home h = home_of(HOME_ROOM "<light name='l' x='100' y='100' angle='1.5707964' width='40' depth='20' "
                               "height='50' elevation='100' power='0.5'>"
                               "<lightSource x='0.25' y='0' z='0.5' color='FFFF8000' diameter='0.5'/>"
                               "<lightSource x='0.5' y='0.5' z='0' color='FF000000'/></light><light name='d' "
                               "x='1' y='1' width='4' depth='4' height='5'/>");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.b.light_count, 2);
    const Light *l = &h.b.lights[0];
    double r = (double)l->flux.r, g = (double)l->flux.g, b = (double)l->flux.b;
    cr_assert_float_eq(r + g + b, 2.5, 1e-6);
    cr_assert_float_eq(g / r, (double)maps_linear(128) / (double)maps_linear(255), 1e-6);
    cr_assert_eq(b, 0);
    // Quarter turn clockwise: its right is down (-y), its front to the left (-x).
    assert_vec3(l->position, 0.9, -0.9, 1.25);
    cr_assert_float_eq(l->radius, 0.1, CLOSE);
    cr_assert_float_eq((double)h.b.lights[1].flux.b, 2.5 / 3, 1e-6);
    cr_assert_eq(h.b.objects[l->object].kind, OBJECT_LAMP);
    cr_assert_geq(home_note(&h, "1 lamps have no light source"), 0);
    home_free(&h);
}

// The file's yaw 0 looks down the screen and counts clockwise there, its pitch looks down; heights are
// absolute; the path is a tour, the camera above is left out.
Test(sh3d, cameras) {
    Home h = home_of(
        "<environment groundColor='FF00FF00'><camera attribute='cameraPath' x='0' y='0' z='1' yaw='0' "
        "pitch='0' fieldOfView='1'/>"
        "<camera attribute='cameraPath' x='10' y='0' z='1' yaw='0' pitch='0' fieldOfView='1'/></environment>"
        "<observerCamera attribute='observerCamera' x='100' y='200' z='170' yaw='0' pitch='0.2' "
        "fieldOfView='1.1'/>"
        "<camera attribute='topCamera' x='0' y='0' z='1000' yaw='0' pitch='1.5' fieldOfView='1.1'/>"
        "<observerCamera attribute='storedCamera' name='Hall' x='0' y='0' z='170' yaw='1.5707963' pitch='0' "
        "fieldOfView='1.1'/>" HOME_ROOM);
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.b.viewpoint_count, 2);
    assert_vec3(h.b.viewpoints[0].eye, 1, -2, 1.7);
    cr_assert_float_eq(h.b.viewpoints[0].yaw, -M_PI / 2, 1e-6);
    cr_assert_float_eq(h.b.viewpoints[0].pitch, -0.2, 1e-6);
    // direction (-sin yaw, cos yaw) = (-1, 0) in both frames.
    cr_assert_float_eq(fabs(h.b.viewpoints[1].yaw), M_PI, 1e-6);
    cr_assert_str_eq(h.b.viewpoints[1].name, "Hall");
    cr_assert_eq(h.b.tour_count, 1);
    cr_assert_eq(h.b.tours[0].viewpoint_count, 2);
    cr_assert_gt(h.b.materials[h.sketch.ground_material].reflectance.g, 0.8f);
    home_free(&h);
}
