// raycast.c - the item buffer by casting one ray through each pixel's centre, in double precision, over a
// bounding-volume hierarchy split by the surface-area heuristic in bins (I. Wald, On fast construction of SAH-based
// bounding volume hierarchies, 2007). The hierarchy changes nothing: the answer equals the brute force's exactly,
// since every comparison it prunes by is monotone in what the brute force compares.
//
// A ray is inside a polygon when it lies on one side of all its edges' great circles, dot(v_i x v_i+1, ray), with v
// relative to the eye, or on one within rounding: no ray slips through a shared edge or vertex.
#include "visibility/hidden/raycast.h"

// Boxes are widened by this, metres: their slabs are computed with rounding, and a box without thickness would lose
// hits. Above the rounding of a coordinate at 1e8 m (MAPS_LIMIT), far below any feature.
#define RAY_BOX_PADDING 1e-6
// Roundings of dot(a x b, ray), relative to |a| |b| |ray|: 8 operations of half a bit each, doubled.
#define RAY_ROUNDING 8e-16
#define RAY_BINS 16
// Facets tested without looking for a better split.
#define RAY_LEAF 4
// Deeper than this the hierarchy is halved by count, which ends within 31 more levels.
#define RAY_DEEP 40
#define RAY_STACK (RAY_DEEP + 40)

typedef struct Facet {
    int polygon, order;  // order: place in the list
    const Vec3 *vertices;
    int count;
    Vec3 n, centre;
    Box box;
} Facet;

// Inner: children at `first` and `first + 1`, count 0. Leaf: facets first .. first + count - 1.
typedef struct Node {
    Box box;
    int first, count;
} Node;

struct RayScene {
    Facet *facets;
    Node *nodes;
    int facet_count, node_count;
};

static bool facet_make(const Scene *scene, int order, Facet *out) {
    int index = scene->list ? scene->list[order] : order;
    const Polygon *polygon = &scene->polygons[index];
    const Vec3 *v = scene->vertices + polygon->first_vertex;
    Vec3 n = plane_of_polygon(v, polygon->vertex_count).n;
    if (vec3_length(n) == 0) return false;
    Vec3 offset = {0, 0, 0};
    Box box = box_empty();
    for (int i = 0; i < polygon->vertex_count; i++) {
        offset = vec3_add(offset, vec3_sub(v[i], v[0]));
        box = box_add(box, v[i]);
    }
    Vec3 centre = vec3_add(v[0], vec3_scale(offset, 1.0 / polygon->vertex_count));
    *out = (Facet){index, order, v, polygon->vertex_count, n, centre, box_grow(box, RAY_BOX_PADDING)};
    return true;
}

