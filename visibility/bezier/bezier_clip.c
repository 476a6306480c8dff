// bezier_clip.c - rays against rational bicubic Bezier patches (Nishita, Sederberg & Kakimoto 1990). A ray is two planes;
// distances of control points to them make a patch in the plane, whose roots are hits. Distances to a line along v, and to
// one along u, bound where roots may lie in u and in v: the parts that the convex hulls leave out are clipped, and a part that does
// not shrink is halved.
//
// Departures. It begins from the nearly flat pieces that the ray's boxes leave. As soon as the tangents
// along u of a part lie in one cone and those along v in another, apart from it, the part has one root or none, and
// Newton's steps find it. Where a part folds, roots may be double: the place is found by Gauss-Newton's steps, on the
// two distances and the determinant of their derivatives together, which knows it to the last digits; the distances
// alone would only to half of them.
//
// Beside it stand other ways to find the hits, to measure Bezier clipping against: halving (Whitted 1980), and Newton's steps from
// a grid of places (after Kajiya 1982, who finds starts by algebra; Toth 1985).
#include "visibility/bezier/bezier_clip.h"

#include <string.h>

#include "engine/core/lanes.h"
#include "maps/building/building.h"
#include "visibility/bezier/bezier_trim.h"

// Four rows of v, lanes along u; points about the patch's centre, multiplied by their weights.
typedef struct PatchNet {
    Four x[4], y[4], z[4], w[4];
} PatchNet;

typedef struct PatchPiece {
    PatchNet net;
    double u, v, width_u, width_v;  // the part of the patch it is
    bool trimmed;                   // some of it is cut off
} PatchPiece;

// Up to four parts of a patch, each a node or, as ~ of its index, a piece.
typedef struct PatchNode {
    Four low[3], high[3];  // x, y, z of their boxes, about the patch's centre
    int child[4];
    int count;
} PatchNode;

enum { PATCH_DEPTH = 5 };  // of the tree, at most: 4^5 pieces

struct BezierPatch {
    Vec3 centre;
    double size;       // from corner to corner of its control points' box
    PatchNode *nodes;  // [node_count] nodes[0]: the root
    PatchPiece *pieces;
    int node_count, node_capacity, piece_count, piece_capacity;
    Trim *trim;  // NULL: all of it is there
    Box box;
};

// The four Bernstein polynomials of degree 3, and their derivatives.
static inline Four bezier_basis(double s) {
    double r = 1 - s;
    return (Four){r * r * r, 3 * r * r * s, 3 * r * s * s, s * s * s};
}
static inline Four bezier_slopes(double s) {
    double r = 1 - s;
    return (Four){-3 * r * r, 3 * r * (r - 2 * s), 3 * s * (2 * r - s), 3 * s * s};
}
static inline Four bezier_bends(double s) {
    double r = 1 - s;
    return (Four){6 * r, 6 * (s - 2 * r), 6 * (r - 2 * s), 6 * s};
}

static inline Four bezier_over_rows(const Four row[4], Four basis) {
    return (basis[0] * row[0] + basis[1] * row[1]) + (basis[2] * row[2] + basis[3] * row[3]);
}

// A matrix restricts coefficients to low .. high: of[i] are the shares of the old ones in new coefficient i.
typedef struct BezierCut {
    double of[4][4];
} BezierCut;
// The point of a net, about the patch's centre, and its derivatives.
typedef struct PatchPoint {
    Vec3 p, du, dv;
} PatchPoint;

// ---- a patch in nearly flat pieces: each is halved across the direction it bends more in, until it bends little,
// four to a node of the tree. Bezier clipping then starts from pieces of which nearly all have one hit or none.

// A piece is flat enough when the second differences of its control points are below this, of its size: of a piece of
// a circle it allows 0.3 rad or so.
#define FLAT 0.06
// Boxes grow by this share of the patch's size: rounding moves points and rays less.
#define BOX_ROUNDING 1e-13
// Control points are this many halvings nearer to a piece, each way, when its box is taken.
enum { BOX_HALVINGS = 2 };

static BezierCut bezier_cut(double a, double b) {
    double c = 1 - a, d = 1 - b;
    return (BezierCut){{
        {c * c * c, 3 * c * c * a, 3 * c * a * a, a * a * a},
        {c * c * d, c * (2 * a * d + c * b), a * (a * d + 2 * c * b), a * a * b},
        {c * d * d, d * (2 * b * c + d * a), b * (b * c + 2 * d * a), a * b * b},
        {d * d * d, 3 * d * d * b, 3 * d * b * b, b * b * b},
    }};
}

