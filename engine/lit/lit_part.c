// lit_part.c - the file of a part as it is drawn, RAD.lit.
//
// Layout: header (DerivedHead), how far each door is open, the state of each lamp, faces, vertices, the light at these, indices, the spots
// of elements and how bright they are, and which lamps shine. `geometry` is the checksum of the .rad file that it was made from.
#include "engine/lit/lit_part.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/file.h"

typedef struct Header {
    DerivedHead head;
    uint64_t rest;      // checksum of the rest of the header
    uint64_t polygons;  // hash of the graph's polygons that have a face
    int32_t polygon_count, door_count, state_count, material_count;  // of the building
    int32_t face_count, vertex_count, index_count, element_count, lamp_count, unused;
    Daylight day;
    LightRange ranges[FALSE_COLOURS];
} Header;

static const DerivedKind KIND = {
    .magic = "ENFLIT", .name = ".lit", .version = 1, .header = sizeof(Header), .largest = (size_t)16 << 30};

// A face in the file.
typedef struct StoredFace {
    Plane plane;
    int32_t polygon, material, first_vertex, first_index, first_element, element_count, lamp, outdoors;
} StoredFace;

static uint64_t rest_hash(const Header *h) {
    return file_hash(&h->polygons, sizeof *h - offsetof(Header, polygons), KIND.version);
}

static const char *file_of(const char *rad, Arena *arena) { return arena_format(arena, "%s.lit", rad); }

// The places and materials of the faces' polygons: a program that numbers polygons otherwise draws nothing wrong.
static uint64_t polygons_hash(const CellGraph *graph, const LitMesh *lit) {
    uint64_t hash = KIND.version;
    for (int f = 0; f < lit->face_count; f++) {
        const Polygon *p = &graph->polygons[lit->faces[f].polygon];
        hash = file_hash(graph->vertices + p->first_vertex, (size_t)p->vertex_count * sizeof *graph->vertices,
                         hash);
        hash = file_hash(&p->material, sizeof p->material, hash);
    }
    return hash;
}

// ---- writing

typedef struct Stored {
    const Header *header;
    const LitMesh *mesh;
    const LitLight *light;
    const Rgb *states;
} Stored;

static void put_faces(DerivedSink *sink, const LitMesh *lit) {
    for (int i = 0; i < lit->face_count; i++) {
        const LitFace *f = &lit->faces[i];
        StoredFace stored = {f->plane,         f->polygon,       f->material, f->first_vertex, f->first_index,
                             f->first_element, f->element_count, f->lamp,     f->outdoors};
        derived_put(sink, &stored, sizeof stored);
    }
}

static void put_body(DerivedSink *sink, const void *context) {
    const Stored *s = context;
    const Header *h = s->header;
    const LitLight *light = s->light;
    derived_put(sink, light->doors, (size_t)h->door_count * sizeof *light->doors);
    derived_put(sink, s->states, (size_t)h->state_count * sizeof *s->states);
    put_faces(sink, s->mesh);
    derived_put(sink, s->mesh->vertex, (size_t)h->vertex_count * sizeof *s->mesh->vertex);
    derived_put(sink, light->vertex, (size_t)h->vertex_count * sizeof *light->vertex);
    derived_put(sink, s->mesh->index, (size_t)h->index_count * sizeof *s->mesh->index);
    derived_put(sink, s->mesh->spot, (size_t)h->element_count * sizeof *s->mesh->spot);
    derived_put(sink, light->luminous, (size_t)h->element_count * sizeof *light->luminous);
    derived_put(sink, light->on, (size_t)h->lamp_count * sizeof *light->on);
}

// Bytes behind the header.
static size_t body_size(const Header *h) {
    const LitMesh *mesh = NULL;
    const LitLight *light = NULL;
    return (size_t)h->door_count * sizeof *light->doors + (size_t)h->state_count * sizeof(Rgb) +
           (size_t)h->face_count * sizeof(StoredFace) +
           (size_t)h->vertex_count * (sizeof *mesh->vertex + sizeof *light->vertex) +
           (size_t)h->index_count * sizeof *mesh->index +
           (size_t)h->element_count * (sizeof *mesh->spot + sizeof *light->luminous) +
           (size_t)h->lamp_count * sizeof *light->on;
}

