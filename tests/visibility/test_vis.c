// test_vis.c - cells, portals, stab trees and queries against straight lines traced through them.
#include <criterion/criterion.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "visibility/sightline.h"

typedef struct Made {
    Arena arena;
    Building *building;
    CellGraph graph;
    StabForest forest;
} Made;

static void make(Made *m, uint64_t seed, int nx, int ny, int storeys, int threads, int max_nodes) {
    Random random = {seed};
    *m = (Made){0};
    m->building = fixture_rooms(&m->arena, &random, nx, ny, storeys);
    VisOptions options = vis_default_options();
    options.threads = threads;
    if (max_nodes) options.max_nodes = max_nodes;
    Error error;
    cr_assert(vis_build_cells(m->building, &options, &m->arena, &m->graph, &error), "seed %llu: %s",
              (unsigned long long)seed, error.text);
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest));
}

// Two sets are separated by a line iff they are by one through two of their points.
static bool separable(const Vec2 *left, const Vec2 *right, int count) {
    Vec2 all[64];
    for (int i = 0; i < count; i++) {
        all[2 * i] = left[i];
        all[2 * i + 1] = right[i];
    }
    for (int i = 0; i < 2 * count; i++) {
        for (int j = 0; j < 2 * count; j++) {
            if (vec2_equal(all[i], all[j])) continue;
            bool good = true;
            for (int k = 0; k < count && good; k++) {
                good = orient2d(all[i], all[j], left[k]) >= 0 && orient2d(all[i], all[j], right[k]) <= 0;
            }
            if (good) return true;
        }
    }
    return false;
}

// Proves that the incremental sightline agrees with brute force on chains of portals of convex cells, degenerate
// ones (small integer coordinates: shared ends, collinear ends) among them.
Test(sightline, agrees_with_brute_force) {
    int found = 0, lost = 0;
    for (uint64_t seed = 1; seed <= 20000; seed++) {
        Random random = {seed};
        Vec2 left[16], right[16], l[16], r[16];
        Sightline line = {.left = l, .right = r, .capacity = 16};
        int grid = seed % 2 ? 8 : 1000, count = 0;
        for (int tries = 0; tries < 400 && count < 10; tries++) {
            Vec2 a = vec2(random_index(&random, grid), random_index(&random, grid) + count * grid / 4);
            Vec2 b = vec2(random_index(&random, grid), random_index(&random, grid) + count * grid / 4);
            if (vec2_equal(a, b)) continue;
            if (count > 0) {
                Vec2 pl = left[count - 1], pr = right[count - 1];
                // Beyond the last portal, and the last one before this: a convex cell lies between.
                if (orient2d(pr, pl, a) > 0 || orient2d(pr, pl, b) > 0) continue;
                if (orient2d(b, a, pl) < 0 || orient2d(b, a, pr) < 0) continue;
                if (orient2d(pr, pl, a) == 0 && orient2d(pr, pl, b) == 0) continue;
            }
            left[count] = a;
            right[count] = b;
            SightlineUndo undo;
            bool expected = separable(left, right, count + 1);
            bool got = sightline_push(&line, a, b, &undo);
            cr_assert_eq(got, expected, "seed %llu, portal %d", (unsigned long long)seed, count);
            if (!got) {
                lost++;
                continue;
            }
            found++;
            if (random_unit(&random) < 0.3) {  // undo must restore
                sightline_pop(&line, &undo);
                continue;
            }
            count++;
        }
    }
    cr_assert(found > 10000 && lost > 10000, "the chains are too easy: %d crossed, %d not", found, lost);
}

// Is there a line of this direction that passes inside all segments, not merely through their ends?
static bool crossed_along(double angle, const Vec2 *left, const Vec2 *right, int count) {
    Vec2 to_left = vec2(-sin(angle), cos(angle));
    double lowest = INFINITY, highest = -INFINITY;
    for (int i = 0; i < count; i++) {
        lowest = fmin(lowest, vec2_dot(to_left, left[i]));
        highest = fmax(highest, vec2_dot(to_left, right[i]));
    }
    return lowest > highest;
}

// Is there one of any direction? The directions of such lines end where a line touches two ends: next to these it is
// looked for.
static bool crossed_inside(const Vec2 *left, const Vec2 *right, int count) {
    static const double BESIDE = 1e-7;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) {
            Vec2 d = vec2_sub(left[i], right[j]);
            double angle = atan2(d.y, d.x);
            for (int k = 0; k < 4; k++) {
                if (crossed_along(angle + (k % 2 ? BESIDE : -BESIDE) + (k / 2 ? M_PI : 0), left, right,
                                  count))
                    return true;
            }
        }
    }
    return false;
}

