// test_leaves.c - doors: what a closed one hides, where the leaf of a moving one may be seen, how leaves move.
#include <criterion/criterion.h>

#include "engine/walk/verify.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "visibility/cells/build.h"

static const char *const SAMPLES[] = {"build/maps/two-rooms.plan", "build/maps/house.plan",
                                      "build/maps/house.sh3d", "build/maps/office.plan"};
enum { SAMPLE_COUNT = sizeof SAMPLES / sizeof *SAMPLES };

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
} Made;

static void make(Made *m, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    *m = (Made){.arena = {0}};
    cr_assert(maps_read(path, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest));
}

// ---- what a closed door hides

// The cells that light can reach from a cell without passing a closed door, by a flood that knows no directions. Of a doorway
// whose door is closed the half beyond is part of it: its jambs end at the leaf.
static void flood(const CellGraph *g, int cell, const float *doors, unsigned char *reached) {
    memset(reached, 0, (size_t)g->cell_count);
    reached[cell] = 1;
    for (bool more = true; more;) {
        more = false;
        for (int i = 0; i < g->portal_count; i++) {
            const Portal *p = &g->portals[i];
            bool closed = p->door >= 0 && doors[p->door] == 0;
            if (closed || (reached[p->cell[0]] == 1) == (reached[p->cell[1]] == 1)) continue;
            reached[p->cell[0]] = reached[p->cell[1]] = 1;
            more = true;
        }
    }
    for (int i = 0; i < g->portal_count; i++) {
        const Portal *p = &g->portals[i];
        if (p->door < 0 || (reached[p->cell[0]] == 1) == (reached[p->cell[1]] == 1)) continue;
        int beyond = g->cells[p->cell[reached[p->cell[0]] == 1]].region;
        for (int c = 0; c < g->cell_count; c++) {
            if (g->cells[c].region == beyond && !reached[c]) reached[c] = 2;
        }
    }
}

static void mark_objects(const CellGraph *g, const unsigned char *reached, unsigned char *allowed) {
    memset(allowed, 0, (size_t)g->object_count);
    for (int c = 0; c < g->cell_count; c++) {
        const SquareGrid *grid = &g->grids[c];
        int begin = g->square_first[grid->first_square];
        int end = g->square_first[grid->first_square + grid->nx * grid->ny];
        for (int k = begin; reached[c] && k < end; k++) allowed[g->square_objects[k]] = 1;
    }
}

static bool beside_a_portal(const CellGraph *g, Vec3 eye) {
    for (int i = 0; i < g->portal_count; i++) {
        const Portal *p = &g->portals[i];
        if (p->door >= 0 && fabs(plane_distance(p->plane, eye)) < 0.01) return true;
    }
    return false;
}

// Proves that nothing behind a closed door is drawn: every object of a draw list touches a cell that light reaches
// from the eye's without passing a closed door. Eyes in a leaf see both sides and are left out.
Test(leaves, nothing_behind_a_closed_door_is_drawn) {
    long hidden = 0;  // cells; in a house with windows all around, light comes in another way
    for (int s = 0; s < SAMPLE_COUNT; s++) {
        Made m;
        make(&m, SAMPLES[s]);
        const CellGraph *g = &m.graph;
        VisQuery *query = vis_query_new(g, &m.forest, &m.arena);
        float *doors = ARENA_ARRAY(&m.arena, float, m.building.opening_count + 1);
        unsigned char *reached = ARENA_ARRAY(&m.arena, unsigned char, g->cell_count),
                      *allowed = ARENA_ARRAY(&m.arena, unsigned char, g->object_count);
        uint64_t seed = 11;
        Random random = {seed};
        for (int i = 0; i < support_count(400, 20000); i++) {
            RandomView view = {.door_open = doors};
            if (!walk_random_view(g, &random, 64, 36, &view)) continue;
            if (beside_a_portal(g, view.camera.eye)) continue;
            Eye eye = {.position = view.camera.eye};
            VisResult result = vis_query(query, &eye, view.cell, doors, i % 2 ? CULL_STAB : CULL_PORTALS);
            if (result.eye_cell < 0) continue;
            flood(g, result.eye_cell, doors, reached);
            mark_objects(g, reached, allowed);
            for (int k = 0; k < result.object_count; k++) {
                cr_assert(allowed[result.objects[k]],
                          "%s, seed %llu, view %d: object %d (%s) is drawn, but behind a closed door",
                          SAMPLES[s], (unsigned long long)seed, i, result.objects[k],
                          g->objects[result.objects[k]].name);
            }
            for (int c = 0; c < g->cell_count; c++) hidden += !reached[c];
        }
        arena_free(&m.arena);
    }
    cr_expect_gt(hidden, 10000, "doors hide too little for this to prove anything: %ld cells", hidden);
}

