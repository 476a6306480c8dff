// test_reconstruct.c - light at vertices: even and linear light comes back as it is, on meshes of a building and on adaptive ones
// made here; creases stay creases, what stands on a surface parts its light, round things are smooth; nothing is gained.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "radiosity/show/reconstruct.h"
#include "tests/radiosity/show/reconstruct_fixture.h"
#include "tests/support/lit_fixture.h"

static Vec3 middle(const Mesh *mesh, const Element *e) {
    Vec3 n = mesh->faces[e->face].plane.n, sum = {0};
    const int *corner = mesh->corners + e->first_corner;
    double twice = 0;
    for (int i = 1; i + 1 < e->corner_count; i++) {
        Vec3 a = mesh->vertices[corner[0]], b = mesh->vertices[corner[i]], c = mesh->vertices[corner[i + 1]];
        double part = vec3_dot(n, vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
        sum = vec3_add(sum, vec3_scale(vec3_add(a, vec3_add(b, c)), part / 3));
        twice += part;
    }
    return vec3_scale(sum, 1 / twice);
}

static double field(Vec3 p) { return 20 + 1.3 * p.x - 0.7 * p.y + 0.9 * p.z; }

static void set_field(const Mesh *mesh, RadSolution *s) {
    for (int e = 0; e < mesh->element_count; e++)
        reconstruct_set(s, e, field(middle(mesh, &mesh->elements[e])));
}

// Largest difference to the field, of corners.
static double off_field(const Mesh *mesh, const VertexLight *light) {
    double most = 0;
    for (int i = 0; i < mesh->corner_count; i++) {
        double b = field(mesh->vertices[mesh->corners[i]]);
        for (int c = 0; c < 3; c++) most = fmax(most, fabs(light->corner[i][c] - b * (c + 1)));
    }
    return most;
}

// Proves that a linear field comes back at every corner, borders and T-vertices included, where elements of one surface differ
// in size. 1e-9: rounding of numbers about 60.
Test(reconstruct, linear_light_on_an_adaptive_mesh) {
    for (unsigned seed = 1; seed <= 40; seed++) {
        Hand hand;
        Random random = {seed};
        reconstruct_hand_start(&hand);
        reconstruct_hand_quarters(&hand, &random, 0, 0, 4, 5);
        reconstruct_hand_finish(&hand);
        RadSolution s = reconstruct_dark(&hand.mesh, &hand.arena);
        set_field(&hand.mesh, &s);
        VertexLight light = reconstruct_light(&hand.mesh, &s, &hand.arena);
        double off = off_field(&hand.mesh, &light);
        cr_assert(off < 1e-9, "seed %u: off by %g", seed, off);
        arena_free(&hand.arena);
    }
}

// Proves the same on the mesh of a building, and that points between vertices lie on the field too.
Test(reconstruct, linear_light_in_a_room) {
    Lit *lit = reconstruct_room();
    const Mesh *mesh = &lit->mesh;
    RadSolution s = reconstruct_dark(mesh, &lit->arena);
    Random random = {5};
    set_field(mesh, &s);
    VertexLight light = reconstruct_light(mesh, &s, &lit->arena);
    double off = off_field(mesh, &light);
    cr_assert(off < 1e-9, "off by %g", off);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        double t = random_between(&random, 0, 1), b[3];
        Vec3 corner = mesh->vertices[mesh->corners[element->first_corner + e % element->corner_count]];
        Vec3 p = vec3_lerp(middle(mesh, element), corner, t);
        reconstruct_at(mesh, &light, element->face, p, b);
        cr_assert_float_eq(b[1], 2 * field(p), 1e-9, "element %d: %.12f, not %.12f", e, b[1], 2 * field(p));
    }
    lit_free(lit);
}

// Proves that factors sum to 1 everywhere: of even light in rooms with furniture, corners and faces have just that.
Test(reconstruct, even_light) {
    for (unsigned seed = 1; seed <= 5; seed++) {
        Lit *lit = lit_rooms(seed);
        RadSolution s = reconstruct_dark(&lit->mesh, &lit->arena);
        for (int e = 0; e < lit->mesh.element_count; e++) reconstruct_set(&s, e, 7);
        VertexLight light = reconstruct_light(&lit->mesh, &s, &lit->arena);
        for (int i = 0; i < lit->mesh.corner_count; i++)
            cr_assert_float_eq(light.corner[i][0], 7, 1e-11, "seed %u: %g", seed, light.corner[i][0]);
        for (int f = 0; f < lit->mesh.face_count; f++) cr_assert_float_eq(light.face[f][2], 21, 1e-11);
        lit_free(lit);
    }
}

// Proves that corners of a room are creases: each face keeps its own light, whatever its neighbours have.
Test(reconstruct, creases_and_materials_stay_apart) {
    Lit *lit = reconstruct_room();
    const Mesh *mesh = &lit->mesh;
    RadSolution s = reconstruct_dark(mesh, &lit->arena);
    for (int e = 0; e < mesh->element_count; e++) reconstruct_set(&s, e, 1 + mesh->elements[e].face);
    VertexLight light = reconstruct_light(mesh, &s, &lit->arena);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++)
            cr_assert_float_eq(light.corner[i][0], 1 + element->face, 1e-11);
    }
    lit_free(lit);
    Hand hand;
    reconstruct_hand_start(&hand);
    reconstruct_hand_square(&hand, 0, 0, 1, 0);
    reconstruct_hand_square(&hand, 1, 0, 1, 1);
    reconstruct_hand_finish(&hand);
    s = reconstruct_dark(&hand.mesh, &hand.arena);
    reconstruct_set(&s, 1, 5);
    light = reconstruct_light(&hand.mesh, &s, &hand.arena);
    for (int i = 0; i < 8; i++) cr_assert_float_eq(light.corner[i][0], i < 4 ? 0 : 5, 1e-12);
    arena_free(&hand.arena);
}

