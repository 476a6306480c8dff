// lane.h - eight floats at a time, by the vector extensions of GCC and clang. A comparison gives a mask: all bits or none.
#ifndef RADIOSITY_LANE_H
#define RADIOSITY_LANE_H

#include <stdint.h>

enum { LANES = 8 };
typedef float Lane __attribute__((vector_size(32)));
typedef int32_t LaneInt __attribute__((vector_size(32)));

static inline Lane lane_of(float a) { return a - (Lane){0}; }
static inline LaneInt lane_int_of(int32_t a) { return a - (LaneInt){0}; }

static inline LaneInt lane_bits(Lane a) { return (LaneInt)a; }
static inline Lane lane_abs(Lane a) { return (Lane)(lane_bits(a) & lane_int_of(0x7fffffff)); }

static inline Lane lane_choose(LaneInt mask, Lane yes, Lane no) {
#ifdef __AVX__
    return __builtin_ia32_blendvps256(no, yes, (Lane)mask);
#else
    return (Lane)((mask & lane_bits(yes)) | (~mask & lane_bits(no)));
#endif
}

static inline LaneInt lane_choose_int(LaneInt mask, LaneInt yes, LaneInt no) {
    return lane_bits(lane_choose(mask, (Lane)yes, (Lane)no));
}

static inline Lane lane_least(Lane a, Lane b) { return lane_choose(a < b, a, b); }

// Bit i: lane i of the mask.
static inline unsigned lane_mask(LaneInt mask) {
#ifdef __AVX__
    return (unsigned)__builtin_ia32_movmskps256((Lane)mask);
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
