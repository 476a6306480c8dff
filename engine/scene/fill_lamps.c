// fill_lamps.c - which rooms are dark, and where a lamp hangs free in them.
#include "engine/scene/fill_lamps.h"

#include <stdlib.h>

#include "engine/core/polygon.h"

const char *const FILL_LAMPS_NAMES[FILL_LAMPS_STATES] = {"off", "on"};

// Radiant flux per floor area where no room has a lamp, W/m^2 a channel: a lamp of 10 W, all channels together, in a room of 20 m^2.
static const double USUAL_FLUX = 0.17;
// From the ceiling to the lamp, metres: clear of the ceiling's polygons, and too small a gap to be seen.
static const double GAP = 0.005;
// Sides of the square, metres: that of a plain ceiling lamp, and that of a bulb for places in which the former has no room.
static const double SIDES[] = {0.3, 0.06};
// Free space kept around a lamp in plan, metres: a square that touches a wall lights little but this wall.
static const double MARGIN = 0.02;
// Lamps of a room hang at least so far apart, metres: about two heights of a room, so that their light on the floor overlaps.
static const double SPACING = 5;
// A cell longer than so many widths gets a lamp for each such piece. Widths count as at least NARROW metres.
static const double LONGEST_PIECE = 2.5, NARROW = 2;
// A second lamp hangs only in cells of at least this floor area, m^2: niches get light from beside.
static const double NICHE = 2;
// By night a room has light from its neighbours where openings to those with light have this share of its floor area together: a doorway is
// enough for a closet, and leaves the end of a corridor black.
static const double LIT_BESIDE = 0.5;
// Rooms of less floor area, m^2, are crevices between walls, which nobody enters.
static const double CREVICE = 0.1;
// A place is good where the lamp hangs in the upper quarter of the cell; lower ones hang below shelves or inside furniture.
static const double HIGH = 0.75;
// From this height over the floor, metres, or from the middle of lower cells, the ceiling above is searched: over tables and chairs.
static const double SEARCH_HEIGHT = 1.2;
// The height of a storey, metres, by which the volume of a room without regions becomes a floor area.
static const double STOREY = 2.5;
// Places tried along a side of a piece of a cell, an odd number: the middle is one of them.
enum { TRIED = 7 };
// The most lamps in one room, which bounds the work in huge halls.
enum { MOST_LAMPS = 64 };

typedef struct Room {
    int id;
    double area, flux;  // m^2; W, the sum of three channels
    bool bright;        // has a source of light of its own
    int first_cell;     // of its cells in Filling.cells; they end where those of the next room begin
} Room;

typedef struct Filling {
    const CellGraph *graph;
    Building *b;
    Arena *arena;
    Arena scratch;
    int *room;    // [cell_count] -1: not part of a room
    Room *rooms;  // [room_count + 1]
    int room_count;
    int *cells;  // room by room
    Box *boxes;  // [polygon_count] of the graph's polygons
    int *above;  // [above_count] those over the floor of the cell at hand
    int above_count;
    int *queue, *met;  // [cell_count] `met` holds the last room from which the cell was reached
} Filling;

// ---- rooms

static double cell_area(const Filling *f, const Cell *c) {
    double twice = 0;
    const Vec2 *plan = &f->graph->plan[c->first_edge];
    for (int i = 1; i + 1 < c->edge_count; i++)
        twice += vec2_cross(vec2_sub(plan[i], plan[0]), vec2_sub(plan[i + 1], plan[0]));
    return f->b->form == FORM_REGIONS ? twice / 2 : twice / 2 * (c->z1 - c->z0) / STOREY;
}

static bool is_outdoors(const Filling *f, int cell) {
    return vis_region(f->graph, cell)->kind == REGION_OUTDOORS;
}

// Makes a room of all indoor cells that ways without doors reach from a cell.
static void flood(Filling *f, int cell, int group) {
    int count = 0;
    f->queue[count++] = cell;
    f->room[cell] = group;
    for (int i = 0; i < count; i++) {
        const Cell *c = &f->graph->cells[f->queue[i]];
        for (int w = c->first_way; w < c->first_way + c->way_count; w++) {
            const Way *way = &f->graph->ways[w];
            if (f->graph->portals[way->portal].door >= 0 || f->room[way->cell] >= 0 ||
                is_outdoors(f, way->cell))
                continue;
            f->room[way->cell] = group;
            f->queue[count++] = way->cell;
        }
    }
}

