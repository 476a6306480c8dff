// room_shares.c - patches by room, and sums over them.
#include "radiosity/shoot/room_shares.h"

// A room with less than this share of all power is dark: nobody sees it, and it may be the rounding of what was given and taken back.
static const double DARK = 1e-7;

static int room_of(const CellGraph *graph, int cell) {
    if (cell < 0 || vis_region(graph, cell)->kind == REGION_OUTDOORS) return -1;
    int region = graph->cells[cell].region;
    return region < 0 ? 0 : region;
}

RoomShares room_shares_new(const Mesh *mesh, Arena *arena) {
    int regions = mesh->graph->building->region_count;
    RoomShares s = {.room_count = regions > 0 ? regions : 1,
                    .of = ARENA_ARRAY(arena, int, mesh->patch_count + 1),
                    .patches = ARENA_ARRAY(arena, int, mesh->patch_count + 1)};
    s.first = ARENA_ARRAY(arena, int, s.room_count + 2);
    s.left = ARENA_ARRAY(arena, double, s.room_count);
    s.light = ARENA_ARRAY(arena, double, s.room_count);
    for (int p = 0; p < mesh->patch_count; p++) {
        s.of[p] = room_of(mesh->graph, mesh->patches[p].cell);
        if (s.of[p] >= 0) s.first[s.of[p] + 2]++;
    }
    for (int r = 0; r < s.room_count; r++) s.first[r + 2] += s.first[r + 1];
    for (int p = 0; p < mesh->patch_count; p++)
        if (s.of[p] >= 0) s.patches[s.first[s.of[p] + 1]++] = p;
    return s;
}

void room_shares_measure(RoomShares *shares, const Mesh *mesh, const RadSolution *solution, double emitted) {
    memset(shares->left, 0, (size_t)shares->room_count * sizeof *shares->left);
    memset(shares->light, 0, (size_t)shares->room_count * sizeof *shares->light);
    shares->least = DARK * emitted;
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        int room = shares->of[p];
        if (room < 0 || !mesh_owns(mesh, patch->face)) continue;
        const double *unshot = solution->unshot[p];
        shares->left[room] += patch->area * (fabs(unshot[0]) + fabs(unshot[1]) + fabs(unshot[2]));
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
            shares->light[room] += mesh->elements[e].area * rgb_sum(solution->radiosity[e]);
    }
}

int room_shares_first(const RoomShares *shares, double residual) {
    for (int r = 0; r < shares->room_count; r++)
        if (room_shares_lacks(shares, r, residual)) return r;
    return -1;
}
