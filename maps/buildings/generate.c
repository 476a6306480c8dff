// generate.c - writes the offices that figures are measured on, as .plan text on standard output:
//   generate office SEED         72 furnished rooms along corridors, about 16,700 polygons, as in the office of
//                                Shudo, Murata & Matsuyama; doors, some windows; differs with the seed
//   generate office-plain SEED   6 x 11 equal rooms of 4 x 4 m, 7,454 polygons; the same for every seed
//   generate enfilade-N SEED     N rooms of that kind in a square, 1 to 100000, their doorways in line: one sees through all
//                                of a row
//   generate rooms-N SEED        the same with doorways anywhere along their walls: one sees a few rooms; differs with the seed
//   generate campus-N SEED, corridor-N, atrium-N, glass-N: see campus.h
// The same seed gives the same text on every machine: all coordinates are whole millimetres held in integers.
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/buildings/campus.h"

// ---- models; polygons are counted as they are written

typedef struct Box3 {
    int x0, y0, z0, x1, y1, z1;  // mm
} Box3;

enum { MAX_MODELS = 32 };
static struct {
    const char *name;
    int polygons;
} models[MAX_MODELS];
static int model_count;

static void begin_model(const char *name, const char *kind) {
    models[model_count].name = name;
    models[model_count++].polygons = 0;
    printf("\nmodel %s%s\n", name, kind);
}

static void box(Box3 b, const char *material, const char *without) {
    printf("  box %.3f,%.3f,%.3f %.3f,%.3f,%.3f %s", b.x0 / 1e3, b.y0 / 1e3, b.z0 / 1e3, b.x1 / 1e3,
           b.y1 / 1e3, b.z1 / 1e3, material);
    int faces = 6;
    if (*without) {
        printf(" without %s", without);
        faces--;
        for (const char *c = without; *c; c++) faces -= *c == ' ';
    }
    printf("\n");
    models[model_count - 1].polygons += faces;
}

// Standing on something, so without its bottom.
static void cylinder(int x, int y, int z0, int z1, int radius, int sides, const char *material) {
    printf("  cylinder %s %.3f %.3f %.3f,%.3f radius %.3f sides %d without bottom\n", material, z0 / 1e3,
           z1 / 1e3, x / 1e3, y / 1e3, radius / 1e3, sides);
    models[model_count - 1].polygons += sides + 1;
}

static void end(void) { printf("end\n"); }

static int polygons_of(const char *name) {
    for (int i = 0; i < model_count; i++)
        if (strcmp(models[i].name, name) == 0) return models[i].polygons;
    fprintf(stderr, "generate: no model %s\n", name);
    exit(1);
}

// ---- office-plain

enum {
    PLAIN_NX = 11,
    PLAIN_NY = 6,
    PLAIN_SIZE = 4000,
    PLAIN_WALL = 100,
    PLAIN_PITCH = PLAIN_SIZE + PLAIN_WALL,
    FARTHEST_ASIDE = 1200  // of a doorway's middle from that of its wall
};

static void plain_models(void) {
    // Corners, not centres, are placed: the coordinates are those of the reference figures.
    begin_model("desk", "");
    box((Box3){0, 0, 700, 1200, 700, 740}, "slab", "");
    box((Box3){30, 20, 0, 70, 680, 700}, "panel", "top");
    box((Box3){1130, 20, 0, 1170, 680, 700}, "panel", "top");
    box((Box3){400, 550, 740, 800, 650, 1150}, "block", "bottom");
    end();
    begin_model("cabinet", "");
    box((Box3){0, 0, 0, 450, 220, 1800}, "panel", "bottom");
    end();
}

