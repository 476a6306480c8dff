// lamp_faces.c - squares and cubes of light for lamps, and openings of lamps with a photometric file.
#include "maps/building/lamp_faces.h"

#include "engine/core/polygon.h"

// From the lamp to its square, metres: clear of the lamp's polygons, and too small a gap to be seen.
static const double GAP = 0.005;
// Least free height above a lamp that shines upwards, metres; with less, the lamp would light only a spot of the ceiling.
static const double HEADROOM = 0.1;
// The smallest radius taken, metres: that of a light bulb. Smaller faces are hard to see from afar by any sampling.
static const double BULB = 0.03;

static Box box_of_object(const Building *b, int object) {
    Box box = box_empty();
    const Object *o = &b->objects[object];
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        for (int k = 0; k < p->vertex_count; k++) box = box_add(box, b->vertices[p->first_vertex + k]);
    }
    return box;
}

static bool glows(const Building *b, int object) {
    const Object *o = &b->objects[object];
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        Rgb e = b->materials[b->polygons[i].material].emission;
        if (e.r > 0 || e.g > 0 || e.b > 0) return true;
    }
    return false;
}

// Whether the plan of a region holds p: an odd number of edges, those of holes included, lies to the right of p.
static bool is_in_plan(const Building *b, const Region *region, Vec3 p) {
    bool inside = false;
    for (int r = region->first_ring; r < region->first_ring + region->ring_count; r++) {
        const Ring *ring = &b->rings[r];
        inside ^= ring_contains(&b->points[ring->first_point], ring->point_count, vec2(p.x, p.y));
    }
    return inside;
}

// The region that holds a point; NULL: none.
static const Region *region_at(const Building *b, Vec3 p) {
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (p.z >= r->z0 && p.z <= r->z1 && is_in_plan(b, r, p)) return r;
    }
    return NULL;
}

// The height of the ceiling over a point; infinite where no region holds the point.
static double ceiling_above(const Building *b, Vec3 p) {
    const Region *r = region_at(b, p);
    return r ? r->z1 : INFINITY;
}

static int light_material(Arena *arena, Building *b, const Light *light, double share, int spread) {
    Rgb flux = light->flux;
    float by = (float)share;
    Material m = {
        .name = "light", .alpha = 1, .emission = {flux.r * by, flux.g * by, flux.b * by}, .spread = spread};
    return building_add_material(arena, b, m);
}

// A rectangle about p whose sides are unit vectors, `width` and `height` metres; it faces across x up.
static void add_lamp_rectangle(Arena *arena, Building *b, Vec3 p, Vec3 across, Vec3 up, double width,
                               double height, int material) {
    Vec3 corner[4];
    for (int i = 0; i < 4; i++) {
        double a = (i == 0 || i == 3 ? -0.5 : 0.5) * width, c = (i < 2 ? -0.5 : 0.5) * height;
        corner[i] = vec3_add(p, vec3_add(vec3_scale(across, a), vec3_scale(up, c)));
    }
    building_add_polygon(arena, b, corner, 4, material);
}

// A square about p that faces n, one of the axes; `side` metres.
static void add_lamp_square(Arena *arena, Building *b, Vec3 p, Vec3 n, double side, int material) {
    Vec3 across = fabs(n.x) > 0.5 ? vec3(0, 1, 0) : vec3(1, 0, 0);
    add_lamp_rectangle(arena, b, p, across, vec3_cross(n, across), side, side, material);
}

static void add_to_lamp(Arena *arena, Building *b, const Light *light, Box lamp, double radius) {
    Vec3 p = light->position;
    double side = radius * sqrt(M_PI);
    bool upwards = p.z > (lamp.min.z + lamp.max.z) / 2 && ceiling_above(b, p) > lamp.max.z + HEADROOM;
    p.z = upwards ? lamp.max.z + GAP : lamp.min.z - GAP;
    add_lamp_square(arena, b, p, vec3(0, 0, upwards ? 1 : -1), side,
                    light_material(arena, b, light, 1 / (side * side), 0));
}

static void add_cube(Arena *arena, Building *b, const Light *light, double radius) {
    double side = radius * sqrt(4 * M_PI / 6);
    int material = light_material(arena, b, light, 1 / (6 * side * side), 0);
    for (int i = 0; i < 6; i++) {
        double s = i % 2 ? 1 : -1;
        Vec3 n = i < 2 ? vec3(s, 0, 0) : i < 4 ? vec3(0, s, 0) : vec3(0, 0, s);
        add_lamp_square(arena, b, vec3_add(light->position, vec3_scale(n, side / 2)), n, side, material);
    }
}

// ---- lamps with a photometric file

// The polygons of the lamp itself glow no more: the file tells its light.
static void put_out(Arena *arena, Building *b, int object) {
    const Object *o = &b->objects[object];
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        Material m = b->materials[b->polygons[i].material];
        m.emission = (Rgb){0, 0, 0};
        b->polygons[i].material = building_add_material(arena, b, m);
    }
}

