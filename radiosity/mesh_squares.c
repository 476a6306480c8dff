// mesh_squares.c - cuts a face along a grid parallel to its longest edge: a rectangle into nx x ny equal parts, another
// convex polygon into squares clipped at its outline, where slivers are joined to their neighbours (Cohen & Wallace
// 1993, chapter 6: elements of even size and good shape).
#include <string.h>

#include "engine/core/polygon.h"
#include "radiosity/mesh_parts.h"

// A part of a square is a sliver below this share of the square: it would receive too few samples to tell its light.
static const double SLIVER = 0.15;
// Below this share it is rounding.
static const double NOTHING = 1e-9;

// Side of squares on faces that are cut, metres; and how many there may be before they are larger.
static const double SEARCHED = 0.06;
static const int MOST_SQUARES = 1 << 16;

// How much longer than asked for an element's edges may be. Small faces make them shorter on the average.
static const double LONGEST = 1.15;

// How many patches of an edge length a side takes.
static int patches_along(double length, double edge) {
    double patches = ceil(length / (LONGEST * edge));
    return patches < 1 ? 1 : (int)patches;
}

double mesh_count_even(const Mesh *mesh) {
    double edge = mesh->options.element * mesh->options.per_patch, per = mesh->options.per_patch, count = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        count += per * patches_along(face->nx / vec3_length(face->gx), edge) * per *
                 patches_along(face->ny / vec3_length(face->gy), edge);
    }
    return count;
}

void mesh_lay_grid(MeshBuilder *builder, Face *face, const int *corner, int count) {
    const Vec3 *points = builder->places.points;
    Vec3 base = points[corner[0]], x = {0};
    double longest = 0;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(points[corner[(i + 1) % count]], points[corner[i]]);
        double length = vec3_length(edge);
        // Of edges equally long but for rounding the first.
        if (length <= longest * (1 + 1e-9)) continue;
        longest = length;
        x = edge;
    }
    x = vec3_normalize(vec3_sub(x, vec3_scale(face->plane.n, vec3_dot(face->plane.n, x))));
    Vec3 y = vec3_cross(face->plane.n, x);
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 p = vec3_sub(points[corner[i]], base);
        x0 = fmin(x0, vec3_dot(x, p));
        x1 = fmax(x1, vec3_dot(x, p));
        y0 = fmin(y0, vec3_dot(y, p));
        y1 = fmax(y1, vec3_dot(y, p));
    }
    const MeshOptions *options = &builder->mesh->options;
    double edge = options->element * options->per_patch * (options->splits ? 2 : 1);
    face->nx = patches_along(x1 - x0, edge);
    face->ny = patches_along(y1 - y0, edge);
    face->root = options->per_patch;
    if (options->splits) face->root = 1 << mesh_deepest(builder, (double)face->nx * face->ny);
    face->nx *= face->root;
    face->ny *= face->root;
    // On the plane, which corners miss where the polygon bends.
    base = vec3_sub(base, vec3_scale(face->plane.n, vec3_dot(face->plane.n, base) - face->plane.d));
    face->origin = vec3_add(base, vec3_add(vec3_scale(x, x0), vec3_scale(y, y0)));
    face->gx = vec3_scale(x, face->nx / (x1 - x0));
    face->gy = vec3_scale(y, face->ny / (y1 - y0));
}

// ---- parts of a face

enum { SEVERAL = -2 };

typedef struct Cutting {
    MeshBuilder *builder;
    const Face *face;
    const Vec3 *outline;  // [count] from the face's origin
    int count;
    Vec3 *part, *spare;  // [count + 8] of the part looked at
    MeshLeaf *leaves;    // [leaf_count]
    int leaf_count;
    int *owner;     // [nx * ny] the leaf whose block a square is in
    int *element;   // [leaf_count] of each leaf, -1: none, SEVERAL: it is in pieces
    double square;  // area of a whole one, m^2
} Cutting;

