// gltf_textures.c - pictures of a glTF document, and how they lie (glTF 2.0, 3.8 and KHR_texture_transform, Khronos 2021).
//
// A picture that is missing or cannot be decoded costs a note, and the material keeps its factor. Pictures are repeated: a sampler that
// clamps or mirrors is noted where a corner lies beyond the picture.
#include "maps/building/texture.h"
#include "maps/polygons/gltf.h"

// A picture of the document, decoded at most once for each use.
typedef struct GltfImage {
    bool asked[3];  // of GLTF_OPACITY, GLTF_OPAQUE, GLTF_MEAN
    int kept[2];    // in Building.textures; 0: of no use
    bool has_mean;
    Rgb mean;
} GltfImage;

bool gltf_list_images(Gltf *g) {
    g->images = ARENA_ARRAY(g->scratch, GltfImage, gltf_list_count(g, "images"));
    return !g->failed;
}

static bool read_image(Gltf *g, int index, Bytes *out) {
    GltfItem item = gltf_item(g, "images", index);
    const char *uri = gltf_text(g, &item, "uri", NULL);
    int view = gltf_index(g, &item, "bufferView", "bufferViews"), stride;
    if (g->failed) return false;
    if (view >= 0) return gltf_read_view(g, view, out, &stride);
    if (!uri) return gltf_fail(g, &item, NULL, "has neither uri nor bufferView");
    return gltf_read_uri(g, &item, uri, false, out);
}

static const char *name_of_image(Gltf *g, int index) {
    GltfItem item = gltf_item(g, "images", index);
    const char *uri = gltf_text(g, &item, "uri", item.place);
    return arena_string(g->scratch,
                        gltf_text(g, &item, "name", strncmp(uri, "data:", 5) == 0 ? item.place : uri));
}

static bool use_image(Gltf *g, int index, GltfUse use, GltfPicture *out) {
    GltfImage *image = &g->images[index];
    if (!image->asked[use]) {
        Bytes bytes = {0};
        image->asked[use] = true;
        bool read = read_image(g, index, &bytes);
        if (g->failed) return false;
        const char *name = name_of_image(g, index);
        if (read && use == GLTF_MEAN) image->has_mean = texture_mean(bytes, &g->pixels, &image->mean);
        if (read && use != GLTF_MEAN)
            image->kept[use] = use == GLTF_OPAQUE
                                   ? texture_add_opaque(g->arena, g->b, name, bytes, &g->pixels)
                                   : texture_add(g->arena, g->b, name, bytes, &g->pixels);
    }
    out->texture = use == GLTF_MEAN ? 0 : image->kept[use];
    out->mean = use == GLTF_MEAN ? image->mean
                : g->b->textures ? g->b->textures[out->texture].mean
                                 : (Rgb){0};
    return use == GLTF_MEAN ? image->has_mean : out->texture > 0;
}

// From a place in the file to the place in the picture: scaled, turned, shifted. The turn is counter-clockwise as the picture is
// seen, with v down.
static void read_way(Gltf *g, const GltfItem *transform, double way[6]) {
    double scale[2] = {1, 1}, offset[2] = {0, 0};
    gltf_numbers(g, transform, "scale", 2, -TEXTURE_FARTHEST, TEXTURE_FARTHEST, scale);
    gltf_numbers(g, transform, "offset", 2, -TEXTURE_FARTHEST, TEXTURE_FARTHEST, offset);
    double turn = gltf_number(g, transform, "rotation", -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, 0), c = cos(turn),
           s = sin(turn);
    const double made[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    memcpy(way, made, sizeof made);
}

static void read_sampler(Gltf *g, const GltfItem *texture, GltfPicture *out) {
    enum { REPEAT = 10497, LEAST = 10000, MOST = 40000 };
    int index = gltf_index(g, texture, "sampler", "samplers");
    if (g->failed || index < 0) return;
    GltfItem sampler = gltf_item(g, "samplers", index);
    out->ends[0] = gltf_int(g, &sampler, "wrapS", LEAST, MOST, REPEAT) != REPEAT;
    out->ends[1] = gltf_int(g, &sampler, "wrapT", LEAST, MOST, REPEAT) != REPEAT;
}

bool gltf_read_picture(Gltf *g, const GltfItem *item, const char *key, GltfUse use, GltfPicture *out) {
    *out = (GltfPicture){0};
    GltfItem info = gltf_member(g, item, key);
    int index = gltf_index(g, &info, "index", "textures");
    if (g->failed || index < 0) return false;
    GltfItem texture = gltf_item(g, "textures", index),
             webp = gltf_extension(g, &texture, "EXT_texture_webp"),
             transform = gltf_extension(g, &info, "KHR_texture_transform");
    const int source[2] = {gltf_index(g, &texture, "source", "images"),
                           gltf_index(g, &webp, "source", "images")};
    out->set = gltf_int(g, &info, "texCoord", 0, GLTF_MAX_SETS, 0);
    out->set = gltf_int(g, &transform, "texCoord", 0, GLTF_MAX_SETS, out->set);
    read_way(g, &transform, out->way);
    read_sampler(g, &texture, out);
    for (int i = 0; i < 2 && !g->failed; i++)
        if (source[i] >= 0 && use_image(g, source[i], use, out)) return true;
    if (!g->failed) g->tally.pictures++;
    return false;
}

Vec2 *gltf_decode_places(Gltf *g, const GltfItem *attributes, const GltfPicture *picture, int vertices,
                         Arena *arena) {
    char key[32];
    snprintf(key, sizeof key, "TEXCOORD_%d", picture->set);
    double *values;
    int accessor = gltf_index(g, attributes, key, "accessors"), count = 0;
    if (accessor >= 0) count = gltf_decode(g, accessor, 2, false, SOUP_MAX_VERTICES, arena, &values);
    if (count < vertices) {
        // A fault in what a picture needs costs the picture alone.
        g->failed = false;
        g->tally.placeless++;
        return NULL;
    }
    Vec2 *places = ARENA_ARRAY(arena, Vec2, vertices);
    const double *w = picture->way;
    bool beyond = false;
    static const double SLACK = 1e-3;  // single precision, and exporters that round
    for (int i = 0; i < vertices; i++) {
        double u = values[2 * i], v = values[2 * i + 1];
        places[i] = vec2(w[0] * u + w[1] * v + w[2], w[3] * u + w[4] * v + w[5]);
        beyond |= picture->ends[0] && fabs(places[i].x - 0.5) > 0.5 + SLACK;
        beyond |= picture->ends[1] && fabs(places[i].y - 0.5) > 0.5 + SLACK;
    }
    g->tally.repeated += beyond;
    return places;
}
