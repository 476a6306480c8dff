// depth_sort.c - the painter's algorithm with an order that is made right where depth alone does not tell (M. Newell, R. Newell
// & T. Sancha, A solution to the hidden surface problem, 1972): the farthest polygon is painted once none that overlaps it in
// depth is hidden by it; one that is goes before it; and where that leads in a ring, or two pass through each other, one of
// them is cut.
//
// All is told in the picture, where edges and depths are lines. Cutting by the plane of the other alone, as the paper
// has it, never ends when each polygon of a ring lies on one side of the others' planes: such are cut along the other's
// outline. The lines to cut along are finite in number and a cut leaves something on both sides, so it ends.
//
// Pieces are convex parts of facets in the picture, with 1/depth as a line. Corners only tell the order and what to cut: a
// sample is inside by the edges, which are those of the polygons, or the lines that cut them, the same line on both sides of a
// cut.
#include <stdlib.h>

#include "visibility/hidden/depth.h"
#include "visibility/hidden/spans.h"

// ---- pieces: which hides which, and cuts

typedef struct DepthPiece {
    int facet, order;
    int first, count;          // in DepthPieces.corners and .edges
    int next;                  // in a list of its owner
    double x0, x1, y0, y1;     // of its corners, pixels
    double nearest, farthest;  // 1/z of its corners: most and least
    Line depth;
} DepthPiece;

typedef struct DepthPieces {
    DepthPiece *piece;  // [count]
    Vec2 *corners;      // [corner_count] pixels
    // [corner_count] from a corner to the next; lane 3 is 1 / length of (a, b), so that distances come in pixels
    Line *edges;
    int count, corner_count;
    Arena *arena;
    int capacity, corner_capacity, edge_capacity;
} DepthPieces;

// Pieces that reach less than this over a line are on one side of it, pixels: below the millionth that edges may be off.
#define PIECE_TOUCH 1e-7
// 1/depths that differ by less than this share are equal: below DEPTH_TIE, above rounding.
#define PIECE_TIE 1e-10

static Line measured(Line line) {
    double length = hypot(line[0], line[1]);
    line[3] = length > 0 ? 1 / length : 0;
    return line;
}

static double pixels_from(const Line *line, Vec2 at) { return line_at(line, at.x, at.y) * (*line)[3]; }

static void add_corner(DepthPieces *p, Vec2 corner, Line edge) {
    *ARENA_PUSH(p->arena, p->corners, p->corner_count, p->corner_capacity) = corner;
    int last = p->corner_count - 1;
    *ARENA_PUSH(p->arena, p->edges, last, p->edge_capacity) = edge;
}

static void end_piece(DepthPieces *p, int facet, int order, int first, Line depth) {
    DepthPiece piece = {.facet = facet,
                        .order = order,
                        .first = first,
                        .count = p->corner_count - first,
                        .next = -1,
                        .x0 = INFINITY,
                        .x1 = -INFINITY,
                        .y0 = INFINITY,
                        .y1 = -INFINITY,
                        .nearest = 0,
                        .farthest = INFINITY,
                        .depth = depth};
    for (int i = first; i < p->corner_count; i++) {
        Vec2 at = p->corners[i];
        double inverse = line_at(&depth, at.x, at.y);
        piece.x0 = fmin(piece.x0, at.x), piece.x1 = fmax(piece.x1, at.x);
        piece.y0 = fmin(piece.y0, at.y), piece.y1 = fmax(piece.y1, at.y);
        piece.nearest = fmax(piece.nearest, inverse), piece.farthest = fmin(piece.farthest, inverse);
    }
    *ARENA_PUSH(p->arena, p->piece, p->count, p->capacity) = piece;
}

