// campus.c - see campus.h. All lengths are whole millimetres held in integers, so that the same seed gives the same text everywhere.
#include "maps/buildings/campus.h"

#include <stdio.h>
#include <string.h>

#include "engine/core/random.h"

enum { WALL = 200, HEIGHT = 2900, STOREY = 3300, STEP = 50 };

// A plan while it is written.
typedef struct Campus {
    Random random;
    int rooms, wanted, openings;  // written so far; how many there are to be
} Campus;

typedef struct Rect {
    int x0, y0, x1, y1;  // inner faces
} Rect;

static int pick(Campus *c, int low, int high) {
    return low + STEP * random_index(&c->random, (high - low) / STEP + 1);
}

static void begin(const char *name, int count, unsigned long long seed) {
    printf("# %s-%d: made by maps/buildings/generate.c with seed %llu.\nplan 1\n\n"
           "material floor #8A8478\nmaterial ceiling #ECEAE4\nmaterial wall #DCD6C8\nmaterial jamb #B9B2A4\n"
           "material door #A97B4F\nmaterial slab #C9A374\nmaterial panel #9AA0A6\nmaterial facade #B8AFA2\n"
           "material lamp #FFFFFF emission 20\nfacade facade\nslabs jamb\nground facade height -0.1\n"
           "\nmodel desk\n  box -0.7,-0.35,0.70 0.7,0.35,0.74 slab\n  box -0.66,-0.31,0 -0.62,0.31,0.70 "
           "panel without top bottom\n"
           "  box 0.62,-0.31,0 0.66,0.31,0.70 panel without top bottom\nend\n"
           "model cabinet\n  box -0.4,-0.2,0 0.4,0.2,1.8 panel without bottom\nend\n",
           name, count, seed);
}

static void begin_storey(int k) {
    printf("\nstorey s%d floor %.3f height %.3f slab %.3f\n", k, k * STOREY / 1e3, HEIGHT / 1e3,
           (STOREY - HEIGHT) / 1e3);
}

// False when all rooms are there.
static bool room(Campus *c, const char *name, Rect r, int height) {
    if (c->rooms == c->wanted) return false;
    printf(
        "room %s%d %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f floor floor ceiling ceiling walls wall wall %.3f",
        name, c->rooms++, r.x0 / 1e3, r.y0 / 1e3, r.x1 / 1e3, r.y0 / 1e3, r.x1 / 1e3, r.y1 / 1e3, r.x0 / 1e3,
        r.y1 / 1e3, WALL / 1e3);
    if (height != HEIGHT) printf(" height %.3f", height / 1e3);
    printf("\n");
    return true;
}

static void lamp(Rect r) {
    int x = (r.x0 + r.x1) / 2, y = (r.y0 + r.y1) / 2;
    printf("inlay lamp ceiling %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f\n", (x - 600) / 1e3, (y - 150) / 1e3,
           (x + 600) / 1e3, (y - 150) / 1e3, (x + 600) / 1e3, (y + 150) / 1e3, (x - 600) / 1e3,
           (y + 150) / 1e3);
}

typedef enum OpeningKind { DOOR, PASSAGE, WINDOW, GLASS } OpeningKind;

// In the middle of a wall's thickness, across x (angle 90) or along it.
static void opening(Campus *c, OpeningKind kind, int x, int y, bool across, int width, int height) {
    static const char *const WORDS[] = {"door", "passage", "window", "window"};
    printf("%s o%d %.3f,%.3f width %.3f height %.3f", WORDS[kind], c->openings++, x / 1e3, y / 1e3,
           width / 1e3, height / 1e3);
    if (across) printf(" angle 90");
    if (kind == WINDOW) printf(" sill 0.9");
    if (kind == GLASS) printf(" sill 0.1");
    printf(kind == DOOR ? " swing 88 material door\n" : " material jamb\n");
}