// A room with doorways to the right and upwards, where there are rooms; `aside` of the middle of their walls, mm.
static void plain_room(int i, int j, bool right, bool up, int aside_right, int aside_up) {
    static const int DESKS[4][2] = {{300, 300}, {2500, 300}, {300, 3000}, {2500, 3000}};
    double x = i * PLAIN_PITCH / 1e3, y = j * PLAIN_PITCH / 1e3, s = PLAIN_SIZE / 1e3;
    printf("\nroom r%d-%d %.1f,%.1f %.1f,%.1f %.1f,%.1f %.1f,%.1f floor floor ceiling ceiling walls wall "
           "wall 0.1\n",
           j, i, x, y, x + s, y, x + s, y + s, x, y + s);
    printf("inlay lamp ceiling %.1f,%.1f %.1f,%.1f %.1f,%.1f %.1f,%.1f\n", x + 1.5, y + 1.5, x + 2.5, y + 1.5,
           x + 2.5, y + 2.5, x + 1.5, y + 2.5);
    if (right)
        printf("passage x%d-%d %.2f,%.2f angle 90 width 0.9 height 2.1 material jamb\n", j, i, x + s + 0.05,
               y + 2 + aside_right / 1e3);
    if (up)
        printf("passage y%d-%d %.2f,%.2f width 0.9 height 2.1 material jamb\n", j, i, x + 2 + aside_up / 1e3,
               y + s + 0.05);
    for (int k = 0; k < 4; k++)
        printf("place desk %.1f,%.1f\n", x + DESKS[k][0] / 1e3, y + DESKS[k][1] / 1e3);
    printf("place cabinet %.1f,%.2f\n", x + 0.3, y + 0.02);
}

static void plain_begin(const char *what) {
    printf("# %s Made by maps/buildings/generate.c.\n"
           "plan 1\n\n"
           "material floor reflectance 0.3\nmaterial ceiling reflectance 0.8\nmaterial wall reflectance 0.6\n"
           "material jamb reflectance 0.5\nmaterial slab reflectance 0.5\nmaterial panel reflectance 0.4\n"
           "material block reflectance 0.2\nmaterial lamp reflectance 0 emission 10\n",
           what);
    plain_models();
    printf("\nstorey office floor 0 height 2.7\n");
}

static void office_plain(void) {
    plain_begin("office-plain: 6 x 11 rooms of 4 x 4 x 2.7 m, 7,454 polygons.");
    for (int j = 0; j < PLAIN_NY; j++)
        for (int i = 0; i < PLAIN_NX; i++) plain_room(i, j, i + 1 < PLAIN_NX, j + 1 < PLAIN_NY, 0, 0);
    printf("\nstart 2,2 yaw 45\n");
}

// Row by row; the last row may be short. The doorways lie up to `aside` mm from the middle of their walls.
static void rooms(int count, int aside, unsigned long long seed) {
    enum { STEP = 50 };  // mm
    Random random = {seed};
    char what[64];
    int nx = 1;
    while (nx * nx < count) nx++;
    snprintf(what, sizeof what, "%d rooms as those of office-plain.", count);
    plain_begin(what);
    for (int k = 0; k < count; k++) {
        int right = STEP * random_index(&random, 2 * aside / STEP + 1) - aside;
        int up = STEP * random_index(&random, 2 * aside / STEP + 1) - aside;
        plain_room(k % nx, k / nx, (k + 1) % nx != 0 && k + 1 < count, k + nx < count, right, up);
    }
    printf("\nstart 2,2 yaw 45\n");
}

// ---- office: six wings, each a corridor between two rows of six rooms, joined in a serpentine at alternate ends

enum {
    WINGS = 6,
    ROW = 6,  // rooms in a row
    ROOMS = 2 * WINGS * ROW,
    WALL = 150,       // mm, between rooms
    CORRIDOR = 2000,  // mm wide
    LENGTH = 32000,   // mm, of a wing
    NARROWEST = 4000,
    WIDEST = 6000,  // mm, of rooms along the corridor
    SHALLOW = 4000,
    DEEP = 5000,    // mm, of rooms across
    GRAIN = 50,     // mm, of sizes
    TARGET = 13500  // polygons of furniture: with the surfaces of the rooms about 16,700 in all
};

typedef struct Room {
    int x0, y0, x1, y1;          // mm, inner faces
    bool upper;                  // its corridor lies below it; its own y counts from the corridor's wall
    int door;                    // mm along its own x
    bool left_door, right_door;  // into the neighbours, in its own frame
} Room;

typedef struct Office {
    Random random;
    int furniture;  // polygons placed so far
    Room room;      // being furnished
} Office;

static int pick(Office *o, int low, int high) { return low + random_index(&o->random, high - low + 1); }
static int pick_size(Office *o, int low, int high) { return low + GRAIN * pick(o, 0, (high - low) / GRAIN); }
static bool chance(Office *o, int percent) { return pick(o, 0, 99) < percent; }

