// test_smooth.c - edges smoothed after drawing.
#include <criterion/criterion.h>
#include <math.h>
#include <string.h>

#include "engine/draw/smooth.h"

enum { W = 160, H = 90 };
static const double DARK = 60, LIGHT = 200;

// The share of a pixel below a line y = y0 + slope * x, by 8 x 8 points in it.
static double below(int x, int y, double y0, double slope) {
    int count = 0;
    for (int k = 0; k < 64; k++) count += y + (k / 8 + 0.5) / 8 > y0 + slope * (x + (k % 8 + 0.5) / 8);
    return count / 64.0;
}

static uint32_t grey(double value) {
    uint32_t g = (uint32_t)lrint(value);
    return 0xff000000u | g << 16 | g << 8 | g;
}

// The mean difference from the exact coverage, of the pixels that the line crosses.
static double error_of(const uint32_t *pixels, double y0, double slope) {
    double sum = 0;
    int count = 0;
    for (int y = 3; y < H - 3; y++)
        for (int x = 20; x < W - 20; x++) {
            double share = below(x, y, y0, slope);
            if (share == 0 || share == 1) continue;
            sum += fabs((pixels[y * W + x] & 255) - (DARK + share * (LIGHT - DARK)));
            count++;
        }
    return sum / count;
}

// Proves that a slanted edge comes nearer to its exact coverage, by a third at least, for slopes from 1 in 12 to 1 in 2, and
// that pixels that no edge is near stay as they are, bit for bit.
Test(smooth, edges_come_near_their_coverage) {
    static const double SLOPES[] = {1.0 / 12, 1.0 / 7, 0.21, 1.0 / 3, 0.5};
    Smoother smoother = {.width = 0};
    for (size_t i = 0; i < sizeof SLOPES / sizeof *SLOPES; i++) {
        static uint32_t drawn[W * H], smooth[W * H];
        double slope = SLOPES[i], y0 = 20.3;
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                drawn[y * W + x] = grey(y + 0.5 > y0 + slope * (x + 0.5) ? LIGHT : DARK);
        memcpy(smooth, drawn, sizeof smooth);
        smooth_edges(&smoother, smooth, W, H);
        double before = error_of(drawn, y0, slope), after = error_of(smooth, y0, slope);
        cr_expect_lt(after, before * 2 / 3, "slope %g: %g levels before, %g after", slope, before, after);
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                if (fabs(y + 0.5 - y0 - slope * (x + 0.5)) > 2)
                    cr_assert_eq(drawn[y * W + x], smooth[y * W + x], "%d, %d", x, y);
    }
    smooth_free(&smoother);
}

// Proves that shading without edges is untouched, and that pictures too small to have neighbours are.
Test(smooth, leaves_shading_alone) {
    static uint32_t drawn[W * H], smooth[W * H];
    Smoother smoother = {.width = 0};
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) drawn[y * W + x] = grey(40 + x + y / 2.0);
    memcpy(smooth, drawn, sizeof smooth);
    smooth_edges(&smoother, smooth, W, H);
    cr_expect_arr_eq(smooth, drawn, sizeof smooth);
    for (int side = 1; side < 4; side++) smooth_edges(&smoother, smooth, side, side);
    smooth_free(&smoother);
}
