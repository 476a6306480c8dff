// test_proxy.c - stand-ins for fine furniture: near the model, closed, few; lamps and light kept; the fine model lit from them.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "radiosity/show/reconstruct.h"
#include "tests/radiosity/mesh/proxy_fixture.h"
#include "tests/support/lit_fixture.h"

static int object_named(const Lit *lit, const char *name) {
    for (int o = 0; o < lit->graph.object_count; o++)
        if (strcmp(lit->graph.objects[o].name, name) == 0) return o;
    cr_assert_fail("no object %s", name);
    return -1;
}

static double distance_to_triangle(Vec3 a, Vec3 b, Vec3 c, Vec3 p) {
    Vec3 v[3] = {a, b, c}, n = vec3_normalize(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
    double nearest = INFINITY;
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        Vec3 along = vec3_sub(v[(k + 1) % 3], v[k]), off = vec3_sub(p, v[k]);
        double t = fmin(fmax(vec3_dot(off, along) / vec3_dot(along, along), 0), 1);
        nearest = fmin(nearest, vec3_length(vec3_sub(off, vec3_scale(along, t))));
        inside = inside && vec3_dot(n, vec3_cross(along, off)) >= 0;
    }
    return inside ? fabs(vec3_dot(n, vec3_sub(p, a))) : nearest;
}

static double distance_to(const Proxies *proxies, int object, Vec3 p) {
    double nearest = INFINITY;
    for (int i = proxies->first[object]; i < proxies->first[object + 1]; i++) {
        const Vec3 *v = proxies->vertices + proxies->polygons[i].first_vertex;
        for (int k = 1; k + 1 < proxies->polygons[i].vertex_count; k++)
            nearest = fmin(nearest, distance_to_triangle(v[0], v[k], v[k + 1], p));
    }
    return nearest;
}

// Proves that nothing of a model is farther from its stand-in than the tolerance, that the stand-in has but corners of the model,
// and far fewer polygons. A bend of merged polygons, half of MAPS_PLANARITY, comes on top.
Test(proxy, stays_near) {
    Lit *lit = proxy_furnished();
    static const double TOLERANCES[] = {0.005, 0.0125, 0.03};
    int before = INT32_MAX;
    for (int t = 0; t < 3; t++) {
        const Proxies *proxies = proxy_proxies_of(lit, TOLERANCES[t]);
        int ball = object_named(lit, "ball");
        const Object *object = &lit->graph.objects[ball];
        cr_assert_not_null(proxies);
        double farthest = 0;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            const Polygon *polygon = &lit->graph.polygons[p];
            cr_expect(proxies->replaced[p]);
            for (int k = 0; k < polygon->vertex_count; k++)
                farthest = fmax(farthest,
                                distance_to(proxies, ball, lit->graph.vertices[polygon->first_vertex + k]));
        }
        cr_expect_leq(farthest, TOLERANCES[t] + MAPS_PLANARITY / 2);
        int count = proxies->first[ball + 1] - proxies->first[ball];
        cr_expect(count < before && count >= 12, "%d polygons", count);
        before = count;
        for (int i = proxies->first[ball]; i < proxies->first[ball + 1]; i++) {
            const Vec3 *v = proxies->vertices + proxies->polygons[i].first_vertex;
            for (int k = 0; k < proxies->polygons[i].vertex_count; k++)
                cr_expect_float_eq(vec3_length(vec3_sub(v[k], BALL)), RADIUS, 1e-9);
        }
    }
    cr_expect_leq(before, 2048 / 10);
    lit_free(lit);
}

// Proves that what was closed is closed: every edge of a stand-in has another the other way round.
Test(proxy, stays_closed) {
    Lit *lit = proxy_furnished();
    const Proxies *proxies = proxy_proxies_of(lit, 0.02);
    static const char *const NAMES[] = {"ball", "panel"};
    for (int n = 0; n < 2; n++) {
        int object = object_named(lit, NAMES[n]);
        for (int i = proxies->first[object]; i < proxies->first[object + 1]; i++) {
            const Polygon *p = &proxies->polygons[i];
            for (int k = 0; k < p->vertex_count; k++) {
                Vec3 a = proxies->vertices[p->first_vertex + k];
                Vec3 b = proxies->vertices[p->first_vertex + (k + 1) % p->vertex_count];
                int twins = 0;
                for (int j = proxies->first[object]; j < proxies->first[object + 1]; j++) {
                    const Polygon *q = &proxies->polygons[j];
                    for (int m = 0; m < q->vertex_count; m++)
                        twins +=
                            vec3_equal(proxies->vertices[q->first_vertex + m], b) &&
                            vec3_equal(proxies->vertices[q->first_vertex + (m + 1) % q->vertex_count], a);
                }
                cr_expect_eq(twins, 1);
            }
        }
    }
    lit_free(lit);
}

// Proves that a panel thinner than the tolerance neither vanishes nor gets a hole: both its sides keep their area, to the bend of its
// edges, and face the way they did.
Test(proxy, panels_stay) {
    Lit *lit = proxy_furnished();
    const Proxies *proxies = proxy_proxies_of(lit, 0.02);
    int panel = object_named(lit, "panel");
    double up = 0, down = 0, area = (PANEL.max.x - PANEL.min.x) * (PANEL.max.y - PANEL.min.y);
    cr_assert_lt(THICK, 0.02);
    for (int i = proxies->first[panel]; i < proxies->first[panel + 1]; i++) {
        const Polygon *p = &proxies->polygons[i];
        const Vec3 *v = proxies->vertices + p->first_vertex;
        double upright = plane_of_polygon(v, p->vertex_count).n.z * polygon_area(v, p->vertex_count);
        *(upright > 0 ? &up : &down) += fabs(upright);
    }
    cr_expect_float_eq(up, area, 0.03 * area);
    cr_expect_float_eq(down, area, 0.03 * area);
    cr_expect_leq(proxies->first[panel + 1] - proxies->first[panel], 40);
    lit_free(lit);
}
