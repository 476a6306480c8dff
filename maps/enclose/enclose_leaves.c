// enclose_leaves.c - the leaves of doors: those of the model, or one leaf or two that fill the doorway, made as boxes. A glazed
// leaf is a frame around a pane, unless it is all of glass.
#include "maps/enclose/enclose.h"

// A leaf keeps this clear of jamb, sill and head, metres: more than VIS_TOUCH and than the planes' noise.
static const double INSET = 0.01;
// Metres; less where the wall is thin, by this share of its depth.
static const double THICKNESS = 0.04, THICKNESS_IN_WALL = 0.6;
// The frame of a glazed leaf, metres.
static const double STILE = 0.09, RAIL = 0.09, KICK = 0.2;
// Narrower leaves are not worth a frame, lower ones neither, metres.
static const double LEAST_GLAZED = 0.4;

// Turns about its hinged end, far enough from the jamb that its back clears it, or slides.
static Leaf make_leaf(const Opening *o, Vec2 hinge, Vec2 tip, double thickness, double turn, Vec2 slide) {
    Vec2 along = vec2_sub(tip, hinge);
    along = vec2_scale(along, 1 / vec2_length(along));
    Vec2 start = vec2_add(hinge, vec2_scale(along, INSET));
    return (Leaf){.pivot = vec2_add(start, vec2_scale(along, thickness / 2)),
                  .turn = turn,
                  .slide = slide,
                  .axis = {start, vec2_sub(tip, vec2_scale(along, INSET))},
                  .thickness = thickness,
                  .z0 = o->sill + INSET,
                  .z1 = o->head - INSET};
}

static int make_leaves(const SketchOpening *s, const Opening *o, double depth, Leaf *out) {
    double thickness = fmin(THICKNESS, depth * THICKNESS_IN_WALL);
    Vec2 along = vec2_sub(o->line[1], o->line[0]), middle = vec2_scale(vec2_add(o->line[0], o->line[1]), 0.5);
    double width = vec2_length(along);
    Vec2 slide = vec2_scale(along, s->slide / width);
    double turn = s->slide == 0 ? s->swing : 0;
    bool two = s->hinge == 2;
    if (width / (two ? 2 : 1) <= 4 * INSET + thickness || o->head - o->sill <= 4 * INSET) return 0;
    if (turn == 0 && s->slide == 0) return 0;
    if (!two) {
        int hinge = s->hinge == 1;
        out[0] = make_leaf(o, o->line[hinge], o->line[!hinge], thickness, turn, slide);
        return 1;
    }
    out[0] = make_leaf(o, o->line[0], middle, thickness, turn, vec2_scale(slide, -1));
    out[1] = make_leaf(o, o->line[1], middle, thickness, -turn, slide);
    return 2;
}

void leaves_append(Enclosure *e, int hole) {
    Building *b = e->b;
    const SketchOpening *s = &e->sketch->openings[hole];
    Opening *o = &b->openings[b->opening_count - 1];
    o->first_leaf = b->leaf_count;
    if (o->kind != OPENING_DOOR) return;
    Leaf leaves[SKETCH_MAX_LEAVES];
    memcpy(leaves, s->leaves, sizeof leaves);
    o->leaf_count = s->leaf_count;
    if (s->leaf_count == 0) {
        double depth = (e->holes[hole].v1 - e->holes[hole].v0) / ENCLOSE_MM;
        o->leaf_count = make_leaves(s, o, depth, leaves);
    }
    for (int i = 0; i < o->leaf_count; i++) {
        leaves[i].opening = b->opening_count - 1;
        *ARENA_PUSH(e->arena, b->leaves, b->leaf_count, b->leaf_capacity) = leaves[i];
    }
}

