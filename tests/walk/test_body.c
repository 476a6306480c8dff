// test_body.c - the walking body: it is never in anything solid, and loses no place that can be reached by foot; and the
// places where such bodies usually fail, each by its name.
#include <criterion/criterion.h>

#include "engine/sim/collision_check.h"
#include "engine/sim/collision_walk.h"
#include "engine/sim/door_part.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

typedef struct Walker {
    Arena arena;
    Building building;
    CellGraph graph;
    Doors doors;
    BodyWorld world;
    CollisionCheck *check;
    Body body;
} Walker;

static void open_cells(Walker *w) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(vis_build_cells(&w->building, &options, &w->arena, &w->graph, &error), "%s", error.text);
    w->doors = doors_new(&w->graph, &w->arena);
    w->world = body_world(&w->graph, w->doors.open, &w->arena);
    w->check = collision_check_new(&w->graph, &w->arena);
    w->body = (Body){.cell = -1};
}

static void open_building(Walker *w, const char *path) {
    Error error;
    cr_assert(maps_read(path, &w->arena, &w->building, &error), "%s", error.text);
    open_cells(w);
}

static void open_file(Walker *w, const char *path) {
    *w = (Walker){.arena = {0}};
    open_building(w, path);
}

// A building in words.
static void open_plan(Walker *w, const char *plan) {
    Error error;
    *w = (Walker){.arena = {0}};
    char *path = arena_format(&w->arena, "%s/test.plan", support_folder(&w->arena));
    cr_assert(file_write(path, plan, strlen(plan), &error), "%s", error.text);
    open_building(w, path);
}

static void stand(Walker *w, double x, double y, double z) {
    cr_assert(body_place_near(&w->body, &w->world, vec3(x, y, z)), "no place at %g, %g, %g", x, y, z);
    cr_assert(fabs(w->body.foot.x - x) < 1e-9 && fabs(w->body.foot.y - y) < 1e-9,
              "%g, %g, %g is taken: it stands at %g, %g", x, y, z, w->body.foot.x, w->body.foot.y);
}

static void expect_free(Walker *w, const char *where) {
    int what;
    CollisionFault f = collision_check_place(w->check, w->doors.open, w->body.foot, w->body.height, &what);
    cr_assert_eq(f, COLLISION_NONE, "%s: %s (%d) at %.9g, %.9g, %.9g", where, COLLISION_FAULT_NAMES[f], what,
                 w->body.foot.x, w->body.foot.y, w->body.foot.z);
    cr_assert_eq(w->body.cell,
                 vis_locate(&w->graph, vec3(w->body.foot.x, w->body.foot.y, w->body.foot.z + BODY_MIDDLE),
                            w->body.cell),
                 "%s: cell %d does not hold it", where, w->body.cell);
    cr_assert_eq(w->world.relocations, 0, "%s: put elsewhere", where);
}

// Walks so far, and expects to arrive within a millimetre.
static void go(Walker *w, double x, double y, const char *where) {
    Vec3 start = w->body.foot;
    body_step(&w->body, &w->world, vec2(x, y), 0.05);
    expect_free(w, where);
    cr_assert(hypot(w->body.foot.x - start.x - x, w->body.foot.y - start.y - y) < 1e-3,
              "%s: from %g, %g by %g, %g it came to %g, %g", where, start.x, start.y, x, y, w->body.foot.x,
              w->body.foot.y);
}

// Expects to be stopped within this much of the way, in the direction of the way.
static void expect_stop(Walker *w, double x, double y, double after, const char *where) {
    Vec3 start = w->body.foot;
    body_step(&w->body, &w->world, vec2(x, y), 0.05);
    expect_free(w, where);
    double gone = ((w->body.foot.x - start.x) * x + (w->body.foot.y - start.y) * y) / hypot(x, y);
    // Tolerance: the skin, 0.1 mm, and what is left of the last piece.
    cr_assert(fabs(gone - after) < 1e-3, "%s: stopped after %g m, not %g", where, gone, after);
}

// ---- geometry

// Convex, of 3 to 7 corners, flat, upright or sloping.
static Solid random_solid(Random *r, Vec3 *vertices) {
    int count = 3 + random_index(r, 5);
    Vec3 n = fixture_direction(r);
    if (random_unit(r) < 0.3) n = vec3(0, 0, 1);
    if (random_unit(r) < 0.3) n = vec3_normalize(vec3(n.x, n.y, 0));
    Vec3 u = vec3_normalize(vec3_cross(n, fabs(n.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0))),
         v = vec3_cross(n, u);
    Vec3 middle = vec3(random_between(r, -1, 1), random_between(r, -1, 1), random_between(r, 0, 2));
    double size = random_between(r, 0.05, 1.2);
    Solid s = {.vertices = vertices, .count = count, .box = box_empty()};
    for (int i = 0; i < count; i++) {
        double a = 2 * M_PI * (i + 0.6 * random_unit(r)) / count;
        vertices[i] = vec3_add(middle, vec3_add(vec3_scale(u, size * cos(a)), vec3_scale(v, size * sin(a))));
        s.box = box_add(s.box, vertices[i]);
    }
    return s;
}