// Corners of the part on the line's side (sign 1 or -1), of a piece's corners first .. first + count - 1.
static void add_side(DepthPieces *p, int first, int count, Line line, double sign) {
    Line cut = four_of(sign) * line;
    cut[3] = line[3];
    for (int i = 0; i < count; i++) {
        Vec2 here = p->corners[first + i], next = p->corners[first + (i + 1) % count];
        Line edge = p->edges[first + i];
        double d = pixels_from(&cut, here), after = pixels_from(&cut, next);
        if (d >= 0) add_corner(p, here, after < 0 && d == 0 ? cut : edge);
        if ((d > 0 && after < 0) || (d < 0 && after > 0)) {
            Vec2 at = vec2_add(here, vec2_scale(vec2_sub(next, here), d / (d - after)));
            add_corner(p, at, d > 0 ? cut : edge);
        }
    }
}

// Cuts a piece in two along a line of the picture; false where that leaves nothing on one side.
static bool depth_pieces_cut(DepthPieces *p, int piece, Line line, int parts[2]) {
    DepthPiece whole = p->piece[piece];
    double most = 0, least = 0;
    line = measured(line);
    for (int i = 0; i < whole.count; i++) {
        double d = pixels_from(&line, p->corners[whole.first + i]);
        most = fmax(most, d);
        least = fmin(least, d);
    }
    if (!(most > PIECE_TOUCH && least < -PIECE_TOUCH)) return false;
    for (int k = 0; k < 2; k++) {
        int first = p->corner_count;
        add_side(p, whole.first, whole.count, line, k ? -1 : 1);
        end_piece(p, whole.facet, whole.order, first, whole.depth);
        parts[k] = p->count - 1;
    }
    return true;
}

// A facet that ends outside the picture, or passes through the eye's plane: the picture's frame, a pixel larger, cut by
// its edges.
static void add_frame(DepthPieces *p, const Image *image) {
    double right = image->width, bottom = image->height;
    add_corner(p, vec2(-1, -1), measured((Line){0, 1, 1, 0}));
    add_corner(p, vec2(right, -1), measured((Line){-1, 0, right, 0}));
    add_corner(p, vec2(right, bottom), measured((Line){0, -1, bottom, 0}));
    add_corner(p, vec2(-1, bottom), measured((Line){1, 0, 1, 0}));
}

// A shape of the picture, clipped to it.
static void depth_pieces_add(DepthPieces *p, const Picture *picture, const Shape *shape) {
    const Facets *facets = picture->facets;
    int order = facets->facets[shape->facet].order, start = p->corner_count, first = start;
    add_frame(p, &picture->image);
    for (int i = 0; i < shape->line_count; i++) {
        int count = p->corner_count - first, next = p->corner_count;
        add_side(p, first, count, measured(picture->lines[shape->first_line + i]), 1);
        first = next;
    }
    // Moves the last ring to where the first began.
    int count = p->corner_count - first;
    memmove(p->corners + start, p->corners + first, sizeof *p->corners * (size_t)count);
    memmove(p->edges + start, p->edges + first, sizeof *p->edges * (size_t)count);
    p->corner_count = start + count;
    if (count >= 3) {
        end_piece(p, shape->facet, order, start, picture->depth[shape->facet]);
    } else {
        p->corner_count = start;
    }
}

static bool apart(const DepthPiece *a, const DepthPiece *b) {
    return a->x1 <= b->x0 || b->x1 <= a->x0 || a->y1 <= b->y0 || b->y1 <= a->y0;
}

// Has b no corner within a's edge i?
static bool beyond_edge(const DepthPieces *p, const DepthPiece *a, const DepthPiece *b) {
    for (int i = 0; i < a->count; i++) {
        const Line *edge = &p->edges[a->first + i];
        int k = 0;
        while (k < b->count && pixels_from(edge, p->corners[b->first + k]) <= PIECE_TOUCH) k++;
        if (k == b->count) return true;
    }
    return false;
}

typedef enum Side { BEHIND = 1, BEFORE = 2 } Side;

