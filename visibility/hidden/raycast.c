// raycast.c - a ray through each pixel's centre, over a bounding-volume hierarchy, 8 x 8 rays together: what none of them can
// meet is told by the four planes around them (I. Wald et al., Interactive rendering with coherent ray tracing, 2001;
// A. Reshetov et al., Multi-level ray tracing algorithm, 2005).
//
// All rays come from one eye: a polygon is met where each of its edges, a line in the picture, says so (image.h).
#include "visibility/hidden/depth.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/image.h"
#include "visibility/hidden/ray_tree.h"

typedef struct RayShapes {
    Picture picture;
    int *taken;  // [facet count] in which look it was set up
    bool *seen;  // [facet count] can it be seen at all?
    int look;
} RayShapes;

static inline RayShapes ray_shapes_new(const Facets *facets, Arena *arena) {
    return (RayShapes){.picture = picture_new(facets, arena),
                       .taken = ARENA_ARRAY(arena, int, facets->count + 1),
                       .seen = ARENA_ARRAY(arena, bool, facets->count + 1)};
}

static inline void ray_shapes_look(RayShapes *shapes, const Camera *camera) {
    shapes->picture.image = image_new(camera);
    shapes->look++;
}

// NULL: it cannot be seen.
static inline const Shape *ray_shape(RayShapes *shapes, int facet, HiddenWork *work) {
    Picture *p = &shapes->picture;
    if (shapes->taken[facet] != shapes->look) {
        int first = p->facets->facets[facet].first;
        shapes->taken[facet] = shapes->look;
        shapes->seen[facet] =
            image_shape(&p->image, p->facets, facet, p->lines + first, &p->depth[facet], &p->shapes[facet]);
        p->shapes[facet].first_line = first;
        work->polygons += shapes->seen[facet];
    }
    return shapes->seen[facet] ? &p->shapes[facet] : NULL;
}

enum { TILE = 8, TILE_FOURS = TILE * TILE / FOUR };

// A share of the terms of a plane's equation, above its rounding: points within count as inside.
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
    Four inverse[TILE_FOURS];  // 1/z of the polygon met so far, 0: none
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
    // Rays beyond the picture's edge count as having met the nearest polygon.
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

// ---- a ray through each pixel's centre, one by one through the cells of a uniform grid (J. Amanatides & A. Woo,
// A fast voxel traversal algorithm for ray tracing, 1987), each polygon tried once a ray (mailboxes).

// Cells for each polygon, about: fewer make long lists, more are crossed empty.
static const double CELLS_A_FACET = 4;
enum { MOST_CELLS = 256 };  // along an axis
// Polygons are entered in all cells within this of their box, metres beside the rounding of coordinates: rays step from cell
// to cell with rounding.
#define GRID_PADDING 1e-6

typedef struct Grid {
    Vec3 low, size;  // of a cell, metres
    int count[3];
    int *first;  // [cells + 1] in `facet`
    int *facet;
} Grid;

typedef struct GridCast {
    Facets facets;
    Grid grid;
    RayShapes shapes;
    int64_t *mail;  // [facet count] the last ray that tried it
    int64_t ray;
    HiddenWork *work;
    size_t memory;
} GridCast;

static size_t cell_at(const Grid *g, const int at[3]) {
    return ((size_t)at[2] * (size_t)g->count[1] + (size_t)at[1]) * (size_t)g->count[0] + (size_t)at[0];
}

static Box facet_box(const Facets *facets, int index) {
    const Facet *facet = &facets->facets[index];
    Box box = box_empty();
    for (int i = 0; i < facet->count; i++) box = box_add(box, facets->corners[facet->first + i]);
    return box_grow(box, GRID_PADDING + facets->rounding);
}

