// plan_views.c - statements of .plan files from which one looks: views, tours, the start.
#include "engine/core/predicates.h"
#include "maps/plan/plan_file.h"

static const double EYE_HEIGHT = 1.6;  // above the floor
static const double DEFAULT_FOV = 70 * (M_PI / 180);

static bool read_eye(Plan *plan, Viewpoint *v) {
    PlanLine *line = &plan->line;
    v->fov = DEFAULT_FOV;
    PlanOption options[] = {
        {.word = "yaw", .kind = PLAN_ANGLE, .out = &v->yaw, .min = -360, .max = 360, .required = true},
        {.word = "pitch", .kind = PLAN_ANGLE, .out = &v->pitch, .min = -90, .max = 90},
        {.word = "fov", .kind = PLAN_ANGLE, .out = &v->fov, .min = 1, .max = 170}};
    if (!plan_place(line, "the eye", true, &v->eye) || !plan_options(line, options, 3)) return false;
    v->eye.z += plan_storey_floor(plan);
    return true;
}

bool plan_read_view(Plan *plan) {
    Viewpoint view = {0};
    if (!plan_name(&plan->line, "the view's name", &view.name) || !read_eye(plan, &view)) return false;
    Building *b = plan->b;
    *ARENA_PUSH(plan->arena, b->viewpoints, b->viewpoint_count, b->viewpoint_capacity) = view;
    return true;
}

bool plan_read_start(Plan *plan) {
    PlanLine *line = &plan->line;
    Vec2 at;
    double yaw = 0;
    PlanOption options[] = {{.word = "yaw", .kind = PLAN_ANGLE, .out = &yaw, .min = -360, .max = 360}};
    if (plan->start_line) return plan_fail(line, "a second 'start' (allowed: once)");
    if (!plan_point(line, "the start", &at) || !plan_options(line, options, 1)) return false;
    plan->start_line = line->number;
    plan->start = vec3(at.x, at.y, plan_storey_floor(plan) + EYE_HEIGHT);
    plan->start_yaw = yaw;
    return true;
}

bool plan_read_tour(Plan *plan) {
    Tour tour = {.first_viewpoint = plan->b->tour_point_count};
    if (!plan_name(&plan->line, "the tour's name", &tour.name) || !plan_end(&plan->line)) return false;
    *ARENA_PUSH(plan->arena, plan->b->tours, plan->b->tour_count, plan->b->tour_capacity) = tour;
    plan->block = BLOCK_TOUR;
    plan->block_line = plan->line.number;
    return true;
}

bool plan_read_tour_eye(Plan *plan) {
    Building *b = plan->b;
    Tour *tour = &b->tours[b->tour_count - 1];
    Viewpoint eye = {.name = tour->name};
    if (!read_eye(plan, &eye)) return false;
    *ARENA_PUSH(plan->arena, b->tour_points, b->tour_point_count, b->tour_point_capacity) = eye;
    tour->viewpoint_count++;
    return true;
}

// Whether q lies in the region's plan: inside an odd number of its rings.
static bool region_holds(const Building *b, const Region *region, Vec2 q) {
    bool in = false;
    for (int k = 0; k < region->ring_count; k++) {
        const Ring *ring = &b->rings[region->first_ring + k];
        const Vec2 *p = &b->points[ring->first_point];
        for (int i = 0, j = ring->point_count - 1; i < ring->point_count; j = i++)
            if ((p[i].y > q.y) != (p[j].y > q.y) && (orient2d(p[j], p[i], q) > 0) == (p[i].y > p[j].y))
                in = !in;
    }
    return in;
}

bool plan_set_start(Plan *plan) {
    Building *b = plan->b;
    Vec3 s = plan->start;
    if (plan->start_line == 0) return true;
    for (int i = 0; i < b->region_count; i++) {
        const Region *region = &b->regions[i];
        if (region->kind != REGION_ROOM || s.z <= region->z0 || s.z >= region->z1) continue;
        if (!region_holds(b, region, vec2(s.x, s.y))) continue;
        b->start = s;
        b->start_yaw = plan->start_yaw;
        return true;
    }
    plan->line.number = plan->start_line;
    return plan_fail(&plan->line,
                     "the start, an eye at (%g, %g, %g), lies in no room (allowed: a place in a room)", s.x,
                     s.y, s.z);
}
