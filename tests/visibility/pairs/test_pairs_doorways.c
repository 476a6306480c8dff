// test_pairs_doorways.c - pairs that doorways of any shape, ways and tangents leave in sight.
#include <criterion/criterion.h>

#include "engine/core/text.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "tests/visibility/pairs/pairs_fixture.h"
#include "visibility/pairs/rounds.h"
#include "visibility/ways.h"

// Proves the same of round doorways of many corners, which searches replace by rectangles about them: along a line from circle to
// circle, each turned and tilted another way, every room sees every other.
Test(pairs, round_doorways_hide_nothing) {
    Random random = {19};
    for (int k = 0; k < 12; k++) {
        enum { ROOMS = 5, MOST = 64 };
        Arena arena = {0};
        Text text = {.arena = &arena};
        int corners = k % 3 == 0 ? MOST : 12 + random_index(&random, 30);
        double rise[2] = {random_between(&random, -0.3, 0.3), random_between(&random, -0.3, 0.3)};
        text_append(&text, "PRT1\n%d\n%d\n", ROOMS, ROOMS - 1);
        for (int d = 0; d + 1 < ROOMS; d++) {
            Vec3 n = vec3_normalize(
                vec3(1, random_between(&random, -0.3, 0.3), random_between(&random, -0.3, 0.3)));
            Vec3 u = vec3_normalize(vec3_cross(n, fixture_direction(&random))), v = vec3_cross(n, u);
            // The line runs near the rim, in another direction each time.
            double radius = random_between(&random, 20, 30), off = 0.9 * radius,
                   turn = random_between(&random, 0, 2 * M_PI);
            Vec3 middle = vec3(128 * d, 128 * d * rise[0], 128 * d * rise[1]);
            middle =
                vec3_add(middle, vec3_add(vec3_scale(u, off * cos(turn)), vec3_scale(v, off * sin(turn))));
            text_append(&text, "%d %d %d", corners, d, d + 1);
            for (int c = 0; c < corners; c++) {
                double angle = 2 * M_PI * c / corners;
                Vec3 p = vec3_add(
                    middle, vec3_add(vec3_scale(u, radius * cos(angle)), vec3_scale(v, radius * sin(angle))));
                text_append(&text, " (%.9g %.9g %.9g )", p.x, p.y, p.z);
            }
            text_append(&text, "\n");
        }
        CellGraph *graph = prt_scene(&arena, text.data);
        for (int m = 0; PAIR_METHODS[m]; m++) {
            PairSet set = pairs_find(graph, PAIR_METHODS[m], 1, NULL, &arena);
            for (int a = 0; a < ROOMS; a++)
                for (int b = 0; b < ROOMS; b++)
                    cr_expect(pairs_sees(&set, a, b), "%s, row %d: %d does not see %d", PAIR_METHODS[m]->name,
                              k, a, b);
        }
        arena_free(&arena);
    }
}