// Proves that a sweep stops where the distance becomes the radius, and not before: by small steps along the way.
Test(solid, sweep_stops_where_the_distance_says) {
    enum { STEPS = 400 };
    Random r = {11};
    int hits = 0;
    for (int i = 0; i < support_count(20000, 400000); i++) {
        Vec3 vertices[8];
        Solid s = random_solid(&r, vertices);
        Band band = {random_between(&r, 0, 1), random_between(&r, 1, 2)};
        double radius = random_between(&r, 0.05, 0.5);
        Vec2 from = vec2(random_between(&r, -3, 3), random_between(&r, -3, 3)), normal;
        Vec2 way = vec2(random_between(&r, -3, 3), random_between(&r, -3, 3));
        if (solid_distance(&s, band, from) < radius) continue;
        double t = solid_sweep(&s, band, from, way, radius, &normal);
        for (int k = 0; k < STEPS; k++) {
            Vec2 at = vec2_add(from, vec2_scale(way, t * k / STEPS));
            // Tolerance: rounding of a quadratic's root, far below BODY_TOLERANCE.
            cr_assert_geq(solid_distance(&s, band, at), radius - 1e-9, "case %d: too near at %d of %d", i, k,
                          STEPS);
        }
        if (t >= 1) continue;
        hits++;
        Vec2 at = vec2_add(from, vec2_scale(way, t)), beyond = vec2_add(from, vec2_scale(way, t + 1e-6));
        cr_assert_float_eq(solid_distance(&s, band, at), radius, 1e-9, "case %d stops early", i);
        cr_assert_lt(solid_distance(&s, band, beyond), radius, "case %d stops where nothing is", i);
        cr_assert_float_eq(vec2_length(normal), 1, 1e-9);
        cr_assert_lt(vec2_dot(normal, way), 0);
    }
    cr_assert_gt(hits, 1000);
}

// Proves that the heights over a disc are those of points of the polygon over it, and that no such point is beyond.
Test(solid, levels_hold_every_point_over_the_disc) {
    Random r = {12};
    int seen = 0;
    for (int i = 0; i < support_count(20000, 400000); i++) {
        Vec3 vertices[8];
        Solid s = random_solid(&r, vertices);
        Vec2 at = vec2(random_between(&r, -1, 1), random_between(&r, -1, 1));
        double radius = random_between(&r, 0.05, 0.5), low = INFINITY, high = -INFINITY;
        Band levels;
        for (int k = 0; k < 200; k++) {
            Vec3 p = vertices[0];
            for (int c = 1; c < s.count; c++) p = vec3_lerp(p, vertices[c], pow(random_unit(&r), 1.5));
            if (hypot(p.x - at.x, p.y - at.y) >= radius) continue;
            low = fmin(low, p.z);
            high = fmax(high, p.z);
        }
        bool over = solid_levels(&s, at, radius, &levels);
        if (low > high) continue;
        seen++;
        cr_assert(over && levels.z0 <= low + 1e-9 && levels.z1 >= high - 1e-9,
                  "case %d: points from %g to %g, levels from %g to %g", i, low, high, levels.z0, levels.z1);
        // Just above and below there is nothing within the radius.
        cr_assert_geq(solid_distance(&s, (Band){levels.z1 + 1e-7, INFINITY}, at), radius - 1e-5, "case %d",
                      i);
        cr_assert_geq(solid_distance(&s, (Band){-INFINITY, levels.z0 - 1e-7}, at), radius - 1e-5, "case %d",
                      i);
    }
    cr_assert_gt(seen, 1000);
}

