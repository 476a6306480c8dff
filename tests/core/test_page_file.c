// test_page_file.c - memory in a file: what is put there stays, whatever leaves the process, and what is given back is used again.
#include <criterion/criterion.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

#include "engine/core/memory.h"
#include "engine/core/page_file.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "tests/support/support.h"

static PageFile *new_file(void) {
    static Arena arena;
    Error error;
    PageFile *file = page_file_new(support_folder(&arena), &error);
    cr_assert(file, "%s", error.text);
    return file;
}

static void drop(PageFile *file) {
    Error error;
    cr_assert(page_file_drop(file, &error), "%s", error.text);
}

// Pages of the process, all and those that are in memory.
static long resident(void) {
    long all = 0, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    cr_assert(file && fscanf(file, "%ld %ld", &all, &pages) == 2);
    fclose(file);
    return pages * sysconf(_SC_PAGESIZE);
}

typedef struct Piece {
    unsigned char *data;
    size_t size;
    unsigned char value;
} Piece;

static void expect_filled(const Piece *p, int when) {
    for (size_t i = 0; i < p->size; i++)
        cr_assert(p->data[i] == p->value, "byte %zu of %zu at step %d", i, p->size, when);
}

// Proves that pieces are zeroed, hold what is written whatever happens to others, and lie apart: 3,000 are taken and given back by
// chance, and now and then all pages leave the process. Sums of what is taken are right at the end.
Test(page_file, pieces_stay_as_they_are) {
    enum { PIECES = 40, STEPS = 3000 };
    PageFile *file = new_file();
    Piece piece[PIECES] = {{0}};
    Random random = {7};
    for (int step = 0; step < STEPS; step++) {
        Piece *p = &piece[random_index(&random, PIECES)];
        if (p->data) {
            expect_filled(p, step);
            page_file_give(p->data);
            p->data = NULL;
            continue;
        }
        p->size = 1 + (size_t)random_index(&random, step % 50 == 0 ? 3000000 : 40000);
        p->data = page_file_take(file, p->size);
        cr_assert(p->data);
        cr_expect_eq(page_file_of(p->data), file);
        cr_expect_eq(page_file_of(p->data + p->size - 1), file);
        cr_assert_geq(page_file_size(p->data), p->size);
        p->value = 0;
        expect_filled(p, step);
        p->value = (unsigned char)(1 + step % 255);
        memset(p->data, p->value, p->size);
        if (step % 100 == 0) drop(file);
    }
    for (int i = 0; i < PIECES; i++) {
        if (!piece[i].data) continue;
        expect_filled(&piece[i], STEPS);
        page_file_give(piece[i].data);
    }
    cr_expect_eq(page_file_used(file), 0);
    int local;
    cr_expect_null(page_file_of(&local));
    page_file_free(file);
}

// Proves that pages leave the process, 64 MB of them, and come back when they are read.
Test(page_file, pages_leave_and_come_back) {
    const size_t size = (size_t)64 << 20;
    PageFile *file = new_file();
    unsigned char *data = page_file_take(file, size);
    cr_assert(data);
    long before = resident();
    memset(data, 42, size);
    cr_expect_geq(resident(), before + (long)(size / 2));
    drop(file);
    cr_expect_leq(resident(), before + (long)(size / 8));
    for (size_t i = 0; i < size; i += 1000) cr_assert(data[i] == 42, "byte %zu", i);
    page_file_free(file);
}

// Bytes that the process wrote so far, -1: not known.
static long long written(void) {
    long long bytes = -1;
    char line[200];
    FILE *file = fopen("/proc/self/io", "r");
    while (file && fgets(line, sizeof line, file)) sscanf(line, "wchar: %lld", &bytes);
    if (file) fclose(file);
    return bytes;
}

