// ambient.c - M. F. Cohen, S. E. Chen, J. R. Wallace & D. P. Greenberg, A Progressive Refinement Approach to Fast Radiosity
// Image Generation, 1988, section 5: form factors are guessed as shares of the area, so that unshot light falls alike on
// everything, and is reflected 1 + rho + rho^2 + ... = 1 / (1 - rho) times, rho the mean reflectance.
// Departure: patches that lie in no cell (backs against walls, insides of closed boxes) and those outdoors are no part of it:
// a lawn would make all rooms green.
#include "radiosity/shoot/ambient.h"

static bool takes_part(const Mesh *mesh, const Patch *patch) {
    return patch->cell >= 0 && vis_region(mesh->graph, patch->cell)->kind != REGION_OUTDOORS;
}

void ambient_irradiance(const Mesh *mesh, const RadSolution *solution, double out[3]) {
    double area = 0, unshot[3] = {0}, reflected[3] = {0};
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        double rho[3];
        if (!takes_part(mesh, patch)) continue;
        rgb_doubles(mesh_patch_reflectance(mesh, p), rho);
        area += patch->area;
        for (int c = 0; c < 3; c++) {
            unshot[c] += patch->area * solution->unshot[p][c];
            reflected[c] += patch->area * rho[c];
        }
    }
    // In 1 - rho the areas cancel. Reflectances are below 1, so that it is never 0.
    for (int c = 0; c < 3; c++) out[c] = area > 0 ? unshot[c] / (area - reflected[c]) : 0;
}

void ambient_radiosities(const Mesh *mesh, const RadSolution *solution, double (*out)[3]) {
    double ambient[3];
    ambient_irradiance(mesh, solution, ambient);
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        bool glows = takes_part(mesh, patch);
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
            double rho[3];
            rgb_doubles(mesh_reflectance(mesh, e), rho);
            for (int c = 0; c < 3; c++)
                out[e][c] = solution->radiosity[e][c] + (glows ? rho[c] * ambient[c] : 0);
        }
    }
}
