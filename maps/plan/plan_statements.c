// plan_statements.c - most statements of .plan files: storeys, materials, stairs, lights, inlays and places of models; rooms, walls
// and openings; views, tours and the start.
#include "maps/plan/plan_file.h"

#include "engine/core/box_tree.h"

// Limits of the format, metres.
#define PLAN_MAX_HEIGHT 1000.0   // of storeys, walls, openings
#define PLAN_MAX_THICKNESS 10.0  // of walls and slabs
#define PLAN_MAX_OPENING 100.0   // width
#define PLAN_MIN_SIZE 0.01       // of things that must have a size

static const double MAX_EMISSION = 1e6;  // W/m^2
static const double MAX_INDEX = 4;       // of refraction: germanium's
static const double ROUNDING = 1e-6;     // of reflectances, which are floats

// `house.plan:12: door pantry`
static const char *place_text(Plan *plan, const char *what, const char *name) {
    return arena_format(plan->arena, "%s:%d: %s %s", plan->line.path, plan->line.number, what, name);
}

static double storey_floor(const Plan *plan) { return plan->b->storeys[plan->storey].floor; }

// Appends a point to the sketch.
static void push_point(Plan *plan, Vec2 point, int material) {
    Sketch *s = &plan->sketch;
    int edges = s->point_count;
    *ARENA_PUSH(plan->arena, s->edge_material, edges, s->edge_capacity) = material;
    *ARENA_PUSH(plan->arena, s->points, s->point_count, s->point_capacity) = point;
}

// Positive where the points run counter-clockwise.
static double signed_area(const Vec2 *points, int count) {
    double sum = 0;
    for (int i = 1; i + 1 < count; i++)
        sum += vec2_cross(vec2_sub(points[i], points[0]), vec2_sub(points[i + 1], points[0]));
    return sum / 2;
}

// ---- storeys, materials, stairs, lights, inlays, places of models

bool plan_read_storey(Plan *plan) {
    Storey storey = {.slab = 0.25};
    PlanOption options[] = {
        {.word = "floor",
         .kind = PLAN_LENGTH,
         .out = &storey.floor,
         .min = -1e5,
         .max = 1e5,
         .required = true},
        {.word = "height",
         .kind = PLAN_LENGTH,
         .out = &storey.height,
         .min = 0.1,
         .max = PLAN_MAX_HEIGHT,
         .required = true},
        {.word = "slab", .kind = PLAN_LENGTH, .out = &storey.slab, .min = 0, .max = PLAN_MAX_THICKNESS}};
    PlanLine *line = &plan->line;
    if (!plan_name(line, "the storey's name", &storey.name) || !plan_options(line, options, 3)) return false;
    storey.floor = maps_snap(storey.floor);
    storey.height = maps_snap(storey.height);
    storey.slab = maps_snap(storey.slab);
    plan->storey = plan->b->storey_count;
    *ARENA_PUSH(plan->arena, plan->b->storeys, plan->b->storey_count, plan->b->storey_capacity) = storey;
    return plan_declare(line, &plan->storeys, "storey", storey.name, plan->storey);
}

// `#RRGGBB`, or -1.
static long colour_of(const char *word) {
    static const char DIGITS[] = "0123456789abcdef0123456789ABCDEF";
    if (word[0] != '#' || strlen(word) != 7) return -1;
    long colour = 0;
    for (int i = 1; i < 7; i++) {
        const char *digit = strchr(DIGITS, word[i]);
        if (!digit) return -1;
        colour = 16 * colour + (digit - DIGITS) % 16;
    }
    return colour;
}

static bool read_reflectance(PlanLine *line, Rgb *out) {
    double r[3];
    if (plan_is(line, "reflectance")) {
        line->next++;
        if (!plan_spectrum(line, "reflectance", 0, (double)MAPS_MAX_REFLECTANCE, r)) return false;
        *out = (Rgb){fminf((float)r[0], MAPS_MAX_REFLECTANCE), fminf((float)r[1], MAPS_MAX_REFLECTANCE),
                     fminf((float)r[2], MAPS_MAX_REFLECTANCE)};
        return true;
    }
    const char *word = line->next < line->count ? line->words[line->next] : "the end of the line";
    long colour = colour_of(word);
    if (colour < 0)
        return plan_fail(line, "the colour is '%.60s' (allowed: #RRGGBB, or reflectance and 1 or 3 numbers)",
                         word);
    *out = maps_colour((unsigned)colour);
    line->next++;
    return true;
}

