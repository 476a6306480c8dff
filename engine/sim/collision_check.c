// collision_check.c - checks whether a body is at an allowed place and got there by an allowed way.
//
// Each polygon is clipped to the heights that matter and projected onto the plan; the remainder is tested for its distance from the
// axis, or for a crossing with the way of the axis.
#include "engine/sim/collision_check.h"

#include <string.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "engine/sim/body.h"
#include "engine/sim/door_part.h"

const char *const COLLISION_FAULT_NAMES[COLLISION_FAULTS] = {
    "none",           "outside the cells", "in something solid", "in a door", "through something solid",
    "through a door", "through a window"};

// Side of a square of the grid, metres; the squares of a large world are larger.
static const double SQUARE = 0.5;
enum { MOST_SQUARES = 512 };  // along a side

struct CollisionCheck {
    const CellGraph *graph;
    Vec2 origin;
    double size;
    int nx, ny;
    int *first, *polygons;  // of square s: polygons[first[s]] .. polygons[first[s + 1] - 1]
    Box *box;               // [polygon_count]
    unsigned char *solid;   // [polygon_count]
    unsigned *seen, serial;
    int *list;        // [polygon_count] the last answer of collision_check_near
    Vec3 *buffer[2];  // each with room for the largest polygon, clipped
    int *window_portals;
    int window_count;
};

// ---- making

static void mark_solid(CollisionCheck *check) {
    const CellGraph *graph = check->graph;
    for (int i = 0; i < graph->object_count; i++) {
        const Object *o = &graph->objects[i];
        bool frame = o->kind == OBJECT_FRAME && o->opening >= 0 &&
                     graph->building->openings[o->opening].kind == OPENING_DOOR;
        // A frame that bars its door by itself is the only thing that is drawn but is no obstacle.
        bool barring =
            frame && !door_lets_pass(graph, o->opening, true) && door_lets_pass(graph, o->opening, false);
        bool solid = !o->plug && o->leaf < 0 && !barring;
        memset(check->solid + o->first_polygon, solid, (size_t)o->polygon_count);
    }
}

static int column(const CollisionCheck *check, double x) {
    double i = floor((x - check->origin.x) / check->size);
    return i < 0 ? 0 : i >= check->nx ? check->nx - 1 : (int)i;
}

static int grid_row(const CollisionCheck *check, double y) {
    double j = floor((y - check->origin.y) / check->size);
    return j < 0 ? 0 : j >= check->ny ? check->ny - 1 : (int)j;
}

static void lay_grid(CollisionCheck *check, Arena *arena) {
    Box world = check->graph->box;
    double longest = fmax(world.max.x - world.min.x, world.max.y - world.min.y);
    check->origin = vec2(world.min.x, world.min.y);
    check->size = fmax(SQUARE, longest / MOST_SQUARES);
    check->nx = (int)ceil((world.max.x - world.min.x) / check->size) + 1;
    check->ny = (int)ceil((world.max.y - world.min.y) / check->size) + 1;
    int squares = check->nx * check->ny;
    int *count = ARENA_ARRAY(arena, int, squares + 1);
    check->first = ARENA_ARRAY(arena, int, squares + 1);
    for (int pass = 0; pass < 2; pass++) {
        for (int p = 0; p < check->graph->polygon_count; p++) {
            Box b = check->box[p];
            for (int j = grid_row(check, b.min.y); check->solid[p] && j <= grid_row(check, b.max.y); j++) {
                for (int i = column(check, b.min.x); i <= column(check, b.max.x); i++) {
                    int square = j * check->nx + i;
                    if (pass == 1) check->polygons[check->first[square] + count[square]] = p;
                    count[square]++;
                }
            }
        }
        if (pass == 1) break;
        for (int s = 0; s < squares; s++) check->first[s + 1] = check->first[s] + count[s];
        check->polygons = ARENA_ARRAY(arena, int, check->first[squares] + 1);
        memset(count, 0, (size_t)squares * sizeof *count);
    }
}

static void list_portals(CollisionCheck *check, Arena *arena) {
    const CellGraph *graph = check->graph;
    const Building *b = graph->building;
    check->window_portals = ARENA_ARRAY(arena, int, graph->portal_count + 1);
    for (int i = 0; i < graph->portal_count; i++) {
        int p = vis_region(graph, graph->portals[i].cell[0])->opening;
        int q = vis_region(graph, graph->portals[i].cell[1])->opening;
        bool window = (p >= 0 && b->openings[p].kind == OPENING_WINDOW) ||
                      (q >= 0 && b->openings[q].kind == OPENING_WINDOW);
        if (window) check->window_portals[check->window_count++] = i;
    }
}

