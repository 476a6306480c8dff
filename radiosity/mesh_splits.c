// mesh_splits.c - quadtrees over the faces of a mesh: which squares are one element, and which elements shoot together.
#include <string.h>

#include "engine/core/error.h"
#include "radiosity/mesh_parts.h"

// A patch's elements are at most so many splits smaller than it: of a patch that is finer somewhere, each quarter shoots, as light
// that changes much within it should not leave from its middle.
enum { SPLITS_IN_PATCH = 1 };

// Is the next node split?
static bool is_split(const MeshSplits *splits, int *at, int depth) {
    if (depth == MESH_DEEPEST) return false;
    if (!splits->bits) return depth < splits->even;
    int i = (*at)++;
    return i < splits->bit_count && (splits->bits[i / 8] >> i % 8 & 1) != 0;
}

// ---- reading

static int deepest(const MeshSplits *splits, int *at, int depth) {
    if (!is_split(splits, at, depth)) return depth;
    int most = depth;
    for (int k = 0; k < 4; k++) {
        int below = deepest(splits, at, depth + 1);
        most = below > most ? below : most;
    }
    return most;
}

int mesh_deepest(MeshBuilder *builder, int roots) {
    int most = 0;
    for (int i = 0; i < roots; i++) {
        int depth = deepest(builder->mesh->options.splits, &builder->laid, 0);
        most = depth > most ? depth : most;
    }
    return most;
}

static MeshBlock quarter(MeshBlock b, int k) {
    int half = (b.i1 + 1 - b.i0) / 2, i = b.i0 + k % 2 * half, j = b.j0 + k / 2 * half;
    return (MeshBlock){i, j, i + half - 1, j + half - 1};
}

// The leaves of a root under way.
typedef struct Leaves {
    MeshLeaf *out;
    int count;
} Leaves;

static void make_patch(Leaves *leaves, int first, int end) {
    for (int k = first; k < end; k++) leaves->out[k].patch = first;
}

// Returns how deep the leaves of a node are. Where it has splits to make one patch of all, those above it make patches.
static int list_node(MeshBuilder *builder, MeshBlock block, int depth, Leaves *leaves) {
    if (!is_split(builder->mesh->options.splits, &builder->cut, depth)) {
        leaves->out[leaves->count++] = (MeshLeaf){.block = block};
        return depth;
    }
    int first[5], below[4], most = depth;
    for (int k = 0; k < 4; k++) {
        first[k] = leaves->count;
        below[k] = list_node(builder, quarter(block, k), depth + 1, leaves);
        most = below[k] > most ? below[k] : most;
    }
    first[4] = leaves->count;
    for (int k = 0; k < 4 && most - depth > SPLITS_IN_PATCH; k++)
        if (below[k] - (depth + 1) <= SPLITS_IN_PATCH) make_patch(leaves, first[k], first[k + 1]);
    return most;
}

// Without splits: each patch's squares.
static int list_squares(const Face *face, int i0, int j0, int count, MeshLeaf *out) {
    int first = count;
    for (int j = j0; j < j0 + face->root; j++)
        for (int i = i0; i < i0 + face->root; i++)
            out[count++] = (MeshLeaf){.block = {i, j, i, j}, .patch = first};
    return count;
}

int mesh_leaves(MeshBuilder *builder, const Face *face, MeshLeaf *out) {
    Leaves leaves = {.out = out};
    for (int j = 0; j < face->ny; j += face->root) {
        for (int i = 0; i < face->nx; i += face->root) {
            MeshBlock root = {i, j, i + face->root - 1, j + face->root - 1};
            int first = leaves.count;
            if (!builder->mesh->options.splits)
                leaves.count = list_squares(face, i, j, leaves.count, out);
            else if (list_node(builder, root, 0, &leaves) <= SPLITS_IN_PATCH)
                make_patch(&leaves, first, leaves.count);
        }
    }
    return leaves.count;
}

unsigned char *mesh_depths(const Mesh *mesh, Arena *arena) {
    unsigned char *depth = ARENA_ARRAY(arena, unsigned char, mesh->element_count);
    Arena scratch = {0};
    int *squares = ARENA_ARRAY(&scratch, int, mesh->element_count);
    for (int i = 0; i < mesh->square_count; i++)
        if (mesh->squares[i] >= 0) squares[mesh->squares[i]]++;
    for (int e = 0; e < mesh->element_count; e++) {
        // Of one that was joined to another, the smaller's.
        int side = mesh->faces[mesh->elements[e].face].root;
        for (; side * side > squares[e] && side > 1; side /= 2) depth[e]++;
    }
    arena_free(&scratch);
    return depth;
}

// ---- writing

typedef struct Writer {
    const Mesh *mesh;
    const Face *face;
    const unsigned char *depth;
    Arena *arena;
    MeshSplits *out;
    int capacity;
} Writer;

static void write_bit(Writer *w, bool bit) {
    int at = w->out->bit_count++, bytes = at / 8;
    if (at % 8 == 0) *ARENA_PUSH(w->arena, w->out->bits, bytes, w->capacity) = 0;
    if (bit) w->out->bits[at / 8] = (unsigned char)(w->out->bits[at / 8] | 1 << at % 8);
}

static int wanted_in(const Writer *w, MeshBlock b) {
    int most = 0;
    for (int j = b.j0; j <= b.j1; j++) {
        for (int i = b.i0; i <= b.i1; i++) {
            int e = w->mesh->squares[w->face->first_square + j * w->face->nx + i];
            if (e >= 0 && w->depth[e] > most) most = w->depth[e];
        }
    }
    return most;
}

// Below a single square all is as that wants it.
static void write_node(Writer *w, MeshBlock b, int depth) {
    if (depth == MESH_DEEPEST) return;
    bool split = wanted_in(w, b) > depth;
    write_bit(w, split);
    for (int k = 0; split && k < 4; k++) write_node(w, b.i0 == b.i1 ? b : quarter(b, k), depth + 1);
}

MeshSplits *mesh_splits(const Mesh *mesh, const unsigned char *depth, Arena *arena) {
    Writer w = {mesh, NULL, depth, arena, ARENA_ARRAY(arena, MeshSplits, 1), 0};
    for (int f = 0; f < mesh->face_count; f++) {
        w.face = &mesh->faces[f];
        int root = w.face->root;
        CORE_ASSERT((root & (root - 1)) == 0);
        for (int j = 0; j < w.face->ny; j += root)
            for (int i = 0; i < w.face->nx; i += root)
                write_node(&w, (MeshBlock){i, j, i + root - 1, j + root - 1}, 0);
    }
    return w.out;
}
