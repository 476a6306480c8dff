// test_mesh_pose.c - doors of a mesh in motion.
#include <criterion/criterion.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "radiosity/mesh/mesh.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

typedef struct Doored {
    Arena arena;
    Building building;
    CellGraph graph;
    Mesh mesh;
    float *open, *other;  // [opening_count]
} Doored;

static void finish(Doored *d) {
    VisOptions options = vis_default_options();
    Error error = {""};
    cr_assert(vis_build_cells(&d->building, &options, &d->arena, &d->graph, &error), "%s", error.text);
    d->open = ARENA_ARRAY(&d->arena, float, d->building.opening_count + 1);
    d->other = ARENA_ARRAY(&d->arena, float, d->building.opening_count + 1);
}

static void build(Doored *d, const float *open, Mesh *out) {
    MeshOptions options = mesh_default_options();
    Error error = {""};
    cr_assert(mesh_build(&d->graph, open, &options, &d->arena, out, &error), "%s", error.text);
}

static void put_doors(const Doored *d, Random *random, float *open) {
    for (int i = 0; i < d->building.opening_count; i++) {
        bool door = d->building.openings[i].kind == OPENING_DOOR;
        open[i] = door ? (float)random_index(random, 5) / 4 : 1;
    }
}

static bool same_panes(const Panes *a, const Panes *b) {
    if (a->count != b->count) return false;
    for (int i = 0; i < a->count; i++)
        if (a->panes[i].opening != b->panes[i].opening || !vec3_equal(a->panes[i].origin, b->panes[i].origin))
            return false;
    return true;
}

static void expect_same(const Mesh *a, const Mesh *b) {
    cr_assert(a->face_count == b->face_count && a->element_count == b->element_count &&
              a->patch_count == b->patch_count && a->vertex_count == b->vertex_count);
    cr_expect_arr_eq(a->vertices, b->vertices, (size_t)a->vertex_count * sizeof *a->vertices);
    cr_expect_arr_eq(a->corners, b->corners, (size_t)a->corner_count * sizeof *a->corners);
    for (int f = 0; f < a->face_count; f++) {
        const Face *p = &a->faces[f], *q = &b->faces[f];
        cr_expect(p->hidden == q->hidden && p->open == q->open && vec3_equal(p->plane.n, q->plane.n) &&
                      p->plane.d == q->plane.d && vec3_equal(p->origin, q->origin) &&
                      vec3_equal(p->gx, q->gx) && vec3_equal(p->gy, q->gy),
                  "face %d", f);
    }
    for (int i = 0; i < a->patch_count; i++) {
        const Patch *p = &a->patches[i], *q = &b->patches[i];
        // The search for a cell may end in either of two cells where a patch lies between them.
        cr_expect(vec3_equal(p->centre, q->centre) && (p->cell < 0) == (q->cell < 0), "patch %d", i);
    }
    cr_expect(same_panes(&a->panes, &b->panes));
}

// Proves that a mesh whose doors were moved, there and back and on, is the mesh that is built with the doors so, to the last bit; and that
// elements are the same in all states.
static void check_moves(Doored *d, Random *random) {
    Mesh there;
    put_doors(d, random, d->open);
    build(d, d->open, &d->mesh);
    for (int i = 0; i < 6; i++) {
        put_doors(d, random, d->other);
        mesh_move(&d->mesh, d->open, d->other, &d->arena);
        memcpy(d->open, d->other, (size_t)d->building.opening_count * sizeof *d->open);
    }
    build(d, d->open, &there);
    expect_same(&d->mesh, &there);
}

Test(mesh_pose, moved_is_built_in_a_house) {
    Doored d = {0};
    Error error = {""};
    Random random = {1};
    cr_assert(maps_read("build/maps/house.plan", &d.arena, &d.building, &error), "%s", error.text);
    finish(&d);
    check_moves(&d, &random);
    arena_free(&d.arena);
}

Test(mesh_pose, moved_is_built_in_random_rooms) {
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(3, 60); seed++) {
        Doored d = {0};
        Random random = {seed};
        d.building = *fixture_rooms(&d.arena, &random, 4, 3, 2);
        finish(&d);
        check_moves(&d, &random);
        arena_free(&d.arena);
    }
}

// Proves that a move tells the doors that moved and boxes about them: all vertices that moved lie in the box before as they were, and in
// that after as they are; and that a copy moves by itself.
Test(mesh_pose, moves_are_told) {
    Doored d = {0};
    Error error = {""};
    Random random = {2};
    cr_assert(maps_read("build/maps/house.plan", &d.arena, &d.building, &error), "%s", error.text);
    finish(&d);
    put_doors(&d, &random, d.open);
    build(&d, d.open, &d.mesh);
    Mesh copy = mesh_copy(&d.mesh, &d.arena);
    put_doors(&d, &random, d.other);
    MovedDoors moved = mesh_move(&d.mesh, d.open, d.other, &d.arena);
    int differ = 0, count = 0;
    for (int i = 0; i < d.building.opening_count; i++) differ += d.open[i] != d.other[i];
    cr_expect_eq(moved.count, differ);
    for (int v = 0; v < copy.vertex_count; v++) {
        Vec3 was = copy.vertices[v], is = d.mesh.vertices[v];
        bool told = vec3_equal(was, is);
        for (int i = 0; i < moved.count; i++)
            told = told || (box_contains(box_grow(moved.doors[i].box[0], 1e-9), was) &&
                            box_contains(box_grow(moved.doors[i].box[1], 1e-9), is));
        cr_expect(told, "vertex %d", v);
        count += !vec3_equal(was, is);
    }
    cr_expect_gt(count, 0);
    arena_free(&d.arena);
}
