// depth_sort.c - the painter's algorithm with an order that is made right where depth alone does not tell (M. Newell, R. Newell
// & T. Sancha, A solution to the hidden surface problem, 1972): the farthest polygon is painted once none that overlaps it in
// depth is hidden by it; one that is goes before it; and where that leads in a ring, or two pass through each other, one of
// them is cut.
//
// All is told in the picture, where edges and depths are lines. Cutting by the plane of the other alone, as the paper
// has it, never ends when each polygon of a ring lies on one side of the others' planes: such are cut along the other's
// outline. The lines to cut along are finite in number and a cut leaves something on both sides, so it ends.
#include <stdlib.h>

#include "visibility/hidden/depth_pieces.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/spans.h"

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
