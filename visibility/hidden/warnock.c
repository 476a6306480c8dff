// warnock.c - area subdivision (J. Warnock, A hidden surface algorithm for computer generated halftone pictures, 1969): an
// area in which one polygon at most is left is drawn, any other is quartered, down to a pixel.
//
// An area is a rectangle of samples, so a line or a depth is at its least and its most in its corners: of what is decided
// there nothing is left to chance. A polygon that surrounds the area and is nearer in all its corners hides the others.
#include "visibility/hidden/depth.h"
#include "visibility/hidden/hidden.h"
#include "visibility/hidden/spans.h"

typedef struct Area {
    int x0, y0, x1, y1;  // samples, all included
} Area;

// A shape in the list of an area.
typedef struct Entry {
    int shape;
    bool surrounds;  // the area, so all areas within it
} Entry;

typedef struct Warnock {
    Facets facets;
    Picture picture;
    Spans spans;
    Arena lists;     // of the picture under way
    Entry *entries;  // the lists of an area and of those it is part of, one after the other
    int capacity;
    ItemBuffer *out;
    HiddenWork *work;
    size_t memory;
} Warnock;

static void *warnock_begin(const Scene *scene, Arena *arena, Error *error) {
    Warnock *w = ARENA_ARRAY(arena, Warnock, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &w->facets, error)) return NULL;
    w->picture = picture_new(&w->facets, arena);
    w->spans = spans_new(arena, FACET_CORNERS);
    w->memory = arena->used - before;
    return w;
}

static void warnock_end(void *prepared) { arena_free(&((Warnock *)prepared)->lists); }

typedef enum Relation { OUTSIDE, MEETS, SURROUNDS } Relation;

static Relation relation_of(const Warnock *w, const Shape *shape, const Area *a) {
    if (shape->x0 > a->x1 || shape->x1 < a->x0 || shape->y0 > a->y1 || shape->y1 < a->y0) return OUTSIDE;
    const Line *lines = w->picture.lines + shape->first_line;
    Relation relation = SURROUNDS;
    for (int i = 0; i < shape->line_count; i++) {
        bool right = lines[i][0] > 0, down = lines[i][1] > 0;
        if (line_at(&lines[i], right ? a->x1 : a->x0, down ? a->y1 : a->y0) < 0) return OUTSIDE;
        if (line_at(&lines[i], right ? a->x0 : a->x1, down ? a->y0 : a->y1) < 0) relation = MEETS;
    }
    return relation;
}

static bool nearer_at(const Warnock *w, int shape, int than, double x, double y) {
    int a = w->picture.shapes[shape].facet, b = w->picture.shapes[than].facet;
    w->work->depth_tests++;
    return depth_nearer(line_at(&w->picture.depth[a], x, y), w->facets.facets[a].order,
                        line_at(&w->picture.depth[b], x, y), w->facets.facets[b].order);
}

static bool hides(const Warnock *w, int shape, int other, const Area *a) {
    return nearer_at(w, shape, other, a->x0, a->y0) && nearer_at(w, shape, other, a->x1, a->y0) &&
           nearer_at(w, shape, other, a->x0, a->y1) && nearer_at(w, shape, other, a->x1, a->y1);
}

static void fill_area(Warnock *w, const Area *a, int shape) {
    int facet = w->picture.shapes[shape].facet;
    for (int y = a->y0; y <= a->y1; y++) {
        int32_t *item = w->out->item + (size_t)y * (size_t)w->out->width;
        for (int x = a->x0; x <= a->x1; x++) item[x] = facet;
    }
    w->work->pixels += (int64_t)(a->x1 - a->x0 + 1) * (a->y1 - a->y0 + 1);
}

static void paint(Warnock *w, const Area *a, int shape) {
    Shape bounds = w->picture.shapes[shape];
    if (bounds.x0 < a->x0) bounds.x0 = a->x0;
    if (bounds.x1 > a->x1) bounds.x1 = a->x1;
    if (bounds.y0 < a->y0) bounds.y0 = a->y0;
    if (bounds.y1 > a->y1) bounds.y1 = a->y1;
    spans_take(&w->spans, &bounds, w->picture.lines + bounds.first_line, bounds.line_count);
    w->work->edges += bounds.line_count;
    w->work->pixels += spans_paint(&w->spans, bounds.facet, w->out);
}