// Places a model in the room's own frame: x along the corridor's wall, y away from it, mm; angle in degrees.
static void place_model(Office *o, const char *model, int x, int y, int angle) {
    const Room *r = &o->room;
    int wx = r->upper ? r->x0 + x : r->x1 - x, wy = r->upper ? r->y0 + y : r->y1 - y;
    int turned = ((angle + (r->upper ? 0 : 180)) % 360 + 360) % 360;
    printf("place %s %.3f,%.3f", model, wx / 1e3, wy / 1e3);
    if (turned) printf(" angle %d", turned);
    printf("\n");
    o->furniture += polygons_of(model);
}

static void put_raised(Office *o, const char *model, int x, int y, int z, int angle) {
    const Room *r = &o->room;
    int wx = r->upper ? r->x0 + x : r->x1 - x, wy = r->upper ? r->y0 + y : r->y1 - y;
    printf("place %s %.3f,%.3f,%.3f angle %d\n", model, wx / 1e3, wy / 1e3, z / 1e3,
           ((angle + (r->upper ? 0 : 180)) % 360 + 360) % 360);
    o->furniture += polygons_of(model);
}

static void desk_models(void) {
    // The user sits on the -y side.
    begin_model("desk", "");
    box((Box3){-700, -350, 700, 700, 350, 740}, "beech", "");
    box((Box3){-680, -330, 0, -640, 330, 700}, "steel", "top");
    box((Box3){640, -330, 0, 680, 330, 700}, "steel", "top");
    box((Box3){-640, 290, 300, 640, 310, 700}, "steel", "top");
    end();
    begin_model("pedestal", "");
    box((Box3){-200, -300, 0, 200, 300, 580}, "steel", "bottom");
    for (int i = 0; i < 3; i++)
        box((Box3){-190, -320, 30 + 180 * i, 190, -300, 200 + 180 * i}, "drawer", "back");
    end();
    begin_model("screen", "");
    box((Box3){-120, -90, 0, 120, 90, 15}, "black", "bottom");
    box((Box3){-20, -10, 15, 20, 10, 120}, "black", "top bottom");
    box((Box3){-270, -30, 120, 270, 0, 460}, "glass", "");
    end();
    begin_model("keyboard", "");
    box((Box3){-220, -70, 0, 220, 70, 25}, "black", "bottom");
    end();
    begin_model("chair", "");  // faces +y
    box((Box3){-230, -220, 430, 230, 230, 490}, "fabric", "");
    box((Box3){-210, -260, 560, 210, -210, 980}, "fabric", "");
    box((Box3){-30, -30, 60, 30, 30, 430}, "black", "top bottom");
    box((Box3){-280, -30, 30, 280, 30, 60}, "black", "");
    box((Box3){-30, -280, 30, 30, 280, 60}, "black", "");
    end();
}

static void storage_models(void) {
    begin_model("cabinet", "");  // opens to -y
    box((Box3){-400, -200, 0, 400, 200, 1300}, "steel", "bottom");
    for (int i = 0; i < 4; i++) {
        box((Box3){-380, -215, 40 + 310 * i, 380, -200, 330 + 310 * i}, "drawer", "back");
        box((Box3){-60, -235, 240 + 310 * i, 60, -215, 260 + 310 * i}, "black", "back");
    }
    end();
    begin_model("shelf", "");
    box((Box3){-450, -150, 0, -430, 150, 2000}, "beech", "bottom");
    box((Box3){430, -150, 0, 450, 150, 2000}, "beech", "bottom");
    box((Box3){-430, 130, 0, 430, 150, 2000}, "beech", "bottom left right");
    for (int i = 0; i < 5; i++) {
        static const int FILL[5] = {420, 300, 390, 180, 350};
        static const char *const BOOKS[5] = {"red", "blue", "green", "red", "blue"};
        box((Box3){-430, -150, 80 + 400 * i, 430, 130, 100 + 400 * i}, "beech", "left right back");
        box((Box3){-430, -90, 100 + 400 * i, -430 + 2 * FILL[i], 110, 380 + 400 * i}, BOOKS[i],
            "bottom left back");
    }
    end();
    begin_model("locker", "");
    box((Box3){-450, -225, 0, 450, 225, 1900}, "steel", "bottom");
    for (int i = 0; i < 3; i++)
        box((Box3){-440 + 295 * i, -240, 60, -150 + 295 * i, -225, 1860}, "drawer", "back");
    end();
}

