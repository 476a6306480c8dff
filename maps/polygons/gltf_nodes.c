// gltf_nodes.c - the nodes of a scene (glTF 2.0, 3.5): a forest in which each node's way to its parent is a matrix or
// a translation, rotation and scale; its meshes, lights and cameras put in their places, y up turned to z up.
#include "maps/polygons/gltf.h"

static const char INSTANCES[] = "EXT_mesh_gpu_instancing";

// Affine, row by row: x' = m[0] x + m[1] y + m[2] z + m[3], and so on.
typedef struct Way {
    double m[12];
} Way;

// (x, y, z) with y up becomes (x, -z, y).
static const Way UPRIGHT = {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0}};

static Way joined(const Way *a, const Way *b) {
    Way out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) {
            double sum = c == 3 ? a->m[4 * r + 3] : 0;
            for (int k = 0; k < 3; k++) sum += a->m[4 * r + k] * b->m[4 * k + c];
            out.m[4 * r + c] = sum;
        }
    return out;
}

static Vec3 moved(const Way *w, Vec3 v) {
    const double *m = w->m;
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3], m[4] * v.x + m[5] * v.y + m[6] * v.z + m[7],
                m[8] * v.x + m[9] * v.y + m[10] * v.z + m[11]);
}

static bool mirrors(const Way *w) {
    const double *m = w->m;
    return vec3_dot(vec3_cross(vec3(m[0], m[4], m[8]), vec3(m[1], m[5], m[9])), vec3(m[2], m[6], m[10])) < 0;
}

static bool read_matrix(Gltf *g, const GltfItem *node, Way *out) {
    double c[16];
    if (!gltf_numbers(g, node, "matrix", 16, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, c)) return false;
    for (int i = 0; i < 12; i++) out->m[i] = c[4 * (i % 4) + i / 4];
    if (c[3] == 0 && c[7] == 0 && c[11] == 0 && c[15] == 1) return true;
    return gltf_fail(g, node, "matrix", "ends its columns with %g, %g, %g, %g (allowed: 0, 0, 0, 1)", c[3],
                     c[7], c[11], c[15]);
}

static bool read_turn(Gltf *g, const GltfItem *node, double r[9]) {
    double q[4] = {0, 0, 0, 1};
    if (!gltf_numbers(g, node, "rotation", 4, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, q) && g->failed)
        return false;
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6)) return gltf_fail(g, node, "rotation", "has length %g (allowed: 1)", length);
    double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
    double turn[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    memcpy(r, turn, sizeof turn);
    return true;
}

static bool read_way(Gltf *g, const GltfItem *node, Way *out) {
    if (json_object_get(node->json, "matrix")) return read_matrix(g, node, out);
    double t[3] = {0, 0, 0}, s[3] = {1, 1, 1}, r[9];
    gltf_numbers(g, node, "translation", 3, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, t);
    gltf_numbers(g, node, "scale", 3, -GLTF_MAX_NUMBER, GLTF_MAX_NUMBER, s);
    if (g->failed || !read_turn(g, node, r)) return false;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) out->m[4 * i + k] = r[3 * i + k] * s[k];
        out->m[4 * i + 3] = t[i];
    }
    return true;
}

// ---- one node

static bool place_face(Gltf *g, const GltfItem *node, const Way *way, const SoupMesh *mesh,
                       const SoupFace *face) {
    Vec3 ring[SOUP_MAX_CORNERS];
    bool mirrored = mirrors(way);
    for (int i = 0; i < face->corner_count; i++) {
        Vec3 v = moved(way, mesh->vertices[mesh->corners[face->first_corner + i]]);
        if (!(fabs(v.x) <= MAPS_LIMIT && fabs(v.y) <= MAPS_LIMIT && fabs(v.z) <= MAPS_LIMIT)) {
            return gltf_fail(g, node, NULL,
                             "a corner of its mesh lies at (%g, %g, %g) m (allowed: within %g m)", v.x, v.y,
                             v.z, MAPS_LIMIT);
        }
        ring[mirrored ? face->corner_count - 1 - i : i] = v;
    }
    size_t bytes = g->size + g->folder.bytes;
    int allowed = building_polygons_allowed((double)bytes);
    if (g->faces++ == allowed)
        return gltf_fail(g, node, NULL,
                         "its mesh makes more than %d polygons in all (the limit for %zu bytes)", allowed,
                         bytes);
    if (building_add_polygon(g->arena, g->b, ring, face->corner_count, face->material) == 0) g->tally.flat++;
    return true;
}

