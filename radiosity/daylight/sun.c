// sun.c - the sun's position by the low-accuracy series of J. Meeus, Astronomical Algorithms, 2nd edition 1998, chapters 7, 12, 13, 16,
// 22 and 25. The equations keep the book's names and degrees.
//
// Departures: terrestrial time counts as universal time, which moves the sun by 0.001 degrees; the air has 1010 hPa and 10 degrees.
#include "radiosity/daylight/sun.h"

static const double DEGREE = M_PI / 180;
// Below this altitude, degrees, the sun is not seen, and the formula of refraction ends.
static const double LEAST_REFRACTED = -1;
// Horizontal parallax of the sun, degrees: 8.794 seconds of arc.
static const double PARALLAX = 8.794 / 3600;

// Chapter 7, Gregorian dates; days.
static double julian_day(int year, int month, int day, double hour) {
    if (month <= 2) year--, month += 12;
    double century = floor(year / 100.0);
    return floor(365.25 * (year + 4716)) + floor(30.6001 * (month + 1)) + day + 2 - century +
           floor(century / 4) - 1524.5 + hour / 24;
}

// Chapter 16, Saemundsson's formula: the lift of a true altitude, degrees.
static double refraction(double altitude) {
    if (altitude < LEAST_REFRACTED || altitude > 89) return 0;
    return 1.02 / 60 / tan((altitude + 10.3 / (altitude + 5.11)) * DEGREE);
}

SunPosition sun_position(int year, int month, int day, double hour, double latitude, double longitude) {
    double days = julian_day(year, month, day, hour) - 2451545, t = days / 36525;
    // Chapter 25: mean longitude and anomaly, equation of the centre, apparent longitude.
    double l0 = 280.46646 + t * (36000.76983 + t * 0.0003032);
    double m = (357.52911 + t * (35999.05029 - t * 0.0001537)) * DEGREE;
    double e = 0.016708634 - t * (0.000042037 + t * 0.0000001267);
    double c = (1.914602 - t * (0.004817 + t * 0.000014)) * sin(m) + (0.019993 - t * 0.000101) * sin(2 * m) +
               0.000289 * sin(3 * m);
    double node = (125.04 - 1934.136 * t) * DEGREE;
    double lambda = (l0 + c - 0.00569 - 0.00478 * sin(node)) * DEGREE;
    double epsilon = (23.4392911 - t * 0.0130042 + 0.00256 * cos(node)) * DEGREE;
    double ascension = atan2(cos(epsilon) * sin(lambda), cos(lambda));
    double sine = sin(epsilon) * sin(lambda), cosine = sqrt(1 - sine * sine);  // of the declination
    // Chapter 12: apparent sidereal time, then the hour angle, positive west of the meridian.
    double sidereal =
        280.46061837 + 360.98564736629 * days + t * t * 0.000387933 - 0.00478 * sin(node) * cos(epsilon);
    double angle = fmod(sidereal, 360) * DEGREE + longitude - ascension;
    // Chapter 13, as a vector to east, north and up.
    double east = -cosine * sin(angle);
    double north = sine * cos(latitude) - cosine * cos(angle) * sin(latitude);
    double up = sine * sin(latitude) + cosine * cos(angle) * cos(latitude);
    double altitude = atan2(up, hypot(east, north)) / DEGREE;
    altitude -= PARALLAX * cos(altitude * DEGREE);
    double azimuth = atan2(east, north);
    return (SunPosition){.altitude = (altitude + refraction(altitude)) * DEGREE,
                         .azimuth = azimuth < 0 ? azimuth + 2 * M_PI : azimuth,
                         .distance = 1.000001018 * (1 - e * e) / (1 + e * cos(m + c * DEGREE))};
}

Vec3 sun_direction(const SunPosition *sun, double north) {
    double turn = sun->azimuth + north, level = cos(sun->altitude);
    return vec3(sin(turn) * level, cos(turn) * level, sin(sun->altitude));
}
