// plan_file.h - a .plan file while it is read: the part that its statements share.
#ifndef MAPS_PLAN_FILE_H
#define MAPS_PLAN_FILE_H

#include "maps/building/sketch.h"
#include "maps/plan/plan_model.h"

enum { BLOCK_NONE, BLOCK_MODEL, BLOCK_TOUR };

typedef struct Plan {
    PlanLine line;
    Arena *arena;
    Building *b;
    Sketch sketch;
    PlanNames materials, storeys, model_names;  // index of a model: its object in `models`
    Building models;
    struct Stretch *stretches;  // of explicit walls; private to plan_statements.c
    int *opening_line;          // [sketch.opening_count] the lines of the openings, for messages
    int stretch_count, stretch_capacity, opening_line_count, opening_line_capacity;
    int storey;      // under which statements stand now
    int block;       // the block in which lines stand now
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

// ---- plan_statements.c
bool plan_read_storey(Plan *plan);
bool plan_read_material(Plan *plan);
bool plan_read_ground(Plan *plan);
bool plan_read_facade(Plan *plan);
bool plan_read_slabs(Plan *plan);
bool plan_read_stairwell(Plan *plan);
bool plan_read_stair(Plan *plan);
// Notes the stairs that stand as slopes, once all are read.
void plan_note_ramps(Plan *plan);
bool plan_read_light(Plan *plan);
bool plan_read_inlay(Plan *plan);
bool plan_read_place(Plan *plan);

bool plan_read_view(Plan *plan);
bool plan_read_tour(Plan *plan);
bool plan_read_tour_eye(Plan *plan);
bool plan_read_start(Plan *plan);
// Once the free space is known: the start that the file names replaces the one that maps_enclose chose.
bool plan_set_start(Plan *plan);

bool plan_read_room(Plan *plan);
bool plan_read_wall(Plan *plan);
bool plan_read_door(Plan *plan);
bool plan_read_passage(Plan *plan);
bool plan_read_window(Plan *plan);

// Once all rooms and walls are known: openings without a depth take that of the wall they stand in.
bool plan_fit_openings(Plan *plan);

#endif