// The list of an area from that of the area around it: what meets it, but for what the nearest surrounding one hides.
// It starts at `first + count`; returns its length.
static int make_list(Warnock *w, const Area *a, int first, int count) {
    int kept = 0, front = -1, list = first + count;
    while (w->capacity < list + count)
        w->entries = arena_grow(&w->lists, w->entries, w->capacity, &w->capacity, sizeof *w->entries);
    double x = (a->x0 + a->x1) / 2.0, y = (a->y0 + a->y1) / 2.0;
    for (int i = first; i < list; i++) {
        Entry e = w->entries[i];
        w->work->comparisons += !e.surrounds;
        Relation relation = e.surrounds ? SURROUNDS : relation_of(w, &w->picture.shapes[e.shape], a);
        if (relation == OUTSIDE) continue;
        e.surrounds = relation == SURROUNDS;
        w->entries[list + kept++] = e;
        if (e.surrounds && (front < 0 || nearer_at(w, e.shape, front, x, y))) front = e.shape;
    }
    if (front < 0) return kept;
    int left = 0;
    for (int i = 0; i < kept; i++) {
        Entry e = w->entries[list + i];
        if (e.shape == front || !hides(w, front, e.shape, a)) w->entries[list + left++] = e;
    }
    return left;
}

// The polygons left in a list at a single sample surround it.
static void draw_sample(Warnock *w, const Area *a, int list, int count) {
    int best = w->entries[list].shape;
    for (int i = 1; i < count; i++)
        if (nearer_at(w, w->entries[list + i].shape, best, a->x0, a->y0)) best = w->entries[list + i].shape;
    fill_area(w, a, best);
}

static void draw_area(Warnock *w, const Area *a, int first, int count) {
    w->work->nodes++;
    int list = first + count, left = make_list(w, a, first, count);
    if (left == 0) return;
    if (left == 1) {
        if (w->entries[list].surrounds) {
            fill_area(w, a, w->entries[list].shape);
        } else {
            paint(w, a, w->entries[list].shape);
        }
        return;
    }
    if (a->x0 == a->x1 && a->y0 == a->y1) {
        draw_sample(w, a, list, left);
        return;
    }
    w->work->splits++;
    int x = a->x0 + (a->x1 - a->x0) / 2, y = a->y0 + (a->y1 - a->y0) / 2;
    for (int part = 0; part < 4; part++) {
        Area of = {part & 1 ? x + 1 : a->x0, part & 2 ? y + 1 : a->y0, part & 1 ? a->x1 : x,
                   part & 2 ? a->y1 : y};
        if (of.x0 <= of.x1 && of.y0 <= of.y1) draw_area(w, &of, list, left);
    }
}

static bool warnock_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                         Error *error) {
    (void)error;
    Warnock *w = prepared;
    memset(out->item, -1, (size_t)out->width * (size_t)out->height * sizeof *out->item);
    arena_reset(&w->lists);
    w->out = out;
    w->work = work;
    picture_take(&w->picture, camera);
    w->capacity = 2 * w->picture.shape_count + 1;
    w->entries = ARENA_ARRAY(&w->lists, Entry, w->capacity);
    for (int i = 0; i < w->picture.shape_count; i++) w->entries[i] = (Entry){i, false};
    Area all = {0, 0, out->width - 1, out->height - 1};
    draw_area(w, &all, 0, w->picture.shape_count);
    work->polygons = w->picture.shape_count;
    work->memory = w->memory + (size_t)w->capacity * sizeof *w->entries;
    picture_resolve(&w->picture, out);
    return true;
}

const HiddenMethod HIDDEN_WARNOCK = {.name = "warnock",
                                     .summary = "areas quartered until one polygon is left",
                                     .begin = warnock_begin,
                                     .draw = warnock_draw,
                                     .end = warnock_end};
