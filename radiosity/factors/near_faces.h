// near_faces.h - the shares of faces close by, mended to their closed forms.
#ifndef RADIOSITY_NEAR_FACES_H
#define RADIOSITY_NEAR_FACES_H

#include "radiosity/factors/row.h"

// Before row_finish: what near faces that nothing hides have of the sum becomes what Lambert's formula says, the rest shares
// the remainder as before. The row of a view remains the same whatever was culled of it.
void near_faces_mend(RowSum *sum, const View *view);

#endif
