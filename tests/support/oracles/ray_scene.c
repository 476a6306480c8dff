// ray_scene.c - rays in double precision over a bounding-volume hierarchy. The hierarchy changes nothing: the answer equals
// the brute force's exactly, since every comparison it prunes by is monotone in what the brute force compares.
//
// A ray is inside a polygon when it lies on one side of all its edges' great circles, dot(v_i x v_i+1, ray), with v
// relative to the eye, or on one within rounding: no ray slips through a shared edge or vertex. Nothing here knows of
// pictures and their lines: it is what these are held against.
#include "tests/support/oracles/ray_scene.h"

#include "visibility/hidden/depth.h"
#include "visibility/hidden/ray_tree.h"

// Roundings of dot(a x b, ray), relative to |a| |b| |ray|: 8 operations of half a bit each, doubled.
#define RAY_ROUNDING 8e-16

struct RayScene {
    Facets facets;
    RayTree tree;
};

RayScene *ray_scene_new(const Scene *scene, Arena *arena, Error *error) {
    RayScene *rays = ARENA_ARRAY(arena, RayScene, 1);
    if (!facets_new(scene, arena, &rays->facets, error)) return NULL;
    rays->tree = ray_tree_new(&rays->facets, arena);
    return rays;
}

// Narrows [*in, *out] to the z at which eye + z * ray is between the slabs of one axis.
static void slab(double min, double max, double eye, double ray, double *in, double *out) {
    if (ray == 0) {
        if (!(min <= eye && eye <= max)) *out = -INFINITY;
        return;
    }
    double a = (min - eye) / ray, b = (max - eye) / ray;
    *in = fmax(*in, fmin(a, b));
    *out = fmin(*out, fmax(a, b));
}

static bool box_hit(const Box *box, Vec3 eye, Vec3 ray, double *in, double *out) {
    *in = 0;
    *out = INFINITY;
    slab(box->min.x, box->max.x, eye.x, ray.x, in, out);
    slab(box->min.y, box->max.y, eye.y, ray.y, in, out);
    slab(box->min.z, box->max.z, eye.z, ray.z, in, out);
    return *in <= *out;
}

static bool is_rounding(double side, Vec3 a, Vec3 b, Vec3 ray) {
    double scale = vec3_dot(a, a) * vec3_dot(b, b) * vec3_dot(ray, ray);
    return side * side <= RAY_ROUNDING * RAY_ROUNDING * scale;
}

static bool facet_hit(const RayScene *rays, int index, Vec3 eye, Vec3 ray, double *z) {
    const Facet *facet = &rays->facets.facets[index];
    double height = vec3_dot(facet->n, vec3_sub(facet->centre, eye)), slope = vec3_dot(facet->n, ray);
    if (fabs(height) < HIDDEN_EDGE_ON || slope == 0 || (height > 0) != (slope > 0)) return false;
    double in, out;
    if (!box_hit(&rays->tree.box[index], eye, ray, &in, &out)) return false;
    const Vec3 *corners = rays->facets.corners + facet->first;
    Vec3 previous = vec3_sub(corners[facet->count - 1], eye);
    for (int i = 0; i < facet->count; i++) {
        Vec3 here = vec3_sub(corners[i], eye);
        // Its edges run counter-clockwise about n: the inside is to the left when n points away from the eye.
        double side = vec3_dot(vec3_cross(previous, here), ray);
        bool outside = height > 0 ? side < 0 : side > 0;
        if (outside && !is_rounding(side, previous, here, ray)) return false;
        previous = here;
    }
    // Within its box: rounding may put a plane seen at a grazing angle outside it, where the hierarchy does not look.
    *z = fmin(fmax(height / slope, in), out);
    return true;
}

typedef struct Nearest {
    double z;
    int64_t key;  // of z, which grows with it
    int order, polygon;
} Nearest;

static const Nearest NOTHING = {INFINITY, INT64_MAX, INT32_MAX, -1};

static void facet_take(const RayScene *rays, int index, Vec3 eye, Vec3 ray, Nearest *nearest) {
    double z;
    if (!facet_hit(rays, index, eye, ray, &z)) return;
    const Facet *facet = &rays->facets.facets[index];
    int64_t key = depth_key(z);
    if (key < nearest->key || (key == nearest->key && facet->order < nearest->order))
        *nearest = (Nearest){z, key, facet->order, facet->polygon};
}

int ray_scene_nearest_brute(const RayScene *rays, Vec3 eye, Vec3 ray, float *z) {
    Nearest nearest = NOTHING;
    for (int i = 0; i < rays->facets.count; i++) facet_take(rays, i, eye, ray, &nearest);
    *z = (float)nearest.z;
    return nearest.polygon;
}

int ray_scene_nearest(const RayScene *rays, Vec3 eye, Vec3 ray, float *z) {
    const RayTree *tree = &rays->tree;
    Nearest nearest = NOTHING;
    struct {
        int node;
        double in;
    } stack[TREE_STACK];
    int held = 0;
    double in, out;
    if (tree->node_count > 0 && box_hit(&tree->nodes[0].box, eye, ray, &in, &out)) {
        stack[held].node = 0;
        stack[held++].in = in;
    }
    while (held > 0) {
        held--;
        // By keys, as hits are: one at an equal depth may still come earlier in the list.
        if (depth_key(stack[held].in) > nearest.key) continue;
        const TreeNode *node = &tree->nodes[stack[held].node];
        for (int i = 0; i < node->count; i++)
            facet_take(rays, tree->facet[node->first + i], eye, ray, &nearest);
        if (node->count > 0) continue;
        double near[2];
        bool hit[2];
        for (int c = 0; c < 2; c++)
            hit[c] = box_hit(&tree->nodes[node->first + c].box, eye, ray, &near[c], &out);
        int far = hit[0] && hit[1] && near[1] < near[0] ? 0 : 1;
        for (int k = 0; k < 2; k++) {
            int c = k == 0 ? far : 1 - far;
            if (!hit[c]) continue;
            CORE_ASSERT(held < TREE_STACK);
            stack[held].node = node->first + c;
            stack[held++].in = near[c];
        }
    }
    *z = (float)nearest.z;
    return nearest.polygon;
}
