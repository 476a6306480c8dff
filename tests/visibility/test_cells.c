// test_cells.c - cells are convex and closed, and have no T-vertices.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/file.h"
#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "tests/support/support.h"
#include "tests/visibility/vis_fixture.h"

// Could two cells be one, with the cut between them left out? Convex at both ends of the cut, then, by the sign alone.
static bool could_be_one(const CellGraph *g, const Cell *a, const Cell *b) {
    const Vec2 *p = g->plan + a->first_edge, *q = g->plan + b->first_edge;
    int n = a->edge_count, m = b->edge_count;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < m; k++) {
            if (!vec2_equal(p[i], q[(k + 1) % m]) || !vec2_equal(p[(i + 1) % n], q[k])) continue;
            return orient2d(p[(i + n - 1) % n], p[i], q[(k + 2) % m]) >= 0 &&
                   orient2d(q[(k + m - 1) % m], q[k], p[(i + 2) % n]) >= 0;
        }
    }
    return false;
}

// The cells of a region fill it, from its floor to its ceiling, and none is cut in two for nothing (Hertel & Mehlhorn). Tolerance of
// areas: rounding.
static void expect_filled(const CellGraph *g, const char *name) {
    const Building *b = g->building;
    for (int r = 0; r < b->region_count; r++) {
        double area = 0, whole = 0;
        for (int i = 0; i < b->regions[r].ring_count; i++) {
            const Ring *ring = &b->rings[b->regions[r].first_ring + i];
            const Vec2 *p = b->points + ring->first_point;
            double turned = 0;
            for (int k = 1; k + 1 < ring->point_count; k++)
                turned += vec2_cross(vec2_sub(p[k], p[0]), vec2_sub(p[k + 1], p[0])) / 2;
            whole += i == 0 ? fabs(turned) : -fabs(turned);
        }
        for (int c = 0; c < g->cell_count; c++) {
            const Cell *cell = &g->cells[c];
            if (cell->region != r) continue;
            cr_assert(cell->z0 == b->regions[r].z0 && cell->z1 == b->regions[r].z1);
            const Vec2 *p = g->plan + cell->first_edge;
            for (int i = 1; i + 1 < cell->edge_count; i++)
                area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
            for (int d = 0; d < c; d++) {
                const Cell *other = &g->cells[d];
                if (other->region != r || cell->edge_count + other->edge_count > 64) continue;
                cr_assert_not(could_be_one(g, cell, other), "%s: cells %d and %d of region %d could be one",
                              name, d, c, r);
            }
        }
        cr_assert_float_eq(area, whole, 1e-9 * (1 + whole), "%s: region %d: %.9f of %.9f m2", name, r, area,
                           whole);
    }
}

// Proves the structure of made-up buildings, every third at a slant. Tolerance: rounding only, areas of a few square metres; at a slant,
// where corners are put on the grid, levels that meet leave slivers of VIS_SLIVER out.
Test(cells, are_closed) {
    for (uint64_t seed = 1; seed <= 30; seed++) {
        Made m;
        char name[32];
        vis_check_make(&m, seed, 3, 3, 2, 1, 0);
        if (seed % 3 == 0) vis_check_turn_away(&m, seed);
        snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
        for (int c = 0; c < m.graph.cell_count; c++)
            vis_check_expect_closed(&m.graph, c, 0, name, seed % 3 ? 1e-9 : 4 * VIS_SLIVER);
        expect_filled(&m.graph, name);
        vis_check_expect_placed(&m.graph, name);
        arena_free(&m.arena);
    }
}

// The area of a cell's boundary that nothing need cover, m^2: the sky, and the world's border.
static double open_of(const CellGraph *g, int c) {
    const Building *b = g->building;
    const Cell *cell = &g->cells[c];
    const Region *region = &b->regions[cell->region];
    const Vec2 *p = g->plan + cell->first_edge;
    double open = 0;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 from = p[i], to = p[(i + 1) % cell->edge_count];
        bool across = from.x == to.x && (to.x == b->world.min.x || to.x == b->world.max.x),
             along = from.y == to.y && (to.y == b->world.min.y || to.y == b->world.max.y);
        if (region->kind == REGION_OUTDOORS && (across || along))
            open += vec2_length(vec2_sub(to, from)) * (cell->z1 - cell->z0);
        double area = vec2_cross(vec2_sub(from, p[0]), vec2_sub(to, p[0])) / 2;
        open += ((region->floor_material < 0) + (region->ceiling_material < 0)) * area;
    }
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &g->portals[g->ways[i].portal];
        bool above = portal->cell[1] == c;
        if (!portal->horizontal || (above ? region->ceiling_material : region->floor_material) >= 0) continue;
        open -= polygon_area(g->portal_vertices + portal->first_vertex, portal->vertex_count);
    }
    return open;
}

