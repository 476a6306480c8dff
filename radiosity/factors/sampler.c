// sampler.c - blocks of directions with boxes about them, and the rasteriser that finds the face seen along each direction.
//
// The boxes replace bounds of faces: a great circle's extent on the disc or the cube needs care (extrema on arcs, on the rim),
// while the sign of a form over a box of directions takes three multiplications, and works for any set of directions.
#include "radiosity/factors/sampler.h"

#include <math.h>
#include <string.h>

#include "engine/core/lanes.h"
#include "radiosity/factors/row.h"
#include "radiosity/mesh/lines.h"

enum { GROUP_SIDE = 4, GROUP_BLOCKS = GROUP_SIDE * GROUP_SIDE };

// 8 rows of 8 directions. A block is flat if the x of a direction depends on its column alone and the y on its row alone, as on the
// disc; `columns` and `rows` then hold them, and less memory is read.
typedef struct SampleBlock {
    Lane z[SAMPLER_BLOCK], rows, columns, x[SAMPLER_BLOCK], y[SAMPLER_BLOCK];
} SampleBlock;

// The depths seen in a block, as 1 / distance (INFINITY for places without a sample), and the faces seen (in Mesh.faces; -1: nothing).
typedef struct ItemBlock {
    Lane near[SAMPLER_BLOCK];
    LaneInt face[SAMPLER_BLOCK];
} ItemBlock;

// For each of eight blocks or groups, the box about its directions, as its middle and half its size, and the least 1 / distance
// seen in it. The boxes are enlarged by the rounding of a form.
typedef struct SampleBoxes {
    Lane x, y, z, half_x, half_y, half_z;
    Lane far;
} SampleBoxes;

// The linear form dot((x, y, z), w) of a direction w, as floats, and the absolute values of its coefficients.
typedef struct Form {
    float x, y, z, unused;
    float abs_x, abs_y, abs_z, unused_abs;
} Form;

typedef struct GridForm {
    float x, y, z;
} GridForm;

// Codes in place of the index of a square: no face, the back of a face, a face whose squares must be looked up.
enum { NOTHING = -1, BACK = -2, MANY = -3 };

// A view's eye, its axes as columns, so that x * v.x + y * v.y + z * v.z is v in these axes, and the turn of the samples'
// axes: each coordinate times `stay`, plus the other of x and y times `cross`.
typedef struct ViewFrame {
    Four x, y, z, stay, cross;
    Vec3 eye;
} ViewFrame;

static inline Four view_frame_of(const ViewFrame *frame, Vec3 v) {
    return frame->x * v.x + frame->y * v.y + frame->z * v.z;
}

// Turns a vector from the view's axes to the samples' axes.
static inline Four view_frame_turned(const ViewFrame *frame, Four v) {
    return v * frame->stay + __builtin_shufflevector(v, v, 1, 0, 3, 2) * frame->cross;
}

// The grid of a face in view: a direction w meets column dot(column, w) * distance, and row likewise.
typedef struct SeenGrid {
    GridForm column, row;
    int first_square, nx, ny;
    int one;  // the square for the whole face, NOTHING or BACK; MANY: meet_face finds the squares
} SeenGrid;

// Samples in even columns and rows, as on the disc: column i lies at first[0] + i / per_unit, row j at first[1] + j / per_unit.
typedef struct EvenGrid {
    double first[2], per_unit;  // per_unit 0: the samples lie otherwise
    int size[2];                // columns and rows
    int across;                 // groups in a row of them
} EvenGrid;

struct Sampler {
    const Mesh *mesh;
    FaceLines outlines;
    double cosine, sine;         // of the turn of the samples' axes from the view's
    SampleBlock *blocks;         // [block_count]
    ItemBlock *items, *nothing;  // [block_count]; `nothing` is `items` before anything is drawn
    unsigned char
        *masks;      // [block_count * SAMPLER_BLOCK] for each row of 8: bit i, there is a sample in lane i
    float *weights;  // [block_count * 64] 0 where there is no sample
    SampleBoxes *block_boxes, *group_boxes;  // [group_count * 2], [(group_count + 15) / 16 * 2]
    int group_count, block_count;
    // [group_count] the group's first block in `blocks`, which has only blocks with samples
    int *first_block;
    unsigned short *used;  // [group_count] bit i: box i has samples
    FormFactorSamples samples;
    bool flat;  // all blocks are flat
    EvenGrid even;
    bool equal;  // all weights are the same: shares are counts of samples
    // The current view.
    ViewFrame frame;
    int *grid_stamp;  // [face_count] the view for which grids[face] was made
    int *lone;        // [face_count] for faces of one element a square that has it, else MANY
    int *view_index;  // [face_count] the index in view->faces of the faces in view
    SeenGrid *grids;  // [face_count]
    Form *edges;      // [most_edges] of the face being drawn: a direction is inside where no form is below 0
    const Form **crossing;  // [most_edges] scratch, see Drawing
    unsigned *crossed;      // [most_edges] scratch, see Drawing
    int *stamp;             // [1]
};

typedef struct SamplerView {
    const Sampler *sampler;
    const View *view;
} SamplerView;

// The x and y axes of the samples, in building space.
static inline void sampler_axes(const Sampler *s, const View *view, Vec3 *x, Vec3 *y) {
    *x = vec3_add(vec3_scale(view->x, s->cosine), vec3_scale(view->y, s->sine));
    *y = vec3_sub(vec3_scale(view->y, s->cosine), vec3_scale(view->x, s->sine));
}

// ---- which of two faces is seen along a direction where floats cannot tell their distances apart: along the line where
// the faces meet, and where they lie in one plane.
//
// Behind a wall without thickness the ceiling of the next room ends on the wall. A direction within a rounding of this line is
// inside both faces, at one distance, and must never see the ceiling, or light leaks through the wall. Inside the edges of both
// faces the ceiling is clearly the farther one. The direction is therefore moved a little inwards from the nearby edges of either
// face, and the distances are compared there, in doubles.

// How far a direction is moved from each nearby edge, radians: well above the rounding of an edge's form, 4e-7, which may have put
// the direction on the wrong side, and less than any visible detail.
static const double INWARDS = 1e-5;
// An edge is nearby if the sine of its angle to the direction is below this: the direction could be moved across it.
static const double AT_EDGE = 4e-5;
// Faces nearer to each other than this lie in one plane, metres: above the noise of coordinates 1,000 km from the origin, below
// the distance of sheets 2e-7 apart (analytic.c).
static const double ONE_PLANE = 1e-8;
// The error of a face's 1 / distance, as a share of the sum of its coefficients: three products and sums of floats, and the rounding
// of their factors; doubled, because two faces are compared.
#define ROUNDING (8 * 0x1p-24f)
// The coefficients of faces nearer than this, metres, count as at this distance: otherwise all directions of these faces would be ties.
#define NEAREST 1e-3f
// By how much, 1/m, rounding may change the difference of the 1 / distances of two faces, whatever the faces.
static const float TIE = ROUNDING * (1 / NEAREST);
// The same of two faces, of which this is the one with the larger coefficients.
static float tie_within(const Form *near) {
    return ROUNDING * fminf(near->abs_x + near->abs_y + near->abs_z, 1 / NEAREST);
}

static const ViewFace *view_face(const SamplerView *of, int face) {
    return &of->view->faces[of->sampler->view_index[face]];
}

// Among two faces in one place, is the first one seen?
static bool is_first(const ViewFace *a, const ViewFace *b) {
    return form_factor_rank(a) < form_factor_rank(b);
}

// For two faces in one plane: 1, the first face is seen; -1, the other one. 0: they do not lie in one plane. The vertices of the face of
// higher index are compared with the plane of the other one, so that the order in which faces are drawn does not matter.
static int sampler_tie_of_planes(const SamplerView *of, int face, int other) {
    const ViewFace *a = view_face(of, face < other ? face : other),
                   *b = view_face(of, face < other ? other : face);
    for (int i = 0; i < b->vertex_count; i++)
        if (fabs(vec3_dot(a->n, of->view->vertices[b->first_vertex + i]) - a->d) > ONE_PLANE) return 0;
    return is_first(a, b) == (face < other) ? 1 : -1;
}

