// gather_rows.h - reflected light along rows: to whom a patch shoots along its row, these send to it along the same row (reciprocity).
#ifndef RADIOSITY_GATHER_ROWS_H
#define RADIOSITY_GATHER_ROWS_H

#include "radiosity/shoot/shoot_rows.h"

// Finds RadSolution.reflected of patches, and with it `sun`, `sent`, `strong`, `close` and `noise`, of light that is shot. Of light that
// goes on (`follow`, else NULL) at those patches alone whose light has changed. Rows that are not there are made; noisy patches get finer
// ones unless the rows are settled, which they are then. False where progress asked to stop.
bool gather_rows(const Mesh *mesh, ShootRows *rows, const RadOptions *options, RadFollow *follow,
                 const Progress *progress, RadSolution *solution);

#endif
