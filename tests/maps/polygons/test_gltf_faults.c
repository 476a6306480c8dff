// test_gltf_faults.c - what the glTF reader refuses, each fault with its place; and damage at random.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/text.h"
#include "tests/support/files/gltf_fixture.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_GLTF;

typedef struct Case {
    const char *text, *expected;
} Case;

Test(gltf, faults_of_the_document) {
    static const Case ASSETS[] = {
        {"{\"version\":\"1.0\"}", "asset.version: is 1.0 (allowed: 2.0 and later 2)"},
        {"{\"version\":2}", "asset.version: is a number (allowed: a string)"},
        {"{\"version\":\"2.0\",\"minVersion\":\"2.1\"}", "asset.minVersion: is 2.1"},
        {"7", "asset: is a number (allowed: an object)"}};
    static const Case HEADS[] = {
        {"\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],",
         "`KHR_draco_mesh_compression` is not read"},
        {"\"extensionsRequired\":[\"EXT_meshopt_compression\"],", "`EXT_meshopt_compression` is not read"},
        {"\"extensionsRequired\":[7],", "`what is no string` is not read"},
        {"\"materials\":7,", "materials: is a number (allowed: an array)"},
        {"\"a\":1,\"a\":2,", "duplicate object key"},
        {"\"a\":1e400,", "real number overflow"},
        {"\"a\":99999999999999999999,", "too big integer"},
        {"\"a\":NaN,", "line 1 of the JSON"},
        {"\"a\":\"\\u0000\",", "\\u0000 is not allowed"},
    };
    static const Case BUFFERS[] = {
        {"{\"byteLength\":169,\"uri\":\"data:;base64,AAAA\"}",
         "buffers[0].byteLength: is 169 (the buffer has 3 bytes)"},
        {"{\"byteLength\":2147483648}", "buffers[0].byteLength: is 2147483648 (allowed 1 to 2147483647)"},
        {"{\"byteLength\":-1}", "buffers[0].byteLength: is -1"},
        {"{\"byteLength\":168}", "buffers[0].uri: is missing"},
        {"{\"uri\":\"x.bin\"}", "buffers[0].byteLength: is missing"},
        {"{\"byteLength\":168,\"uri\":\"data:,AAAA\"}", "allowed of data: `data:TYPE;base64,...`"},
        {"{\"byteLength\":168,\"uri\":\"data:;base64,A*AA\"}", "character 1 of the data is byte 42"},
        {"{\"byteLength\":168,\"uri\":\"../x.bin\"}",
         "refers to the file `../x.bin` (allowed: files in its own folder"},
        {"{\"byteLength\":168,\"uri\":\"a/../../x.bin\"}", "(allowed: files in its own folder"},
        {"{\"byteLength\":168,\"uri\":\"%2e%2E/x.bin\"}", "refers to the file `../x.bin`"},
        {"{\"byteLength\":168,\"uri\":\"/etc/passwd\"}", "refers to the file `/etc/passwd`"},
        {"{\"byteLength\":168,\"uri\":\"..\\\\x.bin\"}", "refers to the file `..\\x.bin` (allowed"},
        {"{\"byteLength\":168,\"uri\":\"\"}", "refers to the file ``"},
        {"{\"byteLength\":168,\"uri\":\"a%00b\"}", "has `%00` (allowed: %01 to %FF)"},
        {"{\"byteLength\":168,\"uri\":\"nothing-here.bin\"}", "nothing-here.bin"},
    };
    for (size_t i = 0; i < sizeof ASSETS / sizeof *ASSETS; i++) {
        GltfDocument d = gltf_usual();
        d.asset = ASSETS[i].text;
        gltf_refuse(&d, ASSETS[i].expected);
    }
    for (size_t i = 0; i < sizeof HEADS / sizeof *HEADS; i++) {
        GltfDocument d = gltf_usual();
        d.head = HEADS[i].text;
        gltf_refuse(&d, HEADS[i].expected);
    }
    for (size_t i = 0; i < sizeof BUFFERS / sizeof *BUFFERS; i++) {
        GltfDocument d = gltf_usual();
        d.buffer = BUFFERS[i].text;
        gltf_refuse(&d, BUFFERS[i].expected);
    }
}