bool plan_read_material(Plan *plan) {
    PlanLine *line = &plan->line;
    Material material = {.alpha = 1};
    PlanPaper paper = {0};
    double alpha = 1, emission[3] = {0}, mirror = 0, refraction = 0;
    PlanOption options[] = {
        {.word = "alpha", .kind = PLAN_PURE, .out = &alpha, .min = 0, .max = 1},
        {.word = "emission", .kind = PLAN_SPECTRUM, .out = emission, .min = 0, .max = MAX_EMISSION},
        {.word = "mirror", .kind = PLAN_PURE, .out = &mirror, .min = 0, .max = 1},
        {.word = "index", .kind = PLAN_PURE, .out = &refraction, .min = 1, .max = MAX_INDEX},
        {.word = "texture", .kind = PLAN_NAME, .out = &paper.file},
        {.word = "width",
         .kind = PLAN_LENGTH,
         .out = &paper.width,
         .min = PLAN_MIN_SIZE,
         .max = PLAN_MAX_HEIGHT},
        {.word = "height",
         .kind = PLAN_LENGTH,
         .out = &paper.height,
         .min = PLAN_MIN_SIZE,
         .max = PLAN_MAX_HEIGHT},
        {.word = "angle", .kind = PLAN_ANGLE, .out = &paper.angle, .min = -360, .max = 360},
        {.word = "right",
         .kind = PLAN_LENGTH,
         .out = &paper.at.x,
         .min = -PLAN_MAX_HEIGHT,
         .max = PLAN_MAX_HEIGHT},
        {.word = "up",
         .kind = PLAN_LENGTH,
         .out = &paper.at.y,
         .min = -PLAN_MAX_HEIGHT,
         .max = PLAN_MAX_HEIGHT}};
    if (!plan_name(line, "the material's name", &material.name) ||
        !read_reflectance(line, &material.reflectance) ||
        !plan_options(line, options, sizeof options / sizeof *options))
        return false;
    material.alpha = (float)alpha;
    if (!plan_add_picture(plan, &paper, &material)) return false;
    const Rgb *r = &material.reflectance;
    double most = (double)fmaxf(r->r, fmaxf(r->g, r->b));
    if (most + mirror > 1 + ROUNDING)
        return plan_fail(line, "a reflectance of %.3g and a mirror of %g make %.3g (allowed: at most 1)",
                         most, mirror, most + mirror);
    if (refraction > 0 && alpha == 1)
        return plan_fail(line,
                         "an index of %g without alpha (allowed: alpha below 1, so that one sees through)",
                         refraction);
    material.mirror = (float)mirror;
    material.index = (float)refraction;
    material.emission = (Rgb){(float)emission[0], (float)emission[1], (float)emission[2]};
    int index = building_add_material(plan->arena, plan->b, material);
    plan_name_picture(plan, index);
    return plan_declare(line, &plan->materials, "material", material.name, index);
}

bool plan_read_ground(Plan *plan) {
    double height = plan->sketch.ground;
    PlanOption options[] = {{.word = "height", .kind = PLAN_LENGTH, .out = &height, .min = -1e5, .max = 1e5}};
    if (plan->ground) return plan_fail(&plan->line, "a second 'ground' (allowed: once)");
    plan->ground = true;
    if (!plan_material(&plan->line, &plan->sketch.ground_material)) return false;
    if (!plan_options(&plan->line, options, 1)) return false;
    plan->sketch.ground = maps_snap(height);
    return true;
}

bool plan_read_facade(Plan *plan) {
    return plan_material(&plan->line, &plan->sketch.outer_material) && plan_end(&plan->line);
}

bool plan_read_slabs(Plan *plan) {
    return plan_material(&plan->line, &plan->sketch.slab_material) && plan_end(&plan->line);
}

bool plan_read_stairwell(Plan *plan) {
    PlanList shape;
    const char *name;
    if (!plan_name(&plan->line, "the stairwell's name", &name) ||
        !plan_points(&plan->line, "corners", 3, &shape) || !plan_end(&plan->line))
        return false;
    Sketch *s = &plan->sketch;
    SketchCutout cutout = {plan->storey, s->point_count, shape.count, place_text(plan, "stairwell", name)};
    for (int i = 0; i < shape.count; i++) push_point(plan, shape.points[i], 0);
    *ARENA_PUSH(plan->arena, s->cutouts, s->cutout_count, s->cutout_capacity) = cutout;
    return true;
}