// Where a's corners lie relative to b's plane. Next to the line of intersection they lie in it: so a piece that reaches both
// sides can be cut there.
static int depth_piece_sides(const DepthPieces *p, const DepthPiece *a, const DepthPiece *b) {
    Line difference = measured(a->depth - b->depth);
    int sides = 0;
    for (int i = 0; i < a->count; i++) {
        Vec2 at = p->corners[a->first + i];
        double off = line_at(&difference, at.x, at.y), tie = PIECE_TIE * line_at(&a->depth, at.x, at.y);
        if (fabs(off) <= tie || fabs(off) * difference[3] <= PIECE_TOUCH) continue;
        sides |= off > 0 ? BEFORE : BEHIND;
    }
    return sides;
}

// Does it hide some of the other, so that it may not be painted before it?
static bool depth_pieces_hides(const DepthPieces *p, int piece, int other) {
    const DepthPiece *a = &p->piece[piece], *b = &p->piece[other];
    if (apart(a, b)) return false;
    int sides = depth_piece_sides(p, a, b);
    if (sides == BEHIND) return false;
    int others = depth_piece_sides(p, b, a);
    // In one plane the first of the list is seen.
    if (sides == 0 || others == 0 ? a->order >= b->order : others == BEFORE) return false;
    return !beyond_edge(p, a, b) && !beyond_edge(p, b, a);
}

// ---- the method

typedef struct DepthSort {
    Facets facets;
    Picture picture;
    DepthPieces pieces;  // of the picture under way
    int *stack;          // [stack_count] moved before their turn, the next to be painted last
    int stack_count, stack_capacity;
    int list;  // the other pieces, farthest first, by DepthPiece.next; -1: none
    Arena scratch;
    HiddenWork *work;
    size_t memory;
} DepthSort;

static void *depth_sort_begin(const Scene *scene, Arena *arena, Error *error) {
    DepthSort *s = ARENA_ARRAY(arena, DepthSort, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &s->facets, error)) return NULL;
    s->picture = picture_new(&s->facets, arena);
    s->memory = arena->used - before;
    return s;
}

static void depth_sort_end(void *prepared) { arena_free(&((DepthSort *)prepared)->scratch); }

typedef struct Place {
    double farthest;
    int piece;
} Place;

static int compare_places(const void *a, const void *b) {
    const Place *p = a, *q = b;
    if (p->farthest != q->farthest) return p->farthest < q->farthest ? -1 : 1;
    return (p->piece < q->piece) - (p->piece > q->piece);
}

static void make_list(DepthSort *s) {
    DepthPieces *pieces = &s->pieces;
    Arena places_arena = {0};
    Place *places = ARENA_ARRAY(&places_arena, Place, s->picture.shape_count + 1);
    for (int i = 0; i < s->picture.shape_count; i++)
        depth_pieces_add(pieces, &s->picture, &s->picture.shapes[i]);
    for (int i = 0; i < pieces->count; i++) places[i] = (Place){pieces->piece[i].farthest, i};
    qsort(places, (size_t)pieces->count, sizeof *places, compare_places);
    s->list = -1;
    for (int i = pieces->count - 1; i >= 0; i--) {
        pieces->piece[places[i].piece].next = s->list;
        s->list = places[i].piece;
    }
    arena_free(&places_arena);
}

static void insert(DepthSort *s, int piece) {
    DepthPiece *all = s->pieces.piece;
    int *at = &s->list;
    while (*at >= 0 && all[*at].farthest < all[piece].farthest) at = &all[*at].next;
    all[piece].next = *at;
    *at = piece;
}

// Takes the piece out of stack or list; its parts go where their depths say.
static void replace(DepthSort *s, int piece, const int parts[2]) {
    DepthPiece *all = s->pieces.piece;
    int kept = 0;
    for (int i = 0; i < s->stack_count; i++)
        if (s->stack[i] != piece) s->stack[kept++] = s->stack[i];
    if (kept == s->stack_count) {
        int *at = &s->list;
        while (*at != piece) at = &all[*at].next;
        *at = all[piece].next;
    }
    s->stack_count = kept;
    insert(s, parts[0]);
    insert(s, parts[1]);
    s->work->splits++;
}

