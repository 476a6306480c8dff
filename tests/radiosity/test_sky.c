// test_sky.c - daylight: closed forms outdoors, path tracing indoors; that it does not depend on culling or threads, that nothing is
// lost, and that the file remembers it.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/bake_probes.h"
#include "engine/core/file.h"
#include "maps/maps.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const double SKY[3] = {10, 20, 30};

static RadOptions options_of(Culling culling, int threads) {
    RadOptions options = rad_default_options();
    options.culling = culling;
    options.threads = threads;
    return options;
}

static RadSolution shone(Lit *lit, const RadOptions *options) {
    RadSolution s;
    Error error = {""};
    cr_assert(rad_start_dark(&lit->mesh, &lit->arena, &s, &error), "%s", error.text);
    cr_assert(rad_shine(&lit->mesh, &lit->forest, NULL, options, SKY, NULL, &s));
    return s;
}

static void check_kept(const RadSolution *s) {
    for (int c = 0; c < 3; c++) {
        double gone = s->absorbed[c] + s->escaped[c];
        cr_assert_leq(gone, s->emitted[c] * (1 + 1e-9));
    }
}

// Emitted light was absorbed, escaped, or is left.
static void check_conserved(const Lit *lit, const RadSolution *s) {
    for (int c = 0; c < 3; c++) {
        double left = 0;
        for (int p = 0; p < s->patch_count; p++) left += s->unshot[p][c] * lit->mesh.patches[p].area;
        double sum = s->absorbed[c] + s->escaped[c] + left;
        cr_assert_float_eq(sum, s->emitted[c], 1e-9 * s->emitted[c], "%.12g, not %.12g", sum, s->emitted[c]);
    }
    check_kept(s);
}

// Proves that a lone square gets pi L from above, half of it standing, nothing from below; and that a probe there is told so.
Test(sky, lone_squares) {
    Lit *lit = lit_new();
    lit_quad(lit, vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0), LIT_WALL);
    lit_quad(lit, vec3(50, 0, 0), vec3(50, 1, 0), vec3(50, 1, 1), vec3(50, 0, 1), LIT_WALL);
    lit_quad(lit, vec3(0, 50, 0), vec3(0, 51, 0), vec3(1, 51, 0), vec3(1, 50, 0), LIT_WALL);
    lit_finish(lit, 0.5, 2);
    RadOptions options = options_of(CULL_STAB, 1);
    RadSolution s = shone(lit, &options);
    static const double SHARE[3] = {1, 0.5, 0};
    for (int e = 0; e < lit->mesh.element_count; e++) {
        double share = SHARE[lit->mesh.elements[e].face];
        // Half of the pixels of a disc: to one in a thousand of them.
        cr_assert_float_eq(s.radiosity[e][1], 0.5 * M_PI * 20 * share, 0.001 * M_PI * 20, "face %d: %g",
                           lit->mesh.elements[e].face, s.radiosity[e][1]);
    }
    check_conserved(lit, &s);
    Arena arena = {0};
    Probes probes = {0};
    Error error = {""};
    cr_assert(bake_probe_parse("0.5,0.5,0,0,0,1", &arena, &probes, &error));
    cr_assert(bake_probe_parse("50,0.5,0.5,1,0,0", &arena, &probes, &error));
    cr_assert(bake_probe_parse("0.5,0.5,5,0.6,0,0.8", &arena, &probes, &error));
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, &s, NULL}, &probes);
    // The square that stands is seen by a sliver from the one that lies, and the other way round.
    cr_assert_float_eq(probes.probes[0].irradiance[2], 30 * M_PI, 0.01);
    cr_assert_float_eq(probes.probes[1].irradiance[2], 15 * M_PI, 0.01);
    cr_assert_float_eq(probes.probes[2].irradiance[0], 10 * M_PI * 0.9, 0.02);
    lit_free(lit);
    arena_free(&arena);
}

