// plan_model.c - the models of .plan files: boxes, prisms, polygons and curved shapes in a model's own frame, and models in a building.
#include "maps/plan/plan_model.h"

#include <float.h>

#include "maps/curved/curved_field.h"
#include "maps/curved/curved_patch.h"
#include "maps/curved/curved_tessellate.h"

enum { MAX_SIDES = 64, MAX_STEPS = 200 };
static const double MAX_FLUX = 1e6;  // W

enum { TOP = 1, BOTTOM = 2, LEFT = 4, RIGHT = 8, FRONT = 16, BACK = 32 };
static const char BOX_FACES[] = "top bottom left right front back";
static const char PRISM_FACES[] = "top bottom";

// A shape that asks for more polygons is refused.
enum { MAX_SHAPE_POLYGONS = 100000 };
// Limits of radii, metres, also of balls and metaballs; the radius of a cone's top may be 0.
static const double LEAST_RADIUS = 0.001, MOST_RADIUS = 100;
// A mesh may exceed its tolerance by this much, metres.
static const double ROUNDING = 1e-9;
enum { MAX_TRIMS = 200, MAX_BALLS = 100 };
static const double LEAST_WEIGHT = 0.001, MOST_WEIGHT = 1000;  // of controls
static const double LEAST_THRESHOLD = 0.001, MOST_THRESHOLD = 100;

// The word by which a line says how far the polygons of a curved shape may lie off it, metres.
#define TOLERANCE_WORD(variable)                                                                             \
    { .word = "tolerance", .kind = PLAN_LENGTH, .out = &(variable), .min = 1e-5, .max = 1 }
#define TOLERANCE 0.002  // where none is given, metres: a silhouette of a vase looks round from across a room

// ---- boxes, prisms, polygons

// Adds the faces of a box except those in `without`, each counter-clockwise seen from outside.
static void add_model_box(Arena *arena, Building *models, Vec3 a, Vec3 b, unsigned without, int material) {
    static const unsigned char CORNERS[6][4] = {{4, 5, 7, 6}, {0, 2, 3, 1}, {0, 4, 6, 2},
                                                {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}};
    for (int side = 0; side < 6; side++) {
        if (without >> side & 1) continue;
        Vec3 v[4];
        for (int i = 0; i < 4; i++) {
            int c = CORNERS[side][i];
            v[i] = vec3(c & 1 ? b.x : a.x, c & 2 ? b.y : a.y, c & 4 ? b.z : a.z);
        }
        building_add_polygon(arena, models, v, 4, material);
    }
}

bool plan_read_box(PlanLine *line, Building *models) {
    Vec3 a, b;
    int material;
    unsigned without = 0;
    PlanOption options[] = {{.word = "without", .kind = PLAN_SET, .out = &without, .words = BOX_FACES}};
    if (!plan_place(line, "the box's lower corner", true, &a) ||
        !plan_place(line, "the box's upper corner", true, &b) || !plan_material(line, &material) ||
        !plan_options(line, options, 1))
        return false;
    if (!(a.x <= b.x && a.y <= b.y && a.z <= b.z))
        return plan_fail(
            line,
            "the box goes from (%g, %g, %g) to (%g, %g, %g) (allowed: lower corner first, so that no "
            "coordinate shrinks)",
            a.x, a.y, a.z, b.x, b.y, b.z);
    add_model_box(line->arena, models, a, b, without, material);
    return true;
}

// Twice the signed area: positive when counter-clockwise.
static double signed_area(const Vec2 *points, int count) {
    double sum = 0;
    for (int i = 1; i + 1 < count; i++)
        sum += vec2_cross(vec2_sub(points[i], points[0]), vec2_sub(points[i + 1], points[0]));
    return sum;
}

