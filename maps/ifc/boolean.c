// boolean.c - union, difference and intersection of bodies by trees of planes (B. Naylor, J. Amanatides & W. Thibault 1990, "Merging BSP
// trees yields polyhedral set operations"). Each face of one body is cut at the other one's tree; it stays where the result has it on its
// boundary. Departure: pieces of a face that turn out alike are put together again, and many tools are subtracted at once, so that a
// wall with twenty windows is cut once.
#include "maps/ifc/shape.h"

#include <stdint.h>
#include <stdlib.h>

#include "engine/core/polygon.h"

enum {
    CANDIDATES = 6,      // planes tried for a node
    LEAF_OUT = -1,       // in front of the last plane
    LEAF_IN = -2,        // behind it
    MOST_CORNERS = 512,  // of a piece
    MOST_DEPTH = 3000,   // cuts within cuts of a face
    MANY = 64,           // faces: as many are parted by planes across them
    SMALL = 48,          // faces: larger bodies are looked at only around the tool
};
static const long long MOST_WORK = 60000000;  // corners looked at, about 10 ns each
// Memory stays until the product is done, so a corner that is cut and a piece that is kept count for more.
static const long long CUT_WORK = 12, PIECE_WORK = 6;
// Farther away the digits of a double hold no tenth of the tolerance: faces would be cut for ever, metres.
static const double FARTHEST = 1e8;

typedef struct Node {
    Plane plane;
    int front, back;
} Node;

typedef struct Tree {
    Node *nodes;
    int count, room;
    int root;
} Tree;

// A face while it is cut.
typedef struct Piece {
    Vec3 *corners;
    int count, material, map;
    Plane plane;
} Piece;

typedef struct Pieces {
    Piece *piece;
    int *label;  // [count] LEAF_OUT or LEAF_IN, once classified
    int count, room, label_room;
} Pieces;

typedef struct Cutter {
    Arena *arena;
    long long work;
} Cutter;

static void push_piece(Cutter *c, Pieces *list, Piece piece, int label) {
    c->work += PIECE_WORK;
    int again = list->count;
    *ARENA_PUSH(c->arena, list->label, again, list->label_room) = label;
    *ARENA_PUSH(c->arena, list->piece, list->count, list->room) = piece;
}

// On which sides of a plane a piece has corners: 1 in front, 2 behind.
static int sides_of(Cutter *c, const Piece *p, Plane plane, double *distance) {
    int sides = 0;
    c->work += p->count;
    for (int i = 0; i < p->count; i++) {
        distance[i] = plane_distance(plane, p->corners[i]);
        sides |= distance[i] > SHAPE_EPSILON ? 1 : distance[i] < -SHAPE_EPSILON ? 2 : 0;
    }
    return sides;
}

// Cuts a piece that has corners on both sides. A piece that comes to nothing on a side counts as whole on the other.
static bool split(Cutter *c, const Piece *p, double *distance, Piece *front, Piece *back) {
    Vec3 *corners = ARENA_ARRAY(c->arena, Vec3, 2 * (p->count + 1));
    c->work += CUT_WORK * (p->count + 1);
    *front = *back = *p;
    front->corners = corners;
    front->count = polygon_clip_band(p->corners, distance, p->count, SHAPE_EPSILON, corners);
    for (int i = 0; i < p->count; i++) distance[i] = -distance[i];
    back->corners = corners + front->count;
    back->count = polygon_clip_band(p->corners, distance, p->count, SHAPE_EPSILON, back->corners);
    return front->count >= 3 && back->count >= 3;
}

// Where a piece lies: 0 in the plane, 1 in front, 2 behind, 3 on both sides, and then it is cut. No part of `classify`, which calls
// itself: the distances would take much of the stack.
__attribute__((noinline)) static int cut_at(Cutter *c, const Piece *p, Plane plane, Piece *front,
                                            Piece *back) {
    double distance[MOST_CORNERS];
    int sides = sides_of(c, p, plane, distance);
    if (sides != 3) return sides;
    if (p->count + 2 >= MOST_CORNERS || c->work > MOST_WORK) return 1;
    return split(c, p, distance, front, back) ? 3 : 1;
}

// ---- trees

