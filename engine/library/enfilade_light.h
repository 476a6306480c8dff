// enfilade_light.h - hidden surfaces and light of buildings, in a library of its own (libenfilade-light), since it needs Embree and
// OSMesa.
//
// Find which polygon is visible in each pixel (hidden.h); mesh a building and light it (mesh.h, adapt.h, shoot.h, sky.h;
// daylight.h), store the light (shoot.h), and query it (reconstruct.h, gather.h, final_gather.h; path_tracer.h for reference
// values). Light is in W/m^2 per channel. A mesh and a solution are read-only once they are made; only one call at a time may
// work on each, and it uses threads of its own.
#ifndef ENFILADE_LIGHT_H
#define ENFILADE_LIGHT_H

#include "engine/library/enfilade.h"
#include "radiosity/daylight/daylight.h"
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

#endif
