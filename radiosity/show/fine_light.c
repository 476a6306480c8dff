// fine_light.c - light that falls on a stand-in falls on what it stands for: irradiances at nodes of the one, near and looking the same
// way, are those of elements of the other (inverse distances: Shepard 1968; with normals as for cached irradiance: Ward, Rubinstein &
// Clear 1988). Elements reflect them by their own materials.
#include "radiosity/show/fine_sources.h"

#include "radiosity/show/reconstruct.h"

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

FineSource *fine_sources(const FineMesh *fine, Arena *arena) {
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

static void rgb3(Rgb c, double out[3]) {
    out[0] = (double)c.r;
    out[1] = (double)c.g;
    out[2] = (double)c.b;
}

// The light that must have fallen on a place that reflects so much; for channels that it does not reflect, the mean of the others.
static void irradiance_of(const Material *m, const double reflected[3], double out[3]) {
    double rho[3], sum = 0;
    int count = 0;
    rgb3(m->reflectance, rho);
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
    rgb3(mesh_material(&fine->mesh, fine->mesh.elements[element].face)->reflectance, rho);
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
        reconstruct_nodes(fine->light, &fine->nodes, solution, out);
    for (int n = 0; n < count; n++) {
        double e[3];
        rgb3(face_material(fine->light, &fine->nodes, n)->emission, e);
        for (int c = 0; c < 3; c++) out[n][c] -= e[c];
    }
    return out;
}

static double (*unshot_at_nodes(const FineMesh *fine, const RadSolution *solution, Arena *arena))[3] {
    const Nodes *nodes = &fine->nodes;
    double(*out)[3] = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out);
    for (int n = 0; n < nodes->count; n++) {
        int patch = fine->light->elements[nodes->element[nodes->first[n]]].patch;
        memcpy(out[n], solution->unshot[patch], sizeof *out);
    }
    return out;
}

// Gathered light stays where it was gathered; of what is fine it is what its elements have.
static void fill_nodes(const FineMesh *fine, const RadSolution *solution, RadSolution *out, Arena *arena) {
    Arena scratch = {0};
    Nodes nodes = nodes_of(&fine->mesh, &scratch);
    out->node = arena_alloc(arena, (size_t)nodes.count, sizeof *out->node);
    out->node_count = nodes.count;
    reconstruct_nodes(&fine->mesh, &nodes, out, out->node);
    for (int c = 0; c < fine->mesh.corner_count; c++) {
        int of_light = fine->corner[c];
        if (of_light >= 0)
            memcpy(out->node[nodes.of_corner[c]], solution->node[fine->nodes.of_corner[of_light]],
                   sizeof *out->node);
    }
    arena_free(&scratch);
}

RadSolution fine_light(const FineMesh *fine, const RadSolution *solution, Arena *arena) {
    if (fine->same) return *solution;
    const Mesh *mesh = &fine->mesh;
    Arena scratch = {0};
    RadSolution out = *solution;
    out.element_count = mesh->element_count;
    out.patch_count = mesh->patch_count;
    out.node = NULL;
    out.node_count = 0;
    out.radiosity = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out.radiosity);
    out.unshot = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out.unshot);
    Lighting l = lighting(fine, node_light(fine, solution, &scratch), &scratch);
    for (int e = 0; e < mesh->element_count; e++) {
        if (fine->element[e] >= 0)
            memcpy(out.radiosity[e], solution->radiosity[fine->element[e]], sizeof *out.radiosity);
        else
            reflected_by(&l, e, out.radiosity[e]);
    }
    l = lighting(fine, unshot_at_nodes(fine, solution, &scratch), &scratch);
    for (int p = 0; p < mesh->patch_count; p++) {
        if (fine->patch[p] >= 0)
            memcpy(out.unshot[p], solution->unshot[fine->patch[p]], sizeof *out.unshot);
        else
            reflected_by(&l, -1 - fine->patch[p], out.unshot[p]);
    }
    if (solution->node) fill_nodes(fine, solution, &out, arena);
    arena_free(&scratch);
    return out;
}
