// box_tree.c - a k-d tree of boxes: the boxes are halved at the median of their middles, along the axis on which the middles lie
// farthest apart, until few are left. The split is at the median, not at the middle of space, so that one box far from all others
// costs one level at most.
#include "engine/core/box_tree.h"

#include <stdlib.h>

// A node over the items order[first] .. order[first + count - 1]. Nodes lie depth-first; `next` is the node after this node's
// subtree.
typedef struct BoxNode {
    Box box;
    int first, count, next;
} BoxNode;

enum { LEAF = 4 };  // most boxes in a leaf: smaller leaves cost more in nodes than they save in tests

typedef struct Builder {
    BoxTree *tree;
    Vec3 *middles;  // [count]
} Builder;

static double middle_along(Vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

// Ties go to the lower index, so that the tree does not depend on the earlier order of the boxes.
static bool is_box_before(const Builder *b, int axis, int i, int j) {
    double p = middle_along(b->middles[i], axis), q = middle_along(b->middles[j], axis);
    return p != q ? p < q : i < j;
}

static void swap(int *a, int *b) {
    int c = *a;
    *a = *b;
    *b = c;
}

// Puts the `middle` boxes that come first along the axis before the others (C. A. R. Hoare, Algorithm 65: Find, 1961).
static void halve_boxes(const Builder *b, int *order, int count, int middle, int axis) {
    int low = 0, high = count - 1;
    while (low < high) {
        int pivot = order[low + (high - low) / 2], i = low, j = high;
        while (i <= j) {
            while (is_box_before(b, axis, order[i], pivot)) i++;
            while (is_box_before(b, axis, pivot, order[j])) j--;
            if (i <= j) swap(&order[i++], &order[j--]);
        }
        if (j < middle) low = i;
        if (i > middle) high = j;
    }
}

static int widest_axis(const Builder *b, int first, int count) {
    Box box = box_empty();
    for (int i = first; i < first + count; i++) box = box_add(box, b->middles[b->tree->order[i]]);
    Vec3 size = vec3_sub(box.max, box.min);
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

static void add_box_node(Builder *b, int first, int count) {
    BoxTree *tree = b->tree;
    BoxNode *node = &tree->nodes[tree->node_count++];
    *node = (BoxNode){.box = box_empty(), .first = first};
    for (int i = first; i < first + count; i++) node->box = box_union(node->box, tree->boxes[tree->order[i]]);
    if (count <= LEAF) {
        node->count = count;
    } else {
        int half = count / 2;
        halve_boxes(b, tree->order + first, count, half, widest_axis(b, first, count));
        add_box_node(b, first, half);
        add_box_node(b, first + half, count - half);
    }
    node->next = tree->node_count;
}

BoxTree box_tree_build(const Box *boxes, int count, Arena *arena) {
    BoxTree tree = {.boxes = boxes, .order = ARENA_ARRAY(arena, int, count)};
    Builder builder = {&tree, ARENA_ARRAY(arena, Vec3, count)};
    for (int i = 0; i < count; i++) {
        if (box_is_empty(boxes[i])) continue;
        builder.middles[i] = vec3_scale(vec3_add(boxes[i].min, boxes[i].max), 0.5);
        tree.order[tree.count++] = i;
    }
    // Every leaf holds at least two boxes, except in a tree of one box, so that there are at most count + 1 nodes.
    tree.nodes = ARENA_ARRAY(arena, BoxNode, tree.count + 1);
    if (tree.count > 0) add_box_node(&builder, 0, tree.count);
    return tree;
}

static int ascending(const void *p, const void *q) {
    int a = *(const int *)p, b = *(const int *)q;
    return (a > b) - (a < b);
}

int box_tree_find(const BoxTree *tree, Box box, Arena *arena, BoxHits *hits) {
    hits->count = 0;
    for (int n = 0; n < tree->node_count;) {
        const BoxNode *node = &tree->nodes[n];
        hits->looked++;
        if (!box_overlap(node->box, box)) {
            n = node->next;
            continue;
        }
        hits->looked += node->count;
        for (int i = node->first; i < node->first + node->count; i++) {
            int item = tree->order[i];
            if (!box_overlap(tree->boxes[item], box)) continue;
            *ARENA_PUSH(arena, hits->items, hits->count, hits->capacity) = item;
        }
        n++;
    }
    if (hits->count > 1) qsort(hits->items, (size_t)hits->count, sizeof *hits->items, ascending);
    return hits->count;
}

// ---- splitting of boxes: they are counted into bins by their centres along each axis; a split between two bins costs the surface
// area of either side times the number of boxes on that side

enum { BINS = 16 };

double box_half_area(Box b) {
    if (box_is_empty(b)) return 0;
    Vec3 s = vec3_sub(b.max, b.min);
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

typedef struct Bins {
    double low, scale;
    int axis;
} Bins;

static int bin_of(Bins bins, const BoxItem *item) {
    int bin = (int)((vec3_component(item->centre, bins.axis) - bins.low) * bins.scale);
    return bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin;
}

// The cost of the cheapest split, which lies after bin `after`; INFINITY where all boxes lie in one bin.
static double cheapest(Bins bins, const BoxItem *items, int count, int *after) {
    Box box[BINS], sum = box_empty();
    int held[BINS] = {0}, n = 0;
    double right[BINS], best = INFINITY;
    for (int b = 0; b < BINS; b++) box[b] = box_empty();
    for (int i = 0; i < count; i++) {
        int b = bin_of(bins, &items[i]);
        held[b]++;
        box[b] = box_union(box[b], items[i].box);
    }
    for (int b = BINS - 1; b > 0; b--) {
        if (held[b]) sum = box_union(sum, box[b]);
        right[b] = box_half_area(sum) * (n += held[b]);
    }
    sum = box_empty();
    n = 0;
    for (int b = 0; b + 1 < BINS; b++) {
        if (held[b]) sum = box_union(sum, box[b]);
        n += held[b];
        if (n == 0 || n == count) continue;
        double cost = box_half_area(sum) * n + right[b + 1];
        if (cost < best) {
            best = cost;
            *after = b;
        }
    }
    return best;
}

static void swap_items(BoxItem *a, BoxItem *b) {
    BoxItem t = *a;
    *a = *b;
    *b = t;
}

int box_split(BoxItem *items, int count, int way) {
    Box centres = box_empty();
    for (int i = 0; i < count; i++) centres = box_add(centres, items[i].centre);
    Bins best_bins = {0};
    double best = INFINITY;
    int best_after = 0;
    Vec3 size = vec3_sub(centres.max, centres.min);
    int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    for (int axis = 0; axis < 3 && way != BOX_SPLIT_HALVES; axis++) {
        double low = vec3_component(centres.min, axis), extent = vec3_component(centres.max, axis) - low;
        Bins bins = {low, BINS / extent, axis};
        int after = 0;
        if (way == BOX_SPLIT_LONGEST && axis != longest) continue;
        if (!(extent > 0) || !isfinite(bins.scale)) continue;
        double cost = cheapest(bins, items, count, &after);
        if (!(cost < best)) continue;
        best = cost;
        best_bins = bins;
        best_after = after;
    }
    if (!isfinite(best)) return count / 2;
    int first = 0;
    for (int i = 0; i < count; i++)
        if (bin_of(best_bins, &items[i]) <= best_after) swap_items(&items[first++], &items[i]);
    return first;
}

Box box_of_items(const BoxItem *items, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_union(box, items[i].box);
    return box;
}
