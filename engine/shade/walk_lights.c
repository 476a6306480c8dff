// walk_lights.c - collects the lamps of each room. This is no light transport: there are no shadows and no bounces, and strengths make a
// room of any size pleasantly bright, so that a plan can be looked at before its light is computed.
#include "engine/shade/walk_lights.h"

#include "engine/core/polygon.h"

// A lamp let into a ceiling belongs to the room below it: how far down that room is looked for, metres.
#define LAMP_DROP 0.4
// A polygon that emits becomes a lamp this far in front of it, metres, so that the ceiling around a panel is lit a little too.
#define LAMP_FRONT 0.15
// Lamps nearer to each other than this become one, metres: the arms of a chandelier, the parts of a panel that spans cells.
#define LAMP_JOIN 0.7
// The most lamps of a room that stay separate, so that the shader's loop stays short; further lamps join the nearest.
enum { LAMPS_IN_ROOM = 8 };

typedef struct Lamp {
    Vec3 position;
    Rgb flux;
    double weight;  // of all lamps that joined it so far
} Lamp;

typedef struct RoomLamps {
    Lamp lamps[LAMPS_IN_ROOM];
    int count;
} RoomLamps;

static int region_at(const CellGraph *graph, Vec3 p) {
    int cell = vis_locate(graph, p, -1);
    return cell >= 0 ? graph->cells[cell].region : -1;
}

// Finds the region of each object: the one that its middle is in, otherwise any region that the object is registered in.
static void find_regions(const CellGraph *graph, int *region) {
    for (int o = 0; o < graph->object_count; o++) {
        Box box = graph->object_boxes[o];
        region[o] = box_is_empty(box) ? -1 : region_at(graph, vec3_lerp(box.min, box.max, 0.5));
    }
    for (int c = 0; c < graph->cell_count; c++) {
        // The cell's own surfaces lie around it, not in it: a ceiling's middle is on the boundary.
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++)
            region[o] = graph->cells[c].region;
        const SquareGrid *grid = &graph->grids[c];
        int begin = graph->square_first[grid->first_square];
        int end = graph->square_first[grid->first_square + grid->nx * grid->ny];
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

static float brightest(Rgb c) { return fmaxf(c.r, fmaxf(c.g, c.b)); }

static void add_lamp(RoomLamps *room, Vec3 position, Rgb flux) {
    Lamp *nearest = NULL;
    double distance = INFINITY, weight = fmax((double)brightest(flux), 1e-6);
    for (int i = 0; i < room->count; i++) {
        double d = vec3_length(vec3_sub(room->lamps[i].position, position));
        if (d >= distance) continue;
        distance = d;
        nearest = &room->lamps[i];
    }
    if (distance > LAMP_JOIN && room->count < LAMPS_IN_ROOM) {
        room->lamps[room->count++] = (Lamp){position, flux, weight};
        return;
    }
    nearest->weight += weight;
    nearest->position = vec3_lerp(nearest->position, position, weight / nearest->weight);
    nearest->flux = (Rgb){nearest->flux.r + flux.r, nearest->flux.g + flux.g, nearest->flux.b + flux.b};
}

static void add_emitters(const CellGraph *graph, int object, const int *region, RoomLamps *rooms) {
    const Building *b = graph->building;
    const Object *o = &graph->objects[object];
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *p = &graph->polygons[i];
        Rgb e = b->materials[p->material].emission;
        if (brightest(e) <= 0) continue;
        const Vec3 *v = graph->vertices + p->first_vertex;
        Vec3 middle = vec3(0, 0, 0);
        for (int k = 0; k < p->vertex_count; k++) middle = vec3_add(middle, v[k]);
        Vec3 front = vec3_scale(plane_of_polygon(v, p->vertex_count).n, LAMP_FRONT);
        middle = vec3_add(vec3_scale(middle, 1.0 / p->vertex_count), front);
        int in = o->kind == OBJECT_SURFACE ? region[object] : region_at(graph, middle);
        if (in < 0 || b->regions[in].kind != REGION_ROOM) continue;
        float area = (float)polygon_area(v, p->vertex_count);
        add_lamp(&rooms[in], middle, (Rgb){e.r * area, e.g * area, e.b * area});
    }
}

static RoomLamps *find_lamps(const CellGraph *graph, const int *region, Arena *scratch) {
    const Building *b = graph->building;
    RoomLamps *rooms = ARENA_ARRAY(scratch, RoomLamps, b->region_count + 1);
    for (int i = 0; i < b->light_count; i++) {
        int in = lamp_region(graph, b->lights[i].position);
        if (in >= 0) add_lamp(&rooms[in], b->lights[i].position, b->lights[i].flux);
    }
    // An object in the building's own list of lights is a lamp's glowing shade, which is no second lamp.
    bool *has_light = ARENA_ARRAY(scratch, bool, graph->object_count + 1);
    for (int i = 0; i < b->light_count; i++) {
        if (b->lights[i].object >= 0) has_light[b->lights[i].object] = true;
    }
    for (int o = 0; o < graph->object_count; o++) {
        if (!has_light[o]) add_emitters(graph, o, region, rooms);
    }
    return rooms;
}

// The lamps of a room share a given strength in proportion to their flux; a room with more lamps is a little brighter.
static void write_lamps(const RoomLamps *room, Vec3 origin, WalkLamp *out) {
    double sum = 0;
    for (int i = 0; i < room->count; i++) sum += room->lamps[i].weight;
    for (int i = 0; i < room->count; i++) {
        const Lamp *lamp = &room->lamps[i];
        Vec3 p = vec3_sub(lamp->position, origin);
        float most = fmaxf(brightest(lamp->flux), 1e-6f);
        out[i] = (WalkLamp){{(float)p.x, (float)p.y, (float)p.z},
                            (float)(sqrt(room->count) * lamp->weight / sum),
                            {lamp->flux.r / most, lamp->flux.g / most, lamp->flux.b / most},
                            0};
    }
}

WalkLights walk_lights(const CellGraph *graph, Vec3 origin, Arena *arena) {
    int objects = graph->object_count, regions = graph->building->region_count;
    Arena scratch = {0};
    WalkLights lights = {.region = ARENA_ARRAY(arena, int, objects + 1),
                         .first = ARENA_ARRAY(arena, int, regions + 1)};
    find_regions(graph, lights.region);
    const RoomLamps *rooms = find_lamps(graph, lights.region, &scratch);
    for (int r = 0; r < regions; r++) {
        lights.first[r] = lights.lamp_count;
        lights.lamp_count += rooms[r].count;
    }
    lights.first[regions] = lights.lamp_count;
    lights.lamps = ARENA_ARRAY(arena, WalkLamp, lights.lamp_count + 1);
    for (int r = 0; r < regions; r++) write_lamps(&rooms[r], origin, lights.lamps + lights.first[r]);
    arena_free(&scratch);
    return lights;
}
