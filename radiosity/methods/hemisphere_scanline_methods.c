// hemisphere_scanline_methods.c - how many scan lines, and which ways: one way, both ways, and both ways as many as a shooter
// needs (Doi & Itoh, eq. 8 and section 3: "line sampling of variable kind in the horizontal and vertical directions").
//
// As the error falls almost with the square of the number of lines, so many lines of one way err half as much as half as many
// both ways. A line's length counts with the exact area of its strip, so that rows sum to 1.
//
// The paper does not say how the number is found. Here lines of the two ways are two measurements of one row, and how much
// they differ tells how wrong they are: each way begins with few lines, and lines between those there are are added until the
// two differ by no more than is allowed. Such lines are even in the angle t of y = -cos t, since then their weights, sin t, do
// not depend on how many there will be: the sum of sin^2 t over any even lattice is exactly half their number. Each shooter's
// error is bounded so, but the mean error of many is less, for the same time, where all take the same number of lines.
#include "radiosity/methods/hemisphere_scanline.h"

enum { MOST_LEVELS = 5 };  // from a quarter of `resolution` lines each way to four times as many
// How much both ways may differ, L1 of the rows, times resolution^1.5: so that shooters in an office take about `resolution`
// lines each way in the mean.
static const double DIFFERENCE = 60;
// Where in their strips lines begin. Halved again and again, the ways' lattices never come to lie alike, nor as mirror images:
// else a row that is the same both ways would seem right.
static const double OFFSET[2] = {1.0 / 3, 1.0 / 5};

typedef struct ScanMethod {
    Scanner *scan;
    int ways;  // 1 or 2
    ScanLattice lattice;
} ScanMethod;

// Area below y of the half of the disc where x > 0.
static double area_below(double y) { return (y * sqrt(1 - y * y) + asin(y)) / 2; }

static ScanLine line_at(double y, double weight) {
    double r2 = 1 - y * y;
    return (ScanLine){y, r2, sqrt(r2), weight};
}

static void *scanline_start(const Mesh *mesh, const FormFactorOptions *options, int ways, Arena *arena) {
    ScanMethod *self = ARENA_ARRAY(arena, ScanMethod, 1);
    int lines = options->resolution;
    self->scan = scanner_new(mesh, lines, arena);
    self->ways = ways;
    self->lattice = (ScanLattice){lines, 0.5, false, ARENA_ARRAY(arena, ScanLine, lines)};
    for (int k = 0; k < lines; k++) {
        double y0 = -1 + 2.0 * k / lines, y1 = k + 1 < lines ? -1 + 2.0 * (k + 1) / lines : 1;
        ScanLine *line = &self->lattice.line[k];
        *line = line_at(-1 + (2 * k + 1.0) / lines, (area_below(y1) - area_below(y0)) / (ways * M_PI));
        line->weight /= line->radius;
    }
    return self;
}

static void *start_one_way(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    return scanline_start(mesh, options, 1, arena);
}

static void *start_both_ways(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    return scanline_start(mesh, options, 2, arena);
}

static void scanline_row(void *context, const View *view, RowSum *sum, FormFactorWork *work) {
    const ScanMethod *self = context;
    scanner_look(self->scan, view);
    for (int way = 0; way < self->ways; way++) scanner_see(self->scan, &self->lattice, way == 1, sum, work);
}

// ---- as many as a shooter needs

typedef struct ScanFit {
    Scanner *scan;
    ScanLattice level[MOST_LEVELS][2];  // of each way; each lies between the lines of those before it
    double difference;                  // allowed
    RowSum across;                      // of the lines the other way
} ScanFit;

static ScanLattice even_in_angle(int count, double offset, Arena *arena) {
    ScanLattice lattice = {count, offset, true, ARENA_ARRAY(arena, ScanLine, count)};
    for (int k = 0; k < count; k++) {
        double t = M_PI * (k + offset) / count;
        lattice.line[k] = line_at(-cos(t), sin(t));
    }
    return lattice;
}

static void *start_fit(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    ScanFit *self = ARENA_ARRAY(arena, ScanFit, 1);
    int least = (options->resolution + 3) / 4, lines = least;
    for (int way = 0; way < 2; way++) {
        double offset = OFFSET[way];
        self->level[0][way] = even_in_angle(lines = least, offset, arena);
        for (int level = 1; level < MOST_LEVELS; level++, lines *= 2) {
            // In the middle of the strips between those there are; all together have strips of half the width.
            self->level[level][way] = even_in_angle(lines, fmod(offset + 0.5, 1), arena);
            offset = fmod(2 * offset, 1);
        }
    }
    self->scan = scanner_new(mesh, lines, arena);
    self->difference = DIFFERENCE / pow(options->resolution, 1.5);
    row_start(&self->across, mesh, arena);
    return self;
}

static double total_of(const RowSum *sum) {
    double total = sum->back + sum->escaped;
    for (int i = 0; i < sum->touched_count; i++) total += sum->share[sum->touched[i]];
    return total;
}

// L1 of two rows.
static double difference_of(const RowSum *a, const RowSum *b) {
    double sum = fabs(a->back - b->back) + fabs(a->escaped - b->escaped);
    for (int i = 0; i < a->touched_count; i++) sum += fabs(a->share[a->touched[i]] - b->share[a->touched[i]]);
    for (int i = 0; i < b->touched_count; i++)
        if (a->share[b->touched[i]] == 0) sum += b->share[b->touched[i]];
    return sum / total_of(a);
}

// Adds the one sum to the other, and empties it.
static void move_sum(RowSum *from, RowSum *to) {
    for (int i = 0; i < from->touched_count; i++) {
        int element = from->touched[i];
        row_add(to, element, from->share[element]);
        from->share[element] = 0;
    }
    to->back += from->back, to->escaped += from->escaped;
    from->back = from->escaped = 0;
    from->touched_count = 0;
}

static void row_fit(void *context, const View *view, RowSum *sum, FormFactorWork *work) {
    ScanFit *self = context;
    scanner_look(self->scan, view);
    for (int level = 0; level < MOST_LEVELS; level++) {
        scanner_see(self->scan, &self->level[level][0], false, sum, work);
        scanner_see(self->scan, &self->level[level][1], true, &self->across, work);
        if (difference_of(sum, &self->across) <= self->difference) break;
    }
    move_sum(&self->across, sum);
}

const FormFactorMethod FORM_FACTOR_HEMISPHERE_SCANLINE = {
    .name = "hemisphere-scanline",
    .summary = "lines over the hemisphere's base one way, exact along them",
    .mended = true,
    .start = start_one_way,
    .row = scanline_row,
};

const FormFactorMethod FORM_FACTOR_HEMISPHERE_SCANLINES = {
    .name = "hemisphere-scanlines",
    .summary = "the same both ways (Doi & Itoh), `resolution` lines each",
    .mended = true,
    .start = start_both_ways,
    .row = scanline_row,
};

const FormFactorMethod FORM_FACTOR_HEMISPHERE_SCANLINES_FIT = {
    .name = "hemisphere-scanlines-fit",
    .summary = "the same, as many as a shooter needs, some `resolution` each",
    .mended = true,
    .start = start_fit,
    .row = row_fit,
};
