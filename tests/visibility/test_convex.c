// test_convex.c - plan polygons with holes cut into convex pieces, by either way of triangulating, and floors into what tiles leave of
// them: nothing lost, nothing twice.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/maps.h"
#include "tests/support/support.h"
#include "visibility/cells/convex.h"
#include "visibility/vis.h"

enum { HOLE = 5 };  // corners

// A room with a raster of holes, each a pentagon in a square of 1 m, at whole millimetres.
typedef struct Holey {
    Arena arena;
    Vec2 *points;
    int *first, *size;
    int rings, count, side;  // side: metres
} Holey;

static Vec2 snap(double x, double y) { return vec2(nearbyint(x * 1000) / 1000, nearbyint(y * 1000) / 1000); }

static Holey make(Random *r, int side, int holes, Vec2 shift) {
    Holey h = {.side = side, .rings = 1 + holes};
    h.points = ARENA_ARRAY(&h.arena, Vec2, 4 + HOLE * holes);
    h.first = ARENA_ARRAY(&h.arena, int, h.rings);
    h.size = ARENA_ARRAY(&h.arena, int, h.rings);
    for (int i = 0; i < 4; i++)
        h.points[h.count++] = snap(shift.x + (i == 1 || i == 2) * side, shift.y + i / 2 * side);
    h.size[0] = 4;
    for (int k = 0; k < holes; k++) {
        Vec2 middle = vec2_add(shift, vec2(k % side + 0.5, (double)(k / side) + 0.5));
        double radius = random_between(r, 0.05, 0.499), turn = random_between(r, 0, 7);
        h.first[k + 1] = h.count;
        h.size[k + 1] = HOLE;
        for (int i = 0; i < HOLE; i++) {  // clockwise; now and then with a dent
            double angle = turn - 2 * M_PI * i / HOLE, far = random_index(r, 4) ? radius : radius / 4;
            h.points[h.count++] = snap(middle.x + far * cos(angle), middle.y + far * sin(angle));
        }
    }
    return h;
}

static double ring_area(const Vec2 *p, int count) {
    double area = 0;
    for (int i = 1; i + 1 < count; i++)
        area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
    return area;
}

static double area_of(const Holey *h) {
    double area = 0;
    for (int i = 0; i < h->rings; i++) area += ring_area(h->points + h->first[i], h->size[i]);
    return area;
}

static bool in_ring(const Vec2 *p, int count, Vec2 at) {
    bool inside = false;
    for (int i = 0, j = count - 1; i < count; j = i++)
        if ((p[i].y > at.y) != (p[j].y > at.y) &&
            at.x < p[i].x + (at.y - p[i].y) * (p[j].x - p[i].x) / (p[j].y - p[i].y))
            inside = !inside;
    return inside;
}

// Points at random lie in one piece where they are in the room and in no hole, else in none.
static void expect_cover(const Holey *h, Random *r, const Vec2 *pieces, const int *first, int count) {
    for (int i = 0; i < 300; i++) {
        Vec2 at = vec2_add(h->points[0], vec2(random_between(r, -0.5, h->side + 0.5),
                                              random_between(r, -0.5, h->side + 0.5)));
        int in = 0;
        bool free = false;
        for (int k = 0; k < h->rings; k++) free ^= in_ring(h->points + h->first[k], h->size[k], at);
        for (int k = 0; k < count; k++) in += in_ring(pieces + first[k], first[k + 1] - first[k], at);
        cr_assert_eq(in, free, "(%g, %g) is in %d pieces, and %s", at.x, at.y, in, free ? "free" : "solid");
    }
}

// Convex pieces that turn to the left and have the area of the whole. Tolerance: sums of products of a few thousand corners.
static void expect_pieces(const Holey *h, Random *r, const Vec2 *pieces, const int *first, int count) {
    double sum = 0;
    for (int k = 0; k < count; k++) {
        const Vec2 *p = pieces + first[k];
        int n = first[k + 1] - first[k];
        cr_assert_geq(n, 3);
        for (int i = 0; i < n; i++) {
            Vec2 a = p[i], b = p[(i + 1) % n], c = p[(i + 2) % n];
            // A thousandth of a square millimetre: corners are whole millimetres but for their last bits.
            cr_assert_geq(vec2_cross(vec2_sub(b, a), vec2_sub(c, b)), -1e-9, "piece %d bends inwards", k);
        }
        double area = ring_area(p, n);
        cr_assert_gt(area, 0);
        sum += area;
    }
    cr_assert_float_eq(sum, area_of(h), 1e-6, "%g m^2 in %d pieces of %g", sum, count, area_of(h));
    expect_cover(h, r, pieces, first, count);
}

