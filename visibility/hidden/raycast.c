// raycast.c - a ray through each pixel's centre, over a bounding-volume hierarchy, 8 x 8 rays together: what none of them can
// meet is told by the four planes around them (I. Wald et al., Interactive rendering with coherent ray tracing, 2001;
// A. Reshetov et al., Multi-level ray tracing algorithm, 2005).
//
// All rays come from one eye: a polygon is met where each of its edges, a line in the picture, says so (image.h).
#include "visibility/hidden/depth.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/ray_shapes.h"
#include "visibility/hidden/ray_tree.h"

enum { TILE = 8, TILE_FOURS = TILE * TILE / FOUR };

// A share of the terms of a plane's equation, above its rounding: what is within counts as inside.
#define PLANE_ROUNDING 1e-14

typedef struct RayCast {
    Facets facets;
    RayTree tree;
    RayShapes shapes;
    HiddenWork *work;
    size_t memory;
} RayCast;

// The rays under way: of pixels x0 .. x1, y0 .. y1 of the picture, row by row of TILE.
typedef struct Tile {
    int x0, y0, x1, y1;
    Four x, y, z;  // normals of the planes around the rays, inwards
    Vec3 forward;
    double least;              // of `inverse`
    Four inverse[TILE_FOURS];  // 1/z of what is met so far, 0: nothing
    int32_t facet[TILE * TILE];
} Tile;

static void *raycast_begin(const Scene *scene, Arena *arena, Error *error) {
    RayCast *r = ARENA_ARRAY(arena, RayCast, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &r->facets, error)) return NULL;
    r->tree = ray_tree_new(&r->facets, arena);
    r->shapes = ray_shapes_new(&r->facets, arena);
    r->memory = arena->used - before;
    return r;
}

// ---- a polygon

// Edges that some of the tile's rays are outside of; -1: one that all are outside of.
static int open_edges(const Tile *tile, const Line *lines, int count, const Line **open) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        bool right = lines[i][0] > 0, down = lines[i][1] > 0;
        if (line_at(&lines[i], right ? tile->x1 : tile->x0, down ? tile->y1 : tile->y0) < 0) return -1;
        if (line_at(&lines[i], right ? tile->x0 : tile->x1, down ? tile->y0 : tile->y1) < 0)
            open[kept++] = &lines[i];
    }
    return kept;
}

// Where depths are so close that the list decides: lane by lane.
static FourMask settle_close_depths(const RayCast *r, const Tile *tile, int facet, int k, Four new,
                                    FourMask close) {
    const Facet *facets = r->facets.facets;
    FourMask nearer = {0};
    for (int i = 0; i < FOUR; i++) {
        int old = tile->facet[FOUR * k + i];
        if (!close[i] || old < 0) continue;
        nearer[i] =
            -(int64_t)depth_nearer(new[i], facets[facet].order, tile->inverse[k][i], facets[old].order);
    }
    return nearer;
}

static void meet_four(const RayCast *r, Tile *tile, int facet, int k, Four new, FourMask inside) {
    Four old = tile->inverse[k];
    FourMask nearer = inside & (new > old *(1 + DEPTH_TIE));
    FourMask close = inside & ~nearer & (new >= old *(1 - DEPTH_TIE));
    if (four_lanes(close)) nearer |= settle_close_depths(r, tile, facet, k, new, close);
    unsigned lanes = four_lanes(nearer);
    if (!lanes) return;
    tile->inverse[k] = four_choose(nearer, new, old);
    for (; lanes; lanes &= lanes - 1) tile->facet[FOUR * k + __builtin_ctz(lanes)] = facet;
}

static void meet_tile(RayCast *r, Tile *tile, int facet) {
    const Shape *shape = ray_shape(&r->shapes, facet, r->work);
    if (!shape || shape->nearest < tile->least || shape->x0 > tile->x1 || shape->x1 < tile->x0 ||
        shape->y0 > tile->y1 || shape->y1 < tile->y0)
        return;
    const Line *open[FACET_CORNERS];
    int count = open_edges(tile, r->shapes.picture.lines + shape->first_line, shape->line_count, open);
    if (count < 0) return;
    Line depth = r->shapes.picture.depth[facet];
    int y0 = shape->y0 > tile->y0 ? shape->y0 : tile->y0, y1 = shape->y1 < tile->y1 ? shape->y1 : tile->y1;
    for (int y = y0; y <= y1; y++) {
        for (int part = 0; part < TILE / FOUR; part++) {
            Four x = (Four){0, 1, 2, 3} + (double)(tile->x0 + FOUR * part);
            FourMask inside = x <= tile->x1;
            for (int i = 0; i < count; i++) {
                Line e = *open[i];
                inside &= e[0] * x + (e[1] * y + e[2]) >= 0;
            }
            if (!four_lanes(inside)) continue;
            meet_four(r, tile, facet, (y - tile->y0) * TILE / FOUR + part,
                      depth[0] * x + (depth[1] * y + depth[2]), inside);
        }
    }
    r->work->depth_tests += (y1 - y0 + 1) * (tile->x1 - tile->x0 + 1);
    Four least = tile->inverse[0];
    int used = (tile->y1 - tile->y0 + 1) * TILE / FOUR;
    for (int k = 1; k < used; k++) least = four_least(least, tile->inverse[k]);
    tile->least = fmin(fmin(least[0], least[1]), fmin(least[2], least[3]));
}