// Proves that the heights of a bent quadrilateral hold every point of its triangles over the disc, and are not much farther: one
// corner is off the others' plane by up to a millimetre, as is allowed.
Test(solid, levels_hold_what_is_bent) {
    Random r = {13};
    for (int i = 0; i < support_count(2000, 40000); i++) {
        Vec3 v[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        double sx = random_between(&r, -0.7, 0.7), sy = random_between(&r, -0.7, 0.7);
        Solid s = {.vertices = v, .count = 4, .box = box_empty()};
        double bend = random_between(&r, -0.001, 0.001), radius = random_between(&r, 0.1, 0.4);
        for (int k = 0; k < 4; k++) {
            v[k].z = sx * v[k].x + sy * v[k].y + (k == 2 ? bend : 0);
            s.box = box_add(s.box, v[k]);
        }
        Vec2 at = vec2(random_between(&r, -0.5, 0.5), random_between(&r, -0.5, 0.5));
        Band levels, points = {INFINITY, -INFINITY};
        cr_assert(solid_levels(&s, at, radius, &levels));
        for (int k = 0; k < 400; k++) {
            // Cut from the bent corner to the one across, or between the others: below, and above the diagonal.
            double a = 2 * M_PI * k / 400, x = at.x + radius * cos(a), y = at.y + radius * sin(a);
            double along = fmin(x, y) + 1, off = fmax(0, x + y), z = sx * x + sy * y;
            for (int cut = 0; cut < 2; cut++) {
                double at_point = z + bend * (cut ? off / 2 : along / 2);
                points = (Band){fmin(points.z0, at_point), fmax(points.z1, at_point)};
            }
        }
        cr_assert(levels.z0 <= points.z0 + 1e-9 && levels.z1 >= points.z1 - 1e-9,
                  "case %d: from %g to %g, levels from %g to %g", i, points.z0, points.z1, levels.z0,
                  levels.z1);
        // Levels are two bends off the plane, of a quarter of what the corner is off; points of the rim miss its highest by 0.02 mm.
        double most = fabs(bend) + 2e-5;
        cr_assert(levels.z0 >= points.z0 - most && levels.z1 <= points.z1 + most,
                  "case %d: from %g to %g, levels from %g to %g", i, points.z0, points.z1, levels.z0,
                  levels.z1);
    }
}

// ---- what is in the way

static double from_segment(Vec2 a, Vec2 b, Vec2 p) {
    Vec2 along = vec2_sub(b, a), to = vec2_sub(p, a);
    double t = fmin(fmax(vec2_dot(to, along) / fmax(vec2_dot(along, along), 1e-30), 0), 1);
    return vec2_length(vec2_sub(to, vec2_scale(along, t)));
}

// How far a portal is in plan.
static double from_portal(const CellGraph *g, int portal, Vec2 p) {
    const Portal *at = &g->portals[portal];
    const Vec3 *v = g->portal_vertices + at->first_vertex;
    double nearest = INFINITY;
    int left = 0;
    for (int i = 0, n = at->vertex_count; i < n; i++) {
        Vec2 a = vec2(v[i].x, v[i].y), b = vec2(v[(i + 1) % n].x, v[(i + 1) % n].y);
        nearest = fmin(nearest, from_segment(a, b, p));
        left += vec2_cross(vec2_sub(b, a), vec2_sub(p, a)) > 0;
    }
    return at->horizontal && (left == 0 || left == at->vertex_count) ? 0 : nearest;
}

static Box portal_box(const CellGraph *g, int portal) {
    Box box = box_empty();
    for (int i = 0; i < g->portals[portal].vertex_count; i++)
        box = box_add(box, g->portal_vertices[g->portals[portal].first_vertex + i]);
    return box;
}

// The cells that portals no farther than `radius`, of which something is in the box, lead to from one; not into windows.
static void reach_cells(const Walker *w, int cell, Vec2 at, double radius, Box box, unsigned char *reached) {
    const CellGraph *g = &w->graph;
    memset(reached, 0, (size_t)g->cell_count);
    reached[cell] = 1;
    for (bool more = true; more;) {
        more = false;
        for (int p = 0; p < g->portal_count; p++) {
            const int *c = g->portals[p].cell;
            int beyond = reached[c[0]] ? c[1] : c[0];
            if (reached[c[0]] == reached[c[1]] || obstacles_is_shut(w->world.obstacles, beyond)) continue;
            if (from_portal(g, p, at) > radius || !box_overlap(portal_box(g, p), box)) continue;
            reached[beyond] = 1;
            more = true;
        }
    }
}

static bool gathers(const Gathered *g, const Vec3 *vertices) {
    int found = 0;
    for (int i = 0; i < g->solid_count; i++) found += g->solids[i].vertices == vertices;
    cr_assert_leq(found, 1, "it is there twice");
    return found == 1;
}

static Box polygon_box(const CellGraph *g, int polygon) {
    Box box = box_empty();
    for (int i = 0; i < g->polygons[polygon].vertex_count; i++)
        box = box_add(box, g->vertices[g->polygons[polygon].first_vertex + i]);
    return box;
}

// Are all drawn polygons in the box gathered, and of walls those of cells near by only? Returns how many they are.
static int expect_gathered(Walker *w, int cell, Vec2 at, double radius, Band band, unsigned char *near,
                           unsigned char *far) {
    const CellGraph *g = &w->graph;
    Box box = {{at.x - radius, at.y - radius, band.z0}, {at.x + radius, at.y + radius, band.z1}};
    Gathered found = obstacles_gather(w->world.obstacles, w->doors.open, cell, at, radius, band);
    int solids = 0, owner = 0;
    reach_cells(w, cell, at, 0.999 * radius, box_grow(box, -1e-9), near);
    // Outside one of its edges by more than the radius a portal is away: in corners that is up to the diagonal, and more in acute ones.
    reach_cells(w, cell, at, 4 * radius, box, far);
    for (int o = 0; o < g->object_count; o++) {
        const Object *object = &g->objects[o];
        while (owner < g->cell_count && o >= g->surface_first[owner + 1]) owner++;
        bool surface = o >= g->surface_first[0], frame = object->kind == OBJECT_FRAME;
        if (object->plug || object->leaf >= 0 || (surface && owner == g->cell_count) || frame) continue;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            bool there = gathers(&found, g->vertices + g->polygons[p].first_vertex),
                 within = box_overlap(polygon_box(g, p), box);
            cr_assert(within || !there, "polygon %d is not near", p);
            cr_assert(there || !within || (surface && !near[owner]),
                      "polygon %d of object %d (%s) is in the way", p, o, object->name);
            cr_assert(!there || !surface || far[owner], "polygon %d is of cell %d, not near by", p, owner);
            solids += there;
        }
    }
    for (int l = 0; l < w->building.leaf_count; l++) {
        const Leaf *leaf = &w->building.leaves[l];
        Vec2 corner[LEAF_CORNERS];
        double open = (double)w->doors.open[leaf->opening];
        int count = leaf_plan(&w->building, leaf, open, corner), there = 0;
        Box reach = box_empty();
        for (int i = 0; i < count; i++)
            reach = box_add(reach, vec3(corner[i].x, corner[i].y, leaf->z0 + open * leaf->rise));
        reach.max.z = leaf->z1 + open * leaf->rise;
        for (int i = 0; i < found.solid_count; i++) {
            const Solid *s = &found.solids[i];
            there += s->prism && s->count == count && s->box.min.z == reach.min.z &&
                     s->vertices[0].x == corner[0].x && s->vertices[0].y == corner[0].y;
        }
        cr_assert_eq(there, box_overlap(reach, box), "leaf %d", l);
    }
    return solids;
}

// A straight way ends in the cell that holds its end where free space goes on all the way, and nowhere where a wall is before that.
static int expect_crossing(Walker *w, int cell, Vec3 from, Vec3 to) {
    const CellGraph *g = &w->graph;
    double length = vec3_length(vec3_sub(to, from));
    Trace trace;
    if (length < 1e-3 ||
        !fixture_trace(g, cell, from, vec3_scale(vec3_sub(to, from), 1 / length), NULL, &trace))
        return 0;
    double free = vec3_length(vec3_sub(trace.hit, from));
    bool shut = false;
    for (int i = 0; i < trace.count; i++)
        shut = shut || obstacles_is_shut(w->world.obstacles, trace.cells[i]);
    int end = vis_locate(g, to, cell), found = obstacles_cross(w->world.obstacles, cell, from, to);
    if (free > length + 1e-4 && !shut)
        cr_assert(found >= 0 && found == end, "from %g, %g, %g in cell %d to %g, %g, %g in %d: %d", from.x,
                  from.y, from.z, cell, to.x, to.y, to.z, end, found);
    if (free < length - 1e-2) cr_assert_eq(found, -1, "through a wall from cell %d to %d", cell, found);
    return free < length - 1e-2 ? 1 : 2;
}

