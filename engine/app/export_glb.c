// export_glb.c - the document and its container (Khronos, glTF 2.0 Specification, 2021, 3.4 and 4.4; KHR_materials_unlit).
#include "engine/app/export_glb.h"

#include <jansson.h>
#include <stdlib.h>

#include "engine/app/app.h"
#include "engine/app/export_pictures.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/core/polygon.h"
#include "radiosity/show/reconstruct.h"
#include "visibility/vis.h"

typedef struct ExportNode {
    const char *name;
    int parent;        // -1: the root
    int leaf;          // in Building.leaves: moves as it; -1
    int first_object;  // of CellGraph; its objects are first_object, next[first_object] ..; -1: none
    int last_object;
} ExportNode;

// The root is node 0; parents come before their children.
typedef struct ExportTree {
    ExportNode *nodes;
    int count, capacity;
    int *next;  // [graph->object_count] -1: the last of its node
} ExportTree;

typedef struct Builder {
    const CellGraph *graph;
    ExportTree *tree;
    Arena *arena;
    int *storey, *region, *opening;  // nodes of them, -1: none yet
    int outdoors;
} Builder;

static int *none_yet(int count, Arena *arena) {
    int *nodes = ARENA_ARRAY(arena, int, count + 1);
    for (int i = 0; i < count; i++) nodes[i] = -1;
    return nodes;
}

static int add_tree_node(Builder *b, const char *name, const char *otherwise, int parent) {
    ExportTree *tree = b->tree;
    *ARENA_PUSH(b->arena, tree->nodes, tree->count, tree->capacity) =
        (ExportNode){.name = name && *name ? name : otherwise,
                     .parent = parent,
                     .leaf = -1,
                     .first_object = -1,
                     .last_object = -1};
    return tree->count - 1;
}

static void add_object(Builder *b, int node, int object) {
    ExportNode *n = &b->tree->nodes[node];
    if (n->last_object < 0)
        n->first_object = object;
    else
        b->tree->next[n->last_object] = object;
    n->last_object = object;
}

static int storey_node(Builder *b, int storey) {
    if (storey < 0) return 0;
    if (b->storey[storey] < 0)
        b->storey[storey] = add_tree_node(b, b->graph->building->storeys[storey].name, "storey", 0);
    return b->storey[storey];
}

static int opening_node(Builder *b, int opening) {
    const Opening *o = &b->graph->building->openings[opening];
    if (b->opening[opening] < 0)
        b->opening[opening] =
            add_tree_node(b, o->name, opening_kind_name(o->kind), storey_node(b, o->storey));
    return b->opening[opening];
}

static int region_node(Builder *b, int index) {
    const Region *r = &b->graph->building->regions[index];
    if (r->opening >= 0) return opening_node(b, r->opening);
    if (b->region[index] < 0)
        b->region[index] = add_tree_node(b, r->name, r->kind == REGION_SHAFT ? "stairwell" : "room",
                                         storey_node(b, r->storey));
    return b->region[index];
}

// The node of a cell's room; the root in a building without regions, and where there is no cell.
static int cell_node(Builder *b, int cell) {
    if (cell < 0 || b->graph->building->form != FORM_REGIONS) return 0;
    const Cell *c = &b->graph->cells[cell];
    if (vis_region(b->graph, cell)->kind != REGION_OUTDOORS && c->region >= 0)
        return region_node(b, c->region);
    if (b->outdoors < 0) b->outdoors = add_tree_node(b, "outdoors", "", 0);
    return b->outdoors;
}

static const char *kind_name(ObjectKind kind) {
    static const char *const NAMES[OBJECT_KINDS] = {"furniture", "stairs", "low wall", "frame",
                                                    "leaf",      "lamp",   "surface"};
    return NAMES[kind];
}