// The plane that cuts few faces and leaves both sides alike.
static int choose_plane(Cutter *c, const Piece *list, int count) {
    if (count <= 2) return 0;
    double distance[MOST_CORNERS];
    int best = 0, step = count <= CANDIDATES ? 1 : count / CANDIDATES, sample = count <= 64 ? 1 : count / 64;
    long long least = INT64_MAX;
    for (int i = 0; i < count; i += step) {
        long long front = 0, back = 0, cut = 0;
        for (int k = 0; k < count; k += sample) {
            int sides = sides_of(c, &list[k], list[i].plane, distance);
            front += sides == 1;
            back += sides == 2;
            cut += sides == 3;
        }
        long long cost = 8 * cut + llabs(front - back);
        if (cost < least) {
            least = cost;
            best = i;
        }
    }
    return best;
}

// Many faces are first parted by a plane across them, which is no face's: a round body would be a tree as deep as it has faces. Both
// sides must have faces, from which their space learns whether it is inside.
static bool choose_across(Cutter *c, const Piece *list, int count, Plane *out) {
    if (count < MANY) return false;
    Box box = box_empty();
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        Vec3 p = list[i].corners[0];
        box = box_add(box, p);
        sum = vec3_add(sum, p);
    }
    c->work += count;
    Vec3 size = vec3_sub(box.max, box.min), mean = vec3_scale(sum, 1.0 / count);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    *out = axis == 0   ? (Plane){{1, 0, 0}, mean.x}
           : axis == 1 ? (Plane){{0, 1, 0}, mean.y}
                       : (Plane){{0, 0, 1}, mean.z};
    double distance[MOST_CORNERS];
    int front = 0, back = 0;
    for (int i = 0; i < count; i++) {
        int sides = sides_of(c, &list[i], *out, distance);
        front += sides != 2;
        back += sides >= 2;
    }
    return front > 0 && back > 0 && front < count - count / 5 && back < count - count / 5;
}

static int new_node(Cutter *c, Tree *tree, Plane plane) {
    Node *node = ARENA_PUSH(c->arena, tree->nodes, tree->count, tree->room);
    *node = (Node){plane, LEAF_OUT, LEAF_IN};
    return tree->count - 1;
}

typedef struct Task {
    Piece *list;
    int count, parent;
    bool front;
} Task;

// Makes the tree of faces, without recursion: a body of many faces is deep.
static bool make_tree(Cutter *c, Piece *list, int count, Tree *tree) {
    *tree = (Tree){.root = LEAF_OUT};
    Task *tasks = NULL;
    int task_count = 0, task_room = 0;
    if (count > 0) *ARENA_PUSH(c->arena, tasks, task_count, task_room) = (Task){list, count, -1, false};
    while (task_count > 0) {
        Task task = tasks[--task_count];
        if (c->work > MOST_WORK) return false;
        Plane plane;
        bool across = choose_across(c, task.list, task.count, &plane);
        if (!across) plane = task.list[choose_plane(c, task.list, task.count)].plane;
        int node = new_node(c, tree, plane);
        if (task.parent < 0) {
            tree->root = node;
        } else if (task.front) {
            tree->nodes[task.parent].front = node;
        } else {
            tree->nodes[task.parent].back = node;
        }
        Pieces front = {0}, back = {0};
        for (int i = 0; i < task.count; i++) {
            const Piece *p = &task.list[i];
            Piece a, b;
            int sides = cut_at(c, p, plane, &a, &b);
            if (sides == 3) {
                push_piece(c, &front, a, 0);
                push_piece(c, &back, b, 0);
            } else if (sides == 1 || (sides == 0 && across)) {
                push_piece(c, &front, *p, 0);
            } else if (sides == 2) {
                push_piece(c, &back, *p, 0);
            }
        }
        if (front.count)
            *ARENA_PUSH(c->arena, tasks, task_count, task_room) =
                (Task){front.piece, front.count, node, true};
        if (back.count)
            *ARENA_PUSH(c->arena, tasks, task_count, task_room) = (Task){back.piece, back.count, node, false};
    }
    return true;
}

enum { MIXED = 0 };

