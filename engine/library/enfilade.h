// enfilade.h - all that the library offers, in the order in which one needs it.
//
// Read a building (maps.h, lamp_faces.h), find cells, portals and stab trees (vis.h; pairs.h for finer sets), ask for what can be
// seen (vis.h) or which polygon lies in each pixel (hidden.h), mesh and light it (mesh.h, adapt.h, shoot.h, sky.h), and ask for the
// light (reconstruct.h, gather.h, final_gather.h; path_tracer.h for the truth).
//
// Lengths are metres, z is up, angles radians, light W/m^2 a channel. What can fail returns false and one sentence in an Error; what
// is made lies in the caller's Arena and goes with it. Options come from a function `..._default_options`. Nothing here prints, and
// nothing is global but a count of memory: buildings may be worked on side by side.
#ifndef ENFILADE_H
#define ENFILADE_H

#ifdef __cplusplus
extern "C" {
#endif

#include "maps/building/lamp_faces.h"
#include "maps/maps.h"
#include "radiosity/factors/form_factor.h"
#include "radiosity/mesh/mesh.h"
#include "radiosity/shoot/adapt.h"
#include "radiosity/shoot/shoot.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/gather.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_tracer.h"
#include "visibility/hidden/hidden.h"
#include "visibility/pairs/pairs.h"
#include "visibility/vis.h"

#ifdef __cplusplus
}
#endif

#endif