static void place_object(Builder *b, int index) {
    const Object *o = &b->graph->objects[index];
    Box box = b->graph->object_boxes[index];
    int parent = o->opening >= 0 ? opening_node(b, o->opening)
                                 : cell_node(b, vis_locate(b->graph, vec3_lerp(box.min, box.max, 0.5), -1));
    int node = add_tree_node(b, o->name, kind_name(o->kind), parent);
    b->tree->nodes[node].leaf = o->leaf;
    add_object(b, node, index);
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

// The tree holds only objects that `wanted` [object_count] names.
static ExportTree export_tree(const CellGraph *graph, const bool *wanted, Arena *arena) {
    const Building *building = graph->building;
    Arena scratch = {0};
    ExportTree tree = {.next = none_yet(graph->object_count, arena)};
    Builder b = {.graph = graph, .tree = &tree, .arena = arena, .outdoors = -1};
    b.storey = none_yet(building->storey_count, &scratch);
    b.region = none_yet(building->region_count, &scratch);
    b.opening = none_yet(building->opening_count, &scratch);
    add_tree_node(&b, base_name(building->source), "building", -1);
    int *cell_of = none_yet(graph->object_count, &scratch);
    for (int c = 0; c < graph->cell_count; c++)
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++) cell_of[o] = c;
    for (int o = 0; o < graph->object_count; o++) {
        if (!wanted[o]) continue;
        if (cell_of[o] >= 0)
            add_object(&b, cell_node(&b, cell_of[o]), o);
        else
            place_object(&b, o);
    }
    arena_free(&scratch);
    return tree;
}

// How a polygon is drawn: walls from their front alone, things from both sides, glass as it lets light through.
// With EXPORT_PICTURED it shows its picture.
typedef enum ExportLook {
    EXPORT_WALL,
    EXPORT_THING,
    EXPORT_GLASS,
    EXPORT_PICTURED = 4,
    EXPORT_LOOKS = 8
} ExportLook;

typedef struct Export {
    const Mesh *mesh;
    const CellGraph *graph;
    const float *door_open;
    Nodes nodes;
    VertexLight light;
    double exposure;  // m^2/W
    Vec3 origin;      // of positions, building space
    Arena arena;
    json_t *materials, *meshes, *accessors;
    int *material;  // [material_count * EXPORT_LOOKS] in `materials`, -1: not yet there
    ExportPictures pictures;
    // The binary part, each with its own view.
    float (*position)[3];
    uint16_t (*colour)[4];
    float (*radiant)[3];  // exitance, W/m^2, without an end
    float (*place)[2];    // in the picture; 0, 0 without one
    uint32_t *index;
    int position_count, position_capacity, colour_count, colour_capacity, radiant_count, radiant_capacity,
        place_count, place_capacity, index_count, index_capacity;
    // The vertex that a node of light became in the primitive at hand.
    int *vertex, *stamp, now;  // [nodes.count]
} Export;

// Views of the binary part.
enum { EXPORT_POSITIONS, EXPORT_COLOURS, EXPORT_RADIANT, EXPORT_INDICES, EXPORT_PLACES, EXPORT_VIEWS };

// A place of middling brightness becomes this in linear light, as in a walk behind its curve.
static const double MIDDLE = 0.52;
// A container counts its bytes in 32 bits.
static const size_t LARGEST = (size_t)UINT32_MAX - 64;

// A text as JSON; bytes that are no UTF-8 become question marks.
static json_t *export_text(const char *text) {
    json_t *json = json_string(text ? text : "");
    if (json) return json;
    Arena scratch = {0};
    char *copy = arena_string(&scratch, text);
    for (char *c = copy; *c; c++) *c = (unsigned char)*c < 0x80 ? *c : '?';
    json = json_string(copy);
    arena_free(&scratch);
    return json;
}

static bool material_emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

static json_t *rgb(Rgb c) { return json_pack("[f f f]", (double)c.r, (double)c.g, (double)c.b); }

