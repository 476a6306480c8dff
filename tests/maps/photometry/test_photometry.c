// test_photometry.c - photometric files: every form of a table is the same table, flux is its integral, factors multiply, and faults are
// told with their line.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/random.h"
#include "maps/photometry/photometry_file.h"
#include "tests/support/files/tables.h"

static bool read_text(Arena *arena, const char *name, const char *text, Photometry *out, Error *error) {
    char *copy = arena_string(arena, text);
    return photometry_read(name, (Bytes){(unsigned char *)copy, strlen(text)}, arena, out, error);
}

static Photometry read_good(Arena *arena, const char *text) {
    Photometry table;
    Error error = {""};
    cr_assert(read_text(arena, "t", text, &table, &error), "%s", error.text);
    return table;
}

// Both formats, and every way to list the planes of a table with its symmetry: the first lists all planes.
static int forms_of(Arena *arena, Table table, double step, char *out[10]) {
    static const Vec2 OPENING = {0.3, 0.6};
    int count = 0;
    for (int ldt = 0; ldt < 2; ldt++) {
        for (Listed l = LISTED_ALL; l <= LISTED_ONE; l++) {
            Listed fewest = tables_fewest(table);
            bool fits = l == LISTED_ALL || l == fewest || fewest == LISTED_ONE ||
                        (fewest == LISTED_QUARTER && l != LISTED_ONE);
            if (!fits) continue;
            out[count++] = (ldt ? tables_ldt : tables_ies)(arena, table, l, step, OPENING);
        }
    }
    return count;
}

// Proves that symmetry is completed as the formats say, in both alike, and angles are found: at random directions every form has the same
// intensity, at the table's own directions the formula's. Tolerance: files have nine digits.
Test(photometry, forms_agree) {
    for (Table t = 0; t < TABLES; t++) {
        Arena arena = {0};
        Random random = {t + 1};
        char *text[10];
        int count = forms_of(&arena, t, 7.5, text);
        cr_assert_gt(count, 1);
        Photometry first = read_good(&arena, text[0]);
        cr_expect(fabs(first.size[0] - 0.3) < 1e-12 && fabs(first.size[1] - 0.6) < 1e-12);
        for (int i = 0; i < count; i++) {
            Photometry table = read_good(&arena, text[i]);
            cr_expect(fabs(photometry_lumens(&table) / photometry_lumens(&first) - 1) < 1e-8,
                      "table %d, form %d", t, i);
            cr_expect(table.size[0] == first.size[0] && table.size[1] == first.size[1]);
            for (int k = 0; k < 300; k++) {
                double gamma = 180 * random_unit(&random), plane = 720 * random_unit(&random) - 360;
                double here = photometry_candela(&table, gamma, plane),
                       there = photometry_candela(&first, gamma, plane);
                cr_assert(fabs(here - there) <= 1e-8 * fmax(there, 1),
                          "table %d, form %d at %g, %g: %g, not %g", t, i, gamma, plane, here, there);
                gamma = 7.5 * floor(gamma / 7.5), plane = 7.5 * floor(plane / 7.5);
                if (gamma > first.gamma[first.gamma_count - 1]) continue;
                double formula = tables_candela(t, gamma, plane);
                here = photometry_candela(&table, gamma, plane);
                cr_assert(fabs(here - formula) <= 1e-8 * fmax(formula, 1),
                          "table %d, form %d at %g, %g: %g, not %g", t, i, gamma, plane, here, formula);
            }
        }
        arena_free(&arena);
    }
}

