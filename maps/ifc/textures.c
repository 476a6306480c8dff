// textures.c - pictures of surface styles, and how they lie on faces (ISO 16739, IfcPresentationAppearanceResource).
#include <math.h>

#include "maps/building/texture.h"
#include "maps/ifc/ifc_file.h"

enum { MOST_TEXTURES = 1000, MOST_COMPONENTS = 4 };

// ---- pictures

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

// Binary data as bytes. The first digit tells how many bits of the next one are unused; of an odd number of digits, the first byte has
// one. Returns how many bytes there are, `most` at most, or -1 where other than digits stand there.
static long long decode(const StepFile *file, const StepValue *v, unsigned char *out, long long most) {
    const char *text = file->text + v->at;
    if (v->kind != STEP_BINARY || v->size < 1) return -1;
    long long count = 0;
    int high = v->size % 2 ? -1 : 0;  // the digit that waits for its other half, -1: none does
    for (size_t at = 1; at < v->size && count < most; at++) {
        int digit = hex_digit(text[at]);
        if (digit < 0) return -1;
        if (high >= 0) out[count++] = (unsigned char)(high * 16 + digit);
        high = high >= 0 ? -1 : digit;
    }
    return count;
}

static bool read_blob(Reader *r, const StepValue *v, IfcTexture *out) {
    if (v->kind != STEP_BINARY) return false;
    long long room = (long long)(v->size / 2) + 1;
    out->image.data = arena_alloc(&r->kept, (size_t)room, 1);
    long long count = decode(&r->file->step, v, out->image.data, room - 1);
    if (count > 0) out->image.size = (size_t)count;
    return count > 0;
}

static int list_length(Reader *r, const StepValue *list) {
    int count = 0;
    StepCursor c = ifc_list(r, list);
    while (step_next(&c).kind != STEP_END) count++;
    return count;
}

// `v` are width, height, components and pixels. As in other formats of scenes, the first pixel is the lower left one.
static bool read_pixels(Reader *r, const StepValue *v, IfcTexture *out) {
    double width = ifc_number(r, &v[0], 0), height = ifc_number(r, &v[1], 0),
           components = ifc_number(r, &v[2], 0);
    if (!(width >= 1 && height >= 1 && components >= 1 && components <= MOST_COMPONENTS) ||
        !(width * height <= TEXTURE_MAX_PIXELS) || list_length(r, &v[3]) < (int)(width * height))
        return false;
    out->width = (int)width;
    out->height = (int)height;
    out->pixels = arena_alloc(&r->kept, (size_t)out->width * (size_t)out->height * 4, 1);
    StepCursor c = ifc_list(r, &v[3]);
    int parts = (int)components;
    for (int i = 0; i < out->width * out->height; i++) {
        StepValue pixel = step_next(&c);
        unsigned char from[MOST_COMPONENTS];
        if (decode(&r->file->step, &pixel, from, parts) != parts) return false;
        int row = out->height - 1 - i / out->width;
        uint8_t *to = out->pixels + 4 * ((size_t)row * (size_t)out->width + (size_t)(i % out->width));
        for (int k = 0; k < 3; k++) to[k] = from[parts >= 3 ? k : 0];
        to[3] = parts % 2 ? 255 : from[parts - 1];
    }
    return true;
}

// IFC4 has a list of parameters before what IFC2X3 has.
static bool read_picture(Reader *r, int record, IfcTexture *out) {
    StepValue v[9];
    if (!ifc_arguments(r, record, v, 9)) return false;
    const StepValue *name = v[5].kind == STEP_STRING ? &v[5] : &v[4];
    switch (ifc_type(r, record)) {
    case T_IMAGETEXTURE:
        if (name->kind == STEP_STRING) out->file = step_string(&r->file->step, name, &r->strings);
        return out->file != NULL;
    case T_BLOBTEXTURE:
        return read_blob(r, v[6].kind == STEP_BINARY ? &v[6] : &v[5], out);
    case T_PIXELTEXTURE:
        return read_pixels(r, v[4].kind == STEP_NUMBER ? &v[4] : &v[5], out);
    default:
        return false;
    }
}

int ifc_read_texture(Reader *r, IfcFile *file, int record) {
    if (record < 0) return 0;
    IfcTexture texture = {.entity = file->step.entity[record]};
    for (int i = 1; i < file->texture_count; i++)
        if (file->textures[i].entity == texture.entity) return i;
    if (!read_picture(r, record, &texture)) {
        ifc_note(r, record, "has no picture that is read");
        return 0;
    }
    if (file->texture_count >= MOST_TEXTURES) {
        ifc_note(r, record, "is one picture too many (allowed: %d)", MOST_TEXTURES - 1);
        return 0;
    }
    if (file->texture_count == 0)
        ARENA_PUSH(&r->kept, file->textures, file->texture_count, file->texture_room)->entity = -1;
    *ARENA_PUSH(&r->kept, file->textures, file->texture_count, file->texture_room) = texture;
    return file->texture_count - 1;
}

