// raycast_grid.c - a ray through each pixel's centre, one by one through the cells of a uniform grid (J. Amanatides & A. Woo,
// A fast voxel traversal algorithm for ray tracing, 1987), each polygon tried once a ray (mailboxes).
#include "visibility/hidden/depth.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/ray_shapes.h"

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
