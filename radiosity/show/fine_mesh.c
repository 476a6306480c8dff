// fine_mesh.c - two meshes in one: of the one that light was found on all but the stand-ins, and what these stand for, cut into elements
// by itself. Both are put together face by face, in the order of polygons, so that of faces in one place the same is seen as
// ever.
#include "radiosity/show/fine_mesh.h"

#include "engine/core/error.h"
#include "radiosity/mesh/mesh_places.h"
#include "radiosity/show/fine_sources.h"

typedef struct Join {
    FineMesh *fine;
    const Mesh *from;  // the mesh at hand
    int *vertex;       // [from->vertex_count] in the joined mesh
    int *element_to;   // [from->element_count]
    bool is_fine;
    Arena *arena;
} Join;

static int outline_of(const Mesh *mesh, const Face *face, const int *vertex, int *out) {
    for (int i = 0; i < face->vertex_count; i++) out[i] = vertex[mesh->outline[face->first_vertex + i]];
    return face->vertex_count;
}

static void take_elements(Join *j, const Face *from, Face *to) {
    FineMesh *fine = j->fine;
    Mesh *mesh = &fine->mesh;
    to->first_element = mesh->element_count;
    for (int e = from->first_element; e < from->first_element + from->element_count; e++) {
        Element element = j->from->elements[e];
        int first = mesh->corner_count, patches = mesh->patch_count - from->first_patch;
        for (int c = element.first_corner; c < element.first_corner + element.corner_count; c++) {
            fine->corner[mesh->corner_count] = j->is_fine ? -1 : c;
            mesh->corners[mesh->corner_count++] = j->vertex[j->from->corners[c]];
        }
        element.face = mesh->face_count;
        element.patch += patches;
        element.first_corner = first;
        fine->element[mesh->element_count] = j->is_fine ? -1 - fine->source_count++ : e;
        j->element_to[e] = mesh->element_count;
        mesh->elements[mesh->element_count++] = element;
    }
}

static void take_patches(Join *j, const Face *from, Face *to) {
    Mesh *mesh = &j->fine->mesh;
    to->first_patch = mesh->patch_count;
    for (int p = from->first_patch; p < from->first_patch + from->patch_count; p++) {
        Patch patch = j->from->patches[p];
        patch.face = mesh->face_count;
        patch.first_element = j->element_to[patch.first_element];
        j->fine->patch[mesh->patch_count] = j->is_fine ? -1 - patch.first_element : p;
        mesh->patches[mesh->patch_count++] = patch;
    }
}

// A run of several elements of a square, and its code.
static int take_shared(Join *j, int code) {
    Mesh *mesh = &j->fine->mesh;
    const int *several = j->from->shared + ~(code + 1);
    int at = mesh->shared_count;
    for (int i = 0; i <= several[0]; i++)
        mesh->shared[mesh->shared_count++] = i == 0 ? several[0] : j->element_to[several[i]];
    return ~at - 1;
}

// Squares of one leaf have one run.
static void take_squares(Join *j, const Face *from, Face *to) {
    Mesh *mesh = &j->fine->mesh;
    int last = -1, last_to = -1;
    to->first_square = mesh->square_count;
    for (int s = from->first_square; s < from->first_square + from->nx * from->ny; s++) {
        int code = j->from->squares[s];
        if (code < -1) {
            if (code != last) last_to = take_shared(j, code);
            last = code;
            code = last_to;
        } else if (code >= 0) {
            code = j->element_to[code];
        }
        mesh->squares[mesh->square_count++] = code;
    }
}

static void take_face(Join *j, int index) {
    Mesh *mesh = &j->fine->mesh;
    const Face *from = &j->from->faces[index];
    Face *to = &mesh->faces[mesh->face_count];
    *to = *from;
    to->first_vertex = mesh->outline_count;
    mesh->outline_count += outline_of(j->from, from, j->vertex, mesh->outline + mesh->outline_count);
    take_elements(j, from, to);
    take_patches(j, from, to);
    take_squares(j, from, to);
    mesh->face_of[from->polygon] = mesh->face_count++;
}

// How long runs of shared elements may come to be: where squares of several leaves take turns they are there several times.
static int most_shared(const Mesh *mesh) {
    int count = 0;
    for (int s = 0; s < mesh->square_count; s++)
        if (mesh->squares[s] < -1) count += 1 + mesh->shared[~(mesh->squares[s] + 1)];
    return count;
}

