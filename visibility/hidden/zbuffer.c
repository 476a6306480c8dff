// zbuffer.c - the depth buffer (E. Catmull, A subdivision algorithm for computer display of curved surfaces, 1974): each
// polygon in turn, at each of its pixels the nearer of the polygon and the one already there.
//
// The buffer holds 1/z as a float, four pixels at a time. Where two floats are so close that they do not tell, both depths are
// computed anew in doubles: so the item buffer itself is all the memory, and no digit is lost.
#include "visibility/hidden/depth.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/spans.h"

// Floats that differ by less may stand for depths that tie: rounding takes two that are equal but for the last bits of a double
// to neighbouring floats.
#define FLOAT_CLOSE 0x1p-22f

// Before loops whose counts are constants once inlined, so that all they hold stays in registers.
#ifdef __clang__
#define UNROLL _Pragma("unroll")
#else
#define UNROLL _Pragma("GCC unroll 4")
#endif

static const FourInt LANE = {0, 1, 2, 3};

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
#ifdef __AVX2__
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

// Four pixels at once, of which those of `inside` count. Returns which were written, a bit each.
static inline unsigned try_four(ZBuffer *z, float *depth, int32_t *items, int facet, int x, int y,
                                FourInt inside, Four inverse) {
    FourFloat new = four_to_float(inverse), old;
    FourInt item;
    memcpy(&old, depth, sizeof old);
    memcpy(&item, items, sizeof item);
    FourFloat close = old * FLOAT_CLOSE;
    FourInt nearer = (new > old + close) & inside, doubtful = (new >= old - close) & inside & ~nearer;
    item = (nearer & facet) | (~nearer & item);
    old = (FourFloat)((nearer & (FourInt) new) | (~nearer & (FourInt)old));
    memcpy(depth, &old, sizeof old);
    memcpy(items, &item, sizeof item);
    for (unsigned doubts = lanes_of(doubtful); __builtin_expect(doubts != 0, 0); doubts &= doubts - 1) {
        int i = __builtin_ctz(doubts);
        try_pixel(z, facet, (size_t)(depth - z->out.depth) + (size_t)i, x + i, y);
    }
    return lanes_of(nearer);
}

// A row of a large shape: its ends are known.
static inline void fill_row(ZBuffer *z, int facet, Line depth, int y, int x0, int x1) {
    size_t row = (size_t)y * (size_t)z->out.width, end = (size_t)z->out.width * (size_t)z->out.height;
    Four at = {0, 1, 2, 3}, base = four_of(depth[1] * y + depth[2]);
    int written = 0;
    for (int x = x0; x <= x1; x += FOUR) {
        size_t pixel = row + (size_t)x;
        if (__builtin_expect(pixel + FOUR > end, 0)) {
            for (int i = x; i <= x1; i++) try_pixel(z, facet, row + (size_t)i, i, y);
            break;
        }
        FourInt inside = LANE <= x1 - x;
        Four inverse = depth[0] * (at + (double)x) + base;
        written += __builtin_popcount(
            try_four(z, z->out.depth + pixel, z->out.item + pixel, facet, x, y, inside, inverse));
    }
    z->work->pixels += written;
    z->work->depth_tests += x1 - x0 + 1;
}

static void fill_large(ZBuffer *z, const Shape *shape, Line depth) {
    spans_take(&z->spans, shape, z->picture.lines, shape->line_count);
    for (int y = z->spans.y0; y <= z->spans.y1; y++) {
        int x0, x1;
        if (spans_row(&z->spans, y, &x0, &x1)) fill_row(z, shape->facet, depth, y, x0, x1);
    }
}

// A small shape: each pixel tells for itself on which side of the edges it is, which takes no division and no branch.
// `count` lines and `fours` of columns are constants where this is inlined.
static inline __attribute__((always_inline)) void fill_small(ZBuffer *z, const Shape *shape, Line depth,
                                                             const int count, const int fours) {
    const Line *lines = z->picture.lines;
    Four at = {0, 1, 2, 3}, along[4][3], depth_along[3];
    FourInt within[3];
    UNROLL
    for (int k = 0; k < fours; k++) {
        Four x = at + (double)(shape->x0 + FOUR * k);
        UNROLL
        for (int i = 0; i < count; i++) along[i][k] = lines[i][0] * x;
        depth_along[k] = depth[0] * x;
        within[k] = LANE <= shape->x1 - shape->x0 - FOUR * k;
    }
    size_t width = (size_t)z->out.width, pixel = (size_t)shape->y0 * width + (size_t)shape->x0;
    float *row = z->out.depth + pixel;
    int32_t *items = z->out.item + pixel;
    int written = 0, tests = 0, facet = shape->facet;
    for (int y = shape->y0; y <= shape->y1; y++, row += width, items += width) {
        UNROLL
        for (int k = 0; k < fours; k++) {
            Four least = along[0][k] + (lines[0][1] * y + lines[0][2]);
            UNROLL
            for (int i = 1; i < count; i++)
                least = four_least(least, along[i][k] + (lines[i][1] * y + lines[i][2]));
            FourInt inside = (four_to_float(least) >= 0) & within[k];
            Four inverse = depth_along[k] + (depth[1] * y + depth[2]);
            int x = shape->x0 + FOUR * k;
            written += __builtin_popcount(
                try_four(z, row + FOUR * k, items + FOUR * k, facet, x, y, inside, inverse));
            tests += __builtin_popcount(lanes_of(inside));
        }
    }
    z->work->pixels += written;
    z->work->depth_tests += tests;
}

static void draw_facet(ZBuffer *z, int facet) {
    Shape shape;
    Line *depth = &z->picture.depth[facet];
    if (!image_shape(&z->picture.image, &z->facets, facet, z->picture.lines, depth, &shape)) return;
    z->work->polygons++;
    z->work->edges += shape.line_count;
    int fours = (shape.x1 - shape.x0) / FOUR + 1, count = shape.line_count;
    size_t end = (size_t)shape.y1 * (size_t)z->out.width + (size_t)(shape.x0 + FOUR * fours);
    bool in_buffer = end <= (size_t)z->out.width * (size_t)z->out.height;
    if (!in_buffer || fours > 3 || count > 4) {
        fill_large(z, &shape, *depth);
    } else if (count == 3) {
        if (fours == 1) fill_small(z, &shape, *depth, 3, 1);
        if (fours == 2) fill_small(z, &shape, *depth, 3, 2);
        if (fours == 3) fill_small(z, &shape, *depth, 3, 3);
    } else {
        if (fours == 1) fill_small(z, &shape, *depth, 4, 1);
        if (fours == 2) fill_small(z, &shape, *depth, 4, 2);
        if (fours == 3) fill_small(z, &shape, *depth, 4, 3);
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
