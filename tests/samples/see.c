// see.c - what can be seen of a building from the place where a walk begins: see BUILDING
#include <enfilade/enfilade.h>
#include <stdio.h>

int main(int argc, char **argv) {
    // Everything that is made lies in the arena; an error is one sentence.
    EnfArena arena = {0};
    EnfError error = {"usage: see BUILDING"};
    EnfBuilding building;
    EnfVisPrepared ready;
    EnfVisPrepareOptions options = enf_vis_prepare_default_options();
    if (argc < 2 || !enf_maps_read(argv[1], &arena, &building, &error) ||
        !enf_vis_prepare(&building, &options, NULL, &arena, &ready, &error)) {
        fprintf(stderr, "%s\n", error.text);
        enf_arena_free(&arena);
        return 1;
    }
    // All around, all doors open.
    EnfEye eye = {.position = building.start};
    EnfVisQuery *query = enf_vis_query_new(&ready.graph, &ready.forest, &arena);
    int cell = enf_vis_locate(&ready.graph, eye.position, -1);
    EnfVisResult seen = enf_vis_query(query, &eye, cell, NULL, ENF_CULL_STAB);
    printf("visible: %d of %d cells, %d of %d polygons\n", seen.cell_count, ready.graph.cell_count,
           seen.polygon_count, ready.graph.polygon_count);
    for (int i = 0; i < seen.cell_count; i++) {
        const char *room = enf_vis_region(&ready.graph, seen.cells[i].cell)->name;
        if (*room) printf("  %s\n", room);
    }
    enf_arena_free(&arena);
    return 0;
}
