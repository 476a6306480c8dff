// test_sums_cells.c - sums of cells, pairs, trees, queries and walks.
#include <criterion/criterion.h>
#include <math.h>
#include <string.h>

#include "engine/draw/view.h"
#include "engine/sim/doors.h"
#include "tests/maps/sums_fixture.h"
#include "tests/support/draft_fixture.h"
#include "tests/support/files/hostile.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/sums.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

// ---- cells, pairs and trees

typedef struct Seen {
    Building building;
    CellGraph graph;
    PairSet pairs;
    StabForest forest;
} Seen;

static void sum_cells(SumFile *f, const CellGraph *g) {
    Sum cells = {0}, portals = {0}, squares = {0};
    for (int i = 0; i < g->cell_count; i++) {
        const Cell *c = &g->cells[i];
        int words[] = {c->region,     c->first_edge, c->edge_count, c->first_face,
                       c->face_count, c->first_way,  c->way_count,  c->outdoors};
        sum_ints(&cells, words, sizeof words / sizeof *words);
        sum_add2(&cells, vec2(c->z0, c->z1));
        sum_box(&cells, c->box);
    }
    for (int i = 0; i < g->plan_count; i++) sum_add2(&cells, g->plan[i]);
    for (int i = 0; i < g->face_count; i++) {
        sum_add3(&cells, g->faces[i].n);
        sum_add(&cells, g->faces[i].d);
    }
    for (int i = 0; i < g->portal_count; i++) {
        const Portal *p = &g->portals[i];
        int words[] = {p->cell[0], p->cell[1], p->first_vertex, p->vertex_count, p->horizontal, p->door};
        sum_ints(&portals, words, sizeof words / sizeof *words);
        sum_add3(&portals, p->plane.n);
        sum_add(&portals, p->plane.d);
        sum_add2(&portals, p->left);
        sum_add2(&portals, p->right);
    }
    for (int i = 0; i < g->portal_vertex_count; i++) sum_add3(&portals, g->portal_vertices[i]);
    for (int i = 0; i < g->way_count; i++) sum_ints(&portals, &g->ways[i].portal, 2);
    for (int i = 0; i < g->cell_count; i++) {
        sum_add2(&squares, g->grids[i].origin);
        sum_add(&squares, g->grids[i].size);
        sum_ints(&squares, &g->grids[i].nx, 3);
    }
    sum_ints(&squares, g->square_first, g->square_count + 1);
    sum_ints(&squares, g->square_objects, g->square_object_count);
    int located = g->locator.nx * g->locator.ny;
    sum_ints(&squares, g->locator_first, located + 1);
    sum_ints(&squares, g->locator_cells, g->locator_first[located]);
    sum_add(&squares, g->dropped_slivers);
    sums_sum(f, "cells", cells);
    sums_sum(f, "portals", portals);
    sums_sum(f, "squares", squares);
    sums_of_sum_polygons(f, g->objects, g->object_count, g->polygons, g->polygon_count, g->vertices,
                         g->vertex_count);
}

static void sum_trees(SumFile *f, const Seen *s) {
    Sum pairs = {0}, trees = {0}, rows = {0};
    for (int i = 0; i < s->graph.cell_count; i++) {
        for (int k = 0; k < s->graph.cell_count; k++) {
            sum_add(&pairs, pair_bit(s->pairs.seen, s->pairs.words, i, k));
            sum_add(&pairs, pair_bit(s->pairs.proven, s->pairs.words, i, k));
            sum_add(&rows, vis_sees(&s->forest, i, k));
        }
        sum_add(&trees, s->forest.bounded[i]);
    }
    sum_ints(&trees, s->forest.root, s->forest.cell_count + 1);
    for (int i = 0; i < s->forest.node_count; i++) sum_ints(&trees, &s->forest.nodes[i].cell, 4);
    // The cost of searching tells of prunings that became weaker, though nothing is decided otherwise.
    Sum work = {0};
    sum_add(&work, (double)s->pairs.work.chains);
    sum_add(&work, (double)s->pairs.work.clips);
    sum_add(&work, (double)s->pairs.work.separators);
    sum_add(&work, (double)s->pairs.work.given_up);
    sums_sum(f, "pairs", pairs);
    sums_sum(f, "work", work);
    sums_sum(f, "trees", trees);
    sums_sum(f, "rows", rows);
}

