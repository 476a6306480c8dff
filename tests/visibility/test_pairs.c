// test_pairs.c - the cell-to-cell methods against each other, against sampled sightlines, and where the truth is known.
#include <criterion/criterion.h>

#include "engine/core/file.h"
#include "engine/core/text.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/rounds.h"
#include "visibility/pairs/sample.h"
#include "visibility/pairs/seen_file.h"
#include "visibility/pairs/witness.h"
#include "visibility/ways.h"

static PairSet find(const CellGraph *graph, const PairMethod *method, int threads, const Progress *progress,
                    Arena *arena) {
    PairOptions options = {.threads = threads, .witnesses = true};
    PairSet set;
    method->find(graph, &options, progress, arena, &set);
    return set;
}

static bool sees(const PairSet *set, int a, int b) { return pair_bit(set->seen, set->words, a, b); }

static CellGraph *read_graph(Arena *arena, const char *path) {
    Building *building = ARENA_ARRAY(arena, Building, 1);
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    VisOptions options = vis_default_options();
    Error error = {""};
    cr_assert(maps_read(path, arena, building, &error), "%s", error.text);
    cr_assert(vis_build_cells(building, &options, arena, graph, &error), "%s", error.text);
    return graph;
}

static CellGraph *rooms_graph(Arena *arena, Random *random, int nx, int ny, int storeys) {
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    VisOptions options = vis_default_options();
    Error error = {""};
    Building *building = fixture_rooms(arena, random, nx, ny, storeys);
    cr_assert(vis_build_cells(building, &options, arena, graph, &error), "%s", error.text);
    return graph;
}

static SampleSet sample(const CellGraph *graph, int points, int threads, Arena *arena) {
    SampleOptions options = {.threads = threads, .points = points, .seed = 5};
    SampleSet set;
    sample_pairs(graph, &options, NULL, arena, &set);
    return set;
}

// Rows whose transpose differs, or in which a cell is missing itself.
static int asymmetries(const uint64_t *rows, int cells) {
    int words = (cells + 63) / 64, wrong = 0;
    for (int i = 0; i < cells; i++) {
        wrong += !pair_bit(rows, words, i, i);
        for (int j = 0; j < i; j++) wrong += pair_bit(rows, words, i, j) != pair_bit(rows, words, j, i);
    }
    return wrong;
}

// Every result is sound: symmetric; a proven pair is a seen one; all witnesses stand the second walk, and come once a pair in order.
static void expect_sound(const CellGraph *graph, const PairMethod *method, const PairSet *set) {
    Arena scratch = {0};
    int cells = graph->cell_count;
    uint64_t *checked = ARENA_ARRAY(&scratch, uint64_t, (size_t)cells * (size_t)set->words);
    cr_expect_eq(asymmetries(set->seen, cells), 0, "%s: asymmetric", method->name);
    cr_expect_eq(pairs_compare(set->seen, set->proven, cells).missed, 0, "%s: proven, not seen",
                 method->name);
    for (int i = 0; i < set->witness_count; i++) {
        const PairWitness *w = &set->witnesses[i];
        cr_assert(w->a < w->b && (i == 0 || w[-1].a < w->a || (w[-1].a == w->a && w[-1].b < w->b)),
                  "%s: sightline %d of %d and %d is not in order", method->name, i, w->a, w->b);
    }
    cr_expect_eq(pairs_check_witnesses(graph, set, checked), 0, "%s: a sightline does not hold",
                 method->name);
    cr_expect_eq(pairs_compare(set->seen, checked, cells).missed, 0, "%s: a sightline to what is not seen",
                 method->name);
    arena_free(&scratch);
}

// Methods that only ever add a constraint to another see no more than that one. Index into PAIR_METHODS by name.
static const char *const TIGHTER[][2] = {
    {"flood", "plan"}, {"plan", "height"}, {"flood", "flow"}, {"flow", "proof"}};

