// mesh_squares.c - cuts a face along its grid: a rectangle into nx x ny equal parts, any other convex polygon into squares clipped
// at the outline, where slivers are joined to their neighbours (Cohen & Wallace 1993, chapter 6: elements of even size and good
// shape).
#include <string.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh_parts.h"

// Squares i0 .. i1 by j0 .. j1 of a face, both included.
typedef struct MeshBlock {
    int i0, j0, i1, j1;
} MeshBlock;

// A leaf of a tree, which becomes an element, or several where it is cut: the part of the face in a block of squares.
typedef struct MeshLeaf {
    MeshBlock block;
    MeshDepth depth;
    int patch;    // the index of the patch's first leaf
    double area;  // m^2; 0: outside the face, or joined to another leaf
} MeshLeaf;

// ---- trees over the faces of a mesh: which squares are one element, and which elements are one patch.

// How a node is split.
typedef enum Cut { WHOLE, QUARTERS, HALVES } Cut;

// A node of a tree: a square, or the half of one.
typedef struct Node {
    int depth,
        patch;  // the depth of the square; the depth of the patch that the node is in, -1: above patches
    int axis;   // for a half, the axis along which the square was halved; -1: a square
} Node;
static const Node ROOT = {0, -1, -1};

static bool may_split(Node node) {
    return node.axis >= 0 ||
           (node.depth < MESH_DEEPEST && (node.patch < 0 || node.depth - node.patch < MESH_IN_PATCH));
}

static MeshDepth depth_of(Node node) {
    return (MeshDepth){(unsigned char)(node.depth + (node.axis == 0)),
                       (unsigned char)(node.depth + (node.axis == 1))};
}

static MeshBlock half_block(MeshBlock b, int axis, int k) {
    int middle = axis == 0 ? (b.i0 + b.i1 + 1) / 2 : (b.j0 + b.j1 + 1) / 2;
    // A single square cannot be halved: both children are the square itself.
    if (axis == 0 && b.i0 < b.i1) return k ? (b.i0 = middle, b) : (b.i1 = middle - 1, b);
    if (axis == 1 && b.j0 < b.j1) return k ? (b.j0 = middle, b) : (b.j1 = middle - 1, b);
    return b;
}

// Child k of a block; quarters are in order row by row.
static MeshBlock part(MeshBlock b, Cut cut, int axis, int k) {
    return cut == QUARTERS ? half_block(half_block(b, 0, k % 2), 1, k / 2) : half_block(b, axis, k);
}

// The child of a node: halves of a square are rectangles, halves of a rectangle are squares again.
static Node below(Node node, Cut cut, int axis) {
    bool square = cut == QUARTERS || node.axis >= 0;
    return square ? (Node){node.depth + 1, node.patch, -1} : (Node){node.depth, node.patch, axis};
}

// ---- reading

static bool read_bit(const MeshSplits *splits, int *at) {
    int i = (*at)++;
    return i < splits->bit_count && (splits->bits[i / 8] >> i % 8 & 1) != 0;
}

// Reads how a node is split. A node above patches that is not split into four becomes a patch.
static Cut read_cut(const MeshSplits *splits, int *at, Node *node, int *axis) {
    if (!splits->bits) {
        node->patch = 0;
        return node->depth < splits->even ? QUARTERS : WHOLE;
    }
    if (node->patch < 0) {
        if (may_split(*node) && read_bit(splits, at)) return QUARTERS;
        node->patch = node->depth;
    }
    if (!may_split(*node) || !read_bit(splits, at)) return WHOLE;
    *axis = node->axis >= 0 ? 1 - node->axis : read_bit(splits, at);
    return HALVES;
}

static int deepest(const MeshSplits *splits, int *at, Node node) {
    int axis = 0;
    Cut cut = read_cut(splits, at, &node, &axis);
    if (cut == WHOLE) return node.depth + (node.axis >= 0);
    int most = 0;
    for (int k = 0; k < (cut == QUARTERS ? 4 : 2); k++) {
        int depth = deepest(splits, at, below(node, cut, axis));
        most = depth > most ? depth : most;
    }
    return most;
}

// The depth of the next `roots` trees of the splits, from bit builder->laid on. Where the bits end, nothing more is split.
static int mesh_deepest(MeshBuilder *builder, double roots) {
    const MeshSplits *splits = builder->mesh->options.splits;
    if (!splits->bits) return splits->even;
    int most = 0;
    for (double i = 0; i < roots && builder->laid < splits->bit_count; i++) {
        int depth = deepest(splits, &builder->laid, ROOT);
        most = depth > most ? depth : most;
    }
    return most;
}

