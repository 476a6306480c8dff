// target.c - bytes for fuzz targets, and the target that all readers of buildings share.
#include "tests/target.h"

#include <stdlib.h>

Bytes target_bytes(Arena *arena, const char *head, const unsigned char *data, size_t size) {
    size_t before = strlen(head);
    unsigned char *copy = arena_alloc(arena, before + size + 1, 1);
    memcpy(copy, head, before);
    if (size > 0) memcpy(copy + before, data, size);
    return (Bytes){copy, before + size};
}

bool target_read(const MapsReader *reader, const char *path, Bytes content, Arena *arena, Building *out) {
    Error error = {""};
    bool read = reader->read(path, content, arena, out, &error);
    if (!read && error.text[0] == 0) abort();
    return read;
}

int target_reader(const MapsReader *reader, const char *path, const unsigned char *data, size_t size) {
    Arena arena = {0};
    Building b = {0};
    const char *fault;
    Bytes content = target_bytes(&arena, "", data, size);
    reader->recognise(content);
    if (target_read(reader, path, content, &arena, &b) && building_check(&b, &arena, &fault, 1) != 0) abort();
    arena_free(&arena);
    return 0;
}
