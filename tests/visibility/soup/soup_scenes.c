// soup_scenes.c - see the header.
#include "tests/visibility/soup/soup_scenes.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

double soup_largest_extent(const CellGraph *g) {
    Vec3 size = vec3_sub(g->box.max, g->box.min);
    return fmax(size.x, fmax(size.y, size.z));
}

void soup_check_portals(const CellGraph *g) {
    double near = 2e-6 * soup_largest_extent(g);
    for (int p = 0; p < g->portal_count; p++) {
        const Portal *portal = &g->portals[p];
        const Vec3 *v = g->portal_vertices + portal->first_vertex;
        cr_assert_gt(vec3_dot(plane_of_polygon(v, portal->vertex_count).n, portal->plane.n), 1 - 1e-9);
        for (int side = 0; side < 2; side++) {
            const Cell *cell = &g->cells[portal->cell[side]];
            bool on_face = false;
            for (int i = cell->first_face; i < cell->first_face + cell->face_count; i++) {
                Plane face = g->faces[i];
                on_face = on_face || vec3_dot(face.n, portal->plane.n) * (side ? -1 : 1) > 1 - 1e-12;
                for (int k = 0; k < portal->vertex_count; k++)
                    cr_assert_gt(plane_distance(face, v[k]), -near, "portal %d leaves cell %d", p,
                                 portal->cell[side]);
            }
            cr_assert(on_face, "portal %d is on no face of cell %d", p, portal->cell[side]);
        }
    }
}

static bool on_face(const CellGraph *g, int cell, const Vec3 *v, int count, double near) {
    const Cell *c = &g->cells[cell];
    for (int i = c->first_face; i < c->first_face + c->face_count; i++) {
        if (polygon_bend(v, count, g->faces[i]) < near) return true;
    }
    return false;
}

// Where two faces of a cell meet, either may be the one that is crossed.
static bool near_edge(const CellGraph *g, int cell, Vec3 p, double near) {
    const Cell *c = &g->cells[cell];
    int faces = 0;
    for (int i = c->first_face; i < c->first_face + c->face_count; i++)
        faces += fabs(plane_distance(g->faces[i], p)) < near;
    return faces > 1;
}

// 1: a polygon that hides, in a face of the cell, is at p; 0: none; -1: p is too near an edge of one.
static int opaque_at(const CellGraph *g, int cell, const Building *b, Vec3 p, double doubt) {
    int found = 0;
    for (int o = 0; o < b->object_count; o++) {
        for (int i = 0; b->objects[o].leaf < 0 && i < b->objects[o].polygon_count; i++) {
            const Polygon *polygon = &b->polygons[b->objects[o].first_polygon + i];
            const Vec3 *v = b->vertices + polygon->first_vertex;
            if (b->materials[polygon->material].alpha < 1) continue;
            if (fabs(plane_distance(plane_of_polygon(v, polygon->vertex_count), p)) > doubt) continue;
            if (!on_face(g, cell, v, polygon->vertex_count, doubt / 20)) continue;
            int inside = soup_fixture_inside(v, polygon->vertex_count, p, doubt);
            if (inside == 1) found = 1;
            if (inside < 0 && found == 0) found = -1;
        }
    }
    return found;
}

static int portal_at(const CellGraph *g, int from, int to, Vec3 p, double doubt) {
    const Cell *cell = &g->cells[from];
    int found = 0;
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &g->portals[g->ways[i].portal];
        if (g->ways[i].cell != to) continue;
        if (fabs(plane_distance(portal->plane, p)) > doubt) continue;
        int inside =
            soup_fixture_inside(g->portal_vertices + portal->first_vertex, portal->vertex_count, p, doubt);
        if (inside == 1) found = 1;
        if (inside < 0 && found == 0) found = -1;
    }
    return found;
}

// A line is in one cell at a time, without gaps, and goes from one to the next through a portal, or through a polygon
// that hides, never both and never neither. Tolerance: lines within ten snaps of an edge are left out.
static void check_lines(const CellGraph *g, const Building *b, Random *random, int lines) {
    double doubt = 1e-5 * soup_largest_extent(g);
    int through_portals = 0, through_walls = 0;
    for (int k = 0; k < lines; k++) {
        Vec3 from = soup_fixture_point(g, random, random_index(random, g->cell_count)),
             way = fixture_direction(random);
        Crossing crossing[512];
        int count = soup_fixture_crossings(g, from, way, crossing, 512);
        for (int i = 0; i + 1 < count; i++) {
            Crossing a = crossing[i], c = crossing[i + 1];
            bool grazes = a.to - a.from < 10 * doubt || c.to - c.from < 10 * doubt;
            if (grazes) continue;
            cr_assert_lt(fabs(a.to - c.from), doubt, "line %d: a gap or an overlap of %g m after cell %d", k,
                         c.from - a.to, a.cell);
            Vec3 p = vec3_add(from, vec3_scale(way, c.from));
            if (near_edge(g, a.cell, p, 2 * doubt) || near_edge(g, c.cell, p, 2 * doubt)) continue;
            int hidden = opaque_at(g, a.cell, b, p, doubt), open = portal_at(g, a.cell, c.cell, p, doubt);
            if (hidden < 0 || open < 0) continue;
            cr_assert_neq(hidden, open, "line %d from cell %d to %d at (%.9g, %.9g, %.9g): %s", k, a.cell,
                          c.cell, p.x, p.y, p.z,
                          hidden ? "through a portal and a wall" : "through neither portal nor wall");
            through_portals += open;
            through_walls += hidden;
        }
    }
    cr_assert(through_portals > lines / 10 && through_walls > lines / 100,
              "%d lines crossed %d portals and %d walls", lines, through_portals, through_walls);
}

void soup_check_soup(const CellGraph *g, const Building *b, uint64_t seed, int lines) {
    Random random = {seed};
    soup_check_portals(g);
    check_lines(g, b, &random, lines);
}
