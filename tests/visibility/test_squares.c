// test_squares.c - the squares of cells list the objects that touch them.
#include <criterion/criterion.h>

#include "engine/core/file.h"
#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/vis_fixture.h"

// In the mesh of squares of a cell, do all squares no farther off in plan than this list the object?
static bool is_registered(const CellGraph *g, int c, Vec3 p, double off, int object) {
    const SquareGrid *grid = &g->grids[c];
    for (int s = 0; s < grid->nx * grid->ny; s++) {
        double x = grid->origin.x + s % grid->nx * grid->size, y = grid->origin.y + s / grid->nx * grid->size;
        if (p.x < x - off || p.x > x + grid->size + off || p.y < y - off || p.y > y + grid->size + off)
            continue;
        bool listed = false;
        int square = grid->first_square + s;
        for (int k = g->square_first[square]; k < g->square_first[square + 1]; k++)
            listed = listed || g->square_objects[k] == object;
        if (!listed) return false;
    }
    return true;
}

// A point of a convex polygon; every other one beside a border of the squares of some cell, if any crosses the polygon there.
static Vec3 point_of(const CellGraph *g, const Polygon *p, Random *random) {
    Vec3 end[2];
    for (int e = 0; e < 2; e++) {
        double weights = 0;
        end[e] = vec3(0, 0, 0);
        for (int k = 0; k < p->vertex_count; k++) {
            double w = pow(random_unit(random), 3) + 1e-9;
            end[e] = vec3_add(end[e], vec3_scale(g->vertices[p->first_vertex + k], w));
            weights += w;
        }
        end[e] = vec3_scale(end[e], 1 / weights);
    }
    const SquareGrid *grid = &g->grids[random_index(random, g->cell_count)];
    bool y = random_index(random, 2);
    double a = y ? end[0].y - grid->origin.y : end[0].x - grid->origin.x,
           b = y ? end[1].y - grid->origin.y : end[1].x - grid->origin.x;
    double at = nearbyint(a / grid->size) * grid->size + random_between(random, -0.9, 0.9) * VIS_TOUCH,
           t = (at - a) / (b - a);
    return t > 0 && t < 1 ? vec3_lerp(end[0], end[1], t) : end[0];
}

// Does some polygon of an object, as drawn, come near a box?
static bool comes_near(const CellGraph *g, const Object *object, Box box) {
    for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
        Box bounds = box_empty();
        for (int k = 0; k < g->polygons[p].vertex_count; k++)
            bounds = box_add(bounds, g->vertices[g->polygons[p].first_vertex + k]);
        if (box_overlap(bounds, box)) return true;
    }
    return false;
}

