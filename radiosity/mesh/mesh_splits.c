// mesh_splits.c - trees over the faces of a mesh: which squares are one element, and which elements shoot together.
#include "engine/core/error.h"
#include "radiosity/mesh/mesh_parts.h"

// The fate of a node.
typedef enum Cut { WHOLE, QUARTERS, HALVES } Cut;

// A node of a tree: a square, or the half of one.
typedef struct Node {
    int depth, patch;  // of the square; the depth of the patch it is in, -1: above patches
    int axis;          // that it was halved along, -1: a square.
} Node;
static const Node ROOT = {0, -1, -1};

static bool may_split(Node node) {
    return node.axis >= 0 ||
           (node.depth < MESH_DEEPEST && (node.patch < 0 || node.depth - node.patch < MESH_IN_PATCH));
}

static MeshDepth depth_of(Node node) {
    return (MeshDepth){(unsigned char)(node.depth + (node.axis == 0)),
                       (unsigned char)(node.depth + (node.axis == 1))};
}

static MeshBlock half(MeshBlock b, int axis, int k) {
    int middle = axis == 0 ? (b.i0 + b.i1 + 1) / 2 : (b.j0 + b.j1 + 1) / 2;
    // Below a single square all is as that wants it.
    if (axis == 0 && b.i0 < b.i1) return k ? (b.i0 = middle, b) : (b.i1 = middle - 1, b);
    if (axis == 1 && b.j0 < b.j1) return k ? (b.j0 = middle, b) : (b.j1 = middle - 1, b);
    return b;
}

// The child k of a block; quarters row by row.
static MeshBlock part(MeshBlock b, Cut cut, int axis, int k) {
    return cut == QUARTERS ? half(half(b, 0, k % 2), 1, k / 2) : half(b, axis, k);
}

// Halves of a square are rectangles, those of a rectangle squares again.
static Node below(Node node, Cut cut, int axis) {
    bool square = cut == QUARTERS || node.axis >= 0;
    return square ? (Node){node.depth + 1, node.patch, -1} : (Node){node.depth, node.patch, axis};
}

// ---- reading

static bool read_bit(const MeshSplits *splits, int *at) {
    int i = (*at)++;
    return i < splits->bit_count && (splits->bits[i / 8] >> i % 8 & 1) != 0;
}

// One above patches that is not split becomes a patch.
static Cut read_cut(const MeshSplits *splits, int *at, Node *node, int *axis) {
    if (!splits->bits) {
        node->patch = 0;
        return node->depth < splits->even ? QUARTERS : WHOLE;
    }
    if (node->patch < 0) {
        if (may_split(*node) && read_bit(splits, at)) return QUARTERS;
        node->patch = node->depth;
    }
    if (!may_split(*node) || !read_bit(splits, at)) return WHOLE;
    *axis = node->axis >= 0 ? 1 - node->axis : read_bit(splits, at);
    return HALVES;
}

static int deepest(const MeshSplits *splits, int *at, Node node) {
    int axis = 0;
    Cut cut = read_cut(splits, at, &node, &axis);
    if (cut == WHOLE) return node.depth + (node.axis >= 0);
    int most = 0;
    for (int k = 0; k < (cut == QUARTERS ? 4 : 2); k++) {
        int depth = deepest(splits, at, below(node, cut, axis));
        most = depth > most ? depth : most;
    }
    return most;
}

int mesh_deepest(MeshBuilder *builder, double roots) {
    const MeshSplits *splits = builder->mesh->options.splits;
    if (!splits->bits) return splits->even;
    int most = 0;
    for (double i = 0; i < roots && builder->laid < splits->bit_count; i++) {
        int depth = deepest(splits, &builder->laid, ROOT);
        most = depth > most ? depth : most;
    }
    return most;
}