static void make_room(Mesh *out, const Mesh *a, const Mesh *b, FineMesh *fine, Arena *arena) {
    out->faces = ARENA_ARRAY(arena, Face, a->face_count + b->face_count);
    out->elements = ARENA_ARRAY(arena, Element, a->element_count + b->element_count);
    out->patches = ARENA_ARRAY(arena, Patch, a->patch_count + b->patch_count);
    out->outline = ARENA_ARRAY(arena, int, a->outline_count + b->outline_count);
    out->corners = ARENA_ARRAY(arena, int, a->corner_count + b->corner_count);
    out->squares = ARENA_ARRAY(arena, int, a->square_count + b->square_count);
    out->shared = ARENA_ARRAY(arena, int, most_shared(a) + most_shared(b));
    out->face_of = ARENA_ARRAY(arena, int, a->graph->polygon_count + 1);
    for (int p = 0; p < a->graph->polygon_count; p++) out->face_of[p] = -1;
    fine->element = ARENA_ARRAY(arena, int, a->element_count + b->element_count);
    fine->patch = ARENA_ARRAY(arena, int, a->patch_count + b->patch_count);
    fine->corner = ARENA_ARRAY(arena, int, a->corner_count + b->corner_count);
}

// Where both meshes have a vertex it is one. Those of the first stay as they are.
static void join_vertices(Mesh *out, Join join[2], Arena *arena, Arena *scratch) {
    Places places;
    places_start(&places, arena);
    for (int k = 0; k < 2; k++) {
        const Mesh *from = join[k].from;
        join[k].vertex = ARENA_ARRAY(scratch, int, from->vertex_count);
        join[k].element_to = ARENA_ARRAY(scratch, int, from->element_count);
        for (int i = 0; i < from->vertex_count; i++)
            join[k].vertex[i] = places_add(&places, from->vertices[i]);
    }
    out->vertices = places.points;
    out->vertex_count = places.count;
}

// Those of both of an object, by polygons; of the stand-ins of the first none.
static void take_object(Join join[2], int object, int at[2]) {
    for (;;) {
        int next = -1;
        for (int k = 0; k < 2; k++) {
            const Mesh *from = join[k].from;
            while (at[k] < from->face_count && from->faces[at[k]].object == object &&
                   from->faces[at[k]].polygon < 0)
                at[k]++;
            if (at[k] == from->face_count || from->faces[at[k]].object != object) continue;
            if (next < 0 || from->faces[at[k]].polygon < join[next].from->faces[at[next]].polygon) next = k;
        }
        if (next < 0) return;
        take_face(&join[next], at[next]++);
    }
}

static void join_meshes(FineMesh *fine, const Mesh *of_fine, Arena *arena) {
    Arena scratch = {0};
    Mesh *out = &fine->mesh;
    Join join[2] = {{.fine = fine, .from = fine->light, .arena = arena},
                    {.fine = fine, .from = of_fine, .arena = arena, .is_fine = true}};
    int at[2] = {0, 0};
    *out = (Mesh){.graph = fine->light->graph, .options = fine->light->options};
    make_room(out, fine->light, of_fine, fine, arena);
    join_vertices(out, join, arena, &scratch);
    for (int o = 0; o < out->graph->object_count; o++) take_object(join, o, at);
    CORE_ASSERT(at[0] == fine->light->face_count && at[1] == of_fine->face_count);
    arena_free(&scratch);
}

FineMesh *fine_mesh_new(const Mesh *light, Arena *arena) {
    FineMesh *fine = ARENA_ARRAY(arena, FineMesh, 1);
    Arena scratch = {0};
    Error error;
    Mesh of_fine;
    // Nothing covers what is narrower than an element.
    MeshOptions options = light->options;
    options.splits = NULL;
    options.per_patch = 1;
    options.close = 0;
    options.replaced = true;
    *fine = (FineMesh){.light = light, .mesh = *light, .same = true};
    if (options.proxies && mesh_build(light->graph, NULL, NULL, &options, &scratch, &of_fine, &error)) {
        fine->same = false;
        join_meshes(fine, &of_fine, arena);
        fine->nodes = nodes_of(light, arena);
        fine->sources = fine_sources(fine, arena);
    }
    arena_free(&scratch);
    return fine;
}
