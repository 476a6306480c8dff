// curved_fixture.h - buildings with curved shapes for tests, and what is asked of their polygons.
#ifndef TESTS_CURVED_FIXTURE_H
#define TESTS_CURVED_FIXTURE_H

#include "maps/curved/curved_tessellate.h"

// Reads a room of 8 x 4 m with a model of these lines placed in it, behind `words` (`2,2 angle 30`). False, and the error, where
// they are refused.
bool curved_try_model(Arena *arena, const char *lines, const char *words, Building *b, Error *error);
void curved_read_model(Arena *arena, const char *lines, const char *words, Building *b);  // must read

// All polygons of the building's shapes at a tolerance; 0: those it holds.
CurvedMesh curved_all(const Building *b, double tolerance, Arena *arena);

// Edges that no neighbour has the other way round: how many; and where, `ends` [2 * count].
int curved_find_open(const CurvedMesh *mesh, Arena *arena, Vec3 **ends);
int curved_open_edges(const CurvedMesh *mesh, Arena *arena);
double curved_area(const CurvedMesh *mesh);
double curved_volume(const CurvedMesh *mesh);  // of closed ones, by the divergence theorem

#endif
