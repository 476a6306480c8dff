// test_proxy.c - stand-ins for fine furniture: near the model, closed, few; lamps and light kept; the fine model lit from them.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

enum { ROUND = 64, PANEL_X = 40, PANEL_Y = 20 };
static const Vec3 BALL = {2, 2, 1};
static const double RADIUS = 0.25, THICK = 0.01;
static const Box PANEL = {{3, 1, 0.7}, {3.8, 1.4, 0.71}};

static void add(Lit *lit, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int material) {
    building_add_polygon(&lit->arena, lit->building, (Vec3[4]){p, q, r, s}, 4, material);
}

static Vec3 on_ball(int i, int j) {
    double a = 2 * M_PI * (i % ROUND) / ROUND, b = M_PI * j / (ROUND / 2) - M_PI / 2;
    if (j == 0 || j == ROUND / 2) a = 0;
    return vec3_add(BALL, vec3_scale(vec3(cos(a) * cos(b), sin(a) * cos(b), sin(b)), RADIUS));
}

static void add_ball(Lit *lit) {
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "ball");
    for (int j = 0; j < ROUND / 2; j++) {
        for (int i = 0; i < ROUND; i++) {
            Vec3 v[4] = {on_ball(i, j), on_ball(i + 1, j), on_ball(i + 1, j + 1), on_ball(i, j + 1)};
            int triangle = j == 0 || j + 1 == ROUND / 2;
            if (j == 0) v[1] = v[2], v[2] = v[3];
            building_add_polygon(&lit->arena, lit->building, v, 4 - triangle, LIT_RED);
        }
    }
}

// A point of the panel's grid, up or down.
static Vec3 on_panel(int i, int j, bool up) {
    return vec3(PANEL.min.x + (PANEL.max.x - PANEL.min.x) * i / PANEL_X,
                PANEL.min.y + (PANEL.max.y - PANEL.min.y) * j / PANEL_Y, up ? PANEL.max.z : PANEL.min.z);
}

// Closed, of squares of 2 cm.
static void add_panel(Lit *lit) {
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "panel");
    for (int j = 0; j < PANEL_Y; j++) {
        for (int i = 0; i < PANEL_X; i++) {
            add(lit, on_panel(i, j, true), on_panel(i + 1, j, true), on_panel(i + 1, j + 1, true),
                on_panel(i, j + 1, true), LIT_WALL);
            add(lit, on_panel(i, j + 1, false), on_panel(i + 1, j + 1, false), on_panel(i + 1, j, false),
                on_panel(i, j, false), LIT_WALL);
        }
    }
    for (int i = 0; i < PANEL_X; i++) {
        add(lit, on_panel(i, 0, false), on_panel(i + 1, 0, false), on_panel(i + 1, 0, true),
            on_panel(i, 0, true), LIT_WALL);
        add(lit, on_panel(i + 1, PANEL_Y, false), on_panel(i, PANEL_Y, false), on_panel(i, PANEL_Y, true),
            on_panel(i + 1, PANEL_Y, true), LIT_WALL);
    }
    for (int j = 0; j < PANEL_Y; j++) {
        add(lit, on_panel(PANEL_X, j, false), on_panel(PANEL_X, j + 1, false), on_panel(PANEL_X, j + 1, true),
            on_panel(PANEL_X, j, true), LIT_WALL);
        add(lit, on_panel(0, j + 1, false), on_panel(0, j, false), on_panel(0, j, true),
            on_panel(0, j + 1, true), LIT_WALL);
    }
}

// A lampshade: a ring of narrow strips, every fourth of which glows.
static void add_lamp(Lit *lit) {
    building_add_object(&lit->arena, lit->building, OBJECT_LAMP, "lamp");
    for (int i = 0; i < 128; i++) {
        double a = 2 * M_PI * i / 128, b = 2 * M_PI * (i + 1) / 128, r = 0.2;
        Vec3 p = vec3(3 + r * cos(a), 3.5 + r * sin(a), 2.2), q = vec3(3 + r * cos(b), 3.5 + r * sin(b), 2.2);
        Vec3 up = {0, 0, 0.1};
        add(lit, p, q, vec3_add(q, up), vec3_add(p, up), i % 4 == 0 ? LIT_LAMP : LIT_WALL);
    }
}

