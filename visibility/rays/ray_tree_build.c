// ray_tree_build.c - a tree made from the root down: of a node's boxes the one of the largest area is split again and again until
// there are eight, each time where the surface-area heuristic in bins says (Wald 2007, On fast construction of SAH-based bounding
// volume hierarchies; Wald, Benthin & Boulos 2008 for more than two children).
#include "visibility/rays/ray_tree_build.h"

#include <float.h>

#include "engine/core/box_tree.h"
#include "visibility/rays/ray_tree.h"

// Planes of boxes are moved outwards by so many roundings of the largest coordinate: of the plane itself, and of a ray's origin,
// which becomes a float too.
static const double OUTWARDS = 4 * (double)FLT_EPSILON;
// And by this where all is near the origin, metres: what polygons reach beyond their edges, and more.
static const double OUTWARDS_LEAST = 1e-7;

typedef struct Range {
    int first, count;
    double area;
    bool whole;  // it cannot be split, or need not be
} Range;

typedef struct Builder {
    SurfaceTree *tree;
    BoxItem *items;
    double outwards;
    Arena *arena;
    int capacity;
} Builder;

static Range range_of(const Builder *b, int first, int count) {
    return (Range){first, count, box_half_area(box_of_items(b->items + first, count)),
                   count <= SURFACE_TREE_LEAF};
}

// Splits the largest until there are eight.
static int split_range(const Builder *b, Range all, int depth, Range range[LANES]) {
    int count = 1;
    range[0] = all;
    while (count < LANES) {
        int largest = -1;
        for (int i = 0; i < count; i++)
            if (!range[i].whole && (largest < 0 || range[i].area > range[largest].area)) largest = i;
        if (largest < 0) break;
        Range r = range[largest];
        int left = box_split(b->items + r.first, r.count,
                             depth < SURFACE_TREE_DEEPEST / 2 ? BOX_SPLIT_ANY_AXIS : BOX_SPLIT_HALVES);
        range[largest] = range_of(b, r.first, left);
        range[count++] = range_of(b, r.first + left, r.count - left);
    }
    return count;
}

static void put_bounds(SurfaceNode *node, int lane, Box box, double outwards) {
    box = box_grow(box, outwards);
    const double low[3] = {box.min.x, box.min.y, box.min.z}, high[3] = {box.max.x, box.max.y, box.max.z};
    for (int a = 0; a < 3; a++) {
        node->bound[a][0][lane] = nextafterf((float)low[a], -INFINITY);
        node->bound[a][1][lane] = nextafterf((float)high[a], INFINITY);
    }
}

static int new_node(Builder *b) {
    SurfaceTree *tree = b->tree;
    SurfaceNode *node = ARENA_PUSH(b->arena, tree->nodes, tree->node_count, b->capacity);
    for (int a = 0; a < 3; a++) {
        node->bound[a][0] = lane_of(FLT_MAX);
        node->bound[a][1] = lane_of(-FLT_MAX);
    }
    return tree->node_count - 1;
}

static void build_surface_node(Builder *b, int index, Range all, int depth) {
    Range range[LANES];
    int count = split_range(b, all, depth, range);
    if (depth + 1 > b->tree->depth) b->tree->depth = depth + 1;
    for (int i = 0; i < count; i++) {
        Box box = box_of_items(b->items + range[i].first, range[i].count);
        bool leaf = range[i].count <= SURFACE_TREE_LEAF;
        int child = leaf ? range[i].first : new_node(b);
        SurfaceNode *node = &b->tree->nodes[index];  // a new node may have moved it
        put_bounds(node, i, box, b->outwards);
        node->child[i] = child;
        node->count[i] = leaf ? range[i].count : 0;
        if (!leaf) build_surface_node(b, child, range[i], depth + 1);
    }
}

static double largest_of(Box box) {
    if (box_is_empty(box)) return 0;
    return fmax(fmax(fmax(-box.min.x, box.max.x), fmax(-box.min.y, box.max.y)), fmax(-box.min.z, box.max.z));
}

SurfaceTree surface_tree_new(const RaySurfaces *surfaces, Arena *arena) {
    SurfaceTree tree = {.surfaces = surfaces, .items = ARENA_ARRAY(arena, int, surfaces->count + 1)};
    Arena scratch = {0};
    Builder b = {.tree = &tree, .items = ARENA_ARRAY(&scratch, BoxItem, surfaces->count + 1), .arena = arena};
    b.outwards = fmax(OUTWARDS * largest_of(surfaces->box), OUTWARDS_LEAST);
    int count = 0;
    for (int i = 0; i < surfaces->count; i++) {
        Box box = surfaces->boxes[i];
        if (!box_is_empty(box)) b.items[count++] = (BoxItem){box, vec3_lerp(box.min, box.max, 0.5), i};
    }
    int root = new_node(&b);
    if (count > 0) build_surface_node(&b, root, range_of(&b, 0, count), 0);
    for (int i = 0; i < count; i++) tree.items[i] = b.items[i].item;
    arena_free(&scratch);
    return tree;
}