static void other_models(void) {
    begin_model("table", "");
    box((Box3){-1200, -550, 700, 1200, 550, 740}, "beech", "");
    for (int i = 0; i < 4; i++) {
        int x = i & 1 ? 1080 : -1120, y = i & 2 ? 430 : -470;
        box((Box3){x, y, 0, x + 40, y + 40, 700}, "steel", "top bottom");
    }
    end();
    begin_model("sofa", "");  // faces -y
    box((Box3){-850, -400, 80, 850, 200, 420}, "fabric", "bottom");
    box((Box3){-850, 200, 80, 850, 400, 820}, "fabric", "bottom");
    box((Box3){-1000, -400, 80, -850, 400, 600}, "fabric", "");
    box((Box3){850, -400, 80, 1000, 400, 600}, "fabric", "");
    end();
    begin_model("plant", "");
    cylinder(0, 0, 0, 380, 190, 8, "clay");
    for (int i = 0; i < 6; i++) {
        static const int TIP[6][2] = {{380, 0},  {190, 330},   {-190, 330},
                                      {-380, 0}, {-190, -330}, {190, -330}};
        printf("  poly green 0,0,0.38 %.3f,%.3f,%.3f %.3f,%.3f,1.25\n", TIP[i][0] / 1e3, TIP[i][1] / 1e3,
               0.85 + 0.05 * (i % 3), TIP[i][0] / 2e3, TIP[i][1] / 2e3);
        models[model_count - 1].polygons++;
    }
    end();
    begin_model("bin", "");
    cylinder(0, 0, 0, 320, 140, 8, "black");
    end();
    begin_model("copier", "");
    box((Box3){-350, -300, 0, 350, 300, 900}, "drawer", "bottom");
    box((Box3){-300, -250, 900, 250, 250, 1080}, "black", "bottom");
    box((Box3){-330, -310, 100, 330, -300, 420}, "steel", "back");
    box((Box3){-330, -310, 480, 330, -300, 780}, "steel", "back");
    end();
    begin_model("board", "");  // hangs at its +y
    box((Box3){-900, -30, 0, 900, 0, 1100}, "white", "");
    box((Box3){-880, -90, -30, 880, 0, 0}, "steel", "");
    end();
}

static void office_materials(void) {
    printf(
        "material white #F2F1EC\nmaterial cream #EADFC6\nmaterial sage #C9D3BE\nmaterial mist #C8D4DC\n"
        "material carpet #6D7480\nmaterial lino #B9B4A6\nmaterial beech #C9A374\nmaterial steel #9AA0A6\n"
        "material drawer #C3C7CB\nmaterial black #2B2C2F\nmaterial glass #3C4A57\nmaterial fabric #3F5C86\n"
        "material red #9C3B34\nmaterial blue #3B5A8C\nmaterial green #4E7A44\nmaterial clay #A8644A\n"
        "material door #A97B4F\nmaterial grass #6F8F4E\nmaterial facade #B8AFA2\n"
        "material lamp #FFFFFF emission 35\n\nground grass height -0.1\nfacade facade\n");
}

// Whether furniture of half-width `half` at x on the corridor's wall leaves the door free.
static bool beside_door(const Room *r, int x, int half) { return abs(x - r->door) > half + 600; }

static void put_desk(Office *o, int x, int y, int angle) {
    // Local offsets turned by quarter turns: (dx, dy) in the desk's frame.
    int c = angle == 0 ? 1 : angle == 180 ? -1 : 0, s = angle == 90 ? 1 : angle == 270 ? -1 : 0;
    place_model(o, "desk", x, y, angle);
    place_model(o, "pedestal", x + c * 400, y + s * 400, angle);
    put_raised(o, "screen", x - s * 150, y + c * 150, 740, angle);
    put_raised(o, "keyboard", x + s * 120, y - c * 120, 740, angle);
    place_model(o, "chair", x + s * 720, y - c * 720, angle + pick(o, -25, 25));
}

