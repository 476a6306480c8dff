// walk.c - a body walks from its start towards the middle of the farthest room, opens each door that stops it, and tells its way:
// walk BUILDING
#include <enfilade/enfilade.h>
#include <stdio.h>

// Steps of a sixtieth of a second at a walking pace.
static const double TICK = 1.0 / 60, PACE = 1.4;

int main(int argc, char **argv) {
    EnfArena arena = {0};
    EnfError error = {"usage: walk BUILDING"};
    EnfBuilding building;
    EnfVisPrepared ready;
    EnfVisPrepareOptions options = enf_vis_prepare_default_options();
    if (argc < 2 || !enf_maps_read(argv[1], &arena, &building, &error) ||
        !enf_vis_prepare(&building, &options, NULL, &arena, &ready, &error)) {
        fprintf(stderr, "%s\n", error.text);
        enf_arena_free(&arena);
        return 1;
    }
    EnfDoors doors = enf_doors_new(&ready.graph, &arena);
    for (int i = 0; i < building.opening_count; i++) enf_doors_set(&doors, i, 0);
    EnfBodyWorld world = enf_body_world(&ready.graph, doors.open, &arena);
    EnfBody body = {.cell = -1};
    if (!enf_body_place_near(&body, &world, building.start)) return 1;

    // The goal: the middle of the door's far side, through the first door that leads somewhere.
    int door = 0;
    while (door < building.opening_count && !enf_doors_usable(&doors, door)) door++;
    if (door == building.opening_count) return 1;
    const EnfOpening *o = &building.openings[door];
    EnfVec2 middle = enf_vec2_scale(enf_vec2_add(o->line[0], o->line[1]), 0.5);
    EnfVec2 across = enf_vec2_sub(o->line[1], o->line[0]);
    EnfVec2 foot = enf_vec2(body.foot.x, body.foot.y);
    EnfVec2 way = enf_vec2(-across.y, across.x);
    if (enf_vec2_dot(way, enf_vec2_sub(middle, foot)) < 0) way = enf_vec2_scale(way, -1);
    // First in front of the door, then through it.
    double side = 1.2 / enf_vec2_length(way);
    EnfVec2 stops[2] = {enf_vec2_sub(middle, enf_vec2_scale(way, side)),
                        enf_vec2_add(middle, enf_vec2_scale(way, side))};
    int region = ready.graph.cells[body.cell].region;
    for (int stop = 0, ticks = 0; stop < 2 && ticks < 60 * 60; ticks++) {
        EnfVec2 left = enf_vec2_sub(stops[stop], enf_vec2(body.foot.x, body.foot.y));
        double length = enf_vec2_length(left);
        if (length < 0.05 || (stop == 0 && length < 0.4)) {
            // A press on the door's handle: closed until now, it swings open while the body waits.
            if (stop++ == 0) enf_doors_toggle(&doors, door);
            continue;
        }
        if (doors.open[door] == doors.wanted[door]) {
            double step = PACE * TICK < length ? PACE * TICK : length;
            enf_body_step(&body, &world, enf_vec2_scale(left, step / length), TICK);
        }
        enf_doors_advance(&doors, TICK, &body);
    }
    int now = ready.graph.cells[body.cell].region;
    printf("from %s through %s to %s\n", building.regions[region].name, o->name, building.regions[now].name);
    enf_arena_free(&arena);
    return now == region;
}
