// query.c - the visible set of an eye: the stab tree of its cell, walked while the view volume narrows at each
// portal (Teller & Sequin 1991, section 5; Luebke & Georges 1995 for the walk without trees), then the squares of
// each visible cell that the narrowed volume covers in plan (Oki 2.2), then the boxes of the objects there.
//
// The narrowed volume is a cone: planes through the eye. It is kept a little too large, so that nothing a rasteriser
// could show is lost: see ANGLE_SLACK and POSITION_SLACK.
#include <string.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/build.h"

enum { MAX_PLANES = 24, MAX_CORNERS = 2 * MAX_PLANES + 8 };

// Rasterisers snap to 1/256 of a pixel: 5e-5 covers views down to 100 pixels a radian.
static const double ANGLE_SLACK = 5e-5;
// They compute in floats: 2e-5 m is half a digit at 300 m from the middle of the building.
static const double POSITION_SLACK = 2e-5;
// An eye this near a portal's plane counts as on it: the whole volume passes if it is at the portal itself, and a thin
// wedge along the plane if the portal is seen edge-on from afar. Metres.
static const double ON_PLANE = 1e-3;
static const double AT_PORTAL = 1e-2;
// An eye this near a wall may be behind it in the floats of a rasteriser, or see through it where its near plane cuts
// it off, metres. A view whose near plane is farther than this must keep its eye that much off the walls.
static const double EYE_CLEARANCE = 1e-3;

const char *const VIS_METHOD_NAMES[VIS_METHODS] = {"none", "frustum", "portals", "plan", "stab"};

typedef struct Cone {
    Plane plane[MAX_PLANES];  // all through the eye, but for those of the caller's frustum
    int count;
    // In plan: directions from `from` counter-clockwise to `to`, less than a half turn; or all around.
    bool all_around;
    Vec2 from, to;
} Cone;

struct VisQuery {
    const CellGraph *graph;
    const StabForest *forest;
    Cone *cones;  // [depth_limit + 1] one for each level of the walk
    int depth_limit;
    unsigned char *on_path;   // [cell_count]
    int *cell_slot;           // [cell_count] place in `cells`, valid when cell_frame says so
    unsigned *cell_frame;     // [cell_count]
    VisibleCell *cells;       // [cell_count]
    uint64_t *drawn;          // bit per object
    unsigned *object_tested;  // [object_count] the last cone it was tested against
    int *objects;             // [object_count] the result
    unsigned frame, cone_serial;
    // Of the query under way:
    const Eye *eye;
    const float *door_open;
    VisMethod method;
    const uint64_t *limit;  // only cells of this visible set are entered, or NULL
    VisResult result;
};

static int forest_depth(const StabForest *forest, Arena *scratch) {
    int deepest = 1, *depth = ARENA_ARRAY(scratch, int, forest->node_count);
    for (int i = 0; i < forest->node_count; i++) {
        depth[i] = forest->nodes[i].parent < 0 ? 1 : depth[forest->nodes[i].parent] + 1;
        if (depth[i] > deepest) deepest = depth[i];
    }
    return deepest;
}

VisQuery *vis_query_new(const CellGraph *graph, const StabForest *forest, Arena *arena) {
    // A walk without trees goes at most this deep; beyond it the visible set is drawn.
    enum { WALK_DEPTH = 1024 };
    VisQuery *q = arena_alloc(arena, 1, sizeof *q);
    Arena scratch = {0};
    int deepest = forest_depth(forest, &scratch);
    arena_free(&scratch);
    q->graph = graph;
    q->forest = forest;
    q->depth_limit = graph->cell_count < WALK_DEPTH ? graph->cell_count : WALK_DEPTH;
    if (deepest > q->depth_limit) q->depth_limit = deepest;
    q->cones = ARENA_ARRAY(arena, Cone, q->depth_limit + 2);
    q->on_path = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    q->cell_slot = ARENA_ARRAY(arena, int, graph->cell_count);
    q->cell_frame = ARENA_ARRAY(arena, unsigned, graph->cell_count);
    q->cells = ARENA_ARRAY(arena, VisibleCell, graph->cell_count);
    q->drawn = ARENA_ARRAY(arena, uint64_t, graph->object_count / 64 + 1);
    q->object_tested = ARENA_ARRAY(arena, unsigned, graph->object_count + 1);
    q->objects = ARENA_ARRAY(arena, int, graph->object_count + 1);
    return q;
}

