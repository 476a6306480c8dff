// sets.h - disjoint sets of numbers, united two by two (union-find; B. A. Galler & M. J. Fischer 1964, halving paths).
//
// Initially parent[i] is i for every number. A set is identified by its leader, the number that is its own parent.
#ifndef CORE_SETS_H
#define CORE_SETS_H

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
