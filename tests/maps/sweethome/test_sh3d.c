// test_sh3d.c - Sweet Home 3D files: the plan and the objects read from them, before anything is enclosed. Bad files
// and real homes: test_sh3d_input.c.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "maps/sweethome/sh3d.h"
#include "tests/maps/sweethome/sh3d_fixture.h"
#include "tests/support/files/home_fixture.h"

extern const MapsReader MAPS_READER_SH3D;

static const Vec2 *wall_point(const Home *h, int wall, int i) {
    return &h->sketch.points[h->sketch.walls[wall].first_point + i];
}

static double wall_area(const Home *h, int wall) {
    return sh3d_shape_area(wall_point(h, wall, 0), h->sketch.walls[wall].point_count);
}

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
    cr_assert_float_eq(h.b.objects[1].proxy->z1, 1, CLOSE);
    cr_assert_float_eq(h.b.objects[1].proxy->z1 - h.b.objects[1].proxy->z0, 1, CLOSE);
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
    cr_assert_null(h.b.objects[0].proxy, "nobody bumps into the roof's box");
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

// A home without levels, 3.66 m high: a hall with outer walls as high, and two rooms in it that walls of 2.44 m enclose, with a gap in
// the wall between them; one of these has a corner at the outer wall.
#define CEILINGS                                                                                             \
    "<wall xStart='-5' yStart='-5' xEnd='1205' yEnd='-5' thickness='10' height='366'/>"                      \
    "<wall xStart='-5' yStart='805' xEnd='1205' yEnd='805' thickness='10' height='366'/>"                    \
    "<wall xStart='-5' yStart='-5' xEnd='-5' yEnd='805' thickness='10' height='366'/>"                       \
    "<wall xStart='1205' yStart='-5' xEnd='1205' yEnd='805' thickness='10' height='366'/>"                   \
    "<wall xStart='200' yStart='195' xEnd='800' yEnd='195' thickness='10' height='244'/>"                    \
    "<wall xStart='200' yStart='605' xEnd='800' yEnd='605' thickness='10' height='244'/>"                    \
    "<wall xStart='195' yStart='190' xEnd='195' yEnd='610' thickness='10' height='244'/>"                    \
    "<wall xStart='805' yStart='190' xEnd='805' yEnd='610' thickness='10' height='244'/>"                    \
    "<wall xStart='500' yStart='200' xEnd='500' yEnd='500' thickness='10' height='244'/>"                    \
    "<room name='hall'><point x='0' y='0'/><point x='1200' y='0'/><point x='1200' y='190'/>"                 \
    "<point x='0' y='190'/></room>"                                                                          \
    "<room name='one' ceilingVisible='%s'><point x='200' y='200'/><point x='495' y='200'/>"                  \
    "<point x='495' y='600'/><point x='200' y='600'/></room>"                                                \
    "<room name='two'><point x='505' y='200'/><point x='800' y='200'/><point x='800' y='600'/>"              \
    "<point x='505' y='600'/></room>"

// On the highest level rooms have the ceilings of the walls around them; not in a storey below, whose ceilings the program draws at
// the level's height. Where walls as high as these ceilings part rooms, they bound, gap or not.
Test(sh3d, ceilings_of_their_own) {
    Home h = home_of(CEILINGS, "false");
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.sketch.wall_count, 9, "low walls are left to maps_enclose");
    cr_expect(isnan(h.sketch.rooms[0].z1));
    cr_expect_float_eq(h.sketch.rooms[1].z1, 2.44, CLOSE);
    cr_expect_float_eq(h.sketch.rooms[2].z1, 2.44, CLOSE);
    cr_expect(h.sketch.rooms[1].open_above && !h.sketch.rooms[2].open_above);
    cr_assert(maps_enclose(&h.sketch, &h.b, &h.arena, &h.error), "%s", h.error.text);
    int low = 0, rooms = 0;
    for (int i = 0; i < h.b.object_count; i++) low += h.b.objects[i].kind == OBJECT_LOW_WALL;
    for (int i = 0; i < h.b.region_count; i++) {
        const Region *r = &h.b.regions[i];
        if (r->kind != REGION_ROOM) continue;
        rooms++;
        bool own = strcmp(r->name, "one") == 0 || strcmp(r->name, "two") == 0;
        cr_expect_float_eq(r->z1, own ? 2.44 : 3.66, CLOSE, "%s ends at %g m", r->name, r->z1);
    }
    cr_expect_eq(low, 0);
    cr_expect_eq(rooms, 4, "hall, the rest of it, one and two: %d", rooms);
    home_free(&h);
    h = home_of(
        "<level id='up' name='Up' elevation='400' floorThickness='12' height='250'/>"
        "<level id='low' name='Low' elevation='0' floorThickness='12' height='366'/>"
        "<wall level='up' xStart='0' yStart='0' xEnd='400' yEnd='0' thickness='20' height='250'/>"
        "<wall level='low' xStart='0' yStart='0' xEnd='900' yEnd='0' thickness='20' height='366'/>"
        "<wall level='low' xStart='0' yStart='300' xEnd='400' yEnd='300' thickness='20' height='244'/>"
        "<room level='low'><point x='10' y='310'/><point x='390' y='310'/><point x='390' y='320'/>"
        "<point x='10' y='320'/></room>");
    cr_assert(h.good, "%s", h.error.text);
    cr_expect(isnan(h.sketch.rooms[0].z1));
    home_free(&h);
}
