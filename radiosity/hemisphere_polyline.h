// hemisphere_polyline.h - the hemisphere base as printed, for comparison.
#ifndef RADIOSITY_HEMISPHERE_POLYLINE_H
#define RADIOSITY_HEMISPHERE_POLYLINE_H

#include "radiosity/form_factor.h"

extern const FormFactorMethod FORM_FACTOR_HEMISPHERE_POLYLINE;

#endif