static void lay_out(Grid *g, const Facets *facets) {
    Box all = box_empty();
    for (int i = 0; i < facets->count; i++) all = box_union(all, facet_box(facets, i));
    if (facets->count == 0) all = (Box){{0, 0, 0}, {1, 1, 1}};
    Vec3 size = vec3_sub(all.max, all.min);
    double cube = cbrt(size.x * size.y * size.z / (CELLS_A_FACET * facets->count + 1));
    double step[3];
    for (int axis = 0; axis < 3; axis++) {
        double cells = ceil(vec3_component(size, axis) / cube);
        g->count[axis] = cells >= 1 ? cells < MOST_CELLS ? (int)cells : MOST_CELLS : 1;
        step[axis] = vec3_component(size, axis) / g->count[axis];
    }
    g->low = all.min;
    g->size = vec3(step[0], step[1], step[2]);
}

static int cell_along(const Grid *g, int axis, double at) {
    int cell = (int)floor(
        fmin(fmax((at - vec3_component(g->low, axis)) / vec3_component(g->size, axis), 0), MOST_CELLS));
    return cell < g->count[axis] ? cell : g->count[axis] - 1;
}

// Does the facet's plane pass through the cell, widened by the padding?
static bool plane_meets(const Grid *g, const Facet *facet, const int at[3], double padding) {
    Vec3 centre = vec3(g->low.x + (at[0] + 0.5) * g->size.x, g->low.y + (at[1] + 0.5) * g->size.y,
                       g->low.z + (at[2] + 0.5) * g->size.z);
    Vec3 n = facet->n;
    double reach = fabs(n.x) * (g->size.x / 2 + padding) + fabs(n.y) * (g->size.y / 2 + padding) +
                   fabs(n.z) * (g->size.z / 2 + padding);
    return fabs(vec3_dot(n, vec3_sub(centre, facet->centre))) <= reach;
}

// Counts the facets of each cell in first[cell + 1]; with `facet`, enters them instead.
static void enter_all(Grid *g, const Facets *facets) {
    for (int i = 0; i < facets->count; i++) {
        Box box = facet_box(facets, i);
        int low[3], high[3], at[3];
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = cell_along(g, axis, vec3_component(box.min, axis));
            high[axis] = cell_along(g, axis, vec3_component(box.max, axis));
        }
        for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
            for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
                for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                    if (!plane_meets(g, &facets->facets[i], at, GRID_PADDING + facets->rounding)) continue;
                    int *place = &g->first[cell_at(g, at) + 1];
                    if (g->facet) g->facet[*place] = i;
                    ++*place;
                }
    }
}

static void build_grid(Grid *g, const Facets *facets, Arena *arena) {
    lay_out(g, facets);
    size_t cells = (size_t)g->count[0] * (size_t)g->count[1] * (size_t)g->count[2];
    g->first = ARENA_ARRAY(arena, int, cells + 2);
    enter_all(g, facets);
    // Counts become places, one cell further on, so that entering moves them to where they belong.
    int total = 0;
    for (size_t c = 0; c <= cells; c++) {
        int count = g->first[c + 1];
        g->first[c + 1] = total;
        total += count;
    }
    g->facet = ARENA_ARRAY(arena, int, total + 1);
    enter_all(g, facets);
}

static void *grid_begin(const Scene *scene, Arena *arena, Error *error) {
    GridCast *c = ARENA_ARRAY(arena, GridCast, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &c->facets, error)) return NULL;
    build_grid(&c->grid, &c->facets, arena);
    c->shapes = ray_shapes_new(&c->facets, arena);
    c->mail = ARENA_ARRAY(arena, int64_t, c->facets.count + 1);
    c->memory = arena->used - before;
    return c;
}

// The nearest hit of a ray so far.
typedef struct Hit {
    double inverse;  // 1/z, 0: nothing
    int facet;
} Hit;

