// daylight.c - irradiances of sun and sky from the sun's altitude and the weather, and the sky's radiance by direction (README.md).
//
// Sources: C. Rigollier, O. Bauer & L. Wald, On the clear sky model of the ESRA, Solar Energy 68, 2000, equations 3 to 6, 13 to 17;
// F. Kasten, The Linke turbidity factor based on improved values of the integral Rayleigh optical thickness, 1996; F. Kasten & A. T. Young,
// Revised optical air mass tables, 1989; F. Kasten & G. Czeplak, Solar and terrestrial radiation dependent on the amount and type of cloud,
// 1980; ISO 15469:2004, Spatial distribution of daylight - CIE standard general sky.
#include "radiosity/daylight/daylight.h"

#include <string.h>

const char *const DAYLIGHT_WEATHER_NAMES[DAYLIGHT_WEATHERS] = {"clear", "intermediate", "overcast"};

// A weather: parameters a .. e of the CIE's table, and the share of the sky that clouds cover.
static const struct {
    double cie[5], cover;
} WEATHERS[DAYLIGHT_WEATHERS] = {
    [DAYLIGHT_CLEAR] = {{-1, -0.32, 10, -3, 0.45}, 0},
    [DAYLIGHT_INTERMEDIATE] = {{0, -1, 5, -2.5, 0.30}, 0.5},
    [DAYLIGHT_OVERCAST] = {{4, -0.70, 0, -1, 0}, 1},
};
static const double UNIFORM[5] = {0, -1, 0, -1, 0};

static const double DEGREE = M_PI / 180;
// Irradiance outside the air at the mean distance of the sun, W/m^2, of the ESRA.
static const double SOLAR_CONSTANT = 1367;
// Linke turbidity at an air mass of 2: clear air in the middle latitudes.
static const double TURBIDITY = 3;
// In civil twilight the light of the sky falls from 400 lx at 0 degrees to 3.4 lx at the end: by e every so many radians.
static const double TWILIGHT_FALL = 1.26 * (M_PI / 180);
static const double TWILIGHT_END = -6 * (M_PI / 180);
// Wavelengths of the channels r, g, b: the middles of their bands, micrometres.
static const double WAVELENGTH[3] = {0.61, 0.55, 0.465};
// The light of a whole cloudless sky: CIE daylight of 10,000 K, as measured skies are (Judd, MacAdam & Wyszecki 1964), in linear sRGB.
// That of Rayleigh's scattering at three wavelengths, mixed with white, is nearly the same with less green: skies look like lavender.
static const double CLEAR_SKY[3] = {0.7634, 0.9369, 1.2997};

// ---- irradiances, W/m^2, all channels together

// Kasten & Young 1989.
static double air_mass(double altitude) {
    double degrees = fmax(altitude / DEGREE, 0);
    return 1 / (sin(degrees * DEGREE) + 0.50572 * pow(degrees + 6.07995, -1.6364));
}

// Across the beam; Rayleigh's optical thickness by Kasten 1996.
static double clear_beam(double altitude, double outside) {
    if (altitude <= 0) return 0;
    double m = air_mass(altitude), thickness = 10.4 + 0.718 * m;
    if (m <= 20) thickness = 6.6296 + m * (1.7513 + m * (-0.1202 + m * (0.0065 - m * 0.00013)));
    return outside * exp(-0.8662 * TURBIDITY * m / thickness);
}

// On level ground.
static double clear_diffuse(double altitude, double outside) {
    const double t = TURBIDITY;
    double zenith = -0.015843 + t * (0.030543 + t * 0.0003797);  // transmission straight down
    double a0 = 0.26463 + t * (-0.061581 + t * 0.0031408), a1 = 2.0402 + t * (0.018945 - t * 0.011161),
           a2 = -1.3025 + t * (0.039231 + t * 0.0085079), s = sin(fmax(altitude, 0));
    if (a0 * zenith < 0.002) a0 = 0.002 / zenith;
    double day = outside * zenith * (a0 + s * (a1 + s * a2));
    if (altitude >= 0) return day;
    return altitude < TWILIGHT_END ? 0 : day * exp(altitude / TWILIGHT_FALL);
}