static Header header_of(const LoadedScene *scene, const LitMesh *lit, const LitLight *light) {
    Header h = {.polygons = polygons_hash(&scene->graph, lit),
                .polygon_count = scene->graph.polygon_count,
                .door_count = scene->building.opening_count,
                .state_count = scene->lamps.count,
                .material_count = scene->building.material_count,
                .face_count = lit->face_count,
                .vertex_count = lit_vertex_count(lit),
                .index_count = lit->faces[lit->face_count].first_index,
                .element_count = lit->element_count,
                .lamp_count = lit->lamp_count,
                .day = light->day};
    memcpy(h.ranges, light->ranges, sizeof h.ranges);
    h.rest = rest_hash(&h);
    return h;
}

// Light on a mesh, and the mesh, as they are drawn.
static LitMesh *make_drawn(const WalkLight *light, Arena *arena, Arena *of_fill, LitLight *out) {
    LitMesh *lit = lit_mesh_new(light->mesh, arena, of_fill);
    *out = lit_light_new(lit, arena);
    lit_light_fill(lit, light->solution, light->door_open, out);
    return lit;
}

bool lit_store_part(const LoadedScene *scene, const char *rad, const WalkLight *light, Error *error) {
    Arena scratch = {0};
    LitLight drawn;
    const LitMesh *lit = make_drawn(light, &scratch, &scratch, &drawn);
    Header header = header_of(scene, lit, &drawn);
    Stored stored = {&header, lit, &drawn, scene->lit};
    uint64_t of_rad;
    bool good = rad_checksum(rad, &scene->building, &of_rad, error) &&
                derived_write(file_of(rad, &scratch), &KIND, scene->building.hash, of_rad, &header, put_body,
                              &stored, error);
    arena_free(&scratch);
    return good;
}

// ---- reading

// A file that is being read.
typedef struct Reading {
    DerivedReader from;
    Header h;
    const LoadedScene *scene;
} Reading;

static bool is_damaged(const Reading *r, Error *error) {
    return error_set(error, "%s: is damaged: its light is out of range", r->from.path);
}

// Do the numbers of the header fit the building and each other?
static bool check_header(const Reading *r, uint64_t of_rad, Error *error) {
    const Header *h = &r->h;
    const LoadedScene *scene = r->scene;
    RadSolution made = {.day = h->day};
    if (h->rest != rest_hash(h) || h->face_count < 0 || h->vertex_count < 0 || h->index_count < 0 ||
        h->element_count < 0 || h->lamp_count < 0 || h->door_count < 0 || h->state_count < 0 ||
        h->index_count % 3 != 0 || h->lamp_count > h->face_count || !daylight_is_sound(&h->day))
        return error_set(error, "%s: is damaged: its header's checksum is wrong", r->from.path);
    if (h->head.geometry != of_rad || h->polygon_count != scene->graph.polygon_count ||
        h->face_count > h->polygon_count || h->door_count != scene->building.opening_count ||
        h->state_count != scene->lamps.count || h->material_count != scene->building.material_count)
        return error_set(error, "%s: is not of this light", r->from.path);
    return derived_check_size(r->from.path, &KIND, KIND.header + r->from.left, body_size(h), error) &&
           (!scene->day_given || light_check_day(r->from.path, &made, &scene->day, error));
}

// The states of the doors, and of the lamps, which must be those of the scene: light of others is not kept here.
static bool take_states(Reading *r, float *doors, Arena *scratch, Error *error) {
    const Header *h = &r->h;
    Rgb *states = ARENA_ARRAY(scratch, Rgb, h->state_count + 1);
    if (!derived_take(&r->from, doors, (size_t)h->door_count * sizeof *doors) ||
        !derived_take(&r->from, states, (size_t)h->state_count * sizeof *states))
        return is_damaged(r, error);
    for (int i = 0; i < h->door_count; i++)
        if (!(doors[i] >= 0 && doors[i] <= 1)) return is_damaged(r, error);
    return memcmp(states, r->scene->lit, (size_t)h->state_count * sizeof *states) == 0 ||
           error_set(error, "%s: was made with other lamps on", r->from.path);
}

static bool face_is_sound(const Header *h, const StoredFace *f, const LitFace *before) {
    double sum = f->plane.n.x + f->plane.n.y + f->plane.n.z + f->plane.d;
    return isfinite(sum) && f->polygon < h->polygon_count && f->material >= 0 &&
           f->material < h->material_count && f->first_vertex <= h->vertex_count &&
           f->first_index <= h->index_count && f->first_index % 3 == 0 && f->first_element >= 0 &&
           f->element_count >= 0 && f->first_element <= h->element_count - f->element_count &&
           f->polygon > (before ? before->polygon : -1) &&
           f->first_vertex >= (before ? before->first_vertex : 0) &&
           f->first_index >= (before ? before->first_index : 0);
}

