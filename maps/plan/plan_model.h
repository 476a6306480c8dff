// plan_model.h - the models of a .plan file, and their placing in the building.
//
// All models of a file are objects of one extra building, `models`, each in its own frame. Concave faces are thus cut only once,
// however often a model is placed.
#ifndef MAPS_PLAN_MODEL_H
#define MAPS_PLAN_MODEL_H

#include "maps/building/building.h"
#include "maps/plan/plan_words.h"

// The placement of a model: mirrored in its own x if `mirror`, then turned by `angle` (radians) about z, then moved to `at`.
typedef struct PlanStand {
    Vec3 at;
    double angle;
    bool mirror;
} PlanStand;

// Read the statements inside `model ... end`, after their first word, and append to the last model.
bool plan_read_box(PlanLine *line, Building *models);
bool plan_read_prism(PlanLine *line, Building *models);
bool plan_read_cylinder(PlanLine *line, Building *models);
bool plan_read_poly(PlanLine *line, Building *models);
bool plan_read_model_light(PlanLine *line, Building *models);

// The same for curved shapes, which are exact where rays are traced.
bool plan_read_sphere(PlanLine *line, Building *models);
bool plan_read_ellipsoid(PlanLine *line, Building *models);
bool plan_read_cone(PlanLine *line, Building *models);
bool plan_read_lathe(PlanLine *line, Building *models);
bool plan_read_patch(PlanLine *line, Building *models);
bool plan_read_trim(PlanLine *line, Building *models);
bool plan_read_metaballs(PlanLine *line, Building *models);
bool plan_read_ball(PlanLine *line, Building *models);
// Call before a line that adds nothing to the open shape: the shape is checked and becomes polygons.
bool plan_close_shape(PlanLine *line, Building *models);
bool plan_light(PlanLine *line, const char *name, Light *out);  // x,y,z and options

// Appends a straight flight of solid steps to the last model: centred in plan, rising along +y.
void plan_add_stair(Arena *arena, Building *models, Vec3 size, int steps, int material);
// Appends one slope of the same size instead: four polygons.
void plan_add_ramp(Arena *arena, Building *models, Vec3 size, int material);

// Appends an object with the model's polygons, and its lights. Fails where the building grows too large.
bool plan_stand_model(PlanLine *line, Arena *arena, const Building *models, int model, const char *name,
                      PlanStand stand, Building *b);

#endif
