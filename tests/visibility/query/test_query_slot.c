// test_query_slot.c - what is in view of upright rectangles, by slots, against rays from the eye and against the polygon
// clipper.
#include <criterion/criterion.h>
#include <string.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "visibility/query/query.h"

typedef struct Wall {
    Vec2 n;  // towards the eye
    double d, s0, s1, z0, z1;
} Wall;

static Vec2 wall_along(const Wall *wall) { return vec2(wall->n.y, -wall->n.x); }
static double wall_before(const Wall *wall, Vec3 eye) {
    return vec2_dot(wall->n, vec2(eye.x, eye.y)) - wall->d;
}

// An upright rectangle about `distance` ahead of the eye, towards +y, which faces the eye; `corners` counter-clockwise as
// the eye sees them.
static Wall wall_ahead(Random *random, Vec3 eye, double distance, Vec3 corners[4]) {
    Wall wall = {.d = 0};
    for (double before = 0; before < 0.01; before = wall_before(&wall, eye)) {
        double turn = random_between(random, -1.5, 1.5), length = random_between(random, 0.01, 4),
               z = random_between(random, -2, 1);
        Vec2 middle = {eye.x + random_between(random, -2, 2), eye.y + distance};
        wall.n = vec2(sin(turn), -cos(turn));
        wall.d = vec2_dot(wall.n, middle);
        double s = vec2_dot(wall_along(&wall), middle);
        wall.s0 = s - length / 2, wall.s1 = s + length / 2;
        wall.z0 = eye.z + z, wall.z1 = wall.z0 + random_between(random, 0.01, 3);
    }
    Vec2 foot = vec2_scale(wall.n, wall.d), along = wall_along(&wall);
    for (int i = 0; i < 4; i++) {
        double s = i == 0 || i == 3 ? wall.s1 : wall.s0;
        Vec2 p = vec2_add(foot, vec2_scale(along, s));
        corners[i] = vec3(p.x, p.y, i < 2 ? wall.z0 : wall.z1);
    }
    return wall;
}

// The walls as ways, so that the eye finds each in another lane.
static void block_of(const Wall *walls, int count, WayBlock *out) {
    for (int i = 0; i < FOUR; i++) {
        const Wall *wall = &walls[i % count];
        out->nx[i] = wall->n.x, out->ny[i] = wall->n.y, out->d[i] = wall->d;
        out->s0[i] = wall->s0, out->s1[i] = wall->s1;
        out->z0[i] = wall->z0, out->z1[i] = wall->z1;
    }
}

static Four ahead_of(const WayBlock *ways, Vec3 eye) { return ways->nx * eye.x + ways->ny * eye.y - ways->d; }

// A view volume of four planes that looks towards +y, pitched and rolled.
static Cone view_volume(Random *random, Vec3 eye) {
    Cone cone = {.all_around = true};
    double pitch = random_between(random, -0.6, 0.6), roll = random_between(random, -0.3, 0.3);
    Vec3 ahead = vec3(0, cos(pitch), sin(pitch)), up = vec3(0, -sin(pitch), cos(pitch)),
         right = vec3(1, 0, 0);
    Vec3 r = vec3_add(vec3_scale(right, cos(roll)), vec3_scale(up, sin(roll)));
    Vec3 u = vec3_sub(vec3_scale(up, cos(roll)), vec3_scale(right, sin(roll)));
    const Vec3 side[4] = {r, vec3_scale(r, -1), u, vec3_scale(u, -1)};
    for (int i = 0; i < 4; i++) {
        Vec3 n = vec3_normalize(vec3_add(side[i], vec3_scale(ahead, i < 2 ? 0.8 : 0.45)));
        cone_add(&cone, n, vec3_dot(n, eye));
    }
    return cone;
}