static double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static double half_area(Box b) {
    if (box_is_empty(b)) return 0;
    Vec3 s = vec3_sub(b.max, b.min);
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

static void swap_facets(Facet *a, Facet *b) {
    Facet t = *a;
    *a = *b;
    *b = t;
}

// Orders facets[0 .. count) so that the `half` smallest along `axis` come first.
static void select_half(Facet *facets, int count, int half, int axis) {
    int low = 0, high = count - 1;
    while (low < high) {
        double pivot = component(facets[(low + high) / 2].centre, axis);
        int i = low, j = high;
        while (i <= j) {
            while (component(facets[i].centre, axis) < pivot) i++;
            while (component(facets[j].centre, axis) > pivot) j--;
            if (i <= j) swap_facets(&facets[i++], &facets[j--]);
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

static int bin_of(Bins bins, const Facet *facet) {
    int bin = (int)((component(facet->centre, bins.axis) - bins.low) * bins.scale);
    return bin < 0 ? 0 : bin >= RAY_BINS ? RAY_BINS - 1 : bin;
}

// The last bin of the cheaper side of the best split, or -1.
static int best_bin(Bins bins, const Facet *facets, int count) {
    Box box[RAY_BINS];
    int held[RAY_BINS] = {0};
    for (int b = 0; b < RAY_BINS; b++) box[b] = box_empty();
    for (int i = 0; i < count; i++) {
        int b = bin_of(bins, &facets[i]);
        box[b] = held[b]++ ? box_union(box[b], facets[i].box) : facets[i].box;
    }
    double right[RAY_BINS];
    Box sum = box_empty();
    int n = 0;
    for (int b = RAY_BINS - 1; b > 0; b--) {
        if (held[b]) sum = n ? box_union(sum, box[b]) : box[b];
        n += held[b];
        right[b] = n > 0 ? half_area(sum) * n : -1;
    }
    int best = -1;
    double best_cost = INFINITY;
    n = 0;
    for (int b = 0; b + 1 < RAY_BINS; b++) {
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

// Splits facets[0 .. count) in two; returns how many come first.
static int split(Facet *facets, int count, int depth) {
    Box centres = box_empty();
    for (int i = 0; i < count; i++) centres = box_add(centres, facets[i].centre);
    Vec3 size = vec3_sub(centres.max, centres.min);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    double extent = component(size, axis);
    Bins bins = {component(centres.min, axis), extent > 0 ? RAY_BINS / extent : 0, axis};
    int bin = depth < RAY_DEEP && isfinite(bins.scale) ? best_bin(bins, facets, count) : -1;
    if (bin < 0) {
        select_half(facets, count, count / 2, axis);
        return count / 2;
    }
    int first = 0;
    for (int i = 0; i < count; i++) {
        if (bin_of(bins, &facets[i]) <= bin) swap_facets(&facets[first++], &facets[i]);
    }
    return first;
}

static void build(RayScene *rays, int node, int first, int count, int depth) {
    Box box = rays->facets[first].box;
    for (int i = 1; i < count; i++) box = box_union(box, rays->facets[first + i].box);
    if (count <= RAY_LEAF) {
        rays->nodes[node] = (Node){box, first, count};
        return;
    }
    int left = split(rays->facets + first, count, depth), child = rays->node_count;
    rays->node_count += 2;
    rays->nodes[node] = (Node){box, child, 0};
    build(rays, child, first, left, depth + 1);
    build(rays, child + 1, first + left, count - left, depth + 1);
}

RayScene *ray_scene_new(const Scene *scene, Arena *arena) {
    RayScene *rays = ARENA_ARRAY(arena, RayScene, 1);
    rays->facets = ARENA_ARRAY(arena, Facet, scene->count + 1);
    for (int i = 0; i < scene->count; i++) {
        if (facet_make(scene, i, &rays->facets[rays->facet_count])) rays->facet_count++;
    }
    rays->nodes = ARENA_ARRAY(arena, Node, 2 * rays->facet_count + 1);
    if (rays->facet_count > 0) {
        rays->node_count = 1;
        build(rays, 0, 0, rays->facet_count, 0);
    }
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

static bool facet_hit(const Facet *facet, Vec3 eye, Vec3 ray, float *z) {
    double height = vec3_dot(facet->n, vec3_sub(facet->centre, eye)), slope = vec3_dot(facet->n, ray);
    if (fabs(height) < HIDDEN_EDGE_ON || slope == 0 || (height > 0) != (slope > 0)) return false;
    double in, out;
    if (!box_hit(&facet->box, eye, ray, &in, &out)) return false;
    Vec3 previous = vec3_sub(facet->vertices[facet->count - 1], eye);
    for (int i = 0; i < facet->count; i++) {
        Vec3 here = vec3_sub(facet->vertices[i], eye);
        // Its edges run counter-clockwise about n: the inside is to the left when n points away from the eye.
        double side = vec3_dot(vec3_cross(previous, here), ray);
        bool outside = height > 0 ? side < 0 : side > 0;
        if (outside && !is_rounding(side, previous, here, ray)) return false;
        previous = here;
    }
    // Within its box: the plane of a bent polygon may be met outside it, where the hierarchy does not look.
    *z = (float)fmin(fmax(height / slope, in), out);
    return true;
}

typedef struct Nearest {
    float z;
    int order, polygon;
} Nearest;

static void facet_take(const Facet *facet, Vec3 eye, Vec3 ray, Nearest *nearest) {
    float z;
    if (!facet_hit(facet, eye, ray, &z)) return;
    if (z < nearest->z || (z == nearest->z && facet->order < nearest->order)) {
        *nearest = (Nearest){z, facet->order, facet->polygon};
    }
}

int ray_scene_nearest_brute(const RayScene *rays, Vec3 eye, Vec3 ray, float *z) {
    Nearest nearest = {INFINITY, INT32_MAX, -1};
    for (int i = 0; i < rays->facet_count; i++) facet_take(&rays->facets[i], eye, ray, &nearest);
    *z = nearest.z;
    return nearest.polygon;
}

int ray_scene_nearest(const RayScene *rays, Vec3 eye, Vec3 ray, float *z) {
    Nearest nearest = {INFINITY, INT32_MAX, -1};
    struct {
        int node;
        double in;
    } stack[RAY_STACK];
    int held = 0;
    double in, out;
    if (rays->node_count > 0 && box_hit(&rays->nodes[0].box, eye, ray, &in, &out)) {
        stack[held].node = 0;
        stack[held++].in = in;
    }
    while (held > 0) {
        held--;
        // Rounded as hits are: a hit at an equal depth may still come earlier in the list.
        if ((float)stack[held].in > nearest.z) continue;
        const Node *node = &rays->nodes[stack[held].node];
        for (int i = 0; i < node->count; i++) facet_take(&rays->facets[node->first + i], eye, ray, &nearest);
        if (node->count > 0) continue;
        double near[2];
        bool hit[2];
        for (int c = 0; c < 2; c++) {
            hit[c] = box_hit(&rays->nodes[node->first + c].box, eye, ray, &near[c], &out);
        }
        int far = hit[0] && hit[1] && near[1] < near[0] ? 0 : 1;
        for (int k = 0; k < 2; k++) {
            int c = k == 0 ? far : 1 - far;
            if (!hit[c]) continue;
            CORE_ASSERT(held < RAY_STACK);
            stack[held].node = node->first + c;
            stack[held++].in = near[c];
        }
    }
    *z = nearest.z;
    return nearest.polygon;
}

static void *raycast_begin(const Scene *scene, Arena *arena, Error *error) {
    (void)error;
    return ray_scene_new(scene, arena);
}

static bool raycast_draw(void *prepared, const Camera *camera, ItemBuffer *out, Error *error) {
    (void)error;
    for (int j = 0; j < camera->height; j++) {
        for (int i = 0; i < camera->width; i++) {
            size_t pixel = (size_t)j * (size_t)camera->width + (size_t)i;
            Vec3 ray = camera_ray(camera, i + 0.5, j + 0.5);
            out->item[pixel] = ray_scene_nearest(prepared, camera->eye, ray, &out->depth[pixel]);
        }
    }
    return true;
}

const HiddenMethod HIDDEN_RAYCAST = {"raycast", "one ray a pixel in double precision, the reference",
                                     raycast_begin, raycast_draw, NULL};
