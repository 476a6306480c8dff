// quake_builder.c - see quake_builder.h. Space is cut along the faces of the boxes until each piece is in one box or in none.
#include "tests/support/files/quake_builder.h"

#include <stdlib.h>

const QuakeBox QUAKE_ROOMS[] = {
    {{0, 0, 0}, {256, 256, 128}, 0, NULL},           // a room
    {{256, 96, 0}, {320, 160, 96}, 0, NULL},         // its door
    {{320, 0, 0}, {576, 256, 128}, 0, NULL},         // a second room
    {{384, 64, -64}, {512, 192, 0}, -3, "*water1"},  // a pool in its floor
    {{416, 256, 0}, {480, 320, 96}, 0, NULL},        // a door to the north
    {{320, 320, 0}, {576, 576, 160}, 0, "*lava1"},   // a third room
    {{320, 320, 160}, {576, 576, 192}, -6, "sky1"},  // and its sky
    {{256, 400, 0}, {320, 464, 96}, 0, NULL},        // a door to the west
    {{0, 320, 0}, {256, 576, 128}, 0, "wall"},  // a fourth room, beside the first but without a door to it
};
const int QUAKE_ROOM_COUNT = sizeof QUAKE_ROOMS / sizeof *QUAKE_ROOMS;

enum { MOST_BYTES = 1 << 22, LUMPS_I = 15, LUMPS_II = 19 };

typedef struct Bin {
    unsigned char *data;
    int size;
} Bin;

typedef struct Maker {
    Arena *arena;
    const QuakeBox *boxes;
    int box_count;
    const QuakeStyle *style;
    QuakeBuilt *built;
    int capacity, node_count, leaf_count, cluster_count;
    Bin lumps[QUAKE_LUMPS];
    int *cluster_of_box;
} Maker;

static unsigned char *more(Bin *bin, int size) {
    bin->size += size;
    if (bin->size > MOST_BYTES) abort();
    return bin->data + bin->size - size;
}

static void put(unsigned char *p, int bytes, long long value) {
    for (int i = 0; i < bytes; i++) p[i] = (unsigned char)(value >> (8 * i) & 255);
}

static void put_float(unsigned char *p, double value) {
    float single = (float)value;
    memcpy(p, &single, sizeof single);
}

// A face with a picture of its own; returns its number.
static int add_face(Maker *m, const char *picture) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[m->style->format];
    int face = m->lumps[QUAKE_FACES].size / layout->record[QUAKE_FACES];
    put(more(&m->lumps[QUAKE_FACES], layout->record[QUAKE_FACES]) + layout->face_texture, layout->face_number,
        face);
    put(more(&m->lumps[QUAKE_TEXTURES], layout->record[QUAKE_TEXTURES]) + 32, 4, face);
    put(more(&m->lumps[QUAKE_LEAF_FACES], layout->leaf_face), layout->leaf_face, face);
    // The lump of pictures: room for the places of 16, then the names.
    Bin *pictures = &m->lumps[QUAKE_PICTURES];
    enum { ROOM = 16 };
    if (pictures->size == 0) more(pictures, 4 + 4 * ROOM);
    if (face >= ROOM) abort();
    put(pictures->data, 4, ROOM);
    put(pictures->data + 4 + 4 * face, 4, pictures->size);
    strncpy((char *)more(pictures, 16), picture, 16);
    return face;
}

// Adds a leaf; returns its number.
static int add_leaf(Maker *m, int from, const int min[3], const int max[3]) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[m->style->format];
    bool two = m->style->format == QUAKE_IBSP38;
    unsigned char *p = more(&m->lumps[QUAKE_LEAVES], layout->record[QUAKE_LEAVES]);
    int contents = from < 0 ? (two ? 1 : -2) : m->boxes[from].contents;
    put(p, 4, from >= 0 && contents == 0 && !two ? -1 : contents);
    put(p + 4, two ? 2 : 4, -1);
    if (from >= 0 && m->boxes[from].picture) {
        int face = add_face(m, m->boxes[from].picture);
        put(p + layout->leaf_faces, layout->leaf_face, face);
        put(p + layout->leaf_faces + layout->leaf_face, layout->leaf_face, 1);
    }
    if (from >= 0) {
        int *cluster = &m->cluster_of_box[from];
        if (*cluster < 0 || !m->style->joined) *cluster = m->cluster_count++;
        if (two) put(p + 4, 2, *cluster);
        QuakeBuiltLeaf *leaf = ARENA_PUSH(m->arena, m->built->leaves, m->built->count, m->capacity);
        *leaf = (QuakeBuiltLeaf){m->leaf_count, from, {min[0], min[1], min[2]}, {max[0], max[1], max[2]}};
    }
    return m->leaf_count++;
}

static bool overlaps(const QuakeBox *box, const int min[3], const int max[3]) {
    for (int i = 0; i < 3; i++) {
        if (box->min[i] >= max[i] || box->max[i] <= min[i]) return false;
    }
    return true;
}

// The next cut of a piece: a face of a box that goes through it, if there is one.
static bool find_cut(const Maker *m, const int min[3], const int max[3], int *axis, int *at) {
    for (int i = 0; i < m->box_count; i++) {
        const QuakeBox *box = &m->boxes[i];
        if (!overlaps(box, min, max)) continue;
        for (int k = 0; k < 6; k++) {
            *axis = k % 3;
            *at = k < 3 ? box->min[*axis] : box->max[*axis];
            if (*at > min[*axis] && *at < max[*axis]) return true;
        }
    }
    return false;
}

