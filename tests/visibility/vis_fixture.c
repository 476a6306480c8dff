// vis_fixture.c - see the header.
#include "tests/visibility/vis_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

void vis_check_make(Made *m, uint64_t seed, int nx, int ny, int storeys, int threads, int max_nodes) {
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

bool vis_check_separable(const Vec2 *left, const Vec2 *right, int count) {
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

bool vis_check_crossed_inside(const Vec2 *left, const Vec2 *right, int count) {
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

bool vis_check_is_in(const CellGraph *g, int c, Vec3 p) {
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

void vis_check_expect_placed(const CellGraph *g, const char *name) {
    for (int p = 0; p < g->portal_count; p++) {
        const Portal *portal = &g->portals[p];
        const Vec3 *v = g->portal_vertices + portal->first_vertex;
        Vec3 middle = middle_of(v, portal->vertex_count), off = vec3_scale(portal->plane.n, 1e-4);
        cr_assert(vis_check_is_in(g, portal->cell[0], vec3_add(middle, off)), "%s: portal %d", name, p);
        cr_assert(vis_check_is_in(g, portal->cell[1], vec3_sub(middle, off)), "%s: portal %d", name, p);
        cr_assert_gt(vec3_dot(plane_of_polygon(v, portal->vertex_count).n, portal->plane.n), 0.99);
        cr_assert_eq(portal->horizontal, fabs(portal->plane.n.z) > 0.5);
    }
    for (int c = 0; c < g->cell_count; c++) {
        for (int i = g->surface_first[c]; i < g->surface_first[c + 1]; i++) {
            const Polygon *p = &g->polygons[g->objects[i].first_polygon];
            const Vec3 *v = g->vertices + p->first_vertex;
            Vec3 n = plane_of_polygon(v, p->vertex_count).n, middle = middle_of(v, p->vertex_count);
            cr_assert(vis_check_is_in(g, c, middle), "%s: surface %d of cell %d", name, i, c);
            cr_assert(vis_check_is_in(g, c, vec3_add(middle, vec3_scale(n, 1e-4))),
                      "%s: surface %d of cell %d", name, i, c);
        }
    }
}

void vis_check_expect_closed(const CellGraph *g, int c, double expected, const char *name, double tolerance) {
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

void vis_check_turn_away(Made *m, uint64_t seed) {
    VisOptions options = vis_default_options();
    Error error;
    fixture_place(m->building, 0.4 * (double)seed, vec3(300.5 - 70 * (double)seed, 411.25, 12));
    cr_assert(vis_build_cells(m->building, &options, &m->arena, &m->graph, &error), "seed %llu: %s",
              (unsigned long long)seed, error.text);
}

void vis_check_add_region(Arena *arena, Building *b, const Vec2 *points, int count, double z0, double z1) {
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
