// test_element_buffer.c - the papers' item buffers, by which their tables are measured again, agree with the exact methods:
// they see the same, a pixel here and there apart.
#include <criterion/criterion.h>
#include <stdio.h>

#include "maps/maps.h"
#include "radiosity/factors/element_buffer.h"
#include "tests/support/support.h"

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    Mesh mesh;
} Made;

static void make(Made *m) {
    Error error = {""};
    VisOptions options = vis_default_options();
    MeshOptions mesh_options = {.element = 0.5, .per_patch = 2};
    cr_assert(maps_read("build/maps/two-rooms.plan", &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest));
    cr_assert(mesh_build(&m->graph, NULL, &mesh_options, &m->arena, &m->mesh, &error), "%s", error.text);
}

static double difference(const Row *a, const Row *b) {
    double sum = fabs(a->back - b->back) + fabs(a->escaped - b->escaped);
    int i = 0, k = 0;
    while (i < a->count || k < b->count) {
        int ea = i < a->count ? a->element[i] : INT32_MAX, eb = k < b->count ? b->element[k] : INT32_MAX;
        double fa = ea <= eb ? (double)a->factor[i++] : 0, fb = eb <= ea ? (double)b->factor[k++] : 0;
        sum += fabs(fa - fb);
    }
    return sum;
}

// The mean over patches of sum |F - F'|.
static double compare(Made *m, int kind, const char *method, int resolution) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    FormFactor *exact = form_factor_new(form_factor_method(method), &m->mesh, &options, &m->arena);
    Viewer *viewer = viewer_new(&m->mesh, &m->forest, NULL, &m->arena);
    ElementBuffer *buffer = element_buffer_new(&m->mesh, kind, resolution, &m->arena);
    RowSum sum;
    int *faces = ARENA_ARRAY(&m->arena, int, m->mesh.face_count), shots = 0;
    double total = 0;
    row_start(&sum, &m->mesh, &m->arena);
    for (int f = 0; f < m->mesh.face_count; f++) faces[f] = f;
    for (int p = 0; p < m->mesh.patch_count; p += 7) {
        const Patch *patch = &m->mesh.patches[p];
        ViewPoint from = {patch->centre, m->mesh.faces[patch->face].plane.n, patch->cell};
        if (from.cell < 0) continue;
        element_buffer_start(buffer, &from);
        for (int s = 0; s < element_buffer_sides(buffer); s++)
            element_buffer_draw(buffer, s, faces, m->mesh.face_count);
        element_buffer_sum(buffer, &sum);
        total += difference(row_finish(&sum), form_factor_row(exact, viewer_look(viewer, &from, CULL_NONE)));
        shots++;
    }
    form_factor_end(exact);
    cr_assert_gt(shots, 20);
    return total / shots;
}

// Tolerance: pixels on edges of elements, which the two round apart, are few where both have the same directions. The exact
// hemisphere's grid is turned about its axis, so other pixels are inside: an element of p pixels differs by about sqrt(p).
Test(element_buffer, agrees_with_exact_directions) {
    Made m = {0};
    make(&m);
    double cube = compare(&m, ELEMENT_HEMICUBE, "hemicube", 100);
    double sphere = compare(&m, ELEMENT_HEMISPHERE, "hemisphere", 100);
    printf("hemicube %.4f, hemisphere %.4f\n", cube, sphere);
    cr_expect_lt(cube, 0.004);
    cr_expect_lt(sphere, 0.03);
    arena_free(&m.arena);
}
