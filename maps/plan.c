// plan.c - reads .plan, the line-based text format of maps/README.md, into a sketch and a building.
//
// Each statement is one row of STATEMENTS and one function, here or in plan_walls.c; its optional words are a table
// inside it.
#include "engine/core/predicates.h"
#include "maps/maps.h"
#include "maps/plan_file.h"

static const double MAX_EMISSION = 1e6;  // W/m^2
static const double MAX_INDEX = 4;       // of refraction: germanium's
static const double ROUNDING = 1e-6;     // of reflectances, which are floats
static const double EYE_HEIGHT = 1.6;    // above the floor
static const double DEFAULT_FOV = 70 * (M_PI / 180);
static const char MARK[] = "\xEF\xBB\xBF";  // of UTF-8, with which some editors begin a file
static const char PLAIN[] = "plain";        // the material of what names none
static const unsigned PLAIN_COLOUR = 0xC8C8C8;

// ---- what all share

const char *plan_place_text(Plan *plan, const char *what, const char *name) {
    return arena_format(plan->arena, "%s:%d: %s %s", plan->line.path, plan->line.number, what, name);
}

double plan_storey_floor(const Plan *plan) { return plan->b->storeys[plan->storey].floor; }

void plan_push_point(Plan *plan, Vec2 point, int material) {
    Sketch *s = &plan->sketch;
    int edges = s->point_count;
    *ARENA_PUSH(plan->arena, s->edge_material, edges, s->edge_capacity) = material;
    *ARENA_PUSH(plan->arena, s->points, s->point_count, s->point_capacity) = point;
}

double plan_signed_area(const Vec2 *points, int count) {
    double sum = 0;
    for (int i = 1; i + 1 < count; i++)
        sum += vec2_cross(vec2_sub(points[i], points[0]), vec2_sub(points[i + 1], points[0]));
    return sum / 2;
}

// ---- statements

static bool read_header(Plan *plan) {
    int version;
    if (plan->begun) return plan_fail(&plan->line, "a second 'plan' (allowed: once, as the first statement)");
    plan->begun = true;
    return plan_whole(&plan->line, "the format's version", 1, 1, &version) && plan_end(&plan->line);
}