static void find_rooms(Filling *f) {
    const CellGraph *g = f->graph;
    bool regions = f->b->form == FORM_REGIONS;
    for (int c = 0; c < g->cell_count; c++) f->room[c] = -1;
    f->room_count = regions ? f->b->region_count : 0;
    for (int c = 0; c < g->cell_count; c++) {
        if (regions && vis_region(g, c)->kind == REGION_ROOM) f->room[c] = g->cells[c].region;
        if (!regions && f->room[c] < 0 && !is_outdoors(f, c)) flood(f, c, f->room_count++);
    }
    f->rooms = ARENA_ARRAY(&f->scratch, Room, f->room_count + 2);
    f->cells = ARENA_ARRAY(&f->scratch, int, g->cell_count + 1);
    for (int r = 0; r < f->room_count; r++) f->rooms[r].id = r;
    for (int c = 0; c < g->cell_count; c++) {
        if (f->room[c] < 0) continue;
        f->rooms[f->room[c]].area += cell_area(f, &g->cells[c]);
        f->rooms[f->room[c] + 2].first_cell++;
    }
    for (int r = 0; r < f->room_count; r++) f->rooms[r + 2].first_cell += f->rooms[r + 1].first_cell;
    for (int c = 0; c < g->cell_count; c++)
        if (f->room[c] >= 0) f->cells[f->rooms[f->room[c] + 1].first_cell++] = c;
}

// ---- light that is there

static double emitted(const Filling *f, const Polygon *p) {
    Rgb e = f->b->materials[p->material].emission;
    return (double)e.r + (double)e.g + (double)e.b;
}

// A polygon shines into the cell before it. A step of more than the gap between a lamp and its square would leave thin cells.
static void add_emitter(Filling *f, const Polygon *p, Arena *scratch) {
    const Vec3 *v = &f->graph->vertices[p->first_vertex];
    Vec3 n = plane_of_polygon(v, p->vertex_count).n, moved[64], middle;
    double area;
    if (p->vertex_count > 64) return;
    for (int i = 0; i < p->vertex_count; i++) moved[i] = vec3_add(v[i], vec3_scale(n, VIS_TOUCH));
    int cell = vis_locate_part(f->graph, moved, p->vertex_count, scratch, &middle, &area);
    if (cell < 0) cell = vis_locate(f->graph, vec3_add(v[0], vec3_scale(n, VIS_TOUCH)), -1);
    if (cell < 0 || f->room[cell] < 0) return;
    Room *room = &f->rooms[f->room[cell]];
    room->bright = true;
    room->flux += emitted(f, p) * polygon_area(v, p->vertex_count);
}

static void find_emitters(Filling *f) {
    Arena scratch = {0};
    for (int i = 0; i < f->graph->polygon_count; i++)
        if (emitted(f, &f->graph->polygons[i]) > 0) add_emitter(f, &f->graph->polygons[i], &scratch);
    arena_free(&scratch);
}

// The light and the outdoors that a room reaches through ways without doors. A way through openings and shafts ends at the next room.
typedef struct Reach {
    bool outdoors;
    double bright;  // area of the ways' last portals into rooms with light, m^2
} Reach;

static Reach light_around(Filling *f, int room) {
    const CellGraph *g = f->graph;
    Reach out = {false, 0};
    int count = 0;
    for (int i = f->rooms[room].first_cell; i < f->rooms[room + 1].first_cell; i++) {
        f->met[f->cells[i]] = room;
        f->queue[count++] = f->cells[i];
    }
    for (int i = 0; i < count; i++) {
        const Cell *c = &g->cells[f->queue[i]];
        for (int w = c->first_way; w < c->first_way + c->way_count; w++) {
            int to = g->ways[w].cell;
            const Portal *portal = &g->portals[g->ways[w].portal];
            if (portal->door >= 0 || f->met[to] == room) continue;
            if (f->room[to] >= 0) {
                if (f->rooms[f->room[to]].bright)
                    out.bright +=
                        polygon_area(g->portal_vertices + portal->first_vertex, portal->vertex_count);
                continue;
            }
            f->met[to] = room;
            if (is_outdoors(f, to))
                out.outdoors = true;
            else
                f->queue[count++] = to;
        }
    }
    return out;
}

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// The median flux per area of rooms with lamps of their own, W/m^2 a channel.
static double flux_per_area(Filling *f) {
    double *per = ARENA_ARRAY(&f->scratch, double, f->room_count + 1);
    int count = 0;
    for (int r = 0; r < f->room_count; r++)
        if (f->rooms[r].flux > 0 && f->rooms[r].area > 0)
            per[count++] = f->rooms[r].flux / f->rooms[r].area / 3;
    if (count == 0) return USUAL_FLUX;
    qsort(per, (size_t)count, sizeof *per, compare_numbers);
    return per[count / 2];
}

