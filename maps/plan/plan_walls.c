// plan_walls.c - the statements of a .plan file that make walls: rooms, walls, and the openings in them.
#include "maps/plan/plan_file.h"

bool plan_read_room(Plan *plan) {
    PlanLine *line = &plan->line;
    PlanShape shape;
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
    double area = fabs(plan_signed_area(shape.points, shape.count));
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
    for (int i = 0; i < shape.count; i++) plan_push_point(plan, shape.points[i], room.wall_material);
    room.place = plan_place_text(plan, "room", room.name);
    Sketch *s = &plan->sketch;
    *ARENA_PUSH(plan->arena, s->rooms, s->room_count, s->room_capacity) = room;
    return true;
}

// Where the side `offset` to the left of a wall's axis turns at p between the directions u and v (unit), one of
// which is the stretch's `own`.
static Vec2 mitre(Vec2 p, Vec2 u, Vec2 v, Vec2 own, double offset) {
    Vec2 n = vec2(-u.y, u.x), m = vec2(-v.y, v.x), sum = vec2_add(n, m);
    double scale = vec2_dot(sum, sum) / 2;
    // A hairpin's mitre would run away: from 150 degrees on the ends stay square.
    if (scale < 0.15) return vec2_add(p, vec2_scale(vec2(-own.y, own.x), offset));
    return vec2_add(p, vec2_scale(sum, offset / scale));
}

typedef struct WallForm {
    double thickness, z0, z1;
    int material;
} WallForm;

// One stretch of a wall along points i, i + 1 of the axis, mitred with its neighbours.
static void add_stretch(Plan *plan, const PlanShape *axis, int i, bool closed, WallForm form) {
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
                       .angle = atan2(u.y, u.x)};
    wall.place = arena_format(plan->arena, "%s:%d: wall at (%.2f, %.2f)", plan->line.path, plan->line.number,
                              a.x, a.y);
    for (int k = 0; k < 4; k++) plan_push_point(plan, corner[k], form.material);
    *ARENA_PUSH(plan->arena, s->walls, s->wall_count, s->wall_capacity) = wall;
    *ARENA_PUSH(plan->arena, plan->stretches, plan->stretch_count, plan->stretch_capacity) =
        (Stretch){plan->storey, a, b, form.thickness};
}

bool plan_read_wall(Plan *plan) {
    PlanLine *line = &plan->line;
    const Storey *storey = &plan->b->storeys[plan->storey];
    PlanShape axis;
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

// What doors, passages and windows have in common, behind their name, centre and options.
static bool add_opening(Plan *plan, SketchOpening *opening, double sill, double height, double depth,
                        const PlanShape *shape) {
    Sketch *s = &plan->sketch;
    opening->sill = maps_snap(plan_storey_floor(plan) + sill);
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
        plan_push_point(plan, p, 0);
    }
    opening->place = plan_place_text(plan, opening_kind_name(opening->kind), opening->name);
    *ARENA_PUSH(plan->arena, s->openings, s->opening_count, s->opening_capacity) = *opening;
    *ARENA_PUSH(plan->arena, plan->pending, plan->pending_count, plan->pending_capacity) =
        (Pending){plan->line.number, depth == 0};
    return true;
}

static bool read_opening(Plan *plan, OpeningKind kind) {
    PlanLine *line = &plan->line;
    SketchOpening o = {.kind = kind, .swing = M_PI / 2, .glazed = kind == OPENING_WINDOW};
    double sill = 0, height = 0, depth = 0;
    PlanShape shape = {0};
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
    // Only doors have a leaf: the last five words are theirs.
    int count = kind == OPENING_DOOR ? 12 : 7;
    if (!plan_name(line, "the opening's name", &o.name) || !plan_point(line, "its centre", &o.centre) ||
        !plan_options(line, options, count))
        return false;
    return add_opening(plan, &o, sill, height, depth, &shape);
}

bool plan_read_door(Plan *plan) { return read_opening(plan, OPENING_DOOR); }
bool plan_read_passage(Plan *plan) { return read_opening(plan, OPENING_PASSAGE); }
bool plan_read_window(Plan *plan) { return read_opening(plan, OPENING_WINDOW); }
