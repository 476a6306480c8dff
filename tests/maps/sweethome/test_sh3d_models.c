// test_sh3d_models.c - models, leaves, lamps and cameras of homes.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/random.h"
#include "tests/maps/sweethome/sh3d_fixture.h"
#include "tests/support/files/home_fixture.h"

#define assert_vec3(p, X, Y, Z)                                                                              \
    cr_assert(fabs((p).x - (X)) < CLOSE && fabs((p).y - (Y)) < CLOSE && fabs((p).z - (Z)) < CLOSE,           \
              "(%.9g, %.9g, %.9g) is not (%g, %g, %g)", (p).x, (p).y, (p).z, (double)(X), (double)(Y),       \
              (double)(Z))

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

static const Material *material_of(const Home *h, int polygon) {
    return &h->b.materials[h->b.polygons[polygon].material];
}

// A model of two named materials and an unknown one. The unknown one is matt, the others are as shiny as the table
// says; where the piece says how shiny it is, that counts, unless it states single materials, which then count alone;
// a colour of the piece brings the piece's shininess back. Unknown names that keep the default colour are told in one
// note, names that the piece paints are not.
Test(sh3d, shininess_and_unknown_names) {
    static const char MODEL[] = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\nusemtl dkgrey\nf 1 3 2\nf 1 2 4\n"
                                "usemtl flgrey\nf 1 4 3\nusemtl strange\nf 2 3 4\n";
    static const struct {
        const char *attributes;
        double dkgrey, flgrey, strange;
        bool noted;
    } CASES[] = {
        {"/>", 60.0 / 128, 0, 0, 1},
        {"shininess='0.25'/>", 0.25, 0.25, 0.25, 1},
        {"shininess='7'/>", 1, 1, 1, 1},
        {"shininess='0.25'><material name='flgrey' shininess='0.5'/></pieceOfFurniture>", 60.0 / 128, 0.5, 0,
         1},
        {"shininess='0.25' color='FF0000FF'><material name='flgrey' shininess='0.5'/></pieceOfFurniture>",
         0.25, 0.25, 0.25, 0},
        {"><material name='x' key='strange' color='FF00FF00'/></pieceOfFurniture>", 60.0 / 128, 0, 0, 0},
        {"><material name='strange' key='x' color='FF00FF00'/></pieceOfFurniture>", 60.0 / 128, 0, 0, 1}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        char xml[2048];
        snprintf(xml, sizeof xml,
                 "<home wallHeight='250'>" HOME_ROOM "<pieceOfFurniture name='w' model='1' x='100' y='200' "
                 "width='10' depth='40' height='20' %s</home>",
                 CASES[i].attributes);
        HomeEntry entries[] = {{"Home.xml", xml, strlen(xml)}, {"1", MODEL, sizeof MODEL - 1}};
        Home h = home_of_zip(entries, 2);
        cr_assert(h.good, "%s", h.error.text);
        cr_assert_eq(h.b.polygon_count, 4);
        // Tolerance: single precision.
        cr_expect_float_eq((double)material_of(&h, 0)->gloss, CASES[i].dkgrey, 1e-6, "case %zu", i);
        cr_expect_float_eq((double)material_of(&h, 2)->gloss, CASES[i].flgrey, 1e-6, "case %zu", i);
        cr_expect_float_eq((double)material_of(&h, 3)->gloss, CASES[i].strange, 1e-6, "case %zu", i);
        const char *words = "1 materials have a name that neither a library nor Sweet Home 3D knows, and the "
                            "colour of its default material: strange";
        cr_expect_eq(home_note(&h, words) >= 0, CASES[i].noted, "case %zu", i);
        cr_expect_eq(home_note(&h, "Sweet Home 3D knows") >= 0, CASES[i].noted, "case %zu", i);
        home_free(&h);
    }
}

// Proves that the parts of a model that the program shows as mirrors are mirrors, also on leaves, and no others.
Test(sh3d, mirrors_of_models) {
    static const char MODEL[] =
        "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\nusemtl flgrey\ng sweethome3d_window_mirror_1\nf 1 3 2\n"
        "g sweethome3d_window_mirror_on_hinge_1\nf 1 2 4\ng mirror\nf 1 4 3\ng "
        "sweethome3d_window_pane\nf 2 3 4\n";
    HomeEntry entries[] = {{"Home.xml",
                            "<home wallHeight='250'>" HOME_ROOM
                            "<pieceOfFurniture name='w' model='1' x='100' y='200' "
                            "width='10' depth='40' height='20'/></home>",
                            0},
                           {"1", MODEL, sizeof MODEL - 1}};
    entries[0].size = strlen(entries[0].data);
    Home h = home_of_zip(entries, 2);
    cr_assert(h.good, "%s", h.error.text);
    cr_assert_eq(h.b.polygon_count, 4);
    int mirrors = 0;
    for (int i = 0; i < 4; i++) {
        const Material *m = material_of(&h, i);
        mirrors += m->mirror > 0;
        // Light that is mirrored is not scattered, too.
        if (m->mirror > 0) cr_expect_lt(m->mirror + m->reflectance.g, 1);
    }
    cr_expect_eq(mirrors, 2);
    home_free(&h);
}

