// spans.h - which pixels of a row lie inside a convex shape, from its edges as lines.
//
// A sample on an edge is inside, and two shapes on either side of one line agree about where it is bit by bit: between them
// no pixel is missed.
#ifndef VISIBILITY_SPANS_H
#define VISIBILITY_SPANS_H

#include "visibility/hidden/image.h"

// A line that changes less than this share of its slope down along the row is taken to be level, pixels a pixel: over the
// widest picture it moves by 2e-8 of a pixel.
#define SPAN_LEVEL 1e-12

// The left ends come first, the right ends from the back: x = slope y + offset.
typedef struct Spans {
    double (*side)[2];  // [capacity]
    int capacity, lefts, rights;
    int x0, x1, y0, y1;  // nothing is inside elsewhere
} Spans;

static inline Spans spans_new(Arena *arena, int most_lines) {
    int capacity = most_lines + 1;
    return (Spans){.side = arena_alloc(arena, (size_t)capacity, sizeof(double[2])), .capacity = capacity};
}

static inline void spans_add(Spans *spans, Line line) {
    double a = line[0], b = line[1], c = line[2];
    if (fabs(a) <= SPAN_LEVEL * fabs(b) || a == 0) {
        // The middle of the picture is as good as any x.
        double at = c + a * (spans->x0 + spans->x1) / 2, y = -at / b;
        if (b > 0 && y > spans->y0) spans->y0 = y > spans->y1 ? spans->y1 + 1 : (int)ceil(y);
        if (b < 0 && y < spans->y1) spans->y1 = y < spans->y0 ? spans->y0 - 1 : (int)floor(y);
        if (b == 0 && c < 0) spans->y1 = spans->y0 - 1;
        return;
    }
    double inverse = 1 / a, slope = -b * inverse, offset = -c * inverse;
    double *left = spans->side[spans->lefts], *right = spans->side[spans->capacity - 1 - spans->rights];
    int is_left = a > 0;
    // Both are free: one is kept.
    left[0] = right[0] = slope;
    left[1] = right[1] = offset;
    spans->lefts += is_left;
    spans->rights += !is_left;
}

// A shape's edges, or a piece's: pixels within its bounds that are inside of all lines.
static inline void spans_take(Spans *spans, const Shape *bounds, const Line *lines, int count) {
    spans->lefts = spans->rights = 0;
    spans->x0 = bounds->x0, spans->x1 = bounds->x1;
    spans->y0 = bounds->y0, spans->y1 = bounds->y1;
    for (int i = 0; i < count; i++) spans_add(spans, lines[i]);
}

// The pixels of a row; false: none.
static inline bool spans_row(const Spans *spans, int y, int *x0, int *x1) {
    double left = spans->x0, right = spans->x1, at = y;
    for (int i = 0; i < spans->lefts; i++) {
        double x = spans->side[i][0] * at + spans->side[i][1];
        left = x > left ? x : left;
    }
    for (int i = 0; i < spans->rights; i++) {
        const double *side = spans->side[spans->capacity - 1 - i];
        double x = side[0] * at + side[1];
        right = x < right ? x : right;
    }
    if (!(left <= right)) return false;
    *x0 = (int)ceil(left);
    *x1 = (int)floor(right);
    return *x0 <= *x1;
}

// Writes `facet` wherever the shape is: the painter's stroke. Returns how many pixels.
static inline int64_t spans_paint(const Spans *spans, int facet, ItemBuffer *out) {
    int64_t pixels = 0;
    for (int y = spans->y0; y <= spans->y1; y++) {
        int x0, x1;
        if (!spans_row(spans, y, &x0, &x1)) continue;
        int32_t *item = out->item + (size_t)y * (size_t)out->width;
        for (int x = x0; x <= x1; x++) item[x] = facet;
        pixels += x1 - x0 + 1;
    }
    return pixels;
}

#endif
