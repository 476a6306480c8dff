// gltf.c - glTF 2.0 documents, .gltf and .glb (Khronos, glTF 2.0 Specification, 2021), as polygons alone.
//
// What is read: the default scene (or the first) with its nodes, meshes of triangles, materials by their colours, lamps
// and cameras. What is not: animation, skins and morph targets (meshes are as at rest), points and lines, normals.
#include "maps/polygons/gltf.h"
#include "maps/building/reader.h"
#include "maps/building/texture.h"

enum { HEADER = 12, CHUNK_HEADER = 8 };
static const uint32_t MAGIC = 0x46546C67, CHUNK_JSON = 0x4E4F534A, CHUNK_BIN = 0x004E4942;

// Extensions that may be required: those read, and those that change looks alone. A name that ends in `_` stands for
// all that begin so.
static const char *const EXTENSIONS[] = {"KHR_lights_punctual",   "KHR_mesh_quantization", "KHR_materials_",
                                         "KHR_texture_transform", "KHR_texture_basisu",    "EXT_texture_webp",
                                         "KHR_xmp_json_ld"};

// ---- the container

static uint32_t word_at(Bytes content, size_t at) {
    uint32_t word;
    memcpy(&word, content.data + at, sizeof word);
    return word;
}

static bool is_binary(Bytes content) { return content.size >= 4 && word_at(content, 0) == MAGIC; }

static bool open_binary(Gltf *g, Bytes content, Bytes *json) {
    if (content.size < HEADER + CHUNK_HEADER) {
        return error_set(g->error, "%s: has %zu bytes (a .glb file has %d at least)", g->path, content.size,
                         HEADER + CHUNK_HEADER);
    }
    if (word_at(content, 4) != 2)
        return error_set(g->error, "%s: byte 4: version %u (allowed: 2)", g->path, word_at(content, 4));
    if (word_at(content, 8) != content.size) {
        return error_set(g->error, "%s: byte 8: the length is given as %u (the file has %zu bytes)", g->path,
                         word_at(content, 8), content.size);
    }
    int chunk = 0;
    for (size_t at = HEADER; at < content.size; chunk++) {
        size_t left = content.size - at;
        if (left < CHUNK_HEADER || word_at(content, at) > left - CHUNK_HEADER) {
            return error_set(g->error, "%s: byte %zu: chunk %d is cut short (%zu bytes are left)", g->path,
                             at, chunk, left);
        }
        Bytes body = {content.data + at + CHUNK_HEADER, word_at(content, at)};
        uint32_t type = word_at(content, at + 4);
        if (chunk == 0 && type != CHUNK_JSON)
            return error_set(g->error, "%s: byte %zu: the first chunk has type %08X (allowed: JSON, %08X)",
                             g->path, at + 4, type, CHUNK_JSON);
        if (chunk == 0) *json = body;
        if (chunk == 1 && type == CHUNK_BIN) g->chunk = body;
        at += CHUNK_HEADER + body.size;
    }
    return true;
}

static bool parse_document(Gltf *g, Bytes json, size_t offset) {
    if (json.size > GLTF_MAX_JSON) {
        return error_set(g->error,
                         "%s: has %zu bytes of JSON (allowed: %zu; a .glb keeps its numbers outside)",
                         g->path, json.size, GLTF_MAX_JSON);
    }
    json_error_t why;
    static const char MARK[] = "\xEF\xBB\xBF";
    size_t skip = json.size >= 3 && memcmp(json.data, MARK, 3) == 0 ? 3 : 0;
    g->root = json_loadb((const char *)json.data + skip, json.size - skip, JSON_REJECT_DUPLICATES, &why);
    if (!g->root) {
        return error_set(g->error, "%s: byte %zu (line %d of the JSON): %.160s", g->path,
                         offset + skip + (size_t)(why.position > 0 ? why.position : 0), why.line, why.text);
    }
    if (json_is_object(g->root)) return true;
    return error_set(g->error, "%s: the JSON is no object (allowed: a glTF document)", g->path);
}

// ---- the document

static bool check_version(Gltf *g) {
    GltfItem root = gltf_root(g), asset = gltf_member(g, &root, "asset");
    const char *version = gltf_text(g, &asset, "version", "missing"),
               *least = gltf_text(g, &asset, "minVersion", "2.0");
    if (g->failed) return false;
    if (strncmp(version, "2.", 2) != 0)
        return gltf_fail(g, &asset, "version", "is %.20s (allowed: 2.0 and later 2)", version);
    if (strcmp(least, "2.0") != 0)
        return gltf_fail(g, &asset, "minVersion", "is %.20s (allowed: 2.0)", least);
    return true;
}