bool plan_read_stair(Plan *plan) {
    PlanLine *line = &plan->line;
    Vec3 at, size = {0};
    int steps = 16, material = 0;
    double angle = 0;
    const char *name;
    PlanOption options[] = {{.word = "angle", .kind = PLAN_ANGLE, .out = &angle, .min = -360, .max = 360},
                            {.word = "width",
                             .kind = PLAN_LENGTH,
                             .out = &size.x,
                             .min = 0.1,
                             .max = PLAN_MAX_OPENING,
                             .required = true},
                            {.word = "depth",
                             .kind = PLAN_LENGTH,
                             .out = &size.y,
                             .min = 0.1,
                             .max = PLAN_MAX_OPENING,
                             .required = true},
                            {.word = "height",
                             .kind = PLAN_LENGTH,
                             .out = &size.z,
                             .min = 0.1,
                             .max = PLAN_MAX_HEIGHT,
                             .required = true},
                            {.word = "steps", .kind = PLAN_WHOLE, .out = &steps, .min = 1, .max = 200},
                            {.word = "material", .kind = PLAN_MATERIAL, .out = &material}};
    if (!plan_name(line, "the stair's name", &name) || !plan_place(line, "its centre", false, &at) ||
        !plan_options(line, options, 6))
        return false;
    Building one = {0};
    building_add_object(plan->arena, &one, OBJECT_STAIR, name);
    PlanStand stand = {vec3(at.x, at.y, storey_floor(plan) + at.z), angle, false};
    // Once flights take half of all polygons allowed, each further flight is one slope: more steps do not make a building more
    // usable.
    if (plan->stair_polygons <= building_polygons_allowed(plan->b->file_size) / 2) {
        plan_add_stair(plan->arena, &one, size, steps, material);
    } else {
        plan_add_ramp(plan->arena, &one, size, material);
        if (plan->ramp_count++ == 0) {
            plan->first_ramp = stand.at;
            plan->first_ramp_place = place_text(plan, "stair", name);
        }
    }
    plan->stair_polygons += one.polygon_count;
    plan_lay_on_polygons(plan, &one, 0, 0);
    return plan_stand_model(line, plan->arena, &one, 0, name, stand, plan->b);
}

void plan_note_ramps(Plan *plan) {
    if (plan->ramp_count == 0) return;
    building_note(plan->arena, plan->b, NOTE_CHANGED, plan->first_ramp,
                  "%d flights of stairs stand as slopes, the first of them %s: their steps would take more "
                  "than half of the %d "
                  "polygons allowed",
                  plan->ramp_count, plan->first_ramp_place, building_polygons_allowed(plan->b->file_size));
}

bool plan_read_light(Plan *plan) {
    const char *name;
    Light light;
    if (!plan_name(&plan->line, "the light's name", &name) || !plan_light(&plan->line, name, &light))
        return false;
    light.position.z += storey_floor(plan);
    *ARENA_PUSH(plan->arena, plan->b->lights, plan->b->light_count, plan->b->light_capacity) = light;
    return true;
}

static void push_inlay(Plan *plan, const PlanList *shape, double z, int material) {
    Building *b = plan->b;
    Inlay inlay = {b->point_count, shape->count, z, material};
    bool flip = signed_area(shape->points, shape->count) < 0;
    for (int i = 0; i < shape->count; i++) {
        int edges = b->point_count;
        *ARENA_PUSH(plan->arena, b->edge_material, edges, b->edge_capacity) = material;
        *ARENA_PUSH(plan->arena, b->points, b->point_count, b->point_capacity) =
            shape->points[flip ? shape->count - 1 - i : i];
    }
    *ARENA_PUSH(plan->arena, b->inlays, b->inlay_count, b->inlay_capacity) = inlay;
}

