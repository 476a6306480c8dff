// sun_nodes.c - the sun as a regular polygon infinitely far away, about which all points have the same directions. Of the cone from a point
// over this polygon the faces that may stand before the sun are cut away (analytic.h), so that penumbrae are exact.
//
// All places are in the sun's axes: x and y across its beams, z towards its middle. A face can hide the sun from a patch only where it
// meets the prism over the patch along the beams, widened by the sun's radius with the distance: such a prism is a shaft with one end
// infinitely far away (Haines & Wallace, Shaft Culling for Efficient Ray-Traced Radiosity, 1991).
#include "radiosity/show/sun_nodes.h"

#include "engine/core/box_tree.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/analytic.h"
#include "radiosity/factors/view.h"
#include "radiosity/shoot/sunlight.h"
#include "radiosity/show/shaft.h"

// Corners of the polygon. Its area is that of the disc; its corners lie 0.6 % outside the disc.
enum { CORNERS = 24 };
// The distance at which the polygon is cut, metres: beyond all faces.
static const double FAR = 1e6;
// Faces that are remembered because they hid the sun from a whole patch.
enum { CLOSERS = 8 };

// A face in the sun's axes.
typedef struct SunFace {
    int first, count;  // in SunNodes.corner
    Plane plane;
    double turn;  // 1 or -1: corners run counter-clockwise or clockwise as the sun sees them; 0: edge on
    double highest;
} SunFace;

struct SunNodes {
    const Mesh *mesh;
    Vec3 x, y, sun;
    double beam[3];
    double wide;  // tangent of the angle from the sun's middle to a corner of the polygon
    double sine;  // its sine
    Vec3 disc[CORNERS];
    double area;    // of the polygon
    SunFace *face;  // [mesh->face_count]
    Vec3 *corner;   // [mesh->outline_count]
    BoxTree tree;   // of faces
    double top;     // of all faces
    bool *reached;  // [cell_count] the sun shines into the cell
};

struct SunPatch {
    const SunNodes *sun;
    Arena *arena;
    BoxHits hits;
    int state, face;
    Vec3 normal;             // of the patch
    Vec3 disc[CORNERS + 1];  // the part of the polygon above the patch's plane
    int disc_count;
    int *blocker;  // faces that may hide some of the sun
    int blocker_count, blocker_capacity;
    int closer[CLOSERS];  // faces that hid the sun from patches lately, the last one first
    int closer_count;
    Vec3 *moved;  // corners about a point
    Plane *edge;
    AnalyticOccluder *occluder;
    int moved_capacity, edge_capacity, occluder_capacity;
};

static Vec3 to_sun(const SunNodes *s, Vec3 v) {
    return vec3(vec3_dot(s->x, v), vec3_dot(s->y, v), vec3_dot(s->sun, v));
}

static Vec3 from_sun(const SunNodes *s, Vec3 v) {
    return vec3_add(vec3_scale(s->x, v.x), vec3_add(vec3_scale(s->y, v.y), vec3_scale(s->sun, v.z)));
}

// ---- made once

static void project_faces(SunNodes *s, Arena *arena) {
    const Mesh *mesh = s->mesh;
    Box *boxes = ARENA_ARRAY(arena, Box, mesh->face_count + 1);
    s->face = ARENA_ARRAY(arena, SunFace, mesh->face_count + 1);
    s->corner = ARENA_ARRAY(arena, Vec3, mesh->outline_count + 1);
    s->top = -INFINITY;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        SunFace *out = &s->face[f];
        Vec3 n = to_sun(s, face->plane.n);
        boxes[f] = box_empty();
        for (int i = face->first_vertex; i < face->first_vertex + face->vertex_count; i++)
            boxes[f] = box_add(boxes[f], s->corner[i] = to_sun(s, mesh->vertices[mesh->outline[i]]));
        *out = (SunFace){face->first_vertex, face->vertex_count, {n, face->plane.d}, 0, boxes[f].max.z};
        if (face->hidden) boxes[f] = box_empty();
        if (fabs(n.z) > s->sine) out->turn = n.z > 0 ? 1 : -1;
        s->top = fmax(s->top, out->highest);
    }
    s->tree = box_tree_build(boxes, mesh->face_count, arena);
}

