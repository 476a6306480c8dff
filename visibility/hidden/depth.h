// depth.h - which of two depths is the nearer one: the same for all methods.
#ifndef VISIBILITY_DEPTH_H
#define VISIBILITY_DEPTH_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// Depths that differ by less than this share of themselves may count as equal.
#define DEPTH_TIE 1e-9

// 1/z (above 0) as a whole number that grows with it, of the first 32 bits after its leading one: steps of 1.2e-10 to 2.3e-10
// of it, so that surfaces equal but for the last bits of a double are equal here, and DEPTH_TIE is kept. A total order
// together with the place in the list.
static inline int64_t depth_key(double inverse) {
    int64_t bits;
    memcpy(&bits, &inverse, sizeof bits);
    return (bits + (1 << 19)) >> 20;
}

// Is a the nearer one, of depths 1/z and places in the list?
static inline bool depth_nearer(double a, int order_a, double b, int order_b) {
    if (a > b * (1 + DEPTH_TIE)) return true;
    if (a < b * (1 - DEPTH_TIE)) return false;
    int64_t key_a = depth_key(a), key_b = depth_key(b);
    return key_a != key_b ? key_a > key_b : order_a < order_b;
}

#endif