bool plan_read_inlay(Plan *plan) {
    PlanLine *line = &plan->line;
    const Storey *storey = &plan->b->storeys[plan->storey];
    PlanList shape;
    int material;
    double z = 0;
    if (!plan_material(line, &material)) return false;
    if (plan_is(line, "floor") || plan_is(line, "ceiling")) {
        z = plan_is(line, "ceiling") ? storey->height : 0;
        line->next++;
    } else if (!plan_number(line, "the inlay's height (or 'floor', 'ceiling')", -PLAN_MAX_HEIGHT,
                            PLAN_MAX_HEIGHT, "metres", &z)) {
        return false;
    }
    if (!plan_points(line, "corners", 3, &shape) || !plan_end(line)) return false;
    for (int i = 0; i < shape.count; i++)
        shape.points[i] = vec2(maps_snap(shape.points[i].x), maps_snap(shape.points[i].y));
    double area = signed_area(shape.points, shape.count);
    int turn = area > 0 ? 1 : -1;
    for (int i = 0; i < shape.count; i++) {
        Vec2 p = shape.points[i], q = shape.points[(i + 1) % shape.count],
             r = shape.points[(i + 2) % shape.count];
        if (area == 0 || orient2d(p, q, r) * turn < 0)
            return plan_fail(
                line, "the inlay is not convex at %g,%g (allowed: a convex polygon with an area)", q.x, q.y);
    }
    push_inlay(plan, &shape, maps_snap(storey->floor + z), material);
    return true;
}

bool plan_read_place(Plan *plan) {
    PlanLine *line = &plan->line;
    const char *model_name, *name = NULL;
    PlanStand stand = {0};
    PlanOption options[] = {
        {.word = "angle", .kind = PLAN_ANGLE, .out = &stand.angle, .min = -360, .max = 360},
        {.word = "mirror", .kind = PLAN_FLAG, .out = &stand.mirror},
        {.word = "name", .kind = PLAN_NAME, .out = &name}};
    if (!plan_name(line, "the model's name", &model_name)) return false;
    int model = plan_find(&plan->model_names, model_name);
    if (model < 0)
        return plan_fail(line, "no model '%.60s' (allowed: one of the %d defined above)", model_name,
                         plan->model_names.count);
    if (!plan_place(line, "its place", false, &stand.at) || !plan_options(line, options, 3)) return false;
    stand.at.z += storey_floor(plan);
    return plan_stand_model(line, plan->arena, &plan->models, model, name ? name : model_name, stand,
                            plan->b);
}

// ---- rooms, walls, and the openings in them

// A stretch of explicit wall, to fit openings into.
typedef struct Stretch {
    int storey;
    Vec2 a, b;
    double thickness;
} Stretch;

bool plan_read_room(Plan *plan) {
    PlanLine *line = &plan->line;
    PlanList shape;
    double foot = NAN, height = NAN;
    SketchRoom room = {.storey = plan->storey};
    PlanOption options[] = {
        {.word = "floor", .kind = PLAN_MATERIAL, .out = &room.floor_material},
        {.word = "ceiling", .kind = PLAN_MATERIAL, .out = &room.ceiling_material},
        {.word = "walls", .kind = PLAN_MATERIAL, .out = &room.wall_material},
        {.word = "wall",
         .kind = PLAN_LENGTH,
         .out = &room.wall,
         .min = PLAN_MIN_SIZE,
         .max = PLAN_MAX_THICKNESS},
        {.word = "foot", .kind = PLAN_LENGTH, .out = &foot, .min = -PLAN_MAX_HEIGHT, .max = PLAN_MAX_HEIGHT},
        {.word = "height", .kind = PLAN_LENGTH, .out = &height, .min = 0.1, .max = PLAN_MAX_HEIGHT}};
    if (!plan_name(line, "the room's name", &room.name) || !plan_points(line, "corners", 3, &shape) ||
        !plan_options(line, options, 6))
        return false;
    double area = fabs(signed_area(shape.points, shape.count));
    if (!(area >= PLAN_MIN_SIZE))
        return plan_fail(line, "room %s has an area of %.4g m^2 (allowed: at least %g)", room.name, area,
                         PLAN_MIN_SIZE);
    const Storey *storey = &plan->b->storeys[plan->storey];
    if (isfinite(foot) || isfinite(height)) {
        room.z0 = maps_snap(storey->floor + (isfinite(foot) ? foot : 0));
        room.z1 = isfinite(height) ? maps_snap(room.z0 + height) : storey->floor + storey->height;
        if (!(room.z1 > room.z0))
            return plan_fail(line,
                             "room %s has its floor at %g m and its ceiling at %g m (allowed: floor below)",
                             room.name, room.z0, room.z1);
    } else {
        room.z0 = room.z1 = NAN;
    }
    room.first_point = plan->sketch.point_count;
    room.point_count = shape.count;
    for (int i = 0; i < shape.count; i++) push_point(plan, shape.points[i], room.wall_material);
    room.place = place_text(plan, "room", room.name);
    Sketch *s = &plan->sketch;
    *ARENA_PUSH(plan->arena, s->rooms, s->room_count, s->room_capacity) = room;
    return true;
}

