// test_enclose_homes.c - real homes, offices and towers are enclosed.
#include <criterion/criterion.h>
#include <math.h>
#include <string.h>

#include "engine/core/random.h"
#include "tests/support/draft_fixture.h"
#include "tests/support/support.h"

// ---- real homes

typedef struct Expected {
    const char *file;
    int faces, joined;
} Expected;

// Proves on our three homes, and on real ones where they are there, that at least as many rooms are found and doors join as a
// survey of them found, that doors which lead nowhere say why, and that at most 2 % of the drawn area is lost. Named terraces count
// as faces here, though they are not indoors: only the house with a basement needs that (12 rooms and a terrace for the survey's 13
// faces; the survey does not say which it counted).
Test(enclose, real_homes) {
    static const Expected homes[] = {{"build/maps/flat.Home.xml", 8, 7},
                                     {"build/maps/hillside.sh3d", 13, 10},
                                     {"build/maps/villa.sh3d", 8, 7},
                                     {"Studio.Home.xml", 3, 2},
                                     {"2-BedroomApartment.sh3d", 7, 7},
                                     {"3BedroomApartment.Home.xml", 9, 9},
                                     {"2BedroomHouseWithBasement.Home.xml", 13, 10},
                                     {"4-BedroomHouse.sh3d", 10, 8},
                                     {"rtreffer_home.Home.xml", 8, 0}};
    for (size_t i = 0; i < sizeof homes / sizeof *homes; i++) {
        Draft d = {.turn = 0};
        Error error = {""};
        bool ours = strchr(homes[i].file, '/');
        char *name = arena_format(&d.arena, "sh3d/%s", homes[i].file);
        if (!ours && !support_has_shared(name)) continue;
        const char *path = ours ? homes[i].file : support_shared(name);
        cr_assert(maps_read(path, &d.arena, &d.b, &error), "%s", error.text);
        draft_expect_sound(&d, homes[i].file);
        int joined = 0;
        for (int k = 0; k < d.b.opening_count; k++) {
            const Opening *o = &d.b.openings[k];
            joined += o->kind != OPENING_WINDOW && draft_joins(&d, k, REGION_ROOM, REGION_ROOM);
            cr_expect((o->region[0] >= 0 && o->region[1] >= 0) || o->reason);
        }
        int faces = draft_count_kind(&d, REGION_ROOM);
        cr_expect_geq(faces, homes[i].faces, "%s: %d", homes[i].file, faces);
        cr_expect_geq(joined, homes[i].joined, "%s: %d", homes[i].file, joined);
        cr_expect_leq(d.b.lost_area, 0.02 * d.b.drawn_area, "%s", homes[i].file);
        draft_free(&d);
    }
}

// Proves that a large plan comes out whole: an office of 72 rooms, 162 walls and 126 doors, each joining two rooms.
Test(enclose, office) {
    Draft d = draft_new(1);
    int nx = 12, ny = 6;
    for (int i = 0; i <= nx; i++) {
        for (int j = 0; j < ny; j++)
            draft_wall(&d, 0, 4.0 * i, 4.0 * j, 4.0 * i, 4.0 * (j + 1), 0.1, DRAFT_HEIGHT);
    }
    for (int j = 0; j <= ny; j++) {
        for (int i = 0; i < nx; i++)
            draft_wall(&d, 0, 4.0 * i, 4.0 * j, 4.0 * (i + 1), 4.0 * j, 0.1, DRAFT_HEIGHT);
    }
    for (int i = 0; i < nx; i++) {
        for (int j = 0; j < ny; j++) {
            draft_room(&d, 0, 4 * i + 0.05, 4 * j + 0.05, 4 * i + 3.95, 4 * j + 3.95);
            if (i) draft_opening(&d, OPENING_DOOR, 0, 4 * i, 4 * j + 2, M_PI / 2, 0.9, 0.1);
            if (j) draft_opening(&d, OPENING_DOOR, 0, 4 * i + 1.3, 4 * j, 0, 0.9, 0.1);
        }
    }
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), nx * ny);
    for (int k = 0; k < d.b.opening_count; k++) cr_expect(draft_joins(&d, k, REGION_ROOM, REGION_ROOM));
    draft_free(&d);
}

// Proves that no room of a tower is lost to the limit of crossings: storeys of the same outlines, and storeys whose inner walls stand
// one centimetre farther each, so that thousands of corners lie on the edges of other storeys.
Test(enclose, towers_keep_their_rooms) {
    enum { STOREYS = 20, SIDE = 8 };
    for (int farther = 0; farther < 2; farther++) {
        Draft d = draft_new(STOREYS);
        for (int k = 0; k < STOREYS; k++) {
            for (int i = 0; i < SIDE * SIDE; i++) {
                double x = 4 * (i % SIDE), y = 4 * (i / SIDE), by = farther * 0.01 * k;
                draft_room(&d, k, x + (i % SIDE ? by : 0), y, x + 3.8 + (i % SIDE < SIDE - 1 ? by : 0),
                           y + 3.8);
                d.s.rooms[d.s.room_count - 1].wall = 0.1;
            }
        }
        draft_enclose(&d);
        cr_expect_eq(draft_count_kind(&d, REGION_ROOM), STOREYS * SIDE * SIDE);
        cr_expect_eq(draft_count_notes(&d, NOTE_DROPPED), 0);
        draft_free(&d);
    }
}

