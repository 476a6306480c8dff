// bsp.c - the painter's algorithm in the order of a binary space partition, made once for all eyes (Fuchs, Kedem & Naylor
// 1980): of each plane first what is beyond it, then what lies in it, then what is on the eye's side.
//
// A piece's pixels are told by the edges of its polygon and by the planes that cut it, as lines in the picture: the two
// pieces of a cut have the same line, so that no pixel between them is lost and none is moved by the rounding of corners.
#include "visibility/hidden/bsp_tree.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/spans.h"

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