static bool take_faces(Reading *r, LitMesh *lit) {
    const Header *h = &r->h;
    int polygon = 0;
    StoredFace f;
    for (int i = 0; i < h->face_count; i++) {
        if (!derived_take(&r->from, &f, sizeof f) ||
            !face_is_sound(h, &f, i > 0 ? &lit->faces[i - 1] : NULL) ||
            (i == 0 && (f.first_vertex != 0 || f.first_index != 0)))
            return false;
        lit->faces[i] =
            (LitFace){f.plane,         f.polygon,       f.material,  f.first_vertex, f.first_index,
                      f.first_element, f.element_count, f.lamp != 0, f.outdoors != 0};
        while (polygon <= f.polygon) lit->first_face[polygon++] = i;
        if (f.lamp && lit->lamp_count == h->lamp_count) return false;
        if (f.lamp) lit->lamp[lit->lamp_count++] = i;
    }
    while (polygon <= h->polygon_count) lit->first_face[polygon++] = h->face_count;
    lit->faces[h->face_count] = (LitFace){.first_vertex = h->vertex_count, .first_index = h->index_count};
    return lit->lamp_count == h->lamp_count;
}

static bool are_finite(const float *v, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(v[i])) return false;
    return true;
}

static bool is_light(const float *v, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!(v[i] >= 0 && isfinite(v[i]))) return false;
    return true;
}

static bool take_vertices(Reading *r, const LitMesh *lit, LitLight *light) {
    const Header *h = &r->h;
    size_t count = (size_t)h->vertex_count;
    if (!derived_take(&r->from, lit->vertex, count * sizeof *lit->vertex) ||
        !derived_take(&r->from, light->vertex, count * sizeof *light->vertex))
        return false;
    for (size_t i = 0; i < count; i++) {
        const LitVertex *v = &lit->vertex[i];
        if (!are_finite(v->position, 3) || !are_finite(v->normal, 3) || v->material < 0 ||
            v->material >= h->material_count || v->emits > 1 || v->outdoors > 1)
            return false;
    }
    return is_light(light->vertex[0], 3 * count);
}

static bool take_indices(Reading *r, const LitMesh *lit) {
    if (!derived_take(&r->from, lit->index, (size_t)r->h.index_count * sizeof *lit->index)) return false;
    for (int f = 0; f < lit->face_count; f++) {
        const LitFace *face = &lit->faces[f];
        for (int i = face->first_index; i < face[1].first_index; i++)
            if (lit->index[i] < (unsigned)face->first_vertex ||
                lit->index[i] >= (unsigned)face[1].first_vertex)
                return false;
    }
    return true;
}

static bool take_elements(Reading *r, const LitMesh *lit, LitLight *light) {
    const Header *h = &r->h;
    unsigned char on;
    if (!derived_take(&r->from, lit->spot, (size_t)h->element_count * sizeof *lit->spot) ||
        !derived_take(&r->from, light->luminous, (size_t)h->element_count * sizeof *light->luminous))
        return false;
    for (int i = 0; i < h->lamp_count; i++) {
        if (!derived_take(&r->from, &on, 1) || on > 1) return false;
        light->on[i] = on == 1;
    }
    return are_finite(lit->spot[0], 4 * (size_t)h->element_count) &&
           is_light(light->luminous, (size_t)h->element_count);
}

