// test_enclose_arrange.c - the arrangement of many lines, held against what an arrangement is, and against GEOS.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/core/random.h"
#include "maps/enclose/enclose.h"

// ---- the parts of a plan

static Vec2 half_start(const Plan *p, int h) { return p->vertices[half_from(p, h)]; }
static Vec2 half_end(const Plan *p, int h) { return p->vertices[half_to(p, h)]; }

static double side(Vec2 a, Vec2 b, Vec2 p) { return vec2_cross(vec2_sub(b, a), vec2_sub(p, a)); }

// Two edges have no point in common but vertices of both. Coordinates are small whole numbers: signs are exact.
static bool edges_meet_wrongly(const Plan *p, int i, int j) {
    Vec2 a = half_start(p, 2 * i), b = half_end(p, 2 * i), c = half_start(p, 2 * j), d = half_end(p, 2 * j);
    double ac = side(a, b, c), ad = side(a, b, d), ca = side(c, d, a), cb = side(c, d, b);
    if (ac * ad < 0 && ca * cb < 0) return true;
    const Vec2 ends[4][3] = {{a, b, c}, {a, b, d}, {c, d, a}, {c, d, b}};
    for (int k = 0; k < 4; k++) {
        Vec2 u = vec2_sub(ends[k][2], ends[k][0]), v = vec2_sub(ends[k][1], ends[k][0]);
        if (vec2_cross(u, v) == 0 && vec2_dot(u, v) > 0 && vec2_dot(u, v) < vec2_dot(v, v)) return true;
    }
    return false;
}

static bool face_holds(const Plan *p, const PlanFace *face, Vec2 at) {
    bool in = false;
    for (int k = 0; k < face->half_count; k++) {
        int h = p->halves[face->first_half + k];
        Vec2 a = half_start(p, h), b = half_end(p, h);
        if ((a.y > at.y) != (b.y > at.y) && side(a, b, at) * (b.y > a.y ? 1 : -1) > 0) in = !in;
    }
    return in;
}

static int by_area(const void *p, const void *q) {
    double a = *(const double *)p, b = *(const double *)q;
    return (a > b) - (a < b);
}

// ---- lines

enum { SIZE = 60, RINGS = 40 };

static Line ring(Vec2 *points, int count) { return (Line){points, count, true}; }

// The border, and quadrilaterals of any form within it; upright rectangles only, if `upright`.
static int random_lines(Random *random, bool upright, Arena *arena, Line *lines) {
    Vec2 *p = ARENA_ARRAY(arena, Vec2, 4 * (RINGS + 1));
    p[0] = vec2(-1, -1), p[1] = vec2(SIZE, -1), p[2] = vec2(SIZE, SIZE), p[3] = vec2(-1, SIZE);
    for (int i = 1; i <= RINGS; i++) {
        Vec2 *q = p + 4 * i;
        int reach = i % 2 ? 6 : SIZE - 1;
        for (int k = 0; k < 4; k++) {
            q[k] = vec2(random_index(random, reach), random_index(random, reach));
            q[k] =
                vec2_add(q[k], vec2(random_index(random, SIZE - reach), random_index(random, SIZE - reach)));
        }
        if (upright) q[1] = vec2(q[2].x, q[0].y), q[3] = vec2(q[0].x, q[2].y);
    }
    for (int i = 0; i <= RINGS; i++) lines[i] = ring(p + 4 * i, 4);
    lines[RINGS].close = false;  // one that encloses nothing by itself
    return RINGS + 1;
}

