// walk_bake.h - light computed before it is drawn: on walls, floors and ceilings as texels of a texture, on other polygons at
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

// The texels of a polygon of a cell's surface: texel (i, j) is i from the left and j rows down; its middle is (first_u + i + 0.5,
// first_v + j + 0.5) texel sides from the origin along the two axes of the polygon's plane. They reach past the polygon's edge.
typedef struct WalkTexels {
    Plane plane;
    double side;  // of a texel, metres
    double first_u, first_v;
    int width, height;
} WalkTexels;

// Lays the texels out; `coarseness`, 1 or more, is by how much their sides are longer than usual.
WalkTexels walk_bake_texels(const WalkBake *bake, int object, int polygon, double coarseness);
// The least coarseness, in steps, at which all surfaces together have at most `most` texels; at most WALK_COARSENESS_MOST.
double walk_bake_coarseness(const WalkBake *bake, long most);
// By then each surface has its fewest texels.
#define WALK_COARSENESS_MOST 100.0
#define WALK_COARSENESS_STEP 1.5
// Computes the texels; 1: as bright as in usual light. Rows of `out` begin `row` floats apart. Any number of threads may call it.
void walk_bake_fill(const WalkBake *bake, int object, int polygon, const WalkTexels *texels, float *out,
                    size_t row);
// The colour of a surface in usual light. The colour on the screen is this colour times the texel.
Rgba8 walk_bake_surface(const WalkBake *bake, int object, int polygon);
// The place of a point of the polygon, in texels from the left and from the first row.
Vec2 walk_bake_place(const WalkBake *bake, const WalkTexels *texels, Vec3 point);

#endif
