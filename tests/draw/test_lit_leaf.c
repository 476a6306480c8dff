// test_lit_leaf.c - leaves that stand elsewhere than they were baked: their light there, and where it was baked.
#include <criterion/criterion.h>

#include "engine/lit/lit_leaf.h"
#include "maps/maps.h"
#include "radiosity/shoot/shoot.h"
#include "visibility/vis.h"

typedef struct Baked {
    Arena arena;
    Building building;
    CellGraph graph;
    Mesh mesh;
    RadSolution solution;
    LitMesh *lit;
    LitLight light;
    float (*leaf)[3];
} Baked;

// The two rooms with the door as drawn. In every room the irradiance is the same on everything: `left` W/m^2 where x is below 4, `right`
// elsewhere; lamps do not emit.
static Baked *open_baked(double left, double right) {
    Arena arena = {0};
    Baked *b = ARENA_ARRAY(&arena, Baked, 1);
    Error error;
    VisOptions vis = vis_default_options();
    MeshOptions options = mesh_default_options();
    options.element = 0.5;
    b->arena = arena;
    cr_assert(maps_read("build/maps/two-rooms.plan", &b->arena, &b->building, &error), "%s", error.text);
    for (int i = 0; i < b->building.material_count; i++) b->building.materials[i].emission = (Rgb){0, 0, 0};
    cr_assert(vis_build_cells(&b->building, &vis, &b->arena, &b->graph, &error), "%s", error.text);
    float *doors = ARENA_ARRAY(&b->arena, float, b->building.opening_count + 1);
    for (int i = 0; i < b->building.opening_count; i++) doors[i] = 0;
    cr_assert(mesh_build(&b->graph, doors, &options, &b->arena, &b->mesh, &error), "%s", error.text);
    cr_assert(rad_start_dark(&b->mesh, &b->arena, &b->solution, &error), "%s", error.text);
    for (int e = 0; e < b->mesh.element_count; e++) {
        const Element *element = &b->mesh.elements[e];
        const Material *m = mesh_material(&b->mesh, element->face);
        double h = b->mesh.vertices[b->mesh.corners[element->first_corner]].x < 4 ? left : right, rho[3];
        rgb_doubles(m->reflectance, rho);
        for (int c = 0; c < 3; c++) b->solution.radiosity[e][c] = rho[c] * h;
    }
    b->lit = lit_mesh_new(&b->mesh, &b->arena, &b->arena);
    b->light = lit_light_new(b->lit, &b->arena);
    lit_light_fill(b->lit, &b->solution, NULL, &b->light);
    b->leaf = arena_alloc(&b->arena, (size_t)lit_vertex_count(b->lit) + 1, sizeof *b->leaf);
    return b;
}

static void close_baked(Baked *b) {
    Arena arena = b->arena;
    arena_free(&arena);
}

static int first_leaf(const Baked *b) {
    int o = 0;
    while (o < b->building.object_count && b->graph.objects[o].leaf < 0) o++;
    cr_assert_lt(o, b->building.object_count, "two-rooms has no leaf");
    return o;
}

// The least and the greatest irradiance on a leaf's vertices, by radiosity and reflectance.
static void irradiance_of(const Baked *b, int object, double *least, double *most) {
    const Object *o = &b->graph.objects[object];
    const LitFace *begin = lit_object_begin(b->lit, o);
    int first = begin->first_vertex;
    *least = INFINITY;
    *most = 0;
    for (const LitFace *face = begin; face < lit_object_end(b->lit, o); face++) {
        double rho[3];
        rgb_doubles(b->building.materials[face->material].reflectance, rho);
        for (int v = face->first_vertex; v < face[1].first_vertex; v++) {
            double h = (double)b->leaf[v - first][1] / rho[1];
            *least = fmin(*least, h);
            *most = fmax(*most, h);
        }
    }
}

// Proves that where the same light falls on everything, it falls on a leaf wherever that stands. Tolerance: floats, and the fit of planes
// by which light comes to vertices.
Test(lit_leaf, even_light_stays_even) {
    Baked *b = open_baked(7, 7);
    int leaf = first_leaf(b);
    for (double open = 0; open <= 1; open += 0.125) {
        double least, most;
        cr_expect_eq(lit_leaf_light(b->lit, &b->light, leaf, open, b->leaf), open > 0);
        irradiance_of(b, leaf, &least, &most);
        cr_expect(least > 7 * (1 - 1e-4) && most < 7 * (1 + 1e-4), "at %g: %g to %g", open, least, most);
    }
    close_baked(b);
}

// Proves that a leaf where it was baked keeps its baked light to the last bit, and that one that is open has light between that of the
// two rooms, on every polygon: here its baked light is nothing, as of a leaf that was between two dark rooms.
Test(lit_leaf, open_leaves_have_the_light_of_rooms) {
    Baked *b = open_baked(2, 10);
    int leaf = first_leaf(b);
    const Object *o = &b->graph.objects[leaf];
    int first = lit_object_begin(b->lit, o)->first_vertex, end = lit_object_end(b->lit, o)->first_vertex;
    memset(b->light.vertex + first, 0, (size_t)(end - first) * sizeof *b->light.vertex);
    double least, most;
    cr_expect_not(lit_leaf_light(b->lit, &b->light, leaf, 0, b->leaf));
    irradiance_of(b, leaf, &least, &most);
    cr_expect_eq(most, 0);
    cr_expect(lit_leaf_light(b->lit, &b->light, leaf, 1, b->leaf));
    irradiance_of(b, leaf, &least, &most);
    cr_expect(least > 2 * (1 - 1e-4) && most < 10 * (1 + 1e-4), "open: %g to %g", least, most);
    // On the way there it changes without a jump: by no more than the light of the brighter room in a tenth of a metre.
    double before = 0;
    for (double open = 0.002; open <= 0.2; open += 0.002) {
        lit_leaf_light(b->lit, &b->light, leaf, open, b->leaf);
        irradiance_of(b, leaf, &least, &most);
        cr_expect(fabs(most - before) < 1, "at %g: from %g to %g", open, before, most);
        before = most;
    }
    close_baked(b);
}

// Proves that the plug of a door that was baked open has the mean light of both rooms when the door closes: nothing of it is black.
// Tolerance as above.
Test(lit_leaf, plugs_have_the_light_of_both_rooms) {
    Baked *b = open_baked(2, 10);
    int plugs = 0;
    for (int o = 0; o < b->graph.object_count; o++) {
        const Object *object = &b->graph.objects[o];
        if (!object->plug) continue;
        int first = lit_object_begin(b->lit, object)->first_vertex,
            end = lit_object_end(b->lit, object)->first_vertex;
        memset(b->light.vertex + first, 0, (size_t)(end - first) * sizeof *b->light.vertex);
        double least, most;
        lit_plug_light(b->lit, &b->light, o, b->leaf);
        irradiance_of(b, o, &least, &most);
        cr_expect(least > 2 * (1 - 1e-4) && most < 10 * (1 + 1e-4), "plug %d: %g to %g", o, least, most);
        plugs++;
    }
    cr_expect_geq(plugs, 1);
    close_baked(b);
}
