// plan_model.c - boxes, prisms, cylinders and single polygons in a model's own frame, and models in a building.
#include "maps/plan/plan_model.h"

enum { MAX_SIDES = 64, MAX_STEPS = 200 };
static const double MAX_FLUX = 1e6;  // W

enum { TOP = 1, BOTTOM = 2, LEFT = 4, RIGHT = 8, FRONT = 16, BACK = 32 };
static const char BOX_FACES[] = "top bottom left right front back";
static const char PRISM_FACES[] = "top bottom";

// The faces of a box but those in `without`, each counter-clockwise from outside.
static void add_model_box(Arena *arena, PlanModels *m, Vec3 a, Vec3 b, unsigned without, int material) {
    static const unsigned char CORNERS[6][4] = {{4, 5, 7, 6}, {0, 2, 3, 1}, {0, 4, 6, 2},
                                                {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}};
    for (int side = 0; side < 6; side++) {
        if (without >> side & 1) continue;
        Vec3 v[4];
        for (int i = 0; i < 4; i++) {
            int c = CORNERS[side][i];
            v[i] = vec3(c & 1 ? b.x : a.x, c & 2 ? b.y : a.y, c & 4 ? b.z : a.z);
        }
        building_add_polygon(arena, &m->shapes, v, 4, material);
    }
}

