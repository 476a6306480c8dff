// test_mesh_splits.c - trees over the faces of a mesh: what is asked for is what comes out, nothing of a face is lost, and bits
// that end early or were forged make a mesh all the same.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const MeshSplits ROOTS = {.even = 0};

// A room, and in it a hexagon, which is clipped out of its squares.
static Lit *room(bool hexagon) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(5, 4, 2.5), true, LIT_WALL, 0);
    MeshOptions options = {.element = 0.5, .per_patch = 2, .splits = &ROOTS};
    Vec3 v[6];
    for (int i = 0; i < 6; i++) {
        double a = 0.3 + i * M_PI / 3;
        v[i] = vec3(2.5 + 1.3 * cos(a), 2 + 1.1 * sin(a), 1);
    }
    if (hexagon) {
        building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "hexagon");
        building_add_polygon(&lit->arena, lit->building, v, 6, LIT_RED);
    }
    lit_finish_with(lit, &options);
    return lit;
}

static Mesh meshed(Lit *lit, const MeshSplits *splits) {
    Mesh mesh;
    Error error = {""};
    MeshOptions options = lit->mesh.options;
    options.splits = splits;
    cr_assert(mesh_build(&lit->graph, NULL, &options, &lit->arena, &mesh, &error), "%s", error.text);
    return mesh;
}

static Vec3 middle_of(const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < e->corner_count; i++)
        sum = vec3_add(sum, mesh->vertices[mesh->corners[e->first_corner + i]]);
    return vec3_scale(sum, 1.0 / e->corner_count);
}

static bool holds(const Mesh *mesh, int element, Vec3 p, double by) {
    const Element *e = &mesh->elements[element];
    Vec3 n = mesh->faces[e->face].plane.n;
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 a = mesh->vertices[mesh->corners[e->first_corner + i]],
             b = mesh->vertices[mesh->corners[e->first_corner + (i + 1) % e->corner_count]];
        Vec3 inwards = vec3_normalize(vec3_cross(n, vec3_sub(b, a)));
        if (vec3_dot(inwards, vec3_sub(p, a)) < -by) return false;
    }
    return true;
}

// Areas of elements sum to those of patches and faces; random points lie in the elements they are said to; no patch is too large.
static void check(const Mesh *mesh, Random *random) {
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        Vec3 v[64];
        cr_assert_leq(face->vertex_count, 64);
        for (int i = 0; i < face->vertex_count; i++)
            v[i] = mesh->vertices[mesh->outline[face->first_vertex + i]];
        double area = 0, of_patches = 0, whole = polygon_area(v, face->vertex_count);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++)
            area += mesh->elements[e].area;
        for (int p = face->first_patch; p < face->first_patch + face->patch_count; p++)
            of_patches += mesh->patches[p].area;
        cr_assert_float_eq(area, whole, 1e-9 * whole, "face %d: elements of %.12g of %.12g", f, area, whole);
        cr_assert_float_eq(of_patches, whole, 1e-9 * whole);
        for (int k = 0; k < 50; k++) {
            int i = 1 + random_index(random, face->vertex_count - 2);
            double s = random_unit(random), t = random_unit(random);
            Vec3 p = vec3_lerp(v[0], vec3_lerp(v[i], v[i + 1], t), sqrt(s));
            int e = mesh_element_at(mesh, f, p);
            cr_assert_eq(mesh->elements[e].face, f);
            // Tolerance: corners are welded within a micrometre.
            cr_assert(holds(mesh, e, p, 2e-6), "%g %g %g is not in element %d", p.x, p.y, p.z, e);
        }
    }
    for (int p = 0; p < mesh->patch_count; p++) cr_assert_leq(mesh->patches[p].element_count, 256);
}

// A depth no more than twice as long as wide, that trees lead to.
static MeshDepth some_depth(Random *random, int least, int most) {
    int x = least + random_index(random, most - least + 1), y = x + random_index(random, 3) - 1;
    y = y < least ? least : y > most ? most : y;
    return (MeshDepth){(unsigned char)x, (unsigned char)y};
}

// Proves that what is written is what is read: depths asked for, a depth of each root, are the depths of its elements along either
// axis, and patches are as large as asked.
Test(mesh_splits, come_out_as_asked) {
    Lit *lit = room(true);
    Random random = {7};
    int count = lit->mesh.element_count;
    unsigned char *patch = ARENA_ARRAY(&lit->arena, unsigned char, count);
    MeshDepth *element = ARENA_ARRAY(&lit->arena, MeshDepth, count);
    for (int e = 0; e < count; e++) {
        patch[e] = (unsigned char)random_index(&random, 3);
        element[e] = some_depth(&random, patch[e], patch[e] + MESH_IN_PATCH);
    }
    Mesh mesh = meshed(lit, mesh_splits(&lit->mesh, patch, element, &lit->arena));
    for (int e = 0; e < mesh.element_count; e++) {
        int root = mesh_element_at(&lit->mesh, mesh.elements[e].face, middle_of(&mesh, e));
        // Hexagon: slivers go to neighbours, beyond their root's border.
        if (mesh.faces[mesh.elements[e].face].vertex_count == 6) continue;
        MeshDepth is = mesh.elements[e].depth, asked = element[root];
        cr_assert(is.x == asked.x && is.y == asked.y, "element %d is %d, %d deep, asked for: %d, %d", e, is.x,
                  is.y, asked.x, asked.y);
        double share = lit->mesh.elements[root].area / mesh.patches[mesh.elements[e].patch].area;
        cr_assert_float_eq(share, ldexp(1, 2 * patch[root]), 1e-6, "a root has %g patches", share);
        double part = lit->mesh.elements[root].area / mesh.elements[e].area;
        cr_assert_float_eq(part, ldexp(1, asked.x + asked.y), 1e-6 * part, "a root has %g elements", part);
    }
    check(&mesh, &random);
    lit_free(lit);
}