static void try_facet(GridCast *c, int facet, int x, int y, Hit *hit) {
    if (c->mail[facet] == c->ray) return;
    c->mail[facet] = c->ray;
    const Shape *shape = ray_shape(&c->shapes, facet, c->work);
    if (!shape || x < shape->x0 || x > shape->x1 || y < shape->y0 || y > shape->y1) return;
    c->work->depth_tests++;
    const Line *lines = c->shapes.picture.lines + shape->first_line;
    for (int i = 0; i < shape->line_count; i++)
        if (line_at(&lines[i], x, y) < 0) return;
    double inverse = line_at(&c->shapes.picture.depth[facet], x, y);
    const Facet *facets = c->facets.facets;
    if (hit->facet < 0 || depth_nearer(inverse, facets[facet].order, hit->inverse, facets[hit->facet].order))
        *hit = (Hit){inverse, facet};
}

// A ray on its way: the cell it is in, and the z at which it comes to the next one along each axis.
typedef struct Walk {
    int at[3], step[3];
    double next[3], stride[3];
} Walk;

// Where the ray enters the grid; false: nowhere.
static bool enter_grid(const Grid *g, Vec3 eye, Vec3 ray, Walk *w) {
    double in = 0, out = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        double low = vec3_component(g->low, axis) - vec3_component(eye, axis), d = vec3_component(ray, axis);
        double high = low + vec3_component(g->size, axis) * g->count[axis];
        if (d == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        in = fmax(in, fmin(low / d, high / d));
        out = fmin(out, fmax(low / d, high / d));
    }
    if (!(in <= out)) return false;
    for (int axis = 0; axis < 3; axis++) {
        double d = vec3_component(ray, axis), low = vec3_component(g->low, axis),
               size = vec3_component(g->size, axis);
        w->at[axis] = cell_along(g, axis, vec3_component(eye, axis) + in * d);
        w->step[axis] = d > 0 ? 1 : -1;
        w->stride[axis] = d == 0 ? INFINITY : size / fabs(d);
        w->next[axis] =
            d == 0 ? INFINITY : (low + (w->at[axis] + (d > 0)) * size - vec3_component(eye, axis)) / d;
    }
    return true;
}

static int cast(GridCast *c, Vec3 ray, int x, int y) {
    const Grid *g = &c->grid;
    Hit hit = {0, -1};
    Walk w;
    c->ray++;
    if (!enter_grid(g, c->shapes.picture.image.eye, ray, &w)) return -1;
    for (;;) {
        size_t cell = cell_at(g, w.at);
        c->work->nodes++;
        for (int i = g->first[cell]; i < g->first[cell + 1]; i++) try_facet(c, g->facet[i], x, y, &hit);
        int axis = w.next[0] < w.next[1] ? (w.next[0] < w.next[2] ? 0 : 2) : w.next[1] < w.next[2] ? 1 : 2;
        // The cells farther on are farther away, by more than could be a tie.
        if (hit.facet >= 0 && hit.inverse * w.next[axis] > 1 + 2 * DEPTH_TIE) break;
        w.at[axis] += w.step[axis];
        if (w.at[axis] < 0 || w.at[axis] >= g->count[axis]) break;
        w.next[axis] += w.stride[axis];
    }
    return hit.facet;
}

static bool grid_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work, Error *error) {
    (void)error;
    GridCast *c = prepared;
    c->work = work;
    ray_shapes_look(&c->shapes, camera);
    for (int y = 0; y < out->height; y++) {
        int32_t *item = out->item + (size_t)y * (size_t)out->width;
        for (int x = 0; x < out->width; x++) item[x] = cast(c, camera_ray(camera, x + 0.5, y + 0.5), x, y);
    }
    work->rays = (int64_t)out->width * out->height;
    work->pixels = work->rays;
    work->memory = c->memory;
    picture_resolve(&c->shapes.picture, out);
    return true;
}

const HiddenMethod HIDDEN_RAYCAST_GRID = {.name = "raycast-grid",
                                          .summary = "one ray a pixel through a uniform grid",
                                          .begin = grid_begin,
                                          .draw = grid_draw};