Test(gltf, faults_of_views) {
    static const Case VIEWS[] = {
        {"[{\"byteLength\":96}]", "bufferViews[0].buffer: is missing"},
        {"[{\"buffer\":1,\"byteLength\":96}]", "bufferViews[0].buffer: is 1 (allowed 0 to 0)"},
        {"[{\"buffer\":0}]", "bufferViews[0].byteLength: is missing"},
        {"[{\"buffer\":0,\"byteLength\":169}]", "bufferViews[0]: bytes 0 to 169 (its buffer has 168)"},
        {"[{\"buffer\":0,\"byteOffset\":2147483647,\"byteLength\":2147483647}]",
         "bufferViews[0]: bytes 2147483647 to 4294967294"},
        {"[{\"buffer\":0,\"byteLength\":96,\"byteStride\":3}]",
         "bufferViews[0].byteStride: is 3 (allowed 4 to 252)"},
        {"[{\"buffer\":0,\"byteLength\":96,\"byteStride\":4}]",
         "accessors[0]: elements of 12 bytes every 4 bytes (allowed: 12 or more)"},
        {"[{\"buffer\":0,\"byteLength\":95}]",
         "accessors[0].count: 8 elements from byte 0 end at byte 96 (its view has 95)"},
        {"[7]", "bufferViews[0]: is a number (allowed: an object)"},
        {"[]", "accessors[0].bufferView: refers to the document's bufferViews (it has none)"},
        {"[{\"buffer\":0,\"byteLength\":96}]", "accessors[1].bufferView: is 1 (allowed 0 to 0)"},
        {"[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":94,\"byteLength\":72}]",
         "meshes[0].primitives[0].indices: index 0 is 4"},
    };
    for (size_t i = 0; i < sizeof VIEWS / sizeof *VIEWS; i++) {
        GltfDocument d = gltf_usual();
        d.views = VIEWS[i].text;
        gltf_refuse(&d, VIEWS[i].expected);
    }
}

Test(gltf, faults_of_accessors) {
    static const Case ACCESSORS[] = {
        {"[]", "attributes.POSITION: refers to the document's accessors (it has none)"},
        {"[{\"bufferView\":0,\"componentType\":5124,\"count\":8,\"type\":\"VEC3\"}]",
         "accessors[0].componentType: is 5124 (allowed 5120 to 5123, 5125, 5126)"},
        {"[{\"bufferView\":0,\"componentType\":5127,\"count\":8,\"type\":\"VEC3\"}]",
         "accessors[0].componentType: is"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC2\"}]",
         "accessors[0].type: is VEC2 (allowed here: VEC3)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8}]", "accessors[0].type: is missing"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\"}]", "accessors[0].count: is missing"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":0,\"type\":\"VEC3\"}]",
         "accessors[0].count: is 0"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":2147483648,\"type\":\"VEC3\"}]",
         "accessors[0].count: is 2147483648 (allowed 1 to 4194304)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":1.5,\"type\":\"VEC3\"}]",
         "accessors[0].count: is 1.5"},
        {"[{\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"}]", "neither a bufferView nor sparse"},
        {"[{\"bufferView\":0,\"byteOffset\":1,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"}]",
         "end at byte 97 (its view has 96)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"normalized\":true,\"count\":8,\"type\":\"VEC3\"}]",
         "accessors[0].normalized: is true"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":9,"
         "\"indices\":{},\"values\":{}}}]",
         "accessors[0].sparse.count: is 9 (allowed 1 to 8)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":1}}]",
         "accessors[0].sparse: lacks indices or values"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
         "\"indices\":{"
         "\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}}]",
         "accessors[0].sparse.indices: index 1 is 0 (allowed 1 to 7: they increase)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
         "\"indices\":{"
         "\"bufferView\":0,\"componentType\":5126},\"values\":{\"bufferView\":0}}}]",
         "accessors[0].sparse.indices.componentType: is 5126"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},{\"bufferView\":1,"
         "\"componentType\":5122,\"count\":36,\"type\":\"SCALAR\"}]",
         "accessors[1].componentType: is 5122 (allowed of indices"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":7,\"type\":\"VEC3\"},{\"bufferView\":1,"
         "\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}]",
         "meshes[0].primitives[0].indices: index 6 is 7 (allowed 0 to 6)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},{\"bufferView\":1,"
         "\"componentType\":5123,\"count\":35,\"type\":\"SCALAR\"}]",
         "has 35 corners (allowed of triangles: a multiple of 3)"},
    };
    for (size_t i = 0; i < sizeof ACCESSORS / sizeof *ACCESSORS; i++) {
        GltfDocument d = gltf_usual();
        d.accessors = ACCESSORS[i].text;
        gltf_refuse(&d, ACCESSORS[i].expected);
    }
    // Not a number where a position should be: the sign of the first float's bytes, all set.
    GltfDocument d = gltf_usual();
    Arena arena = {0};
    unsigned char bytes[GLTF_BYTES];
    gltf_room_bytes(bytes);
    memset(bytes + 4, 0xFF, 4);
    d.buffer = arena_format(&arena, "{\"byteLength\":168,\"uri\":\"data:;base64,%s\"}",
                            gltf_base64(&arena, bytes, GLTF_BYTES));
    gltf_refuse(&d, "accessors[0]: number 1 of element 0 is not finite");
    arena_free(&arena);
}