// Returns how many leaves there are now. Those of one patch have the number of its first.
static int list_node(MeshBuilder *builder, MeshBlock block, Node node, int patch, MeshLeaf *out, int count) {
    int axis = 0;
    bool above = node.patch < 0;
    Cut cut = read_cut(builder->mesh->options.splits, &builder->cut, &node, &axis);
    if (above && node.patch >= 0) patch = count;
    if (cut == WHOLE) {
        out[count] = (MeshLeaf){.block = block, .depth = depth_of(node), .patch = patch};
        return count + 1;
    }
    for (int k = 0; k < (cut == QUARTERS ? 4 : 2); k++)
        count = list_node(builder, part(block, cut, axis, k), below(node, cut, axis), patch, out, count);
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
                        ? list_node(builder, root, ROOT, 0, out, count)
                        : list_squares(face, i, j, builder->mesh->options.per_patch, count, out);
        }
    }
    return count;
}

// ---- writing

typedef struct Writer {
    const Mesh *mesh;
    const Face *face;
    const unsigned char *patch;
    const MeshDepth *element;
    Arena *arena;
    MeshSplits *out;
    int capacity;
} Writer;

static bool write_bit(Writer *w, bool bit) {
    int at = w->out->bit_count++, bytes = at / 8;
    if (at % 8 == 0) *ARENA_PUSH(w->arena, w->out->bits, bytes, w->capacity) = 0;
    if (bit) w->out->bits[at / 8] = (unsigned char)(w->out->bits[at / 8] | 1 << at % 8);
    return bit;
}

// The most that is asked for in a block, of its patches and along each axis of its elements.
typedef struct Wanted {
    int patch, along[2];
} Wanted;

static Wanted wanted_in(const Writer *w, MeshBlock b) {
    Wanted most = {0};
    for (int j = b.j0; j <= b.j1; j++) {
        for (int i = b.i0; i <= b.i1; i++) {
            int e = mesh_square(w->mesh, w->face->first_square + j * w->face->nx + i);
            if (e < 0) continue;
            MeshDepth depth = w->element[e];
            if (w->patch[e] > most.patch) most.patch = w->patch[e];
            if (depth.x > most.along[0]) most.along[0] = depth.x;
            if (depth.y > most.along[1]) most.along[1] = depth.y;
        }
    }
    return most;
}

// Where a square is wanted halved along both axes, the first halving leaves one half whole, where there is one.
static int first_axis(const Writer *w, MeshBlock b, int depth, const Wanted *wanted) {
    if (wanted->along[1] <= depth) return 0;
    if (wanted->along[0] <= depth) return 1;
    for (int k = 0; k < 2; k++)
        if (wanted_in(w, half(b, 1, k)).along[0] <= depth) return 1;
    return 0;
}

static Cut write_cut(Writer *w, MeshBlock b, Node *node, int *axis) {
    Wanted wanted = wanted_in(w, b);
    if (node->patch < 0) {
        if (may_split(*node) && write_bit(w, wanted.patch > node->depth)) return QUARTERS;
        node->patch = node->depth;
    }
    if (!may_split(*node)) return WHOLE;
    *axis = node->axis >= 0 ? 1 - node->axis : first_axis(w, b, node->depth, &wanted);
    if (!write_bit(w, wanted.along[*axis] > node->depth)) return WHOLE;
    if (node->axis < 0) write_bit(w, *axis == 1);
    return HALVES;
}

static void write_node(Writer *w, MeshBlock b, Node node) {
    int axis = 0;
    Cut cut = write_cut(w, b, &node, &axis);
    for (int k = 0; cut != WHOLE && k < (cut == QUARTERS ? 4 : 2); k++)
        write_node(w, part(b, cut, axis, k), below(node, cut, axis));
}

MeshSplits *mesh_splits(const Mesh *mesh, const unsigned char *patch, const MeshDepth *element,
                        Arena *arena) {
    CORE_ASSERT(mesh->options.splits);
    Writer w = {mesh, NULL, patch, element, arena, ARENA_ARRAY(arena, MeshSplits, 1), 0};
    for (int f = 0; f < mesh->face_count; f++) {
        w.face = &mesh->faces[f];
        int root = w.face->root;
        for (int j = 0; j < w.face->ny; j += root)
            for (int i = 0; i < w.face->nx; i += root)
                write_node(&w, (MeshBlock){i, j, i + root - 1, j + root - 1}, ROOT);
    }
    return w.out;
}