// Cuts one where the other passes through it, or along the other's outline.
static bool cut_by(DepthSort *s, int piece, int other) {
    const DepthPiece *p = &s->pieces.piece[piece], *q = &s->pieces.piece[other];
    int parts[2], edges = q->count, first = q->first;
    bool cut = depth_pieces_cut(&s->pieces, piece, p->depth - q->depth, parts);
    for (int i = 0; i < edges && !cut; i++)
        cut = depth_pieces_cut(&s->pieces, piece, s->pieces.edges[first + i], parts);
    if (cut) replace(s, piece, parts);
    return cut;
}

// A ring through pieces of the stack from place `from` up: cuts one of them by another.
static bool cut_ring(DepthSort *s, int from) {
    for (int i = s->stack_count - 1; i >= from; i--)
        for (int k = from; k < s->stack_count; k++)
            if (i != k && cut_by(s, s->stack[i], s->stack[k])) return true;
    return false;
}

static void push(DepthSort *s, int piece) {
    *ARENA_PUSH(&s->scratch, s->stack, s->stack_count, s->stack_capacity) = piece;
}

// Is the top of the stack hidden by none of the others there? Else something was cut. `from`: those already looked at.
static bool settle_stack(DepthSort *s) {
    int top = s->stack[s->stack_count - 1];
    for (int i = s->stack_count - 2; i >= 0; i--) {
        s->work->comparisons++;
        if (!depth_pieces_hides(&s->pieces, top, s->stack[i])) continue;
        if (cut_ring(s, i)) return false;
        s->work->undecided++;
    }
    return true;
}

// May the top of the stack be painted before all of the list? Else another came on top of it, or something was cut.
static bool settle_list(DepthSort *s) {
    DepthPieces *pieces = &s->pieces;
    int top = s->stack[s->stack_count - 1];
    double nearest = pieces->piece[top].nearest;
    for (int *at = &s->list; *at >= 0 && pieces->piece[*at].farthest < nearest;
         at = &pieces->piece[*at].next) {
        int other = *at;
        s->work->comparisons++;
        if (!depth_pieces_hides(pieces, top, other)) continue;
        if (!depth_pieces_hides(pieces, other, top)) {
            *at = pieces->piece[other].next;
            push(s, other);
            return false;
        }
        if (cut_by(s, top, other) || cut_by(s, other, top)) return false;
        s->work->undecided++;
    }
    return true;
}

static void paint_all(DepthSort *s, ItemBuffer *out) {
    Spans spans = {0};
    DepthPieces *pieces = &s->pieces;
    while (s->stack_count > 0 || s->list >= 0) {
        if (s->stack_count == 0) {
            push(s, s->list);
            s->list = pieces->piece[s->list].next;
        }
        if (!settle_stack(s) || !settle_list(s)) continue;
        const DepthPiece *piece = &pieces->piece[s->stack[--s->stack_count]];
        Shape bounds;
        if (!image_bounds(&s->picture.image, pieces->corners + piece->first, piece->count, &bounds)) continue;
        if (spans.capacity <= piece->count) spans = spans_new(&s->scratch, 2 * piece->count);
        spans_take(&spans, &bounds, pieces->edges + piece->first, piece->count);
        s->work->edges += piece->count;
        s->work->pixels += spans_paint(&spans, piece->facet, out);
    }
}

static bool depth_sort_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                            Error *error) {
    (void)error;
    DepthSort *s = prepared;
    memset(out->item, -1, (size_t)out->width * (size_t)out->height * sizeof *out->item);
    arena_reset(&s->scratch);
    s->pieces = (DepthPieces){.arena = &s->scratch};
    s->stack = NULL;
    s->stack_count = s->stack_capacity = 0;
    s->work = work;
    picture_take(&s->picture, camera);
    make_list(s);
    paint_all(s, out);
    work->polygons = s->picture.shape_count;
    work->memory = s->memory + s->scratch.used;
    picture_resolve(&s->picture, out);
    return true;
}

const HiddenMethod HIDDEN_DEPTH_SORT = {.name = "depth-sort",
                                        .summary = "painter's order, cut where there is none",
                                        .begin = depth_sort_begin,
                                        .draw = depth_sort_draw,
                                        .end = depth_sort_end};
