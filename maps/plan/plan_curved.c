// plan_curved.c - spheres, cones and what a lathe turns, in a model's own frame, and all curved shapes in a building.
#include "maps/plan/plan_curved.h"
#include "maps/curved/curved_patch.h"
#include "maps/curved/curved_tessellate.h"

// A shape that asks for more polygons is refused.
enum { MAX_SHAPE_POLYGONS = 100000 };
// Radii, metres; those of a cone's top may be 0.
static const double LEAST_RADIUS = 0.001, MOST_RADIUS = 100;
// What a bound on a tolerance may miss it by.
static const double ROUNDING = 1e-9;

bool plan_tessellate(PlanLine *line, PlanModels *models) {
    Building *shapes = &models->shapes;
    CurvedShape *shape = &shapes->shapes[shapes->shape_count - 1];
    Arena scratch = {0};
    CurvedMesh mesh;
    curved_tessellate(shapes, shape, shape->tolerance, &scratch, &mesh);
    shape->first_polygon = shapes->polygon_count;
    int most = building_polygons_allowed(shapes->file_size);
    bool fine = mesh.tolerance <= shape->tolerance + ROUNDING,
         single = mesh.polygon_count <= MAX_SHAPE_POLYGONS,
         few = single && mesh.polygon_count <= most - shapes->polygon_count;
    for (int i = 0; fine && few && i < mesh.polygon_count; i++)
        building_add_polygon(line->arena, shapes, mesh.vertices + mesh.first[i],
                             mesh.first[i + 1] - mesh.first[i], shape->material);
    shape->polygon_count = shapes->polygon_count - shape->first_polygon;
    double kept = mesh.tolerance;
    int count = mesh.polygon_count;
    arena_free(&scratch);
    if (!isfinite(kept))
        return plan_fail(line,
                         "the trims cut the patch into too many pieces (allowed: loops that hardly cross)");
    if (!fine)
        return plan_fail(line,
                         "a tolerance of %g metres takes too many polygons (allowed here: from about %.2g)",
                         shape->tolerance, kept);
    if (!single) return plan_fail(line, "the shape has %d polygons (limit %d)", count, MAX_SHAPE_POLYGONS);
    if (!few)
        return plan_fail(
            line,
            "the shapes come to more than %d polygons (the limit for a file of %.0f bytes; larger "
            "tolerances make fewer)",
            most, shapes->file_size);
    if (shape->polygon_count == 0)
        return plan_fail(line, "nothing of the shape can be seen (allowed: one with an area)");
    return true;
}

CurvedShape *plan_add_shape(PlanLine *line, PlanModels *models, CurvedKind kind, int material,
                            double tolerance) {
    Building *shapes = &models->shapes;
    CurvedShape *shape = ARENA_PUSH(line->arena, shapes->shapes, shapes->shape_count, shapes->shape_capacity);
    *shape = (CurvedShape){
        .kind = kind, .object = shapes->object_count - 1, .material = material, .tolerance = tolerance};
    return shape;
}

static bool add_ball(PlanLine *line, PlanModels *models, Vec3 centre, Vec3 radii, double angle, int material,
                     double tolerance) {
    double c = cos(angle), s = sin(angle);
    CurvedShape *shape = plan_add_shape(line, models, CURVED_SPHERE, material, tolerance);
    shape->frame = (CurvedFrame){
        centre, {vec3(c * radii.x, s * radii.x, 0), vec3(-s * radii.y, c * radii.y, 0), vec3(0, 0, radii.z)}};
    return plan_tessellate(line, models);
}

bool plan_read_sphere(PlanLine *line, PlanModels *models) {
    int material;
    Vec3 centre;
    double radius = 0, tolerance = PLAN_TOLERANCE;
    PlanOption options[] = {{.word = "radius",
                             .kind = PLAN_LENGTH,
                             .out = &radius,
                             .min = LEAST_RADIUS,
                             .max = MOST_RADIUS,
                             .required = true},
                            PLAN_TOLERANCE_WORD(tolerance)};
    return plan_material(line, &material) && plan_place(line, "the centre", true, &centre) &&
           plan_options(line, options, 2) &&
           add_ball(line, models, centre, vec3(radius, radius, radius), 0, material, tolerance);
}