// A vertex of an edge (`name` as in FaceEdge), from the eye, in the view's axes.
static Vec3 mesh_vertex_of(const SamplerView *of, const ViewFace *face, int name) {
    const View *view = of->view;
    if (name >= 0) return view->vertices[face->first_vertex + name];
    Vec3 off = vec3_sub(of->sampler->mesh->vertices[~name], view->eye);
    return vec3(vec3_dot(view->x, off), vec3_dot(view->y, off), vec3_dot(view->z, off));
}

// The sum of the inward normals of the edges of a face that are near direction w, all in the view's axes.
static Vec3 inwards_from_edges(const SamplerView *of, const ViewFace *face, Vec3 w) {
    const FaceLines *o = &of->sampler->outlines;
    double side = face->d > 0 ? 1 : -1;
    Vec3 sum = {0, 0, 0};
    for (int i = o->first_edge[face->face]; i < o->first_edge[face->face + 1]; i++) {
        Vec3 p = mesh_vertex_of(of, face, o->edges[i].from), q = mesh_vertex_of(of, face, o->edges[i].to);
        Vec3 n = vec3_normalize(vec3_cross(p, q));
        if (side * vec3_dot(n, w) < AT_EDGE) sum = vec3_add(sum, vec3_scale(n, side));
    }
    return sum;
}

// Is the first face seen along w (in the samples' axes), a direction inside both faces? Not inlined: in inlined code GCC 12.2
// contracts the two sums of `at` in spite of -ffp-contract=off (its bug 106902), and ties within a last bit are decided differently.
static __attribute__((noinline)) bool sampler_tie_along(const SamplerView *of, int face, int other, Vec3 w) {
    const ViewFace *a = view_face(of, face), *b = view_face(of, other);
    const Sampler *s = of->sampler;
    Vec3 at = vec3(w.x * s->cosine - w.y * s->sine, w.x * s->sine + w.y * s->cosine, w.z);
    Vec3 inwards = vec3_add(inwards_from_edges(of, a, at), inwards_from_edges(of, b, at));
    at = vec3_add(at, vec3_scale(inwards, INWARDS));
    double nearer = vec3_dot(a->n, at) / a->d - vec3_dot(b->n, at) / b->d;
    return nearer != 0 ? nearer > 0 : is_first(a, b);
}

// ---- finds the face seen along each direction.
//
// A direction w is inside a face iff dot(line, w) has the right sign for the great circle of each of its edges. Along w the face is
// at 1 / distance = dot(n, w) / d, which is linear in w. The forms are computed in doubles and converted to floats before they are
// applied to directions. Two faces along one line share its form to the last bit, but for the sign, so no direction falls between
// them; a direction exactly on the line is inside both, and the depth or form_factor_rank decides.
//
// Faces that floats cannot tell apart along a direction are compared in doubles.
//
// The search is hierarchical (Greene, Kass & Miller 1993): groups of 32 x 32 directions, blocks of 8 x 8, rows of 8. A face skips
// groups and blocks that its edges exclude, and those where everything seen so far is nearer.

// How much nearer than its corners a face may be because of rounding and bent polygons, as a share of the distance.
#define NEAREST_MARGIN 1e-3

// A face on its way through the hierarchy.
typedef struct Drawing {
    Form near;
    float nearest;  // upper bound of 1 / distance on the face
    float tie;      // 1 / distances that differ by no more than this are compared in doubles
    int face;
    bool by_depth;  // blocks where everything seen is nearer are skipped
    const SamplerView *of;
    const Form *edges;  // [edge_count]
    int edge_count, crossing_count;
    unsigned *crossed;  // [edge_count] scratch: which of the boxes each edge crosses
    const Form **
        crossing;  // [crossing_count] the edges that may cross the current block: only these are tested in it
} Drawing;

static ViewFrame frame_of(const Sampler *s, const View *view) {
    Vec3 x = view->x, y = view->y, z = view->z;
    return (ViewFrame){.x = {x.x, y.x, z.x, 0},
                       .y = {x.y, y.y, z.y, 0},
                       .z = {x.z, y.z, z.z, 0},
                       .stay = {s->cosine, s->cosine, 1, 0},
                       .cross = {s->sine, -s->sine, 0, 0},
                       .eye = view->eye};
}

static inline Form form_of(Four v) {
    typedef float FourFloats __attribute__((vector_size(16)));
    typedef int32_t FourInts __attribute__((vector_size(16)));
    union {
        Form form;
        FourFloats part[2];
    } u;
    u.part[0] = __builtin_convertvector(v, FourFloats);
    u.part[1] = (FourFloats)((FourInts)u.part[0] & 0x7fffffff);
    return u.form;
}

// The form that gives a face's 1 / distance along a direction, in the samples' axes.
static inline Form near_form(const ViewFrame *frame, const ViewFace *face) {
    Four n = {face->n.x, face->n.y, face->n.z, 0};
    return form_of(view_frame_turned(frame, n) * (1 / face->d));
}

// How many faces ahead memory is prefetched: FAR_AHEAD for the index of a face's edges, AHEAD for the edges.
enum { AHEAD = 8, FAR_AHEAD = 16 };

static inline void fetch_ahead(const Sampler *s, const View *view, int at) {
    const FaceLines *o = &s->outlines;
    if (at + FAR_AHEAD < view->face_count)
        __builtin_prefetch(&o->first_edge[view->faces[at + FAR_AHEAD].face]);
    if (at + AHEAD < view->face_count)
        __builtin_prefetch(&o->edges[o->first_edge[view->faces[at + AHEAD].face]]);
}

// A vertex of an edge (`name` as in FaceEdge), from the eye, equal to the view's to the last bit; the fourth number is undefined.
static inline Four vertex_of(const Sampler *s, const ViewFrame *frame, const Vec3 *own, int name) {
    Four v;
    if (name >= 0) {
        memcpy(&v, own + name, sizeof v);
        return v;
    }
    Vec3 off = vec3_sub(s->mesh->vertices[~name], frame->eye);
    return view_frame_of(frame, off);
}

// Makes the form of each edge of a face: the normal of the plane through the edge and the eye, of any length, in the samples' axes.
static inline int make_edges(Sampler *s, const ViewFrame *frame, const View *view, const ViewFace *face) {
    const FaceLines *o = &s->outlines;
    int first = o->first_edge[face->face], count = o->first_edge[face->face + 1] - first;
    const Vec3 *own = view->vertices + face->first_vertex;
    double side = face->d > 0 ? 1 : -1;  // seen from behind, edges go counter-clockwise
    for (int i = 0; i < count; i++) {
        const FaceEdge *edge = &o->edges[first + i];
        Four p = vertex_of(s, frame, own, edge->from), q = vertex_of(s, frame, own, edge->to);
        Four turn_p = __builtin_shufflevector(p, p, 1, 2, 0, 3),
             turn_q = __builtin_shufflevector(q, q, 1, 2, 0, 3);
        Four n = p * turn_q - turn_p * q;
        s->edges[i] = form_of(view_frame_turned(frame, __builtin_shufflevector(n, n, 1, 2, 0, 3)) * side);
    }
    return count;
}

// An upper bound of 1 / distance for the whole face, from its corners along the direction of their middle, never more than 1 / d but
// for the margin. A larger value is due to the rounding of a plane seen edge-on.
static float nearest_of(const View *view, const ViewFace *face) {
    const Vec3 *v = view->vertices + face->first_vertex;
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < face->vertex_count; i++) sum = vec3_add(sum, v[i]);
    double least = INFINITY;
    for (int i = 0; i < face->vertex_count; i++) {
        double along = vec3_dot(sum, v[i]);
        least = along < least ? along : least;
    }
    double length = vec3_length(sum), away = fabs(face->d);
    if (least > away * length) away = least / length;
    return (float)((1 + NEAREST_MARGIN) / away);
}

// ---- boxes

// The value of a form in the middle of each box (middle_in), and how far it may differ from it in the box (spread_in).
static inline Lane middle_in(const SampleBoxes *b, const Form *f) {
    return lane_multiply_add(lane_of(f->x), b->x,
                             lane_multiply_add(lane_of(f->y), b->y, lane_of(f->z) * b->z));
}
static inline Lane spread_in(const SampleBoxes *b, const Form *f) {
    return lane_multiply_add(lane_of(f->abs_x), b->half_x,
                             lane_multiply_add(lane_of(f->abs_y), b->half_y, lane_of(f->abs_z) * b->half_z));
}

