// seen_file.c - reading and writing `.seen` files.
#include "visibility/pairs/seen_file.h"

#include "maps/building/building.h"

enum { HEAD = 4 };

static size_t row_bytes(int cell_count) { return ((size_t)cell_count + 7) / 8; }
static size_t file_size(int cell_count) { return HEAD + (size_t)cell_count * row_bytes(cell_count); }

static bool check_row(const char *path, const uint64_t *row, int i, int cell_count, Error *error) {
    if (!(row[i / 64] >> (i % 64) & 1))
        return error_set(error, "%s: cell %d does not see itself (every cell does)", path, i);
    int last = (cell_count - 1) / 64, beyond = cell_count % 64;
    if (beyond && row[last] >> beyond) {
        return error_set(error, "%s: cell %d sees cell %d (allowed 0 to %d)", path, i,
                         last * 64 + 63 - __builtin_clzll(row[last]), cell_count - 1);
    }
    return true;
}

bool seen_parse(const char *path, Bytes content, int cell_count, Arena *arena, uint64_t **rows,
                Error *error) {
    const unsigned char *data = content.data;
    if (content.size < HEAD)
        return error_set(error, "%s: has %zu bytes (at least %d)", path, content.size, HEAD);
    uint32_t told = data[0] | (uint32_t)data[1] << 8 | (uint32_t)data[2] << 16 | (uint32_t)data[3] << 24;
    if (told != (uint32_t)cell_count)
        return error_set(error, "%s: is of %u cells (expected %d)", path, told, cell_count);
    if (content.size != file_size(cell_count)) {
        return error_set(error, "%s: has %zu bytes (expected %zu for %d cells)", path, content.size,
                         file_size(cell_count), cell_count);
    }
    size_t bytes = row_bytes(cell_count), words = ((size_t)cell_count + 63) / 64;
    *rows = ARENA_ARRAY(arena, uint64_t, (size_t)cell_count * words);
    for (int i = 0; i < cell_count; i++) {
        const unsigned char *in = data + HEAD + (size_t)i * bytes;
        uint64_t *row = *rows + (size_t)i * words;
        for (size_t k = 0; k < bytes; k++) row[k / 8] |= (uint64_t)in[k] << (k % 8 * 8);
        if (!check_row(path, row, i, cell_count, error)) return false;
    }
    return true;
}

bool seen_read(const char *path, int cell_count, Arena *arena, uint64_t **rows, Error *error) {
    Arena scratch = {0};
    Bytes content;
    bool good = file_read(path, file_size(MAPS_MAX_GIVEN_CELLS), &scratch, &content, error) &&
                seen_parse(path, content, cell_count, arena, rows, error);
    arena_free(&scratch);
    return good;
}

bool seen_write(const char *path, const uint64_t *rows, int cell_count, Error *error) {
    Arena scratch = {0};
    size_t bytes = row_bytes(cell_count), words = ((size_t)cell_count + 63) / 64,
           size = file_size(cell_count);
    unsigned char *data = arena_alloc(&scratch, size, 1);
    for (int k = 0; k < HEAD; k++) data[k] = (unsigned char)((uint32_t)cell_count >> (8 * k));
    for (int i = 0; i < cell_count; i++) {
        unsigned char *out = data + HEAD + (size_t)i * bytes;
        const uint64_t *row = rows + (size_t)i * words;
        for (size_t k = 0; k < bytes; k++) out[k] = (unsigned char)(row[k / 8] >> (k % 8 * 8));
    }
    bool good = file_write(path, data, size, error);
    arena_free(&scratch);
    return good;
}
