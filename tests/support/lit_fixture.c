// lit_fixture.c - rooms with a lamp, made in memory.
#include "tests/support/lit_fixture.h"

#include <criterion/criterion.h>
#include <stdlib.h>

#include "tests/support/fixture.h"

Lit *lit_new(void) {
    Lit *lit = calloc(1, sizeof *lit);
    cr_assert_not_null(lit);
    Building *b = lit->building = ARENA_ARRAY(&lit->arena, Building, 1);
    b->form = FORM_SOUP;
    b->source = "lit";
    b->hash = 77;
    Material wall = {.name = "wall", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1};
    Material lamp = {.name = "lamp", .emission = {12, 10, 6}, .alpha = 1};
    Material red = {.name = "red", .reflectance = {0.7f, 0.2f, 0.1f}, .alpha = 1};
    building_add_material(&lit->arena, b, wall);
    building_add_material(&lit->arena, b, lamp);
    building_add_material(&lit->arena, b, red);
    return lit;
}

int lit_picture(Lit *lit, int width, int height, const uint8_t *texels, TextureMap map) {
    Building *b = lit->building;
    int texture = texture_add_pixels(&lit->arena, b, "picture", width, height, texels);
    Material m = {
        .name = "picture", .reflectance = b->textures[texture].mean, .alpha = 1, .texture = texture};
    m.texture_map = building_add_texture_map(&lit->arena, b, map);
    return building_add_material(&lit->arena, b, m);
}

void lit_quad(Lit *lit, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int material) {
    Vec3 v[4] = {p, q, r, s};
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "quad");
    building_add_polygon(&lit->arena, lit->building, v, 4, material);
    for (int i = 0; i < 4; i++)
        lit->building->world = box_union(
            lit->building->polygon_count > 1 ? lit->building->world : box_empty(), (Box){v[i], v[i]});
}

void lit_box(Lit *lit, Vec3 l, Vec3 h, bool inwards, int material, int mask) {
    Vec3 v[8] = {{l.x, l.y, l.z}, {h.x, l.y, l.z}, {h.x, h.y, l.z}, {l.x, h.y, l.z},
                 {l.x, l.y, h.z}, {h.x, l.y, h.z}, {h.x, h.y, h.z}, {l.x, h.y, h.z}};
    static const int OUTWARDS[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                       {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
    for (int i = 0; i < 6; i++) {
        const int *o = OUTWARDS[i];
        if (mask >> i & 1) continue;
        if (inwards)
            lit_quad(lit, v[o[3]], v[o[2]], v[o[1]], v[o[0]], material);
        else
            lit_quad(lit, v[o[0]], v[o[1]], v[o[2]], v[o[3]], material);
    }
}

void lit_lamp(Lit *lit, Vec3 m) {
    lit_quad(lit, vec3(m.x - 0.5, m.y - 0.5, m.z), vec3(m.x - 0.5, m.y + 0.5, m.z),
             vec3(m.x + 0.5, m.y + 0.5, m.z), vec3(m.x + 0.5, m.y - 0.5, m.z), LIT_LAMP);
}

void lit_finish_with(Lit *lit, const MeshOptions *mesh) {
    Error error = {""};
    VisOptions options = vis_default_options();
    options.threads = 1;
    cr_assert(vis_build_cells(lit->building, &options, &lit->arena, &lit->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&lit->graph, &options, NULL, &lit->arena, &lit->forest));
    cr_assert(mesh_build(&lit->graph, NULL, mesh, &lit->arena, &lit->mesh, &error), "%s", error.text);
}

void lit_finish(Lit *lit, double element, int per_patch) {
    MeshOptions mesh = {.element = element, .per_patch = per_patch};
    lit_finish_with(lit, &mesh);
}

Lit *lit_rooms(uint64_t seed) {
    Lit *lit = calloc(1, sizeof *lit);
    cr_assert_not_null(lit);
    Random random = {seed};
    Building *b = lit->building = fixture_rooms(&lit->arena, &random, 3, 3, 1);
    Material lamp = {.name = "lamp", .emission = {12, 10, 6}, .alpha = 1};
    int glow = building_add_material(&lit->arena, b, lamp);
    for (int o = 0; o < b->object_count; o++)
        if (b->objects[o].polygon_count > 1) b->polygons[b->objects[o].first_polygon + 1].material = glow;
    lit_finish(lit, 0.5, 2);
    return lit;
}

void lit_free(Lit *lit) {
    arena_free(&lit->arena);
    free(lit);
}

RadReport lit_shoot(Lit *lit, const RadOptions *options, RadSolution *out) {
    Error error = {""};
    cr_assert(rad_start(&lit->mesh, &lit->arena, out, &error), "%s", error.text);
    return rad_shoot(&lit->mesh, &lit->forest, NULL, options, NULL, out);
}