static inline LaneInt boxes_before(const SampleBoxes *b, const Drawing *d) {
    Lane nearest = lane_least(middle_in(b, &d->near) + spread_in(b, &d->near), lane_of(d->nearest));
    return (nearest + d->tie >= b->far) & (nearest > 0);
}

static inline LaneInt boxes_at_edge(const SampleBoxes *b, const Form *edge, LaneInt *crossed) {
    Lane middle = middle_in(b, edge), spread = spread_in(b, edge);
    *crossed = middle <= spread;
    return middle + spread >= 0;
}

// Picks from sixteen boxes those in which the face may be seen; bit i of crossed[e] is set where edge e may cross box i.
static inline unsigned boxes_reached(const SampleBoxes b[2], const Drawing *d) {
    LaneInt low = boxes_before(&b[0], d), high = boxes_before(&b[1], d);
    if (lane_mask(low | high) == 0) return 0;
    for (int e = 0; e < d->edge_count; e++) {
        LaneInt crossed_low, crossed_high;
        low &= boxes_at_edge(&b[0], &d->edges[e], &crossed_low);
        high &= boxes_at_edge(&b[1], &d->edges[e], &crossed_high);
        d->crossed[e] = lane_mask(crossed_low) | lane_mask(crossed_high) << LANES;
    }
    return lane_mask(low) | lane_mask(high) << LANES;
}

// Lists the edges that may cross box i in d->crossing; returns how many.
static inline int choose_edges(const Drawing *d, int i) {
    int count = 0;
    for (int e = 0; e < d->edge_count; e++) {
        d->crossing[count] = &d->edges[e];
        count += (int)(d->crossed[e] >> i & 1);
    }
    return count;
}

// ---- directions

// A form's values along the eight directions of a block's row.
static inline Lane form_at(const Form *f, const SampleBlock *b, int row, bool flat) {
    Lane across = lane_of(f->x) * (flat ? b->columns : b->x[row]);
    Lane y = flat ? lane_of(((const float *)&b->rows)[row]) : b->y[row];
    return lane_multiply_add(lane_of(f->z), b->z[row], lane_multiply_add(lane_of(f->y), y, across));
}

// Among the directions `tied` in a row, which see another face (`before`) at about the same distance, returns those that see the new face.
// `nearer`: the difference of the 1 / distances, which decides where it is more than rounding of these two faces.
static LaneInt settle_row(const Drawing *d, const SampleBlock *b, int row, LaneInt tied, LaneInt before,
                          Lane nearer) {
    LaneInt wins = {0};
    for (unsigned left = lane_mask(tied); left;) {
        int other = before[__builtin_ctz(left)];
        LaneInt these = tied & (before == lane_int_of(other));
        left &= ~lane_mask(these);
        if (other < 0) {
            wins |= these;
            continue;
        }
        Form near = near_form(&d->of->sampler->frame, view_face(d->of, other));
        float tie = fmaxf(tie_within(&d->near), tie_within(&near));
        wins |= these & (nearer > tie);
        unsigned same = lane_mask(these & (lane_abs(nearer) <= tie));
        // Mostly the two faces lie in one plane, and the order is the same for all directions.
        int all = same ? sampler_tie_of_planes(d->of, d->face, other) : 0;
        for (; same; same &= same - 1) {
            int i = __builtin_ctz(same);
            Vec3 w = vec3((double)b->x[row][i], (double)b->y[row][i], (double)b->z[row][i]);
            wins[i] = all > 0 || (all == 0 && sampler_tie_along(d->of, d->face, other, w)) ? -1 : 0;
        }
    }
    return wins;
}

// Decides the ties that draw_inside and draw_row left open. The depths change by no more than a tie.
static __attribute__((noinline)) void settle(const SampleBlock *b, ItemBlock *items, const Drawing *d,
                                             const LaneInt outside[SAMPLER_BLOCK], int first, int end) {
    for (int row = first; row < end; row++) {
        Lane value = lane_least(form_at(&d->near, b, row, false), lane_of(d->nearest));
        LaneInt before = items->face[row];
        LaneInt tied = ~outside[row] & (lane_abs(value - items->near[row]) <= d->tie) & (before != d->face);
        if (lane_mask(tied) == 0) continue;
        LaneInt wins = settle_row(d, b, row, tied, before, value - items->near[row]);
        items->near[row] = lane_choose(wins, value, items->near[row]);
        items->face[row] = lane_choose_int(wins, lane_int_of(d->face), before);
    }
}

// Stores the face at the places inside its edges where it is nearer than the face seen so far. Returns the least 1 / distance now
// seen in the block.
static inline float draw_inside(const SampleBlock *b, ItemBlock *items, const Drawing *d,
                                const LaneInt outside[SAMPLER_BLOCK], bool flat) {
    Lane far = lane_of(INFINITY), nearest = lane_of(d->nearest);
    LaneInt face = lane_int_of(d->face), open = {0};
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        Lane value = lane_least(form_at(&d->near, b, row, flat), nearest), old = items->near[row];
        Lane nearer = value - old;
        LaneInt in = ~outside[row] & (nearer > d->tie);  // only the sign bit of `outside` counts
        open |= ~outside[row] & (lane_abs(nearer) <= d->tie);
        Lane now = lane_choose(in, value, old);
        items->near[row] = now;
        items->face[row] = lane_choose_int(in, face, items->face[row]);
        far = lane_least(far, now);
    }
    if (__builtin_expect(lane_mask(open) != 0, 0)) settle(b, items, d, outside, 0, SAMPLER_BLOCK);
    return lane_least_of(far);
}

// Draws a face in a block. A direction is inside where no form is below 0, that is, no sign bit is set.
static inline void draw_block(const SampleBlock *b, ItemBlock *items, const Drawing *d, float *far,
                              bool flat) {
    LaneInt outside[SAMPLER_BLOCK], all = ~(LaneInt){0};
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) outside[row] = (LaneInt){0};
    for (int e = 0; e < d->crossing_count; e++) {
        Form edge = *d->crossing[e];
        LANE_UNROLL
        for (int row = 0; row < SAMPLER_BLOCK; row++) outside[row] |= lane_bits(form_at(&edge, b, row, flat));
    }
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) all &= outside[row];
    if (lane_mask(all) != 0xff) *far = draw_inside(b, items, d, outside, flat);
}

// Draws a face in a group; returns how many blocks were tested.
static inline int draw_group(Sampler *s, int group, Drawing *d) {
    SampleBoxes *boxes = &s->block_boxes[group * 2];
    unsigned reached = boxes_reached(boxes, d), used = s->used[group];
    int count = __builtin_popcount(reached);
    for (; reached; reached &= reached - 1) {
        unsigned bit = reached & -reached;
        int i = __builtin_ctz(reached), block = s->first_block[group] + __builtin_popcount(used & (bit - 1));
        float unused = 0, *far = d->by_depth ? (float *)&boxes[i / LANES].far + i % LANES : &unused;
        d->crossing_count = choose_edges(d, i);
        if (s->flat)
            draw_block(&s->blocks[block], &s->items[block], d, far, true);
        else
            draw_block(&s->blocks[block], &s->items[block], d, far, false);
    }
    return count;
}

static inline float *far_of_group(Sampler *s, int group) {
    return (float *)&s->group_boxes[group / LANES].far + group % LANES;
}

// The least 1 / distance seen in a group, from those of its blocks.
static inline void lift_far(Sampler *s, int group) {
    const SampleBoxes *boxes = &s->block_boxes[group * 2];
    *far_of_group(s, group) = lane_least_of(lane_least(boxes[0].far, boxes[1].far));
}

static inline void draw_in_group(Sampler *s, int group, Drawing *d, FormFactorWork *work) {
    int blocks = draw_group(s, group, d);
    work->tests += blocks * SAMPLER_BLOCK * LANES;
    if (blocks > 0 && d->by_depth) lift_far(s, group);
}

