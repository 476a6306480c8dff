// plan_fit.c - the openings of a .plan file in the walls around them, once all rooms and walls are known.
#include "engine/core/box_tree.h"
#include "maps/plan/plan_file.h"

static const double PARALLEL = 0.02;  // sine up to which an opening lies along a wall (about 1 degree)
static const double FIT = 0.002;      // how far outside a wall an opening's centre may lie, metres

// Where walls are: rooms with theirs around them, and stretches, on their storeys.
typedef struct Walls {
    BoxTree rooms, stretches;
    BoxHits near;  // what was found last
} Walls;

static Box box_on_storey(const Vec2 *points, int count, int storey) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, vec3(points[i].x, points[i].y, storey));
    return box;
}

static Box widen_in_plan(Box box, double by) {
    Vec3 aside = vec3(by, by, 0);
    return (Box){vec3_sub(box.min, aside), vec3_add(box.max, aside)};
}

static Walls index_walls(Plan *plan) {
    const Sketch *s = &plan->sketch;
    Box *rooms = ARENA_ARRAY(plan->arena, Box, s->room_count),
        *stretches = ARENA_ARRAY(plan->arena, Box, plan->stretch_count);
    for (int i = 0; i < s->room_count; i++) {
        const SketchRoom *r = &s->rooms[i];
        Box box = box_on_storey(s->points + r->first_point, r->point_count, r->storey);
        // A face is as far as its beginning is, and may lie askew: along its length a wall strays from the opening by the
        // sine of that, sqrt(2) PARALLEL.
        double askew = 1.5 * PARALLEL * vec3_length(vec3_sub(box.max, box.min));
        rooms[i] = r->wall > 0 ? widen_in_plan(box, r->wall + 2 * FIT + askew) : box_empty();
    }
    for (int i = 0; i < plan->stretch_count; i++) {
        const Stretch *w = &plan->stretches[i];
        stretches[i] =
            widen_in_plan(box_on_storey((Vec2[2]){w->a, w->b}, 2, w->storey), w->thickness / 2 + 2 * FIT);
    }
    return (Walls){box_tree_build(rooms, s->room_count, plan->arena),
                   box_tree_build(stretches, plan->stretch_count, plan->arena),
                   {0}};
}

// Puts those around an opening's centre into walls->near, in the order of the file. Returns how many.
static int find_around(const Plan *plan, const BoxTree *tree, const SketchOpening *o, Walls *walls) {
    Box centre = box_on_storey(&o->centre, 1, o->storey);
    return box_tree_find(tree, centre, plan->arena, &walls->near);
}

// How far from the centre, along `way`, the face of a room's wall lies; INFINITY when none lies within the wall.
// `wall` receives its thickness.
static double room_face(const Plan *plan, Walls *walls, const SketchOpening *o, Vec2 way, double *wall) {
    const Sketch *s = &plan->sketch;
    double nearest = INFINITY;
    int count = find_around(plan, &walls->rooms, o, walls);
    for (int r = 0; r < count; r++) {
        const SketchRoom *room = &s->rooms[walls->near.items[r]];
        const Vec2 *p = &s->points[room->first_point];
        double turn = plan_signed_area(p, room->point_count) > 0 ? 1 : -1;
        for (int i = 0; i < room->point_count; i++) {
            Vec2 a = p[i], edge = vec2_sub(p[(i + 1) % room->point_count], a);
            double length = vec2_length(edge), facing = turn * vec2_cross(edge, way);
            // The room must lie beyond its edge, and the edge across the way.
            if (!(length > 0) || facing < length * (1 - PARALLEL * PARALLEL)) continue;
            Vec2 to = vec2_sub(a, o->centre);
            double along = -vec2_dot(to, edge) / length, distance = vec2_dot(to, way);
            if (along < -FIT || along > length + FIT) continue;
            if (distance < -FIT || distance > room->wall + FIT || distance >= nearest) continue;
            nearest = distance;
            *wall = room->wall;
        }
    }
    return nearest;
}

// A stretch of explicit wall around the centre, along the opening: its depth is the wall's.
static bool fit_to_stretch(const Plan *plan, Walls *walls, SketchOpening *o, Vec2 axis) {
    int count = find_around(plan, &walls->stretches, o, walls);
    for (int i = 0; i < count; i++) {
        const Stretch *w = &plan->stretches[walls->near.items[i]];
        Vec2 edge = vec2_sub(w->b, w->a), to = vec2_sub(o->centre, w->a);
        double length = vec2_length(edge);
        if (fabs(vec2_cross(edge, axis)) > PARALLEL * length) continue;
        double along = vec2_dot(to, edge) / length, off = vec2_cross(edge, to) / length;
        if (along < 0 || along > length || fabs(off) > w->thickness / 2 + FIT) continue;
        o->centre = vec2_add(w->a, vec2_scale(edge, along / length));
        o->depth = w->thickness;
        return true;
    }
    return false;
}

static bool fit_opening(Plan *plan, Walls *walls, int index) {
    SketchOpening *o = &plan->sketch.openings[index];
    Vec2 axis = vec2(cos(o->angle), sin(o->angle)), normal = vec2(-axis.y, axis.x);
    if (!plan->pending[index].fit || fit_to_stretch(plan, walls, o, axis)) return true;
    double wall[2] = {0}, face[2];
    for (int s = 0; s < 2; s++)
        face[s] = room_face(plan, walls, o, s ? vec2_scale(normal, -1) : normal, &wall[s]);
    // Rooms on both sides: from face to face. On one side: as deep as that room's wall.
    if (isfinite(face[0]) && !isfinite(face[1])) face[1] = wall[0] - face[0];
    if (isfinite(face[1]) && !isfinite(face[0])) face[0] = wall[1] - face[1];
    double depth = face[0] + face[1];
    if (!(isfinite(depth) && depth >= PLAN_MIN_SIZE)) {
        plan->line.number = plan->pending[index].line;
        return plan_fail(
            &plan->line,
            "%s %s at %g,%g stands in no wall along its angle (allowed: a centre inside a wall, or a depth)",
            opening_kind_name(o->kind), o->name, o->centre.x, o->centre.y);
    }
    o->centre = vec2_add(o->centre, vec2_scale(normal, (face[0] - face[1]) / 2));
    o->depth = depth;
    return true;
}

bool plan_fit_openings(Plan *plan) {
    Walls walls = index_walls(plan);
    for (int i = 0; i < plan->sketch.opening_count; i++)
        if (!fit_opening(plan, &walls, i)) return false;
    return true;
}
