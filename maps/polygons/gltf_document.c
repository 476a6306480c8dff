// gltf_document.c - parts of a glTF document with the JSON path that messages name; bytes and numbers that the document holds.
#include "maps/polygons/gltf.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <strings.h>

bool gltf_fail(Gltf *g, const GltfItem *item, const char *key, const char *format, ...) {
    if (g->failed) return false;
    g->failed = true;
    va_list args;
    va_start(args, format);
    const char *sentence = arena_format_list(g->scratch, format, args);
    va_end(args);
    bool both = key && *item->place;
    return error_set(g->error, "%s: %s%s%s%s%.600s", g->path, item->place, both ? "." : "", key ? key : "",
                     key || *item->place ? ": " : "", sentence);
}

GltfItem gltf_root(const Gltf *g) { return (GltfItem){.json = g->root}; }

static const char *kind_of(const json_t *json) {
    static const char *const KINDS[] = {
        [JSON_OBJECT] = "an object", [JSON_ARRAY] = "an array", [JSON_STRING] = "a string",
        [JSON_INTEGER] = "a number", [JSON_REAL] = "a number",  [JSON_TRUE] = "true",
        [JSON_FALSE] = "false",      [JSON_NULL] = "null"};
    return KINDS[json_typeof(json)];
}

// The array `key`, or NULL where it is absent or none.
static const json_t *array_of(Gltf *g, const GltfItem *item, const char *key) {
    const json_t *array = item->json ? json_object_get(item->json, key) : NULL;
    if (!array || g->failed) return NULL;
    if (json_is_array(array)) return array;
    gltf_fail(g, item, key, "is %s (allowed: an array)", kind_of(array));
    return NULL;
}

int gltf_count(Gltf *g, const GltfItem *item, const char *key) {
    const json_t *array = array_of(g, item, key);
    size_t size = array ? json_array_size(array) : 0;
    if (size <= GLTF_MAX_LIST) return (int)size;
    gltf_fail(g, item, key, "has %zu elements (allowed: %d)", size, GLTF_MAX_LIST);
    return 0;
}

static GltfItem only_object(Gltf *g, GltfItem out) {
    if (!out.json || json_is_object(out.json)) return out;
    gltf_fail(g, &out, NULL, "is %s (allowed: an object)", kind_of(out.json));
    out.json = NULL;
    return out;
}

GltfItem gltf_element(Gltf *g, const GltfItem *item, const char *key, int i) {
    GltfItem out = {0};
    const json_t *array = array_of(g, item, key);
    snprintf(out.place, sizeof out.place, "%.50s%s%.30s[%d]", item->place, *item->place ? "." : "", key, i);
    if (array && i >= 0) out.json = json_array_get(array, (size_t)i);
    if (!out.json) gltf_fail(g, &out, NULL, "is not there (the list has %d)", gltf_count(g, item, key));
    return only_object(g, out);
}

GltfItem gltf_member(Gltf *g, const GltfItem *item, const char *key) {
    GltfItem out = {0};
    snprintf(out.place, sizeof out.place, "%.55s%s%.35s", item->place, *item->place ? "." : "", key);
    if (item->json && !g->failed) out.json = json_object_get(item->json, key);
    return only_object(g, out);
}

GltfItem gltf_extension(Gltf *g, const GltfItem *item, const char *name) {
    GltfItem all = gltf_member(g, item, "extensions");
    return gltf_member(g, &all, name);
}

GltfItem gltf_item(Gltf *g, const char *list, int i) {
    GltfItem root = gltf_root(g);
    return gltf_element(g, &root, list, i);
}

int gltf_list_count(Gltf *g, const char *list) {
    GltfItem root = gltf_root(g);
    return gltf_count(g, &root, list);
}

