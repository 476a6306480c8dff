// centroid_sort.c - the painter's algorithm by the depth of each polygon's centroid alone (the lecture's Z sort): simple, and
// wrong where polygons are large for their distance, pass through each other or overlap in a ring.
#include <stdlib.h>

#include "visibility/hidden/hidden.h"
#include "visibility/hidden/spans.h"

typedef struct Place {
    double depth;  // of the centroid along the view, metres
    int order;
    int shape;
} Place;

typedef struct CentroidSort {
    Facets facets;
    Picture picture;
    Place *places;  // [facet count]
    Spans spans;
    size_t memory;
} CentroidSort;

static void *centroid_sort_begin(const Scene *scene, Arena *arena, Error *error) {
    CentroidSort *self = ARENA_ARRAY(arena, CentroidSort, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &self->facets, error)) return NULL;
    self->picture = picture_new(&self->facets, arena);
    self->places = ARENA_ARRAY(arena, Place, self->facets.count + 1);
    self->spans = spans_new(arena, FACET_CORNERS);
    self->memory = arena->used - before;
    return self;
}

// The farthest first; of equal ones the last in the list.
static int compare_places(const void *a, const void *b) {
    const Place *p = a, *q = b;
    if (p->depth != q->depth) return p->depth > q->depth ? -1 : 1;
    return (p->order < q->order) - (p->order > q->order);
}

static bool centroid_sort_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                               Error *error) {
    (void)error;
    CentroidSort *self = prepared;
    Picture *picture = &self->picture;
    memset(out->item, -1, (size_t)out->width * (size_t)out->height * sizeof *out->item);
    picture_take(picture, camera);
    for (int i = 0; i < picture->shape_count; i++) {
        const Facet *facet = &self->facets.facets[picture->shapes[i].facet];
        double depth = vec3_dot(camera->forward, vec3_sub(facet->centre, camera->eye));
        self->places[i] = (Place){depth, facet->order, i};
    }
    qsort(self->places, (size_t)picture->shape_count, sizeof *self->places, compare_places);
    for (int i = 0; i < picture->shape_count; i++) {
        const Shape *shape = &picture->shapes[self->places[i].shape];
        spans_take(&self->spans, shape, picture->lines + shape->first_line, shape->line_count);
        work->edges += shape->line_count;
        work->pixels += spans_paint(&self->spans, shape->facet, out);
    }
    work->polygons = picture->shape_count;
    work->memory = self->memory;
    picture_resolve(picture, out);
    return true;
}

const HiddenMethod HIDDEN_CENTROID_SORT = {.name = "centroid-sort",
                                           .summary = "painter's order by centroids; may fail",
                                           .begin = centroid_sort_begin,
                                           .draw = centroid_sort_draw,
                                           .truth = HIDDEN_GUESS};
