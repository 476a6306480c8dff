// sh3d_zone.c - how far the clock of a time zone is ahead of UTC, by the system's zone data (TZif of RFC 8536, version 2 and above).
//
// Departure: rules for the years after the last stored change (TZif's footer) are not read; those years count as not known.
#include <stdio.h>
#include <string.h>

#include "engine/core/file.h"
#include "maps/sweethome/sh3d.h"

static const char FOLDER[] = "/usr/share/zoneinfo";
enum { HEADER = 44, TYPE = 6, LARGEST = 1 << 20 };

// Counts of a header, in the order of the format.
enum { UT_COUNT, STANDARD_COUNT, LEAP_COUNT, TIME_COUNT, TYPE_COUNT, CHARACTER_COUNT, COUNTS };

static long long number(const unsigned char *at, int bytes) {
    unsigned long long value = at[0] >= 0x80 ? ~0ULL : 0;
    for (int i = 0; i < bytes; i++) value = value << 8 | at[i];
    return (long long)value;
}

// The bytes of a block, header included, whose times have `width` bytes; 0: there is no whole block.
static size_t read_header(const unsigned char *at, size_t left, int width, long long count[COUNTS]) {
    if (left < HEADER || memcmp(at, "TZif", 4) != 0 || at[4] < '2') return 0;
    for (int i = 0; i < COUNTS; i++) {
        count[i] = number(at + 20 + 4 * i, 4);
        if (count[i] < 0 || count[i] > LARGEST) return 0;
    }
    size_t size = HEADER + (size_t)(count[TIME_COUNT] * (width + 1) + count[TYPE_COUNT] * TYPE +
                                    count[CHARACTER_COUNT] + count[LEAP_COUNT] * (width + 4) +
                                    count[STANDARD_COUNT] + count[UT_COUNT]);
    return size <= left ? size : 0;
}

// Seconds ahead of UTC at a time, seconds since 1970; false: not known.
static bool ahead_at(const unsigned char *block, const long long count[COUNTS], bool rules, long long time,
                     long long *seconds) {
    const unsigned char *times = block + HEADER, *kinds = times + 8 * count[TIME_COUNT],
                        *types = kinds + count[TIME_COUNT];
    long long last = -1;
    while (last + 1 < count[TIME_COUNT] && number(times + 8 * (last + 1), 8) <= time) last++;
    if (rules && last + 1 == count[TIME_COUNT]) return false;
    int type = last < 0 ? 0 : kinds[last];
    if (type >= count[TYPE_COUNT]) return false;
    *seconds = number(types + TYPE * type, 4);
    return *seconds > -86400 && *seconds < 86400;
}

bool sh3d_zone_ahead(Bytes zone, double wall, double *hours) {
    long long count[COUNTS], ahead;
    size_t first = read_header(zone.data, zone.size, 4, count);
    const unsigned char *block = zone.data + first;
    size_t size = first > 0 ? read_header(block, zone.size - first, 8, count) : 0;
    if (size == 0) return false;
    // A footer with a comma has rules for summers to come.
    bool rules = memchr(block + size, ',', zone.size - first - size) != NULL;
    long long clock = (long long)floor(wall);
    if (!ahead_at(block, count, rules, clock, &ahead) ||
        !ahead_at(block, count, rules, clock - ahead, &ahead))
        return false;
    *hours = (double)ahead / 3600;
    return true;
}

// Names are those of files in folders; no name leads out of there.
static bool is_name(const char *name) {
    return *name && *name != '/' && strlen(name) < 64 && !strstr(name, "..") &&
           name[strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_+-/")] == 0;
}

bool sh3d_zone_find(const char *name, double wall, double *hours) {
    Arena scratch = {0};
    Bytes zone;
    Error ignored;
    bool good =
        is_name(name) &&
        file_read(arena_format(&scratch, "%s/%s", FOLDER, name), LARGEST, &scratch, &zone, &ignored) &&
        sh3d_zone_ahead(zone, wall, hours);
    arena_free(&scratch);
    return good;
}
