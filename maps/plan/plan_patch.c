// plan_patch.c - patches with their trims, and metaballs: shapes of several lines, which are checked and become polygons when the
// next one begins.
#include <float.h>

#include "maps/curved/curved_field.h"
#include "maps/curved/curved_patch.h"
#include "maps/plan/plan_curved.h"

enum { MAX_TRIMS = 200, MAX_BALLS = 100 };
static const double LEAST_WEIGHT = 0.001, MOST_WEIGHT = 1000;  // of controls
static const double LEAST_RADIUS = 0.001, MOST_RADIUS = 100;   // of balls, metres
static const double LEAST_THRESHOLD = 0.001, MOST_THRESHOLD = 100;

// ---- patches

static bool lies_on_a_line(const CurvedControl *control) {
    const double thin = 1e-4;  // metres
    Vec3 a = control[0].point, far = a;
    for (int i = 1; i < PATCH_CONTROLS; i++) {
        Vec3 p = control[i].point;
        if (vec3_length(vec3_sub(p, a)) > vec3_length(vec3_sub(far, a))) far = p;
    }
    Vec3 along = vec3_normalize(vec3_sub(far, a));
    double off = 0;
    for (int i = 0; i < PATCH_CONTROLS; i++)
        off = fmax(off, vec3_length(vec3_cross(vec3_sub(control[i].point, a), along)));
    return off < thin;
}

// Normals that turn by more than a right angle from one sample to the next: no surface that is drawn does.
bool plan_check_patch(PlanLine *line, const PlanModels *models, const char *what) {
    enum { SAMPLES = 32 };
    const Building *shapes = &models->shapes;
    const CurvedControl *control = shapes->controls + shapes->shapes[shapes->shape_count - 1].first_control;
    if (lies_on_a_line(control))
        return plan_fail(line, "%s lies on a line or in a point (allowed: with an area)", what);
    Vec3 row[SAMPLES + 1];
    for (int j = 0; j <= SAMPLES; j++) {
        Vec3 last = {0, 0, 0};
        for (int i = 0; i <= SAMPLES; i++) {
            double u = (double)i / SAMPLES, v = (double)j / SAMPLES;
            Vec3 n = curved_patch_at(control, u, v).normal;
            if (vec3_length(n) == 0 || (i > 0 && vec3_dot(n, last) <= 0) ||
                (j > 0 && vec3_dot(n, row[i]) <= 0))
                return plan_fail(line, "%s folds over itself near u %.3g, v %.3g (allowed: a smooth surface)",
                                 what, u, v);
            last = row[i] = n;
        }
    }
    return true;
}

static bool read_controls(PlanLine *line, Building *shapes) {
    int count = 0;
    while (plan_is_point(line, 2)) {
        CurvedControl control = {.weight = 1};
        if (!plan_place(line, "a control point", true, &control.point)) return false;
        *ARENA_PUSH(line->arena, shapes->controls, shapes->control_count, shapes->control_capacity) = control;
        count++;
    }
    return count == PATCH_CONTROLS ||
           plan_fail(line, "the patch has %d control points (allowed: %d, four rows of four, as x,y,z)",
                     count, PATCH_CONTROLS);
}

bool plan_read_patch(PlanLine *line, PlanModels *models) {
    Building *shapes = &models->shapes;
    int material, first = shapes->control_count;
    double tolerance = PLAN_TOLERANCE;
    PlanList weights = {0};
    PlanOption options[] = {
        {.word = "weights", .kind = PLAN_LIST, .out = &weights, .min = LEAST_WEIGHT, .max = MOST_WEIGHT},
        PLAN_TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !read_controls(line, shapes) || !plan_options(line, options, 2))
        return false;
    if (weights.count != 0 && weights.count != PATCH_CONTROLS)
        return plan_fail(line, "the patch has %d weights (allowed: %d, or none)", weights.count,
                         PATCH_CONTROLS);
    for (int i = 0; i < weights.count; i++) shapes->controls[first + i].weight = weights.numbers[i];
    CurvedShape *shape = plan_add_shape(line, models, CURVED_PATCH, material, tolerance);
    shape->first_control = first;
    shape->first_trim = shapes->trim_count;
    models->open_line = line->number;
    return plan_check_patch(line, models, "the patch");
}

// The curves of a loop, each beginning where the one before it ends.
static void add_trims(PlanLine *line, Building *shapes, const PlanShape *loop, const PlanList *weights) {
    for (int k = 0; k + 3 < loop->count; k += 3) {
        CurvedTrim trim;
        for (int i = 0; i < 4; i++) {
            trim.point[i] = loop->points[k + i];
            trim.weight[i] = weights->count ? weights->numbers[k + i] : 1;
        }
        *ARENA_PUSH(line->arena, shapes->trims, shapes->trim_count, shapes->trim_capacity) = trim;
    }
}