CollisionCheck *collision_check_new(const CellGraph *graph, Arena *arena) {
    CollisionCheck *check = arena_alloc(arena, 1, sizeof *check);
    int largest = 4;
    check->graph = graph;
    check->box = ARENA_ARRAY(arena, Box, graph->polygon_count + 1);
    check->solid = ARENA_ARRAY(arena, unsigned char, graph->polygon_count + 1);
    check->seen = ARENA_ARRAY(arena, unsigned, graph->polygon_count + 1);
    check->list = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    for (int p = 0; p < graph->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        check->box[p] = box_empty();
        for (int k = 0; k < polygon->vertex_count; k++)
            check->box[p] = box_add(check->box[p], graph->vertices[polygon->first_vertex + k]);
        if (polygon->vertex_count > largest) largest = polygon->vertex_count;
    }
    for (int i = 0; i < 2; i++) check->buffer[i] = ARENA_ARRAY(arena, Vec3, largest + 4);
    mark_solid(check);
    lay_grid(check, arena);
    list_portals(check, arena);
    return check;
}

int collision_check_near(CollisionCheck *check, Box box, const int **polygons) {
    int count = 0;
    check->serial++;
    for (int j = grid_row(check, box.min.y); j <= grid_row(check, box.max.y); j++) {
        for (int i = column(check, box.min.x); i <= column(check, box.max.x); i++) {
            int square = j * check->nx + i;
            for (int k = check->first[square]; k < check->first[square + 1]; k++) {
                int p = check->polygons[k];
                if (check->seen[p] == check->serial || !box_overlap(check->box[p], box)) continue;
                check->seen[p] = check->serial;
                check->list[count++] = p;
            }
        }
    }
    *polygons = check->list;
    return count;
}

// ---- plans

// Clips a polygon to the heights z0 .. z1, into buffer[1] of the check. Returns the vertex count.
static int cut_to(CollisionCheck *check, const Vec3 *v, int count, double z0, double z1) {
    count = polygon_clip(v, count, (Plane){{0, 0, 1}, z0}, 0, check->buffer[0]);
    return polygon_clip(check->buffer[0], count, (Plane){{0, 0, -1}, -z1}, 0, check->buffer[1]);
}

static double to_edge(Vec2 p, Vec2 a, Vec2 b) {
    Vec2 along = vec2_sub(b, a);
    double length = vec2_length(along);
    if (length == 0) return vec2_length(vec2_sub(p, a));
    double t = fmax(0, fmin(length, vec2_dot(vec2_sub(p, a), along) / length));
    return vec2_length(vec2_sub(p, vec2_add(a, vec2_scale(along, t / length))));
}

// Is p inside the plan of a polygon? It is if a ray along +x crosses an odd number of edges.
static bool encloses(const Vec3 *v, int count, Vec2 p) {
    bool inside = false;
    for (int i = 0, k = count - 1; i < count; k = i++)
        inside ^= ring_edge_is_crossed(vec2(v[k].x, v[k].y), vec2(v[i].x, v[i].y), p, RING_DIVIDE_FIRST);
    return inside;
}

double collision_plan_distance(const Vec3 *v, int count, Vec2 p) {
    double nearest = INFINITY;
    for (int i = 0, k = count - 1; i < count; k = i++)
        nearest = fmin(nearest, to_edge(p, vec2(v[k].x, v[k].y), vec2(v[i].x, v[i].y)));
    return count > 0 && encloses(v, count, p) ? 0 : nearest;
}

// Does a way in plan cross the outline of a polygon, or begin or end inside it?
static bool plan_crossed(const Vec3 *v, int count, Vec2 from, Vec2 to) {
    if (count == 0) return false;
    for (int i = 0, k = count - 1; i < count; k = i++) {
        Vec2 a = vec2(v[k].x, v[k].y), b = vec2(v[i].x, v[i].y), way = vec2_sub(to, from),
             edge = vec2_sub(b, a);
        double p = vec2_cross(way, vec2_sub(a, from)), q = vec2_cross(way, vec2_sub(b, from));
        double r = vec2_cross(edge, vec2_sub(from, a)), s = vec2_cross(edge, vec2_sub(to, a));
        if (p * q < 0 && r * s < 0) return true;
    }
    return encloses(v, count, from) || encloses(v, count, to);
}

static int part_plan(const DoorPart *part, Vec3 *out) {
    for (int i = 0; i < part->count; i++) out[i] = vec3(part->plan[i].x, part->plan[i].y, 0);
    return part->count;
}

// ---- answers

static bool outside(const CellGraph *graph, Vec3 foot, double height) {
    Box world = graph->building->world;
    double keep = BODY_RADIUS - BODY_TOLERANCE;
    if (foot.x < world.min.x + keep || foot.x > world.max.x - keep) return true;
    if (foot.y < world.min.y + keep || foot.y > world.max.y - keep) return true;
    // The axis must be in free space from above the body's soles to below its crown.
    for (int i = 1; i <= 4; i++) {
        int cell = vis_locate(graph, vec3(foot.x, foot.y, foot.z + height * i / 5), -1);
        if (cell < 0) return true;
        int opening = vis_region(graph, cell)->opening;
        if (opening >= 0 && graph->building->openings[opening].kind == OPENING_WINDOW) return true;
    }
    return false;
}

