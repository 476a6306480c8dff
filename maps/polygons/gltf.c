// gltf.c - glTF 2.0 documents, .gltf and .glb (Khronos, glTF 2.0 Specification, 2021), as polygons alone.
//
// The reader takes the default scene (or the first) with its nodes, meshes of triangles, materials by their colours, lamps
// and cameras. It leaves out animation, skins and morph targets (meshes are as at rest), points and lines, normals.
#include "maps/polygons/gltf.h"

#include "maps/building/reader.h"
#include "maps/building/texture.h"

enum { HEADER = 12, CHUNK_HEADER = 8 };
static const uint32_t MAGIC = 0x46546C67, CHUNK_JSON = 0x4E4F534A, CHUNK_BIN = 0x004E4942;

// Extensions that may be required: those read, and those that change looks alone. A name that ends in `_` stands for
// all names that begin so.
static const char *const EXTENSIONS[] = {"KHR_lights_punctual",   "KHR_mesh_quantization", "KHR_materials_",
                                         "KHR_texture_transform", "KHR_texture_basisu",    "EXT_texture_webp",
                                         "KHR_xmp_json_ld"};

// Faces of a mesh's primitives, triangles joined, in the mesh's own space; decoded once however often it is placed.
typedef struct GltfMesh {
    SoupMesh *primitives;
    int primitive_count;
    bool decoded;
} GltfMesh;

// A material of the building, and the picture on it.
typedef struct GltfMaterial {
    bool made;
    int material;
    GltfPicture picture;
} GltfMaterial;

// ---- materials
//
// glTF materials as diffuse reflectances, transparency and exitance.
//
// The base colour is taken as a diffuse reflectance, metals too, times its texture; what glows counts by the mean of its texture.
// Transparent materials get an alpha below 1, so that they hide nothing: blended and masked ones by their factor and the mean opacity
// of their texture (a half where it could not be read), transmitting ones by the light that they let pass.
// An emission of L cd/m^2 (the factors times KHR_materials_emissive_strength) is an exitance of pi L / 683 W/m^2.

static const double LOST_ALPHA = 0.5;
static const double MAX_STRENGTH = 1e9;  // cd/m^2 and more: the sun's disc has 1.6e9

// Names of the extensions that describe a surface otherwise.
static const char GLOSSY[] = "KHR_materials_pbrSpecularGlossiness",
                  STRENGTH[] = "KHR_materials_emissive_strength",
                  TRANSMISSION[] = "KHR_materials_transmission";

static bool is_opaque(Gltf *g, const GltfItem *item) {
    const char *mode = gltf_text(g, item, "alphaMode", "OPAQUE");
    bool opaque = strcmp(mode, "OPAQUE") == 0;
    if (!opaque && strcmp(mode, "MASK") != 0 && strcmp(mode, "BLEND") != 0)
        gltf_fail(g, item, "alphaMode", "is %.20s (allowed: OPAQUE, MASK, BLEND)", mode);
    return opaque;
}

// `opacity` is the mean of the texture.
static float alpha_of(Gltf *g, const GltfItem *item, double factor, double opacity) {
    GltfItem extension = gltf_extension(g, item, TRANSMISSION);
    double passes = gltf_number(g, &extension, "transmissionFactor", 0, 1, 0);
    double cutoff = gltf_number(g, item, "alphaCutoff", 0, GLTF_MAX_NUMBER, 0.5), alpha = 1;
    if (strcmp(gltf_text(g, item, "alphaMode", "OPAQUE"), "MASK") == 0)
        alpha = factor < cutoff ? 0 : opacity;
    else if (!is_opaque(g, item))
        alpha = factor * opacity;
    return (float)fmin(alpha, 1 - passes);
}

