// test_lit_states.c - the light that is drawn in states of the lamps.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/random.h"
#include "engine/lit/lit_states.h"
#include "tests/support/lamps_fixture.h"
#include "tests/support/support.h"

// The light of the file in the scene's state of the lamps, as it is drawn.
static LitMesh *load(Lamps3 *l, const char *path, WalkLight *light, LitLight *out) {
    Error error = {""};
    cr_assert(light_load(path, &l->scene, &l->arena, light, &error), "%s", error.text);
    LitMesh *mesh = lit_mesh_new(light->mesh, &l->arena, &l->arena);
    *out = lit_light_new(mesh, &l->arena);
    lit_light_fill(mesh, light->solution, NULL, out);
    return mesh;
}

static void random_state(Random *random, Rgb lit[4]) {
    for (int i = 0; i < 4; i++) {
        float share = random_unit(random) < 0.4 ? 0 : (float)random_unit(random);
        lit[i] = (Rgb){share, share, random_unit(random) < 0.3 ? 0 : share};
    }
}

// Proves that a state that is reached by switching is the state that is loaded, by night and by day, whatever states came before, and
// that the first one comes back as it was, bit for bit. Light is kept in floats: the difference is below 1e-6 of the brightest light there.
Test(lit_states, switched_as_loaded, .timeout = 120) {
    for (int day = 0; day < 2; day++) {
        Lamps3 *l = lamps3_load(day);
        lamps3_bake(l, 1e-3, 2);
        Error error = {""};
        const char *path = arena_format(&l->arena, "%s/x.rad", support_folder(&l->arena));
        cr_assert(rad_save(path, &l->mesh, l->doors, &l->solution, &error), "%s", error.text);
        WalkLight light, other;
        LitLight first, loaded;
        LitMesh *mesh = load(l, path, &light, &first);
        int vertices = lit_vertex_count(mesh);
        cr_assert_not_null(light.states);
        LitStates *states = lit_states_new(mesh, &light, &l->arena);
        LitLight now = lit_light_new(mesh, &l->arena);
        Random random = {7};
        Rgb lit[4], full[4];
        for (int i = 0; i < 4; i++) full[i] = (Rgb){1, 1, 1};
        for (int i = 0; i < 20; i++) {
            random_state(&random, lit);
            cr_assert(lit_states_fill(states, lit, l->doors, NULL, &now));
        }
        memcpy(l->scene.lit, lit, sizeof lit);
        load(l, path, &other, &loaded);
        memcpy(l->scene.lit, full, sizeof full);
        for (int v = 0; v < vertices; v++)
            for (int c = 0; c < 3; c++) {
                if (mesh->vertex[v].emits) continue;
                cr_assert_float_eq(now.vertex[v][c], loaded.vertex[v][c],
                                   1e-6f * (first.vertex[v][c] + 1e-3f), "day %d, vertex %d: %g, loaded %g",
                                   day, v, (double)now.vertex[v][c], (double)loaded.vertex[v][c]);
            }
        for (int i = 0; i < mesh->lamp_count; i++) {
            Rgb share = lit[l->scene.lamps.of_polygon[mesh->lamp[i]]];
            cr_expect_eq(now.on[i], share.r + share.g + share.b > 0);
        }
        while (lit_states_prepare(states, NULL)) {
        }
        cr_assert(lit_states_fill(states, full, l->doors, NULL, &now));
        cr_expect_arr_eq(now.vertex, first.vertex, (size_t)vertices * sizeof *first.vertex);
        lamps3_free(l);
    }
}
