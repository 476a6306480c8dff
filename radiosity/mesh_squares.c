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

// How much longer than asked for an element's edges may be. Small faces make them shorter on the average.
static const double LONGEST = 1.15;

// How many patches, or roots, a side takes.
static int patches_along(double length, const MeshOptions *options) {
    double edge = options->element * options->per_patch * (options->splits ? 2 : 1);
    double patches = ceil(length / (LONGEST * edge));
    return patches < 1 ? 1 : (int)patches;
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
    face->nx = patches_along(x1 - x0, options);
    face->ny = patches_along(y1 - y0, options);
    face->root = options->per_patch;
    if (options->splits) face->root = 1 << mesh_deepest(builder, face->nx * face->ny);
    face->nx *= face->root;
    face->ny *= face->root;
    // On the plane, which corners miss where the polygon bends.
    base = vec3_sub(base, vec3_scale(face->plane.n, vec3_dot(face->plane.n, base) - face->plane.d));
    face->origin = vec3_add(base, vec3_add(vec3_scale(x, x0), vec3_scale(y, y0)));
    face->gx = vec3_scale(x, face->nx / (x1 - x0));
    face->gy = vec3_scale(y, face->ny / (y1 - y0));
}

// ---- parts of a face

// A patch is cut along so many lines at most, the longest, and a leaf into so many pieces.
enum { MOST_LINES = 12, MOST_PIECES = 24, SEVERAL = -2 };
// Nothing thinner is cut off, metres.
static const double THIN = 1e-3;

// What of a leaf lies on certain sides of the lines.
typedef struct Piece {
    int leaf, element;
    unsigned sides;  // bit k: before line k
    int count;
    Vec3 *v;  // [count] from the face's origin
} Piece;

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
    MeshCut lines[MOST_LINES];  // that the patch at hand is cut along
    int line_count;
    Piece *pieces;  // of the patch at hand
    int piece_count, piece_capacity;
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
static bool add_element(Cutting *c, const Vec3 *v, int count, int depth, Patch *patch, Vec3 *moment, double *weight) {
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

static void finish_patch(Cutting *c, Patch *patch, Vec3 moment, double weight) {
    Mesh *mesh = c->builder->mesh;
    if (patch->element_count == 0) return;
    patch->centre = vec3_scale(moment, 1 / weight);
    // On the plane even where the polygon bends: an eye there must not see its own face.
    Vec3 n = c->face->plane.n;
    patch->centre = vec3_sub(patch->centre, vec3_scale(n, vec3_dot(n, patch->centre)));
    patch->centre = vec3_add(c->face->origin, patch->centre);
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
        if (add_element(c, c->part, count, leaf->depth, &patch, &moment, &weight)) c->element[k] = mesh->element_count - 1;
    }
    finish_patch(c, &patch, moment, weight);
}

// ---- pieces

static Vec3 on_grid(const Face *face, Vec3 p) { return vec3(vec3_dot(face->gx, p), vec3_dot(face->gy, p), 0); }

// How long a line is within a block, metres.
static double length_in(const Cutting *c, const MeshCut *cut, MeshBlock b) {
    Vec3 p = on_grid(c->face, cut->from), q = on_grid(c->face, cut->to);
    const double low[2] = {b.i0, b.j0}, high[2] = {b.i1 + 1, b.j1 + 1}, from[2] = {p.x, p.y}, to[2] = {q.x, q.y};
    double t0 = 0, t1 = 1;
    for (int k = 0; k < 2; k++) {
        double way = to[k] - from[k];
        if (way == 0 && (from[k] <= low[k] || from[k] >= high[k])) return 0;
        if (way == 0) continue;
        double in = (low[k] - from[k]) / way, out = (high[k] - from[k]) / way;
        t0 = fmax(t0, fmin(in, out));
        t1 = fmin(t1, fmax(in, out));
    }
    return t1 <= t0 ? 0 : (t1 - t0) * vec3_length(vec3_sub(cut->to, cut->from));
}

// What lies before the line.
static Plane plane_of(const Cutting *c, const MeshCut *cut) {
    Vec3 n = vec3_normalize(vec3_cross(c->face->plane.n, vec3_sub(cut->to, cut->from)));
    return (Plane){n, vec3_dot(n, cut->from)};
}

static bool same_line(const Cutting *c, const MeshCut *a, const MeshCut *b) {
    Plane plane = plane_of(c, a);
    return fabs(plane_distance(plane, b->from)) < THIN && fabs(plane_distance(plane, b->to)) < THIN;
}