// Where a direction meets the wall's plane: along it from the eye's foot, and in height from the eye.
static bool meets(const Wall *wall, Vec3 eye, Vec3 direction, double *s, double *height) {
    double rate = -(direction.x * wall->n.x + direction.y * wall->n.y);
    if (rate <= 0) return false;
    double t = wall_before(wall, eye) / rate;
    Vec2 along = wall_along(wall);
    *s = t * (along.x * direction.x + along.y * direction.y);
    *height = t * direction.z;
    return true;
}

static bool passes(const Wall *wall, Vec3 eye, Vec3 direction) {
    double s, height, foot = vec2_dot(wall_along(wall), vec2(eye.x, eye.y));
    return meets(wall, eye, direction, &s, &height) && s + foot >= wall->s0 && s + foot <= wall->s1 &&
           height + eye.z >= wall->z0 && height + eye.z <= wall->z1;
}

static double edge_at(SlotEdge edge, int lane, double s) { return edge.at[lane] + edge.rise[lane] * s; }

static bool holds(const Slots *slots, int lane, const Wall *wall, Vec3 eye, Vec3 direction) {
    double s, height;
    return meets(wall, eye, direction, &s, &height) && s >= slots->s0[lane] && s <= slots->s1[lane] &&
           height <= edge_at(slots->top, lane, s) && height >= edge_at(slots->bottom, lane, s);
}

static bool in_cone(const Cone *cone, Vec3 direction) {
    for (int i = 0; i < cone->count; i++) {
        if (vec3_dot(cone->plane[i].n, direction) < 0) return false;
    }
    return true;
}

static double slot_area(const Slots *slots, int lane) {
    double s0 = slots->s0[lane], s1 = slots->s1[lane];
    double first = edge_at(slots->top, lane, s0) - edge_at(slots->bottom, lane, s0);
    double last = edge_at(slots->top, lane, s1) - edge_at(slots->bottom, lane, s1);
    return 0.5 * (first + last) * (s1 - s0);
}

// The area that is in view of a wall, by the polygon clipper.
static double polygon_in_view(const Cone *cone, const Vec3 corners[4]) {
    Vec3 polygon[2][MAX_CORNERS];
    int count = 4, at = 0;
    memcpy(polygon[0], corners, 4 * sizeof *corners);
    for (int i = 0; i < cone->count && count > 0; i++, at = 1 - at)
        count = polygon_clip(polygon[at], count, cone->plane[i], 0, polygon[1 - at]);
    return count > 0 ? polygon_area(polygon[at], count) : 0;
}

typedef struct Tally {
    int through_one, through_two, held;
    double slots, polygons;  // areas
} Tally;

// A slot that holds another is as large, but for slack.
static void check_held(const Slots *a, const Slots *b, Tally *tally, unsigned seed) {
    if (!(query_slots_hold(a, b) >> 2 & 1)) return;
    tally->held++;
    cr_assert_geq(slot_area(a, 2), slot_area(b, 2) - 1e-3, "seed %u", seed);
}