// Proves that only pages that were touched are written, 16 of 16,384, and that all others are zero: also where a piece lay before that is
// gone, and was written from end to end.
Test(page_file, pages_that_were_never_touched_are_not_written) {
    const size_t size = (size_t)64 << 20, step = size / 16;
    PageFile *file = new_file();
    for (int round = 0; round < 2; round++) {
        unsigned char *data = page_file_take(file, size);
        cr_assert(data);
        for (size_t i = 0; i < size; i += step) data[i + 5] = 7;
        long long before = written();
        drop(file);
        // Pages are of 4 kB here, or of 64 kB elsewhere.
        if (before >= 0) cr_expect_leq(written() - before, 16 * 65536 + 1000, "round %d", round);
        for (size_t i = 0; i < size; i++)
            cr_assert_eq(data[i], i % step == 5 ? 7 : 0, "byte %zu in round %d", i, round);
        memset(data, 99, size);
        drop(file);
        page_file_give(data);
    }
    page_file_free(file);
}

static void fill_arena(void *context, int index, int thread) {
    Arena *arenas = context;
    (void)thread;
    int *numbers = ARENA_ARRAY(&arenas[index], int, 50000);
    for (int i = 0; i < 50000; i++) numbers[i] = i;
}

// Proves that arenas of a thread that uses a file lie there, also those that its loops make on other threads; that they do not count while
// they sleep, and do again after; that arrays which grow hold what they had; and that all of it is gone in the end.
Test(page_file, arenas_sleep) {
    enum { ARENAS = 4 };
    PageFile *file = new_file(), *none = memory_use_file(file);
    size_t before = memory_used();
    cr_expect_null(none);
    Arena arenas[ARENAS] = {{0}}, grown = {0};
    parallel_for(2, ARENAS, fill_arena, arenas);
    int *number = NULL, count = 0, capacity = 0;
    for (int i = 0; i < 1000000; i++) *ARENA_APPEND(&grown, number, count, capacity) = i;
    size_t there = memory_used() - before;
    cr_expect_eq(there, page_file_used(file));
    cr_expect_geq(there, (size_t)1000000 * sizeof *number);
    memory_sleep(file);
    memory_sleep(file);
    cr_expect_eq(memory_used(), before);
    drop(file);
    memory_wake(file);
    memory_wake(file);
    cr_expect_eq(memory_used(), before + there);
    for (int i = 0; i < 1000000; i++) cr_assert(number[i] == i, "element %d", i);
    for (int i = 0; i < ARENAS; i++) arena_free(&arenas[i]);
    arena_free(&grown);
    cr_expect_eq(memory_used(), before);
    cr_expect_eq(page_file_used(file), 0);
    cr_expect_eq(memory_use_file(NULL), file);
    memory_leave_file(file);
    memory_leave_file(NULL);
}

// Proves that a folder that is not there, and a disk that is too small, are told instead of a crash when a page is written.
Test(page_file, refusals) {
    Error error = {""};
    cr_expect_null(page_file_new("/nowhere/at/all", &error));
    cr_expect(strstr(error.text, "/nowhere/at/all: "), "%s", error.text);
    PageFile *file = new_file();
    cr_expect_null(page_file_take(file, (size_t)1 << 40));
    cr_expect_null(page_file_take(file, SIZE_MAX));
    // A limit of the size of files stands in for a full disk: what does not fit stays in the process.
    struct rlimit limit, small;
    cr_assert(getrlimit(RLIMIT_FSIZE, &limit) == 0);
    small = limit;
    small.rlim_cur = 1 << 20;
    signal(SIGXFSZ, SIG_IGN);
    char *large = page_file_take(file, 8 << 20);
    cr_assert(large);
    large[(8 << 20) - 1] = 1;
    cr_assert(setrlimit(RLIMIT_FSIZE, &small) == 0);
    cr_expect_not(page_file_drop(file, &error));
    cr_expect(strstr(error.text, "the disk has no room"), "%s", error.text);
    setrlimit(RLIMIT_FSIZE, &limit);
    cr_expect_eq(large[(8 << 20) - 1], 1);
    drop(file);
    cr_expect_eq(large[(8 << 20) - 1], 1);
    page_file_free(file);
}
