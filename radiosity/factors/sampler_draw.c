// sampler_draw.c - finds the face seen along each direction.
//
// A direction w is inside a face iff dot(line, w) has the right sign for the great circle of each of its edges, and sees it
// at 1 / distance = dot(n, w) / d, which is linear in w (design.md). The forms are made in doubles from the eye; they are
// floats when they meet directions. Two faces along one line share its form to the last bit, but for its sign, so nothing
// falls between them; a direction right on it is in both, and depth or the lower number decides.
//
// Faces that floats cannot tell apart along a direction are told apart in doubles (sampler_tie.c).
//
// Hierarchical (Greene, Kass & Miller 1993): groups of 32 x 32 directions, blocks of 8 x 8, rows of 8. A face passes over what
// its edges do not reach, and over what lies wholly behind things already seen.
#include <math.h>

#include "radiosity/factors/sampler_part.h"

// How much nearer than its corners a face may be for the rounding and the bending of polygons, a share of the distance.
#define NEAREST_MARGIN 1e-3

// A face on its way through the hierarchy.
typedef struct Drawing {
    Form near;
    float nearest;  // 1 / distance of nowhere on the face is above this
    float tie;      // 1 / distances that differ by less may be the same, or the other way round
    int face;
    bool by_depth;  // what lies behind what was drawn is passed over
    const SamplerView *of;
    const Form *edges;  // [edge_count]
    int edge_count, crossing_count;
    unsigned *crossed;  // [edge_count] scratch: which of the boxes each edge crosses
    const Form **
        crossing;  // [crossing_count] those edges that cross the block at hand: no others are asked for in it
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

// 1 / distance.
static inline Form near_form(const ViewFrame *frame, const ViewFace *face) {
    Four n = {face->n.x, face->n.y, face->n.z, 0};
    return form_of(view_frame_turned(frame, n) * (1 / face->d));
}

// How many faces ahead memory is asked for: where a face's edges are, then the edges.
enum { AHEAD = 8, FAR_AHEAD = 16 };

static inline void fetch_ahead(const Sampler *s, const View *view, int at) {
    const FaceLines *o = &s->outlines;
    if (at + FAR_AHEAD < view->face_count)
        __builtin_prefetch(&o->first_edge[view->faces[at + FAR_AHEAD].face]);
    if (at + AHEAD < view->face_count)
        __builtin_prefetch(&o->edges[o->first_edge[view->faces[at + AHEAD].face]]);
}

// From the eye, as the view has it, to the last bit; the fourth number is any.
static inline Four vertex_of(const Sampler *s, const ViewFrame *frame, const Vec3 *own, int name) {
    Four v;
    if (name >= 0) {
        memcpy(&v, own + name, sizeof v);
        return v;
    }
    Vec3 off = vec3_sub(s->mesh->vertices[~name], frame->eye);
    return view_frame_of(frame, off);
}

// For each edge the plane through it and the eye, in the samples' axes; its length says nothing.
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

// A bound for the whole face, by its corners along the direction of their middle; never more than 1 / d. A depth above it is the rounding
// of a plane that is seen edge-on.
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

// A form's value in the middle of each box, and how far it may be from that anywhere in it.
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

// Picks those of sixteen boxes that the face may be seen in; bit i of crossed[e] is set where edge e may cross box i.
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

// The edges that cross box i.
static inline int choose_edges(const Drawing *d, int i) {
    int count = 0;
    for (int e = 0; e < d->edge_count; e++) {
        d->crossing[count] = &d->edges[e];
        count += (int)(d->crossed[e] >> i & 1);
    }
    return count;
}

// ---- directions

// A form's values along row 0, 1, .. of a block.
static inline Lane form_at(const Form *f, const SampleBlock *b, int row, bool flat) {
    Lane across = lane_of(f->x) * (flat ? b->columns : b->x[row]);
    Lane y = flat ? lane_of(((const float *)&b->rows)[row]) : b->y[row];
    return lane_multiply_add(lane_of(f->z), b->z[row], lane_multiply_add(lane_of(f->y), y, across));
}

// Among the directions of a row that see another face as near, those that see this one all the same.
static LaneInt settle_row(const Drawing *d, const SampleBlock *b, int row, LaneInt tied, LaneInt before) {
    LaneInt wins = {0};
    for (unsigned left = lane_mask(tied); left;) {
        int other = before[__builtin_ctz(left)];
        unsigned same = lane_mask(before == lane_int_of(other)) & left;
        left &= ~same;
        // Mostly the two lie in one plane, and what holds for one direction holds for all.
        int all = other < 0 ? 1 : sampler_tie_of_planes(d->of, d->face, other);
        for (; same; same &= same - 1) {
            int i = __builtin_ctz(same);
            Vec3 w = vec3((double)b->x[row][i], (double)b->y[row][i], (double)b->z[row][i]);
            wins[i] = all > 0 || (all == 0 && sampler_tie_along(d->of, d->face, other, w)) ? -1 : 0;
        }
    }
    return wins;
}

// Decides the places that a drawn block left open. The depth seen stays as near, by less than a tie.
static __attribute__((noinline)) void settle(const SampleBlock *b, ItemBlock *items, const Drawing *d,
                                             const LaneInt outside[SAMPLER_BLOCK]) {
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        Lane value = lane_least(form_at(&d->near, b, row, false), lane_of(d->nearest));
        LaneInt before = items->face[row];
        LaneInt tied = ~outside[row] & (lane_abs(value - items->near[row]) <= d->tie) & (before != d->face);
        if (lane_mask(tied) == 0) continue;
        LaneInt wins = settle_row(d, b, row, tied, before);
        items->near[row] = lane_choose(wins, value, items->near[row]);
        items->face[row] = lane_choose_int(wins, lane_int_of(d->face), before);
    }
}

