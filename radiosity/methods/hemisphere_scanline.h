// hemisphere_scanline.h - the parts of the scan-line method: crossings of edges with lines, what is visible along a
// line, and the elements along a visible span.
//
// A line is y = const on the hemisphere's base, x the place along it, z = sqrt(1 - x^2 - y^2) the height above it. Of the
// lines the other way x and y have changed places in all that is given here. Of whatever plane through the eye, with
// normal e, the line crosses it where ex x + ey y + ez z = 0.
#ifndef RADIOSITY_HEMISPHERE_SCANLINE_H
#define RADIOSITY_HEMISPHERE_SCANLINE_H

#include "radiosity/factors/row.h"

typedef struct ScanLine {
    double y, radius2, radius;  // radius: of the half-circle above the line
    double weight;              // of a unit of length
} ScanLine;

// Lines over the disc: line k is at y = -1 + 2 (k + offset) / count, or, even in angle, at y = -cos(pi (k + offset) / count).
typedef struct ScanLattice {
    int count;
    double offset;
    bool by_angle;
    ScanLine *line;  // [count]
} ScanLattice;

typedef struct Scanner Scanner;
// For lattices of so many lines at most.
Scanner *scanner_new(const Mesh *mesh, int most_lines, Arena *arena);
// Takes a view, to be looked at along lines.
void scanner_look(Scanner *self, const View *view);
// Adds what is seen along all lines of a lattice; `across`: along those the other way.
void scanner_see(Scanner *self, const ScanLattice *lattice, bool across, RowSum *sum, FormFactorWork *work);

#endif
