// tour.c - a tour of every cell that a person can reach. The tour always goes to the nearest place not yet seen, by Dijkstra's
// shortest path through the portals that a person passes; cells that the path crosses count as seen. Cells are convex, so straight
// lines between the crossings stay in free space (but not clear of furniture).
#include "engine/sim/tour.h"

#include <stdio.h>
#include <string.h>

#include "engine/core/heap.h"

// The least clear width a person walks through, metres: narrower gaps are slits beside furniture and columns.
#define TOUR_WIDTH 0.5
// The least clear height, metres: cellar doors are lower than a person, who ducks.
#define TOUR_HEIGHT 1.2
// The highest step between two floors, metres: more than any stair's riser, less than a window sill.
#define TOUR_STEP_UP 0.5
// The eye keeps this far from a ceiling and from the ends of a portal, metres: a head's radius, a shoulder's breadth.
#define TOUR_HEADROOM 0.1
#define TOUR_SHOULDER 0.35
// How far the tour steps out of an outer door, metres.
#define TOUR_STEP_OUT 1.5
// The pitch, radians, is a little down, as people look when they walk: half the drop of an eye over 20 m.
#define TOUR_PITCH (-0.04)
// Moves shorter than this do not turn the head, metres.
#define TOUR_STILL 0.05

TourOptions tour_default_options(void) {
    return (TourOptions){.step = 0.5, .turn = 15 * M_PI / 180, .fov = 75 * M_PI / 180, .eye_height = 1.6};
}

typedef struct Guide {
    const CellGraph *graph;
    const TourOptions *options;
    Arena *arena;
    TourPath *path;
    unsigned char *passable;  // [portal_count]
    int *room;                // [room_count] the same number for all regions of one room (find_rooms)
    unsigned char *looked;    // [room_count] a turn was made in this room
    int *largest;             // [room_count] the room's largest cell, where the turn is made
    int *from;                // [cell_count] the way by which the shortest path enters; -1: none
    double *cost;             // [cell_count]
    Vec3 *at;                 // [cell_count] where the shortest path stands in the cell
    int *heap, *heap_slot;    // [cell_count]
    int heap_count;
    Vec3 eye;
    double yaw;
    int cell;
} Guide;

// ---- cells and portals that a person can pass

static RegionKind kind_of(const CellGraph *graph, int cell) { return vis_region(graph, cell)->kind; }

// The region of a cell; the cell itself in a building without regions.
static int room_of(const CellGraph *graph, int cell) {
    return graph->cells[cell].region >= 0 ? graph->cells[cell].region : cell;
}

static int room_count(const CellGraph *graph) {
    int regions = graph->building->region_count;
    return regions > 0 ? regions : graph->cell_count;
}

static bool enterable(const CellGraph *graph, int cell) {
    const Region *region = vis_region(graph, cell);
    if (region->kind == REGION_OPENING && graph->building->openings[region->opening].kind == OPENING_WINDOW) {
        return false;
    }
    // A shaft is only as high as the slab that it leads through, but a person passes it vertically.
    return region->kind == REGION_SHAFT || graph->cells[cell].z1 - graph->cells[cell].z0 >= TOUR_HEIGHT;
}

static Box portal_box(const CellGraph *graph, const Portal *portal) {
    Box box = box_empty();
    for (int i = 0; i < portal->vertex_count; i++) {
        box = box_add(box, graph->portal_vertices[portal->first_vertex + i]);
    }
    return box;
}

// Does a stair stand in the hole or under it?
static bool has_stair(const CellGraph *graph, Box hole) {
    for (int i = 0; i < graph->building->object_count; i++) {
        if (graph->objects[i].kind != OBJECT_STAIR) continue;
        Box stair = box_grow(graph->object_boxes[i], TOUR_STEP_UP);
        if (box_overlap(stair, hole)) return true;
    }
    return false;
}

