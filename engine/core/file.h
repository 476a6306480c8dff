// file.h - whole files: read at once, written whole or not at all, hashed.
#ifndef CORE_FILE_H
#define CORE_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"

// The content of a file.
typedef struct Bytes {
    unsigned char *data;  // followed by a zero byte that is not counted
    size_t size;
} Bytes;

// Fails on a missing, unreadable or irregular file and on one of more than `limit` bytes.
bool file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error);

// Writes beside `path`, flushes to disk and renames: an earlier file survives any failure.
bool file_write(const char *path, const void *data, size_t size, Error *error);

// Makes the folder and those above it.
bool file_make_folder(const char *path, Error *error);

// `$XDG_CACHE_HOME/enfilade` or `~/.cache/enfilade`, made if missing.
bool file_cache_folder(Arena *arena, char **path, Error *error);

uint64_t file_hash(const void *data, size_t size, uint64_t seed);  // XXH3, 64 bits

#endif
