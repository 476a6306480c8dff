// vis_file.c - the .vis file: the stab forest of a building, under the building's hash.
//
// Layout: header (DerivedHead), roots, bounded flags, visible sets, nodes. The cells are not stored: they are made again
// from the building, and `geometry`, the hash of cells and portals, says whether they came out the same.
#include <string.h>

#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "visibility/vis.h"

enum { VERSION = 2 };

typedef struct Header {
    DerivedHead head;
    int32_t cell_count, portal_count, node_count, words;
} Header;

static const DerivedKind KIND = {.magic = "ENFVIS",
                                 .name = ".vis",
                                 .version = VERSION,
                                 .header = sizeof(Header),
                                 .largest = (size_t)4 << 30};

uint64_t vis_geometry_hash(const CellGraph *graph) {
    uint64_t hash = file_hash(graph->plan, (size_t)graph->plan_count * sizeof *graph->plan, VERSION);
    for (int c = 0; c < graph->cell_count; c++) {
        double heights[2] = {graph->cells[c].z0, graph->cells[c].z1};
        hash = file_hash(heights, sizeof heights, hash);
    }
    hash = file_hash(graph->faces, (size_t)graph->face_count * sizeof *graph->faces, hash);
    for (int p = 0; p < graph->portal_count; p++)
        hash = file_hash(&graph->portals[p].plane, sizeof graph->portals[p].plane, hash);
    hash = file_hash(graph->ways, (size_t)graph->way_count * sizeof *graph->ways, hash);
    return file_hash(graph->portal_vertices,
                     (size_t)graph->portal_vertex_count * sizeof *graph->portal_vertices, hash);
}

typedef struct Sizes {
    size_t root, bounded, seen, nodes, total;
} Sizes;

// Up to VIS_BITS cells, visible sets are stored bit by bit (`words` a row). Those of more are stored packed (CellRows): `words` is 0 then.
enum { VIS_BITS = 8192 };

static int words_of(int cells) { return cells > VIS_BITS ? 0 : (cells + 63) / 64; }

// `packed`: bytes of visible sets that are stored so.
static Sizes sizes_of(int cells, int nodes, size_t packed) {
    Sizes s = {.root = ((size_t)cells + 1) * sizeof(int32_t),
               .bounded = (size_t)cells,
               .seen = words_of(cells) ? (size_t)cells * (size_t)words_of(cells) * sizeof(uint64_t) : packed,
               .nodes = (size_t)nodes * sizeof(StabNode)};
    s.total = s.root + s.bounded + s.seen + s.nodes;
    return s;
}

static void put_seen(const StabForest *forest, unsigned char *at) {
    size_t words = (size_t)words_of(forest->cell_count);
    if (words == 0) {
        cell_rows_pack(&forest->seen, at);
        return;
    }
    uint64_t *row = memory_new(words * sizeof *row);
    for (int c = 0; c < forest->cell_count; c++, at += words * sizeof *row) {
        memset(row, 0, words * sizeof *row);
        cell_rows_join(&forest->seen, c, row);
        memcpy(at, row, words * sizeof *row);
    }
    memory_free(row);
}

// Bits beyond the last cell, which no row has, are dropped.
static void get_seen(const unsigned char *at, StabForest *forest, Arena *arena) {
    size_t words = (size_t)words_of(forest->cell_count);
    if (words == 0) {
        forest->seen = cell_rows_unpack(at, forest->cell_count, arena);
        return;
    }
    uint64_t *row = memory_new(words * sizeof *row);
    forest->seen = cell_rows_new(forest->cell_count, arena);
    for (int c = 0; c < forest->cell_count; c++, at += words * sizeof *row) {
        memcpy(row, at, words * sizeof *row);
        if (forest->cell_count % 64) row[words - 1] &= ((uint64_t)1 << (forest->cell_count % 64)) - 1;
        cell_rows_set(&forest->seen, c, row, arena);
    }
    memory_free(row);
}