// Proves that objects are registered in every square of every cell in which a point of them lies, or lies no farther off than
// VIS_TOUCH, surfaces in those of their own cell; that no square lists what does not come near it; that the squares of the plan list
// the cells that reach into them and no others; and that a place is found in the one cell which holds it.
static void expect_registered(const CellGraph *g, Random *random, int points, const char *name) {
    int held = 0, owner = 0;
    for (int o = 0; o < g->object_count; o++) {
        const Object *object = &g->objects[o];
        while (owner < g->cell_count && o >= g->surface_first[owner + 1]) owner++;
        bool surface = o >= g->surface_first[0] && owner < g->cell_count;
        if (object->leaf >= 0 || object->polygon_count == 0) continue;
        for (int i = 0; i < points; i++) {
            const Polygon *p =
                &g->polygons[object->first_polygon + random_index(random, object->polygon_count)];
            bool aside = i % 4 == 0 && !surface;
            Vec3 at = point_of(g, p, random);
            if (aside) at = vec3_add(at, vec3_scale(fixture_direction(random), 0.5 * VIS_TOUCH));
            for (int c = surface ? owner : 0; c < (surface ? owner + 1 : g->cell_count); c++) {
                if (!vis_check_is_in(g, c, at)) continue;
                held++;
                cr_assert(is_registered(g, c, at, (aside ? 0.45 : 0.95) * VIS_TOUCH, o),
                          "%s: object %d at %g,%g,%g is not registered in cell %d", name, o, at.x, at.y, at.z,
                          c);
            }
        }
    }
    const SquareGrid *locator = &g->locator;
    for (int s = 0; s < locator->nx * locator->ny; s++) {
        Vec3 low = {locator->origin.x + s % locator->nx * locator->size,
                    locator->origin.y + s / locator->nx * locator->size, g->box.min.z};
        Box square = {low, {low.x + locator->size, low.y + locator->size, g->box.max.z}};
        for (int c = 0; c < g->cell_count; c++) {
            int listed = 0;
            for (int k = g->locator_first[s]; k < g->locator_first[s + 1]; k++)
                listed += g->locator_cells[k] == c;
            bool within = box_overlap(g->cells[c].box, box_grow(square, 0.99 * g->touch)),
                 near = box_overlap(g->cells[c].box, box_grow(square, 1.01 * g->touch));
            cr_assert(listed >= within && listed <= near, "%s: square %d lists cell %d %d times", name, s, c,
                      listed);
        }
    }
    cr_assert_gt(held, points);
    for (int c = 0; c < g->cell_count; c++) {
        const SquareGrid *grid = &g->grids[c];
        for (int s = 0; s < grid->nx * grid->ny; s++) {
            Vec3 low = {grid->origin.x + s % grid->nx * grid->size,
                        grid->origin.y + s / grid->nx * grid->size, g->cells[c].z0};
            Box box = {low, {low.x + grid->size, low.y + grid->size, g->cells[c].z1}};
            for (int k = g->square_first[grid->first_square + s];
                 k < g->square_first[grid->first_square + s + 1]; k++) {
                const Object *object = &g->objects[g->square_objects[k]];
                cr_assert(object->leaf >= 0 || comes_near(g, object, box_grow(box, 3 * VIS_TOUCH)),
                          "%s: cell %d, square %d", name, c, s);
            }
        }
    }
    for (int i = 0; i < 20 * points; i++) {
        Vec3 size = vec3_sub(g->box.max, g->box.min), at = g->box.min;
        at = vec3_add(at, vec3(size.x * random_unit(random), size.y * random_unit(random),
                               size.z * random_unit(random)));
        int hint = random_index(random, g->cell_count + 1) - 1, found = vis_locate(g, at, hint);
        for (int c = 0; c < g->cell_count; c++) {
            const Cell *cell = &g->cells[c];
            Vec3 middle = {0, 0, (cell->z0 + cell->z1) / 2};
            for (int k = 0; k < cell->edge_count; k++) {
                middle.x += g->plan[cell->first_edge + k].x / cell->edge_count;
                middle.y += g->plan[cell->first_edge + k].y / cell->edge_count;
            }
            // Well inside: a little farther from the middle too.
            Vec3 out = vec3_add(at, vec3_scale(vec3_sub(at, middle), 1e-3));
            if (vis_check_is_in(g, c, out))
                cr_assert_eq(found, c, "%s: (%g, %g, %g) is in %d", name, at.x, at.y, at.z, c);
            if (found == c)
                cr_assert(vis_check_is_in(g, c, at), "%s: (%g, %g, %g) is not in %d", name, at.x, at.y, at.z,
                          c);
        }
    }
}

// Proves that an object is in both squares of a cell although others, each in one of them, were registered before it: that it fills the
// cell is not known from their squares. The room is 4 m by 2 m, its squares 2 m.
Test(squares, each_object_is_counted_alone) {
    Arena arena = {0};
    Building b;
    CellGraph g;
    Error error;
    VisOptions options = vis_default_options();
    options.square = 2;
    const char *path = arena_format(&arena, "%s/room.plan", support_folder(&arena)),
               *text = "plan 1\nmaterial m #808080\nstorey s floor 0 height 2.6\n"
                       "room r 0,0 4,0 4,2 0,2 wall 0.1\n"
                       "model one\npoly m 0.5,0.5,1 1,0.5,1 1,1,1\nend\n"
                       "model two\npoly m 0.5,0.5,2 1,0.5,2 1,1,2\npoly m 3,0.5,2 3.5,0.5,2 3.5,1,2\nend\n"
                       "place one 0,0\nplace two 0,0\n";
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    int cell = vis_locate(&g, vec3(2, 1, 1), -1), listed = 0;
    cr_assert(cell >= 0 && b.object_count == 2);
    const SquareGrid *grid = &g.grids[cell];
    cr_assert(grid->nx == 2 && grid->ny == 1);
    for (int k = g.square_first[grid->first_square]; k < g.square_first[grid->first_square + 2]; k++)
        listed += g.square_objects[k] == 0 || g.square_objects[k] == 1;
    cr_expect_eq(listed, 3);
    cr_expect(is_registered(&g, cell, vec3(0.8, 0.6, 1), VIS_TOUCH / 2, 0));
    cr_expect(is_registered(&g, cell, vec3(0.8, 0.6, 2), VIS_TOUCH / 2, 1));
    cr_expect(is_registered(&g, cell, vec3(3.3, 0.6, 2), VIS_TOUCH / 2, 1));
    arena_free(&arena);
}