bool plan_read_box(PlanLine *line, PlanModels *models) {
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

static void add_prism(Arena *arena, PlanModels *m, const Vec2 *ring, int count, double z0, double z1,
                      unsigned without, int material) {
    bool flip = signed_area(ring, count) < 0;
    Vec3 *cap = ARENA_ARRAY(arena, Vec3, count);
    for (int i = 0; i < count; i++) {
        Vec2 a = ring[flip ? count - 1 - i : i],
             b = ring[flip ? (2 * count - 2 - i) % count : (i + 1) % count];
        building_add_polygon(arena, &m->shapes,
                             (Vec3[]){{a.x, a.y, z0}, {b.x, b.y, z0}, {b.x, b.y, z1}, {a.x, a.y, z1}}, 4,
                             material);
        cap[i] = vec3(a.x, a.y, z1);
    }
    if (!(without & TOP)) building_add_polygon(arena, &m->shapes, cap, count, material);
    for (int i = 0; i < count; i++) {
        Vec2 a = ring[flip ? i : count - 1 - i];
        cap[i] = vec3(a.x, a.y, z0);
    }
    if (!(without & BOTTOM)) building_add_polygon(arena, &m->shapes, cap, count, material);
}

static bool read_heights(PlanLine *line, double z[2]) {
    if (!plan_number(line, "the lower height", -MAPS_LIMIT, MAPS_LIMIT, "metres", &z[0])) return false;
    return plan_number(line, "the upper height", z[0], MAPS_LIMIT, "metres", &z[1]);
}

bool plan_read_prism(PlanLine *line, PlanModels *models) {
    int material;
    double z[2];
    PlanShape ring;
    unsigned without = 0;
    PlanOption options[] = {{.word = "without", .kind = PLAN_SET, .out = &without, .words = PRISM_FACES}};
    if (!plan_material(line, &material) || !read_heights(line, z) ||
        !plan_points(line, "corners", 3, &ring) || !plan_options(line, options, 1))
        return false;
    add_prism(line->arena, models, ring.points, ring.count, z[0], z[1], without, material);
    return true;
}

bool plan_read_cylinder(PlanLine *line, PlanModels *models) {
    int material, sides = 8;
    Vec2 centre;
    double z[2], radius = 0, tolerance = PLAN_TOLERANCE;
    unsigned without = 0;
    bool round = false;
    PlanOption options[] = {
        {.word = "radius", .kind = PLAN_LENGTH, .out = &radius, .min = 0.001, .max = 100, .required = true},
        {.word = "sides", .kind = PLAN_WHOLE, .out = &sides, .min = 3, .max = MAX_SIDES},
        {.word = "without", .kind = PLAN_SET, .out = &without, .words = PRISM_FACES},
        {.word = "round", .kind = PLAN_FLAG, .out = &round},
        PLAN_TOLERANCE_WORD(tolerance)};
    if (!plan_material(line, &material) || !read_heights(line, z) ||
        !plan_point(line, "the centre", &centre) || !plan_options(line, options, 5))
        return false;
    if (round ? options[1].given : options[4].given)
        return plan_fail(line, "a cylinder with %s (allowed: sides, or round and a tolerance)",
                         round ? "sides that is round" : "a tolerance that is not round");
    if (round)
        return plan_add_round(line, models, centre, z, radius, tolerance,
                              (bool[]){!(without & BOTTOM), !(without & TOP)}, material);
    Vec2 ring[MAX_SIDES];
    for (int i = 0; i < sides; i++) {
        double angle = 2 * M_PI * (i + 0.5) / sides;
        ring[i] = vec2_add(centre, vec2_scale(vec2(cos(angle), sin(angle)), radius));
    }
    add_prism(line->arena, models, ring, sides, z[0], z[1], without, material);
    return true;
}

bool plan_read_poly(PlanLine *line, PlanModels *models) {
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
    building_add_polygon(line->arena, &models->shapes, vertices, count, material);
    return true;
}

bool plan_light(PlanLine *line, const char *name, Light *out) {
    double flux[3] = {0}, radius = 0.05;
    Vec3 at;
    PlanOption options[] = {
        {.word = "flux", .kind = PLAN_SPECTRUM, .out = flux, .min = 0, .max = MAX_FLUX, .required = true},
        {.word = "radius", .kind = PLAN_LENGTH, .out = &radius, .min = 0, .max = 10}};
    if (!plan_place(line, "the light's place", true, &at) || !plan_options(line, options, 2)) return false;
    *out = (Light){name, at, radius, {(float)flux[0], (float)flux[1], (float)flux[2]}, -1};
    return true;
}

bool plan_read_model_light(PlanLine *line, PlanModels *models) {
    Building *shapes = &models->shapes;
    Light light;
    if (!plan_light(line, shapes->objects[shapes->object_count - 1].name, &light)) return false;
    light.object = shapes->object_count - 1;
    *ARENA_PUSH(line->arena, shapes->lights, shapes->light_count, shapes->light_capacity) = light;
    return true;
}

void plan_add_stair(Arena *arena, PlanModels *models, Vec3 size, int steps, int material) {
    double x = size.x / 2, y0 = -size.y / 2, going = size.y / steps, rise = size.z / steps;
    for (int i = 0; i < steps; i++) {
        // Each step is a box down to the floor; what the one behind covers is left out.
        Vec3 a = vec3(-x, y0 + i * going, 0), b = vec3(x, y0 + (i + 1) * going, (i + 1) * rise);
        add_model_box(arena, models, a, b, BOTTOM | FRONT | (i + 1 < steps ? BACK : 0), material);
        double z = i * rise;
        building_add_polygon(arena, &models->shapes,
                             (Vec3[]){{a.x, a.y, z}, {b.x, a.y, z}, {b.x, a.y, b.z}, {a.x, a.y, b.z}}, 4,
                             material);
    }
}

void plan_add_ramp(Arena *arena, PlanModels *models, Vec3 size, int material) {
    double x = size.x / 2, y = size.y / 2, z = size.z;
    Building *b = &models->shapes;
    building_add_polygon(arena, b, (Vec3[]){{-x, -y, 0}, {x, -y, 0}, {x, y, z}, {-x, y, z}}, 4, material);
    building_add_polygon(arena, b, (Vec3[]){{x, y, 0}, {-x, y, 0}, {-x, y, z}, {x, y, z}}, 4, material);
    building_add_polygon(arena, b, (Vec3[]){{-x, y, 0}, {-x, -y, 0}, {-x, y, z}}, 3, material);
    building_add_polygon(arena, b, (Vec3[]){{x, -y, 0}, {x, y, 0}, {x, y, z}}, 3, material);
}

Vec3 plan_turn_point(const PlanTurn *t, Vec3 p) {
    double x = t->stand.mirror ? -p.x : p.x;
    Vec3 at = t->stand.at;
    return vec3(at.x + t->cosine * x - t->sine * p.y, at.y + t->sine * x + t->cosine * p.y, at.z + p.z);
}

Vec3 plan_turn_vector(const PlanTurn *t, Vec3 v) {
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

static bool stand_polygon(PlanLine *line, Arena *arena, const Building *shapes, const Polygon *p,
                          const PlanTurn *turn, Building *b) {
    Vec3 *corner = ARENA_ARRAY(arena, Vec3, p->vertex_count);
    for (int k = 0; k < p->vertex_count; k++) {
        int from = turn->stand.mirror ? p->vertex_count - 1 - k : k;
        Vec3 v = plan_turn_point(turn, shapes->vertices[p->first_vertex + from]);
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
    building_add_polygon(arena, b, corner, p->vertex_count, p->material);
    return true;
}

bool plan_stand_model(PlanLine *line, Arena *arena, const PlanModels *models, int model, const char *name,
                      PlanStand stand, Building *b) {
    const Building *shapes = &models->shapes;
    const Object *shape = &shapes->objects[model];
    PlanTurn turn = {.stand = stand};
    turn_by(stand.angle, &turn.cosine, &turn.sine);
    int *placed = ARENA_ARRAY(arena, int, shape->polygon_count + 1);
    int object = building_add_object(arena, b, shape->kind, name);
    for (int i = 0; i < shape->polygon_count; i++) {
        const Polygon *p = &shapes->polygons[shape->first_polygon + i];
        placed[i] = b->polygon_count;
        if (!stand_polygon(line, arena, shapes, p, &turn, b)) return false;
    }
    placed[shape->polygon_count] = b->polygon_count;
    plan_stand_shapes(arena, models, model, &turn, placed, b);
    building_set_proxy(b, stand.angle);
    for (int i = 0; i < shapes->light_count; i++) {
        Light light = shapes->lights[i];
        if (light.object != model) continue;
        light.position = plan_turn_point(&turn, light.position);
        light.name = name;
        light.object = object;
        *ARENA_PUSH(arena, b->lights, b->light_count, b->light_capacity) = light;
    }
    return true;
}
