// light_level.c - means of logarithms: a lamp that is a thousand times brighter counts for a few elements.
#include "engine/scene/light_level.h"

#include <math.h>

bool light_outdoors(const Mesh *mesh, int element) {
    int cell = mesh->patches[mesh->elements[element].patch].cell;
    return cell >= 0 && vis_region(mesh->graph, cell)->kind == REGION_OUTDOORS;
}

static bool emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

void light_level_add(LightLevel *level, const Mesh *mesh, const RadSolution *solution) {
    const bool day = daylight_shines(&solution->day);
    for (int e = 0; e < mesh->element_count; e++) {
        int face = mesh->elements[e].face;
        double b = light_luminous(solution->radiosity[e]);
        if (emits(mesh_material(mesh, face)) || !((float)b > 0) ||
            (mesh->options.part && !mesh_owns(mesh, face)))
            continue;
        double weight = mesh->elements[e].area * sqrt(b);
        int where = day && light_outdoors(mesh, e);
        level->log[where] += weight * log(b);
        level->weight[where] += weight;
    }
}

double light_level(const LightLevel *level) {
    int where = !(level->weight[0] > 0);
    return level->weight[where] > 0 ? exp(level->log[where] / level->weight[where]) : 0;
}
