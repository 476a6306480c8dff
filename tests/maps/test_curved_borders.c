// test_curved_borders.c - neighbouring patches meet, trims leave what they should, and faults are named.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/curved/curved_patch.h"
#include "tests/maps/curved_shapes.h"
#include "tests/support/curved_fixture.h"

// ---- borders and trims

// Proves that two patches that share a border, one of them the other way round and with other curves elsewhere, meet in the
// same points at any tolerance.
Test(curved, neighbours_meet) {
    Random random = {11};
    for (int n = 0; n < 60; n++) {
        Arena arena = {0};
        CurvedControl control[2 * PATCH_CONTROLS];
        curved_random_patch(&random, control);
        curved_random_patch(&random, control + PATCH_CONTROLS);
        CurvedMesh mesh[2], both = {0};
        double tolerance = pow(10, curved_between(&random, -3, -0.5));
        for (int k = 0; k < 2; k++) {
            // u = 1 of the first is u = 0 of the other, turned round.
            for (int j = 0; k == 1 && j < 4; j++) control[PATCH_CONTROLS + 4 * j] = control[4 * (3 - j) + 3];
            Building b = {.controls = control};
            CurvedShape shape = {.kind = CURVED_PATCH, .first_control = k * PATCH_CONTROLS};
            curved_tessellate(&b, &shape, tolerance, &arena, &mesh[k]);
            for (int i = 0; i < mesh[k].polygon_count; i++)
                curved_mesh_add(&both, &arena, mesh[k].vertices + mesh[k].first[i],
                                mesh[k].first[i + 1] - mesh[k].first[i], k == 1);
        }
        // Sides turned: the second faces the other way, else its border would run as the first's does.
        CurvedControl border[4];
        curved_patch_border(control, 1, border);
        int steps = curved_border_steps(border, tolerance),
            alone = curved_open_edges(&mesh[0], &arena) + curved_open_edges(&mesh[1], &arena);
        int open = curved_open_edges(&both, &arena);
        cr_expect_eq(open, alone - 2 * steps, "pair %d: %d open edges, %d apart, %d shared", n, open, alone,
                     steps);
        arena_free(&arena);
    }
}

// A square of side 1 with its whole outline as a trim, and a circle in it; the circle from four exact quarters.
static const char SQUARE[] =
    "patch red 0,0,1 0.3333,0,1 0.6667,0,1 1,0,1 0,0.3333,1 0.3333,0.3333,1 0.6667,0.3333,1 "
    "1,0.3333,1 0,0.6667,1 0.3333,0.6667,1 0.6667,0.6667,1 1,0.6667,1 0,1,1 0.3333,1,1 "
    "0.6667,1,1 1,1,1 tolerance 0.0005\n"
    "trim 0,0 0.3,0 0.6,0 1,0 1,0.3 1,0.6 1,1 0.6,1 0.3,1 0,1 0,0.6 0,0.3 0,0\n";

static char *circle(Arena *arena, double x, double y, double r) {
    const double half = sqrt(0.5), far = r * 2 * half / (1 + 2 * half), w = (1 + 2 * half) / 3;
    return arena_format(arena,
                        "trim %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g "
                        "%.15g,%.15g %.15g,%.15g "
                        "%.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g weights 1 %.15g %.15g 1 "
                        "%.15g %.15g 1 %.15g "
                        "%.15g 1 %.15g %.15g 1\n",
                        x + r, y, x + r, y + far, x + far, y + r, x, y + r, x - far, y + r, x - r, y + far,
                        x - r, y, x - r, y - far, x - far, y - r, x, y - r, x + far, y - r, x + r, y - far,
                        x + r, y, w, w, w, w, w, w, w, w);
}

// Proves that a trim leaves the area it should, also where loops lie in and beside one another, and that what is left has no
// gaps: open edges lie on the loops alone.
Test(curved, trims_leave_what_they_should) {
    Arena arena = {0};
    const char *hole = circle(&arena, 0.5, 0.5, 0.3), *core = circle(&arena, 0.5, 0.5, 0.1),
               *alone = circle(&arena, 0.37, 0.41, 0.33), *second = circle(&arena, 0.8, 0.85, 0.1);
    const struct {
        char *trims;
        double area;
    } CASES[] = {
        {arena_format(&arena, "%s%s", SQUARE, hole), 1 - M_PI * 0.09},
        {arena_format(&arena, "%s%s%s", SQUARE, hole, core), 1 - M_PI * 0.08},
        {arena_format(&arena, "%.*s%s%s", (int)(strchr(SQUARE, '\n') + 1 - SQUARE), SQUARE, alone, second),
         M_PI * (0.33 * 0.33 + 0.01)}};
    for (size_t c = 0; c < sizeof CASES / sizeof *CASES; c++) {
        for (int way = 0; way < 2; way++) {
            Building b;
            curved_read_model(&arena, CASES[c].trims, way ? "3,2 angle 40 mirror" : "3,2", &b);
            CurvedMesh mesh = curved_all(&b, 0, &arena);
            // Chords of a circle leave out up to 0.5 mm along its 2 m.
            cr_expect_float_eq(curved_area(&mesh), CASES[c].area, 0.002, "case %d: %g", (int)c,
                               curved_area(&mesh));
        }
    }
    arena_free(&arena);
}