// A comb of teeth `pitch` apart along x (or y), each reaching across the others of a crossing comb.
static int comb(Vec2 *out, int teeth, double pitch, bool upright) {
    int count = 0;
    double far = teeth * pitch;
    out[count++] = vec2(-1, -1);
    for (int i = 0; i < teeth; i++) {
        out[count++] = vec2(i * pitch, -1);
        out[count++] = vec2(i * pitch, far);
        out[count++] = vec2((i + 0.5) * pitch, far);
        out[count++] = vec2((i + 0.5) * pitch, -1);
    }
    out[count++] = vec2(far, -1);
    out[count++] = vec2(far, -2);
    out[count++] = vec2(-1, -2);
    for (int i = 0; i < count && !upright; i++) out[i] = vec2(out[i].y, out[i].x);
    return count;
}

// Proves that of outlines that cross at more than 10,000 places those are left out that come too late, whatever they are, each by its
// name and where it begins, and that later ones which cross nothing are there.
Test(enclose, crossing_outlines_have_a_limit) {
    enum { TEETH = 46, MOST = 4 * TEETH + 4 };  // two combs cross at 4 * 46 * 46 = 8,464 places
    for (int kind = 0; kind < 2; kind++) {
        Draft d = draft_new(2);
        Vec2 p[MOST];
        for (int k = 0; k < 2; k++) draft_room(&d, k, -3, -3, 12, 12);
        for (int i = 0; i < 3; i++) {
            int count = comb(p, TEETH, 0.2, i != 1);
            for (int n = 0; i == 2 && n < count; n++) p[n] = vec2(p[n].x + 0.05, p[n].y + 0.05);
            if (kind == 0) {
                draft_room_shape(&d, 1, p, count);
                d.s.rooms[d.s.room_count - 1].place = arena_format(&d.arena, "comb-%d", i);
            } else {
                int first = draft_points(&d, p, count, true);
                draft_cutout(&d, 1, 0, 0, 1, 1);
                d.s.cutouts[i] = (SketchCutout){1, first, count, arena_format(&d.arena, "comb-%d", i)};
            }
        }
        draft_cutout(&d, 1, 10.5, 10.5, 11, 11);
        draft_room(&d, 1, 13, 13, 15, 15);
        draft_enclose(&d);
        int notes = 0;
        for (int i = 0; i < d.b.note_count; i++) {
            const Note *note = &d.b.notes[i];
            if (!strstr(note->text, "too many")) continue;
            notes++;
            cr_expect(strstr(note->text, kind ? "cut-out comb-2 left out" : "room comb-2 left out"), "%s",
                      note->text);
            cr_expect_float_eq(note->place.x, -0.95, 1e-6, "%g", note->place.x);
        }
        cr_expect_eq(notes, 1, "%d", notes);
        cr_expect_eq(draft_kind_at(&d, 10.7, 10.7, DRAFT_HEIGHT + 0.1), REGION_SHAFT);
        cr_expect_eq(draft_kind_at(&d, 14, 14, DRAFT_HEIGHT + 1), REGION_ROOM);
        draft_free(&d);
    }
}

// Proves that an outline whose corner touches its own edge does not cross itself, wherever it begins and either way round, and that
// one which goes through does.
Test(enclose, touching_is_not_crossing) {
    enum { COUNT = 7 };
    for (int deep = 0; deep < 3; deep++) {
        // The notch from above ends above the lower edge, on it, below it.
        Vec2 shape[COUNT] = {{0, 0}, {6, 0}, {6, 4}, {4, 4}, {3, deep == 0 ? 0.5 : deep == 1 ? 0 : -0.5},
                             {2, 4}, {0, 4}};
        for (int first = 0; first < COUNT; first++) {
            for (int back = 0; back < 2; back++) {
                for (int turned = 0; turned < 2; turned++) {
                    Draft d = draft_new(1);
                    Vec2 p[COUNT];
                    for (int i = 0; i < COUNT; i++) {
                        Vec2 q = shape[(first + (back ? COUNT - i : i)) % COUNT];
                        p[i] = turned ? vec2(-q.y, q.x) : q;
                    }
                    draft_room_shape(&d, 0, p, COUNT);
                    d.s.rooms[0].wall = 0.1;
                    Error error = {""};
                    cr_assert(maps_enclose(&d.s, &d.b, &d.arena, &error), "%s", error.text);
                    int notes = 0;
                    for (int i = 0; i < d.b.note_count; i++)
                        notes += strstr(d.b.notes[i].text, "crosses itself") != NULL;
                    cr_expect_eq(notes, deep == 2, "%d notes of an outline from corner %d, notch %d", notes,
                                 first, deep);
                    draft_free(&d);
                }
            }
        }
    }
}
