// test_rad_file.c - the .rad file comes back as it went, and nothing else is taken for one.
#include <criterion/criterion.h>
#include <stddef.h>

#include "radiosity/mesh/nodes.h"
#include "tests/support/fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

typedef struct Saved {
    Lit *lit;
    RadSolution solution;
    const char *path;
    Bytes bytes;
    float doors[64];
} Saved;

static Saved save(uint64_t seed) {
    Saved s = {.lit = lit_rooms(seed)};
    Error error = {""};
    RadOptions options = rad_default_options();
    options.shots = 100;
    lit_shoot(s.lit, &options, &s.solution);
    s.path = arena_format(&s.lit->arena, "%s/x.rad", support_folder(&s.lit->arena));
    int doors = s.lit->building->opening_count;
    cr_assert(doors > 0 && doors <= 64);
    for (int i = 0; i < doors; i++) s.doors[i] = i % 3 ? 1 : 0.25f;
    cr_assert(rad_save(s.path, &s.lit->mesh, s.doors, &s.solution, &error), "%s", error.text);
    s.bytes = support_read(&s.lit->arena, s.path);
    return s;
}

static void refuse(const Saved *s, const Mesh *mesh, const float *doors, const char *expected) {
    RadSolution back;
    Error error = {""};
    cr_assert_not(rad_load(s->path, mesh, doors, &s->lit->arena, &back, &error), "taken, not: %s", expected);
    cr_assert_not_null(strstr(error.text, expected), "says `%s`, not `%s`", error.text, expected);
}

// Proves that all of a solution comes back, and how its mesh was made.
Test(rad_file, comes_back) {
    Saved s = save(3);
    RadSolution back, *went = &s.solution;
    Error error = {""};
    cr_assert(rad_load(s.path, &s.lit->mesh, s.doors, &s.lit->arena, &back, &error), "%s", error.text);
    cr_assert_eq(back.element_count, went->element_count);
    cr_assert_eq(back.patch_count, went->patch_count);
    cr_assert_eq(back.shots, 100);
    cr_assert_eq(memcmp(back.radiosity, went->radiosity, (size_t)back.element_count * 24), 0);
    cr_assert_eq(memcmp(back.unshot, went->unshot, (size_t)back.patch_count * 24), 0);
    cr_assert_eq(memcmp(back.emitted, went->emitted, sizeof back.emitted), 0);
    cr_assert_eq(memcmp(back.absorbed, went->absorbed, sizeof back.absorbed), 0);
    cr_assert_eq(memcmp(back.escaped, went->escaped, sizeof back.escaped), 0);
    MeshOptions options;
    float doors[64];
    cr_assert(rad_load_options(s.path, s.lit->building, &s.lit->arena, &options, doors, &error), "%s",
              error.text);
    cr_assert(options.element == 0.5 && options.per_patch == 2);
    cr_assert_eq(memcmp(doors, s.doors, (size_t)s.lit->building->opening_count * sizeof *doors), 0);
    lit_free(s.lit);
}

// Proves that what was gathered at nodes comes back, and is refused where the nodes are others.
Test(rad_file, nodes_come_back) {
    Saved s = save(3);
    RadSolution back;
    Error error = {""};
    Arena *arena = &s.lit->arena;
    s.solution.node_count = nodes_of(&s.lit->mesh, arena).count;
    s.solution.node = arena_alloc(arena, (size_t)s.solution.node_count, sizeof *s.solution.node);
    for (int n = 0; n < s.solution.node_count; n++) s.solution.node[n][n % 3] = n;
    cr_assert(rad_save(s.path, &s.lit->mesh, s.doors, &s.solution, &error), "%s", error.text);
    cr_assert(rad_load(s.path, &s.lit->mesh, s.doors, arena, &back, &error), "%s", error.text);
    cr_assert_eq(back.node_count, s.solution.node_count);
    cr_assert_eq(memcmp(back.node, s.solution.node, (size_t)back.node_count * sizeof *back.node), 0);
    s.solution.node_count--;
    cr_assert(rad_save(s.path, &s.lit->mesh, s.doors, &s.solution, &error), "%s", error.text);
    refuse(&s, &s.lit->mesh, s.doors, "its elements are not those of this program's version");
    s.solution.node_count++;
    s.solution.node[7][1] = NAN;
    cr_assert(rad_save(s.path, &s.lit->mesh, s.doors, &s.solution, &error), "%s", error.text);
    refuse(&s, &s.lit->mesh, s.doors, "not all its radiosities are finite");
    lit_free(s.lit);
}

