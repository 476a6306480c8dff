// soups.h - what the tests of the soup readers share: a room in numbers, reading from memory, faults and damage.
#ifndef TESTS_SOUPS_H
#define TESTS_SOUPS_H

#include "maps/maps.h"

// A room 4 x 3 x 2.5 m whose six walls look inwards: corners, and four of them a wall.
extern const double SOUPS_ROOM[8][3];
extern const int SOUPS_WALL[6][4];

// Reads a copy of `data` as the file `path`.
bool soups_read(const MapsReader *reader, const char *path, const void *data, size_t size, Arena *arena,
                Building *out, Error *error);
// Text that must be read and pass the check.
void soups_accept(const MapsReader *reader, const char *path, const char *text, Arena *arena, Building *out);
// Text that must be refused with a sentence that holds `expected`.
void soups_refuse(const MapsReader *reader, const char *path, const char *text, const char *expected);
// Notes that hold `text`.
int soups_notes(const Building *b, const char *text);
// Every polygon of one has its like in the other, corner by corner from any of them on.
void soups_expect_same(const Building *a, const Building *b);

// Bytes changed, cut out, doubled and replaced by large numbers, `rounds` times: each time the reader refuses with a
// sentence, or reads what passes the check. A failure prints the seed.
void soups_damage(const MapsReader *reader, const char *path, const void *data, size_t size, uint64_t seed,
                  int rounds);

#endif
