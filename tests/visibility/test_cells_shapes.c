// test_cells_shapes.c - cells above one another, and given ones.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "tests/support/prt_scene.h"
#include "tests/visibility/vis_fixture.h"

// Proves that rooms one above the other are joined by all that their plans have in common, be it a triangle: random triangles over
// random triangles, on many floors, of which some touch and some do not.
Test(cells, triangles_above_one_another) {
    for (uint64_t seed = 1; seed <= 20; seed++) {
        Random random = {seed};
        Arena arena = {0};
        Building *b = ARENA_ARRAY(&arena, Building, 1);
        CellGraph g;
        Error error;
        VisOptions options = vis_default_options();
        b->source = "triangles";
        building_add_material(&arena, b,
                              (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
        int level = 0;
        for (int k = 0; k < 40; k++) {
            Vec2 p[3];
            double x = 8 * (k % 2), turn = random_between(&random, 0, 2),
                   radius = random_between(&random, 0.8, 3.5);
            for (int i = 0; i < 3; i++) {
                double angle = turn + 2 * M_PI * i / 3;
                p[i] = vec2(maps_snap(x + radius * cos(angle)), maps_snap(radius * sin(angle)));
            }
            vis_check_add_region(&arena, b, p, 3, level, level + 2);
            if (k % 2) level += random_index(&random, 4) ? 2 : 3;
        }
        b->world = (Box){{-4, -4, 0}, {12, 4, level + 3}};
        cr_assert(vis_build_cells(b, &options, &arena, &g, &error), "%s", error.text);
        char name[32];
        snprintf(name, sizeof name, "seed %d", (int)seed);
        for (int c = 0; c < g.cell_count; c++) vis_check_expect_closed(&g, c, 0, name, 1e-9);
        vis_check_expect_placed(&g, name);
        // The portal of two cells that touch, one above the other, is where both plans are.
        for (int a = 0; a < g.cell_count; a++) {
            for (int c = 0; c < g.cell_count; c++) {
                bool above = g.cells[a].z0 == g.cells[c].z1;
                for (int i = 0; above && i < 20; i++) {
                    Vec3 at =
                        vec3(random_between(&random, -3, 11), random_between(&random, -3, 3), g.cells[a].z0);
                    if (!vis_check_is_in(&g, a, at) || !vis_check_is_in(&g, c, at)) continue;
                    bool joined = false;
                    for (int p = 0; p < g.portal_count; p++)
                        joined = joined || (g.portals[p].cell[0] == a && g.portals[p].cell[1] == c);
                    cr_assert(joined, "%s: cells %d and %d share (%g, %g)", name, a, c, at.x, at.y);
                }
            }
        }
        arena_free(&arena);
    }
}

// Proves that given cells are bounded by the corners and the planes of their portals and nothing else.
Test(cells, given_ones_have_the_box_of_their_portals) {
    Random random = {2};
    for (int k = 0; k < 20; k++) {
        Arena arena = {0};
        Row row = row_random(&random, 4 + k % 6);
        const CellGraph *g = row_graph(&arena, &row);
        for (int c = 0; c < g->cell_count; c++) {
            const Cell *cell = &g->cells[c];
            Box box = box_empty();
            for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
                const Portal *portal = &g->portals[g->ways[i].portal];
                for (int v = 0; v < portal->vertex_count; v++)
                    box = box_add(box, g->portal_vertices[portal->first_vertex + v]);
            }
            cr_assert(vec3_equal(cell->box.min, box.min) && vec3_equal(cell->box.max, box.max),
                      "row %d, cell %d", k, c);
            cr_assert(cell->z0 == box.min.z && cell->z1 == box.max.z && cell->edge_count == 4);
            const Vec2 *plan = g->plan + cell->first_edge, corner[4] = {{box.min.x, box.min.y},
                                                                        {box.max.x, box.min.y},
                                                                        {box.max.x, box.max.y},
                                                                        {box.min.x, box.max.y}};
            for (int i = 0; i < 4; i++) cr_assert(vec2_equal(plan[i], corner[i]), "row %d, cell %d", k, c);
            cr_assert_eq(cell->face_count, cell->way_count);
            for (int i = 0; i < cell->face_count; i++) {
                const Portal *portal = &g->portals[g->ways[cell->first_way + i].portal];
                Plane face = g->faces[cell->first_face + i];
                double side = portal->cell[0] == c ? 1 : -1;
                cr_assert(vec3_equal(face.n, vec3_scale(portal->plane.n, side)) &&
                          face.d == side * portal->plane.d);
            }
        }
        arena_free(&arena);
    }
}
