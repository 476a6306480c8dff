// solid_outline.h - what a solid body covers of the plan between two heights.
//
// Used where a file has bodies and a plan needs outlines: spaces and walls that are no upright prisms, floors with holes in them,
// cells of IndoorGML.
#ifndef MAPS_SOLID_OUTLINE_H
#define MAPS_SOLID_OUTLINE_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// A connected part of the plan.
typedef struct SolidOutline {
    Vec2 *points;
    int *
        ring;  // [ring_count + 1] offsets into points: the outer ring, counter-clockwise, then the holes, clockwise
    int ring_count;
    double area;  // metres^2, without the holes
} SolidOutline;

typedef struct SolidOutlines {
    SolidOutline *items;
    int count, capacity;
} SolidOutlines;

// Polygons of bodies, collected for the functions below. One thread uses it.
typedef struct SolidTracer SolidTracer;

// Begins; what it makes lies in `arena`. Ends with solid_end.
SolidTracer *solid_begin(Arena *arena);
void solid_end(SolidTracer *tracer);

// Adds a planar convex polygon of a closed body, counter-clockwise seen from outside.
void solid_add(SolidTracer *tracer, const Vec3 *corners, int count);
// The part of the plan over or under which a point of the body lies between the heights z0 < z1: the sections at both heights, and
// the faces between them. Forgets the polygons. Parts of less than SOLID_LEAST_AREA are left out. A body that is not closed covers
// what its faces cover.
SolidOutlines solid_cover(SolidTracer *tracer, double z0, double z1);

// Boolean operations of plans: the parts of `a` outside all of `b`, narrower parts than `narrowest` left out; all of `a` as one.
SolidOutlines solid_difference(SolidTracer *tracer, const SolidOutlines *a, const SolidOutlines *b,
                               double narrowest);
SolidOutlines solid_union(SolidTracer *tracer, const SolidOutlines *a);
// The area, metres^2, that both have.
double solid_common_area(SolidTracer *tracer, const SolidOutlines *a, const SolidOutlines *b);

// An outline of one ring, either way round, copied.
SolidOutline solid_of_ring(Arena *arena, const Vec2 *points, int count);
// Is a place inside the outline, and in none of its holes?
bool solid_contains(const SolidOutline *outline, Vec2 p);
// The whole outline as one ring, which runs to each hole along a line and back. Returns the number of points in `*out`.
int solid_one_ring(const SolidOutline *outline, Arena *arena, Vec2 **out);

// Metres^2: a square of 1 cm.
#define SOLID_LEAST_AREA 1e-4

#endif
