// room_grid.c - EN 12464-1 (2021), the calculation grid, from what is published of it: spacing, strip and whole numbers of points. The
// standard speaks of rectangles; where a room is none, its longest wall tells the directions, and points beside the walls are left out.
#include "radiosity/planner/room_grid.h"

#include "engine/core/polygon.h"

static const double STRIP = 0.5, STRIP_SHARE = 0.15;  // metres; of the shorter side
static const double COARSEST = 10;                    // metres
// Points nearer to a wall than the strip by less than this are kept, metres: the corners of plans are rounded to the grid.
static const double SLACK = MAPS_GRID;

double room_grid_spacing(double d) { return fmin(0.2 * pow(5, log10(d)), COARSEST); }

static double distance_to_edge(Vec2 a, Vec2 b, Vec2 p) {
    Vec2 along = vec2_sub(b, a), off = vec2_sub(p, a);
    double t = fmin(fmax(vec2_dot(along, off) / vec2_dot(along, along), 0), 1);
    return vec2_length(vec2_sub(off, vec2_scale(along, t)));
}

// How far a point is from the walls, metres; below 0 outside the room.
static double distance_inside(const Building *b, const Region *region, Vec2 p) {
    double nearest = INFINITY;
    bool inside = false;
    for (int r = region->first_ring; r < region->first_ring + region->ring_count; r++) {
        const Vec2 *ring = b->points + b->rings[r].first_point;
        int count = b->rings[r].point_count;
        inside ^= ring_contains(ring, count, p);
        for (int i = 0; i < count; i++)
            nearest = fmin(nearest, distance_to_edge(ring[i], ring[(i + 1) % count], p));
    }
    return inside ? nearest : -nearest;
}

static Vec2 longest_wall(const Vec2 *ring, int count) {
    Vec2 best = {1, 0};
    double longest = 0;
    for (int i = 0; i < count; i++) {
        Vec2 edge = vec2_sub(ring[(i + 1) % count], ring[i]);
        // The first of equal walls tells, rounding or not.
        if (vec2_length(edge) <= longest + SLACK) continue;
        longest = vec2_length(edge);
        best = vec2_scale(edge, 1 / longest);
    }
    return best;
}

static void set_axes(const Vec2 *ring, int count, RoomGrid *grid) {
    Vec2 along = longest_wall(ring, count);
    // The axis nearest to the plan's x, so that a grid does not depend on which of two parallel walls is longer by a hair.
    if (fabs(along.x) < fabs(along.y)) along = vec2(along.y, -along.x);
    if (along.x < 0) along = vec2_scale(along, -1);
    grid->x = along;
    grid->y = vec2(-along.y, along.x);
}

static int at_least_one(double count) { return (int)fmax(nearbyint(count), 1); }

// The cells of an area of `size` metres.
static void set_cells(const double size[2], RoomGrid *grid) {
    int longer = size[1] > size[0], side = size[longer] >= 2 * size[!longer] ? !longer : longer;
    grid->count[side] = at_least_one(size[side] / room_grid_spacing(size[side]));
    grid->step[side] = size[side] / grid->count[side];
    grid->count[!side] = at_least_one(size[!side] / grid->step[side]);
    grid->step[!side] = size[!side] / grid->count[!side];
}

static Vec2 cell_place(const RoomGrid *grid, int i, int k) {
    return vec2_add(grid->origin, vec2_add(vec2_scale(grid->x, (i + 0.5) * grid->step[0]),
                                           vec2_scale(grid->y, (k + 0.5) * grid->step[1])));
}

// Those points that are so far from the walls; returns how many.
static int find_points(const Building *b, const Region *region, double border, RoomGrid *grid, Arena *arena) {
    int cells = grid->count[0] * grid->count[1];
    grid->point = ARENA_ARRAY(arena, int, cells + 1);
    grid->points = ARENA_ARRAY(arena, Vec2, cells + 1);
    grid->point_count = 0;
    for (int c = 0; c < cells; c++) {
        Vec2 p = cell_place(grid, c % grid->count[0], c / grid->count[0]);
        bool good = distance_inside(b, region, p) > border - SLACK;
        grid->point[c] = good ? grid->point_count : -1;
        if (good) grid->points[grid->point_count++] = p;
    }
    return grid->point_count;
}

// Where no point of a grid is in the room, the point of it that is farthest from the walls.
static void take_innermost(const Building *b, const Region *region, const double low[2], const double size[2],
                           RoomGrid *grid) {
    enum { STEPS = 32 };
    RoomGrid fine = *grid;
    double best = -INFINITY;
    for (int k = 0; k < 2; k++) fine.step[k] = size[k] / STEPS;
    fine.origin = vec2_add(vec2_scale(grid->x, low[0]), vec2_scale(grid->y, low[1]));
    for (int c = 0; c < STEPS * STEPS; c++) {
        Vec2 p = cell_place(&fine, c % STEPS, c / STEPS);
        double inside = distance_inside(b, region, p);
        if (inside <= best) continue;
        best = inside;
        grid->points[0] = p;
    }
    grid->count[0] = grid->count[1] = grid->point_count = 1;
    grid->point[0] = 0;
    for (int k = 0; k < 2; k++) grid->step[k] = size[k];
    grid->origin = vec2_sub(grid->points[0],
                            vec2_add(vec2_scale(grid->x, size[0] / 2), vec2_scale(grid->y, size[1] / 2)));
}

RoomGrid room_grid(const Building *b, const Region *region, Arena *arena) {
    const Ring *outer = &b->rings[region->first_ring];
    const Vec2 *ring = b->points + outer->first_point;
    RoomGrid grid = {.border = 0};
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, size[2];
    set_axes(ring, outer->point_count, &grid);
    for (int i = 0; i < outer->point_count; i++) {
        double at[2] = {vec2_dot(grid.x, ring[i]), vec2_dot(grid.y, ring[i])};
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
    double border = fmin(STRIP, STRIP_SHARE * fmin(high[0] - low[0], high[1] - low[1]));
    for (int pass = 0; pass < 2; pass++) {
        grid.border = pass == 0 ? border : 0;
        for (int k = 0; k < 2; k++) size[k] = high[k] - low[k] - 2 * grid.border;
        grid.origin =
            vec2_add(vec2_scale(grid.x, low[0] + grid.border), vec2_scale(grid.y, low[1] + grid.border));
        set_cells(size, &grid);
        if (find_points(b, region, grid.border, &grid, arena) > 0) return grid;
    }
    take_innermost(b, region, low, size, &grid);
    return grid;
}
