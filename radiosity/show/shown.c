// shown.c - finer elements lie in those of the mesh that light was found on. Each has the light of the element around it, in
// proportion to the light at the corners, so that together they have its power.
#include "radiosity/show/shown.h"

#include <string.h>

#include "engine/core/error.h"
#include "radiosity/show/reconstruct.h"

bool shown_build(const Mesh *mesh, const MeshSplits *splits, const float *door_open, Arena *arena, Mesh *out,
                 Error *error) {
    const CellGraph *graph = mesh->graph;
    MeshOptions options = mesh->options;
    options.splits = splits;
    bool good = mesh_build(graph, door_open, &options, arena, out, error);
    CORE_ASSERT(!good || out->face_count == mesh->face_count);
    return good;
}

int shown_around(const Mesh *mesh, const Mesh *shown, int element) {
    return mesh_element_at(mesh, shown->elements[element].face, element_centroid(shown, element));
}

void shown_nodes(const Mesh *mesh, const RadSolution *solution, const Mesh *shown, const Nodes *nodes,
                 double (*out)[3]) {
    Arena scratch = {0};
    if (shown == mesh) {
        reconstruct_nodes(mesh, nodes, solution, NULL, out);
        return;
    }
    VertexLight light = reconstruct_light(mesh, solution, &scratch);
    light.triangle = reconstruct_triangles(mesh, &scratch);
    for (int n = 0; n < nodes->count; n++)
        reconstruct_in(mesh, &light, shown_around(mesh, shown, nodes->element[nodes->first[n]]),
                       shown->vertices[nodes->vertex[n]], out[n]);
    arena_free(&scratch);
}

// The mean of the light at an element's corners.
static void corner_mean(const Mesh *shown, const Nodes *nodes, double (*node)[3], int element,
                        double out[3]) {
    const Element *e = &shown->elements[element];
    out[0] = out[1] = out[2] = 0;
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++)
        for (int c = 0; c < 3; c++) out[c] += node[nodes->of_corner[i]][c] / e->corner_count;
}

// The parts of elements of `mesh`: their number, their area, and the power at their corners.
typedef struct Around {
    int count;
    double area, power[3];
} Around;

static void light_elements(const Mesh *mesh, const RadSolution *solution, const Mesh *shown,
                           const Nodes *nodes, RadSolution *out) {
    Arena scratch = {0};
    Around *around = ARENA_ARRAY(&scratch, Around, mesh->element_count + 1);
    int *in = ARENA_ARRAY(&scratch, int, shown->element_count + 1);
    double mean[3];
    for (int e = 0; e < shown->element_count; e++) {
        Around *a = &around[in[e] = shown_around(mesh, shown, e)];
        double area = shown->elements[e].area;
        corner_mean(shown, nodes, solution->node, e, mean);
        a->count++;
        a->area += area;
        for (int c = 0; c < 3; c++) a->power[c] += area * mean[c];
    }
    for (int e = 0; e < shown->element_count; e++) {
        const Around *a = &around[in[e]];
        corner_mean(shown, nodes, solution->node, e, mean);
        double from[3], to[3];
        mesh_even(mesh, in[e], from);
        mesh_even(shown, e, to);
        for (int c = 0; c < 3; c++) {
            bool even = a->count == 1 || !(a->power[c] > 0);
            double share = (even ? 1 : mean[c] * a->area / a->power[c]) * from[c] / to[c];
            out->radiosity[e][c] = share * solution->radiosity[in[e]][c];
            out->direct[e][c] = share * solution->direct[in[e]][c];
        }
    }
    for (int p = 0; p < shown->patch_count; p++)
        memcpy(out->unshot[p], solution->unshot[mesh->elements[in[shown->patches[p].first_element]].patch],
               sizeof *out->unshot);
    arena_free(&scratch);
}

bool shown_fill(const Mesh *mesh, const RadSolution *solution, const Mesh *finer, const Nodes *nodes,
                Arena *arena, RadSolution *out) {
    Arena scratch = {0};
    Nodes own;
    if (!nodes) {
        own = nodes_of(finer, &scratch);
        nodes = &own;
    }
    bool good = nodes->count == solution->node_count;
    if (good) {
        *out = *solution;
        out->shown = NULL;
        out->daylight = out->sun = NULL;
        out->element_count = finer->element_count;
        out->patch_count = finer->patch_count;
        out->radiosity = arena_alloc(arena, (size_t)finer->element_count + 1, sizeof *out->radiosity);
        out->direct = arena_alloc(arena, (size_t)finer->element_count + 1, sizeof *out->direct);
        out->unshot = arena_alloc(arena, (size_t)finer->patch_count + 1, sizeof *out->unshot);
        light_elements(mesh, solution, finer, nodes, out);
    }
    arena_free(&scratch);
    return good;
}

bool shown_light(const Mesh *mesh, const RadSolution *solution, const float *door_open, Arena *arena,
                 const Mesh **shown, const RadSolution **light, Error *error) {
    *shown = mesh;
    *light = solution;
    if (!solution->shown) return true;
    Mesh *finer = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *out = ARENA_ARRAY(arena, RadSolution, 1);
    if (!shown_build(mesh, solution->shown, door_open, arena, finer, error)) return false;
    if (!shown_fill(mesh, solution, finer, NULL, arena, out))
        return error_set(error,
                         "the light is shown on elements that are not those of this program's version");
    *shown = finer;
    *light = out;
    return true;
}

double (*shown_means(const Mesh *mesh, const Mesh *shown, const RadSolution *solution, Arena *arena))[3] {
    Arena scratch = {0};
    Nodes nodes = nodes_of(shown, &scratch);
    double(*out)[3] = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *out);
    double *area = ARENA_ARRAY(&scratch, double, mesh->element_count + 1);
    CORE_ASSERT(nodes.count == solution->node_count);
    for (int e = 0; e < shown->element_count; e++) {
        const Element *element = &shown->elements[e];
        int in = shown == mesh ? e : shown_around(mesh, shown, e);
        double part = element->area / element->corner_count;
        area[in] += element->area;
        for (int k = element->first_corner; k < element->first_corner + element->corner_count; k++)
            for (int c = 0; c < 3; c++) out[in][c] += part * solution->node[nodes.of_corner[k]][c];
    }
    for (int e = 0; e < mesh->element_count; e++)
        for (int c = 0; c < 3 && area[e] > 0; c++) out[e][c] /= area[e];
    arena_free(&scratch);
    return out;
}