// The same of segments that lie anyhow, as where floors are crossed between: what a line crosses is never lost, and
// in general position nothing else is kept.
Test(sightline, holds_for_any_segments) {
    int found = 0, lost = 0;
    for (uint64_t seed = 1; seed <= 20000; seed++) {
        Random random = {seed};
        Vec2 left[16], right[16], l[16], r[16];
        Sightline line = {.left = l, .right = r, .capacity = 16};
        int grid = seed % 2 ? 8 : 1000000, count = 0;
        for (int tries = 0; tries < 40 && count < 10; tries++) {
            // Mostly along some direction, so that lines are found; a tenth anyhow.
            int shift = random_index(&random, 10) ? grid / 3 : 0;
            Vec2 a = vec2(random_index(&random, grid), random_index(&random, grid) + shift);
            Vec2 b = vec2(random_index(&random, grid), random_index(&random, grid) - shift);
            if (vec2_equal(a, b)) continue;
            left[count] = a;
            right[count] = b;
            SightlineUndo undo;
            bool got = sightline_push(&line, a, b, &undo);
            cr_assert(got || !crossed_inside(left, right, count + 1), "seed %llu, portal %d",
                      (unsigned long long)seed, count);
            cr_assert(!got || grid == 8 || separable(left, right, count + 1), "seed %llu, portal %d",
                      (unsigned long long)seed, count);
            found += got;
            lost += !got;
            count += got;
            if (got && random_unit(&random) < 0.3) {
                sightline_pop(&line, &undo);
                count--;
            }
        }
    }
    cr_assert(found > 10000 && lost > 10000, "the segments are too easy: %d crossed, %d not", found, lost);
}

// Cells convex, each way on both its cells; portals and surfaces together have the area of the cell's boundary.
// In the cell, or no more than a micrometre beyond.
static bool is_in(const CellGraph *g, int c, Vec3 p) {
    const Cell *cell = &g->cells[c];
    if (p.z < cell->z0 - 1e-6 || p.z > cell->z1 + 1e-6) return false;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = g->plan[cell->first_edge + i], b = g->plan[cell->first_edge + (i + 1) % cell->edge_count];
        Vec2 edge = vec2_sub(b, a);
        if (vec2_cross(edge, vec2_sub(vec2(p.x, p.y), a)) < -1e-6 * vec2_length(edge)) return false;
    }
    return true;
}

static Vec3 middle_of(const Vec3 *v, int count) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < count; i++) sum = vec3_add(sum, vec3_scale(v[i], 1.0 / count));
    return sum;
}

// Portals lie between their cells, surfaces face into theirs.
static void expect_placed(const CellGraph *g, const char *name) {
    for (int p = 0; p < g->portal_count; p++) {
        const Portal *portal = &g->portals[p];
        const Vec3 *v = g->portal_vertices + portal->first_vertex;
        Vec3 middle = middle_of(v, portal->vertex_count), off = vec3_scale(portal->plane.n, 1e-4);
        cr_assert(is_in(g, portal->cell[0], vec3_add(middle, off)), "%s: portal %d", name, p);
        cr_assert(is_in(g, portal->cell[1], vec3_sub(middle, off)), "%s: portal %d", name, p);
        cr_assert_gt(vec3_dot(plane_of_polygon(v, portal->vertex_count).n, portal->plane.n), 0.99);
        cr_assert_eq(portal->horizontal, fabs(portal->plane.n.z) > 0.5);
    }
    for (int c = 0; c < g->cell_count; c++) {
        for (int i = g->surface_first[c]; i < g->surface_first[c + 1]; i++) {
            const Polygon *p = &g->polygons[g->objects[i].first_polygon];
            const Vec3 *v = g->vertices + p->first_vertex;
            Vec3 n = plane_of_polygon(v, p->vertex_count).n, middle = middle_of(v, p->vertex_count);
            cr_assert(is_in(g, c, middle), "%s: surface %d of cell %d", name, i, c);
            cr_assert(is_in(g, c, vec3_add(middle, vec3_scale(n, 1e-4))), "%s: surface %d of cell %d", name,
                      i, c);
        }
    }
}

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

static void expect_closed(const CellGraph *g, int c, double expected, const char *name, double tolerance) {
    const Cell *cell = &g->cells[c];
    for (int i = 0; i < cell->edge_count; i++) {
        const Vec2 *p = g->plan + cell->first_edge;
        Vec2 next = p[(i + 2) % cell->edge_count];
        cr_assert_geq(orient2d(p[i], p[(i + 1) % cell->edge_count], next), 0, "%s: cell %d is not convex",
                      name, c);
    }
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &g->portals[g->ways[i].portal];
        cr_assert(portal->cell[0] == c || portal->cell[1] == c);
    }
    double open = fixture_uncovered(g, c);
    cr_assert_float_eq(open, expected, tolerance, "%s: cell %d: %.9f m2 are not covered, not %.9f", name, c,
                       open, expected);
}

