// lit_twins.c - sorts faces by the distances of their planes, and clips the outlines of faces in one plane by one another.
#include "engine/draw/lit_twins.h"

#include <stdlib.h>

#include "engine/core/polygon.h"

// Planes nearer to each other than this are one plane, metres: about the tolerance of ties in the rows of form factors, which also
// depends on the planes' coefficients.
static const double SAME_PLACE = 1e-6;
// Normals that lean by less than this are one direction, 1 - cosine.
static const double SAME_WAY = 1e-10;
// Faces that overlap by less than this, metres, are neighbours.
static const double OVERLAP = 1e-3;

typedef struct Key {
    double distance;
    int face;
} Key;

static int by_distance(const void *a, const void *b) {
    const Key *p = a, *q = b;
    return p->distance != q->distance ? (p->distance < q->distance ? -1 : 1) : p->face - q->face;
}

static Box face_box(const Mesh *mesh, const Face *face) {
    Box box = box_empty();
    for (int i = 0; i < face->vertex_count; i++)
        box = box_add(box, mesh->vertices[mesh->outline[face->first_vertex + i]]);
    return box;
}

static bool overlap(const Mesh *mesh, const Face *f, const Face *g) {
    Arena scratch = {0};
    int room = f->vertex_count + g->vertex_count + 1, count = g->vertex_count;
    Vec3 *in = ARENA_ARRAY(&scratch, Vec3, room), *out = ARENA_ARRAY(&scratch, Vec3, room);
    for (int i = 0; i < count; i++) in[i] = mesh->vertices[mesh->outline[g->first_vertex + i]];
    for (int i = 0; i < f->vertex_count && count > 0; i++) {
        Vec3 a = mesh->vertices[mesh->outline[f->first_vertex + i]];
        Vec3 b = mesh->vertices[mesh->outline[f->first_vertex + (i + 1) % f->vertex_count]];
        Vec3 inwards = vec3_normalize(vec3_cross(f->plane.n, vec3_sub(b, a)));
        count = polygon_clip(in, count, (Plane){inwards, vec3_dot(inwards, a)}, -OVERLAP, out);
        Vec3 *swap = in;
        in = out;
        out = swap;
    }
    arena_free(&scratch);
    return count > 0;
}

bool *lit_twins(const Mesh *mesh, Arena *arena) {
    Arena scratch = {0};
    bool *twin = ARENA_ARRAY(arena, bool, mesh->face_count + 1);
    Key *keys = ARENA_ARRAY(&scratch, Key, mesh->face_count + 1);
    Box *boxes = ARENA_ARRAY(&scratch, Box, mesh->face_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        keys[f] = (Key){mesh->faces[f].plane.d, f};
        boxes[f] = face_box(mesh, &mesh->faces[f]);
    }
    qsort(keys, (size_t)mesh->face_count, sizeof *keys, by_distance);
    for (int i = 0; i < mesh->face_count; i++) {
        for (int k = i + 1; k < mesh->face_count && keys[k].distance < keys[i].distance + SAME_PLACE; k++) {
            int f = keys[i].face < keys[k].face ? keys[i].face : keys[k].face,
                g = f == keys[i].face ? keys[k].face : keys[i].face;
            const Face *low = &mesh->faces[f], *high = &mesh->faces[g];
            if (twin[g] || vec3_dot(low->plane.n, high->plane.n) < 1 - SAME_WAY) continue;
            twin[g] = box_overlap(boxes[f], boxes[g]) && overlap(mesh, low, high);
        }
    }
    arena_free(&scratch);
    return twin;
}
