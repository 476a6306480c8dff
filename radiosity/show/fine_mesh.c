// fine_mesh.c - two meshes in one: of the one that light was found on all but the stand-ins, and what these stand for, cut into elements
// by itself. Both are put together face by face, in the order of polygons, so that of faces in one place the same is seen as
// ever.
#include "radiosity/show/fine_mesh.h"

#include "engine/core/error.h"
#include "radiosity/mesh/mesh_places.h"
#include "radiosity/show/reconstruct.h"

// Where a fine element has its light from: nodes of the stand-in near it that look the same way.
enum { FINE_SOURCES = 6 };
typedef struct FineSource {
    int node[FINE_SOURCES];
    float share[FINE_SOURCES];  // sum 1, or all 0: nothing is known
} FineSource;

// ---- light that falls on a stand-in falls on what it stands for: irradiances at nodes of the one, near and looking the same
// way, are those of elements of the other (inverse distances: Shepard 1968; with normals as for cached irradiance: Ward, Rubinstein &
// Clear 1988). Elements reflect them by their own materials.

// Nodes that look away by more than this cosine tell nothing, where there are others.
static const double TURNED = 0.3;
// Nodes nearer than this are equally near, metres: the model and its stand-in may be half as far apart, and one node alone is noise.
static const double NEAR = 2 * PROXY_TOLERANCE;

// ---- sources

// The nodes of an object's elements, each once.
typedef struct ObjectNodes {
    int *first, *node;  // [object_count + 1]
} ObjectNodes;

static int object_of(const Mesh *mesh, const Nodes *nodes, int node) {
    return mesh->faces[mesh->elements[nodes->element[nodes->first[node]]].face].object;
}

static ObjectNodes sort_nodes(const Mesh *mesh, const Nodes *nodes, Arena *arena) {
    int objects = mesh->graph->object_count;
    ObjectNodes out = {ARENA_ARRAY(arena, int, objects + 2), ARENA_ARRAY(arena, int, nodes->count + 1)};
    for (int pass = 0; pass < 2; pass++) {
        for (int n = 0; n < nodes->count; n++) {
            int object = object_of(mesh, nodes, n);
            if (pass == 0)
                out.first[object + 2]++;
            else
                out.node[out.first[object + 1]++] = n;
        }
        for (int o = 0; pass == 0 && o < objects; o++) out.first[o + 2] += out.first[o + 1];
    }
    return out;
}

static const Material *face_material(const Mesh *mesh, const Nodes *nodes, int node) {
    return mesh_material(mesh, mesh->elements[nodes->element[nodes->first[node]]].face);
}

// A black surface does not tell how much light falls on it.
static bool tells(const Material *m) {
    return m->reflectance.r > 0 || m->reflectance.g > 0 || m->reflectance.b > 0;
}

static double weight_of(Vec3 off, double cosine, bool turned) {
    double facing = turned ? 1 + cosine : (cosine - TURNED) / (1 - TURNED);
    double distance = vec3_dot(off, off) + NEAR * NEAR;
    return facing > 0 ? facing * facing / (distance * distance) : 0;
}

// The heaviest first.
static void offer(FineSource *s, int node, double weight) {
    float w = (float)weight;
    if (!(w > s->share[FINE_SOURCES - 1])) return;
    int k = FINE_SOURCES - 1;
    for (; k > 0 && w > s->share[k - 1]; k--) {
        s->share[k] = s->share[k - 1];
        s->node[k] = s->node[k - 1];
    }
    s->share[k] = w;
    s->node[k] = node;
}

static FineSource source_of(const Mesh *light, const Nodes *nodes, const ObjectNodes *sorted, int object,
                            Vec3 place, Vec3 normal) {
    FineSource s = {0};
    for (int turned = 0; turned < 2 && !(s.share[0] > 0); turned++) {
        for (int i = sorted->first[object]; i < sorted->first[object + 1]; i++) {
            int node = sorted->node[i];
            if (!tells(face_material(light, nodes, node))) continue;
            Vec3 off = vec3_sub(light->vertices[nodes->vertex[node]], place);
            offer(&s, node, weight_of(off, vec3_dot(normal, nodes->normal[node]), turned));
        }
    }
    float sum = 0;
    for (int k = 0; k < FINE_SOURCES; k++) sum += s.share[k];
    for (int k = 0; k < FINE_SOURCES && sum > 0; k++) s.share[k] /= sum;
    return s;
}

