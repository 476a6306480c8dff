// bsp.c - the painter's algorithm in the order of a binary space partition, made once for all eyes (Fuchs, Kedem & Naylor
// 1980): of each plane first the polygons beyond it, then those in it, then those on the eye's side.
//
// A piece's pixels are told by the edges of its polygon and by the planes that cut it, as lines in the picture: the two
// pieces of a cut have the same line, so that no pixel between them is lost and none is moved by the rounding of corners.
//
// The tree: a binary space partition along the planes of the polygons (H. Fuchs, Z. Kedem & B. Naylor, On visible surface
// generation by a priori tree structures, 1980). Of a few planes that one is taken which cuts least and leaves sides of
// nearly equal size.
//
// A cut edge is kept as the plane that cut it, since the corners computed for it are rounded.
#include <limits.h>
#include <stdlib.h>

#include "visibility/hidden/spans.h"

// ---- the tree

// Part of a facet.
typedef struct BspPiece {
    int facet, first, count;  // in BspTree.corners and .edges
} BspPiece;

typedef struct BspNode {
    Plane plane;                   // building space
    int child[2];                  // behind the plane, before it; -1: none
    int first_piece, piece_count;  // in the plane, the last of the list first
} BspNode;

// An edge of a piece is an edge of its facet (its number, >= 0), or the cut by a node's plane: bsp_cut.
static inline int bsp_cut(int node, int side) { return -1 - (2 * node + side); }
static inline int bsp_cut_node(int edge) { return (-1 - edge) / 2; }
static inline int bsp_cut_side(int edge) { return (-1 - edge) % 2; }  // the piece's: 0 behind, 1 before

typedef struct BspTree {
    BspNode *nodes;    // [node_count], the root first
    BspPiece *pieces;  // [piece_count]
    Vec3 *corners;     // [corner_count]
    int *edges;        // [corner_count] from a corner to the next
    int node_count, piece_count, corner_count;
    int most_edges, splits, depth;
} BspTree;

enum { CANDIDATES = 6, SAMPLE = 128 };  // planes tried, and pieces they are tried on
// One cut is as bad as so many pieces that one side has more than the other.
static const int CUT_COST = 6;

typedef struct Maker {
    const Facets *facets;
    BspTree *tree;
    Arena *arena, scratch, ids;
    int node_capacity, piece_capacity, corner_capacity, edge_capacity;
    // Pieces on their way down, with corners and edges of their own.
    BspPiece *loose;
    Vec3 *corners;
    int *edges;
    int loose_count, loose_capacity, corner_count, loose_corner_capacity, edge_count, loose_edge_capacity;
    int *next;  // [loose_capacity] of the list a loose piece is in
    int next_capacity;
} Maker;

// A list of loose pieces that waits to become a subtree.
typedef struct Job {
    int first, count;  // linked by Maker.next
    int parent, side, depth;
} Job;

static void push_corner(Maker *m, Vec3 corner, int edge) {
    *ARENA_PUSH(&m->scratch, m->corners, m->corner_count, m->loose_corner_capacity) = corner;
    *ARENA_PUSH(&m->scratch, m->edges, m->edge_count, m->loose_edge_capacity) = edge;
}

static int push_piece(Maker *m, int facet, int first) {
    int count = m->loose_count;
    *ARENA_PUSH(&m->scratch, m->next, count, m->next_capacity) = -1;
    *ARENA_PUSH(&m->scratch, m->loose, m->loose_count, m->loose_capacity) =
        (BspPiece){facet, first, m->corner_count - first};
    return m->loose_count - 1;
}

// The plane of a piece's facet, and how far from it a corner may be and still lie in it.
typedef struct Cutter {
    Plane plane;
    double rounding;
} Cutter;

static Cutter cutter_of(const Maker *m, int piece) {
    const Facet *facet = &m->facets->facets[m->loose[piece].facet];
    return (Cutter){{facet->n, vec3_dot(facet->n, facet->centre)}, facet->rounding};
}

