// lane.h - eight floats at a time, by the vector extensions of GCC and clang; by name what those have no word for. A
// comparison gives a mask: all bits or none.
#ifndef CORE_LANE_H
#define CORE_LANE_H

#include <stdint.h>
#ifdef __AVX2__
#include <immintrin.h>
#else
#include <math.h>
#endif

// Before a loop over the rows of a block, whose masks then stay in registers.
#ifdef __clang__
#define LANE_UNROLL _Pragma("unroll")
#else
#define LANE_UNROLL _Pragma("GCC unroll 8")
#endif

enum { LANES = 8 };
typedef float Lane __attribute__((vector_size(32)));
typedef int32_t LaneInt __attribute__((vector_size(32)));

static inline Lane lane_of(float a) { return a - (Lane){0}; }
static inline LaneInt lane_int_of(int32_t a) { return a - (LaneInt){0}; }

static inline LaneInt lane_bits(Lane a) { return (LaneInt)a; }
static inline Lane lane_abs(Lane a) { return (Lane)(lane_bits(a) & lane_int_of(0x7fffffff)); }

// By the sign bits of the mask alone.
static inline Lane lane_choose(LaneInt mask, Lane yes, Lane no) {
#ifdef __AVX2__
    return (Lane)_mm256_blendv_ps((__m256)no, (__m256)yes, (__m256)mask);
#else
    mask = mask < 0;
    return (Lane)((mask & lane_bits(yes)) | (~mask & lane_bits(no)));
#endif
}

static inline LaneInt lane_choose_int(LaneInt mask, LaneInt yes, LaneInt no) {
    return lane_bits(lane_choose(mask, (Lane)yes, (Lane)no));
}

// a * b + c, rounded once: said outright, it is the same everywhere.
static inline Lane lane_multiply_add(Lane a, Lane b, Lane c) {
#ifdef __FMA__
    return (Lane)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
    for (int i = 0; i < LANES; i++) c[i] = fmaf(a[i], b[i], c[i]);
    return c;
#endif
}

static inline Lane lane_root(Lane a) {
#ifdef __AVX2__
    return (Lane)_mm256_sqrt_ps((__m256)a);
#else
    for (int i = 0; i < LANES; i++) a[i] = sqrtf(a[i]);
    return a;
#endif
}

static inline LaneInt lane_look_up(const int32_t *table, LaneInt index) {
#ifdef __AVX2__
    return (LaneInt)_mm256_i32gather_epi32(table, (__m256i)index, 4);
#else
    LaneInt out = {0};
    for (int i = 0; i < LANES; i++) out[i] = table[index[i]];
    return out;
#endif
}

static inline Lane lane_least(Lane a, Lane b) {
#ifdef __AVX2__
    return (Lane)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return lane_choose(a < b, a, b);
#endif
}

// b where either is no number.
static inline Lane lane_most(Lane a, Lane b) {
#ifdef __AVX2__
    return (Lane)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return lane_choose(a > b, a, b);
#endif
}

// Bit i: lane i of the mask.
static inline unsigned lane_mask(LaneInt mask) {
#ifdef __AVX2__
    return (unsigned)_mm256_movemask_ps((__m256)mask);
#else
    unsigned bits = 0;
    for (int i = 0; i < LANES; i++) bits |= (unsigned)(mask[i] < 0) << i;
    return bits;
#endif
}

// The least of the eight.
static inline float lane_least_of(Lane a) {
    a = lane_least(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3));
    a = lane_least(a, __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5));
    a = lane_least(a, __builtin_shufflevector(a, a, 1, 0, 3, 2, 5, 4, 7, 6));
    return a[0];
}

#endif
