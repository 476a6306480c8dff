// zip.c - entries of a ZIP archive (PKWARE APPNOTE) through minizip. The sizes that the directory claims are checked against the limits
// before an entry is unpacked, and the unpacked bytes against the claim. Entries are found in an index of their names, since minizip
// would look through the whole directory for each entry.
#include "maps/building/zip.h"

#include <errno.h>
#include <minizip/unzip.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/memory.h"

typedef struct Entry {
    const char *name;
    unz64_file_pos at;
    // Its number in the directory: of several entries of one name the first counts.
    int number;
} Entry;

// The archive as minizip reads it: a file in memory.
typedef struct ZipMemory {
    Bytes content;
    size_t at;
} ZipMemory;

struct Archive {
    unzFile zip;
    const char *path;
    ZipMemory memory;
    Entry *entries;  // [entry_count] by name
    int entry_count;
    size_t unpacked;  // bytes read so far
};

// ---- the file in memory

static voidpf ZCALLBACK memory_open(voidpf opaque, const void *name, int mode) {
    (void)name;
    (void)mode;
    return opaque;
}

static uLong ZCALLBACK memory_read(voidpf opaque, voidpf stream, void *out, uLong size) {
    ZipMemory *m = stream;
    (void)opaque;
    size_t left = m->content.size - m->at;
    if (size > left) size = left;
    if (size > 0) memcpy(out, m->content.data + m->at, size);
    m->at += size;
    return size;
}

static ZPOS64_T ZCALLBACK memory_tell(voidpf opaque, voidpf stream) {
    (void)opaque;
    return ((ZipMemory *)stream)->at;
}

static long ZCALLBACK memory_seek(voidpf opaque, voidpf stream, ZPOS64_T offset, int origin) {
    ZipMemory *m = stream;
    (void)opaque;
    size_t from = origin == ZLIB_FILEFUNC_SEEK_CUR   ? m->at
                  : origin == ZLIB_FILEFUNC_SEEK_END ? m->content.size
                                                     : 0;
    if (offset > m->content.size - from) return -1;
    m->at = from + offset;
    return 0;
}

static int ZCALLBACK memory_close(voidpf opaque, voidpf stream) {
    (void)opaque;
    (void)stream;
    return 0;
}

// ---- the index

static int by_name(const void *p, const void *q) {
    const Entry *a = p, *b = q;
    int order = strcmp(a->name, b->name);
    return order ? order : a->number - b->number;
}

// Indexes the archive's entries by name. Returns false where the directory is damaged.
static bool list_entries(Archive *archive, int count, Arena *arena) {
    char name[1024];
    archive->entries = ARENA_ARRAY(arena, Entry, count + 1);
    for (int i = 0; i < count; i++) {
        Entry *entry = &archive->entries[archive->entry_count];
        int status = i == 0 ? unzGoToFirstFile(archive->zip) : unzGoToNextFile(archive->zip);
        if (status != UNZ_OK || unzGetFilePos64(archive->zip, &entry->at) != UNZ_OK ||
            unzGetCurrentFileInfo64(archive->zip, NULL, name, sizeof name, NULL, 0, NULL, 0) != UNZ_OK)
            return false;
        // No building refers to a longer name.
        if (memchr(name, 0, sizeof name) == NULL) continue;
        entry->name = arena_string(arena, name);
        entry->number = i;
        archive->entry_count++;
    }
    qsort(archive->entries, (size_t)archive->entry_count, sizeof *archive->entries, by_name);
    return true;
}

