// shoot_rows.h - the rows of the patches that shoot: made several at a time, kept as long as there is room.
#ifndef RADIOSITY_SHOOT_ROWS_H
#define RADIOSITY_SHOOT_ROWS_H

#include "radiosity/shoot/shoot.h"

// A patch's share of a row.
typedef struct ShootRun {
    int patch;
    float share;
} ShootRun;

// A row as it is stored: runs of elements of one patch, each with the numbers that a shot needs. Shares are floats: `scale` times
// their sum, `back` and `escaped` included, is 1 in doubles, so that no power is lost.
typedef struct ShootRow {
    int run_count, element_count;
    ShootRun *runs;   // [run_count] sorted by length, then by patch
    float *density;   // [element_count] share per area, 1/m^2; run after run
    uint8_t *count;   // [run_count] the number of elements in the run, less one
    uint8_t *offset;  // [element_count] the element's index in its patch
    double back, escaped, scale;
    double sky_light, ground_light;  // as in Row
    SkyPart *sky_part;               // [sky_part_count] whose light is `sky_light`; 0: not asked for
    int sky_part_count;
} ShootRow;

// `day`: whose sky the rows tell; it must outlive them, and may change where the rows know the parts of the sky (options->form_factor:
// shoot_rows_turn).
ShootRows *shoot_rows_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                          const RadOptions *options, const Daylight *day, Arena *arena);
void shoot_rows_end(ShootRows *rows);
// Frees what rows are made with, until the next one is made: for a part of a building that is to sleep (memory_in_file). The rows stay.
void shoot_rows_rest(ShootRows *rows);

// Chooses the patches whose rows have as many directions as those of lamps: those that reflect most light straight from lamps, sun and sky,
// for the light of their cell. Direct light must be complete in the solution. To be called before any patch but lamps gets a row; without
// the call no patch is strong.
void shoot_rows_find_strong(ShootRows *rows, const RadSolution *solution);
// Light was gathered along these rows: none is made anew with more directions from now on. And was it?
void shoot_rows_settle(ShootRows *rows);
bool shoot_rows_settled(const ShootRows *rows);
// [patch_count]
const bool *shoot_rows_strong(const ShootRows *rows);

// Does the row of a patch depend on a door that moves?
bool shoot_rows_depend(const ShootRows *rows, int patch, const MovedDoors *moved);
// Doors have moved: the mesh is posed already (mesh_move), and so is the caller's `door_open`. Drops the rows of patches that may see one
// of these doors, notes them in `dropped` [patch_count] (NULL: nowhere), and returns how many.
int shoot_rows_move(ShootRows *rows, const MovedDoors *moved, bool *dropped);

// The day that the rows tell has changed, in its place: the sun stands elsewhere. The rows stay, and tell the light of that sky. They are
// not settled any more: other patches may be strong.
void shoot_rows_turn(ShootRows *rows);

// From now on the rows are those of `closed`, which is the mesh with black panes more (panes_between_rooms): what they stand before is
// absorbed. Only Row.sky_light and ground_light of rows that are there stay as they are: nothing is to be gathered along them.
void shoot_rows_close(ShootRows *rows, const Mesh *closed);

// Drops the row of a patch, if it is there, unless it has as many directions as those of lamps: the next one has.
void shoot_rows_refine(ShootRows *rows, int patch);

// How many rows to make at a time, so that all threads have enough to do and the rows of neighbours are made together; never more
// than shoot_rows_most.
int shoot_rows_wanted(const ShootRows *rows);
int shoot_rows_most(const ShootRows *rows);
// [patch_count] for each patch, whether its row is stored.
const bool *shoot_rows_there(const ShootRows *rows);
// The row of a patch, NULL if it is not stored.
const ShootRow *shoot_rows_of(const ShootRows *rows, int patch);
// Makes the rows of `patches` [count], which have none yet, in parallel; count is at most shoot_rows_most, and `patches` gets
// sorted. A row that there is no room to keep stays until its patch has shot, or until too many rows wait for their shots.
void shoot_rows_make(ShootRows *rows, int *patches, int count);
// Tells that the patch has shot: its row is dropped unless it is kept.
void shoot_rows_shot(ShootRows *rows, int patch);

// Stores the work done so far in the fields of a report.
void shoot_rows_report(const ShootRows *rows, RadReport *report);

#endif