// The light is in the vertices, so the material is unlit, and white or its picture. `extras` holds the surface's reflectance and emission.
static int export_material(Export *e, int index, ExportLook look) {
    int *known = &e->material[index * EXPORT_LOOKS + (int)look];
    if (*known >= 0) return *known;
    const Material *m = &e->graph->building->materials[index];
    bool glass = (look & ~EXPORT_PICTURED) == EXPORT_GLASS;
    Rgb base = glass ? m->reflectance : (Rgb){1, 1, 1};
    json_t *json =
        json_pack("{s:o s:{s:[f f f f] s:f s:f} s:{s:{}} s:{s:o s:o}}", "name", export_text(m->name),
                  "pbrMetallicRoughness", "baseColorFactor", fmin((double)base.r, 1), fmin((double)base.g, 1),
                  fmin((double)base.b, 1), glass ? (double)m->alpha : 1.0, "metallicFactor", 0.0,
                  "roughnessFactor", 1.0, "extensions", "KHR_materials_unlit", "extras", "reflectance",
                  rgb(m->reflectance), "emission_W_per_m2", rgb(m->emission));
    if (look & EXPORT_PICTURED) {
        json_t *pbr = json_object_get(json, "pbrMetallicRoughness");
        json_object_set_new(pbr, "baseColorTexture",
                            json_pack("{s:i}", "index", export_picture(&e->pictures, index)));
        double opacity = (double)e->graph->building->textures[m->texture].opacity;
        if (glass)
            json_object_set_new(pbr, "baseColorFactor",
                                json_pack("[f f f f]", 1.0, 1.0, 1.0, fmin((double)m->alpha / opacity, 1)));
    }
    if ((look & ~EXPORT_PICTURED) != EXPORT_WALL) json_object_set_new(json, "doubleSided", json_true());
    if (glass) json_object_set_new(json, "alphaMode", json_string("BLEND"));
    json_array_append_new(e->materials, json);
    return *known = (int)json_array_size(e->materials) - 1;
}

// ---- meshes: a primitive a material and look

enum { FULL = 65535 };  // of a normalized unsigned short

static int look_of(const Export *e, int object, int polygon) {
    int pictured = export_pictured(e->graph->building, &e->graph->polygons[polygon]) ? EXPORT_PICTURED : 0;
    if (vis_is_glass(e->graph, polygon)) return EXPORT_GLASS | pictured;
    return (e->graph->objects[object].kind == OBJECT_SURFACE ? EXPORT_WALL : EXPORT_THING) | pictured;
}

// Does the polygon have anything to draw?
static bool export_shows(const Export *e, int object, int polygon) {
    return vis_shown(&e->graph->objects[object], e->door_open) &&
           (e->mesh->face_of[polygon] >= 0 || vis_is_glass(e->graph, polygon));
}

// ---- the polygons of a node, by material

typedef struct Shown {
    int polygon, key, order;
} Shown;

typedef struct ShownList {
    Shown *shown;
    int count, capacity;
    Arena arena;
} ShownList;

static int by_key(const void *a, const void *b) {
    const Shown *x = a, *y = b;
    return x->key != y->key ? (x->key < y->key ? -1 : 1) : (x->order > y->order) - (x->order < y->order);
}

static void list_shown(const Export *e, const ExportTree *tree, const ExportNode *node, ShownList *list) {
    for (int o = node->first_object; o >= 0; o = tree->next[o]) {
        const Object *object = &e->graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            if (!export_shows(e, o, p)) continue;
            int key = e->graph->polygons[p].material * EXPORT_LOOKS + look_of(e, o, p), order = list->count;
            *ARENA_PUSH(&list->arena, list->shown, list->count, list->capacity) = (Shown){p, key, order};
        }
    }
    qsort(list->shown, (size_t)list->count, sizeof *list->shown, by_key);
}

// ---- vertices

// Where a leaf stood when its light was found is undone: its node puts it there again.
static Vec3 to_node(const Export *e, const ExportNode *node, Vec3 p) {
    if (node->leaf < 0) return vec3_sub(p, e->origin);
    const Leaf *leaf = &e->graph->building->leaves[node->leaf];
    double open = e->door_open ? (double)e->door_open[leaf->opening] : 1, angle = -open * leaf->turn;
    p = vec3(p.x - leaf->pivot.x - open * leaf->slide.x, p.y - leaf->pivot.y - open * leaf->slide.y,
             p.z - open * leaf->rise);
    return vec3(cos(angle) * p.x - sin(angle) * p.y, sin(angle) * p.x + cos(angle) * p.y, p.z - e->origin.z);
}

