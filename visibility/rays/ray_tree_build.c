// ray_tree_build.c - a tree made from the root down: of a node's boxes the one of the largest area is split again and again until
// there are eight, each time where the surface-area heuristic in bins says (Wald 2007, On fast construction of SAH-based bounding
// volume hierarchies; Wald, Benthin & Boulos 2008 for more than two children).
#include "visibility/rays/ray_tree_build.h"

#include <float.h>

#include "visibility/rays/ray_tree.h"

enum { BINS = 16 };
// Planes of boxes are moved outwards by so many roundings of the largest coordinate: of the plane itself, and of a ray's origin,
// which becomes a float too.
static const double OUTWARDS = 4 * (double)FLT_EPSILON;
// And by this where all is near the origin, metres: what polygons reach beyond their edges, and more.
static const double OUTWARDS_LEAST = 1e-7;

typedef struct Item {
    Box box;
    Vec3 centre;
    int item;
} Item;

typedef struct Range {
    int first, count;
    double area;
    bool whole;  // it cannot be split, or need not be
} Range;

typedef struct Builder {
    SurfaceTree *tree;
    Item *items;
    double outwards;
    Arena *arena;
    int capacity;
} Builder;

static double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static double half_area(Box b) {
    if (box_is_empty(b)) return 0;
    Vec3 s = vec3_sub(b.max, b.min);
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

// ---- where to split

typedef struct Bins {
    double low, scale;
    int axis;
} Bins;

static int bin_of(Bins bins, const Item *item) {
    int bin = (int)((component(item->centre, bins.axis) - bins.low) * bins.scale);
    return bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin;
}

// The cheapest split after a bin: its cost, INFINITY where all lie in one.
static double cheapest(Bins bins, const Item *items, int count, int *after) {
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
        right[b] = half_area(sum) * (n += held[b]);
    }
    sum = box_empty();
    n = 0;
    for (int b = 0; b + 1 < BINS; b++) {
        if (held[b]) sum = box_union(sum, box[b]);
        n += held[b];
        if (n == 0 || n == count) continue;
        double cost = half_area(sum) * n + right[b + 1];
        if (cost < best) {
            best = cost;
            *after = b;
        }
    }
    return best;
}

static void swap(Item *a, Item *b) {
    Item t = *a;
    *a = *b;
    *b = t;
}

// Puts those of the split that costs least first; returns how many: half, as they come, where there is no telling.
static int split(Item *items, int count, bool by_cost) {
    Box centres = box_empty();
    for (int i = 0; i < count; i++) centres = box_add(centres, items[i].centre);
    Bins best_bins = {0};
    double best = INFINITY;
    int best_after = 0;
    for (int axis = 0; axis < 3 && by_cost; axis++) {
        double low = component(centres.min, axis), extent = component(centres.max, axis) - low;
        Bins bins = {low, BINS / extent, axis};
        int after = 0;
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
        if (bin_of(best_bins, &items[i]) <= best_after) swap(&items[first++], &items[i]);
    return first;
}

// ---- nodes

static Box box_of(const Item *items, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_union(box, items[i].box);
    return box;
}

static Range range_of(const Builder *b, int first, int count) {
    return (Range){first, count, half_area(box_of(b->items + first, count)), count <= SURFACE_TREE_LEAF};
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
        int left = split(b->items + r.first, r.count, depth < SURFACE_TREE_DEEPEST / 2);
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

static void build(Builder *b, int index, Range all, int depth) {
    Range range[LANES];
    int count = split_range(b, all, depth, range);
    if (depth + 1 > b->tree->depth) b->tree->depth = depth + 1;
    for (int i = 0; i < count; i++) {
        Box box = box_of(b->items + range[i].first, range[i].count);
        bool leaf = range[i].count <= SURFACE_TREE_LEAF;
        int child = leaf ? range[i].first : new_node(b);
        SurfaceNode *node = &b->tree->nodes[index];  // a new node may have moved it
        put_bounds(node, i, box, b->outwards);
        node->child[i] = child;
        node->count[i] = leaf ? range[i].count : 0;
        if (!leaf) build(b, child, range[i], depth + 1);
    }
}

static double largest_of(Box box) {
    if (box_is_empty(box)) return 0;
    return fmax(fmax(fmax(-box.min.x, box.max.x), fmax(-box.min.y, box.max.y)), fmax(-box.min.z, box.max.z));
}

SurfaceTree surface_tree_new(const RaySurfaces *surfaces, Arena *arena) {
    SurfaceTree tree = {.surfaces = surfaces, .items = ARENA_ARRAY(arena, int, surfaces->count + 1)};
    Arena scratch = {0};
    Builder b = {.tree = &tree, .items = ARENA_ARRAY(&scratch, Item, surfaces->count + 1), .arena = arena};
    b.outwards = fmax(OUTWARDS * largest_of(surfaces->box), OUTWARDS_LEAST);
    int count = 0;
    for (int i = 0; i < surfaces->count; i++) {
        Box box = surfaces->boxes[i];
        if (!box_is_empty(box)) b.items[count++] = (Item){box, vec3_lerp(box.min, box.max, 0.5), i};
    }
    int root = new_node(&b);
    if (count > 0) build(&b, root, range_of(&b, 0, count), 0);
    for (int i = 0; i < count; i++) tree.items[i] = b.items[i].item;
    arena_free(&scratch);
    return tree;
}