static void add_prism(Arena *arena, Building *models, const Vec2 *ring, int count, double z0, double z1,
                      unsigned without, int material) {
    bool flip = signed_area(ring, count) < 0;
    Vec3 *cap = ARENA_ARRAY(arena, Vec3, count);
    for (int i = 0; i < count; i++) {
        Vec2 a = ring[flip ? count - 1 - i : i],
             b = ring[flip ? (2 * count - 2 - i) % count : (i + 1) % count];
        building_add_polygon(arena, models,
                             (Vec3[]){{a.x, a.y, z0}, {b.x, b.y, z0}, {b.x, b.y, z1}, {a.x, a.y, z1}}, 4,
                             material);
        cap[i] = vec3(a.x, a.y, z1);
    }
    if (!(without & TOP)) building_add_polygon(arena, models, cap, count, material);
    for (int i = 0; i < count; i++) {
        Vec2 a = ring[flip ? i : count - 1 - i];
        cap[i] = vec3(a.x, a.y, z0);
    }
    if (!(without & BOTTOM)) building_add_polygon(arena, models, cap, count, material);
}

static bool read_heights(PlanLine *line, double z[2]) {
    if (!plan_number(line, "the lower height", -MAPS_LIMIT, MAPS_LIMIT, "metres", &z[0])) return false;
    return plan_number(line, "the upper height", z[0], MAPS_LIMIT, "metres", &z[1]);
}

bool plan_read_prism(PlanLine *line, Building *models) {
    int material;
    double z[2];
    PlanList ring;
    unsigned without = 0;
    PlanOption options[] = {{.word = "without", .kind = PLAN_SET, .out = &without, .words = PRISM_FACES}};
    if (!plan_material(line, &material) || !read_heights(line, z) ||
        !plan_points(line, "corners", 3, &ring) || !plan_options(line, options, 1))
        return false;
    add_prism(line->arena, models, ring.points, ring.count, z[0], z[1], without, material);
    return true;
}

bool plan_read_poly(PlanLine *line, Building *models) {
    int material, count = 0, capacity = 0;
    Vec3 *vertices = NULL;
    if (!plan_material(line, &material)) return false;
    while (plan_is_point(line, 2)) {
        Vec3 place;
        if (!plan_place(line, "a corner", true, &place)) return false;
        *ARENA_PUSH(line->arena, vertices, count, capacity) = place;
    }
    if (count < 3)
        return plan_fail(line, "the polygon has %d corners (allowed: at least 3, as x,y,z)", count);
    if (!plan_end(line)) return false;
    Plane plane = plane_of_polygon(vertices, count);
    for (int i = 0; i < count; i++) {
        double off = fabs(plane_distance(plane, vertices[i]));
        if (off > MAPS_PLANARITY)
            return plan_fail(line, "corner %d of the polygon lies %.4g m off its plane (limit %g)", i + 1,
                             off, MAPS_PLANARITY);
    }
    building_add_polygon(line->arena, models, vertices, count, material);
    return true;
}

// ---- curved shapes

// Appends the polygons of the last shape. Fails where they are too many, miss the shape's tolerance or have no area.
static bool tessellate(PlanLine *line, Building *models) {
    CurvedShape *shape = &models->shapes[models->shape_count - 1];
    Arena scratch = {0};
    CurvedMesh mesh;
    curved_tessellate(models, shape, shape->tolerance, &scratch, &mesh);
    shape->first_polygon = models->polygon_count;
    int most = building_polygons_allowed(models->file_size);
    bool fine = mesh.tolerance <= shape->tolerance + ROUNDING,
         single = mesh.polygon_count <= MAX_SHAPE_POLYGONS,
         few = single && mesh.polygon_count <= most - models->polygon_count;
    for (int i = 0; fine && few && i < mesh.polygon_count; i++)
        building_add_polygon(line->arena, models, mesh.vertices + mesh.first[i],
                             mesh.first[i + 1] - mesh.first[i], shape->material);
    shape->polygon_count = models->polygon_count - shape->first_polygon;
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
            most, models->file_size);
    if (shape->polygon_count == 0)
        return plan_fail(line, "nothing of the shape can be seen (allowed: one with an area)");
    return true;
}

