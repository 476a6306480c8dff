// gltf_accessor.c - the numbers that an accessor stands for (glTF 2.0, 3.6.2): of any component type, interleaved,
// normalised, sparse. Bytes are little-endian, as the machine is.
#include <limits.h>

#include "maps/polygons/gltf.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the reader copies numbers as they lie in the file"
#endif

typedef enum ComponentType {
    TYPE_I8 = 5120,
    TYPE_U8,
    TYPE_I16,
    TYPE_U16,
    TYPE_U32 = 5125,
    TYPE_F32
} ComponentType;

// Where numbers lie, and how.
typedef struct Source {
    const unsigned char *data;
    size_t stride;
    ComponentType type;
    bool normalised;
} Source;

static size_t component_size(ComponentType type) {
    return type == TYPE_I8 || type == TYPE_U8 ? 1 : type == TYPE_I16 || type == TYPE_U16 ? 2 : 4;
}

static bool read_type(Gltf *g, const GltfItem *item, ComponentType *out) {
    int type = gltf_int(g, item, "componentType", TYPE_I8, TYPE_F32, -1);
    if (g->failed) return false;
    if (type < 0 || type == TYPE_U32 - 1) {
        return gltf_fail(g, item, "componentType", "is %d (allowed 5120 to 5123, 5125, 5126)", type);
    }
    *out = (ComponentType)type;
    return true;
}

// Signed types are scaled so that 0 stays 0; their lowest value counts as -1.
static double number_at(const Source *source, size_t element, int component) {
    const unsigned char *at =
        source->data + element * source->stride + (size_t)component * component_size(source->type);
    int8_t i8;
    int16_t i16;
    uint16_t u16;
    uint32_t u32;
    float f32;
    switch (source->type) {
    case TYPE_I8:
        memcpy(&i8, at, sizeof i8);
        return source->normalised ? fmax(i8 / 127.0, -1) : i8;
    case TYPE_U8:
        return source->normalised ? *at / 255.0 : *at;
    case TYPE_I16:
        memcpy(&i16, at, sizeof i16);
        return source->normalised ? fmax(i16 / 32767.0, -1) : i16;
    case TYPE_U16:
        memcpy(&u16, at, sizeof u16);
        return source->normalised ? u16 / 65535.0 : u16;
    case TYPE_U32:
        memcpy(&u32, at, sizeof u32);
        return u32;
    case TYPE_F32:
        memcpy(&f32, at, sizeof f32);
        return (double)f32;
    }
    return 0;
}

// Finds `count` elements of `size` bytes that `item` says lie in a view; `any_stride`: views of indices are dense.
static bool locate(Gltf *g, const GltfItem *item, int count, size_t size, bool any_stride, Source *out) {
    int view = gltf_index(g, item, "bufferView", "bufferViews"), stride;
    int offset = gltf_int(g, item, "byteOffset", 0, INT_MAX, 0);
    Bytes bytes;
    if (g->failed) return false;
    if (view < 0) return gltf_fail(g, item, "bufferView", "is missing");
    if (!gltf_read_view(g, view, &bytes, &stride)) return false;
    out->stride = stride > 0 && any_stride ? (size_t)stride : size;
    if (out->stride < size)
        return gltf_fail(g, item, NULL, "elements of %zu bytes every %zu bytes (allowed: %zu or more)", size,
                         out->stride, size);
    size_t end = (size_t)offset + (size_t)(count - 1) * out->stride + size;
    if (end > bytes.size) {
        return gltf_fail(g, item, "count", "%d elements from byte %d end at byte %zu (its view has %zu)",
                         count, offset, end, bytes.size);
    }
    out->data = bytes.data + offset;
    return true;
}

