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

// A face on its way through the hierarchy. Edges that do not cross a group, or a block, are not asked for in it.
typedef struct Drawing {
    Form near;
    int face;
    const DrawnEdge *edges;
    int edge_count;
    unsigned *crossed;  // [edge_count] scratch: which of the boxes each edge crosses
    long long tests;
} Drawing;

static Form form_of(double x, double y, double z) {
    Form f = {.x = (float)x, .y = (float)y, .z = (float)z};
    f.abs_x = fabsf(f.x);
    f.abs_y = fabsf(f.y);
    f.abs_z = fabsf(f.z);
    f.noise = FORM_NOISE * (f.abs_x + f.abs_y + f.abs_z);
    return f;
}

static Form form_in_axes(const View *view, Vec3 v) {
    return form_of(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
}

// The plane through the eye and a line; its length says nothing.
static const Form *line_form(Sampler *s, const View *view, int line) {
    if (s->line_stamp[line] != s->stamp) {
        const Line *l = &s->outlines.lines[line];
        s->line_stamp[line] = s->stamp;
        s->line_forms[line] = form_in_axes(view, vec3_cross(vec3_sub(l->point, view->eye), l->along));
    }
    return &s->line_forms[line];
}

static int make_edges(Sampler *s, const View *view, const ViewFace *face) {
    const FaceLines *o = &s->outlines;
    int first = o->first_edge[face->face], count = o->first_edge[face->face + 1] - first;
    for (int i = 0; i < count; i++) {
        FaceEdge edge = o->edges[first + i];
        DrawnEdge *out = &s->edges[i];
        out->form = *line_form(s, view, edge.line);
        out->least = 0;
        // Seen from behind, edges go counter-clockwise.
        if ((edge.sign > 0) == (face->d > 0)) continue;
        out->form.x = -out->form.x;
        out->form.y = -out->form.y;
        out->form.z = -out->form.z;
        out->least = FLT_TRUE_MIN;
    }
    return count;
}

// A form's value in the middle of each box, and how far it may be from that anywhere in it.
static inline Lane middle_in(const SampleBoxes *b, const Form *f) {
    return f->x * b->x + f->y * b->y + f->z * b->z;
}
static inline Lane spread_in(const SampleBoxes *b, const Form *f) {
    return f->abs_x * b->half_x + f->abs_y * b->half_y + f->abs_z * b->half_z + f->noise;
}

// The boxes that the face may be seen in; bit i of crossed[e] is set where edge e may cross box i.
static inline unsigned boxes_reached(const SampleBoxes *b, const Drawing *d) {
    Lane nearest = middle_in(b, &d->near) + spread_in(b, &d->near);
    LaneInt in = (nearest >= b->far) & (nearest > 0);
    for (int e = 0; e < d->edge_count; e++) {
        Lane middle = middle_in(b, &d->edges[e].form), spread = spread_in(b, &d->edges[e].form);
        in &= middle >= -spread;
        d->crossed[e] = lane_mask(middle <= spread);
    }
    return lane_mask(in);
}

// Of the edges, those that cross box `lane`.
static inline int choose_edges(const Drawing *d, int lane, DrawnEdge *out) {
    int count = 0;
    for (int e = 0; e < d->edge_count; e++) {
        out[count] = d->edges[e];
        count += (int)(d->crossed[e] >> lane & 1);
    }
    return count;
}

// Returns the least 1 / distance now seen in the block.
static inline float draw_block(const SampleBlock *b, ItemBlock *items, const Drawing *d,
                               const DrawnEdge *edges, int edge_count) {
    Lane far = lane_of(INFINITY);
    LaneInt face = lane_int_of(d->face);
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        Lane x = b->x[row], y = b->y[row], z = b->z[row], old = items->near[row];
        Lane value = d->near.x * x + d->near.y * y + d->near.z * z;
        LaneInt before = items->face[row];
        LaneInt in = (value > old) | ((value == old) & (before > face));
        for (int e = 0; e < edge_count; e++) {
            const Form *f = &edges[e].form;
            in &= f->x * x + f->y * y + f->z * z >= edges[e].least;
        }
        Lane now = lane_choose(in, value, old);
        items->near[row] = now;
        items->face[row] = lane_choose_int(in, face, before);
        far = lane_least(far, now);
    }
    return lane_least_of(far);
}

// Eight blocks of a group.
static void draw_eight(Sampler *s, int first_block, SampleBoxes *boxes, Drawing *d) {
    for (unsigned reached = boxes_reached(boxes, d); reached; reached &= reached - 1) {
        int lane = __builtin_ctz(reached), block = first_block + lane;
        int count = choose_edges(d, lane, s->in_block);
        boxes->far[lane] = draw_block(&s->blocks[block], &s->items[block], d, s->in_block, count);
        d->tests += SAMPLER_BLOCK * LANES;
    }
}

static void draw_face(Sampler *s, const Drawing *d, FormFactorWork *work) {
    Drawing part = *d;
    part.edges = s->in_group;
    part.crossed = s->crossed_blocks;
    for (int k = 0; k * LANES < s->group_count; k++) {
        SampleBoxes *groups = &s->group_boxes[k];
        for (unsigned reached = boxes_reached(groups, d); reached; reached &= reached - 1) {
            int lane = __builtin_ctz(reached), group = k * LANES + lane;
            SampleBoxes *boxes = &s->block_boxes[group * 2];
            part.edge_count = choose_edges(d, lane, s->in_group);
            draw_eight(s, group * GROUP_BLOCKS, &boxes[0], &part);
            draw_eight(s, group * GROUP_BLOCKS + LANES, &boxes[1], &part);
            groups->far[lane] = lane_least_of(lane_least(boxes[0].far, boxes[1].far));
        }
    }
    work->tests += part.tests;
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
        double scale = 1 / face->d;
        s->view_index[face->face] = i;
        Drawing d = {.near = form_of(face->n.x * scale, face->n.y * scale, face->n.z * scale),
                     .edges = s->edges,
                     .edge_count = make_edges(s, view, face),
                     .crossed = s->crossed,
                     .face = face->face};
        draw_face(s, &d, work);
    }
    work->samples += s->samples.count;
}
