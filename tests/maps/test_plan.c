// test_plan.c - the .plan reader, the bundled buildings and the generator.
#include <criterion/criterion.h>

#include "tests/maps/plan_fixture.h"
#include "tests/support/support.h"

enum { HEAD_LINES = 8 };

// Each statement puts into the building what the file says, in metres above the storey's floor and in radians.
Test(plan, statements) {
    Arena arena = {0};
    Building b;
    plan_read_more(
        &arena,
        "door d 4.1,2 angle 90 width 1 height 2 hinge right swing -45 open 0.25 glazed material red\n"
        "window w 2,-0.1 width 1.5 sill 1 height 1.2\n"
        "stair up 1,2 width 1 depth 3 height 2 steps 10 material red\n"
        "light l 1,1,2 flux 1 2 3 radius 0.2\n"
        "inlay red ceiling 1,1 2,1 2,2 1,2\n"
        "place m 6,2 angle 90 name table\n"
        "view v 1,1,1.6 yaw 90 pitch -10 fov 60\n"
        "tour t\n  eye 1,1,1.6 yaw 0\n  eye 2,1,1.6 yaw 0\nend\n"
        "start 2,3 yaw 180\n",
        &b);
    cr_assert_eq(b.opening_count, 2);
    const Opening *d = &b.openings[0];
    cr_expect(d->kind == OPENING_DOOR && d->glazed && d->open == 0.25 && d->leaf_count == 1,
              "the door's words");
    cr_expect_float_eq(b.leaves[d->first_leaf].turn, -M_PI / 4, 1e-12);
    cr_expect_gt(b.leaves[d->first_leaf].pivot.y, 2.4, "hung at the far end");
    cr_expect_float_eq(d->sill, 1, 1e-9);
    cr_expect_float_eq(d->head, 3, 1e-9);
    cr_expect(d->region[0] >= 0 && d->region[1] >= 0, "the door joins both rooms");
    cr_expect_float_eq(d->line[0].x, 4.1, 1e-9, "the leaf stands in the middle of the wall");
    cr_expect_eq(b.openings[1].kind, OPENING_WINDOW);
    int stair = 0;
    for (int i = 0; i < b.object_count; i++) {
        const Object *o = &b.objects[i];
        if (o->kind != OBJECT_STAIR) continue;
        stair++;
        // Riser, tread and two sides a step, and the last step's back.
        cr_expect_eq(o->polygon_count, 41);
        cr_expect_float_eq(o->proxy->z1, 3, 1e-9);
    }
    cr_expect_eq(stair, 1);
    cr_expect(b.light_count == 1 && b.lights[0].position.z == 3 && b.lights[0].flux.g == 2);
    cr_expect(b.inlay_count == 1 && b.inlays[0].z == 4);
    cr_expect(b.viewpoint_count == 1 && fabs(b.viewpoints[0].yaw - M_PI / 2) < 1e-12 &&
              b.viewpoints[0].eye.z == 2.6);
    cr_expect(b.tour_count == 1 && b.tours[0].viewpoint_count == 2 && b.tour_point_count == 2);
    cr_expect(b.start.x == 2 && b.start.y == 3 && fabs(b.start.z - 2.6) < 1e-12);
    arena_free(&arena);
}

// About a passage that is no rectangle each room sees the rest of its own wall, in the colour of that wall.
Test(plan, spandrels_have_the_colour_of_their_side) {
    Arena arena = {0};
    Building b;
    Error error;
    cr_assert(
        plan_read_text(&arena,
                       "plan 1\nmaterial red #FF0000\nmaterial blue #0000FF\n"
                       "storey s floor 1 height 3\n"
                       "room a 0,0 4,0 4,4 0,4 wall 0.2 walls red\n"
                       "room b 4.2,0 8,0 8,4 4.2,4 wall 0.2 walls blue\n"
                       "passage p 4.1,2 angle 90 width 1 sill 1 height 1 shape 0,0.5 0.5,0 1,0.5 0.5,1\n",
                       &b, &error),
        "%s", error.text);
    int faces[2] = {0, 0};
    for (int i = 0; i < b.object_count; i++) {
        const Object *o = &b.objects[i];
        for (int k = o->first_polygon; o->kind == OBJECT_FRAME && k < o->first_polygon + o->polygon_count;
             k++) {
            const Polygon *p = &b.polygons[k];
            const Vec3 *v = b.vertices + p->first_vertex;
            double facing = vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0])).x;
            if (v[0].x != v[1].x || v[0].x != v[2].x) continue;
            cr_expect_str_eq(b.materials[p->material].name, facing > 0 ? "blue" : "red");
            faces[facing > 0]++;
        }
    }
    cr_expect(faces[0] >= 4 && faces[1] >= 4, "four corners on each side");
    arena_free(&arena);
}

