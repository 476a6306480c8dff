// test_radiosity_view.c - what a patch has before it: that culling loses no face a ray from it can meet, whatever the method,
// and that views far from the origin, of thin sheets and of neighbours in one plane are right.
#include <criterion/criterion.h>

#include "maps/maps.h"
#include "radiosity/factors/view.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    float *door_open;
    Mesh mesh;
    Viewer *viewer;
} Made;

static void finish(Made *m) {
    VisOptions options = vis_default_options();
    MeshOptions mesh_options = mesh_default_options();
    Error error = {""};
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest));
    cr_assert(mesh_build(&m->graph, m->door_open, &mesh_options, &m->arena, &m->mesh, &error), "%s",
              error.text);
    m->viewer = viewer_new(&m->mesh, &m->forest, m->door_open, &m->arena);
}

static void make_map(Made *m, const char *name) {
    Error error = {""};
    cr_assert(maps_read(name, &m->arena, &m->building, &error), "%s", error.text);
    finish(m);
}

static ViewPoint point_of(const Mesh *mesh, int patch) {
    const Patch *p = &mesh->patches[patch];
    return (ViewPoint){p->centre, mesh->faces[p->face].plane.n, p->cell};
}

// ---- the oracle: rays against all faces, in building space

// Where a ray meets a face, metres; infinite where it does not. Faces whose plane holds the eye are passed by.
static double meet(const Mesh *mesh, int f, Vec3 eye, Vec3 along) {
    const Face *face = &mesh->faces[f];
    const Vec3 *v = mesh->vertices;
    const int *corner = mesh->outline + face->first_vertex;
    double off = vec3_dot(face->plane.n, vec3_sub(v[corner[0]], eye)), slope = vec3_dot(face->plane.n, along);
    if (fabs(off) < 1e-7 || slope == 0 || off / slope <= 0) return INFINITY;
    double side = slope < 0 ? 1 : -1;
    for (int i = 0; i < face->vertex_count; i++) {
        Vec3 a = vec3_sub(v[corner[i]], eye),
             b = vec3_sub(v[corner[i + 1 == face->vertex_count ? 0 : i + 1]], eye);
        if (side * vec3_dot(vec3_cross(a, b), along) > 0) return INFINITY;
    }
    return off / slope;
}

static int first_met(const Mesh *mesh, Vec3 eye, Vec3 along, double *distance) {
    int first = -1;
    *distance = INFINITY;
    for (int f = 0; f < mesh->face_count; f++) {
        double r = mesh->faces[f].hidden ? INFINITY : meet(mesh, f, eye, along);
        if (r >= *distance) continue;
        *distance = r;
        first = f;
    }
    return first;
}

// Every face that a ray meets first is in the view, with its numbers; rays that meet nothing are no fault.
static void check_rays(Made *m, uint64_t seed, int patches, int rays) {
    Random random = {seed};
    const Mesh *mesh = &m->mesh;
    unsigned char *listed[CULLINGS];
    for (int c = 0; c < CULLINGS; c++) listed[c] = ARENA_ARRAY(&m->arena, unsigned char, mesh->face_count);
    int met = 0;
    for (int i = 0; i < patches; i++) {
        int patch = random_index(&random, mesh->patch_count);
        ViewPoint from = point_of(mesh, patch);
        if (from.cell < 0) continue;
        for (int c = 0; c < CULLINGS; c++) {
            const View *view = viewer_look(m->viewer, &from, (Culling)c);
            memset(listed[c], 0, (size_t)mesh->face_count);
            for (int k = 0; k < view->face_count; k++) listed[c][view->faces[k].face] = 1;
        }
        for (int k = 0; k < rays; k++) {
            Vec3 along = fixture_direction(&random);
            // Near the horizon views and rays are decided by rounding.
            if (fabs(vec3_dot(along, from.normal)) < 1e-6) continue;
            if (vec3_dot(along, from.normal) < 0) along = vec3_scale(along, -1);
            double distance;
            int face = first_met(mesh, from.eye, along, &distance);
            if (face < 0) continue;
            met++;
            for (int c = 0; c < CULLINGS; c++)
                cr_expect(listed[c][face], "seed %#llx: patch %d misses face %d at %g m, culling %s",
                          (unsigned long long)seed, patch, face, distance, CULLING_NAMES[c]);
        }
    }
    cr_expect(met > patches * rays / 10, "only %d rays met anything", met);
}

Test(radiosity_view, rays_meet_only_what_is_listed_in_an_office) {
    Made m = {0};
    make_map(&m, "build/maps/office-plain.plan");
    check_rays(&m, 0x51ab, support_count(80, 2000), 100);
    arena_free(&m.arena);
}

Test(radiosity_view, rays_meet_only_what_is_listed_in_a_house) {
    Made m = {0};
    make_map(&m, "build/maps/house.plan");
    check_rays(&m, 0x51ac, support_count(120, 2000), 100);
    arena_free(&m.arena);
}