// Proves that no two edges cross, that each edge has two faces and each point one, that the areas of faces are those of their outlines
// and together that of the border, and that neither loose ends nor edges with one face on both sides are left.
Test(enclose_arrange, is_an_arrangement) {
    Random random = {7};
    for (int round = 0; round < 40; round++) {
        Arena arena = {0};
        Enclosure e = {.scratch = &arena};
        Line lines[RINGS + 1];
        Plan p;
        int count = random_lines(&random, false, &arena, lines);
        plan_arrange(&e, lines, count, &p);
        for (int i = 0; i < p.edge_count; i++) {
            cr_expect_neq(p.edges[i].face[0], p.edges[i].face[1]);
            for (int j = 0; j < i; j++) cr_expect(!edges_meet_wrongly(&p, i, j), "edges %d, %d", i, j);
        }
        double sum = 0;
        for (int f = 0; f < p.face_count; f++) {
            double area = 0;
            for (int k = 0; k < p.faces[f].half_count; k++) {
                int h = p.halves[p.faces[f].first_half + k];
                area += vec2_cross(half_start(&p, h), half_end(&p, h)) / 2;
                cr_expect_eq(half_left(&p, h), f);
            }
            cr_expect(area > 0 && fabs(area - p.faces[f].area) < 1e-6);
            sum += area;
        }
        cr_expect_float_eq(sum, (SIZE + 1) * (SIZE + 1), 1e-6);
        for (int k = 0; k < 300; k++) {
            // Between grid points, on no edge: an edge through it would have 1000 units either way.
            Vec2 at = vec2(random_index(&random, SIZE) - 0.4987, random_index(&random, SIZE) - 0.5003);
            int in = 0;
            for (int f = 0; f < p.face_count; f++) in += face_holds(&p, &p.faces[f], at);
            cr_expect_eq(in, 1, "%d faces at %g, %g", in, at.x, at.y);
        }
        arena_free(&arena);
    }
}

// Proves that faces are those that GEOS makes of the same lines, which all lie on the grid and cross there.
Test(enclose_arrange, is_that_of_geos) {
    Random random = {11};
    GEOSContextHandle_t geos = GEOS_init_r();
    for (int round = 0; round < 40; round++) {
        Arena arena = {0};
        Enclosure e = {.scratch = &arena, .geos = geos};
        Line lines[RINGS + 1];
        Plan p;
        int count = random_lines(&random, true, &arena, lines);
        plan_arrange(&e, lines, count, &p);
        GEOSGeometry *items[RINGS + 1];
        for (int i = 0; i < count; i++) {
            unsigned points = (unsigned)lines[i].count + lines[i].close;
            GEOSCoordSequence *s = GEOSCoordSeq_create_r(geos, points, 2);
            for (unsigned k = 0; k < points; k++) {
                Vec2 at = lines[i].points[k % (unsigned)lines[i].count];
                GEOSCoordSeq_setXY_r(geos, s, k, at.x, at.y);
            }
            items[i] = GEOSGeom_createLineString_r(geos, s);
        }
        GEOSGeometry *all = GEOSGeom_createCollection_r(geos, GEOS_MULTILINESTRING, items, (unsigned)count),
                     *noded = GEOSUnaryUnionPrec_r(geos, all, 1);
        const GEOSGeometry *list[1] = {noded};
        GEOSGeometry *faces = GEOSPolygonize_r(geos, list, 1);
        int face_count = GEOSGetNumGeometries_r(geos, faces);
        cr_assert_eq(face_count, p.face_count, "%d faces, of GEOS %d", p.face_count, face_count);
        double *own = ARENA_ARRAY(&arena, double, face_count),
               *theirs = ARENA_ARRAY(&arena, double, face_count);
        for (int f = 0; f < face_count; f++) {
            own[f] = p.faces[f].area;
            GEOSArea_r(geos, GEOSGetGeometryN_r(geos, faces, f), &theirs[f]);
        }
        qsort(own, (size_t)face_count, sizeof *own, by_area);
        qsort(theirs, (size_t)face_count, sizeof *theirs, by_area);
        for (int f = 0; f < face_count; f++) cr_expect_float_eq(own[f], theirs[f], 1e-6);
        GEOSGeometry *made[3] = {all, noded, faces};
        for (int i = 0; i < 3; i++) GEOSGeom_destroy_r(geos, made[i]);
        arena_free(&arena);
    }
    GEOS_finish_r(geos);
}
