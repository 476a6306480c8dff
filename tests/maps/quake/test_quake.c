// test_quake.c - levels of the Quake family: their portals against boxes, their rows there and back.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/maps.h"
#include "tests/support/files/quake_builder.h"
#include "tests/support/support.h"

static void read_built(Arena *arena, const QuakeBuilt *built, QuakeLevel *level) {
    Error error = {""};
    cr_assert(quake_read("t.bsp", built->file, arena, level, &error), "%s", error.text);
}

static void cells_of(Arena *arena, const QuakeLevel *level, bool clear, QuakeCells *cells) {
    Error error = {""};
    cr_assert(quake_cells(level, &(QuakePortals){NULL, clear}, arena, cells, &error), "%s", error.text);
}

// The area in which two boxes touch, square units.
static double touch(const QuakeBuiltLeaf *a, const QuakeBuiltLeaf *b) {
    double area = 1;
    int contacts = 0;
    for (int k = 0; k < 3; k++) {
        int low = a->min[k] > b->min[k] ? a->min[k] : b->min[k],
            high = a->max[k] < b->max[k] ? a->max[k] : b->max[k];
        if (high < low) return 0;
        if (high == low) contacts++;
        if (high > low) area *= high - low;
    }
    return contacts == 1 ? area : 0;
}

static double portal_area(const Building *b, int one, int other) {
    double sum = 0;
    for (int i = 0; i < b->given_portal_count; i++) {
        const GivenPortal *p = &b->given_portals[i];
        bool fits = (p->cell[0] == one && p->cell[1] == other) || (p->cell[0] == other && p->cell[1] == one);
        if (fits) sum += polygon_area(b->vertices + p->first_vertex, p->vertex_count);
    }
    return sum * QUAKE_METRE * QUAKE_METRE;
}

static bool is_sky(const QuakeBuiltLeaf *leaf) { return QUAKE_ROOMS[leaf->from].contents == -6; }
static bool is_water(const QuakeBuiltLeaf *leaf) { return QUAKE_ROOMS[leaf->from].contents == -3; }

// Between any two leaves lie portals of just the area in which their boxes touch, in each format; none to the sky; between water and air
// none either, unless water is clear. They turn counter-clockwise seen from the first cell.
Test(quake, portals_are_where_boxes_touch) {
    for (int f = 0; f <= QUAKE_BSP2; f++) {
        for (int clear = 0; clear < 2; clear++) {
            Arena arena = {0};
            QuakeBuilt built = quake_build(&arena, QUAKE_ROOMS, QUAKE_ROOM_COUNT, &(QuakeStyle){.format = f});
            QuakeLevel level;
            QuakeCells cells;
            read_built(&arena, &built, &level);
            cells_of(&arena, &level, clear, &cells);
            const Building *b = &cells.building;
            cr_assert_eq(b->given_cell_count, built.count);
            for (int i = 0; i < built.count; i++) {
                for (int k = 0; k < i; k++) {
                    const QuakeBuiltLeaf *one = &built.leaves[i], *other = &built.leaves[k];
                    double expected = touch(one, other);
                    if (is_sky(one) || is_sky(other) || (!clear && is_water(one) != is_water(other)))
                        expected = 0;
                    double area =
                        portal_area(b, cells.cell_of_leaf[one->leaf], cells.cell_of_leaf[other->leaf]);
                    cr_expect_float_eq(area, expected, 1e-6, "%s: %d and %d: %g instead of %g",
                                       QUAKE_FORMAT_NAMES[f], i, k, area, expected);
                }
            }
            for (int i = 0; i < b->given_portal_count; i++) {
                const GivenPortal *p = &b->given_portals[i];
                const Vec3 *v = b->vertices + p->first_vertex;
                Vec3 n = plane_of_polygon(v, p->vertex_count).n, middle = vec3_lerp(v[0], v[2], 0.5);
                int leaf = quake_locate(&level, vec3_add(middle, vec3_scale(n, 0.01)));
                cr_expect_eq(cells.cell_of_leaf[leaf], p->cell[0]);
            }
            arena_free(&arena);
        }
    }
}

