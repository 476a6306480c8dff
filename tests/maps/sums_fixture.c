// sums_fixture.c - see the header.
#include "tests/maps/sums_fixture.h"

#include <criterion/criterion.h>
#include <math.h>

#include "maps/maps.h"
#include "tests/support/draft_fixture.h"
#include "tests/support/files/hostile.h"
#include "tests/support/sums.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

void sums_of_sum_polygons(SumFile *f, const Object *objects, int object_count, const Polygon *polygons,
                          int polygon_count, const Vec3 *vertices, int vertex_count) {
    Sum drawn = {0}, places = {0};
    for (int i = 0; i < object_count; i++) {
        const Object *o = &objects[i];
        int words[] = {(int)o->kind, o->first_polygon, o->polygon_count, o->opening, o->leaf, o->plug};
        sum_ints(&drawn, words, sizeof words / sizeof *words);
        const ObjectProxy none = {0}, *proxy = o->proxy ? o->proxy : &none;
        for (int k = 0; k < 4; k++) sum_add2(&drawn, proxy->corner[k]);
        sum_add2(&drawn, vec2(proxy->z0, proxy->z1));
    }
    for (int i = 0; i < polygon_count; i++) sum_ints(&drawn, &polygons[i].first_vertex, 3);
    for (int i = 0; i < vertex_count; i++) sum_add3(&places, vertices[i]);
    sums_sum(f, "drawn", drawn);
    sums_sum(f, "vertices", places);
}

void sums_of_read_building(const char *path, Arena *arena, Building *b) {
    Error error = {""};
    cr_assert(maps_read(path, arena, b, &error), "%s", error.text);
}

bool sums_of_read_hostile(const HostileKind *k, const char *folder, Arena *arena, Building *out) {
    Error error = {""};
    int few = k->count < 4000 ? 6 : k->count / 500;
    const char *path = arena_format(arena, "%s/%s%s", folder, k->name, k->suffix);
    cr_assert(hostile_write(k, few, 1, path));
    return maps_read(path, arena, out, &error);
}

// A low wall along an arc, of many corners.
static void draw_arc(Draft *d, Random *r, int storey) {
    enum { HALF = 70 };
    Vec2 p[2 * HALF], middle = vec2(random_between(r, 0, 10), random_between(r, 0, 8));
    int half = 40 + random_index(r, HALF - 40);
    for (int i = 0; i < half; i++) {
        double angle = 3.0 * i / half;
        p[i] = vec2_add(middle, vec2(2 * cos(angle), 2 * sin(angle)));
        p[2 * half - 1 - i] = vec2_add(middle, vec2(1.8 * cos(angle), 1.8 * sin(angle)));
    }
    draft_wall_shape(d, storey, p, 2 * half, 0.3, random_between(r, 0.3, 1.5));
}

// A row of rooms, closed by walls of their own or by drawn ones that leave gaps of centimetres at their corners, with doors,
// passages and windows between and outwards, some of them oddly high, low or deep.
static void draw_row(Draft *d, Random *r, int storey) {
    double x = random_between(r, 0, 2), y = random_between(r, -6, -4), wall = random_between(r, 0.05, 0.3);
    bool own = random_index(r, 2);
    for (int i = 0; i < 3; i++) {
        double width = random_between(r, 2, 4), z = d->b.storeys[storey].floor;
        draft_room(d, storey, x, y, x + width, y + 3);
        SketchRoom *room = &d->s.rooms[d->s.room_count - 1];
        if (own) room->wall = wall;
        if (random_index(r, 3) == 0) room->z0 = z + random_between(r, -0.4, 0.4);
        if (random_index(r, 4) == 0) room->z1 = z + random_between(r, 1.5, 3);
        double low = y - wall / 2, high = y + 3 + wall / 2, gap = random_between(r, -0.1, 0.1);
        if (!own) {
            draft_wall(d, storey, x - wall, low, x + width + wall - gap, low, wall, DRAFT_HEIGHT);
            draft_wall(d, storey, x + width, high, x - wall, high, wall, DRAFT_HEIGHT);
            draft_wall(d, storey, x + width + wall / 2, y - wall, x + width + wall / 2, y + 3 + wall - gap,
                       wall, DRAFT_HEIGHT);
            if (i == 0)
                draft_wall(d, storey, x - wall / 2, y + gap, x - wall / 2, y + 3 + wall, wall, DRAFT_HEIGHT);
        }
        SketchOpening *o = draft_opening(d, (OpeningKind)random_index(r, OPENING_KINDS), storey,
                                         x + width + wall / 2, y + random_between(r, 0, 3), M_PI / 2,
                                         random_between(r, 0.3, 1.2), random_between(r, 0, 0.3));
        o->sill += random_between(r, -0.3, 0.5);
        for (int side = 0; side < 2; side++)
            draft_opening(d, (OpeningKind)random_index(r, OPENING_KINDS), storey, x + width / 2,
                          side ? high : low, 0, random_between(r, 0.3, 2), wall);
        x += width + wall;
    }
}

// Materials, turns and swings at random, walls and rooms either way round.
static void dress(Draft *d, Random *r) {
    Sketch *s = &d->s;
    for (int i = 0; i < s->point_count; i++) s->edge_material[i] = random_index(r, 6) - 1;
    for (int i = 0; i < s->wall_count; i++) {
        Vec2 *p = s->points + s->walls[i].first_point;
        for (int k = 0, n = s->walls[i].point_count; i % 3 == 0 && k < n / 2; k++) {
            Vec2 other = p[n - 1 - k];
            p[n - 1 - k] = p[k];
            p[k] = other;
        }
    }
    for (int i = 0; i < s->room_count; i++) {
        s->rooms[i].wall_material = random_index(r, 6) - 1;
        s->rooms[i].floor_material = random_index(r, 4);
        s->rooms[i].ceiling_material = random_index(r, 4);
    }
    for (int i = 0; i < s->opening_count; i++) {
        SketchOpening *o = &s->openings[i];
        o->hinge = random_index(r, 3);
        o->swing = random_between(r, -2, 2);
        o->slide = random_index(r, 3) ? 0 : random_between(r, -1, 1);
        o->open = random_unit(r);
        o->glazed = random_index(r, 4) == 0;
        o->material = random_index(r, 6) - 1;
    }
}

bool sums_of_random_plan(int seed, Draft *d) {
    Random r = {(uint64_t)seed + 5000};
    int storeys = 1 + random_index(&r, 3);
    *d = draft_new(storeys);
    d->s.ground = random_index(&r, 3) ? 0 : random_between(&r, -1, 3);
    if (seed % 3 == 1) {
        d->turn = random_between(&r, 0, 6);
        d->shift = vec2(random_between(&r, -1000, 1000), random_between(&r, -1000, 1000));
    }
    for (int k = 0; k < storeys; k++) {
        if (seed % 2 || seed % 4 == 0) draw_row(d, &r, k);
        if (seed % 10 == 3) draw_arc(d, &r, k);
        if (seed % 4) draft_random_storey(d, &r, k, true);
    }
    if (seed % 2) dress(d, &r);
    Error error = {""};
    return maps_enclose(&d->s, &d->b, &d->arena, &error);
}
