// wad.c - Doom WADs: a map's sectors as rooms, cut into convex prisms; its doors and lifts as doors that move.
//
// The steps are: the lumps (wad_map.c), the plan cut into convex pieces (wad_bsp.c), their sectors and fewer of them
// (wad_sectors.c), the sectors that move (wad_movers.c), regions (wad_regions.c), doors (wad_openings.c). Here: their order,
// notes, and where one stands.
#include "maps/doom/wad.h"

// Eyes over the floor, and under the ceiling where it is low, metres.
static const double EYE = 1.6, CROWN = 0.1;
static const double FIELD_OF_VIEW = 70 * M_PI / 180;
// Numbers of things: players 1 to 4, and where they come back in a deathmatch.
enum { PLAYER_1 = 1, PLAYER_4 = 4, DEATHMATCH = 11 };

static bool recognise_wad(Bytes content) {
    return content.size >= 4 &&
           (memcmp(content.data, "IWAD", 4) == 0 || memcmp(content.data, "PWAD", 4) == 0);
}

// ---- where one stands

// The piece that holds a place, or -1.
static int piece_at(const WadPieces *pieces, WadPoint at) {
    for (int i = 0; i < pieces->piece_count; i++) {
        const WadPiece *p = &pieces->pieces[i];
        bool inside = p->sector >= 0;
        for (int k = 0; k < p->edge_count && inside; k++) {
            const WadEdge *e = &pieces->edges[p->first_edge + k];
            inside = e->side * wad_side_of(&pieces->axes[e->axis], at) >= 0;
        }
        if (inside) return i;
    }
    return -1;
}

static Vec3 eye_over(Vec2 at, double floor, double ceiling) {
    return vec3(at.x, at.y, fmin(floor + EYE, fmax((floor + ceiling) / 2, ceiling - CROWN)));
}

// An eye where a thing stands, on a lift as drawn; false outside.
static bool eye_of(const WadBuilder *w, const WadThing *thing, Vec3 *eye) {
    int piece = piece_at(w->pieces, thing->at);
    if (piece < 0 || w->first_region[piece] == w->first_region[piece + 1]) return false;
    int sector = w->pieces->pieces[piece].sector;
    double floor = wad_metres_of(w->map->sectors[sector].floor),
           ceiling = wad_metres_of(w->movers[sector].ceiling);
    *eye = eye_over(vec2(wad_metres_of((double)thing->at.x), wad_metres_of((double)thing->at.y)), floor,
                    ceiling);
    return true;
}

static void add_viewpoints(const WadBuilder *w) {
    Building *b = w->building;
    int deathmatch = 0;
    for (int i = 0; i < w->map->thing_count; i++) {
        const WadThing *t = &w->map->things[i];
        bool player = t->type >= PLAYER_1 && t->type <= PLAYER_4;
        Viewpoint v = {.yaw = t->angle * (M_PI / 180), .fov = FIELD_OF_VIEW};
        if ((!player && t->type != DEATHMATCH) || !eye_of(w, t, &v.eye)) continue;
        v.name = player ? arena_format(w->arena, "player %d", t->type)
                        : arena_format(w->arena, "deathmatch %d", ++deathmatch);
        *ARENA_PUSH(w->arena, b->viewpoints, b->viewpoint_count, b->viewpoint_capacity) = v;
    }
}

// Where player 1 begins, else another, else any thing stands; in a map without, in the middle of the first region.
static void set_start(const WadBuilder *w) {
    Building *b = w->building;
    for (int pass = 0; pass < 3; pass++) {
        for (int i = 0; i < w->map->thing_count; i++) {
            const WadThing *t = &w->map->things[i];
            bool player = t->type >= PLAYER_1 && (t->type <= PLAYER_4 || t->type == DEATHMATCH);
            if (pass == 0 ? t->type != PLAYER_1 : pass == 1 && !player) continue;
            if (!eye_of(w, t, &b->start)) continue;
            b->start_yaw = t->angle * (M_PI / 180);
            return;
        }
    }
    const Region *r = &b->regions[0];
    const Ring *ring = &b->rings[r->first_ring];
    Vec2 sum = {0, 0};
    for (int i = 0; i < ring->point_count; i++) sum = vec2_add(sum, b->points[ring->first_point + i]);
    b->start = eye_over(vec2_scale(sum, 1.0 / ring->point_count), r->z0, r->z1);
}

// ---- the whole

static void bound_world(Building *b) {
    b->world = box_empty();
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        const Ring *ring = &b->rings[r->first_ring];
        for (int k = 0; k < ring->point_count; k++) {
            Vec2 p = b->points[ring->first_point + k];
            b->world = box_add(box_add(b->world, vec3(p.x, p.y, r->z0)), vec3(p.x, p.y, r->z1));
        }
    }
}

// A map has one floor above each place: one storey, whose plan is drawn at the height where a walk begins.
static void add_storey(const WadBuilder *w) {
    Building *b = w->building;
    double floor = maps_snap(b->start.z - EYE);
    *ARENA_PUSH(w->arena, b->storeys, b->storey_count, b->storey_capacity) =
        (Storey){w->map->name, floor, fmax(b->world.max.z - floor, EYE), 0};
}

