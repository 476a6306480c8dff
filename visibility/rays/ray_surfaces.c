// ray_surfaces.c - where a ray meets a polygon: the plane gives the place, and the ray must pass all edges on one side, which
// the sign of the Plucker product of their lines tells (Shoemake 1998; Amanatides & Choi 1997).
//
// Neighbours have their edge in opposite directions: all terms change their sign and nothing else, so rounding cannot make a
// ray pass between them. Where vertices of one lie on the edge of the other, polygons reach EDGE_SLACK beyond their edges.
//
// The hierarchy: eight boxes are met at once (Dammertz, Hanika & Keller 2008, Shallow Bounding Volume Hierarchies). Boxes are
// floats that hold what they bound whatever is rounded: planes are moved outwards when the tree is made, and distances are
// taken for a little longer than they are (Ize 2013, Robust BVH Ray Traversal). The surfaces in them are met in doubles.
//
// It is made from the root down: of a node's boxes the one of the largest area is split again and again until
// there are eight, each time where the surface-area heuristic in bins says (Wald 2007, On fast construction of SAH-based
// bounding volume hierarchies; Wald, Benthin & Boulos 2008 for more than two children).
//
// The grid: rays go from cell to cell of a uniform grid, and try the surfaces in each (Amanatides & Woo 1987, A Fast Voxel Traversal
// Algorithm; Fujimoto, Tanaka & Iwata 1986). A hit counts once the ray has come to where it is: what reaches into several cells
// is met beyond the present one, too. Departure: no list remembers the surfaces tried in the cell before (their mailboxes), so that
// threads share nothing.
#include "visibility/rays/ray_surfaces.h"

#include <float.h>
#ifdef __AVX__
#include <immintrin.h>
#endif

#include "engine/core/box_tree.h"
#include "engine/core/error.h"
#include "engine/core/lanes.h"

// ---- surfaces one by one

// Four edges of a polygon, from a to b: a x b and b - a, over their length. The last edge fills up the last four.
typedef struct RayEdges {
    Four moment[3], way[3];
} RayEdges;

typedef struct RayPolygon {
    Plane plane;                  // front: counter-clockwise
    int first_edges, edge_count;  // in RaySurfaces.edges; 0: it has no area and is never met
} RayPolygon;

// A ray as all surfaces need it.
typedef struct SurfaceRay {
    Ray ray;              // in the building
    Vec3 origin, moment;  // relative; origin x direction
} SurfaceRay;

static inline SurfaceHit surface_miss(const Ray *ray) {
    return (SurfaceHit){.item = -1, .at = {.t = ray->far}};
}

// Surfaces nearer than this along a ray lie in one place, metres: above rounding 1e8 m from the origin, below any sheet.
#define RAY_SAME_PLACE 1e-6

// How far a ray may pass outside of an edge, metres: above rounding in buildings of a kilometre (1e-12), far below all that
// shows.
static const double EDGE_SLACK = 1e-9;
// The least sine of the angle between a ray and a plane it meets: below, the place is rounding.
static const double LEAST_SINE = 1e-12;

// ---- made once

static void put_edge(RayEdges *edges, int lane, Vec3 a, Vec3 b) {
    Vec3 way = vec3_sub(b, a), moment = vec3_cross(a, b);
    double length = vec3_length(way);
    way = vec3_scale(way, 1 / length);
    moment = vec3_scale(moment, 1 / length);
    edges->way[0][lane] = way.x, edges->way[1][lane] = way.y, edges->way[2][lane] = way.z;
    edges->moment[0][lane] = moment.x, edges->moment[1][lane] = moment.y, edges->moment[2][lane] = moment.z;
}

// A vertex that repeats the one before it has no edge.
static int distinct(const RaySource *source, const Polygon *p, Vec3 origin, Vec3 *out) {
    int count = 0;
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 v = vec3_sub(source->vertices[p->first_vertex + i], origin);
        if (count == 0 || !vec3_equal(v, out[count - 1])) out[count++] = v;
    }
    while (count > 1 && vec3_equal(out[count - 1], out[0])) count--;
    return count;
}