// Proves that rooms of no holes, some, and more than the fat triangulation takes (1,000) fall into convex pieces that cover them once.
Test(convex, pieces_cover_the_polygon_once) {
    static const int HOLES[] = {0, 1, 7, 60, 999, 1000, 1500};
    Random r = {5};
    for (int i = 0; i < 7; i++) {
        int side = (int)ceil(sqrt(HOLES[i])) + 1;
        Holey h = make(&r, side, HOLES[i], i % 2 ? vec2(-70.001, 312.5) : vec2(0, 0));
        ConvexPieces out;
        Error error = {""};
        cr_assert(convex_decompose(h.points, h.first, h.size, h.rings, &h.arena, &out, &error), "%s",
                  error.text);
        Vec2 *pieces = ARENA_ARRAY(&h.arena, Vec2, out.first[out.count]);
        for (int k = 0; k < out.first[out.count]; k++) pieces[k] = h.points[out.vertex[k]];
        expect_pieces(&h, &r, pieces, out.first, out.count);
        arena_free(&h.arena);
    }
}

// Proves the same of the triangles of the sweep alone, whose number Euler's formula tells: corners + 2 * holes - 2.
Test(convex, the_sweep_covers_the_polygon_once) {
    Random r = {6};
    for (int i = 0; i < 40; i++) {
        int holes = i * 3;
        Holey h = make(&r, (int)ceil(sqrt(holes)) + 1, holes, vec2(0, 0));
        int(*edges)[2] = arena_alloc(&h.arena, (size_t)h.count, sizeof *edges), *triangles, n = 0;
        Vec2 *whole = ARENA_ARRAY(&h.arena, Vec2, h.count);
        for (int k = 0; k < h.rings; k++) {
            for (int c = 0; c < h.size[k]; c++, n++) {
                whole[n] = vec2(nearbyint(h.points[n].x * 1000), nearbyint(h.points[n].y * 1000));
                edges[n][0] = n;
                edges[n][1] = h.first[k] + (c + 1) % h.size[k];
            }
        }
        int count = convex_sweep(whole, (const int(*)[2])edges, n, &h.arena, &triangles);
        cr_assert_eq(count, n + 2 * holes - 2, "%d triangles of %d corners, %d holes", count, n, holes);
        Vec2 *pieces = ARENA_ARRAY(&h.arena, Vec2, 3 * count);
        int *first = ARENA_ARRAY(&h.arena, int, count + 1);
        for (int k = 0; k < 3 * count; k++) pieces[k] = h.points[triangles[k]];
        for (int k = 0; k <= count; k++) first[k] = 3 * k;
        expect_pieces(&h, &r, pieces, first, count);
        arena_free(&h.arena);
    }
}

// Proves that edges which are no polygon are refused: one that runs the wrong way, and one that is missing.
Test(convex, the_sweep_refuses_what_is_no_polygon) {
    Arena arena = {0};
    const Vec2 square[4] = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    const int backwards[4][2] = {{0, 3}, {3, 2}, {2, 1}, {1, 0}}, open[3][2] = {{0, 1}, {1, 2}, {2, 3}};
    int *triangles;
    cr_expect_eq(convex_sweep(square, backwards, 4, &arena, &triangles), -1);
    cr_expect_eq(convex_sweep(square, open, 3, &arena, &triangles), -1);
    arena_free(&arena);
}

// ---- floors with much let into them

static double floor_area(const CellGraph *g, bool surfaces) {
    double area = 0;
    for (int o = surfaces ? g->surface_first[0] : 0; o < (surfaces ? g->object_count : g->surface_first[0]);
         o++) {
        for (int p = g->objects[o].first_polygon;
             p < g->objects[o].first_polygon + g->objects[o].polygon_count; p++) {
            const Vec3 *v = g->vertices + g->polygons[p].first_vertex;
            if (v[0].z == 0 && v[1].z == 0 && v[2].z == 0)
                area += polygon_area(v, g->polygons[p].vertex_count);
        }
    }
    return area;
}

static int polygons_at(const CellGraph *g, Vec2 at) {
    int found = 0;
    for (int p = 0; p < g->polygon_count; p++) {
        const Vec3 *v = g->vertices + g->polygons[p].first_vertex;
        Vec2 ring[64];
        int count = g->polygons[p].vertex_count;
        for (int i = 0; i < count && i < 64; i++) ring[i] = vec2(v[i].x, v[i].y);
        found += v[0].z == 0 && v[1].z == 0 && v[2].z == 0 && count <= 64 && in_ring(ring, count, at);
    }
    return found;
}

