// export_glb.c - the document and its container (Khronos, glTF 2.0 Specification, 2021, 3.4 and 4.4; KHR_materials_unlit).
#include "engine/app/export_glb.h"

#include "engine/app/app.h"
#include "engine/app/export_parts.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"

// What a place of middling brightness becomes in linear light: as in a walk, behind its curve.
static const double MIDDLE = 0.52;
// A container counts its bytes in 32 bits.
static const size_t LARGEST = (size_t)UINT32_MAX - 64;

json_t *export_text(const char *text) {
    json_t *json = json_string(text ? text : "");
    if (json) return json;
    Arena scratch = {0};
    char *copy = arena_string(&scratch, text);
    for (char *c = copy; *c; c++) *c = (unsigned char)*c < 0x80 ? *c : '?';
    json = json_string(copy);
    arena_free(&scratch);
    return json;
}

static bool emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

static json_t *rgb(Rgb c) { return json_pack("[f f f]", (double)c.r, (double)c.g, (double)c.b); }

// Light is in the vertices: unlit, white. What the surface is made of is told apart.
int export_material(Export *e, int index, ExportLook look) {
    int *known = &e->material[index * EXPORT_LOOKS + (int)look];
    if (*known >= 0) return *known;
    const Material *m = &e->graph->building->materials[index];
    Rgb base = look == EXPORT_GLASS ? m->reflectance : (Rgb){1, 1, 1};
    json_t *json =
        json_pack("{s:o s:{s:[f f f f] s:f s:f} s:{s:{}} s:{s:o s:o}}", "name", export_text(m->name),
                  "pbrMetallicRoughness", "baseColorFactor", fmin((double)base.r, 1), fmin((double)base.g, 1),
                  fmin((double)base.b, 1), look == EXPORT_GLASS ? (double)m->alpha : 1.0, "metallicFactor",
                  0.0, "roughnessFactor", 1.0, "extensions", "KHR_materials_unlit", "extras", "reflectance",
                  rgb(m->reflectance), "emission_W_per_m2", rgb(m->emission));
    if (look != EXPORT_WALL) json_object_set_new(json, "doubleSided", json_true());
    if (look == EXPORT_GLASS) json_object_set_new(json, "alphaMode", json_string("BLEND"));
    json_array_append_new(e->materials, json);
    return *known = (int)json_array_size(e->materials) - 1;
}

// The logarithmic mean of what does not emit, each place by the light that leaves it, made MIDDLE (Reinhard, Stark, Shirley &
// Ferwerda 2002).
static double find_exposure(const Mesh *mesh, const RadSolution *solution) {
    double power = 0, logs = 0;
    for (int i = 0; i < mesh->element_count; i++) {
        const Element *element = &mesh->elements[i];
        const double *b = solution->radiosity[i];
        double y = 0.2126 * b[0] + 0.7152 * b[1] + 0.0722 * b[2];
        if (emits(mesh_material(mesh, element->face)) || !(y > 0)) continue;
        logs += element->area * y * log(y);
        power += element->area * y;
    }
    return power > 0 ? MIDDLE / exp(logs / power) : 1;
}

static void start(Export *e, const Mesh *mesh, const RadSolution *solution, const float *door_open) {
    *e = (Export){.mesh = mesh, .graph = mesh->graph, .door_open = door_open};
    const Box box = mesh->graph->box;
    e->nodes = nodes_of(mesh, &e->arena);
    e->light = reconstruct_light(mesh, solution, &e->arena);
    e->exposure = find_exposure(mesh, solution);
    // Positions are floats: whole metres from the middle, lest those of georeferenced buildings lose their digits.
    e->origin = vec3(round((box.min.x + box.max.x) / 2), round((box.min.y + box.max.y) / 2), 0);
    e->materials = json_array();
    e->meshes = json_array();
    e->accessors = json_array();
    e->vertex = ARENA_ARRAY(&e->arena, int, e->nodes.count);
    e->stamp = ARENA_ARRAY(&e->arena, int, e->nodes.count);
    int looks = mesh->graph->building->material_count * EXPORT_LOOKS;
    e->material = ARENA_ARRAY(&e->arena, int, looks);
    for (int i = 0; i < looks; i++) e->material[i] = -1;
}

// ---- the document

static ExportTree make_tree(Export *e) {
    const CellGraph *graph = e->graph;
    bool *wanted = ARENA_ARRAY(&e->arena, bool, graph->object_count + 1);
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            wanted[o] = wanted[o] || export_shows(e, o, p);
    }
    return export_tree(graph, wanted, &e->arena);
}

