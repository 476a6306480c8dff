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

// Up to VIS_MANY_CELLS cells, visible sets are stored bit by bit (`words` a row). Those of more are stored as the place of each block
// of each row (CellRows), and the blocks: `words` is 0 then.
enum { EMPTY_BLOCK = -1, FULL_BLOCK = -2 };
static const size_t BLOCK = CELL_BLOCK_WORDS * sizeof(uint64_t);

static int words_of(int cells) { return cells > VIS_MANY_CELLS ? 0 : (cells + 63) / 64; }

static size_t place_count(int cells) {
    return (size_t)cells * (((size_t)cells + CELL_BLOCK - 1) / CELL_BLOCK);
}

// `blocks`: of visible sets, where these are stored in blocks.
static Sizes sizes_of(int cells, int nodes, size_t blocks) {
    Sizes s = {.root = ((size_t)cells + 1) * sizeof(int32_t),
               .bounded = (size_t)cells,
               .seen = words_of(cells) ? (size_t)cells * (size_t)words_of(cells) * sizeof(uint64_t)
                                       : place_count(cells) * sizeof(int32_t) + blocks * BLOCK,
               .nodes = (size_t)nodes * sizeof(StabNode)};
    s.total = s.root + s.bounded + s.seen + s.nodes;
    return s;
}

// Where a row's block is stored: its number among those that are its row's own.
static int32_t block_place(const uint64_t *block, int32_t next) {
    return cell_block_is_empty(block) ? EMPTY_BLOCK : cell_block_is_full(block) ? FULL_BLOCK : next;
}

static int32_t own_blocks(const CellRows *seen) {
    int32_t count = 0;
    for (size_t i = 0; i < place_count(seen->cell_count); i++)
        count += block_place(seen->block[i], count) == count;
    return count;
}

static void put_blocks(const CellRows *seen, unsigned char *at) {
    size_t places = place_count(seen->cell_count);
    unsigned char *blocks = at + places * sizeof(int32_t);
    int32_t next = 0;
    for (size_t i = 0; i < places; i++) {
        int32_t place = block_place(seen->block[i], next);
        memcpy(at + i * sizeof place, &place, sizeof place);
        if (place == next) memcpy(blocks + BLOCK * (size_t)next++, seen->block[i], BLOCK);
    }
}

// How many blocks of their own the places name, in order; -1 where they do not.
static int32_t count_places(const unsigned char *at, int cells) {
    int32_t next = 0;
    for (size_t i = 0; i < place_count(cells); i++) {
        int32_t place;
        memcpy(&place, at + i * sizeof place, sizeof place);
        if (place == next) {
            next++;
        } else if (place != EMPTY_BLOCK && place != FULL_BLOCK) {
            return -1;
        }
    }
    return next;
}

static void put_seen(const StabForest *forest, unsigned char *at) {
    size_t row = (size_t)words_of(forest->cell_count) * sizeof(uint64_t);
    if (!row) {
        put_blocks(&forest->seen, at);
        return;
    }
    for (int c = 0; c < forest->cell_count; c++, at += row) {
        for (int k = 0; k < forest->seen.blocks; k++) {
            size_t left = row - (size_t)k * BLOCK;
            memcpy(at + (size_t)k * BLOCK, cell_rows_block(&forest->seen, c, k), left < BLOCK ? left : BLOCK);
        }
    }
}

// Bits beyond the last cell, which no row has, are dropped.
static void get_row(StabForest *forest, int cell, uint64_t *row, Arena *arena) {
    if (forest->cell_count % 64) row[forest->words - 1] &= ((uint64_t)1 << (forest->cell_count % 64)) - 1;
    cell_rows_set(&forest->seen, cell, row, arena);
}

static void get_seen(const unsigned char *at, StabForest *forest, Arena *arena) {
    size_t size = (size_t)words_of(forest->cell_count) * sizeof(uint64_t);
    const unsigned char *blocks = at + place_count(forest->cell_count) * sizeof(int32_t);
    Arena scratch = {0};
    int in_row = (forest->cell_count + CELL_BLOCK - 1) / CELL_BLOCK;
    uint64_t *row = ARENA_ARRAY(&scratch, uint64_t, in_row * CELL_BLOCK_WORDS);
    forest->seen = cell_rows_new(forest->cell_count, arena);
    for (int c = 0; c < forest->cell_count; c++, at += size) {
        if (size) memcpy(row, at, size);
        for (int k = 0; k < in_row && !size; k++, at += sizeof(int32_t)) {
            uint64_t *block = row + k * CELL_BLOCK_WORDS;
            int32_t place;
            memcpy(&place, at, sizeof place);
            memset(block, place == FULL_BLOCK ? 0xff : 0, BLOCK);
            if (place >= 0) memcpy(block, blocks + (size_t)place * BLOCK, BLOCK);
        }
        get_row(forest, c, row, arena);
    }
    arena_free(&scratch);
}

bool vis_save(const char *path, const CellGraph *graph, const StabForest *forest, Error *error) {
    int cells = forest->cell_count;
    Sizes s = sizes_of(cells, forest->node_count, words_of(cells) ? 0 : (size_t)own_blocks(&forest->seen));
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

// The sizes that the header tells, and of sets in blocks their places; false where the file is too short for these.
static bool sizes_in(const Header *h, Bytes file, Sizes *out) {
    *out = sizes_of(h->cell_count, h->node_count, 0);
    if (words_of(h->cell_count)) return true;
    size_t at = sizeof *h + out->root + out->bounded;
    if (file.size < at + out->seen) return false;
    int32_t blocks = count_places(file.data + at, h->cell_count);
    if (blocks >= 0) *out = sizes_of(h->cell_count, h->node_count, (size_t)blocks);
    return blocks >= 0;
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
