// lamps.c - polygons that emit are sorted by what makes them one lamp; the first lamp of a material keeps it, all others get copies.
#include "radiosity/mesh/lamps.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/box_tree.h"

// Faces of a soup's object that are nearer than this belong to one lamp, metres: the sides of one tube, not two tubes.
static const double TOGETHER = 0.05;
// So far before a face lies the room in which it shines, metres.
static const double BEFORE = 0.01;

// A polygon that emits, and what makes it part of a lamp.
typedef struct Emitter {
    int polygon, object;
    int room;    // region before it, -1
    bool panel;  // part of a wall, floor or ceiling
    int key[3];  // the same for all of a lamp
} Emitter;

static bool emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

static const Vec3 *corners_of(const CellGraph *graph, int polygon) {
    return graph->vertices + graph->polygons[polygon].first_vertex;
}

static Vec3 middle_of(const CellGraph *graph, int polygon) {
    Vec3 sum = {0, 0, 0};
    int count = graph->polygons[polygon].vertex_count;
    for (int i = 0; i < count; i++) sum = vec3_add(sum, corners_of(graph, polygon)[i]);
    return vec3_scale(sum, 1.0 / count);
}

static int room_before(const CellGraph *graph, int polygon) {
    Plane plane = plane_of_polygon(corners_of(graph, polygon), graph->polygons[polygon].vertex_count);
    int cell = vis_locate(graph, vec3_add(middle_of(graph, polygon), vec3_scale(plane.n, BEFORE)), -1);
    return cell < 0 || graph->building->form != FORM_REGIONS ? -1 : graph->cells[cell].region;
}

static Emitter *find_emitters(const CellGraph *graph, int *count, Arena *arena) {
    const Building *b = graph->building;
    Emitter *out = ARENA_ARRAY(arena, Emitter, graph->polygon_count + 1);
    *count = 0;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            if (emits(&b->materials[graph->polygons[p].material]))
                out[(*count)++] = (Emitter){.polygon = p,
                                            .object = o,
                                            .room = room_before(graph, p),
                                            .panel = object->kind == OBJECT_SURFACE};
    }
    return out;
}