// Proves that flux is the integral of the table as it is, linear between its angles: 4 pi of an even candela, and the closed form of
// 100 (1 - gamma / 90) cd, 2 pi 100 (1 - 2 / pi), however coarse the table is; and that each side has its own, by sums over directions.
Test(photometry, flux_is_the_integral) {
    Arena arena = {0};
    Photometry even = read_good(&arena, "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 0\n0 180\n0\n1 1\n");
    cr_expect(fabs(photometry_lumens(&even) / (4 * M_PI) - 1) < 1e-12);
    cr_expect(fabs(even.lumens[PHOTOMETRY_ABOVE] / (2 * M_PI) - 1) < 1e-12);
    Photometry cone =
        read_good(&arena, "TILT=NONE\n1 -1 1 3 2 1 2 0 0 0 1 1 0\n0 30 90\n0 90\n100 66.66666666666667 0\n"
                          "100 66.66666666666667 0\n");
    cr_expect(fabs(photometry_lumens(&cone) / (200 * M_PI * (1 - 2 / M_PI)) - 1) < 1e-12);
    cr_expect_eq(cone.lumens[PHOTOMETRY_ABOVE], 0);
    for (Table t = 0; t < TABLES; t++) {
        enum { STEPS = 400 };
        Photometry table = read_good(&arena, tables_ies(&arena, t, LISTED_ALL, 15, vec2(0, 0)));
        double sum[2] = {0, 0};
        for (int i = 0; i < STEPS; i++)
            for (int k = 0; k < STEPS; k++) {
                double gamma = 180 * (i + 0.5) / STEPS,
                       ring = cos(M_PI * i / STEPS) - cos(M_PI * (i + 1) / STEPS);
                sum[gamma > 90] +=
                    photometry_candela(&table, gamma, 360 * (k + 0.5) / STEPS) * ring * 2 * M_PI / STEPS;
            }
        // Tolerance: the middle of a step of 0.45 degrees stands for all of it, 2e-5 of a parabola; of kinks no more.
        for (int side = 0; side < 2; side++)
            cr_expect(fabs(sum[side] - table.lumens[side]) < 1e-4 * photometry_lumens(&table),
                      "table %d, side %d: %g, not %g", t, side, table.lumens[side], sum[side]);
        for (int side = 0; side < 2; side++) {
            // A share of the face's flux leaves in all directions together.
            LampSpread spread = {&table, 0.3, side};
            double all = 0;
            for (int i = 0; i < STEPS * STEPS && table.lumens[side] > 0; i++) {
                double z = 2 * (i / STEPS + 0.5) / STEPS - 1, turn = 2 * M_PI * (i % STEPS + 0.5) / STEPS,
                       r = sqrt(1 - z * z);
                all +=
                    spread_share(&spread, vec3(r * cos(turn), r * sin(turn), z)) * 4 * M_PI / (STEPS * STEPS);
            }
            if (table.lumens[side] > 0)
                cr_expect(fabs(all - 1) < 2e-3, "table %d, side %d: %g", t, side, all);
        }
    }
    arena_free(&arena);
}

// Proves which factors multiply, and how lengths are told.
Test(photometry, factors_and_lengths) {
    Arena arena = {0};
    static const char *const NUMBERS = "2 1000 3 2 1 1 %d %s 0 0.5 0.9 10 0 90 0 10 10";
    char text[256];
    static const struct {
        const char *first, *lengths;
        int unit;
        double candela, along_c0, along_c90;
    } CASES[] = {{"IESNA:LM-63-1995\nTILT=NONE\n", "0.2 0.4", 2, 13.5, 0.4, 0.2},
                 {"IESNA91\n[TEST]\nTILT=NONE\n", "1 2", 1, 13.5, 0.6096, 0.3048},
                 {"a lamp of 1986\nTILT=NONE\n", "0 0", 2, 13.5, 0, 0},
                 {"IESNA:LM-63-2002\nTILT=NONE\n", "-0.2 -0.2", 2, 15, 0.17724538509, 0.17724538509},
                 {"IES:LM-63-2019\nTILT=NONE\n", "-0.2 0", 2, 15, 0.17724538509, 0.17724538509},
                 {"IESNA:LM-63-2002\nTILT=INCLUDE\n1 3\n0,45,90\n0.8,0.7,0.6\n", "0 0", 2, 12, 0, 0}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        int used = snprintf(text, sizeof text, "%s", CASES[i].first);
        snprintf(text + used, sizeof text - (size_t)used, NUMBERS, CASES[i].unit, CASES[i].lengths);
        Photometry t = read_good(&arena, text);
        cr_expect(fabs(photometry_candela(&t, 45, 123) - CASES[i].candela) < 1e-12, "case %zu: %g", i,
                  photometry_candela(&t, 45, 123));
        cr_expect(fabs(t.size[0] - CASES[i].along_c0) < 1e-9 && fabs(t.size[1] - CASES[i].along_c90) < 1e-9,
                  "case %zu: %g x %g", i, t.size[0], t.size[1]);
    }
    // EULUMDAT: commas, absolute photometry (a negative number of lamps), a conversion factor, and a second set that does not count.
    Photometry t = read_good(
        &arena,
        "x\r\n1\r\n1\r\n1\r\n0\r\n2\r\n90\r\n\r\n\r\n\r\n\r\n\r\n0\r\n0\r\n0\r\n1200\r\n100\r\n0\r\n0\r\n"
        "0\r\n0\r\n100\r\n80\r\n0,5\r\n0\r\n2\r\n-1\r\nled\r\n4000\r\n3000\r\n80\r\n9\r\n1\r\nother\r\n"
        "7\r\n3000\r\n80\r\n9\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n90\r\n7,5\r\n7,"
        "5\r\n");
    cr_expect_eq(photometry_candela(&t, 10, 0), 7.5 * 4 * 0.5);
    cr_expect(t.size[0] == 0.1 && t.size[1] == 1.2 && t.stated == 3200);
    arena_free(&arena);
}