static bool take_body(Reading *r, LitMesh *lit, LitLight *light, Arena *arena) {
    const Header *h = &r->h;
    size_t faces = (size_t)h->face_count + 1, vertices = (size_t)h->vertex_count + 1,
           elements = (size_t)h->element_count + 1;
    *lit = (LitMesh){.graph = &r->scene->graph,
                     .origin = lit_origin(&r->scene->graph),
                     .faces = ARENA_ARRAY(arena, LitFace, faces),
                     .first_face = ARENA_ARRAY(arena, int, h->polygon_count + 1),
                     .face_count = h->face_count,
                     .element_count = h->element_count,
                     .vertex = ARENA_ARRAY(arena, LitVertex, vertices),
                     .index = ARENA_ARRAY(arena, unsigned, h->index_count + 1),
                     .lamp = ARENA_ARRAY(arena, int, h->lamp_count + 1),
                     .spot = arena_alloc(arena, elements, sizeof *lit->spot)};
    *light = (LitLight){.vertex = arena_alloc(arena, vertices, sizeof *light->vertex),
                        .on = ARENA_ARRAY(arena, bool, h->lamp_count + 1),
                        .luminous = ARENA_ARRAY(arena, float, elements),
                        .doors = light->doors,
                        .day = h->day};
    memcpy(light->ranges, h->ranges, sizeof light->ranges);
    for (int q = 0; q < FALSE_COLOURS; q++)
        if (!isfinite(h->ranges[q].low) || !isfinite(h->ranges[q].high)) return false;
    return take_faces(r, lit) && polygons_hash(lit->graph, lit) == h->polygons &&
           take_vertices(r, lit, light) && take_indices(r, lit) && take_elements(r, lit, light);
}

LitMesh *lit_read_part(const LoadedScene *scene, const char *path, uint64_t of_rad, Arena *arena,
                       LitLight *out, Error *error) {
    Arena scratch = {0};
    Reading r = {.scene = scene};
    LitMesh *lit = NULL;
    if (!derived_begin(path, &KIND, scene->building.hash, &r.h, &r.from, error)) return NULL;
    *out = (LitLight){0};
    out->doors = ARENA_ARRAY(arena, float, scene->building.opening_count + 1);
    if (check_header(&r, of_rad, error) && derived_sound(&r.from, &r.h, error) &&
        take_states(&r, out->doors, &scratch, error)) {
        lit = ARENA_ARRAY(arena, LitMesh, 1);
        if (!take_body(&r, lit, out, arena)) {
            is_damaged(&r, error);
            lit = NULL;
        }
    }
    derived_end(&r.from);
    arena_free(&scratch);
    return lit;
}

size_t lit_part_size(const LightOfParts *parts, int part) {
    Arena scratch = {0};
    struct stat of;
    bool there = stat(file_of(light_parts_file(parts, part, &scratch), &scratch), &of) == 0;
    arena_free(&scratch);
    return there ? (size_t)of.st_size : 0;
}

int lit_part_vertices(const LightOfParts *parts, int part) {
    Arena scratch = {0};
    DerivedReader from;
    Header h;
    Error error;
    int vertices = 0;
    const char *path = file_of(light_parts_file(parts, part, &scratch), &scratch);
    if (access(path, F_OK) == 0 &&
        derived_begin(path, &KIND, light_parts_scene(parts)->building.hash, &h, &from, &error)) {
        bool sound = h.rest == rest_hash(&h) && h.vertex_count > 0 &&
                     (size_t)h.vertex_count <= from.left / sizeof(LitVertex);
        vertices = sound ? h.vertex_count : 0;
        derived_end(&from);
    }
    arena_free(&scratch);
    return vertices;
}

LitMesh *lit_read_drawn(const LightOfParts *parts, int part, Arena *arena, LitLight *out) {
    const LoadedScene *scene = light_parts_scene(parts);
    Arena scratch = {0};
    Error error, sentence;
    const char *rad = light_parts_file(parts, part, &scratch), *path = file_of(rad, &scratch);
    uint64_t of_rad;
    bool there = access(path, F_OK) == 0;
    LitMesh *lit = there && rad_checksum(rad, &scene->building, &of_rad, &error)
                       ? lit_read_part(scene, path, of_rad, arena, out, &error)
                       : NULL;
    if (lit) out->level = light_parts_level(parts);
    if (there && !lit && scene->warn) {
        error_set(&sentence, "passed over: %.900s", error.text);
        scene->warn(sentence.text);
    }
    arena_free(&scratch);
    return lit;
}

LitMesh *lit_make_drawn(const LightOfParts *parts, int part, Arena *arena, LitLight *out, Error *error) {
    Arena of_fill = {0};
    WalkLight light;
    LitMesh *lit = NULL;
    if (light_load_part(parts, part, &of_fill, &light, error)) {
        lit = make_drawn(&light, arena, &of_fill, out);
        lit->mesh = NULL;
        lit->nodes = (Nodes){0};
        lit->node = NULL;
        out->level = light_parts_level(parts);
    }
    arena_free(&of_fill);
    return lit;
}
