// direct_points.c - direct light at nodes: for each patch the lamps in front of it, for each lamp the faces that may stand between the two,
// for each node the parts of the lamps that these faces leave in sight (analytic.h).
//
// The stab trees tell which lamps an object may see, and portals by which ways (lamp_ways.h). A face can stand between a patch and
// a lamp only where it meets the convex hull of the two: the shaft of Haines & Wallace (Shaft Culling for Efficient Ray-Traced
// Radiosity, 1991). Shafts of batches of patches find faces in a tree of boxes; shafts of patches choose among these.
#include "radiosity/show/direct_points.h"

#include <limits.h>
#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "radiosity/factors/lamp_spread.h"
#include "radiosity/factors/view.h"
#include "radiosity/shoot/sunlight.h"
#include "radiosity/show/shown.h"

// A node lies on edges, where other faces touch: light is found this share of the way to the middle of the node's elements, and metres
// at most. That is above the rounding of coordinates and below a visible distance.
static const double HAIR = 0.01, LONGEST_HAIR = 1e-3;
static const double SAME_PLANE = 1e-6;  // 1 - cosine, as nodes have it
// Faces that are remembered because they hid all of a lamp.
enum { CLOSERS = 8 };
// Patches of a group, which lie side by side on one face; groups of a batch, which belong to one object; and batches between two
// looks at progress.
enum { GROUP = 16, BATCH = 16, BATCHES_A_LOOK = 32 };
// Patches for which what stands before lamps is found at a time.
enum { TOGETHER = 4 };

// A face in the axes of a group: z is the normal of the face that the group is on.
typedef struct Blocker {
    int face, first, count;  // of its corners, in Worker.corner
    double size;             // m^2
    Plane plane;
} Blocker;

// A face of a lamp that looks at a group.
typedef struct Facing {
    int face, first, count;  // of its corners, in Worker.corner
    Plane plane;
    double emitted[3];         // W/m^2
    const LampSpread *spread;  // NULL: by Lambert's cosine
    int first_blocker,
        blocker_count;  // of a patch: in Worker.blocker, those that are not wholly behind the face
} Facing;

// The faces of a lamp object that look at a group or a patch, and the faces that may hide them.
typedef struct Before {
    int object;                        // in Direct.lamp_objects
    Vec3 box[8];                       // corners of its box
    int first_facing, facing_count;    // in Worker.facing
    int first_blocker, blocker_count;  // in Worker.blocker
    int first_pane, pane_count;        // in Worker.panes: those that may stand between
} Before;

// An object of lamps before a batch, and the faces that may stand between the two.
typedef struct Near {
    int object, first, count;  // in Worker.between
} Near;

// The light that a group has found at a node.
typedef struct NodeLight {
    int group, corner;  // one more than the group's index; in Mesh.corners
} NodeLight;

// A point at which bends were looked for.
typedef struct AskedPoint {
    Vec3 point;
    const PointSources *by;
} AskedPoint;

typedef struct DirectWorker {
    Arena arena, bends;
    BoxHits hits;
    Near *near;
    int *between;  // faces
    int near_count, near_capacity, between_count, between_capacity;
    Vec3 *corner;
    int corner_count, corner_capacity;
    Blocker *blocker;
    int blocker_count, blocker_capacity;
    Facing *facing;
    int facing_count, facing_capacity;
    Before *before;
    int before_count, before_capacity;
    AnalyticOccluder *occluder;
    Plane *edge;
    Vec3 *moved, *lamp;  // corners of a face and of a lamp about a point
    int occluder_capacity, edge_capacity, moved_capacity, lamp_capacity;
    Pane *panes;
    int pane_count, pane_capacity;
    const struct Frame *frame;  // of the group
    LampFlood *flood;
    double (*light)[3];  // irradiance at the corners of an element
    int light_capacity;
    BendFinder *finder;
    NodeLight *of_node;   // [nodes->count]
    bool sampled;         // not all faces of a lamp were asked
    int closer[CLOSERS];  // faces that hid all of a lamp lately, the last one first
    int closer_count;
    SunPatch *sun;            // NULL: there is no sun
    const uint64_t *touched;  // of the patch at hand, as in Direct; NULL: all sources
    SourceLight *by;          // of the point at hand, where sources are told apart
    int by_count, by_capacity;
    AskedPoint *asked;  // in the element at hand
    int asked_count, asked_capacity;
    Arena *kept;  // of PointSources
    RadReport report;
} Worker;

typedef struct DirectGroup {
    int face, first_patch, patch_count;
} Group;

typedef struct DirectBatch {
    int first_group, group_count;
} Batch;

// ---- groups and patches

// The axes of a group, and its face's.
typedef struct Frame {
    Vec3 origin, x, y, z;
} Frame;

static Vec3 to_frame(const Frame *f, Vec3 v) {
    Vec3 p = vec3_sub(v, f->origin);
    return vec3(vec3_dot(f->x, p), vec3_dot(f->y, p), vec3_dot(f->z, p));
}

// The corners of a face, at the end of Worker.corner.
static Vec3 *take_corners(const Direct *d, Worker *w, const Frame *frame, int face, int *count) {
    const Face *f = &d->mesh->faces[face];
    w->corner = arena_room(&w->arena, w->corner, sizeof *w->corner, w->corner_count,
                           w->corner_count + f->vertex_count, &w->corner_capacity);
    Vec3 *out = w->corner + w->corner_count;
    for (int i = 0; i < f->vertex_count; i++)
        out[i] = to_frame(frame, d->mesh->vertices[d->mesh->outline[f->first_vertex + i]]);
    *count = f->vertex_count;
    w->corner_count += f->vertex_count;
    return out;
}

// The rectangle about the elements of some patches, in the plane of the face.
static void bound_patches(const Direct *d, const Frame *frame, int first, int count, Vec3 out[4]) {
    const Mesh *mesh = d->mesh;
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    for (int p = first; p < first + count; p++) {
        const Patch *patch = &mesh->patches[p];
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
            const Element *element = &mesh->elements[e];
            for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
                Vec3 v = to_frame(frame, mesh->vertices[mesh->corners[c]]);
                x0 = fmin(x0, v.x), x1 = fmax(x1, v.x);
                y0 = fmin(y0, v.y), y1 = fmax(y1, v.y);
            }
        }
    }
    x0 -= LONGEST_HAIR, x1 += LONGEST_HAIR, y0 -= LONGEST_HAIR, y1 += LONGEST_HAIR;
    out[0] = vec3(x0, y0, 0), out[1] = vec3(x1, y0, 0), out[2] = vec3(x1, y1, 0), out[3] = vec3(x0, y1, 0);
}

static Plane plane_in(const Direct *d, const Frame *frame, int face) {
    Plane plane = d->mesh->faces[face].plane;
    Vec3 n = vec3(vec3_dot(frame->x, plane.n), vec3_dot(frame->y, plane.n), vec3_dot(frame->z, plane.n));
    return (Plane){n, -plane_distance(plane, frame->origin)};
}

// Has the lamp a part above the rectangle's plane, and the rectangle one before the lamp?
static bool face_each_other(const Vec3 rectangle[4], const Vec3 *corner, int count, Plane plane) {
    bool above = false, before = false;
    for (int i = 0; i < count; i++) above = above || corner[i].z > SHAFT_TOUCH;
    for (int i = 0; i < 4; i++) before = before || plane_distance(plane, rectangle[i]) > SHAFT_TOUCH;
    return above && before;
}

static int larger_first(const void *a, const void *b) {
    const Blocker *p = a, *q = b;
    if (p->size != q->size) return p->size > q->size ? -1 : 1;
    return p->face - q->face;
}

