// export_pictures.c - images by libpng's simplified interface.
#include "engine/app/export_pictures.h"

#include <png.h>
#include <string.h>

#include "engine/core/memory.h"

ExportPictures export_pictures(const Building *building, int first_view) {
    ExportPictures p = {.building = building, .first_view = first_view};
    p.images = json_array();
    p.textures = json_array();
    p.texture = ARENA_ARRAY(&p.arena, int, building->texture_count + 1);
    for (int i = 0; i < building->texture_count; i++) p.texture[i] = -1;
    return p;
}

void export_pictures_free(ExportPictures *p) {
    json_decref(p->images);
    json_decref(p->textures);
    memory_free(p->bytes);
    arena_free(&p->arena);
}

bool export_pictured(const Building *b, const Polygon *polygon) {
    const Material *m = &b->materials[polygon->material];
    bool emits = m->emission.r + m->emission.g + m->emission.b > 0;
    return m->texture > 0 && !emits && (polygon->texture_map || m->texture_map);
}

static void append_image(ExportPictures *p, const Texture *texture) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)texture->width,
                       .height = (png_uint_32)texture->height,
                       .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    size_t start = (p->size + 3) / 4 * 4;
    p->bytes = memory_grow(p->bytes, start + size);
    memset(p->bytes + p->size, 0, start - p->size);
    bool good = png_image_write_to_memory(&image, p->bytes + start, &size, 0, texture->texels, 0, NULL);
    CORE_ASSERT(good);
    p->size = start + size;
    *ARENA_PUSH(&p->arena, p->end, p->end_count, p->end_capacity) = p->size;
}

int export_picture(ExportPictures *p, int material) {
    int texture = p->building->materials[material].texture;
    if (p->texture[texture] >= 0) return p->texture[texture];
    const char *name = p->building->textures[texture].name;
    json_t *label = json_string(name);
    append_image(p, &p->building->textures[texture]);
    json_array_append_new(p->images,
                          json_pack("{s:o s:s s:i}", "name", label ? label : json_string("picture"),
                                    "mimeType", "image/png", "bufferView", p->first_view + p->end_count - 1));
    json_array_append_new(p->textures, json_pack("{s:i}", "source", p->end_count - 1));
    return p->texture[texture] = p->end_count - 1;
}

void export_picture_factor(const Building *b, int material, double out[3]) {
    rgb_doubles(b->textures[b->materials[material].texture].mean, out);
    for (int c = 0; c < 3; c++) out[c] = out[c] > 0 ? 1 / out[c] : 1;
}

void export_picture_place(const Building *b, const Polygon *polygon, Vec3 first, Vec3 p, float out[2]) {
    const TextureMap *map =
        &b->texture_maps[polygon->texture_map ? polygon->texture_map
                                              : b->materials[polygon->material].texture_map];
    double u0 = vec3_dot(map->u, first) + map->u0, v0 = vec3_dot(map->v, first) + map->v0;
    out[0] = (float)(vec3_dot(map->u, vec3_sub(p, first)) + u0 - floor(u0));
    out[1] = (float)(vec3_dot(map->v, vec3_sub(p, first)) + v0 - floor(v0));
}
