// near_faces.h - replaces the shares of faces close by with their closed forms.
#ifndef RADIOSITY_NEAR_FACES_H
#define RADIOSITY_NEAR_FACES_H

#include "radiosity/factors/row.h"

// Call before row_finish. Each near face that nothing hides gets the share that Lambert's formula gives; all other shares keep
// their proportions in the remainder. Culling does not change the result.
void near_faces_mend(RowSum *sum, const View *view);

#endif