// Appends a shape to the last model; the caller adds the shape's parts and polygons afterwards.
static CurvedShape *add_shape(PlanLine *line, Building *models, CurvedKind kind, int material,
                              double tolerance) {
    CurvedShape *shape = ARENA_PUSH(line->arena, models->shapes, models->shape_count, models->shape_capacity);
    *shape = (CurvedShape){
        .kind = kind, .object = models->object_count - 1, .material = material, .tolerance = tolerance};
    return shape;
}

static bool add_ball(PlanLine *line, Building *models, Vec3 centre, Vec3 radii, double angle, int material,
                     double tolerance) {
    double c = cos(angle), s = sin(angle);
    CurvedShape *shape = add_shape(line, models, CURVED_SPHERE, material, tolerance);
    shape->frame = (CurvedFrame){
        centre, {vec3(c * radii.x, s * radii.x, 0), vec3(-s * radii.y, c * radii.y, 0), vec3(0, 0, radii.z)}};
    return tessellate(line, models);
}

bool plan_read_sphere(PlanLine *line, Building *models) {
    int material;
    Vec3 centre;
    double radius = 0, tolerance = TOLERANCE;
    PlanOption options[] = {{.word = "radius",
                             .kind = PLAN_LENGTH,
                             .out = &radius,
                             .min = LEAST_RADIUS,
                             .max = MOST_RADIUS,
                             .required = true},
                            TOLERANCE_WORD(tolerance)};
    return plan_material(line, &material) && plan_place(line, "the centre", true, &centre) &&
           plan_options(line, options, 2) &&
           add_ball(line, models, centre, vec3(radius, radius, radius), 0, material, tolerance);
}

bool plan_read_ellipsoid(PlanLine *line, Building *models) {
    int material;
    Vec3 centre, radii = {0};
    double angle = 0, tolerance = TOLERANCE;
    PlanOption options[] = {{.word = "radii",
                             .kind = PLAN_TRIPLE,
                             .out = &radii,
                             .min = LEAST_RADIUS,
                             .max = MOST_RADIUS,
                             .required = true},
                            {.word = "angle", .kind = PLAN_ANGLE, .out = &angle, .min = -360, .max = 360},
                            TOLERANCE_WORD(tolerance)};
    return plan_material(line, &material) && plan_place(line, "the centre", true, &centre) &&
           plan_options(line, options, 3) &&
           add_ball(line, models, centre, radii, angle, material, tolerance);
}

