// plan_statements.c - statements of .plan files that build: storeys, materials, stairs, lights, inlays, places of models. Rooms, walls and
// openings are in plan_walls.c.
#include "engine/core/predicates.h"
#include "maps/plan/plan_file.h"

static const double MAX_EMISSION = 1e6;  // W/m^2
static const double MAX_INDEX = 4;       // of refraction: germanium's
static const double ROUNDING = 1e-6;     // of reflectances, which are floats

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
    double alpha = 1, emission[3] = {0}, mirror = 0, refraction = 0;
    PlanOption options[] = {
        {.word = "alpha", .kind = PLAN_PURE, .out = &alpha, .min = 0, .max = 1},
        {.word = "emission", .kind = PLAN_SPECTRUM, .out = emission, .min = 0, .max = MAX_EMISSION},
        {.word = "mirror", .kind = PLAN_PURE, .out = &mirror, .min = 0, .max = 1},
        {.word = "index", .kind = PLAN_PURE, .out = &refraction, .min = 1, .max = MAX_INDEX}};
    if (!plan_name(line, "the material's name", &material.name) ||
        !read_reflectance(line, &material.reflectance) || !plan_options(line, options, 4))
        return false;
    const Rgb *r = &material.reflectance;
    double most = (double)fmaxf(r->r, fmaxf(r->g, r->b));
    if (most + mirror > 1 + ROUNDING)
        return plan_fail(line, "a reflectance of %.3g and a mirror of %g make %.3g (allowed: at most 1)",
                         most, mirror, most + mirror);
    if (refraction > 0 && alpha == 1)
        return plan_fail(line,
                         "an index of %g without alpha (allowed: alpha below 1, so that one sees through)",
                         refraction);
    material.alpha = (float)alpha;
    material.mirror = (float)mirror;
    material.index = (float)refraction;
    material.emission = (Rgb){(float)emission[0], (float)emission[1], (float)emission[2]};
    int index = building_add_material(plan->arena, plan->b, material);
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
    PlanShape shape;
    const char *name;
    if (!plan_name(&plan->line, "the stairwell's name", &name) ||
        !plan_points(&plan->line, "corners", 3, &shape) || !plan_end(&plan->line))
        return false;
    Sketch *s = &plan->sketch;
    SketchCutout cutout = {plan->storey, s->point_count, shape.count,
                           plan_place_text(plan, "stairwell", name)};
    for (int i = 0; i < shape.count; i++) plan_push_point(plan, shape.points[i], 0);
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
    PlanModels one = {0};
    building_add_object(plan->arena, &one.shapes, OBJECT_STAIR, name);
    PlanStand stand = {vec3(at.x, at.y, plan_storey_floor(plan) + at.z), angle, false};
    // Beyond half of all polygons allowed a flight is one slope: more steps do not make a building more usable.
    if (plan->stair_polygons <= building_polygons_allowed(plan->b->file_size) / 2) {
        plan_add_stair(plan->arena, &one, size, steps, material);
    } else {
        plan_add_ramp(plan->arena, &one, size, material);
        if (plan->ramp_count++ == 0) {
            plan->first_ramp = stand.at;
            plan->first_ramp_place = plan_place_text(plan, "stair", name);
        }
    }
    plan->stair_polygons += one.shapes.polygon_count;
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
    light.position.z += plan_storey_floor(plan);
    *ARENA_PUSH(plan->arena, plan->b->lights, plan->b->light_count, plan->b->light_capacity) = light;
    return true;
}

static void push_inlay(Plan *plan, const PlanShape *shape, double z, int material) {
    Building *b = plan->b;
    Inlay inlay = {b->point_count, shape->count, z, material};
    bool flip = plan_signed_area(shape->points, shape->count) < 0;
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
    PlanShape shape;
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
    double area = plan_signed_area(shape.points, shape.count);
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
    int model = plan_find(&plan->models.names, model_name);
    if (model < 0)
        return plan_fail(line, "no model '%.60s' (allowed: one of the %d defined above)", model_name,
                         plan->models.names.count);
    if (!plan_place(line, "its place", false, &stand.at) || !plan_options(line, options, 3)) return false;
    stand.at.z += plan_storey_floor(plan);
    return plan_stand_model(line, plan->arena, &plan->models, model, name ? name : model_name, stand,
                            plan->b);
}
