// test_query_slot.c - what is in view of upright rectangles, by slots, against rays from the eye and against the polygon
// clipper.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "visibility/query.h"

// An upright rectangle about `distance` ahead of the eye, towards +y, which faces the eye; `corners` counter-clockwise as
// the eye sees them.
static Gate wall_ahead(Random *random, Vec3 eye, double distance, Vec3 corners[4]) {
    Gate gate = {.is_wall = true};
    for (double ahead = 0; ahead < 0.01; ahead = gate_ahead(&gate, eye)) {
        double turn = random_between(random, -1.5, 1.5), length = random_between(random, 0.01, 4),
               z = random_between(random, -2, 1);
        Vec2 middle = {eye.x + random_between(random, -2, 2), eye.y + distance};
        gate.n = vec2(sin(turn), -cos(turn));
        gate.d = vec2_dot(gate.n, middle);
        double s = vec2_dot(gate_along(&gate), middle);
        gate.wall.s0 = s - length / 2, gate.wall.s1 = s + length / 2;
        gate.wall.z0 = eye.z + z, gate.wall.z1 = gate.wall.z0 + random_between(random, 0.01, 3);
    }
    Vec2 foot = vec2_scale(gate.n, gate.d), along = gate_along(&gate);
    for (int i = 0; i < 4; i++) {
        double s = i == 0 || i == 3 ? gate.wall.s1 : gate.wall.s0;
        Vec2 p = vec2_add(foot, vec2_scale(along, s));
        corners[i] = vec3(p.x, p.y, i < 2 ? gate.wall.z0 : gate.wall.z1);
    }
    return gate;
}

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
static bool meets(const Gate *gate, Vec3 eye, Vec3 direction, double *s, double *height) {
    double rate = -(direction.x * gate->n.x + direction.y * gate->n.y);
    if (rate <= 0) return false;
    double t = gate_ahead(gate, eye) / rate;
    Vec2 along = gate_along(gate);
    *s = t * (along.x * direction.x + along.y * direction.y);
    *height = t * direction.z;
    return true;
}

static bool passes(const Gate *gate, Vec3 eye, Vec3 direction) {
    double s, height, foot = vec2_dot(gate_along(gate), vec2(eye.x, eye.y));
    return meets(gate, eye, direction, &s, &height) && s + foot >= gate->wall.s0 &&
           s + foot <= gate->wall.s1 && height + eye.z >= gate->wall.z0 && height + eye.z <= gate->wall.z1;
}

static double edge_at(SlotEdge edge, double s) { return edge.at + edge.rise * s; }

static bool holds(const Slot *slot, const Gate *gate, Vec3 eye, Vec3 direction) {
    double s, height;
    return meets(gate, eye, direction, &s, &height) && s >= slot->s0 && s <= slot->s1 &&
           height <= edge_at(slot->top, s) && height >= edge_at(slot->bottom, s);
}

static bool in_cone(const Cone *cone, Vec3 direction) {
    for (int i = 0; i < cone->count; i++) {
        if (vec3_dot(cone->plane[i].n, direction) < 0) return false;
    }
    return true;
}

static double slot_area(const Slot *slot) {
    double first = edge_at(slot->top, slot->s0) - edge_at(slot->bottom, slot->s0);
    double last = edge_at(slot->top, slot->s1) - edge_at(slot->bottom, slot->s1);
    return 0.5 * (first + last) * (slot->s1 - slot->s0);
}

// What is in view of a wall by the polygon clipper: its area.
static double polygon_in_view(const Cone *cone, const Vec3 corners[4]) {
    Vec3 polygon[2][MAX_CORNERS];
    int count = 4, at = 0;
    memcpy(polygon[0], corners, 4 * sizeof *corners);
    for (int i = 0; i < cone->count && count > 0; i++, at = 1 - at)
        count = polygon_clip(polygon[at], count, cone->plane[i], 0, polygon[1 - at]);
    return count > 0 ? polygon_area(polygon[at], count) : 0;
}

typedef struct Tally {
    int through_one, through_two;
    double slots, polygons;  // areas
} Tally;