static void draw_face(Sampler *s, Drawing *d, FormFactorWork *work) {
    for (int first = 0; first < s->group_count; first += 2 * LANES) {
        const SampleBoxes *groups = &s->group_boxes[first / LANES];
        for (unsigned reached = boxes_reached(groups, d); reached; reached &= reached - 1)
            draw_in_group(s, first + __builtin_ctz(reached), d, work);
    }
}

// ---- small faces, which most are: a rectangle of columns and rows of samples tells which of them a face can meet. Many meet none.

// The directions from the eye to a face lie in a rectangle of columns and rows of an even grid, both ends included.
typedef struct Span {
    int first[2], last[2];
} Span;

// Faces whose corners' directions differ by more than this, as unit vectors, have no span.
static const double WIDEST_SPAN = 0.5;
// Directions between those of corners lie no farther from the corners' convex hull than this times the square of its width, if that is
// at most WIDEST_SPAN.
static const double ARC = 0.26;
// Added for the rounding of edges, which may put a direction on the wrong side.
static const double SPAN_ROUNDING = 1e-5;

// False: the face is too wide.
static inline bool find_span(const Sampler *s, const View *view, const ViewFace *face, Span *out) {
    const Vec3 *v = view->vertices + face->first_vertex;
    Four x0 = four_of(INFINITY), y0 = x0, z0 = x0, x1 = -x0, y1 = x1, z1 = x1, closest = {0};
    for (int first = 0, end = face->vertex_count - 1; first <= end; first += FOUR) {
        Four at[FOUR];
        for (int i = 0; i < FOUR; i++) memcpy(&at[i], v + (first + i < end ? first + i : end), sizeof at[i]);
        four_transpose(at);
        Four scale = 1 / four_root(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
        Four x = (at[0] * s->cosine + at[1] * s->sine) * scale,
             y = (at[1] * s->cosine - at[0] * s->sine) * scale, z = at[2] * scale;
        x0 = four_least(x0, x), y0 = four_least(y0, y), z0 = four_least(z0, z);
        x1 = four_most(x1, x), y1 = four_most(y1, y), z1 = four_most(z1, z);
        closest = four_most(closest, scale);
    }
    Four ends[FOUR] = {x0, y0, -x1, -y1}, other[FOUR] = {z0, -z1, -closest, -closest};
    four_transpose(ends);
    four_transpose(other);
    Four low = four_least_row(ends), rest = four_least_row(other);
    double width[3] = {low[0] + low[2], low[1] + low[3], rest[0] + rest[1]};
    double width2 = width[0] * width[0] + width[1] * width[1] + width[2] * width[2];
    // The vertices of lines may lie off the corners.
    double margin = ARC * width2 + SPAN_ROUNDING - 2 * RAD_STRAIGHT * rest[2];
    if (!(width2 < WIDEST_SPAN * WIDEST_SPAN && margin < WIDEST_SPAN)) return false;
    const EvenGrid *even = &s->even;
    Four from = (low - margin - (Four){even->first[0], even->first[1], -even->first[0], -even->first[1]}) *
                even->per_unit;
    for (int k = 0; k < 2; k++) {
        int first = (int)ceil(from[k]), last = -(int)ceil(from[k + 2]);
        out->first[k] = first > 0 ? first : 0;
        out->last[k] = last < even->size[k] - 1 ? last : even->size[k] - 1;
    }
    return true;
}

// Which of the faces from `first` on, eight at most, can meet samples, by the spheres about them: a bit for each.
static inline unsigned faces_with_samples(const Sampler *s, const View *view, int first) {
    static const float SMALL_SINE = 0.25f,
                       CHORD = 1.01f;  // of a ball that looks so large or smaller, its chord over its sine
    Lane ball_x, ball_y, ball_z, radius;
    for (int i = 0; i < LANES; i++) {
        const ViewFace *face = &view->faces[first + i < view->face_count ? first + i : view->face_count - 1];
        ball_x[i] = face->centre[0], ball_y[i] = face->centre[1], ball_z[i] = face->centre[2],
        radius[i] = face->radius;
    }
    float cosine = (float)s->cosine, sine = (float)s->sine, per_unit = (float)s->even.per_unit;
    Lane scale = 1 / lane_root(ball_x * ball_x + ball_y * ball_y + ball_z * ball_z), size = radius * scale;
    Lane margin = size * CHORD + (scale * (float)(4 * RAD_STRAIGHT) + (float)SPAN_ROUNDING);
    Lane x = (ball_x * cosine + ball_y * sine) * scale - (float)s->even.first[0],
         y = (ball_y * cosine - ball_x * sine) * scale - (float)s->even.first[1];
    // No whole number lies between two others if the second one, rounded down, is below the first. Both are moved above 0, where
    // conversion rounds down.
    LaneInt last_x = __builtin_convertvector((x + margin + 2) * per_unit, LaneInt),
            last_y = __builtin_convertvector((y + margin + 2) * per_unit, LaneInt);
    LaneInt none = (__builtin_convertvector(last_x, Lane) < (x - margin + 2) * per_unit) |
                   (__builtin_convertvector(last_y, Lane) < (y - margin + 2) * per_unit);
    return 0xff & ~lane_mask(none & (size < SMALL_SINE));
}

// Draws a face in a row of a block. True: a depth has changed.
static inline bool draw_row(const SampleBlock *b, ItemBlock *items, const Drawing *d, int row) {
    LaneInt outside = {0};
    for (int e = 0; e < d->edge_count; e++) outside |= lane_bits(form_at(&d->edges[e], b, row, true));
    if (lane_mask(outside) == 0xff) return false;
    Lane value = lane_least(form_at(&d->near, b, row, true), lane_of(d->nearest)), old = items->near[row];
    Lane nearer = value - old;
    LaneInt in = ~outside & (nearer > d->tie), open = ~outside & (lane_abs(nearer) <= d->tie);
    items->near[row] = lane_choose(in, value, old);
    items->face[row] = lane_choose_int(in, lane_int_of(d->face), items->face[row]);
    if (__builtin_expect(lane_mask(open) != 0, 0)) {
        LaneInt all[SAMPLER_BLOCK];
        all[row] = outside;
        settle(b, items, d, all, row, row + 1);
    }
    return lane_mask(in) != 0;
}

static inline float least_near(const ItemBlock *items) {
    Lane far = items->near[0];
    LANE_UNROLL
    for (int row = 1; row < SAMPLER_BLOCK; row++) far = lane_least(far, items->near[row]);
    return lane_least_of(far);
}

// Draws a face in the rows `first` .. `last` of a block; `far`: the least 1 / distance seen in it.
static inline void draw_rows(Sampler *s, int group, int block, float *far, const Drawing *d, int first,
                             int last) {
    bool changed = false;
    for (int row = first; row <= last; row++)
        changed |= draw_row(&s->blocks[block], &s->items[block], d, row);
    if (!changed || !d->by_depth) return;
    float now = least_near(&s->items[block]);
    if (now == *far) return;
    *far = now;
    lift_far(s, group);
}

// Draws a small face in the blocks that its span reaches. Its edges are made where one of them does not hide it.
static void draw_small(Sampler *s, const Span *span, Drawing *d, FormFactorWork *work) {
    enum { SHIFT = 3, IN_GROUP = GROUP_SIDE - 1 };
    for (int j = span->first[1] >> SHIFT; j <= span->last[1] >> SHIFT; j++) {
        for (int i = span->first[0] >> SHIFT; i <= span->last[0] >> SHIFT; i++) {
            int group = j / GROUP_SIDE * s->even.across + i / GROUP_SIDE,
                k = j % GROUP_SIDE * GROUP_SIDE + i % GROUP_SIDE;
            unsigned used = s->used[group], bit = 1u << k;
            float *far = (float *)&s->block_boxes[group * 2 + k / LANES].far + k % LANES;
            if (!(used & bit) || d->nearest + d->tie < *far) continue;
            if (d->edge_count == 0)
                d->edge_count = make_edges(s, &s->frame, d->of->view, view_face(d->of, d->face));
            int first = span->first[1] - (j << SHIFT), last = span->last[1] - (j << SHIFT);
            draw_rows(s, group, s->first_block[group] + __builtin_popcount(used & (bit - 1)), far, d,
                      first > 0 ? first : 0, last < SAMPLER_BLOCK - 1 ? last : SAMPLER_BLOCK - 1);
            work->tests += SAMPLER_BLOCK * LANES;
        }
    }
}

// Most blocks along either axis that a small face reaches into.
enum { SMALL = 2 };

static inline bool is_small(const Span *span) {
    for (int k = 0; k < 2; k++)
        if (span->last[k] / SAMPLER_BLOCK - span->first[k] / SAMPLER_BLOCK >= SMALL) return false;
    return true;
}

// Draws a face in the groups that its span reaches.
static void draw_medium(Sampler *s, const Span *span, Drawing *d, FormFactorWork *work) {
    enum { SIDE = SAMPLER_BLOCK * GROUP_SIDE };
    for (int j = span->first[1] / SIDE; j <= span->last[1] / SIDE; j++)
        for (int i = span->first[0] / SIDE; i <= span->last[0] / SIDE; i++) {
            int group = j * s->even.across + i;
            if (!(d->nearest + d->tie < *far_of_group(s, group))) draw_in_group(s, group, d, work);
        }
}

static void clear(Sampler *s) {
    memcpy(s->items, s->nothing, (size_t)s->block_count * sizeof *s->items);
    Lane none = lane_of(INFINITY);
    for (int k = 0; k < s->group_count * 2; k++)
        s->block_boxes[k].far = lane_choose(s->block_boxes[k].half_x > 0, (Lane){0}, none);
    for (int k = 0; k * LANES < s->group_count; k++)
        s->group_boxes[k].far = lane_choose(s->group_boxes[k].half_x > 0, (Lane){0}, none);
}

// ---- clusters

// The rectangle of columns and rows of an even grid that the directions to a box lie in; all of the grid where the box is wide.
static inline void find_box_span(const Sampler *s, const View *view, const ViewCluster *cluster, Span *out) {
    static const Lane SIGN[3] = {
        {-1, 1, -1, 1, -1, 1, -1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, -1, -1, -1, 1, 1, 1, 1}};
    Lane at[3], along[2];
    for (int c = 0; c < 3; c++) {
        Vec3 axis = c == 0 ? view->x : c == 1 ? view->y : view->z;
        at[c] = cluster->centre[c] + (cluster->half[0] * (float)axis.x) * SIGN[0] +
                (cluster->half[1] * (float)axis.y) * SIGN[1] + (cluster->half[2] * (float)axis.z) * SIGN[2];
    }
    Lane scale = 1 / lane_root(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
    const float cosine = (float)s->cosine, sine = (float)s->sine;
    along[0] = (at[0] * cosine + at[1] * sine) * scale;
    along[1] = (at[1] * cosine - at[0] * sine) * scale;
    at[2] *= scale;
    float low[2], high[2], up = -lane_least_of(-at[2]) - lane_least_of(at[2]), width2 = up * up;
    for (int k = 0; k < 2; k++) {
        low[k] = lane_least_of(along[k]), high[k] = -lane_least_of(-along[k]);
        width2 += (high[k] - low[k]) * (high[k] - low[k]);
    }
    float margin = (float)ARC * width2 + (float)SPAN_ROUNDING + (float)(4 * RAD_STRAIGHT) * cluster->nearest;
    bool wide = !(width2 < (float)(WIDEST_SPAN * WIDEST_SPAN) && margin < (float)WIDEST_SPAN);
    const EvenGrid *even = &s->even;
    for (int k = 0; k < 2; k++) {
        float first = (float)even->first[k], per_unit = (float)even->per_unit,
              last = (float)(even->size[k] - 1);
        out->first[k] = wide ? 0 : (int)fmaxf(ceilf((low[k] - margin - first) * per_unit), 0);
        out->last[k] = wide ? (int)last : (int)fminf(floorf((high[k] + margin - first) * per_unit), last);
    }
}

// Is something at most as near as `nearest`, 1 / distance, seen in a rectangle of samples? Elsewhere it is hidden.
static bool is_open(const Sampler *s, const Span *span, float nearest) {
    enum { SHIFT = 3 };
    static const LaneInt LANE = {0, 1, 2, 3, 4, 5, 6, 7};
    Lane limit = lane_of(nearest);
    for (int j = span->first[1] >> SHIFT; j <= span->last[1] >> SHIFT; j++) {
        int first = span->first[1] - (j << SHIFT), last = span->last[1] - (j << SHIFT);
        first = first > 0 ? first : 0;
        last = last < SAMPLER_BLOCK - 1 ? last : SAMPLER_BLOCK - 1;
        for (int i = span->first[0] >> SHIFT; i <= span->last[0] >> SHIFT; i++) {
            int group = j / GROUP_SIDE * s->even.across + i / GROUP_SIDE,
                k = j % GROUP_SIDE * GROUP_SIDE + i % GROUP_SIDE;
            float far = ((const float *)&s->block_boxes[group * 2 + k / LANES].far)[k % LANES];
            if (nearest < far) continue;
            unsigned before = s->used[group] & ((1u << k) - 1);
            const Lane *near = s->items[s->first_block[group] + __builtin_popcount(before)].near;
            LaneInt any = {0}, column = LANE + (i << SHIFT);
            for (int row = first; row <= last; row++) any |= near[row] <= limit;
            if (lane_mask(any & (column >= span->first[0]) & (column <= span->last[0]))) return true;
        }
    }
    return false;
}

// May a sample see a face of a cluster, by the box about it and the depths seen so far?
static bool may_see_cluster(const Sampler *s, const View *view, const ViewCluster *cluster) {
    Span span;
    find_box_span(s, view, cluster, &span);
    if (span.first[0] > span.last[0] || span.first[1] > span.last[1]) return false;
    return !view->by_depth || is_open(s, &span, cluster->nearest * (1 + (float)NEAREST_MARGIN) + TIE);
}

// Faces that are nearer than this, metres, are listed.
#define TOO_NEAR 1e-3f

// Which faces of a cluster may a sample see? A bit for each. The same tests that are made of other faces one by one, in floats and a little
// wider. `wide`: those that have no span.
static unsigned faces_to_list(const Sampler *s, const View *view, int index, unsigned *wide, Span *span) {
    Lane v[CLUSTER_CORNERS][3], sum[3] = {{0}};
    view_corners(view, index, (float(*)[3][LANES])v);
    const Lane none = lane_of(INFINITY);
    Lane low[3] = {none, none, none}, high[3] = {-none, -none, -none}, closest = {0}, least = none;
    const float cosine = (float)s->cosine, sine = (float)s->sine;
    for (int i = 0; i < CLUSTER_CORNERS; i++) {
        for (int c = 0; c < 3; c++) sum[c] += v[i][c];
        Lane scale = 1 / lane_root(v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
        const Lane w[3] = {(v[i][0] * cosine + v[i][1] * sine) * scale,
                           (v[i][1] * cosine - v[i][0] * sine) * scale, v[i][2] * scale};
        for (int c = 0; c < 3; c++) low[c] = lane_least(low[c], w[c]), high[c] = lane_most(high[c], w[c]);
        closest = lane_most(closest, scale);
    }
    for (int i = 0; i < CLUSTER_CORNERS; i++)
        least = lane_least(least, sum[0] * v[i][0] + sum[1] * v[i][1] + sum[2] * v[i][2]);
    least /= lane_root(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    Lane width[3], width2, margin;
    for (int c = 0; c < 3; c++) width[c] = high[c] - low[c];
    width2 = width[0] * width[0] + width[1] * width[1] + width[2] * width[2];
    margin = (float)ARC * width2 + (float)(2 * SPAN_ROUNDING) + (float)(4 * RAD_STRAIGHT) * closest;
    LaneInt keep = ~((width2 < (float)(WIDEST_SPAN * WIDEST_SPAN)) & (margin < (float)WIDEST_SPAN) &
                     (least > TOO_NEAR)),
            above = high[2] > -(float)SPAN_ROUNDING, some = above;
    const EvenGrid *even = &s->even;
    LaneInt first[2], last[2];
    for (int k = 0; k < 2; k++) {
        // Above 0, conversion rounds down.
        Lane shift = (2 - (float)even->first[k]) - margin, from = (low[k] + shift) * (float)even->per_unit,
             to = (high[k] + shift + 2 * margin) * (float)even->per_unit;
        int moved = (int)(2 * even->per_unit);
        first[k] = __builtin_convertvector(from, LaneInt);
        first[k] -= (__builtin_convertvector(first[k], Lane) < from) + moved;
        last[k] = __builtin_convertvector(to, LaneInt) - moved;
        some &= (first[k] <= last[k]) & (last[k] >= 0) & (first[k] < even->size[k]);
    }
    *wide = lane_mask(keep & above);
    unsigned out = *wide;
    Lane nearest = (1 + 2 * (float)NEAREST_MARGIN) / least + TIE;
    for (unsigned left = lane_mask(some) & ~*wide; left; left &= left - 1) {
        int i = __builtin_ctz(left);
        for (int k = 0; k < 2; k++) {
            span[i].first[k] = first[k][i] > 0 ? first[k][i] : 0;
            span[i].last[k] = last[k][i] < even->size[k] ? last[k][i] : even->size[k] - 1;
        }
        out |= (unsigned)(!view->by_depth || is_open(s, &span[i], nearest[i])) << i;
    }
    return out;
}

// Draws face i of the view. `span`: where it is known; NULL: anywhere. No part is nearer than `nearest`, 1 / distance.
static void draw_listed(Sampler *s, const View *view, int i, const Span *span, float nearest,
                        FormFactorWork *work) {
    const ViewFace *face = &view->faces[i];
    SamplerView of = {s, view};
    Drawing d = {.near = near_form(&s->frame, face),
                 .nearest = fminf(nearest_of(view, face), nearest),
                 .tie = TIE,
                 .by_depth = view->by_depth,
                 .of = &of,
                 .edges = s->edges,
                 .crossed = s->crossed,
                 .crossing = s->crossing,
                 .face = face->face};
    if (span && is_small(span)) {
        draw_small(s, span, &d, work);
        return;
    }
    d.edge_count = make_edges(s, &s->frame, view, face);
    if (span)
        draw_medium(s, span, &d, work);
    else
        draw_face(s, &d, work);
}

// Draws the faces that are listed first.
static void draw_faces(Sampler *s, const View *view, FormFactorWork *work) {
    bool even = s->even.per_unit > 0;
    unsigned any = 0xff;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *face = &view->faces[i];
        s->view_index[face->face] = i;
        fetch_ahead(s, view, i);
        if (even && i % LANES == 0) any = faces_with_samples(s, view, i);
        if (!(any >> i % LANES & 1)) continue;
        Span span;
        bool spanned = even && find_span(s, view, face, &span);
        if (spanned && (span.first[0] > span.last[0] || span.first[1] > span.last[1])) continue;
        draw_listed(s, view, i, spanned ? &span : NULL, INFINITY, work);
    }
}

static void draw_cluster(Sampler *s, const View *view, int index, FormFactorWork *work) {
    const ViewCluster *cluster = &view->clusters[index];
    const bool even = s->even.per_unit > 0;
    unsigned wide = VIEW_ALL, list = VIEW_ALL;
    Span span[LANES];
    if (even && !may_see_cluster(s, view, cluster)) return;
    if (even) list = faces_to_list(s, view, index, &wide, span);
    int i = view->face_count;
    for (unsigned listed = view_list(view, index, list); listed; listed &= listed - 1, i++) {
        int lane = __builtin_ctz(listed);
        s->view_index[view->faces[i].face] = i;
        draw_listed(s, view, i, wide >> lane & 1 ? NULL : &span[lane],
                    cluster->nearest * (1 + (float)NEAREST_MARGIN), work);
    }
}

void sampler_draw(Sampler *s, const View *view, FormFactorWork *work) {
    ++*s->stamp;
    clear(s);
    s->frame = frame_of(s, view);
    draw_faces(s, view, work);
    for (int i = 0; i < view->cluster_count; i++)
        if (view->clusters[i].listed != VIEW_ALL) draw_cluster(s, view, i, work);
    work->samples += s->samples.count;
}

// ---- the faces drawn, as items or as shares of elements: for a direction w that sees a face, column and row in the face's grid are
// linear in w over dot(n, w) / d, so that one division finds an element.

void sampler_items(const Sampler *self, int32_t *item) {
    for (int row = 0; row < self->block_count * SAMPLER_BLOCK; row++) {
        const int32_t *face = (const int32_t *)&self->items[row / SAMPLER_BLOCK].face[row % SAMPLER_BLOCK];
        for (unsigned mask = self->masks[row]; mask; mask &= mask - 1) {
            int seen = face[__builtin_ctz(mask)];
            *item++ = seen < 0 ? -1 : self->view_index[seen];
        }
    }
}

static GridForm grid_form(const Sampler *s, Vec3 v) {
    Four turned = view_frame_turned(&s->frame, view_frame_of(&s->frame, v));
    return (GridForm){(float)turned[0], (float)turned[1], (float)turned[2]};
}

static const SeenGrid NO_FACE = {.one = NOTHING};

static const SeenGrid *grid_of(Sampler *s, const View *view, int face) {
    SeenGrid *grid = &s->grids[face];
    if (s->grid_stamp[face] == *s->stamp) return grid;
    s->grid_stamp[face] = *s->stamp;
    const Face *f = &s->mesh->faces[face];
    const ViewFace *seen = &view->faces[s->view_index[face]];
    // Along w the plane's point is w / dot(n / d, w), from the eye.
    Vec3 near = vec3_scale(f->plane.n, 1 / seen->d), from = vec3_sub(view->eye, f->origin);
    Vec3 column = vec3_add(f->gx, vec3_scale(near, vec3_dot(f->gx, from)));
    Vec3 row = vec3_add(f->gy, vec3_scale(near, vec3_dot(f->gy, from)));
    *grid = (SeenGrid){.column = grid_form(s, column),
                       .row = grid_form(s, row),
                       .first_square = f->first_square,
                       .nx = f->nx,
                       .ny = f->ny,
                       .one = seen->d > 0 ? BACK : s->lone[face]};
    return grid;
}

static inline Lane grid_form_at(GridForm f, const SampleBlock *b, int row) {
    return lane_multiply_add(lane_of(f.x), b->x[row],
                             lane_multiply_add(lane_of(f.y), b->y[row], lane_of(f.z) * b->z[row]));
}

// Converts eight numbers to integers, clamped to 0 .. most; NAN becomes 0.
static inline LaneInt whole(Lane a, Lane most) {
    return __builtin_convertvector(lane_least(lane_most(a, (Lane){0}), most), LaneInt);
}

// Stores in `square` the squares in which a block's directions meet the face, for the directions in `here`.
static inline void meet_face(const SeenGrid *grid, const SampleBlock *b, const Lane distance[SAMPLER_BLOCK],
                             const LaneInt here[SAMPLER_BLOCK], LaneInt square[SAMPLER_BLOCK]) {
    Lane last_column = lane_of((float)grid->nx - 0.5f), last_line = lane_of((float)grid->ny - 0.5f);
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        LaneInt column = whole(grid_form_at(grid->column, b, row) * distance[row], last_column);
        LaneInt line = whole(grid_form_at(grid->row, b, row) * distance[row], last_line);
        square[row] =
            lane_choose_int(here[row], line * grid->nx + (column + grid->first_square), square[row]);
    }
}

static inline void put_square(int32_t value, const LaneInt here[SAMPLER_BLOCK],
                              LaneInt square[SAMPLER_BLOCK]) {
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++)
        square[row] = lane_choose_int(here[row], lane_int_of(value), square[row]);
}

// Finds where a block's directions in `mask` end: indices of Mesh.squares, NOTHING or BACK.
static inline void find_squares(Sampler *s, const View *view, int block, uint64_t mask,
                                LaneInt square[SAMPLER_BLOCK]) {
    const LaneInt *faces = s->items[block].face;
    Lane distance[SAMPLER_BLOCK];
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) distance[row] = 1 / s->items[block].near[row];
    for (uint64_t left = mask, seen; left; left &= ~seen) {
        int at = __builtin_ctzll(left), face = ((const int32_t *)faces)[at];
        LaneInt here[SAMPLER_BLOCK];
        seen = 0;
        LANE_UNROLL
        for (int row = 0; row < SAMPLER_BLOCK; row++) {
            here[row] = faces[row] == face;
            seen |= (uint64_t)lane_mask(here[row]) << (row * LANES);
        }
        const SeenGrid *grid = face < 0 ? &NO_FACE : grid_of(s, view, face);
        if (grid->one == MANY)
            meet_face(grid, &s->blocks[block], distance, here, square);
        else
            put_square(grid->one, here, square);
    }
}

