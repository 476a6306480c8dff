// lamp_faces.c - squares and cubes of light for lamps.
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

// The height of the ceiling over a point; infinite where no region holds the point.
static double ceiling_above(const Building *b, Vec3 p) {
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (p.z >= r->z0 && p.z <= r->z1 && is_in_plan(b, r, p)) return r->z1;
    }
    return INFINITY;
}

static int light_material(Arena *arena, Building *b, const Light *light, double area) {
    Rgb flux = light->flux;
    float share = (float)(1 / area);
    Material m = {.name = "light", .alpha = 1, .emission = {flux.r * share, flux.g * share, flux.b * share}};
    return building_add_material(arena, b, m);
}

// A square about p that faces n, one of the axes; `side` metres.
static void add_lamp_square(Arena *arena, Building *b, Vec3 p, Vec3 n, double side, int material) {
    Vec3 across = fabs(n.x) > 0.5 ? vec3(0, 1, 0) : vec3(1, 0, 0), up = vec3_cross(n, across);
    Vec3 corner[4];
    for (int i = 0; i < 4; i++) {
        double a = (i == 0 || i == 3 ? -0.5 : 0.5) * side, c = (i < 2 ? -0.5 : 0.5) * side;
        corner[i] = vec3_add(p, vec3_add(vec3_scale(across, a), vec3_scale(up, c)));
    }
    building_add_polygon(arena, b, corner, 4, material);
}

static void add_to_lamp(Arena *arena, Building *b, const Light *light, Box lamp, double radius) {
    Vec3 p = light->position;
    double side = radius * sqrt(M_PI);
    bool upwards = p.z > (lamp.min.z + lamp.max.z) / 2 && ceiling_above(b, p) > lamp.max.z + HEADROOM;
    p.z = upwards ? lamp.max.z + GAP : lamp.min.z - GAP;
    add_lamp_square(arena, b, p, vec3(0, 0, upwards ? 1 : -1), side,
                    light_material(arena, b, light, side * side));
}

static void add_cube(Arena *arena, Building *b, const Light *light, double radius) {
    double side = radius * sqrt(4 * M_PI / 6);
    int material = light_material(arena, b, light, 6 * side * side);
    for (int i = 0; i < 6; i++) {
        double s = i % 2 ? 1 : -1;
        Vec3 n = i < 2 ? vec3(s, 0, 0) : i < 4 ? vec3(0, s, 0) : vec3(0, 0, s);
        add_lamp_square(arena, b, vec3_add(light->position, vec3_scale(n, side / 2)), n, side, material);
    }
}

int lamp_faces_add(Arena *arena, Building *b) {
    int added = 0;
    for (int i = 0; i < b->light_count; i++) {
        Light light = b->lights[i];
        double radius = fmax(light.radius, BULB);
        if (light.flux.r <= 0 && light.flux.g <= 0 && light.flux.b <= 0) continue;
        Box lamp = light.object >= 0 ? box_of_object(b, light.object) : box_empty();
        if (light.object >= 0 && glows(b, light.object)) continue;
        building_add_object(arena, b, OBJECT_LAMP, light.name);
        if (box_is_empty(lamp))
            add_cube(arena, b, &light, radius);
        else
            add_to_lamp(arena, b, &light, lamp, radius);
        added++;
    }
    return added;
}
