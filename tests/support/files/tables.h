// tables.h - photometric files of our own making, for tests: intensities by formula, written as IES or EULUMDAT.
#ifndef TESTS_TABLES_H
#define TESTS_TABLES_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// A narrow lamp, the same all round; a street light, mirrored about the plane C90-C270, brightest far out towards C90; a lamp for walls,
// mirrored about both planes; one that sends most of its light upwards, with no symmetry; a globe, the same all round and both ways.
typedef enum Table { TABLE_SPOT, TABLE_STREET, TABLE_WALLS, TABLE_UP, TABLE_GLOBE, TABLES } Table;

// The intensity by formula, cd; angles in degrees.
double tables_candela(Table table, double gamma, double plane);

// How planes are listed: all (0 to 360), half (0 to 180), a quarter (0 to 90), the side from C270 by C0 to C90, one.
typedef enum Listed { LISTED_ALL, LISTED_HALF, LISTED_QUARTER, LISTED_SIDE, LISTED_ONE } Listed;
// The fewest planes that tell a table.
Listed tables_fewest(Table table);

// The text of a file with steps of so many degrees, of both angles, and an opening of so many metres along C0 and C90. Of IES files the
// side is the one from C90 by C180 to C270.
char *tables_ies(Arena *arena, Table table, Listed listed, double step, Vec2 opening);
char *tables_ldt(Arena *arena, Table table, Listed listed, double step, Vec2 opening);

// Illuminance in lux by formula: the sum over a level opening, whose C0 is turned by `turn` degrees from +x, of intensity times cosine over
// squared distance. The sides below and above leave at the heights z[0] and z[1].
double tables_lux(Table table, Vec2 opening, double turn, Vec2 at, const double z[2], Vec3 point,
                  Vec3 normal);

#endif
