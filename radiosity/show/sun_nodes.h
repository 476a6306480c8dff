// sun_nodes.h - the light that comes straight from the sun's disc, exact at points of patches.
#ifndef RADIOSITY_SUN_NODES_H
#define RADIOSITY_SUN_NODES_H

#include "radiosity/daylight/daylight.h"
#include "radiosity/mesh/mesh.h"

// A mesh under a sun. Any number of threads may read it once it is made. It lives in the arena of the call that made it; the mesh must
// outlive it.
typedef struct SunNodes SunNodes;
// NULL: the day has no sun.
SunNodes *sun_nodes_new(const Mesh *mesh, const Daylight *day, Arena *arena);

// The patch that a thread looks at, and the faces that may hide the sun from it. Only one thread at a time may use it, and its arena. It
// lives in that arena.
typedef struct SunPatch SunPatch;
SunPatch *sun_patch_new(const SunNodes *sun, Arena *arena);

// A patch has nothing of the sun, the whole disc at each of its points, or the part that sun_patch_add finds.
enum { SUN_DARK, SUN_WHOLE, SUN_PARTLY };
// Goes to a patch. Points may lie `around` metres beyond its elements.
int sun_patch_look(SunPatch *at, int patch, double around);
// May the edge of a shadow that the sun's middle throws pass a convex part of the patch, its corners counter-clockwise from the front?
bool sun_patch_edge(SunPatch *at, const Vec3 *corner, int count);
// Adds the irradiance by the sun at a point of the patch, W/m^2 a channel.
void sun_patch_add(SunPatch *at, Vec3 point, double out[3]);

#endif
