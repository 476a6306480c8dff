// file.c - reading and atomic writing of whole files.
#include "engine/core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

// Beside a file, tried for a name that nothing has.
enum { MOST_NAMES = 1000 };

bool file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error) {
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return error_set(error, "%s: cannot be opened: %s", path, strerror(errno));
    struct stat info;
    bool good = false;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        error_set(error, "%s: is not a file", path);
    } else if ((uint64_t)info.st_size > limit) {
        error_set(error, "%s: has %lld bytes (at most %zu are read)", path, (long long)info.st_size, limit);
    } else {
        out->size = (size_t)info.st_size;
        out->data = arena_alloc(arena, out->size + 1, 1);
        size_t got = 0;
        ssize_t step = 1;
        while (got < out->size && (step = read(fd, out->data + got, out->size - got)) > 0)
            got += (size_t)step;
        good = step >= 0 && got == out->size;
        if (!good) error_set(error, "%s: cannot be read: %s", path, step < 0 ? strerror(errno) : "it shrank");
    }
    close(fd);
    return good;
}

static bool write_all(int fd, const char *data, size_t size) {
    while (size > 0) {
        ssize_t step = write(fd, data, size);
        if (step < 0 && errno == EINTR) continue;
        if (step <= 0) return false;
        data += step;
        size -= (size_t)step;
    }
    return true;
}

static void put_folder(const char *path, char folder[PATH_MAX]) {
    snprintf(folder, PATH_MAX, "%s", path);
    char *slash = strrchr(folder, '/');
    if (slash) {
        slash[slash == folder] = 0;
    } else {
        strcpy(folder, ".");
    }
}

// A rename is on disk only when the folder is.
static void sync_folder(const char *path) {
    char folder[PATH_MAX];
    put_folder(path, folder);
    int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;
    fsync(fd);
    close(fd);
}

// A device or a pipe is written to as it is: a file in its place would be the end of it.
static bool is_stream(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

static bool write_stream(const char *path, const void *data, size_t size, Error *error) {
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    bool good = fd >= 0 && write_all(fd, data, size);
    int reason = errno;
    if (fd >= 0) close(fd);
    return good || error_set(error, "%s: cannot be written: %s", path, strerror(reason));
}

// A file without a name, in the folder of `path`: a program that is ended while it writes leaves nothing behind. -1 where the file
// system knows none.
static int open_nameless(const char *path) {
    char folder[PATH_MAX];
    put_folder(path, folder);
    return open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
}

// Gives it one beside `path`, that nothing has yet; longer than that of mkostemp never is.
static bool name_beside(int fd, const char *path, char beside[PATH_MAX]) {
    char own[64];
    snprintf(own, sizeof own, "/proc/self/fd/%d", fd);
    for (int i = 0; i < MOST_NAMES; i++) {
        if (snprintf(beside, PATH_MAX, "%s.%06x", path, (unsigned)(getpid() + i) & 0xffffff) >= PATH_MAX)
            return false;
        if (linkat(AT_FDCWD, own, AT_FDCWD, beside, AT_SYMLINK_FOLLOW) == 0) return true;
        if (errno != EEXIST) return false;
    }
    return false;
}

static int open_named(const char *path, char beside[PATH_MAX]) {
    snprintf(beside, PATH_MAX, "%s.XXXXXX", path);
    int fd = mkostemp(beside, O_CLOEXEC);
    mode_t mask = umask(0);
    umask(mask);
    if (fd >= 0) fchmod(fd, 0666 & ~mask);
    return fd;
}

// Onto the disk and under its name. `beside` is empty where it has none yet.
static bool settle(int fd, const char *path, char beside[PATH_MAX]) {
    if (fsync(fd) != 0 || (!*beside && !name_beside(fd, path, beside))) return false;
    return rename(beside, path) == 0;
}

// `beside`: "" with a file without a name. Closes the file; false with errno.
static bool write_as(int fd, const char *path, const void *data, size_t size, char beside[PATH_MAX]) {
    if (fd < 0) return false;
    bool good = write_all(fd, data, size) && settle(fd, path, beside);
    int reason = errno;
    if (!good && *beside) unlink(beside);
    if (close(fd) != 0 && good) {
        good = false;
        reason = errno;
    }
    errno = reason;
    return good;
}

bool file_write(const char *path, const void *data, size_t size, Error *error) {
    if (is_stream(path)) return write_stream(path, data, size, error);
    char beside[PATH_MAX] = "";
    if (strlen(path) + sizeof ".XXXXXX" > sizeof beside)
        return error_set(error, "%s: the path is too long", path);
    bool good = write_as(open_nameless(path), path, data, size, beside);
    // A name takes /proc, which may not be there. What else fails fails again.
    if (!good) {
        int fd = open_named(path, beside);
        good = write_as(fd, path, data, size, beside);
    }
    if (!good) return error_set(error, "%s: cannot be written: %s", path, strerror(errno));
    sync_folder(path);
    return true;
}

bool file_make_folder(const char *path, Error *error) {
    char part[PATH_MAX];
    if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part) {
        return error_set(error, "%s: the path is too long", path);
    }
    for (char *p = part + 1;; p++) {
        if (*p != '/' && *p != 0) continue;
        char kept = *p;
        *p = 0;
        if (mkdir(part, 0777) != 0 && errno != EEXIST) {
            return error_set(error, "%s: cannot be made: %s", part, strerror(errno));
        }
        *p = kept;
        if (!kept) break;
    }
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return error_set(error, "%s: is not a folder", path);
    return true;
}

bool file_cache_folder(Arena *arena, char **path, Error *error) {
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (cache && *cache) {
        *path = arena_format(arena, "%s/enfilade", cache);
    } else if (home && *home) {
        *path = arena_format(arena, "%s/.cache/enfilade", home);
    } else {
        return error_set(error, "neither XDG_CACHE_HOME nor HOME is set: there is no place for a cache");
    }
    return file_make_folder(*path, error);
}

uint64_t file_hash(const void *data, size_t size, uint64_t seed) {
    return XXH3_64bits_withSeed(data, size, seed);
}
