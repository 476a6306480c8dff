// test_photometry_light.c - the light of lamps with photometric files: on floor and walls the closed form of the candela table, by every
// way in which light is found; and no light is lost.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/stills/still_light.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/gather.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/support/baked_fixture.h"
#include "tests/support/files/tables.h"
#include "tests/support/support.h"

// The lamp hangs here, turned; its sides leave 2.5 mm below and above.
static const Vec3 LAMP = {2.6, 2.3, 2.0};
static const double TURN = 30, HALF_GAP = 0.0025;
static const Vec3 ROOM = {6, 5, 3};

static BakedBuilding *room_with(Table table, Vec2 opening, double reflectance, double step) {
    Arena arena = {0};
    Error error;
    const char *folder = support_folder(&arena);
    const char *path = arena_format(&arena, "%s/room.plan", folder),
               *file = arena_format(&arena, "%s/lamp.ldt", folder);
    const char *plan = arena_format(&arena,
                                    "plan 1\nmaterial wall reflectance %g\nstorey s floor 0 height 3\n"
                                    "room hall 0,0 6,0 6,5 0,5 floor wall ceiling wall walls wall wall 0.15\n"
                                    "light lamp 2.6,2.3,2 photometry lamp.ldt angle 30\n",
                                    reflectance);
    const char *text = tables_ldt(&arena, table, tables_fewest(table), step, opening);
    cr_assert(file_write(path, plan, strlen(plan), &error) && file_write(file, text, strlen(text), &error),
              "%s", error.text);
    BakedBuilding *b = baked_building(path, 1e-3);
    arena_free(&arena);
    return b;
}

static double closed_form(Table table, Vec2 opening, Vec3 point, Vec3 normal) {
    const double z[2] = {LAMP.z - HALF_GAP, LAMP.z + HALF_GAP};
    return tables_lux(table, opening, TURN, vec2(LAMP.x, LAMP.y), z, point, normal);
}

// A point of one of the room's six sides, and its normal.
static Vec3 on_side(int side, double u, double v, Vec3 *normal) {
    double at[3] = {0, 0, 0}, n[3] = {0, 0, 0}, size[3] = {ROOM.x, ROOM.y, ROOM.z};
    int axis = side / 2;
    at[axis] = side % 2 ? size[axis] : 0;
    n[axis] = side % 2 ? -1 : 1;
    at[(axis + 1) % 3] = u * size[(axis + 1) % 3];
    at[(axis + 2) % 3] = v * size[(axis + 2) % 3];
    *normal = vec3(n[0], n[1], n[2]);
    return vec3(at[0], at[1], at[2]);
}

static const Vec2 OPENINGS[TABLES] = {{0.08, 0.08}, {0.2, 0.5}, {0.1, 1.2}, {0.6, 0.6}, {0.2, 0.2}};

// Proves that in a black room the illuminance on floor, walls and ceiling from five tables is the closed form of the table within 1 %, as
// it is gathered at a point, and as it is found at the nodes of the mesh. The tables are narrow, of a street light, of two symmetries,
// upward without symmetry, and even. Files have steps of 2.5 degrees, of the narrow lamp 1 degree, between which they are linear: that is
// within 0.6 % of the formulas at places brighter than 1/500 of the brightest; darker ones are not asked.
Test(photometry_light, floor_and_walls, .timeout = 120) {
    for (Table t = 0; t < TABLES; t++) {
        BakedBuilding *b = room_with(t, OPENINGS[t], 0, t == TABLE_SPOT ? 1 : 2.5);
        Arena arena = {0};
        GatherScene scene = {&b->mesh, &b->scene.forest, b->doors, &b->solution, NULL};
        GatherOptions options = gather_default_options();
        Gatherer *gatherer = gatherer_new(&scene, &options, &arena);
        enum { ALONG = 5, POINTS = 6 * ALONG * ALONG };
        double lux[POINTS], found[POINTS], brightest = 0, worst = 0;
        for (int i = 0; i < POINTS; i++) {
            Vec3 n, p = on_side(i / (ALONG * ALONG), (i % ALONG + 0.47) / ALONG,
                                (i / ALONG % ALONG + 0.53) / ALONG, &n);
            ViewPoint from = {p, n, gather_cell(b->mesh.graph, p, n, -1)};
            double h[3];
            gather(gatherer, &from, h);
            lux[i] = closed_form(t, OPENINGS[t], p, n);
            found[i] = LIGHT_LUMENS_PER_WATT * light_luminous(h);
            brightest = fmax(brightest, lux[i]);
        }
        int asked = 0;
        for (int i = 0; i < POINTS; i++) {
            if (lux[i] < brightest / 500) continue;
            asked++;
            worst = fmax(worst, fabs(found[i] / lux[i] - 1));
            cr_expect(fabs(found[i] / lux[i] - 1) < 0.01, "table %d, side %d: %g lx, not %g", t,
                      i / (ALONG * ALONG), found[i], lux[i]);
        }
        cr_expect_gt(asked, 20);
        Nodes nodes = nodes_of(&b->mesh, &arena);
        double(*h)[3] = arena_alloc(&arena, (size_t)nodes.count + 1, sizeof *h), at_nodes = 0;
        cr_assert(direct_irradiance(&b->mesh, &b->scene.forest, &nodes, NULL, 1, NULL, h, NULL));
        for (int n = 0; n < nodes.count; n++) {
            // Nodes of two sides have the mean of both; nodes of the lamp itself lie inside.
            Vec3 p = b->mesh.vertices[nodes.vertex[n]], normal = nodes.normal[n];
            bool inside = p.x > 0.1 && p.x < 5.9 && p.y > 0.1 && p.y < 4.9 && p.z > 0.1 && p.z < 2.9;
            if (inside || fmax(fabs(normal.x), fmax(fabs(normal.y), fabs(normal.z))) < 0.99) continue;
            double there = closed_form(t, OPENINGS[t], p, normal),
                   here = LIGHT_LUMENS_PER_WATT * light_luminous(h[n]);
            if (there < brightest / 500) continue;
            at_nodes = fmax(at_nodes, fabs(here / there - 1));
        }
        cr_expect_lt(at_nodes, 0.01, "table %d, nodes", t);
        printf("table %d: %d points within %.2g %%, nodes within %.2g %%\n", t, asked, 100 * worst,
               100 * at_nodes);
        gatherer_end(gatherer);
        arena_free(&arena);
        baked_building_free(b);
    }
}