// Proves the same of doorways that stand a millimetre or three behind one another, their corners as far off their planes, as compilers of
// maps print them: what is in front of what is then in doubt, and nothing is hidden by that. Floods, searches and trees.
Test(pairs, bent_doorways_close_together_hide_nothing) {
    Random random = {23};
    for (int k = 0; k < 60; k++) {
        enum { ROOMS = 6 };
        Arena arena = {0};
        Text text = {.arena = &arena};
        double x = 0, turn = random_between(&random, 0, 6);
        text_append(&text, "PRT1\n%d\n%d\n", ROOMS, ROOMS - 1);
        for (int d = 0; d + 1 < ROOMS; d++) {
            // Game units, 32 a metre: 0.1 is three millimetres.
            double bend = random_between(&random, -0.1, 0.1), half = random_between(&random, 8, 40);
            text_append(&text, "4 %d %d", d, d + 1);
            for (int c = 0; c < 4; c++) {
                double off = x + (c % 2 ? bend : -bend), y = c == 1 || c == 2 ? -half : half,
                       z = c > 1 ? half : -half;
                // The file's normal points into the first room, towards -x before the turn.
                text_append(&text, " (%.9g %.9g %.9g )", off * cos(turn) + y * sin(turn),
                            off * sin(turn) - y * cos(turn), z);
            }
            text_append(&text, "\n");
            x += random_index(&random, 3) ? random_between(&random, 0.02, 0.1) : 64;
        }
        CellGraph *graph = prt_scene(&arena, text.data);
        WayGraph ways;
        ways_build(graph, &arena, &ways);
        int *stack = ARENA_ARRAY(&arena, int, ROOMS);
        for (int w = 0; w < ways.way_count; w++) {
            uint64_t row = 0;
            ways_flood(&ways, w, &row, stack);
            int to = ways.ways[w].to, from = ways.ways[w].from;
            for (int c = to; c >= 0 && c < ROOMS; c += to - from)
                cr_assert(row_has(&row, c), "row %d: through %d to %d a flood does not reach %d", k, from, to,
                          c);
        }
        for (int m = 0; PAIR_METHODS[m]; m++) {
            PairSet set = pairs_find(graph, PAIR_METHODS[m], 1, NULL, &arena);
            for (int a = 0; a < ROOMS; a++)
                for (int b = 0; b < ROOMS; b++)
                    cr_assert(pairs_sees(&set, a, b), "%s, row %d: %d does not see %d", PAIR_METHODS[m]->name,
                              k, a, b);
        }
        VisOptions options = vis_default_options();
        StabForest forest;
        cr_assert(vis_build_forest(graph, &options, NULL, &arena, &forest));
        for (int c = 0; c < ROOMS; c++)
            cr_assert_eq(forest.root[c + 1] - forest.root[c], ROOMS, "row %d: the tree of %d lacks a room", k,
                         c);
        arena_free(&arena);
    }
}

// A portal of the text of a portal file between two squares of 64 units, the second to the right of the first or above.
static void add_doorway(Text *text, int from, int to, int x, int y, bool right) {
    x *= 64, y *= 64;
    if (right)
        text_append(text, "4 %d %d (%d %d 64 ) (%d %d 0 ) (%d %d 0 ) (%d %d 64 )\n", from, to, x + 64, y,
                    x + 64, y, x + 64, y + 64, x + 64, y + 64);
    else
        text_append(text, "4 %d %d (%d %d 64 ) (%d %d 0 ) (%d %d 0 ) (%d %d 64 )\n", from, to, x + 64, y + 64,
                    x + 64, y + 64, x, y + 64, x, y + 64);
}

// Proves that no pair of an open hall is lost, in which there are millions of chains of portals: every cell of it sees every other,
// by every method and by trees. From a corner of the hall a crooked passage leads away, so that searches look for what is hidden.
Test(pairs, an_open_hall_is_seen_whole, .timeout = 120) {
    enum { SIDE = 13, HALL = SIDE * SIDE, STEPS = 6, CELLS = HALL + STEPS };
    static const bool RIGHT[STEPS] = {true, true, false, false, true, false};
    Arena arena = {0};
    Text text = {.arena = &arena};
    text_append(&text, "PRT1\n%d\n%d\n", CELLS, 2 * SIDE * (SIDE - 1) + STEPS);
    for (int c = 0; c < HALL; c++) {
        if (c % SIDE + 1 < SIDE) add_doorway(&text, c, c + 1, c % SIDE, c / SIDE, true);
        if (c / SIDE + 1 < SIDE) add_doorway(&text, c, c + SIDE, c % SIDE, c / SIDE, false);
    }
    for (int i = 0, x = SIDE - 1, y = SIDE - 1; i < STEPS; i++) {
        add_doorway(&text, HALL - 1 + i, HALL + i, x, y, RIGHT[i]);
        x += RIGHT[i], y += !RIGHT[i];
    }
    CellGraph *graph = prt_scene(&arena, text.data);
    for (int m = 0; PAIR_METHODS[m]; m++) {
        PairSet set = pairs_find(graph, PAIR_METHODS[m], 2, NULL, &arena);
        for (int a = 0; a < HALL; a++)
            for (int b = 0; b < HALL; b++)
                cr_assert(pairs_sees(&set, a, b), "%s: %d does not see %d", PAIR_METHODS[m]->name, a, b);
    }
    VisOptions options = vis_default_options();
    StabForest forest;
    cr_assert(vis_build_forest(graph, &options, NULL, &arena, &forest));
    for (int a = 0; a < HALL; a++)
        for (int b = 0; b < HALL; b++) cr_assert(vis_sees(&forest, a, b), "trees: %d does not see %d", a, b);
    arena_free(&arena);
}

