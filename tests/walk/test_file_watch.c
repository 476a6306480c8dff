// test_file_watch.c - a changed file is told of once, when it is whole: whichever way an editor writes it.
#include <criterion/criterion.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/walk/file_watch.h"
#include "tests/support/support.h"

static void put(const char *path, const char *text) {
    Error error;
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
}

static void append(const char *path, const char *text) {
    FILE *file = fopen(path, "a");
    cr_assert(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void expect_state(FileWatch *watch, double now, int state, const char *when) {
    int found = file_watch_look(watch, now);
    cr_expect_eq(found, state, "%s: state %d instead of %d", when, found, state);
}

// An editor that puts a new file under the old name, of the same size even: told once, after it has been still.
Test(file_watch, renamed_over) {
    Arena arena = {0};
    char *path = arena_format(&arena, "%s/home.plan", support_folder(&arena));
    put(path, "one");
    FileWatch watch = file_watch_begin(path);
    expect_state(&watch, 10, FILE_SAME, "untouched");
    put(path, "two");
    expect_state(&watch, 11, FILE_SAME, "just changed");
    expect_state(&watch, 11 + FILE_WATCH_STILL / 2, FILE_SAME, "not yet still");
    expect_state(&watch, 11.01 + FILE_WATCH_STILL, FILE_CHANGED, "still");
    expect_state(&watch, 12, FILE_SAME, "told already");
    arena_free(&arena);
}

// A file that grows for a while is half written until it rests: each write puts the moment off.
Test(file_watch, written_slowly) {
    Arena arena = {0};
    char *path = arena_format(&arena, "%s/home.plan", support_folder(&arena));
    put(path, "");
    FileWatch watch = file_watch_begin(path);
    double now = 5;
    for (int i = 0; i < 20; i++) {
        append(path, "more\n");
        expect_state(&watch, now += FILE_WATCH_STILL * 0.9, FILE_SAME, "being written");
    }
    expect_state(&watch, now + FILE_WATCH_STILL * 1.1, FILE_CHANGED, "written");
    arena_free(&arena);
}

// In place, with the size and the time of writing kept, as some tools do: the change of state still shows.
Test(file_watch, time_put_back) {
    Arena arena = {0};
    char *path = arena_format(&arena, "%s/home.plan", support_folder(&arena));
    put(path, "one");
    struct stat before;
    cr_assert_eq(stat(path, &before), 0);
    FileWatch watch = file_watch_begin(path);
    // The file system's clock ticks some 250 times a second.
    usleep(20000);
    FILE *file = fopen(path, "r+");
    cr_assert(file && fputs("two", file) >= 0 && fclose(file) == 0);
    struct timespec times[2] = {before.st_atim, before.st_mtim};
    cr_assert_eq(utimensat(AT_FDCWD, path, times, 0), 0);
    expect_state(&watch, 1, FILE_SAME, "just changed");
    expect_state(&watch, 2, FILE_CHANGED, "changed, with its old time");
    arena_free(&arena);
}

// Away for a moment while an editor replaces it: nothing is lost. Away for good: told once, and when it comes back.
Test(file_watch, gone_and_back) {
    Arena arena = {0};
    char *path = arena_format(&arena, "%s/home.plan", support_folder(&arena));
    put(path, "one");
    FileWatch watch = file_watch_begin(path);
    cr_assert_eq(unlink(path), 0);
    expect_state(&watch, 1, FILE_SAME, "away for a moment");
    put(path, "two");
    expect_state(&watch, 1.1, FILE_SAME, "back at once");
    expect_state(&watch, 1.11 + FILE_WATCH_STILL, FILE_CHANGED, "replaced");
    cr_assert_eq(unlink(path), 0);
    expect_state(&watch, 3, FILE_SAME, "away");
    expect_state(&watch, 4, FILE_GONE, "gone");
    expect_state(&watch, 5, FILE_SAME, "told already");
    put(path, "three");
    expect_state(&watch, 6, FILE_SAME, "back");
    expect_state(&watch, 7, FILE_CHANGED, "back and still");
    arena_free(&arena);
}

// A path that never was a file says nothing until it is one.
Test(file_watch, absent_at_first) {
    Arena arena = {0};
    char *path = arena_format(&arena, "%s/home.plan", support_folder(&arena));
    FileWatch watch = file_watch_begin(path);
    expect_state(&watch, 1, FILE_SAME, "absent");
    put(path, "one");
    expect_state(&watch, 2, FILE_SAME, "new");
    expect_state(&watch, 3, FILE_CHANGED, "new and still");
    arena_free(&arena);
}