static Rgb emission_of(Gltf *g, const GltfItem *item) {
    double factor[3] = {0};
    Rgb mean = {1, 1, 1};
    GltfPicture picture;
    GltfItem extension = gltf_extension(g, item, STRENGTH);
    double strength = gltf_number(g, &extension, "emissiveStrength", 0, MAX_STRENGTH, 1);
    gltf_numbers(g, item, "emissiveFactor", 3, 0, 1, factor);
    bool glows = factor[0] + factor[1] + factor[2] > 0;
    if (glows && gltf_read_picture(g, item, "emissiveTexture", GLTF_MEAN, &picture)) mean = picture.mean;
    double scale = M_PI / GLTF_LUMENS_PER_WATT * strength;
    return (Rgb){(float)(scale * factor[0]) * mean.r, (float)(scale * factor[1]) * mean.g,
                 (float)(scale * factor[2]) * mean.b};
}

// A metal that is no rougher than this is a mirror: what it shows is blurred by less than half a degree (roughness squared, radians).
#define MIRROR_METAL 0.9
#define MIRROR_ROUGHNESS 0.08

static void make_material(Gltf *g, const GltfItem *item, GltfMaterial *out) {
    GltfItem base = gltf_member(g, item, "pbrMetallicRoughness"), glossy = gltf_extension(g, item, GLOSSY);
    double factor[4] = {1, 1, 1, 1}, opacity = 1;
    gltf_numbers(g, glossy.json ? &glossy : &base, glossy.json ? "diffuseFactor" : "baseColorFactor", 4, 0, 1,
                 factor);
    Rgb mean = {1, 1, 1};
    const char *texture = glossy.json ? "diffuseTexture" : "baseColorTexture";
    const GltfItem *surface = glossy.json ? &glossy : &base;
    GltfUse use = is_opaque(g, item) ? GLTF_OPAQUE : GLTF_OPACITY;
    if (gltf_read_picture(g, surface, texture, use, &out->picture)) {
        mean = out->picture.mean;
        opacity = (double)g->b->textures[out->picture.texture].opacity;
    } else if (surface->json && json_object_get(surface->json, texture)) {
        opacity = LOST_ALPHA;
    }
    const char *name = gltf_text(g, item, "name", "");
    Rgb colour = {(float)factor[0] * mean.r, (float)factor[1] * mean.g, (float)factor[2] * mean.b};
    Material material = {.name = name,
                         .reflectance = soup_cap(&g->reader, colour, MAPS_MAX_COLOUR,
                                                 arena_string(g->scratch, *name ? name : item->place)),
                         .emission = emission_of(g, item),
                         .alpha = alpha_of(g, item, factor[3], opacity),
                         .texture = out->picture.texture};
    if (g->failed) return;
    // A smooth metal reflects its colour as a mirror and scatters nothing.
    if (base.json && !json_object_get(base.json, "metallicRoughnessTexture") && material.alpha >= 1 &&
        gltf_number(g, &base, "metallicFactor", 0, 1, 1) >= MIRROR_METAL &&
        gltf_number(g, &base, "roughnessFactor", 0, 1, 1) <= MIRROR_ROUGHNESS) {
        double share = (factor[0] + factor[1] + factor[2]) / 3;
        material_make_mirror(&material, (float)share);
        material.reflectance = (Rgb){0, 0, 0};
    }
    if (g->failed) return;
    out->material = building_add_material(g->arena, g->b, material);
    out->made = true;
}

static const GltfMaterial *material_at(Gltf *g, int index) {
    if (g->failed) return NULL;
    GltfMaterial *known = &g->materials[index < 0 ? gltf_list_count(g, "materials") : index];
    if (known->made) return known;
    // A primitive without a material is white, says glTF.
    GltfItem none = {.place = "the default material"};
    if (index >= 0) none = gltf_item(g, "materials", index);
    make_material(g, &none, known);
    return known;
}

// ---- the triangles of a mesh's primitives (glTF 2.0, 3.7.2), joined to polygons

enum { MODE_TRIANGLES = 4, MODE_STRIP, MODE_FAN };

