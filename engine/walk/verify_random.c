// verify_random.c - random views from places where visibility is most likely to go wrong. Eyes keep off solid surfaces: an eye in
// a wall's own plane would see into the wall, and no answer would be right.
#include <string.h>

#include "engine/sim/door_states.h"
#include "engine/walk/verify.h"

// How near the eyes come to corners, metres.
#define NEAR_LEAST 1e-4
#define NEAR_MOST 3e-3
// How often a cell or portal of the wanted kind is looked for.
#define TRIES 64

typedef bool (*Place)(const CellGraph *graph, Random *random, Vec3 *eye);

static const Region *region_of(const CellGraph *graph, int cell) { return vis_region(graph, cell); }

static Vec2 centre_of_box(const CellGraph *graph, const Cell *cell) {
    Vec2 sum = {0, 0};
    for (int i = 0; i < cell->edge_count; i++) sum = vec2_add(sum, graph->plan[cell->first_edge + i]);
    return vec2_scale(sum, 1.0 / cell->edge_count);
}

// A point of a cell: a convex mix of its plan's corners lies inside, off the boundary.
static Vec3 point_in(const CellGraph *graph, int index, Random *random) {
    const Cell *cell = &graph->cells[index];
    Vec2 sum = {0, 0};
    double weights = 0;
    for (int i = 0; i < cell->edge_count; i++) {
        double w = -log(1 - random_unit(random)) + 1e-3;
        sum = vec2_add(sum, vec2_scale(graph->plan[cell->first_edge + i], w));
        weights += w;
    }
    double inset = fmin(NEAR_LEAST, (cell->z1 - cell->z0) / 4);
    return vec3(sum.x / weights, sum.y / weights, random_between(random, cell->z0 + inset, cell->z1 - inset));
}

static bool in_kind(const CellGraph *graph, Random *random, RegionKind kind, Vec3 *eye) {
    for (int i = 0; i < TRIES; i++) {
        int cell = random_index(random, graph->cell_count);
        if (region_of(graph, cell)->kind != kind) continue;
        *eye = point_in(graph, cell, random);
        return true;
    }
    return false;
}

static bool anywhere(const CellGraph *graph, Random *random, Vec3 *eye) {
    *eye = point_in(graph, random_index(random, graph->cell_count), random);
    return true;
}

static bool room(const CellGraph *graph, Random *random, Vec3 *eye) {
    return in_kind(graph, random, REGION_ROOM, eye);
}

static bool doorway(const CellGraph *graph, Random *random, Vec3 *eye) {
    return in_kind(graph, random, REGION_OPENING, eye);
}

// A place outdoors, drawn towards the building, where its windows are.
static bool outdoors(const CellGraph *graph, Random *random, Vec3 *eye) {
    if (!in_kind(graph, random, REGION_OUTDOORS, eye)) return false;
    Vec3 start = graph->building->start, near = vec3_lerp(start, *eye, random_between(random, 0.2, 1));
    int cell = vis_locate(graph, near, -1);
    if (cell >= 0 && region_of(graph, cell)->kind == REGION_OUTDOORS) *eye = near;
    return true;
}

static bool corner(const CellGraph *graph, Random *random, Vec3 *eye) {
    const Cell *cell = &graph->cells[random_index(random, graph->cell_count)];
    Vec2 p = graph->plan[cell->first_edge + random_index(random, cell->edge_count)],
         c = centre_of_box(graph, cell);
    double away = random_between(random, NEAR_LEAST, NEAR_MOST), size = vec2_length(vec2_sub(c, p));
    if (size < 4 * away) return false;
    p = vec2_add(p, vec2_scale(vec2_sub(c, p), away / size));
    double up = fmin(random_between(random, NEAR_LEAST, NEAR_MOST), (cell->z1 - cell->z0) / 4);
    int where = random_index(random, 3);
    double z = where == 0   ? cell->z0 + up
               : where == 1 ? cell->z1 - up
                            : random_between(random, cell->z0 + up, cell->z1 - up);
    *eye = vec3(p.x, p.y, z);
    return true;
}

// Beside the surface of a cell.
static bool at_wall(const CellGraph *graph, Random *random, Vec3 *eye) {
    int cell = random_index(random, graph->cell_count), first = graph->surface_first[cell],
        count = graph->surface_first[cell + 1] - first;
    if (count == 0) return false;
    const Object *surface = &graph->objects[first + random_index(random, count)];
    const Polygon *polygon = &graph->polygons[surface->first_polygon];
    const Vec3 *v = graph->vertices + polygon->first_vertex;
    Vec3 sum = {0, 0, 0};
    double weights = 0;
    for (int i = 0; i < polygon->vertex_count; i++) {
        double w = -log(1 - random_unit(random)) + 1e-3;
        sum = vec3_add(sum, vec3_scale(v[i], w));
        weights += w;
    }
    double away = random_between(random, NEAR_LEAST, NEAR_MOST);
    *eye = vec3_add(vec3_scale(sum, 1 / weights),
                    vec3_scale(plane_of_polygon(v, polygon->vertex_count).n, away));
    return true;
}

static const Portal *random_portal(const CellGraph *graph, Random *random, Vec3 *eye) {
    if (graph->portal_count == 0) return NULL;
    const Portal *portal = &graph->portals[random_index(random, graph->portal_count)];
    Vec3 sum = {0, 0, 0};
    double weights = 0;
    for (int i = 0; i < portal->vertex_count; i++) {
        double w = -log(1 - random_unit(random)) + 1e-3;
        sum = vec3_add(sum, vec3_scale(graph->portal_vertices[portal->first_vertex + i], w));
        weights += w;
    }
    *eye = vec3_scale(sum, 1 / weights);
    return portal;
}

