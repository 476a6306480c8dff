// test_file_places.c - rights, links, streams and descriptors of files that are written.
#include <criterion/criterion.h>
#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "tests/core/file_fixture.h"
#include "tests/support/support.h"

// Runs `work` in a process of its own, as a user without rights; fails the test unless it returns true.
static void as_nobody(bool (*work)(void *context), void *context) {
    pid_t child = fork();
    if (child == 0) {
        bool changed =
            geteuid() != 0 || (setgroups(0, NULL) == 0 && setgid(NOBODY) == 0 && setuid(NOBODY) == 0);
        _exit(changed && work(context) ? 0 : 1);
    }
    int status;
    cr_assert_eq(waitpid(child, &status, 0), child);
    cr_assert(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

// ---- rights

static bool write_as_nobody(void *context) {
    const Writing *w = context;
    Error error;
    return file_write(w->path, w->text, strlen(w->text), &error) ? !w->root
                                                                 : w->root && strstr(error.text, w->root);
}

// Proves that a file keeps mode, owner and group, as if it were written into; but none of those bits that make a program another
// user's, and no right that its new owner's group did not have.
Test(file, rights_stay) {
    Arena arena = {0};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder);
    Error error;
    umask(022);
    static const mode_t modes[][2] = {{0600, 0600}, {0666, 0666}, {0755, 0755}, {04755, 0755}, {02775, 0775}};
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        file_put(path, "one", modes[i][0]);
        cr_assert(file_write(path, "two", 3, &error), "%s", error.text);
        cr_expect_eq(file_info_of(path).st_mode & 07777, modes[i][1], "0%o", file_info_of(path).st_mode);
        file_expect_text(&arena, path, "two");
    }
    if (geteuid() != 0) cr_skip_test("only root gives files away");
    cr_assert_eq(chown(path, NOBODY, NOBODY), 0);
    file_put(path, "three", 0640);
    cr_expect(file_info_of(path).st_uid == NOBODY && file_info_of(path).st_gid == NOBODY);
    // A file of others, which all may write: their group is not kept, and so its rights are those of all.
    cr_assert(chown(path, 0, 0) == 0 && chmod(path, 0672) == 0 && chmod(folder, 0777) == 0);
    as_nobody(write_as_nobody, &(Writing){path, "four", NULL});
    cr_expect_eq(file_info_of(path).st_mode & 07777, 0622, "0%o", file_info_of(path).st_mode);
    cr_expect_eq(file_info_of(path).st_uid, NOBODY);
    // A file that the user may not write stays: this one, and one whose folder would take no other.
    cr_assert(chown(path, 0, 0) == 0 && chmod(path, 0644) == 0);
    as_nobody(write_as_nobody, &(Writing){path, "five", "a: cannot be written: Permission denied"});
    cr_assert(chmod(path, 0666) == 0 && chmod(folder, 0755) == 0);
    as_nobody(write_as_nobody, &(Writing){path, "five", "its folder takes no other file"});
    file_expect_text(&arena, path, "four");
    arena_free(&arena);
}

// Proves that an access list stays: without it the group would have the rights of those that are named in it.
Test(file, access_lists_stay) {
    Arena arena = {0};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder);
    // Version 2, then tag, rights and number of user, named user, group, bounds and others: rw-, rw-, ---, rw-, ---.
    static const uint32_t list[] = {2,          6 << 16 | 0x01, UINT32_MAX, 6 << 16 | 0x02, NOBODY,    0x04,
                                    UINT32_MAX, 6 << 16 | 0x10, UINT32_MAX, 0x20,           UINT32_MAX};
    file_put(path, "one", 0600);
    if (setxattr(path, "system.posix_acl_access", list, sizeof list, 0) != 0)
        cr_skip_test("no access lists here");
    file_put(path, "two", 0660);
    uint32_t got[16];
    cr_expect_eq(getxattr(path, "system.posix_acl_access", got, sizeof got), (ssize_t)sizeof list);
    cr_expect_arr_eq(got, list, sizeof list);
    arena_free(&arena);
}

// ---- links and streams