// A room of desks; its door is in the wall below it (the corridor's), or above.
static bool office(Campus *c, Rect r, bool door_below) {
    if (!room(c, "office-", r, HEIGHT)) return false;
    lamp(r);
    opening(c, DOOR, pick(c, r.x0 + 700, r.x1 - 700), door_below ? r.y0 - WALL / 2 : r.y1 + WALL / 2, false,
            900, 2100);
    int far = door_below ? r.y1 - 600 : r.y0 + 600;
    for (int x = r.x0 + 1000, k = 0; x + 900 < r.x1 && k < 2; x += 2000, k++)
        printf("place desk %.3f,%.3f%s\n", pick(c, x, x + 200) / 1e3, far / 1e3,
               door_below ? "" : " angle 180");
    printf("place cabinet %.3f,%.3f angle 90\n", (r.x1 - 300) / 1e3, (r.y0 + r.y1) / 2e3);
    return true;
}

// ---- campus: blocks of three storeys around a courtyard. In plan, from below: outer rooms, corridor, inner rooms, courtyard, inner
// rooms, corridor, outer rooms; on the left and right a corridor joins both. Blocks stand wall to wall in rows of a house; houses stand
// apart. Where corridors of neighbours are joined, the doors lie anywhere along their walls, so that no view goes on for long.

enum {
    SIDE_ROOMS = 8,
    ROOM_WIDTH = 4400,
    BLOCK_X = SIDE_ROOMS * (ROOM_WIDTH + WALL) - WALL,
    DEPTH = 4600,  // of rooms
    CORRIDOR = 2200,
    COURT = 9000,
    STOREYS = 3,
    // From below: where each strip begins.
    LOWER_CORRIDOR = DEPTH + WALL,
    LOWER_INNER = LOWER_CORRIDOR + CORRIDOR + WALL,
    COURT_AT = LOWER_INNER + DEPTH + WALL,
    UPPER_INNER = COURT_AT + COURT + WALL,
    UPPER_CORRIDOR = UPPER_INNER + DEPTH + WALL,
    UPPER_OUTER = UPPER_CORRIDOR + CORRIDOR + WALL,
    BLOCK_Y = UPPER_OUTER + DEPTH,
    INNER_X = CORRIDOR + WALL,  // beside the corridors on the left and right
    INNER_ROOMS = 6,
    INNER_WIDTH = (BLOCK_X - 2 * INNER_X - (INNER_ROOMS - 1) * WALL) / INNER_ROOMS,
    STAIRS = 2,      // the outer room below that is a stairwell
    LINK = 5,        // the outer room above, and the one below it in the next block, that join blocks
    ATRIUM = 2,      // the first of two inner rooms above that are one hall through all storeys
    HOUSE_SIDE = 4,  // blocks of a house each way
    STREET = 30000   // between houses
};

typedef struct Block {
    int x, y;
    bool right, up;    // there is a block of the same house
    bool down, first;  // the lowest block on the left has the entrance
} Block;

static Rect at(const Block *b, int x0, int y0, int x1, int y1) {
    return (Rect){b->x + x0, b->y + y0, b->x + x1, b->y + y1};
}

static Rect outer_room(const Block *b, int i, bool above) {
    int x = i * (ROOM_WIDTH + WALL), y = above ? UPPER_OUTER : 0;
    return at(b, x, y, x + ROOM_WIDTH, y + DEPTH);
}
static Rect inner_room(const Block *b, int i, bool above) {
    int x = INNER_X + i * (INNER_WIDTH + WALL), y = above ? UPPER_INNER : LOWER_INNER;
    return at(b, x, y, x + INNER_WIDTH, y + DEPTH);
}