// Tolerance: slivers of at most VIS_SLIVER are left out, some hundred at most.
static void expect_building_closed(const char *path) {
    Arena arena = {0};
    Building b;
    CellGraph g;
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    for (int c = 0; c < g.cell_count; c++) vis_check_expect_closed(&g, c, open_of(&g, c), path, 1e-6);
    expect_filled(&g, path);
    vis_check_expect_placed(&g, path);
    arena_free(&arena);
}

// Proves it of the samples and of real homes, with their stairwells, inlays and slanting walls.
Test(cells, of_samples_are_closed) {
    expect_building_closed("build/maps/two-rooms.plan");
    expect_building_closed("build/maps/house.plan");
    expect_building_closed("build/maps/house.sh3d");
    expect_building_closed("build/maps/office.plan");
    expect_building_closed("build/maps/office-plain.plan");
}

Test(cells, of_homes_are_closed) {
    static const char *const HOMES[] = {"sh3d/2BedroomHouseWithBasement.Home.xml",
                                        "sh3d/3BedroomApartment.Home.xml", "sh3d/4-BedroomHouse.sh3d",
                                        "sh3d/edoardo90_myHomeHas2Stairs.Home.xml"};
    expect_building_closed("build/maps/flat.Home.xml");
    expect_building_closed("build/maps/hillside.sh3d");
    expect_building_closed("build/maps/villa.sh3d");
    for (int i = 0; i < 4; i++)
        if (support_has_shared(HOMES[i])) expect_building_closed(support_shared(HOMES[i]));
}

static void expect_no_t_vertices(const CellGraph *g, const char *name) {
    int first = g->polygons[g->objects[g->surface_first[0]].first_polygon].first_vertex;
    for (int i = g->surface_first[0]; i < g->object_count; i++) {
        const Polygon *p = &g->polygons[g->objects[i].first_polygon];
        for (int k = 0; k < p->vertex_count; k++) {
            Vec3 a = g->vertices[p->first_vertex + k],
                 b = g->vertices[p->first_vertex + (k + 1) % p->vertex_count];
            Vec3 along = vec3_sub(b, a);
            for (int v = first; v < g->vertex_count; v++) {
                Vec3 q = vec3_sub(g->vertices[v], a);
                double t = vec3_dot(q, along) / vec3_dot(along, along);
                if (t < 1e-6 || t > 1 - 1e-6) continue;
                cr_assert_gt(vec3_length(vec3_sub(q, vec3_scale(along, t))), 1e-8,
                             "%s: (%g, %g, %g) lies on an edge of surface %d", name, g->vertices[v].x,
                             g->vertices[v].y, g->vertices[v].z, i);
            }
        }
    }
}

// Proves that no vertex of a surface lies inside an edge of another: nothing shows through the seams, be they along the axes or at a
// slant.
Test(cells, have_no_t_vertices) {
    for (uint64_t seed = 5; seed <= 9; seed++) {
        Made m;
        vis_check_make(&m, seed, 3, 2, 2, 1, 0);
        if (seed > 5) vis_check_turn_away(&m, seed);
        expect_no_t_vertices(&m.graph, seed > 5 ? "turned" : "straight");
        arena_free(&m.arena);
    }
}

// Proves that inlays are laid into floors and ceilings whole, across the cells of a room that bends: of three corners and of six, and
// that what is left of floor and ceiling makes up the rest.
Test(cells, inlays_keep_their_area) {
    static const char PLAN[] =
        "plan 1\nmaterial white #E8E8E8\nmaterial red #E02020\nmaterial blue #2020E0\nstorey s floor 1 "
        "height 2.5\n"
        "room a 0,0 6,0 6,3 3,3 3,6 0,6 floor white ceiling white walls white wall 0.2\n"
        "inlay red floor 0.5,0.5 5.5,1.5 1.5,5.5\n"
        "inlay blue ceiling 1,0.5 4,0.5 5,1.5 4,2.5 1,2.5 0.5,1.5\n";
    Arena arena = {0};
    Building b;
    CellGraph g;
    Error error;
    VisOptions options = vis_default_options();
    char *path = arena_format(&arena, "%s/inlays.plan", support_folder(&arena));
    cr_assert(file_write(path, PLAN, sizeof PLAN - 1, &error), "%s", error.text);
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    // By material and height: floor, ceiling.
    double area[3][2] = {{0}};
    for (int i = g.surface_first[0]; i < g.object_count; i++) {
        const Polygon *p = &g.polygons[g.objects[i].first_polygon];
        const Vec3 *v = g.vertices + p->first_vertex;
        double up = plane_of_polygon(v, p->vertex_count).n.z;
        if (fabs(up) < 0.5) continue;
        cr_expect(v[0].z == (up > 0 ? 1 : 3.5), "a surface at %g", v[0].z);
        const char *name = b.materials[p->material].name;
        int m = strcmp(name, "white") == 0 ? 0 : strcmp(name, "red") == 0 ? 1 : 2;
        area[m][up < 0] += polygon_area(v, p->vertex_count);
    }
    // The red triangle sticks out of the room where it bends: what is beyond is not laid.
    double red = area[1][0], blue = 3 * 2 + 2 * 1 * 0.5 + 2 * 0.5 * 0.5 * 1;
    cr_expect_float_eq(area[2][1], blue, 1e-9, "%g m^2 of blue", area[2][1]);
    cr_expect(red > 7 && area[1][1] == 0 && area[2][0] == 0, "%g m^2 of red", red);
    cr_expect_float_eq(area[0][0] + red, 27, 1e-9);
    cr_expect_float_eq(area[0][1] + blue, 27, 1e-9);
    arena_free(&arena);
}