// ---- where a leaf may be

static bool registered(const CellGraph *g, int cell, int object, Vec3 at) {
    const SquareGrid *grid = &g->grids[cell];
    int i = (int)fmin(fmax((at.x - grid->origin.x) / grid->size, 0), grid->nx - 1);
    int j = (int)fmin(fmax((at.y - grid->origin.y) / grid->size, 0), grid->ny - 1);
    int square = grid->first_square + j * grid->nx + i;
    for (int k = g->square_first[square]; k < g->square_first[square + 1]; k++) {
        if (g->square_objects[k] == object) return true;
    }
    return false;
}

static Vec3 point_of(const CellGraph *g, const Polygon *p, Random *random) {
    const Vec3 *v = g->vertices + p->first_vertex;
    int i = 1 + random_index(random, p->vertex_count - 2);
    double a = random_unit(random), b = random_unit(random);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    return vec3_add(v[0],
                    vec3_add(vec3_scale(vec3_sub(v[i], v[0]), a), vec3_scale(vec3_sub(v[i + 1], v[0]), b)));
}

// Proves that a leaf is found wherever it swings: any point of it, at any share of its way, lies in its box and in
// squares where it is registered.
Test(leaves, are_registered_wherever_they_swing) {
    for (int s = 0; s < SAMPLE_COUNT; s++) {
        Made m;
        make(&m, SAMPLES[s]);
        const CellGraph *g = &m.graph;
        Random random = {3};
        int tried = 0;
        for (int o = 0; o < m.building.object_count; o++) {
            const Object *object = &g->objects[o];
            if (object->leaf < 0) continue;
            const Leaf *leaf = &m.building.leaves[object->leaf];
            for (int i = 0; i < support_count(50, 2000); i++) {
                const Polygon *p =
                    &g->polygons[object->first_polygon + random_index(&random, object->polygon_count)];
                double share = random_unit(&random);
                Vec3 at = leaf_point(leaf, share, point_of(g, p, &random));
                // In float, as door states are kept: some 1e-6 m at 10 m from the hinge.
                cr_assert(box_contains(box_grow(g->object_boxes[o], 1e-5), at), "%s: leaf %d outside its box",
                          SAMPLES[s], object->leaf);
                int cell = vis_locate(g, at, -1);
                if (cell < 0) continue;
                cr_assert(registered(g, cell, o, at), "%s: leaf %d (%s) at share %g, (%g, %g, %g), cell %d",
                          SAMPLES[s], object->leaf, object->name, share, at.x, at.y, at.z, cell);
                tried++;
            }
        }
        cr_expect_gt(tried, 0, "%s has no leaf in free space", SAMPLES[s]);
        arena_free(&m.arena);
    }
}