// ---- places

// A place for a lamp: the middle of the square.
typedef struct Place {
    Vec3 at;
    double side;
} Place;

// The corners of a square in plan, counter-clockwise, and its middle.
static void square_points(Vec2 p, double half, Vec2 out[5]) {
    out[0] = vec2(p.x - half, p.y - half);
    out[1] = vec2(p.x + half, p.y - half);
    out[2] = vec2(p.x + half, p.y + half);
    out[3] = vec2(p.x - half, p.y + half);
    out[4] = p;
}

// The height at which the upright line through p meets a polygon, infinite where it passes by.
static double height_over(const Filling *f, int polygon, Vec2 p) {
    const Polygon *face = &f->graph->polygons[polygon];
    const Vec3 *v = &f->graph->vertices[face->first_vertex];
    bool inside = false;
    for (int i = 0; i < face->vertex_count; i++) {
        Vec3 a = v[i], b = v[i + 1 == face->vertex_count ? 0 : i + 1];
        inside ^= ring_edge_is_crossed(vec2(a.x, a.y), vec2(b.x, b.y), p, RING_DIVIDE_FIRST);
    }
    if (!inside) return INFINITY;
    Plane plane = plane_of_polygon(v, face->vertex_count);
    // Steeper polygons are walls: their height over a point is rounding.
    if (fabs(plane.n.z) < 1e-6) return INFINITY;
    return (plane.d - plane.n.x * p.x - plane.n.y * p.y) / plane.n.z;
}

// The lowest height over `from` that polygons leave free over a whole square; infinite where part of it has no ceiling.
static double ceiling_over(const Filling *f, Vec2 p, double half, double from) {
    Vec2 points[5];
    double low[5] = {INFINITY, INFINITY, INFINITY, INFINITY, INFINITY}, lowest = INFINITY;
    square_points(p, half, points);
    Box column = {{p.x - half, p.y - half, from}, {p.x + half, p.y + half, INFINITY}};
    for (int n = 0; n < f->above_count; n++) {
        int i = f->above[n];
        if (!box_overlap(f->boxes[i], column)) continue;
        for (int k = 0; k < 5; k++) {
            double z = height_over(f, i, points[k]);
            if (z > from) low[k] = fmin(low[k], z);
        }
        // A table's edge or a beam narrower than the square passes between its corners.
        if (f->boxes[i].min.z > from && f->boxes[i].max.z - f->boxes[i].min.z < GAP)
            lowest = fmin(lowest, f->boxes[i].min.z);
    }
    for (int k = 0; k < 5; k++) {
        if (low[k] == INFINITY) return INFINITY;
        lowest = fmin(lowest, low[k]);
    }
    return lowest;
}

// Does the box of a piece of furniture or of a stair hold the point? In a soup an object may be the whole building.
static bool in_furniture(const Filling *f, Vec3 p) {
    if (f->b->form != FORM_REGIONS) return false;
    for (int i = 0; i < f->b->object_count; i++) {
        ObjectKind kind = f->b->objects[i].kind;
        if ((kind == OBJECT_FURNITURE || kind == OBJECT_STAIR || kind == OBJECT_LAMP) &&
            box_contains(box_grow(f->graph->object_boxes[i], MARGIN), p))
            return true;
    }
    return false;
}

static bool cell_holds(const Filling *f, const Cell *c, Vec2 p, double half) {
    Vec2 points[5];
    square_points(p, half + MARGIN, points);
    for (int k = 0; k < 5; k++)
        if (!ring_contains(&f->graph->plan[c->first_edge], c->edge_count, points[k])) return false;
    return true;
}