// The corner of the wall's side, `offset` to the left of its axis, where the axis turns at p from direction u to
// direction v (unit). `own` is the direction of the stretch itself: u or v.
static Vec2 mitre(Vec2 p, Vec2 u, Vec2 v, Vec2 own, double offset) {
    Vec2 n = vec2(-u.y, u.x), m = vec2(-v.y, v.x), sum = vec2_add(n, m);
    double scale = vec2_dot(sum, sum) / 2;
    // The mitre of a hairpin would be very long: for turns from 150 degrees on, the ends stay square.
    if (scale < 0.15) return vec2_add(p, vec2_scale(vec2(-own.y, own.x), offset));
    return vec2_add(p, vec2_scale(sum, offset / scale));
}

typedef struct WallForm {
    double thickness, z0, z1;
    int material;
} WallForm;

// Adds one stretch of a wall along points i, i + 1 of the axis, mitred with its neighbours.
static void add_stretch(Plan *plan, const PlanList *axis, int i, bool closed, WallForm form) {
    Vec2 a = axis->points[i], b = axis->points[i + 1];
    int last = axis->count - 1,
        before = i > 0    ? i - 1
                 : closed ? last - 1
                          : -1,
        after = i + 2 <= last ? i + 2
                : closed      ? 1
                              : -1;
    Vec2 u = vec2_scale(vec2_sub(b, a), 1 / vec2_length(vec2_sub(b, a))), in = u, out = u;
    if (before >= 0) in = vec2_sub(a, axis->points[before]);
    if (after >= 0) out = vec2_sub(axis->points[after], b);
    in = vec2_scale(in, 1 / vec2_length(in));
    out = vec2_scale(out, 1 / vec2_length(out));
    double h = form.thickness / 2;
    Vec2 corner[4] = {mitre(a, in, u, u, -h), mitre(b, u, out, u, -h), mitre(b, u, out, u, h),
                      mitre(a, in, u, u, h)};
    Sketch *s = &plan->sketch;
    SketchWall wall = {.storey = plan->storey,
                       .first_point = s->point_count,
                       .point_count = 4,
                       .z0 = form.z0,
                       .z1 = form.z1,
                       .angle = atan2(u.y, u.x),
                       .top_material = s->outer_material};
    wall.place = arena_format(plan->arena, "%s:%d: wall at (%.2f, %.2f)", plan->line.path, plan->line.number,
                              a.x, a.y);
    for (int k = 0; k < 4; k++) push_point(plan, corner[k], form.material);
    *ARENA_PUSH(plan->arena, s->walls, s->wall_count, s->wall_capacity) = wall;
    *ARENA_PUSH(plan->arena, plan->stretches, plan->stretch_count, plan->stretch_capacity) =
        (Stretch){plan->storey, a, b, form.thickness};
}

bool plan_read_wall(Plan *plan) {
    PlanLine *line = &plan->line;
    const Storey *storey = &plan->b->storeys[plan->storey];
    PlanList axis;
    WallForm form = {.material = plan->sketch.outer_material};
    double height = storey->height, foot = 0;
    PlanOption options[] = {
        {.word = "thickness",
         .kind = PLAN_LENGTH,
         .out = &form.thickness,
         .min = 0.001,
         .max = PLAN_MAX_THICKNESS,
         .required = true},
        {.word = "height", .kind = PLAN_LENGTH, .out = &height, .min = PLAN_MIN_SIZE, .max = PLAN_MAX_HEIGHT},
        {.word = "foot", .kind = PLAN_LENGTH, .out = &foot, .min = -PLAN_MAX_HEIGHT, .max = PLAN_MAX_HEIGHT},
        {.word = "material", .kind = PLAN_MATERIAL, .out = &form.material}};
    if (!plan_points(line, "points", 2, &axis) || !plan_options(line, options, 4)) return false;
    form.z0 = maps_snap(storey->floor + foot);
    form.z1 = maps_snap(form.z0 + height);
    for (int i = 0; i + 1 < axis.count; i++) {
        double length = vec2_length(vec2_sub(axis.points[i + 1], axis.points[i]));
        if (!(length >= MAPS_GRID))
            return plan_fail(line, "the wall from (%g, %g) is %g m long (allowed: at least %g)",
                             axis.points[i].x, axis.points[i].y, length, MAPS_GRID);
    }
    bool closed = axis.count > 3 && vec2_equal(axis.points[0], axis.points[axis.count - 1]);
    for (int i = 0; i + 1 < axis.count; i++) add_stretch(plan, &axis, i, closed, form);
    return true;
}