// Along the corridor's wall and the far corners, where nothing else stands.
static void fill_up(Office *o, int w, int d, int goal) {
    static const char *const ALONG[4] = {"cabinet", "shelf", "cabinet", "locker"};
    for (int x = 550; x + 500 < w && o->furniture < goal; x += 980)
        if (beside_door(&o->room, x, 470)) place_model(o, ALONG[pick(o, 0, 3)], x, 260, 180);
    if (o->furniture < goal && !o->room.right_door) place_model(o, "shelf", w - 200, 1750, 270);
    if (o->furniture < goal) place_model(o, "plant", w - 400, d - 420, pick(o, 0, 59));
    if (o->furniture < goal) place_model(o, "bin", 250, d - 250, 0);
}

static void work_room(Office *o, int w, int d, int goal) {
    int across = (w - 500) / 1700;
    for (int i = 0; i < across && o->furniture < goal; i++)
        put_desk(o, w * (2 * i + 1) / (2 * across), d - 420, 0);
    if (o->furniture < goal && !o->room.left_door && o->room.door > 1600) put_desk(o, 420, 1800, 90);
    fill_up(o, w, d, goal);
}

static void meeting_room(Office *o, int w, int d, int goal) {
    int x = w / 2, y = d / 2 + 250;
    place_model(o, "table", x, y, 0);
    for (int i = 0; i < 3; i++) {
        place_model(o, "chair", x - 750 + 750 * i, y - 800, pick(o, -12, 12));
        place_model(o, "chair", x - 750 + 750 * i, y + 800, 180 + pick(o, -12, 12));
    }
    put_raised(o, "board", w / 2, d - 10, 900, 0);
    fill_up(o, w, d, goal);
}

static void archive_room(Office *o, int w, int d, int goal) {
    for (int x = 700; x + 600 < w && o->furniture < goal; x += 950) {
        place_model(o, "shelf", x, d - 170, 0);
        if (o->furniture < goal) place_model(o, "shelf", x, d - 1500, 0);
    }
    place_model(o, "copier", w - 500, 1900, 270);
    fill_up(o, w, d, goal);
}

static void lounge(Office *o, int w, int d, int goal) {
    place_model(o, "sofa", w / 2, d - 450, 0);
    place_model(o, "sofa", w - 500, d - 2000, 270);
    place_model(o, "table", w / 2 - 400, d - 2000, 90);
    place_model(o, "plant", 450, d - 450, 10);
    for (int i = 0; i < 3; i++)
        place_model(o, "chair", w / 2 - 1250, d - 2700 + 700 * i, 270 + pick(o, -15, 15));
    fill_up(o, w, d, goal);
}

static void lamp(int x, int y, int half_x, int half_y) {
    printf("inlay lamp ceiling %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f\n", (x - half_x) / 1e3,
           (y - half_y) / 1e3, (x + half_x) / 1e3, (y - half_y) / 1e3, (x + half_x) / 1e3, (y + half_y) / 1e3,
           (x - half_x) / 1e3, (y + half_y) / 1e3);
}

static void write_room(const char *name, int index, const Room *r, const char *floor, const char *walls) {
    printf("\nroom %s-%d %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f floor %s ceiling white walls %s wall %.2f\n",
           name, index, r->x0 / 1e3, r->y0 / 1e3, r->x1 / 1e3, r->y0 / 1e3, r->x1 / 1e3, r->y1 / 1e3,
           r->x0 / 1e3, r->y1 / 1e3, floor, walls, WALL / 1e3);
}

static void office_room(Office *o, int index) {
    static const char *const WALLS[4] = {"white", "cream", "sage", "mist"};
    static const char *const NAMES[4] = {"office", "meeting", "archive", "lounge"};
    Room *r = &o->room;
    int w = r->x1 - r->x0, d = r->y1 - r->y0, kind = pick(o, 0, 9);
    kind = kind < 7 ? 0 : kind - 6;
    write_room(NAMES[kind], index, r, kind == 2 ? "lino" : "carpet", WALLS[pick(o, 0, 3)]);
    lamp((r->x0 + r->x1) / 2, (r->y0 + r->y1) / 2, 600, 300);
    int x = r->upper ? r->x0 + r->door : r->x1 - r->door, y = r->upper ? r->y0 - WALL / 2 : r->y1 + WALL / 2;
    // The leaf opens into the room, which lies above the wall or below it.
    bool left = chance(o, 50);
    printf("door d%d %.3f,%.3f width 0.9 height 2.1 hinge %s swing %d material door\n", index, x / 1e3,
           y / 1e3, left ? "left" : "right", left == r->upper ? 88 : -88);
    int goal = (int)((long)TARGET * (index + 1) / ROOMS);
    if (kind == 0) work_room(o, w, d, goal);
    if (kind == 1) meeting_room(o, w, d, goal);
    if (kind == 2) archive_room(o, w, d, goal);
    if (kind == 3) lounge(o, w, d, goal);
}

