// export_tree.c - who stands where: walls, floors and ceilings belong to their room, leaves and frames to their opening,
// furniture to the room that its middle is in.
#include "engine/app/export_tree.h"

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

// Of a cell's room; of a building without regions, and where there is no cell, the root.
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

ExportTree export_tree(const CellGraph *graph, const bool *wanted, Arena *arena) {
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