static void put_polygon(RaySurfaces *s, int item, const Vec3 *v, int count) {
    RayPolygon *p = &s->polygons[item];
    if (count >= 3) p->plane = plane_of_polygon(v, count);
    s->boxes[item] = box_empty();
    for (int i = 0; i < count; i++) s->boxes[item] = box_add(s->boxes[item], v[i]);
    if (vec3_dot(p->plane.n, p->plane.n) == 0) return;
    p->edge_count = count;
    RayEdges *edges = s->edges + p->first_edges;
    for (int i = 0; i < (count + 3) / 4 * 4; i++) {
        int k = i < count ? i : count - 1;
        put_edge(&edges[i / 4], i % 4, v[k], v[(k + 1) % count]);
    }
}

static void put_polygons(RaySurfaces *s, const RaySource *source, Arena *arena) {
    Arena scratch = {0};
    int fours = 0, most = 0;
    for (int i = 0; i < source->list_count; i++) {
        int count = source->polygons[source->list[i]].vertex_count;
        s->polygons[i].first_edges = fours;
        fours += (count + 3) / 4;
        if (count > most) most = count;
    }
    s->edges = ARENA_ARRAY(arena, RayEdges, fours + 1);
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, most + 1);
    for (int i = 0; i < source->list_count; i++) {
        int count = distinct(source, &source->polygons[source->list[i]], s->origin, v);
        put_polygon(s, i, v, count);
    }
    arena_free(&scratch);
}

// The middle of all, whole metres: what is relative to it is as exact as it was.
static Vec3 find_origin(const RaySource *source) {
    Box box = box_empty();
    for (int i = 0; i < source->list_count; i++) {
        const Polygon *p = &source->polygons[source->list[i]];
        for (int k = 0; k < p->vertex_count; k++) box = box_add(box, source->vertices[p->first_vertex + k]);
    }
    if (box_is_empty(box)) return vec3(0, 0, 0);
    Vec3 m = vec3_lerp(box.min, box.max, 0.5);
    return vec3(round(m.x), round(m.y), round(m.z));
}

RaySurfaces ray_surfaces_new(const RaySource *source, Arena *arena) {
    int count = source->list_count + source->shape_count;
    RaySurfaces s = {.origin = find_origin(source),
                     .polygons = ARENA_ARRAY(arena, RayPolygon, source->list_count + 1),
                     .shapes = ARENA_ARRAY(arena, int, source->shape_count + 1),
                     .boxes = ARENA_ARRAY(arena, Box, count + 1),
                     .box = box_empty(),
                     .polygon_count = source->list_count,
                     .count = count};
    put_polygons(&s, source, arena);
    if (source->shape_count > 0) s.curved = curved_rays_new(source->building, arena);
    for (int i = 0; i < source->shape_count; i++) {
        s.shapes[i] = source->shapes[i];
        Box box = curved_rays_box(s.curved, s.shapes[i]);
        s.boxes[source->list_count + i] = (Box){vec3_sub(box.min, s.origin), vec3_sub(box.max, s.origin)};
    }
    for (int i = 0; i < count; i++)
        if (!box_is_empty(s.boxes[i])) s.box = box_union(s.box, s.boxes[i]);
    return s;
}

// ---- rays

static SurfaceRay surface_ray(const RaySurfaces *s, const Ray *ray) {
    Vec3 origin = vec3_sub(ray->origin, s->origin);
    return (SurfaceRay){*ray, origin, vec3_cross(origin, ray->direction)};
}

// Bit i: the number is below that of the limit.
static inline int below(Four a, double limit) {
#ifdef __AVX__
    return _mm256_movemask_pd(_mm256_cmp_pd((__m256d)a, (__m256d)four_of(limit), _CMP_LT_OQ));
#else
    return (a[0] < limit) | (a[1] < limit) << 1 | (a[2] < limit) << 2 | (a[3] < limit) << 3;
#endif
}