// By the coordinates of both: polygons far away do not blur those nearby.
static double rounding_of(const Maker *m, int piece, const Cutter *by) {
    return fmax(by->rounding, m->facets->facets[m->loose[piece].facet].rounding);
}

// Which sides of the plane a piece reaches: 1 behind, 2 before, 3 both, 0 it lies in the plane.
static int bsp_piece_sides(const Maker *m, int piece, const Cutter *by) {
    const BspPiece *p = &m->loose[piece];
    double eps = rounding_of(m, piece, by);
    int sides = 0;
    for (int i = 0; i < p->count; i++) {
        double d = plane_distance(by->plane, m->corners[p->first + i]);
        sides |= d > eps ? 2 : d < -eps ? 1 : 0;
    }
    return sides;
}

static int *ids_of(Maker *m, const Job *job) {
    arena_reset(&m->ids);
    int *ids = ARENA_ARRAY(&m->ids, int, job->count), at = job->first;
    for (int i = 0; i < job->count; i++, at = m->next[at]) ids[i] = at;
    return ids;
}

// The piece whose plane is to cut the others.
static int choose_piece(const Maker *m, const int *ids, int count) {
    int best = ids[0];
    long best_cost = LONG_MAX;
    int tried = count < CANDIDATES ? count : CANDIDATES, sample = count < SAMPLE ? count : SAMPLE;
    for (int c = 0; c < tried && count > 1; c++) {
        int candidate = ids[(int)((long)c * count / tried)];
        Cutter by = cutter_of(m, candidate);
        long cuts = 0, balance = 0;
        for (int i = 0; i < sample; i++) {
            int sides = bsp_piece_sides(m, ids[(int)((long)i * count / sample)], &by);
            cuts += sides == 3;
            balance += sides == 2 ? 1 : sides == 1 ? -1 : 0;
        }
        long cost = CUT_COST * cuts + labs(balance);
        if (cost < best_cost) {
            best_cost = cost;
            best = candidate;
        }
    }
    return best;
}

// The part of a piece on one side of a node's plane, as a new loose piece.
static int cut_piece(Maker *m, int piece, const Cutter *by, int node, int side) {
    BspPiece p = m->loose[piece];
    Plane plane = by->plane;
    int first = m->corner_count, cut = bsp_cut(node, side);
    double sign = side ? 1 : -1, eps = rounding_of(m, piece, by);
    for (int i = 0; i < p.count; i++) {
        Vec3 here = m->corners[p.first + i], next = m->corners[p.first + (i + 1) % p.count];
        double d = sign * plane_distance(plane, here), after = sign * plane_distance(plane, next);
        int edge = m->edges[p.first + i];
        if (d > eps) push_corner(m, here, edge);
        // On the plane: the next edge is the cut, unless the piece's own edge goes on this side.
        if (fabs(d) <= eps) push_corner(m, here, after < -eps ? cut : edge);
        if ((d > eps && after < -eps) || (d < -eps && after > eps)) {
            double t = d / (d - after);
            push_corner(m, vec3_lerp(here, next, t), d > eps ? cut : edge);
        }
    }
    return push_piece(m, p.facet, first);
}

// In the plane of a node: it goes no further.
static void keep_piece(Maker *m, int piece) {
    BspTree *tree = m->tree;
    const BspPiece *p = &m->loose[piece];
    *ARENA_PUSH(m->arena, tree->pieces, tree->piece_count, m->piece_capacity) =
        (BspPiece){p->facet, tree->corner_count, p->count};
    for (int i = 0; i < p->count; i++) {
        int at = tree->corner_count;
        *ARENA_PUSH(m->arena, tree->corners, tree->corner_count, m->corner_capacity) =
            m->corners[p->first + i];
        *ARENA_PUSH(m->arena, tree->edges, at, m->edge_capacity) = m->edges[p->first + i];
    }
    if (p->count > tree->most_edges) tree->most_edges = p->count;
}