// Cuts `length` into ROW widths with walls between.
static void cut_row(Office *o, int length, int *width) {
    int left = length - (ROW - 1) * WALL;
    for (int i = 0; i < ROW; i++) {
        int others = ROW - 1 - i;
        int low = left - others * WIDEST > NARROWEST ? left - others * WIDEST : NARROWEST;
        int high = left - others * NARROWEST < WIDEST ? left - others * NARROWEST : WIDEST;
        // Near the mean, so that the last room of a row is like the others.
        int mean = left / (others + 1);
        if (low < mean - 600) low = mean - 600;
        if (high > mean + 600) high = mean + 600;
        width[i] = others ? low + (high - low) / GRAIN * pick(o, 0, 20) * GRAIN / 20 : left;
        left -= width[i];
    }
}

static void side_door(int index, int x, const Room *r) {
    int y = r->upper ? r->y0 + 900 : r->y1 - 900;
    printf("door s%d %.3f,%.3f angle 90 width 0.8 height 2.1 hinge left swing 85 material door\n", index,
           x / 1e3, y / 1e3);
}

static void facade_windows(const Room *r, int index, bool bottom, bool top, bool left, bool right) {
    double x = (r->x0 + r->x1) / 2e3, y = (r->y0 + r->y1) / 2e3;
    const char *form = "window w%d%c %.3f,%.3f%s width 1.8 sill 0.9 height 1.3 material white\n";
    if (bottom) printf(form, index, 's', x, (r->y0 - WALL / 2) / 1e3, "");
    if (top) printf(form, index, 'n', x, (r->y1 + WALL / 2) / 1e3, "");
    if (left) printf(form, index, 'w', (r->x0 - WALL / 2) / 1e3, y, " angle 90");
    if (right) printf(form, index, 'e', (r->x1 + WALL / 2) / 1e3, y, " angle 90");
}

// One row of rooms from x0 to x1 (mm); `bottom`, `top`: its long side is the facade's.
static void office_row(Office *o, int *index, int x0, int x1, int y0, int y1, bool upper, bool bottom,
                       bool top) {
    int width[ROW], x = x0;
    bool joined = false;
    cut_row(o, x1 - x0, width);
    for (int i = 0; i < ROW; i++) {
        bool next = i + 1 < ROW && !joined && chance(o, 25);
        Room r = {.x0 = x, .y0 = y0, .x1 = x + width[i], .y1 = y1, .upper = upper};
        r.left_door = upper ? joined : next;
        r.right_door = upper ? next : joined;
        r.door = pick_size(o, 900, width[i] - 900);
        o->room = r;
        office_room(o, *index);
        if (next) side_door(*index, r.x1 + WALL / 2, &r);
        facade_windows(&r, *index, bottom, top, i == 0 && x0 == 0 && chance(o, 60),
                       i == ROW - 1 && x1 == LENGTH && chance(o, 60));
        joined = next;
        x += width[i] + WALL;
        ++*index;
    }
}

static void corridor_things(Office *o, int wing, int y0) {
    Room r = {0, y0, LENGTH, y0 + CORRIDOR, true, 0, false, false};
    o->room = r;
    write_room("corridor", wing, &r, "lino", "white");
    for (int x = 2000; x < LENGTH; x += 4000) lamp(x, y0 + CORRIDOR / 2, 600, 150);
    place_model(o, "plant", 350, 400, 0);
    place_model(o, "plant", LENGTH - 350, CORRIDOR - 400, 30);
    if (wing == 0 || wing == WINGS - 1) {
        bool west = wing == 0;
        printf("door entrance-%d %.3f,%.3f angle 90 width 1.6 height 2.2 hinge both swing %d glazed material "
               "steel\n",
               wing, (west ? -WALL / 2 : LENGTH + WALL / 2) / 1e3, (y0 + CORRIDOR / 2) / 1e3,
               west ? -85 : 85);
    }
}

