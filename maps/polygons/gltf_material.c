// gltf_material.c - glTF materials as diffuse reflectances, transparency and exitance.
//
// The base colour is taken as a diffuse reflectance, metals too; textures count by their mean. Whatever may be seen
// through gets an alpha below 1, so that it hides nothing: blended materials by their factor, masked ones and blended
// ones with a texture by half, since where the texture has holes is not kept, transmitting ones by what they let pass.
// An emission of L cd/m^2 (the factors times KHR_materials_emissive_strength) is an exitance of pi L / 683 W/m^2.
#include "maps/building/texture.h"
#include "maps/polygons/gltf.h"

static const float TEXTURED_ALPHA = 0.5f;
static const double MAX_STRENGTH = 1e9;  // cd/m^2 and more: the sun's disc has 1.6e9

// Names of the extensions that describe a surface otherwise.
static const char GLOSSY[] = "KHR_materials_pbrSpecularGlossiness",
                  STRENGTH[] = "KHR_materials_emissive_strength",
                  TRANSMISSION[] = "KHR_materials_transmission";

static bool read_image(Gltf *g, int index, Bytes *out) {
    GltfItem item = gltf_item(g, "images", index);
    const char *uri = gltf_text(g, &item, "uri", NULL);
    int view = gltf_index(g, &item, "bufferView", "bufferViews"), stride;
    if (g->failed) return false;
    if (view >= 0) return gltf_read_view(g, view, out, &stride);
    if (!uri) return gltf_fail(g, &item, NULL, "has neither uri nor bufferView");
    return gltf_read_uri(g, &item, uri, false, out);
}

// The mean of the texture that `key` of `item` names. A picture that is missing or cannot be decoded is tallied, and so
// is one of a kind that an extension names instead of a `source`.
static bool read_texture(Gltf *g, const GltfItem *item, const char *key, Rgb *out) {
    GltfItem info = gltf_member(g, item, key);
    int texture = gltf_index(g, &info, "index", "textures");
    if (g->failed || texture < 0) return false;
    GltfItem of = gltf_item(g, "textures", texture);
    int image = gltf_index(g, &of, "source", "images");
    if (g->failed) return false;
    if (image >= 0) {
        GltfImage *known = &g->images[image];
        Bytes bytes = {0};
        if (!known->asked) {
            bool read = read_image(g, image, &bytes);
            if (g->failed) return false;
            known->usable = read && texture_mean(bytes, &g->pixels, &known->mean);
        }
        known->asked = true;
        *out = known->mean;
        if (known->usable) return true;
    }
    g->tally.pictures++;
    return false;
}

static float alpha_of(Gltf *g, const GltfItem *item, double factor, bool textured) {
    const char *mode = gltf_text(g, item, "alphaMode", "OPAQUE");
    GltfItem extension = gltf_extension(g, item, TRANSMISSION);
    double passes = gltf_number(g, &extension, "transmissionFactor", 0, 1, 0);
    double cutoff = gltf_number(g, item, "alphaCutoff", 0, GLTF_MAX_NUMBER, 0.5), alpha = 1;
    if (strcmp(mode, "MASK") == 0)
        alpha = factor < cutoff ? 0 : 1;
    else if (strcmp(mode, "BLEND") == 0)
        alpha = factor;
    else if (strcmp(mode, "OPAQUE") != 0)
        gltf_fail(g, item, "alphaMode", "is %.20s (allowed: OPAQUE, MASK, BLEND)", mode);
    if (textured && strcmp(mode, "OPAQUE") != 0) alpha = fmin(alpha, (double)TEXTURED_ALPHA);
    return (float)fmin(alpha, 1 - passes);
}

static Rgb emission_of(Gltf *g, const GltfItem *item) {
    double factor[3] = {0};
    Rgb mean = {1, 1, 1};
    GltfItem extension = gltf_extension(g, item, STRENGTH);
    double strength = gltf_number(g, &extension, "emissiveStrength", 0, MAX_STRENGTH, 1);
    gltf_numbers(g, item, "emissiveFactor", 3, 0, 1, factor);
    Rgb read;
    if (factor[0] + factor[1] + factor[2] > 0 && read_texture(g, item, "emissiveTexture", &read)) mean = read;
    double scale = M_PI / GLTF_LUMENS_PER_WATT * strength;
    return (Rgb){(float)(scale * factor[0]) * mean.r, (float)(scale * factor[1]) * mean.g,
                 (float)(scale * factor[2]) * mean.b};
}

static int make_material(Gltf *g, const GltfItem *item) {
    GltfItem base = gltf_member(g, item, "pbrMetallicRoughness"), glossy = gltf_extension(g, item, GLOSSY);
    double factor[4] = {1, 1, 1, 1};
    gltf_numbers(g, glossy.json ? &glossy : &base, glossy.json ? "diffuseFactor" : "baseColorFactor", 4, 0, 1,
                 factor);
    Rgb mean = {1, 1, 1}, read;
    const char *texture = glossy.json ? "diffuseTexture" : "baseColorTexture";
    const GltfItem *surface = glossy.json ? &glossy : &base;
    bool textured = surface->json && json_object_get(surface->json, texture);
    if (textured && read_texture(g, surface, texture, &read)) mean = read;
    const char *name = gltf_text(g, item, "name", "");
    Rgb colour = {(float)factor[0] * mean.r, (float)factor[1] * mean.g, (float)factor[2] * mean.b};
    Material material = {
        .name = name,
        .reflectance = soup_cap(colour, arena_string(g->scratch, *name ? name : item->place), &g->capped),
        .emission = emission_of(g, item),
        .alpha = alpha_of(g, item, factor[3], textured)};
    if (g->failed) return -1;
    return building_add_material(g->arena, g->b, material);
}

int gltf_material(Gltf *g, int index) {
    if (g->failed) return -1;
    int *known = &g->materials[index < 0 ? gltf_list_count(g, "materials") : index];
    if (*known >= 0) return *known;
    // A primitive without a material is white, says glTF.
    GltfItem none = {.place = "the default material"};
    if (index >= 0) none = gltf_item(g, "materials", index);
    *known = make_material(g, &none);
    return *known;
}
