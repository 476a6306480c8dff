// test_panes.c - the transmittance of a pane, and which openings of buildings hold one.
#include <criterion/criterion.h>
#include <stdio.h>

#include <stdlib.h>

#include "engine/core/file.h"
#include "engine/core/random.h"
#include "maps/maps.h"
#include "radiosity/mesh/panes.h"
#include "tests/support/support.h"

// Light that a pane passes, followed from face to face: at each it parts in two, by Fresnel's formulae as tangents and sines have them.
static double followed(double angle, double index, double through) {
    double inside = asin(sin(angle) / index), sum = 0, share[2];
    if (angle == 0) {
        share[0] = share[1] = pow((index - 1) / (index + 1), 2);
    } else {
        share[0] = pow(sin(angle - inside) / sin(angle + inside), 2);
        share[1] = pow(tan(angle - inside) / tan(angle + inside), 2);
    }
    for (int polarised = 0; polarised < 2; polarised++) {
        double r = share[polarised], light = 0.5 * (1 - r), way = pow(through, 1 / cos(inside));
        for (int face = 1; face < 4000; face++) {
            light *= way;
            if (face % 2) sum += light * (1 - r);
            light *= r;
        }
    }
    return sum;
}

// Proves the transmittance against a sum that follows the light, and against figures: clear float glass of 3 mm passes 0.91 straight on
// (data sheets); without absorption a pane of index 1.52 passes (1 - r) / (1 + r) = 0.918 there, and 0.844 at 60 degrees. Tolerances:
// rounding; half a unit of the last digit of a figure.
Test(panes, transmittance_by_angle) {
    for (int degrees = 0; degrees < 90; degrees++) {
        double angle = degrees * M_PI / 180;
        cr_expect_float_eq(glass_transmits(cos(angle)), followed(angle, 1.52, 0.991), 1e-12, "%d degrees",
                           degrees);
    }
    double r = pow(0.52 / 2.52, 2);
    cr_expect_float_eq(followed(0, 1.52, 1), (1 - r) / (1 + r), 1e-12);
    cr_expect_float_eq(followed(0, 1.52, 1), 0.918, 5e-4);
    cr_expect_float_eq(followed(M_PI / 3, 1.52, 1), 0.844, 1e-3);
    cr_expect_float_eq(glass_transmits(1), 0.910, 5e-4);
    cr_expect_float_eq(glass_transmits(cos(M_PI / 6)), 0.907, 5e-4);
    cr_expect_float_eq(glass_transmits(0.5), 0.834, 5e-4);
    cr_expect_float_eq(glass_transmits(cos(80 * M_PI / 180)), 0.449, 5e-4);
    cr_expect_eq(glass_transmits(0), 0);
    cr_expect_float_eq(glass_transmits(1e-6), 0, 1e-4);
}

// Proves that it falls with the angle, and its mean over a hemisphere of even light, by the middle rule: between 0.83 and 0.86, as books
// have it for one clear pane.
Test(panes, transmittance_of_even_light) {
    enum { STEPS = 100000 };
    double sum = 0, last = 0;
    for (int i = 0; i < STEPS; i++) {
        double cosine = (i + 0.5) / STEPS, passes = glass_transmits(cosine);
        cr_assert_geq(passes, last);
        last = passes;
        sum += 2 * cosine * passes / STEPS;
    }
    printf("even light: %.4f passes\n", sum);
    cr_expect(sum > 0.83 && sum < 0.86, "%g", sum);
}

typedef struct Glazed {
    Arena arena;
    Building building;
    CellGraph graph;
} Glazed;

static Glazed *glazed_read(const char *path) {
    Glazed *g = calloc(1, sizeof *g);
    Error error = {""};
    VisOptions vis = vis_default_options();
    cr_assert(maps_read(path, &g->arena, &g->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&g->building, &vis, &g->arena, &g->graph, &error), "%s", error.text);
    return g;
}

static void glazed_free(Glazed *g) {
    arena_free(&g->arena);
    free(g);
}

static Glazed *glazed_plan(const char *openings) {
    Arena arena = {0};
    Error error = {""};
    const char *path = arena_format(&arena, "%s/panes.plan", support_folder(&arena));
    const char *text =
        arena_format(&arena,
                     "plan 1\nmaterial white #E8E8E8\nstorey ground floor 0 height 2.5 slab 0.3\n"
                     "room a 0,0 2,0 2,3 0,3 walls white wall 0.2\n"
                     "room b 2.2,0 6,0 6,3 2.2,3 walls white wall 0.2\n%s",
                     openings);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    Glazed *g = glazed_read(path);
    arena_free(&arena);
    return g;
}