static void add_position(Export *e, Vec3 p) {
    float *at = *ARENA_PUSH(&e->arena, e->position, e->position_count, e->position_capacity);
    at[0] = (float)p.x;
    at[1] = (float)p.y;
    at[2] = (float)p.z;
}

// The colour ends at the exposure, as glTF demands of COLOR_0; the radiant exitance does not. `closed`: the place, of leaves as when
// closed. The light on a picture is that on its mean, over the mean.
static void add_colour(Export *e, const double b[3], int polygon, Vec3 closed) {
    const Building *building = e->graph->building;
    const Polygon *p = &e->graph->polygons[polygon];
    double factor[3] = {1, 1, 1};
    float *place = *ARENA_PUSH(&e->arena, e->place, e->place_count, e->place_capacity);
    place[0] = place[1] = 0;
    if (export_pictured(building, p)) {
        export_picture_place(building, p, e->graph->vertices[p->first_vertex], closed, place);
        if (!vis_is_glass(e->graph, polygon)) export_picture_factor(building, p->material, factor);
    }
    float *radiant = *ARENA_PUSH(&e->arena, e->radiant, e->radiant_count, e->radiant_capacity);
    uint16_t *at = *ARENA_PUSH(&e->arena, e->colour, e->colour_count, e->colour_capacity);
    for (int c = 0; c < 3; c++) at[c] = (uint16_t)lrint(FULL * fmin(b[c] * factor[c] * e->exposure, 1));
    for (int c = 0; c < 3; c++) radiant[c] = (float)b[c];
    at[3] = FULL;
}

// The triangles of corners that became these vertices.
static void export_triangles(Export *e, const Vec3 *v, const int *vertex, int count) {
    Arena scratch = {0};
    int *triangle = ARENA_ARRAY(&scratch, int, 3 * count);
    polygon_triangulate(v, count, triangle);
    for (int k = 0; k < 3 * (count - 2); k++)
        *ARENA_PUSH(&e->arena, e->index, e->index_count, e->index_capacity) = (uint32_t)vertex[triangle[k]];
    arena_free(&scratch);
}

// The point that positions of a node are relative to, the leaf as when closed.
static Vec3 node_origin(const Export *e, const ExportNode *node) {
    if (node->leaf < 0) return e->origin;
    const Leaf *leaf = &e->graph->building->leaves[node->leaf];
    return vec3(leaf->pivot.x, leaf->pivot.y, e->origin.z);
}

static void export_element(Export *e, const ExportNode *node, int polygon, const Element *element,
                           int first_vertex) {
    Arena scratch = {0};
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, element->corner_count);
    int *vertex = ARENA_ARRAY(&scratch, int, element->corner_count);
    for (int i = 0; i < element->corner_count; i++) {
        int corner = element->first_corner + i, at = e->nodes.of_corner[corner];
        v[i] = e->mesh->vertices[e->mesh->corners[corner]];
        if (e->stamp[at] != e->now) {
            e->stamp[at] = e->now;
            e->vertex[at] = e->position_count - first_vertex;
            Vec3 p = to_node(e, node, v[i]);
            add_position(e, p);
            add_colour(e, e->light.corner[corner], polygon, vec3_add(p, node_origin(e, node)));
        }
        vertex[i] = e->vertex[at];
    }
    export_triangles(e, v, vertex, element->corner_count);
    arena_free(&scratch);
}

static void export_face(Export *e, const ExportNode *node, int polygon, int first_vertex) {
    const Face *face = &e->mesh->faces[e->mesh->face_of[polygon]];
    // A vertex may lie elsewhere in the picture of the next polygon.
    if (export_pictured(e->graph->building, &e->graph->polygons[polygon])) e->now++;
    for (int i = 0; i < face->element_count; i++)
        export_element(e, node, polygon, &e->mesh->elements[face->first_element + i], first_vertex);
}