// Proves what is found to be in the way against all that is drawn, and which ways lead on against straight lines: in homes of several
// storeys, with doors anyhow, at a slant and far off.
Test(solid, obstacles_are_all_there_is) {
    static const char *const FILES[] = {"build/maps/hillside.sh3d", "build/maps/house.plan", NULL, NULL};
    int solids = 0, ways[3] = {0};
    for (int f = 0; f < 4; f++) {
        Walker w = {.arena = {0}};
        Random random = {(uint64_t)f + 3};
        Error error;
        if (FILES[f]) {
            cr_assert(maps_read(FILES[f], &w.arena, &w.building, &error), "%s", error.text);
        } else {
            w.building = *fixture_rooms(&w.arena, &random, 3, 2, 2);
            fixture_place(&w.building, f == 2 ? 0 : 0.6, vec3(-80, 250, 1));
        }
        open_cells(&w);
        const CellGraph *g = &w.graph;
        unsigned char *near = ARENA_ARRAY(&w.arena, unsigned char, g->cell_count),
                      *far = ARENA_ARRAY(&w.arena, unsigned char, g->cell_count);
        for (int i = 0; i < support_count(250, 5000); i++) {
            for (int o = 0; o < w.building.opening_count; o++)
                if (w.building.openings[o].kind == OPENING_DOOR)
                    doors_set(&w.doors, o, random_index(&random, 2) ? 0 : (float)random_unit(&random));
            int cell = random_index(&random, g->cell_count);
            if (obstacles_is_shut(w.world.obstacles, cell)) continue;
            Vec3 p = fixture_point(g, &random, cell);
            double radius = random_between(&random, 0.05, 0.8);
            Band band = {p.z - random_between(&random, 0, 1), p.z + random_between(&random, 0, 1)};
            solids += expect_gathered(&w, cell, vec2(p.x, p.y), radius, band, near, far);
            for (int k = 0; k < 20; k++) {
                Vec3 way = vec3_scale(fixture_direction(&random), random_between(&random, 0, 2));
                way = k % 4 ? vec3(way.x, way.y, 0) : vec3(0, 0, way.z);
                ways[expect_crossing(&w, cell, p, vec3_add(p, way))]++;
            }
        }
        arena_free(&w.arena);
    }
    cr_assert(solids > 1000 && ways[1] > 1000 && ways[2] > 1000, "%d solids, %d ways shut, %d open", solids,
              ways[1], ways[2]);
}

// ---- whole buildings

// A random walk with doors moving, every place and every way checked against all polygons; and the ways of a flood of
// the floor, walked. `steps` at `make test`.
static void expect_no_fault(const char *path, long steps, int flood_every) {
    enum { SEEDS = 4 };
    Walker w = {.arena = {0}};
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, &w.arena, &w.building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&w.building, &options, &w.arena, &w.graph, &error), "%s", error.text);
    int seeds = support_soak() ? SEEDS : 1;
    for (int seed = 1; seed <= seeds; seed++) {
        CollisionWalkOptions o = {support_soak() ? 1000000 / SEEDS : steps, (uint64_t)seed,
                                  support_soak() ? 1 : flood_every};
        CollisionReport r;
        cr_assert(collision_walk(&w.graph, &o, &r, &error), "%s", error.text);
        cr_assert_eq(collision_violations(&r), 0, "%s: %ld violations, the first: %s", path,
                     collision_violations(&r), r.first_fault);
        cr_assert_eq(r.flood_lost, 0, "%s: %ld of %ld ways of the flood lost, the first: %s", path,
                     r.flood_lost, r.flood_ways, r.first_lost);
        cr_assert_eq(r.relocations, 0, "%s: put elsewhere %ld times", path, r.relocations);
        cr_assert_eq(r.stuck, 0, "%s: stuck %ld times", path, r.stuck);
        // A leaf may shut it in a corner, until that door is used or the body put elsewhere: some hundred steps each time.
        cr_assert_leq(r.shut_in, r.steps / 100, "%s: shut in %ld times", path, r.shut_in);
        cr_assert_gt(r.flood_places, 1000);
    }
    arena_free(&w.arena);
}

Test(body, two_rooms, .timeout = 1800) { expect_no_fault("build/maps/two-rooms.plan", 50000, 7); }
Test(body, house, .timeout = 1800) { expect_no_fault("build/maps/house.plan", 40000, 41); }
Test(body, office, .timeout = 3600) { expect_no_fault("build/maps/office-plain.plan", 40000, 97); }
Test(body, home_with_basement, .timeout = 1800) {
    expect_no_fault(support_either("sh3d/2BedroomHouseWithBasement.Home.xml", "build/maps/hillside.sh3d"),
                    40000, 41);
}
Test(body, apartment, .timeout = 1800) {
    expect_no_fault(support_either("sh3d/3BedroomApartment.Home.xml", "build/maps/flat.Home.xml"), 40000, 41);
}
Test(body, four_bedrooms, .timeout = 3600) {
    expect_no_fault(support_either("sh3d/4-BedroomHouse.sh3d", "build/maps/villa.sh3d"), 20000, 197);
}
// Polygons alone, with a roof to stand on as far as the border of the world, which runs along the outer walls.
Test(body, two_rooms_of_polygons, .timeout = 1800) {
    expect_no_fault(support_either("radiosity/twoRoom.quads", "tests/seeds/two-rooms.quads"), 20000, 1);
}
Test(body, box_of_polygons, .timeout = 1800) {
    expect_no_fault(support_either("radiosity/boxA.quads", "tests/seeds/boxes.quads"), 20000, 1);
}

