// occluder_sieve.c - a grid over x and y of unit directions. A polygon lies in a cone about the mean direction of its corners; unit
// directions of the cone are no farther apart than the chord of its half angle, so the square about the mean direction holds them.
#include "radiosity/factors/occluder_sieve.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

// Cells of the grid each way.
enum { SIDE = 32 };
// Directions may be off by this, by rounding.
static const double ROUNDING = 1e-9;
// A cone that is wider than this, as the cosine of its half angle, may be anywhere: a cone of a right angle does not hold all between its
// corners any more.
static const double WIDEST = 0.1;

typedef struct Rectangle {
    int x0, x1, y0, y1;
} Rectangle;

typedef struct Entry {
    int occluder, next;  // next of the cell, -1: none
} Entry;

struct OccluderSieve {
    Arena *arena;
    int count;
    int first[SIDE][SIDE];  // -1: none
    Entry *entries;
    int entry_count, entry_capacity;
    uint64_t *marked;  // [most / 64 + 1] all 0 between calls
    int *found;        // [most]
};

OccluderSieve *occluder_sieve_new(int most, Arena *arena) {
    OccluderSieve *s = ARENA_ARRAY(arena, OccluderSieve, 1);
    s->arena = arena;
    s->marked = ARENA_ARRAY(arena, uint64_t, most / 64 + 1);
    s->found = ARENA_ARRAY(arena, int, most + 1);
    occluder_sieve_clear(s);
    return s;
}

void occluder_sieve_clear(OccluderSieve *s) {
    s->count = s->entry_count = 0;
    memset(s->first, -1, sizeof s->first);
}

static int cell_at(double x) {
    int cell = (int)floor((x + 1) / 2 * SIDE);
    return cell < 0 ? 0 : cell >= SIDE ? SIDE - 1 : cell;
}

static Rectangle rectangle_of(const Vec3 *polygon, int count) {
    static const Rectangle ALL = {0, SIDE - 1, 0, SIDE - 1};
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
    return (Rectangle){cell_at(mean.x - chord), cell_at(mean.x + chord), cell_at(mean.y - chord),
                       cell_at(mean.y + chord)};
}

void occluder_sieve_add(OccluderSieve *s, const Vec3 *polygon, int count) {
    Rectangle r = rectangle_of(polygon, count);
    for (int y = r.y0; y <= r.y1; y++) {
        for (int x = r.x0; x <= r.x1; x++) {
            int at = s->entry_count;
            *ARENA_PUSH(s->arena, s->entries, s->entry_count, s->entry_capacity) =
                (Entry){s->count, s->first[y][x]};
            s->first[y][x] = at;
        }
    }
    s->count++;
}

const int *occluder_sieve_ask(OccluderSieve *s, const Vec3 *polygon, int count, int *found) {
    Rectangle r = rectangle_of(polygon, count);
    *found = 0;
    for (int y = r.y0; y <= r.y1; y++)
        for (int x = r.x0; x <= r.x1; x++)
            for (int e = s->first[y][x]; e >= 0; e = s->entries[e].next)
                s->marked[s->entries[e].occluder / 64] |= (uint64_t)1 << s->entries[e].occluder % 64;
    for (int w = 0; w <= s->count / 64; w++) {
        for (uint64_t left = s->marked[w]; left; left &= left - 1)
            s->found[(*found)++] = 64 * w + __builtin_ctzll(left);
        s->marked[w] = 0;
    }
    return s->found;
}