// The two ends of a shaft, in building space.
typedef struct Ends {
    const Vec3 *one, *other;
    int one_count, other_count;
    int but;  // the face that the one end lies on, -1: none
} Ends;

static bool closes(const Direct *d, const Ends *ends, int face) {
    const Face *f = &d->mesh->faces[face];
    return face != ends->but && shaft_is_closed(d->place + f->first_vertex, f->vertex_count, f->plane,
                                                ends->one, ends->one_count, ends->other, ends->other_count);
}

static void note_closer(Worker *w, int face, int at) {
    memmove(w->closer + 1, w->closer, (size_t)at * sizeof *w->closer);
    w->closer[0] = face;
}

// Is the shaft closed by a face that closed another one lately? A wall hides a lamp from all that lies behind the wall.
static bool closed_as_lately(const Direct *d, Worker *w, const Ends *ends) {
    for (int i = 0; i < w->closer_count; i++) {
        int face = w->closer[i];
        if (!closes(d, ends, face)) continue;
        note_closer(w, face, i);
        return true;
    }
    return false;
}

// Is the shaft closed by this face?
static bool closed_by(const Direct *d, Worker *w, const Ends *ends, int face) {
    if (!closes(d, ends, face)) return false;
    if (w->closer_count < CLOSERS) w->closer_count++;
    note_closer(w, face, w->closer_count - 1);
    return true;
}

static Vec3 from_frame(const Frame *f, Vec3 v) {
    Vec3 p = vec3_add(vec3_scale(f->x, v.x), vec3_scale(f->y, v.y));
    return vec3_add(f->origin, vec3_add(p, vec3_scale(f->z, v.z)));
}

// The lamp's face, if it looks at the group.
static void take_facing(const Direct *d, Worker *w, const Frame *frame, const Vec3 rectangle[4], int face) {
    int count, corners = w->corner_count;
    Plane plane = plane_in(d, frame, face);
    const Vec3 *corner = take_corners(d, w, frame, face, &count);
    if (!face_each_other(rectangle, corner, count, plane)) {
        w->corner_count = corners;
        return;
    }
    w->facing = arena_room(&w->arena, w->facing, sizeof *w->facing, w->facing_count, w->facing_count + 1,
                           &w->facing_capacity);
    Facing *facing = &w->facing[w->facing_count++];
    *facing = (Facing){.face = face, .first = corners, .count = count, .plane = plane};
    rgb_doubles(mesh_material(d->mesh, face)->emission, facing->emitted);
    facing->spread = mesh_spread(d->mesh, face);
}

static void put_before(Worker *w, Before before) {
    w->before = arena_room(&w->arena, w->before, sizeof *w->before, w->before_count, w->before_count + 1,
                           &w->before_capacity);
    w->before[w->before_count++] = before;
}

static void put_blocker(Worker *w, Blocker blocker) {
    w->blocker = arena_room(&w->arena, w->blocker, sizeof *w->blocker, w->blocker_count, w->blocker_count + 1,
                            &w->blocker_capacity);
    w->blocker[w->blocker_count++] = blocker;
}

// Lists the panes of glass in a shaft, at the end of Worker.panes.
static void take_panes(const Direct *d, Worker *w, const Shaft *shaft, Before *before) {
    before->first_pane = w->pane_count;
    for (int i = 0; i < d->mesh->panes.count; i++) {
        Vec3 corner[4];
        pane_corners(&d->mesh->panes.panes[i], corner);
        if (!shaft_is_met(shaft, corner, 4)) continue;
        w->panes = arena_room(&w->arena, w->panes, sizeof *w->panes, w->pane_count, w->pane_count + 1,
                              &w->pane_capacity);
        w->panes[w->pane_count++] = d->mesh->panes.panes[i];
    }
    before->pane_count = w->pane_count - before->first_pane;
}

// Puts a lamp object before the group, with the faces in the shaft between them, unless one of these hides all of it.
static void take_lamps(const Direct *d, Worker *w, const Frame *frame, const Vec3 rectangle[4], int own,
                       const Near *near) {
    const LampObject *lamps = &d->lamp_objects[near->object];
    int facing = w->facing_count, blockers = w->blocker_count, corners = w->corner_count;
    Vec3 there[4];
    Before before = {.first_facing = facing, .first_blocker = blockers};
    for (int k = lamps->first; k < lamps->first + lamps->count; k++)
        if (d->lamp[k] != own) take_facing(d, w, frame, rectangle, d->lamp[k]);
    if (w->facing_count == facing) return;
    box_corners(lamps->box, before.box);
    for (int i = 0; i < 4; i++) there[i] = from_frame(frame, rectangle[i]);
    Ends ends = {there, before.box, 4, 8, own};
    Shaft shaft = shaft_to_box(there, 4, d->mesh->faces[own].plane, lamps->box);
    bool closed = closed_as_lately(d, w, &ends) ||
                  !lamp_flood_reaches(w->flood, &shaft, d->mesh->faces[own].object, lamps->object);
    for (int i = near->first; i < near->first + near->count && !closed; i++) {
        int other = w->between[i], count, first = w->corner_count;
        const Face *f = &d->mesh->faces[other];
        if (other == own || !shaft_is_met(&shaft, d->place + f->first_vertex, f->vertex_count)) continue;
        closed = closed_by(d, w, &ends, other);
        take_corners(d, w, frame, other, &count);
        put_blocker(w, (Blocker){other, first, count, d->size[other], plane_in(d, frame, other)});
    }
    if (closed) {
        w->corner_count = corners;
        w->facing_count = facing;
        w->blocker_count = blockers;
        return;
    }
    qsort(w->blocker + blockers, (size_t)(w->blocker_count - blockers), sizeof *w->blocker, larger_first);
    for (int i = 0; i < 8; i++) before.box[i] = to_frame(frame, before.box[i]);
    before.facing_count = w->facing_count - facing;
    before.blocker_count = w->blocker_count - blockers;
    before.object = near->object;
    take_panes(d, w, &shaft, &before);
    put_before(w, before);
}

// Has the face a part in front of the plane, or does it lie in it?
static bool is_before(const Vec3 *corner, int count, Plane plane) {
    bool in_plane = true;
    for (int i = 0; i < count; i++) {
        double distance = plane_distance(plane, corner[i]);
        if (distance > SHAFT_TOUCH) return true;
        in_plane = in_plane && distance >= -SHAFT_TOUCH;
    }
    return in_plane;
}

// Lists the faces that may hide one face of a lamp object.
static void share_blockers(Worker *w, const Before *before, Facing *facing) {
    facing->first_blocker = w->blocker_count;
    for (int i = before->first_blocker; i < before->first_blocker + before->blocker_count; i++) {
        Blocker b = w->blocker[i];
        if (b.face != facing->face && is_before(w->corner + b.first, b.count, facing->plane))
            put_blocker(w, b);
    }
    facing->blocker_count = w->blocker_count - facing->first_blocker;
}