// Contents of Quake II: what is translucent or a detail stops no sight, other liquids and windows do at their surfaces.
Test(quake, contents_of_quake_ii) {
    enum { WINDOW = 2, WATER = 32, DETAIL = 0x8000000, TRANSLUCENT = 0x10000000, AREA_PORTAL = 0x8000 };
    static const struct {
        int one, other;
        bool passes, passes_clear;
    } CASES[] = {{0, 0, true, true},
                 {0, WATER, false, true},
                 {0, WATER | TRANSLUCENT, true, true},
                 {WATER, WATER | TRANSLUCENT, true, true},
                 {0, WINDOW, false, false},
                 {0, WINDOW | DETAIL, true, true},
                 {0, AREA_PORTAL, true, true},
                 {0, 1, false, false}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        for (int clear = 0; clear < 2; clear++) {
            Arena arena = {0};
            const QuakeBox boxes[] = {{{0, 0, 0}, {64, 64, 64}, CASES[i].one, NULL},
                                      {{64, 0, 0}, {128, 64, 64}, CASES[i].other, NULL}};
            QuakeBuilt built = quake_build(&arena, boxes, 2, &(QuakeStyle){.format = QUAKE_IBSP38});
            QuakeLevel level;
            QuakeCells cells;
            read_built(&arena, &built, &level);
            cells_of(&arena, &level, clear, &cells);
            cr_expect_eq(cells.building.given_portal_count, clear ? CASES[i].passes_clear : CASES[i].passes,
                         "case %zu", i);
            arena_free(&arena);
        }
    }
}

// A level whose space reaches the border of its faces and beyond is told as open, with a place.
Test(quake, leaks) {
    Arena arena = {0};
    const QuakeBox boxes[] = {{{0, 0, 0}, {64, 64, 64}, 0, NULL}, {{64, 0, 0}, {128, 64, 64}, 0, NULL}};
    QuakeBuilt built = quake_build(&arena, boxes, 2, &(QuakeStyle){.format = QUAKE_29});
    QuakeLevel level;
    QuakeCells cells;
    read_built(&arena, &built, &level);
    cells_of(&arena, &level, false, &cells);
    cr_expect_eq(cells.building.note_count, 0);
    level.box.max.z = -1;  // as if the faces ended far below
    cells_of(&arena, &level, false, &cells);
    cr_expect_eq(cells.building.note_count, 0);
    level.box.max.z = 0.5;
    cells_of(&arena, &level, false, &cells);
    cr_assert_eq(cells.building.note_count, 1);
    cr_expect(strstr(cells.building.notes[0].text, "is open to the void: 1 portals"), "%s",
              cells.building.notes[0].text);
    arena_free(&arena);
}

// ---- rows

// A grid of rooms that do not touch: as many rows as are wanted.
static QuakeBuilt many(Arena *arena, int count, const QuakeStyle *style) {
    QuakeBox *boxes = ARENA_ARRAY(arena, QuakeBox, count);
    for (int i = 0; i < count; i++) {
        int x = i % 40 * 32, y = i / 40 * 32;
        boxes[i] = (QuakeBox){{x, y, 0}, {x + 16, y + 16, 16}, 0, NULL};
    }
    return quake_build(arena, boxes, count, style);
}

static int words_of(const QuakeLevel *level) { return (level->cluster_count + 63) / 64; }

// Rows in which a share of the bits is set.
static uint64_t *random_rows(Arena *arena, const QuakeLevel *level, double share, Random *random) {
    int words = words_of(level), count = level->cluster_count;
    uint64_t *rows = ARENA_ARRAY(arena, uint64_t, count * words);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < count; k++) {
            if (i == k || random_unit(random) < share) rows[i * words + k / 64] |= (uint64_t)1 << (k % 64);
        }
    }
    return rows;
}

// The bytes of a lump of the file, by its number there.
static Bytes lump(const QuakeLevel *level, int number) {
    const unsigned char *entry = level->content.data + QUAKE_LAYOUTS[level->format].header + 8 * number;
    return (Bytes){level->content.data + quake_i32(entry), (size_t)quake_i32(entry + 4)};
}

