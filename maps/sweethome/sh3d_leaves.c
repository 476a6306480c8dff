// sh3d_leaves.c - the leaves that the models of doors draw, and how they move.
//
// The program's own models name their moving parts (`sweethome3d_opening_on_hinge_1_door`, `sweethome3d_window_pane_on_rail_2`) and the
// hinges they turn on (`sweethome3d_hinge_1_2`). In other models, also older ones of the program, the leaf is the part that stands in the
// way, or sticks out of the wall, with what is fixed to it.
//
// Everything is found in the piece's own frame: x to its right, y to its back, the origin in its middle.
#include <stdlib.h>
#include <string.h>

#include "engine/core/sets.h"
#include "maps/sweethome/sh3d_pieces.h"

// A leaf turned by more than this from the plane of its door is drawn open, radians.
static const double DRAWN_OPEN = 0.3;
// A person passes this part of a doorway, in shares of its half width and of its height: a face in the middle of it belongs
// to the leaf.
static const double WAY_HALF = 0.6, WAY_LOW = 0.2, WAY_HIGH = 0.7;
// A face of a leaf covers something between these heights, in shares of the door's height, where a face of a frame has only its head and
// its sill.
static const double ABOVE_SILL = 0.03, BELOW_HEAD = 0.9;
// A part this deep (over the width) and this high (over the height) is a leaf standing open.
static const double OPEN_DEPTH = 0.3, OPEN_HEIGHT = 0.6;
// As thick as a leaf counts where handles stick out, and as thin; metres.
static const double THICKEST = 0.08, THINNEST = 0.02;
// A handle and its like on a leaf stand out by this at most, and their edges lie within this of the leaf's; metres.
static const double HANDLE = 0.1, HANDLE_EDGE = 0.01;

typedef struct Finder {
    Sh3d *s;
    const Piece *p;
    const ObjModel *m;
    const Vec3 *placed;
    SketchOpening *o;
    Leaves *leaves;
    int *piece;                     // [vertex_count] see find_pieces; NULL where leaves are found by names
    int number[SKETCH_MAX_LEAVES];  // of the part's name
    bool on_rail[SKETCH_MAX_LEAVES];
} Finder;

static Vec3 to_own(const Piece *p, Vec3 v) {
    double c = cos(p->angle), s = sin(p->angle), x = v.x - p->at.x, y = v.y - p->at.y;
    return vec3(c * x + s * y, c * y - s * x, v.z - p->z);
}

static Vec2 to_plan(const Piece *p, Vec2 v) {
    double c = cos(p->angle), s = sin(p->angle);
    return vec2(p->at.x + c * v.x - s * v.y, p->at.y + s * v.x + c * v.y);
}

static Box face_box(const Finder *f, int face) {
    const ObjFace *at = &f->m->faces[face];
    Box box = box_empty();
    for (int k = 0; k < at->corner_count; k++)
        box = box_add(box, to_own(f->p, f->placed[f->m->corners[at->first_corner + k]]));
    return box;
}

static Box leaf_extent(const Finder *f, int leaf) {
    Box box = box_empty();
    for (int i = 0; i < f->m->face_count; i++) {
        if (f->leaves->part[i] == leaf) box = box_union(box, face_box(f, i));
    }
    return box;
}

// ---- parts by name

// The number in `..._on_hinge_2_door` or `..._on_rail_2`, 0 if there is none.
static int part_number(const char *group, bool *on_rail) {
    const char *hinge = strstr(group, "_on_hinge_"), *rail = strstr(group, "_on_rail_");
    *on_rail = rail != NULL;
    if (!strstr(group, "sweethome3d_") || (!hinge && !rail)) return 0;
    return (int)strtol(rail ? rail + strlen("_on_rail_") : hinge + strlen("_on_hinge_"), NULL, 10);
}

static void find_by_name(Finder *f) {
    for (int i = 0; i < f->m->face_count; i++) {
        bool on_rail;
        int number = part_number(f->m->groups[f->m->faces[i].group], &on_rail), leaf = 0;
        f->leaves->part[i] = FRAME;
        if (number <= 0) continue;
        while (leaf < f->o->leaf_count && (f->number[leaf] != number || f->on_rail[leaf] != on_rail)) leaf++;
        if (leaf == SKETCH_MAX_LEAVES) continue;
        if (leaf == f->o->leaf_count) f->o->leaf_count++;
        f->number[leaf] = number;
        f->on_rail[leaf] = on_rail;
        f->leaves->part[i] = leaf;
    }
}