// ---- the tree

// How far along the view a box begins, or INFINITY where no ray of the tile can meet it.
static inline double box_depth(const Tile *tile, Vec3 eye, const Box *box) {
    Vec3 centre = vec3_scale(vec3_add(box->min, box->max), 0.5);
    Vec3 half = vec3_sub(box->max, centre), c = vec3_sub(centre, eye);
    Four at = tile->x * c.x + tile->y * c.y + tile->z * c.z;
    Four reach = four_abs(tile->x) * half.x + four_abs(tile->y) * half.y + four_abs(tile->z) * half.z;
    Four scale = four_abs(tile->x * c.x) + four_abs(tile->y * c.y) + four_abs(tile->z * c.z);
    if (four_lanes(at + reach + PLANE_ROUNDING * scale < 0)) return INFINITY;
    Vec3 f = tile->forward;
    double deep = fabs(f.x) * half.x + fabs(f.y) * half.y + fabs(f.z) * half.z, middle = vec3_dot(f, c);
    return middle + deep < 0 ? INFINITY : middle - deep;
}

static bool is_hidden(const Tile *tile, double depth) {
    return depth == INFINITY || tile->least * depth * (1 - DEPTH_TIE) > 1;
}

static void cast_tile(RayCast *r, Tile *tile) {
    struct {
        int node;
        double depth;
    } stack[TREE_STACK];
    Vec3 eye = r->shapes.picture.image.eye;
    int held = 0;
    if (r->tree.node_count > 0) {
        stack[held].node = 0;
        stack[held++].depth = box_depth(tile, eye, &r->tree.nodes[0].box);
    }
    while (held > 0) {
        held--;
        if (is_hidden(tile, stack[held].depth)) continue;
        const TreeNode *node = &r->tree.nodes[stack[held].node];
        r->work->nodes++;
        for (int i = 0; i < node->count; i++) meet_tile(r, tile, r->tree.facet[node->first + i]);
        if (node->count > 0) continue;
        double depth[2];
        for (int c = 0; c < 2; c++) depth[c] = box_depth(tile, eye, &r->tree.nodes[node->first + c].box);
        int near = depth[1] < depth[0];
        for (int k = 0; k < 2; k++) {
            int c = k == 0 ? !near : near;
            if (is_hidden(tile, depth[c])) continue;
            CORE_ASSERT(held < TREE_STACK);
            stack[held].node = node->first + c;
            stack[held++].depth = depth[c];
        }
    }
}

// The planes through the eye and the outer rays of the tile: a point (X, Y, Z) of image.h is within where X >= x0 Z, and so on.
static void frame_tile(const RayCast *r, Tile *tile) {
    const Four *c = r->shapes.picture.image.column;
    Four from = {-tile->x0, tile->x1, -tile->y0, tile->y1}, sign = {1, -1, 1, -1};
    for (int axis = 0; axis < 3; axis++) {
        Four xy = {c[axis][0], c[axis][0], c[axis][1], c[axis][1]};
        Four n = sign * xy + from * c[axis][2];
        *(axis == 0 ? &tile->x : axis == 1 ? &tile->y : &tile->z) = n;
    }
    tile->forward = vec3(c[0][2], c[1][2], c[2][2]);
    memset(tile->inverse, 0, sizeof tile->inverse);
    memset(tile->facet, -1, sizeof tile->facet);
    tile->least = 0;
    // Rays beyond the picture's edge count as having met what is nearest.
    for (int i = 0; i < TILE * TILE; i++)
        if (i % TILE > tile->x1 - tile->x0) tile->inverse[i / FOUR][i % FOUR] = INFINITY;
}

static bool raycast_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                         Error *error) {
    (void)error;
    RayCast *r = prepared;
    r->work = work;
    ray_shapes_look(&r->shapes, camera);
    int width = out->width, height = out->height;
    for (int y = 0; y < height; y += TILE) {
        for (int x = 0; x < width; x += TILE) {
            Tile tile = {.x0 = x, .y0 = y};
            tile.x1 = (x + TILE < width ? x + TILE : width) - 1;
            tile.y1 = (y + TILE < height ? y + TILE : height) - 1;
            frame_tile(r, &tile);
            cast_tile(r, &tile);
            size_t bytes = (size_t)(tile.x1 - x + 1) * sizeof *out->item;
            for (int j = y; j <= tile.y1; j++)
                memcpy(out->item + (size_t)j * (size_t)width + x, tile.facet + (j - y) * TILE, bytes);
        }
    }
    work->rays = (int64_t)width * height;
    work->pixels = work->rays;
    work->memory = r->memory;
    picture_resolve(&r->shapes.picture, out);
    return true;
}

const HiddenMethod HIDDEN_RAYCAST = {.name = "raycast",
                                     .summary = "rays in eights by eights over a hierarchy of boxes",
                                     .begin = raycast_begin,
                                     .draw = raycast_draw};