// The part of the face in a block, from the face's origin; returns how many corners it has.
static int part_in(Cutting *c, MeshBlock b) {
    const Face *face = c->face;
    int count = c->count;
    memcpy(c->part, c->outline, (size_t)count * sizeof *c->part);
    // The planes are in units of squares. No cuts along the grid's border, which only rounding could tell from edges.
    const struct {
        bool cut;
        Plane keep;
    } side[4] = {{b.i0 > 0, {face->gx, b.i0}},
                 {b.i1 + 1 < face->nx, {vec3_scale(face->gx, -1), -(b.i1 + 1)}},
                 {b.j0 > 0, {face->gy, b.j0}},
                 {b.j1 + 1 < face->ny, {vec3_scale(face->gy, -1), -(b.j1 + 1)}}};
    for (int k = 0; k < 4; k++) {
        if (!side[k].cut) continue;
        count = polygon_clip(c->part, count, side[k].keep, 0, c->spare);
        Vec3 *swap = c->part;
        c->part = c->spare;
        c->spare = swap;
    }
    return count;
}

static double whole_of(const Cutting *c, MeshBlock b) {
    return c->square * (b.i1 + 1 - b.i0) * (b.j1 + 1 - b.j0);
}

static void give(Cutting *c, MeshBlock b, int leaf) {
    for (int j = b.j0; j <= b.j1; j++)
        for (int i = b.i0; i <= b.i1; i++) c->owner[j * c->face->nx + i] = leaf;
}

static void measure_parts(Cutting *c) {
    for (int k = 0; k < c->leaf_count; k++) {
        MeshLeaf *leaf = &c->leaves[k];
        int count = part_in(c, leaf->block);
        double area = count < 3 ? 0 : polygon_area(c->part, count);
        leaf->area = area < NOTHING * c->square ? 0 : area;
        give(c, leaf->block, k);
    }
}

// The leaf beyond one side of a block if the two make a larger block, else -1.
static int beyond(const Cutting *c, MeshBlock b, int side) {
    int i = side == 0 ? b.i0 - 1 : side == 1 ? b.i1 + 1 : b.i0;
    int j = side == 2 ? b.j0 - 1 : side == 3 ? b.j1 + 1 : b.j0;
    if (i < 0 || j < 0 || i >= c->face->nx || j >= c->face->ny) return -1;
    int owner = c->owner[j * c->face->nx + i];
    MeshBlock other = c->leaves[owner].block;
    bool fits = side < 2 ? other.j0 == b.j0 && other.j1 == b.j1 : other.i0 == b.i0 && other.i1 == b.i1;
    return fits && c->leaves[owner].area > 0 ? owner : -1;
}

// Joins a sliver to the largest neighbour with which it makes a block, one of its own patch first: what a block cuts
// out of a convex polygon is convex.
static bool join(Cutting *c, int at) {
    MeshLeaf *leaf = &c->leaves[at], *best = NULL;
    for (int side = 0; side < 4; side++) {
        int index = beyond(c, leaf->block, side);
        if (index < 0) continue;
        MeshLeaf *other = &c->leaves[index];
        bool own = other->patch == leaf->patch, best_own = best && best->patch == leaf->patch;
        if (!best || (own && !best_own) || (own == best_own && other->area > best->area)) best = other;
    }
    if (!best) return false;
    MeshBlock a = leaf->block, b = best->block;
    MeshLeaf *keep = leaf->area > best->area ? leaf : best, *drop = keep == leaf ? best : leaf;
    keep->area += drop->area;
    drop->area = 0;
    keep->block = (MeshBlock){a.i0 < b.i0 ? a.i0 : b.i0, a.j0 < b.j0 ? a.j0 : b.j0, a.i1 > b.i1 ? a.i1 : b.i1,
                              a.j1 > b.j1 ? a.j1 : b.j1};
    give(c, keep->block, (int)(keep - c->leaves));
    c->builder->mesh->merged_elements++;
    return true;
}

static void join_slivers(Cutting *c) {
    for (bool joined = true; joined;) {
        joined = false;
        for (int k = 0; k < c->leaf_count; k++) {
            const MeshLeaf *leaf = &c->leaves[k];
            if (leaf->area > 0 && leaf->area < SLIVER * whole_of(c, leaf->block) && join(c, k)) joined = true;
        }
    }
}