// ---- objects

bool vis_shown(const Object *object, const float *door_open) {
    return !object->plug || (door_open && door_open[object->opening] == 0);
}

// No corner of the box is in front of one of the planes: it cannot be seen.
static bool box_outside(Box box, const Plane *planes, int count) {
    Vec3 middle = vec3_scale(vec3_add(box.min, box.max), 0.5), half = vec3_sub(box.max, middle);
    for (int i = 0; i < count; i++) {
        Vec3 n = planes[i].n;
        double reach = fabs(n.x) * half.x + fabs(n.y) * half.y + fabs(n.z) * half.z;
        if (plane_distance(planes[i], middle) + reach < -POSITION_SLACK) return true;
    }
    return false;
}

static void draw_object(VisQuery *q, int object) { q->drawn[object / 64] |= (uint64_t)1 << (object % 64); }

static void draw_square(VisQuery *q, int square, const Cone *cone) {
    const CellGraph *graph = q->graph;
    for (int k = graph->square_first[square]; k < graph->square_first[square + 1]; k++) {
        int object = graph->square_objects[k];
        if (q->object_tested[object] == q->cone_serial) continue;
        q->object_tested[object] = q->cone_serial;
        if (q->drawn[object / 64] >> (object % 64) & 1) continue;
        q->result.objects_tested++;
        if (!box_outside(graph->object_boxes[object], cone->plane, cone->count)) draw_object(q, object);
    }
}

// ---- squares

// The half of the plan to the left of the line from the eye along `direction`.
static Plane left_of(Vec2 eye, Vec2 direction) {
    Vec3 n = vec3_normalize(vec3(-direction.y, direction.x, 0));
    return (Plane){n, n.x * eye.x + n.y * eye.y};
}

// The part of the cell's plan inside the cone's plan wedge, at height 0.
static int wedge_in_cell(const VisQuery *q, const Cell *cell, const Cone *cone, Vec3 *out) {
    Vec2 eye = {q->eye->position.x, q->eye->position.y};
    int count = cell_polygon(q->graph, cell, 0, out);
    if (cone->all_around) return count;
    Vec3 part[BUILD_MAX_VERTICES];
    count = polygon_clip(out, count, left_of(eye, cone->from), VIS_TOUCH, part);
    return polygon_clip(part, count, left_of(eye, vec2_scale(cone->to, -1)), VIS_TOUCH, out);
}

static int square_at(double x, int count) { return x < 0 ? 0 : x >= count ? count - 1 : (int)x; }

// The columns that the plan polygon reaches in the row between y0 and y1: from its corners there and from where its
// edges cross the row's borders.
static bool row_extent(const Vec3 *region, int count, double y0, double y1, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 a = region[i], b = region[i + 1 == count ? 0 : i + 1];
        if (a.y >= y0 && a.y <= y1) {
            *low = fmin(*low, a.x);
            *high = fmax(*high, a.x);
        }
        for (int k = 0; k < 2; k++) {
            double y = k ? y1 : y0;
            if ((a.y < y) == (b.y < y)) continue;
            double x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            *low = fmin(*low, x);
            *high = fmax(*high, x);
        }
    }
    return *low <= *high;
}