static bool passable(const CellGraph *graph, const Portal *portal) {
    if (!enterable(graph, portal->cell[0]) || !enterable(graph, portal->cell[1])) return false;
    Box box = portal_box(graph, portal);
    if (portal->horizontal) {
        bool wide = box.max.x - box.min.x >= TOUR_WIDTH && box.max.y - box.min.y >= TOUR_WIDTH;
        bool outdoors = kind_of(graph, portal->cell[0]) == REGION_OUTDOORS &&
                        kind_of(graph, portal->cell[1]) == REGION_OUTDOORS;
        return wide && !outdoors && has_stair(graph, box);
    }
    double a = graph->cells[portal->cell[0]].z0, b = graph->cells[portal->cell[1]].z0;
    if (vec2_length(vec2_sub(portal->left, portal->right)) < TOUR_WIDTH) return false;
    if (kind_of(graph, portal->cell[0]) == REGION_SHAFT || kind_of(graph, portal->cell[1]) == REGION_SHAFT)
        return true;
    return box.max.z - fmax(a, b) >= TOUR_HEIGHT && box.min.z <= fmax(a, b) + MAPS_GRID &&
           fabs(a - b) <= TOUR_STEP_UP;
}

// Marks in `out` [cell_count] the cells that a person can reach from the cell `start`; returns their number.
static int reachable(const CellGraph *graph, int start, unsigned char *out) {
    memset(out, 0, (size_t)graph->cell_count);
    if (start < 0) return 0;
    out[start] = 1;
    int count = 1;
    // The loop sweeps over the portals until nothing is added: a handful of sweeps are enough, and no stack is needed.
    for (bool more = true; more;) {
        more = false;
        for (int i = 0; i < graph->portal_count; i++) {
            const Portal *portal = &graph->portals[i];
            if (out[portal->cell[0]] == out[portal->cell[1]] || !passable(graph, portal)) continue;
            out[portal->cell[0]] = out[portal->cell[1]] = 1;
            count++;
            more = true;
        }
    }
    return count;
}

// ---- places

static Vec3 centre_of_cell(const Guide *g, int cell) {
    const Cell *c = &g->graph->cells[cell];
    Vec2 sum = {0, 0};
    double area = 0;
    Vec2 o = g->graph->plan[c->first_edge];
    for (int i = 1; i + 1 < c->edge_count; i++) {
        Vec2 a = vec2_sub(g->graph->plan[c->first_edge + i], o);
        Vec2 b = vec2_sub(g->graph->plan[c->first_edge + i + 1], o);
        double twice = vec2_cross(a, b);
        sum = vec2_add(sum, vec2_scale(vec2_add(a, b), twice / 3));
        area += twice;
    }
    Vec2 centre = area > 0 ? vec2_add(o, vec2_scale(sum, 1 / area)) : o;
    double z = fmin(c->z0 + g->options->eye_height, fmax(c->z1 - TOUR_HEADROOM, (c->z0 + c->z1) / 2));
    return vec3(centre.x, centre.y, z);
}

// Where the path from `here` towards `there` crosses the portal: as straight as a person's breadth allows.
static Vec3 portal_crossing(const Guide *g, const Portal *portal, Vec3 here, Vec3 there) {
    Box box = portal_box(g->graph, portal);
    if (portal->horizontal) {
        Vec3 middle = {0, 0, 0};
        for (int i = 0; i < portal->vertex_count; i++) {
            middle = vec3_add(middle, g->graph->portal_vertices[portal->first_vertex + i]);
        }
        return vec3_scale(middle, 1.0 / portal->vertex_count);
    }
    Vec2 along = vec2_sub(portal->right, portal->left), path = vec2(there.x - here.x, there.y - here.y);
    double length = vec2_length(along), across = vec2_cross(along, path);
    double margin = fmin(TOUR_SHOULDER / length, 0.45), t = 0.5;
    if (across != 0) t = vec2_cross(vec2_sub(vec2(here.x, here.y), portal->left), path) / across;
    t = fmin(fmax(t, margin), 1 - margin);
    Vec2 p = vec2_add(portal->left, vec2_scale(along, t));
    double floor = (g->graph->cells[portal->cell[0]].z0 + g->graph->cells[portal->cell[1]].z0) / 2;
    double middle = (box.min.z + box.max.z) / 2;
    double z = fmin(fmax(floor + g->options->eye_height, fmin(box.min.z + TOUR_HEADROOM, middle)),
                    fmax(box.max.z - TOUR_HEADROOM, middle));
    return vec3(p.x, p.y, z);
}

// ---- frames

static void emit(Guide *g) {
    *ARENA_PUSH(g->arena, g->path->frames, g->path->frame_count, g->path->frame_capacity) =
        (TourFrame){g->eye, g->yaw, TOUR_PITCH, g->options->fov};
}

// The same angle within -pi .. pi.
static double wrap(double angle) { return remainder(angle, 2 * M_PI); }