// Proves that a symbolic link stays and what it leads to is written: through others, into another folder, to where nothing is yet;
// links in a circle are refused.
Test(file, links_are_followed) {
    Arena arena = {0};
    Error error;
    const char *folder = support_folder(&arena), *far = support_folder(&arena);
    const char *a = arena_format(&arena, "%s/a", folder), *b = arena_format(&arena, "%s/b", folder),
               *c = arena_format(&arena, "%s/c", folder), *end = arena_format(&arena, "%s/inner/end", folder),
               *there = arena_format(&arena, "%s/there", far);
    cr_assert_eq(mkdir(arena_format(&arena, "%s/inner", folder), 0755), 0);
    cr_assert(symlink("b", a) == 0 &&
              symlink(arena_format(&arena, "../%s/inner/end", strrchr(folder, '/') + 1), b) == 0);
    file_put(end, "one", 0604);
    cr_assert(file_write(a, "two", 3, &error), "%s", error.text);
    file_expect_text(&arena, end, "two");
    cr_expect(S_ISLNK(file_info_of(a).st_mode) && S_ISLNK(file_info_of(b).st_mode) &&
              (file_info_of(end).st_mode & 0777) == 0604);
    cr_assert_eq(symlink(there, c), 0);
    cr_assert(file_write(c, "new", 3, &error), "%s", error.text);
    file_expect_text(&arena, there, "new");
    cr_expect(S_ISLNK(file_info_of(c).st_mode) && S_ISREG(file_info_of(there).st_mode));
    cr_expect(file_same(c, there) && file_same(a, end) && !file_same(a, c));
    cr_expect(file_same(arena_format(&arena, "%s/none", far), arena_format(&arena, "%s/none", far)));
    cr_assert(unlink(end) == 0 && symlink("../a", end) == 0);
    cr_expect_not(file_write(a, "x", 1, &error));
    cr_expect(strstr(error.text, "symbolic links"), "%s", error.text);
    cr_expect_eq(file_files_in(folder) + file_files_in(far), 4 + 1);
    arena_free(&arena);
}

// Proves that a link from one file system to another is followed: the file is made beside its end, where it can be renamed.
Test(file, links_cross_file_systems) {
    Arena arena = {0};
    Error error;
    const char *folder = support_folder(&arena), *link = arena_format(&arena, "%s/a", folder),
               *far = arena_format(&arena, "/dev/shm/enfilade-test-%d", (int)getpid());
    struct stat here = file_info_of(folder), there;
    if (stat("/dev/shm", &there) != 0 || there.st_dev == here.st_dev || access("/dev/shm", W_OK) != 0)
        cr_skip_test("/dev/shm is no file system of its own");
    file_put(far, "one", 0600);
    cr_assert_eq(symlink(far, link), 0);
    bool good = file_write(link, "two", 3, &error);
    cr_expect(good, "%s", error.text);
    file_expect_text(&arena, far, "two");
    cr_expect(S_ISLNK(file_info_of(link).st_mode));
    unlink(far);
    arena_free(&arena);
}

// Proves that what the shell has opened is written into, where it stands, and is not replaced.
Test(file, descriptors_are_written_into) {
    Arena arena = {0};
    Error error;
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder);
    file_put(path, "head ", 0644);
    int fd = open(path, O_WRONLY | O_APPEND | O_CLOEXEC);
    ino_t inode = file_info_of(path).st_ino;
    cr_assert(file_write(arena_format(&arena, "/dev/fd/%d", fd), "tail", 4, &error), "%s", error.text);
    file_expect_text(&arena, path, "head tail");
    cr_expect_eq(file_info_of(path).st_ino, inode);
    cr_expect(file_check(arena_format(&arena, "/dev/fd/%d", fd), 10, &error));
    close(fd);
    fd = open(path, O_RDONLY | O_CLOEXEC);
    cr_expect_not(file_check(arena_format(&arena, "/proc/self/fd/%d", fd), 10, &error));
    close(fd);
    cr_expect_not(file_write("-", "x", 1, &error));
    cr_expect(strstr(error.text, "/dev/stdout"), "%s", error.text);
    arena_free(&arena);
}