// A room with these three in it, without a mesh yet.
static Lit *furnished(void) {
    Lit *lit = lit_new();
    Error error = {""};
    VisOptions options = vis_default_options();
    lit_box(lit, vec3(0, 0, 0), vec3(6, 5, 3), true, LIT_WALL, 0);
    add_ball(lit);
    add_panel(lit);
    add_lamp(lit);
    cr_assert(vis_build_cells(lit->building, &options, &lit->arena, &lit->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&lit->graph, &options, NULL, &lit->arena, &lit->forest));
    return lit;
}

static const Proxies *proxies_of(Lit *lit, double tolerance) {
    return proxies_find(&lit->graph, NULL, tolerance, &lit->arena);
}

static void build(Lit *lit, const Proxies *proxies, double close, Mesh *out) {
    Error error = {""};
    MeshOptions options = {.element = 0.25, .per_patch = 2, .close = close, .proxies = proxies};
    cr_assert(mesh_build(&lit->graph, NULL, NULL, &options, &lit->arena, out, &error), "%s", error.text);
}

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
    Lit *lit = furnished();
    static const double TOLERANCES[] = {0.005, 0.0125, 0.03};
    int before = INT32_MAX;
    for (int t = 0; t < 3; t++) {
        const Proxies *proxies = proxies_of(lit, TOLERANCES[t]);
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
    Lit *lit = furnished();
    const Proxies *proxies = proxies_of(lit, 0.02);
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
    Lit *lit = furnished();
    const Proxies *proxies = proxies_of(lit, 0.02);
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

// Proves that what emits light is there as it is, and that none of it is lost on stand-ins: emitted is absorbed, escaped and unshot,
// in a room that is closed nothing escapes, and three threads find the same as one.
Test(proxy, keeps_lamps_and_light) {
    Lit *lit = furnished();
    Error error = {""};
    RadSolution found[2], plain;
    const Proxies *proxies = proxies_of(lit, 0.02);
    Mesh fine;
    build(lit, NULL, 0, &fine);
    build(lit, proxies, 0, &lit->mesh);
    cr_assert_lt(4 * lit->mesh.face_count, fine.face_count);
    for (int k = 0; k < 2; k++) {
        RadOptions options = rad_default_options();
        options.threads = k == 0 ? 1 : 3;
        options.residual = 0.01;
        lit_shoot(lit, &options, &found[k]);
    }
    cr_assert(rad_start(&fine, &lit->arena, &plain, &error), "%s", error.text);
    cr_expect_float_eq(found[0].emitted[0], plain.emitted[0], 1e-9 * plain.emitted[0]);
    for (int c = 0; c < 3; c++) {
        double unshot = 0;
        for (int p = 0; p < lit->mesh.patch_count; p++)
            unshot += found[0].unshot[p][c] * lit->mesh.patches[p].area;
        double sum = found[0].absorbed[c] + found[0].escaped[c] + unshot;
        cr_expect_float_eq(sum, found[0].emitted[c], 1e-11 * found[0].emitted[c]);
        cr_expect_lt(found[0].escaped[c], 1e-9 * found[0].emitted[c]);
    }
    cr_expect_eq(memcmp(found[0].radiosity, found[1].radiosity,
                        (size_t)lit->mesh.element_count * sizeof *found[0].radiosity),
                 0);
    lit_free(lit);
}

// Proves that the joined mesh is whole - the room and the lamp as light had them, all that is fine, no stand-ins, elements where the
// squares say - and that the fine model is lit as if light had been found on it: of each side's power to a twentieth, for
// elements are a quarter of a metre and the ball is half a metre across.
Test(proxy, lights_the_fine_model) {
    Lit *lit = furnished();
    Error error = {""};
    RadOptions options = rad_default_options();
    RadSolution truth, solution;
    Mesh fine;
    build(lit, NULL, 0, &fine);
    build(lit, proxies_of(lit, 0.0125), 0.05, &lit->mesh);
    options.residual = 0.003;
    lit_shoot(lit, &options, &solution);
    cr_assert(rad_start(&fine, &lit->arena, &truth, &error), "%s", error.text);
    rad_shoot(&fine, &lit->forest, NULL, &options, NULL, &truth);
    const FineMesh *joined = fine_mesh_new(&lit->mesh, &lit->arena);
    RadSolution shown = fine_light(joined, &solution, &lit->arena);
    const Mesh *mesh = &joined->mesh;
    cr_assert_eq(mesh->face_count, fine.face_count);
    // By whether they are new, and by the sides of a box that they face.
    double have[2][6] = {0}, want[2][6] = {0}, off[2] = {0}, sum[2] = {0};
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        Vec3 n = face->plane.n;
        int side = fabs(n.z) > 0.7 ? n.z > 0 : fabs(n.x) > fabs(n.y) ? 2 + (n.x > 0) : 4 + (n.y > 0);
        cr_assert_eq(mesh->face_of[face->polygon], f);
        cr_assert_eq(face->polygon, fine.faces[f].polygon);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            const Element *element = &mesh->elements[e];
            Vec3 middle = element_centroid(mesh, e);
            bool is_new = joined->element[e] < 0;
            cr_assert_eq(element->face, f);
            cr_assert_eq(mesh->patches[element->patch].face, f);
            cr_assert_eq(mesh_element_at(mesh, f, middle), e);
            cr_assert_eq(is_new, lit->mesh.face_of[face->polygon] < 0);
            have[is_new][side] += element->area * shown.radiosity[e][0];
            want[is_new][side] += element->area * truth.radiosity[mesh_element_at(&fine, f, middle)][0];
        }
    }
    for (int k = 0; k < 12; k++) {
        off[k % 2] += fabs(have[k % 2][k / 2] - want[k % 2][k / 2]);
        sum[k % 2] += want[k % 2][k / 2];
    }
    cr_expect_leq(off[0], 0.01 * sum[0], "%g of %g", off[0], sum[0]);
    cr_expect_leq(off[1], 0.05 * sum[1], "%g of %g", off[1], sum[1]);
    lit_free(lit);
}

