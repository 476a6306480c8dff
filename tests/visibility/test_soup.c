// test_soup.c - cells and portals found among polygons alone, against lines through cells and polygons.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "maps/polygons/soup_doors.h"
#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"
#include "visibility/soup/soup.h"

static CellGraph make(Arena *arena, const Building *b) {
    VisOptions options = vis_default_options();
    CellGraph graph;
    Error error = {""};
    cr_assert(vis_build_cells(b, &options, arena, &graph, &error), "%s", error.text);
    return graph;
}

// The cells that can be reached from one through portals, itself among them.
static int reachable(const CellGraph *g, int start, unsigned char *reached) {
    int count = 1;
    memset(reached, 0, (size_t)g->cell_count);
    reached[start] = 1;
    for (bool more = true; more;) {
        more = false;
        for (int p = 0; p < g->portal_count; p++) {
            const int *cell = g->portals[p].cell;
            if (reached[cell[0]] == reached[cell[1]]) continue;
            reached[cell[0]] = reached[cell[1]] = 1;
            count++;
            more = true;
        }
    }
    return count;
}

static bool connected(const CellGraph *g, Vec3 a, Vec3 b) {
    unsigned char reached[4096];
    int from = vis_locate(g, a, -1), to = vis_locate(g, b, -1);
    cr_assert(from >= 0 && to >= 0 && g->cell_count <= 4096);
    reachable(g, from, reached);
    return reached[to];
}

static double largest_extent(const CellGraph *g) {
    Vec3 size = vec3_sub(g->box.max, g->box.min);
    return fmax(size.x, fmax(size.y, size.z));
}

// ---- what must hold of any soup

