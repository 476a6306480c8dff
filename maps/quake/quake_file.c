// quake_file.c - the lumps of a level, their records with every index checked, and the tree walked once.
#include <stdio.h>
#include <stdlib.h>

#include "maps/quake/quake.h"

const char *const QUAKE_FORMAT_NAMES[QUAKE_FORMATS] = {"BSP29", "2PSB", "BSP2", "IBSP 38"};

// Where a format has things: bytes from the beginning of a record; -1: nowhere.
const QuakeLayout QUAKE_LAYOUTS[QUAKE_FORMATS] = {
    {.magic = {29, 0, 0, 0},
     .header = 4,
     .lump_count = 15,
     .lump = {1, 4, 5, 10, 14, 11, 7, 6, 2},
     .record = {20, 1, 24, 28, 64, 2, 20, 40, 1},
     .child = 2,
     .leaf_faces = 20,
     .leaf_face = 2,
     .sounds = 24,
     .face_texture = 10,
     .face_number = 2},
    {.magic = {'2', 'P', 'S', 'B'},
     .header = 4,
     .lump_count = 15,
     .lump = {1, 4, 5, 10, 14, 11, 7, 6, 2},
     .record = {20, 1, 32, 32, 64, 4, 28, 40, 1},
     .child = 4,
     .leaf_faces = 20,
     .leaf_face = 4,
     .sounds = 28,
     .face_texture = 16,
     .face_number = 4},
    {.magic = {'B', 'S', 'P', '2'},
     .header = 4,
     .lump_count = 15,
     .lump = {1, 4, 5, 10, 14, 11, 7, 6, 2},
     .record = {20, 1, 44, 44, 64, 4, 28, 40, 1},
     .child = 4,
     .leaf_faces = 32,
     .leaf_face = 4,
     .sounds = 40,
     .face_texture = 16,
     .face_number = 4},
    {.magic = {'I', 'B', 'S', 'P'},
     .header = 8,
     .lump_count = 19,
     .lump = {1, 3, 4, 8, 13, 9, 6, 5, -1},
     .record = {20, 1, 28, 28, 48, 2, 20, 76, 1},
     .child = 4,
     .leaf_faces = 20,
     .leaf_face = 2,
     .sounds = -1,
     .face_texture = 10,
     .face_number = 2},
};

const char *const QUAKE_LUMP_NAMES[QUAKE_LUMPS] = {
    "planes", "visibility", "nodes", "leaves", "models", "leaf faces", "faces", "textures", "pictures"};

enum {
    MODEL_ROOT = 36,
    MODEL_LEAVES = 52,  // of Quake: how many leaves the level itself has
    LEAF_ROW = 4,       // of Quake; of Quake II the cluster
    DEEPEST = 1024,     // nodes of the tree; levels of many thousand leaves have some hundred
};

bool quake_recognise(Bytes content) {
    for (int f = 0; f < QUAKE_FORMATS; f++) {
        if (content.size >= 4 && memcmp(content.data, QUAKE_LAYOUTS[f].magic, 4) == 0) return true;
    }
    return false;
}

static bool find_format(QuakeLevel *level, Error *error) {
    const unsigned char *data = level->content.data;
    for (level->format = 0; level->format < QUAKE_FORMATS; level->format++) {
        if (level->content.size >= 8 && memcmp(data, QUAKE_LAYOUTS[level->format].magic, 4) == 0) break;
    }
    if (level->format == QUAKE_FORMATS) {
        return error_set(
            error,
            "%s: is no level of a known format (allowed: Quake's of version 29, 2PSB and BSP2, and IBSP of "
            "version 38)",
            level->path);
    }
    if (level->format == QUAKE_IBSP38 && quake_i32(data + 4) != 38) {
        return error_set(error, "%s: is an IBSP of version %d (allowed: 38, that of Quake II)", level->path,
                         quake_i32(data + 4));
    }
    return true;
}

static bool find_lump(QuakeLevel *level, QuakeLump lump, Error *error) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    if (layout->lump[lump] < 0) return true;
    const unsigned char *entry = level->content.data + layout->header + 8 * layout->lump[lump];
    long long at = quake_i32(entry), size = quake_i32(entry + 4), all = (long long)level->content.size;
    if (at < 0 || size < 0 || at > all || size > all - at) {
        return error_set(
            error, "%s: its lump of %s, %lld bytes at byte %lld, does not lie within the file of %lld bytes",
            level->path, QUAKE_LUMP_NAMES[lump], size, at, all);
    }
    if (size % layout->record[lump] != 0) {
        return error_set(error, "%s: its lump of %s has %lld bytes (allowed: a multiple of %d)", level->path,
                         QUAKE_LUMP_NAMES[lump], size, layout->record[lump]);
    }
    level->lumps[lump] = (Bytes){level->content.data + at, (size_t)size};
    return true;
}

int quake_count(const QuakeLevel *level, QuakeLump lump) {
    return (int)level->lumps[lump].size / QUAKE_LAYOUTS[level->format].record[lump];
}

