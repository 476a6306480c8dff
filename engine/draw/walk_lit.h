// walk_lit.h - a baked building in OpenGL's memory: its elements, each corner in its own light, and the light it had before,
// from which it fades.
#ifndef WALK_LIT_H
#define WALK_LIT_H

#include "engine/draw/lit_mesh.h"

typedef struct WalkLit WalkLit;

// Makes room; nothing is uploaded yet. The mesh stays as long; the leaves in it are moved.
WalkLit *walk_lit_new(LitMesh *mesh, Arena *arena);
void walk_lit_free(WalkLit *lit);  // NULL is allowed
const LitMesh *walk_lit_mesh(const WalkLit *lit);

// Uploads the triangles, then what is new of the light, up to about so many bytes of both. True when all is there: from then
// on this light is what is faded to, and what it was filled from may change. Only when the fade before has ended.
bool walk_lit_upload(WalkLit *lit, const LitLight *light, size_t bytes);
// How much of the newest light is seen, 0 .. 1; the rest is of the one before it.
void walk_lit_fade(WalkLit *lit, double share);
double walk_lit_faded(const WalkLit *lit);

// Puts the leaves of doors where they stand; each keeps the mean light of its faces.
void walk_lit_pose(WalkLit *lit, const float *door_open);
// Makes the list of what is drawn of these objects for an eye: things, then surfaces that face it.
void walk_lit_list(WalkLit *lit, Vec3 eye, const int *objects, int object_count);
void walk_lit_bind(const WalkLit *lit);  // the table of materials
void walk_lit_draw(const WalkLit *lit, bool surfaces);

#endif