static void expect_ordered(const CellGraph *graph, Arena *arena) {
    for (size_t i = 0; i < sizeof TIGHTER / sizeof *TIGHTER; i++) {
        PairSet coarse = find(graph, pair_method(TIGHTER[i][0]), 2, NULL, arena);
        PairSet fine = find(graph, pair_method(TIGHTER[i][1]), 2, NULL, arena);
        cr_expect_eq(pairs_compare(coarse.seen, fine.seen, graph->cell_count).missed, 0,
                     "%s sees more than %s", TIGHTER[i][1], TIGHTER[i][0]);
    }
}

static void expect_samples_seen(const CellGraph *graph, const SampleSet *samples, Arena *arena) {
    for (int m = 0; PAIR_METHODS[m]; m++) {
        PairSet set = find(graph, PAIR_METHODS[m], 2, NULL, arena);
        PairFigures f = pairs_compare(set.seen, samples->proven, graph->cell_count);
        cr_expect_eq(f.missed, 0, "%s misses %lld pairs, first %d and %d", PAIR_METHODS[m]->name, f.missed,
                     f.miss[0], f.miss[1]);
        expect_sound(graph, PAIR_METHODS[m], &set);
    }
}

// No method misses what a sampled sightline proves, in buildings of regions with doors, pillars and two storeys.
Test(pairs, nothing_sampled_is_missed) {
    Random random = {3};
    for (int k = 0; k < support_count(4, 40); k++) {
        Arena arena = {0};
        CellGraph *graph = rooms_graph(&arena, &random, 2 + k % 3, 2, 1 + k % 2);
        SampleSet samples = sample(graph, 12, 2, &arena);
        cr_expect_gt(pair_count(samples.proven, samples.cell_count, samples.words), 2 * graph->cell_count);
        expect_samples_seen(graph, &samples, &arena);
        expect_ordered(graph, &arena);
        arena_free(&arena);
    }
}

// The same on a sealed map drawn by others, against the pairs proven by others too; without it, on the tilted cells of a home.
Test(pairs, nothing_known_is_missed, .timeout = 300) {
    Arena arena = {0};
    bool known_by_others = support_has_shared("prt/lqdm2_omitdetail.seen");
    CellGraph *graph = read_graph(&arena, prt_file(&arena, "lqdm2_omitdetail", "build/maps/hillside.sh3d"));
    SampleSet samples = sample(graph, support_count(2, 120), 2, &arena);
    uint64_t *known;
    Error error = {""};
    if (known_by_others) {
        cr_assert(
            seen_read(support_shared("prt/lqdm2_omitdetail.seen"), graph->cell_count, &arena, &known, &error),
            "%s", error.text);
        pairs_unite(known, graph->cell_count, samples.proven);
    }
    expect_samples_seen(graph, &samples, &arena);
    // Among tilted cells `height` may see pairs that `plan` excludes: neither knows slopes.
    if (known_by_others) expect_ordered(graph, &arena);
    PairSet best = find(graph, pair_method("proof"), 2, NULL, &arena);
    PairFigures f = pairs_compare(best.seen, samples.proven, graph->cell_count);
    // The bar for this map; what has a sightline of its own counts as proven below it.
    cr_expect(!known_by_others || pairs_over(&f) < 0.05, "over-estimate %.3f %%", pairs_over(&f));
    arena_free(&arena);
}

// Maps with slopes, where cells touch along portals that lines graze: each sightline of the proof holds nevertheless.
Test(pairs, sightlines_hold_among_slopes, .timeout = 300) {
    static const char *const MAPS[] = {"lq_e1m5_omitdetail", "e1m1", "lq_e2m2_nodetail", "lqdm13_omitdetail"};
    static const char *const HOMES[] = {"build/maps/hillside.sh3d", "build/maps/flat.Home.xml"};
    for (int k = 0; k < support_count(2, 4); k++) {
        Arena arena = {0};
        CellGraph *graph = read_graph(&arena, prt_file(&arena, MAPS[k], HOMES[k % 2]));
        PairSet set = find(graph, pair_method("proof"), 2, NULL, &arena);
        cr_expect_gt(set.witness_count, 10 * graph->cell_count);
        expect_sound(graph, pair_method("proof"), &set);
        arena_free(&arena);
    }
}

