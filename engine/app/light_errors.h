// light_errors.h - how far the light that a walk shows is off, as a picture: what is seen through each pixel, against path tracing.
#ifndef APP_LIGHT_ERRORS_H
#define APP_LIGHT_ERRORS_H

#include "radiosity/shoot.h"
#include "visibility/hidden/hidden.h"

typedef struct LightErrors {
    const Mesh *mesh;
    const RadSolution *solution;
    double error;  // of the truth, standard error of a pixel, relative
    uint64_t seed;
} LightErrors;

// Writes DIR/NAME-error.png, and DIR/light-error-scale.svg, its legend. Pixels that show lamps, backs or nothing are grey. `rms`: of the
// others, in percent.
bool light_errors_picture(const LightErrors *errors, const Camera *camera, const char *folder,
                          const char *name, double *rms, Error *error);

#endif