// From the last of the list to the first, which is painted over the others.
static void sort_pieces(const Maker *m, BspNode *node) {
    BspPiece *pieces = m->tree->pieces + node->first_piece;
    for (int i = 1; i < node->piece_count; i++) {
        BspPiece piece = pieces[i];
        int at = i;
        for (; at > 0 && m->facets->facets[pieces[at - 1].facet].order < m->facets->facets[piece.facet].order;
             at--)
            pieces[at] = pieces[at - 1];
        pieces[at] = piece;
    }
}

// Makes the node of a job, and two more jobs of the polygons behind and before it.
static void build_node(Maker *m, const Job *job, Job out[2]) {
    BspTree *tree = m->tree;
    int *ids = ids_of(m, job), at = tree->node_count, chosen = choose_piece(m, ids, job->count);
    Cutter by = cutter_of(m, chosen);
    BspNode *node = ARENA_PUSH(m->arena, tree->nodes, tree->node_count, m->node_capacity);
    *node = (BspNode){.plane = by.plane, .child = {-1, -1}, .first_piece = tree->piece_count};
    if (job->parent >= 0) tree->nodes[job->parent].child[job->side] = at;
    if (job->depth > tree->depth) tree->depth = job->depth;
    for (int side = 0; side < 2; side++) out[side] = (Job){-1, 0, at, side, job->depth + 1};
    for (int i = 0; i < job->count; i++) {
        // The chosen one stays, whatever rounding says: so every node takes one.
        int sides = ids[i] == chosen ? 0 : bsp_piece_sides(m, ids[i], &by);
        if (sides == 0) keep_piece(m, ids[i]);
        tree->splits += sides == 3;
        for (int side = 0; side < 2; side++) {
            if (!(sides & (1 << side))) continue;
            int piece = sides == 3 ? cut_piece(m, ids[i], &by, at, side) : ids[i];
            m->next[piece] = out[side].first;
            out[side].first = piece;
            out[side].count++;
        }
    }
    node = &tree->nodes[at];
    node->piece_count = tree->piece_count - node->first_piece;
    sort_pieces(m, node);
}

static BspTree bsp_tree_new(const Facets *facets, Arena *arena) {
    BspTree tree = {0};
    Maker m = {.facets = facets, .tree = &tree, .arena = arena};
    for (int i = 0; i < facets->count; i++) {
        const Facet *facet = &facets->facets[i];
        int first = m.corner_count;
        for (int k = 0; k < facet->count; k++) push_corner(&m, facets->corners[facet->first + k], k);
        push_piece(&m, i, first);
        m.next[i] = i + 1;
    }
    Job *jobs = NULL;
    int job_count = 0, job_capacity = 0;
    if (facets->count > 0)
        *ARENA_PUSH(&m.scratch, jobs, job_count, job_capacity) = (Job){0, facets->count, -1, 0, 1};
    while (job_count > 0) {
        Job job = jobs[--job_count], parts[2];
        build_node(&m, &job, parts);
        for (int side = 0; side < 2; side++)
            if (parts[side].count > 0) *ARENA_PUSH(&m.scratch, jobs, job_count, job_capacity) = parts[side];
    }
    arena_free(&m.scratch);
    arena_free(&m.ids);
    return tree;
}

// ---- the method

typedef struct Bsp {
    Facets facets;
    BspTree tree;
    Picture picture;
    int *shape_of;  // [facet count] of the picture under way, or -1
    int *stack;     // [3 * node count] nodes to visit, -1 - node to paint
    Line *lines;    // [tree.most_edges]
    Spans spans;
    size_t memory;
} Bsp;