static void draw_cell(VisQuery *q, int c, const Cone *cone) {
    const CellMesh *mesh = &q->graph->meshes[c];
    const Cell *cell = &q->graph->cells[c];
    q->cone_serial++;
    Vec3 region[BUILD_MAX_VERTICES];
    int count = wedge_in_cell(q, cell, cone, region);
    if (count == 0) return;
    double bottom = INFINITY, top = -INFINITY;
    for (int i = 0; i < count; i++) {
        bottom = fmin(bottom, region[i].y);
        top = fmax(top, region[i].y);
    }
    int from = square_at((bottom - VIS_TOUCH - mesh->origin.y) / mesh->size, mesh->ny);
    int to = square_at((top + VIS_TOUCH - mesh->origin.y) / mesh->size, mesh->ny);
    for (int j = from; j <= to; j++) {
        double y0 = mesh->origin.y + j * mesh->size, low, high;
        // The last row also holds what lies beyond the mesh by rounding.
        double y1 = j == to ? top + VIS_TOUCH : y0 + mesh->size;
        if (!row_extent(region, count, (j == from ? bottom : y0) - VIS_TOUCH, y1 + VIS_TOUCH, &low, &high))
            continue;
        int first = square_at((low - VIS_TOUCH - mesh->origin.x) / mesh->size, mesh->nx);
        int last = square_at((high + VIS_TOUCH - mesh->origin.x) / mesh->size, mesh->nx);
        int row = mesh->first_square + j * mesh->nx;
        for (int i = first; i <= last; i++) draw_square(q, row + i, cone);
    }
}

// ---- cones

static void add_plane(Cone *cone, Vec3 n, double d) {
    if (cone->count < MAX_PLANES) cone->plane[cone->count++] = (Plane){n, d};
    // One plane less is a larger cone: nothing is lost.
}

// The two upright planes of the plan wedge.
static void add_wedge_planes(Cone *cone, Vec2 eye) {
    Plane from = left_of(eye, cone->from), to = left_of(eye, vec2_scale(cone->to, -1));
    add_plane(cone, from.n, from.d);
    add_plane(cone, to.n, to.d);
}

// Widens the wedge by the slack that the three-dimensional planes have too.
static void tilt_wedge(Cone *cone, double slack) {
    Vec2 from = cone->from, to = cone->to;
    double a = 1 / vec2_length(from), b = 1 / vec2_length(to);
    cone->from = vec2_add(vec2_scale(from, a), vec2_scale(vec2(from.y, -from.x), a * slack));
    cone->to = vec2_add(vec2_scale(to, b), vec2_scale(vec2(-to.y, to.x), b * slack));
    if (vec2_cross(cone->from, cone->to) <= 0) cone->all_around = true;
}

// The wedge of plan directions from the eye to the polygon's corners; all around when they span a half turn.
static void set_wedge(Cone *cone, Vec2 eye, const Vec3 *polygon, int count) {
    cone->all_around = false;
    double nearest = INFINITY;
    for (int i = 0; i < count; i++) {
        Vec2 d = {polygon[i].x - eye.x, polygon[i].y - eye.y};
        nearest = fmin(nearest, vec2_length(d));
        if (i == 0) {
            cone->from = cone->to = d;
            continue;
        }
        if (vec2_cross(cone->from, d) < 0) cone->from = d;
        if (vec2_cross(cone->to, d) > 0) cone->to = d;
    }
    // The corners' directions lie between the extremes found only if none is behind them.
    bool good = nearest > AT_PORTAL &&
                (vec2_cross(cone->from, cone->to) > 0 ||
                 (vec2_cross(cone->from, cone->to) == 0 && vec2_dot(cone->from, cone->to) > 0));
    for (int i = 0; i < count && good; i++) {
        Vec2 d = {polygon[i].x - eye.x, polygon[i].y - eye.y};
        good = vec2_cross(cone->from, d) >= 0 && vec2_cross(d, cone->to) >= 0 &&
               vec2_dot(d, vec2_add(vec2_scale(cone->from, 1 / vec2_length(cone->from)),
                                    vec2_scale(cone->to, 1 / vec2_length(cone->to)))) > 0;
    }
    cone->all_around = !good;
    if (good) tilt_wedge(cone, ANGLE_SLACK + POSITION_SLACK / nearest);
}

