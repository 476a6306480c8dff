// hidden.c - the item buffer and the table of hidden-surface methods.
#include "visibility/hidden/hidden.h"

#include <string.h>

extern const HiddenMethod HIDDEN_RAYCAST, HIDDEN_RAYCAST_GRID, HIDDEN_ZBUFFER, HIDDEN_SCANLINE,
    HIDDEN_CENTROID_SORT, HIDDEN_DEPTH_SORT, HIDDEN_BSP, HIDDEN_WARNOCK, HIDDEN_EMBREE, HIDDEN_OSMESA;
const HiddenMethod *const HIDDEN_METHODS[] = {&HIDDEN_RAYCAST,
                                              &HIDDEN_RAYCAST_GRID,
                                              &HIDDEN_ZBUFFER,
                                              &HIDDEN_SCANLINE,
                                              &HIDDEN_CENTROID_SORT,
                                              &HIDDEN_DEPTH_SORT,
                                              &HIDDEN_BSP,
                                              &HIDDEN_WARNOCK,
                                              &HIDDEN_EMBREE,
                                              &HIDDEN_OSMESA,
                                              NULL};

const HiddenMethod *hidden_find(const char *name) {
    for (int i = 0; HIDDEN_METHODS[i]; i++) {
        if (strcmp(HIDDEN_METHODS[i]->name, name) == 0) return HIDDEN_METHODS[i];
    }
    return NULL;
}

static bool is_vector(Vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

static bool is_axis(Vec3 a) { return is_vector(a) && vec3_length(a) > 0; }

bool hidden_draw(const HiddenMethod *method, void *prepared, const Camera *camera, ItemBuffer *out,
                 HiddenWork *work, Error *error) {
    HiddenWork unused;
    if (!work) work = &unused;
    *work = (HiddenWork){0};
    int width = camera->width, height = camera->height;
    if (width < 1 || height < 1 || width > HIDDEN_LARGEST || height > HIDDEN_LARGEST)
        return error_set(error, "%s: a picture of %d x %d pixels (1 to %d each)", method->name, width, height,
                         HIDDEN_LARGEST);
    if (!is_vector(camera->eye) || !is_axis(camera->forward) || !is_axis(camera->right) ||
        !is_axis(camera->up))
        return error_set(error, "%s: the camera's place or axes are no numbers", method->name);
    if (!(camera->tan_x > 0 && camera->tan_y > 0 && isfinite(camera->tan_x) && isfinite(camera->tan_y)))
        return error_set(error, "%s: the camera's extent is %g x %g (above 0)", method->name, camera->tan_x,
                         camera->tan_y);
    CORE_ASSERT(out->width == width && out->height == height);
    return method->draw(prepared, camera, out, work, error);
}

ItemBuffer item_buffer_new(Arena *arena, int width, int height) {
    size_t pixels = (size_t)width * (size_t)height;
    return (ItemBuffer){width, height, arena_alloc(arena, pixels, sizeof(int32_t)),
                        arena_alloc(arena, pixels, sizeof(float))};
}
