// false_colour.c - the colour map is a straight line in lightness and hue at one chroma in Oklab (B. Ottosson, A perceptual
// color space for image processing, 2020), from dark violet by blue and green to pale yellow.
#include "engine/lit/false_colour.h"

#include <math.h>
#include <stdlib.h>

// The powers of ten that a scale spans.
static const int DECADES = 3;
// In Oklab: the ends of the line, and a chroma that sRGB has for all hues and lightnesses on it.
static const double DARK = 0.24, LIGHT = 0.95, CHROMA = 0.092;
static const double HUE_DARK = 300 * M_PI / 180, HUE_LIGHT = 105 * M_PI / 180;

// Deviations: lightness and chroma at both ends, which sRGB has for both hues, blue and red.
static const double ENDS = 0.5, CHROMA_ENDS = 0.16;
static const double HUE_BELOW = 260 * M_PI / 180, HUE_ABOVE = 27 * M_PI / 180;

const char *const FALSE_COLOUR_NAMES[FALSE_COLOURS] = {"off", "radiosity", "irradiance", "illuminance"};
const char *const FALSE_COLOUR_UNITS[FALSE_COLOURS] = {"", "W/m\u00b2", "W/m\u00b2", "lux"};

void false_colour_weights(FalseColour quantity, double out[3]) {
    const double share[3] = {LIGHT_LUMINOUS};
    for (int c = 0; c < 3; c++)
        out[c] = quantity == FALSE_COLOUR_ILLUMINANCE ? LIGHT_LUMENS_PER_WATT * share[c] : 1;
}

double false_colour_value(FalseColour quantity, const double radiosity[3], const Material *material) {
    const double rho[3] = {(double)material->reflectance.r, (double)material->reflectance.g,
                           (double)material->reflectance.b};
    const double emitted[3] = {(double)material->emission.r, (double)material->emission.g,
                               (double)material->emission.b};
    double weights[3], sum = 0;
    false_colour_weights(quantity, weights);
    for (int c = 0; c < 3; c++) {
        bool arriving = quantity != FALSE_COLOUR_RADIOSITY;
        if (arriving && !(rho[c] > 0)) return -1;
        sum += weights[c] * (arriving ? fmax(radiosity[c] - emitted[c], 0) / rho[c] : radiosity[c]);
    }
    return sum;
}

// The n-th number from 1 (n = 0) in the series 1, 2 or 5 times a power of ten.
static double round_number(int n) {
    static const double STEPS[] = {1, 2, 5};
    int decade = n >= 0 ? n / 3 : -((2 - n) / 3);
    double power = pow(10, abs(decade)), step = STEPS[n - 3 * decade];
    return decade >= 0 ? step * power : step / power;
}

LightRange light_range(double most) {
    if (!(most > 0)) most = 1;
    int n = (int)floor(3 * log10(most)) - 1;
    while (round_number(n) < most) n++;
    return (LightRange){round_number(n - 3 * DECADES), round_number(n)};
}

double light_range_place(LightRange range, double value) {
    return log(value / range.low) / log(range.high / range.low);
}

int light_range_ticks(LightRange range, double out[LIGHT_RANGE_TICKS]) {
    int n = (int)floor(3 * log10(range.low)) - 1, count = 0;
    while (round_number(n) < range.low) n++;
    for (; count < LIGHT_RANGE_TICKS && round_number(n) <= range.high; n++) out[count++] = round_number(n);
    return count;
}

static float to_screen(double x) {
    x = fmin(fmax(x, 0), 1);
    return (float)(x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055);
}

// A colour of Oklab, as sRGB.
static Rgb colour_of(double lightness, double chroma, double hue) {
    double a = chroma * cos(hue), b = chroma * sin(hue);
    double l = lightness + 0.3963377774 * a + 0.2158037573 * b,
           m = lightness - 0.1055613458 * a - 0.0638541728 * b,
           s = lightness - 0.0894841775 * a - 1.2914855480 * b;
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    return (Rgb){to_screen(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
                 to_screen(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
                 to_screen(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

Rgb false_colour_at(double place) {
    double t = fmin(fmax(place, 0), 1);
    return colour_of(DARK + t * (LIGHT - DARK), CHROMA, HUE_DARK + t * (HUE_LIGHT - HUE_DARK));
}

Rgb false_colour_signed(double place) {
    double t = fmin(fmax(place, -1), 1);
    return colour_of(LIGHT - fabs(t) * (LIGHT - ENDS), CHROMA_ENDS * fabs(t), t < 0 ? HUE_BELOW : HUE_ABOVE);
}
