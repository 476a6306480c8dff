// sightline.c - stabbing a sequence of oriented plan segments with one line, exactly and one segment at a time.
//
// A line crosses the sequence iff it has all left ends on its left and all right ends on its right (Teller & Sequin
// 1991, section 4): linear separability of two point sets. As in their incremental form the extreme lines are kept:
// a new portal that lies beyond one of them cannot be reached; otherwise its ends may pull the extremes in. All
// decisions are exact signs of given points, none of constructed ones.
#include "visibility/sightline.h"

#include "engine/core/error.h"
#include "engine/core/predicates.h"

// The right end from which the line to left[to] has every right end on its right.
static int pivot_right(const Sightline *line, int to) {
    int from = 0;
    for (int i = 1; i < to; i++) {
        if (orient2d(line->right[from], line->left[to], line->right[i]) > 0) from = i;
    }
    return from;
}

static int pivot_left(const Sightline *line, int to) {
    int from = 0;
    for (int i = 1; i < to; i++) {
        if (orient2d(line->left[from], line->right[to], line->left[i]) < 0) from = i;
    }
    return from;
}

bool sightline_push(Sightline *line, Vec2 left, Vec2 right, SightlineUndo *undo) {
    CORE_ASSERT(line->count < line->capacity);
    *undo = (SightlineUndo){line->ccw_from, line->ccw_to, line->cw_from, line->cw_to};
    int k = line->count;
    line->left[k] = left;
    line->right[k] = right;
    if (k >= 2) {
        int beyond_ccw = orient2d(line->right[line->ccw_from], line->left[line->ccw_to], right);
        int beyond_cw = orient2d(line->left[line->cw_from], line->right[line->cw_to], left);
        if (beyond_ccw > 0 || beyond_cw < 0) return false;
    }
    line->count++;
    if (k == 1) {
        line->ccw_from = line->cw_from = 0;
        line->ccw_to = line->cw_to = 1;
    } else if (k >= 2) {
        if (orient2d(line->right[line->ccw_from], line->left[line->ccw_to], left) < 0) {
            line->ccw_from = pivot_right(line, k);
            line->ccw_to = k;
        }
        if (orient2d(line->left[line->cw_from], line->right[line->cw_to], right) > 0) {
            line->cw_from = pivot_left(line, k);
            line->cw_to = k;
        }
    }
    return true;
}

void sightline_pop(Sightline *line, const SightlineUndo *undo) {
    line->count--;
    line->ccw_from = undo->ccw_from;
    line->ccw_to = undo->ccw_to;
    line->cw_from = undo->cw_from;
    line->cw_to = undo->cw_to;
}
