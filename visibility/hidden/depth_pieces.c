// depth_pieces.c - convex parts of facets in the picture, with 1/depth as a line: which hides which, and cuts.
//
// Corners only tell the order and what to cut: a sample is inside by the edges, which are those of the polygons, or the
// lines that cut them, the same line on both sides of a cut.
#include "visibility/hidden/depth_pieces.h"

#include "visibility/hidden/depth.h"

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

bool depth_pieces_cut(DepthPieces *p, int piece, Line line, int parts[2]) {
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

void depth_pieces_add(DepthPieces *p, const Picture *picture, const Shape *shape) {
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

bool depth_pieces_hides(const DepthPieces *p, int piece, int other) {
    const DepthPiece *a = &p->piece[piece], *b = &p->piece[other];
    if (apart(a, b)) return false;
    int sides = depth_piece_sides(p, a, b);
    if (sides == BEHIND) return false;
    int others = depth_piece_sides(p, b, a);
    // In one plane the first of the list is seen.
    if (sides == 0 || others == 0 ? a->order >= b->order : others == BEFORE) return false;
    return !beyond_edge(p, a, b) && !beyond_edge(p, b, a);
}
