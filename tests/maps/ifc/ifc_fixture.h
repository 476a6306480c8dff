// ifc_fixture.h - small building models as text around one body.
#ifndef TESTS_IFC_FIXTURE_H
#define TESTS_IFC_FIXTURE_H

#include "maps/ifc/ifc.h"

// A file of one product #90 in metres and radians, whose body is the item #100; `data` are statements that make #100, from #100 on.
// Statements of use: #10 the point 0, #11 the axes at 0, #12 and #13 directions along z and x, #14 the flat axes at 0.
const char *ifc_text(Arena *arena, const char *data);
// Reads text on some threads; fails the running test where it is refused.
void ifc_accept(Arena *arena, const char *text, int threads, IfcModel *out);
// Fails the running test unless the text is refused with these words in the sentence.
void ifc_refuse(const char *text, const char *expected);
// The first product's mesh, of `data` as above, with 256 chords a circle.
IfcMesh ifc_mesh(Arena *arena, const char *data);
double ifc_volume(const IfcMesh *mesh);
double ifc_area(const IfcMesh *mesh);
// How far the sum of the faces' normals, by area, is from 0, of all area: 0 where a body is closed.
double ifc_gap(const IfcMesh *mesh);

#endif