// Corner k of triangle i among the vertices in the order of the indices.
static int corner_of(int mode, int i, int k) {
    if (mode == MODE_TRIANGLES) return 3 * i + k;
    if (mode == MODE_FAN) return k == 2 ? 0 : i + 1 + k;
    // Every other triangle of a strip turns round.
    return k == 0 ? i : i + (k == 1 ? 1 + i % 2 : 2 - i % 2);
}

// The indices of a primitive's corners, NULL where they are the vertices in their order.
static bool decode_indices(Gltf *g, const GltfItem *item, int vertices, Arena *arena, double **out,
                           int *count) {
    int accessor = gltf_index(g, item, "indices", "accessors");
    if (g->failed) return false;
    *out = NULL;
    *count = vertices;
    if (accessor < 0) return true;
    *count = gltf_decode(g, accessor, 1, true, 3 * SOUP_MAX_POLYGONS, arena, out);
    if (*count == 0) return false;
    for (int i = 0; i < *count; i++) {
        if ((*out)[i] < vertices) continue;
        return gltf_fail(g, item, "indices", "index %d is %.0f (allowed 0 to %d)", i, (*out)[i],
                         vertices - 1);
    }
    return true;
}

static bool count_triangles(Gltf *g, const GltfItem *item, int mode, int corners, int *out) {
    if (mode == MODE_TRIANGLES && corners % 3 != 0)
        return gltf_fail(g, item, NULL, "has %d corners (allowed of triangles: a multiple of 3)", corners);
    *out = mode == MODE_TRIANGLES ? corners / 3 : corners - 2;
    if (*out >= 1 && *out <= SOUP_MAX_POLYGONS) return true;
    return gltf_fail(g, item, NULL, "has %d corners (allowed: 3 to %d)", corners, SOUP_MAX_POLYGONS);
}

// `places` of the vertices, or NULL.
static void list_triangles(int mode, const double *indices, const Vec2 *places, const GltfMaterial *material,
                           SoupMesh *mesh, Arena *arena) {
    mesh->faces = ARENA_ARRAY(arena, SoupFace, mesh->face_count);
    mesh->corners = ARENA_ARRAY(arena, int, 3 * mesh->face_count);
    if (places) mesh->places = ARENA_ARRAY(arena, Vec2, 3 * mesh->face_count);
    for (int i = 0; i < mesh->face_count; i++) {
        mesh->faces[i] = (SoupFace){mesh->corner_count, 3, material->material, material->picture.texture};
        for (int k = 0; k < 3; k++) {
            int corner = corner_of(mode, i, k), vertex = indices ? (int)indices[corner] : corner;
            if (places) mesh->places[mesh->corner_count] = places[vertex];
            mesh->corners[mesh->corner_count++] = vertex;
        }
    }
}

// Positions outlive the merging, which the rest does not.
static bool decode_primitive(Gltf *g, const GltfItem *item, Arena *work, SoupMesh *out) {
    GltfItem attributes = gltf_member(g, item, "attributes");
    int mode = gltf_int(g, item, "mode", 0, MODE_FAN, MODE_TRIANGLES);
    int position = gltf_index(g, &attributes, "POSITION", "accessors");
    const GltfMaterial *material = material_at(g, gltf_index(g, item, "material", "materials"));
    if (g->failed) return false;
    if (position < 0) return gltf_fail(g, item, "attributes.POSITION", "is missing");
    if (mode < MODE_TRIANGLES) {
        g->tally.lines++;
        return true;
    }
    double *places, *indices;
    int corners;
    SoupMesh mesh = {0};
    mesh.vertex_count = gltf_decode(g, position, 3, false, SOUP_MAX_VERTICES, work, &places);
    if (mesh.vertex_count == 0 || !decode_indices(g, item, mesh.vertex_count, work, &indices, &corners) ||
        !count_triangles(g, item, mode, corners, &mesh.face_count))
        return false;
    mesh.vertices = ARENA_ARRAY(g->scratch, Vec3, mesh.vertex_count);
    for (int i = 0; i < mesh.vertex_count; i++) {
        const double *v = places + 3 * (size_t)i;
        mesh.vertices[i] = vec3(v[0], v[1], v[2]);
    }
    Vec2 *on_picture = NULL;
    if (material->picture.texture > 0)
        on_picture = gltf_decode_places(g, &attributes, &material->picture, mesh.vertex_count, work);
    mesh.textures = g->b->textures;
    list_triangles(mode, indices, on_picture, material, &mesh, work);
    soup_merge(&mesh, g->scratch, out);
    return true;
}