// Proves that each fault is refused with the file, its line, the text found and the text allowed.
Test(photometry, faults) {
    static const struct {
        const char *text, *expected;
    } CASES[] = {
        {"TILT=FILE.TLT\n1 1 1 2 1 1 2 0 0 0 1 1 0 0 90 0 1 1",
         "t:1: TILT is `FILE.TLT` (allowed: NONE, INCLUDE)"},
        {"TILT=NONE\n1 1 1 2 1 2 2 0 0 0 1 1 0 0 90 0 1 1",
         "t:2: the photometry is of type B, 2 (allowed: type C, 1)"},
        {"TILT=NONE\n1 1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1",
         "t:6: an intensity is `the end of the line` (allowed 0 to 1e+09)"},
        {"TILT=NONE\n1 1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1 -1",
         "t:6: an intensity is `-1` (allowed 0 to 1e+09)"},
        {"TILT=NONE\n1 1 1 2 1 1 2 0 0 0\n1 1 0\n90 0\n0\n1 1",
         "t:4: a vertical angle is `0` after 90 (allowed: above that)"},
        {"TILT=NONE\n1 1 1 2 2 1 2 0 0 0\n1 1 0\n0 90\n0 45\n1 1 1 1",
         "the horizontal angles go from 0 to 45 (allowed: 0 alone, 0 to 90"},
        {"TILT=NONE\n1 1 1 2.5 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1 1",
         "t:2: the number of vertical angles is `2.5` (allowed: a whole number)"},
        {"TILT=NONE\n1 1 1 1000 1000 1 2 0 0 0\n1 1 0\n0 90\n0\n1 1",
         "1000 by 1000 intensities are more than the file has room for"},
        {"TILT=NONE\n1 1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n0 0",
         "t: its table sends 0 lumens (allowed: above 0)"},
        {"made here\n1\n5\n", "t:3: the symmetry is `5` (allowed 0 to 4)"},
        {"made here\n1\n4\n6\n", "t:5: 6 planes with the symmetry 4 (allowed: a multiple of 4)"},
        {"made here\n1\n1\n1\n0\n2\n90\n", "t:8: the length of the opening is `the end of the line`"},
        {"", "t:1: the type of luminaire is `the end of the line` (allowed 0 to 3)"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Photometry table;
        Error error = {""};
        cr_expect_not(read_text(&arena, "t", CASES[i].text, &table, &error), "case %zu is read", i);
        cr_expect(strstr(error.text, CASES[i].expected), "case %zu says `%s`, not `%s`", i, error.text,
                  CASES[i].expected);
        arena_free(&arena);
    }
}