// Cuts a piece at the tree and appends what comes of it with its labels. Where it lies in a plane, the side decides that it is seen
// from: that to which its normal points (`plus`), or the other. Returns the label if all of it has the same.
static int classify(Cutter *c, const Tree *tree, int node, const Piece *p, bool plus, Pieces *out,
                    bool *touched, int depth) {
    while (node >= 0) {
        const Node *n = &tree->nodes[node];
        Piece a, b;
        int sides = cut_at(c, p, n->plane, &a, &b);
        if (sides == 0) {
            *touched = true;
            node = (vec3_dot(n->plane.n, p->plane.n) > 0) == plus ? n->front : n->back;
        } else if (sides == 1 || (sides == 3 && depth > MOST_DEPTH)) {
            node = n->front;
        } else if (sides == 2) {
            node = n->back;
        } else {
            int before = out->count, front_child = n->front, back_child = n->back;
            int one = classify(c, tree, front_child, &a, plus, out, touched, depth + 1);
            int two = classify(c, tree, back_child, &b, plus, out, touched, depth + 1);
            if (one == MIXED || one != two) return MIXED;
            out->count = before;
            push_piece(c, out, *p, one);
            return one;
        }
    }
    push_piece(c, out, *p, node);
    return node;
}

// ---- bodies

typedef struct Body {
    const Shape *shape;
    Piece *pieces;
    Box *boxes;  // [face_count] of each face, grown by the tolerance
    Box box;
    Tree tree;
    bool grown;  // the tree is made
} Body;

// `maps`: pictures stay on the faces that are left.
static bool begin_body(Cutter *c, Body *body, const Shape *shape, bool maps) {
    *body = (Body){.shape = shape, .box = box_grow(shape->box, SHAPE_EPSILON)};
    Vec3 low = shape->box.min, high = shape->box.max;
    if (!(fmin(fmin(low.x, low.y), low.z) > -FARTHEST && fmax(fmax(high.x, high.y), high.z) < FARTHEST))
        return false;
    if (c->work > MOST_WORK) return false;
    c->work += PIECE_WORK * shape->face_count;
    body->pieces = ARENA_ARRAY(c->arena, Piece, shape->face_count + 1);
    body->boxes = ARENA_ARRAY(c->arena, Box, shape->face_count + 1);
    for (int i = 0; i < shape->face_count; i++) {
        const ShapeFace *f = &shape->faces[i];
        if (f->count + 8 > MOST_CORNERS) return false;
        body->pieces[i] =
            (Piece){shape->corners + f->first, f->count, f->material, maps ? f->map : 0, f->plane};
        Box box = box_empty();
        for (int k = 0; k < f->count; k++) box = box_add(box, shape->corners[f->first + k]);
        body->boxes[i] = box_grow(box, SHAPE_EPSILON);
    }
    return true;
}

static bool grow_tree(Cutter *c, Body *body) {
    if (body->grown) return true;
    body->grown = true;
    return make_tree(c, body->pieces, body->shape->face_count, &body->tree);
}

static Box piece_box(const Piece *p) {
    Box box = box_empty();
    for (int i = 0; i < p->count; i++) box = box_add(box, p->corners[i]);
    return box;
}

// Is a point inside a body, by the parity of crossings of a half-line that is parallel to nothing?
static bool contains(Cutter *c, const Body *body, Vec3 p) {
    Vec3 along = vec3(0.5144957554275266, 0.3213938048432697, 0.7949308447);
    bool inside = false;
    for (int i = 0; i < body->shape->face_count; i++) {
        const Piece *f = &body->pieces[i];
        double slope = vec3_dot(f->plane.n, along);
        c->work += f->count;
        if (fabs(slope) < 1e-12) continue;
        double t = -plane_distance(f->plane, p) / slope;
        if (t < 0) continue;
        Vec3 q = vec3_add(p, vec3_scale(along, t));
        if (!box_contains(box_grow(body->boxes[i], SHAPE_EPSILON), q)) continue;
        bool in = true;
        for (int k = 0; k < f->count && in; k++) {
            Vec3 a = f->corners[k], b = f->corners[k + 1 == f->count ? 0 : k + 1];
            in = vec3_dot(f->plane.n, vec3_cross(vec3_sub(b, a), vec3_sub(q, a))) >= 0;
        }
        inside ^= in;
    }
    return inside;
}

