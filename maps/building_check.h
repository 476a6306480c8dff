// building_check.h - what the files of the check share.
#ifndef MAPS_BUILDING_CHECK_H
#define MAPS_BUILDING_CHECK_H

#include "engine/core/box_tree.h"
#include "maps/building/building.h"

typedef struct Check {
    const Building *b;
    Arena *arena;
    const char **faults;
    int max, count;
    Vec2 *mm;                 // [point_count] plan points in millimetres, whole ones on the grid
    BoxHits mine, near, row;  // edges found last, in building_check_regions.c
} Check;

void check_fault(Check *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

static inline bool good(double x) { return isfinite(x) && fabs(x) <= MAPS_LIMIT; }
static inline bool good3(Vec3 p) { return good(p.x) && good(p.y) && good(p.z); }
static inline bool index_good(int i, int count) { return i >= 0 && i < count; }
static inline bool run_good(int first, int count, int total) {
    return first >= 0 && count >= 0 && first <= total - count;
}
static inline const char *text_of(const char *name) { return name && *name ? name : "unnamed"; }

// building_check_regions.c
void check_regions(Check *c);
// building_check_curved.c: mirrors and indices of refraction; curved shapes
void check_optics(Check *c);
void check_curved(Check *c);
// building_check_forms.c: what a building of this form may hold, and given portals.
void check_form(Check *c);

#endif
