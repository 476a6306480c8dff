// building_check.h - the faults found so far, and tests of numbers and indices, for both files of the check.
#ifndef MAPS_BUILDING_CHECK_H
#define MAPS_BUILDING_CHECK_H

#include <stdarg.h>

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

// Adds a fault; the sentence is formatted as by printf.
__attribute__((format(printf, 2, 3))) static inline void check_fault(Check *c, const char *format, ...) {
    if (c->count++ >= c->max) return;
    va_list args;
    va_start(args, format);
    c->faults[c->count - 1] = arena_format_list(c->arena, format, args);
    va_end(args);
}

static inline bool good(double x) { return isfinite(x) && fabs(x) <= MAPS_LIMIT; }
static inline bool good3(Vec3 p) { return good(p.x) && good(p.y) && good(p.z); }
static inline bool index_good(int i, int count) { return i >= 0 && i < count; }
static inline bool run_good(int first, int count, int total) {
    return first >= 0 && count >= 0 && first <= total - count;
}
static inline const char *text_of(const char *name) { return name && *name ? name : "unnamed"; }

// building_check_regions.c
void check_regions(Check *c);

#endif