// Adds a door, passage or window, whose name, centre and options have been read.
static bool add_opening(Plan *plan, SketchOpening *opening, double sill, double height, double depth,
                        const PlanList *shape) {
    Sketch *s = &plan->sketch;
    opening->sill = maps_snap(storey_floor(plan) + sill);
    opening->head = maps_snap(opening->sill + height);
    opening->depth = depth;
    opening->storey = plan->storey;
    opening->first_cutout = s->point_count;
    opening->cutout_count = shape->count;
    for (int i = 0; i < shape->count; i++) {
        Vec2 p = shape->points[i];
        if (p.x < 0 || p.x > 1 || p.y < 0 || p.y > 1)
            return plan_fail(&plan->line, "corner %d of the shape is %g,%g (allowed: 0 to 1)", i + 1, p.x,
                             p.y);
        push_point(plan, p, 0);
    }
    opening->place = place_text(plan, opening_kind_name(opening->kind), opening->name);
    *ARENA_APPEND(plan->arena, s->openings, s->opening_count, s->opening_capacity) = *opening;
    *ARENA_PUSH(plan->arena, plan->opening_line, plan->opening_line_count, plan->opening_line_capacity) =
        plan->line.number;
    return true;
}

static bool read_opening(Plan *plan, OpeningKind kind) {
    PlanLine *line = &plan->line;
    SketchOpening o = {.kind = kind, .swing = M_PI / 2, .glazed = kind == OPENING_WINDOW};
    double sill = 0, height = 0, depth = 0;
    PlanList shape = {0};
    PlanOption options[] = {
        {.word = "angle", .kind = PLAN_ANGLE, .out = &o.angle, .min = -360, .max = 360},
        {.word = "width",
         .kind = PLAN_LENGTH,
         .out = &o.width,
         .min = PLAN_MIN_SIZE,
         .max = PLAN_MAX_OPENING,
         .required = true},
        {.word = "height",
         .kind = PLAN_LENGTH,
         .out = &height,
         .min = PLAN_MIN_SIZE,
         .max = PLAN_MAX_HEIGHT,
         .required = true},
        {.word = "sill",
         .kind = PLAN_LENGTH,
         .out = &sill,
         .min = -PLAN_MAX_HEIGHT,
         .max = PLAN_MAX_HEIGHT,
         .required = kind == OPENING_WINDOW},
        {.word = "depth",
         .kind = PLAN_LENGTH,
         .out = &depth,
         .min = PLAN_MIN_SIZE,
         .max = PLAN_MAX_THICKNESS},
        {.word = "shape", .kind = PLAN_SHAPE, .out = &shape},
        {.word = "material", .kind = PLAN_MATERIAL, .out = &o.material},
        {.word = "hinge", .kind = PLAN_CHOICE, .out = &o.hinge, .words = "left right both"},
        {.word = "swing", .kind = PLAN_ANGLE, .out = &o.swing, .min = -180, .max = 180},
        {.word = "slide",
         .kind = PLAN_LENGTH,
         .out = &o.slide,
         .min = -PLAN_MAX_OPENING,
         .max = PLAN_MAX_OPENING},
        {.word = "open", .kind = PLAN_PURE, .out = &o.open, .min = 0, .max = 1},
        {.word = "glazed", .kind = PLAN_FLAG, .out = &o.glazed}};
    // Only doors have a leaf: the last five options are for doors.
    int count = kind == OPENING_DOOR ? 12 : 7;
    if (!plan_name(line, "the opening's name", &o.name) || !plan_point(line, "its centre", &o.centre) ||
        !plan_options(line, options, count))
        return false;
    return add_opening(plan, &o, sill, height, depth, &shape);
}