SunNodes *sun_nodes_new(const Mesh *mesh, const Daylight *day, Arena *arena) {
    if (!day || rgb_sum(day->beam) == 0) return NULL;
    SunNodes *s = ARENA_ARRAY(arena, SunNodes, 1);
    double step = 2 * M_PI / CORNERS, radius = tan(DAYLIGHT_SUN_RADIUS);
    s->mesh = mesh;
    s->sun = day->sun;
    view_axes(day->sun, &s->x, &s->y);
    memcpy(s->beam, day->beam, sizeof s->beam);
    s->wide = radius * sqrt(step / sin(step));
    s->sine = sin(atan(s->wide));
    for (int i = 0; i < CORNERS; i++)
        s->disc[i] = vec3(FAR * s->wide * cos(i * step), FAR * s->wide * sin(i * step), FAR);
    s->area = M_PI * radius * radius * FAR * FAR;
    project_faces(s, arena);
    s->reached = sunlight_cells(mesh, day->sun, atan(s->wide), arena);
    return s;
}

SunPatch *sun_patch_new(const SunNodes *sun, Arena *arena) {
    SunPatch *at = ARENA_ARRAY(arena, SunPatch, 1);
    at->sun = sun;
    at->arena = arena;
    return at;
}

// ---- points

// The part of the sun that a face hides from a point.
enum { HIDES_NONE, HIDES_SOME, HIDES_ALL };

// A quick test by a circle, of which `sine` is the sine of its radius.
static int hidden_part(const SunNodes *s, const SunFace *face, double sine, Vec3 point) {
    double height = plane_distance(face->plane, point), sign = height > 0 ? -1 : 1;
    if (fabs(height) <= SHAFT_TOUCH) return HIDES_NONE;  // seen edge-on
    double slope = sign * face->plane.n.z;
    if (slope <= -sine) return HIDES_NONE;
    bool all = slope >= sine;
    const Vec3 *corner = s->corner + face->first;
    Vec3 last = vec3_sub(corner[face->count - 1], point);
    for (int i = 0; i < face->count; i++) {
        Vec3 next = vec3_sub(corner[i], point), edge = vec3_cross(last, next);
        double least = sine * sine * vec3_dot(edge, edge), inside = sign * edge.z;
        last = next;
        bool beside = edge.z * edge.z >= least;
        if (beside && inside < 0) return HIDES_NONE;
        all = all && (beside || least == 0);
    }
    return all ? HIDES_ALL : HIDES_SOME;
}

// The cones of the faces that hide some of the sun from the point: returns how many, or -1 where one of them hides all of it. That one is
// then the first to be asked for the next point.
static int find_occluders(SunPatch *at, Vec3 point) {
    const SunNodes *s = at->sun;
    int occluders = 0, edges = 0;
    for (int i = 0; i < at->blocker_count; i++) {
        int f = at->blocker[i];
        const SunFace *face = &s->face[f];
        int part = hidden_part(s, face, s->sine, point);
        if (part == HIDES_ALL) {
            memmove(at->blocker + 1, at->blocker, (size_t)i * sizeof *at->blocker);
            at->blocker[0] = f;
            return -1;
        }
        if (part == HIDES_NONE) continue;
        at->moved = arena_room(at->arena, at->moved, sizeof *at->moved, 0, face->count, &at->moved_capacity);
        at->occluder = arena_room(at->arena, at->occluder, sizeof *at->occluder, occluders, occluders + 1,
                                  &at->occluder_capacity);
        // Planes of the occluders so far are pointed to: the array moves only between points.
        if (edges + face->count > at->edge_capacity) {
            Plane *old = at->edge;
            at->edge = arena_room(at->arena, at->edge, sizeof *at->edge, edges, edges + face->count,
                                  &at->edge_capacity);
            for (int k = 0; k < occluders; k++)
                at->occluder[k].edge = at->edge + (at->occluder[k].edge - old);
        }
        for (int k = 0; k < face->count; k++) at->moved[k] = vec3_sub(s->corner[face->first + k], point);
        AnalyticOccluder *o = &at->occluder[occluders];
        if (!analytic_occluder(at->moved, face->count, 0, at->edge + edges, o)) continue;
        edges += o->edge_count;
        occluders++;
    }
    return occluders;
}

// The part of the sun's polygon that is in sight, and its moment.
typedef struct Sight {
    Vec3 normal, moment;
    double sum;
} Sight;

// Adds the integral of the cosine over the part, which is linear across the plane of the polygon but for 4e-5 of it.
static void add_part(void *context, const Vec3 *polygon, int count) {
    Sight *sight = context;
    for (int i = 1; i + 1 < count; i++) {
        Vec3 a = polygon[0], b = polygon[i], c = polygon[i + 1];
        double area = fabs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2;
        Vec3 middle = vec3_scale(vec3_add(a, vec3_add(b, c)), 1.0 / 3);
        sight->sum += area * vec3_dot(sight->normal, middle);
        sight->moment = vec3_add(sight->moment, vec3_scale(middle, area));
    }
}