// Proves that a file that cannot be written is told of beforehand, that nothing is left of the question, and nothing asked of a pipe.
Test(file, checks_beforehand, .timeout = 20) {
    Arena arena = {0};
    Error error;
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/a", folder),
               *pipe = arena_format(&arena, "%s/pipe", folder);
    cr_assert_eq(mkfifo(pipe, 0666), 0);
    cr_expect(file_check(path, 1 << 20, &error), "%s", error.text);
    cr_expect(file_check(pipe, 1 << 20, &error), "%s", error.text);
    cr_expect_eq(file_files_in(folder), 1);
    cr_expect(!file_check("", 0, &error) && !file_check(arena_format(&arena, "%s/", path), 0, &error));
    cr_expect_not(file_check(folder, 0, &error));
    cr_expect(strstr(error.text, "Is a directory"), "%s", error.text);
    cr_expect_not(file_check(arena_format(&arena, "%s/none/a", folder), 0, &error));
    const char *longest = arena_format(&arena, "%s/%0243d", folder, 0);
    cr_expect(file_write(longest, "x", 1, &error) && unlink(longest) == 0, "%s", error.text);
    cr_expect_not(file_check(arena_format(&arena, "%s0", longest), 0, &error));
    cr_expect(strstr(error.text, "too long"), "%s", error.text);
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit little, all;
    getrlimit(RLIMIT_FSIZE, &all);
    little = (struct rlimit){1 << 16, all.rlim_max};
    setrlimit(RLIMIT_FSIZE, &little);
    bool fits = file_check(path, 1 << 20, &error), less_fits = file_check(path, 1 << 10, NULL);
    setrlimit(RLIMIT_FSIZE, &all);
    cr_expect(!fits && less_fits);
    cr_expect(strstr(error.text, "a: cannot be written: File too large"), "%s", error.text);
    // Asked by a file that has a name, since there is no /proc.
    int status;
    if (fork() == 0) _exit(chroot(folder) != 0 || file_check("/a", 10, NULL) ? 0 : 1);
    cr_expect(wait(&status) > 0 && status == 0);
    cr_expect_eq(file_files_in(folder), 1);
    arena_free(&arena);
}

// Proves that only regular files are read, and that nobody waits for the others; a link to a file is one.
Test(file, reads_regular_files_alone, .timeout = 20) {
    Arena arena = {0};
    const char *folder = support_folder(&arena), *name = arena_format(&arena, "%s/x", folder);
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s/socket", folder);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    cr_assert(bind(fd, (struct sockaddr *)&address, sizeof address) == 0);
    cr_assert(mkfifo(name, 0666) == 0 && symlink("x", arena_format(&arena, "%s/link", folder)) == 0);
    const char *refused[][2] = {{name, "is a pipe (allowed: a regular file)"},
                                {arena_format(&arena, "%s/link", folder), "is a pipe"},
                                {folder, "is a folder"},
                                {address.sun_path, "is a socket"},
                                {"/dev/zero", "is a device"},
                                {"-", "standard input is not read"},
                                {arena_format(&arena, "%s/none", folder), "cannot be opened: No such file"}};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        Bytes bytes;
        Error error = {""};
        cr_expect_not(file_read(refused[i][0], 1 << 20, &arena, &bytes, &error));
        cr_expect(strstr(error.text, refused[i][1]), "%s", error.text);
    }
    close(fd);
    unlink(name);
    file_put(name, "whole", 0644);
    file_expect_text(&arena, refused[1][0], "whole");
    arena_free(&arena);
}

// Proves that several threads read what one reads, to the last byte of a part that is not full, and that a limit holds for large files.
Test(file, large_files_are_read_by_threads, .timeout = 60) {
    enum { SIZE = (64 << 20) + 12345 };
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/large", support_folder(&arena));
    uint32_t *words = arena_alloc(&arena, SIZE / sizeof(uint32_t) + 1, sizeof(uint32_t));
    for (size_t i = 0; i <= SIZE / sizeof(uint32_t); i++) words[i] = (uint32_t)i * 2654435761u;
    Error error;
    cr_assert(file_write(path, words, SIZE, &error), "%s", error.text);
    for (int threads = 1; threads <= 3; threads++) {
        Bytes bytes;
        cr_assert(file_read_by(path, SIZE, threads, &arena, &bytes, &error), "%s", error.text);
        cr_expect(bytes.size == SIZE && memcmp(bytes.data, words, SIZE) == 0, "%d threads", threads);
        cr_expect_eq(bytes.data[SIZE], 0);
        cr_expect_not(file_read_by(path, SIZE - 1, threads, &arena, &bytes, &error));
    }
    arena_free(&arena);
}
