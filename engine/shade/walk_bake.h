// walk_bake.h - light computed beforehand: on walls, floors and ceilings as texels of one texture, on other polygons at
// their corners. Results are ready for the screen: sRGB, with the surface's own colour.
#ifndef WALK_BAKE_H
#define WALK_BAKE_H

#include "engine/shade/walk_lights.h"

typedef struct Rgba8 {
    uint8_t r, g, b, a;
} Rgba8;

static inline uint8_t walk_byte(float x) { return (uint8_t)lrintf(255 * fminf(fmaxf(x, 0), 1)); }

// The colour of a material in a room without lamps or shadows, on the side to which n points (unit); and that of the sky.
Rgba8 walk_bake_plain(const Material *material, Vec3 n);
Rgba8 walk_bake_sky(void);

typedef struct WalkBake WalkBake;

// The colour that shows a material's emission, at most 1 in each channel. Radiant exitance exceeds a screen's range: every lamp is
// shown bright, in its own colour.
Rgb walk_glow(const Material *material);

// The result lives in the arena. `lights` must have been made relative to `origin`.
WalkBake *walk_bake_new(const CellGraph *graph, const WalkLights *lights, Vec3 origin, Arena *arena);

// The colour of a point of an object, seen from the side to which n points (unit). Alpha is the material's.
Rgba8 walk_bake_point(const WalkBake *bake, int object, int material, Vec3 point, Vec3 n);

// The texels of the cells' surfaces, in one texture.
typedef struct WalkAtlas {
    float *texels;  // [height * width] 1: as bright as in usual light
    int width, height;
} WalkAtlas;

// Lays out and computes the texels on all cores; a large building gets coarser texels. False where they do not fit into a texture of
// `max_side` texels each way.
bool walk_bake_surfaces(WalkBake *bake, int max_side, Arena *arena, WalkAtlas *out, Error *error);
// The colour of a surface in usual light, after walk_bake_surfaces. The colour on the screen is this colour times the texel.
Rgba8 walk_bake_surface(const WalkBake *bake, int polygon);
// The place of a surface's corner in the atlas, 0 .. 1 each way.
Vec2 walk_bake_place(const WalkBake *bake, const WalkAtlas *atlas, int polygon, Vec3 corner);

#endif