// [fine->source_count], of a mesh that is joined and whose light has nodes.
static FineSource *fine_sources(const FineMesh *fine, Arena *arena) {
    const Mesh *mesh = &fine->mesh;
    Arena scratch = {0};
    ObjectNodes sorted = sort_nodes(fine->light, &fine->nodes, &scratch);
    FineSource *out = ARENA_ARRAY(arena, FineSource, fine->source_count);
    for (int e = 0; e < mesh->element_count; e++) {
        const Face *face = &mesh->faces[mesh->elements[e].face];
        if (fine->element[e] >= 0) continue;
        out[-1 - fine->element[e]] = source_of(fine->light, &fine->nodes, &sorted, face->object,
                                               element_centroid(mesh, e), face->plane.n);
    }
    arena_free(&scratch);
    return out;
}

// ---- light

// The light that must have fallen on a place that reflects so much; for channels that it does not reflect, the mean of the others.
static void irradiance_of(const Material *m, const double reflected[3], double out[3]) {
    double rho[3], sum = 0;
    int count = 0;
    rgb_doubles(m->reflectance, rho);
    for (int c = 0; c < 3; c++) {
        if (!(rho[c] > 0)) continue;
        sum += out[c] = fmax(reflected[c], 0) / rho[c];
        count++;
    }
    for (int c = 0; c < 3; c++)
        if (!(rho[c] > 0)) out[c] = sum / count;
}

typedef struct Lighting {
    const FineMesh *fine;
    double (*irradiance)[3];  // [nodes.count]
} Lighting;

// `reflected`: [nodes.count] of the light's nodes.
static Lighting lighting(const FineMesh *fine, double (*reflected)[3], Arena *arena) {
    int count = fine->nodes.count;
    Lighting out = {fine, arena_alloc(arena, (size_t)count, sizeof *out.irradiance)};
    for (int n = 0; n < count; n++) {
        const Material *m = face_material(fine->light, &fine->nodes, n);
        if (tells(m)) irradiance_of(m, reflected[n], out.irradiance[n]);
    }
    return out;
}

static void reflected_by(const Lighting *l, int element, double out[3]) {
    const FineMesh *fine = l->fine;
    const FineSource *s = &fine->sources[-1 - fine->element[element]];
    double rho[3];
    rgb_doubles(mesh_reflectance(&fine->mesh, element), rho);
    for (int c = 0; c < 3; c++) {
        out[c] = 0;
        for (int k = 0; k < FINE_SOURCES; k++)
            out[c] += rho[c] * (double)s->share[k] * l->irradiance[s->node[k]][c];
    }
}