// Proves that the check above can fail: a body that is moved into a wall, through a wall and into a leaf is noticed.
Test(body, check_notices) {
    Walker w;
    int what;
    open_file(&w, "build/maps/two-rooms.plan");
    stand(&w, 0.8, 0.8, 0);
    Vec3 foot = w.body.foot, outside = {-0.5, foot.y, foot.z}, wall = {0.1, foot.y, foot.z};
    cr_assert_eq(collision_check_place(w.check, NULL, foot, 1.7, &what), COLLISION_NONE);
    cr_assert_eq(collision_check_place(w.check, NULL, wall, 1.7, &what), COLLISION_IN_SOLID);
    cr_assert_eq(collision_check_way(w.check, NULL, foot, outside, &what), COLLISION_THROUGH_SOLID);
    const Opening *door = &w.building.openings[0];
    cr_assert_eq(door->kind, OPENING_DOOR);
    Vec2 middle = vec2_scale(vec2_add(door->line[0], door->line[1]), 0.5);
    Vec2 half = vec2_scale(vec2_sub(door->line[1], door->line[0]), 0.5);
    Vec3 in = {middle.x, middle.y, door->sill}, before = {in.x + half.y, in.y - half.x, in.z},
         behind = {in.x - half.y, in.y + half.x, in.z};
    cr_assert_eq(collision_check_place(w.check, NULL, in, 1.7, &what), COLLISION_NONE);
    doors_set(&w.doors, 0, 0);
    cr_assert_eq(collision_check_place(w.check, w.doors.open, in, 1.7, &what), COLLISION_IN_LEAF);
    cr_assert_eq(collision_check_way(w.check, w.doors.open, before, behind, &what), COLLISION_THROUGH_LEAF);
    arena_free(&w.arena);
}

// Proves that the same seed walks the same way to the last bit, and another one another way.
Test(body, walks_the_same_way_again) {
    Walker w;
    uint64_t hash[3];
    open_file(&w, "build/maps/two-rooms.plan");
    for (int i = 0; i < 3; i++) {
        CollisionWalkOptions o = {2000, i == 2 ? 6 : 5, 1000};
        CollisionReport r;
        Error error;
        cr_assert(collision_walk(&w.graph, &o, &r, &error), "%s", error.text);
        hash[i] = r.hash;
    }
    cr_assert(hash[0] == hash[1] && hash[0] != hash[2]);
    arena_free(&w.arena);
}

// ---- where such bodies fail

#define HEAD "plan 1\nmaterial m #808080\n"
// Two rooms with a wall of 0.2 m between, and a passage.
#define ROOMS                                                                                                \
    HEAD "storey s floor 0 height 2.6\nroom a 0,0 4,0 4,4 0,4 wall 0.2\nroom b 4.2,0 8.2,0 8.2,4 4.2,4 "     \
         "wall 0.2\n"

// Proves that the axis may be exactly on a portal's plane: placed there, walking along it, across it and back.
Test(body, on_the_plane_of_a_portal) {
    Walker w;
    open_plan(&w, ROOMS "passage p 4.1,2 angle 90 width 1.2 height 2.1\n");
    stand(&w, 4, 2, 0);
    go(&w, 0, 0.2, "along the plane");
    go(&w, 0, -0.4, "back along it");
    go(&w, 1, 0, "across it");
    stand(&w, 4.2, 2, 0);
    go(&w, 0, 0.3, "along the other plane");
    go(&w, -1, 0, "across both");
    arena_free(&w.arena);
}

// Proves that a corner where four cells meet is passed in every direction. A column in the middle of a room makes the
// cells; the corner is where their portals end, found as a vertex of four cells that no wall touches.
static int cells_at(const CellGraph *g, Vec2 p) {
    int count = 0;
    for (int c = 0; c < g->cell_count; c++) {
        for (int i = 0; i < g->cells[c].edge_count; i++)
            count += vec2_equal(g->plan[g->cells[c].first_edge + i], p);
    }
    return count;
}

// Four low kerbs of a raised floor meet: their rooms' outlines share the corner.
Test(body, in_a_corner_where_four_cells_meet) {
    Walker w;
    open_plan(&w, HEAD "storey s floor 0 height 2.6\nroom a 0,0 4,0 4,4 0,4\nroom b 4,0 8,0 8,4 4,4\n"
                       "room c 0,4 4,4 4,8 0,8\nroom d 4,4 8,4 8,8 4,8\n"
                       "wall 0,0 8,0 8,8 0,8 0,0 thickness 0.2\n");
    cr_assert_geq(cells_at(&w.graph, vec2(4, 4)), 4, "the corner is not shared");
    for (int i = 0; i < 64; i++) {
        double x = cos(2 * M_PI * i / 64), y = sin(2 * M_PI * i / 64);
        stand(&w, 4, 4, 0);
        go(&w, x, y, "away from the corner");
        go(&w, -x, -y, "on to it");
        go(&w, -x, -y, "over it");
        go(&w, 2 * x, 2 * y, "over it at once");
    }
    arena_free(&w.arena);
}