// Proves that light of another state is refused, saying what differs.
Test(rad_file, refuses_another_state) {
    Saved s = save(3), other = save(4);
    refuse(&s, &other.lit->mesh, s.doors, "belongs to another building");
    Mesh mesh = s.lit->mesh;
    mesh.options.element = 0.25;
    refuse(&s, &mesh, s.doors, "has elements of 0.5 m, 2 along a patch (asked for: 0.25 m, 2)");
    mesh = s.lit->mesh;
    mesh.element_count--;
    refuse(&s, &mesh, s.doors, "its elements are not those of this program's version");
    mesh = s.lit->mesh;
    Vec3 kept = mesh.vertices[5];
    mesh.vertices[5].x += 1e-9;
    refuse(&s, &mesh, s.doors, "its elements are not those of this program's version");
    mesh.vertices[5] = kept;
    float doors[64];
    memcpy(doors, s.doors, sizeof doors);
    doors[1] = 0;
    refuse(&s, &s.lit->mesh, doors, "was made with door");
    refuse(&s, &s.lit->mesh, NULL, "was made with door");
    lit_free(s.lit);
    lit_free(other.lit);
}

// Proves that light of other colours or lamps than a face has now is refused, and that a name, a mirror or a gloss, on which no light
// depends, may change.
Test(rad_file, refuses_other_materials) {
    Saved s = save(3);
    Mesh *mesh = &s.lit->mesh;
    RadSolution back;
    Error error = {""};
    Material *m = (Material *)mesh_material(mesh, 0), kept = *m;  // the test's own building
    m->reflectance.g += 1e-3f;
    refuse(&s, mesh, s.doors, "its elements are not those of this program's version");
    *m = kept;
    m->emission.b += 1e-3f;
    refuse(&s, mesh, s.doors, "its elements are not those of this program's version");
    *m = kept;
    m->name = "other";
    m->mirror = m->gloss = 0.5f;
    cr_expect(rad_load(s.path, mesh, s.doors, &s.lit->arena, &back, &error), "%s", error.text);
    lit_free(s.lit);
}

// Proves that splits are refused that would make patches of more elements than a shot can tell apart, checksums right or not.
Test(rad_file, refuses_forged_splits) {
    static const MeshSplits TOO_DEEP = {.even = MESH_IN_PATCH + 1}, FITS = {.even = MESH_IN_PATCH};
    Saved s = save(3);
    Error error = {""};
    MeshOptions options;
    float doors[64];
    Mesh mesh = s.lit->mesh;
    mesh.options.splits = &FITS;
    cr_assert(rad_save(s.path, &mesh, s.doors, &s.solution, &error), "%s", error.text);
    cr_assert(rad_load_options(s.path, s.lit->building, &s.lit->arena, &options, doors, &error), "%s",
              error.text);
    cr_assert_eq(options.splits->even, MESH_IN_PATCH);
    mesh.options.splits = &TOO_DEEP;
    cr_assert(rad_save(s.path, &mesh, s.doors, &s.solution, &error), "%s", error.text);
    cr_assert_not(rad_load_options(s.path, s.lit->building, &s.lit->arena, &options, doors, &error));
    cr_assert(strstr(error.text, "is damaged"), "%s", error.text);
    lit_free(s.lit);
}

// Proves that no changed bit and no missing byte goes unseen, wherever it is; a missing one by the header alone.
Test(rad_file, refuses_what_is_not_whole) {
    Saved s = save(3);
    Random random = {9};
    Error error = {""};
    for (int i = 0; i < 400; i++) {
        Arena scratch = {0};
        unsigned char *bad = arena_alloc(&scratch, s.bytes.size, 1);
        memcpy(bad, s.bytes.data, s.bytes.size);
        size_t size = s.bytes.size;
        // Every second one in the header, of some 160 bytes.
        if (i % 3 == 0)
            size = (size_t)(random_unit(&random) * (double)size);
        else
            bad[random_index(&random, i % 3 == 1 ? 160 : (int)size)] ^=
                (unsigned char)(1 << random_index(&random, 8));
        cr_assert(file_write(s.path, bad, size, &error));
        RadSolution back;
        error.text[0] = 0;
        cr_assert_not(rad_load(s.path, &s.lit->mesh, s.doors, &scratch, &back, &error), "seed 9, case %d", i);
        cr_assert_neq(error.text[0], 0);
        Daylight day;
        if (i % 3 == 0)
            cr_assert_not(rad_load_day(s.path, s.lit->building, &day, &error), "seed 9, case %d", i);
        arena_free(&scratch);
    }
    lit_free(s.lit);
}