// The side of the room in which an element lies; -1: the lamp's.
static int side_of(const Mesh *mesh, int element) {
    Plane plane = mesh->faces[mesh->elements[element].face].plane;
    for (int side = 0; side < 6; side++) {
        Vec3 n, p = on_side(side, 0.5, 0.5, &n);
        if (vec3_dot(n, plane.n) > 0.99 && fabs(plane_distance(plane, p)) < 1e-6) return side;
    }
    return -1;
}

// Proves that the light shot is the flux of the file, that none is lost, and that each side of the room gets as much of it as by the closed
// form. Tolerances: exitances are floats; rows are samples of 1 / 3 degree.
Test(photometry_light, is_shot, .timeout = 120) {
    for (Table t = 0; t < TABLES; t++) {
        BakedBuilding *b = room_with(t, OPENINGS[t], 0.5, 2.5);
        const Mesh *mesh = &b->mesh;
        double shot[6] = {0}, exact[6] = {0}, left = 0, all = 0;
        const Photometry *table = &b->scene.building.photometries[1];
        double lumens = LIGHT_LUMENS_PER_WATT * light_luminous(b->solution.emitted);
        cr_expect(fabs(lumens / photometry_lumens(table) - 1) < 2e-7, "table %d: %g lm shot, of %g", t,
                  lumens, photometry_lumens(table));
        for (int p = 0; p < mesh->patch_count; p++) left += b->solution.unshot[p][1] * mesh->patches[p].area;
        double kept = b->solution.absorbed[1] + b->solution.escaped[1] + left;
        cr_expect(fabs(kept / b->solution.emitted[1] - 1) < 1e-12, "table %d: %g of the light is kept", t,
                  kept / b->solution.emitted[1]);
        cr_expect_lt(b->solution.escaped[1], 1e-6 * b->solution.emitted[1]);
        for (int e = 0; e < mesh->element_count; e++) {
            int side = side_of(mesh, e);
            if (side < 0) continue;
            Vec3 n = mesh->faces[mesh->elements[e].face].plane.n;
            shot[side] += b->solution.direct[e][1] / 0.5 * mesh->elements[e].area * LIGHT_LUMENS_PER_WATT;
            exact[side] += closed_form(t, OPENINGS[t], element_centroid(mesh, e), n) * mesh->elements[e].area;
        }
        for (int side = 0; side < 6; side++) all += exact[side];
        for (int side = 0; side < 6; side++) {
            printf("table %d, side %d: %.1f lm shot, %.1f by the closed form\n", t, side, shot[side],
                   exact[side]);
            cr_expect(fabs(shot[side] - exact[side]) < 0.004 * all, "table %d, side %d: %g lm, not %g", t,
                      side, shot[side], exact[side]);
        }
        baked_building_free(b);
    }
}

