// ray_shapes.h - facets as the rays of one picture meet them: set up when the first ray comes near.
#ifndef VISIBILITY_RAY_SHAPES_H
#define VISIBILITY_RAY_SHAPES_H

#include "visibility/hidden/image.h"

typedef struct RayShapes {
    Picture picture;
    int *taken;  // [facet count] in which look it was set up
    bool *seen;  // [facet count] can it be seen at all?
    int look;
} RayShapes;

static inline RayShapes ray_shapes_new(const Facets *facets, Arena *arena) {
    return (RayShapes){.picture = picture_new(facets, arena),
                       .taken = ARENA_ARRAY(arena, int, facets->count + 1),
                       .seen = ARENA_ARRAY(arena, bool, facets->count + 1)};
}

static inline void ray_shapes_look(RayShapes *shapes, const Camera *camera) {
    shapes->picture.image = image_new(camera);
    shapes->look++;
}

// NULL: it cannot be seen.
static inline const Shape *ray_shape(RayShapes *shapes, int facet, HiddenWork *work) {
    Picture *p = &shapes->picture;
    if (shapes->taken[facet] != shapes->look) {
        int first = p->facets->facets[facet].first;
        shapes->taken[facet] = shapes->look;
        shapes->seen[facet] =
            image_shape(&p->image, p->facets, facet, p->lines + first, &p->depth[facet], &p->shapes[facet]);
        p->shapes[facet].first_line = first;
        work->polygons += shapes->seen[facet];
    }
    return shapes->seen[facet] ? &p->shapes[facet] : NULL;
}

#endif