// The corridors of a storey, joined by passages, and by doors to the block on the right.
static bool corridors(Campus *c, const Block *b, int storey) {
    Rect lower = at(b, 0, LOWER_CORRIDOR, BLOCK_X, LOWER_CORRIDOR + CORRIDOR),
         upper = at(b, 0, UPPER_CORRIDOR, BLOCK_X, UPPER_CORRIDOR + CORRIDOR),
         left = at(b, 0, LOWER_INNER, CORRIDOR, UPPER_INNER + DEPTH),
         right = at(b, BLOCK_X - CORRIDOR, LOWER_INNER, BLOCK_X, UPPER_INNER + DEPTH);
    Rect all[] = {lower, left, upper, right};
    for (int i = 0; i < 4; i++) {
        if (!room(c, "corridor-", all[i], HEIGHT)) return false;
        lamp(all[i]);
        if (i == 1) opening(c, PASSAGE, left.x0 + 1100, left.y0 - WALL / 2, false, 1600, 2400);
        if (i == 2) opening(c, PASSAGE, left.x0 + 1100, left.y1 + WALL / 2, false, 1600, 2400);
        if (i == 3) opening(c, PASSAGE, right.x0 + 1100, right.y0 - WALL / 2, false, 1600, 2400);
        if (i == 3) opening(c, PASSAGE, right.x0 + 1100, right.y1 + WALL / 2, false, 1600, 2400);
    }
    if (b->first && storey == 0) opening(c, DOOR, lower.x0 - WALL / 2, lower.y0 + 1100, true, 1200, 2100);
    if (b->right && storey == 0)
        opening(c, DOOR, right.x1 + WALL / 2, pick(c, right.y0 + 3000, right.y1 - 3000), true, 1200, 2100);
    return true;
}

static bool stairs(Campus *c, const Block *b, int storey) {
    Rect r = outer_room(b, STAIRS, false);
    if (!room(c, "stairs-", r, HEIGHT)) return false;
    opening(c, PASSAGE, (r.x0 + r.x1) / 2 - 900, r.y1 + WALL / 2, false, 1200, 2100);
    if (storey > 0)
        printf("stairwell w%d %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f\n", c->openings++, (r.x1 - 1700) / 1e3,
               (r.y0 + 200) / 1e3, (r.x1 - 200) / 1e3, (r.y0 + 200) / 1e3, (r.x1 - 200) / 1e3,
               (r.y1 - 400) / 1e3, (r.x1 - 1700) / 1e3, (r.y1 - 400) / 1e3);
    if (storey + 1 < STOREYS)
        printf("stair t%d %.3f,%.3f width 1.3 depth 4.0 height %.3f steps 18 material jamb\n", c->openings++,
               (r.x1 - 950) / 1e3, (r.y0 + 2200) / 1e3, STOREY / 1e3);
    return true;
}

// A hall beside the corridor above, through all storeys, with a passage below and windows from the corridors above.
static bool atrium(Campus *c, const Block *b, int storey) {
    Rect r = inner_room(b, ATRIUM, true);
    r.x1 = inner_room(b, ATRIUM + 1, true).x1;
    if (storey == 0) {
        if (!room(c, "atrium-", r, (STOREYS - 1) * STOREY + HEIGHT)) return false;
        opening(c, PASSAGE, (r.x0 + r.x1) / 2, r.y1 + WALL / 2, false, 2000, 2400);
    } else if (c->rooms < c->wanted) {
        for (int k = 0; k < 3; k++)
            opening(c, WINDOW, r.x0 + (2 * k + 1) * (r.x1 - r.x0) / 6, r.y1 + WALL / 2, false, 2000, 1400);
    }
    return true;
}