// The element of a direction whose square has none or several, because of rounding or a slanted edge. `side` and `up`: the samples' axes.
static int element_beside(const Sampler *s, const View *view, Vec3 side, Vec3 up, int block, int at) {
    const SampleBlock *b = &s->blocks[block];
    int row = at / LANES, lane = at % LANES, face = s->items[block].face[row][lane];
    double x = (double)b->x[row][lane], y = (double)b->y[row][lane], z = (double)b->z[row][lane];
    double distance = 1 / (double)s->items[block].near[row][lane];
    Vec3 w = vec3_add(vec3_scale(side, x), vec3_add(vec3_scale(up, y), vec3_scale(view->z, z)));
    return lines_element_at(&s->outlines, s->mesh, face, vec3_add(view->eye, vec3_scale(w, distance)));
}

// The share of the samples in `run`, a bit for each place of a block.
static double share_of(const Sampler *s, int block, uint64_t run) {
    if (s->equal) return __builtin_popcountll(run);
    double share = 0;
    for (; run; run &= run - 1)
        share += (double)s->weights[block * SAMPLER_BLOCK * LANES + __builtin_ctzll(run)];
    return share;
}

static void add_beside(const Sampler *s, const View *view, int block, uint64_t run, RowSum *sum) {
    Vec3 side, up;
    sampler_axes(s, view, &side, &up);
    for (; run; run &= run - 1) {
        int element = element_beside(s, view, side, up, block, __builtin_ctzll(run));
        row_add(sum, element, share_of(s, block, run & -run));
    }
}