void sun_patch_add(SunPatch *at, Vec3 point, double out[3]) {
    const SunNodes *s = at->sun;
    double share = at->normal.z;
    if (at->state == SUN_DARK) return;
    int occluders = at->state == SUN_PARTLY ? find_occluders(at, to_sun(s, point)) : 0;
    if (occluders < 0) return;
    Vec3 middle = {0, 0, 1};
    if (occluders > 0 || at->disc_count != CORNERS) {
        Sight sight = {.normal = at->normal};
        analytic_visible(at->disc, at->disc_count, -1, at->occluder, occluders, add_part, &sight);
        share = sight.sum / (s->area * FAR);
        if (share > 0) middle = vec3_normalize(sight.moment);
    }
    // Panes of glass let through as much as in the middle of the part in sight: the sun is half a degree wide.
    if (s->mesh->panes.count > 0 && share > 0)
        share *= panes_transmit_from_afar(&s->mesh->panes, point, from_sun(s, middle));
    for (int c = 0; c < 3; c++) out[c] += share * s->beam[c];
}

// ---- patches

// The rectangle about the elements of a patch along the axes of its face's grid, in the sun's axes; counter-clockwise from the front.
static void bound_patch(const SunNodes *s, const Patch *patch, double around, Vec3 out[4]) {
    const Mesh *mesh = s->mesh;
    const Face *face = &mesh->faces[patch->face];
    Vec3 x = vec3_normalize(face->gx), y = vec3_normalize(face->gy);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    // The grid's axes are at right angles, or nearly.
    y = vec3_normalize(vec3_sub(y, vec3_scale(x, vec3_dot(x, y))));
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const Element *element = &mesh->elements[e];
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            Vec3 v = vec3_sub(mesh->vertices[mesh->corners[c]], face->origin);
            double a = vec3_dot(x, v), b = vec3_dot(y, v);
            low[0] = fmin(low[0], a), high[0] = fmax(high[0], a);
            low[1] = fmin(low[1], b), high[1] = fmax(high[1], b);
        }
    }
    for (int i = 0; i < 4; i++) {
        double a = i == 1 || i == 2 ? high[0] + around : low[0] - around,
               b = i >= 2 ? high[1] + around : low[1] - around;
        out[i] = to_sun(s, vec3_add(face->origin, vec3_add(vec3_scale(x, a), vec3_scale(y, b))));
    }
}

// A convex polygon of points in a plane, in the sun's axes, and how wide the sun is that shines on them.
typedef struct Lit {
    const Vec3 *corner;  // counter-clockwise from the plane's front
    int count;
    Plane plane;
    double lowest;
    double wide, sine;  // tangent and sine of the sun's radius
} Lit;

// Do all of the points lie to the right of the line from a to b, as the sun sees them, by more than the sun's width takes a beam to the
// left? `turn` -1: the other way round. A beam is widened at point k of `v` by `wide` times its height above `height`.
static bool wholly_beside(Vec3 a, Vec3 b, double turn, const Vec3 *v, int count, double wide, double height) {
    double x = b.x - a.x, y = b.y - a.y, length = hypot(x, y);
    if (!(length > 0)) return false;
    for (int i = 0; i < count; i++) {
        double right = turn * (y * (v[i].x - a.x) - x * (v[i].y - a.y)) / length;
        if (right <= wide * (v[i].z - height)) return false;
    }
    return true;
}

// May the face hide some of the sun from the polygon?
static bool may_hide(const SunNodes *s, const SunFace *face, const Lit *lit) {
    const Vec3 *corner = s->corner + face->first;
    bool above = false;
    for (int i = 0; i < face->count && !above; i++)
        above = plane_distance(lit->plane, corner[i]) > SHAFT_TOUCH;
    if (!above || face->highest <= lit->lowest) return false;
    for (int i = 0; i < lit->count && lit->plane.n.z > s->sine; i++)
        if (wholly_beside(lit->corner[i], lit->corner[i + 1 < lit->count ? i + 1 : 0], 1, corner, face->count,
                          lit->wide, lit->lowest))
            return false;
    for (int i = 0; i < face->count && face->turn != 0; i++)
        if (wholly_beside(corner[i], corner[i + 1 < face->count ? i + 1 : 0], face->turn, lit->corner,
                          lit->count, -lit->wide, face->highest))
            return false;
    return true;
}

