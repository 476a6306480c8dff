// test_soup.c - cells and portals found among polygons alone, against lines through cells and polygons.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/visibility/soup/soup_checks.h"
#include "visibility/soup/soup.h"

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
        soup_extent_of(cell, (Plane){n, 0}, &low, &high);
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
            soup_extent_of(cell, plane, &low, &high);
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
                soup_expect_polyhedron(&soup, part[side]);
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
