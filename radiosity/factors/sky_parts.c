// sky_parts.c - directions are sorted into the squares of a map of the sky; what a square has lies at the middle of its directions. So the
// light of a sky whose radiance is linear across a square is exact. About the sun, where radiance falls by a twentieth a degree, a square
// of four degrees is .2 % off.
#include "radiosity/factors/sky_parts.h"

#include <math.h>

// Above this share of a view four squares are one part.
static const double LARGE = 0.1;
// Below this height a part's middle is taken as this high: z is not stored, and horizons lie at 0.
static const double LOWEST = 1e-6;

typedef struct Cell {
    double share;
    Vec3 sum;
} Cell;

struct SkyCollector {
    Cell cell[SKY_PARTS_MOST];
    int touched[SKY_PARTS_MOST], count;
    double share;
};

static int along(double at) {
    int i = (int)((at + 1) * (SKY_PARTS_ACROSS / 2.0));
    return i < 0 ? 0 : i < SKY_PARTS_ACROSS ? i : SKY_PARTS_ACROSS - 1;
}

int sky_part_cell(Vec3 w) {
    double scale = 1 / (fabs(w.x) + fabs(w.y) + fmax(w.z, 0));
    return along((w.x - w.y) * scale) * SKY_PARTS_ACROSS + along((w.x + w.y) * scale);
}

SkyPart sky_part_of(double share, Vec3 sum) {
    double length = vec3_length(sum), scale = length > 0 ? SKY_PART_ONE / length : 0;
    return (SkyPart){(float)share, (int16_t)lrint(sum.x * scale), (int16_t)lrint(sum.y * scale)};
}

double sky_part_relative(const SkyPart *part, const Daylight *day) {
    double x = part->x / (double)SKY_PART_ONE, y = part->y / (double)SKY_PART_ONE;
    double z2 = fmax(1 - x * x - y * y, LOWEST * LOWEST);
    return daylight_relative(day, vec3(x, y, sqrt(z2)));
}

double sky_parts_light(const SkyPart *parts, int count, const Daylight *day) {
    double sum = 0;
    for (int i = 0; i < count; i++) sum += (double)parts[i].share * sky_part_relative(&parts[i], day);
    return sum;
}

void sky_parts_fit(SkyPart *parts, int count, const Daylight *day, double light) {
    double has = sky_parts_light(parts, count, day);
    float scale = (float)(has > 0 ? light / has : 0);
    for (int i = 0; i < count; i++) parts[i].share *= scale;
}

SkyCollector *sky_collector_new(Arena *arena) { return ARENA_ARRAY(arena, SkyCollector, 1); }

void sky_collector_add(SkyCollector *c, double share, Vec3 direction) {
    int at = sky_part_cell(direction);
    Cell *cell = &c->cell[at];
    if (cell->share == 0) c->touched[c->count++] = at;
    cell->share += share;
    cell->sum = vec3_add(cell->sum, vec3_scale(direction, share));
    c->share += share;
}

// Joins four squares to one, which is the first of them that was touched.
static void join_squares(SkyCollector *c) {
    int first[SKY_PARTS_MOST / 4], left = 0;
    for (int i = 0; i < SKY_PARTS_MOST / 4; i++) first[i] = -1;
    for (int i = 0; i < c->count; i++) {
        int at = c->touched[i], row = at / SKY_PARTS_ACROSS / 2, column = at % SKY_PARTS_ACROSS / 2;
        int *of = &first[row * (SKY_PARTS_ACROSS / 2) + column];
        if (*of < 0) {
            *of = at;
            c->touched[left++] = at;
            continue;
        }
        c->cell[*of].share += c->cell[at].share;
        c->cell[*of].sum = vec3_add(c->cell[*of].sum, c->cell[at].sum);
        c->cell[at] = (Cell){0};
    }
    c->count = left;
}

int sky_collector_take(SkyCollector *c, SkyPart *out) {
    if (c->share > LARGE) join_squares(c);
    int count = c->count;
    for (int i = 0; i < count; i++) {
        Cell *cell = &c->cell[c->touched[i]];
        out[i] = sky_part_of(cell->share, cell->sum);
        *cell = (Cell){0};
    }
    c->count = 0;
    c->share = 0;
    return count;
}