// Nor in the sample buildings, whose portals have doubled corners among others.
Test(pairs, nothing_is_missed_in_the_samples, .timeout = 300) {
    static const char *const MAPS[] = {"two-rooms", "house", "office-plain"};
    for (int k = 0; k < 3; k++) {
        Arena arena = {0};
        CellGraph *graph = read_graph(&arena, arena_format(&arena, "build/maps/%s.plan", MAPS[k]));
        SampleSet samples = sample(graph, support_count(4, 100), 2, &arena);
        expect_samples_seen(graph, &samples, &arena);
        expect_ordered(graph, &arena);
        arena_free(&arena);
    }
}

// Rooms in a row. In plan the truth is known exactly, touching lines among it; in space but for touching ones.
Test(pairs, a_row_of_rooms_is_seen_as_it_is) {
    Random random = {11};
    int hidden_by_height = 0, hidden = 0, seen = 0;
    for (int k = 0; k < support_count(40, 1000); k++) {
        Arena arena = {0};
        Row row = row_random(&random, 4 + k % 6);
        CellGraph *graph = row_graph(&arena, &row);
        PairSet plan = find(graph, pair_method("plan"), 1, NULL, &arena);
        PairSet height = find(graph, pair_method("height"), 1, NULL, &arena);
        PairSet flow = find(graph, pair_method("flow"), 1, NULL, &arena);
        PairSet proof = find(graph, pair_method("proof"), 1, NULL, &arena);
        for (int b = 1; b < row.room_count; b++) {
            for (int a = 0; a < b; a++) {
                RowSight flat = row_sight(&row, a, b, false), full = row_sight(&row, a, b, true);
                cr_expect_eq(sees(&plan, a, b), flat != ROW_HIDDEN, "plan: %d to %d", a, b);
                cr_expect(sees(&height, a, b) || full != ROW_SEEN, "height: %d to %d", a, b);
                if (full != ROW_TOUCHED) {
                    cr_expect_eq(sees(&flow, a, b), full == ROW_SEEN, "flow: %d to %d", a, b);
                    cr_expect_eq(sees(&proof, a, b), full == ROW_SEEN, "proof: %d to %d", a, b);
                    cr_expect_eq(pair_bit(proof.proven, proof.words, a, b), full == ROW_SEEN, "%d to %d", a,
                                 b);
                }
                hidden_by_height += sees(&plan, a, b) && !sees(&height, a, b);
                hidden += full == ROW_HIDDEN;
                seen += full == ROW_SEEN && b > a + 2;
            }
        }
        arena_free(&arena);
    }
    cr_expect_gt(hidden_by_height, 20);
    cr_expect_gt(hidden, 100);
    cr_expect_gt(seen, 20);
}

// A row of rooms whose doorways are slim triangles in walls across x, turned at random, that have nothing in common but a tube about
// one line, `clear` units wide: so much lies between the line and both long sides of each triangle. `slimmest`: the least of half the
// angles between these, the greatest is ten times that.
static CellGraph *tube_graph(Arena *arena, Random *random, int rooms, double clear, double slimmest) {
    Text text = {.arena = arena};
    double rise[2] = {random_between(random, -0.3, 0.3), random_between(random, -0.3, 0.3)};
    text_append(&text, "PRT1\n%d\n%d\n", rooms, rooms - 1);
    for (int k = 0; k + 1 < rooms; k++) {
        double x = 64 * (k + random_between(random, 0, 0.5)), turn = random_between(random, 0, 2 * M_PI);
        double half = slimmest * pow(10, random_between(random, 0, 1)),
               long_side = random_between(random, 30, 60);
        text_append(&text, "3 %d %d", k, k + 1);
        // The apex lies behind the line, the long sides go off ahead of it.
        for (int c = 0; c < 3; c++) {
            double behind = clear / sin(half), side = c == 0 ? 0 : (2 * c - 3) * half;
            double length = c == 0 ? 0 : behind + long_side;
            double y = rise[0] * x - behind * cos(turn) + length * cos(turn + side);
            double z = rise[1] * x - behind * sin(turn) + length * sin(turn + side);
            text_append(&text, " (%.12g %.12g %.12g )", x, y, z);
        }
        text_append(&text, "\n");
    }
    return prt_scene(arena, text.data);
}