static Lit *read_plan_with(const char *rest, double element, int per_patch) {
    Lit *lit = lit_new();
    Error error = {""};
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/room.plan", support_folder(&arena));
    const char *text = arena_format(&arena,
                                    "plan 1\nmaterial white #E8E8E8\nmaterial oak #B08A5B\nmaterial grass "
                                    "#6F8F4E\nground grass height -0.2\nfacade white\n"
                                    "storey ground floor 0 height 2.5 slab 0.3\n%s",
                                    rest);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    *lit->building = (Building){0};
    path = arena_string(&lit->arena, path);
    cr_assert(maps_read(path, &lit->arena, lit->building, &error), "%s", error.text);
    arena_free(&arena);
    lit_finish(lit, element, per_patch);
    return lit;
}

static Lit *read_plan(const char *rest, double element) { return read_plan_with(rest, element, 2); }

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
    Lit *lit = read_plan_with("room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                              "window w 2,-0.1 width 1 sill 0.9 height 1.3\n"
                              "model wall\n  box -0.1,-2,0 0.1,2,2 white\nend\nplace wall 8,2\n"
                              "place wall 5.5,-2 angle 60\n",
                              0.5, 4);
    RadOptions options = options_of(CULL_STAB, 1);
    RadSolution s = shone(lit, &options);
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

// A room with one window of this size, a table before it, a garden and a wall out there.
static Lit *room_with_window(double width, double height, double element) {
    Arena arena = {0};
    const char *text =
        arena_format(&arena,
                     "room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                     "window w 4.1,1.5 angle 90 width %g sill 0.9 height %g\n"
                     "model table\n  box -0.4,-0.6,0 0.4,0.6,0.7 oak\nend\nplace table 2.6,1.4\n"
                     "model wall\n  box -0.1,-2,0 0.1,2,2 white\nend\nplace wall 8,2\n",
                     width, height);
    Lit *lit = read_plan(text, element);
    arena_free(&arena);
    return lit;
}

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

enum { POINTS = 24 };

// `make soak` looks at all points, `make test` at a third of them.
static int point_count(void) { return support_count(8, POINTS); }

// Relative errors of what points indoors gather, in order; points nearly in the dark aside.
static int errors_of(Lit *lit, const RadSolution *s, double errors[POINTS]) {
    Arena arena = {0};
    PathTracer *tracer = path_tracer_new(&lit->mesh, SKY, &arena);
    PathQuery queries[POINTS];
    PathResult truth[POINTS];
    Probes probes = {ARENA_ARRAY(&arena, Probe, POINTS), 0, POINTS};
    for (int i = 0; probes.count < point_count() && i < lit->mesh.patch_count; i++) {
        // Anywhere, by a stride that has no factor in common with most counts.
        const Patch *patch = &lit->mesh.patches[(long long)i * 7919 % lit->mesh.patch_count];
        if (patch->cell < 0 || vis_region(&lit->graph, patch->cell)->kind != REGION_ROOM) continue;
        Vec3 n = lit->mesh.faces[patch->face].plane.n;
        queries[probes.count] = (PathQuery){patch->centre, n, 0.003, 0, 1500000, (uint64_t)i};
        probes.probes[probes.count++] = (Probe){.place = patch->centre, .normal = n};
    }
    path_tracer_irradiance(tracer, queries, probes.count, 0, truth);
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, s, NULL}, &probes);
    int count = 0;
    for (int i = 0; i < probes.count; i++) {
        double h = truth[i].irradiance[1], e = probes.probes[i].irradiance[1] / h - 1;
        if (!(h > 0.01)) continue;
        printf("%6.3f %6.3f %6.3f: %9.5f +- %.5f, gathered %+.2f %%\n", queries[i].point.x,
               queries[i].point.y, queries[i].point.z, h, truth[i].standard_error[1], 100 * e);
        errors[count++] = fabs(e);
    }
    qsort(errors, (size_t)count, sizeof *errors, by_size);
    path_tracer_end(tracer);
    arena_free(&arena);
    return count;
}