// Proves that each portal is two ways, as large as the portal and facing where they lead, which a cell lists in their order, and that a
// cell's box is that of its portals; from the middle of the building.
Test(pairs, ways_are_portals_both_ways) {
    Random random = {4};
    for (int k = 0; k < 2; k++) {
        Arena arena = {0};
        Row row = row_random(&random, 9);
        CellGraph *g = k ? row_graph(&arena, &row) : pairs_rooms_graph(&arena, &random, 3, 3, 2);
        WayGraph ways;
        ways_build(g, &arena, &ways);
        cr_assert(ways.way_count == 2 * g->portal_count && ways.cell_count == g->cell_count);
        cr_assert_lt(vec3_length(vec3_sub(ways.origin, vec3_lerp(g->box.min, g->box.max, 0.5))), 1e-12);
        for (int w = 0; w < ways.way_count; w++) {
            const WayShape *way = &ways.ways[w];
            const Portal *portal = &g->portals[w / 2];
            cr_assert(way->from == portal->cell[w % 2] && way->to == portal->cell[1 - w % 2]);
            cr_assert_eq(way->corner_count, portal->vertex_count);
            double farthest = 0, side = w % 2 ? 1 : -1;
            for (int i = 0; i < way->corner_count; i++) {
                Vec3 corner =
                    g->portal_vertices[portal->first_vertex + (w % 2 ? i : way->corner_count - 1 - i)];
                cr_assert_lt(vec3_length(vec3_sub(vec3_add(way->corners[i], ways.origin), corner)), 1e-12);
                farthest = fmax(farthest, vec3_length(vec3_sub(way->corners[i], way->facet.middle)));
                cr_assert(box_contains(box_grow(ways.boxes[way->from], 1e-12), way->corners[i]));
                cr_assert_lt(fabs(plane_distance(way->facet.plane, way->corners[i])), 1e-9);
            }
            cr_assert_float_eq(way->radius, farthest, 1e-12);
            cr_assert_float_eq(vec3_dot(way->facet.plane.n, portal->plane.n), side, 1e-9);
            cr_assert(way->facet.bend < 1e-9 && !way->coarse);
        }
        for (int c = 0; c < g->cell_count; c++) {
            Box box = box_empty();
            int listed = ways.first[c];
            for (int w = 0; w < ways.way_count; w++) {
                if (ways.ways[w].from != c) continue;
                cr_assert(listed < ways.first[c + 1] && ways.list[listed] == w,
                          "cell %d lists its ways in order", c);
                listed++;
                for (int i = 0; i < ways.ways[w].corner_count; i++)
                    box = box_add(box, ways.ways[w].corners[i]);
            }
            cr_assert_eq(listed, ways.first[c + 1]);
            cr_assert(vec3_equal(box.min, ways.boxes[c].min) && vec3_equal(box.max, ways.boxes[c].max));
        }
        arena_free(&arena);
    }
}

// A convex polygon anywhere, as regular as may be, in the plane of `facet`.
static Winding random_winding(Random *random, double spread, Facet *facet) {
    Winding w = {.count = 3 + random_index(random, 6)};
    Vec3 n = fixture_direction(random), u = vec3_normalize(vec3_cross(n, fixture_direction(random))),
         v = vec3_cross(n, u);
    Vec3 middle = vec3_scale(fixture_direction(random), spread);
    double size = random_between(random, 0.1, 2);
    for (int i = 0; i < w.count; i++) {
        double turn = 2 * M_PI * (i + random_between(random, -0.3, 0.3)) / w.count;
        winding_set(
            &w, i,
            vec3_add(middle, vec3_add(vec3_scale(u, size * cos(turn)), vec3_scale(v, size * sin(turn)))));
    }
    winding_close(&w);
    *facet = (Facet){.plane = {n, vec3_dot(n, middle)}, .middle = middle};
    w.facet = facet;
    return w;
}

// Surely, as its plane is known to: to `bend`, and by `tilt` a metre less away from its middle.
static bool is_ahead(const Winding *edges, int side, Vec3 p) {
    const Facet *f = edges->facet;
    double doubt = f->bend + f->tilt * vec3_length(vec3_sub(p, f->middle));
    return side * plane_distance(f->plane, p) > 1e-9 + doubt;
}

