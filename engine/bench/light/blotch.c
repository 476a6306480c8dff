// blotch.c - blotches in octave bands: on each plane of the picture log(shown / truth) is laid on a grid, and smoothed by Gaussians
// of which each is twice as wide as the one before; their differences are the bands (Burt & Adelson 1983). Pixels are scattered and
// planes have borders: each Gaussian is divided by the one of the pixels' number (Knutsson & Westin 1993, normalized convolution).
#include "engine/bench/light/blotch.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/arena.h"
#include "radiosity/factors/view.h"

// The smallest blotch, and the squares of the grid, metres: half of that, since a wave takes two samples.
static const double SMALLEST = 0.06, SQUARE = 0.03;
// Light has an edge where its logarithm changes by so much within the smallest blotch; and the least share of pixels that stay.
static const double EDGE = 0.1, LEAST_SHARE = 0.6;
// Planes are one where normals and distances from the origin round to the same multiples of these; walls lie on whole millimetres,
// of which none is half way between two multiples, metres.
static const double SAME_NORMAL = 1e-3, SAME_DISTANCE = 3e-3;
// Squares of the largest grid: 120 m each way.
static const double MOST_SQUARES = 16e6;
// Gaussians end at so many deviations.
static const double TAIL = 3;
// Squares to look along for a neighbour: far walls have a pixel for several.
enum { NEIGHBOUR = 4 };

// A pixel by its plane.
typedef struct PlanePixel {
    int64_t plane[4];  // normal and distance, rounded
    int pixel;
} PlanePixel;

// The pixels of one plane on a grid of squares.
typedef struct PlaneGrid {
    int width, height;
    float *weight, *ratio, *light;  // [height * width] pixels; sums of log(shown / truth) and of log(truth)
    float *smooth[2], *row;         // of the sums of `ratio` and `weight`; a pass between
    int *square;                    // [pixel count of the plane]
} PlaneGrid;

typedef struct Blotch {
    const BlotchPixels *pixels;
    PlanePixel *order;  // [count]
    double *slope;      // [count] of log(truth) by the metre, in the order of `order`; -1: no grid
    double most_slope;
    double squares[BLOTCH_BANDS];
    int kept;
} Blotch;

static int by_plane(const void *a, const void *b) {
    const PlanePixel *p = a, *q = b;
    for (int i = 0; i < 4; i++)
        if (p->plane[i] != q->plane[i]) return p->plane[i] < q->plane[i] ? -1 : 1;
    return p->pixel - q->pixel;
}

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

static void sort_by_plane(Blotch *self) {
    for (int i = 0; i < self->pixels->count; i++) {
        Vec3 n = self->pixels->normal[i];
        double d = vec3_dot(n, self->pixels->point[i]);
        self->order[i] = (PlanePixel){{llrint(n.x / SAME_NORMAL), llrint(n.y / SAME_NORMAL),
                                       llrint(n.z / SAME_NORMAL), llrint(d / SAME_DISTANCE)},
                                      i};
    }
    qsort(self->order, (size_t)self->pixels->count, sizeof *self->order, by_plane);
}

// Where the plane that begins at `first` ends in the order.
static int plane_end(const Blotch *self, int first) {
    int end = first;
    while (end < self->pixels->count &&
           memcmp(self->order[end].plane, self->order[first].plane, sizeof self->order->plane) == 0)
        end++;
    return end;
}