// Planes through the eye and the polygon's edges, tilted outwards by the slack; `inside` is a direction into the
// polygon.
static void set_planes(Cone *cone, Vec3 eye, const Vec3 *polygon, int count, Vec3 inside) {
    cone->count = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = vec3_sub(polygon[i], eye), b = vec3_sub(polygon[i + 1 == count ? 0 : i + 1], eye);
        Vec3 n = vec3_cross(a, b), edge = vec3_sub(b, a);
        double area = vec3_length(n), length = vec3_length(edge);
        // The eye is in line with this edge, or the edge is a point: its plane is noise, the others do without it.
        if (area <= 1e-9 * length || length < 1e-12) continue;
        n = vec3_scale(n, 1 / area);
        if (vec3_dot(n, inside) < 0) n = vec3_scale(n, -1);
        double distance = area / length;  // from the eye to the edge's line
        n = vec3_normalize(vec3_add(n, vec3_scale(inside, ANGLE_SLACK + POSITION_SLACK / distance)));
        add_plane(cone, n, vec3_dot(n, eye));
    }
}

// Far-off portals of whose plane the eye is part: what goes through lies in a thin wedge along the plane.
static void set_edge_on(Cone *cone, const Cone *parent, Vec3 eye, Plane plane, const Vec3 *polygon,
                        int count) {
    *cone = *parent;
    double nearest = INFINITY;
    Vec3 middle = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        nearest = fmin(nearest, vec3_length(vec3_sub(polygon[i], eye)));
        middle = vec3_add(middle, vec3_scale(vec3_sub(polygon[i], eye), 1.0 / count));
    }
    if (nearest < AT_PORTAL) return;
    Vec3 ahead = vec3_normalize(middle);
    double tilt = 2 * ON_PLANE / nearest + ANGLE_SLACK;
    for (int side = -1; side <= 1; side += 2) {
        Vec3 n = vec3_normalize(vec3_add(vec3_scale(plane.n, side), vec3_scale(ahead, tilt)));
        add_plane(cone, n, vec3_dot(n, eye));
    }
}

// Could the eye, a hair's breadth from the portal's plane, be in the portal?
static bool eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye) {
    Box box = box_empty();
    for (int i = 0; i < portal->vertex_count; i++) {
        box = box_add(box, graph->portal_vertices[portal->first_vertex + i]);
    }
    return box_contains(box_grow(box, AT_PORTAL), eye);
}

// A closed door ends the view, unless the eye is in the leaf itself: then it sees both sides.
static bool door_closed(const VisQuery *q, const Portal *portal) {
    if (portal->door < 0 || !q->door_open || q->door_open[portal->door] > 0) return false;
    Vec3 eye = q->eye->position;
    return fabs(plane_distance(portal->plane, eye)) >= ON_PLANE || !eye_at_portal(q->graph, portal, eye);
}

// The cone beyond `portal`, crossed from `cell`. Returns false when nothing of it is seen.
static bool narrow(VisQuery *q, const Cone *cone, int portal_index, int cell, Cone *out, double *distance) {
    const CellGraph *graph = q->graph;
    const Portal *portal = &graph->portals[portal_index];
    Vec3 eye = q->eye->position;
    q->result.portals_tested++;
    double side = plane_distance(portal->plane, eye);
    if (portal->cell[0] != cell) side = -side;
    if (side < -ON_PLANE) return false;  // one would come back through it
    if (side < ON_PLANE && eye_at_portal(graph, portal, eye)) {
        *out = *cone;
        *distance = 0;
        return true;
    }
    Vec3 buffer[2][MAX_CORNERS];
    const Vec3 *polygon = graph->portal_vertices + portal->first_vertex;
    int count = portal->vertex_count, turn = 0;
    if (count > MAX_CORNERS / 2) {
        *out = *cone;
        *distance = 0;
        return true;
    }
    bool horizontal_only = q->method == VIS_PLAN;
    if (!(horizontal_only && portal->horizontal)) {
        for (int i = 0; i < cone->count && count > 0; i++) {
            count = polygon_clip(polygon, count, cone->plane[i], POSITION_SLACK, buffer[turn]);
            polygon = buffer[turn];
            turn = 1 - turn;
        }
    }
    if (count == 0) return false;
    *distance = INFINITY;
    Vec3 middle = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        Vec3 d = vec3_sub(polygon[i], eye);
        *distance = fmin(*distance, vec3_length(d));
        middle = vec3_add(middle, vec3_scale(d, 1.0 / count));
    }
    if (horizontal_only && portal->horizontal) {
        *out = *cone;
        return true;
    }
    if (side < ON_PLANE) {
        set_edge_on(out, cone, eye, portal->plane, polygon, count);
        return true;
    }
    set_wedge(out, vec2(eye.x, eye.y), polygon, count);
    if (horizontal_only) {
        out->count = 0;
        if (out->all_around) return true;
        add_wedge_planes(out, vec2(eye.x, eye.y));
        return true;
    }
    set_planes(out, eye, polygon, count, vec3_normalize(middle));
    return true;
}