// Doors open, ajar and closed; two storeys with a shaft.
Test(radiosity_view, rays_meet_only_what_is_listed_whatever_the_doors) {
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(4, 100); seed++) {
        Made m = {0};
        Random random = {seed};
        m.building = *fixture_rooms(&m.arena, &random, 4, 3, 2);
        m.door_open = ARENA_ARRAY(&m.arena, float, m.building.opening_count + 1);
        for (int i = 0; i < m.building.opening_count; i++)
            m.door_open[i] = (float)random_index(&random, 3) / 2;
        finish(&m);
        check_rays(&m, seed, 60, 60);
        arena_free(&m.arena);
    }
}

// Rows are the same only if what is in both views is the same to the last bit.
Test(radiosity_view, faces_are_the_same_whatever_is_culled) {
    Made m = {0};
    make_map(&m, "build/maps/house.plan");
    Viewer *other = viewer_new(&m.mesh, &m.forest, NULL, &m.arena);
    Random random = {0x51ad};
    const ViewFace **of_face = ARENA_ARRAY(&m.arena, const ViewFace *, m.mesh.face_count);
    for (int i = 0; i < 200; i++) {
        ViewPoint from = point_of(&m.mesh, random_index(&random, m.mesh.patch_count));
        const View *all = viewer_look(other, &from, CULL_NONE);
        memset(of_face, 0, (size_t)m.mesh.face_count * sizeof *of_face);
        for (int k = 0; k < all->face_count; k++) of_face[all->faces[k].face] = &all->faces[k];
        const View *some = viewer_look(m.viewer, &from, CULL_STAB);
        for (int k = 0; k < some->face_count; k++) {
            const ViewFace *a = &some->faces[k], *b = of_face[a->face];
            cr_assert(b && a->vertex_count == b->vertex_count && a->d == b->d && vec3_equal(a->n, b->n));
            for (int j = 0; j < a->vertex_count; j++)
                cr_assert(
                    vec3_equal(some->vertices[a->first_vertex + j], all->vertices[b->first_vertex + j]));
        }
    }
    arena_free(&m.arena);
}

// ---- a square looked at from a point

// A square of 1 m in the plane z = height, its front down, about (x, y); an eye on the floor below it or beside it.
static const View *look_at_sheet(Arena *arena, Vec3 at, double height, bool beside) {
    Building *b = ARENA_ARRAY(arena, Building, 1);
    b->form = FORM_SOUP;
    b->source = "sheet";
    int stone = building_add_material(
        arena, b, (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    building_add_object(arena, b, OBJECT_FURNITURE, "sheet");
    const double corner[4][2] = {{-0.5, -0.5}, {-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}};
    Vec3 v[4];
    for (int i = 0; i < 4; i++) v[i] = vec3_add(at, vec3(corner[i][0], corner[i][1], height));
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    building_add_polygon(arena, b, v, 4, stone);
    // A graph without cells: views then list all that there is.
    *graph = (CellGraph){.building = b,
                         .objects = b->objects,
                         .polygons = b->polygons,
                         .vertices = b->vertices,
                         .object_count = 1,
                         .polygon_count = b->polygon_count,
                         .vertex_count = b->vertex_count};
    graph->surface_first = ARENA_ARRAY(arena, int, 1);
    graph->locator_first = ARENA_ARRAY(arena, int, 2);
    graph->locator = (SquareGrid){.size = 1, .nx = 1, .ny = 1};
    StabForest *forest = ARENA_ARRAY(arena, StabForest, 1);
    forest->root = ARENA_ARRAY(arena, int, 1);
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    MeshOptions options = mesh_default_options();
    Error error = {""};
    cr_assert(mesh_build(graph, NULL, &options, arena, mesh, &error), "%s", error.text);
    Viewer *viewer = viewer_new(mesh, forest, NULL, arena);
    ViewPoint from = {vec3_add(at, vec3(beside ? 3 : 0.1, 0.2, 0)), {0, 0, 1}, -1};
    return viewer_look(viewer, &from, CULL_NONE);
}

// Sheets as thin as 2e-7 m stay, at the origin, 1 km and 1,000 km off; those in the eye's plane go.
Test(radiosity_view, thin_sheets_stay_and_the_eyes_own_plane_goes) {
    static const double SHIFT[] = {0, 1e3, 1e6};
    static const double HEIGHT[] = {2e-7, 1e-6, 1e-4};
    for (int s = 0; s < 3; s++) {
        Vec3 at = {SHIFT[s], -SHIFT[s] / 3, SHIFT[s] / 7};
        for (int h = 0; h < 3; h++) {
            Arena arena = {0};
            const View *view = look_at_sheet(&arena, at, HEIGHT[h], false);
            cr_assert_eq(view->face_count, 1, "a sheet at %g m, %g m from the origin, is lost", HEIGHT[h],
                         SHIFT[s]);
            // Tolerance: two roundings of coordinates of 1e6 m.
            cr_expect_float_eq(view->faces[0].d, -HEIGHT[h], 3e-10);
            cr_expect_float_eq(view->faces[0].n.z, -1, 1e-15);
            arena_free(&arena);
        }
        for (int beside = 0; beside < 2; beside++) {
            Arena arena = {0};
            const View *view = look_at_sheet(&arena, at, 0, beside);
            cr_expect_eq(view->face_count, 0, "the eye's own plane is seen %g m from the origin", SHIFT[s]);
            arena_free(&arena);
        }
    }
}