// Two vectors of the given length across `axis`, right-handed with it.
static void across(Vec3 axis, double length, Vec3 out[2]) {
    Vec3 n = vec3_normalize(axis), helper = fabs(n.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    out[1] = vec3_scale(vec3_normalize(vec3_cross(n, helper)), length);
    out[0] = vec3_scale(vec3_cross(vec3_normalize(out[1]), n), length);
}

bool plan_read_cone(PlanLine *line, Building *models) {
    int material;
    Vec3 foot, head;
    double radius = 0, top = 0, tolerance = TOLERANCE;
    unsigned without = 0;
    PlanOption options[] = {{.word = "radius",
                             .kind = PLAN_LENGTH,
                             .out = &radius,
                             .min = LEAST_RADIUS,
                             .max = MOST_RADIUS,
                             .required = true},
                            {.word = "top", .kind = PLAN_LENGTH, .out = &top, .min = 0, .max = MOST_RADIUS},
                            {.word = "without", .kind = PLAN_SET, .out = &without, .words = PRISM_FACES},
                            TOLERANCE_WORD(tolerance)};
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
        add_shape(line, models, narrow == wide ? CURVED_CYLINDER : CURVED_CONE, material, tolerance);
    shape->top = narrow / wide;
    shape->disc[upside] = !(without & BOTTOM);
    shape->disc[!upside] = !(without & TOP) && top > 0;
    shape->frame.origin = upside ? head : foot;
    shape->frame.axis[2] = upside ? vec3_sub(foot, head) : vec3_sub(head, foot);
    across(shape->frame.axis[2], wide, shape->frame.axis);
    return tessellate(line, models);
}

// Appends an upright cylinder about `centre` and its polygons.
static bool add_round(PlanLine *line, Building *models, Vec2 centre, const double z[2], double radius,
                      double tolerance, const bool disc[2], int material) {
    if (z[0] == z[1]) return plan_fail(line, "the cylinder has no height (allowed: the upper one above)");
    CurvedShape *shape = add_shape(line, models, CURVED_CYLINDER, material, tolerance);
    shape->frame = (CurvedFrame){vec3(centre.x, centre.y, z[0]),
                                 {vec3(radius, 0, 0), vec3(0, radius, 0), vec3(0, 0, z[1] - z[0])}};
    shape->disc[0] = disc[0];
    shape->disc[1] = disc[1];
    return tessellate(line, models);
}

bool plan_read_cylinder(PlanLine *line, Building *models) {
    int material, sides = 8;
    Vec2 centre;
    double z[2], radius = 0, tolerance = TOLERANCE;
    unsigned without = 0;
    bool round = false;
    PlanOption options[] = {
        {.word = "radius", .kind = PLAN_LENGTH, .out = &radius, .min = 0.001, .max = 100, .required = true},
        {.word = "sides", .kind = PLAN_WHOLE, .out = &sides, .min = 3, .max = MAX_SIDES},
        {.word = "without", .kind = PLAN_SET, .out = &without, .words = PRISM_FACES},
        {.word = "round", .kind = PLAN_FLAG, .out = &round},
        TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !read_heights(line, z) ||
        !plan_point(line, "the centre", &centre) || !plan_options(line, options, 5))
        return false;
    if (round ? options[1].given : options[4].given)
        return plan_fail(line, "a cylinder with %s (allowed: sides, or round and a tolerance)",
                         round ? "sides that is round" : "a tolerance that is not round");
    if (round)
        return add_round(line, models, centre, z, radius, tolerance,
                         (bool[]){!(without & BOTTOM), !(without & TOP)}, material);
    Vec2 ring[MAX_SIDES];
    for (int i = 0; i < sides; i++) {
        double angle = 2 * M_PI * (i + 0.5) / sides;
        ring[i] = vec2_add(centre, vec2_scale(vec2(cos(angle), sin(angle)), radius));
    }
    add_prism(line->arena, models, ring, sides, z[0], z[1], without, material);
    return true;
}

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

// Refuses a patch whose normals turn by a right angle or more from one sample to the next: no surface that is drawn does so.
static bool check_patch(PlanLine *line, const Building *models, const char *what) {
    enum { SAMPLES = 32 };
    const CurvedControl *control = models->controls + models->shapes[models->shape_count - 1].first_control;
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

// Appends a patch that a segment of the profile sweeps over a quarter turn, the quarter `which` of four.
static void add_quarter(PlanLine *line, Building *models, const Vec2 profile[4], int which, Vec3 centre,
                        int material, double tolerance) {
    CurvedShape *shape = add_shape(line, models, CURVED_PATCH, material, tolerance);
    shape->first_control = models->control_count;
    for (int k = 0; k < PATCH_CONTROLS; k++) {
        Vec2 at = profile[k / 4];
        *ARENA_PUSH(line->arena, models->controls, models->control_count, models->control_capacity) =
            quarter(k % 4, which, at.x, at.y, centre);
    }
}

bool plan_read_lathe(PlanLine *line, Building *models) {
    int material;
    Vec3 centre;
    double tolerance = TOLERANCE;
    PlanList profile = {0};
    PlanOption options[] = {{.word = "profile", .kind = PLAN_SHAPE, .out = &profile, .required = true},
                            TOLERANCE_WORD(tolerance)};
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
            if (q == 0 && !check_patch(line, models, what)) return false;
            if (!tessellate(line, models)) return false;
        }
    }
    return true;
}