// The lamp object of a group before one of its patches.
static void narrow(const Direct *d, Worker *w, const Vec3 there[4], const Vec3 rectangle[4], int own,
                   Before before) {
    int facing = w->facing_count, blockers = w->blocker_count;
    Box box = d->lamp_objects[before.object].box;
    for (int i = before.first_facing; i < before.first_facing + before.facing_count; i++) {
        Facing f = w->facing[i];
        if (!face_each_other(rectangle, w->corner + f.first, f.count, f.plane)) continue;
        w->facing = arena_room(&w->arena, w->facing, sizeof *w->facing, w->facing_count, w->facing_count + 1,
                               &w->facing_capacity);
        w->facing[w->facing_count++] = f;
    }
    if (w->facing_count == facing) return;
    if (before.blocker_count > 0) {
        Vec3 corner[8];
        box_corners(box, corner);
        Ends ends = {there, corner, 4, 8, own};
        bool closed = closed_as_lately(d, w, &ends);
        Shaft shaft = {0};
        if (!closed) {
            shaft = shaft_to_box(there, 4, d->mesh->faces[own].plane, box);
            closed = !lamp_flood_reaches(w->flood, &shaft, d->mesh->faces[own].object,
                                         d->lamp_objects[before.object].object);
        }
        for (int i = before.first_blocker; i < before.first_blocker + before.blocker_count && !closed; i++) {
            Blocker b = w->blocker[i];
            if (!shaft_is_met(&shaft, d->place + d->mesh->faces[b.face].first_vertex, b.count)) continue;
            closed = closed_by(d, w, &ends, b.face);
            put_blocker(w, b);
        }
        if (closed) {
            w->facing_count = facing;
            w->blocker_count = blockers;
            return;
        }
    }
    before.first_facing = facing;
    before.facing_count = w->facing_count - facing;
    before.first_blocker = blockers;
    before.blocker_count = w->blocker_count - blockers;
    for (int i = facing; i < w->facing_count; i++) share_blockers(w, &before, &w->facing[i]);
    put_before(w, before);
}

// ---- points

// Corners about a point, in Worker.moved.
static Vec3 *move_corners(Worker *w, const Vec3 *corner, int count, Vec3 point) {
    w->moved = arena_room(&w->arena, w->moved, sizeof *w->moved, 0, count, &w->moved_capacity);
    for (int i = 0; i < count; i++) w->moved[i] = vec3_sub(corner[i], point);
    return w->moved;
}

// Faces hide as in views: of two in one place fronts hide backs, then the lower index (form_factor_rank).
static int rank_of(int face, Plane plane, Vec3 point) {
    ViewFace view = {.face = face, .d = -plane_distance(plane, point)};
    return form_factor_rank(&view);
}

// The part of a lamp that a face hides from a point.
enum { HIDES_NONE, HIDES_SOME, HIDES_ALL };

// A quick test before any polygon is cut. `moved` and `lamp` are the corners of both about the point.
static int hidden_part(const Blocker *b, const Vec3 *moved, const Vec3 *lamp, int count, Vec3 point) {
    double height = plane_distance(b->plane, point), sign = height > 0 ? -1 : 1;
    int beyond = 0, in_plane = 0;
    if (fabs(height) <= SHAFT_TOUCH) return HIDES_NONE;  // seen edge-on
    for (int k = 0; k < count; k++) {
        double behind = sign * (vec3_dot(b->plane.n, lamp[k]) + height);
        beyond += behind > SHAFT_TOUCH;
        in_plane += fabs(behind) <= SHAFT_TOUCH;
    }
    if (beyond == 0 && in_plane < count) return HIDES_NONE;
    bool all = beyond == count;
    for (int i = 0; i < b->count; i++) {
        Vec3 edge = vec3_cross(moved[i], moved[i + 1 < b->count ? i + 1 : 0]);
        double least = SHAFT_TOUCH * SHAFT_TOUCH * vec3_dot(edge, edge);
        int inside = 0;
        for (int k = 0; k < count; k++) {
            double height_in = sign * vec3_dot(edge, lamp[k]);
            inside += height_in > 0 && height_in * height_in > least;
        }
        if (inside == 0 && least > 0) return HIDES_NONE;
        all = all && inside == count;
    }
    return all ? HIDES_ALL : HIDES_SOME;
}

// Corners about a point, in Worker.lamp.
static Vec3 *move_lamp(Worker *w, const Vec3 *corner, int count, Vec3 point) {
    w->lamp = arena_room(&w->arena, w->lamp, sizeof *w->lamp, 0, count, &w->lamp_capacity);
    for (int i = 0; i < count; i++) w->lamp[i] = vec3_sub(corner[i], point);
    return w->lamp;
}

static int hides_lamp(Worker *w, const Blocker *b, const Vec3 *lamp, int count, Vec3 point) {
    return hidden_part(b, move_corners(w, w->corner + b->first, b->count, point), lamp, count, point);
}

// The cones of the faces that hide some of a lamp's face from the point: returns how many, or -1 where one of them hides all of it. That
// one is then the first to be asked for the next point.
static int find_occluders(Worker *w, const Facing *facing, const Vec3 *lamp, Vec3 point) {
    int occluders = 0, edges = 0;
    Blocker *blocker = w->blocker + facing->first_blocker;
    for (int i = 0; i < facing->blocker_count; i++) {
        Blocker b = blocker[i];
        int part = hides_lamp(w, &b, lamp, facing->count, point);
        if (part == HIDES_ALL) {
            memmove(blocker + 1, blocker, (size_t)i * sizeof *blocker);
            blocker[0] = b;
            return -1;
        }
        if (part == HIDES_NONE) continue;
        w->edge = arena_room(&w->arena, w->edge, sizeof *w->edge, edges, edges + b.count, &w->edge_capacity);
        w->occluder = arena_room(&w->arena, w->occluder, sizeof *w->occluder, occluders, occluders + 1,
                                 &w->occluder_capacity);
        AnalyticOccluder *o = &w->occluder[occluders];
        if (!analytic_occluder(w->moved, b.count, rank_of(b.face, b.plane, point), w->edge + edges, o))
            continue;
        edges += o->edge_count;
        occluders++;
    }
    return occluders;
}

// The share of the light from the point, about z, that meets the lamp's face; below 0: a face hides all of it.
static double share_in_sight(Worker *w, const Before *before, const Facing *facing, Vec3 point) {
    SpreadSight by_table =
        spread_sight(facing->spread, LAMP_SPREAD_OFF, w->frame->x, w->frame->y, w->frame->z);
    AnalyticSight sight = {0};
    Panes panes = {.panes = before->pane_count > 0 ? w->panes + before->first_pane : NULL,
                   .count = before->pane_count};
    const Vec3 *lamp = move_lamp(w, w->corner + facing->first, facing->count, point);
    int occluders = find_occluders(w, facing, lamp, point);
    w->report.direct_pairs++;
    if (occluders < 0) return -1;
    if (occluders == 0 && panes.count == 0 && !facing->spread) return analytic_point(lamp, facing->count);
    w->report.direct_cut += occluders > 0;
    analytic_visible(lamp, facing->count, rank_of(facing->face, facing->plane, point), w->occluder, occluders,
                     facing->spread ? spread_sight_add : analytic_sight_add,
                     facing->spread ? (void *)&by_table : &sight);
    if (facing->spread) sight = by_table.sight;
    if (panes.count == 0 || !(sight.area > 0)) return sight.share;
    // Panes of glass weaken all that is in sight as they do on the line to its middle.
    Vec3 middle = vec3_add(point, vec3_scale(sight.moment, 1 / sight.area));
    return sight.share * panes_transmit(&panes, from_frame(w->frame, point), from_frame(w->frame, middle));
}

// Is a face known that hides all of a lamp object from the point? The last face that hid a whole face of it is asked.
static bool hides_object(Worker *w, const Before *before, Vec3 point) {
    const Facing *first = &w->facing[before->first_facing];
    if (first->blocker_count == 0) return false;
    Blocker b = w->blocker[first->first_blocker];
    return hides_lamp(w, &b, move_lamp(w, before->box, 8, point), 8, point) == HIDES_ALL;
}

// Where the light of a point is found that may lie on an element's edge, in the frame.
static Vec3 off_the_edge(Vec3 point, Vec3 towards) {
    Vec3 way = vec3_sub(towards, point);
    double length = vec3_length(way), hair = fmin(HAIR * length, LONGEST_HAIR);
    if (length > 0) point = vec3_add(point, vec3_scale(way, hair / length));
    return vec3(point.x, point.y, 0);
}

