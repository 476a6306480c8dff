// gltf_buffer.c - the bytes of a glTF document: the BIN chunk, base64 in `data:` URIs (RFC 2397, RFC 4648), and files
// beside the document.
#include <limits.h>
#include <stdio.h>
#include <strings.h>

#include "maps/polygons/gltf.h"

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
    if (soup_read_beside(&g->folder, name, g->scratch, out, &why)) return true;
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