static bool decode_mesh(Gltf *g, int index) {
    GltfMesh *mesh = &g->meshes[index];
    if (mesh->decoded) return true;
    GltfItem item = gltf_item(g, "meshes", index);
    int count = gltf_count(g, &item, "primitives");
    if (g->failed) return false;
    if (count == 0) return gltf_fail(g, &item, "primitives", "is missing or empty");
    mesh->primitives = ARENA_ARRAY(g->scratch, SoupMesh, count);
    for (int i = 0; i < count; i++) {
        GltfItem primitive = gltf_element(g, &item, "primitives", i);
        Arena work = {0};
        SoupMesh *kept = &mesh->primitives[mesh->primitive_count];
        bool good = decode_primitive(g, &primitive, &work, kept);
        mesh->primitive_count += kept->face_count > 0;
        if (gltf_count(g, &primitive, "targets") > 0) g->tally.skins++;
        arena_free(&work);
        if (!good) return false;
    }
    mesh->decoded = true;
    return true;
}

// ---- lights and cameras
//
// Lights (KHR_lights_punctual) and cameras of a glTF document.
//
// Candela become watts by the luminous efficacy exporters use, 683 lm/W: a point light of I cd shines with 4 pi I
// lumens, a spot with those in its outer cone, spread over all directions, since lights of a building are balls. Lights
// without a place (directional, in lux) are no lights of a building: they are left out and tallied.

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

static void add_light(Gltf *g, const GltfItem *node, const double m[12]) {
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
static void add_camera(Gltf *g, const GltfItem *node, const double m[12]) {
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

// ---- nodes
//
// The nodes of a scene (glTF 2.0, 3.5): a forest in which each node's way to its parent is a matrix or
// a translation, rotation and scale; its meshes, lights and cameras put in their places, y up turned to z up.

static const char INSTANCES[] = "EXT_mesh_gpu_instancing";

// Affine, row by row: x' = m[0] x + m[1] y + m[2] z + m[3], and so on.
typedef struct Placing {
    double m[12];
} Placing;

// (x, y, z) with y up becomes (x, -z, y).
static const Placing UPRIGHT = {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0}};

static Placing joined(const Placing *a, const Placing *b) {
    Placing out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) {
            double sum = c == 3 ? a->m[4 * r + 3] : 0;
            for (int k = 0; k < 3; k++) sum += a->m[4 * r + k] * b->m[4 * k + c];
            out.m[4 * r + c] = sum;
        }
    return out;
}

static Vec3 moved(const Placing *w, Vec3 v) {
    const double *m = w->m;
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3], m[4] * v.x + m[5] * v.y + m[6] * v.z + m[7],
                m[8] * v.x + m[9] * v.y + m[10] * v.z + m[11]);
}

static bool mirrors(const Placing *w) {
    const double *m = w->m;
    return vec3_dot(vec3_cross(vec3(m[0], m[4], m[8]), vec3(m[1], m[5], m[9])), vec3(m[2], m[6], m[10])) < 0;
}

static bool read_matrix(Gltf *g, const GltfItem *node, Placing *out) {
    double c[16];
    if (!gltf_numbers(g, node, "matrix", 16, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, c)) return false;
    for (int i = 0; i < 12; i++) out->m[i] = c[4 * (i % 4) + i / 4];
    if (c[3] == 0 && c[7] == 0 && c[11] == 0 && c[15] == 1) return true;
    return gltf_fail(g, node, "matrix", "ends its columns with %g, %g, %g, %g (allowed: 0, 0, 0, 1)", c[3],
                     c[7], c[11], c[15]);
}