// ---- patches with their trims, and metaballs: shapes of several lines, which become polygons when the next statement begins

static bool read_controls(PlanLine *line, Building *models) {
    int count = 0;
    while (plan_is_point(line, 2)) {
        CurvedControl control = {.weight = 1};
        if (!plan_place(line, "a control point", true, &control.point)) return false;
        *ARENA_PUSH(line->arena, models->controls, models->control_count, models->control_capacity) = control;
        count++;
    }
    return count == PATCH_CONTROLS ||
           plan_fail(line, "the patch has %d control points (allowed: %d, four rows of four, as x,y,z)",
                     count, PATCH_CONTROLS);
}

bool plan_read_patch(PlanLine *line, Building *models) {
    int material, first = models->control_count;
    double tolerance = TOLERANCE;
    PlanList weights = {0};
    PlanOption options[] = {
        {.word = "weights", .kind = PLAN_LIST, .out = &weights, .min = LEAST_WEIGHT, .max = MOST_WEIGHT},
        TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !read_controls(line, models) || !plan_options(line, options, 2))
        return false;
    if (weights.count != 0 && weights.count != PATCH_CONTROLS)
        return plan_fail(line, "the patch has %d weights (allowed: %d, or none)", weights.count,
                         PATCH_CONTROLS);
    for (int i = 0; i < weights.count; i++) models->controls[first + i].weight = weights.numbers[i];
    CurvedShape *shape = add_shape(line, models, CURVED_PATCH, material, tolerance);
    shape->first_control = first;
    shape->first_trim = models->trim_count;
    line->open_line = line->number;
    return check_patch(line, models, "the patch");
}

// Appends the curves of a loop; each begins where the curve before it ends.
static void add_trims(PlanLine *line, Building *models, const PlanList *loop, const PlanList *weights) {
    for (int k = 0; k + 3 < loop->count; k += 3) {
        CurvedTrim trim;
        for (int i = 0; i < 4; i++) {
            trim.point[i] = loop->points[k + i];
            trim.weight[i] = weights->count ? weights->numbers[k + i] : 1;
        }
        *ARENA_PUSH(line->arena, models->trims, models->trim_count, models->trim_capacity) = trim;
    }
}

bool plan_read_trim(PlanLine *line, Building *models) {
    CurvedShape *shape = line->open_line ? &models->shapes[models->shape_count - 1] : NULL;
    PlanList loop;
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
    add_trims(line, models, &loop, &weights);
    shape->trim_count = models->trim_count - shape->first_trim;
    return shape->trim_count <= MAX_TRIMS ||
           plan_fail(line, "the patch has %d curves of trims (limit %d)", shape->trim_count, MAX_TRIMS);
}

bool plan_read_metaballs(PlanLine *line, Building *models) {
    int material;
    double threshold = 0, tolerance = TOLERANCE;
    PlanOption options[] = {{.word = "threshold",
                             .kind = PLAN_PURE,
                             .out = &threshold,
                             .min = LEAST_THRESHOLD,
                             .max = MOST_THRESHOLD,
                             .required = true},
                            TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !plan_options(line, options, 2)) return false;
    CurvedShape *shape = add_shape(line, models, CURVED_METABALLS, material, tolerance);
    shape->threshold = threshold;
    shape->first_ball = models->ball_count;
    line->open_line = line->number;
    return true;
}

bool plan_read_ball(PlanLine *line, Building *models) {
    CurvedShape *shape = line->open_line ? &models->shapes[models->shape_count - 1] : NULL;
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
    *ARENA_PUSH(line->arena, models->balls, models->ball_count, models->ball_capacity) = ball;
    shape->ball_count++;
    return true;
}

