// ray_tree.c - a bounding-volume hierarchy split by the surface-area heuristic in bins (I. Wald, On fast construction of
// SAH-based bounding volume hierarchies, 2007).
#include "visibility/hidden/ray_tree.h"

// Boxes are widened by this, metres: their slabs are computed with rounding, and a box without thickness would lose
// hits. Above the rounding of a coordinate at 1e8 m (MAPS_LIMIT), far below any feature.
#define TREE_PADDING 1e-6
#define TREE_BINS 16

typedef struct TreeItem {
    Box box;
    Vec3 centre;
    int facet;
} TreeItem;

static double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static double half_area(Box b) {
    if (box_is_empty(b)) return 0;
    Vec3 s = vec3_sub(b.max, b.min);
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

static void swap_leaves(TreeItem *a, TreeItem *b) {
    TreeItem t = *a;
    *a = *b;
    *b = t;
}

// Orders leaves[0 .. count) so that the `half` smallest along `axis` come first.
static void select_half(TreeItem *leaves, int count, int half, int axis) {
    int low = 0, high = count - 1;
    while (low < high) {
        double pivot = component(leaves[(low + high) / 2].centre, axis);
        int i = low, j = high;
        while (i <= j) {
            while (component(leaves[i].centre, axis) < pivot) i++;
            while (component(leaves[j].centre, axis) > pivot) j--;
            if (i <= j) swap_leaves(&leaves[i++], &leaves[j--]);
        }
        if (half <= j) {
            high = j;
        } else if (half >= i) {
            low = i;
        } else {
            return;
        }
    }
}

typedef struct Bins {
    double low, scale;
    int axis;
} Bins;

static int bin_of(Bins bins, const TreeItem *leaf) {
    int bin = (int)((component(leaf->centre, bins.axis) - bins.low) * bins.scale);
    return bin < 0 ? 0 : bin >= TREE_BINS ? TREE_BINS - 1 : bin;
}

// The last bin of the cheaper side of the best split, or -1.
static int best_bin(Bins bins, const TreeItem *leaves, int count) {
    Box box[TREE_BINS];
    int held[TREE_BINS] = {0};
    for (int b = 0; b < TREE_BINS; b++) box[b] = box_empty();
    for (int i = 0; i < count; i++) {
        int b = bin_of(bins, &leaves[i]);
        box[b] = held[b]++ ? box_union(box[b], leaves[i].box) : leaves[i].box;
    }
    double right[TREE_BINS];
    Box sum = box_empty();
    int n = 0;
    for (int b = TREE_BINS - 1; b > 0; b--) {
        if (held[b]) sum = n ? box_union(sum, box[b]) : box[b];
        n += held[b];
        right[b] = n > 0 ? half_area(sum) * n : -1;
    }
    int best = -1;
    double best_cost = INFINITY;
    n = 0;
    for (int b = 0; b + 1 < TREE_BINS; b++) {
        if (held[b]) sum = n ? box_union(sum, box[b]) : box[b];
        n += held[b];
        if (n == 0 || right[b + 1] < 0) continue;
        double cost = half_area(sum) * n + right[b + 1];
        if (cost < best_cost) {
            best_cost = cost;
            best = b;
        }
    }
    return best;
}

// Splits leaves[0 .. count) in two; returns how many come first.
static int split(TreeItem *leaves, int count, int depth) {
    Box centres = box_empty();
    for (int i = 0; i < count; i++) centres = box_add(centres, leaves[i].centre);
    Vec3 size = vec3_sub(centres.max, centres.min);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    double extent = component(size, axis);
    Bins bins = {component(centres.min, axis), extent > 0 ? TREE_BINS / extent : 0, axis};
    int bin = depth < TREE_DEEP && isfinite(bins.scale) ? best_bin(bins, leaves, count) : -1;
    if (bin < 0) {
        select_half(leaves, count, count / 2, axis);
        return count / 2;
    }
    int first = 0;
    for (int i = 0; i < count; i++) {
        if (bin_of(bins, &leaves[i]) <= bin) swap_leaves(&leaves[first++], &leaves[i]);
    }
    return first;
}

static void build(RayTree *tree, TreeItem *leaves, int node, int first, int count, int depth) {
    Box box = leaves[first].box;
    for (int i = 1; i < count; i++) box = box_union(box, leaves[first + i].box);
    if (count <= TREE_LEAF) {
        tree->nodes[node] = (TreeNode){box, first, count};
        return;
    }
    int left = split(leaves + first, count, depth), child = tree->node_count;
    tree->node_count += 2;
    tree->nodes[node] = (TreeNode){box, child, 0};
    build(tree, leaves, child, first, left, depth + 1);
    build(tree, leaves, child + 1, first + left, count - left, depth + 1);
}

RayTree ray_tree_new(const Facets *facets, Arena *arena) {
    int count = facets->count;
    RayTree tree = {.nodes = ARENA_ARRAY(arena, TreeNode, 2 * count + 1),
                    .facet = ARENA_ARRAY(arena, int, count + 1),
                    .box = ARENA_ARRAY(arena, Box, count + 1)};
    if (count == 0) return tree;
    Arena scratch = {0};
    TreeItem *leaves = ARENA_ARRAY(&scratch, TreeItem, count);
    for (int i = 0; i < count; i++) {
        const Facet *facet = &facets->facets[i];
        Box box = box_empty();
        for (int k = 0; k < facet->count; k++) box = box_add(box, facets->corners[facet->first + k]);
        tree.box[i] = box_grow(box, TREE_PADDING);
        leaves[i] = (TreeItem){tree.box[i], facet->centre, i};
    }
    tree.node_count = 1;
    build(&tree, leaves, 0, 0, count, 0);
    for (int i = 0; i < count; i++) tree.facet[i] = leaves[i].facet;
    arena_free(&scratch);
    return tree;
}