bool plan_read_door(Plan *plan) { return read_opening(plan, OPENING_DOOR); }
bool plan_read_passage(Plan *plan) { return read_opening(plan, OPENING_PASSAGE); }
bool plan_read_window(Plan *plan) { return read_opening(plan, OPENING_WINDOW); }

// ---- openings put into the walls around them, once all rooms and walls are known

static const double PARALLEL = 0.02;  // sine up to which an opening lies along a wall (about 1 degree)
static const double FIT = 0.002;      // how far outside a wall an opening's centre may lie, metres

// Where walls are, on their storeys: boxes of rooms with the walls around them, and boxes of stretches.
typedef struct Walls {
    BoxTree rooms, stretches;
    BoxHits near;  // found last
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
        // room_face takes the distance to a face at the face's first corner, and a face may be askew by an angle with the sine
        // sqrt(2) PARALLEL: along its length it strays from the opening by this share.
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

// Puts the items of `tree` whose boxes hold an opening's centre into walls->near, in the order of the file. Returns their
// number.
static int find_around(const Plan *plan, const BoxTree *tree, const SketchOpening *o, Walls *walls) {
    Box centre = box_on_storey(&o->centre, 1, o->storey);
    return box_tree_find(tree, centre, plan->arena, &walls->near);
}

// Returns how far from the opening's centre, along `way`, the nearest face of a room's wall lies; INFINITY when no face lies
// within its wall's thickness. `wall` receives the wall's thickness.
static double room_face(const Plan *plan, Walls *walls, const SketchOpening *o, Vec2 way, double *wall) {
    const Sketch *s = &plan->sketch;
    double nearest = INFINITY;
    int count = find_around(plan, &walls->rooms, o, walls);
    for (int r = 0; r < count; r++) {
        const SketchRoom *room = &s->rooms[walls->near.items[r]];
        const Vec2 *p = &s->points[room->first_point];
        double turn = signed_area(p, room->point_count) > 0 ? 1 : -1;
        for (int i = 0; i < room->point_count; i++) {
            Vec2 a = p[i], edge = vec2_sub(p[(i + 1) % room->point_count], a);
            double length = vec2_length(edge), facing = turn * vec2_cross(edge, way);
            // The room must lie beyond its edge, and the edge must run across `way`.
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

// Fits an opening to a stretch of explicit wall that runs along it and holds its centre: the opening takes the wall's depth and is
// centred in it. Returns false where no stretch fits.
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
    if (o->depth > 0 || fit_to_stretch(plan, walls, o, axis)) return true;
    double wall[2] = {0}, face[2];
    for (int s = 0; s < 2; s++)
        face[s] = room_face(plan, walls, o, s ? vec2_scale(normal, -1) : normal, &wall[s]);
    // With rooms on both sides the opening reaches from face to face; with a room on one side it is as deep as that room's wall.
    if (isfinite(face[0]) && !isfinite(face[1])) face[1] = wall[0] - face[0];
    if (isfinite(face[1]) && !isfinite(face[0])) face[0] = wall[1] - face[1];
    double depth = face[0] + face[1];
    if (!(isfinite(depth) && depth >= PLAN_MIN_SIZE)) {
        plan->line.number = plan->opening_line[index];
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

// ---- views, tours, the start

static const double EYE_HEIGHT = 1.6;  // above the floor, metres
static const double DEFAULT_FOV = 70 * (M_PI / 180);

static bool read_eye(Plan *plan, Viewpoint *v) {
    PlanLine *line = &plan->line;
    v->fov = DEFAULT_FOV;
    PlanOption options[] = {
        {.word = "yaw", .kind = PLAN_ANGLE, .out = &v->yaw, .min = -360, .max = 360, .required = true},
        {.word = "pitch", .kind = PLAN_ANGLE, .out = &v->pitch, .min = -90, .max = 90},
        {.word = "fov", .kind = PLAN_ANGLE, .out = &v->fov, .min = 1, .max = 170}};
    if (!plan_place(line, "the eye", true, &v->eye) || !plan_options(line, options, 3)) return false;
    v->eye.z += storey_floor(plan);
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
    plan->start = vec3(at.x, at.y, storey_floor(plan) + EYE_HEIGHT);
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

// Whether q lies in the region's plan: inside an odd number of the region's rings.
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
