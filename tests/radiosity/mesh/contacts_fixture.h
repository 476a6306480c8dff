// contacts_fixture.h - rooms in which boxes stand, and the elements of their floors.
#ifndef TESTS_CONTACTS_FIXTURE_H
#define TESTS_CONTACTS_FIXTURE_H

#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

typedef struct Rectangle {
    double x0, y0, x1, y1;
} Rectangle;

// 4 x 3 x 2.5 m, the floor its fifth face, with a lamp.
Lit *contacts_room(void);

int contacts_the_floor(const Lit *lit);

void contacts_finish(Lit *lit, double element, int per_patch, const MeshSplits *splits);

Vec3 contacts_middle_of(const Mesh *mesh, const Element *e);

bool contacts_in_rectangle(const Rectangle *r, Vec3 p, double by);

double contacts_area_of(const Mesh *mesh, int face);

// Corners, and the middles of edges, of an element, told apart by an outline: 1 all inside, 0 all outside, -1 both.
int contacts_side_of(const Mesh *mesh, const Element *e, const Rectangle *r);

// Emitted = absorbed + escaped + unshot, and the same light culled and not; returns it.
RadSolution contacts_check_light(Lit *lit);

#endif
