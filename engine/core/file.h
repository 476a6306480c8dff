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

// Fails on a missing or unreadable file, on one of more than `limit` bytes, and, without waiting, on what is no regular file.
bool file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error);

// Writes beside `path`, flushes to disk and renames: an earlier file survives any failure. A symbolic link stays, and the file
// that it leads to is written. The new file has the owner, group, mode and access list of the earlier one, as far as the user may
// give them; as after other writing it loses the set-user-ID and set-group-ID bits, and other hard links keep the earlier content.
// A read-only file is refused, and so is one whose folder takes no other file. A device, a pipe or /dev/stdout is written into.
bool file_write(const char *path, const void *data, size_t size, Error *error);

// Could a file of so many bytes be written there now? Leaves nothing behind.
bool file_check(const char *path, size_t size, Error *error);

// Are both the same file, or would they be?
bool file_same(const char *a, const char *b);

// A file while it is written, for those who write piece by piece: it has no name, or, where the file system knows only files with
// names, one beside its own. What a killed program leaves under that name goes when the same path is written again.
enum { FILE_LONGEST_PATH = 4096 };  // as the system takes, with a zero
typedef struct FileDraft {
    int fd;
    const char *path;                // as given
    char target[FILE_LONGEST_PATH];  // with links followed
    char beside[FILE_LONGEST_PATH];  // the name until it is kept; "": none
    bool stream;                     // a device or a pipe: what is written has left
} FileDraft;
bool file_begin(const char *path, FileDraft *out, Error *error);
bool file_keep(FileDraft *draft,
               Error *error);  // in place of an earlier file; ends the draft, whatever comes of it
void file_drop(FileDraft *draft);

// Makes the folder and those above it.
bool file_make_folder(const char *path, Error *error);

// `$XDG_CACHE_HOME/enfilade` or `~/.cache/enfilade`, which need not be there. Fails where neither variable is set.
bool file_cache_folder(Arena *arena, char **path, Error *error);

uint64_t file_hash(const void *data, size_t size, uint64_t seed);  // XXH3, 64 bits

#endif