static int root_of(int *parent, int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

// Numbers the groups of emitters of a soup whose boxes come near each other: [count] the first of each group.
static int *groups_of(const CellGraph *graph, const Emitter *emitters, int count, Arena *arena) {
    int *parent = ARENA_ARRAY(arena, int, count + 1);
    Box *boxes = ARENA_ARRAY(arena, Box, count + 1);
    BoxHits hits = {0};
    for (int i = 0; i < count; i++) {
        parent[i] = i;
        boxes[i] = box_empty();
        for (int k = 0; k < graph->polygons[emitters[i].polygon].vertex_count; k++)
            boxes[i] = box_add(boxes[i], corners_of(graph, emitters[i].polygon)[k]);
    }
    BoxTree tree = box_tree_build(boxes, count, arena);
    for (int i = 0; i < count; i++) {
        box_tree_find(&tree, box_grow(boxes[i], TOGETHER), arena, &hits);
        for (int k = 0; k < hits.count; k++) {
            int a = root_of(parent, i), c = root_of(parent, hits.items[k]);
            if (emitters[a].object != emitters[c].object) continue;
            parent[a > c ? a : c] = a > c ? c : a;
        }
    }
    for (int i = 0; i < count; i++) parent[i] = root_of(parent, i);
    return parent;
}

static void find_keys(const CellGraph *graph, Emitter *emitters, int count, Arena *arena) {
    bool soup = graph->building->form == FORM_SOUP;
    const int *group = soup ? groups_of(graph, emitters, count, arena) : NULL;
    for (int i = 0; i < count; i++) {
        Emitter *e = &emitters[i];
        if (e->panel && !soup) {
            e->key[0] = e->room;
            e->key[1] = graph->polygons[e->polygon].material;
            e->key[2] = 1;
        } else {
            e->key[0] = e->object;
            e->key[1] = group ? group[i] : 0;
        }
    }
}

static int by_key(const void *a, const void *b) {
    const Emitter *p = a, *q = b;
    for (int i = 2; i >= 0; i--)
        if (p->key[i] != q->key[i]) return p->key[i] - q->key[i];
    return p->polygon - q->polygon;
}

// The first polygon of an emitter's lamp, then its own.
typedef struct Placed {
    int first, emitter;
} Placed;

static int by_first(const void *a, const void *b) {
    const Placed *p = a, *q = b;
    return p->first != q->first ? p->first - q->first : p->emitter - q->emitter;
}

static void name_lamp(const Building *b, const CellGraph *graph, const Emitter *e, Lamp *lamp, Arena *arena) {
    const char *object = graph->objects[e->object].name,
               *material = b->materials[graph->polygons[e->polygon].material].name;
    lamp->name = !e->panel && object && *object ? object : material && *material ? material : "lamp";
    lamp->room = e->room < 0 ? "" : region_title(b, &b->regions[e->room], arena);
}

// Materials of the building as they were read, while they are shared out.
typedef struct Sharing {
    Building *b;
    Arena *arena;
    // For each material that was read its copy for the lamp at hand, and that lamp.
    int *copy, *of;
    int *of_material;
} Sharing;

// The first lamp of a material keeps it.
static int own_material(Sharing *s, int lamp, int material) {
    if (s->of_material[material] < 0 && s->of[material] < 0) {
        s->copy[material] = material;
        s->of[material] = lamp;
    }
    if (s->of[material] != lamp) {
        Building *b = s->b;
        Material copy = b->materials[material];
        copy.full = (Rgb){0, 0, 0};
        s->copy[material] = b->material_count;
        s->of[material] = lamp;
        *ARENA_PUSH(s->arena, b->materials, b->material_count, b->material_capacity) = copy;
    }
    int own = s->copy[material];
    s->of_material[own] = lamp;
    s->b->materials[own].full = s->b->materials[own].emission;
    return own;
}

static void measure_face(const CellGraph *graph, const Material *m, int polygon, Lamp *lamp, double *all) {
    double area = polygon_area(corners_of(graph, polygon), graph->polygons[polygon].vertex_count), e[3];
    rgb_doubles(m->emission, e);
    for (int c = 0; c < 3; c++) lamp->flux[c] += area * e[c];
    lamp->place = vec3_add(lamp->place, vec3_scale(middle_of(graph, polygon), area));
    *all += area;
}

static bool same_lamp(const Emitter *a, const Emitter *b) {
    return memcmp(a->key, b->key, sizeof a->key) == 0;
}

void lamps_find(CellGraph *graph, Building *b, Arena *arena, Lamps *out) {
    Arena scratch = {0};
    int count, read = b->material_count;
    Emitter *emitters = find_emitters(graph, &count, &scratch);
    find_keys(graph, emitters, count, &scratch);
    qsort(emitters, (size_t)count, sizeof *emitters, by_key);
    *out = (Lamps){.graph = graph,
                   .of_material = ARENA_ARRAY(arena, int, read + count + 1),
                   .of_polygon = ARENA_ARRAY(arena, int, graph->polygon_count + 1)};
    for (int m = 0; m < read + count; m++) out->of_material[m] = -1;
    for (int p = 0; p < graph->polygon_count; p++) out->of_polygon[p] = -1;
    // Where each lamp begins among the emitters.
    Placed *placed = ARENA_ARRAY(&scratch, Placed, count + 1);
    for (int i = 0; i < count; i++)
        if (i == 0 || !same_lamp(&emitters[i], &emitters[i - 1]))
            placed[out->count++] = (Placed){emitters[i].polygon, i};
    qsort(placed, (size_t)out->count, sizeof *placed, by_first);
    out->lamps = ARENA_ARRAY(arena, Lamp, out->count + 1);
    Sharing sharing = {b, arena, ARENA_ARRAY(&scratch, int, read + 1), ARENA_ARRAY(&scratch, int, read + 1),
                       out->of_material};
    for (int m = 0; m < read; m++) sharing.of[m] = -1;
    for (int l = 0; l < out->count; l++) {
        const Emitter *first = &emitters[placed[l].emitter];
        Lamp *lamp = &out->lamps[l];
        double area = 0;
        name_lamp(b, graph, first, lamp, arena);
        lamp->object = first->object;
        lamp->region = first->room;
        for (const Emitter *e = first; e < emitters + count && same_lamp(e, first); e++) {
            Polygon *polygon = &graph->polygons[e->polygon];
            measure_face(graph, &b->materials[polygon->material], e->polygon, lamp, &area);
            polygon->material = own_material(&sharing, l, polygon->material);
            out->of_polygon[e->polygon] = l;
        }
        lamp->place = area > 0 ? vec3_scale(lamp->place, 1 / area) : middle_of(graph, first->polygon);
    }
    arena_free(&scratch);
}

void lamps_switch(const Lamps *lamps, const Rgb *lit, Material *materials) {
    for (int m = 0; m < lamps->graph->building->material_count; m++) {
        int lamp = lamps->of_material[m];
        Rgb full = materials[m].full;
        if (lamp >= 0)
            materials[m].emission = (Rgb){full.r * lit[lamp].r, full.g * lit[lamp].g, full.b * lit[lamp].b};
    }
}

Mesh lamps_mesh(const Lamps *lamps, const Mesh *mesh, const Rgb *lit, Arena *arena) {
    Mesh out = *mesh;
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    Building *building = ARENA_ARRAY(arena, Building, 1);
    *graph = *mesh->graph;
    *building = *graph->building;
    building->materials = ARENA_ARRAY(arena, Material, building->material_count + 1);
    memcpy(building->materials, graph->building->materials,
           (size_t)building->material_count * sizeof *building->materials);
    lamps_switch(lamps, lit, building->materials);
    graph->building = building;
    out.graph = graph;
    return out;
}
