// draft_fixture.h - plans drawn in memory, and what is asked of the free space found in them.
#ifndef TESTS_DRAFT_FIXTURE_H
#define TESTS_DRAFT_FIXTURE_H

#include "engine/core/random.h"
#include "maps/building/sketch.h"
#include "maps/maps.h"

static const double DRAFT_WALL = 0.2, DRAFT_HEIGHT = 2.5;  // metres

typedef struct Draft {
    Arena arena;
    Building b;
    Sketch s;
    double turn;  // radians, about the origin, then shifted
    Vec2 shift;
} Draft;

// So many storeys of DRAFT_HEIGHT, empty yet.
Draft draft_new(int storeys);
int draft_points(Draft *d, const Vec2 *p, int count, bool in_plan);
void draft_wall_shape(Draft *d, int storey, const Vec2 *p, int count, double angle, double height);
void draft_wall(Draft *d, int storey, double x0, double y0, double x1, double y1, double thickness,
                double height);
// Four walls around the inside x0 .. x1, y0 .. y1, overlapping at the corners.
void draft_box_walls(Draft *d, int storey, double x0, double y0, double x1, double y1);
void draft_room_shape(Draft *d, int storey, const Vec2 *p, int count);
void draft_room(Draft *d, int storey, double x0, double y0, double x1, double y1);
SketchOpening *draft_opening(Draft *d, OpeningKind kind, int storey, double x, double y, double angle,
                             double width, double depth);
void draft_cutout(Draft *d, int storey, double x0, double y0, double x1, double y1);
// Walls, rooms, openings and cut-outs anywhere: half of the coordinates lie on a coarse raster, so that things touch, coincide and
// cross at their ends.
void draft_random_storey(Draft *d, Random *r, int storey, bool openings);
// No fault by building_check.
void draft_expect_sound(Draft *d, const char *what);
// Finds the free space; the test fails where the building is not sound then.
void draft_enclose(Draft *d);
void draft_free(Draft *d);
int draft_count_kind(const Draft *d, RegionKind kind);
int draft_count_notes(const Draft *d, int kind);
// Does the opening lead from a region of one kind to one of the other?
bool draft_joins(const Draft *d, int opening, RegionKind a, RegionKind b);
double draft_region_area(const Building *b, const Region *r);
double draft_area_of(const Draft *d, RegionKind kind);
// How many regions hold a point; the last of them in `which`.
int draft_regions_at(const Draft *d, double x, double y, double z, int *which);
// The kind of the one region that holds a point, or -1.
int draft_kind_at(const Draft *d, double x, double y, double z);

#endif