// Those that reach into the blocks of leaves first .. end - 1, each line once.
static void find_lines(Cutting *c, int face, int first, int end) {
    const MeshBuilder *builder = c->builder;
    MeshBlock all = c->leaves[first].block;
    for (int k = first; k < end; k++) {
        MeshBlock b = c->leaves[k].block;
        all = (MeshBlock){b.i0 < all.i0 ? b.i0 : all.i0, b.j0 < all.j0 ? b.j0 : all.j0, b.i1 > all.i1 ? b.i1 : all.i1,
                          b.j1 > all.j1 ? b.j1 : all.j1};
    }
    double length[MOST_LINES];
    c->line_count = 0;
    for (int i = builder->first_cut[face]; i < builder->first_cut[face + 1]; i++) {
        const MeshCut *cut = &builder->cuts[i];
        double now = length_in(c, cut, all);
        if (now < THIN) continue;
        bool known = false;
        for (int k = 0; k < c->line_count && !known; k++) known = same_line(c, &c->lines[k], cut);
        if (known) continue;
        if (c->line_count == MOST_LINES && length[MOST_LINES - 1] >= now) continue;
        int at = c->line_count < MOST_LINES ? c->line_count++ : MOST_LINES - 1;
        for (; at > 0 && length[at - 1] < now; at--) {
            c->lines[at] = c->lines[at - 1];
            length[at] = length[at - 1];
        }
        c->lines[at] = *cut;
        length[at] = now;
    }
}

static void side_range(Plane plane, const Vec3 *v, int count, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < count; i++) {
        double d = plane_distance(plane, v[i]);
        *low = fmin(*low, d);
        *high = fmax(*high, d);
    }
}

// Cuts what is there of pieces `first` .. of a leaf along a line.
static void cut_pieces(Cutting *c, int first, int line) {
    Plane plane = plane_of(c, &c->lines[line]);
    for (int i = first, count = c->piece_count; i < count; i++) {
        Piece *piece = &c->pieces[i];
        double low, high;
        side_range(plane, piece->v, piece->count, &low, &high);
        if (low > -THIN || high < THIN || c->piece_count - first >= MOST_PIECES) {
            piece->sides |= (unsigned)(high > -low) << line;
            continue;
        }
        Piece behind = {.leaf = piece->leaf, .sides = piece->sides};
        Vec3 *before = ARENA_ARRAY(&c->builder->scratch, Vec3, piece->count + 1);
        behind.v = ARENA_ARRAY(&c->builder->scratch, Vec3, piece->count + 1);
        behind.count = polygon_clip(piece->v, piece->count, (Plane){vec3_scale(plane.n, -1), -plane.d}, 0, behind.v);
        piece->count = polygon_clip(piece->v, piece->count, plane, 0, before);
        piece->v = before;
        piece->sides |= 1u << line;
        *ARENA_PUSH(&c->builder->scratch, c->pieces, c->piece_count, c->piece_capacity) = behind;
    }
}

static void find_pieces(Cutting *c, int first, int end) {
    c->piece_count = 0;
    for (int k = first; k < end; k++) {
        c->element[k] = -1;
        if (c->leaves[k].area == 0) continue;
        int count = part_in(c, c->leaves[k].block), own = c->piece_count;
        Piece piece = {.leaf = k, .element = -1, .count = count, .v = ARENA_ARRAY(&c->builder->scratch, Vec3, count + 1)};
        memcpy(piece.v, c->part, (size_t)count * sizeof *piece.v);
        *ARENA_PUSH(&c->builder->scratch, c->pieces, c->piece_count, c->piece_capacity) = piece;
        for (int line = 0; line < c->line_count; line++) cut_pieces(c, own, line);
    }
}

// Those on the same sides of all lines are a patch: so none shoots from under what stands on it.
static void add_patch_of(Cutting *c, int face, unsigned sides) {
    Mesh *mesh = c->builder->mesh;
    Patch patch = {.face = face, .first_element = mesh->element_count, .cell = -1};
    Vec3 moment = {0};
    double weight = 0;
    for (int i = 0; i < c->piece_count; i++) {
        Piece *piece = &c->pieces[i];
        if (piece->sides != sides) continue;
        int depth = c->leaves[piece->leaf].depth;
        bool good = piece->count >= 3 && add_element(c, piece->v, piece->count, depth, &patch, &moment, &weight);
        piece->element = good ? mesh->element_count - 1 : -1;
    }
    finish_patch(c, &patch, moment, weight);
}