static void connector(int wing, int y0, int y1, bool east) {
    Room r = {east ? LENGTH - CORRIDOR : 0, y0, east ? LENGTH : CORRIDOR, y1, true, 0, false, false};
    write_room("link", wing, &r, "lino", "white");
    int x = (r.x0 + r.x1) / 2;
    lamp(x, (y0 + y1) / 2, 150, 600);
    printf("door fire-%da %.3f,%.3f width 1.6 height 2.1 hinge both swing 88 material steel\n", wing, x / 1e3,
           (y0 - WALL / 2) / 1e3);
    printf("door fire-%db %.3f,%.3f width 1.6 height 2.1 hinge both swing -88 material steel\n", wing,
           x / 1e3, (y1 + WALL / 2) / 1e3);
}

static void office(uint64_t seed) {
    Office o = {.random = {seed}};
    printf(
        "# office: %d rooms along corridors. Made by maps/buildings/generate.c with seed %llu.\nplan 1\n\n",
        ROOMS, (unsigned long long)seed);
    office_materials();
    desk_models();
    storage_models();
    other_models();
    printf("\nstorey office floor 0 height 2.8\n");
    int y = 0, index = 0;
    for (int wing = 0; wing < WINGS; wing++) {
        int lower = pick_size(&o, SHALLOW, DEEP), upper = pick_size(&o, SHALLOW, DEEP);
        int corridor = y + lower + WALL, top = corridor + CORRIDOR + WALL, cut = CORRIDOR + WALL;
        bool from_east = (wing - 1) % 2 == 0, to_east = wing % 2 == 0, first = wing == 0,
             last = wing == WINGS - 1;
        // Links to the wing below and above take the ends of the rows.
        office_row(&o, &index, !first && !from_east ? cut : 0, !first && from_east ? LENGTH - cut : LENGTH, y,
                   y + lower, false, first, false);
        corridor_things(&o, wing, corridor);
        office_row(&o, &index, !last && !to_east ? cut : 0, !last && to_east ? LENGTH - cut : LENGTH, top,
                   top + upper, true, false, last);
        y = top + upper + WALL;
        if (last) break;
        // The link reaches from this corridor's wall to the next's: its length needs the next row's depth, which
        // the generator draws ahead.
        Random ahead = o.random;
        int next = pick_size(&o, SHALLOW, DEEP);
        o.random = ahead;
        connector(wing, top, y + next, to_east);
    }
    // The walls of the first corridor stand below 5.15 m and above 6.15 m with every seed.
    printf(
        "\nview corridor 1,5.5,1.6 yaw 0 pitch -3\nview room 2,2,1.6 yaw 60 pitch -8\nstart 3,5.5 yaw 0\n");
}

int main(int argc, char **argv) {
    char *rest = "x";
    errno = 0;
    unsigned long long seed = argc == 3 ? strtoull(argv[2], &rest, 10) : 0;
    bool plain = argc == 3 && strcmp(argv[1], "office-plain") == 0,
         full = argc == 3 && strcmp(argv[1], "office") == 0;
    int count = 0, end = 0;
    bool in_line = argc == 3 && sscanf(argv[1], "enfilade-%d%n", &count, &end) == 1 && !argv[1][end];
    bool many = in_line || (argc == 3 && sscanf(argv[1], "rooms-%d%n", &count, &end) == 1 && !argv[1][end]);
    if (many && (count < 1 || count > 100000)) many = false;
    bool good = argc == 3 && !*rest && !errno && argv[2][0] != '-' && argv[2][0];
    bool large = good && !plain && !full && !many && campus_write(argv[1], seed);
    if (!good || (!plain && !full && !many && !large)) {
        fprintf(stderr, "usage: generate "
                        "office|office-plain|rooms-N|enfilade-N|campus-N|corridor-N|atrium-N|glass-N SEED "
                        "(whole numbers; N up to 100000)\n");
        return 2;
    }
    if (plain) office_plain();
    if (full) office(seed);
    if (many) rooms(count, in_line ? 0 : FARTHEST_ASIDE, seed);
    if (fflush(stdout) != 0 || ferror(stdout)) {
        perror("generate: standard output");
        return 1;
    }
    return 0;
}