// Proves that a mesh read again from its own depths has the same splits, bit by bit, also where halves of one square differ: what the
// file stores says all.
Test(mesh_splits, written_again_are_the_same) {
    Lit *lit = room(false);
    for (uint64_t seed = 1; seed <= 10; seed++) {
        Random random = {seed};
        const MeshSplits *splits = &ROOTS;
        Mesh mesh = lit->mesh;
        // Deeper each time, where elements ask for it.
        for (int depth = 1; depth <= 3; depth++) {
            MeshDepth *element = ARENA_ARRAY(&lit->arena, MeshDepth, mesh.element_count);
            unsigned char *patch = ARENA_ARRAY(&lit->arena, unsigned char, mesh.element_count);
            for (int e = 0; e < mesh.element_count; e++) element[e] = some_depth(&random, depth - 1, depth);
            splits = mesh_splits(&mesh, patch, element, &lit->arena);
            mesh = meshed(lit, splits);
        }
        MeshDepth *again = ARENA_ARRAY(&lit->arena, MeshDepth, mesh.element_count);
        unsigned char *roots = ARENA_ARRAY(&lit->arena, unsigned char, mesh.element_count);
        for (int e = 0; e < mesh.element_count; e++) again[e] = mesh.elements[e].depth;
        MeshSplits *back = mesh_splits(&mesh, roots, again, &lit->arena);
        cr_assert_eq(back->bit_count, splits->bit_count);
        cr_assert_arr_eq(back->bits, splits->bits, (size_t)(splits->bit_count + 7) / 8);
    }
    lit_free(lit);
}

// Proves that any bits whatever make a mesh that covers its faces, as deep as 64 squares along a root, also when they end early.
Test(mesh_splits, random_and_forged_bits) {
    Lit *lit = room(true);
    int deepest = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(30, 1000); seed++) {
        Random random = {seed};
        unsigned char bits[256];
        MeshSplits splits = {.bit_count = random_index(&random, 8 * (int)sizeof bits), .bits = bits};
        bool all = seed % 5 == 0;
        for (size_t i = 0; i < sizeof bits; i++)
            bits[i] = all ? 0xff : (unsigned char)(random_next(&random) & random_next(&random));
        Mesh mesh = meshed(lit, &splits);
        check(&mesh, &random);
        for (int e = 0; e < mesh.element_count; e++)
            deepest = mesh.elements[e].depth.x > deepest ? mesh.elements[e].depth.x : deepest;
    }
    cr_expect_eq(deepest, MESH_DEEPEST);
    lit_free(lit);
}

// Proves that no patch has more elements than a shot can tell apart, with the most elements along its side and cuts through all of
// them; and that such a mesh is lit without loss.
Test(mesh_splits, patches_of_very_many_elements) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(3, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(1.5, 1.5, 2.4));
    // Boards across the floor, askew, that cover little of it.
    for (int i = 0; i < 20; i++) {
        double y = 0.1 + 0.1 * i;
        Vec3 p = vec3(0.1, y, 0), q = vec3(2.9, y + 0.7, 0), along = vec3(0, 0.01, 0), up = vec3(0, 0, 0.2);
        lit_quad(lit, p, q, vec3_add(q, up), vec3_add(p, up), LIT_RED);
        p = vec3_add(p, along), q = vec3_add(q, along);
        lit_quad(lit, q, p, vec3_add(p, up), vec3_add(q, up), LIT_RED);
    }
    MeshOptions options = {.element = 0.15, .per_patch = 16, .close = 0.05};
    lit_finish_with(lit, &options);
    Random random = {3};
    check(&lit->mesh, &random);
    RadOptions rad = rad_default_options();
    RadSolution s;
    rad.form_factor.resolution = 50;
    RadReport report = lit_shoot(lit, &rad, &s);
    cr_assert_leq(report.residual, rad.residual);
    lit_free(lit);
}

// Proves that a plain too large for its elements is refused with a sentence, whatever its splits, and at once.
Test(mesh_splits, too_many_squares_are_refused) {
    static const unsigned char BITS[1] = {0xff};
    const MeshSplits some = {.bit_count = 8, .bits = (unsigned char *)BITS};
    const MeshSplits *splits[2] = {&ROOTS, &some};
    Lit *lit = room(true);
    for (int i = 0; i < 2; i++) {
        MeshOptions options = {.element = 0.01, .per_patch = 1, .splits = splits[i]};
        Vec3 *vertices = ARENA_ARRAY(&lit->arena, Vec3, lit->graph.vertex_count);
        for (int v = 0; v < lit->graph.vertex_count; v++)
            vertices[v] = vec3_scale(lit->graph.vertices[v], 5e4);
        Mesh mesh;
        Error error = {""};
        CellGraph large = lit->graph;
        large.vertices = vertices;
        cr_assert_not(mesh_build(&large, NULL, &options, &lit->arena, &mesh, &error));
        cr_assert(strstr(error.text, "take larger ones"), "%s", error.text);
    }
    lit_free(lit);
}
