// ray_grid.c - rays go from cell to cell of a uniform grid, and try what is in each (Amanatides & Woo 1987, A Fast Voxel Traversal
// Algorithm; Fujimoto, Tanaka & Iwata 1986).
//
// A hit counts once the ray has come to where it is: what reaches into several cells is met beyond the present one, too. Departure:
// nothing remembers what was tried in the cell before (their mailboxes), so that threads share nothing.
#include "visibility/rays/ray_grid.h"

#include "engine/core/error.h"

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
