// test_soup_pieces.c - pieces of planes, and the planes of a soup.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/visibility/soup/soup_checks.h"
#include "visibility/soup/soup.h"

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
        cr_assert_float_eq(soup_make(&arena, b).touch, 4 * near, 1e-9 * near);
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
        soup_expect_polyhedron(&soup, soup.cells[0]);
        arena_free(&arena);
    }
}
