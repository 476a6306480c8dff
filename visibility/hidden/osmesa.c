// osmesa.c - the hidden-surface method `osmesa`: an item buffer by Mesa's software rasteriser.
#include "engine/gl/gl_context.h"
#include "visibility/hidden/facets.h"
#include "visibility/hidden/gl_items.h"
#include "visibility/hidden/hidden.h"

typedef struct Prepared {
    GlContext *context;
    GlItems *items;
    Facets facets;
    Scene scene;  // of facets
    size_t memory;
} Prepared;

static void osmesa_end(void *prepared) {
    Prepared *p = prepared;
    if (gl_context_use(p->context, NULL)) gl_items_free(p->items);
    gl_context_close(p->context);
}

static void *osmesa_begin(const Scene *scene, Arena *arena, Error *error) {
    Prepared *p = ARENA_ARRAY(arena, Prepared, 1);
    size_t before = arena->used;
    if (!facets_new(scene, arena, &p->facets, error)) return NULL;
    p->scene = facets_scene(&p->facets, arena);
    p->context = gl_context_open(arena, error);
    if (!p->context) return NULL;
    p->items = gl_items_new(&p->scene, NULL, NULL, arena, error);
    p->memory = arena->used - before;
    if (p->items) return p;
    gl_context_close(p->context);
    return NULL;
}

static bool osmesa_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                        Error *error) {
    Prepared *p = prepared;
    if (!gl_context_use(p->context, error) || !gl_items_look(p->items, camera, NULL, error)) return false;
    gl_items_add(p->items, 0, p->facets.count);
    if (!gl_items_draw(p->items, error) || !gl_items_read(p->items, out, NULL, error)) return false;
    size_t pixels = (size_t)out->width * (size_t)out->height;
    for (size_t i = 0; i < pixels; i++)
        if (out->item[i] >= 0) out->item[i] = p->facets.facets[out->item[i]].polygon;
    work->polygons = p->facets.count;
    work->memory = p->memory;
    return true;
}

const HiddenMethod HIDDEN_OSMESA = {.name = "osmesa",
                                    .summary = "OpenGL in memory by Mesa's software rasteriser",
                                    .begin = osmesa_begin,
                                    .draw = osmesa_draw,
                                    .end = osmesa_end,
                                    .truth = HIDDEN_FLOAT};