// Proves that the tangents from the edges of a polygon are all there are: of each edge the plane, if there is one, that has on the wanted
// side all of the other polygon, touched in some corner of it that lies before the edges; by trying every corner.
Test(pairs, tangents_are_all_there_are) {
    static const double EPSILON = 1e-9;
    Random random = {31};
    int found = 0, none = 0, partly = 0;
    for (int n = 0; n < 20000; n++) {
        Facet facets[2];
        Winding edges = random_winding(&random, 0, &facets[0]),
                other = random_winding(&random, random_between(&random, 0.5, 6), &facets[1]);
        int side = n % 2 ? 1 : -1, count = 0, ahead = 0;
        int keep = n / 2 % 2 ? KEEP_OTHER : KEEP_EDGES;
        Separators out = {.count = 0};
        if (n % 3 == 0) facets[0].bend = 1e-3, facets[0].tilt = 0.05;
        winding_tangents(&edges, &other, side, keep, EPSILON, &out);
        int given = out.count;
        for (int k = 0; k < other.count; k++) ahead += is_ahead(&edges, side, winding_corner(&other, k));
        partly += ahead > 0 && ahead < other.count;
        for (int i = 0; i < edges.count; i++) {
            Vec3 a = winding_corner(&edges, i),
                 along = vec3_scale(vec3_sub(winding_corner(&edges, (i + 1) % edges.count), a), side),
                 normal = {0, 0, 0};
            bool there = false;
            for (int k = 0; k < other.count && !there; k++) {
                Vec3 p = winding_corner(&other, k);
                if (!is_ahead(&edges, side, p)) continue;
                normal = vec3_normalize(vec3_cross(along, vec3_sub(p, a)));
                there = true;
                for (int c = 0; c < other.count; c++)
                    there = there && vec3_dot(normal, vec3_sub(winding_corner(&other, c), a)) > -1e-12;
            }
            none += !there;
            if (!there) continue;
            found++;
            cr_assert_lt(count, given, "case %d: edge %d has a tangent", n, i);
            Plane s = separators_at(&out, count++);
            double sign = keep == KEEP_OTHER ? 1 : -1;
            cr_assert_float_eq(vec3_length(s.n), 1, 1e-12);
            cr_assert_float_eq(vec3_dot(s.n, normal), sign, 1e-6, "case %d: edge %d", n, i);
            cr_assert_float_eq(s.d, vec3_dot(s.n, a), 1e-9);
            for (int c = 0; c < edges.count; c++)
                cr_assert_leq(sign * plane_distance(s, winding_corner(&edges, c)), 1e-9,
                              "case %d: the edges lie behind", n);
        }
        cr_assert_eq(count, given, "case %d: %d tangents, not %d", n, given, count);
    }
    cr_expect(found > 10000 && none > 1000 && partly > 1000, "%d tangents, %d edges without, %d partly ahead",
              found, none, partly);
}

// Through low slits one above the other heights alone decide: `height` loses none that is seen, by whatever little.
Test(pairs, heights_lose_no_slit) {
    Random random = {13};
    int hidden = 0, narrow = 0;
    for (int k = 0; k < 400; k++) {
        Arena arena = {0};
        Row row = row_random(&random, 5 + k % 3);
        for (int i = 0; i < row.room_count; i++) {
            int low = random_index(&random, 24);
            row.doorway[i] = (Doorway){{0, 2}, {low, low + 1 + random_index(&random, 12)}};
        }
        PairSet height = pairs_find(row_graph(&arena, &row), pair_method("height"), 1, NULL, &arena);
        for (int b = 3; b < row.room_count; b++) {
            for (int a = 0; a + 2 < b; a++) {
                RowSight truth = row_sight(&row, a, b, true);
                cr_expect(pairs_sees(&height, a, b) || truth != ROW_SEEN, "row %d: %d to %d", k, a, b);
                hidden += !pairs_sees(&height, a, b);
                narrow += truth == ROW_SEEN;
            }
        }
        arena_free(&arena);
    }
    cr_expect_gt(hidden, 500, "%d", hidden);
    cr_expect_gt(narrow, 500, "%d", narrow);
}
