// plan_file.h - a .plan file while it is read: what its statements share.
#ifndef MAPS_PLAN_FILE_H
#define MAPS_PLAN_FILE_H

#include "maps/building/sketch.h"
#include "maps/plan/plan_model.h"

// Limits of the format, metres.
#define PLAN_MAX_HEIGHT 1000.0   // of storeys, walls, openings
#define PLAN_MAX_THICKNESS 10.0  // of walls and slabs
#define PLAN_MAX_OPENING 100.0   // width
#define PLAN_MIN_SIZE 0.01       // of all that must have a size

typedef enum Block { BLOCK_NONE, BLOCK_MODEL, BLOCK_TOUR } Block;

// A stretch of explicit wall, to fit openings into.
typedef struct Stretch {
    int storey;
    Vec2 a, b;
    double thickness;
} Stretch;

// What the file said of an opening beside the sketch: `line` for messages; `fit` when no depth was given.
typedef struct Pending {
    int line;
    bool fit;
} Pending;

typedef struct Plan {
    PlanLine line;
    Arena *arena;
    Building *b;
    Sketch sketch;
    PlanNames materials, storeys;
    PlanModels models;
    Stretch *stretches;
    Pending *pending;  // [sketch.opening_count]
    int stretch_count, stretch_capacity, pending_count, pending_capacity;
    int storey;  // under which statements stand now
    Block block;
    int block_line;  // where it began
    bool begun, ground;
    Vec3 start;
    double start_yaw;
    int start_line;      // 0: the file names no start
    int stair_polygons;  // of all flights so far
    int ramp_count;      // flights beyond their share of polygons: each is a slope
    Vec3 first_ramp;
    const char *first_ramp_place;
} Plan;

// `house.plan:12: door pantry`
const char *plan_place_text(Plan *plan, const char *what, const char *name);
double plan_storey_floor(const Plan *plan);
void plan_push_point(Plan *plan, Vec2 point, int material);  // into the sketch

double plan_signed_area(const Vec2 *points, int count);  // counter-clockwise positive

// ---- plan_statements.c
bool plan_read_storey(Plan *plan);
bool plan_read_material(Plan *plan);
bool plan_read_ground(Plan *plan);
bool plan_read_facade(Plan *plan);
bool plan_read_slabs(Plan *plan);
bool plan_read_stairwell(Plan *plan);
bool plan_read_stair(Plan *plan);
void plan_note_ramps(Plan *plan);  // of all stairs, at the end
bool plan_read_light(Plan *plan);
bool plan_read_inlay(Plan *plan);
bool plan_read_place(Plan *plan);

// ---- plan_views.c
bool plan_read_view(Plan *plan);
bool plan_read_tour(Plan *plan);
bool plan_read_tour_eye(Plan *plan);
bool plan_read_start(Plan *plan);
// Once all is read: what the file says goes before what maps_enclose chose.
bool plan_set_start(Plan *plan);

// ---- plan_walls.c
bool plan_read_room(Plan *plan);
bool plan_read_wall(Plan *plan);
bool plan_read_door(Plan *plan);
bool plan_read_passage(Plan *plan);
bool plan_read_window(Plan *plan);

// ---- plan_fit.c
// Once all rooms and walls are known: openings without a depth take that of the wall they stand in.
bool plan_fit_openings(Plan *plan);

#endif