// Whole numbers may be written with a fraction of zero, as some exporters do, and are told to their last digit.
static double number_of(Gltf *g, const GltfItem *item, const char *key, const json_t *json, double low,
                        double high, bool whole) {
    double value = json_is_number(json) ? json_number_value(json) : NAN;
    int digits = whole ? 17 : 6;
    if (value >= low && value <= high && (!whole || value == floor(value))) return value;
    if (json_is_number(json))
        gltf_fail(g, item, key, "is %.*g (allowed %.*g to %.*g)", digits, value, digits, low, digits, high);
    else
        gltf_fail(g, item, key, "is %s (allowed: a number from %.*g to %.*g)", kind_of(json), digits, low,
                  digits, high);
    return low;
}

static int int_of(Gltf *g, const GltfItem *item, const char *key, const json_t *json, int low, int high) {
    return (int)number_of(g, item, key, json, low, high, true);
}

int gltf_int(Gltf *g, const GltfItem *item, const char *key, int low, int high, int absent) {
    const json_t *json = item->json ? json_object_get(item->json, key) : NULL;
    return json && !g->failed ? int_of(g, item, key, json, low, high) : absent;
}

double gltf_number(Gltf *g, const GltfItem *item, const char *key, double low, double high, double absent) {
    const json_t *json = item->json ? json_object_get(item->json, key) : NULL;
    return json && !g->failed ? number_of(g, item, key, json, low, high, false) : absent;
}

bool gltf_flag(Gltf *g, const GltfItem *item, const char *key) {
    const json_t *json = item->json ? json_object_get(item->json, key) : NULL;
    if (!json || g->failed) return false;
    if (!json_is_boolean(json)) gltf_fail(g, item, key, "is %s (allowed: true, false)", kind_of(json));
    return json_is_true(json);
}

const char *gltf_text(Gltf *g, const GltfItem *item, const char *key, const char *absent) {
    const json_t *json = item->json ? json_object_get(item->json, key) : NULL;
    if (!json || g->failed) return absent;
    if (json_is_string(json)) return json_string_value(json);
    gltf_fail(g, item, key, "is %s (allowed: a string)", kind_of(json));
    return absent;
}

static int index_of(Gltf *g, const GltfItem *item, const char *key, const json_t *json, const char *list) {
    int count = gltf_list_count(g, list);
    if (count > 0) return int_of(g, item, key, json, 0, count - 1);
    gltf_fail(g, item, key, "refers to the document's %s (it has none)", list);
    return -1;
}

int gltf_index(Gltf *g, const GltfItem *item, const char *key, const char *list) {
    const json_t *json = item->json ? json_object_get(item->json, key) : NULL;
    return json && !g->failed ? index_of(g, item, key, json, list) : -1;
}

int gltf_index_at(Gltf *g, const GltfItem *item, const char *key, int i, const char *list) {
    const json_t *array = array_of(g, item, key), *json = array ? json_array_get(array, (size_t)i) : NULL;
    char which[64];
    snprintf(which, sizeof which, "%.40s[%d]", key, i);
    return json ? index_of(g, item, which, json, list) : -1;
}

bool gltf_numbers(Gltf *g, const GltfItem *item, const char *key, int count, double low, double high,
                  double *out) {
    const json_t *array = array_of(g, item, key);
    if (!array) return false;
    if (gltf_count(g, item, key) != count)
        return gltf_fail(g, item, key, "has %d numbers (allowed: %d)", gltf_count(g, item, key), count);
    for (int i = 0; i < count; i++) {
        char which[64];
        snprintf(which, sizeof which, "%.40s[%d]", key, i);
        out[i] = number_of(g, item, which, json_array_get(array, (size_t)i), low, high, false);
    }
    return !g->failed;
}

// ---- bytes
//
// The bytes of a glTF document: the BIN chunk, base64 in `data:` URIs (RFC 2397, RFC 4648), and files
// beside the document.

