// walk_bake.h - light computed beforehand: on walls, floors and ceilings as texels of one texture, on other polygons at
// their corners. Ready for the screen: sRGB, with the surface's own colour.
#ifndef WALK_BAKE_H
#define WALK_BAKE_H

#include "engine/draw/walk_lights.h"

typedef struct Rgba8 {
    uint8_t r, g, b, a;
} Rgba8;

static inline uint8_t walk_byte(float x) { return (uint8_t)lrintf(255 * fminf(fmaxf(x, 0), 1)); }

typedef struct WalkBake WalkBake;

// Radiant exitance is out of a screen's range: any lamp is bright, of its own colour. At most 1.
Rgb walk_glow(const Material *material);

// All lives in the arena. `lights` were made relative to `origin`.
WalkBake *walk_bake_new(const CellGraph *graph, const WalkLights *lights, Vec3 origin, Arena *arena);

// A point of an object seen from the side to which n points (unit). Alpha is the material's.
Rgba8 walk_bake_point(const WalkBake *bake, int object, int material, Vec3 point, Vec3 n);

// Texels of the surfaces of cells.
typedef struct WalkAtlas {
    float *texels;  // [height * width] 1: as bright as in usual light
    int width, height;
} WalkAtlas;

// Lays out and computes the texels on all cores, coarser than usual for a large building. False where a texture of
// `max_side` each way is too small.
bool walk_bake_surfaces(WalkBake *bake, int max_side, Arena *arena, WalkAtlas *out, Error *error);
// The colour of a surface in usual light, once they are laid out. What is seen is this times the texel.
Rgba8 walk_bake_surface(const WalkBake *bake, int polygon);
// Where a corner of a surface is in the atlas: 0 .. 1 each.
Vec2 walk_bake_place(const WalkBake *bake, const WalkAtlas *atlas, int polygon, Vec3 corner);

#endif