// Every portal is convex, lies in a face of both its cells, within both, and looks at the first of them.
// Tolerance: what is snapped to a plane, 1e-6 of the size.
static void check_portals(const CellGraph *g) {
    double near = 2e-6 * largest_extent(g);
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
    double doubt = 1e-5 * largest_extent(g);
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

// The shadow and the extent of each cell hold points of it, and touch its corners: no line along a side of them misses all
// portals and faces.
static void check_extents(const CellGraph *g, Random *random) {
    double near = 1e-6 * largest_extent(g);
    for (int c = 0; c < g->cell_count; c++) {
        const Cell *cell = &g->cells[c];
        const Vec2 *plan = g->plan + cell->first_edge;
        Box box = box_empty();
        cr_assert(cell->z0 == cell->box.min.z && cell->z1 == cell->box.max.z && cell->z0 < cell->z1);
        for (int i = 0; i < cell->edge_count; i++) {
            Vec2 a = plan[i], b = plan[(i + 1) % cell->edge_count];
            box = box_add(box_add(box, vec3(a.x, a.y, cell->z0)), vec3(a.x, a.y, cell->z1));
            // Both ends are known to `near`, and so the line through them, less and less beyond.
            for (int k = 0; k < 20; k++) {
                Vec3 p = soup_fixture_point(g, random, c);
                Vec2 along = vec2_sub(b, a), to = vec2_sub(vec2(p.x, p.y), a);
                cr_assert_geq(vec2_cross(along, to), -near * (vec2_length(along) + vec2_length(to)));
                cr_assert(box_contains(box_grow(cell->box, near), p));
            }
        }
        cr_assert(box_contains(box_grow(box, near), cell->box.min) &&
                  box_contains(box_grow(box, near), cell->box.max));
        cr_assert(box_contains(box_grow(cell->box, near), box.min) &&
                  box_contains(box_grow(cell->box, near), box.max));
    }
}

static void check_soup(const CellGraph *g, const Building *b, uint64_t seed, int lines) {
    Random random = {seed};
    check_portals(g);
    check_lines(g, b, &random, lines);
}

// ---- polyhedra

// Six times its volume, by pyramids over its faces.
static double volume_of(const SoupCell *cell) {
    double sum = 0;
    for (int i = 0; i < cell->face_count; i++) {
        const CellFace *f = &cell->faces[i];
        for (int k = 1; k + 1 < f->count; k++)
            sum -= vec3_dot(f->v[0], vec3_cross(f->v[k], f->v[k + 1]));  // faces look inwards
    }
    return sum;
}

static void extent_of(const SoupCell *cell, Plane plane, double *low, double *high) {
    *low = INFINITY, *high = -INFINITY;
    for (int i = 0; i < cell->face_count; i++) {
        for (int k = 0; k < cell->faces[i].count; k++) {
            *low = fmin(*low, plane_distance(plane, cell->faces[i].v[k]));
            *high = fmax(*high, plane_distance(plane, cell->faces[i].v[k]));
        }
    }
}

// Each face lies in its plane, looks inwards, and all corners are on its inner side; together they close.
static void expect_polyhedron(const Soup *soup, const SoupCell *cell) {
    Vec3 open = {0, 0, 0};
    for (int i = 0; i < cell->face_count; i++) {
        const CellFace *f = &cell->faces[i];
        Plane inward = soup_inward(soup, f);
        double low, high;
        extent_of(cell, inward, &low, &high);
        cr_assert(low > -1e-8 && high > 0, "a corner is %g m outside face %d", -low, i);
        cr_assert_lt(polygon_bend(f->v, f->count, inward), 1e-8);
        Vec3 area = vec3_scale(plane_of_polygon(f->v, f->count).n, polygon_area(f->v, f->count));
        cr_assert_gt(vec3_dot(area, inward.n), 0);
        open = vec3_add(open, area);
        for (int k = 0; k < i; k++) cr_assert(cell->faces[k].plane != f->plane, "one face a plane");
    }
    cr_assert_lt(vec3_length(open), 1e-7);
}

// A random plane through a cell, now and then through a corner, or beside one by about the thickness that is too thin.
static Plane plane_through(const Soup *soup, const SoupCell *cell, Random *random) {
    Vec3 n = random_index(random, 3) ? fixture_direction(random) : vec3(1, 0, 0), at = {0, 0, 0};
    double weights = 0;
    const CellFace *some = &cell->faces[random_index(random, cell->face_count)];
    for (int i = 0; i < cell->face_count; i++) {
        double w = random_unit(random);
        at = vec3_add(at, vec3_scale(cell->faces[i].v[random_index(random, cell->faces[i].count)], w));
        weights += w;
    }
    at = vec3_scale(at, 1 / weights);
    if (random_index(random, 3) == 0) {
        double low, high;
        at = some->v[random_index(random, some->count)];
        extent_of(cell, (Plane){n, 0}, &low, &high);
        double off = SOUP_THINNEST * soup->size * random_between(random, 0.5, 1.5);
        if (random_index(random, 2)) return (Plane){n, random_index(random, 2) ? low + off : high - off};
    }
    return (Plane){n, vec3_dot(n, at)};
}

// Proves that polyhedra are cut into polyhedra, as often as one likes: none where a part would be too thin, else two whose volumes make up
// the whole, with the section for their common face; and that what a cell holds of a polygon is what lies on the inner side of all its
// faces. Tolerance: corners that are one within SOUP_WELD of ten metres, over a few square metres.
Test(soup, cells_are_cut_into_polyhedra) {
    enum { CUTS = 40 };
    int cut = 0, thin = 0;
    for (uint64_t seed = 1; seed <= 600; seed++) {
        Random random = {seed};
        Arena arena = {0};
        Soup soup = {.scratch = &arena, .size = 10, .planes = ARENA_ARRAY(&arena, SoupPlane, CUTS + 6)};
        SoupCell *cells[CUTS + 1] = {soup_cell_new(&soup)};
        int count = 1;
        Vec3 corner[8];
        for (int i = 0; i < 8; i++) corner[i] = vec3(i & 1 ? 2 : -2, i & 2 ? 1 : -3, i & 4 ? 2 : 0);
        static const int FACES[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                        {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
        for (int i = 0; i < 6; i++) {
            Vec3 v[4];
            for (int k = 0; k < 4; k++) v[k] = corner[FACES[i][k]];
            soup.planes[soup.plane_count++].plane = plane_of_polygon(v, 4);
            soup_cell_add_face(&soup, cells[0], i, 1, v, 4);
        }
        cr_assert_float_eq(volume_of(cells[0]), 6 * 32, 1e-9);
        for (int n = 0; n < CUTS; n++) {
            SoupCell *cell = cells[random_index(&random, count)], *part[2] = {NULL, NULL};
            Plane plane = plane_through(&soup, cell, &random);
            double low, high, least = SOUP_THINNEST * soup.size;
            extent_of(cell, plane, &low, &high);
            soup.planes[soup.plane_count].plane = plane;
            bool split = soup_cell_split(&soup, cell, soup.plane_count, &part[0], &part[1]);
            // A corner exactly as far off as that may go either way.
            if (fabs(fmin(-low, high) - least) > 1e-9)
                cr_assert_eq(split, fmin(-low, high) > least,
                             "seed %llu, cut %d: from %g to %g m of its plane", (unsigned long long)seed, n,
                             low, high);
            thin += !split;
            if (!split) continue;
            cut++;
            Vec3 section[SOUP_MOST_CORNERS];
            int corners = soup_cell_section(&soup, cell, soup.plane_count, section);
            cr_assert_geq(corners, 3);
            cr_assert_gt(vec3_dot(plane_of_polygon(section, corners).n, plane.n), 0.999);
            for (int side = 0; side < 2; side++) {
                const CellFace *common = &part[side]->faces[part[side]->face_count - 1];
                expect_polyhedron(&soup, part[side]);
                cr_assert(common->plane == soup.plane_count && common->side == (side ? -1 : 1));
                cr_assert_float_eq(polygon_area(common->v, common->count), polygon_area(section, corners),
                                   1e-7);
            }
            cr_assert_float_eq(volume_of(part[0]) + volume_of(part[1]), volume_of(cell), 1e-6);
            soup.plane_count++;
            for (int k = 0; k < count; k++)
                if (cells[k] == cell) cells[k] = part[0];
            cells[count++] = part[1];
        }
        for (int n = 0; n < 20; n++) {
            const SoupCell *cell = cells[random_index(&random, count)];
            Vec3 v[3], held[SOUP_MOST_CORNERS];
            for (int k = 0; k < 3; k++) v[k] = vec3_scale(fixture_direction(&random), 3);
            int corners = soup_cell_clip(&soup, cell, v, 3, held);
            for (int k = 0; k < 50; k++) {
                double a = random_unit(&random), b = random_unit(&random) * (1 - a), inside = INFINITY;
                Vec3 p =
                    vec3_add(vec3_scale(v[0], 1 - a - b), vec3_add(vec3_scale(v[1], a), vec3_scale(v[2], b)));
                for (int i = 0; i < cell->face_count; i++)
                    inside = fmin(inside, plane_distance(soup_inward(&soup, &cell->faces[i]), p));
                int there = corners ? soup_fixture_inside(held, corners, p, 1e-6) : 0;
                cr_assert(fabs(inside) < 1e-4 || there < 0 || there == (inside > 0),
                          "seed %llu, polygon %d: %g m inside", (unsigned long long)seed, n, inside);
            }
        }
        arena_free(&arena);
    }
    cr_assert(cut > 10000 && thin > 1000, "%d cuts, %d too thin", cut, thin);
}

// ---- pieces of a plane

// A convex polygon in the plane through `middle` with normal n, either way round.
static int flat_polygon(Random *random, Vec3 n, Vec3 middle, double size, Vec3 *out) {
    Vec3 u = vec3_normalize(vec3_cross(n, fabs(n.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0))),
         w = vec3_cross(n, u);
    int count = 3 + random_index(random, 5), way = random_index(random, 2) ? 1 : -1;
    double turn = random_between(random, 0, 6);
    middle = vec3_add(middle, vec3_add(vec3_scale(u, random_between(random, -2, 2)),
                                       vec3_scale(w, random_between(random, -2, 2))));
    for (int i = 0; i < count; i++) {
        double angle = turn + way * 2 * M_PI * (i + random_between(random, -0.2, 0.2)) / count;
        out[i] =
            vec3_add(middle, vec3_add(vec3_scale(u, size * cos(angle)), vec3_scale(w, size * sin(angle))));
    }
    return count;
}

// In how many of the pieces the point lies; -1 where it is too near an edge.
static int pieces_at(const SoupPieces *pieces, Vec3 p) {
    int held = 0;
    for (int i = 0; i < pieces->count; i++) {
        int inside = soup_fixture_inside(pieces->piece[i].v, pieces->piece[i].count, p, 1e-6);
        if (inside < 0) return -1;
        held += inside;
    }
    return held;
}

// Could two pieces be one? Their hull, by the corners alone, holds no more than they do.
static bool could_join(Arena *arena, const SoupPiece *a, const SoupPiece *b, Vec3 n) {
    Vec3 all[64], hull[65];
    memcpy(all, a->v, (size_t)a->count * sizeof *all);
    memcpy(all + a->count, b->v, (size_t)b->count * sizeof *all);
    int count = soup_hull(arena, all, a->count + b->count, n, 0, hull);
    return polygon_area(hull, count) - polygon_area(a->v, a->count) - polygon_area(b->v, b->count) < 1e-10;
}

// Proves that what is left of a polygon when others are taken from it is what lies in it and in none of those, once each, in convex pieces
// with their boxes; that it stays the same when pieces are joined; and that hardly two pieces are left that could be one (those
// of which both took the place of others). By points.
Test(soup, pieces_are_what_is_left) {
    static const double WELD = 1e-8, NEAR = 1e-5;
    int inside = 0, outside = 0, joined = 0, apart = 0;
    for (uint64_t seed = 1; seed <= 1500; seed++) {
        Random random = {seed};
        Arena arena = {0};
        Vec3 n = seed % 3 ? fixture_direction(&random) : vec3(0, 0, 1), middle = vec3(3, -2, 1), hole[6][8],
             v[8];
        int holes = 1 + random_index(&random, 6), corners[6], count = flat_polygon(&random, n, middle, 3, v);
        SoupPieces pieces = {0};
        soup_pieces_add(&arena, &pieces, v, count);
        for (int i = 0; i < holes; i++) {
            corners[i] = flat_polygon(&random, n, middle, random_between(&random, 0.2, 1.5), hole[i]);
            soup_pieces_subtract(&arena, &pieces, hole[i], corners[i], n, WELD, NEAR);
        }
        int before = pieces.count;
        for (int turn = 0; turn < 2; turn++) {
            if (turn) soup_pieces_join(&arena, &pieces, n, WELD, NEAR);
            for (int i = 0; i < pieces.count; i++) {
                const SoupPiece *piece = &pieces.piece[i];
                Box box = soup_box(piece->v, piece->count, 0);
                cr_assert(vec3_equal(box.min, piece->box.min) && vec3_equal(box.max, piece->box.max));
                for (int k = 0; turn && k < i; k++) apart += could_join(&arena, piece, &pieces.piece[k], n);
            }
            for (int k = 0; k < 60; k++) {
                Vec3 p = {0, 0, 0};
                double weights = 0;
                for (int i = 0; i < count; i++) {
                    double w = random_unit(&random);
                    p = vec3_add(p, vec3_scale(v[i], w));
                    weights += w;
                }
                p = vec3_scale(p, 1 / weights);
                bool taken = false, doubtful = false;
                for (int i = 0; i < holes; i++) {
                    int in = soup_fixture_inside(hole[i], corners[i], p, 1e-6);
                    taken = taken || in > 0;
                    doubtful = doubtful || in < 0;
                }
                int held = pieces_at(&pieces, p);
                if (doubtful || held < 0) continue;
                cr_assert_eq(held, !taken, "seed %llu: a point in %d pieces", (unsigned long long)seed, held);
                inside += taken;
                outside += !taken;
            }
        }
        joined += before - pieces.count;
        arena_free(&arena);
    }
    cr_assert(inside > 10000 && outside > 10000 && joined > 500, "%d, %d, %d", inside, outside, joined);
    cr_assert_lt(apart, joined / 100, "%d pairs could be one", apart);
}

// ---- planes

// Proves that a soup of one plane has its directions along its first edge and across, be it turned any way, and that details, of less than
// a millionth of all that is opaque, part nothing.
Test(soup, directions_of_one_plane) {
    for (uint64_t seed = 1; seed <= 20; seed++) {
        Random random = {seed};
        Arena arena = {0};
        Building *flat = soup_fixture_new(&arena);
        soup_fixture_quad(&arena, flat, vec3(0, 0, 0), vec3(3, 1, 0), vec3(2, 4, 0), vec3(-1, 3, 0), 0);
        soup_fixture_quad(&arena, flat, vec3(1, 1, 0), vec3(1, 1.002, 0), vec3(1, 1.002, 0.002),
                          vec3(1, 1, 0.002), 0);
        SoupPose pose = {1, random_between(&random, 0, 6), fixture_direction(&random), {3, -7, 2}};
        const Building *b = soup_fixture_posed(&arena, flat, &pose);
        CellGraph graph = {.building = b};
        CellBuilder builder = {.building = b, .graph = &graph, .arena = &arena, .scratch = &arena};
        Soup soup = {.builder = &builder, .scratch = &arena};
        soup_find_planes(&soup);
        Vec3 along = vec3_normalize(vec3_sub(b->vertices[1], b->vertices[0]));
        cr_assert_eq(soup.sheet_count, 1);
        cr_assert_gt(fabs(vec3_dot(soup.axis[1], along)), 1 - 1e-9);
        cr_assert_lt(fabs(vec3_dot(soup.axis[0], along)), 1e-9);
        arena_free(&arena);
    }
}

// Proves what is known of the planes of a soup before it is parted: each opaque polygon in some plane, to within SOUP_SNAP, whose sum of
// areas is told, largest first; the sheets of a plane side by side; three directions at right angles, the first across the largest plane;
// a box of these around all corners that touches them; and a world a quarter of the size larger.
Test(soup, planes_hold_all_sheets) {
    for (uint64_t seed = 1; seed <= 40; seed++) {
        Random random = {seed};
        Arena arena = {0};
        const Building *b = soup_fixture_house(&arena, &random, 1 + (int)(seed % 4), 1 + (int)(seed % 3));
        if (seed % 2) {
            SoupPose pose = {random_between(&random, 0.3, 3),
                             random_between(&random, 0, 6),
                             fixture_direction(&random),
                             {300, -70, 20}};
            b = soup_fixture_posed(&arena, b, &pose);
        }
        CellGraph graph = {.building = b};
        CellBuilder builder = {.building = b, .graph = &graph, .arena = &arena, .scratch = &arena};
        Soup soup = {.builder = &builder, .scratch = &arena};
        soup_find_planes(&soup);
        double near = SOUP_SNAP * soup.size, total = 0, farthest = 0, last = INFINITY;
        Vec3 mean = {0, 0, 0};
        for (int i = 0; i < b->vertex_count; i++)
            farthest = fmax(farthest, vec3_length(vec3_sub(b->vertices[i], soup.centre)));
        cr_assert_float_eq(soup.size, 2 * farthest, 1e-9 * soup.size);
        cr_assert_float_eq(make(&arena, b).touch, 4 * near, 1e-9 * near);
        for (int i = 0; i < b->vertex_count; i++)
            mean = vec3_add(mean, vec3_scale(b->vertices[i], 1.0 / b->vertex_count));
        cr_assert_lt(vec3_length(vec3_sub(mean, soup.centre)), 1e-9 * soup.size);
        for (int i = 0; i < b->polygon_count; i++)
            total += polygon_area(b->vertices + b->polygons[i].first_vertex, b->polygons[i].vertex_count);
        cr_assert_float_eq(soup.opaque_area, total, 1e-9 * total);
        cr_assert_eq(soup.sheet_count, b->polygon_count, "there are no details among them");
        int largest = 0;
        for (int p = 0; p < soup.plane_count; p++) {
            const SoupPlane *plane = &soup.planes[p];
            double area = 0, most = 0;
            for (int i = 0; i < soup.sheet_count; i++) {
                const SoupSheet *sheet = &soup.sheets[i];
                bool listed = i >= plane->first_sheet && i < plane->first_sheet + plane->sheet_count;
                cr_assert_eq(listed, sheet->plane == p, "sheet %d in plane %d", i, p);
                if (!listed) continue;
                area += sheet->area;
                most = fmax(most, sheet->area);
                cr_assert_leq(polygon_bend(sheet->v, sheet->count, plane->plane), near);
            }
            cr_assert_float_eq(plane->area, area, 1e-9 * (1 + area));
            cr_assert_float_eq(vec3_length(plane->plane.n), 1, 1e-12);
            if (area > soup.planes[largest].area * (1 + 1e-3)) largest = p;
            cr_assert_leq(most, last + 1e-6 * total, "plane %d has the larger polygon", p);
            if (most > 0) last = most;
            for (int q = 0; q < p && area > 0; q++) {
                // No two planes for what lies in one.
                double apart = 0;
                for (int i = plane->first_sheet; i < plane->first_sheet + plane->sheet_count; i++)
                    apart = fmax(apart,
                                 polygon_bend(soup.sheets[i].v, soup.sheets[i].count, soup.planes[q].plane));
                cr_assert(apart > near, "planes %d and %d are one", q, p);
            }
        }
        for (int k = 0; k < 3; k++) {
            cr_assert_float_eq(vec3_length(soup.axis[k]), 1, 1e-9);
            cr_assert_lt(fabs(vec3_dot(soup.axis[k], soup.axis[(k + 1) % 3])), 1e-8);
        }
        double across = fabs(vec3_dot(soup.axis[0], soup.planes[largest].plane.n));
        cr_assert(across > 1 - 1e-9 || soup.planes[0].area < soup.planes[largest].area * 1.01,
                  "the largest plane is across");
        for (int side = 0; side < 6; side++) {
            Plane plane = soup.planes[soup.box[side]].plane, border = soup.planes[soup.border + side].plane;
            Vec3 inward = vec3_scale(soup.axis[side / 2], side % 2 ? -1 : 1);
            double turn = vec3_dot(plane.n, inward) > 0 ? 1 : -1, least = INFINITY, world = INFINITY;
            cr_assert(vec3_dot(border.n, inward) > 1 - 1e-9 && fabs(vec3_dot(plane.n, inward)) > 1 - 1e-5);
            for (int i = 0; i < b->vertex_count; i++) {
                least = fmin(least, turn * plane_distance(plane, b->vertices[i]));
                world = fmin(world, plane_distance(border, b->vertices[i]));
            }
            cr_assert(fabs(least) < 2 * near, "side %d is %g m off", side, least);
            cr_assert_float_eq(world, soup.size / 4, 2 * near);
        }
        cr_assert_eq(soup.cell_count, 1);
        expect_polyhedron(&soup, soup.cells[0]);
        arena_free(&arena);
    }
}

// ---- reference scenes

// Proves that the scene of two rooms comes out as two rooms and a doorway, as they were drawn.
Test(soup, two_rooms) {
    Arena arena = {0};
    const Building *b = soup_fixture_read(&arena, "twoRoom.quads", "two-rooms.quads");
    CellGraph g = make(&arena, b);
    static const Box expected[3] = {
        {{0, 0, 0}, {4, 3, 2.5}}, {{4, 1, 0}, {4.2, 1.9, 2}}, {{4.2, 0, 0}, {8.2, 3, 2.5}}};
    unsigned char indoors[4096];
    int cell[3];
    for (int i = 0; i < 3; i++) {
        cell[i] = vis_locate(&g, vec3_lerp(expected[i].min, expected[i].max, 0.4), -1);
        Box box = g.cells[cell[i]].box;
        // Tolerance: rounding of cuts.
        cr_assert_lt(vec3_length(vec3_sub(box.min, expected[i].min)), 1e-9);
        cr_assert_lt(vec3_length(vec3_sub(box.max, expected[i].max)), 1e-9);
        cr_assert_not(g.cells[cell[i]].outdoors);
    }
    cr_assert_eq(reachable(&g, cell[0], indoors), 3);
    int portals = 0;
    for (int p = 0; p < g.portal_count; p++) portals += indoors[g.portals[p].cell[0]];
    cr_assert_eq(portals, 2);
    cr_assert_eq(g.dropped_slivers, 0);
    check_soup(&g, b, 1, 4000);
    arena_free(&arena);
}

// Proves that furniture stays in the room it stands in.
Test(soup, room_with_boxes) {
    Arena arena = {0};
    const Building *b = soup_fixture_read(&arena, "boxA.quads", "boxes.quads");
    CellGraph g = make(&arena, b);
    unsigned char indoors[4096];
    int cell = vis_locate(&g, vec3(2, 1.5, 1.8), -1);
    cr_assert_eq(reachable(&g, cell, indoors), 1);
    cr_assert_eq(vis_locate(&g, vec3(3, 2, 0.3), -1), cell, "the low box is part of the room");
    check_portals(&g);
    arena_free(&arena);
}

// Proves that houses of many rooms, with slanting roofs, turned any way, are parted without loss.
Test(soup, houses) {
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Arena arena = {0};
        Random random = {seed};
        const Building *b = soup_fixture_house(&arena, &random, 1 + (int)(seed % 4), 1 + (int)(seed % 3));
        if (seed % 2) {
            SoupPose pose = {1, random_between(&random, 0, 6), fixture_direction(&random), {3, -7, 2}};
            b = soup_fixture_posed(&arena, b, &pose);
        }
        CellGraph g = make(&arena, b);
        check_soup(&g, b, seed, 1500);
        check_extents(&g, &random);
        arena_free(&arena);
    }
}

static bool inside_edge(Vec3 p, Vec3 a, Vec3 b, double near) {
    Vec3 along = vec3_sub(b, a), from = vec3_sub(p, a);
    double length = vec3_length(along), t = vec3_dot(from, along) / length;
    return t > near && t < length - near && vec3_length(vec3_sub(from, vec3_scale(along, t / length))) < near;
}

// Proves that what is drawn has no T-vertices, and is what was read otherwise: the same polygons, of the same areas.
// Tolerance: a tenth of what counts as on an edge, of a building of ten metres.
Test(soup, has_no_t_vertices) {
    for (uint64_t seed = 0; seed <= 4; seed++) {
        Arena arena = {0};
        Random random = {seed};
        const Building *b = seed == 0 ? soup_fixture_read(&arena, "twoRoom.quads", "two-rooms.quads")
                                      : soup_fixture_house(&arena, &random, 2, 2);
        CellGraph g = make(&arena, b);
        cr_assert_gt(g.vertex_count, b->vertex_count, "there were some");
        for (int i = 0; i < b->polygon_count; i++) {
            const Polygon *p = &g.polygons[i], *was = &b->polygons[i];
            double area = polygon_area(b->vertices + was->first_vertex, was->vertex_count);
            cr_assert_float_eq(polygon_area(g.vertices + p->first_vertex, p->vertex_count), area, 1e-5);
            for (int k = 0; k < p->vertex_count; k++) {
                Vec3 from = g.vertices[p->first_vertex + k],
                     to = g.vertices[p->first_vertex + (k + 1) % p->vertex_count];
                cr_assert_not(vec3_equal(from, to), "seed %llu, polygon %d: an edge is a point",
                              (unsigned long long)seed, i);
                for (int v = 0; v < g.vertex_count; v++)
                    cr_assert_not(inside_edge(g.vertices[v], from, to, 1e-7), "seed %llu, polygon %d",
                                  (unsigned long long)seed, i);
            }
        }
        arena_free(&arena);
    }
}

// Proves that polygons flung about at random, steep, thin and round ones among them, are parted without a fault, and that
// what hides and what is open is told apart there too.
Test(soup, polygons_at_random) {
    int parted = 0, seeds = support_count(5, 8);
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; seed++) {
        Arena arena = {0};
        Random random = {seed};
        Building *b = soup_fixture_new(&arena);
        for (int i = 0; i < 150; i++) {
            Vec3 n = fixture_direction(&random),
                 u = vec3_normalize(vec3_cross(n, fixture_direction(&random)));
            Vec3 w = vec3_cross(n, u), middle = vec3_scale(fixture_direction(&random), 2);
            double wide = random_between(&random, 0.1, 6),
                   high = seed % 4 ? random_between(&random, 0.1, 6) : 1e-4;
            int corners = 3 + random_index(&random, seed % 3 ? 4 : 28);
            Vec3 v[40];
            for (int k = 0; k < corners; k++) {
                double angle = 2 * M_PI * k / corners;
                v[k] = vec3_add(middle,
                                vec3_add(vec3_scale(u, wide * cos(angle)), vec3_scale(w, high * sin(angle))));
            }
            building_add_polygon(&arena, b, v, corners, 0);
        }
        CellGraph g = make(&arena, b);
        // Where little is hidden, one cell is enough.
        if (g.cell_count > 20) check_soup(&g, b, seed, 500);
        parted += g.cell_count > 20;
        arena_free(&arena);
    }
    cr_assert_gt(parted, seeds / 2 - 1);
}

// ---- shapes

static Building *closed_room(Arena *arena, Vec3 size) {
    Building *b = soup_fixture_new(arena);
    soup_fixture_box(arena, b, vec3(0, 0, 0), size, 0);
    return b;
}

// Proves that a wall without thickness parts two rooms, and also when it stands there twice.
Test(soup, walls_without_thickness) {
    for (int copies = 1; copies <= 3; copies++) {
        Arena arena = {0};
        Building *b = closed_room(&arena, vec3(8, 3, 2.5));
        for (int i = 0; i < copies; i++) soup_fixture_wall(&arena, b, 0, 5, 0, 3, 0, 2.5, NULL, 0, 0);
        CellGraph g = make(&arena, b);
        cr_assert_not(connected(&g, vec3(2, 1, 1), vec3(7, 1, 1)));
        check_soup(&g, b, (uint64_t)copies, 2000);
        arena_free(&arena);
    }
}

// Proves that cracks of 1e-7 m and steps of 1e-7 m between polygons of a wall let nothing through, that the wall is one
// plane all the same, and that a slit of 1 cm does let through.
Test(soup, cracks) {
    static const double widths[] = {0, 1e-7, 1e-2};
    for (int i = 0; i < 3; i++) {
        Arena arena = {0};
        Building *b = closed_room(&arena, vec3(8, 3, 2.5));
        double gap = widths[i], off = i == 1 ? 1e-7 : 0;
        soup_fixture_wall(&arena, b, 0, 5, 0, 1, 0, 2.5, NULL, 0, 0);
        soup_fixture_wall(&arena, b, 0, 5 + off, 1 + gap, 2, 0, 2.5, NULL, 0, 0);
        soup_fixture_wall(&arena, b, 0, 5 - off, 2, 3, 0, 2.5, NULL, 0, 0);
        CellGraph g = make(&arena, b);
        cr_assert_eq(connected(&g, vec3(2, 1, 1), vec3(7, 1, 1)), i == 2, "a crack of %g m", gap);
        int rooms = 0;
        for (int c = 0; c < g.cell_count; c++) rooms += !g.cells[c].outdoors;
        cr_assert_eq(rooms, 2, "a crack of %g m makes %d rooms", gap, rooms);
        cr_assert_eq(g.dropped_slivers > 0, i == 1, "cracks that are closed are counted");
        arena_free(&arena);
    }
}

// Proves that a room round a corner is seen into, and that its cells are no more than a bend needs.
Test(soup, concave_room) {
    Arena arena = {0};
    Building *b = soup_fixture_new(&arena);
    const Vec3 floor[2][4] = {{{0, 0, 0}, {6, 0, 0}, {6, 2, 0}, {0, 2, 0}},
                              {{0, 2, 0}, {2, 2, 0}, {2, 6, 0}, {0, 6, 0}}};
    for (int i = 0; i < 2; i++) {
        for (int z = 0; z < 2; z++) {
            Vec3 up = {0, 0, z * 2.5};
            const Vec3 *f = floor[i];
            soup_fixture_quad(&arena, b, vec3_add(f[0], up), vec3_add(f[1], up), vec3_add(f[2], up),
                              vec3_add(f[3], up), 0);
        }
    }
    soup_fixture_wall(&arena, b, 1, 0, 0, 6, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 0, 6, 0, 2, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 1, 2, 2, 6, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 0, 2, 2, 6, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 1, 6, 0, 2, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 0, 0, 0, 6, 0, 2.5, NULL, 0, 0);
    CellGraph g = make(&arena, b);
    unsigned char indoors[4096];
    cr_assert_eq(reachable(&g, vis_locate(&g, vec3(5, 1, 1), -1), indoors), 2);
    cr_assert(indoors[vis_locate(&g, vec3(1, 5, 1), -1)]);
    check_soup(&g, b, 3, 3000);
    arena_free(&arena);
}

// Proves that glass parts nothing.
Test(soup, glass) {
    Arena arena = {0};
    Building *b = closed_room(&arena, vec3(8, 3, 2.5));
    soup_fixture_quad(&arena, b, vec3(5, 0, 0), vec3(5, 3, 0), vec3(5, 3, 2.5), vec3(5, 0, 2.5), 1);
    CellGraph g = make(&arena, b);
    cr_assert_eq(vis_locate(&g, vec3(2, 1, 1), -1), vis_locate(&g, vec3(7, 1, 1), -1));
    arena_free(&arena);
}

// Proves that a single polygon, and several in one plane, make cells, and that a soup without any is refused.
Test(soup, flat_and_empty) {
    Arena arena = {0};
    Building *b = soup_fixture_new(&arena);
    VisOptions options = vis_default_options();
    CellGraph g;
    Error error = {""};
    cr_assert_not(vis_build_cells(b, &options, &arena, &g, &error));
    cr_assert_str_eq(error.text, "soup: has no polygons");
    soup_fixture_quad(&arena, b, vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0), 0);
    g = make(&arena, b);
    check_portals(&g);
    cr_assert(connected(&g, vec3(0.5, 0.5, 0.1), vec3(0.5, 0.5, -0.1)), "around the edge");
    soup_fixture_quad(&arena, b, vec3(3, 0, 0), vec3(4, 0, 0), vec3(4, 1, 0), vec3(3, 1, 0), 0);
    g = make(&arena, b);
    check_portals(&g);
    arena_free(&arena);
}

