// plan_curved.h - what the statements of curved shapes in a .plan file share.
#ifndef MAPS_PLAN_CURVED_H
#define MAPS_PLAN_CURVED_H

#include "maps/plan/plan_model.h"

// Appends a shape to the last model; what it consists of, and its polygons, come after.
CurvedShape *plan_add_shape(PlanLine *line, PlanModels *models, CurvedKind kind, int material,
                            double tolerance);
// Refuses a patch, the last shape, without an area or folded over itself; `what` names it in messages.
bool plan_check_patch(PlanLine *line, const PlanModels *models, const char *what);

#endif
