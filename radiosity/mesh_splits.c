// mesh_splits.c - quadtrees over the faces of a mesh: which squares are one element, and which elements shoot together.
#include "engine/core/error.h"
#include "radiosity/mesh_parts.h"

// A node of a quadtree.
typedef struct Node {
    int depth, patch;  // the depth of the patch it is in; -1: above patches
} Node;

static Node below(Node node) { return (Node){node.depth + 1, node.patch}; }

static bool may_split(Node node) {
    return node.depth < MESH_DEEPEST && (node.patch < 0 || node.depth - node.patch < MESH_IN_PATCH);
}

// Is the node split? One above patches that is not becomes a patch.
static bool is_split(const MeshSplits *splits, int *at, Node *node) {
    if (!splits->bits) {
        node->patch = 0;
        return node->depth < splits->even;
    }
    for (;;) {
        int i = *at;
        bool split = false;
        if (may_split(*node)) {
            split = i < splits->bit_count && (splits->bits[i / 8] >> i % 8 & 1) != 0;
            (*at)++;
        }
        if (split || node->patch >= 0) return split;
        node->patch = node->depth;
    }
}

// ---- reading

static int deepest(const MeshSplits *splits, int *at, Node node) {
    if (!is_split(splits, at, &node)) return node.depth;
    int most = 0;
    for (int k = 0; k < 4; k++) {
        int depth = deepest(splits, at, below(node));
        most = depth > most ? depth : most;
    }
    return most;
}

int mesh_deepest(MeshBuilder *builder, double roots) {
    const MeshSplits *splits = builder->mesh->options.splits;
    if (!splits->bits) return splits->even;
    int most = 0;
    for (double i = 0; i < roots && builder->laid < splits->bit_count; i++) {
        int depth = deepest(splits, &builder->laid, (Node){0, -1});
        most = depth > most ? depth : most;
    }
    return most;
}

static MeshBlock quarter(MeshBlock b, int k) {
    int half = (b.i1 + 1 - b.i0) / 2, i = b.i0 + k % 2 * half, j = b.j0 + k / 2 * half;
    return (MeshBlock){i, j, i + half - 1, j + half - 1};
}

// Returns how many leaves there are now. Those of one patch have the number of its first.
static int list_node(MeshBuilder *builder, MeshBlock block, Node node, int patch, MeshLeaf *out, int count) {
    bool above = node.patch < 0, split = is_split(builder->mesh->options.splits, &builder->cut, &node);
    if (above && node.patch >= 0) patch = count;
    if (!split) {
        out[count] = (MeshLeaf){.block = block, .depth = node.depth, .patch = patch};
        return count + 1;
    }
    for (int k = 0; k < 4; k++) count = list_node(builder, quarter(block, k), below(node), patch, out, count);
    return count;
}

// Without splits: each patch's elements, of as many squares as the grid was made finer.
static int list_squares(const Face *face, int i0, int j0, int per_patch, int count, MeshLeaf *out) {
    int first = count, side = face->root / per_patch;
    for (int j = j0; j < j0 + face->root; j += side)
        for (int i = i0; i < i0 + face->root; i += side)
            out[count++] = (MeshLeaf){.block = {i, j, i + side - 1, j + side - 1}, .patch = first};
    return count;
}

int mesh_leaves(MeshBuilder *builder, const Face *face, MeshLeaf *out) {
    int count = 0;
    for (int j = 0; j < face->ny; j += face->root) {
        for (int i = 0; i < face->nx; i += face->root) {
            MeshBlock root = {i, j, i + face->root - 1, j + face->root - 1};
            count = builder->mesh->options.splits
                        ? list_node(builder, root, (Node){0, -1}, 0, out, count)
                        : list_squares(face, i, j, builder->mesh->options.per_patch, count, out);
        }
    }
    return count;
}

// ---- writing

typedef struct Writer {
    const Mesh *mesh;
    const Face *face;
    const unsigned char *patch, *element;
    Arena *arena;
    MeshSplits *out;
    int capacity;
} Writer;

static void write_bit(Writer *w, bool bit) {
    int at = w->out->bit_count++, bytes = at / 8;
    if (at % 8 == 0) *ARENA_PUSH(w->arena, w->out->bits, bytes, w->capacity) = 0;
    if (bit) w->out->bits[at / 8] = (unsigned char)(w->out->bits[at / 8] | 1 << at % 8);
}

static int wanted_in(const Writer *w, MeshBlock b, const unsigned char *depth) {
    int most = 0;
    for (int j = b.j0; j <= b.j1; j++) {
        for (int i = b.i0; i <= b.i1; i++) {
            int e = mesh_square(w->mesh, w->face->first_square + j * w->face->nx + i);
            if (e >= 0 && depth[e] > most) most = depth[e];
        }
    }
    return most;
}

static bool write_whether(Writer *w, MeshBlock b, Node node, const unsigned char *depth) {
    if (!may_split(node)) return false;
    bool split = wanted_in(w, b, depth) > node.depth;
    write_bit(w, split);
    return split;
}

// Below a single square all is as that wants it.
static void write_node(Writer *w, MeshBlock b, Node node) {
    bool split = node.patch < 0 && write_whether(w, b, node, w->patch);
    if (!split) {
        if (node.patch < 0) node.patch = node.depth;
        split = write_whether(w, b, node, w->element);
    }
    for (int k = 0; split && k < 4; k++) write_node(w, b.i0 == b.i1 ? b : quarter(b, k), below(node));
}

MeshSplits *mesh_splits(const Mesh *mesh, const unsigned char *patch, const unsigned char *element,
                        Arena *arena) {
    CORE_ASSERT(mesh->options.splits);
    Writer w = {mesh, NULL, patch, element, arena, ARENA_ARRAY(arena, MeshSplits, 1), 0};
    for (int f = 0; f < mesh->face_count; f++) {
        w.face = &mesh->faces[f];
        int root = w.face->root;
        for (int j = 0; j < w.face->ny; j += root)
            for (int i = 0; i < w.face->nx; i += root)
                write_node(&w, (MeshBlock){i, j, i + root - 1, j + root - 1}, (Node){0, -1});
    }
    return w.out;
}