static void add_nothing(const Sampler *s, const View *view, int block, uint64_t run, RowSum *sum) {
    const SampleBlock *b = &s->blocks[block];
    Vec3 side, up;
    sampler_axes(s, view, &side, &up);
    for (; run; run &= run - 1) {
        int at = __builtin_ctzll(run), row = at / LANES, lane = at % LANES;
        Vec3 across =
            vec3_add(vec3_scale(side, (double)b->x[row][lane]), vec3_scale(up, (double)b->y[row][lane]));
        row_escape(sum, view, share_of(s, block, run & -run),
                   vec3_add(across, vec3_scale(view->z, (double)b->z[row][lane])));
    }
}

// Adds the shares of a block's directions to the sum; neighbours in one square are added together.
static void sum_block(Sampler *s, const View *view, int block, uint64_t mask, RowSum *sum) {
    LaneInt square[SAMPLER_BLOCK] = {0};
    find_squares(s, view, block, mask, square);
    uint64_t ends = 0;
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        LaneInt next = __builtin_shufflevector(square[row], square[row], 1, 2, 3, 4, 5, 6, 7, 7);
        ends |= (uint64_t)((~lane_mask(square[row] == next) & 0xff) | 1 << (LANES - 1)) << (row * LANES);
    }
    for (uint64_t left = ~(uint64_t)0; ends; ends &= ends - 1) {
        int end = __builtin_ctzll(ends), at = ((const int32_t *)square)[end];
        uint64_t run = left & (ends ^ (ends - 1)) & mask;
        left = ~(ends ^ (ends - 1));
        if (run == 0) continue;
        double share = share_of(s, block, run);
        int element = at >= 0 ? s->mesh->squares[at] : -1;
        if (element >= 0)
            row_add(sum, element, share);
        else if (at >= 0)
            add_beside(s, view, block, run, sum);
        else if (at == BACK)
            sum->back += share;
        else
            add_nothing(s, view, block, run, sum);
    }
}