// `t` where it meets the plane, before `far`; by the front where `along`, the cosine, is below 0.
static inline bool meets(const RaySurfaces *s, const RayPolygon *p, const SurfaceRay *r, double far,
                         double *t, double *along) {
    *along = vec3_dot(p->plane.n, r->ray.direction);
    *t = (p->plane.d - vec3_dot(p->plane.n, r->origin)) / *along;
    if (!(*t > r->ray.near && *t < far) || fabs(*along) < LEAST_SINE) return false;
    double side = *along < 0 ? -1 : 1;  // inside of all edges the product is above 0
    Four d[3] = {four_of(side * r->ray.direction.x), four_of(side * r->ray.direction.y),
                 four_of(side * r->ray.direction.z)};
    Four m[3] = {four_of(side * r->moment.x), four_of(side * r->moment.y), four_of(side * r->moment.z)};
    const RayEdges *e = s->edges + p->first_edges;
    for (int i = 0; i < p->edge_count; i += 4, e++) {
        Four inside = (d[0] * e->moment[0] + d[1] * e->moment[1] + d[2] * e->moment[2]) +
                      (m[0] * e->way[0] + m[1] * e->way[1] + m[2] * e->way[2]);
        if (below(inside, -EDGE_SLACK)) return false;
    }
    return p->edge_count > 0;
}

// An order of its own, so that it does not matter in which one items are tried: places along a ray are counted in whole steps.
static bool is_seen_before(const SurfaceHit *a, const SurfaceHit *b) {
    double place = floor(a->at.t / RAY_SAME_PLACE), other = floor(b->at.t / RAY_SAME_PLACE);
    if (b->item < 0 || place != other) return place < other || (b->item < 0 && place == other);
    return a->front != b->front ? a->front : a->item < b->item;
}

// Meets one item: replaces `best` where it is nearer. Of surfaces in one place that one is met which turns its front to the ray,
// then the lower item, whatever the order in which they are tried.
static void ray_surface_try(const RaySurfaces *s, int item, const SurfaceRay *r, SurfaceHit *best) {
    double far = fmin(best->at.t + RAY_SAME_PLACE, r->ray.far);
    SurfaceHit hit = {.item = item};
    if (item < s->polygon_count) {
        const RayPolygon *p = &s->polygons[item];
        double t, along;
        if (!meets(s, p, r, far, &t, &along)) return;
        hit.front = along < 0;
        hit.at = (RayHit){.t = t, .normal = p->plane.n};
    } else {
        Ray ray = r->ray;
        ray.far = far;
        if (!curved_rays_hit(s->curved, s->shapes[item - s->polygon_count], &ray, &hit.at, NULL)) return;
        hit.front = vec3_dot(hit.at.normal, ray.direction) < 0;
    }
    if (is_seen_before(&hit, best)) *best = hit;
}

// Is it met at all?
static bool ray_surface_blocks(const RaySurfaces *s, int item, const SurfaceRay *r) {
    double t, along;
    RayHit hit;
    if (item < s->polygon_count) return meets(s, &s->polygons[item], r, r->ray.far, &t, &along);
    return curved_rays_hit(s->curved, s->shapes[item - s->polygon_count], &r->ray, &hit, NULL);
}

SurfaceHit ray_surfaces_brute(const RaySurfaces *s, const Ray *ray) {
    SurfaceRay r = surface_ray(s, ray);
    SurfaceHit best = surface_miss(ray);
    for (int i = 0; i < s->count; i++) ray_surface_try(s, i, &r, &best);
    return best;
}

// ---- the hierarchy, made

// Items of a leaf, at most.
enum { SURFACE_TREE_LEAF = 3 };
// Nodes on top of one another, at most. Where splits by cost go deeper than half of that, the rest is halved by count: 31 times
// at most.
enum { SURFACE_TREE_DEEPEST = 64 };

// Bounds of its eight children, each axis: low, high. A child that is not there has a box that no ray meets.
typedef struct SurfaceNode {
    Lane bound[3][2];
    int32_t child[LANES];  // a node, or of a leaf the first in SurfaceTree.items
    int32_t count[LANES];  // of items; 0: a node
} SurfaceNode;

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

typedef struct TreeBuilder {
    SurfaceTree *tree;
    BoxItem *items;
    double outwards;
    Arena *arena;
    int capacity;
} TreeBuilder;

static Range range_of(const TreeBuilder *b, int first, int count) {
    return (Range){first, count, box_half_area(box_of_items(b->items + first, count)),
                   count <= SURFACE_TREE_LEAF};
}