static bool read_turn(Gltf *g, const GltfItem *node, double r[9]) {
    double q[4] = {0, 0, 0, 1};
    if (!gltf_numbers(g, node, "rotation", 4, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, q) && g->failed)
        return false;
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6)) return gltf_fail(g, node, "rotation", "has length %g (allowed: 1)", length);
    double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
    double turn[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    memcpy(r, turn, sizeof turn);
    return true;
}

static bool read_way(Gltf *g, const GltfItem *node, Placing *out) {
    if (json_object_get(node->json, "matrix")) return read_matrix(g, node, out);
    double t[3] = {0, 0, 0}, s[3] = {1, 1, 1}, r[9];
    gltf_numbers(g, node, "translation", 3, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, t);
    gltf_numbers(g, node, "scale", 3, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, s);
    if (g->failed || !read_turn(g, node, r)) return false;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) out->m[4 * i + k] = r[3 * i + k] * s[k];
        out->m[4 * i + 3] = t[i];
    }
    return true;
}

static bool place_face(Gltf *g, const GltfItem *node, const Placing *way, const SoupMesh *mesh,
                       const SoupFace *face) {
    Vec3 ring[SOUP_MAX_CORNERS];
    Vec2 places[SOUP_MAX_CORNERS];
    bool mirrored = mirrors(way);
    for (int i = 0; i < face->corner_count; i++) {
        Vec3 v = moved(way, mesh->vertices[mesh->corners[face->first_corner + i]]);
        if (!(fabs(v.x) <= MAPS_LIMIT && fabs(v.y) <= MAPS_LIMIT && fabs(v.z) <= MAPS_LIMIT)) {
            return gltf_fail(g, node, NULL,
                             "a corner of its mesh lies at (%g, %g, %g) m (allowed: within %g m)", v.x, v.y,
                             v.z, MAPS_LIMIT);
        }
        int at = mirrored ? face->corner_count - 1 - i : i;
        ring[at] = v;
        if (mesh->places) places[at] = mesh->places[face->first_corner + i];
    }
    size_t bytes = g->size + g->reader.bytes;
    int allowed = building_polygons_allowed((double)bytes);
    if (g->faces++ == allowed)
        return gltf_fail(g, node, NULL,
                         "its mesh makes more than %d polygons in all (the limit for %zu bytes)", allowed,
                         bytes);
    int added = building_add_textured(g->arena, g->b, ring, mesh->places ? places : NULL, face->corner_count,
                                      face->material);
    if (added == 0) g->tally.flat++;
    return true;
}

static bool place_mesh(Gltf *g, const GltfItem *node, const Placing *way) {
    int index = gltf_index(g, node, "mesh", "meshes");
    if (g->failed) return false;
    if (index < 0) return true;
    if (!decode_mesh(g, index)) return false;
    GltfItem item = gltf_item(g, "meshes", index), instances = gltf_extension(g, node, INSTANCES);
    if (instances.json)
        return gltf_fail(g, &instances, NULL, "is not read (allowed: a node for each instance)");
    if (json_object_get(node->json, "skin")) g->tally.skins++;
    const char *name = gltf_text(g, node, "name", gltf_text(g, &item, "name", ""));
    if (g->failed) return false;
    building_add_object(g->arena, g->b, OBJECT_FURNITURE, name);
    const GltfMesh *mesh = &g->meshes[index];
    for (int i = 0; i < mesh->primitive_count; i++) {
        const SoupMesh *primitive = &mesh->primitives[i];
        for (int f = 0; f < primitive->face_count; f++) {
            if (!place_face(g, node, way, primitive, &primitive->faces[f])) return false;
        }
    }
    if (g->b->objects[g->b->object_count - 1].polygon_count == 0) g->b->object_count--;
    return true;
}

