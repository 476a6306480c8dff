// error_picture.h - how far the light that a walk shows is off, as a picture: what is seen through each pixel, against path tracing.
#ifndef APP_ERROR_PICTURE_H
#define APP_ERROR_PICTURE_H

#include "radiosity/shoot/shoot.h"
#include "visibility/hidden/hidden.h"

typedef struct ErrorPicture {
    const Mesh *mesh;
    const RadSolution *solution;
    uint64_t seed;
} ErrorPicture;

// Roots of mean squares over the pixels, percent.
typedef struct ErrorPictureFound {
    double rms, noise;  // of what is shown; of that, the standard error of the truth
} ErrorPictureFound;

// Writes DIR/NAME-error.png, and DIR/light-error-scale.svg, its legend. Pixels that show lamps, backs or nothing are grey.
bool error_picture(const ErrorPicture *errors, const Camera *camera, const char *folder, const char *name,
                   ErrorPictureFound *found, Error *error);

#endif
