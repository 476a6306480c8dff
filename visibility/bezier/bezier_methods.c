// bezier_methods.c - ways to find where a ray hits a patch, a row of the table each: Bezier clipping from pieces and from
// the whole patch, halving (Whitted 1980), Newton's steps from a grid of places (after Kajiya 1982, who finds starts by
// algebra; Toth 1985).
#include "visibility/bezier/bezier_methods.h"

#include "visibility/bezier/bezier_beam.h"
#include "visibility/bezier/bezier_clip.h"

// A part of this width is a root: halving gains a bit a time.
#define SMALLEST 1e-12
// A step as small as this is the last.
#define LAST_STEP 1e-13
enum { WAITING = 200, MOST_PARTS = 100000, STARTS = 4, MOST_STEPS = 20 };

// ---- halving

typedef struct Half {
    Four f[4], g[4];
    double u, v, width_u, width_v;
} Half;

static bool misses(const Four row[4], double slack) {
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
    Half waiting[WAITING] = {{.width_u = 1, .width_v = 1}};
    bezier_beam_project(beam, &piece->net, 0, waiting[0].f);
    bezier_beam_project(beam, &piece->net, 1, waiting[0].g);
    int count = 1;
    for (int parts = 0; count > 0; parts++) {
        Half *half = &waiting[--count];
        if (misses(half->f, beam->slack) || misses(half->g, beam->slack)) continue;
        if (half->width_u <= SMALLEST && half->width_v <= SMALLEST) {
            bezier_beam_hit(beam, piece, half->u + half->width_u / 2, half->v + half->width_v / 2);
            continue;
        }
        if (parts >= MOST_PARTS || count + 2 > WAITING) {
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
    for (int i = 0; i < MOST_STEPS; i++) {
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
        if (fabs(du) + fabs(dv) < LAST_STEP) return *u >= 0 && *u <= 1 && *v >= 0 && *v <= 1;
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