// Each node has one parent at most; walking up from any of them ends.
static bool find_parents(Gltf *g, int count, int *parent) {
    for (int i = 0; i < count; i++) parent[i] = -1;
    for (int i = 0; i < count; i++) {
        GltfItem node = gltf_item(g, "nodes", i);
        int children = gltf_count(g, &node, "children");
        for (int k = 0; k < children; k++) {
            int child = gltf_index_at(g, &node, "children", k, "nodes");
            if (g->failed) return false;
            if (parent[child] >= 0)
                return gltf_fail(g, &node, "children",
                                 "node %d is a child of node %d too (allowed: one parent)", child,
                                 parent[child]);
            parent[child] = i;
        }
    }
    int *seen = ARENA_ARRAY(g->scratch, int, count);
    for (int i = 0; i < count; i++) {
        int at = i;
        for (; at >= 0 && seen[at] == 0; at = parent[at]) seen[at] = i + 1;
        if (at < 0 || seen[at] != i + 1) continue;
        GltfItem node = gltf_item(g, "nodes", at);
        return gltf_fail(g, &node, NULL, "is its own ancestor (allowed: no cycles)");
    }
    return !g->failed;
}

// The nodes without parent that the scene names, or all of them where there is no scene.
static bool find_roots(Gltf *g, int count, const int *parent, int *roots, int *root_count) {
    GltfItem root = gltf_root(g);
    *root_count = 0;
    int scenes = gltf_list_count(g, "scenes"), scene = gltf_index(g, &root, "scene", "scenes");
    if (g->failed) return false;
    if (scenes == 0) {
        for (int i = 0; i < count; i++)
            if (parent[i] < 0) roots[(*root_count)++] = i;
        return true;
    }
    GltfItem item = gltf_item(g, "scenes", scene < 0 ? 0 : scene);
    bool *named = ARENA_ARRAY(g->scratch, bool, count);
    int nodes = gltf_count(g, &item, "nodes");
    for (int i = 0; i < nodes; i++) {
        int node = gltf_index_at(g, &item, "nodes", i, "nodes");
        if (g->failed) return false;
        if (parent[node] >= 0 || named[node])
            return gltf_fail(g, &item, "nodes", "node %d is %s (allowed: nodes without parent, once)", node,
                             named[node] ? "named twice" : "a child");
        named[node] = true;
        roots[(*root_count)++] = node;
    }
    return true;
}

typedef struct Waiting {
    int node;
    Placing above;
} Waiting;

static bool place_tree(Gltf *g, int root, Waiting *stack) {
    int waiting = 1;
    stack[0] = (Waiting){root, UPRIGHT};
    while (waiting > 0) {
        Waiting at = stack[--waiting];
        GltfItem node = gltf_item(g, "nodes", at.node);
        Placing own;
        if (g->failed || !read_way(g, &node, &own)) return false;
        Placing way = joined(&at.above, &own);
        if (!place_mesh(g, &node, &way)) return false;
        add_light(g, &node, way.m);
        add_camera(g, &node, way.m);
        // Backwards, so that the first child comes first from the stack.
        for (int k = gltf_count(g, &node, "children") - 1; k >= 0; k--)
            stack[waiting++] = (Waiting){gltf_index_at(g, &node, "children", k, "nodes"), way};
        if (g->failed) return false;
    }
    return true;
}

static bool place_nodes(Gltf *g) {
    int count = gltf_list_count(g, "nodes"), root_count;
    if (g->failed) return false;
    int *parent = ARENA_ARRAY(g->scratch, int, count), *roots = ARENA_ARRAY(g->scratch, int, count);
    if (!find_parents(g, count, parent) || !find_roots(g, count, parent, roots, &root_count)) return false;
    // A node waits once at most, having one parent.
    Waiting *stack = ARENA_ARRAY(g->scratch, Waiting, count + 1);
    for (int i = 0; i < root_count; i++) {
        if (!place_tree(g, roots[i], stack)) return false;
    }
    return true;
}

// ---- the container

static uint32_t word_at(Bytes content, size_t at) {
    uint32_t word;
    memcpy(&word, content.data + at, sizeof word);
    return word;
}