bool plan_read_trim(PlanLine *line, PlanModels *models) {
    Building *shapes = &models->shapes;
    CurvedShape *shape = models->open_line ? &shapes->shapes[shapes->shape_count - 1] : NULL;
    PlanShape loop;
    PlanList weights = {0};
    PlanOption options[] = {
        {.word = "weights", .kind = PLAN_LIST, .out = &weights, .min = LEAST_WEIGHT, .max = MOST_WEIGHT}};
    if (!shape || shape->kind != CURVED_PATCH)
        return plan_fail(line, "a trim of nothing (allowed: behind a patch)");
    if (!plan_points(line, "points u,v of the trim", 4, &loop) || !plan_options(line, options, 1))
        return false;
    if (loop.count % 3 != 1)
        return plan_fail(line, "the trim has %d points (allowed: 4, 7, 10, ...: cubic curves end to end)",
                         loop.count);
    if (weights.count != 0 && weights.count != loop.count)
        return plan_fail(line, "the trim has %d weights (allowed: %d, one a point, or none)", weights.count,
                         loop.count);
    for (int i = 0; i < loop.count; i++) {
        Vec2 p = loop.points[i];
        if (!(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1))
            return plan_fail(line, "point %d of the trim is %g,%g (allowed: 0 to 1 each)", i + 1, p.x, p.y);
    }
    Vec2 a = loop.points[0], b = loop.points[loop.count - 1];
    if (!vec2_equal(a, b))
        return plan_fail(line, "the trim begins at %g,%g and ends at %g,%g (allowed: where it began)", a.x,
                         a.y, b.x, b.y);
    add_trims(line, shapes, &loop, &weights);
    shape->trim_count = shapes->trim_count - shape->first_trim;
    return shape->trim_count <= MAX_TRIMS ||
           plan_fail(line, "the patch has %d curves of trims (limit %d)", shape->trim_count, MAX_TRIMS);
}

// ---- metaballs

bool plan_read_metaballs(PlanLine *line, PlanModels *models) {
    int material;
    double threshold = 0, tolerance = PLAN_TOLERANCE;
    PlanOption options[] = {{.word = "threshold",
                             .kind = PLAN_PURE,
                             .out = &threshold,
                             .min = LEAST_THRESHOLD,
                             .max = MOST_THRESHOLD,
                             .required = true},
                            PLAN_TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !plan_options(line, options, 2)) return false;
    CurvedShape *shape = plan_add_shape(line, models, CURVED_METABALLS, material, tolerance);
    shape->threshold = threshold;
    shape->first_ball = models->shapes.ball_count;
    models->open_line = line->number;
    return true;
}

bool plan_read_ball(PlanLine *line, PlanModels *models) {
    Building *shapes = &models->shapes;
    CurvedShape *shape = models->open_line ? &shapes->shapes[shapes->shape_count - 1] : NULL;
    CurvedBall ball = {.weight = 1};
    PlanOption options[] = {
        {.word = "radius",
         .kind = PLAN_LENGTH,
         .out = &ball.radius,
         .min = LEAST_RADIUS,
         .max = MOST_RADIUS,
         .required = true},
        {.word = "weight", .kind = PLAN_PURE, .out = &ball.weight, .min = -MOST_WEIGHT, .max = MOST_WEIGHT}};
    if (!shape || shape->kind != CURVED_METABALLS)
        return plan_fail(line, "a ball of nothing (allowed: behind metaballs)");
    if (!plan_place(line, "the ball's centre", true, &ball.centre) || !plan_options(line, options, 2))
        return false;
    if (fabs(ball.weight) < LEAST_WEIGHT)
        return plan_fail(line, "the ball's weight is %g (allowed: at least %g, or at most %g)", ball.weight,
                         LEAST_WEIGHT, -LEAST_WEIGHT);
    if (shape->ball_count == MAX_BALLS) return plan_fail(line, "more than %d balls (limit)", MAX_BALLS);
    *ARENA_PUSH(line->arena, shapes->balls, shapes->ball_count, shapes->ball_capacity) = ball;
    shape->ball_count++;
    return true;
}

static bool check_balls(PlanLine *line, const Building *shapes, const CurvedShape *shape) {
    if (shape->ball_count == 0)
        return plan_fail(line, "the metaballs have no ball (allowed: at least one line 'ball')");
    double peak = curved_field_peak(shapes->balls + shape->first_ball, shape->ball_count);
    return peak > shape->threshold ||
           plan_fail(line,
                     "the field of the metaballs reaches %.4g, their threshold is %g (allowed: below that)",
                     peak, shape->threshold);
}

bool plan_close_shape(PlanLine *line, PlanModels *models) {
    if (!models->open_line) return true;
    const Building *shapes = &models->shapes;
    const CurvedShape *shape = &shapes->shapes[shapes->shape_count - 1];
    int here = line->number;
    line->number = models->open_line;
    models->open_line = 0;
    if (shape->kind == CURVED_METABALLS && !check_balls(line, shapes, shape)) return false;
    if (!plan_tessellate(line, models)) return false;
    line->number = here;
    return true;
}