// Proves which openings hold a pane: windows, and glazed doors while they are closed; neither passages nor doors of wood, open or not. And
// that panes on one line multiply, by the angle, while a line beside them or within a room passes none.
Test(panes, stand_in_windows_and_closed_glazed_doors) {
    Glazed *g = glazed_plan("window w -0.1,1.5 angle 90 width 1 sill 0.5 height 1.5\n"
                            "door d 2.1,1.5 angle 90 width 1 height 2.1 glazed\n"
                            "door o 2.1,0.5 angle 90 width 0.8 height 2.1\n"
                            "passage p 6.1,1.5 angle 90 width 1 height 2.1\n");
    float closed[4] = {0, 0, 0, 0}, ajar[4] = {0, 0.01f, 0, 0};
    const struct {
        const float *doors;
        int panes;
    } CASES[] = {{closed, 2}, {ajar, 1}, {NULL, 1}};
    cr_assert_eq(g->building.opening_count, 4);
    for (int i = 0; i < 3; i++)
        cr_expect_eq(panes_of(&g->graph, CASES[i].doors, &g->arena).count, CASES[i].panes, "case %d", i);
    Panes both = panes_of(&g->graph, closed, &g->arena), one = panes_of(&g->graph, ajar, &g->arena);
    Vec3 out = {-2, 1.4, 1.2}, in = {1, 1.5, 1.3}, beyond = {4, 1.6, 1.4};
    Vec3 way = vec3_normalize(vec3_sub(beyond, out));
    double each = glass_transmits(way.x);
    cr_expect_float_eq(panes_transmit(&both, out, beyond), each * each, 1e-12);
    cr_expect_float_eq(panes_transmit(&both, beyond, out), each * each, 1e-12);
    cr_expect_float_eq(panes_transmit(&one, out, beyond), each, 1e-12);
    cr_expect_float_eq(panes_transmit(&both, in, beyond), each, 1e-12);
    cr_expect_float_eq(panes_transmit_from_afar(&both, beyond, vec3_scale(way, -1)), each * each, 1e-12);
    cr_expect_eq(panes_transmit_from_afar(&both, out, vec3_scale(way, -1)), 1);
    cr_expect_eq(panes_transmit(&both, in, vec3(1.5, 2, 0)), 1);
    cr_expect_eq(panes_transmit(&both, vec3(1, 1.5, 0.2), vec3(4, 1.5, 0.2)), glass_transmits(1));
    cr_expect_eq(panes_transmit(&both, vec3(1, 0.5, 1), vec3(4, 0.5, 1)), 1, "the door of wood");
    cr_expect_eq(panes_transmit(&both, vec3(-1, 1.5, 2.2), vec3(1, 1.5, 2.2)), 1, "above the window");
    glazed_free(g);
}

// A point of a portal, anywhere.
static Vec3 in_portal(const CellGraph *graph, const Portal *portal, Random *random) {
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    Vec3 sum = {0, 0, 0};
    double weight[64], all = 0;
    cr_assert(portal->vertex_count <= 64);
    for (int i = 0; i < portal->vertex_count; i++) all += weight[i] = random_unit(random) + 1e-3;
    for (int i = 0; i < portal->vertex_count; i++) sum = vec3_add(sum, vec3_scale(v[i], weight[i] / all));
    return sum;
}

// Proves that no light slips by a pane, nor passes two in one window: straight lines from a portal on one side of a window or glazed door,
// closed, to one on the other side cross one pane. In homes as people draw them, with round walls, arches and walls of several thicknesses.
Test(panes, every_line_through_a_window_passes_one) {
    static const char *const HOMES[] = {"build/maps/house.plan", "build/maps/flat.Home.xml",
                                        "build/maps/hillside.sh3d", "build/maps/villa.sh3d"};
    Random random = {3};
    for (int h = 0; h < 4; h++) {
        Glazed *g = glazed_read(HOMES[h]);
        const CellGraph *graph = &g->graph;
        const Building *b = &g->building;
        float *doors = ARENA_ARRAY(&g->arena, float, b->opening_count + 1);
        Panes panes = panes_of(graph, doors, &g->arena);
        int lines = 0, slipped = 0;
        for (int o = 0; o < b->opening_count; o++) {
            const Opening *opening = &b->openings[o];
            int side[2][64], count[2] = {0, 0};
            if (!opening->glazed) continue;
            for (int p = 0; p < graph->portal_count; p++) {
                const Portal *portal = &graph->portals[p];
                bool inside[2];
                for (int k = 0; k < 2; k++) inside[k] = vis_region(graph, portal->cell[k])->opening == o;
                if (inside[0] == inside[1] || portal->horizontal) continue;
                Vec2 middle = vec2_scale(vec2_add(portal->left, portal->right), 0.5);
                int at = orient2d(opening->line[0], opening->line[1], middle) > 0;
                if (count[at] < 64) side[at][count[at]++] = p;
            }
            for (int k = 0; k < 200 && count[0] > 0 && count[1] > 0; k++) {
                Vec3 from =
                         in_portal(graph, &graph->portals[side[0][random_index(&random, count[0])]], &random),
                     to =
                         in_portal(graph, &graph->portals[side[1][random_index(&random, count[1])]], &random);
                Vec2 across = vec2_sub(opening->line[1], opening->line[0]);
                Vec3 way = vec3_normalize(vec3_sub(to, from));
                double cosine = fabs(vec2_cross(across, vec2(way.x, way.y))) / vec2_length(across);
                lines++;
                slipped += fabs(panes_transmit(&panes, from, to) - glass_transmits(cosine)) > 1e-9;
            }
        }
        printf("%s: %d panes, %d of %d lines do not cross one\n", HOMES[h], panes.count, slipped, lines);
        cr_expect(lines > 200 && slipped == 0, "%s: %d of %d", HOMES[h], slipped, lines);
        glazed_free(g);
    }
}
