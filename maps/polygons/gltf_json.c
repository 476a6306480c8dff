// gltf_json.c - parts of a glTF document with the JSON path that messages name.
#include "maps/polygons/gltf.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>

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