int *mesh_face_bits(const Mesh *mesh, const MeshSplits *splits, Arena *arena) {
    int *first = ARENA_ARRAY(arena, int, mesh->face_count + 1), at = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        int roots = (face->nx / face->root) * (face->ny / face->root);
        first[f] = at;
        for (int i = 0; splits->bits && i < roots && at < splits->bit_count; i++) deepest(splits, &at, ROOT);
    }
    first[mesh->face_count] = at;
    return first;
}

// Appends the leaves below a node to `out`; returns how many leaves there are now. `patch` is the index of the patch's first leaf.
static int list_node(MeshBuilder *builder, MeshBlock block, Node node, int patch, MeshLeaf *out, int count) {
    int axis = 0;
    bool above = node.patch < 0;
    Cut cut = read_cut(builder->mesh->options.splits, &builder->cut, &node, &axis);
    if (above && node.patch >= 0) patch = count;
    if (cut == WHOLE) {
        out[count] = (MeshLeaf){.block = block, .depth = depth_of(node), .patch = patch};
        return count + 1;
    }
    for (int k = 0; k < (cut == QUARTERS ? 4 : 2); k++)
        count = list_node(builder, part(block, cut, axis, k), below(node, cut, axis), patch, out, count);
    return count;
}

// Without splits: appends the elements of a patch as leaves, each with as many squares as the refined grid has in an element.
static int list_squares(const Face *face, int i0, int j0, int per_patch, int count, MeshLeaf *out) {
    int first = count, side = face->root / per_patch;
    for (int j = j0; j < j0 + face->root; j += side)
        for (int i = i0; i < i0 + face->root; i += side)
            out[count++] = (MeshLeaf){.block = {i, j, i + side - 1, j + side - 1}, .patch = first};
    return count;
}

// Lists the leaves of a face, in order of their patches; `out` has room for one leaf per square. Advances builder->cut.
static int mesh_leaves(MeshBuilder *builder, const Face *face, MeshLeaf *out) {
    int count = 0;
    for (int j = 0; j < face->ny; j += face->root) {
        for (int i = 0; i < face->nx; i += face->root) {
            MeshBlock root = {i, j, i + face->root - 1, j + face->root - 1};
            count = builder->mesh->options.splits
                        ? list_node(builder, root, ROOT, 0, out, count)
                        : list_squares(face, i, j, builder->mesh->options.per_patch, count, out);
        }
    }
    return count;
}

// ---- writing

// How deep a rectangle of a face's grid is wanted, as for mesh_splits_wanted.
typedef void Wanted(const void *context, const Mesh *mesh, int face, const double box[4], int along[2],
                    int *patch);

// A rectangle of a face's grid, [x0, x1) by [y0, y1). Below squares its borders are fractions, exact in binary.
typedef struct Span {
    double x0, y0, x1, y1;
} Span;

typedef struct Writer {
    const Mesh *mesh;
    int face;
    Wanted *wanted;
    const void *context;
    Arena *arena;
    MeshSplits *out;
    int capacity;
} Writer;

static bool write_bit(Writer *w, bool bit) {
    int at = w->out->bit_count++, bytes = at / 8;
    if (at % 8 == 0) *ARENA_PUSH(w->arena, w->out->bits, bytes, w->capacity) = 0;
    if (bit) w->out->bits[at / 8] = (unsigned char)(w->out->bits[at / 8] | 1 << at % 8);
    return bit;
}

static Span half_span(Span s, int axis, int k) {
    double *low = axis == 0 ? &s.x0 : &s.y0, *high = axis == 0 ? &s.x1 : &s.y1;
    *(k ? low : high) = (*low + *high) / 2;
    return s;
}

static Span part_span(Span s, Cut cut, int axis, int k) {
    return cut == QUARTERS ? half_span(half_span(s, 0, k % 2), 1, k / 2) : half_span(s, axis, k);
}

// The greatest depths wanted in a span: of elements along each axis, and of patches.
static void wanted_in(const Writer *w, Span s, int along[2], int *patch) {
    along[0] = along[1] = *patch = 0;
    w->wanted(w->context, w->mesh, w->face, (double[]){s.x0, s.y0, s.x1, s.y1}, along, patch);
}

// The axis along which a square is halved first. Where both axes are wanted, the choice leaves one half whole if possible.
static int first_axis(const Writer *w, Span s, int depth, const int wanted[2]) {
    if (wanted[1] <= depth) return 0;
    if (wanted[0] <= depth) return 1;
    for (int k = 0; k < 2; k++) {
        int along[2], patch;
        wanted_in(w, half_span(s, 1, k), along, &patch);
        if (along[0] <= depth) return 1;
    }
    return 0;
}

