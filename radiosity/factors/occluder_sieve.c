// occluder_sieve.c - grids over x and y of unit directions, each twice as fine as the one before. A polygon lies in a cone about the mean
// direction of its corners; unit directions of the cone are no farther apart than the chord of its half angle, so the square about the mean
// direction holds them. An occluder is listed in the finest grid in which its square meets two cells each way at most, so in four cells.
#include "radiosity/factors/occluder_sieve.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "engine/core/error.h"

// The finest grid has 32 cells each way.
enum { GRIDS = 6, FINEST = 1 << (GRIDS - 1), MOST_CELLS = 4 };
// Directions may be off by this, by rounding.
static const double ROUNDING = 1e-9;
// A cone that is wider than this, as the cosine of its half angle, may be anywhere: a cone of a right angle does not hold all between its
// corners any more.
static const double WIDEST = 0.1;

typedef struct Square {
    double x0, x1, y0, y1;
} Square;

typedef struct Cells {
    int x0, x1, y0, y1;
} Cells;

typedef struct Entry {
    int occluder, next;  // next of the cell, -1: none
} Entry;

struct OccluderSieve {
    int count, most;
    int first[GRIDS][FINEST][FINEST];  // -1: none
    Entry *entries;                    // [MOST_CELLS * most]
    int entry_count;
    uint64_t *marked;  // [most / 64 + 1] all 0 between calls
    int *found;        // [most]
};

OccluderSieve *occluder_sieve_new(int most, Arena *arena) {
    OccluderSieve *s = ARENA_ARRAY(arena, OccluderSieve, 1);
    s->most = most;
    s->entries = arena_alloc(arena, (size_t)most + 1, MOST_CELLS * sizeof *s->entries);
    s->marked = ARENA_ARRAY(arena, uint64_t, most / 64 + 1);
    s->found = ARENA_ARRAY(arena, int, most + 1);
    occluder_sieve_clear(s);
    return s;
}

void occluder_sieve_clear(OccluderSieve *s) {
    s->count = s->entry_count = 0;
    memset(s->first, -1, sizeof s->first);
}

static int cell_at(double x, int grid) {
    int side = 1 << grid, cell = (int)floor((x + 1) / 2 * side);
    return cell < 0 ? 0 : cell >= side ? side - 1 : cell;
}

static Cells cells_of(Square s, int grid) {
    return (Cells){cell_at(s.x0, grid), cell_at(s.x1, grid), cell_at(s.y0, grid), cell_at(s.y1, grid)};
}

static Square square_around(const Vec3 *polygon, int count) {
    static const Square ALL = {-1, 1, -1, 1};
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        double length = vec3_length(polygon[i]);
        if (!(length > 0)) return ALL;
        sum = vec3_add(sum, vec3_scale(polygon[i], 1 / length));
    }
    double cosine = 1, length = vec3_length(sum);
    if (!(length > 0)) return ALL;
    Vec3 mean = vec3_scale(sum, 1 / length);
    for (int i = 0; i < count; i++)
        cosine = fmin(cosine, vec3_dot(mean, polygon[i]) / vec3_length(polygon[i]));
    if (cosine < WIDEST) return ALL;
    double chord = sqrt(fmax(0, 2 - 2 * cosine)) + ROUNDING;
    return (Square){mean.x - chord, mean.x + chord, mean.y - chord, mean.y + chord};
}

void occluder_sieve_add(OccluderSieve *s, const Vec3 *polygon, int count) {
    CORE_ASSERT(s->count < s->most);
    Square square = square_around(polygon, count);
    int grid = GRIDS - 1;
    Cells c = cells_of(square, grid);
    while (c.x1 > c.x0 + 1 || c.y1 > c.y0 + 1) c = cells_of(square, --grid);
    for (int y = c.y0; y <= c.y1; y++) {
        for (int x = c.x0; x <= c.x1; x++) {
            s->entries[s->entry_count] = (Entry){s->count, s->first[grid][y][x]};
            s->first[grid][y][x] = s->entry_count++;
        }
    }
    s->count++;
}

const int *occluder_sieve_ask(OccluderSieve *s, const Vec3 *polygon, int count, int *found) {
    Square square = square_around(polygon, count);
    *found = 0;
    for (int grid = 0; grid < GRIDS; grid++) {
        Cells c = cells_of(square, grid);
        for (int y = c.y0; y <= c.y1; y++)
            for (int x = c.x0; x <= c.x1; x++)
                for (int e = s->first[grid][y][x]; e >= 0; e = s->entries[e].next)
                    s->marked[s->entries[e].occluder / 64] |= (uint64_t)1 << s->entries[e].occluder % 64;
    }
    for (int w = 0; w <= s->count / 64; w++) {
        for (uint64_t left = s->marked[w]; left; left &= left - 1)
            s->found[(*found)++] = 64 * w + __builtin_ctzll(left);
        s->marked[w] = 0;
    }
    return s->found;
}
