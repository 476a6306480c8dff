// vis_file.c - the .vis file: the stab forest of a building, under the building's hash.
//
// Layout: header, roots, bounded flags, visible sets, nodes; the machine's own byte order, which the header shows.
// The cells are not stored: they are made again from the building, and `geometry` says whether they came out the
// same.
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "visibility/vis.h"

enum { VERSION = 2, BYTE_ORDER_MARK = 0x01020304 };
static const char MAGIC[8] = "ENFVIS";
static const size_t LARGEST_FILE = (size_t)4 << 30;

typedef struct Header {
    char magic[8];
    uint32_t version, byte_order;
    uint64_t building;  // hash of the building's file
    uint64_t geometry;  // hash of cells and portals
    uint64_t body;      // checksum of all that follows the header
    int32_t cell_count, portal_count, node_count, words;
} Header;

static uint64_t geometry_hash(const CellGraph *graph) {
    uint64_t hash = file_hash(graph->plan, (size_t)graph->plan_count * sizeof *graph->plan, VERSION);
    for (int c = 0; c < graph->cell_count; c++) {
        double heights[2] = {graph->cells[c].z0, graph->cells[c].z1};
        hash = file_hash(heights, sizeof heights, hash);
    }
    hash = file_hash(graph->faces, (size_t)graph->face_count * sizeof *graph->faces, hash);
    for (int p = 0; p < graph->portal_count; p++)
        hash = file_hash(&graph->portals[p].plane, sizeof graph->portals[p].plane, hash);
    hash = file_hash(graph->contacts, (size_t)graph->contact_count * sizeof *graph->contacts, hash);
    return file_hash(graph->portal_vertices,
                     (size_t)graph->portal_vertex_count * sizeof *graph->portal_vertices, hash);
}

typedef struct Sizes {
    size_t root, bounded, seen, nodes, total;
} Sizes;

static Sizes sizes_of(int cells, int nodes, int words) {
    Sizes s = {.root = ((size_t)cells + 1) * sizeof(int32_t),
               .bounded = (size_t)cells,
               .seen = (size_t)cells * (size_t)words * sizeof(uint64_t),
               .nodes = (size_t)nodes * sizeof(StabNode)};
    s.total = s.root + s.bounded + s.seen + s.nodes;
    return s;
}

bool vis_save(const char *path, const CellGraph *graph, const StabForest *forest, Error *error) {
    Sizes s = sizes_of(forest->cell_count, forest->node_count, forest->words);
    unsigned char *file = malloc(sizeof(Header) + s.total);
    if (!file) return error_set(error, "%s: no memory for %zu bytes", path, sizeof(Header) + s.total);
    unsigned char *body = file + sizeof(Header), *at = body;
    memcpy(at, forest->root, s.root);
    memcpy(at += s.root, forest->bounded, s.bounded);
    memcpy(at += s.bounded, forest->seen, s.seen);
    memcpy(at += s.seen, forest->nodes, s.nodes);
    Header header = {.version = VERSION,
                     .byte_order = BYTE_ORDER_MARK,
                     .building = graph->building->hash,
                     .geometry = geometry_hash(graph),
                     .body = file_hash(body, s.total, 0),
                     .cell_count = forest->cell_count,
                     .portal_count = graph->portal_count,
                     .node_count = forest->node_count,
                     .words = forest->words};
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    memcpy(file, &header, sizeof header);
    bool good = file_write(path, file, sizeof header + s.total, error);
    free(file);
    return good;
}

static bool check_header(const char *path, const Header *h, const CellGraph *graph, size_t size,
                         Error *error) {
    if (memcmp(h->magic, MAGIC, sizeof MAGIC) != 0) return error_set(error, "%s: is not a .vis file", path);
    if (h->byte_order != BYTE_ORDER_MARK) {
        return error_set(error, "%s: was written on a machine of another byte order", path);
    }
    if (h->version != VERSION) {
        return error_set(error, "%s: has version %u (this program reads version %d)", path, h->version,
                         VERSION);
    }
    if (h->building != graph->building->hash) {
        return error_set(error, "%s: belongs to another building, or to an earlier state of this one", path);
    }
    if (h->geometry != geometry_hash(graph) || h->cell_count != graph->cell_count ||
        h->portal_count != graph->portal_count || h->words != (graph->cell_count + 63) / 64 ||
        h->node_count < 0) {
        return error_set(error, "%s: its cells are not those of this program's version", path);
    }
    size_t expected = sizeof *h + sizes_of(h->cell_count, h->node_count, h->words).total;
    if (size != expected)
        return error_set(error, "%s: has %zu bytes (its header says %zu)", path, size, expected);
    return true;
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

bool vis_load(const char *path, const CellGraph *graph, Arena *arena, StabForest *out, Error *error) {
    Bytes bytes;
    if (!file_read(path, LARGEST_FILE, arena, &bytes, error)) return false;
    Header h;
    if (bytes.size < sizeof h)
        return error_set(error, "%s: has %zu bytes, less than a .vis header", path, bytes.size);
    memcpy(&h, bytes.data, sizeof h);
    if (!check_header(path, &h, graph, bytes.size, error)) return false;
    const unsigned char *at = bytes.data + sizeof h;
    Sizes s = sizes_of(h.cell_count, h.node_count, h.words);
    if (file_hash(at, s.total, 0) != h.body)
        return error_set(error, "%s: is damaged: its checksum is wrong", path);
    *out = (StabForest){.node_count = h.node_count, .cell_count = h.cell_count, .words = h.words};
    out->root = memcpy(arena_alloc(arena, s.root, 1), at, s.root);
    out->bounded = memcpy(arena_alloc(arena, s.bounded, 1), at += s.root, s.bounded);
    out->seen = memcpy(arena_alloc(arena, s.seen, 1), at += s.bounded, s.seen);
    out->nodes = memcpy(arena_alloc(arena, s.nodes, 1), at + s.seen, s.nodes);
    if (!check_nodes(out, h.portal_count))
        return error_set(error, "%s: is damaged: its trees are broken", path);
    return true;
}