// ---- elements and patches

// Twice the area times the centroid, and twice the area, of a fan about its first corner.
static void add_centroid(const Vec3 *v, int count, Vec3 n, Vec3 *moment, double *area) {
    for (int i = 1; i + 1 < count; i++) {
        double twice = vec3_dot(n, vec3_cross(vec3_sub(v[i], v[0]), vec3_sub(v[i + 1], v[0])));
        Vec3 sum = vec3_add(v[0], vec3_add(v[i], v[i + 1]));
        *moment = vec3_add(*moment, vec3_scale(sum, twice / 3));
        *area += twice;
    }
}

// Returns false where nothing is left once its corners are places.
static bool add_element(Cutting *c, const Vec3 *v, int count, int depth, Patch *patch, Vec3 *moment,
                        double *weight) {
    MeshBuilder *builder = c->builder;
    Mesh *mesh = builder->mesh;
    int first = mesh->corner_count;
    for (int i = 0; i < count; i++) {
        int place = places_add(&builder->places, vec3_add(c->face->origin, v[i]));
        if (mesh->corner_count > first && mesh->corners[mesh->corner_count - 1] == place) continue;
        *ARENA_PUSH(builder->arena, mesh->corners, mesh->corner_count, builder->corner_capacity) = place;
    }
    while (mesh->corner_count > first + 1 && mesh->corners[mesh->corner_count - 1] == mesh->corners[first])
        mesh->corner_count--;
    if (mesh->corner_count < first + 3) {
        mesh->corner_count = first;
        return false;
    }
    double area = polygon_area(v, count);
    *ARENA_PUSH(builder->arena, mesh->elements, mesh->element_count, builder->element_capacity) =
        (Element){patch->face, mesh->patch_count, first, mesh->corner_count - first, depth, area};
    add_centroid(v, count, c->face->plane.n, moment, weight);
    patch->area += area;
    patch->element_count++;
    return true;
}

// `centre` from the face's origin.
static void finish_patch(Cutting *c, Patch *patch, Vec3 centre) {
    Mesh *mesh = c->builder->mesh;
    // On the plane even where the polygon bends: an eye there must not see its own face.
    Vec3 n = c->face->plane.n;
    centre = vec3_sub(centre, vec3_scale(n, vec3_dot(n, centre)));
    patch->centre = vec3_add(c->face->origin, centre);
    *ARENA_PUSH(c->builder->arena, mesh->patches, mesh->patch_count, c->builder->patch_capacity) = *patch;
}

// The patch of leaves first .. end - 1.
static void add_whole_patch(Cutting *c, int face, int first, int end) {
    Mesh *mesh = c->builder->mesh;
    Patch patch = {.face = face, .first_element = mesh->element_count, .cell = -1};
    Vec3 moment = {0};
    double weight = 0;
    for (int k = first; k < end; k++) {
        const MeshLeaf *leaf = &c->leaves[k];
        c->element[k] = -1;
        if (leaf->area == 0) continue;
        int count = part_in(c, leaf->block);
        if (add_element(c, c->part, count, leaf->depth, &patch, &moment, &weight))
            c->element[k] = mesh->element_count - 1;
    }
    if (patch.element_count > 0) finish_patch(c, &patch, vec3_scale(moment, 1 / weight));
}

// ---- leaves in pieces

// Those of a patch's leaves first .. end - 1.
typedef struct Pieces {
    MeshPiece *pieces;  // [first_of[end - first]]
    int *first_of;
} Pieces;

static Pieces find_pieces(Cutting *c, int face, int first, int end) {
    Arena *arena = &c->builder->scratch;
    Pieces p = {.first_of = ARENA_ARRAY(arena, int, end - first + 1)};
    int count = 0, capacity = 0;
    for (int k = first; k < end; k++) {
        MeshPiece own[MESH_MOST_PIECES];
        int corners = c->leaves[k].area > 0 ? part_in(c, c->leaves[k].block) : 0;
        int pieces = corners >= 3 ? mesh_cut_pieces(c->builder, face, c->part, corners, arena, own) : 0;
        p.first_of[k - first] = count;
        for (int i = 0; i < pieces; i++) *ARENA_PUSH(arena, p.pieces, count, capacity) = own[i];
    }
    p.first_of[end - first] = count;
    return p;
}

