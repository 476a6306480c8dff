// lit_leaf.h - light for the leaves of doors that stand elsewhere than where their light was baked.
#ifndef WALK_LIT_LEAF_H
#define WALK_LIT_LEAF_H

#include "engine/lit/lit_mesh.h"

// The radiosity of each vertex of a leaf whose door is open by the share `open`, W/m^2 into `out`, in the order of the object's
// vertices. Where the leaf stands as it was baked, that is its baked light; from a tenth of a metre away the light of the room on either
// side, as the walls, floors and ceilings that face the same way have it. Returns whether the leaf stands elsewhere.
bool lit_leaf_light(const LitMesh *lit, const LitLight *light, int object, double open, float (*out)[3]);

// The same of the plug of a door that was baked open and is closed now, where it shows beside its leaf: the mean of the light of the rooms
// on its two sides.
void lit_plug_light(const LitMesh *lit, const LitLight *light, int object, float (*out)[3]);

#endif
