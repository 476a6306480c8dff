// gltf_mesh.c - the triangles of a mesh's primitives (glTF 2.0, 3.7.2), joined to polygons.
#include "maps/polygons/gltf.h"

enum { MODE_TRIANGLES = 4, MODE_STRIP, MODE_FAN };

// Corner k of triangle i among the vertices in the order of the indices.
static int corner_of(int mode, int i, int k) {
    if (mode == MODE_TRIANGLES) return 3 * i + k;
    if (mode == MODE_FAN) return k == 2 ? 0 : i + 1 + k;
    // Every other triangle of a strip turns round.
    return k == 0 ? i : i + (k == 1 ? 1 + i % 2 : 2 - i % 2);
}

static bool decode_indices(Gltf *g, const GltfItem *item, int vertices, Arena *arena, GltfValues *out) {
    int accessor = gltf_index(g, item, "indices", "accessors");
    if (g->failed) return false;
    *out = (GltfValues){.count = vertices};
    if (accessor < 0) return true;
    if (!gltf_decode(g, accessor, 1, true, 3 * SOUP_MAX_POLYGONS, arena, out)) return false;
    for (int i = 0; i < out->count; i++) {
        if (out->values[i] < vertices) continue;
        return gltf_fail(g, item, "indices", "index %d is %.0f (allowed 0 to %d)", i, out->values[i],
                         vertices - 1);
    }
    return true;
}

static bool count_triangles(Gltf *g, const GltfItem *item, int mode, int corners, int *out) {
    if (mode == MODE_TRIANGLES && corners % 3 != 0)
        return gltf_fail(g, item, NULL, "has %d corners (allowed of triangles: a multiple of 3)", corners);
    *out = mode == MODE_TRIANGLES ? corners / 3 : corners - 2;
    if (*out >= 1 && *out <= SOUP_MAX_POLYGONS) return true;
    return gltf_fail(g, item, NULL, "has %d corners (allowed: 3 to %d)", corners, SOUP_MAX_POLYGONS);
}

static void list_triangles(int mode, const GltfValues *indices, int material, SoupMesh *mesh, Arena *arena) {
    mesh->faces = ARENA_ARRAY(arena, SoupFace, mesh->face_count);
    mesh->corners = ARENA_ARRAY(arena, int, 3 * mesh->face_count);
    for (int i = 0; i < mesh->face_count; i++) {
        mesh->faces[i] = (SoupFace){mesh->corner_count, 3, material};
        for (int k = 0; k < 3; k++) {
            int corner = corner_of(mode, i, k);
            mesh->corners[mesh->corner_count++] = indices->values ? (int)indices->values[corner] : corner;
        }
    }
}

// Positions outlive the merging, which the rest does not.
static bool decode_primitive(Gltf *g, const GltfItem *item, Arena *work, SoupMesh *out) {
    GltfItem attributes = gltf_member(g, item, "attributes");
    int mode = gltf_int(g, item, "mode", 0, MODE_FAN, MODE_TRIANGLES);
    int position = gltf_index(g, &attributes, "POSITION", "accessors");
    int material = gltf_material(g, gltf_index(g, item, "material", "materials"));
    if (g->failed) return false;
    if (position < 0) return gltf_fail(g, item, "attributes.POSITION", "is missing");
    if (mode < MODE_TRIANGLES) {
        g->tally.lines++;
        return true;
    }
    GltfValues places, indices;
    SoupMesh mesh = {0};
    if (!gltf_decode(g, position, 3, false, SOUP_MAX_VERTICES, work, &places) ||
        !decode_indices(g, item, places.count, work, &indices) ||
        !count_triangles(g, item, mode, indices.count, &mesh.face_count))
        return false;
    mesh.vertex_count = places.count;
    mesh.vertices = ARENA_ARRAY(g->scratch, Vec3, places.count);
    for (int i = 0; i < places.count; i++) {
        const double *v = places.values + 3 * (size_t)i;
        mesh.vertices[i] = vec3(v[0], v[1], v[2]);
    }
    list_triangles(mode, &indices, material, &mesh, work);
    soup_merge(&mesh, g->scratch, out);
    return true;
}

bool gltf_decode_mesh(Gltf *g, int index) {
    GltfMesh *mesh = &g->meshes[index];
    if (mesh->decoded) return true;
    GltfItem item = gltf_item(g, "meshes", index);
    int count = gltf_count(g, &item, "primitives");
    if (g->failed) return false;
    if (count == 0) return gltf_fail(g, &item, "primitives", "is missing or empty");
    mesh->primitives = ARENA_ARRAY(g->scratch, SoupMesh, count);
    for (int i = 0; i < count; i++) {
        GltfItem primitive = gltf_element(g, &item, "primitives", i);
        Arena work = {0};
        SoupMesh *kept = &mesh->primitives[mesh->primitive_count];
        bool good = decode_primitive(g, &primitive, &work, kept);
        mesh->primitive_count += kept->face_count > 0;
        if (gltf_count(g, &primitive, "targets") > 0) g->tally.skins++;
        arena_free(&work);
        if (!good) return false;
    }
    mesh->decoded = true;
    return true;
}