// Proves that light by all reflections is that of random walks, which know the table, too: at points of all sides of a grey room, within
// three standard errors and the 1.5 % by which gathered light of a bake may be off in a room.
Test(photometry_light, as_walks_find_it, .timeout = 120) {
    for (Table t = TABLE_STREET; t <= TABLE_UP; t++) {
        BakedBuilding *b = room_with(t, OPENINGS[t], 0.5, 5);
        Arena arena = {0};
        GatherScene scene = {&b->mesh, &b->scene.forest, b->doors, &b->solution, NULL};
        GatherOptions options = gather_default_options();
        Gatherer *gatherer = gatherer_new(&scene, &options, &arena);
        PathTracer *tracer = path_tracer_new(&b->mesh, NULL, &arena);
        for (int side = 0; side < 6; side++) {
            Vec3 n, p = on_side(side, 0.37, 0.61, &n);
            ViewPoint from = {p, n, gather_cell(b->mesh.graph, p, n, -1)};
            PathQuery query = {p, n, 5e-3, 0, 400000, 7 + (uint64_t)side};
            PathResult walked;
            double h[3];
            gather(gatherer, &from, h);
            path_tracer_irradiance(tracer, &query, 1, 1, &walked);
            double off = h[1] / walked.irradiance[1] - 1,
                   error = walked.standard_error[1] / walked.irradiance[1];
            printf("table %d, side %d: %.4f gathered, %.4f +- %.4f walked\n", t, side, h[1],
                   walked.irradiance[1], walked.standard_error[1]);
            cr_expect(fabs(off) < 3 * error + 0.015, "table %d, side %d: off by %.2g %% +- %.2g %%", t, side,
                      100 * off, 100 * error);
        }
        path_tracer_end(tracer);
        gatherer_end(gatherer);
        arena_free(&arena);
        baked_building_free(b);
    }
}

// Proves that stills find the same light, near the lamp and far from it: at points of all sides of a room, lit by nothing else, within the
// 1 % that stills allow themselves.
Test(photometry_light, in_stills) {
    for (Table t = TABLE_STREET; t <= TABLE_UP; t++) {
        BakedBuilding *b = room_with(t, OPENINGS[t], 0.5, 2.5);
        RadSolution dark;
        Error error;
        double worst = 0;
        cr_assert(rad_start_dark(&b->mesh, &b->arena, &dark, &error), "%s", error.text);
        StillScene *scene = still_scene_new(&b->mesh, NULL, STILL_TREE_OWN, &b->arena);
        StillLamps *lamps = still_lamps_new(scene, &b->scene.forest, 16, &b->arena);
        StillLight light = still_light_new(scene, &dark, lamps, &b->arena);
        for (int i = 0; i < 6 * 9; i++) {
            Vec3 n, p = on_side(i / 9, (i % 3 + 0.47) / 3, (i / 3 % 3 + 0.53) / 3, &n);
            StillNumbers numbers = {{0.1, 0.2, 0.3}, 0};
            Ray ray = {vec3_add(p, vec3_scale(n, 0.5)), vec3_scale(n, -1), 0, INFINITY};
            SurfaceHit hit = still_rays_first(scene->all, &ray);
            double out[3], lux = closed_form(t, OPENINGS[t], p, n);
            still_light_at(&light, &ray, &hit, 0, 16, &numbers, out);
            if (lux > 0) worst = fmax(worst, fabs(LIGHT_LUMENS_PER_WATT * out[1] / 0.5 / lux - 1));
        }
        printf("table %d: stills within %.2g %%\n", t, 100 * worst);
        cr_expect_lt(worst, 0.01, "table %d: off by %g", t, worst);
        still_lamps_end(lamps);
        baked_building_free(b);
    }
}

// Proves that threads and culling do not show in the light of such lamps, and that a stored solution is taken back with its own table
// alone.
Test(photometry_light, same_bytes) {
    BakedBuilding *b = room_with(TABLE_UP, OPENINGS[TABLE_UP], 0.5, 15);
    RadSolution other[2], back;
    Error error;
    for (int i = 0; i < 2; i++) {
        RadOptions options = rad_default_options();
        options.residual = 1e-3;
        options.threads = i + 1;
        options.culling = i ? CULL_NONE : CULL_STAB;
        cr_assert(rad_start(&b->mesh, &b->arena, &other[i], &error));
        rad_shoot(&b->mesh, &b->scene.forest, b->doors, &options, NULL, &other[i]);
    }
    size_t size = (size_t)b->mesh.element_count * sizeof *other[0].radiosity;
    cr_expect_eq(memcmp(other[0].radiosity, other[1].radiosity, size), 0);
    cr_expect_eq(memcmp(other[0].direct, other[1].direct, size), 0);
    const char *path = arena_format(&b->arena, "%s/x.rad", support_folder(&b->arena));
    cr_assert(rad_save(path, &b->mesh, b->doors, &b->solution, &error), "%s", error.text);
    cr_expect(rad_load(path, &b->mesh, b->doors, &b->arena, &back, &error), "%s", error.text);
    b->scene.building.photometries[1].candela[5] *= 1.5;
    cr_expect_not(rad_load(path, &b->mesh, b->doors, &b->arena, &back, &error));
    baked_building_free(b);
}
