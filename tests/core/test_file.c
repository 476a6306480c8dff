// test_file.c - files appear whole or not at all, with the rights of those that they replace, and a program that is ended while it
// writes leaves nothing beside them; what is no regular file is not read.
#include <criterion/criterion.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "tests/core/file_fixture.h"
#include "tests/support/support.h"

// Writes `path` over and over; ends by a signal alone.
static _Noreturn void write_for_ever(const char *path, const char *data) {
    Error error;
    for (;;)
        if (!file_write(path, data, LARGE, &error)) _exit(1);
}

// Proves that a writer that is killed at any moment leaves the whole file, or none: a file gets its name when it is on disk. Killed
// 20 times within the milliseconds that eight megabytes take to write. For some microseconds of these the file has a name beside the
// target: a kill in 1,000 may fall there, three in 20 do not, and the next writer sweeps away that one file.
Test(file, killed_writers_leave_nothing, .timeout = 60) {
    Arena arena = {0};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/light.rad", folder);
    char *data = arena_alloc(&arena, LARGE, 1);
    memset(data, 'x', LARGE);
    int beside = 0;
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
        int left = file_files_in(folder) - there;
        cr_expect_leq(left, 1, "after %d: %d files", i, file_files_in(folder));
        beside += left > 0;
        if (left == 0) continue;
        Error error;
        cr_assert(file_write(path, data, LARGE, &error), "%s", error.text);
        cr_expect_eq(file_files_in(folder), 1, "after %d the next writer leaves %d files", i,
                     file_files_in(folder));
    }
    cr_expect_lt(beside, 3, "%d of 20 leave a file beside", beside);
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
    cr_expect_eq(file_files_in(folder), 2);
    cr_expect_not(file_write(arena_format(&arena, "%s/none/a", folder), "x", 1, &error));
    cr_expect(strstr(error.text, "none/a: cannot be written: No such file"), "%s", error.text);
    arena_free(&arena);
}

// ---- killed at every step

static void write_text(void *context) {
    const Writing *w = context;
    // Without /proc a file cannot be named later, and has a name from its beginning.
    if (w->root && chroot(w->root) != 0) _exit(1);
    file_write(w->path, w->text, strlen(w->text), NULL);
}

static void kill_everywhere(const char *folder, Writing writing) {
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/a", folder);
    int moments = support_kill(-1, write_text, &writing), left = 0;
    cr_assert_gt(moments, 10);
    for (int i = 0; i < moments; i++) {
        file_put(path, "earlier", 0644);
        cr_assert_eq(support_kill(i, write_text, &writing), -1);
        const char *now = (char *)support_read(&arena, path).data;
        cr_expect(strcmp(now, "earlier") == 0 || strcmp(now, "later") == 0, "killed at %d: %s", i, now);
        left += file_files_in(folder) > 1;
        file_put(path, "next", 0644);
        cr_expect_eq(file_files_in(folder), 1, "killed at %d: what was left stays", i);
    }
    // Else nothing was swept.
    cr_expect_gt(left, 0);
    arena_free(&arena);
}

// Proves that a writer killed before or after any of its system calls leaves the earlier file or the later one, and that what it
// leaves beside it goes with the next writing; with files that get their name last, and with those that have one at first.
Test(file, killed_at_every_step, .timeout = 120) {
    Arena arena = {0};
    const char *folder = support_folder(&arena);
    kill_everywhere(folder, (Writing){arena_format(&arena, "%s/a", folder), "later", NULL});
    if (geteuid() == 0) kill_everywhere(folder, (Writing){"/a", "later", folder});
    arena_free(&arena);
}

// Proves that only what a dead writer left goes: not what a writer still holds, nor what is no such file or has another name.
Test(file, sweeps_its_own_alone) {
    Arena arena = {0};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder);
    static const char *const others[] = {"a.enfilade-8", "a.enfilade-01", "a.enfilade-x", "b.enfilade-0"};
    for (int i = 0; i < 4; i++) file_put(arena_format(&arena, "%s/%s", folder, others[i]), "mine", 0644);
    for (int i = 0; i < 8; i++)
        file_put(arena_format(&arena, "%s/a.enfilade-%d", folder, i), "left", i == 5 ? 0400 : 0644);
    const char *held = arena_format(&arena, "%s/a.enfilade-3", folder),
               *link = arena_format(&arena, "%s/a.enfilade-6", folder);
    int fd = open(held, O_RDONLY | O_CLOEXEC);
    cr_assert(fd >= 0 && flock(fd, LOCK_EX) == 0 && unlink(link) == 0 && symlink("b.enfilade-0", link) == 0);
    file_put(path, "new", 0644);
    cr_expect_eq(file_files_in(folder), 1 + 4 + 2);
    file_expect_text(&arena, held, "left");
    cr_expect(S_ISLNK(file_info_of(link).st_mode));
    close(fd);
    file_put(path, "newer", 0644);
    cr_expect_eq(file_files_in(folder), 1 + 4 + 1);
    arena_free(&arena);
}

// Proves that more writers of one path than there are names for it wait for each other: all succeed, the file is that of one of them,
// and nothing is left.
Test(file, writers_of_one_path, .timeout = 120) {
    enum { WRITERS = 24, TIMES = 4, SIZE = 5000 };
    Arena arena = {0};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder);
    char *data = arena_alloc(&arena, SIZE, 1);
    for (int i = 0; i < WRITERS; i++) {
        if (fork() != 0) continue;
        memset(data, 'a' + i, SIZE);
        bool good = true;
        // Without /proc a writer holds its name as long as it writes.
        if (i % 2 && chroot(folder) == 0) path = "/a";
        for (int k = 0; k < TIMES; k++) good = file_write(path, data, SIZE, NULL) && good;
        _exit(good ? 0 : 1);
    }
    for (int status; wait(&status) > 0;) cr_expect(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    Bytes now = support_read(&arena, path);
    memset(data, now.data[0], SIZE);
    cr_expect(now.size == SIZE && memcmp(now.data, data, SIZE) == 0);
    cr_expect_eq(file_files_in(folder), 1);
    arena_free(&arena);
}
