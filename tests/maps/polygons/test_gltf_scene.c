// test_gltf_scene.c - nodes, lights, cameras, materials and textures of a glTF file.
#include <criterion/criterion.h>

#include "engine/core/text.h"
#include "tests/support/files/gltf_fixture.h"
#include "tests/support/support.h"

// ---- the scene

// Where the room's first wall, its floor, came to lie, and which way it faces.
static Plane floor_plane(const Building *b, int object, Vec3 *low) {
    const Polygon *p = &b->polygons[b->objects[object].first_polygon];
    *low = b->vertices[p->first_vertex];
    for (int i = 1; i < p->vertex_count; i++) {
        Vec3 v = b->vertices[p->first_vertex + i];
        *low = vec3(fmin(low->x, v.x), fmin(low->y, v.y), fmin(low->z, v.z));
    }
    return plane_of_polygon(&b->vertices[p->first_vertex], p->vertex_count);
}

// Ways multiply down the tree, matrices are column by column, mirrors keep walls facing inwards, and a mesh stands at
// each node that names it. y up becomes z up.
Test(gltf, nodes) {
    Arena arena = {0};
    GltfDocument d = gltf_usual();
    d.scene = "\"scene\":1,\"scenes\":[{\"nodes\":[]},{\"nodes\":[0,5]}]";
    d.nodes = "[{\"children\":[1,2],\"translation\":[10,0,0]},"
              "{\"mesh\":0,\"name\":\"raised\",\"translation\":[0,3,0]},"
              "{\"children\":[3,4],\"scale\":[2,2,2]},"
              "{\"mesh\":0,\"name\":\"scaled\",\"translation\":[1,1,1]},"
              "{\"mesh\":0,\"name\":\"mirrored\",\"matrix\":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},"
              "{\"mesh\":0,\"rotation\":[0,0.7071067811865476,0,0.7071067811865476]}]";
    d.mesh = "{\"name\":\"hall\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}";
    Building b;
    gltf_accept(&arena, &d, &b);
    cr_assert_eq(b.object_count, 4);
    static const struct {
        const char *name;
        Vec3 low;
    } EXPECTED[] = {
        {"raised", {10, 0, 3}}, {"scaled", {12, -2, 2}}, {"mirrored", {2, 0, 0}}, {"hall", {-3, 0, 0}}};
    for (int i = 0; i < 4; i++) {
        Vec3 low;
        Plane plane = floor_plane(&b, i, &low);
        cr_expect_str_eq(b.objects[i].name, EXPECTED[i].name);
        // Tolerance: the square root of one half is rounded.
        cr_expect(vec3_length(vec3_sub(low, EXPECTED[i].low)) < 1e-9, "%s at (%g, %g, %g)", EXPECTED[i].name,
                  low.x, low.y, low.z);
        cr_expect_float_eq(plane.n.z, 1, 1e-9, "%s: its floor looks up", EXPECTED[i].name);
    }
    cr_expect_eq(soups_notes(&b, "1 more scenes were left out"), 1);
    arena_free(&arena);
}

// Lamps shine in watts and cameras look where the file says, in a building with z up.
Test(gltf, lights_and_cameras) {
    Arena arena = {0};
    GltfDocument d = gltf_usual();
    d.head =
        "\"extensionsRequired\":[\"KHR_lights_punctual\"],"
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":683,"
        "\"color\":[1,0.5,0]},{\"type\":\"spot\",\"intensity\":683,\"spot\":{\"outerConeAngle\":1.5707963},"
        "\"name\":\"lamp\"},{\"type\":\"directional\",\"intensity\":100000}]}},"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"aspectRatio\":1,\"znear\":1}},"
        "{\"type\":\"orthographic\",\"name\":\"plan\"}],";
    d.scene = "\"scenes\":[{\"nodes\":[0,1,2,3,4,5]}]";
    d.nodes =
        "[{\"mesh\":0},"
        "{\"name\":\"bulb\",\"translation\":[1,2,-3],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},"
        "{\"name\":\"door\",\"camera\":0,\"translation\":[1,1.6,-1]},"
        "{\"camera\":1,\"rotation\":[-0.3826834323650898,0,0,0.9238795325112867]}]";
    Building b;
    gltf_accept(&arena, &d, &b);
    cr_assert_eq(b.light_count, 2);
    const Light *bulb = &b.lights[0], *lamp = &b.lights[1];
    cr_expect_str_eq(bulb->name, "bulb");
    cr_expect_str_eq(lamp->name, "lamp");
    cr_expect(bulb->position.x == 1 && bulb->position.y == 3 && bulb->position.z == 2);
    // 683 cd are 1 W a steradian. Tolerance: single precision; half a sphere's angle has eight digits.
    cr_expect_float_eq((double)bulb->flux.r, 4 * M_PI, 1e-5);
    cr_expect_float_eq((double)bulb->flux.g, 2 * M_PI, 1e-5);
    cr_expect_float_eq((double)lamp->flux.b, 2 * M_PI, 1e-5);
    cr_expect_eq(soups_notes(&b, "1 directional lights"), 1);
    cr_assert_eq(b.viewpoint_count, 2);
    const Viewpoint *door = &b.viewpoints[0], *plan = &b.viewpoints[1];
    cr_expect_str_eq(door->name, "door");
    cr_expect_float_eq(door->yaw, M_PI / 2, 1e-12, "-z of the file is +y of the building");
    cr_expect_float_eq(door->fov, 1, 1e-12);
    cr_expect_float_eq(plan->pitch, -M_PI / 4, 1e-12);
    cr_expect(b.start.x == 1 && b.start.y == 1 && b.start.z == 1.6, "a walk begins at the first camera");
    arena_free(&arena);
}