static Cut write_cut(Writer *w, Span s, Node *node, int *axis) {
    int along[2], patch;
    wanted_in(w, s, along, &patch);
    if (node->patch < 0) {
        if (may_split(*node) && write_bit(w, patch > node->depth)) return QUARTERS;
        node->patch = node->depth;
    }
    if (!may_split(*node)) return WHOLE;
    *axis = node->axis >= 0 ? 1 - node->axis : first_axis(w, s, node->depth, along);
    if (!write_bit(w, along[*axis] > node->depth)) return WHOLE;
    if (node->axis < 0) write_bit(w, *axis == 1);
    return HALVES;
}

static void write_node(Writer *w, Span s, Node node) {
    int axis = 0;
    Cut cut = write_cut(w, s, &node, &axis);
    for (int k = 0; cut != WHOLE && k < (cut == QUARTERS ? 4 : 2); k++)
        write_node(w, part_span(s, cut, axis, k), below(node, cut, axis));
}

MeshSplits *mesh_splits_wanted(const Mesh *mesh, Wanted *wanted, const void *context, Arena *arena) {
    CORE_ASSERT(mesh->options.splits);
    Writer w = {mesh, 0, wanted, context, arena, ARENA_ARRAY(arena, MeshSplits, 1), 0};
    for (; w.face < mesh->face_count; w.face++) {
        const Face *face = &mesh->faces[w.face];
        int root = face->root;
        for (int j = 0; j < face->ny; j += root)
            for (int i = 0; i < face->nx; i += root) write_node(&w, (Span){i, j, i + root, j + root}, ROOT);
    }
    return w.out;
}

// Depths that are wanted for whole elements.
typedef struct WholeDepths {
    const unsigned char *patch;
    const MeshDepth *element;
} WholeDepths;

static void want_whole(const void *context, const Mesh *mesh, int face, const double box[4], int along[2],
                       int *patch) {
    const WholeDepths *d = context;
    const Face *f = &mesh->faces[face];
    for (int j = (int)box[1]; j < box[3]; j++) {
        for (int i = (int)box[0]; i < box[2]; i++) {
            int e = mesh_square(mesh, f->first_square + j * f->nx + i);
            if (e < 0) continue;
            MeshDepth depth = d->element[e];
            if (d->patch[e] > *patch) *patch = d->patch[e];
            if (depth.x > along[0]) along[0] = depth.x;
            if (depth.y > along[1]) along[1] = depth.y;
        }
    }
}

MeshSplits *mesh_splits(const Mesh *mesh, const unsigned char *patch, const MeshDepth *element,
                        Arena *arena) {
    return mesh_splits_wanted(mesh, want_whole, &(WholeDepths){patch, element}, arena);
}

// ---- the grid that a face is cut along: parallel to its longest edge, about its outline.

// On faces with cuts, squares are made smaller until their side is at most SEARCHED, metres, or their number reaches MOST_SEARCHED.
static const double SEARCHED = 0.06;
static const int MOST_SEARCHED = 1 << 16;

// How many times longer than asked for an element's edges may be. On small faces elements are shorter on average.
static const double LONGEST = 1.15;

// How many patches fit along a side, for an edge length of patches.
static int patches_along(double length, double edge) {
    double patches = ceil(length / (LONGEST * edge));
    return patches < 1 ? 1 : (int)patches;
}

double mesh_count_even(const Mesh *mesh) {
    double edge = mesh->options.element * mesh->options.per_patch, per = mesh->options.per_patch, count = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        if (!mesh_owns(mesh, f)) continue;
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
        // Among edges that are equally long but for rounding, the first one counts.
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
    // The base is moved onto the plane; corners lie off the plane where the polygon bends.
    base = vec3_sub(base, vec3_scale(face->plane.n, vec3_dot(face->plane.n, base) - face->plane.d));
    face->origin = vec3_add(base, vec3_add(vec3_scale(x, x0), vec3_scale(y, y0)));
    face->gx = vec3_scale(x, face->nx / (x1 - x0));
    face->gy = vec3_scale(y, face->ny / (y1 - y0));
}

static void mesh_refine_grid(const MeshBuilder *builder, int index, Face *face) {
    if (builder->first_cut[index] == builder->first_cut[index + 1]) return;
    double side = 1 / fmin(vec3_length(face->gx), vec3_length(face->gy));
    for (; side > SEARCHED && (long long)face->nx * face->ny < MOST_SEARCHED; side /= 2) {
        face->nx *= 2;
        face->ny *= 2;
        face->root *= 2;
        face->gx = vec3_scale(face->gx, 2);
        face->gy = vec3_scale(face->gy, 2);
    }
}

// ---- faces in squares

enum { MESH_SEVERAL = -2 };

// A convex piece of a leaf, which becomes an element.
typedef struct MeshPiece {
    Vec3 *v;  // [count] metres from the face's origin
    int count;
    int element;   // the element that the piece became; -1: none
    bool covered;  // an object stands on the piece, or close in front of it
} MeshPiece;
enum { MESH_MOST_PIECES = 32 };