static RadSolution lit_by_sky(Lit *lit, Culling culling, int threads) {
    RadOptions options = options_of(culling, threads);
    RadSolution s = shone(lit, &options);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    return s;
}

// Proves that a room with a window is lit as path tracing, which knows neither portals nor elements, has it. Tolerances: the bar
// for random points, a median of 2 %, and that no point is lost in the corners of elements of a quarter of a metre.
Test(sky, room_with_a_window, .timeout = 300) {
    Lit *lit = room_with_window(1.2, 1.3, 0.25);
    RadSolution s = lit_by_sky(lit, CULL_STAB, 0);
    double errors[POINTS];
    int count = errors_of(lit, &s, errors);
    cr_assert_geq(count, point_count() * 5 / 8);
    cr_assert_leq(errors[count / 2], 0.02, "median %.2f %%", 100 * errors[count / 2]);
    cr_assert_leq(errors[count - 1], 0.1, "at most %.2f %%", 100 * errors[count - 1]);
    check_conserved(lit, &s);
    lit_free(lit);
}

// Proves that light which comes in, goes out again and comes in once more counts once: a room looks through another one, of glass
// on both sides, at a sky above a low horizon.
Test(sky, room_behind_a_room_of_windows, .timeout = 300) {
    Lit *lit = read_plan("room a 0,0 2,0 2,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                         "room b 3,0 6,0 6,3 3,3 floor oak ceiling white walls white wall 0.2\n"
                         "window w -0.1,1.5 angle 90 width 2.8 sill 0.1 height 2.3\n"
                         "window v 2.1,1.5 angle 90 width 2.8 sill 0.1 height 2.3\n"
                         "window u 2.9,1.5 angle 90 width 2.8 sill 0.1 height 2.3\n",
                         0.25);
    RadSolution s = lit_by_sky(lit, CULL_STAB, 0);
    double errors[POINTS];
    int count = errors_of(lit, &s, errors);
    cr_assert_leq(errors[count / 2], 0.02, "median %.2f %%", 100 * errors[count / 2]);
    cr_assert_leq(errors[count - 1], 0.1, "at most %.2f %%", 100 * errors[count - 1]);
    lit_free(lit);
}

// Proves the same of a soup, which has no windows: a box with a hole in its roof, and a smaller one within.
Test(sky, box_with_a_hole, .timeout = 300) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_RED, 1 << 5);
    lit_box(lit, vec3(-0.2, -0.2, -0.2), vec3(4.2, 3.2, 2.6), false, LIT_WALL, 1 << 5);
    lit_quad(lit, vec3(0, 0, 2.5), vec3(0, 3, 2.5), vec3(3, 3, 2.5), vec3(3, 0, 2.5), LIT_RED);
    lit_quad(lit, vec3(-0.2, -0.2, 2.6), vec3(3, -0.2, 2.6), vec3(3, 3.2, 2.6), vec3(-0.2, 3.2, 2.6),
             LIT_WALL);
    lit_box(lit, vec3(1.03, 1.06, 0), vec3(2.04, 1.97, 1), false, LIT_WALL, 1 << 4);
    lit_finish(lit, 0.25, 2);
    RadSolution s = lit_by_sky(lit, CULL_STAB, 0);
    double errors[POINTS];
    int count = errors_of(lit, &s, errors);
    cr_assert_geq(count, point_count() * 5 / 8);
    cr_assert_leq(errors[count / 2], 0.02, "median %.2f %%", 100 * errors[count / 2]);
    check_conserved(lit, &s);
    lit_free(lit);
}

// Proves that neither culling nor threads change a bit of it.
Test(sky, same_culled_and_on_any_number_of_threads) {
    Lit *lit = room_with_window(1.2, 1.3, 0.5);
    RadOptions one = options_of(CULL_STAB, 1);
    RadSolution first = shone(lit, &one);
    for (int i = 0; i < CULLINGS + 1; i++) {
        RadOptions options = i < CULLINGS ? options_of((Culling)i, 1) : options_of(CULL_STAB, 3);
        RadSolution s = shone(lit, &options);
        size_t size = (size_t)s.element_count * sizeof *s.radiosity;
        cr_assert(memcmp(s.radiosity, first.radiosity, size) == 0, "differs: %s",
                  i < CULLINGS ? CULLING_NAMES[i] : "3 threads");
        cr_assert_arr_eq(s.emitted, first.emitted, sizeof s.emitted);
    }
    lit_free(lit);
}

