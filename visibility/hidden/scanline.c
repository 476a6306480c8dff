// scanline.c - row by row, the spans between the ends of the polygons that are active there (G. Watkins, A real time visible
// surface algorithm, 1970; A. Bouknight 1970). Between two ends the same polygons are there, each as deep as a line along the
// row says: the greatest of several lines is convex, so what is nearest at both ends of a span is nearest all along it; else
// polygons pass through each other, and the span is halved.
#include "visibility/hidden/depth.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/spans.h"

// A polygon in the row under way: pixels x0 .. x1, 1/z = slope x + base.
typedef struct Run {
    double slope, base;
    int x0, x1, facet, order, shape;
} Run;

typedef struct ScanLine {
    Facets facets;
    Picture picture;
    double (*sides)[2];  // of all shapes' spans
    Spans *spans;        // [shape count]
    int *next;           // [shape count] shapes that start in the same row
    int *active;         // [active_count] shapes, by the left end they last had
    Run *runs;           // [run_count] of the row, by x0
    int *open;           // [open_count] runs over the pixel under way
    int active_count, run_count, open_count;
    Arena rows;  // of this picture
    int *start;  // [height] the first shape that starts there, or -1
    int32_t *item;
    HiddenWork *work;
    size_t memory;
} ScanLine;

static void *scanline_begin(const Scene *scene, Arena *arena, Error *error) {
    ScanLine *s = ARENA_ARRAY(arena, ScanLine, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &s->facets, error)) return NULL;
    int count = s->facets.count + 1;
    s->picture = picture_new(&s->facets, arena);
    s->sides = arena_alloc(arena, (size_t)(s->facets.corner_count + count), sizeof *s->sides);
    s->spans = ARENA_ARRAY(arena, Spans, count);
    s->next = ARENA_ARRAY(arena, int, count);
    s->active = ARENA_ARRAY(arena, int, count);
    s->open = ARENA_ARRAY(arena, int, count);
    s->runs = ARENA_ARRAY(arena, Run, count);
    s->memory = arena->used - before;
    return s;
}

static void scanline_end(void *prepared) { arena_free(&((ScanLine *)prepared)->rows); }

// The ends of all shapes, and the rows in which they start.
static void sort_rows(ScanLine *s) {
    const Picture *picture = &s->picture;
    int height = picture->image.height;
    memset(s->start, -1, (size_t)height * sizeof *s->start);
    for (int i = picture->shape_count - 1; i >= 0; i--) {
        const Shape *shape = &picture->shapes[i];
        Spans *spans = &s->spans[i];
        // One more than its lines each, as spans_add wants.
        spans->side = s->sides + shape->first_line + i;
        spans->capacity = shape->line_count + 1;
        spans_take(spans, shape, picture->lines + shape->first_line, shape->line_count);
        s->work->edges += shape->line_count;
        if (spans->y0 > spans->y1) continue;
        s->next[i] = s->start[spans->y0];
        s->start[spans->y0] = i;
    }
}

// The runs of a row by their left ends: nearly in order already, as the last row had them.
static void add_run(ScanLine *s, const Run *run) {
    int at = s->run_count++;
    while (at > 0 && s->runs[at - 1].x0 > run->x0) {
        s->runs[at] = s->runs[at - 1];
        at--;
    }
    s->runs[at] = *run;
}

static void find_runs(ScanLine *s, int y) {
    for (int i = s->start[y]; i >= 0; i = s->next[i]) s->active[s->active_count++] = i;
    s->run_count = 0;
    int rest = 0;  // have no pixel in this row
    for (int k = 0; k < s->active_count; k++) {
        int shape = s->active[k], x0, x1;
        if (!spans_row(&s->spans[shape], y, &x0, &x1)) {
            s->active[rest++] = shape;
            continue;
        }
        int facet = s->picture.shapes[shape].facet;
        Line depth = s->picture.depth[facet];
        Run run = {depth[0], depth[1] * y + depth[2], x0, x1, facet, s->facets.facets[facet].order, shape};
        add_run(s, &run);
    }
    for (int k = 0; k < s->run_count; k++) s->active[rest++] = s->runs[k].shape;
    s->active_count = 0;
    for (int k = 0; k < rest; k++)
        if (s->spans[s->active[k]].y1 > y) s->active[s->active_count++] = s->active[k];
}