static void see(const Building *b, Arena *arena, Seen *out) {
    Error error = {""};
    VisOptions options = vis_default_options();
    options.threads = 1;
    cr_assert(vis_build_cells(b, &options, arena, &out->graph, &error), "%s", error.text);
    pair_method_finest()->find(&out->graph, &(PairOptions){.threads = 1}, NULL, arena, &out->pairs);
    CellRows known = cell_rows_of_matrix(out->pairs.seen, out->pairs.cell_count, arena);
    options.known = &known;
    cr_assert(vis_build_forest(&out->graph, &options, NULL, arena, &out->forest));
}

// ---- queries

static Vec3 point_in(const CellGraph *g, Random *random, int cell) {
    return g->cells[cell].face_count ? soup_fixture_point(g, random, cell) : fixture_point(g, random, cell);
}

// Some views of a building by all methods that cull: all doors open, all closed, each as chance will have it.
static void sum_views(SumFile *f, const Seen *s, int views, Arena *arena) {
    const CellGraph *g = &s->graph;
    Random random = {17};
    VisQuery *query = vis_query_new(g, &s->forest, arena);
    float *open = ARENA_ARRAY(arena, float, s->building.opening_count + 1);
    Sum seen[QUERY_CULLINGS] = {{0}}, tested[QUERY_CULLINGS] = {{0}};
    for (int i = 0; i < views; i++) {
        int cell = random_index(&random, g->cell_count);
        Vec3 at = point_in(g, &random, cell);
        Camera camera = camera_look(at, random_between(&random, 0, 2 * M_PI), random_between(&random, -1, 1),
                                    random_between(&random, 0.5, 2), 320, 180);
        Eye eye = i % 4 ? walk_eye(&camera) : (Eye){.position = at};
        for (int k = 0; k < s->building.opening_count; k++)
            open[k] = i % 3 == 1 ? 0 : (float)fmax(0, random_between(&random, -1, 1));
        for (int m = CULL_FRUSTUM; m < QUERY_CULLINGS; m++) {
            VisResult r = vis_query(query, &eye, cell, i % 3 ? open : NULL, (Culling)m);
            for (int k = 0; k < r.cell_count; k++) {
                sum_add(&seen[m], r.cells[k].cell);
                sum_add(&seen[m], r.cells[k].distance);
            }
            sum_ints(&seen[m], r.objects, r.object_count);
            sum_add(&seen[m], r.polygon_count);
            sum_add(&seen[m], r.eye_cell);
            sum_add(&tested[m], r.portals_tested);
            sum_add(&tested[m], r.objects_tested);
        }
    }
    for (int m = CULL_FRUSTUM; m < QUERY_CULLINGS; m++) {
        sums_sum(f, CULLING_NAMES[m], seen[m]);
        sums_sum(f, "tested", tested[m]);
    }
}

static void sum_sight(SumFile *f, const char *name, Building *b, int views, Arena *arena) {
    Seen s = {.building = *b};
    see(&s.building, arena, &s);
    sums_scene(f, name);
    sum_cells(f, &s.graph);
    sum_trees(f, &s);
    if (s.graph.cell_count > 0) sum_views(f, &s, views, arena);
}

// Proves that cells, portals, visible pairs, stab trees, and what is seen by each method are what they were: in our own homes and
// plans, in rooms at random with doors and storeys, in soups aligned and turned, in given cells.
Test(sums, sight, .timeout = 120) {
    SumFile f = sums_begin("sight");
    Random random = {3};
    for (int i = 0; i < FILE_COUNT - 1; i++) {
        Arena arena = {0};
        Building b;
        sums_of_read_building(FILES[i], &arena, &b);
        sum_sight(&f, strrchr(FILES[i], '/') + 1, &b, 60, &arena);
        arena_free(&arena);
    }
    for (int i = 0; i < 12; i++) {
        Arena arena = {0};
        Building *b = i < 6 ? fixture_rooms(&arena, &random, 2 + i % 3, 3, 1 + i % 2)
                            : soup_fixture_house(&arena, &random, 2 + i % 2, 2);
        SoupPose pose = {random_between(&random, 0.5, 20), random_between(&random, 0, 6),
                         fixture_direction(&random), vec3(100, -30, 7)};
        if (i == 10) pose.shift = vec3(-70, 200, -9);
        if (i > 8) b = soup_fixture_posed(&arena, b, &pose);
        sum_sight(&f,
                  arena_format(&f.arena, "%s-%d",
                               i < 6   ? "rooms"
                               : i > 8 ? "soup-turned"
                                       : "soup",
                               i),
                  b, 40, &arena);
        arena_free(&arena);
    }
    for (int seed = 1; seed <= 24; seed++) {
        Draft d;
        if (sums_of_random_plan(seed, &d) && d.b.region_count < 30)
            sum_sight(&f, arena_format(&f.arena, "plan-%d", seed), &d.b, 20, &d.arena);
        draft_free(&d);
    }
    for (int i = 0; i < 6; i++) {
        Arena arena = {0};
        Row row = row_random(&random, 4 + i);
        Building b = *row_graph(&arena, &row)->building;
        sum_sight(&f, arena_format(&f.arena, "row-%d", i), &b, 0, &arena);
        arena_free(&arena);
    }
    sums_end(&f);
}

