// walk_textures.h - the pictures of a building in OpenGL's memory, and their places at vertices.
//
// All pictures are resampled to the sides of one of two arrays of textures. A draw list has a run of triangles without a picture, then one
// for each array, so that the shader of plain triangles stays as short as it is for a building without pictures.
#ifndef WALK_TEXTURES_H
#define WALK_TEXTURES_H

#include "visibility/vis.h"

// The runs of a draw list: 0 has no pictures, run i those of array i - 1. As the `run` of a drawing function WALK_ALL_RUNS draws all.
enum { WALK_RUNS = 3, WALK_ALL_RUNS = -1 };

typedef struct WalkTextures WalkTextures;

// The texels of both arrays together, their smaller levels not counted: 171 MB of OpenGL's memory.
#define WALK_TEXTURES_MOST_TEXELS (32 << 20)

// Uploads the pictures that materials and the sky show. The result lives in the arena; NULL, with an error, where OpenGL refuses them.
WalkTextures *walk_textures_new(const Building *building, Arena *arena, Error *error);
void walk_textures_free(WalkTextures *textures);  // NULL is allowed

// How many runs draw lists have: 1 where no material has a picture.
int walk_textures_runs(const WalkTextures *textures);
// The run of a polygon. Polygons that emit light are drawn without their picture: they are shown bright throughout.
int walk_textures_run(const WalkTextures *textures, const Polygon *polygon);

// The attributes of a vertex: its place in the picture, and by how much the picture's texels, squared, multiply the light of its
// material's mean reflectance and, last, how much they cover.
typedef struct WalkPicture {
    float place[3];  // u, v, layer
    float strength[4];
} WalkPicture;
// The locations of both attributes in the shaders.
enum { WALK_PLACE_PICTURE = 10, WALK_PLACE_STRENGTH = 11 };
// Writes the attributes of points of a polygon, `first` its first corner; of leaves as when closed. A polygon of run 0 gets zeros.
void walk_textures_place(const WalkTextures *textures, const Polygon *polygon, Vec3 first, const Vec3 *points,
                         int count, WalkPicture *out);
// Describes a buffer of WalkPicture to the bound vertex array.
void walk_textures_describe(unsigned buffer);

// Binds the array of a run, 1 or more, to WALK_UNIT_PICTURES.
void walk_textures_bind(const WalkTextures *textures, int run);
bool walk_textures_has_sky(const WalkTextures *textures);
// Binds the picture of the sky there. `strength` of its texels, squared, gives a sky of the mean luminance 1; returns the direction of its
// left edge, Building.sky_start.
float walk_textures_bind_sky(const WalkTextures *textures, double strength[3]);

#endif