// ---- the walk

static void visit_cell(VisQuery *q, int cell, double distance, const Cone *cone) {
    if (q->cell_frame[cell] != q->frame) {
        q->cell_frame[cell] = q->frame;
        q->cell_slot[cell] = q->result.cell_count;
        q->cells[q->result.cell_count++] = (VisibleCell){cell, distance};
    } else if (distance < q->cells[q->cell_slot[cell]].distance) {
        q->cells[q->cell_slot[cell]].distance = distance;
    }
    draw_cell(q, cell, cone);
}

// Of what lies behind a closed leaf the far half of its doorway is drawn, the jambs that share the leaf's edges: to a
// rasteriser these are as near as the leaf. `cell` is part of that half; cells of a region are neighbours in the list.
static void draw_half(VisQuery *q, int cell, const Cone *cone) {
    const Cell *cells = q->graph->cells;
    int first = cell;
    while (first > 0 && cells[first - 1].region == cells[cell].region) first--;
    for (int c = first; c < q->graph->cell_count && cells[c].region == cells[cell].region; c++)
        draw_cell(q, c, cone);
}

// Goes from `cell` through a portal to `to`, narrowing the cone of this depth to that of the next. Returns whether the
// way leads on from there.
static bool enter(VisQuery *q, int cell, int portal, int to, int depth) {
    double distance;
    Cone *beyond = &q->cones[depth + 1];
    if (!narrow(q, &q->cones[depth], portal, cell, beyond, &distance)) return false;
    bool closed = door_closed(q, &q->graph->portals[portal]);
    if (closed) {
        draw_half(q, to, beyond);
    } else {
        visit_cell(q, to, distance, beyond);
    }
    return !closed;
}

static void walk_tree(VisQuery *q, int node, int depth) {
    const StabNode *nodes = q->forest->nodes;
    int first = node + 1, end = q->forest->node_count;
    for (int child = first < end && nodes[first].parent == node ? first : -1; child >= 0;
         child = nodes[child].next) {
        if (enter(q, nodes[node].cell, nodes[child].portal, nodes[child].cell, depth))
            walk_tree(q, child, depth + 1);
    }
}

static void walk_portals(VisQuery *q, int c, int depth) {
    const Cell *cell = &q->graph->cells[c];
    if (depth >= q->depth_limit) {
        q->result.overflow = true;
        return;
    }
    q->on_path[c] = 1;
    for (int i = cell->first_contact; i < cell->first_contact + cell->contact_count; i++) {
        Contact contact = q->graph->contacts[i];
        bool hidden = q->limit && !(q->limit[contact.cell / 64] >> (contact.cell % 64) & 1);
        if (q->on_path[contact.cell] || hidden) continue;
        if (enter(q, c, contact.portal, contact.cell, depth)) walk_portals(q, contact.cell, depth + 1);
    }
    q->on_path[c] = 0;
}

