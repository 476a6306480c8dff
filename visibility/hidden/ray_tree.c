// ray_tree.c - a bounding-volume hierarchy split by the surface-area heuristic.
#include "visibility/hidden/ray_tree.h"

#include "engine/core/box_tree.h"

// Boxes are widened by this, metres: their slabs are computed with rounding, and a box without thickness would lose
// hits. Above the rounding of a coordinate at 1e8 m (MAPS_LIMIT), far below any feature.
#define TREE_PADDING 1e-6

static void build_facet_node(RayTree *tree, BoxItem *leaves, int node, int first, int count, int depth) {
    Box box = box_of_items(leaves + first, count);
    if (count <= TREE_LEAF) {
        tree->nodes[node] = (TreeNode){box, first, count};
        return;
    }
    int left = box_split(leaves + first, count, depth < TREE_DEEP ? BOX_SPLIT_LONGEST : BOX_SPLIT_HALVES);
    int child = tree->node_count;
    tree->node_count += 2;
    tree->nodes[node] = (TreeNode){box, child, 0};
    build_facet_node(tree, leaves, child, first, left, depth + 1);
    build_facet_node(tree, leaves, child + 1, first + left, count - left, depth + 1);
}

RayTree ray_tree_new(const Facets *facets, Arena *arena) {
    int count = facets->count;
    RayTree tree = {.nodes = ARENA_ARRAY(arena, TreeNode, 2 * count + 1),
                    .facet = ARENA_ARRAY(arena, int, count + 1),
                    .box = ARENA_ARRAY(arena, Box, count + 1)};
    if (count == 0) return tree;
    Arena scratch = {0};
    BoxItem *leaves = ARENA_ARRAY(&scratch, BoxItem, count);
    for (int i = 0; i < count; i++) {
        const Facet *facet = &facets->facets[i];
        Box box = box_empty();
        for (int k = 0; k < facet->count; k++) box = box_add(box, facets->corners[facet->first + k]);
        tree.box[i] = box_grow(box, TREE_PADDING);
        leaves[i] = (BoxItem){tree.box[i], facet->centre, i};
    }
    tree.node_count = 1;
    build_facet_node(&tree, leaves, 0, 0, count, 0);
    for (int i = 0; i < count; i++) tree.facet[i] = leaves[i].item;
    arena_free(&scratch);
    return tree;
}
