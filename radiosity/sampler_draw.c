// sampler_draw.c - finds the face seen along each direction.
//
// A direction w is inside a face iff dot(line, w) has the right sign for the great circle of each of its edges, and sees it
// at 1 / distance = dot(n, w) / d, which is linear in w (design.md). The forms are made in doubles from the eye; they are
// floats when they meet directions. Two faces along one line share its form to the last bit, and only one of them holds the
// directions on it, so nothing falls between them.
//
// Hierarchical (Greene, Kass & Miller 1993): groups of 32 x 32 directions, blocks of 8 x 8, rows of 8. A face passes over what
// its edges do not reach, and over what lies wholly behind things already seen.
#include <float.h>
#include <math.h>

#include "radiosity/sampler_part.h"

// Above the rounding of a form's value at a unit direction or at a box's corner, as a share of the sum of its
// coefficients: a few units in the last place of a float.
#define FORM_NOISE 1e-6f

// A face on its way through the hierarchy.
typedef struct Drawing {
    Form near;
    const DrawnEdge *edges;
    int edge_count, face;
    long long tests;
} Drawing;

static Form form_of(double x, double y, double z) {
    Form f = {(float)x, (float)y, (float)z, 0};
    f.noise = FORM_NOISE * (fabsf(f.x) + fabsf(f.y) + fabsf(f.z));
    return f;
}

static Form form_in_axes(const View *view, Vec3 v) {
    return form_of(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
}

// The plane through the eye and a line; its length says nothing.
static Form line_form(Sampler *s, const View *view, int line) {
    if (s->line_stamp[line] != s->stamp) {
        const Line *l = &s->outlines.lines[line];
        s->line_stamp[line] = s->stamp;
        s->line_forms[line] = form_in_axes(view, vec3_cross(vec3_sub(l->point, view->eye), l->along));
    }
    return s->line_forms[line];
}

static int make_edges(Sampler *s, const View *view, const ViewFace *face) {
    const FaceLines *o = &s->outlines;
    int first = o->first_edge[face->face], count = o->first_edge[face->face + 1] - first;
    for (int i = 0; i < count; i++) {
        FaceEdge edge = o->edges[first + i];
        Form f = line_form(s, view, edge.line);
        bool along = (edge.sign > 0) == (face->d > 0);  // seen from behind, edges go counter-clockwise
        if (along)
            s->edges[i] = (DrawnEdge){f, 0};
        else
            s->edges[i] = (DrawnEdge){{-f.x, -f.y, -f.z, f.noise}, FLT_TRUE_MIN};
    }
    return count;
}

// A form's value in the middle of each box, and how far it may be from that anywhere in it.
static inline Lane middle_in(const SampleBoxes *b, Form f) { return f.x * b->x + f.y * b->y + f.z * b->z; }
static inline Lane spread_in(const SampleBoxes *b, Form f) {
    return fabsf(f.x) * b->half_x + fabsf(f.y) * b->half_y + fabsf(f.z) * b->half_z + f.noise;
}

// The boxes that the face may be seen in.
static inline unsigned boxes_reached(const SampleBoxes *b, const Drawing *d) {
    Lane nearest = middle_in(b, d->near) + spread_in(b, d->near);
    LaneInt in = (nearest >= b->far) & (nearest > 0);
    for (int i = 0; i < d->edge_count; i++) {
        Form f = d->edges[i].form;
        in &= middle_in(b, f) + spread_in(b, f) >= 0;
    }
    return lane_mask(in);
}

static inline void draw_row(const SampleBlock *b, ItemBlock *items, int row, const Drawing *d,
                            const DrawnEdge *edges, int edge_count) {
    Lane x = b->x[row], y = b->y[row], z = b->z[row];
    LaneInt in = ~(LaneInt){0};
    for (int i = 0; i < edge_count; i++) {
        Form f = edges[i].form;
        in &= f.x * x + f.y * y + f.z * z >= edges[i].least;
    }
    Lane value = d->near.x * x + d->near.y * y + d->near.z * z, old = items->near[row];
    in &= (value > old) | ((value == old) & (items->face[row] > d->face));
    items->near[row] = lane_choose(in, value, old);
    items->face[row] = lane_choose_int(in, lane_int_of(d->face), items->face[row]);
}

// Returns the least 1 / distance now seen in the block.
static float draw_block(const SampleBlock *b, ItemBlock *items, Drawing *d, const DrawnEdge *edges,
                        int edge_count) {
    Lane far = lane_of(INFINITY);
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        draw_row(b, items, row, d, edges, edge_count);
        far = lane_least(far, items->near[row]);
    }
    d->tests += SAMPLER_BLOCK * LANES;
    return lane_least_of(far);
}

// Which edges cross the boxes: bit i of crossed[e], box i is not wholly inside edge e.
static inline void edges_crossing(const SampleBoxes *b, const Drawing *d, unsigned *crossed) {
    for (int e = 0; e < d->edge_count; e++) {
        Form f = d->edges[e].form;
        crossed[e] = lane_mask(middle_in(b, f) - spread_in(b, f) <= 0);
    }
}

static void draw_eight(Sampler *s, int first_block, SampleBoxes *boxes, Drawing *d) {
    unsigned reached = boxes_reached(boxes, d);
    if (reached == 0) return;
    edges_crossing(boxes, d, s->crossed);
    for (; reached; reached &= reached - 1) {
        int lane = __builtin_ctz(reached), block = first_block + lane, count = 0;
        for (int e = 0; e < d->edge_count; e++)
            if (s->crossed[e] >> lane & 1) s->chosen[count++] = s->edges[e];
        boxes->far[lane] = draw_block(&s->blocks[block], &s->items[block], d, s->chosen, count);
    }
}

static void draw_face(Sampler *s, Drawing *d) {
    for (int k = 0; k * LANES < s->group_count; k++) {
        SampleBoxes *groups = &s->group_boxes[k];
        for (unsigned reached = boxes_reached(groups, d); reached; reached &= reached - 1) {
            int lane = __builtin_ctz(reached), group = k * LANES + lane;
            SampleBoxes *boxes = &s->block_boxes[group * 2];
            draw_eight(s, group * GROUP_BLOCKS, &boxes[0], d);
            draw_eight(s, group * GROUP_BLOCKS + LANES, &boxes[1], d);
            groups->far[lane] = lane_least_of(lane_least(boxes[0].far, boxes[1].far));
        }
    }
}

static void clear(Sampler *s) {
    memcpy(s->items, s->nothing, (size_t)s->group_count * GROUP_BLOCKS * sizeof *s->items);
    Lane none = lane_of(INFINITY);
    for (int k = 0; k < s->group_count * 2; k++)
        s->block_boxes[k].far = lane_choose(s->block_boxes[k].half_x > 0, (Lane){0}, none);
    for (int k = 0; k * LANES < s->group_count; k++)
        s->group_boxes[k].far = lane_choose(s->group_boxes[k].half_x > 0, (Lane){0}, none);
}

void sampler_draw(Sampler *s, const View *view, FormFactorWork *work) {
    s->stamp++;
    clear(s);
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *face = &view->faces[i];
        s->view_index[face->face] = i;
        Drawing d = {.near = form_of(face->n.x / face->d, face->n.y / face->d, face->n.z / face->d),
                     .edges = s->edges,
                     .edge_count = make_edges(s, view, face),
                     .face = face->face};
        draw_face(s, &d);
        work->tests += d.tests;
    }
    work->samples += s->samples.count;
}