static bool decode_sparse(Gltf *g, const GltfItem *item, const Source *of, int components, GltfValues *out) {
    GltfItem sparse = gltf_member(g, item, "sparse"), indices = gltf_member(g, &sparse, "indices"),
             values = gltf_member(g, &sparse, "values");
    if (g->failed || !sparse.json) return !g->failed;
    if (!indices.json || !values.json) return gltf_fail(g, &sparse, NULL, "lacks indices or values");
    int count = gltf_int(g, &sparse, "count", 1, out->count, 1), last = -1;
    Source index = {0}, value = *of;
    if (!read_type(g, &indices, &index.type)) return false;
    if (index.type == TYPE_F32 || index.type == TYPE_I8 || index.type == TYPE_I16)
        return gltf_fail(g, &indices, "componentType", "is %d (allowed 5121, 5123, 5125)", (int)index.type);
    if (!locate(g, &indices, count, component_size(index.type), false, &index) ||
        !locate(g, &values, count, component_size(of->type) * (size_t)components, false, &value))
        return false;
    for (int i = 0; i < count; i++) {
        double at = number_at(&index, (size_t)i, 0);
        if (at <= last || at >= out->count)
            return gltf_fail(g, &indices, NULL, "index %d is %.0f (allowed %d to %d: they increase)", i, at,
                             last + 1, out->count - 1);
        last = (int)at;
        for (int c = 0; c < components; c++)
            out->values[last * components + c] = number_at(&value, (size_t)i, c);
    }
    return true;
}

static bool check_type(Gltf *g, const GltfItem *item, int components, bool integer, const Source *source) {
    static const char *const TYPES[] = {NULL, "SCALAR", "VEC2", "VEC3", "VEC4"};
    const char *type = gltf_text(g, item, "type", "missing");
    if (g->failed) return false;
    if (strcmp(type, TYPES[components]) != 0)
        return gltf_fail(g, item, "type", "is %.20s (allowed here: %s)", type, TYPES[components]);
    bool whole = source->type == TYPE_U8 || source->type == TYPE_U16 || source->type == TYPE_U32;
    if (integer && (!whole || source->normalised))
        return gltf_fail(g, item, "componentType",
                         "is %d (allowed of indices: 5121, 5123, 5125, not normalised)", (int)source->type);
    if (source->normalised && (source->type == TYPE_U32 || source->type == TYPE_F32))
        return gltf_fail(g, item, "normalized", "is true (allowed of types 5120 to 5123, not %d)",
                         (int)source->type);
    return true;
}

static bool check_finite(Gltf *g, const GltfItem *item, const GltfValues *v, int components) {
    for (int i = 0; i < v->count * components; i++) {
        if (isfinite(v->values[i])) continue;
        return gltf_fail(g, item, NULL, "number %d of element %d is not finite", i % components,
                         i / components);
    }
    return true;
}

bool gltf_decode(Gltf *g, int accessor, int components, bool integer, int most, Arena *arena,
                 GltfValues *out) {
    GltfItem item = gltf_item(g, "accessors", accessor);
    Source source = {.normalised = gltf_flag(g, &item, "normalized")};
    int count = gltf_int(g, &item, "count", 1, most, -1);
    if (g->failed || !read_type(g, &item, &source.type) ||
        !check_type(g, &item, components, integer, &source))
        return false;
    if (count < 0) return gltf_fail(g, &item, "count", "is missing");
    size_t bytes = g->size + g->folder.bytes;
    int allowed = (int)fmin(GLTF_MAX_VALUES, GLTF_FREE_VALUES + GLTF_VALUES_A_BYTE * (double)bytes);
    if (count > (allowed - g->values) / components)
        return gltf_fail(
            g, &item, "count",
            "makes more than %d numbers in all, each time that an accessor is used (the limit for %zu bytes)",
            allowed, bytes);
    bool stored = json_object_get(item.json, "bufferView") != NULL;
    if (!stored && !json_object_get(item.json, "sparse"))
        return gltf_fail(g, &item, NULL, "has neither a bufferView nor sparse values");
    if (stored && !locate(g, &item, count, component_size(source.type) * (size_t)components, true, &source))
        return false;
    g->values += count * components;
    *out = (GltfValues){ARENA_ARRAY(arena, double, (size_t)count *(size_t)components), count};
    for (int i = 0; stored && i < count; i++)
        for (int c = 0; c < components; c++)
            out->values[i * components + c] = number_at(&source, (size_t)i, c);
    return decode_sparse(g, &item, &source, components, out) && check_finite(g, &item, out, components);
}