// The light of a floor of 4 x 4 squares, dark up to x = 2 and 1 beyond, at (2, 2); with a wall on the line, of two thin sheets.
static void at_line(bool wall, double out[2]) {
    Hand hand;
    reconstruct_hand_start(&hand);
    for (int i = 0; i < 16; i++) reconstruct_hand_square(&hand, i % 4, i / 4, 1, 0);
    if (wall) {
        Vec3 v[4] = {{2, 0, 0}, {2, 4, 0}, {2, 4, 2}, {2, 0, 2}};
        Vec3 back[4] = {v[3], v[2], v[1], v[0]};
        reconstruct_hand_add(&hand, v, 4, 0, 1);
        reconstruct_hand_add(&hand, back, 4, 0, 1);
    }
    reconstruct_hand_finish(&hand);
    RadSolution s = reconstruct_dark(&hand.mesh, &hand.arena);
    for (int e = 0; e < 16; e++) reconstruct_set(&s, e, e % 4 > 1);
    VertexLight light = reconstruct_light(&hand.mesh, &s, &hand.arena);
    for (int e = 0; e < 16; e++) {
        const Element *element = &hand.mesh.elements[e];
        for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++) {
            Vec3 p = hand.mesh.vertices[hand.mesh.corners[i]];
            if (p.x == 2 && p.y == 2) out[e % 4 > 1] = light.corner[i][0];
        }
    }
    arena_free(&hand.arena);
}

// Proves that light does not creep along a floor under a wall that stands on it, and is smooth where nothing does.
Test(reconstruct, what_stands_on_a_surface_parts_its_light) {
    double b[2];
    at_line(false, b);
    cr_assert_float_eq(b[0], 0.5, 1e-12);
    cr_assert_float_eq(b[1], 0.5, 1e-12);
    at_line(true, b);
    cr_assert_float_eq(b[0], 0, 1e-12);
    cr_assert_float_eq(b[1], 1, 1e-12);
}

// Proves that light at nodes that alone are wanted is that of all nodes, to the last bit.
Test(reconstruct, wanted_nodes_are_nodes_of_all) {
    Lit *lit = lit_rooms(3);
    const Mesh *mesh = &lit->mesh;
    Nodes nodes = nodes_of(mesh, &lit->arena);
    RadSolution s = reconstruct_dark(mesh, &lit->arena);
    Random random = {3};
    double(*all)[3] = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *all),
    (*some)[3] = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *some);
    bool *wanted = ARENA_ARRAY(&lit->arena, bool, nodes.count);
    for (int e = 0; e < mesh->element_count; e++) reconstruct_set(&s, e, random_unit(&random));
    reconstruct_nodes(mesh, &nodes, &s, NULL, all);
    for (int round = 0; round < 20; round++) {
        int first = random_index(&random, nodes.count), count = 1 + random_index(&random, 9);
        for (int n = 0; n < nodes.count; n++) wanted[n] = n >= first && n < first + count;
        reconstruct_nodes(mesh, &nodes, &s, wanted, some);
        for (int n = first; n < first + count && n < nodes.count; n++)
            cr_assert_arr_eq(some[n], all[n], sizeof *all, "node %d", n);
    }
    lit_free(lit);
}

// ---- fits that are kept

// Proves that values of elements and of patches are fitted with what is kept from call to call just as without, to the last bit, also where
// units come to light or are covered meanwhile, and where some nodes alone are wanted. And so are they where only what differs is found
// anew.
static void check_kept(bool of_patches, bool some) {
    Lit *lit = lit_rooms(3);
    const Mesh *mesh = &lit->mesh;
    Nodes nodes = nodes_of(mesh, &lit->arena);
    Random random = {7};
    int units = of_patches ? mesh->patch_count : mesh->element_count;
    double(*value)[3] = arena_alloc(&lit->arena, (size_t)units, sizeof *value);
    double(*out[3])[3];
    for (int i = 0; i < 3; i++) out[i] = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *out[i]);
    bool *wanted = some ? ARENA_ARRAY(&lit->arena, bool, nodes.count) : NULL;
    for (int n = 0; some && n < nodes.count; n++) wanted[n] = random_index(&random, 3) > 0;
    ValueFits kept = {.arena = &lit->arena}, again = {.arena = &lit->arena};
    Marks changed = marks_new(units, &lit->arena);
    for (int round = 0; round < 8; round++) {
        marks_clear(&changed);
        for (int u = 0; u < units; u++) {
            if (round > 0 && random_index(&random, 20) > 0) continue;
            double light = random_index(&random, 4) == 0 ? 0 : random_unit(&random);
            for (int c = 0; c < 3; c++) value[u][c] = light;
            marks_add(&changed, u);
        }
        reconstruct_values(mesh, &nodes, of_patches, value, wanted, out[0], NULL, NULL);
        reconstruct_values(mesh, &nodes, of_patches, value, wanted, out[1], NULL, &kept);
        cr_assert_arr_eq(out[0], out[1], (size_t)nodes.count * sizeof *out[0], "round %d", round);
        if (round == 0)
            reconstruct_values(mesh, &nodes, of_patches, value, wanted, out[2], NULL, &again);
        else
            reconstruct_values_again(mesh, &nodes, of_patches, value, wanted, &changed, out[2], &again);
        cr_assert_arr_eq(out[0], out[2], (size_t)nodes.count * sizeof *out[0], "round %d, again", round);
    }
    lit_free(lit);
}
Test(reconstruct, kept_fits_are_fits_from_nothing) {
    for (int i = 0; i < 4; i++) check_kept(i & 1, i & 2);
}