static double off_loop(const CurvedTrim *loop, int count, Vec3 p) {
    enum { STEPS = 2000 };
    double least = INFINITY;
    for (int i = 0; i < count * STEPS; i++) {
        Vec2 at = curved_trim_point(&loop[i / STEPS], (double)(i % STEPS) / STEPS);
        least = fmin(least, hypot(at.x - p.x, at.y - p.y));
    }
    return least;
}

// Proves that bent patches within loops of any form have, from above, the area within the loop (by Green's theorem), and that
// open edges lie on it and nowhere else. Tolerance: chords of the loop lie off it by about that of the patch, 3 mm.
Test(curved, trimmed_patches_have_no_gaps) {
    Random random = {13};
    for (int n = 0; n < 40; n++) {
        Arena arena = {0};
        CurvedControl control[PATCH_CONTROLS];
        // Seen from above, parameters are places.
        for (int i = 0; i < PATCH_CONTROLS; i++)
            control[i] =
                (CurvedControl){vec3(i % 4 / 3.0, i / 4 / 3.0, curved_between(&random, -0.2, 0.2)), 1};
        double x = curved_between(&random, 0.35, 0.65), y = curved_between(&random, 0.35, 0.65);
        CurvedTrim loop[3];
        Vec2 at[9];
        for (int i = 0; i < 9; i++) {
            double a = 2 * M_PI * i / 9, r = curved_between(&random, 0.1, 0.34);
            at[i] = vec2(x + r * cos(a), y + r * sin(a));
        }
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 4; i++) loop[k].point[i] = at[(3 * k + i) % 9], loop[k].weight[i] = 1;
        Building b = {.controls = control, .trims = loop};
        CurvedShape shape = {.kind = CURVED_PATCH, .trim_count = 3};
        CurvedMesh mesh;
        curved_tessellate(&b, &shape, 0.003, &arena, &mesh);
        double within = 0;
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 1000; i++) {
                Vec2 p = curved_trim_point(&loop[k], i / 1000.0),
                     q = curved_trim_point(&loop[k], (i + 1) / 1000.0);
                within += vec2_cross(p, q) / 2;
            }
        }
        Vec3 *ends;
        int open = curved_find_open(&mesh, &arena, &ends);
        cr_expect_gt(open, 10);
        for (int i = 0; i < 2 * open; i++) {
            double off = off_loop(loop, 3, ends[i]);
            cr_assert_lt(off, 0.006, "loop %d: an open edge ends at (%g, %g), %g off", n, ends[i].x,
                         ends[i].y, off);
        }
        double flat = 0;
        for (int i = 0; i < mesh.polygon_count; i++) {
            Vec3 v[32];
            int count = mesh.first[i + 1] - mesh.first[i];
            for (int k = 0; k < count; k++) {
                v[k] = mesh.vertices[mesh.first[i] + k];
                v[k].z = 0;
            }
            flat += polygon_area(v, count);
        }
        cr_expect_float_eq(flat, fabs(within), 0.003, "loop %d: %g of %g", n, flat, within);
        arena_free(&arena);
    }
}

// ---- what is refused

typedef struct Bad {
    const char *lines, *fragment;
} Bad;

static const char FOLDED[] =
    "patch red 0,0,0 2,0,0 -1,0,0 1,0,0 0,0.3,0 2,0.3,0 -1,0.3,0 1,0.3,0 0,0.6,0 2,0.6,0 "
    "-1,0.6,0 1,0.6,0 0,1,0 2,1,0 -1,1,0 1,1,0";

static const char LINE[] =
    "patch red 0,0,0 1,0,0 2,0,0 3,0,0 0,0,0 1,0,0 2,0,0 3,0,0 0,0,0 1,0,0 2,0,0 3,0,0 0,0,0 "
    "1,0,0 2,0,0 3,0,0";

// A loop of 80 curves all over the square.
static char *scribble(Arena *arena, int head) {
    Random random = {17};
    char *text = arena_format(arena, "%.*s\ntrim 0.5,0.5", head, SQUARE);
    for (int i = 1; i < 240; i++)
        text = arena_format(arena, "%s %.3f,%.3f", text, curved_between(&random, 0, 1),
                            curved_between(&random, 0, 1));
    return arena_format(arena, "%s 0.5,0.5", text);
}

