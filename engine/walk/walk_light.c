// walk_light.c - radiosities to colours: those of vertices (reconstruct.c), an exposure by the mean brightness (Reinhard, Stark,
// Shirley & Ferwerda 2002), the curve of the screen.
#include "engine/walk/walk_light.h"

#include "engine/walk/walk_shade.h"
#include "radiosity/reconstruct.h"

// What a wall of middling brightness becomes, before the shoulder: rooms are mostly light paint.
static const double MIDDLE = 0.55;

static bool emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }
static double brightness(const double b[3]) { return 0.2126 * b[0] + 0.7152 * b[1] + 0.0722 * b[2]; }

// The logarithmic mean of what does not emit, made MIDDLE. Each place counts by the light that leaves it: a dark garden
// or a sealed cupboard would make all rooms too bright.
static double find_exposure(const WalkLight *light) {
    const Mesh *mesh = light->mesh;
    double power = 0, logs = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        double b = brightness(light->solution->radiosity[e]);
        if (emits(mesh_material(mesh, element->face)) || !(b > 0)) continue;
        logs += element->area * b * log(b);
        power += element->area * b;
    }
    return power > 0 ? MIDDLE / exp(logs / power) : 1;
}

static uint8_t to_screen(double b) {
    double x = b * (double)WALK_EXPOSURE;
    x *= (1 + x * (double)WALK_SHOULDER_TOP) / (1 + x * (double)WALK_SHOULDER_BOTTOM);
    return walk_byte((float)(x <= 0.0031308 ? 12.92 * x : 1.055 * pow(fmin(x, 1), 1 / 2.4) - 0.055));
}

static Rgba8 shade(const double b[3], double scale) {
    return (Rgba8){to_screen(scale * b[0]), to_screen(scale * b[1]), to_screen(scale * b[2]), 255};
}

WalkShades walk_light_shades(const WalkLight *light, Arena *arena) {
    const Mesh *mesh = light->mesh;
    Arena scratch = {0};
    VertexLight vertices = reconstruct_light(mesh, light->solution, &scratch);
    WalkShades out = {ARENA_ARRAY(arena, Rgba8, mesh->corner_count),
                      ARENA_ARRAY(arena, Rgba8, mesh->face_count), find_exposure(light)};
    for (int i = 0; i < mesh->corner_count; i++) out.corner[i] = shade(vertices.corner[i], out.exposure);
    for (int f = 0; f < mesh->face_count; f++) out.face[f] = shade(vertices.face[f], out.exposure);
    arena_free(&scratch);
    return out;
}