// ---- places

// The map of places that the first of a list of textures has.
static Frame transform_of(Reader *r, const StepValue *maps) {
    StepCursor c = ifc_list(r, maps);
    StepValue first = step_next(&c), v[4];
    if (first.kind != STEP_REF || !ifc_arguments(r, first.record, v, 4) || v[3].kind != STEP_REF ||
        v[3].record < 0)
        return frame_identity();
    Frame f = ifc_operator(r, v[3].record);
    // Lengths are metres, but places have no unit.
    f.o = vec3_scale(f.o, 1 / r->file->length);
    return f;
}

// Pictures of buildings begin at the top, those of models at the bottom.
static Vec2 picture_place(const Frame *transform, const double st[2]) {
    Vec3 p = frame_point(transform, vec3(st[0], st[1], 0));
    return vec2(p.x, 1 - p.y);
}

static void indexed_places(Reader *r, const StepValue v[4], const Frame *transform, IfcPlaces *out) {
    StepValue list;
    int room = 0, index_room = 0;
    if (ifc_type(r, v[2].record) != T_TEXTUREVERTEXLIST || !ifc_arguments(r, v[2].record, &list, 1)) return;
    StepCursor c = ifc_list(r, &list);
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        double st[2] = {0, 0};
        step_numbers(&c, &s, st, 2);
        *ARENA_PUSH(&r->scratch, out->at, out->count, room) = picture_place(transform, st);
    }
    ifc_count_points(r, out->count);
    c = ifc_list(r, &v[3]);
    for (StepValue t = step_next(&c); t.kind != STEP_END; t = step_next(&c)) {
        double index[3] = {0, 0, 0};
        bool good = step_numbers(&c, &t, index, 3) == 3;
        for (int i = 0; i < 3; i++) good = good && index[i] >= 1 && index[i] <= out->count;
        if (!good) {
            ifc_note(r, v[1].record,
                     "has a triangle whose places in its picture are %g, %g and %g (allowed 1 to %d)",
                     index[0], index[1], index[2], out->count);
            return;
        }
        for (int i = 0; i < 3; i++)
            *ARENA_PUSH(&r->scratch, out->index, out->index_count, index_room) = (int)index[i] - 1;
    }
}

static void vertex_places(Reader *r, const StepValue *vertices, const Frame *transform, IfcPlaces *out) {
    int room = 0;
    StepCursor c = ifc_list(r, vertices);
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        StepValue list;
        double st[2] = {0, 0};
        if (ifc_type(r, s.record) != T_TEXTUREVERTEX || !ifc_arguments(r, s.record, &list, 1)) continue;
        StepCursor inner = ifc_list(r, &list);
        step_next_numbers(&inner, st, 2);
        *ARENA_PUSH(&r->scratch, out->at, out->count, room) = picture_place(transform, st);
    }
}

bool ifc_places(Reader *r, int record, IfcPlaces *out) {
    StepValue v[4];
    *out = (IfcPlaces){0};
    int at = ifc_pair(&r->file->places, record);
    if (at < 0) return false;
    int map = r->file->places.pair[at].value;
    if (!ifc_arguments(r, map, v, 4)) return false;
    Frame transform = transform_of(r, &v[0]);
    if (ifc_type(r, map) == T_TEXTUREMAP)
        vertex_places(r, &v[1], &transform, out);
    else
        indexed_places(r, v, &transform, out);
    return out->count > 0;
}

void ifc_lay_picture(Reader *r, Shape *shape, int first, const Vec3 *corners, const Vec2 *places, int count) {
    static const double ANY[2] = {INFINITY, INFINITY};
    TextureMap map;
    if (first >= shape->face_count ||
        !building_fit_map(corners, places, count, shape->faces[first].plane.n, ANY, &map))
        return;
    double farthest = fmax(fmax(vec3_length(map.u), vec3_length(map.v)), fmax(fabs(map.u0), fabs(map.v0)));
    if (!(farthest <= TEXTURE_FARTHEST)) return;
    *ARENA_PUSH(&r->scratch, shape->maps, shape->map_count, shape->map_room) = map;
    for (int i = first; i < shape->face_count; i++) shape->faces[i].map = shape->map_count;
}