static bool in_one_plane(const Direct *d, int node) {
    for (int i = d->nodes->first[node]; i < d->nodes->first[node + 1]; i++) {
        Vec3 n = d->mesh->faces[d->mesh->elements[d->nodes->element[i]].face].plane.n;
        if (vec3_dot(n, d->nodes->normal[node]) <= 1 - SAME_PLANE) return false;
    }
    return true;
}

static bool is_shared(const Direct *d, int node) {
    return d->nodes->first[node + 1] - d->nodes->first[node] > 1 && in_one_plane(d, node);
}

// The middle of the elements that meet at a node.
static Vec3 middle_of(const Direct *d, int node) {
    const Nodes *nodes = d->nodes;
    int first = nodes->first[node], end = nodes->first[node + 1];
    Vec3 middle = {0, 0, 0};
    for (int i = first; i < end; i++)
        middle =
            vec3_add(middle, vec3_scale(element_centroid(d->mesh, nodes->element[i]), 1.0 / (end - first)));
    return middle;
}

bool direct_corner_counts(const Direct *d, int element, int corner, Vec3 *towards) {
    int node = d->nodes->of_corner[corner];
    *towards = element_centroid(d->mesh, element);
    if (!is_shared(d, node)) return true;
    if (d->nodes->element[d->nodes->first[node]] != element) return false;
    *towards = middle_of(d, node);
    return true;
}

// Unit vectors along gx and gy of the face of an element.
static void axes_of(const Mesh *mesh, int element, Vec3 axis[2]) {
    const Face *face = &mesh->faces[mesh->elements[element].face];
    axis[0] = vec3_normalize(face->gx);
    axis[1] = vec3_normalize(face->gy);
}

void direct_way(const Direct *d, int element, int corner, Vec3 from, float out[2]) {
    int node = corner < 0 ? -1 : d->nodes->of_corner[corner];
    bool shared = node >= 0 && is_shared(d, node);
    Vec3 axis[2], way = vec3_sub(shared ? middle_of(d, node) : element_centroid(d->mesh, element), from);
    axes_of(d->mesh, element, axis);
    for (int i = 0; i < 2; i++) out[i] = (float)vec3_dot(axis[i], way);
}

// As `towards` has it, where that knows the corner.
static Vec3 known_towards(const Direct *d, int element, int corner, Vec3 usual) {
    const float *way = d->towards ? d->towards[corner] : NULL;
    if (!way || isnan(way[0])) return usual;
    Vec3 axis[2];
    axes_of(d->mesh, element, axis);
    return vec3_add(d->mesh->vertices[d->mesh->corners[corner]],
                    vec3_add(vec3_scale(axis[0], (double)way[0]), vec3_scale(axis[1], (double)way[1])));
}

// ---- what each source gives

static bool has_bit(const uint64_t *bits, int i) { return !bits || (bits[i / 64] >> i % 64 & 1); }

static void note_source(Worker *w, int source, const double light[3]) {
    int i = w->by_count;
    if (!has_bit(w->touched, source)) return;
    while (i > 0 && w->by[i - 1].source != source) i--;
    if (i == 0) {
        w->by = arena_room(&w->arena, w->by, sizeof *w->by, w->by_count, w->by_count + 1, &w->by_capacity);
        w->by[w->by_count++] = (SourceLight){.source = source};
        i = w->by_count;
    }
    for (int c = 0; c < 3; c++) w->by[i - 1].light[c] += (float)light[c];
}

// Keeps the sources of the point at hand, and of `before` those that are not looked for now.
static const PointSources *keep_sources(Worker *w, const PointSources *before) {
    for (int i = 0; before && w->touched && i < before->count; i++) {
        if (has_bit(w->touched, before->by[i].source)) continue;
        w->by = arena_room(&w->arena, w->by, sizeof *w->by, w->by_count, w->by_count + 1, &w->by_capacity);
        w->by[w->by_count++] = before->by[i];
    }
    if (w->by_count == 0) return NULL;
    size_t bytes = sizeof(PointSources) + (size_t)w->by_count * sizeof *w->by;
    PointSources *out = arena_alloc(w->kept, bytes, 1);
    out->count = w->by_count;
    memcpy(out->by, w->by, (size_t)w->by_count * sizeof *w->by);
    return out;
}

static const PointSources *sources_asked(const Worker *w, Vec3 point) {
    for (int i = 0; i < w->asked_count; i++)
        if (memcmp(&w->asked[i].point, &point, sizeof point) == 0) return w->asked[i].by;
    return NULL;
}

// Light from the lamps before `first` .. `end`. Of the faces of a lamp object `most` stand for all.
static void light_point(const Direct *d, Worker *w, int first, int end, Vec3 point, int most, double out[3]) {
    w->report.direct_points++;
    w->by_count = 0;
    for (int k = first; k < end; k++) {
        Before before = w->before[k];
        int step = (before.facing_count + most - 1) / most, last = before.first_facing + before.facing_count;
        double weight = before.facing_count / ceil((double)before.facing_count / step);
        w->sampled = w->sampled || step > 1;
        if (hides_object(w, &before, point)) continue;
        for (int i = before.first_facing; i < last; i += step) {
            const Facing *facing = &w->facing[i];
            if (plane_distance(facing->plane, point) <= 0) continue;
            double share = weight * fmax(share_in_sight(w, &before, facing, point), 0);
            for (int c = 0; c < 3; c++) out[c] += share * facing->emitted[c];
            if (d->source_of && share > 0) {
                double light[3];
                for (int c = 0; c < 3; c++) light[c] = share * facing->emitted[c];
                note_source(w, d->source_of[facing->face], light);
            }
        }
    }
}

static void add_sun(const Direct *d, Worker *w, Vec3 point, double out[3]) {
    double light[3] = {0, 0, 0};
    sun_patch_add(w->sun, point, light);
    for (int c = 0; c < 3; c++) out[c] += light[c];
    if (d->source_of && rgb_sum(light) > 0) note_source(w, d->day, light);
}

// So many faces of a lamp stand for all where bends are looked for.
enum { FACES_FOR_BENDS = 2 };

// An element whose bends are looked for.
typedef struct Bent {
    const Direct *d;
    Worker *worker;
    const Frame *frame;
    int first;    // of the lamps before the patch, in Worker.before
    Vec3 middle;  // in the frame
} Bent;

// Irradiance straight from lamps and sun at a point of the element.
static void light_of_bent(void *context, Vec3 point, double out[3]) {
    const Bent *b = context;
    Vec3 at = off_the_edge(to_frame(b->frame, point), b->middle);
    Worker *w = b->worker;
    light_point(b->d, w, b->first, w->before_count, at, FACES_FOR_BENDS, out);
    if (w->sun) add_sun(b->d, w, from_frame(b->frame, at), out);
    if (!b->d->source_of) return;
    w->asked = arena_room(&w->arena, w->asked, sizeof *w->asked, w->asked_count, w->asked_count + 1,
                          &w->asked_capacity);
    w->asked[w->asked_count++] = (AskedPoint){point, keep_sources(w, NULL)};
}

static bool edge_of_bent(void *context, const Vec3 *corner, int count) {
    const Bent *b = context;
    return sun_patch_edge(b->worker->sun, corner, count);
}

static bool edge_in_element(const Direct *d, Worker *w, int e) {
    const Element *element = &d->mesh->elements[e];
    w->moved =
        arena_room(&w->arena, w->moved, sizeof *w->moved, 0, element->corner_count, &w->moved_capacity);
    for (int i = 0; i < element->corner_count; i++)
        w->moved[i] = d->mesh->vertices[d->mesh->corners[element->first_corner + i]];
    return sun_patch_edge(w->sun, w->moved, element->corner_count);
}