// The most bytes of a table that are prefetched.
enum { MOST_FETCHED = 4096 };

static void fetch(const void *from, size_t bytes) {
    for (size_t i = 0; i < bytes && i < MOST_FETCHED; i += 64) __builtin_prefetch((const char *)from + i);
}

// Prefetches the data that most of the row needs: of the faces seen at the first sample of every fourth row of the blocks.
static void fetch_faces(Sampler *s, const View *view, const RowSum *sum) {
    for (int at = 0; at < s->block_count * SAMPLER_BLOCK; at += SAMPLER_BLOCK / 2) {
        if (s->masks[at] == 0) continue;
        int face = s->items[at / SAMPLER_BLOCK].face[at % SAMPLER_BLOCK][__builtin_ctz(s->masks[at])];
        if (face < 0 || s->grid_stamp[face] == *s->stamp) continue;
        const SeenGrid *grid = grid_of(s, view, face);
        if (grid->one == BACK) continue;
        size_t elements = (size_t)s->mesh->faces[face].element_count;
        fetch(sum->share + s->mesh->faces[face].first_element, elements * sizeof *sum->share);
        fetch(s->mesh->squares + grid->first_square, (size_t)grid->nx * (size_t)grid->ny * sizeof(int));
    }
}

void sampler_row(Sampler *s, const View *view, RowSum *sum) {
    fetch_faces(s, view, sum);
    for (int block = 0; block < s->block_count; block++) {
        uint64_t mask;
        memcpy(&mask, s->masks + block * SAMPLER_BLOCK, sizeof mask);
        if (mask) sum_block(s, view, block, mask, sum);
    }
}

// Boxes are enlarged by this: a form's value at a unit direction or a box's corner is right to a few units in the last place of a
// float, as a share of the sum of its coefficients.
#define BOX_ROUNDING 1e-6f

typedef struct Extent {
    float low[3], high[3];
} Extent;

static const Extent EXTENT_EMPTY = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void extend(Extent *e, const Extent *by) {
    for (int k = 0; k < 3; k++) {
        e->low[k] = fminf(e->low[k], by->low[k]);
        e->high[k] = fmaxf(e->high[k], by->high[k]);
    }
}

static void put_box(SampleBoxes *boxes, int lane, const Extent *e) {
    bool empty = e->low[0] > e->high[0];
    float middle[3] = {0}, half[3] = {0};
    for (int k = 0; k < 3 && !empty; k++) {
        middle[k] = 0.5f * (e->low[k] + e->high[k]);
        half[k] = fmaxf(e->high[k] - middle[k], middle[k] - e->low[k]) + BOX_ROUNDING;
    }
    boxes->x[lane] = middle[0];
    boxes->y[lane] = middle[1];
    boxes->z[lane] = middle[2];
    boxes->half_x[lane] = half[0];
    boxes->half_y[lane] = half[1];
    boxes->half_z[lane] = half[2];
    boxes->far[lane] = empty ? INFINITY : 0;
}

static int groups_along(int size) {
    int side = SAMPLER_BLOCK * GROUP_SIDE;
    return (size + side - 1) / side;
}

static int group_total(const SampleGrid *grids, int grid_count) {
    int total = 0;
    for (int g = 0; g < grid_count; g++)
        total += groups_along(grids[g].width) * groups_along(grids[g].height);
    return total;
}

// Adds sample (i, j) of a grid to a place of a block and to the end of s->samples. False: the grid has no sample there.
static bool add_sample(Sampler *s, const SampleGrid *grid, int i, int j, int block, int row, int lane,
                       Extent *extent) {
    double w[3], weight;
    if (i >= grid->width || j >= grid->height || !grid->at(grid, i, j, w, &weight)) return false;
    double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    float unit[3] = {(float)(w[0] / length), (float)(w[1] / length), (float)(w[2] / length)};
    s->blocks[block].x[row][lane] = unit[0];
    s->blocks[block].y[row][lane] = unit[1];
    s->blocks[block].z[row][lane] = unit[2];
    s->blocks[block].columns[lane] = unit[0];
    s->blocks[block].rows[row] = unit[1];
    s->weights[(block * SAMPLER_BLOCK + row) * LANES + lane] = (float)weight;
    int at = s->samples.count++;
    s->samples.x[at] = (float)((w[0] * s->cosine - w[1] * s->sine) / length);
    s->samples.y[at] = (float)((w[0] * s->sine + w[1] * s->cosine) / length);
    s->samples.z[at] = unit[2];
    s->samples.weight[at] = (float)weight;
    Extent one;
    for (int k = 0; k < 3; k++) one.low[k] = one.high[k] = unit[k];
    extend(extent, &one);
    return true;
}