// ---- colours: three factors with a mean of 1

static void keep_mean(double colour[3]) {
    double sum = colour[0] + colour[1] + colour[2];
    for (int c = 0; c < 3; c++) colour[c] *= 3 / sum;
}

// Rayleigh's optical depth of the air straight up (Leckner 1978).
static double depth_of_air(int channel) { return 0.008735 * pow(WAVELENGTH[channel], -4.08); }

static void colour_of_sun(double altitude, double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = exp(-depth_of_air(c) * air_mass(altitude));
    keep_mean(out);
}

static void colour_of_sky(double cover, double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = (1 - cover) * CLEAR_SKY[c] + cover;
}

// ---- the radiance by direction

// The gradation from zenith to horizon, at the cosine of an angle from the zenith.
static double gradation(const double cie[5], double cosine) { return 1 + cie[0] * exp(cie[1] / cosine); }

// The indicatrix at the cosine of an angle from the sun.
static double indicatrix(const double cie[5], double cosine) {
    double angle = acos(fmin(fmax(cosine, -1), 1));
    return 1 + cie[2] * (exp(cie[3] * angle) - exp(cie[3] * M_PI / 2)) + cie[4] * cosine * cosine;
}

double daylight_overhead(const Daylight *day) {
    return indicatrix(day->cie, day->sun.z) * gradation(day->cie, 1);
}

double daylight_relative(const Daylight *day, Vec3 w) {
    return indicatrix(day->cie, vec3_dot(w, day->sun)) * gradation(day->cie, w.z) / daylight_overhead(day);
}

// The mean over directions with the density of the cosine: rings of equal share, so that the middles of a grid's cells count alike. The
// error is below 1e-4: the sky about the sun is the part that changes most.
static double mean_of(const Daylight *day) {
    enum { RINGS = 128, AROUND = 256 };
    double sum = 0;
    for (int i = 0; i < RINGS; i++) {
        double across = sqrt((i + 0.5) / RINGS), up = sqrt(1 - (i + 0.5) / RINGS);
        for (int k = 0; k < AROUND; k++) {
            double angle = 2 * M_PI * (k + 0.5) / AROUND;
            sum += daylight_relative(day, vec3(across * cos(angle), across * sin(angle), up));
        }
    }
    return sum / (RINGS * AROUND);
}

// ---- days

Daylight daylight_uniform(const double radiance[3]) {
    Daylight day = {.sun = {0, 0, 1}, .mean = 1};
    memcpy(day.zenith, radiance, sizeof day.zenith);
    memcpy(day.cie, UNIFORM, sizeof day.cie);
    return day;
}

Daylight daylight_of(const SunPosition *sun, double north, int weather) {
    Daylight day = {.sun = sun_direction(sun, north), .ground = DAYLIGHT_GROUND};
    double cover = WEATHERS[weather].cover, outside = SOLAR_CONSTANT / (sun->distance * sun->distance);
    double beam = clear_beam(sun->altitude, outside), diffuse = clear_diffuse(sun->altitude, outside);
    double level = fmax(day.sun.z, 0), yellow[3], blue[3];
    // Kasten & Czeplak: clouds let this share of the light of a clear sky through. The sun shines between them.
    double global = (diffuse + beam * level) * (1 - 0.75 * pow(cover, 3.4));
    beam *= 1 - cover;
    diffuse = global - beam * level;
    memcpy(day.cie, WEATHERS[weather].cie, sizeof day.cie);
    day.mean = mean_of(&day);
    colour_of_sun(sun->altitude, yellow);
    colour_of_sky(cover, blue);
    for (int c = 0; c < 3; c++) {
        day.beam[c] = beam * yellow[c] / 3;
        day.zenith[c] = diffuse * blue[c] / 3 / (M_PI * day.mean);
    }
    return day;
}