// Places inside the face, where it is nearer than the depth there, see it from now on. Returns the least 1 / distance now seen in the
// block.
static inline float draw_inside(const SampleBlock *b, ItemBlock *items, const Drawing *d,
                                const LaneInt outside[SAMPLER_BLOCK], bool flat) {
    Lane far = lane_of(INFINITY), nearest = lane_of(d->nearest);
    LaneInt face = lane_int_of(d->face), open = {0};
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        Lane value = lane_least(form_at(&d->near, b, row, flat), nearest), old = items->near[row];
        Lane nearer = value - old;
        LaneInt in = ~outside[row] & (nearer > d->tie);  // the sign of `outside` alone tells
        open |= ~outside[row] & (lane_abs(nearer) <= d->tie);
        Lane now = lane_choose(in, value, old);
        items->near[row] = now;
        items->face[row] = lane_choose_int(in, face, items->face[row]);
        far = lane_least(far, now);
    }
    if (__builtin_expect(lane_mask(open) != 0, 0)) settle(b, items, d, outside);
    return lane_least_of(far);
}

// A direction is inside where no form is below 0: no sign bit is set.
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

// Returns how many blocks were looked at.
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

static void draw_face(Sampler *s, Drawing *d, FormFactorWork *work) {
    for (int first = 0; first < s->group_count; first += 2 * LANES) {
        SampleBoxes *groups = &s->group_boxes[first / LANES];
        for (unsigned reached = boxes_reached(groups, d); reached; reached &= reached - 1) {
            int i = __builtin_ctz(reached), group = first + i;
            int blocks = draw_group(s, group, d);
            if (blocks == 0) continue;
            work->tests += blocks * SAMPLER_BLOCK * LANES;
            if (!d->by_depth) continue;
            const SampleBoxes *boxes = &s->block_boxes[group * 2];
            groups[i / LANES].far[i % LANES] = lane_least_of(lane_least(boxes[0].far, boxes[1].far));
        }
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

void sampler_draw(Sampler *s, const View *view, FormFactorWork *work) {
    s->stamp++;
    clear(s);
    s->frame = frame_of(s, view);
    SamplerView of = {s, view};
    float tie = 0;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *face = &view->faces[i];
        s->view_index[face->face] = i;
        fetch_ahead(s, view, i);
        Form near = near_form(&s->frame, face);
        tie = fmaxf(tie, sampler_tie_within(&near));
        Drawing d = {.near = near,
                     .nearest = nearest_of(view, face),
                     .tie = tie,
                     .by_depth = view->by_depth,
                     .of = &of,
                     .edges = s->edges,
                     .edge_count = make_edges(s, &s->frame, view, face),
                     .crossed = s->crossed,
                     .crossing = s->crossing,
                     .face = face->face};
        draw_face(s, &d, work);
    }
    work->samples += s->samples.count;
}