// Proves that light gathered at nodes is handed on as it is.
Test(proxy, hands_nodes_on) {
    Lit *lit = furnished();
    RadSolution solution;
    RadOptions options = rad_default_options();
    build(lit, proxies_of(lit, 0.0125), 0.05, &lit->mesh);
    options.residual = 0.1;
    lit_shoot(lit, &options, &solution);
    Nodes nodes = nodes_of(&lit->mesh, &lit->arena);
    solution.node_count = nodes.count;
    solution.node = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *solution.node);
    for (int n = 0; n < nodes.count; n++) solution.node[n][1] = 100;
    const FineMesh *joined = fine_mesh_new(&lit->mesh, &lit->arena);
    RadSolution shown = fine_light(joined, &solution, &lit->arena);
    VertexLight light = reconstruct_light(&joined->mesh, &shown, &lit->arena);
    for (int c = 0; c < joined->mesh.corner_count; c++) {
        if (joined->corner[c] >= 0) cr_assert_eq(light.corner[c][1], 100);
        cr_assert_gt(light.corner[c][1], 10);
    }
    lit_free(lit);
}

// Proves that a file tells its stand-ins: it comes back on the same ones alone, and nothing is said of them where there are none.
Test(proxy, in_files) {
    Lit *lit = furnished();
    RadSolution solution, back;
    RadOptions options = rad_default_options();
    MeshOptions stored;
    Error error = {""};
    float door;
    Mesh other;
    options.shots = 10;
    build(lit, proxies_of(lit, 0.0125), 0.05, &lit->mesh);
    lit_shoot(lit, &options, &solution);
    const char *path = arena_format(&lit->arena, "%s/p.rad", support_folder(&lit->arena));
    cr_assert(rad_save(path, &lit->mesh, NULL, &solution, &error), "%s", error.text);
    cr_assert(rad_load_options(path, lit->building, &lit->arena, &stored, &door, &error), "%s", error.text);
    cr_expect_float_eq(stored.proxy, 0.0125, 1e-12);
    build(lit, proxies_of(lit, stored.proxy), stored.close, &other);
    cr_expect(rad_load(path, &other, NULL, &lit->arena, &back, &error), "%s", error.text);
    build(lit, proxies_of(lit, 0.02), stored.close, &other);
    cr_expect_not(rad_load(path, &other, NULL, &lit->arena, &back, &error));
    cr_expect_not_null(strstr(error.text, "stand-ins for fine furniture within 0.0125 m (asked for: 0.02 m"),
                       "%s", error.text);
    build(lit, NULL, stored.close, &other);
    cr_expect_not(rad_load(path, &other, NULL, &lit->arena, &back, &error));
    lit_free(lit);
}