typedef struct MeshCutting {
    MeshBuilder *builder;
    Arena *arena;  // of the thread that cuts the face
    int index;
    const Face *face;
    bool is_cut;          // the face has cuts, because objects stand on it
    const Vec3 *outline;  // [count] metres from the face's origin
    int count;
    Vec3 *part, *spare;  // [count + 8] scratch for part_in
    MeshLeaf *leaves;    // [leaf_count]
    int leaf_count;
    int *owner;     // [nx * ny] the leaf whose block contains the square
    int *element;   // [leaf_count] the element of a leaf; -1: none; MESH_SEVERAL: the leaf is in pieces
    int *code;      // [leaf_count] the entry of Mesh.squares for the squares of a leaf in pieces
    int merged;     // slivers that became part of their neighbours
    double square;  // area of a whole square, m^2
    // The pieces into which leaves are cut: leaf k has pieces[first_piece[k]] .. pieces[first_piece[k + 1] - 1], one without cuts.
    MeshPiece *pieces;
    int *first_piece, piece_count, piece_capacity;  // [leaf_count + 1]
} MeshCutting;

// ---- elements that are covered in part, cut into open and covered pieces.

// Parts thinner than this are not cut off, metres.
static const double THIN = 1e-3;
// Two cuts in one place whose `open` directions have a cosine below minus this are the two sides of one thin object or contact.
static const double OPPOSITE = 0.99;

// Is an edge so short that its direction is only rounding? A cut through a vertex may leave such an edge there.
static bool is_rounding(Vec3 edge) { return vec3_dot(edge, edge) < MESH_WELD * MESH_WELD; }

// The unit direction inwards from a side of a polygon about the normal n; false: the side is too short to have one.
static bool inwards_of(const Vec3 *v, int count, int side, Vec3 n, Vec3 *out) {
    Vec3 edge = vec3_sub(v[side + 1 < count ? side + 1 : 0], v[side]);
    if (is_rounding(edge)) return false;
    *out = vec3_normalize(vec3_cross(n, edge));
    return true;
}

// The sides of a convex polygon about the normal n as planes that point inwards, without sides that are too short; returns how many.
// `out` has room for `count`.
static int mesh_sides(const Vec3 *v, int count, Vec3 n, Plane *out) {
    int sides = 0;
    Vec3 inwards;
    for (int i = 0; i < count; i++)
        if (inwards_of(v, count, i, n, &inwards)) out[sides++] = (Plane){inwards, vec3_dot(inwards, v[i])};
    return sides;
}

double mesh_inside(const Vec3 *v, int count, Vec3 n, Vec3 point) {
    double least = INFINITY;
    Vec3 inwards;
    for (int i = 0; i < count; i++)
        if (inwards_of(v, count, i, n, &inwards))
            least = fmin(least, vec3_dot(inwards, vec3_sub(point, v[i])));
    return least;
}

// The length of a cut's line inside a convex polygon about the normal n, metres.
static double length_in(const MeshCut *cut, const Vec3 *v, int count, Vec3 n) {
    double t0 = 0, t1 = 1;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(v[i + 1 < count ? i + 1 : 0], v[i]);
        if (is_rounding(edge)) continue;
        Vec3 inwards = vec3_cross(n, edge);
        double from = vec3_dot(inwards, vec3_sub(cut->from, v[i])),
               to = vec3_dot(inwards, vec3_sub(cut->to, v[i]));
        if (from <= 0 && to <= 0) return 0;
        if (from < 0) t0 = fmax(t0, from / (from - to));
        if (to < 0) t1 = fmin(t1, from / (from - to));
    }
    return t1 <= t0 ? 0 : (t1 - t0) * vec3_length(vec3_sub(cut->to, cut->from));
}

// Does the plane cut the polygon into two parts that are both thicker than THIN?
static bool crosses(Plane plane, const Vec3 *v, int count) {
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < count; i++) {
        double d = plane_distance(plane, v[i]);
        low = fmin(low, d);
        high = fmax(high, d);
    }
    return low < -THIN && high > THIN;
}

static MeshPiece half(const MeshPiece *piece, Plane keep, Arena *arena) {
    MeshPiece out = {.v = ARENA_ARRAY(arena, Vec3, piece->count + 1), .element = -1};
    out.count = polygon_clip(piece->v, piece->count, keep, 0, out.v);
    return out;
}

static double distance_to(const MeshCut *cut, Vec3 point) {
    Vec3 along = vec3_sub(cut->to, cut->from), off = vec3_sub(point, cut->from);
    double t = vec3_dot(along, off) / vec3_dot(along, along);
    return vec3_length(vec3_sub(off, vec3_scale(along, fmin(fmax(t, 0), 1))));
}