// Proves that a floor and hundreds of tiles let into it cover the room once, near the origin and far from it, in long rooms and in a
// deep one: more than MANY of them, so that pieces are looked for by squares (surfaces.c).
Test(convex, tiles_and_the_floor_cover_the_room_once) {
    static const struct {
        int x, y, nx, ny;
    } ROOMS[] = {{0, 0, 20, 15}, {-70, 200, 50, 6}, {300, -90, 5, 60}, {-70, -40, 35, 10}};
    Random r = {7};
    for (int k = 0; k < 4; k++) {
        Arena arena = {0};
        Building b;
        CellGraph g;
        Error error = {""};
        VisOptions options = vis_default_options();
        const char *path = arena_format(&arena, "%s/tiles.plan", support_folder(&arena));
        FILE *f = fopen(path, "w");
        int x = ROOMS[k].x, y = ROOMS[k].y, right = x + ROOMS[k].nx, top = y + ROOMS[k].ny;
        fprintf(f,
                "plan 1\nmaterial tile #aa5533\nstorey s floor 0 height 2.5\nroom a %d,%d %d,%d %d,%d %d,%d "
                "wall 0.2\n",
                x, y, right, y, right, top, x, top);
        for (int i = 0; i < ROOMS[k].nx * ROOMS[k].ny; i++) {
            double radius = random_between(&r, 0.05, 0.5), turn = random_between(&r, 0, 7);
            int corners = 3 + random_index(&r, 4);
            fputs("inlay tile floor", f);
            for (int c = 0; c < corners; c++) {
                double angle = turn + 2 * M_PI * c / corners;
                fprintf(f, " %.3f,%.3f", x + i % ROOMS[k].nx + 0.5 + radius * cos(angle),
                        y + i / ROOMS[k].nx + 0.5 + radius * sin(angle));
            }
            fputs("\n", f);
        }
        fclose(f);
        cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
        cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
        double tiles = floor_area(&g, false), floor = floor_area(&g, true), room = ROOMS[k].nx * ROOMS[k].ny;
        cr_assert_eq(b.inlay_count, (int)room);
        // Tolerance: slivers of up to VIS_SLIVER are left out, a few for each tile.
        cr_assert_float_eq(tiles + floor, room, 1e-6 + 8 * VIS_SLIVER * room,
                           "tiles %.9g, floor %.9g of %g m^2", tiles, floor, room);
        for (int i = 0; i < 500; i++) {
            Vec2 at = vec2(random_between(&r, x, right), random_between(&r, y, top));
            cr_assert_eq(polygons_at(&g, at), 1, "%d polygons of the floor at (%g, %g)", polygons_at(&g, at),
                         at.x, at.y);
        }
        arena_free(&arena);
    }
}

// Proves it of rows of holes that touch each other at their corners: several corners in one place.
Test(convex, holes_that_touch) {
    enum { SIDE = 6, COUNT = 4 + 4 * SIDE * SIDE };
    Random r = {8};
    Holey h = {.side = SIDE + 2, .rings = 1, .count = 4};
    h.points = ARENA_ARRAY(&h.arena, Vec2, COUNT);
    h.first = ARENA_ARRAY(&h.arena, int, 1 + SIDE * SIDE);
    h.size = ARENA_ARRAY(&h.arena, int, 1 + SIDE * SIDE);
    h.size[0] = 4;
    for (int i = 0; i < 4; i++) h.points[i] = vec2((i == 1 || i == 2) * h.side, i / 2 * h.side);
    for (int k = 0; k < SIDE * SIDE; k++, h.rings++) {
        h.first[h.rings] = h.count;
        h.size[h.rings] = 4;
        double x = k % SIDE + 1.5, y = k / SIDE + 1.5;
        h.points[h.count++] = vec2(x - 0.5, y);
        h.points[h.count++] = vec2(x, y + 0.4);
        h.points[h.count++] = vec2(x + 0.5, y);
        h.points[h.count++] = vec2(x, y - 0.4);
    }
    int(*edges)[2] = arena_alloc(&h.arena, COUNT, sizeof *edges), *triangles, first[3 * COUNT];
    Vec2 whole[COUNT], pieces[3 * 3 * COUNT];
    for (int k = 0, n = 0; k < h.rings; k++) {
        for (int c = 0; c < h.size[k]; c++, n++) {
            whole[n] = vec2(1000 * h.points[n].x, 1000 * h.points[n].y);
            edges[n][0] = n;
            edges[n][1] = h.first[k] + (c + 1) % h.size[k];
        }
    }
    int count = convex_sweep(whole, (const int(*)[2])edges, COUNT, &h.arena, &triangles);
    cr_assert(count > 0 && count < 3 * COUNT, "%d", count);
    for (int k = 0; k < 3 * count; k++) pieces[k] = h.points[triangles[k]];
    for (int k = 0; k <= count; k++) first[k] = 3 * k;
    expect_pieces(&h, &r, pieces, first, count);
    arena_free(&h.arena);
}