// The tree of a large body around a box alone: of its faces as far as they lie within. Where there are none, `root` is a leaf.
static bool local_tree(Cutter *c, const Body *body, Box around, Tree *tree) {
    Box box = box_grow(around, 100 * SHAPE_EPSILON);
    Plane sides[6] = {{{1, 0, 0}, box.min.x},   {{-1, 0, 0}, -box.max.x}, {{0, 1, 0}, box.min.y},
                      {{0, -1, 0}, -box.max.y}, {{0, 0, 1}, box.min.z},   {{0, 0, -1}, -box.max.z}};
    Pieces kept = {0};
    for (int i = 0; i < body->shape->face_count; i++) {
        if (!box_overlap(body->boxes[i], box)) continue;
        Piece p = body->pieces[i];
        for (int k = 0; k < 6 && p.count >= 3; k++) {
            Vec3 *out = ARENA_ARRAY(c->arena, Vec3, p.count + 1);
            p.count = polygon_clip(p.corners, p.count, sides[k], 0, out);
            p.corners = out;
            c->work += p.count;
        }
        if (p.count >= 3 && polygon_area(p.corners, p.count) > SHAPE_SMALLEST_AREA)
            push_piece(c, &kept, p, 0);
    }
    if (kept.count) return make_tree(c, kept.piece, kept.count, tree);
    Vec3 middle = vec3_scale(vec3_add(box.min, box.max), 0.5);
    *tree = (Tree){.root = contains(c, body, middle) ? LEAF_IN : LEAF_OUT};
    return true;
}

static void keep_piece(Arena *arena, Shape *out, const Piece *p, bool flip) {
    if (polygon_area(p->corners, p->count) < SHAPE_SMALLEST_AREA) return;
    int first = out->face_count;
    shape_add_in_plane(arena, out, p->corners, p->count, p->material, p->plane);
    if (out->face_count > first) out->faces[first].map = p->map;
    if (!flip || out->face_count == first) return;
    Shape one = {.corners = out->corners, .faces = out->faces + first, .face_count = 1};
    shape_flip(&one);
}

// Replaces the list by those parts of it that have the label, seen from one side.
static void filter(Cutter *c, const Tree *tree, Box box, Pieces *list, bool plus, int label, bool *touched) {
    Pieces next = {0};
    for (int i = 0; i < list->count; i++) {
        Piece *p = &list->piece[i];
        if (!box_overlap(piece_box(p), box)) {
            if (label == LEAF_OUT) push_piece(c, &next, *p, LEAF_OUT);
            continue;
        }
        Pieces parts = {0};
        bool met = false;
        classify(c, tree, tree->root, p, plus, &parts, &met, 0);
        *touched |= met;
        for (int k = 0; k < parts.count; k++)
            if (parts.label[k] == label) push_piece(c, &next, parts.piece[k], label);
    }
    *list = next;
}

// The faces of a tool that bound the result: strictly inside `a` (or outside, of a union), and not within other tools.
static bool keep_tool_faces(Cutter *c, ShapeBoolean operation, Body *a, Body *tools, int tool_count, int at,
                            Shape *out) {
    Body *tool = &tools[at];
    Tree around, *tree = &a->tree;
    if (a->shape->face_count > SMALL && operation == SHAPE_DIFFERENCE) {
        if (!local_tree(c, a, tool->box, &around)) return false;
        tree = &around;
    } else if (!grow_tree(c, a)) {
        return false;
    }
    int label = operation == SHAPE_UNION ? LEAF_OUT : LEAF_IN;
    for (int i = 0; i < tool->shape->face_count; i++) {
        Pieces list = {0};
        bool touched = false, ignored = false;
        push_piece(c, &list, tool->pieces[i], 0);
        filter(c, tree, a->box, &list, true, label, &touched);
        if (touched) filter(c, tree, a->box, &list, false, label, &ignored);
        for (int k = 0; k < tool_count && list.count; k++) {
            if (k == at || !box_overlap(tools[k].box, tool->boxes[i])) continue;
            if (!grow_tree(c, &tools[k])) return false;
            touched = false;
            filter(c, &tools[k].tree, tools[k].box, &list, true, LEAF_OUT, &touched);
            // The first tool's face stays where two tools share one.
            if (touched && k < at) filter(c, &tools[k].tree, tools[k].box, &list, false, LEAF_OUT, &ignored);
        }
        for (int k = 0; k < list.count; k++)
            keep_piece(c->arena, out, &list.piece[k], operation == SHAPE_DIFFERENCE);
        if (c->work > MOST_WORK) return false;
    }
    return true;
}

