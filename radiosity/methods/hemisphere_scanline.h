// hemisphere_scanline.h - the parts of the scan-line method: crossings of edges with lines, what is visible along a
// line, and the elements along a visible span.
//
// A line is y = const on the hemisphere's base, x the place along it, z = sqrt(1 - x^2 - y^2) the height above it. Of the
// lines the other way x and y have changed places in all that is given here. Of whatever plane through the eye, with
// normal e, the line crosses it where ex x + ey y + ez z = 0.
#ifndef RADIOSITY_HEMISPHERE_SCANLINE_H
#define RADIOSITY_HEMISPHERE_SCANLINE_H

#include "radiosity/factors/face_grid.h"
#include "radiosity/factors/row.h"

// A corner of a face above the horizon.
typedef struct ScanCorner {
    Vec3 at;
    double inverse;  // 1 / distance
    int line;        // the first at or above it
} ScanCorner;

// A piece of an edge's great circle along which y only grows or only falls: it is at x = ay + bs, z = cy + es, where
// s = sqrt(h2 - e2 y^2), for lines first .. end - 1.
typedef struct ScanArc {
    double a, b, c, e, h2, e2;
    int first, end;
} ScanArc;

typedef struct ScanPoint {
    double x, z;
} ScanPoint;

// A stretch of a line where a face is. Faces by their index in ScanFaces.
typedef struct ScanSpan {
    ScanPoint from, to;
    int face;
} ScanSpan;

// One coordinate of a face's grid along direction w: dot(g, w) / dot(inverse, w) + offset.
typedef struct ScanAxis {
    Vec3 g;
    double offset;
    int count;
    Vec3 across;      // g x inverse: the way the grid's lines run
    double vanishes;  // y^2 where their vanishing point is
} ScanAxis;
ScanAxis scan_axis(Vec3 g, double offset, int count, Vec3 inverse);

typedef struct ScanFace {
    Vec3 inverse;  // 1 / distance along direction w is dot(inverse, w)
    int face;      // ViewFace.face
    int rank;      // form_factor_rank
    int first_arc, arc_count, first_line, end_line;
    bool back, has_grid;
    FaceGrid grid;     // once asked for
    ScanAxis axis[2];  // likewise
} ScanFace;

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

// The first line at or above y: 0 .. count.
static inline int scan_line_above(double y, const ScanLattice *lattice) {
    double at = (y + 1) * 0.5;
    if (lattice->by_angle) at = acos(y > -1 ? y < 1 ? -y : -1 : 1) / M_PI;
    double k = ceil(at * lattice->count - lattice->offset);
    return k < 0 ? 0 : k > lattice->count ? lattice->count : (int)k;
}
// Appends the arcs of the edge between two corners. Returns how many, up to 2.
int scan_arcs_of_edge(const ScanCorner *from, const ScanCorner *to, const ScanLattice *lattice, ScanArc *out);

// Where alpha x + gamma z + t = 0 strictly between two points of a line: up to 2, increasing in x.
int scan_roots(double alpha, double gamma, double t, const ScanLine *line, ScanPoint from, ScanPoint to,
               ScanPoint root[2]);

// The visible spans of a line, as a list in x.
typedef struct ScanList {
    ScanSpan *span;  // [capacity]
    int *next;       // [capacity] -1: last
    int first, count, capacity;
    int free;  // spans no longer used, -1: none
    long long tests;
} ScanList;
// Adds a span where it is nearer than what is there.
void scan_list_add(ScanList *list, const ScanFace *faces, const ScanLine *line, const ScanSpan *span);

// Adds the elements along a span of a face to the sum. Returns how many pieces.
int scan_elements(const ScanFace *face, const ScanLine *line, const ScanSpan *span, RowSum *sum);

// ---- all lines of a lattice

typedef struct Scanner Scanner;
// For lattices of so many lines at most.
Scanner *scanner_new(const Mesh *mesh, int most_lines, Arena *arena);
// Takes a view, to be looked at along lines.
void scanner_look(Scanner *self, const View *view);
// Adds what is seen along all lines of a lattice; `across`: along those the other way.
void scanner_see(Scanner *self, const ScanLattice *lattice, bool across, RowSum *sum, FormFactorWork *work);

#endif
