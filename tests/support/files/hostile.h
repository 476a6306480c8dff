// hostile.h - small files that ask for much: each kind grows with one number, so that cost can be held against size.
#ifndef TESTS_HOSTILE_H
#define TESTS_HOSTILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "engine/core/random.h"

// A family of files. The same `count` and seed give the same bytes.
typedef struct HostileKind {
    const char *name, *suffix;  // of the file, `.plan`
    int count;        // that makes a file of about 100 to 700 kB, or the largest that the format allows
    bool may_refuse;  // with a sentence that names the excess; the others must open
    void (*write)(FILE *file, int count, Random *random);
    // For hostile_cost.c: the smallest of three counts (0: a 160th of `count`), and by how much twice as many things may multiply
    // work at most (0: 2.6; n log n is 2.2 at these sizes). Below 0: what few things cost grows faster, with the pairs that meet or see
    // each other, and limits end it: only full sizes are tried (check_budgets.sh).
    int few;
    double growth;
} HostileKind;

extern const HostileKind HOSTILE_KINDS[];  // ends with a row without a name

// NULL for an unknown name.
const HostileKind *hostile_find(const char *name);

// Writes the file; false with errno.
bool hostile_write(const HostileKind *kind, int count, uint64_t seed, const char *path);

#endif
