// soup_finish.c - what a soup has besides its polygons.
#include "maps/polygons/soup_readers.h"

static const double EYE_HEIGHT = 1.6;  // metres above the lowest polygon
// The largest extent of a building that can be walked in, metres: less than a cupboard or more than a town is a
// mistake of units.
static const double SMALLEST = 1, LARGEST = 5000;

Rgb soup_cap(Rgb reflectance, const char *material, SoupCapped *capped) {
    float most = fmaxf(reflectance.r, fmaxf(reflectance.g, reflectance.b));
    if (most > MAPS_MAX_REFLECTANCE) {
        if (capped->count++ == 0) capped->first = material;
        capped->most = fmax(capped->most, (double)most);
    }
    return (Rgb){fminf(reflectance.r, MAPS_MAX_REFLECTANCE), fminf(reflectance.g, MAPS_MAX_REFLECTANCE),
                 fminf(reflectance.b, MAPS_MAX_REFLECTANCE)};
}

static void note_size(const char *path, const char *resize, Arena *arena, Building *b) {
    Vec3 size = vec3_sub(b->world.max, b->world.min);
    double largest = fmax(size.x, fmax(size.y, size.z));
    if (largest >= SMALLEST && largest <= LARGEST) return;
    building_note(
        arena, b, NOTE_CHANGED, b->world.min,
        "%s: is %g m wide, %g m deep and %g m high, which no building is (%g to %g m are usual); %s", path,
        size.x, size.y, size.z, SMALLEST, LARGEST, resize);
}

static void set_start(Building *b) {
    if (b->viewpoint_count > 0) {
        b->start = b->viewpoints[0].eye;
        b->start_yaw = b->viewpoints[0].yaw;
        return;
    }
    b->start = vec3_scale(vec3_add(b->world.min, b->world.max), 0.5);
    b->start.z = fmin(b->start.z, b->world.min.z + EYE_HEIGHT);
}

bool soup_finish(const char *path, const SoupCapped *capped, const char *resize, Arena *arena, Building *b,
                 Error *error) {
    if (b->polygon_count == 0)
        return error_set(error, "%s: holds no polygon that has an area (at least one is needed)", path);
    b->form = FORM_SOUP;
    b->world = box_empty();
    for (int i = 0; i < b->vertex_count; i++) b->world = box_add(b->world, b->vertices[i]);
    set_start(b);
    if (capped->count > 0) {
        building_note(arena, b, NOTE_CHANGED, b->start,
                      "%s: %d colours reflect more than %g and were capped, `%.60s` first; the most was %g",
                      path, capped->count, (double)MAPS_MAX_REFLECTANCE, capped->first, capped->most);
    }
    note_size(path, resize, arena, b);
    return true;
}
