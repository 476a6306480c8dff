// panes.c - which openings hold glass; and the transmittance of a pane, by Fresnel's formulae and the law of Bouguer.
#include "radiosity/mesh/panes.h"

#include <string.h>

#include "engine/core/fresnel.h"

// The index of refraction of clear float glass, in the middle of the spectrum that is seen; and the share of light that 3 mm of it let
// through, without the reflections of its faces. So a pane passes 0.91, as data sheets have it.
static const double INDEX = 1.52, THROUGH = 0.991;
// Panes reach so far into the wall around them, metres: more than rounding, less than any wall, so that no line slips by.
static const double INTO_WALL = 0.001;
// A pane whose normal rises more than this is not upright.
static const double LEVEL = 1e-6;

double glass_transmits(double cosine) {
    double reflected[2], sum = 0;
    if (!(cosine > 0)) return 0;
    double beyond = fresnel_shares(fmin(cosine, 1), INDEX, reflected);
    double through = pow(THROUGH, 1 / beyond);
    for (int i = 0; i < 2; i++) {
        double r = reflected[i];
        sum += through * (1 - r) * (1 - r) / (1 - r * through * r * through);
    }
    return sum / 2;
}

// ---- made once

static bool holds_glass(const Opening *o, const float *door_open, int index) {
    if (!o->glazed || o->fills) return false;
    return o->kind == OPENING_WINDOW || (o->kind == OPENING_DOOR && door_open && !(door_open[index] > 0));
}

static Pane pane_in(const Opening *o) {
    Vec2 along = vec2_sub(o->line[1], o->line[0]);
    double width = vec2_length(along), height = o->head - o->sill, wide = width + 2 * INTO_WALL,
           high = height + 2 * INTO_WALL;
    Vec2 unit = vec2_scale(along, 1 / width), corner = vec2_sub(o->line[0], vec2_scale(unit, INTO_WALL));
    Vec3 n = {unit.y, -unit.x, 0}, origin = {corner.x, corner.y, o->sill - INTO_WALL};
    return (Pane){.plane = {n, vec3_dot(n, origin)},
                  .origin = origin,
                  .x = vec3(unit.x / wide, unit.y / wide, 0),
                  .y = vec3(0, 0, 1 / high),
                  .room = -1};
}

// The cells of each opening: its own, and those on both sides of the portals that its door closes.
typedef struct OpeningCells {
    int *first;  // [opening_count + 1] in `cells`
    int *cells;
} OpeningCells;

// Counts a cell of an opening, or lists it where `out` is there; `last` [opening_count] is the cell that each had last.
static void note_cell(int opening, int cell, int *last, int *end, int *out) {
    if (opening < 0 || last[opening] == cell) return;
    last[opening] = cell;
    if (out) out[end[opening]] = cell;
    end[opening]++;
}

static void each_cell(const CellGraph *graph, int *last, int *end, int *out) {
    for (int o = 0; o < graph->building->opening_count; o++) last[o] = -1;
    for (int c = 0; c < graph->cell_count; c++) {
        const Region *region = vis_region(graph, c);
        if (region->kind == REGION_OPENING) note_cell(region->opening, c, last, end, out);
        for (int w = graph->cells[c].first_way; w < graph->cells[c].first_way + graph->cells[c].way_count;
             w++)
            note_cell(graph->portals[graph->ways[w].portal].door, c, last, end, out);
    }
}

static OpeningCells list_cells(const CellGraph *graph, Arena *arena) {
    Arena scratch = {0};
    int count = graph->building->opening_count;
    int *last = ARENA_ARRAY(&scratch, int, count + 1), *end = ARENA_ARRAY(&scratch, int, count + 1);
    OpeningCells out = {.first = ARENA_ARRAY(arena, int, count + 1)};
    each_cell(graph, last, end, NULL);
    for (int o = 0; o < count; o++) {
        out.first[o + 1] = out.first[o] + end[o];
        end[o] = out.first[o];
    }
    out.cells = ARENA_ARRAY(arena, int, out.first[count] + 1);
    each_cell(graph, last, end, out.cells);
    arena_free(&scratch);
    return out;
}