static bool is_binary(Bytes content) { return content.size >= 4 && word_at(content, 0) == MAGIC; }

static bool open_binary(Gltf *g, Bytes content, Bytes *json) {
    if (content.size < HEADER + CHUNK_HEADER) {
        return error_set(g->error, "%s: has %zu bytes (a .glb file has %d at least)", g->path, content.size,
                         HEADER + CHUNK_HEADER);
    }
    if (word_at(content, 4) != 2)
        return error_set(g->error, "%s: byte 4: version %u (allowed: 2)", g->path, word_at(content, 4));
    if (word_at(content, 8) != content.size) {
        return error_set(g->error, "%s: byte 8: the length is given as %u (the file has %zu bytes)", g->path,
                         word_at(content, 8), content.size);
    }
    int chunk = 0;
    for (size_t at = HEADER; at < content.size; chunk++) {
        size_t left = content.size - at;
        if (left < CHUNK_HEADER || word_at(content, at) > left - CHUNK_HEADER) {
            return error_set(g->error, "%s: byte %zu: chunk %d is cut short (%zu bytes are left)", g->path,
                             at, chunk, left);
        }
        Bytes body = {content.data + at + CHUNK_HEADER, word_at(content, at)};
        uint32_t type = word_at(content, at + 4);
        if (chunk == 0 && type != CHUNK_JSON)
            return error_set(g->error, "%s: byte %zu: the first chunk has type %08X (allowed: JSON, %08X)",
                             g->path, at + 4, type, CHUNK_JSON);
        if (chunk == 0) *json = body;
        if (chunk == 1 && type == CHUNK_BIN) g->chunk = body;
        at += CHUNK_HEADER + body.size;
    }
    return true;
}

static bool parse_document(Gltf *g, Bytes json, size_t offset) {
    if (json.size > GLTF_MAX_JSON) {
        return error_set(g->error,
                         "%s: has %zu bytes of JSON (allowed: %zu; a .glb keeps its numbers outside)",
                         g->path, json.size, GLTF_MAX_JSON);
    }
    json_error_t why;
    static const char MARK[] = "\xEF\xBB\xBF";
    size_t skip = json.size >= 3 && memcmp(json.data, MARK, 3) == 0 ? 3 : 0;
    g->root = json_loadb((const char *)json.data + skip, json.size - skip, JSON_REJECT_DUPLICATES, &why);
    if (!g->root) {
        return error_set(g->error, "%s: byte %zu (line %d of the JSON): %.160s", g->path,
                         offset + skip + (size_t)(why.position > 0 ? why.position : 0), why.line, why.text);
    }
    if (json_is_object(g->root)) return true;
    return error_set(g->error, "%s: the JSON is no object (allowed: a glTF document)", g->path);
}

// ---- the document

static bool check_version(Gltf *g) {
    GltfItem root = gltf_root(g), asset = gltf_member(g, &root, "asset");
    const char *version = gltf_text(g, &asset, "version", "missing"),
               *least = gltf_text(g, &asset, "minVersion", "2.0");
    if (g->failed) return false;
    if (strncmp(version, "2.", 2) != 0)
        return gltf_fail(g, &asset, "version", "is %.20s (allowed: 2.0 and later 2)", version);
    if (strcmp(least, "2.0") != 0)
        return gltf_fail(g, &asset, "minVersion", "is %.20s (allowed: 2.0)", least);
    return true;
}

static bool is_known(const char *name) {
    for (size_t i = 0; i < sizeof EXTENSIONS / sizeof *EXTENSIONS; i++) {
        size_t length = strlen(EXTENSIONS[i]);
        bool family = EXTENSIONS[i][length - 1] == '_';
        if (family ? strncmp(name, EXTENSIONS[i], length) == 0 : strcmp(name, EXTENSIONS[i]) == 0)
            return true;
    }
    return false;
}