static bool check_balls(PlanLine *line, const Building *models, const CurvedShape *shape) {
    if (shape->ball_count == 0)
        return plan_fail(line, "the metaballs have no ball (allowed: at least one line 'ball')");
    double peak = curved_field_peak(models->balls + shape->first_ball, shape->ball_count);
    return peak > shape->threshold ||
           plan_fail(line,
                     "the field of the metaballs reaches %.4g, their threshold is %g (allowed: below that)",
                     peak, shape->threshold);
}

bool plan_close_shape(PlanLine *line, Building *models) {
    if (!line->open_line) return true;
    const CurvedShape *shape = &models->shapes[models->shape_count - 1];
    int here = line->number;
    line->number = line->open_line;
    line->open_line = 0;
    if (shape->kind == CURVED_METABALLS && !check_balls(line, models, shape)) return false;
    if (!tessellate(line, models)) return false;
    line->number = here;
    return true;
}

// ---- lights and stairs

bool plan_light(PlanLine *line, const char *name, Light *out) {
    double flux[3] = {0}, radius = 0.05, lumens = 0, turn = 0;
    const char *file = NULL;
    Vec3 at;
    PlanOption options[] = {{.word = "flux", .kind = PLAN_SPECTRUM, .out = flux, .min = 0, .max = MAX_FLUX},
                            {.word = "radius", .kind = PLAN_LENGTH, .out = &radius, .min = 0, .max = 10},
                            {.word = "lumens",
                             .kind = PLAN_PURE,
                             .out = &lumens,
                             .min = 0,
                             .max = MAX_FLUX * LIGHT_LUMENS_PER_WATT},
                            {.word = "photometry", .kind = PLAN_NAME, .out = &file},
                            {.word = "angle", .kind = PLAN_ANGLE, .out = &turn, .min = -360, .max = 360}};
    if (!plan_place(line, "the light's place", true, &at) || !plan_options(line, options, 5)) return false;
    int given = options[0].given + options[2].given;
    if (given > 1 || (given == 0 && !file))
        return plan_fail(line, "a light %s (allowed: flux, or lumens, or a photometry with its own)",
                         given > 1 ? "with both flux and lumens" : "without a flux");
    for (int c = 0; c < 3 && options[2].given; c++) flux[c] = lumens / LIGHT_LUMENS_PER_WATT;
    *out = (Light){.name = name,
                   .position = at,
                   .radius = radius,
                   .flux = {(float)flux[0], (float)flux[1], (float)flux[2]},
                   .object = -1,
                   .file = file,
                   .turn = turn};
    return true;
}

bool plan_read_model_light(PlanLine *line, Building *models) {
    Light light;
    if (!plan_light(line, models->objects[models->object_count - 1].name, &light)) return false;
    light.object = models->object_count - 1;
    *ARENA_PUSH(line->arena, models->lights, models->light_count, models->light_capacity) = light;
    return true;
}

void plan_add_stair(Arena *arena, Building *models, Vec3 size, int steps, int material) {
    double x = size.x / 2, y0 = -size.y / 2, going = size.y / steps, rise = size.z / steps;
    for (int i = 0; i < steps; i++) {
        // Each step is a box down to the floor; the face that the next step covers is left out.
        Vec3 a = vec3(-x, y0 + i * going, 0), b = vec3(x, y0 + (i + 1) * going, (i + 1) * rise);
        add_model_box(arena, models, a, b, BOTTOM | FRONT | (i + 1 < steps ? BACK : 0), material);
        double z = i * rise;
        building_add_polygon(arena, models,
                             (Vec3[]){{a.x, a.y, z}, {b.x, a.y, z}, {b.x, a.y, b.z}, {a.x, a.y, b.z}}, 4,
                             material);
    }
}