static void *bsp_begin(const Scene *scene, Arena *arena, Error *error) {
    Bsp *b = ARENA_ARRAY(arena, Bsp, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &b->facets, error)) return NULL;
    b->tree = bsp_tree_new(&b->facets, arena);
    b->picture = picture_new(&b->facets, arena);
    b->shape_of = ARENA_ARRAY(arena, int, b->facets.count + 1);
    b->stack = ARENA_ARRAY(arena, int, 2 * b->tree.depth + 4);
    b->lines = ARENA_ARRAY(arena, Line, b->tree.most_edges + 1);
    b->spans = spans_new(arena, b->tree.most_edges);
    b->memory = arena->used - before;
    return b;
}

// The pixels a piece may cover: those of its own corners, unless it is the whole polygon or has too many.
static bool bsp_piece_bounds(const Bsp *b, const BspPiece *piece, const Shape *whole, Shape *out) {
    Vec2 corners[FACET_CORNERS + 4];
    double inverse[FACET_CORNERS + 4];
    *out = *whole;
    bool is_cut = false;
    for (int i = 0; i < piece->count; i++) is_cut |= b->tree.edges[piece->first + i] < 0;
    if (!is_cut || piece->count > FACET_CORNERS) return true;
    const Image *image = &b->picture.image;
    int count = image_outline(image, b->tree.corners + piece->first, piece->count, corners, inverse);
    return count > 0 && image_bounds(image, corners, count, out);
}

static void paint(Bsp *b, const BspPiece *piece, ItemBuffer *out, HiddenWork *work) {
    if (b->shape_of[piece->facet] < 0) return;
    const Picture *picture = &b->picture;
    const Shape *whole = &picture->shapes[b->shape_of[piece->facet]];
    Shape bounds;
    if (!bsp_piece_bounds(b, piece, whole, &bounds)) return;
    for (int i = 0; i < piece->count; i++) {
        int edge = b->tree.edges[piece->first + i];
        if (edge >= 0) {
            b->lines[i] = picture->lines[whole->first_line + edge];
            continue;
        }
        Plane plane = b->tree.nodes[bsp_cut_node(edge)].plane;
        Line cut = image_cut(&picture->image, plane.n, plane.d, picture->depth[piece->facet]);
        b->lines[i] = bsp_cut_side(edge) ? cut : -cut;
    }
    spans_take(&b->spans, &bounds, b->lines, piece->count);
    work->edges += piece->count;
    work->pixels += spans_paint(&b->spans, piece->facet, out);
}

static void paint_node(Bsp *b, const BspNode *node, ItemBuffer *out, HiddenWork *work) {
    for (int i = 0; i < node->piece_count; i++) paint(b, &b->tree.pieces[node->first_piece + i], out, work);
}

static bool bsp_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work, Error *error) {
    (void)error;
    Bsp *b = prepared;
    memset(out->item, -1, (size_t)out->width * (size_t)out->height * sizeof *out->item);
    picture_take(&b->picture, camera);
    memset(b->shape_of, -1, (size_t)b->facets.count * sizeof *b->shape_of);
    for (int i = 0; i < b->picture.shape_count; i++) b->shape_of[b->picture.shapes[i].facet] = i;
    int held = 0;
    if (b->tree.node_count > 0) b->stack[held++] = 0;
    while (held > 0) {
        int at = b->stack[--held];
        if (at < 0) {
            paint_node(b, &b->tree.nodes[-1 - at], out, work);
            continue;
        }
        const BspNode *node = &b->tree.nodes[at];
        int near = plane_distance(node->plane, camera->eye) > 0;
        work->nodes++;
        if (node->child[near] >= 0) b->stack[held++] = node->child[near];
        b->stack[held++] = -1 - at;
        if (node->child[!near] >= 0) b->stack[held++] = node->child[!near];
    }
    work->polygons = b->picture.shape_count;
    work->splits = b->tree.splits;
    work->memory = b->memory;
    picture_resolve(&b->picture, out);
    return true;
}

const HiddenMethod HIDDEN_BSP = {.name = "bsp",
                                 .summary = "painter's order of a tree of planes, made once",
                                 .begin = bsp_begin,
                                 .draw = bsp_draw};