// Glass has no light of its own. Of leaves it is as when closed, which is how nodes of leaves have it.
static void add_pane(Export *e, const ExportNode *node, int polygon, int first_vertex) {
    const Polygon *p = &e->graph->polygons[polygon];
    const Vec3 *v = e->graph->vertices + p->first_vertex;
    Arena scratch = {0};
    int *vertex = ARENA_ARRAY(&scratch, int, p->vertex_count);
    const double bright[3] = {1 / e->exposure, 1 / e->exposure, 1 / e->exposure};
    Vec3 from = node_origin(e, node);
    for (int i = 0; i < p->vertex_count; i++) {
        vertex[i] = e->position_count - first_vertex;
        add_position(e, vec3_sub(v[i], from));
        add_colour(e, bright, polygon, v[i]);
        memset(e->radiant[e->radiant_count - 1], 0, sizeof *e->radiant);
    }
    export_triangles(e, v, vertex, p->vertex_count);
    arena_free(&scratch);
}

// ---- accessors

enum { UNSIGNED_SHORT = 5123, UNSIGNED_INT = 5125, FLOAT = 5126 };

static int add_accessor(Export *e, json_t *accessor) {
    json_array_append_new(e->accessors, accessor);
    return (int)json_array_size(e->accessors) - 1;
}

static int add_positions(Export *e, int first) {
    float low[3], high[3];
    memcpy(low, e->position[first], sizeof low);
    memcpy(high, low, sizeof high);
    for (int i = first; i < e->position_count; i++) {
        for (int c = 0; c < 3; c++) {
            low[c] = fminf(low[c], e->position[i][c]);
            high[c] = fmaxf(high[c], e->position[i][c]);
        }
    }
    return add_accessor(e,
                        json_pack("{s:i s:I s:i s:i s:s s:[f f f] s:[f f f]}", "bufferView", EXPORT_POSITIONS,
                                  "byteOffset", (json_int_t)first * (json_int_t)sizeof *e->position,
                                  "componentType", FLOAT, "count", e->position_count - first, "type", "VEC3",
                                  "min", (double)low[0], (double)low[1], (double)low[2], "max",
                                  (double)high[0], (double)high[1], (double)high[2]));
}

// Polygons of one key.
static json_t *add_primitive(Export *e, const ExportNode *node, const Shown *shown, int count) {
    int vertex = e->position_count, index = e->index_count;
    e->now++;
    for (int i = 0; i < count; i++) {
        if (e->mesh->face_of[shown[i].polygon] >= 0)
            export_face(e, node, shown[i].polygon, vertex);
        else
            add_pane(e, node, shown[i].polygon, vertex);
    }
    int positions = add_positions(e, vertex);
    int colours = add_accessor(e, json_pack("{s:i s:I s:i s:b s:i s:s}", "bufferView", EXPORT_COLOURS,
                                            "byteOffset", (json_int_t)vertex * (json_int_t)sizeof *e->colour,
                                            "componentType", UNSIGNED_SHORT, "normalized", 1, "count",
                                            e->colour_count - vertex, "type", "VEC4"));
    int radiant =
        add_accessor(e, json_pack("{s:i s:I s:i s:i s:s}", "bufferView", EXPORT_RADIANT, "byteOffset",
                                  (json_int_t)vertex * (json_int_t)sizeof *e->radiant, "componentType", FLOAT,
                                  "count", e->radiant_count - vertex, "type", "VEC3"));
    int indices =
        add_accessor(e, json_pack("{s:i s:I s:i s:i s:s}", "bufferView", EXPORT_INDICES, "byteOffset",
                                  (json_int_t)index * (json_int_t)sizeof *e->index, "componentType",
                                  UNSIGNED_INT, "count", e->index_count - index, "type", "SCALAR"));
    int places =
        shown->key % EXPORT_LOOKS & EXPORT_PICTURED
            ? add_accessor(e, json_pack("{s:i s:I s:i s:i s:s}", "bufferView", EXPORT_PLACES, "byteOffset",
                                        (json_int_t)vertex * (json_int_t)sizeof *e->place, "componentType",
                                        FLOAT, "count", e->place_count - vertex, "type", "VEC2"))
            : -1;
    int material = export_material(e, shown->key / EXPORT_LOOKS, (ExportLook)(shown->key % EXPORT_LOOKS));
    json_t *attributes =
        json_pack("{s:i s:i s:i}", "POSITION", positions, "COLOR_0", colours, "_RADIANT_EXITANCE", radiant);
    if (places >= 0) json_object_set_new(attributes, "TEXCOORD_0", json_integer(places));
    return json_pack("{s:o s:i s:i}", "attributes", attributes, "indices", indices, "material", material);
}

