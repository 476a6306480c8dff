// wad_merge.c - fewer and larger convex pieces: neighbours of one sector are joined where their union is convex, longest
// common edge first, until no two are left. A partition cuts farther than it must: every axis runs on to the next one.
#include <stdlib.h>

#include "maps/doom/wad.h"

// Does the boundary turn left from edge `from` to edge `to` (+1), right (-1), or go straight on (0)?
static int turn_at_corner(const WadPieces *p, const WadEdge *from, const WadEdge *to) {
    const WadAxis *a = &p->axes[from->axis], *b = &p->axes[to->axis];
    long long cross = from->side * to->side * (a->a * b->b - a->b * b->a);
    return (cross > 0) - (cross < 0);
}

static bool same_point(WadPoint a, WadPoint b) { return a.x == b.x && a.y == b.y && a.w == b.w; }

static const WadEdge *edge_of(const WadPieces *p, int piece, int k) {
    const WadPiece *it = &p->pieces[piece];
    int place = (k - it->first_edge + it->edge_count) % it->edge_count;
    return &p->edges[it->first_edge + place];
}

// Whether two pieces have the whole edge in common and make one convex piece without it.
static bool may_join(const WadPieces *p, const WadContact *c) {
    if (!c->open || p->pieces[c->piece[0]].sector != p->pieces[c->piece[1]].sector) return false;
    if (p->pieces[c->piece[0]].sector < 0) return false;
    for (int k = 0; k < 2; k++) {
        const WadEdge *start = edge_of(p, c->piece[k], c->edge[k]);
        const WadEdge *end = edge_of(p, c->piece[1 - k], c->edge[1 - k] + 1);
        if (!same_point(start->from, end->from)) return false;
        if (turn_at_corner(p, edge_of(p, c->piece[k], c->edge[k] - 1), end) < 0) return false;
    }
    return true;
}

static int longest_first(const void *p, const void *q) {
    const WadContact *a = p, *b = q;
    double x = a->high - a->low, y = b->high - b->low;
    if (x != y) return x < y ? 1 : -1;
    for (int k = 0; k < 2; k++) {
        if (a->edge[k] != b->edge[k]) return a->edge[k] < b->edge[k] ? -1 : 1;
    }
    return 0;
}

static void copy_piece(const WadPieces *from, int piece, Arena *arena, WadPieces *to) {
    const WadPiece *p = &from->pieces[piece];
    *ARENA_PUSH(arena, to->pieces, to->piece_count, to->piece_capacity) =
        (WadPiece){to->edge_count, p->edge_count, p->sector};
    for (int k = 0; k < p->edge_count; k++)
        *ARENA_PUSH(arena, to->edges, to->edge_count, to->edge_capacity) = from->edges[p->first_edge + k];
}

// All edges of both but the common one; where one goes straight on into the next, the corner between is left out.
static void join_pieces(const WadPieces *from, const WadContact *c, Arena *arena, WadPieces *to) {
    int first = to->edge_count;
    for (int k = 0; k < 2; k++) {
        int count = from->pieces[c->piece[k]].edge_count;
        const WadEdge *before = edge_of(from, c->piece[1 - k], c->edge[1 - k] - 1);
        for (int i = 1; i < count; i++) {
            const WadEdge *e = edge_of(from, c->piece[k], c->edge[k] + i);
            if (i == 1 && turn_at_corner(from, before, e) == 0) continue;
            *ARENA_PUSH(arena, to->edges, to->edge_count, to->edge_capacity) = *e;
        }
    }
    *ARENA_PUSH(arena, to->pieces, to->piece_count, to->piece_capacity) =
        (WadPiece){first, to->edge_count - first, from->pieces[c->piece[0]].sector};
}

// Joins as many pairs as there are, each piece once; whether there were any.
static bool join_pairs(const WadLineIndex *index, const WadPieces *from, Arena *arena, WadPieces *to) {
    Arena scratch = {0};
    WadContacts contacts = wad_find_contacts(from, index, &scratch);
    bool *joined = ARENA_ARRAY(&scratch, bool, from->piece_count + 1), any = false;
    if (contacts.count > 0)
        qsort(contacts.contacts, (size_t)contacts.count, sizeof *contacts.contacts, longest_first);
    *to = (WadPieces){.axes = from->axes, .line_axis = from->line_axis, .axis_count = from->axis_count};
    for (int i = 0; i < contacts.count; i++) {
        const WadContact *c = &contacts.contacts[i];
        if (joined[c->piece[0]] || joined[c->piece[1]] || !may_join(from, c)) continue;
        join_pieces(from, c, arena, to);
        joined[c->piece[0]] = joined[c->piece[1]] = any = true;
    }
    for (int i = 0; i < from->piece_count; i++) {
        if (!joined[i]) copy_piece(from, i, arena, to);
    }
    arena_free(&scratch);
    return any;
}

void wad_merge(const WadLineIndex *index, WadPieces *pieces, Arena *arena) {
    Arena scratch[2] = {{0}, {0}};
    WadPieces now = *pieces, next;
    int turns = 0;
    while (join_pairs(index, &now, &scratch[turns % 2], &next)) {
        now = next;
        turns++;
        arena_reset(&scratch[turns % 2]);
    }
    WadPieces out = {.axes = now.axes, .line_axis = now.line_axis, .axis_count = now.axis_count};
    for (int i = 0; i < now.piece_count; i++) copy_piece(&now, i, arena, &out);
    *pieces = out;
    arena_free(&scratch[0]);
    arena_free(&scratch[1]);
}