static void expect_kept(const QuakeLevel *before, const QuakeLevel *after, const char *bspx) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[before->format];
    for (int i = 0; i < layout->lump_count; i++) {
        bool leaves = before->format != QUAKE_IBSP38 && i == layout->lump[QUAKE_LEAVES];
        if (i == layout->lump[QUAKE_VISIBILITY] || leaves) continue;
        Bytes one = lump(before, i), other = lump(after, i);
        cr_expect(one.size == other.size && memcmp(one.data, other.data, one.size) == 0, "lump %d", i);
    }
    if (!bspx) return;
    // It stands where games look: behind the last lump, at a multiple of four.
    size_t last = 0;
    for (int i = 0; i < layout->lump_count; i++) {
        Bytes one = lump(after, i);
        size_t end = (size_t)(one.data - after->content.data) + one.size;
        if (one.size > 0 && end > last) last = end;
    }
    const unsigned char *block = after->content.data + (last + 3) / 4 * 4;
    cr_assert(memcmp(block, "BSPX", 4) == 0);
    cr_expect(memcmp(after->content.data + quake_i32(block + 32), bspx, strlen(bspx)) == 0);
}

// Rows come back as they were written, in all formats, whether the lump before was absent, shorter or longer, in the midst of the
// file or at its end; all other lumps and what is appended stay as they were. 2,100 leaves have runs of more than 255 zero bytes.
Test(quake, rows_there_and_back) {
    Random random = {1};
    static const double SHARES[] = {0, 0.001, 0.3, 1};
    static const char BSPX[] = "seen by nobody but those who look";
    static unsigned char old[200000];
    for (int run = 0; run < QUAKE_FORMATS * 3 * 2 * 2 * 4; run++) {
        Arena arena = {0};
        int size = run / QUAKE_FORMATS % 3, last = run / (QUAKE_FORMATS * 3) % 2,
            bspx = run / (QUAKE_FORMATS * 6) % 2;
        QuakeStyle style = {.format = run % QUAKE_FORMATS,
                            .visibility = {old, size == 0   ? 0
                                                : size == 1 ? 7
                                                            : sizeof old},
                            .last = last,
                            .bspx = bspx ? BSPX : NULL};
        QuakeBuilt built = many(&arena, run % 7 == 0 ? 2100 : 61 + run % 9, &style);
        QuakeLevel before, after;
        read_built(&arena, &built, &before);
        int words = words_of(&before);
        size_t bytes = (size_t)before.cluster_count * (size_t)words * sizeof(uint64_t);
        uint64_t *rows = random_rows(&arena, &before, SHARES[run / (QUAKE_FORMATS * 12)], &random);
        Error error = {""};
        Bytes out;
        cr_assert(quake_with_rows(&before, rows, words, &arena, &out, &error), "%s", error.text);
        cr_assert(quake_read("new.bsp", out, &arena, &after, &error), "%s", error.text);
        uint64_t *again = ARENA_ARRAY(&arena, uint64_t, bytes / sizeof(uint64_t));
        cr_assert(quake_rows(&after, words, again, &error), "%s", error.text);
        cr_expect(memcmp(again, rows, bytes) == 0, "run %d", run);
        expect_kept(&before, &after, style.bspx);
        arena_free(&arena);
    }
}

// In Quake II, what is heard is the union of what is seen from all that is seen: checked bit by bit, from the file.
Test(quake, hearing) {
    Arena arena = {0};
    Random random = {2};
    QuakeBuilt built = many(&arena, 150, &(QuakeStyle){.format = QUAKE_IBSP38});
    QuakeLevel level, after;
    read_built(&arena, &built, &level);
    int words = words_of(&level), count = level.cluster_count;
    uint64_t *rows = random_rows(&arena, &level, 0.01, &random);
    Error error = {""};
    Bytes out;
    cr_assert(quake_with_rows(&level, rows, words, &arena, &out, &error) &&
              quake_read("h.bsp", out, &arena, &after, &error));
    // The places of what is heard stand behind those of what is seen: with these exchanged, the reader reads what is heard.
    unsigned char *places = after.lumps[QUAKE_VISIBILITY].data + 4;
    for (int i = 0; i < count; i++) memcpy(places + 8 * i, places + 8 * i + 4, 4);
    uint64_t *heard = ARENA_ARRAY(&arena, uint64_t, count * words);
    cr_assert(quake_rows(&after, words, heard, &error), "%s", error.text);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < count; k++) {
            bool expected = false;
            for (int via = 0; via < count; via++) {
                bool first = rows[i * words + via / 64] >> (via % 64) & 1;
                expected |= first && (rows[via * words + k / 64] >> (k % 64) & 1);
            }
            cr_expect_eq(heard[i * words + k / 64] >> (k % 64) & 1, expected, "%d hears %d", i, k);
        }
    }
    arena_free(&arena);
}

