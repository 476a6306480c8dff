// mesh_patches.c - the elements of a face and its patches, as its leaves are: whole, or in pieces where something stands on them.
#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh_cutting.h"

// Twice the area times the centroid, and twice the area, of a fan about its first corner.
static void add_centroid(const Vec3 *v, int count, Vec3 n, Vec3 *moment, double *area) {
    for (int i = 1; i + 1 < count; i++) {
        double twice = vec3_dot(n, vec3_cross(vec3_sub(v[i], v[0]), vec3_sub(v[i + 1], v[0])));
        Vec3 sum = vec3_add(v[0], vec3_add(v[i], v[i + 1]));
        *moment = vec3_add(*moment, vec3_scale(sum, twice / 3));
        *area += twice;
    }
}

// A patch that grows by elements.
typedef struct Growing {
    Patch patch;
    Vec3 moment;  // of its area about the face's origin
    double weight;
} Growing;

static Growing begin_patch(const MeshCutting *c) {
    return (Growing){
        .patch = {.face = c->index, .first_element = c->builder->mesh->element_count, .cell = -1}};
}

// Notes which element a piece became: -1 where nothing is left once its corners are places.
static void add_piece_element(MeshCutting *c, MeshPiece *piece, MeshDepth depth, Growing *to) {
    MeshBuilder *builder = c->builder;
    Mesh *mesh = builder->mesh;
    int first = mesh->corner_count;
    for (int i = 0; i < piece->count; i++) {
        int place = places_add(&builder->places, vec3_add(c->face->origin, piece->v[i]));
        if (mesh->corner_count > first && mesh->corners[mesh->corner_count - 1] == place) continue;
        *ARENA_PUSH(builder->arena, mesh->corners, mesh->corner_count, builder->corner_capacity) = place;
    }
    while (mesh->corner_count > first + 1 && mesh->corners[mesh->corner_count - 1] == mesh->corners[first])
        mesh->corner_count--;
    if (mesh->corner_count < first + 3) {
        mesh->corner_count = first;
        return;
    }
    double area = polygon_area(piece->v, piece->count);
    piece->element = mesh->element_count;
    *ARENA_PUSH(builder->arena, mesh->elements, mesh->element_count, builder->element_capacity) =
        (Element){c->index, mesh->patch_count, first, mesh->corner_count - first, depth, area};
    add_centroid(piece->v, piece->count, c->face->plane.n, &to->moment, &to->weight);
    to->patch.area += area;
    to->patch.element_count++;
}

// `centre` from the face's origin.
static void finish_patch(MeshCutting *c, Growing *growing, Vec3 centre) {
    Mesh *mesh = c->builder->mesh;
    // On the plane even where the polygon bends: an eye there must not see its own face.
    Vec3 n = c->face->plane.n;
    centre = vec3_sub(centre, vec3_scale(n, vec3_dot(n, centre)));
    growing->patch.centre = vec3_add(c->face->origin, centre);
    *ARENA_PUSH(c->builder->arena, mesh->patches, mesh->patch_count, c->builder->patch_capacity) =
        growing->patch;
}

// The patch of leaves first .. end - 1.
static void add_whole_patch(MeshCutting *c, int first, int end) {
    Growing patch = begin_patch(c);
    for (int k = first; k < end; k++) {
        c->element[k] = -1;
        if (c->first_piece[k] == c->first_piece[k + 1]) continue;
        MeshPiece *whole = &c->pieces[c->first_piece[k]];
        add_piece_element(c, whole, c->leaves[k].depth, &patch);
        c->element[k] = whole->element;
    }
    if (patch.patch.element_count > 0) finish_patch(c, &patch, vec3_scale(patch.moment, 1 / patch.weight));
}

// ---- leaves in pieces