// The cuts nearest to a point, all at one distance, among the cuts farther away than a given distance.
typedef struct Nearest {
    const MeshCut *cuts[16];  // further ones are left out
    int count;
    double distance;
} Nearest;

static Nearest nearest_beyond(const MeshBuilder *builder, int face, Vec3 point, double beyond) {
    Nearest n = {.distance = INFINITY};
    for (int i = builder->first_cut[face]; i < builder->first_cut[face + 1]; i++) {
        const MeshCut *cut = &builder->cuts[i];
        if (vec3_dot(cut->open, cut->open) == 0) continue;
        double distance = distance_to(cut, point);
        if (distance <= beyond || distance > n.distance + THIN) continue;
        if (distance < n.distance - THIN) n.count = 0;
        n.distance = fmin(n.distance, distance);
        if (n.count < (int)(sizeof n.cuts / sizeof *n.cuts)) n.cuts[n.count++] = cut;
    }
    return n;
}

// Does another of the nearest cuts open in the opposite direction, as between two boxes side by side, or at a wall without
// thickness? Such cuts do not tell which side is covered.
static bool is_answered(const Nearest *n, const MeshCut *cut) {
    for (int i = 0; i < n->count; i++) {
        double facing = vec3_dot(vec3_normalize(n->cuts[i]->open), vec3_normalize(cut->open));
        if (facing < -OPPOSITE) return true;
    }
    return false;
}

// Is a point of a face covered? The nearest cuts that tell it decide.
static bool is_covered(const MeshBuilder *builder, int face, Vec3 point) {
    for (double beyond = -1;;) {
        Nearest n = nearest_beyond(builder, face, point, beyond);
        if (n.count == 0) return false;
        // At a corner two lines are nearest: a point on the open side of either one is open.
        double most = -INFINITY;
        for (int i = 0; i < n.count; i++) {
            if (is_answered(&n, n.cuts[i])) continue;
            most = fmax(most, vec3_dot(n.cuts[i]->open, vec3_sub(point, n.cuts[i]->from)));
        }
        if (most > -INFINITY) return most < 0;
        beyond = n.distance + THIN;
    }
}

// ---- pieces

// The mean of a piece's corners.
static Vec3 mesh_middle(const MeshPiece *piece) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < piece->count; i++) sum = vec3_add(sum, piece->v[i]);
    return vec3_scale(sum, 1.0 / piece->count);
}

// Cuts a convex polygon along the cuts of its face; returns how many pieces there are. `out` has room for MESH_MOST_PIECES; the
// corners of the pieces are in the arena.
static int mesh_cut_pieces(const MeshBuilder *builder, int face, const Vec3 *v, int count, Arena *arena,
                           MeshPiece *out) {
    Vec3 n = builder->mesh->faces[face].plane.n;
    int pieces = 1;
    out[0] = (MeshPiece){.v = ARENA_ARRAY(arena, Vec3, count), .count = count, .element = -1};
    memcpy(out[0].v, v, (size_t)count * sizeof *v);
    for (int i = builder->first_cut[face]; i < builder->first_cut[face + 1]; i++) {
        const MeshCut *cut = &builder->cuts[i];
        Vec3 across = vec3_normalize(vec3_cross(n, vec3_sub(cut->to, cut->from)));
        Plane before = {across, vec3_dot(across, cut->from)}, behind = {vec3_scale(across, -1), -before.d};
        // Only pieces that the line itself runs through are cut, not those beyond its ends.
        for (int k = 0, end = pieces; k < end && pieces < MESH_MOST_PIECES; k++) {
            MeshPiece whole = out[k];
            if (!crosses(before, whole.v, whole.count) || length_in(cut, whole.v, whole.count, n) < THIN)
                continue;
            out[k] = half(&whole, before, arena);
            out[pieces++] = half(&whole, behind, arena);
        }
    }
    for (int k = 0; k < pieces && builder->first_cut[face + 1] > builder->first_cut[face]; k++)
        out[k].covered = out[k].count >= 3 && is_covered(builder, face, mesh_middle(&out[k]));
    return pieces;
}

// ---- the element of each square of a face: the squares of a whole leaf are in the leaf's element; where a leaf is in pieces,
// a square is in the element of one piece, or has several.

// The sides of a piece, as planes that point inwards.
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

// The element whose piece contains the whole square (the circle of radius `reach` about its middle); `code` where there is none.
static int element_about(const Sides *sides, int count, Vec3 middle, double reach, int code) {
    for (int i = 0; i < count; i++) {
        if (sides[i].element < 0) continue;
        int k = 0;
        while (k < sides[i].count && plane_distance(sides[i].plane[k], middle) > reach) k++;
        if (k == sides[i].count) return sides[i].element;
    }
    return code;
}