static bool read_storey(Plan *plan) {
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

static bool read_material(Plan *plan) {
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

static bool read_ground(Plan *plan) {
    double height = plan->sketch.ground;
    PlanOption options[] = {{.word = "height", .kind = PLAN_LENGTH, .out = &height, .min = -1e5, .max = 1e5}};
    if (plan->ground) return plan_fail(&plan->line, "a second 'ground' (allowed: once)");
    plan->ground = true;
    if (!plan_material(&plan->line, &plan->sketch.ground_material)) return false;
    if (!plan_options(&plan->line, options, 1)) return false;
    plan->sketch.ground = maps_snap(height);
    return true;
}

static bool read_facade(Plan *plan) {
    return plan_material(&plan->line, &plan->sketch.outer_material) && plan_end(&plan->line);
}

static bool read_slabs(Plan *plan) {
    return plan_material(&plan->line, &plan->sketch.slab_material) && plan_end(&plan->line);
}

static bool read_stairwell(Plan *plan) {
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

static bool read_stair(Plan *plan) {
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
    plan_add_stair(plan->arena, &one, size, steps, material);
    PlanStand stand = {vec3(at.x, at.y, plan_storey_floor(plan) + at.z), angle, false};
    return plan_stand_model(line, plan->arena, &one, 0, name, stand, plan->b);
}

static bool read_light(Plan *plan) {
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

static bool read_inlay(Plan *plan) {
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

static bool read_place(Plan *plan) {
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

static bool read_view(Plan *plan) {
    Viewpoint view = {0};
    if (!plan_name(&plan->line, "the view's name", &view.name) || !read_eye(plan, &view)) return false;
    Building *b = plan->b;
    *ARENA_PUSH(plan->arena, b->viewpoints, b->viewpoint_count, b->viewpoint_capacity) = view;
    return true;
}

static bool read_start(Plan *plan) {
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

// ---- blocks

static bool read_model(Plan *plan) {
    static const ObjectKind KINDS[] = {OBJECT_FURNITURE, OBJECT_LAMP, OBJECT_STAIR, OBJECT_FRAME,
                                       OBJECT_LOW_WALL};
    PlanLine *line = &plan->line;
    const char *name;
    int kind = 0;
    PlanOption options[] = {
        {.word = "kind", .kind = PLAN_CHOICE, .out = &kind, .words = "furniture lamp stair frame low-wall"}};
    if (!plan_name(line, "the model's name", &name) || !plan_options(line, options, 1)) return false;
    int object = building_add_object(plan->arena, &plan->models.shapes, KINDS[kind], name);
    plan->block = BLOCK_MODEL;
    plan->block_line = line->number;
    return plan_declare(line, &plan->models.names, "model", name, object);
}

static bool read_box(Plan *plan) { return plan_read_box(&plan->line, &plan->models); }
static bool read_prism(Plan *plan) { return plan_read_prism(&plan->line, &plan->models); }
static bool read_cylinder(Plan *plan) { return plan_read_cylinder(&plan->line, &plan->models); }
static bool read_poly(Plan *plan) { return plan_read_poly(&plan->line, &plan->models); }
static bool read_sphere(Plan *plan) { return plan_read_sphere(&plan->line, &plan->models); }
static bool read_ellipsoid(Plan *plan) { return plan_read_ellipsoid(&plan->line, &plan->models); }
static bool read_cone(Plan *plan) { return plan_read_cone(&plan->line, &plan->models); }
static bool read_lathe(Plan *plan) { return plan_read_lathe(&plan->line, &plan->models); }
static bool read_patch(Plan *plan) { return plan_read_patch(&plan->line, &plan->models); }
static bool read_trim(Plan *plan) { return plan_read_trim(&plan->line, &plan->models); }
static bool read_metaballs(Plan *plan) { return plan_read_metaballs(&plan->line, &plan->models); }
static bool read_ball(Plan *plan) { return plan_read_ball(&plan->line, &plan->models); }
static bool read_model_light(Plan *plan) { return plan_read_model_light(&plan->line, &plan->models); }

static bool read_tour(Plan *plan) {
    Tour tour = {.first_viewpoint = plan->b->tour_point_count};
    if (!plan_name(&plan->line, "the tour's name", &tour.name) || !plan_end(&plan->line)) return false;
    *ARENA_PUSH(plan->arena, plan->b->tours, plan->b->tour_count, plan->b->tour_capacity) = tour;
    plan->block = BLOCK_TOUR;
    plan->block_line = plan->line.number;
    return true;
}

static bool read_tour_eye(Plan *plan) {
    Building *b = plan->b;
    Tour *tour = &b->tours[b->tour_count - 1];
    Viewpoint eye = {.name = tour->name};
    if (!read_eye(plan, &eye)) return false;
    *ARENA_PUSH(plan->arena, b->tour_points, b->tour_point_count, b->tour_point_capacity) = eye;
    tour->viewpoint_count++;
    return true;
}

static bool read_end(Plan *plan) {
    const Building *b = plan->b, *shapes = &plan->models.shapes;
    int held = plan->block == BLOCK_TOUR ? b->tours[b->tour_count - 1].viewpoint_count
                                         : shapes->objects[shapes->object_count - 1].polygon_count;
    if (held == 0)
        return plan_fail(&plan->line, "the block of line %d is empty (allowed: at least one %s)",
                         plan->block_line, plan->block == BLOCK_TOUR ? "eye" : "shape with an area");
    plan->block = BLOCK_NONE;
    return plan_end(&plan->line);
}

// ---- the file

typedef struct Statement {
    const char *word;
    Block block;  // it stands in
    bool needs_storey;
    bool (*read)(Plan *plan);
} Statement;

static const Statement STATEMENTS[] = {{"plan", BLOCK_NONE, false, read_header},
                                       {"storey", BLOCK_NONE, false, read_storey},
                                       {"material", BLOCK_NONE, false, read_material},
                                       {"ground", BLOCK_NONE, false, read_ground},
                                       {"facade", BLOCK_NONE, false, read_facade},
                                       {"slabs", BLOCK_NONE, false, read_slabs},
                                       {"room", BLOCK_NONE, true, plan_read_room},
                                       {"wall", BLOCK_NONE, true, plan_read_wall},
                                       {"door", BLOCK_NONE, true, plan_read_door},
                                       {"passage", BLOCK_NONE, true, plan_read_passage},
                                       {"window", BLOCK_NONE, true, plan_read_window},
                                       {"stairwell", BLOCK_NONE, true, read_stairwell},
                                       {"stair", BLOCK_NONE, true, read_stair},
                                       {"light", BLOCK_NONE, true, read_light},
                                       {"inlay", BLOCK_NONE, true, read_inlay},
                                       {"model", BLOCK_NONE, false, read_model},
                                       {"place", BLOCK_NONE, true, read_place},
                                       {"view", BLOCK_NONE, true, read_view},
                                       {"tour", BLOCK_NONE, true, read_tour},
                                       {"start", BLOCK_NONE, true, read_start},
                                       {"box", BLOCK_MODEL, false, read_box},
                                       {"prism", BLOCK_MODEL, false, read_prism},
                                       {"cylinder", BLOCK_MODEL, false, read_cylinder},
                                       {"poly", BLOCK_MODEL, false, read_poly},
                                       {"sphere", BLOCK_MODEL, false, read_sphere},
                                       {"ellipsoid", BLOCK_MODEL, false, read_ellipsoid},
                                       {"cone", BLOCK_MODEL, false, read_cone},
                                       {"lathe", BLOCK_MODEL, false, read_lathe},
                                       {"patch", BLOCK_MODEL, false, read_patch},
                                       {"trim", BLOCK_MODEL, false, read_trim},
                                       {"metaballs", BLOCK_MODEL, false, read_metaballs},
                                       {"ball", BLOCK_MODEL, false, read_ball},
                                       {"light", BLOCK_MODEL, false, read_model_light},
                                       {"end", BLOCK_MODEL, false, read_end},
                                       {"eye", BLOCK_TOUR, true, read_tour_eye},
                                       {"end", BLOCK_TOUR, false, read_end}};
enum { STATEMENT_COUNT = sizeof STATEMENTS / sizeof STATEMENTS[0] };

static bool unknown_statement(Plan *plan, const char *word) {
    static const char *const WHERE[] = {"", " in a model", " in a tour"};
    const char *list = "";
    for (int i = 0; i < STATEMENT_COUNT; i++)
        if (STATEMENTS[i].block == plan->block)
            list = arena_format(plan->arena, "%s%s%s", list, *list ? ", " : "", STATEMENTS[i].word);
    return plan_fail(&plan->line, "unknown statement '%.60s'%s (allowed: %s)", word, WHERE[plan->block],
                     list);
}

// Lines that go on with the shape of the line above.
static bool adds_to_shape(const Statement *s) { return s->read == read_trim || s->read == read_ball; }

static bool read_statement(Plan *plan) {
    PlanLine *line = &plan->line;
    if (line->count == 0) return true;
    const char *word = line->words[line->next++];
    if (!plan->begun && strcmp(word, "plan") != 0)
        return plan_fail(line, "the file begins with '%.60s' (allowed: plan 1)", word);
    for (int i = 0; i < STATEMENT_COUNT; i++) {
        const Statement *statement = &STATEMENTS[i];
        if (statement->block != plan->block || strcmp(statement->word, word) != 0) continue;
        if (statement->needs_storey && plan->storey < 0)
            return plan_fail(line, "'%s' stands before any storey (allowed: after one)", word);
        if (!adds_to_shape(statement) && !plan_close_shape(line, &plan->models)) return false;
        return statement->read(plan);
    }
    return unknown_statement(plan, word);
}

static bool read_lines(Plan *plan, Bytes content) {
    const unsigned char *end = content.data + content.size;
    unsigned char *c = content.data;
    if (content.size >= strlen(MARK) && memcmp(c, MARK, strlen(MARK)) == 0) c += strlen(MARK);
    while (c < end) {
        plan->line.number++;
        unsigned char *newline = memchr(c, '\n', (size_t)(end - c)),
                      *stop = newline ? newline : c + (end - c);
        const unsigned char *zero = memchr(c, 0, (size_t)(stop - c));
        if (zero)
            return plan_fail(&plan->line, "a zero byte at column %d (allowed: text)", (int)(zero - c) + 1);
        size_t length = (size_t)(stop - c);
        if (length > 0 && c[length - 1] == '\r') length--;
        char *text = arena_alloc(plan->arena, length + 1, 1);
        memcpy(text, c, length);
        if (!plan_split(&plan->line, text) || !read_statement(plan)) return false;
        c = stop + 1;
        if (!newline) break;
    }
    if (plan->block != BLOCK_NONE)
        return plan_fail(&plan->line, "the file ends inside the block of line %d (allowed: after its 'end')",
                         plan->block_line);
    if (!plan->begun)
        return plan_fail(&plan->line, "the file holds nothing (allowed: plan 1 and at least one room)");
    if (plan->sketch.room_count == 0)
        return plan_fail(&plan->line, "no room in the file (allowed: at least one)");
    return true;
}

// ---- where a walk begins

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

// What the file says goes before what maps_enclose chose.
static bool set_start(Plan *plan) {
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

static bool read_plan(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Plan *plan = ARENA_ARRAY(arena, Plan, 1);
    plan->line = (PlanLine){.path = path, .materials = &plan->materials, .arena = arena, .error = error};
    plan->arena = arena;
    plan->b = out;
    plan->storey = -1;
    Material plain = {.name = PLAIN, .reflectance = maps_colour(PLAIN_COLOUR), .alpha = 1};
    int index = building_add_material(arena, out, plain);
    if (!plan_declare(&plan->line, &plan->materials, "material", PLAIN, index)) return false;
    if (!read_lines(plan, content)) return false;
    for (int i = 0; i < plan->sketch.opening_count; i++)
        if (!plan_fit_opening(plan, i)) return false;
    Error why = {""};
    if (!maps_enclose(&plan->sketch, out, arena, &why)) return error_set(error, "%s: %.900s", path, why.text);
    return set_start(plan);
}

// A .plan file's first statement is `plan` and a version.
static bool recognise_plan(Bytes content) {
    const char *c = (const char *)content.data;
    if (strncmp(c, MARK, strlen(MARK)) == 0) c += strlen(MARK);
    while (*c == '#' || strchr(" \t\r\n", *c)) {
        if (!*c) return false;
        c += *c == '#' ? strcspn(c, "\n") : 1;
    }
    return strncmp(c, "plan ", 5) == 0;
}

const MapsReader MAPS_READER_PLAN = {
    .name = "plan",
    .suffixes = ".plan",
    .summary = "Enfilade's own text format (maps/README.md)",
    .recognise = recognise_plan,
    .read = read_plan,
};