// Proves that a way exactly through the end of a portal, the jamb, is stopped a radius before it; and that a way that
// only just clears the jamb passes.
Test(body, through_the_end_of_a_portal) {
    Walker w;
    open_plan(&w, ROOMS "passage p 4.1,2 angle 90 width 1.2 height 2.1\n");
    stand(&w, 3, 1.4, 0);
    expect_stop(&w, 0.9, 0, 0.8 - 1e-4, "straight at the jamb");
    stand(&w, 3, 1.4 + BODY_RADIUS + 2e-4, 0);
    go(&w, 2, 0, "just past the jamb");
    stand(&w, 3, 0.4, 0);
    body_step(&w.body, &w.world, vec2(1.0, 1.0), 0);
    expect_free(&w, "aslant at the jamb");
    arena_free(&w.arena);
}

// Proves that one step through five cells ends in the right one, and that the same step is stopped by a closed door.
Test(body, a_step_through_several_cells) {
    Walker w;
    open_plan(&w, ROOMS "door d 4.1,2 angle 90 width 1.2 height 2.1\n");
    doors_set(&w.doors, 0, 1);
    stand(&w, 1, 2, 0);
    go(&w, 4.5, 0, "through the open door");
    go(&w, -4.5, 0, "and back");
    doors_set(&w.doors, 0, 0);
    Vec3 start = w.body.foot;
    body_step(&w.body, &w.world, vec2(4.5, 0), 0);
    expect_free(&w, "at the closed door");
    cr_assert(w.body.foot.x > start.x + 2 && w.body.foot.x < 4.1 - BODY_RADIUS, "it stands at %g",
              w.body.foot.x);
    arena_free(&w.arena);
}

// Proves that no step of 5 m, nor one of 5 s, leads through a wall: from everywhere in a room without doors.
Test(body, long_steps_do_not_tunnel) {
    Walker w;
    Random r = {31};
    open_plan(&w, ROOMS);
    for (int i = 0; i < support_count(3000, 100000); i++) {
        stand(&w, random_between(&r, 0.3, 3.7), random_between(&r, 0.3, 3.7), 0);
        double angle = random_between(&r, 0, 2 * M_PI);
        body_step(&w.body, &w.world, vec2(5 * cos(angle), 5 * sin(angle)), 5);
        expect_free(&w, "after 5 m");
        cr_assert(w.body.foot.x < 4 && w.body.foot.z == 0, "it got to %g at %g", w.body.foot.x,
                  w.body.foot.z);
    }
    arena_free(&w.arena);
}

// Proves that it climbs the stairs of the house to the upper floor and comes down again, without leaving the treads:
// going down it is on something after every step.
Test(body, climbs_stairs_and_comes_down) {
    Walker w;
    open_file(&w, "build/maps/house.plan");
    stand(&w, 7.7, 1.1, 0);
    for (int i = 0; i < 250; i++) {
        body_step(&w.body, &w.world, vec2(0, 0.02), 1.0 / 60);
        expect_free(&w, "going up");
    }
    cr_assert_float_eq(w.body.foot.z, 2.9, 1e-9, "it came to %g m at y %g", w.body.foot.z, w.body.foot.y);
    for (int i = 0; i < 250; i++) {
        body_step(&w.body, &w.world, vec2(0, -0.02), 1.0 / 60);
        expect_free(&w, "going down");
        cr_assert(w.body.standing, "in the air at y %g, z %g", w.body.foot.y, w.body.foot.z);
    }
    cr_assert_float_eq(w.body.foot.z, 0, 1e-9, "it came to %g m", w.body.foot.z);
    // In one step too.
    body_step(&w.body, &w.world, vec2(0, 5), 0);
    cr_assert_float_eq(w.body.foot.z, 2.9, 1e-9, "in one step to %g m", w.body.foot.z);
    arena_free(&w.arena);
}

// Proves how high it steps, and that a rim does not help it higher: over a box of 0.35, not on one of 0.45, and not
// on a bed of 0.55 with a rim 4 cm wide 0.3 m high.
Test(body, steps_so_high_and_no_higher) {
    Walker w;
    open_plan(&w, ROOMS "model low\n box 0,0,0 1,4,0.35 m\nend\nmodel high\n box 0,0,0 1,4,0.45 m\nend\n"
                        "model bed\n box 0,0,0 1,4,0.3 m\n box 0.04,0,0.3 1,4,0.55 m\nend\n"
                        "place low 1.5,0\nplace high 5.8,0\nplace bed 7,0\n");
    stand(&w, 0.5, 2, 0);
    go(&w, 1.5, 0, "on to the low box");
    cr_assert_float_eq(w.body.foot.z, 0.35, 1e-9);
    go(&w, 1.5, 0, "down again");
    cr_assert_eq(w.body.foot.z, 0);
    stand(&w, 4.9, 2, 0);
    expect_stop(&w, 1.5, 0, 0.7 - 1e-4, "the high box");
    arena_free(&w.arena);
    open_plan(&w, ROOMS "model bed\n box 0,0,0 1,4,0.3 m\n box 0.04,0,0.3 1,4,0.55 m\nend\nplace bed 2,0\n");
    stand(&w, 1, 2, 0);
    body_step(&w.body, &w.world, vec2(2, 0), 0);
    cr_assert(w.body.foot.x < 2 && w.body.foot.z < 0.31, "it is on the bed, at %g m", w.body.foot.z);
    arena_free(&w.arena);
}

// Proves that it ducks under what leaves 1.2 m, stands up behind it, and is stopped by what hangs lower.
Test(body, ducks) {
    Walker w;
    open_plan(&w,
              ROOMS "model beam\n box 0,0,0 0.3,4,0.3 m\nend\nplace beam 1.5,0,1.25\nplace beam 6,0,1.15\n");
    stand(&w, 1, 2, 0);
    go(&w, 0.6, 0, "under the beam");
    cr_assert_float_eq(w.body.height, 1.25, 1e-9);
    cr_assert_float_eq(body_eye(&w.body), 1.25 - BODY_CROWN, 1e-9);
    go(&w, 1, 0, "behind it");
    cr_assert_float_eq(w.body.height, BODY_HEIGHT, 1e-9);
    cr_assert_float_eq(body_eye(&w.body), BODY_EYE, 1e-9);
    stand(&w, 5, 2, 0);
    expect_stop(&w, 2, 0, 1 - BODY_RADIUS - 1e-4, "the lower beam");
    arena_free(&w.arena);
}

