// false_colour.h - light as numbers: which quantity, on which scale, in which colour.
#ifndef WALK_FALSE_COLOUR_H
#define WALK_FALSE_COLOUR_H

#include "maps/building/building.h"

typedef enum FalseColour {
    FALSE_COLOUR_OFF,
    FALSE_COLOUR_RADIOSITY,    // light that leaves a surface, W/m^2
    FALSE_COLOUR_IRRADIANCE,   // light that arrives, W/m^2
    FALSE_COLOUR_ILLUMINANCE,  // light that arrives, lux
    FALSE_COLOURS
} FalseColour;
extern const char *const FALSE_COLOUR_NAMES[FALSE_COLOURS];
extern const char *const FALSE_COLOUR_UNITS[FALSE_COLOURS];

// The weight of each channel of light in a quantity.
void false_colour_weights(FalseColour quantity, double out[3]);
// The quantity on a surface with this radiosity. Arriving light is derived from the reflected light: -1 where the material reflects
// nothing in one of the channels.
double false_colour_value(FalseColour quantity, const double radiosity[3], const Material *material);

// A logarithmic scale from low to high, both 1, 2 or 5 times a power of ten.
typedef struct LightRange {
    double low, high;
} LightRange;
// The scale that ends at the first of these numbers not below `most`, and begins a fixed number of powers of ten lower.
LightRange light_range(double most);
double light_range_place(LightRange range, double value);  // 0 at low, 1 at high; may be less or more

// The numbers at a scale's side, 1, 2, 5, 10, ... from low to high. Returns how many.
enum { LIGHT_RANGE_TICKS = 10 };
int light_range_ticks(LightRange range, double out[LIGHT_RANGE_TICKS]);

// The colour at a place of the scale, sRGB 0 .. 1: equal steps look equally far apart, and brighter is more.
Rgb false_colour_at(double place);
// The colour of a deviation, -1 .. 1: blue below 0, near white at 0, red above 0. To the eye, deviations of one size are equally far
// from white on both sides.
Rgb false_colour_signed(double place);

#endif
