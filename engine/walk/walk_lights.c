// walk_lights.c - lamps by room. Not light transport: no shadows, no bounces, and strengths that make a room of any
// size pleasantly bright, so that a plan can be looked at before its light is computed.
#include "engine/walk/walk_lights.h"

// A lamp let into a ceiling is found in the room below: how far down to look, metres.
#define LAMP_DROP 0.4
// More lamps than this in one room are not told apart; the shader's loop stays short.
#define LAMPS_IN_ROOM 8

static int region_at(const CellGraph *graph, Vec3 p) {
    int cell = vis_locate(graph, p, -1);
    return cell >= 0 ? graph->cells[cell].region : -1;
}

// Of an object: where its middle is; else any region it is registered in.
static void find_regions(const CellGraph *graph, int *region) {
    for (int o = 0; o < graph->object_count; o++) {
        Box box = graph->object_boxes[o];
        region[o] = box_is_empty(box) ? -1 : region_at(graph, vec3_lerp(box.min, box.max, 0.5));
    }
    for (int c = 0; c < graph->cell_count; c++) {
        // The cell's own surfaces lie around it, not in it: a ceiling's middle is on the boundary.
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++)
            region[o] = graph->cells[c].region;
        const CellMesh *mesh = &graph->meshes[c];
        int begin = graph->square_first[mesh->first_square];
        int end = graph->square_first[mesh->first_square + mesh->nx * mesh->ny];
        for (int k = begin; k < end; k++) {
            int o = graph->square_objects[k];
            if (region[o] < 0) region[o] = graph->cells[c].region;
        }
    }
}

static int lamp_region(const CellGraph *graph, Vec3 p) {
    for (double down = 0; down <= LAMP_DROP; down += LAMP_DROP / 8) {
        int region = region_at(graph, vec3(p.x, p.y, p.z - down));
        if (region >= 0 && graph->building->regions[region].kind == REGION_ROOM) return region;
    }
    return -1;
}

WalkLights walk_lights(const CellGraph *graph, Vec3 origin, Arena *arena) {
    const Building *b = graph->building;
    WalkLights lights = {.lamps = ARENA_ARRAY(arena, WalkLamp, b->light_count + 1),
                         .first = ARENA_ARRAY(arena, int, graph->object_count + 1),
                         .count = ARENA_ARRAY(arena, int, graph->object_count + 1),
                         .outdoors = ARENA_ARRAY(arena, unsigned char, graph->object_count + 1)};
    int *region = ARENA_ARRAY(arena, int, graph->object_count + 1),
        *home = ARENA_ARRAY(arena, int, b->light_count + 1);
    int *first = ARENA_ARRAY(arena, int, b->region_count + 1),
        *count = ARENA_ARRAY(arena, int, b->region_count + 1);
    find_regions(graph, region);
    for (int i = 0; i < b->light_count; i++) home[i] = lamp_region(graph, b->lights[i].position);
    for (int r = 0; r < b->region_count; r++) {
        first[r] = lights.lamp_count;
        for (int i = 0; i < b->light_count && lights.lamp_count - first[r] < LAMPS_IN_ROOM; i++) {
            if (home[i] != r) continue;
            Vec3 p = vec3_sub(b->lights[i].position, origin);
            Rgb flux = b->lights[i].flux;
            float most = fmaxf(fmaxf(flux.r, flux.g), fmaxf(flux.b, 1e-6f));
            lights.lamps[lights.lamp_count++] = (WalkLamp){
                {(float)p.x, (float)p.y, (float)p.z}, 1, {flux.r / most, flux.g / most, flux.b / most}, 0};
        }
        count[r] = lights.lamp_count - first[r];
        for (int k = first[r]; k < lights.lamp_count; k++)
            lights.lamps[k].strength = 1 / sqrtf((float)count[r]);
    }
    for (int o = 0; o < graph->object_count; o++) {
        if (region[o] < 0) continue;
        lights.first[o] = first[region[o]];
        lights.count[o] = count[region[o]];
        lights.outdoors[o] = b->regions[region[o]].kind == REGION_OUTDOORS;
    }
    return lights;
}
