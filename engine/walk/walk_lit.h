// walk_lit.h - a baked building in OpenGL's memory: its elements, each corner in its own light.
#ifndef WALK_LIT_H
#define WALK_LIT_H

#include "engine/walk/walk_light.h"

typedef struct WalkLit WalkLit;

// Positions are relative to `origin`. All is uploaded here; the light may go afterwards.
WalkLit *walk_lit_new(const WalkLight *light, Vec3 origin, Arena *arena);
void walk_lit_free(WalkLit *lit);  // NULL is allowed

// Puts the leaves of doors where they stand; each keeps the mean light of its faces.
void walk_lit_pose(WalkLit *lit, const float *door_open);
// Makes the list of what is drawn of these objects for an eye: things, then surfaces that face it.
void walk_lit_list(WalkLit *lit, Vec3 eye, const int *objects, int object_count);
void walk_lit_draw(const WalkLit *lit, bool surfaces);

#endif