// The mesh of a node's objects, as index in the document.
static int export_mesh(Export *e, const ExportTree *tree, const ExportNode *node) {
    ShownList list = {0};
    list_shown(e, tree, node, &list);
    json_t *primitives = json_array();
    for (int i = 0, end; i < list.count; i = end) {
        for (end = i; end < list.count && list.shown[end].key == list.shown[i].key;) end++;
        json_array_append_new(primitives, add_primitive(e, node, list.shown + i, end - i));
    }
    arena_free(&list.arena);
    json_array_append_new(e->meshes,
                          json_pack("{s:o s:o}", "name", export_text(node->name), "primitives", primitives));
    return (int)json_array_size(e->meshes) - 1;
}

// ---- nodes: z up, as buildings are; the root turns it to y up

static const double ASPECT = 16.0 / 9;  // of cameras: Viewpoint.fov is across
static const double NEAREST = 0.05;     // metres from a camera to the nearest drawn point
static const double TURN = 0.70710678118654752;

static json_t *vector(double x, double y, double z) { return json_pack("[f f f]", x, y, z); }

// At share t of its way: turned about its pivot, slid, raised.
static void pose_leaf(const Export *e, const Leaf *leaf, json_t *node) {
    double open = e->door_open ? (double)e->door_open[leaf->opening] : 1, half = open * leaf->turn / 2;
    json_object_set_new(node, "translation",
                        vector(leaf->pivot.x + open * leaf->slide.x - e->origin.x,
                               leaf->pivot.y + open * leaf->slide.y - e->origin.y, open * leaf->rise));
    if (half != 0)
        json_object_set_new(node, "rotation", json_pack("[f f f f]", 0.0, 0.0, sin(half), cos(half)));
    json_object_set_new(node, "extras",
                        json_pack("{s:f s:f s:[f f] s:f}", "open", open, "turn", leaf->turn, "slide",
                                  leaf->slide.x, leaf->slide.y, "rise", leaf->rise));
}

// The turn that takes a camera's axes (looks along -z, y up) to yaw and pitch: about x by a right angle and the pitch, then
// about z.
static json_t *camera_turn(double yaw, double pitch) {
    double a = (M_PI / 2 + pitch) / 2, b = (yaw - M_PI / 2) / 2;
    return json_pack("[f f f f]", sin(a) * cos(b), sin(a) * sin(b), cos(a) * sin(b), cos(a) * cos(b));
}

static void append_child(json_t *parent, int child) {
    json_t *children = json_object_get(parent, "children");
    if (!children) json_object_set_new(parent, "children", children = json_array());
    json_array_append_new(children, json_integer(child));
}

static void add_camera(const Export *e, const Viewpoint *v, json_t *nodes, json_t *cameras) {
    double far = vec3_length(vec3_sub(e->graph->box.max, e->graph->box.min));
    double up = 2 * atan(tan(v->fov / 2) / ASPECT);
    json_array_append_new(cameras, json_pack("{s:o s:s s:{s:f s:f s:f s:f}}", "name", export_text(v->name),
                                             "type", "perspective", "perspective", "aspectRatio", ASPECT,
                                             "yfov", up, "znear", NEAREST, "zfar", far));
    Vec3 at = vec3_sub(v->eye, e->origin);
    append_child(json_array_get(nodes, 0), (int)json_array_size(nodes));
    json_array_append_new(nodes,
                          json_pack("{s:o s:i s:o s:o}", "name", export_text(v->name), "camera",
                                    (int)json_array_size(cameras) - 1, "translation",
                                    vector(at.x, at.y, at.z), "rotation", camera_turn(v->yaw, v->pitch)));
}