// Proves that what it is put into does not hold it: it stands free, in the same room.
Test(body, inside_furniture) {
    Walker w;
    Random r = {41};
    open_plan(&w, ROOMS "model block\n box -0.8,-0.8,0 0.8,0.8,1 m\nend\nplace block 3,2\n");
    for (int i = 0; i < 200; i++) {
        Vec3 at =
            vec3(3 + random_between(&r, -1, 1), 2 + random_between(&r, -1, 1), random_between(&r, -0.2, 1.2));
        cr_assert(body_place_near(&w.body, &w.world, at));
        expect_free(&w, "put in a block");
        cr_assert(w.body.foot.x < 4 && w.body.foot.z < 1.01, "it got to %g, %g", w.body.foot.x,
                  w.body.foot.z);
    }
    w.body.foot = vec3(3, 2, 0);
    body_step(&w.body, &w.world, vec2(0.01, 0), 0);
    cr_assert_eq(w.world.relocations, 1);
    w.world.relocations = 0;
    expect_free(&w, "reloaded in a block");
    arena_free(&w.arena);
}

// Proves that it falls off an edge, faster and faster, and lands; also when the machine stalls for 5 s in the air.
Test(body, falls) {
    static const double TICKS[2] = {1.0 / 60, 5};
    Walker w;
    open_plan(&w, ROOMS "model block\n box 0,0,0 1,4,1.2 m\nend\nplace block 1,0\n");
    for (int k = 0; k < 2; k++) {
        stand(&w, 1.5, 2, 1.3);
        cr_assert_float_eq(w.body.foot.z, 1.2, 1e-9);
        body_step(&w.body, &w.world, vec2(0.9, 0), TICKS[0]);
        cr_assert(!w.body.standing && w.body.foot.z > 1.19 && w.body.foot.z < 1.2);
        int ticks = 0;
        for (; !w.body.standing && ticks < 100; ticks++) {
            body_step(&w.body, &w.world, vec2(0, 0), TICKS[k]);
            expect_free(&w, "falling");
        }
        cr_assert(w.body.foot.z == 0 && w.body.fall == 0);
        // A fall of 1.2 m takes sqrt(2 * 1.2 / 9.81) = 0.495 s, less the tick that began it.
        if (k == 0) cr_assert(ticks >= 28 && ticks <= 30, "it fell for %d ticks", ticks);
    }
    arena_free(&w.arena);
}

// Proves that a long fall follows g t^2 / 2 until 50 m/s are reached, and goes on at that speed: by small ticks, and by such as a
// stalled machine has.
Test(body, falls_no_faster_than_in_air) {
    static const double TICKS[2] = {1.0 / 60, 5};
    Walker w;
    open_plan(&w,
              "plan 1\nmaterial m #808080\nstorey s floor 0 height 900\nroom a 0,0 4,0 4,4 0,4 wall 0.2\n");
    for (int k = 0; k < 2; k++) {
        stand(&w, 2, 2, 0);
        w.body.foot.z = 880;
        w.body.standing = false;
        double t = 0, reached = 50 / 9.81;
        for (int i = 0; t < 14.9; i++) {
            double before = w.body.foot.z;
            body_step(&w.body, &w.world, vec2(0, 0), TICKS[k]);
            t += TICKS[k];
            double fallen = t < reached ? 9.81 * t * t / 2 : 25 * reached + 50 * (t - reached);
            cr_assert_leq(before - w.body.foot.z, 50 * TICKS[k] + 1e-9, "tick %d of %g s", i, TICKS[k]);
            // The tick in which the speed is reached: half of the speed that it would gain.
            cr_assert_float_eq(880 - w.body.foot.z, fallen, 9.81 * TICKS[k] * TICKS[k], "after %g s", t);
        }
    }
    arena_free(&w.arena);
}

// A box that is part of an opening, and of one of its leaves if that is not below 0.
typedef struct Part {
    ObjectKind kind;
    int opening, leaf;
    double x0, y0, z0, x1, y1, z1;
} Part;

static void add_part(Walker *w, const Part *p) {
    Building *b = &w->building;
    int object = building_add_object(&w->arena, b, p->kind, "part");
    b->objects[object].opening = p->opening;
    b->objects[object].leaf = p->leaf;
    const Vec2 c[4] = {{p->x0, p->y0}, {p->x1, p->y0}, {p->x1, p->y1}, {p->x0, p->y1}};
    Vec3 top[4], foot[4];
    for (int i = 0; i < 4; i++) {
        Vec2 a = c[i], e = c[(i + 1) % 4];
        Vec3 side[4] = {vec3(a.x, a.y, p->z0), vec3(e.x, e.y, p->z0), vec3(e.x, e.y, p->z1),
                        vec3(a.x, a.y, p->z1)};
        building_add_polygon(&w->arena, b, side, 4, 0);
        top[i] = vec3(a.x, a.y, p->z1);
        foot[3 - i] = vec3(a.x, a.y, p->z0);
    }
    building_add_polygon(&w->arena, b, top, 4, 0);
    building_add_polygon(&w->arena, b, foot, 4, 0);
}