// The same building turned and far away, its cells anew.
static void turn_away(Made *m, uint64_t seed) {
    VisOptions options = vis_default_options();
    Error error;
    fixture_place(m->building, 0.4 * (double)seed, vec3(300.5 - 70 * (double)seed, 411.25, 12));
    cr_assert(vis_build_cells(m->building, &options, &m->arena, &m->graph, &error), "seed %llu: %s",
              (unsigned long long)seed, error.text);
}

// Proves the structure of made-up buildings, every third at a slant. Tolerance: rounding only, areas of a few square metres; at a slant,
// where corners are put on the grid, levels that meet leave slivers of VIS_SLIVER out.
Test(cells, are_closed) {
    for (uint64_t seed = 1; seed <= 30; seed++) {
        Made m;
        char name[32];
        make(&m, seed, 3, 3, 2, 1, 0);
        if (seed % 3 == 0) turn_away(&m, seed);
        snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
        for (int c = 0; c < m.graph.cell_count; c++)
            expect_closed(&m.graph, c, 0, name, seed % 3 ? 1e-9 : 4 * VIS_SLIVER);
        expect_filled(&m.graph, name);
        expect_placed(&m.graph, name);
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
    for (int c = 0; c < g.cell_count; c++) expect_closed(&g, c, open_of(&g, c), path, 1e-6);
    expect_filled(&g, path);
    expect_placed(&g, path);
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
        make(&m, seed, 3, 2, 2, 1, 0);
        if (seed > 5) turn_away(&m, seed);
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

static void add_region(Arena *arena, Building *b, const Vec2 *points, int count, double z0, double z1) {
    *ARENA_PUSH(arena, b->regions, b->region_count, b->region_capacity) =
        (Region){.name = "",
                 .storey = -1,
                 .opening = -1,
                 .first_ring = b->ring_count,
                 .ring_count = 1,
                 .z0 = z0,
                 .z1 = z1};
    *ARENA_PUSH(arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, count};
    for (int i = 0; i < count; i++) {
        int at = b->point_count;
        *ARENA_PUSH(arena, b->edge_material, at, b->edge_capacity) = 0;
        *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = points[i];
    }
}

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
            add_region(&arena, b, p, 3, level, level + 2);
            if (k % 2) level += random_index(&random, 4) ? 2 : 3;
        }
        b->world = (Box){{-4, -4, 0}, {12, 4, level + 3}};
        cr_assert(vis_build_cells(b, &options, &arena, &g, &error), "%s", error.text);
        char name[32];
        snprintf(name, sizeof name, "seed %d", (int)seed);
        for (int c = 0; c < g.cell_count; c++) expect_closed(&g, c, 0, name, 1e-9);
        expect_placed(&g, name);
        // The portal of two cells that touch, one above the other, is where both plans are.
        for (int a = 0; a < g.cell_count; a++) {
            for (int c = 0; c < g.cell_count; c++) {
                bool above = g.cells[a].z0 == g.cells[c].z1;
                for (int i = 0; above && i < 20; i++) {
                    Vec3 at =
                        vec3(random_between(&random, -3, 11), random_between(&random, -3, 3), g.cells[a].z0);
                    if (!is_in(&g, a, at) || !is_in(&g, c, at)) continue;
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

// In the mesh of squares of a cell, do all squares no farther off in plan than this list the object?
static bool is_registered(const CellGraph *g, int c, Vec3 p, double off, int object) {
    const CellMesh *mesh = &g->meshes[c];
    for (int s = 0; s < mesh->nx * mesh->ny; s++) {
        double x = mesh->origin.x + s % mesh->nx * mesh->size, y = mesh->origin.y + s / mesh->nx * mesh->size;
        if (p.x < x - off || p.x > x + mesh->size + off || p.y < y - off || p.y > y + mesh->size + off)
            continue;
        bool listed = false;
        int square = mesh->first_square + s;
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
    const CellMesh *mesh = &g->meshes[random_index(random, g->cell_count)];
    bool y = random_index(random, 2);
    double a = y ? end[0].y - mesh->origin.y : end[0].x - mesh->origin.x,
           b = y ? end[1].y - mesh->origin.y : end[1].x - mesh->origin.x;
    double at = nearbyint(a / mesh->size) * mesh->size + random_between(random, -0.9, 0.9) * VIS_TOUCH,
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
                if (!is_in(g, c, at)) continue;
                held++;
                cr_assert(is_registered(g, c, at, (aside ? 0.45 : 0.95) * VIS_TOUCH, o),
                          "%s: object %d at %g,%g,%g is not registered in cell %d", name, o, at.x, at.y, at.z,
                          c);
            }
        }
    }
    const CellMesh *locator = &g->locator;
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
        const CellMesh *mesh = &g->meshes[c];
        for (int s = 0; s < mesh->nx * mesh->ny; s++) {
            Vec3 low = {mesh->origin.x + s % mesh->nx * mesh->size,
                        mesh->origin.y + s / mesh->nx * mesh->size, g->cells[c].z0};
            Box box = {low, {low.x + mesh->size, low.y + mesh->size, g->cells[c].z1}};
            for (int k = g->square_first[mesh->first_square + s];
                 k < g->square_first[mesh->first_square + s + 1]; k++) {
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
            if (is_in(g, c, out))
                cr_assert_eq(found, c, "%s: (%g, %g, %g) is in %d", name, at.x, at.y, at.z, c);
            if (found == c)
                cr_assert(is_in(g, c, at), "%s: (%g, %g, %g) is not in %d", name, at.x, at.y, at.z, c);
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
    const CellMesh *mesh = &g.meshes[cell];
    cr_assert(mesh->nx == 2 && mesh->ny == 1);
    for (int k = g.square_first[mesh->first_square]; k < g.square_first[mesh->first_square + 2]; k++)
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
    make(&m, 4, 3, 2, 2, 1, 0);
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
                if (is_in(g, c, p))
                    cr_assert(is_registered(&more, c, p, VIS_TOUCH / 2, o), "object %d in cell %d", o, c);
        }
    }
    arena_free(&m.arena);
}

Test(squares, hold_what_touches_them) {
    Random random = {3};
    for (uint64_t seed = 1; seed <= 6; seed++) {
        Made m;
        make(&m, seed, seed % 2 ? 4 : 2, 2, 2, 1, 0);
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

// Proves that stab trees are conservative: whatever way a straight line takes through portals is a path of the tree,
// and the visible sets hold its cells; the sets are symmetric; bounded trees keep the visible sets whole.
Test(forest, holds_every_sightline) {
    for (uint64_t seed = 1; seed <= 40; seed++) {
        Made m;
        bool bounded = seed % 4 == 0;
        make(&m, seed, 4, 4, seed % 3 ? 1 : 2, 1, bounded ? 3 : 0);
        Random random = {seed * 77};
        for (int i = 0; i < 5000; i++) {
            int cell = random_index(&random, m.graph.cell_count);
            Trace trace;
            Vec3 direction = fixture_direction(&random);
            direction.z *= 0.2;  // mostly level: those lines go far
            if (!fixture_trace(&m.graph, cell, fixture_point(&m.graph, &random, cell), direction, NULL,
                               &trace))
                continue;
            for (int k = 0; k < trace.count; k++) {
                cr_assert(vis_sees(&m.forest, cell, trace.cells[k]), "seed %llu: cell %d sees %d",
                          (unsigned long long)seed, cell, trace.cells[k]);
            }
            if (!m.forest.bounded[cell])
                cr_assert(fixture_in_tree(&m.forest, &trace), "seed %llu", (unsigned long long)seed);
        }
        for (int a = 0; a < m.graph.cell_count; a++) {
            for (int b = 0; b < a; b++) cr_assert_eq(vis_sees(&m.forest, a, b), vis_sees(&m.forest, b, a));
        }
        arena_free(&m.arena);
    }
}

// ---- trees against all sequences there are

// A sequence of upright portals, as it is searched: what the plan shows of them, millimetres.
typedef struct Sequence {
    const CellGraph *graph;
    const StabForest *forest;
    Vec2 left[32], right[32];
    int cells[33];
    int count;
    long inside, outside;
} Sequence;

// The child of a node through a portal, or -1.
static int child_through(const StabForest *f, int node, int end, int portal) {
    int child = node + 1 < end && f->nodes[node + 1].parent == node ? node + 1 : -1;
    while (child >= 0 && f->nodes[child].portal != portal) child = f->nodes[child].next;
    return child;
}

// Goes on from a node through each portal: what a line crosses with room to spare is a child, what none crosses is not.
static void expect_children(Sequence *q, int node, uint64_t seed) {
    const CellGraph *g = q->graph;
    int root = q->cells[0], cell = q->cells[q->count], end = q->forest->root[root + 1];
    cr_assert_eq(q->forest->nodes[node].cell, cell);
    if (q->count == 31) return;
    for (int i = g->cells[cell].first_way; i < g->cells[cell].first_way + g->cells[cell].way_count; i++) {
        Way way = g->ways[i];
        const Portal *portal = &g->portals[way.portal];
        bool back = portal->cell[1] == cell, again = false;
        Vec2 ends[2] = {portal->left, portal->right};
        for (int k = 0; k < 2; k++) ends[k] = vec2(nearbyint(ends[k].x * 1000), nearbyint(ends[k].y * 1000));
        q->left[q->count] = ends[back];
        q->right[q->count] = ends[!back];
        for (int k = 0; k <= q->count; k++) again = again || q->cells[k] == way.cell;
        int child = child_through(q->forest, node, end, way.portal);
        bool crossed = !again && crossed_inside(q->left, q->right, q->count + 1),
             touched = !again && separable(q->left, q->right, q->count + 1);
        q->inside += crossed;
        q->outside += !touched;
        cr_assert(!crossed || child >= 0, "seed %llu: the tree of %d lacks a way of %d portals to %d",
                  (unsigned long long)seed, root, q->count + 1, way.cell);
        cr_assert(touched || child < 0,
                  "seed %llu: the tree of %d has a way of %d portals to %d that no line takes",
                  (unsigned long long)seed, root, q->count + 1, way.cell);
        if (child < 0) continue;
        q->cells[++q->count] = way.cell;
        expect_children(q, child, seed);
        q->count--;
    }
}

// Proves that trees hold the sequences of portals that some line crosses, all of them, and none that no line crosses: by trying all. On
// one storey, where all portals share a height, the plan decides. Each tree is in the order that it is stored in.
Test(forest, holds_the_sequences_that_lines_cross) {
    long inside = 0, outside = 0;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Made m;
        make(&m, seed, 3, 2 + seed % 2, 1, 1, 0);
        if (seed % 3 == 0) turn_away(&m, seed);
        VisOptions options = vis_default_options();
        cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &m.forest));
        for (int c = 0; c < m.graph.cell_count; c++) {
            Sequence q = {.graph = &m.graph, .forest = &m.forest, .cells = {c}};
            int first = m.forest.root[c];
            cr_assert_eq(m.forest.nodes[first].parent, -1);
            cr_assert(!m.forest.bounded[c]);
            expect_children(&q, first, seed);
            for (int n = first + 1; n < m.forest.root[c + 1]; n++) {
                const StabNode *node = &m.forest.nodes[n];
                cr_assert(node->parent >= first && node->parent < n, "depth first");
                cr_assert(node->next < 0 ||
                          (node->next > n && m.forest.nodes[node->next].parent == node->parent));
            }
            inside += q.inside;
            outside += q.outside;
        }
        arena_free(&m.arena);
    }
    cr_assert(inside > 5000 && outside > 5000, "%ld sequences are crossed, %ld not", inside, outside);
}

// Four rooms a level, cut anew on each, so that most lie over several; some are missing.
static Building *tower(Arena *arena, Random *random) {
    Building *b = ARENA_ARRAY(arena, Building, 1);
    b->source = "tower";
    building_add_material(arena, b,
                          (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    for (int level = 0; level < 4; level++) {
        double x[3] = {0, maps_snap(random_between(random, 1, 5)), 6},
               y[3] = {0, maps_snap(random_between(random, 1, 5)), 6};
        for (int k = 0; k < 4; k++) {
            double x0 = x[k % 2], x1 = x[k % 2 + 1], y0 = y[k / 2], y1 = y[k / 2 + 1];
            const Vec2 p[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
            if (random_index(random, 4)) add_region(arena, b, p, 4, 3 * level, 3 * level + 3);
        }
    }
    b->world = (Box){{0, 0, 0}, {6, 6, 12}};
    return b;
}

// Proves that no sequence goes up through a floor and down through another, in towers of rooms that overlap anyhow: a straight line
// does not.
Test(forest, does_not_turn_back_in_height) {
    long levels = 0;
    for (uint64_t seed = 1; seed <= 10; seed++) {
        Random random = {seed};
        Arena arena = {0};
        CellGraph g;
        StabForest f;
        Error error;
        VisOptions options = vis_default_options();
        Building *b = tower(&arena, &random);
        cr_assert(vis_build_cells(b, &options, &arena, &g, &error), "%s", error.text);
        cr_assert(vis_build_forest(&g, &options, NULL, &arena, &f));
        for (int c = 0; c < g.cell_count; c++) {
            for (int n = f.root[c]; n < f.root[c + 1]; n++) {
                int up = 0, down = 0;
                for (int k = n; f.nodes[k].parent >= 0; k = f.nodes[k].parent) {
                    const Portal *portal = &g.portals[f.nodes[k].portal];
                    if (!portal->horizontal) continue;
                    double rise = g.cells[f.nodes[k].cell].z0 - g.cells[f.nodes[f.nodes[k].parent].cell].z0;
                    up += rise > 0, down += rise < 0;
                }
                levels += up + down > 1;
                cr_assert(up == 0 || down == 0, "seed %llu: a way from %d to %d goes up and down",
                          (unsigned long long)seed, c, f.nodes[n].cell);
            }
        }
        arena_free(&arena);
    }
    cr_assert_gt(levels, 1000);
}

// Proves determinism: the same .vis bytes on 1, 2 and 7 threads.
Test(forest, is_the_same_on_any_number_of_threads) {
    char path[3][64];
    Bytes bytes[3];
    Arena arena = {0};
    const int threads[3] = {1, 2, 7};
    for (int i = 0; i < 3; i++) {
        Made m;
        make(&m, 11, 5, 5, 2, threads[i], 0);
        snprintf(path[i], sizeof path[i], "/tmp/enfilade-test-%d-%d.vis", (int)getpid(), i);
        Error error;
        cr_assert(vis_save(path[i], &m.graph, &m.forest, &error), "%s", error.text);
        cr_assert(file_read(path[i], 1 << 30, &arena, &bytes[i], &error), "%s", error.text);
        unlink(path[i]);
        arena_free(&m.arena);
        cr_assert_eq(bytes[i].size, bytes[0].size);
        cr_assert_eq(memcmp(bytes[i].data, bytes[0].data, bytes[0].size), 0);
    }
    arena_free(&arena);
}

// Proves that a .vis file comes back as it went, and that damaged, cut and foreign files are refused.
Test(vis_file, refuses_what_is_not_whole) {
    Made m, other;
    make(&m, 3, 2, 2, 1, 1, 0);
    make(&other, 4, 2, 2, 1, 1, 0);
    char path[64];
    snprintf(path, sizeof path, "/tmp/enfilade-test-%d.vis", (int)getpid());
    Error error;
    StabForest back;
    Bytes good;
    cr_assert(vis_save(path, &m.graph, &m.forest, &error), "%s", error.text);
    cr_assert(vis_load(path, &m.graph, &m.arena, &back, &error), "%s", error.text);
    cr_assert_eq(back.node_count, m.forest.node_count);
    cr_assert_eq(memcmp(back.nodes, m.forest.nodes, (size_t)back.node_count * sizeof *back.nodes), 0);
    cr_assert_not(vis_load(path, &other.graph, &m.arena, &back, &error), "another building's file was taken");
    cr_assert(file_read(path, 1 << 30, &m.arena, &good, &error));
    Random random = {9};
    for (int i = 0; i < 300; i++) {
        Arena scratch = {0};
        unsigned char *bad = arena_alloc(&scratch, good.size, 1);
        memcpy(bad, good.data, good.size);
        size_t size = good.size;
        if (i % 2) {
            size = (size_t)(random_unit(&random) * (double)good.size);
        } else {
            bad[(size_t)(random_unit(&random) * (double)good.size)] ^=
                (unsigned char)(1 << random_index(&random, 8));
        }
        cr_assert(file_write(path, bad, size, &error));
        cr_assert_not(vis_load(path, &m.graph, &scratch, &back, &error), "case %d", i);
        arena_free(&scratch);
    }
    unlink(path);
    arena_free(&m.arena);
    arena_free(&other.arena);
}

// Proves that trees are taken for their own cells alone, of which any part may be another, and not when they lead astray: a file
// whose sum is right may be forged.
Test(vis_file, refuses_other_cells_and_forged_trees) {
    Arena arena = {0};
    Error error;
    StabForest back;
    char *path = arena_format(&arena, "%s/trees.vis", support_folder(&arena));
    Random random = {5};
    Row row = row_random(&random, 8);
    CellGraph *given = row_graph(&arena, &row);
    Made m;
    make(&m, 3, 2, 2, 1, 1, 0);
    StabForest forest;
    VisOptions options = vis_default_options();
    cr_assert(vis_build_forest(given, &options, NULL, &arena, &forest));
    const CellGraph *graphs[2] = {given, &m.graph};
    const StabForest *forests[2] = {&forest, &m.forest};
    for (int k = 0; k < 2; k++) {
        const CellGraph *g = graphs[k];
        double *const PARTS[] = {g->face_count ? &g->faces[g->face_count - 1].d : &g->plan[0].x,
                                 &g->plan[g->plan_count - 1].y, &g->cells[g->cell_count - 1].z1,
                                 &g->portals[g->portal_count - 1].plane.d,
                                 &g->portal_vertices[g->portal_vertex_count - 1].z};
        cr_assert(vis_save(path, g, forests[k], &error), "%s", error.text);
        for (int i = 0; i < 5; i++) {
            double before = *PARTS[i];
            *PARTS[i] += 1;
            cr_expect_not(vis_load(path, g, &arena, &back, &error), "graph %d: part %d may be another", k, i);
            *PARTS[i] = before;
        }
        g->ways[g->way_count - 1].cell++;
        cr_expect_not(vis_load(path, g, &arena, &back, &error), "graph %d: ways may be others", k);
        g->ways[g->way_count - 1].cell--;
        cr_assert(vis_load(path, g, &arena, &back, &error), "%s", error.text);
        StabForest forged = *forests[k];
        int last = forged.root[1] - 1, nodes = forged.node_count;
        cr_assert_gt(last, 1);
        int *const FIELDS[] = {&forged.nodes[last].cell,
                               &forged.nodes[last].parent,
                               &forged.nodes[last].portal,
                               &forged.nodes[last].next,
                               &forged.nodes[0].parent,
                               &forged.nodes[0].cell,
                               &forged.root[0],
                               &forged.root[1],
                               &forged.root[forged.cell_count],
                               &forged.nodes[0].next};
        const int WRONG[][3] = {{-1, forged.cell_count, INT_MAX},
                                {-1, last, nodes},
                                {-1, g->portal_count, INT_MAX},
                                {last, nodes, 0},
                                {0, 1, -2},
                                {1, -1, forged.cell_count},
                                {1, -1, 2},
                                {0, nodes + 1, -1},
                                {nodes - 1, nodes + 1, 0},
                                {0, nodes, -2}};
        for (int i = 0; i < 10; i++) {
            for (int w = 0; w < 3; w++) {
                int before = *FIELDS[i];
                *FIELDS[i] = WRONG[i][w];
                cr_assert(vis_save(path, g, &forged, &error), "%s", error.text);
                *FIELDS[i] = before;
                cr_expect_not(vis_load(path, g, &arena, &back, &error), "graph %d: field %d is %d", k, i,
                              WRONG[i][w]);
            }
        }
    }
    arena_free(&m.arena);
    arena_free(&arena);
}

static Eye random_eye(const Made *m, Random *random, int *cell) {
    *cell = random_index(random, m->graph.cell_count);
    Eye eye = {.position = fixture_point(&m->graph, random, *cell)};
    if (random_unit(random) < 0.2) return eye;  // all directions
    Vec3 forward = fixture_direction(random), side = fixture_direction(random);
    Vec3 right = vec3_normalize(vec3_cross(forward, side)), up = vec3_cross(right, forward);
    double x = random_between(random, 0.2, 1.5), y = random_between(random, 0.2, 1.5);
    Vec3 n[4] = {vec3_add(right, vec3_scale(forward, x)), vec3_sub(vec3_scale(forward, x), right),
                 vec3_add(up, vec3_scale(forward, y)), vec3_sub(vec3_scale(forward, y), up)};
    eye.frustum_count = 4;
    for (int i = 0; i < 4; i++) {
        n[i] = vec3_normalize(n[i]);
        eye.frustum[i] = (Plane){n[i], vec3_dot(n[i], eye.position)};
    }
    return eye;
}

// An eye exactly on a portal, or on the plane of its cell's portal, or in a corner of it.
static void put_on_portal(const Made *m, Random *random, int cell, Eye *eye) {
    const Cell *c = &m->graph.cells[cell];
    if (c->way_count == 0) return;
    const Way *way = &m->graph.ways[c->first_way + random_index(random, c->way_count)];
    const Portal *portal = &m->graph.portals[way->portal];
    const Vec3 *v = m->graph.portal_vertices + portal->first_vertex;
    double s = random_unit(random), t = random_unit(random);
    if (random_unit(random) < 0.2) s = 0;
    Vec3 p = vec3_add(v[0], vec3_add(vec3_scale(vec3_sub(v[1], v[0]), s),
                                     vec3_scale(vec3_sub(v[portal->vertex_count - 1], v[0]), t)));
    Vec3 moved = vec3_sub(p, eye->position);
    eye->position = p;
    for (int i = 0; i < eye->frustum_count; i++) eye->frustum[i].d += vec3_dot(eye->frustum[i].n, moved);
}

static bool in_view(const Eye *eye, Vec3 direction) {
    for (int i = 0; i < eye->frustum_count; i++) {
        if (vec3_dot(eye->frustum[i].n, direction) < 1e-9) return false;
    }
    return true;
}

static bool drawn_surface_at(const CellGraph *g, const VisResult *result, int cell, Vec3 hit) {
    for (int i = 0; i < result->object_count; i++) {
        int object = result->objects[i];
        bool surface = object >= g->surface_first[cell] && object < g->surface_first[cell + 1];
        bool leaf = g->objects[object].kind == OBJECT_LEAF;
        if ((surface || leaf) && box_contains(box_grow(g->object_boxes[object], 1e-6), hit)) return true;
    }
    return false;
}

// Proves that a query loses nothing: a line from the eye inside the view, through open portals, ends on a surface
// that is drawn, in a cell that is listed; with random doors, views, and eyes on portals, by every culling.
Test(query, loses_nothing) {
    for (uint64_t seed = 1; seed <= 24; seed++) {
        Made m;
        make(&m, seed, 4, 4, seed % 3 ? 1 : 2, 1, seed % 4 == 0 ? 3 : 0);
        VisQuery *query = vis_query_new(&m.graph, &m.forest, &m.arena);
        Random random = {seed * 31};
        float *doors = ARENA_ARRAY(&m.arena, float, m.building->opening_count);
        for (int i = 0; i < 300; i++) {
            int cell;
            Eye eye = random_eye(&m, &random, &cell);
            if (i % 4 == 0) put_on_portal(&m, &random, cell, &eye);
            for (int d = 0; d < m.building->opening_count; d++) doors[d] = random_unit(&random) < 0.6;
            Culling culling = (Culling)(CULL_PORTALS + i % 3);
            VisResult result = vis_query(query, &eye, cell, doors, culling);
            if (result.eye_cell < 0) continue;
            for (int k = 0; k < 200; k++) {
                Vec3 direction = fixture_direction(&random);
                direction.z *= 0.3;
                Trace trace;
                if (!in_view(&eye, direction)) continue;
                if (!fixture_trace(&m.graph, cell, eye.position, direction, doors, &trace)) continue;
                cr_assert(drawn_surface_at(&m.graph, &result, trace.cells[trace.count - 1], trace.hit),
                          "seed %llu, eye %d, line %d, culling %s: the surface at (%g, %g, %g) is not drawn",
                          (unsigned long long)seed, i, k, CULLING_NAMES[culling], trace.hit.x, trace.hit.y,
                          trace.hit.z);
            }
        }
        arena_free(&m.arena);
    }
}

// Proves that culling culls, and that each culling draws no more than the weaker one: trees no more than run-time
// portals, three dimensions no more than two, and all no more than everything.
Test(query, methods_are_ordered) {
    Made m;
    make(&m, 2, 6, 6, 1, 1, 0);
    VisQuery *query = vis_query_new(&m.graph, &m.forest, &m.arena);
    Random random = {5};
    double drawn[QUERY_CULLINGS] = {0};
    for (int i = 0; i < 300; i++) {
        int cell, count[QUERY_CULLINGS];
        Eye eye = random_eye(&m, &random, &cell);
        for (int k = 0; k < QUERY_CULLINGS; k++) {
            count[k] = vis_query(query, &eye, cell, NULL, (Culling)k).polygon_count;
            drawn[k] += count[k];
        }
        cr_assert(count[CULL_STAB] <= count[CULL_PORTALS] && count[CULL_FRUSTUM] <= count[CULL_NONE]);
    }
    cr_assert_lt(drawn[CULL_STAB], drawn[CULL_PLAN]);
    cr_assert_lt(drawn[CULL_STAB], 0.25 * drawn[CULL_NONE]);
    arena_free(&m.arena);
}

// Proves that opening a door hides nothing.
Test(query, opening_a_door_hides_nothing) {
    Made m;
    make(&m, 8, 4, 4, 1, 1, 0);
    VisQuery *query = vis_query_new(&m.graph, &m.forest, &m.arena);
    Random random = {6};
    float *doors = ARENA_ARRAY(&m.arena, float, m.building->opening_count + 1);
    unsigned char *before = ARENA_ARRAY(&m.arena, unsigned char, m.graph.cell_count);
    for (int i = 0; i < 300; i++) {
        int cell;
        Eye eye = random_eye(&m, &random, &cell);
        for (int d = 0; d < m.building->opening_count; d++) doors[d] = random_unit(&random) < 0.5;
        VisResult result = vis_query(query, &eye, cell, doors, CULL_STAB);
        memset(before, 0, (size_t)m.graph.cell_count);
        for (int k = 0; k < result.cell_count; k++) before[result.cells[k].cell] = 1;
        if (m.building->opening_count) doors[random_index(&random, m.building->opening_count)] = 1;
        result = vis_query(query, &eye, cell, doors, CULL_STAB);
        for (int k = 0; k < result.cell_count; k++) before[result.cells[k].cell] = 0;
        for (int c = 0; c < m.graph.cell_count; c++) cr_assert_eq(before[c], 0, "eye %d, cell %d", i, c);
    }
    arena_free(&m.arena);
}
