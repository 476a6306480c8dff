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

// Fails on a missing or unreadable file, on a file of more than `limit` bytes, and, without waiting, on all but regular files.
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

// A file while it is written, for callers that write piece by piece. The file has no name, or, where the file system knows only
// files with names, a name beside its own. A file that a killed program leaves under that name goes when the path is written again.
enum { FILE_LONGEST_PATH = 4096 };  // as the system takes, with a zero
typedef struct FileDraft {
    int fd;
    const char *path;                // as given
    char target[FILE_LONGEST_PATH];  // with links followed
    char beside[FILE_LONGEST_PATH];  // the name until it is kept; "": none
    bool stream;                     // a device or a pipe: bytes that were written cannot be taken back
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

// ---- files that are made from a building and can be made again (.vis, .rad): how each file begins, and which files are refused
// before their contents are looked at
//
// A header that begins with a DerivedHead, then a body, in the machine's own byte order. A file is read in two steps, since the
// length of the body stands in the header: derived_read, the caller's look at its header, derived_check_body.

// The beginning of a derived file.
typedef struct DerivedHead {
    char magic[8];
    uint32_t version, byte_order;
    uint64_t building;  // hash of the building's file
    uint64_t geometry;  // hash of the geometry to which the body belongs; the caller computes and compares it
    uint64_t body;      // checksum of all bytes that follow the header
} DerivedHead;

// A format of derived files.
typedef struct DerivedKind {
    char magic[8];
    const char *name;  // of the format, for messages: ".vis"
    uint32_t version;
    size_t header;   // bytes, DerivedHead included
    size_t largest;  // bytes of a file that is read
} DerivedKind;

// Returns zeroed memory for a file of this kind, to be freed by memory_free. Returns NULL, with a sentence, where there is none: a
// result that took hours to make is not lost for lack of memory to store it.
unsigned char *derived_new(const char *path, const DerivedKind *kind, size_t body_size, Error *error);

// Fills the DerivedHead of a file that is complete but for it, and writes the file.
bool derived_write(const char *path, const DerivedKind *kind, uint64_t building, uint64_t geometry,
                   unsigned char *file, size_t body_size, Error *error);

// Reads a file that is of this kind, version and building; `out` holds a header at least.
bool derived_read(const char *path, const DerivedKind *kind, uint64_t building, Arena *arena, Bytes *out,
                  Error *error);

// Is the body as long as the header tells, and as it was written?
bool derived_check_body(const char *path, const DerivedKind *kind, Bytes file, size_t body_size,
                        Error *error);

#endif