// Colours, what is seen through, what shines, and the means of textures.
Test(gltf, materials) {
    static const struct {
        const char *material;
        float red, alpha, emission;
    } CASES[] = {
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.2,0.1,0.3]}", 0.5f, 1, 0},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.2,0.1,0.25]}", 0.5f,
         0.25f, 0},
        {"\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.2,0.1,0.75]}", 0.5f, 1,
         0},
        {"\"alphaMode\":\"MASK\",\"alphaCutoff\":0.8,\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0."
         "75]}",
         MAPS_MAX_COLOUR, 0, 0},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"baseColorFactor\":[0.8,1,1,1]}",
         0.8f * MAPS_MAX_COLOUR / 2, 1, 0},
        {"\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}",
         MAPS_MAX_COLOUR / 2, 1, 0},
        {"\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":2}}", 0, 0.5f, 0},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":2},"
         "\"baseColorFactor\":[1,1,1,0.5]}",
         0, 0.25f, 0},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":2}}", MAPS_MAX_COLOUR / 2, 1, 0},
        {"\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":1}}",
         MAPS_MAX_COLOUR, 0.5f, 0},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":1},\"baseColorFactor\":[0.4,1,1,1]}",
         0.4f, 1, 0},
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.75}},"
         "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]}",
         0, 0.25f, 0},
        {"\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[0.6,0,0,1]}}", 0.6f, 1,
         0},
        {"\"emissiveFactor\":[0.5,0,0],\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]},"
         "\"extensions\":{"
         "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":1366}}",
         0, 1, (float)M_PI},
    };
    Arena arena = {0};
    Bytes png = support_png(&arena, 2, 1, (const uint8_t[]){0, 0, 0, 255, 255, 255, 255, 255}),
          half = support_png(&arena, 2, 1, (const uint8_t[]){0, 0, 0, 255, 255, 255, 255, 0});
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        GltfDocument d = gltf_usual();
        d.head = arena_format(&arena,
                              "\"materials\":[{\"name\":\"paint\",%s}],\"textures\":[{\"source\":0},{"
                              "\"source\":1},{\"source\":2}],"
                              "\"images\":[{\"uri\":\"data:image/png;base64,%s\"},{\"bufferView\":0},"
                              "{\"uri\":\"data:image/png;base64,%s\"}],",
                              CASES[i].material, gltf_base64(&arena, png.data, png.size),
                              gltf_base64(&arena, half.data, half.size));
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        Building b;
        gltf_accept(&arena, &d, &b);
        cr_assert_eq(b.material_count, 1);
        const Material *m = &b.materials[0];
        cr_expect_str_eq(m->name, "paint");
        // Tolerance: single precision.
        cr_expect(fabsf(m->reflectance.r - CASES[i].red) < 1e-6f &&
                      fabsf(m->alpha - CASES[i].alpha) < 1e-6f &&
                      fabsf(m->emission.r - CASES[i].emission) < 1e-5f,
                  "%s: %g %g %g", CASES[i].material, (double)m->reflectance.r, (double)m->alpha,
                  (double)m->emission.r);
    }
    arena_free(&arena);
}

// Proves that smooth metals are mirrors of their colour, and that rough ones, dielectrics and panes are none: share and red reflectance.
Test(gltf, mirrors) {
    static const struct {
        const char *material;
        float mirror, red;
    } CASES[] = {
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.6,0.3,1],\"roughnessFactor\":0.05}", 0.6f, 0},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.6,0.3,1],\"roughnessFactor\":0.2}", 0, 0.8f},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.6,0.3,1],\"roughnessFactor\":0,"
         "\"metallicFactor\":0.5}",
         0, 0.8f},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.6,0.3,1]}", 0, 0.8f},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.6,0.3,0.5],"
         "\"roughnessFactor\":0}",
         0, 0.8f}};
    Arena arena = {0};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        GltfDocument d = gltf_usual();
        d.head = arena_format(&arena, "\"materials\":[{%s}],", CASES[i].material);
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        Building b;
        gltf_accept(&arena, &d, &b);
        const Material *m = &b.materials[0];
        // Tolerance: single precision.
        cr_expect(fabsf(m->mirror - CASES[i].mirror) < 1e-6f &&
                      fabsf(m->reflectance.r - CASES[i].red) < 1e-6f,
                  "%s: %g %g", CASES[i].material, (double)m->mirror, (double)m->reflectance.r);
    }
    arena_free(&arena);
}

// A texture that is not there, or no picture, costs its colours and is noted.
Test(gltf, lost_textures) {
    Arena arena = {0};
    static const char *const LOST[] = {"\"bufferView\":0", "\"uri\":\"nothing-here.png\"",
                                       "\"uri\":\"../up.png\""};
    for (size_t i = 0; i < sizeof LOST / sizeof *LOST; i++) {
        GltfDocument d = gltf_usual();
        d.head =
            arena_format(&arena,
                         "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
                         "\"textures\":[{\"source\":0}],\"images\":[{%s}],",
                         LOST[i]);
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        Building b;
        gltf_accept(&arena, &d, &b);
        cr_expect_eq(soups_notes(&b, "1 textures are missing or could not be decoded"), 1);
    }
    arena_free(&arena);
}

// Points and lines are no polygons; what is left of a mesh counts.
Test(gltf, leaves_out) {
    Arena arena = {0};
    GltfDocument d = gltf_usual();
    d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"mode\":1},{\"attributes\":{"
             "\"POSITION\":0},\"indices\":1,\"targets\":[{}]}]}";
    Building b;
    gltf_accept(&arena, &d, &b);
    cr_expect_eq(b.polygon_count, 6);
    cr_expect_eq(soups_notes(&b, "1 primitives of points or lines"), 1);
    cr_expect_eq(soups_notes(&b, "as at rest"), 1);
    arena_free(&arena);
}