// Two walls side by side before a third: every ray of the view through one of them and the third must lie in the slots on
// its way, in the cones beyond them, and in the union of what the third shows by either way.
static void look_through_walls(Random *random, unsigned seed, Tally *tally) {
    Vec3 eye = {random_between(random, -50, 50), random_between(random, -50, 50),
                random_between(random, -5, 5)};
    Vec3 corners[3][4];
    Cone view = view_volume(random, eye), beyond[2], last;
    Gate near[2] = {wall_ahead(random, eye, random_between(random, 0.1, 3), corners[0]),
                    wall_ahead(random, eye, random_between(random, 0.1, 3), corners[1])};
    Gate far = wall_ahead(random, eye, random_between(random, 4, 12), corners[2]);
    Slot slot[2], part[2], both;
    bool seen[2], on[2];
    for (int k = 0; k < 2; k++) {
        seen[k] = query_slot_clip(&view, &near[k], eye, gate_ahead(&near[k], eye), &slot[k]);
        if (seen[k]) query_slot_cone(&slot[k], &near[k], eye, false, &beyond[k]);
        on[k] = seen[k] && query_slot_clip(&beyond[k], &far, eye, gate_ahead(&far, eye), &part[k]);
        tally->slots += seen[k] ? slot_area(&slot[k]) : 0;
        tally->polygons += polygon_in_view(&view, corners[k]);
    }
    both = on[0] && on[1] ? query_slot_union(&part[0], &part[1], &far, eye) : on[0] ? part[0] : part[1];
    if (on[0] || on[1]) query_slot_cone(&both, &far, eye, false, &last);
    for (int i = 0; i < 100; i++) {
        const Vec3 *to = corners[i % 2 ? 2 : i / 2 % 2];
        Vec3 point = vec3_lerp(vec3_lerp(to[0], to[1], random_unit(random)),
                               vec3_lerp(to[3], to[2], random_unit(random)), random_unit(random));
        Vec3 ray = vec3_sub(point, eye);
        if (!in_cone(&view, ray)) continue;
        for (int k = 0; k < 2; k++) {
            if (!passes(&near[k], eye, ray)) continue;
            tally->through_one++;
            cr_assert(seen[k] && holds(&slot[k], &near[k], eye, ray),
                      "a ray is lost at the first wall, seed %u", seed);
            cr_assert(in_cone(&beyond[k], ray), "a ray is lost beyond the first wall, seed %u", seed);
            cr_assert(!beyond[k].is_slot || !query_slot_outside(&beyond[k], ray, vec3(0, 0, 0)), "seed %u",
                      seed);
            if (!passes(&far, eye, ray)) continue;
            tally->through_two++;
            cr_assert(on[k] && holds(&part[k], &far, eye, ray), "a ray is lost at the second wall, seed %u",
                      seed);
            cr_assert(holds(&both, &far, eye, ray), "a ray is lost where two ways meet, seed %u", seed);
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
    cr_assert_geq(tally.slots, tally.polygons * (1 - 1e-9));
    cr_assert_leq(tally.slots, tally.polygons * 1.1, "slots %g m2, polygons %g m2", tally.slots,
                  tally.polygons);
}

// A portal that is no upright rectangle is not taken for one.
Test(query_slot, knows_rectangles) {
    Vec3 v[4] = {{0, 0, 0}, {2, 0, 0}, {2, 0, 3}, {0, 0, 3}};
    CellGraph graph = {.portal_vertices = v};
    Portal portal = {.vertex_count = 4};
    Gate gate;
    cr_assert(query_is_wall(&graph, &portal, plane_of_polygon(v, 4), &gate));
    cr_assert_eq(gate.wall.z1 - gate.wall.z0, 3);
    cr_assert_eq(gate.wall.s1 - gate.wall.s0, 2);
    v[3].x = 0.01;
    cr_assert_not(query_is_wall(&graph, &portal, plane_of_polygon(v, 4), &gate), "a sloping side");
    v[3].x = 0, v[2].y = v[3].y = 0.01;
    cr_assert_not(query_is_wall(&graph, &portal, plane_of_polygon(v, 4), &gate), "a leaning portal");
}