// The same of a small file of each hostile kind: what is too crowded, too long or too thin for others.
Test(sums, hostile_sight, .timeout = 120) {
    SumFile f = sums_begin("hostile-sight");
    const char *folder = support_folder(&f.arena);
    for (int i = 0; HOSTILE_KINDS[i].name; i++) {
        Arena arena = {0};
        Building b;
        if (sums_of_read_hostile(&HOSTILE_KINDS[i], folder, &arena, &b))
            sum_sight(&f, HOSTILE_KINDS[i].name, &b, 6, &arena);
        arena_free(&arena);
    }
    sums_end(&f);
}

// ---- bodies and doors

// Somebody who walks about at random, turns off where nothing gives way, and opens and closes the doors on the way.
static void sum_walk(SumFile *f, const char *path) {
    enum { STEPS = 6000 };
    Arena arena = {0};
    Building b;
    CellGraph g;
    Error error = {""};
    VisOptions options = vis_default_options();
    sums_of_read_building(path, &arena, &b);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    Doors doors = doors_new(&g, &arena);
    BodyWorld world = body_world(&g, doors.open, &arena);
    Body body = {.cell = -1};
    Random random = {23};
    Sum ways = {0}, moved = {0}, work = {0};
    double yaw = b.start_yaw;
    bool placed = body_place_near(&body, &world, b.start);
    for (int i = 0; i < STEPS && placed; i++) {
        if (i % 600 == 599) {  // somewhere else
            int cell = random_index(&random, g.cell_count);
            sum_add(&ways, body_place_near(&body, &world, point_in(&g, &random, cell)));
        }
        Vec3 before = body.foot;
        body_step(&body, &world, vec2(0.04 * cos(yaw), 0.04 * sin(yaw)), 1.0 / 40);
        if (hypot(body.foot.x - before.x, body.foot.y - before.y) < 0.02)
            yaw += random_between(&random, 0.5, 2.5);
        if (i % 10 == 0) {
            Vec3 eye = vec3(body.foot.x, body.foot.y, body.foot.z + body_eye(&body));
            int door = doors_looked_at(&doors, eye, body.cell, vec3(cos(yaw), sin(yaw), 0), DOORS_REACH);
            if (door >= 0 && random_index(&random, 3) == 0) sum_add(&moved, doors_toggle(&doors, door));
            sum_add(&moved, door);
        }
        doors_advance(&doors, 1.0 / 40, &body);
        sum_add3(&ways, body.foot);
        sum_add3(&ways, vec3(body.height, body.head, body.cell));
        for (int k = 0; k < b.opening_count && i % 20 == 0; k++) {
            sum_add(&moved, (double)doors.open[k]);
            sum_add(&moved, doors.halt[k]);
        }
    }
    sum_add3(&work, vec3((double)world.wall_tests, (double)world.object_tests, (double)world.pieces));
    sum_add2(&work, vec2((double)world.relocations, (double)world.refused));
    sums_scene(f, strrchr(path, '/') + 1);
    sums_sum(f, "ways", ways);
    sums_sum(f, "doors", moved);
    sums_sum(f, "work", work);
    arena_free(&arena);
}

// Proves that bodies go, climb, duck and slide as they did, and doors move, halt and go on.
Test(sums, walks, .timeout = 60) {
    SumFile f = sums_begin("walks");
    for (int i = 0; i < FILE_COUNT; i++) sum_walk(&f, FILES[i]);
    sums_end(&f);
}
