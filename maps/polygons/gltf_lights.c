// gltf_lights.c - lights (KHR_lights_punctual) and cameras of a glTF document.
//
// Candela become watts by the luminous efficacy exporters use, 683 lm/W: a point light of I cd shines with 4 pi I
// lumens, a spot with those in its outer cone, spread over all directions, since lights of a building are balls. Lights
// without a place (directional, in lux) are no lights of a building: they are left out and tallied.
#include "maps/polygons/gltf.h"

static const char LIGHTS[] = "KHR_lights_punctual";
static const double RADIUS = 0.05;            // metres, of a luminous ball where the file knows points only
static const double MAX_CANDELA = 1e12;       // lighthouses have 1e7
static const double FIELD = 70 * M_PI / 180;  // radians, of a camera without perspective
static const double ASPECT = 16.0 / 9;        // of a camera that does not say
static const double NARROWEST = 1e-3, WIDEST = 3.1;  // radians, of a view across

static Vec3 origin_of(const double m[12]) { return vec3(m[3], m[7], m[11]); }

static bool near_enough(Gltf *g, const GltfItem *node, Vec3 p) {
    if (fabs(p.x) <= MAPS_LIMIT && fabs(p.y) <= MAPS_LIMIT && fabs(p.z) <= MAPS_LIMIT) return true;
    return gltf_fail(g, node, NULL, "lies at (%g, %g, %g) m (allowed: within %g m)", p.x, p.y, p.z,
                     MAPS_LIMIT);
}

// The lumens of a light over its candelas, or 0 for one without a place.
static double spread_of(Gltf *g, const GltfItem *light) {
    const char *type = gltf_text(g, light, "type", "missing");
    if (g->failed) return 0;
    if (strcmp(type, "point") == 0) return 4 * M_PI;
    if (strcmp(type, "spot") == 0) {
        GltfItem spot = gltf_member(g, light, "spot");
        double outer = gltf_number(g, &spot, "outerConeAngle", 0, M_PI / 2 + 1e-6, M_PI / 4);
        return 2 * M_PI * (1 - cos(outer));
    }
    if (strcmp(type, "directional") == 0)
        g->tally.suns++;
    else
        gltf_fail(g, light, "type", "is %.20s (allowed: point, spot, directional)", type);
    return 0;
}

void gltf_add_light(Gltf *g, const GltfItem *node, const double m[12]) {
    GltfItem mine = gltf_extension(g, node, LIGHTS), root = gltf_root(g),
             all = gltf_extension(g, &root, LIGHTS);
    if (g->failed || !mine.json) return;
    int count = gltf_count(g, &all, "lights"), index = gltf_int(g, &mine, "light", 0, count - 1, -1);
    if (g->failed) return;
    if (index < 0) {
        gltf_fail(g, &mine, "light", "is missing");
        return;
    }
    GltfItem light = gltf_element(g, &all, "lights", index);
    double colour[3] = {1, 1, 1}, candela = gltf_number(g, &light, "intensity", 0, MAX_CANDELA, 1);
    gltf_numbers(g, &light, "color", 3, 0, 1, colour);
    double watts = spread_of(g, &light) * candela / GLTF_LUMENS_PER_WATT;
    const char *name = gltf_text(g, node, "name", gltf_text(g, &light, "name", ""));
    if (g->failed || watts <= 0 || !near_enough(g, node, origin_of(m))) return;
    *ARENA_PUSH(g->arena, g->b->lights, g->b->light_count, g->b->light_capacity) =
        (Light){.name = arena_string(g->arena, name),
                .position = origin_of(m),
                .radius = RADIUS,
                .flux = {(float)(watts * colour[0]), (float)(watts * colour[1]), (float)(watts * colour[2])},
                .object = -1};
}

// Across, in radians.
static double field_of(Gltf *g, const GltfItem *camera) {
    GltfItem perspective = gltf_member(g, camera, "perspective");
    if (!perspective.json) return FIELD;
    double up = gltf_number(g, &perspective, "yfov", 1e-6, M_PI - 1e-6, FIELD / ASPECT),
           aspect = gltf_number(g, &perspective, "aspectRatio", 1e-6, 1e6, ASPECT);
    return fmin(fmax(2 * atan(tan(up / 2) * aspect), NARROWEST), WIDEST);
}

// A camera looks along its own -z; the eye of a building does not roll.
void gltf_add_camera(Gltf *g, const GltfItem *node, const double m[12]) {
    int index = gltf_index(g, node, "camera", "cameras");
    if (g->failed || index < 0) return;
    GltfItem camera = gltf_item(g, "cameras", index);
    double field = field_of(g, &camera);
    const char *name = gltf_text(g, node, "name", gltf_text(g, &camera, "name", ""));
    Vec3 ahead = vec3_normalize(vec3(-m[2], -m[6], -m[10]));
    if (g->failed || !near_enough(g, node, origin_of(m))) return;
    bool sound = isfinite(ahead.x) && isfinite(ahead.y) && isfinite(ahead.z);
    *ARENA_PUSH(g->arena, g->b->viewpoints, g->b->viewpoint_count, g->b->viewpoint_capacity) =
        (Viewpoint){.name = arena_string(g->arena, name),
                    .eye = origin_of(m),
                    .yaw = sound ? atan2(ahead.y, ahead.x) : 0,
                    .pitch = sound ? asin(fmin(fmax(ahead.z, -1), 1)) : 0,
                    .fov = field};
}