// Floors, ceilings and sides of walls are as shiny as the file says.
Test(sh3d, shininess_of_surfaces) {
    Home h = home_of("<room floorShininess='0.5' floorColor='FF804020' "
                     "ceilingShininess='0.25'><point x='0' "
                     "y='0'/><point x='400' y='0'/><point x='400' y='300'/><point x='0' y='300'/></room>");
    cr_assert(h.good, "%s", h.error.text);
    double floor = 0, ceiling = 0;
    for (int i = 0; i < h.b.material_count; i++) {
        const Material *m = &h.b.materials[i];
        if (strcmp(m->name, "paint") == 0) floor = (double)m->gloss;
        if (strcmp(m->name, "ceiling") == 0) ceiling = fmax(ceiling, (double)m->gloss);
    }
    cr_expect_eq(floor, 0.5);
    cr_expect_eq(ceiling, 0.25);
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

// A model that names no parts, closed and open: the frame, whose face goes round the way, and the stop on its head stay; what fills
// the way is the leaf, and the handle on it goes along.
Test(sh3d, leaves_without_names) {
    // The frame's face and the stop; the leaf and the handle on its front. Open, the leaf stands out by 0.8 m, and so does its handle.
    static const char MODEL[] =
        "v -0.45 0 0\nv -0.4 0 0\nv -0.4 1.95 0\nv 0.4 1.95 0\nv 0.4 0 0\nv 0.45 0 0\n"
        "v 0.45 2 0\nv -0.45 2 0\nf 1 2 3 4 5 6 7 8\n"
        "v -0.1 1.97 0\nv 0.1 1.97 0\nv 0.1 1.99 0.02\nf 9 10 11\n%s";
    static const char *const LEAF[] = {
        "v -0.39 0 0\nv 0.39 0 0\nv 0.39 1.94 0\nv -0.39 1.94 0\nf 12 13 14 15\n"
        "v 0.3 1 0.01\nv 0.35 1 0.01\nv 0.35 1.02 0.06\nf 16 17 18\n",
        "v -0.39 0 0\nv -0.39 0 0.8\nv -0.39 1.94 0.8\nv -0.39 1.94 0\nf 12 13 14 15\n"
        "v -0.41 1 0.7\nv -0.41 1 0.75\nv -0.46 1.02 0.75\nf 16 17 18\n"};
    for (int open = 0; open < 2; open++) {
        char model[1024], xml[1024];
        snprintf(model, sizeof model, MODEL, LEAF[open]);
        snprintf(xml, sizeof xml,
                 "<home wallHeight='250'>" HOME_ROOM "<doorOrWindow name='Door' x='300' y='0' width='90' "
                 "depth='%s' height='200' model='1'>" HOME_SASH_LEFT "</doorOrWindow></home>",
                 open ? "80" : "6");
        HomeEntry entries[] = {{"Home.xml", xml, strlen(xml)}, {"1", model, strlen(model)}};
        Home h = home_of_zip(entries, 2);
        cr_assert(h.good, "%s", h.error.text);
        cr_assert_eq(h.sketch.openings[0].leaf_count, 1);
        cr_assert_eq(h.b.object_count, 2);
        cr_expect_eq(h.b.objects[0].kind, OBJECT_FRAME);
        cr_expect_eq(h.b.objects[1].kind, OBJECT_LEAF);
        int polygons = h.b.objects[1].polygon_count;
        cr_expect_eq(polygons, 2, "%s: %d polygons go with the leaf, and %d stay", open ? "open" : "closed",
                     polygons, h.b.objects[0].polygon_count);
        cr_expect_float_eq(h.sketch.openings[0].open, open, 0.05);
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
    cr_assert_float_eq(h.b.objects[0].proxy->z0, 2.72, CLOSE);
    // Tolerance of the box: sines and cosines of an angle.
    Vec2 side = vec2_sub(h.b.objects[0].proxy->corner[1], h.b.objects[0].proxy->corner[0]);
    cr_assert_float_eq(vec2_length(side), 0.5, 1e-9);
    cr_assert_float_eq(atan2(side.y, side.x), -0.5, 1e-9);
    cr_assert_float_eq(h.b.objects[1].proxy->z0, 2.62 + 0.7, CLOSE, "members of groups count from the level");
    const Object *stair = &h.b.objects[2];
    cr_assert_eq(stair->kind, OBJECT_STAIR);
    cr_assert_float_eq(stair->proxy->z1, 2.62, CLOSE, "what rises above the floor is railing");
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