// The area that the lines enclose, and the part of it that did not become regions.
static void measure_lost_area(const WadMap *map, const WadPieces *pieces, const WadMover *movers,
                              Building *b) {
    double drawn = 0, used = 0;
    for (int i = 0; i < map->line_count; i++) {
        WadPoint p = map->vertices[map->lines[i].v[0]], q = map->vertices[map->lines[i].v[1]];
        double cross = (double)p.x * q.y - (double)p.y * q.x;
        drawn += cross * ((map->lines[i].sector[1] >= 0) - (map->lines[i].sector[0] >= 0)) / 2;
    }
    for (int i = 0; i < pieces->piece_count; i++) {
        const WadPiece *p = &pieces->pieces[i];
        bool there = p->sector >= 0 && movers[p->sector].floor < movers[p->sector].ceiling;
        for (int k = 0; there && k < p->edge_count; k++) {
            WadPoint a = pieces->edges[p->first_edge + k].from,
                     c = pieces->edges[p->first_edge + (k + 1) % p->edge_count].from;
            used += (wad_x(a) * wad_y(c) - wad_y(a) * wad_x(c)) / 2;
        }
    }
    b->drawn_area = WAD_METRE * WAD_METRE * fabs(drawn);
    b->lost_area = fmax(0, b->drawn_area - WAD_METRE * WAD_METRE * used);
}

static void note_lines(const WadMap *map, Arena *arena, Building *b) {
    enum { IMPASSABLE = 1 };
    int short_lines = 0, tricks = 0, sideless = 0, barred = 0;
    for (int i = 0; i < map->line_count; i++) {
        const WadLine *line = &map->lines[i];
        WadPoint p = map->vertices[line->v[0]], q = map->vertices[line->v[1]];
        bool two = line->sector[0] >= 0 && line->sector[1] >= 0;
        if (p.x == q.x && p.y == q.y) {
            short_lines++;
        } else if (line->sector[0] < 0 && line->sector[1] < 0) {
            sideless++;
        } else if (line->sector[0] == line->sector[1]) {
            tricks++;
        }
        barred += two && (line->flags & IMPASSABLE);
    }
    const struct {
        int count;
        int kind;
        const char *what;
    } NOTES[] = {{short_lines, NOTE_DROPPED, "lines have no length"},
                 {sideless, NOTE_DROPPED, "lines have no sides"},
                 {tricks, NOTE_DROPPED, "lines have the same sector on both sides and bound nothing"},
                 {barred, NOTE_CHANGED, "lines that the game lets nobody pass may be passed here"}};
    for (size_t i = 0; i < sizeof NOTES / sizeof *NOTES; i++) {
        if (NOTES[i].count > 0)
            building_note(arena, b, NOTES[i].kind, vec3(0, 0, 0), "%s: %s, %d %s", map->path, map->name,
                          NOTES[i].count, NOTES[i].what);
    }
}

static void note_solid(const WadMap *map, const WadMover *movers, Arena *arena, Building *b) {
    int solid = 0;
    for (int i = 0; i < map->sector_count; i++) solid += movers[i].floor >= movers[i].ceiling;
    if (solid > 0)
        building_note(arena, b, NOTE_DROPPED, vec3(0, 0, 0),
                      "%s: %s, %d sectors have no height, nor anything to open up to, and are solid",
                      map->path, map->name, solid);
}

static bool build_from_map(const WadMap *map, WadPieces *pieces, Arena *scratch, Arena *arena, Building *b,
                           Error *error) {
    wad_index_lines(map, pieces, scratch);
    wad_find_sectors(map, pieces, arena, b);
    wad_merge(pieces, scratch);
    WadBuilder builder = {.map = map,
                          .pieces = pieces,
                          .movers = wad_find_movers(map, scratch),
                          .arena = arena,
                          .scratch = scratch,
                          .building = b};
    wad_add_regions(&builder);
    if (b->region_count == 0)
        return error_set(error, "%s: none of the %d sectors of %s encloses a place (allowed: closed sectors)",
                         map->path, map->sector_count, map->name);
    wad_add_openings(&builder);
    bound_world(b);
    set_start(&builder);
    add_viewpoints(&builder);
    add_storey(&builder);
    measure_lost_area(map, pieces, builder.movers, b);
    note_lines(map, arena, b);
    note_solid(map, builder.movers, arena, b);
    wad_note_missing(builder.pictures);
    return true;
}

static bool read(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    WadMap map;
    WadPieces pieces;
    Arena scratch = {0};
    const char *wanted = out->map;
    *out = (Building){.form = FORM_REGIONS};
    bool good = wad_read_map(path, content, wanted, &scratch, &map, error) &&
                wad_cut_plan(&map, &scratch, &pieces, error);
    if (good) {
        out->map = map.name = arena_string(arena, map.name);
        good = build_from_map(&map, &pieces, &scratch, arena, out, error);
    }
    arena_free(&scratch);
    return good;
}

const MapsReader MAPS_READER_WAD = {
    .name = "wad",
    .suffixes = ".wad",
    .summary = "Doom WADs: the maps of the classic binary format, with their doors and lifts",
    .recognise = recognise_wad,
    .read = read,
    .has_maps = true,
};
