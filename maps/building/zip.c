// zip.c - entries of a ZIP archive (PKWARE APPNOTE) through libzip. What the directory claims about sizes is
// checked against the limits before anything is unpacked, and what is unpacked against what was claimed.
#include "maps/building/zip.h"

#include <errno.h>
#include <zip.h>

#include "engine/core/memory.h"

struct Archive {
    zip_t *zip;
    const char *path;
    size_t unpacked;  // bytes read so far
};

// Libzip reports some failures to get memory as others, a damaged file for one: what the C library says is right. To be asked
// after a failure, with errno 0 before.
static void check_memory(void) {
    if (errno == ENOMEM) memory_end_library("libzip");
}

bool archive_open(Bytes content, const char *path, Arena *arena, Archive **out, Error *error) {
    zip_error_t reason;
    zip_error_init(&reason);
    errno = 0;
    zip_source_t *source = zip_source_buffer_create(content.data, content.size, 0, &reason);
    zip_t *zip = source ? zip_open_from_source(source, ZIP_RDONLY, &reason) : NULL;
    if (!zip) {
        check_memory();
        error_set(error, "%s: not a usable ZIP file (%s); it may be cut short", path,
                  zip_error_strerror(&reason));
        if (source) zip_source_free(source);
        zip_error_fini(&reason);
        return false;
    }
    zip_error_fini(&reason);
    zip_int64_t entries = zip_get_num_entries(zip, 0);
    if (entries > ARCHIVE_MAX_ENTRIES) {
        zip_discard(zip);
        return error_set(error, "%s: the ZIP file has %lld entries (at most %d are allowed)", path,
                         (long long)entries, ARCHIVE_MAX_ENTRIES);
    }
    Archive *archive = ARENA_ARRAY(arena, Archive, 1);
    archive->zip = zip;
    archive->path = arena_string(arena, path);
    *out = archive;
    return true;
}

bool archive_has(const Archive *archive, const char *name) {
    return zip_name_locate(archive->zip, name, ZIP_FL_ENC_GUESS) >= 0;
}

static bool size_allowed(const Archive *archive, const char *name, const zip_stat_t *stat, size_t limit,
                         Error *error) {
    if (limit > ARCHIVE_MAX_ENTRY) limit = ARCHIVE_MAX_ENTRY;
    if (stat->size > limit)
        return error_set(error, "%s: entry %s unpacks to %llu bytes (at most %zu are allowed)", archive->path,
                         name, (unsigned long long)stat->size, limit);
    if (stat->size > ARCHIVE_RATIO_FROM && stat->size / ARCHIVE_MAX_RATIO > stat->comp_size)
        return error_set(error, "%s: entry %s unpacks from %llu to %llu bytes (at most %d times is allowed)",
                         archive->path, name, (unsigned long long)stat->comp_size,
                         (unsigned long long)stat->size, ARCHIVE_MAX_RATIO);
    if (archive->unpacked + stat->size > ARCHIVE_MAX_TOTAL)
        return error_set(error, "%s: its entries unpack to more than %zu bytes", archive->path,
                         ARCHIVE_MAX_TOTAL);
    return true;
}

// Reads to the end, which is also what makes libzip compare the checksum.
static bool read_all(zip_file_t *file, unsigned char *data, size_t size) {
    size_t have = 0;
    for (;;) {
        unsigned char beyond;
        zip_int64_t got =
            have < size ? zip_fread(file, data + have, size - have) : zip_fread(file, &beyond, 1);
        if (got < 0 || (have == size && got > 0)) return false;
        if (got == 0) return have == size;
        have += (size_t)got;
    }
}

bool archive_read(Archive *archive, const char *name, size_t limit, Arena *arena, Bytes *out, Error *error) {
    zip_stat_t stat;
    zip_int64_t index = zip_name_locate(archive->zip, name, ZIP_FL_ENC_GUESS);
    if (index < 0 || zip_stat_index(archive->zip, (zip_uint64_t)index, 0, &stat) != 0)
        return error_set(error, "%s: no entry %s in the ZIP file", archive->path, name);
    if (!(stat.valid & ZIP_STAT_SIZE) || !(stat.valid & ZIP_STAT_COMP_SIZE))
        return error_set(error, "%s: entry %s does not say its size", archive->path, name);
    if (!size_allowed(archive, name, &stat, limit, error)) return false;
    errno = 0;
    zip_file_t *file = zip_fopen_index(archive->zip, (zip_uint64_t)index, 0);
    if (!file) check_memory();
    if (!file)
        return error_set(error, "%s: entry %s cannot be unpacked (%s)", archive->path, name,
                         zip_strerror(archive->zip));
    out->size = (size_t)stat.size;
    out->data = ARENA_ARRAY(arena, unsigned char, out->size + 1);
    archive->unpacked += out->size;
    errno = 0;
    bool whole = read_all(file, out->data, out->size);
    if (!whole) check_memory();
    const char *reason = zip_error_strerror(zip_file_get_error(file));
    if (!whole) error_set(error, "%s: entry %s is damaged (%s)", archive->path, name, reason);
    zip_fclose(file);
    return whole;
}

void archive_close(Archive *archive) {
    if (archive && archive->zip) zip_discard(archive->zip);
    if (archive) archive->zip = NULL;
}
