// test_file.c - files appear whole or not at all, and a program that is ended while it writes leaves nothing beside them.
#include <criterion/criterion.h>
#include <dirent.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "tests/support.h"

enum { LARGE = 8 << 20 };

static int files_in(const char *folder) {
    DIR *dir = opendir(folder);
    int count = 0;
    cr_assert(dir);
    for (const struct dirent *entry; (entry = readdir(dir));) count += entry->d_name[0] != '.';
    closedir(dir);
    return count;
}

// Writes `path` over and over; ends by a signal alone.
static _Noreturn void write_for_ever(const char *path, const char *data) {
    Error error;
    for (;;)
        if (!file_write(path, data, LARGE, &error)) _exit(1);
}

// Proves that a writer that is killed at any moment leaves the whole file, or none, and no other: a file gets its name when it is
// on disk. Killed 20 times within what eight megabytes take to write; a name is held for some microseconds of that.
Test(file, killed_writers_leave_nothing, .timeout = 60) {
    Arena arena = {0};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/light.rad", folder);
    char *data = arena_alloc(&arena, LARGE, 1);
    memset(data, 'x', LARGE);
    for (int i = 0; i < 20; i++) {
        pid_t writer = fork();
        if (writer == 0) write_for_ever(path, data);
        usleep(700 * (unsigned)i);
        kill(writer, SIGKILL);
        int status;
        cr_assert_eq(waitpid(writer, &status, 0), writer);
        cr_assert(WIFSIGNALED(status));
        struct stat info;
        bool there = stat(path, &info) == 0;
        cr_assert(!there || info.st_size == LARGE, "%lld bytes", (long long)info.st_size);
        cr_expect_eq(files_in(folder), there, "after %d: %d files", i, files_in(folder));
    }
    arena_free(&arena);
}

// Proves that a file written over another replaces it with the rights that new files have; a folder is not replaced, and nothing
// stays beside it.
Test(file, replaces_files_alone) {
    Arena arena = {0};
    Error error = {""};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder);
    umask(027);
    cr_assert(file_write(path, "one", 3, &error), "%s", error.text);
    cr_assert(file_write(path, "second", 6, &error), "%s", error.text);
    struct stat info;
    cr_assert_eq(stat(path, &info), 0);
    cr_expect_eq(info.st_size, 6);
    cr_expect_eq(info.st_mode & 0777, 0640);
    const char *inner = arena_format(&arena, "%s/folder", folder);
    cr_assert_eq(mkdir(inner, 0777), 0);
    cr_expect_not(file_write(inner, "x", 1, &error));
    cr_expect_eq(files_in(folder), 2);
    cr_expect_not(file_write(arena_format(&arena, "%s/none/a", folder), "x", 1, &error));
    cr_expect(strstr(error.text, "none/a: cannot be written: No such file"), "%s", error.text);
    arena_free(&arena);
}