void plan_add_ramp(Arena *arena, Building *models, Vec3 size, int material) {
    double x = size.x / 2, y = size.y / 2, z = size.z;
    building_add_polygon(arena, models, (Vec3[]){{-x, -y, 0}, {x, -y, 0}, {x, y, z}, {-x, y, z}}, 4,
                         material);
    building_add_polygon(arena, models, (Vec3[]){{x, y, 0}, {-x, y, 0}, {-x, y, z}, {x, y, z}}, 4, material);
    building_add_polygon(arena, models, (Vec3[]){{-x, y, 0}, {-x, -y, 0}, {-x, y, z}}, 3, material);
    building_add_polygon(arena, models, (Vec3[]){{x, -y, 0}, {x, y, 0}, {x, y, z}}, 3, material);
}

// ---- models in a building

// A stand with the cosine and sine of its angle, to place points and directions of a model.
typedef struct PlanTurn {
    PlanStand stand;
    double cosine, sine;
} PlanTurn;
static Vec3 turn_point(const PlanTurn *t, Vec3 p) {
    double x = t->stand.mirror ? -p.x : p.x;
    Vec3 at = t->stand.at;
    return vec3(at.x + t->cosine * x - t->sine * p.y, at.y + t->sine * x + t->cosine * p.y, at.z + p.z);
}

static Vec3 turn_vector(const PlanTurn *t, Vec3 v) {
    double x = t->stand.mirror ? -v.x : v.x;
    return vec3(t->cosine * x - t->sine * v.y, t->sine * x + t->cosine * v.y, v.z);
}

// Quarter turns are exact: a desk by a wall stays flush with it.
static void turn_by(double angle, double *cosine, double *sine) {
    double quarters = angle / (M_PI / 2), whole = nearbyint(quarters);
    *cosine = cos(angle);
    *sine = sin(angle);
    if (fabs(quarters - whole) > 1e-12) return;
    static const signed char COSINE[4] = {1, 0, -1, 0};
    int q = (int)(whole - 4 * floor(whole / 4));
    *cosine = COSINE[q];
    *sine = COSINE[(q + 3) % 4];
}

static void stand_patch(Arena *arena, const Building *models, const PlanTurn *turn, CurvedShape *shape,
                        Building *b) {
    const CurvedControl *control = models->controls + shape->first_control;
    int first_trim = shape->first_trim;
    bool mirror = turn->stand.mirror;
    shape->first_control = b->control_count;
    for (int i = 0; i < PATCH_CONTROLS; i++) {
        // In a mirrored patch u runs the other way, so that the normal still points outside.
        CurvedControl c = control[mirror ? i / 4 * 4 + 3 - i % 4 : i];
        c.point = turn_point(turn, c.point);
        *ARENA_PUSH(arena, b->controls, b->control_count, b->control_capacity) = c;
    }
    shape->first_trim = b->trim_count;
    for (int i = 0; i < shape->trim_count; i++) {
        CurvedTrim t = models->trims[first_trim + i];
        for (int k = 0; mirror && k < 4; k++) t.point[k].x = 1 - t.point[k].x;
        *ARENA_PUSH(arena, b->trims, b->trim_count, b->trim_capacity) = t;
    }
}

static void stand_balls(Arena *arena, const Building *models, const PlanTurn *turn, CurvedShape *shape,
                        Building *b) {
    const CurvedBall *balls = models->balls + shape->first_ball;
    shape->first_ball = b->ball_count;
    for (int i = 0; i < shape->ball_count; i++) {
        CurvedBall ball = balls[i];
        ball.centre = turn_point(turn, ball.centre);
        *ARENA_PUSH(arena, b->balls, b->ball_count, b->ball_capacity) = ball;
    }
}