// ---- doors

static Building *rooms_with_door(Arena *arena, const char *name, double width) {
    const double hole[2] = {1, 2};
    Building *b = closed_room(arena, vec3(8, 3, 2.5));
    soup_fixture_wall(arena, b, 0, 5, 0, 3, 0, 2.5, hole, 1, 2.1);
    building_add_object(arena, b, OBJECT_FURNITURE, name);
    soup_fixture_box(arena, b, vec3(4.98, 1.01, 0.01), vec3(5.02, 1.01 + width, 2.09), 0);
    soup_find_doors(arena, b);
    return b;
}

// Proves that words and sizes tell doors, in several languages and spellings, and what is no door.
Test(soup_doors, told_by_name) {
    static const struct {
        const char *name;
        int doors;
    } cases[] = {
        {"Door", 1},        {"front_door.001", 1}, {"FrontDoor", 1},   {"Haus Tür", 1}, {"TÜR-2", 1},
        {"la porte", 1},    {"DOORS", 1},          {"doorway", 0},     {"outdoor", 0},  {"door frame", 0},
        {"Door_Frame1", 0}, {"wall", 0},           {"indoors.set", 0}, {"", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Arena arena = {0};
        Building *b = rooms_with_door(&arena, cases[i].name, 0.98);
        cr_assert_eq(b->opening_count, cases[i].doors, "`%s`", cases[i].name);
        arena_free(&arena);
    }
    Arena arena = {0};
    cr_assert_eq(rooms_with_door(&arena, "door", 0.3)->opening_count, 0, "too narrow to pass");
    arena_free(&arena);
}

// Proves that a door becomes an opening with a leaf of its own polygons, that nothing else changes, and that the building
// has no fault.
Test(soup_doors, leaf) {
    Arena arena = {0};
    Building *b = rooms_with_door(&arena, "door", 0.98);
    const Leaf *leaf = &b->leaves[0];
    cr_assert_eq(b->leaf_count, 1);
    cr_assert_eq(leaf->opening, 0);
    cr_assert_float_eq(vec2_length(vec2_sub(leaf->axis[1], leaf->axis[0])), 0.98, 1e-9);
    cr_assert_float_eq(leaf->thickness, 0.04, 1e-9);
    cr_assert(vec2_equal(leaf->pivot, leaf->axis[0]));
    int moving = 0, polygons = 0;
    for (int i = 0; i < b->object_count; i++) {
        polygons += b->objects[i].polygon_count;
        if (b->objects[i].leaf == 0) moving += b->objects[i].polygon_count;
    }
    cr_assert_eq(moving, 6);
    cr_assert_eq(polygons, b->polygon_count);
    const char *fault = "";
    cr_assert_eq(building_check(b, &arena, &fault, 1), 0, "%s", fault);
    arena_free(&arena);
}

// As above, with a wall of 0.2 m and the leaf in the middle of it, in no plane of the wall.
static Building *rooms_with_doorway(Arena *arena) {
    const double hole[2] = {1, 2};
    Building *b = closed_room(arena, vec3(8, 3, 2.5));
    for (int side = 0; side < 2; side++)
        soup_fixture_wall(arena, b, 0, 5 + 0.2 * side, 0, 3, 0, 2.5, hole, 1, 2.1);
    for (int k = 0; k < 2; k++) soup_fixture_wall(arena, b, 1, hole[k], 5, 5.2, 0, 2.1, NULL, 0, 0);
    soup_fixture_quad(arena, b, vec3(5, 1, 2.1), vec3(5.2, 1, 2.1), vec3(5.2, 2, 2.1), vec3(5, 2, 2.1), 0);
    building_add_object(arena, b, OBJECT_FURNITURE, "door");
    soup_fixture_box(arena, b, vec3(5.08, 1.01, 0.01), vec3(5.12, 1.99, 2.09), 0);
    soup_find_doors(arena, b);
    return b;
}

// Proves that doors hide nothing while open, and all that is behind them while closed: each portal in the door's plane is
// the door's and has a plug.
Test(soup_doors, close_the_view) {
    Arena arena = {0};
    Building *b = rooms_with_doorway(&arena);
    CellGraph g = make(&arena, b);
    cr_assert(connected(&g, vec3(2, 1, 1), vec3(7, 1, 1)));
    int doors = 0, plugs = 0;
    for (int p = 0; p < g.portal_count; p++) doors += g.portals[p].door == 0;
    for (int i = 0; i < g.object_count; i++) plugs += g.objects[i].plug;
    cr_assert(doors == 1 && plugs == 1, "%d portals, %d plugs", doors, plugs);
    VisOptions options = vis_default_options();
    StabForest forest;
    cr_assert(vis_build_forest(&g, &options, NULL, &arena, &forest));
    VisQuery *query = vis_query_new(&g, &forest, &arena);
    Eye eye = {.position = vec3(2, 1.5, 1.5)};
    float open = 0;
    int behind = vis_locate(&g, vec3(7, 1.5, 1), -1);
    for (int i = 0; i < 2; i++, open = 0.1f) {
        VisResult r = vis_query(query, &eye, vis_locate(&g, eye.position, -1), &open, CULL_STAB);
        bool seen = false;
        for (int k = 0; k < r.cell_count; k++) seen = seen || r.cells[k].cell == behind;
        cr_assert_eq(seen, i == 1);
    }
    arena_free(&arena);
}

// ---- stability

// Which polygons lie in cells that see each other: bit b of row a.
static uint64_t *polygon_pairs(Arena *arena, const Building *b, const PairMethod *method, int *words) {
    CellGraph g = make(arena, b);
    PairOptions options = {.threads = 1};
    PairSet set;
    method->find(&g, &options, NULL, arena, &set);
    int count = b->object_count;
    *words = (count + 63) / 64;
    unsigned char *in = ARENA_ARRAY(arena, unsigned char, (size_t)g.cell_count *(size_t)count);
    for (int c = 0; c < g.cell_count; c++) {
        const CellMesh *mesh = &g.meshes[c];
        int end = g.square_first[mesh->first_square + mesh->nx * mesh->ny];
        for (int k = g.square_first[mesh->first_square]; k < end; k++) {
            if (g.square_objects[k] < count) in[c * count + g.square_objects[k]] = 1;
        }
    }
    uint64_t *pairs = ARENA_ARRAY(arena, uint64_t, (size_t)count * (size_t)*words);
    for (int c = 0; c < g.cell_count; c++) {
        for (int d = 0; d < g.cell_count; d++) {
            if (!pair_bit(set.seen, set.words, c, d)) continue;
            for (int a = 0; a < count; a++) {
                for (int e = 0; in[c * count + a] && e < count; e++) {
                    if (in[d * count + e]) pairs[a * *words + e / 64] |= (uint64_t)1 << (e % 64);
                }
            }
        }
    }
    return pairs;
}

// An object for each polygon, so that the squares tell where each lies.
static Building *one_by_one(Arena *arena, const Building *b) {
    Building *split = ARENA_ARRAY(arena, Building, 1);
    *split = *b;
    split->objects = NULL;
    split->object_count = split->object_capacity = 0;
    for (int p = 0; p < b->polygon_count; p++) {
        building_add_object(arena, split, OBJECT_FURNITURE, "");
        split->objects[p].first_polygon = p;
        split->objects[p].polygon_count = 1;
    }
    return split;
}

static void check_stable(const Building *b, const PairMethod *method, Random *random, uint64_t seed) {
    Arena arena = {0};
    int words;
    const uint64_t *expected = polygon_pairs(&arena, b, method, &words);
    Vec3 axis = fixture_direction(random), far = vec3_scale(fixture_direction(random), 1e6);
    double angle = random_between(random, 0.1, 6);
    const SoupPose poses[] = {{1, angle, {0, 0, 1}, {0, 0, 0}},
                              {1, angle, axis, {0, 0, 0}},
                              {1e-3, 0, axis, {0, 0, 0}},
                              {1e3, 0, axis, {0, 0, 0}},
                              {1, 0, axis, far},
                              {1e-3, angle, axis, {1, 2, 3}},
                              {1, angle, axis, far}};
    for (size_t i = 0; i < sizeof poses / sizeof *poses; i++) {
        const uint64_t *found =
            polygon_pairs(&arena, soup_fixture_posed(&arena, b, &poses[i]), method, &words);
        for (int k = 0; k < b->object_count * words; k++)
            cr_assert_eq(found[k], expected[k], "seed %llu, pose %zu, %s: polygon %d",
                         (unsigned long long)seed, i, method->name, k / words);
    }
    arena_free(&arena);
}

// Proves that the pairs of polygons that see each other are the same however the building is turned, scaled and shifted,
// by the methods that know no upright direction.
Test(soup, is_stable) {
    static const char *const methods[] = {"flood", "flow"};
    for (uint64_t seed = 0; seed <= 12; seed++) {
        Arena arena = {0};
        Random random = {seed};
        const Building *drawn = seed == 0   ? soup_fixture_read(&arena, "twoRoom.quads", "two-rooms.quads")
                                : seed == 1 ? soup_fixture_read(&arena, "boxA.quads", "boxes.quads")
                                            : soup_fixture_house(&arena, &random, 3, 2);
        const Building *b = one_by_one(&arena, drawn);
        for (int i = 0; i < 2; i++) {
            const PairMethod *method = pair_method(methods[i]);
            if (method) check_stable(b, method, &random, seed);
        }
        arena_free(&arena);
    }
}