// Sets the entries of the squares of a leaf in pieces.
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

// Sets the entries of Mesh.squares for a face, once its elements have numbers; the arena is scratch memory.
static void mesh_give_squares(const MeshCutting *c, Arena *arena) {
    const Face *face = c->face;
    int *squares = c->builder->mesh->squares + face->first_square;
    for (int i = 0; i < face->nx * face->ny; i++) {
        int element = c->element[c->owner[i]];
        squares[i] = element == MESH_SEVERAL ? -1 : element;
    }
    for (int k = 0; k < c->leaf_count; k++)
        if (c->element[k] == MESH_SEVERAL && c->leaves[k].area > 0) give_block(c, k, squares, arena);
}

// ---- the elements and patches of a face, from its leaves: whole leaves, or pieces where objects stand on the face.

// Adds twice the area times the centroid to `moment`, and twice the area to `area`, for a polygon as a fan about its first corner.
static void add_centroid(const Vec3 *v, int count, Vec3 n, Vec3 *moment, double *area) {
    for (int i = 1; i + 1 < count; i++) {
        double twice = vec3_dot(n, vec3_cross(vec3_sub(v[i], v[0]), vec3_sub(v[i + 1], v[0])));
        Vec3 sum = vec3_add(v[0], vec3_add(v[i], v[i + 1]));
        *moment = vec3_add(*moment, vec3_scale(sum, twice / 3));
        *area += twice;
    }
}

// A patch while elements are added to it.
typedef struct Growing {
    Patch patch;
    Vec3 moment;    // twice the area times the centroid, from the face's origin
    double weight;  // twice the area, m^2
} Growing;

static Growing begin_patch(const MeshCutting *c) {
    return (Growing){
        .patch = {.face = c->index, .first_element = c->builder->mesh->element_count, .cell = -1}};
}

// Makes a piece an element of the patch and sets piece->element; it stays -1 where fewer than three corners are left after welding.
static void add_piece_element(MeshCutting *c, MeshPiece *piece, MeshDepth depth, Growing *to) {
    MeshBuilder *builder = c->builder;
    Mesh *mesh = builder->mesh;
    int first = mesh->corner_count;
    for (int i = 0; i < piece->count; i++) {
        int place = places_add(&builder->places, vec3_add(c->face->origin, piece->v[i]));
        if (mesh->corner_count > first && mesh->corners[mesh->corner_count - 1] == place) continue;
        *ARENA_APPEND(&builder->scratch, mesh->corners, mesh->corner_count, builder->corner_capacity) = place;
    }
    while (mesh->corner_count > first + 1 && mesh->corners[mesh->corner_count - 1] == mesh->corners[first])
        mesh->corner_count--;
    if (mesh->corner_count < first + 3) {
        mesh->corner_count = first;
        return;
    }
    double area = polygon_area(piece->v, piece->count);
    piece->element = mesh->element_count;
    *ARENA_APPEND(builder->arena, mesh->elements, mesh->element_count, builder->element_capacity) =
        (Element){c->index, mesh->patch_count, first, mesh->corner_count - first, depth, area};
    add_centroid(piece->v, piece->count, c->face->plane.n, &to->moment, &to->weight);
    to->patch.area += area;
    to->patch.element_count++;
}

// Adds the patch to the mesh; `centre` is in metres from the face's origin.
static void finish_patch(MeshCutting *c, Growing *growing, Vec3 centre) {
    Mesh *mesh = c->builder->mesh;
    // The centre is moved onto the plane, also where the polygon bends: an eye there must not see its own face.
    Vec3 n = c->face->plane.n;
    centre = vec3_sub(centre, vec3_scale(n, vec3_dot(n, centre)));
    growing->patch.centre = vec3_add(c->face->origin, centre);
    *ARENA_APPEND(c->builder->arena, mesh->patches, mesh->patch_count, c->builder->patch_capacity) =
        growing->patch;
}

// Makes a patch of the whole leaves first .. end - 1.
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

// Finishes a patch of pieces. The centroid of the area around a box is under the box, outside all elements of the patch; then the
// patch's centre is the middle of the element nearest to the centroid.
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

// Makes a patch of the covered or of the open pieces of leaves first .. end - 1, so that no patch has both. A patch of too many pieces
// is split into several.
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
    *ARENA_APPEND(c->builder->arena, mesh->shared, mesh->shared_count, c->builder->shared_capacity) = number;
}

// Stores the elements of a leaf's pieces in Mesh.shared, the largest first; returns the entry of Mesh.squares for the leaf's squares.
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

