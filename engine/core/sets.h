// sets.h - sets of numbers.
#ifndef CORE_SETS_H
#define CORE_SETS_H

#include <stdbool.h>

#include "engine/core/arena.h"

// ---- a set of numbers below some limit, in the order in which they came

typedef struct Marks {
    bool *has;  // [limit]
    int *of;    // [count]
    int count;
} Marks;

// An empty set of numbers from 0 to limit - 1; it lives in the arena.
static inline Marks marks_new(int limit, Arena *arena) {
    return (Marks){ARENA_ARRAY(arena, bool, limit + 1), ARENA_ARRAY(arena, int, limit + 1), 0};
}

// A number that is there already stays where it is.
static inline void marks_add(Marks *marks, int i) {
    if (marks->has[i]) return;
    marks->has[i] = true;
    marks->of[marks->count++] = i;
}

// In a time that grows with the numbers that it has.
static inline void marks_clear(Marks *marks) {
    for (int i = 0; i < marks->count; i++) marks->has[marks->of[i]] = false;
    marks->count = 0;
}

// ---- disjoint sets, united two by two (union-find; B. A. Galler & M. J. Fischer 1964, halving paths)
//
// Initially parent[i] is i for every number. A set is identified by its leader, the number that is its own parent.

// The leader of the set of i.
static inline int set_find(int *parent, int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

// Joins the set of `other` to the set of `leader`; the leader of the latter leads both.
static inline void set_join(int *parent, int leader, int other) {
    parent[set_find(parent, other)] = set_find(parent, leader);
}

// Unites two sets; the lower of their leaders leads both, so that a set is identified by its lowest number.
static inline void set_unite(int *parent, int a, int b) {
    a = set_find(parent, a);
    b = set_find(parent, b);
    parent[a > b ? a : b] = a < b ? a : b;
}

#endif