// Nodes and cameras; returns the node of the scene.
static int export_nodes(Export *e, const ExportTree *tree, json_t *nodes, json_t *cameras) {
    const Building *b = e->graph->building;
    for (int i = 0; i < tree->count; i++) {
        const ExportNode *n = &tree->nodes[i];
        json_t *node = json_pack("{s:o}", "name", export_text(n->name));
        if (n->first_object >= 0) json_object_set_new(node, "mesh", json_integer(export_mesh(e, tree, n)));
        if (n->leaf >= 0) pose_leaf(e, &b->leaves[n->leaf], node);
        if (n->parent >= 0) append_child(json_array_get(nodes, (size_t)n->parent), i);
        json_array_append_new(nodes, node);
    }
    // (x, y, z) with z up becomes (x, z, -y).
    json_t *root = json_array_get(nodes, 0);
    json_object_set_new(root, "rotation", json_pack("[f f f f]", -TURN, 0.0, 0.0, TURN));
    json_object_set_new(root, "translation", vector(e->origin.x, e->origin.z, -e->origin.y));
    for (int i = 0; i < b->viewpoint_count; i++) add_camera(e, &b->viewpoints[i], nodes, cameras);
    return 0;
}

// ---- the exposure, and the start

// The factor that brings the logarithmic mean of the radiosity to MIDDLE (Reinhard, Stark, Shirley & Ferwerda 2002). The mean
// is over the elements that do not emit, each weighted by the light that leaves it.
static double find_exposure(const Mesh *mesh, const RadSolution *solution) {
    double power = 0, logs = 0;
    for (int i = 0; i < mesh->element_count; i++) {
        const Element *element = &mesh->elements[i];
        const double *b = solution->radiosity[i];
        double y = 0.2126 * b[0] + 0.7152 * b[1] + 0.0722 * b[2];
        if (material_emits(mesh_material(mesh, element->face)) || !(y > 0)) continue;
        logs += element->area * y * log(y);
        power += element->area * y;
    }
    return power > 0 ? MIDDLE / exp(logs / power) : 1;
}

static void start_export(Export *e, const Mesh *mesh, const RadSolution *solution, const float *door_open) {
    *e = (Export){.mesh = mesh, .graph = mesh->graph, .door_open = door_open};
    const Box box = mesh->graph->box;
    e->nodes = nodes_of(mesh, &e->arena);
    e->light = reconstruct_light(mesh, solution, &e->arena);
    e->exposure = find_exposure(mesh, solution);
    // Positions are floats: whole metres from the middle, lest those of georeferenced buildings lose their digits.
    e->origin = vec3(round((box.min.x + box.max.x) / 2), round((box.min.y + box.max.y) / 2), 0);
    e->materials = json_array();
    e->pictures = export_pictures(mesh->graph->building, EXPORT_VIEWS);
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
           : view == EXPORT_RADIANT ? (size_t)e->radiant_count * sizeof *e->radiant
           : view == EXPORT_PLACES  ? (size_t)e->place_count * sizeof *e->place
                                    : (size_t)e->index_count * sizeof *e->index;
}