// The rays of the view volume's edges: where two planes meet, if no other plane is in front of it.
static int corner_rays(const Eye *eye, Vec3 *out, int max) {
    int count = 0;
    for (int i = 0; i < eye->frustum_count; i++) {
        for (int j = i + 1; j < eye->frustum_count; j++) {
            Vec3 d = vec3_cross(eye->frustum[i].n, eye->frustum[j].n);
            if (vec3_length(d) < 1e-9) continue;
            d = vec3_normalize(d);
            for (int sign = -1; sign <= 1; sign += 2) {
                Vec3 ray = vec3_scale(d, sign);
                bool inside = true;
                for (int k = 0; k < eye->frustum_count && inside; k++) {
                    inside = k == i || k == j || vec3_dot(eye->frustum[k].n, ray) >= -1e-9;
                }
                if (inside && count < max) out[count++] = ray;
            }
        }
    }
    return count;
}

// Oki 3.1: the view volume's horizontal angle, and all around when it is a half turn or more.
static void frustum_wedge(Cone *cone, const Eye *eye) {
    Vec3 rays[16];
    int count = corner_rays(eye, rays, 16);
    cone->all_around = true;
    bool up = true, down = true;
    for (int k = 0; k < eye->frustum_count; k++) {
        up = up && eye->frustum[k].n.z >= 0;
        down = down && eye->frustum[k].n.z <= 0;
    }
    if (count < 3 || up || down) return;
    for (int i = 0; i < count; i++) rays[i] = vec3_add(eye->position, rays[i]);
    set_wedge(cone, vec2(eye->position.x, eye->position.y), rays, count);
}

static void first_cone(VisQuery *q, Cone *cone) {
    const Eye *eye = q->eye;
    cone->count = 0;
    cone->all_around = true;
    if (q->method != VIS_PLAN) {
        for (int i = 0; i < eye->frustum_count; i++) add_plane(cone, eye->frustum[i].n, eye->frustum[i].d);
    }
    if (eye->frustum_count < 3) return;
    frustum_wedge(cone, eye);
    if (q->method == VIS_PLAN && !cone->all_around)
        add_wedge_planes(cone, vec2(eye->position.x, eye->position.y));
}

// ---- where the eye is

static bool in_portal(const CellGraph *graph, const Portal *portal, Vec3 eye) {
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    if (fabs(plane_distance(portal->plane, eye)) > EYE_CLEARANCE) return false;
    for (int i = 0; i < portal->vertex_count; i++) {
        Vec3 a = v[i], edge = vec3_normalize(vec3_sub(v[(i + 1) % portal->vertex_count], a));
        Vec3 inward = vec3_cross(portal->plane.n, edge);
        if (vec3_dot(inward, vec3_sub(eye, a)) < EYE_CLEARANCE) return false;
    }
    return true;
}

// Is the eye farther than EYE_CLEARANCE from every surface of the cell? Where it is nearer to a face it must be in a
// portal of that face, and the same must hold of the cell beyond, which may be a sliver; `depth` 0 is the eye's cell.
static bool clear_of_face(const CellGraph *graph, int c, Vec3 n, double d, Vec3 eye, int depth);

static bool clear_of_cell(const CellGraph *graph, int c, Vec3 eye, int depth) {
    const Cell *cell = &graph->cells[c];
    const Vec2 *plan = graph->plan + cell->first_edge;
    if (!clear_of_face(graph, c, vec3(0, 0, 1), cell->z0, eye, depth)) return false;
    if (!clear_of_face(graph, c, vec3(0, 0, -1), -cell->z1, eye, depth)) return false;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = plan[i], edge = vec2_sub(plan[i + 1 == cell->edge_count ? 0 : i + 1], a);
        double length = vec2_length(edge);
        Vec3 n = {-edge.y / length, edge.x / length, 0};
        if (!clear_of_face(graph, c, n, n.x * a.x + n.y * a.y, eye, depth)) return false;
    }
    return true;
}

static bool clear_of_face(const CellGraph *graph, int c, Vec3 n, double d, Vec3 eye, int depth) {
    static const double SAME = 1e-9;
    const Cell *cell = &graph->cells[c];
    if (fabs(vec3_dot(n, eye) - d) >= EYE_CLEARANCE) return true;
    for (int i = cell->first_contact; i < cell->first_contact + cell->contact_count; i++) {
        const Contact *contact = &graph->contacts[i];
        const Portal *portal = &graph->portals[contact->portal];
        double turn = vec3_dot(portal->plane.n, n);
        bool on_face = fabs(turn) > 1 - SAME && fabs(portal->plane.d * turn - d) < SAME * (1 + fabs(d));
        if (!on_face || !in_portal(graph, portal, eye)) continue;
        return depth > 0 || clear_of_cell(graph, contact->cell, eye, depth + 1);
    }
    return false;
}

