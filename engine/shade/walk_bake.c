// walk_bake.c - light computed beforehand, by the formulas of walk_shade.h, with ambient occlusion by distances.
//
// A texel is a surface's brightness on the screen divided by its brightness in usual light; the surface's own colour is stored as it
// looks in usual light. One channel of eleven bits shows no steps on a wall near by, where three of eight would, and is filtered in
// less time.
//
// The texels of all surfaces in one plane lie on one grid through the origin, and reach past the surface's edge: two
// surfaces that meet there have the same texels on both sides, so that no seam shows between them.
#include "engine/shade/walk_bake.h"

#include "engine/shade/walk_occlusion.h"
#include "engine/shade/walk_shade.h"

// The sides of texels, metres: indoors they show the occlusion of corners, outdoors that of houses.
#define TEXEL_INDOORS 0.125
#define TEXEL_OUTDOORS 0.5
// A surface has at most so many texels each way, so that one row of a texture holds several surfaces.
#define TEXELS_MOST 512
// The share of a lamp's strength that usually falls on a surface; and the least brightness on the screen that a surface counts as, so
// that one can divide by the brightness of black surfaces.
#define USUAL_LAMP 0.4f
#define DARKEST (1.0f / 255)
// The middles of the outermost texels lie at least this far outside a surface, in texels, so that rounding asks for no texel beyond them.
#define TEXEL_MARGIN (1.0 / 16)

struct WalkBake {
    const CellGraph *graph;
    const WalkLights *lights;
    const WalkOcclusion *occlusion;
    Vec3 origin;
};

// ---- light at a point

static const Rgb BLACK = {0, 0, 0};