// An eye in the plane of a portal: exactly for portals across an axis, up to rounding for others.
static bool on_portal(const CellGraph *graph, Random *random, Vec3 *eye) {
    const Portal *portal = random_portal(graph, random, eye);
    if (!portal) return false;
    Vec3 n = portal->plane.n, v = graph->portal_vertices[portal->first_vertex];
    if (fabs(n.x) == 1) eye->x = v.x;
    if (fabs(n.y) == 1) eye->y = v.y;
    if (fabs(n.z) == 1) eye->z = v.z;
    return true;
}

static bool beside_portal(const CellGraph *graph, Random *random, Vec3 *eye) {
    const Portal *portal = random_portal(graph, random, eye);
    if (!portal) return false;
    // The distance is from a nanometre to a millimetre, evenly in the exponent.
    double off = pow(10, random_between(random, -9, -3)) * (random_index(random, 2) ? 1 : -1);
    *eye = vec3_add(*eye, vec3_scale(portal->plane.n, off));
    return true;
}

static bool portal_corner(const CellGraph *graph, Random *random, Vec3 *eye) {
    if (graph->portal_count == 0) return false;
    const Portal *portal = &graph->portals[random_index(random, graph->portal_count)];
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    Vec3 middle = {0, 0, 0}, at = v[random_index(random, portal->vertex_count)];
    for (int i = 0; i < portal->vertex_count; i++) {
        middle = vec3_add(middle, vec3_scale(vec3_sub(v[i], v[0]), 1.0 / portal->vertex_count));
    }
    Vec3 inward = vec3_sub(vec3_add(v[0], middle), at);
    double away = random_between(random, NEAR_LEAST, NEAR_MOST), size = vec3_length(inward);
    if (size < 4 * away) return false;
    *eye = vec3_add(at, vec3_scale(inward, away / size));
    return true;
}

static bool door_leaf(const CellGraph *graph, Random *random, Vec3 *eye) {
    for (int i = 0; i < TRIES; i++) {
        const Portal *portal = random_portal(graph, random, eye);
        if (portal && portal->door >= 0) return true;
    }
    return false;
}

static const struct {
    const char *name;
    Place place;
} KINDS[] = {{"anywhere", anywhere},
             {"room", room},
             {"doorway", doorway},
             {"corner", corner},
             {"wall", at_wall},
             {"portal", on_portal},
             {"beside portal", beside_portal},
             {"portal corner", portal_corner},
             {"door leaf", door_leaf},
             {"outdoors", outdoors}};
enum { KIND_COUNT = sizeof KINDS / sizeof *KINDS };

// Is the point within VERIFY_IN_SURFACE of a polygon of the object?
static bool touches(const CellGraph *graph, int object, Vec3 p) {
    if (!box_contains(box_grow(graph->object_boxes[object], VERIFY_IN_SURFACE), p)) return false;
    const Object *o = &graph->objects[object];
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *polygon = &graph->polygons[i];
        const Vec3 *v = graph->vertices + polygon->first_vertex;
        Box box = box_empty();
        for (int k = 0; k < polygon->vertex_count; k++) box = box_add(box, v[k]);
        if (box_contains(box_grow(box, VERIFY_IN_SURFACE), p) &&
            fabs(plane_distance(plane_of_polygon(v, polygon->vertex_count), p)) < VERIFY_IN_SURFACE)
            return true;
    }
    return false;
}

// Is the eye too near a wall of its cell, or of the next? Walls of a soup are among the objects of its cells.
static bool in_surface(const CellGraph *graph, int cell, Vec3 eye) {
    const Cell *own = &graph->cells[cell];
    for (int i = -1; i < own->way_count; i++) {
        int c = i < 0 ? cell : graph->ways[own->first_way + i].cell;
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++)
            if (touches(graph, o, eye)) return true;
    }
    if (own->face_count == 0) return false;
    const SquareGrid *grid = &graph->grids[cell];
    int end = graph->square_first[grid->first_square + grid->nx * grid->ny];
    for (int k = graph->square_first[grid->first_square]; k < end; k++)
        if (touches(graph, graph->square_objects[k], eye)) return true;
    return false;
}

bool walk_random_view(const CellGraph *graph, Random *random, int width, int height, RandomView *out) {
    int kind = random_index(random, KIND_COUNT), mood = random_index(random, 3);
    Vec3 eye = {0, 0, 0};
    out->kind = KINDS[kind].name;
    for (int i = 0; i < graph->building->opening_count; i++) {
        float share = walk_random_share(random);
        out->door_open[i] = mood == 0 ? 1 : mood == 1 ? 0 : share;
    }
    double yaw = random_between(random, -M_PI, M_PI);
    // One view in four looks along an axis, as walls do.
    if (random_index(random, 4) == 0) yaw = (random_index(random, 4) - 2) * (M_PI / 2);
    double pitch =
        random_index(random, 4) ? random_between(random, -0.5, 0.5) : random_between(random, -1.55, 1.55);
    double fov = random_between(random, 0.3, 2.2);
    if (!KINDS[kind].place(graph, random, &eye)) return false;
    out->camera = camera_look(eye, yaw, pitch, fov, width, height);
    out->cell = vis_locate(graph, eye, -1);
    return out->cell >= 0 && !in_surface(graph, out->cell, eye);
}