// Light at a corner of an element, as all lamps and the sun give it.
static void light_corner(const Direct *d, Worker *w, const Frame *frame, int c, Vec3 towards, int first,
                         int sun, double out[3]) {
    Vec3 node = to_frame(frame, d->mesh->vertices[d->mesh->corners[c]]);
    node = off_the_edge(node, to_frame(frame, towards));
    light_point(d, w, first, w->before_count, node, INT_MAX / 2, out);
    if (sun != SUN_DARK) add_sun(d, w, from_frame(frame, node), out);
}

// Light at the corners of an element, in Worker.light: another element may have it by now, if it belongs to the same group, so that it does
// not depend on threads.
static void collect_corners(const Direct *d, Worker *w, const Frame *frame, int e, int group, int first,
                            int sun) {
    const Element *element = &d->mesh->elements[e];
    w->light =
        arena_room(&w->arena, w->light, sizeof *w->light, 0, element->corner_count, &w->light_capacity);
    for (int i = 0; i < element->corner_count; i++) {
        Vec3 towards;
        int c = element->first_corner + i;
        const NodeLight *known = &w->of_node[d->nodes->of_corner[c]];
        memset(w->light[i], 0, sizeof *w->light);
        if (direct_corner_counts(d, e, c, &towards))
            memcpy(w->light[i], d->at_corner[c], sizeof *w->light);
        else if (known->group == group + 1)
            memcpy(w->light[i], d->at_corner[known->corner], sizeof *w->light);
        else
            light_corner(d, w, frame, c, towards, first, sun, w->light[i]);
    }
}

// Light that differs by less than this share is the same.
static const double SAME_LIGHT = 1e-4;

static bool same_light(const double a[3], const double b[3]) {
    for (int c = 0; c < 3; c++)
        if (fabs(a[c] - b[c]) > SAME_LIGHT * fmax(a[c], b[c])) return false;
    return true;
}

// Is the light at the corners and the middle of an element the same as usual?
static bool is_usual(const Direct *d, Bent *bent, int e, Vec3 middle) {
    const Element *element = &d->mesh->elements[e];
    const Within *within = &d->usual->within[e];
    double light[3] = {0, 0, 0};
    if (!within->looked) return false;
    for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++)
        if (!same_light(d->at_corner[c], d->usual->at_corner[c])) return false;
    light_of_bent(bent, middle, light);
    return same_light(light, within->seemed);
}

// `sun`: what the patch has of it.
static void find_bend(const Direct *d, Worker *w, const Frame *frame, int e, int group, int first, int sun) {
    const Element *element = &d->mesh->elements[e];
    Vec3 middle = element_centroid(d->mesh, e);
    Bent bent = {d, w, frame, first, to_frame(frame, middle)};
    BendLight light = {.at = light_of_bent, .context = &bent, .rest = d->besides[e]};
    rgb_doubles(mesh_material(d->mesh, element->face)->reflectance, light.reflectance);
    if ((w->before_count == first && sun != SUN_PARTLY) || rgb_sum(light.reflectance) == 0) return;
    if (d->usual && is_usual(d, &bent, e, middle)) return;
    collect_corners(d, w, frame, e, group, first, sun);
    if (sun == SUN_PARTLY && edge_in_element(d, w, e)) light.edge = edge_of_bent;
    w->sampled = false;
    w->asked_count = 0;
    d->bends[e] = bend_find(w->finder, d->mesh, e, w->light, &light, &w->bends);
    Within *within = &d->within[e];
    const BendPoint *points = bend_points(w->finder, &within->count),
                    *at = direct_find_point(points, within->count, middle);
    within->looked = at != NULL;
    if (at) memcpy(within->seemed, at->irradiance, sizeof within->seemed);
    if (w->sampled) {
        within->count = 0;
        return;
    }
    within->middle_known = at != NULL;
    if (at) memcpy(within->middle, at->irradiance, sizeof within->middle);
    if (at && d->source_of) within->middle_by = sources_asked(w, at->point);
    if (!d->bends[e]) {
        within->count = 0;
        return;
    }
    BendPoint *kept = ARENA_ARRAY(&w->bends, BendPoint, within->count);
    memcpy(kept, points, (size_t)within->count * sizeof *kept);
    within->points = kept;
    if (!d->source_of) return;
    within->by = arena_alloc(&w->bends, (size_t)within->count, sizeof(PointSources *));
    for (int i = 0; i < within->count; i++) within->by[i] = sources_asked(w, kept[i].point);
}

static void light_corners(const Direct *d, Worker *w, const Frame *frame, int e, int group, int first,
                          int sun) {
    const Element *element = &d->mesh->elements[e];
    for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
        Vec3 towards;
        if (!direct_corner_counts(d, e, c, &towards)) continue;
        if (!d->known || !d->known[c]) {
            light_corner(d, w, frame, c, known_towards(d, e, c, towards), first, sun, d->at_corner[c]);
            if (d->source_of) d->corner_by[c] = keep_sources(w, d->corner_by[c]);
        }
        w->of_node[d->nodes->of_corner[c]] = (NodeLight){group + 1, c};
    }
}

// The sources of light at the centroid of an element.
static void light_middle(const Direct *d, Worker *w, const Frame *frame, int e, int first, int sun) {
    double light[3] = {0, 0, 0};
    const Mesh *rough = d->rough ? d->rough : d->mesh;
    Vec3 middle = element_centroid(rough, d->rough ? shown_around(rough, d->mesh, e) : e),
         at = off_the_edge(to_frame(frame, element_centroid(d->mesh, e)), to_frame(frame, middle));
    light_point(d, w, first, w->before_count, at, INT_MAX / 2, light);
    if (sun != SUN_DARK) add_sun(d, w, from_frame(frame, at), light);
    d->middle_by[e] = keep_sources(w, d->middle_by[e]);
}

// ---- sources that are looked for

static const uint64_t *touched_of(const Direct *d, int patch) {
    return d->touched ? d->touched + (size_t)patch * (size_t)d->touched_words : NULL;
}

// Is an object of lamps to be asked for one of the patches first .. end - 1?
static bool is_asked(const Direct *d, int lamp, int first, int end) {
    const LampObject *l = &d->lamp_objects[lamp];
    if (!d->touched || l->source < 0) return true;
    for (int p = first; p < end; p++)
        if (has_bit(touched_of(d, p), l->source)) return true;
    return false;
}

// Patches first .. end - 1, which share what is before them.
static void light_patches(const Direct *d, Worker *w, const Frame *frame, int group, int first_patch, int end,
                          int lamps) {
    const Mesh *mesh = d->mesh;
    int first = w->before_count, blockers = w->blocker_count, facing = w->facing_count;
    Vec3 rectangle[4], there[4];
    bound_patches(d, frame, first_patch, end - first_patch, rectangle);
    for (int i = 0; i < 4; i++) there[i] = from_frame(frame, rectangle[i]);
    for (int k = 0; k < lamps; k++)
        if (is_asked(d, w->before[k].object, first_patch, end))
            narrow(d, w, there, rectangle, mesh->patches[first_patch].face, w->before[k]);
    for (int p = first_patch; p < end; p++) {
        const Patch *patch = &mesh->patches[p];
        w->touched = touched_of(d, p);
        int sun = w->sun ? sun_patch_look(w->sun, p, LONGEST_HAIR) : SUN_DARK;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
            light_corners(d, w, frame, e, group, first, sun);
            if (d->besides) find_bend(d, w, frame, e, group, first, sun);
            if (d->middle_wanted && d->middle_wanted[e]) light_middle(d, w, frame, e, first, sun);
        }
    }
    w->before_count = first;
    w->blocker_count = blockers;
    w->facing_count = facing;
}

