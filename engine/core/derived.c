// derived.c - the common head of derived files: written, and held against kind, version, building and checksum.
#include "engine/core/derived.h"

#include <string.h>

#include "engine/core/memory.h"

static const uint32_t BYTE_ORDER_MARK = 0x01020304;

_Static_assert(sizeof(DerivedHead) == 40, "the files that exist begin with 40 bytes");

unsigned char *derived_new(const char *path, const DerivedKind *kind, size_t body_size, Error *error) {
    unsigned char *file = memory_try(kind->header + body_size);
    if (!file) error_set(error, "%s: no memory for %zu bytes", path, kind->header + body_size);
    return file;
}

bool derived_write(const char *path, const DerivedKind *kind, uint64_t building, uint64_t geometry,
                   unsigned char *file, size_t body_size, Error *error) {
    DerivedHead head = {.version = kind->version,
                        .byte_order = BYTE_ORDER_MARK,
                        .building = building,
                        .geometry = geometry,
                        .body = file_hash(file + kind->header, body_size, 0)};
    memcpy(head.magic, kind->magic, sizeof head.magic);
    memcpy(file, &head, sizeof head);
    return file_write(path, file, kind->header + body_size, error);
}

static bool check_head(const char *path, const DerivedKind *kind, const DerivedHead *head, uint64_t building,
                       Error *error) {
    if (memcmp(head->magic, kind->magic, sizeof head->magic) != 0)
        return error_set(error, "%s: is not a %s file", path, kind->name);
    if (head->byte_order != BYTE_ORDER_MARK)
        return error_set(error, "%s: was written on a machine of another byte order", path);
    if (head->version != kind->version) {
        return error_set(error, "%s: has version %u (this program reads version %u)", path, head->version,
                         kind->version);
    }
    if (head->building != building)
        return error_set(error, "%s: belongs to another building, or to an earlier state of this one", path);
    return true;
}

bool derived_read(const char *path, const DerivedKind *kind, uint64_t building, Arena *arena, Bytes *out,
                  Error *error) {
    if (!file_read(path, kind->largest, arena, out, error)) return false;
    if (out->size < kind->header)
        return error_set(error, "%s: has %zu bytes, less than a %s header", path, out->size, kind->name);
    DerivedHead head;
    memcpy(&head, out->data, sizeof head);
    return check_head(path, kind, &head, building, error);
}

bool derived_check_body(const char *path, const DerivedKind *kind, Bytes file, size_t body_size,
                        Error *error) {
    size_t expected = kind->header + body_size;
    if (file.size != expected)
        return error_set(error, "%s: has %zu bytes (its header says %zu)", path, file.size, expected);
    DerivedHead head;
    memcpy(&head, file.data, sizeof head);
    if (file_hash(file.data + kind->header, body_size, 0) != head.body)
        return error_set(error, "%s: is damaged: its checksum is wrong", path);
    return true;
}
