// plan_model.h - the models of a .plan file: shapes in a frame of their own, and their placing in the building.
#ifndef MAPS_PLAN_MODEL_H
#define MAPS_PLAN_MODEL_H

#include "maps/building/building.h"
#include "maps/plan/plan_words.h"

// All models of a file: objects of a building of shapes, in whose own frame each is drawn. So concave faces are cut
// once, however often a model is placed.
typedef struct PlanModels {
    Building shapes;
    PlanNames names;  // index: the object
    int open_line;  // of the patch or the metaballs, the last shape, to which lines may still be added; 0: none
} PlanModels;

// Where a model stands: turned by `angle` about z, mirrored in its own x first.
typedef struct PlanStand {
    Vec3 at;
    double angle;
    bool mirror;
} PlanStand;

// The statements inside `model ... end`, behind their first word; they append to the last model.
bool plan_read_box(PlanLine *line, PlanModels *models);
bool plan_read_prism(PlanLine *line, PlanModels *models);
bool plan_read_cylinder(PlanLine *line, PlanModels *models);
bool plan_read_poly(PlanLine *line, PlanModels *models);
bool plan_read_model_light(PlanLine *line, PlanModels *models);

// The same of shapes that are exact.
bool plan_read_sphere(PlanLine *line, PlanModels *models);
bool plan_read_ellipsoid(PlanLine *line, PlanModels *models);
bool plan_read_cone(PlanLine *line, PlanModels *models);
bool plan_read_lathe(PlanLine *line, PlanModels *models);
bool plan_read_patch(PlanLine *line, PlanModels *models);
bool plan_read_trim(PlanLine *line, PlanModels *models);
bool plan_read_metaballs(PlanLine *line, PlanModels *models);
bool plan_read_ball(PlanLine *line, PlanModels *models);
// Before a line that adds nothing to the open shape: it is checked and becomes polygons.
bool plan_close_shape(PlanLine *line, PlanModels *models);
bool plan_light(PlanLine *line, const char *name, Light *out);  // x,y,z and options

// Appends a straight flight of solid steps to the last model: centred in plan, rising along +y.
void plan_add_stair(Arena *arena, PlanModels *models, Vec3 size, int steps, int material);
// Likewise one slope of the same size, four polygons.
void plan_add_ramp(Arena *arena, PlanModels *models, Vec3 size, int material);

// Appends an object with the model's polygons, and its lights. Fails where the building grows too large.
bool plan_stand_model(PlanLine *line, Arena *arena, const PlanModels *models, int model, const char *name,
                      PlanStand stand, Building *b);

#endif
