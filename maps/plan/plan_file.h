// plan_file.h - the state of reading a .plan file, which the functions that read its statements share.
#ifndef MAPS_PLAN_FILE_H
#define MAPS_PLAN_FILE_H

#include "maps/building/sketch.h"
#include "maps/plan/plan_model.h"
#include "maps/polygons/soup_readers.h"

enum { BLOCK_NONE, BLOCK_MODEL, BLOCK_TOUR };

// The texture of a material as stated.
typedef struct PlanPaper {
    const char *file;             // NULL: none
    double width, height, angle;  // metres, radians; height 0: as the picture's sides say
    Vec2 at;                      // metres to the right and up
} PlanPaper;

// A material with its picture laid on walls of one direction, or on floors, or ceilings.
typedef struct PlanLaid {
    int of, material;
} PlanLaid;

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
    int storey;      // of the statements now read
    int block;       // of the lines now read
    int block_line;  // the line on which the block began
    bool begun, ground;
    Vec3 start;
    double start_yaw;
    int start_line;      // 0: the file names no start
    int stair_polygons;  // of all flights so far
    int ramp_count;      // flights that became slopes, beyond their share of polygons
    Vec3 first_ramp;
    const char *first_ramp_place;
    SoupReader beside;             // pictures read
    double pixels;                 // that may still be decoded
    struct PlanPicture *pictures;  // private to plan_textures.c
    PlanLaid *laid;
    int picture_count, picture_capacity, laid_count, laid_capacity;
} Plan;

// ---- plan_textures.c
// Reads the picture of a material, and gives the material the picture's mean colour; one that cannot be read is noted and leaves the
// material as it is. Call plan_name_picture with the material's index then.
bool plan_add_picture(Plan *plan, const PlanPaper *paper, Material *material);
void plan_name_picture(Plan *plan, int material);
// Lays pictures on flat polygons without a map, from `first` on, in a grid that begins at height `floor`.
void plan_lay_on_polygons(Plan *plan, Building *of, int first, double floor);
// Lays pictures on all else, once all regions are known.
void plan_lay_textures(Plan *plan);

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
// Call once the free space is known: the start that the file names, if any, replaces the start that maps_enclose chose.
bool plan_set_start(Plan *plan);

bool plan_read_room(Plan *plan);
bool plan_read_wall(Plan *plan);
bool plan_read_door(Plan *plan);
bool plan_read_passage(Plan *plan);
bool plan_read_window(Plan *plan);

// Call once all rooms and walls are known: gives each opening without a depth the depth of the wall in which it stands.
bool plan_fit_openings(Plan *plan);

#endif