// Is the square free there? Then its height over the cell's floor, as a share of the cell's, goes to *share.
static bool hangs_free(const Filling *f, const Cell *c, Vec2 p, double side, Place *out, double *share) {
    double height = c->z1 - c->z0, from = c->z0 + fmin(SEARCH_HEIGHT, height / 2);
    if (!cell_holds(f, c, p, side / 2)) return false;
    double top = ceiling_over(f, p, side / 2, from);
    if (top == INFINITY || top - GAP <= from) return false;
    *out = (Place){{p.x, p.y, top - GAP}, side};
    *share = fmin((top - c->z0) / height, 1);
    return !in_furniture(f, out->at);
}

// The free place nearest to the middle of a piece of a cell that is high enough, else the highest one.
static bool find_place(const Filling *f, const Cell *c, Vec2 middle, Vec2 size, Place *out) {
    double best = 0, best_far = INFINITY;
    for (int s = 0; s < (int)(sizeof SIDES / sizeof *SIDES) && best == 0; s++)
        for (int i = 0; i < TRIED * TRIED; i++) {
            double u = (double)(i % TRIED) / (TRIED - 1) - 0.5, v = (double)(i / TRIED) / (TRIED - 1) - 0.5;
            // The places lie within nine tenths of the piece, so that those of its border are not on it.
            Vec2 off = vec2(0.9 * u * size.x, 0.9 * v * size.y);
            double share, far = vec2_length(off);
            Place place;
            if (best == 1 && far >= best_far) continue;
            if (!hangs_free(f, c, vec2_add(middle, off), SIDES[s], &place, &share)) continue;
            if (share >= HIGH) share = 1;
            if (share < best || (share == best && far >= best_far)) continue;
            best = share;
            best_far = far;
            *out = place;
        }
    return best > 0;
}

static Vec2 plan_middle(const Filling *f, const Cell *c) {
    const Vec2 *plan = &f->graph->plan[c->first_edge];
    Vec2 sum = {0, 0};
    double whole = 0;
    for (int i = 1; i + 1 < c->edge_count; i++) {
        double twice = vec2_cross(vec2_sub(plan[i], plan[0]), vec2_sub(plan[i + 1], plan[0]));
        sum = vec2_add(sum, vec2_scale(vec2_add(plan[0], vec2_add(plan[i], plan[i + 1])), twice / 3));
        whole += twice;
    }
    return whole > 0 ? vec2_scale(sum, 1 / whole) : plan[0];
}

// ---- lamps

typedef struct SizedCell {
    int cell;
    double area;
} SizedCell;

// The largest first; of equals the first.
static int compare_cells(const void *a, const void *b) {
    const SizedCell *x = a, *y = b;
    if (x->area != y->area) return x->area < y->area ? 1 : -1;
    return (x->cell > y->cell) - (x->cell < y->cell);
}

static bool is_far(const Place *places, int count, Vec3 p) {
    for (int i = 0; i < count; i++)
        if (vec3_length(vec3_sub(places[i].at, p)) < SPACING) return false;
    return true;
}

static void list_above(Filling *f, const Cell *c) {
    Box column = c->box;
    column.max.z = INFINITY;
    f->above_count = 0;
    for (int i = 0; i < f->graph->polygon_count; i++)
        if (box_overlap(f->boxes[i], column)) f->above[f->above_count++] = i;
}

// Lamps of a cell: one in its middle, or one in the middle of each piece along a long cell.
static int place_in_cell(Filling *f, const Cell *c, Place *places, int count) {
    list_above(f, c);
    Vec2 size = vec2(c->box.max.x - c->box.min.x, c->box.max.y - c->box.min.y), middle = plan_middle(f, c);
    double length = fmax(size.x, size.y), width = fmax(fmin(size.x, size.y), NARROW);
    int pieces = (int)fmin(fmax(round(length / (LONGEST_PIECE * width)), 1), MOST_LAMPS);
    bool along = size.x > size.y;
    Vec2 step = along ? vec2(size.x / pieces, 0) : vec2(0, size.y / pieces);
    if (along) size.x /= pieces;
    if (!along) size.y /= pieces;
    for (int i = 0; i < pieces && count < MOST_LAMPS; i++) {
        Vec2 at = vec2_add(middle, vec2_scale(step, i - 0.5 * (pieces - 1)));
        Place place;
        if (find_place(f, c, at, size, &place) && is_far(places, count, place.at)) places[count++] = place;
    }
    return count;
}

