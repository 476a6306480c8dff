// light_errors.h - how far the light that a walk shows is off, as a picture: what is seen through each pixel, against path tracing.
#ifndef APP_LIGHT_ERRORS_H
#define APP_LIGHT_ERRORS_H

#include "radiosity/shoot.h"
#include "visibility/hidden/hidden.h"

typedef struct LightErrors {
    const Mesh *mesh;
    const RadSolution *solution;
    uint64_t seed;
} LightErrors;

// Roots of mean squares over the pixels, percent.
typedef struct LightErrorsFound {
    double rms, noise;  // of what is shown; of that, the standard error of the truth
} LightErrorsFound;

// Writes DIR/NAME-error.png, and DIR/light-error-scale.svg, its legend. Pixels that show lamps, backs or nothing are grey.
bool light_errors_picture(const LightErrors *errors, const Camera *camera, const char *folder,
                          const char *name, LightErrorsFound *found, Error *error);

#endif