// Directions to the sun that pass on one side of an edge from a point are half-spaces for the point, so that corners tell for all points.
static bool closes(const SunNodes *s, int face, const Lit *lit) {
    double side = 0;
    for (int i = 0; i < lit->count; i++) {
        double height = plane_distance(s->face[face].plane, lit->corner[i]);
        if (side * height < 0 || hidden_part(s, &s->face[face], lit->sine, lit->corner[i]) != HIDES_ALL)
            return false;
        side = height;
    }
    return true;
}

static void note_closer(SunPatch *at, int face, int place) {
    memmove(at->closer + 1, at->closer, (size_t)place * sizeof *at->closer);
    at->closer[0] = face;
}

static bool is_closed(SunPatch *at, int own, const Lit *lit) {
    for (int i = 0; i < at->closer_count; i++) {
        if (at->closer[i] == own || !closes(at->sun, at->closer[i], lit)) continue;
        note_closer(at, at->closer[i], i);
        return true;
    }
    return false;
}

// Lists the faces that may hide the sun from the patch; false: one of them hides all of it.
static bool find_blockers(SunPatch *at, const Lit *lit) {
    const SunNodes *s = at->sun;
    Box box = box_empty();
    for (int i = 0; i < lit->count; i++) box = box_add(box, lit->corner[i]);
    double wide = s->wide * fmax(s->top - lit->lowest, 0);
    box.min.x -= wide, box.min.y -= wide, box.max.x += wide, box.max.y += wide;
    box.max.z = INFINITY;
    box_tree_find(&s->tree, box, at->arena, &at->hits);
    at->blocker_count = 0;
    at->blocker =
        arena_room(at->arena, at->blocker, sizeof *at->blocker, 0, at->hits.count, &at->blocker_capacity);
    for (int i = 0; i < at->hits.count; i++) {
        int f = at->hits.items[i];
        if (f == at->face || !may_hide(s, &s->face[f], lit)) continue;
        at->blocker[at->blocker_count++] = f;
        if (!closes(s, f, lit)) continue;
        if (at->closer_count < CLOSERS) at->closer_count++;
        note_closer(at, f, at->closer_count - 1);
        return false;
    }
    return true;
}

int sun_patch_look(SunPatch *at, int patch, double around) {
    const SunNodes *s = at->sun;
    const Mesh *mesh = s->mesh;
    const Patch *p = &mesh->patches[patch];
    Plane plane = s->face[p->face].plane;
    Vec3 rectangle[4];
    // A surface lies before one cell; things may stand in several.
    int object = mesh->faces[p->face].object;
    bool surface = object >= 0 && mesh->graph->objects[object].kind == OBJECT_SURFACE;
    at->state = SUN_DARK;
    at->face = p->face;
    at->normal = plane.n;
    if (plane.n.z <= -s->sine || (surface && p->cell >= 0 && !s->reached[p->cell])) return at->state;
    bound_patch(s, p, around, rectangle);
    Lit lit = {rectangle, 4, plane, INFINITY, s->wide, s->sine};
    for (int i = 0; i < 4; i++) lit.lowest = fmin(lit.lowest, rectangle[i].z);
    if (is_closed(at, p->face, &lit) || !find_blockers(at, &lit)) return at->state;
    bool whole = plane.n.z >= s->sine;
    at->disc_count = CORNERS;
    if (whole)
        memcpy(at->disc, s->disc, sizeof s->disc);
    else
        at->disc_count = polygon_clip(s->disc, CORNERS, (Plane){plane.n, 0}, 0, at->disc);
    at->state = at->disc_count < 3 ? SUN_DARK : whole && at->blocker_count == 0 ? SUN_WHOLE : SUN_PARTLY;
    return at->state;
}

bool sun_patch_edge(SunPatch *at, const Vec3 *corner, int count) {
    const SunNodes *s = at->sun;
    bool some = false;
    if (at->state != SUN_PARTLY) return false;
    at->moved = arena_room(at->arena, at->moved, sizeof *at->moved, 0, count, &at->moved_capacity);
    Lit lit = {at->moved, count, s->face[at->face].plane, INFINITY, 0, 0};
    for (int i = 0; i < count; i++) {
        at->moved[i] = to_sun(s, corner[i]);
        lit.lowest = fmin(lit.lowest, at->moved[i].z);
    }
    for (int i = 0; i < at->blocker_count; i++) {
        if (!may_hide(s, &s->face[at->blocker[i]], &lit)) continue;
        if (closes(s, at->blocker[i], &lit)) return false;
        some = true;
    }
    return some;
}