static Vec3 middle_of(const MeshPiece *piece) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < piece->count; i++) sum = vec3_add(sum, piece->v[i]);
    return vec3_scale(sum, 1.0 / piece->count);
}

// The centre of area of what lies around a box is under the box: the patch looks from the middle of its nearest element then.
static void finish_cut_patch(Cutting *c, Patch *patch, Vec3 moment, double weight) {
    const Mesh *mesh = c->builder->mesh;
    Vec3 centre = vec3_scale(moment, 1 / weight), best = centre;
    double nearest = INFINITY;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const Element *element = &mesh->elements[e];
        MeshPiece piece = {.v = ARENA_ARRAY(&c->builder->scratch, Vec3, element->corner_count),
                           .count = element->corner_count};
        for (int i = 0; i < piece.count; i++)
            piece.v[i] = vec3_sub(c->builder->places.points[mesh->corners[element->first_corner + i]],
                                  c->face->origin);
        Vec3 middle = middle_of(&piece);
        double away = vec3_length(vec3_sub(middle, centre));
        if (mesh_inside(piece.v, piece.count, c->face->plane.n, centre) > -MESH_WELD) away = -1;
        if (away >= nearest) continue;
        nearest = away;
        best = away < 0 ? centre : middle;
    }
    if (patch->element_count > 0) finish_patch(c, patch, best);
}

// What is covered has a patch of its own, which nothing open shoots from. Of very many pieces there are several.
static void add_patch_of(Cutting *c, int face, const Pieces *p, int first, int end, bool covered) {
    Mesh *mesh = c->builder->mesh;
    Patch patch = {.face = face, .first_element = mesh->element_count, .cell = -1};
    Vec3 moment = {0};
    double weight = 0;
    for (int k = first; k < end; k++) {
        for (int i = p->first_of[k - first]; i < p->first_of[k - first + 1]; i++) {
            MeshPiece *piece = &p->pieces[i];
            if (piece->count < 3 || mesh_is_covered(c->builder, face, middle_of(piece)) != covered) continue;
            if (add_element(c, piece->v, piece->count, c->leaves[k].depth, &patch, &moment, &weight))
                piece->element = mesh->element_count - 1;
            if (patch.element_count < MESH_MOST_IN_PATCH) continue;
            finish_cut_patch(c, &patch, moment, weight);
            patch = (Patch){.face = face, .first_element = mesh->element_count, .cell = -1};
            moment = (Vec3){0};
            weight = 0;
        }
    }
    finish_cut_patch(c, &patch, moment, weight);
}

static void push_shared(Cutting *c, int number) {
    Mesh *mesh = c->builder->mesh;
    *ARENA_PUSH(c->builder->arena, mesh->shared, mesh->shared_count, c->builder->shared_capacity) = number;
}