Panes panes_of(const CellGraph *graph, const float *door_open, Arena *arena) {
    const Building *b = graph->building;
    Panes out = {.panes = NULL};
    int glazed = 0;
    for (int i = 0; i < b->opening_count; i++) glazed += holds_glass(&b->openings[i], door_open, i);
    if (glazed == 0) return out;
    OpeningCells list = list_cells(graph, arena);
    out.cells = list.cells;
    out.panes = ARENA_ARRAY(arena, Pane, glazed);
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (!holds_glass(o, door_open, i) || vec2_equal(o->line[0], o->line[1]) || !(o->head > o->sill))
            continue;
        Pane pane = pane_in(o);
        pane.opening = i;
        pane.first_cell = list.first[i];
        pane.cell_count = list.first[i + 1] - list.first[i];
        out.panes[out.count++] = pane;
    }
    return out;
}

// ---- black panes

// Where a cell lies when rooms are closed, but for `open`.
static int room_of(const CellGraph *graph, int cell) {
    const Building *b = graph->building;
    const Region *region = vis_region(graph, cell);
    if (region->kind == REGION_ROOM) return graph->cells[cell].region;
    if (region->kind == REGION_SHAFT) return PANES_BETWEEN;
    if (region->kind == REGION_OUTDOORS) return PANES_OUTDOORS;
    for (int side = 0; side < 2; side++) {
        int beyond = b->openings[region->opening].region[side];
        if (beyond < 0 || b->regions[beyond].kind != REGION_ROOM) return PANES_OUTDOORS;
    }
    return PANES_BETWEEN;
}

// The rectangle about a portal, along its longest edge.
static Pane pane_about(const CellGraph *graph, const Portal *portal) {
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    Vec3 along = {0}, origin = v[0];
    double longest = 0, low[2] = {0, 0}, high[2] = {0, 0};
    for (int i = 0; i < portal->vertex_count; i++) {
        Vec3 edge = vec3_sub(v[(i + 1) % portal->vertex_count], v[i]);
        if (vec3_length(edge) <= longest) continue;
        longest = vec3_length(edge);
        along = vec3_scale(edge, 1 / longest);
    }
    Vec3 axis[2] = {along, vec3_cross(portal->plane.n, along)};
    for (int i = 0; i < portal->vertex_count; i++)
        for (int k = 0; k < 2; k++) {
            double at = vec3_dot(axis[k], vec3_sub(v[i], origin));
            low[k] = fmin(low[k], at);
            high[k] = fmax(high[k], at);
        }
    for (int k = 0; k < 2; k++) {
        origin = vec3_add(origin, vec3_scale(axis[k], low[k]));
        axis[k] = vec3_scale(axis[k], 1 / (high[k] - low[k]));
    }
    return (Pane){.plane = portal->plane, .origin = origin, .x = axis[0], .y = axis[1], .opening = -1};
}

Panes panes_between_rooms(const CellGraph *graph, const Panes *glass, Arena *arena) {
    PaneRoom *rooms = ARENA_ARRAY(arena, PaneRoom, graph->cell_count + 1);
    bool *open = ARENA_ARRAY(arena, bool, graph->building->region_count + 1);
    Panes out = {.panes = ARENA_ARRAY(arena, Pane, glass->count + 2 * graph->portal_count + 1),
                 .cells = glass->cells,
                 .count = glass->count,
                 .rooms = rooms};
    for (int c = 0; c < graph->cell_count; c++) rooms[c].room = room_of(graph, c);
    if (glass->count > 0) memcpy(out.panes, glass->panes, (size_t)glass->count * sizeof *out.panes);
    for (int p = 0; p < graph->portal_count; p++) {
        const Portal *portal = &graph->portals[p];
        for (int side = 0; side < 2; side++) {
            int room = rooms[portal->cell[side]].room, there = rooms[portal->cell[!side]].room;
            if (room < 0 || there == room) continue;
            if (there == PANES_OUTDOORS) {
                open[room] = true;
                continue;
            }
            Pane *pane = &out.panes[out.count++];
            *pane = pane_about(graph, portal);
            pane->room = room;
        }
    }
    for (int c = 0; c < graph->cell_count; c++) rooms[c].open = rooms[c].room >= 0 && open[rooms[c].room];
    return out;
}

void panes_pose(const Panes *all, const Building *building, const float *door_open, Panes *out) {
    out->count = 0;
    for (int i = 0; i < all->count; i++) {
        int opening = all->panes[i].opening;
        if (holds_glass(&building->openings[opening], door_open, opening))
            out->panes[out->count++] = all->panes[i];
    }
}

