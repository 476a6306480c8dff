// sightline.c - stabbing a sequence of oriented plan segments with one line, exactly and one segment at a time.
//
// A line crosses the sequence iff it has all left ends on its left and all right ends on its right (Teller & Sequin
// 1991, section 4): linear separability of two point sets. As in their incremental form the extreme lines are kept, which
// touch both sets. A new end on the wrong side of one of them becomes an end of that line, whose other end is found
// anew; if the line then separates, all is well, and if it does not, none does. The sets may lie anyhow: a portal may
// reach behind earlier ones, as it does where floors are crossed in between. All decisions are exact signs of given
// points, none of constructed ones.
#include "visibility/sightline.h"

#include "engine/core/error.h"
#include "engine/core/vec.h"

// The point through which the line from `pivot` (or to it, with `turn` -1) has all others on its left (`side` +1) or
// right (-1), or on it, or -1. Where there is none, whatever comes out fails the check that follows.
static int tangent(Vec2 pivot, int turn, int side, const Vec2 *points, int count) {
    int best = -1;
    for (int i = 0; i < count; i++) {
        if (vec2_equal(points[i], pivot)) continue;
        if (best < 0 || turn * side * orient2d(pivot, points[best], points[i]) < 0) best = i;
    }
    return best;
}

// Has the directed line these left ends on its left, and these right ends on its right? An end that it runs through need not be asked.
static bool separates(const Sightline *line, int left_count, int right_count, Vec2 from, Vec2 to) {
    for (int i = 0; i < left_count; i++) {
        if (orient2d(from, to, line->left[i]) < 0) return false;
    }
    for (int i = 0; i < right_count; i++) {
        if (orient2d(from, to, line->right[i]) > 0) return false;
    }
    return true;
}

// Takes in right end k; the left ends before it are there. An end on the wrong side of one extreme line only lies right of
// the other, which goes on separating: the sets need no check. On the wrong side of both it may lie beyond the left ends.
static bool add_right(Sightline *line, int k, int left_count) {
    Vec2 r = line->right[k];
    bool past_ccw = orient2d(line->right[line->ccw_from], line->left[line->ccw_to], r) > 0;
    bool past_cw = orient2d(line->left[line->cw_from], line->right[line->cw_to], r) > 0;
    if (past_ccw) {
        line->ccw_from = k;
        line->ccw_to = tangent(r, 1, 1, line->left, left_count);
        if (past_cw && !separates(line, left_count, k, r, line->left[line->ccw_to])) return false;
    }
    if (past_cw) {
        line->cw_from = tangent(r, -1, 1, line->left, left_count);
        line->cw_to = k;
        if (past_ccw && !separates(line, left_count, k, line->left[line->cw_from], r)) return false;
    }
    return true;
}

static bool add_left(Sightline *line, int k, int right_count) {
    Vec2 l = line->left[k];
    bool past_ccw = orient2d(line->right[line->ccw_from], line->left[line->ccw_to], l) < 0;
    bool past_cw = orient2d(line->left[line->cw_from], line->right[line->cw_to], l) < 0;
    if (past_ccw) {
        line->ccw_from = tangent(l, -1, -1, line->right, right_count);
        line->ccw_to = k;
        if (past_cw && !separates(line, k, right_count, line->right[line->ccw_from], l)) return false;
    }
    if (past_cw) {
        line->cw_from = k;
        line->cw_to = tangent(l, 1, -1, line->right, right_count);
        if (past_ccw && !separates(line, k, right_count, l, line->right[line->cw_to])) return false;
    }
    return true;
}

static void restore(Sightline *line, const SightlineUndo *undo) {
    line->ccw_from = undo->ccw_from;
    line->ccw_to = undo->ccw_to;
    line->cw_from = undo->cw_from;
    line->cw_to = undo->cw_to;
}

bool sightline_push(Sightline *line, Vec2 left, Vec2 right, SightlineUndo *undo) {
    CORE_ASSERT(line->count < line->capacity);
    *undo = (SightlineUndo){line->ccw_from, line->ccw_to, line->cw_from, line->cw_to};
    int k = line->count;
    line->left[k] = left;
    line->right[k] = right;
    // The extremes through a single portal run along it.
    if (k == 0) line->ccw_from = line->ccw_to = line->cw_from = line->cw_to = 0;
    if (k > 0 && !(add_right(line, k, k) && add_left(line, k, k + 1))) {
        restore(line, undo);
        return false;
    }
    line->count++;
    return true;
}

void sightline_pop(Sightline *line, const SightlineUndo *undo) {
    line->count--;
    restore(line, undo);
}
