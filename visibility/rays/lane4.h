// lane4.h - four doubles at a time, by the vector extensions of GCC and clang; by name what those have no word for. A
// comparison gives a mask: all bits or none.
#ifndef RAYS_LANE4_H
#define RAYS_LANE4_H

#include <stdint.h>
#ifdef __AVX2__
#include <immintrin.h>
#endif

typedef double Lane4 __attribute__((vector_size(32)));
typedef int64_t Lane4Mask __attribute__((vector_size(32)));

static inline Lane4 lane4_of(double a) { return a - (Lane4){0}; }

static inline Lane4 lane4_choose(Lane4Mask mask, Lane4 yes, Lane4 no) {
#ifdef __AVX2__
    return (Lane4)_mm256_blendv_pd((__m256d)no, (__m256d)yes, (__m256d)mask);
#else
    return (Lane4)((mask & (Lane4Mask)yes) | (~mask & (Lane4Mask)no));
#endif
}

// Of what is no number, b.
static inline Lane4 lane4_least(Lane4 a, Lane4 b) {
#ifdef __AVX2__
    return (Lane4)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    return lane4_choose(a < b, a, b);
#endif
}

static inline Lane4 lane4_most(Lane4 a, Lane4 b) {
#ifdef __AVX2__
    return (Lane4)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    return lane4_choose(a > b, a, b);
#endif
}

static inline Lane4 lane4_abs(Lane4 a) { return (Lane4)((Lane4Mask)a & (INT64_MAX - (Lane4Mask){0})); }

// Bit i: lane i of the mask.
static inline unsigned lane4_mask(Lane4Mask mask) {
#ifdef __AVX2__
    return (unsigned)_mm256_movemask_pd((__m256d)mask);
#else
    unsigned bits = 0;
    for (int i = 0; i < 4; i++) bits |= (unsigned)(mask[i] < 0) << i;
    return bits;
#endif
}

static inline double lane4_least_of(Lane4 a) {
    a = lane4_least(a, __builtin_shufflevector(a, a, 2, 3, 0, 1));
    a = lane4_least(a, __builtin_shufflevector(a, a, 1, 0, 3, 2));
    return a[0];
}

static inline double lane4_most_of(Lane4 a) {
    a = lane4_most(a, __builtin_shufflevector(a, a, 2, 3, 0, 1));
    a = lane4_most(a, __builtin_shufflevector(a, a, 1, 0, 3, 2));
    return a[0];
}

// Lane by lane, of four rows.
static inline Lane4 lane4_least_row(const Lane4 row[4]) {
    return lane4_least(lane4_least(row[0], row[1]), lane4_least(row[2], row[3]));
}
static inline Lane4 lane4_most_row(const Lane4 row[4]) {
    return lane4_most(lane4_most(row[0], row[1]), lane4_most(row[2], row[3]));
}

static inline double lane4_sum(Lane4 a) { return (a[0] + a[1]) + (a[2] + a[3]); }

// Rows become columns.
static inline void lane4_transpose(Lane4 row[4]) {
    Lane4 a = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6);
    Lane4 b = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
    Lane4 c = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6);
    Lane4 d = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
    row[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    row[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    row[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    row[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

#endif