static bool is_known(const char *name) {
    for (size_t i = 0; i < sizeof EXTENSIONS / sizeof *EXTENSIONS; i++) {
        size_t length = strlen(EXTENSIONS[i]);
        bool family = EXTENSIONS[i][length - 1] == '_';
        if (family ? strncmp(name, EXTENSIONS[i], length) == 0 : strcmp(name, EXTENSIONS[i]) == 0)
            return true;
    }
    return false;
}

static bool check_extensions(Gltf *g) {
    GltfItem root = gltf_root(g);
    int count = gltf_count(g, &root, "extensionsRequired");
    for (int i = 0; i < count; i++) {
        const char *name =
            json_string_value(json_array_get(json_object_get(g->root, "extensionsRequired"), (size_t)i));
        if (name && is_known(name)) continue;
        return gltf_fail(g, &root, "extensionsRequired",
                         "`%.60s` is not read (allowed: documents that do without, exported again without "
                         "compression)",
                         name ? name : "what is no string");
    }
    return !g->failed;
}

static bool count_lists(Gltf *g) {
    int buffers = gltf_list_count(g, "buffers"), meshes = gltf_list_count(g, "meshes"),
        materials = gltf_list_count(g, "materials"), images = gltf_list_count(g, "images");
    if (g->failed) return false;
    if (materials > SOUP_MAX_MATERIALS) {
        GltfItem root = gltf_root(g);
        return gltf_fail(g, &root, "materials", "has %d elements (allowed: %d)", materials,
                         SOUP_MAX_MATERIALS);
    }
    g->buffers = ARENA_ARRAY(g->scratch, Bytes, buffers);
    g->meshes = ARENA_ARRAY(g->scratch, GltfMesh, meshes);
    g->images = ARENA_ARRAY(g->scratch, GltfImage, images);
    g->materials = ARENA_ARRAY(g->scratch, int, materials + 1);
    for (int i = 0; i <= materials; i++) g->materials[i] = -1;
    return true;
}

static void note_count(Gltf *g, int count, const char *what) {
    if (count > 0)
        building_note(g->arena, g->b, NOTE_DROPPED, vec3(0, 0, 0), "%s: %d %s", g->path, count, what);
}

static void note_losses(Gltf *g) {
    note_count(g, g->tally.lines, "primitives of points or lines were left out");
    note_count(g, g->tally.flat, "polygons have no area and were left out");
    note_count(g, g->tally.suns, "directional lights have no place and were left out");
    note_count(g, g->tally.pictures,
               "textures are missing or could not be decoded (PNG, JPEG and BMP can) and count as white");
    note_count(g, g->tally.skins, "meshes with skins or morph targets are as at rest");
    int scenes = gltf_list_count(g, "scenes");
    if (scenes > 1) note_count(g, scenes - 1, "more scenes were left out: the default one was read");
}

static bool read_document(Gltf *g, Bytes content) {
    Bytes json = content;
    if (is_binary(content) && !open_binary(g, content, &json)) return false;
    if (!parse_document(g, json, (size_t)(json.data - content.data))) return false;
    if (!check_version(g) || !check_extensions(g) || !count_lists(g) || !gltf_place_nodes(g)) return false;
    note_losses(g);
    g->b->hash = g->folder.hash;
    return soup_finish(g->path, &g->capped, "lengths in glTF are metres: scale the model before export",
                       g->arena, g->b, g->error);
}

static bool read_gltf(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Arena scratch = {0};
    Gltf g = {.path = path,
              .pixels = TEXTURE_FREE_PIXELS,
              .size = content.size,
              .folder = {.path = path, .arena = arena, .b = out},
              .arena = arena,
              .scratch = &scratch,
              .b = out,
              .error = error};
    bool good = read_document(&g, content);
    json_decref(g.root);
    arena_free(&scratch);
    return good;
}

// A .glb file, or JSON that speaks of an asset , as every document does.
static bool recognise_gltf(Bytes content) {
    if (is_binary(content)) return true;
    size_t at = 0;
    while (at < content.size && strchr(" \t\r\n\xEF\xBB\xBF", content.data[at]) && content.data[at]) at++;
    return at < content.size && content.data[at] == '{' &&
           memmem(content.data, content.size, "\"asset\"", strlen("\"asset\"")) != NULL;
}

const MapsReader MAPS_READER_GLTF = {
    .name = "gltf",
    .suffixes = ".glb .gltf",
    .summary = "glTF 2.0 models of buildings: polygons alone",
    .recognise = recognise_gltf,
    .read = read_gltf,
};
