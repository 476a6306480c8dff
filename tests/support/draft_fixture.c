// draft_fixture.c - plans drawn in memory, and their free space.
#include "tests/support/draft_fixture.h"

#include <criterion/criterion.h>

// ---- sketches

Draft draft_new(int storeys) {
    Draft d = {.turn = 0};
    for (int i = 0; i < 4; i++) {
        static const char *const names[4] = {"outer", "floor", "ceiling", "side"};
        building_add_material(
            &d.arena, &d.b,
            (Material){.name = names[i], .reflectance = {0.1f * (float)(i + 1), 0.5f, 0.5f}, .alpha = 1});
    }
    for (int i = 0; i < storeys; i++) {
        *ARENA_PUSH(&d.arena, d.b.storeys, d.b.storey_count, d.b.storey_capacity) =
            (Storey){"storey", i * (DRAFT_HEIGHT + 0.2), DRAFT_HEIGHT, 0.2};
    }
    return d;
}

static Vec2 placed(const Draft *d, double x, double y) {
    double c = cos(d->turn), s = sin(d->turn);
    return vec2(c * x - s * y + d->shift.x, s * x + c * y + d->shift.y);
}

int draft_points(Draft *d, const Vec2 *p, int count, bool in_plan) {
    int first = d->s.point_count;
    for (int i = 0; i < count; i++) {
        d->s.edge_material =
            arena_grow(&d->arena, d->s.edge_material, d->s.point_count, &d->s.edge_capacity, sizeof(int));
        d->s.edge_material[d->s.point_count] = 3;
        *ARENA_PUSH(&d->arena, d->s.points, d->s.point_count, d->s.point_capacity) =
            in_plan ? placed(d, p[i].x, p[i].y) : p[i];
    }
    return first;
}

void draft_wall_shape(Draft *d, int storey, const Vec2 *p, int count, double angle, double height) {
    double z = d->b.storeys[storey].floor;
    int first = draft_points(d, p, count, true);
    *ARENA_PUSH(&d->arena, d->s.walls, d->s.wall_count, d->s.wall_capacity) =
        (SketchWall){storey,
                     first,
                     count,
                     z,
                     z + height,
                     angle + d->turn,
                     arena_format(&d->arena, "wall-%d", d->s.wall_count),
                     0};
}

void draft_wall(Draft *d, int storey, double x0, double y0, double x1, double y1, double thickness,
                double height) {
    double angle = atan2(y1 - y0, x1 - x0);
    Vec2 n = vec2(-sin(angle) * thickness / 2, cos(angle) * thickness / 2);
    Vec2 p[4] = {{x0 - n.x, y0 - n.y}, {x1 - n.x, y1 - n.y}, {x1 + n.x, y1 + n.y}, {x0 + n.x, y0 + n.y}};
    draft_wall_shape(d, storey, p, 4, angle, height);
}

