// ray_tree.c - where rays go through a hierarchy of boxes, eight of which are met at once (Dammertz, Hanika & Keller 2008,
// Shallow Bounding Volume Hierarchies).
//
// Boxes are floats that hold what they bound whatever is rounded: planes are moved outwards when the tree is made, and distances
// are taken for a little longer than they are (Ize 2013, Robust BVH Ray Traversal). What is in them is met in doubles.
#include "visibility/rays/ray_tree.h"

#include "engine/core/error.h"
#include "visibility/rays/ray_tree_build.h"

// A direction that is no longer than this along an axis is taken to be so long: its inverse stays a number.
static const float LEAST_WAY = 1e-18f;
// By what the distance to a box may be too short: three roundings of a float, twice.
static const float LONGER = 1 + 6 * 0x1p-23f;

typedef struct Visit {
    float near;
    int32_t child, count;
} Visit;

// Each node on the way leaves seven of its children on the stack.
enum { STACK = 7 * SURFACE_TREE_DEEPEST + LANES };

typedef struct Traversal {
    Lane origin[3], inverse[3], near;
    int far_side[3];  // 1: it goes up that axis
    Visit stack[STACK];
    int height;
} Traversal;

static void begin_traversal(Traversal *t, const SurfaceRay *r) {
    const double o[3] = {r->origin.x, r->origin.y, r->origin.z};
    const double d[3] = {r->ray.direction.x, r->ray.direction.y, r->ray.direction.z};
    for (int a = 0; a < 3; a++) {
        float way = (float)d[a];
        if (fabsf(way) < LEAST_WAY) way = copysignf(LEAST_WAY, way);
        t->origin[a] = lane_of((float)o[a]);
        t->inverse[a] = lane_of(1 / way);
        t->far_side[a] = way > 0;
    }
    t->near = lane_of((float)fmax(r->ray.near, 0));
    t->stack[0] = (Visit){0, 0, 0};
    t->height = 1;
}

// The children of a node that are met before `far`, the nearest on top.
static inline void push_children(Traversal *t, const SurfaceNode *node, float far) {
    Lane near = t->near, end = lane_of(far);
    for (int a = 0; a < 3; a++) {
        near = lane_most((node->bound[a][1 - t->far_side[a]] - t->origin[a]) * t->inverse[a], near);
        end = lane_least((node->bound[a][t->far_side[a]] - t->origin[a]) * t->inverse[a], end);
    }
    unsigned met = lane_mask(near <= end * LONGER);
    int first = t->height;
    for (; met; met &= met - 1) {
        int i = __builtin_ctz(met), at = t->height++;
        Visit visit = {near[i], node->child[i], node->count[i]};
        for (; at > first && t->stack[at - 1].near < visit.near; at--) t->stack[at] = t->stack[at - 1];
        t->stack[at] = visit;
    }
}

// Of a distance, none shorter.
static inline float above(double t) { return (float)t * LONGER; }

SurfaceHit surface_tree_first(const SurfaceTree *tree, const Ray *ray) {
    SurfaceRay r = surface_ray(tree->surfaces, ray);
    SurfaceHit best = surface_miss(ray);
    Traversal t;
    if (tree->surfaces->count == 0) return best;
    begin_traversal(&t, &r);
    float far = above(best.at.t + RAY_SAME_PLACE);
    while (t.height > 0) {
        Visit visit = t.stack[--t.height];
        if (visit.near > far * LONGER) continue;
        if (visit.count == 0) {
            push_children(&t, &tree->nodes[visit.child], far);
            continue;
        }
        for (int i = 0; i < visit.count; i++)
            ray_surface_try(tree->surfaces, tree->items[visit.child + i], &r, &best);
        far = above(best.at.t + RAY_SAME_PLACE);
    }
    return best;
}

bool surface_tree_blocked(const SurfaceTree *tree, const Ray *ray) {
    SurfaceRay r = surface_ray(tree->surfaces, ray);
    Traversal t;
    if (tree->surfaces->count == 0) return false;
    begin_traversal(&t, &r);
    float far = above(ray->far);
    while (t.height > 0) {
        Visit visit = t.stack[--t.height];
        if (visit.count == 0) {
            push_children(&t, &tree->nodes[visit.child], far);
            continue;
        }
        for (int i = 0; i < visit.count; i++)
            if (ray_surface_blocks(tree->surfaces, tree->items[visit.child + i], &r)) return true;
    }
    return false;
}