static bool is_settled(const Direct *d, const Group *g) {
    int p = g->first_patch;
    while (d->settled && p < g->first_patch + g->patch_count && d->settled[p]) p++;
    return d->settled && p == g->first_patch + g->patch_count;
}

static bool patch_is_settled(const Direct *d, int patch) { return d->settled && d->settled[patch]; }

static void light_group(const Direct *d, Worker *w, const Group *g) {
    if (is_settled(d, g)) return;
    const Face *face = &d->mesh->faces[g->face];
    Frame frame = {.origin = d->mesh->patches[g->first_patch].centre, .z = face->plane.n};
    Vec3 rectangle[4];
    // The centre may lie off the plane by rounding.
    frame.origin = vec3_sub(frame.origin, vec3_scale(frame.z, plane_distance(face->plane, frame.origin)));
    view_axes(frame.z, &frame.x, &frame.y);
    w->corner_count = w->blocker_count = w->before_count = w->facing_count = w->pane_count = 0;
    w->frame = &frame;
    bound_patches(d, &frame, g->first_patch, g->patch_count, rectangle);
    for (int i = 0; i < w->near_count; i++)
        if (is_asked(d, w->near[i].object, g->first_patch, g->first_patch + g->patch_count))
            take_lamps(d, w, &frame, rectangle, g->face, &w->near[i]);
    int lamps = w->before_count, end = g->first_patch + g->patch_count, next;
    for (int p = g->first_patch; (lamps > 0 || w->sun) && p < end; p = next) {
        next = p + 1;
        if (patch_is_settled(d, p)) continue;
        while (next < end && next < p + TOGETHER && !patch_is_settled(d, next)) next++;
        light_patches(d, w, &frame, (int)(g - d->groups), p, next, lamps);
    }
}

static Box box_of_groups(const Direct *d, const Batch *batch) {
    const Mesh *mesh = d->mesh;
    Box box = box_empty();
    for (int g = batch->first_group; g < batch->first_group + batch->group_count; g++) {
        const Group *group = &d->groups[g];
        const Patch *first = &mesh->patches[group->first_patch],
                    *last = &mesh->patches[group->first_patch + group->patch_count - 1];
        int end = last->first_element + last->element_count - 1;
        end = mesh->elements[end].first_corner + mesh->elements[end].corner_count;
        for (int c = mesh->elements[first->first_element].first_corner; c < end; c++)
            box = box_add(box, mesh->vertices[mesh->corners[c]]);
    }
    return box_grow(box, LONGEST_HAIR);
}

// Puts the lamps of an object before the batch, unless one face hides all of them.
static void take_object(const Direct *d, Worker *w, Box box, int own, int object) {
    const LampObject *lamps = &d->lamp_objects[object];
    int first = w->between_count;
    Vec3 one[8], other[8];
    box_corners(box, one);
    box_corners(lamps->box, other);
    Ends ends = {one, other, 8, 8, -1};
    if (closed_as_lately(d, w, &ends)) return;
    Shaft shaft = shaft_of_boxes(box, lamps->box);
    if (!lamp_flood_reaches(w->flood, &shaft, own, lamps->object)) return;
    box_tree_find(&d->tree, box_union(box, lamps->box), &w->arena, &w->hits);
    w->between = arena_room(&w->arena, w->between, sizeof *w->between, first, first + w->hits.count,
                            &w->between_capacity);
    for (int i = 0; i < w->hits.count; i++) {
        const Face *face = &d->mesh->faces[w->hits.items[i]];
        if (!shaft_is_met(&shaft, d->place + face->first_vertex, face->vertex_count)) continue;
        if (closed_by(d, w, &ends, w->hits.items[i])) {
            w->between_count = first;
            return;
        }
        w->between[w->between_count++] = w->hits.items[i];
    }
    w->near =
        arena_room(&w->arena, w->near, sizeof *w->near, w->near_count, w->near_count + 1, &w->near_capacity);
    w->near[w->near_count++] = (Near){object, first, w->between_count - first};
}

static void light_batch(void *context, int index, int thread) {
    const Direct *d = context;
    const Batch *batch = &d->batches[d->first + index];
    Worker *w = &d->workers[thread];
    int own = d->mesh->faces[d->groups[batch->first_group].face].object, settled = 0;
    for (int g = batch->first_group; g < batch->first_group + batch->group_count; g++)
        settled += is_settled(d, &d->groups[g]);
    if (settled == batch->group_count) return;
    Box box = box_of_groups(d, batch);
    w->near_count = w->between_count = 0;
    const Group *last = &d->groups[batch->first_group + batch->group_count - 1];
    int first = d->groups[batch->first_group].first_patch, end = last->first_patch + last->patch_count;
    for (int i = -1; d->lamps && (i = lamp_ways_next(d->ways, own, i)) >= 0;)
        if (is_asked(d, i, first, end)) take_object(d, w, box, own, i);
    bool lit = w->near_count > 0 || w->sun;
    for (int g = batch->first_group; lit && g < batch->first_group + batch->group_count; g++)
        light_group(d, w, &d->groups[g]);
}

// ---- all nodes

static void make_groups(Direct *d, Arena *arena) {
    const Mesh *mesh = d->mesh;
    d->groups = ARENA_ARRAY(arena, Group, mesh->patch_count + 1);
    d->batches = ARENA_ARRAY(arena, Batch, mesh->patch_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        for (int p = 0; p < face->patch_count; p += GROUP) {
            int left = face->patch_count - p;
            Batch *last = d->batch_count > 0 ? &d->batches[d->batch_count - 1] : NULL;
            bool joins = last && last->group_count < BATCH &&
                         mesh->faces[d->groups[last->first_group].face].object == face->object;
            if (!joins) d->batches[d->batch_count++] = (Batch){d->group_count, 0};
            d->batches[d->batch_count - 1].group_count++;
            d->groups[d->group_count++] = (Group){f, face->first_patch + p, left < GROUP ? left : GROUP};
        }
    }
}

// Faces of an object follow each other.
static void add_lamp(Direct *d, int face, Box box) {
    int object = d->mesh->faces[face].object;
    if (d->lamp_object_count == 0 || d->lamp_objects[d->lamp_object_count - 1].object != object)
        d->lamp_objects[d->lamp_object_count++] = (LampObject){object, d->lamp_count, 0, -1, box_empty()};
    LampObject *last = &d->lamp_objects[d->lamp_object_count - 1];
    last->box = box_union(last->box, box);
    last->count++;
    d->lamp[d->lamp_count++] = face;
}

static void sort_faces(Direct *d, Arena *arena) {
    const Mesh *mesh = d->mesh;
    Box *boxes = ARENA_ARRAY(arena, Box, mesh->face_count + 1);
    d->size = ARENA_ARRAY(arena, double, mesh->face_count + 1);
    d->lamp = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    d->lamp_objects = ARENA_ARRAY(arena, LampObject, mesh->face_count + 1);
    d->place = ARENA_ARRAY(arena, Vec3, mesh->outline_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        boxes[f] = box_empty();
        for (int i = 0; i < face->vertex_count; i++)
            boxes[f] = box_add(boxes[f], d->place[face->first_vertex + i] =
                                             mesh->vertices[mesh->outline[face->first_vertex + i]]);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++)
            d->size[f] += mesh->elements[e].area;
        if (face->hidden) boxes[f] = box_empty();
        if (mesh_emits(mesh, f) && !face->hidden) add_lamp(d, f, boxes[f]);
    }
    d->tree = box_tree_build(boxes, mesh->face_count, arena);
}