// False where the plane is too large for a grid.
static bool fill_grid(const Blotch *self, int first, int end, Arena *arena, PlaneGrid *out) {
    const BlotchPixels *pixels = self->pixels;
    Vec3 x, y;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    view_axes(pixels->normal[self->order[first].pixel], &x, &y);
    for (int i = first; i < end; i++) {
        Vec3 p = pixels->point[self->order[i].pixel];
        double at[2] = {vec3_dot(x, p), vec3_dot(y, p)};
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
    double columns = (high[0] - low[0]) / SQUARE + 1, rows = (high[1] - low[1]) / SQUARE + 1;
    if (!(columns * rows < MOST_SQUARES)) return false;
    *out = (PlaneGrid){.width = (int)columns, .height = (int)rows};
    int squares = out->width * out->height;
    out->weight = ARENA_ARRAY(arena, float, squares);
    out->ratio = ARENA_ARRAY(arena, float, squares);
    out->light = ARENA_ARRAY(arena, float, squares);
    out->square = ARENA_ARRAY(arena, int, end - first);
    for (int i = first; i < end; i++) {
        int pixel = self->order[i].pixel;
        Vec3 p = pixels->point[pixel];
        int column = (int)((vec3_dot(x, p) - low[0]) / SQUARE),
            row = (int)((vec3_dot(y, p) - low[1]) / SQUARE);
        int s = (row < out->height ? row : out->height - 1) * out->width +
                (column < out->width ? column : out->width - 1);
        out->square[i - first] = s;
        out->weight[s] += 1;
        out->ratio[s] += (float)log(pixels->shown[pixel] / pixels->truth[pixel]);
        out->light[s] += (float)log(pixels->truth[pixel]);
    }
    return true;
}

// The steepest way from a square to the nearest others with pixels, along rows and columns: the change of log(truth) by the metre.
static double slope_at(const PlaneGrid *grid, int square) {
    static const int STEPS[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    int column = square % grid->width, row = square / grid->width;
    double own = (double)(grid->light[square] / grid->weight[square]), steepest = 0;
    for (int k = 0; k < 4; k++) {
        for (int far = 1; far <= NEIGHBOUR; far++) {
            int c = column + far * STEPS[k][0], r = row + far * STEPS[k][1];
            if (c < 0 || r < 0 || c >= grid->width || r >= grid->height) break;
            int other = r * grid->width + c;
            if (grid->weight[other] == 0) continue;
            double change = fabs((double)(grid->light[other] / grid->weight[other]) - own);
            steepest = fmax(steepest, change / (far * SQUARE));
            break;
        }
    }
    return steepest;
}

static void find_slopes(Blotch *self) {
    Arena scratch = {0};
    for (int first = 0, end; first < self->pixels->count; first = end) {
        PlaneGrid grid;
        arena_reset(&scratch);
        end = plane_end(self, first);
        bool fits = fill_grid(self, first, end, &scratch, &grid);
        for (int i = first; i < end; i++)
            self->slope[i] = fits ? slope_at(&grid, grid.square[i - first]) : -1;
    }
    arena_free(&scratch);
}

// The slope at which light has an edge, or the one that leaves enough pixels.
static void find_most_slope(Blotch *self) {
    Arena scratch = {0};
    int count = self->pixels->count;
    double *sorted = ARENA_ARRAY(&scratch, double, count + 1);
    memcpy(sorted, self->slope, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, by_size);
    int least = (int)ceil(LEAST_SHARE * count) - 1;
    self->most_slope = fmax(EDGE / SMALLEST, count > 0 ? sorted[least] : 0);
    arena_free(&scratch);
}

static bool stays(const Blotch *self, int i) {
    return self->slope[i] >= 0 && self->slope[i] <= self->most_slope;
}

// One pass of a Gaussian along rows (step 1) or columns (step width).
static void smooth_pass(const float *from, float *to, int width, int height, bool rows, const float *tap,
                        int reach) {
    int step = rows ? 1 : width, length = rows ? width : height;
    for (int r = 0; r < height; r++) {
        for (int c = 0; c < width; c++) {
            int at = r * width + c, along = rows ? c : r;
            int low = along < reach ? -along : -reach;
            int high = along + reach >= length ? length - 1 - along : reach;
            float sum = 0;
            for (int k = low; k <= high; k++) sum += tap[abs(k)] * from[at + k * step];
            to[at] = sum;
        }
    }
}

static void smooth(const PlaneGrid *grid, const float *from, double deviation, float *to, Arena *scratch) {
    int reach = (int)ceil(TAIL * deviation / SQUARE);
    float *tap = ARENA_ARRAY(scratch, float, reach + 1);
    for (int k = 0; k <= reach; k++) {
        double far = k * SQUARE / deviation;
        tap[k] = (float)exp(-far * far / 2);
    }
    smooth_pass(from, grid->row, grid->width, grid->height, true, tap, reach);
    smooth_pass(grid->row, to, grid->width, grid->height, false, tap, reach);
}

// Adds the squares of the bands at the pixels that stay.
static void add_plane(Blotch *self, int first, int end, Arena *scratch) {
    PlaneGrid grid;
    if (!fill_grid(self, first, end, scratch, &grid)) return;
    int squares = grid.width * grid.height;
    memset(grid.weight, 0, (size_t)squares * sizeof *grid.weight);
    memset(grid.ratio, 0, (size_t)squares * sizeof *grid.ratio);
    for (int i = first; i < end; i++) {
        int pixel = self->order[i].pixel, s = grid.square[i - first];
        if (!stays(self, i)) continue;
        grid.weight[s] += 1;
        grid.ratio[s] += (float)log(self->pixels->shown[pixel] / self->pixels->truth[pixel]);
        self->kept++;
    }
    grid.row = ARENA_ARRAY(scratch, float, squares);
    for (int k = 0; k < 2; k++) grid.smooth[k] = ARENA_ARRAY(scratch, float, squares);
    double *finer = ARENA_ARRAY(scratch, double, end - first);
    for (int b = 0; b <= BLOTCH_BANDS; b++) {
        double deviation = SMALLEST / 2 * (1 << b);
        smooth(&grid, grid.ratio, deviation, grid.smooth[0], scratch);
        smooth(&grid, grid.weight, deviation, grid.smooth[1], scratch);
        for (int i = first; i < end; i++) {
            if (!stays(self, i)) continue;
            int s = grid.square[i - first];
            double mean = (double)(grid.smooth[0][s] / grid.smooth[1][s]), band = finer[i - first] - mean;
            if (b > 0) self->squares[b - 1] += band * band;
            finer[i - first] = mean;
        }
    }
}

double blotch_bands(const BlotchPixels *pixels, double rms[BLOTCH_BANDS]) {
    Arena arena = {0}, scratch = {0};
    Blotch self = {.pixels = pixels,
                   .order = ARENA_ARRAY(&arena, PlanePixel, pixels->count + 1),
                   .slope = ARENA_ARRAY(&arena, double, pixels->count + 1)};
    sort_by_plane(&self);
    find_slopes(&self);
    find_most_slope(&self);
    for (int first = 0, end; first < pixels->count; first = end) {
        end = plane_end(&self, first);
        arena_reset(&scratch);
        add_plane(&self, first, end, &scratch);
    }
    for (int b = 0; b < BLOTCH_BANDS; b++) rms[b] = self.kept > 0 ? sqrt(self.squares[b] / self.kept) : 0;
    arena_free(&arena);
    arena_free(&scratch);
    return pixels->count > 0 ? (double)self.kept / pixels->count : 0;
}
