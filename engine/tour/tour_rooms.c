// tour_rooms.c - rooms as people count them: regions of one name that touch are one room.
#include "engine/tour/tour_rooms.h"

#include <string.h>

// A part whose places cover less, m^2, or reach less far, metres, is too small to walk in.
static const double LEAST_AREA = 0.4, LEAST_REACH = 1.0;
// The floor of a building without regions is cut into pieces that reach this far from their middle, metres.
static const double PIECE = 4.0;

static int first_of(int *room, int region) {
    while (room[region] != region) region = room[region] = room[room[region]];
    return region;
}

// [region_count] the room of each region, -1 for those that are no rooms.
static int *join_regions(const CellGraph *graph, Arena *arena, TourRoute *out) {
    const Building *b = graph->building;
    int *joined = ARENA_ARRAY(arena, int, b->region_count), *room = ARENA_ARRAY(arena, int, b->region_count);
    for (int r = 0; r < b->region_count; r++) joined[r] = r;
    for (int i = 0; i < graph->portal_count; i++) {
        int r = graph->cells[graph->portals[i].cell[0]].region,
            s = graph->cells[graph->portals[i].cell[1]].region;
        bool one = b->regions[r].kind == REGION_ROOM && b->regions[s].kind == REGION_ROOM &&
                   *b->regions[r].name && strcmp(b->regions[r].name, b->regions[s].name) == 0;
        if (one) joined[first_of(joined, s)] = first_of(joined, r);
    }
    out->room_name = ARENA_ARRAY(arena, const char *, b->region_count);
    for (int r = 0; r < b->region_count; r++) {
        room[r] = -1;
        if (b->regions[r].kind != REGION_ROOM || first_of(joined, r) != r) continue;
        out->room_name[out->room_count] = b->regions[r].name;
        room[r] = out->room_count++;
    }
    for (int r = 0; r < b->region_count; r++)
        if (b->regions[r].kind == REGION_ROOM) room[r] = room[first_of(joined, r)];
    return room;
}

// Cuts the floor into pieces, each around the first place that is in none.
static void cut_floor(const TourFloor *f, const unsigned char *wide, Arena *arena, int *of, TourRoute *out) {
    Arena scratch = {0};
    int *queue = ARENA_ARRAY(&scratch, int, f->place_count + 1);
    for (int p = 0; p < f->place_count; p++) {
        const FloorPlace *first = &f->places[p];
        if (of[p] >= 0 || !wide[first->part] || (first->unfit & (FLOOR_ON_THINGS | FLOOR_OUTSIDE))) continue;
        int count = 0;
        of[queue[count++] = p] = out->room_count;
        for (int i = 0; i < count; i++) {
            for (int k = 0; k < 8; k += 2) {
                int to = f->places[queue[i]].link[k];
                if (to < 0 || of[to] >= 0 || vec3_length(vec3_sub(f->places[to].foot, first->foot)) > PIECE)
                    continue;
                of[queue[count++] = to] = out->room_count;
            }
        }
        out->room_count++;
    }
    out->room_name = ARENA_ARRAY(arena, const char *, out->room_count + 1);
    for (int r = 0; r < out->room_count; r++) out->room_name[r] = "";
    arena_free(&scratch);
}

// [part_count] can a person walk in this part?
static unsigned char *find_wide(const TourFloor *f, Arena *arena) {
    unsigned char *wide = ARENA_ARRAY(arena, unsigned char, f->part_count + 1);
    Box *box = ARENA_ARRAY(arena, Box, f->part_count + 1);
    for (int i = 0; i < f->part_count; i++) box[i] = box_empty();
    for (int p = 0; p < f->place_count; p++)
        box[f->places[p].part] = box_add(box[f->places[p].part], f->places[p].foot);
    for (int i = 0; i < f->part_count; i++) {
        double area = f->part_size[i] * f->apart * f->apart;
        wide[i] = area >= LEAST_AREA &&
                  hypot(box[i].max.x - box[i].min.x, box[i].max.y - box[i].min.y) >= LEAST_REACH;
    }
    return wide;
}

int *tour_rooms_find(const TourFloor *f, Arena *arena, TourRoute *out) {
    const CellGraph *graph = f->graph;
    int *of = ARENA_ARRAY(arena, int, f->place_count + 1);
    unsigned char *wide = find_wide(f, arena);
    bool regions = graph->building->region_count > 0;
    int *room = regions ? join_regions(graph, arena, out) : NULL;
    for (int p = 0; p < f->place_count; p++) {
        const FloorPlace *at = &f->places[p];
        of[p] = regions && at->cell >= 0 && wide[at->part] && !(at->unfit & FLOOR_ON_THINGS)
                    ? room[graph->cells[at->cell].region]
                    : -1;
    }
    if (!regions) cut_floor(f, wide, arena, of, out);
    out->room_state = arena_alloc(arena, (size_t)out->room_count + 1, sizeof *out->room_state);
    out->room_place = ARENA_ARRAY(arena, Vec3, out->room_count + 1);
    for (int c = 0; c < graph->cell_count && regions; c++) {
        const Cell *cell = &graph->cells[c];
        int r = room[cell->region];
        Vec2 corner = graph->plan[cell->first_edge];
        if (r >= 0) out->room_place[r] = vec3(corner.x, corner.y, cell->z0);
    }
    for (int p = 0; p < f->place_count; p++) {
        if (of[p] < 0) continue;
        if (out->room_state[of[p]] == ROOM_SHUT) out->room_place[of[p]] = f->places[p].foot;
        out->room_state[of[p]] = ROOM_OPEN;
    }
    for (int c = 0; c < graph->cell_count && f->chosen; c++) {
        int r = room[graph->cells[c].region];
        if (r >= 0 && !f->chosen[c] && out->room_state[r] == ROOM_SHUT) out->room_state[r] = ROOM_BEYOND;
    }
    return of;
}
