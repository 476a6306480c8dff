// soup_checks.h - what must hold of any soup.
#ifndef TESTS_SOUP_CHECKS_H
#define TESTS_SOUP_CHECKS_H

#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"
#include "visibility/soup/soup.h"

CellGraph soup_make(Arena *arena, const Building *b);

// The cells that can be reached from one through portals, itself among them.
int soup_reachable(const CellGraph *g, int start, unsigned char *reached);

bool soup_connected(const CellGraph *g, Vec3 a, Vec3 b);

void soup_extent_of(const SoupCell *cell, Plane plane, double *low, double *high);

// Each face lies in its plane, looks inwards, and all corners are on its inner side; together they close.
void soup_expect_polyhedron(const Soup *soup, const SoupCell *cell);

Building *soup_closed_room(Arena *arena, Vec3 size);

#endif