// Patches times the faces of lamps that they may see. Faces of an object follow each other.
double direct_pairs(const Direct *d) {
    double pairs = 0;
    for (int f = 0, object = -1, faces = 0; f < d->mesh->face_count; f++) {
        const Face *face = &d->mesh->faces[f];
        if (face->object != object) {
            object = face->object;
            faces = 0;
            for (int i = -1; (i = lamp_ways_next(d->ways, object, i)) >= 0;)
                faces += d->lamp_objects[i].count;
        }
        if (mesh_owns(d->mesh, f)) pairs += (double)faces * face->patch_count;
    }
    return pairs;
}

void direct_start(Direct *d, const Mesh *mesh, const StabForest *forest, const Nodes *nodes,
                  const Daylight *day, Arena *arena) {
    *d = (Direct){.mesh = mesh, .nodes = nodes, .lamps = true};
    d->sun = sun_nodes_new(mesh, day, arena);
    sort_faces(d, arena);
    int *object = ARENA_ARRAY(arena, int, d->lamp_object_count + 1);
    for (int i = 0; i < d->lamp_object_count; i++) object[i] = d->lamp_objects[i].object;
    d->ways = lamp_ways_new(mesh->graph, forest, object, d->lamp_object_count, arena);
    make_groups(d, arena);
}

// How many corners share in the light of a node: it is the light of its first corner where all its elements lie in one plane, else the mean
// of all corners.
static int sharing_corners(const Direct *d, int node) {
    return in_one_plane(d, node) ? 1 : d->nodes->first[node + 1] - d->nodes->first[node];
}

typedef struct Sharing {
    const Direct *d;
    int *count;  // [node_count]
} Sharing;
enum { NODES_A_GROUP = 4096 };

static void count_sharing(void *context, int group, int thread) {
    (void)thread;
    const Sharing *s = context;
    int first = group * NODES_A_GROUP, end = first + NODES_A_GROUP;
    for (int n = first; n < end && n < s->d->nodes->count; n++) s->count[n] = sharing_corners(s->d, n);
}

static void join_corners(const Direct *d, double (*out)[3]) {
    const Mesh *mesh = d->mesh;
    Arena scratch = {0};
    int nodes = d->nodes->count;
    Sharing sharing = {d, ARENA_ARRAY(&scratch, int, nodes + 1)};
    parallel_for(d->threads, (nodes + NODES_A_GROUP - 1) / NODES_A_GROUP, count_sharing, &sharing);
    memset(out, 0, (size_t)nodes * sizeof *out);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            int node = d->nodes->of_corner[c];
            for (int k = 0; k < 3; k++) out[node][k] += d->at_corner[c][k] / sharing.count[node];
        }
    }
    arena_free(&scratch);
}

static bool node_is_settled(const Direct *d, int node) {
    for (int i = d->nodes->first[node]; i < d->nodes->first[node + 1]; i++)
        if (!d->settled[d->mesh->elements[d->nodes->element[i]].patch]) return false;
    return true;
}

void direct_node_sources(const Direct *d, bool anew, const PointSources **out) {
    const Mesh *mesh = d->mesh;
    Worker *w = &d->workers[0];
    for (int n = 0; n < d->nodes->count; n++) {
        if (anew && node_is_settled(d, n)) continue;
        int first = d->nodes->first[n], count = sharing_corners(d, n);
        w->by_count = 0;
        out[n] = NULL;
        for (int i = first; i < d->nodes->first[n + 1]; i++) {
            const Element *e = &mesh->elements[d->nodes->element[i]];
            for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++) {
                const PointSources *by = d->nodes->of_corner[c] == n ? d->corner_by[c] : NULL;
                if (by && count == 1) out[n] = by;
                for (int k = 0; by && count > 1 && k < by->count; k++) {
                    double light[3];
                    for (int a = 0; a < 3; a++) light[a] = (double)by->by[k].light[a] / count;
                    note_source(w, by->by[k].source, light);
                }
            }
        }
        w->touched = NULL;
        if (count > 1) out[n] = keep_sources(w, NULL);
    }
}

bool direct_light(Direct *d, int threads, const Progress *progress, double (*out)[3], RadReport *report) {
    d->threads = parallel_threads(threads);
    d->workers = ARENA_ARRAY(&d->arena, Worker, d->threads);
    for (int t = 0; t < d->threads; t++) {
        d->workers[t].flood = lamp_flood_new(d->ways, &d->arena);
        if (d->sun) d->workers[t].sun = sun_patch_new(d->sun, &d->workers[t].arena);
        d->workers[t].of_node = ARENA_ARRAY(&d->arena, NodeLight, d->nodes->count + 1);
        if (d->besides) d->workers[t].finder = bend_finder_new(&d->arena);
        if (d->source_of) d->workers[t].kept = &d->kept[t];
    }
    if (d->source_of && !d->corner_by)
        d->corner_by = arena_alloc(&d->arena, (size_t)d->mesh->corner_count + 1, sizeof *d->corner_by);
    if (!d->at_corner)
        d->at_corner = arena_alloc(&d->arena, (size_t)d->mesh->corner_count + 1, sizeof *d->at_corner);
    bool go_on = true;
    for (d->first = 0; d->first < d->batch_count && go_on; d->first += BATCHES_A_LOOK) {
        int left = d->batch_count - d->first;
        go_on = progress_report(progress, "direct light", (double)d->first / d->batch_count);
        if (go_on) parallel_for(d->threads, left < BATCHES_A_LOOK ? left : BATCHES_A_LOOK, light_batch, d);
    }
    for (int t = 0; t < d->threads; t++) {
        report->direct_points += d->workers[t].report.direct_points;
        report->direct_pairs += d->workers[t].report.direct_pairs;
        report->direct_cut += d->workers[t].report.direct_cut;
    }
    if (go_on && out) join_corners(d, out);
    return go_on;
}

void direct_end(Direct *d) {
    for (int t = 0; t < d->threads; t++) {
        arena_free(&d->workers[t].arena);
        arena_free(&d->workers[t].bends);
    }
    arena_free(&d->arena);
    d->at_corner = NULL;
    d->corner_by = NULL;
    d->threads = 0;
}

// ---- doors that moved

typedef struct Settling {
    Direct *d;
    const MovedDoors *moved;
    Vec3 sun;
    bool any_sun;
    bool *turned;       // [lamp_object_count] moves with one of these doors
    LampFlood **flood;  // [threads]
    int **room;         // [threads] for three lists of objects of lamps
} Settling;

static bool is_met_by_doors(const Shaft *shaft, const MovedDoors *moved) {
    for (int i = 0; i < moved->count; i++) {
        for (int k = 0; k < 2; k++) {
            Vec3 corner[8];
            if (box_is_empty(moved->doors[i].box[k])) continue;
            box_corners(box_grow(moved->doors[i].box[k], LONGEST_HAIR), corner);
            if (shaft_is_met(shaft, corner, 8)) return true;
        }
    }
    return false;
}

// May anything between two boxes meet one of the doors? All that is between them lies in the box about both.
static bool is_near_doors(Box a, Box b, const MovedDoors *moved) {
    Box both = box_grow(box_union(a, b), LONGEST_HAIR);
    for (int i = 0; i < moved->count; i++)
        for (int k = 0; k < 2; k++) {
            Box door = moved->doors[i].box[k];
            if (!box_is_empty(door) && box_overlap(both, door)) return true;
        }
    return false;
}