static int build_node(Maker *m, const int min[3], const int max[3]) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[m->style->format];
    int axis, at;
    if (!find_cut(m, min, max, &axis, &at)) {
        int from = -1;
        for (int i = 0; i < m->box_count; i++) {
            if (overlaps(&m->boxes[i], min, max)) from = i;
        }
        if (from < 0 && m->style->format != QUAKE_IBSP38) return ~0;
        return ~add_leaf(m, from, min, max);
    }
    int node = m->node_count++, low[3] = {min[0], min[1], min[2]}, high[3] = {max[0], max[1], max[2]};
    unsigned char *plane = more(&m->lumps[QUAKE_PLANES], layout->record[QUAKE_PLANES]);
    more(&m->lumps[QUAKE_NODES], layout->record[QUAKE_NODES]);
    // Every other plane faces down its axis.
    int sign = node % 2 ? -1 : 1;
    put_float(plane + 4 * axis, sign);
    put_float(plane + 12, sign * at);
    low[axis] = high[axis] = at;
    int above = build_node(m, low, max), below = build_node(m, min, high);
    unsigned char *p = m->lumps[QUAKE_NODES].data + (size_t)node * (size_t)layout->record[QUAKE_NODES];
    put(p, 4, node);
    put(p + 4, layout->child, sign > 0 ? above : below);
    put(p + 4 + layout->child, layout->child, sign > 0 ? below : above);
    return node;
}

static void add_model(Maker *m, const int min[3], const int max[3], int root) {
    unsigned char *p = more(&m->lumps[QUAKE_MODELS], QUAKE_LAYOUTS[m->style->format].record[QUAKE_MODELS]);
    for (int i = 0; i < 3; i++) {
        put_float(p + 4 * i, min[i]);
        put_float(p + 12 + 4 * i, max[i]);
    }
    put(p + 36, 4, root);
    if (m->style->format != QUAKE_IBSP38) put(p + 52, 4, m->leaf_count - 1);
}

static Bytes write_file(Maker *m) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[m->style->format];
    Bin file = {ARENA_ARRAY(m->arena, unsigned char, MOST_BYTES), 0};
    unsigned char *head = more(&file, layout->header + 8 * layout->lump_count);
    memcpy(head, layout->magic, 4);
    if (m->style->format == QUAKE_IBSP38) put(head + 4, 4, 38);
    int order[QUAKE_LUMPS];
    for (int i = 0; i < QUAKE_LUMPS; i++) order[i] = i;
    if (m->style->last) {
        order[QUAKE_VISIBILITY] = QUAKE_LUMPS - 1;
        order[QUAKE_LUMPS - 1] = QUAKE_VISIBILITY;
    }
    for (int i = 0; i < QUAKE_LUMPS; i++) {
        int lump = order[i];
        if (layout->lump[lump] < 0) continue;
        put(head + layout->header + 8 * layout->lump[lump], 4, file.size);
        put(head + layout->header + 8 * layout->lump[lump] + 4, 4, m->lumps[lump].size);
        if (m->lumps[lump].size > 0)
            memcpy(more(&file, m->lumps[lump].size), m->lumps[lump].data, (size_t)m->lumps[lump].size);
        more(&file, (4 - file.size % 4) % 4);
    }
    if (!m->style->bspx) return (Bytes){file.data, (size_t)file.size};
    unsigned char *block = more(&file, 8 + 32);
    int length = (int)strlen(m->style->bspx);
    memcpy(block, "BSPX\1\0\0\0NOTES", 13);
    put(block + 32, 4, file.size);
    put(block + 36, 4, length);
    memcpy(more(&file, length), m->style->bspx, (size_t)length);
    return (Bytes){file.data, (size_t)file.size};
}

QuakeBuilt quake_build(Arena *arena, const QuakeBox *boxes, int count, const QuakeStyle *style) {
    QuakeBuilt built = {0};
    Maker m = {.arena = arena, .boxes = boxes, .box_count = count, .style = style, .built = &built};
    m.cluster_of_box = ARENA_ARRAY(arena, int, count + 1);
    int min[3], max[3], rock[2][3];
    for (int k = 0; k < 3; k++) {
        min[k] = max[k] = boxes[0].min[k];
        for (int i = 0; i < count; i++) {
            m.cluster_of_box[i] = -1;
            if (boxes[i].min[k] < min[k]) min[k] = boxes[i].min[k];
            if (boxes[i].max[k] > max[k]) max[k] = boxes[i].max[k];
        }
        rock[0][k] = min[k] - 64, rock[1][k] = max[k] + 64;
    }
    for (int i = 0; i < QUAKE_LUMPS; i++) m.lumps[i].data = ARENA_ARRAY(arena, unsigned char, MOST_BYTES);
    if (style->visibility.size > 0)
        memcpy(more(&m.lumps[QUAKE_VISIBILITY], (int)style->visibility.size), style->visibility.data,
               style->visibility.size);
    if (style->format != QUAKE_IBSP38) add_leaf(&m, -1, rock[0], rock[1]);
    int root = build_node(&m, rock[0], rock[1]);
    add_model(&m, min, max, root);
    built.file = write_file(&m);
    return built;
}