static Rgb rgb_mix(Rgb a, Rgb b, float t) {
    return (Rgb){a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}
static Rgb rgb_add(Rgb a, Rgb b, float share) {
    return (Rgb){a.r + share * b.r, a.g + share * b.g, a.b + share * b.b};
}
static Rgb rgb_multiply(Rgb a, Rgb b) { return (Rgb){a.r * b.r, a.g * b.g, a.b * b.b}; }

static float facing(Vec3 n, Vec3 way) { return (float)fmax(vec3_dot(n, way), 0); }

static Rgb ambient_light(Vec3 n, bool outdoors) {
    Rgb light = rgb_mix((Rgb){WALK_BELOW}, (Rgb){WALK_ABOVE}, (float)n.z * 0.5f + 0.5f);
    light = rgb_add(light, (Rgb){WALK_SUN_INDOORS}, facing(n, vec3(WALK_SUN_WAY)));
    light = rgb_add(light, (Rgb){WALK_SIDE}, facing(n, vec3(WALK_SIDE_WAY)));
    light = rgb_add(light, (Rgb){WALK_BACK}, facing(n, vec3(WALK_BACK_WAY)));
    if (!outdoors) return light;
    light = rgb_mix(BLACK, light, WALK_OUTDOORS_DIMMING);
    return rgb_add(light, (Rgb){WALK_SUN_OUTDOORS}, facing(n, vec3(WALK_SUN_WAY)));
}

static Rgb lamp_light(const WalkLights *lights, int object, Vec3 place, Vec3 n) {
    Rgb sum = {0, 0, 0};
    int count;
    const WalkLamp *lamp = lights->lamps + walk_lamps_of(lights, object, &count);
    for (const WalkLamp *end = lamp + count; lamp < end; lamp++) {
        Vec3 way =
            vec3(lamp->position[0] - place.x, lamp->position[1] - place.y, lamp->position[2] - place.z);
        double r2 = vec3_dot(way, way), cosine = vec3_dot(n, way) / fmax(sqrt(r2), 0.01);
        float face = fminf(fmaxf((float)cosine * (1 - WALK_LAMP_WRAP) + WALK_LAMP_WRAP, 0), 1);
        Rgb colour = {lamp->colour[0], lamp->colour[1], lamp->colour[2]};
        sum = rgb_add(sum, rgb_mix(colour, (Rgb){1, 1, 1}, WALK_LAMP_WHITENESS),
                      lamp->strength * face * WALK_LAMP_STRENGTH / (1 + WALK_LAMP_FALL * (float)r2));
    }
    return sum;
}

static float screen(float light) {
    float x = light * WALK_EXPOSURE;
    x = x * (1 + x * WALK_SHOULDER_TOP) / (1 + x * WALK_SHOULDER_BOTTOM);
    if (x > WALK_KNEE) x = WALK_KNEE + (1 - WALK_KNEE) * (1 - expf((WALK_KNEE - x) / (1 - WALK_KNEE)));
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

static Rgb rgb_screen(Rgb light) { return (Rgb){screen(light.r), screen(light.g), screen(light.b)}; }

static Rgba8 to_bytes(Rgb c, float alpha) {
    return (Rgba8){walk_byte(c.r), walk_byte(c.g), walk_byte(c.b), walk_byte(alpha)};
}

Rgb walk_glow(const Material *m) {
    Rgb e = m->emission;
    float most = fmaxf(fmaxf(e.r, e.g), e.b);
    return most > 1 ? rgb_mix(BLACK, e, 1 / most) : e;
}

Rgba8 walk_bake_plain(const Material *m, Vec3 n) {
    return to_bytes(
        rgb_screen(rgb_add(rgb_multiply(m->reflectance, ambient_light(n, false)), walk_glow(m), 1)), 1);
}

Rgba8 walk_bake_sky(void) { return to_bytes(rgb_screen((Rgb){WALK_PANE}), 1); }

// The light that leaves a surface that faces n at a point, on the screen.
static Rgb look_at(const WalkBake *bake, int object, const Material *m, Vec3 point, Vec3 n) {
    float open = (float)walk_occlusion_open(bake->occlusion, point, n, bake->lights->region[object], object);
    Rgb warm = rgb_mix((Rgb){1, 1, 1}, (Rgb){WALK_OCCLUSION_WARMTH}, 1 - open);
    Rgb shade = rgb_mix((Rgb){1, 1, 1}, rgb_mix(BLACK, warm, open), WALK_OCCLUSION_STRENGTH);
    Rgb light = rgb_multiply(ambient_light(n, walk_outdoors(bake->graph, bake->lights, object)), shade);
    light = rgb_add(light, lamp_light(bake->lights, object, vec3_sub(point, bake->origin), n),
                    1 - WALK_LAMP_OPENNESS * (1 - open));
    light = rgb_add(rgb_multiply(m->reflectance, light), walk_glow(m), 1);
    // Holes of a picture mirror no sky.
    return rgb_screen(m->alpha < 1 && m->texture == 0 ? rgb_mix(light, (Rgb){WALK_PANE}, WALK_PANE_SHARE)
                                                      : light);
}

// The colour of a surface in the usual light of its room: the same for all surfaces of a material that face one way.
static Rgb usual_look(const WalkBake *bake, int object, const Material *m, Vec3 n) {
    const WalkLights *lights = bake->lights;
    Rgb light = ambient_light(n, walk_outdoors(bake->graph, bake->lights, object));
    int count, first = walk_lamps_of(lights, object, &count);
    for (int i = first; i < first + count; i++) {
        const WalkLamp *lamp = &lights->lamps[i];
        Rgb colour = {lamp->colour[0], lamp->colour[1], lamp->colour[2]};
        light =
            rgb_add(light, rgb_mix(colour, (Rgb){1, 1, 1}, WALK_LAMP_WHITENESS), USUAL_LAMP * lamp->strength);
    }
    return rgb_screen(rgb_add(rgb_multiply(m->reflectance, light), walk_glow(m), 1));
}

// The brightness of a colour on the screen (the luma of ITU-R BT.709).
static float brightness(Rgb c) { return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b; }

Rgba8 walk_bake_point(const WalkBake *bake, int object, int material, Vec3 point, Vec3 n) {
    const Material *m = &bake->graph->building->materials[material];
    return to_bytes(look_at(bake, object, m, point, n), m->alpha);
}

Rgba8 walk_bake_surface(const WalkBake *bake, int object, int polygon) {
    const CellGraph *graph = bake->graph;
    const Polygon *p = &graph->polygons[polygon];
    Plane plane = plane_of_polygon(graph->vertices + p->first_vertex, p->vertex_count);
    return to_bytes(usual_look(bake, object, &graph->building->materials[p->material], plane.n), 1);
}

// ---- layout

typedef struct Axes {
    Vec3 u, v;
} Axes;

// The two axes in a level or upright plane; the same for all surfaces in it.
static Axes axes_of(Plane plane) {
    if (fabs(plane.n.z) > 0.5) return (Axes){{1, 0, 0}, {0, 1, 0}};
    return (Axes){{-plane.n.y, plane.n.x, 0}, {0, 0, 1}};
}

typedef struct Extent {
    double u0, u1, v0, v1;
} Extent;

static Extent extent_of(const WalkBake *bake, int polygon, Axes axes) {
    const Polygon *p = &bake->graph->polygons[polygon];
    Extent e = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (int i = p->first_vertex; i < p->first_vertex + p->vertex_count; i++) {
        Vec3 at = vec3_sub(bake->graph->vertices[i], bake->origin);
        double u = vec3_dot(axes.u, at), v = vec3_dot(axes.v, at);
        e = (Extent){fmin(e.u0, u), fmax(e.u1, u), fmin(e.v0, v), fmax(e.v1, v)};
    }
    return e;
}

// The number of the first texel, whose middle is not past x, and the number of texels from it to the first whose middle is past y.
static double first_texel(double x, double side) { return floor(x / side - 0.5 - TEXEL_MARGIN); }
static int texels_to(double first, double y, double side) {
    return (int)(floor(y / side - 0.5 + TEXEL_MARGIN) - first) + 2;
}

WalkTexels walk_bake_texels(const WalkBake *bake, int object, int polygon, double coarseness) {
    const Polygon *p = &bake->graph->polygons[polygon];
    WalkTexels t = {.plane = plane_of_polygon(bake->graph->vertices + p->first_vertex, p->vertex_count)};
    Extent e = extent_of(bake, polygon, axes_of(t.plane));
    bool outdoors = walk_outdoors(bake->graph, bake->lights, object);
    t.side = coarseness * (outdoors ? TEXEL_OUTDOORS : TEXEL_INDOORS);
    while (fmax(e.u1 - e.u0, e.v1 - e.v0) > t.side * TEXELS_MOST) t.side *= 2;
    t.first_u = first_texel(e.u0, t.side);
    t.first_v = first_texel(e.v0, t.side);
    t.width = texels_to(t.first_u, e.u1, t.side);
    t.height = texels_to(t.first_v, e.v1, t.side);
    return t;
}

static long count_texels(const WalkBake *bake, double coarseness, long most) {
    const CellGraph *graph = bake->graph;
    long texels = 0;
    for (int o = graph->surface_first[0]; o < graph->surface_first[graph->cell_count] && texels <= most;
         o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            WalkTexels t = walk_bake_texels(bake, o, p, coarseness);
            texels += (long)t.width * t.height;
        }
    }
    return texels;
}

double walk_bake_coarseness(const WalkBake *bake, long most) {
    double coarseness = 1;
    while (count_texels(bake, coarseness, most) > most && coarseness < WALK_COARSENESS_MOST)
        coarseness *= WALK_COARSENESS_STEP;
    return coarseness;
}

void walk_bake_fill(const WalkBake *bake, int object, int polygon, const WalkTexels *t, float *out,
                    size_t row) {
    Axes axes = axes_of(t->plane);
    Vec3 n = t->plane.n;
    // The point of the plane nearest to the origin, from which u and v lead to any other point of the plane.
    Vec3 foot = vec3_sub(bake->origin, vec3_scale(n, plane_distance(t->plane, bake->origin)));
    const Material *m = &bake->graph->building->materials[bake->graph->polygons[polygon].material];
    float usual = fmaxf(brightness(usual_look(bake, object, m, n)), DARKEST);
    for (int j = 0; j < t->height; j++) {
        Vec3 start = vec3_add(foot, vec3_scale(axes.v, (t->first_v + j + 0.5) * t->side));
        for (int i = 0; i < t->width; i++) {
            Vec3 at = vec3_add(start, vec3_scale(axes.u, (t->first_u + i + 0.5) * t->side));
            out[(size_t)j * row + (size_t)i] = brightness(look_at(bake, object, m, at, n)) / usual;
        }
    }
}

Vec2 walk_bake_place(const WalkBake *bake, const WalkTexels *t, Vec3 point) {
    Axes axes = axes_of(t->plane);
    Vec3 at = vec3_sub(point, bake->origin);
    return vec2(vec3_dot(axes.u, at) / t->side - t->first_u, vec3_dot(axes.v, at) / t->side - t->first_v);
}

// ---- interface

WalkBake *walk_bake_new(const CellGraph *graph, const WalkLights *lights, Vec3 origin, Arena *arena) {
    WalkBake *bake = ARENA_ARRAY(arena, WalkBake, 1);
    bake->graph = graph;
    bake->lights = lights;
    bake->origin = origin;
    bake->occlusion = walk_occlusion_new(graph, arena);
    return bake;
}