// The material of the surface in the middle of a ring's edge at height z, -1: none stands there.
static int surface_at(const CellGraph *g, Vec2 a, Vec2 b, double z) {
    Vec3 at = vec3((a.x + b.x) / 2, (a.y + b.y) / 2, z);
    for (int i = 0; i < g->polygon_count; i++) {
        const Polygon *p = &g->polygons[i];
        const Vec3 *v = g->vertices + p->first_vertex;
        Plane plane = plane_of_polygon(v, p->vertex_count);
        bool inside = fabs(plane.n.z) < 0.5 && fabs(vec3_dot(plane.n, at) - plane.d) < 1e-6;
        for (int k = 0; inside && k < p->vertex_count; k++) {
            Vec3 edge = vec3_sub(v[(k + 1) % p->vertex_count], v[k]);
            inside = vec3_dot(vec3_cross(plane.n, edge), vec3_sub(at, v[k])) > 0;
        }
        if (inside) return p->material;
    }
    return -1;
}

// Proves that an outer wall has the look of each storey at its own heights: 1 mm below and above each band's beginning.
Test(cells, walls_look_as_their_storeys) {
    Arena arena = {0};
    Building b = {0};
    Error error;
    CellGraph g;
    VisOptions options = vis_default_options();
    cr_assert(maps_read("maps/buildings/attic.sh3d", &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    int seen = 0;
    for (int i = 0; i < b.band_count; i++) {
        const EdgeBand *band = &b.bands[i];
        int ring = 0;
        while (band->edge >= b.rings[ring].first_point + b.rings[ring].point_count) ring++;
        int first = b.rings[ring].first_point,
            next = first + (band->edge - first + 1) % b.rings[ring].point_count;
        Vec2 from = b.points[band->edge], to = b.points[next];
        int below = surface_at(&g, from, to, band->from - 0.001),
            above = surface_at(&g, from, to, band->from + 0.001);
        cr_expect(above < 0 || above == band->material, "band %d: material %d", i, above);
        cr_expect(below < 0 || below == b.edge_material[band->edge], "band %d: material %d below", i, below);
        seen += below >= 0 && above >= 0 && below != above;
    }
    cr_expect_geq(seen, 4, "%d bands", seen);
    arena_free(&arena);
}

// A room with so many openings along one side that its cell is cut. Proves that no part is flat: a flat cell hides what lies beyond it.
Test(cells, of_a_long_corridor_have_an_area) {
    enum { DOORS = 90 };
    Arena arena = {0};
    Building b;
    CellGraph graph;
    Error error;
    VisOptions options = vis_default_options();
    const char *path = arena_format(&arena, "%s/corridor.plan", support_folder(&arena));
    FILE *file = fopen(path, "w");
    cr_assert(file);
    fprintf(file,
            "plan 1\nmaterial m #808080\nstorey s floor 0 height 2.6\nroom c 0,0 %d,0 %d,2 0,2 wall 0.1\n",
            2 * DOORS, 2 * DOORS);
    fprintf(file, "room d 0,2.1 %d,2.1 %d,5 0,5 wall 0.1\n", 2 * DOORS, 2 * DOORS);
    for (int i = 0; i < DOORS; i++) fprintf(file, "passage p%d %d,2.05 width 1 height 2\n", i, 2 * i + 1);
    cr_assert_eq(fclose(file), 0);
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &graph, &error), "%s", error.text);
    double sum = 0;
    for (int c = 0; c < graph.cell_count; c++) {
        double twice = 0;
        const Cell *cell = &graph.cells[c];
        for (int i = 0; i < cell->edge_count; i++)
            twice += vec2_cross(graph.plan[cell->first_edge + i],
                                graph.plan[cell->first_edge + (i + 1) % cell->edge_count]);
        cr_expect_gt(twice / 2, 1e-3, "cell %d has %g m^2", c, twice / 2);
        sum += twice / 2;
    }
    // Tolerance: rounding of a sum of hundreds of square metres.
    cr_expect_float_eq(sum, 2 * DOORS * (2 + 2.9) + DOORS * 0.1, 1e-6, "%g m^2", sum);
    arena_free(&arena);
}
