// shoot_rows.h - the rows of shooters: made several at a time, kept as long as there is room.
#ifndef RADIOSITY_SHOOT_ROWS_H
#define RADIOSITY_SHOOT_ROWS_H

#include "radiosity/shoot/shoot.h"

// A patch's share of a row.
typedef struct ShootRun {
    int patch;
    float share;
} ShootRun;

// A row as kept: in runs of elements of one patch, each with the numbers that a shot needs. Shares are floats: `scale` times their
// sum, back and escaped included, is 1 in doubles, so that no power is lost.
typedef struct ShootRow {
    int run_count, element_count;
    ShootRun *runs;   // [run_count] short ones first, then by patch
    float *density;   // [element_count] share per area, 1/m^2; run after run
    uint8_t *count;   // [run_count] elements that receive, less one
    uint8_t *offset;  // [element_count] which element of its patch
    double back, escaped, scale;
} ShootRow;

typedef struct ShootRows ShootRows;
ShootRows *shoot_rows_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                          const RadOptions *options, Arena *arena);
void shoot_rows_end(ShootRows *rows);

// How many to make at a time, so that all threads have enough to do, and neighbours are made together; never more than
// shoot_rows_most.
int shoot_rows_wanted(const ShootRows *rows);
int shoot_rows_most(const ShootRows *rows);
// [patch_count] which patches have a row here.
const bool *shoot_rows_there(const ShootRows *rows);
// The row of a patch, NULL if it is not there.
const ShootRow *shoot_rows_of(const ShootRows *rows, int patch);
// Makes the rows of patches that have none, at most as many as wanted, in parallel. Rows that could not be kept are there until they
// are shot, or very many wait.
void shoot_rows_make(ShootRows *rows, int *patches, int count);
// The row of a patch was shot: it goes unless it is kept.
void shoot_rows_shot(ShootRows *rows, int patch);

// The work so far, into the fields of a report.
void shoot_rows_report(const ShootRows *rows, RadReport *report);

#endif
