// test_sky.c - daylight: closed forms outdoors, path tracing indoors; that it does not depend on culling or threads, that nothing is
// lost, and that the file remembers it.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/app/bake_probes.h"
#include "radiosity/show/reconstruct.h"
#include "tests/radiosity/shoot/sky_fixture.h"
#include "tests/support/lit_fixture.h"

// Proves that a lone square gets pi L from above, half of it standing, nothing from below; and that a probe there is told so.
Test(sky, lone_squares) {
    Lit *lit = lit_new();
    lit_quad(lit, vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0), LIT_WALL);
    lit_quad(lit, vec3(50, 0, 0), vec3(50, 1, 0), vec3(50, 1, 1), vec3(50, 0, 1), LIT_WALL);
    lit_quad(lit, vec3(0, 50, 0), vec3(0, 51, 0), vec3(1, 51, 0), vec3(1, 50, 0), LIT_WALL);
    lit_finish(lit, 0.5, 2);
    RadOptions options = sky_options_of(CULL_STAB, 1);
    RadSolution s = sky_shone(lit, &options);
    static const double SHARE[3] = {1, 0.5, 0};
    for (int e = 0; e < lit->mesh.element_count; e++) {
        double share = SHARE[lit->mesh.elements[e].face];
        // Half of the pixels of a disc: to one in a thousand of them.
        cr_assert_float_eq(s.radiosity[e][1], 0.5 * M_PI * 20 * share, 0.001 * M_PI * 20, "face %d: %g",
                           lit->mesh.elements[e].face, s.radiosity[e][1]);
    }
    sky_check_conserved(lit, &s);
    Arena arena = {0};
    Probes probes = {0};
    Error error = {""};
    cr_assert(bake_probe_parse("0.5,0.5,0,0,0,1", &arena, &probes, &error));
    cr_assert(bake_probe_parse("50,0.5,0.5,1,0,0", &arena, &probes, &error));
    cr_assert(bake_probe_parse("0.5,0.5,5,0.6,0,0.8", &arena, &probes, &error));
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, &s, NULL}, 1, &probes);
    // The square that stands is seen by a sliver from the one that lies, and the other way round.
    cr_assert_float_eq(probes.probes[0].irradiance[2], 30 * M_PI, 0.01);
    cr_assert_float_eq(probes.probes[1].irradiance[2], 15 * M_PI, 0.01);
    cr_assert_float_eq(probes.probes[2].irradiance[0], 10 * M_PI * 0.9, 0.02);
    lit_free(lit);
    arena_free(&arena);
}

// Does any polygon of the building but glass stand in the way? All of them are asked.
static bool is_blocked(const CellGraph *g, Vec3 from, Vec3 way) {
    for (int i = 0; i < g->polygon_count; i++) {
        const Polygon *polygon = &g->polygons[i];
        if (g->building->materials[polygon->material].alpha < 1) continue;
        const Vec3 *v = g->vertices + polygon->first_vertex;
        Vec3 n = vec3_normalize(vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0])));
        double t = vec3_dot(n, vec3_sub(v[0], from)) / vec3_dot(n, way);
        if (!(t > 1e-5)) continue;
        Vec3 p = vec3_add(from, vec3_scale(way, t));
        bool inside = true;
        for (int k = 0; k < polygon->vertex_count && inside; k++) {
            Vec3 edge = vec3_sub(v[(k + 1) % polygon->vertex_count], v[k]);
            inside = vec3_dot(n, vec3_cross(edge, vec3_sub(p, v[k]))) >= 0;
        }
        if (inside) return true;
    }
    return false;
}

// The share of the hemisphere over a place, weighted by the cosine, in which the sky is seen: ray by ray.
static double sky_seen(const CellGraph *g, Vec3 place, Vec3 n) {
    enum { SIDE = 40 };
    Vec3 x, y, from = vec3_add(place, vec3_scale(n, 1e-6));
    int seen = 0;
    view_axes(n, &x, &y);
    for (int i = 0; i < SIDE * SIDE; i++) {
        // Even in the unit disc: rings of equal area.
        double r = sqrt((i / SIDE + 0.5) / SIDE), turn = 2 * M_PI * (i % SIDE + 0.5) / SIDE;
        Vec3 way = vec3_add(vec3_scale(x, r * cos(turn)), vec3_scale(y, r * sin(turn)));
        way = vec3_add(way, vec3_scale(n, sqrt(1 - r * r)));
        seen += way.z > 0 && !is_blocked(g, from, way);
    }
    return (double)seen / (SIDE * SIDE);
}

// Proves that the shade beside walls outdoors is that of rays, on the ground, on walls and behind them. Tolerance: 0.03, pixels of
// a disc of 48 across and rays on a grid. But where no more than a tenth of the sky is lost a patch of 2 m looks for all its
// elements, and those nearest to a wall may lose a fifth.
Test(sky, shade_beside_walls_outdoors) {
    Lit *lit = sky_read_plan_with("room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                                  "window w 2,-0.1 width 1 sill 0.9 height 1.3\n"
                                  "model wall\n  box -0.1,-2,0 0.1,2,2 white\nend\nplace wall 8,2\n"
                                  "place wall 5.5,-2 angle 60\n",
                                  0.5, 4);
    RadOptions options = sky_options_of(CULL_STAB, 1);
    RadSolution s = sky_shone(lit, &options);
    int shaded = 0, free = 0;
    for (int e = 0; e < lit->mesh.element_count; e += 7) {
        const Element *element = &lit->mesh.elements[e];
        const Patch *patch = &lit->mesh.patches[element->patch];
        const Face *face = &lit->mesh.faces[element->face];
        Vec3 place = element_centroid(&lit->mesh, e), n = face->plane.n;
        int cell = vis_locate(&lit->graph, vec3_add(place, vec3_scale(n, 1e-6)), -1);
        if (cell < 0 || vis_region(&lit->graph, cell)->kind != REGION_OUTDOORS) continue;
        double want = sky_seen(&lit->graph, place, n), open = 0.5 + 0.5 * n.z;
        double got =
            s.radiosity[e][1] / ((double)mesh_material(&lit->mesh, element->face)->reflectance.g * M_PI * 20);
        bool clear = sky_seen(&lit->graph, patch->centre, n) > 0.88 * open;
        cr_expect_float_eq(got, want, clear ? 0.2 * open : 0.03,
                           "%g instead of %g at %g,%g,%g, facing %g,%g,%g", got, want, place.x, place.y,
                           place.z, n.x, n.y, n.z);
        shaded += !clear;
        free += clear;
    }
    cr_assert(shaded > 50 && free > 300, "%d in shade, %d not", shaded, free);
    lit_free(lit);
}