// Proves how leaves move: a hinged one keeps its distance from its axis and turns by its angle, a sliding one shifts,
// and a closed one is where it was read to the last bit.
Test(leaves, turn_and_slide) {
    Leaf turns = {.pivot = {1, 2}, .turn = M_PI / 2, .axis = {{1, 2}, {2, 2}}, .thickness = 0.04, .z1 = 2};
    Vec3 tip = leaf_point(&turns, 1, vec3(2, 2, 0.5));
    cr_expect(fabs(tip.x - 1) < 1e-12 && fabs(tip.y - 3) < 1e-12 && tip.z == 0.5);
    tip = leaf_point(&turns, 0.5, vec3(2, 2, 0.5));
    cr_expect_float_eq(hypot(tip.x - 1, tip.y - 2), 1, 1e-12);
    Leaf slides = {.pivot = {1, 2}, .slide = {0.5, -1}, .axis = {{1, 2}, {2, 2}}, .thickness = 0.04, .z1 = 2};
    tip = leaf_point(&slides, 0.5, vec3(2, 2, 0.5));
    cr_expect(fabs(tip.x - 2.25) < 1e-12 && fabs(tip.y - 1.5) < 1e-12);
    Vec3 odd = vec3(0.1, 0.7, 0.3);
    cr_expect(vec3_equal(leaf_point(&turns, 0, odd), odd) && vec3_equal(leaf_point(&slides, 0, odd), odd));
    Vec2 corner[4];
    leaf_box(&turns, 0, corner);
    double area = 0;
    for (int i = 0; i < 4; i++) area += vec2_cross(corner[i], corner[(i + 1) % 4]) / 2;
    cr_expect_float_eq(area, 0.04, 1e-12, "counter-clockwise, as large as the leaf");
}

// Proves that the sides of a leaf face outwards, all six: the front of a polygon is where it has light.
Test(leaves, face_outwards) {
    int boxes = 0;
    for (int k = 0; k < SAMPLE_COUNT; k++) {
        Made m;
        make(&m, SAMPLES[k]);
        const Building *b = &m.building;
        for (int i = 0; i < b->object_count; i++) {
            const Object *o = &b->objects[i];
            if (o->leaf < 0 || o->polygon_count != 6) continue;
            const Leaf *leaf = &b->leaves[o->leaf];
            Vec2 middle = vec2_scale(vec2_add(leaf->axis[0], leaf->axis[1]), 0.5);
            boxes++;
            for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
                const Polygon *polygon = &b->polygons[p];
                Plane plane = plane_of_polygon(b->vertices + polygon->first_vertex, polygon->vertex_count);
                cr_expect_lt(plane_distance(plane, vec3(middle.x, middle.y, (leaf->z0 + leaf->z1) / 2)), 0,
                             "%s, leaf of %s: side %d faces inwards", SAMPLES[k],
                             b->openings[leaf->opening].name, p - o->first_polygon);
            }
        }
        arena_free(&m.arena);
    }
    cr_expect_gt(boxes, 10);
}

// Where a point goes, by the angle and the distance it has from the pivot.
static Vec3 moved(const Leaf *leaf, double share, Vec3 p) {
    double angle = atan2(p.y - leaf->pivot.y, p.x - leaf->pivot.x) + share * leaf->turn;
    double far = hypot(p.x - leaf->pivot.x, p.y - leaf->pivot.y);
    return vec3(leaf->pivot.x + far * cos(angle) + share * leaf->slide.x,
                leaf->pivot.y + far * sin(angle) + share * leaf->slide.y, p.z + share * leaf->rise);
}

static bool in_quad(const Vec3 quad[4], Vec3 p, double slack) {
    for (int i = 0; i < 4; i++) {
        Vec3 a = quad[i], b = quad[(i + 1) % 4];
        double length = hypot(b.x - a.x, b.y - a.y);
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) < -slack * length) return false;
    }
    return true;
}

// A leaf anywhere, turned any way, that turns, slides, rises or does some of that; the corners of what is drawn of it, in `v`.
static Leaf random_leaf(Random *random, Vec3 v[8]) {
    double way = random_between(random, 0, 2 * M_PI), long_side = random_between(random, 0.3, 2);
    Vec2 pivot = {random_between(random, -300, 300), random_between(random, -300, 300)};
    Leaf leaf = {.pivot = pivot, .thickness = 0.04, .z0 = 0, .z1 = 2};
    leaf.axis[0] = pivot;
    leaf.axis[1] = vec2(pivot.x + long_side * cos(way), pivot.y + long_side * sin(way));
    if (random_index(random, 3)) leaf.turn = random_between(random, -3, 3);
    if (random_index(random, 2))
        leaf.slide = vec2(random_between(random, -2, 2), random_between(random, -2, 2));
    if (random_index(random, 3) == 0) leaf.rise = random_between(random, -3, 3);
    // With a handle, or a jamb's play: neither in the middle of the axis nor from its end.
    double x0 = random_between(random, -0.2, 0.1), x1 = long_side + random_between(random, -0.1, 0.1),
           y0 = random_between(random, -0.3, 0.05), y1 = y0 + random_between(random, 0.02, 0.4);
    for (int i = 0; i < 8; i++) {
        double x = i & 1 ? x1 : x0, y = i & 2 ? y1 : y0;
        v[i] = vec3(pivot.x + x * cos(way) - y * sin(way), pivot.y + x * sin(way) + y * cos(way),
                    i & 4 ? 2.1 : 0.1);
    }
    return leaf;
}