// The centre of area of what lies around a box is under the box: the patch looks from the middle of its nearest element then.
static void finish_cut_patch(MeshCutting *c, Growing *growing) {
    const Mesh *mesh = c->builder->mesh;
    const Patch *patch = &growing->patch;
    if (patch->element_count == 0) return;
    Vec3 centre = vec3_scale(growing->moment, 1 / growing->weight), best = centre;
    double nearest = INFINITY;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const Element *element = &mesh->elements[e];
        MeshPiece piece = {.v = ARENA_ARRAY(c->arena, Vec3, element->corner_count),
                           .count = element->corner_count};
        for (int i = 0; i < piece.count; i++)
            piece.v[i] = vec3_sub(c->builder->places.points[mesh->corners[element->first_corner + i]],
                                  c->face->origin);
        Vec3 middle = mesh_middle(&piece);
        double away = vec3_length(vec3_sub(middle, centre));
        if (mesh_inside(piece.v, piece.count, c->face->plane.n, centre) > -MESH_WELD) away = -1;
        if (away >= nearest) continue;
        nearest = away;
        best = away < 0 ? centre : middle;
    }
    finish_patch(c, growing, best);
}

// Covered pieces have a patch of their own, from which nothing open shoots; very many pieces have several.
static void add_patch_of(MeshCutting *c, int first, int end, bool covered) {
    Growing patch = begin_patch(c);
    for (int k = first; k < end; k++) {
        for (int i = c->first_piece[k]; i < c->first_piece[k + 1]; i++) {
            MeshPiece *piece = &c->pieces[i];
            if (piece->count < 3 || piece->covered != covered) continue;
            add_piece_element(c, piece, c->leaves[k].depth, &patch);
            if (patch.patch.element_count < MESH_MOST_IN_PATCH) continue;
            finish_cut_patch(c, &patch);
            patch = begin_patch(c);
        }
    }
    finish_cut_patch(c, &patch);
}

static void push_shared(MeshCutting *c, int number) {
    Mesh *mesh = c->builder->mesh;
    *ARENA_PUSH(c->builder->arena, mesh->shared, mesh->shared_count, c->builder->shared_capacity) = number;
}

// Notes which elements the pieces of a leaf became, the largest first; returns the code of its squares.
static int share_leaf(MeshCutting *c, const MeshPiece *pieces, int piece_count) {
    Mesh *mesh = c->builder->mesh;
    int count = 0, at = mesh->shared_count;
    push_shared(c, 0);
    for (int i = 0; i < piece_count; i++) {
        int element = pieces[i].element;
        if (element < 0) continue;
        push_shared(c, element);
        int k = at + ++count;
        for (; k > at + 1 && mesh->elements[mesh->shared[k - 1]].area < mesh->elements[element].area; k--)
            mesh->shared[k] = mesh->shared[k - 1];
        mesh->shared[k] = element;
    }
    mesh->shared[at] = count;
    if (count > 1) return ~at - 1;
    mesh->shared_count = at;
    return count == 1 ? mesh->shared[at + 1] : -1;
}

static void add_cut_patches(MeshCutting *c, int first, int end) {
    add_patch_of(c, first, end, false);
    add_patch_of(c, first, end, true);
    for (int k = first; k < end; k++) {
        int at = c->first_piece[k];
        c->element[k] = MESH_SEVERAL;
        if (c->leaves[k].area > 0) c->code[k] = share_leaf(c, c->pieces + at, c->first_piece[k + 1] - at);
    }
}

void mesh_add_patches(MeshCutting *c) {
    Mesh *mesh = c->builder->mesh;
    Face *face = &mesh->faces[c->index];
    face->first_square = mesh->square_count;
    face->first_element = mesh->element_count;
    face->first_patch = mesh->patch_count;
    mesh->square_count += face->nx * face->ny;
    for (int first = 0, end; first < c->leaf_count; first = end) {
        for (end = first + 1; end < c->leaf_count && c->leaves[end].patch == c->leaves[first].patch;) end++;
        if (c->is_cut)
            add_cut_patches(c, first, end);
        else
            add_whole_patch(c, first, end);
    }
    face->element_count = mesh->element_count - face->first_element;
    face->patch_count = mesh->patch_count - face->first_patch;
    mesh->merged_elements += c->merged;
}