// Proves what frames stop: posts are felt like all that is drawn; a frame which alone bars its door, as a threshold board at the height
// of a chest does, is not, while it is of furniture, of a passage, or where the door would let nobody pass without it. What moves with
// a leaf or is of another door bars nothing.
Test(door_frames, are_felt_or_not) {
    enum { DOOR, NARROW, PASSAGE };
    static const struct {
        Part part;
        int door;
        bool with, without;  // does it let pass?
        bool passes;         // does a body?
    } CASES[] = {
        // Nothing; posts at either jamb; a board across; the same over the head, and to step over.
        {{OBJECT_FRAME, DOOR, -1, 3, 0.5, 0, 3.1, 0.6, 1}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 3.9, 1.4, 0, 4.3, 1.55, 2}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 3.9, 2.5, 0, 4.3, 2.6, 2}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, false, true, true},
        {{OBJECT_FRAME, DOOR, -1, 4.05, 1.3, 1.9, 4.15, 2.7, 2}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 4.05, 1.3, 0, 4.15, 2.7, 0.1}, DOOR, true, true, true},
        // The board as furniture, of nothing, of another door, of a leaf.
        {{OBJECT_FURNITURE, DOOR, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, false},
        {{OBJECT_FRAME, -1, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, false},
        {{OBJECT_FRAME, NARROW, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, false},
        {{OBJECT_FRAME, DOOR, 0, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, true},
        // The frame of a door that is too narrow without it; of a passage.
        {{OBJECT_FRAME, NARROW, -1, 4.05, 3.2, 0.7, 4.15, 3.7, 0.9}, NARROW, false, false, false},
        {{OBJECT_FRAME, PASSAGE, -1, 4.05, 0.2, 0.7, 4.15, 1.1, 0.9}, PASSAGE, false, true, false},
    };
    static const double MIDDLE[] = {2, 3.45, 0.65};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        const Part *p = &CASES[i].part;
        Walker w = {.arena = {0}};
        Error error;
        char *path = arena_format(&w.arena, "%s/test.plan", support_folder(&w.arena));
        static const char PLAN[] =
            ROOMS "door d 4.1,2 angle 90 width 1.2 height 2.1 hinge left swing 88\n"
                  "door n 4.1,3.45 angle 90 width 0.35 height 2.1 hinge left swing 88\n"
                  "passage p 4.1,0.65 angle 90 width 0.9 height 2.1\n";
        cr_assert(file_write(path, PLAN, sizeof PLAN - 1, &error), "%s", error.text);
        cr_assert(maps_read(path, &w.arena, &w.building, &error), "%s", error.text);
        add_part(&w, p);
        open_cells(&w);
        for (int o = 0; o < w.building.opening_count; o++) doors_set(&w.doors, o, 1);
        cr_expect_eq(door_lets_pass(&w.graph, CASES[i].door, true), CASES[i].with, "case %zu, with its frame",
                     i);
        cr_expect_eq(door_lets_pass(&w.graph, CASES[i].door, false), CASES[i].without, "case %zu, without",
                     i);
        for (int y = -3; y <= 3; y++) {
            stand(&w, 2, MIDDLE[CASES[i].door], 0);
            body_step(&w.body, &w.world, vec2(1.2, 0.1 * y), 0.1);
            for (int k = 0; k < 300; k++) {
                body_step(&w.body, &w.world, vec2(0.01, 0), 0.01);
                double dx = fmax(fmax(p->x0 - w.body.foot.x, w.body.foot.x - p->x1), 0),
                       dy = fmax(fmax(p->y0 - w.body.foot.y, w.body.foot.y - p->y1), 0);
                bool felt = p->leaf < 0 &&
                            (CASES[i].with || !CASES[i].without || p->kind != OBJECT_FRAME ||
                             p->opening == PASSAGE) &&
                            p->z1 > w.body.foot.z + 1e-9 && p->z0 < w.body.foot.z + w.body.height - 1e-9;
                cr_assert(!felt || hypot(dx, dy) > BODY_RADIUS - BODY_TOLERANCE,
                          "case %zu: a body at %g, %g, %g is in it", i, w.body.foot.x, w.body.foot.y,
                          w.body.foot.z);
            }
            if (y == 0)
                cr_expect_eq(w.body.foot.x > 4.5, CASES[i].passes, "case %zu: it comes to %g", i,
                             w.body.foot.x);
        }
        arena_free(&w.arena);
    }
}

// Proves that a body which has no place yet is put near where it is wanted before it goes on, and stays without where there is none.
Test(body, without_a_place) {
    Walker w;
    open_plan(&w, ROOMS "passage p 4.1,2 angle 90 width 1.2 height 2.1\n");
    w.body.foot = vec3(3, 1, 0);
    body_step(&w.body, &w.world, vec2(0.5, 0), 0.05);
    cr_expect_eq(w.world.relocations, 1);
    cr_assert_geq(w.body.cell, 0);
    cr_expect(fabs(w.body.foot.x - 3.5) < 1e-3 && w.body.foot.y == 1, "it comes to %g, %g", w.body.foot.x,
              w.body.foot.y);
    w.body = (Body){.foot = {500, 1, 0}, .cell = -1};
    body_step(&w.body, &w.world, vec2(0.5, 0), 0.05);
    cr_expect(w.body.cell == -1 && w.body.foot.x == 500);
    arena_free(&w.arena);
}

// Proves that a window is no way out, though nothing is drawn in it.
Test(body, does_not_climb_out_of_windows) {
    Walker w;
    open_plan(&w, ROOMS "ground m\nwindow w 2,-0.1 width 2 sill 0.3 height 2\n");
    stand(&w, 2, 1, 0);
    expect_stop(&w, 0, -2, 1 - BODY_RADIUS - 1e-4, "the window");
    arena_free(&w.arena);
}