static int sextet(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

static bool decode_base64(Gltf *g, const GltfItem *item, const char *text, Bytes *out) {
    size_t length = strlen(text), used = 0;
    while (length > 0 && text[length - 1] == '=') length--;
    out->data = arena_alloc(g->scratch, length / 4 * 3 + 4, 1);
    unsigned bits = 0;
    for (size_t i = 0; i < length; i++) {
        int value = sextet(text[i]);
        if (value < 0) {
            return gltf_fail(g, item, "uri", "character %zu of the data is byte %d (allowed: base64)", i,
                             (unsigned char)text[i]);
        }
        bits = bits << 6 | (unsigned)value;
        if (i % 4 != 0) out->data[used++] = (unsigned char)(bits >> (6 - 2 * (i % 4)) & 255);
    }
    out->size = used;
    return true;
}

// A file's name may hold any byte as %XX.
static bool decode_percent(Gltf *g, const GltfItem *item, const char *uri, char **out) {
    char *to = *out = arena_string(g->scratch, uri);
    for (const char *from = uri; *from; from++) {
        unsigned code;
        int used = 0;
        if (*from != '%') {
            *to++ = *from;
            continue;
        }
        if (sscanf(from, "%%%2x%n", &code, &used) != 1 || used != 3 || code == 0)
            return gltf_fail(g, item, "uri", "has `%.3s` (allowed: %%01 to %%FF)", from);
        *to++ = (char)code;
        from += 2;
    }
    *to = 0;
    return true;
}

bool gltf_read_uri(Gltf *g, const GltfItem *item, const char *uri, bool needed, Bytes *out) {
    if (strncasecmp(uri, "data:", 5) == 0) {
        const char *comma = strchr(uri, ',');
        static const char MARK[] = ";base64";
        size_t mark = sizeof MARK - 1;
        if (!comma || (size_t)(comma - uri) < 5 + mark || strncasecmp(comma - mark, MARK, mark) != 0)
            return gltf_fail(g, item, "uri", "is `%.40s` (allowed of data: `data:TYPE;base64,...`)", uri);
        return decode_base64(g, item, comma + 1, out);
    }
    char *name;
    Error why = {""};
    if (!decode_percent(g, item, uri, &name)) return false;
    if (soup_read_beside(&g->reader, name, g->scratch, out, &why)) return true;
    return needed && gltf_fail(g, item, "uri", "cannot be read: %.400s", why.text);
}

static bool read_buffer(Gltf *g, int index, Bytes *out) {
    Bytes *known = &g->buffers[index];
    GltfItem item = gltf_item(g, "buffers", index);
    const char *uri = gltf_text(g, &item, "uri", NULL);
    int length = gltf_int(g, &item, "byteLength", 1, INT_MAX, -1);
    if (g->failed) return false;
    if (length < 0) return gltf_fail(g, &item, "byteLength", "is missing");
    if (!known->data) {
        if (uri && !gltf_read_uri(g, &item, uri, true, known)) return false;
        if (!uri && (index != 0 || !g->chunk.data))
            return gltf_fail(g, &item, "uri",
                             "is missing (allowed of the first buffer of a .glb with a BIN chunk)");
        if (!uri) *known = g->chunk;
    }
    if (known->size < (size_t)length)
        return gltf_fail(g, &item, "byteLength", "is %d (the buffer has %zu bytes)", length, known->size);
    *out = (Bytes){known->data, (size_t)length};
    return true;
}

bool gltf_read_view(Gltf *g, int view, Bytes *out, int *stride) {
    GltfItem item = gltf_item(g, "bufferViews", view);
    int buffer = gltf_index(g, &item, "buffer", "buffers");
    int offset = gltf_int(g, &item, "byteOffset", 0, INT_MAX, 0),
        length = gltf_int(g, &item, "byteLength", 1, INT_MAX, -1);
    *stride = gltf_int(g, &item, "byteStride", 4, 252, 0);
    if (g->failed) return false;
    if (buffer < 0) return gltf_fail(g, &item, "buffer", "is missing");
    if (length < 0) return gltf_fail(g, &item, "byteLength", "is missing");
    Bytes whole = {0};
    if (!read_buffer(g, buffer, &whole)) return false;
    if ((size_t)offset + (size_t)length > whole.size) {
        return gltf_fail(g, &item, NULL, "bytes %d to %zu (its buffer has %zu)", offset,
                         (size_t)offset + (size_t)length, whole.size);
    }
    *out = (Bytes){whole.data + offset, (size_t)length};
    return true;
}

// ---- numbers
//
// The numbers that an accessor stands for (glTF 2.0, 3.6.2): of any component type, interleaved,
// normalised, sparse. Bytes are little-endian, as the machine is.

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

// Overwrites some of the `total` elements.
static bool decode_sparse(Gltf *g, const GltfItem *item, const Source *of, int components, double *out,
                          int total) {
    GltfItem sparse = gltf_member(g, item, "sparse"), indices = gltf_member(g, &sparse, "indices"),
             values = gltf_member(g, &sparse, "values");
    if (g->failed || !sparse.json) return !g->failed;
    if (!indices.json || !values.json) return gltf_fail(g, &sparse, NULL, "lacks indices or values");
    int count = gltf_int(g, &sparse, "count", 1, total, 1), last = -1;
    Source index = {0}, value = *of;
    if (!read_type(g, &indices, &index.type)) return false;
    if (index.type == TYPE_F32 || index.type == TYPE_I8 || index.type == TYPE_I16)
        return gltf_fail(g, &indices, "componentType", "is %d (allowed 5121, 5123, 5125)", (int)index.type);
    if (!locate(g, &indices, count, component_size(index.type), false, &index) ||
        !locate(g, &values, count, component_size(of->type) * (size_t)components, false, &value))
        return false;
    for (int i = 0; i < count; i++) {
        double at = number_at(&index, (size_t)i, 0);
        if (at <= last || at >= total)
            return gltf_fail(g, &indices, NULL, "index %d is %.0f (allowed %d to %d: they increase)", i, at,
                             last + 1, total - 1);
        last = (int)at;
        for (int c = 0; c < components; c++) out[last * components + c] = number_at(&value, (size_t)i, c);
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

static bool check_finite(Gltf *g, const GltfItem *item, const double *v, int count, int components) {
    for (int i = 0; i < count * components; i++) {
        if (isfinite(v[i])) continue;
        return gltf_fail(g, item, NULL, "number %d of element %d is not finite", i % components,
                         i / components);
    }
    return true;
}

// Whether so many elements, -1 where the file does not say, are within the bounds of all numbers.
static bool check_count(Gltf *g, const GltfItem *item, int components, int count) {
    if (count < 0) return gltf_fail(g, item, "count", "is missing");
    size_t bytes = g->size + g->reader.bytes;
    int allowed = (int)fmin(GLTF_MAX_VALUES, GLTF_FREE_VALUES + GLTF_VALUES_A_BYTE * (double)bytes);
    if (count <= (allowed - g->values) / components) return true;
    return gltf_fail(
        g, item, "count",
        "makes more than %d numbers in all, each time that an accessor is used (the limit for %zu bytes)",
        allowed, bytes);
}

int gltf_decode(Gltf *g, int accessor, int components, bool integer, int most, Arena *arena, double **out) {
    GltfItem item = gltf_item(g, "accessors", accessor);
    Source source = {.normalised = gltf_flag(g, &item, "normalized")};
    int count = gltf_int(g, &item, "count", 1, most, -1);
    if (g->failed || !read_type(g, &item, &source.type) ||
        !check_type(g, &item, components, integer, &source) || !check_count(g, &item, components, count))
        return 0;
    bool stored = json_object_get(item.json, "bufferView") != NULL;
    if (!stored && !json_object_get(item.json, "sparse")) {
        gltf_fail(g, &item, NULL, "has neither a bufferView nor sparse values");
        return 0;
    }
    if (stored && !locate(g, &item, count, component_size(source.type) * (size_t)components, true, &source))
        return 0;
    g->values += count * components;
    double *values = *out = ARENA_ARRAY(arena, double, (size_t)count *(size_t)components);
    for (int i = 0; stored && i < count; i++)
        for (int c = 0; c < components; c++) values[i * components + c] = number_at(&source, (size_t)i, c);
    bool good = decode_sparse(g, &item, &source, components, values, count) &&
                check_finite(g, &item, values, count, components);
    return good ? count : 0;
}