// ---- results

static void draw_all(VisQuery *q, bool by_frustum) {
    for (int i = 0; i < q->graph->object_count; i++) {
        if (by_frustum) {
            q->result.objects_tested++;
            if (box_outside(q->graph->object_boxes[i], q->eye->frustum, q->eye->frustum_count)) continue;
        }
        draw_object(q, i);
    }
}

// Every object of every cell in the eye's visible set.
static void draw_visible_set(VisQuery *q, int cell) {
    Cone everything = {.all_around = true};
    for (int c = 0; c < q->graph->cell_count; c++) {
        if (vis_sees(q->forest, cell, c)) visit_cell(q, c, 0, &everything);
    }
}

static void collect_objects(VisQuery *q) {
    const CellGraph *graph = q->graph;
    VisResult *result = &q->result;
    for (int word = 0; word <= graph->object_count / 64; word++) {
        for (uint64_t bits = q->drawn[word]; bits; bits &= bits - 1) {
            int object = word * 64 + __builtin_ctzll(bits);
            if (!vis_shown(&graph->objects[object], q->door_open)) continue;
            q->objects[result->object_count++] = object;
            result->polygon_count += graph->objects[object].polygon_count;
        }
        q->drawn[word] = 0;
    }
}

// Insertion sort: the walk finds cells nearly in order, and qsort may allocate.
static void sort_cells(VisQuery *q) {
    for (int i = 1; i < q->result.cell_count; i++) {
        VisibleCell cell = q->cells[i];
        int j = i;
        for (; j > 0 && (q->cells[j - 1].distance > cell.distance ||
                         (q->cells[j - 1].distance == cell.distance && q->cells[j - 1].cell > cell.cell));
             j--) {
            q->cells[j] = q->cells[j - 1];
        }
        q->cells[j] = cell;
    }
}

static void walk(VisQuery *q, int cell) {
    first_cone(q, &q->cones[0]);
    visit_cell(q, cell, 0, &q->cones[0]);
    bool trees = q->method != VIS_PORTALS;
    q->limit = trees ? q->forest->seen + (size_t)cell * (size_t)q->forest->words : NULL;
    if (trees && !q->forest->bounded[cell]) {
        walk_tree(q, q->forest->root[cell], 0);
    } else {
        walk_portals(q, cell, 0);
    }
    if (q->result.overflow) draw_visible_set(q, cell);
}

VisResult vis_query(VisQuery *q, const Eye *eye, int cell, const float *door_open, VisMethod method) {
    CORE_ASSERT(cell < q->graph->cell_count && method < VIS_METHODS);
    q->eye = eye;
    q->door_open = door_open;
    q->method = method;
    q->result = (VisResult){.cells = q->cells, .objects = q->objects, .eye_cell = cell};
    q->frame++;
    // Before the counters come round, forget the marks of long ago.
    if (q->frame > UINT32_MAX / 2 || q->cone_serial > UINT32_MAX / 2) {
        memset(q->cell_frame, 0, (size_t)q->graph->cell_count * sizeof *q->cell_frame);
        memset(q->object_tested, 0, (size_t)q->graph->object_count * sizeof *q->object_tested);
        q->frame = 1;
        q->cone_serial = 0;
    }
    if (cell >= 0 && !clear_of_cell(q->graph, cell, eye->position, 0)) q->result.eye_cell = cell = -1;
    if (method == VIS_NONE || method == VIS_FRUSTUM || cell < 0) {
        draw_all(q, method == VIS_FRUSTUM);
    } else {
        walk(q, cell);
    }
    collect_objects(q);
    sort_cells(q);
    return q->result;
}
