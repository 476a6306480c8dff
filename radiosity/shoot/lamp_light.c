// lamp_light.c - sparse vectors of light, in blocks of numbers with a common exponent.
#include "radiosity/shoot/lamp_light.h"

#include <math.h>
#include <string.h>

// Bits of a channel, and of the exponent.
enum { CHANNEL = 9, MOST = (1 << CHANNEL) - 1, EXPONENTS = 32 };

// Does a block have light that counts?
static bool counts(double (*light)[3], double (*usual)[3], int first, int end, double least) {
    for (int i = first; i < end; i++) {
        double all = rgb_sum(light[i]);
        if (all > 0 && (!usual || all > least * rgb_sum(usual[i]))) return true;
    }
    return false;
}

// Steps of a channel, by the exponent.
static void find_steps(float greatest, double step[EXPONENTS]) {
    for (int e = 0; e < EXPONENTS; e++) step[e] = ldexp((double)greatest / MOST, e - (EXPONENTS - 1));
}

static uint32_t encode(const double light[3], const double step[EXPONENTS]) {
    double most = fmax(fmax(light[0], light[1]), light[2]);
    if (!(most > 0)) return 0;
    int e = EXPONENTS - 1;
    while (e > 0 && most <= MOST * step[e - 1]) e--;
    uint32_t out = (uint32_t)e << 3 * CHANNEL;
    for (int c = 0; c < 3; c++) out |= (uint32_t)fmin(rint(fmax(light[c], 0) / step[e]), MOST) << c * CHANNEL;
    return out;
}

SparseLight sparse_light_new(double (*light)[3], double (*usual)[3], int count, double least, Arena *arena) {
    SparseLight out = {.count = count};
    double step[EXPONENTS];
    int blocks = (count + LIGHT_BLOCK - 1) / LIGHT_BLOCK, kept = 0;
    bool *keep = ARENA_ARRAY(arena, bool, blocks + 1);
    for (int b = 0; b < blocks; b++) {
        int first = b * LIGHT_BLOCK, end = first + LIGHT_BLOCK < count ? first + LIGHT_BLOCK : count;
        keep[b] = counts(light, usual, first, end, least);
        out.block_count += keep[b];
        for (int i = first; i < end; i++)
            for (int c = 0; c < 3; c++) out.greatest = fmaxf(out.greatest, (float)light[i][c]);
    }
    find_steps(out.greatest, step);
    out.block = ARENA_ARRAY(arena, int, out.block_count + 1);
    out.value = arena_alloc(arena, (size_t)out.block_count + 1, sizeof *out.value);
    for (int b = 0; b < blocks; b++) {
        if (!keep[b]) continue;
        out.block[kept] = b;
        for (int i = 0; i < LIGHT_BLOCK && b * LIGHT_BLOCK + i < count; i++)
            out.value[kept][i] = encode(light[b * LIGHT_BLOCK + i], step);
        kept++;
    }
    return out;
}

void sparse_light_add(const SparseLight *light, const double share[3], double (*out)[3]) {
    double step[EXPONENTS], channel[EXPONENTS][3];
    find_steps(light->greatest, step);
    for (int e = 0; e < EXPONENTS; e++)
        for (int c = 0; c < 3; c++) channel[e][c] = step[e] * share[c];
    for (int b = 0; b < light->block_count; b++) {
        int first = light->block[b] * LIGHT_BLOCK,
            count = light->count - first < LIGHT_BLOCK ? light->count - first : LIGHT_BLOCK;
        for (int i = 0; i < count; i++) {
            uint32_t value = light->value[b][i];
            const double *by = channel[value >> 3 * CHANNEL];
            for (int c = 0; c < 3; c++) out[first + i][c] += by[c] * (value >> c * CHANNEL & MOST);
        }
    }
}

size_t sparse_light_bytes(const SparseLight *light) {
    return (size_t)light->block_count * (sizeof *light->block + sizeof *light->value);
}