static bool check_extensions(Gltf *g) {
    GltfItem root = gltf_root(g);
    int count = gltf_count(g, &root, "extensionsRequired");
    for (int i = 0; i < count; i++) {
        const char *name =
            json_string_value(json_array_get(json_object_get(g->root, "extensionsRequired"), (size_t)i));
        if (name && is_known(name)) continue;
        return gltf_fail(g, &root, "extensionsRequired",
                         "`%.60s` is not read (allowed: documents that do without, exported again without "
                         "compression)",
                         name ? name : "what is no string");
    }
    return !g->failed;
}

static bool count_lists(Gltf *g) {
    int buffers = gltf_list_count(g, "buffers"), meshes = gltf_list_count(g, "meshes"),
        materials = gltf_list_count(g, "materials");
    if (g->failed) return false;
    if (materials > SOUP_MAX_MATERIALS) {
        GltfItem root = gltf_root(g);
        return gltf_fail(g, &root, "materials", "has %d elements (allowed: %d)", materials,
                         SOUP_MAX_MATERIALS);
    }
    g->buffers = ARENA_ARRAY(g->scratch, Bytes, buffers);
    g->meshes = ARENA_ARRAY(g->scratch, GltfMesh, meshes);
    g->materials = ARENA_ARRAY(g->scratch, GltfMaterial, materials + 1);
    return gltf_list_images(g);
}

static void note_count(Gltf *g, int count, const char *what) {
    if (count > 0)
        building_note(g->arena, g->b, NOTE_DROPPED, vec3(0, 0, 0), "%s: %d %s", g->path, count, what);
}

static void note_losses(Gltf *g) {
    note_count(g, g->tally.lines, "primitives of points or lines were left out");
    note_count(g, g->tally.flat, "polygons have no area and were left out");
    note_count(g, g->tally.suns, "directional lights have no place and were left out");
    note_count(
        g, g->tally.pictures,
        "textures are missing or could not be decoded (PNG, JPEG, BMP and WebP can): their materials keep "
        "their own colour");
    note_count(g, g->tally.placeless,
               "primitives with a texture do not say how it lies, and have its mean colour");
    note_count(
        g, g->tally.repeated,
        "primitives reach beyond their texture, which is repeated there instead of clamped or mirrored");
    note_count(g, g->tally.skins, "meshes with skins or morph targets are as at rest");
    int scenes = gltf_list_count(g, "scenes");
    if (scenes > 1) note_count(g, scenes - 1, "more scenes were left out: the default one was read");
}

static bool read_document(Gltf *g, Bytes content) {
    Bytes json = content;
    if (is_binary(content) && !open_binary(g, content, &json)) return false;
    if (!parse_document(g, json, (size_t)(json.data - content.data))) return false;
    if (!check_version(g) || !check_extensions(g) || !count_lists(g) || !place_nodes(g)) return false;
    note_losses(g);
    return soup_finish(&g->reader, "lengths in glTF are metres: scale the model before export", g->error);
}

static bool read_gltf(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Arena scratch = {0};
    Gltf g = {.path = path,
              .pixels = TEXTURE_FREE_PIXELS,
              .size = content.size,
              .reader = {.path = path, .arena = arena, .b = out},
              .arena = arena,
              .scratch = &scratch,
              .b = out,
              .error = error};
    bool good = read_document(&g, content);
    json_decref(g.root);
    arena_free(&scratch);
    return good;
}

// A .glb file, or JSON that speaks of an asset , as every document does.
static bool recognise_gltf(Bytes content) {
    if (is_binary(content)) return true;
    size_t at = 0;
    while (at < content.size && strchr(" \t\r\n\xEF\xBB\xBF", content.data[at]) && content.data[at]) at++;
    return at < content.size && content.data[at] == '{' &&
           memmem(content.data, content.size, "\"asset\"", strlen("\"asset\"")) != NULL;
}

const MapsReader MAPS_READER_GLTF = {
    .name = "gltf",
    .suffixes = ".glb .gltf",
    .summary = "glTF 2.0 models of buildings: polygons alone",
    .recognise = recognise_gltf,
    .read = read_gltf,
};
