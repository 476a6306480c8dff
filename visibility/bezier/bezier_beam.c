// bezier_beam.c - a ray about a patch: its two planes (Kajiya 1982), its way down the tree of pieces, and its hits.
#include "visibility/bezier/bezier_beam.h"

// Distances that count as 0, of the patch's size: rounding of the ray, of its origin ten sizes away, and of the net.
#define ROUNDING 4e-14
// Hits with t no more than this apart, of the size, and the same normal, are one that was found in two parts; of grazing
// rays those whose distance from the ray differs by no more than rounding, too.
#define SAME_HIT 1e-11
#define SAME_NORMAL 1e-8  // 1 - cosine
// The least slope of a ray against a patch that counts there.
#define LEAST_SLOPE 1e-9

void bezier_beam_project(const BezierBeam *beam, const PatchNet *net, int plane, Four out[4]) {
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

void bezier_beam_hit(const BezierBeam *beam, const PatchPiece *piece, double u, double v) {
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
enum { WAITING = 3 * PATCH_DEPTH + 4 };

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

bool bezier_beam(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work, BezierBeam *out) {
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

void bezier_beam_pieces(const BezierBeam *beam,
                        void (*each)(const BezierBeam *beam, const PatchPiece *piece)) {
    const BezierPatch *patch = beam->patch;
    Vec3 inverse_d = vec3(inverse(beam->d.x), inverse(beam->d.y), inverse(beam->d.z));
    Entry waiting[WAITING] = {{0, -INFINITY}};
    for (int count = 1; count > 0;) {
        Entry entry = waiting[--count];
        if (entry.t + beam->start >= beam->list->far) continue;
        if (entry.child < 0)
            each(beam, &patch->pieces[~entry.child]);
        else
            count += children_met(beam, &inverse_d, &patch->nodes[entry.child], waiting + count);
    }
}
