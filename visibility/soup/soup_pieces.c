// soup_pieces.c - convex polygons in one plane: differences, hulls, and pieces joined to larger ones.
#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/soup/soup.h"

Box soup_box(const Vec3 *v, int count, double grow) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, v[i]);
    return box_grow(box, grow);
}

void soup_pieces_add(Arena *arena, SoupPieces *pieces, const Vec3 *v, int count) {
    SoupPiece *piece = ARENA_PUSH(arena, pieces->piece, pieces->count, pieces->capacity);
    piece->v = memcpy(ARENA_ARRAY(arena, Vec3, count), v, (size_t)count * sizeof *v);
    piece->count = count;
    piece->box = soup_box(v, count, 0);
}

static void keep(Arena *arena, SoupPieces *pieces, const SoupPiece *piece) {
    *ARENA_PUSH(arena, pieces->piece, pieces->count, pieces->capacity) = *piece;
}

double soup_width(const Vec3 *v, int count) {
    double girth = 0;
    for (int i = 0; i < count; i++) girth += vec3_length(vec3_sub(v[(i + 1) % count], v[i]));
    return girth > 0 ? 2 * polygon_area(v, count) / girth : 0;
}

// The plane through an edge of a polygon, upright on it; its inside is in front. `turn` is +1 where the polygon runs
// counter-clockwise about n.
static Plane edge_plane(Vec3 a, Vec3 b, Vec3 n, int turn) {
    Vec3 inward = vec3_scale(vec3_normalize(vec3_cross(n, vec3_sub(b, a))), turn);
    return (Plane){inward, vec3_dot(inward, a)};
}

static int turn_of(const Vec3 *v, int count, Vec3 n) {
    return vec3_dot(plane_of_polygon(v, count).n, n) < 0 ? -1 : 1;
}

int soup_overlap(const Vec3 *v, int count, const Vec3 *by, int by_count, Vec3 n, Vec3 *out) {
    Vec3 buffer[SOUP_MOST_CORNERS];
    CORE_ASSERT(count + by_count < SOUP_MOST_CORNERS);
    int turn = turn_of(by, by_count, n);
    memcpy(out, v, (size_t)count * sizeof *out);
    for (int i = 0; i < by_count && count > 0; i++) {
        count = polygon_clip(out, count, edge_plane(by[i], by[(i + 1) % by_count], n, turn), 0, buffer);
        memcpy(out, buffer, (size_t)count * sizeof *out);
    }
    return count >= 3 ? count : 0;
}

// Keeps the part outside the hole's first edge, then of the rest the part outside the second, and so on.
static void subtract_from(Arena *arena, const SoupPiece *piece, const Vec3 *hole, int hole_count,
                          Box hole_box, Vec3 n, double weld, SoupPieces *out) {
    if (!box_overlap(piece->box, hole_box)) {
        keep(arena, out, piece);
        return;
    }
    Vec3 rest[SOUP_MOST_CORNERS], part[SOUP_MOST_CORNERS];
    if (piece->count + hole_count > SOUP_MOST_CORNERS / 2) {
        keep(arena, out, piece);  // too round: it stays open
        return;
    }
    int count = soup_overlap(piece->v, piece->count, hole, hole_count, n, rest);
    if (count == 0 || soup_width(rest, count) <= weld) {
        keep(arena, out, piece);  // the hole lies beside it
        return;
    }
    int turn = turn_of(hole, hole_count, n);
    count = piece->count;
    memcpy(rest, piece->v, (size_t)count * sizeof *rest);
    for (int i = 0; i < hole_count && count >= 3; i++) {
        Vec3 a = hole[i], b = hole[(i + 1) % hole_count];
        if (vec3_length(vec3_sub(b, a)) <= weld) continue;
        Plane inside = edge_plane(a, b, n, turn), outside = {vec3_scale(inside.n, -1), -inside.d};
        int left = polygon_clip(rest, count, outside, 0, part);
        if (left >= 3 && soup_width(part, left) > weld) soup_pieces_add(arena, out, part, left);
        count = polygon_clip(rest, count, inside, 0, part);
        memcpy(rest, part, (size_t)count * sizeof *rest);
    }
}

