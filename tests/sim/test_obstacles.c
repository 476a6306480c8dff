// test_obstacles.c - the solids about a body are all there are.
#include <criterion/criterion.h>

#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/sim/body_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

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
        body_check_open_cells(&w);
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