// Appends the curved shapes of a model. `placed` [polygons of the model + 1]: the first polygon of the building that each
// polygon of the model became.
static void stand_shapes(Arena *arena, const Building *models, int model, const PlanTurn *turn,
                         const int *placed, Building *b) {
    int first = models->objects[model].first_polygon;
    for (int i = 0; i < models->shape_count; i++) {
        CurvedShape shape = models->shapes[i];
        if (shape.object != model) continue;
        int at = shape.first_polygon - first;
        shape.object = b->object_count - 1;
        shape.first_polygon = placed[at];
        shape.polygon_count = placed[at + shape.polygon_count] - placed[at];
        shape.frame.origin = turn_point(turn, shape.frame.origin);
        for (int k = 0; k < 3; k++) shape.frame.axis[k] = turn_vector(turn, shape.frame.axis[k]);
        if (shape.kind == CURVED_PATCH) stand_patch(arena, models, turn, &shape, b);
        if (shape.kind == CURVED_METABALLS) stand_balls(arena, models, turn, &shape, b);
        *ARENA_PUSH(arena, b->shapes, b->shape_count, b->shape_capacity) = shape;
    }
}

static bool stand_polygon(PlanLine *line, Arena *arena, const Building *models, const Polygon *p,
                          const PlanTurn *turn, Building *b) {
    // The arena keeps what it is asked for: of furniture in thousands of rooms as much as the building itself.
    enum { FEW = 32 };
    Vec3 few[FEW], *corner = p->vertex_count <= FEW ? few : ARENA_ARRAY(arena, Vec3, p->vertex_count);
    for (int k = 0; k < p->vertex_count; k++) {
        int from = turn->stand.mirror ? p->vertex_count - 1 - k : k;
        Vec3 v = turn_point(turn, models->vertices[p->first_vertex + from]);
        if (fabs(v.x) > MAPS_LIMIT || fabs(v.y) > MAPS_LIMIT || fabs(v.z) > MAPS_LIMIT)
            return plan_fail(line, "a corner comes to (%g, %g, %g) (allowed: at most %g m)", v.x, v.y, v.z,
                             MAPS_LIMIT);
        corner[k] = v;
    }
    int most = building_polygons_allowed(b->file_size);
    if (b->polygon_count >= most)
        return plan_fail(line,
                         "the building comes to more than %d polygons (the limit for a file of %.0f bytes)",
                         most, b->file_size);
    Vec2 *places = NULL;
    if (p->texture_map > 0) {
        const TextureMap *map = &models->texture_maps[p->texture_map];
        places = ARENA_ARRAY(arena, Vec2, p->vertex_count);
        for (int k = 0; k < p->vertex_count; k++) {
            int from = turn->stand.mirror ? p->vertex_count - 1 - k : k;
            Vec3 v = models->vertices[p->first_vertex + from];
            places[k] = vec2(vec3_dot(map->u, v) + map->u0, vec3_dot(map->v, v) + map->v0);
        }
    }
    building_add_textured(arena, b, corner, places, p->vertex_count, p->material);
    return true;
}

bool plan_stand_model(PlanLine *line, Arena *arena, const Building *models, int model, const char *name,
                      PlanStand stand, Building *b) {
    const Object *shape = &models->objects[model];
    PlanTurn turn = {.stand = stand};
    turn_by(stand.angle, &turn.cosine, &turn.sine);
    // Where each polygon of the model went, for curved shapes, which are tessellated.
    int *placed = models->shape_count > 0 ? ARENA_ARRAY(arena, int, shape->polygon_count + 1) : NULL;
    int object = building_add_object(arena, b, shape->kind, name);
    for (int i = 0; i < shape->polygon_count; i++) {
        const Polygon *p = &models->polygons[shape->first_polygon + i];
        if (placed) placed[i] = b->polygon_count;
        if (!stand_polygon(line, arena, models, p, &turn, b)) return false;
    }
    if (placed) placed[shape->polygon_count] = b->polygon_count;
    stand_shapes(arena, models, model, &turn, placed, b);
    building_set_proxy(arena, b, stand.angle);
    for (int i = 0; i < models->light_count; i++) {
        Light light = models->lights[i];
        if (light.object != model) continue;
        light.position = turn_point(&turn, light.position);
        light.turn += stand.angle;
        light.name = name;
        light.object = object;
        *ARENA_PUSH(arena, b->lights, b->light_count, b->light_capacity) = light;
    }
    return true;
}