const unsigned char *quake_record(const QuakeLevel *level, QuakeLump lump, int i) {
    return level->lumps[lump].data + (size_t)i * (size_t)QUAKE_LAYOUTS[level->format].record[lump];
}

static bool read_planes(QuakeLevel *level, Arena *arena, Error *error) {
    level->plane_count = quake_count(level, QUAKE_PLANES);
    level->planes = ARENA_ARRAY(arena, Plane, level->plane_count + 1);
    for (int i = 0; i < level->plane_count; i++) {
        const unsigned char *p = quake_record(level, QUAKE_PLANES, i);
        Vec3 n = vec3(quake_float(p), quake_float(p + 4), quake_float(p + 8));
        double length = vec3_length(n), d = quake_float(p + 12) / QUAKE_METRE;
        if (!(fabs(length - 1) < 1e-3) || !(fabs(d) <= MAPS_LIMIT)) {
            return error_set(
                error,
                "%s: plane %d has a normal of length %g and the distance %g (allowed: 1, and at most %g)",
                level->path, i, length, d * QUAKE_METRE, MAPS_LIMIT * QUAKE_METRE);
        }
        level->planes[i] = (Plane){vec3_scale(n, 1 / length), d / length};
    }
    return true;
}

// A child in sixteen bits is a node if there is one of that number; leaf i is 65535 - i.
static int child_of(const QuakeLevel *level, const unsigned char *p) {
    if (QUAKE_LAYOUTS[level->format].child == 4) return quake_i32(p);
    int number = quake_u16(p);
    return number < level->node_count ? number : ~(0xFFFF - number);
}

static bool child_good(const QuakeLevel *level, int child) {
    return child >= 0 ? child < level->node_count : ~child < level->leaf_count;
}

static bool read_nodes(QuakeLevel *level, Arena *arena, Error *error) {
    level->node_count = quake_count(level, QUAKE_NODES);
    level->nodes = ARENA_ARRAY(arena, QuakeNode, level->node_count + 1);
    for (int i = 0; i < level->node_count; i++) {
        const unsigned char *p = quake_record(level, QUAKE_NODES, i);
        QuakeNode *node = &level->nodes[i];
        node->plane = quake_i32(p);
        if (node->plane < 0 || node->plane >= level->plane_count) {
            return error_set(error, "%s: node %d: its plane is %d (allowed 0 to %d)", level->path, i,
                             node->plane, level->plane_count - 1);
        }
        for (int side = 0; side < 2; side++) {
            node->child[side] = child_of(level, p + 4 + side * QUAKE_LAYOUTS[level->format].child);
            if (!child_good(level, node->child[side])) {
                return error_set(error,
                                 "%s: node %d: a child is %s %d (allowed: nodes 0 to %d and leaves 0 to %d)",
                                 level->path, i, node->child[side] < 0 ? "leaf" : "node",
                                 node->child[side] < 0 ? ~node->child[side] : node->child[side],
                                 level->node_count - 1, level->leaf_count - 1);
            }
        }
    }
    return true;
}

static bool read_leaf(QuakeLevel *level, int i, Error *error) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    const unsigned char *p = quake_record(level, QUAKE_LEAVES, i);
    QuakeLeaf *leaf = &level->leaves[i];
    leaf->contents = quake_i32(p);
    leaf->row = -1;
    bool narrow = layout->leaf_face == 2;
    leaf->first_face = narrow ? quake_u16(p + layout->leaf_faces) : quake_i32(p + layout->leaf_faces);
    leaf->face_count = narrow ? quake_u16(p + layout->leaf_faces + 2) : quake_i32(p + layout->leaf_faces + 4);
    int faces = quake_count(level, QUAKE_LEAF_FACES);
    if (leaf->first_face < 0 || leaf->face_count < 0 || leaf->first_face > faces ||
        leaf->face_count > faces - leaf->first_face) {
        return error_set(error, "%s: leaf %d: has %d faces from %d on (allowed: up to %d in all)",
                         level->path, i, leaf->face_count, leaf->first_face, faces);
    }
    if (level->format == QUAKE_IBSP38) {
        leaf->cluster = (int16_t)quake_u16(p + LEAF_ROW);
        if (leaf->cluster < -1) {
            return error_set(error, "%s: leaf %d: its cluster is %d (allowed: -1 and more)", level->path, i,
                             leaf->cluster);
        }
        if (leaf->cluster >= level->cluster_count) level->cluster_count = leaf->cluster + 1;
        return true;
    }
    leaf->cluster = i >= 1 && i <= level->cluster_count ? i - 1 : -1;
    leaf->row = quake_i32(p + LEAF_ROW);
    if (leaf->row < -1) {
        return error_set(error, "%s: leaf %d: its row begins at byte %d (allowed: -1 and more)", level->path,
                         i, leaf->row);
    }
    return true;
}

