// soup_scenes.h - what must hold of any soup.
#ifndef TESTS_SOUP_SCENES_H
#define TESTS_SOUP_SCENES_H

#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

double soup_largest_extent(const CellGraph *g);

// Every portal is convex, lies in a face of both its cells, within both, and looks at the first of them.
// Tolerance: what is snapped to a plane, 1e-6 of the size.
void soup_check_portals(const CellGraph *g);

void soup_check_soup(const CellGraph *g, const Building *b, uint64_t seed, int lines);

#endif