// Proves that what is seen through ever so thin a tube stays seen by every method, also where the search for it is broken off: as
// thin as ten thousand times what rounding takes, where neither planes nor a line may decide. And that the last doubts do not
// leave the truth undecided where the tube is wide.
Test(pairs, what_is_seen_through_a_thin_tube_stays_seen) {
    Random random = {17};
    int undecided[2] = {0};
    for (int k = 0; k < support_count(600, 6000); k++) {
        Arena arena = {0};
        int wide = k % 2, rooms = 5 + k / 2 % (wide ? 3 : 8);
        double clear = wide ? 1 : pow(10, random_between(&random, -7, -1));
        CellGraph *graph = tube_graph(&arena, &random, rooms, clear, wide ? 0.07 : 0.001);
        for (int m = 0; PAIR_METHODS[m]; m++) {
            PairSet set = find(graph, PAIR_METHODS[m], 1, NULL, &arena);
            for (int b = 0; b < rooms; b++) {
                for (int a = 0; a < b; a++) {
                    cr_expect(sees(&set, a, b), "%s, row %d: %d does not see %d", PAIR_METHODS[m]->name, k, a,
                              b);
                    if (PAIR_METHODS[m] == pair_method("proof"))
                        undecided[wide] += !pair_bit(set.proven, set.words, a, b);
                }
            }
        }
        arena_free(&arena);
    }
    cr_expect(undecided[0] > 20 && undecided[1] == 0, "%d and %d", undecided[0], undecided[1]);
}

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
            PairSet set = find(graph, PAIR_METHODS[m], 1, NULL, &arena);
            for (int a = 0; a < ROOMS; a++)
                for (int b = 0; b < ROOMS; b++)
                    cr_expect(sees(&set, a, b), "%s, row %d: %d does not see %d", PAIR_METHODS[m]->name, k, a,
                              b);
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
            PairSet set = find(graph, PAIR_METHODS[m], 1, NULL, &arena);
            for (int a = 0; a < ROOMS; a++)
                for (int b = 0; b < ROOMS; b++)
                    cr_assert(sees(&set, a, b), "%s, row %d: %d does not see %d", PAIR_METHODS[m]->name, k, a,
                              b);
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
        PairSet set = find(graph, PAIR_METHODS[m], 2, NULL, &arena);
        for (int a = 0; a < HALL; a++)
            for (int b = 0; b < HALL; b++)
                cr_assert(sees(&set, a, b), "%s: %d does not see %d", PAIR_METHODS[m]->name, a, b);
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
        CellGraph *g = k ? row_graph(&arena, &row) : rooms_graph(&arena, &random, 3, 3, 2);
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

// A convex polygon anywhere, as regular as may be.
static Winding random_winding(Random *random, double spread) {
    Winding w = {.count = 3 + random_index(random, 6)};
    Vec3 n = fixture_direction(random), u = vec3_normalize(vec3_cross(n, fixture_direction(random))),
         v = vec3_cross(n, u);
    Vec3 middle = vec3_scale(fixture_direction(random), spread);
    double size = random_between(random, 0.1, 2);
    for (int i = 0; i < w.count; i++) {
        double turn = 2 * M_PI * (i + random_between(random, -0.3, 0.3)) / w.count;
        w.p[i] = vec3_add(middle, vec3_add(vec3_scale(u, size * cos(turn)), vec3_scale(v, size * sin(turn))));
    }
    w.facet = (Facet){.plane = {n, vec3_dot(n, middle)}, .middle = middle};
    return w;
}