// Adds the elements and patches of a face to the mesh; their numbers continue from face to face.
static void mesh_add_patches(MeshCutting *c) {
    Mesh *mesh = c->builder->mesh;
    Face *face = &mesh->faces[c->index];
    c->builder->places.body = places_body(&c->builder->places, mesh->outline[face->first_vertex]);
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

// The part of the face in a block is a sliver below this share of the block: it would get too few samples to measure its light.
static const double SLIVER = 0.15;
// Below this share of a square, a part is rounding.
static const double NOTHING = 1e-9;

// ---- parts of a face

// The part of the face in a block, in c->part; returns how many corners it has.
static int part_in(MeshCutting *c, MeshBlock b) {
    const Face *face = c->face;
    int count = c->count;
    memcpy(c->part, c->outline, (size_t)count * sizeof *c->part);
    // The planes are in units of squares. Nothing is cut along the grid's border, which differs from the face's edges only by rounding.
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

static double whole_of(const MeshCutting *c, MeshBlock b) {
    return c->square * (b.i1 + 1 - b.i0) * (b.j1 + 1 - b.j0);
}

static void give(MeshCutting *c, MeshBlock b, int leaf) {
    for (int j = b.j0; j <= b.j1; j++)
        for (int i = b.i0; i <= b.i1; i++) c->owner[j * c->face->nx + i] = leaf;
}

static void measure_parts(MeshCutting *c) {
    for (int k = 0; k < c->leaf_count; k++) {
        MeshLeaf *leaf = &c->leaves[k];
        int count = part_in(c, leaf->block);
        double area = count < 3 ? 0 : polygon_area(c->part, count);
        leaf->area = area < NOTHING * c->square ? 0 : area;
        give(c, leaf->block, k);
    }
}

// The leaf beyond one side of a block, if it has area and forms a larger block with this one; else -1.
static int beyond(const MeshCutting *c, MeshBlock b, int side) {
    int i = side == 0 ? b.i0 - 1 : side == 1 ? b.i1 + 1 : b.i0;
    int j = side == 2 ? b.j0 - 1 : side == 3 ? b.j1 + 1 : b.j0;
    if (i < 0 || j < 0 || i >= c->face->nx || j >= c->face->ny) return -1;
    int owner = c->owner[j * c->face->nx + i];
    MeshBlock other = c->leaves[owner].block;
    bool fits = side < 2 ? other.j0 == b.j0 && other.j1 == b.j1 : other.i0 == b.i0 && other.i1 == b.i1;
    return fits && c->leaves[owner].area > 0 ? owner : -1;
}

// Joins a sliver to the largest neighbour with which it forms a block, preferring one of its own patch. The part of a convex polygon
// in a block is convex, so the joined element is convex too. False: there is no such neighbour.
static bool join_squares(MeshCutting *c, int at) {
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
    c->merged++;
    return true;
}

static void join_slivers(MeshCutting *c) {
    for (bool joined = true; joined;) {
        joined = false;
        for (int k = 0; k < c->leaf_count; k++) {
            const MeshLeaf *leaf = &c->leaves[k];
            if (leaf->area > 0 && leaf->area < SLIVER * whole_of(c, leaf->block) && join_squares(c, k))
                joined = true;
        }
    }
}

static void find_pieces(MeshCutting *c) {
    c->first_piece = ARENA_ARRAY(c->arena, int, c->leaf_count + 1);
    for (int k = 0; k < c->leaf_count; k++) {
        MeshPiece own[MESH_MOST_PIECES];
        int corners = c->leaves[k].area > 0 ? part_in(c, c->leaves[k].block) : 0;
        int pieces =
            corners >= 3 ? mesh_cut_pieces(c->builder, c->index, c->part, corners, c->arena, own) : 0;
        c->first_piece[k] = c->piece_count;
        for (int i = 0; i < pieces; i++)
            *ARENA_PUSH(c->arena, c->pieces, c->piece_count, c->piece_capacity) = own[i];
    }
    c->first_piece[c->leaf_count] = c->piece_count;
}

// ---- all faces

// The size of a batch of faces. Splits are read in the order of faces, and elements are numbered in this order. While one thread
// numbers the elements of a batch, the others cut the faces of the next one.
enum { FACES_AT_A_TIME = 4096, SQUARES_AT_A_TIME = 1 << 17 };
// The most squares of all faces together; faces with cuts have small squares.
static const double MOST_SQUARES = 5e8;

typedef struct Batch {
    MeshCutting *cutting;  // [FACES_AT_A_TIME]
    int count;
    Arena arena, *arenas;  // [threads]
} Batch;

typedef struct Crew {
    MeshBuilder *builder;
    const Vec3
        *points;  // the places of the outlines; adding corners of elements may move the builder's array
    Batch batches[2], *cut, *numbered;
    int threads, begun;  // `begun`: faces begun so far
} Crew;

// Prepares a face for cutting and lists its leaves; returns how many squares it has.
static int begin_face(MeshBuilder *builder, int index, Arena *arena, MeshCutting *c) {
    Face *face = &builder->mesh->faces[index];
    int most_leaves = face->nx * face->ny;  // refining the grid adds squares, but no leaves
    mesh_refine_grid(builder, index, face);
    *c = (MeshCutting){.builder = builder, .index = index, .face = face};
    c->is_cut = builder->first_cut[index + 1] > builder->first_cut[index];
    c->square = 1 / (vec3_length(face->gx) * vec3_length(face->gy));
    int squares = face->nx * face->ny;
    c->leaves = ARENA_ARRAY(arena, MeshLeaf, most_leaves);
    c->owner = ARENA_ARRAY(arena, int, squares);
    c->leaf_count = mesh_leaves(builder, face, c->leaves);
    c->element = ARENA_ARRAY(arena, int, c->leaf_count);
    c->code = ARENA_ARRAY(arena, int, c->leaf_count);
    return squares;
}

static void begin_batch(Crew *crew, Batch *batch) {
    const Mesh *mesh = crew->builder->mesh;
    arena_reset(&batch->arena);
    for (int t = 0; t < crew->threads; t++) arena_reset(&batch->arenas[t]);
    batch->count = 0;
    for (int squares = 0; crew->begun < mesh->face_count && batch->count < FACES_AT_A_TIME;) {
        if (squares > SQUARES_AT_A_TIME) break;
        squares += begin_face(crew->builder, crew->begun++, &batch->arena, &batch->cutting[batch->count++]);
    }
}

static void cut_face(const Crew *crew, MeshCutting *c, Arena *arena) {
    const Face *face = c->face;
    c->arena = arena;
    Vec3 *outline = ARENA_ARRAY(c->arena, Vec3, face->vertex_count);
    for (int i = 0; i < face->vertex_count; i++) {
        int place = c->builder->mesh->outline[face->first_vertex + i];
        outline[i] = vec3_sub(crew->points[place], face->origin);
    }
    c->outline = outline;
    c->count = face->vertex_count;
    c->part = ARENA_ARRAY(c->arena, Vec3, c->count + 8);
    c->spare = ARENA_ARRAY(c->arena, Vec3, c->count + 8);
    measure_parts(c);
    join_slivers(c);
    find_pieces(c);
}

// Index 0 numbers the elements of one batch; the other indices each cut a face of the other batch.
static void number_or_cut(void *context, int index, int thread) {
    const Crew *crew = context;
    if (index > 0) {
        cut_face(crew, &crew->cut->cutting[index - 1], &crew->cut->arenas[thread]);
        return;
    }
    for (int i = 0; i < crew->numbered->count; i++) mesh_add_patches(&crew->numbered->cutting[i]);
}

static void give_squares(void *context, int index, int thread) {
    const Crew *crew = context;
    mesh_give_squares(&crew->numbered->cutting[index], &crew->numbered->arenas[thread]);
}

static double count_squares(const MeshBuilder *builder) {
    double count = 0;
    for (int f = 0; f < builder->mesh->face_count; f++) {
        Face face = builder->mesh->faces[f];
        mesh_refine_grid(builder, f, &face);
        count += (double)face.nx * face.ny;
    }
    return count;
}

bool mesh_cut_faces(MeshBuilder *builder) {
    double squares = count_squares(builder);
    if (squares > MOST_SQUARES) return false;
    builder->mesh->squares = ARENA_ARRAY(builder->arena, int, squares);
    Arena scratch = {0};
    Crew crew = {.builder = builder,
                 .points = builder->places.points,
                 .threads = parallel_threads(builder->mesh->options.threads)};
    for (int b = 0; b < 2; b++) {
        crew.batches[b].cutting = ARENA_ARRAY(&scratch, MeshCutting, FACES_AT_A_TIME);
        crew.batches[b].arenas = ARENA_ARRAY(&scratch, Arena, crew.threads);
    }
    for (int b = 0; b == 0 || crew.cut->count > 0; b++) {
        crew.cut = &crew.batches[b % 2];
        crew.numbered = &crew.batches[(b + 1) % 2];
        begin_batch(&crew, crew.cut);
        parallel_for(crew.threads, crew.cut->count + 1, number_or_cut, &crew);
        parallel_for(crew.threads, crew.numbered->count, give_squares, &crew);
    }
    for (int b = 0; b < 2; b++) {
        for (int t = 0; t < crew.threads; t++) arena_free(&crew.batches[b].arenas[t]);
        arena_free(&crew.batches[b].arena);
    }
    arena_free(&scratch);
    return true;
}