static bool block_storey(Campus *c, const Block *b, int storey) {
    if (!corridors(c, b, storey)) return false;
    if (storey == 0) {
        if (!room(c, "court-", at(b, INNER_X, COURT_AT, BLOCK_X - INNER_X, COURT_AT + COURT),
                  (STOREYS - 1) * STOREY + HEIGHT))
            return false;
        opening(c, DOOR, b->x + INNER_X - WALL / 2, b->y + pick(c, COURT_AT + 1000, COURT_AT + COURT - 1000),
                true, 1200, 2100);
    }
    if (!stairs(c, b, storey) || !atrium(c, b, storey)) return false;
    for (int above = 0; above < 2; above++) {
        for (int i = 0; i < INNER_ROOMS; i++) {
            if (above && (i == ATRIUM || i == ATRIUM + 1)) continue;
            Rect r = inner_room(b, i, above);
            if (!office(c, r, !above)) return false;
            opening(c, WINDOW, (r.x0 + r.x1) / 2, above ? r.y0 - WALL / 2 : r.y1 + WALL / 2, false, 1800,
                    1400);
        }
        for (int i = 0; i < SIDE_ROOMS; i++) {
            if (!above && i == STAIRS) continue;
            Rect r = outer_room(b, i, above);
            if (!office(c, r, above)) return false;
            // Only on the ground: the halls of the next block below are there already.
            if (i == LINK && !above && b->down && storey == 0)
                opening(c, PASSAGE, pick(c, r.x0 + 700, r.x1 - 700), r.y0 - WALL / 2, false, 1200, 2100);
        }
    }
    return true;
}

enum {
    OF_HOUSE = HOUSE_SIDE * HOUSE_SIDE,
    OF_GROUND = 32,
    OF_STOREY = 30,
    OF_BLOCK = OF_GROUND + (STOREYS - 1) * OF_STOREY
};

static Block block_at(int index, int blocks, int houses_aside) {
    int house = index / OF_HOUSE, i = index % HOUSE_SIDE, j = index % OF_HOUSE / HOUSE_SIDE;
    int pitch_x = HOUSE_SIDE * (BLOCK_X + WALL) + STREET, pitch_y = HOUSE_SIDE * (BLOCK_Y + WALL) + STREET;
    return (Block){.x = house % houses_aside * pitch_x + i * (BLOCK_X + WALL),
                   .y = house / houses_aside * pitch_y + j * (BLOCK_Y + WALL),
                   .right = i + 1 < HOUSE_SIDE && index + 1 < blocks,
                   .down = j > 0,
                   .first = i == 0 && j == 0};
}

// Storey by storey; of the highest one, rooms are left out when there are enough.
static void campus(int count, unsigned long long seed) {
    Campus c = {.random = {seed}, .wanted = count};
    int blocks = (count + OF_BLOCK - 1) / OF_BLOCK, aside = 1;
    while (aside * aside * OF_HOUSE < blocks) aside++;
    begin("campus", count, seed);
    for (int storey = 0; storey < STOREYS && c.rooms < count; storey++) {
        begin_storey(storey);
        for (int i = 0; i < blocks; i++) {
            Block b = block_at(i, blocks, aside);
            if (!block_storey(&c, &b, storey)) break;
        }
    }
    printf("\nstart 6,%.3f yaw 0\n", (LOWER_CORRIDOR + CORRIDOR / 2) / 1e3);
}

// ---- corridors of a kilometre: rooms on both sides of each, doors anywhere along their walls; corridors are apart from each other

static void corridor(int count, unsigned long long seed) {
    enum {
        LENGTH = 1000000,
        ROW = 2 * (LENGTH / (ROOM_WIDTH + WALL)),
        PITCH = 2 * (DEPTH + WALL) + CORRIDOR + 1000
    };
    Campus c = {.random = {seed}, .wanted = count};
    begin("corridor", count, seed);
    begin_storey(0);
    for (int k = 0; c.rooms < count; k++) {
        int left = count - c.rooms - 1, row = left < ROW ? left : ROW, y = k * PITCH;
        Rect hall = {0, y, LENGTH, y + CORRIDOR};
        room(&c, "corridor-", hall, HEIGHT);
        lamp(hall);
        for (int i = 0; i < row; i++) {
            int x = i / 2 * (ROOM_WIDTH + WALL);
            bool above = i % 2;
            Rect r = {x, above ? hall.y1 + WALL : y - WALL - DEPTH, x + ROOM_WIDTH,
                      above ? hall.y1 + WALL + DEPTH : y - WALL};
            office(&c, r, above);
        }
    }
    printf("\nstart 6,1.1 yaw 0\n");
}

