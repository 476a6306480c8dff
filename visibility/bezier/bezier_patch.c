// bezier_patch.c - a patch in nearly flat pieces: each is halved across the direction it bends more in, until it bends little,
// four to a node of the tree. Bezier clipping then starts from pieces of which nearly all have one hit or none.
#include "visibility/bezier/bezier_patch.h"

#include <string.h>

// A piece is flat enough when the second differences of its control points are below this, of its size: of a piece of
// a circle it allows 0.3 rad or so.
#define FLAT 0.06
// By which boxes grow, of the patch's size: what rounding moves points and rays.
#define BOX_ROUNDING 1e-13
// Control points are this many halvings nearer to a piece, each way, when its box is taken.
enum { BOX_HALVINGS = 2 };

BezierCut bezier_cut(double a, double b) {
    double c = 1 - a, d = 1 - b;
    return (BezierCut){{
        {c * c * c, 3 * c * c * a, 3 * c * a * a, a * a * a},
        {c * c * d, c * (2 * a * d + c * b), a * (a * d + 2 * c * b), a * a * b},
        {c * d * d, d * (2 * b * c + d * a), b * (b * c + 2 * d * a), a * b * b},
        {d * d * d, 3 * d * d * b, 3 * d * b * b, b * b * b},
    }};
}

void bezier_cut_rows(Four row[4], const BezierCut *cut) {
    Four out[4];
    for (int i = 0; i < 4; i++) {
        const double *m = cut->of[i];
        out[i] = (m[0] * row[0] + m[1] * row[1]) + (m[2] * row[2] + m[3] * row[3]);
    }
    memcpy(row, out, sizeof out);
}

void bezier_cut_lanes(Four row[4], const BezierCut *cut) {
    Four column[4];
    for (int k = 0; k < 4; k++)
        column[k] = (Four){cut->of[0][k], cut->of[1][k], cut->of[2][k], cut->of[3][k]};
    for (int i = 0; i < 4; i++) {
        Four r = row[i];
        row[i] = (__builtin_shufflevector(r, r, 0, 0, 0, 0) * column[0] +
                  __builtin_shufflevector(r, r, 1, 1, 1, 1) * column[1]) +
                 (__builtin_shufflevector(r, r, 2, 2, 2, 2) * column[2] +
                  __builtin_shufflevector(r, r, 3, 3, 3, 3) * column[3]);
    }
}

static void cut_net(PatchNet *net, bool along_v, double low, double high) {
    BezierCut by = bezier_cut(low, high);
    void (*cut)(Four row[4], const BezierCut *by) = along_v ? bezier_cut_rows : bezier_cut_lanes;
    cut(net->x, &by), cut(net->y, &by), cut(net->z, &by), cut(net->w, &by);
}

// A point is sum(P B) / sum(w B): its value and derivatives come from those of numerator and denominator.
PatchPoint bezier_patch_point(const PatchNet *net, double u, double v) {
    Four bu = bezier_basis(u), su = bezier_slopes(u), bv = bezier_basis(v), sv = bezier_slopes(v);
    const Four *of[4] = {net->x, net->y, net->z, net->w};
    double value[4], du[4], dv[4];
    for (int k = 0; k < 4; k++) {
        Four row = bezier_over_rows(of[k], bv), slope = bezier_over_rows(of[k], sv);
        value[k] = four_sum(row * bu), du[k] = four_sum(row * su), dv[k] = four_sum(slope * bu);
    }
    double w = 1 / value[3];
    PatchPoint at = {.p = vec3_scale(vec3(value[0], value[1], value[2]), w)};
    at.du = vec3_scale(vec3_sub(vec3(du[0], du[1], du[2]), vec3_scale(at.p, du[3])), w);
    at.dv = vec3_scale(vec3_sub(vec3(dv[0], dv[1], dv[2]), vec3_scale(at.p, dv[3])), w);
    return at;
}

// ---- cut into pieces

static Vec3 control(const PatchNet *net, int row, int lane) {
    return vec3_scale(vec3(net->x[row][lane], net->y[row][lane], net->z[row][lane]), 1 / net->w[row][lane]);
}

static Box control_box(const PatchNet *net) {
    Box box = box_empty();
    for (int k = 0; k < 16; k++) box = box_add(box, control(net, k / 4, k % 4));
    return box;
}

static Box tight_box(const PatchNet *net, int halvings) {
    if (halvings == 0) return control_box(net);
    Box box = box_empty();
    for (int k = 0; k < 2; k++) {
        PatchNet half = *net;
        cut_net(&half, halvings % 2, 0.5 * k, 0.5 + 0.5 * k);
        box = box_union(box, tight_box(&half, halvings - 1));
    }
    return box;
}

