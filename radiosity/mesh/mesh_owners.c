// mesh_owners.c - which element each square of a face is in: all of a leaf in the leaf's, those of leaves in pieces each in one or on
// several.
#include "radiosity/mesh/mesh_cutting.h"

// The inward sides of a piece.
typedef struct Sides {
    Plane *plane;
    int count, element;
} Sides;

static Sides *list_sides(const MeshPiece *pieces, int count, Vec3 n, Arena *arena) {
    Sides *sides = ARENA_ARRAY(arena, Sides, count);
    for (int i = 0; i < count; i++) {
        sides[i].element = pieces[i].element;
        if (pieces[i].element < 0) continue;
        sides[i].plane = ARENA_ARRAY(arena, Plane, pieces[i].count);
        sides[i].count = mesh_sides(pieces[i].v, pieces[i].count, n, sides[i].plane);
    }
    return sides;
}

// The element that a whole square is in, else `code`.
static int element_about(const Sides *sides, int count, Vec3 middle, double reach, int code) {
    for (int i = 0; i < count; i++) {
        if (sides[i].element < 0) continue;
        int k = 0;
        while (k < sides[i].count && plane_distance(sides[i].plane[k], middle) > reach) k++;
        if (k == sides[i].count) return sides[i].element;
    }
    return code;
}

// A leaf in pieces.
static void give_block(const MeshCutting *c, int leaf, int *squares, Arena *arena) {
    const Face *face = c->face;
    MeshBlock b = c->leaves[leaf].block;
    int code = c->code[leaf], at = c->first_piece[leaf], count = c->first_piece[leaf + 1] - at;
    bool several = code < -1;
    Sides *sides = several ? list_sides(c->pieces + at, count, face->plane.n, arena) : NULL;
    Vec3 x = vec3_scale(face->gx, 1 / vec3_dot(face->gx, face->gx)),
         y = vec3_scale(face->gy, 1 / vec3_dot(face->gy, face->gy));
    double reach = 0.5 * vec3_length(vec3_add(x, y));
    for (int j = b.j0; j <= b.j1; j++) {
        for (int i = b.i0; i <= b.i1; i++) {
            Vec3 middle = vec3_add(vec3_scale(x, i + 0.5), vec3_scale(y, j + 0.5));
            squares[j * face->nx + i] = several ? element_about(sides, count, middle, reach, code) : code;
        }
    }
}

void mesh_give_squares(const MeshCutting *c, Arena *arena) {
    const Face *face = c->face;
    int *squares = c->builder->mesh->squares + face->first_square;
    for (int i = 0; i < face->nx * face->ny; i++) {
        int element = c->element[c->owner[i]];
        squares[i] = element == MESH_SEVERAL ? -1 : element;
    }
    for (int k = 0; k < c->leaf_count; k++)
        if (c->element[k] == MESH_SEVERAL && c->leaves[k].area > 0) give_block(c, k, squares, arena);
}