// Proves that what a leaf sweeps holds any point of it at any share, and nothing more than that with the width of half a step around;
// and that a pose puts every vertex of a leaf where it is at its door's share, wide open where no shares are told, and no other vertex.
Test(leaves, sweep_all_their_way) {
    Random random = {8};
    for (int n = 0; n < support_count(2000, 50000); n++) {
        Vec3 v[12], posed[12] = {{0, 0, 0}};
        Leaf leaf = random_leaf(&random, v);
        for (int i = 8; i < 12; i++) v[i] = fixture_direction(&random);
        Polygon polygons[] = {{8, 4, 0, 0}, {0, 8, 0, 0}};
        Object objects[] = {{.leaf = -1, .polygon_count = 1},
                            {.leaf = 0, .first_polygon = 1, .polygon_count = 1}};
        Building b = {.leaves = &leaf, .leaf_count = 1, .object_count = 2, .objects = objects};
        CellGraph g = {.building = &b, .objects = objects, .polygons = polygons, .vertices = v};
        SweptLeaf swept;
        build_swept(&g, 1, &swept);
        double reach = 0;
        for (int i = 0; i < 8; i++) reach = fmax(reach, hypot(v[i].x - leaf.pivot.x, v[i].y - leaf.pivot.y));
        double half = (reach * fabs(leaf.turn) + vec2_length(leaf.slide)) / (2 * (SWEPT_STEPS - 1));
        for (int k = 0; k < 40; k++) {
            double share = k < 2 ? k : random_unit(&random);
            Vec3 p = v[random_index(&random, 8)];
            if (k % 2) p = vec3_lerp(p, v[random_index(&random, 8)], random_unit(&random));
            p = moved(&leaf, share, p);
            bool held = p.z > swept.z0 - 1e-9 && p.z < swept.z1 + 1e-9, in_plan = false;
            for (int i = 0; i < SWEPT_STEPS; i++) in_plan = in_plan || in_quad(swept.plan[i], p, 1e-9);
            cr_assert(held && in_plan, "leaf %d at %g: a point is not held", n, share);
        }
        cr_assert_float_eq(swept.z0, 0.1 + fmin(0, leaf.rise), 1e-9);
        cr_assert_float_eq(swept.z1, 2.1 + fmax(0, leaf.rise), 1e-9);
        const Vec3 closed[4] = {v[0], v[1], v[3], v[2]};
        for (int i = 0; i < SWEPT_STEPS; i++) {
            Vec3 box[4];
            for (int k = 0; k < 4; k++) box[k] = moved(&leaf, (double)i / (SWEPT_STEPS - 1), closed[k]);
            for (int k = 0; k < 4; k++)
                cr_assert(in_quad(box, swept.plan[i][k], half + 1e-9) && in_quad(swept.plan[i], box[k], 1e-9),
                          "leaf %d: what is swept at step %d is too much", n, i);
        }
        float open = (float)random_unit(&random);
        for (int told = 0; told < 2; told++) {
            vis_pose(&g, told ? &open : NULL, posed);
            for (int i = 0; i < 8; i++)
                cr_assert_lt(vec3_length(vec3_sub(posed[i], moved(&leaf, told ? (double)open : 1, v[i]))),
                             1e-9);
            for (int i = 8; i < 12; i++) cr_assert(vec3_equal(posed[i], vec3(0, 0, 0)));
        }
    }
}