void pane_corners(const Pane *pane, Vec3 out[4]) {
    Vec3 x = vec3_scale(pane->x, 1 / vec3_dot(pane->x, pane->x)),
         y = vec3_scale(pane->y, 1 / vec3_dot(pane->y, pane->y));
    out[0] = pane->origin;
    out[1] = vec3_add(pane->origin, x);
    out[2] = vec3_add(out[1], y);
    out[3] = vec3_add(pane->origin, y);
}

void panes_seen(const Panes *from, const StabForest *forest, int cell, Plane plane, Panes *out) {
    out->cells = from->cells;
    out->rooms = from->rooms;
    out->count = 0;
    for (int i = 0; i < from->count; i++) {
        const Pane *pane = &from->panes[i];
        bool seen = cell < 0 || pane->cell_count == 0, before = false;
        // Lines from a room to another one's black panes have passed its own.
        if (pane->room >= 0 && cell >= 0 && from->rooms[cell].room >= 0)
            seen = from->rooms[cell].room == pane->room;
        for (int k = pane->first_cell; k < pane->first_cell + pane->cell_count && !seen; k++)
            seen = vis_sees(forest, cell, from->cells[k]);
        if (!seen) continue;
        Vec3 corner[4];
        pane_corners(pane, corner);
        for (int k = 0; k < 4; k++) before = before || plane_distance(plane, corner[k]) > 0;
        if (before) out->panes[out->count++] = *pane;
    }
}

double panes_highest(const Panes *panes, Vec3 from) {
    double highest = -1;
    for (int i = 0; i < panes->count; i++) {
        const Pane *pane = &panes->panes[i];
        Vec3 off = vec3_sub(from, pane->origin);
        if (fabs(pane->plane.n.z) > LEVEL) return 1;
        // The nearest point of the upper edge, seen from above.
        double length2 = vec3_dot(pane->x, pane->x), at = fmin(fmax(vec3_dot(pane->x, off), 0), 1);
        double x = off.x - at * pane->x.x / length2, y = off.y - at * pane->x.y / length2;
        double up = 1 / pane->y.z - off.z, far = sqrt(x * x + y * y + up * up);
        highest = fmax(highest, up > 0 && far > 0 ? up / far : 0);
    }
    return highest;
}

// ---- light

static bool is_on(const Pane *pane, Vec3 p) {
    Vec3 off = vec3_sub(p, pane->origin);
    double x = vec3_dot(pane->x, off), y = vec3_dot(pane->y, off);
    return x >= 0 && x <= 1 && y >= 0 && y <= 1;
}

double panes_transmit(const Panes *panes, Vec3 from, Vec3 to) {
    double share = 1;
    for (int i = 0; i < panes->count; i++) {
        const Pane *pane = &panes->panes[i];
        double a = plane_distance(pane->plane, from), b = plane_distance(pane->plane, to);
        if ((a > 0) == (b > 0) || !is_on(pane, vec3_lerp(from, to, a / (a - b)))) continue;
        share *= pane_transmits(pane, fabs(a - b) / vec3_length(vec3_sub(to, from)));
    }
    return share;
}

double panes_transmit_from_afar(const Panes *panes, Vec3 to, Vec3 source) {
    double share = 1;
    for (int i = 0; i < panes->count; i++) {
        const Pane *pane = &panes->panes[i];
        double height = plane_distance(pane->plane, to), slope = vec3_dot(pane->plane.n, source);
        bool crosses = height > 0 ? slope < 0 : slope > 0;
        if (!crosses || !is_on(pane, vec3_add(to, vec3_scale(source, -height / slope)))) continue;
        share *= pane_transmits(pane, fabs(slope));
    }
    return share;
}

// With all rooms closed, can there be a line between the two cells?
static bool joined(const PaneRoom *a, const PaneRoom *b) {
    if (a->room == b->room) return true;
    return (a->open && b->room == PANES_OUTDOORS) || (b->open && a->room == PANES_OUTDOORS);
}

double panes_transmit_between(const Panes *panes, Vec3 from, int from_cell, Vec3 to, int to_cell) {
    bool known = panes->rooms && from_cell >= 0 && to_cell >= 0;
    if (known && !joined(&panes->rooms[from_cell], &panes->rooms[to_cell])) return 0;
    return panes_transmit(panes, from, to);
}