static void push_shared(Cutting *c, int number) {
    Mesh *mesh = c->builder->mesh;
    *ARENA_PUSH(c->builder->arena, mesh->shared, mesh->shared_count, c->builder->shared_capacity) = number;
}

// Notes which elements the pieces of a leaf became, the largest first; returns the code of its squares.
static int share_leaf(Cutting *c, int first, int end) {
    Mesh *mesh = c->builder->mesh;
    int count = 0, at = mesh->shared_count;
    for (int i = first; i < end; i++) count += c->pieces[i].element >= 0;
    if (count == 0) return -1;
    push_shared(c, count);
    for (int i = first; i < end; i++)
        if (c->pieces[i].element >= 0) push_shared(c, c->pieces[i].element);
    for (int i = 1; i < count; i++) {
        int *list = mesh->shared + at + 1;
        for (int k = i; k > 0 && mesh->elements[list[k]].area > mesh->elements[list[k - 1]].area; k--) {
            int swap = list[k];
            list[k] = list[k - 1];
            list[k - 1] = swap;
        }
    }
    return count == 1 ? mesh->shared[at + 1] : ~at - 1;
}

// Squares that no line of the patch crosses have one element.
static void give_squares(Cutting *c, int leaf, int first, int end, int *squares) {
    const Face *face = c->face;
    MeshBlock b = c->leaves[leaf].block;
    int code = share_leaf(c, first, end);
    double reach = 0.5 / fmin(vec3_length(face->gx), vec3_length(face->gy));
    Vec3 step_x = vec3_scale(face->gx, 1 / vec3_dot(face->gx, face->gx)),
         step_y = vec3_scale(face->gy, 1 / vec3_dot(face->gy, face->gy));
    for (int j = b.j0; j <= b.j1; j++) {
        for (int i = b.i0; i <= b.i1; i++) {
            Vec3 middle = vec3_add(vec3_scale(step_x, i + 0.5), vec3_scale(step_y, j + 0.5));
            int here = code;
            for (int k = first; code < -1 && k < end && here == code; k++) {
                bool inside = c->pieces[k].element >= 0;
                for (int line = 0; line < c->line_count && inside; line++) {
                    double side = plane_distance(plane_of(c, &c->lines[line]), middle);
                    bool before = (c->pieces[k].sides >> line & 1) != 0;
                    inside = before ? side > 1.5 * reach : side < -1.5 * reach;
                }
                if (inside) here = c->pieces[k].element;
            }
            squares[j * face->nx + i] = here;
        }
    }
}

static void add_cut_patch(Cutting *c, int face, int first, int end, int *squares) {
    find_pieces(c, first, end);
    for (int i = 0; i < c->piece_count; i++) {
        bool done = false;
        for (int k = 0; k < i && !done; k++) done = c->pieces[k].sides == c->pieces[i].sides;
        if (!done) add_patch_of(c, face, c->pieces[i].sides);
    }
    for (int i = 0, next; i < c->piece_count; i = next) {
        for (next = i + 1; next < c->piece_count && c->pieces[next].leaf == c->pieces[i].leaf;) next++;
        c->element[c->pieces[i].leaf] = SEVERAL;
        give_squares(c, c->pieces[i].leaf, i, next, squares);
    }
}

static void add_patches(Cutting *c, Face *face, int index) {
    Mesh *mesh = c->builder->mesh;
    c->element = ARENA_ARRAY(&c->builder->scratch, int, c->leaf_count);
    int squares = face->nx * face->ny;
    face->first_square = mesh->square_count;
    face->first_element = mesh->element_count;
    face->first_patch = mesh->patch_count;
    for (int i = 0; i < squares; i++)
        *ARENA_PUSH(c->builder->arena, mesh->squares, mesh->square_count, c->builder->square_capacity) = -1;
    int *square = mesh->squares + face->first_square;
    for (int first = 0, end; first < c->leaf_count; first = end) {
        for (end = first + 1; end < c->leaf_count && c->leaves[end].patch == c->leaves[first].patch;) end++;
        find_lines(c, index, first, end);
        if (c->line_count == 0)
            add_whole_patch(c, index, first, end);
        else
            add_cut_patch(c, index, first, end, square);
    }
    for (int i = 0; i < squares; i++)
        if (c->element[c->owner[i]] != SEVERAL) square[i] = c->element[c->owner[i]];
    face->element_count = mesh->element_count - face->first_element;
    face->patch_count = mesh->patch_count - face->first_patch;
}

void mesh_cut_face(MeshBuilder *builder, int index) {
    Face *face = &builder->mesh->faces[index];
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