// Proves that bad shapes are refused with what is wrong and what is allowed.
Test(curved, faults_are_named) {
    Arena arena = {0};
    int head = (int)(strchr(SQUARE, '\n') - SQUARE);
    const char *weights = "1 1 1 1 1 1 1 1 1 1 1 1 1 1 1";
    const Bad BAD[] = {
        {"sphere red 0,0,1 radius 0", "radius is '0' (allowed: a number from 0.001 to 100 metres)"},
        {"sphere red 0,0,1", "radius is missing"},
        {"sphere red 0,0 radius 1", "the centre is '0,0'"},
        {"sphere red 0,0,1 radius 1 tolerance 0",
         "tolerance is '0' (allowed: a number from 1e-05 to 1 metres)"},
        {"sphere red 0,0,1 radius 90 tolerance 0.0001", "takes too many polygons"},
        {"ellipsoid red 0,0,1 radii 1,0,1",
         "radii is '1,0,1' (allowed: x,y,z, each from 0.001 to 100 metres)"},
        {"cylinder red 0 1 0,0 radius 1 sides 8 round", "sides that is round"},
        {"cylinder red 0 1 0,0 radius 1 tolerance 0.1", "a tolerance that is not round"},
        {"cylinder red 1 1 0,0 radius 1 round", "the cylinder has no height"},
        {"cone red 0,0,1 0,0,1 radius 1", "the cone is 0 metres high"},
        {"cone red 0,0,1 0,0,2 radius 0 top 1", "radius is '0'"},
        {"lathe red 0,0 profile 1,0 1,1 1,2", "the profile has 3 points r,z (allowed: 4, 7, 10"},
        {"lathe red 0,0 profile 1,0 1,1 1,2 -1,3", "point 4 of the profile has radius -1"},
        {"lathe red 0,0 profile 0,0 0,1 0,2 0,3", "part 1 of the profile lies on a line"},
        {"lathe red 0,0 profile 1,0 1,2 1,-1 1,1", "part 1 of the profile folds over itself near"},
        {FOLDED, "the patch folds over itself near u"},
        {LINE, "the patch lies on a line or in a point"},
        {"patch red 0,0,0 1,0,0", "the patch has 2 control points (allowed: 16"},
        {arena_format(&arena, "%.*s weights %s", head, SQUARE, weights),
         "the patch has 15 weights (allowed: 16"},
        {arena_format(&arena, "%.*s weights %s 0", head, SQUARE, weights), "weights is '0'"},
        {arena_format(&arena, "%.*s\ntrim 0,0 0.1,0 0.2,0 0.3,0.1", head, SQUARE),
         "begins at 0,0 and ends at 0.3,0.1"},
        {arena_format(&arena, "%.*s\ntrim 0,0 1.1,0 1,1 0,0", head, SQUARE), "point 2 of the trim is 1.1,0"},
        {arena_format(&arena, "%.*s\ntrim 0,0 1,0 1,1 0,1 0,0", head, SQUARE), "the trim has 5 points"},
        {arena_format(&arena, "%.*s\ntrim 0,0 1,1 1,1 0,0", head, SQUARE),
         "nothing of the shape can be seen"},
        {scribble(&arena, head), "the trims cut the patch into too many pieces"},
        {"box 0,0,0 1,1,1 red\ntrim 0,0 1,0 1,1 0,0", "a trim of nothing (allowed: behind a patch)"},
        {"ball 0,0,0 radius 1", "a ball of nothing"},
        {"metaballs red threshold 0.5", "the metaballs have no ball"},
        {"metaballs red threshold 0\nball 0,0,0 radius 1", "threshold is '0'"},
        {"metaballs red threshold 1.5\nball 0,0,0 radius 1\nball 3,0,0 radius 1",
         "the field of the metaballs reaches 1, their threshold is 1.5"},
        {"metaballs red threshold 0.5\nball 0,0,0 radius 1 weight 0", "the ball's weight is 0"},
        {"metaballs red threshold 0.5\nball 0,0,0 radius 0", "radius is '0'"}};
    for (size_t i = 0; i < sizeof BAD / sizeof *BAD; i++) {
        Building b;
        Error error = {""};
        cr_expect_not(curved_try_model(&arena, BAD[i].lines, "2,2", &b, &error), "was read: %s",
                      BAD[i].lines);
        cr_expect(strstr(error.text, BAD[i].fragment), "%s: '%s' should hold '%s'", BAD[i].lines, error.text,
                  BAD[i].fragment);
    }
    arena_free(&arena);
}
