// test_seen.c - `.seen` files: what is written is read again, and what is damaged is refused with its reason.
#include <criterion/criterion.h>
#include <unistd.h>

#include "engine/core/random.h"
#include "tests/support/support.h"
#include "visibility/pairs/seen_file.h"

static size_t words_of(int cells) { return ((size_t)cells + 63) / 64; }

static uint64_t *random_rows(Arena *arena, Random *random, int cells) {
    uint64_t *rows = ARENA_ARRAY(arena, uint64_t, (size_t)cells * words_of(cells));
    for (int i = 0; i < cells; i++) {
        for (int j = 0; j < cells; j++) {
            if (i == j || random_index(random, 3) == 0)
                rows[(size_t)i * words_of(cells) + (size_t)j / 64] |= (uint64_t)1 << (j % 64);
        }
    }
    return rows;
}

// Whatever the number of cells, at and around whole bytes and words, the same rows come back.
Test(seen, comes_back_as_it_was) {
    static const int COUNTS[] = {1, 2, 7, 8, 9, 63, 64, 65, 117, 128, 425};
    Arena arena = {0};
    Random random = {1};
    char *path = arena_format(&arena, "%s/x.seen", support_folder(&arena));
    for (size_t i = 0; i < sizeof COUNTS / sizeof *COUNTS; i++) {
        int cells = COUNTS[i];
        uint64_t *rows = random_rows(&arena, &random, cells), *back;
        Error error = {""};
        cr_assert(seen_write(path, rows, cells, &error), "%s", error.text);
        cr_assert(seen_read(path, cells, &arena, &back, &error), "%s", error.text);
        cr_expect_arr_eq(rows, back, (size_t)cells * words_of(cells) * sizeof *rows, "%d cells", cells);
        Bytes bytes = support_read(&arena, path);
        cr_expect_eq(bytes.size, 4 + (size_t)cells * (((size_t)cells + 7) / 8));
    }
    arena_free(&arena);
}

// The layout as others write it: nine cells, cell 2 sees 0 and 8.
Test(seen, has_the_layout_of_others) {
    static const unsigned char FILE_BYTES[] = {9, 0,    0, 0,    0x01, 0,    0x02, 0,    0x05, 0x01, 0x08,
                                               0, 0x10, 0, 0x20, 0,    0x40, 0,    0x80, 0,    0,    0x01};
    Arena arena = {0};
    uint64_t *rows;
    Error error = {""};
    Bytes content = {(unsigned char *)arena_alloc(&arena, sizeof FILE_BYTES, 1), sizeof FILE_BYTES};
    memcpy(content.data, FILE_BYTES, sizeof FILE_BYTES);
    cr_assert(seen_parse("x.seen", content, 9, &arena, &rows, &error), "%s", error.text);
    for (int i = 0; i < 9; i++) cr_expect_eq(rows[i], (uint64_t)1 << i | (i == 2 ? 0x101u : 0), "row %d", i);
    char *path = arena_format(&arena, "%s/x.seen", support_folder(&arena));
    cr_assert(seen_write(path, rows, 9, &error), "%s", error.text);
    Bytes bytes = support_read(&arena, path);
    cr_assert_eq(bytes.size, sizeof FILE_BYTES);
    cr_expect_arr_eq(bytes.data, FILE_BYTES, sizeof FILE_BYTES);
    arena_free(&arena);
}

static void refused(Bytes content, int cells, const char *says) {
    Arena arena = {0};
    uint64_t *rows;
    Error error = {""};
    cr_expect_not(seen_parse("x.seen", content, cells, &arena, &rows, &error), "%s", says);
    cr_expect_not_null(strstr(error.text, "x.seen: "), "%s", error.text);
    cr_expect_not_null(strstr(error.text, says), "`%s` does not say `%s`", error.text, says);
    arena_free(&arena);
}

// Every fault has its sentence: too short, of other cells, cut anywhere, too long, bits beyond the last cell, a cell
// that does not see itself.
Test(seen, refuses_what_is_damaged) {
    unsigned char good[] = {3, 0, 0, 0, 1, 2, 4, 0};
    for (size_t size = 0; size < 4; size++) refused((Bytes){good, size}, 3, "at least 4");
    for (size_t size = 4; size < 7; size++) refused((Bytes){good, size}, 3, "expected 7 for 3 cells");
    refused((Bytes){good, 8}, 3, "expected 7 for 3 cells");
    refused((Bytes){good, 7}, 4, "is of 3 cells (expected 4)");
    unsigned char huge[] = {0xff, 0xff, 0xff, 0xff, 1, 2, 4};
    refused((Bytes){huge, 7}, 3, "is of 4294967295 cells");
    unsigned char beyond[] = {3, 0, 0, 0, 1, 0x12, 4};
    refused((Bytes){beyond, 7}, 3, "cell 1 sees cell 4 (allowed 0 to 2)");
    unsigned char blind[] = {3, 0, 0, 0, 1, 5, 4};
    refused((Bytes){blind, 7}, 3, "cell 1 does not see itself");
}

// Whatever is done to its bytes, a file is read or refused with a sentence.
Test(seen, survives_damage) {
    Random random = {2};
    Arena arena = {0};
    for (int k = 0; k < 20000; k++) {
        unsigned char bytes[] = {9, 0, 0, 0, 1, 0, 2, 0, 4, 0, 8, 0, 16, 0, 32, 0, 64, 0, 128, 0, 0, 1};
        uint64_t *rows;
        Error error = {""};
        for (int i = random_index(&random, 4); i >= 0; i--)
            bytes[random_index(&random, sizeof bytes)] ^= (unsigned char)(1 << random_index(&random, 8));
        size_t size = k % 2 ? sizeof bytes : (size_t)random_index(&random, sizeof bytes + 1);
        bool read = seen_parse("x.seen", (Bytes){bytes, size}, 9, &arena, &rows, &error);
        cr_assert(read || error.text[0], "seed 2, file %d", k);
        arena_reset(&arena);
    }
    arena_free(&arena);
}

// Where it cannot be written nothing is left, and an absent file is named.
Test(seen, says_what_is_wrong_with_the_path) {
    Arena arena = {0};
    Error error = {""};
    uint64_t row = 1, *rows;
    char *path = arena_format(&arena, "%s/no/x.seen", support_folder(&arena));
    cr_expect_not(seen_write(path, &row, 1, &error));
    cr_expect_not_null(strstr(error.text, "cannot be written"), "%s", error.text);
    cr_expect_not(seen_read(path, 1, &arena, &rows, &error));
    cr_expect_not_null(strstr(error.text, "cannot be opened"), "%s", error.text);
    arena_free(&arena);
}