// Lamps of one table that hang alike share an entry.
static int add_spread(Arena *arena, Building *b, LampSpread spread) {
    for (int i = 1; i < b->spread_count; i++) {
        const LampSpread *s = &b->spreads[i];
        if (s->table == spread.table && s->turn == spread.turn && s->side == spread.side) return i;
    }
    if (b->spread_count == 0)
        *ARENA_PUSH(arena, b->spreads, b->spread_count, b->spread_capacity) = (LampSpread){0};
    *ARENA_PUSH(arena, b->spreads, b->spread_count, b->spread_capacity) = spread;
    return b->spread_count - 1;
}

// One side of the table leaves from a rectangle of the opening's size at height z.
static void open_side(Arena *arena, Building *b, const Light *light, int side, double radius, double z) {
    const Photometry *t = &b->photometries[light->photometry];
    double own = radius * sqrt(M_PI), width = t->size[0] > 0 ? t->size[0] : own,
           height = t->size[1] > 0 ? t->size[1] : own;
    width = fmax(width, BULB);
    height = fmax(height, BULB);
    double share = t->lumens[side] / photometry_lumens(t) / (width * height);
    int material =
        light_material(arena, b, light, share, add_spread(arena, b, (LampSpread){t, light->turn, side}));
    Vec3 across = vec3(cos(light->turn), sin(light->turn), 0),
         n = vec3(0, 0, side == PHOTOMETRY_ABOVE ? 1 : -1);
    Vec3 p = vec3(light->position.x, light->position.y, z);
    add_lamp_rectangle(arena, b, p, across, vec3_cross(n, across), width, height, material);
}

// The heights of the lamp's two openings. Returns whether the lamp stands: both are then above it.
static bool place_openings(const Building *b, const Light *light, Box lamp, double z[PHOTOMETRY_SIDES]) {
    Vec3 p = light->position;
    const Region *r = region_at(b, p);
    z[PHOTOMETRY_BELOW] = p.z - GAP / 2;
    z[PHOTOMETRY_ABOVE] = p.z + GAP / 2;
    if (box_is_empty(lamp)) return false;
    bool stands = p.z > (lamp.min.z + lamp.max.z) / 2 && ceiling_above(b, p) > lamp.max.z + HEADROOM;
    stands = stands || (r && lamp.min.z - GAP <= r->z0);
    z[PHOTOMETRY_BELOW] = stands ? lamp.max.z + GAP : lamp.min.z - GAP;
    z[PHOTOMETRY_ABOVE] = lamp.max.z + (stands ? 2 : 1) * GAP;
    return stands;
}

static void add_openings(Arena *arena, Building *b, const Light *light, Box lamp, double radius) {
    static const char *const WAYS[] = {"down", "up"};
    const Photometry *t = &b->photometries[light->photometry];
    const Region *r = region_at(b, light->position);
    double z[PHOTOMETRY_SIDES];
    bool stands = place_openings(b, light, lamp, z);
    if (stands && t->lumens[PHOTOMETRY_BELOW] > 0)
        building_note(
            arena, b, NOTE_CHANGED, light->position,
            "lamp %.100s stands: the %.3g %% of its light that go down leave above the lamp, and meet it",
            light->name ? light->name : "", 100 * t->lumens[PHOTOMETRY_BELOW] / photometry_lumens(t));
    for (int side = 0; side < PHOTOMETRY_SIDES; side++) {
        if (!(t->lumens[side] > 0)) continue;
        if (!r || (z[side] > r->z0 && z[side] < r->z1)) {
            open_side(arena, b, light, side, radius, z[side]);
            continue;
        }
        building_note(
            arena, b, NOTE_CHANGED, light->position,
            "lamp %.100s: the %.3g %% of its light that go %s are left out: there is no room for them",
            light->name ? light->name : "", 100 * t->lumens[side] / photometry_lumens(t), WAYS[side]);
    }
}

// The lights of a lamp stand for one photometric file, in their middle; false: an earlier light of the lamp was the one.
static bool join_lights(const Building *b, int index, Light *light) {
    Vec3 sum = {0, 0, 0};
    int count = 0;
    for (int i = 0; i < b->light_count && light->object >= 0; i++) {
        if (b->lights[i].object != light->object || b->lights[i].photometry != light->photometry) continue;
        if (i < index) return false;
        sum = vec3_add(sum, b->lights[i].position);
        count++;
    }
    if (count > 0) light->position = vec3_scale(sum, 1.0 / count);
    return true;
}

int lamp_faces_add(Arena *arena, Building *b) {
    int added = 0;
    for (int i = 0; i < b->light_count; i++) {
        Light light = b->lights[i];
        double radius = fmax(light.radius, BULB);
        if (light.flux.r <= 0 && light.flux.g <= 0 && light.flux.b <= 0) continue;
        Box lamp = light.object >= 0 ? box_of_object(b, light.object) : box_empty();
        bool measured = light.photometry > 0;
        if (measured && !join_lights(b, i, &light)) continue;
        if (light.object >= 0 && glows(b, light.object)) {
            if (!measured) continue;
            put_out(arena, b, light.object);
        }
        building_add_object(arena, b, OBJECT_LAMP, light.name);
        if (measured)
            add_openings(arena, b, &light, lamp, radius);
        else if (box_is_empty(lamp))
            add_cube(arena, b, &light, radius);
        else
            add_to_lamp(arena, b, &light, lamp, radius);
        added++;
    }
    return added;
}
