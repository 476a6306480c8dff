// derived.h - files that are made from a building and can be made again (.vis, .rad): how each begins, and what is refused
// before its contents are looked at.
//
// A header that begins with a DerivedHead, then a body, in the machine's own byte order. A file is read in two steps, since
// how long the body has to be stands in the header: derived_read, the caller's look at its header, derived_check_body.
#ifndef CORE_DERIVED_H
#define CORE_DERIVED_H

#include "engine/core/file.h"

typedef struct DerivedHead {
    char magic[8];
    uint32_t version, byte_order;
    uint64_t building;  // hash of the building's file
    uint64_t geometry;  // hash of what the body's numbers belong to: the caller's to compute and to compare
    uint64_t body;      // checksum of all that follows the header
} DerivedHead;

typedef struct DerivedKind {
    char magic[8];
    const char *name;  // of the format, for messages: ".vis"
    uint32_t version;
    size_t header;   // bytes, DerivedHead included
    size_t largest;  // bytes of a file that is read
} DerivedKind;

// Zeroed memory for a file of this kind, for memory_free. NULL, with a sentence, where there is none: what took hours to make is
// not lost for lack of memory to store it.
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
