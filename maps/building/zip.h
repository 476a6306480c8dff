// zip.h - reading entries of a ZIP archive that lies in memory, guarded against archive bombs.
#ifndef MAPS_ZIP_H
#define MAPS_ZIP_H

#include "engine/core/file.h"

typedef struct Archive Archive;  // opaque: minizip's machinery

// The most entries: more than any building file has (the largest seen: a few hundred).
#define ARCHIVE_MAX_ENTRIES 65536
// The most bytes of one unpacked entry: a model of some million faces.
#define ARCHIVE_MAX_ENTRY ((size_t)256 << 20)
// The most bytes of all entries read from one archive together.
#define ARCHIVE_MAX_TOTAL ((size_t)1 << 30)
// An entry above ARCHIVE_RATIO_FROM bytes may not unpack to more than this many times its packed size: text of
// models packs to a tenth, a bomb to a thousandth.
#define ARCHIVE_MAX_RATIO 200
#define ARCHIVE_RATIO_FROM ((size_t)4 << 20)

// `content` must stay in memory until archive_close. `path` is for messages.
bool archive_open(Bytes content, const char *path, Arena *arena, Archive **out, Error *error);
bool archive_has(const Archive *archive, const char *name);
// Fails on a missing, damaged or encrypted entry and on an entry beyond `limit` bytes or the limits above.
bool archive_read(Archive *archive, const char *name, size_t limit, Arena *arena, Bytes *out, Error *error);
void archive_close(Archive *archive);  // NULL is allowed

#endif
