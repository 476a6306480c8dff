// file.c - reading of whole files, folders, the cache. Writing is in file_write.c.
#include "engine/core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// In this object, so that no library is needed for it.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "engine/core/memory.h"

// Devices and pipes may have no end, or nobody who ever writes.
static bool check_regular(const char *path, mode_t mode, Error *error) {
    if (S_ISREG(mode)) return true;
    const char *kind = S_ISDIR(mode)    ? "folder"
                       : S_ISFIFO(mode) ? "pipe"
                       : S_ISSOCK(mode) ? "socket"
                                        : "device";
    return error_set(error, "%s: is a %s (allowed: a regular file)", path, kind);
}

// -1, with a sentence, where there is none. Does not wait for whoever may write into a pipe.
static int open_regular(const char *path, struct stat *info, Error *error) {
    if (strcmp(path, "-") == 0) {
        error_set(error, "-: standard input is not read (allowed: a regular file; one of this name as ./-)");
        return -1;
    }
    // Asked before it is opened, too: of some devices, opening alone has effects.
    int fd = -1;
    if (stat(path, info) == 0) {
        if (!check_regular(path, info->st_mode, error)) return -1;
        fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    }
    if (fd < 0 || fstat(fd, info) != 0)
        error_set(error, "%s: cannot be opened: %s", path, strerror(errno));
    else if (check_regular(path, info->st_mode, error))
        return fd;
    if (fd >= 0) close(fd);
    return -1;
}

bool file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error) {
    struct stat info;
    int fd = open_regular(path, &info, error);
    if (fd < 0) return false;
    bool good = false;
    if ((uint64_t)info.st_size > limit) {
        error_set(error, "%s: has %lld bytes (at most %zu are read)", path, (long long)info.st_size, limit);
    } else {
        out->size = (size_t)info.st_size;
        memory_note_read(out->size);
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
    // Relative ones are invalid (XDG Base Directory Specification).
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (cache && *cache == '/') {
        *path = arena_format(arena, "%s/enfilade", cache);
    } else if (home && *home) {
        *path = arena_format(arena, "%s/.cache/enfilade", home);
    } else {
        return error_set(error, "there is no cache, since neither XDG_CACHE_HOME nor HOME is set");
    }
    return true;
}

uint64_t file_hash(const void *data, size_t size, uint64_t seed) {
    return XXH3_64bits_withSeed(data, size, seed);
}
