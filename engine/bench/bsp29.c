// bsp29.c - layout: the version, then offset and size of 15 lumps, then the lumps. Leaf 0 is all that is solid; cell c is
// leaf c + 1, whose `visofs` says where its row begins in the visibility lump. Rows are run-length coded: a zero byte is
// followed by how many zero bytes it stands for (id Software, 1996). Little-endian.
#include "engine/bench/bsp29.h"

enum { VERSION = 29, LUMPS = 15, ENTITIES = 0, TEXTURES = 2, VISIBILITY = 4, LEAVES = 10, MODELS = 14 };
enum { HEAD = 4 + 8 * LUMPS, LEAF_SIZE = 28, MODEL_SIZE = 64 };
enum { CONTENTS_EMPTY = -1, CONTENTS_SOLID = -2, NONE = -1 };
// Where in their records what is not zero stands.
enum { LEAF_ROW = 4, MODEL_HEAD_NODES = 36, MODEL_LEAVES = 52 };
static const char ENTITY_TEXT[] = "{\n\"classname\" \"worldspawn\"\n}\n";

static void put(unsigned char *at, int value) {
    for (int k = 0; k < 4; k++) at[k] = (unsigned char)((uint32_t)value >> (8 * k));
}
static int get(const unsigned char *at) {
    return (int)(at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24);
}

Bytes bsp29_make(int cell_count, Arena *arena) {
    size_t sizes[LUMPS] = {[ENTITIES] = sizeof ENTITY_TEXT,
                           [TEXTURES] = 4,
                           [LEAVES] = LEAF_SIZE * ((size_t)cell_count + 1),
                           [MODELS] = MODEL_SIZE};
    size_t at[LUMPS], size = HEAD;
    for (int i = 0; i < LUMPS; i++) {
        at[i] = size;
        size += (sizes[i] + 3) / 4 * 4;
    }
    unsigned char *data = arena_alloc(arena, size, 1);
    put(data, VERSION);
    for (int i = 0; i < LUMPS; i++) {
        put(data + 4 + 8 * i, (int)at[i]);
        put(data + 8 + 8 * i, (int)sizes[i]);
    }
    memcpy(data + at[ENTITIES], ENTITY_TEXT, sizeof ENTITY_TEXT);
    for (int c = 0; c <= cell_count; c++) {
        unsigned char *leaf = data + at[LEAVES] + (size_t)c * LEAF_SIZE;
        put(leaf, c == 0 ? CONTENTS_SOLID : CONTENTS_EMPTY);
        put(leaf + LEAF_ROW, NONE);
    }
    for (int k = 1; k < 3; k++) put(data + at[MODELS] + MODEL_HEAD_NODES + 4 * k, NONE);
    put(data + at[MODELS] + MODEL_LEAVES, cell_count);
    return (Bytes){data, size};
}

static bool find_lump(const char *path, Bytes content, int lump, Bytes *out, Error *error) {
    int from = get(content.data + 4 + 8 * lump), size = get(content.data + 8 + 8 * lump);
    if (from < 0 || size < 0 || (size_t)from + (size_t)size > content.size)
        return error_set(error, "%s: lump %d reaches from %d over %d bytes (the file has %zu)", path, lump,
                         from, size, content.size);
    *out = (Bytes){content.data + from, (size_t)size};
    return true;
}

// Unpacks the row that begins at `from`; false where it is cut short.
static bool unpack(Bytes packed, size_t from, int cell_count, uint64_t *row) {
    size_t bytes = ((size_t)cell_count + 7) / 8, at = from;
    for (size_t k = 0; k < bytes;) {
        if (at >= packed.size) return false;
        unsigned char byte = packed.data[at++];
        if (byte) {
            row[k / 8] |= (uint64_t)byte << (k % 8 * 8);
            k++;
        } else {
            if (at >= packed.size || packed.data[at] == 0) return false;
            k += packed.data[at++];
        }
    }
    if (cell_count % 64) row[cell_count / 64] &= ((uint64_t)1 << (cell_count % 64)) - 1;
    return true;
}

bool bsp29_read_seen(const char *path, int cell_count, Arena *arena, uint64_t **rows, Error *error) {
    enum { LIMIT = 1 << 30 };
    Bytes content, leaves, packed;
    if (!file_read(path, LIMIT, arena, &content, error)) return false;
    if (content.size < HEAD || get(content.data) != VERSION)
        return error_set(error, "%s: is no level of version %d", path, VERSION);
    if (!find_lump(path, content, LEAVES, &leaves, error) ||
        !find_lump(path, content, VISIBILITY, &packed, error))
        return false;
    if (leaves.size != LEAF_SIZE * ((size_t)cell_count + 1)) {
        return error_set(error, "%s: has %zu leaves (expected %d)", path, leaves.size / LEAF_SIZE,
                         cell_count + 1);
    }
    size_t words = ((size_t)cell_count + 63) / 64;
    *rows = ARENA_ARRAY(arena, uint64_t, (size_t)cell_count * words);
    for (int c = 0; c < cell_count; c++) {
        int from = get(leaves.data + (size_t)(c + 1) * LEAF_SIZE + LEAF_ROW);
        if (from < 0 || !unpack(packed, (size_t)from, cell_count, *rows + (size_t)c * words))
            return error_set(error, "%s: leaf %d has no visibility", path, c + 1);
    }
    return true;
}