static bool read_leaves(QuakeLevel *level, Arena *arena, Error *error) {
    level->leaves = ARENA_ARRAY(arena, QuakeLeaf, level->leaf_count + 1);
    for (int i = 0; i < level->leaf_count; i++) {
        if (!read_leaf(level, i, error)) return false;
    }
    if (level->cluster_count < 1 || level->cluster_count > MAPS_MAX_GIVEN_CELLS) {
        return error_set(error, "%s: has %d %s that may see (allowed 1 to %d)", level->path,
                         level->cluster_count, level->format == QUAKE_IBSP38 ? "clusters" : "leaves",
                         MAPS_MAX_GIVEN_CELLS);
    }
    return true;
}

// The first model is the level itself; others are its doors and lifts.
static bool read_model(QuakeLevel *level, Error *error) {
    if (quake_count(level, QUAKE_MODELS) < 1)
        return error_set(error, "%s: has no model (expected at least the level itself)", level->path);
    const unsigned char *p = quake_record(level, QUAKE_MODELS, 0);
    double corner[6];
    for (int i = 0; i < 6; i++) corner[i] = quake_float(p + 4 * i) / QUAKE_METRE;
    for (int i = 0; i < 3; i++) {
        if (!(corner[i] <= corner[i + 3] && fabs(corner[i]) <= MAPS_LIMIT &&
              fabs(corner[i + 3]) <= MAPS_LIMIT)) {
            return error_set(
                error, "%s: the level reaches from %g to %g (allowed: from less to more, at most %g)",
                level->path, corner[i] * QUAKE_METRE, corner[i + 3] * QUAKE_METRE, MAPS_LIMIT * QUAKE_METRE);
        }
    }
    level->box = (Box){vec3(corner[0], corner[1], corner[2]), vec3(corner[3], corner[4], corner[5])};
    level->root = quake_i32(p + MODEL_ROOT);
    if (!child_good(level, level->root))
        return error_set(error, "%s: the tree begins at node %d (allowed 0 to %d)", level->path, level->root,
                         level->node_count - 1);
    return true;
}

static bool hang(const QuakeLevel *level, int child, unsigned char *reached, Error *error) {
    const char *what = child < 0 ? "leaf" : "node";
    int i = child < 0 ? ~child : child;
    if (child < 0 && level->leaves[i].cluster < 0) return true;  // solid is one leaf for all
    unsigned char *bits = &reached[child < 0 ? level->node_count + i : i];
    if (*bits)
        return error_set(error, "%s: %s %d hangs in the tree twice (allowed: once)", level->path, what, i);
    *bits = 1;
    return true;
}

// Walks the tree once, whose nodes may be in any order.
static bool check_tree(const QuakeLevel *level, Error *error) {
    if (level->root < 0) return true;
    Arena scratch = {0};
    unsigned char *reached = ARENA_ARRAY(&scratch, unsigned char, level->node_count + level->leaf_count);
    int stack[DEEPEST + 1], turn[DEEPEST + 1], depth = 0;
    stack[0] = level->root;
    turn[0] = 0;
    bool good = hang(level, level->root, reached, error);
    while (good && depth >= 0) {
        if (turn[depth] == 2) {
            depth--;
            continue;
        }
        int child = level->nodes[stack[depth]].child[turn[depth]++];
        good = hang(level, child, reached, error);
        if (!good || child < 0) continue;
        if (depth == DEEPEST - 1) {
            good = error_set(error, "%s: the tree is more than %d nodes deep at node %d", level->path,
                             DEEPEST, child);
            continue;
        }
        stack[++depth] = child;
        turn[depth] = 0;
    }
    arena_free(&scratch);
    return good;
}

bool quake_read(const char *path, Bytes content, Arena *arena, QuakeLevel *out, Error *error) {
    *out = (QuakeLevel){.path = path, .content = content};
    if (!find_format(out, error)) return false;
    const QuakeLayout *layout = &QUAKE_LAYOUTS[out->format];
    size_t header = (size_t)(layout->header + 8 * layout->lump_count);
    if (content.size < header)
        return error_set(error, "%s: has %zu bytes (expected a header of %zu)", path, content.size, header);
    for (int i = 0; i < QUAKE_LUMPS; i++) {
        if (!find_lump(out, i, error)) return false;
    }
    out->leaf_count = quake_count(out, QUAKE_LEAVES);
    if (!read_planes(out, arena, error) || !read_nodes(out, arena, error) || !read_model(out, error))
        return false;
    if (out->format != QUAKE_IBSP38) {
        out->cluster_count = quake_i32(quake_record(out, QUAKE_MODELS, 0) + MODEL_LEAVES);
        if (out->cluster_count < 1 || out->cluster_count >= out->leaf_count)
            return error_set(error, "%s: the level says that %d of its leaves may see (allowed 1 to %d)",
                             path, out->cluster_count, out->leaf_count - 1);
    }
    return read_leaves(out, arena, error) && check_tree(out, error);
}

int quake_locate(const QuakeLevel *level, Vec3 point) {
    int at = level->root;
    while (at >= 0) {
        const QuakeNode *node = &level->nodes[at];
        at = node->child[plane_distance(level->planes[node->plane], point) < 0];
    }
    return ~at;
}