void soup_pieces_subtract(Arena *arena, SoupPieces *pieces, const Vec3 *hole, int count, Vec3 n, double weld,
                          double near) {
    SoupPieces left = {.piece = pieces->spare, .capacity = pieces->spare_capacity};
    Box box = soup_box(hole, count, near);
    for (int i = 0; i < pieces->count; i++)
        subtract_from(arena, &pieces->piece[i], hole, count, box, n, weld, &left);
    left.spare = pieces->piece;
    left.spare_capacity = pieces->capacity;
    *pieces = left;
}

// A point in a plane's own frame, and where it came from.
typedef struct FlatPoint {
    double x, y;
    Vec3 p;
} FlatPoint;

static int by_flat_place(const void *p, const void *q) {
    const FlatPoint *a = p, *b = q;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    return (a->y > b->y) - (a->y < b->y);
}

// How far c lies to the left of the line a -> b.
static double left_of(const FlatPoint *a, const FlatPoint *b, const FlatPoint *c) {
    double x = b->x - a->x, y = b->y - a->y, length = hypot(x, y);
    return length > 0 ? (x * (c->y - a->y) - y * (c->x - a->x)) / length : 0;
}

// Lower chain, then upper chain (A. M. Andrew 1979).
int soup_hull(Arena *arena, const Vec3 *points, int count, Vec3 n, double weld, Vec3 *out) {
    enum { FEW = SOUP_MOST_CORNERS };
    FlatPoint few[2 * FEW + 2], *flat = few, *chain = few + FEW;
    if (count > FEW) {
        flat = ARENA_ARRAY(arena, FlatPoint, count);
        chain = ARENA_ARRAY(arena, FlatPoint, count + 2);
    }
    Vec3 u = vec3_normalize(vec3_cross(n, fabs(n.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0)));
    Vec3 w = vec3_cross(n, u);
    for (int i = 0; i < count; i++) {
        Vec3 from = vec3_sub(points[i], points[0]);
        flat[i] = (FlatPoint){vec3_dot(from, u), vec3_dot(from, w), points[i]};
    }
    qsort(flat, (size_t)count, sizeof *flat, by_flat_place);
    int kept = 0;
    for (int way = 0; way < 2; way++) {
        int least = kept;
        for (int k = 0; k < count; k++) {
            const FlatPoint *next = &flat[way ? count - 1 - k : k];
            while (kept >= least + 2 && left_of(&chain[kept - 2], &chain[kept - 1], next) <= weld) kept--;
            chain[kept++] = *next;
        }
        kept--;  // it begins the other chain
    }
    for (int i = 0; i < kept; i++) out[i] = chain[i].p;
    return kept;
}

// Joins two pieces where their hull holds no more than they do.
static bool join_soup_pieces(Arena *arena, SoupPiece *a, const SoupPiece *b, Vec3 n, double weld) {
    Vec3 all[SOUP_MOST_CORNERS], hull[SOUP_MOST_CORNERS + 1];
    if (a->count + b->count > SOUP_MOST_CORNERS / 2) return false;
    memcpy(all, a->v, (size_t)a->count * sizeof *all);
    memcpy(all + a->count, b->v, (size_t)b->count * sizeof *all);
    int count = soup_hull(arena, all, a->count + b->count, n, 0, hull);
    double girth = 0;
    for (int i = 0; i < count; i++) girth += vec3_length(vec3_sub(hull[(i + 1) % count], hull[i]));
    double more = polygon_area(hull, count) - polygon_area(a->v, a->count) - polygon_area(b->v, b->count);
    if (more > weld * girth) return false;
    a->v = memcpy(ARENA_ARRAY(arena, Vec3, count), hull, (size_t)count * sizeof *hull);
    a->count = count;
    a->box = soup_box(hull, count, 0);
    return true;
}

void soup_pieces_join(Arena *arena, SoupPieces *pieces, Vec3 n, double weld, double near) {
    for (int i = 0; i < pieces->count; i++) {
        Box around = box_grow(pieces->piece[i].box, near);
        for (int k = 0; k < pieces->count; k++) {
            if (k == i || !box_overlap(around, pieces->piece[k].box)) continue;
            if (!join_soup_pieces(arena, &pieces->piece[i], &pieces->piece[k], n, weld)) continue;
            pieces->piece[k] = pieces->piece[--pieces->count];
            if (i == pieces->count) i = k;
            around = box_grow(pieces->piece[i].box, near);
            k = -1;  // the joined piece may fit others
        }
    }
}