// New rows from old ones; new lanes from old ones.
static void bezier_cut_rows(Four row[4], const BezierCut *cut) {
    Four out[4];
    for (int i = 0; i < 4; i++) {
        const double *m = cut->of[i];
        out[i] = (m[0] * row[0] + m[1] * row[1]) + (m[2] * row[2] + m[3] * row[3]);
    }
    memcpy(row, out, sizeof out);
}

static void bezier_cut_lanes(Four row[4], const BezierCut *cut) {
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
static PatchPoint bezier_patch_point(const PatchNet *net, double u, double v) {
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
        int state = patch->trim ? trim_state(patch->trim, vec2(p->u, p->v),
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

// `whole`: in one piece, as it is.
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

Box bezier_patch_box(const BezierPatch *patch) { return patch->box; }

double bezier_patch_size(const BezierPatch *patch) { return patch->size; }

Vec3 bezier_patch_at(const BezierPatch *whole, double u, double v) {
    return vec3_add(bezier_patch_point(&whole->pieces[0].net, u, v).p, whole->centre);
}

// ---- a ray about a patch: its two planes (Kajiya 1982), its way down the tree of pieces, and its hits

typedef struct BezierBeam {
    const BezierPatch *patch;
    Vec3 o, d;     // o is nearest to the centre
    Vec3 n[2];     // of the planes, unit
    double e[2];   // dot(n, o)
    double start;  // t of o
    double slack;  // distances that count as 0
    HitList *list;
    CurvedWork *work;
} BezierBeam;

// Distances that count as 0, of the patch's size: rounding of the ray, of its origin ten sizes away, and of the net.
#define ROUNDING 4e-14
// Hits with t no more than this apart, of the size, and the same normal, are one that was found in two parts; of grazing
// rays those whose distance from the ray differs by no more than rounding, too.
#define SAME_HIT 1e-11
#define SAME_NORMAL 1e-8  // 1 - cosine
// The least slope of a ray against a patch that counts there.
#define LEAST_SLOPE 1e-9

// Distances of a net's points to one of the planes, multiplied by their weights; rows of v.
static void bezier_beam_project(const BezierBeam *beam, const PatchNet *net, int plane, Four out[4]) {
    Vec3 n = beam->n[plane];
    for (int k = 0; k < 4; k++)
        out[k] = (n.x * net->x[k] + n.y * net->y[k]) + (n.z * net->z[k] - beam->e[plane] * net->w[k]);
}

// ---- hits

// Where a patch has no normal - a row of its control points is one point - that from beside it, towards the piece's middle.
static Vec3 normal_at(const PatchNet *net, double u, double v, const PatchPoint *at) {
    Vec3 n = vec3_cross(at->du, at->dv);
    double lengths = vec3_length(at->du) + vec3_length(at->dv);
    for (double beside = 1e-6; vec3_length(n) <= 1e-9 * lengths * lengths && beside < 1; beside *= 100) {
        PatchPoint near = bezier_patch_point(net, u + beside * (0.5 - u), v + beside * (0.5 - v));
        n = vec3_cross(vec3_normalize(near.du), vec3_normalize(near.dv));
        lengths = 1;
    }
    return vec3_normalize(n);
}

static bool is_known(const BezierBeam *beam, const RayHit *hit) {
    const HitList *list = beam->list;
    double slope = fabs(vec3_dot(hit->normal, beam->d));
    double same = SAME_HIT * beam->patch->size + 2 * beam->slack / fmax(slope, LEAST_SLOPE);
    for (int i = 0; i < list->count && i < list->max; i++)
        if (fabs(list->hits[i].t - hit->t) <= same &&
            1 - fabs(vec3_dot(list->hits[i].normal, hit->normal)) < SAME_NORMAL)
            return true;
    return false;
}

// At u, v of a piece, unless it is cut off or known.
static void bezier_beam_hit(const BezierBeam *beam, const PatchPiece *piece, double u, double v) {
    PatchPoint at = bezier_patch_point(&piece->net, u, v);
    RayHit hit = {.t = beam->start + vec3_dot(beam->d, vec3_sub(at.p, beam->o)),
                  .u = piece->u + u * piece->width_u,
                  .v = piece->v + v * piece->width_v};
    if (!hit_list_wants(beam->list, hit.t)) return;
    if (piece->trimmed && !trim_keeps(beam->patch->trim, vec2(hit.u, hit.v), beam->work)) return;
    hit.normal = normal_at(&piece->net, u, v, &at);
    if (!is_known(beam, &hit)) hit_list_add(beam->list, hit);
}

// ---- the tree

// Axes across a unit vector, without a branch (Duff et al. 2017).
static void axes_across(Vec3 d, Vec3 n[2]) {
    double sign = copysign(1, d.z), a = -1 / (sign + d.z), b = d.x * d.y * a;
    n[0] = vec3(1 + sign * d.x * d.x * a, sign * b, -sign * d.x);
    n[1] = vec3(b, sign + d.y * d.y * a, -d.y);
}

// No component is 0, so that no slab is 0 / 0.
static double inverse(double d) { return 1 / (fabs(d) > 1e-300 ? d : copysign(1e-300, d)); }

// Children waiting: three at each level of the tree, and four.
enum { PIECES_WAITING = 3 * PATCH_DEPTH + 4 };

typedef struct Entry {
    int child;
    double t;  // from the beam's o
} Entry;

// The children that the beam meets, the nearest last. Returns how many.
static int children_met(const BezierBeam *beam, const Vec3 *inverse_d, const PatchNode *node, Entry out[4]) {
    const double o[3] = {beam->o.x, beam->o.y, beam->o.z}, d[3] = {inverse_d->x, inverse_d->y, inverse_d->z};
    Four in = four_of(beam->list->near - beam->start), leave = four_of(beam->list->far - beam->start);
    for (int k = 0; k < 3; k++) {
        Four a = (node->low[k] - four_of(o[k])) * four_of(d[k]);
        Four b = (node->high[k] - four_of(o[k])) * four_of(d[k]);
        in = four_most(four_least(a, b), in);
        leave = four_least(four_most(a, b), leave);
    }
    int count = 0;
    for (unsigned met = four_lanes(in <= leave) & ((1u << node->count) - 1); met; met &= met - 1) {
        int i = __builtin_ctz(met), k = count++;
        for (; k > 0 && out[k - 1].t < in[i]; k--) out[k] = out[k - 1];
        out[k] = (Entry){node->child[i], in[i]};
    }
    return count;
}

// False: the ray passes beside all of the patch.
static bool bezier_beam(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work,
                        BezierBeam *out) {
    BezierBeam beam = {.patch = patch, .d = ray->direction, .list = list, .work = work};
    Vec3 from = vec3_sub(ray->origin, patch->centre);
    beam.start = -vec3_dot(from, ray->direction);
    beam.o = vec3_add(from, vec3_scale(ray->direction, beam.start));
    if (4 * vec3_dot(beam.o, beam.o) > 1.001 * patch->size * patch->size) return false;  // beside its sphere
    beam.slack = ROUNDING * patch->size;
    axes_across(beam.d, beam.n);
    for (int k = 0; k < 2; k++) beam.e[k] = vec3_dot(beam.n[k], beam.o);
    *out = beam;
    return true;
}

// Calls for the pieces whose boxes the ray meets before the hits found so far, the nearest first.
static void bezier_beam_pieces(const BezierBeam *beam,
                               void (*each)(const BezierBeam *beam, const PatchPiece *piece)) {
    const BezierPatch *patch = beam->patch;
    Vec3 inverse_d = vec3(inverse(beam->d.x), inverse(beam->d.y), inverse(beam->d.z));
    Entry waiting[PIECES_WAITING] = {{0, -INFINITY}};
    for (int count = 1; count > 0;) {
        Entry entry = waiting[--count];
        if (entry.t + beam->start >= beam->list->far) continue;
        if (entry.child < 0)
            each(beam, &patch->pieces[~entry.child]);
        else
            count += children_met(beam, &inverse_d, &patch->nodes[entry.child], waiting + count);
    }
}

// ---- parts of a patch seen along a ray: clipped by convex hulls (Nishita, Sederberg & Kakimoto 1990, section 3), cut, halved, and
// told to have one root at most. All of that is linear in the distances of control points to two lines through the ray.

typedef struct BezierPart {
    Vec2 along_u, along_v;          // the lines, unit vectors in the plane across the ray
    Four a[4];                      // distances to the line along v; rows of v, lanes along u
    Four b[4];                      // to the line along u; rows of u, lanes along v
    double u, v, width_u, width_v;  // where it is in its piece
} BezierPart;

// Both distances at a place of the part, and their derivatives.
typedef struct BezierPlace {
    double a, a_u, a_v, b, b_u, b_v;
} BezierPlace;
typedef struct BezierBends {
    double a_uu, a_uv, a_vv, b_uu, b_uv, b_vv;
} BezierBends;

// Tangents whose cross product is less than this of their lengths make no frame to measure in.
#define ASKEW 0.2

// ---- lines

// The mean tangents of a net in the plane, from its corners; both rows of v, lanes along u.
static void mean_tangents(const Four f[4], const Four g[4], Vec2 *along_u, Vec2 *along_v) {
    *along_u = vec2(f[0][3] - f[0][0] + f[3][3] - f[3][0], g[0][3] - g[0][0] + g[3][3] - g[3][0]);
    *along_v = vec2(f[3][0] - f[0][0] + f[3][3] - f[0][3], g[3][0] - g[0][0] + g[3][3] - g[0][3]);
}

static Vec2 unit(Vec2 a, Vec2 instead) {
    double length = vec2_length(a);
    return length > 0 ? vec2_scale(a, 1 / length) : instead;
}

// Lines along the mean tangents; where these are nearly one, the second line is across the first: only so is a part
// clipped along both.
static void choose_lines(const Four f[4], const Four g[4], bool for_clips, Vec2 *along_u, Vec2 *along_v) {
    Vec2 u, v;
    mean_tangents(f, g, &u, &v);
    double long_u = vec2_length(u), long_v = vec2_length(v);
    bool u_leads = long_u >= long_v;
    u = unit(u, unit(vec2(v.y, -v.x), vec2(1, 0)));
    v = unit(v, vec2(-u.y, u.x));
    if (for_clips && fabs(vec2_cross(u, v)) < ASKEW) {
        if (u_leads)
            v = vec2(-u.y, u.x);
        else
            u = vec2(v.y, -v.x);
    }
    double sign = vec2_cross(u, v) < 0 ? -1 : 1;  // so that distances grow with u and v
    *along_u = vec2_scale(u, sign);
    *along_v = vec2_scale(v, sign);
}

// From coordinates f and g in the plane, rows of v. Lines are along the mean tangents; `for_clips` the second is across the
// first where these are nearly one: only so is a part clipped along both.
static void bezier_part_measure(BezierPart *part, const Four f[4], const Four g[4], bool for_clips) {
    Vec2 u, v;
    choose_lines(f, g, for_clips, &u, &v);
    part->along_u = u;
    part->along_v = v;
    for (int k = 0; k < 4; k++) {
        part->a[k] = f[k] * v.y - g[k] * v.x;
        part->b[k] = u.x * g[k] - u.y * f[k];
    }
    four_transpose(part->b);
}

// The coordinates again.
static void coordinates(const BezierPart *part, Four f[4], Four g[4]) {
    Vec2 u = part->along_u, v = part->along_v;
    double scale = 1 / vec2_cross(u, v);
    Four b[4];
    memcpy(b, part->b, sizeof b);
    four_transpose(b);
    for (int k = 0; k < 4; k++) {
        f[k] = (part->a[k] * u.x + b[k] * v.x) * scale;
        g[k] = (part->a[k] * u.y + b[k] * v.y) * scale;
    }
}

// ---- clips

// Where the hull of (lane / 3, low .. high) comes down to 0 from lane 0 on, in lanes; low[0] > 0.
static double comes_down(const double low[4]) {
    double first = 3;
    for (int j = 1; j < 4; j++) {
        if (!(low[j] <= 0)) continue;
        for (int i = 0; i < j; i++)
            if (low[i] > 0) {
                double at = i + (j - i) * (low[i] / (low[i] - low[j]));
                first = at < first ? at : first;
            }
    }
    return first;
}

// The lanes, as 0 .. 1, outside which no distance is within slack of 0. False: none is.
static bool clip_lanes(const Four row[4], double slack, double *from, double *to) {
    Four low = four_least_row(row) - four_of(slack), high = -four_most_row(row) - four_of(slack);
    unsigned above = four_lanes(low > four_of(0)), below = four_lanes(high > four_of(0));
    if (above == 15 || below == 15) return false;
    *from = 0;
    *to = 1;
    if ((above | below) & 1) {
        Four a = above & 1 ? low : high;
        *from = comes_down((double[]){a[0], a[1], a[2], a[3]}) / 3;
    }
    if ((above | below) & 8) {
        Four a = above & 8 ? low : high;
        *to = 1 - comes_down((double[]){a[3], a[2], a[1], a[0]}) / 3;
    }
    return true;
}

// False: no root of the part is where all distances are more than slack. Else from .. to, in u and v, hold all roots.
static bool bezier_part_clip(const BezierPart *part, double slack, double from[2], double to[2]) {
    return clip_lanes(part->a, slack, &from[0], &to[0]) && clip_lanes(part->b, slack, &from[1], &to[1]);
}

// Along one parameter, which runs over the lanes of one of the distances and the rows of the other.
static void cut_lanes(Four lanes[4], Four rows[4], double *at, double *width, double from, double to) {
    BezierCut piece = bezier_cut(from, to);
    bezier_cut_lanes(lanes, &piece);
    bezier_cut_rows(rows, &piece);
    *at += from * *width;
    *width *= to - from;
}

static void cut_u(BezierPart *part, double from, double to) {
    cut_lanes(part->a, part->b, &part->u, &part->width_u, from, to);
}

static void cut_v(BezierPart *part, double from, double to) {
    cut_lanes(part->b, part->a, &part->v, &part->width_v, from, to);
}

static void bezier_part_cut(BezierPart *part, const double from[2], const double to[2]) {
    cut_u(part, from[0], to[0]);
    cut_v(part, from[1], to[1]);
}

// Measures it anew, and halves it across the longer of its mean tangents.
static void bezier_part_halve(BezierPart *first, BezierPart *second) {
    Four f[4], g[4];
    Vec2 u, v;
    coordinates(first, f, g);
    mean_tangents(f, g, &u, &v);
    bezier_part_measure(first, f, g, true);
    *second = *first;
    if (vec2_dot(u, u) > vec2_dot(v, v)) {
        cut_u(first, 0, 0.5);
        cut_u(second, 0.5, 1);
    } else {
        cut_v(first, 0, 0.5);
        cut_v(second, 0.5, 1);
    }
}

// all distances are within slack
static bool bezier_part_is_zero(const BezierPart *part, double slack) {
    return !(four_most_of(four_most_row(part->a)) > slack ||
             four_least_of(four_least_row(part->a)) < -slack ||
             four_most_of(four_most_row(part->b)) > slack || four_least_of(four_least_row(part->b)) < -slack);
}

// ---- one root or none

// The least difference of neighbouring lanes, which is along the distance's own parameter; the largest of rows.
static void slopes(const Four row[4], double *least, double *most_across) {
    Four along[4], across = four_of(0);
    for (int k = 0; k < 4; k++)
        along[k] = __builtin_shufflevector(row[k], row[k], 1, 2, 3, 3) -
                   __builtin_shufflevector(row[k], row[k], 0, 1, 2, 2);
    for (int k = 0; k < 3; k++) across = four_most(across, four_abs(row[k + 1] - row[k]));
    *least = four_least_of(four_least_row(along));
    *most_across = four_most_of(across);
}

static bool cones_are_apart(const BezierPart *part) {
    double a_u, a_v, b_v, b_u;
    slopes(part->a, &a_u, &a_v);
    slopes(part->b, &b_v, &b_u);
    return a_u > 0 && b_v > 0 && a_u * b_v > a_v * b_u;
}

static bool bezier_part_has_one_root_at_most(const BezierPart *part) {
    if (cones_are_apart(part)) return true;
    BezierPart again;
    Four f[4], g[4];
    coordinates(part, f, g);
    bezier_part_measure(&again, f, g, false);
    return cones_are_apart(&again);
}

// ---- places

static BezierPlace bezier_part_place(const BezierPart *part, double u, double v) {
    Four bu = bezier_basis(u), su = bezier_slopes(u), bv = bezier_basis(v), sv = bezier_slopes(v);
    Four a = bezier_over_rows(part->a, bv), b = bezier_over_rows(part->b, bu);
    return (BezierPlace){four_sum(a * bu),
                         four_sum(a * su),
                         four_sum(bezier_over_rows(part->a, sv) * bu),
                         four_sum(b * bv),
                         four_sum(bezier_over_rows(part->b, su) * bv),
                         four_sum(b * sv)};
}

static BezierBends bezier_part_bends(const BezierPart *part, double u, double v) {
    Four bu = bezier_basis(u), su = bezier_slopes(u), cu = bezier_bends(u);
    Four bv = bezier_basis(v), sv = bezier_slopes(v), cv = bezier_bends(v);
    return (BezierBends){
        four_sum(bezier_over_rows(part->a, bv) * cu), four_sum(bezier_over_rows(part->a, sv) * su),
        four_sum(bezier_over_rows(part->a, cv) * bu), four_sum(bezier_over_rows(part->b, cu) * bv),
        four_sum(bezier_over_rows(part->b, su) * sv), four_sum(bezier_over_rows(part->b, bu) * cv)};
}

// ---- Bezier clipping

// A part that keeps more than this both ways is halved (Nishita, Sederberg & Kakimoto 1990).
#define SHRINKS 0.8
// A clip leaves this much: a narrower part is worse to compute with, and Newton's steps need none.
#define LEAST_LEFT 1e-3
// Parts that fold and are no larger than this, of a piece, may be a double root.
#define MAY_TOUCH 1e-2
// A part whose distances are all less than that, of the slack, is a point: where a row of control points is one, all along it.
#define POINT 8
// How far beyond a part's border a root may lie, of the slack: neighbours then leave no crack.
#define AT_BORDER 0.25
// Distances of that are rounding alone, and no step makes them less.
#define ROUNDED 0.02
// A step this small, of a part, is the last: squared, it is less than rounding.
#define LAST_STEP 1e-7
enum {
    WAITING = 64,     // parts: each halving leaves one
    MOST_PARTS = 400  // of a piece: tangent rays take 50; one that stays in the surface would take any number
};
enum { MOST_STEPS = 8 };  // of Newton: from within a part with one root three or four do

// ---- roots

// Is there no root but the one at u, v, outside the part but no farther than half its size?
static bool is_alone(const BezierPart *part) {
    BezierPart wide = *part;
    bezier_part_cut(&wide, (double[]){-0.5, -0.5}, (double[]){1.5, 1.5});
    return bezier_part_has_one_root_at_most(&wide);
}

static double into_part(double s) { return s < 0 ? 0 : s > 1 ? 1 : s; }

static bool is_on_ray(const BezierBeam *beam, const BezierPlace *at) {
    return fmax(fabs(at->a), fabs(at->b)) <= AT_BORDER * beam->slack;
}

// Is the root at u, v no farther outside than rounding? Then it is moved to the border, and along it to where it is nearest,
// since a grazing ray's place on the surface is known far less well than its distance from it.
static bool is_at_border(const BezierBeam *beam, const BezierPart *part, double *u, double *v) {
    double from_u = into_part(*u), from_v = into_part(*v);
    bool out_u = from_u != *u, out_v = from_v != *v;
    BezierPlace at = bezier_part_place(part, from_u, from_v);
    double step_u = -(at.a * at.a_u + at.b * at.b_u) / (at.a_u * at.a_u + at.b_u * at.b_u);
    double step_v = -(at.a * at.a_v + at.b * at.b_v) / (at.a_v * at.a_v + at.b_v * at.b_v);
    *u = from_u;
    *v = from_v;
    if (is_on_ray(beam, &at)) return true;
    if (out_u) {
        *v = into_part(from_v + step_v);
        at = bezier_part_place(part, *u, *v);
        if (is_on_ray(beam, &at)) return true;
    }
    if (!out_v) return false;
    *u = into_part(from_u + step_u);
    *v = from_v;
    at = bezier_part_place(part, *u, *v);
    return is_on_ray(beam, &at);
}

typedef enum Search { FOUND, NONE, UNKNOWN } Search;

// Newton's steps from u, v to the one root there may be in the part.
static Search find_root(const BezierBeam *beam, const BezierPart *part, double *u, double *v) {
    for (int i = 0; i < MOST_STEPS; i++) {
        BezierPlace at = bezier_part_place(part, *u, *v);
        beam->work->steps++;
        double determinant = at.a_u * at.b_v - at.a_v * at.b_u;
        double du = (at.a_v * at.b - at.b_v * at.a) / determinant;
        double dv = (at.b_u * at.a - at.a_u * at.b) / determinant;
        *u += du;
        *v += dv;
        if (!(fabs(*u - 0.5) < 1 && fabs(*v - 0.5) < 1)) return UNKNOWN;
        bool rounded = fmax(fabs(at.a), fabs(at.b)) <= ROUNDED * beam->slack;
        if (fabs(du) + fabs(dv) > LAST_STEP && !rounded) continue;
        if (*u >= 0 && *u <= 1 && *v >= 0 && *v <= 1) return FOUND;
        if (is_at_border(beam, part, u, v)) return FOUND;
        return is_alone(part) ? NONE : UNKNOWN;
    }
    return UNKNOWN;
}

// ---- folds

// A Gauss-Newton step to where both distances and the determinant of their derivatives are 0.
static bool fold_step(const BezierPart *part, double *u, double *v, double *step) {
    BezierPlace p = bezier_part_place(part, *u, *v);
    BezierBends c = bezier_part_bends(part, *u, *v);
    double scale = sqrt(p.a_u * p.a_u + p.a_v * p.a_v + p.b_u * p.b_u + p.b_v * p.b_v);
    if (!(scale > 0)) return false;
    double r[3] = {p.a, p.b, (p.a_u * p.b_v - p.a_v * p.b_u) / scale};
    double ju[3] = {p.a_u, p.b_u,
                    (c.a_uu * p.b_v + p.a_u * c.b_uv - c.a_uv * p.b_u - p.a_v * c.b_uu) / scale};
    double jv[3] = {p.a_v, p.b_v,
                    (c.a_uv * p.b_v + p.a_u * c.b_vv - c.a_vv * p.b_u - p.a_v * c.b_uv) / scale};
    double uu = 0, uv = 0, vv = 0, gu = 0, gv = 0;
    for (int i = 0; i < 3; i++) {
        uu += ju[i] * ju[i], uv += ju[i] * jv[i], vv += jv[i] * jv[i];
        gu += ju[i] * r[i], gv += jv[i] * r[i];
    }
    double determinant = uu * vv - uv * uv, du = (uv * gv - vv * gu) / determinant;
    double dv = (uv * gu - uu * gv) / determinant;
    *u += du;
    *v += dv;
    *step = fabs(du) + fabs(dv);
    return fabs(*u - 0.5) < 1.5 && fabs(*v - 0.5) < 1.5;
}

static bool find_double_root(const BezierBeam *beam, const BezierPart *part, double *u, double *v) {
    *u = *v = 0.5;
    double step = 1;
    for (int i = 0; i < MOST_STEPS && step > 1e-9; i++) {
        beam->work->steps++;
        if (!fold_step(part, u, v, &step)) return false;
    }
    *u = fmin(fmax(*u, 0), 1);
    *v = fmin(fmax(*v, 0), 1);
    BezierPlace at = bezier_part_place(part, *u, *v);
    return fabs(at.a) <= 4 * beam->slack && fabs(at.b) <= 4 * beam->slack;
}

// ---- parts

static void add_hit(const BezierBeam *beam, const PatchPiece *piece, const BezierPart *part, double u,
                    double v) {
    bezier_beam_hit(beam, piece, part->u + u * part->width_u, part->v + v * part->width_v);
}

static void widen_part(double *from, double *to) {
    double more = (LEAST_LEFT - (*to - *from)) / 2;
    if (!(more > 0)) return;
    *from = fmax(0, fmin(*from - more, 1 - LEAST_LEFT));
    *to = *from + LEAST_LEFT;
}

// The roots of a part that are told without clipping it, given where its hulls leave them.
static Search search_roots(const BezierBeam *beam, const BezierPart *part, const double from[2],
                           const double to[2], double *u, double *v) {
    *u = (from[0] + to[0]) / 2;
    *v = (from[1] + to[1]) / 2;
    if (bezier_part_has_one_root_at_most(part)) return find_root(beam, part, u, v);
    bool small = fmax(part->width_u, part->width_v) < MAY_TOUCH;
    return small && find_double_root(beam, part, u, v) ? FOUND : UNKNOWN;
}

// Clips a part until it is empty, or its hits are known, or it must be halved. True: halve it.
static bool clip_patch_part(const BezierBeam *beam, const PatchPiece *piece, BezierPart *part) {
    for (;;) {
        double from[2], to[2], u, v;
        beam->work->clips += 2;
        if (!bezier_part_clip(part, beam->slack, from, to)) return false;
        if (bezier_part_is_zero(part, POINT * beam->slack)) {
            add_hit(beam, piece, part, 0.5, 0.5);
            return false;
        }
        Search found = search_roots(beam, part, from, to, &u, &v);
        if (found == FOUND) add_hit(beam, piece, part, u, v);
        if (found != UNKNOWN) return false;
        if (to[0] - from[0] > SHRINKS && to[1] - from[1] > SHRINKS) return true;
        for (int k = 0; k < 2; k++) widen_part(&from[k], &to[k]);
        bezier_part_cut(part, from, to);
    }
}

static bool misses(const Four row[4], double slack) {
    return four_least_of(four_least_row(row)) > slack || four_most_of(four_most_row(row)) < -slack;
}

static void piece_hits(const BezierBeam *beam, const PatchPiece *piece) {
    Four f[4], g[4];
    bezier_beam_project(beam, &piece->net, 0, f);
    if (misses(f, beam->slack)) return;
    bezier_beam_project(beam, &piece->net, 1, g);
    if (misses(g, beam->slack)) return;
    BezierPart waiting[WAITING];
    waiting[0].u = waiting[0].v = 0;
    waiting[0].width_u = waiting[0].width_v = 1;
    bezier_part_measure(&waiting[0], f, g, true);
    int count = 1;
    for (int parts = 0; count > 0; parts++) {
        if (parts == MOST_PARTS || count + 2 > WAITING) {
            beam->work->undecided++;
            return;
        }
        BezierPart part = waiting[--count];
        if (!clip_patch_part(beam, piece, &part)) continue;
        beam->work->splits++;
        waiting[count] = part;
        bezier_part_halve(&waiting[count], &waiting[count + 1]);
        count += 2;
    }
}

void bezier_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work) {
    BezierBeam beam;
    if (bezier_beam(patch, ray, list, work, &beam)) bezier_beam_pieces(&beam, piece_hits);
}

// ---- other methods: a row of the table each

// A part of this width is a root: halving gains a bit a time.
#define SMALLEST_HALF 1e-12
// A step as small as this is the last.
#define LAST_NEWTON_STEP 1e-13
enum { HALVES_WAITING = 200, MOST_HALVES = 100000, STARTS = 4, MOST_NEWTON_STEPS = 20 };

// ---- halving

typedef struct Half {
    Four f[4], g[4];
    double u, v, width_u, width_v;
} Half;

static bool half_misses(const Four row[4], double slack) {
    return four_least_of(four_least_row(row)) > slack || four_most_of(four_most_row(row)) < -slack;
}

static void halve_half(Half *first, Half *second) {
    *second = *first;
    bool along_v = first->width_v > first->width_u;
    for (int k = 0; k < 2; k++) {
        Half *half = k ? second : first;
        BezierCut cut = bezier_cut(0.5 * k, 0.5 + 0.5 * k);
        void (*by)(Four row[4], const BezierCut *cut) = along_v ? bezier_cut_rows : bezier_cut_lanes;
        by(half->f, &cut);
        by(half->g, &cut);
        double *at = along_v ? &half->v : &half->u, *width = along_v ? &half->width_v : &half->width_u;
        *width /= 2;
        *at += k * *width;
    }
}

static void halve_piece(const BezierBeam *beam, const PatchPiece *piece) {
    Half waiting[HALVES_WAITING] = {{.width_u = 1, .width_v = 1}};
    bezier_beam_project(beam, &piece->net, 0, waiting[0].f);
    bezier_beam_project(beam, &piece->net, 1, waiting[0].g);
    int count = 1;
    for (int parts = 0; count > 0; parts++) {
        Half *half = &waiting[--count];
        if (half_misses(half->f, beam->slack) || half_misses(half->g, beam->slack)) continue;
        if (half->width_u <= SMALLEST_HALF && half->width_v <= SMALLEST_HALF) {
            bezier_beam_hit(beam, piece, half->u + half->width_u / 2, half->v + half->width_v / 2);
            continue;
        }
        if (parts >= MOST_HALVES || count + 2 > HALVES_WAITING) {
            beam->work->undecided++;
            return;
        }
        beam->work->splits++;
        halve_half(half, half + 1);
        count += 2;
    }
}

static void halving_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work) {
    BezierBeam beam;
    if (bezier_beam(patch, ray, list, work, &beam)) bezier_beam_pieces(&beam, halve_piece);
}

// ---- Newton's steps

static bool iterate(const BezierBeam *beam, const PatchPiece *piece, double *u, double *v) {
    for (int i = 0; i < MOST_NEWTON_STEPS; i++) {
        PatchPoint at = bezier_patch_point(&piece->net, *u, *v);
        Vec3 off = vec3_sub(at.p, beam->o);
        double f = vec3_dot(beam->n[0], off), fu = vec3_dot(beam->n[0], at.du),
               fv = vec3_dot(beam->n[0], at.dv);
        double g = vec3_dot(beam->n[1], off), gu = vec3_dot(beam->n[1], at.du),
               gv = vec3_dot(beam->n[1], at.dv);
        double determinant = fu * gv - fv * gu;
        double du = (fv * g - gv * f) / determinant, dv = (gu * f - fu * g) / determinant;
        beam->work->steps++;
        *u += du;
        *v += dv;
        if (!(*u > -1 && *u < 2 && *v > -1 && *v < 2)) return false;
        if (fabs(du) + fabs(dv) < LAST_NEWTON_STEP) return *u >= 0 && *u <= 1 && *v >= 0 && *v <= 1;
    }
    return false;
}

static void iterate_piece(const BezierBeam *beam, const PatchPiece *piece) {
    for (int k = 0; k < STARTS * STARTS; k++) {
        double u = (k % STARTS + 0.5) / STARTS, v = (k / STARTS + 0.5) / STARTS;
        if (iterate(beam, piece, &u, &v)) bezier_beam_hit(beam, piece, u, v);
    }
}

static void newton_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work) {
    BezierBeam beam;
    if (bezier_beam(patch, ray, list, work, &beam)) bezier_beam_pieces(&beam, iterate_piece);
}

const BezierMethod BEZIER_METHODS[] = {{"clip", false, false, bezier_hits},
                                       {"clip-whole", true, false, bezier_hits},
                                       {"halve", true, true, halving_hits},
                                       {"newton", true, false, newton_hits},
                                       {NULL, false, false, NULL}};
