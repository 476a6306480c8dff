// test_walk_light.c - radiosities at corners: even light is even, neighbours in one plane agree; and what was baked for
// another building is passed over or refused.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "engine/walk/walk_light.h"
#include "tests/fixture.h"
#include "tests/support.h"

typedef struct Made {
    Arena arena;
    CellGraph graph;
    Mesh mesh;
    RadSolution solution;
} Made;

static void make(Made *m) {
    Random random = {3};
    Error error = {""};
    VisOptions options = vis_default_options();
    MeshOptions mesh_options = mesh_default_options();
    *m = (Made){.arena = {0}};
    const Building *b = fixture_rooms(&m->arena, &random, 2, 2, 1);
    cr_assert(vis_build_cells(b, &options, &m->arena, &m->graph, &error), "%s", error.text);
    cr_assert(mesh_build(&m->graph, NULL, NULL, &mesh_options, &m->arena, &m->mesh, &error), "%s",
              error.text);
    m->solution.element_count = m->mesh.element_count;
    m->solution.radiosity =
        arena_alloc(&m->arena, (size_t)m->mesh.element_count, sizeof *m->solution.radiosity);
}

static void set(Made *m, int element, double b) {
    for (int c = 0; c < 3; c++) m->solution.radiosity[element][c] = b;
}

// Proves that even light is even at all corners, and on whole faces: the same, to rounding.
Test(walk_light, even_light_is_even) {
    Made m;
    make(&m);
    for (int e = 0; e < m.mesh.element_count; e++) set(&m, e, 7);
    VertexLight light = walk_light_vertices(&m.mesh, &m.solution, &m.arena);
    for (int i = 0; i < m.mesh.corner_count; i++)
        cr_assert_float_eq(light.corner[i][1], 7, 1e-12, "corner %d is %g", i, light.corner[i][1]);
    for (int f = 0; f < m.mesh.face_count; f++)
        cr_assert_float_eq(light.face[f][1], 7, 1e-12, "face %d is %g", f, light.face[f][1]);
    arena_free(&m.arena);
}

// Corners at one place, of one face, have one light: no seams between elements. With elements in random light.
Test(walk_light, elements_of_a_face_meet_in_one_light) {
    Made m;
    Random random = {11};
    make(&m);
    for (int e = 0; e < m.mesh.element_count; e++) set(&m, e, random_between(&random, 0.5, 1.5));
    VertexLight light = walk_light_vertices(&m.mesh, &m.solution, &m.arena);
    double *at = ARENA_ARRAY(&m.arena, double, m.mesh.vertex_count);
    int *face_at = ARENA_ARRAY(&m.arena, int, m.mesh.vertex_count), met = 0;
    for (int v = 0; v < m.mesh.vertex_count; v++) face_at[v] = -1;
    for (int e = 0; e < m.mesh.element_count; e++) {
        const Element *element = &m.mesh.elements[e];
        for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++) {
            int v = m.mesh.corners[i];
            if (face_at[v] == element->face) {
                cr_assert_eq(at[v], light.corner[i][0], "a seam at vertex %d", v);
                met++;
            }
            face_at[v] = element->face;
            at[v] = light.corner[i][0];
        }
    }
    cr_expect_gt(met, 1000);
    arena_free(&m.arena);
}

Test(walk_light, light_of_another_building_is_passed_over_or_refused, .timeout = 120) {
    Arena arena = {0};
    char *folder = support_folder(&arena), *output;
    const char *build = support_build();
    cr_assert_eq(support_run(&arena, NULL,
                             "export XDG_CACHE_HOME=%s && cp build/maps/two-rooms.plan %s/a.plan && "
                             "%s/enfilade bake %s/a.plan -o %s/a.rad --shots 50",
                             folder, folder, build, folder, folder),
                 0);
    const char *walk =
        "export XDG_CACHE_HOME=%s && %s/enfilade walk %s/a.plan --offscreen %s/frames --every 1000 "
        "--size 64x48 %s";
    int code = support_run(&arena, &output, walk, folder, build, folder, folder, "");
    cr_expect(code == 0 && !strstr(output, "passed over"), "%s", output);
    cr_expect_eq(support_run(&arena, NULL, "echo '# other' >> %s/a.plan", folder), 0);
    code = support_run(&arena, &output, walk, folder, build, folder, folder, "");
    cr_expect(code == 0 && strstr(output, "passed over"), "%s", output);
    code = support_run(&arena, &output, walk, folder, build, folder, folder,
                       arena_format(&arena, "--light %s/a.rad", folder));
    cr_expect(code == 1 && strstr(output, "a.rad"), "%s", output);
    code = support_run(&arena, &output, walk, folder, build, folder, folder, "--look baked");
    cr_expect(code == 1 && strstr(output, "no light"), "%s", output);
    arena_free(&arena);
}
