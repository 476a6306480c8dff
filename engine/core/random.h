// random.h - reproducible random numbers: the same seed gives the same numbers on every machine.
#ifndef CORE_RANDOM_H
#define CORE_RANDOM_H

#include <stdint.h>

typedef struct Random {
    uint64_t state;
} Random;

// SplitMix64 (Steele, Lea & Flood 2014): any seed will do.
static inline uint64_t random_next(Random *random) {
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// In [0, 1).
static inline double random_unit(Random *random) { return (double)(random_next(random) >> 11) * 0x1p-53; }
static inline double random_between(Random *random, double low, double high) {
    return low + (high - low) * random_unit(random);
}
// In [0, count).
static inline int random_index(Random *random, int count) { return (int)(random_unit(random) * count); }

#endif