// Proves that an office of plain furniture has none, and that its mesh is then the one without.
Test(proxy, none_where_nothing_is_fine) {
    Lit *lit = lit_new();
    Error error = {""};
    *lit->building = (Building){0};
    cr_assert(maps_read("build/maps/office-plain.plan", &lit->arena, lit->building, &error), "%s",
              error.text);
    lit_finish(lit, 1, 2);
    cr_expect_null(proxies_of(lit, PROXY_TOLERANCE));
    const FineMesh *same = fine_mesh_new(&lit->mesh, &lit->arena);
    cr_expect(same->same && same->mesh.elements == lit->mesh.elements);
    lit_free(lit);
}

static bool touches(const CellGraph *graph, int square, int object) {
    for (int k = graph->square_first[square]; k < graph->square_first[square + 1]; k++)
        if (graph->square_objects[k] == object) return true;
    return false;
}

// Proves that objects are found where their stand-ins are: a graph without more of them is the same, and where the first object has all
// polygons it is in every square that any is in, besides those that are there.
Test(proxy, found_in_their_squares) {
    Lit *lit = lit_rooms(5);
    const CellGraph *graph = &lit->graph;
    CellGraph again, all;
    int *of_first = ARENA_ARRAY(&lit->arena, int, graph->object_count + 1);
    for (int o = 0; o < graph->object_count; o++)
        of_first[o + 1] = graph->objects[graph->surface_first[0]].first_polygon;
    vis_register(graph, graph->polygons, graph->vertices, of_first, &lit->arena, &all);
    int more = 0;
    for (int s = 0; s < graph->square_count; s++) {
        bool any = false;
        for (int k = graph->square_first[s]; k < graph->square_first[s + 1]; k++) {
            int object = graph->square_objects[k];
            cr_assert(touches(&all, s, object));
            any = any || graph->objects[object].first_polygon < of_first[1];
        }
        for (int k = all.square_first[s] + 1; k < all.square_first[s + 1]; k++)
            cr_assert_lt(all.square_objects[k - 1], all.square_objects[k]);
        more += touches(&all, s, 0) && !touches(graph, s, 0);
        if (any) cr_assert(touches(&all, s, 0));
    }
    cr_expect_gt(more, 10);
    memset(of_first, 0, (size_t)(graph->object_count + 1) * sizeof *of_first);
    vis_register(graph, graph->polygons, graph->vertices, of_first, &lit->arena, &again);
    cr_assert_eq(again.square_object_count, graph->square_object_count);
    cr_expect_eq(memcmp(again.square_objects, graph->square_objects,
                        (size_t)graph->square_object_count * sizeof *again.square_objects),
                 0);
    lit_free(lit);
}