// The door whose leaf, within [z0, z1], is too near to the place `from` or, if `way`, crosses the way to `to`; -1: none.
static int door_at_fault(const CollisionCheck *check, const float *door_open, Vec2 from, Vec2 to, double z0,
                         double z1, bool way) {
    const Building *b = check->graph->building;
    for (int i = 0; i < b->opening_count; i++) {
        for (int k = 0; k < door_part_count(b, i); k++) {
            DoorPart part;
            Vec3 plan[LEAF_CORNERS];
            if (!door_part(b, i, k, door_open ? (double)door_open[i] : 1, &part)) continue;
            if (part.heights.z0 >= z1 || part.heights.z1 <= z0) continue;
            int count = part_plan(&part, plan);
            if (way ? plan_crossed(plan, count, from, to)
                    : collision_plan_distance(plan, count, from) < BODY_RADIUS - BODY_TOLERANCE)
                return i;
        }
    }
    return -1;
}

static CollisionFault fault(CollisionFault kind, int what, int *out) {
    *out = what;
    return kind;
}

CollisionFault collision_check_place(CollisionCheck *check, const float *door_open, Vec3 foot, double height,
                                     int *what) {
    Vec2 at = vec2(foot.x, foot.y);
    double z0 = foot.z + BODY_TOLERANCE, z1 = foot.z + height - BODY_TOLERANCE;
    if (outside(check->graph, foot, height)) return fault(COLLISION_OUTSIDE, -1, what);
    Box box = {{at.x - BODY_RADIUS, at.y - BODY_RADIUS, z0}, {at.x + BODY_RADIUS, at.y + BODY_RADIUS, z1}};
    const int *near;
    int count = collision_check_near(check, box, &near);
    for (int i = 0; i < count; i++) {
        const Polygon *p = &check->graph->polygons[near[i]];
        int left = cut_to(check, check->graph->vertices + p->first_vertex, p->vertex_count, z0, z1);
        if (collision_plan_distance(check->buffer[1], left, at) < BODY_RADIUS - BODY_TOLERANCE)
            return fault(COLLISION_IN_SOLID, near[i], what);
    }
    int door = door_at_fault(check, door_open, at, at, z0, z1, false);
    return door >= 0 ? fault(COLLISION_IN_LEAF, door, what) : fault(COLLISION_NONE, -1, what);
}

// Checks a level way: between the highest step and the height of a ducking body, the axis must cross no polygon.
static CollisionFault check_level(CollisionCheck *check, const float *door_open, Vec3 from, Vec3 to,
                                  int *what) {
    const CellGraph *graph = check->graph;
    Vec2 a = vec2(from.x, from.y), b = vec2(to.x, to.y);
    double z0 = from.z + BODY_STEP + BODY_TOLERANCE, z1 = from.z + BODY_LOWEST - BODY_TOLERANCE;
    Box box = {{fmin(a.x, b.x), fmin(a.y, b.y), z0}, {fmax(a.x, b.x), fmax(a.y, b.y), z1}};
    const int *near;
    int count = collision_check_near(check, box, &near);
    for (int i = 0; i < count; i++) {
        const Polygon *p = &graph->polygons[near[i]];
        int left = cut_to(check, graph->vertices + p->first_vertex, p->vertex_count, z0, z1);
        if (plan_crossed(check->buffer[1], left, a, b)) return fault(COLLISION_THROUGH_SOLID, near[i], what);
    }
    for (int i = 0; i < check->window_count; i++) {
        const Portal *p = &graph->portals[check->window_portals[i]];
        int left = cut_to(check, graph->portal_vertices + p->first_vertex, p->vertex_count, z0, z1);
        if (plan_crossed(check->buffer[1], left, a, b)) return fault(COLLISION_THROUGH_WINDOW, -1, what);
    }
    int door = door_at_fault(check, door_open, a, b, z0, z1, true);
    return door >= 0 ? fault(COLLISION_THROUGH_LEAF, door, what) : fault(COLLISION_NONE, -1, what);
}

CollisionFault collision_check_way(CollisionCheck *check, const float *door_open, Vec3 from, Vec3 to,
                                   int *what) {
    if (from.x != to.x || from.y != to.y) {
        CORE_ASSERT(from.z == to.z);
        return check_level(check, door_open, from, to, what);
    }
    // The way is vertical: no polygon may lie between its ends.
    double low = fmin(from.z, to.z) + BODY_TOLERANCE, high = fmax(from.z, to.z) - BODY_TOLERANCE;
    if (low >= high) return fault(COLLISION_NONE, -1, what);
    const int *near;
    int count = collision_check_near(check, (Box){{from.x, from.y, low}, {from.x, from.y, high}}, &near);
    for (int i = 0; i < count; i++) {
        const Polygon *p = &check->graph->polygons[near[i]];
        int left = cut_to(check, check->graph->vertices + p->first_vertex, p->vertex_count, low, high);
        if (left > 0 && encloses(check->buffer[1], left, vec2(from.x, from.y)))
            return fault(COLLISION_THROUGH_SOLID, near[i], what);
    }
    return fault(COLLISION_NONE, -1, what);
}
