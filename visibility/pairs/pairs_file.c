// pairs_file.c - see pairs_file.h.
#include "visibility/pairs/pairs_file.h"

#include <string.h>

#include "engine/core/file.h"

typedef struct Header {
    DerivedHead head;
    int32_t cell_count, words;
} Header;

static const DerivedKind KIND = {
    .magic = "ENFPAIR", .name = ".pairs", .version = 1, .header = sizeof(Header), .largest = (size_t)4 << 30};

static size_t rows_size(int cells, int words) { return (size_t)cells * (size_t)words * sizeof(uint64_t); }

static void put_rows(DerivedSink *sink, const void *context) {
    const PairSet *set = context;
    size_t rows = rows_size(set->cell_count, set->words);
    derived_put(sink, set->seen, rows);
    derived_put(sink, set->proven, rows);
}

bool pairs_save(const char *path, const CellGraph *graph, const PairSet *set, Error *error) {
    Header header = {.cell_count = set->cell_count, .words = set->words};
    uint64_t hash = vis_geometry_hash(graph);
    return derived_write(path, &KIND, hash, hash, &header, put_rows, set, error);
}

// Do the rows say of each pair the same both ways, of each cell that it sees itself, and that what is proven is seen?
static bool rows_hold(const PairSet *set) {
    for (int a = 0; a < set->cell_count; a++) {
        if (!pair_bit(set->seen, set->words, a, a)) return false;
        for (int b = 0; b < set->words * 64; b++) {
            bool seen = pair_bit(set->seen, set->words, a, b),
                 proven = pair_bit(set->proven, set->words, a, b);
            if (proven && !seen) return false;
            if (!seen) continue;
            if (b >= set->cell_count || !pair_bit(set->seen, set->words, b, a)) return false;
            if (proven != pair_bit(set->proven, set->words, b, a)) return false;
        }
    }
    return true;
}

bool pairs_load(const char *path, const CellGraph *graph, Arena *arena, PairSet *out, Error *error) {
    Bytes file;
    if (!derived_read(path, &KIND, vis_geometry_hash(graph), arena, &file, error)) return false;
    Header header;
    memcpy(&header, file.data, sizeof header);
    int cells = graph->cell_count, words = (cells + 63) / 64;
    if (header.cell_count != cells || header.words != words || header.head.geometry != header.head.building)
        return error_set(error, "%s: is of %d other cells (expected %d)", path, header.cell_count, cells);
    size_t rows = rows_size(cells, words);
    if (!derived_check_body(path, &KIND, file, 2 * rows, error)) return false;
    *out = pair_set_new(graph, arena);
    memcpy(out->seen, file.data + sizeof header, rows);
    memcpy(out->proven, file.data + sizeof header + rows, rows);
    return rows_hold(out) || error_set(error, "%s: its rows do not hold together", path);
}