static bool combine(Cutter *c, ShapeBoolean operation, Body *a, Body *tools, int tool_count, Shape *out) {
    for (int i = 0; i < a->shape->face_count; i++) {
        Pieces list = {0};
        push_piece(c, &list, a->pieces[i], 0);
        bool ignored = false;
        for (int k = 0; k < tool_count && list.count; k++) {
            bool meets = box_overlap(tools[k].box, a->boxes[i]);
            if (!meets) {
                if (operation == SHAPE_INTERSECTION) list.count = 0;
                continue;
            }
            if (!grow_tree(c, &tools[k])) return false;
            // Seen from inside `a`, or of a union from outside.
            filter(c, &tools[k].tree, tools[k].box, &list, operation == SHAPE_UNION,
                   operation == SHAPE_INTERSECTION ? LEAF_IN : LEAF_OUT, &ignored);
        }
        for (int k = 0; k < list.count; k++) keep_piece(c->arena, out, &list.piece[k], false);
        if (c->work > MOST_WORK) return false;
    }
    // A surface that encloses nothing gets no new faces.
    for (int k = 0; k < tool_count && a->shape->solid; k++)
        if (!keep_tool_faces(c, operation, a, tools, tool_count, k, out)) return false;
    return true;
}

bool shape_boolean(Arena *arena, ShapeBoolean operation, const Shape *a, const Shape *const *tools,
                   int tool_count, long long *work, Shape *out) {
    Cutter c = {.arena = arena, .work = *work};
    *out = *a;
    Body body, *bodies = ARENA_ARRAY(arena, Body, tool_count + 1);
    int near = 0;
    if (!begin_body(&c, &body, a, true)) return false;
    for (int i = 0; i < tool_count; i++) {
        bool meets = tools[i]->face_count > 0 && box_overlap(tools[i]->box, body.box);
        if (operation == SHAPE_DIFFERENCE && !meets) continue;
        if (!begin_body(&c, &bodies[near++], tools[i], false)) return false;
    }
    if (near == 0) return true;
    Shape result = shape_empty(a->solid);
    bool good = combine(&c, operation, &body, bodies, near, &result);
    *work = c.work;
    result.maps = a->maps;
    result.map_count = result.map_room = a->map_count;
    if (good) *out = result;
    return good;
}

Shape shape_half_space(Arena *arena, Box box, Plane plane) {
    Shape out = shape_empty(true);
    Vec3 corner[8], clipped[16];
    box_corners(box, corner);
    static const int FACES[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    Plane behind = {vec3_scale(plane.n, -1), -plane.d};
    Plane inside[6] = {{{1, 0, 0}, box.min.x},   {{-1, 0, 0}, -box.max.x}, {{0, 1, 0}, box.min.y},
                       {{0, -1, 0}, -box.max.y}, {{0, 0, 1}, box.min.z},   {{0, 0, -1}, -box.max.z}};
    for (int i = 0; i < 6; i++) {
        Vec3 face[4];
        for (int k = 0; k < 4; k++) face[k] = corner[FACES[i][k]];
        int count = polygon_clip(face, 4, behind, 0, clipped);
        shape_add(arena, &out, clipped, count, -1);
    }
    // The cut itself: a square of the plane, larger than the box, clipped to it.
    Vec3 middle = vec3_scale(vec3_add(box.min, box.max), 0.5);
    middle = vec3_sub(middle, vec3_scale(plane.n, plane_distance(plane, middle)));
    double reach = 2 * vec3_length(vec3_sub(box.max, box.min)) + 1;
    Vec3 n = plane.n, u = fabs(n.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    u = vec3_scale(vec3_normalize(vec3_cross(u, n)), reach);
    Vec3 v = vec3_cross(n, u),
         square[16] = {vec3_sub(vec3_sub(middle, u), v), vec3_sub(vec3_add(middle, u), v),
                       vec3_add(vec3_add(middle, u), v), vec3_add(vec3_sub(middle, u), v)};
    int count = 4;
    for (int i = 0; i < 6 && count; i++) {
        count = polygon_clip(square, count, inside[i], 0, clipped);
        memcpy(square, clipped, (size_t)count * sizeof(Vec3));
    }
    if (count >= 3 && polygon_area(square, count) > SHAPE_SMALLEST_AREA)
        shape_add_in_plane(arena, &out, square, count, -1, plane);
    return out;
}
