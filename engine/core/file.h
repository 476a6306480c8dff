// file.h - whole files: read at once, written whole or not at all, hashed.
#ifndef CORE_FILE_H
#define CORE_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"

// The content of a file.
typedef struct Bytes {
    unsigned char *data;  // followed by a zero byte that is not counted
    size_t size;
} Bytes;

// Reads a whole regular file. Fails on a missing or unreadable file, on a file of more than `limit` bytes and, without waiting, on
// anything but a regular file.
bool file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error);
// The same by this many threads; 0: as many as there are processors, as file_read takes for large files.
bool file_read_by(const char *path, size_t limit, int threads, Arena *arena, Bytes *out, Error *error);

// Writes a new file beside `path`, flushes it to disk and renames it, so that an earlier file survives any failure. A symbolic link
// stays, and the file that it leads to is replaced. The new file has the owner, group, mode and access list of the earlier file, as
// far as the user may set them; as after any other write it loses the set-user-ID and set-group-ID bits, and other hard links keep
// the earlier content. A read-only file is refused, and so is a file in whose folder no other file can be made. A device, a pipe or
// /dev/stdout is written into directly.
bool file_write(const char *path, const void *data, size_t size, Error *error);

// Could a file of `size` bytes be written at `path` now? The check leaves nothing behind.
bool file_check(const char *path, size_t size, Error *error);

// Do both paths lead to the same regular file or, where neither file exists, would they once it is written?
bool file_same(const char *a, const char *b);

// A file that is being written, for callers that write piece by piece. Until file_keep it has no name or, where the file system has
// no nameless files, a temporary name beside its own. A file that a killed program left under a temporary name is removed when the
// path is written again.
enum { FILE_LONGEST_PATH = 4096 };  // the system's limit, with the zero byte
typedef struct FileDraft {
    int fd;
    const char *path;                // as given
    char target[FILE_LONGEST_PATH];  // with links followed
    char beside[FILE_LONGEST_PATH];  // the temporary name; "": none
    bool stream;                     // a device or a pipe: bytes that were written cannot be taken back
} FileDraft;
bool file_begin(const char *path, FileDraft *out, Error *error);
// Puts the file in place of an earlier one. Ends the draft, whether it succeeds or fails.
bool file_keep(FileDraft *draft, Error *error);
void file_drop(FileDraft *draft);

// Makes the folder and the missing folders above it.
bool file_make_folder(const char *path, Error *error);

// Gives `$XDG_CACHE_HOME/enfilade` or `~/.cache/enfilade`; the folder need not exist. Fails where neither XDG_CACHE_HOME nor HOME
// is set.
bool file_cache_folder(Arena *arena, char **path, Error *error);

uint64_t file_hash(const void *data, size_t size, uint64_t seed);  // XXH3, 64 bits

// ---- derived files, which are made from a building and can be made again (.vis, .rad): how each file begins, and which files are
// refused before their contents are looked at
//
// A derived file is a header that begins with a DerivedHead, then a body, in the machine's own byte order. It is read in two steps,
// since the length of the body follows from the header: derived_read and, after the caller has looked at the header,
// derived_check_body.

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
    size_t largest;  // bytes; a larger file is refused
} DerivedKind;

// The bytes of a body, in their order, any number at a time.
typedef struct DerivedSink DerivedSink;
void derived_put(DerivedSink *sink, const void *data, size_t size);
// Puts a whole body. It is called several times, puts the same each time, and requests no memory: a result that took hours to make must
// not be lost for lack of memory to store it.
typedef void DerivedBody(DerivedSink *sink, const void *context);

// Writes a header, in which it fills in the DerivedHead, and a body, as file_write does.
bool derived_write(const char *path, const DerivedKind *kind, uint64_t building, uint64_t geometry,
                   void *header, DerivedBody *body, const void *context, Error *error);

// Reads a file and checks that it is of this kind, version and building. `out` then holds at least a header.
bool derived_read(const char *path, const DerivedKind *kind, uint64_t building, Arena *arena, Bytes *out,
                  Error *error);

// Reads and checks the header alone, and tells how many bytes the whole file has.
bool derived_read_header(const char *path, const DerivedKind *kind, uint64_t building, Arena *arena,
                         Bytes *out, size_t *whole, Error *error);

// Has the file as many bytes as a body of `body_size` makes? The body itself may be damaged all the same.
bool derived_check_size(const char *path, const DerivedKind *kind, size_t whole, size_t body_size,
                        Error *error);

// Has the body `body_size` bytes, the length that the caller took from the header, and the checksum of the head?
bool derived_check_body(const char *path, const DerivedKind *kind, Bytes file, size_t body_size,
                        Error *error);

// Or a large file is read piece by piece.
typedef struct DerivedReader {
    const char *path;
    FILE *file;
    size_t header;  // bytes of it
    size_t left;    // bytes of the body that are not taken yet
} DerivedReader;
// Reads and checks the header, as derived_read does. To be ended if true.
bool derived_begin(const char *path, const DerivedKind *kind, uint64_t building, void *header,
                   DerivedReader *out, Error *error);
// Has the body, of which nothing was taken yet, the checksum of the head?
bool derived_sound(DerivedReader *reader, const void *header, Error *error);
// Takes the next bytes; false where fewer are left, or where they cannot be read.
bool derived_take(DerivedReader *reader, void *out, size_t size);
void derived_end(DerivedReader *reader);

#endif