// The run that is seen at x, of those open.
static int nearest_at(const ScanLine *s, int x) {
    int best = s->open[0];
    double best_depth = s->runs[best].slope * x + s->runs[best].base;
    for (int k = 1; k < s->open_count; k++) {
        const Run *run = &s->runs[s->open[k]];
        double depth = run->slope * x + run->base;
        if (!depth_nearer(depth, run->order, best_depth, s->runs[best].order)) continue;
        best = s->open[k];
        best_depth = depth;
    }
    s->work->depth_tests += s->open_count;
    return best;
}

static void fill_pixels(ScanLine *s, int x0, int x1, int run) {
    int facet = s->runs[run].facet;
    for (int x = x0; x <= x1; x++) s->item[x] = facet;
    s->work->pixels += x1 - x0 + 1;
}

// Pixels x0 .. x1, at whose ends these runs are seen.
static void fill_span(ScanLine *s, int x0, int first, int x1, int last) {
    while (first != last && x1 - x0 > 1) {
        int middle = x0 + (x1 - x0) / 2, run = nearest_at(s, middle);
        s->work->splits++;
        fill_span(s, x0, first, middle, run);
        x0 = middle;
        first = run;
    }
    fill_pixels(s, x0, first == last ? x1 : x0, first);
    if (first != last) fill_pixels(s, x1, x1, last);
}

// Those that ended before x are no longer open; returns the last pixel before another one ends.
static int close_runs(ScanLine *s, int x) {
    int kept = 0, until = INT32_MAX;
    for (int k = 0; k < s->open_count; k++) {
        int end = s->runs[s->open[k]].x1;
        if (end < x) continue;
        s->open[kept++] = s->open[k];
        until = end < until ? end : until;
    }
    s->open_count = kept;
    return until;
}

static void draw_row(ScanLine *s) {
    s->open_count = 0;
    for (int x = 0, next = 0; next < s->run_count || s->open_count > 0;) {
        while (next < s->run_count && s->runs[next].x0 <= x) s->open[s->open_count++] = next++;
        int until = close_runs(s, x);
        if (next < s->run_count && s->runs[next].x0 <= until) until = s->runs[next].x0 - 1;
        if (s->open_count > 0) {
            int first = nearest_at(s, x),
                last = s->open_count == 1 || until == x ? first : nearest_at(s, until);
            fill_span(s, x, first, until, last);
        } else if (next == s->run_count) {
            return;
        }
        x = until + 1;
    }
}

static bool scanline_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                          Error *error) {
    (void)error;
    ScanLine *s = prepared;
    memset(out->item, -1, (size_t)out->width * (size_t)out->height * sizeof *out->item);
    arena_reset(&s->rows);
    s->start = ARENA_ARRAY(&s->rows, int, out->height);
    s->work = work;
    s->active_count = 0;
    picture_take(&s->picture, camera);
    sort_rows(s);
    for (int y = 0; y < out->height; y++) {
        s->item = out->item + (size_t)y * (size_t)out->width;
        find_runs(s, y);
        draw_row(s);
    }
    work->polygons = s->picture.shape_count;
    work->memory = s->memory + (size_t)out->height * sizeof *s->start;
    picture_resolve(&s->picture, out);
    return true;
}

const HiddenMethod HIDDEN_SCANLINE = {.name = "scanline",
                                      .summary = "spans of active polygons, row by row",
                                      .begin = scanline_begin,
                                      .draw = scanline_draw,
                                      .end = scanline_end};