// ---- a hall onto which all rooms of five galleries open, on its two long sides

static void hall(int count, unsigned long long seed) {
    enum { GALLERIES = 5, WIDTH = 24000 };
    Campus c = {.random = {seed}, .wanted = count};
    int row = (count - 1 + 2 * GALLERIES - 1) / (2 * GALLERIES);
    if (row < 1) row = 1;
    begin("atrium", count, seed);
    Rect all = {0, 0, row * (ROOM_WIDTH + WALL) - WALL, WIDTH};
    for (int storey = 0; storey < GALLERIES && c.rooms < count; storey++) {
        begin_storey(storey);
        if (storey == 0) room(&c, "hall-", all, (GALLERIES - 1) * STOREY + HEIGHT);
        for (int i = 0; i < 2 * row; i++) {
            int x = i / 2 * (ROOM_WIDTH + WALL);
            bool above = i % 2;
            Rect r = {x, above ? WIDTH + WALL : -WALL - DEPTH, x + ROOM_WIDTH,
                      above ? WIDTH + WALL + DEPTH : -WALL};
            if (!office(&c, r, above)) break;
        }
    }
    printf("\nstart 2,2 yaw 0\n");
}

// ---- glass: houses of rooms between walls of glass, each a square of SIDE rooms a side, apart from each other

static void glass(int count, unsigned long long seed) {
    enum { SIDE = 5, SIZE = 4000, PITCH = SIZE + WALL, HOUSE = SIDE * PITCH + 4000 };
    Campus c = {.random = {seed}, .wanted = count};
    int houses = (count + SIDE * SIDE - 1) / (SIDE * SIDE), aside = 1;
    while (aside * aside < houses) aside++;
    begin("glass", count, seed);
    begin_storey(0);
    for (int k = 0; k < count; k++) {
        int house = k / (SIDE * SIDE), i = k % SIDE, j = k % (SIDE * SIDE) / SIDE;
        int x = house % aside * HOUSE + i * PITCH, y = house / aside * HOUSE + j * PITCH;
        Rect r = {x, y, x + SIZE, y + SIZE};
        room(&c, "glass-", r, HEIGHT);
        lamp(r);
        if (i + 1 < SIDE && k + 1 < count)
            opening(&c, GLASS, r.x1 + WALL / 2, y + SIZE / 2, true, 3600, 2600);
        if (j > 0) opening(&c, GLASS, x + SIZE / 2, r.y0 - WALL / 2, false, 3600, 2600);
        printf("place cabinet %.3f,%.3f\n", pick(&c, x + 600, r.x1 - 600) / 1e3,
               pick(&c, y + 600, r.y1 - 600) / 1e3);
    }
    printf("\nstart 2,2 yaw 0\n");
}

bool campus_write(const char *name, unsigned long long seed) {
    static const struct {
        const char *name;
        int least;
        void (*write)(int count, unsigned long long seed);
    } ALL[] = {
        {"campus-", 10, campus}, {"corridor-", 2, corridor}, {"atrium-", 2, hall}, {"glass-", 1, glass}};
    for (size_t i = 0; i < sizeof ALL / sizeof *ALL; i++) {
        size_t length = strlen(ALL[i].name);
        int count = 0, end = 0;
        if (strncmp(name, ALL[i].name, length) != 0) continue;
        if (sscanf(name + length, "%6d%n", &count, &end) != 1 || name[length + (size_t)end]) return false;
        if (count < ALL[i].least || count > 100000) return false;
        ALL[i].write(count, seed);
        return true;
    }
    return false;
}