// Does the sun's beam to any point of a box meet another one? The box is a point where the other one is larger by its size.
static bool beam_meets(Box from, Vec3 sun, Box door) {
    const double at[3] = {from.min.x, from.min.y, from.min.z}, along[3] = {sun.x, sun.y, sun.z},
                 low[3] = {door.min.x + from.min.x - from.max.x, door.min.y + from.min.y - from.max.y,
                           door.min.z + from.min.z - from.max.z},
                 high[3] = {door.max.x, door.max.y, door.max.z};
    double t0 = 0, t1 = INFINITY;
    for (int c = 0; c < 3; c++) {
        if (along[c] == 0) {
            if (at[c] < low[c] || at[c] > high[c]) return false;
            continue;
        }
        double a = (low[c] - at[c]) / along[c], b = (high[c] - at[c]) / along[c];
        t0 = fmax(t0, fmin(a, b));
        t1 = fmin(t1, fmax(a, b));
    }
    return t0 <= t1;
}

static bool beams_meet(const Settling *s, Box box) {
    for (int i = 0; i < s->moved->count && s->any_sun; i++)
        for (int k = 0; k < 2; k++) {
            Box door = s->moved->doors[i].box[k];
            if (!box_is_empty(door) && beam_meets(box, s->sun, box_grow(door, LONGEST_HAIR))) return true;
        }
    return false;
}

static bool moves_with(const Mesh *mesh, int object, const MovedDoors *moved) {
    return mesh_leaf_moves(moved, mesh->graph->building, mesh->graph->objects[object].leaf);
}

// The sources of an object of lamps, as bits.
static void touch_lamp(const Direct *d, int lamp, uint64_t *bits) {
    const LampObject *l = &d->lamp_objects[lamp];
    for (int k = l->first; k < l->first + l->count; k++) {
        int source = d->source_of[d->lamp[k]];
        if (source >= 0) bits[source / 64] |= (uint64_t)1 << source % 64;
    }
}

// May doors stand between anything in the box and a lamp? Of the lamps asked, an object each, those where they may are put into `found`
// [*count].
static void lamps_that_change(const Settling *s, LampFlood *flood, int object, Box box, const int *asked,
                              int asked_count, int *found, int *count) {
    const Direct *d = s->d;
    *count = 0;
    for (int i = 0; i < asked_count; i++) {
        int lamp = asked[i];
        if (!s->turned[lamp] && !is_near_doors(box, d->lamp_objects[lamp].box, s->moved)) continue;
        Shaft shaft = shaft_of_boxes(box, d->lamp_objects[lamp].box);
        bool meets = s->turned[lamp] || is_met_by_doors(&shaft, s->moved);
        if (meets && lamp_flood_reaches(flood, &shaft, object, d->lamp_objects[lamp].object))
            found[(*count)++] = lamp;
    }
}

static Box box_of_patch(const Mesh *mesh, const Patch *patch) {
    Box box = box_empty();
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const int *corner = mesh->corners + mesh->elements[e].first_corner;
        for (int i = 0; i < mesh->elements[e].corner_count; i++)
            box = box_add(box, mesh->vertices[corner[i]]);
    }
    return box_grow(box, LONGEST_HAIR);
}

// All light of a patch is to be found anew, or only that of some lamps, and of the sun or not.
static void settle_patch(const Settling *s, int patch, bool all, const int *lamp, int count, bool sun) {
    Direct *d = s->d;
    d->settled[patch] = !all && count == 0 && !sun;
    if (!d->touched || d->settled[patch]) return;
    uint64_t *bits = d->touched + (size_t)patch * (size_t)d->touched_words;
    if (all) memset(bits, 0xff, (size_t)d->touched_words * sizeof *bits);
    for (int i = 0; i < count; i++) touch_lamp(d, lamp[i], bits);
    if (sun) bits[d->day / 64] |= (uint64_t)1 << d->day % 64;
}

static void settle_batch(void *context, int index, int thread) {
    const Settling *s = context;
    const Direct *d = s->d;
    const Batch *batch = &d->batches[index];
    int object = d->mesh->faces[d->groups[batch->first_group].face].object, asked = 0, some, few;
    int *lamps = s->room[thread], *of_batch = lamps + d->lamp_object_count,
        *of_patch = of_batch + d->lamp_object_count;
    Box all = box_of_groups(d, batch);
    bool own = moves_with(d->mesh, object, s->moved), sun = !own && beams_meet(s, all);
    for (int i = -1; !own && d->lamps && (i = lamp_ways_next(d->ways, object, i)) >= 0;) lamps[asked++] = i;
    lamps_that_change(s, s->flood[thread], object, all, lamps, asked, of_batch, &some);
    for (int g = batch->first_group; g < batch->first_group + batch->group_count; g++) {
        const Group *group = &d->groups[g];
        for (int p = group->first_patch; p < group->first_patch + group->patch_count; p++) {
            Box box = some > 0 || sun ? box_of_patch(d->mesh, &d->mesh->patches[p]) : all;
            lamps_that_change(s, s->flood[thread], object, box, of_batch, some, of_patch, &few);
            settle_patch(s, p, own, of_patch, few, sun && beams_meet(s, box));
        }
    }
}

// The source of all faces of an object of lamps, -1: there are several.
static int source_of_object(const Direct *d, const LampObject *l) {
    int source = d->source_of[d->lamp[l->first]];
    for (int k = l->first; k < l->first + l->count; k++)
        if (d->source_of[d->lamp[k]] != source) return -1;
    return source;
}

void direct_settle(Direct *d, const MovedDoors *moved, const Daylight *day, int threads) {
    const Mesh *mesh = d->mesh;
    Arena scratch = {0};
    int lamps = d->lamp_object_count;
    threads = parallel_threads(threads);
    Settling s = {.d = d, .moved = moved, .sun = day->sun, .any_sun = d->sun != NULL};
    d->settled = ARENA_ARRAY(&d->arena, bool, mesh->patch_count + 1);
    d->known = ARENA_ARRAY(&d->arena, bool, mesh->corner_count + 1);
    if (d->source_of) {
        d->touched_words = d->day / 64 + 1;
        d->touched =
            ARENA_ARRAY(&d->arena, uint64_t, (size_t)mesh->patch_count * (size_t)d->touched_words + 1);
        for (int i = 0; i < lamps; i++) d->lamp_objects[i].source = source_of_object(d, &d->lamp_objects[i]);
    }
    s.turned = ARENA_ARRAY(&scratch, bool, lamps + 1);
    for (int i = 0; i < lamps; i++) s.turned[i] = moves_with(mesh, d->lamp_objects[i].object, moved);
    s.flood = ARENA_ARRAY(&scratch, LampFlood *, threads);
    s.room = ARENA_ARRAY(&scratch, int *, threads);
    for (int t = 0; t < threads; t++) {
        s.flood[t] = lamp_flood_new(d->ways, &scratch);
        s.room[t] = ARENA_ARRAY(&scratch, int, 3 * lamps + 1);
    }
    parallel_for(threads, d->batch_count, settle_batch, &s);
    for (int e = 0; e < mesh->element_count; e++)
        for (int c = 0; c < mesh->elements[e].corner_count; c++)
            d->known[mesh->elements[e].first_corner + c] = d->settled[mesh->elements[e].patch];
    arena_free(&scratch);
}

void direct_forget(const Direct *d, int patch, const PointSources **by) {
    const uint64_t *touched = touched_of(d, patch);
    const PointSources *from = *by;
    int left = 0;
    for (int i = 0; from && i < from->count; i++) left += !has_bit(touched, from->by[i].source);
    if (!from || left == from->count) return;
    PointSources *out = NULL;
    if (left > 0) {
        out = arena_alloc(&d->kept[0], sizeof *out + (size_t)left * sizeof *out->by, 1);
        for (int i = 0; i < from->count; i++)
            if (!has_bit(touched, from->by[i].source)) out->by[out->count++] = from->by[i];
    }
    *by = out;
}