// Two walls side by side before a third: every ray of the view through one of them and the third must lie in the slots on
// its way, in the cones beyond them, and in the union of what the third shows by either way.
static void look_through_walls(Random *random, unsigned seed, Tally *tally) {
    Vec3 eye = {random_between(random, -50, 50), random_between(random, -50, 50),
                random_between(random, -5, 5)};
    Vec3 corners[3][4];
    Cone view = view_volume(random, eye), beyond[2], last;
    Wall near[2] = {wall_ahead(random, eye, random_between(random, 0.1, 3), corners[0]),
                    wall_ahead(random, eye, random_between(random, 0.1, 3), corners[1])};
    Wall far[3] = {near[0], near[1], wall_ahead(random, eye, random_between(random, 4, 12), corners[2])};
    WayBlock first, second;
    block_of(near, 2, &first);
    block_of(far, 3, &second);
    Slots slots, part[2], both;
    unsigned seen = query_slots_clip(&view, &first, eye, ahead_of(&first, eye), &slots);
    cr_assert_eq(seen >> 2, seen & 3, "the same walls in other lanes, seed %u", seed);
    bool on[2];
    for (int k = 0; k < 2; k++) {
        if (seen >> k & 1) query_slot_cone(&slots, &first, k, eye, false, &beyond[k]);
        on[k] = (seen >> k & 1) &&
                (query_slots_clip(&beyond[k], &second, eye, ahead_of(&second, eye), &part[k]) >> 2 & 1);
        tally->slots += seen >> k & 1 ? slot_area(&slots, k) : 0;
        tally->polygons += polygon_in_view(&view, corners[k]);
        if (seen >> k & 1) query_cone_planes(&beyond[k], eye);
    }
    both = part[on[0] ? 0 : 1];
    if (on[0] && on[1]) query_slots_join(&second, eye, &part[0], &part[1], &both);
    if (on[0] && on[1]) check_held(&part[0], &part[1], tally, seed);
    if (on[0] || on[1]) query_slot_cone(&both, &second, 2, eye, false, &last);
    if (on[0] || on[1]) query_cone_planes(&last, eye);
    for (int i = 0; i < 100; i++) {
        const Vec3 *to = corners[i % 2 ? 2 : i / 2 % 2];
        Vec3 point = vec3_lerp(vec3_lerp(to[0], to[1], random_unit(random)),
                               vec3_lerp(to[3], to[2], random_unit(random)), random_unit(random));
        Vec3 ray = vec3_sub(point, eye);
        if (!in_cone(&view, ray)) continue;
        for (int k = 0; k < 2; k++) {
            if (!passes(&near[k], eye, ray)) continue;
            tally->through_one++;
            cr_assert((seen >> k & 1) && holds(&slots, k, &near[k], eye, ray),
                      "a ray is lost at the first wall, seed %u", seed);
            cr_assert(in_cone(&beyond[k], ray), "a ray is lost beyond the first wall, seed %u", seed);
            if (!passes(&far[2], eye, ray)) continue;
            tally->through_two++;
            cr_assert(on[k] && holds(&part[k], 2, &far[2], eye, ray),
                      "a ray is lost at the second wall, seed %u", seed);
            cr_assert(holds(&both, 2, &far[2], eye, ray), "a ray is lost where two ways meet, seed %u", seed);
            cr_assert(in_cone(&last, ray), "a ray is lost beyond the second wall, seed %u", seed);
        }
    }
}

// No ray that a rasteriser could follow is lost, and a slot shows little more than the polygon: corners that a rolled
// view cuts off, on the whole less than a tenth of the area.
Test(query_slot, holds_all_rays_and_little_more) {
    Tally tally = {0};
    for (unsigned seed = 1; seed <= 20000; seed++) {
        Random random = {seed};
        look_through_walls(&random, seed, &tally);
    }
    cr_assert_gt(tally.through_one, 100000);
    cr_assert_gt(tally.through_two, 20000);
    cr_assert_gt(tally.held, 100);
    cr_assert_geq(tally.slots, tally.polygons * (1 - 1e-9));
    cr_assert_leq(tally.slots, tally.polygons * 1.1, "slots %g m2, polygons %g m2", tally.slots,
                  tally.polygons);
}

// A portal that is no upright rectangle is not taken for one.
Test(query_slot, knows_rectangles) {
    Vec3 v[4] = {{0, 0, 0}, {2, 0, 0}, {2, 0, 3}, {0, 0, 3}};
    CellGraph graph = {.portal_vertices = v};
    Portal portal = {.vertex_count = 4};
    double s[2], z[2];
    cr_assert(query_is_wall(&graph, &portal, plane_of_polygon(v, 4), s, z));
    cr_assert_eq(z[1] - z[0], 3);
    cr_assert_eq(s[1] - s[0], 2);
    v[3].x = 0.01;
    cr_assert_not(query_is_wall(&graph, &portal, plane_of_polygon(v, 4), s, z), "a sloping side");
    v[3].x = 0, v[2].y = v[3].y = 0.01;
    cr_assert_not(query_is_wall(&graph, &portal, plane_of_polygon(v, 4), s, z), "a leaning portal");
}
