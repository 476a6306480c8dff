// zbuffer.c - the depth buffer (E. Catmull, A subdivision algorithm for computer display of curved surfaces, 1974): each
// polygon in turn, at each of its pixels the nearer of it and what is there.
//
// The buffer holds 1/z as a float, four pixels at a time. Where two floats are so close that rounding could decide, both
// depths are computed anew in doubles: so the item buffer itself is all the memory, and no digit is lost.
#include "visibility/hidden/depth.h"
#include "visibility/hidden/methods.h"
#include "visibility/hidden/spans.h"

// Floats that differ by less may be in the wrong order: four roundings of half a bit.
#define FLOAT_CLOSE 0x1p-22f

typedef struct ZBuffer {
    Facets facets;
    Picture picture;
    Spans spans;
    ItemBuffer out;  // of the picture under way: facets and 1/z
    HiddenWork *work;
    size_t memory;
} ZBuffer;

static void *zbuffer_begin(const Scene *scene, Arena *arena, Error *error) {
    ZBuffer *z = ARENA_ARRAY(arena, ZBuffer, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &z->facets, error)) return NULL;
    z->picture = (Picture){.facets = &z->facets,
                           .depth = ARENA_ARRAY(arena, Line, z->facets.count + 1),
                           .lines = ARENA_ARRAY(arena, Line, FACET_CORNERS)};
    z->spans = spans_new(arena, FACET_CORNERS);
    z->memory = arena->used - before;
    return z;
}

// Bit i: lane i of the mask.
static inline unsigned lanes_of(FourInt mask) {
#ifdef __SSE__
    return (unsigned)_mm_movemask_ps((__m128)mask);
#else
    unsigned lanes = 0;
    for (int i = 0; i < FOUR; i++) lanes |= (unsigned)(mask[i] < 0) << i;
    return lanes;
#endif
}

// One pixel, by doubles.
static void try_pixel(ZBuffer *z, int facet, size_t pixel, int x, int y) {
    const Facet *facets = z->facets.facets;
    int old = z->out.item[pixel];
    double depth = line_at(&z->picture.depth[facet], x, y);
    if (old >= 0 &&
        !depth_nearer(depth, facets[facet].order, line_at(&z->picture.depth[old], x, y), facets[old].order))
        return;
    z->out.item[pixel] = facet;
    z->out.depth[pixel] = (float)depth;
    z->work->pixels++;
}

// Four pixels at once, of which those up to x1 count.
static inline int try_four(ZBuffer *z, int facet, size_t pixel, int x, int x1, int y, Four inverse) {
    FourFloat new = four_to_float(inverse), old;
    FourInt item, inside = (FourInt){0, 1, 2, 3} <= x1 - x;
    memcpy(&old, z->out.depth + pixel, sizeof old);
    memcpy(&item, z->out.item + pixel, sizeof item);
    FourFloat close = old * FLOAT_CLOSE;
    FourInt nearer = (new > old + close) & inside, doubtful = (new >= old - close) & inside & ~nearer;
    item = (nearer & facet) | (~nearer & item);
    old = (FourFloat)((nearer & (FourInt) new) | (~nearer & (FourInt)old));
    memcpy(z->out.depth + pixel, &old, sizeof old);
    memcpy(z->out.item + pixel, &item, sizeof item);
    unsigned doubts = lanes_of(doubtful);
    for (; __builtin_expect(doubts != 0, 0); doubts &= doubts - 1) {
        int i = __builtin_ctz(doubts);
        try_pixel(z, facet, pixel + (size_t)i, x + i, y);
    }
    return __builtin_popcount(lanes_of(nearer));
}

static inline void fill_row(ZBuffer *z, int facet, Line depth, int y, int x0, int x1) {
    size_t row = (size_t)y * (size_t)z->out.width, end = (size_t)z->out.width * (size_t)z->out.height;
    Four at = {0, 1, 2, 3};
    Four base = four_of(depth[1] * y + depth[2]);
    int written = 0;
    for (int x = x0; x <= x1; x += FOUR) {
        size_t pixel = row + (size_t)x;
        if (__builtin_expect(pixel + FOUR > end, 0)) {
            for (int i = x; i <= x1; i++) try_pixel(z, facet, row + (size_t)i, i, y);
            break;
        }
        Four inverse = four_of(depth[0]) * (at + (double)x) + base;
        written += try_four(z, facet, pixel, x, x1, y, inverse);
    }
    z->work->pixels += written;
    z->work->depth_tests += x1 - x0 + 1;
}

static void draw_facet(ZBuffer *z, int facet) {
    Shape shape;
    Line *lines = z->picture.lines, *depth = &z->picture.depth[facet];
    if (!image_shape(&z->picture.image, &z->facets, facet, lines, depth, &shape)) return;
    z->work->polygons++;
    z->work->edges += shape.line_count;
    spans_take(&z->spans, &shape, lines, shape.line_count);
    for (int y = z->spans.y0; y <= z->spans.y1; y++) {
        int x0, x1;
        if (spans_row(&z->spans, y, &x0, &x1)) fill_row(z, facet, *depth, y, x0, x1);
    }
}

static bool zbuffer_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                         Error *error) {
    (void)error;
    ZBuffer *z = prepared;
    size_t pixels = (size_t)out->width * (size_t)out->height;
    memset(out->item, -1, pixels * sizeof *out->item);
    memset(out->depth, 0, pixels * sizeof *out->depth);
    z->picture.image = image_new(camera);
    z->out = *out;
    z->work = work;
    for (int i = 0; i < z->facets.count; i++) draw_facet(z, i);
    picture_resolve(&z->picture, out);
    work->memory = z->memory;
    return true;
}

const HiddenMethod HIDDEN_ZBUFFER = {.name = "zbuffer",
                                     .summary = "depth buffer, polygon by polygon",
                                     .begin = zbuffer_begin,
                                     .draw = zbuffer_draw};
