// campus.h - the large buildings that generate.c writes: what cost is measured on as rooms become thousands.
#ifndef MAPS_BUILDINGS_CAMPUS_H
#define MAPS_BUILDINGS_CAMPUS_H

#include <stdbool.h>

// Writes the building `name` as .plan text on standard output; false where there is none of that name:
//   campus-N     N rooms, 10 to 100000, in blocks of three storeys around courtyards: corridors, stairs, atria, windows, doors
//   corridor-N   N rooms on both sides of corridors of a kilometre
//   atrium-N     N rooms on five galleries around one hall
//   glass-N      N rooms between walls of glass, on a campus of houses without outer windows
bool campus_write(const char *name, unsigned long long seed);

#endif
