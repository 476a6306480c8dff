// wad_movers.c - which sectors of a Doom map move, and how far.
//
// A door is a sector whose ceiling comes down to its floor. Lines say which: those used by hand mean the sector behind
// them, those used at a switch or walked over all sectors of their tag. A door opens up to 4 units below the lowest
// ceiling around it; a lift goes down to the lowest floor around it (the numbers of the specials: id Software 1993; the
// generalised ones: Boom). Many maps close sectors without a special; those are doors too, or, where no ceiling around
// is higher, hatches: their floor sinks.
#include <limits.h>

#include "maps/doom/wad.h"

// The ceiling of an open door stays so far below the lowest one around, map units.
enum { LINTEL = 4 };

typedef struct Special {
    int from, to;
    int motion;   // see WadMover
    bool behind;  // the sector behind the line; else those of its tag
} Special;

static const Special SPECIALS[] = {
    {1, 1, WAD_DOOR, true},      {26, 28, WAD_DOOR, true},    {31, 34, WAD_DOOR, true},
    {117, 118, WAD_DOOR, true},  {2, 4, WAD_DOOR, false},     {16, 16, WAD_DOOR, false},
    {29, 29, WAD_DOOR, false},   {42, 42, WAD_DOOR, false},   {46, 46, WAD_DOOR, false},
    {50, 50, WAD_DOOR, false},   {61, 61, WAD_DOOR, false},   {63, 63, WAD_DOOR, false},
    {75, 76, WAD_DOOR, false},   {86, 86, WAD_DOOR, false},   {90, 90, WAD_DOOR, false},
    {99, 99, WAD_DOOR, false},   {103, 103, WAD_DOOR, false}, {105, 116, WAD_DOOR, false},
    {133, 137, WAD_DOOR, false}, {10, 10, WAD_LIFT, false},   {21, 21, WAD_LIFT, false},
    {62, 62, WAD_LIFT, false},   {88, 88, WAD_LIFT, false},   {120, 123, WAD_LIFT, false},
};

// Boom's: three bits say how it is set off, the last two values by a push at the line.
enum {
    BOOM_LIFT = 0x3400,
    BOOM_LOCKED = 0x3800,
    BOOM_DOOR = 0x3C00,
    BOOM_END = 0x4000,
    TRIGGER = 7,
    PUSHED = 6
};

static bool find_special(int number, Special *out) {
    if (number >= BOOM_LIFT && number < BOOM_END) {
        bool door = number >= BOOM_LOCKED;
        *out = (Special){number, number, door ? WAD_DOOR : WAD_LIFT, (number & TRIGGER) >= PUSHED};
        return true;
    }
    for (size_t i = 0; i < sizeof SPECIALS / sizeof *SPECIALS; i++) {
        if (number < SPECIALS[i].from || number > SPECIALS[i].to) continue;
        *out = SPECIALS[i];
        return true;
    }
    return false;
}

// The heights of the sectors beyond a sector's lines, map units; closed ones have no ceiling to open up to.
typedef struct Around {
    int lowest_floor, lowest_ceiling;  // INT_MAX without
} Around;

static Around *look_around(const WadMap *map, Arena *scratch) {
    Around *around = ARENA_ARRAY(scratch, Around, map->sector_count + 1);
    for (int i = 0; i < map->sector_count; i++) around[i] = (Around){INT_MAX, INT_MAX};
    for (int i = 0; i < map->line_count; i++) {
        const WadLine *line = &map->lines[i];
        if (line->sector[0] < 0 || line->sector[1] < 0 || wad_line_is_void(map, line)) continue;
        for (int k = 0; k < 2; k++) {
            const WadSector *beyond = &map->sectors[line->sector[1 - k]];
            Around *a = &around[line->sector[k]];
            if (beyond->floor < a->lowest_floor) a->lowest_floor = beyond->floor;
            if (beyond->ceiling > beyond->floor && beyond->ceiling < a->lowest_ceiling)
                a->lowest_ceiling = beyond->ceiling;
        }
    }
    return around;
}

// A sector that is a lift to one line and a door to another is a door.
static void want(int *wanted, int motion) {
    if (*wanted != WAD_DOOR) *wanted = motion;
}

static int *find_wanted(const WadMap *map, Arena *scratch) {
    enum { TAGS = 1 << 16 };
    int *wanted = ARENA_ARRAY(scratch, int, map->sector_count + 1);
    int *of_tag = ARENA_ARRAY(scratch, int, TAGS);
    for (int i = 0; i < map->line_count; i++) {
        const WadLine *line = &map->lines[i];
        Special special;
        if (!find_special(line->special, &special)) continue;
        if (!special.behind && line->tag != 0) want(&of_tag[line->tag], special.motion);
        if (special.behind && line->sector[1] >= 0) want(&wanted[line->sector[1]], special.motion);
    }
    for (int s = 0; s < map->sector_count; s++) {
        int motion = of_tag[map->sectors[s].tag];
        if (motion != WAD_FIXED) want(&wanted[s], motion);
    }
    return wanted;
}

static WadMover door_of(const WadSector *s, const Around *around) {
    int top = around->lowest_ceiling == INT_MAX ? s->ceiling : around->lowest_ceiling - LINTEL;
    if (top < s->ceiling) top = s->ceiling;
    if (top > s->floor) {
        double open = fmax(0, s->ceiling - s->floor) / (top - s->floor);
        return (WadMover){WAD_DOOR, s->floor, top, s->floor, top, open};
    }
    // No ceiling around is higher: the leaf sinks.
    if (around->lowest_floor < s->ceiling)
        return (WadMover){WAD_HATCH, around->lowest_floor, s->ceiling, around->lowest_floor, s->ceiling, 0};
    return (WadMover){.motion = WAD_FIXED, .floor = s->floor, .ceiling = s->floor};
}

WadMover *wad_find_movers(const WadMap *map, Arena *arena) {
    Arena scratch = {0};
    WadMover *movers = ARENA_ARRAY(arena, WadMover, map->sector_count + 1);
    const Around *around = look_around(map, &scratch);
    const int *wanted = find_wanted(map, &scratch);
    for (int i = 0; i < map->sector_count; i++) {
        const WadSector *s = &map->sectors[i];
        int lowest = around[i].lowest_floor < s->floor ? around[i].lowest_floor : s->floor;
        movers[i] = (WadMover){.motion = WAD_FIXED, .floor = s->floor, .ceiling = s->ceiling};
        if (wanted[i] == WAD_DOOR || s->ceiling <= s->floor) {
            movers[i] = door_of(s, &around[i]);
        } else if (wanted[i] == WAD_LIFT && lowest < s->floor) {
            movers[i] = (WadMover){WAD_LIFT, lowest, s->ceiling, lowest, s->floor, 0};
        }
    }
    arena_free(&scratch);
    return movers;
}