// Proves which widths squares may have.
Test(squares, are_of_widths_within_limits) {
    static const struct {
        double square;
        bool allowed;
    } CASES[] = {{0.25, true}, {100, true}, {0.2499, false}, {100.01, false}, {-1, false}, {NAN, false}};
    Arena arena = {0};
    Random random = {8};
    const Building *b = fixture_rooms(&arena, &random, 1, 1, 1);
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        CellGraph g;
        Error error = {""};
        VisOptions options = vis_default_options();
        options.square = CASES[i].square;
        cr_expect_eq(vis_build_cells(b, &options, &arena, &g, &error), CASES[i].allowed, "%g",
                     CASES[i].square);
        cr_expect_eq(strstr(error.text, "(allowed 0.25 to 100)") != NULL, !CASES[i].allowed, "%s",
                     error.text);
    }
    arena_free(&arena);
}

// Proves that what is registered stays so where more is to be registered, and that what is added is found.
Test(squares, take_more) {
    Made m;
    vis_check_make(&m, 4, 3, 2, 2, 1, 0);
    const CellGraph *g = &m.graph;
    CellGraph same, more;
    int *first = ARENA_ARRAY(&m.arena, int, g->object_count + 1);
    vis_register(g, NULL, NULL, first, &m.arena, &same);
    cr_assert_eq(same.square_object_count, g->square_object_count);
    // A triangle for each object, somewhere else.
    Random random = {6};
    Polygon *polygons = ARENA_ARRAY(&m.arena, Polygon, g->object_count);
    Vec3 *vertices = ARENA_ARRAY(&m.arena, Vec3, 3 * g->object_count);
    for (int o = 0; o < g->object_count; o++) {
        polygons[o] = (Polygon){.first_vertex = 3 * o, .vertex_count = 3};
        first[o + 1] = o + 1;
        Vec3 at = fixture_point(g, &random, random_index(&random, g->cell_count));
        for (int k = 0; k < 3; k++)
            vertices[3 * o + k] = vec3_add(at, vec3_scale(fixture_direction(&random), 0.3));
    }
    vis_register(g, polygons, vertices, first, &m.arena, &more);
    for (int s = 0; s < g->square_count; s++) {
        for (int k = g->square_first[s]; k < g->square_first[s + 1]; k++) {
            bool kept = false, again = false;
            for (int i = same.square_first[s]; i < same.square_first[s + 1]; i++)
                again = again || same.square_objects[i] == g->square_objects[k];
            for (int i = more.square_first[s]; i < more.square_first[s + 1]; i++)
                kept = kept || more.square_objects[i] == g->square_objects[k];
            cr_assert(kept && again, "square %d no longer lists object %d", s, g->square_objects[k]);
        }
        for (int i = more.square_first[s]; i + 1 < more.square_first[s + 1]; i++)
            for (int k = i + 1; k < more.square_first[s + 1]; k++)
                cr_assert_neq(more.square_objects[i], more.square_objects[k], "square %d lists one twice", s);
    }
    for (int o = 0; o < g->object_count; o++) {
        for (int i = 0; i < 5; i++) {
            double u = random_unit(&random), v = random_unit(&random) * (1 - u);
            const Vec3 *t = vertices + 3 * o;
            Vec3 p =
                vec3_add(vec3_scale(t[0], 1 - u - v), vec3_add(vec3_scale(t[1], u), vec3_scale(t[2], v)));
            for (int c = 0; c < g->cell_count; c++)
                if (vis_check_is_in(g, c, p))
                    cr_assert(is_registered(&more, c, p, VIS_TOUCH / 2, o), "object %d in cell %d", o, c);
        }
    }
    arena_free(&m.arena);
}

Test(squares, hold_what_touches_them) {
    Random random = {3};
    for (uint64_t seed = 1; seed <= 6; seed++) {
        Made m;
        vis_check_make(&m, seed, seed % 2 ? 4 : 2, 2, 2, 1, 0);
        fixture_place(m.building, seed % 3 ? 0 : 0.3 * (double)seed,
                      vec3(137.25 - 61 * (double)seed, 912.5, -3.5 * (double)seed));
        CellGraph g;
        VisOptions options = vis_default_options();
        options.square = 0.25 + 0.5 * (double)seed;
        Error error;
        cr_assert(vis_build_cells(m.building, &options, &m.arena, &g, &error), "%s", error.text);
        expect_registered(&g, &random, 40, "rooms");
        arena_free(&m.arena);
    }
    Arena arena = {0};
    Building b;
    CellGraph g;
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read("build/maps/house.plan", &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    expect_registered(&g, &random, 10, "house");
    arena_free(&arena);
}