// The reflectance at nodes of the light's mesh.
static double (*node_light(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    int count = fine->nodes.count;
    double(*out)[3] = arena_alloc(arena, (size_t)count + 1, sizeof *out);
    if (solution->node)
        memcpy(out, solution->node, (size_t)count * sizeof *out);
    else
        reconstruct_nodes(fine->light, &fine->nodes, solution, NULL, out);
    for (int n = 0; n < count; n++) {
        double e[3];
        rgb_doubles(face_material(fine->light, &fine->nodes, n)->emission, e);
        for (int c = 0; c < 3; c++) out[n][c] -= e[c];
    }
    return out;
}

static double (*direct_at_nodes(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    RadSolution direct = *solution;
    double(*out)[3] = arena_alloc(arena, (size_t)fine->nodes.count + 1, sizeof *out);
    direct.radiosity = solution->direct;
    reconstruct_nodes(fine->light, &fine->nodes, &direct, NULL, out);
    return out;
}

static double (*unshot_at_nodes(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    const Nodes *nodes = &fine->nodes;
    double(*out)[3] = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out);
    for (int n = 0; n < nodes->count; n++) {
        int patch = fine->light->elements[nodes->element[nodes->first[n]]].patch;
        double own[3], mean[3];
        rgb_doubles(mesh_patch_reflectance(fine->light, patch), own);
        rgb_doubles(face_material(fine->light, nodes, n)->reflectance, mean);
        for (int c = 0; c < 3; c++)
            out[n][c] = solution->unshot[patch][c] * (own[c] > 0 ? mean[c] / own[c] : 1);
    }
    return out;
}

// Gathered light stays where it was gathered; of what is fine it is what its elements have.
static void fill_nodes(const FineMesh *fine, const RadSolution *solution, RadSolution *out, Arena *arena) {
    const Nodes *nodes = &fine->own;
    out->node = arena_alloc(arena, (size_t)nodes->count, sizeof *out->node);
    out->node_count = nodes->count;
    reconstruct_nodes(&fine->mesh, nodes, out, fine->fine, out->node);
    for (int c = 0; c < fine->mesh.corner_count; c++) {
        int of_light = fine->corner[c];
        if (of_light >= 0)
            memcpy(out->node[nodes->of_corner[c]], solution->node[fine->nodes.of_corner[of_light]],
                   sizeof *out->node);
    }
}

// The nodes that are of fine elements alone.
static bool *find_fine(const FineMesh *fine, Arena *arena) {
    bool *out = ARENA_ARRAY(arena, bool, fine->own.count + 1);
    for (int n = 0; n < fine->own.count; n++) out[n] = true;
    for (int c = 0; c < fine->mesh.corner_count; c++)
        if (fine->corner[c] >= 0) out[fine->own.of_corner[c]] = false;
    return out;
}

static double (*fine_rest(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    RadSolution rest = *solution;
    rest.node = solution->rest;
    rest.rest = NULL;
    return fine_light(fine, &rest, arena).node;
}

static double (*fine_direct(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    Arena scratch = {0};
    const Mesh *mesh = &fine->mesh;
    double(*out)[3] = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out);
    Lighting l = lighting(fine, direct_at_nodes(fine, solution, &scratch), &scratch);
    for (int e = 0; e < mesh->element_count; e++) {
        if (fine->element[e] >= 0)
            memcpy(out[e], solution->direct[fine->element[e]], sizeof *out);
        else
            reflected_by(&l, e, out[e]);
    }
    arena_free(&scratch);
    return out;
}

static double (*fine_unshot(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    Arena scratch = {0};
    const Mesh *mesh = &fine->mesh;
    double(*out)[3] = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out);
    Lighting l = lighting(fine, unshot_at_nodes(fine, solution, &scratch), &scratch);
    for (int p = 0; p < mesh->patch_count; p++) {
        if (fine->patch[p] >= 0)
            memcpy(out[p], solution->unshot[fine->patch[p]], sizeof *out);
        else
            reflected_by(&l, -1 - fine->patch[p], out[p]);
    }
    arena_free(&scratch);
    return out;
}

RadSolution fine_light(const FineMesh *fine, const RadSolution *solution, Arena *arena) {
    if (fine->same) return *solution;
    const Mesh *mesh = &fine->mesh;
    Arena scratch = {0};
    RadSolution out = *solution;
    out.daylight = out.sun = NULL;
    out.element_count = mesh->element_count;
    out.patch_count = mesh->patch_count;
    out.node = NULL;
    out.node_count = 0;
    out.rest = solution->node && solution->rest ? fine_rest(fine, solution, arena) : NULL;
    out.radiosity = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out.radiosity);
    Lighting l = lighting(fine, node_light(fine, solution, &scratch), &scratch);
    for (int e = 0; e < mesh->element_count; e++) {
        if (fine->element[e] >= 0)
            memcpy(out.radiosity[e], solution->radiosity[fine->element[e]], sizeof *out.radiosity);
        else
            reflected_by(&l, e, out.radiosity[e]);
    }
    if (solution->direct) out.direct = fine_direct(fine, solution, arena);
    if (solution->unshot) out.unshot = fine_unshot(fine, solution, arena);
    if (solution->node) fill_nodes(fine, solution, &out, arena);
    arena_free(&scratch);
    return out;
}

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
    *out = (Mesh){.graph = fine->light->graph, .options = fine->light->options, .panes = fine->light->panes};
    make_room(out, fine->light, of_fine, fine, arena);
    join_vertices(out, join, arena, &scratch);
    for (int o = 0; o < out->graph->object_count; o++) take_object(join, o, at);
    CORE_ASSERT(at[0] == fine->light->face_count && at[1] == of_fine->face_count);
    mesh_find_reflectances(out, arena);
    arena_free(&scratch);
}

FineMesh *fine_mesh_new(const Mesh *light, Arena *arena) {
    FineMesh *fine = ARENA_ARRAY(arena, FineMesh, 1);
    Arena scratch = {0};
    Error error;
    Mesh of_fine;
    // A face narrower than an element is not covered.
    MeshOptions options = light->options;
    options.splits = NULL;
    options.per_patch = 1;
    options.close = 0;
    options.replaced = true;
    *fine = (FineMesh){.light = light, .mesh = *light, .same = true};
    if (options.proxies && mesh_build(light->graph, NULL, &options, &scratch, &of_fine, &error)) {
        fine->same = false;
        join_meshes(fine, &of_fine, arena);
        fine->nodes = nodes_of(light, arena);
        fine->own = nodes_of(&fine->mesh, arena);
        fine->fine = find_fine(fine, arena);
        fine->sources = fine_sources(fine, arena);
    }
    arena_free(&scratch);
    return fine;
}