static bool place_mesh(Gltf *g, const GltfItem *node, const Way *way) {
    int index = gltf_index(g, node, "mesh", "meshes");
    if (g->failed) return false;
    if (index < 0) return true;
    if (!gltf_decode_mesh(g, index)) return false;
    GltfItem item = gltf_item(g, "meshes", index), instances = gltf_extension(g, node, INSTANCES);
    if (instances.json)
        return gltf_fail(g, &instances, NULL, "is not read (allowed: a node for each instance)");
    if (json_object_get(node->json, "skin")) g->tally.skins++;
    const char *name = gltf_text(g, node, "name", gltf_text(g, &item, "name", ""));
    if (g->failed) return false;
    building_add_object(g->arena, g->b, OBJECT_FURNITURE, name);
    const GltfMesh *mesh = &g->meshes[index];
    for (int i = 0; i < mesh->primitive_count; i++) {
        const SoupMesh *primitive = &mesh->primitives[i];
        for (int f = 0; f < primitive->face_count; f++) {
            if (!place_face(g, node, way, primitive, &primitive->faces[f])) return false;
        }
    }
    if (g->b->objects[g->b->object_count - 1].polygon_count == 0) g->b->object_count--;
    return true;
}

// ---- the forest

// Each node has one parent at most; walking up from any of them ends.
static bool find_parents(Gltf *g, int count, int *parent) {
    for (int i = 0; i < count; i++) parent[i] = -1;
    for (int i = 0; i < count; i++) {
        GltfItem node = gltf_item(g, "nodes", i);
        int children = gltf_count(g, &node, "children");
        for (int k = 0; k < children; k++) {
            int child = gltf_index_at(g, &node, "children", k, "nodes");
            if (g->failed) return false;
            if (parent[child] >= 0)
                return gltf_fail(g, &node, "children",
                                 "node %d is a child of node %d too (allowed: one parent)", child,
                                 parent[child]);
            parent[child] = i;
        }
    }
    int *seen = ARENA_ARRAY(g->scratch, int, count);
    for (int i = 0; i < count; i++) {
        int at = i;
        for (; at >= 0 && seen[at] == 0; at = parent[at]) seen[at] = i + 1;
        if (at < 0 || seen[at] != i + 1) continue;
        GltfItem node = gltf_item(g, "nodes", at);
        return gltf_fail(g, &node, NULL, "is its own ancestor (allowed: no cycles)");
    }
    return !g->failed;
}

// The nodes without parent that the scene names, or all of them where there is no scene.
static bool find_roots(Gltf *g, int count, const int *parent, int *roots, int *root_count) {
    GltfItem root = gltf_root(g);
    *root_count = 0;
    int scenes = gltf_list_count(g, "scenes"), scene = gltf_index(g, &root, "scene", "scenes");
    if (g->failed) return false;
    if (scenes == 0) {
        for (int i = 0; i < count; i++)
            if (parent[i] < 0) roots[(*root_count)++] = i;
        return true;
    }
    GltfItem item = gltf_item(g, "scenes", scene < 0 ? 0 : scene);
    bool *named = ARENA_ARRAY(g->scratch, bool, count);
    int nodes = gltf_count(g, &item, "nodes");
    for (int i = 0; i < nodes; i++) {
        int node = gltf_index_at(g, &item, "nodes", i, "nodes");
        if (g->failed) return false;
        if (parent[node] >= 0 || named[node])
            return gltf_fail(g, &item, "nodes", "node %d is %s (allowed: nodes without parent, once)", node,
                             named[node] ? "named twice" : "a child");
        named[node] = true;
        roots[(*root_count)++] = node;
    }
    return true;
}

typedef struct Waiting {
    int node;
    Way above;
} Waiting;

static bool place_tree(Gltf *g, int root, Waiting *stack) {
    int waiting = 1;
    stack[0] = (Waiting){root, UPRIGHT};
    while (waiting > 0) {
        Waiting at = stack[--waiting];
        GltfItem node = gltf_item(g, "nodes", at.node);
        Way own;
        if (g->failed || !read_way(g, &node, &own)) return false;
        Way way = joined(&at.above, &own);
        if (!place_mesh(g, &node, &way)) return false;
        gltf_add_light(g, &node, way.m);
        gltf_add_camera(g, &node, way.m);
        // Backwards, so that the first child comes first from the stack.
        for (int k = gltf_count(g, &node, "children") - 1; k >= 0; k--)
            stack[waiting++] = (Waiting){gltf_index_at(g, &node, "children", k, "nodes"), way};
        if (g->failed) return false;
    }
    return true;
}

bool gltf_place_nodes(Gltf *g) {
    int count = gltf_list_count(g, "nodes"), root_count;
    if (g->failed) return false;
    int *parent = ARENA_ARRAY(g->scratch, int, count), *roots = ARENA_ARRAY(g->scratch, int, count);
    if (!find_parents(g, count, parent) || !find_roots(g, count, parent, roots, &root_count)) return false;
    // A node waits once at most, having one parent.
    Waiting *stack = ARENA_ARRAY(g->scratch, Waiting, count + 1);
    for (int i = 0; i < root_count; i++) {
        if (!place_tree(g, roots[i], stack)) return false;
    }
    return true;
}