// The middle of the parts named after the hinge; false if there are none.
static bool find_hinge(const Finder *f, int number, Vec2 *out) {
    char name[64];
    int length = snprintf(name, sizeof name, "sweethome3d_hinge_%d", number);
    Box box = box_empty();
    for (int i = 0; i < f->m->face_count; i++) {
        const char *at = strstr(f->m->groups[f->m->faces[i].group], name);
        if (at && (at[length] < '0' || at[length] > '9')) box = box_union(box, face_box(f, i));
    }
    if (box_is_empty(box)) return false;
    *out = vec2((box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2);
    return true;
}

// ---- leaves by the names of their parts

typedef struct Corner {
    Vec3 at;
    int vertex;
} Corner;

static int vertices_by_place(const void *p, const void *q) {
    const Vec3 *a = &((const Corner *)p)->at, *b = &((const Corner *)q)->at;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return (a->z > b->z) - (a->z < b->z);
}

// The connected piece that each vertex belongs to: by faces, and by vertices in the same place.
static int *find_pieces(const Finder *f) {
    const ObjModel *m = f->m;
    int *parent = ARENA_ARRAY(f->s->arena, int, m->vertex_count + 1);
    Corner *corners = ARENA_ARRAY(f->s->arena, Corner, m->vertex_count + 1);
    for (int i = 0; i < m->vertex_count; i++) {
        parent[i] = i;
        corners[i] = (Corner){f->placed[i], i};
    }
    qsort(corners, (size_t)m->vertex_count, sizeof *corners, vertices_by_place);
    for (int i = 1; i < m->vertex_count; i++) {
        if (vec3_equal(corners[i].at, corners[i - 1].at))
            set_join(parent, corners[i - 1].vertex, corners[i].vertex);
    }
    for (int i = 0; i < m->face_count; i++) {
        const int *corner = m->corners + m->faces[i].first_corner;
        for (int k = 1; k < m->faces[i].corner_count; k++) set_join(parent, corner[0], corner[k]);
    }
    for (int i = 0; i < m->vertex_count; i++) parent[i] = set_find(parent, i);
    return parent;
}

// Does the face cover any place at x between sill and head? `x`: the middle of the face's box. The face of a frame goes round the way: the
// middle of its box is in the way, too, but no part of the face is. A face that is seen edge-on counts as one that covers the way.
static bool covers_way(const Finder *f, int face, double x) {
    const ObjFace *at = &f->m->faces[face];
    double low = ABOVE_SILL * f->p->height, high = BELOW_HEAD * f->p->height;
    int crossings = 0, above = 0;
    for (int k = 0; k < at->corner_count; k++) {
        const int *corner = f->m->corners + at->first_corner;
        Vec3 a = to_own(f->p, f->placed[corner[k]]);
        Vec3 b = to_own(f->p, f->placed[corner[(k + 1) % at->corner_count]]);
        if ((a.x > x) == (b.x > x)) continue;
        double z = a.z + (b.z - a.z) * (x - a.x) / (b.x - a.x);
        if (z > low && z < high) return true;
        crossings++;
        above += z > low;
    }
    return crossings == 0 || above % 2 == 1;
}

static bool in_the_way(const Finder *f, int face, Box box) {
    Vec3 middle = vec3_lerp(box.min, box.max, 0.5);
    return fabs(middle.x) < WAY_HALF * f->p->width / 2 && middle.z > WAY_LOW * f->p->height &&
           middle.z < WAY_HIGH * f->p->height && covers_way(f, face, middle.x);
}

static void find_by_place(Finder *f) {
    const ObjModel *m = f->m;
    int *piece = f->piece = find_pieces(f);
    Box *extent = ARENA_ARRAY(f->s->arena, Box, m->vertex_count + 1);
    bool *moves = ARENA_ARRAY(f->s->arena, bool, m->vertex_count + 1);
    for (int i = 0; i < m->vertex_count; i++) extent[i] = box_empty();
    for (int i = 0; i < m->face_count; i++) {
        int at = piece[m->corners[m->faces[i].first_corner]];
        Box box = face_box(f, i);
        extent[at] = box_union(extent[at], box);
        moves[at] = moves[at] || in_the_way(f, i, box);
    }
    for (int i = 0; i < m->face_count; i++) {
        int at = piece[m->corners[m->faces[i].first_corner]];
        Vec3 size = vec3_sub(extent[at].max, extent[at].min);
        bool open = size.y > OPEN_DEPTH * f->p->width && size.z > OPEN_HEIGHT * f->p->height;
        bool right = extent[at].min.x + extent[at].max.x > 0;
        f->leaves->part[i] = !moves[at] && !open ? FRAME : f->o->hinge == 2 && right ? 1 : 0;
        if (f->leaves->part[i] >= f->o->leaf_count) f->o->leaf_count = f->leaves->part[i] + 1;
    }
}

// ---- how they move

// A leaf that slides goes over the next one, or aside by its own width where there is none; the others stay.
static void set_slide(const Finder *f, int leaf, Box box) {
    Leaf *l = &f->o->leaves[leaf];
    double middle = (box.min.x + box.max.x) / 2, nearest = INFINITY, way = box.max.x - box.min.x;
    for (int i = 0; i < f->o->leaf_count; i++) {
        if (i == leaf || !f->on_rail[i]) continue;
        if (f->number[i] < f->number[leaf]) return;
        Box other = leaf_extent(f, i);
        double to = (other.min.x + other.max.x) / 2 - middle;
        if (fabs(to) < fabs(nearest)) nearest = to;
    }
    if (isfinite(nearest)) way = nearest;
    l->slide = vec2_sub(to_plan(f->p, vec2(way, 0)), f->p->at);
}

static void set_turn(const Finder *f, int leaf, Box box, Vec2 *pivot) {
    SketchOpening *o = f->o;
    Leaf *l = &o->leaves[leaf];
    Vec2 middle = vec2((box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2);
    bool known = find_hinge(f, f->number[leaf], pivot);
    int end = known ? pivot->x > 0 : o->hinge == 2 ? middle.x > 0 : o->hinge;
    bool out = box.max.y - box.min.y > OPEN_DEPTH * f->p->width;
    if (!known) {
        // A leaf that stands open has its hinge at the end near the wall.
        double wall = fabs(box.min.y) < fabs(box.max.y) ? box.min.y : box.max.y;
        *pivot = vec2(end ? box.max.x : box.min.x, out ? wall : middle.y);
    }
    double side = end ? -1 : 1;
    Vec2 to = vec2_sub(middle, *pivot);
    double drawn = atan2(side * to.y, side * to.x);
    l->turn = o->hinge == 2 && end == 1 ? -o->swing : o->swing;
    if (fabs(drawn) < DRAWN_OPEN) return;
    if (l->turn * drawn < 0 || fabs(l->turn) < fabs(drawn)) l->turn = drawn;
    f->leaves->drawn[leaf] = drawn / l->turn;
    o->open = fmax(o->open, drawn / l->turn);
}

static void set_motion(const Finder *f, int leaf) {
    Leaf *l = &f->o->leaves[leaf];
    Box box = leaf_extent(f, leaf);
    Vec2 pivot = vec2((box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2);
    *l = (Leaf){.z0 = f->p->z + box.min.z, .z1 = f->p->z + box.max.z};
    if (f->on_rail[leaf]) {
        set_slide(f, leaf, box);
    } else {
        set_turn(f, leaf, box, &pivot);
    }
    l->pivot = to_plan(f->p, pivot);
}

const Vec3 *sh3d_close_leaf(Sh3d *s, const ObjModel *m, const Vec3 *placed, const Leaves *leaves, int leaf,
                            const SketchOpening *o) {
    if (leaves->drawn[leaf] == 0) return placed;
    Vec3 *out = ARENA_ARRAY(s->arena, Vec3, m->vertex_count + 1);
    memcpy(out, placed, (size_t)m->vertex_count * sizeof *out);
    for (int i = 0; i < m->face_count; i++) {
        const ObjFace *f = &m->faces[i];
        for (int k = 0; leaves->part[i] == leaf && k < f->corner_count; k++) {
            int v = m->corners[f->first_corner + k];
            out[v] = leaf_point(&o->leaves[leaf], -leaves->drawn[leaf], placed[v]);
        }
    }
    return out;
}

static Box closed_extent(const Finder *f, int leaf) {
    Finder shut = *f;
    shut.placed = sh3d_close_leaf(f->s, f->m, f->placed, f->leaves, leaf, f->o);
    return leaf_extent(&shut, leaf);
}

// Its plan box when closed.
static void set_box(const Finder *f, int leaf) {
    Leaf *l = &f->o->leaves[leaf];
    Box box = closed_extent(f, leaf);
    double y = (box.min.y + box.max.y) / 2;
    Vec2 left = to_plan(f->p, vec2(box.min.x, y)), right = to_plan(f->p, vec2(box.max.x, y));
    bool hung_left = vec2_length(vec2_sub(l->pivot, left)) <= vec2_length(vec2_sub(l->pivot, right));
    l->axis[0] = hung_left ? left : right;
    l->axis[1] = hung_left ? right : left;
    l->thickness = fmin(fmax(box.max.y - box.min.y, THINNEST), THICKEST);
}

// Pieces that lie on the closed leaf go with it, not with the frame.
static void take_handles(const Finder *f, int leaf) {
    const ObjModel *m = f->m;
    Vec3 edge = vec3(HANDLE_EDGE, HANDLE, HANDLE_EDGE);
    Box of_leaf = closed_extent(f, leaf), *extent = ARENA_ARRAY(f->s->arena, Box, m->vertex_count + 1);
    of_leaf = (Box){vec3_sub(of_leaf.min, edge), vec3_add(of_leaf.max, edge)};
    for (int i = 0; i < m->vertex_count; i++) extent[i] = box_empty();
    for (int i = 0; i < m->vertex_count; i++) {
        Vec3 closed = leaf_point(&f->o->leaves[leaf], -f->leaves->drawn[leaf], f->placed[i]);
        extent[f->piece[i]] = box_add(extent[f->piece[i]], to_own(f->p, closed));
    }
    for (int i = 0; i < m->face_count; i++) {
        Box at = extent[f->piece[m->corners[m->faces[i].first_corner]]];
        if (f->leaves->part[i] == FRAME && box_contains(of_leaf, at.min) && box_contains(of_leaf, at.max))
            f->leaves->part[i] = leaf;
    }
}

// A leaf of no extent has no box: it stays with the frame.
static void drop_thin(Finder *f) {
    for (int leaf = 0; leaf < f->o->leaf_count; leaf++) {
        Box box = leaf_extent(f, leaf);
        double breadth = hypot(box.max.x - box.min.x, box.max.y - box.min.y);
        if (breadth >= MAPS_GRID && box.max.z - box.min.z >= MAPS_GRID) continue;
        for (int i = 0; i < f->m->face_count; i++) {
            if (f->leaves->part[i] == leaf) f->leaves->part[i] = FRAME;
            if (f->leaves->part[i] > leaf) f->leaves->part[i]--;
        }
        for (int k = leaf; k + 1 < f->o->leaf_count; k++) {
            f->number[k] = f->number[k + 1];
            f->on_rail[k] = f->on_rail[k + 1];
        }
        f->o->leaf_count--;
        leaf--;
    }
}

Leaves sh3d_find_leaves(Sh3d *s, const Piece *p, const ObjModel *m, const Vec3 *placed, SketchOpening *o) {
    Leaves leaves = {.part = ARENA_ARRAY(s->arena, int, m->face_count + 1)};
    Finder f = {.s = s, .p = p, .m = m, .placed = placed, .o = o, .leaves = &leaves};
    find_by_name(&f);
    if (o->leaf_count == 0) find_by_place(&f);
    drop_thin(&f);
    for (int leaf = 0; leaf < o->leaf_count; leaf++) set_motion(&f, leaf);
    for (int leaf = 0; leaf < o->leaf_count; leaf++) set_box(&f, leaf);
    for (int leaf = 0; f.piece && leaf < o->leaf_count; leaf++) take_handles(&f, leaf);
    return leaves;
}