void draft_box_walls(Draft *d, int storey, double x0, double y0, double x1, double y1) {
    double h = DRAFT_WALL / 2;
    draft_wall(d, storey, x0 - DRAFT_WALL, y0 - h, x1 + DRAFT_WALL, y0 - h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(d, storey, x0 - DRAFT_WALL, y1 + h, x1 + DRAFT_WALL, y1 + h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(d, storey, x0 - h, y0 - DRAFT_WALL, x0 - h, y1 + DRAFT_WALL, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(d, storey, x1 + h, y0 - DRAFT_WALL, x1 + h, y1 + DRAFT_WALL, DRAFT_WALL, DRAFT_HEIGHT);
}

void draft_room_shape(Draft *d, int storey, const Vec2 *p, int count) {
    int first = draft_points(d, p, count, true), n = d->s.room_count;
    *ARENA_PUSH(&d->arena, d->s.rooms, d->s.room_count, d->s.room_capacity) =
        (SketchRoom){storey,
                     first,
                     count,
                     arena_format(&d->arena, "Room %d", n),
                     arena_format(&d->arena, "room-%d", n),
                     1,
                     2,
                     NAN,
                     NAN,
                     0,
                     3,
                     false};
}

void draft_room(Draft *d, int storey, double x0, double y0, double x1, double y1) {
    Vec2 p[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    draft_room_shape(d, storey, p, 4);
}

SketchOpening *draft_opening(Draft *d, OpeningKind kind, int storey, double x, double y, double angle,
                             double width, double depth) {
    double z = d->b.storeys[storey].floor;
    SketchOpening *o = ARENA_PUSH(&d->arena, d->s.openings, d->s.opening_count, d->s.opening_capacity);
    *o = (SketchOpening){.kind = kind,
                         .storey = storey,
                         .centre = placed(d, x, y),
                         .angle = angle + d->turn,
                         .width = width,
                         .depth = depth,
                         .sill = z,
                         .head = z + 2,
                         .swing = 1.5,
                         .material = 3,
                         .name = "opening"};
    o->place = arena_format(&d->arena, "opening-%d", d->s.opening_count - 1);
    if (kind == OPENING_WINDOW) o->sill = z + 0.9;
    return o;
}

void draft_cutout(Draft *d, int storey, double x0, double y0, double x1, double y1) {
    Vec2 p[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    int first = draft_points(d, p, 4, true);
    *ARENA_PUSH(&d->arena, d->s.cutouts, d->s.cutout_count, d->s.cutout_capacity) =
        (SketchCutout){storey, first, 4, "cut-out"};
}

// ---- results

void draft_expect_sound(Draft *d, const char *what) {
    const char *faults[4];
    int count = building_check(&d->b, &d->arena, faults, 4);
    cr_expect_eq(count, 0, "%s: %d faults, first: %s", what, count, count ? faults[0] : "");
}

void draft_enclose(Draft *d) {
    Error error = {""};
    cr_assert(maps_enclose(&d->s, &d->b, &d->arena, &error), "%s", error.text);
    draft_expect_sound(d, "enclosed");
}

void draft_free(Draft *d) { arena_free(&d->arena); }

int draft_count_kind(const Draft *d, RegionKind kind) {
    int count = 0;
    for (int i = 0; i < d->b.region_count; i++) count += d->b.regions[i].kind == kind;
    return count;
}

int draft_count_notes(const Draft *d, int kind) {
    int count = 0;
    for (int i = 0; i < d->b.note_count; i++) count += d->b.notes[i].kind == kind;
    return count;
}

bool draft_joins(const Draft *d, int opening, RegionKind a, RegionKind b) {
    const Opening *o = &d->b.openings[opening];
    if (o->region[0] < 0 || o->region[1] < 0 || o->region[0] == o->region[1]) return false;
    RegionKind p = d->b.regions[o->region[0]].kind, q = d->b.regions[o->region[1]].kind;
    return (p == a && q == b) || (p == b && q == a);
}

static double ring_area(const Building *b, const Ring *ring) {
    const Vec2 *p = &b->points[ring->first_point];
    double sum = 0;
    for (int i = 1; i + 1 < ring->point_count; i++)
        sum += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
    return sum;
}

double draft_region_area(const Building *b, const Region *r) {
    double sum = 0;
    for (int k = 0; k < r->ring_count; k++) sum += ring_area(b, &b->rings[r->first_ring + k]);
    return sum;
}

double draft_area_of(const Draft *d, RegionKind kind) {
    double sum = 0;
    for (int i = 0; i < d->b.region_count; i++) {
        if (d->b.regions[i].kind == kind) sum += draft_region_area(&d->b, &d->b.regions[i]);
    }
    return sum;
}

static bool in_region(const Building *b, const Region *r, Vec3 p) {
    if (p.z <= r->z0 || p.z >= r->z1) return false;
    bool inside = false;
    for (int k = 0; k < r->ring_count; k++) {
        const Ring *ring = &b->rings[r->first_ring + k];
        const Vec2 *v = &b->points[ring->first_point];
        for (int i = 0, j = ring->point_count - 1; i < ring->point_count; j = i++) {
            if ((v[i].y > p.y) != (v[j].y > p.y) &&
                p.x < v[i].x + (v[j].x - v[i].x) * (p.y - v[i].y) / (v[j].y - v[i].y))
                inside = !inside;
        }
    }
    return inside;
}

int draft_regions_at(const Draft *d, double x, double y, double z, int *which) {
    int count = 0;
    Vec2 p = placed(d, x, y);
    for (int i = 0; i < d->b.region_count; i++) {
        if (!in_region(&d->b, &d->b.regions[i], vec3(p.x, p.y, z))) continue;
        count++;
        if (which) *which = i;
    }
    return count;
}

int draft_kind_at(const Draft *d, double x, double y, double z) {
    int which = -1;
    return draft_regions_at(d, x, y, z, &which) == 1 ? (int)d->b.regions[which].kind : -1;
}

// ---- random plans

static double on_raster(Random *r, double low, double high) {
    double x = random_between(r, low, high);
    // Half of the coordinates on a coarse raster, so that things touch, coincide and cross at their ends.
    return random_index(r, 2) ? nearbyint(x * 2) / 2 : x;
}

void draft_random_storey(Draft *d, Random *r, int storey, bool openings) {
    int walls = random_index(r, 12), rooms = random_index(r, 6);
    for (int i = 0; i < walls; i++) {
        double x = on_raster(r, 0, 10), y = on_raster(r, 0, 8);
        bool square = random_index(r, 3) > 0;
        double length = random_between(r, 0, 6),
               angle = square ? M_PI / 2 * random_index(r, 4) : random_between(r, 0, 6.3);
        double height = random_index(r, 6) ? DRAFT_HEIGHT : random_between(r, 0, 4);
        draft_wall(d, storey, x, y, x + length * cos(angle), y + length * sin(angle),
                   random_between(r, 0.005, 0.4), height);
    }
    if (random_index(r, 2)) draft_box_walls(d, storey, 1, 1, 6, 5);
    for (int i = 0; i < rooms; i++) {
        if (random_index(r, 2)) {
            double x = on_raster(r, 0, 9), y = on_raster(r, 0, 7);
            draft_room(d, storey, x, y, x + on_raster(r, 0, 4), y + on_raster(r, 0, 4));
        } else {
            Vec2 p[7];
            int count = 3 + random_index(r, 5);
            for (int k = 0; k < count; k++) p[k] = vec2(on_raster(r, 0, 10), on_raster(r, 0, 8));
            draft_room_shape(d, storey, p, count);
        }
        SketchRoom *room = &d->s.rooms[d->s.room_count - 1];
        if (random_index(r, 8) == 0) room->wall = random_between(r, 0.01, 0.5);
        if (random_index(r, 8) == 0) room->z0 = d->b.storeys[storey].floor + random_between(r, -1, 1);
        if (random_index(r, 8) == 0) room->z1 = d->b.storeys[storey].floor + random_between(r, 1, 6);
    }
    for (int i = openings ? random_index(r, 6) : 0; i > 0; i--) {
        double x = on_raster(r, 0, 10), y = on_raster(r, 0, 8), angle = M_PI / 2 * random_index(r, 4);
        if (d->s.wall_count && random_index(r, 3)) {  // on a wall
            const SketchWall *w = &d->s.walls[random_index(r, d->s.wall_count)];
            Vec2 a = d->s.points[w->first_point], c = d->s.points[w->first_point + 2];
            x = (a.x + c.x) / 2;
            y = (a.y + c.y) / 2;
            angle = w->angle;
        }
        SketchOpening *o = draft_opening(d, (OpeningKind)random_index(r, OPENING_KINDS), storey, x, y, angle,
                                         random_between(r, 0, 1.5), random_between(r, 0, 0.5));
        o->hinge = random_index(r, 3);
        o->head += random_between(r, -1, 1);
    }
    if (storey > 0 && random_index(r, 2)) {
        double x = on_raster(r, 0, 9), y = on_raster(r, 0, 7);
        draft_cutout(d, storey, x, y, x + on_raster(r, 0, 3), y + on_raster(r, 0, 3));
    }
}
