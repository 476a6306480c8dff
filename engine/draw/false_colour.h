// false_colour.h - light as numbers: which quantity, on which scale, in which colour.
#ifndef WALK_FALSE_COLOUR_H
#define WALK_FALSE_COLOUR_H

#include "maps/building/building.h"

// The one rule by which three channels become one number. Of power, W/m^2, it is their sum. Of what the eye makes of it, it
// is the share that each has in luminance (ITU-R BT.709), at 683 lm/W (the definition of the candela).
#define LIGHT_LUMINOUS 0.2126, 0.7152, 0.0722
#define LIGHT_LUMENS_PER_WATT 683.0
static inline double light_luminous(const double w[3]) {
    const double share[3] = {LIGHT_LUMINOUS};
    return share[0] * w[0] + share[1] * w[1] + share[2] * w[2];
}

typedef enum FalseColour {
    FALSE_COLOUR_OFF,
    FALSE_COLOUR_RADIOSITY,    // what leaves a surface, W/m^2
    FALSE_COLOUR_IRRADIANCE,   // what arrives, W/m^2
    FALSE_COLOUR_ILLUMINANCE,  // what arrives, lux
    FALSE_COLOURS
} FalseColour;
extern const char *const FALSE_COLOUR_NAMES[FALSE_COLOURS];
extern const char *const FALSE_COLOUR_UNITS[FALSE_COLOURS];

// The weight of each channel of light in a quantity.
void false_colour_weights(FalseColour quantity, double out[3]);
// The quantity of a surface with this radiosity. Arriving light is known by the reflected part: -1 where none is, in any channel.
double false_colour_value(FalseColour quantity, const double radiosity[3], const Material *material);

// A logarithmic scale from low to high, both 1, 2 or 5 times a power of ten.
typedef struct LightRange {
    double low, high;
} LightRange;
// So many powers of ten below the first such number that is not below `most`.
LightRange light_range(double most);
double light_range_place(LightRange range, double value);  // 0 at low, 1 at high, beyond them less and more

// The numbers at a scale's side, 1, 2, 5, 10, ... from low to high. Returns how many.
enum { LIGHT_RANGE_TICKS = 10 };
int light_range_ticks(LightRange range, double out[LIGHT_RANGE_TICKS]);

// The colour at a place of the scale, sRGB 0 .. 1: equal steps look equally far apart, and brighter is more.
Rgb false_colour_at(double place);
// The colour of a number that may be too little or too much, -1 .. 1: blue, near white at 0, red; as far from white to the eye on
// both sides.
Rgb false_colour_signed(double place);

#endif