void leaves_assign(Enclosure *e) {
    for (int i = 0; i < e->b->object_count; i++) {
        Object *object = &e->b->objects[i];
        if (object->opening < 0) continue;
        const Hole *hole = &e->holes[object->opening];
        object->opening = hole->used ? hole->opening : -1;
        if (object->leaf < 0) continue;
        // Without its opening a leaf stands where it was drawn.
        object->leaf = hole->used ? object->leaf + e->b->openings[hole->opening].first_leaf : -1;
    }
}

// ---- polygons

// A box in the leaf's own frame: u along its axis, v up, w across.
static void add_leaf_box(Enclosure *e, const Leaf *leaf, Vec2 u, Vec2 v, double w, int material) {
    static const int SIDES[6][4] = {{0, 1, 5, 4}, {3, 2, 6, 7}, {0, 4, 6, 2},
                                    {1, 3, 7, 5}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
    along = vec2_scale(along, 1 / vec2_length(along));
    Vec3 corner[8];
    for (int i = 0; i < 8; i++) {
        double x = i & 1 ? u.y : u.x, across = i & 2 ? w / 2 : -w / 2;
        corner[i] = vec3(leaf->axis[0].x + along.x * x - along.y * across,
                         leaf->axis[0].y + along.y * x + along.x * across, leaf->z0 + (i & 4 ? v.y : v.x));
    }
    for (int side = 0; side < 6; side++) {
        Vec3 quad[4];
        for (int k = 0; k < 4; k++) quad[k] = corner[SIDES[side][k]];
        building_add_polygon(e->arena, e->b, quad, 4, material);
    }
}

static void add_glazed(Enclosure *e, const Leaf *leaf, double width, double height, int material) {
    int pane = building_add_material(
        e->arena, e->b, (Material){.name = "pane", .reflectance = maps_colour(0xBCD8DE), .alpha = 0.3f});
    add_leaf_box(e, leaf, vec2(0, STILE), vec2(0, height), leaf->thickness, material);
    add_leaf_box(e, leaf, vec2(width - STILE, width), vec2(0, height), leaf->thickness, material);
    add_leaf_box(e, leaf, vec2(STILE, width - STILE), vec2(0, KICK), leaf->thickness, material);
    add_leaf_box(e, leaf, vec2(STILE, width - STILE), vec2(height - RAIL, height), leaf->thickness, material);
    Vec2 along = vec2_scale(vec2_sub(leaf->axis[1], leaf->axis[0]), 1 / width);
    Vec2 from = vec2_add(leaf->axis[0], vec2_scale(along, STILE)),
         to = vec2_sub(leaf->axis[1], vec2_scale(along, STILE));
    double z0 = leaf->z0 + KICK, z1 = leaf->z1 - RAIL;
    Vec3 quad[4] = {{from.x, from.y, z0}, {to.x, to.y, z0}, {to.x, to.y, z1}, {from.x, from.y, z1}};
    building_add_polygon(e->arena, e->b, quad, 4, pane);
}

void leaves_draw(Enclosure *e, int hole) {
    Building *b = e->b;
    const Opening *o = &b->openings[e->holes[hole].opening];
    if (e->sketch->openings[hole].leaf_count > 0) return;
    for (int i = o->first_leaf; i < o->first_leaf + o->leaf_count; i++) {
        const Leaf *leaf = &b->leaves[i];
        Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
        double width = vec2_length(along), height = leaf->z1 - leaf->z0;
        int object = building_add_object(e->arena, b, OBJECT_LEAF, o->name);
        b->objects[object].opening = leaf->opening;
        b->objects[object].leaf = i;
        // A leaf of a transparent material needs no frame: it is one sheet.
        bool framed = o->glazed && b->materials[o->material].alpha >= 1;
        if (framed && width >= LEAST_GLAZED && height >= LEAST_GLAZED) {
            add_glazed(e, leaf, width, height, o->material);
        } else {
            add_leaf_box(e, leaf, vec2(0, width), vec2(0, height), leaf->thickness, o->material);
        }
        building_set_proxy(b, atan2(along.y, along.x));
    }
}