// The weather with the day's sky; DAYLIGHT_WEATHERS: none.
static int weather_of(const Daylight *day) {
    int w = 0;
    while (w < DAYLIGHT_WEATHERS && memcmp(day->cie, WEATHERS[w].cie, sizeof day->cie) != 0) w++;
    return w;
}

const char *daylight_weather_name(const Daylight *day) {
    int w = weather_of(day);
    return w < DAYLIGHT_WEATHERS ? DAYLIGHT_WEATHER_NAMES[w] : "uniform";
}

bool daylight_shines(const Daylight *day) {
    for (int c = 0; c < 3; c++)
        if (day->beam[c] > 0 || day->zenith[c] > 0) return true;
    return false;
}

bool daylight_is_sound(const Daylight *day) {
    bool good = day->mean >= 0 && isfinite(day->mean) && day->ground >= 0 && day->ground <= 1 &&
                fabs(vec3_dot(day->sun, day->sun) - (daylight_shines(day) ? 1 : 0)) < 1e-6;
    bool known = daylight_is_uniform(day) || !daylight_shines(day);
    for (int c = 0; c < 3; c++)
        good = good && day->beam[c] >= 0 && isfinite(day->beam[c]) && day->zenith[c] >= 0 &&
               isfinite(day->zenith[c]);
    return good && (known || weather_of(day) < DAYLIGHT_WEATHERS);
}

bool daylight_is_uniform(const Daylight *day) {
    return day->cie[0] == 0 && day->cie[2] == 0 && day->cie[4] == 0 && day->ground == 0 &&
           day->beam[0] + day->beam[1] + day->beam[2] == 0;
}

void daylight_mean(const Daylight *day, double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = day->zenith[c] * day->mean;
}

void daylight_horizontal(const Daylight *day, double out[3]) {
    for (int c = 0; c < 3; c++)
        out[c] = M_PI * day->zenith[c] * day->mean + day->beam[c] * fmax(day->sun.z, 0);
}

void daylight_below(const Daylight *day, double out[3]) {
    daylight_horizontal(day, out);
    for (int c = 0; c < 3; c++) out[c] *= day->ground / M_PI;
}

void daylight_radiance(const Daylight *day, Vec3 direction, double out[3]) {
    if (!(direction.z > 0)) {
        daylight_below(day, out);
        return;
    }
    double relative = daylight_relative(day, direction);
    for (int c = 0; c < 3; c++) out[c] = day->zenith[c] * relative;
}

// The colour of grass and soil: three factors with a mean of 1. The light that the ground sends to walls stays white.
static const double GRASS[3] = {0.96, 1.30, 0.74};

void daylight_seen_ground(const Daylight *day, double out[3]) {
    daylight_below(day, out);
    if (daylight_is_uniform(day)) {
        daylight_mean(day, out);
        for (int c = 0; c < 3; c++) out[c] *= DAYLIGHT_GROUND;
    }
    for (int c = 0; c < 3; c++) out[c] *= M_PI * GRASS[c];
}

// Level rays count as if they rose so far: the gradation divides by the height.
static const double LEAST_RISE = 1e-3;

void daylight_seen(const Daylight *day, Vec3 w, double out[3]) {
    Vec3 up = vec3_normalize(vec3(w.x, w.y, fmax(w.z, LEAST_RISE)));
    double ground[3], sine = DAYLIGHT_SUN_RADIUS;
    double t = fmin(fmax(1 + w.z / DAYLIGHT_HAZE, 0), 1), above = t * t * (3 - 2 * t);
    daylight_radiance(day, up, out);
    daylight_seen_ground(day, ground);
    bool disc = w.z > 0 && vec3_dot(w, day->sun) > cos(DAYLIGHT_SUN_RADIUS);
    for (int c = 0; c < 3; c++) {
        // A disc of half a degree of radiance L sends pi sine^2 L.
        if (disc) out[c] += day->beam[c] / (M_PI * sine * sine);
        out[c] = ground[c] + above * (M_PI * out[c] - ground[c]);
    }
}