// Shapes have the faces they should, facing out: the sum of their areas times normals is zero when closed, and the
// divergence theorem gives their volume, also turned and mirrored.
Test(plan, shapes_are_closed) {
    static const struct {
        const char *shape;
        double volume;  // m^3
    } CASES[] = {{"box 0,0,0 1,2,3 red", 6},
                 {"prism red 0 2 0,0 1,0 1,1 0,1", 2},
                 {"prism red 0 2 0,1 1,1 1,0 0,0", 2},
                 {"prism red 0 1 0,0 2,0 2,2 1,2 1,1 0,1", 3},
                 {"cylinder red 0 1 0,0 radius 1 sides 4", 2}};
    for (int i = 0; i < (int)(sizeof CASES / sizeof CASES[0]); i++) {
        for (int way = 0; way < 4; way++) {
            Arena arena = {0};
            Building b;
            plan_read_more(&arena,
                           arena_format(&arena, "model x\n%s\nend\nplace x 2,2 angle %d%s\n", CASES[i].shape,
                                        30 * way, way & 1 ? " mirror" : ""),
                           &b);
            double volume = 0;
            int object = 0;
            while (strcmp(b.objects[object].name, "x") != 0) object++;
            const Object *o = &b.objects[object];
            for (int k = o->first_polygon; k < o->first_polygon + o->polygon_count; k++) {
                const Vec3 *v = &b.vertices[b.polygons[k].first_vertex];
                int n = b.polygons[k].vertex_count;
                volume += plane_of_polygon(v, n).d * polygon_area(v, n) / 3;
            }
            // Six coordinates of metres in doubles: far below a cubic millimetre.
            cr_expect_float_eq(volume, CASES[i].volume, 1e-9, "%s, way %d: volume %g", CASES[i].shape, way,
                               volume);
            arena_free(&arena);
        }
    }
}

// `without` leaves out exactly the faces it names.
Test(plan, faces_left_out) {
    Arena arena = {0};
    Building b;
    plan_read_more(&arena, "model x\nbox 0,0,0 1,1,1 red without top back left\nend\nplace x 1,1\n", &b);
    int polygons = 0;
    for (int i = 0; i < b.polygon_count; i++) {
        Plane p = plane_of_polygon(&b.vertices[b.polygons[i].first_vertex], b.polygons[i].vertex_count);
        cr_expect(p.n.z < 0.5 && p.n.y < 0.5 && p.n.x > -0.5, "polygon %d faces (%g, %g, %g)", i, p.n.x,
                  p.n.y, p.n.z);
        polygons++;
    }
    cr_expect_eq(polygons, 3);
    arena_free(&arena);
}

// An opening is fitted to the wall around its centre, be it a room's or an explicit one; a mitred wall closes.
Test(plan, openings_are_fitted) {
    Arena arena = {0};
    Building b;
    plan_read_more(
        &arena, "door near 4.02,1 angle 90 width 0.8 height 2\nwindow out 2,4.15 width 1 sill 1 height 1\n",
        &b);
    cr_expect_float_eq(b.openings[0].line[0].x, 4.1, 1e-9);
    cr_expect(b.openings[0].region[0] >= 0 && b.openings[0].region[1] >= 0);
    cr_expect(b.openings[1].region[0] >= 0 && b.openings[1].region[1] >= 0);
    Error error = {""};
    bool read = plan_read_text(&arena,
                               "plan 1\nstorey s floor 0 height 3\nroom a 0,0 5,0 7,3 0,3\n"
                               "wall 0,0 5,0 7,3 0,3 0,0 thickness 0.3\ndoor d 2,0.1 width 1 height 2\n",
                               &b, &error);
    cr_assert(read, "%s", error.text);
    cr_expect_eq(b.note_count, 0, "%s", b.note_count ? b.notes[0].text : "");
    cr_expect(b.opening_count == 1 && b.openings[0].region[0] >= 0 && b.openings[0].region[1] >= 0);
    cr_expect_float_eq(b.openings[0].line[0].y, 0, 1e-9);
    arena_free(&arena);
}

