// test_mesh.c - faces, elements and patches: nothing of a polygon lost, every element convex and where its grid says, places
// welded and T-vertices anchored.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "radiosity/mesh/mesh.h"
#include "radiosity/mesh/mesh_places.h"
#include "tests/radiosity/mesh/mesh_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

static void load(Sheets *s, const char *path, double close) {
    Error error = {""};
    VisOptions options = vis_default_options();
    MeshOptions mesh_options = mesh_default_options();
    mesh_options.close = close;
    cr_assert(maps_read(path, &s->arena, &s->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&s->building, &options, &s->arena, &s->graph, &error), "%s", error.text);
    cr_assert(mesh_build(&s->graph, NULL, &mesh_options, &s->arena, &s->mesh, &error), "%s", error.text);
}

// ---- what holds of every mesh

// No vertex of the list lies inside an edge of a ring but as one of the ring's.
static int cracks(const Mesh *mesh, const int *ring, int count, const int *among, int among_count) {
    int found = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = mesh->vertices[ring[i]], edge = vec3_sub(mesh->vertices[ring[(i + 1) % count]], a);
        double length = vec3_length(edge);
        for (int k = 0; k < among_count; k++) {
            if (among[k] == ring[i] || among[k] == ring[(i + 1) % count]) continue;
            Vec3 off = vec3_sub(mesh->vertices[among[k]], a);
            double along = vec3_dot(off, edge) / length;
            if (along < 1e-6 || along > length - 1e-6) continue;
            Vec3 beside = vec3_sub(off, vec3_scale(edge, along / length));
            if (vec3_length(beside) < 0.9 * MESH_WELD) found++;
        }
    }
    return found;
}

static void check_anchors(const Mesh *mesh) {
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        cr_expect_eq(cracks(mesh, mesh->outline + face->first_vertex, face->vertex_count, mesh->outline,
                            mesh->outline_count),
                     0, "face %d has T-vertices", f);
    }
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        cr_expect_eq(cracks(mesh, mesh->corners + element->first_corner, element->corner_count, mesh->corners,
                            mesh->corner_count),
                     0, "element %d has T-vertices", e);
    }
}

// Elements are alike here, and not cut along the things that stand on them.
Test(mesh, office_plain_has_the_counts_of_the_reference_figures) {
    Sheets s = {0};
    load(&s, "build/maps/office-plain.plan", 0);
    cr_expect_eq(s.mesh.face_count, 7454);
    cr_expect_eq(s.mesh.element_count, 80624);
    cr_expect_eq(s.mesh.patch_count, 20156);
    // The panels' undersides stand on the floor: no cell is in front of them.
    cr_expect_eq(s.mesh.lost_patches, 66 * 4 * 2);
    mesh_check_mesh(&s.mesh, s.graph.vertices);
    arena_free(&s.arena);
}

// Proves that a patch looks from where it can be seen: of shelves that go through the wall at x = 4 m, their middles inside it, one
// ends in the room, one in the next room, one in both, one in neither.
Test(mesh, patches_through_walls_look_from_their_rooms) {
    static const char PLAN[] =
        "plan 1\nstorey ground floor 0 height 2.6\nroom a 0,0 4,0 4,3 0,3 wall 0.6\n"
        "room b 4.6,0 8,0 8,3 4.6,3 wall 0.6\nmodel shelves\n"
        "  poly plain 3.90,0.5,1 4.5,0.5,1 4.5,0.8,1 3.90,0.8,1\n"
        "  poly plain 4.15,1.0,1 4.7,1.0,1 4.7,1.3,1 4.15,1.3,1\n"
        "  poly plain 3.95,1.5,1 4.7,1.5,1 4.7,1.8,1 3.95,1.8,1\n"
        "  poly plain 4.05,2.0,1 4.5,2.0,1 4.5,2.3,1 4.05,2.3,1\nend\nplace shelves 0,0\n";
    static const double PLACES[] = {3.95, 4.65, 4.65,
                                    4.275};  // the middles of what is free, and of the last one
    Sheets s = {0};
    Error error = {""};
    char *path = arena_format(&s.arena, "%s/shelves.plan", support_folder(&s.arena));
    MeshOptions coarse = {.element = 1, .per_patch = 1};
    VisOptions options = vis_default_options();
    cr_assert(file_write(path, PLAN, sizeof PLAN - 1, &error), "%s", error.text);
    cr_assert(maps_read(path, &s.arena, &s.building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&s.building, &options, &s.arena, &s.graph, &error), "%s", error.text);
    cr_assert(mesh_build(&s.graph, NULL, &coarse, &s.arena, &s.mesh, &error), "%s", error.text);
    cr_assert_eq(s.mesh.lost_patches, 1);
    for (int i = 0; i < 4; i++) {
        const Patch *patch = &s.mesh.patches[s.mesh.faces[s.mesh.face_of[i]].first_patch];
        // Tolerance: the micrometre in front of its face from which a patch is looked for.
        cr_expect_float_eq(patch->centre.x, PLACES[i], 1e-6, "shelf %d looks from x = %g", i,
                           patch->centre.x);
        cr_expect_float_eq(patch->centre.z, 1, 1e-9);
        cr_expect_eq(patch->cell, vis_locate(&s.graph, patch->centre, -1), "shelf %d", i);
    }
    arena_free(&s.arena);
}

Test(mesh, a_house_is_covered_by_its_elements) {
    Sheets s = {0};
    load(&s, "build/maps/house.plan", mesh_default_options().close);
    mesh_check_mesh(&s.mesh, s.graph.vertices);
    arena_free(&s.arena);
}

// By brute force, so in a small building.
Test(mesh, every_vertex_on_an_edge_is_a_corner_there) {
    Sheets s = {0};
    Random random = {5};
    Error error = {""};
    VisOptions options = vis_default_options();
    MeshOptions mesh_options = {.element = 0.9, .per_patch = 2};
    s.building = *fixture_rooms(&s.arena, &random, 2, 2, 2);
    cr_assert(vis_build_cells(&s.building, &options, &s.arena, &s.graph, &error), "%s", error.text);
    cr_assert(mesh_build(&s.graph, NULL, &mesh_options, &s.arena, &s.mesh, &error), "%s", error.text);
    mesh_check_mesh(&s.mesh, s.graph.vertices);
    check_anchors(&s.mesh);
    arena_free(&s.arena);
}
