// build.c - a building made in memory, two rooms with a passage between them, and what is seen in it with the eye in each.
#include <enfilade/enfilade.h>
#include <stdio.h>

// A room's inner faces, closed by walls of 15 cm.
static void add_room(EnfArena *arena, EnfSketch *sketch, const char *name, double x0, double x1) {
    const EnfVec2 corners[4] = {{x0, 0}, {x1, 0}, {x1, 4}, {x0, 4}};
    EnfSketchRoom room = {.first_point = sketch->point_count,
                          .point_count = 4,
                          .name = name,
                          .place = name,
                          .z0 = 0,
                          .z1 = 2.5,
                          .wall = 0.15};
    for (int i = 0; i < 4; i++) {
        *ENF_ARENA_PUSH(arena, sketch->points, sketch->point_count, sketch->point_capacity) = corners[i];
    }
    *ENF_ARENA_PUSH(arena, sketch->rooms, sketch->room_count, sketch->room_capacity) = room;
}

int main(void) {
    EnfArena arena = {0};
    EnfError error;
    EnfBuilding building = {.form = ENF_FORM_REGIONS, .source = "two rooms", .start = {2, 2, 1.6}};
    EnfSketch sketch = {0};
    EnfVisPrepared ready;
    EnfVisPrepareOptions options = enf_vis_prepare_default_options();

    EnfMaterial plaster = {.name = "plaster", .reflectance = {0.7f, 0.7f, 0.7f}, .alpha = 1};
    int material = enf_building_add_material(&arena, &building, plaster);
    EnfStorey storey = {.name = "ground", .floor = 0, .height = 2.5, .slab = 0.3};
    *ENF_ARENA_PUSH(&arena, building.storeys, building.storey_count, building.storey_capacity) = storey;
    sketch.ground_material = sketch.outer_material = sketch.slab_material = material;
    add_room(&arena, &sketch, "west", 0, 4);
    add_room(&arena, &sketch, "east", 4.15, 8.15);
    EnfSketchOpening passage = {.kind = ENF_OPENING_PASSAGE,
                                .centre = {4.075, 2},
                                .angle = 1.5707963267948966,
                                .width = 1,
                                .depth = 0.15,
                                .sill = 0,
                                .head = 2.1,
                                .name = "passage",
                                .place = "passage"};
    *ENF_ARENA_PUSH(&arena, sketch.openings, sketch.opening_count, sketch.opening_capacity) = passage;

    const char *fault;
    if (!enf_maps_enclose(&sketch, &building, &arena, &error) ||
        !enf_vis_prepare(&building, &options, NULL, &arena, &ready, &error)) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    if (enf_building_check(&building, &arena, &fault, 1) > 0) {
        fprintf(stderr, "%s\n", fault);
        return 1;
    }
    EnfVisQuery *query = enf_vis_query_new(&ready.graph, &ready.forest, &arena);
    for (int i = 0; i < 2; i++) {
        EnfEye eye = {.position = {2 + 4.15 * i, 2, 1.6}};
        int cell = enf_vis_locate(&ready.graph, eye.position, -1);
        EnfVisResult seen = enf_vis_query(query, &eye, cell, NULL, ENF_CULL_STAB);
        printf("from %s: %d of %d cells\n", enf_vis_region(&ready.graph, cell)->name, seen.cell_count,
               ready.graph.cell_count);
    }
    enf_arena_free(&arena);
    return 0;
}