bool vis_save(const char *path, const CellGraph *graph, const StabForest *forest, Error *error) {
    int cells = forest->cell_count;
    Sizes s = sizes_of(cells, forest->node_count, words_of(cells) ? 0 : cell_rows_packed_size(&forest->seen));
    unsigned char *file = derived_new(path, &KIND, s.total, error);
    if (!file) return false;
    Header header = {.cell_count = cells,
                     .portal_count = graph->portal_count,
                     .node_count = forest->node_count,
                     .words = words_of(cells)};
    memcpy(file, &header, sizeof header);
    unsigned char *at = file + sizeof header;
    memcpy(at, forest->root, s.root);
    memcpy(at += s.root, forest->bounded, s.bounded);
    put_seen(forest, at += s.bounded);
    memcpy(at + s.seen, forest->nodes, s.nodes);
    bool good =
        derived_write(path, &KIND, graph->building->hash, vis_geometry_hash(graph), file, s.total, error);
    memory_free(file);
    return good;
}

static bool check_cells(const char *path, const Header *h, const CellGraph *graph, Error *error) {
    if (h->head.geometry == vis_geometry_hash(graph) && h->cell_count == graph->cell_count &&
        h->portal_count == graph->portal_count && h->words == words_of(graph->cell_count) &&
        h->node_count >= 0)
        return true;
    return error_set(error, "%s: its cells are not those of this program's version", path);
}

// The checksum finds accidents; this keeps a forged file from leading the query astray.
static bool check_nodes(const StabForest *f, int portal_count) {
    if (f->root[0] != 0 || f->root[f->cell_count] != f->node_count) return false;
    for (int c = 0; c < f->cell_count; c++) {
        int first = f->root[c], end = f->root[c + 1];
        if (first >= end || end > f->node_count) return false;
        for (int i = first; i < end; i++) {
            const StabNode *n = &f->nodes[i];
            bool is_root = i == first;
            if (n->cell < 0 || n->cell >= f->cell_count) return false;
            if (is_root ? n->parent != -1 || n->cell != c : n->parent < first || n->parent >= i) return false;
            if (!is_root && (n->portal < 0 || n->portal >= portal_count)) return false;
            if (n->next != -1 && (n->next <= i || n->next >= end)) return false;
        }
    }
    return true;
}

// The sizes that the header tells, and of packed sets those that they tell; false where these are broken.
static bool sizes_in(const Header *h, Bytes file, Sizes *out) {
    *out = sizes_of(h->cell_count, h->node_count, 0);
    if (words_of(h->cell_count)) return true;
    size_t at = sizeof *h + out->root + out->bounded;
    size_t packed = file.size > at ? cell_rows_measure(file.data + at, file.size - at, h->cell_count) : 0;
    *out = sizes_of(h->cell_count, h->node_count, packed);
    return packed > 0;
}

bool vis_load(const char *path, const CellGraph *graph, Arena *arena, StabForest *out, Error *error) {
    Arena scratch = {0};
    Bytes file;
    Header h;
    Sizes s;
    bool good = derived_read(path, &KIND, graph->building->hash, &scratch, &file, error);
    if (good) {
        memcpy(&h, file.data, sizeof h);
        good = check_cells(path, &h, graph, error) &&
               (sizes_in(&h, file, &s) ||
                error_set(error, "%s: is damaged: its visible sets are broken", path)) &&
               derived_check_body(path, &KIND, file, s.total, error);
    }
    if (good) {
        const unsigned char *at = file.data + sizeof h;
        *out = (StabForest){
            .node_count = h.node_count, .cell_count = h.cell_count, .words = (h.cell_count + 63) / 64};
        out->root = memcpy(arena_alloc(arena, s.root, 1), at, s.root);
        out->bounded = memcpy(arena_alloc(arena, s.bounded, 1), at += s.root, s.bounded);
        get_seen(at += s.bounded, out, arena);
        out->nodes = memcpy(arena_alloc(arena, s.nodes, 1), at + s.seen, s.nodes);
        good = check_nodes(out, h.portal_count) ||
               error_set(error, "%s: is damaged: its trees are broken", path);
    }
    arena_free(&scratch);
    return good;
}