// Surely, as its plane is known to: to `bend`, and by `tilt` a metre less away from its middle.
static bool is_ahead(const Winding *edges, int side, Vec3 p) {
    const Facet *f = &edges->facet;
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
        Winding edges = random_winding(&random, 0),
                other = random_winding(&random, random_between(&random, 0.5, 6));
        int side = n % 2 ? 1 : -1, count = 0, ahead = 0;
        int keep = n / 2 % 2 ? KEEP_OTHER : KEEP_EDGES;
        Separator out[WINDING_MAX];
        if (n % 3 == 0) edges.facet.bend = 1e-3, edges.facet.tilt = 0.05;
        int given = winding_tangents(&edges, &other, side, keep, EPSILON, out);
        for (int k = 0; k < other.count; k++) ahead += is_ahead(&edges, side, other.p[k]);
        partly += ahead > 0 && ahead < other.count;
        for (int i = 0; i < edges.count; i++) {
            Vec3 a = edges.p[i], along = vec3_scale(vec3_sub(edges.p[(i + 1) % edges.count], a), side),
                 normal = {0, 0, 0};
            bool there = false;
            for (int k = 0; k < other.count && !there; k++) {
                if (!is_ahead(&edges, side, other.p[k])) continue;
                normal = vec3_normalize(vec3_cross(along, vec3_sub(other.p[k], a)));
                there = true;
                for (int c = 0; c < other.count; c++)
                    there = there && vec3_dot(normal, vec3_sub(other.p[c], a)) > -1e-12;
            }
            none += !there;
            if (!there) continue;
            found++;
            cr_assert_lt(count, given, "case %d: edge %d has a tangent", n, i);
            Separator s = out[count++];
            double length = vec3_length(s.n), sign = keep == KEEP_OTHER ? 1 : -1;
            cr_assert_float_eq(vec3_dot(s.n, normal), sign * length, 1e-6 * length, "case %d: edge %d", n, i);
            cr_assert_float_eq(s.d, vec3_dot(s.n, a), 1e-9 * (1 + length));
            cr_assert(s.slack >= EPSILON * length * 0.999 && s.slack <= 1.8 * EPSILON * length);
            for (int c = 0; c < edges.count; c++)
                cr_assert_leq(sign * (vec3_dot(s.n, edges.p[c]) - s.d), 1e-9, "case %d: the edges lie behind",
                              n);
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
        PairSet height = find(row_graph(&arena, &row), pair_method("height"), 1, NULL, &arena);
        for (int b = 3; b < row.room_count; b++) {
            for (int a = 0; a + 2 < b; a++) {
                RowSight truth = row_sight(&row, a, b, true);
                cr_expect(sees(&height, a, b) || truth != ROW_SEEN, "row %d: %d to %d", k, a, b);
                hidden += !sees(&height, a, b);
                narrow += truth == ROW_SEEN;
            }
        }
        arena_free(&arena);
    }
    cr_expect_gt(hidden, 500, "%d", hidden);
    cr_expect_gt(narrow, 500, "%d", narrow);
}

// The sampler finds nothing that is hidden, and nearly all there is: what it misses is seen through slits only.
Test(pairs, samples_know_a_row_of_rooms) {
    Random random = {12};
    int seen = 0, found = 0;
    for (int k = 0; k < 40; k++) {
        Arena arena = {0};
        Row row = row_random(&random, 4 + k % 6);
        CellGraph *graph = row_graph(&arena, &row);
        SampleSet samples = sample(graph, 40, 1, &arena);
        cr_expect_eq(asymmetries(samples.proven, graph->cell_count), 0);
        for (int b = 1; b < row.room_count; b++) {
            for (int a = 0; a < b; a++) {
                bool proven = pair_bit(samples.proven, samples.words, a, b);
                RowSight truth = row_sight(&row, a, b, true);
                cr_expect(!proven || truth == ROW_SEEN, "%d to %d is hidden", a, b);
                seen += truth == ROW_SEEN;
                found += proven;
            }
        }
        arena_free(&arena);
    }
    cr_expect_geq(found, seen * 99 / 100, "%d of %d found", found, seen);
}

static uint64_t hash_of(const PairSet *set) {
    uint64_t hash = file_hash(set->witnesses, (size_t)set->witness_count * sizeof *set->witnesses, 0);
    size_t size = (size_t)set->cell_count * (size_t)set->words * sizeof *set->seen;
    hash = file_hash(set->proven, size, file_hash(set->seen, size, hash));
    return file_hash(&set->work, sizeof set->work, hash);
}