// Names hold blanks in quotes; comments, carriage returns, a byte order mark and a missing last newline are fine.
Test(plan, text_forms) {
    Arena arena = {0};
    Building b;
    Error error = {""};
    const char *text =
        "\xEF\xBB\xBF# a house\r\nplan 1 # version\r\nmaterial c #A0B0C0   # a colour\r\n\r\n"
        "storey \"ground floor\" floor 0 height 2.5\r\nroom \"living room\" 0,0 3,0 3,3 0,3 wall .1 floor c";
    cr_assert(plan_read_text(&arena, text, &b, &error), "%s", error.text);
    cr_expect_str_eq(b.storeys[0].name, "ground floor");
    cr_expect(MAPS_READER_PLAN.recognise((Bytes){(unsigned char *)arena_string(&arena, text), strlen(text)}));
    cr_expect_not(MAPS_READER_PLAN.recognise(
        (Bytes){(unsigned char *)arena_string(&arena, "# planning\nplane 1"), 19}));
    arena_free(&arena);
}

typedef struct Bad {
    const char *text;
    int line;  // counted within the text
    const char *fragment;
} Bad;

// After HEAD.
static const Bad BAD_LINES[] = {
    {"rom x 0,0 1,0 1,1", 1, "unknown statement 'rom' (allowed: plan, storey, material"},
    {"plan 1", 1, "second 'plan'"},
    {"storey s floor 0 height 3", 1, "storey 's' already"},
    {"storey u floor 0", 1, "height is missing"},
    {"storey u floor 0 height -1", 1, "height is '-1' (allowed: a number from 0.1 to 1000 metres)"},
    {"storey u floor 0 height nan", 1, "height is 'nan'"},
    {"storey u floor inf height 3", 1, "floor is 'inf'"},
    {"storey u floor 0x10 height 3", 1, "floor is '0x10'"},
    {"storey u floor 1e999 height 3", 1, "floor is '1e999'"},
    {"storey u floor 0 height 3 height 4", 1, "height stands twice"},
    {"material red #00FF00", 1, "material 'red' already"},
    {"material blue 00FF00", 1, "colour is '00FF00' (allowed: #RRGGBB"},
    {"material blue #00FF0G", 1, "colour is '#00FF0G'"},
    {"material blue reflectance 1", 1, "reflectance is '1' (allowed: a number from 0 to 0.99"},
    {"material blue #00FF00 alpha 2", 1, "alpha is '2'"},
    {"material blue #00FF00 emission 1 2", 1, "emission is the end of the line"},
    {"material", 1, "name is missing"},
    {"ground green", 1, "no material 'green' (allowed so far: plain, red)"},
    {"ground red\nground red", 2, "second 'ground'"},
    {"facade", 1, "no material the end of the line"},
    {"room c 0,0 1,0", 1, "2 of corners"},
    {"room c 0,0 1,0 1,x", 1, "corners is '1,x' (allowed: x,y in metres"},
    {"room c 0,0 1,0 1,1,1", 1, "corners is '1,1,1'"},
    {"room c 0,0 1,0 2,0 wall 0.1", 1, "area of 0 m^2"},
    {"room c 0,0 1,0 1,1e9 wall 0.1", 1, "corners is '1,1e9'"},
    {"room c 0,0 1,0 1,1 floor blue", 1, "no material 'blue'"},
    {"room c 0,0 1,0 1,1 colour red", 1,
     "unknown word 'colour' (allowed: floor, ceiling, walls, wall, foot, height)"},
    {"room c 0,0 1,0 1,1 foot 4", 1, "allowed: floor below"},
    {"wall 0,0 1,0", 1, "thickness is missing"},
    {"wall 0,0 0,0 thickness 0.1", 1, "is 0 m long"},
    {"door d 4.1,2 angle 90 width 1", 1, "height is missing"},
    {"door d 2,2 width 1 height 2", 1, "stands in no wall"},
    {"door d 4.1,2 width 1 height 2", 1, "stands in no wall along its angle"},
    {"door d 4.1,2 angle 90 width 1 height 2 hinge top", 1, "hinge is 'top' (allowed: left right both)"},
    {"door d 4.1,2 angle 90 width 1 height 2 swing 270", 1,
     "swing is '270' (allowed: a number from -180 to 180 degrees)"},
    {"window w 2,-0.1 width 1 height 1", 1, "sill is missing"},
    {"window w 2,-0.1 width 1 height 1 sill 1 hinge left", 1, "unknown word 'hinge'"},
    {"window w 2,-0.1 width 1 height 1 sill 1 shape 0,0 1,0 2,1", 1, "corner 3 of the shape is 2,1"},
    {"passage p 4.1,2 angle 90 width 1 height 2 glazed", 1, "unknown word 'glazed'"},
    {"stairwell w 0,0 1,0", 1, "2 of corners"},
    {"stair s 1,1 width 1 depth 3 height 3 steps 0", 1,
     "steps is '0' (allowed: a whole number from 1 to 200)"},
    {"stair s 1,1 width 1 depth 3 height 3 steps 2.5", 1, "steps is '2.5'"},
    {"light l 1,1 flux 1", 1, "place is '1,1' (allowed: x,y,z"},
    {"light l 1,1,1 flux -1", 1, "flux is '-1'"},
    {"inlay red top 0,0 1,0 1,1", 1, "height (or 'floor', 'ceiling') is 'top'"},
    {"inlay red floor 0,0 2,0 1,0.5 1,2", 1, "not convex"},
    {"inlay red floor 0,0 1,0 2,0", 1, "not convex"},
    {"model m", 1, "model 'm' already"},
    {"model n kind chair", 1, "kind is 'chair' (allowed: furniture lamp"},
    {"model n\nroom c 0,0 1,0 1,1", 2, "unknown statement 'room' in a model (allowed: box, prism"},
    {"model n\nend", 2, "block of line 9 is empty"},
    {"model n\nbox 1,0,0 0,1,1 red\nend", 2, "allowed: lower corner first"},
    {"model n\nbox 0,0,0 1,1,1 red without lid\nend", 2, "without is 'lid' (allowed: top bottom left right"},
    {"model n\nprism red 1 0 0,0 1,0 1,1\nend", 2, "upper height is '0'"},
    {"model n\ncylinder red 0 1 0,0 radius 1 sides 2\nend", 2, "sides is '2'"},
    {"model n\npoly red 0,0,0 1,0,0 1,1,0.5 0,1,0\nend", 2, "off its plane (limit 0.001)"},
    {"model n\npoly red 0,0,0 1,0,0\nend", 2, "2 corners"},
    {"model n\nbox 0,0,0 1,1,1 red\n", 2, "ends inside the block of line 9"},
    {"place x 1,1", 1, "no model 'x'"},
    {"place m 1,1 angle 400", 1, "angle is '400'"},
    {"place m 1e8,1", 1, "a corner comes to"},
    {"place m", 1, "its place is the end of the line"},
    {"view v 1,1 yaw 0", 1, "the eye is '1,1'"},
    {"view v 1,1,1 yaw 0 pitch 91", 1, "pitch is '91'"},
    {"tour t\nend", 2, "allowed: at least one eye"},
    {"tour t\neye 1,1,1\nend", 2, "yaw is missing"},
    {"start 1,1 yaw 0\nstart 1,1", 2, "second 'start'"},
    {"start 1,1 0", 1, "unknown word '0' (allowed: yaw)"},
    {"start 9,9", 1, "lies in no room"},
    {"facade red red", 1, "'red' is left over"},
    {"material \"blue #00FF00", 1, "a quoted name is not closed"},
    {"material \"blue\"x #00FF00", 1, "no blank after"},
    {"material blue\x01 #00FF00", 1, "byte 1 at column 14"}};