bool plan_read_ellipsoid(PlanLine *line, PlanModels *models) {
    int material;
    Vec3 centre, radii = {0};
    double angle = 0, tolerance = PLAN_TOLERANCE;
    PlanOption options[] = {{.word = "radii",
                             .kind = PLAN_TRIPLE,
                             .out = &radii,
                             .min = LEAST_RADIUS,
                             .max = MOST_RADIUS,
                             .required = true},
                            {.word = "angle", .kind = PLAN_ANGLE, .out = &angle, .min = -360, .max = 360},
                            PLAN_TOLERANCE_WORD(tolerance)};
    return plan_material(line, &material) && plan_place(line, "the centre", true, &centre) &&
           plan_options(line, options, 3) &&
           add_ball(line, models, centre, radii, angle, material, tolerance);
}

// ---- cylinders and cones

bool plan_add_round(PlanLine *line, PlanModels *models, Vec2 centre, const double z[2], double radius,
                    double tolerance, const bool disc[2], int material) {
    if (z[0] == z[1]) return plan_fail(line, "the cylinder has no height (allowed: the upper one above)");
    CurvedShape *shape = plan_add_shape(line, models, CURVED_CYLINDER, material, tolerance);
    shape->frame = (CurvedFrame){vec3(centre.x, centre.y, z[0]),
                                 {vec3(radius, 0, 0), vec3(0, radius, 0), vec3(0, 0, z[1] - z[0])}};
    shape->disc[0] = disc[0];
    shape->disc[1] = disc[1];
    return plan_tessellate(line, models);
}