// The largest second difference of control points along u or v, of the size.
static double bend_of(const PatchNet *net, bool along_v) {
    Box box = control_box(net);
    double size = vec3_length(vec3_sub(box.max, box.min)), most = 0;
    for (int i = 0; i < 4; i++)
        for (int k = 1; k < 3; k++) {
            Vec3 p[3];
            for (int s = 0; s < 3; s++)
                p[s] = along_v ? control(net, k + s - 1, i) : control(net, i, k + s - 1);
            Vec3 second = vec3_sub(vec3_add(p[0], p[2]), vec3_scale(p[1], 2));
            most = fmax(most, vec3_length(second));
        }
    return size > 0 ? most / size : 0;
}

static bool is_flat(const PatchNet *net) { return fmax(bend_of(net, false), bend_of(net, true)) <= FLAT; }

static void halve_patch_piece(PatchPiece *first, PatchPiece *second, bool along_v) {
    *second = *first;
    cut_net(&first->net, along_v, 0, 0.5);
    cut_net(&second->net, along_v, 0.5, 1);
    if (along_v) {
        second->width_v = first->width_v /= 2;
        second->v += second->width_v;
    } else {
        second->width_u = first->width_u /= 2;
        second->u += second->width_u;
    }
}

// Halves the part that bends most, until there are four or all are flat.
static int cut_in_parts(PatchPiece part[4]) {
    for (int count = 1;; count++) {
        double most = 0;
        int worst = 0;
        bool along_v = false;
        for (int i = 0; i < 2 * count; i++) {
            double bend = bend_of(&part[i / 2].net, i % 2);
            if (bend > most) most = bend, worst = i / 2, along_v = i % 2;
        }
        if (count == 4 || most <= FLAT) return count;
        halve_patch_piece(&part[worst], &part[count], along_v);
    }
}

static int add_patch_piece(BezierPatch *patch, const PatchPiece *part, bool trimmed, Arena *arena) {
    PatchPiece *piece = ARENA_PUSH(arena, patch->pieces, patch->piece_count, patch->piece_capacity);
    *piece = *part;
    piece->trimmed = trimmed;
    return ~(patch->piece_count - 1);
}

// Returns the node's index. Parts that are cut off whole are left out.
static int add_patch_node(BezierPatch *patch, PatchPiece whole, int depth, Arena *arena) {
    int index = patch->node_count;
    (void)ARENA_PUSH(arena, patch->nodes, patch->node_count, patch->node_capacity);
    PatchPiece part[4] = {whole};
    PatchNode node = {.count = 0};
    int count = depth < PATCH_DEPTH ? cut_in_parts(part) : 1;
    for (int i = 0; i < count; i++) {
        const PatchPiece *p = &part[i];
        TrimState state = patch->trim ? trim_state(patch->trim, vec2(p->u, p->v),
                                                   vec2(p->u + p->width_u, p->v + p->width_v))
                                      : TRIM_KEPT;
        if (state == TRIM_CUT_OFF) continue;
        Box box = box_grow(tight_box(&p->net, 2 * BOX_HALVINGS), BOX_ROUNDING * patch->size);
        int at = node.count++;
        node.low[0][at] = box.min.x, node.low[1][at] = box.min.y, node.low[2][at] = box.min.z;
        node.high[0][at] = box.max.x, node.high[1][at] = box.max.y, node.high[2][at] = box.max.z;
        bool leaf = depth >= PATCH_DEPTH - 1 || is_flat(&p->net);
        node.child[at] = leaf ? add_patch_piece(patch, p, state == TRIM_SOME_KEPT, arena)
                              : add_patch_node(patch, *p, depth + 1, arena);
    }
    patch->nodes[index] = node;
    return index;
}

BezierPatch *bezier_patch_new(const Building *building, const CurvedShape *shape, bool whole, Arena *arena) {
    const CurvedControl *controls = building->controls + shape->first_control;
    BezierPatch *patch = ARENA_ARRAY(arena, BezierPatch, 1);
    Box box = box_empty();
    double heaviest = 0;
    for (int k = 0; k < 16; k++) {
        box = box_add(box, controls[k].point);
        heaviest = fmax(heaviest, controls[k].weight);
    }
    patch->centre = vec3_lerp(box.min, box.max, 0.5);
    patch->size = vec3_length(vec3_sub(box.max, box.min));
    PatchPiece all = {.width_u = 1, .width_v = 1};
    for (int k = 0; k < 16; k++) {
        double w = controls[k].weight / heaviest;
        Vec3 p = vec3_scale(vec3_sub(controls[k].point, patch->centre), w);
        all.net.x[k / 4][k % 4] = p.x, all.net.y[k / 4][k % 4] = p.y, all.net.z[k / 4][k % 4] = p.z;
        all.net.w[k / 4][k % 4] = w;
    }
    if (shape->trim_count > 0)
        patch->trim = trim_new(building->trims + shape->first_trim, shape->trim_count, arena);
    Box tight = tight_box(&all.net, 2 * BOX_HALVINGS);
    double rounding = BOX_ROUNDING * (patch->size + vec3_length(patch->centre));
    patch->box =
        box_grow((Box){vec3_add(patch->centre, tight.min), vec3_add(patch->centre, tight.max)}, rounding);
    add_patch_node(patch, all, whole ? PATCH_DEPTH : 0, arena);
    return patch;
}