Test(gltf, faults_of_nodes) {
    static const Case NODES[] = {
        {"[]", "scenes[0].nodes[0]: refers to the document's nodes (it has none)"},
        {"[{\"mesh\":1}]", "nodes[0].mesh: is 1 (allowed 0 to 0)"},
        {"[{\"mesh\":-1}]", "nodes[0].mesh: is -1"},
        {"[{\"mesh\":\"0\"}]", "nodes[0].mesh: is a string (allowed: a number from 0 to 0)"},
        {"[{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}]",
         "nodes[2].children: node 1 is a child of node 0 too (allowed: one parent)"},
        {"[{},{\"children\":[2]},{\"children\":[3]},{\"children\":[1]}]",
         "is its own ancestor (allowed: no cycles)"},
        {"[{\"children\":[0]}]", "nodes[0]: is its own ancestor"},
        {"[{},{\"children\":[0]}]", "scenes[0].nodes: node 0 is a child"},
        {"[{\"children\":[9]}]", "nodes[0].children[0]: is 9 (allowed 0 to 0)"},
        {"[{\"children\":7}]", "nodes[0].children: is a number (allowed: an array)"},
        {"[{\"matrix\":[1,2,3]}]", "nodes[0].matrix: has 3 numbers (allowed: 16)"},
        {"[{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2]}]",
         "nodes[0].matrix: ends its columns with 0, 0, 0, 2"},
        {"[{\"translation\":[1,2,\"3\"]}]", "nodes[0].translation[2]: is a string"},
        {"[{\"translation\":[1,2,1e300]}]", "nodes[0].translation[2]: is 1e+300 (allowed -1e+15 to 1e+15)"},
        {"[{\"rotation\":[0,0,0,0]}]", "nodes[0].rotation: has length 0 (allowed: 1)"},
        {"[{\"mesh\":0,\"translation\":[1e9,0,0]}]", "nodes[0]: a corner of its mesh lies at (1e+09"},
        {"[{\"mesh\":0,\"scale\":[0,0,0]}]", "t.gltf: holds no polygon that has an area"},
        {"[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{}}}]",
         "EXT_mesh_gpu_instancing: is not read"},
        {"[{\"camera\":0}]", "nodes[0].camera: refers to the document's cameras (it has none)"},
        {"[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]", "KHR_lights_punctual.light: is 0"},
        {"[{\"extensions\":7}]", "nodes[0].extensions: is a number (allowed: an object)"},
    };
    for (size_t i = 0; i < sizeof NODES / sizeof *NODES; i++) {
        GltfDocument d = gltf_usual();
        d.nodes = NODES[i].text;
        gltf_refuse(&d, NODES[i].expected);
    }
    GltfDocument d = gltf_usual();
    d.scene = "\"scene\":0,\"scenes\":[{\"nodes\":[0,0]}]";
    gltf_refuse(&d, "scenes[0].nodes: node 0 is named twice");
    d.scene = "\"scene\":1,\"scenes\":[{\"nodes\":[0]}]";
    gltf_refuse(&d, "scene: is 1 (allowed 0 to 0)");
}