// Two directions across `axis`, right-handed with it.
static void across(Vec3 axis, double length, Vec3 out[2]) {
    Vec3 n = vec3_normalize(axis), helper = fabs(n.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    out[1] = vec3_scale(vec3_normalize(vec3_cross(n, helper)), length);
    out[0] = vec3_scale(vec3_cross(vec3_normalize(out[1]), n), length);
}

enum { TOP = 1, BOTTOM = 2 };

bool plan_read_cone(PlanLine *line, PlanModels *models) {
    int material;
    Vec3 foot, head;
    double radius = 0, top = 0, tolerance = PLAN_TOLERANCE;
    unsigned without = 0;
    PlanOption options[] = {{.word = "radius",
                             .kind = PLAN_LENGTH,
                             .out = &radius,
                             .min = LEAST_RADIUS,
                             .max = MOST_RADIUS,
                             .required = true},
                            {.word = "top", .kind = PLAN_LENGTH, .out = &top, .min = 0, .max = MOST_RADIUS},
                            {.word = "without", .kind = PLAN_SET, .out = &without, .words = "top bottom"},
                            PLAN_TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !plan_place(line, "the middle of the foot", true, &foot) ||
        !plan_place(line, "the middle of the top", true, &head) || !plan_options(line, options, 4))
        return false;
    if (vec3_length(vec3_sub(head, foot)) < LEAST_RADIUS)
        return plan_fail(line, "the cone is %.4g metres high (allowed: at least %g)",
                         vec3_length(vec3_sub(head, foot)), LEAST_RADIUS);
    // The wider end is at z = 0 of the shape's own frame.
    bool upside = top > radius;
    double wide = upside ? top : radius, narrow = upside ? radius : top;
    CurvedShape *shape =
        plan_add_shape(line, models, narrow == wide ? CURVED_CYLINDER : CURVED_CONE, material, tolerance);
    shape->top = narrow / wide;
    shape->disc[upside] = !(without & BOTTOM);
    shape->disc[!upside] = !(without & TOP) && top > 0;
    shape->frame.origin = upside ? head : foot;
    shape->frame.axis[2] = upside ? vec3_sub(foot, head) : vec3_sub(head, foot);
    across(shape->frame.axis[2], wide, shape->frame.axis);
    return plan_tessellate(line, models);
}

// ---- lathe

// The quarter of a unit circle from one axis to the next, exactly: the rational quadratic one raised by a degree (L. Piegl &
// W. Tiller, A menagerie of rational B-spline circles, 1989).
static CurvedControl quarter(int i, int quarter, double radius, double z, Vec3 centre) {
    const double half = sqrt(0.5), far = 2 * half / (1 + 2 * half), weight = (1 + 2 * half) / 3;
    const double x[4] = {1, 1, far, 0}, y[4] = {0, far, 1, 1}, w[4] = {1, weight, weight, 1};
    static const int COSINE[4] = {1, 0, -1, 0}, SINE[4] = {0, 1, 0, -1};
    double c = COSINE[quarter], s = SINE[quarter];
    Vec3 at = vec3(radius * (c * x[i] - s * y[i]), radius * (s * x[i] + c * y[i]), z);
    return (CurvedControl){vec3_add(centre, at), w[i]};
}

// A segment of the profile, turned a quarter.
static void add_quarter(PlanLine *line, PlanModels *models, const Vec2 profile[4], int which, Vec3 centre,
                        int material, double tolerance) {
    Building *shapes = &models->shapes;
    CurvedShape *shape = plan_add_shape(line, models, CURVED_PATCH, material, tolerance);
    shape->first_control = shapes->control_count;
    for (int k = 0; k < PATCH_CONTROLS; k++) {
        Vec2 at = profile[k / 4];
        *ARENA_PUSH(line->arena, shapes->controls, shapes->control_count, shapes->control_capacity) =
            quarter(k % 4, which, at.x, at.y, centre);
    }
}

bool plan_read_lathe(PlanLine *line, PlanModels *models) {
    int material;
    Vec3 centre;
    double tolerance = PLAN_TOLERANCE;
    PlanShape profile = {0};
    PlanOption options[] = {{.word = "profile", .kind = PLAN_SHAPE, .out = &profile, .required = true},
                            PLAN_TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !plan_place(line, "the middle", false, &centre) ||
        !plan_options(line, options, 2))
        return false;
    if (profile.count < 4 || profile.count % 3 != 1)
        return plan_fail(line,
                         "the profile has %d points r,z (allowed: 4, 7, 10, ...: cubic curves end to end)",
                         profile.count);
    for (int i = 0; i < profile.count; i++) {
        if (profile.points[i].x >= 0) continue;
        return plan_fail(line, "point %d of the profile has radius %g (allowed: at least 0)", i + 1,
                         profile.points[i].x);
    }
    for (int k = 0; k + 3 < profile.count; k += 3) {
        const char *what = arena_format(line->arena, "part %d of the profile", k / 3 + 1);
        for (int q = 0; q < 4; q++) {
            add_quarter(line, models, profile.points + k, q, centre, material, tolerance);
            if (q == 0 && !plan_check_patch(line, models, what)) return false;
            if (!plan_tessellate(line, models)) return false;
        }
    }
    return true;
}

// ---- in a building

static void stand_patch(Arena *arena, const Building *from, const PlanTurn *turn, CurvedShape *shape,
                        Building *b) {
    const CurvedControl *control = from->controls + shape->first_control;
    int first_trim = shape->first_trim;
    bool mirror = turn->stand.mirror;
    shape->first_control = b->control_count;
    for (int i = 0; i < PATCH_CONTROLS; i++) {
        // Mirrored, u runs the other way, so that the normal stays outside.
        CurvedControl c = control[mirror ? i / 4 * 4 + 3 - i % 4 : i];
        c.point = plan_turn_point(turn, c.point);
        *ARENA_PUSH(arena, b->controls, b->control_count, b->control_capacity) = c;
    }
    shape->first_trim = b->trim_count;
    for (int i = 0; i < shape->trim_count; i++) {
        CurvedTrim t = from->trims[first_trim + i];
        for (int k = 0; mirror && k < 4; k++) t.point[k].x = 1 - t.point[k].x;
        *ARENA_PUSH(arena, b->trims, b->trim_count, b->trim_capacity) = t;
    }
}

static void stand_balls(Arena *arena, const Building *from, const PlanTurn *turn, CurvedShape *shape,
                        Building *b) {
    const CurvedBall *balls = from->balls + shape->first_ball;
    shape->first_ball = b->ball_count;
    for (int i = 0; i < shape->ball_count; i++) {
        CurvedBall ball = balls[i];
        ball.centre = plan_turn_point(turn, ball.centre);
        *ARENA_PUSH(arena, b->balls, b->ball_count, b->ball_capacity) = ball;
    }
}

void plan_stand_shapes(Arena *arena, const PlanModels *models, int model, const PlanTurn *turn,
                       const int *placed, Building *b) {
    const Building *from = &models->shapes;
    int first = from->objects[model].first_polygon;
    for (int i = 0; i < from->shape_count; i++) {
        CurvedShape shape = from->shapes[i];
        if (shape.object != model) continue;
        int at = shape.first_polygon - first;
        shape.object = b->object_count - 1;
        shape.first_polygon = placed[at];
        shape.polygon_count = placed[at + shape.polygon_count] - placed[at];
        shape.frame.origin = plan_turn_point(turn, shape.frame.origin);
        for (int k = 0; k < 3; k++) shape.frame.axis[k] = plan_turn_vector(turn, shape.frame.axis[k]);
        if (shape.kind == CURVED_PATCH) stand_patch(arena, from, turn, &shape, b);
        if (shape.kind == CURVED_METABALLS) stand_balls(arena, from, turn, &shape, b);
        *ARENA_PUSH(arena, b->shapes, b->shape_count, b->shape_capacity) = shape;
    }
}
