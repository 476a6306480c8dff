// curved_trim_pieces.c - what loops leave of the cells of a grid, as trapezoids.
//
// A cell that none of them enters is there as a whole or not at all; another is cut into slabs between the heights of all corners in
// it, and a slab into trapezoids between the edges that pass through it, each of which is there where a ray from it crosses the loops an
// odd number of times.
#include <stdlib.h>

#include "maps/curved/curved_trim.h"

enum { MOST_PIECES = 50000 };  // where loops cross each other all over

static int by_number(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double u_at(const TrimSegment *s, double v) {
    if (v == s->a.y) return s->a.x;
    if (v == s->b.y) return s->b.x;
    return curved_snap(s->a.x + (s->b.x - s->a.x) * (v - s->a.y) / (s->b.y - s->a.y));
}

// An odd number of segments lies to the left.
static bool is_there(const CurvedTrimmed *t, Vec2 p) {
    bool in = false;
    for (int i = 0; i < t->segment_count; i++) {
        const TrimSegment *s = &t->segments[i];
        if ((s->a.y > p.y) == (s->b.y > p.y)) continue;
        double u = s->a.x + (s->b.x - s->a.x) * (p.y - s->a.y) / (s->b.y - s->a.y);
        if (u < p.x) in = !in;
    }
    return in;
}

static bool is_full(const CurvedTrimmed *t) { return t->piece_count >= MOST_PIECES; }

static void add_trim_piece(CurvedTrimmed *t, Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    const Vec2 given[4] = {a, b, c, d};
    TrimPiece piece = {.count = 0};
    for (int i = 0; i < 4; i++)
        if (!vec2_equal(given[i], given[(i + 1) % 4])) piece.corner[piece.count++] = given[i];
    if (piece.count < 3) return;
    *ARENA_PUSH(t->arena, t->pieces, t->piece_count, t->piece_capacity) = piece;
    t->corner_count += piece.count;
}

typedef struct Levels {
    double *v;
    int count, capacity;
} Levels;

static void add_level(CurvedTrimmed *t, Levels *levels, double v) {
    *ARENA_PUSH(t->arena, levels->v, levels->count, levels->capacity) = v;
}

// Where two segments of a cell cross, their order changes.
static void add_crossing(CurvedTrimmed *t, const TrimSegment *s, const TrimSegment *r, Levels *levels) {
    Vec2 d = vec2_sub(s->b, s->a), e = vec2_sub(r->b, r->a), from = vec2_sub(r->a, s->a);
    double turn = vec2_cross(d, e);
    if (turn == 0) return;
    double x = vec2_cross(from, e) / turn, y = vec2_cross(from, d) / turn;
    if (x > 0 && x < 1 && y > 0 && y < 1) add_level(t, levels, curved_snap(s->a.y + x * d.y));
}

typedef struct Edge {
    double middle;  // u at half the slab's height
    double low, high;
    bool side;  // of the cell, no segment
} Edge;

static int by_middle(const void *a, const void *b) {
    return by_number(&((const Edge *)a)->middle, &((const Edge *)b)->middle);
}

// The sides of the cell and the segments that pass through the slab, by u.
static int find_edges(const CurvedTrimmed *t, int column, double low, double high, const TrimSegment *in,
                      int count, Edge *edges) {
    int n = 0;
    for (int k = 0; k < 2; k++) {
        double side = t->u[column + k];
        edges[n++] = (Edge){side, side, side, true};
    }
    for (int i = 0; i < count; i++) {
        const TrimSegment *s = &in[i];
        if (fmin(s->a.y, s->b.y) > low || fmax(s->a.y, s->b.y) < high) continue;
        double a = u_at(s, low), b = u_at(s, high);
        edges[n++] = (Edge){(a + b) / 2, a, b, false};
    }
    qsort(edges, (size_t)n, sizeof *edges, by_middle);
    return n;
}

// The first gap between edges is asked for; each segment after it changes the answer.
static void add_slab(CurvedTrimmed *t, double low, double high, const Edge *edges, int count) {
    bool known = false, there = false;
    for (int i = 0; i + 1 < count; i++) {
        const Edge *e = &edges[i], *f = &edges[i + 1];
        if (known && !e->side) there = !there;
        if (e->middle == f->middle) continue;
        if (!known) there = is_there(t, vec2((e->middle + f->middle) / 2, (low + high) / 2));
        known = true;
        if (there)
            add_trim_piece(t, vec2(e->low, low), vec2(f->low, low), vec2(f->high, high), vec2(e->high, high));
    }
}

static void add_cell(CurvedTrimmed *t, int i, int j, const TrimSegment *in, int count) {
    Levels levels = {0};
    Edge *edges = ARENA_ARRAY(t->arena, Edge, count + 2);
    for (int k = 0; k < 2; k++) add_level(t, &levels, t->v[j + k]);
    for (int s = 0; s < count; s++) {
        add_level(t, &levels, in[s].a.y);
        add_level(t, &levels, in[s].b.y);
        for (int r = 0; r < s; r++) add_crossing(t, &in[s], &in[r], &levels);
    }
    qsort(levels.v, (size_t)levels.count, sizeof *levels.v, by_number);
    for (int k = 0; k + 1 < levels.count && !is_full(t); k++) {
        double low = levels.v[k], high = levels.v[k + 1];
        if (low < high) add_slab(t, low, high, edges, find_edges(t, i, low, high, in, count, edges));
    }
}

static int line_below(const double *line, int n, double x) {
    int i = 0;
    while (i + 1 < n && line[i + 1] <= x) i++;
    return i;
}

// Segments sorted by their cells.
static void add_cells(CurvedTrimmed *t) {
    int cells = t->nu * t->nv, *first = ARENA_ARRAY(t->arena, int, cells + 2),
        *cell = ARENA_ARRAY(t->arena, int, t->segment_count + 1);
    TrimSegment *sorted = ARENA_ARRAY(t->arena, TrimSegment, t->segment_count + 1);
    for (int i = 0; i < t->segment_count; i++) {
        const TrimSegment *s = &t->segments[i];
        cell[i] = line_below(t->v, t->nv, (s->a.y + s->b.y) / 2) * t->nu +
                  line_below(t->u, t->nu, (s->a.x + s->b.x) / 2);
        first[cell[i] + 2]++;
    }
    for (int c = 0; c < cells; c++) first[c + 2] += first[c + 1];
    for (int i = 0; i < t->segment_count; i++) sorted[first[cell[i] + 1]++] = t->segments[i];
    for (int c = 0; c < cells; c++)
        add_cell(t, c % t->nu, c / t->nu, sorted + first[c], first[c + 1] - first[c]);
}

bool curved_trim_cut(CurvedTrimmed *t) {
    add_cells(t);
    return !is_full(t);
}
