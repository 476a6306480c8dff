// smooth.c - edges smoothed after drawing, by the idea of FXAA (T. Lottes, NVIDIA white paper, 2009): where the brightness of neighbours
// differs much, the edge is followed along its row or column to both ends, and the pixel takes as much of its neighbour across the edge
// as a straight line between those ends would cover. It is done on the processor and not in a shader, since it serves software OpenGL,
// in which a shader over all pixels took one and a half times as long as the frame; here pixels without an edge cost a few instructions
// for 32 of them. The constants are our own.
#include "engine/draw/smooth.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

// An edge differs by more than this, of 255, and by more than this power of two of the brighter side.
enum { LEAST = 10, SHARE_BITS = 3 };
// An edge is followed so far each way, pixels: one that rises by a pixel in 24 still looks straight.
enum { REACH = 12 };
// The share that a pixel takes of its neighbour at most where it stands out alone, of 256.
enum { ALONE = 100 };

void smooth_free(Smoother *s) {
    arena_free(&s->arena);
    *s = (Smoother){.width = 0};
}

static void fit_picture(Smoother *s, int width, int height) {
    if (s->width == width && s->height == height) return;
    size_t count = (size_t)width * (size_t)height;
    smooth_free(s);
    s->bright = ARENA_ARRAY(&s->arena, uint8_t, count);
    s->changed = ARENA_ARRAY(&s->arena, uint32_t, count);
    s->to = ARENA_ARRAY(&s->arena, uint32_t, count);
    s->edge = ARENA_ARRAY(&s->arena, uint8_t, (size_t)width + sizeof(uint64_t));
    s->width = width;
    s->height = height;
}

// Brightness by the weights of ITU-R BT.601 on the screen's values.
static void find_brightness(const uint32_t *pixels, uint8_t *bright, int count) {
#pragma omp simd
    for (int i = 0; i < count; i++) {
        uint32_t c = pixels[i];
        bright[i] = (uint8_t)((29 * (c & 255) + 150 * (c >> 8 & 255) + 77 * (c >> 16 & 255)) >> 8);
    }
}

static inline uint8_t least(uint8_t a, uint8_t b) { return a < b ? a : b; }
static inline uint8_t most(uint8_t a, uint8_t b) { return a > b ? a : b; }

// Is there an edge at each pixel 1 .. width - 2 of a row?
static void find_edges(const uint8_t *restrict row, int width, uint8_t *restrict edge) {
    const uint8_t *above = row - width, *below = row + width;
#pragma omp simd
    for (int x = 1; x < width - 1; x++) {
        uint8_t high = most(most(most(row[x - 1], row[x + 1]), most(above[x], below[x])), row[x]);
        uint8_t low = least(least(least(row[x - 1], row[x + 1]), least(above[x], below[x])), row[x]);
        edge[x] = (uint8_t)(high - low) > most(LEAST, (uint8_t)(high >> SHARE_BITS));
    }
}

// How far the edge between a pixel and its neighbour across goes on one way, 1 .. REACH, and how twice their mean differs there from here.
// `at` walks in steps of `along`, at most `room` of them.
static int follow(const uint8_t *at, ptrdiff_t along, ptrdiff_t across, int room, int twice_middle,
                  int half_step, int *end) {
    int steps = 1;
    for (;; steps++) {
        if (steps <= room) at += along;
        *end = at[0] + at[across] - twice_middle;
        if (steps == REACH || abs(*end) >= half_step) return steps;
    }
}

// The share of the neighbour `across` that belongs to this pixel, of 256; 0: none.
static int covered_share(const uint8_t *b, int x, int y, int width, int height, ptrdiff_t *across) {
    const ptrdiff_t row = width;
    int m = b[0], n = b[-row], s = b[row], w = b[-1], e = b[1];
    int nw = b[-row - 1], ne = b[-row + 1], sw = b[row - 1], se = b[row + 1];
    int rows = abs(nw - 2 * w + sw) + 2 * abs(n - 2 * m + s) + abs(ne - 2 * e + se);
    int columns = abs(nw - 2 * n + ne) + 2 * abs(w - 2 * m + e) + abs(sw - 2 * s + se);
    bool level = rows >= columns;
    int before = level ? n : w, after = level ? s : e;
    bool first = abs(before - m) >= abs(after - m);
    ptrdiff_t along = level ? 1 : row;
    *across = (level ? row : 1) * (first ? -1 : 1);
    int other = first ? before : after, half_step = abs(other - m) / 2, back_end, forth_end;
    if (half_step < 1) return 0;
    // The neighbour across is in the picture as well, since the outermost pixels are left out.
    int back = follow(b, -along, *across, level ? x : y, m + other, half_step, &back_end);
    int forth =
        follow(b, along, *across, level ? width - 1 - x : height - 1 - y, m + other, half_step, &forth_end);
    int covered = 128 - 256 * (back < forth ? back : forth) / (back + forth);
    // Only the side of the edge that the line leaves is covered by the other.
    int end = back < forth ? back_end : forth_end;
    if ((2 * m < m + other) == (end < 0)) covered = 0;
    // A pixel that stands out alone, part of a thin thing, takes a little from all around.
    int high = m, low = m, around[] = {n, s, w, e};
    for (int i = 0; i < 4; i++) {
        if (around[i] > high) high = around[i];
        if (around[i] < low) low = around[i];
    }
    int mean = (2 * (n + s + w + e) + nw + ne + sw + se) / 12;
    int alone = 256 * abs(mean - m) / (high - low);
    if (alone > 256) alone = 256;
    int thin = ALONE * alone / 256 * alone / 256;
    return covered > thin ? covered : thin;
}

static uint32_t mix(uint32_t a, uint32_t b, uint32_t share) {
    uint32_t out = 0;
    for (int shift = 0; shift < 32; shift += 8) {
        uint32_t x = a >> shift & 255, y = b >> shift & 255;
        out |= (x * (256 - share) + y * share + 128) >> 8 << shift;
    }
    return out;
}

void smooth_edges(Smoother *s, uint32_t *pixels, int width, int height) {
    if (width < 3 || height < 3) return;
    fit_picture(s, width, height);
    find_brightness(pixels, s->bright, width * height);
    int count = 0;
    for (int y = 1; y < height - 1; y++) {
        const uint8_t *row = s->bright + (size_t)y * (size_t)width;
        find_edges(row, width, s->edge);
        for (int x0 = 0; x0 < width; x0 += (int)sizeof(uint64_t)) {
            uint64_t any;
            memcpy(&any, s->edge + x0, sizeof any);
            if (any == 0) continue;
            for (int x = x0; x < x0 + (int)sizeof any && x < width - 1; x++) {
                ptrdiff_t across;
                int share = s->edge[x] ? covered_share(row + x, x, y, width, height, &across) : 0;
                if (share == 0) continue;
                ptrdiff_t i = (ptrdiff_t)y * width + x;
                s->changed[count] = (uint32_t)i;
                s->to[count++] = mix(pixels[i], pixels[i + across], (uint32_t)share);
            }
        }
    }
    // Only now, since each pixel is made of what was drawn.
    for (int i = 0; i < count; i++) pixels[s->changed[i]] = s->to[i];
}
