// sets.h - disjoint sets of numbers, united two by two (union-find; B. A. Galler & M. J. Fischer 1964, halving paths).
//
// parent[i] of every number is i itself at first. A set goes by the number that leads it: its parent is itself.
#ifndef CORE_SETS_H
#define CORE_SETS_H

// The number that leads the set of i.
static inline int set_find(int *parent, int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

// The set of `other` joins that of `leader`, whose leader leads both.
static inline void set_join(int *parent, int leader, int other) {
    parent[set_find(parent, other)] = set_find(parent, leader);
}

// Unites two sets; the lower of their leaders leads both, so that a set goes by its lowest number.
static inline void set_unite(int *parent, int a, int b) {
    a = set_find(parent, a);
    b = set_find(parent, b);
    parent[a > b ? a : b] = a < b ? a : b;
}

#endif
