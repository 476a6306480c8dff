// light_plan.h - the plan of a storey with lines of equal light.
#ifndef APP_LIGHT_PLAN_H
#define APP_LIGHT_PLAN_H

#include "engine/app/planned_light.h"

// Before the work: is there such a storey?
bool light_plan_check(const LoadedScene *scene, int storey, Error *error);
// The lines of the lamps' illuminance, or, where no lamp is on, of the daylight factor; over the colours of the light, each room's mean
// with its name, and a legend. `pixels` is the width. Into *svg, in the arena. Fails where the storey has no rooms.
bool light_plan(const LoadedScene *scene, const PlannedLight *light, int storey, int pixels, Arena *arena,
                const char **svg, Error *error);

#endif