static void expect_refused(const char *text, size_t size, int line, const char *fragment) {
    Arena arena = {0};
    Building b;
    Error error = {""};
    bool read = plan_read_bytes(&arena, text, size, &b, &error);
    cr_expect_not(read, "was read: %s", text);
    const char *place = arena_format(&arena, "t.plan:%d: ", line);
    cr_expect(strncmp(error.text, place, strlen(place)) == 0, "'%s' should begin with '%s'", error.text,
              place);
    cr_expect(strstr(error.text, fragment) != NULL, "'%s' should hold '%s'", error.text, fragment);
    arena_free(&arena);
}

// Each fault is refused with its file and line, what was found and what is allowed.
Test(plan, faults_are_named) {
    Arena arena = {0};
    for (int i = 0; i < (int)(sizeof BAD_LINES / sizeof BAD_LINES[0]); i++) {
        char *text = arena_format(&arena, "%s%s", HEAD, BAD_LINES[i].text);
        expect_refused(text, strlen(text), HEAD_LINES + BAD_LINES[i].line, BAD_LINES[i].fragment);
    }
    static const Bad WHOLE[] = {{"", 0, "the file holds nothing"},
                                {"# nothing\n", 1, "the file holds nothing"},
                                {"room a 0,0 1,0 1,1\n", 1, "begins with 'room' (allowed: plan 1)"},
                                {"plan 2\n", 1, "version is '2'"},
                                {"plan 1\nroom a 0,0 1,0 1,1\n", 2, "before any storey"},
                                {"plan 1\nstorey s floor 0 height 3\n", 2, "no room in the file"}};
    for (int i = 0; i < (int)(sizeof WHOLE / sizeof WHOLE[0]); i++)
        expect_refused(WHOLE[i].text, strlen(WHOLE[i].text), WHOLE[i].line, WHOLE[i].fragment);
    expect_refused("plan 1\nsto\0rey", 14, 2, "a zero byte at column 4");
    arena_free(&arena);
}