static void turn_by(Guide *g, double angle) {
    int steps = (int)ceil(fabs(angle) / g->options->turn - 1e-9);
    double start = g->yaw;
    for (int i = 1; i <= steps; i++) {
        g->yaw = wrap(start + angle * i / steps);
        emit(g);
    }
}

static void go_to(Guide *g, Vec3 place) {
    Vec3 path = vec3_sub(place, g->eye), start = g->eye;
    double length = vec3_length(path);
    if (hypot(path.x, path.y) > TOUR_STILL) turn_by(g, wrap(atan2(path.y, path.x) - g->yaw));
    int steps = (int)ceil(length / g->options->step - 1e-9);
    for (int i = 1; i <= steps; i++) {
        g->eye = i == steps ? place : vec3_lerp(start, place, (double)i / steps);
        emit(g);
    }
}

// ---- the nearest place not yet seen

// Ties go to the lower cell, so that the tour is the same on every machine.
static bool is_cheaper(const void *guide, const void *first, const void *second) {
    const Guide *g = guide;
    int a = *(const int *)first, b = *(const int *)second;
    double dearer = g->cost[a] - g->cost[b];
    return dearer < 0 || (dearer == 0 && a < b);
}

static Heap heap_of(const Guide *g) {
    return (Heap){
        .items = g->heap, .size = sizeof *g->heap, .before = is_cheaper, .context = g, .slot = g->heap_slot};
}

// Puts a cell that was never reached before into the heap, or lets a cell rise that has become cheaper.
static void reach_cell(Guide *g, int cell) {
    const Heap heap = heap_of(g);
    heap_rise(&heap, g->heap_slot[cell] < 0 ? g->heap_count++ : g->heap_slot[cell], &cell);
}

static int take_cheapest(Guide *g) {
    int cell = g->heap[0];
    const Heap heap = heap_of(g);
    heap_drop_first(&heap, g->heap_count);
    g->heap_slot[cell] = --g->heap_count;
    return cell;
}

static bool is_outer_step(const Guide *g, int cell, const Portal **door) {
    const Cell *c = &g->graph->cells[cell];
    for (int i = 0; i < c->way_count; i++) {
        const Way *way = &g->graph->ways[c->first_way + i];
        const Portal *portal = &g->graph->portals[way->portal];
        if (kind_of(g->graph, way->cell) == REGION_OPENING && g->passable[way->portal]) {
            *door = portal;
            return true;
        }
    }
    return false;
}

static bool is_target(const Guide *g, int cell) {
    int room = g->room[room_of(g->graph, cell)];
    RegionKind kind = kind_of(g->graph, cell);
    if (kind == REGION_ROOM && !g->looked[room] && g->largest[room] == cell) return true;
    return !g->path->visited[cell];
}

// Dijkstra's algorithm from the place of the tour; returns the nearest target or -1.
static int find_target(Guide *g) {
    const CellGraph *graph = g->graph;
    for (int c = 0; c < graph->cell_count; c++) {
        g->cost[c] = INFINITY;
        g->from[c] = g->heap_slot[c] = -1;
    }
    g->heap_count = 0;
    g->cost[g->cell] = 0;
    g->at[g->cell] = g->eye;
    reach_cell(g, g->cell);
    while (g->heap_count > 0) {
        int cell = take_cheapest(g);
        if (is_target(g, cell)) return cell;
        const Cell *c = &graph->cells[cell];
        for (int i = 0; i < c->way_count; i++) {
            int way = c->first_way + i, next = graph->ways[way].cell;
            const Portal *portal = &graph->portals[graph->ways[way].portal];
            if (!g->path->reachable[next] || !g->passable[graph->ways[way].portal]) continue;
            Vec3 at = portal_crossing(g, portal, g->at[cell], centre_of_cell(g, next));
            double cost = g->cost[cell] + vec3_length(vec3_sub(at, g->at[cell]));
            if (cost >= g->cost[next]) continue;
            g->cost[next] = cost;
            g->from[next] = way;
            g->at[next] = at;
            reach_cell(g, next);
        }
    }
    return -1;
}

static void enter(Guide *g, int cell) {
    g->cell = cell;
    g->path->visited_count += !g->path->visited[cell];
    g->path->visited[cell] = 1;
}

