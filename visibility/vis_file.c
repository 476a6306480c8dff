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

// Up to VIS_BITS cells, visible sets are stored bit by bit (`words` a row). Those of more are stored packed (CellRows): `words` is 0 then.
enum { VIS_BITS = 8192 };

static int words_of(int cells) { return cells > VIS_BITS ? 0 : (cells + 63) / 64; }

static size_t root_size(int cells) { return ((size_t)cells + 1) * sizeof(int32_t); }

static void put_forest(DerivedSink *sink, const void *context) {
    const StabForest *forest = context;
    int cells = forest->cell_count, words = words_of(cells);
    derived_put(sink, forest->root, root_size(cells));
    derived_put(sink, forest->bounded, (size_t)cells);
    if (words == 0) cell_rows_put(&forest->seen, sink);
    for (int c = 0; c < cells && words > 0; c++) {
        uint64_t row[VIS_BITS / 64] = {0};
        cell_rows_join(&forest->seen, c, row);
        derived_put(sink, row, (size_t)words * sizeof *row);
    }
    derived_put(sink, forest->nodes, (size_t)forest->node_count * sizeof *forest->nodes);
}

bool vis_save(const char *path, const CellGraph *graph, const StabForest *forest, Error *error) {
    Header header = {.cell_count = forest->cell_count,
                     .portal_count = graph->portal_count,
                     .node_count = forest->node_count,
                     .words = words_of(forest->cell_count)};
    return derived_write(path, &KIND, graph->building->hash, vis_geometry_hash(graph), &header, put_forest,
                         forest, error);
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

// Bits beyond the last cell, which no row has, are dropped.
static bool take_seen(DerivedReader *reader, StabForest *forest, Arena *arena) {
    int cells = forest->cell_count, words = words_of(cells);
    if (words == 0) return cell_rows_take(reader, cells, arena, &forest->seen);
    forest->seen = cell_rows_new(cells, arena);
    for (int c = 0; c < cells; c++) {
        uint64_t row[VIS_BITS / 64];
        if (!derived_take(reader, row, (size_t)words * sizeof *row)) return false;
        if (cells % 64) row[words - 1] &= ((uint64_t)1 << (cells % 64)) - 1;
        cell_rows_set(&forest->seen, c, row, arena);
    }
    return true;
}

// Has the body the length that the header tells? That of packed sets follows from them alone.
static bool check_size(const DerivedReader *reader, const Header *h, Error *error) {
    size_t cells = (size_t)h->cell_count, words = (size_t)words_of(h->cell_count),
           least = root_size(h->cell_count) + cells + cells * words * sizeof(uint64_t) +
                   (size_t)h->node_count * sizeof(StabNode);
    if (words == 0 && reader->left >= least) return true;
    return derived_check_size(reader->path, &KIND, reader->header + reader->left, least, error);
}

static bool take_forest(DerivedReader *reader, const Header *h, Arena *arena, StabForest *out, Error *error) {
    int cells = h->cell_count;
    size_t nodes = (size_t)h->node_count * sizeof *out->nodes;
    *out = (StabForest){.node_count = h->node_count, .cell_count = cells, .words = (cells + 63) / 64};
    out->root = arena_alloc(arena, root_size(cells), 1);
    out->bounded = arena_alloc(arena, (size_t)cells, 1);
    if (!derived_take(reader, out->root, root_size(cells)) ||
        !derived_take(reader, out->bounded, (size_t)cells) || !take_seen(reader, out, arena) ||
        reader->left != nodes)
        return error_set(error, "%s: is damaged: its visible sets are broken", reader->path);
    out->nodes = arena_alloc(arena, nodes, 1);
    memory_expect_full(out->nodes, nodes);
    return (derived_take(reader, out->nodes, nodes) && check_nodes(out, h->portal_count)) ||
           error_set(error, "%s: is damaged: its trees are broken", reader->path);
}

bool vis_load(const char *path, const CellGraph *graph, Arena *arena, StabForest *out, Error *error) {
    DerivedReader reader;
    Header h;
    if (!derived_begin(path, &KIND, graph->building->hash, &h, &reader, error)) return false;
    bool good = check_cells(path, &h, graph, error) && check_size(&reader, &h, error) &&
                derived_sound(&reader, &h, error) && take_forest(&reader, &h, arena, out, error);
    derived_end(&reader);
    return good;
}