// A leaf of Quake has the sounds of what it may see, and no other.
Test(quake, sounds) {
    for (int f = 0; f <= QUAKE_BSP2; f++) {
        Arena arena = {0};
        QuakeBuilt built = quake_build(&arena, QUAKE_ROOMS, QUAKE_ROOM_COUNT, &(QuakeStyle){.format = f});
        QuakeLevel level;
        read_built(&arena, &built, &level);
        Random random = {3};
        int words = words_of(&level);
        uint64_t *rows = random_rows(&arena, &level, 0.1, &random);
        Error error = {""};
        Bytes out;
        cr_assert(quake_with_rows(&level, rows, words, &arena, &out, &error));
        const QuakeLayout *layout = &QUAKE_LAYOUTS[f];
        const unsigned char *leaves =
            out.data + quake_i32(out.data + layout->header + 8 * layout->lump[QUAKE_LEAVES]);
        for (int i = 0; i < built.count; i++) {
            bool water = false, sky = false, lava = false;
            int row = built.leaves[i].leaf - 1;
            for (int k = 0; k < built.count; k++) {
                int bit = built.leaves[k].leaf - 1;
                const char *picture = QUAKE_ROOMS[built.leaves[k].from].picture;
                if (!picture || !(rows[row * words + bit / 64] >> (bit % 64) & 1)) continue;
                water |= strcmp(picture, "*water1") == 0;
                sky |= strcmp(picture, "sky1") == 0;
                lava |= strcmp(picture, "*lava1") == 0;
            }
            const unsigned char *sounds = leaves + (row + 1) * layout->record[QUAKE_LEAVES] + layout->sounds;
            cr_expect(sounds[0] == 255 * water && sounds[1] == 255 * sky && sounds[2] == 0 &&
                          sounds[3] == 255 * lava,
                      "leaf %d of %s", row + 1, QUAKE_FORMAT_NAMES[f]);
        }
        arena_free(&arena);
    }
}

// The leaves of one cluster see together what each of them sees, and are seen where one of them is.
Test(quake, rows_of_clusters) {
    Arena arena = {0};
    QuakeBuilt built = quake_build(&arena, QUAKE_ROOMS, QUAKE_ROOM_COUNT,
                                   &(QuakeStyle){.format = QUAKE_IBSP38, .joined = true});
    QuakeLevel level;
    QuakeCells cells;
    read_built(&arena, &built, &level);
    cells_of(&arena, &level, false, &cells);
    int n = cells.building.given_cell_count, cell_words = (n + 63) / 64, words = words_of(&level);
    cr_assert(level.cluster_count == QUAKE_ROOM_COUNT && n > level.cluster_count);
    Random random = {4};
    uint64_t *seen = ARENA_ARRAY(&arena, uint64_t, n * cell_words),
             *rows = ARENA_ARRAY(&arena, uint64_t, level.cluster_count * words);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++)
            if (random_unit(&random) < 0.05) seen[i * cell_words + k / 64] |= (uint64_t)1 << (k % 64);
    }
    quake_rows_of_cells(&level, &cells, seen, cell_words, words, rows);
    for (int a = 0; a < level.cluster_count; a++) {
        for (int b = 0; b < level.cluster_count; b++) {
            bool expected = a == b;
            for (int i = 0; i < level.leaf_count; i++) {
                for (int k = 0; k < level.leaf_count; k++) {
                    if (level.leaves[i].cluster != a || level.leaves[k].cluster != b) continue;
                    int from = cells.cell_of_leaf[i], to = cells.cell_of_leaf[k];
                    expected |= seen[from * cell_words + to / 64] >> (to % 64) & 1;
                }
            }
            cr_expect_eq(rows[a * words + b / 64] >> (b % 64) & 1, expected, "%d sees %d", a, b);
        }
    }
    arena_free(&arena);
}