// Steps out of an outer door and looks back at it.
static void look_back(Guide *g, const Portal *door) {
    int side = kind_of(g->graph, door->cell[0]) == REGION_OPENING ? 1 : 0;
    Vec3 out = vec3_scale(door->plane.n, side == 0 ? 1 : -1);
    Vec3 start = portal_crossing(g, door, g->eye, vec3_add(g->eye, out));
    double reach = TOUR_STEP_OUT;
    Vec3 place = vec3_add(start, vec3_scale(out, reach));
    for (; reach > 0.1 && vis_locate(g->graph, place, g->cell) != g->cell; reach /= 2) {
        place = vec3_add(start, vec3_scale(out, reach / 2));
    }
    if (reach > 0.1) go_to(g, place);
    turn_by(g, wrap(atan2(-out.y, -out.x) - g->yaw));
}

static void walk_to(Guide *g, int target) {
    int *path = ARENA_ARRAY(g->arena, int, g->graph->cell_count + 1), count = 0;
    for (int c = target; g->from[c] >= 0;) {
        path[count++] = g->from[c];
        const Portal *portal = &g->graph->portals[g->graph->ways[g->from[c]].portal];
        c = portal->cell[0] == c ? portal->cell[1] : portal->cell[0];
    }
    for (int i = count - 1; i >= 0; i--) {
        const Way *way = &g->graph->ways[path[i]];
        Vec3 there = i > 0 ? g->at[g->graph->ways[path[i - 1]].cell] : centre_of_cell(g, target);
        go_to(g, portal_crossing(g, &g->graph->portals[way->portal], g->eye, there));
        enter(g, way->cell);
    }
    RegionKind kind = kind_of(g->graph, target);
    const Portal *door;
    if (kind == REGION_OUTDOORS) {
        if (is_outer_step(g, target, &door)) look_back(g, door);
        return;
    }
    go_to(g, centre_of_cell(g, target));
    int room = g->room[room_of(g->graph, target)];
    if (kind != REGION_ROOM || g->looked[room] || g->largest[room] != target) return;
    g->looked[room] = 1;
    turn_by(g, 2 * M_PI);
}

// ---- the tours

static int find_start(const CellGraph *graph) {
    int cell = vis_locate(graph, graph->building->start, -1);
    if (cell >= 0 && enterable(graph, cell)) return cell;
    for (int c = 0; c < graph->cell_count; c++) {
        if (kind_of(graph, c) == REGION_ROOM && enterable(graph, c)) return c;
    }
    return 0;
}

static double plan_area(const CellGraph *graph, const Cell *cell) {
    double twice = 0;
    Vec2 o = graph->plan[cell->first_edge];
    for (int i = 1; i + 1 < cell->edge_count; i++) {
        twice += vec2_cross(vec2_sub(graph->plan[cell->first_edge + i], o),
                            vec2_sub(graph->plan[cell->first_edge + i + 1], o));
    }
    return twice / 2;
}

static int first_of_room(int *room, int region) {
    while (room[region] != region) region = room[region] = room[room[region]];
    return region;
}

// Regions of the same name that touch are pieces of one room.
static void find_rooms(Guide *g) {
    const CellGraph *graph = g->graph;
    const Building *b = graph->building;
    for (int r = 0; r < room_count(graph); r++) g->room[r] = r;
    if (b->region_count == 0) return;
    for (int i = 0; i < graph->portal_count; i++) {
        int r = graph->cells[graph->portals[i].cell[0]].region,
            s = graph->cells[graph->portals[i].cell[1]].region;
        bool one = *b->regions[r].name && strcmp(b->regions[r].name, b->regions[s].name) == 0;
        if (one) g->room[first_of_room(g->room, s)] = first_of_room(g->room, r);
    }
    for (int r = 0; r < b->region_count; r++) g->room[r] = first_of_room(g->room, r);
}

static void find_largest(Guide *g) {
    const CellGraph *graph = g->graph;
    for (int r = 0; r < room_count(graph); r++) g->largest[r] = -1;
    for (int c = 0; c < graph->cell_count; c++) {
        int *largest = &g->largest[g->room[room_of(graph, c)]];
        if (!g->path->reachable[c]) continue;
        if (*largest < 0 || plan_area(graph, &graph->cells[c]) > plan_area(graph, &graph->cells[*largest])) {
            *largest = c;
        }
    }
}