// Proves that light through a key-hole is neither lost nor made: a hole of 2 cm, 20 cm deep. What comes in is, within a factor of
// two, what two discs of its area at its depth exchange: the sky above the horizon, seen along the hole, is half of its far end.
Test(sky, key_hole) {
    Lit *lit = room_with_window(0.02, 0.02, 0.25);
    RadSolution s = lit_by_sky(lit, CULL_STAB, 0);
    check_conserved(lit, &s);
    double indoors = s.emitted[1] - s.outdoors[1], opening = 0.02 * 0.02;
    cr_assert_gt(indoors, 0.2 * opening * M_PI * 20 / 2);
    cr_assert_leq(indoors, opening * M_PI * 20 / 2 * 1.01);
    double room = 0;
    for (int e = 0; e < s.element_count; e++) {
        int cell = lit->mesh.patches[lit->mesh.elements[e].patch].cell;
        cr_assert(isfinite(s.radiosity[e][1]) && s.radiosity[e][1] >= 0);
        if (cell >= 0 && vis_region(&lit->graph, cell)->kind == REGION_ROOM)
            room += s.radiosity[e][1] * lit->mesh.elements[e].area;
    }
    cr_assert_gt(room, 0);
    cr_assert_lt(room, 4 * opening * M_PI * 20);
    lit_free(lit);
}

// Proves that the file remembers the sky, and that a run that was broken off goes on to the same light.
Test(sky, is_stored_and_resumed) {
    Lit *lit = room_with_window(1.2, 1.3, 0.5);
    RadSolution whole = lit_by_sky(lit, CULL_STAB, 1), back;
    RadOptions options = options_of(CULL_STAB, 1);
    options.shots = 10;
    RadSolution s = shone(lit, &options);
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &s);
    Arena arena = {0};
    Error error = {""};
    const char *path = arena_format(&arena, "%s/a.rad", support_folder(&arena));
    cr_assert(rad_save(path, &lit->mesh, NULL, &s, &error), "%s", error.text);
    cr_assert(rad_load(path, &lit->mesh, NULL, &lit->arena, &back, &error), "%s", error.text);
    cr_assert_arr_eq(back.sky, SKY, sizeof back.sky);
    options.shots = 0;
    rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &back);
    cr_assert_eq(back.shots, whole.shots);
    cr_assert_arr_eq(back.radiosity, whole.radiosity, (size_t)back.element_count * sizeof *back.radiosity);
    lit_free(lit);
    arena_free(&arena);
}

// Asks to stop once this share is done.
static bool stop_at(void *context, const char *stage, double done) {
    cr_assert_str_eq(stage, "sky");
    return done < *(double *)context;
}

// Proves that daylight heeds whoever asks to stop, outdoors and at the openings, and else is as if nobody had been told of it.
Test(sky, stops_when_asked) {
    Lit *lit = room_with_window(1, 1, 0.5);
    RadOptions options = options_of(CULL_STAB, 2);
    double never = 2, at[2] = {0, 0.5};
    RadSolution alone = shone(lit, &options), s;
    Error error = {""};
    for (int i = 0; i < 3; i++) {
        Progress progress = {stop_at, i < 2 ? &at[i] : &never};
        cr_assert(rad_start_dark(&lit->mesh, &lit->arena, &s, &error), "%s", error.text);
        cr_assert_eq(rad_shine(&lit->mesh, &lit->forest, NULL, &options, SKY, &progress, &s), i == 2);
    }
    cr_assert_arr_eq(s.radiosity, alone.radiosity, (size_t)s.element_count * sizeof *s.radiosity);
    lit_free(lit);
}
