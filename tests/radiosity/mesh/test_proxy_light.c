// test_proxy_light.c - stand-ins take and give the light of the fine model.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/reconstruct.h"
#include "tests/radiosity/mesh/proxy_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static void build(Lit *lit, const Proxies *proxies, double close, Mesh *out) {
    Error error = {""};
    MeshOptions options = {.element = 0.25, .per_patch = 2, .close = close, .proxies = proxies};
    cr_assert(mesh_build(&lit->graph, NULL, &options, &lit->arena, out, &error), "%s", error.text);
}

// Proves that what emits light is there as it is, and that none of it is lost on stand-ins: emitted is absorbed, escaped and unshot,
// in a room that is closed nothing escapes, and three threads find the same as one.
Test(proxy, keeps_lamps_and_light) {
    Lit *lit = proxy_furnished();
    Error error = {""};
    RadSolution found[2], plain;
    const Proxies *proxies = proxy_proxies_of(lit, 0.02);
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
    Lit *lit = proxy_furnished();
    Error error = {""};
    RadOptions options = rad_default_options();
    RadSolution truth, solution;
    Mesh fine;
    build(lit, NULL, 0, &fine);
    build(lit, proxy_proxies_of(lit, 0.0125), 0.05, &lit->mesh);
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
    Lit *lit = proxy_furnished();
    RadSolution solution;
    RadOptions options = rad_default_options();
    build(lit, proxy_proxies_of(lit, 0.0125), 0.05, &lit->mesh);
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
    Lit *lit = proxy_furnished();
    RadSolution solution, back;
    RadOptions options = rad_default_options();
    MeshOptions stored;
    Error error = {""};
    float door;
    Mesh other;
    options.shots = 10;
    build(lit, proxy_proxies_of(lit, 0.0125), 0.05, &lit->mesh);
    lit_shoot(lit, &options, &solution);
    const char *path = arena_format(&lit->arena, "%s/p.rad", support_folder(&lit->arena));
    cr_assert(rad_save(path, &lit->mesh, NULL, &solution, &error), "%s", error.text);
    cr_assert(rad_load_options(path, lit->building, &lit->arena, &stored, &door, &error), "%s", error.text);
    cr_expect_float_eq(stored.proxy, 0.0125, 1e-12);
    build(lit, proxy_proxies_of(lit, stored.proxy), stored.close, &other);
    cr_expect(rad_load(path, &other, NULL, &lit->arena, &back, &error), "%s", error.text);
    build(lit, proxy_proxies_of(lit, 0.02), stored.close, &other);
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
    cr_expect_null(proxy_proxies_of(lit, PROXY_TOLERANCE));
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
