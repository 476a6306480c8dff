// mesh_cells.c - the cells of the graph that patches lie in.
#include "radiosity/mesh/mesh_parts.h"

// The cell of a patch is the one that contains a point this far in front of its face, metres: more than rounding, less than any gap
// in a building.
static const double IN_FRONT = 1e-6;

// For a patch whose centre lies inside a wall that its polygon goes through (a roof over a gable, the frame of a door): the largest
// part of an element that lies in a cell becomes the patch's centre and cell, because the patch's light comes from there.
static void find_part(Mesh *mesh, Patch *patch) {
    Vec3 front = vec3_scale(mesh->faces[patch->face].plane.n, IN_FRONT), middle;
    Arena scratch = {0};
    double largest = 0, area;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const Element *element = &mesh->elements[e];
        Vec3 *v = ARENA_ARRAY(&scratch, Vec3, element->corner_count);
        for (int i = 0; i < element->corner_count; i++)
            v[i] = vec3_add(mesh->vertices[mesh->corners[element->first_corner + i]], front);
        int cell = vis_locate_part(mesh->graph, v, element->corner_count, &scratch, &middle, &area);
        if (cell < 0 || area <= largest) continue;
        largest = area;
        patch->cell = cell;
        patch->centre = vec3_sub(middle, front);
    }
    arena_free(&scratch);
}

int mesh_find_cell(Mesh *mesh, int index, int hint) {
    Patch *patch = &mesh->patches[index];
    Vec3 n = mesh->faces[patch->face].plane.n;
    patch->cell = vis_locate(mesh->graph, vec3_add(patch->centre, vec3_scale(n, IN_FRONT)), hint);
    if (patch->cell < 0) find_part(mesh, patch);
    return patch->cell;
}

void mesh_find_cells(Mesh *mesh) {
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    int *cell_of = ARENA_ARRAY(&scratch, int, graph->object_count), hint = -1;
    for (int o = 0; o < graph->object_count; o++) cell_of[o] = -1;
    for (int c = 0; c < graph->cell_count; c++)
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++) cell_of[o] = c;
    for (int i = 0; i < mesh->patch_count; i++) {
        int surface = cell_of[mesh->faces[mesh->patches[i].face].object];
        mesh->patches[i].cell = surface;
        if (surface < 0) surface = mesh_find_cell(mesh, i, hint);
        if (surface >= 0) hint = surface;
        mesh->lost_patches += surface < 0;
    }
    arena_free(&scratch);
}