// Fills a block whose first sample is (i, j) of the grid. False: the block has no samples.
static bool list_block(Sampler *s, const SampleGrid *grid, int i, int j, int block, Extent *extent) {
    bool any = false;
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        unsigned mask = 0;
        for (int lane = 0; lane < LANES; lane++) {
            bool sample = add_sample(s, grid, i + lane, j + row, block, row, lane, extent);
            s->nothing[block].near[row][lane] = sample ? 0 : INFINITY;
            s->nothing[block].face[row][lane] = -1;
            mask |= (unsigned)sample << lane;
        }
        s->masks[block * SAMPLER_BLOCK + row] = (unsigned char)mask;
        any = any || mask != 0;
    }
    return any;
}

static void add_group(Sampler *s, const SampleGrid *grid, int i, int j, int group) {
    Extent whole = EXTENT_EMPTY;
    s->first_block[group] = s->block_count;
    for (int k = 0; k < GROUP_BLOCKS; k++) {
        Extent extent = EXTENT_EMPTY;
        bool any = list_block(s, grid, i + k % GROUP_SIDE * SAMPLER_BLOCK, j + k / GROUP_SIDE * SAMPLER_BLOCK,
                              s->block_count, &extent);
        s->used[group] |= (unsigned short)(any << k);
        s->block_count += any;
        put_box(&s->block_boxes[group * 2 + k / LANES], k % LANES, &extent);
        extend(&whole, &extent);
    }
    put_box(&s->group_boxes[group / LANES], group % LANES, &whole);
}

static bool is_flat(const Sampler *s) {
    for (int row = 0; row < s->block_count * SAMPLER_BLOCK; row++) {
        for (unsigned mask = s->masks[row]; mask; mask &= mask - 1) {
            const SampleBlock *b = &s->blocks[row / SAMPLER_BLOCK];
            int lane = __builtin_ctz(mask);
            if (b->x[row % SAMPLER_BLOCK][lane] != b->columns[lane]) return false;
            if (b->y[row % SAMPLER_BLOCK][lane] != b->rows[row % SAMPLER_BLOCK]) return false;
        }
    }
    return true;
}

static void scale_weights(Sampler *s) {
    double sum = 0;
    float least = INFINITY, most = 0;
    for (int i = 0; i < s->samples.count; i++) {
        sum += s->samples.weight[i];
        least = fminf(least, s->samples.weight[i]);
        most = fmaxf(most, s->samples.weight[i]);
    }
    s->equal = least == most;
    for (int i = 0; i < s->samples.count; i++) s->samples.weight[i] = (float)(s->samples.weight[i] / sum);
    for (int i = 0; i < s->block_count * SAMPLER_BLOCK * LANES; i++)
        s->weights[i] = (float)(s->weights[i] / sum);
}

static int lone_square(const Mesh *mesh, const Face *face) {
    int at = face->first_square;
    if (face->element_count != 1) return MANY;
    while (mesh->squares[at] == -1) at++;
    return at;
}

// Finds whether the samples lie in even columns and rows.
static EvenGrid even_grid(const Sampler *s, const SampleGrid *grids, int grid_count) {
    const SampleGrid *grid = &grids[0];
    EvenGrid none = {0}, even = {.size = {grid->width, grid->height},
                                 .per_unit = 0.5 * grid->width,
                                 .across = groups_along(grid->width)};
    if (!s->flat || grid_count != 1 || grid->width != grid->height) return none;
    for (int pass = 0, known = 0; pass < 2; pass++) {
        for (int j = 0; j < grid->height; j++) {
            for (int i = 0; i < grid->width; i++) {
                double w[3], weight;
                if (!grid->at(grid, i, j, w, &weight)) continue;
                double first[2] = {w[0] - i / even.per_unit, w[1] - j / even.per_unit};
                for (int k = 0; k < 2; k++) {
                    if (!known) even.first[k] = first[k];
                    if (fabs(first[k] - even.first[k]) > 1e-9) return none;
                }
                known = 1;
            }
        }
    }
    return even;
}

static void take_view_memory(Sampler *s, Arena *arena) {
    s->stamp = ARENA_ARRAY(arena, int, 1);
    s->grid_stamp = ARENA_ARRAY(arena, int, s->mesh->face_count + 1);
    s->view_index = ARENA_ARRAY(arena, int, s->mesh->face_count + 1);
    s->grids = ARENA_ARRAY(arena, SeenGrid, s->mesh->face_count + 1);
    s->lone = ARENA_ARRAY(arena, int, s->mesh->face_count + 1);
    for (int f = 0; f < s->mesh->face_count; f++) s->lone[f] = lone_square(s->mesh, &s->mesh->faces[f]);
    s->edges = ARENA_ARRAY(arena, Form, s->outlines.most_edges + 1);
    s->crossing = ARENA_ARRAY(arena, const Form *, s->outlines.most_edges + 1);
    s->crossed = ARENA_ARRAY(arena, unsigned, s->outlines.most_edges + 1);
}

// Places for samples, whole groups of them.
static int place_count(const Sampler *s) {
    return (s->group_count * GROUP_BLOCKS + 1) * SAMPLER_BLOCK * LANES;  // + 1 for a trial block
}

static void make_samples(Sampler *s, const SampleGrid *grids, int grid_count, Arena *arena) {
    s->group_count = group_total(grids, grid_count);
    int places = place_count(s), blocks = places / (SAMPLER_BLOCK * LANES);
    s->blocks = ARENA_ARRAY(arena, SampleBlock, blocks);
    s->nothing = ARENA_ARRAY(arena, ItemBlock, blocks);
    s->masks = ARENA_ARRAY(arena, unsigned char, blocks *SAMPLER_BLOCK);
    s->weights = ARENA_ARRAY(arena, float, places);
    s->first_block = ARENA_ARRAY(arena, int, s->group_count);
    s->used = ARENA_ARRAY(arena, unsigned short, s->group_count);
    s->block_boxes = ARENA_ARRAY(arena, SampleBoxes, s->group_count * 2);
    int pairs = (s->group_count + 2 * LANES - 1) / (2 * LANES);
    s->group_boxes = ARENA_ARRAY(arena, SampleBoxes, pairs * 2);
    s->samples.x = ARENA_ARRAY(arena, float, places);
    s->samples.y = ARENA_ARRAY(arena, float, places);
    s->samples.z = ARENA_ARRAY(arena, float, places);
    s->samples.weight = ARENA_ARRAY(arena, float, places);
    for (int i = 0; i < pairs * 2 * LANES; i++) put_box(&s->group_boxes[i / LANES], i % LANES, &EXTENT_EMPTY);
    int group = 0, side = SAMPLER_BLOCK * GROUP_SIDE;
    for (int g = 0; g < grid_count; g++)
        for (int j = 0; j < grids[g].height; j += side)
            for (int i = 0; i < grids[g].width; i += side) add_group(s, &grids[g], i, j, group++);
    scale_weights(s);
    s->flat = is_flat(s);
    s->even = even_grid(s, grids, grid_count);
}

Sampler *sampler_new(const Mesh *mesh, const FaceLines *lines, const SampleGrid *grids, int grid_count,
                     double turn, Arena *arena) {
    Sampler *s = ARENA_ARRAY(arena, Sampler, 1);
    s->mesh = mesh;
    s->cosine = cos(turn);
    s->sine = sin(turn);
    s->outlines = lines ? *lines : lines_of_mesh(mesh, arena);
    make_samples(s, grids, grid_count, arena);
    s->items = ARENA_ARRAY(arena, ItemBlock, place_count(s) / (SAMPLER_BLOCK * LANES));
    take_view_memory(s, arena);
    return s;
}

Sampler *sampler_new_like(const Sampler *like, const SampleGrid *grids, int grid_count, Arena *arena) {
    Sampler *s = ARENA_ARRAY(arena, Sampler, 1);
    *s = *like;
    s->samples.count = s->block_count = 0;
    make_samples(s, grids, grid_count, arena);
    CORE_ASSERT(s->group_count <= like->group_count);
    return s;
}

const FormFactorSamples *sampler_samples(const Sampler *self) { return &self->samples; }