Test(gltf, faults_of_meshes) {
    static const Case MESHES[] = {
        {"{}", "meshes[0].primitives: is missing or empty"},
        {"{\"primitives\":[{}]}", "meshes[0].primitives[0].attributes.POSITION: is missing"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":9}}]}",
         "meshes[0].primitives[0].attributes.POSITION: is 9 (allowed 0 to 1)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":7}]}",
         "primitives[0].mode: is 7 (allowed 0 to 6)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}",
         "has 8 corners (allowed of triangles: a multiple of 3)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":1}}]}",
         "accessors[1].type: is SCALAR (allowed here: VEC3)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":0}]}", "accessors[0].type: is VEC3"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}",
         "the document's materials (it has none)"},
    };
    for (size_t i = 0; i < sizeof MESHES / sizeof *MESHES; i++) {
        GltfDocument d = gltf_usual();
        d.mesh = MESHES[i].text;
        gltf_refuse(&d, MESHES[i].expected);
    }
}

Test(gltf, faults_of_materials) {
    static const Case MATERIALS[] = {
        {"\"alphaMode\":\"CLEAR\"", "materials[0].alphaMode: is CLEAR (allowed: OPAQUE, MASK, BLEND)"},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[2,0,0,1]}",
         "materials[0].pbrMetallicRoughness.baseColorFactor[0]: is 2 (allowed 0 to 1)"},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1]}", "has 3 numbers (allowed: 4)"},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}",
         "the document's textures (it has none)"},
        {"\"emissiveFactor\":[0,0,-1]", "materials[0].emissiveFactor[2]: is -1"},
    };
    Arena arena = {0};
    for (size_t i = 0; i < sizeof MATERIALS / sizeof *MATERIALS; i++) {
        GltfDocument d = gltf_usual();
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        d.head = arena_format(&arena, "\"materials\":[{%s}],", MATERIALS[i].text);
        gltf_refuse(&d, MATERIALS[i].expected);
    }
    arena_free(&arena);
}

// A tree of nodes deeper than any stack of calls would bear.
Test(gltf, deep_tree) {
    Arena arena = {0};
    Text nodes = {.arena = &arena};
    enum { DEPTH = 100000 };
    text_append(&nodes, "[");
    for (int i = 0; i < DEPTH; i++) text_append(&nodes, "{\"children\":[%d]},", i + 1);
    text_append(&nodes, "{\"mesh\":0}]");
    GltfDocument d = gltf_usual();
    d.nodes = nodes.data;
    Building b;
    gltf_accept(&arena, &d, &b);
    cr_expect_eq(b.polygon_count, 6);
    arena_free(&arena);
}

// The fuzzer's first document, which has something of everything, is read or refused however it is damaged.
Test(gltf, survives_damage, .timeout = 300) {
    static const char *const SEEDS[] = {"tests/seeds/room.gltf", "tests/seeds/room.glb"};
    for (size_t i = 0; i < sizeof SEEDS / sizeof *SEEDS; i++) {
        Arena arena = {0};
        Bytes seed = support_read(&arena, SEEDS[i]);
        Building b;
        Error error = {""};
        cr_assert(maps_read(SEEDS[i], &arena, &b, &error), "%s", error.text);
        cr_expect(b.polygon_count == 12 && b.light_count == 1 && b.viewpoint_count == 1);
        soups_damage(&MAPS_READER_GLTF, SEEDS[i], seed.data, seed.size, 17 + i, support_count(6000, 600000));
        arena_free(&arena);
    }
}