static size_t view_size(const Export *e, int view) {
    return view == EXPORT_POSITIONS ? (size_t)e->position_count * sizeof *e->position
           : view == EXPORT_COLOURS ? (size_t)e->colour_count * sizeof *e->colour
                                    : (size_t)e->index_count * sizeof *e->index;
}

static json_t *views_of(const Export *e, size_t *total) {
    enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER = 34963 };
    json_t *views = json_array();
    *total = 0;
    for (int v = 0; v < EXPORT_VIEWS; v++) {
        json_t *view = json_pack("{s:i s:I s:I s:i}", "buffer", 0, "byteOffset", (json_int_t)*total,
                                 "byteLength", (json_int_t)view_size(e, v), "target",
                                 v == EXPORT_INDICES ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER);
        int stride = v == EXPORT_POSITIONS ? sizeof *e->position : sizeof *e->colour;
        if (v != EXPORT_INDICES) json_object_set_new(view, "byteStride", json_integer(stride));
        json_array_append_new(views, view);
        *total += view_size(e, v);
    }
    return views;
}

static json_t *extras_of(const Export *e) {
    return json_pack("{s:f s:f s:s}", "exposure_m2_per_W", e->exposure, "W_per_m2_per_unit", 1 / e->exposure,
                     "light",
                     "COLOR_0, linear, is radiant exitance times the exposure; above 1 (lamps, and what is "
                     "close to them) it is cut off at 1");
}

static json_t *document_of(Export *e, size_t *binary) {
    ExportTree tree = make_tree(e);
    json_t *nodes = json_array(), *cameras = json_array();
    int root = export_nodes(e, &tree, nodes, cameras);
    json_t *views = views_of(e, binary);
    json_t *json = json_pack("{s:{s:s s:s} s:[s] s:i s:[{s:o s:[i] s:o}] s:o s:o s:o s:o s:o s:[{s:I}]}",
                             "asset", "version", "2.0", "generator", "Enfilade " APP_VERSION,
                             "extensionsUsed", "KHR_materials_unlit", "scene", 0, "scenes", "name",
                             export_text(tree.nodes[0].name), "nodes", root, "extras", extras_of(e), "nodes",
                             nodes, "meshes", e->meshes, "materials", e->materials, "accessors", e->accessors,
                             "bufferViews", views, "buffers", "byteLength", (json_int_t)*binary);
    CORE_ASSERT(json);
    if (json_array_size(cameras) > 0)
        json_object_set_new(json, "cameras", cameras);
    else
        json_decref(cameras);
    return json;
}

// ---- the container

static size_t whole(size_t size) { return (size + 3) / 4 * 4; }

static unsigned char *put(unsigned char *at, const void *data, size_t size) {
    if (size > 0) memcpy(at, data, size);
    return at + size;
}

// A chunk's head: its length and its kind, four letters.
static unsigned char *put_head(unsigned char *at, size_t length, const char kind[4]) {
    uint32_t size = (uint32_t)length;
    return put(put(at, &size, 4), kind, 4);
}

// Little-endian, as this machine.
static bool write_container(const char *path, const Export *e, const char *text, size_t binary,
                            Error *error) {
    enum { HEADS = 12 + 8 + 8 };
    size_t length = strlen(text), total = HEADS + whole(length) + whole(binary);
    if (total > LARGEST)
        return error_set(error, "%s: would have %zu bytes (a .glb has at most %zu): take larger elements",
                         path, total, LARGEST);
    unsigned char *file = memory_new(total), *at = file;
    uint32_t head[2] = {2, (uint32_t)total};
    at = put(put(at, "glTF", 4), head, sizeof head);
    at = put(put_head(at, whole(length), "JSON"), text, length);
    memset(at, ' ', whole(length) - length);
    at = put_head(at + whole(length) - length, whole(binary), "BIN\0");
    at = put(at, e->position, view_size(e, EXPORT_POSITIONS));
    at = put(at, e->colour, view_size(e, EXPORT_COLOURS));
    put(at, e->index, view_size(e, EXPORT_INDICES));
    bool good = file_write(path, file, total, error);
    memory_free(file);
    return good;
}

bool export_glb(const char *path, const Mesh *mesh, const RadSolution *solution, const float *door_open,
                Error *error) {
    Export e;
    size_t binary;
    start(&e, mesh, solution, door_open);
    json_t *json = document_of(&e, &binary);
    char *text = json_dumps(json, JSON_COMPACT);
    json_decref(json);
    bool good = text ? write_container(path, &e, text, binary, error)
                     : error_set(error, "%s: no memory for its description", path);
    json_free_t give_back;
    json_get_alloc_funcs(NULL, &give_back);
    give_back(text);
    arena_free(&e.arena);
    return good;
}
