// curved_rays.c - the kinds of curved shapes, made ready for rays: one table.
#include "visibility/rays/curved_rays.h"

#include <assert.h>

#include "visibility/bezier/bezier_clip.h"
#include "visibility/rays/metaball_hit.h"
#include "visibility/rays/quadric_hit.h"

typedef struct Kind {
    const void *(*prepare)(const Building *building, const CurvedShape *shape, Arena *arena);
    Box (*box)(const void *self);
    void (*hits)(const void *self, const Ray *ray, HitList *list, CurvedWork *work);
} Kind;

static const void *prepare_quadric(const Building *building, const CurvedShape *shape, Arena *arena) {
    (void)building;
    Quadric *quadric = ARENA_ARRAY(arena, Quadric, 1);
    *quadric = quadric_of(shape);
    return quadric;
}
static Box box_of_quadric(const void *self) { return ((const Quadric *)self)->box; }
static void hit_quadric(const void *self, const Ray *ray, HitList *list, CurvedWork *work) {
    (void)work;
    quadric_hits(self, ray, list);
}

static const void *prepare_patch(const Building *building, const CurvedShape *shape, Arena *arena) {
    return bezier_patch_new(building, shape, false, arena);
}
static Box box_of_patch(const void *self) { return ((const BezierPatch *)self)->box; }
static void hit_patch(const void *self, const Ray *ray, HitList *list, CurvedWork *work) {
    bezier_hits(self, ray, list, work);
}

static const void *prepare_balls(const Building *building, const CurvedShape *shape, Arena *arena) {
    return metaballs_new(building, shape, arena);
}
static Box box_of_balls(const void *self) { return metaballs_box(self); }
static void hit_balls(const void *self, const Ray *ray, HitList *list, CurvedWork *work) {
    metaball_hits(self, ray, list, work);
}

#define QUADRIC                                                                                              \
    { prepare_quadric, box_of_quadric, hit_quadric }
static const Kind KINDS[CURVED_KINDS] = {
    [CURVED_SPHERE] = QUADRIC,
    [CURVED_CYLINDER] = QUADRIC,
    [CURVED_CONE] = QUADRIC,
    [CURVED_PATCH] = {prepare_patch, box_of_patch, hit_patch},
    [CURVED_METABALLS] = {prepare_balls, box_of_balls, hit_balls},
};

typedef struct Shape {
    const Kind *kind;
    const void *self;
} Shape;

struct CurvedRays {
    Shape *shapes;
    int count;
};

CurvedRays *curved_rays_new(const Building *building, Arena *arena) {
    CurvedRays *rays = ARENA_ARRAY(arena, CurvedRays, 1);
    rays->count = building->shape_count;
    rays->shapes = ARENA_ARRAY(arena, Shape, rays->count + 1);
    for (int i = 0; i < rays->count; i++) {
        const CurvedShape *shape = &building->shapes[i];
        const Kind *kind = &KINDS[shape->kind];
        rays->shapes[i] = (Shape){kind, kind->prepare(building, shape, arena)};
    }
    return rays;
}

Box curved_rays_box(const CurvedRays *rays, int shape) {
    assert(shape >= 0 && shape < rays->count);
    return rays->shapes[shape].kind->box(rays->shapes[shape].self);
}

static int find_shape_hits(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hits, int max,
                           CurvedWork *work) {
    CurvedWork unwanted = {0};
    if (!work) work = &unwanted;
    work->rays++;
    HitList list = {.hits = hits, .max = max, .near = ray->near, .far = ray->far};
    rays->shapes[shape].kind->hits(rays->shapes[shape].self, ray, &list, work);
    return list.count;
}

bool curved_rays_hit(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hit, CurvedWork *work) {
    return find_shape_hits(rays, shape, ray, hit, 1, work) > 0;
}

int curved_rays_all(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hits, int max,
                    CurvedWork *work) {
    assert(max >= 2);
    return find_shape_hits(rays, shape, ray, hits, max, work);
}