static int find_places(Filling *f, int room, Place places[MOST_LAMPS]) {
    const CellGraph *g = f->graph;
    Arena scratch = {0};
    SizedCell *cells = ARENA_ARRAY(&scratch, SizedCell, g->cell_count + 1);
    int cell_count = 0, count = 0;
    for (int c = 0; c < g->cell_count; c++)
        if (f->room[c] == room) cells[cell_count++] = (SizedCell){c, cell_area(f, &g->cells[c])};
    qsort(cells, (size_t)cell_count, sizeof *cells, compare_cells);
    for (int i = 0; i < cell_count && count < MOST_LAMPS; i++)
        if (count == 0 || cells[i].area >= NICHE)
            count = place_in_cell(f, &g->cells[cells[i].cell], places, count);
    arena_free(&scratch);
    return count;
}

// The square faces down.
static void add_lamp(Filling *f, const Place *place, double watts) {
    double half = place->side / 2;
    float exitance = (float)(watts / (place->side * place->side));
    Vec2 plan[5];
    Vec3 corner[4];
    square_points(vec2(place->at.x, place->at.y), half, plan);
    for (int i = 0; i < 4; i++) corner[i] = vec3(plan[3 - i].x, plan[3 - i].y, place->at.z);
    Material m = {.name = "fill lamp", .alpha = 1, .emission = {exitance, exitance, exitance}};
    building_add_object(f->arena, f->b, OBJECT_LAMP, "fill lamp");
    building_add_polygon(f->arena, f->b, corner, 4, building_add_material(f->arena, f->b, m));
}

static int compare_rooms(const void *a, const void *b) {
    const Room *x = a, *y = b;
    if (x->area != y->area) return x->area < y->area ? 1 : -1;
    return (x->id > y->id) - (x->id < y->id);
}

// Rooms by area, since a large room that has got a lamp also lights small rooms that are open to it. Returns how many got lamps.
static int fill_rooms(Filling *f, bool day) {
    int rooms = 0;
    Room *order = ARENA_ARRAY(&f->scratch, Room, f->room_count + 1);
    for (int r = 0; day && r < f->room_count; r++)
        if (f->rooms[r].area > 0 && light_around(f, r).outdoors) f->rooms[r].bright = true;
    for (int r = 0; r < f->room_count; r++) order[r] = f->rooms[r];
    qsort(order, (size_t)f->room_count, sizeof *order, compare_rooms);
    double per_area = flux_per_area(f);
    for (int c = 0; c < f->graph->cell_count; c++) f->met[c] = -1;
    for (int i = 0; i < f->room_count; i++) {
        Place places[MOST_LAMPS];
        Room *room = &f->rooms[order[i].id];
        if (room->area < CREVICE || room->bright) continue;
        double beside = light_around(f, room->id).bright;
        if (beside > 0 && (day || beside >= LIT_BESIDE * room->area)) continue;
        int count = find_places(f, room->id, places);
        for (int k = 0; k < count; k++) add_lamp(f, &places[k], per_area * room->area / count);
        room->bright = count > 0;
        f->b->fill_lamps += count;
        rooms += count > 0;
    }
    return rooms;
}

static Box box_of_polygon(const CellGraph *g, const Polygon *p) {
    Box box = box_empty();
    for (int k = 0; k < p->vertex_count; k++) box = box_add(box, g->vertices[p->first_vertex + k]);
    return box;
}

void fill_lamps_add(const CellGraph *graph, bool day, Arena *arena, Building *b, int *rooms) {
    *rooms = b->fill_lamps = 0;
    if (b->form == FORM_CELLS) return;
    Filling f = {.graph = graph, .b = b, .arena = arena};
    f.room = ARENA_ARRAY(&f.scratch, int, graph->cell_count + 1);
    f.queue = ARENA_ARRAY(&f.scratch, int, graph->cell_count + 1);
    f.met = ARENA_ARRAY(&f.scratch, int, graph->cell_count + 1);
    f.boxes = ARENA_ARRAY(&f.scratch, Box, graph->polygon_count + 1);
    f.above = ARENA_ARRAY(&f.scratch, int, graph->polygon_count + 1);
    for (int c = 0; c < graph->cell_count; c++) f.met[c] = -1;
    for (int i = 0; i < graph->polygon_count; i++) f.boxes[i] = box_of_polygon(graph, &graph->polygons[i]);
    find_rooms(&f);
    find_emitters(&f);
    *rooms = fill_rooms(&f, day);
    arena_free(&f.scratch);
}