// Those of places and of images are there only where something shows a picture.
static json_t *views_of(const Export *e, size_t *total) {
    enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER = 34963 };
    static const int STRIDES[EXPORT_VIEWS] = {[EXPORT_POSITIONS] = sizeof *e->position,
                                              [EXPORT_COLOURS] = sizeof *e->colour,
                                              [EXPORT_RADIANT] = sizeof *e->radiant,
                                              [EXPORT_PLACES] = sizeof *e->place};
    const ExportPictures *pictures = &e->pictures;
    json_t *views = json_array();
    *total = 0;
    for (int v = 0; v < (pictures->end_count > 0 ? EXPORT_VIEWS : EXPORT_PLACES); v++) {
        json_t *view = json_pack("{s:i s:I s:I s:i}", "buffer", 0, "byteOffset", (json_int_t)*total,
                                 "byteLength", (json_int_t)view_size(e, v), "target",
                                 v == EXPORT_INDICES ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER);
        if (STRIDES[v] > 0) json_object_set_new(view, "byteStride", json_integer(STRIDES[v]));
        json_array_append_new(views, view);
        *total += view_size(e, v);
    }
    for (int i = 0; i < pictures->end_count; i++) {
        size_t start = i > 0 ? (pictures->end[i - 1] + 3) / 4 * 4 : 0;
        json_array_append_new(views, json_pack("{s:i s:I s:I}", "buffer", 0, "byteOffset",
                                               (json_int_t)(*total + start), "byteLength",
                                               (json_int_t)(pictures->end[i] - start)));
    }
    *total += pictures->size;
    return views;
}

static json_t *extras_of(const Export *e) {
    return json_pack(
        "{s:f s:f s:s}", "exposure_m2_per_W", e->exposure, "W_per_m2_per_unit", 1 / e->exposure, "light",
        "COLOR_0, linear, is radiant exitance times the exposure, where there is a picture over its mean, "
        "cut off at 1; _RADIANT_EXITANCE, "
        "W/m2, is all of it, of lamps and of surfaces close to them, too");
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
    if (e->pictures.end_count > 0) {
        json_object_set(json, "images", e->pictures.images);
        json_object_set(json, "textures", e->pictures.textures);
    }
    if (json_array_size(cameras) > 0)
        json_object_set_new(json, "cameras", cameras);
    else
        json_decref(cameras);
    return json;
}

// ---- the container

static size_t whole(size_t size) { return (size + 3) / 4 * 4; }

static unsigned char *put_bytes(unsigned char *at, const void *data, size_t size) {
    if (size > 0) memcpy(at, data, size);
    return at + size;
}

// A chunk's head: its length and its kind, four letters.
static unsigned char *put_head(unsigned char *at, size_t length, const char kind[4]) {
    uint32_t size = (uint32_t)length;
    return put_bytes(put_bytes(at, &size, 4), kind, 4);
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
    at = put_bytes(put_bytes(at, "glTF", 4), head, sizeof head);
    at = put_bytes(put_head(at, whole(length), "JSON"), text, length);
    memset(at, ' ', whole(length) - length);
    at = put_head(at + whole(length) - length, whole(binary), "BIN\0");
    at = put_bytes(at, e->position, view_size(e, EXPORT_POSITIONS));
    at = put_bytes(at, e->colour, view_size(e, EXPORT_COLOURS));
    at = put_bytes(at, e->radiant, view_size(e, EXPORT_RADIANT));
    at = put_bytes(at, e->index, view_size(e, EXPORT_INDICES));
    if (e->pictures.end_count > 0) {
        at = put_bytes(at, e->place, view_size(e, EXPORT_PLACES));
        at = put_bytes(at, e->pictures.bytes, e->pictures.size);
    }
    memset(at, 0, whole(binary) - binary);
    bool good = file_write(path, file, total, error);
    memory_free(file);
    return good;
}

bool export_glb(const char *path, const Mesh *mesh, const RadSolution *solution, const float *door_open,
                Error *error) {
    Export e;
    size_t binary;
    start_export(&e, mesh, solution, door_open);
    json_t *json = document_of(&e, &binary);
    char *text = json_dumps(json, JSON_COMPACT);
    json_decref(json);
    bool good = text ? write_container(path, &e, text, binary, error)
                     : error_set(error, "%s: no memory for its description", path);
    json_free_t give_back;
    json_get_alloc_funcs(NULL, &give_back);
    give_back(text);
    export_pictures_free(&e.pictures);
    arena_free(&e.arena);
    return good;
}
