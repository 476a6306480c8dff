// lanes.h - eight floats, or four doubles, at a time, by the vector extensions of GCC and clang, with functions for the operations
// that the extensions lack. A comparison gives a mask: in each lane all bits are set, or none. Doubles are for computations for
// which floats are too rough, and for short lists that would leave most of eight lanes empty.
#ifndef CORE_LANES_H
#define CORE_LANES_H

#include <stdint.h>
#include <string.h>
#ifdef __AVX2__
#include <immintrin.h>
#else
#include <math.h>
#endif

// ---- eight floats

// Stands before a loop over the rows of a block and unrolls it, so that the masks of the rows stay in registers.
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

// `yes` in the lanes in which the mask's sign bit is set, `no` in the others.
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

// a * b + c, rounded once. The fused operation is explicit, so that the result is the same on every machine.
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

// The larger of a and b in each lane; b where either is NaN.
static inline Lane lane_most(Lane a, Lane b) {
#ifdef __AVX2__
    return (Lane)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return lane_choose(a > b, a, b);
#endif
}

// Bit i of the result is lane i of the mask.
static inline unsigned lane_mask(LaneInt mask) {
#ifdef __AVX2__
    return (unsigned)_mm256_movemask_ps((__m256)mask);
#else
    unsigned bits = 0;
    for (int i = 0; i < LANES; i++) bits |= (unsigned)(mask[i] < 0) << i;
    return bits;
#endif
}

// The least of the eight lanes.
static inline float lane_least_of(Lane a) {
    a = lane_least(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3));
    a = lane_least(a, __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5));
    a = lane_least(a, __builtin_shufflevector(a, a, 1, 0, 3, 2, 5, 4, 7, 6));
    return a[0];
}

// ---- four doubles

enum { FOUR = 4, FOUR_ALL = 15 };  // FOUR_ALL: a bit for each of the four lanes
typedef double Four __attribute__((vector_size(32)));
typedef int64_t FourMask __attribute__((vector_size(32)));
typedef float FourFloat __attribute__((vector_size(16)));
typedef int32_t FourInt __attribute__((vector_size(16)));

static inline Four four_of(double a) { return (Four){a, a, a, a}; }
// From and to any place in an array.
static inline Four four_load(const double *from) {
    Four a;
    memcpy(&a, from, sizeof a);
    return a;
}
static inline void four_store(double *to, Four a) { memcpy(to, &a, sizeof a); }
static inline Four four_abs(Four a) { return (Four)((FourMask)a & INT64_MAX); }
// Without AVX the lanes are converted one by one: GCC 12 for aarch64 breaks off on __builtin_convertvector.
#ifdef __AVX__
static inline Four four_from_float(FourFloat a) { return __builtin_convertvector(a, Four); }
static inline FourFloat four_to_float(Four a) { return __builtin_convertvector(a, FourFloat); }
#else
static inline Four four_from_float(FourFloat a) {
    return (Four){(double)a[0], (double)a[1], (double)a[2], (double)a[3]};
}
static inline FourFloat four_to_float(Four a) {
    return (FourFloat){(float)a[0], (float)a[1], (float)a[2], (float)a[3]};
}
#endif

static inline Four four_choose(FourMask mask, Four yes, Four no) {
#ifdef __AVX2__
    return (Four)_mm256_blendv_pd((__m256d)no, (__m256d)yes, (__m256d)mask);
#else
    return (Four)((mask & (FourMask)yes) | (~mask & (FourMask)no));
#endif
}

// The smaller of a and b in each lane; b where either is NaN.
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

// Bit i of the result is lane i of the mask.
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

static inline double four_least_of(Four a) {
    a = four_least(a, __builtin_shufflevector(a, a, 2, 3, 0, 1));
    a = four_least(a, __builtin_shufflevector(a, a, 1, 0, 3, 2));
    return a[0];
}

static inline double four_most_of(Four a) {
    a = four_most(a, __builtin_shufflevector(a, a, 2, 3, 0, 1));
    a = four_most(a, __builtin_shufflevector(a, a, 1, 0, 3, 2));
    return a[0];
}

// The least, and the greatest, of four rows, lane by lane.
static inline Four four_least_row(const Four row[4]) {
    return four_least(four_least(row[0], row[1]), four_least(row[2], row[3]));
}
static inline Four four_most_row(const Four row[4]) {
    return four_most(four_most(row[0], row[1]), four_most(row[2], row[3]));
}

static inline double four_sum(Four a) { return (a[0] + a[1]) + (a[2] + a[3]); }

// Transposes a block of four rows: rows become columns.
static inline void four_transpose(Four row[4]) {
    Four a = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6);
    Four b = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
    Four c = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6);
    Four d = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
    row[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    row[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    row[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    row[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

// A bit for each lane whose number `at` is in a set of bits; number n is bit n % 64 of word n / 64. The words are loaded one by
// one, since processors gather slowly.
static inline unsigned four_in_set(const uint64_t *set, FourInt at) {
    unsigned lanes = 0;
    for (int i = 0; i < FOUR; i++) lanes |= (unsigned)(set[at[i] >> 6] >> (at[i] & 63) & 1) << i;
    return lanes;
}

#endif