// Pairs, proofs, witnesses and counts of work are the same on 1, 2 and 7 threads; samples too.
Test(pairs, threads_do_not_show) {
    Arena arena = {0};
    Random random = {4};
    CellGraph *graph = rooms_graph(&arena, &random, 4, 3, 2);
    for (int m = 0; PAIR_METHODS[m]; m++) {
        PairSet one = find(graph, PAIR_METHODS[m], 1, NULL, &arena);
        for (int threads = 2; threads <= 7; threads += 5) {
            PairSet other = find(graph, PAIR_METHODS[m], threads, NULL, &arena);
            cr_expect_eq(hash_of(&one), hash_of(&other), "%s on %d threads", PAIR_METHODS[m]->name, threads);
        }
    }
    SampleSet one = sample(graph, 3, 1, &arena), seven = sample(graph, 3, 7, &arena);
    size_t size = (size_t)one.cell_count * (size_t)one.words * sizeof *one.proven;
    cr_expect_arr_eq(one.proven, seven.proven, size);
    cr_expect(one.windows == seven.windows && one.refuted == seven.refuted);
    arena_free(&arena);
}

// More points find no less, and another sightline is told for each pair that was found.
Test(pairs, samples_grow_and_can_be_shown) {
    Arena arena = {0};
    Random random = {6};
    CellGraph *graph = rooms_graph(&arena, &random, 3, 2, 1);
    SampleSet few = sample(graph, 2, 2, &arena), many = sample(graph, 12, 2, &arena);
    cr_expect_eq(pairs_compare(many.proven, few.proven, graph->cell_count).missed, 0);
    SampleOptions options = {.points = 2, .seed = 5};
    for (int a = 0; a < graph->cell_count; a++) {
        for (int b = 0; b < graph->cell_count; b++) {
            PairWitness line;
            bool there = sample_sightline(graph, &options, a, b, &line) ||
                         sample_sightline(graph, &options, b, a, &line);
            cr_expect_eq(there, a != b && pair_bit(few.proven, few.words, a, b), "%d and %d", a, b);
            if (there) cr_expect(witness_walk(graph, line.a, line.b, line.from, line.to).proves);
        }
    }
    arena_free(&arena);
}

typedef struct Patience {
    int left;
} Patience;
static bool run_out(void *context, const char *stage, double done) {
    (void)stage, (void)done;
    return ((Patience *)context)->left-- > 0;
}

// Stopped at any report, a method tells so, and what it then calls visible holds all that it would have found; of the
// samples there are only fewer.
Test(pairs, what_is_stopped_errs_towards_visible) {
    Arena arena = {0};
    Random random = {8};
    CellGraph *graph = rooms_graph(&arena, &random, 3, 3, 1);
    for (int m = 0; PAIR_METHODS[m]; m++) {
        const PairMethod *method = PAIR_METHODS[m];
        PairSet whole = find(graph, method, 2, NULL, &arena);
        cr_expect_not(whole.stopped, "%s", method->name);
        for (int left = 0; left < 40; left += 1 + left) {
            Patience patience = {left};
            Progress progress = {run_out, &patience};
            PairSet part = find(graph, method, 2, &progress, &arena);
            // The flood is done before it would report.
            cr_expect_eq(part.stopped, patience.left < 0, "%s after %d reports", method->name, left);
            cr_expect_eq(pairs_compare(part.seen, whole.seen, graph->cell_count).missed, 0,
                         "%s after %d reports", method->name, left);
            expect_sound(graph, method, &part);
        }
    }
    Patience patience = {3};
    Progress progress = {run_out, &patience};
    SampleOptions options = {.threads = 2, .points = 4, .seed = 5};
    SampleSet part, whole = sample(graph, 4, 2, &arena);
    sample_pairs(graph, &options, &progress, &arena, &part);
    cr_expect(part.stopped);
    cr_expect_eq(pairs_compare(whole.proven, part.proven, graph->cell_count).missed, 0);
    arena_free(&arena);
}

static void arrive(Flow *flow, int depth) {
    int cell = flow_cell(flow, depth);
    row_add(((Finding *)flow->context)->kept, cell);
    row_drop(flow->unknown, cell);
}

// With `scale` times the usual work.
static PairSet search_with(const CellGraph *graph, double scale, Arena *arena) {
    PairOptions options = {.threads = 2};
    PairSet set;
    Rounds rounds;
    rounds_start(&rounds, graph, &options, NULL, arena, &set);
    rounds.ways.scale = scale;
    rounds_search(&rounds, NULL, arrive);
    rounds_end(&rounds);
    return set;
}

