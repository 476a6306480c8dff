// test_mesh.c - faces, elements and patches: nothing of a polygon lost, every element convex and where its grid says, places
// welded and T-vertices anchored.
#include <criterion/criterion.h>
#include <stdio.h>
#include <time.h>

#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "radiosity/mesh/mesh.h"
#include "radiosity/mesh/mesh_places.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

// A graph of polygons alone: what the mesh needs of one where no cells are asked for.
typedef struct Sheets {
    Arena arena;
    Building building;
    CellGraph graph;
    Mesh mesh;
} Sheets;

static void start(Sheets *s) {
    *s = (Sheets){.building = {.form = FORM_SOUP, .source = "sheets"}};
    building_add_material(&s->arena, &s->building,
                          (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    building_add_material(&s->arena, &s->building, (Material){.name = "glass", .alpha = 0.3f});
    building_add_object(&s->arena, &s->building, OBJECT_FURNITURE, "sheets");
}

static bool finish(Sheets *s, double element, int per_patch, Error *error) {
    Building *b = &s->building;
    s->graph = (CellGraph){.building = b,
                           .objects = b->objects,
                           .polygons = b->polygons,
                           .vertices = b->vertices,
                           .object_count = b->object_count,
                           .polygon_count = b->polygon_count,
                           .vertex_count = b->vertex_count};
    s->graph.surface_first = ARENA_ARRAY(&s->arena, int, 1);
    s->graph.locator_first = ARENA_ARRAY(&s->arena, int, 2);
    s->graph.locator = (CellMesh){.size = 1, .nx = 1, .ny = 1};
    MeshOptions options = {.element = element, .per_patch = per_patch};
    return mesh_build(&s->graph, NULL, NULL, &options, &s->arena, &s->mesh, error);
}

static void load(Sheets *s, const char *path, double close) {
    Error error = {""};
    VisOptions options = vis_default_options();
    MeshOptions mesh_options = mesh_default_options();
    mesh_options.close = close;
    cr_assert(maps_read(path, &s->arena, &s->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&s->building, &options, &s->arena, &s->graph, &error), "%s", error.text);
    cr_assert(mesh_build(&s->graph, NULL, NULL, &mesh_options, &s->arena, &s->mesh, &error), "%s",
              error.text);
}

// ---- what holds of every mesh

static int corners_of(const Mesh *mesh, const Element *element, Vec3 *out) {
    for (int i = 0; i < element->corner_count; i++)
        out[i] = mesh->vertices[mesh->corners[element->first_corner + i]];
    return element->corner_count;
}

static void check_element(const Mesh *mesh, int e) {
    enum { MOST = 512 };
    const Element *element = &mesh->elements[e];
    const Face *face = &mesh->faces[element->face];
    Vec3 v[MOST], middle = {0, 0, 0};
    cr_assert_leq(element->corner_count, MOST);
    int count = corners_of(mesh, element, v);
    cr_assert_geq(count, 3, "element %d has %d corners", e, count);
    cr_assert_gt(element->area, 0);
    // Tolerance: corners are moved by up to MESH_WELD.
    cr_expect_float_eq(polygon_area(v, count), element->area, 1e-6 * sqrt(element->area), "element %d", e);
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(v[(i + 1) % count], v[i]);
        double length = vec3_length(edge);
        middle = vec3_add(middle, vec3_scale(v[i], 1.0 / count));
        cr_assert_gt(length, MESH_WELD, "element %d has an edge of %g m", e, length);
        for (int k = 0; k < count; k++) {
            double off = vec3_dot(vec3_cross(edge, vec3_sub(v[k], v[i])), face->plane.n) / length;
            cr_expect_geq(off, -3e-7, "element %d: corner %d is %g m outside edge %d", e, k, -off, i);
        }
    }
    cr_expect_eq(mesh_element_at(mesh, element->face, middle), e, "the middle of element %d is in %d", e,
                 mesh_element_at(mesh, element->face, middle));
}

static void check_patch(const Mesh *mesh, int p, int *next) {
    const Patch *patch = &mesh->patches[p];
    const Face *face = &mesh->faces[patch->face];
    double area = 0;
    cr_assert_eq(patch->first_element, *next, "patches are not in the order of elements");
    for (int e = *next; e < *next + patch->element_count; e++) {
        cr_assert(mesh->elements[e].patch == p && mesh->elements[e].face == patch->face);
        area += mesh->elements[e].area;
    }
    *next += patch->element_count;
    cr_expect_float_eq(area, patch->area, 1e-12 + 1e-12 * area);
    cr_expect_lt(fabs(plane_distance(face->plane, patch->centre)), 1e-9);
    int at = mesh_element_at(mesh, patch->face, patch->centre);
    // A patch that lost squares to neighbours may have its centre in one of theirs; mostly not.
    cr_expect_eq(mesh->elements[at].face, patch->face);
}

static void check_mesh(const Mesh *mesh, const Vec3 *vertices) {
    int next = 0;
    double area = 0, drawn = 0;
    for (int e = 0; e < mesh->element_count; e++) check_element(mesh, e), area += mesh->elements[e].area;
    for (int p = 0; p < mesh->patch_count; p++) check_patch(mesh, p, &next);
    cr_expect_eq(next, mesh->element_count);
    for (int f = 0; f < mesh->face_count; f++) {
        const Polygon *p = &mesh->graph->polygons[mesh->faces[f].polygon];
        cr_expect_eq(mesh->face_of[mesh->faces[f].polygon], f);
        drawn += polygon_area(vertices + p->first_vertex, p->vertex_count);
    }
    cr_expect_float_eq(area, drawn, 1e-7 * drawn, "elements have %.9g m^2 of %.9g", area, drawn);
}

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
    check_mesh(&s.mesh, s.graph.vertices);
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
    cr_assert(mesh_build(&s.graph, NULL, NULL, &coarse, &s.arena, &s.mesh, &error), "%s", error.text);
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
    check_mesh(&s.mesh, s.graph.vertices);
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
    cr_assert(mesh_build(&s.graph, NULL, NULL, &mesh_options, &s.arena, &s.mesh, &error), "%s", error.text);
    check_mesh(&s.mesh, s.graph.vertices);
    check_anchors(&s.mesh);
    arena_free(&s.arena);
}

