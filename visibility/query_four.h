// query_four.h - four doubles at a time, by the vector extensions of GCC and clang; by name what those have no word for. A
// comparison gives a mask: all bits or none. Doubles, not eight floats: a cell has four or five portals in the mean, so
// that more lanes would stay empty, and the slacks of the query hold for buildings of any size.
#ifndef VISIBILITY_QUERY_FOUR_H
#define VISIBILITY_QUERY_FOUR_H

#include <stdint.h>
#ifdef __AVX2__
#include <immintrin.h>
#else
#include <math.h>
#endif

enum { FOUR = 4, FOUR_ALL = 15 };  // all: as lanes, a bit each
typedef double Four __attribute__((vector_size(32)));
typedef int64_t FourMask __attribute__((vector_size(32)));
typedef float FourFloat __attribute__((vector_size(16)));
typedef int32_t FourInt __attribute__((vector_size(16)));

static inline Four four_of(double a) { return (Four){a, a, a, a}; }
static inline Four four_abs(Four a) { return (Four)((FourMask)a & INT64_MAX); }
static inline Four four_from_float(FourFloat a) { return __builtin_convertvector(a, Four); }
static inline FourFloat four_to_float(Four a) { return __builtin_convertvector(a, FourFloat); }

static inline Four four_choose(FourMask mask, Four yes, Four no) {
#ifdef __AVX2__
    return (Four)_mm256_blendv_pd((__m256d)no, (__m256d)yes, (__m256d)mask);
#else
    return (Four)((mask & (FourMask)yes) | (~mask & (FourMask)no));
#endif
}

static inline Four four_least(Four a, Four b) {
#ifdef __AVX2__
    return (Four)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    return four_choose(a < b, a, b);
#endif
}

static inline Four four_most(Four a, Four b) {
#ifdef __AVX2__
    return (Four)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    return four_choose(a > b, a, b);
#endif
}

static inline Four four_root(Four a) {
#ifdef __AVX2__
    return (Four)_mm256_sqrt_pd((__m256d)a);
#else
    for (int i = 0; i < FOUR; i++) a[i] = sqrt(a[i]);
    return a;
#endif
}

// Bit i: lane i of the mask.
static inline unsigned four_lanes(FourMask mask) {
#ifdef __AVX2__
    return (unsigned)_mm256_movemask_pd((__m256d)mask);
#else
    unsigned lanes = 0;
    for (int i = 0; i < FOUR; i++) lanes |= (unsigned)(mask[i] < 0) << i;
    return lanes;
#endif
}

static inline FourMask four_mask(unsigned lanes) {
    FourMask bit = {1, 2, 4, 8}, all = {lanes, lanes, lanes, lanes};
    return (all & bit) != 0;
}

// Lanes whose bit is set in a set of bits: bit `at` is in word at / 64. One by one: processors gather slowly.
static inline unsigned four_in_set(const uint64_t *set, FourInt at) {
    unsigned lanes = 0;
    for (int i = 0; i < FOUR; i++) lanes |= (unsigned)(set[at[i] >> 6] >> (at[i] & 63) & 1) << i;
    return lanes;
}

#endif