// Splits the largest until there are eight.
static int split_range(const TreeBuilder *b, Range all, int depth, Range range[LANES]) {
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

static int new_node(TreeBuilder *b) {
    SurfaceTree *tree = b->tree;
    SurfaceNode *node = ARENA_PUSH(b->arena, tree->nodes, tree->node_count, b->capacity);
    for (int a = 0; a < 3; a++) {
        node->bound[a][0] = lane_of(FLT_MAX);
        node->bound[a][1] = lane_of(-FLT_MAX);
    }
    return tree->node_count - 1;
}

static void build_surface_node(TreeBuilder *b, int index, Range all, int depth) {
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
    TreeBuilder b = {
        .tree = &tree, .items = ARENA_ARRAY(&scratch, BoxItem, surfaces->count + 1), .arena = arena};
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

// ---- rays through the hierarchy

// A direction that is no longer than this along an axis is taken to be so long: its inverse stays a number.
static const float LEAST_WAY = 1e-18f;
// The distance to a box may be too short by this share: three roundings of a float, twice.
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

// Rounds a distance up.
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

// ---- the grid

// Cells to an item: more are passed through for longer, fewer hold more.
static const double CELLS_AN_ITEM = 4;
enum { MOST_CELLS_AN_AXIS = 256 };
// Items reach into cells a little beyond them, metres, for rays that pass along the border of two: more than rounding.
static const double BEYOND = 1e-6;

// ---- made once

static int cell_along(const SurfaceGrid *grid, int axis, double at) {
    int cell = (int)floor((at - vec3_component(grid->low, axis)) / vec3_component(grid->size, axis));
    return cell < 0 ? 0 : cell >= grid->count[axis] ? grid->count[axis] - 1 : cell;
}

static int cell_index(const SurfaceGrid *grid, const int at[3]) {
    return (at[2] * grid->count[1] + at[1]) * grid->count[0] + at[0];
}

// Does the plane of a polygon pass through a cell? Shapes are taken to reach into all cells of their boxes.
static bool touches(const SurfaceGrid *grid, int item, const int at[3]) {
    if (item >= grid->surfaces->polygon_count) return true;
    Plane plane = grid->surfaces->polygons[item].plane;
    Vec3 s = vec3_scale(grid->size, 0.5);
    Vec3 middle = vec3_add(grid->low, vec3((at[0] + 0.5) * grid->size.x, (at[1] + 0.5) * grid->size.y,
                                           (at[2] + 0.5) * grid->size.z));
    double reach = fabs(plane.n.x) * s.x + fabs(plane.n.y) * s.y + fabs(plane.n.z) * s.z + BEYOND;
    return fabs(plane_distance(plane, middle)) <= reach;
}

// Counts the cells of each item into first[cell + 1]; or, with `items`, puts it there.
static void put_items(const SurfaceGrid *grid, int *first, int *items) {
    for (int i = 0; i < grid->surfaces->count; i++) {
        Box box = grid->surfaces->boxes[i];
        if (box_is_empty(box)) continue;
        int low[3], high[3], at[3];
        for (int a = 0; a < 3; a++) {
            low[a] = cell_along(grid, a, vec3_component(box.min, a) - BEYOND);
            high[a] = cell_along(grid, a, vec3_component(box.max, a) + BEYOND);
        }
        for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
            for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
                for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                    if (!touches(grid, i, at)) continue;
                    int cell = cell_index(grid, at);
                    if (items)
                        items[first[cell]++] = i;
                    else
                        first[cell + 1]++;
                }
    }
}

static void choose_cells(SurfaceGrid *grid, Box box) {
    box = box_grow(box, BEYOND);
    Vec3 extent = vec3_sub(box.max, box.min);
    double side = cbrt(extent.x * extent.y * extent.z / (CELLS_AN_ITEM * grid->surfaces->count));
    double size[3];
    for (int a = 0; a < 3; a++) {
        double count = fmin(fmax(round(vec3_component(extent, a) / side), 1), MOST_CELLS_AN_AXIS);
        grid->count[a] = (int)count;
        size[a] = vec3_component(extent, a) / count;
    }
    grid->low = box.min;
    grid->size = vec3(size[0], size[1], size[2]);
}

SurfaceGrid surface_grid_new(const RaySurfaces *surfaces, Arena *arena) {
    SurfaceGrid grid = {.surfaces = surfaces};
    if (box_is_empty(surfaces->box)) return grid;
    choose_cells(&grid, surfaces->box);
    int cells = grid.count[0] * grid.count[1] * grid.count[2];
    Arena scratch = {0};
    int *next = ARENA_ARRAY(&scratch, int, cells + 1);
    grid.first = ARENA_ARRAY(arena, int, cells + 1);
    put_items(&grid, grid.first, NULL);
    for (int c = 0; c < cells; c++) grid.first[c + 1] += grid.first[c];
    memcpy(next, grid.first, (size_t)cells * sizeof *next);
    grid.items = ARENA_ARRAY(arena, int, grid.first[cells] + 1);
    put_items(&grid, next, grid.items);
    arena_free(&scratch);
    return grid;
}

// ---- rays

typedef struct Walk {
    int at[3], step[3];
    double next[3], way[3];  // along the ray: to the end of the cell on each axis; from cell to cell
    double end;              // where it leaves the grid
} Walk;

// False: it does not come through the grid.
static bool enter(const SurfaceGrid *grid, const SurfaceRay *r, Walk *w) {
    double near = fmax(r->ray.near, 0);
    w->end = r->ray.far;
    for (int a = 0; a < 3; a++) {
        double o = vec3_component(r->origin, a), d = vec3_component(r->ray.direction, a),
               low = vec3_component(grid->low, a);
        double high = low + grid->count[a] * vec3_component(grid->size, a);
        if (d == 0 && (o < low || o > high)) return false;
        if (d == 0) continue;
        near = fmax(near, ((d > 0 ? low : high) - o) / d);
        w->end = fmin(w->end, ((d > 0 ? high : low) - o) / d);
    }
    if (!(near <= w->end)) return false;
    for (int a = 0; a < 3; a++) {
        double o = vec3_component(r->origin, a), d = vec3_component(r->ray.direction, a),
               size = vec3_component(grid->size, a);
        w->at[a] = cell_along(grid, a, o + near * d);
        w->step[a] = d > 0 ? 1 : -1;
        double border = vec3_component(grid->low, a) + (w->at[a] + (d > 0)) * size;
        w->next[a] = d == 0 ? INFINITY : (border - o) / d;
        w->way[a] = d == 0 ? INFINITY : size / fabs(d);
    }
    return true;
}

static inline int next_axis(const Walk *w) {
    if (w->next[0] < w->next[1]) return w->next[0] < w->next[2] ? 0 : 2;
    return w->next[1] < w->next[2] ? 1 : 2;
}

// To the cell behind the border on an axis; false: there is none.
static inline bool step(const SurfaceGrid *grid, Walk *w, int axis) {
    w->at[axis] += w->step[axis];
    w->next[axis] += w->way[axis];
    return w->at[axis] >= 0 && w->at[axis] < grid->count[axis];
}

SurfaceHit surface_grid_first(const SurfaceGrid *grid, const Ray *ray) {
    SurfaceRay r = surface_ray(grid->surfaces, ray);
    SurfaceHit best = surface_miss(ray);
    Walk w;
    if (!grid->first || !enter(grid, &r, &w)) return best;
    for (;;) {
        int cell = cell_index(grid, w.at), axis = next_axis(&w);
        for (int i = grid->first[cell]; i < grid->first[cell + 1]; i++)
            ray_surface_try(grid->surfaces, grid->items[i], &r, &best);
        double end = w.next[axis];
        if (best.at.t + RAY_SAME_PLACE < end || end > w.end || !step(grid, &w, axis)) return best;
    }
}

bool surface_grid_blocked(const SurfaceGrid *grid, const Ray *ray) {
    SurfaceRay r = surface_ray(grid->surfaces, ray);
    Walk w;
    if (!grid->first || !enter(grid, &r, &w)) return false;
    for (;;) {
        int cell = cell_index(grid, w.at), axis = next_axis(&w);
        for (int i = grid->first[cell]; i < grid->first[cell + 1]; i++)
            if (ray_surface_blocks(grid->surfaces, grid->items[i], &r)) return true;
        if (w.next[axis] > w.end || !step(grid, &w, axis)) return false;
    }
}