// Notes which elements the pieces of a leaf became, the largest first; returns the code of its squares.
static int share_leaf(Cutting *c, const MeshPiece *pieces, int piece_count) {
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

// The element that a whole square is in, else `code`.
static int element_about(const Cutting *c, Vec3 middle, double reach, const MeshPiece *pieces, int count,
                         int code) {
    for (int i = 0; i < count; i++) {
        const MeshPiece *piece = &pieces[i];
        if (piece->element >= 0 && mesh_inside(piece->v, piece->count, c->face->plane.n, middle) > reach)
            return piece->element;
    }
    return code;
}

static void give_squares(Cutting *c, MeshBlock b, const MeshPiece *pieces, int count, int *squares) {
    const Face *face = c->face;
    int code = share_leaf(c, pieces, count);
    Vec3 x = vec3_scale(face->gx, 1 / vec3_dot(face->gx, face->gx)),
         y = vec3_scale(face->gy, 1 / vec3_dot(face->gy, face->gy));
    double reach = 0.5 * vec3_length(vec3_add(x, y));
    for (int j = b.j0; j <= b.j1; j++) {
        for (int i = b.i0; i <= b.i1; i++) {
            Vec3 middle = vec3_add(vec3_scale(x, i + 0.5), vec3_scale(y, j + 0.5));
            squares[j * face->nx + i] =
                code < -1 ? element_about(c, middle, reach, pieces, count, code) : code;
        }
    }
}

static void add_cut_patches(Cutting *c, int face, int first, int end, int *squares) {
    Pieces p = find_pieces(c, face, first, end);
    add_patch_of(c, face, &p, first, end, false);
    add_patch_of(c, face, &p, first, end, true);
    for (int k = first; k < end; k++) {
        int at = p.first_of[k - first];
        c->element[k] = SEVERAL;
        if (c->leaves[k].area > 0)
            give_squares(c, c->leaves[k].block, p.pieces + at, p.first_of[k - first + 1] - at, squares);
    }
}

static void add_patches(Cutting *c, Face *face, int index) {
    Mesh *mesh = c->builder->mesh;
    c->element = ARENA_ARRAY(&c->builder->scratch, int, c->leaf_count);
    int squares = face->nx * face->ny;
    bool is_cut = c->builder->first_cut[index + 1] > c->builder->first_cut[index];
    face->first_square = mesh->square_count;
    face->first_element = mesh->element_count;
    face->first_patch = mesh->patch_count;
    for (int i = 0; i < squares; i++)
        *ARENA_PUSH(c->builder->arena, mesh->squares, mesh->square_count, c->builder->square_capacity) = -1;
    int *square = mesh->squares + face->first_square;
    for (int first = 0, end; first < c->leaf_count; first = end) {
        for (end = first + 1; end < c->leaf_count && c->leaves[end].patch == c->leaves[first].patch;) end++;
        if (is_cut)
            add_cut_patches(c, index, first, end, square);
        else
            add_whole_patch(c, index, first, end);
    }
    for (int i = 0; i < squares; i++)
        if (c->element[c->owner[i]] != SEVERAL) square[i] = c->element[c->owner[i]];
    face->element_count = mesh->element_count - face->first_element;
    face->patch_count = mesh->patch_count - face->first_patch;
}

// Only what lies in squares that cuts cross takes a search: they are made small.
static void refine_grid(const MeshBuilder *builder, int index, Face *face) {
    if (builder->first_cut[index] == builder->first_cut[index + 1]) return;
    double side = 1 / fmin(vec3_length(face->gx), vec3_length(face->gy));
    for (; side > SEARCHED && (long long)face->nx * face->ny < MOST_SQUARES; side /= 2) {
        face->nx *= 2;
        face->ny *= 2;
        face->root *= 2;
        face->gx = vec3_scale(face->gx, 2);
        face->gy = vec3_scale(face->gy, 2);
    }
}

void mesh_cut_face(MeshBuilder *builder, int index) {
    Face *face = &builder->mesh->faces[index];
    refine_grid(builder, index, face);
    int squares = face->nx * face->ny;
    arena_reset(&builder->scratch);
    Vec3 *outline = ARENA_ARRAY(&builder->scratch, Vec3, face->vertex_count);
    for (int i = 0; i < face->vertex_count; i++) {
        int place = builder->mesh->outline[face->first_vertex + i];
        outline[i] = vec3_sub(builder->places.points[place], face->origin);
    }
    Cutting c = {.builder = builder,
                 .face = face,
                 .outline = outline,
                 .count = face->vertex_count,
                 .part = ARENA_ARRAY(&builder->scratch, Vec3, face->vertex_count + 8),
                 .spare = ARENA_ARRAY(&builder->scratch, Vec3, face->vertex_count + 8),
                 .square = 1 / (vec3_length(face->gx) * vec3_length(face->gy)),
                 .leaves = ARENA_ARRAY(&builder->scratch, MeshLeaf, squares),
                 .owner = ARENA_ARRAY(&builder->scratch, int, squares)};
    c.leaf_count = mesh_leaves(builder, face, c.leaves);
    measure_parts(&c);
    join_slivers(&c);
    add_patches(&c, face, index);
}
