// error_picture.h - a picture of the errors of the light as shown, pixel by pixel, and its legend.
#ifndef BENCH_ERROR_PICTURE_H
#define BENCH_ERROR_PICTURE_H

#include "engine/core/camera.h"
#include "radiosity/shoot/shoot.h"

typedef struct ErrorPicture {
    const Mesh *mesh;
    const RadSolution *solution;
    uint64_t seed;
} ErrorPicture;

// Roots of mean squares over the pixels, percent.
typedef struct ErrorPictureFound {
    double rms, noise;  // of the shown light against the truth; of the standard error of the truth
} ErrorPictureFound;

// Writes DIR/NAME-error.png, and DIR/light-error-scale.svg, its legend. Pixels that show lamps, backs or nothing are grey.
bool error_picture(const ErrorPicture *picture, const Camera *camera, const char *folder, const char *name,
                   ErrorPictureFound *found, Error *error);

#endif