static void tour_auto(const CellGraph *graph, const TourOptions *options, Arena *arena, TourPath *out) {
    int cells = graph->cell_count;
    Guide guide = {.graph = graph, .options = options, .arena = arena, .path = out};
    guide.passable = ARENA_ARRAY(arena, unsigned char, graph->portal_count + 1);
    for (int i = 0; i < graph->portal_count; i++) guide.passable[i] = passable(graph, &graph->portals[i]);
    guide.room = ARENA_ARRAY(arena, int, room_count(graph));
    guide.looked = ARENA_ARRAY(arena, unsigned char, room_count(graph));
    guide.largest = ARENA_ARRAY(arena, int, room_count(graph));
    guide.from = ARENA_ARRAY(arena, int, cells);
    guide.cost = ARENA_ARRAY(arena, double, cells);
    guide.at = ARENA_ARRAY(arena, Vec3, cells);
    guide.heap = ARENA_ARRAY(arena, int, cells);
    guide.heap_slot = ARENA_ARRAY(arena, int, cells);
    int start = find_start(graph);
    out->reachable_count = reachable(graph, start, out->reachable);
    find_rooms(&guide);
    find_largest(&guide);
    bool inside = vis_locate(graph, graph->building->start, start) == start;
    guide.eye = inside ? graph->building->start : centre_of_cell(&guide, start);
    guide.yaw = inside ? wrap(graph->building->start_yaw) : 0;
    emit(&guide);
    enter(&guide, start);
    for (int target; (target = find_target(&guide)) >= 0;) {
        walk_to(&guide, target);
        enter(&guide, target);
    }
}

// Adds the frames between two stored viewpoints, the second included.
static void interpolate(const TourOptions *options, Arena *arena, const Viewpoint *a, const Viewpoint *b,
                        TourPath *out) {
    double turn = wrap(b->yaw - a->yaw);
    double steps = fmax(vec3_length(vec3_sub(b->eye, a->eye)) / options->step, fabs(turn) / options->turn);
    steps = ceil(fmax(steps, fabs(b->pitch - a->pitch) / options->turn) - 1e-9);
    // Coordinates are checked, so this many frames are a very long path, not a fault.
    int count = steps < 1e6 ? (int)steps : 1000000;
    for (int i = 1; i <= count; i++) {
        double t = (double)i / count;
        *ARENA_PUSH(arena, out->frames, out->frame_count, out->frame_capacity) =
            (TourFrame){vec3_lerp(a->eye, b->eye, t), wrap(a->yaw + turn * t),
                        a->pitch + (b->pitch - a->pitch) * t, a->fov + (b->fov - a->fov) * t};
    }
}

static void add_viewpoint(const TourOptions *options, Arena *arena, const Viewpoint *v, TourPath *out) {
    *ARENA_PUSH(arena, out->frames, out->frame_count, out->frame_capacity) =
        (TourFrame){v->eye, v->yaw, v->pitch, v->fov > 0 ? v->fov : options->fov};
}

static bool no_such_tour(const Building *b, const char *name, Error *error) {
    char names[512] = "auto";
    size_t used = strlen(names);
    for (int i = 0; i < b->tour_count + b->viewpoint_count; i++) {
        const char *next = i < b->tour_count ? b->tours[i].name : b->viewpoints[i - b->tour_count].name;
        if (used + strlen(next) + 8 > sizeof names) {
            memcpy(names + used, ", ...", 6);
            break;
        }
        used += (size_t)snprintf(names + used, sizeof names - used, ", %s", next);
    }
    return error_set(error, "%s: there is no tour or viewpoint `%s` (allowed: %s)",
                     b->source ? b->source : "building", name, names);
}

bool tour_make(const CellGraph *graph, const char *name, const TourOptions *options, Arena *arena,
               TourPath *out, Error *error) {
    const Building *b = graph->building;
    *out = (TourPath){0};
    out->reachable = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    out->visited = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    if (strcmp(name, "auto") == 0) {
        tour_auto(graph, options, arena, out);
        return true;
    }
    for (int i = 0; i < b->tour_count; i++) {
        if (strcmp(b->tours[i].name, name) != 0 || b->tours[i].viewpoint_count == 0) continue;
        const Viewpoint *v = b->tour_points + b->tours[i].first_viewpoint;
        add_viewpoint(options, arena, v, out);
        for (int k = 1; k < b->tours[i].viewpoint_count; k++)
            interpolate(options, arena, &v[k - 1], &v[k], out);
        return true;
    }
    for (int i = 0; i < b->viewpoint_count; i++) {
        if (strcmp(b->viewpoints[i].name, name) != 0) continue;
        add_viewpoint(options, arena, &b->viewpoints[i], out);
        return true;
    }
    return no_such_tour(b, name, error);
}