// Proves that searches which may do little work are given up and counted, and that what was in doubt then counts as visible, up to all
// that the flood reaches.
Test(pairs, given_up_errs_towards_visible) {
    Arena arena = {0};
    Random random = {8};
    CellGraph *graph = rooms_graph(&arena, &random, 4, 4, 1);
    PairSet whole = search_with(graph, 1, &arena), less = whole,
            flood = find(graph, pair_method("flood"), 2, NULL, &arena);
    cr_expect_eq(whole.work.given_up, 0);
    // A thousandth of the usual work is too little for a few searches, a ten-millionth for any but the easiest.
    for (int k = 3; k < 8; k++) {
        PairSet part = search_with(graph, pow(10, -k), &arena);
        cr_expect(part.work.given_up > 0 && part.work.given_up >= less.work.given_up, "1e-%d: %lld", k,
                  part.work.given_up);
        cr_expect_eq(pairs_compare(part.seen, less.seen, graph->cell_count).missed, 0, "1e-%d", k);
        cr_expect_eq(pairs_compare(flood.seen, part.seen, graph->cell_count).missed, 0, "1e-%d", k);
        cr_expect_eq(asymmetries(part.seen, graph->cell_count), 0, "1e-%d", k);
        less = part;
    }
    cr_expect_gt(pair_count(less.seen, less.cell_count, less.words),
                 pair_count(whole.seen, whole.cell_count, whole.words));
    arena_free(&arena);
}

// Proves that work grows with the square of a file's size above a megabyte, and is 24 times as much for a map of Doom.
Test(pairs, work_grows_with_the_file) {
    static const struct {
        double size;
        const char *map;
        long long expected;
    } CASES[] = {{0, NULL, 100},     {1, NULL, 100},       {1e6, NULL, 100},    {3e6, NULL, 900},
                 {1e7, NULL, 10000}, {1e5, "MAP01", 2400}, {2e6, "MAP01", 9600}};
    Arena arena = {0};
    Random random = {8};
    CellGraph graph = *rooms_graph(&arena, &random, 2, 1, 1);
    Building building = *graph.building;
    graph.building = &building;
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        WayGraph ways;
        building.file_size = CASES[i].size;
        building.map = CASES[i].map;
        ways_build(&graph, &arena, &ways);
        cr_expect_eq(ways_work(&ways, 100), CASES[i].expected, "%zu: %lld", i, ways_work(&ways, 100));
    }
    arena_free(&arena);
}

// A graph without portals, and one of a single cell: everybody sees only themselves.
Test(pairs, lonely_cells_see_themselves) {
    Arena arena = {0};
    static const char *const TEXTS[] = {"PRT1\n1\n0\n", "PRT1\n70\n0\n"};
    for (int k = 0; k < 2; k++) {
        CellGraph *graph = prt_scene(&arena, TEXTS[k]);
        for (int c = 0; c < graph->cell_count; c++) {
            Box box = graph->cells[c].box;
            cr_expect(vec3_equal(box.min, box.max) && graph->cells[c].face_count == 0, "it is nowhere");
        }
        for (int m = 0; PAIR_METHODS[m]; m++) {
            PairSet set = find(graph, PAIR_METHODS[m], 2, NULL, &arena);
            cr_expect_eq(pair_count(set.seen, set.cell_count, set.words), graph->cell_count, "%s",
                         PAIR_METHODS[m]->name);
            expect_sound(graph, PAIR_METHODS[m], &set);
        }
        SampleSet samples = sample(graph, 3, 2, &arena);
        cr_expect_eq(pair_count(samples.proven, samples.cell_count, samples.words), graph->cell_count);
    }
    arena_free(&arena);
}

// The table: names differ, each is found by its name, others are not.
Test(pairs, methods_have_names) {
    for (int m = 0; PAIR_METHODS[m]; m++) {
        cr_expect_eq(pair_method(PAIR_METHODS[m]->name), PAIR_METHODS[m]);
        cr_expect_gt(strlen(PAIR_METHODS[m]->summary), 0u);
    }
    cr_expect_null(pair_method("nonsense"));
}