// Lopsided convex polygons in any plane, in grids of any fineness.
Test(mesh, convex_polygons_become_convex_elements) {
    int merged = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(300, 5000); seed++) {
        Sheets s;
        Random random = {seed};
        Error error = {""};
        start(&s);
        Vec3 n = fixture_direction(&random), x = vec3_normalize(vec3_cross(n, fixture_direction(&random)));
        Vec3 y = vec3_cross(n, x), v[12], at = {random_between(&random, -1e6, 1e6), 3, -2};
        int count = 3 + random_index(&random, 10);
        double turn = random_between(&random, 0, 6.28), flat = random_between(&random, 0.05, 1);
        for (int i = 0; i < count; i++) {
            double a = turn + 6.283185307 * (i + random_between(&random, 0, 0.8)) / count;
            v[i] = vec3_add(at, vec3_add(vec3_scale(x, 2 * cos(a)), vec3_scale(y, 2 * flat * sin(a))));
        }
        building_add_polygon(&s.arena, &s.building, v, count, 0);
        bool good = finish(&s, random_between(&random, 0.05, 2), 1 + random_index(&random, 4), &error);
        cr_assert(good, "seed %llu: %s", (unsigned long long)seed, error.text);
        check_mesh(&s.mesh, s.building.vertices);
        merged += s.mesh.merged_elements;
        arena_free(&s.arena);
    }
    cr_expect_gt(merged, 100, "hardly any slivers were there to be joined");
}

Test(mesh, glass_and_what_has_no_area_are_left_out) {
    Sheets s;
    Error error = {""};
    start(&s);
    const Vec3 square[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const Vec3 needle[3] = {{0, 0, 0}, {1, 0, 0}, {1, 5e-8, 0}};
    // Six thousandths of a square metre, and nowhere wider than points are told apart.
    const Vec3 hair[3] = {{0, 0, 0}, {2e5, 0, 0}, {1e5, 6e-8, 0}};
    building_add_polygon(&s.arena, &s.building, square, 4, 1);
    cr_expect(!finish(&s, 0.3, 2, &error));
    cr_expect(strstr(error.text, "no polygon"), "%s", error.text);
    building_add_polygon(&s.arena, &s.building, square, 4, 0);
    // As a reader would not leave them.
    for (int i = 2; i < 4; i++) {
        building_add_polygon(&s.arena, &s.building, square, 4, 0);
        memcpy(s.building.vertices + s.building.polygons[i].first_vertex, i == 2 ? needle : hair,
               sizeof needle);
        s.building.polygons[i].vertex_count = 3;
    }
    cr_assert(finish(&s, 0.3, 2, &error), "%s", error.text);
    cr_expect_eq(s.mesh.face_count, 1);
    cr_expect_eq(s.mesh.dropped_faces, 2);
    cr_expect(s.mesh.face_of[0] == -1 && s.mesh.face_of[1] == 0 && s.mesh.face_of[2] == -1 &&
              s.mesh.face_of[3] == -1);
    arena_free(&s.arena);
}

Test(mesh, too_many_elements_are_refused) {
    Sheets s;
    Error error = {""};
    start(&s);
    const Vec3 plain[4] = {{0, 0, 0}, {1e3, 0, 0}, {1e3, 1e3, 0}, {0, 1e3, 0}};
    building_add_polygon(&s.arena, &s.building, plain, 4, 0);
    cr_expect(!finish(&s, 0.01, 2, &error));
    cr_expect(strstr(error.text, "take larger ones"), "%s", error.text);
    arena_free(&s.arena);
}

// Time grows with the polygons: 100,000 of them, in a heap of cubes that share corners and edges, take about half a second
// of one core here. The limit is wide because machines are loaded.
Test(mesh, a_hundred_thousand_polygons_are_quick) {
    enum { SIDE = 26 };
    static const int WALL[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    Sheets s;
    Error error = {""};
    start(&s);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        Vec3 at = {0.5 * (i % SIDE), 0.25 + 0.5 * (i / SIDE % SIDE), 0.5 * (i / SIDE / SIDE)}, v[4];
        for (int w = 0; w < 6; w++) {
            for (int k = 0; k < 4; k++)
                v[k] = vec3_add(
                    at, vec3(0.5 * (WALL[w][k] & 1), 0.25 * (WALL[w][k] >> 1 & 1), 0.5 * (WALL[w][k] >> 2)));
            building_add_polygon(&s.arena, &s.building, v, 4, 0);
        }
    }
    clock_t before = clock();
    cr_assert(finish(&s, 0.5, 1, &error), "%s", error.text);
    double seconds = (double)(clock() - before) / CLOCKS_PER_SEC;
    printf("%d polygons: %.2f s\n", s.mesh.face_count, seconds);
    cr_expect_lt(seconds, 3);
    arena_free(&s.arena);
}
