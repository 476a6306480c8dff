// sky_parts.h - the sky as it is seen from a place, in parts: its light is known under any sun, without another look.
#ifndef RADIOSITY_SKY_PARTS_H
#define RADIOSITY_SKY_PARTS_H

#include <stdint.h>

#include "engine/core/arena.h"
#include "radiosity/daylight/daylight.h"

// A part of the sky, about 4 degrees across, or 7 where more than a tenth of a view is sky: the share of the view that it fills, less
// what panes of glass keep, and x and y of its middle, a unit vector that points up.
typedef struct SkyPart {
    float share;
    int16_t x, y;  // times SKY_PART_ONE
} SkyPart;
enum { SKY_PARTS_ACROSS = 40, SKY_PARTS_MOST = SKY_PARTS_ACROSS * SKY_PARTS_ACROSS, SKY_PART_ONE = 32767 };

// The cell of a unit direction that points up, 0 .. SKY_PARTS_MOST - 1: a square of an octahedral map (Cigolle et al. 2014).
int sky_part_cell(Vec3 direction);
// A part from the sum of unit directions, each times its share.
SkyPart sky_part_of(double share, Vec3 sum);
// The radiance of the sky at the middle of a part over that overhead.
double sky_part_relative(const SkyPart *part, const Daylight *day);
// The sum over parts of the share times that radiance.
double sky_parts_light(const SkyPart *parts, int count, const Daylight *day);
// Scales the shares so that this sum is `light` under the day, as directions one by one tell it.
void sky_parts_fit(SkyPart *parts, int count, const Daylight *day, double light);

// Collects the parts of one view after the other. Lives in the arena.
typedef struct SkyCollector SkyCollector;
SkyCollector *sky_collector_new(Arena *arena);
// Adds a share of the view along a unit direction that points up.
void sky_collector_add(SkyCollector *collector, double share, Vec3 direction);
// Stores the parts in `out` [SKY_PARTS_MOST], returns how many there are, and begins anew.
int sky_collector_take(SkyCollector *collector, SkyPart *out);

#endif