// The first entry of this name, or NULL.
static const Entry *find_entry(const Archive *archive, const char *name) {
    int low = 0, high = archive->entry_count;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (strcmp(archive->entries[middle].name, name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == archive->entry_count || strcmp(archive->entries[low].name, name) != 0) return NULL;
    return &archive->entries[low];
}

// ---- the archive

// Ends the program where a call of minizip failed for lack of memory. Minizip reports this like other failures, such as a damaged
// file, but the C library sets errno. Set errno to 0 before the call of minizip.
static void check_memory(void) {
    if (errno == ENOMEM) memory_end_library("minizip");
}

bool archive_open(Bytes content, const char *path, Arena *arena, Archive **out, Error *error) {
    Archive *archive = ARENA_ARRAY(arena, Archive, 1);
    *archive = (Archive){.path = arena_string(arena, path), .memory = {content, 0}};
    zlib_filefunc64_def calls = {.zopen64_file = memory_open,
                                 .zread_file = memory_read,
                                 .ztell64_file = memory_tell,
                                 .zseek64_file = memory_seek,
                                 .zclose_file = memory_close,
                                 .zerror_file = memory_close,
                                 .opaque = &archive->memory};
    unz_global_info64 info = {0};
    errno = 0;
    archive->zip = unzOpen2_64(path, &calls);
    bool good = archive->zip && unzGetGlobalInfo64(archive->zip, &info) == UNZ_OK;
    if (good && info.number_entry > ARCHIVE_MAX_ENTRIES) {
        archive_close(archive);
        return error_set(error, "%s: the ZIP file has %llu entries (at most %d are allowed)", path,
                         (unsigned long long)info.number_entry, ARCHIVE_MAX_ENTRIES);
    }
    if (!good || !list_entries(archive, (int)info.number_entry, arena)) {
        check_memory();
        archive_close(archive);
        return error_set(error, "%s: not a usable ZIP file; it may be cut short", path);
    }
    *out = archive;
    return true;
}

bool archive_has(const Archive *archive, const char *name) { return find_entry(archive, name) != NULL; }

static bool size_allowed(const Archive *archive, const char *name, const unz_file_info64 *info, size_t limit,
                         Error *error) {
    size_t packed = info->compressed_size, unpacked = info->uncompressed_size;
    if (limit > ARCHIVE_MAX_ENTRY) limit = ARCHIVE_MAX_ENTRY;
    if (unpacked > limit)
        return error_set(error, "%s: entry %s unpacks to %zu bytes (at most %zu are allowed)", archive->path,
                         name, unpacked, limit);
    if (unpacked > ARCHIVE_RATIO_FROM && unpacked / ARCHIVE_MAX_RATIO > packed)
        return error_set(error, "%s: entry %s unpacks from %zu to %zu bytes (at most %d times is allowed)",
                         archive->path, name, packed, unpacked, ARCHIVE_MAX_RATIO);
    if (archive->unpacked + unpacked > ARCHIVE_MAX_TOTAL)
        return error_set(error, "%s: its entries unpack to more than %zu bytes", archive->path,
                         ARCHIVE_MAX_TOTAL);
    return true;
}

// Reads the current entry to its end, where minizip compares the checksum.
static bool read_all(unzFile zip, unsigned char *data, size_t size) {
    size_t have = 0;
    int got = 0;
    unsigned char beyond;
    while (have < size && (got = unzReadCurrentFile(zip, data + have, (unsigned)(size - have))) > 0)
        have += (size_t)got;
    if (have == size && got >= 0) got = unzReadCurrentFile(zip, &beyond, 1);
    return unzCloseCurrentFile(zip) == UNZ_OK && have == size && got == 0;
}

bool archive_read(Archive *archive, const char *name, size_t limit, Arena *arena, Bytes *out, Error *error) {
    enum { ENCRYPTED = 1 };
    unz_file_info64 info;
    unzFile zip = archive->zip;
    const Entry *entry = find_entry(archive, name);
    if (!entry || unzGoToFilePos64(zip, &entry->at) != UNZ_OK ||
        unzGetCurrentFileInfo64(zip, &info, NULL, 0, NULL, 0, NULL, 0) != UNZ_OK)
        return error_set(error, "%s: no entry %s in the ZIP file", archive->path, name);
    if (info.flag & ENCRYPTED)
        return error_set(error, "%s: entry %s is encrypted (allowed: entries without a password)",
                         archive->path, name);
    if (!size_allowed(archive, name, &info, limit, error)) return false;
    errno = 0;
    if (unzOpenCurrentFile(zip) != UNZ_OK) {
        check_memory();
        return error_set(error, "%s: entry %s cannot be unpacked (allowed: stored or deflated, undamaged)",
                         archive->path, name);
    }
    out->size = (size_t)info.uncompressed_size;
    out->data = ARENA_ARRAY(arena, unsigned char, out->size + 1);
    archive->unpacked += out->size;
    errno = 0;
    if (read_all(zip, out->data, out->size)) return true;
    check_memory();
    return error_set(error, "%s: entry %s is damaged", archive->path, name);
}

void archive_close(Archive *archive) {
    if (archive && archive->zip) unzClose(archive->zip);
    if (archive) archive->zip = NULL;
}
